//! A term for what the catalogue lacks, in the form of a user's effect.
//!
//! Sparse regression of the slip force: `F = sum nuisances + sum c_k g_k`, g_k from a library of terms, chosen one
//! after another by the fall of the squared error on slip phases not learned from (orthogonal matching
//! pursuit; Pati, Rezaiifar and Krishnaprasad 1993, with cross-validation as its stop). Nuisances stay free:
//! a friction level for each run, and what wrong frequencies, damping and masses leave (terms in w, w', w'').
//! A proposal is a place to start: it says nothing about stick, where the force is not determined.

use crate::diagnose::initialisation::free_characteristic::slip_samples;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::validation::estimate::Estimate;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use std::collections::BTreeMap;

/// Terms proposed at most.
const MOST_TERMS: usize = 2;
/// Smallest fall of the squared error, as a share of what the nuisances leave, that makes a term.
const LEAST_SHARE: f64 = 0.05;
/// Samples of a run that are used at most.
const MOST_SAMPLES: usize = 1200;

/// What a slip sample offers to the terms.
struct Row {
    run: usize,
    fold: usize,
    force: f64,
    expected: f64,
    w: f64,
    w_dot: f64,
    w_ddot: f64,
    v_r: f64,
    t: f64,
}

/// A term of the library: target, formula with `c` for its coefficient, unit of c, and its value.
struct Term {
    target: &'static str,
    formula: &'static str,
    unit: &'static str,
    value: fn(&Row) -> f64,
}

const LIBRARY: [Term; 14] = [
    Term {
        target: "tip_force",
        formula: "c*w^2",
        unit: "N/m2",
        value: |r| r.w * r.w,
    },
    Term {
        target: "tip_force",
        formula: "c*w^3",
        unit: "N/m3",
        value: |r| r.w.powi(3),
    },
    Term {
        target: "tip_force",
        formula: "c*abs(w)*w",
        unit: "N/m2",
        value: |r| r.w.abs() * r.w,
    },
    Term {
        target: "tip_force",
        formula: "c*max(w, 0)",
        unit: "N/m",
        value: |r| r.w.max(0.0),
    },
    Term {
        target: "tip_force",
        formula: "c*w_dot^2",
        unit: "N.s2/m2",
        value: |r| r.w_dot * r.w_dot,
    },
    Term {
        target: "tip_force",
        formula: "c*abs(w_dot)*w_dot",
        unit: "N.s2/m2",
        value: |r| r.w_dot.abs() * r.w_dot,
    },
    Term {
        target: "tip_force",
        formula: "c*w_dot^3",
        unit: "N.s3/m3",
        value: |r| r.w_dot.powi(3),
    },
    Term {
        target: "tip_force",
        formula: "c*max(w_dot, 0)",
        unit: "N.s/m",
        value: |r| r.w_dot.max(0.0),
    },
    Term {
        target: "tip_force",
        formula: "c*w*w_dot",
        unit: "N.s/m2",
        value: |r| r.w * r.w_dot,
    },
    Term {
        target: "friction_factor",
        formula: "1 + c*w",
        unit: "1/m",
        value: |r| r.expected * r.w,
    },
    Term {
        target: "friction_factor",
        formula: "1 + c*w_dot",
        unit: "s/m",
        value: |r| r.expected * r.w_dot,
    },
    Term {
        target: "friction_factor",
        formula: "1 + c*t",
        unit: "1/s",
        value: |r| r.expected * r.t,
    },
    Term {
        target: "friction_factor",
        formula: "1 + c*max(v_r, 0)",
        unit: "s/m",
        value: |r| r.expected * r.v_r.max(0.0),
    },
    Term {
        target: "friction_factor",
        formula: "1 + c*abs(w)",
        unit: "1/m",
        value: |r| r.expected * r.w.abs(),
    },
];

/// A term in the form of a user's effect.
#[derive(Debug, Clone, Serialize)]
pub struct ProposedTerm {
    /// What it acts on.
    pub target: String,
    /// Its formula.
    pub expression: String,
    /// The values of the parameters in it.
    pub parameters: BTreeMap<String, Estimate>,
    /// Share that it explains of the squared force left without it; of a term that was fitted to the motion, of the squared error
    /// of prediction on the runs kept out, left by the calibrated model.
    pub explained_share: f64,
    /// Whether it was fitted to the motion, as effects are; otherwise it is a regression of the slip force, to be tried.
    pub fitted: bool,
    /// The effect of the library, or the formula in place of a curve, that it is; `None` for a regression of the slip force.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effect: Option<String>,
    /// The file of that effect, with its states.
    #[serde(skip)]
    pub file: Option<String>,
    /// Parameters that are shapes: lengths, velocities, frequencies.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub shapes: Vec<String>,
    /// Parameters that differ from run to run.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub phases: Vec<String>,
}

impl ProposedTerm {
    /// How much it explains, in words.
    pub fn worth(&self) -> String {
        let share = 100.0 * self.explained_share;
        if self.fitted {
            format!(
                "fitted to the motion; removes {share:.0} % of the squared error on runs kept out of the fit"
            )
        } else {
            format!("explains {share:.0} % of the squared slip force left without it")
        }
    }
}

