//! Frames of a depth camera: 16-bit depth images, with colour images aligned to them if there are any.

use super::camera::Camera;
use super::capture::Frame;
use super::{read, read_error};
use crate::nearest::Neighbour;
use crate::normals::principal_frame;
use crease::memory::{Allowance, MemoryLimit};
use crease::numpy::ReadError;
use glam::{Vec3, Vec3A};
use image::{DynamicImage, ImageDecoder, ImageReader};
use rayon::prelude::*;
use std::io::Cursor;
use std::path::Path;

/// A normal is that of the plane of so many pixels around: sensors are noisier than neighbouring pixels are apart.
const NORMAL_RADIUS: i64 = 4;
/// Pixels lie on one surface where their depths differ by less than this for each pixel between them, metres …
const STEP: f32 = 0.012;
/// … and a pixel of a surface has at least this share of its neighbourhood on it; others fly between foreground and background.
const LEAST_SUPPORT: f32 = 0.35;
/// Surfaces seen at a smaller cosine say more about noise than about shape.
const LEAST_COSINE: f32 = 0.2;
/// The paper's c of μ = exp(−c z), 1/m.
pub const NEARNESS: f32 = 2.0;
/// For a capture of one's own: a full picture of four thousand by four thousand pixels may be read.
const CAPTURE_LIMIT: MemoryLimit = MemoryLimit { times_file: 4, plus: 1 << 30 };
/// What a pixel with a depth takes while its frame is made, bytes: 39 for point, normal, colour and μ, the rest on the way.
const PIXEL_BYTES: usize = 64;

/// An image file: its name for messages, and its bytes.
#[derive(Clone, Copy, Debug)]
pub struct ImageFile<'a> {
    /// Name for messages.
    pub name: &'a str,
    /// All of it.
    pub bytes: &'a [u8],
}

/// Reads the images of one frame, and decodes them.
pub(super) fn read_frame(
    camera: &Camera,
    index: usize,
    depth_path: &Path,
    colour_path: Option<&Path>,
) -> Result<Frame, ReadError> {
    let name = |path: &Path| path.display().to_string();
    let (depth_name, colour_name) = (name(depth_path), colour_path.map(name).unwrap_or_default());
    let (depth, colour) = (read(depth_path)?, colour_path.map(read).transpose()?);
    let colour = colour.as_ref().map(|bytes| ImageFile { name: &colour_name, bytes });
    decode_frame(camera, index, ImageFile { name: &depth_name, bytes: &depth }, colour, CAPTURE_LIMIT)
}

/// One frame of its images: points in the world, normals towards the camera, colours, μ.
///
/// Flying pixels and grazing ones are dropped. μ is divided by its mean over the frame, so that the weight of all data against
/// smoothness does not hang on where the camera stands.
///
/// Fails on images of other kinds or sizes than the camera's, where nothing is seen, and where the frame would take more memory than `limit`
/// gives its images.
pub fn decode_frame(
    camera: &Camera,
    index: usize,
    depth_file: ImageFile,
    colour_file: Option<ImageFile>,
    limit: MemoryLimit,
) -> Result<Frame, ReadError> {
    let error = |expected: &str, found: String| read_error(Path::new(depth_file.name), "image", expected, found);
    let length = depth_file.bytes.len() + colour_file.map_or(0, |file| file.bytes.len());
    let allowance = Allowance::new(limit, length);
    let depth = match decode(depth_file, camera, &allowance)? {
        DynamicImage::ImageLuma16(image) => image.into_raw(),
        other => return Err(error("16-bit greyscale", format!("{:?}", other.color()))),
    };
    let colours = colour_file.map(|file| Ok(decode(file, camera, &allowance)?.into_rgb8().into_raw())).transpose()?;
    let seen = depth.iter().filter(|&&depth| depth > 0).count();
    allowance
        .afford(PIXEL_BYTES.saturating_mul(seen))
        .map_err(|short| error(&short.expected, format!("{} for {seen} pixels with a depth", short.found)))?;
    let image = DepthImage { camera, depth: &depth };
    let kept: Vec<(u32, Vec3)> = (0..depth.len())
        .into_par_iter()
        .filter(|&pixel| depth[pixel] > 0)
        .filter_map(|pixel| Some((pixel as u32, image.normal(pixel)?.into())))
        .collect();
    if kept.is_empty() {
        return Err(error("a surface in front of the camera", "none".into()));
    }
    let world = &camera.world_from_camera;
    let points: Vec<Vec3A> =
        kept.iter().map(|&(pixel, _)| world.transform_point3a(image.point(pixel as usize))).collect();
    if let Some(far) = points.iter().find(|point| !point.is_finite()) {
        return Err(error("points that the camera puts at finite places", far.to_string()));
    }
    let mut frame = Frame {
        index,
        weights: vec![1.0; points.len()],
        points,
        normals: Some(kept.iter().map(|&(_, normal)| world.transform_vector3a(normal.into())).collect()),
        colours: colours
            .map(|rgb| kept.iter().map(|&(pixel, _)| std::array::from_fn(|c| rgb[3 * pixel as usize + c])).collect()),
        camera: Some(camera.clone()),
    };
    frame.weigh(NEARNESS);
    Ok(frame)
}

