//! Converts a scene to its canonical document.

use super::brdf::GrfReflection;
use super::document::{
    AppearanceChange, AreaLight, BlockKind, DefinitionBody, FinishNote, GrfBlock, GrfDefinition,
    GrfDocument, GrfName, MaterialNote, MeshBlock, MeshInstanceBlock, NameKind, ObjectNotes,
    OpacityNote, PrimitiveBlock, SourcePosition, VertexColumn, VertexList,
};
use super::has_area;
use super::materials::surface;
use super::solids::{Figures, exact_block};
use super::surroundings::{self, BackplateBlock, EnvironmentBlock};
use azulejo_scene::brdf::{Description, Model};
use azulejo_scene::{
    Attribute, BackIrradiance, Brdf, Faces, LightKind, Material, MaterialId, Mesh, MeshInstance,
    NumberPicture, Object, Primitive, PrimitiveKind, Rgb, Scene, SceneBackground, Shape, TextureId,
    Units, WrapMode,
};
use glam::{DVec2, DVec3};
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

impl GrfDocument {
    /// The canonical document of a scene that satisfies [`Scene::validate`].
    ///
    /// Materials and textures become definitions around everything else, under their own names if
    /// these are identifiers. Normals and texture coordinates per corner become attributes of
    /// vertices, which are split where corners differ. Pixels of textures are omitted.
    pub fn from_scene(scene: &Scene) -> GrfDocument {
        GrfDocument::with_pictures(scene, scene.textures.iter().map(|t| t.path.as_str()))
    }

    /// The same, with these image files for its textures.
    pub(super) fn with_pictures<'s>(
        scene: &Scene,
        pictures: impl Iterator<Item = &'s str>,
    ) -> GrfDocument {
        let names = GrfNames::new(scene);
        // Put before the definitions what has no materials: surroundings name their pictures by path.
        let mut outside = Vec::new();
        if scene.units != Units::default() {
            outside.push(BlockKind::Units(scene.units));
        }
        let pictures: Vec<&str> = pictures.collect();
        let picture = |id: TextureId| pictures[id as usize].to_owned();
        outside.extend(scene.background.map(|background| match background {
            SceneBackground::Color(color) => BlockKind::Background(color),
            SceneBackground::Environment(environment) => {
                BlockKind::Environment(EnvironmentBlock::new(None, environment, picture))
            }
            SceneBackground::Backplate(plate) => BlockKind::Backplate(Box::new(BackplateBlock {
                picture: picture(plate.texture),
                plate,
            })),
        }));
        outside.extend(scene.fog.map(BlockKind::Fog));
        outside.extend(scene.cameras.iter().cloned().map(BlockKind::Camera));
        outside.extend(scene.lights.iter().map(|light| match light.kind {
            LightKind::Environment(environment) => BlockKind::Environment(EnvironmentBlock::new(
                Some(&light.name),
                environment,
                picture,
            )),
            _ => BlockKind::Light(light.clone()),
        }));
        // Define materials and their textures, not those of surroundings alone; notes add what these cannot express.
        let mut inside = Vec::new();
        let mut definitions = Vec::new();
        let only_around = surroundings::pictures_of(scene);
        for (id, (path, name)) in pictures.iter().zip(&names.textures).enumerate() {
            if !only_around.contains(&(id as TextureId)) {
                let wrap = scene
                    .textures
                    .get(id)
                    .map_or_else(Default::default, |t| t.wrap);
                definitions.push(texture_definition(name, path, wrap, &mut inside));
            }
        }
        for (material, name) in scene.materials.iter().zip(&names.materials) {
            let (definition, note) = material_definition(name, material, &names.textures);
            definitions.push(definition);
            inside.extend(note.map(|note| BlockKind::Material(Box::new(note))));
        }
        // Figures precede the solids that extrude them.
        let figures = names.figures.blocks.iter().cloned();
        inside.extend(figures.map(BlockKind::Figure));
        inside.extend(scene.objects.iter().map(|o| names.object(scene, o)));
        // A scope without definitions has no meaning: the blocks stand beside the others.
        if definitions.is_empty() {
            outside.extend(inside);
        } else {
            outside.push(BlockKind::Definitions {
                definitions,
                blocks: Some(placed(inside)),
            });
        }
        GrfDocument {
            blocks: placed(outside),
            ..GrfDocument::default()
        }
    }
}

