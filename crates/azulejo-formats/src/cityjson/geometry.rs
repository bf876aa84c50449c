//! Geometries: surfaces nested in shells and solids, and placed templates.

use super::appearance::CityColor;
use super::document::{CityDocument, CityHeader};
use super::objects::{CityMeshes, CityReader};
use super::rings::SurfaceRings;
use crate::ReadError;
use crate::reading::json::Json;
use azulejo_scene::MaterialId;
use glam::{DAffine3, DMat4, DVec3};
use std::borrow::Cow;

/// How many lists surround the surfaces in the boundaries of a type of geometry.
fn depth_of(kind: &str) -> Option<usize> {
    match kind {
        "MultiSurface" | "CompositeSurface" => Some(0),
        "Solid" => Some(1),
        "MultiSolid" | "CompositeSolid" => Some(2),
        _ => None,
    }
}

/// The vertices of a geometry and where they are.
struct CityVertices<'d> {
    positions: &'d [DVec3],
    /// From a template to the world.
    placement: Option<DAffine3>,
}

impl CityVertices<'_> {
    fn at(&self, vertex: u32) -> DVec3 {
        let own = self.positions[vertex as usize];
        self.placement.map_or(own, |map| map.transform_point3(own))
    }

    /// Whether the placement turns fronts to backs.
    fn is_mirrored(&self) -> bool {
        let map = self.placement;
        map.is_some_and(|map| map.matrix3.determinant() < 0.0)
    }
}

/// What belongs to the surfaces of a geometry besides their boundaries.
struct SurfaceStyle<'a, 'd> {
    /// Types of semantic surfaces, by number.
    kinds: Vec<Option<Cow<'a, str>>>,
    materials: &'d [CityColor],
    /// The material of all surfaces, if it is one.
    material: Option<usize>,
    vertices: CityVertices<'d>,
}

/// A part of the boundaries, and what belongs to it in lists of the same structure.
#[derive(Clone, Copy)]
struct BoundaryPart<'a> {
    boundary: Json<'a>,
    semantics: Option<Json<'a>>,
    material: Option<Json<'a>>,
}

impl<'a> BoundaryPart<'a> {
    /// The parts of a list.
    fn parts(self) -> impl Iterator<Item = BoundaryPart<'a>> {
        let elements = |list: Option<Json<'a>>| list.into_iter().flat_map(Json::elements);
        let mut semantics = elements(self.semantics);
        let mut materials = elements(self.material);
        self.boundary.elements().map(move |boundary| BoundaryPart {
            boundary,
            semantics: semantics.next(),
            material: materials.next(),
        })
    }
}

impl<'a> CityReader<'a> {
    /// Reads a geometry of an object into its meshes.
    ///
    /// # Errors
    /// As [`CityReader::document`].
    pub fn geometry(
        &mut self,
        meshes: &mut CityMeshes<'_>,
        document: &CityDocument<'a>,
        header: &CityHeader<'a>,
        geometry: Json<'a>,
    ) -> Result<(), ReadError> {
        if geometry.member("template").is_some() {
            return self.instance(meshes, document, header, geometry);
        }
        let vertices = CityVertices {
            positions: &document.vertices,
            placement: None,
        };
        let materials = document.materials.as_ref().unwrap_or(&header.materials);
        self.surfaces(meshes, geometry, materials, vertices)
    }

    /// A template at a place: a matrix, and then the offset to a vertex.
    fn instance(
        &mut self,
        meshes: &mut CityMeshes<'_>,
        document: &CityDocument<'a>,
        header: &CityHeader<'a>,
        geometry: Json<'a>,
    ) -> Result<(), ReadError> {
        let file = self.file;
        let number = geometry.member("template").and_then(Json::index);
        let Some(&template) = number.and_then(|k| header.templates.get(k)) else {
            let expected = format!("one of the {} templates", header.templates.len());
            return Err(file.error_with(geometry, "an instance of another template", &expected));
        };
        let anchor = geometry.member("boundaries");
        let anchor = anchor.and_then(|list| list.elements().next()?.index());
        let Some(&anchor) = anchor.and_then(|k| document.vertices.get(k)) else {
            let expected = "boundaries with the number of a vertex";
            return Err(file.error_with(geometry, "an instance without a place", expected));
        };
        let matrix = match geometry.member("transformationMatrix") {
            None => DAffine3::IDENTITY,
            Some(matrix) => affine(matrix)
                .ok_or_else(|| file.error(matrix, "16 numbers of an affine map, by rows"))?,
        };
        // Also the time to read the template once more, should it hold nothing but blanks.
        self.spend(template.geometry.get().len() as u64 / 16)?;
        meshes.begin_template();
        let vertices = CityVertices {
            positions: &header.template_vertices,
            placement: Some(DAffine3::from_translation(anchor) * matrix),
        };
        self.surfaces(meshes, template.geometry, &header.materials, vertices)
    }

    fn spend(&mut self, elements: u64) -> Result<(), ReadError> {
        let name = self.file.name;
        self.budget.spend(elements).map_err(|e| e.error(name))
    }

