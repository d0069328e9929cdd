//! Whether the memory of a hypothesis fades within a segment.
//!
//! Each segment has start values of its own for the states of effects. A memory that is short beside a segment has next to nothing of them
//! left at its end: there its law is seen. One that has not faded by then is another constant in each segment. Where the hypothesis is
//! adequate, what remains is white, and the evidence prices these values as it prices all; where it is not, they take up whatever nobody
//! modelled, and it would be believed for that alone.

use crate::diagnose::estimation::fitter::Fitter;
use crate::diagnose::initialisation::score_test::one_step;
use crate::diagnose::selection::fitted_model::{FittedModel, is_small};
use crate::diagnose::selection::screening::Screen;
use crate::error::Error;
use crate::parallel::parallel;

/// Share of a start value that may be left at the end of a segment. A memory that decays to that has a fifth of its squares in start values:
/// `(1 - share^2) / (2 ln(1/share))`.
const LEFT: f64 = 0.1;

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

    /// Whether of each state of an effect no more than [`LEFT`] remains at the end of a segment. What is down to the noise leaves nothing to
    /// be taken up, and what no segment shows is held against none.
    fn fades(&self, model: &FittedModel) -> Result<bool, Error> {
        let h = &model.fitted.hypothesis;
        if h.extra_states.is_empty() || is_small(&model.fit) {
            return Ok(true);
        }
        let data = self.problem.data(&self.segments);
        let mut predictor = self.problem.predictor(h)?;
        let mut fitter = Fitter::new(&mut predictor, h, &data, one_step());
        let left = fitter.memory_left(&model.fitted.fit.point);
        Ok(!left.iter().any(|left| *left > LEFT))
    }
}
