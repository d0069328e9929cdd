//! Figures 9, 10 and 11: phase plots and spectra at several operating points.

use std::fmt::Write as _;

use beam_physics::sweep::{Motion, Sample, Spectrum, main_frequency, spectrum, trace};

use super::{Claim, PaperFigure, Verdict, Workshop};
use crate::error::Error;
use crate::report::{Axis, Colour, Figure, Plot, number};

/// Length in s and number of samples of what the spectra are made from.
const LENGTH: f64 = 2.0;
const SAMPLES: usize = 1 << 14;
/// Spectra are shown up to this frequency in Hz.
const HIGHEST: f64 = 600.0;

/// A motion at an operating point.
struct Case {
    force: f64,
    velocity: f64,
    motion: Motion,
    samples: Vec<Sample>,
    spectrum: Spectrum,
}

impl Case {
    fn new(workshop: &Workshop, force: f64, velocity: f64) -> Option<Case> {
        let values = workshop.values(&[("normal_force", force), ("belt_velocity", velocity)]);
        let subject = values.subject().ok()?;
        // The large cycle, which the paper's figures show, coexists with a small one near the second mode.
        let motion = workshop.largest(&values)?;
        let samples = trace(&subject, motion.end.as_ref()?, LENGTH, SAMPLES).ok()?;
        let w: Vec<f64> = samples.iter().map(|s| s.displacement).collect();
        Some(Case {
            spectrum: spectrum(&w, LENGTH / SAMPLES as f64),
            force,
            velocity,
            motion,
            samples,
        })
    }

    fn title(&self) -> String {
        format!("{} N, {} mm/s", self.force, number(1e3 * self.velocity, 3))
    }

    /// Amplitude in m of the strongest line within 3 Hz of a frequency.
    fn line(&self, frequency: f64) -> f64 {
        let s = &self.spectrum;
        let at = |f: f64| ((f / s.resolution).max(0.0) as usize).min(s.amplitudes.len() - 1);
        let range = at(frequency - 3.0)..=at(frequency + 3.0);
        s.amplitudes[range].iter().fold(0.0, |a: f64, b| a.max(*b))
    }

    fn main(&self) -> f64 {
        main_frequency(&self.spectrum).unwrap_or(f64::NAN)
    }

    /// Root of the sum of squares of the second to the tenth harmonic over the first.
    fn distortion(&self) -> f64 {
        let f = self.main();
        let harmonics = (2..=10).map(|k| self.line(k as f64 * f).powi(2));
        harmonics.sum::<f64>().sqrt() / self.line(f)
    }

    /// A few cycles in the phase plane.
    fn phase(&self) -> Plot {
        let main = self.main();
        let period = if main.is_finite() { 1.0 / main } else { LENGTH };
        let cycles = self.motion.period.filter(|p| *p > 0).unwrap_or(12) as f64;
        let shown = (period * (cycles + 1.0)).min(LENGTH);
        let curve = self.samples.iter().take_while(|s| s.time <= shown);
        let (w, v): (Vec<f64>, Vec<f64>) =
            curve.map(|s| (1e3 * s.displacement, s.velocity)).unzip();
        Plot::new(
            Axis::linear("tip displacement", "mm"),
            Axis::linear("tip velocity", "m/s"),
        )
        .thin_line("", Colour::Blue, &w, &v)
        .level("belt velocity", Colour::Grey, self.velocity)
        .caption(&format!(
            "Phase plot at {}: {} % of the time in stick.",
            self.title(),
            number(100.0 * self.motion.stick_fraction, 3)
        ))
    }

    fn lines(&self) -> Plot {
        let s = &self.spectrum;
        let count = ((HIGHEST / s.resolution) as usize).min(s.amplitudes.len());
        let f: Vec<f64> = (0..count).map(|k| k as f64 * s.resolution).collect();
        let a: Vec<f64> = s.amplitudes[..count].iter().map(|a| 1e3 * a).collect();
        Plot::new(
            Axis::linear("frequency", "Hz"),
            Axis::log("amplitude", "mm").from_to(1e-6, 3.0),
        )
        .thin_line("", Colour::Blue, &f, &a)
        .upright("natural frequencies", Colour::Grey, 80.0)
        .upright("", Colour::Grey, 510.0)
        .caption(&format!(
            "Amplitude spectrum at {}: main line at {} Hz.",
            self.title(),
            number(self.main(), 4)
        ))
    }

