//! File dialogs, questions about unsaved changes, and a complete session.

use crate::window::*;
use azulejo::scene::{PrimitiveKind, Scene, Shape};
use azulejo_workbench::app::{App, Severity};
use azulejo_workbench::command::Command;
use azulejo_workbench::document::NewShapeKind;
use azulejo_workbench::first_pass::LightSettings;
use azulejo_workbench::script::{ScriptPlayer, parse};
use azulejo_workbench::ui::PanelTab;
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::NodeT;
use std::path::Path;

/// The dialog shows the folder of the last opened file.
fn dialog_in(folder: &TestFolder) -> TestWindow {
    let mut app = App::quiet();
    app.execute(Command::Open(vec![folder.copy("shapes.grf")]));
    let mut window = window(app);
    wait(&mut window);
    window
}

fn file_of(window: &TestWindow) -> Option<&Path> {
    window.state().app.file.as_ref().map(|f| f.path.as_path())
}

/// Makes a change.
fn change(window: &mut TestWindow) {
    press(window, Modifiers::COMMAND, Key::L);
    assert!(window.state().app.is_changed());
}

#[test]
fn a_file_is_opened_by_its_name() {
    let folder = TestFolder::new("typed");
    let mut window = dialog_in(&folder);
    let cornell = folder.copy("cornell.grf");
    press(&mut window, Modifiers::COMMAND, Key::O);
    assert!(says(&window, "Open models"));
    write(&mut window, "", "cornell.grf");
    press(&mut window, Modifiers::NONE, Key::Enter);
    wait(&mut window);
    check_no_error(&window);
    assert_eq!(file_of(&window), Some(&*cornell));
    assert!(!says(&window, "Open models"), "the dialog is done");
    assert_eq!(window.state().app.asking, None);
}

#[test]
fn a_recipe_is_chosen_in_the_menu_and_undone() {
    let folder = TestFolder::new("recipe");
    let mut window = dialog_in(&folder);
    let before = window.state().app.document.clone();
    let rule = "[[material]]\nname = \"moss\"\ndiffuse = 0.125\n";
    std::fs::write(folder.path("dark.toml"), rule).unwrap();
    click(&mut window, "File");
    click(&mut window, "Apply recipe…");
    assert!(says(&window, "Choose a recipe"));
    write(&mut window, "", "dark.toml");
    press(&mut window, Modifiers::NONE, Key::Enter);
    wait(&mut window);
    check_no_error(&window);
    let mut materials = window.state().app.document.materials.iter();
    let moss = materials.find(|m| m.name == "moss").unwrap();
    assert_eq!(moss.diffuse, azulejo::scene::Rgb::grey(0.125));
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(window.state().app.document, before);
}

#[test]
fn a_file_is_added_whatever_its_name_and_a_dialog_can_be_left() {
    let folder = TestFolder::new("added");
    std::fs::copy(example("cornell.grf"), folder.path("model.backup")).unwrap();
    let mut window = dialog_in(&folder);
    let both = Modifiers::COMMAND | Modifiers::SHIFT;
    press(&mut window, both, Key::O);
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert_eq!(window.state().app.asking, None);
    press(&mut window, both, Key::O);
    write(&mut window, "", "model.backup");
    click_last(&mut window, "Open");
    wait(&mut window);
    check_no_error(&window);
    let source_files = &window.state().app.document.source_files;
    assert_eq!(source_files.len(), 2);
    assert!(!says(&window, "Add models"));
}

