//! Arrays from pickles of every flavour, and what is refused.

use crate::fixtures::{ARRAYS, BODY};
use crease::numpy::{Archive, Array, ReadError};

fn texts(values: &[&str]) -> Vec<String> {
    values.iter().map(ToString::to_string).collect()
}

#[test]
fn every_flavour_gives_the_same_arrays() {
    let matrix = vec![0.0, 0.25, 0.5, 0.75, 1.0, 1.25];
    let sparse = Array::new(&[2, 3], vec![0.0, 0.0, 0.25, 0.5, 0.75, 0.0]);
    let expected = [
        ("c_order", Array::new(&[2, 3], matrix.clone())),
        ("fortran", Array::new(&[2, 3], matrix.iter().map(|&x| x as f32).collect::<Vec<_>>())),
        ("big_endian", Array::new(&[3], vec![1i64, -2, 300])),
        ("truth", Array::new(&[2], vec![true, false])),
        ("text", Array::new(&[2], texts(&["pelvis", "hip"]))),
        ("byte_text", Array::new(&[2], texts(&["ab", "c"]))),
        ("empty", Array::new(&[0, 3], Vec::<f64>::new())),
        ("all_bytes", Array::new(&[256], (0..256).collect::<Vec<u64>>())),
        ("scalar", Array::new(&[], vec![1.5])),
        ("float", Array::new(&[], vec![2.5])),
        ("integer", Array::new(&[], vec![-7i64])),
        ("long", Array::new(&[], vec![1i64 << 40])),
        ("list", Array::new(&[3], vec![1i64, 2, 3])),
        ("name", Array::new(&[], texts(&["tee 'shirt'\\\n"]))),
        ("sparse_columns", sparse.clone()),
        ("sparse_rows", sparse),
        ("wrapped", Array::new(&[2, 3], matrix)),
        ("selected", Array::new(&[2, 2], vec![0.0, 0.25, 0.75, 1.0])),
    ];
    for (file, bytes) in ARRAYS {
        let mut archive = Archive::open(bytes, file).unwrap();
        for (name, array) in &expected {
            let field = archive.required(name).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(field.array(), array, "{file} {name}");
        }
        let error = archive.required("nothing").unwrap_err();
        assert_eq!((error.field.as_str(), error.found.as_str()), ("nothing", "None"));
        let error = archive.required("missing").unwrap_err();
        assert!(error.found.contains("c_order"), "{error}");
    }
}

fn open_error(bytes: &[u8]) -> ReadError {
    Archive::open(bytes, "test.pkl").map(|archive| archive.names()).expect_err("should be refused")
}

#[test]
fn classes_outside_the_list_are_refused_by_name() {
    for bytes in [
        b"(S'a'\ncos\nsystem\n(S'echo hello'\ntRs.".as_slice(),
        b"\x80\x02}U\x01acos\nsystem\nU\x04echo\x85Rs.",
        b"\x80\x04}\x8c\x01a\x8c\x02os\x8c\x06system\x93\x8c\x04echo\x85Rs.",
    ] {
        let error = open_error(bytes);
        assert_eq!(error.found, "the class os.system");
        assert_eq!(error.file, "test.pkl");
        assert!(error.field.starts_with("pickle byte "), "{error}");
    }
    // Instructions that name a class in other ways.
    for (opcode, bytes) in [
        ("0x69", b"(S'a'\n(ios\nsystem\n.".as_slice()),
        ("0x6f", b"((cnumpy\nndarray\no."),
        ("0x82", b"\x80\x02\x82\x01."),
        ("0x50", b"(Pname\n."),
        ("0x97", b"\x80\x05\x97."),
    ] {
        assert_eq!(open_error(bytes).found, opcode);
    }
    assert_eq!(open_error(b"(cnumpy\nload\n.").found, "the class numpy.load");
    assert_eq!(open_error(b"(c__builtin__\neval\n.").found, "the class __builtin__.eval");
}

#[test]
fn malformed_pickles_are_errors() {
    for (bytes, found) in [
        (b"".as_slice(), "the first bytes []"),
        (b"hello", "the first bytes [104, 101, 108, 108, 111]"),
        (b"\x80\x06}.", "protocol 6"),
        (b"\x80\x02].", "a sequence of 0"),
        (b"\x80\x02}", "0 before the end"),
        (b"\x80\x02.", "fewer"),
        (b"\x80\x02}(.", "fewer"),
        (b"\x80\x02}0.", "fewer"),
        (b"\x80\x02}t.", "none"),
        (b"\x80\x02}h\x05.", "nothing under 5"),
        (b"\x80\x02}(K\x01u.", "1 values in all"),
        (b"\x80\x02}K\x01a.", "a dictionary of 0"),
        (b"\x80\x02}K\x01b.", "a dictionary of 0"),
        (b"\x80\x02}K\x01)R.", "the number 1"),
        (b"\x80\x02}B\xff\xff\xff\xff.", "1 before the end"),
        (b"\x80\x04}\x8e\xff\xff\xff\xff\xff\xff\xff\xff.", "1 before the end"),
    ] {
        assert_eq!(open_error(bytes).found, found, "{bytes:?}");
    }
}

