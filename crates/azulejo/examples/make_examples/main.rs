//! Makes the scenes in `examples/`: `cargo run --example make_examples [FOLDER]`.
//!
//! Nothing there is written by hand but the typeface: the Cornell box comes from its published
//! measures, all else from these pages.

mod exact;

use azulejo::formats::grf;
use azulejo::scene::synthetic::{CornellVariant, cornell_box};
use azulejo::scene::{
    Camera, Light, LightKind, Material, MaterialId, Object, Primitive, PrimitiveKind, Rgb, Scene,
    Shape,
};
use glam::{DAffine3, DMat3, DVec3};
use std::error::Error;
use std::fs;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).unwrap_or("examples".into());
    for (name, scene) in [
        ("cornell", cornell_box(CornellVariant::Diffuse)),
        ("cornell-mirror", cornell_box(CornellVariant::MirrorBlock)),
        ("cornell-glossy", cornell_box(CornellVariant::Glossy)),
        ("shapes", shapes()),
        ("studio", studio()),
        ("title", exact::title()?),
        ("csg", exact::csg()?),
    ] {
        scene.validate()?;
        let mut text = Vec::new();
        grf::write(&scene, &mut text)?;
        fs::write(Path::new(&folder).join(name).with_extension("grf"), text)?;
    }
    Ok(())
}

/// A room with one of every exact shape: a mirror ball, a glass ball, a column, a cone, a box,
/// lit by a round lamp and a weak spot.
fn shapes() -> Scene {
    let mut scene = Scene::default();
    let mut diffuse =
        |name, r, g, b| scene.add_material(Material::diffuse(name, Rgb::new(r, g, b)));
    let floor = diffuse("floor", 0.55, 0.45, 0.35);
    let wall = diffuse("wall", 0.75, 0.75, 0.72);
    let blue = diffuse("blue wall", 0.2, 0.3, 0.6);
    let clay = diffuse("clay", 0.7, 0.3, 0.15);
    let moss = diffuse("moss", 0.25, 0.5, 0.2);
    let chrome = scene.add_material(Material::mirror("chrome", Rgb::grey(0.9)));
    let glass = scene.add_material(Material::dielectric("glass", 1.5));
    let lamp = scene.add_material(Material::emitter("lamp", Rgb::new(20.0, 18.0, 14.0)));
    room(&mut scene, floor, wall, blue);
    add(
        &mut scene,
        "lamp",
        Primitive::sphere(DVec3::new(3.0, 2.6, 2.5), 0.2, lamp),
    );
    add(
        &mut scene,
        "chrome ball",
        Primitive::sphere(DVec3::new(1.4, 0.6, 1.5), 0.6, chrome),
    );
    add(
        &mut scene,
        "glass ball",
        Primitive::sphere(DVec3::new(3.3, 0.41, 3.4), 0.4, glass),
    );
    // Floating a hair above the floor, so that nothing is coplanar.
    let at = |x, z| DVec3::new(x, 0.001, z);
    let upright = |kind, base, radius, height, material| {
        Primitive::new(kind, standing(base, radius, height), material)
    };
    let column = upright(PrimitiveKind::Cylinder, at(5.0, 1.0), 0.35, 2.2, wall);
    add(&mut scene, "column", column);
    let cone = upright(
        PrimitiveKind::Cone { top: 0.0 },
        at(3.2, 1.3),
        0.5,
        1.2,
        clay,
    );
    add(&mut scene, "cone", cone);
    let bucket = upright(
        PrimitiveKind::Cone { top: 0.6 },
        at(1.8, 3.6),
        0.35,
        0.5,
        clay,
    );
    add(&mut scene, "bucket", bucket);
    let cuboid = Primitive::new(
        PrimitiveKind::Cuboid,
        turned_box(at(4.4, 2.6), 0.8, 0.5),
        moss,
    );
    add(&mut scene, "box", cuboid);
    scene.lights.push(Light {
        name: "spot".into(),
        kind: LightKind::Spot {
            position: DVec3::new(0.3, 2.7, 3.7),
            direction: DVec3::new(1.1, -2.1, -2.2).normalize(),
            intensity: Rgb::new(6.0, 7.0, 9.0),
            inner: 0.2,
            outer: 0.35,
        },
    });
    scene.cameras.push(Camera {
        name: "door".into(),
        eye: DVec3::new(3.0, 1.7, 7.4),
        target: DVec3::new(3.0, 1.1, 1.0),
        up: DVec3::Y,
        vertical_fov: 42f64.to_radians(),
        size: Some((640, 480)),
    });
    scene
}

