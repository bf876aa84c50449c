//! Edits of objects: names, placements and materials.

use super::{EditError, Edited, is_placement, missing, refuse, set};
use crate::document::{ItemId, NewShape, SceneDocument, SceneObject, ShapeFacts, map_materials};
use azulejo::scene::{Material, MaterialId, Object, Scene, Shape};
use glam::{DAffine3, DVec3};
use std::collections::HashMap;
use std::sync::Arc;

impl SceneDocument {
    pub(super) fn object_mut(&mut self, id: ItemId) -> Option<&mut SceneObject> {
        let at = self.objects.binary_search_by_key(&id, |i| i.id).ok()?;
        self.objects.get_mut(at).map(Arc::make_mut)
    }

    pub(super) fn rename(&mut self, id: ItemId, name: &str) -> Edited {
        let name = name.trim().to_owned();
        if name.chars().any(char::is_control) {
            return refuse("the name contains control characters, expected one line of text");
        }
        if let Some(item) = self.object_mut(id) {
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

    pub(super) fn hide(&mut self, ids: &[ItemId], hidden: bool) -> Vec<ItemId> {
        let chosen = set(ids);
        let named = self.objects.iter_mut().filter(|i| chosen.contains(&i.id));
        // Do not copy an object that already has this visibility.
        let others = named.filter(|i| i.hidden != hidden);
        others.for_each(|item| Arc::make_mut(item).hidden = hidden);
        let lights = self.lights.iter_mut().filter(|l| chosen.contains(&l.id));
        lights.for_each(|lamp| lamp.hidden = hidden);
        let cameras = self.cameras.iter_mut().filter(|c| chosen.contains(&c.id));
        cameras.for_each(|view| view.hidden = hidden);
        ids.to_vec()
    }

    pub(super) fn delete(&mut self, ids: &[ItemId]) -> Edited {
        if !ids.iter().any(|&id| self.has(id)) {
            return refuse("nothing is selected, select what to delete");
        }
        let chosen = set(ids);
        self.objects.retain(|i| !chosen.contains(&i.id));
        self.lights.retain(|l| !chosen.contains(&l.id));
        self.cameras.retain(|c| !chosen.contains(&c.id));
        self.rtrace = None;
        Ok(Vec::new())
    }

    pub(super) fn transform(&mut self, ids: &[ItemId], map: &DAffine3) -> Edited {
        if !is_placement(map) {
            return refuse("the transform is singular, expected factors other than 0");
        }
        let mut moved = self.clone();
        moved.transform_items(ids, map)?;
        moved.transform_markers(ids, map)?;
        moved.rtrace = None;
        *self = moved;
        Ok(ids.to_vec())
    }

    fn transform_items(&mut self, ids: &[ItemId], map: &DAffine3) -> Result<(), EditError> {
        let chosen = set(ids);
        for item in self.objects.iter_mut().filter(|i| chosen.contains(&i.id)) {
            let item = Arc::make_mut(item);
            item.placement = *map * item.placement;
        }
        let items = self.objects.iter().filter(|i| chosen.contains(&i.id));
        self.check_placed(items.map(|item| &**item))
    }

    /// Lights and cameras transform themselves.
    fn transform_markers(&mut self, ids: &[ItemId], map: &DAffine3) -> Result<(), EditError> {
        let chosen = set(ids);
        let lights = self.lights.iter().filter(|l| chosen.contains(&l.id));
        let cameras = self.cameras.iter().filter(|c| chosen.contains(&c.id));
        let carried = Scene {
            lights: lights.map(|l| l.light.clone()).collect(),
            cameras: cameras.map(|c| c.camera.clone()).collect(),
            textures: self.blank_textures(),
            ..Scene::default()
        }
        .transformed(map);
        carried.validate().or_else(refuse)?;
        let places = (self.lights.iter_mut()).filter(|l| chosen.contains(&l.id));
        places
            .zip(carried.lights)
            .for_each(|(lamp, light)| lamp.light = light);
        let places = (self.cameras.iter_mut()).filter(|c| chosen.contains(&c.id));
        places
            .zip(carried.cameras)
            .for_each(|(view, camera)| view.camera = camera);
        Ok(())
    }

    pub(super) fn set_placement(&mut self, id: ItemId, placement: &DAffine3) -> Edited {
        if !is_placement(placement) {
            return refuse("the object's transform is singular, expected factors other than 0");
        }
        let Some(mut item) = self.object(id).cloned() else {
            return missing("object");
        };
        item.placement = *placement;
        self.replace_item(item)
    }

    /// Replaces the object with the same id.
    fn replace_item(&mut self, item: SceneObject) -> Edited {
        self.check_placed([&item])?;
        let id = item.id;
        if let Some(old) = self.object_mut(id) {
            *old = item;
        }
        self.rtrace = None;
        Ok(vec![id])
    }

    /// Checks that the objects are valid at their placements and that coordinates remain precise
    /// enough.
    fn check_placed<'a>(
        &self,
        items: impl IntoIterator<Item = &'a SceneObject>,
    ) -> Result<(), EditError> {
        let alone = self.placed_alone(items)?;
        alone.validate().or_else(|e| refuse(e.problem))
    }

    /// A scene with just these objects, for validation. One scene serves all of them, since
    /// building it takes time in proportion to the number of materials.
    fn placed_alone<'a>(
        &self,
        items: impl IntoIterator<Item = &'a SceneObject>,
    ) -> Result<Scene, EditError> {
        let mut objects = Vec::new();
        for item in items {
            let bounds = item.bounds();
            // Bounds leave out vertices without faces.
            let is_placed = |p: &DVec3| item.placement.transform_point3(*p).is_finite();
            let is_there = match &*item.shape {
                Shape::Mesh(mesh) => mesh.positions.iter().all(is_placed),
                Shape::Instance(_) | Shape::Primitive(_) | Shape::Exact(_) => true,
            };
            let is_there = is_there
                && (bounds.is_empty() || (bounds.min.is_finite() && bounds.max.is_finite()));
            if !is_placement(&item.placement) || !is_there {
                return refuse("the object exceeds the range of coordinates");
            }
            // A finite mesh at a finite placement stays valid.
            if !matches!(&*item.shape, Shape::Mesh(_)) {
                objects.push(item.object());
            }
        }
        Ok(self.with_any_materials(objects))
    }

