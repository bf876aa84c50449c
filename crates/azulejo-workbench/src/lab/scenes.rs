//! The scenes of the lessons.

use super::{Lesson, POWER};
use azulejo::scene::brdf::Brdf;
use azulejo::scene::math::area_vector;
use azulejo::scene::synthetic::{CornellVariant, cornell_box};
use azulejo::scene::{
    Camera, Contour, Curve, Exact, Figure, Material, MaterialId, Mesh, Object, Prism, Rgb, Scene,
    Shape, Solid, Units,
};
use glam::{DAffine3, DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Reflectance of the room with bounces.
pub(super) const WALLS: f64 = 0.6;
/// Reflectance of the mirror.
pub(super) const MIRROR: f64 = 0.8;
/// Corners of the polygons of the letter that is a mesh.
const CORNERS: usize = 8;
/// The sheet whose area is asked for, of four corners.
const SHEET: [DVec3; 4] = [
    DVec3::new(-0.5, 0.2, -0.6),
    DVec3::new(0.6, 0.1, -0.6),
    DVec3::new(0.75, 1.0, -0.6),
    DVec3::new(-0.3, 1.2, -0.6),
];
/// A rough metal with one wavelength, by wave optics.
const WAVES: &str = "he_torrance ks = 0.9 sigma0 = 0.18 tau = 6 lambda = 0.55";
/// A metal with about the same slopes, by facets.
const FACETS: &str = "torrance_sparrow_gauss ks = 0.9 c = 12";

/// The scene of a lesson.
pub(super) fn scene(lesson: Lesson) -> Scene {
    match lesson {
        Lesson::FormFactor | Lesson::ErrorBar => squares(),
        Lesson::EnergyBalance => room(),
        Lesson::Reciprocity => sheet(),
        Lesson::Engines => cornell_box(CornellVariant::Diffuse),
        Lesson::Mirror => mirror(),
        Lesson::Grazing => plates(),
        Lesson::Letter => letters(),
    }
}

/// The area of the sheet, m².
pub(super) fn sheet_area() -> f64 {
    area_vector(&SHEET).length()
}

/// An empty scene in metres with a camera.
fn stage(eye: DVec3, target: DVec3) -> Scene {
    Scene {
        units: Units {
            metres_per_unit: Some(1.0),
            ..Units::default()
        },
        cameras: vec![Camera {
            name: "front".into(),
            eye,
            target,
            up: DVec3::Y,
            vertical_fov: 40f64.to_radians(),
            size: None,
        }],
        ..Scene::default()
    }
}

/// Adds a polygon, counter-clockwise as seen from its front.
fn add(scene: &mut Scene, name: &str, corners: &[DVec3], material: MaterialId) {
    let mut mesh = Mesh {
        positions: corners.to_vec(),
        ..Mesh::default()
    };
    let order: Vec<u32> = (0..corners.len() as u32).collect();
    mesh.push_face(&order, material);
    scene.objects.push(Object::new(name, Shape::Mesh(mesh)));
}

/// A rectangle from one corner by two edges; its front is where their cross product points.
fn rectangle(corner: DVec3, u: DVec3, v: DVec3) -> [DVec3; 4] {
    [corner, corner + u, corner + u + v, corner + v]
}

fn white(scene: &mut Scene) -> MaterialId {
    scene.add_material(Material::diffuse("white", Rgb::grey(0.7)))
}

/// A square of 1 m that faces up around the origin, and one that faces down above it.
fn squares() -> Scene {
    let mut scene = stage(DVec3::new(1.3, 0.85, 3.1), DVec3::new(0.0, 0.5, 0.0));
    let white = white(&mut scene);
    let low = DVec3::new(-0.5, 0.0, -0.5);
    add(
        &mut scene,
        "lower",
        &rectangle(low, DVec3::Z, DVec3::X),
        white,
    );
    let high = low + DVec3::Y;
    add(
        &mut scene,
        "upper",
        &rectangle(high, DVec3::X, DVec3::Z),
        white,
    );
    scene
}

/// A closed cube of 2 m seen from inside, whose ceiling emits; everything reflects the same.
fn room() -> Scene {
    let size = 2.0;
    let mut scene = stage(DVec3::new(1.0, 1.0, 1.98), DVec3::new(1.0, 0.9, 0.0));
    scene.cameras[0].vertical_fov = 75f64.to_radians();
    let walls = scene.add_material(Material::diffuse("walls", Rgb::grey(WALLS)));
    let lamp = scene.add_material(Material {
        emission: Rgb::grey(POWER / (PI * size * size)),
        ..Material::diffuse("lamp", Rgb::grey(WALLS))
    });
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| size * axis);
    let sides = [
        ("floor", DVec3::ZERO, z, x, walls),
        ("ceiling", y, x, z, lamp),
        ("back", DVec3::ZERO, x, y, walls),
        ("front", z, y, x, walls),
        ("left", DVec3::ZERO, y, z, walls),
        ("right", x, z, y, walls),
    ];
    for (name, corner, u, v, material) in sides {
        add(&mut scene, name, &rectangle(corner, u, v), material);
    }
    scene
}

/// A square of 1 m, and an upright sheet behind it.
fn sheet() -> Scene {
    let mut scene = stage(DVec3::new(0.9, 1.3, 3.0), DVec3::new(0.1, 0.5, 0.0));
    let white = white(&mut scene);
    let low = DVec3::new(-0.5, 0.0, -0.5);
    add(
        &mut scene,
        "square",
        &rectangle(low, DVec3::Z, DVec3::X),
        white,
    );
    add(&mut scene, "sheet", &SHEET, white);
    scene
}

