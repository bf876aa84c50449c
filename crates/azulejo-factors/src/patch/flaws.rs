//! What in a model makes form factors wrong without a trace in their sums: faces that overlap in one plane, whose
//! light counts twice, and faces without area, which have no row.

use super::box_pairs::{for_each_pair, grown};
use super::{FaceId, Patches};
use azulejo_scene::Scene;
use azulejo_scene::math::{Aabb, area_vector};
use azulejo_trace::lambert::{ArrayPolygon, clip};
use glam::DVec3;

/// Largest difference of the normals of one plane, as 1 − cosine: 0.003°.
const TURN: f64 = 1e-9;
/// Largest distance of one plane from another that counts as the same, over the size of the faces.
const DEPTH: f64 = 1e-6;
/// Share of the smaller of two faces from which they overlap.
const OVERLAP: f64 = 1e-3;
/// Faces or pairs of faces that a sentence names.
const NAMED: usize = 3;

impl Patches {
    /// Pairs of faces that lie in one plane, face the same way and share more than a thousandth of the smaller
    /// patch, in order. Light that arrives there counts for both. Curved faces are not compared.
    pub fn overlapping_faces(&self) -> Vec<[FaceId; 2]> {
        self.faces_of(&self.coinciding(1.0))
    }

    /// The same of faces that are back to back.
    pub fn faces_back_to_back(&self) -> Vec<[FaceId; 2]> {
        self.faces_of(&self.coinciding(-1.0))
    }

    /// Patches whose backs are covered by fronts of others, as those of a wall that is two faces, one for each of
    /// its rooms.
    pub fn covered_backs(&self) -> Vec<usize> {
        let mut covered = vec![0.0; self.len()];
        for ([i, j], common) in self.coinciding(-1.0) {
            covered[i] += common;
            covered[j] += common;
        }
        let is_covered = |&i: &usize| covered[i] > (1.0 - OVERLAP) * self.area(i);
        (0..self.len()).filter(is_covered).collect()
    }

