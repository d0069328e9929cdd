//! What the force that a friction characteristic leaves unexplained depends on.
//!
//! In slip, `e = F - mu(v_r) F_N` with F the smoothed force and mu a free characteristic with a level for each run
//! ([`crate::diagnose::initialisation::force_spectrum`]). For each quantity x the samples are sorted into bins; the mean of e/F_N in a bin,
//! learned on every second slip phase, predicts e in the others. The share explained is
//! `1 - sum (e - e_x)^2 / sum e^2` on the phases not learned from: at most 1, below 0 if x says nothing.
//! The share of a surface over several quantities at once is the ceiling for any law that knows them.

use crate::diagnose::initialisation::force_spectrum::lines;
use crate::diagnose::initialisation::free_characteristic::slip_samples;
use crate::diagnose::model::periodic::Argument;
use crate::diagnose::model::problem::Problem;
use crate::smoothing::SlipSample;
use serde_json::{Value, json};

/// Bins for one quantity.
const BINS: usize = 24;
/// Bins of each quantity where several are taken together.
const SURFACE_BINS: usize = 8;
/// Samples that a bin needs before its mean counts.
const LEAST: usize = 12;
/// Range of frequencies that are looked for, in Hz.
const FREQUENCIES: (f64, f64) = (5.0, 300.0);
/// Range of wavelengths that are looked for, in m.
const WAVELENGTHS: (f64, f64) = (2e-3, 0.2);
/// Periodic lines that are reported.
const LINES: usize = 2;

/// A sample with what its force may depend on.
struct Seen {
    sample: SlipSample,
    run: usize,
    /// Number of the slip phase within the run.
    phase: usize,
    /// e/F_N.
    rest: f64,
    displacement: f64,
    velocity: f64,
    grows: bool,
    dwell: f64,
}

/// A quantity, its name and how to read it.
type Quantity = (&'static str, fn(&Seen) -> f64);

const QUANTITIES: [Quantity; 7] = [
    ("relative velocity (m/s)", |s| {
        s.sample.relative_velocity.abs()
    }),
    ("tip displacement (m)", |s| s.displacement),
    ("tip velocity (m/s)", |s| s.velocity),
    ("time since the run began (s)", |s| s.sample.time),
    ("dwell of the stick before (s)", |s| s.dwell),
    ("sense of the sliding speed's change (1)", |s| {
        f64::from(u8::from(s.grows))
    }),
    ("operating point (run)", |s| s.run as f64),
];

/// Numbers for diagnosis.json: shares explained by each quantity, by surfaces, and what repeats.
pub fn describe(problem: &Problem) -> Value {
    let seen = observe(problem);
    if seen.len() < 10 * LEAST {
        return json!({ "note": "too little slip to say what the unexplained force depends on" });
    }
    let mut single: Vec<(&str, f64)> = QUANTITIES
        .iter()
        .map(|(name, read)| (*name, share(&seen, &[*read], BINS)))
        .collect();
    single.sort_by(|a, b| b.1.total_cmp(&a.1));
    let motion = share(
        &seen,
        &[QUANTITIES[0].1, QUANTITIES[1].1, QUANTITIES[5].1],
        SURFACE_BINS,
    );
    let size = (seen.iter().map(|s| s.rest * s.rest).sum::<f64>() / seen.len() as f64).sqrt();
    let repeats = |argument, range, unit: &str| -> Vec<Value> {
        lines(problem, argument, range, LINES)
            .iter()
            .map(|l| json!({ "value": l.value, "unit": unit, "relative_amplitude": l.amplitude, "gain": l.gain }))
            .collect()
    };
    json!({
        "explained_share_by": single
            .iter()
            .map(|(name, share)| json!({ "quantity": name, "share": share }))
            .collect::<Vec<_>>(),
        "explained_share_by_free_surface_of_relative_velocity_displacement_and_sense": motion,
        "unexplained_force_over_normal_force_rms": size,
        "repeats_in_time": repeats(Argument::Time, FREQUENCIES, "Hz"),
        "repeats_along_the_belt": repeats(Argument::Travel, WAVELENGTHS, "m"),
    })
}

fn observe(problem: &Problem) -> Vec<Seen> {
    let mut out = Vec::new();
    for (run, samples) in slip_samples(problem).into_iter().enumerate() {
        let stick_slip = &problem.smoothings[run].stick_slip;
        let smoothed = &stick_slip.smoothed;
        let force = problem.campaign.runs[run].normal_force;
        for sample in samples {
            let k = ((sample.time / smoothed.sample_interval).round() as usize)
                .min(smoothed.displacement.len() - 1);
            let phase = stick_slip.phases.partition_point(|p| p.past <= k);
            let before = phase.checked_sub(1).map(|p| &stick_slip.phases[p]);
            out.push(Seen {
                run,
                phase,
                rest: (sample.force - sample.expected) / force,
                displacement: smoothed.displacement[k],
                velocity: smoothed.velocity[k],
                grows: smoothed.acceleration[k] * sample.relative_velocity > 0.0,
                dwell: before.map_or(0.0, |p| p.end - p.start),
                sample,
            });
        }
    }
    out
}

/// Share of the squares of the rest that bins over some quantities explain on phases not learned from.
fn share(seen: &[Seen], by: &[fn(&Seen) -> f64], bins: usize) -> f64 {
    let edges: Vec<Vec<f64>> = by
        .iter()
        .map(|read| {
            let mut values: Vec<f64> = seen.iter().map(read).collect();
            values.sort_by(f64::total_cmp);
            (1..bins).map(|b| values[b * values.len() / bins]).collect()
        })
        .collect();
    let cell = |s: &Seen| {
        by.iter().zip(&edges).fold(0, |at, (read, edges)| {
            at * bins + edges.partition_point(|e| *e <= read(s))
        })
    };
    let cells = bins.pow(by.len() as u32);
    let (mut before, mut after) = (0.0, 0.0);
    for fold in 0..2 {
        let (mut sum, mut count) = (vec![0.0; cells], vec![0usize; cells]);
        for s in seen.iter().filter(|s| s.phase / 2 % 2 != fold) {
            sum[cell(s)] += s.rest;
            count[cell(s)] += 1;
        }
        for s in seen.iter().filter(|s| s.phase / 2 % 2 == fold) {
            let at = cell(s);
            let expected = if count[at] >= LEAST {
                sum[at] / count[at] as f64
            } else {
                0.0
            };
            before += s.rest * s.rest;
            after += (s.rest - expected).powi(2);
        }
    }
    if before > 0.0 {
        1.0 - after / before
    } else {
        0.0
    }
}
