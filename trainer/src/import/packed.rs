//! ReSynth and PoP (Ma et al. 2021): one `.npz` a frame with points `scan_pc`, normals `scan_n`, `pose` and `transl`.

use super::{Found, Source, files, read_poses};

pub(super) fn find(source: &Source) -> anyhow::Result<Found> {
    let scans = files(&source.frames, "npz")?;
    let (poses, betas) = read_poses(&scans)?;
    Ok(Found { scans, poses, betas })
}
