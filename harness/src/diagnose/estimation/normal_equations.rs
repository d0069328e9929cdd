//! The weighted normal equations of a fit, the start states eliminated.

use crate::diagnose::estimation::fitter::{Fitter, Place, directions};
use crate::diagnose::estimation::scaled_matrix::{scaled_inverse, scaled_solve};
use crate::diagnose::estimation::sensitivities::Linear;
use crate::diagnose::model::parameter::{Parameter, Scale};
use crate::diagnose::model::point::Point;
use nalgebra::{DMatrix, DVector};

/// The weighted normal equations, with each segment's start state eliminated.
pub(crate) struct Normal {
    matrix: DMatrix<f64>,
    gradient: DVector<f64>,
    /// Per segment: H_xx, H_xk, g_x, indices of the states.
    blocks: Vec<Option<Block>>,
    shared: usize,
    /// First column of each run's own parameters.
    own_first: Vec<usize>,
    moves: bool,
}

#[derive(Clone)]
struct Block {
    xx: DMatrix<f64>,
    xk: DMatrix<f64>,
    gx: DVector<f64>,
    list: Vec<usize>,
    columns: Vec<usize>,
    kk: DMatrix<f64>,
    gk: DVector<f64>,
    /// Whether the segment has a say in the parameters.
    kept: bool,
}

/// Matrix and gradient of the parameters, and the inverse of each segment's block of start states.
type Reduced = (DMatrix<f64>, DVector<f64>, Vec<Option<DMatrix<f64>>>);

impl Normal {
    /// The equations at a place, each segment weighted by the error variance that it has there.
    pub fn assemble(f: &Fitter, here: &Place, linear: &[Option<Linear>]) -> Self {
        let (point, sums) = (&here.point, &here.sums);
        let h = f.hypothesis;
        let shared = h.shared.len();
        let (matrix, gradient, own_first) = priors(f, point);
        let mut blocks = Vec::new();
        let kept = f.kept(sums);
        for (k, l) in linear.iter().enumerate() {
            let segment = &f.data.segments[k];
            let Some(l) = l else {
                blocks.push(None);
                continue;
            };
            let weight = f.weight(k, sums[k]);
            let r = DVector::from_column_slice(&l.residual);
            let list = directions(h, point.stuck[k]);
            let states = l.states.tr_mul(&l.states);
            let mut xx = weight * states;
            let mut gx = weight * l.states.tr_mul(&r);
            f.add_state_prior(&list, &point.states[k], 1.0, &mut xx, &mut gx);
            let first = own_first[segment.run];
            let columns: Vec<usize> = (0..shared)
                .chain(first..first + h.per_run[segment.run].len())
                .collect();
            let xk = weight * l.states.tr_mul(&l.parameters);
            let kk = weight * l.parameters.tr_mul(&l.parameters);
            let gk = weight * l.parameters.tr_mul(&r);
            blocks.push(Some(Block {
                xx,
                xk,
                gx,
                list,
                columns,
                kk,
                gk,
                kept: kept[k],
            }));
        }
        Self {
            matrix,
            gradient,
            blocks,
            shared,
            own_first,
            moves: f.options.parameters,
        }
    }

    /// The same matrices with what other residuals, in place of those left, pull at; what is believed pulls at nothing.
    pub fn pulled_by(
        &self,
        f: &Fitter,
        here: &Place,
        linear: &[Option<Linear>],
        residual: &[Option<DVector<f64>>],
    ) -> Self {
        let all = self.blocks.iter().zip(linear).zip(residual).enumerate();
        let pulled = all.map(|(k, ((block, l), r))| {
            let (mut block, l) = (block.clone()?, l.as_ref()?);
            let weight = f.weight(k, here.sums[k]);
            let rows = l.states.nrows();
            let none = || DVector::zeros(rows);
            let r = r.clone().unwrap_or_else(none);
            block.gx = weight * l.states.tr_mul(&r);
            block.gk = weight * l.parameters.tr_mul(&r);
            Some(block)
        });
        Self {
            matrix: self.matrix.clone(),
            gradient: DVector::zeros(self.gradient.len()),
            blocks: pulled.collect(),
            own_first: self.own_first.clone(),
            ..*self
        }
    }

