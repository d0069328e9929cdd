//! One point: from its start to the numbers that describe its motion.

use super::exponent::Exponent;
use super::follow::{Crossing, Features, Follower};
use super::measure::Stretch;
use super::period::period_of;
use super::run::Run;
use super::spectrum::strongest_line;
use super::start::start;
use super::{Carry, Section, StartRule, Subject, static_compliance};
use crate::contact::ContactMode;
use crate::error::PhysicsError;
use crate::integrate::{MAX_STATES, State};
use crate::model::Model;
use crate::simulate::Simulation;

/// Periods of the lowest mode without a peak, beyond the time of a stick, after which nothing moves.
const QUIET: f64 = 50.0;
/// Longest stick in s that is waited for.
const LONGEST_STICK: f64 = 1000.0;
/// Amplitude, as a share of the static deflection at break-away, below which the tip rests.
const REST: f64 = 1e-6;
/// Loss of amplitude from each quarter of a stretch to the next that says that a motion dies out.
const DYING: f64 = 0.9975;

/// How long a point is followed.
///
/// Transients: the first `settle` peaks are discarded and the next `cycles` measured. Where the motion does not
/// repeat yet although no difference to it clearly grows, that stretch is discarded too and the next one measured,
/// at most `patience` times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rule {
    /// Peaks that are discarded.
    pub settle: usize,
    /// Peaks that are measured.
    pub cycles: usize,
    /// Further stretches for motions that still settle.
    pub patience: usize,
    /// Where the motion is looked at.
    pub section: Section,
    /// Whether the Lyapunov exponent is measured; without it what does not repeat is not resolved.
    pub lyapunov: bool,
}

impl Default for Rule {
    fn default() -> Self {
        Self {
            settle: 200,
            cycles: 200,
            patience: 4,
            section: Section::Peak,
            lyapunov: true,
        }
    }
}

/// What became of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// The motion repeats, or it is irregular: it does not repeat, and its exponent is positive beyond the standard error.
    Settled,
    /// Still approaching its final motion when patience ended.
    Settling,
    /// The amplitude falls and falls: no self-sustained vibration.
    DiesOut,
    /// Nothing moves.
    Rest,
    /// The section is not met, although the tip moves.
    NoSection,
    /// The motion does not repeat, and no difference to it clearly grows or dies out when patience ended: quasi-periodic, or a
    /// transient longer than it was looked at, or chaotic with an exponent too near zero to tell. Also where no exponent
    /// was measured. Last, as its number travels to clusters.
    Unresolved,
}

impl Status {
    /// The word for files.
    pub fn word(self) -> &'static str {
        match self {
            Status::Settled => "ok",
            Status::Settling => "settling",
            Status::DiesOut => "dies_out",
            Status::Rest => "rest",
            Status::NoSection => "no_section",
            Status::Unresolved => "unresolved",
        }
    }
}

/// The motion at one point.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Section points after which it repeats; 0 where it does not, `None` where there is no motion.
    pub period: Option<usize>,
    /// Frequency of the strongest spectral line in Hz.
    pub main_frequency: Option<f64>,
    /// Half the distance from the lowest trough to the highest peak, in m.
    pub amplitude: f64,
    /// Share of time in stick.
    pub stick_fraction: f64,
    /// Largest Lyapunov exponent in 1/s, the trivial one along the motion left out; minus infinity where differences
    /// vanish altogether.
    pub lyapunov: Option<f64>,
    /// What became of the point.
    pub status: Status,
    /// The section's points.
    pub section: Vec<Crossing>,
    /// Time in s after which the motion repeats.
    pub duration: Option<f64>,
    /// Where the motion can be gone on with.
    pub end: Option<Carry>,
}

/// Follows one point to its motion.
///
/// # Errors
/// Parameters outside the range in which the equations hold, or a run that can't go on.
pub fn evaluate(
    subject: &Subject,
    rule: &Rule,
    from: &StartRule,
    carried: Option<&Carry>,
) -> Result<Motion, PhysicsError> {
    subject.model.require_springs()?;
    let tolerance = subject.tolerance;
    let begin = start(from, subject, carried);
    let inputs = subject.model.inputs;
    let run = Simulation::from_model(subject.model.clone(), inputs, &begin, tolerance)?;
    let mut path = Path::new(Run::quickest(run));
    let Some(mut stretch) = path.stretch(rule, rule.settle, false, None)? else {
        return Ok(rest(&path));
    };
    let mut round = 0;
    loop {
        let amplitude = stretch.amplitude_from(stretch.peaks.len() / 2);
        if amplitude < path.least {
            return Ok(rest(&path));
        }
        let mut exponent = rule
            .lyapunov
            .then(|| Exponent::new(&mut path.follower, amplitude, tolerance));
        match path.stretch(rule, rule.cycles, true, exponent.as_mut())? {
            Some(next) => stretch = next,
            None => return Ok(rest(&path)),
        }
        let motion = describe(&path, &mut stretch, exponent.as_ref());
        // What sticks in every cycle is excited in every cycle: it may fall for a while, but not to nothing.
        let falls = motion.status == Status::DiesOut && motion.stick_fraction == 0.0;
        let may_repeat = motion.period == Some(0) && !falls;
        let has_grown = exponent.as_ref().is_none_or(Exponent::has_grown);
        if !may_repeat || has_grown || round == rule.patience {
            return Ok(motion);
        }
        round += 1;
    }
}

