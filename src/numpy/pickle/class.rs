//! The classes and functions that a pickle may name. All others are refused.

/// What a name in a pickle stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Class {
    /// `numpy.ndarray`: only ever an argument of [`Class::Reconstruct`].
    NdArray,
    /// `numpy.dtype(name, align, copy)`; its state holds the byte order.
    Dtype,
    /// `_reconstruct(ndarray, (0,), b'b')`: an empty array; its state holds shape, type and bytes.
    Reconstruct,
    /// `_frombuffer(bytes, dtype, shape, order)`: an array, protocol 5.
    FromBuffer,
    /// `scalar(dtype, bytes)`: a single number.
    Scalar,
    /// `_codecs.encode(text, 'latin1')`: bytes, before protocol 3.
    Encode,
    /// `bytes()` or `bytearray(bytes)`.
    Bytes,
    /// Compressed sparse columns.
    SparseColumns,
    /// Compressed sparse rows.
    SparseRows,
    /// `chumpy.ch.Ch`: an array in the state's `x`.
    Chumpy,
    /// `chumpy.reordering.Select`: elements `idxs` of the state's `a`.
    ChumpySelect,
    /// `copyreg._reconstructor(class, object, None)`: an object, before protocol 2.
    Reconstructor,
    /// A dictionary that keeps its order.
    Dictionary,
    /// Other builtins that turn up beside arrays and carry none.
    Other,
}

impl Class {
    /// By module and name, in the spellings of Python 2 and 3, numpy 1 and 2, old and new scipy.
    pub(super) fn named(module: &str, name: &str) -> Option<Self> {
        Some(match (module, name) {
            ("numpy", "ndarray") => Self::NdArray,
            ("numpy", "dtype") => Self::Dtype,
            ("numpy.core.multiarray" | "numpy._core.multiarray", "_reconstruct") => Self::Reconstruct,
            ("numpy.core.multiarray" | "numpy._core.multiarray", "scalar") => Self::Scalar,
            ("numpy.core.numeric" | "numpy._core.numeric", "_frombuffer") => Self::FromBuffer,
            ("_codecs", "encode") => Self::Encode,
            ("__builtin__" | "builtins", "bytes" | "bytearray") => Self::Bytes,
            ("scipy.sparse.csc" | "scipy.sparse._csc", "csc_matrix" | "csc_array") => Self::SparseColumns,
            ("scipy.sparse.csr" | "scipy.sparse._csr", "csr_matrix" | "csr_array") => Self::SparseRows,
            ("chumpy.ch", "Ch") => Self::Chumpy,
            ("chumpy.reordering", "Select") => Self::ChumpySelect,
            ("copy_reg" | "copyreg", "_reconstructor") => Self::Reconstructor,
            ("collections", "OrderedDict") => Self::Dictionary,
            ("__builtin__" | "builtins", "object" | "set" | "frozenset" | "list" | "dict" | "slice") => Self::Other,
            _ => return None,
        })
    }
}
