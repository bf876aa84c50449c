//! The start screen, and the cards over the model.

use crate::window::*;
use azulejo_workbench::app::App;
use azulejo_workbench::command::Command;
use azulejo_workbench::view::Shading;
use azulejo_workbench::words::Language;
use egui::{Key, Modifiers};

#[test]
fn an_empty_window_offers_examples_and_what_comes_next() {
    let mut window = window(App::quiet());
    for text in ["or drop files here", "Examples", "From a model to an image"] {
        assert!(says(&window, text), "{text}");
    }
    click(&mut window, "Cornell box");
    wait(&mut window);
    assert!(!window.state().app.document.is_empty());
    assert!(!says(&window, "or drop files here"));
}

/// A model, a studio and the light, each by the card that offers it.
#[test]
fn each_card_offers_what_the_model_lacks() {
    let mut app = App::quiet();
    app.execute(Command::AddShape(
        azulejo_workbench::document::NewShapeKind::Sphere,
    ));
    app.lighting.settings.patches = 50;
    app.lighting.settings.error = 0.5;
    let mut window = window(app);
    assert!(says(&window, "There is no light source yet."));
    click_last(&mut window, "Studio");
    assert!(window.state().app.document.has_light());
    assert!(says(&window, "The light is not solved yet."));
    click_last(&mut window, "Solve");
    wait(&mut window);
    assert!(window.state().app.lighting.is_current);
    assert!(!says(&window, "The light is not solved yet."));
    assert_eq!(window.state().app.view.shading, Shading::Irradiance);
    // An edit makes the light old, which is said with a way out.
    window.state_mut().app.execute(Command::AddShape(
        azulejo_workbench::document::NewShapeKind::Cone,
    ));
    window.run();
    assert!(says(
        &window,
        "This light is from an earlier state of the model."
    ));
}

/// While the solver runs, nobody is told to start it.
#[test]
fn progress_is_said_in_the_view() {
    let mut app = opened("cornell.grf");
    app.lighting.settings.patches = 20_000;
    app.lighting.settings.error = 0.001;
    let mut window = window(app);
    window.key_press_modifiers(Modifiers::NONE, Key::F5);
    // It does not settle while the solver runs.
    window.run_steps(4);
    assert!(says(&window, "Solving the light"));
    assert!(!says(&window, "not solved yet"));
    find(&window, egui::accesskit::Role::Button, "Pause");
    window.state_mut().app.execute(Command::StopSolving);
    window.run_ok();
    assert!(window.state().app.jobs().is_empty());
}

#[test]
fn a_failure_is_said_in_the_middle_in_the_language_of_the_window() {
    let mut app = App::quiet();
    app.preferences.language = Language::Spanish;
    app.execute(Command::Open(vec!["/no/such.obj".into()]));
    let mut window = window(app);
    wait(&mut window);
    assert!(says(&window, "/no/such.obj: el archivo no existe"));
    click_last(&mut window, "Cerrar");
    assert!(window.state().app.failure.is_none());
}

#[test]
fn an_image_is_left_by_its_card_and_by_a_key() {
    let mut window = window(opened("cornell.grf"));
    for way in 0..2 {
        let render = Command::Render {
            width: 8,
            height: 8,
            paths: Some(1),
        };
        window.state_mut().app.execute(render);
        wait(&mut window);
        assert!(says(&window, "1 / 1 paths per pixel"));
        match way {
            0 => click_last(&mut window, "Back to the model"),
            _ => press(&mut window, Modifiers::NONE, Key::Escape),
        }
        assert!(window.state().app.render.is_none());
    }
}

#[test]
fn two_modes_are_compared_and_the_divider_moves_by_keys() {
    let mut window = window(opened("cornell.grf"));
    press(&mut window, Modifiers::NONE, Key::C);
    let at = |window: &TestWindow| window.state().app.view.comparison.map(|c| c.at);
    assert_eq!(at(&window), Some(0.5));
    find(
        &window,
        egui::accesskit::Role::Slider,
        "Divider between the two images",
    )
    .focus();
    window.run();
    press(&mut window, Modifiers::NONE, Key::ArrowRight);
    assert!(at(&window).is_some_and(|at| at > 0.51));
    press(&mut window, Modifiers::NONE, Key::C);
    assert_eq!(at(&window), None);
}

/// A solution that a deadline ended early does not look like one that is done.
#[test]
fn light_that_is_less_accurate_than_asked_for_says_so() {
    let mut app = opened("cornell.grf");
    app.lighting.settings.error = 0.001;
    app.lighting.settings.time = Some(4.0);
    let mut window = window(app);
    window.state_mut().app.execute(Command::Solve);
    wait(&mut window);
    // With an error, or as a preview that was left, depending on how far it came.
    let warns = |window: &TestWindow| {
        says(window, "less accurate than the target") || says(window, "Stopped early")
    };
    assert!(warns(&window));
    let button = "Solve without a time limit";
    assert!(says(&window, button));
    click_last(&mut window, "Close");
    // Behind the failure of a busy machine lies the preview, which says it too.
    if says(&window, button) {
        click_last(&mut window, "Close");
    }
    assert!(!says(&window, button));
    assert!(window.state().app.lighting.is_current);
}
