//! The viewport under mouse and keyboard.

use crate::window::*;
use azulejo_workbench::ui::actions::{ActionTarget, WindowAction};
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers};
use glam::DVec3;

fn viewport(window: &TestWindow) -> egui_kittest::Node<'_> {
    find(window, Role::Canvas, "Viewport")
}

/// Position and target of the camera.
fn look(window: &TestWindow) -> (DVec3, DVec3) {
    let camera = &window.state().app.view.camera;
    (camera.eye, camera.target)
}

/// Holds a key for some frames.
fn hold(window: &mut TestWindow, modifiers: Modifiers, key: Key) {
    window.event(Event::ModifiersChanged(modifiers));
    window.key_down(key);
    window.run_steps(5);
    window.key_up(key);
    window.event(Event::ModifiersChanged(Modifiers::NONE));
    window.run();
}

#[test]
fn one_flies_after_a_click_on_the_model_too() {
    let mut window = window(opened("cornell.grf"));
    let before = look(&window);
    hold(&mut window, Modifiers::NONE, Key::W);
    let flown = look(&window);
    assert_ne!(flown.0, before.0);
    viewport(&window).click();
    window.run();
    assert!(!window.state().app.selection.ids.is_empty());
    hold(&mut window, Modifiers::NONE, Key::W);
    assert_ne!(look(&window).0, flown.0);
    // Arrow keys turn the camera and do not move the focus.
    let (eye, target) = look(&window);
    hold(&mut window, Modifiers::NONE, Key::ArrowLeft);
    assert_eq!(look(&window).0, eye);
    assert_ne!(look(&window).1, target);
    assert!(viewport(&window).is_focused());
}

#[test]
fn the_cube_turns_the_view_and_leaves_the_focus_where_it_is() {
    let mut window = window(opened("cornell.grf"));
    viewport(&window).click();
    window.run();
    let selected = window.state().app.selection.clone();
    let cube = find(&window, Role::Button, "Orientation cube").rect();
    let before = look(&window);
    window.hover_at(cube.center());
    window.run();
    window.drag_at(cube.center());
    window.run();
    for step in [0.5, 1.0] {
        window.hover_at(cube.center() + step * egui::vec2(40.0, 25.0));
        window.run();
    }
    window.drop_at(cube.center() + egui::vec2(40.0, 25.0));
    window.run();
    let turned = look(&window);
    assert!(turned.0 != before.0 && turned.1 == before.1);
    // From this side three faces are seen, one of them in the middle.
    window.hover_at(cube.center());
    window.run();
    find(&window, Role::Button, "Orientation cube").click();
    window.run();
    let (eye, target) = look(&window);
    let toward = (eye - target).normalize();
    assert!(toward.abs().max_element() > 0.9999, "{toward}");
    assert_eq!(window.state().app.selection, selected);
    assert!(viewport(&window).is_focused());
    hold(&mut window, Modifiers::NONE, Key::W);
    assert_ne!(look(&window).0, eye);
}

#[test]
fn panels_are_hidden_and_come_back() {
    let mut window = window(opened("cornell.grf"));
    let widths = |window: &TestWindow| viewport(window).rect().width();
    let both = widths(&window);
    // The window without a screen has a margin of 8 points.
    assert!((both - (1184.0 - 220.0 - 380.0)).abs() < 2.0, "{both}");
    press(&mut window, Modifiers::NONE, Key::F3);
    press(&mut window, Modifiers::NONE, Key::F4);
    assert!((widths(&window) - 1184.0).abs() < 2.0);
    assert!(!says(&window, "Materials"));
    // Renaming happens in the tree.
    let id = window.state().app.document.objects[0].id;
    let selection = azulejo_workbench::command::Selection::one(id);
    window.state_mut().app.selection = selection;
    press(&mut window, Modifiers::NONE, Key::F2);
    assert!(window.state().app.preferences.shows_tree);
    press(&mut window, Modifiers::NONE, Key::Escape);
    press(&mut window, Modifiers::NONE, Key::F4);
    assert_eq!(widths(&window), both);
}

#[test]
fn a_panel_keeps_the_width_to_which_it_was_dragged() {
    let mut window = window(opened("cornell.grf"));
    let edge = viewport(&window).rect().right_center() + egui::vec2(2.0, 0.0);
    window.hover_at(edge);
    window.run();
    window.drag_at(edge);
    window.run();
    window.hover_at(edge + egui::vec2(50.0, 0.0));
    window.run();
    window.drop_at(edge + egui::vec2(100.0, 0.0));
    window.run();
    let kept = window.state().app.preferences.properties_width;
    assert!((kept - 280.0).abs() < 4.0, "{kept}");
    let right = viewport(&window).rect().right();
    // The window without a screen has a margin of 8 points.
    assert!((1192.0 - right - kept).abs() < 2.0);
}

#[test]
fn keys_turn_shift_and_bring_nearer() {
    let mut window = window(opened("cornell.grf"));
    let distance = |(eye, target): (DVec3, DVec3)| eye.distance(target);
    let before = look(&window);
    hold(&mut window, Modifiers::SHIFT, Key::ArrowRight);
    let turned = look(&window);
    assert!(turned.0 != before.0 && turned.1 == before.1);
    assert!((distance(turned) - distance(before)).abs() < 1e-6 * distance(before));
    hold(&mut window, Modifiers::COMMAND, Key::ArrowUp);
    let shifted = look(&window);
    assert!(shifted.1 != turned.1);
    assert!((distance(shifted) - distance(turned)).abs() < 1e-6 * distance(before));
    hold(&mut window, Modifiers::NONE, Key::Plus);
    let near = look(&window);
    assert!(near.1 == shifted.1 && distance(near) < distance(shifted));
    hold(&mut window, Modifiers::NONE, Key::Minus);
    assert!(distance(look(&window)) > distance(near));
}

#[test]
fn keys_are_for_the_dialog_that_is_open() {
    let mut window = window(opened("cornell.grf"));
    let before = look(&window);
    window
        .state_mut()
        .run_action(ActionTarget::Window(WindowAction::Preferences));
    window.run();
    hold(&mut window, Modifiers::NONE, Key::W);
    assert_eq!(look(&window), before);
}

#[test]
fn keys_point_at_the_middle() {
    let mut window = window(opened("cornell.grf"));
    viewport(&window).focus();
    window.run();
    press(&mut window, Modifiers::NONE, Key::Enter);
    assert_eq!(window.state().app.selection.ids.len(), 1);
    press(&mut window, Modifiers::NONE, Key::P);
    assert_eq!(window.state().app.probes.len(), 1);
    press(&mut window, Modifiers::ALT, Key::Enter);
    let faces = window.state().app.selection.faces.clone();
    assert!(faces.is_some_and(|(_, faces)| faces.len() == 1));
}

#[test]
fn a_probe_that_waits_for_a_place_is_given_up_wherever_the_mouse_is() {
    let mut window = window(opened("cornell.grf"));
    let probes = |window: &TestWindow| window.state().app.probes.len();
    let wait_for_place = |window: &mut TestWindow| {
        window.hover_at(egui::pos2(5.0, 5.0));
        window.run();
        window
            .state_mut()
            .run_action(ActionTarget::Window(WindowAction::AddProbe));
        window.run();
    };
    wait_for_place(&mut window);
    viewport(&window).click();
    window.run();
    assert_eq!(probes(&window), 1);
    wait_for_place(&mut window);
    press(&mut window, Modifiers::NONE, Key::Escape);
    viewport(&window).click();
    window.run();
    assert_eq!(probes(&window), 1);
}
