//! What reading a file may hold in memory: bounded by the file's size, so that a small file cannot claim a machine.

use std::cell::Cell;

/// Memory that reading one file may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryLimit {
    /// Multiple of the file's size …
    pub times_file: usize,
    /// … and bytes beyond that.
    pub plus: usize,
}

impl Default for MemoryLimit {
    /// Four times the file and 64 MiB: more than bodies, motions and avatars in use take.
    fn default() -> Self {
        Self { times_file: 4, plus: 64 << 20 }
    }
}

/// The limit for one file, and what of it is taken.
#[derive(Debug)]
pub struct Allowance {
    limit: MemoryLimit,
    total: usize,
    held: Cell<usize>,
}

/// More memory is needed than a file may take, in the words of readers' errors.
#[derive(Clone, Debug, PartialEq)]
pub struct Shortage {
    /// What the file may take.
    pub expected: String,
    /// What it takes, and what it wants beyond that.
    pub found: String,
}

impl Allowance {
    /// For a file of `file_size` bytes; nothing is taken yet.
    pub fn new(limit: MemoryLimit, file_size: usize) -> Self {
        let total = limit.times_file.saturating_mul(file_size).saturating_add(limit.plus);
        Self { limit, total, held: Cell::new(0) }
    }

    /// Takes `bytes` for as long as the file is read.
    pub fn hold(&self, bytes: usize) -> Result<(), Shortage> {
        self.afford(bytes)?;
        self.held.set(self.held.get() + bytes);
        Ok(())
    }

    /// Bytes that can still be had.
    pub fn left(&self) -> usize {
        self.total - self.held.get()
    }

    /// Makes room for `more` items in a list that is kept, at least doubling it where it is full. While items move, both places are needed.
    pub fn grow<T>(&self, items: &mut Vec<T>, more: usize) -> Result<(), Shortage> {
        let (length, capacity) = (items.len(), items.capacity());
        if capacity - length >= more {
            return Ok(());
        }
        let wanted = length.saturating_add(more).max(capacity.saturating_mul(2));
        self.afford(wanted.saturating_mul(size_of::<T>()))?;
        items.reserve_exact(wanted - length);
        self.hold((wanted - capacity) * size_of::<T>())
    }

    /// Whether `bytes` more can be had for a while.
    pub fn afford(&self, bytes: usize) -> Result<(), Shortage> {
        if self.held.get().saturating_add(bytes) <= self.total {
            return Ok(());
        }
        let MemoryLimit { times_file, plus } = self.limit;
        Err(Shortage {
            expected: format!("at most {} bytes in memory, {times_file} times the file and {plus}", self.total),
            found: format!("{} and {bytes} more", self.held.get()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_held_counts_and_what_is_afforded_does_not() {
        let allowance = Allowance::new(MemoryLimit { times_file: 2, plus: 10 }, 5);
        assert!(allowance.afford(20).is_ok());
        assert!(allowance.hold(15).is_ok());
        assert!(allowance.afford(5).is_ok());
        let shortage = allowance.hold(6).unwrap_err();
        assert_eq!(shortage.expected, "at most 20 bytes in memory, 2 times the file and 10");
        assert_eq!(shortage.found, "15 and 6 more");
        assert!(allowance.hold(usize::MAX).is_err());
        assert!(allowance.hold(5).is_ok());
        assert_eq!(allowance.left(), 0);
    }

    #[test]
    fn lists_grow_until_both_places_are_too_large() {
        let allowance = Allowance::new(MemoryLimit { times_file: 0, plus: 100 }, 0);
        let mut items: Vec<u32> = Vec::new();
        let fitted = (0..100).take_while(|&item| allowance.grow(&mut items, 1).map(|()| items.push(item)).is_ok());
        // 16 items take 64 bytes; 32 would take 128.
        assert_eq!((fitted.count(), items.capacity()), (16, 16));
        assert!(allowance.grow(&mut items, usize::MAX).is_err());
    }
}
