//! Regression on sets of effects: how well a few effects together explain what a model leaves, to first order.
//!
//! On a window k of the record the residual r_k of a model is, to first order,
//!
//! ```text
//! r_k = X_k x_k + N_k n + sum_e C_ke c_e + noise
//! ```
//!
//! with x_k the start state of the window, n the nuisances, believed to lie about n_0 with the standard deviations s, and c_e the
//! coefficients of the effects of a set. The start states are projected out. The rest minimises the negative logarithm of
//! [`Likelihood`] and priors by iteratively reweighted least squares, and Laplace's approximation, with the curvature of
//! these, gives the evidence of the set. Holds
//! where windows are so short that a wrong model errs by its forces and not yet by the transitions that it misses; from afar it ranks and
//! says no more. Sources: all subsets, Hocking, Biometrics 32 (1976) 1, sect. 3; reweighting, Holland and Welsch,
//! Communications in Statistics A6 (1977) 813; evidence, MacKay, Neural Computation 4 (1992) 415, sect. 4.

use crate::diagnose::estimation::likelihood::Likelihood;
use nalgebra::{DMatrix, DVector};

/// Reweightings at most, ...
const REWEIGHTED: usize = 12;
/// ... and the fall in nats below which they end: far less than what sets differ by.
const LEAST_FALL: f64 = 0.01;
/// Part of a column, as a share of it, that is rounding once others have been projected out.
const ROUNDING: f64 = 1e-7;

/// One window of the record.
pub(crate) struct Window {
    /// Measured less predicted, m.
    pub residual: DVector<f64>,
    /// Derivatives of the prediction by the start state.
    pub states: DMatrix<f64>,
    /// The same by the nuisances.
    pub nuisances: DMatrix<f64>,
    /// Likelihood of what is left.
    pub likelihood: Likelihood,
    /// Whether no other window ends where it begins.
    pub is_first: bool,
}

/// What is believed of a nuisance, on its scale.
#[derive(Clone, Copy)]
pub(crate) struct Belief {
    /// Standard deviation; zero of what does not move.
    pub std: f64,
    /// Where the model stands, less what is believed.
    pub offset: f64,
}

/// What an effect changes in the prediction of a window.
pub(crate) struct Change {
    /// Per unit of each of its coefficients, m.
    pub columns: DMatrix<f64>,
    /// Per unit of each component that it adds to the start state, in units of what is believed of that over the noise.
    pub states: DMatrix<f64>,
}

/// An effect in one of its shapes.
pub(crate) struct Effect {
    /// What it changes in each window.
    pub changes: Vec<Change>,
    /// Standard deviation believed of each coefficient, about zero.
    pub std: Vec<f64>,
    /// Whether its coefficients can't be negative.
    pub is_positive: bool,
    /// Price in nats of having been chosen among shapes.
    pub price: f64,
}

/// How well a set explains the residuals.
pub(crate) struct Explained {
    /// Negative logarithm of the evidence, nats, up to what is the same for all sets.
    pub score: f64,
    /// Change of each nuisance.
    pub nuisances: Vec<f64>,
    /// Coefficients of each effect of the set.
    pub effects: Vec<Vec<f64>>,
    /// Whether no effect is pulled to where it can't be: else the set without it stands for it.
    pub is_possible: bool,
}

/// The windows, their start states projected out.
pub(crate) struct Regression {
    windows: Vec<Window>,
    bases: Vec<DMatrix<f64>>,
    beliefs: Vec<Belief>,
}

/// A window's part of the normal equations, by what is free and acts there.
struct Part {
    free: Vec<usize>,
    matrix: DMatrix<f64>,
    right: DVector<f64>,
    square: f64,
}

impl Part {
    fn sum_of_squares(&self, all: &DVector<f64>) -> f64 {
        let own = all.select_rows(&self.free);
        (self.square - 2.0 * own.dot(&self.right) + own.dot(&(&self.matrix * &own))).max(0.0)
    }
}

