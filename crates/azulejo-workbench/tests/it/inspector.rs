//! Properties of the selection.

use crate::window::*;
use azulejo::scene::{LightKind, Rgb, Shape};
use azulejo_workbench::app::App;
use azulejo_workbench::command::{Command, Selection};
use azulejo_workbench::document::{Edit, NewLightKind, NewShapeKind};
use egui::accesskit::Role;
use egui::{Key, Modifiers, vec2};
use glam::DVec3;

fn with_shape() -> TestWindow {
    let mut app = App::quiet();
    app.execute(Command::AddShape(NewShapeKind::Cuboid));
    window(app)
}

fn with_light(kind: NewLightKind) -> TestWindow {
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
    let placement = window.state().app.document.objects[0].placement;
    // The centre, at first half a unit above the ground, is where the position says; a corner is
    // turned and scaled about it, with its proportions.
    let centre = placement.transform_point3(DVec3::new(0.0, 0.5, 0.0));
    let corner = placement.transform_point3(DVec3::X);
    let is_near = |a: DVec3, b: [f64; 3]| (a - DVec3::from(b)).length() < 1e-9;
    assert!(is_near(centre, [3.0, 0.5, 0.0]), "{centre}");
    assert!(is_near(corner, [4.0, 2.5, 0.0]), "{corner}");
    assert_eq!(window.state().app.undo_labels().0, Some("move"));
    set(&mut window, "Scale y", 0.0);
    let after = window.state().app.document.objects[0].placement;
    assert_eq!(after, placement, "what flattens is refused");
    click(&mut window, "Reset transform");
    assert_eq!(
        window.state().app.document.objects[0].placement,
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
    assert_eq!(window.state().app.document.objects[0].name, "my crate");
    press(&mut window, Modifiers::NONE, Key::Enter);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(
        window.state().app.document.objects[0].name,
        "box",
        "all letters are one step"
    );
}

#[test]
fn several_things_move_together() {
    let mut app = opened("shapes.grf");
    app.execute(Command::Select(Selection {
        ids: app.document.objects.iter().map(|i| i.id).collect(),
        ..Selection::default()
    }));
    let before = app.document.bounds(None).centre();
    let mut window = window(app);
    set(&mut window, "Move by y", 1.5);
    set(&mut window, "Rotate by ° y", 90.0);
    set(&mut window, "Scale by", 2.0);
    assert!(!window.state().app.is_changed(), "not before it is applied");
    let size = window.state().app.document.bounds(None).size();
    click(&mut window, "Apply to all");
    let bounds = window.state().app.document.bounds(None);
    assert!((bounds.centre() - before - DVec3::new(0.0, 1.5, 0.0)).length() < 1e-6);
    let turned = 2.0 * DVec3::new(size.z, size.y, size.x);
    assert!(
        (bounds.size() - turned).length() < 1e-6,
        "{:?}",
        bounds.size()
    );
    check_no_error(&window);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert!(!window.state().app.is_changed(), "one step");
}

#[test]
fn a_spot_has_all_its_properties() {
    let mut window = with_light(NewLightKind::Spot);
    set(&mut window, "Intensity", 12.0);
    set(&mut window, "Inner angle", 40.0);
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
    set(&mut window, "Outer angle", 10.0);
    window.state().app.document.scene().validate().unwrap();
    check_no_error(&window);
}

#[test]
fn the_other_lights_have_theirs() {
    for (kind, label) in [
        (NewLightKind::Point, "Intensity"),
        (NewLightKind::Sun, "Irradiance"),
        (NewLightKind::Ambient, "Radiance"),
    ] {
        let mut window = with_light(kind);
        let amber = Rgb::new(1.0, 0.5, 0.25);
        shine(&mut window, amber * 2.0);
        set(&mut window, label, 7.0);
        check_shines(&window, amber * 7.0);
        // Off and on again: the colour is not lost.
        set(&mut window, label, 0.0);
        check_shines(&window, Rgb::BLACK);
        set(&mut window, label, 5.0);
        check_shines(&window, amber * 5.0);
        check_no_error(&window);
    }
}

/// The radiometric quantity of the first light.
fn shine_of(kind: &mut LightKind) -> &mut Rgb {
    match kind {
        LightKind::Point { intensity, .. } | LightKind::Spot { intensity, .. } => intensity,
        LightKind::Luminaire { scale, .. } => scale,
        LightKind::Directional { irradiance, .. } => irradiance,
        LightKind::Ambient { radiance } => radiance,
        LightKind::Environment(environment) => &mut environment.scale,
    }
}

/// Sets strength and colour of the first light.
fn shine(window: &mut TestWindow, color: Rgb) {
    let lamp = &window.state().app.document.lights[0];
    let (id, mut light) = (lamp.id, lamp.light.clone());
    *shine_of(&mut light.kind) = color;
    let command = Command::Edit(Edit::SetLight(id, light), None);
    window.state_mut().app.execute(command);
    window.run();
}

fn check_shines(window: &TestWindow, expected: Rgb) {
    let mut kind = window.state().app.document.lights[0].light.kind.clone();
    let shine = *shine_of(&mut kind);
    let differs = (shine - expected)
        .max_channel()
        .max((expected - shine).max_channel());
    assert!(differs < 1e-5, "{shine:?}, expected {expected:?}");
}

/// Opens a colour picker; returns the corner of its square of shades.
fn open_picker(window: &mut TestWindow, name: &str) -> egui::Pos2 {
    find(window, Role::ColorWell, name).click();
    window.run_steps(4);
    find(window, Role::SpinButton, "R").rect().left_bottom()
}

#[test]
fn a_colour_is_picked_and_the_strength_stays() {
    let mut app = App::quiet();
    app.execute(Command::AddLight(NewLightKind::Point));
    let mut window = window(app);
    shine(&mut window, Rgb::new(8.0, 4.0, 2.0));
    let square = open_picker(&mut window, "Emission colour");
    let shine = |window: &TestWindow| {
        let mut kind = window.state().app.document.lights[0].light.kind.clone();
        *shine_of(&mut kind)
    };
    assert_eq!(
        shine(&window),
        Rgb::new(8.0, 4.0, 2.0),
        "opened, not changed"
    );
    // A dark shade, held: it sets the hue and not the strength.
    window.drag_at(square + vec2(60.0, 200.0));
    window.run_steps(10);
    window.hover_at(square + vec2(240.0, 200.0));
    window.run_steps(10);
    let picked = shine(&window);
    assert!((picked.max_channel() - 8.0).abs() < 1e-5, "{picked:?}");
    assert!(picked.b < 1.0, "a fuller colour than before: {picked:?}");
    // The last move of the drag arrives with the release, in the same undo step.
    window.event(egui::Event::PointerMoved(square + vec2(20.0, 200.0)));
    window.drop_at(square + vec2(20.0, 200.0));
    window.run();
    assert!(shine(&window).b > 4.0, "{:?}", shine(&window));
    press(&mut window, Modifiers::NONE, Key::Escape);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(shine(&window), Rgb::new(8.0, 4.0, 2.0));
}

#[test]
fn what_is_typed_and_what_is_clicked_then_are_two_steps() {
    let mut window = with_shape();
    find(&window, Role::SpinButton, "Position x").focus();
    window.run();
    press(&mut window, Modifiers::COMMAND, Key::A);
    window.event(egui::Event::Text("3".into()));
    window.run();
    // A real click: its press ends typing.
    let button = find(&window, Role::Button, "Reset transform")
        .rect()
        .center();
    window.drag_at(button);
    window.step();
    window.drop_at(button);
    window.run();
    let place = |window: &TestWindow| window.state().app.document.objects[0].placement;
    assert_eq!(place(&window), glam::DAffine3::IDENTITY);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(place(&window).translation.x, 3.0);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(place(&window), glam::DAffine3::IDENTITY);
}

#[test]
fn looking_at_numbers_and_colours_changes_nothing() {
    let mut app = App::quiet();
    app.execute(Command::AddLight(NewLightKind::Spot));
    let mut window = window(app);
    let lamp = &window.state().app.document.lights[0];
    let (id, mut light) = (lamp.id, lamp.light.clone());
    if let LightKind::Spot {
        position,
        intensity,
        inner,
        ..
    } = &mut light.kind
    {
        position.x = 0.482_374_81;
        *intensity = Rgb::new(3e-7, 2e-7, 1e-7);
        *inner = 0.3;
    }
    window
        .state_mut()
        .app
        .execute(Command::Edit(Edit::SetLight(id, light), None));
    let revision = window.state().app.revision();
    for label in [
        "Position x",
        "Direction y",
        "Intensity",
        "Inner angle",
        "Outer angle",
    ] {
        find(&window, Role::SpinButton, label).focus();
        window.run();
        press(&mut window, Modifiers::NONE, Key::Enter);
        assert_eq!(window.state().app.revision(), revision, "{label}");
    }
    open_picker(&mut window, "Emission colour");
    assert_eq!(window.state().app.revision(), revision);
}

#[test]
fn numbers_of_cones_cameras_and_fog_are_typed_as_wholes() {
    let mut app = App::quiet();
    app.execute(Command::AddShape(NewShapeKind::Cone));
    let mut cone = window(app);
    type_slowly(&mut cone, "Top radius", "0.25");
    let Shape::Primitive(p) = &*cone.state().app.document.objects[0].shape else {
        panic!("a cone stays exact")
    };
    assert_eq!(p.kind, azulejo::scene::PrimitiveKind::Cone { top: 0.25 });
    press(&mut cone, Modifiers::COMMAND, Key::Z);
    assert_eq!(cone.state().app.undo_labels().0, Some("add a shape"));

    let mut camera = window(opened("shapes.grf"));
    click(&mut camera, "📷 door");
    type_slowly(&mut camera, "Field of view", "50");
    press(&mut camera, Modifiers::COMMAND, Key::Z);
    assert!(!camera.state().app.is_changed());

    click_last(&mut camera, "View");
    find(&camera, Role::CheckBox, "Fog in the scene").click();
    camera.run();
    type_slowly(&mut camera, "Visibility range", "12.5");
    assert_eq!(camera.state().app.document.fog.unwrap().visibility, 12.5);
    press(&mut camera, Modifiers::COMMAND, Key::Z);
    press(&mut camera, Modifiers::COMMAND, Key::Z);
    assert!(!camera.state().app.is_changed());
}

/// Types a number key by key.
fn type_slowly(window: &mut TestWindow, label: &str, number: &str) {
    find(window, Role::SpinButton, label).focus();
    window.run();
    press(window, Modifiers::COMMAND, Key::A);
    for key in number.chars() {
        window.event(egui::Event::Text(key.into()));
        window.run();
    }
    press(window, Modifiers::NONE, Key::Enter);
}

#[test]
fn a_camera_is_looked_through_and_takes_the_views_place() {
    let mut window = window(opened("shapes.grf"));
    click(&mut window, "📷 door");
    set(&mut window, "Viewpoint x", 1.25);
    set(&mut window, "Field of view", 50.0);
    let camera = window.state().app.document.cameras[0].camera.clone();
    assert_eq!(camera.eye.x, 1.25);
    assert!((camera.vertical_fov.to_degrees() - 50.0).abs() < 1e-9);
    click(&mut window, "View through camera");
    assert_eq!(window.state().app.view.camera.eye, camera.eye);
    press(&mut window, Modifiers::NONE, Key::Home);
    click(&mut window, "Move camera to view");
    let app = &window.state().app;
    assert_eq!(app.document.cameras[0].camera.eye, app.view.camera.eye);
    assert_eq!(app.document.cameras[0].camera.name, "door");
}

#[test]
fn a_material_is_assigned() {
    let mut window = window(opened("shapes.grf"));
    click(&mut window, "column");
    find(&window, Role::ComboBox, "Material").click();
    window.run();
    click_last(&mut window, "moss");
    let document = &window.state().app.document;
    let column = document
        .objects
        .iter()
        .find(|i| i.name == "column")
        .unwrap();
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
    click(&mut window, "Lumens");
    click_last(&mut window, "z");
    let units = window.state().app.document.units;
    assert!(units.photometric && units.up == azulejo::scene::Up::Z);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert!(!window.state().app.is_changed());
}

#[test]
fn a_luminaire_says_its_beam_and_is_turned_about_its_aim() {
    let folder = TestFolder::new("luminaire");
    let mut window = window(with_luminaire(&folder));
    let half = "Beam (half of the greatest): 60° × 30°";
    assert!(says(&window, half), "{:#?}", labels(&window));
    assert!(says(&window, "Field (a tenth): 108° × 54°"));
    let axis = |window: &TestWindow, y: bool| match window.state().app.document.lights[0].light.kind
    {
        LightKind::Luminaire { world_from_web, .. } if y => world_from_web.y_axis,
        LightKind::Luminaire { world_from_web, .. } => world_from_web.x_axis,
        _ => panic!("no luminaire"),
    };
    assert!((axis(&window, false) - DVec3::X).length() < 1e-12);
    set(&mut window, "Turn about the aim", 90.0);
    assert!((axis(&window, false) - DVec3::Y).length() < 1e-12);
    assert!((axis(&window, true) + DVec3::X).length() < 1e-12);
    // The same angle in another direction.
    set(&mut window, "Direction x", 1.0);
    set(&mut window, "Direction z", 0.0);
    let turned = find(&window, Role::SpinButton, "Turn about the aim").value();
    assert!(turned.is_some_and(|text| text.starts_with("90")));
    set(&mut window, "Turn about the aim", 0.0);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert!((axis(&window, false) - DVec3::Y).length() < 1e-9);
}
