//! Many points on all cores.

use super::{Carry, Motion, Rule, StartRule, Values, evaluate};
use crate::error::PhysicsError;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::channel;

/// One point to be evaluated.
#[derive(Debug, Clone)]
pub struct Task {
    /// The caller's number for it.
    pub id: usize,
    /// Values of the model's variables.
    pub values: Values,
    /// How it starts.
    pub start: StartRule,
}

/// Points one after the other, each of which may start from the one before.
#[derive(Debug, Clone, Default)]
pub struct Chain {
    /// Where the motion was before the first.
    pub carried: Option<Carry>,
    /// The points.
    pub tasks: Vec<Task>,
}

/// What became of a task.
#[derive(Debug)]
pub struct Outcome {
    /// The caller's number.
    pub id: usize,
    /// Its motion, or why there is none.
    pub motion: Result<Motion, PhysicsError>,
}

/// Evaluates all chains on `threads` threads and hands each outcome to `sink` as it comes, in any order.
///
/// What is computed does not depend on the number of threads. `sink` is called on the caller's thread; when it says
/// no, what is in work is finished and dropped, and nothing new begun.
pub fn run(chains: &[Chain], rule: &Rule, threads: usize, mut sink: impl FnMut(Outcome) -> bool) {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = channel();
    std::thread::scope(|scope| {
        for _ in 0..threads.clamp(1, chains.len().max(1)) {
            let (sender, next) = (sender.clone(), &next);
            scope.spawn(move || {
                while let Some(chain) = chains.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let mut carried = chain.carried.clone();
                    for task in &chain.tasks {
                        let motion = task.values.subject().and_then(|subject| {
                            evaluate(&subject, rule, &task.start, carried.as_ref())
                        });
                        if let Ok(Motion { end: Some(end), .. }) = &motion {
                            carried = Some(end.clone());
                        }
                        let outcome = Outcome {
                            id: task.id,
                            motion,
                        };
                        // No one listens any more: the caller has stopped.
                        if sender.send(outcome).is_err() {
                            return;
                        }
                    }
                }
            });
        }
        drop(sender);
        for outcome in &receiver {
            if !sink(outcome) {
                break;
            }
        }
        drop(receiver);
    });
}
