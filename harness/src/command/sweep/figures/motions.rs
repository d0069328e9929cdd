//! Figures 9, 10 and 11: phase plots and spectra at several operating points.

use std::fmt::Write as _;

use beam_physics::sweep::{Motion, Sample, Spectrum, main_frequency, spectrum, trace};

use super::claim::{Bound, Claim, Finding};
use super::{PaperFigure, Workshop};
use crate::command::sweep::table::Result as Row;
use crate::command::sweep::terminal::name;
use crate::error::Error;
use crate::report::{Axis, Colour, Plot, number};

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

/// The least change from one value to the next; NaN where there are no two.
fn least_step(values: &[f64]) -> f64 {
    let steps = values.windows(2).map(|w| w[1] - w[0]);
    steps.reduce(f64::min).unwrap_or(f64::NAN)
}

/// A claim that a number rises from one operating point to the next.
fn rising(what: &str, values: &[f64], unit: &'static str) -> Finding {
    Finding::new(
        format!("least rise of {what} from one operating point to the next"),
        least_step(values),
        unit,
        Bound::Above(0.0),
        "what rises does so at every step",
    )
}

fn pictures(prefix: &str, cases: &[Case], plot: impl Fn(&Case) -> Plot) -> Vec<(String, Plot)> {
    cases
        .iter()
        .map(|c| {
            let name = format!(
                "{prefix}_{}N_{}mm_per_s",
                c.force,
                number(1e3 * c.velocity, 3)
            );
            (name, plot(c))
        })
        .collect()
}

fn phase_plots(over_velocity: &[Case], over_force: &[Case]) -> PaperFigure {
    let mut shown = pictures("figure9", over_velocity, Case::phase);
    shown.extend(pictures("figure9", over_force, Case::phase));
    let harmonics: Vec<f64> = over_velocity.iter().map(Case::distortion).collect();
    let sticks: Vec<f64> = over_force.iter().map(|c| c.motion.stick_fraction).collect();
    PaperFigure {
        number: "9",
        title: "Phase plots (the paper's are measured)".into(),
        claims: vec![
            harmonic_claim(
                &harmonics,
                format!(
                    "Higher harmonics over the first: {}",
                    list(over_velocity, |c| number(c.distortion(), 3))
                ),
            ),
            sticking_claim(
                &sticks,
                format!(
                    "Share of time in stick: {}",
                    list(over_force, |c| number(c.motion.stick_fraction, 3))
                ),
            ),
        ],
        pictures: shown,
    }
}

fn harmonic_claim(harmonics: &[f64], context: String) -> Claim {
    let less: Vec<f64> = harmonics.iter().map(|h| -h).collect();
    Claim::new(
        "An increasing belt velocity leads to more harmonic motions.",
        context,
        vec![Finding::new(
            "least fall of the higher harmonics (second to tenth over the first) from one belt velocity to the next",
            least_step(&less),
            "",
            Bound::Above(0.0),
            "what falls does so at every step",
        )],
    )
}

fn sticking_claim(sticks: &[f64], context: String) -> Claim {
    Claim::new(
        "An increase of the normal force leads to longer sticking.",
        context,
        vec![rising("the share of time in stick", sticks, "")],
    )
}

fn spectra(over_velocity: &[Case], over_force: &[Case]) -> PaperFigure {
    let all: Vec<&Case> = over_velocity.iter().chain(over_force).collect();
    let mains: Vec<f64> = all.iter().map(|c| c.main()).collect();
    let hidden: Vec<f64> = [80.0, 510.0]
        .iter()
        .map(|f| {
            let shares = all.iter().map(|c| 100.0 * c.line(*f) / c.line(c.main()));
            shares.fold(0.0, f64::max)
        })
        .collect();
    let higher: Vec<f64> = over_force.iter().map(Case::distortion).collect();
    let mut shown = pictures("figure10", over_velocity, Case::lines);
    shown.extend(pictures("figure10", over_force, Case::lines));
    let main = |c: &Case| format!("{} Hz", number(c.main(), 3));
    PaperFigure {
        number: "10",
        title: "Fourier spectra (the paper's are of measured data)".into(),
        claims: vec![
            main_claim(
                &mains,
                format!(
                    "Main lines: {}; {}",
                    list(over_velocity, main),
                    list(over_force, main)
                ),
            ),
            hidden_claim([hidden[0], hidden[1]]),
            higher_claim(
                &higher,
                format!(
                    "Higher harmonics over the first: {}",
                    list(over_force, |c| number(c.distortion(), 3))
                ),
            ),
        ],
        pictures: shown,
    }
}

fn main_claim(mains: &[f64], context: String) -> Claim {
    let highest = mains.iter().copied().fold(f64::NAN, f64::max);
    let inside = mains.iter().filter(|f| (30.0..=50.0).contains(*f)).count();
    Claim::new(
        "The main frequency is about 40 Hz, below the first natural frequency of 80 Hz.",
        context,
        vec![
            Finding::new(
                "share of the operating points with a main line of 30 to 50 Hz",
                100.0 * inside as f64 / mains.len().max(1) as f64,
                "%",
                Bound::AtLeast(50.0),
                "about 40 Hz, within a quarter, for most of the motions shown",
            ),
            Finding::new(
                "highest main line",
                highest,
                "Hz",
                Bound::AtMost(80.0),
                "the first natural frequency",
            ),
        ],
    )
}

