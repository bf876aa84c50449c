//! Where objects and faces come from.

use super::{accessor, triangle};
use crate::gltf::{FaceOrigin, ObjectOrigin, Stillness, read_with_origins};
use crate::{Memory, ReadOptions, gltf};

fn origins(file: &str) -> Vec<ObjectOrigin> {
    let (files, options) = (Memory::new(), ReadOptions::default());
    let read = read_with_origins(file.as_bytes(), "a.gltf", &files, &options);
    let (loaded, origins) = read.unwrap_or_else(|e| panic!("{e}"));
    let plain = gltf::read(file.as_bytes(), "a.gltf", &files, &options).unwrap();
    assert_eq!(loaded.scene, plain.scene);
    assert_eq!(loaded.warnings, plain.warnings);
    assert_eq!(origins.len(), loaded.scene.objects.len());
    for (object, origin) in loaded.scene.objects.iter().zip(&origins) {
        assert_eq!(object.shape.mesh().unwrap().faces.len(), origin.faces.len());
    }
    origins
}

const PRIMITIVE: &str = "{\"attributes\":{\"POSITION\":0}}";

#[test]
fn triangles_are_counted_in_the_file() {
    let corners: Vec<u8> = [0u16, 1, 2, 0, 1, 9, 2, 1, 0, 0]
        .iter()
        .flat_map(|i| i.to_le_bytes())
        .collect();
    let floats: Vec<f32> = corners
        .as_chunks::<4>()
        .0
        .iter()
        .map(|b| f32::from_le_bytes(*b))
        .collect();
    let accessors = accessor(5123, 10, "SCALAR");
    let indexed = "{\"attributes\":{\"POSITION\":0},\"indices\":1}";
    let points = "{\"attributes\":{\"POSITION\":0},\"mode\":0}";
    let rest = format!(
        "\"nodes\":[{{}},{{\"mesh\":1,\"scale\":[1,1,-1]}},{{\"mesh\":1}},{{\"mesh\":0}}],\
         \"meshes\":[{{\"primitives\":[{points}]}},{{\"primitives\":[{points},{indexed},{PRIMITIVE}]}}]"
    );
    let origins = origins(&triangle(&floats, &accessors, &rest));
    let face = |primitive, triangle| FaceOrigin {
        primitive,
        triangle,
    };
    assert_eq!(&origins[0].faces[..], [face(1, 0), face(1, 2), face(2, 0)]);
    let places: Vec<_> = origins
        .iter()
        .map(|o| (o.node, o.mesh, o.mirrored))
        .collect();
    assert_eq!(places, [(1, 1, true), (2, 1, false)]);
    assert!(std::sync::Arc::ptr_eq(&origins[0].faces, &origins[1].faces));
    assert!(
        origins
            .iter()
            .all(|o| o.stillness == Stillness::Still && o.instance.is_none())
    );
}

#[test]
fn what_moves() {
    use Stillness::{Animated, Morphed, Skinned, Still};
    let morphed = |weights: &str| {
        format!(
            "{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0}},\"targets\":[{{\"POSITION\":0}}]}}]{weights}}}"
        )
    };
    let pointer = |p: &str| {
        format!(
            "{{\"sampler\":0,\"target\":{{\"path\":\"pointer\",\"extensions\":{{\"KHR_animation_pointer\":{{\"pointer\":\"{p}\"}}}}}}}}"
        )
    };
    let rest = format!(
        "\"meshes\":[{{\"primitives\":[{PRIMITIVE}]}},{},{},{}],\
         \"nodes\":[{{\"mesh\":0}},{{\"children\":[2]}},{{\"children\":[3]}},{{\"mesh\":0}},{{\"mesh\":1}},\
         {{\"mesh\":1,\"weights\":[0.0]}},{{\"mesh\":2}},{{\"mesh\":3}},{{\"mesh\":0,\"skin\":0}},{{\"mesh\":0}}],\
         \"skins\":[{{\"joints\":[0]}}],\
         \"animations\":[{{\"samplers\":[],\"channels\":[{{\"sampler\":0,\"target\":{{\"node\":1,\"path\":\"translation\"}}}},\
         {{\"sampler\":0,\"target\":{{\"node\":5,\"path\":\"weights\"}}}},{},{}]}}]",
        morphed(""),
        morphed(",\"weights\":[0.5]"),
        morphed(""),
        pointer("/meshes/3/weights/0"),
        pointer("/nodes/9/rotation"),
    );
    let nodes: Vec<_> = origins(&triangle(&[], "", &rest))
        .iter()
        .map(|o| (o.node, o.stillness))
        .collect();
    let expected = [
        (0, Still),
        (3, Animated),
        (4, Still),
        (5, Morphed),
        (6, Morphed),
        (7, Morphed),
        (8, Skinned),
        (9, Animated),
    ];
    assert_eq!(nodes, expected);
}

