//! From a document to a scene: scopes, transforms, materials.

use super::document::{
    AreaLight, Block, BlockKind, Body, Column, Document, Fail, Kind, MaterialNote, MeshBlock, Name,
    Place, PrimitiveBlock,
};
use super::look::{Key, Look};
use super::materials::{REFLECTS_TOO_MUCH, Surface, surface};
use super::placement::{
    Outer, affine, degenerate_faces, face_normals, is_mirror, moved_camera, moved_light, turn_round,
};
use super::solids::Defined;
use super::{has_area, is_camera, is_invertible, unit};
use crate::reading::options::Budget;
use crate::reading::warnings::Warnings;
use crate::{Loaded, ReadError, ReadOptions};
use azulejo_scene::math::normal_matrix;
use azulejo_scene::{
    Attribute, Faces, Figure, MaterialId, Mesh, Object, Primitive, PrimitiveKind, Rgb, Scene,
    Shape, Texture, TextureId,
};
use glam::{DAffine3, DVec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Radiance of a light that says none.
const DEFAULT_RADIANCE: Rgb = Rgb::WHITE;

/// Bytes of names that all derived materials together may copy.
const BUDGET: usize = 1 << 28;

pub(super) type Resolved<T> = Result<T, Fail>;

impl Document {
    /// The scene that the document describes. Textures have no pixels yet: see
    /// [`load_textures`](super::load_textures).
    ///
    /// # Errors
    /// A transform that carries numbers out of range. The error names the place but doesn't draw
    /// its line.
    pub fn resolve(&self) -> Result<Loaded, ReadError> {
        self.resolve_with(&ReadOptions::default())
    }

    /// As [`resolve`](Document::resolve), with limits for what instances may unfold to.
    ///
    /// # Errors
    /// Also instances that unfold to more.
    pub fn resolve_with(&self, options: &ReadOptions) -> Result<Loaded, ReadError> {
        let mut resolver = Resolver {
            document: self,
            scene: Scene::default(),
            warnings: Warnings::default(),
            scopes: Vec::new(),
            surfaces: HashMap::new(),
            derived: HashMap::new(),
            texture_ids: HashMap::new(),
            budget: BUDGET,
            instances: Budget::new(options),
            depth: 0,
        };
        resolver
            .list(&self.blocks, &[], None)
            .map_err(|fail| *fail)?;
        let scene = resolver.scene;
        if let Err(invalid) = scene.validate() {
            let name = self.sources.shown(0);
            return Err(ReadError::whole(
                name,
                invalid.to_string(),
                "a possible scene",
            ));
        }
        Ok(Loaded {
            scene,
            warnings: resolver.warnings.finish(self.sources.shown(0)),
        })
    }
}

pub(super) struct Resolver<'d> {
    document: &'d Document,
    pub scene: Scene,
    warnings: Warnings,
    pub scopes: Vec<Scope<'d>>,
    /// What stands behind the materials that a `def brdf` made.
    pub surfaces: HashMap<MaterialId, Known>,
    /// Materials made from looks, so that equal looks share one.
    pub derived: HashMap<Key, MaterialId>,
    /// Bytes of names that derived materials may still copy.
    pub budget: usize,
    /// Textures named in place.
    texture_ids: HashMap<String, TextureId>,
    /// What instances may still copy.
    pub instances: Budget,
    /// Solids and definitions that are being made, one inside of the other.
    pub depth: usize,
}

/// A material of a `def brdf`.
pub(super) struct Known {
    pub surface: Surface,
    /// Whether `use` of it also says the textures.
    pub sets_textures: bool,
}

/// The names of one list of blocks.
#[derive(Default)]
pub(super) struct Scope<'d> {
    colors: HashMap<&'d str, Rgb>,
    brdfs: HashMap<&'d str, MaterialId>,
    textures: HashMap<&'d str, TextureId>,
    pub figures: HashMap<&'d str, &'d Arc<Figure>>,
    pub solids: HashMap<&'d str, Defined<'d>>,
}

impl<'d> Resolver<'d> {
    pub fn warn(&mut self, place: Place, message: impl Into<String>, count: usize) {
        let file = self.document.sources.shown(place.file);
        self.warnings
            .add_many(file, message.into(), count, || place.position());
    }

