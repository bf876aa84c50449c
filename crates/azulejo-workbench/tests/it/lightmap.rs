//! Lightmaps: the dialog, the window, and the files.

use crate::window::*;
use azulejo::formats::gltf::patch;
use azulejo_workbench::app::App;
use azulejo_workbench::bake::{BakeSettings, LightmapFile};
use azulejo_workbench::command::{Command, FileRequest};
use azulejo_workbench::document::Edit;
use azulejo_workbench::script::{ScriptPlayer, parse};
use azulejo_workbench::variants::all;
use azulejo_workbench::view::Shading;
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use glam::{DAffine3, DVec3};
use std::path::PathBuf;

/// A quick lightmap.
fn bake(app: &mut App) {
    app.execute(Command::SetBake(BakeSettings {
        size: 64,
        error: 0.3,
        ..BakeSettings::default()
    }));
    app.execute(Command::Bake);
    finish(app);
}

fn finish(app: &mut App) {
    while !app.jobs().is_empty() {
        std::thread::sleep(std::time::Duration::from_millis(1));
        app.poll();
    }
}

fn open(path: PathBuf) -> App {
    let mut app = App::quiet();
    app.execute(Command::Open(vec![path]));
    finish(&mut app);
    app
}

#[test]
fn a_lightmap_is_baked_from_the_menu_and_looked_at() {
    let mut window = window(opened("cornell.grf"));
    press(&mut window, Modifiers::NONE, Key::F9);
    set(&mut window, "Page size", 64.0);
    set(&mut window, "Target error", 30.0);
    click_last(&mut window, "Bake");
    wait(&mut window);
    check_no_error(&window);
    let app = &window.state().app;
    assert_eq!(app.lightmap.settings.size, 64);
    assert!(app.lightmap.is_current);
    // Its window is open, and the viewport shows it.
    assert!(says(&window, "Texels per metre") && says(&window, "64 × 64"));
    assert_eq!(app.view.shading, Shading::Irradiance);
    assert!(app.lightmap.shown_in(Shading::Irradiance).is_some());
    for view in all() {
        window.state_mut().lightmap.view.quantity = view;
        window.run();
    }
    find(&window, Role::CheckBox, "In the viewport").click();
    window.run();
    let shown = |window: &TestWindow| {
        let lightmap = &window.state().app.lightmap;
        lightmap.shown_in(Shading::Irradiance).is_some()
    };
    assert!(!shown(&window));
    click(&mut window, "Save the error…");
    let request = FileRequest::SaveLightmap(LightmapFile::StandardError);
    assert_eq!(window.state().app.asking, Some(request));
}

#[test]
fn without_light_there_is_nothing_to_bake() {
    let mut app = opened("cornell.grf");
    let lamps: Vec<_> = app.document.objects.iter().map(|o| o.id).collect();
    app.execute(Command::Edit(Edit::Delete(lamps), None));
    let mut window = window(app);
    press(&mut window, Modifiers::NONE, Key::F9);
    assert!(!says(&window, "Page size"));
    window.state_mut().app.execute(Command::Bake);
    assert!(says(&window, "no light source") || window.state().app.errors == 1);
}

#[test]
fn a_lightmap_is_saved() {
    let folder = TestFolder::new("lightmap");
    let mut app = opened("cornell.grf");
    bake(&mut app);
    for (what, name) in [
        (LightmapFile::Model, "box.gltf"),
        (LightmapFile::Model, "model"),
        (LightmapFile::Irradiance, "e.exr"),
        (LightmapFile::StandardError, "se"),
    ] {
        app.execute(Command::SaveLightmap(what, folder.path(name)));
        finish(&mut app);
    }
    assert_eq!(app.errors, 0, "{:?}", app.messages);
    for name in ["e.exr", "se.exr"] {
        let bytes = std::fs::read(folder.path(name)).unwrap();
        assert!(bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]));
    }
    for name in ["box.gltf", "model.glb"] {
        let bytes = std::fs::read(folder.path(name)).unwrap();
        assert!(String::from_utf8_lossy(&bytes).contains("MOZ_lightmap"));
        // What was baked shows its light when it is opened.
        let again = open(folder.path(name));
        assert!(again.lightmap.result.is_none());
        assert!(again.lightmap.shown_in(Shading::FalseColor).is_some());
    }
    app.execute(Command::SaveLightmap(
        LightmapFile::Model,
        folder.path("e.exr"),
    ));
    finish(&mut app);
    assert_eq!(app.errors, 1);
}

