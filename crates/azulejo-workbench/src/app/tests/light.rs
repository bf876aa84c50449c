//! The light of the document, and renders of it.

use super::*;
use crate::document::tests::solved;
use crate::first_pass::LightSettings;
use azulejo::formats::read_picture;
use azulejo::scene::{Backplate, BackplateFit, SceneBackground};

/// The sample, solved with minimal effort.
fn lit() -> App {
    let mut app = filled();
    app.execute(Command::SetLight(LightSettings {
        patches: 30,
        error: 0.5,
        ..LightSettings::default()
    }));
    run(&mut app, Command::Solve);
    check_no_error(&app);
    app
}

#[test]
fn solving_lights_the_document_and_edits_make_it_old() {
    let mut app = lit();
    assert!(app.lighting.is_current && app.is_changed());
    let range = app.lighting.range.expect("something is lit");
    assert!(range.high > 0.0 && range.low <= range.usual && range.usual <= range.high);
    let solution = app.lighting.solution.as_ref().unwrap();
    assert!(solution.report.is_some());
    edit(&mut app, Edit::Hide(vec![ItemId(1)], true));
    assert!(app.lighting.is_current);
    edit(&mut app, Edit::Delete(vec![ItemId(3)]));
    assert!(!app.lighting.is_current);
    app.execute(Command::Undo);
    assert!(app.lighting.is_current);
    app.execute(Command::ClearLight);
    assert!(app.lighting.solution.is_none() && !app.lighting.is_current);
}

#[test]
fn light_that_is_not_saved_is_a_change_though_the_edits_are_undone() {
    let mut app = filled();
    edit(&mut app, Edit::Hide(vec![ItemId(1)], true));
    let solution = solved(&app.document);
    app.take_light(solution);
    app.execute(Command::Undo);
    assert!(app.lighting.is_current && app.is_changed());
}

#[test]
fn light_of_another_state_does_not_take_the_place_of_true_light() {
    let mut app = filled();
    app.take_light(solved(&app.document));
    let first = app.lighting.solution.clone().unwrap();
    edit(&mut app, Edit::Delete(vec![ItemId(3)]));
    let second = solved(&app.document);
    app.execute(Command::Undo);
    app.take_light(second);
    assert!(app.lighting.is_current);
    assert!(Arc::ptr_eq(app.lighting.solution.as_ref().unwrap(), &first));
    // Nor is it lost: its state may be restored, and then it counts as another solution than
    // before.
    let before = app.state();
    app.execute(Command::Redo);
    assert!(app.lighting.is_current && app.is_changed());
    assert_ne!(app.state().light, before.light);
    app.execute(Command::Undo);
    assert!(app.lighting.is_current);
    assert!(Arc::ptr_eq(app.lighting.solution.as_ref().unwrap(), &first));
}

/// Starts loading a file, calls `light` meanwhile, and returns the path.
fn loading(app: &mut App, light: impl FnOnce(&mut App)) -> PathBuf {
    let shapes = example("shapes.grf");
    app.execute(Command::Open(vec![shapes.clone()]));
    app.execute(Command::Discard);
    light(app);
    settle(app);
    shapes
}

#[test]
fn light_that_comes_while_a_file_is_read_is_not_lost() {
    let mut app = filled();
    let shapes = loading(&mut app, |app| app.take_light(solved(&app.document)));
    let question = PendingQuestion::Unsaved(Box::new(Command::Open(vec![shapes])));
    assert_eq!(app.question, Some(question));
    assert!(app.lighting.is_current);
}

#[test]
fn who_gives_up_what_is_being_solved_is_not_asked_for_each_preview() {
    let mut app = filled();
    edit(&mut app, Edit::Rename(ItemId(3), "marble".into()));
    app.execute(Command::Solve);
    app.execute(Command::Pause);
    let job = Job {
        id: app.jobs()[0].id,
        kind: JobKind::Solve,
        title: String::new(),
        progress: Arc::default(),
        started: Instant::now(),
    };
    let shapes = loading(&mut app, |app| {
        let solution = solved(&app.document);
        app.take_light_of(&job, solution);
    });
    assert_eq!(app.question, None);
    assert_eq!(app.file.as_ref().map(|f| &f.path), Some(&shapes));
}

#[test]
fn nothing_that_shines_is_told() {
    let mut app = App::quiet();
    run(&mut app, Command::Solve);
    check_error(&app, "there is no light source");
}

#[test]
fn a_solver_rests_goes_on_and_ends() {
    let mut app = filled();
    app.execute(Command::SetLight(LightSettings {
        patches: 2_000,
        error: 1e-6,
        ..LightSettings::default()
    }));
    app.execute(Command::Solve);
    app.execute(Command::Pause);
    assert!(app.lighting.is_paused && app.is_busy(JobKind::Solve));
    app.execute(Command::Resume);
    assert!(!app.lighting.is_paused);
    app.execute(Command::Solve);
    assert_eq!(app.jobs().len(), 1);
    app.execute(Command::StopSolving);
    settle(&mut app);
    check_no_error(&app);
    let solver = |app: &mut App| {
        app.execute(Command::Solve);
        app.jobs()[0].id
    };
    let job = solver(&mut app);
    app.execute(Command::Cancel(job));
    assert!(app.jobs().is_empty() && !app.lighting.is_paused);
}

