//! Bringing an FMU to an operating point, and recording its motion there.

use crate::diagnose::model::known_structure::structure;
use crate::error::Error;
use crate::fmu::{Drive, Fmu, Instance, Kind};
use crate::measurement::BeamKnowledge;
use crate::observer::{Mode, Structure};
use crate::watch::Watch;

/// Where and from what state to run.
#[derive(Debug, Clone, Default)]
pub struct OperatingPoint {
    /// Belt velocity, m/s.
    pub belt_velocity: f64,
    /// Normal force, N.
    pub normal_force: f64,
    /// Further start values, by variable name, in the variable's own unit.
    pub settings: Vec<(String, f64)>,
    /// What a campaign knows of the structure, where the FMU is of another make and has no modes to tell it.
    pub structure: Option<Structure>,
}

impl OperatingPoint {
    /// An operating point with what is known of the beam as start values.
    ///
    /// Names the FMU does not have are left out, so that a campaign may know more than a foreign FMU can use.
    pub fn of_beam(
        fmu: &Fmu,
        beam: &BeamKnowledge,
        belt_velocity: f64,
        normal_force: f64,
    ) -> OperatingPoint {
        let modes = beam.natural_frequencies_hz.len();
        let mut settings = Vec::new();
        if modes > 0 {
            settings.push(("mode_count".to_owned(), modes as f64));
        }
        let lists = [
            ("frequency", &beam.natural_frequencies_hz),
            ("damping_ratio", &beam.damping_ratios),
            ("damping_rate", &beam.damping_rates_per_s),
            ("mass", &beam.masses_kg),
            ("tip_value", &beam.tip_values),
            ("clamp_share", &beam.clamp_shares),
            ("sensor_ratio", &beam.sensor.ratios),
        ];
        for (part, values) in lists {
            settings.extend(
                values
                    .iter()
                    .enumerate()
                    .map(|(j, value)| (format!("mode[{}].{part}", j + 1), *value)),
            );
        }
        settings.retain(|(name, _)| fmu.description().find(name).is_some());
        OperatingPoint {
            belt_velocity,
            normal_force,
            settings,
            structure: fmu.side_file().and_then(|_| structure(fmu, beam).ok()),
        }
    }

    /// With these start values, in place of those of the same names.
    pub fn with(mut self, settings: &[(String, f64)]) -> OperatingPoint {
        let is_given = |name: &str| settings.iter().any(|s| s.0 == name);
        self.settings.retain(|(name, _)| !is_given(name));
        self.settings.extend_from_slice(settings);
        self
    }

    /// Adds a start state: the tip at `displacement` (m) with `velocity` (m/s), the beam bent as by a force at its tip.
    ///
    /// ```text
    /// q_j = w [phi_j / (m_j w_j^2)] / sum_k [phi_k^2 / (m_k w_k^2)],   q_j' likewise from w'
    /// ```
    ///
    /// A mass without a spring takes all of a static deflection. A record gives the tip only; a stick phase, which bends the beam slowly, has nearly this shape. FMUs without modal
    /// coordinates start as they please.
    pub fn starting_at(mut self, fmu: &Fmu, displacement: f64, velocity: f64) -> OperatingPoint {
        let known = self.modes(fmu);
        let slides = known.iter().any(|(_, frequency, _)| *frequency == 0.0);
        let bent = |&(tip, frequency, mobility): &(f64, f64, f64)| {
            let bend = match (slides, frequency == 0.0) {
                (true, true) => mobility,
                (true, false) => 0.0,
                (false, _) => mobility / (frequency * frequency),
            };
            (tip, bend)
        };
        let shape: Vec<(f64, f64)> = known.iter().map(bent).collect();
        let flexibility: f64 = shape.iter().map(|(tip, bend)| tip * bend).sum();
        let states = shape.into_iter().enumerate().flat_map(|(j, (_, bend))| {
            let share = bend / flexibility;
            [
                (format!("q[{}]", j + 1), displacement * share),
                (format!("q_dot[{}]", j + 1), velocity * share),
            ]
        });
        match fmu.side_file() {
            None => self.settings.extend(states),
            Some(side) => {
                let names = side.start_names().map(str::to_owned);
                let values = states.map(|(_, value)| value);
                self.settings.extend(names.zip(values));
            }
        }
        self
    }

