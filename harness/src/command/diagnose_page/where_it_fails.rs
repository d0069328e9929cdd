//! Where the predictions fail, on the first page: one error in six pictures, each with the sentence that follows from its numbers.

use super::Material;
use super::ladder::dumbbells;
use super::views::COLOURS;
use crate::diagnose::data::contact_phase::ContactPhase;
use crate::diagnose::explanation::spectrum::median_over_noise;
use crate::diagnose::explanation::where_it_fails::{
    CHANCE, COLUMNS, ErrorOver, FACTOR, ROWS, SHUFFLES, WhereItFails,
};
use crate::diagnose::result::diagnosis::Verdict;
use crate::measurement::Run;
use crate::metric::half_width;
use crate::report::{Axis, Colour, Matrix, Page, Plot, number};

/// Size of a small picture, px.
const SIZE: (f64, f64) = (400.0, 270.0);

/// The error of both models.
struct Both<'a> {
    material: &'a Material<'a>,
    /// Before, after.
    errors: [WhereItFails; 2],
    /// Which of them is the calibrated model, of which the sentences speak.
    calibrated: usize,
}

/// The section.
pub fn section(page: Page, material: &Material) -> Page {
    let [before, after] = &material.views.pair;
    let both = Both {
        material,
        errors: [before, after].map(|v| WhereItFails::new(material.problem, &v.replays)),
        calibrated: usize::from(
            material.diagnosis.verdict == Verdict::NoMissingEffect || material.steps.len() == 1,
        ),
    };
    page.section(super::SECTIONS[2])
        .paragraph(&both.lead())
        .small_figures(&[
            &both.by_contact_phase(),
            &both.plane(),
            &both.by_place(),
            &both.by_time(),
            &both.by_operating_point(),
            &both.by_frequency(),
        ])
        .paragraph(&format!(
            "A dependence is called one where the levels differ by more than {FACTOR} times (less is no clue, and a level below the noise counts as the noise) and by more than chance \
             makes: in no more than {} of {SHUFFLES} random exchanges of whole predictions between the intervals may they be as far apart. \
             Where each place is passed once, place and time go together within a run.",
            (CHANCE * (SHUFFLES + 1) as f64) as usize - 1
        ))
}

