//! What a study computes: its parameters, starts and rule, and the rows of its table.

use beam_physics::sweep::{Chain, Rule, Section, StartRule, Task, Values};
use serde_json::{Value, json};

use crate::command::pack::own_effects;
use crate::error::Error;
use crate::fmu::{Causality, Fmu, Kind};

/// One parameter with the values it takes.
#[derive(Debug, Clone)]
pub struct Axis {
    /// The FMU's name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// The values, in the order asked for.
    pub values: Vec<f64>,
}

/// Even values, rounded to twelve digits so that 0.103 reads as such.
pub fn even(from: f64, to: f64, points: usize) -> Vec<f64> {
    let rounded = |v: f64| format!("{v:.11e}").parse().unwrap_or(v);
    (0..points)
        .map(|i| match i {
            0 => from,
            i if i + 1 == points => to,
            i => rounded(from + (to - from) * i as f64 / (points - 1) as f64),
        })
        .collect()
}

/// How the points start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum StartKind {
    /// In stick, the beam bent by 0.95 of the break-away force (or as --set q[1]=... says)
    Fixed,
    /// Each from the motion at the next lower value
    Up,
    /// Each from the motion at the next higher value
    Down,
    /// From a grid of bends and velocities, all at every point
    Grid,
}

impl StartKind {
    /// The word for files.
    pub fn word(self) -> &'static str {
        match self {
            StartKind::Fixed => "fixed",
            StartKind::Up => "up",
            StartKind::Down => "down",
            StartKind::Grid => "grid",
        }
    }
}

/// A row of the table.
#[derive(Debug, Clone)]
pub struct Row {
    /// Parameter values.
    pub at: Vec<f64>,
    /// Kind of start.
    pub kind: StartKind,
    /// The start's name in the table.
    pub start: String,
    rule: StartRule,
}

impl Row {
    /// What tells the row from all others: its first fields in the table.
    pub fn key(&self) -> String {
        let mut key = String::new();
        for value in &self.at {
            key += &format!("{value},");
        }
        key + &self.start
    }
}

/// A study.
#[derive(Debug, Clone)]
pub struct Plan {
    /// One or two parameters.
    pub axes: Vec<Axis>,
    /// Further start values.
    pub settings: Vec<(String, f64)>,
    /// Kinds of start.
    pub starts: Vec<StartKind>,
    /// Numbers of bends and of velocities of the grid of starts.
    pub grid: (usize, usize),
    /// How long each point is followed, and where it is looked at.
    pub rule: Rule,
    /// All values of the model but for the parameters'.
    pub base: Values,
    /// Identity of the FMU whose start values these are.
    pub guid: String,
}

impl Plan {
    /// The values of all variables at a point.
    pub fn values(&self, at: &[f64]) -> Values {
        let mut values = self.base.clone();
        for (axis, value) in self.axes.iter().zip(at) {
            values.set(&axis.name, *value).expect("names are checked");
        }
        values
    }

    /// The parameters' values at all points; the first parameter runs fastest.
    pub fn points(&self) -> Vec<Vec<f64>> {
        let (first, rest) = self.axes.split_first().expect("at least one parameter");
        let seconds = rest
            .first()
            .map_or(vec![None], |a| a.values.iter().copied().map(Some).collect());
        let of = |second: &Option<f64>, first: f64| {
            let mut at = vec![first];
            at.extend(second);
            at
        };
        seconds
            .iter()
            .flat_map(|s| first.values.iter().map(move |f| of(s, *f)))
            .collect()
    }

    fn starts_of(&self, kind: StartKind) -> Vec<(String, StartRule)> {
        match kind {
            StartKind::Fixed => vec![("fixed".into(), StartRule::Fixed)],
            StartKind::Up => vec![("up".into(), StartRule::Carried)],
            StartKind::Down => vec![("down".into(), StartRule::Carried)],
            StartKind::Grid => {
                let even = |i: usize, n: usize, reach: f64| match n {
                    1 => 0.0,
                    n => reach * (2.0 * i as f64 / (n - 1) as f64 - 1.0),
                };
                let (bends, velocities) = self.grid;
                (0..bends)
                    .flat_map(|b| (0..velocities).map(move |v| (b, v)))
                    .map(|(b, v)| {
                        let (bend, velocity) = (even(b, bends, 0.95), even(v, velocities, 1.0));
                        let name = format!("grid {bend:.3} {velocity:.3}");
                        (name, StartRule::Grid { bend, velocity })
                    })
                    .collect()
            }
        }
    }

    /// All rows in the table's order: by point, then by start.
    pub fn rows(&self) -> Vec<Row> {
        let starts: Vec<_> = self
            .starts
            .iter()
            .flat_map(|kind| self.starts_of(*kind).into_iter().map(|s| (*kind, s)))
            .collect();
        let mut rows = Vec::new();
        for at in self.points() {
            for (kind, (start, rule)) in &starts {
                rows.push(Row {
                    at: at.clone(),
                    kind: *kind,
                    start: start.clone(),
                    rule: rule.clone(),
                });
            }
        }
        rows
    }

    fn task(&self, id: usize, row: &Row) -> Task {
        Task {
            id,
            values: self.values(&row.at),
            start: row.rule.clone(),
        }
    }

