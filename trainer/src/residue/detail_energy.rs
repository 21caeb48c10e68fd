//! How much of the true surface's detail a surface has: a smooth surface scores well in normals, and looks dead.

use super::body_part::{BODY_PARTS, BodyPart};
use crate::compact::{FitOptions, OrientedScan, fit_surface};
use crate::sequence::GroundTruth;
use crate::targets::operator_laplacian;
use crease::mesh::{Adjacency, Scheme, Subdivision};
use glam::Vec3A;

/// Root mean square of the operator Laplacian of what lies between base and surface, 1/m.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct DetailEnergy {
    /// Of the detailed mesh.
    pub own_per_metre: f64,
    /// Of the finest mesh fitted to the ground truth.
    pub true_per_metre: f64,
}

/// Measures detail on one avatar's topology.
pub struct DetailMeter<'a> {
    subdivision: &'a Subdivision,
    scheme: Scheme,
    adjacency: Adjacency,
    fit: FitOptions,
    /// δ beyond this comes from degenerate triangles, 1/m.
    clamp: f32,
}

impl<'a> DetailMeter<'a> {
    /// For surfaces over the finest level of `subdivision`, whose ground truth is fitted with `fit`.
    pub fn new(subdivision: &'a Subdivision, scheme: Scheme, fit: FitOptions, clamp: f32) -> Self {
        let finest = subdivision.level_count();
        let adjacency = Adjacency::new(subdivision.vertex_count(finest), subdivision.triangles(finest));
        Self { subdivision, scheme, adjacency, fit, clamp }
    }

    /// Squares of δ, summed over the vertices of each part of the body: of `detailed` and of the truth, and how many vertices.
    pub fn squares(
        &self,
        base: &[Vec3A],
        detailed: &[Vec3A],
        truth: &GroundTruth,
        parts: &[BodyPart],
    ) -> anyhow::Result<[[f64; 3]; BODY_PARTS.len()]> {
        let scan =
            OrientedScan { points: &truth.points, normals: &truth.normals, weights: &vec![1.0; truth.points.len()] };
        let finest = self.subdivision.level_count();
        let fitted = fit_surface(self.subdivision, &self.adjacency, self.scheme, finest, base, base, &scan, &self.fit)?;
        let mut squares = [[0.0; 3]; BODY_PARTS.len()];
        for (column, surface) in [detailed, &fitted].into_iter().enumerate() {
            let displacement: Vec<Vec3A> = surface.iter().zip(base).map(|(&surface, &base)| surface - base).collect();
            let triangles = self.subdivision.triangles(finest);
            let delta = operator_laplacian(&self.adjacency, triangles, base, &displacement);
            for (delta, part) in delta.iter().zip(parts) {
                squares[*part as usize][column] += f64::from(delta.clamp_length_max(self.clamp).length_squared());
            }
        }
        for part in parts {
            squares[*part as usize][2] += 1.0;
        }
        Ok(squares)
    }
}

/// The roots of the means of what [`DetailMeter::squares`] gave.
pub fn energy([own, truth, count]: [f64; 3]) -> DetailEnergy {
    let root = |squares: f64| (squares / count.max(1.0)).sqrt();
    DetailEnergy { own_per_metre: root(own), true_per_metre: root(truth) }
}
