//! `stickslip check` on a simulated campaign, good and spoilt in every way that it knows.

mod rig;

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use rig::{Noise, Rig};
use stickslip::check::{Quality, Severity, check};
use stickslip::measurement::Campaign;

/// Operating points: belt velocity in m/s, normal force in N.
const POINTS: [(f64, f64); 4] = [(0.06, 60.0), (0.1, 100.0), (0.12, 120.0), (0.08, 120.0)];
const RATE: f64 = 10e3;
const NOISE: f64 = 5e-7;

/// One run: what its file and its entry say.
#[derive(Clone)]
struct Written {
    time: Vec<f64>,
    values: Vec<f64>,
    /// Velocity, m/s, for those who measure that.
    velocity: Vec<f64>,
    belt: f64,
    force: f64,
}

/// A campaign as it is written.
#[derive(Clone)]
struct Spoilt {
    frequencies: [f64; 2],
    runs: Vec<Written>,
}

fn good() -> Spoilt {
    let mut random = Noise::new(5);
    let runs = POINTS.map(|(belt, force)| {
        let rig = Rig {
            belt_velocity: belt,
            normal_force: force,
            ..Rig::default_case()
        };
        let record = rig.run(0.5, 0.8, RATE);
        let noisy = |w: &f64| w + NOISE * random.normal();
        let values: Vec<f64> = record.displacement.iter().map(noisy).collect();
        Written {
            time: (0..values.len()).map(|i| i as f64 / RATE).collect(),
            values,
            velocity: record.velocity,
            belt,
            force,
        }
    });
    Spoilt {
        frequencies: [80.0, 510.0],
        runs: runs.to_vec(),
    }
}

fn write(campaign: &Spoilt, folder: &Path) {
    let mut toml = format!(
        "[beam]\nnatural_frequencies_hz = {:?}\ndamping_ratios = [0.00015, 0.00085]\nmass_kg = 0.427\n",
        campaign.frequencies
    );
    for (i, run) in campaign.runs.iter().enumerate() {
        let _ = write!(
            toml,
            "[[run]]\nfile = \"run{i}.csv\"\nbelt_velocity_m_per_s = {:?}\nnormal_force_n = {:?}\n",
            run.belt, run.force
        );
        let mut csv = String::from("time_s,tip_displacement_m\n");
        for (t, w) in run.time.iter().zip(&run.values) {
            let _ = writeln!(csv, "{t:.9},{w:.9e}");
        }
        std::fs::write(folder.join(format!("run{i}.csv")), csv).unwrap();
    }
    std::fs::write(folder.join("campaign.toml"), toml).unwrap();
}

fn checked(campaign: &Spoilt) -> Quality {
    let folder = tempfile::tempdir().unwrap();
    write(campaign, folder.path());
    check(&Campaign::load(folder.path()).unwrap())
}

/// A campaign in which every run was changed.
fn each(base: &Spoilt, change: impl Fn(&mut Written)) -> Spoilt {
    let mut campaign = base.clone();
    campaign.runs.iter_mut().for_each(change);
    campaign
}

fn scaled(base: &Spoilt, time: f64, displacement: f64) -> Spoilt {
    each(base, |run| {
        run.time.iter_mut().for_each(|t| *t *= time);
        run.values.iter_mut().for_each(|w| *w *= displacement);
    })
}

fn derivative(values: &[f64]) -> Vec<f64> {
    let slopes = values.windows(2).map(|w| (w[1] - w[0]) * RATE);
    let mut slopes: Vec<f64> = slopes.collect();
    slopes.push(slopes[slopes.len() - 1]);
    slopes
}

