//! One slip event simulated with a given friction curve: from stick through break-away and slip
//! into the next stick. The engine of [`super`].

use crate::observer::structure::{MODE_LIMIT, Structure};

/// Modal coordinates and velocities `[q_1, q_1', q_2, ...]` in m and m/s; unused places are zero.
pub(super) type State = [f64; 2 * MODE_LIMIT];

/// Runge-Kutta steps per sample.
const STEPS: usize = 4;

/// A stretch of the record about one slip event.
#[derive(Debug, Clone)]
pub(super) struct Shot {
    /// Sample in stick where the simulation starts.
    pub first: usize,
    /// One past the last sample compared.
    pub past: usize,
    /// Belt velocity in m/s, taken as constant over the event.
    pub belt: f64,
    /// Normal force in N, taken as constant over the event.
    pub normal: f64,
}

/// Precomputed modal data.
pub(super) struct Plant {
    n: usize,
    stiffness: [f64; MODE_LIMIT],
    damping: [f64; MODE_LIMIT],
    drive: [f64; MODE_LIMIT],
    tip: [f64; MODE_LIMIT],
    sensor: [f64; MODE_LIMIT],
    inverse_mass: f64,
}

impl Plant {
    pub fn new(structure: &Structure) -> Self {
        let mut plant = Self {
            n: structure.modes().len(),
            stiffness: [0.0; MODE_LIMIT],
            damping: [0.0; MODE_LIMIT],
            drive: [0.0; MODE_LIMIT],
            tip: [0.0; MODE_LIMIT],
            sensor: [0.0; MODE_LIMIT],
            inverse_mass: structure.inverse_tip_mass(),
        };
        for (j, mode) in structure.modes().iter().enumerate() {
            let w = mode.angular_frequency();
            plant.stiffness[j] = w * w;
            plant.damping[j] = mode.damping();
            plant.drive[j] = mode.tip_value / mode.mass_kg;
            plant.tip[j] = mode.tip_value;
            plant.sensor[j] = mode.sensor_value();
        }
        plant
    }

    /// Displacement in m where the sensor looks.
    pub fn displacement(&self, x: &State) -> f64 {
        (0..self.n).map(|j| self.sensor[j] * x[2 * j]).sum()
    }

    fn velocity(&self, x: &State) -> f64 {
        (0..self.n).map(|j| self.tip[j] * x[2 * j + 1]).sum()
    }

    fn holding_force(&self, x: &State) -> f64 {
        let pull: f64 = (0..self.n)
            .map(|j| self.tip[j] * (self.damping[j] * x[2 * j + 1] + self.stiffness[j] * x[2 * j]))
            .sum();
        pull / self.inverse_mass
    }

    /// Brings the tip to the belt's velocity by an impulse at the tip.
    fn stick_to(&self, x: &mut State, belt: f64) {
        let impulse = (belt - self.velocity(x)) / self.inverse_mass;
        for j in 0..self.n {
            x[2 * j + 1] += self.drive[j] * impulse;
        }
    }

    fn step(&self, x: &State, h: f64, force: &impl Fn(&State) -> f64) -> State {
        let rates = |x: &State| -> State {
            let f = force(x);
            let mut out = [0.0; 2 * MODE_LIMIT];
            for j in 0..self.n {
                out[2 * j] = x[2 * j + 1];
                out[2 * j + 1] = self.drive[j] * f
                    - self.damping[j] * x[2 * j + 1]
                    - self.stiffness[j] * x[2 * j];
            }
            out
        };
        let along = |k: &State, f: f64| -> State {
            let mut out = *x;
            for i in 0..2 * self.n {
                out[i] += f * k[i];
            }
            out
        };
        let k1 = rates(x);
        let k2 = rates(&along(&k1, 0.5 * h));
        let k3 = rates(&along(&k2, 0.5 * h));
        let k4 = rates(&along(&k3, h));
        let mut out = *x;
        for i in 0..2 * self.n {
            out[i] += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
        }
        out
    }

    /// Displacement at every sample of the shot, for the friction coefficient `mu(speed)`.
    pub fn shoot(
        &self,
        shot: &Shot,
        start: &State,
        interval: f64,
        mu: &impl Fn(f64) -> f64,
    ) -> Vec<f64> {
        let mut x = *start;
        self.stick_to(&mut x, shot.belt);
        let limit = mu(0.0) * shot.normal;
        let mut contact = Contact {
            direction: 0.0,
            armed: true,
        };
        let mut out = Vec::with_capacity(shot.past - shot.first);
        for _ in shot.first..shot.past {
            out.push(self.displacement(&x));
            for _ in 0..STEPS {
                self.advance(
                    &mut x,
                    &mut contact,
                    interval / STEPS as f64,
                    shot,
                    limit,
                    mu,
                );
            }
        }
        out
    }

    /// One step with its events.
    fn advance(
        &self,
        x: &mut State,
        contact: &mut Contact,
        step: f64,
        shot: &Shot,
        limit: f64,
        mu: &impl Fn(f64) -> f64,
    ) {
        let mut left = step;
        for _ in 0..8 {
            let direction = contact.direction;
            let speed = |x: &State| (self.velocity(x) - shot.belt) * direction;
            let force = |x: &State| {
                if direction == 0.0 {
                    self.holding_force(x)
                } else {
                    -direction * shot.normal * mu(speed(x).max(0.0))
                }
            };
            let margin = |x: &State| {
                if direction == 0.0 {
                    limit - self.holding_force(x).abs()
                } else {
                    speed(x)
                }
            };
            let end = self.step(x, left, &force);
            let after = margin(&end);
            // A trial curve may drive the motion beyond all bounds: then there is no event to find,
            // and the misfit, not a number, refuses the trial.
            if !after.is_finite() {
                *x = end;
                return;
            }
            if after >= 0.0 || !contact.armed {
                // Just after break-away the speed starts at zero; it counts once positive.
                contact.armed |= after > 0.0;
                *x = end;
                return;
            }
            let at = cross(margin(x), after, left, |h| margin(&self.step(x, h, &force)));
            *x = self.step(x, at, &force);
            left -= at;
            let pull = self.holding_force(x);
            *contact = if direction == 0.0 {
                Contact {
                    direction: -pull.signum(),
                    armed: false,
                }
            } else if pull.abs() <= limit {
                self.stick_to(x, shot.belt);
                Contact {
                    direction: 0.0,
                    armed: true,
                }
            } else {
                Contact {
                    direction: -direction,
                    armed: false,
                }
            };
        }
    }
}

struct Contact {
    /// -1 or 1 in slip, 0 in stick.
    direction: f64,
    armed: bool,
}

/// Zero of a falling function between 0 and `width` (Illinois form of regula falsi, Dowell and
/// Jarratt 1971), where it goes from `start >= 0` to `end < 0`.
fn cross(start: f64, end: f64, width: f64, value: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, width);
    let (mut at_low, mut at_high) = (start.max(0.0), end);
    for _ in 0..60 {
        if high - low <= 1e-13 * width {
            break;
        }
        let share = at_low / (at_low - at_high);
        let share = if share.is_finite() { share } else { 0.5 };
        let middle = (low + (high - low) * share).clamp(low, high);
        let found = value(middle);
        if found >= 0.0 {
            if middle == low {
                break;
            }
            (low, at_low) = (middle, found);
            at_high *= 0.5;
        } else {
            if middle == high {
                break;
            }
            (high, at_high) = (middle, found);
            at_low *= 0.5;
        }
    }
    high
}
