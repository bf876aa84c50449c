//! The parts of a document: vertices, templates, materials, and the city objects as they are.

use super::appearance::CityColor;
use super::levels::own_level;
use crate::ReadError;
use crate::reading::cursor::{TextCursor, position};
use crate::reading::json::Json;
use crate::reading::warnings::Warnings;
use glam::DVec3;
use std::borrow::Cow;

/// The text of a file, for messages with positions.
#[derive(Clone, Copy)]
pub(super) struct CityFile<'a> {
    pub text: &'a str,
    /// The name of the file.
    pub name: &'a str,
}

impl CityFile<'_> {
    /// An error about a value.
    #[cold]
    pub fn error(&self, value: Json<'_>, expected: &str) -> ReadError {
        let found = match value.get() {
            long if long.len() > 40 => "another value".to_owned(),
            short => short.to_owned(),
        };
        self.error_with(value, found, expected)
    }

    /// An error about a value, with the caller's description of it.
    #[cold]
    pub fn error_with(
        &self,
        value: Json<'_>,
        found: impl Into<String>,
        expected: &str,
    ) -> ReadError {
        let cursor = TextCursor::<[u8]>::new(self.text.as_bytes());
        cursor.error(self.name, value.at(), found, expected)
    }

    /// Counts a warning about a value.
    pub fn warn(&self, warnings: &mut Warnings, value: Json<'_>, message: impl Into<String>) {
        warnings.add(self.name, message.into(), || {
            position(self.text.as_bytes(), value.at())
        });
    }
}

/// What all documents of a sequence share.
pub(super) struct CityHeader<'a> {
    scale: DVec3,
    translate: DVec3,
    /// The materials of features that have none of their own.
    pub materials: Vec<CityColor>,
    /// Geometries to be placed several times, and their vertices.
    pub templates: Vec<CityTemplate<'a>>,
    pub template_vertices: Vec<DVec3>,
}

/// A geometry to be placed several times.
#[derive(Clone, Copy)]
pub(super) struct CityTemplate<'a> {
    pub geometry: Json<'a>,
    /// Its level of detail.
    pub level: Option<f64>,
}

/// A model, or a feature of a sequence.
pub(super) struct CityDocument<'a> {
    /// The city objects with their identifiers.
    pub objects: Vec<(Cow<'a, str>, Json<'a>)>,
    /// Positions of the vertices.
    pub vertices: Vec<DVec3>,
    /// The materials that its geometries number, if they are not those of the header.
    pub materials: Option<Vec<CityColor>>,
}

impl<'a> CityHeader<'a> {
    /// Reads what precedes the objects, wherever it stands.
    ///
    /// # Errors
    /// Another type of document; a transform or vertices that are not numbers.
    pub fn read(
        value: Json<'a>,
        file: CityFile<'a>,
        warnings: &mut Warnings,
    ) -> Result<CityHeader<'a>, ReadError> {
        let mut header = CityHeader {
            scale: DVec3::ONE,
            translate: DVec3::ZERO,
            materials: Vec::new(),
            templates: Vec::new(),
            template_vertices: Vec::new(),
        };
        let is = |kind: Json<'_>| kind.string().as_deref() == Some("CityJSON");
        if !value.member("type").is_some_and(is) {
            let expected = "an object whose \"type\" is \"CityJSON\"";
            return Err(file.error(value, expected));
        }
        for (name, member) in value.members() {
            match &*name {
                "version" => version(member, file, warnings),
                "transform" => header.transform(member, file)?,
                "appearance" => header.materials = materials(member),
                "geometry-templates" => header.templates(member, file)?,
                _ => {}
            }
        }
        Ok(header)
    }

    fn transform(&mut self, value: Json<'a>, file: CityFile<'a>) -> Result<(), ReadError> {
        for (name, member) in value.members() {
            let target = match &*name {
                "scale" => &mut self.scale,
                "translate" => &mut self.translate,
                _ => continue,
            };
            let numbers = member.triple();
            *target = numbers
                .ok_or_else(|| file.error(member, "three numbers"))?
                .into();
        }
        Ok(())
    }

    fn templates(&mut self, value: Json<'a>, file: CityFile<'a>) -> Result<(), ReadError> {
        for (name, member) in value.members() {
            match &*name {
                "templates" => self.templates = member.elements().map(template).collect(),
                "vertices-templates" => {
                    self.template_vertices = positions(member, file, |p| p)?;
                }
                _ => {}
            }
        }
        Ok(())
    }
}

fn template(geometry: Json<'_>) -> CityTemplate<'_> {
    let level = own_level(geometry);
    CityTemplate { geometry, level }
}

/// Versions before 1.0 had other names for types and members.
fn version(value: Json<'_>, file: CityFile<'_>, warnings: &mut Warnings) {
    let version = value.string().unwrap_or_default();
    if !matches!(version.split('.').next(), Some("1" | "2")) {
        let message = "version that is not 1.0, 1.1 or 2.0: read as 2.0";
        file.warn(warnings, value, message);
    }
}

fn materials(appearance: Json<'_>) -> Vec<CityColor> {
    let list = appearance.member("materials");
    let list = list.into_iter().flat_map(Json::elements);
    list.map(CityColor::read).collect()
}

/// A list of positions, each mapped.
fn positions(
    list: Json<'_>,
    file: CityFile<'_>,
    map: impl Fn(DVec3) -> DVec3,
) -> Result<Vec<DVec3>, ReadError> {
    if !list.is_array() {
        return Err(file.error(list, "a list of vertices"));
    }
    let mut vertices = Vec::new();
    for vertex in list.elements() {
        let numbers = vertex.triple().map(|p| map(p.into()));
        let finite = numbers.filter(|p| p.is_finite());
        vertices.push(finite.ok_or_else(|| file.error(vertex, "three coordinates"))?);
    }
    Ok(vertices)
}

impl<'a> CityDocument<'a> {
    /// Reads the objects and vertices of a model.
    ///
    /// # Errors
    /// Vertices that are not numbers.
    pub fn read(
        value: Json<'a>,
        header: &CityHeader<'a>,
        file: CityFile<'a>,
    ) -> Result<CityDocument<'a>, ReadError> {
        let mut document = CityDocument {
            objects: Vec::new(),
            vertices: Vec::new(),
            materials: None,
        };
        for (name, member) in value.members() {
            match &*name {
                "CityObjects" => document.objects = member.members().collect(),
                "vertices" => {
                    let map = |p: DVec3| header.scale * p + header.translate;
                    document.vertices = positions(member, file, map)?;
                }
                "appearance" => document.materials = Some(materials(member)),
                _ => {}
            }
        }
        Ok(document)
    }

    /// Reads a line of a sequence after the first one.
    ///
    /// # Errors
    /// Anything but a feature, and the errors of [`CityDocument::read`].
    pub fn feature(
        value: Json<'a>,
        header: &CityHeader<'a>,
        file: CityFile<'a>,
    ) -> Result<CityDocument<'a>, ReadError> {
        let is = |kind: Json<'_>| kind.string().as_deref() == Some("CityJSONFeature");
        if !value.member("type").is_some_and(is) {
            let expected = "an object whose \"type\" is \"CityJSONFeature\"";
            return Err(file.error(value, expected));
        }
        CityDocument::read(value, header, file)
    }
}
