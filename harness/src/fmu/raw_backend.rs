//! A backend without a crate, for instances that are driven by inputs with a slope: `fmi2SetRealInputDerivatives`
//! (FMI 2.0.5, section 4.2.1) is passed on by neither crate, and their instances can't be reached.
//!
//! Saved states are not offered: nobody drives an instance and goes back.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::Path;
use std::sync::Arc;

use libloading::Library;

use super::archive;
use super::description::ModelDescription;
use super::message_log::MessageLog;
use super::slave::Slave;
use super::status::Status;

/// `fmi2CoSimulation`.
const CO_SIMULATION: c_int = 1;

/// `fmi2CallbackFunctions`. The logger has a list of arguments of any length behind its format; of the platforms for which
/// binaries are made, all pass the first of them as if it were named.
#[repr(C)]
struct Callbacks {
    logger: extern "C" fn(
        *mut c_void,
        *const c_char,
        c_int,
        *const c_char,
        *const c_char,
        *const c_char,
    ),
    allocate: unsafe extern "C" fn(usize, usize) -> *mut c_void,
    free: unsafe extern "C" fn(*mut c_void),
    step_finished: *const c_void,
    environment: *const MessageLog,
}

unsafe extern "C" {
    fn calloc(count: usize, size: usize) -> *mut c_void;
    fn free(memory: *mut c_void);
}

extern "C" fn log(
    environment: *mut c_void,
    _: *const c_char,
    _: c_int,
    _: *const c_char,
    format: *const c_char,
    first: *const c_char,
) {
    if environment.is_null() || format.is_null() {
        return;
    }
    // SAFETY: the environment is the log that the instance keeps alive; the format is a text, and where it is "%s" alone so
    // is the argument behind it.
    let (messages, format) =
        unsafe { (&*environment.cast::<MessageLog>(), CStr::from_ptr(format)) };
    let readable = cfg!(any(
        target_arch = "x86_64",
        all(target_arch = "aarch64", not(target_vendor = "apple"))
    ));
    let text = if format == c"%s" && readable && !first.is_null() {
        // SAFETY: as above.
        unsafe { CStr::from_ptr(first) }
    } else {
        format
    };
    messages.push(&text.to_string_lossy());
}

type Instantiate = unsafe extern "C" fn(
    *const c_char,
    c_int,
    *const c_char,
    *const c_char,
    *const Callbacks,
    c_int,
    c_int,
) -> *mut c_void;
type Free = unsafe extern "C" fn(*mut c_void);
type Plain = unsafe extern "C" fn(*mut c_void) -> c_int;
type SetReals = unsafe extern "C" fn(*mut c_void, *const u32, usize, *const f64) -> c_int;
type GetReals = unsafe extern "C" fn(*mut c_void, *const u32, usize, *mut f64) -> c_int;
type SetIntegers = unsafe extern "C" fn(*mut c_void, *const u32, usize, *const i32) -> c_int;
type GetIntegers = unsafe extern "C" fn(*mut c_void, *const u32, usize, *mut i32) -> c_int;
type SetTexts = unsafe extern "C" fn(*mut c_void, *const u32, usize, *const *const c_char) -> c_int;
type SetRates =
    unsafe extern "C" fn(*mut c_void, *const u32, usize, *const c_int, *const f64) -> c_int;
type Setup = unsafe extern "C" fn(*mut c_void, c_int, f64, f64, c_int, f64) -> c_int;
type Step = unsafe extern "C" fn(*mut c_void, f64, f64, c_int) -> c_int;

/// The functions in use.
struct Functions {
    free: Free,
    set_real: SetReals,
    get_real: GetReals,
    set_integer: SetIntegers,
    get_integer: GetIntegers,
    set_boolean: SetIntegers,
    get_boolean: GetIntegers,
    set_string: SetTexts,
    set_rates: SetRates,
    setup: Setup,
    enter: Plain,
    exit: Plain,
    step: Step,
    reset: Plain,
    terminate: Plain,
}

pub(crate) struct RawSlave {
    component: *mut c_void,
    functions: Functions,
    // The functions live in the library, and the instance knows the callbacks and, through them, the log: these go last.
    _callbacks: Box<Callbacks>,
    _log: Arc<MessageLog>,
    _library: Library,
}

