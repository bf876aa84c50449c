//! The triangle that a ray meets first.

use crate::gpu::Drawn;
use azulejo::scene::Mesh;
use azulejo::scene::math::Ray;
use glam::DVec3;

/// Where a ray meets what is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index among what is drawn.
    pub object: usize,
    /// Face of its mesh.
    pub face: u32,
    /// Vertices of the triangle that was met.
    pub corners: [u32; 3],
    /// Their weights.
    pub weights: [f64; 3],
    /// World position.
    pub position: DVec3,
    /// Unit normal of the side that was met.
    pub normal: DVec3,
    t: f64,
}

/// The nearest hit of all.
pub fn pick(drawn: &[Drawn], ray: &Ray) -> Option<Hit> {
    let hits = drawn.iter().enumerate().filter_map(|(k, d)| one(k, d, ray));
    hits.min_by(|a, b| a.t.total_cmp(&b.t))
}

fn one(object: usize, drawn: &Drawn, ray: &Ray) -> Option<Hit> {
    let inverse = drawn.world_from_object.inverse();
    let local = Ray::new(
        inverse.transform_point3(ray.origin),
        inverse.transform_vector3(ray.direction),
    );
    let mesh: &Mesh = drawn.mesh;
    let mut best: Option<(f64, u32, [u32; 3], [f64; 3])> = None;
    let mut triangles = Vec::new();
    for face in 0..mesh.faces.len() {
        triangles.clear();
        mesh.triangulate_into(face, &mut triangles);
        for t in &triangles {
            let corners = t.map(|c| mesh.faces.get(face)[c as usize]);
            let p = corners.map(|v| mesh.positions[v as usize]);
            let (e1, e2) = (p[1] - p[0], p[2] - p[0]);
            let q = local.direction.cross(e2);
            let det = e1.dot(q);
            if det == 0.0 {
                continue;
            }
            let s = local.origin - p[0];
            let u = s.dot(q) / det;
            let r = s.cross(e1);
            let v = local.direction.dot(r) / det;
            let d = e2.dot(r) / det;
            if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && d > 0.0 && best.is_none_or(|b| d < b.0) {
                best = Some((d, face as u32, corners, [1.0 - u - v, u, v]));
            }
        }
    }
    let (t, face, corners, weights) = best?;
    let position = ray.at(t);
    let p = corners.map(|v| {
        drawn
            .world_from_object
            .transform_point3(mesh.positions[v as usize])
    });
    let n = (p[1] - p[0]).cross(p[2] - p[0]).normalize_or_zero();
    let normal = if n.dot(ray.direction) > 0.0 { -n } else { n };
    Some(Hit {
        object,
        face,
        corners,
        weights,
        position,
        normal,
        t,
    })
}
