//! Interpolation, colours and textures, seen along rays.

use crate::{assert_close, mesh_of, polygon, primitive, radiance_along};
use azulejo_render::SecondPass;
use azulejo_scene::{
    Attribute, BackIrradiance, Image, Light, LightKind, Material, Primitive, PrimitiveKind, Rgb,
    Scene, SurfaceGrid, SurfaceLight, Texture,
};
use glam::{DAffine3, DVec2, DVec3};
use std::f64::consts::PI;

/// A linear field over x and y.
fn field(x: f64, y: f64) -> Rgb {
    Rgb::new(3.0 + x, 4.0 - 0.5 * y, 5.0 + 0.3 * x + 0.7 * y)
}

/// Looks straight down on a polygon in a plane that is tilted about x = y = 0.
fn check(outline: &[(f64, f64)], seen: &[(f64, f64)]) {
    let lift = |x: f64, y: f64| DVec3::new(x, y, 0.4 * x - 0.2 * y);
    let mut scene = Scene::default();
    let white = scene.add_material(Material::diffuse("white", Rgb::new(1.0, 0.5, 0.25)));
    let corners: Vec<DVec3> = outline.iter().map(|&(x, y)| lift(x, y)).collect();
    let object = polygon(&mut scene, &corners, white);
    let irradiance = outline.iter().map(|&(x, y)| PI * field(x, y)).collect();
    mesh_of(&mut scene, object).irradiance = irradiance;
    let down = |&(x, y): &(f64, f64)| (lift(x, y) + 3.0 * DVec3::Z, lift(x, y));
    let rays: Vec<(DVec3, DVec3)> = seen.iter().map(down).collect();
    let found = radiance_along(&scene, &rays, &SecondPass::default());
    for (&(x, y), radiance) in seen.iter().zip(found) {
        let expected = Rgb::new(1.0, 0.5, 0.25) * field(x, y);
        assert_close(radiance, expected, 1e-5);
    }
}

#[test]
fn linear_fields_come_out_exactly() {
    let inside = [(0.1, 0.1), (0.5, 0.3), (0.2, 0.6), (0.45, 0.45)];
    check(&[(0., 0.), (1., 0.), (0., 1.)], &inside);
    check(&[(0., 0.), (1., 0.), (1., 1.), (0., 1.)], &inside);
    check(&[(0., 0.), (2., -0.5), (1.2, 1.), (-0.5, 1.5)], &inside);
    // A dart, concave at its third corner, by its triangles.
    check(
        &[(0., 0.), (2., 0.), (0.5, 0.5), (0., 2.)],
        &[(0.1, 0.1), (0.9, 0.1), (0.2, 0.6)],
    );
    check(
        &[(0., 0.), (1., -0.2), (1.4, 0.5), (0.9, 1.2), (-0.1, 1.)],
        &inside,
    );
}

#[test]
fn no_diagonal_shows_in_a_quadrilateral() {
    // One bright corner: triangles would make the middle either 1/2 or 0, bilinear is 1/4.
    let mut scene = Scene::default();
    let white = scene.add_material(Material::diffuse("white", Rgb::WHITE));
    let corners = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
    let object = polygon(&mut scene, &corners, white);
    let mut irradiance = vec![Rgb::BLACK; 4];
    irradiance[2] = Rgb::grey(PI);
    mesh_of(&mut scene, object).irradiance = irradiance;
    let at = |x: f64, y: f64| (DVec3::new(x, y, 1.0), DVec3::new(x, y, 0.0));
    let rays = [at(0.5, 0.5), at(0.25, 0.75), at(0.75, 0.25)];
    let found = radiance_along(&scene, &rays, &SecondPass::default());
    assert_close(found[0], Rgb::grey(0.25), 1e-5);
    assert_close(found[1], Rgb::grey(0.1875), 1e-5);
    assert_close(found[2], Rgb::grey(0.1875), 1e-5);
}

#[test]
fn vertex_colours_and_textures_multiply_the_reflectance() {
    let mut scene = Scene::default();
    let image = Image {
        width: 2,
        height: 1,
        pixels: vec![[0.5, 1.0, 0.0], [1.0, 0.25, 0.0]],
        alpha: None,
    };
    for image in [Some(image), None] {
        scene.textures.push(Texture {
            path: "paint".into(),
            image,
            ..Texture::default()
        });
    }
    let painted = scene.add_material(Material {
        textures: vec![0, 1],
        ..Material::diffuse("painted", Rgb::grey(0.5))
    });
    let corners = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
    let object = polygon(&mut scene, &corners, painted);
    let mesh = mesh_of(&mut scene, object);
    mesh.irradiance = vec![Rgb::grey(PI); 4];
    mesh.colors = vec![Rgb::new(1.0, 0.5, 1.0); 4];
    let uvs = corners.map(|c| DVec2::new(c.x, c.y)).to_vec();
    mesh.uvs = Some(Attribute::per_vertex(uvs));
    let at = |x: f64| (DVec3::new(x, 0.3, 1.0), DVec3::new(x, 0.3, 0.0));
    let found = radiance_along(&scene, &[at(0.25), at(0.75)], &SecondPass::default());
    assert_close(found[0], Rgb::new(0.25, 0.25, 0.0), 1e-5);
    assert_close(found[1], Rgb::new(0.5, 0.0625, 0.0), 1e-5);
}

