//! Picking with a ray or a rectangle, on the CPU in `f64`.
//!
//! All triangles are tested: no acceleration structure has to be updated after every edit.

use super::frame::DrawnMesh;
use crate::projection::Projection;
use azulejo::scene::Mesh;
use azulejo::scene::math::{Aabb, Ray};
use glam::{DAffine3, DVec2, DVec3};
use rayon::prelude::*;

/// Number of faces per parallel task.
const BLOCK: usize = 1 << 14;

/// The nearest intersection of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PickHit {
    /// Index of the object among those that were given.
    pub object: usize,
    /// Index of the face in its mesh.
    pub face: usize,
    /// Ray parameter, in units of the length of the ray's direction.
    pub distance: f64,
    /// Position in world space.
    pub position: DVec3,
    /// Vertices of the triangle of the face that was hit.
    pub vertices: [u32; 3],
    /// Barycentric coordinates for these vertices.
    pub barycentric: DVec3,
    /// Whether the front side was hit.
    pub is_front: bool,
}

/// What of a model is not shown, so that one sees into it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cutaway {
    /// Whether back faces are culled, which shows the inside of rooms from outside.
    pub hides_backs: bool,
    /// A plane, n · x = d: what lies beyond it, n · x > d, is cut away.
    pub section: Option<(DVec3, f64)>,
}

impl Cutaway {
    /// The nearest intersection with a face that is shown.
    pub fn pick(&self, objects: &[DrawnMesh], ray: &Ray) -> Option<PickHit> {
        let Some((normal, offset)) = self.section else {
            return pick(objects, ray, self.hides_backs);
        };
        // The part that is shown is convex: a ray enters it and leaves it once.
        let (height, slope) = (normal.dot(ray.origin) - offset, normal.dot(ray.direction));
        let start = if height <= 0.0 {
            0.0
        } else if slope < 0.0 {
            -height / slope
        } else {
            return None;
        };
        let inner = Ray {
            origin: ray.at(start),
            ..*ray
        };
        let hit = pick(objects, &inner, self.hides_backs)?;
        let slack = 1e-9 * (1.0 + offset.abs());
        let is_shown = normal.dot(hit.position) <= offset + slack;
        is_shown.then_some(PickHit {
            distance: start + hit.distance,
            ..hit
        })
    }
}

/// The nearest intersection with a face, or `None`. With `hides_backs`, back faces are ignored.
pub fn pick(objects: &[DrawnMesh], ray: &Ray, hides_backs: bool) -> Option<PickHit> {
    let mut nearest: Option<PickHit> = None;
    for (object, drawn) in objects.iter().enumerate() {
        let mut own = *ray;
        own.t_max = nearest.map_or(ray.t_max, |n| n.distance);
        if let Some(pick) = pick_in(drawn, &own, hides_backs) {
            nearest = Some(PickHit { object, ..pick });
        }
    }
    nearest
}

fn pick_in(drawn: &DrawnMesh, ray: &Ray, hides_backs: bool) -> Option<PickHit> {
    let place = drawn.world_from_object;
    let from_world = place.inverse();
    if !from_world.is_finite() {
        return None;
    }
    // Ray parameters are the same in both spaces.
    let local = Ray {
        origin: from_world.transform_point3(ray.origin),
        direction: from_world.transform_vector3(ray.direction),
        ..*ray
    };
    if drawn.bounds.is_some_and(|bounds| !hits_box(bounds, &local)) {
        return None;
    }
    let mesh = drawn.mesh;
    let blocks = mesh.faces.len().div_ceil(BLOCK);
    let nearest = (0..blocks).into_par_iter().filter_map(|block| {
        let faces = block * BLOCK..mesh.faces.len().min((block + 1) * BLOCK);
        pick_among(mesh, faces, &local, hides_backs)
    });
    // Ties are broken by the face index, so that the result does not depend on the threads.
    let nearest = nearest.min_by(|a, b| {
        let by_distance = a.distance.total_cmp(&b.distance);
        by_distance.then(a.face.cmp(&b.face))
    })?;
    let position = place.transform_point3(local.at(nearest.distance));
    Some(PickHit {
        position,
        ..nearest
    })
}

