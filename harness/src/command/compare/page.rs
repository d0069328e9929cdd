//! report.html of a comparison.

use super::RunComparison;
use super::comparison::Curves;
use crate::fmu::Fmu;
use crate::measurement::Campaign;
use crate::metric::{Cycle, HARMONICS, quantile};
use crate::report::{Axis, Bars, Cell, Colour, Figure, Page, Plot, Table, number, with_unit};

/// The finished document.
pub fn html(
    fmu: &Fmu,
    campaign: &Campaign,
    comparisons: &[RunComparison],
    limit: Option<f64>,
) -> String {
    let lead = format!(
        "{} against campaign '{}', {} runs, worst first.",
        fmu.description().model_name,
        campaign.name,
        comparisons.len()
    );
    let mut page = Page::new("Model against measurement", &lead)
        .paragraph(
            "NRMSE is the root mean square difference between measurement and model over the spread of the measurement: 0 is a perfect \
             match, 1 is as bad as a constant. A self-excited motion has no clock, and several motions coexist at one operating point. So the \
             model is started from a grid of states, and each measured cycle is compared with the most similar cycle of the model's \
             motions; errors of the period are a column of their own. Pictures show the motion of the model whose amplitude is nearest. Noise is the NRMSE that a perfect model would have.",
        )
        .table(&summary(comparisons, limit))
        .figures(&[&scores(comparisons), &harmonic_error(comparisons)])
        .section("Harmonics")
        .paragraph("Amplitudes at the multiples of each motion's own cycle frequency, model | measured.")
        .table(&harmonics(comparisons));
    for run in comparisons {
        page = run_section(page, run);
    }
    page.html()
}

fn summary(comparisons: &[RunComparison], limit: Option<f64>) -> Table {
    let header = [
        "run",
        "belt velocity",
        "normal force",
        "NRMSE",
        "noise",
        "period",
        "measured",
        "difference",
        "amplitude",
        "measured",
        "difference",
        "stick share",
        "measured",
        "remarks",
    ];
    let text = |t: String| Cell::Number(t);
    let change =
        |model: f64, measured: f64| text(format!("{:+.1} %", 100.0 * (model / measured - 1.0)));
    comparisons.iter().fold(Table::new(&header), |table, run| {
        let score = number(run.nrmse, 3);
        let period = |p: Option<f64>| text(p.map_or("none".into(), |s| with_unit(s, "s")));
        table.row(vec![
            Cell::Text(run.name.clone()),
            text(format!("{} m/s", number(run.belt_velocity_m_per_s, 3))),
            text(with_unit(run.normal_force_n, "N")),
            if limit.is_some_and(|l| !(run.nrmse <= l)) {
                Cell::Alert(score)
            } else {
                Cell::Number(score)
            },
            text(number(run.noise_floor, 2)),
            period(run.model.period),
            period(run.measured.period),
            match (run.model.period, run.measured.period) {
                (Some(model), Some(measured)) => change(model, measured),
                _ => text("–".into()),
            },
            text(with_unit(run.model.amplitude, "m")),
            text(with_unit(run.measured.amplitude, "m")),
            change(run.model.amplitude, run.measured.amplitude),
            text(format!("{:.3}", run.model.stick_fraction)),
            text(format!("{:.3}", run.measured.stick_fraction)),
            Cell::Text(run.remarks.join("; ")),
        ])
    })
}

