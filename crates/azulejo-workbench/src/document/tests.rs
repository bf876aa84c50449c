//! Documents and scenes, edits and their errors, and the validity of solutions.

use super::*;
use crate::first_pass::LightSettings;
use azulejo::models::{self, Reading};
use azulejo::radiosity::{Report, solve};
use azulejo::scene::{
    Attribute, Exact, Image, Irradiance, LightKind, Mesh, Primitive, Rgb, SharedMesh, Solid,
    SurfaceGrid, VertexLight,
};
use azulejo::trace::{Progress, Tracer};
use glam::DVec2;
use std::collections::HashSet;
use std::f64::consts::PI;
use std::path::Path;

/// A small room with one of everything: a mesh with two materials, a sphere, solid text, an area
/// light, lights, a camera, a texture, fog.
pub(crate) fn sample_scene() -> Scene {
    let mut floor = Mesh {
        positions: [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)]
            .map(|(x, y)| DVec3::new(x, 0.0, -y))
            .to_vec(),
        ..Mesh::default()
    };
    floor.push_face(&[0, 1, 2], 0);
    floor.push_face(&[0, 2, 3], 1);
    let mut lamp = Mesh {
        positions: [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)]
            .map(|(x, z)| DVec3::new(x, 2.0, z))
            .to_vec(),
        ..Mesh::default()
    };
    lamp.push_face(&[3, 2, 1, 0], 2);
    let ball = Primitive::sphere(DVec3::new(0.0, 0.5, 0.0), 0.5, 1);
    let exact = Exact::new(vec![Solid::Primitive(Primitive::sphere(
        DVec3::new(1.0, 0.5, 1.0),
        0.25,
        0,
    ))]);
    let mut painted = Material::diffuse("painted", Rgb::grey(0.5));
    painted.textures = vec![0];
    Scene {
        objects: vec![
            Object::new("room/floor", Shape::Mesh(floor)),
            Object::new("room/lamp", Shape::Mesh(lamp)),
            Object::new("ball", Shape::Primitive(ball)),
            Object::new("bead", Shape::Exact(exact)),
        ],
        materials: vec![
            painted,
            Material::diffuse("white", Rgb::grey(0.7)),
            Material::emitter("glow", Rgb::grey(5.0)),
        ],
        textures: vec![Texture::default()],
        lights: vec![Light {
            name: "bulb".into(),
            kind: LightKind::Spot {
                position: DVec3::new(0.0, 1.5, 0.0),
                direction: DVec3::NEG_Y,
                intensity: Rgb::grey(1.0),
                inner: 0.3,
                outer: 0.5,
            },
        }],
        cameras: vec![Camera {
            name: "front".into(),
            eye: DVec3::new(0.0, 1.0, 5.0),
            target: DVec3::Y,
            up: DVec3::Y,
            vertical_fov: 0.7,
            size: Some((64, 48)),
        }],
        background: Some(Rgb::grey(0.1).into()),
        fog: Some(Fog {
            color: Rgb::grey(0.5),
            visibility: 50.0,
            exponential: true,
        }),
        units: Units {
            metres_per_unit: Some(0.5),
            ..Units::default()
        },
        rtrace: None,
    }
}

/// The sample as a document: ids 1 to 4 are objects, 5 is the light, 6 the camera.
pub(crate) fn sample() -> SceneDocument {
    SceneDocument::of_scene(sample_scene(), None)
}

/// The path of an example model.
pub(crate) fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../examples")
        .join(name)
}

fn read(name: &str) -> Scene {
    let model = models::read(&example(name), &Reading::default(), &Progress::new());
    model.unwrap().scene
}

/// A quick solve.
pub(crate) fn light_of(document: &SceneDocument) -> (Irradiance, Report) {
    let settings = LightSettings {
        patches: 30,
        error: 0.3,
        ..LightSettings::default()
    };
    let scene = document.scene();
    let tracer = Tracer::new(&scene);
    let light = solve(&scene, &tracer, &settings.first_pass(), &Progress::new()).unwrap();
    (light.irradiance, light.report)
}

pub(crate) fn solved(document: &SceneDocument) -> Solution {
    let (irradiance, report) = light_of(document);
    Solution::new(document.clone(), document.scene(), irradiance, Some(report))
}

