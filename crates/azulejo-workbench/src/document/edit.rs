//! All edits of a document.

mod duplicate;
mod materials;
mod objects;
mod recipes;
mod surroundings;

use super::{ItemId, NewLight, NewShape, SceneCamera, SceneDocument};
use azulejo::recipe::Recipe;
use azulejo::scene::sky::PerezWeather;
use azulejo::scene::{
    BackplateFit, Camera, Fog, Light, Material, MaterialId, Projection, Scene, SceneBackground,
    Shape, Texture, Units,
};
use glam::DAffine3;
use std::collections::HashSet;
use std::fmt;
use std::sync::Arc;

/// One edit of a document.
#[derive(Clone, Debug, PartialEq)]
pub enum Edit {
    /// Renames an object, a light or a camera.
    Rename(ItemId, String),
    /// Hides objects and the markers of lights and cameras in the viewport, or shows them.
    Hide(Vec<ItemId>, bool),
    /// Deletes objects, lights and cameras.
    Delete(Vec<ItemId>),
    /// Duplicates them in place.
    Duplicate(Vec<ItemId>),
    /// Moves, rotates or scales objects, lights and cameras.
    Transform(Vec<ItemId>, DAffine3),
    /// Sets the placement of an object.
    SetPlacement(ItemId, DAffine3),
    /// Adds an object of this shape.
    AddShape(NewShape),
    /// Replaces the shape of an object.
    SetShape(ItemId, Arc<Shape>),
    /// Adds a light source without area.
    AddLight(NewLight),
    /// Changes a light. A sky around a sun that moves goes with it.
    SetLight(ItemId, Light),
    /// Adds a loaded picture of the surroundings as a light.
    AddEnvironment(Arc<Texture>, Projection),
    /// Gives an environment another picture, in its place and with its brightness.
    SetEnvironmentPicture(ItemId, Arc<Texture>, Projection),
    /// Takes the sun out of the picture of an environment, as a light of its own.
    ExtractSun(ItemId),
    /// Makes a sky that of weather, and the sun at its place as bright.
    SetWeather(ItemId, PerezWeather),
    /// Surrounds a model in which nothing shines with a floor and three lamps, or hangs a lamp in a
    /// room.
    AddStudio,
    /// Stores a camera in the document.
    AddCamera(Camera),
    /// Replaces a stored camera.
    SetCamera(ItemId, Camera),
    /// Adds a material, which no surface has yet.
    AddMaterial(Material),
    /// Replaces a material on all surfaces that have it.
    SetMaterial(MaterialId, Material),
    /// Deletes an unused material; the indices of later materials decrease by one.
    DeleteMaterial(MaterialId),
    /// Deletes all materials that no surface has; indices of later ones decrease.
    DeleteUnusedMaterials,
    /// Assigns a material to objects.
    Assign(Vec<ItemId>, MaterialId),
    /// Assigns a material to faces of a mesh.
    AssignFaces(ItemId, Vec<u32>, MaterialId),
    /// Puts an image behind the scene: how it fills the view, and the radiance of its white,
    /// W/(sr·m²).
    SetBackplate(Arc<Texture>, BackplateFit, f64),
    /// Replaces the background; `None` removes it.
    SetBackground(Option<SceneBackground>),
    /// Replaces the fog; `None` removes it.
    SetFog(Option<Fog>),
    /// Changes the units. Nothing is scaled.
    SetUnits(Units),
    /// Applies a recipe to everything.
    ApplyRecipe(Arc<Recipe>),
    /// Forgets which recipes belong to the models; what they have made stays.
    ForgetRecipes,
    /// Appends another document in the same units; an empty document takes over its units.
    Append(Box<SceneDocument>),
}

/// Why an edit was rejected: what was found and what was expected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EditError(pub String);

impl fmt::Display for EditError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for EditError {}

pub(super) type Edited = Result<Vec<ItemId>, EditError>;

