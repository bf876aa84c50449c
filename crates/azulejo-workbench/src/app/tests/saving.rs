//! Saving: the later of two saves wins, light is written, files are overwritten.

use super::*;
use crate::document::tests::solved;
use azulejo::models;
use azulejo::scene::Shape;
use azulejo::trace::Progress;

fn last(app: &App) -> &str {
    app.messages.last().map_or("", |m| m.text.as_str())
}

#[test]
fn the_later_of_two_saves_is_what_stays() {
    let folder = TestFolder::new("twice");
    let path = folder.path("a.grf");
    let mut app = filled();
    app.execute(Command::SaveAs(path.clone()));
    edit(&mut app, Edit::Rename(ItemId(3), "marble".into()));
    app.execute(Command::SaveAs(folder.path("b.grf")));
    app.execute(Command::SaveAs(path.clone()));
    assert_eq!(app.jobs().len(), 2, "the first is given up");
    settle(&mut app);
    check_no_error(&app);
    assert!(!app.is_changed());
    assert!(std::fs::read_to_string(path).unwrap().contains("marble"));
    assert!(folder.path("b.grf").exists());
}

#[test]
fn a_copy_over_the_own_file_was_not_written_by_others() {
    let folder = TestFolder::new("own-copy");
    let path = folder.copy("shapes.grf");
    let mut app = App::quiet();
    run(&mut app, Command::Open(vec![path.clone()]));
    let first = app.document.objects[0].id;
    edit(&mut app, Edit::Rename(first, "renamed".into()));
    run(&mut app, Command::Export(path));
    app.check_disk();
    assert_eq!(app.question, None);
    assert!(app.is_changed());
}

/// Writes the sample with light on all surfaces, or on all but the first object if not `whole`.
fn lit_file(path: &Path, whole: bool) {
    let document = sample();
    let (mut scene, _) = document.lit_scene(Some(&solved(&document)));
    if let (false, Shape::Mesh(mesh)) = (whole, &mut scene.objects[0].shape) {
        mesh.irradiance.clear();
        mesh.irradiance_error.clear();
    }
    models::write(&scene, path, &Progress::new()).unwrap();
}

#[test]
fn light_of_what_is_added_to_nothing_is_kept() {
    let folder = TestFolder::new("added-light");
    let path = folder.path("lit.grf");
    lit_file(&path, true);
    let mut app = App::quiet();
    run(&mut app, Command::Add(vec![path]));
    check_no_error(&app);
    assert!(app.lighting.is_current && app.is_changed());
    run(&mut app, Command::SaveAs(folder.path("b.grf")));
    assert!(last(&app).ends_with("saved with its light"));
}

#[test]
fn light_of_a_part_is_not_lost_without_a_word() {
    let folder = TestFolder::new("part-light");
    let path = folder.path("part.grf");
    lit_file(&path, false);
    let mut app = App::quiet();
    run(&mut app, Command::Open(vec![path]));
    check_no_error(&app);
    assert!(app.lighting.solution.is_none());
    run(&mut app, Command::SaveAs(folder.path("b.grf")));
    let said = "saved without the light stored in the file";
    assert!(last(&app).ends_with(said), "{}", last(&app));
}
