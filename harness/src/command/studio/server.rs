//! The server: the page's files, the board, questions and orders.

use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::body::Body;
use axum::extract::{DefaultBodyLimit, Json, Path as UrlPath, Query, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::middleware::from_fn_with_state;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::desk::{Ask, Board, Desk, Order, Outcome, Progress, Shown, closed};
use super::dropped;
use super::guard::{Guard, check};
use super::ladder::{Difference, Origin, differences};
use super::model::Draft;
use super::preview::Errors;
use super::work::Job;
use crate::error::Error;
use crate::report::plotly_script;

/// Largest request in bytes; a draft has some kilobytes, with values along the belt some hundred.
const LARGEST_REQUEST: usize = 4 << 20;
/// Largest file dropped on the page.
pub const LARGEST_FILE: usize = 256 << 20;
/// How long a page waits for a change of the board before it asks again.
const PATIENCE: Duration = Duration::from_secs(15);

/// An answer that is an error: its text for the page.
pub struct Refused(pub Error);

impl From<Error> for Refused {
    fn from(error: Error) -> Self {
        Refused(error)
    }
}

impl IntoResponse for Refused {
    fn into_response(self) -> Response {
        let status = match &self.0 {
            Error::StudioBusy { .. } | Error::StudioClosed { .. } => StatusCode::CONFLICT,
            Error::Internal { .. } | Error::Write { .. } => StatusCode::INTERNAL_SERVER_ERROR,
            _ => StatusCode::UNPROCESSABLE_ENTITY,
        };
        (status, Json(json!({ "error": self.0.to_string() }))).into_response()
    }
}

type Answered<T> = Result<T, Refused>;
type At = State<Arc<Desk>>;

/// Everything that is served under the token.
pub fn router(desk: Arc<Desk>, guard: Guard) -> Router {
    let at = |path: &str| format!("/{}/{path}", guard.token());
    let mut router = Router::new()
        .route(
            &at(""),
            get(|| page_file(include_str!("page/studio.html"), HTML)),
        )
        .route(
            &at("studio.css"),
            get(|| page_file(include_str!("page/studio.css"), CSS)),
        )
        .route(&at("plotly.js"), get(|| page_file(plotly_script(), SCRIPT)));
    for (name, text) in SCRIPTS {
        router = router.route(&at(name), get(move || page_file(text, SCRIPT)));
    }
    router
        .route(&at("api/campaign"), get(campaign))
        .route(&at("api/board"), get(board))
        .route(&at("api/predict"), post(predict))
        .route(&at("api/work"), post(work))
        .route(&at("api/cancel"), post(cancel))
        .route(&at("api/forget"), post(forget))
        .route(&at("api/differences"), get(compare))
        .route(&at("api/reload"), post(reload))
        .route(&at("api/templates"), get(dropped::templates))
        .route(
            &at("api/file"),
            post(dropped::receive).layer(DefaultBodyLimit::max(LARGEST_FILE)),
        )
        .route(&at("api/import"), post(dropped::import))
        .route(&at("files/{*path}"), get(written))
        .fallback(|| async { (StatusCode::NOT_FOUND, "not found") })
        .with_state(desk)
        .layer(DefaultBodyLimit::max(LARGEST_REQUEST))
        .layer(from_fn_with_state(guard, check))
}

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
/// The page's own scripts.
const SCRIPTS: [(&str, &str); 6] = [
    ("main.js", include_str!("page/main.js")),
    ("controls.js", include_str!("page/controls.js")),
    ("plots.js", include_str!("page/plots.js")),
    ("history.js", include_str!("page/history.js")),
    ("drop.js", include_str!("page/drop.js")),
    ("server.js", include_str!("page/server.js")),
];

async fn page_file(text: &'static str, kind: &'static str) -> impl IntoResponse {
    ([(header::CONTENT_TYPE, kind)], text)
}

fn json_text(text: String) -> Response {
    ([(header::CONTENT_TYPE, "application/json")], text).into_response()
}

async fn campaign(State(desk): At) -> Answered<Response> {
    let found = desk.read(|board| match &board.campaign {
        Some(json) => Ok(json.to_string()),
        None => Err(closed(board.trouble.as_deref())),
    })?;
    Ok(json_text(found))
}

#[derive(Deserialize)]
struct Since {
    since: Option<u64>,
    client: String,
}

/// A rung as the page shows it.
#[derive(Serialize)]
struct RungView<'a> {
    id: u64,
    name: &'a str,
    origin: Origin,
    before: Option<u64>,
    draft: &'a Draft,
    errors: &'a Errors,
    forecast: Option<f64>,
}

#[derive(Serialize)]
struct BoardView<'a> {
    version: u64,
    opened: u64,
    is_open: bool,
    trouble: &'a Option<String>,
    rungs: Vec<RungView<'a>>,
    draft: Option<&'a Draft>,
    base: Option<u64>,
    shown: &'a Shown,
    progress: &'a Option<Progress>,
    outcome: &'a Option<Outcome>,
}

