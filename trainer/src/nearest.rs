//! Nearest points of a cloud.

use glam::Vec3A;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use std::num::NonZero;

/// A cloud made ready for nearest-point queries by a k-d tree.
pub struct NearestPoints {
    tree: ImmutableKdTree<f32, 3>,
}

/// A neighbour: its index and squared distance in m².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbour {
    /// Index into the cloud.
    pub index: u32,
    /// Squared distance, m².
    pub squared_distance: f32,
}

impl NearestPoints {
    /// Builds the tree over `points`: at least one, all finite.
    pub fn new(points: &[Vec3A]) -> Self {
        let entries: Vec<[f32; 3]> = points.iter().map(Vec3A::to_array).collect();
        let tree = ImmutableKdTree::new_from_slice(&entries).expect("the points are finite");
        Self { tree }
    }

    /// The point nearest to `query`.
    pub fn one(&self, query: Vec3A) -> Neighbour {
        let found = self.tree.query(&query.to_array()).nearest_one::<SquaredEuclidean<f32>>().execute();
        Neighbour { index: found.item, squared_distance: found.distance }
    }

    /// The `count` nearest points, nearest first; fewer where the cloud has fewer.
    pub fn several(&self, query: Vec3A, count: NonZero<usize>) -> Vec<Neighbour> {
        let found = self.tree.query(&query.to_array()).nearest_n::<SquaredEuclidean<f32>>(count).execute();
        found.iter().map(|item| Neighbour { index: item.item, squared_distance: item.distance }).collect()
    }

    /// All points within `radius` metres, in no order.
    pub fn within(&self, query: Vec3A, radius: f32) -> Vec<Neighbour> {
        let found =
            self.tree.query(&query.to_array()).within::<SquaredEuclidean<f32>>(radius * radius).unsorted().execute();
        found.iter().map(|item| Neighbour { index: item.item, squared_distance: item.distance }).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::random_points;

    fn brute(points: &[Vec3A], query: Vec3A) -> Vec<(f32, u32)> {
        let mut all: Vec<(f32, u32)> =
            points.iter().enumerate().map(|(index, point)| (point.distance_squared(query), index as u32)).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all
    }

    #[test]
    fn agrees_with_brute_force() {
        let points = random_points(500, 1.0, 1);
        let nearest = NearestPoints::new(&points);
        for query in random_points(50, 1.2, 2) {
            let all = brute(&points, query);
            assert_eq!(nearest.one(query).index, all[0].1);
            let several: Vec<u32> =
                nearest.several(query, NonZero::new(7).unwrap()).iter().map(|neighbour| neighbour.index).collect();
            assert_eq!(several, all[..7].iter().map(|entry| entry.1).collect::<Vec<_>>());
            let mut within: Vec<u32> = nearest.within(query, 0.4).iter().map(|neighbour| neighbour.index).collect();
            within.sort_unstable();
            let mut expected: Vec<u32> = all.iter().filter(|entry| entry.0 <= 0.16).map(|entry| entry.1).collect();
            expected.sort_unstable();
            assert_eq!(within, expected);
        }
    }
}
