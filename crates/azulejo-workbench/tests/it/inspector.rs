//! Numbers of what is selected.

use crate::window::*;
use azulejo::scene::{LightKind, Shape};
use azulejo_workbench::app::App;
use azulejo_workbench::command::Command;
use azulejo_workbench::document::{NewKind, NewLightKind};
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use glam::DVec3;

fn with_shape() -> Window {
    let mut app = App::quiet();
    app.execute(Command::AddShape(NewKind::Cuboid));
    window(app)
}

fn with_light(kind: NewLightKind) -> Window {
    let mut app = App::quiet();
    app.execute(Command::AddLight(kind));
    window(app)
}

#[test]
fn a_box_is_moved_turned_and_scaled_by_numbers() {
    let mut window = with_shape();
    set(&mut window, "Position x", 3.0);
    set(&mut window, "Rotation ° z", 90.0);
    set(&mut window, "Scale x", 2.0);
    let placement = window.state().app.document.items[0].placement;
    let moved = placement.transform_point3(DVec3::X);
    assert!(
        (moved - DVec3::new(3.0, 2.0, 0.0)).length() < 1e-9,
        "{moved}"
    );
    assert_eq!(window.state().app.undo_labels().0, Some("move"));
    set(&mut window, "Scale y", 0.0);
    let after = window.state().app.document.items[0].placement;
    assert_eq!(after, placement, "what flattens is refused");
    click(&mut window, "Back to where it was made");
    assert_eq!(
        window.state().app.document.items[0].placement,
        glam::DAffine3::IDENTITY
    );
    for _ in 0..4 {
        press(&mut window, Modifiers::COMMAND, Key::Z);
    }
    assert_eq!(window.state().app.undo_labels().0, Some("add a shape"));
}

#[test]
fn a_name_of_two_words_is_written() {
    let mut window = with_shape();
    write(&mut window, "box", "my");
    window.event(egui::Event::Text(" ".into()));
    window.run();
    window.event(egui::Event::Text("crate".into()));
    window.run();
    assert_eq!(window.state().app.document.items[0].name, "my crate");
    press(&mut window, Modifiers::NONE, Key::Enter);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(
        window.state().app.document.items[0].name,
        "box",
        "all letters are one step"
    );
}

#[test]
fn several_things_move_together() {
    let mut app = opened("shapes.grf");
    app.execute(Command::SelectAll);
    let before = app.document.bounds(None).centre();
    let mut window = window(app);
    set(&mut window, "Move by y", 1.5);
    let after = window.state().app.document.bounds(None).centre();
    assert!((after - before - DVec3::new(0.0, 1.5, 0.0)).length() < 1e-9);
}

#[test]
fn a_spot_has_all_its_properties() {
    let mut window = with_light(NewLightKind::Spot);
    set(&mut window, "Intensity", 12.0);
    set(&mut window, "Full inside", 40.0);
    set(&mut window, "Position y", 2.0);
    set(&mut window, "Direction x", 1.0);
    let LightKind::Spot {
        position,
        direction,
        intensity,
        inner,
        outer,
    } = window.state().app.document.lights[0].light.kind
    else {
        panic!("a spot stays a spot")
    };
    assert!((intensity.max_channel() - 12.0).abs() < 1e-5);
    assert!((inner.to_degrees() - 40.0).abs() < 1e-9);
    assert!(outer >= inner, "the inner pushes the outer");
    assert_eq!(position.y, 2.0);
    assert!((direction.length() - 1.0).abs() < 1e-9 && direction.x > 0.5);
    set(&mut window, "None outside", 10.0);
    window.state().app.document.scene().validate().unwrap();
    check_no_error(&window);
}

#[test]
fn the_other_lights_have_theirs() {
    for (kind, label) in [
        (NewLightKind::Point, "Intensity"),
        (NewLightKind::Directional, "Irradiance"),
        (NewLightKind::Ambient, "Radiance"),
    ] {
        let mut window = with_light(kind);
        set(&mut window, label, 7.0);
        let strength = match window.state().app.document.lights[0].light.kind {
            LightKind::Point { intensity, .. } => intensity,
            LightKind::Directional { irradiance, .. } => irradiance,
            LightKind::Ambient { radiance } => radiance,
            LightKind::Spot { .. } => panic!("none was added"),
        };
        assert!((strength.max_channel() - 7.0).abs() < 1e-5, "{kind:?}");
        // Dark and bright again: the colour is not lost in between.
        set(&mut window, label, 0.0);
        set(&mut window, label, 5.0);
        check_no_error(&window);
    }
}

#[test]
fn a_camera_is_looked_through_and_takes_the_views_place() {
    let mut window = window(opened("shapes.grf"));
    click(&mut window, "📷 door");
    set(&mut window, "Eye x", 1.25);
    set(&mut window, "Field of view", 50.0);
    let camera = window.state().app.document.cameras[0].camera.clone();
    assert_eq!(camera.eye.x, 1.25);
    assert!((camera.vertical_fov.to_degrees() - 50.0).abs() < 1e-9);
    click(&mut window, "Look through it");
    assert_eq!(window.state().app.view.camera.eye, camera.eye);
    press(&mut window, Modifiers::NONE, Key::Home);
    click(&mut window, "Take the view's place");
    let app = &window.state().app;
    assert_eq!(app.document.cameras[0].camera.eye, app.view.camera.eye);
    assert_eq!(app.document.cameras[0].camera.name, "door");
}

#[test]
fn a_material_is_assigned() {
    let mut window = window(opened("shapes.grf"));
    click(&mut window, "column");
    find(&window, Role::ComboBox, "Made of").click();
    window.run();
    click_last(&mut window, "moss");
    let document = &window.state().app.document;
    let column = document.items.iter().find(|i| i.name == "column").unwrap();
    let material = column.materials()[0] as usize;
    assert_eq!(document.materials[material].name, "moss");
    assert!(matches!(&*column.shape, Shape::Primitive(_)));
    assert_eq!(
        window.state().app.undo_labels().0,
        Some("assign a material")
    );
}

#[test]
fn units_say_what_numbers_mean() {
    let mut window = window(opened("shapes.grf"));
    click(&mut window, "lumens");
    click_last(&mut window, "z");
    let units = window.state().app.document.units;
    assert!(units.photometric && units.up == azulejo::scene::Up::Z);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert!(!window.state().app.is_changed());
}