/// A component that an effect adds to the start state of a window: that window, and the information on it in units of what is believed.
type StateTold = (usize, f64);

impl Regression {
    /// The regression of the residuals of some windows.
    pub fn new(windows: Vec<Window>, beliefs: Vec<Belief>) -> Self {
        let basis = |w: &Window| {
            let mut basis = Vec::new();
            for column in w.states.column_iter() {
                extend(&mut basis, column.into_owned(), 0.0);
            }
            as_matrix(&basis, w.residual.len())
        };
        let bases: Vec<DMatrix<f64>> = windows.iter().map(basis).collect();
        let projected = windows.into_iter().zip(&bases).map(|(w, q)| Window {
            nuisances: without(q, w.nuisances),
            residual: without(q, w.residual),
            ..w
        });
        Self {
            windows: projected.collect(),
            bases,
            beliefs,
        }
    }

    /// An effect, the start states of the windows projected out.
    pub fn beside_states(&self, effect: Effect) -> Effect {
        let both = effect.changes.into_iter().zip(&self.bases);
        let changes = both.map(|(change, q)| Change {
            columns: without(q, change.columns),
            states: without(q, change.states),
        });
        Effect {
            changes: changes.collect(),
            ..effect
        }
    }

    /// How well a set of effects, each [`Self::beside_states`], explains the residuals; `None` where that is not determined.
    pub fn explained_by(&self, set: &[&Effect]) -> Option<Explained> {
        let known = self.beliefs.len();
        let mut beliefs = self.beliefs.clone();
        for effect in set {
            let of_effect = effect.std.iter().map(|&std| Belief { std, offset: 0.0 });
            beliefs.extend(of_effect);
        }
        let free: Vec<usize> = (0..beliefs.len())
            .filter(|&i| beliefs[i].std > 0.0)
            .collect();
        let beliefs_free: Vec<Belief> = free.iter().map(|&i| beliefs[i]).collect();
        let mut told: Vec<StateTold> = Vec::new();
        let parts: Vec<Part> = (0..self.windows.len())
            .map(|k| self.part(k, set, &free, &mut told))
            .collect();
        let (mut at, mut objective) = (DVector::zeros(free.len()), f64::INFINITY);
        for _ in 0..REWEIGHTED {
            let (matrix, right) = self.normal(&parts, &beliefs_free, &at);
            let next = solved(&matrix, &right)?;
            let reached = self.objective(&parts, &beliefs_free, &next);
            let fall = objective - reached;
            if !(fall > LEAST_FALL) {
                break;
            }
            (at, objective) = (next, reached);
        }
        if !objective.is_finite() {
            return None;
        }
        let (information, _) = self.normal(&parts, &beliefs_free, &at);
        let mut all = vec![0.0; beliefs.len()];
        free.iter().zip(&at).for_each(|(&i, value)| all[i] = *value);
        let mut from = known;
        let (mut effects, mut is_possible) = (Vec::new(), true);
        for effect in set {
            let own = all[from..from + effect.std.len()].to_vec();
            is_possible &= !effect.is_positive || own.iter().all(|c| *c >= 0.0);
            from += own.len();
            effects.push(own);
        }
        all.truncate(known);
        let scaled = DMatrix::from_fn(free.len(), free.len(), |i, j| {
            information[(i, j)] * beliefs_free[i].std * beliefs_free[j].std
        });
        let volume = scaled.cholesky()?.l().diagonal().map(f64::ln).sum();
        let shapes: f64 = set.iter().map(|e| e.price).sum();
        Some(Explained {
            score: objective + volume + shapes + self.price_of_states(&parts, &at, &told),
            nuisances: all,
            effects,
            is_possible,
        })
    }

