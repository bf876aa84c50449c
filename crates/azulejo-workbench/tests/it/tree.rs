//! The tree.

use crate::window::*;
use azulejo_workbench::command::{Command, Selection};
use azulejo_workbench::document::ItemId;
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;

fn id_of(window: &TestWindow, name: &str) -> ItemId {
    let mut items = window.state().app.document.objects.iter();
    items.find(|i| i.name == name).unwrap().id
}

#[test]
fn things_are_selected_one_by_one_and_by_groups() {
    let mut window = window(opened("shapes.grf"));
    click(&mut window, "ceiling");
    let (ceiling, column) = (id_of(&window, "ceiling"), id_of(&window, "column"));
    assert_eq!(window.state().app.selection.ids, [ceiling]);
    find(&window, Role::Button, "column").click_modifiers(Modifiers::COMMAND);
    window.run();
    assert_eq!(window.state().app.selection.ids, [ceiling, column]);
    assert!(says(&window, "2 selected"));
    click(&mut window, "shapes");
    assert_eq!(window.state().app.selection.ids.len(), 12);
    click(&mut window, "💡 spot");
    assert!(says(&window, "Falls off with the square of the distance."));
    click_last(&mut window, "moss");
    let app = &window.state().app;
    let material = app.selection.material.unwrap() as usize;
    assert_eq!(app.document.materials[material].name, "moss");
}

#[test]
fn a_thing_is_renamed_in_its_row() {
    let mut window = window(opened("shapes.grf"));
    click(&mut window, "ceiling");
    press(&mut window, Modifiers::NONE, Key::F2);
    let id = window.state().app.selection.ids[0];
    press(&mut window, Modifiers::COMMAND, Key::A);
    window.event(egui::Event::Text("roof".into()));
    window.run();
    press(&mut window, Modifiers::NONE, Key::Enter);
    assert_eq!(window.state().app.document.name(id), Some("roof"));
    assert_eq!(
        window.state().app.selection.ids,
        [id],
        "a text is not the model"
    );
    find(&window, Role::Button, "roof");

    press(&mut window, Modifiers::NONE, Key::F2);
    window.event(egui::Event::Text("wrong".into()));
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert_eq!(window.state().app.document.name(id), Some("roof"));

    press(&mut window, Modifiers::NONE, Key::F2);
    let revision = window.state().app.revision();
    press(&mut window, Modifiers::NONE, Key::Enter);
    assert!(!says(&window, "wrong"), "{:?}", labels(&window));
    assert_eq!(
        window.state().app.revision(),
        revision,
        "the same name again is not a step"
    );
}

#[test]
fn things_and_groups_are_hidden_and_shown() {
    let mut window = window(opened("shapes.grf"));
    let hidden = |window: &TestWindow| {
        let items = window.state().app.document.objects.iter();
        items.filter(|i| i.hidden).count()
    };
    click(&mut window, "Hide: ceiling");
    assert_eq!(hidden(&window), 1);
    click(&mut window, "Show: ceiling");
    assert_eq!(hidden(&window), 0);
    click(&mut window, "Hide: shapes");
    assert_eq!(hidden(&window), 12);
    press(&mut window, Modifiers::SHIFT, Key::H);
    assert_eq!(hidden(&window), 0);
}

#[test]
fn lights_and_cameras_are_hidden_and_shown() {
    let mut window = window(opened("shapes.grf"));
    let hidden = |window: &TestWindow| window.state().app.document.hidden().len();
    click(&mut window, "Hide: spot");
    assert_eq!(hidden(&window), 1);
    click(&mut window, "Show: spot");
    // The spot, and the lamp, which is an object that shines.
    let lights = window.state().app.document.lights.len() + 1;
    click(&mut window, "Hide: Lights");
    assert_eq!(hidden(&window), lights);
    let camera = window.state().app.document.cameras[0].id;
    let select = Command::Select(Selection::one(camera));
    window.state_mut().app.execute(select);
    window.run();
    press(&mut window, Modifiers::NONE, Key::H);
    assert_eq!(hidden(&window), lights + 1);
    let revision = window.state().app.revision();
    press(&mut window, Modifiers::NONE, Key::H);
    assert_eq!(window.state().app.revision(), revision);
}

