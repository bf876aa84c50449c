//! Numbers of what is selected.

use super::desk::PanelContext;
use super::{inputs, together};
use crate::command::{Command, Selection};
use crate::document::{Edit, ItemId, SceneCamera, SceneDocument, SceneLight, SceneObject};
use azulejo::scene::{Camera, Light, LightKind, MaterialId, PrimitiveKind, Rgb, Shape, Units};
use egui::{Grid, Ui};
use glam::{DAffine3, DQuat, DVec3, EulerRot};
use std::sync::Arc;

/// Draws it.
pub fn show(ui: &mut Ui, desk: &mut PanelContext) {
    let app = desk.app;
    match &app.selection.ids[..] {
        [] => nothing(ui, desk),
        [id] => {
            if let Some(item) = app.document.item(*id) {
                object(ui, desk, item);
            } else if let Some(lamp) = app.document.lamp(*id) {
                lamp_numbers(ui, desk, lamp);
            } else if let Some(view) = app.document.viewpoint(*id) {
                camera_numbers(ui, desk, view);
            }
        }
        several => {
            let text = desk.say("selected");
            ui.label(format!("{} {text}", several.len()));
            together::show(ui, desk);
            assign(ui, desk);
        }
    }
}

/// What the scene is as a whole.
fn nothing(ui: &mut Ui, desk: &mut PanelContext) {
    let document = &desk.app.document;
    ui.weak(desk.say("Nothing is selected: click an object, here or in the tree."));
    ui.add_space(6.0);
    Grid::new("scene").num_columns(2).show(ui, |ui| {
        let mut row = |name: &str, value: String| {
            ui.label(name);
            ui.label(value);
            ui.end_row();
        };
        row(desk.say("Objects"), document.items.len().to_string());
        row(desk.say("Faces"), document.face_count().to_string());
        row(desk.say("Lights"), document.lights.len().to_string());
        let size = document.bounds(None).size();
        row(
            desk.say("Size"),
            format!("{:.4} × {:.4} × {:.4}", size.x, size.y, size.z),
        );
    });
    units(ui, desk);
}

fn units(ui: &mut Ui, desk: &mut PanelContext) {
    use azulejo::scene::Up;
    let old = desk.app.document.units;
    let mut units = old;
    ui.horizontal(|ui| {
        ui.label(desk.say("One unit is"));
        let mut metres = units.metres();
        let speed = 0.01 * metres;
        let drag = inputs::number(&mut metres, 1e-9..=1e9).speed(speed);
        if ui.add(drag.suffix(" m")).changed() {
            units.metres_per_unit = Some(metres);
        }
    });
    ui.horizontal(|ui| {
        ui.label(desk.say("Up is"));
        ui.selectable_value(&mut units.up, Up::Y, "y");
        ui.selectable_value(&mut units.up, Up::Z, "z");
    });
    ui.horizontal(|ui| {
        ui.label(desk.say("Light is in"));
        ui.selectable_value(&mut units.photometric, false, desk.say("watts"));
        ui.selectable_value(&mut units.photometric, true, desk.say("lumens"));
    });
    if units != old {
        desk.edit(Edit::SetUnits(units));
    }
}

fn object(ui: &mut Ui, desk: &mut PanelContext, item: &SceneObject) {
    name(ui, desk, item.id, &item.name);
    let kind = kind_of(&item.shape, desk);
    ui.weak(kind);
    placement(ui, desk, item);
    if let Shape::Primitive(primitive) = &*item.shape
        && let PrimitiveKind::Cone { top } = primitive.kind
    {
        let mut new_top = top;
        ui.horizontal(|ui| {
            let label = ui.label(desk.say("Radius at the top"));
            let drag = inputs::number(&mut new_top, 0.0..=1.0).speed(0.01);
            ui.add(drag).labelled_by(label.id);
        });
        if new_top != top {
            let mut cone = primitive.clone();
            cone.kind = PrimitiveKind::Cone { top: new_top };
            cone.light = None;
            desk.edit(Edit::SetShape(item.id, Arc::new(Shape::Primitive(cone))));
        }
    }
    ui.separator();
    assign(ui, desk);
}