#[test]
fn val_deviations_that_rigs_have_are_no_findings() {
    // The truth is the simulation of tests/rig, which shares no code with the check.
    let base = good();
    for (belt, force, frequency, offset, said) in [
        (1.0, 1.0, 1.0, 0.0, None),
        (1.02, 0.95, 1.005, 2e-3, None),
        // Friction would have to push the tip against the belt.
        (0.98, 1.05, 0.995, -5e-3, Some(("zero", Severity::Warning))),
    ] {
        let mut campaign = each(&base, |run| {
            run.belt *= belt;
            run.force *= force;
            run.values.iter_mut().for_each(|w| *w += offset);
        });
        campaign.frequencies = campaign.frequencies.map(|f| f * frequency);
        let quality = checked(&campaign);
        let found: Vec<_> = quality
            .findings
            .iter()
            .map(|f| (f.id, f.severity))
            .collect();
        assert_eq!(found, Vec::from_iter(said), "{:#?}", quality.findings);
        assert_eq!(quality.runs.len(), POINTS.len());
    }
    // Both belt and sensor the other way round is one more rig.
    let mirrored = each(&base, |run| {
        run.belt = -run.belt;
        run.values.iter_mut().for_each(|w| *w = -*w);
    });
    assert!(checked(&mirrored).findings.is_empty());
}

