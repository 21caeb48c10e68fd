//! Pose to detailed mesh on the CPU: the one definition of correct.

mod base;
#[cfg(test)]
mod tests;

pub use base::BaseAnimator;
pub use crease_posing::posed_surface::PosedSurface;

use crate::avatar::{Avatar, AvatarError, Form};
use crate::body::Pose;
use crate::laplacian::{put_residual, scale_per_area};
use crate::mesh::{Mesh, Scheme, Subdivision, Triangle, VertexAreas, put_sum};
use crate::network::Domain;
use crate::solver::{Solver, Start, Stop};
use glam::Vec3A;
use std::ops::RangeInclusive;
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
    /// What poses far from training wear: 0 what is likeliest, which is smooth; 1 the folds of the training poses nearest to them. Has no
    /// say in functions that do not recall.
    pub liveliness: f32,
    /// When the solver stops.
    pub stop: Stop,
    /// Start the solver from what the last calls make likely in place of the base: fewer iterations where poses follow each other, and
    /// a result that differs within the tolerance. With [`Stop::Iterations`] the result then depends on earlier poses.
    pub warm_start: bool,
    /// Subdivision level of the mesh that is returned, as near as [`Animator::levels`] allows.
    pub level: usize,
    /// Level on which the Laplacian is integrated, `level` at most. Below `level` the displacement is carried up by Loop's stencils:
    /// a quarter of the cost for each level, without the finest wrinkles.
    pub solve_level: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            stage: Stage::Detailed,
            detail: 1.0,
            liveliness: 1.0,
            stop: Stop::Tolerance(1e-5),
            warm_start: false,
            level: usize::MAX,
            solve_level: usize::MAX,
        }
    }
}

/// What a frame consists of, in this order; the parts after [`Part::Base`] belong to the detailed stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// f_d.
    Deformation,
    /// Skinning and subdivision.
    Base,
    /// f_l, turned into the posed frame and refined.
    Laplacian,
    /// Areas, row scales and the wanted Laplacian in metres.
    Residual,
    /// The solver.
    Solve,
}

/// An avatar made ready to move: all that no frame changes, and scratch space, which the first detailed frame makes: an avatar that a GPU
/// poses takes no memory for it.
pub struct Animator {
    base: BaseAnimator,
    domains: Vec<Domain>,
    pub(crate) solver: Solver,
    /// s/a of each vertex, for the levels on which the solver solves, coarsest first.
    scales_per_area: Vec<Vec<f32>>,
    /// δ of f_l, posed, from its own level up to the finest.
    laplacians: Vec<Vec<Vec3A>>,
    areas: Vec<f32>,
    /// What the areas need, for the levels on which the solver solves; made when one first does.
    vertex_areas: Vec<Option<VertexAreas>>,
    residual: Vec<Vec3A>,
    /// From the coarsest level of the solver up.
    displacements: Vec<Vec<Vec3A>>,
    detailed: Vec<Vec3A>,
    iterations: u32,
}

impl Animator {
    /// Prepares `avatar`, after [`Avatar::validate`].
    pub fn new(avatar: Arc<Avatar>) -> Result<Self, AvatarError> {
        Self::over(BaseAnimator::new(avatar)?)
    }

    /// Prepares what `base` still lacks: the solver, and what f_l needs, after a look at its values in the rest pose.
    pub fn over(base: BaseAnimator) -> Result<Self, AvatarError> {
        let (avatar, subdivision) = (base.avatar(), base.subdivision());
        let finest_level = subdivision.level_count();
        let laplacian_level = avatar.laplacian.level();
        let finest_domain = laplacian_level.max(avatar.deformation.level());
        let domains = Domain::levels(&avatar.canonical, &avatar.rig.skin, subdivision, finest_domain);
        let joint_count = avatar.rig.parents.len();
        if let Some(vertex) = avatar.laplacian.not_finite_at_rest(&domains[laplacian_level], joint_count) {
            return Err(AvatarError::not_finite(&avatar.name, "laplacian", vertex));
        }
        let solver = Solver::new(subdivision, &avatar.anchors, avatar.anchor_weight, &avatar.factor)
            .map_err(|error| AvatarError::from_factor(&avatar.name, &error))?;
        let solver_levels = solver.coarsest_level()..=finest_level;
        let scales_per_area =
            |level: usize| solver.valences(level).into_iter().map(scale_per_area).collect::<Vec<f32>>();
        Ok(Self {
            domains,
            scales_per_area: solver_levels.clone().map(scales_per_area).collect(),
            laplacians: vec![Vec::new(); finest_level - laplacian_level + 1],
            areas: Vec::new(),
            vertex_areas: vec![None; solver_levels.clone().count()],
            residual: Vec::new(),
            displacements: vec![Vec::new(); solver_levels.count()],
            detailed: Vec::new(),
            iterations: 0,
            solver,
            base,
        })
    }

    /// Poses the avatar. The result depends on pose and options alone, within the solver's tolerance.
    /// Positions (metres, vertices of [`Options::level`]) stay valid until the next call. `pose` has one rotation for each of the avatar's
    /// joints.
    ///
    /// Nothing is allocated after the first calls.
    pub fn animate(&mut self, pose: &Pose, options: &Options) -> &[Vec3A] {
        self.animate_observed(pose, options, &mut |_| ())
    }

