//! Meshes and clouds with known answers, for tests.

use crate::sampling::generator;
use crease::mesh::Mesh;
use glam::Vec3A;
use rand::RngExt;
use std::collections::HashMap;

/// An icosahedron subdivided `level` times, on the sphere of `radius`; outward triangles.
pub fn sphere(radius: f32, level: usize) -> Mesh {
    let g = (1.0 + 5f32.sqrt()) / 2.0;
    let corners = [
        [-1.0, g, 0.0],
        [1.0, g, 0.0],
        [-1.0, -g, 0.0],
        [1.0, -g, 0.0],
        [0.0, -1.0, g],
        [0.0, 1.0, g],
        [0.0, -1.0, -g],
        [0.0, 1.0, -g],
        [g, 0.0, -1.0],
        [g, 0.0, 1.0],
        [-g, 0.0, -1.0],
        [-g, 0.0, 1.0],
    ];
    let mut positions: Vec<Vec3A> =
        corners.iter().map(|&corner| Vec3A::from_array(corner).normalize() * radius).collect();
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..level {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let point = (positions[a as usize] + positions[b as usize]).normalize() * radius;
                positions.push(point);
                positions.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    Mesh { positions, triangles }
}

/// `count` points spread uniformly over the sphere of `radius`.
pub fn sphere_points(count: usize, radius: f32, seed: u64) -> Vec<Vec3A> {
    let mut generator = generator(seed);
    (0..count)
        .map(|_| {
            let y: f32 = generator.random_range(-1.0..1.0);
            let angle = generator.random_range(0.0..std::f32::consts::TAU);
            let ring = (1.0 - y * y).sqrt();
            Vec3A::new(ring * angle.cos(), y, ring * angle.sin()) * radius
        })
        .collect()
}
