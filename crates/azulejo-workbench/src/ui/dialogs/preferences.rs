//! The preferences.

use crate::command::Command;
use crate::preferences::{MAX_GATHER, Preferences, Theme};
use crate::ui::inputs::{self, labelled_row};
use crate::ui::panel_context::PanelContext;
use crate::variants::all;
use crate::view::ColorMap;
use crate::words::Language;
use egui::{ComboBox, DragValue, Grid, Id, Modal, Slider, Ui};

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
    let (combo, language) = (ComboBox::new("language", ""), &mut new.language);
    inputs::choice(combo, ui, language, Language::ALL, |l| l.name()).labelled_by(label.id);
    ui.end_row();
    ui.label(tr("Theme"));
    ui.horizontal(|ui| {
        ui.selectable_value(&mut new.theme, Theme::System, tr("System"));
        ui.selectable_value(&mut new.theme, Theme::Light, tr("Light theme"));
        ui.selectable_value(&mut new.theme, Theme::Dark, tr("Dark theme"));
    });
    ui.end_row();
    let slider = Slider::new(&mut new.scale, 0.5..=3.0).step_by(0.1);
    let slider = slider.update_while_editing(false);
    labelled_row(ui, tr("Interface scale"), slider);
    let label = ui.label(tr("Colour map"));
    let (combo, map) = (ComboBox::new("map", ""), &mut new.color_map);
    inputs::choice(combo, ui, map, all(), |&m| map_name(m, cx)).labelled_by(label.id);
    ui.end_row();
    let drag = DragValue::new(&mut new.autosave).range(0..=3_600);
    labelled_row(ui, tr("Recovery copy after"), drag.suffix(" s")).on_hover_text(tr("0 s: never"));
    let drag = DragValue::new(&mut new.threads).range(0..=256);
    labelled_row(ui, tr("Threads"), drag)
        .on_hover_text(tr("0: all but one, which is reserved for the window"));
    let drag = DragValue::new(&mut new.picture_samples).range(1..=65_536);
    labelled_row(ui, tr("Paths per pixel of a render"), drag);
    let drag = DragValue::new(&mut new.picture_gather).range(0..=MAX_GATHER);
    let about = tr("More rays give less noise and take longer; 0 for the usual 8.");
    labelled_row(ui, tr("Final gather rays"), drag).on_hover_text(about);
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
