//! Navigation with mouse and keyboard.

use crate::app::App;
use crate::ui::focus::keep_arrows;
use crate::view::ModelView;
use egui::{Key, Modifiers, PointerButton, Response, Ui};
use glam::DVec3;

/// Radians per point of dragging.
pub(super) const TURN: f64 = 0.008;
/// Flying speed in sizes of the model per second.
const FLIGHT: f64 = 0.25;
/// Turning speed in radians per second.
const HEAD: f64 = 1.0;

/// Panning speed by keyboard, in heights of the view per second.
const SHIFT: f64 = 0.5;
/// Change of the distance per second of zooming by keyboard.
const NEARER: f64 = 0.4;

/// The view after this frame's input; also whether to repaint at once because a key is held.
pub fn navigate(ui: &Ui, response: &Response, app: &App) -> (ModelView, bool) {
    let mut view = app.view.clone();
    let up = app.document.units.up.axis();
    let held = HeldKeys::now(ui, response);
    drag(ui, response, &mut view, up, held.flies());
    wheel(ui, response, &mut view);
    let is_held = held.any();
    if is_held {
        let reach = app.document.bounds(None).diagonal().max(1e-6);
        held.move_view(&mut view, reach, up);
    }
    (view, is_held)
}

fn drag(ui: &Ui, response: &Response, view: &mut ModelView, up: DVec3, flies: bool) {
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
    if flies {
        // While flying, the mouse looks around.
        view.fly(DVec3::ZERO, TURN * dx, -TURN * dy, up);
    } else if shifts {
        view.pan(-dx / height, dy / height);
    } else if modifiers.command {
        view.zoom((dy / 150.0).exp());
    } else {
        view.orbit(TURN * dx, TURN * dy, up);
    }
}

fn wheel(ui: &Ui, response: &Response, view: &mut ModelView) {
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

/// Held keys, and the time since the last frame.
#[derive(Default)]
struct HeldKeys {
    /// Right, up and forward: -1, 0 or 1.
    step: DVec3,
    /// Arrow keys: right and up.
    arrows: (f64, f64),
    /// Closer or further away.
    zoom: f64,
    modifiers: Modifiers,
    seconds: f64,
}

impl HeldKeys {
    /// No keys are held while another widget has the focus.
    fn now(ui: &Ui, response: &Response) -> HeldKeys {
        if response.has_focus() {
            keep_arrows(response);
        } else if ui.memory(|m| m.focused()).is_some() {
            return HeldKeys::default();
        }
        ui.input(|i| {
            let held = |key| f64::from(u8::from(i.key_down(key)));
            let letters = if i.modifiers.any() {
                DVec3::ZERO
            } else {
                DVec3::new(
                    held(Key::D) - held(Key::A),
                    held(Key::R) - held(Key::F),
                    held(Key::W) - held(Key::S),
                )
            };
            let plus = held(Key::Plus).max(held(Key::Equals));
            let signs = plus - held(Key::Minus);
            HeldKeys {
                step: letters,
                arrows: (
                    held(Key::ArrowRight) - held(Key::ArrowLeft),
                    held(Key::ArrowUp) - held(Key::ArrowDown),
                ),
                // Typing a plus may need Shift; with Ctrl these keys scale the window.
                zoom: if i.modifiers.command { 0.0 } else { signs },
                modifiers: i.modifiers,
                seconds: f64::from(i.stable_dt.min(0.1)),
            }
        })
    }

    fn flies(&self) -> bool {
        self.step != DVec3::ZERO
    }

    fn any(&self) -> bool {
        self.flies() || self.arrows != (0.0, 0.0) || self.zoom != 0.0
    }

    /// Moves the view; `reach` is the size of the model.
    fn move_view(&self, view: &mut ModelView, reach: f64, up: DVec3) {
        let dt = self.seconds;
        if self.arrows != (0.0, 0.0) {
            let (x, y) = (self.arrows.0 * dt, self.arrows.1 * dt);
            if self.modifiers.command {
                view.pan(SHIFT * x, SHIFT * y);
            } else if self.modifiers.shift {
                view.orbit(HEAD * x, -HEAD * y, up);
            } else {
                view.fly(DVec3::ZERO, HEAD * x, HEAD * y, up);
            }
        }
        if self.zoom != 0.0 {
            view.zoom(NEARER.powf(self.zoom * dt));
        }
        if self.flies() {
            view.fly(self.step * (FLIGHT * reach * dt), 0.0, 0.0, up);
        }
    }
}
