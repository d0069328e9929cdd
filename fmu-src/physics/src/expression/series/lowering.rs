//! How the operations of a formula become steps.

use super::Operand::{Constant, Step as Of};
use super::{Operand, Step};
use crate::expression::Op;
use crate::real::{Real, ZERO, real, value};

/// Largest whole exponent that is worked out by products.
const MAX_WHOLE_EXPONENT: f64 = 16.0;

fn is_positive(x: Real) -> Real {
    real(f64::from(u8::from(value(x) > 0.0)))
}

fn is_not_negative(x: Real) -> Real {
    real(f64::from(u8::from(value(x) >= 0.0)))
}

/// A function of one value.
type Function = fn(Real) -> Real;

/// Turns operations into steps.
pub(super) struct Lowering {
    pub(super) steps: Vec<Step>,
}

impl Lowering {
    pub(super) fn push(&mut self, step: Step) -> Operand {
        self.steps.push(step);
        Of(self.steps.len() - 1)
    }

    /// The same, for a step that others refer to.
    fn place(&mut self, step: Step) -> usize {
        self.steps.push(step);
        self.steps.len() - 1
    }

    pub(super) fn unary(&mut self, op: Op, u: usize) -> Option<Operand> {
        let one = Constant(real(1.0));
        Some(match op {
            Op::Negate => self.push(Step::Difference(Constant(ZERO), Of(u))),
            Op::Unary(name, f) => match name {
                "abs" => {
                    let sign = self.push(Step::Piecewise(u, crate::expression::parser::sign));
                    self.push(Step::Product(sign, Of(u)))
                }
                "sign" => self.push(Step::Piecewise(u, f)),
                "floor" => self.push(Step::Floor(u)),
                "sqrt" => self.push(Step::Power(u, real(0.5))),
                "exp" => {
                    let slope = self.place(Step::Slope(u));
                    // Its own derivative.
                    let derivative = self.steps.len();
                    self.integral(f, u, slope, derivative)
                }
                "tanh" | "tan" => {
                    let slope = self.place(Step::Slope(u));
                    let y = self.steps.len();
                    self.integral(f, u, slope, y + 2);
                    let square = self.push(Step::Product(Of(y), Of(y)));
                    self.push(match name {
                        "tanh" => Step::Difference(one, square),
                        _ => Step::Sum(one, square),
                    });
                    Of(y)
                }
                "sin" | "cos" | "sinh" | "cosh" => {
                    let slope = self.place(Step::Slope(u));
                    let first = self.steps.len();
                    let (sine, cosine): (Function, Function) = if name.ends_with('h') {
                        (Real::sinh, Real::cosh)
                    } else {
                        (Real::sin, Real::cos)
                    };
                    self.integral(sine, u, slope, first + 1);
                    if name.ends_with('h') {
                        self.integral(cosine, u, slope, first);
                    } else {
                        self.integral(cosine, u, slope, first + 2);
                        self.push(Step::Difference(Constant(ZERO), Of(first)));
                    }
                    Of(first + usize::from(name.starts_with("cos")))
                }
                "ln" | "log10" => {
                    let slope = self.place(Step::Slope(u));
                    let scale = match name {
                        "ln" => real(1.0),
                        _ => real(std::f64::consts::LOG10_E),
                    };
                    let derivative = self.place(Step::Quotient(Constant(scale), u));
                    self.integral(f, u, slope, derivative)
                }
                "atan" => {
                    let slope = self.place(Step::Slope(u));
                    let square = self.push(Step::Product(Of(u), Of(u)));
                    let below = self.place(Step::Sum(one, square));
                    let derivative = self.place(Step::Quotient(one, below));
                    self.integral(f, u, slope, derivative)
                }
                "asin" | "acos" => {
                    let slope = self.place(Step::Slope(u));
                    let square = self.push(Step::Product(Of(u), Of(u)));
                    let below = self.place(Step::Difference(one, square));
                    let root = self.place(Step::Power(below, real(-0.5)));
                    let derivative = match name {
                        "asin" => root,
                        _ => self.place(Step::Difference(Constant(ZERO), Of(root))),
                    };
                    self.integral(f, u, slope, derivative)
                }
                _ => return None,
            },
            _ => return None,
        })
    }

