//! What stands between the master and an instance: NULL, calling sequence, panics, messages.

use crate::lifecycle::{Function, Phase};
use crate::slave::Slave;
use crate::status::{Fault, Status};
use crate::types::Component;
use std::any::Any;
use std::ffi::c_int;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs `body` on the instance behind a handle and turns the outcome into a status.
///
/// # Safety
/// `component` is NULL or a handle from `fmi2Instantiate` that was not freed, used by one thread at a
/// time (FMI 2.0.5, section 2.1.3).
pub unsafe fn with_instance(
    component: Component,
    function: Function,
    body: impl FnOnce(&mut Slave) -> Result<(), Fault>,
) -> c_int {
    // SAFETY: by the contract of this function the pointer is NULL or refers to a live instance that
    // nobody else uses during the call.
    let Some(instance) = (unsafe { component.cast::<Slave>().as_mut() }) else {
        return Status::Error.code();
    };
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        instance.admit(function)?;
        body(instance)
    }));
    let fault = match outcome {
        Ok(Ok(())) => return Status::Ok.code(),
        Ok(Err(fault)) => fault,
        Err(payload) => {
            instance.model.set_phase(Phase::Fatal);
            Fault::Panic {
                message: panic_message(&*payload),
            }
        }
    };
    let status = fault.status();
    // The message itself could fail only for want of memory; even then nothing may cross.
    let _ = catch_unwind(AssertUnwindSafe(|| {
        instance.log.message(status, &fault.to_string());
    }));
    status.code()
}

/// The text of a panic.
pub fn panic_message(payload: &(dyn Any + Send)) -> String {
    payload
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned())
        .or_else(|| payload.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "unknown cause".to_owned())
}

/// A slice of the master's, for reading.
///
/// # Errors
/// [`Fault::NullArgument`] where elements are announced but the pointer is NULL.
///
/// # Safety
/// `pointer` is NULL or refers to `count` elements that nobody changes during the call.
pub unsafe fn slice<'a, T>(
    pointer: *const T,
    count: usize,
    function: Function,
    argument: &'static str,
) -> Result<&'a [T], Fault> {
    if count == 0 {
        return Ok(&[]);
    }
    if pointer.is_null() {
        return Err(Fault::NullArgument { function, argument });
    }
    // SAFETY: not NULL, and by the contract it refers to `count` elements.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// An array of the master's, to be filled.
///
/// # Errors
/// [`Fault::NullArgument`] where elements are announced but the pointer is NULL.
///
/// # Safety
/// `pointer` is NULL or refers to `count` elements that nobody else uses during the call.
pub unsafe fn slice_mut<'a, T>(
    pointer: *mut T,
    count: usize,
    function: Function,
    argument: &'static str,
) -> Result<&'a mut [T], Fault> {
    writable(pointer, count, function, argument)?;
    if count == 0 {
        return Ok(&mut []);
    }
    // SAFETY: not NULL, and by the contract it refers to `count` elements.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, count) })
}

/// Refuses an output argument that is NULL although elements are to be written.
///
/// # Errors
/// [`Fault::NullArgument`].
pub fn writable<T>(
    pointer: *mut T,
    count: usize,
    function: Function,
    argument: &'static str,
) -> Result<(), Fault> {
    if count > 0 && pointer.is_null() {
        return Err(Fault::NullArgument { function, argument });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instance::Instance;
    use crate::lifecycle::Interface;
    use crate::log::Log;
    use crate::resource::Starts;
    use crate::types::CallbackFunctions;

    #[test]
    fn a_panic_becomes_fatal_and_the_instance_refuses_everything_after_it() {
        let callbacks = CallbackFunctions {
            logger: None,
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            environment: std::ptr::null_mut(),
        };
        let log = Log::new(callbacks, c"test".into(), true);
        let beam = Instance::new(Starts::built_in(), Interface::CoSimulation);
        let mut instance = Slave {
            log,
            model: Box::new(beam),
        };
        let component: Component = std::ptr::from_mut(&mut instance).cast();
        // SAFETY: the instance lives on this stack.
        let call = |body: fn(&mut Slave) -> Result<(), Fault>| unsafe {
            with_instance(component, Function::Reset, body)
        };
        assert_eq!(call(|_| Ok(())), Status::Ok.code());
        assert_eq!(call(|_| panic!("on purpose")), Status::Fatal.code());
        assert_eq!(call(|_| Ok(())), Status::Error.code());
    }
}