    fn surfaces(
        &mut self,
        meshes: &mut CityMeshes<'_>,
        geometry: Json<'a>,
        materials: &[CityColor],
        vertices: CityVertices<'_>,
    ) -> Result<(), ReadError> {
        let kind = geometry.member("type").and_then(Json::string);
        let kind = kind.unwrap_or_default();
        let Some(depth) = depth_of(&kind) else {
            let message = match &*kind {
                "MultiPoint" | "MultiLineString" => "points and lines: skipped",
                _ => "geometry of an unknown type: skipped",
            };
            self.file.warn(&mut self.warnings, geometry, message);
            return Ok(());
        };
        let Some(boundary) = geometry.member("boundaries") else {
            let message = "geometry without boundaries: skipped";
            self.file.warn(&mut self.warnings, geometry, message);
            return Ok(());
        };
        if geometry.member("texture").is_some() {
            self.file
                .warn(&mut self.warnings, geometry, "textures: skipped");
        }
        let semantics = geometry.member("semantics");
        // The first theme; the others are other looks of the same surfaces.
        let look = geometry.member("material");
        let look = look.and_then(|themes| themes.members().next());
        let look = look.map(|(_, theme)| theme);
        let kinds = semantics.and_then(|s| s.member("surfaces"));
        let kinds = kinds.into_iter().flat_map(Json::elements);
        let style = SurfaceStyle {
            kinds: kinds.map(|s| s.member("type")?.string()).collect(),
            materials,
            material: look.and_then(|look| look.member("value")?.index()),
            vertices,
        };
        let whole = BoundaryPart {
            boundary,
            semantics: semantics.and_then(|s| s.member("values")),
            material: look.and_then(|look| look.member("values")),
        };
        self.boundaries(meshes, &style, whole, depth)
    }

    /// Reads surfaces in up to two lists.
    fn boundaries(
        &mut self,
        meshes: &mut CityMeshes<'_>,
        style: &SurfaceStyle<'a, '_>,
        part: BoundaryPart<'a>,
        depth: usize,
    ) -> Result<(), ReadError> {
        for inner in part.parts() {
            match depth {
                0 => self.surface(meshes, style, inner)?,
                _ => self.boundaries(meshes, style, inner, depth - 1)?,
            }
        }
        Ok(())
    }

    fn surface(
        &mut self,
        meshes: &mut CityMeshes<'_>,
        style: &SurfaceStyle<'a, '_>,
        surface: BoundaryPart<'a>,
    ) -> Result<(), ReadError> {
        let count = style.vertices.positions.len();
        // The first ring is the outline, further ones are holes.
        let rings = SurfaceRings::read(surface.boundary, count, self.file)?;
        let mut warn = |message: &str, times: usize| {
            for _ in 0..times {
                self.file
                    .warn(&mut self.warnings, surface.boundary, message);
            }
        };
        warn(
            "hole with fewer than three corners: filled",
            rings.empty_holes,
        );
        if !rings.is_polygon() {
            warn("surface with fewer than three corners: skipped", 1);
            return Ok(());
        }
        // Vertices of the file are finite, but the placement of a template may not keep them so.
        let elements = 2 * rings.vertices.len() as u64;
        let is_placed = style.vertices.placement.is_some();
        let at = |v: u32| style.vertices.at(v);
        if is_placed && !rings.vertices.iter().all(|&v| at(v).is_finite()) {
            warn("surface whose place is not finite: skipped", 1);
            return Ok(());
        }
        self.spend(elements.max(rings.cost()))?;
        if !self.budget.keeps() {
            return Ok(());
        }
        // A face has a single loop: connect the holes to the outline.
        let (mut corners, left_out) = rings.joined(at);
        for _ in 0..left_out {
            let message = "hole outside of its surface: filled";
            self.file
                .warn(&mut self.warnings, surface.boundary, message);
        }
        if style.vertices.is_mirrored() {
            corners.reverse();
        }
        // The semantic type groups the faces, and names the material of those without a colour.
        let kind = surface.semantics.and_then(Json::index);
        let kind = kind.and_then(|k| style.kinds.get(k)?.as_deref());
        let material = self.material(meshes, style, surface, kind);
        meshes.face(kind, &corners, at, material);
        Ok(())
    }

    fn material(
        &mut self,
        meshes: &CityMeshes<'_>,
        style: &SurfaceStyle<'a, '_>,
        surface: BoundaryPart<'a>,
        kind: Option<&str>,
    ) -> MaterialId {
        let number = surface.material.and_then(Json::index).or(style.material);
        let material = number.and_then(|k| style.materials.get(k));
        let colored = material.and_then(|m| self.materials.colored(&mut self.scene, m));
        colored.unwrap_or_else(|| {
            let kind = kind.unwrap_or(&meshes.kind);
            self.materials.grey(&mut self.scene, kind)
        })
    }
}

/// A map by a matrix in rows, whose last row must be 0 0 0 1.
fn affine(matrix: Json<'_>) -> Option<DAffine3> {
    let numbers: Option<Vec<f64>> = matrix.elements().take(17).map(Json::number).collect();
    let numbers: [f64; 16] = numbers?.try_into().ok()?;
    let is_affine = numbers[12..] == [0.0, 0.0, 0.0, 1.0];
    let map = DAffine3::from_mat4(DMat4::from_cols_array(&numbers).transpose());
    (is_affine && map.is_finite()).then_some(map)
}
