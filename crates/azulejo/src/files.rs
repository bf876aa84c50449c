//! Errors of the file system, with readable messages.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// The operating system refused an operation on a file.
#[derive(Debug)]
pub struct Refused {
    /// The operation, as a verb: "read", "write".
    pub deed: &'static str,
    /// The file, as the user named it.
    pub path: PathBuf,
    /// The reason.
    pub error: io::Error,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (deed, path) = (self.deed, self.path.display());
        write!(f, "cannot {deed} {path}: {}", reason(&self.error))
    }
}

impl std::error::Error for Refused {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.error)
    }
}

/// The message of an operating system's error, without the number that Rust appends.
pub fn reason(error: &io::Error) -> String {
    let text = error.to_string();
    match text.find(" (os error") {
        Some(end) => text[..end].to_string(),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_the_system_name_the_file_and_drop_the_number() {
        let full = Refused {
            deed: "write",
            path: "a.grf".into(),
            error: io::Error::from_raw_os_error(28),
        };
        let message = full.to_string();
        assert_eq!(message, "cannot write a.grf: No space left on device");
    }
}
