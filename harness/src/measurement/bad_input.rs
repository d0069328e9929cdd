//! What a user can get wrong, and the message that answers it.

use std::fmt::Write as _;
use std::fs;

use super::Campaign;
use crate::error::Error;

const CAMPAIGN: &str =
    "[[run]]\nfile = \"run.csv\"\nbelt_velocity_m_per_s = 0.1\nnormal_force_n = 100\n";

fn good_csv() -> String {
    let mut csv = String::from("time_s,tip_displacement_m\n");
    for i in 0..64 {
        writeln!(
            csv,
            "{:.4},{}",
            f64::from(i) * 1e-4,
            f64::from(i % 7) * 1e-6
        )
        .unwrap();
    }
    csv
}

fn load(campaign: &str, csv: &str) -> Result<Campaign, Error> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("campaign.toml"), campaign).unwrap();
    fs::write(folder.path().join("run.csv"), csv).unwrap();
    Campaign::load(folder.path())
}

/// The message, with the temporary folder left out.
fn message(campaign: &str, csv: &str) -> String {
    let text = load(campaign, csv).unwrap_err().to_string();
    let name = if text.contains("campaign.toml:") && !text.contains("run.csv:") {
        "campaign.toml"
    } else {
        "run.csv"
    };
    text.split_once(name)
        .map_or(text.clone(), |(_, rest)| format!("{name}{rest}"))
}

#[test]
fn a_good_campaign_loads() {
    let campaign = load(CAMPAIGN, &good_csv()).unwrap();
    assert_eq!(campaign.runs[0].name, "run");
    assert_eq!(campaign.runs[0].time.len(), 64);
}

#[test]
fn belt_velocity_zero_or_negative_is_legal() {
    for velocity in ["0", "-0.1"] {
        load(&CAMPAIGN.replace("0.1", velocity), &good_csv()).unwrap();
    }
}

#[test]
fn columns_and_scales_can_be_chosen_per_campaign_and_per_run() {
    let campaign = format!(
        "{CAMPAIGN}displacement_scale = -1e-3\n[channels]\ntime_column = \"t\"\ntime_scale = 2.0\ndisplacement_column = \"w\"\ndelimiter = \";\"\n"
    );
    let csv = good_csv()
        .replace("time_s,tip_displacement_m", "t,w")
        .replace(',', ";");
    let run = &load(&campaign, &csv).unwrap().runs[0];
    assert!((run.sampling.interval - 2e-4).abs() < 1e-12);
    assert_eq!(run.measured[1], -1e-9);
}

#[test]
fn messages_of_campaign_files() {
    let with = |from, to| message(&CAMPAIGN.replace(from, to), &good_csv());
    let beam = |lines: &str| message(&format!("[beam]\n{lines}\n{CAMPAIGN}"), &good_csv());
    let messages = [
        with("normal_force_n", "normal_force"),
        with("100", "-5"),
        with("100", "\"much\""),
        with("file = ", "role = \"train\"\nfile = "),
        message("name = \"x\"\n", &good_csv()),
        message("name = \n", &good_csv()),
        beam("mass_kg = -0.4"),
        beam("natural_frequencies_hz = [80, nan]"),
        beam("natural_frequencies_hz = [80, 510]\ndamping_ratios = [0.1]"),
        beam("damping_ratios = [-0.1]"),
        with("normal_force_n", "time_scale = 0\nnormal_force_n"),
    ];
    insta::assert_snapshot!(messages.join("\n"));
}

