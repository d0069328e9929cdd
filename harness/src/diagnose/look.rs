//! First looks at the starts of a search, and the climb from those that look best.

use super::fit::{Data, Effort, Fit, Fitter};
use super::hypothesis::Hypothesis;
use super::predictor::{Point, Predictor};
use super::search::{Depth, keep_better};

/// Jacobians after which a start must not be hopeless: ...
const FOOTHILL: usize = 2;
/// ... above this many times the objective without the effect.
const HOPELESS: f64 = 2.0;
/// A fit whose median error is below this many times the noise is about to arrive.
const FOUND: f64 = 1.5;

/// The search for one hypothesis.
pub(super) struct Looker<'a, 'b> {
    hypothesis: &'a Hypothesis,
    data: &'b Data<'b>,
    depth: Depth,
    /// The best fit that was followed.
    pub best: Option<Fit>,
}

impl<'a, 'b> Looker<'a, 'b> {
    /// A search that has seen nothing.
    pub fn new(hypothesis: &'a Hypothesis, data: &'b Data<'b>, depth: Depth) -> Self {
        Self {
            hypothesis,
            data,
            depth,
            best: None,
        }
    }

    fn fit(&self, predictor: &mut Predictor<'a>, start: Point, effort: Effort) -> Fit {
        Fitter::new(predictor, self.hypothesis, self.data, effort).run(start)
    }

    /// Whether a fit has come down to the noise.
    pub fn has_arrived(&self) -> bool {
        let arrived = |fit: &Fit| self.data.quantile(fit, 0.75) < FOUND;
        self.best.as_ref().is_some_and(arrived)
    }

    /// Looks at the starts and gives those that are left to follow, best first. What is about to arrive is followed at once, and
    /// ends it all when it has.
    pub fn look(&mut self, predictor: &mut Predictor<'a>, starts: Vec<Point>) -> Vec<Fit> {
        let effort = self.depth.first_look();
        let mut looks = Vec::new();
        for start in starts {
            let seen = self.fit(predictor, start, effort);
            if self.data.quantile(&seen, 0.5) < FOUND {
                let climb = self.depth.following(self.depth.climb);
                let fit = self.fit(predictor, seen.point, climb);
                keep_better(&mut self.best, fit);
                if self.has_arrived() {
                    break;
                }
            } else {
                looks.push(seen);
            }
        }
        looks.sort_by(|a, b| a.trimmed.total_cmp(&b.trimmed));
        looks
    }

    /// Follows a start to the end, unless it turns out hopeless beside the objective without the effect.
    pub fn follow(&mut self, predictor: &mut Predictor<'a>, start: Point, without: f64) {
        // Lost shots are not looked for before the start has shown promise: a model that is wrong loses many.
        let foothill = Effort {
            revive: false,
            ..self.depth.following(FOOTHILL)
        };
        let mut fit = self.fit(predictor, start, foothill);
        if fit.trimmed < HOPELESS * without {
            let rest = self.depth.following(self.depth.climb - FOOTHILL);
            fit = self.fit(predictor, fit.point, rest);
        }
        keep_better(&mut self.best, fit);
    }
}
