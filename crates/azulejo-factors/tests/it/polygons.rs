//! Scenes of single polygons.

use azulejo_factors::{FaceId, FormFactors};
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

pub fn unit_square(z: f64) -> Vec<DVec3> {
    [(0., 0.), (1., 0.), (1., 1.), (0., 1.)]
        .map(|(x, y)| dvec3(x, y, z))
        .to_vec()
}

/// The one polygon of an object.
pub fn polygon(scene: &Scene, object: u32) -> Vec<DVec3> {
    match &scene.objects[object as usize].shape {
        Shape::Mesh(mesh) => mesh.face_positions(0),
        _ => panic!("object {object} is not a mesh"),
    }
}

/// Form factor from object 0 to object 1, over all their patches, with its standard error.
pub fn between(matrix: &FormFactors) -> (f64, f64) {
    let rows_of = |object: u32| {
        (0..matrix.len()).filter(move |&i| matrix.faces[i] == FaceId { object, face: 0 })
    };
    let (mut sum, mut variance) = (0.0, 0.0);
    for i in rows_of(0) {
        for j in rows_of(1) {
            let (value, error) = matrix.get(i, j as u32);
            sum += matrix.areas[i] * value;
            variance += (matrix.areas[i] * f64::from(error)).powi(2);
        }
    }
    let area: f64 = rows_of(0).map(|i| matrix.areas[i]).sum();
    (sum / area, variance.sqrt() / area)
}