    /// The rows as chains of work: a continuation is one chain for each value of the second parameter.
    pub fn chains(&self, rows: &[Row]) -> Vec<Chain> {
        let mut chains = Vec::new();
        for kind in [StartKind::Up, StartKind::Down] {
            let mut seconds: Vec<Option<f64>> = Vec::new();
            for row in rows.iter().filter(|r| r.kind == kind) {
                let second = row.at.get(1).copied();
                if !seconds.contains(&second) {
                    seconds.push(second);
                }
            }
            for second in seconds {
                let mut ids: Vec<usize> = (0..rows.len())
                    .filter(|&i| rows[i].kind == kind && rows[i].at.get(1).copied() == second)
                    .collect();
                ids.sort_by(|a, b| rows[*a].at[0].total_cmp(&rows[*b].at[0]));
                if kind == StartKind::Down {
                    ids.reverse();
                }
                chains.push(Chain {
                    carried: None,
                    tasks: ids.iter().map(|&i| self.task(i, &rows[i])).collect(),
                });
            }
        }
        for (i, row) in rows.iter().enumerate() {
            if matches!(row.kind, StartKind::Fixed | StartKind::Grid) {
                chains.push(Chain {
                    carried: None,
                    tasks: vec![self.task(i, row)],
                });
            }
        }
        chains
    }

    /// Everything that decides on the results, to tell one study from another.
    pub fn identity(&self) -> Value {
        let axes = self.axes.iter();
        let section = match self.rule.section {
            Section::Peak => json!("peak"),
            Section::Release => json!("release"),
            Section::Stroboscopic { period } => json!({ "stroboscopic_period_s": period }),
        };
        let set: serde_json::Map<String, Value> = self
            .settings
            .iter()
            .map(|(name, value)| (name.clone(), json!(value)))
            .collect();
        json!({
            "format": 1,
            "parameters": axes.map(|a| json!({ "name": a.name, "unit": a.unit, "values": a.values })).collect::<Vec<_>>(),
            "set": set,
            "starts": self.starts.iter().map(|s| s.word()).collect::<Vec<_>>(),
            "grid": [self.grid.0, self.grid.1],
            "section": section,
            "settle": self.rule.settle,
            "cycles": self.rule.cycles,
            "patience": self.rule.patience,
            "fmu_guid": self.guid,
        })
    }
}

/// The start values of all settable variables of the FMU.
pub fn base(fmu: &Fmu) -> Result<Values, Error> {
    let mut values = Values::default();
    for card in own_effects::of_fmu(fmu)? {
        values.offer(card.at_start(), card.strengths());
    }
    for v in &fmu.description().variables {
        if !v.is_settable() || v.kind == Kind::String {
            continue;
        }
        let Some(start) = v.start_number() else {
            continue;
        };
        // Start values that say what is the default already must not count as a start given by the user.
        if values.get(&v.name) == Some(start) {
            continue;
        }
        set(&mut values, &v.name, start)?;
    }
    Ok(values)
}

fn set(values: &mut Values, name: &str, value: f64) -> Result<(), Error> {
    values.set(name, value).map_err(|_| Error::SweepVariable {
        name: name.into(),
        problem: "sweep computes this repository's model, which has no such variable; use an FMU of this project".into(),
    })
}

/// Sets a variable of the FMU, checked by its description.
pub fn set_checked(values: &mut Values, fmu: &Fmu, name: &str, value: f64) -> Result<(), Error> {
    check(fmu, name, value)?;
    set(values, name, value)
}

/// Whether a variable may have this value.
pub fn check(fmu: &Fmu, name: &str, value: f64) -> Result<(), Error> {
    let variable = fmu.variable(name)?;
    let refuse = |problem: String| {
        Err(Error::SweepVariable {
            name: name.into(),
            problem,
        })
    };
    if !variable.is_settable() || variable.causality == Causality::Output {
        return refuse(
            "it is a result; `stickslip simulate --list` shows parameters and inputs".into(),
        );
    }
    let unit = variable.unit.as_deref().unwrap_or("1");
    if !value.is_finite() {
        return refuse(format!("{value} {unit} is not a finite number"));
    }
    if variable.kind != Kind::Real && value.fract() != 0.0 {
        return refuse(format!("it takes whole numbers, {value} is none"));
    }
    if let Some(min) = variable.min.filter(|min| value < *min) {
        return refuse(format!(
            "{value} {unit} is below its least value {min} {unit}"
        ));
    }
    if let Some(max) = variable.max.filter(|max| value > *max) {
        return refuse(format!(
            "{value} {unit} is above its greatest value {max} {unit}"
        ));
    }
    Ok(())
}

/// Whether a variable belongs to the start state that `fixed` starts use where it is set.
pub fn is_start(name: &str) -> bool {
    name.starts_with("q[") || name.starts_with("q_dot[") || name == "start.contact"
}

impl Row {
    /// The start as numbers: 0 fixed, 1 grid with bend and velocity, 2 carried.
    pub fn rule_numbers(&self) -> [f64; 3] {
        match self.rule {
            StartRule::Fixed => [0.0, 0.0, 0.0],
            StartRule::Grid { bend, velocity } => [1.0, bend, velocity],
            StartRule::Carried => [2.0, 0.0, 0.0],
        }
    }
}
