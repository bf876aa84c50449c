//! City objects become objects of the scene.

use super::appearance::CityMaterials;
use super::document::{CityDocument, CityFile, CityHeader};
use super::levels::choose;
use crate::reading::json::Json;
use crate::reading::options::Budget;
use crate::reading::warnings::Warnings;
use crate::{Lod, ReadError};
use azulejo_scene::{MaterialId, Mesh, Object, Scene, Shape};
use glam::DVec3;
use std::borrow::Cow;
use std::collections::HashMap;

/// What reading collects.
pub(super) struct CityReader<'a> {
    pub file: CityFile<'a>,
    pub lod: Lod,
    pub warnings: Warnings,
    pub budget: Budget,
    pub materials: CityMaterials,
    pub scene: Scene,
}

impl<'a> CityReader<'a> {
    /// Reads all objects of a document.
    ///
    /// # Errors
    /// Vertices that do not exist, and more elements than the budget has.
    pub fn document(
        &mut self,
        document: &CityDocument<'a>,
        header: &CityHeader<'a>,
    ) -> Result<(), ReadError> {
        let (chosen, left_out) = choose(document, header, self.lod);
        let message = "object whose parts have a higher level of detail: its own left out";
        self.warnings
            .add_many(self.file.name, message.to_owned(), left_out, || {
                crate::Position::Whole
            });
        for ((id, object), geometries) in document.objects.iter().zip(chosen) {
            let kind = object.member("type").and_then(Json::string);
            let mut meshes = CityMeshes::new(id, kind.unwrap_or_default());
            for geometry in geometries.list {
                self.geometry(&mut meshes, document, header, geometry)?;
            }
            meshes.finish(&mut self.scene);
        }
        Ok(())
    }
}

/// The meshes of one city object, one for each semantic type.
pub(super) struct CityMeshes<'d> {
    id: &'d str,
    /// The type of the object, which names the material of surfaces without a semantic type.
    pub kind: Cow<'d, str>,
    numbers: HashMap<Option<String>, usize>,
    list: Vec<TypedMesh>,
    /// Number of the geometry, in which equal numbers of vertices mean equal positions.
    geometry: u32,
}

/// The surfaces of one semantic type.
struct TypedMesh {
    kind: Option<String>,
    mesh: Mesh,
    /// The vertices of the mesh by geometry and number in the file.
    vertices: HashMap<(u32, u32), u32>,
}

impl<'d> CityMeshes<'d> {
    fn new(id: &'d str, kind: Cow<'d, str>) -> CityMeshes<'d> {
        CityMeshes {
            id,
            kind,
            numbers: HashMap::new(),
            list: Vec::new(),
            geometry: 0,
        }
    }

    /// Begins a template, whose vertices are its own.
    pub fn begin_template(&mut self) {
        self.geometry += 1;
    }

    /// Adds a surface as a loop of vertices.
    pub fn face(
        &mut self,
        kind: Option<&str>,
        corners: &[u32],
        position: impl Fn(u32) -> DVec3,
        material: MaterialId,
    ) {
        let kind = kind.map(str::to_owned);
        let next = self.list.len();
        let number = *self.numbers.entry(kind.clone()).or_insert(next);
        if number == next {
            self.list.push(TypedMesh {
                kind,
                mesh: Mesh::default(),
                vertices: HashMap::new(),
            });
        }
        let TypedMesh { mesh, vertices, .. } = &mut self.list[number];
        let geometry = self.geometry;
        let vertex = |&corner: &u32| {
            let next = mesh.positions.len() as u32;
            *vertices.entry((geometry, corner)).or_insert_with(|| {
                mesh.positions.push(position(corner));
                next
            })
        };
        let corners: Vec<u32> = corners.iter().map(vertex).collect();
        mesh.push_face(&corners, material);
    }

    /// Adds the objects to the scene: "id type", or the identifier alone.
    fn finish(self, scene: &mut Scene) {
        for typed in self.list {
            let name = match typed.kind {
                Some(kind) => format!("{} {kind}", self.id),
                None => self.id.to_owned(),
            };
            scene
                .objects
                .push(Object::new(name, Shape::Mesh(typed.mesh)));
        }
    }
}
