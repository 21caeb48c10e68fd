//! Solving with an LDLᵀ factor.

use super::factor_pattern::{FactorPattern, inverse_permutation};
use super::{CoarseFactor, FactorError};
use crate::mesh::Adjacency;
use glam::Vec3A;
use std::ops::Range;

/// Columns of a panel at most: as many as a vector register has lanes.
const WIDTH: usize = 4;

/// Neighbouring columns of L whose entries below the panel stand in the same rows. Taking them together reads and writes the right side
/// once for all of them.
#[derive(Clone, Debug)]
struct Panel {
    /// The first column.
    first: u32,
    /// Columns, 1 to [`WIDTH`].
    width: u32,
    /// `triangle[i][j]` is L's entry of the panel's row i, column j, below the diagonal; zero elsewhere.
    triangle: [[f32; WIDTH]; WIDTH],
    /// Where its rows and their values are.
    range: Range<u32>,
}

/// A factor ready to solve with.
#[derive(Clone, Debug)]
pub(super) struct DirectSolver {
    pub permutation: Vec<u32>,
    panels: Vec<Panel>,
    /// Rows below each panel, and their entries in its columns.
    rows: Vec<u32>,
    values: Vec<[f32; WIDTH]>,
    pub reciprocal_diagonal: Vec<f32>,
    /// The right side and then the solution, in elimination order.
    permuted: Vec<Vec3A>,
}

impl DirectSolver {
    /// Checks `factor` against the pattern that `coupling` and its permutation have.
    pub fn new(coupling: &Adjacency, factor: &CoarseFactor) -> Result<Self, FactorError> {
        let count = coupling.vertex_count();
        check_length("permutation", count, factor.permutation.len())?;
        check_length("diagonal", count, factor.diagonal.len())?;
        let step_of =
            inverse_permutation(&factor.permutation).ok_or(FactorError::NotAPermutation { expected: count })?;
        let pattern = FactorPattern::new(coupling, &factor.permutation, &step_of);
        check_length("values", pattern.rows.len(), factor.values.len())?;
        let entries: Vec<f32> = factor.values.iter().map(|value| value.to_f32()).collect();
        check_each("diagonal", "positive and finite", &factor.diagonal, |d| d > 0.0 && d.is_finite())?;
        check_each("values", "finite", &entries, f32::is_finite)?;
        let panels = panels(&pattern);
        let row_count = panels.iter().map(|columns| pattern.column(columns.end - 1).len()).sum();
        let mut solver = Self {
            permutation: factor.permutation.clone(),
            panels: Vec::with_capacity(panels.len()),
            rows: Vec::with_capacity(row_count),
            values: Vec::with_capacity(row_count),
            reciprocal_diagonal: factor.diagonal.iter().map(|d| d.recip()).collect(),
            permuted: vec![Vec3A::ZERO; count],
        };
        for columns in panels {
            solver.push_panel(&pattern, &entries, columns);
        }
        Ok(solver)
    }

    /// Appends the panel of these columns.
    fn push_panel(&mut self, pattern: &FactorPattern, entries: &[f32], columns: Range<usize>) {
        let (first, width) = (columns.start, columns.len());
        let mut triangle = [[0.0; WIDTH]; WIDTH];
        let start = self.rows.len();
        self.rows.extend_from_slice(&pattern.rows[pattern.column(first + width - 1)]);
        self.values.resize(self.rows.len(), [0.0; WIDTH]);
        for j in 0..width {
            let (inside, below) = entries[pattern.column(first + j)].split_at(width - 1 - j);
            for (i, &entry) in inside.iter().enumerate() {
                triangle[j + 1 + i][j] = entry;
            }
            for (values, &entry) in self.values[start..].iter_mut().zip(below) {
                values[j] = entry;
            }
        }
        let range = start as u32..self.rows.len() as u32;
        self.panels.push(Panel { first: first as u32, width: width as u32, triangle, range });
    }

    /// For each column the panel that it is in.
    pub fn panels_of_columns(&self) -> Vec<u32> {
        let panels = self.panels.iter().zip(0u32..);
        panels.flat_map(|(panel, number)| std::iter::repeat_n(number, panel.width as usize)).collect()
    }

