//! What is being worked on, as plain data that is cheap to copy.
//!
//! A [`SceneDocument`] holds what a [`Scene`] holds, but shares it: shapes and materials stand behind
//! [`Arc`]s and an object keeps its placement beside its shape. So a copy of the whole document
//! is a list of pointers, undo is the document before, and dragging an object moves one matrix
//! however many triangles hang on it.

mod create;
mod edit;
mod marker_bounds;
mod memory;
mod outline;
mod shading_point;
mod solution;
#[cfg(test)]
pub(crate) mod tests;
mod units;

pub use create::{NewLight, NewLightKind, NewShape, NewShapeKind, TextLayout};
pub use edit::{Edit, EditError};
pub use marker_bounds::light_position;
pub use outline::{PrismOutline, SIDES};
pub use shading_point::ShadingPoint;
pub use solution::{Solution, same_light};

use azulejo::formats::Format;
use azulejo::scene::math::Aabb;
use azulejo::scene::{
    Camera, Fog, Light, Material, MaterialId, Object, Rgb, Rtrace, Scene, Shape, Texture, Units,
};
use glam::{DAffine3, DVec3};
use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::Arc;

/// Names one thing of a document for as long as it exists, undo and redo included.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ItemId(pub u64);

/// A model that is being lit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneDocument {
    /// Where things come from; what is made by hand has none.
    pub source_files: Vec<SourceFile>,
    /// What has a surface. Each stands behind a pointer of its own: of a thousand objects an edit
    /// copies those that it changes.
    pub objects: Vec<Arc<SceneObject>>,
    /// What surfaces refer to by [`MaterialId`].
    pub materials: Vec<Arc<Material>>,
    /// What materials refer to.
    pub textures: Vec<Arc<Texture>>,
    /// Lights without area.
    pub lights: Vec<SceneLight>,
    /// Saved viewpoints.
    pub cameras: Vec<SceneCamera>,
    /// Radiance where there is no surface.
    pub background: Option<Rgb>,
    /// What hides far surfaces.
    pub fog: Option<Fog>,
    /// What the numbers mean.
    pub units: Units,
    /// RTRACE's numbers; they describe one file as it was and do not outlive other objects.
    pub rtrace: Option<Arc<Rtrace>>,
    /// The number of the next [`ItemId`].
    next: u64,
}

/// One file's content in a document.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceFile {
    /// What its objects' names begin with.
    pub name: String,
    /// The file.
    pub path: PathBuf,
    /// Its format, if it was recognised.
    pub format: Option<Format>,
}

/// An object: a shape and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneObject {
    /// Its name for good.
    pub id: ItemId,
    /// Its name for people; groups of a file are parts of it, as in `house/kitchen/table`.
    pub name: String,
    /// Index of its file in [`SceneDocument::source_files`].
    pub source_file: Option<usize>,
    /// Whether the viewport leaves it out. It goes on casting and receiving light.
    pub hidden: bool,
    /// Its geometry before it is placed; [`SceneObject::set_shape`] changes it.
    pub shape: Arc<Shape>,
    /// What is asked of the shape in every frame, found once.
    facts: Arc<ShapeFacts>,
    /// Where it stands; identity for what comes from a file.
    pub placement: DAffine3,
}

/// A light without area.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLight {
    /// Its name for good.
    pub id: ItemId,
    /// Index of its file in [`SceneDocument::source_files`].
    pub source_file: Option<usize>,
    /// Whether its sign is left out of the viewport. It goes on shining.
    pub hidden: bool,
    /// What it is.
    pub light: Light,
}

/// A saved viewpoint.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneCamera {
    /// Its name for good.
    pub id: ItemId,
    /// Index of its file in [`SceneDocument::source_files`].
    pub source_file: Option<usize>,
    /// Whether its sign is left out of the viewport.
    pub hidden: bool,
    /// What it sees.
    pub camera: Camera,
}

/// Finds a thing by its name for good: names count up, and what is added goes to the end.
fn in_order<T>(things: &[T], id: ItemId, of: impl Fn(&T) -> ItemId) -> Option<&T> {
    let at = things.binary_search_by_key(&id, of).ok()?;
    things.get(at)
}

