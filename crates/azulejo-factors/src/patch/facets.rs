//! Flat triangles that approximate curved patches, for item buffers.

use super::bent::onto;
use super::{PatchPoint, Patches};
use glam::DVec3;

/// Largest turn of a curved surface's normal along a facet, radians: chords are then shorter than
/// their arcs by 1 / 5000.
const MOST_TURN: f64 = 0.07;

/// Most pieces of a curved patch in either direction.
const MOST_STEPS: u32 = 16;

impl Patches {
    /// Triangles of all patches, each with the number of its patch, counter-clockwise from its
    /// front; curved ones turn by at most 4° along an edge. Some may have no area, at a pole.
    pub fn triangles(&self) -> Vec<(u32, [DVec3; 3])> {
        let facets = PatchFacets::new(self);
        let numbered = |i: usize| facets.of(i).into_iter().map(move |t| (i as u32, t));
        (0..self.len()).flat_map(numbered).collect()
    }
}

/// How finely the curved patches of each object are divided. All of an object are divided alike, so
/// that neighbours share their corners.
pub(crate) struct PatchFacets<'a> {
    patches: &'a Patches,
    /// Pieces of a patch in either direction; 0 for objects whose patches are flat.
    steps: Vec<u32>,
}

impl<'a> PatchFacets<'a> {
    pub fn new(patches: &'a Patches) -> PatchFacets<'a> {
        let objects = 0..patches.object_patches.len().saturating_sub(1) as u32;
        let steps = |object: u32| {
            let turns = patches.patches_of(object).map(|i| patches.turn(i));
            let turn = turns.fold(0.0, f64::max);
            let steps = (turn / MOST_TURN).ceil() as u32;
            steps.min(MOST_STEPS)
        };
        PatchFacets {
            patches,
            steps: objects.map(steps).collect(),
        }
    }

    /// The triangles of a patch, counter-clockwise from its front. Some of a curved patch may have
    /// no area, at a pole.
    pub fn of(&self, i: usize) -> Vec<[DVec3; 3]> {
        if let Some(polygon) = self.patches.polygon(i) {
            let triangle = |k: usize| [polygon[0], polygon[k], polygon[k + 1]];
            return (1..polygon.len() - 1).map(triangle).collect();
        }
        let n = self.steps(i);
        let cells = (0..n * n).map(|cell| (cell % n, cell / n));
        cells.flat_map(|cell| self.halves(i, cell)).collect()
    }

    /// The point of the triangles of patch `i` for `(u1, u2)` in the unit square: as
    /// [`Patches::sample`], but on the triangles, so that they do not occlude the view of their own
    /// patch.
    pub fn sample(&self, i: usize, u1: f64, u2: f64) -> PatchPoint {
        if self.patches.polygon(i).is_some() {
            let point = self.patches.sample(i, u1, u2);
            return PatchPoint {
                position: self.above(i, point.position),
                ..point
            };
        }
        let (s, t, weight) = self.patches.sample_parameters(i, u1, u2);
        let n = self.steps(i);
        let cell = |x: f64| ((x * f64::from(n)) as u32).min(n - 1);
        let (column, row) = (cell(s), cell(t));
        let inside = |x: f64, cell: u32| (x * f64::from(n) - f64::from(cell)).clamp(0.0, 1.0);
        let (x, y) = (inside(s, column), inside(t, row));
        let corner = |x, y| self.corner(i, column + x, row + y);
        let (origin, far) = (corner(0, 0), corner(1, 1));
        // The diagonal from (0, 0) to (1, 1) divides the cell.
        let position = if x >= y {
            let right = corner(1, 0);
            origin + x * (right - origin) + y * (far - right)
        } else {
            let left = corner(0, 1);
            origin + y * (left - origin) + x * (far - left)
        };
        let exact = self.patches.curved_point(i, s, t).normal;
        let [a, b, c] = self.halves(i, (column, row))[usize::from(x < y)];
        let normal = (b - a).cross(c - a).normalize_or(exact);
        PatchPoint {
            position,
            normal,
            weight,
        }
    }

    /// A position of flat patch `i`, moved along its normal onto its triangles. Where a face is not exactly
    /// flat they are not those that the tracer sees.
    pub fn above(&self, i: usize, position: DVec3) -> DVec3 {
        let is_bent = self.patches.bent.contains_key(&self.patches.owner[i]);
        if is_bent {
            onto(&self.of(i), self.patches.normal(i), position)
        } else {
            position
        }
    }

    fn steps(&self, i: usize) -> u32 {
        let object = self.patches.face(i).object as usize;
        self.steps.get(object).map_or(1, |&n| n.max(1))
    }

    fn corner(&self, i: usize, column: u32, row: u32) -> DVec3 {
        let n = f64::from(self.steps(i));
        let (s, t) = (f64::from(column) / n, f64::from(row) / n);
        self.patches.curved_point(i, s, t).position
    }

    /// The two triangles of a cell: on the side of (1, 0), and on that of (0, 1).
    fn halves(&self, i: usize, (column, row): (u32, u32)) -> [[DVec3; 3]; 2] {
        let corner = |x, y| self.corner(i, column + x, row + y);
        let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
        let n = f64::from(self.steps(i));
        let middle = |k: u32| (f64::from(k) + 0.5) / n;
        let point = self.patches.curved_point(i, middle(column), middle(row));
        // The parameters of some parts are clockwise.
        if (c - a).cross(d - b).dot(point.normal) < 0.0 {
            [[a, c, b], [a, d, c]]
        } else {
            [[a, b, c], [a, c, d]]
        }
    }
}

impl Patches {
    /// How far the normal of a curved patch turns along its parameters, radians; 0 if it is flat.
    fn turn(&self, i: usize) -> f64 {
        if self.polygon(i).is_some() {
            return 0.0;
        }
        let ends = [0.0, 0.5, 1.0];
        let normal = |s, t| self.curved_point(i, s, t).normal;
        let along = |f: &dyn Fn(f64) -> DVec3| {
            let [a, b, c] = ends.map(f);
            a.angle_between(b) + b.angle_between(c)
        };
        let rows = ends.map(|t| along(&|s| normal(s, t)));
        let columns = ends.map(|s| along(&|t| normal(s, t)));
        rows.into_iter().chain(columns).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PatchSize;
    use azulejo_scene::math::area_vector;
    use azulejo_scene::{Material, Object, Primitive, Rgb, Scene, Shape};

    fn sphere() -> Patches {
        let mut scene = Scene::default();
        let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
        let sphere = Primitive::sphere(DVec3::ZERO, 2.0, grey);
        let shape = Shape::Primitive(sphere);
        scene.objects.push(Object::new("sphere", shape));
        Patches::new(&scene, PatchSize::Count(100))
    }

    #[test]
    fn facets_of_a_sphere_are_nearly_its_area_and_face_outwards() {
        let patches = sphere();
        let facets = PatchFacets::new(&patches);
        let mut area = 0.0;
        for i in 0..patches.len() {
            for triangle in facets.of(i) {
                let vector = area_vector(&triangle);
                area += vector.length();
                assert!(vector.dot(triangle[0]) >= 0.0);
                assert!(triangle.iter().all(|p| (p.length() - 2.0).abs() < 1e-12));
            }
        }
        let truth: f64 = (0..patches.len()).map(|i| patches.area(i)).sum();
        assert!(area < truth && area > 0.999 * truth, "{area} of {truth}");
    }

    #[test]
    fn samples_lie_on_facets() {
        let patches = sphere();
        let facets = PatchFacets::new(&patches);
        for i in 0..patches.len() {
            let triangles = facets.of(i);
            for k in 0..25 {
                let (u1, u2) = (0.04 + 0.2 * f64::from(k % 5), 0.07 + 0.2 * f64::from(k / 5));
                let at = facets.sample(i, u1, u2);
                let is_on = |[a, b, c]: &[DVec3; 3]| {
                    let normal = (b - a).cross(c - a).normalize_or_zero();
                    let is_beside = (at.position - *a).dot(normal).abs() < 1e-12;
                    is_beside && normal.dot(at.normal) > 1.0 - 1e-12
                };
                assert!(triangles.iter().any(is_on), "{i} {k}");
                let exact = patches.sample(i, u1, u2);
                assert_eq!(exact.weight, at.weight);
                assert!(exact.position.distance(at.position) < 4e-3);
            }
        }
    }
}
