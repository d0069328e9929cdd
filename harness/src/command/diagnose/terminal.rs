//! A diagnosis in words for the terminal.

use crate::command::diagnose_page::{likely, with_interval};
use crate::command::progress::Progress;
use crate::diagnose::result::diagnosis::{Diagnosis, Rung};
use crate::diagnose::result::further_sensors::FoundSensor;
use crate::diagnose::thresholds::TIE;

/// How long each stage took, and what was computed.
pub(super) fn costs(progress: &Progress, diagnosis: &Diagnosis) -> String {
    use std::fmt::Write as _;
    let mut out = String::new();
    for (stage, time) in progress.times() {
        let _ = writeln!(out, "{stage:<28} {:>8.1} s", time.as_secs_f64());
    }
    let work = diagnosis.counters;
    let _ = writeln!(
        out,
        "{} fits, {} motions of a segment, {} derivatives of one, {:.1} s of processor time",
        work.fits, work.motions, work.sensitivities, work.processor_s
    );
    out
}

/// How far the readings of further sensor `i` are met along the ladder, and by which factor and how late they are.
fn of_sensor(i: usize, sensor: &FoundSensor, ladder: &[Rung]) -> String {
    let over_noise = ladder
        .iter()
        .filter_map(|rung| rung.further_over_noise.get(i));
    let over_noise: Vec<String> = over_noise.map(|r| format!("{r:.2}")).collect();
    let gain = sensor.gain.as_ref().map_or(String::new(), |gain| {
        format!("; factor {}", with_interval(gain))
    });
    let delay = sensor.delay.as_ref().map_or(String::new(), |delay| {
        format!("; delay beside what is stated {}", with_interval(delay))
    });
    format!(
        "{}: error over noise, step by step, {}{gain}{delay}",
        sensor.name,
        over_noise.join(", ")
    )
}

/// The summary for the terminal.
pub fn terminal(diagnosis: &Diagnosis) -> String {
    use std::fmt::Write as _;
    let mut out = String::new();
    let _ = writeln!(out, "{}\n", diagnosis.summary);
    if let Some(probability) = diagnosis.verdict_probability {
        let _ = writeln!(
            out,
            "Probability of this verdict among all that was compared: {}\n",
            likely(probability)
        );
    }
    let _ = writeln!(
        out,
        "{:<32} {:>10} {:>10} {:>14}",
        "error ladder (NRMSE)", "fit", "held out", "held out/noise"
    );
    for rung in &diagnosis.error_ladder {
        let _ = writeln!(
            out,
            "{:<32} {:>9.3} % {:>9.3} % {:>14.2}",
            rung.step,
            100.0 * rung.fit_nrmse,
            100.0 * rung.holdout_nrmse,
            rung.holdout_over_noise
        );
    }
    for (i, sensor) in diagnosis.further_sensors.iter().enumerate() {
        let _ = writeln!(out, "{}", of_sensor(i, sensor, &diagnosis.error_ladder));
    }
    let _ = writeln!(
        out,
        "\n{:<48} {:>10} {:>12} {:>10}",
        "candidates, best first", "gain", "probability", "fit/noise"
    );
    for candidate in diagnosis.candidates.iter().take(8) {
        let mark = match (candidate.refuted, candidate.passed_over) {
            (true, _) => " (refuted)",
            (false, true) => " (first look)",
            (false, false) => "",
        };
        let fitted = format!("{}{mark}", candidate.id);
        let _ = writeln!(
            out,
            "{:<48} {:>10.1} {:>12} {:>10.2}",
            fitted,
            candidate.score,
            likely(candidate.probability),
            candidate.fit_over_noise
        );
    }
    if let Some(next) = &diagnosis.next_measurement {
        let _ = writeln!(
            out,
            "\nTo separate {}, measure at {} m/s and {} N (wrong ones should then fall behind by {:.0} in gain; {TIE} is a tie).",
            next.separates.join(", "),
            next.belt_velocity_m_per_s,
            next.normal_force_n,
            next.expected_gain
        );
    }
    for (i, term) in diagnosis.proposed_terms.iter().enumerate() {
        let _ = writeln!(
            out,
            "proposed term (proposed_{}.toml): {} = {}, {}",
            i + 1,
            term.target,
            term.expression,
            term.worth()
        );
    }
    for remark in &diagnosis.remarks {
        let _ = writeln!(out, "note: {remark}");
    }
    out
}