    /// (row, value) below the diagonal of column `j` of L, which is in the panel of number `panel`; rows ascend.
    pub fn column(&self, panel: u32, j: usize) -> impl Iterator<Item = (u32, f32)> + '_ {
        let panel = &self.panels[panel as usize];
        let own = j - panel.first as usize;
        let inside = (own + 1..panel.width as usize).map(move |i| (panel.first + i as u32, panel.triangle[i][own]));
        let below = self.rows[panel.rows()].iter().zip(&self.values[panel.rows()]);
        inside.chain(below.map(move |(&row, values)| (row, values[own])))
    }

    /// x = Pᵀ L⁻ᵀ D⁻¹ L⁻¹ P b.
    pub fn solve(&mut self, b: &[Vec3A], x: &mut [Vec3A]) {
        let Self { permutation, panels, rows, values, reciprocal_diagonal, permuted } = self;
        for (y, &vertex) in permuted.iter_mut().zip(&*permutation) {
            *y = b[vertex as usize];
        }
        for panel in &*panels {
            let own = panel.columns();
            let mut y = [Vec3A::ZERO; WIDTH];
            for (y, own) in y.iter_mut().zip(&mut permuted[own]) {
                *y = *own;
            }
            for i in 1..WIDTH {
                for j in 0..i {
                    y[i] -= y[j] * panel.triangle[i][j];
                }
            }
            let own = &mut permuted[panel.columns()];
            own.copy_from_slice(&y[..own.len()]);
            for (&row, value) in rows[panel.rows()].iter().zip(&values[panel.rows()]) {
                permuted[row as usize] -= (y[0] * value[0] + y[1] * value[1]) + (y[2] * value[2] + y[3] * value[3]);
            }
        }
        for panel in panels.iter().rev() {
            let mut sums = [Vec3A::ZERO; WIDTH];
            for (&row, value) in rows[panel.rows()].iter().zip(&values[panel.rows()]) {
                let below = permuted[row as usize];
                for j in 0..WIDTH {
                    sums[j] += below * value[j];
                }
            }
            let own = permuted[panel.columns()].iter().zip(&reciprocal_diagonal[panel.columns()]);
            let mut y = [Vec3A::ZERO; WIDTH];
            for ((y, (own, &reciprocal)), sum) in y.iter_mut().zip(own).zip(sums) {
                *y = *own * reciprocal - sum;
            }
            for j in (0..WIDTH - 1).rev() {
                for i in j + 1..WIDTH {
                    y[j] -= y[i] * panel.triangle[i][j];
                }
            }
            let own = &mut permuted[panel.columns()];
            own.copy_from_slice(&y[..own.len()]);
        }
        for (y, &vertex) in permuted.iter().zip(&*permutation) {
            x[vertex as usize] = *y;
        }
    }
}

/// The columns of each panel.
fn panels(pattern: &FactorPattern) -> Vec<Range<usize>> {
    let rows = |j: usize| &pattern.rows[pattern.column(j)];
    let is_continued =
        |j: usize| rows(j).split_first().is_some_and(|(&next, below)| next as usize == j + 1 && below == rows(j + 1));
    let (mut panels, mut first) = (Vec::new(), 0);
    while first + 1 < pattern.offsets.len() {
        let width = (1..WIDTH).find(|&width| !is_continued(first + width - 1)).unwrap_or(WIDTH);
        panels.push(first..first + width);
        first += width;
    }
    panels
}

impl Panel {
    fn columns(&self) -> Range<usize> {
        self.first as usize..(self.first + self.width) as usize
    }

    fn rows(&self) -> Range<usize> {
        self.range.start as usize..self.range.end as usize
    }
}

fn check_length(field: &'static str, expected: usize, found: usize) -> Result<(), FactorError> {
    if expected == found { Ok(()) } else { Err(FactorError::Length { field, expected, found }) }
}

fn check_each(
    field: &'static str,
    expected: &'static str,
    values: &[f32],
    is_fine: impl Fn(f32) -> bool,
) -> Result<(), FactorError> {
    match values.iter().position(|&value| !is_fine(value)) {
        Some(index) => Err(FactorError::Value { field, index, expected, found: values[index] }),
        None => Ok(()),
    }
}