#[test]
fn messages_of_csv_files() {
    let with = |from, to| message(CAMPAIGN, &good_csv().replacen(from, to, 1));
    let messages = [
        with("tip_displacement_m", "displacement_m"),
        with("0.0003,0.000003", "0.0003,inf"),
        with("0.0003,0.000003", "0.0003,3 um"),
        with("0.0003,", "0.0002,"),
        with("0.0003,", "0.0001,"),
        with("0.0003,", "0.0003,1,"),
        message(CAMPAIGN, ""),
        message(CAMPAIGN, "time_s,tip_displacement_m\n0,0\n"),
        // Cut off, mixed, empty, ambiguous, in another unit, in words.
        message(CAMPAIGN, good_csv().trim_end().rsplit_once(',').unwrap().0),
        with("0.0003,", "0.0003;"),
        with("0.0003,0.000003", "\"0,0003\",0.000003"),
        with("0.0000,0\n", "0.0000,0,0\n"),
        message(
            CAMPAIGN,
            &three_columns("time_s,y,tip_displacement_m").replace(",1\n", ",\n"),
        ),
        message(CAMPAIGN, &three_columns("time_s,time_s,tip_displacement_m")),
        with("time_s,tip_displacement_m", "time_s,x [mm],y [mm]"),
        message(CAMPAIGN, &three_columns("t [s],t2 [ms],x [mm]")),
        message(CAMPAIGN, &three_columns("t [s],x [mm],y [mm]")),
        message(
            CAMPAIGN,
            &three_columns("t [s],tip_displacement_m [mm/s],y [mm]"),
        ),
        message(
            CAMPAIGN,
            "time_s,tip_displacement_m\n0.1 s,3 um\n0.2 s,4 um\n",
        ),
    ];
    insta::assert_snapshot!(messages.join("\n"));
}

#[test]
fn a_unit_that_is_not_known_is_refused_without_a_scale() {
    let csv = |unit: &str| good_csv().replacen("tip_displacement_m", &format!("w [{unit}]"), 1);
    let stated = |more: &str| format!("[channels]\ndisplacement_column = \"w\"\n{more}{CAMPAIGN}");
    let column = stated("").replace("\"w\"", "\"w [stone]\"");
    let refused = message(&column, &csv("stone"));
    assert!(
        refused.contains("stone, a unit that is not known")
            && refused.contains("displacement_scale"),
        "{refused}"
    );
    let scaled = column.replace("]\"\n", "]\"\ndisplacement_scale = 0.5\n");
    let known = load(CAMPAIGN, &good_csv()).unwrap().runs[0]
        .measured
        .clone();
    let read = load(&scaled, &csv("stone")).unwrap().runs[0]
        .measured
        .clone();
    assert_eq!(read, known.iter().map(|w| 0.5 * w).collect::<Vec<_>>());
    let read = load(&stated(""), &csv("\u{b5}m")).unwrap().runs[0]
        .measured
        .clone();
    assert_eq!(read, known.iter().map(|w| 1e-6 * w).collect::<Vec<_>>());
}

#[test]
fn a_high_pass_is_undone_where_it_is_positive_and_nothing_is_missing() {
    let stated = |corner: &str| format!("[sensor]\nhigh_pass_hz = {corner}\n{CAMPAIGN}");
    let wrong = message(&stated("-0.5"), &good_csv());
    assert!(
        wrong.contains("high_pass_hz") && wrong.contains("-0.5 Hz"),
        "{wrong}"
    );
    let good = good_csv();
    let rows = good.lines().filter(|row| !row.starts_with("0.002"));
    let with_gap = rows.collect::<Vec<_>>().join("\n");
    let wrong = message(&stated("0.5"), &with_gap);
    assert!(wrong.contains("across 1 gap(s)"), "{wrong}");
    let run = &load(&stated("0.5"), &good_csv()).unwrap().runs[0];
    let said = run.understood.as_deref().unwrap_or_default();
    assert!(said.contains("a high pass at 0.5 Hz undone"), "{said}");
    let mean = run.measured.iter().sum::<f64>() / run.measured.len() as f64;
    assert!(mean.abs() < 1e-18, "{mean}");
}

/// A good file with a column of ones added and other names.
fn three_columns(header: &str) -> String {
    let good = good_csv();
    let rows = good.lines().skip(1).map(|line| format!("{line},1\n"));
    format!("{header}\n{}", rows.collect::<String>())
}

#[test]
fn a_missing_file_is_named() {
    let error = load(&CAMPAIGN.replace("run.csv", "other.csv"), "").unwrap_err();
    assert!(error.to_string().contains("other.csv"), "{error}");
    assert_eq!(error.exit_code(), 2);
}

#[test]
fn a_time_far_off_all_others_is_refused() {
    let csv = good_csv() + "1e5,0\n";
    let error = load(CAMPAIGN, &csv).unwrap_err().to_string();
    assert!(
        error.contains("100000 s") && error.contains("0.0001"),
        "{error}"
    );
}

