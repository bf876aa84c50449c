//! The material library.

use crate::window::*;
use azulejo_workbench::app::App;
use azulejo_workbench::command::{Command, FileRequest, Selection};
use azulejo_workbench::document::{Edit, NewShapeKind};
use azulejo_workbench::ui::PanelTab;
use egui::accesskit::Role;

/// A window with boxes of one material, the last of which is selected, and its library.
fn with_library(boxes: usize) -> TestWindow {
    let mut app = App::quiet();
    for _ in 0..boxes {
        app.execute(Command::AddShape(NewShapeKind::Cuboid));
    }
    let mut window = window(app);
    window.state_mut().tab = PanelTab::Material;
    // Pictures arrive for a while, so that there is no frame after which nothing changes.
    window.run_steps(2);
    open(&mut window);
    window
}

fn open(window: &mut TestWindow) {
    find(window, Role::DisclosureTriangle, "Library").click();
    // The section opens slowly.
    window.run_steps(30);
}

fn tap(window: &mut TestWindow, label: &str) {
    find(window, Role::Button, label).click();
    window.run_steps(6);
}

#[test]
fn a_picture_gives_the_selected_material_its_reflection_in_one_step() {
    let mut window = with_library(1);
    let before = window.state().app.document.materials.clone();
    tap(&mut window, "Copper");
    let app = &window.state().app;
    let id = app.selection.material.unwrap() as usize;
    let copper = &app.document.materials[id];
    assert!(copper.brdf.is_some() && copper.diffuse.is_black());
    assert_eq!(app.undo_labels().0, Some("change a material"));
    window.state_mut().app.execute(Command::Undo);
    assert_eq!(window.state().app.document.materials, before);
    // The tree must not show the name any more.
    window.run_steps(2);
    // Two clicks are two steps.
    tap(&mut window, "Copper");
    tap(&mut window, "Brick");
    window.state_mut().app.execute(Command::Undo);
    let name = &window.state().app.document.materials[id].name;
    assert_eq!(name, "Copper");
    check_no_error(&window);
}

#[test]
fn other_objects_keep_the_material_that_they_shared() {
    let mut window = with_library(2);
    let app = &mut window.state_mut().app;
    let ids: Vec<_> = app.document.objects.iter().map(|o| o.id).collect();
    app.execute(Command::Edit(Edit::Assign(ids.clone(), 0), None));
    app.execute(Command::Select(Selection {
        ids: vec![ids[1]],
        faces: None,
        material: Some(0),
    }));
    let before = app.document.materials.clone();
    window.run_steps(2);
    tap(&mut window, "Brushed steel");
    let app = &window.state().app;
    let used = |k: usize| app.document.objects[k].materials();
    assert_eq!((used(0), used(1)), (&[0][..], &[before.len() as u32][..]));
    assert_eq!(app.document.materials[..before.len()], before[..]);
    assert_eq!(app.document.materials.last().unwrap().name, "Brushed steel");
    assert_eq!(app.selection.material, Some(before.len() as u32));
    // Once it has its own, that one changes; both are one step each.
    tap(&mut window, "Oak");
    let app = &mut window.state_mut().app;
    assert_eq!(app.document.materials.len(), before.len() + 1);
    app.execute(Command::Undo);
    app.execute(Command::Undo);
    assert_eq!(app.document.materials, before);
    check_no_error(&window);
}

#[test]
fn a_material_is_added_for_the_selected_objects_in_one_step() {
    let mut window = with_library(2);
    let before = window.state().app.document.materials.len();
    tap(&mut window, "Add to the scene: Oak");
    let app = &window.state().app;
    assert_eq!(app.document.materials.len(), before + 1);
    assert_eq!(app.document.materials[before].name, "Oak");
    assert_eq!(app.selection.material, Some(before as u32));
    let used: Vec<_> = app.document.objects.iter().map(|o| o.materials()).collect();
    assert!(used[1].contains(&(before as u32)) && !used[0].contains(&(before as u32)));
    window.state_mut().app.execute(Command::Undo);
    assert_eq!(window.state().app.document.materials.len(), before);
}

#[test]
fn without_a_material_the_library_is_open_and_adds() {
    let mut window = window(App::quiet());
    window.state_mut().tab = PanelTab::Material;
    window.run_steps(4);
    tap(&mut window, "Gold");
    let app = &window.state().app;
    assert_eq!(app.document.materials.last().unwrap().name, "Gold");
    assert!(app.selection.material.is_some());
}

#[test]
fn a_model_is_saved_under_the_name_of_its_material() {
    let mut app = App::quiet();
    app.execute(Command::AddShape(NewShapeKind::Cuboid));
    let mut window = window(app);
    window.state_mut().tab = PanelTab::Material;
    window.run_steps(2);
    open(&mut window);
    tap(&mut window, "Brushed steel");
    let request = Command::RequestFile(FileRequest::SaveBrdf);
    window.state_mut().app.execute(request);
    window.run_steps(4);
    assert!(
        says(&window, "brushed-steel.brdf"),
        "{:#?}",
        labels(&window)
    );
}
