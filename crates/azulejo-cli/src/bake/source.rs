//! What is baked: a glTF file that stays as it is, or models that become one.

use super::args::BakeArgs;
use crate::args::ReadingArgs;
use crate::failure::Failure;
use crate::input;
use crate::session::Session;
use azulejo::lightmap::meshes_of;
use azulejo::models::{read_bytes, unbaked};
use azulejo_formats::gltf::{self, MattSurfaces, ObjectOrigin, Stillness};
use azulejo_formats::{Folder, Format, ReadOptions};
use azulejo_scene::{Object, Scene, Shape};
use azulejo_trace::Progress;
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
    /// Reads a file as the command says.
    pub fn read(reading: &ReadingArgs, path: &Path) -> Result<SourceFile, Failure> {
        let files = Folder::of_model(path);
        Ok(SourceFile {
            bytes: read_bytes(path)?,
            name: path.to_string_lossy().into_owned(),
            files: (reading.allow.iter()).fold(files, |files, more| files.allow(more)),
            options: ReadOptions {
                lod: reading.lod,
                most_elements: reading.most_elements,
                darkens_unpainted: true,
                ..ReadOptions::default()
            },
        })
    }

    /// For edits.
    pub fn patched(&self) -> gltf::patch::GltfFile<'_> {
        gltf::patch::GltfFile {
            bytes: &self.bytes,
            name: &self.name,
            files: &self.files,
            options: &self.options,
        }
    }
}

impl BakeSource {
    /// Reads the models of a command.
    pub fn read(args: &BakeArgs, session: &mut Session) -> Result<BakeSource, Failure> {
        let scene = input::read_relit(&args.input, args.first_pass.instant(), session)?;
        if session.formats().first() == Some(&Format::Gltf) {
            if let Some(source) = BakeSource::given(&scene, args, session)? {
                return Ok(source);
            }
            session.note("several models with surfaces: they become a new glTF file");
        }
        BakeSource::written(scene, args)
    }

    /// The first model as it is; `None` if others add surfaces to it.
    fn given(
        scene: &Scene,
        args: &BakeArgs,
        session: &mut Session,
    ) -> Result<Option<BakeSource>, Failure> {
        let path = &args.input.scenes[0];
        if path == Path::new("-") {
            return Err(Failure::misuse(
                "a glTF file that gets a lightmap cannot come from standard input: name the file",
            ));
        }
        let mut file = SourceFile::read(&args.input.reading, path)?;
        // As the scene was read: without a lightmap of azulejo's.
        file.bytes = unbaked(file.bytes, &file.name).0;
        let read = gltf::read_with_origins(&file.bytes, &file.name, &file.files, &file.options);
        let (_, origins) = read.map_err(Failure::failed)?;
        // What is added for light alone, such as the floor of a studio, comes behind.
        let has_more = args.input.scenes.len() > 1 && scene.objects.len() > origins.len();
        if has_more || scene.objects.len() < origins.len() {
            return Ok(None);
        }
        let (mut kept, mut receivers, mut origin_of) = (Vec::new(), Vec::new(), Vec::new());
        let mut moving = 0;
        for (number, object) in scene.objects.iter().enumerate() {
            let origin = origins.get(number);
            if origin.is_some_and(|o| o.stillness != Stillness::Still) {
                moving += 1;
                continue;
            }
            if origin.is_some_and(|o| o.instance.is_none()) {
                receivers.push(kept.len() as u32);
                origin_of.push(number);
            }
            kept.push(object.clone());
        }
        if moving > 0 {
            session.note(&format!(
                "{moving} objects that are animated, skinned or morphed neither receive nor shade"
            ));
        }
        if origins.iter().any(|o| o.instance.is_some()) {
            session.note(
                "instances by EXT_mesh_gpu_instancing shade, but have no lightmap: they share one mesh",
            );
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
        }))
    }

    /// Models as a new glTF file.
    fn written(scene: Scene, args: &BakeArgs) -> Result<BakeSource, Failure> {
        let mut scene = meshes_of(&scene, !args.texels.no_split_contacts);
        let has_faces = |o: &Object| o.shape.mesh().is_some_and(|mesh| !mesh.faces.is_empty());
        scene.objects.retain(has_faces);
        let mut bytes = Vec::new();
        gltf::write_with(&scene, MattSurfaces::Said, &mut bytes).map_err(Failure::failed)?;
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
        let (loaded, origins) = read.map_err(Failure::failed)?;
        let is_same = loaded.scene.objects.len() == scene.objects.len();
        let order: Vec<Option<Vec<u32>>> = scene
            .objects
            .iter()
            .map(|o| Some(written_order(o)))
            .collect();
        let counts = origins.iter().zip(&order);
        let is_complete = counts.clone().all(|(origin, order)| {
            order
                .as_ref()
                .is_some_and(|order| order.len() == origin.faces.len())
        });
        if !is_same || !is_complete {
            return Err(Failure::failed(
                "some triangles cannot be written in single precision: scale the model with --place",
            ));
        }
        Ok(BakeSource {
            receivers: (0..scene.objects.len() as u32).collect(),
            origin_of: (0..scene.objects.len()).collect(),
            scene,
            file,
            origins,
            order,
            is_given: false,
        })
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

/// Removes the lightmap of a file.
pub fn stripped(path: &Path, progress: &Progress) -> Result<gltf::patch::StrippedFile, Failure> {
    progress.begin("reading", 0);
    let bytes = read_bytes(path)?;
    gltf::patch::strip(&bytes, &path.to_string_lossy()).map_err(Failure::failed)
}
