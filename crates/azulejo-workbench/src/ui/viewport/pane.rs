//! One picture of the model: its polygons, its texture, and the scale of its colours.

use super::super::colors;
use super::super::panel_context::PanelContext;
use super::cache::ViewportCache;
use super::isolines::IsolineLabels;
use super::legend::{self, LegendText};
use super::markers;
use super::task_plane;
use super::texture::{DeviceLost, DrawStamp, ViewportTexture};
use crate::app::light_unit::ShownUnit;
use crate::app::{App, IrradianceRange, TaskPlane};
use crate::gpu::{
    Background, ColorScalar, ColorScale, Cutaway, DrawnMesh, LightmapPages, PickHit, PixelBuffer,
    Projection, TextureSource, ViewportFrame,
};
use crate::view::{Backdrop, ModelView, Shading};
use azulejo::render::Tone;
use azulejo::scene::math::Ray;
use azulejo::scene::{Material, Rgb, SceneBackground, TextureId};
use eframe::egui_wgpu::RenderState;
use egui::{Color32, Rect, Ui};
use glam::DVec3;

/// A picture of the model.
#[derive(Default)]
pub struct ViewPane {
    /// The displayed polygons.
    pub cache: ViewportCache,
    screen: Option<ViewportTexture>,
    labels: IsolineLabels,
    cut: Cutaway,
}

impl ViewPane {
    /// Creates a picture on a graphics device.
    pub fn on(state: &RenderState) -> Result<ViewPane, DeviceLost> {
        Ok(ViewPane {
            screen: Some(ViewportTexture::new(state)?),
            ..ViewPane::default()
        })
    }

    /// Another picture on the same device, if there is one.
    pub fn beside(&self) -> Result<ViewPane, DeviceLost> {
        let state = self.screen.as_ref().map(ViewportTexture::state);
        state.map_or_else(|| Ok(ViewPane::default()), ViewPane::on)
    }

    /// Checks that the device is available, if there should be one.
    pub fn check(&self) -> Result<(), DeviceLost> {
        self.screen.as_ref().map_or(Ok(()), ViewportTexture::check)
    }

    /// The pixels of the last drawing.
    pub fn pixels(&self) -> Option<PixelBuffer> {
        self.screen.as_ref()?.read().ok()
    }

    /// The displayed surface that a ray hits first.
    pub fn hit(&self, ray: &Ray) -> Option<PickHit> {
        let drawn: Vec<DrawnMesh> = self.cache.entries().iter().map(|e| e.drawn()).collect();
        self.cut.pick(&drawn, ray)
    }

    /// What is cut away from the model.
    pub fn cut(&self) -> Cutaway {
        self.cut
    }

    /// Updates the polygons without drawing them.
    pub fn update(&mut self, app: &App, view: &ModelView, size: [u32; 2]) {
        let projection = Projection::new(&view.camera, size);
        self.cache.update(app, view.shading, &projection);
        self.cut = Cutaway {
            hides_backs: view.hides_backs,
            section: view.section.map(|s| s.plane(app.document.bounds(None))),
        };
    }

