//! The life of an instance: from `fmi2Instantiate` to `fmi2FreeInstance`.
//!
//! # Safety
//! As in [`super`].
#![allow(non_snake_case, clippy::missing_safety_doc)]

use crate::drive::Drive;
use crate::experiment::Experiment;
use crate::guard::{panic_message, slice, with_instance};
use crate::instance::Instance;
use crate::lifecycle::{Function, Interface, Phase};
use crate::log::Log;
use crate::model::Model;
use crate::resource::{Starts, folder_of_uri};
use crate::slave::Slave;
use crate::status::{Fault, Status};
use crate::types::{Boolean, CallbackFunctions, Component, Text};
use std::ffi::{CStr, CString, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;

/// `fmi2GetTypesPlatform`.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> Text {
    c"default".as_ptr()
}

/// `fmi2GetVersion`.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> Text {
    c"2.0".as_ptr()
}

/// A string of the master's, or `None` for NULL.
///
/// # Safety
/// `text` is NULL or ends with a zero byte.
unsafe fn text<'a>(text: Text) -> Option<&'a CStr> {
    // SAFETY: not NULL where it is read, terminated by contract.
    (!text.is_null()).then(|| unsafe { CStr::from_ptr(text) })
}

/// `fmi2Instantiate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    instance_name: Text,
    fmu_type: c_int,
    guid: Text,
    resource_location: Text,
    functions: *const CallbackFunctions,
    _visible: Boolean,
    logging_on: Boolean,
) -> Component {
    // SAFETY: the master passes NULL or valid callbacks; they are copied.
    let Some(callbacks) = (unsafe { functions.as_ref() }).copied() else {
        return ptr::null_mut();
    };
    // SAFETY: strings of the master are NULL or terminated.
    let (name, guid, location) =
        unsafe { (text(instance_name), text(guid), text(resource_location)) };
    let log = Log::new(
        callbacks,
        name.map(CStr::to_owned).unwrap_or_default(),
        logging_on != 0,
    );
    let made = catch_unwind(AssertUnwindSafe(|| {
        instantiate(name, fmu_type, guid, location)
    }));
    let (status, message) = match made {
        Ok(Ok(model)) => {
            log.message(
                Status::Ok,
                &format!("instantiated for {}", model.interface()),
            );
            return Box::into_raw(Box::new(Slave { log, model })).cast();
        }
        Ok(Err(message)) => (Status::Error, message),
        Err(payload) => (Status::Fatal, panic_message(&*payload)),
    };
    log.message(status, &format!("fmi2Instantiate: {message}"));
    ptr::null_mut()
}

/// Checks the arguments, and makes the model that the GUID asks for.
fn instantiate(
    name: Option<&CStr>,
    fmu_type: c_int,
    guid: Option<&CStr>,
    location: Option<&CStr>,
) -> Result<Box<dyn Model>, String> {
    if name.is_none_or(CStr::is_empty) {
        return Err("instanceName is NULL or empty; pass a name".into());
    }
    let interface = Interface::from_number(fmu_type).ok_or_else(|| {
        format!("fmuType {fmu_type} is unknown; use model exchange (0) or co-simulation (1)")
    })?;
    let given = guid.map(CStr::to_string_lossy).unwrap_or_default();
    if given == beam_model_description::belt_drive::guid() {
        return Ok(Box::new(Drive::new(interface)?));
    }
    let folder = location.and_then(|uri| folder_of_uri(&uri.to_string_lossy()));
    let starts = Starts::load(folder.as_deref())?;
    if given != starts.guid {
        return Err(format!(
            "GUID '{given}' is not that of this binary, '{}'; \
             use the modelDescription.xml packed with it",
            starts.guid
        ));
    }
    Ok(Box::new(Instance::new(starts, interface)))
}

/// `fmi2FreeInstance`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(component: Component) {
    if !component.is_null() {
        let instance = component.cast::<Slave>();
        let _ = catch_unwind(AssertUnwindSafe(|| {
            // SAFETY: the handle came from Box::into_raw in fmi2Instantiate and is freed once.
            drop(unsafe { Box::from_raw(instance) })
        }));
    }
}

/// `fmi2SetDebugLogging`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    component: Component,
    logging_on: Boolean,
    count: usize,
    categories: *const Text,
) -> c_int {
    let function = Function::SetDebugLogging;
    // SAFETY: contract of this module.
    unsafe {
        with_instance(component, function, |instance| {
            let mut list: Vec<CString> = Vec::with_capacity(count.min(16));
            for &category in slice(categories, count, function, "categories")? {
                let category = text(category).ok_or(Fault::NullArgument {
                    function,
                    argument: "categories",
                })?;
                list.push(category.to_owned());
            }
            instance.log.set(logging_on != 0, list)
        })
    }
}

/// `fmi2SetupExperiment`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    component: Component,
    tolerance_defined: Boolean,
    tolerance: f64,
    start_time: f64,
    stop_time_defined: Boolean,
    stop_time: f64,
) -> c_int {
    // SAFETY: contract of this module.
    unsafe {
        with_instance(component, Function::SetupExperiment, |instance| {
            instance.model.setup_experiment(Experiment {
                start: start_time,
                stop: (stop_time_defined != 0).then_some(stop_time),
                tolerance: (tolerance_defined != 0).then_some(tolerance),
            })
        })
    }
}

/// `fmi2EnterInitializationMode`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(component: Component) -> c_int {
    // SAFETY: contract of this module.
    unsafe {
        with_instance(component, Function::EnterInitializationMode, |instance| {
            instance.model.enter_initialization();
            Ok(())
        })
    }
}

/// `fmi2ExitInitializationMode`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(component: Component) -> c_int {
    // SAFETY: contract of this module.
    unsafe {
        with_instance(component, Function::ExitInitializationMode, |instance| {
            instance.model.exit_initialization()
        })
    }
}

/// `fmi2Terminate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(component: Component) -> c_int {
    // SAFETY: contract of this module.
    unsafe {
        with_instance(component, Function::Terminate, |instance| {
            instance.model.set_phase(Phase::Terminated);
            Ok(())
        })
    }
}

/// `fmi2Reset`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(component: Component) -> c_int {
    // SAFETY: contract of this module.
    unsafe {
        with_instance(component, Function::Reset, |instance| {
            instance.model.reset();
            Ok(())
        })
    }
}
