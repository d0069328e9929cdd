//! The functions of FMI 2.0 for model exchange, as the master calls them.
//!
//! # Safety
//! As in [`super`].
#![allow(non_snake_case, clippy::missing_safety_doc)]

use crate::guard::{slice, slice_mut, with_instance, writable};
use crate::lifecycle::{Function, Phase};
use crate::model::Model;
use crate::status::Fault;
use crate::types::{Boolean, Component, EventInfo};
use std::ffi::c_int;

/// Enters a phase.
///
/// # Safety
/// Contract of this module.
unsafe fn enter(component: Component, function: Function, phase: Phase) -> c_int {
    // SAFETY: contract of this module.
    unsafe {
        with_instance(component, function, |instance| {
            instance.model.set_phase(phase);
            Ok(())
        })
    }
}

/// `fmi2EnterEventMode`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterEventMode(component: Component) -> c_int {
    // SAFETY: contract of this module.
    unsafe { enter(component, Function::EnterEventMode, Phase::EventMode) }
}

/// `fmi2EnterContinuousTimeMode`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterContinuousTimeMode(component: Component) -> c_int {
    let function = Function::EnterContinuousTimeMode;
    // SAFETY: contract of this module.
    unsafe { enter(component, function, Phase::ContinuousTime) }
}

/// `fmi2NewDiscreteStates`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2NewDiscreteStates(
    component: Component,
    event_info: *mut EventInfo,
) -> c_int {
    let function = Function::NewDiscreteStates;
    // SAFETY: contract of this module.
    unsafe {
        with_instance(component, function, |instance| {
            writable(event_info, 1, function, "fmi2eventInfo")?;
            *event_info = instance.model.new_discrete_states()?;
            Ok(())
        })
    }
}

/// `fmi2CompletedIntegratorStep`: this FMU has no events of steps.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CompletedIntegratorStep(
    component: Component,
    _no_set_state_prior_to_current_point: Boolean,
    enter_event_mode: *mut Boolean,
    terminate_simulation: *mut Boolean,
) -> c_int {
    let function = Function::CompletedIntegratorStep;
    // SAFETY: contract of this module.
    unsafe {
        with_instance(component, function, |_| {
            writable(enter_event_mode, 1, function, "enterEventMode")?;
            writable(terminate_simulation, 1, function, "terminateSimulation")?;
            *enter_event_mode = 0;
            *terminate_simulation = 0;
            Ok(())
        })
    }
}

/// `fmi2SetTime`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetTime(component: Component, time: f64) -> c_int {
    // SAFETY: contract of this module.
    unsafe {
        with_instance(component, Function::SetTime, |instance| {
            instance.model.set_time(time)
        })
    }
}

/// `fmi2SetContinuousStates`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetContinuousStates(
    component: Component,
    states: *const f64,
    count: usize,
) -> c_int {
    let function = Function::SetContinuousStates;
    // SAFETY: contract of this module.
    unsafe {
        with_instance(component, function, |instance| {
            let states = slice(states, count, function, "x")?;
            instance.model.set_states(states)
        })
    }
}

/// Fills an array of the master's.
///
/// # Safety
/// Contract of this module.
unsafe fn fill(
    component: Component,
    function: Function,
    argument: &'static str,
    values: *mut f64,
    count: usize,
    with: impl FnOnce(&mut dyn Model, &mut [f64]) -> Result<(), Fault>,
) -> c_int {
    // SAFETY: contract of this module.
    unsafe {
        with_instance(component, function, |instance| {
            let values = slice_mut(values, count, function, argument)?;
            with(&mut *instance.model, values)
        })
    }
}

/// `fmi2GetDerivatives`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDerivatives(
    component: Component,
    derivatives: *mut f64,
    count: usize,
) -> c_int {
    let function = Function::GetDerivatives;
    // SAFETY: contract of this module.
    unsafe {
        fill(
            component,
            function,
            "derivatives",
            derivatives,
            count,
            |model, values| model.get_derivatives(values),
        )
    }
}

/// `fmi2GetEventIndicators`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetEventIndicators(
    component: Component,
    indicators: *mut f64,
    count: usize,
) -> c_int {
    let function = Function::GetEventIndicators;
    // SAFETY: contract of this module.
    unsafe {
        fill(
            component,
            function,
            "eventIndicators",
            indicators,
            count,
            |model, values| model.get_indicators(values),
        )
    }
}

/// `fmi2GetContinuousStates`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetContinuousStates(
    component: Component,
    states: *mut f64,
    count: usize,
) -> c_int {
    let function = Function::GetContinuousStates;
    // SAFETY: contract of this module.
    unsafe {
        fill(component, function, "x", states, count, |model, values| {
            model.get_states(values)
        })
    }
}

/// `fmi2GetNominalsOfContinuousStates`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetNominalsOfContinuousStates(
    component: Component,
    nominals: *mut f64,
    count: usize,
) -> c_int {
    let function = Function::GetNominalsOfContinuousStates;
    // SAFETY: contract of this module.
    unsafe {
        fill(
            component,
            function,
            "x_nominal",
            nominals,
            count,
            |model, values| model.get_nominals(values),
        )
    }
}