    /// Window `k` with a set of effects; of the start state's components that these add, those that the window tells are projected out.
    fn part(&self, k: usize, set: &[&Effect], free: &[usize], told: &mut Vec<StateTold>) -> Part {
        let window = &self.windows[k];
        let mut basis = Vec::new();
        for column in set.iter().flat_map(|e| e.changes[k].states.column_iter()) {
            let Some(norm) = extend(&mut basis, column.into_owned(), 1.0) else {
                continue;
            };
            // A window that another one leads up to begins where that ends.
            if window.is_first {
                told.push((k, norm * norm));
            }
        }
        let of_effects = set.iter().flat_map(|e| e.changes[k].columns.column_iter());
        let all: Vec<_> = window.nuisances.column_iter().chain(of_effects).collect();
        let acts = |j: &usize| all[free[*j]].iter().any(|v| *v != 0.0);
        let acting: Vec<usize> = (0..free.len()).filter(acts).collect();
        let mut columns: Vec<DVector<f64>> =
            acting.iter().map(|&j| all[free[j]].into_owned()).collect();
        columns.push(window.residual.clone());
        let columns = without(
            &as_matrix(&basis, window.residual.len()),
            as_matrix(&columns, window.residual.len()),
        );
        let gram = columns.tr_mul(&columns);
        let count = acting.len();
        Part {
            free: acting,
            matrix: gram.view((0, 0), (count, count)).into_owned(),
            right: gram.view((0, count), (count, 1)).column(0).into_owned(),
            square: gram[(count, count)],
        }
    }

    /// Normal equations, each window weighted as what is left of it at a point asks for.
    fn normal(
        &self,
        parts: &[Part],
        beliefs: &[Belief],
        at: &DVector<f64>,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let mut matrix = DMatrix::zeros(at.len(), at.len());
        let mut right = DVector::zeros(at.len());
        for (part, window) in parts.iter().zip(&self.windows) {
            let weight = window.likelihood.weight(part.sum_of_squares(at));
            for (a, &i) in part.free.iter().enumerate() {
                right[i] += weight * part.right[a];
                for (b, &j) in part.free.iter().enumerate() {
                    matrix[(i, j)] += weight * part.matrix[(a, b)];
                }
            }
        }
        for (i, belief) in beliefs.iter().enumerate() {
            let precision = belief.std.powi(-2);
            matrix[(i, i)] += precision;
            right[i] -= precision * belief.offset;
        }
        (matrix, right)
    }

    /// Negative logarithm of likelihood and prior, nats.
    fn objective(&self, parts: &[Part], beliefs: &[Belief], at: &DVector<f64>) -> f64 {
        let windows = parts.iter().zip(&self.windows);
        let losses = windows.map(|(part, w)| w.likelihood.loss(part.sum_of_squares(at)));
        let believed = beliefs.iter().zip(at);
        let prior = believed.map(|(b, value)| 0.5 * ((value + b.offset) / b.std).powi(2));
        losses.sum::<f64>() + prior.sum::<f64>()
    }

    /// Price in nats of what effects add to the start states. Here it is told as far as what is left of the windows lets it be; the evidence
    /// of a fit takes all windows as met, and from afar that price stood above all that any effect gains.
    fn price_of_states(&self, parts: &[Part], at: &DVector<f64>, told: &[StateTold]) -> f64 {
        let price = |&(k, information): &StateTold| {
            let likelihood = self.windows[k].likelihood;
            let share = likelihood.weight(parts[k].sum_of_squares(at)) / likelihood.weight(0.0);
            0.5 * (share * information).ln_1p()
        };
        told.iter().map(price).sum()
    }
}

/// Adds what a column has beyond an orthonormal basis to that, unless it is rounding or no longer than `least`; its length if it was
/// added.
fn extend(basis: &mut Vec<DVector<f64>>, mut column: DVector<f64>, least: f64) -> Option<f64> {
    let whole = column.norm();
    // Twice is enough (Kahan, in Parlett, The Symmetric Eigenvalue Problem, 1998, section 6.9).
    for _ in 0..2 {
        for b in basis.iter() {
            let along = b.dot(&column);
            column.axpy(-along, b, 1.0);
        }
    }
    let beyond = column.norm();
    if !(beyond > ROUNDING * whole && beyond > least) {
        return None;
    }
    basis.push(column / beyond);
    Some(beyond)
}

