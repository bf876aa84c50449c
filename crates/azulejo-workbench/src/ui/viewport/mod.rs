//! The viewport: drawing, navigation and picking.

mod cache;
mod gizmo;
mod hover;
mod legend;
mod markers;
mod navigate;
mod picking;
mod probe_markers;
mod rendered;
mod texture;

pub(super) use markers::middle;

pub use gizmo::GizmoMode;
pub use hover::{radiance_unit, value};
pub use legend::number;
pub(super) use legend::paint as paint_legend;

use super::panel_context::PanelContext;
use crate::app::{App, IrradianceRange};
use crate::command::{Command, SurfacePick};
use crate::document::Edit;
use crate::gpu::{
    Background, ColorScalar, ColorScale, LightmapPages, Projection, TextureSource, ViewportFrame,
};
use crate::view::{Backdrop, ModelView, Shading};
use azulejo::render::Tone;
use azulejo::scene::math::Ray;
use azulejo::scene::{Camera, Material, Rgb, SceneBackground};
use cache::ViewportCache;
use egui::{Color32, CursorIcon, Pos2, Rect, Response, Sense, Ui, Vec2};
use gizmo::{Gizmo, GizmoHandle};
use glam::{DAffine3, DVec3};
use texture::{DrawStamp, ViewportTexture};

pub use texture::DeviceLost;

/// The state of the viewport.
#[derive(Default)]
pub struct Viewport {
    cache: ViewportCache,
    screen: Option<ViewportTexture>,
    rendered: rendered::RenderTexture,
    /// The mode of the gizmo.
    pub mode: GizmoMode,
    grip: Option<GizmoHandle>,
    /// The text for the point under the mouse.
    hover_text: Option<String>,
    probed_at: Option<(Pos2, u64, Camera, Shading)>,
    /// The ray of the mouse, or of the centre of the view when the keyboard is used.
    pointed: Option<Ray>,
    /// Whether the view was last moved with the keyboard: then its centre is the pointer.
    by_keys: bool,
    /// Whether the next click pins a probe.
    pub pins_next: bool,
    /// Size in pixels.
    size: [u32; 2],
}

/// The exposure at which typical irradiance on a grey surface appears as a bright mid-tone.
pub fn auto_exposure(app: &App) -> f64 {
    let usual = shown_range(app).map_or(0.0, |r| r.usual);
    if usual > 0.0 {
        0.6 * std::f64::consts::PI / (0.5 * usual)
    } else {
        1.0
    }
}

/// Range of the irradiance that is shown: that of the lightmap, or of vertices.
pub fn shown_range(app: &App) -> Option<IrradianceRange> {
    match app.lightmap.shown_in(app.view.shading) {
        Some(shown) => shown.range,
        None => app.lighting.range,
    }
}

/// The exposure of the modes that display light.
fn exposure(app: &App, view: &ModelView) -> f64 {
    view.exposure.unwrap_or_else(|| auto_exposure(app))
}

/// The unit of irradiance.
pub fn irradiance_unit(app: &App) -> &'static str {
    if app.document.units.photometric {
        "lx"
    } else {
        "W/m²"
    }
}

impl Viewport {
    /// Creates a viewport on the device of a window, if it has one.
    ///
    /// # Errors
    ///
    /// [`DeviceLost`] if the device cannot be used.
    pub fn of_window(context: &eframe::CreationContext<'_>) -> Result<Viewport, DeviceLost> {
        let card = context.wgpu_render_state.as_ref();
        card.map_or_else(|| Ok(Viewport::default()), Viewport::on)
    }

    /// Creates a viewport on a graphics device.
    fn on(state: &eframe::egui_wgpu::RenderState) -> Result<Viewport, DeviceLost> {
        Ok(Viewport {
            screen: Some(ViewportTexture::new(state)?),
            ..Viewport::default()
        })
    }

