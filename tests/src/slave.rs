//! The FMU's binary, loaded as a master loads it and called by the names of the standard.
// The tests hand wrong and stale pointers over on purpose, to see them refused.
#![allow(clippy::not_unsafe_ptr_arg_deref)]

use crate::fmu_library;
use crate::variables::{guid, reference};
use libloading::Library;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr;
use std::sync::{Mutex, OnceLock};

/// `fmi2OK`.
pub const OK: c_int = 0;
/// `fmi2Warning`.
pub const WARNING: c_int = 1;
/// `fmi2Discard`.
pub const DISCARD: c_int = 2;
/// `fmi2Error`.
pub const ERROR: c_int = 3;
/// `fmi2Fatal`.
pub const FATAL: c_int = 4;

/// A message that the FMU has logged.
#[derive(Debug, Clone, PartialEq)]
pub struct Message {
    /// Status of the message.
    pub status: c_int,
    /// Its category.
    pub category: String,
    /// Its text.
    pub text: String,
}

/// `fmi2CallbackFunctions`.
#[repr(C)]
pub struct Callbacks {
    /// The logger as a bare address, since Rust can't define variadic functions.
    pub logger: *const c_void,
    /// Unused.
    pub allocate: *const c_void,
    /// Unused.
    pub free: *const c_void,
    /// Unused.
    pub step_finished: *const c_void,
    /// Handed to the logger.
    pub environment: *mut c_void,
}

/// Takes "%s" and its one argument; on the platforms tested a variadic call passes these as a plain
/// call would.
extern "C" fn keep(
    environment: *mut c_void,
    _instance: *const c_char,
    status: c_int,
    category: *const c_char,
    format: *const c_char,
    text: *const c_char,
) {
    // SAFETY: the environment is the list below, which lives as long as the slave.
    let list = unsafe { &*environment.cast::<Mutex<Vec<Message>>>() };
    // SAFETY: the FMU passes terminated strings.
    let read = |p: *const c_char| unsafe { CStr::from_ptr(p) }.to_string_lossy().into_owned();
    assert_eq!(read(format), "%s");
    list.lock().expect("no panic while locked").push(Message {
        status,
        category: read(category),
        text: read(text),
    });
}

/// The library, loaded once.
pub fn library() -> &'static Library {
    static LIBRARY: OnceLock<Library> = OnceLock::new();
    // SAFETY: the FMU's binary has no initialisers of its own.
    LIBRARY.get_or_init(|| unsafe { Library::new(fmu_library()) }.expect("the FMU is built"))
}