#[test]
fn a_scene_comes_back_from_its_document() {
    let check = |scene: Scene| {
        scene.validate().unwrap();
        let document = SceneDocument::of_scene(scene.clone(), None);
        assert_eq!(document.scene(), scene);
    };
    check(Scene::default());
    check(sample_scene());
    for name in [
        "cornell.grf",
        "cornell-glossy.grf",
        "csg.grf",
        "shapes.grf",
        "title.grf",
    ] {
        check(read(name));
    }
}

/// Instances of a mesh share a shape, also where materials are renumbered; with light they do not.
#[test]
fn instances_share_a_shape() {
    let mut scene = sample_scene();
    let Shape::Mesh(mesh) = scene.objects[0].shape.clone() else {
        panic!("the floor is a mesh");
    };
    let mut shared = SharedMesh::new(mesh);
    for k in 0..3 {
        let place = DAffine3::from_translation(DVec3::Y * f64::from(k));
        let shape = Shape::Instance(shared.placed(place).unwrap());
        scene.objects.push(Object::new("shelf", shape));
    }
    scene.validate().unwrap();
    let mut document = SceneDocument::of_scene(sample_scene(), None);
    let ids = document.append(scene.clone(), None);
    let [first, last] = [ids.len() - 3, ids.len() - 1].map(|k| document.object(ids[k]).unwrap());
    assert!(Arc::ptr_eq(&first.shape, &last.shape));
    assert_eq!(last.placement.translation, 2.0 * DVec3::Y);
    let mut expected = sample_scene();
    expected.merge(scene.clone());
    expected.unfold();
    assert_eq!(document.scene(), expected);
    for object in &mut scene.objects {
        if let Shape::Instance(instance) = &mut object.shape {
            instance.light = Some(Box::new(VertexLight {
                irradiance: vec![Rgb::WHITE; instance.mesh.positions.len()],
                ..VertexLight::default()
            }));
        }
    }
    let lit = SceneDocument::of_scene(scene.clone(), None);
    let Shape::Mesh(mesh) = &*lit.objects[lit.objects.len() - 1].shape else {
        panic!("light needs a mesh of its own");
    };
    assert_eq!(mesh.irradiance, vec![Rgb::WHITE; mesh.positions.len()]);
}

#[test]
fn the_light_of_a_file_is_kept_beside_the_scene() {
    let document = sample();
    let (irradiance, _) = light_of(&document);
    let mut lit = document.scene();
    lit.set_irradiance(irradiance);
    let again = SceneDocument::of_scene(lit.clone(), None);
    let mut unlit = lit.clone();
    (unlit.objects.iter_mut()).for_each(|o| solution::remove_irradiance(&mut o.shape));
    assert_eq!(again.scene(), unlit);
    let solution = Solution::of_file(&again).expect("all is lit");
    assert_eq!(again.lit_scene(Some(&solution)), (lit, true));
    assert!(Solution::of_file(&document).is_none());
}

#[test]
fn two_scenes_in_one_document_are_as_two_merged() {
    let (mut a, b) = (sample_scene(), read("shapes.grf"));
    let mut document = SceneDocument::of_scene(a.clone(), None);
    let source_file = SourceFile {
        name: "shapes".into(),
        path: "shapes.grf".into(),
        format: None,
        recipes: Vec::new(),
    };
    let new = document.append(b.clone(), Some(source_file.clone()));
    let mut appended = sample();
    Edit::Append(Box::new(SceneDocument::of_scene(
        b.clone(),
        Some(source_file),
    )))
    .apply(&mut appended)
    .unwrap();
    a.merge(b);
    assert_eq!(document.scene(), a);
    assert_eq!(appended.scene(), a);
    document.scene().validate().unwrap();
    assert!(
        new.iter()
            .all(|&id| document.object(id).unwrap().source_file == Some(0))
    );
    assert_eq!(document.objects[0].source_file, None);
}

#[test]
fn an_empty_document_takes_over_the_units_of_what_joins_it() {
    let mut document = SceneDocument::default();
    let cornell = SceneDocument::of_scene(read("cornell.grf"), None);
    Edit::Append(Box::new(cornell.clone()))
        .apply(&mut document)
        .unwrap();
    assert_eq!(document.scene(), cornell.scene());
}