impl Edit {
    /// Short label for the menu entry "Undo ...".
    pub fn label(&self) -> &'static str {
        match self {
            Edit::Rename(..) => "rename",
            Edit::Hide(_, true) => "hide",
            Edit::Hide(_, false) => "show",
            Edit::Delete(_) => "delete",
            Edit::Duplicate(_) => "duplicate",
            Edit::Transform(..) | Edit::SetPlacement(..) => "move",
            Edit::AddShape(_) => "add a shape",
            Edit::SetShape(..) => "change a shape",
            Edit::AddLight(_) | Edit::AddEnvironment(..) => "add a light",
            Edit::SetLight(..) | Edit::SetEnvironmentPicture(..) | Edit::SetWeather(..) => {
                "change a light"
            }
            Edit::ExtractSun(_) => "extract the sun",
            Edit::AddStudio => "add a studio",
            Edit::AddCamera(_) => "save a camera",
            Edit::SetCamera(..) => "change a camera",
            Edit::AddMaterial(_) => "add a material",
            Edit::SetMaterial(..) => "change a material",
            Edit::DeleteMaterial(_) => "delete a material",
            Edit::DeleteUnusedMaterials => "remove unused materials",
            Edit::Assign(..) | Edit::AssignFaces(..) => "assign a material",
            Edit::SetBackground(_) | Edit::SetBackplate(..) => "change the background",
            Edit::SetFog(_) => "change the fog",
            Edit::SetUnits(_) => "change the units",
            Edit::ApplyRecipe(_) => "apply a recipe",
            Edit::ForgetRecipes => "forget the recipes",
            Edit::Append(_) => "add a file",
        }
    }

    /// The name of the one object, light, camera or material that the edit concerns, without the
    /// groups that contain it; `None` if it concerns several, or the whole scene. `made` is what the
    /// edit made or changed.
    pub fn subject(
        &self,
        before: &SceneDocument,
        after: &SceneDocument,
        made: &[ItemId],
    ) -> Option<String> {
        let of_material = |document: &SceneDocument, id: MaterialId| {
            Some(document.materials.get(id as usize)?.name.clone())
        };
        let ids = match self {
            Edit::AddMaterial(material) => return named(&material.name),
            Edit::SetMaterial(id, _) | Edit::DeleteMaterial(id) => {
                return named(&of_material(before, *id)?);
            }
            Edit::Hide(ids, _)
            | Edit::Delete(ids)
            | Edit::Duplicate(ids)
            | Edit::Transform(ids, _)
            | Edit::Assign(ids, _) => &ids[..],
            Edit::Rename(id, _)
            | Edit::SetPlacement(id, _)
            | Edit::SetShape(id, _)
            | Edit::SetLight(id, _)
            | Edit::SetEnvironmentPicture(id, ..)
            | Edit::ExtractSun(id)
            | Edit::SetWeather(id, _)
            | Edit::SetCamera(id, _)
            | Edit::AssignFaces(id, ..) => std::slice::from_ref(id),
            Edit::AddShape(_)
            | Edit::AddLight(_)
            | Edit::AddEnvironment(..)
            | Edit::AddCamera(_) => made,
            Edit::AddStudio
            | Edit::DeleteUnusedMaterials
            | Edit::SetBackground(_)
            | Edit::SetBackplate(..)
            | Edit::SetFog(_)
            | Edit::SetUnits(_)
            | Edit::ApplyRecipe(_)
            | Edit::ForgetRecipes
            | Edit::Append(_) => return None,
        };
        match ids {
            [id] => named(before.name(*id).or_else(|| after.name(*id))?),
            _ => None,
        }
    }

    /// Whether the edit would change anything. Hiding what is hidden or keeping a name is not worth
    /// an undo step.
    pub fn changes(&self, document: &SceneDocument) -> bool {
        match self {
            Edit::Hide(ids, hidden) => {
                let is_other = |&id: &ItemId| document.is_hidden(id) == Some(!hidden);
                ids.iter().any(is_other)
            }
            Edit::Rename(id, name) => document.name(*id) != Some(name.trim()),
            Edit::ForgetRecipes => document.has_recipes(),
            _ => true,
        }
    }

    /// Applies the edit to `document`; returns what should be selected afterwards. A rejected edit
    /// leaves the document unchanged.
    ///
    /// # Errors
    ///
    /// [`EditError`] if something it refers to does not exist, or if the result is not a valid
    /// scene.
    pub fn apply(&self, document: &mut SceneDocument) -> Edited {
        self.apply_noting(document, &mut Vec::new())
    }

    /// [`Edit::apply`]; `notes` receives what is worth saying of an edit that was applied.
    ///
    /// # Errors
    ///
    /// As [`Edit::apply`].
    pub fn apply_noting(&self, document: &mut SceneDocument, notes: &mut Vec<String>) -> Edited {
        match self {
            Edit::Rename(id, name) => document.rename(*id, name),
            Edit::Hide(ids, hidden) => Ok(document.hide(ids, *hidden)),
            Edit::Delete(ids) => document.with_grounds(|d| d.delete(ids)),
            Edit::Duplicate(ids) => document.duplicate(ids),
            Edit::Transform(ids, map) => document.with_grounds(|d| d.transform(ids, map)),
            Edit::SetPlacement(id, placement) => document.set_placement(*id, placement),
            Edit::AddShape(new) => document.add_shape(new),
            Edit::SetShape(id, shape) => document.set_shape(*id, shape),
            Edit::AddLight(new) => document.with_grounds(|d| d.add_light(new)),
            Edit::SetLight(id, light) => document.with_grounds(|d| d.set_light(*id, light)),
            Edit::AddEnvironment(texture, projection) => {
                document.add_environment(texture, *projection)
            }
            Edit::SetEnvironmentPicture(id, texture, projection) => {
                document.set_environment_picture(*id, texture, *projection)
            }
            Edit::ExtractSun(id) => document.with_grounds(|d| d.extract_sun(*id)),
            Edit::SetWeather(id, weather) => document.with_grounds(|d| d.set_weather(*id, weather)),
            Edit::AddStudio => document.add_studio(),
            Edit::AddCamera(camera) => document.add_camera(camera),
            Edit::SetCamera(id, camera) => document.set_camera(*id, camera),
            Edit::AddMaterial(material) => document.add_material(material),
            Edit::SetMaterial(id, material) => document.set_material(*id, material),
            Edit::DeleteMaterial(id) => document.delete_material(*id),
            Edit::DeleteUnusedMaterials => document.delete_unused_materials(),
            Edit::Assign(ids, material) => document.assign(ids, *material),
            Edit::AssignFaces(id, faces, material) => document.assign_faces(*id, faces, *material),
            Edit::SetBackplate(texture, fit, radiance) => {
                document.set_backplate(texture, *fit, *radiance)
            }
            Edit::SetBackground(radiance) => document.set_surroundings(*radiance, document.fog),
            Edit::SetFog(fog) => document.set_surroundings(document.background, *fog),
            Edit::SetUnits(units) => document.set_units(*units),
            Edit::ApplyRecipe(recipe) => document.apply_recipe(recipe, notes),
            Edit::ForgetRecipes => document.forget_recipes(),
            Edit::Append(other) => Ok(document.append_document(other)),
        }
    }
}

