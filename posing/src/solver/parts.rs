//! What the solver is made of, for another implementation of the same solve (`gpu`).

use super::Solver;
use super::factor_pattern::FactorPattern;
use super::normal_operator::NormalOperator;
use crate::mesh::SparseMatrix;

/// A = c LᵀL + BᵀB on a level; L is that of its triangles.
pub struct OperatorParts<'a> {
    /// c
    pub scale: f32,
    /// B
    pub anchors: &'a SparseMatrix,
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
    /// L below its diagonal.
    pub pattern: FactorPattern,
    /// In the pattern's order.
    pub values: Vec<f32>,
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
        let (pattern, values) = solver.columns();
        FactorParts {
            permutation: &solver.permutation,
            reciprocal_diagonal: &solver.reciprocal_diagonal,
            pattern,
            values,
        }
    }
}

fn parts(operator: &NormalOperator) -> OperatorParts<'_> {
    OperatorParts { scale: operator.scale, anchors: &operator.anchors }
}
