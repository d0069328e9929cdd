//! Stick and slip phases from the relative velocity.
//!
//! Two-state hidden Markov chain (Rabiner 1989): in stick the estimated relative velocity is
//! normal about 0 with the estimate's standard deviation, in slip it is anywhere in the range of
//! the record. The likeliest sequence of states (Viterbi 1967) gives the phases, the
//! forward-backward probabilities their certainty.

use super::error::ObserverError;

/// What the contact does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PhaseMode {
    /// Relative velocity below 0: the tip lags behind the belt.
    BackwardSlip,
    /// Relative velocity 0.
    Stick,
    /// Relative velocity above 0: the tip overtakes the belt.
    ForwardSlip,
}

impl PhaseMode {
    /// -1, 0 or 1, as the FMU's `contact_mode`.
    pub fn number(self) -> i8 {
        match self {
            PhaseMode::BackwardSlip => -1,
            PhaseMode::Stick => 0,
            PhaseMode::ForwardSlip => 1,
        }
    }

    /// The word for tables and plots.
    pub fn name(self) -> &'static str {
        match self {
            PhaseMode::BackwardSlip => "backward slip",
            PhaseMode::Stick => "stick",
            PhaseMode::ForwardSlip => "forward slip",
        }
    }
}

/// A stretch of the record in one mode.
#[derive(Debug, Clone, PartialEq)]
pub struct Phase {
    /// The mode.
    pub mode: PhaseMode,
    /// Start in s: where the relative velocity leaves or reaches zero, between two samples.
    pub start: f64,
    /// End in s; equal to the start of the next phase.
    pub end: f64,
    /// First sample.
    pub first: usize,
    /// One past the last sample.
    pub past: usize,
    /// Mean probability of this mode in its samples (0 to 1), as far as the standard deviation of
    /// the velocity is right.
    pub certainty: f64,
    /// Whether the record shows the phase from its beginning to its end.
    pub complete: bool,
}

impl Phase {
    /// Duration in s.
    pub fn duration(&self) -> f64 {
        self.end - self.start
    }
}

/// Choices for [`segments`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SegmentSettings {
    /// Stick phases shorter than this many samples are taken for a passage through zero.
    pub least_stick_samples: usize,
    /// Expected number of transitions per sample.
    pub transition_rate: f64,
    /// Factor on the standard deviation given, for errors it does not know of.
    pub std_factor: f64,
}

impl Default for SegmentSettings {
    fn default() -> Self {
        Self {
            least_stick_samples: 4,
            transition_rate: 0.01,
            std_factor: 1.5,
        }
    }
}

/// Finds the phases of a record.
///
/// `time` in s, `relative_velocity` in m/s (`w' - v_belt`), `relative_velocity_std` in m/s; one
/// value per sample. The phases follow each other without gap and cover the record.
pub fn segments(
    time: &[f64],
    relative_velocity: &[f64],
    relative_velocity_std: &[f64],
    settings: &SegmentSettings,
) -> Result<Vec<Phase>, ObserverError> {
    for (what, found) in [
        ("relative velocity", relative_velocity.len()),
        (
            "standard deviation of the relative velocity",
            relative_velocity_std.len(),
        ),
    ] {
        if found != time.len() {
            return Err(ObserverError::LengthMismatch {
                what,
                expected: time.len(),
                found,
            });
        }
    }
    if time.len() < 2 {
        return Err(ObserverError::TooFewSamples {
            found: time.len(),
            needed: 2,
        });
    }
    let chain = Chain::new(relative_velocity, relative_velocity_std, settings);
    let mut stick = chain.likeliest();
    drop_short(&mut stick, settings.least_stick_samples);
    Ok(phases(
        time,
        relative_velocity,
        &stick,
        &chain.probabilities(),
    ))
}

/// The phases of a record whose samples in `stick` are known, as those of [`segments`]; certain throughout.
///
/// # Errors
/// [`ObserverError::LengthMismatch`] where not every sample has a flag.
pub(super) fn phases_of(
    time: &[f64],
    relative_velocity: &[f64],
    stick: &[bool],
) -> Result<Vec<Phase>, ObserverError> {
    if stick.len() != time.len() {
        return Err(ObserverError::LengthMismatch {
            what: "samples known to be in stick",
            expected: time.len(),
            found: stick.len(),
        });
    }
    let certain: Vec<f64> = stick.iter().map(|s| f64::from(u8::from(*s))).collect();
    Ok(phases(time, relative_velocity, stick, &certain))
}

/// Log odds of stick against slip per sample, and of staying against changing.
struct Chain {
    log_odds: Vec<f64>,
    stay: f64,
    change: f64,
}

impl Chain {
    fn new(velocity: &[f64], std: &[f64], settings: &SegmentSettings) -> Self {
        let (low, high) = velocity
            .iter()
            .fold((0.0_f64, 0.0_f64), |(l, h), v| (l.min(*v), h.max(*v)));
        let smallest = 1e-6 * (high - low).max(1e-9);
        let log_odds = velocity
            .iter()
            .zip(std)
            .map(|(v, s)| {
                let s = (s * settings.std_factor).max(smallest);
                let range = (high - low).max(20.0 * s);
                let density =
                    -0.5 * (v / s).powi(2) - (s * (2.0 * std::f64::consts::PI).sqrt()).ln();
                density + range.ln()
            })
            .collect();
        Self {
            log_odds,
            stay: (1.0 - settings.transition_rate).ln(),
            change: settings.transition_rate.ln(),
        }
    }