#[test]
fn levels_and_instances() {
    let rest = format!(
        "\"meshes\":[{{\"primitives\":[{PRIMITIVE}]}}],\
         \"nodes\":[{{\"mesh\":0,\"extensions\":{{\"MSFT_lod\":{{\"ids\":[1,2]}}}}}},{{\"mesh\":0}},\
         {{\"children\":[3]}},{{\"mesh\":0}},\
         {{\"mesh\":0,\"extensions\":{{\"EXT_mesh_gpu_instancing\":{{\"attributes\":{{\"TRANSLATION\":0}}}}}}}}]"
    );
    let origins = origins(&triangle(&[], "", &rest));
    let levels: Vec<_> = origins
        .iter()
        .map(|o| (o.node, o.level_of_detail, o.instance))
        .collect();
    let expected = [
        (0, 0, None),
        (1, 1, None),
        (3, 2, None),
        (4, 0, Some(0)),
        (4, 0, Some(1)),
        (4, 0, Some(2)),
    ];
    assert_eq!(levels, expected);
}

/// What an animation moves, and coarser levels, are named at their nodes.
#[test]
fn lamps_that_move_and_levels_are_named() {
    let rest = format!(
        "\"extensionsUsed\":[\"KHR_lights_punctual\"],\
         \"extensions\":{{\"KHR_lights_punctual\":{{\"lights\":[{{\"type\":\"point\"}}]}}}},\
         \"animations\":[{{\"samplers\":[{{\"input\":0,\"output\":0}}],\
           \"channels\":[{{\"sampler\":0,\"target\":{{\"node\":1,\"path\":\"translation\"}}}}]}}],\
         \"meshes\":[{{\"primitives\":[{PRIMITIVE}]}}],\
         \"nodes\":[{{\"mesh\":0,\"extensions\":{{\"MSFT_lod\":{{\"ids\":[4]}}}}}},{{\"children\":[2]}},\
           {{\"extensions\":{{\"KHR_lights_punctual\":{{\"light\":0}}}}}},\
           {{\"extensions\":{{\"KHR_lights_punctual\":{{\"light\":0}}}}}},{{\"mesh\":0}}]"
    );
    let file = triangle(&[], "", &rest);
    let (loaded, _) = read_with_origins(
        file.as_bytes(),
        "lamps.gltf",
        &Memory::new(),
        &ReadOptions::default(),
    )
    .unwrap();
    let warned: Vec<String> = loaded.warnings.iter().map(|w| w.to_string()).collect();
    let has =
        |text: &str, place: &str| warned.iter().any(|w| w.contains(text) && w.contains(place));
    assert!(
        has("lamp that an animation moves", "nodes[2]"),
        "{warned:?}"
    );
    assert!(has("MSFT_lod", "nodes[0]"), "{warned:?}");
    assert!(
        !has("lamp that an animation moves", "nodes[3]"),
        "{warned:?}"
    );
}
