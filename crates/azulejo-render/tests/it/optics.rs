//! Mirrors and glass against geometrical optics.

use crate::{assert_close, polygon, primitive, radiance_along};
use azulejo_render::SecondPass;
use azulejo_scene::{
    Attribute, Material, Mesh, Object, Primitive, PrimitiveKind, Rgb, Scene, Shape,
};
use glam::{DAffine3, DVec3};
use std::f64::consts::PI;

/// A wall at z = 4 that faces −z, with irradiance that differs everywhere.
fn wall(scene: &mut Scene) {
    let white = scene.add_material(Material::diffuse("wall", Rgb::WHITE));
    let corners = [(9.0, -9.0), (-9.0, -9.0), (-9.0, 9.0), (9.0, 9.0)];
    let object = polygon(scene, &corners.map(|(x, y)| DVec3::new(x, y, 4.0)), white);
    let mesh = crate::mesh_of(scene, object);
    let value = |p: &DVec3| PI * Rgb::new(10.0 + p.x, 10.0 + p.y, 20.0 + p.x - p.y);
    mesh.irradiance = mesh.positions.iter().map(value).collect();
}

#[test]
fn a_mirror_shows_the_mirrored_wall() {
    let mut scene = Scene::default();
    wall(&mut scene);
    let from = [DVec3::new(-1.0, 0.5, 2.0), DVec3::new(2.0, -1.0, 3.0)];
    let to = [DVec3::new(0.3, 0.2, 0.0), DVec3::new(-1.0, 0.4, 0.0)];
    let flip = |p: DVec3| DVec3::new(p.x, p.y, -p.z);
    let direct = radiance_along(
        &scene,
        &[(flip(from[0]), to[0]), (flip(from[1]), to[1])],
        &SecondPass::default(),
    );
    let share = Rgb::new(0.9, 0.5, 0.7);
    let mirror = scene.add_material(Material::mirror("mirror", share));
    let corners = [(-3.0, -3.0), (3.0, -3.0), (3.0, 3.0), (-3.0, 3.0)];
    polygon(
        &mut scene,
        &corners.map(|(x, y)| DVec3::new(x, y, 0.0)),
        mirror,
    );
    let mirrored = radiance_along(
        &scene,
        &[(from[0], to[0]), (from[1], to[1])],
        &SecondPass::default(),
    );
    for k in 0..2 {
        assert!(direct[k].r > 1.0, "the wall shines");
        assert_close(mirrored[k], share * direct[k], 1e-4);
    }
}

#[test]
fn a_smooth_mirror_bends_by_its_vertex_normals() {
    let mut scene = Scene::default();
    wall(&mut scene);
    let mirror = scene.add_material(Material::mirror("mirror", Rgb::WHITE));
    let corners = [(-3.0, -3.0), (3.0, -3.0), (3.0, 3.0), (-3.0, 3.0)];
    let object = polygon(
        &mut scene,
        &corners.map(|(x, y)| DVec3::new(x, y, 0.0)),
        mirror,
    );
    let from = DVec3::new(0.0, 0.0, 2.0);
    let straight = radiance_along(&scene, &[(from, DVec3::ZERO)], &SecondPass::default());
    // Tilted by half of the angle whose tangent is 3/4, the mirror shows x = 3 at z = 4.
    let tilted = DVec3::new(1.0, 0.0, 3.0).normalize();
    let mesh = crate::mesh_of(&mut scene, object);
    mesh.normals = Some(Attribute::per_vertex(vec![tilted; 4]));
    let bent = radiance_along(&scene, &[(from, DVec3::ZERO)], &SecondPass::default());
    assert_close(straight[0], Rgb::new(10.0, 10.0, 20.0), 1e-3);
    assert_close(bent[0], Rgb::new(13.0, 10.0, 23.0), 1e-3);
}

#[test]
fn two_facing_mirrors_end_and_keep_their_mean() {
    // Straight between two mirrors of reflectance r that emit 1: 1 + r + r² + ... = 1/(1 − r).
    let mut scene = Scene::default();
    let shiny = scene.add_material(Material {
        emission: Rgb::WHITE,
        ..Material::mirror("shiny", Rgb::new(0.5, 0.8, 0.9))
    });
    for z in [0.0, 1.0] {
        let across = if z == 0.0 { DVec3::X } else { -DVec3::X };
        let corner = DVec3::new(0.0, -0.5, z) - 0.5 * across;
        primitive(
            &mut scene,
            Primitive::parallelogram(corner, across, DVec3::Y, shiny),
        );
    }
    let options = SecondPass {
        samples_per_pixel: 256,
        ..SecondPass::default()
    };
    let found = radiance_along(
        &scene,
        &[(DVec3::new(0.1, 0.1, 0.5), DVec3::new(0.1, 0.1, 1.0))],
        &options,
    );
    // Roulette starts at weight 0.01, so it decides over 0.01/(1 − r) at most.
    assert_close(found[0], Rgb::new(2.0, 5.0, 10.0), 0.02);
}

