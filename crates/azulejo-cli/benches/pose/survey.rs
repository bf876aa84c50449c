//! Where the elements of the original are in a changed scene, found by their places alone.
//!
//! An element is a face of the original, or a whole shape that is not a mesh. What a file or a command
//! makes of it may have other objects, other faces in another order, other numbers.

use super::scenes::PosedScene;
use azulejo_scene::math::Aabb;
use azulejo_scene::{Light, LightKind, Mesh, Scene, Shape, TriangleTree};
use glam::{DAffine3, DVec3};
use std::collections::HashMap;

/// Share of a face's area that rounding may change, for its row to be compared.
const MOST_MOVED: f64 = 0.01;

/// The elements of an original scene.
pub struct Original {
    tree: TriangleTree,
    /// Object of each element.
    pub objects: Vec<usize>,
    /// Element of each object that is not a mesh, by its name.
    whole: HashMap<String, usize>,
    /// Area of each element, 0 for shapes that are not meshes.
    pub areas: Vec<f64>,
    /// Circumference over area of each face.
    narrowness: Vec<f64>,
    /// The smallest box around all.
    pub bounds: Aabb,
    /// Change of an area, relative to it, for each unit by which vertices move: the largest circumference
    /// over area of an object.
    pub sensitivity: f64,
    /// The same for faces that are not flat, and are other surfaces once they are divided: times the distance
    /// of their corners from their planes.
    pub bent: f64,
    /// The largest of these distances: triangles of a divided face lie as far from those of the original.
    uneven: f64,
    /// Whether lamps at points or cameras may show what is a room.
    pub is_furnished: bool,
    /// All meshes as one, for its faces as elements.
    mesh: Mesh,
}

/// The elements at the faces of a scene: by object, by face; more than one where faces coincide, none where
/// something was added.
pub struct FaceElements {
    /// Elements of each face of each object.
    pub faces: Vec<Vec<Vec<usize>>>,
    /// Whether an object has a face with an area that is not of the original.
    pub has_added: Vec<bool>,
}

impl Original {
    /// Lists the elements of a scene.
    pub fn new(posed: &PosedScene) -> Original {
        let mut mesh = Mesh::default();
        let (mut objects, mut whole) = (Vec::new(), HashMap::new());
        let mut narrowness = Vec::new();
        let (mut sensitivity, mut bent, mut uneven) = (0.0f64, 0.0f64, 0.0f64);
        for (k, object) in posed.scene.objects.iter().enumerate() {
            let Shape::Mesh(own) = &object.shape else {
                continue;
            };
            let (mut around, mut area, mut bend) = (0.0, 0.0, 0.0f64);
            for face in 0..own.faces.len() {
                let corners = own.face_positions(face);
                let next = corners.iter().cycle().skip(1);
                let own_around: f64 = corners.iter().zip(next).map(|(a, b)| a.distance(*b)).sum();
                around += own_around;
                let normal = own.face_area_vector(face);
                area += normal.length();
                narrowness.push(own_around / normal.length().max(f64::MIN_POSITIVE));
                bend = bend.max(height(&corners, normal.normalize_or_zero()));
                let first = mesh.positions.len() as u32;
                mesh.positions.extend(&corners);
                let ring: Vec<u32> = (first..mesh.positions.len() as u32).collect();
                mesh.push_face(&ring, 0);
                objects.push(k);
            }
            uneven = uneven.max(bend);
            if area > 0.0 {
                sensitivity = sensitivity.max(around / area);
                bent = bent.max(bend * around / area);
            }
        }
        let mut areas: Vec<f64> = (0..mesh.faces.len())
            .map(|f| mesh.face_area_vector(f).length())
            .collect();
        for (k, object) in posed.scene.objects.iter().enumerate() {
            if object.shape.mesh().is_none() {
                whole.insert(object.name.clone(), objects.len());
                objects.push(k);
                areas.push(0.0);
            }
        }
        Original {
            tree: TriangleTree::new(&mesh),
            objects,
            whole,
            areas,
            narrowness,
            bounds: posed.scene.bounds(),
            sensitivity,
            bent,
            uneven,
            is_furnished: !posed.scene.cameras.is_empty()
                || posed.scene.lights.iter().any(is_at_a_point),
            mesh,
        }
    }

    /// The size of the scene.
    pub fn size(&self) -> f64 {
        self.bounds.diagonal()
    }

    /// Faces that are as narrow as vertices moved: any face may become of them. Each comes with another face of
    /// its object, with which it can be compared.
    pub fn slivers(&self, moved: f64) -> impl Iterator<Item = [usize; 2]> {
        let is_sliver = move |&face: &usize| self.narrowness[face] * moved > MOST_MOVED;
        let faces = 0..self.narrowness.len();
        faces.clone().filter(is_sliver).filter_map(move |face| {
            let mut others = faces.clone().filter(|other| !is_sliver(other));
            let other = others.find(|&other| self.objects[other] == self.objects[face])?;
            Some([face, other])
        })
    }