    /// Of each mode the mode shape at the tip (1), the natural frequency (Hz) and the mode shape over the mass (1/kg).
    fn modes(&self, fmu: &Fmu) -> Vec<(f64, f64, f64)> {
        if let Some(structure) = &self.structure {
            let of_mode = |m: &Mode| (m.tip_value, m.frequency_hz, m.tip_value / m.mass_kg);
            return structure.modes().iter().map(of_mode).collect();
        }
        let modes = self.value(fmu, "mode_count").unwrap_or(0.0) as usize;
        let part = |j: usize, part: &str| self.value(fmu, &format!("mode[{j}].{part}"));
        let known = (1..=modes).map(|j| {
            let (tip, frequency) = (part(j, "tip_value")?, part(j, "frequency")?);
            Some((tip, frequency, tip / part(j, "mass")?))
        });
        // The first mode that the FMU lacks ends the list.
        known.collect::<Option<_>>().unwrap_or_default()
    }

    /// A start value: the one set here, else the FMU's own.
    fn value(&self, fmu: &Fmu, name: &str) -> Option<f64> {
        let set = self
            .settings
            .iter()
            .find(|(n, _)| n == name)
            .map(|(_, value)| *value);
        set.or_else(|| fmu.description().find(name)?.start_number())
    }

    /// Sets everything and initialises at time 0.
    pub fn start(&self, fmu: &Fmu, instance: &mut Instance) -> Result<(), Error> {
        self.start_driven(fmu, instance, None)
    }

    /// The same with inputs that vary; they come before the constant ones.
    pub fn start_driven(
        &self,
        fmu: &Fmu,
        instance: &mut Instance,
        drive: Option<&Drive>,
    ) -> Result<(), Error> {
        for (name, value) in &self.settings {
            instance.set_number(fmu.variable(name)?, *value)?;
        }
        for (name, value) in [
            ("belt_velocity", self.belt_velocity),
            ("normal_force", self.normal_force),
        ] {
            // An FMU of another make may lack what is the same in all runs.
            if fmu.side_file().is_none() || fmu.variable(name).is_ok() {
                instance.set_real(&fmu.real_references(&[name])?, &[value])?;
            }
        }
        if let Some(drive) = drive {
            drive.begin(instance, 0.0)?;
        }
        instance.initialize(0.0, None, None)
    }
}

/// Values of some variables at even times.
#[derive(Debug, Clone)]
pub struct Trajectory {
    /// Times, s.
    pub time: Vec<f64>,
    /// One list per variable asked for, in its own unit; integers and enumerations as numbers.
    pub values: Vec<Vec<f64>>,
}

/// Runs a started instance for `steps` communication steps of `step` (s) and records `outputs`, the start included.
pub fn record(
    fmu: &Fmu,
    instance: &mut Instance,
    outputs: &[&str],
    step: f64,
    steps: usize,
) -> Result<Trajectory, Error> {
    record_driven(fmu, instance, outputs, (step, steps), None, &())
}

/// Steps between two looks at whether to stop.
const LOOK: usize = 1000;

/// The same with inputs that vary, under a watch.
pub fn record_driven(
    fmu: &Fmu,
    instance: &mut Instance,
    outputs: &[&str],
    (step, steps): (f64, usize),
    drive: Option<&Drive>,
    watch: &dyn Watch,
) -> Result<Trajectory, Error> {
    let variables = outputs
        .iter()
        .map(|name| fmu.variable(name))
        .collect::<Result<Vec<_>, _>>()?;
    let mut trajectory = Trajectory {
        time: Vec::with_capacity(steps + 1),
        values: vec![Vec::with_capacity(steps + 1); outputs.len()],
    };
    for i in 0..=steps {
        if i % LOOK == 0 {
            if watch.stop() {
                return Err(Error::Interrupted {
                    what: "steps simulated",
                    done: i,
                    of: steps,
                });
            }
            watch.step("simulating", i, steps);
        }
        trajectory.time.push(i as f64 * step);
        for (variable, values) in variables.iter().zip(&mut trajectory.values) {
            let (mut real, mut integer) = ([0.0], [0]);
            values.push(match variable.kind {
                Kind::Integer | Kind::Enumeration => {
                    instance.get_integer(&[variable.reference], &mut integer)?;
                    f64::from(integer[0])
                }
                Kind::Boolean => {
                    instance.get_boolean(&[variable.reference], &mut integer)?;
                    f64::from(integer[0])
                }
                Kind::Real | Kind::String => {
                    instance.get_real(&[variable.reference], &mut real)?;
                    real[0]
                }
            });
        }
        if i < steps {
            // The next time is i + 1 steps, not a running sum, so that it does not drift.
            let (now, next) = (i as f64 * step, (i + 1) as f64 * step);
            match drive {
                Some(drive) => drive.advance(instance, now, next)?,
                None => instance.do_step(now, next - now)?,
            }
        }
    }
    Ok(trajectory)
}
