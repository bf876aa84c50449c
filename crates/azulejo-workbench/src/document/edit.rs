//! All the ways in which a document changes.

use super::{Document, Id, Item, Lamp, NewLight, NewShape, Viewpoint, map_materials};
use azulejo::scene::{Camera, Fog, Light, Material, MaterialId, Object, Rgb, Scene, Shape, Units};
use glam::DAffine3;
use std::collections::{HashMap, HashSet};
use std::fmt;
use std::sync::Arc;

/// One change of a document.
#[derive(Clone, Debug, PartialEq)]
pub enum Edit {
    /// Gives an object, a light or a camera another name.
    Rename(Id, String),
    /// Hides objects from the viewport, or shows them.
    Hide(Vec<Id>, bool),
    /// Takes things away.
    Delete(Vec<Id>),
    /// Adds the same again, in the same place.
    Duplicate(Vec<Id>),
    /// Moves, turns or scales things, cameras and lights included.
    Transform(Vec<Id>, DAffine3),
    /// Says where an object stands.
    Place(Id, DAffine3),
    /// Adds a shape.
    AddShape(NewShape),
    /// Puts another shape in the place of an object's.
    SetShape(Id, Arc<Shape>),
    /// Adds a light.
    AddLight(NewLight),
    /// Changes a light.
    SetLight(Id, Light),
    /// Saves a viewpoint.
    AddCamera(Camera),
    /// Changes a viewpoint.
    SetCamera(Id, Camera),
    /// Adds a material.
    AddMaterial(Material),
    /// Changes a material.
    SetMaterial(MaterialId, Material),
    /// Gives objects a material.
    Assign(Vec<Id>, MaterialId),
    /// Gives some faces of a mesh a material.
    AssignFaces(Id, Vec<u32>, MaterialId),
    /// The radiance where there is no surface.
    SetBackground(Option<Rgb>),
    /// What hides far surfaces.
    SetFog(Option<Fog>),
    /// What the numbers mean. Nothing is scaled.
    SetUnits(Units),
    /// Adds another document's things, which has the same units; an empty one takes them over.
    Append(Box<Document>),
}

/// Why an edit was not made: what was found, what was expected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused(pub String);

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Refused {}

type Edited = Result<Vec<Id>, Refused>;

impl Edit {
    /// A few words for the menu: "Undo ...".
    pub fn label(&self) -> &'static str {
        match self {
            Edit::Rename(..) => "rename",
            Edit::Hide(_, true) => "hide",
            Edit::Hide(_, false) => "show",
            Edit::Delete(_) => "delete",
            Edit::Duplicate(_) => "duplicate",
            Edit::Transform(..) | Edit::Place(..) => "move",
            Edit::AddShape(_) => "add a shape",
            Edit::SetShape(..) => "change a shape",
            Edit::AddLight(_) => "add a light",
            Edit::SetLight(..) => "change a light",
            Edit::AddCamera(_) => "save a camera",
            Edit::SetCamera(..) => "change a camera",
            Edit::AddMaterial(_) => "add a material",
            Edit::SetMaterial(..) => "change a material",
            Edit::Assign(..) | Edit::AssignFaces(..) => "assign a material",
            Edit::SetBackground(_) => "change the background",
            Edit::SetFog(_) => "change the fog",
            Edit::SetUnits(_) => "change the units",
            Edit::Append(_) => "add a file",
        }
    }

    /// Changes `document`; returns what should be selected then. A document that refuses is
    /// unchanged.
    ///
    /// # Errors
    /// [`Refused`]: what is named does not exist, or the numbers make no valid scene.
    pub fn apply(&self, document: &mut Document) -> Edited {
        match self {
            Edit::Rename(id, name) => document.rename(*id, name),
            Edit::Hide(ids, hidden) => Ok(document.hide(ids, *hidden)),
            Edit::Delete(ids) => document.delete(ids),
            Edit::Duplicate(ids) => document.duplicate(ids),
            Edit::Transform(ids, map) => document.transform(ids, map),
            Edit::Place(id, placement) => document.place(*id, placement),
            Edit::AddShape(new) => document.add_shape(new),
            Edit::SetShape(id, shape) => document.set_shape(*id, shape),
            Edit::AddLight(new) => document.add_light(new),
            Edit::SetLight(id, light) => document.set_light(*id, light),
            Edit::AddCamera(camera) => document.add_camera(camera),
            Edit::SetCamera(id, camera) => document.set_camera(*id, camera),
            Edit::AddMaterial(material) => document.add_material(material),
            Edit::SetMaterial(id, material) => document.set_material(*id, material),
            Edit::Assign(ids, material) => document.assign(ids, *material),
            Edit::AssignFaces(id, faces, material) => document.assign_faces(*id, faces, *material),
            Edit::SetBackground(radiance) => document.set_surroundings(*radiance, document.fog),
            Edit::SetFog(fog) => document.set_surroundings(document.background, *fog),
            Edit::SetUnits(units) => document.set_units(*units),
            Edit::Append(other) => Ok(document.append_document(other)),
        }
    }
}