    pub fn fail(&self, place: Place, found: impl Into<String>, expected: &str) -> Fail {
        self.document.sources.fail(place, found, expected)
    }

    /// A list of blocks is a scope: its definitions are known before any of its blocks.
    fn list(
        &mut self,
        blocks: &'d [Block],
        definitions: &'d [super::document::Definition],
        outer: Outer,
    ) -> Resolved<()> {
        self.scopes.push(Scope::default());
        let place = blocks.first().map_or(Place::default(), |b| b.place);
        self.define(definitions, place);
        self.gather_definitions(blocks);
        self.gather_notes(blocks)?;
        self.make_definitions(blocks)?;
        self.blocks(blocks, outer)?;
        self.scopes.pop();
        Ok(())
    }

    fn blocks(&mut self, blocks: &'d [Block], outer: Outer) -> Resolved<()> {
        for block in blocks {
            self.block(block, outer)?;
        }
        Ok(())
    }

    fn block(&mut self, block: &'d Block, outer: Outer) -> Resolved<()> {
        let place = block.place;
        match &block.kind {
            BlockKind::Mesh(mesh) => self.mesh(mesh, place, outer)?,
            BlockKind::AreaLight(light) => self.area_light(light, place, outer)?,
            BlockKind::Primitive(primitive) => self.primitive(primitive, place, outer)?,
            BlockKind::Exact(exact) => self.exact(exact, place, outer)?,
            BlockKind::Include { blocks, .. } => self.blocks(blocks, outer)?,
            BlockKind::Transform { steps, blocks } => {
                let map = outer.unwrap_or(DAffine3::IDENTITY) * affine(steps);
                if !map.is_finite() {
                    return Err(self.fail(place, "a transform out of range", "finite numbers"));
                }
                self.list(blocks, &[], Some(map))?;
            }
            BlockKind::Definitions {
                definitions,
                blocks: Some(blocks),
            } => self.list(blocks, definitions, outer)?,
            BlockKind::Units(units) => self.scene.units = *units,
            BlockKind::Background(color) => self.scene.background = Some(*color),
            BlockKind::Fog(fog) => self.scene.fog = Some(*fog),
            BlockKind::Camera(camera) => {
                let camera = moved_camera(camera, outer);
                if !is_camera(&camera) {
                    return Err(self.fail(place, "a transform that blinds the camera", "another"));
                }
                self.scene.cameras.push(camera);
            }
            BlockKind::Light(light) => {
                let light = moved_light(light, outer).ok_or_else(|| {
                    self.fail(place, "a transform that flattens a light", "another")
                })?;
                self.scene.lights.push(light);
            }
            BlockKind::Definitions { blocks: None, .. }
            | BlockKind::Figure(_)
            | BlockKind::Define(_)
            | BlockKind::Material(_)
            | BlockKind::Texture { .. }
            | BlockKind::Params(_)
            | BlockKind::Unknown { .. } => {}
        }
        Ok(())
    }

    /// Definitions without blocks of their own, also those in included files.
    fn gather_definitions(&mut self, blocks: &'d [Block]) {
        for block in blocks {
            match &block.kind {
                BlockKind::Include { blocks, .. } => self.gather_definitions(blocks),
                BlockKind::Definitions {
                    definitions,
                    blocks: None,
                } => self.define(definitions, block.place),
                BlockKind::Figure(block) => {
                    self.scope().figures.insert(&block.name, &block.figure);
                }
                BlockKind::Define(definition) => {
                    let open = Defined::Open(definition, block.place);
                    self.scope().solids.insert(&definition.name, open);
                }
                _ => {}
            }
        }
    }

    fn define(&mut self, definitions: &'d [super::document::Definition], place: Place) {
        for definition in definitions {
            let name: &'d str = &definition.name;
            match &definition.body {
                Body::Color(rgb) => {
                    self.scope().colors.insert(name, *rgb);
                }
                Body::Texture(path) => {
                    let id = self.add_texture(path, place);
                    self.scope().textures.insert(name, id);
                }
                Body::Brdf(brdf) => {
                    let surface = surface(name, brdf);
                    let mut material = surface.material.clone();
                    if !material.limit_reflectance() {
                        self.warn(place, REFLECTS_TOO_MUCH, 1);
                    }
                    let id = self.scene.add_material(material);
                    let known = Known {
                        surface,
                        sets_textures: false,
                    };
                    self.surfaces.insert(id, known);
                    self.scope().brdfs.insert(name, id);
                }
            }
        }
    }

