//! The glTF file that gets the lightmap of a document: its own, as long as it still shows what that has.

use crate::document::SceneDocument;
use azulejo::formats::gltf;
use azulejo::formats::{Folder, Format, ReadOptions};
use azulejo::lightmap::{BakeSource, SourceFile};
use azulejo::models::{read_bytes, unbaked};
use azulejo::scene::{Light, Object, Scene};
use std::path::Path;

/// Distance of vertices beside the size of the scene up to which they count as the same: placements are
/// applied in another order here.
const SAME_PLACE: f64 = 1e-9;

/// The scene of a document with the file that gets its lightmap: a new one if backs are to become faces.
///
/// # Errors
///
/// What cannot be read or written, as text.
pub fn of(document: &SceneDocument, splits_sides: bool) -> Result<BakeSource, String> {
    let mut scene = document.scene();
    scene.drop_lightmaps();
    if !splits_sides && let Some(source) = own_file(document, &mut scene)? {
        return Ok(source);
    }
    BakeSource::written(&scene, true).map_err(|e| e.to_string())
}

/// The glTF file of the document, if it has one and the surfaces of both are the same.
fn own_file(document: &SceneDocument, scene: &mut Scene) -> Result<Option<BakeSource>, String> {
    let [file] = &document.source_files[..] else {
        return Ok(None);
    };
    if file.format != Some(Format::Gltf) {
        return Ok(None);
    }
    // A file that is gone is written anew.
    let Ok(bytes) = read_bytes(&file.path) else {
        return Ok(None);
    };
    let name = file.path.to_string_lossy().into_owned();
    let options = ReadOptions::default();
    let read = |bytes: &[u8]| {
        let loaded = gltf::read(bytes, &name, &Folder::of_model(&file.path), &options);
        loaded.ok().map(|loaded| loaded.scene)
    };
    let (plain, notes) = unbaked(bytes.clone(), &name);
    let Some(mut own) = read(&plain) else {
        return Ok(None);
    };
    own.drop_lightmaps();
    let is_same = if notes.is_empty() {
        is_same(scene, &own)
    } else {
        read(&bytes).is_some_and(|baked| unbake(scene, baked, own))
    };
    if !is_same {
        return Ok(None);
    }
    let source = SourceFile {
        bytes: plain,
        files: Folder::of_model(Path::new(&name)),
        name,
        options,
    };
    let mut given = BakeSource::given(scene, source, true).map_err(|e| e.to_string())?;
    if let Some(given) = &mut given {
        given.notes.splice(0..0, notes);
    }
    Ok(given)
}

/// Makes a scene that was read of a baked file what that was before; whether its surfaces are those of the file.
fn unbake(scene: &mut Scene, mut baked: Scene, plain: Scene) -> bool {
    baked.drop_lightmaps();
    if !is_same(scene, &baked) {
        return false;
    }
    relight(scene, &baked.lights, plain.lights);
    if scene.materials.len() == plain.materials.len() {
        return true;
    }
    // A material on several pages has become several; pictures of the surroundings may have been added since.
    let has_surroundings = scene.surrounding_pictures().next().is_some();
    (scene.objects, scene.materials) = (plain.objects, plain.materials);
    scene.textures = plain.textures;
    !has_surroundings
}

/// Gives lamps that were dimmed for a lightmap back what they were, unless they have been edited.
fn relight(scene: &mut Scene, dimmed: &[Light], lights: Vec<Light>) {
    for (light, shining) in dimmed.iter().zip(lights) {
        let mut lights = scene.lights.iter_mut();
        if let Some(own) = lights.find(|own| own.name == light.name && own.kind == light.kind) {
            own.kind = shining.kind;
        }
    }
}

/// Whether two scenes have the same surfaces of the same materials; names and lights do not matter.
fn is_same(a: &Scene, b: &Scene) -> bool {
    let apart = SAME_PLACE * a.bounds().diagonal();
    let materials = a.materials.len() == b.materials.len()
        && (a.materials.iter().zip(&b.materials)).all(|(a, b)| a == b);
    materials
        && a.objects.len() == b.objects.len()
        && (a.objects.iter().zip(&b.objects)).all(|(a, b)| is_same_object(a, b, apart))
}

fn is_same_object(a: &Object, b: &Object, apart: f64) -> bool {
    let (Some(a), Some(b)) = (a.shape.placed_mesh(), b.shape.placed_mesh()) else {
        return false;
    };
    a.mesh.faces == b.mesh.faces
        && a.mesh.face_materials == b.mesh.face_materials
        && a.mesh.positions.len() == b.mesh.positions.len()
        && (0..a.mesh.positions.len() as u32)
            .all(|v| a.position(v).distance(b.position(v)) <= apart)
}
