//! The viewport: drawing, navigation and picking.

mod cache;
mod cards;
mod compare;
mod cube;
mod gizmo;
mod hover;
mod isolines;
mod legend;
mod markers;
mod navigate;
mod pane;
mod picking;
mod probe_markers;
mod rendered;
mod start;
mod task_plane;
mod texture;

pub(super) use markers::middle;

pub(super) use cards::{action_button, render_state};
pub use gizmo::GizmoMode;
pub use hover::value;
pub use legend::number;
pub(super) use legend::{LegendText, paint as paint_legend};

use super::actions::ActionTarget;
use super::panel_context::PanelContext;
use crate::command::Command;
use crate::document::{Edit, SurfacePick};
use crate::gpu::Projection;
use crate::view::{ModelView, Shading};
use azulejo::scene::Camera;
use azulejo::scene::math::Ray;
use egui::{Color32, CursorIcon, Pos2, Rect, Response, Sense, Ui, Vec2};
use gizmo::{Gizmo, GizmoHandle};
use glam::DAffine3;
use pane::ViewPane;

pub use texture::DeviceLost;

/// The state of the viewport.
#[derive(Default)]
pub struct Viewport {
    pane: ViewPane,
    /// The picture at the right, where two are compared.
    other: Option<ViewPane>,
    rendered: rendered::RenderTexture,
    start: start::StartScreen,
    /// Whether the handles of the selection move, rotate or scale it.
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
            pane: ViewPane::on(state)?,
            ..Viewport::default()
        })
    }

    /// Checks that the device is available, if there should be one.
    ///
    /// # Errors
    ///
    /// [`DeviceLost`].
    pub fn check(&self) -> Result<(), DeviceLost> {
        self.pane.check()
    }

    /// The image of the model as last drawn, three bytes per pixel: width, height and pixels.
    pub fn pixels(&self) -> Option<(u32, u32, Vec<u8>)> {
        let pixels = self.pane.pixels()?;
        Some((pixels.width, pixels.height, pixels.rgb()))
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

    /// Draws the model or the rendered image; handles the mouse and the keyboard. Returns the
    /// actions that were chosen on its cards.
    ///
    /// # Errors
    ///
    /// [`DeviceLost`] if the graphics device is lost. The window has to be opened again.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext,
    ) -> Result<Vec<ActionTarget>, DeviceLost> {
        let rect = ui.available_rect_before_wrap();
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        let name = cx.tr("Viewport");
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, true, name));
        let pixels = rect.size() * ui.ctx().pixels_per_point();
        self.size = [pixels.x.round() as u32, pixels.y.round() as u32];
        let view = self.view(ui, &response, cx);
        // An image rendered at another size covers only a part of the viewport.
        let seen = match &cx.app.render {
            Some(shown) => rendered::fit(rect, shown.size),
            None => rect,
        };
        let points = Projection::new(&view.camera, [seen.width() as u32, seen.height() as u32]);
        if cx.app.render.is_some() {
            // What is under the mouse is that of the model, of which the image is.
            self.pane.update(cx.app, &view, self.size);
            self.rendered.show(ui, rect, cx.app);
        } else {
            self.draw(ui, rect, cx, &view)?;
            self.handles(ui, rect, &response, &points, cx);
            if !cx.app.is_blank() {
                cube::show(ui, &response, cx, &view);
            }
        }
        self.point(ui, seen, &response, &points, cx);
        probe_markers::paint(ui, seen, &points, cx);
        self.decorate(ui, rect, cx);
        let targets = self.cards(ui, rect, cx);
        Ok(targets)
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

    /// Draws the model, and at the right another picture of it where two are compared.
    fn draw(
        &mut self,
        ui: &mut Ui,
        rect: Rect,
        cx: &mut PanelContext,
        view: &ModelView,
    ) -> Result<(), DeviceLost> {
        self.pane.draw(ui, (rect, rect), self.size, cx, view)?;
        let Some(comparison) = view.comparison else {
            self.other = None;
            return Ok(());
        };
        let other = match &mut self.other {
            Some(other) => other,
            none => none.insert(self.pane.beside()?),
        };
        let right = ModelView {
            shading: comparison.with,
            comparison: None,
            ..view.clone()
        };
        let clip = compare::right_part(rect, &comparison);
        other.draw(ui, (rect, clip), self.size, cx, &right)?;
        compare::divider(ui, rect, cx, view);
        Ok(())
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

    /// Draws the cards: a failure, progress, and what can be done next.
    fn cards(&mut self, ui: &mut Ui, rect: Rect, cx: &mut PanelContext) -> Vec<ActionTarget> {
        if cx.app.is_blank() {
            let targets = self.start.show(ui, rect, cx);
            cards::show_failure(ui, rect, cx);
            return targets;
        }
        self.start.leave();
        let rect = match cx.app.render {
            Some(_) => rect,
            None => cube::room_for_cards(rect, &cx.app.view, cards::WIDTH),
        };
        cards::show_failure(ui, rect, cx);
        if cards::show_progress(ui, rect, cx) {
            return Vec::new();
        }
        if cx.app.render.is_some() {
            cards::show_render(ui, rect, cx)
        } else {
            cards::show_finer_mesh(ui, rect, cx);
            cards::show_inaccurate(ui, rect, cx);
            cards::show_next(ui, rect, cx)
        }
    }

    /// Draws legends and buttons over the model.
    fn decorate(&mut self, ui: &mut Ui, rect: Rect, cx: &PanelContext) {
        let app = cx.app;
        if self.by_keys {
            probe_markers::cross(ui.painter(), rect.center(), "", 1.0);
        }
        if app.render.is_none() {
            self.pane.legend(ui, rect, cx, app.view.shading);
            if let (Some(comparison), Some(other)) = (&app.view.comparison, &self.other) {
                let right = compare::right_part(rect, comparison);
                other.legend(ui, right, cx, comparison.with);
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
            let frame = egui::Frame::popup(ui.style()).inner_margin(2.0);
            frame.show(ui, |ui| {
                ui.horizontal(|ui| {
                    for (mode, name) in modes {
                        ui.selectable_value(&mut self.mode, mode, name);
                    }
                });
            });
        });
    }
}
