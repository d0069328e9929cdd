//! What the page draws of a run: as measured, and as a model predicts it.

use serde::Serialize;

use super::preview::Predicted;
use crate::diagnose::data::break_away_events::events;
use crate::diagnose::data::segment::Segment;
use crate::diagnose::explanation::replay::FORCE;
use crate::diagnose::model::predictor::Predictor;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::references::output_of;
use crate::diagnose::model::simulator::{Samples, Simulator};
use crate::error::Error;
use crate::fmu::Variable;
use crate::measurement::Measurand;
use crate::metric::spectrum;
use crate::parallel::parallel;

/// Speed relative to the belt, over the belt's own, below which the tip counts as sticking.
const AT_REST: f64 = 0.02;
/// Samples of the shortest stick that counts.
const LEAST_STICK: usize = 4;

/// A break-away.
#[derive(Debug, Serialize)]
pub struct BreakAway {
    /// Friction force over normal force (1).
    pub force: f32,
    /// Distance in m that belt and tip have moved against each other.
    pub place: f32,
    /// Length of the stick before it, s.
    pub dwell: f32,
}

/// An amplitude spectrum.
#[derive(Debug, Default, Serialize)]
pub struct Lines {
    /// Hz.
    pub frequency: Vec<f32>,
    /// Amplitude of the sine, in the unit of what is measured.
    pub amplitude: Vec<f32>,
}

/// A run as measured, sample by sample; `null` stands for what is not known.
#[derive(Debug, Serialize)]
pub struct Measured {
    /// Name.
    pub name: String,
    /// Time since the run began, s.
    pub time: Vec<f32>,
    /// What the sensor read, in its SI unit ([`Measurand`]).
    pub reading: Vec<f32>,
    /// Displacement of the tip, m, smoothed; empty where the sensor reads it.
    pub displacement: Vec<f32>,
    /// Velocity of the tip, smoothed, m/s.
    pub velocity: Vec<f32>,
    /// The same less that of the belt, m/s.
    pub relative: Vec<f32>,
    /// Friction force over normal force, estimated without a friction law (1).
    pub friction: Vec<f32>,
    /// Break-aways.
    pub break_aways: Vec<BreakAway>,
}

/// The same run as a model predicts it, over the segments; `null` between them.
#[derive(Debug, Serialize)]
pub struct Curves {
    /// What the sensor should read, in its SI unit.
    pub reading: Vec<f32>,
    /// Displacement of the tip, m; empty where the sensor reads it.
    pub displacement: Vec<f32>,
    /// Measured less predicted reading, in the same unit.
    pub residual: Vec<f32>,
    /// Velocity of the tip, m/s.
    pub velocity: Vec<f32>,
    /// The same less that of the belt, m/s.
    pub relative: Vec<f32>,
    /// Friction force over normal force (1); empty where the FMU does not tell it.
    pub friction: Vec<f32>,
    /// Break-aways.
    pub break_aways: Vec<BreakAway>,
    /// Spectra of what is measured, predicted and left, over the longest stretch without a gap.
    pub spectra: [Lines; 3],
    /// Length of that stretch, s.
    pub stretch: f64,
}

/// Run `r` as measured.
pub fn measured(problem: &Problem, r: usize) -> Measured {
    let run = &problem.campaign.runs[r];
    let stick_slip = &problem.smoothings[r].stick_slip;
    let smoothed = &stick_slip.smoothed;
    let at = |series: &[f64], k: usize| -> f32 {
        let slot = ((run.time[k] - run.time[0]) / smoothed.sample_interval).round() as usize;
        series.get(slot).map_or(f32::NAN, |v| *v as f32)
    };
    let read = |series: &[f64]| (0..run.time.len()).map(|k| at(series, k)).collect();
    let normal = run.normal_force as f32;
    let friction: Vec<f32> = read(&smoothed.force);
    let found = events(run, &problem.smoothings[r]);
    let break_away = |e: &crate::diagnose::data::break_away_events::Event| BreakAway {
        force: e.force as f32,
        place: e.place as f32,
        dwell: e.dwell as f32,
    };
    Measured {
        name: run.name.clone(),
        time: run.time.iter().map(|t| (t - run.time[0]) as f32).collect(),
        reading: run.measured.iter().map(|m| *m as f32).collect(),
        displacement: match reads_tip(problem) {
            true => Vec::new(),
            false => read(&smoothed.displacement),
        },
        velocity: read(&smoothed.velocity),
        relative: read(&stick_slip.relative_velocity),
        friction: friction.into_iter().map(|f| f / normal).collect(),
        break_aways: found.iter().map(break_away).collect(),
    }
}

/// Whether the sensor reads the displacement of the tip.
fn reads_tip(problem: &Problem) -> bool {
    let campaign = &problem.campaign;
    campaign.beam.sensor.is_tip() && campaign.measurand() == Measurand::Displacement
}