fn field_error(bytes: &[u8]) -> ReadError {
    let mut archive = Archive::open(bytes, "test.pkl").unwrap_or_else(|error| panic!("{error}"));
    archive.required("a").expect_err("should be refused")
}

#[test]
fn values_that_are_no_arrays_are_errors() {
    // A chumpy object that wraps itself.
    let error = field_error(b"\x80\x02}U\x01acchumpy.ch\nCh\n)\x81q\x00}U\x01xh\x00sbs.");
    assert!(error.found.contains("wrappers"), "{error}");
    // A list that holds itself.
    let error = field_error(b"\x80\x02}U\x01a]q\x00h\x00as.");
    assert_eq!(error.found, "a sequence of 1");
    // A dtype without its name, bytes that are their own argument.
    assert!(
        field_error(b"\x80\x02}U\x01acnumpy._core.multiarray\nscalar\ncnumpy\ndtype\n)RU\x01x\x86Rs.")
            .found
            .contains("Dtype")
    );
    let error =
        field_error(b"\x80\x02}U\x01acnumpy._core.multiarray\nscalar\ncnumpy\ndtype\nU\x02f8\x85RU\x01x\x86Rs.");
    assert_eq!(error.found, "1 bytes");
    assert_eq!(field_error(b"\x80\x02}U\x01a]K\x01aU\x01xas.").expected, "an array, or values of one kind");
    assert!(field_error(b"\x80\x02}U\x01acnumpy._core.multiarray\n_reconstruct\n)Rs.").found.contains("Reconstruct"));
}

#[test]
fn small_pickles_do_not_stand_for_huge_values() {
    // One long text, shared 100 000 times: as keys, and as a list.
    let shared = |start: &[u8], repeated: &[u8], end: &[u8]| {
        let text = [b"X\x00\x00\x01\x00".as_slice(), &[b'x'; 1 << 16], b"q\x000"].concat();
        [b"\x80\x02", text.as_slice(), start, &repeated.repeat(100_000), end].concat()
    };
    assert_eq!(open_error(&shared(b"}(", b"h\x00N", b"u.")).found, "100000");
    let error = field_error(&shared(b"}U\x01a](", b"h\x00", b"es."));
    assert_eq!(error.found, "the text \"xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx\"");
}

#[test]
fn sparse_matrices_are_checked() {
    let sparse = |shape: &[u8], indices: &[u8], starts: &[u8]| {
        let mut bytes = b"\x80\x02}U\x01acscipy.sparse.csr\ncsr_matrix\n)\x81}(U\x06_shape".to_vec();
        for (name, values) in [("", shape), ("U\x07indices", indices), ("U\x06indptr", starts)] {
            bytes.extend(name.as_bytes());
            bytes.push(b'(');
            values.iter().for_each(|&value| bytes.extend([b'K', value]));
            bytes.push(b't');
        }
        bytes.extend(b"U\x04data(K\x05K\x07tubs.");
        bytes
    };
    let read = |bytes: &[u8]| Archive::open(bytes, "test.pkl").unwrap().required("a");
    let array = read(&sparse(&[2, 2], &[1, 0], &[0, 1, 2])).unwrap().array().clone();
    assert_eq!(array, Array::new(&[2, 2], vec![0.0, 5.0, 7.0, 0.0]));
    for (shape, indices, starts, found) in [
        ([2, 2], [1, 2], vec![0, 1, 2], "an index beyond the shape"),
        ([2, 2], [1, 0], vec![0, 1], "indptr of another length than the shape"),
        ([2, 2], [1, 0], vec![0, 1, 3], "indptr beyond the data"),
        ([2, 2], [1, 0], vec![0, 2, 1], "indptr beyond the data"),
    ] {
        assert_eq!(read(&sparse(&shape, &indices, &starts)).unwrap_err().found, found);
    }
    let huge =
        b"\x80\x02}U\x01acscipy.sparse.csr\ncsr_matrix\n)\x81}U\x06_shapeJ\xff\xff\xff\x7fJ\xff\xff\xff\x7f\x86sbs.";
    assert_eq!(read(huge).unwrap_err().found, "shape [2147483647, 2147483647]");
}

#[test]
fn byte_strings_of_python_2_may_be_names() {
    let (file, bytes) = BODY;
    let names = Archive::open(bytes, file).unwrap().names();
    assert!(names.contains(&"J_regressor".to_owned()), "{names:?}");
}
