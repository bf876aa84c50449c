//! Scenes that are written are read back unchanged.

use crate::{Memory, ReadOptions, gltf};
use azulejo_scene::{
    Attribute, Camera, Dielectric, Image, Light, LightKind, Material, Mesh, Object, Opacity,
    OpacityChannel, OpacityMode, OpacityPicture, Primitive, Rgb, Scene, Shape, SharedMesh,
    Sidedness, Texture, Units, Up, WrapMode,
};
use glam::{DAffine3, DQuat, DVec2, DVec3};
use proptest::prelude::*;

fn glb(scene: &Scene) -> Vec<u8> {
    let mut file = Vec::new();
    gltf::write(scene, &mut file).unwrap();
    file
}

pub(super) fn read_back(scene: &Scene) -> Scene {
    let loaded = gltf::read(
        &glb(scene),
        "a.glb",
        &Memory::new(),
        &ReadOptions::default(),
    );
    let loaded = loaded.unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(loaded.warnings, []);
    loaded.scene.validate().unwrap();
    unsaid(loaded.scene)
}

/// glTF always says from which sides a surface is visible, and that meshes without normals are flat; the scenes here
/// do not.
fn unsaid(mut scene: Scene) -> Scene {
    scene.for_each_mesh(|mesh| {
        let flat = if mesh.normals.is_none() {
            mesh.faces.len()
        } else {
            0
        };
        assert_eq!(mesh.smoothing, vec![0; flat]);
        mesh.smoothing.clear();
    });
    for m in &mut scene.materials {
        assert_ne!(m.sidedness, Sidedness::Unsaid);
        m.sidedness = Sidedness::Unsaid;
    }
    scene
}

/// Numbers that single precision represents exactly.
fn number(most: f64) -> impl Strategy<Value = f64> {
    (-most..most).prop_map(|v| f64::from(v as f32))
}

fn share() -> impl Strategy<Value = Rgb> {
    let channel = || (0u32..=8).prop_map(|n| f64::from(n) / 16.0);
    (channel(), channel(), channel()).prop_map(|(r, g, b)| Rgb::new(r, g, b))
}

fn surface() -> impl Strategy<Value = Material> {
    let mixed = (share(), 0u32..=4).prop_map(|(colour, mirrored)| Material {
        diffuse: colour * (1.0 - f64::from(mirrored) / 4.0),
        mirror: colour * (f64::from(mirrored) / 4.0),
        ..Material::default()
    });
    let kinds = prop_oneof![
        Just((1.0, true)),
        Just((1.5, true)),
        Just((1.5, false)),
        Just((2.25, false))
    ];
    let glass = (share(), kinds).prop_map(|(t, (ior, thin))| Material {
        mirror: Rgb::WHITE,
        dielectric: Some(Dielectric {
            ior,
            transmittance: t,
            thin,
        }),
        ..Material::default()
    });
    let lamp = (share(), any::<bool>(), 0i32..20).prop_map(|(c, emits_back, strength)| {
        let emission = c * 2f64.powi(strength);
        Material {
            emission,
            emits_back: emits_back && !emission.is_black(),
            ..Material::default()
        }
    });
    let textured = share().prop_map(|diffuse| Material {
        diffuse,
        textures: vec![0],
        ..Material::default()
    });
    prop_oneof![mixed, glass, lamp, textured]
}

/// Triangles over vertices with one value of each attribute, sorted by material.
fn mesh() -> impl Strategy<Value = Mesh> {
    let extras = any::<[bool; 4]>();
    (3usize..12, 1usize..8, extras).prop_flat_map(|(vertices, faces, has)| {
        let count = |is_present: bool| if is_present { vertices } else { 0 };
        let vector = |most: f64| [number(most), number(most), number(most)];
        (
            prop::collection::vec(vector(1e3), vertices),
            prop::collection::vec((0usize..6).prop_map(axis), count(has[0])),
            prop::collection::vec([number(8.0), number(8.0)], count(has[1])),
            prop::collection::vec(share(), count(has[2])),
            prop::collection::vec(share().prop_map(|e| e * 1e3), count(has[3])),
            prop::collection::vec(
                [0..vertices as u32, 0..vertices as u32, 0..vertices as u32],
                faces,
            ),
            prop::collection::vec(0u32..4, faces),
        )
            .prop_map(
                |(positions, normals, uvs, colors, light, faces, mut materials)| {
                    materials.sort_unstable();
                    let mut mesh = Mesh {
                        positions: positions.into_iter().map(DVec3::from).collect(),
                        normals: per_vertex(normals),
                        // 1 − v is exact both ways for these.
                        uvs: per_vertex(
                            uvs.into_iter().map(|uv| DVec2::from(uv).round()).collect(),
                        ),
                        colors,
                        irradiance: light.into_iter().map(|e| e.map(|c| c.round())).collect(),
                        ..Mesh::default()
                    };
                    for (face, material) in faces.iter().zip(materials) {
                        mesh.push_face(face, material);
                    }
                    mesh
                },
            )
    })
}

