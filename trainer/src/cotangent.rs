//! The cotangent Laplacian of one posed mesh (paper Eq. cotLap), and reconstruction with it: what the uniform-angle operator stands in for.
//!
//! Rows are divided by what the uniform-angle ones are divided by: (L u)_k = s_k δ_k with the same s_k, and on equilateral triangles the same
//! L. So anchors weigh the same beside both. Unlike there L hangs on the pose. (A row divided by the sum of its own cotangents would be
//! divided by next to nothing between obtuse triangles.)

use crease::laplacian::scale_per_area;
use crease::mesh::{Adjacency, Triangle, mixed_voronoi_areas};
use faer::prelude::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{Argsort, Pair, SparseColMat, SymbolicSparseColMat};
use faer::{Mat, Side};
use glam::{DVec3, Vec3A};

/// L and s of one mesh.
pub struct CotangentOperator<'a> {
    adjacency: &'a Adjacency,
    /// −L off its diagonal, in the adjacency's order.
    weights: Vec<f64>,
    /// s_k, m²; zero where a vertex has fewer than three neighbours, or no area.
    scales: Vec<f64>,
}

impl<'a> CotangentOperator<'a> {
    /// Of a mesh (metres) whose neighbours `adjacency` has.
    pub fn new(adjacency: &'a Adjacency, triangles: &[Triangle], positions: &[Vec3A]) -> Self {
        let mut weights = vec![0.0; adjacency.neighbours.len()];
        for &triangle in triangles {
            for turn in 0..3 {
                let [opposite, a, b] = [0, 1, 2].map(|corner| triangle[(turn + corner) % 3]);
                let half = 0.5 * cotangent([opposite, a, b].map(|vertex| positions[vertex as usize].as_dvec3()));
                weights[entry(adjacency, a, b)] += half;
                weights[entry(adjacency, b, a)] += half;
            }
        }
        let mut areas = vec![0.0; positions.len()];
        mixed_voronoi_areas(positions, triangles, &mut areas);
        let mut scales = vec![0.0; positions.len()];
        for (k, scale) in scales.iter_mut().enumerate() {
            let scale_per_area = f64::from(scale_per_area(adjacency.valence(k)));
            *scale = f64::from(areas[k]) * scale_per_area;
            let row = adjacency.offsets[k] as usize..adjacency.offsets[k + 1] as usize;
            weights[row].iter_mut().for_each(|weight| *weight *= scale_per_area);
        }
        Self { adjacency, weights, scales }
    }

    /// Column and value of each entry of row `k`, the diagonal first.
    fn row(&self, k: usize) -> impl Iterator<Item = (usize, f64)> + Clone + '_ {
        let weights = &self.weights[self.adjacency.offsets[k] as usize..self.adjacency.offsets[k + 1] as usize];
        let others = self.adjacency.of(k).iter().zip(weights);
        std::iter::once((k, weights.iter().sum())).chain(others.map(|(&j, &weight)| (j as usize, -weight)))
    }

    /// L `field`.
    fn apply(&self, field: &[Vec3A]) -> Vec<DVec3> {
        let row = |k| self.row(k).map(|(j, value)| value * field[j].as_dvec3()).sum();
        (0..field.len()).map(row).collect()
    }

    /// δ = L `field` / s, 1/m; zero where s is.
    pub fn delta(&self, field: &[Vec3A]) -> Vec<Vec3A> {
        let of_row = |(row, &scale): (DVec3, &f64)| if scale > 0.0 { (row / scale).as_vec3a() } else { Vec3A::ZERO };
        self.apply(field).into_iter().zip(&self.scales).map(of_row).collect()
    }
}

/// The cotangent of a triangle's angle at its first corner; zero where it has no area.
fn cotangent([corner, a, b]: [DVec3; 3]) -> f64 {
    let (first, second) = (a - corner, b - corner);
    let twice_area = first.cross(second).length();
    if twice_area > f64::from(f32::MIN_POSITIVE) { first.dot(second) / twice_area } else { 0.0 }
}

/// Where `adjacency` has the neighbour `j` of `k`.
fn entry(adjacency: &Adjacency, k: u32, j: u32) -> usize {
    let within = adjacency.of(k as usize).binary_search(&j).expect("corners of a triangle are neighbours");
    adjacency.offsets[k as usize] as usize + within
}

