//! Derivatives along a motion, from FMUs that export `stickslipOutputTangents`, or `stickslipDrivenTangents` of one output (ours do;
//! docs/adr/0012-tangents.md).
//!
//! The function is not of the standard, so no FMI crate knows it: the library is opened once more (the system counts the
//! openings) and has an instance of its own here.
#![allow(unsafe_code)]

use super::{Course, Fmu, Loaded, archive};
use libloading::Library;
use std::ffi::{CString, c_char, c_int, c_void};
use std::ptr;
use std::sync::Arc;

/// `fmi2CoSimulation`.
const CO_SIMULATION: c_int = 1;
/// `fmi2OK`.
const OK: c_int = 0;

/// `fmi2CallbackFunctions`; our FMU needs none of them.
#[repr(C)]
struct Callbacks([*const c_void; 5]);

type Instantiate = unsafe extern "C" fn(
    *const c_char,
    c_int,
    *const c_char,
    *const c_char,
    *const Callbacks,
    c_int,
    c_int,
) -> *mut c_void;
type OfComponent = unsafe extern "C" fn(*mut c_void) -> c_int;
type Free = unsafe extern "C" fn(*mut c_void);
type SetReal = unsafe extern "C" fn(*mut c_void, *const u32, usize, *const f64) -> c_int;
type SetInteger = unsafe extern "C" fn(*mut c_void, *const u32, usize, *const c_int) -> c_int;
type Evaluate = unsafe extern "C" fn(
    *mut c_void,
    *const f64,
    usize,
    *const u32,
    usize,
    *const usize,
    usize,
    *const u32,
    *const f64,
    usize,
    *const u32,
    usize,
    *const f64,
    usize,
    *const f64,
    *const f64,
    *mut f64,
    *mut f64,
) -> c_int;
type EvaluateOne = unsafe extern "C" fn(
    *mut c_void,
    *const f64,
    usize,
    u32,
    *const usize,
    usize,
    *const u32,
    *const f64,
    usize,
    *const u32,
    usize,
    *const f64,
    usize,
    *const f64,
    *const f64,
    *mut f64,
    *mut f64,
) -> c_int;

/// How many outputs of a motion an FMU gives at once: one, where it was packed before several could be asked for.
#[derive(Clone, Copy)]
enum Export {
    Several(Evaluate),
    One(EvaluateOne),
}

/// Directions in the space of what is set before a run: each changes some variables by so much.
#[derive(Debug, Default)]
pub struct Directions {
    sizes: Vec<usize>,
    references: Vec<u32>,
    changes: Vec<f64>,
}

impl Directions {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.sizes.clear();
        self.references.clear();
        self.changes.clear();
    }
    /// Adds a direction.
    pub fn push(&mut self, changes: impl IntoIterator<Item = (u32, f64)>) {
        let before = self.references.len();
        for (reference, change) in changes {
            self.references.push(reference);
            self.changes.push(change);
        }
        self.sizes.push(self.references.len() - before);
    }
    /// How many there are.
    pub fn len(&self) -> usize {
        self.sizes.len()
    }
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.sizes.is_empty()
    }
}

/// An instance that gives motions with their derivatives. Belongs to the thread that makes it.
pub struct Tangents {
    component: *mut c_void,
    reset: OfComponent,
    free: Free,
    set_real: SetReal,
    set_integer: SetInteger,
    evaluate: Export,
    // The functions live in the library, and the library in the FMU's folder: both go last, in this order.
    _callbacks: Box<Callbacks>,
    _library: Library,
    _loaded: Arc<Loaded>,
}