#[test]
fn things_move_as_a_scene_does() {
    let maps = [
        DAffine3::from_translation(DVec3::new(1.0, -2.0, 0.5)),
        DAffine3::from_rotation_y(0.7) * DAffine3::from_scale(DVec3::new(2.0, 1.0, 0.5)),
        DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)),
    ];
    for map in maps {
        let mut scene = sample_scene();
        scene.fog = None;
        let mut document = SceneDocument::of_scene(scene.clone(), None);
        let ids: Vec<ItemId> = (1..=6).map(ItemId).collect();
        let bounds = scene.clone().transformed(&map).bounds();
        Edit::Transform(ids, map).apply(&mut document).unwrap();
        assert_eq!(document.scene(), scene.transformed(&map), "{map:?}");
        let around = document.bounds(None);
        let grown = around.union(bounds);
        assert!(
            (grown.size() - around.size()).length() < 1e-9,
            "{around:?} {bounds:?}"
        );
    }
}

#[test]
fn what_is_added_is_valid_in_every_kind_of_units() {
    let kinds = [
        NewShapeKind::Cuboid,
        NewShapeKind::Sphere,
        NewShapeKind::Cylinder,
        NewShapeKind::Cone,
        NewShapeKind::Square,
        NewShapeKind::AreaLight,
        NewShapeKind::Prism(PrismOutline::regular(7, 0.5).unwrap()),
        NewShapeKind::Text(TextLayout::set("Aç", 0.2, None).unwrap()),
    ];
    use azulejo::scene::Up;
    for (up, photometric) in [(Up::Y, false), (Up::Z, true)] {
        let mut document = SceneDocument {
            units: Units {
                up,
                photometric,
                ..Units::default()
            },
            ..SceneDocument::default()
        };
        for kind in &kinds {
            let new = NewShape {
                kind: kind.clone(),
                at: DVec3::new(1.0, 2.0, 3.0),
                size: 2.0,
                material: None,
            };
            let ids = Edit::AddShape(new).apply(&mut document).unwrap();
            let bounds = document.bounds(Some(&ids));
            if !matches!(kind, NewShapeKind::Text(_)) {
                let side = bounds.size().max_element();
                assert!((side - 2.0).abs() < 1e-9, "{kind:?} of {side}");
            }
            // It stands on its base or is centred at its position.
            let low = bounds.min.dot(up.axis()) - DVec3::new(1.0, 2.0, 3.0).dot(up.axis());
            assert!(low > -0.6, "{kind:?} goes {low} below its ground");
        }
        document.scene().validate().unwrap();
        assert!(document.has_light());
        let names: HashSet<&str> = document.objects.iter().map(|i| i.name.as_str()).collect();
        assert_eq!(names.len(), kinds.len());
    }
}

#[test]
fn a_lamp_shines_downward() {
    let mut document = SceneDocument::default();
    let new = NewShape {
        kind: NewShapeKind::AreaLight,
        at: DVec3::Y,
        size: 1.0,
        material: None,
    };
    Edit::AddShape(new).apply(&mut document).unwrap();
    let Shape::Primitive(square) = &*document.objects[0].shape else {
        unreachable!("a lamp is a square")
    };
    let mesh = square.tessellate(&[SurfaceGrid { nu: 1, nv: 1 }]);
    let corner = |k: usize| mesh.positions[mesh.faces.corners[k] as usize];
    let normal = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    assert!(normal.normalize().dot(DVec3::NEG_Y) > 0.999, "{normal}");
}

/// Checks the validity of a solution before and after an edit, and after undoing it.
fn check_light(edit: Edit, stays: bool) {
    let document = sample();
    let solution = solved_without_solver(&document);
    assert!(solution.is_of(&document));
    let mut edited = document.clone();
    edit.apply(&mut edited).unwrap();
    assert_eq!(solution.is_of(&edited), stays, "{edit:?}");
    assert_eq!(edited.lit_scene(Some(&solution)).1, stays, "{edit:?}");
    assert!(solution.is_of(&document));
}

