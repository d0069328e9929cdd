//! Further sensors as a fit has them: outputs of the FMU, what each sensor makes of them, and the constants of its own.

use crate::diagnose::data::further_readings::spread;
use crate::diagnose::data::segment::FurtherPart;
use crate::diagnose::model::instants::Instants;
use crate::diagnose::model::parameter::{Kind, Parameter, SensorConstant};
use crate::error::Error;
use crate::fmu::Fmu;
use crate::measurement::{Campaign, DelayBelief, FurtherSensor, Reading, Run};

/// Standard deviations from what is stated within which factor and place of a sensor are sought: beyond, the campaign states another one.
const REACH: f64 = 6.0;
/// The same of its zero: ten times what varies, as the first sensor's, where nothing is stated.
const REACH_OF_ZERO: f64 = 500.0;

/// Default standard deviation of a sensor's zero, as a share of the standard deviation of what it reads; that of the first sensor too.
pub(crate) const OFFSET_STD: f64 = 0.02;

/// A constant of a sensor, which the FMU does not have.
fn constant(
    (sensor, item): (&FurtherSensor, &str),
    unit: &str,
    kind: Kind,
    belief: (f64, f64),
    reach: f64,
) -> Parameter {
    // A sensor may be called as an effect is, or as the first sensor.
    let name = format!("further_sensor.{}.{item}", sensor.name);
    Parameter {
        kind,
        targets: Vec::new(),
        ..Parameter::linear(name, unit, 0, belief, reach)
    }
}

/// How far the clocks of a campaign's sensors may be off, exactly as stated where the FMU can't be read between the samples.
pub fn delay_beliefs(fmu: &Fmu, campaign: &Campaign) -> Vec<DelayBelief> {
    let is_read_anywhere = fmu.description().capabilities.can_handle_variable_step;
    let belief = |sensor: &FurtherSensor| match is_read_anywhere {
        true => sensor.delay_belief(&campaign.runs),
        false => DelayBelief::EXACT,
    };
    campaign.further_sensors.iter().map(belief).collect()
}

/// What all runs have of the further sensors: the factor of each, its delay, and its place by the structure's `modes` first modes.
pub fn shared_constants(
    sensors: &[FurtherSensor],
    delays: &[DelayBelief],
    modes: usize,
) -> Vec<Parameter> {
    let mut out = Vec::new();
    for (number, sensor) in sensors.iter().enumerate() {
        let kind = |of| Kind::Sensor(number, of);
        let (gain, belief) = (kind(SensorConstant::Gain), (1.0, sensor.gain_std));
        out.push(constant((sensor, "gain"), "1", gain, belief, REACH));
        let DelayBelief { std, most } = delays[number];
        if std > 0.0 {
            let delay = kind(SensorConstant::Delay);
            let reach = most / std;
            out.push(constant((sensor, "delay"), "s", delay, (0.0, std), reach));
        }
        if sensor.place.is_tip() {
            continue;
        }
        let ratios = sensor.place.ratios.iter().zip(&sensor.place.stds);
        for (j, belief) in ratios.enumerate().take(modes) {
            let item = format!("mode_ratio[{}]", j + 1);
            let (ratio, belief) = (kind(SensorConstant::Ratio(j)), (*belief.0, *belief.1));
            out.push(constant((sensor, &item), "1", ratio, belief, REACH));
        }
    }
    out
}

/// What a run has of its own of the further sensors, their zeros. All runs have the same ones: that of a sensor which read nothing in one stays
/// where it is believed to be.
pub fn constants_of_run(sensors: &[FurtherSensor], run: &Run) -> Vec<Parameter> {
    let zero = |(number, sensor): (usize, &FurtherSensor)| {
        let record = run.further.get(number).and_then(Option::as_ref);
        let usual = || record.map_or(1.0, |record| OFFSET_STD * spread(record));
        let std = sensor.offset_std.unwrap_or_else(usual);
        constant(
            (sensor, "offset"),
            sensor.reading.unit(),
            Kind::Sensor(number, SensorConstant::Offset),
            (0.0, std),
            REACH_OF_ZERO,
        )
    };
    sensors.iter().enumerate().map(zero).collect()
}

/// What a sensor reads of the FMU's outputs, by their places among [`FurtherSensors::outputs`].
struct Parts {
    /// That of the contact.
    whole: usize,
    /// Modal displacements or velocities; none for a sensor at the contact.
    modes: Vec<usize>,
    /// Ratios of the modes as stated, where nothing else is known.
    ratios: Vec<f64>,
    /// The ratio of modes that effects add.
    ratio_of_added: f64,
}