#[test]
fn val_each_mistake_is_recognised_and_named() {
    // The truth is what was done to the simulation of tests/rig.
    let base = good();
    let swapped = {
        let mut campaign = base.clone();
        let first = campaign.runs[0].values.clone();
        campaign.runs[0].values = std::mem::replace(&mut campaign.runs[2].values, first);
        campaign
    };
    let frequencies = |factor: f64| Spoilt {
        frequencies: base.frequencies.map(|f| f * factor),
        ..base.clone()
    };
    let every = |step: usize| {
        each(&base, |run| {
            run.time = run.time.iter().copied().step_by(step).collect();
            run.values = run.values.iter().copied().step_by(step).collect();
        })
    };
    let jittered = each(&base, |run| {
        let mut random = Noise::new(2);
        let jitter = 0.12 / RATE;
        for t in &mut run.time {
            *t += jitter * random.normal().clamp(-3.0, 3.0);
        }
    });
    let clipped = |share: f64| {
        each(&base, move |run| {
            let mut sorted = run.values.clone();
            sorted.sort_by(f64::total_cmp);
            let limit = sorted[((1.0 - share) * sorted.len() as f64) as usize];
            run.values.iter_mut().for_each(|w| *w = w.min(limit));
        })
    };
    // The last point has fast small cycles: where they are clipped, stretches are too short to be
    // told from crests.
    let drifting = each(&base, |run| {
        let range = 3e-3;
        let span = run.time[run.time.len() - 1];
        for (t, w) in run.time.iter().zip(&mut run.values) {
            *w += range * t / span;
        }
    });
    use Severity::{Error, Warning};
    let cases: Vec<(&str, Spoilt, Severity, &str, usize, &str)> = vec![
        (
            "time in ms",
            scaled(&base, 1e3, 1.0),
            Error,
            "time_in_ms",
            4,
            "time_scale",
        ),
        (
            "mm",
            scaled(&base, 1.0, 1e3),
            Error,
            "displacement_in_mm",
            4,
            "by 0.001",
        ),
        (
            "um",
            scaled(&base, 1.0, 1e6),
            Error,
            "displacement_in_um",
            4,
            "by 0.000001",
        ),
        (
            "ms and mm",
            scaled(&base, 1e3, 1e3),
            Error,
            "time_in_ms_displacement_in_mm",
            4,
            "time_scale",
        ),
        (
            "velocity",
            each(&base, |run| {
                let mut random = Noise::new(9);
                let noisy = |v: &f64| v + 1e-4 * random.normal();
                run.values = run.velocity.iter().map(noisy).collect();
            }),
            Error,
            "velocity",
            4,
            "displacement_column",
        ),
        (
            "acceleration",
            each(&base, |run| {
                let mut random = Noise::new(9);
                let noisy = |a: &f64| a + 1e-2 * random.normal();
                run.values = derivative(&run.velocity).iter().map(noisy).collect();
            }),
            Error,
            "acceleration",
            4,
            "displacement_column",
        ),
        (
            "belt reversed",
            each(&base, |run| run.belt = -run.belt),
            Error,
            "sign",
            4,
            "sign",
        ),
        (
            "sensor reversed",
            scaled(&base, 1.0, -1.0),
            Error,
            "sign",
            4,
            "sign",
        ),
        (
            "files swapped",
            swapped,
            Error,
            "swapped_files",
            2,
            "exchange",
        ),
        (
            "doubled",
            frequencies(2.0),
            Error,
            "natural_frequencies",
            4,
            "[80, 510]",
        ),
        (
            "halved",
            frequencies(0.5),
            Error,
            "natural_frequencies",
            4,
            "[80, 510]",
        ),
        (
            "rad/s",
            frequencies(std::f64::consts::TAU),
            Error,
            "natural_frequencies",
            4,
            "rad/s",
        ),
        (
            "force in kN",
            each(&base, |run| run.force *= 1e-3),
            Error,
            "force_in_kn",
            4,
            "by 1000",
        ),
        (
            "belt in mm/s",
            each(&base, |run| run.belt *= 1e3),
            Error,
            "belt_velocity_in_mm_per_s",
            4,
            "by 0.001",
        ),
        ("200 Hz", every(50), Error, "slow_sampling", 4, "ten times"),
        ("1 kHz", every(10), Warning, "slow_sampling", 4, "ten times"),
        ("clipped", clipped(0.3), Error, "clipped", 3, "larger range"),
        (
            "clipped a little",
            clipped(0.05),
            Warning,
            "clipped",
            3,
            "larger range",
        ),
        ("jitter", jittered, Warning, "jitter", 4, "clock"),
        ("drift", drifting, Warning, "drift", 4, "trend"),
    ];
    let mut wrong = Vec::new();
    for (what, campaign, severity, id, runs, remedy) in cases {
        let quality = checked(&campaign);
        let expected = quality.findings.iter().filter(|finding| {
            finding.severity == severity && finding.id == id && finding.remedy.contains(remedy)
        });
        if expected.map(|finding| finding.runs.len()).sum::<usize>() != runs {
            wrong.push(format!("{what}: {:#?}", quality.findings));
        }
        // What does not concern it is not questioned as an error.
        if quality.errors().any(|finding| finding.id != id) {
            wrong.push(format!("{what}, beside it: {:#?}", quality.findings));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn long_work_is_not_begun_on_what_cannot_be_meant_unless_forced() {
    let mut campaign = good();
    campaign.runs.truncate(2);
    for run in &mut campaign.runs {
        run.force *= 1e-3;
        run.time.truncate(3000);
        run.values.truncate(3000);
    }
    let folder = tempfile::tempdir().unwrap();
    write(&campaign, folder.path());
    let run = |command: &str, more: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_stickslip"))
            .arg(command)
            .arg(folder.path())
            .args(more)
            .current_dir(folder.path())
            .output()
            .unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (
            output.status.code(),
            text(&output.stdout),
            text(&output.stderr),
        )
    };
    let output = ["-o", "out"];
    for (command, more) in [
        ("diagnose", &output[..]),
        ("compare", &output),
        ("try", &["--add", "cubic_stiffness", "-o", "out"]),
    ] {
        let (code, _, said) = run(command, more);
        assert_eq!(code, Some(2), "{command}: {said}");
        let last = said.lines().last().unwrap();
        assert!(
            last.contains("--force") && last.contains("normal_force_n"),
            "{said}"
        );
        assert!(!folder.path().join("out").exists(), "{command} has begun");
    }
    let (code, _, said) = run("compare", &["-o", "out", "--force"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("kN"), "{said}");

    let (code, page, _) = run("check", &[]);
    assert_eq!(code, Some(2));
    for word in [
        "measured:",
        "stated:",
        "remedy:",
        "force_in_kn",
        "run0, run1",
    ] {
        assert!(page.contains(word), "{word} in {page}");
    }
    let (_, json, _) = run("check", &["--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["findings"][0]["severity"], "error");
    assert_eq!(json["runs"].as_array().unwrap().len(), 2);
}

#[test]
fn a_run_that_holds_one_value_is_refused_where_it_is_read() {
    let base = good();
    for value in [0.0, 1e-3] {
        let mut campaign = base.clone();
        campaign.runs[1].values.fill(value);
        let folder = tempfile::tempdir().unwrap();
        write(&campaign, folder.path());
        let message = Campaign::load(folder.path()).unwrap_err().to_string();
        assert!(message.contains("run1.csv"), "{message}");
        assert!(message.contains("8000"), "{message}");
    }
}
