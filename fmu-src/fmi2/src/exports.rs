//! The functions of FMI 2.0 that both interfaces share and those of co-simulation, as the master calls
//! them.
//!
//! # Safety
//! All functions rely on the master to keep the standard's promises about pointers: handles come from
//! `fmi2Instantiate` and are not used after `fmi2FreeInstance`, arrays have the announced lengths,
//! strings end with a zero byte, and one instance is used by one thread at a time.
#![allow(non_snake_case, clippy::missing_safety_doc)]

use crate::drive::Drive;
use crate::experiment::Experiment;
use crate::guard::{panic_message, slice, with_instance, writable};
use crate::instance::Instance;
use crate::lifecycle::{Function, Interface, Phase};
use crate::log::Log;
use crate::model::{Model, SavedState};
use crate::resource::{Starts, folder_of_uri};
use crate::slave::Slave;
use crate::status::{Fault, Status};
use crate::types::{
    Boolean, CallbackFunctions, Component, DO_STEP_STATUS, LAST_SUCCESSFUL_TIME, PENDING_STATUS,
    StateHandle, TERMINATED, Text, ValueReference,
};
use crate::values::Access;
use std::any::Any;
use std::ffi::{CStr, CString, c_char, c_int};
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

/// The handle of a copied state. The `Option` lets a copy go into the memory of an older one.
fn handle(state: SavedState) -> StateHandle {
    Box::into_raw(Box::new(Some(state))).cast()
}

/// The copied state behind a handle.
///
/// # Errors
/// [`Fault::NullArgument`].
///
/// # Safety
/// The handle is NULL or came from [`handle`] and was not freed.
unsafe fn saved<'a>(state: StateHandle, function: Function) -> Result<&'a dyn Any, Fault> {
    // SAFETY: by the contract.
    let kept = unsafe { state.cast::<Option<SavedState>>().as_ref() };
    kept.and_then(Option::as_deref).ok_or(Fault::NullArgument {
        function,
        argument: "FMUstate",
    })
}

/// `fmi2GetFMUstate`: a new state, or the given one overwritten.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(component: Component, state: *mut StateHandle) -> c_int {
    let function = Function::GetFmuState;
    // SAFETY: contract of this module; a handle that is not NULL came from this FMU.
    unsafe {
        with_instance(component, function, |instance| {
            writable(state, 1, function, "FMUstate")?;
            match (*state).cast::<Option<SavedState>>().as_mut() {
                Some(kept) => *kept = Some(instance.model.save(kept.take())),
                None => *state = handle(instance.model.save(None)),
            }
            Ok(())
        })
    }
}

/// `fmi2SetFMUstate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(component: Component, state: StateHandle) -> c_int {
    let function = Function::SetFmuState;
    // SAFETY: contract of this module; the handle is NULL or came from this FMU.
    unsafe {
        with_instance(component, function, |instance| {
            instance.model.restore(saved(state, function)?)
        })
    }
}

/// `fmi2FreeFMUstate`; NULL is no error (FMI 2.0.5, section 2.1.8).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(component: Component, state: *mut StateHandle) -> c_int {
    // SAFETY: contract of this module; the handle is NULL or came from Box::into_raw above. It is set
    // to NULL, so that freeing it again does nothing.
    unsafe {
        with_instance(component, Function::FreeFmuState, |_| {
            if !state.is_null() && !(*state).is_null() {
                drop(Box::from_raw((*state).cast::<Option<SavedState>>()));
                *state = ptr::null_mut();
            }
            Ok(())
        })
    }
}

/// `fmi2SerializedFMUstateSize`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(
    component: Component,
    state: StateHandle,
    size: *mut usize,
) -> c_int {
    let function = Function::SerializedFmuStateSize;
    // SAFETY: contract of this module.
    unsafe {
        with_instance(component, function, |instance| {
            writable(size, 1, function, "size")?;
            *size = instance.model.serialize(saved(state, function)?)?.len();
            Ok(())
        })
    }
}

/// `fmi2SerializeFMUstate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    component: Component,
    state: StateHandle,
    serialized: *mut c_char,
    size: usize,
) -> c_int {
    let function = Function::SerializeFmuState;
    // SAFETY: contract of this module; at most `size` bytes are written.
    unsafe {
        with_instance(component, function, |instance| {
            writable(serialized, 1, function, "serializedState")?;
            let bytes = instance.model.serialize(saved(state, function)?)?;
            if size < bytes.len() {
                return Err(Fault::BadArgument {
                    function,
                    argument: "size",
                    value: size as f64,
                    unit: "bytes",
                    required: format!("at least {}", bytes.len()),
                });
            }
            ptr::copy_nonoverlapping(bytes.as_ptr().cast(), serialized, bytes.len());
            Ok(())
        })
    }
}

/// `fmi2DeSerializeFMUstate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    component: Component,
    serialized: *const c_char,
    size: usize,
    state: *mut StateHandle,
) -> c_int {
    let function = Function::DeSerializeFmuState;
    // SAFETY: contract of this module.
    unsafe {
        with_instance(component, function, |instance| {
            writable(state, 1, function, "FMUstate")?;
            let bytes = slice(serialized.cast::<u8>(), size, function, "serializedState")?;
            let read = instance.model.deserialize(bytes)?;
            match (*state).cast::<Option<SavedState>>().as_mut() {
                Some(kept) => *kept = Some(read),
                None => *state = handle(read),
            }
            Ok(())
        })
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
