//! W = L⁻¹ of the coarse level's factor: what turns two long serial substitutions into two products that run side by side.
//!
//! With the steps in postorder of the elimination tree, row i of W fills just the columns of the subtree of i, which end with i itself,
//! so W needs no indices. Whatever the rounding, Wᵀ D⁻¹ W stays symmetric and positive definite.

use crate::solver::FactorParts;

/// "None" among steps.
pub(super) const NONE: u32 = u32::MAX;

/// The elimination tree in postorder, and W row by row.
pub(super) struct InverseFactor {
    /// Step of the factor at each place of the postorder.
    pub steps: Vec<u32>,
    /// Parent of each place; later than the place itself.
    pub parents: Vec<u32>,
    /// First place of the subtree of each place.
    pub first_columns: Vec<u32>,
    /// Row i starts here in `values`; one more at the end.
    pub offsets: Vec<usize>,
    /// Columns `first_columns[i] ..= i` of each row i.
    pub values: Vec<f32>,
}

impl InverseFactor {
    /// How many values [`Self::new`] will make: the sum of the subtrees' sizes.
    pub fn value_count(factor: &FactorParts<'_>) -> usize {
        let mut sizes = vec![1usize; factor.permutation.len()];
        for j in 0..sizes.len() {
            if let Some(&parent) = factor.pattern.rows[factor.pattern.column(j)].first() {
                sizes[parent as usize] += sizes[j];
            }
        }
        sizes.iter().sum()
    }

    pub fn new(factor: &FactorParts<'_>) -> Self {
        let (steps, places) = postorder(factor);
        let count = steps.len();
        let mut parents = vec![NONE; count];
        let mut first_columns: Vec<u32> = (0..count as u32).collect();
        let mut row_entries = vec![Vec::new(); count];
        for (place, &step) in steps.iter().enumerate() {
            let column = factor.pattern.column(step as usize);
            let rows = &factor.pattern.rows[column.clone()];
            if let Some(&parent) = rows.first() {
                let parent = places[parent as usize];
                parents[place] = parent;
                first_columns[parent as usize] = first_columns[parent as usize].min(first_columns[place]);
            }
            for (&row, &value) in rows.iter().zip(&factor.values[column]) {
                row_entries[places[row as usize] as usize].push((place, value));
            }
        }
        let mut offsets = vec![0];
        for (i, &first) in first_columns.iter().enumerate() {
            offsets.push(offsets[i] + i + 1 - first as usize);
        }
        let mut values = vec![0.0f32; offsets[count]];
        for i in 0..count {
            let (earlier, row) = values.split_at_mut(offsets[i]);
            let row = &mut row[..offsets[i + 1] - offsets[i]];
            row[i - first_columns[i] as usize] = 1.0;
            // L W = I by rows: w_i = e_i − Σ l_ik w_k.
            let first = first_columns[i] as usize;
            let row_of = |&(k, value): &(usize, f32)| Row {
                start: first_columns[k] as usize - first,
                values: &earlier[offsets[k]..offsets[k + 1]],
                factor: value,
            };
            let (fours, rest) = row_entries[i].as_chunks::<4>();
            fours.iter().for_each(|four| subtract_four(row, four.each_ref().map(row_of)));
            rest.iter().for_each(|entry| row_of(entry).subtract(row));
        }
        Self { steps, parents, first_columns, offsets, values }
    }
}

/// A row of W and what it is multiplied by.
#[derive(Clone, Copy)]
struct Row<'a> {
    /// Where it begins in the row that it is taken from.
    start: usize,
    values: &'a [f32],
    factor: f32,
}

impl<'a> Row<'a> {
    fn end(&self) -> usize {
        self.start + self.values.len()
    }

    /// The part between two places of the row that it is taken from.
    fn part(&self, start: usize, end: usize) -> Self {
        let (start, end) = (start.max(self.start), end.min(self.end()));
        let end = end.max(start);
        Self { start, values: &self.values[start - self.start..end - self.start], ..*self }
    }

    fn subtract(&self, from: &mut [f32]) {
        for (entry, value) in from[self.start..self.end()].iter_mut().zip(self.values) {
            *entry -= self.factor * value;
        }
    }
}

/// Subtracts four rows. Neighbouring steps have nearly the same subtree: where all four overlap, `from` is read and written once.
fn subtract_four(from: &mut [f32], rows: [Row<'_>; 4]) {
    let start = rows.iter().map(|row| row.start).fold(0, usize::max);
    let end = rows.iter().map(Row::end).fold(usize::MAX, usize::min);
    if start >= end {
        rows.iter().for_each(|row| row.subtract(from));
        return;
    }
    for row in &rows {
        row.part(0, start).subtract(from);
        row.part(end, usize::MAX).subtract(from);
    }
    let [a, b, c, d] = rows.map(|row| row.part(start, end));
    let pairs = a.values.iter().zip(b.values).zip(c.values.iter().zip(d.values));
    for (entry, ((av, bv), (cv, dv))) in from[start..end].iter_mut().zip(pairs) {
        *entry -= (a.factor * av + b.factor * bv) + (c.factor * cv + d.factor * dv);
    }
}

/// Steps in postorder, and the place of each step.
fn postorder(factor: &FactorParts<'_>) -> (Vec<u32>, Vec<u32>) {
    let count = factor.permutation.len();
    let (mut first_child, mut next_sibling) = (vec![NONE; count], vec![NONE; count]);
    let mut roots = Vec::new();
    for j in (0..count).rev() {
        match factor.pattern.rows[factor.pattern.column(j)].first() {
            Some(&parent) => next_sibling[j] = std::mem::replace(&mut first_child[parent as usize], j as u32),
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
