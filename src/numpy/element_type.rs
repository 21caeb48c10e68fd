//! numpy's element types (`<f4`, `|u1`, `>i8`, `<U14`) and the decoding of raw bytes.

use super::{Array, DIMENSION_LIMIT, ELEMENT_LIMIT, Elements, Place, ReadError};
use crate::memory::Allowance;
use half::f16;

/// Texts that one array may have: each takes memory of its own, even an empty one.
const TEXT_LIMIT: usize = 1 << 16;

/// Bytes of the widest number.
const DECODED_SIZE: usize = 8;

/// How one element is laid out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ElementType {
    kind: Kind,
    byte_count: usize,
    big_endian: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Float,
    Signed,
    Unsigned,
    Bool,
    ByteText,
    UnicodeText,
}

impl ElementType {
    /// From numpy's name: byte order (`<`, `>`, `=`, `|`, or none for little endian), kind, size.
    pub(super) fn parse(name: &str, place: Place) -> Result<Self, ReadError> {
        Self::from_name(name).ok_or_else(|| {
            place.error(
                "elements of type f2, f4, f8, i1-i8, u1-u8, b1, S or U",
                format!("{:?}", name.chars().take(40).collect::<String>()),
            )
        })
    }

    fn from_name(name: &str) -> Option<Self> {
        let big_endian = name.starts_with('>');
        let name = name.strip_prefix(['<', '>', '=', '|']).unwrap_or(name);
        let size: usize = name.get(1..)?.parse().ok()?;
        let (kind, byte_count) = match (name.as_bytes().first()?, size) {
            (b'f', 2 | 4 | 8) => (Kind::Float, size),
            (b'i', 1 | 2 | 4 | 8) => (Kind::Signed, size),
            (b'u', 1 | 2 | 4 | 8) => (Kind::Unsigned, size),
            (b'b', 1) => (Kind::Bool, 1),
            (b'S' | b'a', _) => (Kind::ByteText, size),
            (b'U', _) => (Kind::UnicodeText, size.checked_mul(4)?),
            _ => return None,
        };
        Some(Self { kind, byte_count, big_endian })
    }

    /// Bytes of a decoded element.
    fn decoded_size(&self) -> usize {
        match self.kind {
            Kind::Float if self.byte_count < 8 => 4,
            Kind::Bool => 1,
            // Every character may take three bytes.
            Kind::ByteText | Kind::UnicodeText => size_of::<String>() + 3 * self.byte_count,
            _ => DECODED_SIZE,
        }
    }

    /// The same type in the byte order that a pickle states apart from the name.
    pub(super) fn with_byte_order(self, order: &str) -> Self {
        Self { big_endian: order == ">", ..self }
    }

    /// How many elements a shape has; an error beyond the limits.
    fn element_count(&self, shape: &[usize], place: Place) -> Result<usize, ReadError> {
        let limit = match self.kind {
            Kind::ByteText | Kind::UnicodeText => TEXT_LIMIT,
            _ => ELEMENT_LIMIT,
        };
        (shape.len() <= DIMENSION_LIMIT)
            .then(|| shape.iter().try_fold(1usize, |count, &length| count.checked_mul(length)))
            .flatten()
            .filter(|&count| count <= limit)
            .ok_or_else(|| {
                let expected = format!("at most {limit} elements in {DIMENSION_LIMIT} dimensions");
                place.error(expected, format!("shape {shape:?}"))
            })
    }

