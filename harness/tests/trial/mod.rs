//! Running the command on bad input: what every end must look like, and files to spoil.

use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use stickslip::exit::Exit;
use tempfile::TempDir;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// Longest time that any of these commands may take: they take seconds at most, on a busy machine somewhat more.
const LIMIT: Duration = Duration::from_secs(60);

/// Runs the command in `folder`; what is wrong with its end, if anything.
pub fn complaint(folder: &Path, line: &[String]) -> Option<String> {
    let file = |name: &str| std::fs::File::create(folder.join(name)).unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .args(line)
        .current_dir(folder)
        .env("RUST_BACKTRACE", "0")
        .stdin(Stdio::null())
        // Files, so that a long output can't block the command while it is waited for.
        .stdout(file(".stdout"))
        .stderr(file(".stderr"))
        .spawn()
        .unwrap();
    let begun = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if begun.elapsed() > LIMIT {
            child.kill().unwrap();
            child.wait().unwrap();
            return Some(format!("did not end within {LIMIT:?}"));
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let said = std::fs::read(folder.join(".stderr")).unwrap();
    let said = String::from_utf8_lossy(&said);
    let documented = Exit::ALL
        .iter()
        .any(|exit| status.code() == Some(i32::from(exit.code())));
    // What was understood of a file, or questioned in it, may stand before.
    let errors = said.lines().filter(|line| line.starts_with("error:"));
    let one_line = errors.count() == 1
        && said
            .lines()
            .last()
            .is_some_and(|line| line.starts_with("error:") && line.len() > "error: ".len());
    let well = documented && !said.contains("panicked") && (status.success() || one_line);
    let begin: String = said.chars().take(400).collect();
    (!well).then(|| format!("{status}: {begin}"))
}

/// Runs many lines, each in a folder of its own, on all cores; fails with every complaint.
pub fn none_complains(lines: Vec<Vec<String>>) {
    let count = lines.len();
    let lines = Mutex::new(lines.into_iter());
    let complaints = Mutex::new(Vec::new());
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let next = lines.lock().unwrap().next();
                    let Some(line) = next else { break };
                    let folder = tempfile::tempdir().unwrap();
                    if let Some(what) = complaint(folder.path(), &line) {
                        let short = |text: &String| text.chars().take(80).collect::<String>();
                        let line: Vec<String> = line.iter().map(short).collect();
                        let mut complaints = complaints.lock().unwrap();
                        complaints.push(format!("stickslip {}\n    {what}", line.join(" ")));
                    }
                }
            });
        }
    });
    let complaints = complaints.into_inner().unwrap();
    assert!(
        complaints.is_empty(),
        "{} of {count}:\n{}",
        complaints.len(),
        complaints.join("\n")
    );
}

/// Good files of every kind that a command reads.
pub struct Files {
    folder: TempDir,
}

/// Samples of each run: enough to load and to observe, too few for a diagnosis, which would take its time.
const SAMPLES: usize = 250;

impl Files {
    /// Writes them.
    pub fn new() -> Files {
        let files = Files {
            folder: tempfile::tempdir().unwrap(),
        };
        let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-data/demo");
        let case = files.at("blind/01");
        std::fs::create_dir_all(&case).unwrap();
        // As many as a correlation dimension needs.
        let csv = std::fs::read_to_string(demo.join("run01.csv")).unwrap();
        let series: Vec<&str> = csv.lines().take(601).collect();
        files.write("series.csv", (series.join("\n") + "\n").as_bytes());
        let mut campaign =
            String::from("[beam]\nnatural_frequencies_hz = [80.0, 510.0]\nmass_kg = 0.427\n");
        for (run, velocity, force) in [("run01", 0.04, 36.0), ("run02", 0.06, 60.0)] {
            let csv = std::fs::read_to_string(demo.join(format!("{run}.csv"))).unwrap();
            let lines: Vec<&str> = csv.lines().take(1 + SAMPLES).collect();
            std::fs::write(case.join(format!("{run}.csv")), lines.join("\n") + "\n").unwrap();
            campaign += &format!(
                "[[run]]\nfile = \"{run}.csv\"\nbelt_velocity_m_per_s = {velocity}\nnormal_force_n = {force}\n"
            );
        }
        std::fs::write(case.join("campaign.toml"), campaign).unwrap();
        let truth = "[{\"campaign\": \"01\", \"effects\": [], \"parameters\": {}}]";
        files.write("blind/truth.json", truth.as_bytes());
        files.write(
            "beam.toml",
            b"[beam]\nnatural_frequencies_hz = [80.0, 510.0]\nmass_kg = 0.427\n",
        );
        files.write("values.set", b"# a comment\nmode_count=2\n");
        let effect = "id = \"ribs\"\ntitle = \"Ribs\"\ntarget = \"friction_factor\"\nexpression = \"1 + a*cos(s/0.002)\"\n\
            [[parameter]]\nname = \"a\"\nunit = \"1\"\nmin = 0\nmax = 0.3\ntypical = 0.05\n";
        files.write("effect.toml", effect.as_bytes());
        let packed = files.path("packed.fmu");
        let line = ["pack".to_owned(), "-o".into(), packed.clone()];
        assert_eq!(complaint(files.folder.path(), &line), None);
        files.write("beam.fmu", &light(Path::new(&packed)));
        files
    }

    /// A file's place.
    pub fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The same as a text.
    pub fn path(&self, name: &str) -> String {
        self.at(name).to_str().unwrap().to_owned()
    }

    /// Writes a file and returns its path.
    pub fn write(&self, name: &str, bytes: &[u8]) -> String {
        std::fs::write(self.at(name), bytes).unwrap();
        self.path(name)
    }
}

/// The same FMU without debugging symbols and packed without compression: hundreds of runs unpack it.
fn light(fmu: &Path) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let library = folder.path().join("library");
    let mut archive = ZipArchive::new(std::fs::File::open(fmu).unwrap()).unwrap();
    let mut out = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let stored = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    for i in 0..archive.len() {
        let mut entry = archive.by_index(i).unwrap();
        let name = entry.name().unwrap().into_owned();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        if name.starts_with("binaries/") {
            std::fs::write(&library, &bytes).unwrap();
            let stripped = Command::new("strip").arg(&library).status();
            if stripped.is_ok_and(|s| s.success()) {
                bytes = std::fs::read(&library).unwrap();
            }
        }
        out.start_file(name, stored).unwrap();
        out.write_all(&bytes).unwrap();
    }
    out.finish().unwrap().into_inner()
}
