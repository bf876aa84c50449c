//! Keyboard focus: where it is seen, where it returns to, and what scrolls with it.

use egui::{Context, Event, EventFilter, Id, Key, Popup, Response, StrokeKind, Ui, Vec2};

/// Reserves the arrow keys for the focused widget: they do not move the focus.
pub fn keep_arrows(response: &Response) {
    let filter = EventFilter {
        horizontal_arrows: true,
        vertical_arrows: true,
        ..EventFilter::default()
    };
    let context = &response.ctx;
    context.memory_mut(|m| m.set_focus_lock_filter(response.id, filter));
}

/// Scrolls to the widget that has just got the focus, if it is one of this area that does not show.
/// To be called within the area, after its contents.
pub fn follow(ui: &Ui) {
    let focused = ui.memory(|m| m.focused());
    let key = ui.scope_id().with("followed");
    let last: Option<Id> = ui.data(|d| d.get_temp(key)).flatten();
    if focused == last {
        return;
    }
    ui.data_mut(|d| d.insert_temp(key, focused));
    let Some(response) = focused.and_then(|id| ui.ctx().read_response(id)) else {
        return;
    };
    let area = ui.clip_rect();
    let is_cut = response.interact_rect.height() < response.rect.height().min(area.height()) - 0.5;
    let is_beside = area.x_range().contains(response.rect.center().x);
    if response.layer_id == ui.layer_id() && is_cut && is_beside {
        ui.scroll_to_rect(response.rect.expand(4.0), None);
    }
}

/// Scrolls an area by the page keys, and by the arrows if nothing has the focus that takes them. To be
/// called within the area.
pub fn scroll_by_keys(ui: &Ui, takes_arrows: bool) {
    let page = 0.8 * ui.clip_rect().height();
    let presses = |key| ui.input(|i| i.num_presses(key)) as f32;
    let mut way = page * (presses(Key::PageUp) - presses(Key::PageDown));
    if takes_arrows {
        let line = 2.0 * ui.text_style_height(&egui::TextStyle::Body);
        way += line * (presses(Key::ArrowUp) - presses(Key::ArrowDown));
    }
    if way != 0.0 {
        ui.scroll_with_delta(Vec2::new(0.0, way));
    }
}

/// Gives a widget the focus in the first frame in which it is drawn, and again after it was gone.
pub fn at_first(response: &Response) {
    let context = &response.ctx;
    let key = response.id.with("drawn in");
    let frame = context.cumulative_frame_nr();
    let last: Option<u64> = context.data(|d| d.get_temp(key));
    context.data_mut(|d| d.insert_temp(key, frame));
    if last.is_none_or(|last| last + 1 < frame) {
        response.request_focus();
    }
}

/// Closes the list of a combo box when the keyboard has chosen one of its entries. To be called within
/// the list, after its entries.
pub fn close_list(ui: &Ui) {
    let chooses = ui.input(|i| i.key_pressed(Key::Enter) || i.key_pressed(Key::Space));
    let focused = ui.memory(|m| m.focused());
    let focused = focused.and_then(|id| ui.ctx().read_response(id));
    if chooses && focused.is_some_and(|r| r.layer_id == ui.layer_id()) {
        ui.close();
    }
}

/// What the keyboard has the focus on, from frame to frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct FocusTrail {
    last: Option<Id>,
    /// Where the focus was when a dialog, a menu or a list opened.
    before: Option<Id>,
    was_open: bool,
    /// Where the focus returns to, and for how many frames more that is tried: what has closed may
    /// take it away once more.
    returns: Option<(Id, u8)>,
    /// Whether the focus was moved by the keyboard, and not by a click.
    by_keys: bool,
}

impl FocusTrail {
    /// Called at the end of a frame; `has_dialog` tells whether a dialog is open. Outlines the focused
    /// widget while the keyboard is used, and gives the focus back when what had taken it closes.
    pub fn end_frame(&mut self, context: &Context, has_dialog: bool) {
        // Keys that may move the focus switch its outline on, and clicks switch it off.
        let (moves, clicks) = context.input(|i| {
            let keys = [
                Key::Tab,
                Key::ArrowUp,
                Key::ArrowDown,
                Key::ArrowLeft,
                Key::ArrowRight,
                Key::F10,
            ];
            let with_alt = |event: &Event| match event {
                Event::Key {
                    pressed: true,
                    modifiers,
                    ..
                } => modifiers.alt,
                _ => false,
            };
            let moves = keys.iter().any(|&key| i.key_pressed(key)) || i.events.iter().any(with_alt);
            (moves, i.pointer.any_pressed())
        });
        self.by_keys = (self.by_keys || moves) && !clicks;
        // Keep the focus of the frame before: what opens may have taken it already.
        let is_open = has_dialog || Popup::is_any_open(context);
        if is_open && !self.was_open {
            self.before = self.last;
        }
        // When it closes, keyboard users get the focus back where it was.
        let focused = context.memory(|m| m.focused());
        if self.was_open && !is_open && self.by_keys {
            self.returns = self.before.take().map(|id| (id, 4));
        }
        // Try for some frames; a click, or what opens next, ends that.
        self.returns = self.returns.filter(|_| !is_open && !clicks);
        if let Some((id, tries)) = self.returns {
            if focused.is_none() {
                context.memory_mut(|m| m.request_focus(id));
            }
            self.returns = (tries > 1).then_some((id, tries - 1));
            context.request_repaint();
        }
        (self.was_open, self.last) = (is_open, focused);
        if self.by_keys {
            outline(context, focused);
        }
    }
}

/// Draws a line around the focused widget, where it shows.
fn outline(context: &Context, focused: Option<Id>) {
    let response = focused.and_then(|id| context.read_response(id));
    let Some(response) = response.filter(|r| r.interact_rect.is_positive()) else {
        return;
    };
    let stroke = context.style_of(context.theme()).visuals.selection.stroke;
    let stroke = egui::Stroke::new(2.0, stroke.color);
    let painter = context.layer_painter(response.layer_id);
    let around = response.interact_rect.expand(1.0);
    painter.rect_stroke(around, 3.0, stroke, StrokeKind::Middle);
}
