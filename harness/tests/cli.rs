//! The command as a user types it: what it prints, what it leaves behind, how it exits.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn stickslip(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .args(arguments)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn demo_campaign() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-data/demo")
}

/// Runs a command that must fail, and returns its exit code and message.
fn failure(arguments: &[&str]) -> (i32, String) {
    let output = stickslip(arguments);
    assert!(
        text(&output.stdout).is_empty(),
        "a failure prints nothing on standard output"
    );
    (
        output.status.code().unwrap(),
        text(&output.stderr).trim_end().to_owned(),
    )
}

#[test]
fn help_says_what_there_is() {
    // Further commands come and go with their own help; these four are described here.
    for command in ["simulate", "compare", "demo", "pack"] {
        let output = stickslip(&[command, "--help"]);
        assert!(output.status.success());
        insta::assert_snapshot!(format!("help_{command}"), text(&output.stdout));
    }
    let help = text(&stickslip(&["--help"]).stdout);
    assert!(help.contains("Exit codes:"), "{help}");
}

#[test]
fn compare_writes_a_self_contained_report_and_json() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new/folder");
    let output = stickslip(&[
        "compare",
        demo_campaign().to_str().unwrap(),
        "-o",
        out.to_str().unwrap(),
        "--json",
    ]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let scores: Vec<f64> = json["runs"]
        .as_array()
        .unwrap()
        .iter()
        .map(|run| run["nrmse"].as_f64().unwrap())
        .collect();
    assert_eq!(scores.len(), 4);
    assert!(
        scores.is_sorted_by(|a, b| a >= b),
        "worst first: {scores:?}"
    );
    let from = &json["provenance"];
    assert_eq!(from["version"], env!("CARGO_PKG_VERSION"));
    assert!(
        from["command_line"]
            .as_str()
            .unwrap()
            .starts_with("stickslip compare ")
    );
    assert_eq!(
        from["inputs"].as_array().unwrap().len(),
        5,
        "four runs and campaign.toml"
    );
    let report = std::fs::read_to_string(out.join("report.html")).unwrap();
    for key in ["version", "date", "inputs_sha256"] {
        let value = from[key].as_str().unwrap();
        assert!(
            !value.is_empty() && (key == "date" || report.contains(value)),
            "{key}: {value}"
        );
    }
    assert!(report.len() < 6_000_000, "{} bytes", report.len());
    let figures = figures(&report);
    assert_eq!(
        figures.len(),
        2 + 4 * 5,
        "two figures for all and five per run"
    );
    for figure in &figures {
        let traces = figure["data"].as_array().unwrap();
        assert!(
            traces
                .iter()
                .any(|t| t["x"].as_array().is_some_and(|x| x.len() > 1))
        );
        for axis in ["xaxis", "yaxis"] {
            assert!(
                figure["layout"][axis]["range"][1].is_number(),
                "{axis}: {figure}"
            );
        }
    }
    // The bars say what the JSON says.
    let bars = &figures[0]["data"][0]["x"];
    for (bar, score) in bars.as_array().unwrap().iter().zip(&scores) {
        assert!(
            (bar.as_f64().unwrap() / score - 1.0).abs() < 1e-4,
            "{bar} {score}"
        );
    }
    // Beside the one copy of Plotly's script, which names addresses that it asks for maps only.
    let own = report.replacen(stickslip::report::plotly_script(), "", 1);
    for reach in ["http", "src=", "<link", "@import", "url(", "plotly.js v"] {
        assert!(!own.contains(reach), "needs no network: {reach}");
    }
}

/// The figures of a page, as Plotly is given them.
fn figures(page: &str) -> Vec<serde_json::Value> {
    page.split("<script type=\"application/json\">")
        .skip(1)
        .map(|rest| serde_json::from_str(rest.split("</script>").next().unwrap()).unwrap())
        .collect()
}

#[test]
fn the_gate_decides_by_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    let compare = |limit: &str| {
        stickslip(&[
            "compare",
            demo_campaign().to_str().unwrap(),
            "-o",
            folder.path().to_str().unwrap(),
            "--fail-above",
            limit,
        ])
    };
    assert_eq!(compare("2").status.code(), Some(0));
    let failed = compare("1e-6");
    assert_eq!(failed.status.code(), Some(1));
    assert!(
        text(&failed.stderr).contains("above the limit 0.000001 set by --fail-above"),
        "{}",
        text(&failed.stderr)
    );
    // The report is there all the same: it says why.
    assert!(folder.path().join("report.html").is_file());
}

