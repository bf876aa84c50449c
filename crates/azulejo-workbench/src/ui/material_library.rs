//! The library of the Material tab: pictures of materials that the selection gets, or that are
//! added to the scene.

use super::brdf::SpherePictures;
use super::panel_context::PanelContext;
use crate::app::App;
use crate::command::{Command, Selection};
use crate::document::{Edit, SceneObject};
use crate::library::{LIBRARY, LibraryMaterial};
use crate::words::Language;
use azulejo::scene::{Material, MaterialId, Shape};
use egui::{Align2, CollapsingHeader, Color32, FontId, Rect, RichText, Sense, Ui, pos2, vec2};

/// Side of a picture in points.
const SIDE: f32 = 76.0;
/// Width of a cell, and height of the name below its picture.
const WIDTH: f32 = 92.0;
const NAME_HEIGHT: f32 = 30.0;

/// What a click on a picture means.
enum Choice {
    Replace(&'static LibraryMaterial),
    Add(&'static LibraryMaterial),
}

/// Draws the section; `gesture` makes all edits of a click one undo step. Returns whether there
/// was one. Without a selected material, a click adds to the scene.
pub fn show(
    ui: &mut Ui,
    cx: &mut PanelContext,
    pictures: &mut SpherePictures,
    material: Option<MaterialId>,
    gesture: u64,
) -> bool {
    let title = RichText::new(cx.tr("Library")).strong();
    let header = CollapsingHeader::new(title)
        // Open where there is nothing else to see, whatever was chosen beside an editor.
        .id_salt(("material library", material.is_none()))
        .default_open(material.is_none());
    let shown = header.show_unindented(ui, |ui| {
        pictures.update(ui.ctx(), materials);
        grid(ui, cx, pictures)
    });
    let Some(choice) = shown.body_returned.flatten() else {
        return false;
    };
    match (choice, material) {
        (Choice::Replace(entry), Some(id)) => give(cx, entry, id, gesture),
        (Choice::Replace(entry) | Choice::Add(entry), _) => add(cx, entry, gesture),
    }
    true
}

/// The materials in the order of their pictures.
fn materials() -> Vec<Material> {
    let made = LIBRARY.iter().map(|m| m.material(m.script_name()));
    made.map(Option::unwrap_or_default).collect()
}

fn grid(ui: &mut Ui, cx: &PanelContext, pictures: &SpherePictures) -> Option<Choice> {
    let mut choice = None;
    let columns = (ui.available_width() / WIDTH).floor().max(1.0) as usize;
    let entries: Vec<(usize, &'static LibraryMaterial)> = LIBRARY.iter().enumerate().collect();
    for line in entries.chunks(columns) {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 0.0;
            for &(index, entry) in line {
                choice = cell(ui, cx, pictures, index, entry).or(choice.take());
            }
        });
    }
    choice
}

/// A picture with its name, and a button that adds the material to the scene.
fn cell(
    ui: &mut Ui,
    cx: &PanelContext,
    pictures: &SpherePictures,
    index: usize,
    entry: &'static LibraryMaterial,
) -> Option<Choice> {
    let name = (entry.title)(cx.language);
    let size = vec2(WIDTH, SIDE + NAME_HEIGHT);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let response = response.on_hover_text(cx.tr(
        "Gives the selection this material; other objects keep theirs, and what is emitted stays. Without a selection, it is added to the scene.",
    ));
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, name));
    let left = rect.center().x - 0.5 * SIDE;
    let square = Rect::from_min_size(pos2(left, rect.top()), vec2(SIDE, SIDE));
    picture(ui, pictures, index, square);
    if response.hovered() || response.has_focus() {
        let stroke = ui.visuals().selection.stroke;
        ui.painter()
            .rect_stroke(square, 4.0, stroke, egui::StrokeKind::Inside);
    }
    label(ui, name, Rect::from_min_max(square.left_bottom(), rect.max));
    let corner = square.right_top() + vec2(-21.0, 3.0);
    let about = cx.tr("Add to the scene");
    let button = ui.put(
        Rect::from_min_size(corner, vec2(18.0, 18.0)),
        egui::Button::new("+").small(),
    );
    let button = button
        .on_hover_text(cx.tr("Adds it as a new material and assigns it to the selected objects."));
    let words = format!("{about}: {name}");
    button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, words.clone()));
    if button.clicked() {
        return Some(Choice::Add(entry));
    }
    response.clicked().then_some(Choice::Replace(entry))
}

fn picture(ui: &Ui, pictures: &SpherePictures, index: usize, square: Rect) {
    let painter = ui.painter();
    match pictures.of(index) {
        Some(texture) => {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            painter.image(texture.id(), square, whole, Color32::WHITE);
        }
        None => {
            let fill = ui.visuals().widgets.inactive.bg_fill;
            painter.circle_filled(square.center(), 0.4 * SIDE, fill);
        }
    }
}