fn pick_among(
    mesh: &Mesh,
    faces: std::ops::Range<usize>,
    ray: &Ray,
    hides_backs: bool,
) -> Option<PickHit> {
    let mut ray = *ray;
    let mut nearest = None;
    let mut triangles = Vec::new();
    for face in faces {
        let vertices = mesh.faces.get(face);
        triangles.clear();
        match vertices.len() {
            3 => triangles.push([0, 1, 2]),
            _ if !hits_box(around(mesh, vertices), &ray) => continue,
            _ => mesh.triangulate_into(face, &mut triangles),
        }
        for triangle in &triangles {
            let vertices = triangle.map(|k| vertices[k as usize]);
            let corners = vertices.map(|v| mesh.positions[v as usize]);
            let Some((distance, barycentric, is_front)) = intersect(&corners, &ray) else {
                continue;
            };
            if is_front || !hides_backs {
                ray.t_max = distance;
                nearest = Some(PickHit {
                    object: 0,
                    face,
                    distance,
                    position: DVec3::ZERO,
                    vertices,
                    barycentric,
                    is_front,
                });
            }
        }
    }
    nearest
}

fn around(mesh: &Mesh, vertices: &[u32]) -> Aabb {
    Aabb::around(vertices.iter().map(|&v| mesh.positions[v as usize]))
}

/// Whether a ray hits a slightly enlarged box.
fn hits_box(bounds: Aabb, ray: &Ray) -> bool {
    let margin = 1e-9 * bounds.diagonal();
    let (mut from, mut to) = (ray.t_min, ray.t_max);
    for axis in 0..3 {
        let inverse = 1.0 / ray.direction[axis];
        let a = (bounds.min[axis] - margin - ray.origin[axis]) * inverse;
        let b = (bounds.max[axis] + margin - ray.origin[axis]) * inverse;
        // A ray within a plane of the box yields NaN, which `max` and `min` ignore.
        from = from.max(a.min(b));
        to = to.min(a.max(b));
    }
    from <= to
}

/// Ray parameter, barycentric coordinates and whether the front was hit: Möller and Trumbore,
/// *Fast, Minimum Storage Ray/Triangle Intersection*, JGT 2(1), 1997.
fn intersect([a, b, c]: &[DVec3; 3], ray: &Ray) -> Option<(f64, DVec3, bool)> {
    let (ab, ac) = (*b - *a, *c - *a);
    let p = ray.direction.cross(ac);
    let determinant = ab.dot(p);
    let from_a = ray.origin - *a;
    let u = from_a.dot(p) / determinant;
    // Written so that a degenerate triangle, which yields NaN, is not hit.
    if !(0.0..=1.0).contains(&u) {
        return None;
    }
    let q = from_a.cross(ab);
    let v = ray.direction.dot(q) / determinant;
    if !(v >= 0.0 && u + v <= 1.0) {
        return None;
    }
    let t = ac.dot(q) / determinant;
    let is_within = ray.t_min <= t && t < ray.t_max;
    is_within.then_some((t, DVec3::new(1.0 - u - v, u, v), determinant > 0.0))
}

