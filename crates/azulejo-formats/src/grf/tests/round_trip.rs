//! Written scenes and documents read back bit by bit.

use super::exact_shapes::{exact, shared_figures};
use super::*;
use azulejo_scene::brdf::Description;
use azulejo_scene::{
    Attribute, BackIrradiance, Backplate, BackplateFit, Brdf, Camera, Dielectric, FinishMaps, Fog,
    Light, LightKind, Material, NumberPicture, Object, Opacity, OpacityChannel, OpacityMode,
    OpacityPicture, PictureChannel, Primitive, PrimitiveKind, Relief, ReliefKind, Rgb,
    SceneBackground, Sidedness, SurfaceGrid, SurfaceLight, Texture, Units, Up, WrapMode,
};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;
use std::sync::Arc;

/// Checks that writing and reading a document preserves its text and its scene.
fn check_document(text: &str) {
    let once = document_text(&document(text));
    assert_eq!(document_text(&document(&once)), once);
    assert_eq!(scene(&once), scene(text));
}

#[test]
fn documents() {
    check_document(CUBE);
    check_document(EVERYTHING);
    check_document(
        &triangle("use color c (0,1,2) rgb (1,0,0) brdf ward ax = .1 ks = (.1, 0.2, 3e-1) texture \"a b\"")
            .replace(
                "begin mesh",
                "def c = rgb (1,1,1) def d = brdf \"x.binary\" begin mesh",
            ),
    );
}

#[test]
fn a_picture_behind_the_image_is_kept() {
    for (text, fit, radiance) in [
        ("fit = scaled", BackplateFit::Scaled, 1.0),
        (
            "radiance = 0.25 fit = centered",
            BackplateFit::Centered,
            0.25,
        ),
        ("fit = tiled radiance = 3", BackplateFit::Tiled, 3.0),
    ] {
        let text = format!("ext background begin picture = \"sky.png\" {text} end ext\n");
        check_document(&text);
        let scene = scene(&text);
        let plate = Backplate {
            texture: 0,
            fit,
            radiance,
        };
        assert_eq!(scene.background, Some(SceneBackground::Backplate(plate)));
        assert_eq!(scene.textures[0].path, "sky.png");
        let written = document_text(&GrfDocument::from_scene(&scene));
        assert_eq!(self::scene(&written), scene, "{written}");
    }
}

#[test]
fn a_document_keeps_what_it_does_not_know() {
    let text = document_text(&document(EVERYTHING));
    assert!(
        text.contains("params begin\nview (0, 0, 1) dependent 3\nend params\n"),
        "{text}"
    );
    assert!(
        text.contains("ext weather begin\nrain = \"a \\\" b\" end nothing\nend ext\n"),
        "{text}"
    );
}

#[test]
fn canonical_text() {
    let mut scene = Scene::default();
    let white = scene.add_material(Material::diffuse("white", Rgb::grey(0.7)));
    let mut mesh = Mesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        irradiance: vec![Rgb::new(1.0, 0.5, 0.25); 3],
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2], white);
    scene.objects.push(Object::new("floor", Shape::Mesh(mesh)));
    assert_eq!(
        written(&scene),
        "def white = brdf diffuse kd = 0.7\nbegin\n\
         ext object begin name = \"floor\" end ext\nbegin mesh\nuse brdf white\n\
         begin vertices\nirad (1, 0.5, 0.25) (0, 0, 0)\nirad (1, 0.5, 0.25) (1, 0, 0)\n\
         irad (1, 0.5, 0.25) (0, 1, 0)\nend vertices\nbegin faces\n(0, 1, 2)\nend faces\n\
         end mesh\nend def\n"
    );
}

