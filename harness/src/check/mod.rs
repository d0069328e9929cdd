//! The quality of a campaign's data, before long work begins on them.
//!
//! What a run says of itself ([`motion`]) is held against what is stated of it ([`examined`]): in
//! stick the tip moves with the belt, friction balances the deflection, in slip the tip swings as
//! its modes do; without contact it answers a force as its modes do ([`response`]). A value that can't be meant is an error, named with the mistake that would explain
//! it; deviations that rigs have are none ([`thresholds`]).

mod clamp;
mod examined;
mod finding;
mod free_swing;
mod high_pass;
mod load_cell;
mod modes;
pub mod motion;
pub mod plateau;
mod response;
mod scale;
mod signal;
mod swapped;
mod thresholds;
mod zero;

use examined::Examined;
use finding::gathered;
pub use finding::{Finding, Severity};
use serde::Serialize;

use crate::measurement::{
    Campaign, FurtherRecord, FurtherSensor, Measurand, NoiseStd, Reading, Run,
};

/// What was found in a campaign.
#[derive(Debug, Clone, Serialize)]
pub struct Quality {
    /// Its name.
    pub campaign: String,
    /// The runs in the order of the file.
    pub runs: Vec<RunQuality>,
    /// What was measured.
    #[serde(skip)]
    pub measurand: Measurand,
    /// Deflection where the sensor looks over that of the tip, if it looks elsewhere: all motions are those of the tip, by this share.
    #[serde(skip)]
    pub seen_share: Option<f64>,
    /// Whether anything presses on the contact in some run; without that, belt, stick and friction say nothing.
    #[serde(skip)]
    pub is_pressed: bool,
    /// What there is to say, errors first.
    pub findings: Vec<Finding>,
}

/// A run in numbers.
#[derive(Debug, Clone, Serialize)]
pub struct RunQuality {
    /// Its name.
    pub name: String,
    /// Samples.
    pub samples: usize,
    /// Samples per second, Hz.
    pub sample_rate_hz: f64,
    /// Noise.
    #[serde(flatten)]
    pub noise_std: NoiseStd,
    /// Range of the displacement, or of the integral of the velocity, m.
    pub range_m: f64,
    /// Stated belt speed, m/s.
    pub belt_velocity_m_per_s: f64,
    /// Speed of the tip in stick, m/s, where stick is seen.
    pub stick_speed_m_per_s: Option<f64>,
    /// Share of the time in stick, 1.
    pub stick_share: f64,
    /// Mean deflection times static stiffness over the normal force, 1, where masses and
    /// frequencies are stated.
    pub mean_friction: Option<f64>,
    /// How the file was read, where it is not plain CSV in SI units.
    pub understood: Option<String>,
    /// What further sensors read.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub further: Vec<ReadingQuality>,
}

/// What a further sensor read in a run, in numbers.
#[derive(Debug, Clone, Serialize)]
pub struct ReadingQuality {
    /// What it is called.
    pub name: String,
    /// What it reads.
    pub quantity: Reading,
    /// SI unit of that.
    pub unit: &'static str,
    /// Samples with a reading.
    pub samples: usize,
    /// Standard deviation of its noise, in that unit; `None` where it read nothing that varies.
    pub noise_std: Option<f64>,
    /// Least and largest reading; NaN where it read nothing.
    pub range: [f64; 2],
}

impl ReadingQuality {
    fn all(sensors: &[FurtherSensor], run: &Run) -> Vec<Self> {
        let one = |(sensor, record): (&FurtherSensor, &Option<FurtherRecord>)| {
            let values = record
                .iter()
                .flat_map(|r| &r.values)
                .filter(|y| y.is_finite());
            Self {
                name: sensor.name.clone(),
                quantity: sensor.reading,
                unit: sensor.reading.unit(),
                samples: values.clone().count(),
                noise_std: record.as_ref().map(|r| r.noise_std),
                range: [
                    values.clone().copied().fold(f64::NAN, f64::min),
                    values.copied().fold(f64::NAN, f64::max),
                ],
            }
        };
        sensors.iter().zip(&run.further).map(one).collect()
    }
}

