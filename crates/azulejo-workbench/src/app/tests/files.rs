//! Opening, adding, saving and exporting files, and changes by other programs.

use super::*;
use crate::document::tests::solved;
use azulejo::models::FORMATS;

fn file_of(app: &App) -> Option<&Path> {
    app.file.as_ref().map(|f| f.path.as_path())
}

/// An app with a copy of the Cornell box and an unsaved change.
fn changed(folder: &TestFolder) -> App {
    let mut app = App::quiet();
    let model = folder.copy("cornell.grf");
    run(&mut app, Command::Open(vec![model]));
    check_no_error(&app);
    let first = app.document.objects[0].id;
    edit(&mut app, Edit::Rename(first, "ground".into()));
    assert!(app.is_changed());
    app
}

#[test]
fn a_file_is_opened_and_others_join_it_under_their_names() {
    let folder = TestFolder::new("open");
    let mut app = App::quiet();
    let cornell = folder.copy("cornell.grf");
    run(&mut app, Command::Open(vec![cornell.clone()]));
    assert_eq!(file_of(&app), Some(&*cornell));
    assert!(!app.is_changed() && app.undo_labels().0.is_none());
    assert_eq!(app.preferences.recent, std::slice::from_ref(&cornell));
    let (count, units) = (app.document.objects.len(), app.document.units);
    assert_eq!(app.document.objects[0].name, "floor");
    // The view uses the file's own camera.
    assert_eq!(app.view.camera, app.document.cameras[0].camera);

    run(&mut app, Command::Add(vec![folder.copy("shapes.grf")]));
    check_no_error(&app);
    assert!(app.is_changed());
    assert_eq!(file_of(&app), Some(&*cornell));
    assert_eq!(app.document.units, units);
    let new = &app.document.objects[count..];
    assert!(!new.is_empty() && new.iter().all(|i| i.source_file == Some(1)));
    assert!(
        new.iter().all(|i| i.name.starts_with("shapes")),
        "{:?}",
        new[0].name
    );
    app.execute(Command::Undo);
    assert_eq!(app.document.objects.len(), count);
    assert!(!app.is_changed());
}

#[test]
fn a_file_that_fails_changes_nothing_and_is_told() {
    let folder = TestFolder::new("fails");
    let mut app = changed(&folder);
    let before = app.document.clone();
    let broken = folder.path("broken.grf");
    std::fs::write(&broken, "begin mesh begin vertices (1, 2").unwrap();
    run(&mut app, Command::Add(vec![broken.clone()]));
    check_error(&app, "broken.grf");
    app.messages.clear();
    run(&mut app, Command::Add(vec![folder.path("missing.obj")]));
    check_error(&app, "missing.obj");
    assert_eq!(app.document, before);

    // Even a file that was to replace the document after its changes were discarded.
    app.messages.clear();
    app.execute(Command::Open(vec![broken]));
    run(&mut app, Command::Discard);
    check_error(&app, "broken.grf");
    assert_eq!(app.document, before);
    assert!(
        app.is_changed(),
        "the changes are there, and not on the disk"
    );
}

#[test]
fn of_several_files_those_that_can_be_read_are_opened() {
    let folder = TestFolder::new("several");
    let broken = folder.path("broken.obj");
    std::fs::write(&broken, "f 1 2 3").unwrap();
    let mut app = App::quiet();
    let (a, b) = (folder.copy("shapes.grf"), folder.copy("csg.grf"));
    let missing = folder.path("missing.3ds");
    run(&mut app, Command::Open(vec![missing, a.clone(), b]));
    check_two_of_three(&app, &a);
}

/// Asserts that shapes and CSG models are open and that one file failed.
fn check_two_of_three(app: &App, first: &Path) {
    assert_eq!(errors(app).len(), 1, "{:?}", errors(app));
    assert_eq!(file_of(app), Some(first));
    let names: Vec<&str> = app.document.source_files.iter().map(|b| &*b.name).collect();
    assert_eq!(names, ["shapes", "csg"]);
    assert!(app.loading.is_none());
}

#[test]
fn files_that_are_added_wait_for_those_on_their_way() {
    let folder = TestFolder::new("queue");
    let (a, b) = (folder.copy("shapes.grf"), folder.copy("csg.grf"));
    let mut app = App::quiet();
    app.execute(Command::Open(vec![a.clone()]));
    app.execute(Command::Add(vec![folder.path("missing.obj")]));
    run(&mut app, Command::Add(vec![b]));
    check_two_of_three(&app, &a);
}

