//! Everything the observer says of one run.

use super::characteristic::{self, Point};
use super::{Arguments, Method};
use crate::measurement::{FaultKind, Run};
use crate::metric::{
    StickVelocity, half_width, measured_stick_velocity, plateau, quantile, stick_velocity,
};
use crate::observer::{
    BeltVelocity, Bin, Contact, CurveSettings, DwellResult, Estimate, FrictionCurve, LawFit,
    LawPoints, NormalForce, ObserverError, Phase, PhaseMode, PoleRule, SegmentSettings, Settings,
    Smoothed, StickSlipSettings, Structure, TimeForm, UniformRecord, Whiteness, break_away, drift,
    estimate_frequencies, fit_laws, friction_characteristic, friction_curve, observe as place,
    offset_from_symmetry, segments, smooth, smooth_stick_slip,
};
use crate::report::number;

/// Results for one run; columns have one entry per sample.
#[derive(Debug)]
pub struct Observation {
    /// The run's name.
    pub name: String,
    /// How the force was estimated.
    pub method: Method,
    /// The structure used.
    pub structure: Structure,
    /// Belt velocity in m/s.
    pub belt_velocity: f64,
    /// Normal force in N.
    pub normal_force: f64,
    /// Time in s.
    pub time: Vec<f64>,
    /// Measured displacement less offset in m; NaN where missing.
    pub measured: Vec<f64>,
    /// Force in N.
    pub force: Vec<f64>,
    /// Its standard deviation in N; NaN for the pole-placed observer, which knows none.
    pub force_std: Vec<f64>,
    /// Displacement in m.
    pub displacement: Vec<f64>,
    /// Velocity in m/s.
    pub velocity: Vec<f64>,
    /// Velocity less belt velocity in m/s.
    pub relative_velocity: Vec<f64>,
    /// Stick and slip.
    pub phases: Vec<Phase>,
    /// Friction coefficient over relative velocity.
    pub bins: Vec<Bin>,
    /// The friction curve by shooting, where there was one.
    pub curve: Option<FrictionCurve>,
    /// Whether that curve explains the slip events, so that it may stand for the friction.
    pub curve_trusted: bool,
    /// The characteristic as friction.csv has it.
    pub characteristic: Vec<Point>,
    /// Laws, best first, table last.
    pub laws: Vec<LawFit>,
    /// Break-away against dwell time.
    pub dwell: Option<DwellResult>,
    /// Innovation of the Kalman filter.
    pub whiteness: Whiteness,
    /// Sensor noise in m.
    pub noise_std: f64,
    /// Drift of the displacement in m/s.
    pub drift: Option<Estimate>,
    /// Sensor offset found from slip in both directions, in m.
    pub offset: Option<Estimate>,
    /// Pole-placed observers beside it: pole speed in Hz, and RMS difference of their force, causal and with the delay
    /// taken out, over the spread of the force.
    pub pole_speeds: Vec<(f64, f64, f64)>,
    /// The belt's velocity as the stick phases have it.
    pub belt_in_stick: Option<StickVelocity>,
    /// What the reader must know.
    pub remarks: Vec<String>,
}

impl Observation {
    /// Mode of every sample: -1, 0, 1.
    pub fn modes(&self) -> Vec<i8> {
        let mut out = Vec::with_capacity(self.time.len());
        for phase in &self.phases {
            out.resize(phase.past, phase.mode.number());
        }
        out
    }

    /// Share of the samples in stick.
    pub fn stick_fraction(&self) -> f64 {
        let modes = self.modes();
        modes.iter().filter(|m| **m == 0).count() as f64 / modes.len() as f64
    }

    /// Number of complete stick phases.
    pub fn sticks(&self) -> usize {
        let stick = |p: &&Phase| p.mode == PhaseMode::Stick && p.complete;
        self.phases.iter().filter(stick).count()
    }

    /// The best law with parameters of its own.
    pub fn best_law(&self) -> Option<&LawFit> {
        self.laws.first().filter(|l| !l.parameters.is_empty())
    }
}

/// Standard deviation of a pole-placed observer's velocity as share of the belt velocity, for finding stick.
const POLE_VELOCITY_STD: f64 = 0.03;
/// Misfit of the velocity in stick above which sticking is not rigid.
const STICK_MISFIT: f64 = 3.0;
/// Misfit of the friction curve above which friction is not one curve.
const CURVE_MISFIT: f64 = 1.5;