#[test]
fn simulate_writes_the_default_motion() {
    let output = stickslip(&[
        "simulate",
        "--duration",
        "0.01",
        "--step",
        "1e-3",
        "--variables",
        "tip_displacement,contact_mode",
    ]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let csv = text(&output.stdout);
    assert_eq!(
        csv.lines().next(),
        Some("time,tip_displacement,contact_mode")
    );
    assert_eq!(csv.lines().count(), 12);
}

/// One effect of the catalogue, one of the library, one at a strength and an operating point of one's own.
#[test]
fn effects_are_explained_with_pictures_of_what_they_do() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let strong = [
        "--set",
        "static_friction_aging.gain=0.3",
        "--belt-velocity",
        "0.06",
    ];
    for (id, further) in [
        ("third_mode", &[][..]),
        ("term_stop", &[]),
        ("static_friction_aging", &strong),
    ] {
        let output = stickslip(&[&["effects", id, "-o", out][..], further].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
        let file = folder.path().join(format!("{id}.html"));
        assert!(text(&output.stdout).contains(&format!("Report: {}", file.display())));
        let page = std::fs::read_to_string(file).unwrap();
        assert_eq!(page.matches("<figcaption>").count(), 2);
        assert!(page.contains("once settled the period goes from"), "{id}");
        let apart = page.split("by up to ").nth(1).unwrap();
        let apart: f64 = apart.split(' ').next().unwrap().parse().unwrap();
        assert!(
            apart > 1.0,
            "{id} moves the tip by {apart} % of the amplitude"
        );
    }
    let (code, message) = failure(&["effects", "third_mode", "--belt-velocity", "0.06"]);
    assert_eq!(code, 2, "{message}");
    assert!(message.contains("add -o DIR"), "{message}");
}

#[test]
fn a_packed_fmu_has_the_same_bytes_every_time() {
    let folder = tempfile::tempdir().unwrap();
    let pack = |name: &str| {
        let path = folder.path().join(name);
        assert!(
            stickslip(&["pack", "-o", path.to_str().unwrap()])
                .status
                .success()
        );
        std::fs::read(path).unwrap()
    };
    assert!(pack("a.fmu") == pack("b.fmu"));
}

#[test]
fn bad_input_is_named_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "x").unwrap();
    let blocked = file.join("out");
    let campaign = demo_campaign();
    let (campaign, file, blocked) = (
        campaign.to_str().unwrap(),
        file.to_str().unwrap(),
        blocked.to_str().unwrap(),
    );
    let cases: [&[&str]; 8] = [
        &["compare", "nowhere", "-o", blocked],
        &["compare", campaign, "-o", blocked],
        &["compare", campaign, "-o", blocked, "--fail-above", "0"],
        &["simulate", "--fmu", file],
        &["simulate", "--step", "0"],
        &["simulate", "--set", "mode_count"],
        &["simulate", "--set", "mode[1].mas=1"],
        &["simulate", "--duration", "1e9"],
    ];
    let messages: Vec<String> = cases
        .iter()
        .map(|case| {
            let (code, message) = failure(case);
            format!(
                "{code} {}",
                message
                    .replace(folder.path().to_str().unwrap(), "DIR")
                    .replace(campaign, "CAMPAIGN")
            )
        })
        .map(|line| {
            line.split_once("StickSlipBeam.fmu: ")
                .map_or(line.clone(), |(_, rest)| format!("2 FMU: {rest}"))
        })
        .collect();
    insta::assert_snapshot!(messages.join("\n"));
    assert_eq!(
        std::fs::read_dir(folder.path()).unwrap().count(),
        1,
        "nothing was left behind"
    );
}

#[test]
fn impossible_physics_is_refused_by_the_fmu() {
    for setting in [
        "mode[1].mass=-1",
        "mode[1].damping_ratio=-0.1",
        "mode_count=0",
    ] {
        let (code, message) = failure(&["simulate", "--set", setting]);
        let name = setting.split('=').next().unwrap();
        assert!(code == 3 && message.contains(name), "{code} {message}");
    }
    let (code, message) = failure(&["simulate", "--normal-force=-5"]);
    assert!(
        code == 3 && message.contains("normal_force") && message.contains("-5"),
        "{code} {message}"
    );
}

#[test]
fn belt_velocity_zero_and_negative_are_legal() {
    for velocity in ["0", "-0.1"] {
        let output = stickslip(&[
            "simulate",
            "--duration",
            "0.05",
            "--belt-velocity",
            velocity,
        ]);
        assert!(output.status.success(), "{}", text(&output.stderr));
    }
}
