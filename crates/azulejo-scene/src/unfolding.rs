//! Instances of shared meshes in a scene: which there are, and meshes of their own in their place.

use crate::{Mesh, Object, Scene, Shape};
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

impl Scene {
    /// Whether any object is an instance of a shared mesh.
    pub fn has_instances(&self) -> bool {
        let is_instance = |o: &Object| matches!(o.shape, Shape::Instance(_));
        self.objects.iter().any(is_instance)
    }

    /// The scene with a mesh of its own for every instance, for those who know no shared meshes; itself
    /// if it has none.
    pub fn unfolded(&self) -> Cow<'_, Scene> {
        if !self.has_instances() {
            return Cow::Borrowed(self);
        }
        let mut scene = self.clone();
        scene.unfold();
        Cow::Owned(scene)
    }

    /// Gives every instance a mesh of its own, in place.
    pub fn unfold(&mut self) {
        self.unfold_if(|_| true);
    }

    /// Gives some instances meshes of their own.
    pub fn unfold_if(&mut self, is_meant: impl Fn(&Object) -> bool) {
        for object in self.objects.iter_mut().filter(|o| is_meant(o)) {
            if let Shape::Instance(instance) = &mut object.shape {
                object.shape = Shape::Mesh(instance.take_mesh());
            }
        }
    }

    /// Gives a mesh of its own to every instance that shares its mesh with no other.
    pub fn unfold_single_instances(&mut self) {
        let mut uses: HashMap<*const Mesh, usize> = HashMap::new();
        for object in &self.objects {
            if let Shape::Instance(instance) = &object.shape {
                *uses.entry(Arc::as_ptr(&instance.mesh)).or_default() += 1;
            }
        }
        self.unfold_if(|object| match &object.shape {
            Shape::Instance(instance) => uses[&Arc::as_ptr(&instance.mesh)] == 1,
            _ => false,
        });
    }

    /// Applies a change to every mesh, and to every shared one once.
    pub fn for_each_mesh(&mut self, mut change: impl FnMut(&mut Mesh)) {
        for object in &mut self.objects {
            if let Shape::Mesh(mesh) = &mut object.shape {
                change(mesh);
            }
        }
        self.change_shared_meshes(change);
    }

    /// Applies a change to every shared mesh once; instances that shared a mesh share the changed one.
    pub fn change_shared_meshes(&mut self, mut change: impl FnMut(&mut Mesh)) {
        let mut changed: HashMap<*const Mesh, Arc<Mesh>> = HashMap::new();
        // The old meshes stay alive until all are changed, or a new one might get an old one's address.
        let mut old = Vec::new();
        for object in &mut self.objects {
            let Shape::Instance(instance) = &mut object.shape else {
                continue;
            };
            let new = changed
                .entry(Arc::as_ptr(&instance.mesh))
                .or_insert_with(|| {
                    let mut mesh = Mesh::clone(&instance.mesh);
                    change(&mut mesh);
                    old.push(instance.mesh.clone());
                    Arc::new(mesh)
                });
            instance.mesh = new.clone();
        }
    }

    /// The distinct shared meshes, in the order of their first instances.
    pub fn shared_meshes(&self) -> Vec<&Arc<Mesh>> {
        let mut seen = HashSet::new();
        let meshes = self
            .objects
            .iter()
            .filter_map(|object| match &object.shape {
                Shape::Instance(instance) => Some(&instance.mesh),
                _ => None,
            });
        meshes.filter(|m| seen.insert(Arc::as_ptr(m))).collect()
    }
}