    /// A scene of these objects with as many default materials as they refer to.
    fn with_any_materials(&self, objects: Vec<Object>) -> Scene {
        let count = if objects.is_empty() {
            0
        } else {
            self.materials.len()
        };
        Scene {
            objects,
            materials: vec![Material::default(); count],
            ..Scene::default()
        }
    }

    pub(super) fn add_shape(&mut self, new: &NewShape) -> Edited {
        let mut made = self.clone();
        let (name, shape) = new.make(&mut made)?;
        let name = self.unique_name(&name);
        let id = made.push_shape(name, shape, None);
        made.check_placed(made.object(id))?;
        made.rtrace = None;
        *self = made;
        Ok(vec![id])
    }

    pub(super) fn set_shape(&mut self, id: ItemId, shape: &Arc<Shape>) -> Edited {
        let Some(mut item) = self.object(id).cloned() else {
            return missing("object");
        };
        let alone = self.with_any_materials(vec![Object::new("", Shape::clone(shape))]);
        alone.validate().or_else(|e| refuse(e.problem))?;
        item.set_shape(Arc::clone(shape));
        self.replace_item(item)
    }

    /// Objects that shared a shape share the changed one.
    pub(super) fn assign(&mut self, ids: &[ItemId], material: MaterialId) -> Edited {
        self.known_material(material)?;
        let chosen = set(ids);
        let mut made: HashMap<*const Shape, (Arc<Shape>, Arc<ShapeFacts>)> = HashMap::new();
        for item in self.objects.iter_mut().filter(|i| chosen.contains(&i.id)) {
            let item = Arc::make_mut(item);
            let old = Arc::clone(&item.shape);
            match made.get(&Arc::as_ptr(&old)) {
                Some((shape, facts)) => {
                    item.shape = Arc::clone(shape);
                    item.facts = Arc::clone(facts);
                }
                None => {
                    item.change_shape(|shape| map_materials(shape, &mut |_| material));
                    let new = (Arc::clone(&item.shape), Arc::clone(&item.facts));
                    made.insert(Arc::as_ptr(&old), new);
                }
            }
        }
        self.rtrace = None;
        Ok(ids.to_vec())
    }