/// μ of depths in metres with c = `nearness`. Taken from the nearest on, as exp(−c z) alone is zero a few dozen metres away; its mean is 1 in any case.
pub(super) fn weights(depths: impl Iterator<Item = f32> + Clone, nearness: f32) -> Vec<f32> {
    let nearest = depths.clone().fold(f32::INFINITY, f32::min);
    let mut weights: Vec<f32> = depths.map(|depth| (-nearness * (depth - nearest)).exp()).collect();
    let mean = weights.iter().sum::<f32>() / weights.len() as f32;
    weights.iter_mut().for_each(|weight| *weight /= mean);
    weights
}

/// Decodes an image of the camera's size, which is looked at before anything is unpacked.
fn decode(file: ImageFile, camera: &Camera, allowance: &Allowance) -> Result<DynamicImage, ReadError> {
    let error = |expected: &str, found: String| read_error(Path::new(file.name), "image", expected, found);
    let broken = |problem: image::ImageError| error("a PNG or JPEG image", problem.to_string());
    let reader = ImageReader::new(Cursor::new(file.bytes));
    let mut reader = reader.with_guessed_format().map_err(|problem| broken(problem.into()))?;
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(allowance.left() as u64);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(broken)?;
    let (width, height) = decoder.dimensions();
    if (width, height) != (camera.width, camera.height) {
        let expected = format!("{} × {} as in camera.json", camera.width, camera.height);
        return Err(error(&expected, format!("{width} × {height}")));
    }
    let unpacked = usize::try_from(decoder.total_bytes()).unwrap_or(usize::MAX);
    allowance.hold(unpacked).map_err(|short| error(&short.expected, short.found))?;
    DynamicImage::from_decoder(decoder).map_err(broken)
}

/// Depths of all pixels, row by row, in the camera's units.
struct DepthImage<'a> {
    camera: &'a Camera,
    depth: &'a [u16],
}

