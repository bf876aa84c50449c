//! The file dialog with nothing but the keyboard, and its looks in small windows.

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

/// The name of a folder.
fn own_name(folder: &TestFolder) -> String {
    let path = folder.path("");
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// The names of the displayed rows.
fn rows(window: &TestWindow) -> Vec<String> {
    let rows = window.query_all_by_role(Role::ListBoxOption);
    rows.filter_map(|n| egui_kittest::kittest::NodeT::accesskit_node(&n).label())
        .collect()
}

#[test]
fn a_file_is_opened_by_typing_and_enter() {
    let folder = TestFolder::new("key-open");
    let mut window = window_in(&folder);
    open(&mut window);
    assert_eq!(rows(&window), ["🗀 sub", "🗋 cornell.grf", "🗋 shapes.grf"]);
    assert_eq!(focused(&window).as_deref(), Some("File:"));
    type_text(&mut window, "corn");
    assert_eq!(rows(&window), ["🗋 cornell.grf"]);
    enter(&mut window);
    assert_eq!(file_of(&window), Some(&*folder.path("cornell.grf")));
    assert!(!says(&window, "Open models"));
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
    let own = own_name(&folder);
    for modifiers in [Modifiers::NONE, Modifiers::SHIFT] {
        let mut seen = Vec::new();
        for _ in 0..60 {
            press(&mut window, modifiers, Key::Tab);
            seen.extend(focused(&window));
        }
        for widget in [
            "Parent folder",
            "Refresh",
            "New folder",
            &own,
            "Current folder",
            "Name",
            "Size",
            "Modified",
            "Files",
            "File:",
            "Open",
            "Cancel",
            "All files",
            "Show hidden files",
        ] {
            assert!(seen.iter().any(|s| s == widget), "{widget} of {seen:?}");
        }
        for widget in ["File", "Solve", "Object", "column"] {
            assert!(seen.iter().all(|s| s != widget), "{widget} of {seen:?}");
        }
        // It comes around.
        let names = seen.iter().filter(|s| *s == "File:").count();
        assert!(names > 1, "{seen:?}");
    }
}

#[test]
fn arrows_move_in_the_list_and_enter_goes_into_folders() {
    let folder = TestFolder::new("key-arrows");
    let mut window = window_in(&folder);
    open(&mut window);
    key(&mut window, Key::ArrowDown);
    assert!(says(&window, "sub"));
    key(&mut window, Key::Enter);
    assert_eq!(rows(&window), ["🗋 deep.grf"]);
    key(&mut window, Key::ArrowDown);
    enter(&mut window);
    assert_eq!(file_of(&window), Some(&*folder.path("sub/deep.grf")));
}

#[test]
fn presses_within_one_frame_all_count() {
    let folder = TestFolder::new("key-frame");
    let mut window = window_in(&folder);
    open(&mut window);
    window.key_press(Key::ArrowDown);
    window.key_press(Key::ArrowDown);
    window.step();
    enter(&mut window);
    assert_eq!(file_of(&window), Some(&*folder.path("cornell.grf")));
}

#[test]
fn the_parent_folder_is_a_key_away() {
    let folder = TestFolder::new("key-parent");
    let mut window = window_in(&folder);
    open(&mut window);
    let into = |window: &mut TestWindow| {
        type_text(window, "sub");
        key(window, Key::Enter);
        assert_eq!(rows(window), ["🗋 deep.grf"]);
    };
    into(&mut window);
    press(&mut window, Modifiers::ALT, Key::ArrowUp);
    assert_eq!(rows(&window)[0], "🗀 sub");
    into(&mut window);
    key(&mut window, Key::Backspace);
    assert_eq!(rows(&window)[0], "🗀 sub", "the name was empty");
    into(&mut window);
    find(&window, Role::ListBox, "Files").focus();
    window.run();
    key(&mut window, Key::ArrowDown);
    assert!(says(&window, "deep.grf"));
    key(&mut window, Key::Backspace);
    assert_eq!(rows(&window)[0], "🗀 sub", "from the list");
    // A name that is deleted is only that.
    type_text(&mut window, "x");
    key(&mut window, Key::Backspace);
    assert_eq!(rows(&window)[0], "🗀 sub");
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
    type_text(&mut window, "sub/");
    key(&mut window, Key::Enter);
    assert_eq!(rows(&window), ["🗋 deep.grf"], "a folder is entered");
    type_text(&mut window, "../cornell.grf");
    enter(&mut window);
    assert_eq!(file_of(&window), Some(&*folder.path("cornell.grf")));
    open(&mut window);
    let absolute = folder.path("sub/deep.grf");
    type_text(&mut window, &absolute.to_string_lossy());
    enter(&mut window);
    assert_eq!(file_of(&window), Some(&*absolute));
    open(&mut window);
    type_text(&mut window, "nowhere.grf");
    key(&mut window, Key::Enter);
    assert!(says(&window, "There is no such file:"));
    assert_eq!(focused(&window).as_deref(), Some("File:"));
}

#[test]
fn what_is_typed_in_the_list_goes_to_the_name() {
    let folder = TestFolder::new("key-list");
    let mut window = window_in(&folder);
    open(&mut window);
    find(&window, Role::ListBox, "Files").focus();
    window.run();
    type_text(&mut window, "c");
    type_text(&mut window, "o");
    assert_eq!(focused(&window).as_deref(), Some("File:"));
    assert_eq!(rows(&window), ["🗋 cornell.grf"]);
}

#[test]
fn several_files_are_selected_with_shift_and_arrows() {
    let folder = TestFolder::new("key-several");
    let mut window = window_in(&folder);
    let objects = window.state().app.document.objects.len();
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::O);
    find(&window, Role::ListBox, "Files").focus();
    window.run();
    key(&mut window, Key::End);
    press(&mut window, Modifiers::SHIFT, Key::ArrowUp);
    assert!(says(&window, "2 files selected"));
    enter(&mut window);
    assert!(window.state().app.document.objects.len() > 2 * objects);
}