fn view(board: &Board, version: u64) -> String {
    let ladder = board.ladder.as_ref();
    let rungs = ladder.iter().flat_map(|ladder| &ladder.rungs);
    let view = BoardView {
        version,
        opened: board.opened,
        is_open: board.campaign.is_some(),
        trouble: &board.trouble,
        rungs: rungs
            .map(|rung| RungView {
                id: rung.id,
                name: &rung.name,
                origin: rung.origin,
                before: rung.before,
                draft: &rung.draft,
                errors: &rung.errors,
                forecast: rung.forecast,
            })
            .collect(),
        draft: ladder.map(|ladder| &ladder.draft),
        base: ladder.map(|ladder| ladder.base),
        shown: &board.shown,
        progress: &board.progress,
        outcome: &board.outcome,
    };
    serde_json::to_string(&view).expect("numbers and texts have a JSON form")
}

/// The board, once it has changed from what the page knows but for the page's own turns of sliders.
async fn board(State(desk): At, Query(of): Query<Since>) -> Response {
    let mut watch = desk.watch();
    let known = of.since.unwrap_or(u64::MAX);
    let begun = desk.read(|board| board.shown.turn);
    let own_turns = |version: u64| {
        desk.read(|board| {
            let turns = board.shown.turn - begun;
            board.shown.client == of.client && version == known.saturating_add(turns)
        })
    };
    let changed = watch.wait_for(|version| *version != known && !own_turns(*version));
    let _ = tokio::time::timeout(PATIENCE, changed).await;
    let version = *desk.watch().borrow();
    json_text(desk.read(|board| view(board, version)))
}

async fn predict(State(desk): At, Json(ask): Json<Ask>) -> Answered<Response> {
    match desk.ask(ask).await {
        Ok(Some(answer)) => Ok(json_text(answer?)),
        // A later question of this page is being answered instead.
        Ok(None) | Err(_) => Ok(json_text("null".into())),
    }
}

async fn work(State(desk): At, Json(job): Json<Job>) -> Answered<Json<Value>> {
    desk.order(Order::Work(job))?;
    Ok(Json(json!({})))
}

async fn cancel(State(desk): At, Json(_): Json<Value>) -> Json<Value> {
    desk.cancel();
    Json(json!({}))
}

async fn reload(State(desk): At, Json(_): Json<Value>) -> Answered<Json<Value>> {
    desk.order(Order::Reload)?;
    Ok(Json(json!({})))
}

#[derive(Deserialize)]
struct OfRung {
    rung: u64,
}

async fn forget(State(desk): At, Json(of): Json<OfRung>) -> Answered<Json<Value>> {
    desk.change_ladder(|ladder| ladder.forget(of.rung))?;
    Ok(Json(json!({})))
}

#[derive(Deserialize)]
struct Two {
    first: u64,
    second: u64,
}

async fn compare(State(desk): At, Query(two): Query<Two>) -> Answered<Json<Vec<Difference>>> {
    let found = desk.read(|board| {
        let ladder = board.ladder.as_ref();
        let ladder = ladder.ok_or_else(|| closed(board.trouble.as_deref()))?;
        let (a, b) = (ladder.rung(two.first)?, ladder.rung(two.second)?);
        Ok::<_, Error>(differences(&a.draft, &b.draft))
    })?;
    Ok(Json(found))
}

/// A file of the output folder, and of no other.
async fn written(State(desk): At, UrlPath(path): UrlPath<String>) -> Response {
    let missing = || (StatusCode::NOT_FOUND, "not found").into_response();
    let Some(path) = inside(&desk.output, &path) else {
        return missing();
    };
    let Ok(bytes) = std::fs::read(&path) else {
        return missing();
    };
    let extension = path.extension().and_then(|e| e.to_str());
    let (kind, policy) = match extension {
        // A report draws with scripts of its own, and reaches for nothing.
        Some("html") => (
            "text/html; charset=utf-8",
            "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; sandbox allow-scripts allow-downloads",
        ),
        Some("toml" | "txt" | "ssv") => {
            ("text/plain; charset=utf-8", "default-src 'none'; sandbox")
        }
        Some("json") => ("application/json", "default-src 'none'; sandbox"),
        _ => ("application/octet-stream", "default-src 'none'; sandbox"),
    };
    let mut response = ([(header::CONTENT_TYPE, kind)], Body::from(bytes)).into_response();
    let policy = HeaderValue::from_static(policy);
    response
        .headers_mut()
        .insert(header::CONTENT_SECURITY_POLICY, policy);
    response
}

/// A path within a folder, all links followed; `None` for one that leads out, or to nothing.
pub fn inside(folder: &Path, path: &str) -> Option<PathBuf> {
    let relative = Path::new(path);
    let is_plain = |c: Component| matches!(c, Component::Normal(_));
    if !relative.components().all(is_plain) {
        return None;
    }
    let whole = folder.join(relative).canonicalize().ok()?;
    let within = whole.starts_with(folder.canonicalize().ok()?);
    (within && whole.is_file()).then_some(whole)
}
