//! Recipes: applied, undone, noted beside the model, and applied again.

use super::*;
use azulejo::scene::{LightKind, Shape};

const MODEL: &str = "o floor\nv 0 0 0\nv 4 0 0\nv 4 0 4\nv 0 0 4\nusemtl tiles\nf 4 3 2 1\n\
    o lamp_1\nv 1 3 1\nv 2 3 1\nv 2 3 3\nv 1 3 3\nusemtl tiles\nf 5 6 7 8\n";

const RECIPE: &str = "background = 0.5\n\n[[material]]\nname = \"til*\"\ndiffuse = 0.25\n\n\
    [[object]]\nname = \"lamp*\"\nlumens = 358\n\n[[object]]\nname = \"sofa\"\nmirror = 1\n\n\
    [[light]]\nname = \"bulb\"\nkind = \"point\"\nposition = [2, 2, 2]\nintensity = 3\n\n\
    [[camera]]\nname = \"door\"\neye = [2, 1, 6]\ntarget = [2, 1, 0]\nup = [0, 1, 0]\nfov = 60\n";

/// A folder with a model and a recipe.
fn room(name: &str) -> TestFolder {
    let folder = TestFolder::new(name);
    std::fs::write(folder.path("room.obj"), MODEL).unwrap();
    std::fs::write(folder.path("studio.toml"), RECIPE).unwrap();
    folder
}

fn opened(path: PathBuf) -> App {
    let mut app = App::quiet();
    run(&mut app, Command::Open(vec![path]));
    check_no_error(&app);
    app
}

fn has_message(app: &App, level: Severity, part: &str) -> bool {
    let mut messages = app.messages.iter();
    messages.any(|m| m.level == level && m.text.contains(part))
}

/// Asserts that the document is the model as the recipe makes it.
fn check_applied(app: &App) {
    let document = &app.document;
    let tiles = document.materials.iter().find(|m| m.name == "tiles");
    assert_eq!(tiles.unwrap().diffuse.r, 0.25);
    let lamp = document
        .objects
        .iter()
        .find(|o| o.name == "lamp_1")
        .unwrap();
    let shines = &document.materials[lamp.materials()[0] as usize];
    // 358 lm are 2 W, from 2 m².
    let exitance = std::f64::consts::PI * shines.emission.r;
    assert!((exitance - 1.0).abs() < 1e-9, "{exitance}");
    let floor = document.objects.iter().find(|o| o.name == "floor").unwrap();
    assert!(!document.materials[floor.materials()[0] as usize].is_emitter());
    assert_eq!((document.lights.len(), document.cameras.len()), (1, 1));
    assert!(matches!(
        document.lights[0].light.kind,
        LightKind::Point { .. }
    ));
    assert!(document.background.is_some());
    document.scene().validate().unwrap();
}

#[test]
fn a_recipe_is_applied_in_one_step_and_says_what_it_did_not_find() {
    let folder = room("recipe");
    let mut app = opened(folder.path("room.obj"));
    let before = app.document.clone();
    app.execute(Command::ApplyRecipe(folder.path("studio.toml")));
    check_no_error(&app);
    check_applied(&app);
    assert!(has_message(
        &app,
        Severity::Warning,
        "the rule \"sofa\" matches no object"
    ));
    assert_eq!(app.undo_labels().0, Some("apply a recipe"));
    app.execute(Command::Undo);
    assert_eq!(app.document, before);
    app.execute(Command::Redo);
    check_applied(&app);
}

#[test]
fn a_recipe_belongs_to_the_model_until_it_is_undone_or_forgotten() {
    let folder = room("noted");
    let note = folder.path("room.obj.recipes.toml");
    let mut app = opened(folder.path("room.obj"));
    assert!(!note.exists());
    app.execute(Command::ApplyRecipe(folder.path("studio.toml")));
    assert!(
        std::fs::read_to_string(&note)
            .unwrap()
            .contains("\"studio.toml\"")
    );
    app.execute(Command::Undo);
    assert!(!note.exists(), "undone");
    app.execute(Command::Redo);
    assert!(note.exists());
    let applied = app.document.materials.clone();
    edit(&mut app, Edit::ForgetRecipes);
    assert!(!note.exists(), "forgotten");
    assert_eq!(app.document.materials, applied, "what it made stays");
    let steps = app.revision();
    edit(&mut app, Edit::ForgetRecipes);
    assert_eq!(app.revision(), steps, "nothing is left to forget");
    check_no_error(&app);
}

