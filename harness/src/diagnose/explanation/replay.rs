//! Predictions of segments where a errors left the parameters and start states: for pictures, sample by sample.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::predictor::Predictor;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::simulator::{Samples, Simulator};
use crate::diagnose::validation::segment_errors::SegmentErrors;
use crate::error::Error;
use crate::parallel::parallel;

/// The FMU's contact force, where it has one.
pub(crate) const FORCE: &str = "friction_force";

/// A segment as a model predicts it.
#[derive(Debug, Clone)]
pub struct Replay {
    /// Index of the segment in the problem.
    pub segment: usize,
    /// What the sensor is predicted to measure, in m or m/s, one per sample; NaN once the prediction was given up.
    pub measured: Vec<f64>,
    /// The model's contact force in N at the same times; NaN where it is not known.
    pub force: Vec<f64>,
    /// What each of the segment's further sensors is predicted to read at the same times, in its SI unit; likewise.
    pub further: Vec<Vec<f64>>,
}

/// Predicts every segment of a errors at every sample.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn replay(
    problem: &Problem,
    hypothesis: &Hypothesis,
    judgement: &SegmentErrors,
) -> Result<Vec<Replay>, Error> {
    let force = problem.fmu.variable(FORCE).ok().map(|v| v.reference);
    let observed = problem
        .references
        .observing(force.unwrap_or(problem.references.measured));
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let places: Vec<usize> = (0..judgement.segments.len()).collect();
    let parts: Vec<&[usize]> = places
        .chunks(places.len().div_ceil(threads).max(1))
        .collect();
    let results = parallel(&parts, |part| {
        let runs = &problem.campaign.runs;
        let mut motion = Predictor::new(
            problem.fmu,
            &problem.references,
            runs,
            hypothesis,
            &problem.work,
        )?;
        let mut contact = Predictor::new(problem.fmu, &observed, runs, hypothesis, &problem.work)?;
        let one = |&i: &usize| {
            let index = judgement.segments[i];
            let segment = &problem.segments[index];
            let mut sensors = run_segment(&mut motion, segment, judgement, i);
            let measured = sensors.remove(0);
            for (values, part) in sensors.iter_mut().zip(&segment.further) {
                values.iter_mut().for_each(|y| *y *= part.scale);
                // Beyond the ends nothing is predicted for a clock that is off.
                let count = values.len();
                let left_out = part.most_delay.min(count);
                values[..left_out].fill(f64::NAN);
                values[count - left_out..].fill(f64::NAN);
            }
            // Another output must not be compared with what was measured.
            let free = Segment {
                measured: vec![f64::NAN; segment.measured.len()],
                further: Vec::new(),
                ..segment.clone()
            };
            let whole = measured.last().is_some_and(|d| d.is_finite());
            let force = if whole && force.is_some() {
                run_segment(&mut contact, &free, judgement, i).remove(0)
            } else {
                vec![f64::NAN; segment.time.len()]
            };
            Replay {
                segment: index,
                measured,
                force,
                further: sensors,
            }
        };
        Ok(part.iter().map(one).collect::<Vec<Replay>>())
    })?;
    Ok(results.into_iter().flatten().collect())
}

/// What the sensors read over a segment, the first one first, each filled up with NaN where the FMU or the prediction gave up.
fn run_segment(
    predictor: &mut Predictor,
    segment: &Segment,
    judgement: &SegmentErrors,
    place: usize,
) -> Vec<Vec<f64>> {
    let point = &judgement.point;
    let mut out = Vec::with_capacity(segment.time.len());
    // A state that the FMU can't start from leaves the picture empty at this segment.
    let done = predictor.predict(
        segment,
        point.values(place, segment.run),
        Samples::all(segment).of_all_sensors(),
        &mut out,
    );
    let sensors = 1 + segment.further.len();
    if done.is_err() {
        // Further sensors are read once the motion has ended.
        let reached = out.len();
        out.resize(reached * sensors, f64::NAN);
    }
    let reached = out.len() / sensors;
    let of_sensor = |i: usize| {
        let mut own = out[i * reached..(i + 1) * reached].to_vec();
        own.resize(segment.time.len(), f64::NAN);
        own
    };
    (0..sensors).map(of_sensor).collect()
}