fn per_vertex<T: Copy>(values: Vec<T>) -> Option<Attribute<T>> {
    (!values.is_empty()).then(|| Attribute::per_vertex(values))
}

fn axis(k: usize) -> DVec3 {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    if k < 3 { axes[k] } else { -axes[k - 3] }
}

fn scene() -> impl Strategy<Value = Scene> {
    let materials = prop::collection::vec(surface(), 4);
    let name = "[a-z/ áñ漢\"\\\\]{0,9}";
    let objects = prop::collection::vec((name, mesh()), 1..4);
    (materials, objects, any::<bool>()).prop_map(|(mut materials, objects, photometric)| {
        for (i, m) in materials.iter_mut().enumerate() {
            m.name = format!("m {i}");
        }
        Scene {
            materials,
            textures: vec![Texture {
                path: "maps/a b.png".into(),
                image: Some(Image {
                    width: 2,
                    height: 1,
                    pixels: vec![[0.0, 1.0, 0.0], [1.0; 3]],
                    alpha: None,
                }),
                wrap: [WrapMode::Clamp, WrapMode::Mirror],
            }],
            objects: objects
                .into_iter()
                .map(|(name, mesh)| Object::new(name, Shape::Mesh(mesh)))
                .collect(),
            units: Units {
                metres_per_unit: Some(1.0),
                up: Up::Y,
                photometric,
            },
            ..Scene::default()
        }
    })
}

/// Removes what no face uses from a scene, and orders the rest by first use, as a reader
/// does.
fn as_used(scene: &Scene) -> Scene {
    let mut used = Scene {
        materials: Vec::new(),
        textures: Vec::new(),
        ..scene.clone()
    };
    let mut order: Vec<u32> = Vec::new();
    for object in &mut used.objects {
        let Shape::Mesh(mesh) = &mut object.shape else {
            continue;
        };
        for m in &mut mesh.face_materials {
            let place = order.iter().position(|o| o == m).unwrap_or_else(|| {
                order.push(*m);
                order.len() - 1
            });
            *m = place as u32;
        }
    }
    used.materials = order
        .iter()
        .map(|&m| scene.materials[m as usize].clone())
        .collect();
    if used.materials.iter().any(|m| !m.textures.is_empty()) {
        used.textures.clone_from(&scene.textures);
    }
    used
}

/// Whether two scenes are equal up to rounding of colours and directions.
fn assert_alike(back: &Scene, expected: &Scene) {
    let rounded = |scene: &Scene| {
        let mut scene = scene.clone();
        let near = |c: Rgb| c.map(|c| f64::from(c as f32));
        for m in &mut scene.materials {
            (m.diffuse, m.mirror) = (near(m.diffuse), near(m.mirror));
            m.emission = near(m.emission);
        }
        scene
    };
    assert_eq!(rounded(back), rounded(expected));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn written_scenes_are_read_back(scene in scene()) {
        prop_assert_eq!(scene.validate(), Ok(()));
        // A vertex list of which half is unused is cut down.
        let expected = as_used(&scene);
        let all_used = expected.objects.iter().all(|o| match &o.shape {
            Shape::Mesh(mesh) => {
                let used = |v: u32| mesh.faces.corners.contains(&v);
                2 * (0..mesh.positions.len() as u32).filter(|v| used(*v)).count() >= mesh.positions.len()
            }
            _ => true,
        });
        // Without texture coordinates there is no texture.
        let warned = expected.objects.iter().any(|o| match &o.shape {
            Shape::Mesh(mesh) => mesh.uvs.is_none()
                && mesh.face_materials.iter().any(|m| !expected.materials[*m as usize].textures.is_empty()),
            _ => false,
        });
        prop_assume!(all_used && !warned);
        assert_alike(&read_back(&scene), &expected);
    }
}

