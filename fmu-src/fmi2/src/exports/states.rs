//! Copies of the state of an instance, and their bytes.
//!
//! # Safety
//! As in [`super`].
#![allow(non_snake_case, clippy::missing_safety_doc)]

use crate::guard::{slice, with_instance, writable};
use crate::lifecycle::Function;
use crate::model::SavedState;
use crate::status::Fault;
use crate::types::{Component, StateHandle};
use std::any::Any;
use std::ffi::{c_char, c_int};
use std::ptr;

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
