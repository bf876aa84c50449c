//! A room with everything that the second pass renders: coloured walls, a lamp, a matt cylinder, a
//! mirror and a glass ball. Its irradiance comes from a formula, so it needs no first pass.

use azulejo_scene::{
    Camera, Material, Mesh, Object, Primitive, PrimitiveKind, Rgb, Scene, Shape, SurfaceLight,
};
use glam::{DAffine3, DQuat, DVec3};

/// The lamp's middle, its area and its radiance.
const LAMP: (DVec3, f64, Rgb) = (DVec3::new(0.5, 0.998, 0.5), 0.09, Rgb::new(17.0, 12.0, 5.0));

/// The gallery, its sides divided `n` × `n`, and a camera that sees it all.
pub fn gallery(n: u32) -> (Scene, Camera) {
    let mut scene = Scene::default();
    let white = scene.add_material(Material::diffuse("white", Rgb::new(0.73, 0.71, 0.68)));
    let red = scene.add_material(Material::diffuse("red", Rgb::new(0.63, 0.07, 0.05)));
    let green = scene.add_material(Material::diffuse("green", Rgb::new(0.14, 0.45, 0.09)));
    let lamp = scene.add_material(Material::emitter("lamp", LAMP.2));
    let mirror = scene.add_material(Material::mirror("mirror", Rgb::grey(0.9)));
    let glass = scene.add_material(Material::dielectric("glass", 1.5));
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    sheet(&mut scene, n, DVec3::ZERO, z, x, white);
    sheet(&mut scene, n, y, x, z, white);
    sheet(&mut scene, n, DVec3::ZERO, x, y, white);
    sheet(&mut scene, n, DVec3::ZERO, y, z, red);
    sheet(&mut scene, n, x, z, y, green);
    sheet(
        &mut scene,
        2,
        DVec3::new(0.35, 0.998, 0.35),
        0.3 * x,
        0.3 * z,
        lamp,
    );
    let turned = DVec3::new(0.3, 0.0, 0.18);
    sheet(
        &mut scene,
        1,
        DVec3::new(0.12, 0.05, 0.45),
        turned * DVec3::new(1.0, 0.0, -1.0),
        0.6 * y,
        mirror,
    );
    let ball = Primitive::sphere(DVec3::new(0.72, 0.2, 0.66), 0.18, glass);
    scene
        .objects
        .push(Object::new("ball", Shape::Primitive(ball)));
    let map = DAffine3::from_scale_rotation_translation(
        DVec3::new(0.11, 0.11, 0.3),
        DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2),
        DVec3::new(0.32, 0.0, 0.68),
    );
    scene
        .objects
        .push(Object::new("drum", Shape::Primitive(drum(map, white))));
    (scene, eye())
}

/// Looks into the room through its open front.
fn eye() -> Camera {
    Camera {
        name: "front".into(),
        eye: DVec3::new(0.5, 0.5, 2.4),
        target: DVec3::splat(0.5),
        up: DVec3::Y,
        vertical_fov: 0.69,
        size: None,
    }
}

/// A parallelogram of `n` × `n` faces, front toward `across × along`, with irradiance.
fn sheet(scene: &mut Scene, n: u32, corner: DVec3, across: DVec3, along: DVec3, material: u32) {
    let mut mesh = Mesh::default();
    let share = |k: u32| f64::from(k) / f64::from(n);
    for k in 0..(n + 1) * (n + 1) {
        let (i, j) = (k % (n + 1), k / (n + 1));
        mesh.positions
            .push(corner + share(i) * across + share(j) * along);
    }
    for k in 0..n * n {
        let a = k / n * (n + 1) + k % n;
        mesh.push_face(&[a, a + 1, a + n + 2, a + n + 1], material);
    }
    let normal = across.cross(along).normalize();
    mesh.irradiance = mesh
        .positions
        .iter()
        .map(|&p| irradiance(p, normal))
        .collect();
    scene.objects.push(Object::new("sheet", Shape::Mesh(mesh)));
}

/// A cylinder with irradiance.
fn drum(map: DAffine3, material: u32) -> Primitive {
    let mut drum = Primitive::new(PrimitiveKind::Cylinder, map, material);
    let grids = drum.grids(1e-3, 0.1);
    let mesh = drum.tessellate(&grids);
    let normals = mesh.normals.expect("tessellations have normals").values;
    let at = mesh.positions.iter().zip(normals);
    drum.light = Some(Box::new(SurfaceLight {
        grids,
        irradiance: at.map(|(&p, n)| irradiance(p, n)).collect(),
        error: Vec::new(),
    }));
    drum
}

/// The lamp as a point that shines downward, without shadows, over a constant for the rest.
fn irradiance(p: DVec3, normal: DVec3) -> Rgb {
    let (middle, area, radiance) = LAMP;
    let to_lamp = middle - p;
    let r2 = to_lamp.length_squared().max(0.02);
    let cosines = to_lamp.dot(normal).max(0.0) * to_lamp.y.max(0.0) / r2;
    radiance * (cosines * area / r2) + Rgb::new(0.9, 0.7, 0.5)
}
