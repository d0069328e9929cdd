//! Unknown functions as effects: a curve of one quantity that acts in one place.
//!
//! Each is a user's effect with a table, a natural cubic spline through [`NODES`] nodes at even distances over the range of
//! its argument. Its values at the nodes are
//!
//! ```text
//! g_i = s sum_k d_k z_k cos(pi k i / (NODES - 1)),   d_0 = 1, d_k = k^-2
//! ```
//!
//! with independent normal z_k before the data, of standard deviation 1 unless the data tell another smoothness ([`Smoothness`]): the cosine coefficients of a curve of which the second derivative is
//! white have standard deviations that fall with the square of their number (Wahba 1990, Spline Models for Observational Data,
//! sect. 1.3). s is the strength as met in practice that the file gives as `typical`.

use crate::diagnose::model::parameter::{Kind, Parameter, Scale};
use crate::fmu::effect_card::EffectCard;
use crate::measurement::{Campaign, Measurand};
use crate::metric::velocity;
use crate::observer::Structure;
use serde::Serialize;

/// Nodes of a curve.
pub const NODES: usize = 8;
/// How the identifiers of all of them begin.
const PREFIX: &str = "term_unknown_";
/// How the names of the values at the nodes begin.
const NODE: &str = "g_";
/// Largest latent value, in standard deviations before the data.
const MOST: f64 = 20.0;

/// Name of the state that low-passes an argument.
const STATE: &str = "x";
/// Time constant in s with which a memory is looked for first: a few periods of a beam of 80 Hz.
const TYPICAL_MEMORY: f64 = 0.05;
/// Bounds of a constant of a formula in units of its value: what follows from a curve is good to a factor.
const FORMULA_RANGE: f64 = 10.0;

/// Where an unknown function acts.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Place {
    /// Name in `diagnosis.json`.
    name: &'static str,
    /// Target in an effect's file.
    target: &'static str,
    /// The formula, with `G` for the curve.
    formula: &'static str,
    /// The mode, from 1, where it acts on one alone.
    mode: Option<usize>,
}

const fn place(name: &'static str, target: &'static str, formula: &'static str) -> Place {
    Place {
        name,
        target,
        formula,
        mode: None,
    }
}

const FRICTION: Place = place("friction", "friction_factor", "1 + G");
/// Where it depends on the load alone it is a factor on each run's level of friction, which is fitted by its logarithm: the
/// valley in which the two trade is straight.
const FRICTION_LEVEL: Place = place("friction", "friction_factor", "exp(G)");
/// A force that adds to the normal force, so that it counts less at a higher one; in shares of the mean one.
const NORMAL_FORCE: Place = place(
    "normal_force",
    "normal_force_factor",
    "1 + G*MEAN_FORCE/F_N",
);
const TIP_FORCE: Place = place("tip_force", "tip_force", "G");
const FREQUENCY: Place = place("frequency", "frequency_factor", "1 + G");
/// Of the first mode alone: a mass that comes and goes, a contact that gives way, while temperature acts on all modes alike.
const FIRST_FREQUENCY: Place = Place {
    mode: Some(1),
    ..FREQUENCY
};
const DAMPING: Place = place("damping", "damping_factor", "1 + G");
const MEASUREMENT: Place = place("measurement", "measurement", "w + G");
const BELT: Place = place("belt", "belt_velocity", "v0*G");

/// What an unknown function depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Argument {
    /// Name in `diagnosis.json` and in the identifier.
    name: &'static str,
    /// The quantity of the formula; for one with a memory, what is low-passed.
    quantity: &'static str,
    unit: &'static str,
    /// Whether it is the quantity low-passed with a time constant.
    remembers: bool,
}

const fn argument(name: &'static str, quantity: &'static str, unit: &'static str) -> Argument {
    Argument {
        name,
        quantity,
        unit,
        remembers: false,
    }
}

const fn past(name: &'static str, quantity: &'static str, unit: &'static str) -> Argument {
    Argument {
        name,
        quantity,
        unit,
        remembers: true,
    }
}

const DEFLECTION: Argument = argument("w", "w", "m");
const VELOCITY: Argument = argument("w_dot", "w_dot", "m/s");
const SPEED: Argument = argument("v_r", "v_abs", "m/s");
const TIME: Argument = argument("time", "t", "s");
const LOAD: Argument = argument("normal_force", "F_N", "N");
const DWELL: Argument = argument("dwell", "t_stick", "s");
const PAST_SPEED: Argument = past("low_passed_v_r", "v_abs", "m/s");
const PAST_POWER: Argument = past("low_passed_power", "abs(F*v_r)", "W");
const PAST_DEFLECTION: Argument = past("low_passed_w", "abs(w)", "m");