#[test]
fn what_several_objects_share_is_a_definition() {
    let mut window = window(opened("shapes.grf"));
    assert!(window.query_by_label("Shapes").is_none());
    click(&mut window, "column");
    press(&mut window, Modifiers::COMMAND, Key::D);
    let column = id_of(&window, "column");
    let copy = window.state().app.selection.ids[0];
    write(&mut window, "", "column");
    for section in ["Definitions", "Shapes"] {
        find(&window, Role::Button, section);
    }
    click(&mut window, "column × 2");
    assert_eq!(window.state().app.selection.ids, [column, copy]);
}

#[test]
fn groups_close_and_open_where_something_in_them_is_selected() {
    let mut window = window(opened("shapes.grf"));
    find(&window, Role::DisclosureTriangle, "− shapes").click();
    window.run();
    assert!(window.query_by_label("ceiling").is_none());
    let ceiling = id_of(&window, "ceiling");
    let select = Command::Select(Selection::one(ceiling));
    window.state_mut().app.execute(select);
    window.run();
    find(&window, Role::Button, "ceiling");
}

#[test]
fn only_what_is_looked_for_is_shown() {
    let mut window = window(opened("shapes.grf"));
    write(&mut window, "", "WALL");
    for found in ["back wall", "left wall", "blue wall"] {
        find(&window, Role::Button, found);
    }
    assert!(window.query_by_label("ceiling").is_none());
    assert!(window.query_by_label("💡 spot").is_none());
    // Typing in the field triggers no shortcuts: "h" hides nothing.
    assert!(!window.state().app.is_changed());
    write(&mut window, "WALL", "no such thing");
    assert!(says(&window, "No name contains this text"));
}

fn materials(window: &TestWindow) -> Vec<String> {
    let materials = window.state().app.document.materials.iter();
    materials.map(|m| m.name.clone()).collect()
}

#[test]
fn a_material_of_the_tree_is_copied_and_deleted_by_keys_where_nothing_else_is_selected() {
    let mut window = window(opened("shapes.grf"));
    let before = materials(&window);
    click_last(&mut window, "moss");
    press(&mut window, Modifiers::COMMAND, Key::D);
    assert_eq!(materials(&window)[before.len()..], ["moss 2"]);
    press(&mut window, Modifiers::NONE, Key::Delete);
    assert_eq!(materials(&window), before);
    check_no_error(&window);
    assert_eq!(window.state().app.selection.material, None);
    // With an object selected, shortcuts apply to it, and after its deletion to nothing.
    click(&mut window, "ceiling");
    press(&mut window, Modifiers::NONE, Key::Delete);
    press(&mut window, Modifiers::NONE, Key::Delete);
    assert_eq!(materials(&window), before);
    assert_eq!(window.state().app.document.objects.len(), 11);
    check_no_error(&window);
}

#[test]
fn materials_are_copied_and_deleted_by_buttons_and_the_unused_ones_by_a_menu() {
    let mut window = window(opened("shapes.grf"));
    let before = materials(&window).len();
    click_last(&mut window, "moss");
    click_last(&mut window, "Material");
    click(&mut window, "Duplicate");
    assert_eq!(materials(&window)[before..], ["moss 2"]);
    click(&mut window, "Delete");
    assert_eq!(materials(&window).len(), before);
    find(&window, Role::Button, "moss").click_secondary();
    window.run();
    click_last(&mut window, "Duplicate");
    click(&mut window, "Edit");
    click_last(&mut window, "Remove unused materials");
    check_no_error(&window);
    let app = &window.state().app;
    assert_eq!(
        app.document.used_materials().len(),
        app.document.materials.len()
    );
    assert_eq!(app.undo_labels().0, Some("remove unused materials"));
}
