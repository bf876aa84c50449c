//! epJSON: the same objects with names for their fields.

use super::classes::{ClassLayout, InputClass, class};
use super::input::{InputObject, InputText, InputValue};
use crate::ReadError;
use crate::reading::json::{self, Json};
use glam::DVec3;
use std::borrow::Cow;

/// Reads the objects of the known classes.
///
/// # Errors
/// Malformed JSON, and coordinates that are not numbers.
pub(super) fn read<'a>(file: InputText<'a>) -> Result<Vec<InputObject<'a>>, ReadError> {
    let values = json::values(file.text, file.name)?;
    let mut inputs = Vec::new();
    for (class_name, objects) in values[0].members() {
        let Some(layout) = class(&class_name) else {
            continue;
        };
        for (name, object) in objects.members() {
            inputs.push(read_object(layout, name, object, file)?);
        }
    }
    Ok(inputs)
}

fn read_object<'a>(
    layout: ClassLayout,
    name: Cow<'a, str>,
    value: Json<'a>,
    file: InputText<'a>,
) -> Result<InputObject<'a>, ReadError> {
    let mut object = InputObject {
        layout,
        at: value.at(),
        name,
        fields: Vec::new(),
        vertices: Vec::new(),
    };
    // Up to four corners of openings have fields of their own.
    let mut corners: [[Option<InputValue<'a>>; 3]; 4] = Default::default();
    for (field, member) in value.members() {
        if field == "vertices" && layout.has_vertices() {
            object.vertices = vertices(member, file)?;
        } else if let Some((corner, axis)) = corner_of(&field)
            && layout.class == InputClass::Opening
        {
            corners[corner][axis] = scalar(member);
        } else if let Some(known) = layout.field(&field)
            && let Some(value) = scalar(member)
        {
            object.fields.push((known, value));
        }
    }
    for corner in &corners {
        if corner.iter().any(Option::is_some) {
            object.vertices.push(point(corner, value, file)?);
        }
    }
    Ok(object)
}

/// The text of a number or a string that is not blank.
fn scalar(value: Json<'_>) -> Option<InputValue<'_>> {
    let text = value.string().unwrap_or(Cow::Borrowed(value.get()));
    let text = match text {
        Cow::Borrowed(text) => Cow::Borrowed(text.trim()),
        Cow::Owned(text) => Cow::Owned(text.trim().to_owned()),
    };
    let at = value.at();
    (!text.is_empty()).then_some(InputValue { text, at })
}

/// Corner and axis of a field like `vertex_1_x_coordinate`.
fn corner_of(field: &str) -> Option<(usize, usize)> {
    let inner = field.strip_prefix("vertex_")?.strip_suffix("_coordinate")?;
    let (number, axis) = inner.split_once('_')?;
    let corner = number.parse::<usize>().ok()?.checked_sub(1)?;
    let axis = ["x", "y", "z"].iter().position(|a| *a == axis)?;
    (corner < 4).then_some((corner, axis))
}

fn vertices(list: Json<'_>, file: InputText<'_>) -> Result<Vec<DVec3>, ReadError> {
    let vertex = |vertex: Json<'_>| {
        let mut coordinates = [None, None, None];
        for (name, value) in vertex.members() {
            let axes = [
                "vertex_x_coordinate",
                "vertex_y_coordinate",
                "vertex_z_coordinate",
            ];
            if let Some(axis) = axes.iter().position(|axis| *axis == name) {
                coordinates[axis] = scalar(value);
            }
        }
        point(&coordinates, vertex, file)
    };
    list.elements().map(vertex).collect()
}

fn point(
    coordinates: &[Option<InputValue<'_>>; 3],
    vertex: Json<'_>,
    file: InputText<'_>,
) -> Result<DVec3, ReadError> {
    let number = |value: &Option<InputValue<'_>>| match value {
        Some(value) => value.number(file, "a coordinate"),
        None => Err(file.error(vertex.at(), "a vertex without x, y or z", "a coordinate")),
    };
    let [x, y, z] = coordinates;
    Ok(DVec3::new(number(x)?, number(y)?, number(z)?))
}
