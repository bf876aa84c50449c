//! Converts a document to a scene: scopes, transforms, materials.

use super::appearance::{DerivedMaterialKey, FaceAppearance};
use super::document::{
    AreaLight, BlockKind, BoxedError, DefinitionBody, FinishNote, GrfBlock, GrfDefinition,
    GrfDocument, GrfName, MaterialNote, MeshBlock, NameKind, ObjectNotes, OpacityNote,
    PrimitiveBlock, SourcePosition, VertexColumn,
};
use super::instances::SharedMeshes;
use super::materials::{DefinedMaterial, REFLECTS_TOO_MUCH, surface};
use super::placement::{
    BlockPlace, OuterTransform, affine, degenerate_faces, face_normals, is_mirror, moved_camera,
    moved_light, reverse_faces,
};
use super::shared::share_vertices;
use super::solids::Defined;
use super::{has_area, is_camera, is_invertible, unit};
use crate::reading::options::Budget;
use crate::reading::warnings::Warnings;
use crate::{Loaded, ReadError, ReadOptions};
use azulejo_scene::math::normal_matrix;
use azulejo_scene::{
    Attribute, Faces, Figure, FinishMaps, MaterialId, Mesh, NumberPicture, Object, Opacity,
    OpacityPicture, PictureChannel, Primitive, PrimitiveKind, Relief, Rgb, Scene, Shape, Texture,
    TextureId,
};
use glam::{DAffine3, DVec3};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Radiance of a light without one.
const DEFAULT_RADIANCE: Rgb = Rgb::WHITE;

/// Budget of bytes of names that all derived materials together may copy.
const BUDGET: usize = 1 << 28;

pub(super) type ResolveResult<T> = Result<T, BoxedError>;

impl GrfDocument {
    /// The scene that the document describes. Textures have no pixels yet: see
    /// [`load_textures`](super::load_textures).
    ///
    /// # Errors
    /// A transform that overflows. The error has a position, but no source line.
    pub fn resolve(&self) -> Result<Loaded, ReadError> {
        self.resolve_with(&ReadOptions::default())
    }

    /// As [`resolve`](GrfDocument::resolve), with limits for what instances may unfold to.
    ///
    /// # Errors
    /// Also instances that unfold to more.
    pub fn resolve_with(&self, options: &ReadOptions) -> Result<Loaded, ReadError> {
        let mut resolver = GrfResolver {
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
            is_repeated: false,
            shared_meshes: SharedMeshes::default(),
            made_textures: HashMap::new(),
            made_materials: HashMap::new(),
        };
        resolver
            .list(&self.blocks, &[], None)
            .map_err(|fail| *fail)?;
        let mut scene = resolver.scene;
        scene.unfold_single_instances();
        if let Err(invalid) = scene.validate() {
            let name = self.sources.shown(0);
            return Err(ReadError::whole(name, invalid.to_string(), "a valid scene"));
        }
        Ok(Loaded {
            scene,
            warnings: resolver.warnings.finish(self.sources.shown(0)),
        })
    }
}

pub(super) struct GrfResolver<'d> {
    document: &'d GrfDocument,
    pub scene: Scene,
    warnings: Warnings,
    pub scopes: Vec<ResolveScope<'d>>,
    /// The materials made from `def brdf`.
    pub surfaces: HashMap<MaterialId, NamedMaterial>,
    /// Derived materials, so that equal appearances share one.
    pub derived: HashMap<DerivedMaterialKey, MaterialId>,
    /// Remaining bytes of names that derived materials may copy.
    pub budget: usize,
    /// Textures given in place.
    texture_ids: HashMap<String, TextureId>,
    /// Remaining budget of what instances may copy.
    pub instances: Budget,
    /// Current depth of nested solids and definitions.
    pub depth: usize,
    /// Whether the current block is of a file that is included several times.
    pub is_repeated: bool,
    pub shared_meshes: SharedMeshes<'d>,
    /// The textures and materials made of definitions: a file that is included several times makes
    /// them once.
    made_textures: HashMap<*const GrfDefinition, TextureId>,
    made_materials: HashMap<*const GrfDefinition, MaterialId>,
}

/// A material of a `def brdf`.
pub(super) struct NamedMaterial {
    pub surface: DefinedMaterial,
    /// Whether `use` of it also sets the textures.
    pub sets_textures: bool,
}

