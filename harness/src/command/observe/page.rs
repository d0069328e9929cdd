//! observer.html.

use super::{Observation, pictures};
use crate::metric::half_width;
use crate::observer::{FittedParameter, LawFit};
use crate::provenance::Provenance;
use crate::report::{Cell, Colour, Page, Table, number, with_unit};

/// The finished document.
pub fn html(o: &Observation, provenance: &Provenance) -> String {
    let lead = format!(
        "Run {} at {} m/s and {}: {}.",
        o.name,
        number(o.belt_velocity, 3),
        with_unit(o.normal_force, "N"),
        o.method.name()
    );
    let quantity = o.measurand.name();
    let title = format!("Friction force from the measured {quantity}");
    let window = pictures::window(o);
    let (colour, headline, text) = verdict(o);
    let mut page = Page::new(&title, &lead)
        .banner(colour, &headline, &text, &[])
        .figure(&pictures::characteristic(o))
        .paragraph(&format!(
            "The structure is known: its natural frequencies, damping and mass. The friction force on its tip is not, so it is \
             estimated together with the motion from the measured {quantity} (Stelter 1992, section 5, and Kalman smoothers)."
        ))
        .table(&summary(o))
        .list(&o.remarks)
        .section("Force over time")
        .figures(&[
            &pictures::force(o, &window),
            &pictures::motion(o, &window),
            &pictures::velocity(o, &window),
        ])
        .section("Friction characteristic")
        .figures(&[&pictures::hysteresis(o)]);
    if !o.laws.is_empty() {
        page = page
            .paragraph(
                "Laws fitted to the characteristic, best first, with 95 % intervals; parameters are named as in the FMU, the residual is the RMS \
                 deviation of the coefficient. The table is in friction_table.set; the option \"set\" of simulate takes it as @friction_table.set.",
            )
            .table(&laws(&o.laws));
    }
    if let Some(dwell) = &o.dwell {
        let verdict = format!("Verdict: {}.", dwell.verdict());
        page = page
            .section("Break-away")
            .paragraph(&verdict)
            .figure(&pictures::break_away(o));
    }
    if !o.pole_speeds.is_empty() {
        page = page
            .section("The paper's observer beside it")
            .paragraph(
                "Difference of the pole-placed observer's force from the force above, over the spread of the force, for several pole speeds. \
                 It knows only the past, so it is late; the last column has the delay taken out.",
            )
            .table(&poles(o));
    }
    page.foot(&provenance.lines()).html()
}

/// What was found, and whether it can be trusted.
fn verdict(o: &Observation) -> (Colour, String, String) {
    let contradicted = o
        .belt_in_stick
        .filter(|belt| belt.contradicts(o.belt_velocity));
    let friction = match (&o.dwell, o.best_law()) {
        (Some(dwell), Some(best)) => format!(
            "Static coefficient {}, scatter {} from stick to stick; in slip the {} law fits best.",
            number(dwell.mu_mean, 3),
            number(dwell.mu_std, 2),
            best.law.name()
        ),
        (Some(dwell), None) => format!(
            "Static coefficient {}, scatter {} from stick to stick.",
            number(dwell.mu_mean, 3),
            number(dwell.mu_std, 2)
        ),
        _ => "The record shows no whole stick phase; the force stands below.".to_owned(),
    };
    match contradicted {
        Some(belt) => (
            Colour::Red,
            format!(
                "The stated belt velocity is off by {:.2} %.",
                100.0 * belt.stated_is_off_by(o.belt_velocity).abs()
            ),
            "The force below rests on the stated one; see the first remark.".to_owned(),
        ),
        None if !o.whiteness.acceptable() => (
            Colour::Orange,
            friction,
            "The beam's data do not explain the record; treat the force with caution.".to_owned(),
        ),
        None => (
            Colour::Green,
            friction,
            "The beam's data explain the record down to white noise.".to_owned(),
        ),
    }
}

fn summary(o: &Observation) -> Table {
    let row = |t: Table, name: &str, value: String| {
        t.row(vec![Cell::Text(name.into()), Cell::Number(value)])
    };
    let frequencies: Vec<String> = o
        .structure
        .modes()
        .iter()
        .map(|m| with_unit(m.frequency_hz, "Hz"))
        .collect();
    let mut table = Table::new(&["quantity", "value"]);
    table = row(table, "natural frequencies", frequencies.join(", "));
    if let Some(belt) = &o.belt_in_stick {
        let text = format!(
            "{:.6} ± {} m/s (95 %)",
            belt.velocity,
            number(half_width(belt.std), 2)
        );
        table = row(
            table,
            "belt velocity, stated",
            format!("{} m/s", o.belt_velocity),
        );
        table = row(table, "belt velocity, from the stick phases", text);
    }
    table = row(
        table,
        "sensor noise",
        with_unit(o.noise_std, o.measurand.unit()),
    );
    table = row(
        table,
        "share of time in stick",
        number(o.stick_fraction(), 3),
    );
    table = row(table, "complete stick phases", o.sticks().to_string());
    table = row(
        table,
        "largest autocorrelation of the innovation (below 0.3 is good)",
        number(o.whiteness.largest_autocorrelation(), 2),
    );
    if let Some(d) = &o.dwell {
        table = row(
            table,
            "static coefficient",
            format!(
                "{}, scatter {} from stick to stick",
                number(d.mu_mean, 3),
                number(d.mu_std, 2)
            ),
        );
    }
    table
}

/// The interval in words.
fn interval(p: &FittedParameter) -> String {
    if p.is_determined() {
        format!("{} to {}", number(p.low, 4), number(p.high, 4))
    } else {
        "not determined by this record".into()
    }
}

fn laws(fits: &[LawFit]) -> Table {
    let mut table = Table::new(&[
        "law",
        "parameter",
        "value",
        "95 % interval",
        "unit",
        "residual",
    ]);
    for fit in fits {
        let name = |first: bool| {
            Cell::Text(if first {
                fit.law.name().into()
            } else {
                String::new()
            })
        };
        if fit.parameters.is_empty() {
            table = table.row(vec![
                name(true),
                Cell::Text("points: friction_table.set".into()),
                Cell::Number(String::new()),
                Cell::Number(String::new()),
                Cell::Text(String::new()),
                Cell::Number(number(fit.residual, 2)),
            ]);
        }
        for (i, p) in fit.parameters.iter().enumerate() {
            table = table.row(vec![
                name(i == 0),
                Cell::Text(p.name.into()),
                Cell::Number(number(p.value, 4)),
                Cell::Number(interval(p)),
                Cell::Text(p.unit.into()),
                Cell::Number(if i == 0 {
                    number(fit.residual, 2)
                } else {
                    String::new()
                }),
            ]);
        }
    }
    table
}

fn poles(o: &Observation) -> Table {
    let header = [
        "pole speed",
        "difference [1]",
        "difference, delay taken out [1]",
    ];
    o.pole_speeds
        .iter()
        .fold(Table::new(&header), |table, (f, causal, shifted)| {
            table.row(vec![
                Cell::Number(with_unit(*f, "Hz")),
                Cell::Number(number(*causal, 3)),
                Cell::Number(number(*shifted, 3)),
            ])
        })
}