    fn faces_of(&self, pairs: &[([usize; 2], f64)]) -> Vec<[FaceId; 2]> {
        let faces = pairs.iter().map(|(pair, _)| pair.map(|i| self.face(i)));
        let mut pairs: Vec<_> = faces.filter(|[a, b]| a != b).collect();
        pairs.iter_mut().for_each(|pair| pair.sort_unstable());
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// Pairs of patches of different faces that lie in one plane and face the same way (`turn` 1) or opposite ways
    /// (−1), with the area that they share.
    fn coinciding(&self, turn: f64) -> Vec<([usize; 2], f64)> {
        let polygons: Vec<_> = (0..self.len()).map(|i| self.polygon(i)).collect();
        let bounds = |corners: &[DVec3]| {
            let bounds = Aabb::around(corners.iter().copied());
            grown(bounds, DEPTH * bounds.size().max_element())
        };
        // Curved patches keep an empty box, which meets no other.
        let boxes = polygons
            .iter()
            .map(|p| p.as_deref().map_or(Aabb::EMPTY, bounds));
        for_each_pair(&boxes.collect::<Vec<_>>(), |pair, pairs| {
            let [i, j] = pair.map(|k| k as usize);
            if let (Some(a), Some(b)) = (&polygons[i], &polygons[j])
                && self.face(i) != self.face(j)
                && 1.0 - turn * self.normal(i).dot(self.normal(j)) < TURN
                && let Some(common) = overlap(a, b, self.normal(i))
            {
                pairs.push(([i, j], common));
            }
        })
    }

    /// Faces whose patches have no area, so that they are not rows.
    pub fn faces_without_area(&self) -> Vec<FaceId> {
        let objects = self.face_base.windows(2).zip(0..);
        let faces = objects.flat_map(|(range, object)| {
            (0..range[1] - range[0]).map(move |face| FaceId { object, face })
        });
        let has_area = |i: usize| self.area(i) > 0.0;
        faces
            .filter(|&face| !self.patches_of_face(face).any(has_area))
            .collect()
    }

    /// Overlapping faces and faces without area, in sentences that name them; none if there are none. Faces that are
    /// back to back overlap where backs are `two_sided` rows.
    pub fn flaws(&self, scene: &Scene, two_sided: bool) -> Vec<String> {
        let name = |face: &FaceId| match scene.objects.get(face.object as usize) {
            Some(object) => format!("face {} of \"{}\"", face.face, object.name),
            None => format!("face {}", face.face),
        };
        let listed = |names: Vec<String>| {
            let more = match names.len().saturating_sub(NAMED) {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            names[..names.len().min(NAMED)].join(", ") + &more
        };
        let mut flaws = Vec::new();
        let overlapping = self.overlapping_faces();
        if !overlapping.is_empty() {
            let pairs = overlapping.iter();
            let pairs = pairs.map(|[a, b]| format!("{} on {}", name(b), name(a)));
            flaws.push(format!(
                "faces lie in one plane and overlap, and light that meets them counts for both: {}; remove one, or \
                 cut it out of the other",
                listed(pairs.collect())
            ));
        }
        let pairs = if two_sided {
            self.faces_back_to_back()
        } else {
            Vec::new()
        };
        if !pairs.is_empty() {
            let pairs = pairs.iter();
            let pairs = pairs.map(|[a, b]| format!("{} and {}", name(a), name(b)));
            flaws.push(format!(
                "faces lie back to back in one plane, so that the back of each faces as the front of the other: {}; \
                 a back that fronts cover has no light",
                listed(pairs.collect())
            ));
        }
        let empty = self.faces_without_area();
        if !empty.is_empty() {
            flaws.push(format!(
                "faces without area have no row: {}",
                listed(empty.iter().map(name).collect())
            ));
        }
        flaws
    }
}

/// The area that two convex polygons which are parallel to each other share in one plane; `None` for next to nothing.
fn overlap(a: &[DVec3], b: &[DVec3], normal: DVec3) -> Option<f64> {
    let size = |p: &[DVec3]| area_vector(p).length();
    let least = size(a).min(size(b));
    let depth = normal.dot(b[0] - a[0]).abs();
    if depth > DEPTH * size(a).max(size(b)).sqrt() {
        return None;
    }
    let mut common: ArrayPolygon = b.iter().copied().collect();
    for (k, &start) in a.iter().enumerate() {
        let end = a[(k + 1) % a.len()];
        common = clip(&common, start, normal.cross(end - start));
    }
    let shared = size(&common);
    (shared > OVERLAP * least).then_some(shared)
}

#[cfg(test)]
mod tests {
    use crate::patch::{PatchSize, Patches};
    use azulejo_scene::{Material, Mesh, Object, Rgb, Scene, Shape};
    use glam::DVec3;

    /// Squares of side 1 at places in a plane, each an object, the last one turned to the back.
    fn squares(places: &[[f64; 3]], turned: bool) -> Scene {
        let mut scene = Scene::default();
        let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
        for (k, &[x, y, z]) in places.iter().enumerate() {
            let mut mesh = Mesh::default();
            for (u, v) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
                mesh.positions.push(DVec3::new(x + u, y + v, z));
            }
            let is_last = k + 1 == places.len();
            let corners = if turned && is_last {
                [3, 2, 1, 0]
            } else {
                [0, 1, 2, 3]
            };
            mesh.push_face(&corners, grey);
            mesh.push_face(&[0, 1, 1], grey);
            scene
                .objects
                .push(Object::new(format!("square {k}"), Shape::Mesh(mesh)));
        }
        scene
    }

    fn overlapping(places: &[[f64; 3]], turned: bool) -> usize {
        let scene = squares(places, turned);
        let sizes = [0.0, 0.3].map(PatchSize::Edge);
        let [whole, divided] = sizes.map(|size| Patches::new(&scene, size).overlapping_faces());
        assert_eq!(whole, divided);
        whole.len()
    }

    #[test]
    fn faces_that_lie_on_others_are_found() {
        let floor = [0.0; 3];
        assert_eq!(overlapping(&[floor, floor], false), 1);
        assert_eq!(overlapping(&[floor, [0.9, 0.5, 0.0]], false), 1);
        assert_eq!(overlapping(&[floor, floor, floor], false), 3);
        assert_eq!(
            overlapping(&[floor, floor], true),
            0,
            "two sides of a sheet"
        );
        assert_eq!(
            overlapping(&[floor, [1.0, 0.0, 0.0]], false),
            0,
            "neighbours"
        );
        assert_eq!(
            overlapping(&[floor, [0.0, 0.0, 1e-3]], false),
            0,
            "a layer above"
        );
    }

    #[test]
    fn flaws_are_named() {
        let scene = squares(&[[0.0; 3], [0.5, 0.0, 0.0]], false);
        let patches = Patches::new(&scene, PatchSize::Edge(0.0));
        let flaws = patches.flaws(&scene, false);
        assert!(
            flaws[0].contains("face 0 of \"square 1\" on face 0 of \"square 0\""),
            "{flaws:?}"
        );
        assert_eq!(
            flaws[1],
            "faces without area have no row: face 1 of \"square 0\", face 1 of \"square 1\""
        );
    }
}