#[test]
fn corners_that_disagree_split_their_vertex_in_the_file_only() {
    let mut mesh = Mesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::NEG_Y, DVec3::Z],
        irradiance: (0..5).map(|v| Rgb::grey(f64::from(v))).collect(),
        normals: Some(Attribute {
            values: vec![DVec3::Z, DVec3::X],
            corners: Some(vec![0, 0, 0, 1, 0, 1]),
        }),
        uvs: Some(Attribute::per_vertex(vec![DVec2::ONE; 5])),
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2], 0);
    mesh.push_face(&[0, 1, 3], 0);
    let mut scene = Scene::default();
    scene.add_material(Material::default());
    scene.objects.push(Object::new("", Shape::Mesh(mesh)));
    let text = written(&scene);
    assert!(text.contains("(0, 1, 2)\n(5, 1, 3)\n"), "{text}");
    assert!(
        text.contains("end mesh\next shared begin vertices = 0 end ext\n"),
        "{text}"
    );
    let back = super::scene(&text);
    let (mesh, given) = (super::mesh(&back, 0), super::mesh(&scene, 0));
    assert_eq!(
        (&mesh.positions, &mesh.faces),
        (&given.positions, &given.faces)
    );
    assert_eq!(mesh.irradiance, given.irradiance);
    let normal = |m: &Mesh, corner: usize| {
        let normals = m.normals.as_ref().unwrap();
        normals.at(corner, m.faces.corners[corner])
    };
    assert!((0..6).all(|c| normal(mesh, c) == normal(given, c)));
    assert_eq!(written(&back), text);
    // A copy that was moved by hand is a vertex of its own.
    let moved = text.replace(
        "irad (0, 0, 0) uv (1, 1) (0, 0, 0)\nend",
        "irad (0, 0, 0) uv (1, 1) (0, 0, 9)\nend",
    );
    assert_ne!(moved, text);
    let apart = loaded(&moved);
    assert_eq!(super::mesh(&apart.scene, 0).positions.len(), 6);
    assert!(apart.warnings[0].to_string().contains("kept apart"));
}

/// Third-party models: converted to GRF they keep their faces, and from then on every bit.
#[test]
fn models_from_elsewhere() {
    let Some(data) = azulejo_testing::data() else {
        return;
    };
    let folders = ["scenes", "corpus/obj"].map(|f| data.join(f));
    let mut count = 0;
    for folder in folders {
        let files = crate::Folder::new(&folder);
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|e| e != "obj") {
                continue;
            }
            let name = path.display().to_string();
            let bytes = std::fs::read(&path).unwrap();
            let Ok(loaded) = crate::obj::read(&bytes, &name, &files) else {
                continue;
            };
            count += 1;
            let text = written(&loaded.scene);
            let once = read(text.as_bytes(), &name, &files).unwrap().scene;
            let faces = |s: &Scene| {
                (0..s.objects.len())
                    .map(|o| mesh(s, o).faces.len())
                    .sum::<usize>()
            };
            assert_eq!(faces(&once), faces(&loaded.scene), "{name}");
            assert_eq!(once.materials, loaded.scene.materials, "{name}");
            assert!(written(&once) == text, "{name}");
        }
    }
    assert!(count > 4, "{count} models");
}

pub(super) fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        -100.0..100.0,
        Just(0.0),
        Just(-0.5),
        Just(1e-300),
        Just(123_456_789.012_345_67),
        -1e200..1e200,
    ]
}

fn point() -> impl Strategy<Value = DVec3> {
    [number(), number(), number()].prop_map(DVec3::from_array)
}

pub(super) fn small_point() -> impl Strategy<Value = DVec3> {
    [-9.0..9.0, -9.0..9.0, -9.0..9.0].prop_map(DVec3::from_array)
}

pub(super) fn direction() -> impl Strategy<Value = DVec3> {
    small_point().prop_filter_map("no direction", DVec3::try_normalize)
}

pub(super) fn light_rgb() -> impl Strategy<Value = Rgb> {
    [0.0..1e3, 0.0..1e3, 0.0..1e3].prop_map(Rgb::from)
}

fn share() -> impl Strategy<Value = Rgb> {
    prop_oneof![
        Just(Rgb::BLACK),
        (0.0..=0.5).prop_map(Rgb::grey),
        [0.0..=0.5, 0.0..=0.5, 0.0..=0.5].prop_map(Rgb::from),
    ]
}

/// Typical names, and arbitrary ones.
fn name() -> impl Strategy<Value = String> {
    prop_oneof![
        Just(String::new()),
        "[a-z]{1,3}",
        Just("m0".to_owned()),
        Just("end ext".to_owned()),
        Just("C:\\maps\\".to_owned()),
        any::<String>(),
    ]
}

fn brdf() -> impl Strategy<Value = Arc<Brdf>> {
    let lewis = (share(), share(), 0.0..1e6f64).prop_map(|(kd, ks, n)| {
        Description::model(
            "lewis",
            [("kd", kd.into()), ("ks", ks.into()), ("n", n.into())],
        )
    });
    let file = any::<String>().prop_map(|path| Description::File {
        path,
        content: None,
    });
    prop_oneof![lewis, file].prop_map(|d| Arc::new(Brdf::new(d).unwrap()))
}

