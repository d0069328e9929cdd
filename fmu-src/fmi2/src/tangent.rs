//! A motion with its derivatives by what it was started with: the model once more, with numbers that carry derivatives
//! along (`beam-tangent`), through stick, slip and every transition.

use crate::instance::Content;
use crate::setup::PLACES;
use crate::status::Fault;
use crate::values::{Access, find};
use beam_model_description::{Layout, ModeItem, Quantity, UserCard};
use beam_physics::effects::user_expression as plain_effect;
use beam_tangent as physics;
use physics::belt::Inputs;
use physics::effects::user_expression::{Target, UserEffect, UserParameter, UserState, UserTable};
use physics::error::PhysicsError;
use physics::integrate::MAX_STATES;
use physics::model::Model;
use physics::real::{Real, real};
use physics::simulate::{Outputs, Row, Simulation};
use physics::tangent::DIRECTIONS;

// Of the one set-up, what only steps and states need is not used here.
#[allow(dead_code, clippy::duplicate_mod)]
#[path = "setup.rs"]
mod setup;

/// A direction in the space of what can be set before a run: value references and how much each changes.
pub type Direction<'a> = (&'a [u32], &'a [f64]);

/// What is asked for.
pub struct Request<'a> {
    /// Rising times in s, the first of which is the start.
    pub times: &'a [f64],
    /// Value references of the outputs, at least one.
    pub outputs: &'a [u32],
    /// Directions of the derivatives.
    pub directions: Vec<Direction<'a>>,
    /// What inputs do in the course of the motion.
    pub course: Course<'a>,
}

/// What inputs do in the course of a motion: over each piece an input acts as `x (a + b (t - t_0))`, with x the value of its
/// variable, a its factor (1) and b the rate of the factor (1/s) from the piece's begin t_0 (s) on. So a derivative by x is
/// one by the scale of the whole input. Without pieces inputs are constant.
#[derive(Default)]
pub struct Course<'a> {
    /// Value references of the inputs that vary.
    pub references: &'a [u32],
    /// Rising times in s at which pieces begin, the first not after the start of the motion.
    pub begins: &'a [f64],
    /// Factors, piece after piece, each as long as `references`.
    pub factors: &'a [f64],
    /// Their rates in 1/s, likewise.
    pub rates: &'a [f64],
}

/// Where it is written.
pub struct Answer<'a> {
    /// The outputs at each time, output after output.
    pub values: &'a mut [f64],
    /// Their derivatives, direction after direction, each as `values`.
    pub slopes: &'a mut [f64],
}

/// What a direction changes: indices of variables, and by how much.
type Seed = Vec<(usize, f64)>;

/// Room for motions with derivatives, one for each group of directions, kept from one motion to the next: a calibration asks
/// for many motions of one model, of which building it anew would take as long as following them.
#[derive(Default)]
pub struct Room(Vec<Group>);

/// The run of one group, and what its model was built from.
struct Group {
    run: Box<Simulation>,
    values: Vec<f64>,
    /// Those of the seeds that change the model.
    seeds: Vec<Seed>,
}

/// What of the seeds changes the model, and not the start alone.
fn of_model(layout: &Layout, seeds: &[Seed]) -> Vec<Seed> {
    let one = |seed: &Seed| {
        let is_of = |&(index, _): &(usize, f64)| PLACES.is_of_model(layout, index);
        seed.iter().copied().filter(is_of).collect()
    };
    seeds.iter().map(one).collect()
}

/// What can be observed along a motion with its derivatives. Rates: 0 for a displacement, 1 for a velocity.
#[derive(Clone, Copy)]
enum Observable {
    /// Displacement after the measuring chain.
    Measured,
    /// Displacement or velocity of the tip.
    Tip(usize),
    /// Velocity where the sensor looks.
    SensorVelocity,
    /// Displacement or velocity of the mode with this index.
    Mode(usize, usize),
    /// Not linear in the state, since friction passes through it at once.
    Evaluated(fn(&Outputs) -> Real),
}

