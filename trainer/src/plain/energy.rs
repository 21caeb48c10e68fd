//! E_d: how well posed base meshes fit their scans (paper Eqs. pose_dependent_offsets, base_reg, reliable_anchor).
//!
//! All distances are squared, in m². Each sum is divided by the number of its terms, so that the weights do not depend on how many
//! points, vertices, anchors or frames there are.

use super::gather::Rows;
use super::rows_of;
use crate::closest::ClosestPoint;
use crate::nearest::NearestPoints;
use crate::sequence::Camera;
use crate::visibility::visible_vertices;
use burn::tensor::{Device, Tensor, TensorData};
use crease::mesh::{Adjacency, Triangle};
use glam::Vec3A;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use std::sync::Arc;

/// Weights of the terms of E_d against the scan-to-mesh term.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    /// λ_r.
    pub regulariser: f32,
    /// λ_a.
    pub anchor: f32,
    /// Of the distance from every vertex to the scan.
    pub mesh_to_scan: f32,
}

/// A scan that a mesh is fitted to.
pub(super) struct Scan {
    /// Points that pull the mesh.
    points: Vec<Vec3A>,
    /// μ of each of `points`.
    weights: Vec<f32>,
    /// The whole scan, which the mesh is pulled to.
    cloud: Arc<Cloud>,
    /// The camera, where the scan is the view of one: what it does not see of the mesh is not pulled.
    camera: Option<Camera>,
}

struct Cloud {
    points: Vec<Vec3A>,
    nearest: NearestPoints,
}

impl Scan {
    /// `points` are metres, `weights` their μ.
    pub(super) fn new(points: Vec<Vec3A>, weights: Vec<f32>, camera: Option<Camera>) -> Self {
        let cloud = Arc::new(Cloud { nearest: NearestPoints::new(&points), points: points.clone() });
        Self { points, weights, cloud, camera }
    }

    /// In memory, about; the search tree takes as much as its points.
    pub(super) fn bytes(&self) -> usize {
        let own = size_of_val(self.points.as_slice()) + size_of_val(self.weights.as_slice());
        own + 2 * size_of_val(self.cloud.points.as_slice())
    }

    /// The same scan with `count` of its points pulling, drawn with replacement.
    pub(super) fn drawn(&self, count: usize, generator: &mut Pcg64Mcg) -> Self {
        let drawn: Vec<usize> = (0..count).map(|_| generator.random_range(0..self.points.len())).collect();
        Self {
            points: drawn.iter().map(|&index| self.points[index]).collect(),
            weights: drawn.iter().map(|&index| self.weights[index]).collect(),
            cloud: Arc::clone(&self.cloud),
            camera: self.camera.clone(),
        }
    }

    /// The scan's point nearest to `source`.
    fn nearest(&self, source: Vec3A) -> Vec3A {
        self.cloud.points[self.cloud.nearest.one(source).index as usize]
    }
}

/// What E_d needs of the mesh: constant while training.
pub(super) struct Energy {
    triangles: Vec<Triangle>,
    vertex_count: usize,
    /// L = I − D⁻¹A.
    umbrella: Rows,
    /// Anchors as sums of vertices.
    anchors: Rows,
    vertices: Rows,
    weights: Weights,
}

impl Energy {
    pub(super) fn new(triangles: &[Triangle], adjacency: &Adjacency, anchors: Rows, weights: Weights) -> Self {
        let vertex_count = adjacency.offsets.len() - 1;
        let umbrella: Vec<Vec<(u32, f32)>> = (0..vertex_count)
            .map(|k| {
                let neighbours = adjacency.of(k);
                let share = -1.0 / neighbours.len().max(1) as f32;
                // A vertex without neighbours has no Laplacian.
                let own = if neighbours.is_empty() { 0.0 } else { 1.0 };
                std::iter::once((k as u32, own)).chain(neighbours.iter().map(|&j| (j, share))).collect()
            })
            .collect();
        Self {
            triangles: triangles.to_vec(),
            vertex_count,
            umbrella: Rows::new(&umbrella),
            anchors,
            vertices: Rows::identity(vertex_count),
            weights,
        }
    }

