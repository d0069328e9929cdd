//! Processor time, because the clock on the wall shows what else the machine does.

use std::time::Duration;

/// Seconds of processor time that this thread has used; from the clock on the wall where the system does not tell.
pub fn thread() -> f64 {
    read(Whose::Thread).as_secs_f64()
}

/// Seconds of processor time that this program has used, threads that have ended included.
pub fn process() -> f64 {
    read(Whose::Process).as_secs_f64()
}

/// Seconds of processor time that one of many runs takes, at least a tenth of a second of them: as long as a run of the
/// quickest of the peers.
pub fn per_run(mut run: impl FnMut()) -> f64 {
    const LONG_ENOUGH: f64 = 0.1;
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

enum Whose {
    Thread,
    Process,
}

#[cfg(unix)]
fn read(whose: Whose) -> Duration {
    use rustix::time::{ClockId, clock_gettime};
    let time = clock_gettime(match whose {
        Whose::Thread => ClockId::ThreadCPUTime,
        Whose::Process => ClockId::ProcessCPUTime,
    });
    Duration::new(
        time.tv_sec.unsigned_abs(),
        time.tv_nsec.try_into().expect("less than a second"),
    )
}

#[cfg(not(unix))]
fn read(_: Whose) -> Duration {
    static BEGIN: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    BEGIN.get_or_init(std::time::Instant::now).elapsed()
}