/// The names of one list of blocks.
#[derive(Default)]
pub(super) struct ResolveScope<'d> {
    colors: HashMap<&'d str, Rgb>,
    brdfs: HashMap<&'d str, MaterialId>,
    textures: HashMap<&'d str, TextureId>,
    pub figures: HashMap<&'d str, &'d Arc<Figure>>,
    pub solids: HashMap<&'d str, Defined<'d>>,
}

impl<'d> GrfResolver<'d> {
    pub fn warn(&mut self, place: SourcePosition, message: impl Into<String>, count: usize) {
        let file = self.document.sources.shown(place.file);
        self.warnings
            .add_many(file, message.into(), count, || place.position());
    }

    pub fn fail(
        &self,
        place: SourcePosition,
        found: impl Into<String>,
        expected: &str,
    ) -> BoxedError {
        self.document.sources.fail(place, found, expected)
    }

    /// A list of blocks is a scope: its definitions are known before any of its blocks.
    fn list(
        &mut self,
        blocks: &'d [GrfBlock],
        definitions: &'d [GrfDefinition],
        outer: OuterTransform,
    ) -> ResolveResult<()> {
        self.scopes.push(ResolveScope::default());
        let place = blocks
            .first()
            .map_or(SourcePosition::default(), |b| b.place);
        self.define(definitions, place);
        let mut defining = Vec::new();
        self.defining_blocks(blocks, &mut HashSet::new(), &mut defining)?;
        self.gather_definitions(&defining);
        self.gather_notes(&defining)?;
        self.make_definitions(&defining)?;
        self.blocks(blocks, outer)?;
        self.scopes.pop();
        Ok(())
    }

    /// The blocks that define names in a list, those of included files among them.
    fn defining_blocks(
        &mut self,
        blocks: &'d [GrfBlock],
        known: &mut HashSet<*const Vec<GrfBlock>>,
        defining: &mut Vec<&'d GrfBlock>,
    ) -> ResolveResult<()> {
        for block in blocks {
            match &block.kind {
                BlockKind::Include { blocks, .. } => {
                    if !known.insert(Arc::as_ptr(blocks)) {
                        self.spend(4 * (blocks.len() as u64 + 1), block.place)?;
                    }
                    self.defining_blocks(blocks, known, defining)?;
                }
                BlockKind::Definitions { blocks: None, .. }
                | BlockKind::Figure(_)
                | BlockKind::Define(_)
                | BlockKind::Texture { .. }
                | BlockKind::Material(_) => defining.push(block),
                _ => {}
            }
        }
        Ok(())
    }

    fn blocks(&mut self, blocks: &'d [GrfBlock], outer: OuterTransform) -> ResolveResult<()> {
        for block in blocks {
            if self.is_repeated {
                self.spend(1, block.place)?;
            }
            self.block(block, outer)?;
        }
        Ok(())
    }

    /// Takes elements from the budget of what includes and instances multiply.
    pub fn spend(&mut self, elements: u64, place: SourcePosition) -> ResolveResult<()> {
        let spent = self.instances.spend(elements);
        spent.map_err(|exhausted| {
            let error = exhausted.error(self.document.sources.shown(place.file));
            Box::new(error)
        })
    }