#[test]
fn primitives_show_the_light_of_the_part_that_is_seen() {
    let mut scene = Scene::default();
    let white = scene.add_material(Material::diffuse("white", Rgb::WHITE));
    let mut cube = Primitive::new(PrimitiveKind::Cuboid, DAffine3::IDENTITY, white);
    let grid = SurfaceGrid { nu: 1, nv: 1 };
    // Part k carries k, and 1 more toward its corner u = v = 1.
    let part = |k: i32| [0.0, 0.0, 0.0, 1.0].map(|bump| Rgb::grey(PI * (f64::from(k) + bump)));
    cube.light = Some(Box::new(SurfaceLight {
        grids: vec![grid; 6],
        irradiance: (0..6).flat_map(part).collect(),
        error: Vec::new(),
    }));
    primitive(&mut scene, cube);
    let middle = DVec3::splat(0.5);
    let axes = [
        -DVec3::X,
        DVec3::X,
        -DVec3::Y,
        DVec3::Y,
        -DVec3::Z,
        DVec3::Z,
    ];
    let rays = axes.map(|axis| (middle + 2.0 * axis, middle));
    let found = radiance_along(&scene, &rays, &SecondPass::default());
    for (k, radiance) in found.into_iter().enumerate() {
        assert_close(radiance, Rgb::grey(k as f64 + 0.25), 1e-5);
    }
}

#[test]
fn a_scene_without_a_first_pass_shows_its_lamps_only() {
    let mut scene = Scene::default();
    let white = scene.add_material(Material::diffuse("white", Rgb::WHITE));
    polygon(&mut scene, &[DVec3::ZERO, DVec3::X, DVec3::Y], white);
    primitive(
        &mut scene,
        Primitive::sphere(DVec3::new(5.0, 0.0, 0.0), 1.0, white),
    );
    let found = radiance_along(
        &scene,
        &[
            (DVec3::new(0.2, 0.2, 1.0), DVec3::new(0.2, 0.2, 0.0)),
            (DVec3::new(5.0, 0.0, 4.0), DVec3::new(5.0, 0.0, 0.0)),
        ],
        &SecondPass::default(),
    );
    assert_eq!(found, [Rgb::BLACK; 2]);
}

/// A sheet in a room of even radiance, with marked irradiance on its sides; seen from both.
fn seen_of_sheet(back: Option<BackIrradiance>) -> [Rgb; 2] {
    let mut scene = Scene::default();
    let white = scene.add_material(Material::diffuse("white", Rgb::grey(0.5)));
    let corners = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
    let object = polygon(&mut scene, &corners, white);
    let mesh = mesh_of(&mut scene, object);
    mesh.irradiance = vec![Rgb::grey(4.0 * PI); 4];
    mesh.back = back.map(Box::new);
    scene.lights.push(Light {
        name: String::new(),
        kind: LightKind::Ambient {
            radiance: Rgb::WHITE,
        },
    });
    let middle = DVec3::new(0.4, 0.3, 0.0);
    let rays = [DVec3::Z, -DVec3::Z].map(|side| (middle + side, middle));
    let found = radiance_along(&scene, &rays, &SecondPass::default());
    [found[0], found[1]]
}

#[test]
fn each_side_shows_its_own_light() {
    let back = |e: [Option<f64>; 4]| BackIrradiance {
        irradiance: e.map(|e| e.map(|e| Rgb::grey(e * PI))).to_vec(),
        error: Vec::new(),
    };
    let [front, behind] = seen_of_sheet(Some(back([Some(6.0); 4])));
    assert_close(front, Rgb::grey(2.0), 1e-6);
    assert_close(behind, Rgb::grey(3.0), 1e-6);
    // What is not stored is gathered: the room's radiance.
    for unknown in [None, Some(back([Some(6.0), None, Some(6.0), Some(6.0)]))] {
        let [front, behind] = seen_of_sheet(unknown);
        assert_close(front, Rgb::grey(2.0), 1e-6);
        assert_close(behind, Rgb::grey(0.5), 1e-6);
    }
}