/// What takes a walk over all faces to find.
#[derive(Debug, PartialEq)]
struct ShapeFacts {
    /// The box around the shape where it was made.
    bounds: Aabb,
    /// Its materials, each once, in the order of its faces.
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

impl SceneObject {
    /// The smallest box around it, in the world.
    pub fn bounds(&self) -> Aabb {
        placed_bounds(self.facts.bounds, &self.placement)
    }

    /// Its materials, each once, in the order of its faces.
    pub fn materials(&self) -> &[MaterialId] {
        &self.facts.materials
    }

    /// Gives it another shape.
    pub fn set_shape(&mut self, shape: Arc<Shape>) {
        self.facts = Arc::new(ShapeFacts::of(&shape));
        self.shape = shape;
    }

    /// Changes its shape; a shape that others have too is copied first.
    fn change_shape(&mut self, change: impl FnOnce(&mut Shape)) {
        change(Arc::make_mut(&mut self.shape));
        self.facts = Arc::new(ShapeFacts::of(&self.shape));
    }

    /// The object as a scene has it: placed.
    pub fn object(&self) -> Object {
        let mut shape = Shape::clone(&self.shape);
        if self.placement != DAffine3::IDENTITY {
            match &mut shape {
                Shape::Mesh(mesh) => mesh.transform(&self.placement),
                Shape::Primitive(p) => p.transform(&self.placement),
                Shape::Exact(exact) => exact.transform(&self.placement),
            }
        }
        Object::new(self.name.clone(), shape)
    }
}

/// The materials of a shape, each once, in the order of its faces.
fn materials_of(shape: &Shape) -> Vec<MaterialId> {
    let (mut found, mut seen) = (Vec::new(), HashSet::new());
    let mut note = |m: MaterialId| {
        if seen.insert(m) {
            found.push(m);
        }
    };
    match shape {
        Shape::Mesh(mesh) => {
            // Runs of faces share a material; each run is looked up once.
            let mut last = None;
            for &m in &mesh.face_materials {
                if last != Some(m) {
                    note(m);
                    last = Some(m);
                }
            }
        }
        Shape::Primitive(p) => note(p.material),
        Shape::Exact(exact) => exact.leaves().iter().for_each(|l| note(l.material())),
    }
    found
}

/// The smallest box around a shape where it was made.
fn bounds_of(shape: &Shape) -> Aabb {
    match shape {
        Shape::Mesh(mesh) => mesh.bounds(),
        Shape::Primitive(primitive) => primitive.bounds(),
        Shape::Exact(exact) => exact.bounds(),
    }
}

/// A box around a box under a map.
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
    /// A document of one scene. Nothing is copied.
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