/// The further sensors of a campaign.
pub struct FurtherSensors {
    /// Value references of the FMU's outputs that they read.
    pub outputs: Vec<u32>,
    /// Their names.
    pub output_names: Vec<String>,
    parts: Vec<Parts>,
    /// Mode shapes at the contact.
    tip_values: Vec<f64>,
}

/// Constants of a sensor where a fit stands.
#[derive(Debug, Clone, Default)]
struct Constants {
    gain: f64,
    ratios: Vec<f64>,
    offset: f64,
    delay: f64,
}

/// A reading that changes by more than this share of its reach over [`DELAY_STEP`](super::instants::DELAY_STEP) jumps there: a motion of 1 kHz changes by less than a
/// thousandth of it.
const JUMPS: f64 = 1e-2;

impl FurtherSensors {
    /// The sensors, read from an FMU with these mode shapes at the contact.
    ///
    /// # Errors
    /// An FMU without an output that a sensor reads.
    pub fn new(fmu: &Fmu, sensors: &[FurtherSensor], tip_values: Vec<f64>) -> Result<Self, Error> {
        let (mut outputs, mut output_names) = (Vec::new(), Vec::new());
        let mut place = |name: &str| -> Result<usize, Error> {
            let reference = fmu.variable(name)?.reference;
            let known = outputs.iter().position(|o| *o == reference);
            Ok(known.unwrap_or_else(|| {
                outputs.push(reference);
                output_names.push(name.to_owned());
                outputs.len() - 1
            }))
        };
        let mut parts = Vec::new();
        for sensor in sensors {
            let whole = place(sensor.reading.output())?;
            let state = match sensor.reading {
                Reading::Velocity => "q_dot",
                _ => "q",
            };
            let mut modes = Vec::new();
            if !sensor.place.is_tip() {
                for j in 1..=tip_values.len() {
                    modes.push(place(&format!("{state}[{j}]"))?);
                }
            }
            let of_added = sensor.place.ratios.get(tip_values.len());
            let mut ratios = vec![1.0; modes.len()];
            ratios
                .iter_mut()
                .zip(&sensor.place.ratios)
                .for_each(|(to, ratio)| *to = *ratio);
            parts.push(Parts {
                whole,
                modes,
                ratios,
                ratio_of_added: of_added.copied().unwrap_or(1.0),
            });
        }
        Ok(Self {
            outputs,
            output_names,
            parts,
            tip_values,
        })
    }

    /// Where the constants of sensor `number` stand.
    fn constants(&self, number: usize, all: &[(&Parameter, f64)]) -> Constants {
        let mut found = Constants {
            gain: 1.0,
            ratios: self.parts[number].ratios.clone(),
            offset: 0.0,
            delay: 0.0,
        };
        for (parameter, position) in all {
            match parameter.kind {
                Kind::Sensor(n, of) if n == number => match of {
                    SensorConstant::Gain => found.gain = *position,
                    SensorConstant::Offset => found.offset = *position,
                    SensorConstant::Delay => found.delay = *position,
                    SensorConstant::Ratio(j) => {
                        if let Some(ratio) = found.ratios.get_mut(j) {
                            *ratio = *position;
                        }
                    }
                },
                _ => {}
            }
        }
        found
    }

    /// What mode `j` adds at the contact, of outputs given by their places.
    fn of_mode(&self, parts: &Parts, j: usize, output: &dyn Fn(usize) -> f64) -> f64 {
        self.tip_values[j] * output(parts.modes[j])
    }

    /// What a sensor sees where it looks, of outputs, or of their derivatives, given by their places.
    fn seen(&self, parts: &Parts, ratios: &[f64], output: &dyn Fn(usize) -> f64) -> f64 {
        let whole = output(parts.whole);
        if parts.modes.is_empty() {
            return whole;
        }
        let (mut seen, mut rest) = (0.0, whole);
        for (j, ratio) in ratios.iter().enumerate() {
            let of_mode = self.of_mode(parts, j, output);
            seen += ratio * of_mode;
            rest -= of_mode;
        }
        // What is left at the contact is of modes that effects add.
        seen + parts.ratio_of_added * rest
    }

    /// What a sensor reads as it is stated, with factor 1 and zero 0, of outputs given by their places.
    pub fn as_stated(&self, number: usize, output: &dyn Fn(usize) -> f64) -> f64 {
        let parts = &self.parts[number];
        self.seen(parts, &parts.ratios, output)
    }

    /// Times in s by which the clocks of a segment's sensors are late.
    pub(super) fn delays(
        &self,
        further: &[FurtherPart],
        constants: &[(&Parameter, f64)],
    ) -> Vec<f64> {
        let delay = |part: &FurtherPart| self.constants(part.sensor, constants).delay;
        further.iter().map(delay).collect()
    }

