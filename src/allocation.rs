//! The allocator of the binaries: a thread can have a memory limit, and stops before it would exceed it.
//!
//! The standard library ends the process when an allocation fails and cannot fail one thread alone. A thread
//! that would exceed its limit therefore never gets an answer: it sleeps until the process ends, and the
//! thread that waits for it is notified. Use it only for optional work.

use std::alloc::{GlobalAlloc, Layout};
use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use mimalloc::MiMalloc;

/// mimalloc with per-thread limits; `check` allocates many small values (docs/explanation/build.md).
#[derive(Debug)]
pub struct Limited;

/// Remaining memory of a thread.
#[derive(Clone, Copy)]
struct Budget {
    /// Bytes.
    left: usize,
    /// Set when the thread stops; outlives the limit.
    exceeded: *const AtomicBool,
}

thread_local! {
    /// The limit of this thread, or `None`.
    static BUDGET: Cell<Option<Budget>> = const { Cell::new(None) };
}

/// Runs a function that may allocate at most `bytes` more than now. If it would exceed them, `exceeded` is
/// set and the current thread sleeps until the process ends. Has no effect unless [`Limited`] is the
/// program's allocator.
pub fn limited<T>(bytes: usize, exceeded: &AtomicBool, run: impl FnOnce() -> T) -> T {
    /// Removes the limit, also when `run` panics.
    struct Lifted(Option<Budget>);
    impl Drop for Lifted {
        fn drop(&mut self) {
            BUDGET.set(self.0);
        }
    }
    let _lifted = Lifted(BUDGET.replace(Some(Budget { left: bytes, exceeded })));
    run()
}

/// Whether [`Limited`] is the program's allocator, so that [`limited`] has an effect.
pub fn is_limiting() -> bool {
    const ENOUGH: usize = 1 << 20;
    let before = BUDGET.replace(Some(Budget { left: ENOUGH, exceeded: std::ptr::null() }));
    let probe = std::hint::black_box(Box::new(0_u64));
    let after = BUDGET.replace(before);
    drop(probe);
    after.is_some_and(|after| after.left < ENOUGH)
}

/// Takes bytes from the budget of this thread and stops the thread if too few are left.
fn take(bytes: usize) {
    // A thread that is ending has no limit any more.
    let Ok(Some(budget)) = BUDGET.try_with(Cell::get) else { return };
    let Some(left) = budget.left.checked_sub(bytes) else { stop(budget) };
    let _ = BUDGET.try_with(|cell| cell.set(Some(Budget { left, ..budget })));
}

/// Gives bytes back.
fn give(bytes: usize) {
    let Ok(Some(budget)) = BUDGET.try_with(Cell::get) else { return };
    let _ =
        BUDGET.try_with(|cell| cell.set(Some(Budget { left: budget.left.saturating_add(bytes), ..budget })));
}

fn stop(budget: Budget) -> ! {
    // SAFETY: `limited` keeps the reference alive while this thread has the budget, and this thread never
    // continues.
    unsafe { &*budget.exceeded }.store(true, Ordering::SeqCst);
    loop {
        std::thread::sleep(Duration::from_secs(3600));
    }
}

// SAFETY: every call is passed to mimalloc unchanged, or never returns. The budget is a plain
// cell without a destructor, so that reading it does not allocate.
unsafe impl GlobalAlloc for Limited {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        take(layout.size());
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { MiMalloc.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        take(layout.size());
        // SAFETY: the caller keeps the contract of `alloc_zeroed`.
        unsafe { MiMalloc.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        match size.checked_sub(layout.size()) {
            Some(more) => take(more),
            None => give(layout.size() - size),
        }
        // SAFETY: the pointer came from `alloc` with this layout, and the caller keeps the contract of
        // `realloc`.
        unsafe { MiMalloc.realloc(pointer, layout, size) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        give(layout.size());
        // SAFETY: the pointer came from `alloc` above with this layout.
        unsafe { MiMalloc.dealloc(pointer, layout) }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    #[test]
    fn a_thread_that_would_exceed_its_limit_stops_and_says_so() {
        let exceeded = Arc::new(AtomicBool::new(false));
        let told = exceeded.clone();
        let thread = std::thread::spawn(move || {
            limited(1000, &told, || {
                for bytes in [600, 300] {
                    take(bytes);
                    give(bytes);
                }
                take(900);
                take(200);
            })
        });
        while !exceeded.load(Ordering::SeqCst) {
            assert!(!thread.is_finished(), "it exceeded its limit and continued");
            std::thread::sleep(Duration::from_millis(1));
        }
        assert!(!thread.is_finished());
    }

    #[test]
    fn the_limit_ends_with_the_work() {
        let exceeded = AtomicBool::new(false);
        limited(10, &exceeded, || take(10));
        take(1_000_000);
        assert!(std::panic::catch_unwind(|| limited(10, &exceeded, || panic!("it goes wrong"))).is_err());
        assert!(BUDGET.get().is_none() && !exceeded.load(Ordering::SeqCst));
    }
}
