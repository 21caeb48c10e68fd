//! The `.npz` format: a zip archive of `.npy` files, stored or deflated.

use super::{Array, ENTRY_BYTE_LIMIT, Place, ReadError, npy};
use crate::inflate::{Wrapping, inflate};
use crate::memory::Allowance;
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use rawzip::{CompressionMethod, ZipArchive, ZipArchiveWriter, ZipFileHeaderRecord, ZipSliceArchive};
use std::collections::{BTreeSet, HashSet};
use std::io::Write;

/// Zip's checksum, without a table: a page would have to download it.
const CHECKSUM: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// An open archive; arrays are unpacked when asked for.
pub(super) struct Npz<'a> {
    file: String,
    zip: ZipSliceArchive<&'a [u8]>,
}

impl<'a> Npz<'a> {
    pub(super) fn open(bytes: &'a [u8], file: &str) -> Result<Self, ReadError> {
        let place = Place { file, field: "archive" };
        let broken = |error: rawzip::Error| place.error("a whole zip archive", error.to_string());
        let zip = ZipArchive::from_slice(bytes).map_err(broken)?;
        let mut names = HashSet::new();
        let mut count = 0;
        for entry in zip.entries() {
            let name = entry.map_err(broken)?.file_path().as_ref().to_owned();
            count += 1;
            if let Some(name) = names.replace(name) {
                let found = format!("two of {:?}", String::from_utf8_lossy(&name));
                return Err(place.error("entries of different names", found));
            }
        }
        if count != zip.entries_hint() {
            return Err(place.error(format!("{} entries as declared", zip.entries_hint()), count.to_string()));
        }
        Ok(Self { file: file.to_owned(), zip })
    }

    /// Names of the arrays, sorted.
    pub(super) fn names(&self) -> Vec<String> {
        let name = |entry: ZipFileHeaderRecord| {
            let path = entry.file_path();
            let path = std::str::from_utf8(path.as_ref()).ok()?;
            path.strip_suffix(".npy").map(ToOwned::to_owned)
        };
        let mut names = BTreeSet::new();
        names.extend(self.zip.entries().flatten().filter_map(name));
        names.into_iter().collect()
    }

    /// Reads an array, if there is one of that name.
    pub(super) fn array(&self, name: &str, allowance: &Allowance) -> Result<Option<Array>, ReadError> {
        let place = Place { file: &self.file, field: name };
        let path = format!("{name}.npy");
        match self.zip.entries().flatten().find(|entry| entry.file_path().as_ref() == path.as_bytes()) {
            None => Ok(None),
            Some(entry) => npy::read(&self.unpacked(&entry, allowance, place)?, allowance, place).map(Some),
        }
    }

    /// The bytes of an entry, as many as it declares and with its checksum.
    fn unpacked(&self, entry: &ZipFileHeaderRecord, allowance: &Allowance, place: Place) -> Result<Vec<u8>, ReadError> {
        let declared = entry.uncompressed_size_hint();
        let length = usize::try_from(declared).ok().filter(|_| declared <= ENTRY_BYTE_LIMIT).ok_or_else(|| {
            place.error(format!("at most {ENTRY_BYTE_LIMIT} bytes"), format!("{declared} bytes declared"))
        })?;
        allowance.afford(length).map_err(|shortage| place.short(shortage))?;
        if entry.flags().is_encrypted() {
            return Err(place.error("a zip entry that anyone can read", "an encrypted one"));
        }
        let local = self.zip.get_entry(entry.wayfinder());
        let packed = local.map_err(|error| place.error("a whole zip entry", error.to_string()))?.data();
        let unpacked = match entry.compression_method() {
            CompressionMethod::DEFLATE => inflate(packed, length, Wrapping::None),
            CompressionMethod::STORE if packed.len() == length => Ok(packed.to_vec()),
            CompressionMethod::STORE => Err(packed.len().to_string()),
            other => {
                return Err(place.error("a zip entry that is stored or deflated", format!("method {}", other.as_u16())));
            }
        };
        let unpacked = unpacked.map_err(|found| place.error(format!("{declared} bytes as declared"), found))?;
        match CHECKSUM.checksum(&unpacked) {
            checksum if checksum == entry.crc32() => Ok(unpacked),
            checksum => Err(place.error(format!("the checksum {:08x}", entry.crc32()), format!("{checksum:08x}"))),
        }
    }
}

/// How the arrays of an archive are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compression {
    /// As they are.
    Stored,
    /// With deflate.
    Deflated,
}

/// Writes named arrays as a `.npz` file. The bytes depend on the arrays alone: no times are stored.
///
/// # Errors
/// If two arrays have one name.
pub fn write_npz(arrays: &[(&str, &Array)], compression: Compression) -> std::io::Result<Vec<u8>> {
    let mut names = HashSet::new();
    if let Some((name, _)) = arrays.iter().find(|(name, _)| !names.insert(name)) {
        return Err(std::io::Error::other(format!("two arrays of the name {name}")));
    }
    let method = match compression {
        Compression::Stored => CompressionMethod::STORE,
        Compression::Deflated => CompressionMethod::DEFLATE,
    };
    let mut zip = ZipArchiveWriter::new(Vec::new());
    for (name, array) in arrays {
        let mut bytes = Vec::new();
        npy::write(array, &mut bytes)?;
        let path = format!("{name}.npy");
        let entry = zip.new_file(path.as_str()).compression_method(method);
        let (mut entry, config) = entry.start().map_err(std::io::Error::other)?;
        let descriptor = match compression {
            Compression::Stored => {
                let mut writer = config.wrap(&mut entry);
                writer.write_all(&bytes)?;
                writer.finish().map_err(std::io::Error::other)?.1
            }
            Compression::Deflated => {
                let encoder = flate2::write::DeflateEncoder::new(&mut entry, flate2::Compression::default());
                let mut writer = config.wrap(encoder);
                writer.write_all(&bytes)?;
                let (encoder, descriptor) = writer.finish().map_err(std::io::Error::other)?;
                encoder.finish()?;
                descriptor
            }
        };
        entry.finish(descriptor).map_err(std::io::Error::other)?;
    }
    zip.finish().map_err(std::io::Error::other)
}
