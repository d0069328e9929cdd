//! An effect explained on a page, with pictures of what it does to the motion.

use super::motion::{self, Motion, typical};
use super::shown;
use crate::command::operating_options::Said;
use crate::command::operating_point::OperatingPoint;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::fmu::effect_card::EffectCard;
use crate::provenance::Provenance;
use crate::report::{Axis, Cell, Colour, Page, Plot, Table, number, with_unit};

/// The page about an effect. `said` holds the operating point, and values in place of the typical ones.
///
/// # Errors
/// A start value that the FMU refuses, or a motion that it can't go on with.
pub fn html(fmu: &Fmu, card: &EffectCard, said: &Said) -> Result<String, Error> {
    let mut items = vec![format!("Equation: {}", card.equation)];
    for (heading, text) in [
        ("How it shows", &card.signature),
        ("What looks alike", &card.confounders),
        ("Source", &card.source),
    ] {
        if !text.is_empty() {
            items.push(format!("{heading}: {text}"));
        }
    }
    let page = Page::new(&card.id, &card.title)
        .paragraph(&card.description)
        .list(&items);
    let page = if motion::can_be_shown(fmu) {
        pictures(page, fmu, card, said)?
    } else {
        page.paragraph(
            "The FMU has no measured_displacement, friction_force and relative_velocity, so what the effect does can't be shown.",
        )
    };
    let provenance = Provenance::of(&[])?;
    Ok(page.foot(&provenance.lines()).html())
}

fn pictures(page: Page, fmu: &Fmu, card: &EffectCard, said: &Said) -> Result<Page, Error> {
    let (belt_velocity, normal_force) = said.load();
    let own = |name: &str| name.starts_with(&format!("{}.", card.id));
    let point = OperatingPoint {
        belt_velocity,
        normal_force,
        settings: Vec::new(),
        ..OperatingPoint::default()
    };
    let others: Vec<_> = said
        .settings
        .iter()
        .filter(|s| !own(&s.0))
        .cloned()
        .collect();
    let without = point.with(&others);
    let state = motion::state_on_the_cycle(fmu, &without)?;
    let without = without.with(&state).with(&others);
    let with = without.clone().with(&typical(card)).with(&said.settings);
    let (reference, changed) = (motion::motion(fmu, &without)?, motion::motion(fmu, &with)?);
    let at = format!(
        "{} m/s and {}",
        number(belt_velocity, 3),
        with_unit(normal_force, "N")
    );
    let caption = sentence(&card.id, &at, &reference, &changed);
    let numbers = numbers(&reference, &changed);
    let end = reference.shown();
    let pair = [
        ("reference model", Colour::Grey, reference.until(end)),
        (card.id.as_str(), Colour::Blue, changed.until(end)),
    ];
    Ok(page
        .section("What it does")
        .paragraph("Both motions start in the same state on the reference model's cycle, in which a cycle begins; the numbers below are of the motions 1.5 to 2 s later.")
        .figures(&[&displacement(&pair).caption(&caption), &force(&pair).caption(&format!(
            "Friction force on the tip over the relative velocity in the same cycles, at {at}: the upright part at zero is stick."
        ))])
        .table(&numbers)
        .section("Parameters")
        .table(&parameters(card, &with)))
}

type Pair<'a> = [(&'a str, Colour, Motion); 2];

fn displacement(pair: &Pair) -> Plot {
    let plot = Plot::new(
        Axis::linear("time", "ms"),
        Axis::linear("measured displacement", "mm"),
    );
    pair.iter().fold(plot, |plot, (name, colour, motion)| {
        plot.line(
            name,
            *colour,
            &scaled(&motion.time),
            &scaled(&motion.displacement),
        )
    })
}

fn force(pair: &Pair) -> Plot {
    let plot = Plot::new(
        Axis::linear("relative velocity", "m/s"),
        Axis::linear("friction force", "N"),
    );
    pair.iter().fold(plot, |plot, (name, colour, motion)| {
        plot.thin_line(name, *colour, &motion.relative_velocity, &motion.force)
    })
}

