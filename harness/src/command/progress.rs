//! The progress bar of long commands.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressStyle};

use crate::watch::{Stage, Watch};

/// A bar on the terminal with what is in work; Ctrl-C stops the work at its next pause.
pub struct Progress {
    bar: ProgressBar,
    stop: Arc<AtomicBool>,
    stages: Mutex<Stages>,
}

/// Where work with stages stands, for whoever shows it.
#[derive(Debug, Default)]
pub struct Stages {
    /// Stages begun so far, and when.
    begun: Vec<(Stage, Instant)>,
    /// Share of the whole that is done.
    share: f64,
    /// The steps being counted: how many are done, the share of the whole when they began, and when that was.
    steps: Option<(usize, f64, Instant)>,
}

/// Length of the bar of work with stages.
const WHOLE: f64 = 1000.0;
/// Steps before which nothing is said about the time left: fewer say little.
const TELLING: usize = 3;

impl Progress {
    /// Steps of a list, with the time left.
    pub const STEPS: &str = "{elapsed_precise} {bar:30} {pos}/{len} {msg} (about {eta} left)";
    /// Share of the whole.
    pub const SHARE: &str = "{elapsed_precise} {bar:30} {percent} % {msg}";
    /// Work with stages.
    pub const STAGES: &str = "{elapsed_precise} {bar:30} {msg}";

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
        Self {
            bar,
            stop,
            stages: Mutex::default(),
        }
    }

    /// Prints without disturbing the bar.
    pub fn suspend<T>(&self, print: impl FnOnce() -> T) -> T {
        self.bar.suspend(print)
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }

    /// The stages passed so far, each with the time that it took.
    pub fn times(&self) -> Vec<(&'static str, Duration)> {
        let stages = self.stages();
        let ends = stages.begun.iter().skip(1).map(|(_, at)| *at);
        let ends = ends.chain([Instant::now()]);
        let begun = stages.begun.iter().zip(ends);
        begun
            .map(|((stage, at), end)| (stage.name, end.duration_since(*at)))
            .collect()
    }

    fn stages(&self) -> MutexGuard<'_, Stages> {
        self.stages.lock().unwrap_or_else(|e| e.into_inner())
    }
}

impl Stages {
    /// A part of the work begins; `false` where it had begun before.
    pub fn begin(&mut self, stage: Stage, now: Instant) -> bool {
        if self.begun.last().is_some_and(|(last, _)| *last == stage) {
            return false;
        }
        let before = self.begun.last().map_or(0.0, |(before, _)| before.until);
        self.share = self.share.max(before);
        self.steps = None;
        self.begun.push((stage, now));
        true
    }

    /// The part of the work that is being done, where there are parts.
    pub fn current(&self) -> Option<Stage> {
        self.begun.last().map(|(stage, _)| *stage)
    }

    /// Share (1) of the whole that is done.
    pub fn share(&self) -> f64 {
        self.share
    }

    /// Counts a step of a stage and says in words where the work stands. The bar never goes back: each list of steps within a
    /// stage takes half of what is left of it, since nobody knows how many there will be.
    pub fn step(
        &mut self,
        stage: Stage,
        what: &str,
        done: usize,
        of: usize,
        now: Instant,
    ) -> String {
        let (from, since) = match self.steps {
            Some((before, from, since)) if before < done => (from, since),
            _ => (self.share, now),
        };
        self.steps = Some((done, from, since));
        let part = done as f64 / of.max(1) as f64;
        let here = from + 0.5 * part * (stage.until - from);
        self.share = self.share.max(here);
        let name = stage.name;
        if of < 2 {
            return format!("{name}: {what}");
        }
        let left = (done >= TELLING && done < of).then(|| {
            let each = now.duration_since(since) / (done - 1) as u32;
            let left = HumanDuration(each * (of - done) as u32);
            format!(", about {left} left of these")
        });
        format!("{name}: {done} of {of}{}: {what}", left.unwrap_or_default())
    }
}

impl Watch for Progress {
    fn stage(&self, stage: Stage) {
        let mut stages = self.stages();
        if !stages.begin(stage, Instant::now()) {
            return;
        }
        self.bar.set_length(WHOLE as u64);
        self.bar.set_position((WHOLE * stages.share) as u64);
        self.bar.set_message(stage.name);
    }
    fn step(&self, what: &str, done: usize, of: usize) {
        let mut stages = self.stages();
        match stages.current() {
            Some(stage) => {
                let message = stages.step(stage, what, done, of, Instant::now());
                self.bar.set_position((WHOLE * stages.share) as u64);
                self.bar.set_message(message);
            }
            None => {
                self.bar.set_length(of as u64);
                self.bar.set_position(done as u64);
                self.bar.set_message(what.to_owned());
            }
        }
    }
    fn stop(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_never_goes_back_and_tells_the_time_left_of_a_list() {
        let stage = Stage {
            name: "pairs",
            until: 0.8,
        };
        let start = Instant::now();
        let at = |seconds: u64| start + Duration::from_secs(seconds);
        let mut stages = Stages::default();
        let mut shares = Vec::new();
        let mut words = String::new();
        for (list, size) in [(0, 4), (1, 6)] {
            for done in 1..=size {
                let now = at(100 * list + 2 * done as u64);
                words = stages.step(stage, "a + b", done, size, now);
                shares.push(stages.share);
                if done == 4 && size == 6 {
                    // Two seconds each, two to go.
                    assert_eq!(words, "pairs: 4 of 6, about 4 seconds left of these: a + b");
                }
            }
        }
        assert_eq!(words, "pairs: 6 of 6: a + b");
        assert!(shares.windows(2).all(|w| w[0] <= w[1]), "{shares:?}");
        assert!(shares[3] > 0.0 && shares[9] > shares[4] && shares[9] < 0.8);
        assert_eq!(stages.step(stage, "x", 0, 1, at(300)), "pairs: x");
    }
}
