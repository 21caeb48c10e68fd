//! The `.npy` format, versions 1 to 3: magic, version, header length, a Python dictionary as text, raw elements.
//! Source: numpy's `numpy.lib.format`.

use super::element_type::ElementType;
use super::{Array, Elements, Place, ReadError};
use crate::memory::Allowance;
use std::io::Write;

const MAGIC: &[u8] = b"\x93NUMPY";

/// Reads one array.
pub(super) fn read(bytes: &[u8], allowance: &Allowance, place: Place) -> Result<Array, ReadError> {
    let (header, data) = split(bytes, place)?;
    let header = std::str::from_utf8(header).map_err(|_| place.error("a header in UTF-8", "other bytes"))?;
    let header = Header::parse(header).ok_or_else(|| {
        let shown: String = header.trim_end().chars().take(120).collect();
        place.error("a header with descr, fortran_order and shape", format!("{shown:?}"))
    })?;
    let element_type = ElementType::parse(header.element_type, place)?;
    element_type.decode(data, &header.shape, header.fortran_order, allowance, place)
}

/// Header text and raw elements.
fn split<'a>(bytes: &'a [u8], place: Place) -> Result<(&'a [u8], &'a [u8]), ReadError> {
    let cut_short = || place.error("a numpy header", format!("{} bytes", bytes.len()));
    let rest = bytes.strip_prefix(MAGIC).ok_or_else(|| {
        place.error("the first bytes \\x93NUMPY", format!("{:?}", &bytes[..bytes.len().min(MAGIC.len())]))
    })?;
    let (&[version, _], rest) = rest.split_first_chunk::<2>().ok_or_else(cut_short)?;
    let (length, rest) = match version {
        1 => {
            let (length, rest) = rest.split_first_chunk::<2>().ok_or_else(cut_short)?;
            (usize::from(u16::from_le_bytes(*length)), rest)
        }
        2 | 3 => {
            let (length, rest) = rest.split_first_chunk::<4>().ok_or_else(cut_short)?;
            (u32::from_le_bytes(*length) as usize, rest)
        }
        other => {
            return Err(place.error("version 1, 2 or 3 of the npy format", format!("version {other}")));
        }
    };
    rest.split_at_checked(length).ok_or_else(cut_short)
}

struct Header<'a> {
    element_type: &'a str,
    fortran_order: bool,
    shape: Vec<usize>,
}

impl<'a> Header<'a> {
    /// Parses `{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }`.
    fn parse(text: &'a str) -> Option<Self> {
        let (mut element_type, mut fortran_order, mut shape) = (None, None, None);
        let mut rest = text.trim().strip_prefix('{')?.strip_suffix('}')?.trim();
        while !rest.is_empty() {
            let (key, after) = quoted(rest)?;
            let after = after.trim_start().strip_prefix(':')?.trim_start();
            rest = match key {
                "descr" => {
                    let (value, after) = quoted(after)?;
                    element_type = Some(value);
                    after
                }
                "fortran_order" => {
                    let (value, after) = match after.strip_prefix("True") {
                        Some(after) => (true, after),
                        None => (false, after.strip_prefix("False")?),
                    };
                    fortran_order = Some(value);
                    after
                }
                "shape" => {
                    let (inside, after) = after.strip_prefix('(')?.split_once(')')?;
                    shape = Some(lengths(inside)?);
                    after
                }
                _ => return None,
            };
            rest = rest.trim_start();
            rest = rest.strip_prefix(',').unwrap_or(rest).trim_start();
        }
        Some(Self { element_type: element_type?, fortran_order: fortran_order?, shape: shape? })
    }
}

/// A string in single or double quotes at the start of `text`, and what follows.
fn quoted(text: &str) -> Option<(&str, &str)> {
    let quote = text.chars().next().filter(|c| matches!(c, '\'' | '"'))?;
    text[1..].split_once(quote)
}

/// Comma-separated lengths; Python 2 marks long ones with an L.
fn lengths(text: &str) -> Option<Vec<usize>> {
    text.split(',')
        .map(str::trim)
        .filter(|part| !part.is_empty())
        .map(|part| part.strip_suffix('L').unwrap_or(part).parse().ok())
        .collect()
}

