//! A formula on power series: the same operations once more, coefficient by coefficient.
//!
//! Each operation becomes one or a few steps with a series each. An analytic function `f` of a series u has the
//! coefficients `f_k = sum_i i u_i g_(k-i) / k` with `g = f'(u)`, itself a series of the same program (Moore 1966, ch. 11):
//! `tanh` has `g = 1 - tanh^2`, `atan` has `g = 1/(1 + u^2)`. Comparisons, `abs`, `min` and the like are taken in the
//! branch that holds at the start; [`SeriesProgram::until`] says how far it holds.

mod lowering;

use super::Op;
use super::spline::Spline;
use crate::integrate::series::{Series, all_or_nothing, chained, product, quotient, sign_until};
use crate::real::{Real, ZERO, real, value};

/// Most steps of a program; longer formulas are integrated by their values.
const MAX_STEPS: usize = 128;

/// A value in a program: a constant, or the series of a step.
#[derive(Debug, Clone, Copy)]
enum Operand {
    Constant(Real),
    Step(usize),
}

use Operand::{Constant, Step as Of};
use lowering::Lowering;

/// One series, from those of other steps.
#[derive(Debug, Clone, Copy)]
enum Step {
    Quantity(usize),
    Sum(Operand, Operand),
    Difference(Operand, Operand),
    Product(Operand, Operand),
    Quotient(Operand, usize),
    /// A series to a constant power.
    Power(usize, Real),
    /// `k u_k`, what integrals are made of.
    Slope(usize),
    /// A function of one value, by its slope and its derivative.
    Integral {
        start: fn(Real) -> Real,
        argument: usize,
        slope: usize,
        derivative: usize,
    },
    /// Angle of the point (x, y), from `k angle_k`.
    Angle {
        y: Operand,
        x: Operand,
        rate: usize,
    },
    /// A constant while the series keeps its sign: the function of its first coefficient.
    Piecewise(usize, fn(Real) -> Real),
    /// The largest whole number below.
    Floor(usize),
    /// The first of two where a condition is not zero.
    Choose(Operand, Operand, Operand),
    /// Distance from the left end of the piece of a table's curve.
    Distance {
        table: usize,
        argument: usize,
    },
    /// `c_p + d inner`, or `c_p + d c_(p+1)` without an inner one: one step of Horner's rule on a piece.
    Horner {
        table: usize,
        distance: usize,
        argument: usize,
        inner: Option<usize>,
        power: usize,
    },
}

/// A compiled formula on power series, with the values of its constants.
#[derive(Debug, Clone)]
pub struct SeriesProgram {
    steps: Vec<Step>,
    tables: Vec<Spline>,
    result: Operand,
}

impl SeriesProgram {
    /// Lowers a program in which the quantities from `variable` on are the given constants; `None` where it uses what has no
    /// series or is too long.
    pub(super) fn lower(
        program: &[Op],
        variable: usize,
        constants: &[Real],
        tables: &[Spline],
    ) -> Option<Self> {
        let mut lowering = Lowering { steps: Vec::new() };
        let mut quantities = vec![None; variable];
        let mut stack: Vec<Operand> = Vec::new();
        for op in program {
            let out = match *op {
                Op::Number(x) => Constant(x),
                Op::Quantity(i) if i < variable => {
                    *quantities[i].get_or_insert_with(|| lowering.push(Step::Quantity(i)))
                }
                Op::Quantity(i) => Constant(constants[i - variable]),
                Op::Choose => {
                    let (b, a, c) = (stack.pop()?, stack.pop()?, stack.pop()?);
                    match c {
                        Constant(c) if value(c) == 0.0 => b,
                        Constant(_) => a,
                        Of(_) => lowering.push(Step::Choose(c, a, b)),
                    }
                }
                Op::Table(table) => match stack.pop()? {
                    Constant(c) => Constant(tables[table].value(c)),
                    Of(u) => lowering.table(table, u),
                },
                Op::Negate | Op::Unary(..) => {
                    let u = stack.pop()?;
                    match u {
                        Constant(c) => Constant(op.unary(c)),
                        Of(u) => lowering.unary(*op, u)?,
                    }
                }
                _ => {
                    let (b, a) = (stack.pop()?, stack.pop()?);
                    match (a, b) {
                        (Constant(a), Constant(b)) => Constant(op.binary(a, b)),
                        _ => lowering.binary(*op, a, b)?,
                    }
                }
            };
            stack.push(out);
        }
        let fits = lowering.steps.len() <= MAX_STEPS;
        fits.then_some(Self {
            steps: lowering.steps,
            tables: tables.to_vec(),
            result: stack.pop()?,
        })
    }

