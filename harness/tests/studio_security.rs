//! Who the studio lets in, and what it gives away: by requests with a wrong token, Host, Origin, path and size. What it
//! says of bad input, of a full disk and where there is no browser, while it lives on. And what it draws of each quantity that a sensor may read.

mod rig;

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

/// A studio of the demonstration.
struct Studio {
    child: Child,
    port: u16,
    token: String,
    folder: tempfile::TempDir,
}

fn demo() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-data/demo")
}

impl Studio {
    fn of(campaign: &Path) -> Studio {
        let mut command = Command::new(env!("CARGO_BIN_EXE_stickslip"));
        command.args(["studio", "--no-open", "-o", "out"]);
        command.stderr(Stdio::null());
        Self::started(command.arg(campaign))
    }

    /// The studio that a command starts, in a folder of its own.
    fn started(command: &mut Command) -> Studio {
        let folder = tempfile::tempdir().unwrap();
        let mut child = command
            .current_dir(folder.path())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        let mut out = BufReader::new(child.stdout.take().unwrap());
        out.read_line(&mut line).unwrap();
        let address = line.split_whitespace().nth(1).expect("an address");
        let rest = address.strip_prefix("http://127.0.0.1:").expect("loopback");
        let (port, token) = rest.split_once('/').unwrap();
        let studio = Studio {
            child,
            port: port.parse().unwrap(),
            token: token.trim_end_matches('/').to_owned(),
            folder,
        };
        studio.wait_until("it is open", |board| board["is_open"] == true);
        studio
    }

    /// Status and body of a request as it is given.
    fn raw(&self, request: &[u8]) -> (u16, String) {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream
            .set_read_timeout(Some(Duration::from_secs(60)))
            .unwrap();
        // A server that refuses early may close before all is written.
        let _ = stream.write_all(request);
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        let answer = String::from_utf8_lossy(&answer).into_owned();
        let status = answer.split(' ').nth(1).and_then(|s| s.parse().ok());
        let body = answer.split_once("\r\n\r\n").map_or("", |(_, body)| body);
        (status.unwrap_or(0), body.to_owned())
    }

    fn get(&self, path: &str, headers: &str) -> (u16, String) {
        let request = format!("GET {path} HTTP/1.1\r\n{headers}Connection: close\r\n\r\n");
        self.raw(request.as_bytes())
    }

    fn host(&self) -> String {
        format!("Host: 127.0.0.1:{}\r\n", self.port)
    }

    fn own(&self, path: &str) -> (u16, String) {
        self.get(&format!("/{}/{path}", self.token), &self.host())
    }

    fn post(&self, path: &str, body: &str) -> (u16, String) {
        let request = format!(
            "POST /{}/{path} HTTP/1.1\r\n{}Content-Type: application/json\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{body}",
            self.token,
            self.host(),
            body.len()
        );
        self.raw(request.as_bytes())
    }

    fn board(&self) -> Value {
        let (status, body) = self.own("api/board?client=test");
        assert_eq!(status, 200, "{body}");
        serde_json::from_str(&body).unwrap()
    }