/// An exported function.
///
/// # Safety
/// `T` is the function's type in the standard.
pub unsafe fn function<T: Copy>(name: &str) -> T {
    // SAFETY: by contract.
    *unsafe { library().get::<T>(name.as_bytes()) }.unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// Calls an exported function whose arguments are given with their types.
macro_rules! call {
    ($name:literal $(, $value:expr => $type:ty)* $(,)?) => {{
        // SAFETY: the types written at each place of use are those of the standard.
        unsafe { function::<unsafe extern "C" fn($($type),*) -> c_int>($name)($($value),*) }
    }};
}

type Get = unsafe extern "C" fn(*mut c_void, *const u32, usize, *mut f64) -> c_int;
type Step = unsafe extern "C" fn(*mut c_void, f64, f64, c_int) -> c_int;

/// One instance.
pub struct Slave {
    /// The handle, for calls with arguments that no wrapper offers.
    pub component: *mut c_void,
    messages: Box<Mutex<Vec<Message>>>,
    _callbacks: Box<Callbacks>,
    get_real: Get,
    do_step: Step,
}

// SAFETY: one instance may be used by any one thread at a time.
unsafe impl Send for Slave {}

impl Slave {
    /// A fresh instance.
    pub fn new() -> Self {
        Self::instantiate("test", 1, Some(guid()), None, 0).expect("a legal call")
    }

    /// `fmi2Instantiate` with any arguments; the messages where it gives NULL.
    ///
    /// # Errors
    /// The messages logged.
    pub fn instantiate(
        name: &str,
        kind: c_int,
        guid: Option<&str>,
        resources: Option<&str>,
        logging: c_int,
    ) -> Result<Self, Vec<Message>> {
        let messages = Box::new(Mutex::new(Vec::new()));
        let callbacks = Box::new(Callbacks {
            logger: keep as *const c_void,
            allocate: ptr::null(),
            free: ptr::null(),
            step_finished: ptr::null(),
            environment: ptr::from_ref(&*messages).cast_mut().cast(),
        });
        let text = |t: Option<&str>| t.map(|t| CString::new(t).expect("no zero byte"));
        let address = |t: &Option<CString>| t.as_ref().map_or(ptr::null(), |t| t.as_ptr());
        let (name, guid, resources) = (text(Some(name)), text(guid), text(resources));
        type Instantiate = unsafe extern "C" fn(
            *const c_char,
            c_int,
            *const c_char,
            *const c_char,
            *const Callbacks,
            c_int,
            c_int,
        ) -> *mut c_void;
        // SAFETY: the types are those of the standard; all arguments outlive the call.
        let component = unsafe {
            function::<Instantiate>("fmi2Instantiate")(
                address(&name),
                kind,
                address(&guid),
                address(&resources),
                &raw const *callbacks,
                0,
                logging,
            )
        };
        if component.is_null() {
            return Err(messages.into_inner().expect("no panic while locked"));
        }
        Ok(Self {
            component,
            messages,
            _callbacks: callbacks,
            // SAFETY: the types are those of the standard.
            get_real: unsafe { function("fmi2GetReal") },
            // SAFETY: as above.
            do_step: unsafe { function("fmi2DoStep") },
        })
    }

    /// An instance that is ready for its first step.
    pub fn started() -> Self {
        let slave = Self::new();
        slave.start_at(0.0);
        slave
    }

    /// Experiment from `time` in s on, and initialisation.
    pub fn start_at(&self, time: f64) {
        assert_eq!(self.setup(time), OK);
        assert_eq!(self.enter(), OK);
        assert_eq!(self.exit(), OK, "{:?}", self.messages());
    }

    /// The messages so far, which are then forgotten.
    pub fn messages(&self) -> Vec<Message> {
        std::mem::take(&mut *self.messages.lock().expect("no panic while locked"))
    }

    /// `fmi2SetupExperiment` with nothing but a start time in s.
    pub fn setup(&self, time: f64) -> c_int {
        self.experiment(None, time, None)
    }

    /// `fmi2SetupExperiment`; times in s.
    pub fn experiment(&self, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> c_int {
        call!("fmi2SetupExperiment",
            self.component => *mut c_void,
            c_int::from(tolerance.is_some()) => c_int, tolerance.unwrap_or(f64::NAN) => f64,
            start => f64,
            c_int::from(stop.is_some()) => c_int, stop.unwrap_or(f64::NAN) => f64)
    }

    /// `fmi2EnterInitializationMode`.
    pub fn enter(&self) -> c_int {
        call!("fmi2EnterInitializationMode", self.component => *mut c_void)
    }

    /// `fmi2ExitInitializationMode`.
    pub fn exit(&self) -> c_int {
        call!("fmi2ExitInitializationMode", self.component => *mut c_void)
    }

    /// `fmi2Terminate`.
    pub fn terminate(&self) -> c_int {
        call!("fmi2Terminate", self.component => *mut c_void)
    }

    /// `fmi2Reset`.
    pub fn reset(&self) -> c_int {
        call!("fmi2Reset", self.component => *mut c_void)
    }

    /// `fmi2DoStep` from `point` over `step`, in s.
    pub fn step(&self, point: f64, step: f64) -> c_int {
        // SAFETY: the handle is live.
        unsafe { (self.do_step)(self.component, point, step, 1) }
    }

    /// `fmi2GetReal` by value reference.
    pub fn get_into(&self, references: &[u32], values: &mut [f64]) -> c_int {
        assert_eq!(references.len(), values.len());
        // SAFETY: the handle is live, the lengths agree.
        unsafe {
            (self.get_real)(
                self.component,
                references.as_ptr(),
                references.len(),
                values.as_mut_ptr(),
            )
        }
    }

    /// One Real variable.
    pub fn get(&self, name: &str) -> f64 {
        let mut value = [f64::NAN];
        assert_eq!(self.get_into(&[reference(name)], &mut value), OK, "{name}");
        value[0]
    }

    /// One Integer or Enumeration variable.
    pub fn get_integer(&self, name: &str) -> c_int {
        let vr = reference(name);
        let mut value = c_int::MIN;
        let status = call!("fmi2GetInteger",
            self.component => *mut c_void,
            (&raw const vr) => *const u32, 1 => usize,
            &raw mut value => *mut c_int);
        assert_eq!(status, OK, "{name}");
        value
    }

    /// Sets one Real variable.
    pub fn set(&self, name: &str, value: f64) -> c_int {
        self.set_all(&[reference(name)], &[value])
    }

    /// Sets Real variables by value reference.
    pub fn set_all(&self, references: &[u32], values: &[f64]) -> c_int {
        assert_eq!(references.len(), values.len());
        call!("fmi2SetReal",
            self.component => *mut c_void,
            references.as_ptr() => *const u32, references.len() => usize,
            values.as_ptr() => *const f64)
    }

    /// Sets one Integer or Enumeration variable.
    pub fn set_integer(&self, name: &str, value: c_int) -> c_int {
        let vr = reference(name);
        call!("fmi2SetInteger",
            self.component => *mut c_void,
            (&raw const vr) => *const u32, 1 => usize,
            &raw const value => *const c_int)
    }

    /// A get or set function of any type on one variable, with a zero as value.
    pub fn call_on(&self, name: &str, vr: u32) -> c_int {
        let mut value = [0_u64];
        // SAFETY: a value of eight bytes has room for every type of the standard.
        unsafe {
            function::<unsafe extern "C" fn(*mut c_void, *const u32, usize, *mut u64) -> c_int>(
                name,
            )(self.component, &raw const vr, 1, value.as_mut_ptr())
        }
    }

    /// Sets the rate of an input, per s, for the next step.
    pub fn set_rate(&self, name: &str, order: c_int, value: f64) -> c_int {
        let vr = reference(name);
        call!("fmi2SetRealInputDerivatives",
            self.component => *mut c_void,
            (&raw const vr) => *const u32, 1 => usize,
            &raw const order => *const c_int, &raw const value => *const f64)
    }

    /// The rate of an output, per s.
    pub fn rate(&self, name: &str) -> f64 {
        let mut value = f64::NAN;
        assert_eq!(self.rate_into(name, 1, &mut value), OK, "{name}");
        value
    }

    /// `fmi2GetRealOutputDerivatives` of one output.
    pub fn rate_into(&self, name: &str, order: c_int, value: &mut f64) -> c_int {
        let vr = reference(name);
        call!("fmi2GetRealOutputDerivatives",
            self.component => *mut c_void,
            (&raw const vr) => *const u32, 1 => usize,
            (&raw const order) => *const c_int, value => *mut f64)
    }

    /// The rates of several outputs, per s.
    pub fn rates_into(&self, references: &[u32], values: &mut [f64]) -> c_int {
        assert_eq!(references.len(), values.len());
        let orders: Vec<c_int> = vec![1; references.len()];
        call!("fmi2GetRealOutputDerivatives",
            self.component => *mut c_void,
            references.as_ptr() => *const u32, references.len() => usize,
            orders.as_ptr() => *const c_int, values.as_mut_ptr() => *mut f64)
    }

    /// `fmi2GetRealStatus(fmi2LastSuccessfulTime)` in s, where it is legal.
    pub fn last_successful_time(&self) -> Option<f64> {
        let mut time = f64::NAN;
        let status = call!("fmi2GetRealStatus",
            self.component => *mut c_void, 2 => c_int, (&raw mut time) => *mut f64);
        (status == OK).then_some(time)
    }

    /// `fmi2SetDebugLogging`.
    pub fn debug_logging(&self, on: bool, categories: &[&CStr]) -> c_int {
        let list: Vec<_> = categories.iter().map(|c| c.as_ptr()).collect();
        call!("fmi2SetDebugLogging",
            self.component => *mut c_void, c_int::from(on) => c_int,
            list.len() => usize, list.as_ptr() => *const *const c_char)
    }

    /// A copy of the state; free it with [`Slave::free_state`].
    pub fn state(&self) -> *mut c_void {
        let mut state = ptr::null_mut();
        assert_eq!(self.state_into(&mut state), OK);
        state
    }

    /// `fmi2GetFMUstate`.
    pub fn state_into(&self, state: &mut *mut c_void) -> c_int {
        call!("fmi2GetFMUstate", self.component => *mut c_void, state => *mut *mut c_void)
    }

    /// `fmi2SetFMUstate`.
    pub fn set_state(&self, state: *mut c_void) -> c_int {
        call!("fmi2SetFMUstate", self.component => *mut c_void, state => *mut c_void)
    }

    /// `fmi2FreeFMUstate`.
    pub fn free_state(&self, state: &mut *mut c_void) -> c_int {
        call!("fmi2FreeFMUstate", self.component => *mut c_void, state => *mut *mut c_void)
    }

    /// Bytes of a state.
    pub fn serialize(&self, state: *mut c_void) -> Vec<u8> {
        let mut size = 0_usize;
        let status = call!("fmi2SerializedFMUstateSize",
            self.component => *mut c_void, state => *mut c_void, &raw mut size => *mut usize);
        assert_eq!(status, OK);
        let mut bytes = vec![0_u8; size];
        let status = call!("fmi2SerializeFMUstate",
            self.component => *mut c_void, state => *mut c_void,
            bytes.as_mut_ptr().cast() => *mut c_char, size => usize);
        assert_eq!(status, OK);
        bytes
    }

    /// `fmi2DeSerializeFMUstate`: the state or the status.
    ///
    /// # Errors
    /// The status that is not OK.
    pub fn deserialize(&self, bytes: &[u8]) -> Result<*mut c_void, c_int> {
        let mut state = ptr::null_mut();
        let status = call!("fmi2DeSerializeFMUstate",
            self.component => *mut c_void, bytes.as_ptr().cast() => *const c_char,
            bytes.len() => usize, &raw mut state => *mut *mut c_void);
        if status == OK { Ok(state) } else { Err(status) }
    }
}

impl Default for Slave {
    fn default() -> Self {
        Self::new()
    }
}

impl Drop for Slave {
    fn drop(&mut self) {
        // SAFETY: the handle is freed once.
        unsafe {
            function::<unsafe extern "C" fn(*mut c_void)>("fmi2FreeInstance")(self.component);
        }
    }
}
