//! CAPE (Ma et al. 2020): raw scans as PLY, and for each a `.npz` with `pose` and `transl`; names end in the number of the frame.

use super::{Found, Source, files, read_poses};
use crate::sequence::read_error;

pub(super) fn find(source: &Source) -> anyhow::Result<Found> {
    let folder = source.scans.as_ref().unwrap_or(&source.frames);
    let (scans, parameters) = (files(folder, "ply")?, files(&source.frames, "npz")?);
    if scans.len() != parameters.len() {
        let expected = format!("{} scans as there are .npz files", parameters.len());
        return Err(read_error(folder, "folder", &expected, scans.len().to_string()).into());
    }
    let (poses, betas) = read_poses(&parameters)?;
    Ok(Found { scans, poses, betas })
}