    /// Waits for a board of which something holds.
    fn wait_until(&self, what: &str, holds: impl Fn(&Value) -> bool) -> Value {
        let begun = Instant::now();
        loop {
            let board = self.board();
            if holds(&board) {
                return board;
            }
            let waited = begun.elapsed();
            assert!(
                waited < Duration::from_secs(120),
                "not within {waited:?}: {what}: {board}"
            );
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    fn predict(&self, draft: &Value, careful: bool) -> (u16, Value) {
        let ask = json!({
            "client": "test", "draft": draft, "base": 0, "run": 0, "careful": careful, "shown": true
        });
        let (status, body) = self.post("api/predict", &ask.to_string());
        (
            status,
            serde_json::from_str(&body).unwrap_or(Value::String(body)),
        )
    }
}

impl Drop for Studio {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn nothing() -> Value {
    json!({ "effects": {}, "shared": {}, "own": {} })
}

#[test]
fn only_the_page_at_the_address_is_let_in() {
    let studio = Studio::of(&demo());
    let (port, token) = (studio.port, &studio.token);
    let page = format!("/{token}/");
    let (status, body) = studio.get(&page, &studio.host());
    assert_eq!(status, 200);
    assert!(body.contains("stickslip studio"));
    assert!(
        token.len() == 32 && token.chars().all(|c| c.is_ascii_hexdigit()),
        "{token}"
    );

    // The token.
    let other = "0".repeat(32);
    for path in [
        "/",
        "/api/board?client=a",
        &format!("/{other}/"),
        &format!("/{}/", &token[..31]),
        &format!("/{token}0/"),
        &format!("/x/{token}/"),
    ] {
        let (status, body) = studio.get(path, &studio.host());
        assert_eq!(status, 404, "{path}");
        assert!(!body.contains(token.as_str()), "{path}: {body}");
    }
    // The host: a name that leads here, another port, none.
    for host in [
        "evil.example",
        "127.0.0.1",
        "127.0.0.1:1",
        "localhost.evil.example",
        "0.0.0.0",
    ] {
        let (status, _) = studio.get(&page, &format!("Host: {host}\r\n"));
        assert_eq!(status, 403, "{host}");
    }
    assert_ne!(studio.get(&page, "").0, 200);
    assert_eq!(
        studio.get(&page, &format!("Host: localhost:{port}\r\n")).0,
        200
    );
    // The origin.
    let host = studio.host();
    for origin in [
        "http://evil.example",
        "null",
        "https://127.0.0.1",
        &format!("http://127.0.0.1:{}", port - 1),
        &format!("http://127.0.0.1:{port}.evil.example"),
    ] {
        let (status, _) = studio.get(&page, &format!("{host}Origin: {origin}\r\n"));
        assert_eq!(status, 403, "{origin}");
    }
    let own = format!("{host}Origin: http://127.0.0.1:{port}\r\n");
    assert_eq!(studio.get(&page, &own).0, 200);
    let (status, _) = studio.get(&page, &format!("{host}Sec-Fetch-Site: cross-site\r\n"));
    assert_eq!(status, 403);
    // Orders are JSON, which a form of another page can't send.
    let body = "{\"kind\":\"score\"}";
    let form = format!(
        "POST /{token}/api/work HTTP/1.1\r\n{host}Content-Type: text/plain\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{body}",
        body.len()
    );
    assert_eq!(studio.raw(form.as_bytes()).0, 415);
}

#[test]
fn no_file_but_those_written_is_given_away_and_requests_are_bounded() {
    let studio = Studio::of(&demo());
    let out = studio.folder.path().join("out");
    std::fs::write(studio.folder.path().join("secret.txt"), "secret").unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink(
        studio.folder.path().join("secret.txt"),
        out.join("link.txt"),
    )
    .unwrap();
    std::fs::write(out.join("mine.txt"), "mine").unwrap();
    assert_eq!(studio.own("files/mine.txt"), (200, "mine".into()));
    for path in [
        "files/../secret.txt",
        "files/%2e%2e/secret.txt",
        "files/..%2fsecret.txt",
        "files/.//../secret.txt",
        "files//etc/passwd",
        "files/%2fetc%2fpasswd",
        "files/link.txt",
        "files/",
        "files/none.txt",
        "files/..\\secret.txt",
    ] {
        let (status, body) = studio.own(path);
        assert!(status == 404 || status == 400, "{path}: {status}");
        assert!(
            !body.contains("secret") && !body.contains("root:"),
            "{path}: {body}"
        );
    }
    let large = "x".repeat(5 << 20);
    let (status, _) = studio.post("api/predict", &large);
    assert_eq!(status, 413);
    // A length that is announced is refused before it is sent.
    let announced = format!(
        "POST /{}/api/file?name=a.csv HTTP/1.1\r\n{}Content-Length: 999999999999\r\nConnection: close\r\n\r\n",
        studio.token,
        studio.host()
    );
    assert_eq!(studio.raw(announced.as_bytes()).0, 413);
    assert_eq!(studio.own("").0, 200);
}

#[test]
fn what_cannot_be_is_said_and_the_server_lives() {
    let studio = Studio::of(&demo());
    let with = |shared: Value| json!({ "effects": {}, "shared": shared, "own": {} });
    for (draft, words) in [
        (with(json!({ "friction.mu_0": 1e9 })), "friction.mu_0"),
        (with(json!({ "friction.mu_0": -1.0 })), "outside"),
        (
            json!({ "effects": { "no_such_effect": {} }, "shared": {}, "own": {} }),
            "no_such_effect",
        ),
        (
            json!({ "effects": { "third_mode": { "nothing": 1.0 } }, "shared": {}, "own": {} }),
            "nothing",
        ),
        (json!({ "surprise": 1 }), "surprise"),
    ] {
        let (status, answer) = studio.predict(&draft, false);
        assert_eq!(status, 422, "{answer}");
        assert!(answer.to_string().contains(words), "{answer}");
    }
    let far = json!({ "client": "a", "draft": nothing(), "base": 99, "run": 0, "careful": false, "shown": true });
    assert_eq!(studio.post("api/predict", &far.to_string()).0, 422);
    let run = json!({ "client": "a", "draft": nothing(), "base": 0, "run": 99, "careful": false, "shown": true });
    assert_eq!(studio.post("api/predict", &run.to_string()).0, 422);
    for (path, body) in [
        ("api/work", "{\"kind\":\"unknown\"}"),
        ("api/work", "{"),
        ("api/forget", "{\"rung\":0}"),
        (
            "api/import",
            "{\"files\":[\"../../etc/passwd\"],\"name\":\"x\",\"belt_velocity\":[\"1\"],\"normal_force\":[\"1\"]}",
        ),
        (
            "api/import",
            "{\"files\":[],\"name\":\"--help\",\"belt_velocity\":[],\"normal_force\":[]}",
        ),
    ] {
        let (status, answer) = studio.post(path, body);
        assert!(
            (400..500).contains(&status),
            "{path} {body}: {status} {answer}"
        );
    }
    let (status, answer) = studio.predict(&nothing(), false);
    assert_eq!(status, 200, "{answer}");
}

#[test]
fn a_slider_moves_the_error_a_rung_is_kept_and_the_next_studio_goes_on() {
    let studio = Studio::of(&demo());
    let (_, plain) = studio.predict(&nothing(), true);
    let on = json!({
        "effects": { "belt_periodic_friction": {} },
        "shared": { "belt_periodic_friction.amplitude": 0.08, "belt_periodic_friction.wavelength": 0.022 },
        "own": {}
    });
    let (status, with) = studio.predict(&on, true);
    assert_eq!(status, 200, "{with}");
    let error = |answer: &Value| answer["errors"]["fitted"].as_f64().unwrap();
    assert!(
        error(&plain) > 0.05 && (error(&plain) - error(&with)).abs() > 1e-3,
        "{} {}",
        error(&plain),
        error(&with)
    );
    assert!(with["curves"]["reading"].as_array().unwrap().len() > 1000);
    assert!(
        with["curves"]["displacement"]
            .as_array()
            .unwrap()
            .is_empty()
    );
    let keep = json!({ "kind": "keep", "draft": on, "base": 0, "name": "mine" });
    assert_eq!(studio.post("api/work", &keep.to_string()).0, 200);
    let board = studio.wait_until("the rung", |board| {
        board["rungs"].as_array().unwrap().len() == 2
    });
    assert!(board["rungs"][1]["forecast"].as_f64().unwrap() > 0.0);
    let kept = board["rungs"][1]["errors"]["fitted"].as_f64().unwrap();
    assert!(
        (kept - error(&with)).abs() < 1e-9,
        "a rung has the error that the page showed"
    );
    // What was kept is there again for a new server in the same folder.
    let folder = studio.folder.path().join("out/studio.json");
    let text = std::fs::read_to_string(folder).unwrap();
    let file: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(file["rungs"][1]["name"], "mine");
    assert_eq!(file["draft"], on);
}

#[test]
fn a_campaign_that_becomes_invalid_leaves_the_page_with_what_it_has() {
    let copy = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(demo()).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, copy.path().join(path.file_name().unwrap())).unwrap();
    }
    let studio = Studio::of(copy.path());
    std::fs::write(
        copy.path().join("run01.csv"),
        "time_s,tip_displacement_m\n0,nonsense\n",
    )
    .unwrap();
    let changed = |board: &Value| {
        board["trouble"]
            .as_str()
            .is_some_and(|t| t.contains("changed"))
    };
    studio.wait_until("it is told that files have changed", changed);
    assert_eq!(studio.post("api/reload", "{}").0, 200);
    let told = |board: &Value| {
        board["trouble"]
            .as_str()
            .is_some_and(|t| t.contains("run01.csv"))
    };
    studio.wait_until("it is told why", told);
    let (status, _) = studio.predict(&nothing(), false);
    assert_eq!(status, 200);
}

#[test]
fn a_port_in_use_is_said_before_any_work() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port();
    let folder = tempfile::tempdir().unwrap();
    let ended = Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .args(["studio", "--no-open", "--port", &port.to_string()])
        .arg(demo())
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert_eq!(ended.status.code(), Some(2));
    let said = String::from_utf8_lossy(&ended.stderr);
    assert!(
        said.contains(&port.to_string()) && said.contains("--port"),
        "{said}"
    );
}