/// Run `r` as predicted.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn curves(problem: &Problem, predicted: &Predicted, r: usize) -> Result<Curves, Error> {
    let run = &problem.campaign.runs[r];
    let of_run: Vec<usize> = (0..problem.segments.len())
        .filter(|k| problem.segments[*k].run == r)
        .collect();
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let parts: Vec<&[usize]> = of_run
        .chunks(of_run.len().div_ceil(threads).max(1))
        .collect();
    let motions = parallel(&parts, |part| motions(problem, predicted, part))?;
    let scale = predicted.hypothesis.scales(&predicted.point.shared);
    let belt = |k: usize| -> f64 {
        let series = run.inputs.belt_velocity.as_ref();
        scale[0] * series.map_or(run.belt_velocity, |s| s.values[k])
    };
    let normal = scale[1] * run.normal_force;
    let count = run.time.len();
    let mut out = Curves {
        reading: vec![f32::NAN; count],
        displacement: vec![f32::NAN; if reads_tip(problem) { 0 } else { count }],
        residual: vec![f32::NAN; count],
        velocity: vec![f32::NAN; count],
        relative: vec![f32::NAN; count],
        friction: vec![f32::NAN; count],
        break_aways: Vec::new(),
        spectra: Default::default(),
        stretch: 0.0,
    };
    let mut whole = vec![f64::NAN; count];
    let mut tells_force = false;
    for (k, motion) in of_run.iter().zip(motions.into_iter().flatten()) {
        let segment = &problem.segments[*k];
        let velocity = match motion.velocity {
            Some(velocity) => velocity,
            None => differences(&segment.time, &motion.reading),
        };
        let first = segment.first;
        let relative: Vec<f64> = (0..velocity.len())
            .map(|i| velocity[i] - belt(first + i))
            .collect();
        for i in 0..segment.time.len() {
            let y = motion.reading[i];
            whole[first + i] = y;
            out.reading[first + i] = y as f32;
            if let Some(displacement) = &motion.displacement {
                out.displacement[first + i] = displacement[i] as f32;
            }
            out.residual[first + i] = (segment.measured[i] - y) as f32;
            out.velocity[first + i] = velocity[i] as f32;
            out.relative[first + i] = relative[i] as f32;
        }
        if let Some(force) = motion.force {
            tells_force = true;
            let share: Vec<f64> = force.iter().map(|f| f / normal).collect();
            for (place, f) in out.friction[first..].iter_mut().zip(&share) {
                *place = *f as f32;
            }
            break_aways(
                segment,
                &relative,
                &share,
                belt(first),
                &mut out.break_aways,
            );
        }
    }
    if !tells_force {
        out.friction.clear();
    }
    let stretch = longest_stretch(&whole);
    let h = run.sample_interval();
    out.stretch = stretch.len() as f64 * h;
    if stretch.len() >= 32 {
        let (measured, model) = (&run.measured[stretch.clone()], &whole[stretch]);
        let left: Vec<f64> = measured.iter().zip(model).map(|(m, y)| m - y).collect();
        out.spectra = [measured, model, &left].map(|series| lines(series, h));
    }
    Ok(out)
}

struct Motion {
    /// What the sensor should read.
    reading: Vec<f64>,
    /// Displacement where the sensor reads something else.
    displacement: Option<Vec<f64>>,
    /// Velocity where it reads no displacement, whose differences it is.
    velocity: Option<Vec<f64>>,
    force: Option<Vec<f64>>,
}

/// What the sensor should read over segments, with the rest of the motion and the force; NaN from where the FMU gave up.
fn motions(problem: &Problem, of: &Predicted, indices: &[usize]) -> Result<Vec<Motion>, Error> {
    let h = &of.hypothesis;
    let runs = &problem.campaign.runs;
    let measurand = problem.campaign.measurand();
    let observing = |variable: Result<&Variable, Error>, is_wanted: bool| match variable {
        Ok(found) if is_wanted => Some(problem.references.observing(found.reference)),
        _ => None,
    };
    // Away from the tip the sensor tells neither of what rubs.
    let is_tip = problem.campaign.beam.sensor.is_tip();
    let of_tip = |measurand: Measurand| match is_tip {
        true => output_of(problem.fmu, measurand),
        false => problem.fmu.variable(&format!("tip_{}", measurand.name())),
    };
    let observed = [
        observing(of_tip(Measurand::Displacement), !reads_tip(problem)),
        observing(
            of_tip(Measurand::Velocity),
            !is_tip || measurand == Measurand::Acceleration,
        ),
        observing(problem.fmu.variable(FORCE), true),
    ];
    let mut motion = problem.predictor(h)?;
    let mut beside = Vec::new();
    for references in &observed {
        let predictor = references
            .as_ref()
            .map(|found| Predictor::new(problem.fmu, found, runs, h, &problem.work));
        beside.push(predictor.transpose()?);
    }
    let run = |predictor: &mut Predictor, segment: &Segment, k: usize| {
        let mut out = Vec::with_capacity(segment.time.len());
        let values = of.point.values(k, segment.run);
        // A state that the FMU can't start from leaves the picture empty at this segment.
        let _ = predictor.predict(segment, values, Samples::all(segment), &mut out);
        out.resize(segment.time.len(), f64::NAN);
        out
    };
    let one = |&k: &usize| {
        let segment = &problem.segments[k];
        let reading = run(&mut motion, segment, k);
        // Another output must not be compared with the measurement, by which a motion is given up.
        let free = Segment {
            measured: vec![f64::NAN; segment.measured.len()],
            ..segment.clone()
        };
        let whole = reading.last().is_some_and(|d| d.is_finite());
        let mut others = beside.iter_mut().map(|predictor| {
            let predictor = predictor.as_mut()?;
            Some(match whole {
                true => run(predictor, &free, k),
                false => vec![f64::NAN; reading.len()],
            })
        });
        let mut other = || others.next().expect("three outputs");
        let (displacement, velocity, force) = (other(), other(), other());
        Motion {
            displacement,
            velocity: velocity
                .or_else(|| (measurand == Measurand::Velocity).then(|| reading.clone())),
            force,
            reading,
        }
    };
    Ok(indices.iter().map(one).collect())
}

