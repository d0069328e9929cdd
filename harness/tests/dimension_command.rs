//! `stickslip dimension` through the command line.

mod attractors;

use std::process::{Command, Output};

fn dimension(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .arg("dimension")
        .args(arguments)
        .output()
        .unwrap()
}

// Source: Grassberger and Procaccia 1983: Henon map 1.21 +- 0.01.
#[test]
fn val_dimension_writes_numbers_counts_and_report() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let text: String = attractors::henon(1, 6000)
        .iter()
        .map(|x| format!("{x}\n"))
        .collect();
    std::fs::write(at("henon.csv"), format!("x\n{text}")).unwrap();
    let done = dimension(&[
        &at("henon.csv"),
        "-o",
        &at("out"),
        "--surrogates",
        "19",
        "--json",
    ]);
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
    let json: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(json["verdict"], "dimension");
    assert!((json["correlation_dimension"].as_f64().unwrap() - 1.21).abs() < 0.06);
    let sums = std::fs::read_to_string(at("out/correlation_sum.csv")).unwrap();
    assert_eq!(sums.lines().next(), Some("m,radius,pairs"));
    assert_eq!(
        sums.lines().count(),
        1 + 10 * json["radii"].as_array().unwrap().len()
    );
    let page = std::fs::read_to_string(at("out/dimension.html")).unwrap();
    assert!(
        page.matches("<script type=\"application/json\">").count() >= 5 && page.contains("Eckmann")
    );
    assert!(
        std::fs::read_to_string(at("out/dimension.json"))
            .unwrap()
            .contains("\"verdict\"")
    );
}

// Source: the issue: "bad input: a clear message".
#[test]
fn val_dimension_refuses_bad_input_clearly() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.csv").to_str().unwrap().to_owned();
    let refused = |text: &str, arguments: &[&str], word: &str| {
        std::fs::write(&file, text).unwrap();
        let done = dimension(&[&[&file[..]], arguments].concat());
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert_eq!(done.status.code(), Some(2), "{said}");
        assert!(said.contains(word), "{said}");
    };
    refused("a,b\n1,2\n3,4\n", &[], "--column");
    refused("a\n1\n2\n", &[], "too few");
    refused(&format!("a\n{}", "5\n".repeat(900)), &[], "does not move");
    let wave: String = (0..900)
        .map(|i| format!("{}\n", (0.1 * f64::from(i)).sin()))
        .collect();
    refused(&wave, &["--delay", "0"], "delay = 0");
    refused(&wave, &["--theiler", "5000"], "900 samples");
}
