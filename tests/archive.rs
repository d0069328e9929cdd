//! What the packed archive holds (FMI 2.0.5, section 2.3), and the files for the FMI Cross-Check.

use std::collections::BTreeMap;
use std::path::Path;
use stickslip::command::{cross_check, pack};
use stickslip::fmu::{Fmu, PLATFORM};
use stickslip_tests::slave::{OK, Slave};
use stickslip_tests::variables::XML;

fn files(path: &Path) -> BTreeMap<String, Vec<u8>> {
    Fmu::load(path)
        .unwrap()
        .files()
        .unwrap()
        .into_iter()
        .collect()
}

fn packed() -> BTreeMap<String, Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("StickSlipBeam.fmu");
    pack::pack(&path).unwrap();
    files(&path)
}

fn text(files: &BTreeMap<String, Vec<u8>>, name: &str) -> String {
    let bytes = files
        .get(name)
        .unwrap_or_else(|| panic!("{name} is missing"));
    String::from_utf8(bytes.clone()).unwrap()
}

/// Rows of numbers below a head line of quoted names.
fn table(csv: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut lines = csv.lines();
    let names = lines.next().unwrap().split(',');
    let names = names.map(|n| n.trim_matches('"').to_owned()).collect();
    let row = |line: &str| line.split(',').map(|x| x.parse().unwrap()).collect();
    (names, lines.map(row).collect())
}

#[test]
fn picture_and_documentation_are_there_and_nothing_of_fmi_3() {
    let files = packed();
    assert_eq!(text(&files, "modelDescription.xml"), *XML);
    assert_eq!(&files["model.png"][..8], b"\x89PNG\r\n\x1a\n");
    assert!(text(&files, "documentation/index.html").contains("belt_velocity"));
    let license = |name: &str| text(&files, &format!("documentation/licenses/{name}"));
    assert!(license("license.txt").contains("MIT"));
    assert!(license("license_mit.txt").contains("WITHOUT WARRANTY OF ANY KIND"));
    assert!(license("license_apache.txt").contains("TERMS AND CONDITIONS"));
    assert!(license("third_party.txt").contains("nalgebra | Apache-2.0"));
    // VDMCheck2 and FMI Library report errors on an FMI 2.0 archive with this folder of FMI 3.0.
    assert!(
        !files
            .keys()
            .any(|name| name.starts_with("terminalsAndIcons"))
    );
}

#[test]
fn the_default_parameter_set_is_the_description_s() {
    let set = text(&packed(), "resources/defaults.ssv");
    let set = roxmltree::Document::parse(&set).unwrap();
    let description = roxmltree::Document::parse(&XML).unwrap();
    let mut count = 0;
    for variable in description
        .descendants()
        .filter(|n| n.attribute("causality") == Some("parameter"))
    {
        let name = variable.attribute("name").unwrap();
        let start: f64 = variable
            .first_element_child()
            .unwrap()
            .attribute("start")
            .unwrap()
            .parse()
            .unwrap();
        let same = set
            .descendants()
            .find(|n| n.tag_name().name() == "Parameter" && n.attribute("name") == Some(name))
            .unwrap_or_else(|| panic!("{name} is missing"));
        let value: f64 = same
            .first_element_child()
            .unwrap()
            .attribute("value")
            .unwrap()
            .parse()
            .unwrap();
        assert_eq!(value, start, "{name}");
        count += 1;
    }
    assert!(count > 150, "{count}");
}

#[test]
fn the_reference_results_are_those_of_the_binary() {
    let files = packed();
    let csv = text(
        &files,
        "extra/org.fmi-standard.fmi-ls-ref/StickSlipBeam_out.csv",
    );
    let (names, rows) = table(&csv);
    assert!(files.contains_key("extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml"));
    let slave = Slave::started();
    for (i, row) in rows.iter().enumerate() {
        if i > 0 {
            let (from, to) = ((i - 1) as f64 * 1e-3, i as f64 * 1e-3);
            assert_eq!(slave.step(from, to - from), OK);
        }
        for (name, value) in names.iter().zip(row) {
            let here = match name.as_str() {
                "time" => i as f64 * 1e-3,
                "contact_mode" | "transition_count" => f64::from(slave.get_integer(name)),
                _ => slave.get(name),
            };
            assert_eq!(*value, here, "{name} in row {i}");
        }
    }
    assert_eq!(rows.len(), 201);
}

#[test]
fn the_cross_check_files_keep_its_rules() {
    // FMI-CROSS-CHECK-RULES, section 4.1: at least three FMUs, ten results at most, below 1 MB, head line of quoted names.
    let folder = tempfile::tempdir().unwrap();
    let folders = cross_check::write(folder.path()).unwrap();
    assert!(folders.len() >= 3);
    let mut inputs = 0;
    for model in &folders {
        let below = model.strip_prefix(folder.path()).unwrap();
        assert!(below.starts_with(format!("fmus/2.0/cs/{PLATFORM}/StickSlip")));
        let name = model.file_name().unwrap().to_str().unwrap();
        let file = |ending: &str| model.join(format!("{name}{ending}"));
        let read = |ending: &str| std::fs::read_to_string(file(ending)).unwrap();
        let fmu = Fmu::load(&file(".fmu")).unwrap();
        let csv = read("_ref.csv");
        assert!(csv.len() < 1_000_000 && csv.starts_with("\"time\",\""));
        let (names, rows) = table(&csv);
        assert!(names.len() <= 11 && rows.len() == 501);
        assert!(rows.windows(2).all(|pair| pair[0][0] < pair[1][0]));
        assert!(
            names[1..]
                .iter()
                .all(|n| fmu.description().find(n).is_some())
        );
        assert!(rows.iter().flatten().all(|x| x.is_finite()));
        let options = read("_ref.opt");
        for key in ["StartTime", "StopTime", "StepSize", "RelTol"] {
            assert!(options.contains(key), "{options}");
        }
        assert!(model.join("readme.txt").is_file());
        if file("_in.csv").is_file() {
            inputs += 1;
            let (names, rows) = table(&read("_in.csv"));
            assert_eq!(names, ["time", "belt_velocity", "normal_force"]);
            assert!(rows[0][1] < rows[1][1] && rows[0][0] == 0.0);
        }
    }
    assert_eq!(inputs, 1);
}
