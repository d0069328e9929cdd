//! Motions as Taylor series: the equations of [`super`] once more, coefficient by coefficient.

mod base;
mod full;
mod users;
mod workspace;

use super::{Enabled, Model};
use crate::beam::MAX_MODES;
use crate::contact::ContactMode;
use crate::effects::series::Series;
use crate::friction::FrictionLaw;
use crate::friction::series::ExponentialSum;
use crate::integrate::taylor;
use crate::integrate::{MAX_DEGREE, Scales, Segment};
use crate::real::{Real, ZERO, value};
use base::BaseSeries;
use full::FullSeries;
pub(super) use users::Users;
pub use workspace::Workspace;

/// Most effects with a factor on the friction force.
const MAX_FACTORS: usize = 6;
/// Most effects that are on together.
const MAX_PARTS: usize = 16;
/// Share of the static limit in the terms left out, from which on they do not matter.
const ROUNDING: f64 = 1e-13;
const NONE: Series = [ZERO; MAX_DEGREE + 1];

/// What the expansion of a model in power series needs.
pub(super) struct Expandable {
    /// The friction law.
    pub(super) law: ExponentialSum,
    /// Which effects use which hook.
    pub(super) users: Users,
    /// Number of registers of all effects.
    pub(super) registers: usize,
}

/// The friction law as a sum of exponentials, if all effects have power series too, and which of them use
/// which hook; gives each effect the place of its registers.
pub(super) fn exponential_sum(law: &FrictionLaw, effects: &mut [Enabled]) -> Option<Expandable> {
    let (mut registers, mut factors) = (0, 0);
    for e in effects.iter_mut() {
        let series = e.effect.series()?;
        let (count, hooks) = (series.register_count(), series.hooks());
        e.hooks = hooks;
        e.first_register = registers;
        registers += count;
        factors += usize::from(hooks.factor || hooks.static_factor);
    }
    let fits = factors <= MAX_FACTORS && effects.len() <= MAX_PARTS;
    let law = law.exponential_sum().filter(|_| fits)?;
    Some(Expandable {
        law,
        users: Users::of(effects),
        registers,
    })
}

/// [`taylor::expand`]; with derivatives for each instruction set, as these are what vectors are made for.
#[cfg_attr(
    feature = "tangent",
    multiversion::multiversion(targets("x86_64+avx2+fma"))
)]
fn expand_base(system: &mut BaseSeries, degree: usize, segment: &mut Segment) {
    taylor::expand(system, degree, segment);
}

/// As [`expand_base`], with effects.
#[cfg_attr(
    feature = "tangent",
    multiversion::multiversion(targets("x86_64+avx2+fma"))
)]
fn expand_full(system: &mut FullSeries, degree: usize, segment: &mut Segment) {
    taylor::expand(system, degree, segment);
}

/// What decides on break-away during a stretch of stick, as polynomials in theta, valid up to the degree of the
/// segment.
pub struct Stick {
    /// Normalised time up to which they are good to the tolerance.
    pub reach: f64,
    /// Constraint force F_c in N.
    pub force: Series,
    /// Largest force in N that stick can carry.
    pub limit: Series,
}

impl Model {
    /// Whether motions can be expanded in power series.
    pub fn has_series(&self) -> bool {
        self.exponential_sum.is_some()
    }

    /// Expands slip from the time and state at which `segment` starts, and gives the normalised time up to which
    /// the series is good to the tolerance, or just beyond which an expression of an effect changes its branch;
    /// [`Workspace::sliding_speed`] is then that of the stretch. `None` where the series does not hold.
    pub fn expand_slip(
        &self,
        mode: ContactMode,
        tolerance: f64,
        scales: &Scales,
        segment: &mut Segment,
        room: &mut Workspace,
    ) -> Option<f64> {
        let law = self.exponential_sum.as_ref()?;
        segment.length = self.series_unit;
        let degree = taylor::degree(tolerance);
        if self.plain_slip {
            let mut system = BaseSeries::new(self, law, mode, segment.start, room);
            expand_base(&mut system, degree, segment);
            let reach = taylor::reach(segment, tolerance, scales);
            system.observe(degree, &segment.coefficients[degree]);
            let reach = law.reach(&system.room.motion.speed[..=degree], reach);
            system.holds(reach).then_some(reach)
        } else {
            let mut system = FullSeries::new(self, law, mode, segment, room);
            expand_full(&mut system, degree, segment);
            let reach = taylor::reach(segment, tolerance, scales);
            system.observe(degree, &segment.coefficients[degree]);
            let reach = law.reach(&system.room.motion.speed[..=degree], reach);
            system.until(degree - 1, reach)
        }
    }

    /// Expands stick from the time and state at which `segment` starts, as [`Model::expand_slip`].
    pub fn expand_stick(
        &self,
        tolerance: f64,
        scales: &Scales,
        segment: &mut Segment,
        room: &mut Workspace,
    ) -> Option<Stick> {
        let law = self.exponential_sum.as_ref()?;
        segment.length = self.series_unit;
        let degree = taylor::degree(tolerance);
        let mut system = FullSeries::new(self, law, ContactMode::Stuck, segment, room);
        expand_full(&mut system, degree, segment);
        let reach = taylor::reach(segment, tolerance, scales);
        system.advance(degree, &segment.coefficients, &mut [ZERO; MAX_MODES]);
        self.checked(&system, degree, reach, tolerance)
    }

    /// The same along a stretch of stick that `segment` already gives as polynomials on [0, 1].
    pub fn follow_stick(&self, segment: &Segment, room: &mut Workspace) -> Option<Stick> {
        let law = self.exponential_sum.as_ref()?;
        let mut system = FullSeries::new(self, law, ContactMode::Stuck, segment, room);
        for k in 0..=segment.degree {
            system.advance(k, &segment.coefficients, &mut [ZERO; MAX_MODES]);
        }
        let stick = self.checked(&system, segment.degree, 1.0, ROUNDING);
        stick.filter(|stick| stick.reach == 1.0)
    }

    /// What was found, if it holds, and if the limit is as good as the motion.
    fn checked(
        &self,
        system: &FullSeries,
        degree: usize,
        reach: f64,
        tolerance: f64,
    ) -> Option<Stick> {
        let limit = *system.capacity();
        let reach = system.until(degree, reach)?;
        let last = |power: usize| value(limit[power]).abs() * reach.powi(power as i32);
        let left_out = last(degree).max(last(degree - 1));
        let good = left_out <= tolerance * value(limit[0]).abs();
        good.then_some(Stick {
            reach,
            force: system.room.force,
            limit,
        })
    }

    /// Coefficients of the given belt velocity, normal force, external force and clamp acceleration in units of `unit` in s,
    /// powers 0 and 1.
    fn given(&self, t: Real, unit: f64) -> [[Real; 2]; 4] {
        let i = &self.inputs;
        [
            [i.belt_velocity_at(t), i.belt_acceleration * unit],
            [i.normal_force_at(t), i.normal_force_rate * unit],
            [i.external_force_at(t), i.external_force_rate * unit],
            [i.clamp_acceleration_at(t), i.clamp_acceleration_rate * unit],
        ]
    }
}