fn placed(kinds: Vec<BlockKind>) -> Vec<GrfBlock> {
    let place = SourcePosition::default();
    kinds
        .into_iter()
        .map(|kind| GrfBlock { place, kind })
        .collect()
}

/// Identifiers of a scene's materials, textures and figures.
pub(super) struct GrfNames {
    pub materials: Vec<GrfName>,
    pub textures: Vec<GrfName>,
    figures: Figures,
    /// For each shared mesh the index of its first object, and its number.
    shared_meshes: HashMap<*const Mesh, (usize, usize)>,
}

impl GrfNames {
    pub fn new(scene: &Scene) -> GrfNames {
        let materials = scene.materials.iter().map(|m| &*m.name);
        let textures = scene.textures.iter().map(|_| "");
        GrfNames {
            materials: identifiers(materials, "m"),
            textures: identifiers(textures, "t"),
            figures: Figures::of(scene),
            shared_meshes: shared_meshes(scene),
        }
    }

    fn object(&self, scene: &Scene, object: &Object) -> BlockKind {
        let notes = ObjectNotes {
            name: object.name.clone(),
            ..ObjectNotes::default()
        };
        match &object.shape {
            Shape::Mesh(mesh) => BlockKind::Mesh(Box::new(self.mesh(scene, mesh, notes))),
            Shape::Instance(instance) => self.instance(scene, object, instance, notes),
            Shape::Primitive(p) => self.primitive(scene, p, notes),
            Shape::Exact(exact) => {
                let block = exact_block(exact, &self.figures, &self.materials, notes);
                BlockKind::Exact(Box::new(block))
            }
        }
    }

    /// The mesh itself with its name for the first of its instances, and its name alone for the others.
    fn instance(
        &self,
        scene: &Scene,
        object: &Object,
        instance: &MeshInstance,
        notes: ObjectNotes,
    ) -> BlockKind {
        let number = self.shared_meshes[&Arc::as_ptr(&instance.mesh)];
        let (index, name) = (number.0, GrfName::from(format!("s{}", number.1)));
        if !std::ptr::eq(object, &raw const scene.objects[index]) {
            return BlockKind::MeshInstance(Box::new(MeshInstanceBlock {
                notes,
                ..MeshInstanceBlock::from_instance(name, instance)
            }));
        }
        let mut mesh = Mesh::clone(&instance.mesh);
        if let Some(light) = instance.light.as_deref() {
            mesh.irradiance.clone_from(&light.irradiance);
            mesh.irradiance_error.clone_from(&light.error);
            mesh.back.clone_from(&light.back);
        }
        let mut block = self.mesh(scene, &mesh, notes);
        block.notes.shared_mesh = Some((name, instance.world_from_mesh));
        BlockKind::Mesh(Box::new(block))
    }

    fn material(&self, id: MaterialId) -> AppearanceChange {
        AppearanceChange::Use(NameKind::Brdf, self.materials[id as usize].clone())
    }

    fn mesh(&self, scene: &Scene, mesh: &Mesh, notes: ObjectNotes) -> MeshBlock {
        let radiance = common_radiance(scene, mesh);
        let mut head = Vec::new();
        let mut changes = Vec::new();
        for run in material_runs(&mesh.face_materials) {
            let material = mesh.face_materials[run];
            let textures = &scene.materials[material as usize].textures;
            let expressed = std::iter::once(self.material(material))
                .chain(textures.iter().map(|t| self.texture(*t)));
            changes.extend(expressed.map(|change| (run as u32, change)));
        }
        // A single material goes before the vertices; an emitting mesh has no appearance there.
        if radiance.is_none() && changes.iter().all(|(at, _)| *at == 0) {
            head = changes.drain(..).map(|(_, change)| change).collect();
        }
        MeshBlock {
            is_light: radiance.is_some(),
            radiance,
            head,
            changes,
            ..polygons(Cow::Borrowed(mesh), notes)
        }
    }

    fn texture(&self, id: TextureId) -> AppearanceChange {
        AppearanceChange::Use(NameKind::Texture, self.textures[id as usize].clone())
    }

