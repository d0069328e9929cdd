//! A formula with the values of its parameters: on numbers, and on power series where it has them.

use super::quantity::VARIABLE;
use crate::effects::series::Series;
use crate::expression::Expression;
use crate::expression::series::SeriesProgram;
use crate::expression::spline::Spline;
use crate::real::Real;
use std::sync::Arc;

/// What the formulas of one effect share: names, values of the parameters and tables.
pub(super) struct Scope<'a> {
    /// Names of all that varies, then of the parameters; those that this formula may not use are empty.
    pub names: Vec<&'a str>,
    pub tables: Vec<&'a str>,
    pub constants: Arc<[Real]>,
    pub splines: Arc<[Spline]>,
}

/// A compiled formula.
#[derive(Debug)]
pub(super) struct Formula {
    expression: Expression,
    program: Option<SeriesProgram>,
    constants: Arc<[Real]>,
    splines: Arc<[Spline]>,
}

impl Formula {
    /// Compiles `text`.
    ///
    /// # Errors
    /// What is wrong with it, with the column.
    pub fn compile(text: &str, scope: &Scope) -> Result<Self, String> {
        let expression = Expression::compile(text, &scope.names, &scope.tables)
            .map_err(|problem| format!("'{text}', {problem}"))?;
        Ok(Self {
            program: expression.series(VARIABLE, &scope.constants, &scope.splines),
            constants: Arc::clone(&scope.constants),
            splines: Arc::clone(&scope.splines),
            expression,
        })
    }

    /// Whether what stands at this place of the names occurs.
    pub fn uses(&self, index: usize) -> bool {
        self.expression.uses(index)
    }

    /// Whether a table occurs.
    pub fn uses_table(&self, index: usize) -> bool {
        self.expression.uses_table(index)
    }

    /// Value at all that varies.
    pub fn value(&self, variable: &[Real; VARIABLE]) -> Real {
        self.expression
            .value(variable, &self.constants, &self.splines)
    }

    /// Whether it has a power series.
    pub fn has_series(&self) -> bool {
        self.program.is_some()
    }

    /// Number of series that its power series keeps.
    pub fn register_count(&self) -> usize {
        self.program
            .as_ref()
            .map_or(0, SeriesProgram::register_count)
    }

    /// Coefficient `k`, from those of all that varies.
    pub fn next(&self, k: usize, variable: &[Real; VARIABLE], registers: &mut [Series]) -> Real {
        let program = self.program.as_ref().expect("asked for where it has one");
        program.next(k, |i| variable[i], registers)
    }

    /// Normalised time, at most `theta`, up to which the series holds.
    pub fn until(&self, registers: &[Series], degree: usize, theta: f64) -> f64 {
        let program = self.program.as_ref().expect("asked for where it has one");
        program.until(registers, degree, theta)
    }
}
