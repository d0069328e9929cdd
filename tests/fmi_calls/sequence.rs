//! The state machines of the calling sequence (FMI 2.0.5, sections 3.2.3 and 4.2.4), function by function.

use std::ffi::{c_char, c_int, c_void};
use std::ptr;
use stickslip_tests::exchange::{EventInfo, INDICATORS, STATES};
use stickslip_tests::slave::{ERROR, OK, Slave, function};
use stickslip_tests::variables::reference;

/// An instance in each phase that a master can bring about.
fn in_phase(phase: &str) -> Slave {
    let slave = Slave::new();
    match phase {
        "instantiated" => {}
        "initialization" => assert_eq!(slave.enter(), OK),
        "ready" => slave.start_at(0.0),
        "stepped" => {
            slave.start_at(0.0);
            assert_eq!(slave.step(0.0, 1e-3), OK);
        }
        "terminated" => {
            slave.start_at(0.0);
            assert_eq!(slave.terminate(), OK);
        }
        other => return in_exchange(other),
    }
    slave
}

/// An instance for model exchange in each phase.
fn in_exchange(phase: &str) -> Slave {
    let slave = Slave::new_exchange();
    if phase == "exchange: instantiated" {
        return slave;
    }
    assert_eq!(slave.enter(), OK);
    if phase == "exchange: initialization" {
        return slave;
    }
    assert_eq!(slave.exit(), OK);
    match phase {
        "event" => {}
        "continuous" => assert_eq!(slave.plain_call("fmi2EnterContinuousTimeMode"), OK),
        "exchange: terminated" => assert_eq!(slave.terminate(), OK),
        other => panic!("{other}"),
    }
    slave
}

