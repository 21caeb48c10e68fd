//! Anchors by Poisson-disk sample elimination (Yuksel 2015).

use glam::Vec3A;
use std::collections::BinaryHeap;

/// Chooses `count` of `positions`, spread evenly over a surface of `area` m²; ascending indices. All of them if there are no more.
///
/// Removes the most crowded point over and over; distances are straight lines in space (Yuksel 2015, Section 3, with the
/// weight's exponent 8 and the weight limit β = 0.65, γ = 1.5). Starts from [`CANDIDATES_PER_CHOICE`] times `count` points
/// picked by a hash where there are more. The same input gives the same choice everywhere.
pub fn sample_elimination(positions: &[Vec3A], area: f32, count: usize) -> Vec<u32> {
    let candidate_count = count.saturating_mul(CANDIDATES_PER_CHOICE);
    if positions.len() <= candidate_count {
        return eliminate(positions, area, count);
    }
    let mut candidates: Vec<u32> = (0..positions.len() as u32).collect();
    candidates.sort_unstable_by_key(|&k| (k.wrapping_mul(0x9E37_79B9) ^ k >> 7).wrapping_mul(0x85EB_CA6B));
    candidates.truncate(candidate_count);
    candidates.sort_unstable();
    let thinned: Vec<Vec3A> = candidates.iter().map(|&k| positions[k as usize]).collect();
    eliminate(&thinned, area, count).into_iter().map(|k| candidates[k as usize]).collect()
}

/// Yuksel finds five enough; more spread a little better, and time grows with the square.
const CANDIDATES_PER_CHOICE: usize = 24;

fn eliminate(positions: &[Vec3A], area: f32, count: usize) -> Vec<u32> {
    if count == 0 || positions.len() <= count {
        return (0..positions.len().min(count) as u32).collect();
    }
    let crowding = Crowding::new(area, count, positions.len());
    let mut grid = Grid::new(positions, crowding.reach);
    let mut weights = vec![0.0f64; positions.len()];
    for (k, weight) in weights.iter_mut().enumerate() {
        grid.for_each_near(positions[k], |j, position| {
            if j as usize != k {
                *weight += crowding.weight(positions[k].distance_squared(position));
            }
        });
    }

    // Weights only fall, so an entry of the heap is an upper bound: one that is out of date goes back with its present weight.
    let mut heap: BinaryHeap<Candidate> =
        (0..).zip(&weights).map(|(vertex, &weight)| Candidate { weight, vertex }).collect();
    let mut removed = positions.len() - count;
    while removed > 0
        && let Some(top) = heap.pop()
    {
        let present = weights[top.vertex as usize];
        if present < top.weight {
            heap.push(Candidate { weight: present, ..top });
            continue;
        }
        let position = positions[top.vertex as usize];
        grid.remove(top.vertex, position);
        grid.for_each_near(position, |j, other| {
            weights[j as usize] -= crowding.weight(position.distance_squared(other))
        });
        removed -= 1;
    }
    let mut chosen: Vec<u32> = heap.into_iter().map(|candidate| candidate.vertex).collect();
    chosen.sort_unstable();
    chosen
}

/// How much a point crowds another, by distance.
struct Crowding {
    /// 2 r_max: points farther apart do not crowd each other, metres.
    reach: f32,
    /// 2 r_min: points nearer than this crowd no more than at this distance, metres.
    limit: f32,
}

impl Crowding {
    fn new(area: f32, count: usize, of: usize) -> Self {
        let largest_radius = (area / (2.0 * 3f32.sqrt() * count as f32)).sqrt();
        let share = count as f32 / of as f32;
        let smallest_radius = largest_radius * (1.0 - share * share.sqrt()) * 0.65;
        Self { reach: 2.0 * largest_radius, limit: 2.0 * smallest_radius }
    }

    fn weight(&self, distance_squared: f32) -> f64 {
        if distance_squared >= self.reach * self.reach {
            return 0.0;
        }
        let nearness = f64::from(1.0 - distance_squared.sqrt().max(self.limit) / self.reach);
        let fourth = nearness * nearness * nearness * nearness;
        fourth * fourth
    }
}

/// An entry of the heap: heaviest first, then the smaller index.
#[derive(PartialEq)]
struct Candidate {
    weight: f64,
    vertex: u32,
}

impl Eq for Candidate {}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.weight.total_cmp(&other.weight).then(other.vertex.cmp(&self.vertex))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// Points in cubic cells.
struct Grid {
    origin: Vec3A,
    cell_size: f32,
    cell_counts: [usize; 3],
    cells: Vec<Vec<(u32, Vec3A)>>,
}

