//! Scenes for those rows of the reference table that are made of polygons.

use crate::table::{Mirror, Row};
use azulejo_radiosity::{FaceId, FormFactors};
use azulejo_scene::math::Frame;
use azulejo_scene::{Material, Mesh, Object, Rgb, Scene, Shape};
use glam::{DVec3, dvec3};

/// A grey or mirroring polygon.
pub fn add(scene: &mut Scene, polygon: &[DVec3], rho_s: f64) {
    let material = Material {
        diffuse: Rgb::grey(0.5 * (1.0 - rho_s)),
        mirror: Rgb::grey(rho_s),
        ..Material::default()
    };
    let material = scene.add_material(material);
    let mut mesh = Mesh {
        positions: polygon.to_vec(),
        ..Mesh::default()
    };
    mesh.push_face(&(0..polygon.len() as u32).collect::<Vec<_>>(), material);
    scene.objects.push(Object::new("", Shape::Mesh(mesh)));
}

/// A row whose mirrors, told of in words, are polygons too; others as they are.
pub fn in_polygons(row: &Row) -> Row {
    let mut row = row.clone();
    if let Some(walls) = mirror_walls(&row.id) {
        row.p1 = unit_square(0.0);
        row.p2 = unit_square(1.0).into_iter().rev().collect();
        row.mirrors = walls;
    }
    row
}

/// The scene of a row: object 0 sends, object 1 receives. `None` for rows of another kind.
pub fn scene(row: &Row) -> Option<Scene> {
    let mut row = in_polygons(row);
    if let Some((position, normal)) = row.point_normal {
        row.p1 = element(position, normal);
    }
    if row.p1.is_empty() || row.p2.is_empty() {
        return None;
    }
    let mut scene = Scene::default();
    add(&mut scene, &row.p1, 0.0);
    add(&mut scene, &row.p2, 0.0);
    row.occluders.iter().for_each(|o| add(&mut scene, o, 0.0));
    row.mirrors
        .iter()
        .for_each(|m| add(&mut scene, &m.polygon, m.rho_s));
    Some(scene)
}

/// The mirrors of rows that tell of them in words: walls x = 0, or x = 0 and x = 1, of a unit
/// cube.
fn mirror_walls(id: &str) -> Option<Vec<Mirror>> {
    let wall = |x: f64, rho_s: f64| {
        let polygon = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(y, z)| dvec3(x, y, z));
        Mirror {
            rho_s,
            polygon: polygon.to_vec(),
        }
    };
    match id.strip_prefix("corridor_") {
        Some(rho_s) => {
            let rho_s = rho_s.parse().expect("a reflectance");
            Some(vec![wall(0.0, rho_s), wall(1.0, rho_s)])
        }
        None => (id == "cube_mirror_F").then(|| vec![wall(0.0, 0.9)]),
    }
}

pub fn unit_square(z: f64) -> Vec<DVec3> {
    [(0., 0.), (1., 0.), (1., 1.), (0., 1.)]
        .map(|(x, y)| dvec3(x, y, z))
        .to_vec()
}

/// A surface element as a square so small that its form factor differs by less than 1e-6.
fn element(position: DVec3, normal: DVec3) -> Vec<DVec3> {
    let frame = Frame::from_normal(normal);
    let corner = |(x, y): (f64, f64)| position + frame.to_world(5e-4 * dvec3(x, y, 0.0));
    [(-1., -1.), (1., -1.), (1., 1.), (-1., 1.)]
        .map(corner)
        .to_vec()
}

/// Form factor from object 0 to object 1, over all their patches, with its standard error.
pub fn between(found: &FormFactors) -> (f64, f64) {
    let rows_of = |object: u32| {
        (0..found.len()).filter(move |&i| found.faces[i] == FaceId { object, face: 0 })
    };
    let (mut sum, mut variance) = (0.0, 0.0);
    for i in rows_of(0) {
        for j in rows_of(1) {
            let (value, error) = found.get(i, j as u32);
            sum += found.areas[i] * value;
            variance += (found.areas[i] * f64::from(error)).powi(2);
        }
    }
    let area: f64 = rows_of(0).map(|i| found.areas[i]).sum();
    (sum / area, variance.sqrt() / area)
}
