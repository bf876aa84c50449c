//! The BRDF editor: the reflection of a material in numbers and plots.
//!
//! It has no mathematics of its own: it evaluates [`azulejo::scene::brdf`] and draws the results.
//! Slow computations run in threads of the editor; until they finish, the last result is displayed.
//! A [`BrdfEditor`] holds no part of the document: it receives a material and responds with a
//! changed
//! one, or requests a file.
//!
//! ```no_run
//! use azulejo_workbench::ui::brdf::{BrdfEditor, EditorInput, EditorResponse, PreviewLight};
//! use azulejo_workbench::words::Language;
//! use std::sync::Arc;
//!
//! let light = PreviewLight::studio();
//! let (mut editor, material) = (BrdfEditor::default(), Arc::default());
//! let mut panel = |ui: &mut egui::Ui| {
//!     let input = EditorInput { key: 7, material: &material, others: &[], light: &light,
//! is_photometric: false };
//!     for response in editor.ui(ui, Language::English, &input) {
//!         match response {
//!             // All changes up to a finished one are one undo step.
//!             EditorResponse::Change { material, is_finished } => {}
//!             // Ask for a file, then `apply_file` and `with_description`.
//!             EditorResponse::Load => {}
//!             EditorResponse::Save(text) => {}
//!         }
//!     }
//! };
//! ```

mod background;
mod badges;
mod catalog;
mod color;
mod compare;
mod curve;
mod draft;
mod fields;
mod file;
mod light;
mod lobe_solid;
mod lobes;
mod model;
mod parameter;
mod parameter_name;
mod pictures;
mod plots;
mod polar;
mod reflection;
mod roughness;
mod sphere;
mod surface;
mod surface_plots;
mod theme;
mod view;

#[cfg(test)]
mod tests;

pub use file::{ModelFile, apply_file, with_description};
pub use light::{PreviewLamp, PreviewLight};
pub use pictures::SpherePictures;

use crate::words::Language;
use azulejo::scene::brdf::Description;
use azulejo::scene::{Material, Rgb};
use compare::ComparedMaterial;
use draft::ModelDraft;
use egui::{TextEdit, Ui};
use std::sync::Arc;
use surface::SurfaceKind;
use surface_plots::{BackgroundWorkers, SurfacePlots};
use view::LobeView;

/// The input of the editor.
#[derive(Clone, Copy)]
pub struct EditorInput<'a> {
    /// Identifies the material. Partial input is dropped when it changes.
    pub key: u64,
    /// The material in the document.
    pub material: &'a Arc<Material>,
    /// Materials to compare with.
    pub others: &'a [Arc<Material>],
    /// The lighting of the preview sphere.
    pub light: &'a PreviewLight,
    /// Whether emission is in cd/m² instead of W/(sr·m²).
    pub is_photometric: bool,
}

/// A response of the editor.
#[allow(
    clippy::large_enum_variant,
    reason = "there is one at a time, so its size does not matter"
)]
#[derive(Clone, Debug, PartialEq)]
pub enum EditorResponse {
    /// The material was changed.
    Change {
        /// The new material; valid in every scene.
        material: Material,
        /// Whether the change is complete. While a slider is being dragged, changes follow each
        /// other and only the last one is finished: together they are one undo step.
        is_finished: bool,
    },
    /// A file of a reflection model is to be loaded.
    Load,
    /// This text is to be saved as a reflection model.
    Save(String),
}

/// The editor: display settings, and results of background computations.
pub struct BrdfEditor {
    key: Option<u64>,
    /// The kind of surface chosen last: a black surface may be any.
    kind: SurfaceKind,
    /// The name being typed.
    name: Option<String>,
    /// The colour of a light that is currently off.
    emitted: Rgb,
    draft: Option<ModelDraft>,
    /// The description to restore when the user returns from another kind of surface.
    left: Option<Description>,
    /// The last colour of the material: glass and varnish have none.
    color: Option<Rgb>,
    /// Whether a change is unfinished.
    is_open: bool,
    /// Why the model cannot be saved.
    trouble: Option<String>,
    compared: Option<ComparedMaterial>,
    view: LobeView,
    sides: [SurfacePlots; 2],
    workers: BackgroundWorkers,
}

impl Default for BrdfEditor {
    fn default() -> BrdfEditor {
        BrdfEditor {
            key: None,
            kind: SurfaceKind::Matt,
            name: None,
            emitted: Rgb::WHITE,
            draft: None,
            left: None,
            color: None,
            is_open: false,
            trouble: None,
            compared: None,
            view: LobeView::default(),
            sides: Default::default(),
            workers: BackgroundWorkers::default(),
        }
    }
}

impl BrdfEditor {
    /// Draws the editor; returns what the user did, usually nothing.
    ///
    /// Expects the document to have applied the change of the previous frame; otherwise the
    /// document's version takes precedence.
    pub fn ui(
        &mut self,
        ui: &mut Ui,
        language: Language,
        shown: &EditorInput,
    ) -> Vec<EditorResponse> {
        self.follow(shown);
        let mut material = Material::clone(shown.material);
        self.head(ui, language, &mut material);
        let command = self.files(ui, language, shown);
        match self.kind {
            SurfaceKind::Model => self.model(ui, language, &mut material),
            kind => surface::fields(ui, language, kind, &mut material),
        }
        surface::emission(
            ui,
            language,
            shown.is_photometric,
            &mut material,
            &mut self.emitted,
        );
        ui.separator();
        self.pictures(ui, language, shown);
        let changed = self.changed(ui, shown, material);
        command.into_iter().chain(changed).collect()
    }

