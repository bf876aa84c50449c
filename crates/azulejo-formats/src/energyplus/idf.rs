//! IDF: objects of comma-separated fields, each ended by a semicolon.

use super::classes::{ClassLayout, InputClass, InputVersion, class};
use super::input::{InputObject, InputText, InputValue, is_automatic};
use crate::ReadError;
use crate::reading::warnings::Warnings;
use glam::DVec3;
use std::borrow::Cow;

/// An object whose fields have no names yet.
struct IdfRecord<'a> {
    layout: ClassLayout,
    at: usize,
    /// The fields after the class, the last ones not blank.
    fields: Vec<InputValue<'a>>,
}

/// Files that do not say their version are taken as this one.
const LATEST: InputVersion = (u32::MAX, 0);

/// Reads the objects of the known classes.
///
/// # Errors
/// Coordinates that are not numbers.
pub(super) fn read<'a>(
    file: InputText<'a>,
    warnings: &mut Warnings,
) -> Result<Vec<InputObject<'a>>, ReadError> {
    let records = records(file, warnings);
    let version = records.iter().find_map(version);
    let records = records.into_iter();
    records
        .map(|record| object(record, version, file, warnings))
        .collect()
}

fn version(record: &IdfRecord<'_>) -> Option<InputVersion> {
    if record.layout.class != InputClass::Version {
        return None;
    }
    let mut numbers = record.fields.first()?.text.split('.');
    let major = numbers.next()?.trim().parse().ok()?;
    let minor = numbers.next().and_then(|n| n.trim().parse().ok());
    Some((major, minor.unwrap_or(0)))
}

/// All objects of the known classes.
fn records<'a>(file: InputText<'a>, warnings: &mut Warnings) -> Vec<IdfRecord<'a>> {
    let mut inputs = Vec::new();
    let mut fields = IdfFields {
        text: file.text,
        at: 0,
        macros: None,
    };
    while let Some((class_name, mut end)) = fields.next() {
        let layout = class(&class_name.text);
        let at = class_name.at;
        let mut values = Vec::new();
        while end == Some(b',') {
            let Some((value, next)) = fields.next() else {
                end = None;
                break;
            };
            if layout.is_some() {
                values.push(value);
            }
            end = next;
        }
        if end.is_none() {
            let message = "the file ends inside an object: skipped";
            file.warn(warnings, at, message);
            break;
        }
        while values.last().is_some_and(|v| v.text.is_empty()) {
            values.pop();
        }
        inputs.extend(layout.map(|layout| IdfRecord {
            layout,
            at,
            fields: values,
        }));
    }
    if let Some(at) = fields.macros {
        let message = "macro commands (##): skipped; EnergyPlus expands them beforehand";
        file.warn(warnings, at, message);
    }
    inputs
}

/// The fields of a file one after another.
struct IdfFields<'a> {
    text: &'a str,
    at: usize,
    /// The first line that is a macro command.
    macros: Option<usize>,
}

impl<'a> IdfFields<'a> {
    /// The next field and what ends it; `None` at the end of the file, unless text precedes it.
    fn next(&mut self) -> Option<(InputValue<'a>, Option<u8>)> {
        let mut value = InputValue {
            text: Cow::Borrowed(""),
            at: self.at,
        };
        loop {
            let rest = &self.text[self.at..];
            let length = rest.find([',', ';', '!', '\n', '\r']);
            let piece = &rest[..length.unwrap_or(rest.len())];
            let end = length.map(|length| rest.as_bytes()[length]);
            self.append(&mut value, piece);
            self.at += piece.len() + usize::from(end.is_some());
            match end {
                Some(b',' | b';') => return Some((value, end)),
                Some(b'!') => self.skip_line(),
                Some(_) => {}
                None if value.text.is_empty() => return None,
                None => return Some((value, None)),
            }
        }
    }