    /// Decodes exactly the elements of `shape`, in C order or `fortran_order` (first index fastest).
    pub(super) fn decode(
        &self,
        bytes: &[u8],
        shape: &[usize],
        fortran_order: bool,
        allowance: &Allowance,
        place: Place,
    ) -> Result<Array, ReadError> {
        let count = self.element_count(shape, place)?;
        if count.checked_mul(self.byte_count) != Some(bytes.len()) {
            let expected = format!("{count} elements of {} bytes for shape {shape:?}", self.byte_count);
            return Err(place.error(expected, format!("{} bytes", bytes.len())));
        }
        // The bytes, the elements, and what is made of them next or, in Fortran's order, their copy.
        let element_size = self.decoded_size() + DECODED_SIZE;
        allowance
            .afford(bytes.len().saturating_add(count.saturating_mul(element_size)))
            .map_err(|shortage| place.short(shortage))?;
        let order = Order { shape, fortran_order };
        let big = self.big_endian;
        let elements = match (self.kind, self.byte_count) {
            (Kind::Float, 2) => order.apply(words(bytes, big, |w| f16::from_le_bytes(w).to_f32())),
            (Kind::Float, 4) => order.apply(words(bytes, big, f32::from_le_bytes)),
            (Kind::Float, _) => order.apply(words(bytes, big, f64::from_le_bytes)),
            (Kind::Signed, 1) => order.apply(words(bytes, big, |w| i64::from(i8::from_le_bytes(w)))),
            (Kind::Signed, 2) => order.apply(words(bytes, big, |w| i64::from(i16::from_le_bytes(w)))),
            (Kind::Signed, 4) => order.apply(words(bytes, big, |w| i64::from(i32::from_le_bytes(w)))),
            (Kind::Signed, _) => order.apply(words(bytes, big, i64::from_le_bytes)),
            (Kind::Unsigned, 1) => order.apply(words(bytes, big, |w| u64::from(u8::from_le_bytes(w)))),
            (Kind::Unsigned, 2) => order.apply(words(bytes, big, |w| u64::from(u16::from_le_bytes(w)))),
            (Kind::Unsigned, 4) => order.apply(words(bytes, big, |w| u64::from(u32::from_le_bytes(w)))),
            (Kind::Unsigned, _) => order.apply(words(bytes, big, u64::from_le_bytes)),
            (Kind::Bool, _) => order.apply(bytes.iter().map(|&b| b != 0).collect::<Vec<_>>()),
            (Kind::ByteText | Kind::UnicodeText, 0) => order.apply(vec![String::new(); count]),
            (Kind::ByteText, size) => order.apply(bytes.chunks_exact(size).map(latin1).collect::<Vec<_>>()),
            (Kind::UnicodeText, size) => {
                order.apply(bytes.chunks_exact(size).map(|chunk| utf32(chunk, big)).collect::<Vec<_>>())
            }
        };
        Ok(Array { shape: shape.to_vec(), elements })
    }
}

/// Splits into words of `N` bytes and decodes each from little endian.
fn words<const N: usize, T>(bytes: &[u8], big_endian: bool, from_le_bytes: impl Fn([u8; N]) -> T) -> Vec<T> {
    let (words, _) = bytes.as_chunks::<N>();
    words
        .iter()
        .map(|&word| {
            let mut word = word;
            if big_endian {
                word.reverse();
            }
            from_le_bytes(word)
        })
        .collect()
}

/// A byte string, without the zeros that numpy pads with.
fn latin1(bytes: &[u8]) -> String {
    let text: String = bytes.iter().map(|&byte| char::from(byte)).collect();
    text.trim_end_matches('\0').to_owned()
}

/// A unicode string of four bytes a character, without the zeros that numpy pads with.
fn utf32(bytes: &[u8], big_endian: bool) -> String {
    let text: String = words(bytes, big_endian, u32::from_le_bytes)
        .into_iter()
        .map(|code| char::from_u32(code).unwrap_or(char::REPLACEMENT_CHARACTER))
        .collect();
    text.trim_end_matches('\0').to_owned()
}

/// Order of elements in a file.
struct Order<'a> {
    shape: &'a [usize],
    fortran_order: bool,
}