/// A run on its way.
struct Path {
    follower: Follower,
    features: Features,
    /// Time in s without a peak after which nothing moves.
    quiet: f64,
    /// Amplitude in m below which nothing moves.
    least: f64,
}

impl Path {
    fn new(run: Run) -> Self {
        let model = run.model();
        let lowest = model
            .beam()
            .modes()
            .iter()
            .fold(f64::INFINITY, |a, m| a.min(m.frequency));
        let deflection =
            static_compliance(model) * model.static_limit(run.time(), &[0.0; MAX_STATES]);
        let belt = model.inputs.belt_velocity.abs();
        let stick = if belt > 0.0 {
            4.0 * deflection / belt
        } else {
            0.0
        };
        Self {
            quiet: QUIET / lowest + stick.min(LONGEST_STICK),
            least: (REST * deflection).max(1e-12),
            follower: Follower::new(run),
            features: Features::default(),
        }
    }

    /// Goes on for `peaks` peaks; `None` where no peak comes any more.
    fn stretch(
        &mut self,
        rule: &Rule,
        peaks: usize,
        sampled: bool,
        mut exponent: Option<&mut Exponent>,
    ) -> Result<Option<Stretch>, PhysicsError> {
        let mut stretch = Stretch::new(&self.follower, rule.section, sampled);
        let mut seen = stretch.to;
        while stretch.peaks.len() < peaks {
            stretch.next(&mut self.follower, &mut self.features)?;
            if self.features.peaks.is_empty() {
                if stretch.to - seen > self.quiet {
                    return Ok(None);
                }
                continue;
            }
            seen = stretch.to;
            if let Some(exponent) = exponent.as_deref_mut() {
                let mode = self.follower.run().contact_mode();
                exponent.meet(&mut self.follower, &self.features.peaks, mode)?;
            }
        }
        Ok(Some(stretch))
    }
}

fn rest(path: &Path) -> Motion {
    let model = path.follower.run().model();
    Motion {
        period: None,
        main_frequency: None,
        amplitude: 0.0,
        stick_fraction: match path.features.mode {
            Some(ContactMode::Stuck) => 1.0,
            _ => 0.0,
        },
        lyapunov: None,
        status: Status::Rest,
        section: Vec::new(),
        duration: None,
        end: Some(carry(model, path.follower.run().piece_end(), 0.0)),
    }
}

fn carry(model: &Model, state: &State, travel: f64) -> Carry {
    Carry {
        modes: model.beam().modes().len(),
        dimension: model.dimension(),
        state: *state,
        travel,
    }
}

fn describe(path: &Path, stretch: &mut Stretch, exponent: Option<&Exponent>) -> Motion {
    let lyapunov = exponent.and_then(Exponent::value);
    let model = path.follower.run().model();
    let quarters = [0, 1, 2, 3].map(|i| stretch.amplitude_from(i * stretch.peaks.len() / 4));
    let [amplitude, _, later, _] = quarters;
    let period = period_of(model.beam(), &stretch.points, amplitude);
    let duration = period.map(|p| {
        let n = stretch.points.len();
        stretch.points[n - 1].time - stretch.points[n - 1 - p].time
    });
    let line = strongest_line(stretch.last_samples(duration), stretch.interval);
    // The strongest line of a motion that repeats is a multiple of its own frequency.
    let main = match (line, duration) {
        (Some(f), Some(t)) if (f * t).round() >= 1.0 => Some((f * t).round() / t),
        _ => line,
    };
    let shrinks = quarters.windows(2).all(|q| q[1] < DYING * q[0]);
    let status = if stretch.points.is_empty() {
        Status::NoSection
    } else if period.is_some() {
        Status::Settled
    } else if shrinks && lyapunov.is_some_and(|l| l < 0.0) {
        Status::DiesOut
    } else if exponent.is_some_and(Exponent::has_shrunk) {
        Status::Settling
    } else if exponent.is_some_and(Exponent::has_grown) {
        Status::Settled
    } else {
        Status::Unresolved
    };
    let end = stretch.last.map(|peak| {
        let mode = ContactMode::slip_towards(-model.inputs.belt_velocity);
        let travel = model.motion(peak.time, &peak.state, mode).travel;
        carry(model, &peak.state, travel)
    });
    Motion {
        period: Some(period.unwrap_or(0)),
        main_frequency: main,
        amplitude: if period.is_some() { later } else { amplitude },
        stick_fraction: stretch.stick_fraction(),
        lyapunov,
        status,
        section: std::mem::take(&mut stretch.points),
        duration,
        end,
    }
}
