//! Values that several threads need and one of them makes.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Values by key, each made once: of threads that ask for the same one at the same time, one makes it and the
/// others do other work or wait. Clones share the values.
#[derive(Debug)]
pub struct Once<K, V> {
    made: Arc<Mutex<BTreeMap<K, Arc<OnceLock<V>>>>>,
}

thread_local! {
    /// Whether this thread may not begin other work while it waits: it makes a value, for which that work could
    /// ask, or it has begun some already, which no other thread can finish and which takes room on the stack.
    static IS_BUSY: Cell<bool> = const { Cell::new(false) };
}

impl<K: Ord, V: Clone> Once<K, V> {
    /// The value of a key. `make` must not ask for the same key, and must not wait for other threads.
    pub fn get(&self, key: K, make: impl FnOnce() -> V) -> V {
        let (value, is_first) = {
            let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
            match made.entry(key) {
                Entry::Vacant(entry) => (entry.insert(Arc::default()).clone(), true),
                Entry::Occupied(entry) => (entry.get().clone(), false),
            }
        };
        if !is_first {
            work_until(|| value.get().is_some());
        }
        value.get_or_init(|| busy(make)).clone()
    }
}

/// Does other work of the thread pool until the condition holds or no work is left.
fn work_until(holds: impl Fn() -> bool) {
    while !holds() && !IS_BUSY.get() && busy(rayon::yield_now) == Some(rayon::Yield::Executed) {}
}

fn busy<T>(work: impl FnOnce() -> T) -> T {
    let before = IS_BUSY.replace(true);
    let done = work();
    IS_BUSY.set(before);
    done
}

impl<K, V> Clone for Once<K, V> {
    fn clone(&self) -> Self {
        Self { made: self.made.clone() }
    }
}

impl<K, V> Default for Once<K, V> {
    fn default() -> Self {
        Self { made: Arc::default() }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    #[test]
    fn a_value_is_made_once_however_many_threads_ask_for_it() {
        let (values, calls) = (Once::<u8, usize>::default(), AtomicUsize::new(0));
        let ask = |key: u8| values.clone().get(key, || calls.fetch_add(1, Ordering::SeqCst));
        std::thread::scope(|scope| {
            for thread in 0..8 {
                scope.spawn(move || ask(thread % 2));
            }
        });
        assert_eq!(calls.load(Ordering::SeqCst), 2);
        assert_eq!(ask(0) + ask(1), 1, "each key has its own value");
    }

    #[test]
    fn a_thread_that_waits_does_other_work_of_its_pool() {
        use rayon::prelude::*;
        let (values, calls) = (Once::<usize, usize>::default(), AtomicUsize::new(0));
        let make = |key: usize| {
            calls.fetch_add(1, Ordering::SeqCst);
            std::thread::sleep(std::time::Duration::from_millis(5));
            key * key
        };
        let (begun, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let ask = |task: usize| {
            most.fetch_max(begun.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
            let sum: usize = [0, task % 3].map(|key| values.get(key, || make(key))).iter().sum();
            begun.fetch_sub(1, Ordering::SeqCst);
            sum
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool");
        let sums: Vec<usize> = pool.install(|| (0..200).into_par_iter().map(ask).collect());
        assert!(sums.iter().enumerate().all(|(task, sum)| *sum == (task % 3) * (task % 3)));
        assert_eq!(calls.load(Ordering::SeqCst), 3);
        let most = most.load(Ordering::SeqCst);
        assert!(most > 2 && most <= 4, "{most} at once in two threads");
    }
}