#[test]
fn a_file_is_not_written_over_without_asking() {
    let folder = TestFolder::new("replace");
    let other = folder.copy("cornell.grf");
    let before = std::fs::read(&other).unwrap();
    let mut window = dialog_in(&folder);
    let save_as = |window: &mut TestWindow| {
        press(window, Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
        write(window, "shapes.grf", "cornell.grf");
        click_last(window, "Save");
        assert!(says(window, "A file with this name already exists"));
    };
    save_as(&mut window);
    click_last(&mut window, "Cancel");
    wait(&mut window);
    assert_eq!(std::fs::read(&other).unwrap(), before);
    assert!(!says(&window, "Save as GRF") && window.state().app.asking.is_none());
    save_as(&mut window);
    click_last(&mut window, "Replace");
    wait(&mut window);
    check_no_error(&window);
    assert_eq!(file_of(&window), Some(&*other));
    assert_ne!(std::fs::read(&other).unwrap(), before);
}

#[test]
fn the_question_about_changes_has_three_answers() {
    let folder = TestFolder::new("question");
    let mut window = dialog_in(&folder);
    change(&mut window);
    let ask = |window: &mut TestWindow| {
        press(window, Modifiers::COMMAND, Key::Q);
        assert!(says(window, "Unsaved changes"));
        assert!(!window.state().app.closing);
    };
    ask(&mut window);
    click_last(&mut window, "Cancel");
    assert!(!says(&window, "Unsaved changes"));
    ask(&mut window);
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert!(!says(&window, "Unsaved changes"));
    ask(&mut window);
    click_last(&mut window, "Save");
    wait(&mut window);
    check_no_error(&window);
    assert!(window.state().app.closing && !window.state().app.is_changed());

    let mut window = dialog_in(&folder);
    change(&mut window);
    press(&mut window, Modifiers::COMMAND, Key::N);
    click_last(&mut window, "Don't save");
    assert!(window.state().app.document.is_empty() && !window.state().app.is_changed());
}

#[test]
fn a_file_that_others_wrote_is_asked_about_when_the_window_is_looked_at_again() {
    let folder = TestFolder::new("others");
    let mut window = dialog_in(&folder);
    let focus = |window: &mut TestWindow, focused: bool| {
        let viewport = window.input_mut().viewports.values_mut().next().unwrap();
        viewport.focused = Some(focused);
        window.run();
    };
    focus(&mut window, false);
    std::fs::copy(example("csg.grf"), folder.path("shapes.grf")).unwrap();
    focus(&mut window, true);
    assert!(says(&window, "The file has changed on disk"));
    let many = window.state().app.document.objects.len();
    click_last(&mut window, "Reload");
    wait(&mut window);
    assert_ne!(window.state().app.document.objects.len(), many);
    assert!(!says(&window, "The file has changed on disk"));
}

#[test]
fn what_fails_is_told_and_the_work_stays() {
    let folder = TestFolder::new("fails");
    let mut window = dialog_in(&folder);
    change(&mut window);
    let before = window.state().app.document.clone();
    std::fs::write(folder.path("bad.obj"), "f 1 2 3").unwrap();
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::O);
    write(&mut window, "", "bad.obj");
    press(&mut window, Modifiers::NONE, Key::Enter);
    wait(&mut window);
    assert!(says(&window, "bad.obj"));
    let errors = window
        .state()
        .app
        .messages
        .iter()
        .filter(|m| m.level == Severity::Error);
    assert_eq!(errors.count(), 1);
    assert_eq!(window.state().app.document, before);
}

/// A job that waits for its input: a pipe.
#[cfg(unix)]
#[test]
fn work_that_does_not_know_how_much_it_is_shows_no_share() {
    let folder = TestFolder::new("piped");
    let pipe = folder.path("pipe.grf");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.unwrap().success());
    let mut window = dialog_in(&folder);
    let open = Command::Open(vec![pipe.clone()]);
    window.state_mut().app.execute(open);
    // Both ends of the pipe are open from here on, and it is empty.
    let mut writer = std::fs::File::options().write(true).open(pipe).unwrap();
    let is_reading = |window: &TestWindow| {
        let jobs = window.state().app.jobs();
        jobs[0].progress.stage() == "reading"
    };
    while !is_reading(&window) {
        std::thread::yield_now();
    }
    window.run_steps(2);
    let bar = find(&window, Role::ProgressIndicator, "reading");
    assert_eq!(bar.accesskit_node().numeric_value(), None);
    let text = std::fs::read(example("cornell.grf")).unwrap();
    std::io::Write::write_all(&mut writer, &text).unwrap();
    drop(writer);
    wait(&mut window);
    check_no_error(&window);
    assert_eq!(window.state().app.document.source_files[0].name, "pipe");
}