    /// Checks that the device is available, if there should be one.
    ///
    /// # Errors
    ///
    /// [`DeviceLost`].
    pub fn check(&self) -> Result<(), DeviceLost> {
        self.screen.as_ref().map_or(Ok(()), ViewportTexture::check)
    }

    /// The text for the point under the mouse.
    pub fn probe(&self) -> Option<&str> {
        self.hover_text.as_deref()
    }

    /// The surface point under the pointer.
    pub fn pointed_surface(&self) -> Option<SurfacePick> {
        self.patch_at(&self.pointed?)
    }

    /// The size of the viewport in pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.size[0].max(1), self.size[1].max(1))
    }

    /// Draws the model or the rendered image; handles the mouse and the keyboard.
    ///
    /// # Errors
    ///
    /// [`DeviceLost`] if the graphics device is lost. The window has to be opened again.
    pub fn show(&mut self, ui: &mut Ui, cx: &mut PanelContext) -> Result<(), DeviceLost> {
        let rect = ui.available_rect_before_wrap();
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        let name = cx.tr("Viewport");
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, true, name));
        let pixels = rect.size() * ui.ctx().pixels_per_point();
        self.size = [pixels.x.round() as u32, pixels.y.round() as u32];
        let view = self.view(ui, &response, cx);
        self.cache
            .update(cx.app, &Projection::new(&view.camera, self.size));
        // An image rendered at another size covers only a part of the viewport.
        let seen = match &cx.app.render {
            Some(shown) => rendered::fit(rect, shown.size),
            None => rect,
        };
        let points = Projection::new(&view.camera, [seen.width() as u32, seen.height() as u32]);
        if cx.app.render.is_some() {
            self.rendered.show(ui, rect, cx.app);
        } else {
            self.draw(ui, rect, cx, &view)?;
            self.handles(ui, rect, &response, &points, cx);
        }
        self.point(ui, seen, &response, &points, cx);
        probe_markers::paint(ui, seen, &points, cx);
        self.decorate(ui, rect, cx);
        Ok(())
    }

    /// The view after this frame's input.
    fn view(&mut self, ui: &Ui, response: &Response, cx: &mut PanelContext) -> ModelView {
        let app = cx.app;
        // Whether a drag starts on a handle is decided below; if so, it does not rotate the view.
        if self.grip.is_some() || response.drag_started() || cx.is_covered {
            return app.view.clone();
        }
        let (view, is_held) = navigate::navigate(ui, response, app);
        if is_held {
            self.by_keys = true;
            ui.ctx().request_repaint();
        }
        if view != app.view {
            cx.send(Command::SetView(Box::new(view.clone())));
        }
        view
    }

    fn draw(
        &mut self,
        ui: &Ui,
        rect: Rect,
        cx: &PanelContext,
        view: &ModelView,
    ) -> Result<(), DeviceLost> {
        let Some(screen) = &mut self.screen else {
            ui.painter().rect_filled(rect, 0.0, Color32::from_gray(40));
            return Ok(());
        };
        let app = cx.app;
        let scale = scale(app);
        let lightmap = app.lightmap.shown_in(view.shading);
        let stamp = DrawStamp {
            view: view.clone(),
            size: self.size,
            revision: app.revision(),
            selection: app.selection.clone(),
            seen: app.lighting.form_factors.as_ref().map(|s| s.number),
            lightmap: lightmap.map(|shown| shown.key),
            scale,
        };
        let materials: Vec<&Material> = app.document.materials.iter().map(|m| &**m).collect();
        let backdrop = self.cache.backdrop_key(&view.backdrop);
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
        let overlay = markers::overlay(app);
        let frame = ViewportFrame {
            shading: view.shading,
            textures: &textures,
            lightmap: lightmap.map(|shown| LightmapPages {
                key: shown.key,
                pages: &shown.lightmap.pages,
            }),
            background: background(app, view, backdrop, ui.visuals().dark_mode),
            fog: app.document.fog.filter(|_| view.shows_fog),
            overlay: &overlay,
            exposure: exposure(app, view),
            scale,
            ..ViewportFrame::new(self.size, &view.camera, &drawn, &materials)
        };
        screen.draw(ui, rect, stamp, &frame)
    }

    /// The gizmo of the selection.
    fn handles(
        &mut self,
        ui: &Ui,
        rect: Rect,
        response: &Response,
        view: &Projection,
        cx: &mut PanelContext,
    ) {
        let Some(centre) = middle(cx.app) else {
            self.grip = None;
            return;
        };
        let gizmo = Gizmo {
            view,
            rect,
            centre,
            mode: self.mode,
        };
        let mouse = response.hover_pos().or(response.interact_pointer_pos());
        let under = mouse.and_then(|p| gizmo.grip_at(p));
        if response.drag_started_by(egui::PointerButton::Primary) {
            // The button was pressed slightly before the drag was detected.
            let press = ui.input(|i| i.pointer.press_origin());
            self.grip = press.and_then(|p| gizmo.grip_at(p));
        }
        if let (Some(grip), Some(mouse)) = (&mut self.grip, response.interact_pointer_pos())
            && response.dragged()
            && let Some(map) = gizmo.drag(grip, mouse)
            && map != DAffine3::IDENTITY
        {
            let ids = cx.app.selection.ids.clone();
            cx.edit(Edit::Transform(ids, map));
        }
        if !response.dragged() {
            self.grip = None;
        }
        if under.is_some() || self.grip.is_some() {
            ui.ctx().set_cursor_icon(CursorIcon::Grab);
        }
        gizmo.paint(ui.painter(), self.grip.as_ref().or(under.as_ref()));
    }

    /// Draws legends and buttons over the model.
    fn decorate(&mut self, ui: &mut Ui, rect: Rect, cx: &PanelContext) {
        let app = cx.app;
        if self.by_keys {
            probe_markers::cross(ui.painter(), rect.center(), "", 1.0);
        }
        if app.render.is_none() {
            match app.view.shading {
                Shading::FalseColor if app.lighting.solution.is_some() || shows_lightmap(app) => {
                    legend::paint(ui.painter(), rect, &scale(app), irradiance_unit(app));
                }
                Shading::FormFactors if app.lighting.form_factors.is_some() => {
                    legend::paint(ui.painter(), rect, &scale(app), "F");
                }
                _ => {}
            }
        }
        if let Some(hint) = self.hint(cx) {
            let at = rect.center_top() + Vec2::new(0.0, 10.0);
            let font = egui::FontId::proportional(13.0);
            let galley = ui
                .painter()
                .layout_no_wrap(hint.into(), font, Color32::WHITE);
            let place =
                Rect::from_center_size(at + Vec2::new(0.0, 0.5 * galley.size().y), galley.size());
            let back = Color32::from_black_alpha(160);
            ui.painter().rect_filled(place.expand(5.0), 4.0, back);
            ui.painter().galley(place.min, galley, Color32::WHITE);
        }
        if app.render.is_none() && !app.selection.ids.is_empty() {
            self.mode_buttons(ui, rect, cx);
        }
    }

    /// A hint about the displayed state.
    fn hint(&self, cx: &PanelContext) -> Option<&'static str> {
        let app = cx.app;
        let lighting = &app.lighting;
        let shading = app.view.shading;
        if app.document.objects.is_empty() {
            None
        } else if self.pins_next {
            Some(cx.tr("Click the point to pin a probe at; Escape cancels."))
        } else if shading == Shading::FormFactors && lighting.form_factors.is_none() {
            Some(cx.tr("Click a surface to display its form factors."))
        } else if shows_lightmap(app) {
            let is_old = app.lightmap.result.is_some() && !app.lightmap.is_current;
            is_old.then(|| cx.tr("This lightmap is of an earlier state of the model."))
        } else if shading.shows_light() && lighting.solution.is_none() {
            Some(cx.tr("Not solved yet: press F5."))
        } else if shading.shows_light() && !lighting.is_current {
            Some(cx.tr("This light is outdated: press F5."))
        } else {
            None
        }
    }

    fn mode_buttons(&mut self, ui: &mut Ui, rect: Rect, cx: &PanelContext) {
        let modes = [
            (GizmoMode::Move, cx.tr("Move")),
            (GizmoMode::Rotate, cx.tr("Rotate")),
            (GizmoMode::Scale, cx.tr("Resize")),
        ];
        let place = Rect::from_min_size(rect.min + Vec2::splat(8.0), Vec2::new(240.0, 24.0));
        ui.scope_builder(egui::UiBuilder::new().max_rect(place), |ui| {
            ui.horizontal(|ui| {
                for (mode, name) in modes {
                    ui.selectable_value(&mut self.mode, mode, name);
                }
            });
        });
    }
}