impl DepthImage<'_> {
    /// What a pixel sees, in the camera's frame.
    fn point(&self, pixel: usize) -> Vec3A {
        let width = self.camera.width as usize;
        let metres = f32::from(self.depth[pixel]) * self.camera.depth_scale;
        self.camera.unproject((pixel % width) as f32, (pixel / width) as f32, metres)
    }

    /// Unit normal at a pixel, towards the camera, in the camera's frame; nothing where the pixel lies on no surface.
    fn normal(&self, pixel: usize) -> Option<Vec3A> {
        let (width, height) = (i64::from(self.camera.width), i64::from(self.camera.height));
        let (x, y) = (pixel as i64 % width, pixel as i64 / width);
        let own = self.point(pixel);
        let whole = ((2 * NORMAL_RADIUS + 1) * (2 * NORMAL_RADIUS + 1)) as usize;
        let (mut points, mut neighbours) = (Vec::with_capacity(whole), Vec::with_capacity(whole));
        for dy in -NORMAL_RADIUS..=NORMAL_RADIUS {
            for dx in -NORMAL_RADIUS..=NORMAL_RADIUS {
                let (u, v) = (x + dx, y + dy);
                if !(0..width).contains(&u) || !(0..height).contains(&v) {
                    continue;
                }
                let other = self.point((v * width + u) as usize);
                let steps = dx.abs().max(dy.abs()).max(1) as f32;
                if other.z > 0.0 && (other.z - own.z).abs() < STEP * steps.sqrt() {
                    let index = points.len() as u32;
                    neighbours.push(Neighbour { index, squared_distance: other.distance_squared(own) });
                    points.push(other);
                }
            }
        }
        if (neighbours.len() as f32) < LEAST_SUPPORT * whole as f32 {
            return None;
        }
        let [_, _, normal] = principal_frame(&points, own, &neighbours);
        let cosine = -normal.dot(own.normalize());
        let normal = if cosine < 0.0 { -normal } else { normal };
        (cosine.abs() >= LEAST_COSINE).then_some(normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Affine3A;
    use image::{ImageBuffer, Luma, Rgb};

    const SIZE: u32 = 120;

    fn camera() -> Camera {
        let world_from_camera = Affine3A::from_translation(glam::Vec3::new(0.0, 1.0, 0.0));
        Camera {
            width: SIZE,
            height: SIZE,
            focal: [120.0; 2],
            centre: [60.0; 2],
            depth_scale: 1e-3,
            world_from_camera,
            camera_from_world: world_from_camera.inverse(),
        }
    }

    /// A sphere of 40 cm, 1.5 m away, with a flying pixel before an empty background.
    fn sphere_depth() -> ImageBuffer<Luma<u16>, Vec<u16>> {
        let camera = camera();
        let centre = Vec3A::new(0.0, 0.0, 1.5);
        let mut image = ImageBuffer::from_fn(SIZE, SIZE, |u, v| {
            let ray = camera.unproject(u as f32, v as f32, 1.0).normalize();
            let along = ray.dot(centre);
            let root = along * along - centre.length_squared() + 0.4 * 0.4;
            let depth = if root > 0.0 { (along - root.sqrt()) * ray.z } else { 0.0 };
            Luma([(1000.0 * depth).round() as u16])
        });
        image.put_pixel(3, 3, Luma([900]));
        image
    }

    fn directory(name: &str) -> std::path::PathBuf {
        let path = std::env::temp_dir().join(format!("crease-depth-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        path
    }

    #[test]
    fn a_sphere_comes_back_with_normals_colours_and_weights() {
        let directory = directory("sphere");
        let (depth, colour) = (directory.join("0000.png"), directory.join("0000-colour.png"));
        sphere_depth().save(&depth).unwrap();
        ImageBuffer::from_fn(SIZE, SIZE, |u, v| Rgb([u as u8, v as u8, 7u8])).save(&colour).unwrap();
        let mut frame = read_frame(&camera(), 0, &depth, Some(&colour)).unwrap();
        let centre = Vec3A::new(0.0, 1.0, 1.5);
        assert!(frame.points.len() > 2_000, "{}", frame.points.len());
        for (point, normal) in frame.points.iter().zip(frame.normals.as_ref().unwrap()) {
            assert!((point.distance(centre) - 0.4).abs() < 2e-3, "the flying pixel is gone: {point}");
            assert!(normal.dot((*point - centre).normalize()) > 0.97, "{normal} at {point}");
        }
        let nearest = (0..frame.points.len()).min_by(|&a, &b| frame.points[a].z.total_cmp(&frame.points[b].z)).unwrap();
        let [r, g, b] = frame.colours.as_ref().unwrap()[nearest];
        assert!(r.abs_diff(60) < 4 && g.abs_diff(60) < 4 && b == 7);
        let mean = frame.weights.iter().sum::<f32>() / frame.weights.len() as f32;
        assert!((mean - 1.0).abs() < 1e-4 && frame.weights[nearest] > 1.0, "near points count more");
        frame.weigh(0.0);
        assert!(frame.weights.iter().all(|&weight| weight == 1.0), "and all alike where nearness does not");
        // As where millimetres are taken for metres.
        let far = weights([1500.0, 1501.0].into_iter(), NEARNESS);
        assert!((far[0] + far[1] - 2.0).abs() < 1e-5 && (far[0] / far[1] - (NEARNESS).exp()).abs() < 1e-3, "{far:?}");
        std::fs::remove_dir_all(&directory).unwrap();
    }

    #[test]
    fn other_images_are_refused() {
        let directory = directory("refused");
        let path = directory.join("0000.png");
        let refused = |found: &str| {
            let error = read_frame(&camera(), 0, &path, None).unwrap_err();
            assert!(error.file.ends_with("0000.png") && error.to_string().contains(found), "{error}");
        };
        ImageBuffer::from_pixel(SIZE, SIZE, Luma([9u8])).save(&path).unwrap();
        refused("16-bit");
        ImageBuffer::from_pixel(SIZE, 5, Luma([900u16])).save(&path).unwrap();
        refused("120 × 5");
        ImageBuffer::from_pixel(SIZE, SIZE, Luma([0u16])).save(&path).unwrap();
        refused("a surface in front");
        std::fs::write(&path, b"not an image").unwrap();
        refused("PNG or JPEG");
        std::fs::remove_dir_all(&directory).unwrap();
    }
}
