//! Dialogs and the message list.

use crate::window::*;
use azulejo_workbench::app::{App, Severity};
use azulejo_workbench::words::Language;
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;

#[test]
fn the_language_changes_at_once_everywhere() {
    let mut window = window(opened("shapes.grf"));
    press(&mut window, Modifiers::COMMAND, Key::Comma);
    assert!(says(&window, "Preferences"));
    for (language, file, lights) in [
        (Language::Spanish, "Archivo", "Luces"),
        (Language::Portuguese, "Ficheiro", "Luzes"),
    ] {
        let own = window.state().app.preferences.language.name();
        let is_it = |n: &egui_kittest::kittest::AccessKitNode<'_>| {
            n.role() == Role::ComboBox && n.value().is_some_and(|v| v == own)
        };
        let combo = egui_kittest::kittest::by().predicate(is_it);
        window.query_all(combo).next().expect("languages").click();
        window.run();
        click_last(&mut window, language.name());
        assert_eq!(window.state().app.preferences.language, language);
        find(&window, Role::Button, file);
        find(&window, Role::Button, lights);
        assert!(
            window
                .query_by_role_and_label(Role::Button, "File")
                .is_none()
        );
    }
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert!(!says(&window, "Preferências"));
}

#[test]
fn the_keys_are_listed_and_do_nothing_meanwhile() {
    let mut window = window(opened("shapes.grf"));
    press(&mut window, Modifiers::NONE, Key::Questionmark);
    for text in [
        "Keyboard and mouse",
        "Ctrl+Shift+Z",
        "Fly forward",
        "Render image",
    ] {
        assert!(says(&window, text), "{text}");
    }
    press(&mut window, Modifiers::COMMAND, Key::L);
    assert!(!window.state().app.is_changed());
    click_last(&mut window, "Close");
    assert!(!says(&window, "Keyboard and mouse"));
    press(&mut window, Modifiers::COMMAND, Key::L);
    assert!(window.state().app.is_changed());
}

#[test]
fn azulejo_says_what_it_is() {
    let mut window = window(App::quiet());
    click(&mut window, "Help");
    click_last(&mut window, "About azulejo");
    assert!(says(&window, env!("CARGO_PKG_VERSION")));
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert!(!says(&window, env!("CARGO_PKG_VERSION")));
}

#[test]
fn solid_letters_are_added() {
    let mut window = window(opened("cornell.grf"));
    let many = window.state().app.document.objects.len();
    click(&mut window, "Add");
    click_last(&mut window, "Text…");
    write(&mut window, "", "Hola");
    set(&mut window, "Depth (em)", 0.5);
    click_last(&mut window, "Add text");
    check_no_error(&window);
    let document = &window.state().app.document;
    assert_eq!(document.objects.len(), many + 1);
    assert_eq!(document.objects[many].name, "Hola");
    assert!(!says(&window, "Solid text"));
}

#[test]
fn a_message_leads_to_what_it_is_about() {
    let folder = TestFolder::new("messages");
    let path = folder.path("odd.obj");
    let text = "o roof\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl nowhere\nf 1 2 3\ncurv2 1 2\n\
                o far\nv 9 9 9\nv 10 9 9\nv 9 10 9\nf 4 5 6\n";
    std::fs::write(&path, text).unwrap();
    let mut app = App::quiet();
    app.execute(azulejo_workbench::command::Command::Open(vec![path]));
    let mut window = window(app);
    wait(&mut window);
    let warnings = window.state().app.messages.iter();
    let warnings = warnings.filter(|m| m.level == Severity::Warning).count();
    assert!(warnings > 0);
    click(&mut window, &format!("⚠ {warnings}"));
    window
        .query_all_by_role(Role::Link)
        .next()
        .expect("a way")
        .click();
    window.run();
    let app = &window.state().app;
    assert_eq!(app.selection.ids, [app.document.objects[0].id]);
    // It is in the centre of the view.
    let about = app.document.bounds(Some(&app.selection.ids)).centre();
    assert!((app.view.camera.target - about).length() < 1e-9);
    click(&mut window, "Clear");
    assert!(window.state().app.messages.is_empty());
}

#[test]
fn every_tab_has_names_for_all_its_widgets() {
    let mut window = window(opened("shapes.grf"));
    click(&mut window, "column");
    for tab in ["Material", "Light", "View", "Object"] {
        click_last(&mut window, tab);
    }
    check_no_error(&window);
}

#[test]
fn an_idle_window_draws_nothing() {
    let mut window = window(opened("cornell.grf"));
    assert_eq!(window.run(), 1);
    let delay = window
        .output()
        .viewport_output
        .values()
        .map(|v| v.repaint_delay)
        .min();
    assert!(delay.is_some_and(|d| d.as_secs() > 60), "{delay:?}");
}

#[test]
fn a_prism_is_added() {
    let mut window = window(opened("cornell.grf"));
    let many = window.state().app.document.objects.len();
    click(&mut window, "Add");
    click_last(&mut window, "Prism…");
    set(&mut window, "Sides", 5.0);
    set(&mut window, "Larger side", 2.0);
    set(&mut window, "Height", 0.5);
    click_last(&mut window, "Add prism");
    check_no_error(&window);
    let app = &window.state().app;
    assert_eq!(app.document.objects[many].name, "prism");
    let size = app.document.bounds(Some(&app.selection.ids)).size();
    assert!((size.x - 2.0).abs() < 1e-9, "{size}");
    assert!((size.y - 0.5).abs() < 1e-9, "{size}");
    assert!(!says(&window, "Exact prism"));
}

#[test]
fn a_drawing_is_extruded_and_what_is_none_is_told() {
    use azulejo_workbench::command::{Command, PrismBase};
    let folder = TestFolder::new("drawing");
    let (path, other) = (folder.path("logo.svg"), folder.path("no.svg"));
    let text = r#"<svg xmlns="http://www.w3.org/2000/svg" width="4" height="2">
        <circle cx="1" cy="1" r="1"/><path d="M2 0h2v2h-2z"/></svg>"#;
    std::fs::write(&path, text).unwrap();
    std::fs::write(&other, "none").unwrap();
    let mut app = App::quiet();
    let add = |path| Command::AddPrism {
        base: PrismBase::Drawing(path),
        size: 8.0,
        height: 1.0,
    };
    app.execute(add(path));
    assert!(app.messages.is_empty(), "{:?}", app.messages);
    assert_eq!(app.document.objects[0].name, "logo");
    let size = app.document.bounds(None).size();
    assert!(
        (size - glam::DVec3::new(8.0, 1.0, 4.0)).length() < 1e-9,
        "{size}"
    );
    app.execute(add(other));
    assert_eq!(app.errors, 1);
    assert_eq!(app.document.objects.len(), 1);
}

#[test]
fn a_file_for_a_dialog_is_asked_for_and_left_again() {
    for (entry, button, title, back) in [
        (
            "Prism…",
            "From a drawing…",
            "Choose a drawing to extrude",
            "Exact prism",
        ),
        ("Text…", "DejaVu Serif", "Choose a font", "Solid text"),
    ] {
        let mut window = window(App::quiet());
        click(&mut window, "Add");
        click_last(&mut window, entry);
        click(&mut window, button);
        assert!(says(&window, title));
        click_last(&mut window, "Cancel");
        assert!(!says(&window, title), "{:?}", labels(&window));
        assert!(says(&window, back), "what asked still waits");
        press(&mut window, Modifiers::NONE, Key::Escape);
        assert!(!says(&window, back));
        assert!(!window.state().app.is_changed());
    }
}