    /// A point on an element and its unit normal, by two random numbers; `None` for shapes that are not a mesh
    /// and faces without area.
    pub fn point_on(&self, element: usize, [u, v]: [f64; 2]) -> Option<(DVec3, DVec3)> {
        if element >= self.mesh.faces.len() {
            return None;
        }
        let normal = self.mesh.face_area_vector(element).try_normalize()?;
        let triangles = self.mesh.triangulate(element);
        let ring = self.mesh.face_positions(element);
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|k| ring[k as usize]);
            (b - a).cross(c - a).length()
        };
        let largest = triangles
            .iter()
            .max_by(|a, b| area(a).total_cmp(&area(b)))?;
        let [a, b, c] = largest.map(|k| ring[k as usize]);
        let root = u.sqrt();
        Some((a + root * (1.0 - v) * (b - a) + root * v * (c - a), normal))
    }

    /// The elements at all faces of a scene, which the map makes of the original, to within `reach`.
    pub fn find(&self, scene: &Scene, map: &DAffine3, reach: f64) -> FaceElements {
        let (inverse, reach) = (map.inverse(), reach + self.uneven);
        let mirrors = map.matrix3.determinant() < 0.0;
        let mut has_added = vec![false; scene.objects.len()];
        let objects = scene
            .objects
            .iter()
            .zip(&mut has_added)
            .map(|(object, has_added)| {
                if let Some(&element) = self.whole.get(&object.name) {
                    let faces = object.shape.mesh().map_or(1, |m| m.faces.len());
                    return vec![vec![element]; faces.max(1)];
                }
                let Some(placed) = object.shape.placed_mesh() else {
                    return Vec::new();
                };
                let face = |face: usize| {
                    let corners: Vec<DVec3> = placed.face_positions(face);
                    let corners: Vec<DVec3> = corners
                        .iter()
                        .map(|&p| inverse.transform_point3(p))
                        .collect();
                    let elements = self.elements_at(&corners, mirrors, reach);
                    *has_added |= elements.as_ref().is_some_and(Vec::is_empty);
                    elements.unwrap_or_default()
                };
                (0..placed.mesh.faces.len()).map(face).collect()
            });
        let faces = objects.collect();
        FaceElements { faces, has_added }
    }

    /// The elements at a polygon in the coordinates of the original; `None` if it has no area, or so little that rounding
    /// may have turned it anywhere.
    fn elements_at(&self, corners: &[DVec3], mirrors: bool, reach: f64) -> Option<Vec<usize>> {
        let (point, normal) = middle(corners)?;
        let normal = if mirrors { -normal } else { normal };
        let mut elements = Vec::new();
        let around = Aabb {
            min: point - reach,
            max: point + reach,
        };
        self.tree.for_each_in(&around, |k, triangle| {
            let own = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
            let own = own.normalize_or_zero();
            let is_here = distance(triangle, own, point) <= reach;
            if is_here && own.dot(normal) > 0.5 {
                elements.push(self.tree.triangle(k).face as usize);
            }
        });
        elements.sort_unstable();
        elements.dedup();
        (!elements.is_empty() || !is_sliver(corners, reach)).then_some(elements)
    }
}

fn is_at_a_point(light: &Light) -> bool {
    matches!(light.kind, LightKind::Point { .. } | LightKind::Spot { .. })
}

/// Distance between the lowest and the highest of some points along a unit vector; 0 for rounding alone.
fn height(points: &[DVec3], along: DVec3) -> f64 {
    let heights = points.iter().map(|p| along.dot(*p - points[0]));
    let [low, high] = heights.fold([0.0f64; 2], |[low, high], h| [low.min(h), high.max(h)]);
    let reach = points.iter().map(|p| p.distance(points[0]));
    let rounding = 1e-12 * reach.fold(points[0].length(), f64::max);
    if high - low > rounding {
        high - low
    } else {
        0.0
    }
}

/// Whether a polygon is no wider than `reach`.
fn is_sliver(corners: &[DVec3], reach: f64) -> bool {
    let from_first = corners.iter().map(|p| *p - corners[0]);
    let longest = from_first.max_by(|a, b| a.length().total_cmp(&b.length()));
    let along = longest.unwrap_or_default().normalize_or_zero();
    let mut across = corners.iter().map(|p| (*p - corners[0]).cross(along));
    across.all(|distance| distance.length() <= reach)
}

