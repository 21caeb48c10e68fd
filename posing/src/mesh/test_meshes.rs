//! Meshes that tests are made on.

use super::{Mesh, Subdivision, Triangle};
use glam::{Vec3A, vec3a};
use std::f32::consts::TAU;

/// A regular icosahedron of unit circumradius.
pub fn icosahedron() -> Mesh {
    let golden = (1.0 + 5f32.sqrt()) / 2.0;
    let mut positions = Vec::new();
    for (a, b) in [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)] {
        positions.extend([vec3a(0.0, a, b), vec3a(a, b, 0.0), vec3a(b, 0.0, a)].map(Vec3A::normalize));
    }
    // Faces are the triples at mutual edge distance, turned outward.
    let edge = 4.0 / (1.0 + golden * golden);
    let near = |i: usize, j: usize| (positions[i].distance_squared(positions[j]) - edge).abs() < 1e-3;
    let mut triangles = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(i, j) && near(j, k) && near(i, k) {
                    triangles.push(outward(&positions, [i as u32, j as u32, k as u32]));
                }
            }
        }
    }
    Mesh { positions, triangles }
}

/// A cube of side 2 about the origin, two triangles a face.
pub fn cube() -> Mesh {
    let positions: Vec<Vec3A> =
        (0..8).map(|i| vec3a(f(i & 1), f(i >> 1 & 1), f(i >> 2 & 1)) * 2.0 - Vec3A::ONE).collect();
    let mut triangles = Vec::new();
    for axis in 0..3 {
        let (u, v) = (1u32 << ((axis + 1) % 3), 1u32 << ((axis + 2) % 3));
        for side in [0, 1u32 << axis] {
            triangles.push(outward(&positions, [side, side + u, side + u + v]));
            triangles.push(outward(&positions, [side, side + u + v, side + v]));
        }
    }
    Mesh { positions, triangles }
}

/// The icosahedron subdivided `levels` times at edge midpoints, vertices pushed onto the unit sphere.
pub fn icosphere(levels: usize) -> Mesh {
    let mut mesh = icosahedron();
    for _ in 0..levels {
        mesh = subdivided(&mesh, super::Scheme::Midpoint);
        mesh.positions.iter_mut().for_each(|p| *p = p.normalize());
    }
    mesh
}

/// A torus of radii 0.3 m and 0.12 m about the y axis, `around` × `across` vertices.
pub fn torus(around: u32, across: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..around {
        for j in 0..across {
            let (u, v) = (TAU * f(i) / f(around), TAU * f(j) / f(across));
            let radius = 0.3 + 0.12 * v.cos();
            mesh.positions.push(vec3a(radius * u.cos(), 0.12 * v.sin(), radius * u.sin()));
            let at = |di, dj| (i + di) % around * across + (j + dj) % across;
            mesh.triangles.push([at(0, 0), at(0, 1), at(1, 1)]);
            mesh.triangles.push([at(0, 0), at(1, 1), at(1, 0)]);
        }
    }
    mesh
}

/// An open sheet of `columns` × `rows` unit squares in the plane z = 0, facing +z; vertices row by row.
pub fn grid(columns: u32, rows: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for y in 0..=rows {
        for x in 0..=columns {
            mesh.positions.push(vec3a(f(x), f(y), 0.0));
            if x < columns && y < rows {
                let at = |dx, dy| (y + dy) * (columns + 1) + x + dx;
                mesh.triangles.push([at(0, 0), at(1, 0), at(1, 1)]);
                mesh.triangles.push([at(0, 0), at(1, 1), at(0, 1)]);
            }
        }
    }
    mesh
}

/// `mesh` subdivided once.
pub fn subdivided(mesh: &Mesh, scheme: super::Scheme) -> Mesh {
    let subdivision = Subdivision::new(mesh.positions.len(), &mesh.triangles, 1);
    let mut positions = vec![Vec3A::ZERO; subdivision.vertex_count(1)];
    subdivision.refine(scheme, 0, &mesh.positions, &mut positions);
    Mesh { positions, triangles: subdivision.triangles(1).to_vec() }
}

/// A value in −0.5 .. 0.5 from a counter: noise that is the same everywhere.
pub fn noise(counter: u32) -> f32 {
    let mut x = counter.wrapping_mul(0x9E37_79B9) ^ 0x85EB_CA6B;
    for shift in [16, 13, 16] {
        x = (x ^ x >> shift).wrapping_mul(0xC2B2_AE35);
    }
    (x >> 8) as f32 / (1 << 24) as f32 - 0.5
}

/// A noise vector for each of `count` vertices.
pub fn noise_vectors(count: usize, seed: u32) -> Vec<Vec3A> {
    (0..count as u32).map(|i| Vec3A::from_array([0, 1, 2].map(|c| noise(seed + 3 * i + c)))).collect()
}

fn outward(positions: &[Vec3A], [a, b, c]: Triangle) -> Triangle {
    let [p, q, r] = [a, b, c].map(|i| positions[i as usize]);
    if (q - p).cross(r - p).dot(p + q + r) > 0.0 { [a, b, c] } else { [a, c, b] }
}

fn f(x: u32) -> f32 {
    x as f32
}
