//! `stickslip studio`: the campaign, the model's effects and the error on one page, live.
//!
//! The page is served to this computer alone (`guard`). What it asks goes over the `desk` to the `engine`, which predicts
//! (`preview`, `curves`) and works (`work`); every try is a rung of the `ladder`, which is kept in the output folder.

mod controls;
mod curves;
mod desk;
mod dropped;
mod engine;
mod export;
mod guard;
mod ladder;
mod model;
mod preview;
mod server;
mod work;

use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::Args;

use super::given_campaign::{self, Forced};
use crate::error::Error;
use crate::output::{make_folder, print_line, tell};

/// Options of `studio`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder with campaign.toml and the CSV files, or the path of campaign.toml [default: the demonstration]
    #[arg(value_name = "CAMPAIGN")]
    campaign: Option<PathBuf>,
    /// FMU to work with [default: this repository's StickSlipBeam, packed on the spot]
    #[arg(long, value_name = "FILE")]
    fmu: Option<PathBuf>,
    /// Folder in which the tries are kept and files are written; the same folder goes on from there
    #[arg(short, long, value_name = "DIR", default_value = "studio")]
    output: PathBuf,
    /// Port on 127.0.0.1; 0 takes any that is free
    #[arg(long, value_name = "PORT", default_value_t = 0)]
    port: u16,
    /// Print the address and leave the browser alone
    #[arg(long)]
    no_open: bool,
    /// End by itself after so many seconds and open no browser, for scripts
    #[arg(long, value_name = "S")]
    end_after: Option<f64>,
    #[command(flatten)]
    forced: Forced,
}

/// Longest time after which the server may end by itself, s: a year.
const LONGEST: f64 = 3.2e7;

/// Runs the command until Ctrl-C.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let end_after = arguments.end_after.map(seconds).transpose()?;
    let given = match &arguments.campaign {
        Some(path) => path.clone(),
        None => super::demo::campaign(),
    };
    let campaign = given_campaign::load(&given, arguments.forced)?;
    make_folder(&arguments.output)?;
    let fmu = super::open_fmu(arguments.fmu.as_deref())?;
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()
        .map_err(|e| Error::Internal {
            problem: format!("no threads to serve with: {e}"),
        })?;
    let refused = |source| Error::Port {
        port: arguments.port,
        source,
    };
    let address = SocketAddr::from((Ipv4Addr::LOCALHOST, arguments.port));
    let listener = runtime
        .block_on(tokio::net::TcpListener::bind(address))
        .map_err(refused)?;
    let port = listener.local_addr().map_err(refused)?.port();
    let guard = guard::Guard::new(port)?;
    let page = guard.address();
    let desk = Arc::new(desk::Desk::new(&arguments.output));
    let closing = AtomicBool::new(false);
    print_line(format_args!("Studio: {page} (Ctrl-C ends it)"))?;
    if !arguments.no_open
        && end_after.is_none()
        && let Err(error) = open::that_detached(&page)
    {
        tell(format_args!(
            "No browser could be opened ({error}); open the address above in one."
        ));
    }
    let (stop, stopped) = tokio::sync::watch::channel(());
    // A second registration (several commands in one program) is refused and not needed.
    let _ = ctrlc::set_handler(move || {
        let _ = stop.send(());
    });
    let until = async move {
        let mut stopped = stopped;
        let pressed = async {
            // Without a handler there is no one to send.
            if stopped.changed().await.is_err() {
                std::future::pending::<()>().await;
            }
        };
        match end_after {
            Some(time) => {
                let _ = tokio::time::timeout(time, pressed).await;
            }
            None => pressed.await,
        }
    };
    std::thread::scope(|scope| {
        scope.spawn(|| engine::run(&desk, &fmu, campaign, given, &closing));
        let app = server::router(desk.clone(), guard);
        let served = runtime.block_on(async {
            let serving = std::future::IntoFuture::into_future(axum::serve(listener, app));
            tokio::select! {
                served = serving => served.map_err(refused),
                () = until => Ok(()),
            }
        });
        desk.cancel();
        closing.store(true, Ordering::Relaxed);
        served
    })
}

/// A time to end after.
fn seconds(value: f64) -> Result<Duration, Error> {
    if (0.0..=LONGEST).contains(&value) {
        return Ok(Duration::from_secs_f64(value));
    }
    Err(Error::Option {
        option: "--end-after",
        value: value.to_string(),
        rule: format!("is no time to end after; give 0 to {LONGEST:e} s, or leave it out"),
    })
}
