//! The first minute with a model: examples, a studio, what is new comes into view, images, failures.

use super::*;
use crate::command::FileRequest;
use crate::document::{NewLightKind, NewShapeKind};
use crate::variants::all;
use crate::view::{Shading, sees_all};
use azulejo::scene::synthetic::cube_room;

fn room() -> App {
    let mut app = App::quiet();
    app.replace(SceneDocument::of_scene(cube_room(), None), None);
    app
}

#[test]
fn the_lamp_of_a_solid_hangs_outside_of_it_and_that_of_a_room_within() {
    let lamp = |app: &mut App| {
        app.execute(Command::AddShape(NewShapeKind::AreaLight));
        app.document.objects.last().unwrap().bounds()
    };
    for kind in [NewShapeKind::Cuboid, NewShapeKind::Sphere] {
        let mut app = App::quiet();
        app.execute(Command::AddShape(kind));
        let model = app.document.bounds(None);
        assert!(lamp(&mut app).min.y > model.max.y);
    }
    let mut app = room();
    let model = app.document.bounds(None);
    let hung = lamp(&mut app);
    assert!(
        model.min.y < hung.min.y && hung.max.y < model.max.y,
        "{hung:?}"
    );
}

#[test]
fn what_is_new_is_seen_and_selected() {
    let mut app = filled();
    for command in [
        Command::AddShape(NewShapeKind::AreaLight),
        Command::AddLight(NewLightKind::Spot),
        Command::AddShape(NewShapeKind::Cone),
    ] {
        app.execute(command);
        let ids = app.selection.ids.clone();
        assert_eq!(ids.len(), 1);
        assert!(sees_all(
            &app.view.camera,
            app.view.aspect,
            app.document.frame_of(&ids)
        ));
        assert!(!app.document.name(ids[0]).unwrap().is_empty());
    }
}

#[test]
fn a_studio_is_framed_by_its_model_and_not_by_its_floor() {
    let mut app = App::quiet();
    app.execute(Command::AddShape(NewShapeKind::Sphere));
    let model = app.document.bounds(None);
    edit(&mut app, Edit::AddStudio);
    assert_eq!(app.document.model_bounds(), model);
    assert!(app.document.bounds(None).diagonal() > 5.0 * model.diagonal());
    assert!(sees_all(&app.view.camera, app.view.aspect, model));
    // New shapes are as large as suits the model, too.
    assert!((app.default_size() - 0.25 * model.diagonal()).abs() < 1e-9);
    assert!(app.document.has_light());
    run(&mut app, Command::Solve);
    check_no_error(&app);
    assert!(app.lighting.is_current);
}

#[test]
fn files_that_are_opened_together_are_framed_together() {
    let folder = TestFolder::new("together");
    let write = |name: &str, x: f64| {
        let text = format!("v {x} 0 0\nv {} 0 0\nv {x} 1 0\nf 1 2 3\n", x + 1.0);
        std::fs::write(folder.path(name), text).unwrap();
        folder.path(name)
    };
    let paths = vec![write("a.obj", 0.0), write("b.obj", 100.0)];
    let mut app = App::quiet();
    run(&mut app, Command::Open(paths));
    check_no_error(&app);
    assert!(sees_all(
        &app.view.camera,
        app.view.aspect,
        app.document.bounds(None)
    ));
    // What is added later is brought into view as well, and selected.
    run(&mut app, Command::Add(vec![write("c.obj", 500.0)]));
    assert!(sees_all(
        &app.view.camera,
        app.view.aspect,
        app.document.bounds(None)
    ));
    assert_eq!(app.selection.ids, [app.document.objects[2].id]);
}

#[test]
fn the_light_of_a_file_is_shown() {
    let folder = TestFolder::new("lit");
    let mut app = filled();
    run(&mut app, Command::Solve);
    run(&mut app, Command::SaveAs(folder.path("lit.grf")));
    let mut again = App::quiet();
    run(&mut again, Command::Open(vec![folder.path("lit.grf")]));
    check_no_error(&again);
    assert!(again.lighting.solution.is_some());
    assert_eq!(again.view.shading, Shading::Irradiance);
}

