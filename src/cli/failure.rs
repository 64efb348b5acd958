//! What ends a command early, and with which exit code.

use std::io::{self, Write};
use std::process::ExitCode;

/// What ends a command early.
#[derive(Debug)]
pub(super) enum Failure {
    /// Input or usage that makes no sense; the text says what and where.
    Input(String),
    /// stdout could not be written.
    Output(io::Error),
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::Output(error)
    }
}

impl Failure {
    /// Bad usage or input; 1 and 3 are for limits.
    const BAD_INPUT: u8 = 2;

    /// Says it on stderr and gives the exit code.
    pub(super) fn report(&self) -> ExitCode {
        let text = match self {
            Self::Input(text) => text.clone(),
            // The reader of a pipe has left, as `head` does: nobody is there to be told.
            Self::Output(error) if error.kind() == io::ErrorKind::BrokenPipe => {
                return ExitCode::SUCCESS;
            }
            Self::Output(error) => format!("stdout: {error}"),
        };
        // When stderr is closed too, the exit code is all that can be said.
        let _ = writeln!(anstream::stderr(), "{text}");
        ExitCode::from(Self::BAD_INPUT)
    }
}