    /// Change of a segment's prediction to first order from one point to another.
    pub fn first_order(
        &self,
        f: &Fitter,
        k: usize,
        l: &Linear,
        (from, to): (&Point, &Point),
    ) -> Option<DVector<f64>> {
        let block = self.blocks[k].as_ref()?;
        let run = f.data.segments[k].run;
        let state = block.list.iter();
        let state = state.map(|&i| to.states[k][i] - from.states[k][i]);
        let state = DVector::from_iterator(block.list.len(), state);
        let shared = to.shared.iter().zip(&from.shared);
        let per_run = to.per_run[run].iter().zip(&from.per_run[run]);
        let parameters = shared.chain(per_run).map(|(to, from)| to - from);
        let parameters = DVector::from_iterator(l.parameters.ncols(), parameters);
        Some(&l.states * state + &l.parameters * parameters)
    }

    /// Length of the way from one point to another, all that is free in units of its standard deviation, all else known; segments that
    /// do not count are left out.
    pub fn length(&self, from: &Point, to: &Point) -> f64 {
        let mut diagonal = self.matrix.diagonal();
        let mut of_states = 0.0;
        for (k, block) in self.blocks.iter().enumerate() {
            let Some(b) = block.as_ref().filter(|b| b.kept) else {
                continue;
            };
            let squares = b.list.iter().enumerate();
            let square = |(c, &i): (usize, &usize)| {
                b.xx[(c, c)] * (to.states[k][i] - from.states[k][i]).powi(2)
            };
            of_states += squares.map(square).sum::<f64>();
            for (i, &c) in b.columns.iter().enumerate() {
                diagonal[c] += b.kk[(i, i)];
            }
        }
        let per_run = to.per_run.iter().zip(&from.per_run);
        let per_run = per_run.flat_map(|(to, from)| to.iter().zip(from));
        let all = to.shared.iter().zip(&from.shared).chain(per_run);
        let squares = all
            .zip(&diagonal)
            .map(|((to, from), h)| h * (to - from).powi(2));
        (of_states + squares.sum::<f64>()).sqrt()
    }

    /// The reduced system of the parameters at a damping: `H + damping diag(H)`.
    pub fn reduced(&self, damping: f64) -> Option<Reduced> {
        let mut matrix = self.matrix.clone();
        let mut gradient = self.gradient.clone();
        for i in 0..matrix.nrows() {
            matrix[(i, i)] *= 1.0 + damping;
        }
        let mut inverses = Vec::new();
        for block in &self.blocks {
            let Some(b) = block else {
                inverses.push(None);
                continue;
            };
            let inverse = scaled_inverse(&b.xx, damping)?;
            if self.moves && b.kept {
                let t = &inverse * &b.xk;
                let schur = &b.kk - b.xk.tr_mul(&t);
                let reduced = &b.gk - t.tr_mul(&b.gx);
                for (i, &ci) in b.columns.iter().enumerate() {
                    gradient[ci] += reduced[i];
                    for (j, &cj) in b.columns.iter().enumerate() {
                        matrix[(ci, cj)] += schur[(i, j)];
                    }
                    matrix[(ci, ci)] += damping * b.kk[(i, i)];
                }
            }
            inverses.push(Some(inverse));
        }
        Some((matrix, gradient, inverses))
    }

    /// The point after a step; `None` if the damped matrix is not positive definite.
    pub fn step(&self, f: &Fitter, point: &Point, damping: f64) -> Option<Point> {
        let (matrix, gradient, inverses) = self.reduced(damping)?;
        let mut trial = point.clone();
        let mut moved = DVector::zeros(matrix.nrows());
        if self.moves {
            moved = self.moved(f, point, matrix, gradient)?;
            let h = f.hypothesis;
            for c in 0..self.shared {
                trial.shared[c] += moved[c];
            }
            for (run, parameters) in h.per_run.iter().enumerate() {
                for i in 0..parameters.len() {
                    trial.per_run[run][i] += moved[self.own_first[run] + i];
                }
            }
        }
        for (k, block) in self.blocks.iter().enumerate() {
            let (Some(b), Some(inverse)) = (block, &inverses[k]) else {
                continue;
            };
            let part = DVector::from_iterator(b.columns.len(), b.columns.iter().map(|&c| moved[c]));
            let step = inverse * (&b.gx - &b.xk * part);
            for (c, &i) in b.list.iter().enumerate() {
                trial.states[k][i] += step[c];
            }
        }
        Some(trial)
    }

