//! Keys of what has the focus.

use egui::{EventFilter, Response};

/// Keeps the arrows for what has the focus: they do not go to another part of the window.
pub fn keep_arrows(response: &Response) {
    let filter = EventFilter {
        horizontal_arrows: true,
        vertical_arrows: true,
        ..EventFilter::default()
    };
    let context = &response.ctx;
    context.memory_mut(|m| m.set_focus_lock_filter(response.id, filter));
}
