//! Pose to detailed mesh on the CPU: the one definition of correct.

mod surface;
#[cfg(test)]
mod tests;

pub use surface::PosedSurface;

use crate::avatar::{Avatar, AvatarError, Form};
use crate::body::Pose;
use crate::laplacian::{apply_topological, row_scales};
use crate::mesh::{Adjacency, Mesh, Scheme, Subdivision, Triangle, mixed_voronoi_areas};
use crate::network::{Domain, Scratch};
use crate::solver::{Solver, Stop};
use glam::Vec3A;
use std::sync::Arc;

/// How far down the pipeline a frame goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Stage {
    /// The skinned body, subdivided.
    Body,
    /// The pose-dependent base mesh, subdivided.
    Base,
    /// The detailed mesh.
    #[default]
    Detailed,
}

/// Choices of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// How far to go.
    pub stage: Stage,
    /// 0 is the base, 1 as trained, 2 exaggerated.
    pub detail: f32,
    /// When the solver stops.
    pub stop: Stop,
    /// Start the solver from the displacement of the last call in place of zero: fewer iterations where poses follow each other, and
    /// a result that differs within the tolerance. With [`Stop::Iterations`] the result then depends on earlier poses.
    pub warm_start: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { stage: Stage::Detailed, detail: 1.0, stop: Stop::Tolerance(1e-5), warm_start: false }
    }
}

/// An avatar made ready to move: all that no frame changes, and scratch space.
pub struct Animator {
    avatar: Arc<Avatar>,
    subdivision: Subdivision,
    domains: Vec<Domain>,
    finest_adjacency: Adjacency,
    pub(crate) solver: Solver,
    surface: PosedSurface,
    scratch: Scratch,
    offsets: Vec<Vec3A>,
    /// δ of f_l, posed, from its own level up to the finest.
    laplacians: Vec<Vec<Vec3A>>,
    areas: Vec<f32>,
    scales: Vec<f32>,
    residual: Vec<Vec3A>,
    displacement: Vec<Vec3A>,
    detailed: Vec<Vec3A>,
    iterations: u32,
}

impl Animator {
    /// Prepares `avatar`, after [`Avatar::validate`].
    pub fn new(avatar: Arc<Avatar>) -> Result<Self, AvatarError> {
        avatar.validate(&avatar.name)?;
        let finest_level = avatar.level_count as usize;
        let subdivision = Subdivision::new(avatar.rig.rest.len(), &avatar.triangles, finest_level);
        let count = subdivision.vertex_count(finest_level);
        let laplacian_level = avatar.laplacian.level();
        let solver = Solver::new(&subdivision, &avatar.anchors, avatar.anchor_weight, avatar.factor.clone())
            .map_err(|error| AvatarError::from_factor(&avatar.name, &error))?;
        Ok(Self {
            domains: Domain::levels(&avatar.canonical, &avatar.rig.skin, &subdivision),
            finest_adjacency: Adjacency::new(count, subdivision.triangles(finest_level)),
            solver,
            surface: PosedSurface::new(&subdivision),
            scratch: Scratch::default(),
            offsets: vec![Vec3A::ZERO; avatar.rig.rest.len()],
            laplacians: (laplacian_level..=finest_level)
                .map(|level| vec![Vec3A::ZERO; subdivision.vertex_count(level)])
                .collect(),
            areas: vec![0.0; count],
            scales: vec![0.0; count],
            residual: vec![Vec3A::ZERO; count],
            displacement: vec![Vec3A::ZERO; count],
            detailed: vec![Vec3A::ZERO; count],
            iterations: 0,
            subdivision,
            avatar,
        })
    }

