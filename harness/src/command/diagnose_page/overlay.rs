//! Measured and predicted motion of every run, before and after, with the residual underneath.

use super::views::COLOURS;
use super::{Material, scaled};
use crate::diagnose::model::problem::Problem;
use crate::observer::PhaseMode;
use crate::report::{Axis, Colour, Page, Plot, number, with_unit};

/// Consecutive segments that a picture shows.
const SHOWN: usize = 5;
const MILLI: f64 = 1e3;

/// The section.
pub fn section(page: Page, material: &Material) -> Page {
    let problem = material.problem;
    let mut page = page.section(super::SECTIONS[3]).paragraph(&format!(
        "Every prediction starts from an estimated state and runs for {:.0} ms; then the next one starts. Each picture shows the pieces of its run \
         that are most typical of it. On runs kept out of the fit, the pieces without prediction are those from which the run's own friction level was learnt.",
        MILLI * problem.horizon
    ));
    for run in 0..problem.campaign.runs.len() {
        let Some(shown) = typical(material, run) else {
            page = page.paragraph(&format!(
                "{}: too short to be predicted.",
                problem.campaign.runs[run].name
            ));
            continue;
        };
        let (motion, residual) = (
            motion(material, run, &shown),
            residual(material, run, &shown),
        );
        page = page
            .subsection(&title(material, run))
            .figures(&[&motion, &residual]);
        let further = further(material, run, &shown);
        if !further.is_empty() {
            page = super::side_by_side(page, &further);
        }
    }
    page
}

fn title(material: &Material, r: usize) -> String {
    let run = &material.problem.campaign.runs[r];
    let [before, after] = material
        .views
        .pair
        .each_ref()
        .map(|v| super::verdict::percent(v.by_run[r]));
    format!(
        "{}: {} m/s, {}{}: error {before} → {after}",
        run.name,
        number(run.belt_velocity, 3),
        with_unit(run.normal_force, "N"),
        if material.problem.held_out[r] {
            ", kept out of the fit"
        } else {
            ""
        }
    )
}

/// The stretch of consecutive segments whose error before is nearest to the run's median.
fn typical(material: &Material, run: usize) -> Option<Vec<usize>> {
    let problem = material.problem;
    let of_run: Vec<usize> = (0..problem.segments.len())
        .filter(|&k| problem.segments[k].run == run)
        .collect();
    let error = |k: usize, view: usize| {
        let replay = material.views.pair[view].replays.get(&k)?;
        let segment = &problem.segments[k];
        let sum: f64 = segment
            .measured
            .iter()
            .zip(&replay.measured)
            .map(|(m, p)| (m - p).powi(2))
            .sum();
        sum.is_finite()
            .then(|| (sum / segment.time.len() as f64).ln())
    };
    let level = |window: &[usize]| {
        let errors: Vec<f64> = window
            .iter()
            .filter_map(|&k| error(k, 0).or_else(|| error(k, 1)))
            .collect();
        let predicted = window
            .iter()
            .filter(|k| material.views.pair[1].replays.contains_key(k))
            .count();
        (predicted, errors.iter().sum::<f64>() / errors.len() as f64)
    };
    let middle = super::statistics::median(
        of_run
            .iter()
            .map(|&k| error(k, 0).or_else(|| error(k, 1)).unwrap_or(f64::NAN)),
    );
    of_run
        .windows(SHOWN.min(of_run.len()).max(1))
        .map(|w| (level(w), w))
        .filter(|((predicted, mean), _)| *predicted > 0 && mean.is_finite())
        .min_by(|((n, a), _), ((m, b), _)| {
            m.cmp(n)
                .then((a - middle).abs().total_cmp(&(b - middle).abs()))
        })
        .map(|(_, w)| w.to_vec())
}

/// Times of a segment in ms since the run began.
fn times(problem: &Problem, k: usize) -> Vec<f64> {
    let segment = &problem.segments[k];
    let origin = problem.campaign.runs[segment.run].time[0];
    segment.time.iter().map(|t| MILLI * (t - origin)).collect()
}

/// Stick phases of the stretch shown, in ms.
fn sticks(problem: &Problem, run: usize, from: f64, to: f64) -> Vec<(f64, f64)> {
    problem.smoothings[run]
        .stick_slip
        .phases
        .iter()
        .filter(|p| p.mode == PhaseMode::Stick)
        .map(|p| ((MILLI * p.start).max(from), (MILLI * p.end).min(to)))
        .filter(|(start, end)| end > start)
        .collect()
}

fn span(problem: &Problem, shown: &[usize]) -> (f64, f64) {
    let (first, last) = (
        times(problem, shown[0]),
        times(problem, shown[shown.len() - 1]),
    );
    (first[0], last[last.len() - 1])
}

