//! The progress bar of long commands.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use indicatif::{ProgressBar, ProgressStyle};

use crate::watch::Watch;

/// A bar on the terminal with what is in work; Ctrl-C stops the work at its next pause.
pub struct Progress {
    bar: ProgressBar,
    stop: Arc<AtomicBool>,
}

impl Progress {
    /// Steps of a list, with the time left.
    pub const STEPS: &str = "{elapsed_precise} {bar:30} {pos}/{len} {msg} (about {eta} left)";
    /// Share of the whole.
    pub const SHARE: &str = "{elapsed_precise} {bar:30} {percent} % {msg}";

    /// A bar in one of the styles above.
    pub fn new(style: &str) -> Self {
        let bar = ProgressBar::new(1);
        bar.set_style(
            ProgressStyle::with_template(style).unwrap_or_else(|_| ProgressStyle::default_bar()),
        );
        let stop = Arc::new(AtomicBool::new(false));
        let flag = stop.clone();
        // A second registration (several campaigns in one program) is refused and not needed.
        let _ = ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed));
        Self { bar, stop }
    }

    /// Prints without disturbing the bar.
    pub fn suspend<T>(&self, print: impl FnOnce() -> T) -> T {
        self.bar.suspend(print)
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Watch for Progress {
    fn step(&self, what: &str, done: usize, of: usize) {
        self.bar.set_length(of as u64);
        self.bar.set_position(done as u64);
        self.bar.set_message(what.to_owned());
    }
    fn stop(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}
