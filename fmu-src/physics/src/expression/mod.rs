//! Formulas that a user writes: compiled once into a short program, then evaluated without allocation.
//!
//! Numbers (`0.02`, `1e-3`), named quantities, `pi`, `+ - * / ^` (also `**`), comparisons
//! (`< <= > >=`, 1 if true, 0 if not), brackets and the functions of [`FUNCTIONS`], and `table(x, name)`, the curve of a
//! table at x. As on paper, `-x^2` is
//! `-(x^2)` and `2^3^2` is `2^(3^2)`.
//!
//! The evaluators on crates.io don't fit: of those with a usable licence, exmex 0.21 reads `-x^2` as
//! `(-x)^2` and does not know `1e-3`, fasteval and meval are no longer kept; evalexpr is AGPL.

mod parser;
pub mod series;
pub mod spline;

use crate::real::{Real, ZERO, value};
use series::SeriesProgram;
use spline::Spline;
use std::fmt;

/// Deepest nesting, and most values waiting on the stack.
const MAX_DEPTH: usize = 48;

/// Names and argument counts of the functions.
pub const FUNCTIONS: &[(&str, usize)] = &[
    ("sin", 1),
    ("cos", 1),
    ("tan", 1),
    ("asin", 1),
    ("acos", 1),
    ("atan", 1),
    ("atan2", 2),
    ("sinh", 1),
    ("cosh", 1),
    ("tanh", 1),
    ("exp", 1),
    ("ln", 1),
    ("log10", 1),
    ("sqrt", 1),
    ("abs", 1),
    ("sign", 1),
    ("floor", 1),
    ("min", 2),
    ("max", 2),
    ("if", 3),
];

#[derive(Debug, Clone, Copy)]
enum Op {
    Number(Real),
    Quantity(usize),
    Negate,
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    /// The curve of the table with this index.
    Table(usize),
    /// `if(condition, then, else)`: any condition but 0 is true.
    Choose,
    /// A function of one value, with its name.
    Unary(&'static str, fn(Real) -> Real),
    /// A function of two values or a comparison, with its name.
    Binary(&'static str, fn(Real, Real) -> Real),
}

/// An operation of a formula, for those who look at formulas without evaluating them; operations come after what they take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// A number as written.
    Number(f64),
    /// The quantity with this index.
    Quantity(usize),
    /// The curve of the table with this index at one value.
    Table(usize),
    /// A function of one value, or `-`.
    Unary(&'static str),
    /// A function of two values, an operation or a comparison.
    Binary(&'static str),
    /// `if(condition, then, else)`.
    Choose,
}

/// What is wrong with a formula, and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Column, counted from 1.
    pub column: usize,
    /// What is wrong there.
    pub text: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "column {}: {}", self.column, self.text)
    }
}

/// A compiled formula.
#[derive(Debug, Clone)]
pub struct Expression {
    program: Vec<Op>,
}

impl Expression {
    /// Compiles `text`, in which the names `quantities` may occur, and `table(x, name)` with the names `tables`.
    ///
    /// # Errors
    /// The first thing that can't be read, with its column.
    pub fn compile(text: &str, quantities: &[&str], tables: &[&str]) -> Result<Self, Problem> {
        parser::parse(text, quantities, tables).map(|program| Self { program })
    }

    /// Value for the quantities in the order in which they were named, first those that vary, then the constants.
    pub fn value(&self, variable: &[Real], constants: &[Real], tables: &[Spline]) -> Real {
        let mut stack = [ZERO; MAX_DEPTH];
        let mut top = 0;
        for op in &self.program {
            match *op {
                Op::Number(value) => {
                    stack[top] = value;
                    top += 1;
                }
                Op::Quantity(index) => {
                    stack[top] = match variable.get(index) {
                        Some(quantity) => *quantity,
                        None => constants[index - variable.len()],
                    };
                    top += 1;
                }
                Op::Table(index) => stack[top - 1] = tables[index].value(stack[top - 1]),
                Op::Negate | Op::Unary(..) => stack[top - 1] = op.unary(stack[top - 1]),
                Op::Choose => {
                    top -= 2;
                    let chosen = if value(stack[top - 1]) == 0.0 {
                        top + 1
                    } else {
                        top
                    };
                    stack[top - 1] = stack[chosen];
                }
                _ => {
                    top -= 1;
                    let (a, b) = (stack[top - 1], stack[top]);
                    stack[top - 1] = op.binary(a, b);
                }
            }
        }
        stack[0]
    }

    /// The formula on power series, where it has them: the first `variable` quantities vary, the others have the values
    /// `constants`.
    pub fn series(
        &self,
        variable: usize,
        constants: &[Real],
        tables: &[Spline],
    ) -> Option<SeriesProgram> {
        SeriesProgram::lower(&self.program, variable, constants, tables)
    }