    /// True where the likeliest sequence sticks.
    fn likeliest(&self) -> Vec<bool> {
        let n = self.log_odds.len();
        // Score of [slip, stick] and where it came from.
        let mut score = [0.0, self.log_odds[0]];
        let mut from = vec![[false, true]; n];
        for (k, from) in from.iter_mut().enumerate().skip(1) {
            let to = |stick: bool, gain: f64| {
                let keep = score[usize::from(stick)] + self.stay;
                let turn = score[usize::from(!stick)] + self.change;
                if keep >= turn {
                    (keep + gain, stick)
                } else {
                    (turn + gain, !stick)
                }
            };
            let (slip, from_slip) = to(false, 0.0);
            let (hold, from_hold) = to(true, self.log_odds[k]);
            score = [slip, hold];
            *from = [from_slip, from_hold];
        }
        let mut state = score[1] > score[0];
        let mut out = vec![state; n];
        for k in (0..n).rev() {
            out[k] = state;
            state = from[k][usize::from(state)];
        }
        out
    }

    /// Probability of stick in every sample.
    fn probabilities(&self) -> Vec<f64> {
        let n = self.log_odds.len();
        let spread = |score: [f64; 2]| {
            [
                log_sum(score[0] + self.stay, score[1] + self.change),
                log_sum(score[1] + self.stay, score[0] + self.change),
            ]
        };
        let mut forward = vec![[0.0; 2]; n];
        forward[0] = [0.0, self.log_odds[0]];
        for k in 1..n {
            let next = spread(forward[k - 1]);
            forward[k] = [next[0], next[1] + self.log_odds[k]];
        }
        let mut later = [0.0; 2];
        let mut out = vec![0.0; n];
        for k in (0..n).rev() {
            let odds = forward[k][1] + later[1] - forward[k][0] - later[0];
            out[k] = 1.0 / (1.0 + (-odds).exp());
            later = spread([later[0], later[1] + self.log_odds[k]]);
        }
        out
    }
}

fn log_sum(a: f64, b: f64) -> f64 {
    a.max(b) + (-(a - b).abs()).exp().ln_1p()
}

/// Turns stick phases of fewer than `least` samples into slip.
fn drop_short(stick: &mut [bool], least: usize) {
    let mut k = 0;
    while k < stick.len() {
        let past = end_of_run(stick, k);
        let inner = k > 0 && past < stick.len();
        if stick[k] && inner && past - k < least {
            stick[k..past].fill(false);
        }
        k = past;
    }
}

fn end_of_run<T: PartialEq>(values: &[T], from: usize) -> usize {
    values[from..]
        .iter()
        .position(|v| *v != values[from])
        .map_or(values.len(), |offset| from + offset)
}

fn phases(time: &[f64], velocity: &[f64], stick: &[bool], probability: &[f64]) -> Vec<Phase> {
    let modes: Vec<PhaseMode> = stick
        .iter()
        .zip(velocity)
        .map(|(stick, v)| match (stick, *v > 0.0) {
            (true, _) => PhaseMode::Stick,
            (false, true) => PhaseMode::ForwardSlip,
            (false, false) => PhaseMode::BackwardSlip,
        })
        .collect();
    let mut out: Vec<Phase> = Vec::new();
    let mut first = 0;
    while first < modes.len() {
        let past = end_of_run(&modes, first);
        let mode = modes[first];
        let sure = probability[first..past].iter().sum::<f64>() / (past - first) as f64;
        out.push(Phase {
            mode,
            start: time[first],
            end: time[past - 1],
            first,
            past,
            certainty: if mode == PhaseMode::Stick {
                sure
            } else {
                1.0 - sure
            },
            complete: first > 0 && past < modes.len(),
        });
        first = past;
    }
    for i in 1..out.len() {
        let at = border(time, velocity, &out[i - 1], &out[i]);
        out[i - 1].end = at;
        out[i].start = at;
    }
    out
}

/// Transition time between the last sample of one phase and the first of the next: where the
/// relative velocity, continued from the slipping side, is zero.
fn border(time: &[f64], velocity: &[f64], before: &Phase, after: &Phase) -> f64 {
    let (a, b) = (before.past - 1, after.first);
    let step = time[b] - time[a];
    let share = match (before.mode, after.mode) {
        (PhaseMode::Stick, _) => {
            // Velocity leaves zero gradually: half way is the unbiased guess.
            0.5
        }
        (_, PhaseMode::Stick) if before.past - before.first >= 2 => {
            let slope = velocity[a] - velocity[a - 1];
            if slope * velocity[a] < 0.0 {
                (-velocity[a] / slope).clamp(0.0, 1.0)
            } else {
                0.5
            }
        }
        _ => {
            let change = velocity[b] - velocity[a];
            if change == 0.0 {
                0.5
            } else {
                (-velocity[a] / change).clamp(0.0, 1.0)
            }
        }
    };
    time[a] + share * step
}