/// Loads the library once more (the system counts the loads) and instantiates.
pub(crate) fn instantiate(
    folder: &Path,
    description: &ModelDescription,
    name: &str,
    log_to: Arc<MessageLog>,
) -> Result<RawSlave, String> {
    let path = archive::binary(folder, &description.model_identifier);
    let text = |t: &str| CString::new(t).map_err(|e| e.to_string());
    let resources = text(&format!("file://{}/resources", folder.display()))?;
    let (name, guid) = (text(name)?, text(&description.guid)?);
    let callbacks = Box::new(Callbacks {
        logger: log,
        allocate: calloc,
        free,
        step_finished: std::ptr::null(),
        environment: Arc::as_ptr(&log_to),
    });
    // SAFETY: an FMU's library, whose functions have the types of FMI 2.0; pointers to them are kept beside the library.
    unsafe {
        let library = Library::new(path).map_err(|e| e.to_string())?;
        macro_rules! function {
            ($name:literal) => {
                *library
                    .get(concat!("fmi2", $name).as_bytes())
                    .map_err(|e| e.to_string())?
            };
        }
        let instantiate: Instantiate = function!("Instantiate");
        let functions = Functions {
            free: function!("FreeInstance"),
            set_real: function!("SetReal"),
            get_real: function!("GetReal"),
            set_integer: function!("SetInteger"),
            get_integer: function!("GetInteger"),
            set_boolean: function!("SetBoolean"),
            get_boolean: function!("GetBoolean"),
            set_string: function!("SetString"),
            set_rates: function!("SetRealInputDerivatives"),
            setup: function!("SetupExperiment"),
            enter: function!("EnterInitializationMode"),
            exit: function!("ExitInitializationMode"),
            step: function!("DoStep"),
            reset: function!("Reset"),
            terminate: function!("Terminate"),
        };
        let component = instantiate(
            name.as_ptr(),
            CO_SIMULATION,
            guid.as_ptr(),
            resources.as_ptr(),
            &raw const *callbacks,
            0,
            0,
        );
        if component.is_null() {
            return Err("fmi2Instantiate gave no instance".into());
        }
        Ok(RawSlave {
            component,
            functions,
            _callbacks: callbacks,
            _log: log_to,
            _library: library,
        })
    }
}

fn status(code: c_int) -> Status {
    match code {
        0 => Status::Ok,
        1 => Status::Warning,
        2 => Status::Discard,
        4 => Status::Fatal,
        5 => Status::Pending,
        _ => Status::Error,
    }
}

/// A call with the instance; lists have the announced lengths, which [`super::Instance`] checks.
macro_rules! call {
    ($self:ident.$function:ident($($argument:expr),*)) => {
        // SAFETY: the instance is live, the lists have the announced lengths.
        status(unsafe { ($self.functions.$function)($self.component, $($argument),*) })
    };
}

impl Slave for RawSlave {
    fn set_real(&mut self, references: &[u32], values: &[f64]) -> Status {
        call!(self.set_real(references.as_ptr(), references.len(), values.as_ptr()))
    }
    fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Status {
        call!(self.get_real(references.as_ptr(), references.len(), values.as_mut_ptr()))
    }
    fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Status {
        call!(self.set_integer(references.as_ptr(), references.len(), values.as_ptr()))
    }
    fn get_integer(&mut self, references: &[u32], values: &mut [i32]) -> Status {
        call!(self.get_integer(references.as_ptr(), references.len(), values.as_mut_ptr()))
    }
    fn set_boolean(&mut self, references: &[u32], values: &[i32]) -> Status {
        call!(self.set_boolean(references.as_ptr(), references.len(), values.as_ptr()))
    }
    fn get_boolean(&mut self, references: &[u32], values: &mut [i32]) -> Status {
        call!(self.get_boolean(references.as_ptr(), references.len(), values.as_mut_ptr()))
    }
    fn set_string(&mut self, references: &[u32], values: &[&str]) -> Status {
        let texts: Result<Vec<CString>, _> = values.iter().map(|v| CString::new(*v)).collect();
        let Ok(texts) = texts else {
            return Status::Error;
        };
        let pointers: Vec<*const c_char> = texts.iter().map(|t| t.as_ptr()).collect();
        call!(self.set_string(references.as_ptr(), references.len(), pointers.as_ptr()))
    }
    fn set_input_rates(&mut self, references: &[u32], rates: &[f64]) -> Status {
        let orders = vec![1; references.len()];
        call!(self.set_rates(
            references.as_ptr(),
            references.len(),
            orders.as_ptr(),
            rates.as_ptr()
        ))
    }
    fn setup_experiment(
        &mut self,
        tolerance: Option<f64>,
        start: f64,
        stop: Option<f64>,
    ) -> Status {
        let (defined, tolerance) = (c_int::from(tolerance.is_some()), tolerance.unwrap_or(0.0));
        let (ends, stop) = (c_int::from(stop.is_some()), stop.unwrap_or(0.0));
        call!(self.setup(defined, tolerance, start, ends, stop))
    }
    fn enter_initialization(&mut self) -> Status {
        call!(self.enter())
    }
    fn exit_initialization(&mut self) -> Status {
        call!(self.exit())
    }
    fn do_step(&mut self, time: f64, step: f64) -> Status {
        call!(self.step(time, step, 1))
    }
    fn reset(&mut self) -> Status {
        call!(self.reset())
    }
    fn terminate(&mut self) -> Status {
        call!(self.terminate())
    }
    fn save_state(&mut self) -> Result<usize, Status> {
        Err(Status::Error)
    }
    fn overwrite_state(&mut self, _: usize) -> Status {
        Status::Error
    }
    fn restore_state(&mut self, _: usize) -> Status {
        Status::Error
    }
    fn serialize_state(&mut self, _: usize) -> Result<Vec<u8>, Status> {
        Err(Status::Error)
    }
    fn deserialize_state(&mut self, _: &[u8]) -> Result<usize, Status> {
        Err(Status::Error)
    }
}

impl Drop for RawSlave {
    fn drop(&mut self) {
        // SAFETY: made by this library, freed once.
        unsafe { (self.functions.free)(self.component) };
    }
}
