//! Functions beyond the standard: a motion with its derivatives by parameters and start values, the same for a motion that
//! inputs drive, and the same for several outputs of it.
//!
//! A calibration sets the FMU's variables by `fmi2SetReal` and `fmi2SetInteger` as ever, and calls `stickslipTangents` in
//! place of steps. Masters that do not know the functions never see them. Decision: docs/adr/0012-tangents.md.
//!
//! # Safety
//! As in [`super`].
#![allow(non_snake_case, clippy::missing_safety_doc)]

use crate::guard::{slice, slice_mut, with_instance};
use crate::lifecycle::Function;
use crate::status::Fault;
use crate::tangent::{Answer, Course, Direction, Request};
use crate::types::Component;
use std::ffi::c_int;

/// Writes the output with value reference `output` (an output of the motion, or a modal displacement or velocity) at `time_count` rising times in s, the first of which is the start of the
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
    // SAFETY: contract of this module; empty lists are not looked at.
    unsafe {
        stickslipDrivenTangents(
            component,
            times,
            time_count,
            output,
            sizes,
            direction_count,
            references,
            changes,
            change_count,
            std::ptr::null(),
            0,
            std::ptr::null(),
            0,
            std::ptr::null(),
            std::ptr::null(),
            values,
            slopes,
        )
    }
}

/// [`stickslipTangents`] with inputs that vary: `inputs` are the value references of `input_count` of them, and from
/// `begins[k]` in s to the next begin input i acts as `x (a + b (t - begins[k]))`, with x the value of its variable,
/// `a = factors[k input_count + i]` (1) and `b = rates[k input_count + i]` (1/s). The first piece begins where the motion
/// does or before. Inputs that are not named are constant.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslipDrivenTangents(
    component: Component,
    times: *const f64,
    time_count: usize,
    output: u32,
    sizes: *const usize,
    direction_count: usize,
    references: *const u32,
    changes: *const f64,
    change_count: usize,
    inputs: *const u32,
    input_count: usize,
    begins: *const f64,
    piece_count: usize,
    factors: *const f64,
    rates: *const f64,
    values: *mut f64,
    slopes: *mut f64,
) -> c_int {
    // SAFETY: contract of this module.
    unsafe {
        stickslipOutputTangents(
            component,
            times,
            time_count,
            &raw const output,
            1,
            sizes,
            direction_count,
            references,
            changes,
            change_count,
            inputs,
            input_count,
            begins,
            piece_count,
            factors,
            rates,
            values,
            slopes,
        )
    }
}

/// [`stickslipDrivenTangents`] of the `output_count` outputs with value references `outputs`, at least one, of one motion:
/// `values` holds output after output, each as long as `times`, and `slopes` direction after direction, each as long as
/// `values`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslipOutputTangents(
    component: Component,
    times: *const f64,
    time_count: usize,
    outputs: *const u32,
    output_count: usize,
    sizes: *const usize,
    direction_count: usize,
    references: *const u32,
    changes: *const f64,
    change_count: usize,
    inputs: *const u32,
    input_count: usize,
    begins: *const f64,
    piece_count: usize,
    factors: *const f64,
    rates: *const f64,
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
            let outputs = slice(outputs, output_count, function, "outputs")?;
            let value_count = time_count.saturating_mul(output_count);
            let values = slice_mut(values, value_count, function, "values")?;
            let slopes = slice_mut(
                slopes,
                value_count.saturating_mul(direction_count),
                function,
                "slopes",
            )?;
            let numbers = piece_count.saturating_mul(input_count);
            let course = Course {
                references: slice(inputs, input_count, function, "inputs")?,
                begins: slice(begins, piece_count, function, "begins")?,
                factors: slice(factors, numbers, function, "factors")?,
                rates: slice(rates, numbers, function, "rates")?,
            };
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
            if outputs.is_empty() {
                return Err(wrong("outputs", 0.0, "at least one"));
            }
            if time_count == 0 || !times.is_sorted() || !times.iter().all(|t| t.is_finite()) {
                return Err(wrong(
                    "times",
                    time_count as f64,
                    "at least one, finite and rising",
                ));
            }
            let starts_early = course.begins.first().is_none_or(|begin| *begin <= times[0]);
            let is_finite = |list: &[f64]| list.iter().all(|x| x.is_finite());
            if !(starts_early
                && course.begins.is_sorted()
                && [course.begins, course.factors, course.rates]
                    .into_iter()
                    .all(is_finite))
            {
                return Err(wrong(
                    "begins",
                    piece_count as f64,
                    "finite and rising, the first not after the first time, with finite factors and rates",
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
                outputs,
                directions,
                course,
            };
            instance.model.tangents(&request, Answer { values, slopes })
        })
    }
}