#[test]
fn what_waits_to_be_added_to_a_file_waits_for_the_answer_about_it() {
    let folder = TestFolder::new("queue-asked");
    let (a, b) = (folder.copy("shapes.grf"), folder.copy("csg.grf"));
    let mut app = filled();
    app.execute(Command::Open(vec![a.clone()]));
    app.execute(Command::Add(vec![b.clone()]));
    edit(&mut app, Edit::Rename(ItemId(3), "marble".into()));
    settle(&mut app);
    let question = PendingQuestion::Unsaved(Box::new(Command::Open(vec![a, b])));
    assert_eq!(app.question, Some(question));
    run(&mut app, Command::Discard);
    assert_eq!(app.document.source_files.len(), 2);
}

#[test]
fn files_that_are_given_up_for_another_are_named() {
    let folder = TestFolder::new("given-up");
    let (a, b) = (folder.copy("shapes.grf"), folder.copy("csg.grf"));
    let mut app = App::quiet();
    app.execute(Command::Open(vec![a]));
    app.execute(Command::Add(vec![b]));
    run(&mut app, Command::Open(vec![folder.copy("cornell.grf")]));
    let given_up = app.messages.iter().find(|m| m.level == Severity::Warning);
    let text = &given_up.expect("a warning").text;
    assert!(text.contains("shapes.grf") && text.contains("csg.grf"));
    assert_eq!(app.document.source_files.len(), 1);
}

#[test]
fn what_is_saved_comes_back_equal() {
    let folder = TestFolder::new("save");
    let mut app = filled();
    edit(&mut app, Edit::Rename(ItemId(3), "marble".into()));
    let path = folder.path("unlit.grf");
    run(&mut app, Command::SaveAs(folder.path("unlit")));
    check_no_error(&app);
    assert!(!app.is_changed());
    assert_eq!(file_of(&app), Some(&*path));
    let mut again = App::quiet();
    run(&mut again, Command::Open(vec![path]));
    assert_eq!(again.document.scene(), app.document.scene());
    assert!(again.lighting.solution.is_none());
}

#[test]
fn light_is_saved_and_comes_back() {
    let folder = TestFolder::new("lit");
    let mut app = filled();
    app.take_light(solved(&app.document));
    assert!(app.is_changed());
    let path = folder.path("lit.grf");
    run(&mut app, Command::SaveAs(path.clone()));
    check_no_error(&app);
    assert!(!app.is_changed());
    assert!(
        app.messages
            .last()
            .unwrap()
            .text
            .ends_with("with its light")
    );

    let mut again = App::quiet();
    run(&mut again, Command::Open(vec![path.clone()]));
    assert!(again.lighting.is_current);
    let solution = app.lighting.solution.as_deref();
    let (lit, _) = app.document.lit_scene(solution);
    let (reread, _) = again.document.lit_scene(again.lighting.solution.as_deref());
    assert_eq!(reread, lit);

    // Light of an earlier state is not written to a later one.
    edit(&mut app, Edit::Delete(vec![ItemId(3)]));
    run(&mut app, Command::Save);
    assert!(app.messages.last().unwrap().text.contains("without light"));
    run(&mut again, Command::Open(vec![path]));
    assert!(again.lighting.solution.is_none());
}

#[test]
fn what_cannot_be_written_is_told_and_stays_a_change() {
    let folder = TestFolder::new("refused");
    let mut app = changed(&folder);
    let own = app.file.clone();
    let file = folder.path("file");
    std::fs::write(&file, "").unwrap();
    std::fs::create_dir(folder.path("a.grf")).unwrap();
    for (path, expected) in [
        (folder.path("a.grf"), "a.grf"),
        (folder.path("none/b.grf"), "b.grf"),
        (file.join("c.grf"), "c.grf"),
        (folder.path("d.xyz"), "d.xyz"),
        (PathBuf::from("/proc/e.grf"), "e.grf"),
    ] {
        app.messages.clear();
        run(&mut app, Command::SaveAs(path));
        check_error(&app, expected);
        assert!(app.is_changed());
        assert_eq!(app.file, own);
    }
}

