use super::*;
use crate::command::Command;
use crate::document::Edit;
use crate::first_pass::LightSettings;
use azulejo::scene::{Light, LightKind, Material, Mesh, Object, Primitive, Rgb, Scene, Shape};
use glam::{DAffine3, DVec3};
use std::f64::consts::PI;
use std::time::{Duration, Instant};

/// Longer than any job of a test takes, even on a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// A horizontal rectangle that faces up, or down.
fn rectangle(min: [f64; 2], max: [f64; 2], height: f64, is_up: bool, material: u32) -> Shape {
    let mut mesh = Mesh::default();
    let corners = [
        [min[0], min[1]],
        [min[0], max[1]],
        [max[0], max[1]],
        [max[0], min[1]],
    ];
    mesh.positions = corners.map(|[x, z]| DVec3::new(x, height, z)).to_vec();
    let order = if is_up { [0, 1, 2, 3] } else { [3, 2, 1, 0] };
    mesh.push_face(&order, material);
    Shape::Mesh(mesh)
}

/// A black floor of 5 m by 4 m.
fn floor() -> Scene {
    let mut scene = Scene::default();
    let black = scene.add_material(Material::diffuse("black", Rgb::BLACK));
    let shape = rectangle([0.0, 0.0], [5.0, 4.0], 0.0, true, black);
    scene.objects.push(Object::new("floor", shape));
    scene
}

fn sky(scene: &mut Scene, radiance: f64) {
    scene.lights.push(Light {
        name: "sky".to_owned(),
        kind: LightKind::Ambient {
            radiance: Rgb::grey(radiance),
        },
    });
}

fn measured(scene: Scene, settings: TaskPlaneSettings) -> App {
    let mut app = App::quiet();
    app.document = SceneDocument::of_scene(scene, None);
    app.execute(Command::SetLight(LightSettings {
        patches: 200,
        error: 0.05,
        ..LightSettings::default()
    }));
    app.execute(Command::SetTaskPlane(settings));
    app.execute(Command::MeasureTaskPlane);
    wait(&mut app);
    app
}

fn wait(app: &mut App) {
    let begin = Instant::now();
    while !app.jobs().is_empty() {
        assert!(begin.elapsed() < PATIENCE, "a job does not end");
        std::thread::sleep(Duration::from_millis(1));
        app.poll();
    }
}

#[test]
fn a_uniform_sky_lights_all_of_it_by_pi() {
    let mut scene = floor();
    sky(&mut scene, 2.0);
    let app = measured(scene, TaskPlaneSettings::default());
    let plane = app.task_plane.result.as_ref().expect("it is measured");
    assert_eq!(plane.cells.iter().flatten().count(), 16 * 12);
    let figures = plane.figures().expect("figures");
    for (value, error) in [figures.least, figures.mean, figures.most] {
        let off = (value - 2.0 * PI).abs();
        assert!(off < 1e-3 + 4.0 * error, "{figures:?}");
    }
    assert!((figures.uniformity.0 - 1.0).abs() < 0.01, "{figures:?}");
    // The centres lie at the height of a desk, half a metre from the edges.
    let places: Vec<DVec3> = plane.grid.centres().map(|c| c.1).collect();
    assert_eq!(places[0], DVec3::new(0.5 + 0.125, 0.8, 0.5 + 0.125));
    let last = places[places.len() - 1];
    assert!(
        (last - DVec3::new(4.375, 0.8, 3.375)).length() < 1e-9,
        "{last}"
    );
}