    /// Draws the picture of `view` into `rect`, visible within `clip`.
    pub fn draw(
        &mut self,
        ui: &Ui,
        (rect, clip): (Rect, Rect),
        size: [u32; 2],
        cx: &PanelContext,
        view: &ModelView,
    ) -> Result<(), DeviceLost> {
        let app = cx.app;
        self.update(app, view, size);
        let painter = ui.painter().with_clip_rect(clip);
        // Without a graphics device the pane stays grey.
        let Some(screen) = &mut self.screen else {
            painter.rect_filled(clip, 0.0, Color32::from_gray(40));
            return Ok(());
        };
        // The stamp tells whether app or view have changed since the picture was drawn.
        let scale = scale(app, view.shading);
        let lightmap = app.lightmap.shown_in(view.shading);
        let stamp = DrawStamp {
            view: view.clone(),
            size,
            revision: app.revision(),
            selection: app.selection.clone(),
            seen: app.lighting.form_factors.as_ref().map(|s| s.number),
            lightmap: lightmap.map(|shown| shown.key),
            task_plane: app.task_plane.result.as_ref().map(|plane| plane.number),
            scale,
        };
        // Collect meshes, materials and textures; where form factors are shown, patches replace the objects.
        let materials: Vec<&Material> = app.document.materials.iter().map(|m| &**m).collect();
        let cache = &self.cache;
        let textures = app.document.textures.iter();
        let textures: Vec<TextureSource> = textures
            .map(|t| TextureSource {
                key: cache.texture_key(t),
                image: t.image.as_ref(),
            })
            .collect();
        let shows_factors = view.shading == Shading::FormFactors;
        let drawn = cache.drawn(app, shows_factors);
        // Draw markers and the measured task plane in addition to the model.
        let mut overlay = markers::overlay(app, view.shading);
        if let Some((plane, scale)) = plane_scale(app, view.shading) {
            task_plane::draw(&mut overlay, plane, &scale);
        }
        let frame = ViewportFrame {
            shading: view.shading,
            textures: &textures,
            lightmap: lightmap.map(|shown| LightmapPages {
                key: shown.key,
                pages: &shown.lightmap.pages,
            }),
            background: background(app, view, &textures, ui.visuals().dark_mode),
            fog: app.document.fog.filter(|_| view.shows_fog),
            overlay: &overlay,
            exposure: app.exposure(view),
            scale,
            hides_backs: view.hides_backs,
            section: self.cut.section,
            ..ViewportFrame::new(size, &view.camera, &drawn, &materials)
        };
        screen.draw(ui, &painter, rect, stamp.clone(), &frame)?;
        // Write the values on the isolines over the picture.
        if has_isolines(app, view.shading) {
            self.labels
                .show(&painter, (rect, clip), screen, &stamp, &frame);
        }
        Ok(())
    }

    /// Draws the legend of the picture, if it has one.
    pub fn legend(&self, ui: &Ui, rect: Rect, cx: &PanelContext, shading: Shading) {
        let app = cx.app;
        let has_scale = has_isolines(app, shading) || shading == Shading::FormFactors;
        if let Some((_, scale)) = plane_scale(app, shading).filter(|_| !has_scale) {
            let unit = ShownUnit::of(app).irradiance();
            let beyond = (false, app.view.false_color.range.is_some());
            legend::paint(ui.painter(), rect, &scale, LegendText { unit, beyond });
            return;
        }
        let scale = scale(app, shading);
        let unit = match shading {
            Shading::FalseColor if has_isolines(app, shading) => ShownUnit::of(app).irradiance(),
            Shading::Error if has_isolines(app, shading) => "± %",
            Shading::FormFactors if app.lighting.form_factors.is_some() => "F",
            _ => return,
        };
        let range = match shading {
            Shading::FormFactors => None,
            _ => values(app, shading),
        };
        let slack = 1e-6 * (scale.high - scale.low);
        let beyond = range.map(|r| (r.low < scale.low - slack, r.high > scale.high + slack));
        let text = LegendText {
            unit,
            beyond: beyond.unwrap_or_default(),
        };
        legend::paint(ui.painter(), rect, &scale, text);
    }
}

/// The measured task plane with the scale of its colours: that of the surfaces where they are shown
/// on one of irradiance, or one of its own, from zero.
fn plane_scale(app: &App, shading: Shading) -> Option<(&TaskPlane, ColorScale)> {
    let plane = app.task_plane.result.as_ref()?;
    if shading == Shading::FalseColor && has_isolines(app, shading) {
        return Some((plane, scale(app, shading)));
    }
    let most = plane.figures()?.most.0;
    let own = light_scale(app, (0.0, most.max(1e-12)), false);
    Some((plane, ColorScale { bands: 0, ..own }))
}

/// Whether values of light are shown on a scale.
fn has_isolines(app: &App, shading: Shading) -> bool {
    let is_lit = app.lighting.solution.is_some() || app.lightmap.shown_in(shading).is_some();
    match shading {
        Shading::FalseColor => is_lit,
        Shading::Error => app.lighting.error_range.is_some(),
        _ => false,
    }
}

/// Range of the values that a shading mode shows on its scale.
fn values(app: &App, shading: Shading) -> Option<IrradianceRange> {
    match (shading, app.lightmap.shown_in(shading)) {
        (Shading::Error, _) => app.lighting.error_range,
        (_, Some(shown)) => shown.range,
        (_, None) => app.lighting.range,
    }
}

