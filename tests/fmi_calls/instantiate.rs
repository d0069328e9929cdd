//! fmi2Instantiate and fmi2FreeInstance (FMI 2.0.5, section 2.1.5).

use std::ffi::{CString, c_char, c_int, c_void};
use std::ptr;
use stickslip_tests::slave::{Callbacks, OK, Slave, function};
use stickslip_tests::variables::guid;

fn refusal(name: &str, kind: i32, guid: Option<&str>, resources: Option<&str>) -> String {
    let messages = Slave::instantiate(name, kind, guid, resources, 0)
        .err()
        .expect("refused");
    messages.last().expect("explained").text.clone()
}

#[test]
fn wrong_arguments_give_null_and_a_message() {
    assert!(refusal("x", 1, Some("{wrong}"), None).contains("GUID '{wrong}'"));
    assert!(refusal("x", 1, None, None).contains("GUID"));
    assert!(refusal("", 1, Some(guid()), None).contains("instanceName"));
    assert!(refusal("x", 2, Some(guid()), None).contains("co-simulation"));
    assert!(refusal("x", 7, Some(guid()), None).contains("fmuType 7"));
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

#[test]
fn no_callbacks_give_null_and_no_logger_is_fine() {
    let (name, id) = (CString::new("x").unwrap(), CString::new(guid()).unwrap());
    // SAFETY: the types are those of the standard; NULL is what is tested.
    unsafe {
        let instantiate = function::<Instantiate>("fmi2Instantiate");
        let nothing = ptr::null();
        assert!(instantiate(name.as_ptr(), 1, id.as_ptr(), nothing, ptr::null(), 0, 1).is_null());
        assert!(instantiate(ptr::null(), 1, ptr::null(), nothing, ptr::null(), 0, 1).is_null());
        let silent = Callbacks {
            logger: ptr::null(),
            allocate: ptr::null(),
            free: ptr::null(),
            step_finished: ptr::null(),
            environment: ptr::null_mut(),
        };
        let component = instantiate(name.as_ptr(), 1, id.as_ptr(), nothing, &silent, 0, 1);
        assert!(!component.is_null());
        type Step = unsafe extern "C" fn(*mut c_void, f64, f64, c_int) -> c_int;
        assert_eq!(function::<Step>("fmi2DoStep")(component, 0.0, 1.0, 1), 3);
        let free: unsafe extern "C" fn(*mut c_void) = function("fmi2FreeInstance");
        free(component);
        free(ptr::null_mut());
    }
}

#[test]
fn resource_locations_of_all_masters_are_accepted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a folder/Gerät");
    std::fs::create_dir_all(&path).unwrap();
    let plain = path.to_str().unwrap();
    let encoded = plain.replace(' ', "%20").replace('ä', "%C3%A4");
    for uri in [
        None,
        Some(String::new()),
        Some("no uri at all".into()),
        Some("file:///nonexistent/resources".into()),
        Some("https://elsewhere/resources".into()),
        Some(format!("file://{plain}")),
        Some(format!("file://{encoded}/")),
        Some(format!("file:{encoded}")),
        Some(format!("file:///{encoded}")),
        Some(format!("file://localhost{encoded}")),
    ] {
        assert!(
            Slave::instantiate("x", 1, Some(guid()), uri.as_deref(), 0).is_ok(),
            "{uri:?}"
        );
    }
}

#[test]
fn start_values_in_the_resources_replace_the_built_in_ones() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("start_values.toml");
    let uri = format!("file://{}", folder.path().display());
    std::fs::write(
        &file,
        "guid = \"{mine}\"\n[start]\n\"friction.mu_0\" = 0.5\n\"mode[1].frequency\" = 81.5\n",
    )
    .unwrap();
    let slave = Slave::instantiate("x", 1, Some("{mine}"), Some(&uri), 0)
        .unwrap_or_else(|m| panic!("{m:?}"));
    assert_eq!(slave.enter(), OK);
    assert_eq!(slave.get("friction.mu_0"), 0.5);
    assert_eq!(slave.get("mode[1].frequency"), 81.5);
    assert_eq!(slave.get("mode[2].frequency"), 510.0);
    assert_eq!(slave.set("friction.mu_0", 0.6), OK);
    assert_eq!(slave.reset(), OK);
    assert_eq!(slave.enter(), OK);
    assert_eq!(
        slave.get("friction.mu_0"),
        0.5,
        "reset goes back to the calibrated value"
    );
    assert!(refusal("x", 1, Some(guid()), Some(&uri)).contains("GUID"));
    for (text, part) in [
        (
            "guid = \"{mine}\"\n\"friction.mu_0\" = -1",
            "friction.mu_0 = -1",
        ),
        ("guid = \"{mine}\"\nnonsense = 1", "'nonsense'"),
        ("guid = \"{mine}\"\nmode_count = 1.5", "whole number"),
        ("\"friction.mu_0\" = 0.5", "'guid' is missing"),
        ("guid = [", "not valid TOML"),
    ] {
        std::fs::write(&file, text).unwrap();
        let message = refusal("x", 1, Some("{mine}"), Some(&uri));
        assert!(
            message.contains(part) && message.contains("start_values.toml"),
            "{message}"
        );
    }
}

#[test]
fn a_thousand_instances_live_side_by_side() {
    let slaves: Vec<_> = (0..1000).map(|_| Slave::started()).collect();
    for slave in &slaves {
        assert_eq!(slave.step(0.0, 1e-3), OK);
    }
    let first = super::results(&slaves[0]);
    assert!(slaves.iter().all(|slave| super::results(slave) == first));
}

#[test]
fn instances_in_threads_and_across_threads_agree() {
    let expected = {
        let slave = Slave::started();
        super::advance(&slave, 0.0, 1e-3, 300);
        super::results(&slave)
    };
    let threads: Vec<_> = (0..8)
        .map(|_| {
            let slave = Slave::new();
            std::thread::spawn(move || {
                slave.start_at(0.0);
                super::advance(&slave, 0.0, 1e-3, 300);
                slave
            })
        })
        .collect();
    for thread in threads {
        let slave = thread.join().unwrap();
        assert_eq!(super::results(&slave), expected);
    }
}

#[test]
fn the_library_can_be_opened_and_closed_over_and_over() {
    for _ in 0..200 {
        // SAFETY: the FMU's binary has no initialisers of its own.
        let library = unsafe { libloading::Library::new(stickslip_tests::fmu_library()) }.unwrap();
        // SAFETY: the type is that of the standard.
        let version = unsafe {
            library
                .get::<unsafe extern "C" fn() -> *const c_char>("fmi2GetVersion")
                .unwrap()()
        };
        // SAFETY: a constant string.
        let version = unsafe { std::ffi::CStr::from_ptr(version) };
        assert_eq!(version, c"2.0");
        drop(library);
    }
}
