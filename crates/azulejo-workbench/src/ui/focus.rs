//! Keyboard focus.

use egui::{EventFilter, Response};

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