fn material(textures: usize) -> impl Strategy<Value = Material> {
    let dielectric =
        (0.1..3.0, share(), any::<bool>()).prop_map(|(ior, transmittance, thin)| Dielectric {
            ior,
            transmittance,
            thin,
        });
    let opacity = option::weighted(0.2, opacity(textures));
    let maps = (option::weighted(0.2, finish(textures)), relief(textures));
    let picture = option::weighted(0.3, 0..textures.max(1) as u32);
    let picture = picture.prop_map(move |p| p.filter(|_| textures > 0));
    let textures = vec(0..textures.max(1) as u32, 0..=3.min(textures));
    let emission = prop_oneof![3 => Just(Rgb::BLACK), 1 => light_rgb()];
    (
        name(),
        share(),
        share(),
        option::weighted(0.2, dielectric),
        (emission, picture, any::<bool>(), sidedness()),
        (textures, opacity, maps),
        option::weighted(0.2, brdf()),
    )
        .prop_map(
            |(
                name,
                diffuse,
                mirror,
                dielectric,
                (emission, emission_picture, emits_back, sidedness),
                (textures, opacity, (finish, relief)),
                brdf,
            )| {
                Material {
                    name,
                    diffuse,
                    mirror,
                    dielectric,
                    emission,
                    emission_picture,
                    emits_back,
                    sidedness,
                    textures,
                    brdf,
                    opacity,
                    finish,
                    relief,
                    lightmap: None,
                }
            },
        )
}

fn finish(textures: usize) -> impl Strategy<Value = FinishMaps> {
    let channel = prop_oneof![
        Just(PictureChannel::Red),
        Just(PictureChannel::Green),
        Just(PictureChannel::Blue)
    ];
    let picture = move || {
        let picture = option::weighted(0.5, (0..textures.max(1) as u32, channel.clone()));
        picture.prop_map(move |p| p.filter(|_| textures > 0))
    };
    let number = |(texture, channel)| NumberPicture { texture, channel };
    (share(), 0.0..=1.0f64, 0.0..=1.0f64, picture(), picture()).prop_map(
        move |(base, metallic, roughness, of_metal, of_roughness)| FinishMaps {
            base,
            metallic,
            roughness,
            metallic_picture: of_metal.map(number),
            roughness_picture: of_roughness.map(number),
        },
    )
}

fn relief(textures: usize) -> impl Strategy<Value = Option<Relief>> {
    let kind = prop_oneof![
        (0.0..2.0f64).prop_map(|scale| ReliefKind::Normals { scale }),
        (-2.0..2.0f64).prop_map(|slope| ReliefKind::Heights { slope }),
    ];
    let relief = (0..textures.max(1) as u32, kind);
    let relief = relief.prop_map(|(texture, kind)| Relief { texture, kind });
    option::weighted(0.2, relief).prop_map(move |r| r.filter(|_| textures > 0))
}

const WRAPS: [[WrapMode; 2]; 3] = [
    [WrapMode::Repeat; 2],
    [WrapMode::Clamp, WrapMode::Mirror],
    [WrapMode::Mirror, WrapMode::Repeat],
];

fn opacity(textures: usize) -> impl Strategy<Value = Opacity> {
    let channel = prop_oneof![Just(OpacityChannel::Alpha), Just(OpacityChannel::Luminance)];
    let picture = (0..textures.max(1) as u32, channel);
    let picture = option::weighted(0.5, picture).prop_map(move |p| p.filter(|_| textures > 0));
    let mode = prop_oneof![
        Just(OpacityMode::Blend),
        (0.0..2.0f64).prop_map(|cutoff| OpacityMode::Mask { cutoff }),
    ];
    (0.0..=1.0f64, picture, mode).prop_map(|(constant, picture, mode)| Opacity {
        constant,
        picture: picture.map(|(texture, channel)| OpacityPicture { texture, channel }),
        mode,
    })
}

fn sidedness() -> impl Strategy<Value = Sidedness> {
    prop_oneof![
        Just(Sidedness::Unsaid),
        Just(Sidedness::One),
        Just(Sidedness::Two)
    ]
}

