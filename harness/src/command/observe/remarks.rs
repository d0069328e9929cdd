//! What the reader must know of a run and of what was found.

use super::Observation;
use crate::measurement::{FaultKind, Measurand, Run};
use crate::metric::{StickVelocity, half_width};
use crate::observer::{Estimate, UniformRecord};
use crate::report::number;

/// Number of samples in faults of one kind.
pub fn faulty(run: &Run, kind: FaultKind) -> usize {
    let of_kind = run.faults.iter().filter(|f| f.kind == kind);
    of_kind.map(|f| f.samples).sum()
}

/// Remarks on samples that are not there or not to be trusted.
pub fn faults(run: &Run, record: &UniformRecord) -> Vec<String> {
    let count = record.measured.len();
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
pub fn judge(out: &mut Observation, record: &UniformRecord) {
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
    let duration = record.measured.len() as f64 * record.interval;
    if let Some(slow) = out.drift.filter(Estimate::is_significant) {
        out.remarks.push(format!(
            "The displacement drifts by {:.3} ± {:.3} mm (95 %) over the record: sensor drift or slow change of friction, which one record cannot \
             tell apart.",
            1e3 * slow.value * duration,
            1e3 * half_width(slow.std) * duration
        ));
    }
    level(out);
}

/// What the record says of the level of the force, or can't say.
fn level(out: &mut Observation) {
    let stiffness = out.structure.static_compliance().recip();
    let remark = match (out.stated_coefficient, out.offset) {
        (None, Some(offset)) if offset.is_significant() => format!(
            "Slip in both directions shows a sensor offset of {:.4} ± {:.4} mm (95 %) beyond the one subtracted; repeat with --offset.",
            1e3 * offset.value,
            1e3 * half_width(offset.std)
        ),
        (None, None) if out.measurand == Measurand::Displacement && !out.structure.is_free() => {
            "The record slips in one direction only: a sensor offset would look like a constant force and cannot be distinguished from it.".into()
        }
        (Some(_), Some(offset)) if offset.is_significant() => format!(
            "Slip in both directions shows that the force is {:.3} ± {:.3} N (95 %) too high throughout: the coefficient differs from the \
             one stated by --friction-coefficient.",
            stiffness * offset.value,
            stiffness * half_width(offset.std)
        ),
        (Some(coefficient), _) => format!(
            "The {} does not show the level of force and deflection, which was set such that the median coefficient in slip is {}, as stated \
             by --friction-coefficient; only differences are measured.",
            out.measurand.name(),
            number(coefficient, 3)
        ),
        _ => return,
    };
    out.remarks.push(remark);
}