#[test]
fn a_hall_of_perfect_mirrors_ends() {
    let mut scene = Scene::default();
    let mirror = scene.add_material(Material::mirror("mirror", Rgb::WHITE));
    let map = DAffine3::from_scale(DVec3::splat(2.0));
    primitive(
        &mut scene,
        Primitive::new(PrimitiveKind::Cuboid, map, mirror),
    );
    let found = radiance_along(
        &scene,
        &[(DVec3::ONE, DVec3::new(1.3, 1.2, 2.0))],
        &SecondPass::default(),
    );
    assert_close(found[0], Rgb::BLACK, 0.0);
}

/// Reflectance of one boundary for light at `cos` in air, polarizations apart.
fn fresnel(cos: f64, ior: f64) -> [f64; 2] {
    let cos_t = (1.0 - (1.0 - cos * cos) / (ior * ior)).sqrt();
    [
        (cos - ior * cos_t) / (cos + ior * cos_t),
        (ior * cos - cos_t) / (ior * cos + cos_t),
    ]
    .map(|amplitude| amplitude * amplitude)
}

/// A pane 0 <= z <= 1 before a lamp at z = 2: what passes at an angle of incidence.
fn check_pane(degrees: f64) {
    let mut scene = Scene::default();
    let lamp = scene.add_material(Material::emitter("lamp", Rgb::WHITE));
    let glass = scene.add_material(Material::dielectric("glass", 1.5));
    let corner = DVec3::new(-100.0, -100.0, 2.0);
    let (x, y) = (200.0 * DVec3::X, 200.0 * DVec3::Y);
    primitive(&mut scene, Primitive::parallelogram(corner, y, x, lamp));
    let map = DAffine3::from_scale_rotation_translation(
        DVec3::new(200.0, 200.0, 1.0),
        glam::DQuat::IDENTITY,
        DVec3::new(-100.0, -100.0, 0.0),
    );
    primitive(
        &mut scene,
        Primitive::new(PrimitiveKind::Cuboid, map, glass),
    );
    let (sin, cos) = degrees.to_radians().sin_cos();
    let target = DVec3::new(0.2, 0.1, 0.0);
    let options = SecondPass {
        samples_per_pixel: 4096,
        ..SecondPass::default()
    };
    let found = radiance_along(
        &scene,
        &[(target - DVec3::new(sin, 0.0, cos), target)],
        &options,
    );
    // The renderer carries no polarization: the mean reflectance goes into the series
    // T² (1 + R² + R⁴ + ...) = (1 − R)/(1 + R).
    let r = 0.5 * fresnel(cos, 1.5).iter().sum::<f64>();
    assert_close(found[0], Rgb::grey((1.0 - r) / (1.0 + r)), 2e-3);
}

#[test]
fn a_pane_passes_what_fresnel_says() {
    for degrees in [0.0, 30.0, 60.0, 75.0] {
        check_pane(degrees);
    }
}

#[test]
fn a_right_angle_prism_throws_everything_back() {
    let mut scene = Scene::default();
    let front = scene.add_material(Material::emitter("front", Rgb::new(1.0, 2.0, 0.0)));
    let behind = scene.add_material(Material::emitter("behind", Rgb::new(0.0, 0.0, 9.0)));
    let glass = scene.add_material(Material::dielectric("glass", 1.5));
    let sheet = |z: f64, toward: f64, material| {
        let corner = DVec3::new(-9.0 * toward, -9.0, z);
        Primitive::parallelogram(corner, 18.0 * toward * DVec3::X, 18.0 * DVec3::Y, material)
    };
    primitive(&mut scene, sheet(-5.0, 1.0, front));
    primitive(&mut scene, sheet(5.0, -1.0, behind));
    scene
        .objects
        .push(Object::new("prism", Shape::Mesh(right_angle_prism(glass))));
    // Square on the hypotenuse: 45° at both short sides, beyond the critical angle of 41.8°.
    let at = DVec3::new(0.4, 0.3, 0.0);
    let options = SecondPass {
        samples_per_pixel: 64,
        ..SecondPass::default()
    };
    let found = radiance_along(&scene, &[(at - DVec3::Z, at)], &options);
    // Roulette decides on what is left after the second boundary.
    assert_close(found[0], Rgb::new(1.0, 2.0, 0.0), 1e-2);
}

/// Hypotenuse in z = 0 toward −z, edge of the right angle at z = 1, along y from −1 to 1.
fn right_angle_prism(material: u32) -> Mesh {
    let outline = [(-1.0, 0.0), (0.0, 1.0), (1.0, 0.0)];
    let mut mesh = Mesh::default();
    for y in [-1.0, 1.0] {
        mesh.positions
            .extend(outline.map(|(x, z)| DVec3::new(x, y, z)));
    }
    mesh.push_face(&[0, 2, 1], material);
    mesh.push_face(&[3, 4, 5], material);
    for k in 0..3 {
        let next = (k + 1) % 3;
        mesh.push_face(&[k, next, next + 3, k + 3], material);
    }
    for face in 0..5 {
        let inside = DVec3::new(0.0, 0.0, 0.4);
        let outward = mesh.face_positions(face)[0] - inside;
        assert!(
            mesh.face_area_vector(face).dot(outward) > 0.0,
            "face {face}"
        );
    }
    mesh
}
