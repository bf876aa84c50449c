//! Final gathers: irradiance at the hit instead of interpolated between vertices.

use crate::furnace::room;
use crate::{assert_close, mesh_of, polygon, primitive, radiance_along};
use azulejo_render::{FinalGather, SecondPass};
use azulejo_scene::{Light, LightKind, Material, Primitive, Rgb, Scene, SurfaceGrid, SurfaceLight};
use glam::DVec3;
use std::f64::consts::PI;

fn gathering(rays: u32) -> SecondPass {
    SecondPass {
        gather: FinalGather::Everywhere(rays),
        samples_per_pixel: 64,
        ..SecondPass::default()
    }
}

/// A white floor in z = 0, seen from above or below at (0.1, 0.2).
fn floor(scene: &mut Scene) -> usize {
    let white = scene.add_material(Material::diffuse("floor", Rgb::new(0.8, 0.5, 0.3)));
    let corners = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)];
    polygon(scene, &corners.map(|(x, y)| DVec3::new(x, y, 0.0)), white)
}

fn look_at_floor(scene: &Scene, from: f64, options: &SecondPass) -> Rgb {
    let at = DVec3::new(0.1, 0.2, 0.0);
    radiance_along(scene, &[(at + DVec3::new(0.5, 0.0, from), at)], options)[0]
}

/// Form factor of a rectangle `a` × `b` that is parallel to a point's plane, one unit above, with
/// a corner over the point.
fn corner_factor(a: f64, b: f64) -> f64 {
    let half = |x: f64, y: f64| x / x.hypot(1.0) * (y / x.hypot(1.0)).atan();
    (half(a, b) + half(b, a)) / (2.0 * PI)
}

#[test]
fn a_lamp_lights_the_floor_as_its_form_factor_says() {
    let mut scene = Scene::default();
    floor(&mut scene);
    let lamp = scene.add_material(Material::emitter("lamp", Rgb::new(5.0, 4.0, 3.0)));
    let corner = DVec3::new(-0.4, -0.8, 1.0);
    primitive(
        &mut scene,
        Primitive::parallelogram(corner, 2.0 * DVec3::Y, DVec3::X, lamp),
    );
    let found = look_at_floor(&scene, 0.5, &gathering(8));
    // The lamp is centred over the seen point: four equal quarters.
    let factor = 4.0 * corner_factor(0.5, 1.0);
    let expected = Rgb::new(0.8, 0.5, 0.3) * Rgb::new(5.0, 4.0, 3.0) * factor;
    assert_close(found, expected, 1e-5);
}

fn add_bulb(scene: &mut Scene, height: f64) {
    let kind = LightKind::Point {
        position: DVec3::new(0.1, 0.2, height),
        intensity: Rgb::new(2.0, 4.0, 8.0),
    };
    scene.lights.push(Light {
        name: "bulb".into(),
        kind,
    });
}

#[test]
fn a_bulb_lights_by_the_square_of_its_distance() {
    let mut scene = Scene::default();
    floor(&mut scene);
    add_bulb(&mut scene, 2.0);
    let lit = Rgb::new(0.8, 0.5, 0.3) * Rgb::new(2.0, 4.0, 8.0) / (4.0 * PI);
    assert_close(look_at_floor(&scene, 3.0, &gathering(4)), lit, 1e-5);
    assert_close(look_at_floor(&scene, -3.0, &gathering(4)), Rgb::BLACK, 0.0);
}

#[test]
fn backs_are_lit_by_what_is_behind_also_without_a_final_gather() {
    let mut scene = Scene::default();
    let sheet = floor(&mut scene);
    mesh_of(&mut scene, sheet).irradiance = vec![Rgb::grey(PI); 4];
    add_bulb(&mut scene, -2.0);
    let lit = Rgb::new(0.8, 0.5, 0.3) * Rgb::new(2.0, 4.0, 8.0) / (4.0 * PI);
    let plain = SecondPass::default();
    assert_close(look_at_floor(&scene, -3.0, &plain), lit, 1e-5);
    assert_close(
        look_at_floor(&scene, 3.0, &plain),
        Rgb::new(0.8, 0.5, 0.3),
        1e-5,
    );
}