#[test]
fn two_files_are_one_scene() {
    let mut scene = Scene::default();
    let white = scene.add_material(Material::diffuse("white", Rgb::grey(0.5)));
    let ball = Primitive::sphere(DVec3::ZERO, 2.0, white);
    scene
        .objects
        .push(Object::new("ball", Shape::Primitive(ball)));
    scene.units.metres_per_unit = Some(1.0);
    let (mut json, mut bin) = (Vec::new(), Vec::new());
    gltf::write_json(&scene, "the numbers.bin", &mut json, &mut bin).unwrap();
    let files = Memory::new().with("the numbers.bin", bin);
    let loaded = gltf::read(&json, "a.gltf", &files, &ReadOptions::default()).unwrap();
    assert_eq!(unsaid(loaded.scene.clone()), read_back(&scene));
    let area = 16.0 * std::f64::consts::PI;
    let Shape::Mesh(mesh) = &loaded.scene.objects[0].shape else {
        panic!("glTF has meshes only")
    };
    assert!((mesh.area() / area - 1.0).abs() < 0.01, "{}", mesh.area());
    assert_eq!(
        gltf::losses(&scene),
        ["1 exact primitives that become polygons"]
    );
}

/// A square of one face with a normal for each corner and a discontinuity in its coordinates.
#[test]
fn corner_values_split_vertices() {
    let mut scene = Scene::default();
    scene.add_material(Material::diffuse("white", Rgb::grey(0.5)));
    let mut mesh = Mesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y],
        irradiance: vec![Rgb::grey(3.0), Rgb::grey(1.0), Rgb::BLACK, Rgb::grey(0.5)],
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2, 3], 0);
    mesh.push_face(&[2, 1, 0], 0);
    mesh.normals = Some(Attribute {
        values: vec![DVec3::Z, DVec3::NEG_Z],
        corners: Some(vec![0, 0, 0, 0, 1, 1, 1]),
    });
    scene.objects.push(Object::new("", Shape::Mesh(mesh)));
    let back = read_back(&scene);
    let Shape::Mesh(mesh) = &back.objects[0].shape else {
        panic!("glTF has meshes only")
    };
    assert_eq!((mesh.positions.len(), mesh.faces.len()), (7, 3));
    assert_eq!(mesh.irradiance[6], Rgb::grey(3.0));
    assert!(mesh.colors.is_empty());
    assert_eq!(
        gltf::losses(&scene),
        ["1 meshes whose polygons become triangles"]
    );
}