/// Samples to either side of one at which the fastest motion of a free mass is looked for.
const SLOPE_HALF_WIDTH: usize = 5;

/// All that are tried.
const ALL: [(Place, Argument); 22] = [
    (FRICTION, DEFLECTION),
    (FRICTION, VELOCITY),
    (FRICTION, SPEED),
    (FRICTION, TIME),
    (FRICTION, DWELL),
    (FRICTION_LEVEL, LOAD),
    (FRICTION, PAST_SPEED),
    (FRICTION, PAST_POWER),
    (NORMAL_FORCE, DEFLECTION),
    (NORMAL_FORCE, VELOCITY),
    (TIP_FORCE, DEFLECTION),
    (TIP_FORCE, VELOCITY),
    (TIP_FORCE, TIME),
    (FREQUENCY, TIME),
    (FREQUENCY, PAST_DEFLECTION),
    (FIRST_FREQUENCY, TIME),
    (FIRST_FREQUENCY, PAST_DEFLECTION),
    (DAMPING, DEFLECTION),
    (DAMPING, PAST_DEFLECTION),
    (MEASUREMENT, DEFLECTION),
    (MEASUREMENT, TIME),
    (BELT, TIME),
];

/// An unknown function of a campaign, as an effect.
#[derive(Debug, Clone)]
pub struct UnknownFunction {
    /// Identifier of the effect.
    pub id: String,
    /// Where it acts, as `diagnosis.json` names it.
    pub place: &'static str,
    /// The mode, from 1, where it acts on one alone.
    pub mode: Option<usize>,
    /// What it depends on, as `diagnosis.json` names it.
    pub argument: &'static str,
    /// Unit of the argument.
    pub argument_unit: &'static str,
    /// Whether the argument is low-passed with a time constant.
    pub remembers: bool,
    /// Places of the nodes.
    pub at: Vec<f64>,
    /// The effect's file.
    pub file: String,
    /// Target in an effect's file.
    target: &'static str,
    /// The formula of that target, with `G` for the curve.
    formula: String,
    /// What it depends on.
    of: Argument,
}

/// A constant of a formula in place of a curve.
#[derive(Debug, Clone, PartialEq)]
pub struct FormulaConstant {
    /// Name within the effect.
    pub name: String,
    /// Unit symbol.
    pub unit: String,
    /// Value as it follows from the curve.
    pub value: f64,
    /// Whether it is no strength but a place on the argument's axis, which is positive.
    pub is_shape: bool,
}

impl UnknownFunction {
    /// The file with another identifier and these values at the nodes as typical ones, and as typical time constant.
    pub fn file_with(&self, id: &str, values: &[f64], memory_s: Option<f64>) -> String {
        let list: Vec<String> = values.iter().map(|v| format!("{v:e}")).collect();
        let most = values.iter().fold(1e-12, |m: f64, v| m.max(v.abs()));
        let line = |line: &str| match (line.split(" = ").next(), memory_s) {
            (Some("id"), _) => format!("id = \"{id}\""),
            (Some("typical"), _) if line.ends_with("# strength") => {
                format!("typical = [{}]", list.join(", "))
            }
            (Some("min"), _) if line.ends_with("# strength") => format!("min = {:e}", -10.0 * most),
            (Some("max"), _) if line.ends_with("# strength") => format!("max = {:e}", 10.0 * most),
            (Some("typical"), Some(tau)) => format!("typical = {tau:e}"),
            _ => line.to_owned(),
        };
        self.file.lines().map(|l| line(l) + "\n").collect()
    }

