//! The preferences.

use crate::command::Command;
use crate::preferences::{MAX_GATHER, Preferences, Theme};
use crate::ui::focus;
use crate::ui::panel_context::PanelContext;
use crate::view::ColorMap;
use crate::words::Language;
use egui::{DragValue, Grid, Id, Modal, Slider, Ui};

/// Draws the preferences while they are open.
pub(super) fn show(ui: &Ui, cx: &mut PanelContext, is_open: &mut bool) {
    if !*is_open {
        return;
    }
    let old = &cx.app.preferences;
    let mut new = old.clone();
    let mut is_done = false;
    let modal = Modal::new(Id::unique("preferences")).show(ui.ctx(), |ui| {
        ui.set_width(420.0);
        ui.heading(cx.tr("Preferences"));
        Grid::new("preferences")
            .num_columns(2)
            .spacing([16.0, 6.0])
            .show(ui, |ui| preference_rows(ui, cx, &mut new));
        is_done = ui.button(cx.tr("Close")).clicked();
    });
    if new != *old {
        cx.send(Command::SetPreferences(Box::new(new)));
    }
    *is_open = !(is_done || modal.should_close());
}

fn preference_rows(ui: &mut Ui, cx: &PanelContext, new: &mut Preferences) {
    let tr = |text| cx.tr(text);
    let label = ui.label(tr("Language"));
    egui::ComboBox::new("language", "")
        .selected_text(new.language.name())
        .show_ui(ui, |ui| {
            focus::close_list(ui);
            for language in Language::ALL {
                ui.selectable_value(&mut new.language, language, language.name());
            }
        })
        .response
        .labelled_by(label.id);
    ui.end_row();
    ui.label(tr("Theme"));
    ui.horizontal(|ui| {
        ui.selectable_value(&mut new.theme, Theme::System, tr("System"));
        ui.selectable_value(&mut new.theme, Theme::Light, tr("Light theme"));
        ui.selectable_value(&mut new.theme, Theme::Dark, tr("Dark theme"));
    });
    ui.end_row();
    let label = ui.label(tr("Interface scale"));
    let slider = Slider::new(&mut new.scale, 0.5..=3.0).step_by(0.1);
    ui.add(slider.update_while_editing(false))
        .labelled_by(label.id);
    ui.end_row();
    let label = ui.label(tr("Colour map"));
    egui::ComboBox::new("map", "")
        .selected_text(map_name(new.color_map, cx))
        .show_ui(ui, |ui| {
            focus::close_list(ui);
            for map in ColorMap::ALL {
                ui.selectable_value(&mut new.color_map, map, map_name(map, cx));
            }
        })
        .response
        .labelled_by(label.id);
    ui.end_row();
    let label = ui.label(tr("Recovery copy after"));
    let drag = DragValue::new(&mut new.autosave)
        .range(0..=3_600)
        .suffix(" s");
    ui.add(drag)
        .on_hover_text(tr("0 s: never"))
        .labelled_by(label.id);
    ui.end_row();
    let label = ui.label(tr("Threads"));
    let drag = DragValue::new(&mut new.threads).range(0..=256);
    ui.add(drag)
        .on_hover_text(tr("0: all but one, which is reserved for the window"))
        .labelled_by(label.id);
    ui.end_row();
    let label = ui.label(tr("Paths per pixel of a render"));
    let drag = DragValue::new(&mut new.picture_samples).range(1..=65_536);
    ui.add(drag).labelled_by(label.id);
    ui.end_row();
    let label = ui.label(tr("Final gather rays"));
    let drag = DragValue::new(&mut new.picture_gather).range(0..=MAX_GATHER);
    let about = tr("More rays give less noise and take longer; 0 for the usual 8.");
    ui.add(drag).labelled_by(label.id).on_hover_text(about);
    ui.end_row();
}

/// The name of a colour map.
pub fn map_name(map: ColorMap, cx: &PanelContext) -> &'static str {
    match map {
        ColorMap::Viridis => "viridis",
        ColorMap::Cividis => "cividis",
        ColorMap::Magma => "magma",
        ColorMap::Grey => cx.tr("grey"),
    }
}