/// The objects with a vertex inside a rectangle of the image (pixels from the upper left corner),
/// whether occluded or not.
pub fn pick_rectangle(
    objects: &[DrawnMesh],
    view: &Projection,
    corner: DVec2,
    opposite: DVec2,
) -> Vec<usize> {
    let (low, high) = (corner.min(opposite), corner.max(opposite));
    let is_inside = |place: &DAffine3, p: DVec3| {
        let pixel = view.project(place.transform_point3(p));
        pixel.is_some_and(|q| q.cmpge(low).all() && q.cmple(high).all())
    };
    let is_touched = |drawn: &DrawnMesh| {
        let mesh = drawn.mesh;
        let corners = mesh.faces.corners.par_iter();
        corners.any(|&v| is_inside(&drawn.world_from_object, mesh.positions[v as usize]))
    };
    let objects = objects.iter().enumerate();
    objects
        .filter(|(_, d)| is_touched(d))
        .map(|(k, _)| k)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo::scene::{Camera, Primitive};

    fn ball(centre: DVec3) -> Mesh {
        let ball = Primitive::sphere(centre, 1.0, 0);
        ball.tessellate(&ball.grids(1e-3, f64::INFINITY))
    }

    #[test]
    fn the_nearest_of_all_is_picked() {
        let (near, far) = (ball(DVec3::Z), ball(-3.0 * DVec3::Z));
        let objects = [DrawnMesh::new(1, &far), DrawnMesh::new(2, &near)];
        let ray = Ray::new(DVec3::new(0.1, 0.2, 9.0), -2.0 * DVec3::Z);
        let hit = pick(&objects, &ray, false).expect("a ball");
        assert!(hit.object == 1 && hit.is_front);
        assert!((hit.position - ray.at(hit.distance)).length() < 1e-12);
        let corners = hit.vertices.map(|v| near.positions[v as usize]);
        let weights = hit.barycentric.to_array();
        let again: DVec3 = corners.iter().zip(weights).map(|(&c, w)| w * c).sum();
        assert!((again - hit.position).length() < 1e-12);
        assert_eq!(pick(&objects, &Ray::new(ray.origin, DVec3::Z), false), None);
    }

    #[test]
    fn boxes_keep_no_ray_from_what_it_meets() {
        let mesh = ball(DVec3::ZERO);
        let mut flat = Mesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            ..Mesh::default()
        };
        flat.push_face(&[0, 1, 2], 0);
        for mesh in [mesh, flat, Mesh::default()] {
            let mut drawn = DrawnMesh::new(1, &mesh);
            drawn.world_from_object = DAffine3::from_rotation_translation(
                glam::DQuat::from_rotation_z(0.4),
                DVec3::new(5.0, 1.0, -2.0),
            );
            let boxed = DrawnMesh {
                bounds: Some(mesh.bounds()),
                ..drawn
            };
            for k in 0..400 {
                let (x, y) = (f64::from(k % 20), f64::from(k / 20));
                let eye = DVec3::new(4.0 + 0.1 * x, 0.1 * y, 9.0);
                let ray = Ray::new(eye, -DVec3::Z);
                assert_eq!(pick(&[boxed], &ray, false), pick(&[drawn], &ray, false));
            }
        }
    }

    #[test]
    fn places_far_away_and_mirrored_count() {
        let mesh = ball(DVec3::ZERO);
        let offset = DVec3::new(3e6, -2e6, 1e6);
        let mut drawn = DrawnMesh::new(1, &mesh);
        drawn.world_from_object = DAffine3::from_scale_rotation_translation(
            DVec3::new(-2.0, 2.0, 2.0),
            glam::DQuat::from_rotation_x(0.3),
            offset,
        );
        let ray = Ray::new(offset + 10.0 * DVec3::X, -DVec3::X);
        let hit = pick(&[drawn], &ray, true).expect("the ball");
        assert!((hit.distance - 8.0).abs() < 1e-2, "{hit:?}");
        drawn.world_from_object.matrix3 = glam::DMat3::ZERO;
        assert_eq!(pick(&[drawn], &ray, false), None);
    }

    #[test]
    fn backs_can_be_passed() {
        let mesh = ball(DVec3::ZERO);
        let drawn = [DrawnMesh::new(1, &mesh)];
        let from_inside = Ray::new(DVec3::ZERO, DVec3::new(0.3, 0.2, 1.0));
        let back = pick(&drawn, &from_inside, false).expect("the back");
        assert!(!back.is_front);
        assert_eq!(pick(&drawn, &from_inside, true), None);
    }

    #[test]
    fn polygons_are_met_where_they_are() {
        // An L shape: its notch is not hit.
        let mut mesh = Mesh::default();
        let outline = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)];
        mesh.positions = outline
            .map(|(x, y)| DVec3::new(f64::from(x), f64::from(y), 0.0))
            .to_vec();
        mesh.push_face(&[0, 1, 2, 3, 4, 5], 0);
        let drawn = [DrawnMesh::new(1, &mesh)];
        let met = |x, y| {
            let ray = Ray::new(DVec3::new(x, y, 5.0), -DVec3::Z);
            pick(&drawn, &ray, false).is_some()
        };
        assert!(met(0.5, 1.5) && met(1.5, 0.5) && !met(1.5, 1.5) && !met(-0.1, 0.5));
    }

    #[test]
    fn a_rectangle_takes_what_it_touches() {
        let (left, right) = (ball(-2.0 * DVec3::X), ball(2.0 * DVec3::X));
        let objects = [DrawnMesh::new(1, &left), DrawnMesh::new(2, &right)];
        let camera = Camera {
            name: String::new(),
            eye: 10.0 * DVec3::Z,
            target: DVec3::ZERO,
            up: DVec3::Y,
            vertical_fov: 1.0,
            size: None,
        };
        let view = Projection::new(&camera, [200, 200]);
        let check = |a: (f64, f64), b: (f64, f64), expected: &[usize]| {
            assert_eq!(
                pick_rectangle(&objects, &view, a.into(), b.into()),
                expected
            );
        };
        check((0.0, 0.0), (200.0, 200.0), &[0, 1]);
        check((110.0, 200.0), (200.0, 0.0), &[1]);
        check((0.0, 0.0), (10.0, 10.0), &[]);
    }
}
