//! Recovery after a crash, and preferences.

use super::*;
use crate::words::Language;

fn dirs(folder: &TestFolder) -> UserDirs {
    UserDirs {
        preferences: Some(folder.path("preferences.toml")),
        recovery: Some(folder.path("recovery")),
        thumbnails: None,
    }
}

fn app_in(folder: &TestFolder, autosave: u32) -> App {
    let preferences = Preferences {
        language: Language::English,
        autosave,
        ..Preferences::default()
    };
    App::new(preferences, dirs(folder), Arc::new(|| ()))
}

/// Pretends that the change was made this many seconds ago.
fn let_pass(app: &mut App, seconds: u64) {
    app.changed_at = app
        .changed_at
        .and_then(|t| t.checked_sub(Duration::from_secs(seconds)));
}

fn copies(folder: &TestFolder) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder.path("recovery"))
        .into_iter()
        .flatten();
    let paths = entries.map(|e| e.unwrap().path());
    paths
        .filter(|p| p.extension().is_some_and(|e| e == "grf"))
        .collect()
}

/// The folders of a crashed session: its files without its locks.
fn after_a_crash(folder: &TestFolder, app: App) -> TestFolder {
    let name = folder.0.file_name().unwrap().to_string_lossy().into_owned();
    let next = TestFolder::new(&format!("{name}-next"));
    std::fs::create_dir(next.path("recovery")).unwrap();
    for entry in std::fs::read_dir(folder.path("recovery")).unwrap() {
        let entry = entry.unwrap();
        std::fs::copy(entry.path(), next.path("recovery").join(entry.file_name())).unwrap();
    }
    drop(app);
    next
}

#[test]
fn a_copy_is_written_after_a_while_and_only_of_changes() {
    let folder = TestFolder::new("autosave");
    let mut app = app_in(&folder, 20);
    run(&mut app, Command::Open(vec![example("shapes.grf")]));
    settle(&mut app);
    assert!(copies(&folder).is_empty());
    assert_eq!(app.repaint_after(), None);

    edit(&mut app, Edit::Rename(ItemId(1), "renamed".into()));
    settle(&mut app);
    assert!(copies(&folder).is_empty());
    assert!(
        app.repaint_after()
            .is_some_and(|t| t <= Duration::from_secs(20))
    );
    let_pass(&mut app, 21);
    settle(&mut app);
    assert_eq!(copies(&folder).len(), 1);
    let written = std::fs::metadata(&copies(&folder)[0])
        .unwrap()
        .modified()
        .unwrap();
    settle(&mut app);
    let_pass(&mut app, 21);
    assert_eq!(app.repaint_after(), None, "there is nothing to wake for");
    let again = std::fs::metadata(&copies(&folder)[0])
        .unwrap()
        .modified()
        .unwrap();
    assert_eq!(written, again, "the same was written twice");

    run(&mut app, Command::SaveAs(folder.path("safe.grf")));
    assert!(copies(&folder).is_empty());
}

#[test]
fn no_copy_is_written_where_none_is_wanted() {
    let folder = TestFolder::new("never");
    let mut app = app_in(&folder, 0);
    edit(&mut app, Edit::Append(Box::new(sample())));
    let_pass(&mut app, 1_000);
    settle(&mut app);
    assert!(copies(&folder).is_empty() && app.repaint_after().is_none());
}

#[test]
fn what_a_crash_left_is_recovered_with_its_name() {
    let folder = TestFolder::new("crash");
    let mut app = app_in(&folder, 1);
    let model = folder.copy("cornell.grf");
    run(&mut app, Command::Open(vec![model.clone()]));
    let first = app.document.objects[0].id;
    edit(&mut app, Edit::Rename(first, "ground".into()));
    let_pass(&mut app, 2);
    settle(&mut app);
    let scene = app.document.scene();
    let next = after_a_crash(&folder, app);
    assert!(copies(&folder).is_empty(), "it ended in good order");

    let mut app = app_in(&next, 1);
    let [recoverable] = app.recoverable() else {
        panic!("{:?}", app.recoverable())
    };
    assert_eq!(recoverable.original.as_deref(), Some(&*model));
    let copy = recoverable.copy.clone();
    run(&mut app, Command::Recover(copy.clone()));
    check_no_error(&app);
    assert_eq!(app.document.scene(), scene);
    assert_eq!(app.file.as_ref().map(|f| &*f.path), Some(&*model));
    assert_eq!(app.document.source_files[0].path, model);
    assert!(app.is_changed() && app.recoverable().is_empty());
    assert!(copy.exists(), "another crash would take the only copy");
    // It was not recovered because of another program's change: there is nothing to ask.
    app.check_disk();
    assert_eq!(app.question, None);
    // But the file on disk differs from the recovered document.
    app.execute(Command::Save);
    assert_eq!(
        app.question,
        Some(PendingQuestion::ChangedOnDisk(model.clone()))
    );
    run(&mut app, Command::SaveAnyway);
    assert!(!app.is_changed() && !copy.exists());
    assert!(std::fs::read_to_string(model).unwrap().contains("ground"));
}

