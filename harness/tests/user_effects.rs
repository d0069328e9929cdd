//! Effects of the user's own, from their file to the calibrated FMU.

use beam_physics::belt::Inputs;
use beam_physics::effects::user_expression::{Target, UserEffect, UserParameter};
use beam_physics::integrate::MAX_STATES;
use beam_physics::parameters::ModelParameters;
use beam_physics::simulate::{DEFAULT_TOLERANCE, Simulation, Start, StartContact};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use stickslip::command::{pack, repaired_model};
use stickslip::diagnose::model::library;
use stickslip::fmu::effect_card::{Role, candidates};
use stickslip::fmu::{Course, Directions, Fmu, Instance};

/// Target, formula, name, unit and value of its one parameter.
type Case = (Target, &'static str, &'static str, f64);
const CASES: [Case; 4] = [
    (Target::FrictionFactor, "1 + k*tanh(w_dot/0.02)", "1", 0.1),
    (
        Target::NormalForceFactor,
        "1 + k*sin(2*pi*40*t)*(w > 0)",
        "1",
        0.1,
    ),
    (Target::TipForce, "-k*max(w - 0.5e-3, 0)^3", "N/m3", 1e11),
    (Target::BeltVelocity, "k*v0*sin(2*pi*30*t)", "1", 0.05),
];

fn file_of(id: &str, (target, formula, unit, value): Case) -> String {
    format!(
        "id = \"{id}\"\ntitle = \"Mine\"\ntarget = \"{}\"\nexpression = \"{formula}\"\n\n\
         [[parameter]]\nname = \"k\"\nunit = \"{unit}\"\nmin = 0\nmax = {:?}\ntypical = {value:?}\n",
        target.name(),
        10.0 * value
    )
}