    /// An emitting parallelogram is GRF's own area light; everything else is an extension.
    fn primitive(&self, scene: &Scene, p: &Primitive, notes: ObjectNotes) -> BlockKind {
        let notes = ObjectNotes {
            material: Some(self.materials[p.material as usize].clone()),
            light: p.light.clone(),
            ..notes
        };
        let map = p.world_from_object;
        let (a, b) = (map.matrix3.x_axis, map.matrix3.y_axis);
        let material = &scene.materials[p.material as usize];
        // The third axis of a parallelogram has no meaning.
        let is_area_light =
            p.kind == PrimitiveKind::Square && material.is_emitter() && has_area(a, b);
        if is_area_light {
            return BlockKind::AreaLight(Box::new(AreaLight {
                corner: map.translation,
                edges: [a, b],
                radiance: Some(material.emission),
                notes,
            }));
        }
        BlockKind::Primitive(Box::new(PrimitiveBlock {
            kind: p.kind,
            map,
            notes,
        }))
    }
}

/// For each shared mesh the index of its first object, and its number.
fn shared_meshes(scene: &Scene) -> HashMap<*const Mesh, (usize, usize)> {
    let mut known = HashMap::new();
    for (index, object) in scene.objects.iter().enumerate() {
        if let Shape::Instance(instance) = &object.shape {
            let number = known.len();
            let entry = known.entry(Arc::as_ptr(&instance.mesh));
            entry.or_insert((index, number));
        }
    }
    known
}

/// Distinct identifiers: names that are valid and not taken yet, or a letter and a number.
fn identifiers<'n>(names: impl Iterator<Item = &'n str>, letter: &str) -> Vec<GrfName> {
    let names: Vec<&str> = names.collect();
    let given: HashSet<&str> = names.iter().copied().collect();
    let mut taken: HashSet<&str> = HashSet::new();
    let mut next = 0;
    let mut fresh = || loop {
        let name = format!("{letter}{next}");
        next += 1;
        if !given.contains(&*name) {
            return GrfName::from(name);
        }
    };
    let mut out = Vec::with_capacity(names.len());
    for name in names {
        let is_free = is_identifier(name) && taken.insert(name);
        out.push(if is_free {
            GrfName::from(name)
        } else {
            fresh()
        });
    }
    out
}

/// Whether a name can be written as it is. Keywords cannot, for the sake of readability.
fn is_identifier(name: &str) -> bool {
    const KEYWORDS: [&str; 9] = [
        "begin", "end", "def", "use", "none", "brdf", "texture", "rgb", "ext",
    ];
    let is_word = |b: u8| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'$');
    name.bytes().all(is_word)
        && name.bytes().next().is_some_and(|b| !b.is_ascii_digit())
        && !KEYWORDS.iter().any(|k| name.eq_ignore_ascii_case(k))
}

/// Whether a path can be written between quotes as it is.
fn is_plain_path(path: &str) -> bool {
    !path.contains(|c: char| c == '"' || c.is_control())
}

fn texture_definition(
    name: &GrfName,
    path: &str,
    wrap: [WrapMode; 2],
    notes: &mut Vec<BlockKind>,
) -> GrfDefinition {
    let mut plain = path.to_owned();
    if !is_plain_path(path) || wrap != [WrapMode::Repeat; 2] {
        plain.retain(|c| c != '"' && !c.is_control());
        notes.push(BlockKind::Texture {
            of: name.clone(),
            path: path.to_owned(),
            wrap,
        });
    }
    GrfDefinition {
        name: name.clone(),
        body: DefinitionBody::Texture(GrfName::from(plain)),
    }
}