/// What no frame changes of (LᵀL + w_a S) d = Lᵀ s δ: pattern, order and the factor's pattern. The matrix itself each frame changes.
pub struct CotangentReconstruction {
    /// Of the lower triangle.
    pattern: SymbolicSparseColMat<usize>,
    /// Takes entries, in the order in which [`entries`] gives them, to their places.
    order: Argsort<usize>,
    factor: SymbolicLlt<usize>,
    anchors: Vec<u32>,
    anchor_weight: f64,
}

impl CotangentReconstruction {
    /// Orders by approximate minimum degree. `anchors` are vertices of the mesh whose neighbours `adjacency` has.
    pub fn new(adjacency: &Adjacency, anchors: &[u32], anchor_weight: f32) -> anyhow::Result<Self> {
        let count = adjacency.vertex_count();
        let columns = |k: usize| std::iter::once(k).chain(adjacency.of(k).iter().map(|&j| j as usize));
        let mut pairs = Vec::new();
        for k in 0..count {
            for row in columns(k) {
                pairs.extend(columns(k).filter(|&column| column <= row).map(|column| Pair::new(row, column)));
            }
        }
        pairs.extend(anchors.iter().map(|&anchor| Pair::new(anchor as usize, anchor as usize)));
        let (pattern, order) = SymbolicSparseColMat::try_new_from_indices(count, count, &pairs)?;
        let factor = SymbolicLlt::try_new(pattern.as_ref(), Side::Lower)?;
        Ok(Self { pattern, order, factor, anchors: anchors.to_vec(), anchor_weight: anchor_weight.into() })
    }

