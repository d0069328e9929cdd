//! The error of an FMU over short pieces of a run, each predicted from a start state that the FMU holds for it.
//!
//! A free motion over a whole run diverges from the measured one where motions are irregular, however right the model is; and
//! a phase or friction level differs from run to run, where an FMU has one. So the FMU that `diagnose` and `try` write holds
//! parameters and start states for each run, and its last error can be seen again from these.

use crate::command::run_sets;
use crate::diagnose::model::references::output_of;
use crate::diagnose::result::run_sets::{Piece, RunSet, SENSOR_OFFSET};
use crate::diagnose::validation::segment_errors::typical;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::measurement::Run;

/// What an FMU holds for the runs of a campaign.
pub(super) struct Held(Vec<RunSet>);

impl Held {
    /// Reads it.
    ///
    /// # Errors
    /// Files in the FMU that can't be understood.
    pub fn by(fmu: &Fmu) -> Result<Self, Error> {
        Ok(Self(run_sets::of_fmu(fmu)?))
    }

    /// The set of a run. It must have been made from this very record: other rigs have a run01 too.
    pub fn of(&self, run: &Run) -> Option<&RunSet> {
        let named = self.0.iter().filter(|set| set.run == run.name);
        named.into_iter().find(|set| is_of(set, run))
    }
}

/// Whether a set's pieces start with what the record says there.
fn is_of(set: &RunSet, run: &Run) -> bool {
    let starts = |piece: &Piece| first_sample(piece, run).map(|k| run.measured[k]);
    !set.pieces.is_empty() && set.pieces.iter().all(|p| starts(p) == Some(p.measured))
}

/// The sample with which a piece starts.
fn first_sample(piece: &Piece, run: &Run) -> Option<usize> {
    let half = 0.5 * run.sample_interval();
    let from = run.time[0] + piece.start - half;
    let k = run.time.partition_point(|t| *t < from);
    (k < run.time.len() && run.time[k] <= from + 2.0 * half).then_some(k)
}

/// Parameters of a set that a free motion takes over: all but the inputs, which the campaign gives.
pub(super) fn settings(set: Option<&RunSet>) -> Vec<(String, f64)> {
    let is_input = |name: &str| {
        [
            "belt_velocity",
            "normal_force",
            "external_force",
            "clamp_acceleration",
        ]
        .contains(&name)
    };
    let all = set.map_or(&[][..], |s| &s.parameters);
    let parameters = all.iter().filter(|(name, _)| !is_input(name));
    parameters.cloned().collect()
}

/// Root mean square error of the pieces over the standard deviation of what was measured, without the worst tenth of the pieces
/// as in the error ladder: those graze a transition, where a prediction turns on the last digit of its start state.
///
/// # Errors
/// Values that the FMU refuses.
pub(super) fn nrmse(fmu: &Fmu, run: &Run, set: &RunSet) -> Result<f64, Error> {
    let trusted = run.trusted();
    let mut squares = Vec::new();
    for piece in &set.pieces {
        squares.extend(mean_square(fmu, run, &trusted, set, piece)?);
    }
    Ok(typical(&mut squares).sqrt() / super::comparison::spread(&run.measured))
}

/// Mean square error of one piece; `None` where no sample of it counts.
fn mean_square(
    fmu: &Fmu,
    run: &Run,
    trusted: &[bool],
    set: &RunSet,
    piece: &Piece,
) -> Result<Option<f64>, Error> {
    let Some(first) = first_sample(piece, run) else {
        return Ok(None);
    };
    let mut instance = fmu.instantiate(&run.name)?;
    let starts = set.start_names.iter().zip(&piece.values);
    let parameters = set.parameters.iter().map(|(name, value)| (name, value));
    let mut offset = 0.0;
    for (name, value) in parameters.chain(starts) {
        if name == SENSOR_OFFSET {
            offset = *value;
            continue;
        }
        instance.set_number(fmu.variable(name)?, *value)?;
    }
    let measured = [output_of(fmu, run.measurand)?.reference];
    instance.initialize(piece.start, None, None)?;
    let (mut sum, mut count) = (0.0, 0);
    let mut now = piece.start;
    for k in first..run.time.len() {
        let t = run.time[k] - run.time[0];
        if t > piece.end + 0.5 * run.sample_interval() {
            break;
        }
        if t > now {
            if instance.do_step(now, t - now).is_err() {
                // A motion that the model can't follow is one of the worst.
                return Ok(Some(f64::INFINITY));
            }
            now = t;
        }
        let mut y = [0.0];
        instance.get_real(&measured, &mut y)?;
        if trusted[k] {
            sum += (run.measured[k] - y[0] - offset).powi(2);
            count += 1;
        }
    }
    Ok((count > 0).then_some(sum / f64::from(count)))
}
