//! The same run as many loggers write it: every file gives the same samples, and one line that says
//! how it was read.

use std::fmt::Write as _;
use std::fs;

use super::{Campaign, Run};

const RUN: &str =
    "[[run]]\nfile = \"run.csv\"\nbelt_velocity_m_per_s = 0.1\nnormal_force_n = 100\n";
const SAMPLES: i32 = 64;

fn time(i: i32) -> f64 {
    f64::from(i) * 1e-4
}

fn displacement(i: i32) -> f64 {
    f64::from((7 * i) % 11 - 5) * 1e-5
}

/// Rows with both numbers in other units, written by `row`.
fn rows(per_second: f64, per_metre: f64, row: impl Fn(String, String) -> String) -> String {
    let mut text = String::new();
    for i in 0..SAMPLES {
        let t = format!("{:.4}", time(i) * per_second);
        let w = format!("{:.6}", displacement(i) * per_metre);
        let _ = writeln!(text, "{}", row(t, w));
    }
    text
}

fn comma(number: &str) -> String {
    number.replace('.', ",")
}

fn load(channels: &str, bytes: &[u8]) -> Run {
    let folder = tempfile::tempdir().unwrap();
    let toml = format!("{channels}{RUN}");
    fs::write(folder.path().join("campaign.toml"), toml).unwrap();
    fs::write(folder.path().join("run.csv"), bytes).unwrap();
    Campaign::load(folder.path()).unwrap().runs.remove(0)
}

fn holds_the_samples(run: &Run, missing: usize) {
    assert_eq!(run.time.len(), SAMPLES as usize - missing);
    for (t, w) in run.time.iter().zip(&run.measured) {
        let i = (t / 1e-4).round() as i32;
        assert!((t - time(i)).abs() < 1e-9, "{t}");
        assert!((w - displacement(i)).abs() < 1e-9, "{w} at {t}");
    }
}

#[test]
fn the_samples_are_the_same_in_every_dialect() {
    let header = "time_s,tip_displacement_m\n";
    let plain = rows(1.0, 1.0, |t, w| format!("{t},{w}"));
    let semicolons = rows(1e3, 1e3, |t, w| format!("{};{}", comma(&t), comma(&w)));
    let tabs = rows(1.0, 1.0, |t, w| format!("{t}\t{w}"));
    let spaces = rows(1.0, 1.0, |t, w| format!("  {t}   {w}"));
    let scope: String = (0..3000)
        .map(|i| format!("Setting {i},{}\n", i % 7))
        .collect();
    let flags = rows(1.0, 1.0, |t, w| format!("{t},ok,{w}"));
    let cases = [
        ("", format!("{header}{plain}"), None),
        (
            "",
            format!("t/ms;x [mm]\n{semicolons}"),
            Some("semicolons, decimal commas, 'x [mm]' in mm taken to m, 't/ms' in ms taken to s"),
        ),
        (
            "",
            format!("t;x\nms;mm\n{semicolons}"),
            Some(
                "semicolons, decimal commas, row of units, 'x' in mm taken to m, 't' in ms taken to s",
            ),
        ),
        (
            "displacement_column = \"laser\"\n",
            format!("Time (ms);laser [mm];\n{}", semicolons.replace('\n', ";\n")),
            Some(
                "semicolons, decimal commas, 'laser [mm]' in mm taken to m, 'Time (ms)' in ms taken to s",
            ),
        ),
        (
            "time_scale = 1e-3\ndisplacement_scale = 1e-3\n",
            format!("t/ms;x [mm]\n{semicolons}"),
            Some("semicolons, decimal commas"),
        ),
        (
            "",
            format!("% rig 3\ntime_s\ttip_displacement_m\n{tabs}"),
            Some("tabs"),
        ),
        (
            "",
            format!("# time_s tip_displacement_m\n{spaces}"),
            Some("spaces, header in a comment"),
        ),
        ("", format!("t [s] w [m]\n{spaces}"), Some("spaces")),
        (
            "",
            format!("Scope 7\n{scope}{header}{plain}// end\n"),
            Some("table from line 3002"),
        ),
        (
            "displacement_column = \"column2\"\ntime_column = \"column1\"\n",
            plain.clone(),
            None,
        ),
        (
            "",
            format!("time_s,state,tip_displacement_m\n{flags}"),
            None,
        ),
        (
            "sample_rate_hz = 10000\n",
            format!("x [um]\n{}", rows(1.0, 1e6, |_, w| comma(&w))),
            Some(
                "semicolons, decimal commas, 'x [um]' in um taken to m, times from sample_rate_hz = 10000",
            ),
        ),
        (
            "",
            format!("\u{feff}{header}{}", plain.replace('\n', "\r\n")),
            Some("UTF-8 with a byte order mark"),
        ),
    ];
    for (channels, text, understood) in cases {
        let run = load(&format!("[channels]\n{channels}"), text.as_bytes());
        holds_the_samples(&run, 0);
        assert_eq!(run.understood.as_deref(), understood, "{channels}");
    }
}

#[test]
fn a_file_in_utf16_is_read() {
    let text = format!(
        "t/ms\tx/\u{b5}m\n{}",
        rows(1e3, 1e6, |t, w| format!("{}\t{}", comma(&t), comma(&w)))
    );
    let mut bytes = vec![0xff, 0xfe];
    bytes.extend(text.encode_utf16().flat_map(u16::to_le_bytes));
    let run = load("", &bytes);
    holds_the_samples(&run, 0);
    let understood = run.understood.unwrap();
    assert!(understood.starts_with("UTF-16"), "{understood}");
}

#[test]
fn missing_samples_are_gaps() {
    let plain = rows(1.0, 1.0, |t, w| format!("{t},{w}"));
    for missing in ["", "NaN", "-"] {
        let mut lines: Vec<String> = plain.lines().map(str::to_owned).collect();
        for i in 10..13 {
            let t = lines[i].split_once(',').unwrap().0.to_owned();
            lines[i] = format!("{t},{missing}");
        }
        let text = format!("time_s,tip_displacement_m\n{}\n", lines.join("\n"));
        let run = load("", text.as_bytes());
        holds_the_samples(&run, 3);
        assert_eq!(run.sampling.gaps.len(), 1);
        assert_eq!(run.sampling.gaps[0].missing, 3);
        assert_eq!(run.understood.unwrap(), "3 of 64 samples missing");
    }
    let by_rate = plain
        .lines()
        .enumerate()
        .map(|(i, line)| match i {
            20 => "-\n".to_owned(),
            30 => "\n".to_owned(),
            _ => format!("{}\n", line.split_once(',').unwrap().1),
        })
        .collect::<String>();
    let run = load(
        "[channels]\nsample_rate_hz = 1e4\n",
        format!("tip_displacement_m\n{by_rate}").as_bytes(),
    );
    holds_the_samples(&run, 2);
    let after: Vec<usize> = run.sampling.gaps.iter().map(|gap| gap.after).collect();
    assert_eq!(after, [19, 28]);
}
