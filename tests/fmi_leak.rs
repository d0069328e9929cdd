//! Memory over many instances and states; alone in its process, so that nothing else allocates.
#![cfg(target_os = "linux")]

use stickslip_tests::slave::{OK, Slave};

/// Resident memory of this process in kB.
fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|l| l.starts_with("VmRSS")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}

#[test]
fn nothing_leaks() {
    let cycle = || {
        let slave = Slave::new();
        assert_eq!(slave.set("third_mode.frequency", 1404.0), OK);
        slave.start_at(0.0);
        assert_eq!(slave.step(0.0, 5e-3), OK);
        let mut state = slave.state();
        let bytes = slave.serialize(state);
        let mut copy = slave.deserialize(&bytes).unwrap();
        assert_eq!(slave.set_state(copy), OK);
        slave.free_state(&mut copy);
        slave.free_state(&mut state);
    };
    (0..200).for_each(|_| cycle());
    let before = resident();
    (0..2000).for_each(|_| cycle());
    let grown = resident().saturating_sub(before);
    // A leaked instance or state would be 20 kB.
    assert!(grown < 4_000, "{grown} kB");
}
