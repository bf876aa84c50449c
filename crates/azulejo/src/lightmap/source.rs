//! The glTF file that gets a lightmap: one that stays as it is, or one that is written of a scene.
//!
//! A [`BakeSource`] says which objects of a scene are baked, and which faces of the file they are.
//! [`BakeSource::layouts`] carries the charts of a lightmap over to the file.

use super::{Baked, BytePictures, meshes_of};
use crate::models::unbaked;
use azulejo_bake::Receiver;
use azulejo_formats::gltf::patch::{
    self, Container, Convention, GltfFile, InstanceMode, LightmapEdit, LightmapUvs, LightsMode,
    ObjectLayout, PatchError, PatchedFile,
};
use azulejo_formats::gltf::{self, MattSurfaces, ObjectOrigin, Stillness};
use azulejo_formats::{Folder, ReadError, ReadOptions};
use azulejo_scene::{Object, Scene, Shape};
use std::fmt;
use std::io;
use std::path::Path;

/// A scene, and the glTF file that gets its lightmap.
pub struct BakeSource {
    /// What shades, lights and receives.
    pub scene: Scene,
    /// The objects of `scene` that receive.
    pub receivers: Vec<u32>,
    /// The glTF file.
    pub file: SourceFile,
    /// The origins of its objects.
    pub origins: Vec<ObjectOrigin>,
    /// For each receiver, which of the origins it is.
    pub origin_of: Vec<usize>,
    /// For each receiver, where its triangles are among those of the file.
    pub order: Vec<Option<Vec<u32>>>,
    /// Whether the file is the user's own, not one that was made of other models.
    pub is_given: bool,
    /// What is to be said of it.
    pub notes: Vec<String>,
}

/// A glTF file.
pub struct SourceFile {
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// Its name, for messages.
    pub name: String,
    /// The files around it.
    pub files: Folder,
    /// How it was read.
    pub options: ReadOptions,
}

impl SourceFile {
    /// For edits.
    pub fn patched(&self) -> GltfFile<'_> {
        GltfFile {
            bytes: &self.bytes,
            name: &self.name,
            files: &self.files,
            options: &self.options,
        }
    }
}

/// Why a scene has no glTF file that could get a lightmap.
#[derive(Debug)]
#[non_exhaustive]
pub enum SourceError {
    /// The file cannot be read.
    Read(ReadError),
    /// The scene cannot be written.
    Write(io::Error),
    /// The file cannot get a lightmap.
    Patch(PatchError),
    /// Triangles would have no area in the single precision of the format.
    Precision,
}

impl fmt::Display for SourceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SourceError::Read(error) => error.fmt(f),
            SourceError::Write(error) => error.fmt(f),
            SourceError::Patch(error) => error.fmt(f),
            SourceError::Precision => f.write_str(
                "some triangles cannot be written in single precision: scale the model with --place",
            ),
        }
    }
}

impl std::error::Error for SourceError {}

impl From<ReadError> for SourceError {
    fn from(error: ReadError) -> SourceError {
        SourceError::Read(error)
    }
}

impl From<PatchError> for SourceError {
    fn from(error: PatchError) -> SourceError {
        SourceError::Patch(error)
    }
}

impl From<io::Error> for SourceError {
    fn from(error: io::Error) -> SourceError {
        SourceError::Write(error)
    }
}

impl BakeSource {
    /// A glTF file as it is, without a lightmap of azulejo's, and the scene that was read from it, to which
    /// others may have added light. `None` if the scene has other surfaces: `is_alone` says that those behind
    /// the file's own, such as the floor of a studio, are there for the light.
    ///
    /// # Errors
    /// [`SourceError::Read`].
    pub fn given(
        scene: &Scene,
        mut file: SourceFile,
        is_alone: bool,
    ) -> Result<Option<BakeSource>, SourceError> {
        // Read the file without a lightmap that is in it, to know where the objects of the scene come from.
        file.bytes = unbaked(file.bytes, &file.name).0;
        // Instances get light of their own as nodes.
        if let Some(expanded) = patch::expanded(&file.patched())? {
            file.bytes = expanded;
        }
        let read = gltf::read_with_origins(&file.bytes, &file.name, &file.files, &file.options);
        let (_, origins) = read?;
        // A scene with fewer objects, or with more that are not just there for the light, is not that of the file.
        let has_more = !is_alone && scene.objects.len() > origins.len();
        if has_more || scene.objects.len() < origins.len() {
            return Ok(None);
        }
        // Leave out what moves. Objects that the file does not have shade but do not receive.
        let (mut kept, mut receivers, mut origin_of) = (Vec::new(), Vec::new(), Vec::new());
        let mut moving = 0;
        for (number, object) in scene.objects.iter().enumerate() {
            let origin = origins.get(number);
            if origin.is_some_and(|o| o.stillness != Stillness::Still) {
                moving += 1;
                continue;
            }
            if origin.is_some() {
                receivers.push(kept.len() as u32);
                origin_of.push(number);
            }
            kept.push(object.clone());
        }
        let mut notes = Vec::new();
        if moving > 0 {
            notes.push(format!(
                "{moving} objects that are animated, skinned or morphed neither receive nor shade"
            ));
        }
        let order = vec![None; receivers.len()];
        Ok(Some(BakeSource {
            scene: Scene {
                objects: kept,
                ..scene.clone()
            },
            receivers,
            file,
            origins,
            origin_of,
            order,
            is_given: true,
            notes,
        }))
    }

