//! What an instance takes of memory, counted by the allocator of this test.
//!
//! Each thread counts for itself: the test runner's own thread allocates when it first waits for a
//! result, which on a busy machine happens while the steps are counted.

use beam_fmu::types::CallbackFunctions;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::ffi::CString;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
    static LIVE: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: everything is handed to the system's allocator as it comes.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
        LIVE.set(LIVE.get().wrapping_add(layout.size()));
        // SAFETY: as asked for by the caller.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        LIVE.set(LIVE.get().wrapping_sub(layout.size()));
        // SAFETY: as asked for by the caller.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const CALLBACKS: CallbackFunctions = CallbackFunctions {
    logger: None,
    allocate_memory: None,
    free_memory: None,
    step_finished: None,
    environment: std::ptr::null_mut(),
};

/// A started instance of the model with this GUID.
fn started(guid: &str) -> beam_fmu::types::Component {
    let guid = CString::new(guid).unwrap();
    // SAFETY: strings and callbacks outlive the call; the handle is valid until it is freed.
    unsafe {
        let component = beam_fmu::fmi2Instantiate(
            c"a".as_ptr(),
            1,
            guid.as_ptr(),
            std::ptr::null(),
            &CALLBACKS,
            0,
            0,
        );
        assert!(!component.is_null());
        assert_eq!(beam_fmu::fmi2EnterInitializationMode(component), 0);
        assert_eq!(beam_fmu::fmi2ExitInitializationMode(component), 0);
        component
    }
}

#[test]
fn steps_and_reads_allocate_nothing_and_an_instance_takes_less_than_50_kb() {
    let drive = beam_model_description::belt_drive::guid();
    for (guid, references) in [
        (beam_model_description::guid(), [10_u32, 13]),
        (drive, [10, 11]),
    ] {
        // Tables that all instances share are made by the first.
        // SAFETY: a valid handle, freed once.
        unsafe { beam_fmu::fmi2FreeInstance(started(guid)) };
        let before = LIVE.get();
        let component = started(guid);
        let step = |k: u32| {
            // SAFETY: a valid handle; arrays of the lengths given.
            unsafe {
                assert_eq!(
                    beam_fmu::fmi2DoStep(component, f64::from(k) * 1e-4, 1e-4, 1),
                    0
                );
                let mut values = [0.0; 2];
                let status =
                    beam_fmu::fmi2GetReal(component, references.as_ptr(), 2, values.as_mut_ptr());
                assert_eq!(status, 0);
            }
        };
        // Through several cycles of stick and slip: what is allocated once, for good, is allocated by then.
        (0..1000).for_each(step);
        let size = LIVE.get() - before;
        let counted = COUNT.get();
        (1000..4000).for_each(step);
        let allocations = COUNT.get() - counted;
        assert!(size < 50_000, "{size} bytes");
        assert_eq!(allocations, 0);
        // SAFETY: a valid handle, freed once.
        unsafe { beam_fmu::fmi2FreeInstance(component) };
        assert_eq!(LIVE.get(), before, "all is given back");
        println!("an instance takes {size} bytes; 3000 steps made {allocations} allocations");
    }
}