    /// Adds a scene that already has this document's units, as [`Scene::merge`] does; returns the
    /// new objects.
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
            material.textures.iter_mut().for_each(|t| *t += textures);
            self.materials.push(Arc::new(material));
        }
        let mut ids = Vec::new();
        for mut object in scene.objects {
            if materials > 0 {
                map_materials(&mut object.shape, &mut |m| m + materials);
            }
            ids.push(self.push_shape(object.name, object.shape, source_file));
        }
        for light in scene.lights {
            let id = self.new_id();
            self.lights.push(SceneLight {
                id,
                source_file,
                hidden: false,
                light,
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
        self.background = self.background.or(scene.background);
        self.fog = self.fog.or(scene.fog);
        ids
    }

    /// Adds an object where it was made.
    fn push_shape(&mut self, name: String, shape: Shape, source_file: Option<usize>) -> ItemId {
        let id = self.new_id();
        self.objects.push(Arc::new(SceneObject {
            id,
            name,
            source_file,
            hidden: false,
            facts: Arc::new(ShapeFacts::of(&shape)),
            shape: Arc::new(shape),
            placement: DAffine3::IDENTITY,
        }));
        id
    }

    fn new_id(&mut self) -> ItemId {
        self.next += 1;
        ItemId(self.next)
    }

    /// The scene that the passes read: everything, in its place, without light on it.
    pub fn scene(&self) -> Scene {
        self.scene_of(|item| {
            let mut object = item.object();
            solution::strip(&mut object.shape);
            object
        })
    }

    /// The scene with the light of a solution on it, if that is still this document's; whether
    /// it was.
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

    /// The scene of what shines alone.
    pub fn lamps_scene(&self) -> Scene {
        let mut lamps = self.clone();
        let shines = |m: MaterialId| {
            let material = self.materials.get(m as usize);
            material.is_some_and(|m| m.is_emitter())
        };
        (lamps.objects).retain(|item| item.materials().iter().any(|&m| shines(m)));
        lamps.rtrace = None;
        // Pictures on them do not shine, and are large.
        lamps.textures.clear();
        for material in lamps
            .materials
            .iter_mut()
            .filter(|m| !m.textures.is_empty())
        {
            Arc::make_mut(material).textures.clear();
        }
        lamps.scene()
    }

    /// Whether there is nothing in it that has a place.
    pub fn is_empty(&self) -> bool {
        self.objects.is_empty() && self.lights.is_empty() && self.cameras.is_empty()
    }

    /// Everything is as if it was made by hand.
    pub(crate) fn leave_files(&mut self) {
        self.source_files.clear();
        (self.objects.iter_mut()).for_each(|i| Arc::make_mut(i).source_file = None);
        self.lights.iter_mut().for_each(|l| l.source_file = None);
        self.cameras.iter_mut().for_each(|c| c.source_file = None);
    }

    /// The object of this name for good.
    pub fn item(&self, id: ItemId) -> Option<&SceneObject> {
        in_order(&self.objects, id, |i| i.id).map(|item| &**item)
    }

    /// The light of this name for good.
    pub fn lamp(&self, id: ItemId) -> Option<&SceneLight> {
        in_order(&self.lights, id, |l| l.id)
    }

    /// The viewpoint of this name for good.
    pub fn viewpoint(&self, id: ItemId) -> Option<&SceneCamera> {
        in_order(&self.cameras, id, |c| c.id)
    }

    /// Whether anything of this document has the name for good.
    pub fn has(&self, id: ItemId) -> bool {
        self.item(id).is_some() || self.lamp(id).is_some() || self.viewpoint(id).is_some()
    }

    /// Whether a thing is out of sight; `None` if there is no such thing.
    pub fn is_hidden(&self, id: ItemId) -> Option<bool> {
        let item = self.item(id).map(|i| i.hidden);
        let lamp = || self.lamp(id).map(|l| l.hidden);
        let camera = || self.viewpoint(id).map(|c| c.hidden);
        item.or_else(lamp).or_else(camera)
    }

    /// Everything that is out of sight.
    pub fn hidden(&self) -> Vec<ItemId> {
        let items = self.objects.iter().filter(|i| i.hidden).map(|i| i.id);
        let lights = self.lights.iter().filter(|l| l.hidden).map(|l| l.id);
        let cameras = self.cameras.iter().filter(|c| c.hidden).map(|c| c.id);
        items.chain(lights).chain(cameras).collect()
    }

    /// Its name for people.
    pub fn name(&self, id: ItemId) -> Option<&str> {
        let item = self.item(id).map(|i| i.name.as_str());
        let lamp = || self.lamp(id).map(|l| l.light.name.as_str());
        let camera = || self.viewpoint(id).map(|c| c.camera.name.as_str());
        item.or_else(lamp).or_else(camera)
    }

    /// The smallest box around all objects, or around those of `ids`.
    pub fn bounds(&self, ids: Option<&[ItemId]>) -> Aabb {
        let around = |all: Aabb, item: &SceneObject| all.union(item.bounds());
        match ids {
            None => (self.objects.iter()).fold(Aabb::EMPTY, |all, item| around(all, item)),
            Some(ids) => {
                let items = ids.iter().filter_map(|&id| self.item(id));
                items.fold(Aabb::EMPTY, around)
            }
        }
    }

    /// How many polygons its meshes have, and one for each exact shape.
    pub fn face_count(&self) -> usize {
        let faces = |item: &SceneObject| match &*item.shape {
            Shape::Mesh(mesh) => mesh.faces.len(),
            Shape::Primitive(_) => 1,
            Shape::Exact(exact) => exact.leaves().len(),
        };
        self.objects.iter().map(|item| faces(item)).sum()
    }

    /// Whether anything shines.
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

/// Changes every material that a shape refers to.
fn map_materials(shape: &mut Shape, change: &mut impl FnMut(MaterialId) -> MaterialId) {
    match shape {
        Shape::Mesh(mesh) => mesh.face_materials.iter_mut().for_each(|m| *m = change(*m)),
        Shape::Primitive(p) => p.material = change(p.material),
        Shape::Exact(exact) => exact.map_materials(change),
    }
}
