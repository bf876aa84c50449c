//! Menus, shortcuts and the toolbar.

use crate::window::*;
use azulejo_workbench::app::App;
use azulejo_workbench::command::Command;
use azulejo_workbench::ui::actions::{ACTIONS, Action, Menu, key_text};
use azulejo_workbench::words::Language;
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT, Queryable};

/// Opens the menu that contains an action.
fn open_menu(window: &mut TestWindow, menu: Menu) {
    let own = match menu {
        Menu::Shading => Menu::View,
        other => other,
    };
    click(window, own.label(Language::English));
    if menu == Menu::Shading {
        click(window, "Shading");
    }
}

/// The text of an action's menu entry.
fn label(window: &TestWindow, action: &Action) -> String {
    let name = match (action.label, window.state().app.undo_texts()) {
        ("Undo", (Some(what), _)) | ("Redo", (_, Some(what))) => {
            format!("{}: {what}", action.label)
        }
        _ => action.label.to_owned(),
    };
    match action.key {
        Some(key) => format!("{name} {}", key_text(&window.ctx, &key, Language::English)),
        None => name,
    }
}

/// Chooses every entry of every menu in turn; those that do not apply are disabled.
fn check_menus(app: impl Fn() -> App) {
    for action in ACTIONS {
        let mut window = window(app());
        open_menu(&mut window, action.menu);
        let makes_sense = (action.target)(&window.state().app).is_some();
        let text = label(&window, action);
        let entries = window.query_all_by_role_and_label(Role::Button, &text);
        let entry = entries
            .last()
            .unwrap_or_else(|| panic!("no \"{text}\" in its menu"));
        assert_eq!(entry.accesskit_node().is_disabled(), !makes_sense, "{text}");
        entry.click();
        // It may start the solver or a render, which is not waited for.
        window.run_steps(4);
        let scene = window.state().app.document.scene();
        assert!(scene.validate().is_ok(), "after {text}");
    }
}

#[test]
fn every_entry_of_the_menus_can_be_chosen_in_an_empty_window() {
    check_menus(App::quiet);
}

#[test]
fn every_entry_of_the_menus_can_be_chosen_with_a_model() {
    check_menus(|| {
        let mut app = opened("shapes.grf");
        app.execute(Command::SelectAll);
        app
    });
}

#[test]
fn every_key_does_what_its_entry_does() {
    let mut window = window(opened("cornell.grf"));
    press(&mut window, Modifiers::COMMAND, Key::L);
    assert_eq!(window.state().app.undo_labels().0, Some("add a shape"));
    press(&mut window, Modifiers::COMMAND, Key::D);
    assert_eq!(window.state().app.undo_labels().0, Some("duplicate"));
    let many = window.state().app.document.objects.len();
    press(&mut window, Modifiers::NONE, Key::Delete);
    assert_eq!(window.state().app.document.objects.len(), many - 1);
    for _ in 0..3 {
        press(&mut window, Modifiers::COMMAND, Key::Z);
    }
    assert_eq!(
        window.state().app.undo_labels(),
        (None, Some("add a shape"))
    );
    assert!(!window.state().app.is_changed());
    let both = Modifiers::COMMAND | Modifiers::SHIFT;
    press(&mut window, both, Key::Z);
    assert_eq!(window.state().app.undo_labels().0, Some("add a shape"));
    check_no_error(&window);
}

#[test]
fn the_bar_of_tools_shows_what_surfaces_show() {
    let mut window = window(opened("cornell.grf"));
    find(&window, Role::ComboBox, "Shading mode").click();
    window.run();
    click_last(&mut window, "Hidden lines");
    let shading = window.state().app.view.shading;
    assert_eq!(shading, azulejo_workbench::view::Shading::HiddenLines);
    assert!(says(&window, "Hidden lines"));
    assert!(!window.state().app.is_changed(), "a look is not a change");
}

#[test]
fn recent_files_are_opened_again() {
    let folder = TestFolder::new("recent");
    let model = folder.copy("shapes.grf");
    let mut app = App::quiet();
    app.preferences.note_recent(&model);
    let mut window = window(app);
    click(&mut window, "File");
    click(&mut window, "Recent");
    click_last(&mut window, "shapes.grf");
    wait(&mut window);
    check_no_error(&window);
    assert_eq!(window.state().app.document.source_files[0].path, model);
}
