//! One function beyond the standard: a motion with its derivatives by parameters and start values.
//!
//! A calibration sets the FMU's variables by `fmi2SetReal` and `fmi2SetInteger` as ever, and calls `stickslipTangents` in
//! place of steps. Masters that do not know the function never see it. Decision: docs/adr/0012-tangents.md.
//!
//! # Safety
//! As [`crate::exports`].
#![allow(non_snake_case, clippy::missing_safety_doc)]

use crate::guard::{slice, slice_mut, with_instance};
use crate::lifecycle::Function;
use crate::status::Fault;
use crate::tangent::{Answer, Direction, Request};
use crate::types::Component;
use std::ffi::c_int;

/// Writes the output with value reference `output` at `time_count` rising times in s, the first of which is the start of the
/// motion, to `values`, and its derivatives along each of the directions to `slopes`, direction after direction, each as long
/// as `values`. Direction i changes the `sizes[i]` next of the variables `references` by `changes` each.
///
/// Legal wherever `fmi2SetReal` is; the instance's own run is left alone. Where the motion is not differentiable (it touches a
/// transition) slopes are not finite.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslipTangents(
    component: Component,
    times: *const f64,
    time_count: usize,
    output: u32,
    sizes: *const usize,
    direction_count: usize,
    references: *const u32,
    changes: *const f64,
    change_count: usize,
    values: *mut f64,
    slopes: *mut f64,
) -> c_int {
    let function = Function::SetReal;
    // SAFETY: contract of this module: lists have the announced lengths.
    unsafe {
        with_instance(component, function, |instance| {
            let times = slice(times, time_count, function, "times")?;
            let sizes = slice(sizes, direction_count, function, "sizes")?;
            let mut references = slice(references, change_count, function, "references")?;
            let mut changes = slice(changes, change_count, function, "changes")?;
            let values = slice_mut(values, time_count, function, "values")?;
            let slopes = slice_mut(
                slopes,
                time_count.saturating_mul(direction_count),
                function,
                "slopes",
            )?;
            let wrong = |argument, value: f64, required: &str| Fault::BadArgument {
                function,
                argument,
                value,
                unit: "1",
                required: required.into(),
            };
            if sizes.iter().sum::<usize>() != change_count {
                let sum = sizes.iter().sum::<usize>() as f64;
                return Err(wrong("sizes", sum, "as many in all as there are changes"));
            }
            if time_count == 0 || !times.is_sorted() || !times.iter().all(|t| t.is_finite()) {
                return Err(wrong(
                    "times",
                    time_count as f64,
                    "at least one, finite and rising",
                ));
            }
            let directions: Vec<Direction> = sizes
                .iter()
                .map(|&size| {
                    let (own, rest) = references.split_at(size);
                    let (by, others) = changes.split_at(size);
                    (references, changes) = (rest, others);
                    (own, by)
                })
                .collect();
            let request = Request {
                times,
                output,
                directions,
            };
            instance.model.tangents(&request, Answer { values, slopes })
        })
    }
}