fn refuse<T>(why: impl fmt::Display) -> Result<T, Refused> {
    Err(Refused(why.to_string()))
}

fn missing<T>(what: &str) -> Result<T, Refused> {
    refuse(format_args!("there is no such {what} any more"))
}

/// Factors beyond this, or below its inverse, are of no unit of length.
const MOST_SCALE: f64 = 1e12;

/// Whether a map keeps shapes what they are: finite, flattening nothing, and no further from a
/// turn than numbers can tell.
fn is_placement(map: &DAffine3) -> bool {
    let m = &map.matrix3;
    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.length());
    let sane = |length: f64| (1.0 / MOST_SCALE..=MOST_SCALE).contains(&length);
    let flatness = m.determinant().abs() / (x * y * z);
    map.is_finite() && [x, y, z].into_iter().all(sane) && flatness > 1e-9
}

impl Document {
    fn item_mut(&mut self, id: Id) -> Option<&mut Item> {
        let at = self.items.binary_search_by_key(&id, |i| i.id).ok()?;
        self.items.get_mut(at)
    }

    fn rename(&mut self, id: Id, name: &str) -> Edited {
        let name = name.trim().to_owned();
        if name.chars().any(char::is_control) {
            return refuse("a name holds control characters, expected one line of text");
        }
        if let Some(item) = self.item_mut(id) {
            item.name = name;
        } else if let Some(lamp) = self.lights.iter_mut().find(|l| l.id == id) {
            lamp.light.name = name;
        } else if let Some(view) = self.cameras.iter_mut().find(|c| c.id == id) {
            view.camera.name = name;
        } else {
            return missing("object");
        }
        Ok(vec![id])
    }

    fn hide(&mut self, ids: &[Id], hidden: bool) -> Vec<Id> {
        let chosen = set(ids);
        let named = self.items.iter_mut().filter(|i| chosen.contains(&i.id));
        named.for_each(|item| item.hidden = hidden);
        ids.to_vec()
    }

    fn delete(&mut self, ids: &[Id]) -> Edited {
        if !ids.iter().any(|&id| self.has(id)) {
            return refuse("nothing is selected, select what to delete");
        }
        let chosen = set(ids);
        self.items.retain(|i| !chosen.contains(&i.id));
        self.lights.retain(|l| !chosen.contains(&l.id));
        self.cameras.retain(|c| !chosen.contains(&c.id));
        self.rtrace = None;
        Ok(Vec::new())
    }