/// A glTF file that was not edited keeps what it has; what was edited is written anew.
#[test]
fn a_gltf_file_stays_what_it_is() {
    let folder = TestFolder::new("lightmap-gltf");
    let mut app = opened("cornell.grf");
    app.execute(Command::Export(folder.path("box.glb")));
    finish(&mut app);
    let before = std::fs::read(folder.path("box.glb")).unwrap();
    let mut app = open(folder.path("box.glb"));
    bake(&mut app);
    let is_given = |app: &App| app.lightmap.result.as_ref().unwrap().source.is_given;
    assert!(is_given(&app));
    let baked = folder.path("baked.glb");
    app.execute(Command::SaveLightmap(LightmapFile::Model, baked.clone()));
    finish(&mut app);
    let stripped = patch::strip(&std::fs::read(&baked).unwrap(), "baked.glb").unwrap();
    assert!(stripped.is_exact && stripped.bytes == before);
    // The lightmap of a file is not light that is baked once more.
    let mut again = open(baked);
    bake(&mut again);
    assert!(is_given(&again));
    let mean = |app: &App| {
        app.lightmap
            .result
            .as_ref()
            .unwrap()
            .baked
            .lightmap
            .mean()
            .luminance()
    };
    assert!(
        (mean(&again) / mean(&app) - 1.0).abs() < 0.05,
        "{} {}",
        mean(&again),
        mean(&app)
    );
    let id = app.document.objects[0].id;
    let up = DAffine3::from_translation(DVec3::Y);
    app.execute(Command::Edit(Edit::Transform(vec![id], up), None));
    assert!(!app.lightmap.is_current);
    bake(&mut app);
    assert!(!is_given(&app) && app.lightmap.is_current);
    app.execute(Command::Undo);
    assert!(!app.lightmap.is_current);
}

#[test]
fn baking_is_cancelled() {
    let mut window = window(opened("cornell.grf"));
    let app = &mut window.state_mut().app;
    app.execute(Command::SetBake(BakeSettings {
        error: 0.001,
        ..BakeSettings::default()
    }));
    app.execute(Command::Bake);
    let job = app.jobs()[0].id;
    window.run_steps(3);
    find(&window, Role::Button, "✖").click();
    window.run();
    let app = &window.state().app;
    assert!(app.jobs().iter().all(|j| j.id != job));
    assert!(app.lightmap.result.is_none() && app.errors == 0);
}

#[test]
fn a_script_bakes_and_saves() {
    let folder = TestFolder::new("lightmap-script");
    let (model, map) = (folder.path("model.glb"), folder.path("map.exr"));
    let text = format!(
        "bake size=64 error=30% light=indirect as=mx\nlightmap density\nsave-lightmap {}\nsave-lightmap {}\n\
         lightmap none",
        model.display(),
        map.display()
    );
    let mut window = window(opened("cornell.grf"));
    let player = ScriptPlayer::new(parse(&text, "steps").unwrap(), "steps");
    let outcome = player.outcome();
    window.state_mut().play(player);
    while outcome.lock().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(1));
        window.step();
    }
    assert_eq!(*outcome.lock().unwrap(), Some(Ok(())));
    assert!(!window.state().lightmap.is_open);
    let bytes = std::fs::read(model).unwrap();
    assert!(String::from_utf8_lossy(&bytes).contains("MX_lightmap"));
    assert!(map.exists());
}
