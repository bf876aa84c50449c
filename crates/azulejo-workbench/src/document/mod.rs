//! The document being edited, as plain data that is cheap to clone.
//!
//! A [`SceneDocument`] holds what a [`Scene`] holds, but shares it: shapes and materials are stored
//! in [`Arc`]s, and an object stores its placement separately from its shape. A clone of the
//! document is a list of pointers, undo keeps the previous document, and dragging an object changes
//! one matrix, however many triangles it has.

mod create;
mod daylight;
mod edit;
mod example;
mod marker_bounds;
mod memory;
mod outline;
mod shading_point;
mod solution;
mod task_grid;
#[cfg(test)]
pub(crate) mod tests;
mod units;

pub use create::{NewLight, NewLightKind, NewShape, NewShapeKind, TextLayout};
pub use daylight::SkySettings;
pub use edit::{Edit, EditError};
pub use example::Example;
pub use marker_bounds::light_position;
pub use outline::{PrismOutline, SIDES};
pub use shading_point::ShadingPoint;
pub(crate) use solution::same_geometry;
pub use solution::{Solution, same_light};
pub use task_grid::{MAX_POINTS, TaskGrid, TaskPlaneSettings};

use azulejo::formats::Format;
use azulejo::scene::math::Aabb;
use azulejo::scene::{
    Camera, Fog, Light, Material, MaterialId, Mesh, Object, Rgb, Rtrace, Scene, SceneBackground,
    Shape, Texture, Units,
};
use glam::{DAffine3, DVec3};
use std::collections::{HashMap, HashSet};
use std::path::PathBuf;
use std::sync::Arc;

/// Identifies an object, a light or a camera for the lifetime of the document, undo and redo
/// included.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ItemId(pub u64);

/// A picked surface point with its side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePick {
    /// The object it belongs to.
    pub item: ItemId,
    /// Position in world space.
    pub position: DVec3,
    /// Unit normal of the picked side.
    pub normal: DVec3,
}

/// A scene being edited.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneDocument {
    /// The files that objects were loaded from.
    pub source_files: Vec<SourceFile>,
    /// Objects with surfaces. Each is in an `Arc` of its own, so that an edit copies only the
    /// objects that it changes.
    pub objects: Vec<Arc<SceneObject>>,
    /// Surfaces refer to these by [`MaterialId`].
    pub materials: Vec<Arc<Material>>,
    /// Materials refer to these.
    pub textures: Vec<Arc<Texture>>,
    /// Light sources without area.
    pub lights: Vec<SceneLight>,
    /// Saved cameras.
    pub cameras: Vec<SceneCamera>,
    /// What is behind everything.
    pub background: Option<SceneBackground>,
    /// Fog in the viewport.
    pub fog: Option<Fog>,
    /// Units of length and light.
    pub units: Units,
    /// RTRACE settings of the file; dropped when other objects are added, since they describe one
    /// file only.
    pub rtrace: Option<Arc<Rtrace>>,
    /// The next free [`ItemId`].
    next: u64,
}

/// A file whose content is part of the document.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceFile {
    /// Prefix of the names of its objects.
    pub name: String,
    /// Where it was read.
    pub path: PathBuf,
    /// Its format, if it was recognized.
    pub format: Option<Format>,
    /// The recipes that belong to it and are noted beside it, in the order of their application.
    pub recipes: Vec<PathBuf>,
}

/// An object: a shape and its placement.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneObject {
    /// What selections, edits and solutions know it by.
    pub id: ItemId,
    /// Its name; groups of the file are path components, as in `house/kitchen/table`.
    pub name: String,
    /// Index of its file in [`SceneDocument::source_files`].
    pub source_file: Option<usize>,
    /// Whether the viewport omits it. It still casts and receives light.
    pub hidden: bool,
    /// Its geometry in object space; change it with [`SceneObject::set_shape`]. Instances of one mesh
    /// are objects that share a shape.
    pub shape: Arc<Shape>,
    /// Derived data needed in every frame, computed once.
    facts: Arc<ShapeFacts>,
    /// World from object; the identity for objects loaded from a file, but instances.
    pub placement: DAffine3,
}