    /// The operations in the order in which they are done.
    pub fn steps(&self) -> impl Iterator<Item = Step> + '_ {
        self.program.iter().map(|op| match *op {
            Op::Number(x) => Step::Number(value(x)),
            Op::Quantity(i) => Step::Quantity(i),
            Op::Table(i) => Step::Table(i),
            Op::Negate => Step::Unary("-"),
            Op::Unary(name, _) => Step::Unary(name),
            Op::Add => Step::Binary("+"),
            Op::Subtract => Step::Binary("-"),
            Op::Multiply => Step::Binary("*"),
            Op::Divide => Step::Binary("/"),
            Op::Power => Step::Binary("^"),
            Op::Binary(name, _) => Step::Binary(name),
            Op::Choose => Step::Choose,
        })
    }

    /// Whether the table with this index occurs.
    pub fn uses_table(&self, index: usize) -> bool {
        let is_it = |op: &Op| matches!(op, Op::Table(i) if *i == index);
        self.program.iter().any(is_it)
    }

    /// Whether the quantity with this index occurs.
    pub fn uses(&self, index: usize) -> bool {
        let is_it = |op: &Op| matches!(op, Op::Quantity(i) if *i == index);
        self.program.iter().any(is_it)
    }
}

impl Op {
    fn unary(self, a: Real) -> Real {
        match self {
            Self::Negate => -a,
            Self::Unary(_, f) => f(a),
            _ => unreachable!("not an operation on one value"),
        }
    }

    fn binary(self, a: Real, b: Real) -> Real {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            Self::Power if b == 2.0 => a * a,
            Self::Power => a.powf(b),
            Self::Binary(_, f) => f(a, b),
            _ => unreachable!("not an operation on two values"),
        }
    }

    /// Values taken from the stack.
    fn takes(self) -> usize {
        match self {
            Self::Number(_) | Self::Quantity(_) => 0,
            Self::Negate | Self::Unary(..) | Self::Table(_) => 1,
            Self::Choose => 3,
            _ => 2,
        }
    }
}

#[cfg(all(test, not(feature = "tangent")))]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn value(text: &str) -> f64 {
        let formula = Expression::compile(text, &["x", "w_dot"], &[])
            .unwrap_or_else(|e| panic!("{text}: {e}"));
        formula.value(&[3.0, -0.5], &[], &[])
    }

    #[test]
    fn val_formulas_mean_what_they_mean_on_paper() {
        // Source: arithmetic, evaluated by hand.
        for (text, expected) in [
            ("-x^2", -9.0),
            ("2^3^2", 512.0),
            ("2^-1", 0.5),
            ("2**3", 8.0),
            ("1-2-3", -4.0),
            ("6/2*3", 9.0),
            ("-2*-x", 6.0),
            ("1e-3*x + .5E+1", 5.003),
            ("(1 + x) * 2", 8.0),
            ("w_dot*abs(w_dot)", -0.25),
            ("min(1, max(-x, w_dot))", -0.5),
            ("if(x > 1, 2, 3) + if(x <= 1, 10, 20)", 22.0),
            ("sign(0) + sign(-x)", -1.0),
            ("atan2(1, 1) - pi/4", 0.0),
            ("sqrt(x*x + 16)", 5.0),
            ("exp(ln(x)) + log10(100)", 5.0),
            ("2*(x >= 3) - (x < 3)", 2.0),
        ] {
            assert_relative_eq!(value(text), expected, epsilon = 1e-15, max_relative = 1e-15);
        }
        assert!(!value("1/(x - 3)").is_finite());
        assert!(value("sqrt(-x)").is_nan());
    }

    #[test]
    fn what_cannot_be_read_is_named_with_its_column() {
        for (text, column, part) in [
            ("", 1, "ends"),
            ("1 +", 4, "ends"),
            ("(1 + x", 7, "')'"),
            ("1 + x)", 6, "')' without '('"),
            ("2 x", 3, "operator"),
            ("2 * vr", 5, "unknown name 'vr'; known are x, w_dot, pi"),
            ("log(x)", 1, "ln is the natural"),
            ("sin x", 5, "'('"),
            ("sin(x, 2)", 7, "takes 1"),
            ("max(x)", 6, "takes 2"),
            ("x + $", 5, "'$'"),
            ("1.2.3", 1, "not a number"),
            ("1e400", 1, "not a number"),
            ("x == 3", 3, "operator"),
            ("\u{e4} + x", 1, "unknown name"),
        ] {
            let problem = Expression::compile(text, &["x", "w_dot"], &[]).unwrap_err();
            assert_eq!(problem.column, column, "{text}: {problem}");
            assert!(problem.text.contains(part), "{text}: {problem}");
        }
    }

    #[test]
    fn nesting_has_a_limit_and_length_has_not() {
        for (open, close) in [("(", ")"), ("sin(", ")"), ("2^", ""), ("1 + (", ")")] {
            let text = open.repeat(100_000) + "x" + &close.repeat(100_000);
            assert!(Expression::compile(&text, &["x"], &[]).is_err());
        }
        let long = "x + ".repeat(10_000) + &"-".repeat(10_001) + "x";
        let formula = Expression::compile(&long, &["x"], &[]).unwrap();
        assert_relative_eq!(formula.value(&[1.0], &[], &[]), 9_999.0);
    }
}