    /// Whether something displayed is still being computed.
    pub fn is_busy(&self) -> bool {
        let count = 1 + usize::from(self.compared.is_some());
        let draft = self.draft.as_ref().is_some_and(ModelDraft::is_busy);
        draft || self.sides[..count].iter().any(SurfacePlots::is_busy)
    }

    /// Detects another material, or changes made elsewhere.
    fn follow(&mut self, shown: &EditorInput) {
        if self.key != Some(shown.key) {
            *self = BrdfEditor {
                key: Some(shown.key),
                compared: self.compared.take(),
                view: self.view.clone(),
                sides: std::mem::take(&mut self.sides),
                workers: std::mem::take(&mut self.workers),
                ..BrdfEditor::default()
            };
        }
        if !self.kind.is_compatible(shown.material) {
            self.kind = SurfaceKind::of(shown.material);
        }
        match &shown.material.brdf {
            None => self.draft = None,
            Some(brdf) if self.draft.as_ref().is_some_and(|d| d.is_of(brdf)) => {}
            Some(brdf) => self.draft = Some(ModelDraft::new(brdf.clone())),
        }
    }

    /// Name and kind of surface.
    fn head(&mut self, ui: &mut Ui, language: Language, material: &mut Material) {
        self.name_field(ui, language, material);
        let kind = self.kind.choose(ui, language);
        if kind != self.kind {
            self.become_kind(kind, material);
        }
    }

    /// Loading and saving reflection models.
    fn files(
        &mut self,
        ui: &mut Ui,
        language: Language,
        shown: &EditorInput,
    ) -> Option<EditorResponse> {
        let brdf = shown.material.brdf.as_deref();
        let [load, save] = theme::row(ui, language.tr("Model file"), "", |ui, _| {
            let load = ui.button(language.tr("Load…"));
            let save = egui::Button::new(language.tr("Save…"));
            [load, ui.add_enabled(brdf.is_some(), save)].map(|button| button.clicked())
        });
        if let Some(brdf) = brdf.filter(|_| save) {
            let saved = file::saved(brdf.description());
            self.trouble = saved.as_ref().err().cloned();
            return saved.ok().map(EditorResponse::Save);
        }
        if let Some(trouble) = &self.trouble {
            theme::problem(ui, trouble);
        }
        load.then_some(EditorResponse::Load)
    }

    fn name_field(&mut self, ui: &mut Ui, language: Language, material: &mut Material) {
        theme::row(ui, language.tr("Name"), "", |ui, label| {
            let mut name = self.name.take().unwrap_or_else(|| material.name.clone());
            let field = TextEdit::singleline(&mut name).desired_width(ui.available_width() - 8.0);
            let response = ui.add(field).accessible_name(label);
            if response.has_focus() {
                self.name = Some(name);
            } else if response.lost_focus() && !ui.input(|i| i.key_pressed(egui::Key::Escape)) {
                material.name = name;
            }
        });
    }

    fn become_kind(&mut self, kind: SurfaceKind, material: &mut Material) {
        self.color = color::material_color(material).or(self.color);
        if let Some(draft) = self.draft.take() {
            self.left = Some(draft.description);
        }
        let is_mirror = SurfaceKind::of(material) == SurfaceKind::Mirror;
        kind.convert(material, self.color);
        if kind == SurfaceKind::Model {
            let shade = self.color.unwrap_or(material.diffuse);
            let left = self.left.take();
            let kept = left.and_then(|d| surface::recolored(d, shade));
            let description = kept.unwrap_or_else(|| surface::model_of(shade, is_mirror));
            if let Ok(model) = with_description(material, description) {
                *material = model;
            }
        }
        self.kind = SurfaceKind::of(material);
    }

    fn model(&mut self, ui: &mut Ui, language: Language, material: &mut Material) {
        if let Some(draft) = &mut self.draft {
            model::description(ui, language, &mut draft.description, &mut self.color);
            if let Some(brdf) = draft.made(ui.ctx()) {
                *material = file::with_brdf(material, brdf);
            }
            draft.show_status(ui, language);
        }
    }

    /// The response if the material differs from before.
    fn changed(
        &mut self,
        ui: &Ui,
        shown: &EditorInput,
        material: Material,
    ) -> Option<EditorResponse> {
        let is_busy = self.draft.as_ref().is_some_and(ModelDraft::is_busy);
        let is_finished = !is_busy && !ui.input(|i| i.pointer.any_down());
        if !draft::is_same_material(&material, shown.material) {
            self.is_open = !is_finished;
            return Some(EditorResponse::Change {
                material,
                is_finished,
            });
        }
        if !(self.is_open && is_finished) {
            return None;
        }
        self.is_open = false;
        Some(EditorResponse::Change {
            material,
            is_finished,
        })
    }

    fn pictures(&mut self, ui: &mut Ui, language: Language, shown: &EditorInput) {
        compare::choose(ui, language, &mut self.compared, shown.others);
        let other = compare::current(&mut self.compared, shown.others);
        let first = shown.material;
        let mut names = vec![compare::name(language, first)];
        self.sides[0].ask(ui.ctx(), &self.workers, first, shown.light, &self.view);
        if let Some((name, other)) = other {
            self.sides[1].ask(ui.ctx(), &self.workers, other, shown.light, &self.view);
            names.push(name.to_owned());
        }
        let count = names.len();
        plots::show(
            ui,
            language,
            &mut self.view,
            &mut self.sides[..count],
            &names,
        );
    }
}