#[test]
fn a_run_longer_than_any_is_refused_with_the_unit_in_doubt() {
    let campaign = format!("[channels]\ntime_scale = 1e9\n{CAMPAIGN}");
    let error = load(&campaign, &good_csv()).unwrap_err().to_string();
    assert!(
        error.contains("6300000 s") && error.contains("time_scale"),
        "{error}"
    );
}

#[test]
fn a_delimiter_that_numbers_are_made_of_is_refused() {
    for delimiter in ["\u{20ac}", "e", ".", "-", "\\n"] {
        let campaign = format!("[channels]\ndelimiter = \"{delimiter}\"\n{CAMPAIGN}");
        let error = load(&campaign, &good_csv()).unwrap_err().to_string();
        assert!(error.contains("toml:2: delimiter"), "{error}");
    }
    let campaign = format!("[channels]\ndelimiter = \"\\t\"\n{CAMPAIGN}");
    load(&campaign, &good_csv().replace(',', "\t")).unwrap();
}

const STATED: &str = "[beam]\nnatural_frequencies_hz = [80.0, 510.0]\nnatural_frequencies_std_hz = [0.4, 5.1]\nmass_kg = 0.4\nmass_std_kg = 0.016\ntip_values = [2.0, -2.0]\ntip_values_std = 0.03\n[rig]\nbelt_velocity_std = 0.02\nbelt_velocity_run_std = 0.005\nnormal_force_run_std = 0.03\n";

#[test]
fn how_well_things_are_known_may_be_stated_in_their_own_units() {
    let known = load(&format!("{STATED}{CAMPAIGN}"), &good_csv())
        .unwrap()
        .uncertainty;
    assert!(
        (known.frequency(0) - 0.005).abs() < 1e-12 && (known.frequency(1) - 0.01).abs() < 1e-12
    );
    assert!((known.participation(1) - 0.04f64.hypot(0.03)).abs() < 1e-12);
    assert_eq!(
        (known.belt_velocity_std, known.normal_force_std),
        (0.02, 0.025)
    );
    assert_eq!(
        (known.belt_velocity_run_std, known.normal_force_run_std),
        (0.005, 0.03)
    );
}

#[test]
fn messages_of_what_is_known_wrongly() {
    for (from, to, expected) in [
        ("[0.4, 5.1]", "[0.4]", "natural_frequencies_std_hz has 1"),
        ("mass_kg = 0.4\n", "", "state both under [beam]"),
        (
            "= 0.03\n[rig]",
            "= -0.03\n[rig]",
            "it must be greater than zero",
        ),
        (
            "[rig]",
            "[uncertainty]\nbelt_velocity_std = 0.01\n[rig]",
            "leave one out",
        ),
    ] {
        let campaign = format!("{}{CAMPAIGN}", STATED.replacen(from, to, 1));
        let found = message(&campaign, &good_csv());
        assert!(found.contains(expected), "{found}");
    }
}

#[test]
fn damping_rates_that_no_structure_has_are_refused() {
    let with =
        |keys: &str| format!("[beam]\nnatural_frequencies_hz = [0.0, 80.0]\n{keys}\n{CAMPAIGN}");
    for (keys, expected) in [
        (
            "damping_rates_per_s = [-1.0, 0.0]",
            "[beam] damping_rates_per_s = -1 1/s",
        ),
        ("damping_rates_per_s = [1.0]", "damping_rates_per_s"),
        ("damping_rates_std_per_s = 0.1", "damping_rates_per_s"),
        (
            "damping_rates_per_s = [1.0, 0.0]\ndamping_rates_std_per_s = -0.1",
            "damping_rates_std_per_s",
        ),
    ] {
        let text = message(&with(keys), &good_csv());
        assert!(text.contains(expected), "{keys}: {text}");
    }
    let stated = with("damping_rates_per_s = [2.0, 0.0]\ndamping_rates_std_per_s = 0.5");
    let campaign = load(&stated, &good_csv()).unwrap();
    assert_eq!(campaign.beam.damping_rates_per_s, [2.0, 0.0]);
    assert_eq!(campaign.uncertainty.damping_rate(0), 0.25);
    // Of a rate of zero there is no share.
    assert_eq!(campaign.uncertainty.damping_rate(1), 0.5);
}