/// One curve over several segments, interrupted between them.
fn curve(
    problem: &Problem,
    shown: &[usize],
    value: impl Fn(usize) -> Option<Vec<f64>>,
) -> (Vec<f64>, Vec<f64>) {
    let (mut x, mut y) = (Vec::new(), Vec::new());
    for &k in shown {
        let Some(values) = value(k) else { continue };
        x.extend(times(problem, k));
        y.extend(values);
        x.push(f64::NAN);
        y.push(f64::NAN);
    }
    (x, y)
}

fn motion(material: &Material, run: usize, shown: &[usize]) -> Plot {
    let problem = material.problem;
    let (from, to) = span(problem, shown);
    let measured: Vec<(f64, f64)> = {
        let run = &problem.campaign.runs[run];
        let time = run.time.iter().map(|t| MILLI * (t - run.time[0]));
        time.zip(&run.measured)
            .filter(|(t, _)| (from..=to).contains(t))
            .map(|(t, y)| (t, MILLI * y))
            .collect()
    };
    let measurand = problem.campaign.measurand();
    let (time, values): (Vec<f64>, Vec<f64>) = measured.into_iter().unzip();
    let mut plot = Plot::new(
        Axis::linear("time", "ms").from_to(from, to),
        super::axis_of(&problem.campaign),
    )
    .shade("stick", Colour::Sky, &sticks(problem, run, from, to))
    .line("measured", Colour::Ink, &time, &values);
    for (view, colour) in material.views.pair.iter().zip(COLOURS) {
        let (x, y) = curve(problem, shown, |k| {
            view.replays.get(&k).map(|r| scaled(&r.measured, MILLI))
        });
        plot = plot.dashed_line(&view.name, colour, &x, &y);
    }
    plot.caption(&format!(
        "Measured and predicted {} of the {}; stick phases are shaded.",
        measurand.name(),
        problem.campaign.beam.sensor.name()
    ))
}

/// What each further sensor read and is predicted to read.
fn further(material: &Material, run: usize, shown: &[usize]) -> Vec<Plot> {
    let problem = material.problem;
    let (from, to) = span(problem, shown);
    let record = &problem.campaign.runs[run];
    let sensors = problem.campaign.further_sensors.iter();
    let read = sensors.zip(&record.further).enumerate();
    let read = read.filter_map(|(number, (s, record))| Some((number, s, record.as_ref()?)));
    read.map(|(number, sensor, read)| {
        let time = record.time.iter().map(|t| MILLI * (t - record.time[0]));
        let in_sight = time.zip(&read.values);
        let in_sight = in_sight.filter(|(t, y)| (from..=to).contains(t) && y.is_finite());
        let (time, values): (Vec<f64>, Vec<f64>) = in_sight.map(|(t, y)| (t, *y)).unzip();
        let mut plot = Plot::new(
            Axis::linear("time", "ms").from_to(from, to),
            Axis::linear(&sensor.name, sensor.reading.unit()),
        )
        .shade("stick", Colour::Sky, &sticks(problem, run, from, to))
        .line("measured", Colour::Ink, &time, &values);
        for (view, colour) in material.views.pair.iter().zip(COLOURS) {
            let (x, y) = curve(problem, shown, |k| {
                let mut parts = problem.segments[k].further.iter();
                let place = parts.position(|part| part.sensor == number)?;
                view.replays.get(&k)?.further.get(place).cloned()
            });
            plot = plot.dashed_line(&view.name, colour, &x, &y);
        }
        plot.caption(&format!(
            "What the further sensor '{}' measured, and what the models predict with its own factor, zero and delay; stick phases are shaded.",
            sensor.name
        ))
    })
    .collect()
}

fn residual(material: &Material, run: usize, shown: &[usize]) -> Plot {
    let problem = material.problem;
    let (from, to) = span(problem, shown);
    let noise = problem.noise[run];
    let mut plot = Plot::new(
        Axis::linear("time", "ms").from_to(from, to),
        Axis::symlog("measured less predicted, over noise", "1", 3.0),
    )
    .shade("stick", Colour::Sky, &sticks(problem, run, from, to))
    .band(
        "noise (2 std)",
        Colour::Grey,
        &[from, to],
        &[-2.0; 2],
        &[2.0; 2],
    );
    for (view, colour) in material.views.pair.iter().zip(COLOURS) {
        let (x, y) = curve(problem, shown, |k| {
            let replay = view.replays.get(&k)?;
            let segment = &problem.segments[k];
            Some(
                (0..segment.time.len())
                    .map(|i| {
                        if segment.trusted[i] {
                            (segment.measured[i] - replay.measured[i]) / noise
                        } else {
                            f64::NAN
                        }
                    })
                    .collect(),
            )
        });
        plot = plot.thin_line(&view.name, colour, &x, &y);
    }
    plot.caption(&format!(
        "What the predictions miss, in units of the sensor noise ({}); the scale is linear up to 3 and logarithmic beyond.",
        with_unit(noise, problem.campaign.measurand().unit())
    ))
}
