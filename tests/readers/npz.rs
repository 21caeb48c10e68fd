//! `.npz` archives, whole and wrong.

use crease::numpy::{Archive, Array, Compression, ReadError, write_npz};
use std::io::{Cursor, Write};
use zip::write::SimpleFileOptions;

#[test]
fn written_archives_come_back() {
    let arrays = [
        ("poses", Array::new(&[2, 2], vec![1.0f32, 2.0, 3.0, 4.0])),
        ("betas", Array::new(&[3], vec![0.1f64, 0.2, 0.3])),
        ("f", Array::new(&[1, 3], vec![0i64, 1, 2])),
        ("joint_names", Array::new(&[2], vec!["pelvis".to_owned(), "head".to_owned()])),
    ];
    let named: Vec<(&str, &Array)> = arrays.iter().map(|(name, array)| (*name, array)).collect();
    for compression in [Compression::Stored, Compression::Deflated] {
        let bytes = write_npz(&named, compression).unwrap();
        assert_eq!(bytes, write_npz(&named, compression).unwrap(), "the same bytes each time");
        let mut archive = Archive::open(&bytes, "test.npz").unwrap();
        assert_eq!(archive.names(), ["betas", "f", "joint_names", "poses"]);
        for (name, array) in &arrays {
            assert_eq!(archive.required(name).unwrap().array(), array);
        }
        assert!(archive.optional("trans").unwrap().is_none());
    }
    assert!(write_npz(&[("a", &arrays[0].1), ("a", &arrays[0].1)], Compression::Stored).is_err());
}

/// A zip archive with one entry of any content.
pub fn zip_with(name: &str, content: &[u8]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    zip.start_file(name, SimpleFileOptions::default().compression_method(zip::CompressionMethod::Deflated)).unwrap();
    zip.write_all(content).unwrap();
    zip.finish().unwrap().into_inner()
}

fn error_of(bytes: &[u8]) -> ReadError {
    Archive::open(bytes, "test.npz").and_then(|mut archive| archive.required("a")).expect_err("should be refused")
}

/// Overwrites the unpacked size in the local and the central header.
fn with_declared_size(mut bytes: Vec<u8>, size: u32) -> Vec<u8> {
    for (signature, offset) in [(b"PK\x03\x04", 22), (b"PK\x01\x02", 24)] {
        let header = bytes.windows(4).position(|window| window == signature).unwrap();
        bytes[header + offset..header + offset + 4].copy_from_slice(&size.to_le_bytes());
    }
    bytes
}

#[test]
fn wrong_sizes_are_errors() {
    let mut npy = b"\x93NUMPY\x01\x00\x42\x00".to_vec();
    npy.extend(format!("{:<66}", "{'descr': '|u1', 'fortran_order': False, 'shape': (3,), }").bytes());
    npy.extend([1, 2, 3]);
    let whole = zip_with("a.npy", &npy);
    let field = Archive::open(&whole, "test.npz").unwrap().required("a").unwrap();
    assert_eq!(field.array(), &Array::new(&[3], vec![1u64, 2, 3]));

    let size = npy.len() as u32;
    for false_size in [size - 1, size + 1, 1 << 20] {
        let error = error_of(&with_declared_size(whole.clone(), false_size));
        assert_eq!(error.field, "a", "{error}");
    }
    let error = error_of(&with_declared_size(whole, 0xf000_0000));
    assert_eq!((error.field.as_str(), error.found.as_str()), ("a", "4026531840 bytes declared"));

    npy.pop();
    assert_eq!(error_of(&zip_with("a.npy", &npy)).found, "2 bytes");
}

#[test]
fn entries_that_are_no_arrays_are_errors() {
    assert!(error_of(&zip_with("b.npy", b"")).found.contains("only b"));
    assert!(error_of(&zip_with("a.txt", b"")).found.contains("nothing"));
    assert_eq!(error_of(&zip_with("a.npy", b"hello")).field, "a");
    assert_eq!(error_of(b"PK\x03\x04").field, "archive");
}

/// A stored archive of `a.npy` and `b.npy`, one number each, after `change`.
fn changed(change: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let array = Array::new(&[1], vec![1.5f32]);
    let mut bytes = write_npz(&[("a", &array), ("b", &array)], Compression::Stored).unwrap();
    change(&mut bytes);
    bytes
}

fn replace(bytes: &mut [u8], old: &[u8], new: &[u8]) {
    let places: Vec<usize> = (0..bytes.len()).filter(|&at| bytes[at..].starts_with(old)).collect();
    assert!(!places.is_empty());
    places.iter().for_each(|&at| bytes[at..at + new.len()].copy_from_slice(new));
}

#[test]
fn two_entries_of_one_name_are_an_error() {
    assert!(Archive::open(&changed(|_| ()), "test.npz").is_ok());
    let error = error_of(&changed(|bytes| replace(bytes, b"b.npy", b"a.npy")));
    assert_eq!((error.field.as_str(), error.found.as_str()), ("archive", "two of \"a.npy\""));
}

#[test]
fn a_checksum_that_does_not_fit_is_an_error() {
    let error = error_of(&changed(|bytes| replace(bytes, &1.5f32.to_le_bytes(), &1.25f32.to_le_bytes())));
    assert!(error.field == "a" && error.expected.starts_with("the checksum"), "{error}");
}

#[test]
fn unknown_methods_and_encryption_are_errors() {
    // The central directory's first entry: flags at 8, method at 10.
    let central = |bytes: &[u8]| bytes.windows(4).position(|window| window == b"PK\x01\x02").unwrap();
    let error = error_of(&changed(|bytes| {
        let at = central(bytes);
        bytes[at + 10] = 12;
    }));
    assert_eq!((error.field.as_str(), error.found.as_str()), ("a", "method 12"));
    let error = error_of(&changed(|bytes| {
        let at = central(bytes);
        bytes[at + 8] |= 1;
    }));
    assert_eq!((error.field.as_str(), error.found.as_str()), ("a", "an encrypted one"));
}
