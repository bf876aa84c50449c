//! All background results for one of the displayed materials.

use super::background::{BackgroundWorker, LatestResult};
use super::badges::{ModelChecks, measure};
use super::light::PreviewLight;
use super::lobes::{AlbedoCurve, AlbedoKey, LobeKey, SampledLobes, albedo, lobes};
use super::reflection::MaterialReflection;
use super::sphere::{SphereImage, SphereKey, draw};
use super::view::LobeView;
use crate::words::Language;
use azulejo::scene::Material;
use egui::accesskit::Role;
use egui::{ColorImage, Context, TextureHandle, TextureOptions, Ui, Vec2};

/// Width and height of the sphere's image, pixels.
const SIDE: u32 = 160;

/// Threads of the editor: one for plots, one for images.
pub(super) struct BackgroundWorkers {
    plots: BackgroundWorker,
    pictures: BackgroundWorker,
}

impl Default for BackgroundWorkers {
    fn default() -> BackgroundWorkers {
        BackgroundWorkers {
            plots: BackgroundWorker::new("brdf plots"),
            pictures: BackgroundWorker::new("brdf spheres"),
        }
    }
}

/// The results for one material.
#[derive(Default)]
pub(super) struct SurfacePlots {
    pub lobes: LatestResult<LobeKey, SampledLobes>,
    pub albedo: LatestResult<AlbedoKey, AlbedoCurve>,
    pub measures: LatestResult<MaterialReflection, ModelChecks>,
    sphere: LatestResult<SphereKey, SphereImage>,
    /// The uploaded image of the sphere, with its key and number of paths.
    texture: Option<(SphereKey, u32, TextureHandle)>,
}

impl SurfacePlots {
    /// Requests all results for a material.
    pub fn ask(
        &mut self,
        ctx: &Context,
        workers: &BackgroundWorkers,
        material: &Material,
        light: &PreviewLight,
        view: &LobeView,
    ) {
        let optics = MaterialReflection::of(material);
        let key = LobeKey {
            optics: optics.clone(),
            incidences: view.incidences(),
            azimuth: view.azimuth,
        };
        self.lobes.ask(&key, lobes, &workers.plots, ctx);
        let key = AlbedoKey {
            optics: optics.clone(),
            azimuth: view.azimuth,
        };
        self.albedo.ask(&key, albedo, &workers.plots, ctx);
        // These take longest, and nobody reads them while dragging.
        if !ctx.input(|i| i.pointer.any_down()) {
            self.measures.ask(&optics, measure, &workers.plots, ctx);
        }
        let key = SphereKey::new(material, light, SIDE);
        self.sphere.ask(&key, draw, &workers.pictures, ctx);
    }

    /// Whether something displayed is out of date.
    pub fn is_behind(&self) -> bool {
        self.lobes.is_running() || self.albedo.is_running() || self.measures.is_running()
    }

    /// Whether something is missing or not displayed yet.
    pub fn is_busy(&self) -> bool {
        let is_shown = self.measures.found().is_some() && self.texture.is_some();
        self.is_behind() || self.sphere.is_running() || !is_shown
    }

    /// Draws the sphere, `size` points wide and high.
    pub fn sphere(&mut self, ui: &mut Ui, language: Language, size: f32) {
        let words = language.tr("Sphere of the material under the light of the scene");
        self.upload(ui.ctx());
        let Some((_, samples, texture)) = &self.texture else {
            let place = ui.allocate_ui(Vec2::splat(size), |ui| {
                ui.centered_and_justified(Ui::spinner)
            });
            place
                .response
                .widget_info(|| egui::WidgetInfo::labeled(Role::Image, true, words));
            return;
        };
        let image = egui::Image::new((texture.id(), Vec2::splat(size)))
            .corner_radius(4)
            .alt_text(words);
        let paths = language.tr("paths per pixel");
        ui.add(image)
            .on_hover_text(format!("{words}\n{samples} {paths}"));
    }

    /// Uploads the latest image of the sphere.
    fn upload(&mut self, ctx: &Context) {
        let Some((key, picture)) = self.sphere.found() else {
            return;
        };
        let old = self.texture.as_mut();
        let old = match old {
            Some((shown, samples, _)) if shown == key && *samples == picture.samples => return,
            old => old,
        };
        let image = ColorImage::from_rgb([picture.side, picture.side], &picture.rgb);
        match old {
            Some(texture) => {
                texture.2.set(image, TextureOptions::LINEAR);
                (texture.0, texture.1) = (key.clone(), picture.samples);
            }
            None => {
                let texture = ctx.load_texture("sphere", image, TextureOptions::LINEAR);
                self.texture = Some((key.clone(), picture.samples, texture));
            }
        }
    }
}