    /// What a formula calls the argument of the curve.
    pub fn variable(&self) -> &'static str {
        if self.of.remembers {
            STATE
        } else {
            self.of.quantity
        }
    }

    /// Unit of the curve's values.
    pub fn value_unit(&self) -> &'static str {
        value_unit(self.place)
    }

    /// An effect with the formula `curve` of [`Self::variable`] in place of the table; `memory_s` is the time constant found, in s.
    pub fn formula_file(
        &self,
        id: &str,
        curve: &str,
        constants: &[FormulaConstant],
        memory_s: Option<f64>,
    ) -> String {
        let mut out = format!(
            "id = \"{id}\"\ntitle = \"Formula in {} acting on {}\"\nfamily = \"unknown\"\n\
             target = \"{}\"\n{}expression = \"{}\"\n",
            self.argument.replace('_', " "),
            self.place.replace('_', " "),
            self.target,
            mode_line(self.mode),
            self.formula.replace('G', &format!("({curve})")),
        );
        for c in constants {
            let (least, most) = match c.is_shape {
                true => (c.value / FORMULA_RANGE, c.value * FORMULA_RANGE),
                false => (
                    -FORMULA_RANGE * c.value.abs(),
                    FORMULA_RANGE * c.value.abs(),
                ),
            };
            out += &format!(
                "\n[[parameter]]\nname = \"{}\"\nunit = \"{}\"\nmin = {least:e}\nmax = {most:e}\ntypical = {:e}\n",
                c.name, c.unit, c.value
            );
            if c.is_shape {
                out += "role = \"shape\"\n";
            }
        }
        out + &memory(&self.of, &self.at, memory_s.unwrap_or(TYPICAL_MEMORY))
    }
}

/// Whether an effect is an unknown function.
pub fn is_unknown_function(id: &str) -> bool {
    id.starts_with(PREFIX)
}

/// Unit of what acts on a place, as `diagnosis.json` names it.
pub(crate) fn value_unit(place: &str) -> &'static str {
    match place {
        "tip_force" => "N",
        "measurement" => "m",
        "clamp" => "m/s2",
        _ => "1",
    }
}

/// Whether a parameter of an unknown function is a value at a node.
pub(crate) fn is_node(name: &str) -> bool {
    name.starts_with(NODE)
}

/// How smooth a curve is believed to be: latent value `k` has the standard deviation `a max(k, 1)^(2 - p)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Smoothness {
    /// a, in units of the typical strength.
    pub strength: f64,
    /// p, by which cosine coefficients fall with their number: 1 for a curve that is continuous, 2 for one with a slope, 3 for a
    /// smoother one.
    pub decay: f64,
    /// Whether the evidence told both.
    pub is_told: bool,
}

impl Smoothness {
    /// What is believed where nothing told it.
    pub const UNTOLD: Self = Self {
        strength: 1.0,
        decay: 2.0,
        is_told: false,
    };

    /// Standard deviation of latent value `k` before the data.
    pub fn std(&self, k: usize) -> f64 {
        self.strength * (k.max(1) as f64).powf(2.0 - self.decay)
    }
}

/// Weight of the latent value `k` at node `i`, in units of the strength.
pub fn weight(k: usize, i: usize) -> f64 {
    let smooth = if k == 0 { 1.0 } else { (k as f64).powi(-2) };
    smooth * (std::f64::consts::PI * (k * i) as f64 / (NODES - 1) as f64).cos()
}

/// Name of the latent value `k` of an unknown function.
pub fn latent_name(id: &str, k: usize) -> String {
    format!("{id}.z_{}", k + 1)
}

/// The latent values of an unknown function that is believed so smooth, which set those at its nodes.
pub(crate) fn latent(card: &EffectCard, smoothness: Smoothness) -> Vec<Parameter> {
    let nodes: Vec<_> = card
        .parameters
        .iter()
        .filter(|p| is_node(&p.name))
        .collect();
    let of = |k: usize| Parameter {
        name: latent_name(&card.id, k),
        unit: "1".into(),
        kind: Kind::Latent,
        targets: nodes
            .iter()
            .enumerate()
            .map(|(i, p)| (p.reference, p.typical * weight(k, i)))
            .collect(),
        scale: Scale::Linear,
        prior: 0.0,
        prior_std: smoothness.std(k),
        min: -MOST * smoothness.std(k),
        max: MOST * smoothness.std(k),
        step: 1e-3,
        support: None,
    };
    (0..nodes.len()).map(of).collect()
}

/// Peak velocity in m/s of a harmonic motion of this amplitude in m and frequency in Hz.
fn velocity_of(amplitude: f64, frequency_hz: f64) -> f64 {
    amplitude * std::f64::consts::TAU * frequency_hz
}

