//! The FMU in hosts that are set up in unusual ways. Each in a process of its own: what goes wrong there would take the
//! other tests along.
#![cfg(target_os = "linux")]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::Path;
use std::process::Command;
use stickslip_tests::exchange::Integration;
use stickslip_tests::fmu_library;
use stickslip_tests::slave::{Callbacks, OK, Slave};
use stickslip_tests::variables::{guid, reference};

/// Runs one of the tests marked `ignore` below in another process.
fn in_a_process_of_its_own(test: &str) {
    in_a_process_of_its_own_with(test, &[]);
}

/// The same with paths in the environment.
fn in_a_process_of_its_own_with(test: &str, environment: &[(&str, &Path)]) {
    let out = Command::new(std::env::current_exe().unwrap())
        .envs(environment.iter().copied())
        .args([
            "--exact",
            test,
            "--ignored",
            "--test-threads=1",
            "--nocapture",
        ])
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&out.stdout);
    assert!(
        out.status.success() && text.contains("1 passed"),
        "{test}: {}\n{text}{}",
        out.status,
        String::from_utf8_lossy(&out.stderr)
    );
}

/// Displacement at the end of runs with stick, slip and effects, in both interfaces.
fn motion() -> [u64; 3] {
    let plain = Slave::started();
    let rich = Slave::new();
    for (name, value) in [
        ("third_mode.frequency", 1404.0),
        ("belt_drive_compliance.mass", 2.0),
        ("belt_drive_compliance.stiffness", 8e4),
        ("static_friction_aging.gain", 0.1),
        ("sensor_lag.time_constant", 1e-4),
    ] {
        assert_eq!(rich.set(name, value), OK);
    }
    rich.start_at(0.0);
    for i in 0..60 {
        let point = f64::from(i) * 1e-3;
        assert_eq!((plain.step(point, 1e-3), rich.step(point, 1e-3)), (OK, OK));
    }
    let exchange = Slave::started_exchange(&[]);
    Integration::new(&exchange, 0.0, &|_, _| {}).run(0.02, 1e-5);
    [&plain, &rich, &exchange].map(|s| s.get("measured_displacement").to_bits())
}

#[test]
#[ignore = "runs in a process of its own"]
fn host_with_floating_point_exceptions() {
    unsafe extern "C" {
        fn feenableexcept(mask: c_int) -> c_int;
    }
    let expected = motion();
    // SAFETY: a function of the C library; 0x1d is invalid, division by zero, overflow and underflow on x86-64, and
    // of these the first three are enabled.
    unsafe { feenableexcept(0x0d) };
    assert_eq!(motion(), expected);
}

#[test]
fn floating_point_exceptions_enabled_by_the_host_are_not_raised() {
    in_a_process_of_its_own("host_with_floating_point_exceptions");
}

#[test]
#[ignore = "runs in a process of its own"]
fn host_without_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    std::env::set_current_dir(folder.path()).unwrap();
    folder.close().unwrap();
    assert!(std::env::current_dir().is_err(), "the folder is gone");
    motion();
}

#[test]
fn the_current_folder_is_not_needed() {
    in_a_process_of_its_own("host_without_a_folder");
}