/// A light source without area.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLight {
    /// What selections, edits and solutions know it by.
    pub id: ItemId,
    /// Index of its file in [`SceneDocument::source_files`].
    pub source_file: Option<usize>,
    /// Whether its marker is hidden in the viewport. It still emits light.
    pub hidden: bool,
    /// Its name, and what it emits from where, in world space.
    pub light: Light,
}

/// A saved camera.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneCamera {
    /// What selections, edits and solutions know it by.
    pub id: ItemId,
    /// Index of its file in [`SceneDocument::source_files`].
    pub source_file: Option<usize>,
    /// Whether its marker is hidden in the viewport.
    pub hidden: bool,
    /// Its name, and what it sees from where, in world space.
    pub camera: Camera,
}

/// Finds an element by its id with a binary search: ids increase, and new elements are appended.
fn find_by_id<T>(things: &[T], id: ItemId, of: impl Fn(&T) -> ItemId) -> Option<&T> {
    let at = things.binary_search_by_key(&id, of).ok()?;
    things.get(at)
}

/// Data derived from a shape by a pass over all its faces.
#[derive(Debug, PartialEq)]
struct ShapeFacts {
    /// Bounding box in object space.
    bounds: Aabb,
    /// The materials used, without duplicates, in the order of the faces.
    materials: Vec<MaterialId>,
}

impl ShapeFacts {
    fn of(shape: &Shape) -> ShapeFacts {
        ShapeFacts {
            bounds: bounds_of(shape),
            materials: materials_of(shape),
        }
    }
}

/// A shape that several objects may have, and what is derived from it.
#[derive(Clone)]
struct SharedShape {
    shape: Arc<Shape>,
    facts: Arc<ShapeFacts>,
}

impl SharedShape {
    fn new(shape: Shape) -> SharedShape {
        SharedShape {
            facts: Arc::new(ShapeFacts::of(&shape)),
            shape: Arc::new(shape),
        }
    }
}

impl SceneObject {
    /// The bounding box in world space.
    pub fn bounds(&self) -> Aabb {
        placed_bounds(self.facts.bounds, &self.placement)
    }

    /// Centre of the shape's bounding box in object space.
    pub fn pivot(&self) -> DVec3 {
        if self.facts.bounds.is_empty() {
            DVec3::ZERO
        } else {
            self.facts.bounds.centre()
        }
    }

    /// The materials used, without duplicates, in the order of the faces.
    pub fn materials(&self) -> &[MaterialId] {
        &self.facts.materials
    }

    /// Replaces the shape and what is derived from it.
    pub fn set_shape(&mut self, shape: Arc<Shape>) {
        self.facts = Arc::new(ShapeFacts::of(&shape));
        self.shape = shape;
    }

    /// Modifies the shape, after cloning it if it is shared.
    fn change_shape(&mut self, change: impl FnOnce(&mut Shape)) {
        change(Arc::make_mut(&mut self.shape));
        self.facts = Arc::new(ShapeFacts::of(&self.shape));
    }

    /// The object as part of a scene, with its placement applied.
    pub fn object(&self) -> Object {
        let mut shape = Shape::clone(&self.shape);
        if self.placement != DAffine3::IDENTITY {
            match &mut shape {
                Shape::Mesh(mesh) => mesh.transform(&self.placement),
                Shape::Instance(instance) => {
                    let mut mesh = instance.to_mesh();
                    mesh.transform(&self.placement);
                    shape = Shape::Mesh(mesh);
                }
                Shape::Primitive(p) => p.transform(&self.placement),
                Shape::Exact(exact) => exact.transform(&self.placement),
            }
        }
        Object::new(self.name.clone(), shape)
    }
}

/// The materials used by a shape, without duplicates, in the order of its faces.
fn materials_of(shape: &Shape) -> Vec<MaterialId> {
    let (mut materials, mut seen) = (Vec::new(), HashSet::new());
    let mut note = |m: MaterialId| {
        if seen.insert(m) {
            materials.push(m);
        }
    };
    if let Some(mesh) = shape.mesh() {
        // Consecutive faces often share a material; look up each run once.
        let mut last = None;
        for &m in &mesh.face_materials {
            if last != Some(m) {
                note(m);
                last = Some(m);
            }
        }
    }
    match shape {
        Shape::Mesh(_) | Shape::Instance(_) => {}
        Shape::Primitive(p) => note(p.material),
        Shape::Exact(exact) => exact.leaves().iter().for_each(|l| note(l.material())),
    }
    materials
}

