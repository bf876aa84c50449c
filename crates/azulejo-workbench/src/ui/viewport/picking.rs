//! The pointer in the viewport (the mouse, or the centre of the view with the keyboard), and
//! clicks.

use super::{Viewport, hover, markers};
use crate::command::{Command, Selection};
use crate::document::{ItemId, SurfacePick};
use crate::gpu::{DrawnMesh, PickHit, Projection};
use crate::ui::panel_context::PanelContext;
use crate::view::Shading;
use azulejo::scene::Shape;
use azulejo::scene::math::Ray;
use egui::{Pos2, Rect, Response, Ui};
use glam::DVec2;

impl Viewport {
    /// Updates the pointer and handles clicks. `rect` is the rectangle of the model.
    pub(super) fn point(
        &mut self,
        ui: &Ui,
        rect: Rect,
        response: &Response,
        view: &Projection,
        cx: &mut PanelContext,
    ) {
        if self.pins_next && ui.input(|i| i.key_pressed(egui::Key::Escape)) {
            self.pins_next = false;
        }
        let Some(at) = self.pointer(response, rect) else {
            self.hover_text = None;
            self.probed_at = None;
            self.pointed = None;
            return;
        };
        let offset = at - rect.min;
        let pixel = DVec2::new(f64::from(offset.x), f64::from(offset.y));
        let ray = view.ray(pixel);
        self.pointed = Some(ray);
        if response.double_clicked() {
            let bounds = cx.app.document.frame_of(&cx.app.selection.ids);
            let mut look = cx.app.view.clone();
            look.frame(bounds);
            cx.send(Command::SetView(Box::new(look)));
        } else if response.clicked() {
            response.request_focus();
            self.click(ui, at, rect, &ray, view, cx);
        }
        // An unchanged pointer needs no new query.
        let view = &cx.app.view;
        let key = (at, cx.app.revision(), view.camera.clone(), view.shading);
        if self.probed_at.as_ref() != Some(&key) && !response.dragged() {
            self.probed_at = Some(key);
            self.hover_text = hover::text(cx, &self.pane, &ray);
        }
    }

    /// The mouse position, or the centre of the view when the keyboard is used.
    fn pointer(&mut self, response: &Response, rect: Rect) -> Option<Pos2> {
        let moves = response.ctx.input(|i| i.pointer.is_moving());
        if !response.has_focus() || (response.hovered() && moves) {
            self.by_keys = false;
        } else if response.gained_focus() && !response.hovered() {
            self.by_keys = true;
        }
        if self.by_keys {
            Some(rect.center())
        } else {
            response.hover_pos()
        }
    }

    fn click(
        &mut self,
        ui: &Ui,
        mouse: Pos2,
        rect: Rect,
        ray: &Ray,
        view: &Projection,
        cx: &mut PanelContext,
    ) {
        let modifiers = ui.input(|i| i.modifiers);
        if std::mem::take(&mut self.pins_next) {
            if let Some(pick) = self.patch_at(ray) {
                cx.send(Command::AddProbe(pick));
            }
            return;
        }
        if cx.app.view.shading == Shading::FormFactors {
            if let Some(pick) = self.patch_at(ray) {
                cx.send(Command::FormFactorsFrom(pick));
            }
            return;
        }
        if modifiers.alt {
            self.pick_face(ray, cx);
            return;
        }
        let item = markers::at(mouse, rect, view, cx.app).or_else(|| {
            let hit = self.hit(ray)?;
            Some(self.pane.cache.entries()[hit.object].id)
        });
        match item {
            Some(id) => cx.select(id, modifiers.command || modifiers.shift),
            None => cx.send(Command::Select(Selection::default())),
        }
    }

    /// The displayed surface that a ray hits first.
    pub(in crate::ui) fn patch_at(&self, ray: &Ray) -> Option<SurfacePick> {
        let hit = self.hit(ray)?;
        let entry = &self.pane.cache.entries()[hit.object];
        Some(SurfacePick {
            item: entry.id,
            position: hit.position,
            normal: entry.normal(hit.vertices, ray),
        })
    }

    fn hit(&self, ray: &Ray) -> Option<PickHit> {
        self.pane.hit(ray)
    }

    /// Toggles a face in the selection. Faces are those of the model, not the solver's patches.
    fn pick_face(&self, ray: &Ray, cx: &mut PanelContext) {
        let document = &cx.app.document;
        let meshes: Vec<(ItemId, DrawnMesh)> = (document.objects.iter())
            .filter(|item| !item.hidden)
            .filter_map(|item| match &*item.shape {
                Shape::Mesh(mesh) => Some((
                    item.id,
                    DrawnMesh {
                        world_from_object: item.placement,
                        ..DrawnMesh::new(0, mesh)
                    },
                )),
                _ => None,
            })
            .collect();
        let drawn: Vec<DrawnMesh> = meshes.iter().map(|(_, d)| *d).collect();
        let Some(hit) = self.pane.cut().pick(&drawn, ray) else {
            return;
        };
        let id = meshes[hit.object].0;
        let mut faces = match &cx.app.selection.faces {
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
        cx.send(Command::Select(Selection {
            ids: vec![id],
            faces: (!faces.is_empty()).then_some((id, faces)),
            material: material.copied(),
        }));
    }
}
