//! Who hears of the progress of long work, and may stop it.

/// A named part of long work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stage {
    /// What is done in it.
    pub name: &'static str,
    /// Share (1) of the whole that is usually done when it ends.
    pub until: f64,
}

/// Told what is being worked on.
pub trait Watch: Sync {
    /// A part of the work begins. Parts that were not needed are passed over.
    fn stage(&self, _: Stage) {}
    /// A step of work begins: what, and its share of the whole, or of the stage where there is one.
    fn step(&self, what: &str, done: usize, of: usize);
    /// Whether to stop at the next opportunity.
    fn stop(&self) -> bool;
    /// Whether no one wants what stopped work has found, so that it may end with an error at once.
    fn discards(&self) -> bool {
        false
    }
}

/// No one watches.
impl Watch for () {
    fn step(&self, _: &str, _: usize, _: usize) {}
    fn stop(&self) -> bool {
        false
    }
}

/// Passes on all but the stages: work that is one stage of a larger one.
pub struct OneStage<'a>(pub &'a dyn Watch);

impl Watch for OneStage<'_> {
    fn step(&self, what: &str, done: usize, of: usize) {
        self.0.step(what, done, of);
    }
    fn stop(&self) -> bool {
        self.0.stop()
    }
    fn discards(&self) -> bool {
        self.0.discards()
    }
}

/// Passes on whether to stop, and says nothing.
pub struct Silent<'a>(pub &'a dyn Watch);

impl Watch for Silent<'_> {
    fn step(&self, _: &str, _: usize, _: usize) {}
    fn stop(&self) -> bool {
        self.0.stop()
    }
    fn discards(&self) -> bool {
        self.0.discards()
    }
}
