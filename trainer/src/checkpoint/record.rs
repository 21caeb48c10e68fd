//! One checkpoint file: a header, what the result depends on, the result, a checksum.
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `CREASECK` |
//! | 4 | version, little endian |
//! | 32 | fingerprint of everything that the result depends on |
//! | 8 | length of the result in bytes, little endian |
//! | length | the result |
//! | 32 | SHA-256 of all bytes before |

use super::Fingerprint;
use crease::numpy::ReadError;
use sha2::{Digest, Sha256};

const MAGIC: &[u8; 8] = b"CREASECK";
/// Of this layout and of the results inside.
const VERSION: u32 = 2;
const HEADER_LENGTH: usize = 8 + 4 + 32 + 8;
const CHECKSUM_LENGTH: usize = 32;

/// What a checkpoint file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Record<'a> {
    /// What the result depends on.
    pub inputs: Fingerprint,
    /// The result's bytes.
    pub result: &'a [u8],
}

impl<'a> Record<'a> {
    /// Reads a file's bytes; `file` is its name for messages.
    ///
    /// Fails on another kind of file, on another version, and where a byte is missing, added or changed. Allocates nothing but the error.
    pub fn read(bytes: &'a [u8], file: &str) -> Result<Self, ReadError> {
        let error = |field: &str, expected: String, found: String| ReadError {
            file: file.into(),
            field: field.into(),
            expected,
            found,
        };
        let least = HEADER_LENGTH + CHECKSUM_LENGTH;
        let (Some((header, _)), Some((content, checksum))) =
            (bytes.split_first_chunk::<HEADER_LENGTH>(), bytes.split_last_chunk::<CHECKSUM_LENGTH>())
        else {
            return Err(error("length", format!("at least {least} bytes"), bytes.len().to_string()));
        };
        let (magic, version, inputs, length) = (&header[..8], &header[8..12], &header[12..44], &header[44..]);
        if magic != MAGIC {
            return Err(error("magic", "CREASECK".into(), format!("{:?}", String::from_utf8_lossy(magic))));
        }
        let version = u32::from_le_bytes(version.try_into().expect("four bytes"));
        if version != VERSION {
            return Err(error("version", VERSION.to_string(), version.to_string()));
        }
        let length = u64::from_le_bytes(length.try_into().expect("eight bytes"));
        let there = content.len().checked_sub(HEADER_LENGTH);
        if there.is_none_or(|there| there as u64 != length) {
            return Err(error("length", format!("{least} bytes and a result of {length}"), bytes.len().to_string()));
        }
        if Sha256::digest(content).as_slice() != checksum {
            return Err(error("checksum", "that of the bytes before".into(), "another".into()));
        }
        let inputs = Fingerprint(inputs.try_into().expect("32 bytes"));
        Ok(Self { inputs, result: &content[HEADER_LENGTH..] })
    }

    /// The file's bytes.
    pub fn write(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(HEADER_LENGTH + self.result.len() + CHECKSUM_LENGTH);
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(self.inputs.0);
        bytes.extend((self.result.len() as u64).to_le_bytes());
        bytes.extend(self.result);
        let checksum = Sha256::digest(&bytes);
        bytes.extend(checksum.as_slice());
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_changed_or_missing_byte_is_noticed() {
        let record = Record { inputs: Fingerprint([7; 32]), result: b"what was computed" };
        let bytes = record.write();
        assert_eq!(Record::read(&bytes, "a").unwrap(), record);
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 1 << (at % 8);
            let error = Record::read(&damaged, "a").unwrap_err();
            assert_eq!(error.file, "a");
            assert!(Record::read(&bytes[..at], "a").is_err());
        }
        assert!(Record::read(&[bytes, vec![0]].concat(), "a").is_err());
    }

    #[test]
    fn other_versions_are_named() {
        let mut bytes = Record { inputs: Fingerprint([0; 32]), result: b"" }.write();
        bytes[8] = 9;
        let error = Record::read(&bytes, "a").unwrap_err();
        assert_eq!((error.field.as_str(), error.expected, error.found.as_str()), ("version", VERSION.to_string(), "9"));
    }
}