/// A scene in millimetres with z up: a lamp, a camera and a triangle that faces up.
#[test]
fn other_units_are_converted() {
    let mut scene = Scene::default();
    scene.add_material(Material::diffuse("white", Rgb::grey(0.5)));
    let mut mesh = Mesh {
        positions: vec![DVec3::ZERO, DVec3::X * 1e3, DVec3::Y * 1e3],
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2], 0);
    scene.objects.push(Object::new("floor", Shape::Mesh(mesh)));
    let lights = [
        LightKind::Point {
            position: DVec3::Z * 2e3,
            intensity: Rgb::grey(4e6),
        },
        LightKind::Spot {
            position: DVec3::Z * 2e3,
            direction: DVec3::NEG_Z,
            intensity: Rgb::new(1e6, 5e5, 0.0),
            inner: 0.25,
            outer: 0.5,
        },
        LightKind::Directional {
            direction: DVec3::Y,
            irradiance: Rgb::grey(3.0),
            half_angle: 0.0,
        },
        LightKind::Ambient {
            radiance: Rgb::WHITE,
        },
    ];
    let light = |kind| Light {
        name: "lamp".into(),
        kind,
    };
    scene.lights = lights.map(light).to_vec();
    scene.cameras.push(Camera {
        name: "eye".into(),
        eye: DVec3::new(0.0, -5e3, 1e3),
        target: DVec3::new(0.0, 0.0, 1e3),
        up: DVec3::Z,
        vertical_fov: 0.75,
        size: Some((4, 3)),
    });
    scene.units = Units {
        metres_per_unit: Some(1e-3),
        up: Up::Z,
        photometric: false,
    };
    let expected = scene.clone().adapted(Units {
        metres_per_unit: Some(1.0),
        ..Units::default()
    });
    let back = read_back(&scene);
    let near = |a: DVec3, b: DVec3| (a - b).length() < 1e-6;
    let positions = |scene: &Scene| match &scene.objects[0].shape {
        Shape::Mesh(mesh) => mesh.positions.clone(),
        _ => Vec::new(),
    };
    let pairs = positions(&back).into_iter().zip(positions(&expected));
    assert!(pairs.into_iter().all(|(a, b)| near(a, b)));
    let (camera, expected_camera) = (&back.cameras[0], &expected.cameras[0]);
    assert!(
        near(camera.eye, expected_camera.eye) && near(camera.axes().2, expected_camera.axes().2)
    );
    assert!(near(camera.axes().1, expected_camera.axes().1) && camera.vertical_fov == 0.75);
    assert_eq!(back.lights.len(), 4);
    let LightKind::Ambient { radiance } = back.lights[3].kind else {
        panic!("{:?}", back.lights[3])
    };
    assert!((radiance - Rgb::WHITE).map(f64::abs).max_channel() < 1e-9);
    assert_eq!(back.lights[3].name, "lamp");
    for (lamp, expected_lamp) in back.lights.iter().zip(&expected.lights).take(3) {
        let at = DVec3::new(0.3, 0.1, -0.2);
        match (lamp.kind.clone(), expected_lamp.kind.clone()) {
            (
                LightKind::Directional { direction: a, .. },
                LightKind::Directional { direction: b, .. },
            ) => {
                assert!(near(a, b));
            }
            (a, b) => {
                let w = (at - DVec3::Y * 2.0).normalize();
                let (a, b) = (a.intensity_toward(w), b.intensity_toward(w));
                assert!((a - b).map(f64::abs).max_channel() < 1e-5, "{a:?} {b:?}");
            }
        }
    }
    assert!(!back.units.photometric);
    let losses = gltf::losses(&scene);
    assert_eq!(losses.len(), 1, "{losses:?}");
}

#[test]
fn pictures_without_pixels_are_reported() {
    let mut scene = Scene::default();
    scene.textures.push(Texture {
        path: "maps/a b.png".into(),
        image: None,
        ..Texture::default()
    });
    scene.add_material(Material {
        textures: vec![0],
        diffuse: Rgb::grey(0.5),
        ..Material::default()
    });
    let mut mesh = Mesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        uvs: Some(Attribute::per_vertex(vec![DVec2::ONE; 3])),
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2], 0);
    scene.objects.push(Object::new("", Shape::Mesh(mesh)));
    let loaded = gltf::read(
        &glb(&scene),
        "a.glb",
        &Memory::new(),
        &ReadOptions::default(),
    );
    let loaded = loaded.unwrap();
    assert_eq!(loaded.scene.textures, scene.textures);
    assert_eq!(loaded.warnings.len(), 1);
}

/// glTF does not allow textures on meshes without texture coordinates, where azulejo ignores them.
#[test]
fn pictures_without_coordinates() {
    let mut scene = Scene::default();
    scene.textures.push(Texture::default());
    scene.add_material(Material {
        textures: vec![0],
        diffuse: Rgb::grey(0.5),
        ..Material::default()
    });
    let mut mesh = Mesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2], 0);
    scene.objects.push(Object::new("", Shape::Mesh(mesh)));
    let back = read_back(&scene);
    assert_eq!(back.materials, [Material::diffuse("", Rgb::grey(0.5))]);
}

#[test]
fn an_empty_scene_is_a_file() {
    let file = glb(&Scene::default());
    let loaded = gltf::read(&file, "a.glb", &Memory::new(), &ReadOptions::default());
    assert_eq!(loaded.unwrap().warnings.len(), 1);
}