/// An FMU with the effects in these files.
fn packed(folder: &Path, texts: &[String]) -> Fmu {
    let files: Vec<PathBuf> = (0..texts.len())
        .map(|i| folder.join(format!("{i}.toml")))
        .collect();
    for (file, text) in files.iter().zip(texts) {
        std::fs::write(file, text).unwrap();
    }
    let path = folder.join("X.fmu");
    pack::pack_with(&path, &files).unwrap();
    Fmu::load(&path).unwrap()
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

const STEPS: u32 = 60;
const STEP: f64 = 1e-3;

fn started(fmu: &Fmu, settings: &[(&str, f64)]) -> Instance {
    let mut instance = fmu.instantiate("test").unwrap();
    let all = [
        ("belt_velocity", 0.1),
        ("normal_force", 100.0),
        ("q[1]", 8.3e-4),
    ];
    for (name, value) in all.iter().chain(settings) {
        instance
            .set_number(fmu.variable(name).unwrap(), *value)
            .unwrap();
    }
    instance.initialize(0.0, None, None).unwrap();
    instance
}

/// Displacement of the tip in m at the end of each step.
fn motion(fmu: &Fmu, settings: &[(&str, f64)]) -> Vec<f64> {
    outputs(fmu, settings, "tip_displacement")
}

/// The same as the sensor gives it.
fn measured(fmu: &Fmu, settings: &[(&str, f64)]) -> Vec<f64> {
    outputs(fmu, settings, "measured_displacement")
}

fn outputs(fmu: &Fmu, settings: &[(&str, f64)], name: &str) -> Vec<f64> {
    let mut instance = started(fmu, settings);
    let displacement = fmu.real_references(&[name]).unwrap();
    (0..STEPS)
        .map(|i| {
            instance.do_step(f64::from(i) * STEP, STEP).unwrap();
            let mut value = [f64::NAN];
            instance.get_real(&displacement, &mut value).unwrap();
            value[0]
        })
        .collect()
}

/// The same by the physics alone.
fn expected((target, formula, unit, value): Case) -> Vec<f64> {
    let parameters = ModelParameters {
        user_effects: vec![UserEffect::new(
            "mine",
            target,
            formula,
            vec![UserParameter {
                name: "k".into(),
                unit: unit.into(),
                start: 0.0,
                min: 0.0,
                max: 1e12,
                value,
            }],
        )],
        ..ModelParameters::default()
    };
    let mut state = [0.0; MAX_STATES];
    state[0] = 8.3e-4;
    let start = Start {
        state,
        contact: StartContact::Automatic,
        ..Start::default()
    };
    let inputs = Inputs::constant(0.1, 100.0);
    let mut run = Simulation::new(&parameters, inputs, &start, DEFAULT_TOLERANCE).unwrap();
    (0..STEPS)
        .map(|i| {
            run.advance_to(f64::from(i) * STEP + STEP).unwrap();
            run.outputs().displacement
        })
        .collect()
}

#[test]
fn an_effect_in_an_fmu_moves_as_in_the_physics_and_off_as_the_plain_fmu() {
    let folder = folder();
    let id = |case: &Case| format!("my_{}", case.0.name());
    let texts: Vec<String> = CASES.iter().map(|c| file_of(&id(c), *c)).collect();
    let fmu = packed(folder.path(), &texts);
    let path = folder.path().join("plain.fmu");
    pack::pack(&path).unwrap();
    let plain = motion(&Fmu::load(&path).unwrap(), &[]);
    assert!(motion(&fmu, &[]) == plain, "off is bit-identical to absent");
    for case in CASES {
        let name = format!("{}.k", id(&case));
        let moved = motion(&fmu, &[(&name, case.3)]);
        assert_ne!(moved, plain);
        for (a, b) in moved.iter().zip(expected(case)) {
            assert!((a - b).abs() <= 1e-12, "{name}: {a} {b}");
        }
    }
}

#[test]
fn an_effect_is_a_candidate_like_those_of_the_catalogue() {
    let folder = folder();
    let fmu = packed(folder.path(), &[file_of("mine", CASES[2])]);
    let all = candidates(&fmu).unwrap();
    let mine = all.last().unwrap();
    assert_eq!((mine.id.as_str(), all.len() >= 17), ("mine", true));
    assert_eq!(mine.equation, "F_tip = -k*max(w - 0.5e-3, 0)^3");
    assert_eq!(mine.parameters[0].role, Role::Amplitude);
    assert_eq!(mine.parameters[0].reference, 9000);
    assert_eq!(mine.parameters[0].unit, "N/m3");
}

#[test]
fn a_formula_without_value_is_an_error_with_a_message() {
    let folder = folder();
    let late = (Target::FrictionFactor, "1 + k/(t < 0.01)", "1", 0.1);
    let fmu = packed(folder.path(), &[file_of("late", late)]);
    let mut instance = started(&fmu, &[("late.k", 0.1)]);
    let outcome = (0..40).try_for_each(|i| instance.do_step(f64::from(i) * STEP, STEP));
    let message = outcome.unwrap_err().to_string();
    assert!(message.contains("returned fmi2Error"), "{message}");
    assert!(
        message.contains("user effect 'late': the formula gives inf"),
        "{message}"
    );
    // The FMU lives on.
    instance.reset().unwrap();
    drop(instance);
    assert_eq!(motion(&fmu, &[]).len(), STEPS as usize);
}

#[test]
fn states_go_to_fmus_with_the_same_effects_only() {
    let folders = [folder(), folder()];
    let one = packed(folders[0].path(), &[file_of("mine", CASES[0])]);
    let two = packed(folders[1].path(), &[file_of("mine", CASES[2])]);
    let mut a = started(&one, &[("mine.k", 0.1)]);
    a.do_step(0.0, STEP).unwrap();
    let state = a.save_state().unwrap();
    let bytes = a.serialize_state(&state).unwrap();
    let mut again = started(&one, &[]);
    assert!(again.deserialize_state(&bytes).is_ok());
    let error = started(&two, &[]).deserialize_state(&bytes).unwrap_err();
    assert!(error.to_string().contains("does not fit"), "{error}");
}

/// Writes an archive of files again, some changed.
fn changed(fmu: &Fmu, path: &Path, change: impl Fn(&str, Vec<u8>) -> Option<Vec<u8>>) {
    let files = fmu.files().unwrap().into_iter();
    let files = files.filter_map(|(name, bytes)| Some((name.clone(), change(&name, bytes)?)));
    pack::write_fmu(path, &files.collect::<Vec<_>>()).unwrap();
}

#[test]
fn an_effect_changed_after_packing_is_refused() {
    let folder = folder();
    let fmu = packed(folder.path(), &[file_of("mine", CASES[0])]);
    let files = fmu.files().unwrap().into_iter().map(|(name, bytes)| {
        let text = String::from_utf8_lossy(&bytes).replace("0.02", "0.03");
        let effect = name == "resources/effects/mine.toml";
        (name, if effect { text.into_bytes() } else { bytes })
    });
    let error = pack::write_fmu(&folder.path().join("Y.fmu"), &files.collect::<Vec<_>>());
    let message = error.unwrap_err().to_string();
    assert!(
        message.contains("effects/mine.toml: was changed since") && message.contains("pack"),
        "{message}"
    );
}

#[test]
fn a_calibrated_fmu_keeps_effects_and_starts_with_its_values() {
    let folder = folder();
    let fmu = packed(folder.path(), &[file_of("mine", CASES[0])]);
    let values = [
        ("mine.k".to_owned(), 0.08),
        ("friction.mu_0".to_owned(), 0.61),
    ];
    let path = folder.path().join("calibrated.fmu");
    repaired_model::write_fmu(&fmu, &values, &path).unwrap();
    let calibrated = Fmu::load(&path).unwrap();
    let set = motion(&fmu, &[("mine.k", 0.08), ("friction.mu_0", 0.61)]);
    assert!(motion(&calibrated, &[]) == set);
    assert_ne!(calibrated.description().guid, fmu.description().guid);
    assert_eq!(candidates(&calibrated).unwrap().last().unwrap().id, "mine");
    // A second calibration adds to the first.
    let again = folder.path().join("again.fmu");
    repaired_model::write_fmu(&calibrated, &[("mine.k".to_owned(), 0.0)], &again).unwrap();
    assert!(motion(&Fmu::load(&again).unwrap(), &[]) == motion(&fmu, &[("friction.mu_0", 0.61)]));
    // What the FMU does not take is refused.
    let bad = [("friction.mu_0".to_owned(), -1.0)];
    let error = repaired_model::write_fmu(&fmu, &bad, &again).unwrap_err();
    assert!(error.to_string().contains("at least 0"), "{error}");
}

#[test]
fn an_fmu_of_others_keeps_everything_but_its_start_attributes() {
    let folder = folder();
    let ours = packed(folder.path(), &[]);
    let path = folder.path().join("theirs.fmu");
    changed(&ours, &path, |name, bytes| {
        (name != pack::START_VALUES).then_some(bytes)
    });
    let theirs = Fmu::load(&path).unwrap();
    let calibrated = folder.path().join("calibrated.fmu");
    let values = [
        ("friction.mu_0".to_owned(), 0.61),
        ("mode_count".to_owned(), 3.0),
    ];
    repaired_model::write_fmu(&theirs, &values, &calibrated).unwrap();
    let (before, after) = (theirs.files().unwrap(), Fmu::load(&calibrated).unwrap());
    let after = after.files().unwrap();
    assert_eq!(before.len(), after.len());
    assert!(before[1..] == after[1..]);
    let lines = |file: &(String, Vec<u8>)| -> Vec<String> {
        let text = String::from_utf8(file.1.clone()).unwrap();
        text.lines().map(str::to_owned).collect()
    };
    let (before, after) = (lines(&before[0]), lines(&after[0]));
    let different: Vec<_> = before.iter().zip(&after).filter(|(a, b)| a != b).collect();
    assert_eq!(different.len(), 2, "{different:#?}");
    assert!(different[0].1.contains("start=\"3\""));
    assert!(different[1].1.contains("start=\"0.61\""));
}

fn stickslip(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stickslip"));
    command.args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
fn bad_files_are_named_with_their_line_and_nothing_is_written() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (good, bad, fmu) = (at("good.toml"), at("bad.toml"), at("X.fmu"));
    std::fs::write(&good, file_of("mine", CASES[0])).unwrap();
    std::fs::write(&bad, file_of("mine", CASES[0]).replace("w_dot", "speed")).unwrap();
    for (files, expected) in [
        (
            vec![&bad],
            format!("{bad}:4: '1 + k*tanh(speed/0.02)', column 12: unknown name 'speed'"),
        ),
        (
            vec![&good, &good],
            format!("{good}: two effects have the id 'mine'"),
        ),
        (vec![&fmu], format!("cannot read {fmu}")),
    ] {
        let mut arguments = vec!["pack", "-o", &fmu];
        files
            .iter()
            .for_each(|file| arguments.extend(["--effect", file]));
        let output = stickslip(&arguments);
        assert_eq!(output.status.code(), Some(2));
        assert!(
            text(&output.stderr).contains(&expected),
            "{}",
            text(&output.stderr)
        );
        assert!(!Path::new(&fmu).exists());
    }
}

/// Three runs of the model with an effect of the user's own, sampled at 10 kHz with 0.2 micrometres of noise.
fn campaign(fmu: &Fmu, settings: &[(&str, f64)], folder: &Path) {
    std::fs::create_dir(folder).unwrap();
    let displacement = fmu.real_references(&["measured_displacement"]).unwrap();
    let mut list = String::from(
        "[beam]\nnatural_frequencies_hz = [80.0, 510.0]\ndamping_ratios = [0.00015, 0.00085]\nmass_kg = 0.427\n",
    );
    let mut random = 1_u64;
    for (i, (velocity, force)) in [(0.06, 60.0), (0.08, 70.0), (0.1, 90.0)].iter().enumerate() {
        let point = [("belt_velocity", *velocity), ("normal_force", *force)];
        let mut instance = started(fmu, &[settings, &point].concat());
        let mut csv = String::from("time_s,tip_displacement_m\n");
        for step in 0..2500 {
            let time = f64::from(step) * 1e-4;
            instance.do_step(time, 1e-4).unwrap();
            let mut w = [0.0];
            instance.get_real(&displacement, &mut w).unwrap();
            let mut noise = -6.0;
            for _ in 0..12 {
                // A linear congruential generator (Knuth, MMIX); twelve of its numbers make nearly a normal one.
                random = random
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                noise += (random >> 11) as f64 / (1_u64 << 53) as f64;
            }
            if step >= 500 {
                let _ = writeln!(csv, "{:.4},{:.9e}", time - 0.05, w[0] + 2e-7 * noise);
            }
        }
        std::fs::write(folder.join(format!("{i}.csv")), csv).unwrap();
        let _ = write!(
            list,
            "[[run]]\nfile = \"{i}.csv\"\nbelt_velocity_m_per_s = {velocity}\nnormal_force_n = {force}\n"
        );
    }
    std::fs::write(folder.join("campaign.toml"), list).unwrap();
}

#[test]
fn trying_an_effect_of_ones_own_brings_the_error_down_to_the_noise() {
    let folder = folder();
    let fmu = packed(folder.path(), &[file_of("mine", CASES[2])]);
    let runs = folder.path().join("campaign");
    campaign(&fmu, &[("mine.k", 1.2e11)], &runs);
    // Without a library beside it the program can't pack, and need not.
    let program = folder.path().join("stickslip");
    std::fs::copy(env!("CARGO_BIN_EXE_stickslip"), &program).unwrap();
    let out = folder.path().join("out");
    let output = Command::new(&program)
        .args(["try", runs.to_str().unwrap(), "--add", "mine", "--json"])
        .args(["--fmu", fmu.path().to_str().unwrap()])
        .args(["-o", out.to_str().unwrap()])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let strength = &json["effects"][0]["parameters"]["k"];
    assert_eq!(json["effects"][0]["id"], "mine");
    assert!(
        (strength["value"].as_f64().unwrap() - 1.2e11).abs() < 1.2e10,
        "{strength}"
    );
    let rungs = json["error_ladder"].as_array().unwrap();
    let ratio = rungs.last().unwrap()["holdout_over_noise"]
        .as_f64()
        .unwrap();
    assert!(ratio < 1.5, "{ratio}");
    let calibrated = Fmu::load(&out.join(pack::FILE_NAME)).unwrap();
    let start = calibrated.variable("mine.k").unwrap().start_number();
    // The reader of JSON may be off by the last digit.
    approx::assert_relative_eq!(
        start.unwrap(),
        strength["value"].as_f64().unwrap(),
        max_relative = 1e-14
    );
}

/// val: the demonstration campaign by reference-data/computed/generator, in which friction varies along the belt with 22 mm.
#[test]
fn val_what_repeats_is_found_whatever_its_phase_is_called_and_far_from_what_is_typical() {
    let folder = folder();
    let ribs = "id = \"ribs\"\ntitle = \"Ribs\"\ntarget = \"friction_factor\"\nexpression = \"1 + a*cos(2*pi*s/L + p)\"\n\
        [[parameter]]\nname = \"a\"\nunit = \"1\"\nmin = 0\nmax = 0.3\ntypical = 0.05\n\
        [[parameter]]\nname = \"L\"\nunit = \"m\"\nmin = 0.002\nmax = 0.1\ntypical = 0.06\nrole = \"shape\"\n\
        [[parameter]]\nname = \"p\"\nunit = \"rad\"\nmin = -4\nmax = 4\ntypical = 0\nrole = \"phase\"\n";
    let fmu = packed(folder.path(), &[ribs.to_owned()]);
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-data/demo");
    let out = folder.path().join("out");
    let output = stickslip(&[
        "try",
        demo.to_str().unwrap(),
        "--add",
        "ribs",
        "--json",
        "--fmu",
        fmu.path().to_str().unwrap(),
        "-o",
        out.to_str().unwrap(),
    ]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let length = &json["effects"][0]["parameters"]["L"]["value"];
    assert!(
        (length.as_f64().unwrap() - 0.022).abs() < 1e-4,
        "{length} m where 0.022 m is hidden"
    );
}

/// Effects on the other targets, with states and a table; `k` switches each on, with its typical value behind.
const WITH_MEMORY: [(&str, f64); 4] = [
    (
        "target = 'friction_factor'\nexpression = '1 - k*heat'\n\
         [[state]]\nname = 'heat'\nunit = 'J'\nnominal = 0.01\nrate = 'abs(F*v_r) - heat/0.02'\non_break_away = '0.9*heat'\n",
        0.5,
    ),
    ("target = 'measurement'\nexpression = 'w + k*w^2'\n", 60.0),
    (
        "target = 'frequency_factor'\nmode = 1\nexpression = '1 - k*x'\n\
         [[state]]\nname = 'x'\nunit = '1'\nnominal = 1\nrate = '(1 - x)/0.05'\n",
        0.02,
    ),
    (
        "target = 'damping_factor'\nexpression = '1 + k*(table(w, g))^2'\n\
         [[table]]\nname = 'g'\nunit = '1'\nat = [-1e-3, 0.1e-3, 2e-3]\nmin = 0\nmax = 9\ntypical = 3\nrole = 'shape'\n",
        5.0,
    ),
];

fn file_with_memory((text, strength): (&str, f64)) -> String {
    format!(
        "id = 'mine'\ntitle = 'Mine'\n{text}\n[[parameter]]\nname = 'k'\nunit = '1'\n\
         min = 0\nmax = {:?}\ntypical = {strength:?}\n",
        10.0 * strength
    )
}

#[test]
fn an_effect_with_memory_is_off_as_absent_and_its_state_is_a_variable() {
    let (folder, plain) = (folder(), folder());
    let nothing = motion(&packed(plain.path(), &[]), &[]);
    for case in WITH_MEMORY {
        let fmu = packed(folder.path(), &[file_with_memory(case)]);
        assert!(motion(&fmu, &[]) == nothing, "{case:?}");
    }
    let fmu = packed(folder.path(), &[file_with_memory(WITH_MEMORY[2])]);
    let mut instance = started(&fmu, &[("mine.k", 0.02)]);
    let state = fmu.real_references(&["mine.state.x"]).unwrap();
    let read = |instance: &mut Instance| {
        let mut x = [0.0];
        instance.get_real(&state, &mut x).unwrap();
        x[0]
    };
    instance.do_step(0.0, 0.03).unwrap();
    let expected = 1.0 - (-0.03_f64 / 0.05).exp();
    assert!((read(&mut instance) - expected).abs() < 1e-9);
    // A saved state holds it.
    let saved = instance.save_state().unwrap();
    let bytes = instance.serialize_state(&saved).unwrap();
    instance.do_step(0.03, 0.02).unwrap();
    let later = read(&mut instance);
    let mut again = started(&fmu, &[("mine.k", 0.02)]);
    let restored = again.deserialize_state(&bytes).unwrap();
    again.restore_state(&restored).unwrap();
    again.do_step(0.03, 0.02).unwrap();
    assert!(read(&mut again).to_bits() == later.to_bits());
}

#[test]
fn every_effect_of_the_library_is_off_as_absent_and_moves_the_tip_where_it_is_on() {
    let folder = folder();
    let texts = library::FILES.map(str::to_owned);
    let fmu = packed(folder.path(), &texts);
    let empty = tempfile::tempdir().unwrap();
    let nothing = measured(&packed(empty.path(), &[]), &[]);
    assert!(measured(&fmu, &[]) == nothing);
    let all = candidates(&fmu).unwrap();
    let of_library = all.iter().filter(|c| library::is_library_effect(&c.id));
    let mut count = 0;
    for card in of_library {
        let names: Vec<(String, f64)> = card
            .parameters
            .iter()
            .map(|p| (format!("{}.{}", card.id, p.name), p.typical))
            .collect();
        let mut on: Vec<(&str, f64)> = names.iter().map(|(n, v)| (n.as_str(), *v)).collect();
        // States from where they are in equilibrium with the start: Settled.
        on.push(("start.effects", 1.0));
        let moved = measured(&fmu, &on);
        let change = moved
            .iter()
            .zip(&nothing)
            .fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
        // Visible beside the noise of a good sensor, and still a motion of this beam.
        assert!(change > 2e-7, "{}: {change} m", card.id);
        assert!(moved.iter().all(|w| w.abs() < 5e-3), "{}", card.id);
        for text in [&card.source, &card.signature, &card.confounders] {
            assert!(!text.is_empty(), "{} tells too little of itself", card.id);
        }
        count += 1;
    }
    assert_eq!(count, library::FILES.len());
}

#[test]
fn val_motions_with_users_effects_have_derivatives_by_their_parameters() {
    // Source: central differences of motions by fmi2DoStep.
    let simple = CASES.map(|case| (file_of("mine", case), case.3));
    let with_memory = WITH_MEMORY.map(|case| (file_with_memory(case), case.1));
    for (file, strength) in simple.into_iter().chain(with_memory) {
        let folder = folder();
        let fmu = packed(folder.path(), std::slice::from_ref(&file));
        let names = [
            "belt_velocity",
            "normal_force",
            "q[1]",
            "mine.k",
            "tolerance",
        ];
        let values = [0.1, 100.0, 8.3e-4, strength, 1e-12];
        let references = fmu.real_references(&names).unwrap();
        let times: Vec<f64> = (0..=STEPS).map(|i| f64::from(i) * STEP).collect();
        let mut directions = Directions::default();
        directions.push([(references[2], 1.0)]);
        directions.push([(references[3], 1.0)]);
        let (mut motion_with, mut slopes) = (vec![0.0; times.len()], vec![0.0; 2 * times.len()]);
        let mut tangents = fmu.tangents().expect("our FMU offers them");
        assert!(tangents.set((&[], &[]), (&references, &values)));
        let output = fmu.real_references(&["measured_displacement"]).unwrap()[0];
        assert!(tangents.evaluate(
            (&times, &Course::default()),
            &[output],
            &directions,
            &mut motion_with,
            &mut slopes
        ));
        let at = |name: &str, value: f64| {
            let settings = [("mine.k", strength), ("tolerance", 1e-12), (name, value)];
            measured(&fmu, &settings)
        };
        for (i, (name, value)) in [("q[1]", 8.3e-4), ("mine.k", strength)]
            .into_iter()
            .enumerate()
        {
            // A motion that grows by a factor of 750: steps ten times as large are no differentials.
            let step = 1e-6 * value;
            let (low, high) = (at(name, value - step), at(name, value + step));
            let truth: Vec<f64> = low
                .iter()
                .zip(&high)
                .map(|(a, b)| (b - a) / (2.0 * step))
                .collect();
            let largest = truth.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
            assert!(largest > 0.0, "{file}, {name}: nothing to compare");
            for (k, t) in truth.iter().enumerate() {
                let slope = slopes[i * times.len() + k + 1];
                assert!(
                    (slope - t).abs() < 1e-3 * largest,
                    "{file}, by {name} at {} s: {slope} against {t}",
                    times[k + 1]
                );
            }
        }
    }
}