    /// A table's curve: Horner's rule on the piece in which the argument lies.
    pub(super) fn table(&mut self, table: usize, argument: usize) -> Operand {
        let distance = self.place(Step::Distance { table, argument });
        let mut inner = None;
        for power in [2, 1, 0] {
            inner = Some(self.place(Step::Horner {
                table,
                distance,
                argument,
                inner,
                power,
            }));
        }
        Of(inner.expect("three steps"))
    }

    fn integral(
        &mut self,
        start: Function,
        argument: usize,
        slope: usize,
        derivative: usize,
    ) -> Operand {
        self.push(Step::Integral {
            start,
            argument,
            slope,
            derivative,
        })
    }

    pub(super) fn binary(&mut self, op: Op, a: Operand, b: Operand) -> Option<Operand> {
        let difference = |lowering: &mut Self, a, b| lowering.place(Step::Difference(a, b));
        Some(match op {
            Op::Add => self.push(Step::Sum(a, b)),
            Op::Subtract => self.push(Step::Difference(a, b)),
            Op::Multiply => self.push(Step::Product(a, b)),
            Op::Divide => match b {
                Constant(c) => self.push(Step::Product(a, Constant(real(1.0) / c))),
                Of(b) => self.push(Step::Quotient(a, b)),
            },
            Op::Power => self.power(a, b)?,
            Op::Binary(name, _) => match name {
                "min" | "max" => {
                    let d = match name {
                        "min" => difference(self, b, a),
                        _ => difference(self, a, b),
                    };
                    let first = self.push(Step::Piecewise(d, is_positive));
                    self.push(Step::Choose(first, a, b))
                }
                "<" | "<=" | ">" | ">=" => {
                    let d = match name.starts_with('<') {
                        true => difference(self, b, a),
                        false => difference(self, a, b),
                    };
                    let truth = match name.len() {
                        1 => is_positive,
                        _ => is_not_negative,
                    };
                    self.push(Step::Piecewise(d, truth))
                }
                "atan2" => self.angle(a, b),
                _ => return None,
            },
            _ => return None,
        })
    }

    /// The angle of the point (x, y), by `(x^2 + y^2) angle' = x y' - y x'`.
    fn angle(&mut self, y: Operand, x: Operand) -> Operand {
        let mut slope = |u| match u {
            Of(u) => self.push(Step::Slope(u)),
            Constant(_) => Constant(ZERO),
        };
        let (y_slope, x_slope) = (slope(y), slope(x));
        let mut product = |a, b| self.push(Step::Product(a, b));
        let (forward, back) = (product(x, y_slope), product(y, x_slope));
        let (x_square, y_square) = (product(x, x), product(y, y));
        let turned = self.push(Step::Difference(forward, back));
        let square = self.place(Step::Sum(x_square, y_square));
        let rate = self.place(Step::Quotient(turned, square));
        self.push(Step::Angle { y, x, rate })
    }

    fn power(&mut self, base: Operand, exponent: Operand) -> Option<Operand> {
        match (base, exponent) {
            (Of(u), Constant(p)) => {
                let whole = value(p).abs();
                // Equality looks at derivatives too: an exponent that is fitted is no whole number.
                let is_whole = p == real(value(p).round()) && whole <= MAX_WHOLE_EXPONENT;
                if !is_whole {
                    return Some(self.push(Step::Power(u, p)));
                }
                let positive = self.whole_power(u, whole as u32);
                Some(match positive {
                    Of(of) if value(p) < 0.0 => self.push(Step::Quotient(Constant(real(1.0)), of)),
                    _ => positive,
                })
            }
            // A variable exponent: exp(p ln u).
            (base, exponent) => {
                let logarithm = match base {
                    Constant(c) => Constant(c.ln()),
                    Of(u) => self.unary(Op::Unary("ln", Real::ln), u)?,
                };
                let Of(product) = self.push(Step::Product(logarithm, exponent)) else {
                    return None;
                };
                self.unary(Op::Unary("exp", Real::exp), product)
            }
        }
    }

    /// By squares (Knuth, The Art of Computer Programming, vol. 2, sect. 4.6.3).
    fn whole_power(&mut self, u: usize, exponent: u32) -> Operand {
        let (mut left, mut square) = (exponent, Of(u));
        let mut out = Constant(real(1.0));
        while left > 0 {
            if left % 2 == 1 {
                out = match out {
                    Constant(_) => square,
                    of => self.push(Step::Product(of, square)),
                };
            }
            left /= 2;
            if left > 0 {
                square = self.push(Step::Product(square, square));
            }
        }
        out
    }
}