impl Order<'_> {
    /// Puts values into C order.
    fn apply<T: Clone>(&self, values: Vec<T>) -> Elements
    where
        Elements: From<Vec<T>>,
    {
        if !self.fortran_order || self.shape.len() < 2 || values.is_empty() {
            return values.into();
        }
        let mut strides = vec![1; self.shape.len()];
        for axis in 1..self.shape.len() {
            strides[axis] = strides[axis - 1] * self.shape[axis - 1];
        }
        let mut index = vec![0; self.shape.len()];
        let mut source = 0;
        let mut ordered = Vec::with_capacity(values.len());
        for _ in 0..values.len() {
            ordered.push(values[source].clone());
            for axis in (0..index.len()).rev() {
                index[axis] += 1;
                source += strides[axis];
                if index[axis] < self.shape[axis] {
                    break;
                }
                index[axis] = 0;
                source -= strides[axis] * self.shape[axis];
            }
        }
        ordered.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::MemoryLimit;

    const PLACE: Place = Place { file: "test.npy", field: "array" };

    fn allowance() -> Allowance {
        Allowance::new(MemoryLimit::default(), 0)
    }

    fn decode(name: &str, bytes: &[u8], shape: &[usize]) -> Result<Array, ReadError> {
        ElementType::parse(name, PLACE)?.decode(bytes, shape, false, &allowance(), PLACE)
    }

    #[test]
    fn both_byte_orders() {
        assert_eq!(decode("<f4", &1.5f32.to_le_bytes(), &[]).unwrap(), Array::new(&[], vec![1.5f32]));
        assert_eq!(decode(">f4", &1.5f32.to_be_bytes(), &[]).unwrap(), Array::new(&[], vec![1.5f32]));
        assert_eq!(decode(">i2", &(-7i16).to_be_bytes(), &[1]).unwrap(), Array::new(&[1], vec![-7i64]));
        assert_eq!(decode("<u8", &[255; 8], &[1]).unwrap(), Array::new(&[1], vec![u64::MAX]));
        assert_eq!(decode("|i1", &[255], &[1]).unwrap(), Array::new(&[1], vec![-1i64]));
        assert_eq!(decode("|b1", &[0, 1], &[2]).unwrap(), Array::new(&[2], vec![false, true]));
        assert_eq!(decode("<f2", &[0x00, 0x3e], &[1]).unwrap(), Array::new(&[1], vec![1.5f32]));
    }

    #[test]
    fn text_loses_its_padding() {
        assert_eq!(decode("|S4", b"ab\0\0", &[]).unwrap(), Array::new(&[], vec!["ab".to_owned()]));
        assert_eq!(decode("<U2", b"\xe9\0\0\0\0\0\0\0", &[1]).unwrap(), Array::new(&[1], vec!["é".to_owned()]));
    }

    #[test]
    fn fortran_order_becomes_c_order() {
        let bytes: Vec<u8> = (0..24).collect();
        let array =
            ElementType::parse("u1", PLACE).unwrap().decode(&bytes, &[2, 3, 4], true, &allowance(), PLACE).unwrap();
        let values = array.to_i64().unwrap();
        for (i, j, k) in [(0, 0, 0), (1, 0, 0), (0, 2, 1), (1, 2, 3)] {
            assert_eq!(values[(i * 3 + j) * 4 + k], (i + 2 * (j + 3 * k)) as i64);
        }
    }

    #[test]
    fn sizes_that_do_not_fit_are_errors() {
        assert_eq!(decode("<f4", &[0; 7], &[2]).unwrap_err().found, "7 bytes");
        assert!(decode("<f4", &[], &[usize::MAX, 2]).unwrap_err().found.starts_with("shape"));
        assert!(decode("<f4", &[], &[1 << 27]).unwrap_err().found.starts_with("shape"));
        assert!(decode("|S0", &[], &[1 << 20]).unwrap_err().found.starts_with("shape"));
        assert_eq!(decode("|O", &[], &[1]).unwrap_err().found, "\"|O\"");
        assert_eq!(decode("<é4", &[], &[1]).unwrap_err().found, "\"<é4\"");
    }
}
