//! What ends a command early, and with which exit code.

use std::io::{self, Write};
use std::process::ExitCode;

/// What ends a command early.
#[derive(Debug)]
pub(super) enum Failure {
    /// Input or usage that makes no sense; the text says what and where.
    Input(String),
    /// A limit was exceeded; which one was said on stdout.
    Exceeded,
    /// The runs cannot tell whether limits are kept; which ones was said on stdout.
    TooLittle,
    /// stdout could not be written.
    Output(io::Error),
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::Output(error)
    }
}

impl Failure {
    const EXCEEDED: u8 = 1;
    const BAD_INPUT: u8 = 2;
    const TOO_LITTLE: u8 = 3;

    /// Says it on stderr and gives the exit code.
    pub(super) fn report(&self) -> ExitCode {
        let text = match self {
            Self::Input(text) => text.clone(),
            Self::Exceeded => return ExitCode::from(Self::EXCEEDED),
            Self::TooLittle => return ExitCode::from(Self::TOO_LITTLE),
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