fn kind_of(shape: &Shape, desk: &PanelContext) -> String {
    match shape {
        Shape::Mesh(mesh) => format!(
            "{}: {} {}, {} {}",
            desk.say("mesh"),
            mesh.positions.len(),
            desk.say("vertices"),
            mesh.faces.len(),
            desk.say("faces")
        ),
        Shape::Primitive(p) => match p.kind {
            PrimitiveKind::Sphere => desk.say("exact sphere").into(),
            PrimitiveKind::Cylinder => desk.say("exact cylinder").into(),
            PrimitiveKind::Cone { .. } => desk.say("exact cone").into(),
            PrimitiveKind::Tube { .. } => desk.say("exact tube").into(),
            PrimitiveKind::Cuboid => desk.say("exact box").into(),
            PrimitiveKind::Square => desk.say("exact parallelogram").into(),
        },
        Shape::Exact(exact) => {
            let text = desk.say("exact solids");
            format!("{}: {}", text, exact.leaves().len())
        }
    }
}

fn name(ui: &mut Ui, desk: &mut PanelContext, id: ItemId, name: &str) {
    let label = ui.label(desk.say("Name"));
    // A name has no space at its end, but who types two words passes there.
    let draft = ui.scope_id().with(("name", id));
    let typed = ui.data(|d| d.get_temp::<String>(draft));
    let mut text = typed.unwrap_or_else(|| name.to_owned());
    let response = ui.text_edit_singleline(&mut text).labelled_by(label.id);
    // Asked before: within, the context is locked.
    let has_focus = response.has_focus();
    ui.data_mut(|d| {
        d.remove::<String>(draft);
        if has_focus {
            d.insert_temp(draft, text.clone());
        }
    });
    // Each letter is an edit; all that are typed without a pause elsewhere are one step.
    if response.changed() && text != name {
        let gesture = Some(response.id.value() ^ id.0);
        desk.wish(Command::Edit(Edit::Rename(id, text), gesture));
    }
}

/// Three numbers in a row.
pub(super) fn vector(ui: &mut Ui, name: &str, v: &mut DVec3, speed: f64) -> bool {
    ui.label(name);
    let mut changed = false;
    ui.horizontal(|ui| {
        for (axis, x) in ["x", "y", "z"]
            .into_iter()
            .zip([&mut v.x, &mut v.y, &mut v.z])
        {
            let drag = inputs::number(x, f64::NEG_INFINITY..=f64::INFINITY)
                .speed(speed)
                .max_decimals(6)
                .prefix(format!("{axis} "));
            let response = ui.add_sized([96.0, ui.spacing().interact_size.y], drag);
            response.widget_info(|| {
                egui::WidgetInfo::labeled(egui::Role::SpinButton, true, format!("{name} {axis}"))
            });
            changed |= response.changed();
        }
    });
    ui.end_row();
    changed
}

/// How far a pixel of dragging goes.
pub(super) fn speed(document: &SceneDocument) -> f64 {
    (document.bounds(None).diagonal() * 1e-3).max(1e-6)
}

fn placement(ui: &mut Ui, desk: &mut PanelContext, item: &SceneObject) {
    let (mut scale, rotation, mut translation) = item.placement.to_scale_rotation_translation();
    // Adding 0 takes the sign from a negative zero.
    let angles = DVec3::from(rotation.to_euler(EulerRot::XYZ)).map(|a| a.to_degrees() + 0.0);
    let mut turned = angles;
    let is_plain = {
        let again = DAffine3::from_scale_rotation_translation(scale, rotation, translation);
        again.abs_diff_eq(item.placement, 1e-9 * (1.0 + scale.length()))
    };
    let mut changed = false;
    Grid::new("placement").num_columns(2).show(ui, |ui| {
        let speed = speed(&desk.app.document);
        changed |= vector(ui, desk.say("Position"), &mut translation, speed);
        if is_plain {
            changed |= vector(ui, desk.say("Rotation °"), &mut turned, 0.5);
            changed |= vector(ui, desk.say("Scale"), &mut scale, 0.01);
        }
    });
    if ui.button(desk.say("Back to where it was made")).clicked() {
        desk.edit(Edit::SetPlacement(item.id, DAffine3::IDENTITY));
    }
    if !changed {
        return;
    }
    let placement = match is_plain {
        false => DAffine3 {
            translation,
            ..item.placement
        },
        true => {
            let t = turned.map(f64::to_radians);
            let q = match turned == angles {
                true => rotation,
                false => DQuat::from_euler(EulerRot::XYZ, t.x, t.y, t.z),
            };
            DAffine3::from_scale_rotation_translation(scale, q, translation)
        }
    };
    desk.edit(Edit::SetPlacement(item.id, placement));
}