    /// [`Self::animate`], telling `observe` of each part when it is done.
    pub fn animate_observed(&mut self, pose: &Pose, options: &Options, observe: &mut dyn FnMut(Part)) -> &[Vec3A] {
        let level = self.base.level(options);
        self.base.animate_observed(pose, options, observe);
        self.iterations = 0;
        if options.stage != Stage::Detailed || options.detail == 0.0 {
            return self.base.surface.positions(level);
        }
        let solve_level = options.solve_level.clamp(*self.levels().start(), level);
        self.evaluate_laplacian(pose, options.liveliness, solve_level);
        observe(Part::Laplacian);
        self.evaluate_residual(options.detail, solve_level);
        observe(Part::Residual);
        let start = if options.warm_start { Start::Earlier } else { Start::Base };
        let subdivision = self.base.subdivision();
        let residual = &self.residual[..subdivision.vertex_count(solve_level)];
        let solved = solve_level - self.solver.coarsest_level();
        self.iterations =
            self.solver.solve(solve_level, residual, &mut self.displacements[solved], start, options.stop);
        let wanted = level - self.solver.coarsest_level();
        subdivision.refine_upwards(Scheme::Loop, solve_level, &mut self.displacements[solved..=wanted]);
        let displacement = &self.displacements[wanted];
        let base = self.base.surface.positions(level);
        put_sum(base, displacement, &mut self.detailed);
        observe(Part::Solve);
        &self.detailed[..base.len()]
    }

    /// Levels that can be asked for.
    pub fn levels(&self) -> RangeInclusive<usize> {
        self.base.levels()
    }

    /// Makes the space that a detailed frame works in.
    fn make_room(&mut self) {
        let subdivision = self.base.subdivision();
        let finest = subdivision.level_count();
        for vectors in [&mut self.laplacians, &mut self.displacements] {
            let coarsest = finest + 1 - vectors.len();
            for (level, vectors) in (coarsest..).zip(vectors) {
                vectors.resize(subdivision.vertex_count(level), Vec3A::ZERO);
            }
        }
        let count = subdivision.vertex_count(finest);
        self.areas.resize(count, 0.0);
        self.residual.resize(count, Vec3A::ZERO);
        self.detailed.resize(count, Vec3A::ZERO);
    }

    /// f_l, turned into the posed frame and carried to `level` by Loop's stencils.
    fn evaluate_laplacian(&mut self, pose: &Pose, liveliness: f32, level: usize) {
        self.make_room();
        let BaseAnimator { avatar, subdivision, surface, scratch, .. } = &mut self.base;
        let own_level = avatar.laplacian.level();
        let values = &mut self.laplacians[0];
        avatar.laplacian.evaluate_lively(&self.domains[own_level], pose, liveliness, scratch, values);
        surface.turn(subdivision, own_level, &mut self.laplacians[0]);
        subdivision.refine_upwards(Scheme::Loop, own_level, &mut self.laplacians[..=level - own_level]);
    }

    /// f_l at `pose`, the one posed last, in the posed frame: δ, 1/m, at the vertices of `level`. [`Options::detail`] has no say in it.
    pub fn learned_laplacian(&mut self, pose: &Pose, liveliness: f32, level: usize) -> &[Vec3A] {
        let (coarsest, finest) = self.levels().into_inner();
        let level = level.clamp(coarsest, finest);
        self.evaluate_laplacian(pose, liveliness, level);
        &self.laplacians[level - self.base.avatar.laplacian.level()]
    }

    /// r on `level`: s δ in the relative form, s δ − L u in the absolute one, times `detail`.
    fn evaluate_residual(&mut self, detail: f32, level: usize) {
        let base = self.base.surface.positions(level);
        let triangles = self.base.subdivision().triangles(level);
        let vertex_areas = &mut self.vertex_areas[level - self.solver.coarsest_level()];
        let vertex_areas = vertex_areas.get_or_insert_with(|| VertexAreas::new(base.len(), triangles));
        vertex_areas.put(base, triangles, &mut self.areas[..base.len()]);
        let residual = &mut self.residual[..base.len()];
        match self.base.avatar.form {
            Form::Absolute => self.solver.laplacian(level, base, residual),
            Form::Relative => residual.fill(Vec3A::ZERO),
        }
        let deltas = &self.laplacians[level - self.base.avatar.laplacian.level()];
        let scales_per_area = &self.scales_per_area[level - self.solver.coarsest_level()];
        put_residual(detail, &self.areas, scales_per_area, deltas, residual);
    }

    /// Triangles of the finest level.
    pub fn triangles(&self) -> &[Triangle] {
        self.base.triangles()
    }

    /// The avatar.
    pub fn avatar(&self) -> &Avatar {
        self.base.avatar()
    }

    /// The avatar, to keep.
    pub fn shared_avatar(&self) -> Arc<Avatar> {
        Arc::clone(self.base.avatar())
    }

    /// Topology of all levels.
    pub fn subdivision(&self) -> &Subdivision {
        self.base.subdivision()
    }

    /// Query points and masks of all levels up to the finest on which f_d or f_l stands.
    pub fn domains(&self) -> &[Domain] {
        &self.domains
    }

    /// Body or base mesh of the last call, all levels.
    pub fn surface(&self) -> &PosedSurface {
        &self.base.surface
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