#[test]
fn what_had_no_name_has_none_after_a_crash() {
    let folder = TestFolder::new("nameless");
    let mut app = app_in(&folder, 1);
    edit(&mut app, Edit::Append(Box::new(sample())));
    let_pass(&mut app, 2);
    settle(&mut app);
    let next = after_a_crash(&folder, app);
    let mut app = app_in(&next, 1);
    let copy = app.recoverable()[0].copy.clone();
    run(&mut app, Command::Recover(copy));
    check_no_error(&app);
    assert!(app.file.is_none() && app.document.source_files.is_empty());
    assert_eq!(app.document.scene(), sample().scene());
    app.execute(Command::Save);
    assert_eq!(app.asking, Some(FileRequest::SaveAs));
}

#[test]
fn what_a_crash_left_can_be_deleted_or_be_broken() {
    let folder = TestFolder::new("broken");
    let mut app = app_in(&folder, 1);
    edit(&mut app, Edit::Append(Box::new(sample())));
    let_pass(&mut app, 2);
    settle(&mut app);
    let next = after_a_crash(&folder, app);
    let mut app = app_in(&next, 1);
    let copy = app.recoverable()[0].copy.clone();
    std::fs::write(&copy, "begin mesh").unwrap();
    run(&mut app, Command::Recover(copy.clone()));
    assert_eq!(errors(&app).len(), 1);
    assert!(app.document.is_empty() && app.recoverable().len() == 1);
    app.execute(Command::DeleteRecovery(copy.clone()));
    assert!(app.recoverable().is_empty() && !copy.exists());
}

/// A relative path to a file from the current folder of the process.
#[cfg(unix)]
fn from_here(path: &Path) -> PathBuf {
    let here = std::env::current_dir().unwrap();
    let up: PathBuf = here.components().skip(1).map(|_| "..").collect();
    up.join(path.strip_prefix("/").unwrap())
}

#[cfg(unix)]
#[test]
fn files_are_known_wherever_the_next_session_begins() {
    let folder = TestFolder::new("relative");
    let mut app = app_in(&folder, 1);
    let model = from_here(&folder.copy("shapes.grf"));
    assert!(model.is_relative());
    run(&mut app, Command::Open(vec![model]));
    run(
        &mut app,
        Command::Export(from_here(&folder.path("copy.grf"))),
    );
    run(&mut app, Command::SaveAs(from_here(&folder.path("b"))));
    check_no_error(&app);
    let recent = &app.preferences.recent;
    assert_eq!(recent.len(), 3);
    assert!(recent.iter().all(|p| p.is_absolute()), "{recent:?}");
    edit(&mut app, Edit::Rename(ItemId(1), "renamed".into()));
    let_pass(&mut app, 2);
    settle(&mut app);
    let next = after_a_crash(&folder, app);
    let app = app_in(&next, 1);
    let original = app.recoverable()[0].original.clone().unwrap();
    assert!(original.is_absolute() && original.ends_with("b.grf"));
}

#[cfg(unix)]
#[test]
fn a_name_that_is_no_text_survives_a_crash_and_keeps_no_preferences_away() {
    use std::os::unix::ffi::OsStrExt;
    let folder = TestFolder::new("bytes");
    let mut app = app_in(&folder, 1);
    let odd = folder.0.join(std::ffi::OsStr::from_bytes(b"caf\xe9.grf"));
    std::fs::copy(example("shapes.grf"), &odd).unwrap();
    run(&mut app, Command::Open(vec![folder.copy("csg.grf")]));
    run(&mut app, Command::Open(vec![odd.clone()]));
    assert!(app.messages.iter().all(|m| m.level == Severity::Note));
    assert_eq!(app.preferences.recent.len(), 2);
    let (kept, _) = Preferences::load(&folder.path("preferences.toml"));
    assert_eq!(kept.recent, [folder.path("csg.grf")]);
    edit(&mut app, Edit::Rename(ItemId(1), "renamed".into()));
    let_pass(&mut app, 2);
    settle(&mut app);
    let next = after_a_crash(&folder, app);
    let app = app_in(&next, 1);
    assert_eq!(app.recoverable()[0].original, Some(odd));
}