/// The picture of an opacity becomes the alpha channel of the colour's.
#[test]
fn opacities_come_back() {
    let picture = |pixels: Vec<[f32; 3]>| Texture {
        path: "picture".into(),
        image: Some(Image::opaque(2, 1, pixels)),
        ..Texture::default()
    };
    let colour = picture(vec![[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    let mut cut = colour.clone();
    cut.image = cut.image.map(|image| image.with_alpha(vec![0.2, 1.0]));
    let check = |textures: Vec<Texture>, base: &[u32], opacity: Opacity, alpha: &[f32]| {
        let mut scene = Scene {
            textures,
            ..Scene::default()
        };
        scene.add_material(Material {
            textures: base.to_vec(),
            opacity: Some(opacity),
            ..Material::diffuse("leaf", Rgb::grey(0.5))
        });
        let mut mesh = Mesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            uvs: Some(Attribute::per_vertex(vec![DVec2::ONE; 3])),
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, 2], 0);
        scene.objects.push(Object::new("", Shape::Mesh(mesh)));
        let options = ReadOptions::default();
        let back = gltf::read(&glb(&scene), "a.glb", &Memory::new(), &options).unwrap();
        let read_opacity = back.scene.materials[0].opacity.unwrap();
        assert_eq!(
            (read_opacity.constant, read_opacity.mode),
            (opacity.constant, opacity.mode)
        );
        assert_eq!(read_opacity.picture.is_some(), opacity.picture.is_some());
        let image = back.scene.textures.first().and_then(|t| t.image.as_ref());
        let channel = image.and_then(|image| image.alpha.as_deref());
        assert_eq!(channel.unwrap_or_default(), alpha);
        assert_eq!(back.warnings, []);
    };
    let whole = Opacity::constant(1.0);
    let by = |texture: u32, channel: OpacityChannel| Opacity {
        picture: Some(OpacityPicture { texture, channel }),
        ..whole
    };
    check(Vec::new(), &[], Opacity::constant(0.5), &[]);
    let alpha = by(0, OpacityChannel::Alpha);
    check(vec![cut.clone()], &[0], alpha, &[0.2, 1.0]);
    let mask = Opacity {
        mode: OpacityMode::Mask { cutoff: 0.25 },
        constant: 0.5,
        ..by(1, OpacityChannel::Luminance)
    };
    let board = picture(vec![[0.0; 3], [1.0; 3]]);
    check(vec![colour, board.clone()], &[0], mask, &[0.0, 1.0]);
    check(
        vec![board],
        &[],
        by(0, OpacityChannel::Luminance),
        &[0.0, 1.0],
    );
}

/// A picture that only an environment shows is not written beside its cube map.
#[test]
fn pictures_of_the_surroundings_are_no_textures() {
    use azulejo_scene::{Environment, Image, Light, LightKind, Projection, Texture, Up};
    let picture = |value: f32| Texture {
        image: Some(Image::opaque(64, 32, vec![[value; 3]; 64 * 32])),
        ..Texture::default()
    };
    let mut scene = azulejo_scene::synthetic::cube_room();
    scene.textures = vec![picture(9.0), picture(0.5)];
    scene.materials[0].textures = vec![1];
    let size = |scene: &Scene| {
        let mut bytes = Vec::new();
        gltf::write(scene, &mut bytes).unwrap();
        bytes
    };
    let environment = Environment::picture(0, Projection::Equirectangular, Up::Z);
    scene.lights.push(Light {
        name: "sky".to_owned(),
        kind: LightKind::Environment(environment),
    });
    let bytes = size(&scene);
    let text = String::from_utf8_lossy(&bytes);
    // The picture of the material, and four levels of six faces.
    assert_eq!(text.matches("\"image/png\"").count(), 1 + 24);
    let losses = gltf::losses(&scene);
    assert!(
        losses
            .iter()
            .any(|l| l.starts_with("1 pictures of the surroundings")),
        "{losses:?}"
    );
    scene.materials[0].textures = vec![0];
    assert!(
        gltf::losses(&scene)
            .iter()
            .all(|l| !l.contains("surroundings"))
    );
}

/// One mesh in several places stays one, but for a place that nodes cannot say.
#[test]
fn shared_meshes_are_written_once() {
    let mut scene = Scene::default();
    let id = scene.add_material(Material::diffuse("leaf", Rgb::new(0.25, 0.5, 0.125)));
    let mut mesh = Mesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2], id);
    mesh.push_face(&[0, 3, 1], id);
    let mut shared = SharedMesh::new(mesh);
    let shear = DAffine3::from_cols_array(&[1., 0., 0., 0.5, 1., 0., 0., 0., 1., 0., 0., 8.]);
    let places = [
        DAffine3::IDENTITY,
        DAffine3::from_translation(DVec3::new(1.0, 2.0, 4.0)),
        DAffine3::from_scale(DVec3::new(2.0, 0.5, 1.0)),
        DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)),
        DAffine3::from_scale_rotation_translation(
            DVec3::splat(2.0),
            DQuat::from_xyzw(0.5, 0.5, 0.5, 0.5),
            DVec3::Y,
        ),
        shear,
    ];
    for place in places {
        let placed = shared.placed(place).unwrap();
        scene
            .objects
            .push(Object::new("leaf", Shape::Instance(placed)));
    }
    scene.validate().unwrap();
    let once = {
        let mut alone = scene.clone();
        alone.objects.truncate(1);
        glb(&alone).len()
    };
    let all = glb(&scene).len();
    assert!(
        all < once + 2500,
        "{all} bytes of six places, {once} of one"
    );
    let again = read_back(&scene);
    assert!(again.shared_meshes().len() <= 2);
    assert_eq!(again.objects.len(), scene.objects.len());
    for (a, b) in again.objects.iter().zip(&scene.objects) {
        let [a, b] = [a, b].map(|o| o.shape.placed_mesh().unwrap());
        for face in 0..2 {
            let [p, q] = [&a, &b].map(|m| m.face_positions(face));
            assert!(
                p.iter().zip(&q).all(|(p, q)| p.distance(*q) < 1e-6),
                "{p:?} {q:?}"
            );
            assert!(a.face_area_vector(face).distance(b.face_area_vector(face)) < 1e-6);
        }
    }
}

