//! The paper's extended state observer run on a sampled displacement (Stelter 1992, eqs. 9-11).

use super::error::ObserverError;
use super::poles::{PoleRule, continuous_gain, delay, discrete_gain, model, observer_matrix};
use super::structure::Structure;
use nalgebra::{Complex, DMatrix, DVector};

/// How the observer is brought to sampled data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TimeForm {
    /// The structure is discretised exactly for a force constant over each interval, and the
    /// discrete observer has the poles `exp(p T)`.
    #[default]
    Discrete,
    /// The continuous observer of eq. (10), integrated exactly for a displacement that runs
    /// straight from sample to sample.
    Continuous,
}

/// What [`observe`] finds; one value per sample in every column.
#[derive(Debug, Clone, PartialEq)]
pub struct Observed {
    /// Modal coordinates `q[j][k]` in m.
    pub q: Vec<Vec<f64>>,
    /// Modal velocities `q_dot[j][k]` in m/s.
    pub q_dot: Vec<Vec<f64>>,
    /// Contact force on the tip in N; late by [`Observed::delay`].
    pub force: Vec<f64>,
    /// Tip displacement in m.
    pub displacement: Vec<f64>,
    /// Tip velocity in m/s.
    pub velocity: Vec<f64>,
    /// The poles used, in 1/s.
    pub poles: Vec<Complex<f64>>,
    /// Delay of the force at low frequency in s.
    pub delay: f64,
}

impl Observed {
    /// The force moved earlier by its delay (linear interpolation); the last values are held.
    pub fn force_without_delay(&self, sample_interval: f64) -> Vec<f64> {
        let shift = self.delay / sample_interval;
        let last = self.force.len() - 1;
        (0..self.force.len())
            .map(|k| {
                let at = (k as f64 + shift).clamp(0.0, last as f64);
                let below = at.floor() as usize;
                let share = at - below as f64;
                self.force[below] * (1.0 - share) + self.force[(below + 1).min(last)] * share
            })
            .collect()
    }
}

/// Runs the observer over a uniformly sampled displacement.
///
/// `sample_interval` in s; `displacement` in m at the tip, NaN where missing (the observer then
/// runs on without correction). Causal: the force is late and jumps are smeared over the inverse
/// of the pole speed; the smoothers of this library do better on recorded data.
pub fn observe(
    structure: &Structure,
    sample_interval: f64,
    displacement: &[f64],
    rule: &PoleRule,
    form: TimeForm,
) -> Result<Observed, ObserverError> {
    if !structure.is_collocated() {
        return Err(ObserverError::PolesElsewhere);
    }
    let poles = rule.poles(structure, sample_interval, displacement)?;
    let stepper = match form {
        TimeForm::Discrete => Stepper::discrete(structure, &poles, sample_interval)?,
        TimeForm::Continuous => Stepper::continuous(structure, &poles, sample_interval)?,
    };
    let modes = structure.modes();
    let n = modes.len();
    let count = displacement.len();
    let first = displacement.iter().copied().find(|y| !y.is_nan());
    let Some(first) = first else {
        return Err(ObserverError::TooFewSamples {
            found: 0,
            needed: 1,
        });
    };
    let column = || Vec::with_capacity(count);
    let mut out = Observed {
        q: vec![column(); n],
        q_dot: vec![column(); n],
        force: column(),
        displacement: column(),
        velocity: column(),
        delay: delay(&poles),
        poles,
    };
    // Start in static equilibrium with the first sample.
    let force = first / structure.static_compliance();
    let mut state = DVector::zeros(2 * n + 1);
    for (j, mode) in modes.iter().enumerate() {
        state[2 * j] = mode.modal_compliance() * force;
    }
    state[2 * n] = force * stepper.force_scale;
    let mut scratch = state.clone();
    for k in 0..count {
        stepper.correct(&mut state, displacement[k]);
        let (mut w, mut w_dot) = (0.0, 0.0);
        for (j, mode) in modes.iter().enumerate() {
            let velocity = state[2 * j + 1] * stepper.velocity_scale[j];
            out.q[j].push(state[2 * j]);
            out.q_dot[j].push(velocity);
            w += mode.tip_value * state[2 * j];
            w_dot += mode.tip_value * velocity;
        }
        out.displacement.push(w);
        out.velocity.push(w_dot);
        out.force.push(state[2 * n] / stepper.force_scale);
        let next = displacement.get(k + 1).copied().unwrap_or(f64::NAN);
        stepper.advance(&mut state, &mut scratch, displacement[k], next);
    }
    Ok(out)
}