#[test]
fn without_a_browser_the_address_is_told_and_the_page_served() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stickslip"));
    let nothing_installed = tempfile::tempdir().unwrap();
    command
        .args(["studio", "-o", "out"])
        .arg(demo())
        .env_clear()
        .env("PATH", nothing_installed.path())
        .stderr(Stdio::piped());
    let mut studio = Studio::started(&mut command);
    let (status, page) = studio.own("");
    assert_eq!(status, 200, "{page}");
    studio.child.kill().unwrap();
    let mut said = String::new();
    let mut errors = studio.child.stderr.take().unwrap();
    errors.read_to_string(&mut said).unwrap();
    assert!(
        said.contains("No browser could be opened") && said.contains("open the address above"),
        "{said}"
    );
}

#[cfg(target_os = "linux")]
#[test]
fn what_can_not_be_written_is_said_and_the_server_lives() {
    let mut command = Command::new("sh");
    // A write beyond the limit below fails as on a full disk, and does not end the process.
    command
        .args(["-c", "trap '' XFSZ; exec \"$0\" \"$@\""])
        .arg(env!("CARGO_BIN_EXE_stickslip"))
        .args(["studio", "--no-open", "-o", "out"])
        .arg(demo())
        .stderr(Stdio::null());
    let studio = Studio::started(&mut command);
    let limited = Command::new("prlimit")
        .args(["--pid", &studio.child.id().to_string(), "--fsize=64"])
        .status()
        .unwrap();
    assert!(limited.success());
    let keep = json!({ "kind": "keep", "draft": nothing(), "base": 0, "name": "mine" });
    assert_eq!(studio.post("api/work", &keep.to_string()).0, 200);
    let board = studio.wait_until("the trouble", |board| board["trouble"].is_string());
    let trouble = board["trouble"].as_str().unwrap();
    assert!(trouble.contains("studio.json"), "{trouble}");
    assert_eq!(board["rungs"].as_array().unwrap().len(), 2, "{board}");
    // What was written before is there in full.
    let written = std::fs::read_to_string(studio.folder.path().join("out/studio.json"));
    if let Ok(text) = written {
        let _: Value = serde_json::from_str(&text).unwrap();
    }
    let (status, answer) = studio.predict(&nothing(), false);
    assert_eq!(status, 200, "{answer}");
}

