//! The model: drawn, moved around, picked.

mod gizmo;
mod legend;
mod navigate;
mod picture;
mod pins;
mod probe;
mod screen;
mod signs;
mod stage;

pub use gizmo::Mode;
pub use legend::number;
pub use probe::{radiance_unit, value};

use super::desk::Desk;
use crate::app::App;
use crate::command::{Command, PatchAt, Selection};
use crate::document::{Edit, Id};
use crate::gpu::{Background, Drawn, Frame, Pick, Picture, Projection, Quantity, Scale, pick};
use crate::view::{Backdrop, Shading};
use azulejo::scene::math::Ray;
use azulejo::scene::{Camera, Material, Shape};
use egui::{Color32, CursorIcon, Pos2, Rect, Response, Sense, Ui, Vec2};
use gizmo::{Gizmo, Grip};
use glam::{DAffine3, DVec2};
use screen::{Screen, Stamp};
use stage::Stage;

pub use screen::Loss;

/// The viewport's own state.
#[derive(Default)]
pub struct Viewport {
    stage: Stage,
    screen: Option<Screen>,
    picture: picture::Shown,
    /// What the handles of the selection do.
    pub mode: Mode,
    grip: Option<Grip>,
    /// What is under the mouse.
    probe: Option<String>,
    probed_at: Option<(Pos2, u64, Camera, Shading)>,
    /// Where the mouse is, as a ray.
    mouse_ray: Option<Ray>,
    /// Whether the next click pins a probe.
    pub pins_next: bool,
    /// Pixels.
    size: [u32; 2],
}

/// Exposure that shows the usual irradiance on a grey surface as a bright middle.
pub fn auto_exposure(app: &App) -> f64 {
    let usual = app.lighting.range.map_or(0.0, |r| r.usual);
    match usual > 0.0 {
        true => 0.6 * std::f64::consts::PI / (0.5 * usual),
        false => 1.0,
    }
}

/// The unit of irradiance.
pub fn irradiance_unit(app: &App) -> &'static str {
    match app.document.units.photometric {
        true => "lx",
        false => "W/m²",
    }
}

impl Viewport {
    /// With a graphics card to draw on.
    pub fn on(state: &eframe::egui_wgpu::RenderState) -> Result<Viewport, Loss> {
        Ok(Viewport {
            screen: Some(Screen::new(state)?),
            ..Viewport::default()
        })
    }

    /// Whether there is a card, or none was expected.
    ///
    /// # Errors
    /// [`Loss`].
    pub fn check(&self) -> Result<(), Loss> {
        self.screen.as_ref().map_or(Ok(()), Screen::check)
    }

    /// What is under the mouse.
    pub fn probe(&self) -> Option<&str> {
        self.probe.as_deref()
    }

    /// The place of a surface under the mouse.
    pub fn place_under_mouse(&self) -> Option<PatchAt> {
        self.patch_at(&self.mouse_ray?)
    }

