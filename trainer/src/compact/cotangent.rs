//! The cotangent operator of each frame's own base in place of the uniform-angle one: what the matrix that no pose changes is compared
//! with. The same fits, tables and regression; the matrix is factored anew in every frame.

use super::laplacian::{branch, canonical_delta, measure_each, regress_on_tables};
use super::surface_fit::refine_to_finest;
use super::views::View;
use crate::context::{Sample, TrainContext};
use crate::cotangent::{CotangentOperator, CotangentReconstruction};
use crate::targets::base_surface;
use crease::avatar::Form;
use crease::mesh::Scheme;
use crease::network::{Compact, Scratch, SurfaceFunction};
use glam::Vec3A;

/// Learns cotangent Laplacians in the canonical frame, 1/m.
pub struct CompactCotangent;

impl CompactCotangent {
    /// Canonical δ of every training frame from the base of `deformation` to its fitted surface, on the level of f_l's tables.
    pub fn measure(
        &self,
        context: &TrainContext,
        deformation: &SurfaceFunction,
        surfaces: &[View],
    ) -> anyhow::Result<Vec<Vec<Vec3A>>> {
        let triangles = context.subdivision.triangles(context.level_count());
        measure_each(context, "measuring with cotangents", surfaces, |sample, fitted| {
            canonical_delta(context, deformation, sample, fitted, |base, wanted| {
                CotangentOperator::new(&context.finest_adjacency, triangles, base).delta(wanted)
            })
        })
    }

    /// The function of what [`Self::measure`] gives.
    pub fn regress(&self, context: &TrainContext, targets: &[Vec<Vec3A>]) -> anyhow::Result<Compact> {
        regress_on_tables(context, targets, &branch(&context.options))
    }

    /// What no frame changes of the reconstruction.
    pub fn reconstruction(&self, context: &TrainContext) -> anyhow::Result<CotangentReconstruction> {
        CotangentReconstruction::new(&context.finest_adjacency, &context.anchors, context.options.anchor_weight)
    }

    /// The finest surface of one frame, metres.
    pub fn surface(
        &self,
        context: &TrainContext,
        deformation: &SurfaceFunction,
        laplacian: &SurfaceFunction,
        reconstruction: &CotangentReconstruction,
        sample: Sample,
    ) -> anyhow::Result<Vec<Vec3A>> {
        let TrainContext { subdivision, domains, finest_adjacency, .. } = context;
        let level = laplacian.level();
        let mut surface = base_surface(context, deformation, sample);
        let mut values = vec![Vec3A::ZERO; subdivision.vertex_count(level)];
        laplacian.evaluate(&domains[level], context.pose(sample), &mut Scratch::default(), &mut values);
        surface.turn(subdivision, level, &mut values);
        let mut delta = refine_to_finest(subdivision, Scheme::Loop, level, &values);
        let base = surface.finest();
        let operator = CotangentOperator::new(finest_adjacency, subdivision.triangles(context.level_count()), base);
        if context.options.form == Form::Absolute {
            delta.iter_mut().zip(operator.delta(base)).for_each(|(delta, own)| *delta -= own);
        }
        let displacement = reconstruction.solve(&operator, &delta)?;
        Ok(base.iter().zip(displacement).map(|(&base, gap)| base + gap).collect())
    }
}