impl Tangents {
    /// An instance of `fmu`, or nothing where it does not offer derivatives.
    pub(super) fn new(fmu: &Fmu) -> Option<Self> {
        let (folder, description) = (fmu.folder(), fmu.description());
        let path = archive::binary(folder, &description.model_identifier);
        let text = |t: &str| CString::new(t).ok();
        let resources = text(&format!("file://{}/resources", folder.display()))?;
        let (name, guid) = (text("tangents")?, text(&description.guid)?);
        // SAFETY: the FMU's library, which the other backend has loaded already; its types are those of FMI 2.0 and of
        // the exports that carry these names. The function pointers are kept beside the library.
        unsafe {
            let library = Library::new(path).ok()?;
            let several = library.get::<Evaluate>(b"stickslipOutputTangents");
            let evaluate = match several.map(|several| *several) {
                Ok(several) => Export::Several(several),
                Err(_) => {
                    let one = library.get::<EvaluateOne>(b"stickslipDrivenTangents");
                    Export::One(*one.ok()?)
                }
            };
            let instantiate = *library.get::<Instantiate>(b"fmi2Instantiate").ok()?;
            let reset = *library.get::<OfComponent>(b"fmi2Reset").ok()?;
            let free = *library.get::<Free>(b"fmi2FreeInstance").ok()?;
            let set_real = *library.get::<SetReal>(b"fmi2SetReal").ok()?;
            let set_integer = *library.get::<SetInteger>(b"fmi2SetInteger").ok()?;
            let callbacks = Box::new(Callbacks([ptr::null(); 5]));
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
                return None;
            }
            Some(Self {
                component,
                reset,
                free,
                set_real,
                set_integer,
                evaluate,
                _callbacks: callbacks,
                _library: library,
                _loaded: fmu.loaded.clone(),
            })
        }
    }

    /// Sets everything anew: integers (and enumerations), then reals. False where the FMU refuses.
    ///
    /// # Panics
    /// Lists of different lengths.
    pub fn set(&mut self, integers: (&[u32], &[i32]), reals: (&[u32], &[f64])) -> bool {
        assert_eq!(
            integers.0.len(),
            integers.1.len(),
            "one value per reference"
        );
        assert_eq!(reals.0.len(), reals.1.len(), "one value per reference");
        // SAFETY: the component is live, the lists have the announced lengths.
        unsafe {
            (self.reset)(self.component) == OK
                && (self.set_integer)(
                    self.component,
                    integers.0.as_ptr(),
                    integers.0.len(),
                    integers.1.as_ptr(),
                ) == OK
                && (self.set_real)(
                    self.component,
                    reals.0.as_ptr(),
                    reals.0.len(),
                    reals.1.as_ptr(),
                ) == OK
        }
    }

    /// The outputs at each of the rising `times` in s, the first of which is the start, one after another, and their derivatives,
    /// direction after direction, each as long as `values`, where inputs have a course. False where the FMU can't follow.
    ///
    /// # Panics
    /// Lists of the wrong lengths.
    pub fn evaluate(
        &mut self,
        (times, course): (&[f64], &Course),
        outputs: &[u32],
        directions: &Directions,
        values: &mut [f64],
        slopes: &mut [f64],
    ) -> bool {
        assert_eq!(
            values.len(),
            times.len() * outputs.len(),
            "one value per time and output"
        );
        assert_eq!(
            slopes.len(),
            values.len() * directions.len(),
            "one slope per value and direction"
        );
        let numbers = course.references.len() * course.begins.len();
        assert!(
            course.factors.len() == numbers && course.rates.len() == numbers,
            "one factor and rate per piece and input"
        );
        let (evaluate, d) = (self.evaluate, directions);
        // SAFETY: the component is live, the lists have the announced lengths.
        let status = unsafe {
            match evaluate {
                Export::Several(evaluate) => evaluate(
                    self.component,
                    times.as_ptr(),
                    times.len(),
                    outputs.as_ptr(),
                    outputs.len(),
                    d.sizes.as_ptr(),
                    d.sizes.len(),
                    d.references.as_ptr(),
                    d.changes.as_ptr(),
                    d.changes.len(),
                    course.references.as_ptr(),
                    course.references.len(),
                    course.begins.as_ptr(),
                    course.begins.len(),
                    course.factors.as_ptr(),
                    course.rates.as_ptr(),
                    values.as_mut_ptr(),
                    slopes.as_mut_ptr(),
                ),
                Export::One(evaluate) => {
                    let [output] = outputs else {
                        return false;
                    };
                    evaluate(
                        self.component,
                        times.as_ptr(),
                        times.len(),
                        *output,
                        d.sizes.as_ptr(),
                        d.sizes.len(),
                        d.references.as_ptr(),
                        d.changes.as_ptr(),
                        d.changes.len(),
                        course.references.as_ptr(),
                        course.references.len(),
                        course.begins.as_ptr(),
                        course.begins.len(),
                        course.factors.as_ptr(),
                        course.rates.as_ptr(),
                        values.as_mut_ptr(),
                        slopes.as_mut_ptr(),
                    )
                }
            }
        };
        status == OK
    }
}

impl Drop for Tangents {
    fn drop(&mut self) {
        // SAFETY: made by this library, freed once.
        unsafe { (self.free)(self.component) };
    }
}