/// A device that is always full, behind a name with the extension GRF.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_told_and_what_waited_for_the_save_does_not_go_on() {
    let folder = TestFolder::new("full");
    let mut app = changed(&folder);
    let full = folder.path("full.grf");
    std::os::unix::fs::symlink("/dev/full", &full).unwrap();
    app.execute(Command::Quit);
    run(&mut app, Command::SaveAs(full));
    check_error(&app, "full.grf");
    assert!(app.is_changed() && !app.closing && app.question.is_none());
    assert_eq!(app.document.objects[0].name, "ground");
}

#[test]
fn a_file_that_others_wrote_is_asked_about() {
    let folder = TestFolder::new("others");
    let mut app = changed(&folder);
    let path = folder.path("cornell.grf");
    app.check_disk();
    assert_eq!(app.question, None);
    let others = std::fs::read_to_string(example("shapes.grf")).unwrap();
    std::fs::write(&path, &others).unwrap();
    run(&mut app, Command::Save);
    assert_eq!(
        app.question,
        Some(PendingQuestion::ChangedOnDisk(path.clone()))
    );
    app.execute(Command::CancelPending);
    assert_eq!(std::fs::read_to_string(&path).unwrap(), others);
    assert!(app.is_changed());

    app.execute(Command::Save);
    run(&mut app, Command::SaveAnyway);
    assert_eq!((app.question.clone(), app.is_changed()), (None, false));
    assert_ne!(std::fs::read_to_string(&path).unwrap(), others);

    // Once when the window gets the focus, and once more before the file is overwritten.
    std::fs::write(&path, &others).unwrap();
    app.check_disk();
    assert_eq!(
        app.question,
        Some(PendingQuestion::ChangedOnDisk(path.clone()))
    );
    app.execute(Command::CancelPending);
    app.check_disk();
    assert_eq!(app.question, None);
    run(&mut app, Command::Save);
    assert_eq!(
        app.question,
        Some(PendingQuestion::ChangedOnDisk(path.clone()))
    );
    run(&mut app, Command::Discard);
    check_no_error(&app);
    assert_eq!(app.document.source_files[0].name, "cornell");
    assert!(!app.document.objects.iter().any(|i| i.name == "ground"));
    app.check_disk();
    assert_eq!(app.question, None);

    std::fs::remove_file(&path).unwrap();
    app.check_disk();
    assert_eq!(app.question, None);
    assert!(
        app.messages
            .last()
            .unwrap()
            .text
            .contains("no longer exists")
    );
    run(&mut app, Command::Save);
    check_no_error(&app);
    assert!(path.exists());
}

#[test]
fn changes_are_not_lost_without_asking() {
    let folder = TestFolder::new("guard");
    let other = folder.copy("shapes.grf");
    for command in [Command::New, Command::Open(vec![other]), Command::Quit] {
        let mut app = changed(&folder);
        let before = app.document.clone();
        let ask = |app: &mut App| {
            app.execute(command.clone());
            let question = PendingQuestion::Unsaved(Box::new(command.clone()));
            assert_eq!(app.question.as_ref(), Some(&question));
            assert_eq!(app.document, before);
        };
        let is_done = |app: &App| app.closing || app.document != before;
        ask(&mut app);
        run(&mut app, Command::CancelPending);
        assert!(!is_done(&app) && app.is_changed());
        ask(&mut app);
        run(&mut app, Command::Discard);
        assert!(is_done(&app));
        assert_eq!(app.question, None);

        let mut app = changed(&folder);
        ask(&mut app);
        run(&mut app, Command::Save);
        check_no_error(&app);
        assert!(is_done(&app), "{command:?}");
        let saved = std::fs::read_to_string(folder.path("cornell.grf")).unwrap();
        assert!(saved.contains("ground"));
    }
}

#[test]
fn a_document_without_a_place_asks_for_one_before_it_goes() {
    let folder = TestFolder::new("place");
    let mut app = filled();
    edit(&mut app, Edit::Delete(vec![ItemId(3)]));
    app.execute(Command::Quit);
    app.execute(Command::Save);
    assert_eq!(app.asking, Some(FileRequest::SaveAs));
    app.execute(Command::DialogClosed);
    run(&mut app, Command::SaveAs(folder.path("a.grf")));
    assert!(app.closing && app.asking.is_none());

    // A format that stores no light is not overwritten: the user is asked for a file.
    let mut app = App::quiet();
    run(&mut app, Command::Open(vec![folder.copy("box.vs3")]));
    check_no_error(&app);
    app.execute(Command::Save);
    assert_eq!(app.asking, Some(FileRequest::SaveAs));
    app.execute(Command::CancelPending);
    assert_eq!(app.asking, None);
}

