//! Co-simulation: steps, rates of inputs and outputs, questions about the last step.
//!
//! # Safety
//! As in [`super`].
#![allow(non_snake_case, clippy::missing_safety_doc)]

use crate::guard::{slice, with_instance, writable};
use crate::lifecycle::Function;
use crate::slave::Slave;
use crate::status::Fault;
use crate::types::{
    Boolean, Component, DO_STEP_STATUS, LAST_SUCCESSFUL_TIME, PENDING_STATUS, TERMINATED, Text,
    ValueReference,
};
use std::ffi::c_int;

/// `fmi2SetRealInputDerivatives`: the rate holds for the next step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    component: Component,
    references: *const ValueReference,
    count: usize,
    orders: *const c_int,
    values: *const f64,
) -> c_int {
    let function = Function::SetRealInputDerivatives;
    // SAFETY: contract of this module.
    unsafe {
        with_instance(component, function, |instance| {
            let references = slice(references, count, function, "vr")?;
            let orders = slice(orders, count, function, "order")?;
            let values = slice(values, count, function, "value")?;
            instance.model.set_input_rates(references, orders, values)
        })
    }
}

/// `fmi2GetRealOutputDerivatives`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    component: Component,
    references: *const ValueReference,
    count: usize,
    orders: *const c_int,
    values: *mut f64,
) -> c_int {
    let function = Function::GetRealOutputDerivatives;
    // SAFETY: contract of this module; every position written is below `count`.
    unsafe {
        with_instance(component, function, |instance| {
            let references = slice(references, count, function, "vr")?;
            let orders = slice(orders, count, function, "order")?;
            writable(values, count, function, "value")?;
            instance
                .model
                .output_rates(references, orders, &mut |position, value| {
                    values.add(position).write(value);
                })
        })
    }
}

/// `fmi2DoStep`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    component: Component,
    current_communication_point: f64,
    communication_step_size: f64,
    _no_set_state_before_current_point: Boolean,
) -> c_int {
    // SAFETY: contract of this module.
    unsafe {
        with_instance(component, Function::DoStep, |instance| {
            instance
                .model
                .do_step(current_communication_point, communication_step_size)
        })
    }
}

/// `fmi2CancelStep`: steps are synchronous, so there is never one to cancel.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(component: Component) -> c_int {
    // SAFETY: contract of this module.
    unsafe { with_instance(component, Function::CancelStep, |_| Ok(())) }
}

/// Answers a question about the last step.
///
/// # Safety
/// Contract of this module.
unsafe fn answer<T>(
    component: Component,
    function: Function,
    kind: c_int,
    value: *mut T,
    answer: impl FnOnce(&Slave) -> Option<T>,
) -> c_int {
    // SAFETY: contract of this module.
    unsafe {
        with_instance(component, function, |instance| {
            writable(value, 1, function, "value")?;
            *value = answer(instance).ok_or_else(|| Fault::Unsupported {
                function,
                what: format!("status kind {kind}"),
            })?;
            Ok(())
        })
    }
}

/// `fmi2GetStatus`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(
    component: Component,
    kind: c_int,
    value: *mut c_int,
) -> c_int {
    // SAFETY: contract of this module.
    unsafe {
        answer(component, Function::GetStatus, kind, value, |instance| {
            (kind == DO_STEP_STATUS).then(|| instance.model.last_step().code())
        })
    }
}

/// `fmi2GetRealStatus`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(
    component: Component,
    kind: c_int,
    value: *mut f64,
) -> c_int {
    // SAFETY: contract of this module.
    unsafe {
        answer(
            component,
            Function::GetRealStatus,
            kind,
            value,
            |instance| (kind == LAST_SUCCESSFUL_TIME).then_some(instance.model.time()),
        )
    }
}

/// `fmi2GetIntegerStatus`: the standard defines no kind of this type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(
    component: Component,
    kind: c_int,
    value: *mut c_int,
) -> c_int {
    // SAFETY: contract of this module.
    unsafe { answer(component, Function::GetIntegerStatus, kind, value, |_| None) }
}

/// `fmi2GetBooleanStatus`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(
    component: Component,
    kind: c_int,
    value: *mut Boolean,
) -> c_int {
    // SAFETY: contract of this module.
    unsafe {
        answer(component, Function::GetBooleanStatus, kind, value, |_| {
            (kind == TERMINATED).then_some(0)
        })
    }
}

/// `fmi2GetStringStatus`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(
    component: Component,
    kind: c_int,
    value: *mut Text,
) -> c_int {
    // SAFETY: contract of this module.
    unsafe {
        answer(component, Function::GetStringStatus, kind, value, |_| {
            (kind == PENDING_STATUS).then_some(c"".as_ptr())
        })
    }
}