    fn curve_csv(&self, csv: &mut String) {
        for s in self.samples.iter().take(SAMPLES / 8) {
            let _ = writeln!(
                csv,
                "{},{},{},{},{}",
                self.force, self.velocity, s.time, s.displacement, s.velocity
            );
        }
    }

    fn spectrum_csv(&self, csv: &mut String) {
        let s = &self.spectrum;
        let count = ((HIGHEST / s.resolution) as usize).min(s.amplitudes.len());
        for (k, a) in s.amplitudes[..count].iter().enumerate() {
            let f = k as f64 * s.resolution;
            let _ = writeln!(csv, "{},{},{f},{a}", self.force, self.velocity);
        }
    }
}

const CURVES: &str = "normal_force,belt_velocity,time_s,displacement_m,velocity_m_per_s\n";
const LINES: &str = "normal_force,belt_velocity,frequency_hz,amplitude_m\n";

/// The figures.
pub fn figures(workshop: &Workshop) -> Result<Vec<PaperFigure>, Error> {
    workshop.begin("figures 9 to 11: phase plots and spectra");
    let case = |force, velocity| Case::new(workshop, force, velocity);
    let over_velocity: Vec<Case> = [0.04, 0.08, 0.12]
        .into_iter()
        .filter_map(|v| case(100.0, v))
        .collect();
    let over_force: Vec<Case> = [50.0, 80.0, 120.0]
        .into_iter()
        .filter_map(|f| case(f, 0.06))
        .collect();
    let thirty_six: Vec<Case> = [0.02, 0.04, 0.08]
        .into_iter()
        .filter_map(|v| case(36.0, v))
        .collect();
    let (mut curves, mut lines) = (String::from(CURVES), String::from(LINES));
    for case in over_velocity.iter().chain(&over_force) {
        case.curve_csv(&mut curves);
        case.spectrum_csv(&mut lines);
    }
    workshop.data("figure9.csv", &curves)?;
    workshop.data("figure10.csv", &lines)?;
    let mut compared = String::from(CURVES);
    thirty_six.iter().for_each(|c| c.curve_csv(&mut compared));
    workshop.data("figure11.csv", &compared)?;
    Ok(vec![
        phase_plots(&over_velocity, &over_force),
        spectra(&over_velocity, &over_force),
        compared_with_measurement(&thirty_six),
    ])
}

fn list(cases: &[Case], what: impl Fn(&Case) -> String) -> String {
    let all: Vec<String> = cases
        .iter()
        .map(|c| format!("{}: {}", c.title(), what(c)))
        .collect();
    all.join("; ")
}

fn rises(values: impl Iterator<Item = f64>) -> bool {
    let all: Vec<f64> = values.collect();
    all.len() > 1 && all.windows(2).all(|w| w[1] > w[0])
}

fn pictures(
    prefix: &str,
    cases: &[Case],
    plot: impl Fn(&Case) -> Plot,
) -> Vec<(String, Box<dyn Figure>)> {
    cases
        .iter()
        .map(|c| {
            let name = format!(
                "{prefix}_{}N_{}mm_per_s",
                c.force,
                number(1e3 * c.velocity, 3)
            );
            (name, Box::new(plot(c)) as Box<dyn Figure>)
        })
        .collect()
}

