//! Packed tables: the bytes of all numbers sorted into planes, then a zlib stream.
//!
//! The high bytes of neighbouring numbers are alike and the low ones are not, so apart they take less room.

use flate2::Compression;
use flate2::bufread::ZlibDecoder;
use flate2::write::ZlibEncoder;
use std::io::{Read, Write};

/// Deflate makes at most so many bytes of one: 258 for two bits.
const GREATEST_RATIO: usize = 1032;

/// `bytes`, numbers of `size` bytes each, packed.
pub fn pack(bytes: &[u8], size: usize) -> Vec<u8> {
    let planes: Vec<u8> = (0..size).flat_map(|plane| bytes.iter().skip(plane).step_by(size).copied()).collect();
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(&planes).and_then(|()| encoder.finish()).expect("memory takes every write")
}

/// The bytes that [`pack`] was given, `length` of them; what is wrong where it was given others.
pub fn unpack(packed: &[u8], length: usize, size: usize) -> Result<Vec<u8>, String> {
    if length > GREATEST_RATIO * packed.len() {
        return Err(format!("{} bytes, too few for {length}", packed.len()));
    }
    let mut planes = Vec::with_capacity(length);
    // One byte more than declared is enough to see that there are more.
    let limit = length as u64 + 1;
    ZlibDecoder::new(packed).take(limit).read_to_end(&mut planes).map_err(|error| error.to_string())?;
    if planes.len() != length {
        return Err(if planes.len() > length { "more".into() } else { format!("{} bytes", planes.len()) });
    }
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

    #[test]
    fn wrong_lengths_and_damage_are_errors() {
        let packed = pack(&[7; 600], 2);
        assert_eq!(unpack(&packed, 598, 2).unwrap_err(), "more");
        assert_eq!(unpack(&packed, 602, 2).unwrap_err(), "600 bytes");
        // Refused before anything is allocated.
        assert!(unpack(&packed, usize::MAX / 2, 2).unwrap_err().contains("too few"));
        for at in 0..packed.len() {
            let mut damaged = packed.clone();
            damaged[at] ^= 0x10;
            // The checksum misses nothing that one bit can do; bits that say how hard the writer tried may change.
            assert!(unpack(&damaged, 600, 2).is_err() || unpack(&damaged, 600, 2).unwrap() == [7; 600]);
        }
        assert!(unpack(&packed[..packed.len() - 1], 600, 2).is_err());
    }
}
