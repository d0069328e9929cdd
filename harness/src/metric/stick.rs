//! Where a measured motion sticks to the belt.

use super::amplitude::standard_deviation;
use super::rest::{rest, velocity_from_rest};
use super::velocity::velocity;

/// Stick and slip of a displacement record.
#[derive(Debug, Clone)]
pub struct StickDetection {
    /// For each sample, whether the tip moves with the belt.
    pub sticks: Vec<bool>,
    /// Velocity, measured or from the displacement, m/s.
    pub velocity: Vec<f64>,
    /// Half width of the band around the belt velocity that counts as stick, m/s.
    pub tolerance: f64,
}

/// Smallest band, as a share of the belt velocity or of the motion's velocity, whichever is larger.
const NARROWEST: f64 = 0.03;
/// The band in standard deviations of the velocity's noise.
const NOISE_BAND: f64 = 3.0;
/// Longest smoothing, s: a quarter period of the second mode (510 Hz) of the nominal beam.
const LONGEST_SMOOTHING: f64 = 5e-4;

/// Finds stick: the tip's velocity stays within a band around `belt_velocity` (m/s).
///
/// ```text
/// stick:  |v_i - v_belt| <= max(0.03 max(|v_belt|, rms v), 3 s_v),   s_v = (s/dt) sqrt(3 / (h (h+1) (2h+1)))
/// ```
///
/// `noise` s is the standard deviation of the displacement (m), dt the sample interval (s), v by [`velocity`] with half
/// width h. Single samples are decided by their neighbours. A motion that passes the belt velocity at its own velocity
/// maximum is taken for stick while it is inside the band; use the contact mode where a model gives one.
pub fn detect_stick(
    time: &[f64],
    displacement: &[f64],
    belt_velocity: f64,
    noise: f64,
) -> StickDetection {
    let n = time.len();
    let interval = (time[n - 1] - time[0]) / (n - 1) as f64;
    let half_width = ((LONGEST_SMOOTHING / interval) as usize).clamp(2, 50);
    let velocity = velocity(time, displacement, half_width);
    let h = half_width as f64;
    let velocity_noise = noise / interval * (3.0 / (h * (h + 1.0) * (2.0 * h + 1.0))).sqrt();
    let rms = (velocity.iter().map(|v| v * v).sum::<f64>() / n as f64).sqrt();
    let tolerance = (NARROWEST * belt_velocity.abs().max(rms)).max(NOISE_BAND * velocity_noise);
    within(velocity, belt_velocity, tolerance)
}

/// The same from a measured `velocity` (m/s), whose noise has the standard deviation `noise` (m/s): v_i is measured, and
/// s_v is the noise.
pub fn measured_stick(velocity: &[f64], belt_velocity: f64, noise: f64) -> StickDetection {
    let squares: f64 = velocity.iter().map(|v| v * v).sum();
    let rms = (squares / velocity.len() as f64).sqrt();
    let tolerance = (NARROWEST * belt_velocity.abs().max(rms)).max(NOISE_BAND * noise);
    within(velocity.to_vec(), belt_velocity, tolerance)
}

/// The same from a measured `acceleration` (m/s^2) over `time` (s), whose noise has the standard deviation `noise` (m/s^2): stick
/// is where it rests ([`rest`]) for half a period of the second mode of the nominal beam, the velocity there the belt's, and
/// elsewhere what it becomes from there ([`velocity_from_rest`]). A model's record without noise rests within a hundredth of its
/// standard deviation.
pub fn resting_stick(
    time: &[f64],
    acceleration: &[f64],
    belt_velocity: f64,
    noise: f64,
) -> StickDetection {
    let n = time.len();
    let interval = (time[n - 1] - time[0]) / (n - 1) as f64;
    let shortest = (2.0 * LONGEST_SMOOTHING / interval).round() as usize;
    let resolved = noise.max(NARROWEST / NOISE_BAND * standard_deviation(acceleration));
    let found = rest(acceleration, resolved, shortest);
    let mut velocity = velocity_from_rest(time, acceleration, found.as_ref());
    if found.is_some() {
        velocity.iter_mut().for_each(|v| *v += belt_velocity);
    }
    let rms = (velocity.iter().map(|v| v * v).sum::<f64>() / n as f64).sqrt();
    StickDetection {
        sticks: found.map_or_else(|| vec![false; n], |rest| rest.on),
        velocity,
        tolerance: NARROWEST * belt_velocity.abs().max(rms),
    }
}

/// Stick where the velocity is within a band around the belt's.
fn within(velocity: Vec<f64>, belt_velocity: f64, tolerance: f64) -> StickDetection {
    let raw: Vec<bool> = velocity
        .iter()
        .map(|v| (v - belt_velocity).abs() <= tolerance)
        .collect();
    let n = velocity.len();
    let sticks = (0..n)
        .map(|i| majority(&raw[i.saturating_sub(2)..(i + 3).min(n)]))
        .collect();
    StickDetection {
        sticks,
        velocity,
        tolerance,
    }
}

fn majority(flags: &[bool]) -> bool {
    2 * flags.iter().filter(|f| **f).count() > flags.len()
}

/// Share of time (1) in which `sticks` is true; each sample stands for the interval that follows it.
pub fn stick_fraction(time: &[f64], sticks: &[bool]) -> f64 {
    let total = time[time.len() - 1] - time[0];
    let stuck = time
        .windows(2)
        .zip(sticks)
        .filter(|(_, stick)| **stick)
        .fold(0.0, |sum, (w, _)| sum + w[1] - w[0]);
    stuck / total
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_a_triangle_that_rises_with_the_belt_sticks_while_it_rises() {
        // 60 % of each 30 ms cycle at 0.1 m/s, then a fall at -0.15 m/s.
        let cycle = |t: f64| {
            let phase = t % 0.03;
            if phase < 0.018 {
                0.1 * phase
            } else {
                1.8e-3 - 0.15 * (phase - 0.018)
            }
        };
        let time: Vec<f64> = (0..6000).map(|i| f64::from(i) * 1e-4).collect();
        let values: Vec<f64> = time.iter().map(|t| cycle(*t)).collect();
        let found = detect_stick(&time, &values, 0.1, 1e-7);
        let fraction = stick_fraction(&time, &found.sticks);
        assert!((fraction - 0.6).abs() < 0.04, "{fraction}");
    }
}