#[test]
fn form_factors_are_found_and_forgotten_with_an_edit() {
    let mut app = lit();
    let pick = crate::document::SurfacePick {
        item: ItemId(1),
        position: glam::DVec3::new(1.5, 0.0, -1.5),
        normal: glam::DVec3::Y,
    };
    run(&mut app, Command::FormFactorsFrom(pick));
    check_no_error(&app);
    let seen = app.lighting.form_factors.as_ref().expect("factors");
    assert!(seen.sum > 0.0 && seen.sum <= 1.0 + 1e-6, "{}", seen.sum);
    assert_eq!(seen.patches.faces.len(), seen.factors.len());
    edit(&mut app, Edit::Rename(ItemId(1), "ground".into()));
    assert!(app.lighting.form_factors.is_none());
    let nowhere = crate::document::SurfacePick {
        position: glam::DVec3::splat(1e3),
        ..pick
    };
    run(&mut app, Command::FormFactorsFrom(nowhere));
    check_error(&app, "no patch at that place");
}

#[test]
fn pictures_are_drawn_refined_and_written_in_three_formats() {
    let folder = TestFolder::new("pictures");
    let mut app = filled();
    app.execute(Command::SaveRender(folder.path("early.png")));
    check_error(&app, "there is no image yet");
    app.messages.clear();
    app.preferences.picture_samples = 2;
    run(
        &mut app,
        Command::Render {
            width: 24,
            height: 16,
            paths: None,
        },
    );
    let render = app.render.clone().expect("a render");
    assert_eq!((render.samples, render.size), (2, (24, 16)));
    for name in ["a.png", "a.hdr", "a.exr", "bare"] {
        run(&mut app, Command::SaveRender(folder.path(name)));
    }
    check_no_error(&app);
    for name in ["a.png", "a.hdr", "bare.png"] {
        let bytes = std::fs::read(folder.path(name)).unwrap();
        let image = read_picture(&bytes).unwrap();
        assert_eq!((image.width, image.height), (24, 16), "{name}");
    }
    assert!(folder.path("a.exr").exists());
    run(&mut app, Command::SaveRender(folder.path("a.webp")));
    check_error(&app, "unknown image format");
    edit(&mut app, Edit::Delete(vec![ItemId(3)]));
    assert!(app.render.is_none(), "a render of a closed document");
    app.messages.clear();
    app.execute(Command::Render {
        width: 0,
        height: 5,
        paths: None,
    });
    check_error(&app, "cannot render an image");
}

#[test]
fn a_final_gather_draws_the_picture_anew() {
    let mut app = filled();
    app.take_light(solved(&app.document));
    let small = Command::Render {
        width: 12,
        height: 8,
        paths: Some(1),
    };
    run(&mut app, small);
    let plain = app.render.clone().expect("a render");
    let preferences = Preferences {
        picture_gather: 4,
        ..app.preferences.clone()
    };
    run(&mut app, Command::SetPreferences(Box::new(preferences)));
    let gathered = app.render.clone().expect("a render");
    assert_eq!((gathered.samples, gathered.most), (1, 1));
    assert_ne!(gathered.image, plain.image);
}

#[test]
fn an_image_behind_the_scene_is_placed_saved_and_undone() {
    let folder = TestFolder::new("backdrop");
    let mut app = filled();
    app.preferences.picture_samples = 1;
    run(
        &mut app,
        Command::Render {
            width: 8,
            height: 8,
            paths: None,
        },
    );
    run(&mut app, Command::SaveRender(folder.path("sky.png")));
    let other = folder.copy("shapes.grf");
    run(&mut app, Command::Open(vec![other.clone()]));
    run(&mut app, Command::LoadBackplate(folder.path("sky.png")));
    let Some(SceneBackground::Backplate(plate)) = app.document.background else {
        panic!("no image: {:?}", app.document.background)
    };
    assert_eq!((plate.fit, plate.radiance), (BackplateFit::Scaled, 1.0));
    assert_eq!(app.file.as_ref().map(|f| &f.path), Some(&other));
    run(&mut app, Command::LoadBackplate(other));
    assert_eq!(errors(&app).len(), 1);
    // It is placed, saved with the scene, and there again when that is opened.
    let plate = Backplate {
        fit: BackplateFit::Tiled,
        radiance: 0.25,
        ..plate
    };
    edit(
        &mut app,
        Edit::SetBackground(Some(SceneBackground::Backplate(plate))),
    );
    let kept = folder.path("kept.grf");
    run(&mut app, Command::SaveAs(kept.clone()));
    let mut second = App::quiet();
    run(&mut second, Command::Open(vec![kept]));
    let Some(SceneBackground::Backplate(read)) = second.document.background else {
        panic!("no image: {:?}", second.document.background)
    };
    assert_eq!((read.fit, read.radiance), (plate.fit, plate.radiance));
    let picture = second.document.textures[read.texture as usize]
        .image
        .as_ref();
    assert_eq!(picture.map(|i| (i.width, i.height)), Some((8, 8)));
    // Undo takes it away.
    app.execute(Command::Undo);
    app.execute(Command::Undo);
    assert_eq!(app.document.background, None);
}
