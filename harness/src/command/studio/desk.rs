//! What the server and the engine share: questions, work, and the board that the page shows.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::time::Duration;

use serde::{Deserialize, Serialize};
use tokio::sync::{oneshot, watch};

use super::ladder::Ladder;
use super::model::Draft;
use super::work::{Finding, Job};
use crate::error::Error;

/// Questions that may wait at once, of different pages.
const MOST_WAITING: usize = 16;

/// A draft to be predicted.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ask {
    /// The page that asks; its last question wins.
    pub client: String,
    /// The model.
    pub draft: Draft,
    /// The rung that it starts from.
    pub base: u64,
    /// The run whose curves are wanted.
    pub run: usize,
    /// Whether starts are found by least squares, and not estimated only.
    pub careful: bool,
    /// Whether it is the model on the page, and not one beside it.
    pub shown: bool,
}

/// What a question is answered with: JSON, or why not; `None` once a later question has taken its place.
pub type Reply = Option<Result<String, Error>>;

/// A question that waits.
pub struct Waiting {
    /// The question.
    pub ask: Ask,
    /// Set once a later question of the same page has come.
    pub superseded: Arc<AtomicBool>,
    /// Where the answer goes.
    pub reply: oneshot::Sender<Reply>,
}

/// Work in progress.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Progress {
    /// What it is.
    pub what: String,
    /// What is done now.
    pub words: String,
    /// Share of the whole that is done (1); `None` where nobody knows.
    pub share: Option<f64>,
    /// The same when the stage in progress ends.
    #[serde(skip)]
    pub stage_end: f64,
    /// The error after each iteration of a fit.
    pub errors: Vec<f64>,
    /// Where a fit stands.
    pub draft: Option<Draft>,
}

/// How the last work ended.
#[derive(Debug, Clone, Serialize)]
pub struct Outcome {
    /// Number, by which a page knows a new one.
    pub id: u64,
    /// What it was.
    pub what: String,
    /// What went wrong.
    pub error: Option<String>,
    /// What was found.
    pub finding: Option<Finding>,
}

/// The model on the page.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Shown {
    /// The page that turned it last.
    pub client: String,
    /// Number of the turn.
    pub turn: u64,
}

/// What the page shows besides curves.
#[derive(Default)]
pub struct Board {
    /// Campaign and controls as JSON, once a campaign is open.
    pub campaign: Option<Arc<str>>,
    /// Number of the opening, by which a page knows that it must read them again.
    pub opened: u64,
    /// What must be said of campaign or folder.
    pub trouble: Option<String>,
    /// Folder of the history and the files of the campaign that is open.
    pub home: PathBuf,
    /// The history.
    pub ladder: Option<Ladder>,
    /// Who turned the model last.
    pub shown: Shown,
    /// Work in progress.
    pub progress: Option<Progress>,
    /// How the last one ended.
    pub outcome: Option<Outcome>,
    outcomes: u64,
}

/// What the engine is to do.
pub enum Order {
    /// Work on the campaign that is open.
    Work(Job),
    /// Read the campaign anew.
    Reload,
    /// Open another one.
    Open(PathBuf),
}

/// The desk.
pub struct Desk {
    /// Folder of everything that is written.
    pub output: PathBuf,
    board: Mutex<Board>,
    changed: watch::Sender<u64>,
    asks: Mutex<VecDeque<Waiting>>,
    asked: Condvar,
    /// The question being answered: its page, and the mark that a later one sets.
    answering: Mutex<Option<(String, Arc<AtomicBool>)>>,
    orders: Mutex<VecDeque<Order>>,
    ordered: Condvar,
    /// Set to stop the work in progress.
    cancelled: AtomicBool,
    questions: AtomicU64,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|e| e.into_inner())
}

impl Desk {
    /// A desk for results in `output`.
    pub fn new(output: &Path) -> Desk {
        Desk {
            output: output.to_owned(),
            board: Mutex::default(),
            changed: watch::Sender::new(0),
            asks: Mutex::default(),
            asked: Condvar::new(),
            answering: Mutex::default(),
            orders: Mutex::default(),
            ordered: Condvar::new(),
            cancelled: AtomicBool::new(false),
            questions: AtomicU64::new(0),
        }
    }

    /// Changes the board and tells the pages.
    pub fn post<R>(&self, change: impl FnOnce(&mut Board) -> R) -> R {
        let result = change(&mut locked(&self.board));
        self.changed.send_modify(|version| *version += 1);
        result
    }

    /// Reads the board.
    pub fn read<R>(&self, read: impl FnOnce(&Board) -> R) -> R {
        read(&locked(&self.board))
    }

    /// A folder for files of the campaign that is open, and its path within the output folder.
    pub fn folder(&self, name: &str) -> (PathBuf, String) {
        let folder = self.read(|board| board.home.join(name));
        let inside = folder.strip_prefix(&self.output).unwrap_or(&folder);
        let parts = inside.components().map(|c| c.as_os_str().to_string_lossy());
        let inside = parts.collect::<Vec<_>>().join("/");
        (folder, inside)
    }