/// The bounding box of a shape in object space.
fn bounds_of(shape: &Shape) -> Aabb {
    match shape {
        Shape::Mesh(mesh) => mesh.bounds(),
        Shape::Instance(instance) => instance.bounds(),
        Shape::Primitive(primitive) => primitive.bounds(),
        Shape::Exact(exact) => exact.bounds(),
    }
}

/// The bounding box of a transformed box.
fn placed_bounds(bounds: Aabb, map: &DAffine3) -> Aabb {
    if bounds.is_empty() || *map == DAffine3::IDENTITY {
        return bounds;
    }
    let corner = |k: u32| {
        let pick = |bit: u32, low: f64, high: f64| if k & bit == 0 { low } else { high };
        map.transform_point3(DVec3::new(
            pick(1, bounds.min.x, bounds.max.x),
            pick(2, bounds.min.y, bounds.max.y),
            pick(4, bounds.min.z, bounds.max.z),
        ))
    };
    Aabb::around((0..8).map(corner))
}

impl SceneDocument {
    /// Creates a document from a scene without copying geometry.
    pub fn of_scene(scene: Scene, source_file: Option<SourceFile>) -> SceneDocument {
        let mut document = SceneDocument {
            units: scene.units,
            rtrace: None,
            ..SceneDocument::default()
        };
        let rtrace = scene.rtrace.clone();
        document.append(scene, source_file);
        document.rtrace = rtrace.map(|numbers| Arc::new(*numbers));
        document
    }

    /// Appends a scene in the same units, as [`Scene::merge`] does; returns the ids of the new
    /// objects.
    pub fn append(&mut self, scene: Scene, source_file: Option<SourceFile>) -> Vec<ItemId> {
        let source_file = source_file.map(|b| {
            self.source_files.push(b);
            self.source_files.len() - 1
        });
        let (materials, textures) = (self.materials.len() as u32, self.textures.len() as u32);
        self.rtrace = None;
        self.textures
            .extend(scene.textures.into_iter().map(Arc::new));
        for mut material in scene.materials {
            material.renumber_pictures(textures);
            self.materials.push(Arc::new(material));
        }
        let mut ids = Vec::new();
        // By the address of the mesh, which the entries keep alive.
        let mut shared: HashMap<*const Mesh, (Arc<Mesh>, SharedShape)> = HashMap::new();
        for object in scene.objects {
            let id = match object.shape {
                Shape::Instance(instance) if instance.light.is_none() => {
                    let mesh = instance.mesh;
                    let entry = shared.entry(Arc::as_ptr(&mesh)).or_insert_with(|| {
                        let mut shape = Shape::Mesh(Mesh::clone(&mesh));
                        map_materials(&mut shape, &mut |m| m + materials);
                        (mesh, SharedShape::new(shape))
                    });
                    let shape = entry.1.clone();
                    self.push_object(object.name, shape, instance.world_from_mesh, source_file)
                }
                mut shape => {
                    // Light belongs to one place: what is lit gets a mesh of its own.
                    if let Shape::Instance(instance) = &shape {
                        shape = Shape::Mesh(instance.to_mesh());
                    }
                    if materials > 0 {
                        map_materials(&mut shape, &mut |m| m + materials);
                    }
                    self.push_shape(object.name, shape, source_file)
                }
            };
            ids.push(id);
        }
        for light in scene.lights {
            let id = self.new_id();
            self.lights.push(SceneLight {
                id,
                source_file,
                hidden: false,
                light: light.with_texture(|t| t + textures),
            });
        }
        for camera in scene.cameras {
            let id = self.new_id();
            self.cameras.push(SceneCamera {
                id,
                source_file,
                hidden: false,
                camera,
            });
        }
        let background = scene.background.map(|b| b.with_texture(|t| t + textures));
        self.background = self.background.or(background);
        self.fog = self.fog.or(scene.fog);
        ids
    }