#[test]
fn a_finer_mesh_is_said_and_that_of_the_model_can_be_kept() {
    let folder = TestFolder::new("finer");
    let path = folder.path("room.grf");
    let mut app = room();
    app.execute(Command::AddShape(NewShapeKind::AreaLight));
    let faces = app.document.face_count();
    run(&mut app, Command::Solve);
    run(&mut app, Command::SaveAs(path.clone()));
    let finer = app
        .finer_mesh
        .clone()
        .expect("patches are smaller than walls");
    assert_eq!((finer.model, &finer.path), (faces, &path));
    assert!(finer.saved > faces);
    run(&mut app, Command::KeepFaces);
    settle(&mut app);
    check_no_error(&app);
    assert_eq!(app.finer_mesh, None);
    let mut again = App::quiet();
    run(&mut again, Command::Open(vec![path]));
    assert_eq!(again.document.face_count(), faces);
    assert!(again.lighting.solution.is_some());
}

#[test]
fn an_image_that_is_stopped_stays_and_goes_on() {
    let mut app = filled();
    let render = Command::Render {
        width: 32,
        height: 24,
        paths: Some(1 << 15),
    };
    app.execute(render);
    let begin = Instant::now();
    while app.render.as_ref().is_none_or(|r| r.samples == 0) {
        assert!(begin.elapsed() < Duration::from_secs(300));
        std::thread::sleep(Duration::from_millis(1));
        app.poll();
    }
    // Saving one that is not finished asks first.
    app.execute(Command::RequestFile(FileRequest::SaveRender));
    assert_eq!(app.question, Some(PendingQuestion::UnfinishedRender));
    assert_eq!(app.asking, None);
    app.execute(Command::SaveUnfinishedRender);
    assert_eq!(app.asking, Some(FileRequest::SaveRender));
    app.execute(Command::DialogClosed);
    app.execute(Command::StopRender);
    let stopped = app.render.as_ref().unwrap().samples;
    assert!(stopped > 0 && !app.is_busy(JobKind::Render));
    assert!(app.render.as_ref().unwrap().time_left().is_some());
    app.execute(Command::ResumeRender);
    let begin = Instant::now();
    while app.render.as_ref().unwrap().samples == stopped {
        assert!(begin.elapsed() < Duration::from_secs(300));
        std::thread::sleep(Duration::from_millis(1));
        app.poll();
    }
    assert!(app.render.as_ref().unwrap().samples > stopped);
    app.execute(Command::CloseRender);
    assert!(app.render.is_none() && app.jobs().is_empty());
}

#[test]
fn a_file_without_a_model_is_a_failure_and_replaces_nothing() {
    let folder = TestFolder::new("nothing");
    let path = folder.path("notes.obj");
    std::fs::write(&path, "# A list of things to do\nv 0 0 0\n").unwrap();
    let mut app = filled();
    let before = app.document.objects.len();
    run(&mut app, Command::Open(vec![path.clone()]));
    assert!(
        app.failure
            .as_ref()
            .is_some_and(|f| f.contains("contains nothing"))
    );
    assert_eq!(app.document.objects.len(), before);
    assert!(!app.preferences.recent.contains(&path));
}

#[test]
fn a_failure_stays_until_it_is_seen_or_something_else_is_done() {
    let mut app = App::quiet();
    run(&mut app, Command::Open(vec!["/no/such.obj".into()]));
    assert!(app.failure.as_ref().is_some_and(|f| f.contains("such.obj")));
    app.execute(Command::Select(Selection::default()));
    assert!(app.failure.is_some(), "looking around is not an answer");
    app.execute(Command::DismissFailure);
    assert_eq!(app.failure, None);
}

#[test]
fn every_example_is_a_valid_scene_with_light_and_a_view() {
    for example in all() {
        let mut app = App::quiet();
        app.execute(Command::OpenExample(example));
        assert_eq!(app.errors, 0, "{:?}", app.messages);
        app.document.scene().validate().unwrap();
        assert!(app.document.has_light() && !app.document.cameras.is_empty());
        assert!(!app.is_changed(), "an example is nothing to save");
    }
}
