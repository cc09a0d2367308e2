//! Values that several threads need and one of them makes.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Values by key, each made once: of threads that ask for the same one at the same time, one makes it and the
/// others wait. Clones share the values.
#[derive(Debug)]
pub struct Once<K, V> {
    made: Arc<Mutex<BTreeMap<K, Arc<OnceLock<V>>>>>,
}

impl<K: Ord, V: Clone> Once<K, V> {
    /// The value of a key. `make` must not ask for the same key, and must not wait for other threads.
    pub fn get(&self, key: K, make: impl FnOnce() -> V) -> V {
        let value = {
            let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
            made.entry(key).or_default().clone()
        };
        value.get_or_init(make).clone()
    }
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
}