impl Observable {
    /// What an output is; `None` for all that can't be observed so.
    fn of(quantity: Quantity) -> Option<Self> {
        Some(match quantity {
            Quantity::MeasuredDisplacement => Self::Measured,
            Quantity::TipDisplacement => Self::Tip(0),
            Quantity::TipVelocity => Self::Tip(1),
            Quantity::MeasuredVelocity => Self::SensorVelocity,
            Quantity::Mode(j, ModeItem::Displacement) => Self::Mode(j, 0),
            Quantity::Mode(j, ModeItem::Velocity) => Self::Mode(j, 1),
            Quantity::TipAcceleration => Self::Evaluated(|o| o.acceleration),
            Quantity::MeasuredAcceleration => Self::Evaluated(|o| o.measured_acceleration),
            Quantity::FrictionForce => Self::Evaluated(|o| o.friction_force),
            _ => return None,
        })
    }

    /// The same in a model.
    fn seen_in(self, model: &Model) -> Observed {
        let (modes, mut row) = (model.beam().modes(), [real(0.0); MAX_STATES]);
        match self {
            Self::Evaluated(of) => return Observed::Evaluated(of),
            Self::Measured => {
                return match model.measured_row() {
                    Some(row) => Observed::Row(row.into()),
                    None => Observed::Evaluated(|o| o.measured_displacement),
                };
            }
            Self::Tip(rate) => modes
                .iter()
                .enumerate()
                .for_each(|(j, mode)| row[2 * j + rate] = mode.tip_value),
            Self::SensorVelocity => modes
                .iter()
                .zip(model.sensor_values())
                .enumerate()
                .for_each(|(j, (_, value))| row[2 * j + 1] = value),
            // A mode that the model does not have does not move.
            Self::Mode(j, rate) if j < modes.len() => row[2 * j + rate] = real(1.0),
            Self::Mode(..) => {}
        }
        Observed::Row(Box::new((row, real(0.0))))
    }
}

/// An output along the motion of a model.
enum Observed {
    /// Linear in the state.
    Row(Box<Row>),
    /// Of all that can be observed at a time.
    Evaluated(fn(&Outputs) -> Real),
}

/// Advances through the rising `times` in s and writes the outputs at each, time after time.
fn sample(
    run: &mut Simulation,
    times: &[f64],
    observed: &[Observed],
    out: &mut Vec<Real>,
) -> Result<(), PhysicsError> {
    let rows: Option<Vec<Row>> = observed
        .iter()
        .map(|o| match o {
            Observed::Row(row) => Some(**row),
            Observed::Evaluated(_) => None,
        })
        .collect();
    if let Some(rows) = rows {
        return run.sample(times, &rows, out);
    }
    for &time in times {
        run.advance_to(real(time))?;
        let (outputs, state) = (run.outputs(), run.state());
        out.extend(observed.iter().map(|o| match o {
            Observed::Row(output) => {
                let (row, offset) = &**output;
                let terms = row.iter().zip(&state);
                terms.fold(*offset, |sum, (a, x)| sum + *a * *x)
            }
            Observed::Evaluated(of) => of(&outputs),
        }));
    }
    Ok(())
}

impl Content {
    /// Follows a motion with its derivatives, some directions at a time.
    ///
    /// # Errors
    /// References that can't be set or observed, values with which the equations can't be set up, a motion that can't be
    /// followed.
    pub fn tangents(
        &self,
        room: &mut Room,
        request: &Request,
        answer: Answer,
    ) -> Result<(), Fault> {
        let observed = request
            .outputs
            .iter()
            .map(|&output| self.observable(output))
            .collect::<Result<Vec<_>, Fault>>()?;
        let seeded = request
            .directions
            .iter()
            .map(|(references, changes)| self.seed(references, changes))
            .collect::<Result<Vec<_>, Fault>>()?;
        let times = request.times;
        let course = self.course(&request.course)?;
        let groups = seeded
            .chunks(DIRECTIONS)
            .zip(answer.slopes.chunks_mut(DIRECTIONS * answer.values.len()));
        let mut follow = |number: usize, seeds: &[Seed]| {
            let followed = self.follow(room, number, (times, &course), seeds, &observed);
            followed.map_err(|cause| Fault::NotFollowed {
                time: times[0],
                cause,
            })
        };
        // Found time after time, asked for output after output.
        let (count, width) = (times.len(), observed.len());
        let place = |i: usize| (i % width) * count + i / width;
        if seeded.is_empty() {
            for (i, y) in follow(0, &[])?.iter().enumerate() {
                answer.values[place(i)] = y.value;
            }
        }
        let length = answer.values.len();
        for (number, (seeds, slopes)) in groups.enumerate() {
            for (i, y) in follow(number, seeds)?.iter().enumerate() {
                let k = place(i);
                answer.values[k] = y.value;
                for (direction, slopes) in slopes.chunks_mut(length).enumerate() {
                    slopes[k] = y.slope.get(direction);
                }
            }
        }
        Ok(())
    }