/// Matt surfaces may say that they mirror nothing; others are written as before, and all are read as before.
#[test]
fn matt_surfaces_say_so() {
    let mut scene = Scene {
        materials: vec![
            Material::diffuse("matt", Rgb::grey(0.5)),
            Material::mirror("mirror", Rgb::grey(0.5)),
            Material::dielectric("glass", 1.5),
            Material::emitter("lamp", Rgb::grey(0.5)),
        ],
        ..Scene::default()
    };
    for material in 0..4 {
        let mut mesh = Mesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, 2], material);
        scene.objects.push(Object::new("", Shape::Mesh(mesh)));
    }
    let written = |matt| {
        let mut file = Vec::new();
        gltf::write_with(&scene, matt, &mut file).unwrap();
        let length = u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
        let json: serde_json::Value = serde_json::from_slice(&file[20..20 + length]).unwrap();
        let factor = |m: &serde_json::Value| {
            m["extensions"]["KHR_materials_specular"]["specularFactor"].clone()
        };
        let factors: Vec<_> = json["materials"]
            .as_array()
            .unwrap()
            .iter()
            .map(factor)
            .collect();
        (factors, json["extensionsUsed"].to_string(), file)
    };
    let (said_factors, used, with) = written(gltf::MattSurfaces::Said);
    let none = serde_json::Value::Null;
    assert_eq!(
        said_factors,
        [0.into(), none.clone(), none.clone(), 0.into()]
    );
    assert!(used.contains("KHR_materials_specular"), "{used}");
    let (factors, used, without) = written(gltf::MattSurfaces::Rough);
    assert!(factors.iter().all(|f| *f == none));
    assert!(!used.contains("KHR_materials_specular"), "{used}");
    assert!(without == glb(&scene));
    let read = |file: &[u8]| {
        let loaded = gltf::read(file, "a.glb", &Memory::new(), &ReadOptions::default());
        let loaded = loaded.unwrap();
        assert_eq!(loaded.warnings, []);
        loaded.scene
    };
    assert_eq!(read(&with), read(&without));
}