/// The two squares, with a mirror along one side of both.
fn mirror() -> Scene {
    let mut scene = squares();
    scene.cameras[0].eye = DVec3::new(2.2, 0.9, 2.6);
    let glass = scene.add_material(Material::mirror("mirror", Rgb::grey(MIRROR)));
    let corner = DVec3::new(-0.5, 0.0, -0.5);
    add(
        &mut scene,
        "mirror",
        &rectangle(corner, DVec3::Y, DVec3::Z),
        glass,
    );
    scene
}

/// Two plates of rough metal under bars of light, seen at a grazing angle.
fn plates() -> Scene {
    let mut scene = stage(DVec3::new(0.0, 1.0, 6.0), DVec3::new(0.0, 0.1, 0.0));
    let mut metal = |name: &str, text: &str| {
        let model = text.parse().and_then(Brdf::new);
        // A test excludes that.
        let material = model.map_or_else(
            |_| Material::diffuse(name, Rgb::grey(0.5)),
            |model| Material::with_brdf(name, Arc::new(model)),
        );
        scene.add_material(material)
    };
    let (waves, facets) = (metal("waves", WAVES), metal("facets", FACETS));
    let lamp = scene.add_material(Material::emitter("lamp", Rgb::grey(6.0)));
    let (u, v) = (2.4 * DVec3::Z, 1.15 * DVec3::X);
    for (name, x, material) in [("waves", -1.2, waves), ("facets", 0.05, facets)] {
        let corner = DVec3::new(x, 0.0, -1.2);
        add(&mut scene, name, &rectangle(corner, u, v), material);
    }
    for k in 0..5 {
        let corner = DVec3::new(-1.1 + 0.5 * f64::from(k), 0.05, -1.5);
        let (u, v) = (0.2 * DVec3::X, 0.5 * DVec3::Y);
        let name = format!("bar {}", k + 1);
        add(&mut scene, &name, &rectangle(corner, u, v), lamp);
    }
    scene
}

/// The letter O as an exact prism and as a mesh, both shining.
fn letters() -> Scene {
    const DEPTH: f64 = 1e-3;
    let mut scene = stage(DVec3::new(0.0, 0.9, 5.2), DVec3::new(0.0, 0.5, 0.0));
    let white = white(&mut scene);
    let shine = scene.add_material(Material::emitter("shine", Rgb::grey(10.0)));
    let floor = rectangle(DVec3::new(-2.0, 0.0, -0.5), 2.0 * DVec3::Z, 4.0 * DVec3::X);
    add(&mut scene, "floor", &floor, white);
    let [outer, inner] = [0.5, 0.3];
    let figure = Figure {
        contours: vec![circle(outer), circle(inner)],
        ..Figure::default()
    };
    let prism = Prism {
        figure: Arc::new(figure),
        world_from_figure: DAffine3::from_translation(DVec3::new(-0.7, 0.55, 0.0))
            * DAffine3::from_scale(DVec3::new(1.0, 1.0, DEPTH)),
        material: shine,
        bevel: None,
    };
    let exact = Exact::new(vec![Solid::Prism(prism)]);
    scene
        .objects
        .push(Object::new("exact", Shape::Exact(exact)));
    let mesh = ring_mesh([inner, outer], DVec3::new(0.7, 0.55, 0.0), DEPTH, shine);
    scene.objects.push(Object::new("mesh", Shape::Mesh(mesh)));
    scene
}

/// A circle of four cubic curves, which deviate from it by 2.7e-4 of its radius.
fn circle(radius: f64) -> Contour {
    let k = 4.0 / 3.0 * (TAU / 16.0).tan();
    let quarter = |n: u32| {
        let (sin, cos) = (0.25 * TAU * f64::from(n)).sin_cos();
        let (along, across) = (DVec2::new(cos, sin), DVec2::new(-sin, cos));
        Curve::Cubic {
            start: radius * along,
            control1: radius * (along + k * across),
            control2: radius * (across + k * along),
        }
    };
    Contour {
        curves: (0..4).map(quarter).collect(),
    }
}

/// A ring between two regular polygons, extruded along z: front, back, and both rims.
fn ring_mesh([inner, outer]: [f64; 2], centre: DVec3, depth: f64, material: MaterialId) -> Mesh {
    let mut mesh = Mesh::default();
    for (radius, z) in [(inner, 0.0), (outer, 0.0), (inner, depth), (outer, depth)] {
        let corner = |k: usize| {
            let (sin, cos) = (TAU * k as f64 / CORNERS as f64).sin_cos();
            centre + DVec3::new(radius * cos, radius * sin, z)
        };
        mesh.positions.extend((0..CORNERS).map(corner));
    }
    for k in 0..CORNERS {
        let next = (k + 1) % CORNERS;
        let at = |ring: usize, k: usize| (ring * CORNERS + k) as u32;
        let [back, front] = [[0, 1], [2, 3]];
        for face in [
            [
                at(front[0], k),
                at(front[1], k),
                at(front[1], next),
                at(front[0], next),
            ],
            [
                at(back[0], next),
                at(back[1], next),
                at(back[1], k),
                at(back[0], k),
            ],
            [
                at(back[1], k),
                at(back[1], next),
                at(front[1], next),
                at(front[1], k),
            ],
            [
                at(back[0], next),
                at(back[0], k),
                at(front[0], k),
                at(front[0], next),
            ],
        ] {
            mesh.push_face(&face, material);
        }
    }
    mesh
}
