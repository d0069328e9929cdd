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

type OutputTangents = unsafe extern "C" fn(
    *mut c_void,
    *const f64,
    usize,
    *const u32,
    usize,
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

/// Values of an output, and its derivatives along each direction.
type Derivatives = (Vec<f64>, Vec<Vec<f64>>);

/// Directions as the exports take them, and where they write.
struct Lists {
    sizes: Vec<usize>,
    references: Vec<u32>,
    changes: Vec<f64>,
    values: Vec<f64>,
    slopes: Vec<f64>,
}

impl Lists {
    fn new(times: &[f64], directions: &[Vec<(&str, f64)>]) -> Self {
        let all = || directions.iter().flatten();
        Self {
            sizes: directions.iter().map(Vec::len).collect(),
            references: all().map(|(name, _)| reference(name)).collect(),
            changes: all().map(|d| d.1).collect(),
            values: vec![0.0; times.len()],
            slopes: vec![0.0; times.len() * directions.len()],
        }
    }

    fn answer(self, times: &[f64], status: c_int) -> Result<Derivatives, c_int> {
        if status != crate::slave::OK {
            return Err(status);
        }
        let slopes = self.slopes.chunks(times.len()).map(<[f64]>::to_vec);
        Ok((self.values, slopes.collect()))
    }
}

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
    ) -> Result<Derivatives, c_int> {
        let mut lists = Lists::new(times, directions);
        // SAFETY: the type is that of the export, the lists have the announced lengths.
        let status = unsafe {
            function::<Tangents>("stickslipTangents")(
                self.component,
                times.as_ptr(),
                times.len(),
                reference(output),
                lists.sizes.as_ptr(),
                lists.sizes.len(),
                lists.references.as_ptr(),
                lists.changes.as_ptr(),
                lists.changes.len(),
                lists.values.as_mut_ptr(),
                lists.slopes.as_mut_ptr(),
            )
        };
        lists.answer(times, status)
    }

    /// The same beside an input that varies.
    ///
    /// # Errors
    /// The status returned.
    pub fn driven_tangents(
        &self,
        times: &[f64],
        output: &str,
        directions: &[Vec<(&str, f64)>],
        course: &Course,
    ) -> Result<Derivatives, c_int> {
        let mut lists = Lists::new(times, directions);
        let input = reference(course.input);
        // SAFETY: the type is that of the export, the lists have the announced lengths.
        let status = unsafe {
            function::<DrivenTangents>("stickslipDrivenTangents")(
                self.component,
                times.as_ptr(),
                times.len(),
                reference(output),
                lists.sizes.as_ptr(),
                lists.sizes.len(),
                lists.references.as_ptr(),
                lists.changes.as_ptr(),
                lists.changes.len(),
                &raw const input,
                1,
                course.begins.as_ptr(),
                course.begins.len(),
                course.factors.as_ptr(),
                course.rates.as_ptr(),
                lists.values.as_mut_ptr(),
                lists.slopes.as_mut_ptr(),
            )
        };
        lists.answer(times, status)
    }

    /// Several outputs of one motion, each with its derivatives.
    ///
    /// # Errors
    /// The status returned.
    pub fn output_tangents(
        &self,
        times: &[f64],
        outputs: &[&str],
        directions: &[Vec<(&str, f64)>],
    ) -> Result<Vec<Derivatives>, c_int> {
        let mut lists = Lists::new(times, directions);
        let references: Vec<u32> = outputs.iter().map(|name| reference(name)).collect();
        let count = times.len() * outputs.len();
        lists.values.resize(count, 0.0);
        lists.slopes.resize(count * directions.len(), 0.0);
        let none: *const f64 = std::ptr::null();
        // SAFETY: the type is that of the export, the lists have the announced lengths.
        let status = unsafe {
            function::<OutputTangents>("stickslipOutputTangents")(
                self.component,
                times.as_ptr(),
                times.len(),
                references.as_ptr(),
                references.len(),
                lists.sizes.as_ptr(),
                lists.sizes.len(),
                lists.references.as_ptr(),
                lists.changes.as_ptr(),
                lists.changes.len(),
                std::ptr::null(),
                0,
                none,
                0,
                none,
                none,
                lists.values.as_mut_ptr(),
                lists.slopes.as_mut_ptr(),
            )
        };
        if status != crate::slave::OK {
            return Err(status);
        }
        let of_output = |i: usize| {
            let part = |list: &[f64]| list[i * times.len()..(i + 1) * times.len()].to_vec();
            (
                part(&lists.values),
                lists.slopes.chunks(count).map(part).collect(),
            )
        };
        Ok((0..outputs.len()).map(of_output).collect())
    }
}
