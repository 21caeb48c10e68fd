//! The GLB container: a header, a JSON chunk, a binary chunk (glTF 2.0, section 4).

use super::AvatarError;

const MAGIC: u32 = u32::from_le_bytes(*b"glTF");
const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BINARY: u32 = u32::from_le_bytes(*b"BIN\0");

/// The two chunks of a GLB.
pub struct Glb<'a> {
    /// The JSON chunk's bytes, padding included.
    pub json: &'a [u8],
    /// The binary chunk's bytes, padding included.
    pub binary: &'a [u8],
}

impl<'a> Glb<'a> {
    /// Splits `bytes`; chunks of unknown types after the two are skipped, as glTF asks.
    pub fn parse(bytes: &'a [u8], file: &str) -> Result<Self, AvatarError> {
        let error = |field: &str, expected: &str, found: String| AvatarError::new(file, field, expected, found);
        let word = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let (Some(magic), Some(version), Some(length)) = (word(0), word(4), word(8)) else {
            return Err(error("header", "12 bytes", format!("{} bytes", bytes.len())));
        };
        if magic != MAGIC {
            return Err(error("header.magic", "\"glTF\"", format!("{magic:#010x}")));
        }
        if version != 2 {
            return Err(error("header.version", "2", version.to_string()));
        }
        if length as usize != bytes.len() {
            return Err(error("header.length", &format!("the file's length, {}", bytes.len()), length.to_string()));
        }
        let chunk = |at: usize, name: &str, kind: u32| {
            let (Some(length), Some(found)) = (word(at), word(at + 4)) else {
                return Err(error(name, "a chunk", "the end of the file".into()));
            };
            if found != kind {
                return Err(error(&format!("{name}.type"), &format!("{kind:#010x}"), format!("{found:#010x}")));
            }
            let rest = &bytes[at + 8..];
            rest.get(..length as usize)
                .ok_or_else(|| error(&format!("{name}.length"), &format!("at most {}", rest.len()), length.to_string()))
        };
        let json = chunk(12, "JSON chunk", JSON)?;
        let binary = chunk(20 + json.len(), "BIN chunk", BINARY)?;
        Ok(Self { json, binary })
    }

    /// The file's bytes: the JSON padded with spaces, the binary with zeros, to multiples of four.
    pub fn assemble(mut json: Vec<u8>, mut binary: Vec<u8>) -> Vec<u8> {
        json.resize(json.len().next_multiple_of(4), b' ');
        binary.resize(binary.len().next_multiple_of(4), 0);
        let length = 12 + 8 + json.len() + 8 + binary.len();
        let mut bytes = Vec::with_capacity(length);
        for word in [MAGIC, 2, length as u32, json.len() as u32, JSON] {
            bytes.extend(word.to_le_bytes());
        }
        bytes.extend(&json);
        for word in [binary.len() as u32, BINARY] {
            bytes.extend(word.to_le_bytes());
        }
        bytes.extend(&binary);
        bytes
    }
}
