//! Whether the memory of a hypothesis fades within a segment.
//!
//! Each segment has start values of its own for the states of effects. What they leave at its end, over what they were,
//!
//! ```text
//! share = |z_end(z + d) - z_end(z)| / |d|
//! ```
//!
//! is next to nothing for a memory that is short beside a segment: there its law is seen. One that has not faded by then is another constant
//! in each segment. Where the hypothesis is adequate, what remains is white, and the evidence prices these values as it prices all; where it
//! is not, they take up whatever nobody modelled, and it would be believed for that alone.

use crate::diagnose::estimation::fitter::Fitter;
use crate::diagnose::initialisation::score_test::one_step;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::screening::Screen;
use crate::error::Error;
use crate::metric::median;
use crate::parallel::parallel;

/// Share of a start value that may be left at the end of a segment. A memory that decays to that has a fifth of its squares in start values:
/// `(1 - share^2) / (2 ln(1/share))`.
const LEFT: f64 = 0.1;
/// How far a start value is moved, as a share of its typical size: linear, and far above what an integrator loses.
const MOVED: f64 = 0.01;

impl Screen<'_> {
    /// Those of some models whose memory fades, and those without any.
    ///
    /// # Errors
    /// An FMU that can't be instantiated.
    pub(crate) fn fading(&self, models: Vec<FittedModel>) -> Result<Vec<FittedModel>, Error> {
        let fades = parallel(&models, |model| self.fades(model))?;
        let both = models.into_iter().zip(fades);
        Ok(both.filter(|(_, fades)| *fades).map(|(m, _)| m).collect())
    }

    /// Whether of each state of an effect no more than [`LEFT`] remains at the end of a segment, in the median of the segments that another
    /// one follows.
    fn fades(&self, model: &FittedModel) -> Result<bool, Error> {
        let h = &model.fitted.hypothesis;
        if h.extra_states.is_empty() {
            return Ok(true);
        }
        let data = self.problem.data(&self.segments);
        let mut predictor = self.problem.predictor(h)?;
        let mut fitter = Fitter::new(&mut predictor, h, &data, one_step());
        let point = &model.fitted.fit.point;
        let modal = 2 * h.modes;
        let mut left: Vec<Vec<f64>> = vec![Vec::new(); h.extra_states.len()];
        for k in 1..self.segments.len() {
            if !self.segments[k].follows(&self.segments[k - 1]) {
                continue;
            }
            let Some(reached) = fitter.carried_on(k, point) else {
                continue;
            };
            for (i, (_, nominal)) in h.extra_states.iter().enumerate() {
                let mut moved = point.clone();
                moved.states[k - 1][modal + i] += MOVED * nominal;
                if let Some(other) = fitter.carried_on(k, &moved) {
                    let change = other.state[modal + i] - reached.state[modal + i];
                    left[i].push((change / (MOVED * nominal)).abs());
                }
            }
        }
        // Of a memory that no segment shows nothing is known.
        let fades = |left: &mut Vec<f64>| !left.is_empty() && median(left) <= LEFT;
        Ok(left.iter_mut().all(fades))
    }
}