/// Materials of what is selected, and what else it could be made of.
fn assign(ui: &mut Ui, desk: &mut PanelContext) {
    let app = desk.app;
    let document = &app.document;
    let selection = &app.selection;
    let mut used: Vec<MaterialId> = Vec::new();
    for id in &selection.ids {
        if let Some(item) = document.item(*id) {
            used.extend(item.materials());
        }
    }
    used.sort_unstable();
    used.dedup();
    if used.is_empty() && selection.faces.is_none() {
        return;
    }
    ui.label(desk.say("Materials"));
    for &material in used.iter().take(20) {
        let is_it = selection.material == Some(material);
        if ui
            .selectable_label(is_it, named(document, material))
            .clicked()
        {
            let mut selection = selection.clone();
            selection.material = Some(material);
            desk.wish(Command::Select(selection));
        }
    }
    let what = match &selection.faces {
        Some((_, faces)) => format!("{} {}", faces.len(), desk.say("faces get")),
        None => desk.say("Made of").to_owned(),
    };
    let mut chosen = None;
    egui::ComboBox::new("assign", what)
        .selected_text(match used[..] {
            [one] => named(document, one),
            _ => desk.say("several").to_owned(),
        })
        .show_ui(ui, |ui| {
            for k in 0..document.materials.len() as MaterialId {
                if ui
                    .selectable_label(used == [k], named(document, k))
                    .clicked()
                {
                    chosen = Some(k);
                }
            }
        });
    if let Some(material) = chosen {
        desk.edit(match &selection.faces {
            Some((id, faces)) => Edit::AssignFaces(*id, faces.clone(), material),
            None => Edit::Assign(selection.ids.clone(), material),
        });
        desk.wish(Command::Select(Selection {
            material: Some(material),
            ..selection.clone()
        }));
    }
}

/// The name of a material, or its number.
pub fn named(document: &SceneDocument, material: MaterialId) -> String {
    match document.materials.get(material as usize) {
        Some(m) if !m.name.is_empty() => m.name.clone(),
        _ => format!("#{material}"),
    }
}

/// A unit with what it is of.
fn unit(units: Units, radiometric: &'static str, photometric: &'static str) -> &'static str {
    match units.photometric {
        true => photometric,
        false => radiometric,
    }
}

/// A row with strength and colour of a light; colours are relative to their brightest channel.
fn light_color(
    ui: &mut Ui,
    desk: &PanelContext,
    lamp: ItemId,
    name: &str,
    unit: &str,
    light: &mut Rgb,
) -> bool {
    let last = egui::Id::unique(("hue", lamp));
    let (mut strength, mut hue) = inputs::parts(ui, last, *light);
    let old = (strength, hue);
    ui.label(name);
    ui.horizontal(|ui| {
        inputs::picked(ui, desk.say("Its colour"), &mut hue, inputs::hue);
        let speed = (0.01 * strength).max(0.01);
        let drag = inputs::number(&mut strength, 0.0..=1e12)
            .speed(speed)
            .suffix(format!(" {unit}"));
        ui.add(drag).accessible_name(name);
    });
    ui.end_row();
    if (strength, hue) == old {
        return false;
    }
    inputs::keep_hue(ui, last, hue);
    let new = hue * strength;
    // The colour of a light that is off is remembered, and no change of it.
    let changed = new != *light;
    *light = new;
    changed
}

