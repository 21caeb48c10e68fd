//! Displacements in place of Laplacians: what f_l is compared with. The same fits, tables and regression; the surface is the base plus the
//! displacement, and nothing is solved.

use super::laplacian::{measure_each, on_tables, regress_on_tables};
use super::surface_fit::refine_to_finest;
use super::two_scales::BranchOptions;
use super::views::View;
use crate::context::{Sample, TrainContext};
use crate::targets::base_surface;
use crease::mesh::Scheme;
use crease::network::{Compact, Scratch, SurfaceFunction};
use glam::Vec3A;

/// Learns displacements in the canonical frame, metres.
pub struct CompactDisplacement;

impl CompactDisplacement {
    /// Canonical displacements of every training frame from the base of `deformation` to its fitted surface, on the level of f_l's tables.
    pub fn measure(
        &self,
        context: &TrainContext,
        deformation: &SurfaceFunction,
        surfaces: &[View],
    ) -> anyhow::Result<Vec<Vec<Vec3A>>> {
        measure_each(context, "measuring displacements", surfaces, |sample, fitted| {
            let mut surface = base_surface(context, deformation, sample);
            let gaps: Vec<Vec3A> = fitted.values.iter().zip(surface.finest()).map(|(&to, &from)| to - from).collect();
            View { values: on_tables(context, &mut surface, &gaps), seen: fitted.seen.clone() }
        })
    }

    /// The function of what [`Self::measure`] gives, with as many components as f_l has; its tables are in f_d's steps, which are metres too.
    pub fn regress(&self, context: &TrainContext, displacements: &[Vec<Vec3A>]) -> anyhow::Result<Compact> {
        let BranchOptions { mut wide, mut narrow, .. } = context.options.compact.laplacian;
        wide.step = context.options.compact.deformation.wide.step;
        narrow.step = context.options.compact.deformation.narrow.step;
        let options = BranchOptions { wide, narrow, ..context.options.compact.laplacian };
        regress_on_tables(context, displacements, &options)
    }

    /// The finest surface of one frame, metres.
    pub fn surface(
        &self,
        context: &TrainContext,
        deformation: &SurfaceFunction,
        displacement: &SurfaceFunction,
        sample: Sample,
    ) -> Vec<Vec3A> {
        let level = displacement.level();
        let mut surface = base_surface(context, deformation, sample);
        let mut values = vec![Vec3A::ZERO; context.subdivision.vertex_count(level)];
        displacement.evaluate(&context.domains[level], context.pose(sample), &mut Scratch::default(), &mut values);
        surface.turn(&context.subdivision, level, &mut values);
        let refined = refine_to_finest(&context.subdivision, Scheme::Loop, level, &values);
        surface.finest().iter().zip(refined).map(|(&base, gap)| base + gap).collect()
    }
}
