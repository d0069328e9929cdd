//! Processor time, because the clock on the wall shows what else the machine does.

use std::fs;
use std::sync::OnceLock;
use std::time::Instant;

/// Seconds of processor time that this thread has used; from the clock on the wall where the system does not tell.
pub fn thread() -> f64 {
    scheduled("/proc/thread-self/schedstat").unwrap_or_else(wall)
}

/// Seconds of processor time that one of many runs takes in the mean: the clock may count in steps of 4 ms.
pub fn per_run(mut run: impl FnMut()) -> f64 {
    const LONG_ENOUGH: f64 = 0.25;
    let begun = thread();
    let mut runs = 0.0;
    loop {
        run();
        runs += 1.0;
        let taken = thread() - begun;
        if taken >= LONG_ENOUGH {
            return taken / runs;
        }
    }
}

/// Seconds of processor time that this program has used, threads that have ended included.
pub fn process() -> f64 {
    ticks().unwrap_or_else(wall)
}

/// Nanoseconds on the processor are the first of Linux's three numbers.
fn scheduled(path: &str) -> Option<f64> {
    let numbers = fs::read_to_string(path).ok()?;
    let busy: f64 = numbers.split_whitespace().next()?.parse().ok()?;
    Some(1e-9 * busy)
}

/// Linux counts finished threads in hundredths of a second only.
fn ticks() -> Option<f64> {
    let line = fs::read_to_string("/proc/self/stat").ok()?;
    // The second field is a name that may contain spaces; fields 14 and 15 are user and system time.
    let (_, fields) = line.rsplit_once(')')?;
    let mut times = fields.split_whitespace().skip(11);
    let user: f64 = times.next()?.parse().ok()?;
    let system: f64 = times.next()?.parse().ok()?;
    Some(0.01 * (user + system))
}

fn wall() -> f64 {
    static BEGIN: OnceLock<Instant> = OnceLock::new();
    BEGIN.get_or_init(Instant::now).elapsed().as_secs_f64()
}
