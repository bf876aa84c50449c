//! Properties of the selection.

use super::panel_context::PanelContext;
use super::{emitter, group_transform, inputs, lamps};
use crate::command::{Command, Selection};
use crate::document::{Edit, ItemId, SceneCamera, SceneDocument, SceneObject};
use crate::ui::focus;
use azulejo::scene::{Camera, MaterialId, Mesh, PrimitiveKind, Shape};
use egui::{Grid, Ui};
use glam::{DAffine3, DQuat, DVec3, EulerRot};
use std::sync::Arc;

/// Draws the tab.
pub fn show(ui: &mut Ui, cx: &mut PanelContext) {
    let app = cx.app;
    match &app.selection.ids[..] {
        [] => nothing(ui, cx),
        [id] => {
            if let Some(item) = app.document.object(*id) {
                object(ui, cx, item);
            } else if let Some(lamp) = app.document.light(*id) {
                lamps::show(ui, cx, lamp);
            } else if let Some(view) = app.document.camera(*id) {
                camera_numbers(ui, cx, view);
            }
        }
        several => {
            let text = cx.tr("selected");
            ui.label(format!("{} {text}", several.len()));
            group_transform::show(ui, cx);
            assign(ui, cx);
        }
    }
}

/// Properties of the scene, if nothing is selected.
fn nothing(ui: &mut Ui, cx: &mut PanelContext) {
    let document = &cx.app.document;
    ui.weak(cx.tr("Nothing is selected: click an object, here or in the tree."));
    ui.add_space(6.0);
    Grid::new("scene").num_columns(2).show(ui, |ui| {
        let mut row = |name: &str, value: String| {
            ui.label(name);
            ui.label(value);
            ui.end_row();
        };
        row(cx.tr("Objects"), document.objects.len().to_string());
        row(cx.tr("Faces"), document.face_count().to_string());
        let emitters = document.objects.iter().filter(|item| document.shines(item));
        let lights = document.lights.len() + emitters.count();
        row(cx.tr("Lights"), lights.to_string());
        let size = document.bounds(None).size();
        row(
            cx.tr("Size"),
            format!("{:.4} × {:.4} × {:.4}", size.x, size.y, size.z),
        );
    });
    units(ui, cx);
}

fn units(ui: &mut Ui, cx: &mut PanelContext) {
    use azulejo::scene::Up;
    let old = cx.app.document.units;
    let mut units = old;
    ui.horizontal(|ui| {
        ui.label(cx.tr("Scene unit"));
        let mut metres = units.metres();
        let speed = 0.01 * metres;
        let drag = inputs::number(&mut metres, 1e-9..=1e9).speed(speed);
        if ui.add(drag.suffix(" m")).changed() {
            units.metres_per_unit = Some(metres);
        }
    });
    ui.horizontal(|ui| {
        ui.label(cx.tr("Up axis"));
        ui.selectable_value(&mut units.up, Up::Y, "y");
        ui.selectable_value(&mut units.up, Up::Z, "z");
    });
    ui.horizontal_wrapped(|ui| {
        ui.label(cx.tr("Values in the file are in"));
        ui.selectable_value(&mut units.photometric, false, cx.tr("Watts"));
        ui.selectable_value(&mut units.photometric, true, cx.tr("Lumens"));
    });
    if units != old {
        cx.edit(Edit::SetUnits(units));
    }
}

fn object(ui: &mut Ui, cx: &mut PanelContext, item: &SceneObject) {
    name(ui, cx, item.id, &item.name);
    let kind = kind_of(&item.shape, cx);
    ui.weak(kind);
    placement(ui, cx, item);
    if let Shape::Primitive(primitive) = &*item.shape
        && let PrimitiveKind::Cone { top } = primitive.kind
    {
        let mut new_top = top;
        ui.horizontal(|ui| {
            let drag = inputs::number(&mut new_top, 0.0..=1.0).speed(0.01);
            inputs::labelled(ui, cx.tr("Top radius"), drag);
        });
        if new_top != top {
            let mut cone = primitive.clone();
            cone.kind = PrimitiveKind::Cone { top: new_top };
            cone.light = None;
            cx.edit(Edit::SetShape(item.id, Arc::new(Shape::Primitive(cone))));
        }
    }
    emitter::show(ui, cx, item);
    ui.separator();
    assign(ui, cx);
}

