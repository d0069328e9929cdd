//! The belt drive, the second model of the binary, through the C interface.

use stickslip_tests::slave::{ERROR, OK, Slave};

/// Value references.
const FRICTION_FORCE: u32 = 1;
const MOTOR_VELOCITY: u32 = 2;
const BELT_VELOCITY: u32 = 10;
const STRETCH: u32 = 12;
const MASS: u32 = 100;

fn instance(kind: i32) -> Result<Slave, String> {
    let guid = beam_model_description::belt_drive::guid();
    let made = Slave::instantiate("drive", kind, Some(guid), None, 0);
    made.map_err(|messages| format!("{messages:?}"))
}

fn started() -> Slave {
    let slave = instance(1).unwrap();
    slave.start_at(0.0);
    slave
}

fn read(slave: &Slave, reference: u32) -> f64 {
    let mut value = [f64::NAN];
    assert_eq!(slave.get_into(&[reference], &mut value), OK);
    value[0]
}

#[test]
fn val_a_constant_force_stretches_the_belt_as_statics_says() {
    // Truth: at rest against the motor, k x = -F with k = 2e4 N/m, and the belt has the motor's velocity.
    let slave = started();
    assert_eq!(slave.set_all(&[FRICTION_FORCE], &[30.0]), OK);
    assert_eq!(slave.step(0.0, 5.0), OK);
    assert!((read(&slave, STRETCH) + 30.0 / 2e4).abs() < 1e-12);
    assert!((read(&slave, BELT_VELOCITY) - 0.1).abs() < 1e-12);
}

#[test]
fn a_restored_state_goes_on_to_the_bit_also_from_bytes() {
    let slave = started();
    assert_eq!(slave.set_all(&[FRICTION_FORCE], &[20.0]), OK);
    assert_eq!(slave.step(0.0, 1e-3), OK);
    let mut state = slave.state();
    let finish = |slave: &Slave| {
        assert_eq!(slave.step(1e-3, 3e-3), OK);
        read(slave, BELT_VELOCITY).to_bits()
    };
    let first = finish(&slave);
    assert_eq!(slave.set_state(state), OK);
    assert_eq!(finish(&slave), first);
    let bytes = slave.serialize(state);
    let other = instance(1).unwrap();
    let mut copy = other.deserialize(&bytes).unwrap();
    assert_eq!(other.set_state(copy), OK);
    assert_eq!(finish(&other), first);
    assert_eq!(other.deserialize(&bytes[1..]).err(), Some(ERROR));
    other.free_state(&mut copy);
    slave.free_state(&mut state);
}

#[test]
fn states_of_the_beam_and_of_the_drive_are_not_mistaken_for_each_other() {
    let (beam, drive) = (Slave::started(), started());
    let (mut of_beam, mut of_drive) = (beam.state(), drive.state());
    assert_eq!(beam.set_state(of_drive), ERROR);
    assert_eq!(drive.set_state(of_beam), ERROR);
    assert_eq!(
        drive.deserialize(&beam.serialize(of_beam)).err(),
        Some(ERROR)
    );
    assert_eq!(
        beam.deserialize(&drive.serialize(of_drive)).err(),
        Some(ERROR)
    );
    beam.free_state(&mut of_beam);
    drive.free_state(&mut of_drive);
}

#[test]
fn what_the_drive_does_not_offer_is_refused() {
    let text = instance(0).err().unwrap();
    assert!(text.contains("co-simulation only"), "{text}");
    let slave = started();
    let vr = [BELT_VELOCITY];
    assert_eq!(
        slave.directional(&vr, &[FRICTION_FORCE], &[1.0], &mut [0.0]),
        ERROR
    );
    assert_eq!(slave.set_all(&[MASS], &[2.0]), ERROR);
    assert_eq!(slave.set_all(&[BELT_VELOCITY], &[2.0]), ERROR);
    assert_eq!(slave.set_all(&[FRICTION_FORCE], &[f64::NAN]), ERROR);
    assert_eq!(slave.set_all(&[77], &[0.0]), ERROR);
    assert_eq!(slave.step(0.0, f64::NAN), ERROR);
    assert_eq!(slave.step(0.0, 1e-3), OK);
    assert_eq!(slave.reset(), OK);
    assert_eq!(slave.set_all(&[MASS], &[0.0]), ERROR);
    assert_eq!(slave.set_all(&[MASS], &[2.0]), OK);
    assert_eq!(slave.set_all(&[MOTOR_VELOCITY], &[0.2]), OK);
    slave.start_at(0.0);
    assert_eq!(read(&slave, BELT_VELOCITY), 0.2);
}