/// In thousandths of the unit.
fn scaled(values: &[f64]) -> Vec<f64> {
    values.iter().map(|v| 1e3 * v).collect()
}

/// What the picture of the displacement shows, from its numbers.
fn sentence(id: &str, at: &str, reference: &Motion, changed: &Motion) -> String {
    let change = |from: f64, to: f64, unit: &str| {
        let relative = 100.0 * (to / from - 1.0);
        let percent = match relative {
            r if r.abs() < 0.05 => "unchanged".to_owned(),
            r => format!("{}{} %", if r > 0.0 { "+" } else { "" }, number(r, 2)),
        };
        format!(
            "from {} to {} ({percent})",
            with_unit(from, unit),
            with_unit(to, unit)
        )
    };
    let period = match reference.period.is_finite() && changed.period.is_finite() {
        true => format!(
            "the period goes {} and ",
            change(reference.period, changed.period, "s")
        ),
        false => String::new(),
    };
    format!(
        "From the same state at {at} {id}, at the strength below, takes the tip by up to {} % of the amplitude away from the reference model's motion in these cycles; once settled {period}the amplitude goes {}.",
        number(100.0 * changed.apart(reference, reference.shown()), 2),
        change(reference.amplitude, changed.amplitude, "m")
    )
}

fn numbers(reference: &Motion, changed: &Motion) -> Table {
    let row = |name: &str, of: fn(&Motion) -> String| {
        let number = |m: &Motion| Cell::Number(of(m));
        vec![
            Cell::Text(name.to_owned()),
            number(reference),
            number(changed),
        ]
    };
    Table::new(&["", "reference model", "with the effect"])
        .row(row("period", |m| with_unit(m.period, "s")))
        .row(row("amplitude", |m| with_unit(m.amplitude, "m")))
        .row(row("share of the time at rest on the belt", |m| {
            format!("{} %", number(100.0 * m.stick_share, 3))
        }))
}

fn parameters(card: &EffectCard, with: &OperatingPoint) -> Table {
    let header = [
        "FMU variable",
        "in the pictures",
        "off",
        "from",
        "to",
        "unit",
        "what it is",
    ];
    shown(card).fold(Table::new(&header), |table, p| {
        let name = format!("{}.{}", card.id, p.name);
        let set = with.settings.iter().rfind(|s| s.0 == name);
        let value = |v: f64| Cell::Number(number(v, 4));
        table.row(vec![
            Cell::Text(name.clone()),
            value(set.map_or(p.start, |s| s.1)),
            value(p.start),
            value(p.min),
            value(p.max),
            Cell::Text(p.unit.clone()),
            Cell::Text(p.description.clone()),
        ])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(period: f64, amplitude: f64) -> Motion {
        Motion {
            time: vec![0.0],
            displacement: vec![amplitude],
            force: vec![0.0],
            relative_velocity: vec![0.0],
            period,
            amplitude,
            stick_share: 0.5,
        }
    }

    #[test]
    fn the_sentence_follows_from_the_numbers() {
        let reference = motion(0.03, 1e-3);
        let told =
            |changed: &Motion| sentence("third_mode", "0.1 m/s and 100 N", &reference, changed);
        assert_eq!(
            told(&motion(0.033, 0.9e-3)),
            "From the same state at 0.1 m/s and 100 N third_mode, at the strength below, takes the tip by up to 10 % of the amplitude away \
             from the reference model's motion in these cycles; once settled the period goes from 30 ms to 33 ms (+10 %) and the amplitude goes from 1 mm to 900 µm (-10 %)."
        );
        assert!(told(&motion(0.03, 1e-3)).contains("30 ms (unchanged)"));
        assert!(!told(&motion(f64::NAN, 1e-3)).contains("period"));
    }
}