    /// Appends to `out` what each sensor of a segment reads at the first `count` samples, one after another, over the scale that its values
    /// there have; `outputs` are those of [`Self::outputs`], instant after instant, as far as the motion was followed.
    pub(super) fn read(
        &self,
        further: &[FurtherPart],
        constants: &[(&Parameter, f64)],
        (outputs, count): (&[f64], usize),
        instants: &Instants,
        out: &mut Vec<f64>,
    ) {
        let last = outputs.len() / self.outputs.len() - 1;
        for (part, places) in further.iter().zip(&instants.late) {
            let own = self.constants(part.sensor, constants);
            for place in &places[..count] {
                let at = &outputs[*place.min(&last) * self.outputs.len()..];
                let seen = self.seen(&self.parts[part.sensor], &own.ratios, &|i| at[i]);
                out.push((own.gain * seen + own.offset) / part.scale);
            }
        }
    }

    /// Appends to `out` how the readings of a segment change in a direction in which the outputs change by `slopes`, output after
    /// output, at all instants.
    pub(super) fn slopes(
        &self,
        further: &[FurtherPart],
        constants: &[(&Parameter, f64)],
        slopes: &[f64],
        instants: &Instants,
        out: &mut Vec<f64>,
    ) {
        let count = instants.times.len();
        for (part, places) in further.iter().zip(&instants.late) {
            let own = self.constants(part.sensor, constants);
            let parts = &self.parts[part.sensor];
            for k in places {
                let seen = self.seen(parts, &own.ratios, &|i| slopes[i * count + k]);
                out.push(own.gain * seen / part.scale);
            }
        }
    }

    /// Appends to `out` how the readings of a segment change with constant `of` of sensor `number`, where the outputs are `values`,
    /// output after output, at all instants.
    pub(super) fn slopes_of_constant(
        &self,
        further: &[FurtherPart],
        constants: &[(&Parameter, f64)],
        (number, of): (usize, SensorConstant),
        values: &[f64],
        instants: &Instants,
        out: &mut Vec<f64>,
    ) {
        let count = instants.times.len();
        for (i, part) in further.iter().enumerate() {
            let places = &instants.late[i];
            if part.sensor != number {
                out.resize(out.len() + places.len(), 0.0);
                continue;
            }
            let own = self.constants(number, constants);
            let parts = &self.parts[number];
            let seen = |place: usize| {
                self.seen(parts, &own.ratios, &|output: usize| {
                    values[output * count + place]
                })
            };
            for (k, &place) in places.iter().enumerate() {
                let slope = match of {
                    SensorConstant::Gain => seen(place),
                    SensorConstant::Ratio(j) => {
                        let output = |output: usize| values[output * count + place];
                        own.gain * self.of_mode(parts, j, &output)
                    }
                    SensorConstant::Offset => 1.0,
                    SensorConstant::Delay => {
                        let later = instants.later[i][k];
                        // At an end of the segment both may be the same.
                        let apart = instants.times[place] - instants.times[later];
                        let change = own.gain * (seen(later) - seen(place));
                        match apart > 0.0 && change.abs() < JUMPS * part.reach * part.scale {
                            true => change / apart,
                            false => 0.0,
                        }
                    }
                };
                out.push(slope / part.scale);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measurement::SensorPlace;

    #[test]
    fn a_sensor_at_the_contact_has_a_factor_and_no_place() {
        let sensor = |ratios: Vec<f64>| FurtherSensor {
            name: "laser".into(),
            reading: Reading::Displacement,
            place: SensorPlace {
                stds: vec![0.025; ratios.len()],
                ratios,
            },
            gain_std: 0.01,
            offset_std: None,
            noise_std: None,
            delay: 0.0,
            delay_std: None,
            column: "w".into(),
            scale: None,
        };
        let names = |ratios: Vec<f64>, modes: usize| -> Vec<String> {
            let belief = DelayBelief {
                std: 1e-4,
                most: 3e-4,
            };
            let all = shared_constants(&[sensor(ratios)], &[belief], modes);
            all.into_iter().map(|p| p.name).collect()
        };
        let at_contact = ["further_sensor.laser.gain", "further_sensor.laser.delay"];
        assert_eq!(names(Vec::new(), 2), at_contact);
        // As stated of a structure with one mode.
        assert_eq!(names(vec![1.0], 1), at_contact);
        let two = names(vec![0.6, -0.3, 0.1], 2);
        assert_eq!(two[3], "further_sensor.laser.mode_ratio[2]");
        assert_eq!(two.len(), 4);
    }
}