/// Terms in user-effect form with their coefficients; empty if none explains enough.
pub fn propose(problem: &Problem) -> Vec<ProposedTerm> {
    let rows = rows(problem);
    let runs = problem.campaign.runs.len();
    let nuisances = runs + 3;
    if rows.len() < 20 * (nuisances + MOST_TERMS) {
        return Vec::new();
    }
    let base = |r: &Row| -> Vec<f64> {
        let mut row = vec![0.0; nuisances];
        row[r.run] = r.expected;
        row[runs..].copy_from_slice(&[r.w, r.w_dot, r.w_ddot]);
        row
    };
    let mut chosen: Vec<usize> = Vec::new();
    let mut share = Vec::new();
    let Some(first) = error(&rows, &base, &chosen) else {
        return Vec::new();
    };
    let mut now = first;
    while chosen.len() < MOST_TERMS {
        let best = (0..LIBRARY.len())
            .filter(|k| !chosen.contains(k))
            .filter_map(|k| {
                let mut with = chosen.clone();
                with.push(k);
                Some((k, error(&rows, &base, &with)?))
            })
            .min_by(|a, b| a.1.total_cmp(&b.1));
        match best {
            Some((k, after)) if now - after > LEAST_SHARE * first => {
                chosen.push(k);
                share.push((now - after) / first);
                now = after;
            }
            _ => break,
        }
    }
    let all: Vec<&Row> = rows.iter().collect();
    let Some((solution, spread)) = solve(&all, &base, &chosen) else {
        return Vec::new();
    };
    chosen
        .iter()
        .enumerate()
        .map(|(i, &k)| {
            let term = &LIBRARY[k];
            let coefficient = Estimate {
                value: solution[nuisances + i],
                std: spread[nuisances + i],
                unit: term.unit.to_owned(),
                at_bound: false,
            };
            ProposedTerm {
                target: term.target.to_owned(),
                expression: term.formula.to_owned(),
                parameters: BTreeMap::from([("c".to_owned(), coefficient)]),
                explained_share: share[i],
                fitted: false,
                effect: None,
                file: None,
                shapes: Vec::new(),
                phases: Vec::new(),
            }
        })
        .collect()
}

fn rows(problem: &Problem) -> Vec<Row> {
    let mut out = Vec::new();
    for (run, samples) in slip_samples(problem).into_iter().enumerate() {
        let stick_slip = &problem.smoothings[run].stick_slip;
        let smoothed = &stick_slip.smoothed;
        let every = samples.len().div_ceil(MOST_SAMPLES).max(1);
        for sample in samples.into_iter().step_by(every) {
            let k = ((sample.time / smoothed.sample_interval).round() as usize)
                .min(smoothed.displacement.len() - 1);
            let phase = stick_slip.phases.partition_point(|p| p.past <= k);
            out.push(Row {
                run,
                fold: phase / 2 % 2,
                force: sample.force,
                expected: sample.expected,
                w: smoothed.displacement[k],
                w_dot: smoothed.velocity[k],
                w_ddot: smoothed.acceleration[k],
                v_r: sample.relative_velocity,
                t: sample.time,
            });
        }
    }
    out
}

/// Squared error on the phases not learned from.
fn error(rows: &[Row], base: &dyn Fn(&Row) -> Vec<f64>, chosen: &[usize]) -> Option<f64> {
    let mut sum = 0.0;
    for fold in 0..2 {
        let learn: Vec<&Row> = rows.iter().filter(|r| r.fold != fold).collect();
        let (solution, _) = solve(&learn, base, chosen)?;
        for r in rows.iter().filter(|r| r.fold == fold) {
            let predicted: f64 = columns(r, base, chosen)
                .iter()
                .zip(solution.iter())
                .map(|(a, b)| a * b)
                .sum();
            sum += (r.force - predicted).powi(2);
        }
    }
    Some(sum)
}

fn columns(r: &Row, base: &dyn Fn(&Row) -> Vec<f64>, chosen: &[usize]) -> Vec<f64> {
    let mut row = base(r);
    row.extend(chosen.iter().map(|&k| (LIBRARY[k].value)(r)));
    row
}

/// Least squares with columns scaled to unit length, and standard deviations for independent errors.
fn solve(
    rows: &[&Row],
    base: &dyn Fn(&Row) -> Vec<f64>,
    chosen: &[usize],
) -> Option<(DVector<f64>, DVector<f64>)> {
    let table: Vec<Vec<f64>> = rows.iter().map(|r| columns(r, base, chosen)).collect();
    let width = table.first()?.len();
    let matrix = DMatrix::from_fn(table.len(), width, |i, j| table[i][j]);
    let scale = DVector::from_iterator(
        width,
        matrix
            .column_iter()
            .map(|c| c.norm().max(f64::MIN_POSITIVE).recip()),
    );
    let scaled = &matrix * DMatrix::from_diagonal(&scale);
    let force = DVector::from_iterator(rows.len(), rows.iter().map(|r| r.force));
    // A run without slip has no level: a trace on the diagonal keeps the rest solvable.
    let gram = scaled.tr_mul(&scaled) + DMatrix::identity(width, width) * 1e-12;
    let factor = gram.cholesky()?;
    let solution = factor.solve(&scaled.tr_mul(&force));
    let rest = (&force - &scaled * &solution).norm_squared() / rows.len() as f64;
    let inverse = factor.inverse();
    let spread = DVector::from_fn(width, |i, _| (rest * inverse[(i, i)]).sqrt() * scale[i]);
    Some((solution.component_mul(&scale), spread))
}