    /// Poses the avatar. The result depends on pose and options alone, within the solver's tolerance.
    /// Positions (finest level, metres) stay valid until the next call. `pose` has one rotation for each of the avatar's joints.
    ///
    /// Memory of the mesh's size is allocated in [`Animator::new`] and in the first call alone.
    pub fn animate(&mut self, pose: &Pose, options: &Options) -> &[Vec3A] {
        let avatar = Arc::clone(&self.avatar);
        let offsets: &[Vec3A] = if options.stage == Stage::Body {
            &[]
        } else {
            avatar.deformation.evaluate(&self.domains[0], pose, &mut self.scratch, &mut self.offsets);
            &self.offsets
        };
        self.surface.pose(&avatar.rig, offsets, pose, &self.subdivision, avatar.scheme);
        self.iterations = 0;
        if options.stage != Stage::Detailed || options.detail == 0.0 {
            return self.surface.finest();
        }
        self.evaluate_laplacian(pose);
        self.evaluate_residual(options.detail);
        if !options.warm_start {
            self.displacement.fill(Vec3A::ZERO);
        }
        self.iterations = self.solver.solve(&self.residual, &mut self.displacement, options.stop);
        for ((detailed, base), displacement) in
            self.detailed.iter_mut().zip(self.surface.finest()).zip(&self.displacement)
        {
            *detailed = *base + *displacement;
        }
        &self.detailed
    }

    /// f_l, turned into the posed frame and carried to the finest level by Loop's stencils.
    fn evaluate_laplacian(&mut self, pose: &Pose) {
        let function = &self.avatar.laplacian;
        let level = function.level();
        function.evaluate(&self.domains[level], pose, &mut self.scratch, &mut self.laplacians[0]);
        for (delta, rotation) in self.laplacians[0].iter_mut().zip(self.surface.rotations(&self.subdivision, level)) {
            *delta = *rotation * *delta;
        }
        for i in 0..self.laplacians.len() - 1 {
            let (coarse, fine) = self.laplacians.split_at_mut(i + 1);
            self.subdivision.refine(Scheme::Loop, level + i, &coarse[i], &mut fine[0]);
        }
    }

    /// r: s δ in the relative form, s δ − L u in the absolute one, times `detail`.
    fn evaluate_residual(&mut self, detail: f32) {
        let base = self.surface.finest();
        let finest_level = self.subdivision.level_count();
        mixed_voronoi_areas(base, self.subdivision.triangles(finest_level), &mut self.areas);
        row_scales(&self.finest_adjacency, &self.areas, &mut self.scales);
        match self.avatar.form {
            Form::Absolute => apply_topological(&self.finest_adjacency, base, &mut self.residual),
            Form::Relative => self.residual.fill(Vec3A::ZERO),
        }
        let deltas = &self.laplacians[self.laplacians.len() - 1];
        for ((residual, delta), scale) in self.residual.iter_mut().zip(deltas).zip(&self.scales) {
            *residual = detail * (*scale * *delta - *residual);
        }
    }

    /// Triangles of the finest level.
    pub fn triangles(&self) -> &[Triangle] {
        self.subdivision.triangles(self.subdivision.level_count())
    }

    /// The avatar.
    pub fn avatar(&self) -> &Avatar {
        &self.avatar
    }

    /// The avatar, to keep.
    pub fn shared_avatar(&self) -> Arc<Avatar> {
        Arc::clone(&self.avatar)
    }

    /// Topology of all levels.
    pub fn subdivision(&self) -> &Subdivision {
        &self.subdivision
    }

    /// Query points and masks of all levels.
    pub fn domains(&self) -> &[Domain] {
        &self.domains
    }

    /// Body or base mesh of the last call, all levels.
    pub fn surface(&self) -> &PosedSurface {
        &self.surface
    }

    /// Iterations of the solver in the last call.
    pub fn iterations(&self) -> u32 {
        self.iterations
    }
}

/// Poses `avatar` once. For many frames keep an [`Animator`].
pub fn animate(avatar: &Avatar, pose: &Pose, options: &Options) -> Result<Mesh, AvatarError> {
    let mut animator = Animator::new(Arc::new(avatar.clone()))?;
    let positions = animator.animate(pose, options).to_vec();
    Ok(Mesh { positions, triangles: animator.triangles().to_vec() })
}
