//! What the solver is made of, for another implementation of the same solve (`gpu`).

use super::Solver;
use super::direct::DirectSolver;
use super::normal_operator::NormalOperator;
use crate::mesh::SparseMatrix;
use crate::mesh::rings::Rings;

/// A = c LᵀL + BᵀB on a level; L takes from each vertex the mean of its neighbours.
pub struct OperatorParts<'a> {
    /// c
    pub scale: f32,
    /// B
    pub anchors: &'a SparseMatrix,
    rings: &'a Rings,
}

impl OperatorParts<'_> {
    /// Vertices of the level.
    pub fn vertex_count(&self) -> usize {
        self.rings.vertex_count()
    }

    /// Neighbours of `vertex`.
    pub fn neighbours(&self, vertex: usize) -> impl Iterator<Item = u32> + '_ {
        self.rings.of(vertex)
    }
}

/// A level above the coarsest. Loop's stencils lead there and their transpose back.
pub struct LevelParts<'a> {
    /// The operator of the level.
    pub operator: OperatorParts<'a>,
    /// a of the smoother a (α N + β K) a.
    pub scaling: &'a [f32],
    /// α and β.
    pub weights: [f32; 2],
    /// Smoothing steps before and after the coarser level.
    pub steps: usize,
}

/// P A₀ Pᵀ = L D Lᵀ.
pub struct FactorParts<'a> {
    /// The vertex that each step removes.
    pub permutation: &'a [u32],
    /// D⁻¹
    pub reciprocal_diagonal: &'a [f32],
    solver: &'a DirectSolver,
    /// For each column the panel that it is in.
    panels: Vec<u32>,
}

impl FactorParts<'_> {
    /// (row, value) below the diagonal of column `j` of L; rows ascend.
    pub fn column(&self, j: usize) -> impl Iterator<Item = (u32, f32)> + '_ {
        self.solver.column(self.panels[j], j)
    }

    /// The step after `j` that it changes first: its parent in the elimination tree.
    pub fn parent(&self, j: usize) -> Option<u32> {
        self.column(j).next().map(|(row, _)| row)
    }
}

impl Solver {
    /// The operator of the finest level.
    pub fn operator_parts(&self) -> OperatorParts<'_> {
        parts(&self.operators[0])
    }

    /// Levels above the coarsest, finest first.
    pub fn level_parts(&self) -> impl Iterator<Item = LevelParts<'_>> {
        self.preconditioner.levels.iter().zip(&self.operators).map(|(level, operator)| LevelParts {
            operator: parts(operator),
            scaling: &level.scaling,
            weights: level.weights,
            steps: level.steps,
        })
    }

    /// The coarsest level's factor.
    pub fn factor_parts(&self) -> FactorParts<'_> {
        let solver = &self.preconditioner.coarsest;
        FactorParts {
            permutation: &solver.permutation,
            reciprocal_diagonal: &solver.reciprocal_diagonal,
            panels: solver.panels_of_columns(),
            solver,
        }
    }
}

fn parts(operator: &NormalOperator) -> OperatorParts<'_> {
    OperatorParts { scale: operator.scale, anchors: &operator.anchors, rings: operator.rings() }
}