    /// Number of series that it keeps.
    pub fn register_count(&self) -> usize {
        self.steps.len()
    }

    /// Coefficient `k` of the formula's value; `quantity` gives those of the quantities. To be asked for k = 0, 1, 2, ...
    pub fn next(
        &self,
        k: usize,
        quantity: impl Fn(usize) -> Real,
        registers: &mut [Series],
    ) -> Real {
        let at = |operand: Operand, registers: &[Series]| match operand {
            Of(i) => registers[i][k],
            Constant(c) if k == 0 => c,
            Constant(_) => ZERO,
        };
        for (i, step) in self.steps.iter().enumerate() {
            let r: &[Series] = registers;
            let coefficient = match *step {
                Step::Quantity(q) => quantity(q),
                Step::Sum(a, b) => at(a, r) + at(b, r),
                Step::Difference(a, b) => at(a, r) - at(b, r),
                Step::Product(Of(a), Of(b)) => product(&r[a], &r[b], k),
                Step::Product(Constant(a), Of(b)) | Step::Product(Of(b), Constant(a)) => {
                    a * r[b][k]
                }
                Step::Product(a, b) => at(a, r) * at(b, r),
                Step::Quotient(a, b) => quotient(at(a, r), &r[b], &r[i], k),
                Step::Power(u, exponent) => power(&r[u], &r[i], exponent, k),
                Step::Slope(u) => r[u][k] * k as f64,
                Step::Integral {
                    start,
                    argument,
                    slope,
                    derivative,
                } => match k {
                    0 => start(r[argument][0]),
                    _ => chained(&r[derivative], &r[slope], k),
                },
                Step::Angle { y, x, .. } if k == 0 => at(y, r).atan2(at(x, r)),
                Step::Angle { rate, .. } => r[rate][k] / k as f64,
                Step::Piecewise(u, f) if k == 0 => f(r[u][0]),
                Step::Floor(u) if k == 0 => r[u][0].floor(),
                Step::Piecewise(..) | Step::Floor(_) => ZERO,
                Step::Choose(c, a, b) => at(self.chosen(c, a, b, r), r),
                Step::Distance { table, argument } if k == 0 => {
                    let spline = &self.tables[table];
                    r[argument][0] - spline.origin(spline.piece(value(r[argument][0])))
                }
                Step::Distance { argument, .. } => r[argument][k],
                Step::Horner {
                    table,
                    distance,
                    argument,
                    inner,
                    power,
                } => {
                    let spline = &self.tables[table];
                    let c = spline.coefficients(spline.piece(value(r[argument][0])));
                    let above = match inner {
                        Some(inner) => product(&r[inner], &r[distance], k),
                        None => c[power + 1] * r[distance][k],
                    };
                    if k == 0 { c[power] + above } else { above }
                }
            };
            registers[i][k] = coefficient;
        }
        at(self.result, registers)
    }

    fn chosen(&self, c: Operand, a: Operand, b: Operand, registers: &[Series]) -> Operand {
        let condition = match c {
            Of(c) => registers[c][0],
            Constant(c) => c,
        };
        if value(condition) == 0.0 { b } else { a }
    }