    pub(super) fn assign_faces(
        &mut self,
        id: ItemId,
        faces: &[u32],
        material: MaterialId,
    ) -> Edited {
        self.known_material(material)?;
        let Some(item) = self.object(id) else {
            return missing("object");
        };
        let Shape::Mesh(mesh) = &*item.shape else {
            return self.assign(&[id], material);
        };
        if faces.iter().any(|&f| f as usize >= mesh.faces.len()) {
            return missing("face");
        }
        if let Some(item) = self.object_mut(id) {
            item.change_shape(|shape| {
                if let Shape::Mesh(mesh) = shape {
                    for &face in faces {
                        mesh.face_materials[face as usize] = material;
                    }
                }
            });
        }
        self.rtrace = None;
        Ok(vec![id])
    }
}

#[cfg(test)]
mod tests {
    use crate::document::tests::sample;
    use crate::document::{Edit, ItemId, SceneDocument};
    use azulejo::scene::Material;
    use glam::{DAffine3, DVec3};
    use std::sync::Arc;

    /// Forty spheres, fifty materials.
    fn crowd() -> (SceneDocument, Vec<ItemId>) {
        let mut document = sample();
        let white = Arc::new(Material::default());
        document.materials.resize(50, white);
        for _ in 0..39 {
            let ball = vec![ItemId(3)];
            Edit::Duplicate(ball).apply(&mut document).unwrap();
        }
        let ids = (document.objects.iter())
            .map(|i| i.id)
            .filter(|id| *id != ItemId(4));
        let ids = ids.collect();
        (document, ids)
    }

    #[test]
    fn what_moves_together_is_checked_together() {
        let (mut document, ids) = crowd();
        let moved = ids.iter().filter_map(|&id| document.object(id));
        let alone = document.placed_alone(moved).unwrap();
        // The two meshes are represented by their bounding boxes.
        assert_eq!((alone.objects.len(), alone.materials.len()), (40, 50));
        let meshes = [ItemId(1), ItemId(2)].into_iter();
        let meshes = meshes.filter_map(|id| document.object(id));
        assert_eq!(document.placed_alone(meshes).unwrap(), Default::default());

        let away = DAffine3::from_translation(DVec3::X * f64::MAX);
        assert_eq!(
            Edit::Transform(ids.clone(), away).apply(&mut document),
            Ok(ids.clone())
        );
        let before = document.clone();
        let refused = Edit::Transform(ids, away).apply(&mut document);
        assert!(
            refused
                .unwrap_err()
                .to_string()
                .contains("range of coordinates")
        );
        assert_eq!(document, before);
    }

    #[test]
    fn objects_that_do_not_move_are_not_copied() {
        let (mut document, ids) = crowd();
        let before = document.clone();
        Edit::Transform(ids, DAffine3::from_translation(DVec3::X))
            .apply(&mut document)
            .unwrap();
        let pairs = before.objects.iter().zip(&document.objects);
        let shared: Vec<ItemId> = pairs
            .filter(|(a, b)| Arc::ptr_eq(a, b))
            .map(|(a, _)| a.id)
            .collect();
        assert_eq!(shared, [ItemId(4)]);
    }
}
