//! The default case through the FMU's C interface, and what starting anew costs:
//! `cargo bench --bench fmu_speed`. CPU times, the best of several; `default_case` compares with a peer.

use std::hint::black_box;
use stickslip_tests::slave::{OK, Slave};
use stickslip_tests::variables::reference;

/// Start of the default case (100 N, 0.10 m/s, in stick): q_1, q_1', q_2, q_2', and the tolerance.
const START: [f64; 5] = [
    0.001_162_331_347_770_524_6,
    0.05,
    -2.860_023_308_624_127_7e-5,
    0.0,
    1e-9,
];

/// CPU time of this thread in ms: unlike the clock on the wall it stands still while others compute.
#[cfg(target_os = "linux")]
fn now() -> f64 {
    let mut time = libc::timespec {
        tv_sec: 0,
        tv_nsec: 0,
    };
    // SAFETY: a function of the C library that fills what it is given.
    let status = unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &raw mut time) };
    assert_eq!(status, 0);
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 * 1e-6
}

/// Time in ms since the first call.
#[cfg(not(target_os = "linux"))]
fn now() -> f64 {
    static BEGUN: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    let begun = BEGUN.get_or_init(std::time::Instant::now);
    begun.elapsed().as_secs_f64() * 1e3
}

fn best_of(count: usize, mut run: impl FnMut()) -> f64 {
    (0..count)
        .map(|_| {
            let begun = now();
            run();
            now() - begun
        })
        .fold(f64::INFINITY, f64::min)
}

fn main() {
    let starts = ["q[1]", "q_dot[1]", "q[2]", "q_dot[2]", "tolerance"].map(reference);
    let slave = Slave::new();
    let begin = || {
        assert_eq!(slave.reset(), OK);
        assert_eq!(slave.set_all(&starts, &START), OK);
        slave.start_at(0.0);
    };
    let one_step = best_of(30, || {
        begin();
        assert_eq!(slave.step(0.0, 2.0), OK);
    });
    assert_eq!(slave.get_integer("transition_count"), 132);
    let measured = [reference("measured_displacement")];
    let mut value = [0.0];
    let fine = best_of(15, || {
        begin();
        for i in 0..20_000 {
            assert_eq!(slave.step(f64::from(i) * 1e-4, 1e-4), OK);
            slave.get_into(&measured, &mut value);
            black_box(&value);
        }
    });
    let eight = [
        "tip_displacement",
        "tip_velocity",
        "tip_acceleration",
        "friction_force",
        "relative_velocity",
        "power_into_beam",
        "belt_travel",
        "dwell_time",
    ]
    .map(reference);
    let mut values = [0.0; 8];
    let full = best_of(15, || {
        begin();
        for i in 0..20_000 {
            assert_eq!(slave.step(f64::from(i) * 1e-4, 1e-4), OK);
            slave.get_into(&eight, &mut values);
            black_box(&values);
        }
    });
    let restarts = 20_000;
    let restart = best_of(15, || (0..restarts).for_each(|_| begin())) / f64::from(restarts) * 1e3;
    let mut state = slave.state();
    let save = best_of(15, || {
        (0..restarts).for_each(|_| assert_eq!(slave.state_into(&mut state), OK))
    }) / f64::from(restarts)
        * 1e3;
    let restore = best_of(15, || {
        (0..restarts).for_each(|_| assert_eq!(slave.set_state(state), OK))
    }) / f64::from(restarts)
        * 1e3;
    slave.free_state(&mut state);
    // Steps in stick; the state is put back before each round, which is a hundredth of what is measured.
    assert_eq!(slave.reset(), OK);
    slave.start_at(0.0);
    let mut begun = 0_u32;
    while slave.get_integer("contact_mode") != 0 {
        assert_eq!(slave.step(f64::from(begun) * 1e-4, 1e-4), OK);
        begun += 1;
    }
    let transitions = slave.get_integer("transition_count");
    let mut stuck = slave.state();
    let steps = 100_u32;
    let stick = best_of(400, || {
        assert_eq!(slave.set_state(stuck), OK);
        for i in begun..begun + steps {
            assert_eq!(slave.step(f64::from(i) * 1e-4, 1e-4), OK);
        }
    });
    assert_eq!(slave.get_integer("transition_count"), transitions);
    let stick = stick / f64::from(steps) * 1e6;
    slave.free_state(&mut stuck);
    println!("default case, 2 s, 132 transitions, tolerance 1e-9");
    println!("  FMU, one step                                {one_step:8.3} ms");
    println!("  FMU, H = 1e-4 s, measured_displacement read  {fine:8.3} ms");
    println!("  FMU, H = 1e-4 s, 8 outputs read              {full:8.3} ms");
    println!("  reset + set starts + setup + initialise      {restart:8.3} us");
    println!("  fmi2DoStep in stick, H = 1e-4 s              {stick:8.0} ns");
    println!("  get state / set state                        {save:8.3} / {restore:.3} us");
}
