//! report.html of a comparison.

use super::RunComparison;
use super::pictures::{
    cycle_overlay, further_series, harmonic_error, phase_plane, residual, scores, spectra,
    time_series,
};
use super::terminal::{FROM_STARTS, FURTHER};
use crate::command::data_quality;
use crate::fmu::Fmu;
use crate::measurement::Campaign;
use crate::metric::HARMONICS;
use crate::provenance::Provenance;
use crate::report::{Cell, Colour, Figure, Page, Table, number, with_unit};

/// The finished document.
pub fn html(
    fmu: &Fmu,
    campaign: &Campaign,
    comparisons: &[RunComparison],
    limit: Option<f64>,
    provenance: &Provenance,
) -> String {
    let lead = format!(
        "{} against campaign '{}', {} runs, worst first.",
        fmu.description().model_name,
        campaign.name,
        comparisons.len()
    );
    let (colour, headline, text) = verdict(comparisons);
    let page = Page::new("Model against measurement", &lead)
        .banner(colour, &headline, &text, &[])
        .figure(&scores(comparisons))
        .table(&summary(comparisons, limit));
    let mut page = further_sensors(from_start_states(page, comparisons), comparisons)
        .paragraph(
            "NRMSE is the root mean square difference between measurement and model over the spread of the measurement: 0 is a perfect \
             match, 1 is as bad as a constant. Noise is the NRMSE that a perfect model would have. A self-excited motion has no clock, and \
             several motions coexist at one operating point. So the model is started from a grid of states, and each measured cycle is \
             compared with the most similar cycle that the model makes; the pictures show the model put together in this way. Its period \
             is the one exception: that is taken from the model's own motion, the one with the nearest amplitude.",
        );
    page = data_quality::section(page, campaign)
        .section("Harmonics")
        .figure(&harmonic_error(comparisons))
        .paragraph("Amplitudes at the multiples of the cycle frequency, model | measured.")
        .table(&harmonics(comparisons));
    for run in comparisons {
        page = run_section(page, run);
    }
    page.foot(&provenance.lines()).html()
}

/// An error above this multiple of the noise is more than the sensor explains; what lies between is for the reader to judge.
const BEYOND_NOISE: f64 = 3.0;

/// How well the model does, in a few words: for all runs, and for the worst.
fn verdict(comparisons: &[RunComparison]) -> (Colour, String, String) {
    let over_noise = |run: &RunComparison| run.nrmse / run.noise_floor;
    let explained = |run: &&RunComparison| over_noise(run) <= BEYOND_NOISE;
    let close = comparisons.iter().filter(explained).count();
    let (colour, headline) = match comparisons.len() {
        all if close == all => (
            Colour::Green,
            "The model explains every run within three times the sensor's noise.".to_owned(),
        ),
        all => (
            Colour::Orange,
            format!(
                "In {} of {all} runs the model is off by more than three times the sensor's noise.",
                all - close
            ),
        ),
    };
    let text = comparisons.first().map_or(String::new(), |worst| {
        format!(
            "Worst: {} with an error (NRMSE) of {}, {} times the noise.",
            worst.name,
            number(worst.nrmse, 3),
            number(over_noise(worst), 2)
        )
    });
    (colour, headline, text)
}

fn summary(comparisons: &[RunComparison], limit: Option<f64>) -> Table {
    let header = [
        "run",
        "belt velocity",
        "normal force",
        "NRMSE",
        "noise",
        "period, measured",
        "period, model",
        "differs by",
        "amplitude, measured",
        "amplitude, model",
        "differs by",
        "stick share, measured",
        "stick share, model",
    ];
    let text = |t: String| Cell::Number(t);
    let change = |model: f64, measured: f64| {
        // Rounded first, and plus zero, so that nothing reads -0.0.
        let percent = (1e3 * (model / measured - 1.0)).round() / 10.0 + 0.0;
        text(format!("{percent:+.1} %"))
    };
    let period = |p: Option<f64>| text(p.map_or("none".into(), |s| with_unit(s, "s")));
    comparisons.iter().fold(Table::new(&header), |table, run| {
        let score = number(run.nrmse, 3);
        let unit = run.curves.measurand.unit();
        table.row(vec![
            Cell::Text(run.name.clone()),
            text(format!("{} m/s", number(run.belt_velocity_m_per_s, 3))),
            text(with_unit(run.normal_force_n, "N")),
            if limit.is_some_and(|l| run.exceeds(l)) {
                Cell::Alert(score)
            } else {
                Cell::Number(score)
            },
            text(number(run.noise_floor, 2)),
            period(run.measured.period),
            period(run.model.period),
            match (run.model.period, run.measured.period) {
                (Some(model), Some(measured)) => change(model, measured),
                _ => text("–".into()),
            },
            text(with_unit(run.measured.amplitude, unit)),
            text(with_unit(run.model.amplitude, unit)),
            change(run.model.amplitude, run.measured.amplitude),
            text(dash(run.measured.stick_fraction)),
            text(dash(run.model.stick_fraction)),
        ])
    })
}