    /// Adds an object with the identity as its placement.
    fn push_shape(&mut self, name: String, shape: Shape, source_file: Option<usize>) -> ItemId {
        let shape = SharedShape::new(shape);
        self.push_object(name, shape, DAffine3::IDENTITY, source_file)
    }

    fn push_object(
        &mut self,
        name: String,
        SharedShape { shape, facts }: SharedShape,
        placement: DAffine3,
        source_file: Option<usize>,
    ) -> ItemId {
        let id = self.new_id();
        self.objects.push(Arc::new(SceneObject {
            id,
            name,
            source_file,
            hidden: false,
            shape,
            facts,
            placement,
        }));
        id
    }

    fn new_id(&mut self) -> ItemId {
        self.next += 1;
        ItemId(self.next)
    }

    /// The complete scene with all placements applied and without solved light.
    pub fn scene(&self) -> Scene {
        self.scene_of(|item| {
            let mut object = item.object();
            solution::remove_irradiance(&mut object.shape);
            object
        })
    }

    /// The scene with the light of a solution, if it is valid for this document; returns whether it
    /// is.
    pub fn lit_scene(&self, solution: Option<&Solution>) -> (Scene, bool) {
        match solution.filter(|s| s.is_of(self)) {
            None => (self.scene(), false),
            Some(solution) => {
                let lit = self.scene_of(|item| match solution.shape(item.id) {
                    Some(shape) => Object::new(item.name.clone(), Shape::clone(shape)),
                    None => item.object(),
                });
                (lit, true)
            }
        }
    }

    fn scene_of(&self, object: impl Fn(&SceneObject) -> Object) -> Scene {
        Scene {
            objects: self.objects.iter().map(|item| object(item)).collect(),
            materials: self.materials.iter().map(|m| Material::clone(m)).collect(),
            textures: self.textures.iter().map(|t| Texture::clone(t)).collect(),
            lights: self.lights.iter().map(|l| l.light.clone()).collect(),
            cameras: self.cameras.iter().map(|c| c.camera.clone()).collect(),
            background: self.background,
            fog: self.fog,
            units: self.units,
            rtrace: self.rtrace.as_deref().cloned().map(Box::new),
        }
    }

    /// The scene reduced to its emitters.
    pub fn emitters_scene(&self) -> Scene {
        let mut lamps = self.clone();
        let shines = |m: MaterialId| {
            let material = self.materials.get(m as usize);
            material.is_some_and(|m| m.is_emitter())
        };
        (lamps.objects).retain(|item| item.materials().iter().any(|&m| shines(m)));
        lamps.rtrace = None;
        // Textures are large, and the mean of those that are emitted is enough.
        let textures = std::mem::take(&mut lamps.textures);
        for material in lamps
            .materials
            .iter_mut()
            .filter(|m| m.pictures().next().is_some())
        {
            let material = Arc::make_mut(material);
            if let Some(id) = material.emission_picture {
                let texture = textures.get(id as usize);
                material.emission *= texture.map_or(Rgb::BLACK, |t| t.mean());
            }
            material.drop_pictures();
        }
        lamps.scene()
    }

    /// Whether there are no objects, lights or cameras.
    pub fn is_empty(&self) -> bool {
        self.objects.is_empty() && self.lights.is_empty() && self.cameras.is_empty()
    }

    /// Forgets which files the content came from.
    pub(crate) fn detach_files(&mut self) {
        self.source_files.clear();
        (self.objects.iter_mut()).for_each(|i| Arc::make_mut(i).source_file = None);
        self.lights.iter_mut().for_each(|l| l.source_file = None);
        self.cameras.iter_mut().for_each(|c| c.source_file = None);
    }

    /// The object with this id.
    pub fn object(&self, id: ItemId) -> Option<&SceneObject> {
        find_by_id(&self.objects, id, |i| i.id).map(|item| &**item)
    }

    /// The light with this id.
    pub fn light(&self, id: ItemId) -> Option<&SceneLight> {
        find_by_id(&self.lights, id, |l| l.id)
    }

    /// The camera with this id.
    pub fn camera(&self, id: ItemId) -> Option<&SceneCamera> {
        find_by_id(&self.cameras, id, |c| c.id)
    }