/// Whether the viewport shows a lightmap.
fn shows_lightmap(app: &App) -> bool {
    app.lightmap.shown_in(app.view.shading).is_some()
}

/// The current colour scale.
fn scale(app: &App) -> ColorScale {
    let colors = &app.view.false_color;
    if app.view.shading == Shading::FormFactors {
        let factors = app
            .lighting
            .form_factors
            .iter()
            .flat_map(|s| s.factors.iter());
        let high = factors.fold(0.0, |a: f64, &b| a.max(b)).max(1e-9);
        return ColorScale {
            map: colors.map,
            low: if colors.logarithmic { 1e-4 * high } else { 0.0 },
            high,
            is_logarithmic: colors.logarithmic,
            bands: 0,
            quantity: ColorScalar::default(),
        };
    }
    let found = shown_range(app);
    let found = found.map_or((0.0, 1.0), |r| (r.low, r.usual.max(r.low + 1e-12)));
    let (mut low, mut high) = colors.range.unwrap_or(found);
    if colors.logarithmic {
        high = high.max(1e-9);
        low = low.clamp(1e-4 * high, high);
    }
    ColorScale {
        map: colors.map,
        low,
        high: if high > low { high } else { low + 1.0 },
        is_logarithmic: colors.logarithmic,
        bands: colors.isolines,
        quantity: ColorScalar::default(),
    }
}

