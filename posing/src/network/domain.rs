//! Query points and pose masks of a subdivision level's vertices: constant in time.

use crate::mesh::Subdivision;
use crate::pose_feature::{PoseMask, vertex_masks};
use crate::rig::Skin;
use glam::Vec3A;

/// Q(v) and the mask of θ̄(v) for each vertex of one level.
#[derive(Clone, Debug)]
pub struct Domain {
    /// Q(v) on the canonical body, metres. New vertices lie at edge midpoints, whatever the subdivision scheme.
    pub canonical: Vec<Vec3A>,
    /// Mask of θ̄(v). A new vertex listens to what either end of its edge listens to.
    pub masks: Vec<PoseMask>,
}

impl Domain {
    /// Domains of levels 0 ..= `finest` for the canonical template (zero shape).
    pub fn levels(template: &[Vec3A], skin: &Skin, subdivision: &Subdivision, finest: usize) -> Vec<Self> {
        let mut levels = vec![Self::coarsest(template, skin)];
        for level in 0..finest {
            levels.push(levels[level].refined(subdivision.edges(level)));
        }
        levels
    }

    /// The domain of level 0.
    pub fn coarsest(template: &[Vec3A], skin: &Skin) -> Self {
        Self { canonical: template.to_vec(), masks: vertex_masks(skin) }
    }

    fn refined(&self, edges: &[[u32; 2]]) -> Self {
        let count = self.canonical.len() + edges.len();
        let mut finer = Self { canonical: Vec::with_capacity(count), masks: Vec::with_capacity(count) };
        finer.canonical.extend_from_slice(&self.canonical);
        finer.masks.extend_from_slice(&self.masks);
        for [a, b] in edges.iter().map(|edge| edge.map(|v| v as usize)) {
            finer.canonical.push(0.5 * (self.canonical[a] + self.canonical[b]));
            finer.masks.push(self.masks[a].union(self.masks[b]));
        }
        finer
    }
}
