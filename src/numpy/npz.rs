//! The `.npz` format: a zip archive of `.npy` files, stored or deflated.

use super::{Array, ENTRY_BYTE_LIMIT, Place, ReadError, npy};
use crate::memory::Allowance;
use std::io::{Cursor, Read};
use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// An open archive; arrays are unpacked when asked for.
pub(super) struct Npz<'a> {
    file: String,
    zip: ZipArchive<Cursor<&'a [u8]>>,
}

impl<'a> Npz<'a> {
    pub(super) fn open(bytes: &'a [u8], file: &str) -> Result<Self, ReadError> {
        let zip = ZipArchive::new(Cursor::new(bytes))
            .map_err(|error| Place { file, field: "archive" }.error("a whole zip archive", error.to_string()))?;
        Ok(Self { file: file.to_owned(), zip })
    }

    /// Names of the arrays, sorted.
    pub(super) fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = (self.zip.file_names().flatten())
            .filter_map(|name| name.strip_suffix(".npy").map(ToOwned::to_owned))
            .collect();
        names.sort();
        names
    }

    /// Reads an array, if there is one of that name.
    pub(super) fn array(&mut self, name: &str, allowance: &Allowance) -> Result<Option<Array>, ReadError> {
        let place = Place { file: &self.file, field: name };
        let unpacked = |error: &dyn std::fmt::Display| place.error("a whole zip entry", error.to_string());
        let mut entry = match self.zip.by_name(&format!("{name}.npy")) {
            Ok(entry) => entry,
            Err(ZipError::FileNotFound) => return Ok(None),
            Err(error) => return Err(unpacked(&error)),
        };
        if entry.size() > ENTRY_BYTE_LIMIT {
            let expected = format!("at most {ENTRY_BYTE_LIMIT} bytes");
            return Err(place.error(expected, format!("{} bytes declared", entry.size())));
        }
        // One byte more than declared is enough to see that there are more.
        let declared = entry.size();
        allowance.afford(declared as usize).map_err(|shortage| place.short(shortage))?;
        let mut bytes = Vec::with_capacity(declared as usize);
        (&mut entry).take(declared + 1).read_to_end(&mut bytes).map_err(|error| unpacked(&error))?;
        if bytes.len() as u64 != declared {
            let found = if bytes.len() as u64 > declared { "more".to_owned() } else { bytes.len().to_string() };
            return Err(place.error(format!("{declared} bytes as declared"), found));
        }
        npy::read(&bytes, allowance, place).map(Some)
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
    let method = match compression {
        Compression::Stored => CompressionMethod::Stored,
        Compression::Deflated => CompressionMethod::Deflated,
    };
    let options = SimpleFileOptions::default().compression_method(method);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, array) in arrays {
        zip.start_file(format!("{name}.npy"), options)?;
        let mut bytes = Vec::new();
        npy::write(array, &mut bytes)?;
        std::io::Write::write_all(&mut zip, &bytes)?;
    }
    Ok(zip.finish()?.into_inner())
}