/// Irradiance on the backs of some of `count` vertices.
fn back(count: usize) -> impl Strategy<Value = Box<BackIrradiance>> {
    let vertices = vec(option::of((light_rgb(), light_rgb())), count);
    (vertices, any::<bool>()).prop_map(|(vertices, has_errors)| {
        let error = vertices.iter().map(|v| v.unwrap_or_default().1);
        Box::new(BackIrradiance {
            irradiance: vertices.iter().map(|v| v.map(|v| v.0)).collect(),
            error: if has_errors {
                error.collect()
            } else {
                Vec::new()
            },
        })
    })
}

/// A list of `count` values, or none.
pub(super) fn all_or_none<T: std::fmt::Debug + Clone>(
    count: usize,
    value: impl Strategy<Value = T>,
) -> impl Strategy<Value = Vec<T>> {
    prop_oneof![Just(Vec::new()), vec(value, count)]
}

fn attribute<T: Copy>(values: Vec<T>) -> Option<Attribute<T>> {
    (!values.is_empty()).then(|| Attribute::per_vertex(values))
}

pub(super) fn a_mesh(materials: u32) -> impl Strategy<Value = Shape> {
    let sizes = (
        1..9usize,
        vec(vec(any::<prop::sample::Index>(), 3..6), 0..6),
    );
    sizes.prop_flat_map(move |(count, faces)| {
        let attributes = (
            vec(point(), count),
            all_or_none(count, direction()),
            all_or_none(count, [number(), number()].prop_map(DVec2::from_array)),
            all_or_none(count, light_rgb()),
            all_or_none(count, light_rgb()),
            all_or_none(count, light_rgb()),
            vec(0..materials, faces.len()),
            all_or_none(faces.len(), any::<u32>()),
            option::of(back(count)),
        );
        attributes.prop_map(move |a| {
            let mut mesh = Mesh {
                positions: a.0,
                normals: attribute(a.1),
                uvs: attribute(a.2),
                colors: a.3,
                back: a
                    .8
                    .filter(|b| !a.4.is_empty() && b.irradiance.iter().any(Option::is_some)),
                irradiance: a.4,
                irradiance_error: a.5,
                smoothing: a.7,
                ..Mesh::default()
            };
            for (face, material) in faces.iter().zip(a.6) {
                let corners: Vec<u32> = face.iter().map(|i| i.index(count) as u32).collect();
                mesh.push_face(&corners, material);
            }
            Shape::Mesh(mesh)
        })
    })
}

pub(super) fn primitive_kind() -> impl Strategy<Value = PrimitiveKind> {
    prop_oneof![
        Just(PrimitiveKind::Sphere),
        Just(PrimitiveKind::Cylinder),
        Just(PrimitiveKind::Cuboid),
        Just(PrimitiveKind::Square),
        (0.0..=1.0).prop_map(|top| PrimitiveKind::Cone { top }),
    ]
}

fn surface_light(parts: usize) -> impl Strategy<Value = SurfaceLight> {
    vec((1..3u32, 1..3u32), parts).prop_flat_map(|sizes| {
        let grids: Vec<SurfaceGrid> = sizes
            .into_iter()
            .map(|(nu, nv)| SurfaceGrid { nu, nv })
            .collect();
        let count = grids.iter().map(SurfaceGrid::vertices).sum();
        (vec(light_rgb(), count), all_or_none(count, light_rgb())).prop_map(
            move |(irradiance, error)| SurfaceLight {
                grids: grids.clone(),
                irradiance,
                error,
            },
        )
    })
}

fn primitive(materials: u32) -> impl Strategy<Value = Shape> {
    let map = [small_point(), small_point(), small_point(), small_point()];
    (primitive_kind(), map, 0..materials, any::<bool>())
        .prop_map(|(kind, [x, y, z, at], material, is_plain)| {
            let map = DAffine3 {
                matrix3: DMat3::from_cols(x, y, z),
                translation: at,
            };
            if is_plain {
                Primitive::parallelogram(at, x, y, material)
            } else {
                Primitive::new(kind, map, material)
            }
        })
        .prop_filter("flat", |p| {
            super::super::is_invertible(p.kind, &p.world_from_object)
        })
        .prop_flat_map(|primitive| {
            option::of(surface_light(primitive.kind.parts())).prop_map(move |light| {
                Shape::Primitive(Primitive {
                    light: light.map(Box::new),
                    ..primitive.clone()
                })
            })
        })
}

