//! The quality of a campaign's data as a section of a report.

use crate::check::{Quality, ReadingQuality, RunQuality, Severity, check};
use crate::measurement::Campaign;
use crate::report::{Cell, Page, Table, number, with_unit};

/// Its title.
pub const TITLE: &str = "Data quality";

/// The section: each run in numbers, and what contradicts what is stated of it.
pub fn section(page: Page, campaign: &Campaign) -> Page {
    of(page, &check(campaign))
}

fn of(page: Page, quality: &Quality) -> Page {
    let page = page
        .section(TITLE)
        .paragraph(&sentence(quality))
        .table(&runs(quality));
    let findings = quality.findings.iter().map(|finding| {
        let severity = match finding.severity {
            Severity::Error => "Error",
            Severity::Warning => "Warning",
        };
        format!(
            "{severity} in {}: measured {}, stated {}. Remedy: {}.",
            finding.runs.join(", "),
            finding.measured,
            finding.stated,
            finding.remedy.trim_end_matches('.')
        )
    });
    let findings: Vec<String> = findings.collect();
    let understood = quality.runs.iter().filter_map(|run| {
        let understood = run.understood.as_ref()?;
        Some(format!("{}: {understood}", run.name))
    });
    let understood: Vec<String> = understood.collect();
    let further = quality.runs.iter().flat_map(of_further).collect();
    [findings, understood, further]
        .into_iter()
        .filter(|items| !items.is_empty())
        .fold(page, |page, items| page.list(&items))
}

/// What each further sensor read in a run.
pub fn of_further(run: &RunQuality) -> Vec<String> {
    let one = |reading: &ReadingQuality| {
        let [low, high] = reading.range.map(|y| number(y, 3));
        let read = match reading.noise_std {
            None => "nothing that varies was read".to_owned(),
            Some(noise) => format!(
                "{} of {} samples read, {low} to {high} {}, noise {}",
                reading.samples,
                run.samples,
                reading.unit,
                with_unit(noise, reading.unit)
            ),
        };
        format!("{}, {}: {read}", run.name, reading.name)
    };
    run.further.iter().map(one).collect()
}

/// What the table and the list say together.
fn sentence(quality: &Quality) -> String {
    let errors = quality.errors().count();
    let warnings = quality.findings.len() - errors;
    let said = match (errors, warnings) {
        (0, 0) => "Nothing measured contradicts what campaign.toml states.".to_owned(),
        _ => format!(
            "What was measured contradicts what campaign.toml states (errors: {errors}, warnings: {warnings}; listed below)."
        ),
    };
    let elsewhere = quality.elsewhere();
    let contact = match quality.is_pressed {
        true => {
            "In stick the contact moves with the belt; mean friction is the mean deflection times the static stiffness over the normal force. A \
             dash: not seen in these data."
        }
        false => "",
    };
    format!("{said} {elsewhere}{contact}")
}

fn runs(quality: &Quality) -> Table {
    let unit = quality.measurand.unit();
    let mut header = vec![
        "run",
        "samples",
        "rate",
        "range of the displacement",
        "noise (standard deviation)",
    ];
    let of_contact = [
        "belt stated",
        "belt seen in stick",
        "time in stick",
        "mean friction",
    ];
    if quality.is_pressed {
        header.extend(of_contact);
    }
    let dash = |value: Option<String>| Cell::Number(value.unwrap_or("–".into()));
    let row = |run: &RunQuality| {
        let seen = run.stick_speed_m_per_s;
        let mut cells = vec![
            Cell::Text(run.name.clone()),
            Cell::Number(run.samples.to_string()),
            Cell::Number(with_unit(run.sample_rate_hz, "Hz")),
            Cell::Number(with_unit(run.range_m, "m")),
            Cell::Number(with_unit(run.noise_std.value(), unit)),
        ];
        if quality.is_pressed {
            cells.extend([
                Cell::Number(format!("{} m/s", number(run.belt_velocity_m_per_s, 4))),
                dash(seen.map(|v| format!("{} m/s", number(v, 4)))),
                dash(seen.map(|_| format!("{:.0} %", 100.0 * run.stick_share))),
                dash(run.mean_friction.map(|mu| number(mu, 3))),
            ]);
        }
        cells
    };
    let rows = quality.runs.iter().map(row);
    rows.fold(Table::new(&header), Table::row)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::Finding;
    use crate::measurement::{Measurand, NoiseStd, Reading};

    #[test]
    fn a_contradiction_is_said_with_its_remedy_and_what_is_not_seen_is_a_dash() {
        let run = RunQuality {
            name: "slow".into(),
            samples: 4000,
            sample_rate_hz: 1e4,
            noise_std: NoiseStd::of(Measurand::Velocity, 2e-4),
            range_m: 1.5e-3,
            belt_velocity_m_per_s: 0.06,
            stick_speed_m_per_s: None,
            stick_share: 0.0,
            mean_friction: None,
            understood: Some("semicolons between fields".into()),
            further: vec![ReadingQuality {
                name: "load cell".into(),
                quantity: Reading::FrictionForce,
                unit: "N",
                samples: 2000,
                noise_std: Some(0.1),
                range: [-20.0, 60.0],
            }],
        };
        let finding = Finding {
            id: "sign",
            severity: Severity::Error,
            runs: vec!["slow".into()],
            measured: "-0.06 m/s in stick".into(),
            stated: "0.06 m/s".into(),
            remedy: "turn the sign of the sensor".into(),
        };
        let quality = Quality {
            campaign: "rig".into(),
            runs: vec![run],
            measurand: Measurand::Velocity,
            seen_share: None,
            is_pressed: true,
            findings: vec![finding],
        };
        let html = of(Page::new("Report", ""), &quality).html();
        for part in [
            "errors: 1, warnings: 0",
            "Error in slow: measured -0.06 m/s in stick, stated 0.06 m/s. Remedy: turn the sign of the sensor.",
            "slow: semicolons between fields",
            "200 µm/s",
            "slow, load cell: 2000 of 4000 samples read, -20 to 60 N, noise 100 mN",
            "–",
        ] {
            assert!(html.contains(part), "{part}");
        }
        let fine = Quality {
            findings: Vec::new(),
            ..quality
        };
        let html = of(Page::new("Report", ""), &fine).html();
        assert!(html.contains("Nothing measured contradicts"));
    }
}
