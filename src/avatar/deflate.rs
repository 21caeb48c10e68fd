//! Packed tables: the bytes of all numbers sorted into planes, then a zlib stream.
//!
//! The high bytes of neighbouring numbers are alike and the low ones are not, so apart they take less room.

use crate::inflate::{Wrapping, inflate};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::io::Write;

/// `bytes`, numbers of `size` bytes each, packed.
pub fn pack(bytes: &[u8], size: usize) -> Vec<u8> {
    let planes: Vec<u8> = (0..size).flat_map(|plane| bytes.iter().skip(plane).step_by(size).copied()).collect();
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(&planes).and_then(|()| encoder.finish()).expect("memory takes every write")
}

/// The bytes that [`pack`] was given, `length` of them; what is wrong where it was given others.
pub fn unpack(packed: &[u8], length: usize, size: usize) -> Result<Vec<u8>, String> {
    let planes = inflate(packed, length, Wrapping::Zlib)?;
    if size == 1 {
        return Ok(planes);
    }
    let count = length / size;
    let mut bytes = vec![0; length];
    for (plane, values) in planes.chunks_exact(count.max(1)).enumerate() {
        bytes.iter_mut().skip(plane).step_by(size).zip(values).for_each(|(byte, value)| *byte = *value);
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unpacking_gives_back_what_was_packed() {
        for size in [1, 2, 4] {
            for count in [0, 1, 1000] {
                let bytes: Vec<u8> = (0..count * size).map(|i| (i * i % 251) as u8).collect();
                assert_eq!(unpack(&pack(&bytes, size), bytes.len(), size).unwrap(), bytes);
            }
        }
    }

    #[test]
    fn planes_pack_smooth_numbers_better() {
        let bytes: Vec<u8> = (0..4000u16).flat_map(|i| (1000 + i % 200).to_le_bytes()).collect();
        assert!(pack(&bytes, 2).len() < pack(&bytes, 1).len());
    }
}