/// The colour scale of a shading mode.
fn scale(app: &App, shading: Shading) -> ColorScale {
    let settings = &app.view.false_color;
    let plain = ColorScale {
        map: settings.map,
        low: 0.0,
        high: 1.0,
        is_logarithmic: settings.logarithmic,
        bands: 0,
        quantity: ColorScalar::default(),
        display: 1.0,
    };
    if shading == Shading::FormFactors {
        let factors = app
            .lighting
            .form_factors
            .iter()
            .flat_map(|s| s.factors.iter());
        let high = factors.fold(0.0, |a: f64, &b| a.max(b)).max(1e-9);
        return ColorScale {
            low: if settings.logarithmic {
                1e-4 * high
            } else {
                0.0
            },
            high,
            ..plain
        };
    }
    let range = values(app, shading);
    let range = range.map_or((0.0, 1.0), |r| (r.low, r.usual.max(r.low + 1e-12)));
    light_scale(app, range, shading == Shading::Error)
}

/// The scale of irradiance or of its standard errors with the settings of the view; `found` are the
/// ends of an automatic range.
fn light_scale(app: &App, found: (f64, f64), is_error: bool) -> ColorScale {
    let settings = &app.view.false_color;
    let fixed = settings.range.filter(|_| !is_error);
    let (mut low, mut high) = fixed.unwrap_or(found);
    let is_logarithmic = settings.logarithmic && !is_error;
    if is_logarithmic {
        high = high.max(1e-9);
        low = low.clamp(1e-4 * high, high);
    }
    let scale = ColorScale {
        low,
        high: if high > low { high } else { low + 1.0 },
        is_logarithmic,
        bands: settings.isolines,
        display: if is_error {
            100.0
        } else {
            ShownUnit::of(app).factor
        },
        map: settings.map,
        quantity: ColorScalar::default(),
    };
    // A range that the user has set is kept as it is.
    if fixed.is_some() {
        scale
    } else {
        scale.rounded()
    }
}

/// The background of the viewport; `textures` are those of the document.
fn background<'a>(
    app: &App,
    view: &ModelView,
    textures: &[TextureSource<'a>],
    is_dark: bool,
) -> Background<'a> {
    if let Backdrop::Color(color) = view.backdrop {
        return Background::Color(color);
    }
    // In modes that display light, the background is exposed like the surfaces.
    let shows_light = matches!(view.shading, Shading::Irradiance | Shading::Patches);
    let exposure = if shows_light { app.exposure(view) } else { 1.0 };
    let shown = |radiance: Rgb| {
        let shown = if shows_light {
            Tone::default().map(exposure * radiance)
        } else {
            radiance
        };
        let [r, g, b, _] = colors::color(shown).to_array();
        [r, g, b]
    };
    let picture = |id: TextureId| textures.get(id as usize).copied();
    match app.document.background {
        Some(SceneBackground::Color(radiance)) => Background::Color(shown(radiance)),
        // Its middle, above and below the horizon; pictures are rendered with all of it.
        Some(SceneBackground::Environment(environment)) => {
            let [lower, upper] = [-0.3, 0.3].map(|height| {
                let local = DVec3::new(1.0, 0.0, height).normalize();
                let direction = environment.world_from_environment * local;
                let image = environment.texture().and_then(picture);
                shown(environment.seen(direction, image.and_then(|t| t.image)))
            });
            Background::Gradient { lower, upper }
        }
        Some(SceneBackground::Backplate(plate)) => match picture(plate.texture) {
            Some(picture) => Background::Image {
                picture,
                fit: plate.fit,
                // In the other modes a background is a picture, and has no brightness.
                gain: if shows_light {
                    exposure * plate.radiance
                } else {
                    1.0
                },
                around: [0, 0, 0],
            },
            None => Background::Color([0, 0, 0]),
        },
        None if is_dark => Background::Gradient {
            lower: [30, 32, 36],
            upper: [66, 72, 82],
        },
        None => Background::Gradient {
            lower: [200, 204, 210],
            upper: [150, 162, 178],
        },
    }
}