/// A solution with arbitrary values.
fn solved_without_solver(document: &SceneDocument) -> Solution {
    static LIGHT: std::sync::OnceLock<Irradiance> = std::sync::OnceLock::new();
    let light = LIGHT.get_or_init(|| light_of(&sample()).0);
    Solution::new(document.clone(), document.scene(), light.clone(), None)
}

#[test]
fn light_is_old_after_edits_that_matter_and_only_those() {
    let document = sample();
    let (floor, bulb, view) = (ItemId(1), ItemId(5), ItemId(6));
    let red = Material::diffuse("red", Rgb::new(0.5, 0.1, 0.1));
    let other = Material {
        name: "other".into(),
        ..Material::clone(&document.materials[1])
    };
    let mut brighter = document.lights[0].light.clone();
    brighter.kind = LightKind::Ambient {
        radiance: Rgb::grey(1.0),
    };
    let ball = Primitive::sphere(DVec3::ZERO, 1.0, 0);
    for edit in [
        Edit::Delete(vec![floor]),
        Edit::Delete(vec![bulb]),
        Edit::Duplicate(vec![ItemId(3)]),
        Edit::Transform(vec![floor], DAffine3::from_translation(DVec3::X)),
        Edit::Transform(vec![bulb], DAffine3::from_translation(DVec3::X)),
        Edit::SetPlacement(ItemId(3), DAffine3::from_scale(DVec3::splat(2.0))),
        Edit::SetShape(ItemId(3), Arc::new(Shape::Primitive(ball))),
        Edit::SetLight(bulb, brighter),
        Edit::SetMaterial(1, red),
        Edit::Assign(vec![floor], 1),
        Edit::AssignFaces(floor, vec![0], 1),
        Edit::Append(Box::new(sample())),
    ] {
        check_light(edit, false);
    }
    for edit in [
        Edit::Rename(floor, "ground".into()),
        Edit::Rename(bulb, "sun".into()),
        Edit::Hide(vec![floor], true),
        Edit::AddCamera(document.cameras[0].camera.clone()),
        Edit::SetCamera(view, document.cameras[0].camera.clone()),
        Edit::Delete(vec![view]),
        Edit::AddMaterial(other.clone()),
        Edit::SetMaterial(1, other),
    ] {
        check_light(edit, true);
    }
}

#[test]
fn what_does_not_exist_refuses_to_change() {
    let document = sample();
    let nowhere = ItemId(99);
    let camera = document.cameras[0].camera.clone();
    let wrong = Material::diffuse("bright", Rgb::grey(1.5));
    let mut far = Material::diffuse("far", Rgb::grey(0.5));
    far.textures = vec![7];
    let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
    let ball = Shape::Primitive(Primitive::sphere(DVec3::ZERO, 1.0, 9));
    for (edit, expected) in [
        (
            Edit::Rename(nowhere, "x".into()),
            "the object no longer exists",
        ),
        (Edit::Rename(ItemId(1), "a\nb".into()), "control characters"),
        (Edit::Delete(vec![nowhere]), "nothing is selected"),
        (Edit::Duplicate(vec![nowhere]), "nothing is selected"),
        (
            Edit::SetPlacement(nowhere, DAffine3::IDENTITY),
            "the object no longer exists",
        ),
        (Edit::SetPlacement(ItemId(1), flat), "singular"),
        (Edit::Transform(vec![ItemId(1)], flat), "singular"),
        (Edit::SetShape(ItemId(1), Arc::new(ball)), "material 9 of 3"),
        (
            Edit::SetLight(ItemId(1), document.lights[0].light.clone()),
            "the light no longer exists",
        ),
        (
            Edit::SetCamera(nowhere, camera.clone()),
            "the camera no longer exists",
        ),
        (
            Edit::AddCamera(Camera {
                vertical_fov: 4.0,
                ..camera
            }),
            "field of view",
        ),
        (Edit::AddMaterial(wrong.clone()), "expected 0..=1"),
        (Edit::AddMaterial(far), "texture 7 of 1"),
        (
            Edit::SetMaterial(9, Material::default()),
            "the material no longer exists",
        ),
        (
            Edit::Assign(vec![ItemId(1)], 3),
            "the material no longer exists",
        ),
        (
            Edit::AssignFaces(ItemId(1), vec![2], 0),
            "the face no longer exists",
        ),
        (
            Edit::SetBackground(Some(Rgb::grey(-1.0).into())),
            "background",
        ),
    ] {
        let mut edited = document.clone();
        let refused = edit.apply(&mut edited).unwrap_err().to_string();
        assert!(refused.contains(expected), "{edit:?}: {refused}");
        assert_eq!(edited, document, "{edit:?}");
    }
}