    fn block(&mut self, block: &'d GrfBlock, outer: OuterTransform) -> ResolveResult<()> {
        let source = block.place;
        let place = BlockPlace { source, outer };
        match &block.kind {
            BlockKind::Mesh(mesh) => self.mesh(mesh, place)?,
            BlockKind::AreaLight(light) => self.area_light(light, place)?,
            BlockKind::Primitive(primitive) => self.primitive(primitive, place)?,
            BlockKind::Exact(exact) => self.exact(exact, place)?,
            BlockKind::MeshInstance(block) => self.mesh_instance(block, place)?,
            BlockKind::Include { blocks, .. } => {
                // A file with several includes takes its blocks from the budget at each of them.
                let was_repeated = self.is_repeated;
                self.is_repeated |= Arc::strong_count(blocks) > 1;
                self.blocks(blocks, outer)?;
                self.is_repeated = was_repeated;
            }
            BlockKind::Transform { steps, blocks } => {
                let map = outer.unwrap_or(DAffine3::IDENTITY) * affine(steps);
                if !map.is_finite() {
                    return Err(self.fail(source, "a transform that overflows", "finite numbers"));
                }
                self.list(blocks, &[], Some(map))?;
            }
            BlockKind::Definitions {
                definitions,
                blocks: Some(blocks),
            } => self.list(blocks, definitions, outer)?,
            BlockKind::Units(units) => self.scene.units = *units,
            BlockKind::Background(color) => self.scene.background = Some((*color).into()),
            BlockKind::Environment(block) => self.environment(block, place)?,
            BlockKind::Backplate(block) => self.backplate(block, source),
            BlockKind::Fog(fog) => self.scene.fog = Some(*fog),
            BlockKind::Camera(camera) => {
                let camera = moved_camera(camera, outer);
                if !is_camera(&camera) {
                    return Err(self.fail(
                        source,
                        "a transform that makes the view of a camera degenerate",
                        "another",
                    ));
                }
                self.scene.cameras.push(camera);
            }
            BlockKind::Light(light) => {
                let light = moved_light(light, outer).ok_or_else(|| {
                    self.fail(
                        source,
                        "a transform that leaves a light without direction",
                        "another",
                    )
                })?;
                self.scene.lights.push(light);
            }
            // What defines names took effect when the list began; the rest changes nothing in the scene.
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

    /// Collects definitions without blocks of their own.
    fn gather_definitions(&mut self, blocks: &[&'d GrfBlock]) {
        for block in blocks {
            match &block.kind {
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

    fn define(&mut self, definitions: &'d [GrfDefinition], place: SourcePosition) {
        for definition in definitions {
            let name: &'d str = &definition.name;
            match &definition.body {
                DefinitionBody::Color(rgb) => {
                    self.scope().colors.insert(name, *rgb);
                }
                DefinitionBody::Texture(path) => {
                    let known = self.made_textures.get(&std::ptr::from_ref(definition));
                    let id = match known {
                        Some(&id) => id,
                        None => self.add_texture(path, place),
                    };
                    self.made_textures.insert(definition, id);
                    self.scope().textures.insert(name, id);
                }
                DefinitionBody::Brdf(brdf) => {
                    if let Some(&id) = self.made_materials.get(&std::ptr::from_ref(definition)) {
                        self.scope().brdfs.insert(name, id);
                        continue;
                    }
                    let surface = surface(name, brdf);
                    let mut material = surface.material.clone();
                    if !material.limit_reflectance() {
                        self.warn(place, REFLECTS_TOO_MUCH, 1);
                    }
                    let id = self.scene.add_material(material);
                    let known = NamedMaterial {
                        surface,
                        sets_textures: false,
                    };
                    self.surfaces.insert(id, known);
                    self.made_materials.insert(definition, id);
                    self.scope().brdfs.insert(name, id);
                }
            }
        }
    }

    /// Collects `ext material` and `ext texture`, which complete definitions.
    fn gather_notes(&mut self, blocks: &[&'d GrfBlock]) -> ResolveResult<()> {
        for block in blocks {
            match &block.kind {
                BlockKind::Texture { of, path, wrap } => {
                    let id = self.texture_named(of, block.place)?;
                    let texture = &mut self.scene.textures[id as usize];
                    texture.path.clone_from(path);
                    texture.wrap = *wrap;
                }
                BlockKind::Material(note) => self.annotate(note, block.place)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn annotate(&mut self, note: &'d MaterialNote, place: SourcePosition) -> ResolveResult<()> {
        let id = self.brdf_named(&note.of, place)?;
        // Every name in the note is resolved first: the material is borrowed afterwards.
        let named = |name: &'d GrfName| self.texture_named(name, place);
        let textures = note.textures.as_ref();
        let textures = textures.map(|names| names.iter().map(named).collect());
        let textures: Option<Vec<TextureId>> = textures.transpose()?;
        let emission_picture = note.emission_texture.as_ref().map(named).transpose()?;
        let opacity = note.opacity.as_ref().map(|o| self.opacity(o, place));
        let opacity = opacity.transpose()?;
        let finish = note.finish.as_ref().map(|f| self.finish(f, place));
        let finish = finish.transpose()?;
        let relief = match &note.relief {
            Some((name, kind)) => Some(Relief {
                texture: named(name)?,
                kind: *kind,
            }),
            None => None,
        };
        if let Some(known) = self.surfaces.get_mut(&id) {
            known.sets_textures |= textures.is_some();
            let own = &mut known.surface.material;
            own.emission_picture = emission_picture.or(own.emission_picture);
            own.finish = finish.or(own.finish);
            own.relief = relief.or(own.relief);
            own.opacity = opacity.or(own.opacity);
            known.surface.annotate(note, textures);
            let mut material = known.surface.material.clone();
            if !material.limit_reflectance() {
                self.warn(place, REFLECTS_TOO_MUCH, 1);
            }
            self.scene.materials[id as usize] = material;
        }
        Ok(())
    }

    fn finish(&self, note: &'d FinishNote, place: SourcePosition) -> ResolveResult<FinishMaps> {
        let picture = |given: &'d Option<(GrfName, PictureChannel)>| {
            let number = |(name, channel): &'d (GrfName, PictureChannel)| {
                let texture = self.texture_named(name, place)?;
                let channel = *channel;
                Ok(NumberPicture { texture, channel })
            };
            let number: ResolveResult<Option<NumberPicture>> =
                given.as_ref().map(number).transpose();
            number
        };
        Ok(FinishMaps {
            base: note.base,
            metallic: note.metallic,
            roughness: note.roughness,
            metallic_picture: picture(&note.metallic_picture)?,
            roughness_picture: picture(&note.roughness_picture)?,
        })
    }

    fn opacity(&self, note: &'d OpacityNote, place: SourcePosition) -> ResolveResult<Opacity> {
        let picture = match &note.picture {
            None => None,
            Some((name, channel)) => Some(OpacityPicture {
                texture: self.texture_named(name, place)?,
                channel: *channel,
            }),
        };
        Ok(Opacity {
            constant: note.constant,
            picture,
            mode: note.mode,
        })
    }

    fn scope(&mut self) -> &mut ResolveScope<'d> {
        if self.scopes.is_empty() {
            self.scopes.push(ResolveScope::default());
        }
        let last = self.scopes.len() - 1;
        &mut self.scopes[last]
    }

    pub fn lookup<T: Copy>(
        &self,
        kind: NameKind,
        name: &str,
        place: SourcePosition,
        names: impl for<'s> Fn(&'s ResolveScope<'d>) -> &'s HashMap<&'d str, T>,
    ) -> ResolveResult<T> {
        let value = self.scopes.iter().rev().find_map(|s| names(s).get(name));
        value
            .copied()
            .ok_or_else(|| self.undefined(kind, name, place))
    }

    /// The error for an undefined name, which only a document modified by a program can contain.
    #[cold]
    pub fn undefined(&self, kind: NameKind, name: &str, place: SourcePosition) -> BoxedError {
        self.fail(
            place,
            format!("`{name}`, which is not defined"),
            &format!("a {} that is defined", kind.word()),
        )
    }

    pub fn brdf_named(&self, name: &GrfName, place: SourcePosition) -> ResolveResult<MaterialId> {
        self.lookup(NameKind::Brdf, name, place, |s| &s.brdfs)
    }

    pub fn texture_named(&self, name: &GrfName, place: SourcePosition) -> ResolveResult<TextureId> {
        self.lookup(NameKind::Texture, name, place, |s| &s.textures)
    }

    pub fn color_named(&self, name: &GrfName, place: SourcePosition) -> ResolveResult<Rgb> {
        self.lookup(NameKind::Color, name, place, |s| &s.colors)
    }

    fn add_texture(&mut self, path: &str, place: SourcePosition) -> TextureId {
        let path = self.texture_path(path, place);
        self.scene.textures.push(Texture {
            path,
            ..Texture::default()
        });
        (self.scene.textures.len() - 1) as TextureId
    }

    /// The path of a texture relative to the folder of the outermost file.
    fn texture_path(&self, path: &str, place: SourcePosition) -> String {
        match self.document.sources.get(place.file) {
            Some(source) if source.path.contains('/') => super::parse::joined(&source.path, path),
            _ => path.to_owned(),
        }
    }

    pub fn texture_in_place(&mut self, path: &str, place: SourcePosition) -> TextureId {
        let key = self.texture_path(path, place);
        if let Some(&known) = self.texture_ids.get(&key) {
            return known;
        }
        let id = self.add_texture(path, place);
        self.texture_ids.insert(key, id);
        id
    }
}

/// Transformed normals per corner; `faces` are the faces before the transform.
fn placed_normals(
    normals: &Attribute<DVec3>,
    faces: &Faces,
    outer: OuterTransform,
) -> Attribute<DVec3> {
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
        reverse_faces(&mut turned);
        *corners = turned.corners;
    }
    normals
}

impl<'d> GrfResolver<'d> {
    fn area_light(&mut self, light: &'d AreaLight, place: BlockPlace) -> ResolveResult<()> {
        let map = place.outer.unwrap_or(DAffine3::IDENTITY);
        let [mut a, mut b] = light.edges.map(|edge| map.matrix3 * edge);
        if is_mirror(place.outer) {
            // Keep the front of a mirrored light on the mirrored side.
            (a, b) = (b, a);
        }
        let corner = map.transform_point3(light.corner);
        if !has_area(a, b) || !corner.is_finite() {
            return Err(self.fail(
                place.source,
                "a light that a transform leaves without area",
                "a transform that preserves its area",
            ));
        }
        let radiance = light.radiance.unwrap_or(DEFAULT_RADIANCE);
        let material = self.noted_material(&light.notes, Some(radiance), place.source)?;
        let mut primitive = Primitive::parallelogram(corner, a, b, material);
        primitive.light.clone_from(&light.notes.light);
        self.push_object(&light.notes, Shape::Primitive(primitive))
    }

    fn primitive(&mut self, block: &'d PrimitiveBlock, place: BlockPlace) -> ResolveResult<()> {
        let mut map = place.outer.map_or(block.map, |outer| outer * block.map);
        if block.kind == PrimitiveKind::Square && is_mirror(place.outer) {
            let axes = &mut map.matrix3;
            (axes.x_axis, axes.y_axis) = (axes.y_axis, axes.x_axis);
        }
        if !is_invertible(block.kind, &map) {
            return Err(self.fail(
                place.source,
                "a primitive that a transform flattens",
                "an invertible transform",
            ));
        }
        let material = self.noted_material(&block.notes, None, place.source)?;
        let mut primitive = Primitive::new(block.kind, map, material);
        primitive.light.clone_from(&block.notes.light);
        self.push_object(&block.notes, Shape::Primitive(primitive))
    }

    fn mesh(&mut self, block: &'d MeshBlock, place: BlockPlace) -> ResolveResult<()> {
        let materials = self.face_materials(block, place.source)?;
        let shape = if let Some(named) = &block.notes.shared_mesh {
            let mesh = {
                let own = BlockPlace {
                    outer: None,
                    ..place
                };
                self.whole_mesh(block, materials, own)?
            };
            Shape::Instance(self.named_instance(named, mesh, place)?)
        } else {
            match self.included_instance(block, &materials, place)? {
                Some(instance) => Shape::Instance(instance),
                None => {
                    if self.is_repeated {
                        let size = block.vertices.positions.len() + block.faces.corners.len();
                        self.spend(size as u64, place.source)?;
                    }
                    Shape::Mesh(self.whole_mesh(block, materials, place)?)
                }
            }
        };
        self.push_object(&block.notes, shape)
    }

    /// Adds an object with the name in its notes.
    pub fn push_object(&mut self, notes: &ObjectNotes, shape: Shape) -> ResolveResult<()> {
        self.scene.objects.push(Object::new(&*notes.name, shape));
        Ok(())
    }

    /// As [`built_mesh`](GrfResolver::built_mesh), with the vertices that its file shares.
    pub fn whole_mesh(
        &mut self,
        block: &'d MeshBlock,
        face_materials: Vec<MaterialId>,
        place: BlockPlace,
    ) -> ResolveResult<Mesh> {
        let mut mesh = self.built_mesh(block, face_materials, place)?;
        if !block.notes.shared.is_empty() && !share_vertices(&mut mesh, &block.notes.shared) {
            let message = "vertices of `ext shared` that differ from their originals: kept apart";
            self.warn(place.source, message, 1);
        }
        Ok(mesh)
    }

    /// A mesh in world coordinates, with these face materials.
    pub fn built_mesh(
        &mut self,
        block: &'d MeshBlock,
        face_materials: Vec<MaterialId>,
        place: BlockPlace,
    ) -> ResolveResult<Mesh> {
        let (vertices, source) = (&block.vertices, place.source);
        let count = vertices.positions.len();
        // Move the vertices to the world; even a finite transform can overflow.
        let mut positions = vertices.positions.clone();
        if let Some(map) = place.outer {
            for p in &mut positions {
                *p = map.transform_point3(*p);
            }
            if !positions.iter().all(|p| p.is_finite()) {
                return Err(self.fail(
                    source,
                    "a mesh whose transformed positions overflow",
                    "finite positions",
                ));
            }
        }
        // A mirror would turn fronts to backs.
        let mut faces = block.faces.clone();
        if is_mirror(place.outer) {
            reverse_faces(&mut faces);
        }
        // A mesh has an attribute at all vertices or at none: fill the gaps of the columns.
        let mut mesh = Mesh {
            positions,
            faces,
            face_materials,
            smoothing: block.notes.smoothing.clone(),
            colors: self.colors(block, source)?,
            irradiance: self.filled(
                &vertices.irradiance,
                count,
                Rgb::BLACK,
                source,
                "vertex without `irad` in a mesh with `irad`: read as black",
            ),
            irradiance_error: block.notes.irradiance_error.clone(),
            back: block.notes.back.clone(),
            ..Mesh::default()
        };
        let uvs = self.filled(
            &vertices.uvs,
            count,
            glam::DVec2::ZERO,
            source,
            "vertex without `uv` in a mesh with `uv`: read as (0, 0)",
        );
        mesh.uvs = (!vertices.uvs.is_empty()).then(|| Attribute::per_vertex(uvs));
        // Normals are per vertex in GRF's own meshes, per corner in skins and in meshes of solids.
        if !vertices.normals.is_empty() {
            let normals = self.normals(block, &mesh, place);
            mesh.normals = Some(Attribute::per_vertex(normals));
        }
        if let Some(normals) = &block.notes.normals {
            mesh.normals = Some(placed_normals(normals, &block.faces, place.outer));
        }
        let flat = degenerate_faces(&mesh);
        self.warn(source, "face without area: kept", flat);
        Ok(mesh)
    }

    /// An attribute with `substitute` for missing values; empty if all vertices lack it.
    fn filled<T: Copy + Default>(
        &mut self,
        column: &VertexColumn<T>,
        count: usize,
        substitute: T,
        place: SourcePosition,
        message: &str,
    ) -> Vec<T> {
        if column.is_empty() {
            return Vec::new();
        }
        if let Some(values) = column.complete(count) {
            return values.to_vec();
        }
        self.warn(place, message, column.lacking(count));
        (0..count)
            .map(|v| column.get(v).unwrap_or(substitute))
            .collect()
    }

    fn colors(&mut self, block: &'d MeshBlock, place: SourcePosition) -> ResolveResult<Vec<Rgb>> {
        let vertices = &block.vertices;
        let mut colors = self.filled(
            &vertices.colors,
            vertices.positions.len(),
            Rgb::WHITE,
            place,
            "vertex without colour in a mesh with colours: read as white",
        );
        for (vertex, name) in &vertices.named_colors {
            let color = self.color_named(name, place)?;
            if let Some(slot) = colors.get_mut(*vertex as usize) {
                *slot = color;
            }
        }
        Ok(colors)
    }

    /// Unit normals in world coordinates; missing or zero ones are computed from the adjacent
    /// faces.
    fn normals(&mut self, block: &MeshBlock, mesh: &Mesh, place: BlockPlace) -> Vec<DVec3> {
        let matrix = place.outer.map(|map| normal_matrix(map.matrix3));
        let given = |v: usize| {
            let normal = block.vertices.normals.get(v)?;
            // Without a matrix, a unit normal stays as written.
            unit(matrix.map_or(normal, |m| m * normal))
        };
        let mut normals: Vec<Option<DVec3>> = (0..mesh.positions.len()).map(given).collect();
        let missing = normals.iter().filter(|n| n.is_none()).count();
        if missing > 0 {
            let message = "vertex without normal in a mesh with normals: computed from its faces";
            self.warn(place.source, message, missing);
            let around = face_normals(mesh);
            for (normal, faces) in normals.iter_mut().zip(around) {
                *normal = normal.or(unit(faces));
            }
        }
        normals.into_iter().map(|n| n.unwrap_or(DVec3::Z)).collect()
    }

    fn face_materials(
        &mut self,
        block: &'d MeshBlock,
        place: SourcePosition,
    ) -> ResolveResult<Vec<MaterialId>> {
        let emission = (block.is_light).then(|| block.radiance.unwrap_or(DEFAULT_RADIANCE));
        let is_colored = !block.vertices.colors.is_empty();
        let mut appearance = FaceAppearance::default();
        let mut is_stacking = false;
        for change in &block.head {
            self.change(&mut appearance, change, &mut is_stacking, place)?;
        }
        let faces = block.faces.len();
        let mut materials = Vec::with_capacity(faces);
        let mut changes = block.changes.iter().peekable();
        while materials.len() < faces {
            is_stacking = false;
            let here = materials.len();
            while let Some((_, change)) = changes.next_if(|(at, _)| *at as usize <= here) {
                self.change(&mut appearance, change, &mut is_stacking, place)?;
            }
            let end = changes.peek().map_or(faces, |(at, _)| *at as usize);
            let material = self.material(&appearance, emission, is_colored, place);
            materials.resize(end.clamp(here + 1, faces), material);
        }
        Ok(materials)
    }
}