/// A frequency in Hz by which the motions of a campaign are measured: the lowest natural one, or, where no mode has a spring, that
/// of a harmonic motion as wide and as fast as the widest and the fastest measured. `ranges` is of the displacement, run by run
/// ([`super::displacement_range`]).
pub fn lowest_frequency(campaign: &Campaign, structure: &Structure, ranges: &[(f64, f64)]) -> f64 {
    let sprung = structure.modes().iter().filter(|m| !m.is_free());
    let lowest = sprung.map(|m| m.frequency_hz).fold(f64::INFINITY, f64::min);
    if lowest.is_finite() {
        return lowest;
    }
    let of_run = |(run, &(low, high)): (&crate::measurement::Run, &(f64, f64))| {
        let size = |a: f64, v: &f64| a.max(v.abs());
        // The range is of the tip, what is measured where the sensor looks.
        let half = 0.5 * (high - low) * campaign.beam.seen_share().abs();
        let angular = match run.measurand {
            Measurand::Displacement => {
                let speed = velocity(&run.time, &run.measured, SLOPE_HALF_WIDTH);
                speed.iter().fold(0.0, size) / half
            }
            Measurand::Velocity => run.measured.iter().fold(0.0, size) / half,
            Measurand::Acceleration => (run.measured.iter().fold(0.0, size) / half).sqrt(),
        };
        angular / std::f64::consts::TAU
    };
    let runs = campaign.runs.iter().zip(ranges);
    let highest = runs.map(of_run).fold(0.0, f64::max);
    if highest > 0.0 { highest } else { 1.0 }
}

/// Least and largest normal force that the runs of a campaign state, N.
pub(super) fn loads(campaign: &Campaign) -> (f64, f64) {
    let of_run = |run: &crate::measurement::Run| match &run.inputs.normal_force {
        Some(series) => series.values.clone(),
        None => vec![run.normal_force],
    };
    let all = campaign.runs.iter().flat_map(of_run);
    all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), f| {
        (low.min(f), high.max(f))
    })
}

/// The unknown functions of a campaign: their nodes cover what its runs pass. `lowest_hz` is that of [`lowest_frequency`], and
/// so are `ranges`. What would act on a sensor of displacements is left out where something else was measured, and what would act on
/// the normal force where all runs have one that is constant.
pub fn unknown_functions(
    campaign: &Campaign,
    lowest_hz: f64,
    tip_mass_kg: f64,
    ranges: &[(f64, f64)],
) -> Vec<UnknownFunction> {
    let runs = &campaign.runs;
    let most =
        |of: &dyn Fn(&crate::measurement::Run) -> f64| runs.iter().map(of).fold(0.0, f64::max);
    let all = ranges.iter();
    let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), r| {
        (l.min(r.0), h.max(r.1))
    });
    let is_measured =
        |place: &Place| *place != MEASUREMENT || campaign.measurand() == Measurand::Displacement;
    let (least_load, most_load) = loads(campaign);
    // At one load a factor on the normal force is the same factor on friction: one hypothesis.
    let is_distinct = |place: &Place| *place != NORMAL_FORCE || least_load < most_load;
    let half = (0.5 * (high - low)).max(1e-9);
    let belt = most(&|r| r.belt_velocity.abs());
    let force = most(&|r| r.normal_force);
    let mean_force = runs.iter().map(|r| r.normal_force).sum::<f64>() / runs.len().max(1) as f64;
    // Where nothing rubs, forces are measured by the one that drives; where nothing drives either, by that of the moving mass.
    let push = |r: &crate::measurement::Run| {
        let shaken = tip_mass_kg * r.inputs.clamp_acceleration.largest();
        r.inputs.external_force.largest().max(shaken)
    };
    let inertia = tip_mass_kg * half * (std::f64::consts::TAU * lowest_hz).powi(2);
    let scales = [mean_force, most(&push), inertia];
    let mean_force = scales.into_iter().find(|f| *f > 0.0).unwrap_or(1.0);
    let sliding = if belt > 0.0 {
        belt
    } else {
        velocity_of(half, lowest_hz)
    };
    // A harmonic motion of this amplitude at the lowest natural frequency, or the belt, where that is faster.
    let velocity = velocity_of(half, lowest_hz).max(belt);
    let duration = most(&|r| r.time[r.time.len() - 1]);
    let range = |argument: Argument| match argument {
        DEFLECTION => (low, high),
        VELOCITY => (-velocity, velocity),
        SPEED => (0.0, velocity + belt),
        TIME => (0.0, duration),
        // Stick lasts for a period or a few.
        DWELL => (0.0, 3.0 / lowest_hz),
        LOAD => loads(campaign),
        PAST_SPEED => (0.0, velocity),
        PAST_POWER => (0.0, force * sliding),
        _ => (0.0, high.abs().max(low.abs())),
    };
    let strength = |place: Place| match place {
        FRICTION | FRICTION_LEVEL | NORMAL_FORCE => 0.3,
        TIP_FORCE => 0.1 * mean_force,
        FREQUENCY | FIRST_FREQUENCY => 0.03,
        DAMPING => 5.0,
        MEASUREMENT => 0.1 * half,
        _ => 0.1,
    };
    ALL.iter()
        .filter(|(place, _)| is_measured(place) && is_distinct(place))
        .map(|&(place, argument)| {
            let (from, to) = match range(argument) {
                // It does not vary in this campaign: the curve can't act, and its nodes may be anywhere.
                (from, to) if to <= from => (from, from + 1.0),
                wide => wide,
            };
            let at: Vec<f64> = (0..NODES)
                .map(|i| from + (to - from) * i as f64 / (NODES - 1) as f64)
                .collect();
            UnknownFunction {
                id: id(place, argument),
                place: place.name,
                mode: place.mode,
                argument: argument.name,
                argument_unit: argument.unit,
                remembers: argument.remembers,
                file: file(place, argument, &at, strength(place), mean_force),
                target: place.target,
                formula: formula(place, mean_force),
                of: argument,
                at,
            }
        })
        .collect()
}

