//! Frames of a depth camera: 16-bit depth images, with colour images aligned to them if there are any.

use super::camera::Camera;
use super::capture::Frame;
use super::{read, read_error};
use crate::nearest::Neighbour;
use crate::normals::principal_frame;
use crease::numpy::ReadError;
use glam::Vec3A;
use image::DynamicImage;
use rayon::prelude::*;
use std::path::Path;

/// A normal is that of the plane of so many pixels around: sensors are noisier than neighbouring pixels are apart.
const NORMAL_RADIUS: i64 = 4;
/// Pixels lie on one surface where their depths differ by less than this for each pixel between them, metres …
const STEP: f32 = 0.012;
/// … and a pixel of a surface has at least this share of its neighbourhood on it; others fly between foreground and background.
const LEAST_SUPPORT: f32 = 0.35;
/// Surfaces seen at a smaller cosine say more about noise than about shape.
const LEAST_COSINE: f32 = 0.2;
/// c of μ = exp(−c z) (paper, below Eq. pose_dependent_offsets), 1/m.
const NEARNESS: f32 = 2.0;

/// Reads one frame: points in the world, normals towards the camera, colours, μ.
///
/// Flying pixels and grazing ones are dropped. μ is divided by its mean over the frame, so that the weight of all data against
/// smoothness does not hang on where the camera stands.
pub(super) fn read_frame(
    camera: &Camera,
    index: usize,
    depth_path: &Path,
    colour_path: Option<&Path>,
) -> Result<Frame, ReadError> {
    let depth = match decode(depth_path, camera)? {
        DynamicImage::ImageLuma16(image) => image.into_raw(),
        other => return Err(read_error(depth_path, "image", "16-bit greyscale", format!("{:?}", other.color()))),
    };
    let colours = colour_path.map(|path| Ok(decode(path, camera)?.into_rgb8().into_raw())).transpose()?;
    let (width, height) = (i64::from(camera.width), i64::from(camera.height));
    let grid: Vec<Vec3A> = (0..depth.len())
        .map(|pixel| {
            let metres = f32::from(depth[pixel]) * camera.depth_scale;
            camera.unproject((pixel as i64 % width) as f32, (pixel as i64 / width) as f32, metres)
        })
        .collect();
    let kept: Vec<(usize, Vec3A)> = (0..grid.len())
        .into_par_iter()
        .filter(|&pixel| depth[pixel] > 0)
        .filter_map(|pixel| Some((pixel, normal(&grid, width, height, pixel)?)))
        .collect();
    if kept.is_empty() {
        return Err(read_error(depth_path, "image", "a surface in front of the camera", "none".into()));
    }
    let world = &camera.world_from_camera;
    let mut weights: Vec<f32> = kept.iter().map(|&(pixel, _)| (-NEARNESS * grid[pixel].z).exp()).collect();
    let mean = weights.iter().sum::<f32>() / weights.len() as f32;
    weights.iter_mut().for_each(|weight| *weight /= mean);
    Ok(Frame {
        index,
        points: kept.iter().map(|&(pixel, _)| world.transform_point3a(grid[pixel])).collect(),
        normals: Some(kept.iter().map(|&(_, normal)| world.transform_vector3a(normal)).collect()),
        colours: colours
            .map(|rgb| kept.iter().map(|&(pixel, _)| std::array::from_fn(|c| rgb[3 * pixel + c])).collect()),
        weights,
        camera: Some(camera.clone()),
    })
}

/// Decodes an image of the camera's size.
fn decode(path: &Path, camera: &Camera) -> Result<DynamicImage, ReadError> {
    let bytes = read(path)?;
    let image = image::load_from_memory(&bytes)
        .map_err(|error| read_error(path, "image", "a PNG or JPEG image", error.to_string()))?;
    if (image.width(), image.height()) == (camera.width, camera.height) {
        return Ok(image);
    }
    let expected = format!("{} × {} as in camera.json", camera.width, camera.height);
    Err(read_error(path, "image", &expected, format!("{} × {}", image.width(), image.height())))
}

/// Unit normal at a pixel, towards the camera, in the camera's frame; nothing where the pixel lies on no surface.
fn normal(grid: &[Vec3A], width: i64, height: i64, pixel: usize) -> Option<Vec3A> {
    let (x, y) = (pixel as i64 % width, pixel as i64 / width);
    let own = grid[pixel];
    let mut neighbours = Vec::with_capacity(((2 * NORMAL_RADIUS + 1) * (2 * NORMAL_RADIUS + 1)) as usize);
    for dy in -NORMAL_RADIUS..=NORMAL_RADIUS {
        for dx in -NORMAL_RADIUS..=NORMAL_RADIUS {
            let (u, v) = (x + dx, y + dy);
            if !(0..width).contains(&u) || !(0..height).contains(&v) {
                continue;
            }
            let other = (v * width + u) as usize;
            let steps = dx.abs().max(dy.abs()).max(1) as f32;
            if grid[other].z > 0.0 && (grid[other].z - own.z).abs() < STEP * steps.sqrt() {
                neighbours.push(Neighbour { index: other as u32, squared_distance: grid[other].distance_squared(own) });
            }
        }
    }
    let whole = ((2 * NORMAL_RADIUS + 1) * (2 * NORMAL_RADIUS + 1)) as f32;
    if (neighbours.len() as f32) < LEAST_SUPPORT * whole {
        return None;
    }
    let [_, _, normal] = principal_frame(grid, own, &neighbours);
    let cosine = -normal.dot(own.normalize());
    let normal = if cosine < 0.0 { -normal } else { normal };
    (cosine.abs() >= LEAST_COSINE).then_some(normal)
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
        let frame = read_frame(&camera(), 0, &depth, Some(&colour)).unwrap();
        let centre = Vec3A::new(0.0, 1.0, 1.5);
        assert!(frame.points.len() > 2_000, "{}", frame.points.len());
        for (point, normal) in frame.points.iter().zip(frame.normals.as_ref().unwrap()) {
            assert!((point.distance(centre) - 0.4).abs() < 2e-3, "the flying pixel is gone: {point}");
            assert!(normal.dot((*point - centre).normalize()) > 0.97, "{normal} at {point}");
        }
        let nearest = (0..frame.points.len()).min_by(|&a, &b| frame.points[a].z.total_cmp(&frame.points[b].z)).unwrap();
        let [r, g, b] = frame.colours.unwrap()[nearest];
        assert!(r.abs_diff(60) < 4 && g.abs_diff(60) < 4 && b == 7);
        let mean = frame.weights.iter().sum::<f32>() / frame.weights.len() as f32;
        assert!((mean - 1.0).abs() < 1e-4 && frame.weights[nearest] > 1.0, "near points count more");
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