fn kind_of(shape: &Shape, cx: &PanelContext) -> String {
    let of_mesh = |mesh: &Mesh| {
        let [vertices, faces] = [cx.tr("vertices"), cx.tr("faces")];
        let (v, f) = (mesh.positions.len(), mesh.faces.len());
        format!("{}: {v} {vertices}, {f} {faces}", cx.tr("mesh"))
    };
    match shape {
        Shape::Mesh(mesh) => of_mesh(mesh),
        Shape::Instance(instance) => of_mesh(&instance.mesh),
        Shape::Primitive(p) => match p.kind {
            PrimitiveKind::Sphere => cx.tr("exact sphere").into(),
            PrimitiveKind::Cylinder => cx.tr("exact cylinder").into(),
            PrimitiveKind::Cone { .. } => cx.tr("exact cone").into(),
            PrimitiveKind::Tube { .. } => cx.tr("exact tube").into(),
            PrimitiveKind::Cuboid => cx.tr("exact box").into(),
            PrimitiveKind::Square => cx.tr("exact parallelogram").into(),
        },
        Shape::Exact(exact) => {
            let text = cx.tr("exact solids");
            format!("{}: {}", text, exact.leaves().len())
        }
    }
}

/// The field of a name.
pub(super) fn name(ui: &mut Ui, cx: &mut PanelContext, id: ItemId, name: &str) {
    let label = ui.label(cx.tr("Name"));
    // Names are trimmed, but typing two words needs a space at the end for a moment.
    let draft = ui.scope_id().with(("name", id));
    let typed = ui.data(|d| d.get_temp::<String>(draft));
    let mut text = typed.unwrap_or_else(|| name.to_owned());
    let response = ui.text_edit_singleline(&mut text).labelled_by(label.id);
    // Queried first: inside the closure the context is locked.
    let has_focus = response.has_focus();
    ui.data_mut(|d| {
        d.remove::<String>(draft);
        if has_focus {
            d.insert_temp(draft, text.clone());
        }
    });
    // Each letter is an edit; those typed without interruption are one undo step.
    if response.changed() && text != name {
        let gesture = Some(response.id.value() ^ id.0);
        cx.send(Command::Edit(Edit::Rename(id, text), gesture));
    }
}

/// Three number fields in a row.
pub(super) fn vector(ui: &mut Ui, name: &str, v: &mut DVec3, speed: f64) -> bool {
    ui.label(name);
    let mut changed = false;
    ui.horizontal(|ui| {
        let width = field_width(ui);
        // A narrow field shows fewer digits; the number keeps all of them.
        let decimals = ((width - 34.0) / 7.0).clamp(1.0, 6.0) as usize;
        for (axis, x) in ["x", "y", "z"]
            .into_iter()
            .zip([&mut v.x, &mut v.y, &mut v.z])
        {
            // Farther away, not even half precision would be left for the model.
            let drag = inputs::number(x, -1e12..=1e12)
                .speed(speed)
                .max_decimals(decimals)
                .prefix(format!("{axis} "));
            let response = ui.add_sized([width, ui.spacing().interact_size.y], drag);
            response.widget_info(|| {
                egui::WidgetInfo::labeled(egui::Role::SpinButton, true, format!("{name} {axis}"))
            });
            changed |= response.changed();
        }
    });
    ui.end_row();
    changed
}

/// Width of each of three number fields that share a row.
fn field_width(ui: &Ui) -> f32 {
    let gaps = 2.0 * ui.spacing().item_spacing.x;
    // A grid gives its last column what the widest row of the last frame took: more than shows.
    let shown = ui.clip_rect().right() - ui.cursor().left() - ui.spacing().item_spacing.x;
    ((ui.available_width().min(shown) - gaps) / 3.0).clamp(36.0, 96.0)
}

/// Change of a coordinate per pixel of dragging.
pub(super) fn speed(document: &SceneDocument) -> f64 {
    (document.bounds(None).diagonal() * 1e-3).max(1e-6)
}