#[test]
fn letters_that_cannot_be_set_are_refused() {
    for (text, depth, font, expected) in [
        ("", 0.1, None, "0 bytes of text"),
        ("a", 0.0, None, "letters 0 deep"),
        ("a", f64::NAN, None, "letters NaN deep"),
        ("a", 0.1, Some((&b"no font"[..], "x.ttf")), "x.ttf"),
    ] {
        let refused = TextLayout::set(text, depth, font).unwrap_err().to_string();
        assert!(refused.contains(expected), "{refused}");
    }
    assert!(TextLayout::set(&"a".repeat(20_000), 0.1, None).is_err());
}

#[test]
fn copies_of_many_have_names_of_their_own() {
    let mut document = SceneDocument::of_scene(sample_scene(), None);
    let ids: Vec<ItemId> = document.objects.iter().map(|i| i.id).collect();
    for _ in 0..3 {
        Edit::Duplicate(ids.clone()).apply(&mut document).unwrap();
    }
    // A copy gets a free name, and of two objects with the same name each gets its own.
    let ball = document
        .objects
        .iter()
        .find(|i| i.name == "ball 3")
        .unwrap()
        .id;
    Edit::Rename(ball, "ball".into())
        .apply(&mut document)
        .unwrap();
    let both: Vec<ItemId> = document
        .objects
        .iter()
        .filter(|i| i.name == "ball")
        .map(|i| i.id)
        .collect();
    let copies = Edit::Duplicate(both).apply(&mut document).unwrap();
    let name = |id: &ItemId| document.name(*id).unwrap().to_owned();
    assert_eq!(
        copies.iter().map(name).collect::<Vec<_>>(),
        ["ball 3", "ball 5"]
    );
}

#[test]
fn radiance_knows_colours_and_textures() {
    let mut scene = sample_scene();
    // Dark on the left, bright on the right.
    let image = Image {
        width: 2,
        height: 1,
        pixels: vec![[0.25; 3], [1.0; 3]],
        alpha: None,
    };
    scene.textures[0].image = Some(image);
    let document = SceneDocument::of_scene(scene, None);
    let mut mesh = Mesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        colors: vec![Rgb::WHITE, Rgb::grey(0.5), Rgb::grey(0.5)],
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2], 0);
    let radiance = |mesh: &Mesh, weights: [f64; 3]| {
        let paint = ShadingPoint::at(mesh, 0, [0, 1, 2], weights, true).unwrap();
        document.radiance(&paint, Rgb::grey(PI)).unwrap().r
    };
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
    // A texture has no effect without texture coordinates.
    near(radiance(&mesh, [1.0, 0.0, 0.0]), 0.5);
    near(radiance(&mesh, [0.0, 1.0, 0.0]), 0.25);
    let uvs = [0.25, 0.75, 0.75].map(|u| DVec2::new(u, 0.5)).to_vec();
    mesh.uvs = Some(Attribute::per_vertex(uvs));
    near(radiance(&mesh, [1.0, 0.0, 0.0]), 0.125);
    near(radiance(&mesh, [0.0, 0.5, 0.5]), 0.25);
    assert_eq!(
        ShadingPoint::at(&mesh, 1, [0, 1, 2], [1.0, 0.0, 0.0], true),
        None
    );

    // The emitter emits from its front side.
    mesh.face_materials = vec![2];
    let paint =
        |is_front| ShadingPoint::at(&mesh, 0, [0, 1, 2], [1.0, 0.0, 0.0], is_front).unwrap();
    let own = |is_front| document.radiance(&paint(is_front), Rgb::BLACK);
    assert_eq!(own(true), Some(Rgb::grey(5.0)));
    assert_eq!(own(false), Some(Rgb::BLACK));
}