fn as_matrix(columns: &[DVector<f64>], rows: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns.len(), |i, j| columns[j][i])
}

/// What columns have beyond an orthonormal basis.
fn without<C: nalgebra::Dim>(
    basis: &DMatrix<f64>,
    mut columns: nalgebra::OMatrix<f64, nalgebra::Dyn, C>,
) -> nalgebra::OMatrix<f64, nalgebra::Dyn, C>
where
    nalgebra::DefaultAllocator: nalgebra::allocator::Allocator<nalgebra::Dyn, C>
        + nalgebra::allocator::Allocator<C>
        + nalgebra::allocator::Allocator<nalgebra::Dyn, C>,
{
    for _ in 0..2 {
        let explained = basis * (basis.transpose() * &columns);
        columns -= explained;
    }
    columns
}

/// Solution of a system scaled to a diagonal of ones.
fn solved(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let scale = matrix.diagonal().map(|d| d.sqrt().recip());
    let scaled = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        matrix[(i, j)] * scale[i] * scale[j]
    });
    let factor = scaled.cholesky()?;
    Some(
        factor
            .solve(&right.component_mul(&scale))
            .component_mul(&scale),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOISE: f64 = 0.1;
    const ROWS: usize = 30;
    const WINDOWS: usize = 3;

    fn wave(k: usize, j: usize) -> DVector<f64> {
        let rate = 0.31 + 0.17 * j as f64 + 0.05 * k as f64;
        DVector::from_fn(ROWS, |i, _| (rate * i as f64 + j as f64).sin())
    }

    /// Windows with two components of the start state, a nuisance and what two effects leave.
    fn windows(of_effects: [f64; 2]) -> Vec<Window> {
        let one = |k: usize| {
            let noise = DVector::from_fn(ROWS, |i, _| NOISE * (1.7 * (i * i + 3 * k) as f64).sin());
            Window {
                residual: wave(k, 0) * 0.7 - wave(k, 1) * 0.2
                    + wave(k, 2) * 0.05
                    + wave(k, 3) * of_effects[0]
                    + wave(k, 4) * of_effects[1]
                    + noise,
                states: DMatrix::from_columns(&[wave(k, 0), wave(k, 1)]),
                nuisances: DMatrix::from_columns(&[wave(k, 2)]),
                likelihood: Likelihood::new(ROWS as f64, NOISE, 2),
                is_first: true,
            }
        };
        (0..WINDOWS).map(one).collect()
    }

    fn effect(j: usize, std: f64, states: usize) -> Effect {
        let change = |k: usize| Change {
            columns: DMatrix::from_columns(&[wave(k, j)]),
            states: DMatrix::from_fn(ROWS, states, |i, c| wave(k, 5 + c)[i] * 3.0),
        };
        Effect {
            changes: (0..WINDOWS).map(change).collect(),
            std: vec![std],
            is_positive: true,
            price: 0.0,
        }
    }

    const BELIEF: Belief = Belief {
        std: 0.3,
        offset: 0.02,
    };

    /// Evidence of the linear model with the start states believed to lie anywhere, by the covariance of what is measured.
    fn log_evidence(windows: &[Window], effects: &[usize], stds: &[f64]) -> f64 {
        let wide = 100.0;
        let n = ROWS * WINDOWS;
        let columns = 2 * WINDOWS + 1 + effects.len();
        let mut design = DMatrix::zeros(n, columns);
        let mut data = DVector::zeros(n);
        for (k, w) in windows.iter().enumerate() {
            let rows = k * ROWS;
            // The nuisance is believed to lie at minus its offset from where the model stands.
            let left = &w.residual + wave(k, 2) * BELIEF.offset;
            data.rows_mut(rows, ROWS).copy_from(&left);
            let mut put = |c: usize, column: &DVector<f64>| {
                design.view_mut((rows, c), (ROWS, 1)).copy_from(column);
            };
            put(2 * k, &wave(k, 0));
            put(2 * k + 1, &wave(k, 1));
            put(2 * WINDOWS, &wave(k, 2));
            for (e, &j) in effects.iter().enumerate() {
                put(2 * WINDOWS + 1 + e, &wave(k, j));
            }
        }
        let mut stds_of_all = vec![wide; 2 * WINDOWS];
        stds_of_all.push(BELIEF.std);
        stds_of_all.extend(stds);
        let prior = DMatrix::from_diagonal(&DVector::from_vec(stds_of_all).map(|s| s * s));
        let covariance =
            DMatrix::identity(n, n) * (NOISE * NOISE) + &design * prior * design.transpose();
        let factor = covariance.cholesky().unwrap();
        let half_log: f64 = factor.l().diagonal().iter().map(|d| d.ln()).sum();
        -0.5 * data.dot(&factor.solve(&data)) - half_log
    }

    fn score(regression: &Regression, effects: &[(usize, f64)]) -> f64 {
        let made = effects.iter().map(|&(j, std)| effect(j, std, 0));
        let made: Vec<Effect> = made.map(|e| regression.beside_states(e)).collect();
        let set: Vec<&Effect> = made.iter().collect();
        regression.explained_by(&set).unwrap().score
    }

    /// Source: Bayes' theorem for a linear model with known noise, by the covariance of what is measured.
    #[test]
    fn val_the_score_of_a_set_is_the_evidence_of_a_linear_model() {
        let strengths = [0.03, 0.02];
        let regression = Regression::new(windows(strengths), vec![BELIEF]);
        let alone = score(&regression, &[]);
        let measured = windows(strengths);
        for set in [vec![(3, 0.5)], vec![(4, 0.2)], vec![(3, 0.5), (4, 0.2)]] {
            let (effects, stds): (Vec<usize>, Vec<f64>) = set.iter().copied().unzip();
            let expected =
                log_evidence(&measured, &effects, &stds) - log_evidence(&measured, &[], &[]);
            let found = alone - score(&regression, &set);
            assert!(
                (found - expected).abs() < 1e-4 * expected.abs(),
                "{set:?}: {found} {expected}"
            );
        }
    }

    #[test]
    fn two_effects_that_only_show_together_are_found_together_with_their_strengths() {
        let strengths = [0.9, 0.6];
        let regression = Regression::new(windows(strengths), vec![BELIEF]);
        let of = |set: &[usize]| {
            let set: Vec<(usize, f64)> = set.iter().map(|&j| (j, 1.0)).collect();
            score(&regression, &set)
        };
        assert!(of(&[3, 4]) < of(&[3]).min(of(&[4])) - 20.0);
        let made = [3, 4].map(|j| regression.beside_states(effect(j, 1.0, 0)));
        let found = regression.explained_by(&[&made[0], &made[1]]).unwrap();
        for (found, strength) in found.effects.iter().zip(strengths) {
            assert!((found[0] - strength).abs() < 0.05, "{found:?} {strength}");
        }
    }

    #[test]
    fn what_the_data_pull_to_where_it_cannot_be_is_told() {
        let regression = Regression::new(windows([-0.5, 0.0]), vec![BELIEF]);
        let pulled = regression.beside_states(effect(3, 1.0, 0));
        assert!(!regression.explained_by(&[&pulled]).unwrap().is_possible);
        let free = Effect {
            is_positive: false,
            ..effect(3, 1.0, 0)
        };
        let free = regression.beside_states(free);
        assert!(regression.explained_by(&[&free]).unwrap().is_possible);
    }

    #[test]
    fn components_of_the_start_state_that_an_effect_adds_have_their_price() {
        let regression = Regression::new(windows([0.5, 0.0]), vec![BELIEF]);
        let score = |states: usize| {
            let one = regression.beside_states(effect(3, 1.0, states));
            regression.explained_by(&[&one]).unwrap().score
        };
        assert!(score(2) > score(0), "{} {}", score(2), score(0));
    }
}