    fn duplicate(&mut self, ids: &[Id]) -> Edited {
        if !ids.iter().any(|&id| self.has(id)) {
            return refuse("nothing is selected, select what to duplicate");
        }
        let chosen = set(ids);
        let items = self.items.iter().filter(|i| chosen.contains(&i.id));
        let items: Vec<Item> = items.cloned().collect();
        let lamps = self.lights.iter().filter(|l| chosen.contains(&l.id));
        let lamps: Vec<Lamp> = lamps.cloned().collect();
        let views = self.cameras.iter().filter(|c| chosen.contains(&c.id));
        let views: Vec<Viewpoint> = views.cloned().collect();
        let mut names = Names::of(self);
        let mut copies = Vec::new();
        for mut item in items {
            item.id = self.new_id();
            item.name = names.fresh(&item.name);
            copies.push(item.id);
            self.items.push(item);
            self.rtrace = None;
        }
        for mut lamp in lamps {
            lamp.id = self.new_id();
            lamp.light.name = names.fresh(&lamp.light.name);
            copies.push(lamp.id);
            self.lights.push(lamp);
        }
        for mut view in views {
            view.id = self.new_id();
            view.camera.name = names.fresh(&view.camera.name);
            copies.push(view.id);
            self.cameras.push(view);
        }
        Ok(copies)
    }

    /// `name` with the first number behind it that no object, light or camera has.
    pub(super) fn fresh_name(&self, name: &str) -> String {
        Names::of(self).fresh(name)
    }

    fn transform(&mut self, ids: &[Id], map: &DAffine3) -> Edited {
        if !is_placement(map) {
            return refuse("the transform flattens what it moves, expected factors other than 0");
        }
        let chosen = set(ids);
        let mut moved = self.clone();
        for item in moved.items.iter_mut().filter(|i| chosen.contains(&i.id)) {
            item.placement = *map * item.placement;
            self.check_placed(item)?;
        }
        // Lights and cameras know themselves how they move.
        let lights = self.lights.iter().filter(|l| chosen.contains(&l.id));
        let cameras = self.cameras.iter().filter(|c| chosen.contains(&c.id));
        let carried = Scene {
            lights: lights.map(|l| l.light.clone()).collect(),
            cameras: cameras.map(|c| c.camera.clone()).collect(),
            ..Scene::default()
        }
        .transformed(map);
        carried.validate().or_else(refuse)?;
        let places = (moved.lights.iter_mut()).filter(|l| chosen.contains(&l.id));
        places
            .zip(carried.lights)
            .for_each(|(lamp, light)| lamp.light = light);
        let places = (moved.cameras.iter_mut()).filter(|c| chosen.contains(&c.id));
        places
            .zip(carried.cameras)
            .for_each(|(view, camera)| view.camera = camera);
        moved.rtrace = None;
        *self = moved;
        Ok(ids.to_vec())
    }

    fn place(&mut self, id: Id, placement: &DAffine3) -> Edited {
        if !is_placement(placement) {
            return refuse("the transform flattens the object, expected factors other than 0");
        }
        let Some(mut item) = self.item(id).cloned() else {
            return missing("object");
        };
        item.placement = *placement;
        self.replace_item(item)
    }

    /// Puts an object in the place of the one of its name for good.
    fn replace_item(&mut self, item: Item) -> Edited {
        self.check_placed(&item)?;
        let id = item.id;
        if let Some(old) = self.item_mut(id) {
            *old = item;
        }
        self.rtrace = None;
        Ok(vec![id])
    }

    /// Whether numbers can tell where an object stands, and what it is there.
    fn check_placed(&self, item: &Item) -> Result<(), Refused> {
        let bounds = item.bounds();
        let is_there = bounds.is_empty() || (bounds.min.is_finite() && bounds.max.is_finite());
        if !is_placement(&item.placement) || !is_there {
            return refuse("the object leaves the range of numbers");
        }
        match &*item.shape {
            Shape::Mesh(_) => Ok(()),
            _ => self.check_object(item.object()),
        }
    }

    /// Whether an object would be valid with these materials.
    fn check_object(&self, object: Object) -> Result<(), Refused> {
        let alone = Scene {
            objects: vec![object],
            materials: vec![Material::default(); self.materials.len()],
            ..Scene::default()
        };
        alone.validate().or_else(|e| refuse(e.problem))
    }