    /// A scene as a new glTF file of meshes; if wished, cut along the lines on which one thing stands on
    /// another ([`meshes_of`]).
    ///
    /// # Errors
    /// [`SourceError`].
    pub fn written(scene: &Scene, cuts_contacts: bool) -> Result<BakeSource, SourceError> {
        BakeSource::of_meshes(meshes_of(scene, cuts_contacts))
    }

    /// A scene of meshes as a new glTF file.
    ///
    /// # Errors
    /// [`SourceError`].
    pub(super) fn of_meshes(mut scene: Scene) -> Result<BakeSource, SourceError> {
        let has_faces = |o: &Object| o.shape.mesh().is_some_and(|mesh| !mesh.faces.is_empty());
        scene.objects.retain(has_faces);
        // What was not found is light as it was computed; viewers refuse files that name it.
        let is_found: Vec<bool> = scene.textures.iter().map(|t| t.image.is_some()).collect();
        for material in &mut scene.materials {
            material.textures.retain(|&t| is_found[t as usize]);
        }
        let mut bytes = Vec::new();
        gltf::write_with(&scene, MattSurfaces::Said, &mut bytes)?;
        let file = SourceFile {
            bytes,
            name: "the written model".to_owned(),
            files: Folder::of_model(Path::new(".")),
            options: ReadOptions {
                most_elements: u64::MAX,
                ..ReadOptions::default()
            },
        };
        let read = gltf::read_with_origins(&file.bytes, &file.name, &file.files, &file.options);
        let (loaded, origins) = read?;
        let is_same = loaded.scene.objects.len() == scene.objects.len();
        let order: Vec<Vec<u32>> = scene.objects.iter().map(written_order).collect();
        let mut counts = origins.iter().zip(&order);
        let has_area = |scene: &Scene| {
            let receivers = scene.objects.iter().filter_map(Receiver::of_object);
            let mut visible = receivers.map(|r| r.visible_triangles());
            visible.any(|of_receiver| of_receiver.contains(&true))
        };
        if has_area(&scene) && !has_area(&loaded.scene) {
            return Err(SourceError::Precision);
        }
        if !is_same || !counts.all(|(origin, order)| order.len() == origin.faces.len()) {
            return Err(SourceError::Precision);
        }
        Ok(BakeSource {
            receivers: (0..scene.objects.len() as u32).collect(),
            origin_of: (0..scene.objects.len()).collect(),
            scene,
            file,
            origins,
            order: order.into_iter().map(Some).collect(),
            is_given: false,
            notes: Vec::new(),
        })
    }

    /// The file with a lightmap as PNG, which `MOZ_lightmap` names, in one binary file; lamps that are not surfaces are
    /// dark. What `azulejo bake` writes where nothing else is asked for.
    ///
    /// # Errors
    /// [`SourceError::Patch`] and [`SourceError::Write`].
    pub fn glb(&self, baked: &Baked) -> Result<PatchedFile, SourceError> {
        let bytes = BytePictures::new(baked, true);
        let pages = bytes.pictures.iter().map(|picture| picture.png(baked));
        let edit = LightmapEdit {
            content: None,
            objects: &self.layouts_in(baked, |receiver, t| bytes.of_triangles[receiver][t]),
            pages: &pages.collect::<io::Result<Vec<_>>>()?,
            uvs: LightmapUvs::default(),
            instances: InstanceMode::Copy,
            convention: Convention::Moz,
            lights: LightsMode::Dim,
            mipmaps: false,
            output: patch::Output {
                container: Container::Glb,
                stem: "",
            },
        };
        let file = self.file.patched();
        Ok(patch::with_lightmap(&file, &self.origins, &edit)?)
    }