    /// The size of the viewport, pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.size[0].max(1), self.size[1].max(1))
    }

    /// Draws the model, or the picture by rays in its place; takes the mouse and the keys.
    ///
    /// # Errors
    /// [`Loss`]: the graphics card is gone. The window has to be opened again.
    pub fn show(&mut self, ui: &mut Ui, desk: &mut Desk) -> Result<(), Loss> {
        let rect = ui.available_rect_before_wrap();
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        let name = desk.say("Viewport");
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, true, name));
        let pixels = rect.size() * ui.ctx().pixels_per_point();
        self.size = [pixels.x.round() as u32, pixels.y.round() as u32];
        let view = self.view(ui, &response, desk);
        let points = Projection::new(&view.camera, [rect.width() as u32, rect.height() as u32]);
        self.stage
            .update(desk.app, &Projection::new(&view.camera, self.size));
        if desk.app.picture.is_some() {
            self.picture.show(ui, rect, desk.app);
        } else {
            self.draw(ui, rect, desk, &view)?;
            self.handles(ui, rect, &response, &points, desk);
        }
        self.read_mouse(ui, rect, &response, &points, desk);
        pins::paint(ui, rect, &points, desk);
        self.decorate(ui, rect, desk);
        Ok(())
    }

    /// The view after this frame's mouse and keys.
    fn view(&self, ui: &Ui, response: &Response, desk: &mut Desk) -> crate::view::View {
        let app = desk.app;
        // Where a drag begins is found out below: on a handle, it does not turn the view.
        if self.grip.is_some() || response.drag_started() {
            return app.view.clone();
        }
        let (view, flies) = navigate::navigate(ui, response, app);
        if flies {
            ui.ctx().request_repaint();
        }
        if view != app.view {
            desk.wish(Command::Look(Box::new(view.clone())));
        }
        view
    }

    fn draw(
        &mut self,
        ui: &Ui,
        rect: Rect,
        desk: &Desk,
        view: &crate::view::View,
    ) -> Result<(), Loss> {
        let Some(screen) = &mut self.screen else {
            ui.painter().rect_filled(rect, 0.0, Color32::from_gray(40));
            return Ok(());
        };
        let app = desk.app;
        let scale = scale(app);
        let stamp = Stamp {
            view: view.clone(),
            size: self.size,
            revision: app.revision(),
            selection: app.selection.clone(),
            seen: app.lighting.seen.as_ref().map(|s| s.number),
            scale,
        };
        let materials: Vec<&Material> = app.document.materials.iter().map(|m| &**m).collect();
        let backdrop = self.stage.backdrop_key(&view.backdrop);
        let stage = &self.stage;
        let textures = app.document.textures.iter();
        let textures: Vec<Picture> = textures
            .map(|t| Picture {
                key: stage.texture_key(t),
                image: t.image.as_ref(),
            })
            .collect();
        let shows_factors = view.shading == Shading::FormFactors;
        let drawn = stage.drawn(app, shows_factors);
        let overlay = signs::overlay(app);
        let frame = Frame {
            shading: view.shading,
            textures: &textures,
            background: background(app, &view.backdrop, backdrop, ui.visuals().dark_mode),
            fog: app.document.fog.filter(|_| view.fog),
            overlay: &overlay,
            exposure: view.exposure.unwrap_or_else(|| auto_exposure(app)),
            scale,
            ..Frame::new(self.size, &view.camera, &drawn, &materials)
        };
        screen.draw(ui, rect, stamp, &frame)
    }

    /// The handles of what is selected.
    fn handles(
        &mut self,
        ui: &Ui,
        rect: Rect,
        response: &Response,
        view: &Projection,
        desk: &mut Desk,
    ) {
        let Some(centre) = self.handle_place(desk.app) else {
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
            // The press was a little before the drag began.
            let press = ui.input(|i| i.pointer.press_origin());
            self.grip = press.and_then(|p| gizmo.grip_at(p));
        }
        if let (Some(grip), Some(mouse)) = (&mut self.grip, response.interact_pointer_pos())
            && response.dragged()
            && let Some(map) = gizmo.drag(grip, mouse)
            && map != DAffine3::IDENTITY
        {
            let ids = desk.app.selection.ids.clone();
            desk.edit(Edit::Transform(ids, map));
        }
        if !response.dragged() {
            self.grip = None;
        }
        if under.is_some() || self.grip.is_some() {
            ui.ctx().set_cursor_icon(CursorIcon::Grab);
        }
        gizmo.paint(ui.painter(), self.grip.as_ref().or(under.as_ref()));
    }

    /// The middle of what is selected.
    fn handle_place(&self, app: &App) -> Option<glam::DVec3> {
        let selection = &app.selection;
        if selection.ids.is_empty() {
            return None;
        }
        let mut bounds = app.document.bounds(Some(&selection.ids));
        let all = app.document.bounds(None);
        for id in &selection.ids {
            if let Some(lamp) = app.document.lamp(*id) {
                bounds = bounds.with_point(signs::light_place(&lamp.light.kind, all));
            }
            if let Some(view) = app.document.viewpoint(*id) {
                bounds = bounds.with_point(view.camera.eye);
            }
        }
        (!bounds.is_empty()).then(|| bounds.centre())
    }

    fn read_mouse(
        &mut self,
        ui: &Ui,
        rect: Rect,
        response: &Response,
        view: &Projection,
        desk: &mut Desk,
    ) {
        let Some(mouse) = response.hover_pos() else {
            self.probe = None;
            self.probed_at = None;
            self.mouse_ray = None;
            return;
        };
        let place = mouse - rect.min;
        let pixel = DVec2::new(f64::from(place.x), f64::from(place.y));
        let ray = view.ray(pixel);
        self.mouse_ray = Some(ray);
        if self.pins_next && ui.input(|i| i.key_pressed(egui::Key::Escape)) {
            self.pins_next = false;
        }
        if response.double_clicked() {
            let bounds = desk.app.document.bounds(Some(&desk.app.selection.ids));
            let mut look = desk.app.view.clone();
            look.frame(bounds);
            desk.wish(Command::Look(Box::new(look)));
        } else if response.clicked() {
            response.request_focus();
            self.click(ui, mouse, rect, &ray, view, desk);
        }
        // A mouse that rests need not be asked again.
        let view = &desk.app.view;
        let key = (
            mouse,
            desk.app.revision(),
            view.camera.clone(),
            view.shading,
        );
        if self.probed_at.as_ref() != Some(&key) && !response.dragged() {
            self.probed_at = Some(key);
            self.probe = probe::text(desk, &self.stage, &ray);
        }
    }

    fn click(
        &mut self,
        ui: &Ui,
        mouse: Pos2,
        rect: Rect,
        ray: &Ray,
        view: &Projection,
        desk: &mut Desk,
    ) {
        let modifiers = ui.input(|i| i.modifiers);
        if std::mem::take(&mut self.pins_next) {
            if let Some(place) = self.patch_at(ray) {
                desk.wish(Command::Pin(place));
            }
            return;
        }
        if desk.app.view.shading == Shading::FormFactors {
            if let Some(place) = self.patch_at(ray) {
                desk.wish(Command::FormFactorsFrom(place));
            }
            return;
        }
        if modifiers.alt {
            self.pick_face(ray, desk);
            return;
        }
        let found = self.sign_at(mouse, rect, view, desk.app).or_else(|| {
            let drawn = self.stage.drawn(desk.app, false);
            let hit = pick(&drawn, ray, false)?;
            Some(self.stage.entries()[hit.object].id)
        });
        match found {
            Some(id) => desk.select(id, modifiers.command || modifiers.shift),
            None => desk.wish(Command::Select(Selection::default())),
        }
    }

    fn patch_at(&self, ray: &Ray) -> Option<PatchAt> {
        let hit = self.hit(ray)?;
        let entry = &self.stage.entries()[hit.object];
        Some(PatchAt {
            item: entry.id,
            position: hit.position,
            normal: entry.normal(hit.vertices, ray),
        })
    }

    fn hit(&self, ray: &Ray) -> Option<Pick> {
        let entries = self.stage.entries().iter();
        let drawn: Vec<Drawn> = entries
            .map(|e| Drawn {
                world_from_object: e.placement,
                ..Drawn::new(0, e.mesh())
            })
            .collect();
        pick(&drawn, ray, false)
    }

    /// Adds a face to the selection, or takes it away. Faces are those of the model, whatever the
    /// solver divided them into.
    fn pick_face(&self, ray: &Ray, desk: &mut Desk) {
        let document = &desk.app.document;
        let meshes: Vec<(Id, Drawn)> = (document.items.iter())
            .filter(|item| !item.hidden)
            .filter_map(|item| match &*item.shape {
                Shape::Mesh(mesh) => Some((
                    item.id,
                    Drawn {
                        world_from_object: item.placement,
                        ..Drawn::new(0, mesh)
                    },
                )),
                _ => None,
            })
            .collect();
        let drawn: Vec<Drawn> = meshes.iter().map(|(_, d)| *d).collect();
        let Some(hit) = pick(&drawn, ray, false) else {
            return;
        };
        let id = meshes[hit.object].0;
        let mut faces = match &desk.app.selection.faces {
            Some((old, faces)) if *old == id => faces.clone(),
            _ => Vec::new(),
        };
        match faces.iter().position(|&f| f as usize == hit.face) {
            Some(at) => {
                faces.remove(at);
            }
            None => faces.push(hit.face as u32),
        }
        let material = drawn[hit.object].mesh.face_materials.get(hit.face);
        desk.wish(Command::Select(Selection {
            ids: vec![id],
            faces: (!faces.is_empty()).then_some((id, faces)),
            material: material.copied(),
        }));
    }

    /// The light or camera whose sign is under the mouse.
    fn sign_at(&self, mouse: Pos2, rect: Rect, view: &Projection, app: &App) -> Option<Id> {
        const NEAR: f32 = 12.0;
        if !app.view.signs {
            return None;
        }
        let bounds = app.document.bounds(None);
        let lights = app.document.lights.iter();
        let lights = lights.map(|l| (l.id, signs::light_place(&l.light.kind, bounds)));
        let cameras = app.document.cameras.iter();
        let cameras = cameras.map(|c| (c.id, c.camera.eye));
        let distance = |p: glam::DVec3| {
            let p = view.project(p)?;
            let p = rect.min + Vec2::new(p.x as f32, p.y as f32);
            Some(p.distance(mouse)).filter(|d| *d < NEAR)
        };
        let near = lights.chain(cameras);
        let near = near.filter_map(|(id, p)| Some((id, distance(p)?)));
        near.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(id, _)| id)
    }

    /// What is painted over the model: legends and buttons.
    fn decorate(&mut self, ui: &mut Ui, rect: Rect, desk: &Desk) {
        let app = desk.app;
        if app.picture.is_none() {
            match app.view.shading {
                Shading::FalseColor if app.lighting.solution.is_some() => {
                    legend::paint(ui.painter(), rect, &scale(app), irradiance_unit(app));
                }
                Shading::FormFactors if app.lighting.seen.is_some() => {
                    legend::paint(ui.painter(), rect, &scale(app), "F");
                }
                _ => {}
            }
        }
        if let Some(hint) = self.hint(desk) {
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
        if app.picture.is_none() && !app.selection.ids.is_empty() {
            self.mode_buttons(ui, rect, desk);
        }
    }

    /// What one should know of what is shown.
    fn hint(&self, desk: &Desk) -> Option<&'static str> {
        let app = desk.app;
        let lighting = &app.lighting;
        let shading = app.view.shading;
        if app.document.items.is_empty() {
            None
        } else if self.pins_next {
            Some(desk.say("Click the place to watch; Escape for none."))
        } else if shading == Shading::FormFactors && lighting.seen.is_none() {
            Some(desk.say("Click a surface: its form factors become colours."))
        } else if shading.shows_light() && lighting.solution.is_none() {
            Some(desk.say("Not solved yet: press F5."))
        } else if shading.shows_light() && !lighting.is_current {
            Some(desk.say("This light is from before the last changes: press F5."))
        } else {
            None
        }
    }

    fn mode_buttons(&mut self, ui: &mut Ui, rect: Rect, desk: &Desk) {
        let modes = [
            (Mode::Move, desk.say("Move")),
            (Mode::Turn, desk.say("Turn")),
            (Mode::Scale, desk.say("Resize")),
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

/// How numbers become colours now.
fn scale(app: &App) -> Scale {
    let colors = &app.view.false_color;
    if app.view.shading == Shading::FormFactors {
        let factors = app.lighting.seen.iter().flat_map(|s| s.factors.iter());
        let high = factors.fold(0.0, |a: f64, &b| a.max(b)).max(1e-9);
        return Scale {
            map: colors.map,
            low: if colors.logarithmic { 1e-4 * high } else { 0.0 },
            high,
            is_logarithmic: colors.logarithmic,
            bands: 0,
            quantity: Quantity::default(),
        };
    }
    let found = app.lighting.range;
    let found = found.map_or((0.0, 1.0), |r| (r.low, r.usual.max(r.low + 1e-12)));
    let (mut low, mut high) = colors.range.unwrap_or(found);
    if colors.logarithmic {
        high = high.max(1e-9);
        low = low.clamp(1e-4 * high, high);
    }
    Scale {
        map: colors.map,
        low,
        high: if high > low { high } else { low + 1.0 },
        is_logarithmic: colors.logarithmic,
        bands: colors.isolines,
        quantity: Quantity::default(),
    }
}

/// What is behind the model.
fn background<'a>(app: &App, backdrop: &'a Backdrop, key: u64, is_dark: bool) -> Background<'a> {
    match backdrop {
        Backdrop::Color(color) => Background::Color(*color),
        Backdrop::Image(image, fit) => Background::Image {
            picture: Picture {
                key,
                image: Some(&**image),
            },
            fit: *fit,
            around: [0, 0, 0],
        },
        Backdrop::Scene => match app.document.background {
            Some(radiance) => {
                let [r, g, b, _] = super::paint::color(radiance).to_array();
                Background::Color([r, g, b])
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