#[test]
#[ignore = "runs in a process of its own"]
fn host_with_a_decimal_comma() {
    let expected = motion();
    // SAFETY: a function of the C library with a constant string; the name is found below LOCPATH.
    let set = unsafe { libc::setlocale(libc::LC_ALL, c"comma".as_ptr()) };
    assert!(!set.is_null(), "the locale made for this test is not found");
    let mut written = [0_u8; 8];
    // SAFETY: at most 8 bytes are written; the format takes one double.
    unsafe {
        libc::snprintf(
            written.as_mut_ptr().cast(),
            written.len(),
            c"%.1f".as_ptr(),
            0.5,
        )
    };
    assert_eq!(&written[..4], b"0,5\0", "the C library writes a comma");
    let folder = tempfile::tempdir().unwrap();
    let uri = format!("file://{}", folder.path().display());
    let text = "guid = \"{mine}\"\n[start]\n\"friction.mu_0\" = 0.625\n";
    std::fs::write(folder.path().join("start_values.toml"), text).unwrap();
    let slave = Slave::instantiate("x", 1, Some("{mine}"), Some(&uri), 0);
    let slave = slave.unwrap_or_else(|m| panic!("{m:?}"));
    assert_eq!(slave.enter(), OK);
    assert_eq!(slave.get("friction.mu_0"), 0.625);
    assert_ne!(slave.set("normal_force", -0.5), OK);
    assert!(slave.messages()[0].text.contains("-0.5 N"));
    assert_eq!(motion(), expected);
}

/// Few machines have a locale with a comma installed, so one is made: the C library's own tool compiles it, and
/// `LOCPATH` says where it lies.
#[test]
fn numbers_are_read_and_written_the_same_way_in_every_locale() {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("comma.src");
    std::fs::write(&source, include_str!("peers/comma_locale.txt")).unwrap();
    let made = folder.path().join("comma");
    // localedef warns (exit code 1) of categories that the source copies from POSIX; the file is what counts.
    let tool = Command::new("localedef")
        .args(["--no-archive", "--force", "-i"])
        .arg(&source)
        .args(["-f", "ANSI_X3.4-1968"])
        .arg(&made)
        .output()
        .expect("localedef belongs to the C library");
    assert!(
        made.join("LC_NUMERIC").is_file(),
        "{}",
        String::from_utf8_lossy(&tool.stderr)
    );
    let locales = [("LOCPATH", folder.path())];
    in_a_process_of_its_own_with("host_with_a_decimal_comma", &locales);
}

#[test]
#[ignore = "runs in a process of its own"]
fn host_in_a_folder_that_it_may_not_write() {
    use std::os::unix::fs::PermissionsExt as _;
    let expected = motion();
    let folder = tempfile::tempdir().unwrap();
    let read_only = std::fs::Permissions::from_mode(0o555);
    std::fs::set_permissions(folder.path(), read_only).unwrap();
    std::env::set_current_dir(folder.path()).unwrap();
    // The superuser may write everywhere; another user's rights are what the test is about.
    // SAFETY: functions of the C library; 65534 is nobody, a user without rights.
    unsafe {
        if libc::geteuid() == 0 {
            assert_eq!(libc::seteuid(65534), 0);
        }
    }
    assert!(
        std::fs::write("probe", "").is_err(),
        "the folder is not writable"
    );
    assert_eq!(motion(), expected);
    let files = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(files, 0);
    // SAFETY: as above; back, so that the folder can be removed.
    unsafe { libc::seteuid(libc::getuid()) };
}

#[test]
fn the_current_folder_may_be_read_only() {
    in_a_process_of_its_own("host_in_a_folder_that_it_may_not_write");
}