    /// What the output with a value reference is.
    fn observable(&self, output: u32) -> Result<Observable, Fault> {
        let index = find(self.layout, output, Access::Real)?;
        let variable = &self.layout.variables()[index];
        Observable::of(variable.quantity).ok_or_else(|| Fault::Unsupported {
            function: crate::lifecycle::Function::SetReal,
            what: format!("derivatives of '{}' along a motion", variable.name),
        })
    }

    /// Indices of the variables that a direction changes, and by how much.
    fn seed(&self, references: &[u32], changes: &[f64]) -> Result<Seed, Fault> {
        references
            .iter()
            .zip(changes)
            .map(|(&reference, &change)| {
                let index = find(self.layout, reference, Access::Real)?;
                Ok((index, change))
            })
            .collect()
    }

    /// The course of the inputs in the order of [`setup::INPUTS`].
    fn course(&self, course: &Course) -> Result<Vec<Piece>, Fault> {
        let inputs = PLACES.input_indices();
        let mut of_inputs = Vec::new();
        for &reference in course.references {
            let index = find(self.layout, reference, Access::Real)?;
            let input = inputs.iter().position(|place| *place == index);
            of_inputs.push(input.ok_or_else(|| Fault::Unsupported {
                function: crate::lifecycle::Function::SetRealInputDerivatives,
                what: format!(
                    "a course of '{}', which is not an input",
                    self.layout.variables()[index].name
                ),
            })?);
        }
        let piece = |(k, &begin): (usize, &f64)| {
            let mut piece = Piece {
                begin,
                factors: [1.0; setup::INPUTS],
                rates: [0.0; setup::INPUTS],
            };
            for (i, &input) in of_inputs.iter().enumerate() {
                let at = k * of_inputs.len() + i;
                piece.factors[input] = course.factors[at];
                piece.rates[input] = course.rates[at];
            }
            piece
        };
        Ok(course.begins.iter().enumerate().map(piece).collect())
    }

