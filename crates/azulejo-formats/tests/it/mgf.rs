//! Real-world MGF scenes: their luminous flux, and counts of their elements.

use azulejo_formats::{Folder, Loaded, Memory, ReadOptions, mgf};
use azulejo_scene::{Light, LightKind, Material, MaterialId, PrimitiveKind, Scene, Shape};
use azulejo_testing::data;
use std::f64::consts::PI;
use std::path::Path;

/// Reads a file of the corpus with the materials next to its folder.
fn read(data: &Path, path: &str) -> Loaded {
    let corpus = data.join("corpus/mgf");
    let path = corpus.join(path);
    let bytes = std::fs::read(&path).expect("a readable file");
    let name = path.file_name().expect("a file name").to_string_lossy();
    let files = Folder::of_model(&path).allow(&corpus);
    let loaded = mgf::read(&bytes, &name, &files, &ReadOptions::default()).expect("a scene");
    loaded.scene.validate().expect("a valid scene");
    loaded
}

/// Flux emitted from the fronts of all surfaces, lumens.
fn lumens(scene: &Scene) -> f64 {
    let exitance = |m: MaterialId| PI * scene.materials[m as usize].emission.luminance();
    let shines = |m: MaterialId| Material::is_emitter(&scene.materials[m as usize]);
    let objects = scene.objects.iter().map(|object| match &object.shape {
        Shape::Primitive(p) if shines(p.material) => p.area() * exitance(p.material),
        shape => of_faces(shape)
            .filter(|(_, m)| shines(*m))
            .map(|(area, m)| area * exitance(m))
            .sum(),
    });
    objects.sum()
}

/// Area and material of each face of a mesh; nothing of other shapes.
fn of_faces(shape: &Shape) -> impl Iterator<Item = (f64, MaterialId)> {
    shape.placed_mesh().into_iter().flat_map(|placed| {
        let materials = placed.mesh.face_materials.iter().enumerate();
        materials.map(move |(f, &m)| (placed.face_area_vector(f).length(), m))
    })
}

#[test]
fn lamps_give_the_light_that_the_files_say() {
    let Some(data) = data() else { return };
    // The sums of area times ed, of fronts.
    for (path, expected) in [
        ("cube.mgf", 200_000.0),
        ("corridor.mgf", 2_280_000.0),
        ("office2/office2.mgf", 2_600.0),
        ("office3/office.mgf", 16_718.0),
        ("examp1.mgf", 8_697.5),
        ("hospital/main.mgf", 13_548.0),
    ] {
        let found = lumens(&read(&data, path).scene);
        assert!(
            (found / expected - 1.0).abs() < 5e-4,
            "{path}: {found}, expected {expected}"
        );
    }
}

#[test]
fn spheres_are_exact() {
    let Some(data) = data() else { return };
    for (path, expected) in [
        ("cube.mgf", 0),
        ("corridor.mgf", 1),
        ("office3/office.mgf", 77),
        ("hospital/main.mgf", 61),
    ] {
        let scene = read(&data, path).scene;
        let found = scene.objects.iter().filter(|o| is_sphere(&o.shape)).count();
        assert_eq!(found, expected, "{path}");
    }
}

#[test]
fn a_photometric_file_and_its_body() {
    let Some(data) = data() else { return };
    let ies = std::fs::read(data.join("corpus/mgf/examp1.ies")).expect("a readable file");
    let body = std::fs::read(data.join("corpus/mgf/examp1.mgf")).expect("a readable file");
    let text = b"ies lamp.ies -t 0 0 2.5\n";
    let files = Memory::new().with("lamp.ies", ies);
    let read = |files: &Memory| {
        mgf::read(text, "room.mgf", files, &ReadOptions::default())
            .expect("a scene")
            .scene
    };
    // Without its geometry the luminaire is points that share the flux of the candelas.
    let alone = read(&files);
    assert_eq!(alone.objects.len(), 0);
    let of = |light: &Light| match &light.kind {
        LightKind::Luminaire { scale, web, .. } => scale.r * web.sphere_integral(),
        _ => 0.0,
    };
    let found: f64 = alone.lights.iter().map(of).sum();
    assert!(
        alone.lights.len() > 1 && (found / 5_000.0 - 1.0).abs() < 0.25,
        "{found}"
    );
    let whole = read(&files.with("examp1.mgf", body));
    assert!((lumens(&whole) / 8_697.5 - 1.0).abs() < 5e-4);
    assert_eq!(whole.objects.len(), 27);
}

/// The office, and its conversion to VRML 1.0: the same rooms, tables and lamps.
#[test]
fn the_office_and_its_twin() {
    let Some(data) = data() else { return };
    let office = read(&data, "office3/office.mgf").scene;
    let path = data.join("corpus/wrl/castle/lights_materials/raytracer/office.wrl");
    let bytes = std::fs::read(&path).expect("a readable file");
    let twin = azulejo_formats::read(&bytes, "office.wrl", &Folder::of_model(&path))
        .expect("a scene")
        .scene;
    let (found, expected) = (Measures::of(&office), Measures::of(&twin));
    assert_eq!((found.spheres, expected.spheres), (77, 77));
    // Both tessellate circles, with different numbers of sides.
    let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-3;
    assert!(close(found.area, expected.area), "{found:?} {expected:?}");
    assert!(
        close(found.shining, expected.shining),
        "{found:?} {expected:?}"
    );
    let (a, b) = (office.bounds(), twin.bounds());
    let apart = (a.min - b.min).abs().max((a.max - b.max).abs());
    assert!(apart.max_element() < 1e-3, "{a:?} {b:?}");
}

/// Measures of a scene that do not depend on names and materials.
#[derive(Debug, Default)]
struct Measures {
    spheres: usize,
    area: f64,
    /// Area of the surfaces that emit.
    shining: f64,
}

impl Measures {
    fn of(scene: &Scene) -> Measures {
        let mut measures = Measures::default();
        let mut add = |area: f64, material: MaterialId| {
            measures.area += area;
            if scene.materials[material as usize].is_emitter() {
                measures.shining += area;
            }
        };
        for object in &scene.objects {
            match &object.shape {
                Shape::Primitive(p) => add(p.area(), p.material),
                shape => of_faces(shape).for_each(|(area, m)| add(area, m)),
            }
        }
        measures.spheres = scene.objects.iter().filter(|o| is_sphere(&o.shape)).count();
        measures
    }
}

fn is_sphere(shape: &Shape) -> bool {
    match shape {
        Shape::Primitive(p) => p.kind == PrimitiveKind::Sphere,
        Shape::Exact(_) | Shape::Mesh(_) | Shape::Instance(_) => false,
    }
}
