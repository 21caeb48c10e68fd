//! The header of a PLY file.

use crease::numpy::ReadError;

/// Longer headers are refused.
const LONGEST_HEADER: usize = 64 * 1024;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn parse(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// From little-endian bytes; those beyond the size are ignored.
    pub(super) fn decode(self, b: [u8; 8]) -> f64 {
        match self {
            Self::I8 => i8::from_le_bytes([b[0]]).into(),
            Self::U8 => b[0].into(),
            Self::I16 => i16::from_le_bytes([b[0], b[1]]).into(),
            Self::U16 => u16::from_le_bytes([b[0], b[1]]).into(),
            Self::I32 => i32::from_le_bytes([b[0], b[1], b[2], b[3]]).into(),
            Self::U32 => u32::from_le_bytes([b[0], b[1], b[2], b[3]]).into(),
            Self::F32 => f32::from_le_bytes([b[0], b[1], b[2], b[3]]).into(),
            Self::F64 => f64::from_le_bytes(b),
        }
    }
}

#[derive(Clone, Debug)]
pub(super) struct Property {
    pub name: String,
    pub scalar: Scalar,
    /// Type of the length, for lists.
    pub list_length: Option<Scalar>,
}

impl Property {
    pub(super) fn is_list(&self) -> bool {
        self.list_length.is_some()
    }

    /// Bytes of a value; of an empty list for lists.
    pub(super) fn least_size(&self) -> usize {
        self.list_length.unwrap_or(self.scalar).size()
    }

    /// Colours are bytes, or fractions where they are stored as floats.
    pub(super) fn colour_byte(&self, value: f64) -> u8 {
        let scale = if matches!(self.scalar, Scalar::F32 | Scalar::F64) { 255.0 } else { 1.0 };
        (value * scale).round().clamp(0.0, 255.0) as u8
    }
}

#[derive(Clone, Debug)]
pub(super) struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
}

#[derive(Clone, Debug)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Where the data begins.
    pub body_offset: usize,
}

impl Header {
    pub(super) fn read(bytes: &[u8], file: &str) -> Result<Self, ReadError> {
        let error = |expected: &str, found: &str| ReadError {
            file: file.into(),
            field: "header".into(),
            expected: expected.into(),
            found: found.chars().take(60).collect(),
        };
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        let mut offset = 0;
        loop {
            let window = &bytes[offset..bytes.len().min(LONGEST_HEADER)];
            let Some(length) = window.iter().position(|&byte| byte == b'\n') else {
                return Err(error("a line end_header", "none"));
            };
            let line = String::from_utf8_lossy(&window[..length]);
            let words: Vec<&str> = line.split_whitespace().collect();
            if offset == 0 && words != ["ply"] {
                return Err(error("a first line ply", line.trim()));
            }
            offset += length + 1;
            match words.as_slice() {
                ["ply"] | ["comment" | "obj_info", ..] | [] => {}
                ["format", "ascii", _] => encoding = Some(Encoding::Ascii),
                ["format", "binary_little_endian", _] => encoding = Some(Encoding::LittleEndian),
                ["format", "binary_big_endian", _] => encoding = Some(Encoding::BigEndian),
                ["element", name, count] => {
                    let count = count.parse().map_err(|_| error("a count of elements", &line))?;
                    elements.push(Element { name: (*name).into(), count, properties: Vec::new() });
                }
                ["property", rest @ ..] => {
                    let property = parse_property(rest).ok_or_else(|| error("a property of a known type", &line))?;
                    let element = elements.last_mut().ok_or_else(|| error("an element before", &line))?;
                    element.properties.push(property);
                }
                ["end_header"] => break,
                _ => return Err(error("format, element, property or end_header", &line)),
            }
        }
        let encoding = encoding.ok_or_else(|| error("a line format", "none"))?;
        Ok(Self { encoding, elements, body_offset: offset })
    }
}

fn parse_property(words: &[&str]) -> Option<Property> {
    match words {
        ["list", length, scalar, name] => Some(Property {
            name: (*name).into(),
            scalar: Scalar::parse(scalar)?,
            list_length: Some(Scalar::parse(length)?),
        }),
        [scalar, name] => Some(Property { name: (*name).into(), scalar: Scalar::parse(scalar)?, list_length: None }),
        _ => None,
    }
}
