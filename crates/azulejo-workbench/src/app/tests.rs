//! The app without a window.

mod edits;
mod files;
mod light;
mod recovery;
mod saving;
mod units;

use super::*;
use crate::document::Edit;
use crate::document::tests::{example, sample};
use std::path::Path;
use std::time::Duration;

/// A folder that goes away with the test.
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

    /// A copy of a model that comes with azulejo.
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

/// An app with the sample in it, as if it was just opened.
fn filled() -> App {
    let mut app = App::quiet();
    app.replace(sample(), None);
    app
}

/// Polls until no job goes on.
fn settle(app: &mut App) {
    let begin = Instant::now();
    app.poll();
    while !app.jobs().is_empty() {
        assert!(
            begin.elapsed() < Duration::from_secs(60),
            "a job does not end"
        );
        std::thread::sleep(Duration::from_millis(1));
        app.poll();
    }
}

/// Executes a command and waits for all that it begins.
fn run(app: &mut App, command: Command) {
    app.execute(command);
    settle(app);
}

fn edit(app: &mut App, edit: Edit) {
    app.execute(Command::Edit(edit, None));
}

/// The errors that were told.
fn errors(app: &App) -> Vec<&str> {
    let errors = app.messages.iter().filter(|m| m.level == Severity::Error);
    errors.map(|m| m.text.as_str()).collect()
}

/// Tells an error that has this in it, and that alone.
fn check_error(app: &App, said: &str) {
    let errors = errors(app);
    assert!(
        matches!(&errors[..], [one] if one.contains(said)),
        "{errors:?}"
    );
}

fn check_no_error(app: &App) {
    assert_eq!(errors(app), [] as [&str; 0]);
}
