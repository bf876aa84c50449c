//! Mouse and keys that move the view.

use crate::app::App;
use crate::view::View;
use egui::{Key, PointerButton, Response, Ui};
use glam::DVec3;

/// Radians per point of dragging.
const TURN: f64 = 0.008;
/// Share of the model that is flown in a second.
const FLIGHT: f64 = 0.25;
/// Radians per second of turning the head.
const HEAD: f64 = 1.0;

/// The view after this frame's mouse and keys; whether it must be drawn again at once because a
/// key is held.
pub fn navigate(ui: &Ui, response: &Response, app: &App) -> (View, bool) {
    let mut view = app.view.clone();
    let up = app.document.units.up.axis();
    drag(ui, response, &mut view, up);
    wheel(ui, response, &mut view);
    let flies = fly(ui, app, &mut view, up);
    (view, flies)
}

fn drag(ui: &Ui, response: &Response, view: &mut View, up: DVec3) {
    let by = response.drag_delta();
    if by == egui::Vec2::ZERO {
        return;
    }
    let (dx, dy) = (f64::from(by.x), f64::from(by.y));
    let height = f64::from(response.rect.height().max(1.0));
    let modifiers = ui.input(|i| i.modifiers);
    let shifts = response.dragged_by(PointerButton::Secondary)
        || response.dragged_by(PointerButton::Middle)
        || modifiers.shift;
    if shifts {
        view.pan(-dx / height, dy / height);
    } else if modifiers.command {
        view.zoom((dy / 150.0).exp());
    } else {
        view.orbit(TURN * dx, TURN * dy, up);
    }
}

fn wheel(ui: &Ui, response: &Response, view: &mut View) {
    if !response.hovered() {
        return;
    }
    let (scroll, pinch) = ui.input(|i| (i.smooth_scroll_delta.y, i.zoom_delta()));
    if scroll != 0.0 {
        view.zoom((-f64::from(scroll) / 300.0).exp());
    }
    if pinch != 1.0 {
        view.zoom(1.0 / f64::from(pinch));
    }
}

/// Keys that fly, as long as they are held and no text is being written.
fn fly(ui: &Ui, app: &App, view: &mut View, up: DVec3) -> bool {
    if ui.ctx().egui_wants_keyboard_input() {
        return false;
    }
    let (step, yaw, pitch, dt) = ui.input(|i| {
        if i.modifiers.any() {
            return (DVec3::ZERO, 0.0, 0.0, 0.0);
        }
        let held = |key| f64::from(u8::from(i.key_down(key)));
        let step = DVec3::new(
            held(Key::D) - held(Key::A),
            held(Key::R) - held(Key::F),
            held(Key::W) - held(Key::S),
        );
        let yaw = held(Key::ArrowRight) - held(Key::ArrowLeft);
        let pitch = held(Key::ArrowUp) - held(Key::ArrowDown);
        (step, yaw, pitch, f64::from(i.stable_dt.min(0.1)))
    });
    let moves = step != DVec3::ZERO || yaw != 0.0 || pitch != 0.0;
    if moves {
        let reach = app.document.bounds(None).diagonal().max(1e-6);
        view.fly(
            step * (FLIGHT * reach * dt),
            yaw * HEAD * dt,
            pitch * HEAD * dt,
            up,
        );
    }
    moves
}