fn add(scene: &mut Scene, name: &str, primitive: Primitive) {
    scene
        .objects
        .push(Object::new(name, Shape::Primitive(primitive)));
}

/// A photographer's corner for any model: put one in with `--place MODEL:fit=2`.
fn studio() -> Scene {
    let mut scene = Scene::default();
    let mut diffuse =
        |name, r, g, b| scene.add_material(Material::diffuse(name, Rgb::new(r, g, b)));
    let floor = diffuse("floor", 0.5, 0.48, 0.45);
    let wall = diffuse("wall", 0.65, 0.66, 0.68);
    let key = scene.add_material(Material::emitter("key lamp", Rgb::new(24.0, 22.0, 19.0)));
    let fill = scene.add_material(Material::emitter("fill lamp", Rgb::new(2.0, 2.4, 3.0)));
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let tilted = (2.0 * z - 1.2 * y) * 0.7;
    for (name, corner, edge1, edge2, material) in [
        ("floor", -8.0 * x - 3.0 * z, 10.0 * z, 14.0 * x, floor),
        ("wall", -8.0 * x - 3.0 * z, 14.0 * x, 7.0 * y, wall),
        ("key lamp", DVec3::new(-3.2, 5.0, 1.0), 1.6 * x, tilted, key),
        (
            "fill lamp",
            DVec3::new(5.0, 1.0, 1.0),
            3.0 * z,
            3.0 * y,
            fill,
        ),
    ] {
        let lamp = Primitive::parallelogram(corner, edge1, edge2, material);
        add(&mut scene, name, lamp);
    }
    scene.cameras.push(Camera {
        name: "front".into(),
        eye: DVec3::new(2.0, 1.9, 5.2),
        target: DVec3::new(0.0, 0.65, 0.0),
        up: y,
        vertical_fov: 32f64.to_radians(),
        size: Some((640, 480)),
    });
    scene
}

/// Floor, ceiling and three walls of a room of 6 × 3 × 5, open toward the viewer; each a
/// parallelogram that faces inward.
fn room(scene: &mut Scene, floor: MaterialId, wall: MaterialId, blue: MaterialId) {
    let (x, y, z) = (6.0 * DVec3::X, 3.0 * DVec3::Y, 5.0 * DVec3::Z);
    for (name, corner, edge1, edge2, material) in [
        ("floor", DVec3::ZERO, z, x, floor),
        ("ceiling", y, x, z, wall),
        ("back wall", DVec3::ZERO, x, y, wall),
        ("left wall", DVec3::ZERO, y, z, blue),
        ("right wall", x, z, y, wall),
    ] {
        add(
            scene,
            name,
            Primitive::parallelogram(corner, edge1, edge2, material),
        );
    }
}

/// Stands a shape whose axis is z upright on `base`.
fn standing(base: DVec3, radius: f64, height: f64) -> DAffine3 {
    let columns = DMat3::from_cols(radius * DVec3::Z, radius * DVec3::X, height * DVec3::Y);
    DAffine3::from_mat3_translation(columns, base)
}

/// A box with a square base, turned by half a radian about the vertical.
fn turned_box(corner: DVec3, side: f64, height: f64) -> DAffine3 {
    let turn = DMat3::from_rotation_y(0.5);
    DAffine3::from_mat3_translation(
        turn * DMat3::from_diagonal(DVec3::new(side, height, side)),
        corner,
    )
}
