//! What f_l should say: ground-truth Laplacians of scan points, carried to the canonical frame.

use crate::checkpoint::Keep;
use crate::context::{Sample, TrainContext};
use crate::localise::{Query, localise};
use crate::quadratic::fit_quadratics;
use crease::animate::PosedSurface;
use crease::avatar::Form;
use crease::laplacian::{apply_topological, scale_per_area};
use crease::mesh::{Adjacency, Triangle, mixed_voronoi_areas};
use crease::network::{Scratch, SurfaceFunction};
use crease::pose_feature::PoseMask;
use glam::{Mat3A, Vec3A};

/// Row scales below this belong to degenerate triangles, m².
const LEAST_SCALE: f32 = 1e-12;

/// One training pair of a surface function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Q on the canonical body, metres.
    pub canonical: Vec3A,
    /// Mask of θ̄.
    pub mask: PoseMask,
    /// What the function should say, in the canonical frame: δ of f_l in 1/m, or the offset of f_d in metres.
    pub value: Vec3A,
    /// μ.
    pub weight: f32,
}

impl Keep for Vec<Target> {
    /// Q, mask, value and μ of each target: 32 bytes.
    fn to_bytes(&self) -> Vec<u8> {
        let numbers = |Target { canonical: q, mask, value: d, weight }: &Target| {
            let [qx, qy, qz, dx, dy, dz, weight] = [q.x, q.y, q.z, d.x, d.y, d.z, *weight].map(f32::to_bits);
            [qx, qy, qz, mask.0, dx, dy, dz, weight]
        };
        self.iter().flat_map(numbers).flat_map(u32::to_le_bytes).collect()
    }

    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (targets, []) = bytes.as_chunks::<32>() else { return None };
        let words = |bytes: &[u8; 32]| -> [u32; 8] {
            std::array::from_fn(|i| u32::from_le_bytes(std::array::from_fn(|byte| bytes[4 * i + byte])))
        };
        let vector = |words: &[u32]| Vec3A::from_array(std::array::from_fn(|axis| f32::from_bits(words[axis])));
        let target = |w: [u32; 8]| Target {
            canonical: vector(&w[..3]),
            mask: PoseMask(w[3]),
            value: vector(&w[4..7]),
            weight: f32::from_bits(w[7]),
        };
        Some(targets.iter().map(|bytes| target(words(bytes))).collect())
    }
}

/// Training pairs of one frame by quadratic fits to its scan.
///
/// Scan points are projected onto the subdivided base mesh: with midpoints the same surface as the base mesh itself, and the one that the
/// reconstruction starts from in every scheme. In the relative form the base's own Laplacian at the projected point is taken off.
pub fn quadratic_targets(
    context: &TrainContext,
    deformation: &SurfaceFunction,
    sample: Sample,
) -> anyhow::Result<Vec<Target>> {
    let options = &context.options;
    let level = context.level_count();
    let triangles = context.subdivision.triangles(level);
    let scan = context.scan(sample)?;
    let points = scan.points;
    let fits = fit_quadratics(&points, &options.quadratic);
    let normals: Vec<Vec3A> = fits.iter().map(|fit| fit.map_or(Vec3A::ZERO, |fit| fit.normal)).collect();

    let mut surface = base_surface(context, deformation, sample);
    let base = surface.finest().to_vec();
    let base_laplacian = match options.form {
        Form::Absolute => None,
        Form::Relative => Some(operator_laplacian(&context.finest_adjacency, triangles, &base, &base)),
    };
    let rotations: &[Mat3A] = surface.rotations(&context.subdivision, level);
    let located = localise(&points, &normals, &base, triangles, &options.localisation)?;
    let targets = located.iter().zip(&fits).zip(&scan.weights).filter_map(|((surface, fit), &weight)| {
        let (surface, fit) = (surface.as_ref()?, fit.as_ref()?);
        let query = Query::at(surface, triangles, &context.domains[level], rotations);
        let own = base_laplacian.as_ref().map_or(Vec3A::ZERO, |values| surface.interpolate(triangles, values));
        let value = query.posed_from_canonical.inverse() * (fit.laplacian - own);
        value.is_finite().then_some(Target { canonical: query.canonical, mask: query.mask, value, weight })
    });
    Ok(targets.collect())
}

/// The posed base mesh of a training frame on all levels.
pub fn base_surface(context: &TrainContext, deformation: &SurfaceFunction, sample: Sample) -> PosedSurface {
    let mut surface = PosedSurface::new(&context.subdivision);
    surface.pose(
        &context.rig,
        &offsets(context, deformation, sample),
        context.pose(sample),
        &context.subdivision,
        context.options.scheme,
        context.subdivision.level_count(),
    );
    surface
}

/// f_d in the pose of a training frame: level 0, metres, canonical frame.
pub fn offsets(context: &TrainContext, deformation: &SurfaceFunction, sample: Sample) -> Vec<Vec3A> {
    let mut offsets = vec![Vec3A::ZERO; context.rig.rest.len()];
    deformation.evaluate(&context.domains[0], context.pose(sample), &mut Scratch::default(), &mut offsets);
    offsets
}

/// δ that the reconstruction's operator on `base` measures of a field on the same `triangles`, the finest level's: L x / s, 1/m.
pub fn operator_laplacian(
    adjacency: &Adjacency,
    triangles: &[Triangle],
    base: &[Vec3A],
    field: &[Vec3A],
) -> Vec<Vec3A> {
    let mut areas = vec![0.0; base.len()];
    mixed_voronoi_areas(base, triangles, &mut areas);
    let mut laplacian = vec![Vec3A::ZERO; base.len()];
    apply_topological(adjacency, field, &mut laplacian);
    for (k, (value, area)) in laplacian.iter_mut().zip(areas).enumerate() {
        let scale = area * scale_per_area(adjacency.valence(k));
        *value /= scale.max(LEAST_SCALE);
    }
    laplacian
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_are_kept_bit_for_bit() {
        let target = |x: f32| Target {
            canonical: Vec3A::new(x, -0.0, 0.1),
            mask: PoseMask(0b1010),
            value: Vec3A::new(0.3, x, 300.0),
            weight: 0.7,
        };
        let targets = vec![target(1.0), target(f32::MIN_POSITIVE)];
        assert_eq!(Vec::<Target>::from_bytes(&targets.to_bytes()), Some(targets.clone()));
        assert_eq!(Vec::<Target>::from_bytes(&targets.to_bytes()[1..]), None);
    }
}
