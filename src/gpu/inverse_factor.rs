//! W = L⁻¹ of the coarse level's factor: what turns two long serial substitutions into two products that run side by side.
//!
//! With the steps in postorder of the elimination tree, row i of W fills just the columns of the subtree of i, which end with i itself,
//! so W needs no indices. Whatever the rounding, Wᵀ D⁻¹ W stays symmetric and positive definite.

use crate::solver::FactorParts;
use glam::Vec4;
use half::f16;

/// "None" among steps.
pub(super) const NONE: u32 = u32::MAX;

/// The elimination tree in postorder, and where the rows of W lie one after the other.
pub(super) struct InverseFactor {
    /// Step of the factor at each place of the postorder.
    pub steps: Vec<u32>,
    /// Place of each step.
    places: Vec<u32>,
    /// Parent of each place; later than the place itself.
    pub parents: Vec<u32>,
    /// First place of the subtree of each place: row i has the columns `first_columns[i] ..= i`.
    pub first_columns: Vec<u32>,
    /// Where each row begins among all values, an even number; one more at the end.
    pub offsets: Vec<usize>,
}

impl InverseFactor {
    /// How many values the rows of W take.
    pub fn value_count(factor: &FactorParts<'_>) -> usize {
        let mut sizes = vec![1usize; factor.permutation.len()];
        for j in 0..sizes.len() {
            if let Some(parent) = factor.parent(j) {
                sizes[parent as usize] += sizes[j];
            }
        }
        sizes.into_iter().map(padded).sum()
    }

    pub fn new(factor: &FactorParts<'_>) -> Self {
        let (steps, places) = postorder(factor);
        let count = steps.len();
        let mut parents = vec![NONE; count];
        let mut first_columns: Vec<u32> = (0..count as u32).collect();
        for (place, &step) in steps.iter().enumerate() {
            if let Some(parent) = factor.parent(step as usize) {
                let parent = places[parent as usize];
                parents[place] = parent;
                first_columns[parent as usize] = first_columns[parent as usize].min(first_columns[place]);
            }
        }
        let mut offsets = vec![0];
        for (i, &first) in first_columns.iter().enumerate() {
            offsets.push(offsets[i] + padded(i + 1 - first as usize));
        }
        Self { steps, places, parents, first_columns, offsets }
    }

    /// Makes W and hands its rows, some at a time and in their order, to `take`: where they begin among all values, and the values.
    ///
    /// Columns side by side: a block of them solves L w = e_j at once. What the block's columns fill beyond the block are the rows of its
    /// last one, as the subtree of a common ancestor is a run of places. So after a block its own rows are whole, and only those of its last
    /// one's ancestors wait: W, millions of values, is never in memory as a whole.
    pub fn for_each_rows(&self, factor: &FactorParts<'_>, mut take: impl FnMut(usize, &[f16])) {
        let Self { steps, places, parents, first_columns, offsets } = self;
        let count = steps.len();
        let mut rows = vec![Row::default(); count];
        let mut values: Vec<Vec<f16>> = vec![Vec::new(); count];
        let mut whole = Vec::new();
        for first in (0..count).step_by(LANES) {
            let last = (first + LANES).min(count) - 1;
            let mut next = Some(first);
            while let Some(i) = next {
                let mut row = std::mem::take(&mut rows[i]);
                if i <= last {
                    row.as_mut()[i - first] += 1.0;
                }
                for (below, value) in factor.column(steps[i] as usize) {
                    rows[places[below as usize] as usize].subtract(value, &row);
                }
                let columns = first.max(first_columns[i] as usize)..=last.min(i);
                let lanes = &row.as_mut()[columns.start() - first..=columns.end() - first];
                values[i].extend(lanes.iter().map(|&lane| f16::from_f32(lane)));
                next = if i < last { Some(i + 1) } else { Some(parents[i] as usize).filter(|_| parents[i] != NONE) };
            }
            whole.clear();
            for (row, end) in values[first..=last].iter_mut().zip(&offsets[first + 1..]) {
                whole.append(&mut std::mem::take(row));
                whole.resize(end - offsets[first], f16::ZERO);
            }
            take(offsets[first], &whole);
        }
    }
}

/// Rows begin at whole words.
fn padded(length: usize) -> usize {
    length.next_multiple_of(2)
}

/// Columns that are made together.
const LANES: usize = 16;

/// What is known so far of one row of W in a block of columns.
#[derive(Clone, Copy, Default)]
struct Row([Vec4; LANES / 4]);

impl Row {
    fn subtract(&mut self, factor: f32, other: &Self) {
        for (four, other) in self.0.iter_mut().zip(&other.0) {
            *four -= *other * factor;
        }
    }

    fn as_mut(&mut self) -> &mut [f32] {
        bytemuck::cast_slice_mut(&mut self.0)
    }
}

/// Steps in postorder, and the place of each step.
fn postorder(factor: &FactorParts<'_>) -> (Vec<u32>, Vec<u32>) {
    let count = factor.permutation.len();
    let (mut first_child, mut next_sibling) = (vec![NONE; count], vec![NONE; count]);
    let mut roots = Vec::new();
    for j in (0..count).rev() {
        match factor.parent(j) {
            Some(parent) => next_sibling[j] = std::mem::replace(&mut first_child[parent as usize], j as u32),
            None => roots.push(j as u32),
        }
    }
    let (mut steps, mut places) = (Vec::with_capacity(count), vec![0; count]);
    // A step is left when its children are done, which the list then no longer has.
    let mut open = roots;
    while let Some(&step) = open.last() {
        match first_child[step as usize] {
            NONE => {
                places[step as usize] = steps.len() as u32;
                steps.push(step);
                open.pop();
            }
            child => {
                first_child[step as usize] = next_sibling[child as usize];
                open.push(child);
            }
        }
    }
    (steps, places)
}