    /// The displacement d, metres, whose Laplacian is `delta` (1/m), by a direct solve in double precision.
    ///
    /// Fails where the matrix is not positive definite: a connected part without anchors.
    pub fn solve(&self, operator: &CotangentOperator, delta: &[Vec3A]) -> anyhow::Result<Vec<Vec3A>> {
        let count = delta.len();
        let mut values = Vec::new();
        let mut right = Mat::<f64>::zeros(count, 3);
        for k in 0..count {
            let wanted = operator.scales[k] * delta[k].as_dvec3();
            for (row, a) in operator.row(k) {
                values.extend(operator.row(k).filter(|&(column, _)| column <= row).map(|(_, b)| a * b));
                for axis in 0..3 {
                    right[(row, axis)] += a * wanted[axis];
                }
            }
        }
        values.extend(self.anchors.iter().map(|_| self.anchor_weight));
        let matrix = SparseColMat::new_from_argsort(self.pattern.clone(), &self.order, &values)?;
        let factor = Llt::try_new_with_symbolic(self.factor.clone(), matrix.as_ref(), Side::Lower)
            .map_err(|error| anyhow::anyhow!("the cotangent matrix cannot be factored: {error:?}"))?;
        let solution = factor.solve(&right);
        Ok((0..count).map(|k| Vec3A::from_array([0, 1, 2].map(|axis| solution[(k, axis)] as f32))).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::sphere;
    use crate::targets::operator_laplacian;

    /// Equilateral triangles of 2 cm in a plane, `side` vertices each way.
    fn sheet(side: u32) -> (Vec<Vec3A>, Vec<Triangle>) {
        let place = |i: u32, j: u32| 0.02 * Vec3A::new(i as f32 + 0.5 * j as f32, 0.75f32.sqrt() * j as f32, 0.0);
        let positions = (0..side * side).map(|k| place(k % side, k / side)).collect();
        let corners = (0..side - 1).flat_map(|j| (0..side - 1).map(move |i| j * side + i));
        let triangles = corners.flat_map(|k| [[k, k + 1, k + side], [k + 1, k + side + 1, k + side]]).collect();
        (positions, triangles)
    }

    fn is_inner(k: usize, side: usize) -> bool {
        [k % side, k / side].iter().all(|&at| at > 0 && at < side - 1)
    }

    #[test]
    fn on_regular_triangles_both_operators_agree() {
        let (positions, triangles) = sheet(9);
        let adjacency = Adjacency::new(positions.len(), &triangles);
        let bumps: Vec<Vec3A> = positions.iter().map(|p| Vec3A::Z * (90.0 * p.x).sin() * (70.0 * p.y).cos()).collect();
        let own = CotangentOperator::new(&adjacency, &triangles, &positions).delta(&bumps);
        let uniform = operator_laplacian(&adjacency, &triangles, &positions, &bumps);
        for k in (0..positions.len()).filter(|&k| is_inner(k, 9)) {
            assert!((own[k] - uniform[k]).length() < 1e-3 * uniform[k].length(), "{} and {}", own[k], uniform[k]);
        }
        // On stretched ones they do not.
        let stretched: Vec<Vec3A> = positions.iter().map(|&p| p * Vec3A::new(3.0, 1.0, 1.0)).collect();
        let own = CotangentOperator::new(&adjacency, &triangles, &stretched).delta(&bumps);
        let uniform = operator_laplacian(&adjacency, &triangles, &stretched, &bumps);
        let apart = |k: &usize| (own[*k] - uniform[*k]).length() > 0.2 * uniform[*k].length();
        assert!((0..positions.len()).filter(|&k| is_inner(k, 9)).filter(apart).count() > 20);
    }

    #[test]
    fn delta_of_a_sphere_is_outward_twice_the_curvature_however_it_is_meshed() {
        let mesh = sphere(0.4, 4);
        let adjacency = Adjacency::new(mesh.positions.len(), &mesh.triangles);
        let operator = CotangentOperator::new(&adjacency, &mesh.triangles, &mesh.positions);
        for (delta, position) in operator.delta(&mesh.positions).iter().zip(&mesh.positions) {
            let expected = *position * (2.0 / (0.4 * 0.4));
            assert!((*delta - expected).length() < 0.02 * expected.length(), "{delta} for {expected}");
        }
    }

    #[test]
    fn linear_fields_of_a_plane_have_no_laplacian_where_triangles_are_stretched() {
        let (mut positions, triangles) = sheet(7);
        for (k, position) in positions.iter_mut().enumerate().filter(|&(k, _)| is_inner(k, 7)) {
            *position += 0.004 * Vec3A::new((k as f32).sin(), (2.0 * k as f32).cos(), 0.0);
        }
        let adjacency = Adjacency::new(positions.len(), &triangles);
        let own = CotangentOperator::new(&adjacency, &triangles, &positions).delta(&positions);
        let uniform = operator_laplacian(&adjacency, &triangles, &positions, &positions);
        let largest = |deltas: &[Vec3A]| {
            (0..deltas.len()).filter(|&k| is_inner(k, 7)).map(|k| deltas[k].length()).fold(0.0, f32::max)
        };
        assert!(largest(&own) < 0.05 && largest(&uniform) > 2.0, "{} and {}", largest(&own), largest(&uniform));
    }

    #[test]
    fn the_laplacian_of_a_displacement_gives_the_displacement_back() {
        let mesh = sphere(0.4, 3);
        let adjacency = Adjacency::new(mesh.positions.len(), &mesh.triangles);
        let operator = CotangentOperator::new(&adjacency, &mesh.triangles, &mesh.positions);
        let anchors: Vec<u32> = (0..mesh.positions.len() as u32).step_by(9).collect();
        let reconstruction = CotangentReconstruction::new(&adjacency, &anchors, 1.0).unwrap();
        // Zero at the anchors, which hold it there.
        let wanted: Vec<Vec3A> = (mesh.positions.iter().enumerate())
            .map(|(k, &p)| if k % 9 == 0 { Vec3A::ZERO } else { p * 0.05 * (20.0 * p.y).sin() })
            .collect();
        let found = reconstruction.solve(&operator, &operator.delta(&wanted)).unwrap();
        for (found, wanted) in found.iter().zip(&wanted) {
            assert!(found.distance(*wanted) < 1e-6, "{found} for {wanted}");
        }
        let nothing = reconstruction.solve(&operator, &vec![Vec3A::ZERO; wanted.len()]).unwrap();
        assert!(nothing.iter().all(|d| d.length() == 0.0));
        assert!(CotangentReconstruction::new(&adjacency, &[], 1.0).unwrap().solve(&operator, &wanted).is_err());
    }
}