    /// E_d of posed vertices (frames · vertices, 3), frame after frame. `positions` are the same numbers on the CPU: correspondences are
    /// found there, and gradients flow through the vertices they weigh. (Where a closest point slides along the surface, its derivative
    /// does not count: the gap is at right angles to the slide.)
    ///
    /// Fails on a mesh without triangles.
    pub(super) fn evaluate(
        &self,
        posed: &Tensor<2>,
        positions: &[Vec3A],
        scans: &[&Scan],
    ) -> anyhow::Result<Tensor<1>> {
        let device = posed.device();
        let frames: Vec<&[Vec3A]> = positions.chunks_exact(self.vertex_count).collect();
        let mut pull = Pull::default();
        let hits: Vec<_> = frames
            .par_iter()
            .zip(scans)
            .map(|(frame, scan)| Ok(ClosestPoint::new(frame, &self.triangles)?.query_all(&scan.points)))
            .collect::<anyhow::Result<_>>()?;
        for (frame, (hits, scan)) in hits.iter().zip(scans).enumerate() {
            let offset = (frame * self.vertex_count) as u32;
            let share = 1.0 / (scan.points.len() * scans.len()) as f32;
            for ((hit, &point), &weight) in hits.iter().zip(&scan.points).zip(&scan.weights) {
                let corners = self.triangles[hit.triangle as usize].map(|corner| corner + offset);
                pull.rows.push_triangle(corners, hit.barycentric);
                pull.targets.push(point);
                pull.weights.push(weight * share);
            }
        }
        let mut total = pull.energy(posed, &device);

        if self.weights.regulariser > 0.0 {
            let mut umbrella = Rows::default();
            for frame in 0..scans.len() {
                umbrella.append(&self.umbrella, frame * self.vertex_count);
            }
            let squares = umbrella.apply(posed.clone(), &device).square().sum();
            total = total + squares * (self.weights.regulariser / (self.vertex_count * scans.len()) as f32);
        }
        for (rows, weight) in [(&self.anchors, self.weights.anchor), (&self.vertices, self.weights.mesh_to_scan)] {
            if weight > 0.0 && rows.count() > 0 {
                total = total + self.to_scans(rows, &frames, scans).energy(posed, &device) * weight;
            }
        }
        Ok(total)
    }

    /// Pulls each of `rows` of every frame to its nearest scan point (paper Eq. reliable_anchor: those that the camera sees).
    fn to_scans(&self, rows: &Rows, frames: &[&[Vec3A]], scans: &[&Scan]) -> Pull {
        let mut pull = Pull::default();
        for (index, (frame, scan)) in frames.iter().zip(scans).enumerate() {
            pull.rows.append(rows, index * self.vertex_count);
            let sources = rows.apply_slice(frame);
            let nearest = sources.par_iter().map(|&source| scan.nearest(source));
            pull.targets.extend(nearest.collect::<Vec<_>>());
            let seen = self.seen(rows, frame, scan);
            let share = 1.0 / (seen.iter().filter(|&&seen| seen).count().max(1) * scans.len()) as f32;
            pull.weights.extend(seen.iter().map(|&seen| if seen { share } else { 0.0 }));
        }
        pull
    }

    /// Which of `rows` the scan's camera sees on a frame's mesh; all where the scan is whole.
    fn seen(&self, rows: &Rows, frame: &[Vec3A], scan: &Scan) -> Vec<bool> {
        let Some(camera) = &scan.camera else { return vec![true; rows.count()] };
        let seen = visible_vertices(camera, frame, &self.triangles);
        let shares: Vec<Vec3A> = seen.iter().map(|&seen| if seen { Vec3A::ONE } else { Vec3A::ZERO }).collect();
        rows.apply_slice(&shares).iter().map(|share| share.x > 0.5).collect()
    }
}

/// Surface points pulled to fixed targets.
#[derive(Default)]
struct Pull {
    rows: Rows,
    targets: Vec<Vec3A>,
    weights: Vec<f32>,
}

impl Pull {
    /// Σ weight |surface − target|².
    fn energy(&self, posed: &Tensor<2>, device: &Device) -> Tensor<1> {
        let count = self.targets.len();
        let targets = rows_of(self.targets.iter().copied(), device);
        let weights = Tensor::<2>::from_data(TensorData::new(self.weights.clone(), [count, 1]), device);
        ((self.rows.apply(posed.clone(), device) - targets).square() * weights).sum()
    }
}

#[cfg(test)]
mod tests;