/// Root mean square difference of two series where both are known, over the standard deviation of the second.
fn difference(series: &Value, truth: &[f64]) -> f64 {
    let series = series.as_array().unwrap();
    assert_eq!(series.len(), truth.len());
    let known = series.iter().zip(truth);
    let known: Vec<(f64, f64)> = known.filter_map(|(s, t)| Some((s.as_f64()?, *t))).collect();
    assert!(2 * known.len() > truth.len(), "{} known", known.len());
    let square: f64 = known.iter().map(|(s, t)| (s - t).powi(2)).sum();
    (square / known.len() as f64).sqrt() / rig::std(truth)
}

// Source: independent simulation (rig/), in which nothing is missing.
#[test]
fn val_the_page_has_the_whole_motion_of_what_a_vibrometer_or_an_accelerometer_reads() {
    let motions = rig::campaign::motions(0.4);
    type Signal = fn(&rig::Record) -> &Vec<f64>;
    let cases: [(&str, &str, f64, Signal); 2] = [
        ("velocity", "m/s", 1e-4, |r| &r.velocity),
        ("acceleration", "m/s^2", 0.2, |r| &r.acceleration),
    ];
    for (quantity, unit, noise, signal) in cases {
        let folder = tempfile::tempdir().unwrap();
        let runs = rig::campaign::disturbed(&motions, signal, 0.0, noise);
        rig::campaign::write(folder.path(), &format!("{quantity}_column"), "s", &runs);
        let studio = Studio::of(folder.path());
        let (status, body) = studio.own("api/campaign");
        assert_eq!(status, 200, "{body}");
        let campaign: Value = serde_json::from_str(&body).unwrap();
        assert_eq!(
            campaign["quantity"],
            json!({ "name": quantity, "unit": unit })
        );
        let (status, answer) = studio.predict(&nothing(), true);
        assert_eq!(status, 200, "{answer}");
        let (measured, curves) = (&campaign["runs"][0]["measured"], &answer["curves"]);
        let truth = &motions[0];
        let displacement = &truth.displacement;
        for (of, series, truth) in [
            ("measured", &measured["reading"], signal(truth)),
            (
                "measured displacement",
                &measured["displacement"],
                displacement,
            ),
            ("predicted", &curves["reading"], signal(truth)),
            (
                "predicted displacement",
                &curves["displacement"],
                displacement,
            ),
            ("predicted velocity", &curves["velocity"], &truth.velocity),
        ] {
            let off = difference(series, truth);
            assert!(off < 0.05, "{quantity}, {of}: {off:.4} of the spread off");
        }
    }
}