/// Strongest lines near 80 and 510 Hz in % of the main line.
fn hidden_claim(shares: [f64; 2]) -> Claim {
    let findings = [80.0, 510.0].iter().zip(shares).map(|(f, share)| {
        Finding::new(
            format!(
                "strongest line within 3 Hz of {f} Hz over the main line, at any operating point"
            ),
            share,
            "%",
            Bound::AtMost(10.0),
            "20 dB below the main line; harmonics of the main frequency that fall there count too",
        )
    });
    Claim::new(
        "The natural frequencies (80 and 510 Hz) do not show up in the spectra.",
        "",
        findings.collect(),
    )
}

fn higher_claim(higher: &[f64], context: String) -> Claim {
    Claim::new(
        "With the normal force higher harmonics show up.",
        context,
        vec![rising(
            "the higher harmonics (second to tenth over the first)",
            higher,
            "",
        )],
    )
}

fn compared_with_measurement(cases: &[Case]) -> PaperFigure {
    let mut shown = pictures("figure11", cases, Case::phase);
    shown.extend(pictures("figure11_spectrum", cases, Case::lines));
    let context = format!(
        "The measurements are not at hand: whether curves coincide can't be judged, only whether the model has stable limit cycles. Its motions: {}",
        list(cases, |c| format!(
            "{}, {} Hz, amplitude {} mm",
            name(&Row::of(&c.motion)),
            number(c.main(), 3),
            number(1e3 * c.motion.amplitude, 3)
        ))
    );
    let cycles: Vec<(String, Option<usize>, f64)> = cases
        .iter()
        .map(|c| {
            let exponent = c.motion.lyapunov.unwrap_or(f64::NAN);
            (c.title(), c.motion.period, exponent)
        })
        .collect();
    PaperFigure {
        number: "11",
        title: "Simulated motions at 36 N (the paper lays measured ones over them)".into(),
        claims: vec![stable_claim(&cycles, context)],
        pictures: shown,
    }
}

/// From operating point, period and exponent in 1/s of each motion.
fn stable_claim(cycles: &[(String, Option<usize>, f64)], context: String) -> Claim {
    let repeats = cycles.iter().filter(|c| c.1 == Some(1)).count();
    let mut findings = vec![Finding::new(
        "operating points with a motion of period one",
        repeats as f64,
        "",
        Bound::AtLeast(cycles.len() as f64),
        "a limit cycle at each of the operating points shown",
    )];
    findings.extend(cycles.iter().map(|(title, _, exponent)| {
        Finding::new(
            format!("largest Lyapunov exponent at {title}"),
            *exponent,
            "1/s",
            Bound::AtMost(0.0),
            "disturbances of a stable cycle do not grow",
        )
    }));
    Claim::new(
        "The tip vibrates in a stable limit cycle, which measurement and simulation share.",
        context,
        findings,
    )
}

#[cfg(test)]
mod tests {
    use super::super::claim::Verdict;
    use super::*;

    #[test]
    fn verdicts_come_out_both_ways() {
        let text = String::new;
        let three = |a, b, c| [a, b, c];
        assert_eq!(
            harmonic_claim(&three(0.5, 0.4, 0.3), text()).verdict(),
            Verdict::Agrees
        );
        assert_eq!(
            harmonic_claim(&three(0.5, 0.4, 0.4), text()).verdict(),
            Verdict::Differs
        );
        assert_eq!(
            sticking_claim(&three(0.5, 0.6, 0.7), text()).verdict(),
            Verdict::Agrees
        );
        assert_eq!(
            sticking_claim(&three(0.5, 0.4, 0.7), text()).verdict(),
            Verdict::Differs
        );
        assert_eq!(higher_claim(&[0.1], text()).verdict(), Verdict::Differs);
        assert_eq!(
            higher_claim(&three(0.1, 0.2, 0.3), text()).verdict(),
            Verdict::Agrees
        );
        assert_eq!(
            main_claim(&three(33.0, 41.0, 70.0), text()).verdict(),
            Verdict::Agrees
        );
        assert_eq!(
            main_claim(&three(20.0, 25.0, 70.0), text()).verdict(),
            Verdict::InPart
        );
        assert_eq!(
            main_claim(&three(420.0, 25.0, 70.0), text()).verdict(),
            Verdict::Differs
        );
        assert_eq!(hidden_claim([1.0, 9.0]).verdict(), Verdict::Agrees);
        assert_eq!(hidden_claim([20.0, 9.0]).verdict(), Verdict::InPart);
        assert_eq!(hidden_claim([20.0, 11.0]).verdict(), Verdict::Differs);
        let cycle = |period, exponent| stable_claim(&[("x".into(), period, exponent)], text());
        assert_eq!(cycle(Some(1), -3.0).verdict(), Verdict::Agrees);
        assert_eq!(cycle(Some(5), -3.0).verdict(), Verdict::InPart);
        assert_eq!(cycle(Some(0), 2.0).verdict(), Verdict::Differs);
    }
}