/// A name in at most two lines.
fn label(ui: &Ui, name: &str, rect: Rect) {
    let color = ui.visuals().text_color();
    let font = FontId::proportional(12.0);
    let galley = ui
        .painter()
        .layout(name.to_owned(), font, color, WIDTH - 8.0);
    let middle = Align2::CENTER_TOP.anchor_size(
        pos2(rect.left() + 0.5 * SIDE, rect.top() + 1.0),
        galley.size(),
    );
    ui.painter().galley(middle.min, galley, color);
}

/// Gives the selection a material in place of `id`: by changing that one, or as one of its own if other
/// objects have it, too.
fn give(cx: &mut PanelContext, entry: &LibraryMaterial, id: MaterialId, gesture: u64) {
    for command in giving(cx.app, entry, id, cx.language) {
        let command = match command {
            Command::Edit(edit, _) => Command::Edit(edit, Some(gesture)),
            other => other,
        };
        cx.send(command);
    }
}

/// The commands that give the selection a material of the library in place of `id`; none if it has no
/// such material.
pub fn giving(
    app: &App,
    entry: &LibraryMaterial,
    id: MaterialId,
    language: Language,
) -> Vec<Command> {
    if !is_used_elsewhere(app, id) {
        let edit = replacing(app, entry, id, language);
        return edit.map(|e| Command::Edit(e, None)).into_iter().collect();
    }
    let (document, selection) = (&app.document, &app.selection);
    let old = document.materials.get(id as usize);
    let Some(mut new) = old.and_then(|old| entry.replacing(old, language)) else {
        return Vec::new();
    };
    new.name = document.unique_material_name(&new.name);
    let number = document.materials.len() as MaterialId;
    let mut edits = vec![Edit::AddMaterial(new)];
    match &selection.faces {
        Some((item, faces)) => edits.push(Edit::AssignFaces(*item, faces.clone(), number)),
        None => {
            let objects = selection.ids.iter().filter_map(|&i| document.object(i));
            edits.extend(objects.filter_map(|object| instead(object, id, number)));
        }
    }
    let select = Command::Select(Selection {
        material: Some(number),
        ..selection.clone()
    });
    let edits = edits.into_iter().map(|edit| Command::Edit(edit, None));
    edits.chain([select]).collect()
}

/// Whether anything but the selected objects, or anything but the selected faces, has a material.
fn is_used_elsewhere(app: &App, id: MaterialId) -> bool {
    let (document, selection) = (&app.document, &app.selection);
    if let Some((item, faces)) = &selection.faces {
        let others = document.objects.iter().filter(|o| o.id != *item);
        let own = document.object(*item).map_or(0, |o| faces_of(o, id).len());
        let chosen = faces.len();
        return own > chosen || others.into_iter().any(|o| o.materials().contains(&id));
    }
    let is_chosen = |o: &SceneObject| selection.ids.contains(&o.id);
    let users = document
        .objects
        .iter()
        .filter(|o| o.materials().contains(&id));
    let (chosen, others): (Vec<_>, Vec<_>) = users.partition(|o| is_chosen(o));
    !chosen.is_empty() && !others.is_empty()
}

/// The faces of an object that have a material; none if it has no mesh of its own.
fn faces_of(object: &SceneObject, id: MaterialId) -> Vec<u32> {
    let Shape::Mesh(mesh) = &*object.shape else {
        return Vec::new();
    };
    let faces = mesh.face_materials.iter().enumerate();
    let own = faces.filter(|&(_, &material)| material == id);
    own.map(|(face, _)| face as u32).collect()
}

/// The edit that gives an object one material instead of another.
fn instead(object: &SceneObject, old: MaterialId, new: MaterialId) -> Option<Edit> {
    match object.materials() {
        [only] if *only == old => Some(Edit::Assign(vec![object.id], new)),
        some if some.contains(&old) => {
            Some(Edit::AssignFaces(object.id, faces_of(object, old), new))
        }
        _ => None,
    }
}

/// The edit that gives a material of the scene the reflection of one of the library.
fn replacing(
    app: &App,
    entry: &LibraryMaterial,
    id: MaterialId,
    language: Language,
) -> Option<Edit> {
    let old = app.document.materials.get(id as usize)?;
    Some(Edit::SetMaterial(id, entry.replacing(old, language)?))
}

/// Adds a material to the scene, gives it to the selected faces or objects, and selects it.
fn add(cx: &mut PanelContext, entry: &LibraryMaterial, gesture: u64) {
    let (document, selection) = (&cx.app.document, &cx.app.selection);
    let name = document.unique_material_name((entry.title)(cx.language));
    let Some(material) = entry.material(name) else {
        return;
    };
    let id = document.materials.len() as MaterialId;
    let objects = selection.ids.iter().copied();
    let objects: Vec<_> = objects.filter(|&i| document.object(i).is_some()).collect();
    let assign = match &selection.faces {
        Some((item, faces)) => Some(Edit::AssignFaces(*item, faces.clone(), id)),
        None => (!objects.is_empty()).then_some(Edit::Assign(objects, id)),
    };
    let select = Command::Select(Selection {
        material: Some(id),
        ..selection.clone()
    });
    cx.send(Command::Edit(Edit::AddMaterial(material), Some(gesture)));
    if let Some(edit) = assign {
        cx.send(Command::Edit(edit, Some(gesture)));
    }
    cx.send(select);
}
