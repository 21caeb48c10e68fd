//! Named arrays in a file of either kind, `.npz` or pickle, and the checks that readers of such files share.

use super::npz::Npz;
use super::pickle::Pickle;
use super::{Array, Place, ReadError};
use crate::memory::{Allowance, MemoryLimit};

/// What is made of an element and kept: a third of a vector of 16 bytes, for most.
const KEPT_BYTES: usize = 6;

/// An open `.npz` or pickle.
pub struct Archive<'a> {
    file: String,
    allowance: Allowance,
    kind: Kind<'a>,
}

enum Kind<'a> {
    Npz(Npz<'a>),
    Pickle(Pickle<'a>),
}

impl<'a> Archive<'a> {
    /// Opens a `.npz` or a pickled dictionary, told apart by the first bytes; `file` is the name for messages.
    ///
    /// # Errors
    /// If it is neither, cut short, or a pickle with a class other than those that carry arrays; where it, or an array that is read later,
    /// would take more memory than the default [`MemoryLimit`].
    pub fn open(bytes: &'a [u8], file: &str) -> Result<Self, ReadError> {
        Self::open_within(bytes, file, MemoryLimit::default())
    }

    /// [`Self::open`] with another limit.
    pub fn open_within(bytes: &'a [u8], file: &str, limit: MemoryLimit) -> Result<Self, ReadError> {
        let allowance = Allowance::new(limit, bytes.len());
        let kind = match bytes {
            [b'P', b'K', 3, 4, ..] | [b'P', b'K', 5, 6, ..] => Kind::Npz(Npz::open(bytes, file)?),
            // PROTO from protocol 2 on; before, a pickled dictionary starts with MARK or EMPTY_DICT.
            [0x80 | b'(' | b'}', ..] => Kind::Pickle(Pickle::open(bytes, file, &allowance)?),
            _ => {
                let found = format!("the first bytes {:?}", &bytes[..bytes.len().min(8)]);
                let place = Place { file, field: "byte 0" };
                return Err(place.error("a .npz archive or a pickled dictionary", found));
            }
        };
        Ok(Self { file: file.to_owned(), allowance, kind })
    }

    /// Names of everything inside.
    pub fn names(&self) -> Vec<String> {
        match &self.kind {
            Kind::Npz(npz) => npz.names(),
            Kind::Pickle(pickle) => pickle.names(),
        }
    }

    /// Reads a field that may be missing.
    pub fn optional(&mut self, name: &str) -> Result<Option<Field>, ReadError> {
        let array = match &mut self.kind {
            Kind::Npz(npz) => npz.array(name, &self.allowance)?,
            Kind::Pickle(pickle) => pickle.array(name, &self.allowance)?,
        };
        if let Some(array) = &array {
            let place = Place { file: &self.file, field: name };
            self.allowance.hold(KEPT_BYTES * array.elements.len()).map_err(|shortage| place.short(shortage))?;
        }
        Ok(array.map(|array| Field { file: self.file.clone(), name: name.to_owned(), array }))
    }

    /// Reads a field; an error if it is missing.
    pub fn required(&mut self, name: &str) -> Result<Field, ReadError> {
        self.optional(name)?.ok_or_else(|| self.missing(name))
    }

    /// The error that says that a field is missing and which there are.
    pub fn missing(&self, name: &str) -> ReadError {
        let names = self.names();
        let listed = names.iter().take(20).map(String::as_str).collect::<Vec<_>>().join(", ");
        let found = if names.is_empty() { "nothing".to_owned() } else { format!("only {listed}") };
        Place { file: &self.file, field: name }.error("an array of this name", found)
    }
}

/// An array that knows its file and name, for errors.
#[derive(Clone, Debug)]
pub struct Field {
    file: String,
    name: String,
    array: Array,
}

impl Field {
    /// An error about this field.
    pub fn error(&self, expected: impl Into<String>, found: impl Into<String>) -> ReadError {
        Place { file: &self.file, field: &self.name }.error(expected, found)
    }

    /// The array itself.
    pub fn array(&self) -> &Array {
        &self.array
    }

    /// The name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Length of each dimension.
    pub fn shape(&self) -> &[usize] {
        &self.array.shape
    }

    /// The error that says which shape it should have, such as `"(V, 3)"`.
    pub fn wrong_shape(&self, expected: impl std::fmt::Display) -> ReadError {
        self.error(format!("shape {expected}"), format!("shape {:?}", self.shape()))
    }

    /// The number of rows, if every row has `width` numbers.
    pub fn rows_of(&self, width: usize) -> Result<usize, ReadError> {
        match *self.shape() {
            [rows, columns] if columns == width => Ok(rows),
            _ => Err(self.wrong_shape(format_args!("(N, {width})"))),
        }
    }

    /// Checks the shape.
    pub fn expect_shape(&self, shape: &[usize]) -> Result<(), ReadError> {
        if self.shape() == shape { Ok(()) } else { Err(self.wrong_shape(format_args!("{shape:?}"))) }
    }

    /// The numbers, in C order; an error where one is not finite as a 32-bit float.
    pub fn finite_numbers(&self) -> Result<Vec<f32>, ReadError> {
        let numbers = self.array.to_f32().ok_or_else(|| self.error("numbers", "text"))?;
        match numbers.iter().position(|x| !x.is_finite()) {
            None => Ok(numbers),
            Some(at) => Err(self.error("finite 32-bit numbers", format!("{} at {:?}", numbers[at], self.index_of(at)))),
        }
    }

    /// The one number of a field that has only one.
    pub fn single_number(&self) -> Result<f32, ReadError> {
        match self.finite_numbers()?[..] {
            [number] => Ok(number),
            _ => Err(self.wrong_shape("() or (1,)")),
        }
    }

    /// Whole numbers, in C order.
    pub fn integers(&self) -> Result<Vec<i64>, ReadError> {
        self.array.to_i64().ok_or_else(|| self.error("whole numbers of 64 bits", "others"))
    }

    /// Indices below `limit`, in C order; `limited_by` says what they count.
    pub fn indices(&self, limit: usize, limited_by: &str) -> Result<Vec<u32>, ReadError> {
        let indices = self.integers()?;
        let checked = indices.iter().enumerate().map(|(at, &index)| {
            u32::try_from(index).ok().filter(|&index| (index as usize) < limit).ok_or_else(|| {
                let expected = format!("indices from 0 to {} ({limited_by})", limit.saturating_sub(1));
                self.error(expected, format!("{index} at {:?}", self.index_of(at)))
            })
        });
        checked.collect()
    }

    /// The strings, in C order.
    pub fn texts(&self) -> Result<&[String], ReadError> {
        self.array.to_text().ok_or_else(|| self.error("text", "numbers"))
    }

    /// Index along each dimension of the element at position `at` in C order.
    fn index_of(&self, mut at: usize) -> Vec<usize> {
        let mut index = vec![0; self.shape().len()];
        for (axis, &length) in self.shape().iter().enumerate().rev() {
            index[axis] = at % length.max(1);
            at /= length.max(1);
        }
        index
    }
}
