//! Shapes: their geometry, and its conversion to an object.

use super::appearance::ShapeAppearance;
use super::builder::{VrmlPlacement, VrmlSceneBuilder};
use super::faces::{Binding, BoundPool, FaceSet, box_mapping, build};
use super::tree::{FieldValue, VrmlNode, limited, triples};
use super::{elevation, extrusion, flat, solids, triangles};
use crate::ReadError;
use azulejo_scene::{MaterialId, Mesh, Rgb, Sidedness};
use glam::{DVec2, DVec3};
use std::borrow::Cow;
use std::rc::Rc;

/// Polygons with their attributes, before they are assembled into a mesh.
#[derive(Debug)]
pub(super) struct SurfaceFields<'n> {
    /// The pool of vertices.
    pub positions: Vec<DVec3>,
    /// Corners; −1 ends a face.
    pub coord_index: Cow<'n, [i32]>,
    pub colors: Option<ValuePool<'n, Rgb>>,
    pub normals: Option<ValuePool<'n, DVec3>>,
    pub uvs: Option<ValuePool<'n, DVec2>>,
    /// Whether corners are counter-clockwise as seen from the front.
    pub ccw: bool,
    /// Whether the back is never visible.
    pub solid: bool,
    /// What the field `solid` says, if it is there.
    pub sidedness: Sidedness,
    /// Greatest angle between faces that are smoothed across their common edge, radians.
    pub crease_angle: f64,
    /// Whether other surfaces share the pool.
    pub is_shared: bool,
}

/// Values and their binding.
#[derive(Debug)]
pub(super) struct ValuePool<'n, T> {
    pub values: Vec<T>,
    /// Absent or empty: vertices use the index of the positions, faces their order.
    pub index: Option<Cow<'n, [i32]>>,
    pub binding: Binding,
}

impl<T> ValuePool<'_, T> {
    /// One value per vertex.
    pub fn per_vertex(values: Vec<T>) -> Self {
        ValuePool {
            values,
            index: None,
            binding: Binding::PerVertexIndexed,
        }
    }

    fn bound(&self) -> BoundPool<'_, T> {
        let index = self.index.as_deref();
        BoundPool {
            values: &self.values,
            index: index.filter(|index| !index.is_empty()),
            binding: self.binding,
        }
    }
}

impl<'n> SurfaceFields<'n> {
    /// Polygons with the node's `ccw`, `solid` and `creaseAngle`, without attributes.
    pub fn new(
        node: &VrmlNode,
        positions: Vec<DVec3>,
        coord_index: Cow<'n, [i32]>,
    ) -> SurfaceFields<'n> {
        SurfaceFields {
            positions,
            coord_index,
            colors: None,
            normals: None,
            uvs: None,
            ccw: node.flag("ccw", true),
            solid: node.flag("solid", true),
            sidedness: sidedness(node),
            crease_angle: node.number("creaseAngle", 0.0).max(0.0),
            is_shared: false,
        }
    }
}

/// What a geometry's field `solid` says. Where it is absent, TRUE is but a default that exporters
/// rely on whether or not the shape is solid.
pub(super) fn sidedness(node: &VrmlNode) -> Sidedness {
    match node.value("solid").and_then(FieldValue::flag) {
        Some(true) => Sidedness::One,
        Some(false) => Sidedness::Two,
        None => Sidedness::Unsaid,
    }
}