#[test]
fn a_folder_is_created_without_the_mouse() {
    let folder = TestFolder::new("key-new");
    let mut window = window_in(&folder);
    save_as(&mut window);
    find(&window, Role::Button, "New folder").focus();
    window.run();
    key(&mut window, Key::Enter);
    assert_eq!(focused(&window).as_deref(), Some("New folder:"));
    key(&mut window, Key::Escape);
    assert!(says(&window, "Save as GRF"), "only the folder is given up");
    find(&window, Role::Button, "New folder").focus();
    window.run();
    key(&mut window, Key::Enter);
    type_text(&mut window, "made");
    key(&mut window, Key::Enter);
    assert!(folder.path("made").is_dir());
    enter(&mut window);
    assert_eq!(file_of(&window), Some(&*folder.path("made/shapes.grf")));
}

#[test]
fn a_folder_that_cannot_be_read_says_so() {
    let folder = TestFolder::new("key-unreadable");
    let mut window = window_in(&folder);
    open(&mut window);
    std::fs::remove_dir_all(folder.path("sub")).unwrap();
    key(&mut window, Key::ArrowDown);
    key(&mut window, Key::Enter);
    assert!(says(&window, "This folder cannot be read:"));
    press(&mut window, Modifiers::ALT, Key::ArrowUp);
    assert_eq!(rows(&window), ["🗋 cornell.grf", "🗋 shapes.grf"]);
}

#[test]
fn headers_sort_and_recent_folders_are_a_click_away() {
    let folder = TestFolder::new("key-sort");
    let mut window = window_in(&folder);
    open(&mut window);
    click_last(&mut window, "Name");
    assert_eq!(rows(&window), ["🗀 sub", "🗋 shapes.grf", "🗋 cornell.grf"]);
    press(&mut window, Modifiers::ALT, Key::ArrowUp);
    assert!(!says(&window, "🗋 cornell.grf"));
    click_last(&mut window, &own_name(&folder));
    assert_eq!(rows(&window).len(), 3);
}

#[test]
fn places_are_in_a_menu_where_there_is_no_space() {
    let folder = TestFolder::new("key-places");
    let mut window = window_in(&folder);
    window.set_size(egui::vec2(480.0, 360.0));
    open(&mut window);
    click_last(&mut window, "Places");
    find(&window, Role::Button, "Current folder");
    key(&mut window, Key::Escape);
    let closed = |window: &TestWindow| {
        let places = window.query_all_by_role_and_label(Role::Button, "Current folder");
        places.count() == 0
    };
    assert!(closed(&window) && says(&window, "Open models"));
    find(&window, Role::Button, "Places").focus();
    window.run();
    key(&mut window, Key::Enter);
    click_last(&mut window, "Current folder");
    let here = std::env::current_dir().unwrap();
    let name = here.file_name().unwrap().to_string_lossy().into_owned();
    find(&window, Role::Button, &name);
    assert!(closed(&window) && !says(&window, "🗋 cornell.grf"));
}

#[test]
fn ten_thousand_files_are_only_drawn_where_they_are_seen() {
    let folder = TestFolder::new("key-many");
    for k in 0..10_000 {
        std::fs::write(folder.path(&format!("{k:05}.obj")), "").unwrap();
    }
    let mut window = window_in(&folder);
    open(&mut window);
    assert!((5..60).contains(&rows(&window).len()));
    find(&window, Role::ListBox, "Files").focus();
    window.run();
    key(&mut window, Key::End);
    assert_eq!(rows(&window).last().unwrap(), "🗋 shapes.grf");
    type_text(&mut window, "09999");
    assert_eq!(rows(&window), ["🗋 09999.obj"]);
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
            for (role, text) in [
                (Role::Button, "Save"),
                (Role::Button, "Cancel"),
                (Role::Button, "New folder"),
                (Role::CheckBox, "All files"),
                (Role::CheckBox, "Show hidden files"),
            ] {
                let found = window.query_all_by_role_and_label(role, language.tr(text));
                let rect = found.last().expect(text).rect();
                assert!(
                    screen.contains_rect(rect),
                    "{text} at {rect} of {language:?}"
                );
            }
            assert!(rows(&window).len() >= 3, "{language:?} {width}");
        }
    }
}