fn fog() -> impl Strategy<Value = Fog> {
    (light_rgb(), 1e-6..1e6, any::<bool>()).prop_map(|(color, visibility, exponential)| Fog {
        color,
        visibility,
        exponential,
    })
}

fn light() -> impl Strategy<Value = Light> {
    let angle = 0.0..std::f64::consts::PI;
    let spot = (point(), direction(), light_rgb(), angle.clone(), angle);
    let kind = prop_oneof![
        (point(), light_rgb()).prop_map(|(position, intensity)| LightKind::Point {
            position,
            intensity
        }),
        spot.prop_map(|(position, direction, intensity, a, b)| LightKind::Spot {
            position,
            direction,
            intensity,
            inner: a.min(b),
            outer: a.max(b),
        }),
        (direction(), light_rgb(), prop_oneof![Just(0.0), 0.0..1.5]).prop_map(
            |(direction, irradiance, half_angle)| LightKind::Directional {
                direction,
                irradiance,
                half_angle,
            }
        ),
        light_rgb().prop_map(|radiance| LightKind::Ambient { radiance }),
    ];
    (name(), kind).prop_map(|(name, kind)| Light { name, kind })
}

fn camera() -> impl Strategy<Value = Camera> {
    (
        name(),
        small_point(),
        small_point(),
        direction(),
        0.01..3.1,
        option::of((1..9000u32, 1..9000u32)),
    )
        .prop_map(|(name, eye, target, up, vertical_fov, size)| Camera {
            name,
            eye,
            target,
            up,
            vertical_fov,
            size,
        })
        .prop_filter("blind", super::super::is_camera)
}

fn any_scene() -> impl Strategy<Value = Scene> {
    let paths = vec(any::<String>(), 0..3);
    paths
        .prop_flat_map(|paths| (vec(material(paths.len()), 1..6), Just(paths)))
        .prop_flat_map(|(materials, paths)| {
            let count = materials.len() as u32;
            let shape = prop_oneof![a_mesh(count), primitive(count), exact(count)];
            let units = (option::of(1e-6..1e6), any::<bool>(), any::<bool>()).prop_map(
                |(metres_per_unit, is_z, photometric)| Units {
                    metres_per_unit,
                    up: if is_z { Up::Z } else { Up::Y },
                    photometric,
                },
            );
            (
                vec((name(), shape), 0..5),
                Just(materials),
                Just(paths),
                vec(light(), 0..3),
                vec(camera(), 0..3),
                (
                    prop_oneof![Just(Units::default()), units],
                    option::weighted(0.2, light_rgb()),
                    option::weighted(0.2, fog()),
                ),
            )
        })
        .prop_map(|(objects, mut materials, paths, lights, cameras, rest)| {
            let (units, background, fog) = rest;
            let textures: Vec<Texture> = paths
                .into_iter()
                .enumerate()
                .map(|(k, path)| Texture {
                    path,
                    image: None,
                    wrap: WRAPS[k % WRAPS.len()],
                })
                .collect();
            for material in &mut materials {
                material.textures.retain(|&t| (t as usize) < textures.len());
            }
            let objects = objects
                .into_iter()
                .map(|(name, shape)| Object::new(name, shape))
                .collect();
            Scene {
                objects,
                materials,
                textures,
                lights,
                cameras,
                background: background.map(SceneBackground::Color),
                fog,
                units,
                rtrace: None,
            }
        })
}

/// Gives lamps the third axis that they have after reading, as `light` has two edges.
fn settle_lamps(scene: &mut Scene) {
    for object in &mut scene.objects {
        if let Shape::Primitive(p) = &mut object.shape
            && p.kind == PrimitiveKind::Square
            && scene.materials[p.material as usize].is_emitter()
        {
            let m = &mut p.world_from_object.matrix3;
            m.z_axis = m.x_axis.cross(m.y_axis).normalize_or_zero();
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn scenes(mut scene in any_scene()) {
        for material in &mut scene.materials {
            material.limit_reflectance();
        }
        settle_lamps(&mut scene);
        prop_assert_eq!(scene.validate(), Ok(()));
        let text = written(&scene);
        let back = match read(text.as_bytes(), "test.grf", &Memory::new()) {
            Ok(loaded) => loaded.scene,
            Err(e) => panic!("{e}\n{text}"),
        };
        prop_assert_eq!(&back, &scene, "{}", text);
        prop_assert_eq!(shared_figures(&back), shared_figures(&scene));
        prop_assert_eq!(written(&back), text);
    }
}
