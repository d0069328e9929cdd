//! Who hears of the progress of long work, and may stop it.

/// Told what is being worked on.
pub trait Watch: Sync {
    /// A step of work begins: what, and its share of the whole.
    fn step(&self, what: &str, done: usize, of: usize);
    /// Whether to stop at the next opportunity.
    fn stop(&self) -> bool;
}

/// No one watches.
impl Watch for () {
    fn step(&self, _: &str, _: usize, _: usize) {}
    fn stop(&self) -> bool {
        false
    }
}

/// Passes on whether to stop, and says nothing.
pub struct Silent<'a>(pub &'a dyn Watch);

impl Watch for Silent<'_> {
    fn step(&self, _: &str, _: usize, _: usize) {}
    fn stop(&self) -> bool {
        self.0.stop()
    }
}