#[test]
fn a_recipe_is_applied_again_when_the_model_is_imported_anew() {
    let folder = room("again");
    let model = folder.path("room.obj");
    let mut app = opened(model.clone());
    app.execute(Command::ApplyRecipe(folder.path("studio.toml")));
    // The model is exported anew from the program that made it, with one more lamp.
    let more = "o lamp_2\nv 0 3 0\nv 1 3 0\nv 1 3 1\nv 0 3 1\nusemtl tiles\nf 9 10 11 12\n";
    std::fs::write(&model, format!("{MODEL}{more}")).unwrap();
    let app = opened(model.clone());
    check_applied(&app);
    let lamp = app.document.objects.iter().find(|o| o.name == "lamp_2");
    let material = lamp.unwrap().materials()[0];
    assert!(app.document.materials[material as usize].is_emitter());
    assert!(!app.is_changed(), "it will be applied again, too");
    assert!(has_message(&app, Severity::Note, "studio.toml"));
    // Beside another model only its own objects change, whatever their group is called then.
    let mut both = opened(example("cornell.grf"));
    let materials = both.document.materials.len();
    run(&mut both, Command::Add(vec![model]));
    check_no_error(&both);
    let lamps = both.document.objects.iter();
    let lamps = lamps.filter(|o| o.name.ends_with("lamp_1") || o.name.ends_with("lamp_2"));
    let of = |o: &Arc<crate::document::SceneObject>| o.materials()[0] as usize;
    let shine: Vec<usize> = lamps.map(of).collect();
    assert_eq!(shine.len(), 2);
    assert!(
        shine
            .iter()
            .all(|&m| m >= materials && both.document.materials[m].is_emitter())
    );
}

#[test]
fn a_noted_recipe_that_fails_leaves_the_model_as_it_is() {
    let folder = room("failing");
    let model = folder.path("room.obj");
    let mut app = opened(model.clone());
    app.execute(Command::ApplyRecipe(folder.path("studio.toml")));
    std::fs::remove_file(folder.path("studio.toml")).unwrap();
    let app = opened(model.clone());
    assert!(has_message(&app, Severity::Warning, "studio.toml"));
    assert!(app.document.lights.is_empty() && app.document.has_recipes());
    std::fs::write(folder.path("room.obj.recipes.toml"), "recipes = 1").unwrap();
    let app = opened(model);
    assert!(has_message(
        &app,
        Severity::Warning,
        "room.obj.recipes.toml"
    ));
}

#[test]
fn what_is_saved_as_grf_holds_what_its_recipes_made() {
    let folder = room("saved");
    let lit = folder.path("room.grf");
    let mut app = opened(folder.path("room.obj"));
    app.execute(Command::ApplyRecipe(folder.path("studio.toml")));
    run(&mut app, Command::SaveAs(lit.clone()));
    let mut saved = opened(lit);
    check_applied(&saved);
    saved.execute(Command::ApplyRecipe(folder.path("studio.toml")));
    assert!(!saved.document.has_recipes());
    assert!(!folder.path("room.grf.recipes.toml").exists());
}

#[test]
fn objects_that_shared_a_shape_share_the_changed_one() {
    let folder = room("shared");
    let mut app = opened(folder.path("room.obj"));
    let lamp = app.document.objects.iter().find(|o| o.name == "lamp_1");
    let id = lamp.unwrap().id;
    edit(&mut app, Edit::Duplicate(vec![id]));
    std::fs::write(
        folder.path("glass.toml"),
        "[[object]]\nname = \"lamp*\"\nglass = 1.5\n",
    )
    .unwrap();
    app.execute(Command::ApplyRecipe(folder.path("glass.toml")));
    check_no_error(&app);
    let objects = &app.document.objects;
    assert!(matches!(&*objects[1].shape, Shape::Mesh(_)));
    assert!(Arc::ptr_eq(&objects[1].shape, &objects[2].shape));
    assert!(!Arc::ptr_eq(&objects[0].shape, &objects[1].shape));
}

#[test]
fn a_recipe_that_fails_changes_nothing() {
    let folder = room("wrong");
    std::fs::write(
        folder.path("wrong.toml"),
        "[[light]]\nkind = \"star\"\nintensity = 1",
    )
    .unwrap();
    let mut app = opened(folder.path("room.obj"));
    let before = app.document.clone();
    app.execute(Command::ApplyRecipe(folder.path("wrong.toml")));
    check_error(&app, "wrong.toml:1:1: kind: expected point");
    assert_eq!(app.document, before);
    assert!(!folder.path("room.obj.recipes.toml").exists());
}