    /// Where the faces of the file's objects lie in a lightmap of this source, for each of its origins.
    pub fn layouts(&self, baked: &Baked) -> Vec<Option<ObjectLayout>> {
        self.layouts_in(baked, |receiver, t| {
            baked.atlas.layout.receivers[receiver].pages[t]
        })
    }

    /// The same, where `picture` says which picture shows a triangle of a receiver.
    pub fn layouts_in(
        &self,
        baked: &Baked,
        picture: impl Fn(usize, usize) -> u32,
    ) -> Vec<Option<ObjectLayout>> {
        let mut layouts = vec![None; self.origins.len()];
        for (receiver, layout) in baked.atlas.layout.receivers.iter().enumerate() {
            let object = baked.objects[receiver];
            let Some(place) = self.receivers.iter().position(|&r| r == object) else {
                continue;
            };
            let in_order = |t: usize| match &self.order[place] {
                Some(order) => order[t] as usize,
                None => t,
            };
            let count = layout.uvs.len();
            layouts[self.origin_of[place]] = Some(ObjectLayout {
                uvs: (0..count).map(|t| layout.uvs[in_order(t)]).collect(),
                pages: (0..count).map(|t| picture(receiver, in_order(t))).collect(),
            });
        }
        layouts
    }
}

/// The triangles of an object in the order in which they are written: by material, in the order in which
/// faces first have it.
fn written_order(object: &Object) -> Vec<u32> {
    let Some(mesh) = (match &object.shape {
        Shape::Mesh(mesh) => Some(mesh),
        other => other.mesh(),
    }) else {
        return Vec::new();
    };
    let mut materials = Vec::new();
    let mut triangles = Vec::new();
    for (face, &material) in mesh.face_materials.iter().enumerate() {
        let known = materials.iter().position(|&m| m == material);
        let rank = known.unwrap_or_else(|| {
            materials.push(material);
            materials.len() - 1
        });
        let count = mesh.faces.get(face).len() - 2;
        triangles.extend(std::iter::repeat_n(rank, count));
    }
    let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
    order.sort_by_key(|&t| triangles[t as usize]);
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::synthetic::cube_room;
    use glam::DVec3;

    fn file(scene: &Scene) -> SourceFile {
        let mut bytes = Vec::new();
        gltf::write(scene, &mut bytes).unwrap();
        SourceFile {
            bytes,
            name: "room.glb".to_owned(),
            files: Folder::of_model(Path::new(".")),
            options: ReadOptions::default(),
        }
    }

    /// A file is taken as it is only for the objects that it has.
    #[test]
    fn files_with_other_surfaces_are_not_given() {
        let room = cube_room();
        let source = BakeSource::given(&room, file(&room), true)
            .unwrap()
            .unwrap();
        assert!(source.is_given && source.notes.is_empty());
        assert_eq!(source.receivers.len(), room.objects.len());
        let mut more = room.clone();
        more.objects.push(room.objects[0].clone());
        assert!(
            BakeSource::given(&more, file(&room), false)
                .unwrap()
                .is_none()
        );
        let lit = BakeSource::given(&more, file(&room), true).unwrap();
        // It shades, but receives nothing.
        assert_eq!(lit.unwrap().receivers.len(), room.objects.len());
        assert!(
            BakeSource::given(&room, file(&more), true)
                .unwrap()
                .is_none()
        );
    }

    #[test]
    fn objects_are_written_with_all_their_triangles() {
        let source = BakeSource::written(&cube_room(), true).unwrap();
        assert!(!source.is_given);
        for (order, origin) in source.order.iter().zip(&source.origins) {
            let mut order = order.clone().unwrap();
            assert_eq!(order.len(), origin.faces.len());
            order.sort_unstable();
            assert!(order.into_iter().eq(0..origin.faces.len() as u32));
        }
        let moved = |map: fn(DVec3) -> DVec3| {
            let mut room = cube_room();
            if let Shape::Mesh(mesh) = &mut room.objects[0].shape {
                mesh.positions.iter_mut().for_each(|p| *p = map(*p));
            }
            BakeSource::written(&room, false)
        };
        // Where single precision has steps of 64, positions are relative to a point near the room.
        let far = moved(|p| p + DVec3::splat(1e9)).unwrap();
        assert!(far.order.iter().all(Option::is_some));
        // Nothing that single precision holds is left of a room so small.
        let refused = moved(|p| 1e-60 * p);
        let counts = refused.map(|s| (s.scene.objects.len(), s.receivers.len()));
        assert!(matches!(counts, Err(SourceError::Precision)), "{counts:?}");
    }
}
