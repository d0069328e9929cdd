//! How effects enter the Taylor series of a motion: their hooks once more, coefficient by coefficient.

use super::{ContactForce, Motion};
use crate::integrate::MAX_DEGREE;
use crate::real::{Real, ZERO, real};

pub use crate::integrate::State;
pub use crate::integrate::series::{
    Series, all_or_nothing, chained, product, quotient, sign_until,
};

/// Registers of [`harmonic`].
pub const HARMONIC_REGISTERS: usize = 2;
/// Registers of [`cosine`].
pub const COSINE_REGISTERS: usize = 3;

/// Coefficient `k` of `cos(angle + rate theta)`.
pub fn harmonic(k: usize, angle: Real, rate: Real, registers: &mut [Series]) -> Real {
    let [cosine, sine, ..] = registers else {
        unreachable!("HARMONIC_REGISTERS")
    };
    if k == 0 {
        (sine[0], cosine[0]) = angle.sin_cos();
    } else {
        let share = rate / k as f64;
        (cosine[k], sine[k]) = (-share * sine[k - 1], share * cosine[k - 1]);
    }
    cosine[k]
}

/// Coefficient `k` of the cosine of a series, of which coefficient `k` is given.
pub fn cosine(k: usize, angle: Real, registers: &mut [Series]) -> Real {
    let [cosine, sine, slope, ..] = registers else {
        unreachable!("COSINE_REGISTERS")
    };
    if k == 0 {
        (sine[0], cosine[0]) = angle.sin_cos();
    } else {
        slope[k] = k as f64 * angle;
        (cosine[k], sine[k]) = (-chained(sine, slope, k), chained(cosine, slope, k));
    }
    cosine[k]
}

/// The motion as power series in `theta = (t - start.time) / unit`, known up to the power that is
/// being worked out. See [`Motion`] for the quantities.
#[derive(Clone)]
pub struct MotionSeries {
    /// Unit of the normalised time in s.
    pub unit: f64,
    /// The motion at the start.
    pub start: Motion,
    /// Tip displacement w in m.
    pub displacement: Series,
    /// Tip velocity w' in m/s.
    pub velocity: Series,
    /// Displacement in m where the sensor looks.
    pub sensor_displacement: Series,
    /// Velocity in m/s where the sensor looks.
    pub sensor_velocity: Series,
    /// Sign of v_r, 0 in stick.
    pub sign: f64,
    /// Sliding speed in m/s.
    pub speed: Series,
    /// Place on the belt in m.
    pub travel: Series,
    /// Normal force in N as given, powers 0 and 1.
    pub normal_force: [Real; 2],
    /// Belt velocity in m/s as given, powers 0 and 1.
    pub given_belt_velocity: [Real; 2],
    /// Whether the contact sticks.
    pub stuck: bool,
}

impl MotionSeries {
    /// No coefficients yet.
    pub fn new(unit: f64, start: Motion) -> Self {
        let none = [ZERO; MAX_DEGREE + 1];
        Self {
            unit,
            start,
            displacement: none,
            velocity: none,
            sensor_displacement: none,
            sensor_velocity: none,
            sign: 0.0,
            speed: none,
            travel: none,
            normal_force: [ZERO; 2],
            given_belt_velocity: [ZERO; 2],
            stuck: false,
        }
    }

    /// Coefficient `k` of the relative velocity v_r in m/s.
    #[inline]
    pub fn relative_velocity(&self, k: usize) -> Real {
        self.sign * self.speed[k]
    }

    /// Coefficient `k` of everything but the velocity of the belt's surface.
    pub fn power(&self, k: usize) -> Motion {
        let linear = |start: Real, rate: Real| match k {
            0 => start,
            1 => rate,
            _ => ZERO,
        };
        let dwell = if self.stuck { self.unit } else { 0.0 };
        Motion {
            time: linear(self.start.time, real(self.unit)),
            displacement: self.displacement[k],
            velocity: self.velocity[k],
            sensor_displacement: self.sensor_displacement[k],
            sensor_velocity: self.sensor_velocity[k],
            given_belt_velocity: linear(self.given_belt_velocity[0], self.given_belt_velocity[1]),
            belt_velocity: ZERO,
            relative_velocity: self.relative_velocity(k),
            speed: self.speed[k],
            normal_force: linear(self.normal_force[0], self.normal_force[1]),
            travel: self.travel[k],
            dwell: linear(self.start.dwell, real(dwell)),
        }
    }
}