    fn add_shape(&mut self, new: &NewShape) -> Edited {
        let mut made = self.clone();
        let (name, shape) = new.make(&mut made)?;
        let name = self.fresh_name(&name);
        let id = made.push_shape(name, shape, None);
        made.items
            .last()
            .map_or(Ok(()), |item| made.check_placed(item))?;
        made.rtrace = None;
        *self = made;
        Ok(vec![id])
    }

    fn set_shape(&mut self, id: Id, shape: &Arc<Shape>) -> Edited {
        let Some(mut item) = self.item(id).cloned() else {
            return missing("object");
        };
        self.check_object(Object::new("", Shape::clone(shape)))?;
        item.set_shape(Arc::clone(shape));
        self.replace_item(item)
    }

    fn add_light(&mut self, new: &NewLight) -> Edited {
        let mut light = new.make(self);
        light.name = self.fresh_name(&light.name);
        check_light(&light)?;
        let id = self.new_id();
        self.lights.push(Lamp {
            id,
            branch: None,
            light,
        });
        Ok(vec![id])
    }

    fn set_light(&mut self, id: Id, light: &Light) -> Edited {
        check_light(light)?;
        match self.lights.iter_mut().find(|l| l.id == id) {
            Some(lamp) => lamp.light = light.clone(),
            None => return missing("light"),
        }
        Ok(vec![id])
    }

    fn add_camera(&mut self, camera: &Camera) -> Edited {
        check_camera(camera)?;
        let id = self.new_id();
        let mut camera = camera.clone();
        let name = match camera.name.is_empty() {
            true => "camera",
            false => &camera.name,
        };
        camera.name = self.fresh_name(name);
        self.cameras.push(Viewpoint {
            id,
            branch: None,
            camera,
        });
        Ok(vec![id])
    }

    fn set_camera(&mut self, id: Id, camera: &Camera) -> Edited {
        check_camera(camera)?;
        match self.cameras.iter_mut().find(|c| c.id == id) {
            Some(view) => view.camera = camera.clone(),
            None => return missing("camera"),
        }
        Ok(vec![id])
    }

    fn add_material(&mut self, material: &Material) -> Edited {
        self.check_material(material)?;
        self.materials.push(Arc::new(material.clone()));
        Ok(Vec::new())
    }

    fn set_material(&mut self, id: MaterialId, material: &Material) -> Edited {
        self.check_material(material)?;
        match self.materials.get_mut(id as usize) {
            Some(old) => *old = Arc::new(material.clone()),
            None => return missing("material"),
        }
        Ok(Vec::new())
    }

    fn check_material(&self, material: &Material) -> Result<(), Refused> {
        let count = self.textures.len();
        if let Some(t) = material.textures.iter().find(|&&t| t as usize >= count) {
            return refuse(format_args!("texture {t} of {count}"));
        }
        let alone = Scene {
            materials: vec![Material {
                textures: Vec::new(),
                ..material.clone()
            }],
            ..Scene::default()
        };
        alone.validate().or_else(|e| refuse(e.problem))
    }

    fn known_material(&self, id: MaterialId) -> Result<(), Refused> {
        match self.materials.get(id as usize) {
            Some(_) => Ok(()),
            None => missing("material"),
        }
    }

    fn assign(&mut self, ids: &[Id], material: MaterialId) -> Edited {
        self.known_material(material)?;
        let chosen = set(ids);
        let named = self.items.iter_mut().filter(|i| chosen.contains(&i.id));
        for item in named {
            item.change_shape(|shape| map_materials(shape, &mut |_| material));
        }
        self.rtrace = None;
        Ok(ids.to_vec())
    }

    fn assign_faces(&mut self, id: Id, faces: &[u32], material: MaterialId) -> Edited {
        self.known_material(material)?;
        let Some(item) = self.item_mut(id) else {
            return missing("object");
        };
        let Shape::Mesh(mesh) = &*item.shape else {
            return self.assign(&[id], material);
        };
        if faces.iter().any(|&f| f as usize >= mesh.faces.len()) {
            return missing("face");
        }
        item.change_shape(|shape| {
            if let Shape::Mesh(mesh) = shape {
                for &face in faces {
                    mesh.face_materials[face as usize] = material;
                }
            }
        });
        self.rtrace = None;
        Ok(vec![id])
    }

