//! The pictures of a comparison.

use super::comparison::Curves;
use super::{FurtherComparison, RunComparison};
use crate::measurement::Measurand;
use crate::metric::{Cycle, HARMONICS, integral, quantile};
use crate::report::{Axis, Bars, Colour, Plot};

const MILLI: f64 = 1e3;
const MICRO: f64 = 1e6;

/// `tip displacement` in mm, or what else was measured.
fn axis_of(curves: &Curves) -> Axis {
    Axis::linear(
        &format!("{} {}", curves.place, curves.measurand.name()),
        curves.measurand.milli_unit(),
    )
}

fn micro_unit(measurand: Measurand) -> &'static str {
    match measurand {
        Measurand::Displacement => "µm",
        Measurand::Velocity => "µm/s",
        Measurand::Acceleration => "µm/s^2",
    }
}

pub(super) fn scores(comparisons: &[RunComparison]) -> Bars {
    let names: Vec<String> = comparisons.iter().map(|r| r.name.clone()).collect();
    let values = |f: fn(&RunComparison) -> f64| comparisons.iter().map(f).collect::<Vec<_>>();
    Bars::new(Axis::linear("NRMSE", "1"), &names)
        .series("model error", Colour::Orange, &values(|r| r.nrmse))
        .series(
            "noise, which no model removes",
            Colour::Grey,
            &values(|r| r.noise_floor),
        )
        .caption(
            "How far the model is from each measured run, beside the share that is only noise.",
        )
}

pub(super) fn harmonic_error(comparisons: &[RunComparison]) -> Plot {
    let measurand = comparisons
        .first()
        .map_or_else(Measurand::default, |r| r.curves.measurand);
    let order: Vec<f64> = (1..=HARMONICS).map(|k| k as f64).collect();
    let axes = Plot::new(
        Axis::linear("harmonic", "1").from_to(0.7, HARMONICS as f64 + 0.3),
        Axis::log("amplitude", micro_unit(measurand)),
    );
    let plot = comparisons
        .iter()
        .zip(Colour::SERIES)
        .fold(axes, |plot, (run, colour)| {
            let micro = |list: &[f64]| list.iter().map(|a| a * 1e6).collect::<Vec<_>>();
            plot.line(&run.name, colour, &order, &micro(&run.model.harmonics))
                .scatter("", colour, &order, &micro(&run.measured.harmonics))
        });
    plot.caption(
        "Amplitudes of the harmonics of the cycle: lines are the model, points the measurement.",
    )
}

fn scaled(values: &[f64], factor: f64) -> Vec<f64> {
    values.iter().map(|v| v * factor).collect()
}

pub(super) fn time_series(curves: &Curves) -> Plot {
    Plot::new(Axis::linear("time", "s"), axis_of(curves))
        .size(1240.0, 260.0)
        .thin_line(
            "measured",
            Colour::Ink,
            &curves.time,
            &scaled(&curves.measured, MILLI),
        )
        .thin_line(
            "model, aligned cycle by cycle",
            Colour::Orange,
            &curves.time,
            &scaled(&curves.model, MILLI),
        )
        .caption("The record, and in each of its cycles the most similar cycle of the model.")
}

/// The readings of a further sensor and the model there.
pub(super) fn further_series(time: &[f64], sensor: &FurtherComparison) -> Plot {
    let quantity = sensor.quantity.replace('_', " ");
    Plot::new(
        Axis::linear("time", "s"),
        Axis::linear(&quantity, sensor.unit),
    )
    .size(1240.0, 260.0)
    .thin_line("measured", Colour::Ink, time, &sensor.measured)
    .thin_line(
        "model, aligned by the first sensor",
        Colour::Orange,
        time,
        &sensor.model,
    )
    .caption(&format!(
        "{}: its readings, and what the model makes there where the first sensor aligns it.",
        sensor.name
    ))
}

pub(super) fn cycle_overlay(run: &RunComparison, measured: &Cycle, model: &Cycle) -> Plot {
    let phases = measured.mean.len();
    let period = run.measured.period.unwrap_or(1.0) * MILLI;
    let at = |i: usize| period * i as f64 / phases as f64;
    let time: Vec<f64> = (0..phases).map(at).collect();
    let edge = |sign: f64| {
        measured
            .mean
            .iter()
            .zip(&measured.std)
            .map(|(m, s)| (m + sign * s) * MILLI)
            .collect::<Vec<_>>()
    };
    let sticks: Vec<(f64, f64)> = stretches(&run.curves.cycle_sticks)
        .into_iter()
        .map(|(a, b)| (at(a), at(b)))
        .collect();
    Plot::new(Axis::linear("time in the cycle", "ms").from_to(0.0, period), axis_of(&run.curves))
        .shade("measured sticks", Colour::Sky, &sticks)
        .band("scatter (1 std)", Colour::Grey, &time, &edge(-1.0), &edge(1.0))
        .line("measured", Colour::Ink, &time, &scaled(&measured.mean, MILLI))
        .line("model", Colour::Orange, &time, &scaled(&model.mean, MILLI))
        .caption(&format!(
            "The average of {} measured cycles and the aligned model over the same times, each stretched to the period.",
            measured.cycles
        ))
}

/// Index ranges in which `flags` is true.
fn stretches(flags: &[bool]) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut first = 0;
    for stretch in flags.chunk_by(|a, b| a == b) {
        if stretch[0] {
            found.push((first, first + stretch.len()));
        }
        first += stretch.len();
    }
    found
}