    /// Normalised time, at most `theta`, up to which the branches taken hold, as far as `degree` tells; 0 where the value is not
    /// finite or ends.
    pub fn until(&self, registers: &[Series], degree: usize, theta: f64) -> f64 {
        let Of(result) = self.result else {
            return theta;
        };
        if !registers[result][..=degree].iter().all(|c| c.is_finite()) {
            return 0.0;
        }
        let mut end = theta;
        let sign_of = |f: &Series| sign_until(f, degree, theta);
        // A branch that is not taken may be anything. What a step needs stands before it, but for the derivatives of
        // functions by themselves, which have no branches.
        let mut is_live = [false; MAX_STEPS];
        is_live[result] = true;
        for (i, step) in self.steps.iter().enumerate().rev() {
            if !is_live[i] {
                continue;
            }
            let mut needs = |operand: Operand| {
                if let Of(j) = operand {
                    is_live[j] = true;
                }
            };
            match *step {
                Step::Quantity(_) => {}
                Step::Sum(a, b) | Step::Difference(a, b) | Step::Product(a, b) => {
                    needs(a);
                    needs(b);
                }
                Step::Quotient(a, b) => {
                    needs(a);
                    needs(Of(b));
                }
                Step::Slope(u) => needs(Of(u)),
                Step::Power(u, _) => {
                    needs(Of(u));
                    if !(value(registers[u][0]) > 0.0) {
                        return 0.0;
                    }
                    end = end.min(all_or_nothing(&registers[u], degree, theta));
                }
                Step::Integral {
                    argument,
                    derivative,
                    ..
                } => {
                    needs(Of(argument));
                    if derivative < i {
                        needs(Of(derivative));
                    }
                }
                Step::Angle { y, x, rate } => {
                    needs(y);
                    needs(x);
                    needs(Of(rate));
                    // It jumps where y changes its sign left of the origin.
                    let keeps = |operand: Operand| match operand {
                        Of(j) => sign_of(&registers[j]),
                        Constant(c) if value(c) != 0.0 => theta,
                        Constant(_) => 0.0,
                    };
                    let is_right = match x {
                        Of(j) => value(registers[j][0]) > 0.0,
                        Constant(c) => value(c) > 0.0,
                    };
                    let of_x = if is_right { keeps(x) } else { 0.0 };
                    end = end.min(keeps(y).max(of_x));
                }
                Step::Piecewise(u, _) => {
                    needs(Of(u));
                    end = end.min(sign_of(&registers[u]));
                }
                Step::Floor(u) => {
                    needs(Of(u));
                    let mut above = registers[u];
                    above[0] -= above[0].floor();
                    let mut below = above;
                    below.iter_mut().for_each(|c| *c = -*c);
                    below[0] += real(1.0);
                    end = end.min(sign_of(&above)).min(sign_of(&below));
                }
                Step::Choose(c, a, b) => {
                    needs(c);
                    needs(self.chosen(c, a, b, registers));
                    if let Of(c) = c
                        && !self.is_constant(c)
                    {
                        end = end.min(sign_of(&registers[c]));
                    }
                }
                Step::Distance { argument, .. } => needs(Of(argument)),
                Step::Horner {
                    table,
                    distance,
                    argument,
                    inner,
                    ..
                } => {
                    needs(Of(distance));
                    if let Some(inner) = inner {
                        needs(Of(inner));
                        continue;
                    }
                    let spline = &self.tables[table];
                    let [left, right] = spline.ends(spline.piece(value(registers[argument][0])));
                    let mut from = registers[argument];
                    from[0] -= left.unwrap_or(f64::NEG_INFINITY).max(-f64::MAX);
                    let mut to = registers[argument].map(|c| -c);
                    to[0] += right.unwrap_or(f64::INFINITY).min(f64::MAX);
                    if !(value(from[0]) > 0.0 && value(to[0]) > 0.0) {
                        return 0.0;
                    }
                    end = end.min(sign_of(&from)).min(sign_of(&to));
                }
            }
        }
        end
    }

    /// Whether a step is constant as long as its own condition holds.
    fn is_constant(&self, step: usize) -> bool {
        matches!(self.steps[step], Step::Piecewise(..) | Step::Floor(_))
    }
}

/// Coefficient `k` of `u^p`, of which the lower ones are known: `u y' = p u' y` (Moore 1966, ch. 11).
fn power(u: &Series, y: &Series, p: Real, k: usize) -> Real {
    if k == 0 {
        return u[0].powf(p);
    }
    let mut sum = ZERO;
    for i in 1..=k {
        sum += (p * i as f64 - (k - i) as f64) * u[i] * y[k - i];
    }
    sum / (u[0] * k as f64)
}

