//! The dialog for a lightmap.

use crate::bake::BakeSettings;
use crate::command::Command;
use crate::ui::inputs;
use crate::ui::panel_context::PanelContext;
use azulejo::formats::gltf::patch::Convention;
use azulejo::lightmap::{BakedLight, BakedSides};
use egui::{ComboBox, DragValue, Grid, Id, Modal, Ui};

/// Texels per metre when the size of pages is no longer given: two centimetres.
const DEFAULT_DENSITY: f64 = 50.0;

/// The dialog for a lightmap.
#[derive(Clone, Debug)]
pub struct BakeDialog {
    settings: BakeSettings,
}

impl BakeDialog {
    /// Starts with these settings.
    pub fn new(settings: BakeSettings) -> BakeDialog {
        BakeDialog { settings }
    }

    /// Draws the dialog; returns whether it is finished.
    pub(super) fn show(&mut self, ui: &Ui, cx: &mut PanelContext) -> bool {
        let mut done = false;
        let modal = Modal::new(Id::unique("bake")).show(ui.ctx(), |ui| {
            ui.set_width(400.0);
            ui.heading(cx.tr("Bake a lightmap"));
            let grid = Grid::new("bake").num_columns(2).spacing([12.0, 5.0]);
            grid.show(ui, |ui| {
                self.resolution(ui, cx);
                self.error(ui, cx);
                self.light(ui, cx);
                self.sides(ui, cx);
                self.convention(ui, cx);
            });
            ui.horizontal(|ui| {
                if ui.button(cx.tr("Bake")).clicked() {
                    cx.send(Command::SetBake(self.settings));
                    cx.send(Command::Bake);
                    done = true;
                }
                done |= ui.button(cx.tr("Cancel")).clicked();
            });
        });
        done || modal.should_close()
    }

    fn resolution(&mut self, ui: &mut Ui, cx: &PanelContext) {
        let density = &mut self.settings.texels_per_metre;
        if ui.radio(density.is_none(), cx.tr("Page size")).clicked() {
            *density = None;
        }
        let drag = DragValue::new(&mut self.settings.size)
            .range(16..=8192)
            .speed(8.0)
            .update_while_editing(false);
        let field = ui.add_enabled(density.is_none(), drag);
        label(&field, cx.tr("Page size"));
        ui.end_row();
        let about = cx.tr("On as many pages as needed.");
        let radio = ui.radio(density.is_some(), cx.tr("Texels per metre"));
        if radio.on_hover_text(about).clicked() {
            density.get_or_insert(DEFAULT_DENSITY);
        }
        let mut shown = density.unwrap_or(DEFAULT_DENSITY);
        let drag = DragValue::new(&mut shown)
            .range(1e-3..=1e5)
            .speed(0.5)
            .max_decimals(3)
            .update_while_editing(false);
        let field = ui.add_enabled(density.is_some(), drag);
        label(&field, cx.tr("Texels per metre"));
        if field.changed() {
            *density = Some(shown);
        }
        ui.end_row();
    }

    fn error(&mut self, ui: &mut Ui, cx: &PanelContext) {
        let about = cx.tr(
            "Estimated error of all texels relative to their mean. Half the error takes up to four times as long.",
        );
        let name = cx.tr("Target error");
        inputs::error_row(ui, name, about, &mut self.settings.error);
    }

    fn light(&mut self, ui: &mut Ui, cx: &PanelContext) {
        let choices = [
            (BakedLight::Total, cx.tr("Direct and indirect")),
            (BakedLight::Indirect, cx.tr("Indirect only")),
            (BakedLight::Direct, cx.tr("Direct only")),
        ];
        let about = cx.tr("Viewers that add direct light themselves need indirect light only.");
        choice(
            ui,
            cx.tr("Baked light"),
            about,
            &choices,
            &mut self.settings.light,
        );
    }

    fn sides(&mut self, ui: &mut Ui, cx: &PanelContext) {
        let choices = [
            (None, cx.tr("Default of the file format")),
            (Some(BakedSides::Front), cx.tr("Front")),
            (Some(BakedSides::Brighter), cx.tr("Brighter side")),
            (Some(BakedSides::Both), cx.tr("Both, as separate faces")),
        ];
        let about = cx.tr(
            "glTF states which side of a surface is the front; for other formats, each chart gets the light of its brighter side.",
        );
        choice(
            ui,
            cx.tr("Lit side"),
            about,
            &choices,
            &mut self.settings.sides,
        );
    }

    fn convention(&mut self, ui: &mut Ui, cx: &PanelContext) {
        let choices = [
            (Convention::Moz, cx.tr("MOZ_lightmap of materials")),
            (Convention::Mx, cx.tr("MX_lightmap of nodes")),
            (Convention::Plain, cx.tr("Texture coordinates only")),
        ];
        let about = cx.tr("How the file refers to the lightmap.");
        let convention = &mut self.settings.convention;
        choice(ui, cx.tr("Convention"), about, &choices, convention);
    }
}

/// Names a field for those who do not see what stands beside it.
fn label(field: &egui::Response, name: &str) {
    field.clone().accessible_name(name);
}

/// A row with a list to choose from.
fn choice<T: Copy + PartialEq>(
    ui: &mut Ui,
    name: &str,
    about: &str,
    all: &[(T, &str)],
    value: &mut T,
) {
    let title = ui.label(name).on_hover_text(about);
    let entries = all.iter().map(|(value, _)| *value);
    let name_of = |value: &T| all.iter().find(|a| a.0 == *value).map_or("", |a| a.1);
    inputs::choice(
        ComboBox::from_id_salt(name).width(220.0),
        ui,
        value,
        entries,
        name_of,
    )
    .labelled_by(title.id)
    .on_hover_text(about);
    ui.end_row();
}
