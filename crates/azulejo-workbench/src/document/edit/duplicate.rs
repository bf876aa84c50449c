//! Duplicating, appending whole documents, and unique names.

use super::{Edited, refuse, set};
use crate::document::{ItemId, SceneCamera, SceneDocument, SceneLight, SceneObject, map_materials};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

impl SceneDocument {
    pub(super) fn duplicate(&mut self, ids: &[ItemId]) -> Edited {
        if !ids.iter().any(|&id| self.has(id)) {
            return refuse("nothing is selected, select what to duplicate");
        }
        let chosen = set(ids);
        let items = self.objects.iter().filter(|i| chosen.contains(&i.id));
        let items: Vec<SceneObject> = items.map(|item| SceneObject::clone(item)).collect();
        let lamps = self.lights.iter().filter(|l| chosen.contains(&l.id));
        let lamps: Vec<SceneLight> = lamps.cloned().collect();
        let views = self.cameras.iter().filter(|c| chosen.contains(&c.id));
        let views: Vec<SceneCamera> = views.cloned().collect();
        let mut names = UniqueNames::of(self);
        let mut copies = Vec::new();
        for mut item in items {
            item.id = self.new_id();
            item.name = names.fresh(&item.name);
            copies.push(item.id);
            self.objects.push(Arc::new(item));
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

    /// `name` with the first number that makes it unique among objects, lights and cameras.
    pub(super) fn unique_name(&self, name: &str) -> String {
        UniqueNames::of(self).fresh(name)
    }

    /// Appends the content of another document; its ids are replaced by new ones of this document.
    pub(super) fn append_document(&mut self, other: &SceneDocument) -> Vec<ItemId> {
        // An empty document takes the units of its first content.
        if self.is_empty() {
            self.units = other.units;
        }
        // Source files, materials and textures are referred to by index: those of the other follow.
        let (source_files, materials) = (self.source_files.len(), self.materials.len() as u32);
        let textures = self.textures.len() as u32;
        let source_file = |b: Option<usize>| b.map(|b| b + source_files);
        self.source_files.extend(other.source_files.iter().cloned());
        self.textures.extend(other.textures.iter().cloned());
        // Materials stay shared between the documents, unless their textures are renumbered.
        for material in &other.materials {
            let mut material = Arc::clone(material);
            if textures > 0 && material.pictures().next().is_some() {
                Arc::make_mut(&mut material).renumber_pictures(textures);
            }
            self.materials.push(material);
        }
        // Objects, lights and cameras get new ids, and references to what lies at new indices.
        let mut ids = Vec::new();
        for item in &other.objects {
            let mut item = SceneObject::clone(item);
            if materials > 0 {
                item.change_shape(|shape| map_materials(shape, &mut |m| m + materials));
            }
            item.id = self.new_id();
            item.source_file = source_file(item.source_file);
            ids.push(item.id);
            self.objects.push(Arc::new(item));
        }
        for lamp in &other.lights {
            let id = self.new_id();
            self.lights.push(SceneLight {
                id,
                source_file: source_file(lamp.source_file),
                hidden: lamp.hidden,
                light: lamp.light.clone().with_texture(|t| t + textures),
            });
        }
        for view in &other.cameras {
            let id = self.new_id();
            self.cameras.push(SceneCamera {
                id,
                source_file: source_file(view.source_file),
                hidden: view.hidden,
                camera: view.camera.clone(),
            });
        }
        // A background or fog that is there takes precedence; RTRACE settings describe one file only.
        let background = other.background.map(|b| b.with_texture(|t| t + textures));
        self.background = self.background.or(background);
        self.fog = self.fog.or(other.fog);
        self.rtrace = None;
        ids
    }
}

/// The names that are taken.
pub(super) struct UniqueNames {
    taken: HashSet<String>,
    /// The last free number found for each stem; smaller ones need not be tried again.
    numbers: HashMap<String, u64>,
}

impl UniqueNames {
    fn of(document: &SceneDocument) -> UniqueNames {
        let items = document.objects.iter().map(|i| &i.name);
        let lights = document.lights.iter().map(|l| &l.light.name);
        let cameras = document.cameras.iter().map(|c| &c.camera.name);
        UniqueNames::among(items.chain(lights).chain(cameras))
    }

    /// Starts with the given names.
    pub(super) fn among<'a>(names: impl Iterator<Item = &'a String>) -> UniqueNames {
        UniqueNames {
            taken: names.cloned().collect(),
            numbers: HashMap::new(),
        }
    }

    /// Returns `name`, with the first free number appended if it is taken, and marks it as taken.
    pub(super) fn fresh(&mut self, name: &str) -> String {
        let mut free_name = name.to_owned();
        if self.taken.contains(name) {
            let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
            let stem = stem.trim_end();
            let number = self.numbers.entry(stem.to_owned()).or_insert(1);
            while self.taken.contains(&free_name) {
                *number += 1;
                free_name = format!("{stem} {number}");
            }
        }
        self.taken.insert(free_name.clone());
        free_name
    }
}