#[test]
fn pictures_survive_a_crash_with_the_model_and_go_with_the_copy() {
    use azulejo::formats::{picture::png, read_picture};
    let folder = TestFolder::new("textures");
    let mut file = Vec::new();
    png::write(1, 2, &[9, 99, 200, 0, 50, 255], &mut file).unwrap();
    std::fs::write(folder.path("wood.png"), &file).unwrap();
    let mut scene = sample().scene();
    // One texture is a file beside the model, the other is embedded in the model file.
    for path in ["wood.png", "inside"] {
        scene.textures.push(Texture {
            path: path.into(),
            image: Some(read_picture(&file).unwrap()),
            ..Texture::default()
        });
    }
    let model = folder.path("room.grf");
    std::fs::copy(example("shapes.grf"), &model).unwrap();
    let mut app = app_in(&folder, 1);
    run(&mut app, Command::Open(vec![model]));
    let document = SceneDocument::of_scene(scene, None);
    edit(&mut app, Edit::Append(Box::new(document)));
    let_pass(&mut app, 2);
    settle(&mut app);
    check_no_error(&app);
    let images: Vec<_> = app.document.textures.iter().map(|t| &t.image).collect();
    let images: Vec<_> = images.into_iter().cloned().collect();
    let next = after_a_crash(&folder, App::quiet());
    let left = || std::fs::read_dir(next.path("recovery")).unwrap().count();
    assert_eq!(left(), 3, "a note, a copy, a picture");

    let mut app = app_in(&next, 0);
    let copy = app.recoverable()[0].copy.clone();
    run(&mut app, Command::Recover(copy));
    check_no_error(&app);
    let again: Vec<_> = app
        .document
        .textures
        .iter()
        .map(|t| t.image.clone())
        .collect();
    assert_eq!(again, images);
    assert!(again.iter().flatten().count() >= 2);
    let names = app.document.textures.iter().map(|t| t.path.as_str());
    assert_eq!(names.filter(|n| *n == "wood.png").count(), 1);
    run(&mut app, Command::SaveAs(next.path("b.grf")));
    check_no_error(&app);
    assert_eq!(left(), 0);
    let mut last = App::quiet();
    run(&mut last, Command::Open(vec![next.path("b.grf")]));
    let last: Vec<_> = last
        .document
        .textures
        .iter()
        .map(|t| t.image.clone())
        .collect();
    assert_eq!(last, images);
}

#[test]
fn what_waits_for_a_copy_waits_for_the_answer_too() {
    let folder = TestFolder::new("waits");
    let mut app = app_in(&folder, 1);
    edit(&mut app, Edit::Append(Box::new(sample())));
    let_pass(&mut app, 2);
    settle(&mut app);
    let next = after_a_crash(&folder, app);
    let mut app = app_in(&next, 0);
    let copy = app.recoverable()[0].copy.clone();
    app.execute(Command::Recover(copy.clone()));
    app.execute(Command::Add(vec![example("shapes.grf")]));
    edit(&mut app, Edit::Append(Box::new(sample())));
    settle(&mut app);
    let question = PendingQuestion::Unsaved(Box::new(Command::Recover(copy)));
    assert_eq!(app.question, Some(question));
    run(&mut app, Command::Discard);
    check_no_error(&app);
    assert_eq!(app.document.source_files.len(), 1);
    assert!(app.document.objects.len() > sample().objects.len());
}

#[test]
fn a_copy_that_failed_is_tried_again_though_nothing_happens() {
    let folder = TestFolder::new("again");
    std::fs::write(folder.path("recovery"), "no folder").unwrap();
    let mut app = app_in(&folder, 1);
    edit(&mut app, Edit::Append(Box::new(sample())));
    let_pass(&mut app, 2);
    settle(&mut app);
    assert!(
        app.repaint_after()
            .is_some_and(|t| t > Duration::from_secs(60))
    );
}

#[test]
fn a_copy_that_cannot_be_written_is_told_once() {
    let folder = TestFolder::new("unwritable");
    std::fs::write(folder.path("recovery"), "no folder").unwrap();
    let mut app = app_in(&folder, 1);
    edit(&mut app, Edit::Append(Box::new(sample())));
    let_pass(&mut app, 2);
    settle(&mut app);
    settle(&mut app);
    assert!(errors(&app).len() <= 1, "{:?}", errors(&app));
    assert_eq!(app.document.objects.len(), 4);
}

#[test]
fn preferences_are_kept() {
    let folder = TestFolder::new("preferences");
    let mut app = app_in(&folder, 7);
    let mut mine = app.preferences.clone();
    mine.language = Language::Portuguese;
    mine.color_map = crate::view::ColorMap::Magma;
    app.execute(Command::SetPreferences(Box::new(mine.clone())));
    assert_eq!(app.view.false_color.map, crate::view::ColorMap::Magma);
    run(&mut app, Command::Open(vec![example("shapes.grf")]));
    let (kept, trouble) = Preferences::load(&folder.path("preferences.toml"));
    assert_eq!(trouble, None);
    assert_eq!(kept.recent, [example("shapes.grf")]);
    assert_eq!(kept.language, Language::Portuguese);

    // Where preferences cannot be stored this is reported, and they apply to this session.
    let mut app = App::new(
        mine,
        UserDirs {
            preferences: Some(PathBuf::from("/proc/none/preferences.toml")),
            recovery: None,
            thumbnails: None,
        },
        Arc::new(|| ()),
    );
    let mut other = app.preferences.clone();
    other.language = Language::Spanish;
    app.execute(Command::SetPreferences(Box::new(other)));
    assert_eq!(app.preferences.language, Language::Spanish);
    assert_eq!(app.messages.last().unwrap().level, Severity::Warning);
}

#[test]
fn a_request_to_end_without_changes_leaves_nothing() {
    let folder = TestFolder::new("ended-unchanged");
    let mut app = app_in(&folder, 0);
    assert_eq!(app.leave_recovery(), Ok(None));
    drop(app);
    assert!(copies(&folder).is_empty());
}
