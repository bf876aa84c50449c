//! An array of cubes on a plane.

use super::add_grid;
use crate::{Material, Mesh, Object, Rgb, Scene, Shape, Units, Up};
use glam::DVec3;

/// `count` × `count` cubes of side 1 in a square array of pitch 2 on a plane (z up), open to the sky: a
/// quarter of the ground is built on. Each side of a cube, and each unit of ground, has
/// `detail` × `detail` quadrilaterals.
///
/// The arrangement of O. Coceal et al., "Mean flow and turbulence statistics over groups of urban-like
/// cubical obstacles", Boundary-Layer Meteorology 121, 2006, which large-eddy simulations of cities have
/// as their example. Cubes are objects `cube0`… with faces named by material: `roof`, `wall`.
pub fn cube_array(count: u32, detail: u32) -> Scene {
    let (count, detail) = (count.max(1), detail.max(1));
    let mut scene = Scene {
        units: Units {
            up: Up::Z,
            ..Units::default()
        },
        ..Scene::default()
    };
    let grey = |name, rho| Material::diffuse(name, Rgb::grey(rho));
    let ground = scene.add_material(grey("ground", 0.2));
    let roof = scene.add_material(grey("roof", 0.3));
    let wall = scene.add_material(grey("wall", 0.5));
    let step = 1.0 / f64::from(detail);
    let mut plane = Mesh::default();
    for (x, y) in cells(2 * count) {
        // Ground below cubes sees nothing.
        if x % 2 == 0 || y % 2 == 0 {
            let corner = DVec3::new(f64::from(x), f64::from(y), 0.0);
            let place = |i, j| corner + step * DVec3::new(f64::from(i), f64::from(j), 0.0);
            add_grid(&mut plane, detail, detail, ground, place);
        }
    }
    scene
        .objects
        .push(Object::new("ground", Shape::Mesh(plane)));
    for (k, (x, y)) in cells(count).enumerate() {
        let corner = DVec3::new(2.0 * f64::from(x) + 1.0, 2.0 * f64::from(y) + 1.0, 0.0);
        let mut mesh = Mesh::default();
        for (material, start, u, v) in [
            (roof, DVec3::Z, DVec3::X, DVec3::Y),
            (wall, DVec3::ZERO, DVec3::X, DVec3::Z),
            (wall, DVec3::X, DVec3::Y, DVec3::Z),
            (wall, DVec3::new(1.0, 1.0, 0.0), -DVec3::X, DVec3::Z),
            (wall, DVec3::Y, -DVec3::Y, DVec3::Z),
        ] {
            let place = |i, j| corner + start + step * (f64::from(i) * u + f64::from(j) * v);
            add_grid(&mut mesh, detail, detail, material, place);
        }
        scene
            .objects
            .push(Object::new(format!("cube{k}"), Shape::Mesh(mesh)));
    }
    scene
}

/// All cells of a square, row by row.
fn cells(count: u32) -> impl Iterator<Item = (u32, u32)> {
    (0..count).flat_map(move |y| (0..count).map(move |x| (x, y)))
}
