//! `crease render`.

use super::read_avatar;
use super::shown::Shown;
use anyhow::{Context, bail, ensure};
use clap::{Args, ValueEnum};
use crease::animate::Animator;
use crease::motion::Motion;
use crease::render::{Follow, Scene, Theme, View};
use crease_trainer::files::write_whole;
use crease_trainer::normals::unit_normals;
use crease_trainer::progress::Progress;
use crease_trainer::sequence::read;
use crease_trainer::studio::Studio;
use image::{ImageFormat, RgbaImage};
use std::fs;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;

/// Endings of films, which ffmpeg writes.
const FILMS: [&str; 3] = ["mp4", "webm", "mov"];

#[derive(Args)]
pub struct Arguments {
    /// The avatar (.glb)
    pub avatar: PathBuf,
    /// The motion: AIST++ .pkl, AMASS or SMPL-X-style .npz
    pub motion: PathBuf,
    /// A film (.mp4, .webm or .mov, written by ffmpeg), or a directory of PNG pictures
    #[arg(short, long, value_name = "FILE or DIRECTORY")]
    pub output: PathBuf,
    /// The motion's frames a second: needed where the file does not say, and stronger where it does
    #[arg(long)]
    pub fps: Option<f32>,
    /// Pictures a second
    #[arg(long, default_value_t = 30.0)]
    pub picture_rate: f32,
    /// Pixels; even numbers for films
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "720x900", value_parser = parse_size)]
    pub size: [u32; 2],
    #[command(flatten)]
    pub shown: Shown,
    /// What the surface's colours tell
    #[arg(long, value_enum, default_value_t = ViewName::Lit)]
    pub view: ViewName,
    /// A dark studio
    #[arg(long)]
    pub dark: bool,
    /// Degrees about the vertical by which the eye stands from the front (+z) to the left of the figure (+x)
    #[arg(long, default_value_t = 20.0, allow_negative_numbers = true)]
    pub azimuth: f32,
    /// Degrees above the horizon
    #[arg(long, default_value_t = 7.0, allow_negative_numbers = true)]
    pub elevation: f32,
    /// Metres from the figure
    #[arg(long, default_value_t = 4.9)]
    pub distance: f32,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum ViewName {
    /// Cloth under light
    Lit,
    /// Clay, and the mesh's edges
    Wireframe,
    /// Normals as colours
    Normals,
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let sides: Vec<u32> = text.split('x').filter_map(|side| side.trim().parse().ok()).collect();
    match sides[..] {
        [width, height] if width > 0 && height > 0 && text.matches('x').count() == 1 => Ok([width, height]),
        _ => Err("expected two whole numbers of pixels, such as 720x900".into()),
    }
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let options = arguments.shown.options()?;
    ensure!(
        arguments.picture_rate.is_finite() && arguments.picture_rate > 0.0,
        "--picture-rate: expected a positive number, found {}",
        arguments.picture_rate
    );
    let avatar = Arc::new(read_avatar(&arguments.avatar)?);
    let motion = Motion::read(&read(&arguments.motion)?, &arguments.motion.display().to_string(), arguments.fps)?;
    for note in &motion.notes {
        eprintln!("note: {note}");
    }
    let studio = Studio::open()?;
    let mut film = Film::open(&arguments.output, arguments.size, arguments.picture_rate)?;
    let mut animator = Animator::new(Arc::clone(&avatar))?;
    let triangles = animator.triangles().to_vec();
    let mut figure = studio.dressed(&animator)?;
    let mut scene = scene(arguments);
    let seconds = motion.loop_duration();
    let count = ((seconds * arguments.picture_rate) as usize).max(1);
    let bar = Progress::Bars.bar("drawing", count);
    for index in 0..count {
        let time = index as f32 / arguments.picture_rate;
        let pose = motion.sample(time);
        let positions = animator.animate(&pose, &options);
        let normals = unit_normals(positions, &triangles);
        scene.set_figure(positions, &normals, 0);
        scene.camera.follow(avatar.rig.root(&pose));
        if index == 0 {
            scene.camera.jump();
        } else {
            scene.camera.advance(1.0 / arguments.picture_rate);
        }
        film.add(index, &figure.picture(&scene, arguments.size)?)?;
        bar.advance(1);
    }
    drop(bar);
    film.finish()?;
    println!("{}: {count} pictures, drawn with {}", arguments.output.display(), studio.adapter());
    Ok(())
}