    /// `ext material` and `ext texture`, which complete definitions.
    fn gather_notes(&mut self, blocks: &'d [Block]) -> Resolved<()> {
        for block in blocks {
            match &block.kind {
                BlockKind::Include { blocks, .. } => self.gather_notes(blocks)?,
                BlockKind::Texture { of, path } => {
                    let id = self.texture_named(of, block.place)?;
                    self.scene.textures[id as usize].path.clone_from(path);
                }
                BlockKind::Material(note) => self.annotate(note, block.place)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn annotate(&mut self, note: &'d MaterialNote, place: Place) -> Resolved<()> {
        let id = self.brdf_named(&note.of, place)?;
        let textures = match &note.textures {
            None => None,
            Some(names) => Some(
                names
                    .iter()
                    .map(|name| self.texture_named(name, place))
                    .collect::<Resolved<Vec<_>>>()?,
            ),
        };
        if let Some(known) = self.surfaces.get_mut(&id) {
            known.sets_textures |= textures.is_some();
            known.surface.annotate(note, textures);
            let mut material = known.surface.material.clone();
            if !material.limit_reflectance() {
                self.warn(place, REFLECTS_TOO_MUCH, 1);
            }
            self.scene.materials[id as usize] = material;
        }
        Ok(())
    }

    fn scope(&mut self) -> &mut Scope<'d> {
        if self.scopes.is_empty() {
            self.scopes.push(Scope::default());
        }
        let last = self.scopes.len() - 1;
        &mut self.scopes[last]
    }

    fn lookup<T: Copy>(
        &self,
        kind: Kind,
        name: &str,
        place: Place,
        names: impl for<'s> Fn(&'s Scope<'d>) -> &'s HashMap<&'d str, T>,
    ) -> Resolved<T> {
        let found = self.scopes.iter().rev().find_map(|s| names(s).get(name));
        found
            .copied()
            .ok_or_else(|| self.undefined(kind, name, place))
    }

    /// Only a document that was changed by hand has such a name.
    #[cold]
    pub fn undefined(&self, kind: Kind, name: &str, place: Place) -> Fail {
        self.fail(
            place,
            format!("`{name}`, which is not defined"),
            &format!("a {} that is defined", kind.word()),
        )
    }

    pub fn brdf_named(&self, name: &Name, place: Place) -> Resolved<MaterialId> {
        self.lookup(Kind::Brdf, name, place, |s| &s.brdfs)
    }

    pub fn texture_named(&self, name: &Name, place: Place) -> Resolved<TextureId> {
        self.lookup(Kind::Texture, name, place, |s| &s.textures)
    }

    pub fn color_named(&self, name: &Name, place: Place) -> Resolved<Rgb> {
        self.lookup(Kind::Color, name, place, |s| &s.colors)
    }

    fn add_texture(&mut self, path: &str, place: Place) -> TextureId {
        let path = self.texture_path(path, place);
        self.scene.textures.push(Texture { path, image: None });
        (self.scene.textures.len() - 1) as TextureId
    }

    /// The path of a texture from the folder of the outermost file.
    fn texture_path(&self, path: &str, place: Place) -> String {
        match self.document.sources.get(place.file) {
            Some(source) if source.path.contains('/') => super::parse::joined(&source.path, path),
            _ => path.to_owned(),
        }
    }

    pub fn texture_in_place(&mut self, path: &str, place: Place) -> TextureId {
        let key = self.texture_path(path, place);
        if let Some(&known) = self.texture_ids.get(&key) {
            return known;
        }
        let id = self.add_texture(path, place);
        self.texture_ids.insert(key, id);
        id
    }
}

/// Normals by corners under a transform; `faces` are those before it.
fn placed_normals(normals: &Attribute<DVec3>, faces: &Faces, outer: Outer) -> Attribute<DVec3> {
    let mut normals = normals.clone();
    let Some(map) = outer else { return normals };
    let matrix = normal_matrix(map.matrix3);
    for n in &mut normals.values {
        *n = unit(matrix * *n).unwrap_or(*n);
    }
    if let Some(corners) = normals.corners.as_mut().filter(|_| is_mirror(outer)) {
        let mut turned = Faces {
            starts: faces.starts.clone(),
            corners: std::mem::take(corners),
        };
        turn_round(&mut turned);
        *corners = turned.corners;
    }
    normals
}

/// Objects.
impl<'d> Resolver<'d> {
    fn area_light(&mut self, light: &'d AreaLight, place: Place, outer: Outer) -> Resolved<()> {
        let map = outer.unwrap_or(DAffine3::IDENTITY);
        let [mut a, mut b] = light.edges.map(|edge| map.matrix3 * edge);
        if is_mirror(outer) {
            // In a mirror the lamp still shines on the mirrored room.
            (a, b) = (b, a);
        }
        let corner = map.transform_point3(light.corner);
        if !has_area(a, b) || !corner.is_finite() {
            return Err(self.fail(
                place,
                "a light that a transform leaves without area",
                "a transform that keeps it",
            ));
        }
        let radiance = light.radiance.unwrap_or(DEFAULT_RADIANCE);
        let material = self.noted_material(&light.notes, Some(radiance), place)?;
        let mut primitive = Primitive::parallelogram(corner, a, b, material);
        primitive.light.clone_from(&light.notes.light);
        let shape = Shape::Primitive(primitive);
        self.scene
            .objects
            .push(Object::new(&*light.notes.name, shape));
        Ok(())
    }

    fn primitive(&mut self, block: &'d PrimitiveBlock, place: Place, outer: Outer) -> Resolved<()> {
        let mut map = outer.map_or(block.map, |outer| outer * block.map);
        if block.kind == PrimitiveKind::Square && is_mirror(outer) {
            let axes = &mut map.matrix3;
            (axes.x_axis, axes.y_axis) = (axes.y_axis, axes.x_axis);
        }
        if !is_invertible(block.kind, &map) {
            return Err(self.fail(
                place,
                "a primitive that a transform flattens",
                "a transform that keeps it",
            ));
        }
        let material = self.noted_material(&block.notes, None, place)?;
        let mut primitive = Primitive::new(block.kind, map, material);
        primitive.light.clone_from(&block.notes.light);
        let shape = Shape::Primitive(primitive);
        self.scene
            .objects
            .push(Object::new(&*block.notes.name, shape));
        Ok(())
    }

    fn mesh(&mut self, block: &'d MeshBlock, place: Place, outer: Outer) -> Resolved<()> {
        let materials = self.face_materials(block, place)?;
        let mesh = self.built_mesh(block, materials, place, outer)?;
        let shape = Shape::Mesh(mesh);
        self.scene
            .objects
            .push(Object::new(&*block.notes.name, shape));
        Ok(())
    }

    /// A mesh in the world, its faces of these materials.
    pub fn built_mesh(
        &mut self,
        block: &'d MeshBlock,
        face_materials: Vec<MaterialId>,
        place: Place,
        outer: Outer,
    ) -> Resolved<Mesh> {
        let vertices = &block.vertices;
        let count = vertices.positions.len();
        let mut positions = vertices.positions.clone();
        if let Some(map) = outer {
            for p in &mut positions {
                *p = map.transform_point3(*p);
            }
            if !positions.iter().all(|p| p.is_finite()) {
                return Err(self.fail(
                    place,
                    "a mesh that a transform carries out of range",
                    "finite positions",
                ));
            }
        }
        let mut faces = block.faces.clone();
        if is_mirror(outer) {
            turn_round(&mut faces);
        }
        let mut mesh = Mesh {
            positions,
            faces,
            face_materials,
            smoothing: block.notes.smoothing.clone(),
            colors: self.colors(block, place)?,
            irradiance: self.filled(
                &vertices.irradiance,
                count,
                Rgb::BLACK,
                place,
                "a vertex has no `irad` beside others that have; read as black",
            ),
            irradiance_error: block.notes.irradiance_error.clone(),
            ..Mesh::default()
        };
        let uvs = self.filled(
            &vertices.uvs,
            count,
            glam::DVec2::ZERO,
            place,
            "a vertex has no `uv` beside others that have; read as (0, 0)",
        );
        mesh.uvs = (!vertices.uvs.is_empty()).then(|| Attribute::per_vertex(uvs));
        if !vertices.normals.is_empty() {
            let normals = self.normals(block, &mesh, outer, place);
            mesh.normals = Some(Attribute::per_vertex(normals));
        }
        if let Some(normals) = &block.notes.normals {
            mesh.normals = Some(placed_normals(normals, &block.faces, outer));
        }
        let flat = degenerate_faces(&mesh);
        self.warn(place, "a face has no area; kept", flat);
        Ok(mesh)
    }

    /// An attribute with `substitute` where it is missing; empty when all vertices lack it.
    fn filled<T: Copy + Default>(
        &mut self,
        column: &Column<T>,
        count: usize,
        substitute: T,
        place: Place,
        message: &str,
    ) -> Vec<T> {
        if column.is_empty() {
            return Vec::new();
        }
        if let Some(all) = column.complete(count) {
            return all.to_vec();
        }
        self.warn(place, message, column.lacking(count));
        (0..count)
            .map(|v| column.get(v).unwrap_or(substitute))
            .collect()
    }

    fn colors(&mut self, block: &'d MeshBlock, place: Place) -> Resolved<Vec<Rgb>> {
        let vertices = &block.vertices;
        let mut colors = self.filled(
            &vertices.colors,
            vertices.positions.len(),
            Rgb::WHITE,
            place,
            "a vertex has no colour beside others that have; read as white",
        );
        for (vertex, name) in &vertices.named_colors {
            let color = self.color_named(name, place)?;
            if let Some(slot) = colors.get_mut(*vertex as usize) {
                *slot = color;
            }
        }
        Ok(colors)
    }

    /// Unit normals in the world; those that are missing or zero come from the faces around.
    fn normals(
        &mut self,
        block: &MeshBlock,
        mesh: &Mesh,
        outer: Outer,
        place: Place,
    ) -> Vec<DVec3> {
        let matrix = outer.map(|map| normal_matrix(map.matrix3));
        let given = |v: usize| {
            let normal = block.vertices.normals.get(v)?;
            // A matrix that is not there leaves a unit normal as it was written.
            unit(matrix.map_or(normal, |m| m * normal))
        };
        let mut normals: Vec<Option<DVec3>> = (0..mesh.positions.len()).map(given).collect();
        let missing = normals.iter().filter(|n| n.is_none()).count();
        if missing > 0 {
            let message = "a vertex has no normal beside others that have; taken from its faces";
            self.warn(place, message, missing);
            let around = face_normals(mesh);
            for (normal, faces) in normals.iter_mut().zip(around) {
                *normal = normal.or(unit(faces));
            }
        }
        normals.into_iter().map(|n| n.unwrap_or(DVec3::Z)).collect()
    }

    fn face_materials(&mut self, block: &'d MeshBlock, place: Place) -> Resolved<Vec<MaterialId>> {
        let emission = match block.is_light {
            true => Some(block.radiance.unwrap_or(DEFAULT_RADIANCE)),
            false => None,
        };
        let is_colored = !block.vertices.colors.is_empty();
        let mut look = Look::default();
        let mut is_stacking = false;
        for change in &block.head {
            self.change(&mut look, change, &mut is_stacking, place)?;
        }
        let faces = block.faces.len();
        let mut materials = Vec::with_capacity(faces);
        let mut changes = block.changes.iter().peekable();
        while materials.len() < faces {
            is_stacking = false;
            let here = materials.len();
            while let Some((_, change)) = changes.next_if(|(at, _)| *at as usize <= here) {
                self.change(&mut look, change, &mut is_stacking, place)?;
            }
            let end = changes.peek().map_or(faces, |(at, _)| *at as usize);
            let material = self.material(&look, emission, is_colored, place);
            materials.resize(end.clamp(here + 1, faces), material);
        }
        Ok(materials)
    }
}
