//! Exit codes and the last messages.

use std::fmt::Display;
use std::io::{self, Write};
use std::process::ExitCode;

use crate::output::OutputError;
use crate::scene::LoadError;
use crate::text::shown::escaped;

/// How the program ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Done.
    Ok = 0,
    /// Input or output failed.
    Files = 1,
    /// The command line is wrong.
    Usage = 2,
    /// The scene is wrong, or a stage of it cannot begin.
    Scene = 3,
    /// An increment could not be solved.
    Solver = 4,
    /// Ctrl-C, SIGTERM or SIGHUP.
    Interrupted = 130,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// Why a command failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// Exit code.
    pub exit: Exit,
    /// Message.
    pub message: String,
}

impl Failure {
    /// A failure with this exit code and message.
    pub fn new(exit: Exit, message: impl Display) -> Self {
        Self { exit, message: message.to_string() }
    }
}

impl From<LoadError> for Failure {
    fn from(error: LoadError) -> Self {
        let exit = match error {
            LoadError::Read { .. } => Exit::Files,
            LoadError::Set(_) => Exit::Usage,
            LoadError::Scene(_) => Exit::Scene,
        };
        Self::new(exit, error)
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        Self::new(Exit::Files, error)
    }
}

/// Prints to standard output. A closed pipe is no error, because the reader needs no more. A full
/// disk is an error. Control characters, which a scene may contain, are escaped.
///
/// # Errors
/// If standard output cannot be written.
pub fn say(what: impl Display) -> Result<(), Failure> {
    match writeln!(io::stdout(), "{}", escaped(&what.to_string())) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::new(Exit::Files, format_args!("standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints to standard error with control characters escaped.
pub fn complain(what: impl Display) {
    let _ = writeln!(io::stderr(), "{}", escaped(&what.to_string()));
}