#[test]
#[ignore = "runs in a process of its own"]
fn host_with_the_binary_loaded_twice() {
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("copy.so");
    std::fs::copy(fmu_library(), &copy).unwrap();
    // SAFETY: the FMU's binary has no initialisers of its own.
    let library = unsafe { libloading::Library::new(&copy) }.unwrap();
    type Instantiate = unsafe extern "C" fn(
        *const c_char,
        c_int,
        *const c_char,
        *const c_char,
        *const Callbacks,
        c_int,
        c_int,
    ) -> *mut c_void;
    let callbacks = Callbacks {
        logger: std::ptr::null(),
        allocate: std::ptr::null(),
        free: std::ptr::null(),
        step_finished: std::ptr::null(),
        environment: std::ptr::null_mut(),
    };
    let id = CString::new(guid()).unwrap();
    let first = Slave::started();
    // SAFETY: the types are those of the standard; the handle is freed once and not used after that.
    unsafe {
        let call = |name: &str| -> unsafe extern "C" fn(*mut c_void) -> c_int {
            *library.get(name.as_bytes()).unwrap()
        };
        let instantiate: Instantiate = *library.get(b"fmi2Instantiate").unwrap();
        let second = instantiate(
            c"b".as_ptr(),
            1,
            id.as_ptr(),
            std::ptr::null(),
            &callbacks,
            0,
            0,
        );
        assert!(!second.is_null());
        assert_eq!(call("fmi2EnterInitializationMode")(second), OK);
        assert_eq!(call("fmi2ExitInitializationMode")(second), OK);
        let step: unsafe extern "C" fn(*mut c_void, f64, f64, c_int) -> c_int =
            *library.get(b"fmi2DoStep").unwrap();
        let get: unsafe extern "C" fn(*mut c_void, *const u32, usize, *mut f64) -> c_int =
            *library.get(b"fmi2GetReal").unwrap();
        let vr = reference("tip_displacement");
        for i in 0..50 {
            let point = f64::from(i) * 1e-3;
            assert_eq!(
                (first.step(point, 1e-3), step(second, point, 1e-3, 1)),
                (OK, OK)
            );
            let mut value = f64::NAN;
            assert_eq!(get(second, &raw const vr, 1, &raw mut value), OK);
            assert_eq!(value, first.get("tip_displacement"));
        }
        let free: unsafe extern "C" fn(*mut c_void) = *library.get(b"fmi2FreeInstance").unwrap();
        free(second);
    }
}

#[test]
fn a_binary_loaded_twice_is_two_fmus() {
    in_a_process_of_its_own("host_with_the_binary_loaded_twice");
}

#[test]
#[ignore = "runs in a process of its own"]
fn host_that_unloads_while_a_thread_lives() {
    let (go, wait) = std::sync::mpsc::channel::<()>();
    let (done, ready) = std::sync::mpsc::channel();
    let thread = std::thread::spawn(move || {
        // SAFETY: the FMU's binary has no initialisers of its own.
        let library = unsafe { libloading::Library::new(fmu_library()) }.unwrap();
        // SAFETY: the type is that of the standard; the string is constant.
        let version = unsafe {
            let call: unsafe extern "C" fn() -> *const c_char =
                *library.get(b"fmi2GetVersion").unwrap();
            CStr::from_ptr(call())
        };
        assert_eq!(version, c"2.0");
        motion();
        done.send(library).unwrap();
        wait.recv().unwrap();
    });
    drop(ready.recv().unwrap());
    go.send(()).unwrap();
    thread.join().unwrap();
}

#[test]
fn unloading_while_a_thread_that_called_is_alive_is_survived() {
    in_a_process_of_its_own("host_that_unloads_while_a_thread_lives");
}

#[test]
#[ignore = "runs in a process of its own"]
fn host_that_frees_in_every_state() {
    for kind in [0, 1] {
        let make = || {
            Slave::instantiate("x", kind, Some(guid()), None, 1).unwrap_or_else(|m| panic!("{m:?}"))
        };
        drop(make());
        let slave = make();
        assert_eq!(slave.enter(), OK);
        drop(slave);
        let slave = make();
        slave.start_at(0.0);
        // The master frees its states after, before, or never.
        let mut state = slave.state();
        assert_eq!(slave.free_state(&mut state), OK);
        drop(slave);
        let slave = make();
        slave.start_at(0.0);
        assert_eq!(slave.terminate(), OK);
        assert_ne!(slave.step(0.0, 1e-3), OK);
        drop(slave);
        let slave = make();
        assert_eq!(slave.set("mode[1].mass", 0.0), OK);
        assert_eq!(slave.enter(), OK);
        assert_ne!(slave.exit(), OK);
    }
}

#[test]
fn an_instance_can_be_freed_in_every_state() {
    in_a_process_of_its_own("host_that_frees_in_every_state");
}