/// One step of either form: `z <- (z + gain (w_k - c z))`, then
/// `z <- A z + early w_k + late w_(k+1)` (without the terms in `w` where a sample is missing).
struct Stepper {
    gain: DVector<f64>,
    output: DVector<f64>,
    transition: DMatrix<f64>,
    early: DVector<f64>,
    late: DVector<f64>,
    free: DMatrix<f64>,
    velocity_scale: Vec<f64>,
    force_scale: f64,
}

impl Stepper {
    fn discrete(
        structure: &Structure,
        poles: &[Complex<f64>],
        interval: f64,
    ) -> Result<Self, ObserverError> {
        let model = model(structure, interval)?;
        let size = model.output.len();
        Ok(Self {
            gain: discrete_gain(structure, poles, interval)?,
            output: model.output,
            transition: model.transition.clone(),
            early: DVector::zeros(size),
            late: DVector::zeros(size),
            free: model.transition,
            velocity_scale: structure
                .modes()
                .iter()
                .map(|m| m.angular_frequency())
                .collect(),
            force_scale: model.force_scale,
        })
    }

    fn continuous(
        structure: &Structure,
        poles: &[Complex<f64>],
        interval: f64,
    ) -> Result<Self, ObserverError> {
        let mut model = model(structure, interval)?;
        let size = model.output.len();
        // To scaled states: S z = x, with x in SI units.
        let mut scale = DVector::from_element(size, 1.0);
        for (j, mode) in structure.modes().iter().enumerate() {
            scale[2 * j + 1] = mode.angular_frequency();
        }
        scale[size - 1] = 1.0 / model.force_scale;
        let si_gain = continuous_gain(structure, poles)?;
        let matrix = observer_matrix(structure, &si_gain);
        // [z; w; w'] with constant w': one matrix exponential gives all three responses
        // (van Loan 1978).
        let mut block = DMatrix::zeros(size + 2, size + 2);
        for row in 0..size {
            for column in 0..size {
                block[(row, column)] =
                    matrix[(row, column)] * scale[column] / scale[row] * interval;
            }
            block[(row, size)] = si_gain[row] / scale[row] * interval;
        }
        block[(size, size + 1)] = 1.0;
        let response = block.exp();
        let rise = response
            .view((0, size + 1), (size, 1))
            .column(0)
            .into_owned();
        let held = response.view((0, size), (size, 1)).column(0).into_owned();
        model.output.fill(0.0);
        Ok(Self {
            gain: DVector::zeros(size),
            output: model.output,
            transition: response.view((0, 0), (size, size)).into_owned(),
            early: held - &rise,
            late: rise,
            free: model.transition,
            velocity_scale: structure
                .modes()
                .iter()
                .map(|m| m.angular_frequency())
                .collect(),
            force_scale: model.force_scale,
        })
    }

    fn correct(&self, state: &mut DVector<f64>, w: f64) {
        if !w.is_nan() {
            let innovation = w - self.output.dot(state);
            state.axpy(innovation, &self.gain, 1.0);
        }
    }

    fn advance(&self, state: &mut DVector<f64>, scratch: &mut DVector<f64>, w: f64, next: f64) {
        if w.is_nan() || next.is_nan() {
            scratch.gemv(1.0, &self.free, state, 0.0);
        } else {
            scratch.gemv(1.0, &self.transition, state, 0.0);
            scratch.axpy(w, &self.early, 1.0);
            scratch.axpy(next, &self.late, 1.0);
        }
        std::mem::swap(state, scratch);
    }
}
