//! The surface cut into overlapping regions, one for each distinct pose mask.

use crease::mesh::Adjacency;
use crease::pose_feature::PoseMask;
use std::collections::BTreeMap;

/// A region with the weight of its branch on each of its vertices; over all regions the weights of a vertex sum to one.
#[derive(Clone, Debug)]
pub struct WeightedRegion {
    /// Joints that the region listens to.
    pub mask: PoseMask,
    /// (vertex, weight), vertices ascending.
    pub vertices: Vec<(u32, f32)>,
}

/// Weights below this are dropped: a row of tables for each would cost more than it shows.
const SMALLEST_WEIGHT: f32 = 0.04;

/// Distinct masks of `masks` as regions whose borders are blended over about `blend_steps` edges.
///
/// A hard border would be a jump of the surface function, and a crease in the mesh for poses far from training.
pub fn weighted_regions(masks: &[PoseMask], adjacency: &Adjacency, blend_steps: usize) -> Vec<WeightedRegion> {
    let mut distinct = masks.to_vec();
    distinct.sort_unstable();
    distinct.dedup();
    let mut weights: Vec<Vec<f32>> = distinct
        .iter()
        .map(|&mask| {
            let mut weight: Vec<f32> = masks.iter().map(|&m| if m == mask { 1.0 } else { 0.0 }).collect();
            for _ in 0..blend_steps {
                weight = (0..masks.len())
                    .map(|k| {
                        let neighbours = adjacency.of(k);
                        let sum: f32 = neighbours.iter().map(|&j| weight[j as usize]).sum();
                        0.5 * weight[k] + 0.5 * sum / neighbours.len().max(1) as f32
                    })
                    .collect();
            }
            weight
        })
        .collect();
    for k in 0..masks.len() {
        let largest = weights.iter().map(|w| w[k]).fold(0.0, f32::max);
        let smallest = SMALLEST_WEIGHT.min(largest);
        let total: f32 = weights.iter().map(|w| w[k]).filter(|&w| w >= smallest).sum();
        for weight in &mut weights {
            weight[k] = if weight[k] >= smallest { weight[k] / total } else { 0.0 };
        }
    }
    distinct
        .into_iter()
        .zip(weights)
        .map(|(mask, weights)| WeightedRegion {
            mask,
            vertices: weights
                .into_iter()
                .enumerate()
                .filter(|&(_, weight)| weight > 0.0)
                .map(|(k, weight)| (k as u32, weight))
                .collect(),
        })
        .filter(|region| !region.vertices.is_empty())
        .collect()
}

/// All regions that listen to joints as one, which listens to all of theirs; those that listen to none stay.
pub fn merged(regions: &[WeightedRegion]) -> Vec<WeightedRegion> {
    let (mut merged, listening): (Vec<_>, Vec<_>) =
        regions.iter().cloned().partition(|region| region.mask == PoseMask::default());
    let mut whole = WeightedRegion { mask: PoseMask::default(), vertices: Vec::new() };
    let mut weights = BTreeMap::new();
    for region in listening {
        whole.mask = whole.mask.union(region.mask);
        for (vertex, weight) in region.vertices {
            *weights.entry(vertex).or_insert(0.0) += weight;
        }
    }
    whole.vertices.extend(weights);
    if !whole.vertices.is_empty() {
        merged.push(whole);
    }
    merged
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merging_keeps_the_deaf_apart_and_weights_whole() {
        let region =
            |mask, vertices: &[(u32, f32)]| WeightedRegion { mask: PoseMask(mask), vertices: vertices.to_vec() };
        let regions = [
            region(0, &[(0, 1.0), (1, 0.5)]),
            region(2, &[(1, 0.25), (2, 0.5)]),
            region(4, &[(1, 0.25), (2, 0.5), (3, 1.0)]),
        ];
        let merged = merged(&regions);
        assert_eq!(merged.len(), 2);
        assert_eq!((merged[0].mask, &merged[0].vertices), (PoseMask(0), &vec![(0, 1.0), (1, 0.5)]));
        assert_eq!((merged[1].mask, &merged[1].vertices), (PoseMask(6), &vec![(1, 0.5), (2, 1.0), (3, 1.0)]));
    }

    #[test]
    fn weights_sum_to_one_and_fall_off_away_from_the_border() {
        // A strip of triangles: 40 columns, two rows; the left half listens to joint 1, the right half to joint 2.
        let columns = 40u32;
        let mut triangles = Vec::new();
        for i in 0..columns - 1 {
            let (a, b, c, d) = (2 * i, 2 * i + 1, 2 * i + 2, 2 * i + 3);
            triangles.push([a, c, b]);
            triangles.push([b, c, d]);
        }
        let masks: Vec<PoseMask> = (0..2 * columns).map(|k| PoseMask(if k < columns { 2 } else { 4 })).collect();
        let adjacency = Adjacency::new(masks.len(), &triangles);
        let regions = weighted_regions(&masks, &adjacency, 4);
        assert_eq!(regions.len(), 2);
        let mut sums = vec![0.0; masks.len()];
        for region in &regions {
            for &(vertex, weight) in &region.vertices {
                sums[vertex as usize] += weight;
            }
        }
        assert!(sums.iter().all(|&sum: &f32| (sum - 1.0).abs() < 1e-6));
        let left = &regions[0].vertices;
        let weight_at = |vertex: u32| left.iter().find(|v| v.0 == vertex).map_or(0.0, |v| v.1);
        assert_eq!(weight_at(0), 1.0);
        assert_eq!(weight_at(2 * columns - 1), 0.0);
        let middle = weight_at(columns);
        assert!(middle > 0.2 && middle < 0.8, "the border is blended, weight {middle}");
    }
}
