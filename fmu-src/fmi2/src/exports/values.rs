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

/// `fmi2GetReal`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(
    component: Component,
    references: *const ValueReference,
    count: usize,
    values: *mut f64,
) -> c_int {
    let (function, access) = (Function::GetReal, Access::Real);
    // SAFETY: contract of this module.
    unsafe {
        get(
            component,
            function,
            access,
            references,
            count,
            values,
            |v| v,
        )
    }
}

/// `fmi2GetInteger`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetInteger(
    component: Component,
    references: *const ValueReference,
    count: usize,
    values: *mut c_int,
) -> c_int {
    let (function, access) = (Function::GetInteger, Access::Integer);
    // SAFETY: contract of this module.
    unsafe {
        get(
            component,
            function,
            access,
            references,
            count,
            values,
            |v| v as c_int,
        )
    }
}

/// `fmi2GetBoolean`; no variable has this type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBoolean(
    component: Component,
    references: *const ValueReference,
    count: usize,
    values: *mut Boolean,
) -> c_int {
    let (function, access) = (Function::GetBoolean, Access::Boolean);
    // SAFETY: contract of this module.
    unsafe {
        get(
            component,
            function,
            access,
            references,
            count,
            values,
            |v| v as c_int,
        )
    }
}

/// `fmi2GetString`; no variable has this type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetString(
    component: Component,
    references: *const ValueReference,
    count: usize,
    values: *mut Text,
) -> c_int {
    let (function, access) = (Function::GetString, Access::Text);
    // SAFETY: contract of this module.
    unsafe {
        get(
            component,
            function,
            access,
            references,
            count,
            values,
            |_| c"".as_ptr(),
        )
    }
}

/// `fmi2SetReal`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(
    component: Component,
    references: *const ValueReference,
    count: usize,
    values: *const f64,
) -> c_int {
    let (function, access) = (Function::SetReal, Access::Real);
    // SAFETY: contract of this module.
    unsafe {
        set(
            component,
            function,
            access,
            references,
            count,
            values,
            |v| v,
        )
    }
}

/// `fmi2SetInteger`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(
    component: Component,
    references: *const ValueReference,
    count: usize,
    values: *const c_int,
) -> c_int {
    let (function, access) = (Function::SetInteger, Access::Integer);
    // SAFETY: contract of this module.
    unsafe {
        set(
            component,
            function,
            access,
            references,
            count,
            values,
            f64::from,
        )
    }
}

/// `fmi2SetBoolean`; no variable has this type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetBoolean(
    component: Component,
    references: *const ValueReference,
    count: usize,
    values: *const Boolean,
) -> c_int {
    let (function, access) = (Function::SetBoolean, Access::Boolean);
    // SAFETY: contract of this module.
    unsafe {
        set(
            component,
            function,
            access,
            references,
            count,
            values,
            f64::from,
        )
    }
}

/// `fmi2SetString`; no variable has this type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetString(
    component: Component,
    references: *const ValueReference,
    count: usize,
    values: *const Text,
) -> c_int {
    let (function, access) = (Function::SetString, Access::Text);
    // SAFETY: contract of this module.
    unsafe {
        set(
            component,
            function,
            access,
            references,
            count,
            values,
            |_| 0.0,
        )
    }
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
