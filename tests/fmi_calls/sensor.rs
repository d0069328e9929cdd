//! Outputs of a sensor that looks at the tip or elsewhere.

use stickslip_tests::slave::{OK, Slave};

/// What a sensor reads with these ratios, from the modal coordinates or velocities (`q` or `q_dot`).
fn by_hand(slave: &Slave, ratios: [f64; 2], what: &str) -> f64 {
    let modes = ratios.iter().zip([2.0, -2.0]).zip(1..);
    modes
        .map(|((ratio, tip), j)| ratio * tip * slave.get(&format!("{what}[{j}]")))
        .sum()
}

#[test]
fn a_sensor_reads_the_modes_with_its_ratios_and_at_the_tip_the_tip() {
    for ratios in [[1.0, 1.0], [0.6, -0.5]] {
        let slave = Slave::new();
        for (j, ratio) in ratios.iter().enumerate() {
            let name = format!("mode[{}].sensor_ratio", j + 1);
            assert_eq!(slave.set(&name, *ratio), OK);
        }
        assert_eq!(slave.set("sensor.offset", 2e-4), OK);
        slave.start_at(0.0);
        let (mut time, step) = (0.0, 1e-4);
        let mut speeds = Vec::new();
        for _ in 0..500 {
            assert_eq!(slave.step(time, step), OK);
            time += step;
            let w = slave.get("measured_displacement");
            assert!((w - 2e-4 - by_hand(&slave, ratios, "q")).abs() < 1e-15);
            let v = slave.get("measured_velocity");
            assert!((v - by_hand(&slave, ratios, "q_dot")).abs() < 1e-13);
            if ratios == [1.0, 1.0] {
                assert_eq!(v, slave.get("tip_velocity"));
                let a = slave.get("measured_acceleration");
                assert_eq!(a, slave.get("tip_acceleration"));
            }
            speeds.push((v, slave.get("measured_acceleration")));
        }
        // The acceleration is the slope of the velocity, but where friction jumps.
        let slope = |w: &[(f64, f64)]| (w[2].0 - w[0].0) / (2.0 * step);
        let largest = speeds.iter().fold(0.0, |a: f64, s| a.max(s.1.abs()));
        let near = speeds
            .windows(3)
            .filter(|w| (slope(w) - w[1].1).abs() < 0.05 * largest);
        assert!(near.count() > 450);
    }
}

#[test]
fn a_slow_sensor_follows_what_moves_where_it_looks() {
    let tau = 1e-4;
    let slave = Slave::new();
    assert_eq!(slave.set("mode[1].sensor_ratio", 0.5), OK);
    assert_eq!(slave.set("mode[2].sensor_ratio", -0.7), OK);
    assert_eq!(slave.set("sensor_lag.time_constant", tau), OK);
    slave.start_at(0.0);
    // tau y' = w_s - y by the trapezoidal rule, from what the sensor reads first.
    let (mut time, step) = (0.0, 2e-6);
    let seen = |slave: &Slave| by_hand(slave, [0.5, -0.7], "q");
    let (mut y, mut before) = (slave.get("measured_displacement"), seen(&slave));
    let mut largest = 0.0_f64;
    for _ in 0..5000 {
        assert_eq!(slave.step(time, step), OK);
        time += step;
        let now = seen(&slave);
        let share = 0.5 * step / tau;
        y = ((1.0 - share) * y + share * (before + now)) / (1.0 + share);
        before = now;
        largest = largest.max(now.abs());
        let off = (slave.get("measured_displacement") - y).abs();
        assert!(off < 1e-4 * largest.max(1e-6), "{off} at {time}");
    }
}
