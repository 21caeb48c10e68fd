//! Inflating what deflate packed, to a declared length and no further.

use flate2::{Decompress, FlushDecompress, Status};

/// Deflate makes at most so many bytes of one: 258 for two bits.
const GREATEST_RATIO: usize = 1032;

/// How a deflated stream is wrapped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wrapping {
    /// RFC 1950: a header and a checksum.
    Zlib,
    /// Nothing (RFC 1951), as in zip archives.
    None,
}

/// What `packed` inflates to, which must be `length` bytes; else what it is. A false `length` costs no more memory than `packed` can fill.
pub(crate) fn inflate(packed: &[u8], length: usize, wrapping: Wrapping) -> Result<Vec<u8>, String> {
    if length / GREATEST_RATIO > packed.len() {
        return Err(format!("{} bytes, too few for {length}", packed.len()));
    }
    // One byte more than declared is enough to see that there are more.
    let mut bytes = vec![0; length + 1];
    let mut stream = Decompress::new(wrapping == Wrapping::Zlib);
    let status = stream.decompress(packed, &mut bytes, FlushDecompress::Finish);
    let found = stream.total_out();
    match status {
        _ if found > length as u64 => Err("more".into()),
        Ok(Status::StreamEnd) if found == length as u64 => {
            bytes.truncate(length);
            Ok(bytes)
        }
        Ok(Status::StreamEnd) => Err(format!("{found} bytes")),
        Ok(_) => Err(format!("{found} bytes without an end")),
        Err(error) => Err(error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::{DeflateEncoder, ZlibEncoder};
    use std::io::Write;

    const LENGTH: usize = 600;

    fn packed(wrapping: Wrapping) -> Vec<u8> {
        let bytes = [7; LENGTH];
        match wrapping {
            Wrapping::Zlib => {
                let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
                encoder.write_all(&bytes).unwrap();
                encoder.finish().unwrap()
            }
            Wrapping::None => {
                let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
                encoder.write_all(&bytes).unwrap();
                encoder.finish().unwrap()
            }
        }
    }

    #[test]
    fn only_the_declared_length_is_accepted() {
        for wrapping in [Wrapping::Zlib, Wrapping::None] {
            let packed = packed(wrapping);
            assert_eq!(inflate(&packed, LENGTH, wrapping).unwrap(), [7; LENGTH]);
            assert_eq!(inflate(&packed, LENGTH - 2, wrapping).unwrap_err(), "more");
            assert_eq!(inflate(&packed, LENGTH + 2, wrapping).unwrap_err(), "600 bytes");
            // Refused before anything is allocated.
            assert!(inflate(&packed, usize::MAX / 2, wrapping).unwrap_err().contains("too few"));
            for length in 0..packed.len() {
                assert!(inflate(&packed[..length], LENGTH, wrapping).is_err(), "cut to {length} bytes");
            }
        }
    }

    #[test]
    fn a_checksum_misses_no_flipped_bit() {
        let packed = packed(Wrapping::Zlib);
        for at in 0..packed.len() {
            let mut damaged = packed.clone();
            damaged[at] ^= 0x10;
            // Bits that say how hard the writer tried may change.
            let found = inflate(&damaged, LENGTH, Wrapping::Zlib);
            assert!(found.is_err() || found.unwrap() == [7; LENGTH], "byte {at}");
        }
    }
}
