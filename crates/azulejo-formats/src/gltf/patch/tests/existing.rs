//! Lightmaps that files have, and coordinates that stay.

use super::craft::{json_of, two_squares};
use super::kept::check_same;
use super::{pages, usual};
use crate::gltf::patch::{
    GltfFile, LightmapUvs, NO_PAGE, ObjectLayout, coordinates, found_lightmap, strip, with_lightmap,
};
use crate::gltf::read_with_origins;
use crate::{Memory, ReadOptions};

/// Two meshes of two squares; the second has no coordinates if `is_whole` is false.
fn file(is_whole: bool) -> Vec<u8> {
    let mut craft = two_squares();
    let uvs = [0.0, 0.0, 0.0, 1.0, 0.5, 0.0, 0.5, 1.0, 1.0, 0.0, 1.0, 1.0];
    craft.floats(&uvs, "VEC2");
    let first = r#"{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":2,"TEXCOORD_1":2},"indices":1,"material":0}]}"#;
    let bare = first.replace(r#","TEXCOORD_0":2,"TEXCOORD_1":2"#, "");
    let second = if is_whole { first } else { &bare };
    craft.glb(&format!(
        r#""meshes":[{first},{second}],"nodes":[{{"mesh":0}},{{"mesh":1,"scale":[-1,1,1]}}],"materials":[{{}}]"#
    ))
}

#[test]
fn coordinates_stay_and_are_found_again() {
    let (bytes, options, files) = (file(true), ReadOptions::default(), Memory::new());
    let original = GltfFile {
        bytes: &bytes,
        name: "a.glb",
        files: &files,
        options: &options,
    };
    let (_, origins) = read_with_origins(&bytes, "a.glb", &files, &options).unwrap();
    let uv_set = coordinates(&original, &origins, 1).unwrap();
    assert!(!uv_set.is_named && !uv_set.is_own && uv_set.pages[0].picture == Ok(None));
    let first: &ObjectLayout = uv_set.objects[0].as_ref().unwrap();
    assert_eq!((first.uvs.len(), first.uvs[0][0]), (4, [0.0, 0.0]));
    // The mirrored node has the corners of each face in the other order.
    let second = uv_set.objects[1].as_ref().unwrap();
    let [a, b, c] = first.uvs[1];
    assert_eq!(second.uvs[1], [a, c, b]);

    let pictures = pages(1);
    let mut edit = usual(&uv_set.objects, &pictures);
    edit.uvs = LightmapUvs::Existing(1);
    let patched = with_lightmap(&original, &origins, &edit).unwrap();
    let json = json_of(&patched);
    let accessors = json["accessors"].as_array().unwrap().len();
    assert_eq!(accessors, 3, "no vertices are added");
    let lightmap = &json["materials"][0]["extensions"]["MOZ_lightmap"];
    assert_eq!(lightmap["texCoord"], 1);
    check_same(
        "a.glb",
        &bytes,
        &strip(&patched.bytes, "a.glb").unwrap().bytes,
    );

    let baked = GltfFile {
        bytes: &patched.bytes,
        ..original
    };
    let again = found_lightmap(&baked, &origins, None).unwrap();
    assert!(again.is_named && again.is_own && again.is_one_set);
    assert_eq!((again.set, &again.objects), (1, &uv_set.objects));
    assert_eq!(again.pages.len(), 1);
    let picture = Ok(Some(pictures[0].picture.clone()));
    assert_eq!(again.pages[0].picture, picture);
    assert_eq!(again.pages[0].intensity, pictures[0].intensity);
}

#[test]
fn what_has_no_coordinates_is_refused() {
    let (bytes, options, files) = (file(false), ReadOptions::default(), Memory::new());
    let original = GltfFile {
        bytes: &bytes,
        name: "a.glb",
        files: &files,
        options: &options,
    };
    let (_, origins) = read_with_origins(&bytes, "a.glb", &files, &options).unwrap();
    let uv_set = coordinates(&original, &origins, 1).unwrap();
    assert!(uv_set.objects[0].is_some() && uv_set.objects[1].is_none());
    assert!(coordinates(&original, &origins, 2).unwrap().objects[0].is_none());
    let pictures = pages(1);
    let whole = vec![uv_set.objects[0].clone(); 2];
    let mut edit = usual(&whole, &pictures);
    edit.uvs = LightmapUvs::Existing(1);
    let refused = with_lightmap(&original, &origins, &edit).unwrap_err();
    assert!(refused.to_string().contains("TEXCOORD_1"), "{refused}");
    assert_ne!(uv_set.objects[0].as_ref().unwrap().pages[0], NO_PAGE);
}