/// Writes one array, version 1, little endian, C order.
pub(super) fn write(array: &Array, out: &mut impl Write) -> std::io::Result<()> {
    let element_type = match &array.elements {
        Elements::F32(_) => "<f4".to_owned(),
        Elements::F64(_) => "<f8".to_owned(),
        Elements::I64(_) => "<i8".to_owned(),
        Elements::U64(_) => "<u8".to_owned(),
        Elements::Bool(_) => "|b1".to_owned(),
        Elements::Text(values) => format!("<U{}", character_width(values)),
    };
    let mut shape = array.shape.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    if array.shape.len() == 1 {
        shape.push(',');
    }
    let mut header = format!("{{'descr': '{element_type}', 'fortran_order': False, 'shape': ({shape}), }}");
    // Elements start at a multiple of 64 bytes; the header ends in a line feed.
    let unpadded = MAGIC.len() + 4 + header.len() + 1;
    header.push_str(&" ".repeat(unpadded.next_multiple_of(64) - unpadded));
    header.push('\n');
    let length = u16::try_from(header.len()).map_err(std::io::Error::other)?;
    out.write_all(MAGIC)?;
    out.write_all(&[1, 0])?;
    out.write_all(&length.to_le_bytes())?;
    out.write_all(header.as_bytes())?;
    match &array.elements {
        Elements::F32(values) => values.iter().try_for_each(|x| out.write_all(&x.to_le_bytes())),
        Elements::F64(values) => values.iter().try_for_each(|x| out.write_all(&x.to_le_bytes())),
        Elements::I64(values) => values.iter().try_for_each(|x| out.write_all(&x.to_le_bytes())),
        Elements::U64(values) => values.iter().try_for_each(|x| out.write_all(&x.to_le_bytes())),
        Elements::Bool(values) => values.iter().try_for_each(|&x| out.write_all(&[u8::from(x)])),
        Elements::Text(values) => {
            let width = character_width(values);
            values.iter().try_for_each(|text| {
                let padded = text.chars().map(u32::from).chain(std::iter::repeat(0)).take(width);
                padded.into_iter().try_for_each(|code| out.write_all(&code.to_le_bytes()))
            })
        }
    }
}

/// Characters of the longest text, at least one.
fn character_width(values: &[String]) -> usize {
    values.iter().map(|text| text.chars().count()).max().unwrap_or(0).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::MemoryLimit;

    const PLACE: Place = Place { file: "test.npz", field: "array" };

    fn read_whole(bytes: &[u8]) -> Result<Array, ReadError> {
        read(bytes, &Allowance::new(MemoryLimit::default(), bytes.len()), PLACE)
    }

    fn npy(version: u8, header: &str, data: &[u8]) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend([version, 0]);
        match version {
            1 => bytes.extend((header.len() as u16).to_le_bytes()),
            _ => bytes.extend((header.len() as u32).to_le_bytes()),
        }
        bytes.extend(header.as_bytes());
        bytes.extend(data);
        bytes
    }

    #[test]
    fn versions_one_to_three() {
        let header = "{'descr': '|u1', 'fortran_order': False, 'shape': (2L,), }   \n";
        for version in 1..=3 {
            let array = read_whole(&npy(version, header, &[7, 8])).unwrap();
            assert_eq!(array, Array::new(&[2], vec![7u64, 8]));
        }
        assert_eq!(read_whole(&npy(4, header, &[7, 8])).unwrap_err().found, "version 4");
    }

    #[test]
    fn every_element_type_comes_back() {
        for array in [
            Array::new(&[2, 3], vec![1.0f32, -2.0, 3.5, f32::MAX, 0.0, 1e-9]),
            Array::new(&[0, 3], Vec::<f32>::new()),
            Array::new(&[], vec![std::f64::consts::PI]),
            Array::new(&[2], vec![i64::MIN, i64::MAX]),
            Array::new(&[1, 1, 1], vec![u64::MAX]),
            Array::new(&[2], vec![true, false]),
            Array::new(&[2], vec!["pelvis".to_owned(), "größe".to_owned()]),
        ] {
            let mut bytes = Vec::new();
            write(&array, &mut bytes).unwrap();
            assert_eq!(read_whole(&bytes).unwrap(), array);
            let header_length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
            assert_eq!((10 + header_length) % 64, 0, "elements are aligned");
        }
    }

    #[test]
    fn broken_headers_are_errors() {
        for header in [
            "",
            "{",
            "{}",
            "{'descr': '<f4'}",
            "{'descr': '<f4', 'fortran_order': Perhaps, 'shape': (1,)}",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (-1,)}",
            "{'descr': [('x', '<f4')], 'fortran_order': False, 'shape': (1,)}",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (1,), 'more': 1}",
        ] {
            let error = read_whole(&npy(1, header, &[0; 4])).unwrap_err();
            assert_eq!(error.expected, "a header with descr, fortran_order and shape", "{header}");
        }
        assert!(read_whole(b"\x93NUMPY\x01\x00\xff\xff{").is_err());
        assert!(read_whole(b"PK").is_err());
    }
}
