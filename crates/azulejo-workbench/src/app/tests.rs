//! Tests of the app without a window.

mod edits;
mod files;
mod first_minute;
mod light;
mod recipes;
mod recovery;
mod saving;
mod surroundings;
mod units;

use super::*;
use crate::document::Edit;
use crate::document::tests::{example, sample};
use std::path::Path;
use std::time::Duration;

/// A temporary folder, deleted at the end of the test.
struct TestFolder(PathBuf);

impl TestFolder {
    fn new(name: &str) -> TestFolder {
        let own = format!("azulejo-app-{name}-{}", std::process::id());
        let path = std::env::temp_dir().join(own);
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        TestFolder(path)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Copies one of azulejo's example models into the folder.
    fn copy(&self, name: &str) -> PathBuf {
        std::fs::copy(example(name), self.path(name)).unwrap();
        self.path(name)
    }
}

impl Drop for TestFolder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// An app with the sample scene, as if it had just been opened.
fn filled() -> App {
    let mut app = App::quiet();
    app.replace(sample(), None);
    app
}

/// Polls until no job is running.
fn settle(app: &mut App) {
    let begin = Instant::now();
    app.poll();
    while !app.jobs().is_empty() {
        assert!(
            begin.elapsed() < Duration::from_secs(300),
            "a job does not end"
        );
        std::thread::sleep(Duration::from_millis(1));
        app.poll();
    }
}

/// Executes a command and waits for the jobs that it starts.
fn run(app: &mut App, command: Command) {
    app.execute(command);
    settle(app);
}

fn edit(app: &mut App, edit: Edit) {
    app.execute(Command::Edit(edit, None));
}

/// The errors reported so far.
fn errors(app: &App) -> Vec<&str> {
    let errors = app.messages.iter().filter(|m| m.level == Severity::Error);
    errors.map(|m| m.text.as_str()).collect()
}

/// Asserts that exactly one error was reported and that it contains `expected`.
fn check_error(app: &App, expected: &str) {
    let errors = errors(app);
    assert!(
        matches!(&errors[..], [one] if one.contains(expected)),
        "{errors:?}"
    );
}

fn check_no_error(app: &App) {
    assert_eq!(errors(app), [] as [&str; 0]);
}
