//! Forecasts of the runs kept out: what was measured and what was predicted without another look.

use super::{Material, scaled};
use crate::diagnose::validation::forecast::Forecast;
use crate::report::{Axis, Cell, Colour, Page, Plot, Table, number, with_unit};

const MILLI: f64 = 1e3;
/// Valid times after which a picture ends: what follows is another motion.
const SHOWN: f64 = 3.0;
/// Cycles that a picture shows at least.
const CYCLES: f64 = 8.0;

/// The section; nothing where no run was kept out.
pub fn section(page: Page, material: &Material) -> Page {
    let forecasts = &material.diagnosis.forecast;
    if forecasts.is_empty() {
        return page;
    }
    let mut page = page
        .section("Forecast: runs that the fit has not seen")
        .paragraph(
            "All that the runs share comes from the runs fitted. The first part of each run, up to the first upright line, determines its friction level, \
             offset, phases and state; everything after is predicted without another look. A forecast is valid until its error exceeds 0.4 of the \
             standard deviation of the displacement. The band holds 8 of 10 motions that the data allow as well: constants drawn from what the fit leaves \
             open, and the first part measured again with the sensor's noise. The limit of a forecast is how long the model predicts its own motion from a beginning with the same noise.",
        )
        .table(&table(forecasts));
    for forecast in &forecasts[1..] {
        page = page.figure(&picture(material, forecast).size(1240.0, 260.0));
    }
    page
}

/// The forecast of the first run kept out; the section shows the others.
pub fn first(material: &Material) -> Option<Plot> {
    let forecasts = &material.diagnosis.forecast;
    forecasts.first().map(|first| picture(material, first))
}

fn table(forecasts: &[Forecast]) -> Table {
    let table = Table::new(&[
        "run",
        "learned from",
        "error of one-cycle forecasts (NRMSE)",
        "valid for",
        "limit by the noise",
        "period (predicted | measured)",
        "amplitude (predicted | measured)",
        "stick share (predicted | measured)",
    ]);
    let value = |value: Option<f64>, unit: &str| match value {
        Some(value) => with_unit(value, unit),
        None => "none".to_owned(),
    };
    forecasts.iter().fold(table, |table, f| {
        let pair = |both: crate::diagnose::validation::forecast::Compared, unit: &str| {
            let (predicted, measured) = (value(both.predicted, unit), value(both.measured, unit));
            Cell::Number(format!("{predicted} | {measured}"))
        };
        let (amplitude, unit) = f.amplitude.with_unit();
        table.row(vec![
            Cell::Text(f.run.clone()),
            Cell::Number(with_unit(f.learned_s, "s")),
            Cell::Number(super::verdict::percent(f.one_cycle_nrmse)),
            Cell::Number(with_unit(f.valid_time_s, "s")),
            Cell::Number(with_unit(f.valid_time_limit_s, "s")),
            pair(f.period_s, "s"),
            pair(amplitude, unit),
            pair(f.stick_share, ""),
        ])
    })
}

fn picture(material: &Material, forecast: &Forecast) -> Plot {
    let problem = material.problem;
    let run = &problem.campaign.runs[forecast.index];
    let cycle = problem.smoothings[forecast.index].cycle;
    let cycles = if cycle.is_finite() {
        CYCLES * cycle
    } else {
        0.0
    };
    let end = forecast.learned_s + cycles.max(SHOWN * forecast.valid_time_s);
    let time: Vec<f64> = run.time.iter().map(|t| t - run.time[0]).collect();
    let shown = time.partition_point(|t| *t <= end);
    let (when, predicted) = &forecast.curve;
    let ahead = when.partition_point(|t| *t <= end);
    let plot = Plot::new(
        Axis::linear("time since the run began", "s"),
        super::axis_of(&material.problem.campaign),
    );
    // Without the effect, where one was found.
    let ladder = &material.diagnosis.error_ladder;
    let calibrated = ladder
        .get(1)
        .filter(|_| !material.diagnosis.effects.is_empty());
    let before = calibrated.and_then(|r| r.forecasts.iter().find(|f| f.index == forecast.index));
    let plot = match before {
        Some(before) => {
            let (when, predicted) = &before.curve;
            let ahead = when.partition_point(|t| *t <= end);
            plot.thin_line(
                "calibrated model",
                Colour::Sky,
                &when[..ahead],
                &scaled(&predicted[..ahead], MILLI),
            )
        }
        None => plot,
    };
    let plot = match &forecast.band {
        Some(band) => {
            let shown = band.time.partition_point(|t| *t <= end);
            plot.band(
                "8 of 10 allowed motions",
                Colour::Orange,
                &band.time[..shown],
                &scaled(&band.low[..shown], MILLI),
                &scaled(&band.high[..shown], MILLI),
            )
        }
        None => plot,
    };
    let plot = plot
        // The measured line on top is thinner: where both agree, both are seen.
        .wide_line(
            "forecast",
            Colour::Orange,
            &when[..ahead],
            &scaled(&predicted[..ahead], MILLI),
        )
        .thin_line(
            "measured",
            Colour::Ink,
            &time[..shown],
            &scaled(&run.measured[..shown], MILLI),
        )
        .upright("learning stopped", Colour::Green, forecast.learned_s)
        .upright(
            "valid until here",
            Colour::Grey,
            forecast.learned_s + forecast.valid_time_s,
        );
    plot.caption(&format!(
        "{}, {} m/s, {}: measured motion and its forecast, valid for {} of {} that the noise allows.",
        run.name,
        number(run.belt_velocity, 3),
        with_unit(run.normal_force, "N"),
        with_unit(forecast.valid_time_s, "s"),
        with_unit(forecast.valid_time_limit_s, "s"),
    ))
}