impl Grid {
    /// Cells are no smaller than `reach`, so that all points within it are in the 27 cells around, and no more than the points.
    fn new(positions: &[Vec3A], reach: f32) -> Self {
        let smallest = positions.iter().fold(Vec3A::INFINITY, |bound, p| bound.min(*p));
        let largest = positions.iter().fold(Vec3A::NEG_INFINITY, |bound, p| bound.max(*p));
        let counts = |cell_size: f32| ((largest - smallest) / cell_size).to_array().map(|cells| cells as usize + 1);
        let is_too_many = |counts: [usize; 3]| {
            counts.iter().fold(1usize, |product, &count| product.saturating_mul(count)) > positions.len().max(64)
        };
        let mut cell_size = reach.max(f32::MIN_POSITIVE);
        while is_too_many(counts(cell_size)) {
            cell_size *= 1.3;
        }
        let cell_counts = counts(cell_size);
        let mut grid =
            Self { origin: smallest, cell_size, cell_counts, cells: vec![Vec::new(); cell_counts.iter().product()] };
        for (k, &position) in positions.iter().enumerate() {
            let cell = grid.index(grid.cell_of(position));
            grid.cells[cell].push((k as u32, position));
        }
        grid
    }

    fn cell_of(&self, position: Vec3A) -> [usize; 3] {
        let cells = ((position - self.origin) / self.cell_size).to_array();
        std::array::from_fn(|axis| (cells[axis] as usize).min(self.cell_counts[axis] - 1))
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.cell_counts[1] + y) * self.cell_counts[0] + x
    }

    fn remove(&mut self, vertex: u32, position: Vec3A) {
        let cell = self.index(self.cell_of(position));
        self.cells[cell].retain(|&(other, _)| other != vertex);
    }

    fn for_each_near(&self, position: Vec3A, mut visit: impl FnMut(u32, Vec3A)) {
        let [xs, ys, zs]: [_; 3] = {
            let cell = self.cell_of(position);
            std::array::from_fn(|axis| cell[axis].saturating_sub(1)..=(cell[axis] + 1).min(self.cell_counts[axis] - 1))
        };
        for z in zs {
            for y in ys.clone() {
                for x in xs.clone() {
                    self.cells[self.index([x, y, z])].iter().for_each(|&(vertex, other)| visit(vertex, other));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_meshes::{icosphere, noise};
    use std::f32::consts::PI;

    /// The least distance between two of `chosen`, as a share of the largest that so many points could keep (2 r_max).
    fn spacing(positions: &[Vec3A], area: f32, chosen: &[u32]) -> f32 {
        let mut nearest = f32::INFINITY;
        for (i, &a) in chosen.iter().enumerate() {
            for &b in &chosen[i + 1..] {
                nearest = nearest.min(positions[a as usize].distance(positions[b as usize]));
            }
        }
        nearest / Crowding::new(area, chosen.len(), positions.len()).reach
    }

    #[test]
    fn chosen_points_keep_their_distance_where_random_ones_do_not() {
        let sphere = icosphere(5);
        let chosen = sample_elimination(&sphere.positions, 4.0 * PI, 300);
        assert_eq!(chosen.len(), 300);
        assert!(chosen.is_sorted_by(|a, b| a < b));
        let random: Vec<u32> = (0..300).map(|i| 34 * i + (17.0 + 33.0 * noise(i)) as u32).collect();
        let (even, uneven) =
            (spacing(&sphere.positions, 4.0 * PI, &chosen), spacing(&sphere.positions, 4.0 * PI, &random));
        // Yuksel reports 0.7 and more on planes.
        assert!(even > 0.7 && uneven < 0.3, "{even} and {uneven}");
    }

    #[test]
    fn the_choice_repeats_and_does_not_hang_on_the_position_in_space() {
        let sphere = icosphere(3);
        let first = sample_elimination(&sphere.positions, 4.0 * PI, 50);
        assert_eq!(first, sample_elimination(&sphere.positions, 4.0 * PI, 50));
        assert_ne!(first, sample_elimination(&sphere.positions, 4.0 * PI, 51)[..50]);
    }

    #[test]
    fn few_points_coincident_points_and_none() {
        let points = [Vec3A::X, Vec3A::Y, Vec3A::Z];
        assert_eq!(sample_elimination(&points, 1.0, 5), [0, 1, 2]);
        assert_eq!(sample_elimination(&points, 1.0, 0), [0u32; 0]);
        assert_eq!(sample_elimination(&[Vec3A::ONE; 9], 0.0, 4).len(), 4);
    }
}
