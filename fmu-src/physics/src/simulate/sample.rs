//! Outputs that are linear in the state, at many times of a run: one polynomial each for each piece of motion.

use super::Simulation;
use crate::contact::ContactMode;
use crate::error::PhysicsError;
use crate::integrate::linear::LinearOutput;
use crate::integrate::series::Series;
use crate::integrate::{MAX_DEGREE, State};
use crate::real::{Real, ZERO, polynomial, real};

/// An output `offset + row x`.
pub type Row = (State, Real);

impl Simulation {
    /// Advances through the rising `times` in s and writes the outputs `rows` at each, time after time.
    ///
    /// # Errors
    /// As [`Simulation::advance_to`]; what was reached before is in `out`.
    pub fn sample(
        &mut self,
        times: &[f64],
        rows: &[Row],
        out: &mut Vec<Real>,
    ) -> Result<(), PhysicsError> {
        let mut in_stick: Vec<Option<LinearOutput>> = rows.iter().map(|_| None).collect();
        let mut polynomials = vec![[ZERO; MAX_DEGREE + 1]; rows.len()];
        let mut of = None;
        for &time in times {
            let t = real(time);
            self.pass_to(t)?;
            let start = self.segment.start;
            if of != Some(start) {
                for ((c, row), in_stick) in polynomials.iter_mut().zip(rows).zip(&mut in_stick) {
                    *c = self.output_polynomial(row, in_stick);
                }
                of = Some(start);
            }
            let theta = self.segment.theta(t);
            let degree = self.segment.degree;
            out.extend(
                polynomials
                    .iter()
                    .map(|c| polynomial(c[..=degree].iter(), theta)),
            );
        }
        Ok(())
    }

    /// The polynomial of an output over the present piece.
    fn output_polynomial(
        &mut self,
        (row, offset): &Row,
        in_stick: &mut Option<LinearOutput>,
    ) -> Series {
        if self.segment_is_ready || self.segment_mode != ContactMode::Stuck {
            self.ready_segment();
            return self.segment.combine(row, &[*offset]);
        }
        let system = self.stick_system.as_ref().expect("stick is linear");
        let output = in_stick.get_or_insert_with(|| system.linear.output(row, *offset));
        output.polynomial(&self.segment.coefficients[0])
    }
}
