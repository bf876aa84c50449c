//! The lightmap of the document: baking, what was baked, and saving it.

use super::files::with_default_extension;
use super::lighting::{IrradianceRange, range_of};
use super::{App, JobResult};
use crate::bake::{BakeSettings, BakedDocument, LightmapFile, ShownLightmap, bake_document, write};
use crate::document::same_light;
use crate::jobs::JobKind;
use crate::view::Shading;
use azulejo::scene::Rgb;
use std::path::PathBuf;
use std::sync::Arc;

/// The last lightmap, and the settings for the next.
#[derive(Clone, Default)]
pub struct LightmapState {
    /// Settings for the next lightmap.
    pub settings: BakeSettings,
    /// The one that was baked last, which may be outdated.
    pub result: Option<Arc<BakedDocument>>,
    /// Whether it belongs to the document in its current state.
    pub is_current: bool,
    /// What the viewport shows: the last one, or that of the file.
    pub shown: Option<ViewportLightmap>,
}

/// A lightmap for the viewport.
#[derive(Clone)]
pub struct ViewportLightmap {
    /// Its number, another for each.
    pub key: u64,
    /// Its surfaces and pages.
    pub lightmap: Arc<ShownLightmap>,
    /// From its darkest texel to its brightest, if any has light.
    pub range: Option<IrradianceRange>,
    /// Whether it is shown, and not the light of vertices.
    pub is_shown: bool,
}

impl LightmapState {
    /// What the viewport shows in a shading mode, if that is a lightmap.
    pub fn shown_in(&self, shading: Shading) -> Option<&ViewportLightmap> {
        let shows = matches!(shading, Shading::Irradiance | Shading::FalseColor);
        self.shown.as_ref().filter(|s| s.is_shown && shows)
    }
}

impl App {
    /// Starts baking the document in its current state.
    pub(super) fn bake(&mut self) {
        if !self.document.has_light() {
            return self
                .fail(self.tr("there is no light source: add a light or an emissive material"));
        }
        if self.document.objects.is_empty() {
            return self.fail(self.tr("there are no surfaces"));
        }
        let (document, settings) = (self.document.clone(), self.lightmap.settings);
        let light = self.lighting.settings;
        let title = self.tr("lightmap");
        self.start_job(JobKind::Bake, title, move |progress, outbox| {
            let note = |text| outbox.send(JobResult::Note(text));
            if let Some(baked) = bake_document(&document, &settings, &light, progress, &note)? {
                outbox.send(JobResult::Baked(Box::new(baked)));
            }
            Ok(())
        });
    }

    pub(super) fn take_baked(&mut self, baked: BakedDocument) {
        let shown = ShownLightmap::baked(&baked);
        self.lightmap.result = Some(Arc::new(baked));
        self.lightmap_outdated();
        self.show_in_viewport(shown);
        if self.lightmap.shown.is_some() && !self.view.shading.shows_light() {
            self.view.shading = Shading::Irradiance;
        }
    }

    fn show_in_viewport(&mut self, lightmap: Option<ShownLightmap>) {
        self.lightmap.shown = lightmap.map(|lightmap| {
            let texels = lightmap.pages.iter().flat_map(|page| &page.pixels);
            let lit = texels.filter(|t| t.iter().any(|&v| v > 0.0));
            let values = lit.map(|t| Rgb::from(t.map(f64::from)).luminance());
            ViewportLightmap {
                key: self.new_revision(),
                range: range_of(values.collect()),
                lightmap: Arc::new(lightmap),
                is_shown: true,
            }
        });
    }

    /// Shows the lightmap in the viewport, or the light of vertices.
    pub(super) fn show_lightmap(&mut self, is_shown: bool) {
        if let Some(shown) = &mut self.lightmap.shown {
            shown.is_shown = is_shown;
        }
    }

    /// Called when the document changes: whether the lightmap still belongs to it.
    pub(super) fn lightmap_outdated(&mut self) {
        let result = self.lightmap.result.as_ref();
        self.lightmap.is_current = result.is_some_and(|r| same_light(&r.document, &self.document));
    }

    /// Forgets the lightmap of another document.
    pub(super) fn drop_lightmap(&mut self) {
        self.jobs.cancel_kind(JobKind::Bake);
        self.lightmap = LightmapState {
            settings: self.lightmap.settings,
            ..LightmapState::default()
        };
        self.show_lightmap_of_file();
    }

    /// Shows the lightmap that came with the files of the document.
    pub(super) fn show_lightmap_of_file(&mut self) {
        self.show_in_viewport(ShownLightmap::of_file(&self.document));
    }

    pub(super) fn save_lightmap(&mut self, what: LightmapFile, path: PathBuf) {
        self.asking = None;
        let Some(baked) = self.lightmap.result.clone() else {
            return self.fail(self.tr("there is no lightmap yet: bake one first"));
        };
        let path = with_default_extension(path, what.extension());
        let saved = self.tr("saved");
        self.start_saving(path.clone(), move |progress, outbox| {
            for note in write(&baked, what, &path, progress)? {
                outbox.send(JobResult::Note(note));
            }
            outbox.send(JobResult::Note(format!("{}: {saved}", path.display())));
            Ok(())
        });
    }
}