fn harmonics(comparisons: &[RunComparison]) -> Table {
    let names: Vec<String> = (1..=HARMONICS).map(|k| format!("{k} f")).collect();
    let header: Vec<&str> = std::iter::once("run")
        .chain(names.iter().map(String::as_str))
        .collect();
    comparisons.iter().fold(Table::new(&header), |table, run| {
        let value =
            |list: &[f64], k: usize| list.get(k).map_or("–".into(), |v| with_unit(*v, "m"));
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

fn scores(comparisons: &[RunComparison]) -> Bars {
    let names: Vec<String> = comparisons.iter().map(|r| r.name.clone()).collect();
    let values = |f: fn(&RunComparison) -> f64| comparisons.iter().map(f).collect::<Vec<_>>();
    Bars::new(Axis::linear("NRMSE", "1"), &names)
        .series("model error", Colour::Orange, &values(|r| r.nrmse))
        .series(
            "noise, which no model removes",
            Colour::Grey,
            &values(|r| r.noise_floor),
        )
        .caption(
            "How far the model is from each measured run, against the share that is only noise.",
        )
}

fn harmonic_error(comparisons: &[RunComparison]) -> Plot {
    let order: Vec<f64> = (1..=HARMONICS).map(|k| k as f64).collect();
    let axes = Plot::new(
        Axis::linear("harmonic", "1").from_to(0.7, HARMONICS as f64 + 0.3),
        Axis::log("amplitude", "µm"),
    );
    let plot = comparisons
        .iter()
        .zip(Colour::SERIES)
        .fold(axes, |plot, (run, colour)| {
            let micro = |list: &[f64]| list.iter().map(|a| a * 1e6).collect::<Vec<_>>();
            plot.line(&run.name, colour, &order, &micro(&run.model.harmonics))
                .scatter("", colour, &order, &micro(&run.measured.harmonics))
        });
    plot.caption(
        "Amplitudes of the harmonics of the cycle: lines are the model, points the measurement.",
    )
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
    page.section(&title).figures(&figures)
}

const MILLI: f64 = 1e3;
const MICRO: f64 = 1e6;

fn scaled(values: &[f64], factor: f64) -> Vec<f64> {
    values.iter().map(|v| v * factor).collect()
}

fn cycle_overlay(run: &RunComparison, measured: &Cycle, model: &Cycle) -> Plot {
    let phases = measured.mean.len();
    let period = run.measured.period.unwrap_or(1.0) * MILLI;
    let at = |i: usize| period * i as f64 / phases as f64;
    let time: Vec<f64> = (0..phases).map(at).collect();
    let edge = |sign: f64| {
        measured
            .mean
            .iter()
            .zip(&measured.std)
            .map(|(m, s)| (m + sign * s) * MILLI)
            .collect::<Vec<_>>()
    };
    let sticks: Vec<(f64, f64)> = stretches(&run.curves.cycle_sticks)
        .into_iter()
        .map(|(a, b)| (at(a), at(b)))
        .collect();
    Plot::new(Axis::linear("time in the cycle", "ms").from_to(0.0, period), Axis::linear("tip displacement", "mm"))
        .shade("measured tip sticks", Colour::Sky, &sticks)
        .band("scatter of the cycles (1 std)", Colour::Grey, &time, &edge(-1.0), &edge(1.0))
        .line("measured", Colour::Ink, &time, &scaled(&measured.mean, MILLI))
        .line("model", Colour::Orange, &time, &scaled(&model.mean, MILLI))
        .caption(&format!(
            "The average cycle, of {} measured and {} of the model; both are stretched to the measured period and the model is turned to fit.",
            measured.cycles, model.cycles
        ))
}

/// Index ranges in which `flags` is true.
fn stretches(flags: &[bool]) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut first = 0;
    for stretch in flags.chunk_by(|a, b| a == b) {
        if stretch[0] {
            found.push((first, first + stretch.len()));
        }
        first += stretch.len();
    }
    found
}

fn phase_plane(run: &RunComparison) -> Plot {
    let curves = &run.curves;
    let stick = &curves.measured_stick;
    let stuck: Vec<f64> = curves
        .measured
        .iter()
        .zip(&stick.sticks)
        .filter(|(_, s)| **s)
        .map(|(w, _)| *w)
        .collect();
    let (low, high) = (
        run.belt_velocity_m_per_s - stick.tolerance,
        run.belt_velocity_m_per_s + stick.tolerance,
    );
    let plot = Plot::new(
        Axis::linear("tip displacement", "mm"),
        Axis::linear("tip velocity", "m/s"),
    );
    let plot = if stuck.is_empty() {
        plot
    } else {
        let ends = [
            quantile(&stuck, 0.005) * MILLI,
            quantile(&stuck, 0.995) * MILLI,
        ];
        plot.band(
            "stick: the tip moves with the belt",
            Colour::Sky,
            &ends,
            &[low; 2],
            &[high; 2],
        )
    };
    plot.thin_line("measured", Colour::Ink, &scaled(&curves.measured, MILLI), &stick.velocity)
        .thin_line("model", Colour::Orange, &scaled(&curves.model.0, MILLI), &curves.model.1)
        .caption("Phase plane: velocity over displacement of the tip, the stick phase shaded where the measured tip keeps the belt's velocity.")
}

fn spectra(curves: &Curves) -> Plot {
    let (measured, model) = &curves.spectra;
    let nyquist = measured.frequency.last().copied().unwrap_or(1.0);
    let shown = nyquist.min(1500.0);
    let highest = measured
        .amplitude
        .iter()
        .chain(&model.amplitude)
        .fold(0.0_f64, |m, a| m.max(*a))
        * MICRO;
    // Below a tenth of the noise there is nothing to compare.
    let floor = (0.1 * quantile(&measured.amplitude, 0.5) * MICRO).max(1e-6 * highest);
    Plot::new(
        Axis::linear("frequency", "Hz").from_to(0.0, shown),
        Axis::log("amplitude", "µm").from_to(floor, 2.0 * highest),
    )
    .thin_line(
        "measured",
        Colour::Ink,
        &measured.frequency,
        &scaled(&measured.amplitude, MICRO),
    )
    .thin_line(
        "model",
        Colour::Orange,
        &model.frequency,
        &scaled(&model.amplitude, MICRO),
    )
    .caption("Amplitude spectra of the tip displacement (Hann window over the whole record).")
}

fn residual(run: &RunComparison) -> Plot {
    let noise = 2.0 * run.noise_std_m * MICRO;
    Plot::new(
        Axis::linear("time", "s"),
        Axis::linear("measured minus model", "µm"),
    )
    .thin_line(
        "residual",
        Colour::Red,
        &run.curves.time,
        &scaled(&run.curves.residual, MICRO),
    )
    .level("2 std of the noise", Colour::Grey, noise)
    .level("", Colour::Grey, -noise)
    .caption("What the model misses over time: each measured cycle minus the most similar cycle of the model.")
}