#[cfg(all(test, not(feature = "tangent")))]
mod tests {
    use super::super::Expression;
    use super::*;
    use crate::integrate::MAX_DEGREE;

    fn table() -> Spline {
        Spline::new(&[-1.0, 0.2, 0.4, 1.5], &[0.3, -0.2, 0.9, 1.0])
    }

    /// Value at theta by the series of a formula of x = 0.3 + 0.8 theta - 0.1 theta^2, with its branches checked; `None` where
    /// they do not hold.
    fn by_series(text: &str, degree: usize, theta: f64) -> Option<f64> {
        let formula = Expression::compile(text, &["x", "a"], &["g"]).unwrap();
        let program = formula.series(1, &[0.7], &[table()])?;
        let mut registers = vec![[ZERO; MAX_DEGREE + 1]; program.register_count()];
        let x = [0.3, 0.8, -0.1];
        let mut value = 0.0;
        for k in 0..=degree {
            let quantity = |_| x.get(k).copied().unwrap_or(0.0);
            value += program.next(k, quantity, &mut registers) * theta.powi(k as i32);
        }
        (program.until(&registers, degree, theta) == theta).then_some(value)
    }

    #[test]
    fn val_series_of_functions_give_their_values() {
        // Source: the formula evaluated at the place itself.
        let theta = 0.05;
        let x = 0.3 + 0.8 * theta - 0.1 * theta * theta;
        for text in [
            "x",
            "a",
            "1 + a*x - x/a + a/x",
            "sin(x) + cos(2*x)",
            "tan(x)",
            "asin(x) + acos(a*x)",
            "atan(3*x)",
            "sinh(x) - cosh(x)",
            "tanh(x/0.2)",
            "exp(-x/a)",
            "ln(x) + log10(x)",
            "sqrt(x)",
            "x^2 + x^3 - x^5 + x^-2 + x^1.3 + x^a + a^x + x^x",
            "(x - 1)^3 + (x - 2)^-1",
            "x^0 + a^2",
            "abs(x - 2) + sign(x - 2)*x",
            "floor(11*x) + x",
            "min(x, 1) + max(x, 1)*x",
            "atan2(x, 1 + x^2) + atan2(x - 2, x - 5)*x",
            "atan2(2, x - 0.31) + atan2(x - 5, -a)",
            "atan2(x - 0.31, 3)",
            "if(x > 0.2, x^2, ln(x - 5))",
            "if(x <= 0.2, sqrt(x - 5), a*x)",
            "(x >= 0.1)*x + (x < 0.1)",
            "if(x, 2*x, 1)",
            "table(x, g)*x + table(a, g)",
            "table(x - 5, g) + table(2*x + 9, g)",
        ] {
            let formula = Expression::compile(text, &["x", "a"], &["g"]).unwrap();
            let expected = formula.value(&[x], &[0.7], &[table()]);
            let found = by_series(text, 16, theta).unwrap_or_else(|| panic!("{text} has none"));
            assert!(
                (found - expected).abs() < 1e-12 * expected.abs().max(1.0),
                "{text}: {found} {expected}"
            );
        }
    }

    #[test]
    fn a_branch_that_ends_within_the_step_does_not_hold() {
        // x passes 0.31 on the way to 0.34.
        for text in [
            "abs(x - 0.31)",
            "if(x > 0.31, x, 2)",
            "max(x, 0.31)",
            "floor(x/0.31)",
            "sqrt(0.31 - x)",
            "if(x - 0.31, 1, 2)*x",
            "table(x + 0.09, g)",
            "atan2(x - 0.31, -1)",
            "atan2(0.31 - x, x - 0.315)",
        ] {
            assert!(by_series(text, 8, 0.05).is_none(), "{text}");
            assert!(by_series(text, 8, 0.005).is_some(), "{text}");
        }
        // The branch that is not taken does not count.
        assert!(by_series("if(x < 1, x, abs(x - 0.31))", 8, 0.05).is_some());
    }
}