/// The last component of a name, if there is one.
fn named(name: &str) -> Option<String> {
    let last = name.rsplit('/').next()?.trim();
    (!last.is_empty()).then(|| last.to_owned())
}

fn refuse<T>(why: impl fmt::Display) -> Result<T, EditError> {
    Err(EditError(why.to_string()))
}

fn missing<T>(what: &str) -> Result<T, EditError> {
    refuse(format_args!("the {what} no longer exists"))
}

/// No unit of length needs a larger factor, or a smaller one than its inverse.
const MAX_SCALE: f64 = 1e12;

/// Whether a map is a usable placement: finite, with sensible scales along its axes, and not nearly
/// singular.
fn is_placement(map: &DAffine3) -> bool {
    let m = &map.matrix3;
    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.length());
    let sane = |length: f64| (1.0 / MAX_SCALE..=MAX_SCALE).contains(&length);
    let flatness = m.determinant().abs() / (x * y * z);
    map.is_finite() && [x, y, z].into_iter().all(sane) && flatness > 1e-9
}

impl SceneDocument {
    fn add_light(&mut self, new: &NewLight) -> Edited {
        let light = new.make(self);
        self.push_light(&light.name, light.kind)
    }

    fn add_camera(&mut self, camera: &Camera) -> Edited {
        check_camera(camera)?;
        let id = self.new_id();
        let mut camera = camera.clone();
        let name = if camera.name.is_empty() {
            "camera"
        } else {
            &camera.name
        };
        camera.name = self.unique_name(name);
        self.cameras.push(SceneCamera {
            id,
            source_file: None,
            hidden: false,
            camera,
        });
        Ok(vec![id])
    }

    fn set_camera(&mut self, id: ItemId, camera: &Camera) -> Edited {
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

    fn check_material(&self, material: &Material) -> Result<(), EditError> {
        let count = self.textures.len();
        if let Some(t) = material.pictures().find(|&t| t as usize >= count) {
            return refuse(format_args!("texture {t} of {count}"));
        }
        let mut material = material.clone();
        material.drop_pictures();
        let alone = Scene {
            materials: vec![material],
            ..Scene::default()
        };
        alone.validate().or_else(|e| refuse(e.problem))
    }

    fn known_material(&self, id: MaterialId) -> Result<(), EditError> {
        match self.materials.get(id as usize) {
            Some(_) => Ok(()),
            None => missing("material"),
        }
    }

    fn set_surroundings(
        &mut self,
        background: Option<SceneBackground>,
        fog: Option<Fog>,
    ) -> Edited {
        let alone = Scene {
            // A background's picture is one of the document's.
            textures: self.blank_textures(),
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
}

fn set(ids: &[ItemId]) -> HashSet<ItemId> {
    ids.iter().copied().collect()
}

fn check_camera(camera: &Camera) -> Result<(), EditError> {
    let alone = Scene {
        cameras: vec![camera.clone()],
        ..Scene::default()
    };
    alone.validate().or_else(|e| refuse(e.problem))
}
