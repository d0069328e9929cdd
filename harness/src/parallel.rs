//! Work on all processors.

use std::cell::Cell;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::error::Error;

thread_local! {
    /// Whether work of this thread stays on it.
    static ALONE: Cell<bool> = const { Cell::new(false) };
}

/// Does work that stays on the calling thread: [`parallel`] starts no others within it. For many
/// pieces of work that know nothing of each other, one on each processor.
pub fn on_this_thread<R>(work: impl FnOnce() -> R) -> R {
    /// Puts back what was, also where the work panics.
    struct Before(bool);
    impl Drop for Before {
        fn drop(&mut self) {
            ALONE.set(self.0);
        }
    }
    let _before = Before(ALONE.replace(true));
    work()
}

/// Maps a slice on as many threads as there are processors; results in the order of the slice.
/// Within [`on_this_thread`] all is done there, one item after another.
///
/// # Errors
/// The error of the first item of the slice that fails.
pub fn parallel<T: Sync, R: Send>(
    items: &[T],
    work: impl Fn(&T) -> Result<R, Error> + Sync,
) -> Result<Vec<R>, Error> {
    if ALONE.get() {
        return items.iter().map(work).collect();
    }
    let threads = std::thread::available_parallelism()
        .map_or(1, |n| n.get())
        .min(items.len())
        .max(1);
    let next = AtomicUsize::new(0);
    let slots: Vec<Mutex<Option<Result<R, Error>>>> =
        items.iter().map(|_| Mutex::new(None)).collect();
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    let Some(item) = items.get(i) else { break };
                    let result = work(item);
                    *slots[i].lock().unwrap_or_else(|e| e.into_inner()) = Some(result);
                }
            });
        }
    });
    slots
        .into_iter()
        .map(|slot| {
            slot.into_inner()
                .unwrap_or_else(|e| e.into_inner())
                .expect("every item was worked on")
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread::current;

    #[test]
    fn confined_work_stays_on_its_thread_and_the_next_is_free_again() {
        let here = current().id();
        let items = [1, 2, 3, 4];
        let elsewhere = || {
            let found = parallel(&items, |i| Ok((*i, current().id() != here))).unwrap();
            assert_eq!(found.iter().map(|(i, _)| *i).collect::<Vec<_>>(), items);
            found.iter().any(|(_, elsewhere)| *elsewhere)
        };
        assert!(!on_this_thread(elsewhere));
        assert!(elsewhere());
        let _ = std::panic::catch_unwind(|| on_this_thread(|| panic!("on purpose")));
        assert!(elsewhere());
    }
}
