//! Edits of whole files.

mod corpus;
mod craft;
mod crafted;
mod existing;
mod expansion;
mod kept;
mod materials;
mod vertex_light;

use super::super::origin::ObjectOrigin;
use super::convert::Overlay;
use super::*;
use crate::{ReadOptions, gltf};
use azulejo_scene::Scene;

/// Files in memory that a test edits.
pub struct Case<'a> {
    pub bytes: &'a [u8],
    pub name: &'a str,
    pub files: &'a dyn crate::Files,
}

/// How a test lays out faces.
#[derive(Clone, Copy, Debug)]
pub enum Charts {
    /// No vertex is in two charts.
    One,
    /// Every face is a chart.
    Faces,
    /// Faces are in one of several charts by a hash of this and their number.
    Random(u64),
}

fn mixed(a: u64, b: u64) -> u64 {
    let mut x = a.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ b;
    x ^= x >> 31;
    x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^ x >> 29
}

/// A number in 0..1 of single precision.
fn share(hash: u64) -> f32 {
    (hash >> 40) as f32 / (1u64 << 24) as f32
}

/// Layouts for all objects of a scene that stand still; every third of them gets nothing if `some`.
pub fn layouts(
    scene: &Scene,
    origins: &[ObjectOrigin],
    charts: Charts,
    pages: u32,
) -> Vec<Option<ObjectLayout>> {
    let objects = scene.objects.iter().zip(origins).enumerate();
    objects
        .map(|(i, (object, origin))| {
            let mesh = object.shape.mesh()?;
            if origin.instance.is_some() {
                return None;
            }
            assert_eq!(mesh.faces.len(), origin.faces.len());
            let mut layout = ObjectLayout::default();
            for (f, face) in origin.faces.iter().enumerate() {
                let chart = match charts {
                    Charts::One => 0,
                    Charts::Faces => f as u64,
                    Charts::Random(seed) => mixed(seed, f as u64) % 3,
                };
                let corners = mesh.faces.get(f);
                let uv = |k: usize| {
                    let key = mixed(chart << 32 | u64::from(corners[k]), i as u64);
                    [share(key), share(mixed(key, 1))]
                };
                layout.uvs.push([uv(0), uv(1), uv(2)]);
                layout
                    .pages
                    .push((face.primitive + i as u32) % pages.max(1));
            }
            Some(layout)
        })
        .collect()
}

/// Pages with pictures that are not pictures.
pub fn pages(count: u32) -> Vec<LightmapPage> {
    (0..count)
        .map(|i| LightmapPage {
            directions: Vec::new(),
            name: format!("light \"{i}\""),
            picture: vec![i as u8; 5 + i as usize],
            media_type: MediaType::Png,
            intensity: 12.5 + f64::from(i),
            fallback: None,
        })
        .collect()
}

/// An edit with the usual choices.
pub fn usual<'a>(
    objects: &'a [Option<ObjectLayout>],
    pages: &'a [LightmapPage],
) -> LightmapEdit<'a> {
    LightmapEdit {
        content: None,
        objects,
        pages,
        uvs: LightmapUvs::default(),
        instances: InstanceMode::Copy,
        convention: Convention::Moz,
        lights: LightsMode::Dim,
        mipmaps: false,
        output: Output {
            container: Container::Same,
            stem: "a",
        },
    }
}

/// Edits a file, and checks that everything else stays and that the edit can be undone. `None` if the file
/// cannot be read.
pub fn check(
    case: &Case,
    charts: Charts,
    change: impl Fn(&mut LightmapEdit),
) -> Option<PatchedFile> {
    let options = ReadOptions::default();
    let read = |bytes: &[u8], files: &dyn crate::Files| {
        gltf::read_with_origins(bytes, case.name, files, &options)
    };
    let original = GltfFile {
        bytes: case.bytes,
        name: case.name,
        files: case.files,
        options: &options,
    };
    let Ok((loaded, origins)) = read(case.bytes, case.files) else {
        let pages = pages(1);
        // Without objects there may be nothing to refuse.
        drop(with_lightmap(&original, &[], &usual(&[], &pages)));
        return None;
    };
    assert_eq!(loaded.scene.objects.len(), origins.len());
    let pages = pages(2);
    let objects = layouts(&loaded.scene, &origins, charts, 2);
    let mut edit = usual(&objects, &pages);
    change(&mut edit);
    let patched = with_lightmap(&original, &origins, &edit).unwrap_or_else(|e| panic!("{e}"));
    let stripped = strip(&patched.bytes, case.name).unwrap();
    assert!(stripped.is_exact);
    kept::check_same(case.name, case.bytes, &stripped.bytes);
    let names = patched.files.iter().map(|(n, _)| n);
    assert!(stripped.unused_files.iter().eq(names.clone()));
    let distinct: std::collections::HashSet<&String> = names.collect();
    assert_eq!(distinct.len(), patched.files.len());
    let files = Overlay {
        old: case.files,
        new: &patched.files,
    };
    let (again, new_origins) = read(&patched.bytes, &files).unwrap_or_else(|e| panic!("{e}"));
    kept::check_values(case.bytes, &patched.bytes);
    kept::check_scene(&loaded.scene, &again.scene);
    kept::check_origins(&origins, &new_origins);
    // Once more, over what is there.
    let file = GltfFile {
        bytes: &patched.bytes,
        files: &files,
        ..original
    };
    kept::check_coordinates(&file, &new_origins, &objects);
    let twice = with_lightmap(&file, &origins, &edit).unwrap();
    kept::check_same(case.name, &twice.bytes, &patched.bytes);
    Some(patched)
}
