//! Work with the interpreter released: it is told of progress, and Ctrl-C stops the work.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

use pyo3::prelude::*;

use stickslip::command::progress::Stages;
use stickslip::error::Error;
use stickslip::provenance::on_behalf_of;
use stickslip::watch::{Stage, Watch};

use crate::raised::raised;

/// Time between two looks at signals and progress.
const LOOK: Duration = Duration::from_millis(50);

/// Hears of the work and passes on whether to stop.
#[derive(Default)]
struct Relay {
    stop: AtomicBool,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    stages: Stages,
    /// What is done and the share of the whole, until it is told.
    news: Option<(String, f64)>,
}

impl Relay {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(|e| e.into_inner())
    }
}

impl Watch for Relay {
    fn stage(&self, stage: Stage) {
        let mut state = self.state();
        if state.stages.begin(stage, Instant::now()) {
            state.news = Some((stage.name.to_owned(), state.stages.share()));
        }
    }
    fn step(&self, what: &str, done: usize, of: usize) {
        let mut state = self.state();
        let news = match state.stages.current() {
            Some(stage) => {
                let words = state.stages.step(stage, what, done, of, Instant::now());
                (words, state.stages.share())
            }
            None => (what.to_owned(), done as f64 / of.max(1) as f64),
        };
        state.news = Some(news);
    }
    fn stop(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
    /// What stops it raises an exception, and no result is returned.
    fn discards(&self) -> bool {
        true
    }
}

/// Does work on behalf of a command line on a thread of its own, while this one looks after signals and calls
/// `progress(what, share)`.
///
/// # Errors
/// Those of the work; what a signal (KeyboardInterrupt) or `progress` raises, after the work has stopped.
pub fn supervised<T: Send>(
    py: Python<'_>,
    line: Vec<String>,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(&dyn Watch) -> Result<T, Error> + Send,
) -> PyResult<T> {
    let heard = Relay::default();
    let relay = &heard;
    let (ended, end) = channel();
    let (found, broken) = py.detach(move || {
        std::thread::scope(|scope| {
            let worker = scope.spawn(move || {
                // Told when it is dropped, also by a panic.
                let _ended = ended;
                on_behalf_of(Some(line), || work(relay))
            });
            let mut broken = None;
            while let Err(RecvTimeoutError::Timeout) = end.recv_timeout(LOOK) as Result<(), _> {
                if broken.is_none() {
                    let looked = Python::attach(|py| look(py, relay, progress));
                    broken = looked.err();
                    relay.stop.store(broken.is_some(), Ordering::Relaxed);
                }
            }
            (worker.join(), broken)
        })
    });
    if let Some(error) = broken {
        return Err(error);
    }
    look(py, relay, progress)?;
    match found {
        Ok(found) => found.map_err(|error| raised(py, &error)),
        Err(panic) => std::panic::resume_unwind(panic),
    }
}

fn look(py: Python<'_>, relay: &Relay, progress: Option<&Py<PyAny>>) -> PyResult<()> {
    py.check_signals()?;
    let news = relay.state().news.take();
    if let (Some(progress), Some((what, share))) = (progress, news) {
        progress.call1(py, (what, share))?;
    }
    Ok(())
}