/// Function, a legal call of it apart from the phase, and the phases where the standard allows it.
type Row = (&'static str, fn(&Slave) -> c_int, &'static [&'static str]);

const PHASES: [&str; 10] = [
    "instantiated",
    "initialization",
    "ready",
    "stepped",
    "terminated",
    "exchange: instantiated",
    "exchange: initialization",
    "event",
    "continuous",
    "exchange: terminated",
];
const BEFORE: &[&str] = &["instantiated", "exchange: instantiated"];
const START: &[&str] = &["initialization", "exchange: initialization"];
const RUN: &[&str] = &["ready", "stepped"];
const BOTH_RUN: &[&str] = &["ready", "stepped", "event", "continuous"];
const READ: &[&str] = &[
    "initialization",
    "ready",
    "stepped",
    "terminated",
    "exchange: initialization",
    "event",
    "continuous",
    "exchange: terminated",
];
const WRITE: &[&str] = &[
    "instantiated",
    "initialization",
    "ready",
    "stepped",
    "exchange: instantiated",
    "exchange: initialization",
    "event",
    "continuous",
];
/// Tunable parameters change at communication points and events.
const TUNE: &[&str] = &[
    "instantiated",
    "initialization",
    "ready",
    "stepped",
    "exchange: instantiated",
    "exchange: initialization",
    "event",
];
const RATES: &[&str] = &["instantiated", "initialization", "ready", "stepped"];
const STATUS: &[&str] = &["ready", "stepped", "terminated"];
const EVENT: &[&str] = &["event"];
const CONTINUOUS: &[&str] = &["continuous"];
const INTEGRATED: &[&str] = &["event", "continuous"];
const DERIVATIVES: &[&str] = &["event", "continuous", "exchange: terminated"];
const INSTANTS: &[&str] = &[
    "exchange: initialization",
    "event",
    "continuous",
    "exchange: terminated",
];
const NOMINALS: &[&str] = &[
    "exchange: instantiated",
    "exchange: initialization",
    "event",
    "continuous",
    "exchange: terminated",
];

fn status<T>(name: &str, slave: &Slave, kind: c_int, mut value: T) -> c_int {
    // SAFETY: the types are those of the standard.
    unsafe {
        function::<unsafe extern "C" fn(*mut c_void, c_int, *mut T) -> c_int>(name)(
            slave.component,
            kind,
            &raw mut value,
        )
    }
}

const TABLE: &[Row] = &[
    ("fmi2SetupExperiment", |s| s.setup(0.0), BEFORE),
    ("fmi2EnterInitializationMode", Slave::enter, BEFORE),
    ("fmi2ExitInitializationMode", Slave::exit, START),
    ("fmi2Terminate", Slave::terminate, BOTH_RUN),
    ("fmi2Reset", Slave::reset, &PHASES),
    ("fmi2DoStep", |s| s.step(point(s), 1e-3), RUN),
    ("fmi2SetReal", |s| s.set("belt_velocity", 0.1), WRITE),
    (
        "fmi2GetReal",
        |s| s.get_into(&[reference("tip_velocity")], &mut [0.0]),
        READ,
    ),
    (
        "fmi2SetRealInputDerivatives",
        |s| s.set_rate("belt_velocity", 1, 0.0),
        RATES,
    ),
    ("fmi2SetReal", |s| s.set("friction.level", 1.0), TUNE),
    (
        "fmi2GetDirectionalDerivative",
        |s| {
            let (unknown, known) = (reference("friction_force"), reference("normal_force"));
            s.directional(&[unknown], &[known], &[1.0], &mut [0.0])
        },
        READ,
    ),
    (
        "fmi2EnterEventMode",
        |s| s.plain_call("fmi2EnterEventMode"),
        INTEGRATED,
    ),
    (
        "fmi2NewDiscreteStates",
        |s| s.new_discrete_states_into(&mut EventInfo::default()),
        EVENT,
    ),
    (
        "fmi2EnterContinuousTimeMode",
        |s| s.plain_call("fmi2EnterContinuousTimeMode"),
        EVENT,
    ),
    (
        "fmi2CompletedIntegratorStep",
        |s| completed(s.component),
        CONTINUOUS,
    ),
    ("fmi2SetTime", |s| s.set_time(0.0), INTEGRATED),
    (
        "fmi2SetContinuousStates",
        |s| s.set_states(&vec![0.0; STATES.len()]),
        CONTINUOUS,
    ),
    (
        "fmi2GetDerivatives",
        |s| s.fill("fmi2GetDerivatives", &mut vec![0.0; STATES.len()]),
        DERIVATIVES,
    ),
    (
        "fmi2GetEventIndicators",
        |s| s.fill("fmi2GetEventIndicators", &mut [0.0; INDICATORS]),
        INSTANTS,
    ),
    (
        "fmi2GetContinuousStates",
        |s| s.fill("fmi2GetContinuousStates", &mut vec![0.0; STATES.len()]),
        INSTANTS,
    ),
    (
        "fmi2GetNominalsOfContinuousStates",
        |s| {
            s.fill(
                "fmi2GetNominalsOfContinuousStates",
                &mut vec![0.0; STATES.len()],
            )
        },
        NOMINALS,
    ),
    (
        "fmi2GetRealOutputDerivatives",
        |s| s.rate_into("tip_velocity", 1, &mut 0.0),
        STATUS,
    ),
    (
        "fmi2GetStatus",
        |s| status("fmi2GetStatus", s, 0, 0_i32),
        STATUS,
    ),
    (
        "fmi2GetRealStatus",
        |s| status("fmi2GetRealStatus", s, 2, 0.0_f64),
        STATUS,
    ),
    (
        "fmi2GetBooleanStatus",
        |s| status("fmi2GetBooleanStatus", s, 3, 0_i32),
        STATUS,
    ),
    (
        "fmi2GetStringStatus",
        |s| status("fmi2GetStringStatus", s, 1, ptr::null::<c_char>()),
        STATUS,
    ),
];

fn completed(component: *mut c_void) -> c_int {
    type Call = unsafe extern "C" fn(*mut c_void, c_int, *mut c_int, *mut c_int) -> c_int;
    let (mut event, mut end) = (-1, -1);
    // SAFETY: the types are those of the standard.
    let status = unsafe {
        function::<Call>("fmi2CompletedIntegratorStep")(component, 1, &mut event, &mut end)
    };
    if status == OK {
        assert_eq!((event, end), (0, 0));
    }
    status
}

/// The communication point of an instance in one of the phases above.
fn point(slave: &Slave) -> f64 {
    let time = slave.last_successful_time().unwrap_or(0.0);
    slave.messages();
    time
}

#[test]
fn every_call_in_every_phase_is_done_or_refused_with_a_message() {
    for (name, call, legal) in TABLE {
        for phase in PHASES {
            let slave = in_phase(phase);
            let status = call(&slave);
            if legal.contains(&phase) {
                assert_eq!(status, OK, "{name} in {phase}: {:?}", slave.messages());
            } else {
                assert_eq!(status, ERROR, "{name} in {phase}");
                let text = &slave.messages()[0].text;
                let why = ["phase", "instance made for", "settable at events only"];
                assert!(why.iter().any(|part| text.contains(part)), "{text}");
            }
        }
    }
}

#[test]
fn states_can_be_taken_and_restored_in_every_phase() {
    for phase in PHASES {
        let slave = in_phase(phase);
        let mut state = slave.state();
        assert_eq!(slave.set_state(state), OK, "{phase}");
        assert_eq!(slave.free_state(&mut state), OK, "{phase}");
        assert!(state.is_null());
        assert_eq!(
            slave.free_state(&mut state),
            OK,
            "freeing again does nothing"
        );
    }
}

#[test]
fn a_refused_call_leaves_the_run_as_it_was() {
    let (plain, disturbed) = (Slave::started(), Slave::started());
    for i in 0..200 {
        let point = f64::from(i) * 1e-3;
        assert_eq!(plain.step(point, 1e-3), OK);
        assert_eq!(disturbed.enter(), ERROR);
        assert_eq!(disturbed.setup(1.0), ERROR);
        assert_eq!(disturbed.set("tolerance", 1e-3), ERROR);
        assert_eq!(disturbed.set("belt_velocity", f64::NAN), ERROR);
        assert_eq!(disturbed.step(point, -1e-3), ERROR);
        assert_eq!(disturbed.step(point + 5.0, 1e-3), ERROR);
        assert_eq!(disturbed.step(point, 1e-3), OK);
        assert_eq!(super::results(&plain), super::results(&disturbed));
    }
}

#[test]
fn what_is_not_offered_is_refused_with_a_message() {
    let slave = Slave::started();
    assert_eq!(status("fmi2GetIntegerStatus", &slave, 0, 0_i32), ERROR);
    assert_eq!(status("fmi2GetStatus", &slave, 9, 0_i32), ERROR);
    // SAFETY: the type is that of the standard.
    let cancel: unsafe extern "C" fn(*mut c_void) -> c_int = unsafe { function("fmi2CancelStep") };
    // SAFETY: the handle is live.
    assert_eq!(unsafe { cancel(slave.component) }, ERROR);
    assert_eq!(slave.messages().len(), 3);
}

#[test]
fn every_function_survives_a_null_component() {
    let nothing: *mut c_void = ptr::null_mut();
    // SAFETY: NULL handles must be refused; all other arguments are unused then.
    unsafe {
        for name in [
            "fmi2EnterInitializationMode",
            "fmi2ExitInitializationMode",
            "fmi2Terminate",
            "fmi2Reset",
            "fmi2CancelStep",
        ] {
            let call: unsafe extern "C" fn(*mut c_void) -> c_int = function(name);
            assert_eq!(call(nothing), ERROR, "{name}");
        }
        for name in [
            "fmi2GetReal",
            "fmi2GetInteger",
            "fmi2GetBoolean",
            "fmi2GetString",
            "fmi2SetReal",
            "fmi2SetInteger",
            "fmi2SetBoolean",
            "fmi2SetString",
        ] {
            type Access =
                unsafe extern "C" fn(*mut c_void, *const u32, usize, *mut c_void) -> c_int;
            let call = function::<Access>(name);
            assert_eq!(call(nothing, ptr::null(), 0, nothing), ERROR, "{name}");
        }
        let step: unsafe extern "C" fn(*mut c_void, f64, f64, c_int) -> c_int =
            function("fmi2DoStep");
        assert_eq!(step(nothing, 0.0, 1.0, 1), ERROR);
    }
}

#[test]
fn null_arguments_are_refused_with_a_message() {
    let slave = Slave::started();
    let vr = [reference("tip_velocity")];
    type Access = unsafe extern "C" fn(*mut c_void, *const u32, usize, *mut f64) -> c_int;
    // SAFETY: NULL is what is tested; lengths of 0 announce nothing.
    unsafe {
        for name in ["fmi2GetReal", "fmi2SetReal"] {
            let call = function::<Access>(name);
            let mut value = 0.1;
            assert_eq!(call(slave.component, ptr::null(), 1, &mut value), ERROR);
            assert_eq!(
                call(slave.component, vr.as_ptr(), 1, ptr::null_mut()),
                ERROR
            );
            assert_eq!(call(slave.component, ptr::null(), 0, ptr::null_mut()), OK);
        }
    }
    assert_eq!(status_null(&slave, "fmi2GetRealStatus"), ERROR);
    assert_eq!(slave.set_state(ptr::null_mut()), ERROR);
    let texts: Vec<_> = slave.messages().into_iter().map(|m| m.text).collect();
    assert_eq!(texts.len(), 6);
    assert!(
        texts.iter().all(|text| text.contains("is NULL")),
        "{texts:?}"
    );
}

fn status_null(slave: &Slave, name: &str) -> c_int {
    // SAFETY: NULL is what is tested.
    unsafe {
        function::<unsafe extern "C" fn(*mut c_void, c_int, *mut c_void) -> c_int>(name)(
            slave.component,
            2,
            ptr::null_mut(),
        )
    }
}
