//! A window without a screen, and helpers to operate it.

use azulejo_workbench::app::{App, Severity};
use azulejo_workbench::command::{Command, Selection};
use azulejo_workbench::ui::Workbench;
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT, Queryable, by};
use egui_kittest::{Harness, Node};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A window without a screen. Every widget in it must have an accessible name.
pub type TestWindow = Harness<'static, Workbench>;

/// A job that takes longer than this has stalled.
pub const PATIENCE: Duration = Duration::from_secs(300);

/// A window around an app.
pub fn window(app: App) -> TestWindow {
    let mut window = Harness::builder()
        .with_size([1200.0, 800.0])
        .with_max_steps(200)
        .with_accessibility_check(true)
        .build_ui_state(
            |ui, window: &mut Workbench| window.show(ui),
            Workbench::new(app),
        );
    window.run();
    window
}

/// The path of an example model.
pub fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../examples")
        .join(name)
}

/// An app with a model.
pub fn opened(name: &str) -> App {
    let mut app = App::quiet();
    app.execute(Command::Open(vec![example(name)]));
    let begin = Instant::now();
    while !app.jobs().is_empty() {
        assert!(begin.elapsed() < PATIENCE, "a job does not end");
        std::thread::sleep(Duration::from_millis(1));
        app.poll();
    }
    app
}

/// Runs frames until no job is running.
pub fn wait(window: &mut TestWindow) {
    let begin = Instant::now();
    window.run_steps(2);
    while !window.state().app.jobs().is_empty() {
        assert!(begin.elapsed() < PATIENCE, "a job does not end");
        std::thread::sleep(Duration::from_millis(1));
        window.step();
    }
    // A closing window runs until it is gone.
    window.run_ok();
}

/// The only widget with a role and a label, or the first of several.
pub fn find<'a>(window: &'a TestWindow, role: Role, label: &'a str) -> Node<'a> {
    let mut nodes = window.query_all_by_role_and_label(role, label);
    let node = nodes.next();
    node.unwrap_or_else(|| panic!("no {role:?} \"{label}\" in {:#?}", labels(window)))
}

/// Everything that has a label.
pub fn labels(window: &TestWindow) -> Vec<String> {
    let nodes = window.query_all(by().predicate(|n| n.label().is_some()));
    nodes
        .map(|n| {
            format!(
                "{:?} {}",
                n.accesskit_node().role(),
                n.accesskit_node().label().unwrap_or_default()
            )
        })
        .collect()
}

/// Whether the text is displayed anywhere, as a label or as a value.
pub fn says(window: &TestWindow, text: &str) -> bool {
    let has = |n: &egui_kittest::kittest::AccessKitNode<'_>| {
        n.label().is_some_and(|l| l.contains(text)) || n.value().is_some_and(|v| v.contains(text))
    };
    window.query_all(by().predicate(has)).next().is_some()
}

/// Clicks the first button with a label.
pub fn click(window: &mut TestWindow, label: &str) {
    find(window, Role::Button, label).click();
    window.run();
}

/// Clicks the last button with a label: the topmost one.
pub fn click_last(window: &mut TestWindow, label: &str) {
    let last = window
        .query_all_by_role_and_label(Role::Button, label)
        .last();
    last.unwrap_or_else(|| panic!("no button \"{label}\""))
        .click();
    // It may be the last click of all: a closing window never settles.
    window.run_ok();
}

pub fn press(window: &mut TestWindow, modifiers: Modifiers, key: Key) {
    window.key_press_modifiers(modifiers, key);
    window.run();
}

/// Types where the focus is.
pub fn type_text(window: &mut TestWindow, text: &str) {
    window.event(egui::Event::Text(text.into()));
    window.run();
}

/// The label of the widget that has the focus.
pub fn focused(window: &TestWindow) -> Option<String> {
    let has_focus = |n: &egui_kittest::kittest::AccessKitNode<'_>| n.is_focused();
    let focused = window.query_all(by().predicate(has_focus)).last()?;
    let node = focused.accesskit_node();
    let own = node.label();
    let labels = node.labelled_by().filter_map(|n| n.label().or(n.value()));
    own.or_else(|| labels.into_iter().next())
}

/// Sets the value of a number field.
pub fn set(window: &mut TestWindow, label: &str, value: f64) {
    find(window, Role::SpinButton, label).set_value_accesskit(value);
    window.run();
}

/// Replaces the text of the field that contains `old`.
pub fn write(window: &mut TestWindow, old: &str, new: &str) {
    field(window, old).focus();
    window.run();
    press(window, Modifiers::COMMAND, Key::A);
    field(window, old).type_text(new);
    window.run();
}

fn field<'a>(window: &'a TestWindow, text: &'a str) -> Node<'a> {
    let is_it = move |n: &egui_kittest::kittest::AccessKitNode<'_>| {
        let is_text = matches!(n.role(), Role::TextInput | Role::MultilineTextInput);
        is_text && n.value().unwrap_or_default() == text
    };
    let last = window.query_all(by().predicate(is_it)).last();
    last.unwrap_or_else(|| panic!("no field with \"{text}\""))
}

/// Asserts that no error was reported.
pub fn check_no_error(window: &TestWindow) {
    let messages = &window.state().app.messages;
    let errors: Vec<_> = messages
        .iter()
        .filter(|m| m.level == Severity::Error)
        .collect();
    assert!(errors.is_empty(), "{errors:?}");
}

/// A temporary folder, deleted at the end of the test.
pub struct TestFolder(PathBuf);

impl TestFolder {
    pub fn new(name: &str) -> TestFolder {
        let own = format!("azulejo-window-{name}-{}", std::process::id());
        let path = std::env::temp_dir().join(own);
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        TestFolder(path)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Copies an example model into the folder.
    pub fn copy(&self, name: &str) -> PathBuf {
        std::fs::copy(example(name), self.path(name)).unwrap();
        self.path(name)
    }
}

/// An app with a luminaire of IES LM-63 whose light is selected: 100 cd straight down, nothing from 60 degrees on across
/// and from 30 along.
pub fn with_luminaire(folder: &TestFolder) -> App {
    let path = folder.path("wash.ies");
    let text = "IESNA:LM-63-2002\n[LUMINAIRE] Wash\nTILT=NONE\n1 1000 1 3 2 1 2 0 0 0\n1 1 30\n0 30 60\n0 90\n\
        100 50 0\n100 0 0\n";
    std::fs::write(&path, text).unwrap();
    let mut app = App::quiet();
    app.execute(Command::Open(vec![path]));
    while !app.jobs().is_empty() {
        std::thread::sleep(Duration::from_millis(1));
        app.poll();
    }
    let lamp = app.document.lights[0].id;
    app.execute(Command::Select(Selection::one(lamp)));
    app
}

impl Drop for TestFolder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