    /// The outputs at `times`, time after time, with derivatives by at most [`DIRECTIONS`] directions, the group with this number.
    fn follow(
        &self,
        room: &mut Room,
        number: usize,
        (times, course): (&[f64], &[Piece]),
        seeds: &[Seed],
        observed: &[Observable],
    ) -> Result<Vec<Real>, PhysicsError> {
        let mut seeded: Vec<Real> = self.values.iter().map(|v| real(*v)).collect();
        for (i, seed) in seeds.iter().enumerate() {
            for &(index, change) in seed {
                seeded[index].slope.change(i, change);
            }
        }
        let places = &*setup::PLACES;
        let begin = real(times[0]);
        let plain = places.inputs(&seeded, [real(0.0); setup::INPUTS], begin);
        // Pieces that end before the motion begins say nothing of it.
        let first = course
            .partition_point(|piece| piece.begin <= times[0])
            .saturating_sub(1);
        let course = &course[first..];
        let inputs = match course.first() {
            Some(piece) => piece.inputs(&plain, times[0]),
            None => plain,
        };
        let tolerance = self.values[places.tolerance];
        let of_model = of_model(self.layout, seeds);
        let is_same = |group: &Group| {
            PLACES.same_model(self.layout, &self.values, &group.values) && group.seeds == of_model
        };
        let known = room.0.get_mut(number);
        let run = match known {
            Some(group) if is_same(group) => {
                let from = places.start(self.layout, &seeded, group.run.model(), begin);
                group.run.restart(inputs, &from, tolerance)?;
                &mut group.run
            }
            known => {
                let model = setup::model(self.layout, &seeded, inputs, user_effect)?;
                let from = places.start(self.layout, &seeded, &model, begin);
                let group = if let Some(group) = known {
                    // Until it stands again, it is nobody's model.
                    group.values.clear();
                    group.run.replace(model, inputs, &from, tolerance)?;
                    group
                } else {
                    let run = Simulation::from_model(model, inputs, &from, tolerance)?;
                    room.0.truncate(number);
                    room.0.push(Group {
                        run: Box::new(run),
                        values: Vec::new(),
                        seeds: Vec::new(),
                    });
                    &mut room.0[number]
                };
                group.values.clone_from(&self.values);
                group.seeds = of_model;
                &mut group.run
            }
        };
        let model = run.model();
        let observed: Vec<Observed> = observed.iter().map(|o| o.seen_in(model)).collect();
        let mut out = Vec::with_capacity(times.len() * observed.len());
        let mut left = times;
        for piece in course.iter().skip(1) {
            let (within, after) = left.split_at(left.partition_point(|time| *time <= piece.begin));
            sample(run, within, &observed, &mut out)?;
            left = after;
            if left.is_empty() {
                break;
            }
            run.advance_to(real(piece.begin))?;
            run.set_inputs(piece.inputs(&plain, piece.begin))?;
        }
        sample(run, left, &observed, &mut out)?;
        Ok(out)
    }
}

/// All inputs over a piece of a motion, as in [`Course`].
struct Piece {
    begin: f64,
    factors: [f64; setup::INPUTS],
    rates: [f64; setup::INPUTS],
}

impl Piece {
    /// The inputs from `t` in s on, where `plain` are the values of their variables.
    fn inputs(&self, plain: &Inputs, t: f64) -> Inputs {
        let at = |i: usize| self.factors[i] + self.rates[i] * (t - self.begin);
        Inputs {
            since: real(t),
            belt_velocity: at(0) * plain.belt_velocity,
            belt_acceleration: self.rates[0] * plain.belt_velocity,
            normal_force: at(1) * plain.normal_force,
            normal_force_rate: self.rates[1] * plain.normal_force,
            external_force: at(2) * plain.external_force,
            external_force_rate: self.rates[2] * plain.external_force,
            clamp_acceleration: at(3) * plain.clamp_acceleration,
            clamp_acceleration_rate: self.rates[3] * plain.clamp_acceleration,
        }
    }
}

/// A user's effect with parameters that carry derivatives, or `None` where their values mean "off".
fn user_effect(card: &UserCard, values: &[Real]) -> Option<UserEffect> {
    let plain: Vec<f64> = values.iter().map(|v| v.value).collect();
    let effect = card.effect(&plain)?;
    let state = |s: plain_effect::UserState| UserState {
        name: s.name,
        unit: s.unit,
        nominal: s.nominal,
        start: s.start,
        rate: s.rate,
        on_stick: s.on_stick,
        on_break_away: s.on_break_away,
    };
    let table = |t: plain_effect::UserTable| UserTable {
        name: t.name,
        at: t.at,
        first_parameter: t.first_parameter,
    };
    Some(UserEffect {
        id: effect.id,
        target: Target::from_name(effect.target.name()).expect("the same list"),
        mode: effect.mode,
        expression: effect.expression,
        states: effect.states.into_iter().map(state).collect(),
        tables: effect.tables.into_iter().map(table).collect(),
        parameters: effect
            .parameters
            .into_iter()
            .zip(values)
            .map(|(p, &value)| UserParameter {
                name: p.name,
                unit: p.unit,
                start: p.start,
                min: p.min,
                max: p.max,
                value,
            })
            .collect(),
    })
}
