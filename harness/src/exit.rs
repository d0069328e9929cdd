//! How a command ends: the one list of exit codes, for programs, `--help` and the README.

/// The end of a command, as scripts see it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// All went well.
    Done = 0,
    /// A gate of `--fail-above` is not met.
    GateFailed = 1,
    /// Something given can't be used.
    BadInput = 2,
    /// The FMU gave up.
    FmuFailed = 3,
    /// A file, a folder or standard output can't be written.
    NotWritten = 4,
    /// The user stopped it.
    Stopped = 5,
    /// The reader of standard output (`head`) has gone: 128 and the number of SIGPIPE, as shells report it of other tools.
    ReaderGone = 141,
}

impl Exit {
    /// All of them, in ascending order.
    pub const ALL: [Exit; 7] = [
        Exit::Done,
        Exit::GateFailed,
        Exit::BadInput,
        Exit::FmuFailed,
        Exit::NotWritten,
        Exit::Stopped,
        Exit::ReaderGone,
    ];

    /// The process's exit code.
    pub fn code(self) -> u8 {
        self as u8
    }

    /// In words.
    pub fn meaning(self) -> &'static str {
        match self {
            Exit::Done => "done",
            Exit::GateFailed => "a gate failed (--fail-above)",
            Exit::BadInput => "bad input: option, campaign, CSV or FMU file",
            Exit::FmuFailed => "the FMU failed while running",
            Exit::NotWritten => "a result could not be written",
            Exit::Stopped => "stopped before the end; the same command goes on",
            Exit::ReaderGone => "the reader of standard output has closed it, as `head` does",
        }
    }

    /// The list, as `--help` shows it.
    pub fn list() -> String {
        let mut text = String::from("Exit codes:");
        for exit in Exit::ALL {
            text += &format!("\n  {:<3}  {}", exit.code(), exit.meaning());
        }
        text
    }
}
