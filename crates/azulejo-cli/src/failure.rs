//! Failures of commands, and their exit codes.

use azulejo::files::{Refused, reason};
use azulejo::models::{ReadFailure, WriteFailure};
use azulejo::output::OutputError;
use azulejo::recipe::RecipeError;
use azulejo::surroundings::PictureFailure;
use azulejo_trace::Cancelled;
use std::fmt;
use std::io;
use std::path::Path;
use std::process::ExitCode;

/// Why a command stopped before its work was done.
#[derive(Debug)]
pub enum Failure {
    /// The command line is invalid: exit code 2.
    Misuse(String),
    /// The work failed: exit code 1.
    Failed(String),
    /// Ctrl-C: exit code 1.
    Cancelled,
    /// The answer is in the report, and it is no: exit code 1.
    Found,
    /// The reader of our output has closed the pipe: silent, exit code 0.
    BrokenPipe,
}

impl Failure {
    /// The work failed with this message.
    pub fn failed(message: impl fmt::Display) -> Failure {
        Failure::Failed(message.to_string())
    }

    /// The command line is invalid, with this message.
    pub fn misuse(message: impl fmt::Display) -> Failure {
        Failure::Misuse(message.to_string())
    }

    /// The operating system refused an operation on a file; `what` is a verb.
    pub fn file(what: &str, path: &Path, error: &io::Error) -> Failure {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Failure::BrokenPipe,
            _ => Failure::Failed(format!(
                "cannot {what} {}: {}",
                path.display(),
                reason(error)
            )),
        }
    }

    /// The process's exit code.
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(self.status())
    }

    /// The exit code as a number.
    pub fn status(&self) -> u8 {
        match self {
            Failure::BrokenPipe => 0,
            Failure::Failed(_) | Failure::Cancelled | Failure::Found => 1,
            Failure::Misuse(_) => 2,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::Misuse(message) | Failure::Failed(message) => f.write_str(message),
            Failure::Cancelled => f.write_str("cancelled"),
            Failure::Found => f.write_str("something was found"),
            Failure::BrokenPipe => f.write_str("the output was closed"),
        }
    }
}

impl From<Cancelled> for Failure {
    fn from(_: Cancelled) -> Failure {
        Failure::Cancelled
    }
}

impl From<Refused> for Failure {
    fn from(refused: Refused) -> Failure {
        Failure::file(refused.deed, &refused.path, &refused.error)
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Failure {
        match error {
            OutputError::Cancelled => Failure::Cancelled,
            OutputError::File(refused) => refused.into(),
            other => Failure::failed(other),
        }
    }
}

impl From<ReadFailure> for Failure {
    fn from(failure: ReadFailure) -> Failure {
        match failure {
            ReadFailure::Cancelled => Failure::Cancelled,
            ReadFailure::File(refused) => refused.into(),
            other => Failure::failed(other),
        }
    }
}

impl From<PictureFailure> for Failure {
    fn from(failure: PictureFailure) -> Failure {
        match failure {
            PictureFailure::File(failure) => failure.into(),
            other => Failure::failed(other),
        }
    }
}

impl From<RecipeError> for Failure {
    fn from(error: RecipeError) -> Failure {
        match error {
            RecipeError::File(refused) => refused.into(),
            other => Failure::failed(other),
        }
    }
}

impl From<WriteFailure> for Failure {
    fn from(failure: WriteFailure) -> Failure {
        match failure {
            WriteFailure::Output(error) => error.into(),
            // The others are about the file name.
            other => Failure::misuse(other),
        }
    }
}

/// Errors of writing to standard output, which has no path.
impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Failure {
        Failure::file("write", Path::new("standard output"), &error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_the_system_name_the_file_and_drop_the_number() {
        let full = io::Error::from_raw_os_error(28);
        let message = Failure::file("write", Path::new("a.grf"), &full).to_string();
        assert_eq!(message, "cannot write a.grf: No space left on device");
        let closed = io::Error::from(io::ErrorKind::BrokenPipe);
        assert!(matches!(Failure::from(closed), Failure::BrokenPipe));
    }
}