/// The error from start states that the FMU holds, if it holds any.
fn from_start_states(page: Page, comparisons: &[RunComparison]) -> Page {
    if comparisons
        .iter()
        .all(|r| r.nrmse_from_start_states.is_none())
    {
        return page;
    }
    let header = ["run", "NRMSE from start states", "noise", "over the noise"];
    let table = comparisons.iter().fold(Table::new(&header), |table, run| {
        let error = run.nrmse_from_start_states;
        let shown = |value: Option<f64>| value.map_or("–".into(), |v| number(v, 3));
        table.row(vec![
            Cell::Text(run.name.clone()),
            Cell::Number(shown(error)),
            Cell::Number(number(run.noise_floor, 2)),
            Cell::Number(shown(error.map(|e| e / run.noise_floor))),
        ])
    });
    page.paragraph(&format!("{FROM_STARTS}.")).table(&table)
}

/// What further sensors read, if there are any.
fn further_sensors(page: Page, comparisons: &[RunComparison]) -> Page {
    if comparisons.iter().all(|r| r.further_sensors.is_empty()) {
        return page;
    }
    let header = [
        "run", "sensor", "quantity", "NRMSE", "noise", "factor", "readings",
    ];
    let rows = comparisons
        .iter()
        .flat_map(|run| run.further_sensors.iter().map(move |sensor| (run, sensor)));
    let table = rows.fold(Table::new(&header), |table, (run, sensor)| {
        table.row(vec![
            Cell::Text(run.name.clone()),
            Cell::Text(sensor.name.clone()),
            Cell::Text(sensor.quantity.replace('_', " ")),
            Cell::Number(number(sensor.nrmse, 3)),
            Cell::Number(number(sensor.noise_floor, 2)),
            Cell::Number(number(sensor.factor, 3)),
            Cell::Number(sensor.samples.to_string()),
        ])
    });
    page.paragraph(&format!("{FURTHER}.")).table(&table)
}

fn harmonics(comparisons: &[RunComparison]) -> Table {
    let names: Vec<String> = (1..=HARMONICS).map(|k| format!("{k} f")).collect();
    let header: Vec<&str> = std::iter::once("run")
        .chain(names.iter().map(String::as_str))
        .collect();
    comparisons.iter().fold(Table::new(&header), |table, run| {
        let unit = run.curves.measurand.unit();
        let value =
            |list: &[f64], k: usize| list.get(k).map_or("–".into(), |v| with_unit(*v, unit));
        let pair = |k| {
            Cell::Number(format!(
                "{} | {}",
                value(&run.model.harmonics, k),
                value(&run.measured.harmonics, k)
            ))
        };
        table.row(
            std::iter::once(Cell::Text(run.name.clone()))
                .chain((0..HARMONICS).map(pair))
                .collect(),
        )
    })
}

fn run_section(page: Page, run: &RunComparison) -> Page {
    let title = format!(
        "{}: {} m/s, {}, NRMSE {}",
        run.name,
        number(run.belt_velocity_m_per_s, 3),
        with_unit(run.normal_force_n, "N"),
        number(run.nrmse, 3)
    );
    let curves = &run.curves;
    let (plane, spectra, residual) = (phase_plane(run), spectra(curves), residual(run));
    let overlay = curves
        .cycles
        .as_ref()
        .map(|(measured, model)| cycle_overlay(run, measured, model));
    let first = overlay.as_ref().map(|plot| plot as &dyn Figure);
    let figures: Vec<&dyn Figure> = first
        .into_iter()
        .chain([&plane as &dyn Figure, &spectra, &residual])
        .collect();
    let page = page.section(&title);
    let page = if run.remarks.is_empty() {
        page
    } else {
        page.list(&run.remarks)
    };
    let page = page.figure(&time_series(curves)).figures(&figures);
    let sensors = run.further_sensors.iter();
    sensors.fold(page, |page, sensor| {
        page.figure(&further_series(&curves.time, sensor))
    })
}

/// A share of time, a dash where it is not known.
fn dash(share: f64) -> String {
    match share.is_finite() {
        true => format!("{share:.3}"),
        false => "–".into(),
    }
}