/// Position, rotation and scale of an object about its own centre.
fn placement(ui: &mut Ui, cx: &mut PanelContext, item: &SceneObject) {
    let mut numbers = PlacementNumbers::of(item);
    let before = numbers;
    let id = ui.scope_id().with("keeps proportions");
    let mut is_locked = ui.data(|d| d.get_temp::<bool>(id)).unwrap_or(true);
    Grid::new("placement").num_columns(2).show(ui, |ui| {
        let speed = speed(&cx.app.document);
        vector(ui, cx.tr("Position"), &mut numbers.centre, speed);
        if numbers.is_plain {
            vector(ui, cx.tr("Rotation °"), &mut numbers.degrees, 0.5);
            vector(ui, cx.tr("Scale"), &mut numbers.scale, 0.01);
            ui.label("");
            ui.checkbox(&mut is_locked, cx.tr("Keep proportions"));
            ui.end_row();
        }
        ui.label(cx.tr("Size"));
        let size = item.bounds().size();
        ui.weak(format!("{:.4} × {:.4} × {:.4}", size.x, size.y, size.z));
        ui.end_row();
    });
    ui.data_mut(|d| d.insert_temp(id, is_locked));
    if ui.button(cx.tr("Reset transform")).clicked() {
        cx.edit(Edit::SetPlacement(item.id, DAffine3::IDENTITY));
    }
    if is_locked {
        numbers.keep_proportions(&before);
    }
    if numbers != before {
        cx.edit(Edit::SetPlacement(
            item.id,
            numbers.placement(&before, item),
        ));
    }
}

/// The placement of an object as numbers: its centre in the world, and rotation and scale about it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PlacementNumbers {
    /// Centre of the bounding box of the shape, world units.
    centre: DVec3,
    /// The same in object space.
    pivot: DVec3,
    /// Angles about x, then y, then z.
    degrees: DVec3,
    scale: DVec3,
    /// Whether the placement is made of rotation and scale; a shear is not.
    is_plain: bool,
}

impl PlacementNumbers {
    fn of(item: &SceneObject) -> PlacementNumbers {
        let (scale, rotation, translation) = item.placement.to_scale_rotation_translation();
        let again = DAffine3::from_scale_rotation_translation(scale, rotation, translation);
        let pivot = item.pivot();
        // Adding 0 removes the sign of a negative zero.
        let angles = DVec3::from(rotation.to_euler(EulerRot::XYZ)).map(|a| a.to_degrees() + 0.0);
        PlacementNumbers {
            centre: item.placement.transform_point3(pivot),
            pivot,
            degrees: angles,
            scale,
            is_plain: again.abs_diff_eq(item.placement, 1e-9 * (1.0 + scale.length())),
        }
    }

    /// Scales all axes by the factor by which one of them was changed.
    fn keep_proportions(&mut self, before: &PlacementNumbers) {
        let changed = (0..3).find(|&k| self.scale[k] != before.scale[k]);
        if let Some(axis) = changed
            && before.scale[axis] != 0.0
        {
            self.scale = before.scale * (self.scale[axis] / before.scale[axis]);
        }
    }

    /// The placement that has these numbers, and otherwise those from before.
    fn placement(&self, before: &PlacementNumbers, item: &SceneObject) -> DAffine3 {
        if !self.is_plain || (self.degrees, self.scale) == (before.degrees, before.scale) {
            let moved = DAffine3::from_translation(self.centre - before.centre);
            return moved * item.placement;
        }
        let turn = if self.degrees == before.degrees {
            item.placement.to_scale_rotation_translation().1
        } else {
            let [x, y, z] = self.degrees.to_array().map(f64::to_radians);
            DQuat::from_euler(EulerRot::XYZ, x, y, z)
        };
        DAffine3::from_scale_rotation_translation(self.scale, turn, self.centre)
            * DAffine3::from_translation(-self.pivot)
    }
}

/// The materials of the selection, and the choice of another.
fn assign(ui: &mut Ui, cx: &mut PanelContext) {
    let app = cx.app;
    let document = &app.document;
    let selection = &app.selection;
    // Collect the materials of all selected objects, each once.
    let mut used: Vec<MaterialId> = Vec::new();
    for id in &selection.ids {
        if let Some(item) = document.object(*id) {
            used.extend(item.materials());
        }
    }
    used.sort_unstable();
    used.dedup();
    // Lights and cameras have no materials; without any, and without faces, there is nothing to assign.
    if used.is_empty() && selection.faces.is_none() {
        return;
    }
    ui.label(cx.tr("Materials"));
    // A click on a name selects the material itself for editing; a long list is cut.
    for &material in used.iter().take(20) {
        let is_it = selection.material == Some(material);
        if ui
            .selectable_label(is_it, named(document, material))
            .clicked()
        {
            let mut selection = selection.clone();
            selection.material = Some(material);
            cx.send(Command::Select(selection));
        }
    }
    // Offer all materials of the document, for the selected faces alone if there are any.
    let what = match &selection.faces {
        Some((_, faces)) => format!("{} {}", faces.len(), cx.tr("selected faces")),
        None => cx.tr("Material").to_owned(),
    };
    let mut chosen = None;
    egui::ComboBox::new("assign", what)
        .selected_text(match used[..] {
            [one] => named(document, one),
            _ => cx.tr("Multiple").to_owned(),
        })
        .show_ui(ui, |ui| {
            focus::close_list(ui);
            for k in 0..document.materials.len() as MaterialId {
                if ui
                    .selectable_label(used == [k], named(document, k))
                    .clicked()
                {
                    chosen = Some(k);
                }
            }
        });
    // Select the assigned material, too, so that its properties are shown.
    if let Some(material) = chosen {
        cx.edit(match &selection.faces {
            Some((id, faces)) => Edit::AssignFaces(*id, faces.clone(), material),
            None => Edit::Assign(selection.ids.clone(), material),
        });
        cx.send(Command::Select(Selection {
            material: Some(material),
            ..selection.clone()
        }));
    }
}

