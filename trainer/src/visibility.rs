//! What a camera sees of a mesh: a depth buffer, rasterised on the processor.

use crate::sequence::Camera;
use crease::mesh::{Triangle, vertex_normals};
use glam::Vec3A;

/// A surface hides what is farther behind it than this, metres.
const DEPTH_TOLERANCE: f32 = 0.01;
/// Vertices whose normal makes a smaller cosine with the direction to the camera count as seen from behind.
const LEAST_COSINE: f32 = 0.1;

/// Depth of the nearest surface at each pixel.
pub struct DepthBuffer<'a> {
    camera: &'a Camera,
    /// Metres along the optical axis, row by row; infinite where nothing is.
    pub depths: Vec<f32>,
}

impl<'a> DepthBuffer<'a> {
    /// Renders a mesh (metres, world). Triangles that reach behind the camera are left out.
    pub fn render(camera: &'a Camera, positions: &[Vec3A], triangles: &[Triangle]) -> Self {
        let projected: Vec<Option<[f32; 3]>> = positions.iter().map(|&position| camera.project(position)).collect();
        let mut buffer = Self { camera, depths: vec![f32::INFINITY; (camera.width * camera.height) as usize] };
        for triangle in triangles {
            if let [Some(a), Some(b), Some(c)] = triangle.map(|vertex| projected[vertex as usize]) {
                buffer.fill(a, b, c);
            }
        }
        buffer
    }

    /// Fills one triangle of (u, v, depth). Along a plane the reciprocal of depth is linear in pixels.
    fn fill(&mut self, a: [f32; 3], b: [f32; 3], c: [f32; 3]) {
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area.abs() < 1e-9 {
            return;
        }
        let range = |axis: usize, count: u32| {
            let least = a[axis].min(b[axis]).min(c[axis]).ceil().max(0.0);
            let greatest = a[axis].max(b[axis]).max(c[axis]).floor().min(count as f32 - 1.0);
            (least as i64, greatest as i64)
        };
        let (left, right) = range(0, self.camera.width);
        let (top, bottom) = range(1, self.camera.height);
        for v in top..=bottom {
            for u in left..=right {
                let (x, y) = (u as f32, v as f32);
                let wb = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area;
                let wc = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area;
                let wa = 1.0 - wb - wc;
                if wa < 0.0 || wb < 0.0 || wc < 0.0 {
                    continue;
                }
                let depth = 1.0 / (wa / a[2] + wb / b[2] + wc / c[2]);
                let pixel = &mut self.depths[(v * i64::from(self.camera.width) + u) as usize];
                *pixel = pixel.min(depth);
            }
        }
    }

    /// Whether nothing stands between the camera and `point`, and the image holds it.
    pub fn is_visible(&self, point: Vec3A) -> bool {
        let Some([u, v, depth]) = self.camera.project(point) else { return false };
        let (u, v) = (u.round(), v.round());
        let inside = u >= 0.0 && v >= 0.0 && u < self.camera.width as f32 && v < self.camera.height as f32;
        inside && depth <= self.depths[v as usize * self.camera.width as usize + u as usize] + DEPTH_TOLERANCE
    }
}

/// Which vertices of a closed mesh with outward triangles the camera sees.
pub fn visible_vertices(camera: &Camera, positions: &[Vec3A], triangles: &[Triangle]) -> Vec<bool> {
    let buffer = DepthBuffer::render(camera, positions, triangles);
    let mut normals = vec![Vec3A::ZERO; positions.len()];
    vertex_normals(positions, triangles, &mut normals);
    let eye = camera.position();
    let facing = |position: Vec3A, normal: Vec3A| normal.dot((eye - position).normalize_or_zero()) > LEAST_COSINE;
    let seen = positions.iter().zip(&normals).map(|(&p, &n)| facing(p, n) && buffer.is_visible(p));
    seen.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::sphere;
    use glam::{Affine3A, Vec3};

    #[test]
    fn the_near_side_is_seen_and_what_stands_behind_is_not() {
        let world_from_camera = Affine3A::from_translation(Vec3::new(0.0, 0.0, -3.0));
        let camera = Camera {
            width: 800,
            height: 800,
            focal: [800.0; 2],
            centre: [400.0; 2],
            depth_scale: 1e-3,
            world_from_camera,
            camera_from_world: world_from_camera.inverse(),
        };
        let near = sphere(0.5, 3);
        let count = near.positions.len();
        let mut positions = near.positions.clone();
        positions.extend(near.positions.iter().map(|&p| 0.4 * p + Vec3A::Z * 1.5));
        let mut triangles = near.triangles.clone();
        triangles.extend(near.triangles.iter().map(|triangle| triangle.map(|v| v + count as u32)));
        let seen = visible_vertices(&camera, &positions, &triangles);
        for (position, &seen) in near.positions.iter().zip(&seen) {
            let cosine = position.normalize().dot((camera.position() - *position).normalize());
            // At a grazing angle the surface is deeper at a neighbouring pixel than the tolerance.
            if !(0.05..0.35).contains(&cosine) {
                assert_eq!(seen, cosine > LEAST_COSINE, "{position}");
            }
        }
        assert!(seen[count..].iter().all(|&seen| !seen), "the small sphere is hidden by the large one");
        let alone = visible_vertices(&camera, &positions[count..], &near.triangles);
        assert!(alone.iter().any(|&seen| seen), "and is seen without it");
        let middle = DepthBuffer::render(&camera, &near.positions, &near.triangles).depths[400 * 800 + 400];
        assert!((middle - 2.5).abs() < 4e-3, "{middle}");
    }
}