    fn set_surroundings(&mut self, background: Option<Rgb>, fog: Option<Fog>) -> Edited {
        let alone = Scene {
            background,
            fog,
            ..Scene::default()
        };
        alone.validate().or_else(refuse)?;
        (self.background, self.fog) = (background, fog);
        Ok(Vec::new())
    }

    fn set_units(&mut self, units: Units) -> Edited {
        let alone = Scene {
            units,
            ..Scene::default()
        };
        alone.validate().or_else(refuse)?;
        self.units = units;
        Ok(Vec::new())
    }

    /// Adds what another document holds; its names for good become ones of this document.
    fn append_document(&mut self, other: &Document) -> Vec<Id> {
        if self.is_empty() {
            self.units = other.units;
        }
        let (branches, materials) = (self.branches.len(), self.materials.len() as u32);
        let textures = self.textures.len() as u32;
        let branch = |b: Option<usize>| b.map(|b| b + branches);
        self.branches.extend(other.branches.iter().cloned());
        self.textures.extend(other.textures.iter().cloned());
        for material in &other.materials {
            let mut material = Arc::clone(material);
            if textures > 0 && !material.textures.is_empty() {
                let own = Arc::make_mut(&mut material);
                own.textures.iter_mut().for_each(|t| *t += textures);
            }
            self.materials.push(material);
        }
        let mut ids = Vec::new();
        for item in &other.items {
            let mut item = item.clone();
            if materials > 0 {
                item.change_shape(|shape| map_materials(shape, &mut |m| m + materials));
            }
            item.id = self.new_id();
            item.branch = branch(item.branch);
            ids.push(item.id);
            self.items.push(item);
        }
        for lamp in &other.lights {
            let id = self.new_id();
            self.lights.push(Lamp {
                id,
                branch: branch(lamp.branch),
                light: lamp.light.clone(),
            });
        }
        for view in &other.cameras {
            let id = self.new_id();
            self.cameras.push(Viewpoint {
                id,
                branch: branch(view.branch),
                camera: view.camera.clone(),
            });
        }
        self.background = self.background.or(other.background);
        self.fog = self.fog.or(other.fog);
        self.rtrace = None;
        ids
    }
}

fn set(ids: &[Id]) -> HashSet<Id> {
    ids.iter().copied().collect()
}

/// Names that are taken.
struct Names {
    taken: HashSet<String>,
    /// The last number behind each stem that was found free: those before it are not asked again.
    numbers: HashMap<String, u64>,
}

impl Names {
    fn of(document: &Document) -> Names {
        let items = document.items.iter().map(|i| &i.name);
        let lights = document.lights.iter().map(|l| &l.light.name);
        let cameras = document.cameras.iter().map(|c| &c.camera.name);
        Names {
            taken: items.chain(lights).chain(cameras).cloned().collect(),
            numbers: HashMap::new(),
        }
    }

    /// `name`, with the first free number behind it if it is taken; then it is taken too.
    fn fresh(&mut self, name: &str) -> String {
        let mut found = name.to_owned();
        if self.taken.contains(name) {
            let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
            let stem = stem.trim_end();
            let number = self.numbers.entry(stem.to_owned()).or_insert(1);
            while self.taken.contains(&found) {
                *number += 1;
                found = format!("{stem} {number}");
            }
        }
        self.taken.insert(found.clone());
        found
    }
}

fn check_light(light: &Light) -> Result<(), Refused> {
    let alone = Scene {
        lights: vec![light.clone()],
        ..Scene::default()
    };
    alone.validate().or_else(|e| refuse(e.problem))
}

fn check_camera(camera: &Camera) -> Result<(), Refused> {
    let alone = Scene {
        cameras: vec![camera.clone()],
        ..Scene::default()
    };
    alone.validate().or_else(|e| refuse(e.problem))
}
