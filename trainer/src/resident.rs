//! Things read by number, of which those that came first stay in memory.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Things that can be read again. What was read stays until its bytes are used up; what comes after is read each time: orders of training
/// are random, so any share that stays is as good as another.
pub struct Resident<'a, T> {
    read: Box<dyn Fn(usize) -> anyhow::Result<T> + Sync + 'a>,
    size: fn(&T) -> usize,
    slots: Vec<OnceLock<Arc<T>>>,
    bytes_left: Mutex<usize>,
}

impl<'a, T> Resident<'a, T> {
    /// `count` things, of which `bytes` stay. `read` gives the same thing whenever it is asked for the same number; `size` says its bytes.
    pub fn new(
        count: usize,
        bytes: usize,
        size: fn(&T) -> usize,
        read: impl Fn(usize) -> anyhow::Result<T> + Sync + 'a,
    ) -> Self {
        let slots = std::iter::repeat_with(OnceLock::new).take(count).collect();
        Self { read: Box::new(read), size, slots, bytes_left: Mutex::new(bytes) }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.slots.len()
    }

    /// Thing `index`, from memory or read now.
    pub fn get(&self, index: usize) -> anyhow::Result<Arc<T>> {
        if let Some(kept) = self.slots[index].get() {
            return Ok(Arc::clone(kept));
        }
        let thing = Arc::new((self.read)(index)?);
        let mut left = self.bytes_left.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(rest) = left.checked_sub((self.size)(&thing))
            && self.slots[index].set(Arc::clone(&thing)).is_ok()
        {
            *left = rest;
        }
        Ok(thing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn what_fits_is_read_once_and_the_rest_each_time() {
        let reads = AtomicUsize::new(0);
        let read = |index: usize| {
            reads.fetch_add(1, Ordering::Relaxed);
            anyhow::ensure!(index != 9, "no nine");
            Ok(vec![index as u8; 10])
        };
        let things = Resident::new(10, 25, |thing: &Vec<u8>| thing.len(), read);
        for _ in 0..3 {
            for index in [4, 2, 7, 1] {
                assert_eq!(*things.get(index).unwrap(), vec![index as u8; 10]);
            }
        }
        assert_eq!(reads.load(Ordering::Relaxed), 2 + 3 * 2, "two stay, two are read thrice");
        assert!(things.get(9).is_err() && things.count() == 10);
    }
}