impl Quality {
    /// What numbers are of, where the sensor looks elsewhere than at the tip; empty where it does not.
    pub fn elsewhere(&self) -> String {
        self.seen_share.map_or_else(String::new, |share| {
            format!("The sensor looks elsewhere: motions and noise are what it reads over {share:.3}, about those of the tip. ")
        })
    }

    /// The findings that are errors.
    pub fn errors(&self) -> impl Iterator<Item = &Finding> {
        self.findings
            .iter()
            .filter(|finding| finding.severity == Severity::Error)
    }
}

/// Looks at a campaign's data.
pub fn check(campaign: &Campaign) -> Quality {
    let is_tip = campaign.beam.sensor.is_tip();
    let seen_share = (!is_tip).then(|| campaign.beam.seen_share());
    let at_tip: Option<Vec<Run>> =
        seen_share.map(|share| campaign.runs.iter().map(|run| run.over(share)).collect());
    let mut runs: Vec<Examined> = at_tip
        .as_ref()
        .unwrap_or(&campaign.runs)
        .iter()
        .map(|run| Examined::of(run, &campaign.beam))
        .collect();
    let swapped = swapped::swapped(&runs);
    let mut findings = Vec::new();
    let mut scaled = false;
    // Wrong frequencies make the stiffness wrong and leave stick speeds alone; wrong times spoil
    // both.
    let modes = modes::modes(campaign, &runs);
    let misstated = modes
        .as_ref()
        .is_some_and(|finding| finding.severity == Severity::Error)
        && !runs.iter().any(scale::speed_contradicted);
    if misstated {
        runs.iter_mut().for_each(|run| run.stiffness = None);
    }
    let mut scales: Vec<Option<Finding>> = runs.iter().map(scale::scale).collect();
    swapped.iter().for_each(|(at, _)| scales[*at] = None);
    scale::share(&runs, &mut scales);
    for (run, finding) in runs.iter().zip(scales) {
        let timed = finding
            .as_ref()
            .is_none_or(|finding| finding.severity == Severity::Warning);
        scaled |= !timed;
        findings.extend(finding);
        findings.extend(signal::signal(run, &campaign.beam, timed));
    }
    findings.extend(clamp::clamp(campaign));
    for run in &campaign.runs {
        findings.extend(load_cell::load_cell(run, &campaign.further_sensors));
        findings.extend(response::response(run, &campaign.beam));
    }
    findings.extend(swapped.into_iter().map(|(_, finding)| finding));
    if !scaled {
        findings.extend(modes);
        findings.extend(free_swing::free_swing(campaign));
        findings.extend(zero::zero(&runs));
    }
    Quality {
        campaign: campaign.name.clone(),
        measurand: campaign.measurand(),
        seen_share,
        is_pressed: campaign.runs.iter().any(Run::is_pressed),
        runs: runs
            .iter()
            .map(|run| RunQuality::of(run, &campaign.further_sensors))
            .collect(),
        findings: gathered(findings),
    }
}

impl RunQuality {
    fn of(run: &Examined, further_sensors: &[FurtherSensor]) -> RunQuality {
        let (record, motion) = (run.run, &run.motion);
        RunQuality {
            name: record.name.clone(),
            samples: record.time.len(),
            sample_rate_hz: 1.0 / record.sample_interval(),
            noise_std: NoiseStd::of(record.measurand, record.noise.std),
            range_m: motion.range,
            belt_velocity_m_per_s: record.belt_velocity,
            stick_speed_m_per_s: motion.stick_speed,
            stick_share: motion.stick_share,
            mean_friction: run.mean_friction(),
            understood: record.understood.clone(),
            further: ReadingQuality::all(further_sensors, record),
        }
    }
}