/// Derivative by central differences, one-sided at the ends.
fn differences(time: &[f64], values: &[f64]) -> Vec<f64> {
    let last = values.len() - 1;
    (0..=last)
        .map(|i| {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(last));
            (values[b] - values[a]) / (time[b] - time[a])
        })
        .collect()
}

/// The break-aways of a segment as predicted: ends of sticks of some length, by the speed relative to the belt.
fn break_aways(
    segment: &Segment,
    relative: &[f64],
    share: &[f64],
    belt: f64,
    found: &mut Vec<BreakAway>,
) {
    let rests = |i: usize| relative[i].abs() < AT_REST * belt.abs();
    let mut since = None;
    let mut passed = 0.0;
    for i in 0..relative.len() {
        if i > 0 {
            passed -= relative[i] * (segment.time[i] - segment.time[i - 1]);
        }
        match (rests(i), since) {
            (true, None) => since = Some(i),
            (false, Some(begin)) => {
                since = None;
                // What began before the segment lasts as long as the measured stick says.
                let before = if begin < 2 { segment.dwell } else { 0.0 };
                let known = begin >= 2 || segment.stuck;
                if i - begin >= LEAST_STICK && known && share[i - 1].is_finite() {
                    found.push(BreakAway {
                        force: share[i - 1].abs() as f32,
                        place: (segment.travel + passed) as f32,
                        dwell: (before + segment.time[i - 1] - segment.time[begin]) as f32,
                    });
                }
            }
            _ => {}
        }
    }
}

/// The longest stretch of finite values.
fn longest_stretch(values: &[f64]) -> std::ops::Range<usize> {
    let (mut best, mut begin) = (0..0, 0);
    for i in 0..=values.len() {
        if i == values.len() || !values[i].is_finite() {
            if i - begin > best.len() {
                best = begin..i;
            }
            begin = i + 1;
        }
    }
    best
}

fn lines(series: &[f64], interval: f64) -> Lines {
    let found = spectrum(series, interval);
    let short = |values: &[f64]| values.iter().map(|v| *v as f32).collect();
    Lines {
        frequency: short(&found.frequency),
        amplitude: short(&found.amplitude),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_stretch_lies_between_gaps() {
        let n = f64::NAN;
        assert_eq!(longest_stretch(&[1.0, n, 1.0, 2.0, n]), 2..4);
        assert_eq!(longest_stretch(&[n]), 0..0);
        assert_eq!(longest_stretch(&[1.0, 2.0]), 0..2);
    }

    #[test]
    fn val_a_stick_that_ends_is_a_break_away_with_its_dwell_and_force() {
        let time: Vec<f64> = (0..20).map(|i| f64::from(i) * 1e-3).collect();
        let segment = Segment {
            run: 0,
            first: 0,
            measured: vec![0.0; 20],
            trusted: vec![true; 20],
            count: 20,
            further: Vec::new(),
            stuck: false,
            dwell: 0.0,
            travel: 0.5,
            travel_end: 0.5,
            belt_distance: 0.0,
            state: Vec::new(),
            time,
        };
        // Slip at 0.1 m/s against the belt for 5 ms, stick for 10 ms, slip.
        let relative: Vec<f64> = (0..20)
            .map(|i| if (5..15).contains(&i) { 0.0 } else { -0.1 })
            .collect();
        let share: Vec<f64> = (0..20).map(|i| 0.01 * f64::from(i)).collect();
        let mut found = Vec::new();
        break_aways(&segment, &relative, &share, 0.1, &mut found);
        assert_eq!(found.len(), 1);
        assert!((found[0].force - 0.14).abs() < 1e-6);
        assert!((found[0].dwell - 9e-3).abs() < 1e-6);
        assert!((found[0].place - 0.5005).abs() < 1e-6, "{}", found[0].place);
    }
}