fn phase_plots(over_velocity: &[Case], over_force: &[Case]) -> PaperFigure {
    let harmonic = rises(over_velocity.iter().map(|c| -c.distortion()));
    let longer = rises(over_force.iter().map(|c| c.motion.stick_fraction));
    let agreement = |yes: bool| {
        if yes {
            Verdict::Agrees
        } else {
            Verdict::Differs
        }
    };
    let mut shown = pictures("figure9", over_velocity, Case::phase);
    shown.extend(pictures("figure9", over_force, Case::phase));
    PaperFigure {
        number: "9",
        title: "Phase plots (the paper's are measured)".into(),
        claims: vec![
            Claim {
                paper: "An increasing belt velocity leads to more harmonic motions.".into(),
                model: format!(
                    "share of the higher harmonics: {}",
                    list(over_velocity, |c| number(c.distortion(), 3))
                ),
                verdict: agreement(harmonic),
            },
            Claim {
                paper: "An increase of the normal force leads to longer sticking.".into(),
                model: format!(
                    "share of time in stick: {}",
                    list(over_force, |c| number(c.motion.stick_fraction, 3))
                ),
                verdict: agreement(longer),
            },
        ],
        pictures: shown,
    }
}

fn spectra(over_velocity: &[Case], over_force: &[Case]) -> PaperFigure {
    let all: Vec<&Case> = over_velocity.iter().chain(over_force).collect();
    let below = all.iter().filter(|c| c.main() < 80.0).count();
    let frequencies = list(over_velocity, |c| format!("{} Hz", number(c.main(), 3)));
    let hidden = |c: &Case| c.line(80.0).max(c.line(510.0)) / c.line(c.main());
    let largest = all.iter().map(|c| hidden(c)).fold(0.0, f64::max);
    let higher = rises(over_force.iter().map(Case::distortion));
    let mut shown = pictures("figure10", over_velocity, Case::lines);
    shown.extend(pictures("figure10", over_force, Case::lines));
    PaperFigure {
        number: "10",
        title: "Fourier spectra (the paper's are of measured data)".into(),
        claims: vec![
            Claim {
                paper:
                    "The main frequency is about 40 Hz, below the first natural frequency of 80 Hz."
                        .into(),
                model: format!(
                    "{frequencies}; below 80 Hz at {below} of {} operating points",
                    all.len()
                ),
                verdict: if below == all.len() {
                    Verdict::Agrees
                } else {
                    Verdict::InPart
                },
            },
            Claim {
                paper: "The natural frequencies (80 and 510 Hz) do not show up in the spectra."
                    .into(),
                model: format!(
                    "lines within 3 Hz of 80 and 510 Hz reach at most {} % of the main line (harmonics of the main frequency that fall \
                     there included)",
                    number(100.0 * largest, 2)
                ),
                verdict: if largest < 0.1 {
                    Verdict::Agrees
                } else {
                    Verdict::InPart
                },
            },
            Claim {
                paper: "With the normal force higher harmonics show up.".into(),
                model: format!(
                    "share of the higher harmonics: {}",
                    list(over_force, |c| number(c.distortion(), 3))
                ),
                verdict: if higher {
                    Verdict::Agrees
                } else {
                    Verdict::Differs
                },
            },
        ],
        pictures: shown,
    }
}

fn compared_with_measurement(cases: &[Case]) -> PaperFigure {
    let mut shown = pictures("figure11", cases, Case::phase);
    shown.extend(pictures("figure11_spectrum", cases, Case::lines));
    PaperFigure {
        number: "11",
        title: "Simulated motions at 36 N (the paper lays measured ones over them)".into(),
        claims: vec![Claim {
            paper: "Measured and simulated phase plots and spectra coincide within a wide range; the motion is a stable limit cycle.".into(),
            model: format!(
                "the model's motions: {}; the measurements are not at hand, so the comparison itself can't be repeated",
                list(cases, |c| format!(
                    "{}, {} Hz, amplitude {} mm",
                    match c.motion.period {
                        Some(0) | None => "irregular".to_owned(),
                        Some(p) => format!("period {p}"),
                    },
                    number(c.main(), 3),
                    number(1e3 * c.motion.amplitude, 3)
                ))
            ),
            verdict: Verdict::Measured,
        }],
        pictures: shown,
    }
}