/// A material as a GRF definition, and the attributes that this cannot express.
fn material_definition(
    name: &GrfName,
    material: &Material,
    textures: &[GrfName],
) -> (GrfDefinition, Option<MaterialNote>) {
    let brdf = brdf_of(material);
    let mut expressed = surface(name, &brdf).material;
    expressed.limit_reflectance();
    let unless = |same: bool, color: Rgb| (!same).then_some(color);
    let note = MaterialNote {
        of: name.clone(),
        name: (material.name != expressed.name).then(|| material.name.clone()),
        diffuse: unless(material.diffuse == expressed.diffuse, material.diffuse),
        mirror: unless(material.mirror == expressed.mirror, material.mirror),
        emission: unless(!material.is_emitter(), material.emission),
        emission_texture: material
            .emission_picture
            .map(|t| textures[t as usize].clone()),
        emits_back: material.emits_back,
        ior: material.dielectric.map(|d| d.ior),
        transmittance: material.dielectric.map(|d| d.transmittance),
        thin: material.dielectric.is_some_and(|d| d.thin),
        sidedness: material.sidedness,
        // If there is any texture, every material lists its own: GRF has no way to write "none".
        textures: (!textures.is_empty()).then(|| {
            let named = |&t: &TextureId| textures[t as usize].clone();
            material.textures.iter().map(named).collect()
        }),
        brdf_file: match &material.brdf {
            Some(brdf) if expressed.brdf.is_none() => Some(Arc::new(brdf.into())),
            _ => None,
        },
        opacity: material.opacity.map(|o| OpacityNote {
            constant: o.constant,
            picture: o
                .picture
                .map(|p| (textures[p.texture as usize].clone(), p.channel)),
            mode: o.mode,
        }),
        finish: material.finish.map(|f| {
            let named = |p: NumberPicture| (textures[p.texture as usize].clone(), p.channel);
            FinishNote {
                base: f.base,
                metallic: f.metallic,
                roughness: f.roughness,
                metallic_picture: f.metallic_picture.map(named),
                roughness_picture: f.roughness_picture.map(named),
            }
        }),
        relief: material
            .relief
            .map(|r| (textures[r.texture as usize].clone(), r.kind)),
    };
    let definition = GrfDefinition {
        name: name.clone(),
        body: DefinitionBody::Brdf(Arc::new(brdf)),
    };
    (definition, (!note.is_empty()).then_some(note))
}

/// The brdf that expresses a material best.
pub(super) fn brdf_of(material: &Material) -> GrfReflection {
    match &material.brdf {
        Some(brdf) if file_of(brdf).is_none_or(is_plain_path) => brdf.into(),
        _ => GrfReflection {
            description: plain_brdf(material.diffuse, material.mirror),
            brdf: None,
        },
    }
}

/// The name of the file that contains a brdf.
fn file_of(brdf: &Brdf) -> Option<&str> {
    match brdf.description() {
        Description::File { path, .. } => Some(path),
        _ => None,
    }
}

fn plain_brdf(diffuse: Rgb, mirror: Rgb) -> Description {
    let matt = Model::new("diffuse", [("kd", diffuse.into())]);
    let mirror_model = Model::new("specular", [("ks", mirror.into())]);
    if mirror.is_black() {
        Description::Model(matt)
    } else if diffuse.is_black() {
        Description::Model(mirror_model)
    } else {
        Description::Combination(vec![(1.0, matt), (1.0, mirror_model)])
    }
}

/// The radiance of a mesh whose faces all emit equally.
fn common_radiance(scene: &Scene, mesh: &Mesh) -> Option<Rgb> {
    let material = |m: MaterialId| &scene.materials[m as usize];
    let has_picture = |&m: &MaterialId| material(m).emission_picture.is_some();
    if mesh.face_materials.iter().any(has_picture) {
        return None;
    }
    let emission = |m: MaterialId| material(m).emission;
    let (first, rest) = mesh.face_materials.split_first()?;
    let radiance = emission(*first);
    let is_common = rest.iter().all(|&m| emission(m) == radiance);
    (is_common && !radiance.is_black()).then_some(radiance)
}

/// The vertices, faces and notes of a mesh, without its appearance.
pub(super) fn polygons(mesh: Cow<'_, Mesh>, notes: ObjectNotes) -> MeshBlock {
    let (mesh, shared) = split_corners(mesh);
    let mesh = mesh.into_owned();
    MeshBlock {
        vertices: VertexList {
            positions: mesh.positions,
            normals: column(mesh.normals),
            irradiance: VertexColumn::full(mesh.irradiance),
            uvs: column(mesh.uvs),
            colors: VertexColumn::full(mesh.colors),
            named_colors: Vec::new(),
        },
        faces: mesh.faces,
        notes: ObjectNotes {
            smoothing: mesh.smoothing,
            shared,
            irradiance_error: mesh.irradiance_error,
            back: mesh.back,
            ..notes
        },
        ..MeshBlock::default()
    }
}

/// The faces at which the material changes, including the first face.
fn material_runs(materials: &[MaterialId]) -> impl Iterator<Item = usize> {
    (0..materials.len()).filter(|&f| f == 0 || materials[f] != materials[f - 1])
}

fn column<T: Copy + Default>(attribute: Option<Attribute<T>>) -> VertexColumn<T> {
    VertexColumn::full(attribute.map_or_else(Vec::new, |a| a.values))
}

