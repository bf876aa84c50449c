//! The box of Cornell University, as published.

use crate::{
    Brdf, Camera, Material, MaterialId, Mesh, Object, Primitive, Rgb, Scene, Shape, Units,
};
use glam::DVec3;
use std::sync::Arc;

/// The material of the tall block of the [`cornell_box`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CornellVariant {
    /// White, as in the laboratory.
    Diffuse,
    /// A mirror of reflectance 0.9.
    MirrorBlock,
    /// Polished aluminium by He and Torrance, on a brushed floor by Ward, with a ball of rough gold
    /// in the short block's place.
    Glossy,
}

/// The box of the Program of Computer Graphics at Cornell University, with its published
/// measured geometry, in millimetres; reflectances and light as the usual RGB approximations.
///
/// The lamp fills a hole in the ceiling; the front, z = 0, is open. One object per face, the
/// camera as published.
pub fn cornell_box(variant: CornellVariant) -> Scene {
    let mut scene = Scene {
        units: Units {
            metres_per_unit: Some(1e-3),
            ..Units::default()
        },
        ..Scene::default()
    };
    let mut diffuse =
        |name: &str, r, g, b| scene.add_material(Material::diffuse(name, Rgb::new(r, g, b)));
    let white = diffuse("white", 0.725, 0.71, 0.68);
    let red = diffuse("red", 0.63, 0.065, 0.05);
    let green = diffuse("green", 0.14, 0.45, 0.091);
    let light = scene.add_material(Material::emitter("light", Rgb::new(17.0, 12.0, 4.0)));
    // The variant decides on the tall block, the floor, and what is in the place of the short block.
    let tall = match variant {
        CornellVariant::Diffuse => white,
        CornellVariant::MirrorBlock => {
            scene.add_material(Material::mirror("mirror", Rgb::grey(0.9)))
        }
        CornellVariant::Glossy => add_model(
            &mut scene,
            "aluminium",
            "he_torrance sigma0 = 0.13 tau = 2.2 metal = aluminium",
        ),
    };
    let floor = match variant {
        CornellVariant::Glossy => add_model(
            &mut scene,
            "brushed",
            "ward_gmd kd = (0.3, 0.25, 0.2) ks = 0.45 ax = 0.07 ay = 0.25",
        ),
        _ => white,
    };
    add_cornell_room(&mut scene, [floor, white, red, green, light]);
    // The published tops of the blocks, whose sides go straight down to the floor.
    let short_top = [
        [130, 165, 65],
        [82, 165, 225],
        [240, 165, 272],
        [290, 165, 114],
    ];
    let tall_top = [
        [423, 330, 247],
        [265, 330, 296],
        [314, 330, 456],
        [472, 330, 406],
    ];
    if variant == CornellVariant::Glossy {
        let gold = add_model(
            &mut scene,
            "gold",
            "ggx_smith ax = 0.15 ay = 0.15 metal = gold",
        );
        let ball = Primitive::sphere(DVec3::new(185.0, 90.1, 169.0), 90.0, gold);
        scene
            .objects
            .push(Object::new("ball", Shape::Primitive(ball)));
    } else {
        add_cornell_block(&mut scene, "short", short_top, white);
    }
    add_cornell_block(&mut scene, "tall", tall_top, tall);
    // A film of 25 mm at a focal length of 35 mm, as published, gives the field of view.
    scene.cameras.push(Camera {
        name: "front".into(),
        eye: DVec3::new(278.0, 273.0, -800.0),
        target: DVec3::new(278.0, 273.0, -799.0),
        up: DVec3::Y,
        vertical_fov: 39.307_724f64.to_radians(),
        size: Some((512, 512)),
    });
    scene
}

/// Adds a material with this reflection model.
///
/// # Panics
/// If the text is not a valid description.
fn add_model(scene: &mut Scene, name: &str, text: &str) -> MaterialId {
    let brdf = text.parse().and_then(Brdf::new);
    let brdf = brdf.unwrap_or_else(|problem| panic!("{text}: {problem}"));
    scene.add_material(Material::with_brdf(name, Arc::new(brdf)))
}

type Quad = [DVec3; 4];

fn add_quad(scene: &mut Scene, name: impl Into<String>, quad: Quad, material: MaterialId) {
    let mut mesh = Mesh {
        positions: quad.to_vec(),
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2, 3], material);
    scene.objects.push(Object::new(name, Shape::Mesh(mesh)));
}

fn add_cornell_room(scene: &mut Scene, [ground, white, red, green, light]: [MaterialId; 5]) {
    let p = DVec3::new;
    let (height, depth) = (548.8, 559.2);
    let floor = [
        p(552.8, 0.0, 0.0),
        p(0.0, 0.0, 0.0),
        p(0.0, 0.0, depth),
        p(549.6, 0.0, depth),
    ];
    let ceiling = [
        p(556.0, height, 0.0),
        p(556.0, height, depth),
        p(0.0, height, depth),
        p(0.0, height, 0.0),
    ];
    let lamp = [
        p(343.0, height, 227.0),
        p(343.0, height, 332.0),
        p(213.0, height, 332.0),
        p(213.0, height, 227.0),
    ];
    add_quad(scene, "floor", floor, ground);
    for k in 0..4 {
        // Four trapezoids around the lamp.
        let next = (k + 1) % 4;
        let piece = [ceiling[k], ceiling[next], lamp[next], lamp[k]];
        add_quad(scene, format!("ceiling{k}"), piece, white);
    }
    let [a, b, c, d] = floor;
    let [e, f, g, h] = ceiling;
    add_quad(scene, "back", [d, c, g, f], white);
    add_quad(scene, "right", [c, b, h, g], green);
    add_quad(scene, "left", [a, d, f, e], red);
    add_quad(scene, "light", lamp, light);
}

fn add_cornell_block(scene: &mut Scene, name: &str, top: [[i32; 3]; 4], material: MaterialId) {
    let top = top.map(|c| DVec3::from_array(c.map(f64::from)));
    let foot = |p: DVec3| DVec3::new(p.x, 0.0, p.z);
    add_quad(scene, format!("{name}_top"), top, material);
    for k in 0..4 {
        let (a, b) = (top[k], top[(k + 1) % 4]);
        let side = [b, a, foot(a), foot(b)];
        add_quad(scene, format!("{name}_side{k}"), side, material);
    }
}