    /// Appends what a line has of a field.
    fn append(&mut self, value: &mut InputValue<'a>, piece: &'a str) {
        let bare = piece.trim();
        if bare.starts_with("##") {
            self.macros.get_or_insert(self.at);
            return;
        }
        match (bare, value.text.is_empty()) {
            ("", _) => {}
            (_, true) => {
                let before = piece.len() - piece.trim_start().len();
                value.at = self.at + before;
                value.text = Cow::Borrowed(bare);
            }
            _ => {
                let text = value.text.to_mut();
                text.push(' ');
                text.push_str(bare);
            }
        }
    }

    fn skip_line(&mut self) {
        let rest = &self.text[self.at..];
        self.at += rest.find(['\n', '\r']).unwrap_or(rest.len());
    }
}

/// Gives the fields of a record their names, and separates the vertices.
fn object<'a>(
    record: IdfRecord<'a>,
    version: Option<InputVersion>,
    file: InputText<'a>,
    warnings: &mut Warnings,
) -> Result<InputObject<'a>, ReadError> {
    let names = names(&record, version);
    let mut fields = record.fields.into_iter();
    // Only these two classes have objects without a name.
    let is_nameless = matches!(record.layout.class, InputClass::Version | InputClass::Rules);
    let name = if is_nameless {
        Cow::Borrowed("")
    } else {
        fields.next().unwrap_or_default().text
    };
    let mut object = InputObject {
        layout: record.layout,
        at: record.at,
        name,
        fields: Vec::new(),
        vertices: Vec::new(),
    };
    let named = names.into_iter().zip(fields.by_ref());
    let named = named.filter(|(_, value)| !value.text.is_empty());
    object.fields = named.collect();
    if record.layout.has_vertices() {
        let coordinates: Vec<_> = fields.collect();
        object.vertices = vertices(&object, &coordinates, file, warnings)?;
    }
    Ok(object)
}

/// The vertices of an object: as many as it says, if it says so.
fn vertices(
    object: &InputObject<'_>,
    coordinates: &[InputValue<'_>],
    file: InputText<'_>,
    warnings: &mut Warnings,
) -> Result<Vec<DVec3>, ReadError> {
    let stated = object.text("number_of_vertices").parse::<f64>().ok();
    let stated = stated.filter(|n| *n >= 0.0).map(|n| n as usize);
    let (whole, rest) = coordinates.as_chunks::<3>();
    let count = stated.unwrap_or(whole.len());
    if count != whole.len() || !rest.is_empty() {
        let message = "surface with another number of vertices than it says: all are read";
        file.warn(warnings, object.at, message);
    }
    if let Some(value) = rest.first() {
        return Err(file.error(value.at, "the coordinates of half a vertex", "x, y and z"));
    }
    let vertex = |point: &[InputValue<'_>; 3]| {
        let [x, y, z] = point;
        let number = |value: &InputValue<'_>| value.number(file, "a coordinate");
        Ok(DVec3::new(number(x)?, number(y)?, number(z)?))
    };
    whole.iter().map(vertex).collect()
}

/// The names of the fields behind that of the object: those of the file's version or, where vertices
/// contradict it or nothing says which it is, those of the version that suits.
fn names(record: &IdfRecord<'_>, version: Option<InputVersion>) -> Vec<&'static str> {
    let layout = record.layout;
    let by_version = layout.fields(version.unwrap_or(LATEST));
    let others = [LATEST, (9, 0), (8, 9)].map(|v| layout.fields(v));
    let suits = |names: &Vec<&'static str>| {
        if layout.has_vertices() {
            vertices_suit(record, names.len())
        } else {
            version.is_some() || record.fields.len() == names.len() + 1
        }
    };
    if suits(&by_version) {
        return by_version;
    }
    let mut others = others.into_iter();
    others.find(suits).unwrap_or(by_version)
}

/// Whether the number of vertices, the last of `fields` fields after the name, is that of the
/// coordinates behind it.
fn vertices_suit(record: &IdfRecord<'_>, fields: usize) -> bool {
    let Some(stated) = record.fields.get(fields) else {
        return false;
    };
    let coordinates = record.fields.len() - fields - 1;
    let is_stated = stated.text.parse() == Ok(coordinates as f64 / 3.0);
    let is_open = stated.text.is_empty() || is_automatic(&stated.text);
    coordinates.is_multiple_of(3) && (is_stated || is_open)
}
