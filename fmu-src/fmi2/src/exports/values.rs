//! Values of variables, read and set, and derivatives of outputs along directions.
//!
//! # Safety
//! As in [`super`].
#![allow(non_snake_case, clippy::missing_safety_doc)]

use crate::guard::{slice, with_instance, writable};
use crate::lifecycle::Function;
use crate::types::{Boolean, Component, Text, ValueReference};
use crate::values::Access;
use std::ffi::c_int;

/// Reads `count` variables, each turned into the master's type by `convert`.
///
/// # Safety
/// Contract of this module.
unsafe fn get<T>(
    component: Component,
    function: Function,
    access: Access,
    references: *const ValueReference,
    count: usize,
    values: *mut T,
    convert: impl Fn(f64) -> T,
) -> c_int {
    // SAFETY: contract of this module; every position written is below `count`.
    unsafe {
        with_instance(component, function, |instance| {
            let references = slice(references, count, function, "vr")?;
            writable(values, count, function, "value")?;
            instance
                .model
                .get(references, access, &mut |position, value| {
                    values.add(position).write(convert(value));
                })
        })
    }
}

/// Sets `count` variables.
///
/// # Safety
/// Contract of this module.
unsafe fn set<T: Copy>(
    component: Component,
    function: Function,
    access: Access,
    references: *const ValueReference,
    count: usize,
    values: *const T,
    convert: impl Fn(T) -> f64,
) -> c_int {
    // SAFETY: contract of this module.
    unsafe {
        with_instance(component, function, |instance| {
            let references = slice(references, count, function, "vr")?;
            let values = slice(values, count, function, "value")?;
            instance
                .model
                .set(references, access, &|position| convert(values[position]))
        })
    }
}

/// The standard's functions that read or set variables of one type, each of which is converted between that type and what the model
/// holds.
macro_rules! functions {
    ($call:ident, $pointer:tt; $(
        $(#[$doc:meta])* $name:ident: $function:ident, $access:ident, $type:ty, $convert:expr;
    )*) => {$(
        $(#[$doc])*
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            component: Component,
            references: *const ValueReference,
            count: usize,
            values: *$pointer $type,
        ) -> c_int {
            let (function, access) = (Function::$function, Access::$access);
            // SAFETY: contract of this module.
            unsafe { $call(component, function, access, references, count, values, $convert) }
        }
    )*};
}

functions! {
    get, mut;
    /// `fmi2GetReal`.
    fmi2GetReal: GetReal, Real, f64, |v| v;
    /// `fmi2GetInteger`.
    fmi2GetInteger: GetInteger, Integer, c_int, |v| v as c_int;
    /// `fmi2GetBoolean`; no variable has this type.
    fmi2GetBoolean: GetBoolean, Boolean, Boolean, |v| v as c_int;
    /// `fmi2GetString`; no variable has this type.
    fmi2GetString: GetString, Text, Text, |_| c"".as_ptr();
}

functions! {
    set, const;
    /// `fmi2SetReal`.
    fmi2SetReal: SetReal, Real, f64, |v| v;
    /// `fmi2SetInteger`.
    fmi2SetInteger: SetInteger, Integer, c_int, f64::from;
    /// `fmi2SetBoolean`; no variable has this type.
    fmi2SetBoolean: SetBoolean, Boolean, Boolean, f64::from;
    /// `fmi2SetString`; no variable has this type.
    fmi2SetString: SetString, Text, Text, |_| 0.0;
}

/// `fmi2GetDirectionalDerivative`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    component: Component,
    unknowns: *const ValueReference,
    unknown_count: usize,
    knowns: *const ValueReference,
    known_count: usize,
    seed: *const f64,
    sensitivity: *mut f64,
) -> c_int {
    let function = Function::GetDirectionalDerivative;
    // SAFETY: contract of this module; every position written is below `unknown_count`.
    unsafe {
        with_instance(component, function, |instance| {
            let unknowns = slice(unknowns, unknown_count, function, "vUnknown_ref")?;
            let knowns = slice(knowns, known_count, function, "vKnown_ref")?;
            let seed = slice(seed, known_count, function, "dvKnown")?;
            writable(sensitivity, unknown_count, function, "dvUnknown")?;
            instance
                .model
                .directional(unknowns, knowns, seed, &mut |position, value| {
                    sensitivity.add(position).write(value);
                })
        })
    }
}