impl Both<'_> {
    fn lead(&self) -> String {
        let name = |view: usize| self.material.views.pair[view].name.as_str();
        let range = |view: usize| {
            let ranges = self.errors[view]
                .all()
                .into_iter()
                .filter_map(ErrorOver::range);
            ranges.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
        };
        let other = match (self.calibrated, range(1)) {
            (0, Some((low, high))) => format!(
                " {}, the error lies between {} and {} times the noise in all six.",
                capital(name(1)),
                number(low, 2),
                number(high, 2)
            ),
            _ => String::new(),
        };
        format!(
            "The error of the calibrated model's predictions over the noise (median of the samples): 1 is the floor, where nothing is left to be explained. \
             The sentences speak of the calibrated model.{other}"
        )
    }

    /// The sentence about the calibrated model.
    fn said(&self, of: impl Fn(&WhereItFails) -> &ErrorOver) -> String {
        of(&self.errors[self.calibrated]).statement.clone()
    }

    fn by_contact_phase(&self) -> Plot {
        let names: Vec<String> = ContactPhase::ALL
            .iter()
            .map(|m| m.name().to_owned())
            .collect();
        let values = self.errors.each_ref().map(|e| {
            let levels = e.contact_phase.levels.iter();
            levels.map(|l| l.over_noise).collect::<Vec<f64>>()
        });
        let [before, after] = &self.material.views.pair;
        dumbbells(
            Axis::log("error over noise", "1"),
            &names,
            &values,
            [&before.name, &after.name],
        )
        .upright("noise", Colour::Green, 1.0)
        .size(SIZE.0, SIZE.1)
        .caption(&self.said(|e| &e.contact_phase))
    }

    fn plane(&self) -> Matrix {
        let plane = &self.errors[self.calibrated].plane;
        let rows: Vec<String> = plane.rows.iter().map(|w| number(*w, 2)).collect();
        let columns: Vec<String> = plane.levels[..COLUMNS]
            .iter()
            .enumerate()
            .map(|(c, l)| match c {
                0 => "stick".to_owned(),
                _ => number(l.middle, 2),
            })
            .collect();
        // Displacement upwards, as in every plot.
        let values = (0..ROWS).rev().map(|r| {
            let row = &plane.levels[r * COLUMNS..(r + 1) * COLUMNS];
            row.iter().map(|l| l.over_noise).collect()
        });
        Matrix::new(
            "tip displacement [mm]",
            &rows.into_iter().rev().collect::<Vec<String>>(),
            "relative velocity in slip [m/s]",
            &columns,
            values.collect(),
        )
        .logarithmic()
        .caption(&format!(
            "{} (In the cells: error over noise of the model {}{}.)",
            plane.statement,
            self.material.views.pair[self.calibrated].name,
            match plane.range() {
                Some((_, high)) if high > 9999.0 => "; k: thousand",
                _ => "",
            }
        ))
    }

    fn by_place(&self) -> Plot {
        let place = &self.errors[self.calibrated].place;
        let mut plot = Plot::new(
            Axis::linear("belt travel", "mm"),
            Axis::log("error over noise", "1"),
        )
        .size(SIZE.0, SIZE.1);
        for (r, run) in self.material.problem.campaign.runs.iter().enumerate() {
            let of = place.levels.iter().filter(|l| l.stratum == r);
            let (x, y): (Vec<f64>, Vec<f64>) = of.map(|l| (l.middle, l.over_noise)).unzip();
            if y.iter().any(|v| v.is_finite()) {
                let colour = Colour::SERIES[r % Colour::SERIES.len()];
                plot = plot
                    .line(&run.name, colour, &x, &y)
                    .scatter("", colour, &x, &y);
            }
        }
        plot.level("noise", Colour::Green, 1.0)
            .caption(&place.statement)
    }

    fn by_time(&self) -> Plot {
        let mut plot = Plot::new(
            Axis::linear("time since the run began", "s"),
            Axis::log("error over noise", "1"),
        )
        .size(SIZE.0, SIZE.1);
        for (view, colour) in COLOURS.iter().enumerate() {
            let levels = &self.errors[view].time.levels;
            let known: Vec<_> = levels.iter().filter(|l| l.is_known()).collect();
            let x: Vec<f64> = known.iter().map(|l| l.middle).collect();
            let y: Vec<f64> = known.iter().map(|l| l.over_noise).collect();
            let edge = |sign: f64| -> Vec<f64> {
                let of = known.iter();
                of.map(|l| l.over_noise * (sign * half_width(l.std_of_log())).exp())
                    .collect()
            };
            plot = plot
                .band("", *colour, &x, &edge(-1.0), &edge(1.0))
                .line(&self.material.views.pair[view].name, *colour, &x, &y)
                .scatter("", *colour, &x, &y);
        }
        plot.level("noise", Colour::Green, 1.0).caption(&format!(
            "{} (Bands: 95 % intervals.)",
            self.said(|e| &e.time)
        ))
    }

    fn by_operating_point(&self) -> Plot {
        let problem = self.material.problem;
        let runs = &problem.campaign.runs;
        let axis = |name: &str, unit: &str, of: fn(&Run) -> f64, beyond: f64| {
            let low = runs.iter().map(of).fold(f64::INFINITY, f64::min);
            let high = runs.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
            let width = (high - low).max(0.1 * high.abs()).max(1e-6);
            Axis::linear(name, unit).from_to(low - 0.08 * width, high + beyond * width)
        };
        // Room for the numbers, which stand above the points and to their right.
        let speed = axis("belt velocity", "m/s", |r| r.belt_velocity, 0.35);
        let force = axis("normal force", "N", |r| r.normal_force, 0.14);
        let mut plot = Plot::new(speed, force).size(SIZE.0, SIZE.1);
        let [before, after] = self.errors.each_ref().map(|e| &e.operating_point.levels);
        for (held, name, colour) in [
            (false, "fitted", Colour::Purple),
            (true, "kept out", Colour::Green),
        ] {
            let (mut x, mut y, mut texts) = (Vec::new(), Vec::new(), Vec::new());
            for (b, a) in before.iter().zip(after) {
                let run = b.middle as usize;
                if problem.held_out[run] == held {
                    x.push(runs[run].belt_velocity);
                    y.push(runs[run].normal_force);
                    let [b, a] = [b, a].map(|l| number(l.over_noise, 2));
                    texts.push(format!("{b} → {a}"));
                }
            }
            if !x.is_empty() {
                plot = plot
                    .scatter(name, colour, &x, &y)
                    .notes(colour, &x, &y, &texts);
            }
        }
        let [before, after] = &self.material.views.pair;
        plot.caption(&format!(
            "{} (Numbers: error over noise {} → {}.)",
            self.said(|e| &e.operating_point),
            before.name,
            after.name
        ))
    }

    /// The spectrum line by line; the sentence is about its octaves.
    fn by_frequency(&self) -> Plot {
        let problem = self.material.problem;
        let calibrated = &self.material.diagnosis.calibrated;
        let modes = || {
            let named = calibrated.iter();
            named.filter(|(n, _)| n.ends_with("].frequency"))
        };
        let highest = modes().map(|m| m.1.value).fold(0.0, f64::max);
        let runs = problem.campaign.runs.iter();
        let nyquist = runs
            .map(|r| 0.5 / r.sample_interval())
            .fold(f64::INFINITY, f64::min);
        let mut plot = Plot::new(
            Axis::log("frequency", "Hz").from_to(
                0.9 / problem.horizon,
                nyquist.min((4.0 * highest).max(1000.0)),
            ),
            Axis::log("error over white noise", "1"),
        )
        .size(SIZE.0, SIZE.1);
        for (view, colour) in self.material.views.pair.iter().zip(COLOURS) {
            let lines = median_over_noise(problem, &view.replays);
            let (frequency, level): (Vec<f64>, Vec<f64>) = lines.into_iter().unzip();
            plot = plot.line(&view.name, colour, &frequency, &level);
        }
        for (i, (_, value)) in modes().enumerate() {
            let name = if i == 0 { "modes" } else { "" };
            plot = plot.upright(name, Colour::Grey, value.value);
        }
        plot.level("white noise", Colour::Green, 1.0)
            .caption(&self.said(|e| &e.frequency))
    }
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters
        .next()
        .map_or(String::new(), |l| l.to_uppercase().chain(letters).collect())
}
