//! Files with an inside: opened, and closed again with lengths and checksums that are right.

use crate::{Container, Part};
use crease_trainer::checkpoint::{Fingerprint, Record};
use std::io::{Cursor, Read, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// A GLB: its JSON and its binary chunk.
pub const GLB: Container = Container { open: open_glb, close: close_glb };
/// A zip archive: one part an entry. Closed without compression, so that blind mutations reach the content as well.
pub const NPZ: Container = Container { open: open_npz, close: close_npz };
/// The view of a depth camera: `camera.json`, header and pixels of a PNG, and a picture of any kind.
pub const VIEW: Container = Container { open: open_view, close: close_view };
/// A checkpoint's file: fingerprint and result.
pub const CHECKPOINT: Container = Container { open: open_checkpoint, close: close_checkpoint };

/// Unpacked bytes that are looked at: a bomb is not a seed.
const LARGEST_ENTRY: u64 = 1 << 16;

fn part(name: &str, bytes: &[u8]) -> Part {
    Part { name: name.to_owned(), bytes: bytes.to_vec() }
}

fn open_glb(bytes: &[u8]) -> Option<Vec<Part>> {
    let chunk = |at: usize| {
        let length = u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?) as usize;
        bytes.get(at + 8..)?.get(..length)
    };
    let json = chunk(12)?;
    let binary = chunk(20 + json.len())?;
    Some(vec![part("JSON", json), part("BIN", binary)])
}

fn close_glb(parts: &[Part]) -> Vec<u8> {
    let mut chunks = Vec::new();
    for (part, kind, padding) in [(&parts[0], b"JSON", b' '), (&parts[1], b"BIN\0", 0)] {
        let length = part.bytes.len().next_multiple_of(4);
        chunks.extend((length as u32).to_le_bytes());
        chunks.extend(kind);
        chunks.extend(&part.bytes);
        chunks.resize(chunks.len() + length - part.bytes.len(), padding);
    }
    let head = [b"glTF".as_slice(), &2u32.to_le_bytes(), &(12 + chunks.len() as u32).to_le_bytes()];
    [head.concat(), chunks].concat()
}

fn open_npz(bytes: &[u8]) -> Option<Vec<Part>> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).ok()?;
    let mut parts = Vec::new();
    for index in 0..archive.len() {
        let entry = archive.by_index(index).ok()?;
        let name = entry.name().ok()?.into_owned();
        let mut content = Vec::new();
        entry.take(LARGEST_ENTRY).read_to_end(&mut content).ok()?;
        parts.push(Part { name, bytes: content });
    }
    (!parts.is_empty()).then_some(parts)
}

fn close_npz(parts: &[Part]) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    for part in parts {
        // A name that is there already is left out.
        if archive.start_file(part.name.as_str(), options).is_ok() {
            archive.write_all(&part.bytes).expect("memory takes every write");
        }
    }
    archive.finish().expect("memory takes every write").into_inner()
}

/// `camera.json`, depth image and picture, each but the last behind its length.
pub fn split_view(bytes: &[u8]) -> Option<(&[u8], &[u8], &[u8])> {
    let split = |bytes| {
        let (length, rest) = <[u8]>::split_first_chunk(bytes)?;
        rest.split_at_checked(u16::from_le_bytes(*length).into())
    };
    let (camera, rest) = split(bytes)?;
    let (depth, colour) = split(rest)?;
    Some((camera, depth, colour))
}

fn open_view(bytes: &[u8]) -> Option<Vec<Part>> {
    let (camera, depth, colour) = split_view(bytes)?;
    let mut chunks = depth.get(PNG_SIGNATURE.len()..)?;
    let (mut header, mut packed) = (None, Vec::new());
    while let Some((length, rest)) = chunks.split_first_chunk() {
        let (kind, rest) = rest.split_first_chunk::<4>()?;
        let (content, rest) = rest.split_at_checked(u32::from_be_bytes(*length) as usize)?;
        match kind {
            b"IHDR" => header = Some(content),
            b"IDAT" => packed.extend(content),
            _ => {}
        }
        chunks = rest.get(4..)?;
    }
    let mut pixels = Vec::new();
    flate2::read::ZlibDecoder::new(&*packed).take(LARGEST_ENTRY).read_to_end(&mut pixels).ok()?;
    Some(vec![part("camera.json", camera), part("header", header?), part("pixels", &pixels), part("picture", colour)])
}

const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

fn close_view(parts: &[Part]) -> Vec<u8> {
    let [camera, header, pixels, colour] = [0, 1, 2, 3].map(|index| parts[index].bytes.as_slice());
    let depth = png(header, pixels);
    let length = |bytes: &[u8]| u16::try_from(bytes.len()).unwrap_or(u16::MAX).to_le_bytes();
    [&length(camera), camera, &length(&depth), &depth, colour].concat()
}

/// A PNG of its header's 13 bytes and its rows, each behind its filter's number; not compressed.
pub fn png(header: &[u8], rows: &[u8]) -> Vec<u8> {
    let mut packed = vec![0x78, 0x01];
    let mut blocks = rows.chunks(usize::from(u16::MAX)).peekable();
    while let Some(block) = blocks.next() {
        let length = block.len() as u16;
        packed.push(u8::from(blocks.peek().is_none()));
        packed.extend(length.to_le_bytes());
        packed.extend((!length).to_le_bytes());
        packed.extend(block);
    }
    let (a, b) = rows.iter().fold((1, 0), |(a, b), &byte| {
        let a = (a + u32::from(byte)) % 65521;
        (a, (b + a) % 65521)
    });
    packed.extend((b << 16 | a).to_be_bytes());
    packed_png(header, &packed)
}

/// A PNG of its header's 13 bytes and its rows as zlib packs them.
pub fn packed_png(header: &[u8], packed: &[u8]) -> Vec<u8> {
    let mut bytes = PNG_SIGNATURE.to_vec();
    for (kind, content) in [(b"IHDR", header), (b"IDAT", packed), (b"IEND", &[])] {
        let mut checksum = flate2::Crc::new();
        checksum.update(kind);
        checksum.update(content);
        bytes.extend((content.len() as u32).to_be_bytes());
        bytes.extend(kind);
        bytes.extend(content);
        bytes.extend(checksum.sum().to_be_bytes());
    }
    bytes
}

fn open_checkpoint(bytes: &[u8]) -> Option<Vec<Part>> {
    let record = Record::read(bytes, "checkpoint").ok()?;
    Some(vec![part("inputs", &record.inputs.0), part("result", record.result)])
}

fn close_checkpoint(parts: &[Part]) -> Vec<u8> {
    let mut inputs = [0; 32];
    inputs.iter_mut().zip(&parts[0].bytes).for_each(|(to, from)| *to = *from);
    Record { inputs: Fingerprint(inputs), result: &parts[1].bytes }.write()
}

#[cfg(test)]
mod tests {
    use crate::TARGETS;

    #[test]
    fn containers_close_to_what_can_be_opened_again() {
        for target in &TARGETS {
            let Some(container) = target.container else { continue };
            for seed in (target.seeds)() {
                let mut parts = (container.open)(&seed).unwrap_or_else(|| panic!("{} does not open", target.name));
                (target.check)(&(container.close)(&parts));
                let last = parts.len() - 1;
                parts[last].bytes.push(7);
                let changed = (container.close)(&parts);
                let again = (container.open)(&changed).unwrap();
                assert_eq!(again.len(), parts.len(), "{}", target.name);
                assert_ne!(changed, seed, "{}", target.name);
            }
        }
    }
}