pub(super) fn phase_plane(run: &RunComparison) -> Plot {
    let curves = &run.curves;
    let stick = &curves.measured_stick;
    let [measured, model] = planes(curves);
    let stuck: Vec<f64> = measured
        .0
        .iter()
        .zip(&stick.sticks)
        .filter(|(_, s)| **s)
        .map(|(w, _)| *w)
        .collect();
    let (low, high) = (
        run.belt_velocity_m_per_s - stick.tolerance,
        run.belt_velocity_m_per_s + stick.tolerance,
    );
    let plot = Plot::new(
        Axis::linear(&format!("{} displacement", curves.place), "mm"),
        Axis::linear(&format!("{} velocity", curves.place), "m/s"),
    );
    let plot = if stuck.is_empty() {
        plot
    } else {
        let ends = [
            quantile(&stuck, 0.005) * MILLI,
            quantile(&stuck, 0.995) * MILLI,
        ];
        plot.band(
            "stick: the tip moves with the belt",
            Colour::Sky,
            &ends,
            &[low; 2],
            &[high; 2],
        )
    };
    let caption = match curves.place {
        "tip" => {
            "Phase plane: velocity over displacement of the tip, the stick phase shaded where the measured tip keeps the belt's velocity."
        }
        _ => "Phase plane: velocity over displacement where the sensor looks.",
    };
    let of_integral = match curves.measurand {
        Measurand::Displacement => "",
        Measurand::Velocity => " The displacement is the integral of the velocity, about its mean.",
        Measurand::Acceleration => {
            " The velocity is the integral of the acceleration from stick on, and the displacement that of the velocity, about its mean."
        }
    };
    plot.thin_line(
        "measured",
        Colour::Ink,
        &scaled(&measured.0, MILLI),
        &measured.1,
    )
    .thin_line("model", Colour::Orange, &scaled(&model.0, MILLI), &model.1)
    .caption(&format!("{caption}{of_integral}"))
}

/// Displacement (m) and velocity (m/s) of the measurement and of the model; where no displacement was measured, displacements
/// about their means.
fn planes(curves: &Curves) -> [(Vec<f64>, Vec<f64>); 2] {
    let velocity = curves.measured_stick.velocity.clone();
    match curves.measurand {
        Measurand::Displacement => [
            (curves.measured.clone(), velocity),
            (curves.model.clone(), curves.model_other.clone()),
        ],
        Measurand::Velocity | Measurand::Acceleration => {
            let finite = || curves.model_other.iter().filter(|w| w.is_finite());
            let mean = finite().sum::<f64>() / finite().count().max(1) as f64;
            let about = curves.model_other.iter().map(|w| w - mean).collect();
            let swing = integral(&curves.time, &velocity);
            let of_model = match curves.measurand {
                Measurand::Acceleration => rate(&curves.time, &curves.model_other),
                _ => curves.model.clone(),
            };
            [(swing, velocity), (about, of_model)]
        }
    }
}

/// Velocity (m/s) of a displacement (m), NaN where two motions meet.
fn rate(time: &[f64], displacement: &[f64]) -> Vec<f64> {
    let last = time.len() - 1;
    let slope = |k: usize| {
        let (a, b) = (k.saturating_sub(1), (k + 1).min(last));
        (displacement[b] - displacement[a]) / (time[b] - time[a])
    };
    (0..=last).map(slope).collect()
}

pub(super) fn spectra(curves: &Curves) -> Plot {
    let (measured, model) = &curves.spectra;
    let nyquist = measured.frequency.last().copied().unwrap_or(1.0);
    let shown = nyquist.min(1500.0);
    let highest = measured
        .amplitude
        .iter()
        .chain(&model.amplitude)
        .fold(0.0_f64, |m, a| m.max(*a))
        * MICRO;
    // Below a tenth of the noise there is nothing to compare.
    let floor = (0.1 * quantile(&measured.amplitude, 0.5) * MICRO).max(1e-6 * highest);
    Plot::new(
        Axis::linear("frequency", "Hz").from_to(0.0, shown),
        Axis::log("amplitude", micro_unit(curves.measurand)).from_to(floor, 2.0 * highest),
    )
    .thin_line(
        "measured",
        Colour::Ink,
        &measured.frequency,
        &scaled(&measured.amplitude, MICRO),
    )
    .thin_line(
        "model",
        Colour::Orange,
        &model.frequency,
        &scaled(&model.amplitude, MICRO),
    )
    .caption(&format!(
        "Amplitude spectra of the {} {} (Hann window over the whole record); the joints between its cycles lift the floor of the model.",
        curves.place,
        curves.measurand.name()
    ))
}

pub(super) fn residual(run: &RunComparison) -> Plot {
    let noise = 2.0 * run.noise_std.value() * MICRO;
    Plot::new(
        Axis::linear("time", "s"),
        Axis::linear(
            "measured minus model",
            micro_unit(run.curves.measurand),
        ),
    )
    .thin_line(
        "residual",
        Colour::Red,
        &run.curves.time,
        &scaled(&run.curves.residual, MICRO),
    )
    .level("2 std of the noise", Colour::Grey, noise)
    .level("", Colour::Grey, -noise)
    .caption("What the model misses over time: each measured cycle minus the most similar cycle of the model.")
}