/// The name of a material, or its index.
pub fn named(document: &SceneDocument, material: MaterialId) -> String {
    match document.materials.get(material as usize) {
        Some(m) if !m.name.is_empty() => m.name.clone(),
        _ => format!("#{material}"),
    }
}

fn camera_numbers(ui: &mut Ui, cx: &mut PanelContext, view: &SceneCamera) {
    name(ui, cx, view.id, &view.camera.name);
    let mut camera = view.camera.clone();
    let step = speed(&cx.app.document);
    let mut changed = false;
    Grid::new("camera").num_columns(2).show(ui, |ui| {
        changed |= vector(ui, cx.tr("Viewpoint"), &mut camera.eye, step);
        changed |= vector(ui, cx.tr("Target"), &mut camera.target, step);
        changed |= vector(ui, cx.tr("Up"), &mut camera.up, 0.01);
        let mut degrees = camera.vertical_fov.to_degrees();
        let drag = inputs::number(&mut degrees, 1.0..=170.0)
            .speed(0.25)
            .suffix("°");
        if inputs::labelled(ui, cx.tr("Field of view"), drag).changed() {
            camera.vertical_fov = degrees.to_radians();
            changed = true;
        }
        ui.end_row();
    });
    ui.horizontal_wrapped(|ui| {
        if ui.button(cx.tr("View through camera")).clicked() {
            let mut look = cx.app.view.clone();
            look.camera = view.camera.clone();
            cx.send(Command::SetView(Box::new(look)));
        }
        if ui.button(cx.tr("Move camera to view")).clicked() {
            camera = Camera {
                name: view.camera.name.clone(),
                size: view.camera.size,
                ..cx.app.view.camera.clone()
            };
            changed = true;
        }
    });
    if changed {
        cx.edit(Edit::SetCamera(view.id, camera));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::App;
    use crate::command::Command;
    use crate::document::NewShapeKind;

    /// A box whose corner is at (2, 0, 0), with the identity as its placement.
    fn item() -> SceneObject {
        let mut app = App::quiet();
        app.execute(Command::AddShape(NewShapeKind::Cuboid));
        let id = app.document.objects[0].id;
        let map = DAffine3::from_translation(DVec3::new(2.0, 0.0, 0.0));
        app.execute(Command::Edit(Edit::Transform(vec![id], map), None));
        app.document.objects[0].as_ref().clone()
    }

    #[test]
    fn the_position_is_where_the_object_is() {
        let item = item();
        let numbers = PlacementNumbers::of(&item);
        let expected = item.bounds().centre();
        assert!((numbers.centre - expected).length() < 1e-12, "{numbers:?}");
    }

    #[test]
    fn an_object_is_scaled_and_turned_about_its_own_centre() {
        let item = item();
        let before = PlacementNumbers::of(&item);
        let mut transform = before;
        transform.scale.y *= 3.0;
        transform.keep_proportions(&before);
        assert_eq!(transform.scale, before.scale * 3.0);
        transform.degrees.y += 90.0;
        let placement = transform.placement(&before, &item);
        let centre = placement.transform_point3(before.pivot);
        assert!((centre - before.centre).length() < 1e-12, "{centre}");
        let mut moved = before;
        moved.centre += DVec3::X;
        let placement = moved.placement(&before, &item);
        assert_eq!(placement.matrix3, item.placement.matrix3);
        let shift = placement.translation - item.placement.translation;
        assert!((shift - DVec3::X).length() < 1e-12);
    }
}
