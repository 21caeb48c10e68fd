//! Loops over rows, shared out between threads where there are some (feature `threads`).
//!
//! Every row is computed as one thread would compute it, and sums are taken over parts that do not depend on the number of threads: a result
//! is the same to the bit on any number of them.

#[cfg(feature = "threads")]
mod team;

use std::ops::Range;

#[cfg(feature = "threads")]
static TEAM: team::Team = team::Team::new();

/// Takes part in the loops of all threads from now on: the calling thread does nothing else, and does not come back.
#[cfg(feature = "threads")]
pub fn join() -> ! {
    TEAM.join()
}

/// How many threads have joined.
#[cfg(feature = "threads")]
pub fn joined() -> usize {
    TEAM.members()
}

/// Whether loops are shared out from now on, by whichever thread runs them.
#[cfg(feature = "threads")]
pub fn set_shares(shares: bool) {
    TEAM.set_shares(shares);
}

/// Tells that this thread has no loops for a while, so that the others need not look out for them.
pub fn rest() {
    #[cfg(feature = "threads")]
    TEAM.rest();
}

/// Rows that a thread takes at once.
#[cfg(feature = "threads")]
const ROWS_AT_ONCE: usize = 2048;

/// Parts of a sum.
const PARTS: usize = 16;

/// Calls `work` with all of `rows`, part by part: the number of the part's first row, and the part.
#[inline(always)]
pub fn for_rows<T: Send>(rows: &mut [T], work: impl Fn(usize, &mut [T]) + Sync) {
    #[cfg(feature = "threads")]
    if rows.len() > ROWS_AT_ONCE {
        let parts = Parts::new(rows);
        return TEAM.share(parts.count(), &|part| work(part * ROWS_AT_ONCE, parts.get(part)));
    }
    work(0, rows);
}

/// [`for_rows`] of two slices of one length.
#[inline(always)]
pub fn for_row_pairs<A: Send, B: Send>(
    first: &mut [A],
    second: &mut [B],
    work: impl Fn(usize, &mut [A], &mut [B]) + Sync,
) {
    assert_eq!(first.len(), second.len());
    #[cfg(feature = "threads")]
    if first.len() > ROWS_AT_ONCE {
        let (first, second) = (Parts::new(first), Parts::new(second));
        let work = |part| work(part * ROWS_AT_ONCE, first.get(part), second.get(part));
        return TEAM.share(first.count(), &work);
    }
    work(0, first, second);
}

/// `of` of each of the parts into which the rows 0 .. `count` are divided, in their order.
#[inline(always)]
pub fn of_parts<S: Copy + Default + Send>(count: usize, of: impl Fn(Range<usize>) -> S + Sync) -> [S; PARTS] {
    let range = |part: usize| part * count / PARTS..(part + 1) * count / PARTS;
    let mut values = [S::default(); PARTS];
    #[cfg(feature = "threads")]
    if count > ROWS_AT_ONCE {
        let parts = Parts::of(&mut values, 1);
        TEAM.share(parts.count(), &|part| parts.get(part)[0] = of(range(part)));
        return values;
    }
    for (part, value) in values.iter_mut().enumerate() {
        *value = of(range(part));
    }
    values
}

/// A slice in parts that different threads may have.
#[cfg(feature = "threads")]
struct Parts<'a, T> {
    rows: *mut T,
    count: usize,
    at_once: usize,
    slice: std::marker::PhantomData<&'a mut [T]>,
}

#[cfg(feature = "threads")]
#[allow(unsafe_code)]
// SAFETY: it gives every part of a slice away once, as the slice itself could be given away.
unsafe impl<T: Send> Sync for Parts<'_, T> {}

#[cfg(feature = "threads")]
impl<'a, T> Parts<'a, T> {
    fn new(rows: &'a mut [T]) -> Self {
        Self::of(rows, ROWS_AT_ONCE)
    }

    fn of(rows: &'a mut [T], at_once: usize) -> Self {
        Self { rows: rows.as_mut_ptr(), count: rows.len(), at_once, slice: std::marker::PhantomData }
    }

    fn count(&self) -> usize {
        self.count.div_ceil(self.at_once)
    }

    /// Each part once.
    #[allow(unsafe_code, clippy::mut_from_ref)]
    fn get(&self, part: usize) -> &'a mut [T] {
        let first = part * self.at_once;
        let length = self.at_once.min(self.count - first);
        // SAFETY: within the slice that `of` took, and apart from all other parts; `Team::share` takes no part twice.
        unsafe { std::slice::from_raw_parts_mut(self.rows.add(first), length) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// More rows than one thread takes, and no multiple of anything.
    const COUNT: usize = 30_011;

    #[test]
    fn every_row_is_had_once() {
        let (mut rows, mut others) = (vec![0; COUNT], vec![1; COUNT]);
        for_rows(&mut rows, |first, part| (first..).zip(part).for_each(|(number, row)| *row += number));
        for_row_pairs(&mut rows, &mut others, |first, part, others| {
            for (number, (row, other)) in (first..).zip(part.iter_mut().zip(others)) {
                *row += number;
                *other += number;
            }
        });
        assert!(rows.iter().enumerate().all(|(number, &row)| row == 2 * number));
        assert!(others.iter().enumerate().all(|(number, &other)| other == 1 + number));
        for_rows(&mut [0u8; 0], |_, part| assert!(part.is_empty()));
    }

    #[test]
    fn parts_follow_each_other() {
        for count in [0, 5, COUNT] {
            let parts = of_parts(count, |range| (range.start, range.end));
            assert_eq!((parts[0].0, parts[PARTS - 1].1), (0, count));
            assert!(parts.windows(2).all(|pair| pair[0].1 == pair[1].0));
        }
    }
}
