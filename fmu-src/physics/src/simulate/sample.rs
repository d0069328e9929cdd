//! An output that is linear in the state, at many times of a run: one polynomial for each piece of motion.

use super::Simulation;
use crate::contact::ContactMode;
use crate::error::PhysicsError;
use crate::integrate::linear::LinearOutput;
use crate::integrate::series::Series;
use crate::integrate::{MAX_DEGREE, State};
use crate::real::{Real, ZERO, polynomial, real};

impl Simulation {
    /// Advances through the rising `times` in s and writes `offset + row x` at each.
    ///
    /// # Errors
    /// As [`Simulation::advance_to`]; what was reached before is in `out`.
    pub fn sample(
        &mut self,
        times: &[f64],
        row: &State,
        offset: Real,
        out: &mut Vec<Real>,
    ) -> Result<(), PhysicsError> {
        let mut in_stick: Option<LinearOutput> = None;
        let (mut c, mut of) = ([ZERO; MAX_DEGREE + 1], None);
        for &time in times {
            let t = real(time);
            self.pass_to(t)?;
            let start = self.segment.start;
            if of != Some(start) {
                c = self.output_polynomial(row, offset, &mut in_stick);
                of = Some(start);
            }
            let theta = self.segment.theta(t);
            out.push(polynomial(c[..=self.segment.degree].iter(), theta));
        }
        Ok(())
    }

    /// The polynomial of `offset + row x` over the present piece.
    fn output_polynomial(
        &mut self,
        row: &State,
        offset: Real,
        in_stick: &mut Option<LinearOutput>,
    ) -> Series {
        if self.segment_is_ready || self.segment_mode != ContactMode::Stuck {
            self.ready_segment();
            return self.segment.combine(row, &[offset]);
        }
        let system = self.stick_system.as_ref().expect("stick is linear");
        let output = in_stick.get_or_insert_with(|| system.linear.output(row, offset));
        output.polynomial(&self.segment.coefficients[0])
    }

    /// The same for what the sensor gives, in m.
    ///
    /// # Errors
    /// As [`Simulation::sample`].
    pub fn sample_measured(
        &mut self,
        times: &[f64],
        out: &mut Vec<Real>,
    ) -> Result<(), PhysicsError> {
        if let Some((row, offset)) = self.model.measured_row() {
            return self.sample(times, &row, offset, out);
        }
        for &time in times {
            self.advance_to(real(time))?;
            out.push(self.measured_displacement());
        }
        Ok(())
    }
}
