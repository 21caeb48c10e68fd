//! `crease transfer` and `crease texture`: what one avatar takes from another (paper, section 6).

use super::read_avatar;
use clap::Args;
use crease::avatar::{Appearance, Avatar};
use crease_trainer::files::write_whole;
use std::path::{Path, PathBuf};

#[derive(Args)]
pub struct DetailArguments {
    /// The avatar whose wrinkles are taken (.glb)
    #[arg(long, value_name = "AVATAR")]
    pub detail: PathBuf,
    /// The avatar that wears them (.glb)
    #[arg(long, value_name = "AVATAR")]
    pub base: PathBuf,
    /// Where to write it
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
}

#[derive(Args)]
pub struct TextureArguments {
    /// The avatar whose texture is taken (.glb)
    #[arg(long, value_name = "AVATAR")]
    pub from: PathBuf,
    /// The avatar that wears it (.glb)
    #[arg(long, value_name = "AVATAR")]
    pub onto: PathBuf,
    /// Where to write it
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
}

/// The base of one avatar with the wrinkles of another.
pub fn detail(arguments: &DetailArguments) -> anyhow::Result<()> {
    let (giver, wearer) = (read_avatar(&arguments.detail)?, read_avatar(&arguments.base)?);
    let avatar = wearer.with_detail_of(&giver, &arguments.detail.display().to_string())?;
    write(avatar, "detail_from", &giver, &arguments.output)
}

/// One avatar in the texture of another.
pub fn texture(arguments: &TextureArguments) -> anyhow::Result<()> {
    let (giver, wearer) = (read_avatar(&arguments.from)?, read_avatar(&arguments.onto)?);
    let texture = wearer.texture_of(&giver, &arguments.from.display().to_string())?.clone();
    let appearance = Appearance { texture: Some(texture), ..wearer.appearance.clone() };
    write(Avatar { appearance, ..wearer }, "texture_from", &giver, &arguments.output)
}

/// Writes what was made, which says whose it is.
fn write(mut avatar: Avatar, key: &str, giver: &Avatar, output: &Path) -> anyhow::Result<()> {
    let facts = serde_json::json!({ "name": giver.name, "provenance": giver.provenance });
    avatar.provenance.insert(key.into(), facts);
    let bytes = avatar.write();
    write_whole(output, &bytes)?;
    println!("{}: {:.2} MB", output.display(), bytes.len() as f64 / 1e6);
    Ok(())
}