/// The background of the viewport.
fn background<'a>(app: &App, view: &'a ModelView, key: u64, is_dark: bool) -> Background<'a> {
    match &view.backdrop {
        Backdrop::Color(color) => Background::Color(*color),
        Backdrop::Image(image, fit) => Background::Image {
            picture: TextureSource {
                key,
                image: Some(&**image),
            },
            fit: *fit,
            around: [0, 0, 0],
        },
        Backdrop::Scene => match app.document.background {
            Some(own) => {
                // In modes that display light, the background is exposed like the surfaces.
                let shown = |radiance: Rgb| {
                    let shown = match view.shading {
                        Shading::Irradiance | Shading::Patches => {
                            Tone::default().map(exposure(app, view) * radiance)
                        }
                        _ => radiance,
                    };
                    let [r, g, b, _] = super::colors::color(shown).to_array();
                    [r, g, b]
                };
                match own {
                    SceneBackground::Color(radiance) => Background::Color(shown(radiance)),
                    // Its middle, above and below the horizon; pictures are rendered with all of it.
                    SceneBackground::Environment(environment) => {
                        let [lower, upper] = [-0.3, 0.3].map(|height| {
                            let texture = environment.texture();
                            let texture =
                                texture.and_then(|t| app.document.textures.get(t as usize));
                            let local = DVec3::new(1.0, 0.0, height).normalize();
                            let direction = environment.world_from_environment * local;
                            shown(
                                environment.seen(direction, texture.and_then(|t| t.image.as_ref())),
                            )
                        });
                        Background::Gradient { lower, upper }
                    }
                }
            }
            None if is_dark => Background::Gradient {
                lower: [30, 32, 36],
                upper: [66, 72, 82],
            },
            None => Background::Gradient {
                lower: [200, 204, 210],
                upper: [150, 162, 178],
            },
        },
    }
}