    /// Changes of all parameters. What would go beyond its bounds or too far at once goes as far as it may, and the others are solved
    /// for again beside it: their step is one beside a change that is not made otherwise (a set of active bounds, Gill, Murray and
    /// Wright 1981, Practical Optimization, sect. 5.2).
    fn moved(
        &self,
        f: &Fitter,
        point: &Point,
        mut matrix: DMatrix<f64>,
        mut gradient: DVector<f64>,
    ) -> Option<DVector<f64>> {
        let size = gradient.len();
        let mut is_held = vec![false; size];
        loop {
            let step = scaled_solve(&matrix, &gradient)?;
            let allowed = self.allowed(f, point, &step);
            let beyond: Vec<usize> = (0..size)
                .filter(|&c| !is_held[c] && allowed[c] != step[c])
                .collect();
            if beyond.is_empty() {
                return Some(allowed);
            }
            for c in beyond {
                is_held[c] = true;
                gradient.axpy(-allowed[c], &matrix.column(c), 1.0);
                matrix.row_mut(c).fill(0.0);
                matrix.column_mut(c).fill(0.0);
                matrix[(c, c)] = 1.0;
                gradient[c] = allowed[c];
            }
        }
    }

    /// A step of all parameters within what each may do; none of what does not move.
    fn allowed(&self, f: &Fitter, point: &Point, step: &DVector<f64>) -> DVector<f64> {
        let h = f.hypothesis;
        let mut allowed = DVector::zeros(step.len());
        let within = |parameter: &Parameter, from: f64, step: f64| {
            let to = parameter.clamp(from + step);
            // The very step, where nothing bars it.
            if to == from + step { step } else { to - from }
        };
        for (c, parameter) in h.shared.iter().enumerate() {
            if f.moves(parameter) {
                allowed[c] = within(parameter, point.shared[c], limited(step[c], parameter));
            }
        }
        for (run, parameters) in h.per_run.iter().enumerate() {
            for (i, parameter) in parameters.iter().enumerate() {
                if parameter.prior_std > 0.0 {
                    let c = self.own_first[run] + i;
                    allowed[c] = within(parameter, point.per_run[run][i], step[c]);
                }
            }
        }
        allowed
    }
}

/// What the priors alone make of matrix and gradient of the parameters, and the first column of each run's own parameters.
pub(crate) fn priors(f: &Fitter, point: &Point) -> (DMatrix<f64>, DVector<f64>, Vec<usize>) {
    let h = f.hypothesis;
    let mut own_first = Vec::new();
    let mut size = h.shared.len();
    for run in &h.per_run {
        own_first.push(size);
        size += run.len();
    }
    let mut matrix = DMatrix::zeros(size, size);
    let mut gradient = DVector::zeros(size);
    let mut add = |c: usize, parameter: &Parameter, u: f64, moves: bool| {
        if moves && parameter.prior_std > 0.0 {
            let precision = f.precision(parameter);
            matrix[(c, c)] += precision;
            gradient[c] -= precision * (u - parameter.position(parameter.prior));
        } else {
            matrix[(c, c)] += 1.0;
        }
    };
    for (c, parameter) in h.shared.iter().enumerate() {
        add(c, parameter, point.shared[c], f.moves(parameter));
    }
    for (run, parameters) in h.per_run.iter().enumerate() {
        for (i, parameter) in parameters.iter().enumerate() {
            add(own_first[run] + i, parameter, point.per_run[run][i], true);
        }
    }
    (matrix, gradient, own_first)
}

/// At most one e-fold of a logarithmic parameter at a time.
fn limited(step: f64, parameter: &Parameter) -> f64 {
    match parameter.scale {
        Scale::Log => step.clamp(-0.7, 0.7),
        Scale::Linear => step,
    }
}