    /// Whether an object, light or camera has this id.
    pub fn has(&self, id: ItemId) -> bool {
        self.object(id).is_some() || self.light(id).is_some() || self.camera(id).is_some()
    }

    /// Whether it is hidden; `None` if it does not exist.
    pub fn is_hidden(&self, id: ItemId) -> Option<bool> {
        let item = self.object(id).map(|i| i.hidden);
        let lamp = || self.light(id).map(|l| l.hidden);
        let camera = || self.camera(id).map(|c| c.hidden);
        item.or_else(lamp).or_else(camera)
    }

    /// All hidden objects, lights and cameras.
    pub fn hidden(&self) -> Vec<ItemId> {
        let items = self.objects.iter().filter(|i| i.hidden).map(|i| i.id);
        let lights = self.lights.iter().filter(|l| l.hidden).map(|l| l.id);
        let cameras = self.cameras.iter().filter(|c| c.hidden).map(|c| c.id);
        items.chain(lights).chain(cameras).collect()
    }

    /// The name of an object, a light or a camera.
    pub fn name(&self, id: ItemId) -> Option<&str> {
        let item = self.object(id).map(|i| i.name.as_str());
        let lamp = || self.light(id).map(|l| l.light.name.as_str());
        let camera = || self.camera(id).map(|c| c.camera.name.as_str());
        item.or_else(lamp).or_else(camera)
    }

    /// The bounding box of all objects, or of those in `ids`.
    pub fn bounds(&self, ids: Option<&[ItemId]>) -> Aabb {
        let around = |all: Aabb, item: &SceneObject| all.union(item.bounds());
        match ids {
            None => (self.objects.iter()).fold(Aabb::EMPTY, |all, item| around(all, item)),
            Some(ids) => {
                let items = ids.iter().filter_map(|&id| self.object(id));
                items.fold(Aabb::EMPTY, around)
            }
        }
    }

    /// The bounding box of the model: of all objects but the floor and the lamps of a studio, which
    /// stand far around it, unless there is nothing else.
    pub fn model_bounds(&self) -> Aabb {
        let of_model = self.objects.iter().filter(|item| {
            item.source_file.is_some() || !azulejo::surroundings::is_studio_part(&item.name)
        });
        let bounds = of_model.fold(Aabb::EMPTY, |all, item| all.union(item.bounds()));
        if bounds.is_empty() {
            self.bounds(None)
        } else {
            bounds
        }
    }

    /// Number of polygons, counting each exact shape as one.
    pub fn face_count(&self) -> usize {
        let faces = |item: &SceneObject| match &*item.shape {
            Shape::Mesh(mesh) => mesh.faces.len(),
            Shape::Instance(instance) => instance.mesh.faces.len(),
            Shape::Primitive(_) => 1,
            Shape::Exact(exact) => exact.leaves().len(),
        };
        self.objects.iter().map(|item| faces(item)).sum()
    }

    /// Whether an object emits light.
    pub fn shines(&self, item: &SceneObject) -> bool {
        item.materials().iter().any(|&m| {
            let material = self.materials.get(m as usize);
            material.is_some_and(|m| m.is_emitter())
        })
    }

    /// Whether anything emits light.
    pub fn has_light(&self) -> bool {
        let shines = |m: MaterialId| {
            let material = self.materials.get(m as usize);
            material.is_some_and(|m| m.is_emitter())
        };
        !self.lights.is_empty()
            || (self.materials.iter().any(|m| m.is_emitter())
                && (self.objects.iter()).any(|i| i.materials().iter().any(|&m| shines(m))))
    }
}

/// Applies `change` to every material index in a shape.
fn map_materials(shape: &mut Shape, change: &mut impl FnMut(MaterialId) -> MaterialId) {
    match shape {
        Shape::Mesh(mesh) => mesh.face_materials.iter_mut().for_each(|m| *m = change(*m)),
        Shape::Instance(instance) => {
            let mesh = Arc::make_mut(&mut instance.mesh);
            mesh.face_materials.iter_mut().for_each(|m| *m = change(*m));
        }
        Shape::Primitive(p) => p.material = change(p.material),
        Shape::Exact(exact) => exact.map_materials(change),
    }
}