/// A floor of given irradiance under a bulb that gives another, seen with gathers where corners
/// differ.
fn look_at_uneven(irradiance: [f64; 4], errors: &[Rgb], evenness: f64) -> Rgb {
    let mut scene = Scene::default();
    let sheet = floor(&mut scene);
    let mesh = mesh_of(&mut scene, sheet);
    mesh.irradiance = irradiance.map(|e| Rgb::grey(PI * e)).to_vec();
    mesh.irradiance_error = errors.to_vec();
    add_bulb(&mut scene, 2.0);
    let options = SecondPass {
        gather: FinalGather::Uneven(4),
        evenness,
        ..SecondPass::default()
    };
    look_at_floor(&scene, 3.0, &options)
}

#[test]
fn where_corners_differ_by_half_light_is_gathered() {
    let floor = Rgb::new(0.8, 0.5, 0.3);
    let lit = floor * Rgb::new(2.0, 4.0, 8.0) / (4.0 * PI);
    assert_close(look_at_uneven([1.0, 1.0, 0.0, 0.0], &[], 0.5), lit, 1e-5);
    assert_close(look_at_uneven([1.0; 4], &[], 0.5), floor, 1e-5);
    // Half of the largest is not enough, and neither is noise.
    let even = look_at_uneven([1.0, 0.6, 1.0, 0.6], &[], 0.5);
    assert!((even.r / floor.r - 0.8).abs() < 0.01, "{even:?}");
    // Where a smaller share is allowed it is enough.
    assert_close(look_at_uneven([1.0, 0.6, 1.0, 0.6], &[], 0.3), lit, 1e-5);
    let noisy = look_at_uneven([1.0, 0.0, 1.0, 0.0], &[Rgb::grey(PI * 0.2); 4], 0.5);
    assert!((noisy.r / floor.r - 0.5).abs() < 0.02, "{noisy:?}");
}

#[test]
fn primitives_are_gathered_where_a_cell_is_uneven() {
    let mut scene = Scene::default();
    let white = scene.add_material(Material::diffuse("floor", Rgb::grey(0.5)));
    let corner = DVec3::new(-9.0, -9.0, 0.0);
    let mut sheet = Primitive::parallelogram(corner, 18.0 * DVec3::X, 18.0 * DVec3::Y, white);
    // Two cells, of which the second is seen: even first, then not.
    let light = |values: [f64; 6]| SurfaceLight {
        grids: vec![SurfaceGrid { nu: 2, nv: 1 }],
        irradiance: values.map(|e| Rgb::grey(PI * e)).to_vec(),
        error: Vec::new(),
    };
    let mut look = |values| {
        sheet.light = Some(Box::new(light(values)));
        let mut scene = scene.clone();
        primitive(&mut scene, sheet.clone());
        add_bulb(&mut scene, 2.0);
        let options = SecondPass {
            gather: FinalGather::Uneven(4),
            ..SecondPass::default()
        };
        look_at_floor(&scene, 3.0, &options)
    };
    assert_close(look([0.0, 1.0, 1.0, 0.0, 1.0, 1.0]), Rgb::grey(0.5), 1e-5);
    let lit = Rgb::new(2.0, 4.0, 8.0) * (0.5 / (4.0 * PI));
    assert_close(look([1.0, 1.0, 0.0, 1.0, 1.0, 0.0]), lit, 1e-5);
}

/// The furnace seen with a final gather.
fn check_furnace(scene: &Scene, tolerance: f64) {
    let eye = DVec3::new(0.3, 0.2, 0.1);
    let around = [DVec3::X, -DVec3::Z, DVec3::new(2.7, 1.5, 0.4)];
    let rays = around.map(|d| (eye, eye + d));
    for radiance in radiance_along(scene, &rays, &gathering(64)) {
        assert_close(radiance, Rgb::WHITE, tolerance);
    }
}

#[test]
fn a_gathered_furnace_has_radiance_one() {
    check_furnace(&room(), 0.02);
}

#[test]
fn a_gather_finds_its_own_light_without_a_first_pass() {
    let mut scene = room();
    scene.materials[0] = Material {
        emission: Rgb::grey(0.6),
        ..Material::diffuse("wall", Rgb::grey(0.4))
    };
    mesh_of(&mut scene, 0).irradiance.clear();
    // Six bounces leave out 0.4 to the 7th at least.
    check_furnace(&scene, 0.02);
}