/// A save that waits for its reader: a pipe.
#[cfg(unix)]
#[test]
fn changes_made_while_a_window_waits_to_close_are_asked_about() {
    let folder = TestFolder::new("closing");
    let pipe = folder.path("pipe.grf");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.unwrap().success());
    let mut window = dialog_in(&folder);
    window.state_mut().rescue_to(std::sync::mpsc::channel().0);
    window
        .state_mut()
        .app
        .execute(Command::Export(pipe.clone()));
    window.state_mut().app.execute(Command::Quit);
    window.run_steps(3);
    assert!(window.state().app.closing, "it waits");
    let shape = Command::AddShape(NewShapeKind::Cuboid);
    window.state_mut().app.execute(shape);
    let reader = std::thread::spawn(move || std::fs::read(pipe).unwrap());
    wait(&mut window);
    assert!(!reader.join().unwrap().is_empty());
    assert!(says(&window, "Unsaved changes"));
    assert!(!window.state().app.closing);
    click_last(&mut window, "Don't save");
    assert!(window.state().app.closing);
}

/// A complete session, from the first click to the last.
#[test]
fn a_model_is_opened_lit_given_a_reflection_model_solved_saved_and_comes_back() {
    let folder = TestFolder::new("session");
    let mut window = dialog_in(&folder);
    press(&mut window, Modifiers::COMMAND, Key::L);
    find_material(&mut window);
    let model = "material brdf ward_duer ks=0.3 kd=0.4 ax=0.1 ay=0.3";
    let steps = parse(model, "test").unwrap();
    window.state_mut().play(ScriptPlayer::new(steps, "test"));
    window.run_steps(12);
    window
        .state_mut()
        .app
        .execute(Command::SetLight(LightSettings {
            patches: 60,
            error: 0.2,
            ..LightSettings::default()
        }));
    window.state_mut().tab = PanelTab::Light;
    click(&mut window, "Solve");
    wait(&mut window);
    check_no_error(&window);
    assert!(window.state().app.lighting.is_current);
    press(&mut window, Modifiers::COMMAND, Key::S);
    wait(&mut window);
    check_no_error(&window);
    assert!(!window.state().app.is_changed());

    let mut again = App::quiet();
    again.execute(Command::Open(vec![folder.path("shapes.grf")]));
    let mut again = crate::window::window(again);
    wait(&mut again);
    check_no_error(&again);
    let scene = |window: &TestWindow| {
        let app = &window.state().app;
        app.document.lit_scene(app.lighting.solution.as_deref())
    };
    let (first, second) = (scene(&window), scene(&again));
    assert!(first.1 && second.1, "both are lit");
    assert_eq!(first.0.materials, second.0.materials);
    assert_eq!(without_depth(first.0), without_depth(second.0));
}

/// The same with unit normals as the third axes of parallelograms, which have no depth: `light` of
/// GRF says only its edges.
fn without_depth(mut scene: Scene) -> Scene {
    for object in &mut scene.objects {
        if let Shape::Primitive(p) = &mut object.shape
            && p.kind == PrimitiveKind::Square
        {
            let axes = &mut p.world_from_object.matrix3;
            axes.z_axis = axes.x_axis.cross(axes.y_axis).normalize();
        }
    }
    scene
}

/// Selects the clay in the tree.
fn find_material(window: &mut TestWindow) {
    click_last(window, "clay");
    assert!(window.state().app.selection.material.is_some());
}
