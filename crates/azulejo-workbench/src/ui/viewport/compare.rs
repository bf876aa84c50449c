//! Two pictures of the model side by side, with a handle between them.

use super::super::actions::shading_action;
use super::super::panel_context::PanelContext;
use crate::command::Command;
use crate::view::{Comparison, ModelView, Shading};
use egui::{
    Align2, Color32, CursorIcon, FontId, Key, Painter, Pos2, Rect, Sense, Shape, Stroke, Ui, Vec2,
};

/// Width of what can be dragged, points.
const HANDLE: f32 = 14.0;

/// The part of the viewport that the right picture covers.
pub fn right_part(rect: Rect, comparison: &Comparison) -> Rect {
    let x = rect.left() + comparison.at.clamp(0.0, 1.0) * rect.width();
    Rect::from_min_max(Pos2::new(x, rect.top()), rect.max)
}

/// Draws the handle between both pictures, and the name of each; dragging it, or the arrow keys
/// while it has the focus, moves it.
pub fn divider(ui: &mut Ui, rect: Rect, cx: &mut PanelContext, view: &ModelView) {
    let Some(comparison) = view.comparison else {
        return;
    };
    let x = right_part(rect, &comparison).left();
    let band = Rect::from_x_y_ranges(x - 0.5 * HANDLE..=x + 0.5 * HANDLE, rect.y_range());
    let response = ui.interact(band, ui.scope_id().with("divider"), Sense::click_and_drag());
    let name = cx.tr("Divider between the two images");
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Slider, true, name));
    if response.hovered() || response.dragged() {
        ui.ctx().set_cursor_icon(CursorIcon::ResizeHorizontal);
    }
    let mut at = comparison.at;
    if response.dragged() {
        at += response.drag_delta().x / rect.width().max(1.0);
    }
    if response.has_focus() {
        super::super::focus::keep_arrows(&response);
        let step = |key| ui.input(|i| i.num_presses(key)) as f32 * 0.02;
        at += step(Key::ArrowRight) - step(Key::ArrowLeft);
    }
    let at = at.clamp(0.0, 1.0);
    if at != comparison.at {
        let mut moved = view.clone();
        moved.comparison = Some(Comparison { at, ..comparison });
        cx.send(Command::SetView(Box::new(moved)));
    }
    let painter = ui.painter().with_clip_rect(rect);
    let width = if response.has_focus() { 3.0 } else { 1.5 };
    for (width, color) in [(width + 2.0, Color32::BLACK), (width, Color32::WHITE)] {
        painter.vline(x, rect.y_range(), Stroke::new(width, color));
    }
    let grip = Pos2::new(x, rect.center().y);
    painter.circle(grip, 9.0, Color32::WHITE, Stroke::new(1.5, Color32::BLACK));
    for side in [-1.0, 1.0] {
        let at = |x: f32, y: f32| grip + Vec2::new(side * x, y);
        let head = vec![at(6.5, 0.0), at(2.0, -3.5), at(2.0, 3.5)];
        painter.add(Shape::convex_polygon(head, Color32::BLACK, Stroke::NONE));
    }
    // Below the buttons of the selection.
    let top = rect.top() + 38.0;
    label(
        &painter,
        Pos2::new(x - 14.0, top),
        Align2::RIGHT_TOP,
        title(cx, view.shading),
    );
    label(
        &painter,
        Pos2::new(x + 14.0, top),
        Align2::LEFT_TOP,
        title(cx, comparison.with),
    );
}

/// The name of a shading mode, as in the menu.
fn title(cx: &PanelContext, shading: Shading) -> &'static str {
    shading_action(cx.app, shading).map_or("", |a| cx.tr(a.label))
}

fn label(painter: &Painter, at: Pos2, align: Align2, text: &str) {
    let font = FontId::proportional(13.0);
    let galley = painter.layout_no_wrap(text.into(), font, Color32::WHITE);
    let place = align.anchor_size(at, galley.size());
    painter.rect_filled(
        place.expand2(Vec2::new(6.0, 3.0)),
        4.0,
        Color32::from_black_alpha(170),
    );
    painter.galley(place.min, galley, Color32::WHITE);
}
