//! Ground-truth Laplacians of a point cloud by local quadratic fits (paper, GT Laplacian coordinates approximation; Liang & Zhao 2012).

use crate::nearest::{NearestPoints, Neighbour};
use crate::normals::principal_frame;
use crate::options::{Neighbourhood, QuadraticOptions};
use glam::Vec3A;
use rayon::prelude::*;
use std::num::NonZero;

/// Coefficients of the quadratic: z = a1 + a2 x + a3 y + a4 x² + a5 xy + a6 y².
const COEFFICIENT_COUNT: usize = 6;

/// The surface near a scan point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadraticFit {
    /// δ = −Δx, 1/m: outward and 2/R long on a sphere. The sign does not depend on that of the normal.
    pub laplacian: Vec3A,
    /// Unit normal of the fitted surface; its sign is arbitrary.
    pub normal: Vec3A,
}

/// Fits a quadratic to the neighbourhood of each of `points` (metres).
///
/// Nothing where a neighbourhood has fewer than six points or does not span a surface.
pub fn fit_quadratics(points: &[Vec3A], options: &QuadraticOptions) -> Vec<Option<QuadraticFit>> {
    if points.is_empty() {
        return Vec::new();
    }
    let nearest = NearestPoints::new(points);
    points
        .par_iter()
        .with_min_len(256)
        .map(|&point| {
            let (neighbours, radius) = neighbourhood(&nearest, point, options.neighbourhood)?;
            let fit = fit(points, point, &neighbours, radius)?;
            Some(QuadraticFit { laplacian: fit.laplacian.clamp_length_max(options.clamp), ..fit })
        })
        .collect()
}

/// The neighbours of a point and the distance to the farthest that there could be.
fn neighbourhood(nearest: &NearestPoints, point: Vec3A, which: Neighbourhood) -> Option<(Vec<Neighbour>, f32)> {
    match which {
        Neighbourhood::Radius(radius) => Some((nearest.within(point, radius), radius)),
        Neighbourhood::Nearest(count) => {
            let neighbours = nearest.several(point, NonZero::new(count)?);
            let radius = neighbours.last()?.squared_distance.sqrt();
            Some((neighbours, radius))
        }
    }
}

/// Weighted fit with weights exp(−d²/h²), h = `radius`; coordinates are scaled by the radius so that the equations are well-conditioned.
fn fit(points: &[Vec3A], point: Vec3A, neighbours: &[Neighbour], radius: f32) -> Option<QuadraticFit> {
    if neighbours.len() < COEFFICIENT_COUNT || radius <= 0.0 {
        return None;
    }
    let [first, second, normal] = principal_frame(points, point, neighbours);
    let scale = 1.0 / radius;
    let mut matrix = [[0.0; COEFFICIENT_COUNT]; COEFFICIENT_COUNT];
    let mut right = [0.0; COEFFICIENT_COUNT];
    for neighbour in neighbours {
        let offset = (points[neighbour.index as usize] - point) * scale;
        let weight = f64::from((-neighbour.squared_distance * scale * scale).exp());
        let [x, y, z] = [first, second, normal].map(|axis| f64::from(axis.dot(offset)));
        let row = [1.0, x, y, x * x, x * y, y * y];
        for i in 0..COEFFICIENT_COUNT {
            for j in 0..=i {
                matrix[i][j] += weight * row[i] * row[j];
            }
            right[i] += weight * row[i] * z;
        }
    }
    let a = solve_positive_definite(matrix, right)?;
    let [along_first, along_second, along_normal] =
        laplacian_of_graph(&a).map(|value| (value * f64::from(scale)) as f32);
    let laplacian = -(first * along_first + second * along_second + normal * along_normal);
    let normal = (normal - first * a[1] as f32 - second * a[2] as f32).normalize();
    Some(QuadraticFit { laplacian, normal })
}

/// Δ(x, y, z) at the origin of the graph of the quadratic: A1, A2, Δz of Liang & Zhao.
///
/// Their A1, A2 and Δz are (−a2, −a3, 1) m / g² with g = 1 + a2² + a3², since the Laplacian of position is along the normal.
fn laplacian_of_graph(a: &[f64; COEFFICIENT_COUNT]) -> [f64; 3] {
    let g = 1.0 + a[1] * a[1] + a[2] * a[2];
    let m = 2.0 * ((1.0 + a[2] * a[2]) * a[3] - a[1] * a[2] * a[4] + (1.0 + a[1] * a[1]) * a[5]);
    let length = m / (g * g);
    [-a[1] * length, -a[2] * length, length]
}

/// Solves by Cholesky's factorisation; reads the lower triangle. Nothing where the matrix is singular to working precision.
fn solve_positive_definite<const N: usize>(mut l: [[f64; N]; N], mut x: [f64; N]) -> Option<[f64; N]> {
    for j in 0..N {
        let before = l[j][j];
        let pivot = before - (0..j).map(|k| l[j][k] * l[j][k]).sum::<f64>();
        if pivot <= 1e-10 * before {
            return None;
        }
        l[j][j] = pivot.sqrt();
        for i in j + 1..N {
            l[i][j] = (l[i][j] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>()) / l[j][j];
        }
    }
    for i in 0..N {
        x[i] = (x[i] - (0..i).map(|k| l[i][k] * x[k]).sum::<f64>()) / l[i][i];
    }
    for i in (0..N).rev() {
        x[i] = (x[i] - (i + 1..N).map(|k| l[k][i] * x[k]).sum::<f64>()) / l[i][i];
    }
    Some(x)
}

#[cfg(test)]
mod tests;
