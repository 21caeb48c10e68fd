//! Which branches ran: the counters that the compiler adds where `cargo xtask fuzz` asks for them. Without, there are none.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

/// Counters that are looked at together.
const CHUNK: usize = 32;

/// Address ranges of the counters, one for each linked module.
static RANGES: Mutex<BTreeSet<(usize, usize)>> = Mutex::new(BTreeSet::new());

/// LLVM's coverage calls this once for each module, before `main`, with its first counter and the end of them.
#[expect(unsafe_code, reason = "the name by which LLVM's instrumentation finds it; it only notes two addresses")]
#[unsafe(no_mangle)]
pub extern "C" fn __sanitizer_cov_8bit_counters_init(start: *mut u8, stop: *mut u8) {
    if start < stop {
        RANGES.lock().unwrap_or_else(PoisonError::into_inner).insert((start.addr(), stop.addr()));
    }
}

/// What earlier inputs have reached: for each counter, the orders of magnitude that it had.
pub struct Coverage {
    ranges: Vec<(*mut u8, usize)>,
    seen: Vec<u8>,
}

impl Coverage {
    /// Nothing reached yet.
    pub fn new() -> Self {
        let ranges = RANGES.lock().unwrap_or_else(PoisonError::into_inner);
        let ranges: Vec<(*mut u8, usize)> =
            ranges.iter().map(|&(start, stop)| (std::ptr::with_exposed_provenance_mut(start), stop - start)).collect();
        Self { seen: vec![0; ranges.iter().map(|range| range.1).sum()], ranges }
    }

    /// How many counters there are; none in a build without instrumentation.
    pub fn len(&self) -> usize {
        self.seen.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.seen.is_empty()
    }

    /// Sets every counter to zero.
    #[expect(
        unsafe_code,
        reason = "counters are the module's own static memory, named by the instrumentation that made them"
    )]
    pub fn reset(&mut self) {
        for &(start, length) in &self.ranges {
            // SAFETY: the range is a writable section of this program, which lives as long as it; counters are plain bytes.
            unsafe { start.write_bytes(0, length) };
        }
    }

    /// Whether a counter counts since [`Self::reset`] that never did. Notes nothing.
    #[expect(unsafe_code, reason = "as in reset")]
    pub fn has_more(&self) -> bool {
        let mut seen = self.seen.as_slice();
        self.ranges.iter().any(|&(start, length)| {
            // SAFETY: as in `is_new`.
            let counters = unsafe { std::slice::from_raw_parts(start, length) };
            let (own, rest) = seen.split_at(length);
            seen = rest;
            let is_more = |(counters, seen): (&[u8], &[u8])| {
                // Most of the program does not run.
                counters.iter().any(|&count| count != 0)
                    && counters.iter().zip(seen).any(|(&count, &seen)| count != 0 && seen == 0)
            };
            counters.chunks(CHUNK).zip(own.chunks(CHUNK)).any(is_more)
        })
    }

    /// Whether a counter has a magnitude since [`Self::reset`] that it never had, and notes it.
    #[expect(unsafe_code, reason = "as in reset")]
    pub fn is_new(&mut self) -> bool {
        let mut is_new = false;
        let mut seen = self.seen.as_mut_slice();
        for &(start, length) in &self.ranges {
            // SAFETY: the section that `reset` writes; what other threads count meanwhile may be seen or not.
            let counters = unsafe { std::slice::from_raw_parts(start, length) };
            let (own, rest) = seen.split_at_mut(length);
            seen = rest;
            for (counters, seen) in counters.chunks(CHUNK).zip(own.chunks_mut(CHUNK)) {
                // Most of the program does not run.
                if counters.iter().all(|&count| count == 0) {
                    continue;
                }
                for (count, seen) in counters.iter().zip(seen) {
                    let magnitude = count.checked_ilog2().map_or(0, |log| 1 << log);
                    is_new |= magnitude & !*seen != 0;
                    *seen |= magnitude;
                }
            }
        }
        is_new
    }
}

impl Default for Coverage {
    fn default() -> Self {
        Self::new()
    }
}