fn scene(arguments: &Arguments) -> Scene {
    let mut scene = Scene::default();
    let [azimuth, elevation] = [arguments.azimuth, arguments.elevation].map(f32::to_radians);
    scene.camera.set_orbit(Some(azimuth), Some(elevation), Some(arguments.distance), 1.0);
    scene.camera.set_follow(Follow::Soft);
    scene.view = match arguments.view {
        ViewName::Lit => View::Lit,
        ViewName::Wireframe => View::Wireframe,
        ViewName::Normals => View::Normals,
    };
    if arguments.dark {
        scene.theme = Theme::DARK;
    }
    scene
}

/// Where pictures go.
enum Film {
    Directory(PathBuf),
    /// Written aside, and renamed when it is whole.
    Ffmpeg {
        process: Child,
        aside: PathBuf,
        path: PathBuf,
    },
}

impl Film {
    fn open(path: &Path, [width, height]: [u32; 2], rate: f32) -> anyhow::Result<Self> {
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        if !FILMS.contains(&ending) {
            ensure!(
                ending.is_empty() || path.is_dir(),
                "{}: expected a directory, or a film that ends in {}, found .{ending}",
                path.display(),
                FILMS.join(", ")
            );
            return Ok(Self::Directory(path.to_owned()));
        }
        ensure!(width % 2 == 0 && height % 2 == 0, "--size: expected even numbers for a film, found {width}x{height}");
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        fs::create_dir_all(folder).with_context(|| format!("{}: cannot make the directory", folder.display()))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let aside = folder.join(format!(".{}.part.{name}", std::process::id()));
        let process = Command::new("ffmpeg")
            .args(["-y", "-loglevel", "error", "-f", "rawvideo", "-pixel_format", "rgba"])
            .args(["-video_size", &format!("{width}x{height}"), "-framerate", &rate.to_string(), "-i", "-"])
            .args(["-pix_fmt", "yuv420p"])
            .arg(&aside)
            .stdin(Stdio::piped())
            .spawn()
            .with_context(|| {
                format!("{}: ffmpeg, which writes films, cannot be started; install it, or name a directory for PNG pictures", path.display())
            })?;
        Ok(Self::Ffmpeg { process, aside, path: path.to_owned() })
    }

    fn add(&mut self, index: usize, picture: &RgbaImage) -> anyhow::Result<()> {
        match self {
            Self::Directory(directory) => {
                let mut bytes = Cursor::new(Vec::new());
                picture.write_to(&mut bytes, ImageFormat::Png)?;
                write_whole(&directory.join(format!("{index:05}.png")), bytes.get_ref())
            }
            Self::Ffmpeg { process, path, .. } => {
                // Before it is written to: a broken pipe would end this process without a word.
                if let Some(status) = process.try_wait()? {
                    bail!("{}: ffmpeg stopped ({status})", path.display());
                }
                let pipe = process.stdin.as_mut().context("ffmpeg takes no pictures")?;
                pipe.write_all(picture).with_context(|| format!("{}: ffmpeg stopped", path.display()))
            }
        }
    }

    fn finish(mut self) -> anyhow::Result<()> {
        let Self::Ffmpeg { process, aside, path } = &mut self else { return Ok(()) };
        drop(process.stdin.take());
        let status = process.wait()?;
        ensure!(status.success(), "{}: ffmpeg could not write it ({status})", path.display());
        fs::rename(aside, &*path).with_context(|| format!("{}: cannot be written", path.display()))
    }
}

impl Drop for Film {
    /// Nothing half-written stays.
    fn drop(&mut self) {
        if let Self::Ffmpeg { process, aside, .. } = self {
            drop(process.stdin.take());
            // It may be over already, and its file renamed.
            let _ = process.wait();
            let _ = fs::remove_file(aside);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_two_numbers() {
        assert_eq!(parse_size("720x900"), Ok([720, 900]));
        for wrong in ["720", "0x10", "axb", "1x2x3", "-1x5"] {
            assert!(parse_size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn an_output_of_an_unknown_kind_is_refused_before_anything_is_drawn() {
        let Err(error) = Film::open(Path::new("out.gif"), [10, 10], 30.0) else { panic!("a film of another kind") };
        assert!(error.to_string().contains(".gif"));
        let Err(error) = Film::open(Path::new("out.mp4"), [11, 10], 30.0) else { panic!("odd sizes have no film") };
        assert!(error.to_string().contains("11x10"));
    }
}
