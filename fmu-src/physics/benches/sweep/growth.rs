//! The cost over points, cycles and modes, on one thread.
//!
//! Over modes the motion itself must stay what it is, or the figure shows how often other motions stick. So the modes
//! beyond the second hardly touch the tip: the equations have as many states as ever, the motion has two modes.

use crate::clock;
use beam_physics::sweep::{Rule, Section, StartRule, Values, evaluate};

const REPETITIONS: usize = 3;
/// Tip value of modes that are there to be computed only.
const FAINT: f64 = 2e-6;

#[derive(Clone, Copy)]
struct Study {
    points: usize,
    cycles: usize,
    modes: usize,
    /// Tip value and frequency in Hz of the modes beyond the second; `None` for those of the cantilever.
    others: Option<(f64, f64)>,
}

const USUAL: Study = Study {
    points: 20,
    cycles: 200,
    modes: 2,
    others: None,
};

/// Least processor time in s, and the mean share of time in stick.
fn cost(study: Study) -> (f64, f64) {
    let rule = Rule {
        settle: study.cycles / 2,
        cycles: study.cycles - study.cycles / 2,
        patience: 0,
        section: Section::Peak,
        lyapunov: false,
    };
    let mut least = f64::INFINITY;
    let mut stuck = 0.0;
    let mut run = || {
        stuck = 0.0;
        for i in 0..study.points {
            // Motions of period one, so that all points are alike.
            let velocity = 0.096 + 0.003 * i as f64 / study.points as f64;
            let mut values = Values::default();
            let mut set = |name: &str, value: f64| values.set(name, value).expect("known");
            set("belt_velocity", velocity);
            set("normal_force", 100.0);
            set("mode_count", study.modes as f64);
            if let Some((tip, frequency)) = study.others {
                for j in 3..=study.modes {
                    set(&format!("mode[{j}].tip_value"), tip);
                    // Apart from each other, so that none is the double of another.
                    let own = frequency * (1.0 + 0.01 * j as f64);
                    set(&format!("mode[{j}].frequency"), own);
                }
            }
            let subject = values.subject().expect("valid");
            let motion = evaluate(&subject, &rule, &StartRule::Fixed, None).expect("moves");
            stuck += motion.stick_fraction / study.points as f64;
        }
    };
    for _ in 0..REPETITIONS {
        least = least.min(clock::per_run(&mut run));
    }
    (least, stuck)
}

fn line(study: Study, what: &str) {
    let (seconds, stuck) = cost(study);
    println!(
        "{:>4} points, {:>3} cycles, {} modes{what}: {:6.3} s, {:5.1} us per point and cycle, {:4.1} % in stick",
        study.points,
        study.cycles,
        study.modes,
        seconds,
        1e6 * seconds / (study.points * study.cycles) as f64,
        100.0 * stuck
    );
}

/// Prints the three series.
pub fn report() {
    println!("processor time of one thread, best of {REPETITIONS}, without exponents");
    for points in [10, 20, 40, 80] {
        line(Study { points, ..USUAL }, "");
    }
    for cycles in [50, 100, 200, 400, 800] {
        line(Study { cycles, ..USUAL }, "");
    }
    for modes in 2..=8 {
        let others = Some((FAINT, 300.0));
        line(
            Study {
                modes,
                others,
                ..USUAL
            },
            ", the others faint, about 300 Hz",
        );
    }
    for modes in [1, 2, 3, 4, 5, 6, 8] {
        line(Study { modes, ..USUAL }, " of the cantilever");
    }
}
