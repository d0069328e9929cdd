//! 2 s of the default case (100 N, 0.10 m/s; 132 transitions) at tolerance 1e-9 in this project and in
//! heyoka, in one run: `cargo bench --bench default_case`. Runs alternate, so that both see the same
//! machine; times are medians. heyoka is installed into target/bench-venv on first use.

use beam_physics::belt::Inputs;
use beam_physics::integrate::MAX_STATES;
use beam_physics::parameters::ModelParameters;
use beam_physics::simulate::{Simulation, Start};
use std::hint::black_box;
use std::io::{BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Instant;
use stickslip_tests::peers::environment;
use stickslip_tests::root;
use stickslip_tests::slave::{OK, Slave};
use stickslip_tests::variables::reference;

/// Start of the default case, in stick: q_1, q_1', q_2, q_2'.
const START: [f64; 4] = [
    0.001_162_331_347_770_524_6,
    0.05,
    -2.860_023_308_624_127_7e-5,
    0.0,
];
const STOP: f64 = 2.0;
const TOLERANCE: f64 = 1e-9;
const TRANSITIONS: u64 = 132;
const ROUNDS: usize = 51;

/// The peer, which computes the case once for every line it is sent.
struct Peer {
    child: Child,
    ask: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Peer {
    fn start() -> Self {
        let mut child = Command::new(python())
            .arg(root().join("benches/peers/heyoka_default_case.py"))
            .arg(TOLERANCE.to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the peer starts");
        let ask = child.stdin.take().expect("piped");
        let answers = BufReader::new(child.stdout.take().expect("piped"));
        let mut peer = Self {
            child,
            ask,
            answers,
        };
        peer.run();
        peer
    }

    /// Milliseconds of one run.
    fn run(&mut self) -> f64 {
        writeln!(self.ask).expect("the peer listens");
        let mut line = String::new();
        self.answers.read_line(&mut line).expect("the peer answers");
        line.trim().parse().expect("milliseconds")
    }
}

/// Python with the peers of the benchmarks.
fn python() -> PathBuf {
    environment("bench-venv", "benches/peers/requirements.txt").join("python")
}

/// Milliseconds that `run` takes.
fn time(run: impl FnOnce()) -> f64 {
    let begun = Instant::now();
    run();
    begun.elapsed().as_secs_f64() * 1e3
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn physics() {
    let mut state = [0.0; MAX_STATES];
    state[..4].copy_from_slice(&START);
    let start = Start {
        state,
        ..Start::default()
    };
    let inputs = Inputs::constant(0.1, 100.0);
    let mut run = Simulation::new(&ModelParameters::default(), inputs, &start, TOLERANCE)
        .expect("the default case");
    run.advance_to(STOP).expect("the default case");
    assert_eq!(run.transition_count(), TRANSITIONS);
    black_box(run.state());
}

fn begin(slave: &Slave) {
    let names = ["q[1]", "q_dot[1]", "q[2]", "q_dot[2]", "tolerance"].map(reference);
    let [a, b, c, d] = START;
    assert_eq!(slave.reset(), OK);
    assert_eq!(slave.set_all(&names, &[a, b, c, d, TOLERANCE]), OK);
    slave.start_at(0.0);
}

/// Through the FMU in `steps` equal steps, reading one output after each.
fn fmu(slave: &Slave, steps: u32) {
    begin(slave);
    let step = STOP / f64::from(steps);
    let measured = [reference("measured_displacement")];
    let mut value = [0.0];
    for i in 0..steps {
        assert_eq!(slave.step(f64::from(i) * step, step), OK);
        slave.get_into(&measured, &mut value);
        black_box(&value);
    }
}

fn main() {
    let slave = Slave::new();
    let mut peer = Peer::start();
    let mut times = [const { Vec::new() }; 4];
    for _ in 0..ROUNDS {
        times[0].push(peer.run());
        times[1].push(time(physics));
        times[2].push(time(|| fmu(&slave, 1)));
        times[3].push(time(|| fmu(&slave, 20_000)));
    }
    assert_eq!(slave.get_integer("transition_count"), 132);
    drop(peer.ask);
    assert!(peer.child.wait().expect("the peer ends").success());
    let medians = times.map(median);
    println!(
        "default case, {STOP} s, {TRANSITIONS} transitions, tolerance 1e-9; medians of {ROUNDS}"
    );
    println!("{:<44} {:>9} {:>9}", "", "ms", "/ heyoka");
    for (name, ms) in [
        "heyoka 7.13.2, Taylor with terminal events",
        "this project, physics",
        "this project, FMU, one step",
        "this project, FMU, H = 1e-4 s, 1 output read",
    ]
    .iter()
    .zip(medians)
    {
        println!("{name:<44} {ms:>9.3} {:>9.3}", ms / medians[0]);
    }
}