impl VrmlSceneBuilder<'_> {
    /// Adds a node `Shape` as an object.
    ///
    /// # Errors
    /// The model unfolds to more than the options allow.
    pub(super) fn place_shape(
        &mut self,
        shape: &VrmlNode,
        frame: &VrmlPlacement,
    ) -> Result<(), ReadError> {
        let Some(geometry) = self.child(shape, "geometry")? else {
            self.warn_node(shape, "Shape without geometry: skipped");
            return Ok(());
        };
        let frame = &frame.named(shape.name.as_deref().or(geometry.name.as_deref()));
        if let Some(solid) = solids::solid(&geometry) {
            return match self.appearance(shape)? {
                Some(shape_appearance) => {
                    solids::place(self, &geometry, &solid, frame, &shape_appearance)
                }
                None => Ok(()),
            };
        }
        let surface = match &*geometry.kind {
            "IndexedFaceSet" => Some(self.face_set(&geometry)?),
            "ElevationGrid" => elevation::surface(self, &geometry)?,
            "Extrusion" => extrusion::surface(self, &geometry)?,
            #[cfg(feature = "fonts")]
            "Text" => match self.text(&geometry)? {
                Some(letters) => Some(letters),
                // What is missing has been said.
                None => return Ok(()),
            },
            kind => match triangles::layout(kind) {
                Some(layout) => Some(triangles::surface(self, &geometry, layout)?),
                None => flat::surface(&geometry),
            },
        };
        let Some(surface) = surface else {
            self.skip(&geometry);
            return Ok(());
        };
        match self.appearance(shape)? {
            Some(shape_appearance) => {
                self.place_surface(&geometry, frame, surface, &shape_appearance)
            }
            None => Ok(()),
        }
    }

    fn face_set<'n>(&mut self, node: &'n VrmlNode) -> Result<SurfaceFields<'n>, ReadError> {
        let (positions, is_shared) = self.coordinates(node)?;
        let mut surface = SurfaceFields::new(node, positions, node.integers("coordIndex"));
        surface.is_shared = is_shared;
        let index = |name: &str| Some(node.integers(name)).filter(|i| !i.is_empty());
        self.attributes(node, &mut surface)?;
        let bind = |binding: &mut Binding, index: &Option<Cow<[i32]>>| {
            if *binding == Binding::PerFace && index.is_some() {
                *binding = Binding::PerFaceIndexed;
            }
        };
        if let Some(colors) = &mut surface.colors {
            colors.index = index("colorIndex");
            bind(&mut colors.binding, &colors.index);
        }
        if let Some(normals) = &mut surface.normals {
            normals.index = index("normalIndex");
            bind(&mut normals.binding, &normals.index);
        }
        if let Some(uvs) = &mut surface.uvs {
            uvs.index = index("texCoordIndex");
        }
        Ok(surface)
    }

    /// The positions in the field `coord`, and whether other geometries share them.
    pub(super) fn coordinates(&mut self, node: &VrmlNode) -> Result<(Vec<DVec3>, bool), ReadError> {
        let is_shared = node
            .nodes("coord")
            .first()
            .is_some_and(|c| Rc::strong_count(c) > 1);
        let Some(coord) = self.child(node, "coord")? else {
            return Ok((Vec::new(), false));
        };
        if !matches!(&*coord.kind, "Coordinate" | "CoordinateDouble") {
            self.skip(&coord);
            return Ok((Vec::new(), false));
        }
        let numbers = coord.numbers("point");
        // A large pool may serve many small geometries, and each of them scans all of it.
        self.spend(numbers.len() as u64 / 8)?;
        let mut positions = triples(&numbers);
        let mut lost = usize::from(!numbers.len().is_multiple_of(3));
        for position in positions.iter_mut().filter(|p| !p.is_finite()) {
            *position = DVec3::ZERO;
            lost += 1;
        }
        let message = "position that is not three finite numbers: 0 0 0 is used, an incomplete last one is skipped";
        self.warn_many(&coord.source, coord.at, message, lost);
        Ok((positions, is_shared))
    }

    /// Colours, normals and texture coordinates, with the bindings of most geometry nodes.
    pub(super) fn attributes(
        &mut self,
        node: &VrmlNode,
        surface: &mut SurfaceFields,
    ) -> Result<(), ReadError> {
        let binding = |name: &str| {
            if node.flag(name, true) {
                Binding::PerVertexIndexed
            } else {
                Binding::PerFace
            }
        };
        if let Some(color) = self.child(node, "color")? {
            surface.colors = self.colors(&color)?.map(|values| ValuePool {
                values,
                index: None,
                binding: binding("colorPerVertex"),
            });
        }
        if let Some(normal) = self.child(node, "normal")? {
            let numbers = normal.numbers("vector");
            self.spend(numbers.len() as u64 / 8)?;
            surface.normals = Some(ValuePool {
                values: triples(&numbers),
                index: None,
                binding: binding("normalPerVertex"),
            });
        }
        surface.uvs = self.uvs(node)?.map(ValuePool::per_vertex);
        // Fields of shaders and volumes, which azulejo does not use.
        for field in ["attrib", "fogCoord"] {
            let lost = node.nodes(field).len();
            self.warn_many(&node.source, node.at, format!("{field}: skipped"), lost);
        }
        Ok(())
    }

    fn colors(&mut self, node: &VrmlNode) -> Result<Option<Vec<Rgb>>, ReadError> {
        let numbers = node.numbers("color");
        self.spend(numbers.len() as u64 / 8)?;
        let channels = match &*node.kind {
            "Color" => 3,
            "ColorRGBA" => 4,
            _ => {
                self.skip(node);
                return Ok(None);
            }
        };
        let colors = numbers.chunks_exact(channels);
        if channels == 4 && colors.clone().any(|c| c[3] < 1.0) {
            self.warn_node(node, "colours with alpha (ColorRGBA): opaque");
        }
        let color = |c: &[f64]| limited(Rgb::new(c[0], c[1], c[2]));
        Ok(Some(colors.map(color).collect()))
    }

    /// The texture coordinates of a geometry; of several sets, the first.
    fn uvs(&mut self, node: &VrmlNode) -> Result<Option<Vec<DVec2>>, ReadError> {
        let Some(mut node) = self.child(node, "texCoord")? else {
            return Ok(None);
        };
        if &*node.kind == "MultiTextureCoordinate" {
            match self.child(&node, "texCoord")? {
                Some(first) => node = first,
                None => return Ok(None),
            }
        }
        if &*node.kind != "TextureCoordinate" {
            self.skip(&node);
            return Ok(None);
        }
        let points = node.points2("point");
        self.spend(points.len() as u64 / 4)?;
        Ok(Some(points).filter(|p| !p.is_empty()))
    }

    /// Adds polygons as an object.
    fn place_surface(
        &mut self,
        node: &VrmlNode,
        frame: &VrmlPlacement,
        mut surface: SurfaceFields,
        shape_appearance: &ShapeAppearance,
    ) -> Result<(), ReadError> {
        apply_texture_transform(&mut surface, shape_appearance);
        let set = FaceSet {
            positions: &surface.positions,
            coord_index: &surface.coord_index,
            colors: surface.colors.as_ref().map(ValuePool::bound),
            normals: surface.normals.as_ref().map(ValuePool::bound),
            uvs: surface.uvs.as_ref().map(ValuePool::bound),
            ccw: surface.ccw,
            crease_angle: surface.crease_angle,
            drop_unused: surface.is_shared,
        };
        self.spend(set.cost())?;
        let mut built = build(&set);
        for (message, count) in built.problems.messages() {
            self.warn_many(&node.source, node.at, message, count);
        }
        let pool = surface.colors.as_ref().map_or(&[][..], |c| &c.values);
        self.paint(
            &mut built.mesh,
            &built.face_values,
            pool,
            &surface,
            shape_appearance,
        );
        let placed = self.place_mesh(frame, None, (&node.source, node.at), built.mesh);
        self.report(node, placed);
        Ok(())
    }

    /// Assigns materials to the faces. `face_values` holds the index of each face's colour in `pool`,
    /// if faces have colours of their own.
    fn paint(
        &mut self,
        mesh: &mut Mesh,
        face_values: &[u32],
        pool: &[Rgb],
        surface: &SurfaceFields,
        shape_appearance: &ShapeAppearance,
    ) {
        let mut material = |color: Option<Rgb>| -> MaterialId {
            let mut material = shape_appearance.textured(color);
            material.emits_back = material.is_emitter() && !surface.solid;
            material.sidedness = surface.sidedness;
            self.materials.index(material)
        };
        if face_values.is_empty() {
            // Vertex colours replace the reflectance, but are multiplied with it here.
            let color = (!mesh.colors.is_empty()).then_some(Rgb::WHITE);
            mesh.face_materials.fill(material(color));
            return;
        }
        let mut known = vec![None; pool.len()];
        for (face, &value) in mesh.face_materials.iter_mut().zip(face_values) {
            let color = pool[value as usize];
            *face = *known[value as usize].get_or_insert_with(|| material(Some(color)));
        }
    }
}

/// Generates texture coordinates for a textured surface without any, and applies the texture
/// transform of the appearance.
fn apply_texture_transform(surface: &mut SurfaceFields, shape_appearance: &ShapeAppearance) {
    if !shape_appearance.is_pictured() {
        return;
    }
    if surface.uvs.is_none() {
        surface.uvs = Some(ValuePool::per_vertex(box_mapping(&surface.positions)));
    }
    if let (Some(map), Some(uvs)) = (shape_appearance.texture_from_uv, &mut surface.uvs) {
        for uv in &mut uvs.values {
            *uv = map.transform_point2(*uv);
        }
    }
}