fn lamp_numbers(ui: &mut Ui, desk: &mut PanelContext, lamp: &SceneLight) {
    name(ui, desk, lamp.id, &lamp.light.name);
    let mut light = lamp.light.clone();
    let units = desk.app.document.units;
    let step = speed(&desk.app.document);
    let mut changed = false;
    Grid::new("light")
        .num_columns(2)
        .show(ui, |ui| match &mut light.kind {
            LightKind::Point {
                position,
                intensity,
            } => {
                changed |= vector(ui, desk.say("Position"), position, step);
                let (name, unit) = (desk.say("Intensity"), unit(units, "W/sr", "cd"));
                changed |= light_color(ui, desk, lamp.id, name, unit, intensity);
            }
            LightKind::Spot {
                position,
                direction,
                intensity,
                inner,
                outer,
            } => {
                changed |= vector(ui, desk.say("Position"), position, step);
                changed |= unit_vector(ui, desk.say("Direction"), direction);
                let (name, unit) = (desk.say("Intensity"), unit(units, "W/sr", "cd"));
                changed |= light_color(ui, desk, lamp.id, name, unit, intensity);
                changed |= cone(ui, desk, inner, outer);
            }
            LightKind::Directional {
                direction,
                irradiance,
            } => {
                changed |= unit_vector(ui, desk.say("Direction"), direction);
                let (name, unit) = (desk.say("Irradiance"), unit(units, "W/m²", "lx"));
                changed |= light_color(ui, desk, lamp.id, name, unit, irradiance);
            }
            LightKind::Ambient { radiance } => {
                let (name, unit) = (desk.say("Radiance"), unit(units, "W/(sr·m²)", "cd/m²"));
                changed |= light_color(ui, desk, lamp.id, name, unit, radiance);
            }
        });
    ui.weak(attenuation(&light, desk));
    if changed {
        desk.edit(Edit::SetLight(lamp.id, light));
    }
}

/// How the light falls off, which is a matter of physics and not of taste.
fn attenuation(light: &Light, desk: &PanelContext) -> &'static str {
    match light.kind {
        LightKind::Point { .. } | LightKind::Spot { .. } => {
            desk.say("Falls with the square of the distance.")
        }
        LightKind::Directional { .. } => desk.say("The same at any distance."),
        LightKind::Ambient { .. } => desk.say("The same from everywhere."),
    }
}

/// A direction; numbers that have none are not taken.
fn unit_vector(ui: &mut Ui, name: &str, direction: &mut DVec3) -> bool {
    let mut typed = *direction;
    if !vector(ui, name, &mut typed, 0.01) {
        return false;
    }
    match typed.try_normalize() {
        Some(unit) => {
            *direction = unit;
            true
        }
        None => false,
    }
}

fn cone(ui: &mut Ui, desk: &PanelContext, inner: &mut f64, outer: &mut f64) -> bool {
    let mut degrees = [inner.to_degrees(), outer.to_degrees()];
    let names = [desk.say("Full inside"), desk.say("None outside")];
    let mut changed = false;
    for k in 0..2 {
        let label = ui.label(names[k]);
        let drag = inputs::number(&mut degrees[k], 0.0..=180.0)
            .speed(0.25)
            .suffix("°");
        if ui.add(drag).labelled_by(label.id).changed() {
            changed = true;
            // The one that is moved pushes the other.
            match k {
                0 => degrees[1] = degrees[1].max(degrees[0]),
                _ => degrees[0] = degrees[0].min(degrees[1]),
            }
        }
        ui.end_row();
    }
    if changed {
        (*inner, *outer) = (degrees[0].to_radians(), degrees[1].to_radians());
    }
    changed
}

fn camera_numbers(ui: &mut Ui, desk: &mut PanelContext, view: &SceneCamera) {
    name(ui, desk, view.id, &view.camera.name);
    let mut camera = view.camera.clone();
    let step = speed(&desk.app.document);
    let mut changed = false;
    Grid::new("camera").num_columns(2).show(ui, |ui| {
        changed |= vector(ui, desk.say("Eye"), &mut camera.eye, step);
        changed |= vector(ui, desk.say("Looks at"), &mut camera.target, step);
        changed |= vector(ui, desk.say("Up"), &mut camera.up, 0.01);
        let label = ui.label(desk.say("Field of view"));
        let mut degrees = camera.vertical_fov.to_degrees();
        let drag = inputs::number(&mut degrees, 1.0..=170.0)
            .speed(0.25)
            .suffix("°");
        if ui.add(drag).labelled_by(label.id).changed() {
            camera.vertical_fov = degrees.to_radians();
            changed = true;
        }
        ui.end_row();
    });
    ui.horizontal(|ui| {
        if ui.button(desk.say("Look through it")).clicked() {
            let mut look = desk.app.view.clone();
            look.camera = view.camera.clone();
            desk.wish(Command::SetView(Box::new(look)));
        }
        if ui.button(desk.say("Take the view's place")).clicked() {
            camera = Camera {
                name: view.camera.name.clone(),
                size: view.camera.size,
                ..desk.app.view.camera.clone()
            };
            changed = true;
        }
    });
    if changed {
        desk.edit(Edit::SetCamera(view.id, camera));
    }
}