#[test]
fn a_small_lamp_lights_it_by_the_fourth_power_of_the_cosine() {
    let mut scene = floor();
    let (radiance, side) = (1000.0, 0.1);
    let lamp = scene.add_material(Material::emitter("lamp", Rgb::grey(radiance)));
    let [low, high] = [-0.5, 0.5].map(|k| [2.5 + k * side, 2.0 + k * side]);
    let shape = rectangle(low, high, 2.8, false, lamp);
    scene.objects.push(Object::new("lamp", shape));
    let settings = TaskPlaneSettings {
        counts: [7, 5],
        ..TaskPlaneSettings::default()
    };
    let app = measured(scene, settings);
    let plane = app.task_plane.result.as_ref().expect("it is measured");
    let lamp = DVec3::new(2.5, 2.8, 2.0);
    for ((_, centre), cell) in plane.grid.centres().zip(&plane.cells) {
        let to = lamp - centre;
        let expected = radiance * side * side * to.y * to.y / to.length_squared().powi(2);
        let estimate = cell.expect("nothing is in the way");
        let (value, error) = (estimate.value.luminance(), estimate.error.luminance());
        let off = (value - expected).abs();
        assert!(
            off < 2e-3 * expected + 4.0 * error,
            "{centre}: {value} {expected}"
        );
    }
    let figures = plane.figures().expect("figures");
    // Farthest from the lamp is a corner: 12/7 m and 1.2 m aside, 2 m below.
    let far = (4.0 / (4.0 + (12.0f64 / 7.0).powi(2) + 1.44)).powi(2);
    assert!(
        (figures.diversity.0 - far).abs() < 0.02,
        "{figures:?} {far}"
    );
    assert!(figures.uniformity.0 > figures.diversity.0);
}

#[test]
fn points_in_solids_are_left_out_and_those_below_shelves_are_not() {
    let mut scene = floor();
    sky(&mut scene, 1.0);
    let ball = Primitive::sphere(DVec3::new(2.5, 0.8, 2.0), 0.75, 0);
    let shelf = rectangle([0.0, 0.0], [1.0, 1.0], 1.5, true, 0);
    scene
        .objects
        .push(Object::new("ball", Shape::Primitive(ball)));
    scene.objects.push(Object::new("shelf", shelf));
    let app = measured(scene, TaskPlaneSettings::default());
    let plane = app.task_plane.result.as_ref().expect("it is measured");
    for ((_, centre), cell) in plane.grid.centres().zip(&plane.cells) {
        let is_inside = centre.distance(DVec3::new(2.5, 0.8, 2.0)) < 0.75;
        assert_eq!(cell.is_none(), is_inside, "{centre}");
    }
}

#[test]
fn an_edit_forgets_it_and_undo_does_not_bring_it_back_wrong() {
    let mut scene = floor();
    sky(&mut scene, 1.0);
    let mut app = measured(scene, TaskPlaneSettings::default());
    let id = app.document.objects[0].id;
    let away = DAffine3::from_translation(DVec3::X);
    app.execute(Command::Edit(Edit::SetPlacement(id, away), None));
    assert!(app.task_plane.result.is_none() && app.task_plane.is_added);
    app.execute(Command::RemoveTaskPlane);
    assert!(!app.task_plane.is_added);
}

#[test]
fn its_table_has_a_row_for_each_point() {
    let mut scene = floor();
    sky(&mut scene, 1.0);
    let settings = TaskPlaneSettings {
        counts: [3, 2],
        ..TaskPlaneSettings::default()
    };
    let mut app = measured(scene, settings);
    let name = format!("azulejo-task-plane-{}.csv", std::process::id());
    let path = std::env::temp_dir().join(name);
    app.execute(Command::SaveTaskPlane(path.clone()));
    wait(&mut app);
    let text = std::fs::read_to_string(&path).expect("a table");
    let _ = std::fs::remove_file(path);
    let rows: Vec<&str> = text.split_terminator("\r\n").collect();
    assert_eq!(rows.len(), 7, "{text}");
    assert!(rows[6].starts_with("3,2,") && rows[6].ends_with(",W/m²"));
}

#[test]
fn it_suits_rooms_and_small_models() {
    let mut app = App::quiet();
    app.document = SceneDocument::of_scene(floor(), None);
    app.execute(Command::AddTaskPlane);
    assert_eq!(app.task_plane.settings, TaskPlaneSettings::default());
    app.execute(Command::RemoveTaskPlane);
    app.document.units.metres_per_unit = Some(0.1);
    app.execute(Command::AddTaskPlane);
    let settings = app.task_plane.settings;
    assert_eq!((settings.height, settings.margin), (0.0, 0.04));
    assert!(TaskGrid::of(&app.document, &settings).is_some());
}

#[test]
fn a_margin_that_leaves_nothing_is_refused() {
    let mut scene = floor();
    sky(&mut scene, 1.0);
    let settings = TaskPlaneSettings {
        margin: 2.0,
        ..TaskPlaneSettings::default()
    };
    let app = measured(scene, settings);
    assert!(app.task_plane.result.is_none() && app.failure.is_some());
}
