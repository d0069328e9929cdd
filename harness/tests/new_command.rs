//! `stickslip new`: every template passes what its README names next.

use std::path::Path;
use std::process::{Command, Output};

fn stickslip(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn templates() -> Vec<String> {
    let output = stickslip(&["new", "--list"], Path::new("."));
    assert!(output.status.success());
    let list = text(&output.stdout);
    let first = |line: &str| line.split_whitespace().next().unwrap().to_owned();
    list.lines().map(first).collect()
}

#[test]
fn every_template_is_checked_and_compared_at_once() {
    let templates = templates();
    assert_eq!(
        templates,
        [
            "beam-on-belt",
            "mass-on-belt",
            "pin-on-disc",
            "sliding-drive",
            "oscillator"
        ]
    );
    let folder = tempfile::tempdir().unwrap();
    for template in &templates {
        let run = |arguments: &[&str]| {
            let output = stickslip(arguments, folder.path());
            let said = text(&output.stderr);
            assert!(output.status.success(), "{arguments:?}: {said}");
            text(&output.stdout)
        };
        run(&["new", template, template]);
        let page = run(&["check", template]);
        assert!(page.contains("Nothing contradicts"), "{template}: {page}");
        // The example is this model with sensor noise, so that little more than the noise is left.
        let out = format!("{template}.out");
        run(&["compare", template, "-o", &out, "--fail-above", "0.05"]);
        assert!(folder.path().join(out).join("report.html").is_file());
    }
}

#[test]
fn every_key_of_a_template_is_explained_and_its_picture_stands_alone() {
    let folder = tempfile::tempdir().unwrap();
    for template in templates() {
        assert!(
            stickslip(&["new", &template, &template], folder.path())
                .status
                .success()
        );
        let read =
            |name: &str| std::fs::read_to_string(folder.path().join(&template).join(name)).unwrap();
        let toml = read("campaign.toml");
        for key in [
            "natural_frequencies_hz",
            "mass_kg",
            "mass_std_kg",
            "belt_velocity_m_per_s",
            "normal_force_n",
        ] {
            assert!(toml.contains(&format!("\n{key} = ")), "{template}: {key}");
        }
        assert!(
            toml.lines().filter(|line| line.contains('#')).count() > 12,
            "{toml}"
        );
        let readme = read("README.md");
        assert!(
            readme.contains("machine.svg") && readme.contains("stickslip check"),
            "{readme}"
        );
        let picture = read("machine.svg");
        assert!(
            picture.starts_with("<svg") && !picture.contains("href"),
            "{picture}"
        );
        let wide = |text: &str| text.lines().map(|line| line.chars().count()).max().unwrap();
        assert!(wide(&toml) <= 100 && wide(&readme) <= 100, "{template}");
    }
}

#[test]
fn a_folder_in_use_and_a_name_unknown_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("mine")).unwrap();
    std::fs::write(folder.path().join("mine/notes.txt"), "x").unwrap();
    let output = stickslip(&["new", "oscillator", "mine"], folder.path());
    assert_eq!(output.status.code(), Some(2));
    assert!(
        text(&output.stderr).contains("'notes.txt'"),
        "{}",
        text(&output.stderr)
    );
    assert_eq!(
        std::fs::read_dir(folder.path().join("mine"))
            .unwrap()
            .count(),
        1
    );
    let output = stickslip(&["new", "ocillator", "other"], folder.path());
    assert_eq!(output.status.code(), Some(2));
    let said = text(&output.stderr);
    assert!(
        said.contains("did you mean 'oscillator'") && said.contains("--list"),
        "{said}"
    );
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