/// Which hooks an effect uses. Each is asked for every power of every step, so those without are passed over.
#[derive(Debug, Clone, Copy, Default)]
pub struct Hooks {
    /// [`EffectSeries::add_modal_acceleration`].
    pub modal_acceleration: bool,
    /// [`EffectSeries::tip_force`].
    pub tip_force: bool,
    /// [`EffectSeries::factor`].
    pub factor: bool,
    /// [`EffectSeries::static_factor`].
    pub static_factor: bool,
    /// [`EffectSeries::ripple`].
    pub ripple: bool,
    /// [`EffectSeries::memory_force`].
    pub memory_force: bool,
    /// [`EffectSeries::add_rates`].
    pub rates: bool,
    /// [`super::Effect::lagged_speed`].
    pub lagged_speed: bool,
}

/// The hooks of an effect on power series. Every default adds nothing.
///
/// Each gives coefficient `k` and is asked for k = 0, 1, 2, ... in turn. `registers` keep what the
/// effect needs of lower powers; they are its own, as many as [`EffectSeries::register_count`] says.
pub trait EffectSeries {
    /// Whether the effect takes part in slip at all, other than by a mode that it adds.
    fn acts_in_slip(&self) -> bool {
        true
    }
    /// Which of the following, and of the hooks on values that are linear in the states, the effect uses.
    fn hooks(&self) -> Hooks {
        Hooks::default()
    }
    /// Number of series that the effect keeps for itself.
    fn register_count(&self) -> usize {
        0
    }
    /// Adds to the modal accelerations in m/s^2, one for each mode; `states` are the coefficients
    /// of all states, `x` coefficient `k` of the effect's own.
    fn add_modal_acceleration(
        &self,
        _k: usize,
        _m: &MotionSeries,
        _x: &[Real],
        _states: &[State],
        _registers: &mut [Series],
        _acceleration: &mut [Real],
    ) {
    }
    /// Force on the tip besides friction, in N.
    fn tip_force(
        &self,
        _k: usize,
        _m: &MotionSeries,
        _x: &[Real],
        _registers: &mut [Series],
    ) -> Real {
        ZERO
    }
    /// Factor on the coefficient of friction or on the normal force.
    fn factor(&self, k: usize, _m: &MotionSeries, _x: &[Real], _registers: &mut [Series]) -> Real {
        if k == 0 { real(1.0) } else { ZERO }
    }
    /// Factor on the static limit, from the dwell at the start.
    fn static_factor(&self, k: usize, _m: &MotionSeries, _registers: &mut [Series]) -> Real {
        if k == 0 { real(1.0) } else { ZERO }
    }
    /// Velocity in m/s imposed on the belt, from time and inputs alone; asked for one power ahead of the others.
    fn ripple(&self, _k: usize, _m: &MotionSeries, _registers: &mut [Series]) -> Real {
        ZERO
    }
    /// Friction force in N of a law with memory, given the capacity mu F_N in N and the effect's states.
    fn memory_force(
        &self,
        _k: usize,
        _m: &MotionSeries,
        _capacity: &Series,
        _x: &[Real],
        _registers: &mut [Series],
    ) -> Real {
        ZERO
    }
    /// Rates of the effect's states. `motion`, `contact` and `x` hold coefficient `k`; where
    /// [`super::Effect::add_rates`] is linear in them, without a constant, it serves here too.
    fn add_rates(
        &self,
        _k: usize,
        _motion: &Motion,
        _contact: &ContactForce,
        _x: &[Real],
        _registers: &mut [Series],
        _rates: &mut [Real],
    ) {
    }
    /// Normalised time, at most `theta`, up to which the expressions hold, e.g. no quantity changes its sign whose magnitude they
    /// contain; a step ends just beyond, and the next one has the expressions that hold there. 0 where there are none.
    fn until(&self, _m: &MotionSeries, _registers: &[Series], _degree: usize, theta: f64) -> f64 {
        theta
    }
}
