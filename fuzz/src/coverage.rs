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
    pub fn has_more(&self) -> bool {
        counting(&self.ranges)
            .any(|(at, counters)| counters.iter().zip(&self.seen[at..]).any(|(&count, &seen)| count != 0 && seen == 0))
    }

    /// Whether a counter has a magnitude since [`Self::reset`] that it never had, and notes it.
    pub fn is_new(&mut self) -> bool {
        let mut is_new = false;
        for (at, counters) in counting(&self.ranges) {
            for (count, seen) in counters.iter().zip(&mut self.seen[at..]) {
                let magnitude = count.checked_ilog2().map_or(0, |log| 1 << log);
                is_new |= magnitude & !*seen != 0;
                *seen |= magnitude;
            }
        }
        is_new
    }
}

/// Chunks of counters of which one counts, each with the place of its first among all: most of the program does not run.
fn counting(ranges: &[(*mut u8, usize)]) -> impl Iterator<Item = (usize, &'static [u8])> {
    let mut begin = 0;
    let chunks = ranges.iter().flat_map(move |&(start, length)| {
        #[expect(unsafe_code, reason = "as in reset")]
        // SAFETY: the section that `reset` writes; what other threads count meanwhile may be seen or not.
        let counters = unsafe { std::slice::from_raw_parts(start, length) };
        let first = begin;
        begin += length;
        counters.chunks(CHUNK).enumerate().map(move |(index, chunk)| (first + index * CHUNK, chunk))
    });
    chunks.filter(|(_, chunk)| chunk.iter().any(|&count| count != 0))
}

impl Default for Coverage {
    fn default() -> Self {
        Self::new()
    }
}