/// A point within a polygon, and its unit normal: the middle of its largest triangle, which is part of it.
fn middle(corners: &[DVec3]) -> Option<(DVec3, DVec3)> {
    let mut mesh = Mesh {
        positions: corners.to_vec(),
        ..Mesh::default()
    };
    let ring: Vec<u32> = (0..corners.len() as u32).collect();
    mesh.push_face(&ring, 0);
    let normal = mesh.face_area_vector(0).try_normalize()?;
    let triangles = mesh.triangulate(0).into_iter();
    let triangles = triangles.map(|t| t.map(|k| corners[k as usize]));
    let area = |t: &[DVec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]).length();
    let largest = triangles.max_by(|a, b| area(a).total_cmp(&area(b)))?;
    Some((largest.iter().sum::<DVec3>() / 3.0, normal))
}

/// Distance of a point from a triangle; infinite if it lies beside it.
fn distance(triangle: &[DVec3; 3], normal: DVec3, point: DVec3) -> f64 {
    let height = normal.dot(point - triangle[0]);
    let foot = point - height * normal;
    let longest = (0..3).map(|k| triangle[k].distance(triangle[(k + 1) % 3]));
    let slack = 1e-9 * longest.fold(0.0, f64::max) + height.abs();
    let is_inside = (0..3).all(|k| {
        let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
        let inward = normal.cross(b - a).normalize_or_zero();
        inward.dot(foot - a) >= -slack
    });
    if is_inside {
        height.abs()
    } else {
        f64::INFINITY
    }
}

/// Elements in groups: the finest in which every row of several scenes lies in one group.
pub struct Partition(Vec<usize>);

impl Partition {
    /// Each element by itself.
    pub fn new(elements: usize) -> Partition {
        Partition((0..elements).collect())
    }

    /// The group of an element.
    pub fn of(&self, mut element: usize) -> usize {
        while self.0[element] != element {
            element = self.0[element];
        }
        element
    }

    /// Joins the groups of some elements.
    pub fn join(&mut self, elements: impl IntoIterator<Item = usize>) {
        let mut first = None;
        for element in elements {
            let group = self.of(element);
            let first = *first.get_or_insert(group);
            let (low, high) = (first.min(group), first.max(group));
            self.0[high] = low;
        }
    }

    /// The group of several elements, which are in one; `None` without.
    pub fn of_all(&self, elements: &[usize]) -> Option<usize> {
        elements.first().map(|&e| self.of(e))
    }
}

#[cfg(test)]
mod tests {
    use super::super::changes::{CHANGES, Pose};
    use super::super::dice::Dice;
    use super::super::scenes::families;
    use super::*;

    /// Every face of every change is found, each at the one element that it is a part of.
    #[test]
    fn elements_are_found() {
        for posed in &families(false)[0] {
            let original = Original::new(posed);
            for change in CHANGES {
                let mut pose = Pose::new(posed.scene.clone(), &["grf"]);
                (change.apply)(&mut pose, &mut Dice::new(3, change.name));
                let scale = pose.map.matrix3.determinant().abs().cbrt();
                let reach = 1e-9 * original.size() + 2.0 * pose.moved / scale;
                let face_elements = original.find(&pose.scene, &pose.map, reach);
                let mut areas = vec![0.0; original.areas.len()];
                for (object, faces) in pose.scene.objects.iter().zip(&face_elements.faces) {
                    let mesh = object.shape.mesh().unwrap();
                    for (face, elements) in faces.iter().enumerate() {
                        let is_added = object.name == "double";
                        assert_eq!(
                            elements.is_empty(),
                            is_added,
                            "{} {}",
                            posed.name,
                            change.name
                        );
                        let share = 1.0 / elements.len() as f64;
                        for &element in elements {
                            areas[element] += share * mesh.face_area_vector(face).length();
                        }
                    }
                }
                let sum = areas.iter().sum::<f64>() / (scale * scale);
                let whole: f64 = original.areas.iter().sum();
                assert!(
                    (sum / whole - 1.0).abs() < 0.02,
                    "{} {}",
                    posed.name,
                    change.name
                );
            }
        }
    }

    /// A part of a face without width, which rounding has turned, is not taken for a face that was added.
    #[test]
    fn slivers_are_not_added() {
        let posed = &families(false)[0][0];
        let original = Original::new(posed);
        let (point, normal) = original.point_on(0, [0.3, 0.3]).unwrap();
        let along = 1e-3 * original.size() * normal.any_orthonormal_vector();
        let sliver = [
            point,
            point + along,
            point + 0.5 * along + 1e-6 * original.size() * normal,
        ];
        let turned = |reach: f64| original.elements_at(&sliver, false, reach * original.size());
        assert_eq!(turned(1e-5), None);
        assert_eq!(turned(1e-7), Some(Vec::new()));
    }

    #[test]
    fn groups_are_joined() {
        let mut groups = Partition::new(6);
        groups.join([1, 4]);
        groups.join([4, 5]);
        groups.join([]);
        assert_eq!(groups.of_all(&[5, 1]), Some(groups.of(4)));
        assert_ne!(groups.of(0), groups.of(1));
        assert_eq!(groups.of_all(&[]), None);
    }
}
