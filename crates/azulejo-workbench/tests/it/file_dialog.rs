//! The field for a path, where the desktop has no dialog, with nothing but the keyboard.

use crate::window::*;
use azulejo_workbench::app::App;
use azulejo_workbench::command::{Command, FileRequest};
use azulejo_workbench::words::Language;
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use std::path::Path;

/// A window with `shapes.grf` of a folder that contains two models and a folder with another.
fn window_in(folder: &TestFolder) -> TestWindow {
    std::fs::create_dir_all(folder.path("sub")).unwrap();
    std::fs::copy(example("csg.grf"), folder.path("sub/deep.grf")).unwrap();
    folder.copy("cornell.grf");
    let mut app = App::quiet();
    app.execute(Command::Open(vec![folder.copy("shapes.grf")]));
    let mut window = window(app);
    wait(&mut window);
    window
}

fn open(window: &mut TestWindow) {
    press(window, Modifiers::COMMAND, Key::O);
    assert!(says(window, "Open models"));
    assert_eq!(focused(window).as_deref(), Some("File:"));
}

fn save_as(window: &mut TestWindow) {
    press(window, Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    assert!(says(window, "Save as GRF"));
}

fn key(window: &mut TestWindow, key: Key) {
    press(window, Modifiers::NONE, key);
}

fn enter(window: &mut TestWindow) {
    key(window, Key::Enter);
    wait(window);
    check_no_error(window);
}

fn file_of(window: &TestWindow) -> Option<&Path> {
    window.state().app.file.as_ref().map(|f| f.path.as_path())
}

#[test]
fn enter_alone_saves_under_the_proposed_name() {
    let folder = TestFolder::new("key-save");
    let mut window = window_in(&folder);
    press(&mut window, Modifiers::COMMAND, Key::L);
    assert!(window.state().app.is_changed());
    save_as(&mut window);
    enter(&mut window);
    assert!(!window.state().app.is_changed());
    assert_eq!(file_of(&window), Some(&*folder.path("shapes.grf")));
}

#[test]
fn typing_replaces_the_proposed_name_but_not_its_extension() {
    let folder = TestFolder::new("key-stem");
    let mut window = window_in(&folder);
    save_as(&mut window);
    type_text(&mut window, "other");
    assert!(says(&window, "other.grf"));
    enter(&mut window);
    assert_eq!(file_of(&window), Some(&*folder.path("other.grf")));
}

#[test]
fn tab_reaches_everything_in_the_dialog_and_nothing_else() {
    let folder = TestFolder::new("key-tab");
    let mut window = window_in(&folder);
    open(&mut window);
    type_text(&mut window, "s");
    for modifiers in [Modifiers::NONE, Modifiers::SHIFT] {
        let mut seen = Vec::new();
        for _ in 0..6 {
            press(&mut window, modifiers, Key::Tab);
            seen.extend(focused(&window));
        }
        seen.sort();
        let twice = ["Cancel", "Cancel", "File:", "File:", "Open", "Open"];
        assert_eq!(seen, twice);
    }
}

#[test]
fn escape_cancels_what_waits_for_the_file() {
    let folder = TestFolder::new("key-escape");
    let mut window = window_in(&folder);
    press(&mut window, Modifiers::COMMAND, Key::L);
    let new = Command::RequestFile(FileRequest::SaveAs);
    window.state_mut().app.execute(new);
    window.run();
    type_text(&mut window, "never");
    key(&mut window, Key::Escape);
    assert!(!says(&window, "Save as GRF") && window.state().app.asking.is_none());
    assert!(window.state().app.question.is_none());
    assert!(!folder.path("never.grf").exists());
}

#[test]
fn typed_paths_are_followed() {
    let folder = TestFolder::new("key-paths");
    let mut window = window_in(&folder);
    open(&mut window);
    type_text(&mut window, "sub/deep.grf");
    enter(&mut window);
    assert_eq!(file_of(&window), Some(&*folder.path("sub/deep.grf")));
    open(&mut window);
    // Relative to the folder of the last file.
    type_text(&mut window, "../cornell.grf");
    enter(&mut window);
    assert_eq!(file_of(&window), Some(&*folder.path("cornell.grf")));
    open(&mut window);
    let absolute = folder.path("sub/deep.grf");
    type_text(&mut window, &absolute.to_string_lossy());
    enter(&mut window);
    assert_eq!(file_of(&window), Some(&*absolute));
}

#[test]
fn what_is_not_there_is_told_until_another_path_is_typed() {
    let folder = TestFolder::new("key-missing");
    let mut window = window_in(&folder);
    open(&mut window);
    key(&mut window, Key::Enter);
    assert!(says(&window, "Open models"), "nothing is typed yet");
    for (typed, problem) in [
        ("nowhere.grf", "There is no such file:"),
        ("/zoo/a.grf", "There is no such folder:"),
    ] {
        press(&mut window, Modifiers::COMMAND, Key::A);
        type_text(&mut window, typed);
        assert!(!says(&window, "There is no such"));
        key(&mut window, Key::Enter);
        assert!(says(&window, problem));
        assert_eq!(focused(&window).as_deref(), Some("File:"));
    }
    press(&mut window, Modifiers::COMMAND, Key::A);
    type_text(&mut window, "sub");
    click_last(&mut window, "Open");
    assert!(says(&window, "This is a folder:"));
    assert_eq!(focused(&window).as_deref(), Some("File:"));
    // The cursor is at the end of what was typed.
    type_text(&mut window, "/deep.grf");
    enter(&mut window);
    assert_eq!(file_of(&window), Some(&*folder.path("sub/deep.grf")));
}

/// Windows of 800 × 600 and 640 × 480 pixels at a scale of 1.5, in every language.
#[test]
fn the_buttons_stay_visible_in_small_windows() {
    let folder = TestFolder::new("key-small");
    for language in Language::ALL {
        for (width, height) in [(533.0, 400.0), (427.0, 320.0)] {
            let mut window = window_in(&folder);
            window.state_mut().app.preferences.language = language;
            window.set_size(egui::vec2(width, height));
            window.run();
            let export = Command::RequestFile(FileRequest::Export);
            window.state_mut().app.execute(export);
            window.run();
            let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(width, height));
            for text in ["Save", "Cancel"] {
                let buttons = window.query_all_by_role_and_label(Role::Button, language.tr(text));
                let rect = buttons.last().expect(text).rect();
                assert!(
                    screen.contains_rect(rect),
                    "{text} at {rect} of {language:?}"
                );
            }
        }
    }
}