#[test]
fn edits_made_while_a_file_is_read_are_not_lost() {
    let mut app = filled();
    let shapes = example("shapes.grf");
    app.execute(Command::Open(vec![shapes.clone()]));
    edit(&mut app, Edit::Rename(ItemId(3), "marble".into()));
    settle(&mut app);
    let question = PendingQuestion::Unsaved(Box::new(Command::Open(vec![shapes.clone()])));
    assert_eq!(app.question, Some(question));
    assert_eq!(app.document.name(ItemId(3)), Some("marble"));
    run(&mut app, Command::Discard);
    assert_eq!(file_of(&app), Some(&*shapes));
}

#[test]
fn a_save_that_ends_late_is_not_of_the_next_document() {
    let folder = TestFolder::new("late");
    let mut app = filled();
    let path = folder.path("late.grf");
    app.execute(Command::SaveAs(path.clone()));
    app.execute(Command::New);
    settle(&mut app);
    check_no_error(&app);
    assert!(path.exists() && app.file.is_none());
    assert!(app.document.is_empty() && !app.is_changed());
}

#[test]
fn a_new_document_is_not_replaced_by_a_file_on_its_way() {
    let mut app = App::quiet();
    app.execute(Command::Open(vec![example("cornell.grf")]));
    app.execute(Command::New);
    settle(&mut app);
    assert!(app.document.is_empty() && app.jobs().is_empty());
}

#[test]
fn copies_are_exported_in_every_format() {
    let folder = TestFolder::new("export");
    let mut app = changed(&folder);
    let own = app.file.clone();
    for format in &FORMATS {
        let path = folder.path(&format!("copy.{}", format.extension));
        run(&mut app, Command::Export(path.clone()));
        check_no_error(&app);
        let mut again = App::quiet();
        run(&mut again, Command::Open(vec![path]));
        check_no_error(&again);
        assert!(again.document.face_count() > 10, "{}", format.extension);
    }
    assert!(app.is_changed(), "an export is not a save");
    assert_eq!(app.file, own);
}

#[test]
fn warnings_lead_to_what_they_are_about() {
    let folder = TestFolder::new("warnings");
    let path = folder.path("odd.obj");
    let text = "o roof\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl nowhere\ncurv2 1 2\n";
    std::fs::write(&path, text).unwrap();
    let mut app = App::quiet();
    run(&mut app, Command::Open(vec![path]));
    check_no_error(&app);
    let warnings: Vec<_> = app
        .messages
        .iter()
        .filter(|m| m.level == Severity::Warning)
        .collect();
    assert!(!warnings.is_empty());
    assert!(
        warnings
            .iter()
            .all(|m| m.about.is_some_and(|id| app.document.has(id)))
    );
    app.execute(Command::ClearMessages);
    assert!(app.messages.is_empty());
}

#[test]
fn a_job_is_cancelled() {
    let mut app = filled();
    app.execute(Command::Open(vec![example("cornell.grf")]));
    let job = app.jobs()[0].id;
    app.execute(Command::Cancel(job));
    settle(&mut app);
    assert_eq!(app.document, sample());
    assert!(app.loading.is_none());
}

#[test]
fn messages_are_not_kept_for_ever() {
    let mut app = App::quiet();
    (0..1_500).for_each(|k| app.report(Severity::Note, k.to_string()));
    assert_eq!(app.messages.len(), 1_000);
    assert_eq!(app.messages.last().unwrap().text, "1499");
}

#[test]
fn what_forgets_lights_is_not_saved_under_that_name() {
    let folder = TestFolder::new("lossy");
    let mut app = App::quiet();
    run(&mut app, Command::Open(vec![folder.copy("cornell.grf")]));
    let first = app.document.objects[0].id;
    edit(&mut app, Edit::Rename(first, "ground".into()));
    app.execute(Command::Quit);
    run(&mut app, Command::SaveAs(folder.path("room.obj")));
    check_no_error(&app);
    assert!(folder.path("room.obj").exists());
    assert!(app.is_changed() && !app.closing);
}