    /// Tells of changes of the board.
    pub fn watch(&self) -> watch::Receiver<u64> {
        self.changed.subscribe()
    }

    /// Puts a question; the last one of the same page wins.
    pub fn ask(&self, ask: Ask) -> oneshot::Receiver<Reply> {
        let (reply, answer) = oneshot::channel();
        let waiting = Waiting {
            superseded: Arc::default(),
            reply,
            ask,
        };
        self.questions.fetch_add(1, Ordering::Relaxed);
        if let Some((client, superseded)) = &*locked(&self.answering)
            && *client == waiting.ask.client
        {
            superseded.store(true, Ordering::Relaxed);
        }
        let mut asks = locked(&self.asks);
        let place = asks
            .iter()
            .position(|other| other.ask.client == waiting.ask.client);
        let old = match place {
            Some(i) => Some(std::mem::replace(&mut asks[i], waiting)),
            None => {
                asks.push_back(waiting);
                (asks.len() > MOST_WAITING)
                    .then(|| asks.pop_front())
                    .flatten()
            }
        };
        drop(asks);
        if let Some(old) = old {
            let _ = old.reply.send(None);
        }
        self.asked.notify_all();
        answer
    }

    /// The next question, within `wait`.
    pub fn next_ask(&self, wait: Duration) -> Option<Waiting> {
        let mut asks = locked(&self.asks);
        if asks.is_empty() {
            let waited = self.asked.wait_timeout(asks, wait);
            asks = waited.unwrap_or_else(|e| e.into_inner()).0;
        }
        let next = asks.pop_front()?;
        let mark = (next.ask.client.clone(), next.superseded.clone());
        *locked(&self.answering) = Some(mark);
        Some(next)
    }

    /// Gives an order.
    ///
    /// # Errors
    /// [`Error::StudioBusy`] while work is in progress.
    pub fn order(&self, order: Order) -> Result<(), Error> {
        let mut orders = locked(&self.orders);
        let running = self.read(|board| board.progress.as_ref().map(|p| p.what.clone()));
        let waiting = (!orders.is_empty()).then(|| "what was asked for before".to_owned());
        if let Some(running) = running.or(waiting) {
            return Err(Error::StudioBusy { running });
        }
        self.cancelled.store(false, Ordering::Relaxed);
        if let Order::Work(job) = &order {
            let what = job.name().to_owned();
            self.post(|board| {
                board.progress = Some(Progress {
                    what,
                    ..Progress::default()
                });
            });
        }
        orders.push_back(order);
        drop(orders);
        self.ordered.notify_all();
        Ok(())
    }

    /// The next order, within `wait`.
    pub fn next_order(&self, wait: Duration) -> Option<Order> {
        let mut orders = locked(&self.orders);
        if orders.is_empty() {
            let waited = self.ordered.wait_timeout(orders, wait);
            orders = waited.unwrap_or_else(|e| e.into_inner()).0;
        }
        orders.pop_front()
    }

    /// Stops the work in progress at its next pause.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether the work in progress is to stop.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Says how the work in progress ended.
    pub fn end(&self, result: Result<Finding, Error>) {
        self.post(|board| {
            let Some(progress) = board.progress.take() else {
                return;
            };
            board.outcomes += 1;
            let (finding, error) = match result {
                Ok(finding) => (Some(finding), None),
                Err(error) => (None, Some(error.to_string())),
            };
            board.outcome = Some(Outcome {
                id: board.outcomes,
                what: progress.what,
                error,
                finding,
            });
        });
    }

    /// Changes the work in progress.
    pub fn progress(&self, change: impl FnOnce(&mut Progress)) {
        self.post(|board| {
            if let Some(progress) = &mut board.progress {
                change(progress);
            }
        });
    }

    /// Changes the ladder and writes it; a folder that can't be written is told on the page, which goes on.
    ///
    /// # Errors
    /// What the change fails with; no campaign open.
    pub fn change_ladder<R>(
        &self,
        change: impl FnOnce(&mut Ladder) -> Result<R, Error>,
    ) -> Result<R, Error> {
        self.post(|board| {
            let Some(ladder) = &mut board.ladder else {
                return Err(closed(board.trouble.as_deref()));
            };
            let result = change(ladder)?;
            let written = ladder.write(&board.home);
            board.trouble = written.err().map(|error| format!("{NOT_SAVED}: {error}"));
            Ok(result)
        })
    }
}

/// What the page says where the ladder can't be written.
const NOT_SAVED: &str = "What is on the page is not saved";

/// The error of what needs an open campaign.
pub fn closed(trouble: Option<&str>) -> Error {
    Error::StudioClosed {
        why: trouble.unwrap_or("it is being read").to_owned(),
    }
}
