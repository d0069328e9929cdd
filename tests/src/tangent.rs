//! `stickslipTangents`, called as a calibration calls it.

use crate::slave::{Slave, function};
use crate::variables::reference;
use std::ffi::{c_int, c_void};

/// The course of one input: begins of pieces in s, factors of its variable, their rates in 1/s.
pub struct Course<'a> {
    /// The input's name.
    pub input: &'a str,
    /// Begins of the pieces in s.
    pub begins: &'a [f64],
    /// Factors (1).
    pub factors: &'a [f64],
    /// Rates in 1/s.
    pub rates: &'a [f64],
}

type DrivenTangents = unsafe extern "C" fn(
    *mut c_void,
    *const f64,
    usize,
    u32,
    *const usize,
    usize,
    *const u32,
    *const f64,
    usize,
    *const u32,
    usize,
    *const f64,
    usize,
    *const f64,
    *const f64,
    *mut f64,
    *mut f64,
) -> c_int;

type Tangents = unsafe extern "C" fn(
    *mut c_void,
    *const f64,
    usize,
    u32,
    *const usize,
    usize,
    *const u32,
    *const f64,
    usize,
    *mut f64,
    *mut f64,
) -> c_int;

impl Slave {
    /// The output at each time and its derivatives along each direction (names and changes), or the status refusing it.
    ///
    /// # Errors
    /// The status returned.
    pub fn tangents(
        &self,
        times: &[f64],
        output: &str,
        directions: &[Vec<(&str, f64)>],
    ) -> Result<(Vec<f64>, Vec<Vec<f64>>), c_int> {
        let sizes: Vec<usize> = directions.iter().map(Vec::len).collect();
        let references: Vec<u32> = directions
            .iter()
            .flatten()
            .map(|(name, _)| reference(name))
            .collect();
        let changes: Vec<f64> = directions.iter().flatten().map(|d| d.1).collect();
        let mut values = vec![0.0; times.len()];
        let mut slopes = vec![0.0; times.len() * directions.len()];
        // SAFETY: the type is that of the export, the lists have the announced lengths.
        let status = unsafe {
            function::<Tangents>("stickslipTangents")(
                self.component,
                times.as_ptr(),
                times.len(),
                reference(output),
                sizes.as_ptr(),
                sizes.len(),
                references.as_ptr(),
                changes.as_ptr(),
                changes.len(),
                values.as_mut_ptr(),
                slopes.as_mut_ptr(),
            )
        };
        if status == crate::slave::OK {
            let slopes = slopes.chunks(times.len()).map(<[f64]>::to_vec).collect();
            Ok((values, slopes))
        } else {
            Err(status)
        }
    }

    /// The same beside an input that varies.
    ///
    /// # Errors
    /// The status returned.
    pub fn driven_tangents(
        &self,
        times: &[f64],
        output: &str,
        directions: &[(&str, f64)],
        course: &Course,
    ) -> Result<(Vec<f64>, Vec<Vec<f64>>), c_int> {
        let sizes = vec![1; directions.len()];
        let references: Vec<u32> = directions.iter().map(|d| reference(d.0)).collect();
        let changes: Vec<f64> = directions.iter().map(|d| d.1).collect();
        let mut values = vec![0.0; times.len()];
        let mut slopes = vec![0.0; times.len() * directions.len()];
        let input = reference(course.input);
        // SAFETY: the type is that of the export, the lists have the announced lengths.
        let status = unsafe {
            function::<DrivenTangents>("stickslipDrivenTangents")(
                self.component,
                times.as_ptr(),
                times.len(),
                reference(output),
                sizes.as_ptr(),
                sizes.len(),
                references.as_ptr(),
                changes.as_ptr(),
                changes.len(),
                &raw const input,
                1,
                course.begins.as_ptr(),
                course.begins.len(),
                course.factors.as_ptr(),
                course.rates.as_ptr(),
                values.as_mut_ptr(),
                slopes.as_mut_ptr(),
            )
        };
        if status == crate::slave::OK {
            let slopes = slopes.chunks(times.len()).map(<[f64]>::to_vec).collect();
            Ok((values, slopes))
        } else {
            Err(status)
        }
    }
}
