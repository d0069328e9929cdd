//! Loggers' files that are cut off or spoilt: no panic, one line that says why, nothing left behind.

// Its good files are for others.
#[allow(dead_code)]
mod trial;

use std::path::Path;
use std::process::Command;

use trial::complaint;

const WHOLE: [&str; 12] = [
    "matlab5.mat",
    "matlab5_compressed.mat",
    "matlab5_struct.mat",
    "matlab73.mat",
    "hdf5.h5",
    "hdf5_rate.h5",
    "ascii.uff",
    "binary.uff",
    "pcm24.wav",
    "snappy.parquet",
    "zstd.parquet",
    "waveform.tdms",
];

fn bytes_of(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/import_files");
    std::fs::read(folder.join(name)).unwrap()
}

/// Imports a file of this name and content; whether it succeeded, and what was said.
fn tried(name: &str, bytes: &[u8]) -> (bool, String) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(name), bytes).unwrap();
    let words = [
        "import",
        name,
        "-o",
        "new",
        "--belt-velocity",
        "0",
        "--normal-force",
        "1",
        "--scale",
        "1",
    ];
    let line: Vec<String> = words.iter().map(|w| (*w).to_owned()).collect();
    assert_eq!(
        complaint(folder.path(), &line),
        None,
        "{name}, {} bytes",
        bytes.len()
    );
    let said = std::fs::read_to_string(folder.path().join(".stderr")).unwrap();
    let is_there = folder.path().join("new").exists();
    let entries = std::fs::read_dir(folder.path()).unwrap();
    let hidden = entries.filter(|e| {
        let name = e.as_ref().unwrap().file_name();
        name.to_string_lossy().starts_with(".stickslip-")
    });
    assert_eq!(hidden.count(), 0, "{name}: something was left half-written");
    let failed = said.lines().any(|line| line.starts_with("error:"));
    assert_eq!(is_there, !failed, "{name}: {said}");
    (!failed, said)
}

#[test]
fn files_cut_off_anywhere_are_refused() {
    for name in WHOLE {
        let whole = bytes_of(name);
        for share in [0.0, 0.001, 0.01, 0.03, 0.1, 0.25, 0.5, 0.75, 0.9, 0.97] {
            let count = (share * whole.len() as f64) as usize;
            let (done, said) = tried(name, &whole[..count]);
            assert!(!done, "{name}, {count} of {} bytes: {said}", whole.len());
            assert!(said.contains(name) && said.contains("; "), "{said}");
        }
    }
}

#[test]
fn spoilt_bytes_do_not_panic() {
    let mut random = 12_345u64;
    let mut next = move || {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        random
    };
    for name in WHOLE {
        let whole = bytes_of(name);
        for trial in 0..12 {
            let mut spoilt = whole.clone();
            // The head is where lengths and types stand.
            let reach = if trial % 2 == 0 {
                whole.len()
            } else {
                whole.len().min(400)
            };
            for _ in 0..1 + trial / 2 {
                let at = (next() % reach as u64) as usize;
                spoilt[at] = [0xff, 0x00, 0x7f, 0x80, next() as u8][(next() % 5) as usize];
            }
            tried(name, &spoilt);
        }
    }
}

fn uff(head: &str, data: &str) -> String {
    format!(
        "    -1\n    58\nlaser\nNONE\nNONE\nNONE\nNONE\n    1         0    0         0       NONE         3   1       NONE         0   0\n\
         {head}\n        17    0    0    0 NONE                 s\n         8    0    0    0 NONE                 mm\n\
         \x20        0    0    0    0 NONE                 NONE\n         0    0    0    0 NONE                 NONE\n{data}    -1\n"
    )
}

#[test]
fn mistakes_are_named_with_channel_and_remedy() {
    let rows = |row: &dyn Fn(usize) -> String| (0..64).map(row).collect::<String>();
    let single = rows(&|i| format!(" {:12.5E}\n", (i % 7) as f64));
    let good = "         2        64         1  0.00000e+00  5.00000e-04  0.00000e+00";
    let cases: [(&str, String, &[&str]); 12] = [
        (
            "two.csv",
            format!(
                "t [s],t2 [ms],x [mm]\n{}",
                rows(&|i| format!("{i},{i},1\n"))
            ),
            &["'t', 't2'", "--time"],
        ),
        (
            "words.csv",
            format!(
                "t [s],x [mm]\n{}",
                rows(&|i| if i == 20 {
                    "20,lost\n".into()
                } else {
                    format!("{i},{}\n", i % 5)
                })
            ),
            &["'x [mm]'", "line 22", "'lost'"],
        ),
        (
            "empty.csv",
            format!("t [s],x [mm],y\n{}", rows(&|i| format!("{i},,1\n"))),
            &["channel 'x'", "not one number"],
        ),
        (
            "nan.csv",
            format!(
                "t [s],x [mm]\n{}",
                rows(&|i| if i == 3 {
                    "3,NaN\n".into()
                } else {
                    format!("{i},{}\n", i % 5)
                })
            ),
            &["sample 4", "--skip-missing"],
        ),
        (
            "mixed.csv",
            format!(
                "t [s],x [mm]\n{}",
                rows(&|i| if i == 9 {
                    "9,1,1\n".into()
                } else {
                    format!("{i},1\n")
                })
            ),
            &["mixed.csv:11", "3 fields"],
        ),
        (
            "strain.csv",
            format!("t [s],x [um/m]\n{}", rows(&|i| format!("{i},{}\n", i % 5))),
            &["channel 'x'", "a strain"],
        ),
        (
            "speed.csv",
            format!("t [s],x [mm/s]\n{}", rows(&|i| format!("{i},{}\n", i % 5))),
            &["channel 'x'", "a velocity", "--velocity x"],
        ),
        (
            "volts.csv",
            format!("t [s],x [V]\n{}", rows(&|i| format!("{i},{}\n", i % 5))),
            &[],
        ),
        (
            "few.uff",
            uff(&good.replace("64", "65"), &single),
            &["data set 1", "65 points"],
        ),
        (
            "many.uff",
            uff(&good.replace("64", "60"), &single),
            &["60 points", "more"],
        ),
        (
            "words.uff",
            uff(good, &single.replacen(" 3.0", " x.y", 1)),
            &["where numbers should stand"],
        ),
        (
            "run.xlsx",
            "PK\u{3}\u{4}".to_owned(),
            &["spreadsheet", "Python"],
        ),
    ];
    for (name, text, parts) in cases {
        let (done, said) = tried(name, text.as_bytes());
        assert_eq!(done, parts.is_empty(), "{name}: {said}");
        assert!(
            parts.iter().all(|part| said.contains(part)),
            "{parts:?}: {said}"
        );
    }
    let (done, said) = tried("good.uff", uff(good, &single).as_bytes());
    assert!(done, "{said}");
}

#[test]
fn a_recording_that_was_not_finished_says_so() {
    let mut bytes = bytes_of("waveform.tdms");
    bytes[12..20].fill(0xff);
    let (_, said) = tried("run.tdms", &bytes);
    assert!(
        said.contains("never finished") && said.contains("nptdms"),
        "{said}"
    );
}

#[test]
fn a_folder_that_can_not_be_written_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("run.mat"), bytes_of("matlab5.mat")).unwrap();
    std::fs::write(folder.path().join("file"), "x").unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .args(["import", "run.mat", "-o", "file/new"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(4));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}