/// Share of clipped samples from which on the force would be the model's and not the record's.
const MOSTLY: f64 = 0.5;

/// Number of samples in faults of one kind.
fn faulty(run: &Run, kind: FaultKind) -> usize {
    let of_kind = run.faults.iter().filter(|f| f.kind == kind);
    of_kind.map(|f| f.samples).sum()
}

/// Remarks on samples that are not there or not to be trusted.
fn faults(run: &Run, record: &UniformRecord) -> Vec<String> {
    let count = record.displacement.len();
    let (clipped, held) = (
        faulty(run, FaultKind::Clipped),
        faulty(run, FaultKind::Held),
    );
    let gaps = count.saturating_sub(run.time.len());
    let bridged = "they were left out and bridged by the model, where the force is less certain";
    let remark = |found: usize, what: &str| {
        (found > 0).then(|| format!("{found} of {count} samples {what}; {bridged}."))
    };
    [
        remark(gaps, "are missing (gaps in the time column)"),
        remark(clipped, "are clipped: the signal is saturated at an end of the sensor's range, which should be larger"),
        remark(held, "repeat a held value: the recorder lost them"),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Observes a run.
pub fn observe(
    run: &Run,
    structure: Structure,
    arguments: &Arguments,
    rule: &PoleRule,
    mut remarks: Vec<String>,
) -> Result<Observation, ObserverError> {
    let clipped = faulty(run, FaultKind::Clipped);
    if clipped as f64 > MOSTLY * run.time.len() as f64 {
        return Err(ObserverError::Saturated {
            clipped,
            count: run.time.len(),
            low_m: run.measured.iter().copied().fold(f64::INFINITY, f64::min),
            high_m: run
                .measured
                .iter()
                .copied()
                .fold(f64::NEG_INFINITY, f64::max),
        });
    }
    let record = UniformRecord::of(&run.time, &run.measured, Some(&run.trusted()))?;
    remarks.extend(faults(run, &record));
    let belt = BeltVelocity::Constant(run.belt_velocity);
    let settings = Settings {
        offset: arguments.offset,
        ..Settings::default()
    };
    let aware = StickSlipSettings {
        smoother: settings.clone(),
        ..StickSlipSettings::default()
    };
    let (interval, y) = (record.interval, &record.displacement[..]);
    let structure = match arguments.estimate_frequencies {
        Some(range) => {
            let found = estimate_frequencies(&structure, interval, y, belt, &aware, range)?;
            for (j, mode) in found.modes.iter().enumerate() {
                let kept = if mode.determined {
                    "used"
                } else {
                    "not determined by this record, kept as given"
                };
                remarks.push(format!(
                    "Mode {}: {:.3} Hz given, {:.3} ± {:.3} Hz (95 %) found; {kept}.",
                    j + 1,
                    mode.given_hz,
                    mode.found_hz,
                    half_width(mode.std_hz)
                ));
            }
            found.structure
        }
        None => structure,
    };
    let plain = smooth(&structure, interval, y, &settings)?;
    let mut out = Observation {
        name: run.name.clone(),
        method: arguments.method,
        belt_velocity: run.belt_velocity,
        normal_force: run.normal_force,
        time: record.time(),
        measured: y.iter().map(|y| y - arguments.offset).collect(),
        relative_velocity: Vec::new(),
        phases: Vec::new(),
        bins: Vec::new(),
        curve: None,
        curve_trusted: false,
        characteristic: Vec::new(),
        laws: Vec::new(),
        dwell: None,
        whiteness: plain.whiteness.clone(),
        noise_std: plain.noise_std,
        drift: drift(y, interval),
        offset: None,
        pole_speeds: Vec::new(),
        belt_in_stick: belt_in_stick(&structure, &record, &plain, run.belt_velocity),
        remarks,
        force: plain.force.clone(),
        force_std: plain.force_std.clone(),
        displacement: plain.displacement.clone(),
        velocity: plain.velocity.clone(),
        structure,
    };
    let mut velocity_std = plain.velocity_std.clone();
    let mut stick_slip = None;
    match arguments.method {
        Method::Kalman => {}
        Method::Pole => {
            let measured = &out.measured;
            let found = place(&out.structure, interval, measured, rule, TimeForm::Discrete)?;
            out.remarks.push(format!(
                "Poles at {}; the force is late by {:.2} ms and was moved earlier by that.",
                match rule {
                    PoleRule::Given(_) => "the places given".to_owned(),
                    _ => format!(
                        "{:.0} Hz and the transmission zeros",
                        found.poles[0].norm() / std::f64::consts::TAU
                    ),
                },
                1e3 * found.delay
            ));
            out.force = found.force_without_delay(interval);
            out.force_std = vec![f64::NAN; y.len()];
            out.displacement = found.displacement;
            out.velocity = found.velocity;
            velocity_std = vec![POLE_VELOCITY_STD * run.belt_velocity.abs(); y.len()];
        }
        Method::StickSlip => {
            let found = smooth_stick_slip(&out.structure, interval, y, belt, &aware)?;
            if found.stick_misfit > STICK_MISFIT {
                out.remarks.push(format!(
                    "In stick the tip does not follow the belt within the noise (misfit {:.1}): the contact may be compliant or the \
                     belt's speed may give way; prefer --method kalman.",
                    found.stick_misfit
                ));
            }
            out.force = found.smoothed.force.clone();
            out.force_std = found.smoothed.force_std.clone();
            out.displacement = found.smoothed.displacement.clone();
            out.velocity = found.smoothed.velocity.clone();
            stick_slip = Some(found);
        }
    }
    out.relative_velocity = out.velocity.iter().map(|v| v - run.belt_velocity).collect();
    out.phases = match &stick_slip {
        Some(found) => {
            // Phases count time from the first sample.
            let shift = |p: &Phase| Phase {
                start: p.start + record.start,
                end: p.end + record.start,
                ..p.clone()
            };
            found.phases.iter().map(shift).collect()
        }
        None => segments(
            &out.time,
            &out.relative_velocity,
            &velocity_std,
            &SegmentSettings::default(),
        )?,
    };
    friction(&mut out, stick_slip.as_ref(), y, belt);
    out.pole_speeds = pole_speeds(&out, interval);
    judge(&mut out, &record);
    Ok(out)
}

/// The belt's velocity from the stick phases, which are found without trusting the stated one.
fn belt_in_stick(
    structure: &Structure,
    record: &UniformRecord,
    plain: &Smoothed,
    stated: f64,
) -> Option<StickVelocity> {
    let velocity_std = quantile(&plain.velocity_std, 0.5);
    let sticks = plateau(&plain.velocity, velocity_std, stated)?;
    if !structure.is_collocated() {
        // What is measured is the motion of another point.
        return measured_stick_velocity(&plain.velocity, &sticks);
    }
    stick_velocity(&record.time(), &record.displacement, &sticks)
}

/// Characteristic, curve, break-away and laws; what the record does not give becomes a remark.
fn friction(
    out: &mut Observation,
    stick_slip: Option<&crate::observer::StickSlip>,
    y: &[f64],
    belt: BeltVelocity,
) {
    let mut remarks = Vec::new();
    let mut note = |error: ObserverError| remarks.push(format!("{}.", capital(&error.to_string())));
    let contact = Contact {
        relative_velocity: &out.relative_velocity,
        force: &out.force,
        normal_force: NormalForce::Constant(out.normal_force),
        phases: &out.phases,
    };
    let bins = friction_characteristic(&contact, &Default::default())
        .map_err(&mut note)
        .unwrap_or_default();
    let dwell = break_away(&contact).map_err(&mut note).ok();
    let curve = stick_slip.and_then(|found| {
        friction_curve(
            &out.structure,
            y,
            belt,
            &contact,
            found,
            &CurveSettings::default(),
        )
        .map_err(&mut note)
        .ok()
    });
    let trusted = curve.as_ref().filter(|c| c.misfit < CURVE_MISFIT);
    let points = match trusted {
        Some(curve) => LawPoints::from_curve(curve),
        None => {
            let mean = |d: &DwellResult| (d.mu_mean, d.mu_std / (d.events.len() as f64).sqrt());
            LawPoints::from_bins(&bins, dwell.as_ref().map(mean))
        }
    };
    let laws = fit_laws(&points).map_err(&mut note).unwrap_or_default();
    if let (Some(curve), None) = (&curve, trusted) {
        remarks.push(format!(
            "Friction in slip is not one curve over the speed within the noise (misfit {:.1}); the laws are fitted to the binned means.",
            curve.misfit
        ));
    }
    let normal = NormalForce::Constant(out.normal_force);
    out.offset = offset_from_symmetry(&out.structure, &bins, normal);
    out.curve_trusted = trusted.is_some();
    (out.bins, out.dwell, out.curve, out.laws) = (bins, dwell, curve, laws);
    out.characteristic = characteristic::best(out);
    out.remarks.extend(remarks);
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters
        .next()
        .map_or(String::new(), |c| c.to_uppercase().chain(letters).collect())
}

/// Multiples of the speed that the data suggest.
const SPEEDS: [f64; 5] = [0.25, 0.5, 0.75, 1.0, 1.5];

fn pole_speeds(out: &Observation, interval: f64) -> Vec<(f64, f64, f64)> {
    let rule = PoleRule::FromData;
    let Ok(poles) = rule.poles(&out.structure, interval, &out.measured) else {
        return Vec::new();
    };
    let suggested = poles[0].norm() / std::f64::consts::TAU;
    SPEEDS
        .iter()
        .filter_map(|factor| {
            let rule = PoleRule::AtZeros {
                frequency_hz: factor * suggested,
            };
            let form = TimeForm::Discrete;
            let found = place(&out.structure, interval, &out.measured, &rule, form).ok()?;
            let earlier = found.force_without_delay(interval);
            let off = |force: &[f64]| difference(force, &out.force);
            Some((factor * suggested, off(&found.force), off(&earlier)))
        })
        .collect()
}

/// RMS difference over the spread of `reference`, middle 80 %.
fn difference(force: &[f64], reference: &[f64]) -> f64 {
    let n = reference.len();
    let part = n / 10..n - n / 10;
    let count = part.len() as f64;
    let mean = reference[part.clone()].iter().sum::<f64>() / count;
    let spread: f64 = reference[part.clone()]
        .iter()
        .map(|f| (f - mean).powi(2))
        .sum();
    let off: f64 = part.map(|k| (force[k] - reference[k]).powi(2)).sum();
    (off / spread).sqrt()
}

/// What to say of a stated belt velocity that the stick phases contradict; first of the remarks, since all else rests on it.
fn contradiction(stated: f64, found: &StickVelocity) -> String {
    let percent = 100.0 * found.stated_is_off_by(stated);
    format!(
        "The stated belt velocity of {stated} m/s is {:.2} % too {}: in stick the tip moves with the belt, and in {} stick phases it moves at \
         {:.6} ± {} m/s (95 %). The stated one was used; repeat with the other (--belt-velocity, or belt_velocity_m_per_s of the run), \
         unless the sensor's scale is what is off.",
        percent.abs(),
        if percent > 0.0 { "high" } else { "low" },
        found.phases,
        found.velocity,
        number(half_width(found.std), 2),
    )
}

/// Remarks on trust.
fn judge(out: &mut Observation, record: &UniformRecord) {
    if let Some(found) = out
        .belt_in_stick
        .filter(|f| f.contradicts(out.belt_velocity))
    {
        out.remarks
            .insert(0, contradiction(out.belt_velocity, &found));
    }
    if !out.whiteness.acceptable() {
        out.remarks.push(format!(
            "The innovation is not white (autocorrelation {:.2}, strongest at {:.0} Hz): a mode near there is missing, a natural frequency \
             is wrong (try --estimate-frequencies 0.01), or the force jumps too often for this sampling rate. Treat the force with caution.",
            out.whiteness.largest_autocorrelation(),
            out.whiteness.peak_frequency_hz
        ));
    }
    let duration = record.displacement.len() as f64 * record.interval;
    if let Some(slow) = out.drift.filter(Estimate::is_significant) {
        out.remarks.push(format!(
            "The displacement drifts by {:.3} ± {:.3} mm (95 %) over the record: sensor drift or slow change of friction, which one record cannot \
             tell apart.",
            1e3 * slow.value * duration,
            1e3 * half_width(slow.std) * duration
        ));
    }
    match out.offset {
        Some(offset) if offset.is_significant() => out.remarks.push(format!(
            "Slip in both directions shows a sensor offset of {:.4} ± {:.4} mm (95 %) beyond the one subtracted; repeat with --offset.",
            1e3 * offset.value,
            1e3 * half_width(offset.std)
        )),
        Some(_) => {}
        None => out.remarks.push(
            "The record slips in one direction only: a sensor offset would look like a constant force and cannot be told from it.".into(),
        ),
    }
}