/// A mesh whose normals and texture coordinates are stored per vertex: a vertex whose corners
/// differ is split. Vertices keep their indices for their first corner; copies are appended. Also
/// the original of each copy.
fn split_corners(mesh: Cow<'_, Mesh>) -> (Cow<'_, Mesh>, Vec<u32>) {
    let by_corner = |has: Option<bool>| has.unwrap_or(false);
    let normals = by_corner(mesh.normals.as_ref().map(|a| a.corners.is_some()));
    let uvs = by_corner(mesh.uvs.as_ref().map(|a| a.corners.is_some()));
    if !normals && !uvs {
        return (mesh, Vec::new());
    }
    let mut split = VertexSplitter::new(&mesh);
    let mut faces = Faces::default();
    let mut corners = Vec::new();
    for face in 0..mesh.faces.len() {
        corners.clear();
        for corner in mesh.faces.corner_range(face) {
            corners.push(split.vertex(corner));
        }
        faces.push(&corners);
    }
    let copies = split.combinations.iter().skip(mesh.positions.len());
    let shared = copies.flatten().map(|c| c[0]).collect();
    (Cow::Owned(split.mesh(faces)), shared)
}

/// Indices of a vertex's position, normal and texture coordinate after splitting.
type VertexCombination = [u32; 3];

struct VertexSplitter<'m> {
    mesh: &'m Mesh,
    /// For each vertex, old and new; `None` for an old one that no corner has used yet.
    combinations: Vec<Option<VertexCombination>>,
    known: HashMap<VertexCombination, u32>,
}

impl VertexSplitter<'_> {
    fn new(mesh: &Mesh) -> VertexSplitter<'_> {
        VertexSplitter {
            mesh,
            combinations: vec![None; mesh.positions.len()],
            known: HashMap::new(),
        }
    }

    fn vertex(&mut self, corner: usize) -> u32 {
        let position = self.mesh.faces.corners[corner];
        let combination = [
            position,
            index(&self.mesh.normals, corner, position),
            index(&self.mesh.uvs, corner, position),
        ];
        if let Some(&known) = self.known.get(&combination) {
            return known;
        }
        let first = &mut self.combinations[position as usize];
        let vertex = if first.is_none() {
            *first = Some(combination);
            position
        } else {
            self.combinations.push(Some(combination));
            self.combinations.len() as u32 - 1
        };
        self.known.insert(combination, vertex);
        vertex
    }

    fn mesh(self, faces: Faces) -> Mesh {
        let old = self.mesh;
        let position = |v: usize| self.combinations[v].map_or(v, |c| c[0] as usize);
        let count = self.combinations.len();
        let taken = |list: &Vec<Rgb>| {
            if list.is_empty() {
                Vec::new()
            } else {
                (0..count).map(|v| list[position(v)]).collect()
            }
        };
        Mesh {
            positions: (0..count).map(|v| old.positions[position(v)]).collect(),
            normals: self.attribute(&old.normals, 1, DVec3::Z),
            uvs: self.attribute(&old.uvs, 2, DVec2::ZERO),
            // GRF has no lightmaps.
            lightmap_uvs: None,
            colors: taken(&old.colors),
            irradiance: taken(&old.irradiance),
            irradiance_error: taken(&old.irradiance_error),
            back: old.back.as_deref().map(|back| {
                Box::new(BackIrradiance {
                    irradiance: (0..count).map(|v| back.irradiance[position(v)]).collect(),
                    error: taken(&back.error),
                })
            }),
            faces,
            face_materials: old.face_materials.clone(),
            smoothing: old.smoothing.clone(),
            history: old.history,
        }
    }

    /// An attribute per vertex; `unused` for vertices without faces.
    fn attribute<T: Copy>(
        &self,
        attribute: &Option<Attribute<T>>,
        part: usize,
        unused: T,
    ) -> Option<Attribute<T>> {
        let attribute = attribute.as_ref()?;
        let value = |c: &Option<VertexCombination>| {
            c.map_or(unused, |c| attribute.values[c[part] as usize])
        };
        Some(Attribute::per_vertex(
            self.combinations.iter().map(value).collect(),
        ))
    }
}

/// The index of a corner's value in an attribute.
fn index<T>(attribute: &Option<Attribute<T>>, corner: usize, vertex: u32) -> u32 {
    match attribute {
        None => 0,
        Some(a) => a.corners.as_ref().map_or(vertex, |corners| corners[corner]),
    }
}