/// Identifier of the effect.
fn id(place: Place, of: Argument) -> String {
    let mode = place.mode.map_or(String::new(), |mode| format!("_{mode}"));
    format!("{PREFIX}{}{mode}_{}", place.name, of.name)
}

/// The line of a file that names the mode, if it is one alone.
fn mode_line(mode: Option<usize>) -> String {
    mode.map_or(String::new(), |mode| format!("mode = {mode}\n"))
}

/// The formula of a place, with `G` for the curve.
fn formula(place: Place, mean_force: f64) -> String {
    place
        .formula
        .replace("MEAN_FORCE", &format!("{mean_force:?}"))
}

/// Time constant and state of an argument with a memory; nothing for others.
fn memory(of: &Argument, at: &[f64], typical: f64) -> String {
    if !of.remembers {
        return String::new();
    }
    let nominal = at[at.len() - 1].abs().max(1e-9) / 4.0;
    format!(
        "\n[[parameter]]\nname = \"tau\"\nunit = \"s\"\nmin = 1e-3\nmax = 5.0\ntypical = {typical:?}\n\
         role = \"shape\"\n\n[[state]]\nname = \"{STATE}\"\nunit = \"{}\"\nnominal = {nominal:e}\n\
         rate = \"({} - {STATE})/tau\"\n",
        of.unit, of.quantity
    )
}

fn file(place: Place, of: Argument, at: &[f64], strength: f64, mean_force: f64) -> String {
    let variable = if of.remembers { STATE } else { of.quantity };
    let formula = formula(place, mean_force).replace('G', &format!("table({variable}, g)"));
    let unit = match place {
        TIP_FORCE => "N",
        MEASUREMENT => "m",
        _ => "1",
    };
    let list: Vec<String> = at.iter().map(|a| format!("{a:e}")).collect();
    let table = format!(
        "id = \"{}\"\ntitle = \"Unknown function of {} acting on {}\"\n\
         family = \"unknown\"\ntarget = \"{}\"\n{}expression = \"{formula}\"\n\n\
         [[table]]\nname = \"g\"\nunit = \"{unit}\"\nat = [{}]\nmin = {:e} # strength\n\
         max = {:e} # strength\ntypical = {strength:e} # strength\n",
        id(place, of),
        of.name.replace('_', " "),
        place.name.replace('_', " "),
        place.target,
        mode_line(place.mode),
        list.join(", "),
        -MOST * strength,
        MOST * strength,
    );
    table + &memory(&of, at, TYPICAL_MEMORY)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn latent_values_make_any_curve_and_rough_ones_are_less_believed() {
        // The cosines are independent: the curve through given nodes has one set of them.
        let matrix = nalgebra::DMatrix::from_fn(NODES, NODES, |i, k| weight(k, i));
        assert!(matrix.clone().lu().determinant().abs() > 1e-9);
        let straight = nalgebra::DVector::<f64>::from_fn(NODES, |i, _| i as f64);
        let zigzag = nalgebra::DVector::<f64>::from_fn(NODES, |i, _| (i % 2) as f64);
        let cost = |curve: nalgebra::DVector<f64>| {
            matrix.clone().lu().solve(&curve).unwrap().norm_squared()
        };
        assert!(cost(zigzag) > 5.0 * cost(straight));
    }
}
