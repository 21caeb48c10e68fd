//! Values that are made when they are asked for, the latest of them kept: what training streams from disk in bounded memory.

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex, PoisonError};

/// A value for each index, made by `make`; `capacity` of them are kept.
pub struct Stream<T, F> {
    make: F,
    capacity: usize,
    kept: Mutex<Kept<T>>,
}

struct Kept<T> {
    values: HashMap<usize, Arc<T>>,
    /// Oldest first.
    order: VecDeque<usize>,
}

impl<T, F: Fn(usize) -> anyhow::Result<T>> Stream<T, F> {
    /// Keeps `capacity` values, at least one.
    pub fn new(capacity: usize, make: F) -> Self {
        let kept = Mutex::new(Kept { values: HashMap::new(), order: VecDeque::new() });
        Self { make, capacity: capacity.max(1), kept }
    }

    /// The value of `index`. Threads that ask for one that nobody has yet may each make it: it is the same.
    pub fn get(&self, index: usize) -> anyhow::Result<Arc<T>> {
        if let Some(value) = self.kept().values.get(&index) {
            return Ok(Arc::clone(value));
        }
        let value = Arc::new((self.make)(index)?);
        let mut kept = self.kept();
        if kept.values.insert(index, Arc::clone(&value)).is_none() {
            kept.order.push_back(index);
        }
        while kept.order.len() > self.capacity {
            if let Some(oldest) = kept.order.pop_front() {
                kept.values.remove(&oldest);
            }
        }
        Ok(value)
    }

    fn kept(&self) -> std::sync::MutexGuard<'_, Kept<T>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::ensure;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn values_are_made_once_while_there_is_room_and_again_after() {
        let made = AtomicUsize::new(0);
        let stream = Stream::new(2, |index| {
            made.fetch_add(1, Ordering::Relaxed);
            ensure!(index < 9, "no such value");
            Ok(10 * index)
        });
        let get = |index| *stream.get(index).unwrap();
        assert_eq!([get(1), get(2), get(1), get(2)], [10, 20, 10, 20]);
        assert_eq!(made.load(Ordering::Relaxed), 2);
        assert_eq!([get(3), get(1)], [30, 10]);
        assert_eq!(made.load(Ordering::Relaxed), 4, "the oldest went");
        assert_eq!(stream.kept().values.len(), 2);
        assert!(stream.get(9).is_err());
    }
}
