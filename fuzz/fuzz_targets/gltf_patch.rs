//! Any bytes as glTF: a lightmap can be put into what is read, its removal gives back the same values and buffers,
//! and the edited file has the same faces, also with light of its vertices.
#![no_main]

use azulejo_formats::gltf::patch::{
    self, Container, Convention, GltfFile, InstanceMode, LightmapEdit, LightmapPage, LightmapUvs,
    LightsMode, MediaType, ObjectLayout, Output, strip, with_lightmap, with_vertex_light,
};
use azulejo_formats::gltf::{FaceOrigin, ObjectOrigin, read_with_origins};
use azulejo_formats::{Memory, ReadOptions};
use azulejo_scene::{Rgb, Scene, Shape};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    // Files of many objects without content are read with blanks between them alone, which edits leave out.
    if bytes.iter().filter(|b| **b == b'{').count() > 900 {
        return;
    }
    let options = ReadOptions::in_proportion(bytes.len());
    let files = Memory::new().with("a.bin", bytes);
    drop(strip(bytes, "fuzz.gltf"));
    let Ok((loaded, origins)) = read_with_origins(bytes, "fuzz.gltf", &files, &options) else {
        return;
    };
    assert_eq!(loaded.scene.objects.len(), origins.len());
    let page = LightmapPage {
        directions: vec![b"picture".to_vec(); 3],
        name: "light".to_owned(),
        picture: b"picture".to_vec(),
        media_type: MediaType::Png,
        intensity: 2.0,
        fallback: None,
    };
    let objects: Vec<Option<ObjectLayout>> = origins.iter().map(layout).collect();
    let edit = LightmapEdit {
        content: Some("a-b"),
        objects: &objects,
        pages: &[page],
        uvs: LightmapUvs::default(),
        instances: InstanceMode::Copy,
        convention: Convention::Moz,
        lights: LightsMode::Dim,
        mipmaps: false,
        output: Output {
            container: Container::Same,
            stem: "fuzz",
        },
    };
    let original = GltfFile {
        bytes,
        name: "fuzz.gltf",
        files: &files,
        options: &options,
    };
    if let Ok(Some(expanded)) = patch::expanded(&original) {
        let whole = read_with_origins(&expanded, "wide.gltf", &files, &ReadOptions::default());
        let (wide, _) = whole.expect("what is expanded is read");
        assert!(wide.scene.objects.len() >= loaded.scene.objects.len());
        drop(strip(&expanded, "wide.gltf").expect("an expansion can be undone"));
    }
    let output = edit.output;
    if let Ok(lit) = with_vertex_light(&original, &origins, &lit(loaded.scene), output) {
        let all = lit.files.iter();
        let files = all.fold(files.clone(), |all, (name, bytes)| {
            all.with(name, bytes.clone())
        });
        let read = read_with_origins(&lit.bytes, "lit.gltf", &files, &ReadOptions::default());
        let (_, again) = read.expect("what is lit is read");
        assert!(faces(&again).eq(faces(&origins)));
    }
    // Texts in UTF-16 and cut files are read, but not edited.
    let Ok(patched) = with_lightmap(&original, &origins, &edit) else {
        return;
    };
    let stripped = strip(&patched.bytes, "fuzz.gltf").expect("what was edited has a lightmap");
    let had_one = strip(bytes, "fuzz.gltf").is_ok();
    assert!(had_one || stripped.is_exact);
    // Blanks are gone; what is left is the same once more.
    let once_more = GltfFile {
        bytes: &stripped.bytes,
        ..original
    };
    let twice = with_lightmap(&once_more, &origins, &edit).expect("what was stripped is edited");
    assert!(twice.bytes == patched.bytes);
    let again = strip(&twice.bytes, "fuzz.gltf").expect("what was edited has a lightmap");
    assert!(had_one || again.bytes == stripped.bytes);
    let all = patched.files.iter();
    let files = all.fold(files.clone(), |all, (name, bytes)| {
        all.with(name, bytes.clone())
    });
    let options = ReadOptions::default();
    let read = read_with_origins(&patched.bytes, "again.gltf", &files, &options);
    let (_, again) = read.expect("what is edited is read");
    assert!(had_one || faces(&again).eq(faces(&origins)));
});

/// The scene with the same light everywhere.
fn lit(mut scene: Scene) -> Scene {
    scene.unfold();
    for object in &mut scene.objects {
        if let Shape::Mesh(mesh) = &mut object.shape {
            mesh.irradiance = vec![Rgb::grey(3.0); mesh.positions.len()];
        }
    }
    scene
}

/// A layout in which neighbours share some corners and not others.
fn layout(origin: &ObjectOrigin) -> Option<ObjectLayout> {
    let count = origin.faces.len();
    let share = |f: usize| (f % 3) as f32 / 4.0;
    let uvs = (0..count).map(|f| [[share(f), 0.5], [0.25, 0.5], [0.5, share(f)]]);
    Some(ObjectLayout {
        uvs: uvs.collect(),
        pages: vec![0; count],
    })
}

fn faces(origins: &[ObjectOrigin]) -> impl Iterator<Item = (usize, &[FaceOrigin])> {
    origins.iter().map(|origin| (origin.node, &*origin.faces))
}
