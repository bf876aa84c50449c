//! The list of keyboard and mouse shortcuts.

use crate::ui::actions::{ACTIONS, Menu, key_text};
use crate::ui::focus;
use crate::ui::panel_context::PanelContext;
use clap::ValueEnum;
use egui::{Grid, Id, Modal, Ui};

/// Draws the list of shortcuts while it is open.
pub(super) fn show(ui: &Ui, cx: &PanelContext, is_open: &mut bool) {
    if !*is_open {
        return;
    }
    let mut is_done = false;
    let modal = Modal::new(Id::unique("keys")).show(ui.ctx(), |ui| {
        ui.set_width(640f32.min(ui.ctx().content_rect().width() - 60.0));
        ui.heading(cx.tr("Keyboard and mouse"));
        egui::ScrollArea::vertical()
            .max_height(460f32.min(ui.ctx().content_rect().height() - 140.0))
            .show(ui, |ui| {
                focus::scroll_by_keys(ui, true);
                mouse_help(ui, cx);
                key_help(ui, cx);
            });
        let close = ui.button(cx.tr("Close"));
        focus::at_first(&close);
        focus::keep_arrows(&close);
        is_done = close.clicked();
    });
    *is_open = !(is_done || modal.should_close());
}

fn mouse_help(ui: &mut Ui, cx: &PanelContext) {
    let rows = [
        (cx.tr("Drag"), cx.tr("Orbit around the centre of the view")),
        (
            cx.tr("Right or middle drag, or Shift and drag"),
            cx.tr("Pan the view"),
        ),
        (cx.tr("Wheel, or Ctrl and drag"), cx.tr("Zoom")),
        (
            cx.tr("Click"),
            cx.tr("Select an object; with Ctrl, add it to the selection; with Alt, select a face"),
        ),
        (cx.tr("Double click"), cx.tr("Frame the object")),
        (
            cx.tr("W A S D, R F"),
            cx.tr("Fly forward, left, back, right, up, down"),
        ),
        (cx.tr("Drag while flying"), cx.tr("Look around")),
        (cx.tr("Arrows"), cx.tr("Turn the camera")),
        (cx.tr("Shift + arrows"), cx.tr("Orbit around the model")),
        (cx.tr("Ctrl + arrows"), cx.tr("Pan the view")),
        ("+ −", cx.tr("Zoom")),
        (
            cx.tr("Enter, with the viewport in focus"),
            cx.tr("Click at its centre; with Alt, select a face"),
        ),
        (
            cx.tr("Drag an arrow of the selection"),
            cx.tr("Move it along the axis"),
        ),
    ];
    Grid::new("mouse")
        .num_columns(2)
        .striped(true)
        .show(ui, |ui| {
            for (what, does) in rows {
                ui.strong(what);
                ui.label(does);
                ui.end_row();
            }
        });
}

/// Two columns of menus with their shortcuts.
fn key_help(ui: &mut Ui, cx: &PanelContext) {
    let (left, right) = Menu::value_variants().split_at(Menu::value_variants().len() / 2);
    ui.columns(2, |columns| {
        for (column, menus) in columns.iter_mut().zip([left, right]) {
            key_column(column, cx, menus);
        }
    });
}

fn key_column(ui: &mut Ui, cx: &PanelContext, menus: &[Menu]) {
    for &menu in menus {
        let keyed: Vec<_> = (ACTIONS.iter())
            .filter(|a| a.menu == menu && a.key.is_some())
            .collect();
        if keyed.is_empty() {
            continue;
        }
        ui.add_space(8.0);
        ui.strong(menu.label(cx.language));
        Grid::new(("keys", menu.label(cx.language)))
            .num_columns(2)
            .striped(true)
            .show(ui, |ui| {
                for action in keyed {
                    let key = action.key.map(|k| key_text(ui.ctx(), &k, cx.language));
                    ui.monospace(key.unwrap_or_default());
                    ui.label(cx.tr(action.label));
                    ui.end_row();
                }
            });
    }
}
