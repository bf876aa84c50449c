//! Named surfaces of meshes that list all their points once: an object for each name, with the points
//! that its faces use.
//!
//! Meshes for thermal and mechanical computations name surfaces, not objects.

use super::boundary::VolumeBoundary;
use crate::Position;
use crate::reading::warnings::Warnings;
use azulejo_scene::{Faces, Material, MaterialId, Mesh, Object, Rgb, Scene, Shape, Up};
use glam::DVec3;
use std::collections::HashMap;

/// Reflectance of surfaces, for which these formats have no materials.
const REFLECTANCE: Rgb = Rgb::grey(0.5);

/// Collects faces by the names of their surfaces, in the order of first appearance.
#[derive(Debug, Default)]
pub(crate) struct NamedSurfaces {
    numbers: HashMap<String, usize>,
    surfaces: Vec<(String, Faces)>,
    /// Faces with fewer than three different corners.
    flat: usize,
    /// Faces with a corner that is none of the points.
    lost: usize,
    /// Faces with a point that is not finite.
    infinite: usize,
}

impl NamedSurfaces {
    /// The number of the surface with a name, for [`NamedSurfaces::push`].
    pub fn number(&mut self, name: &str) -> usize {
        if let Some(&known) = self.numbers.get(name) {
            return known;
        }
        self.numbers.insert(name.to_owned(), self.surfaces.len());
        self.surfaces.push((name.to_owned(), Faces::default()));
        self.surfaces.len() - 1
    }

    /// Appends a face to the surface of this number. Corners that equal the next one are left out:
    /// quadrilaterals with three different corners are common where a program has no triangles.
    pub fn push(&mut self, surface: usize, corners: &[u32], positions: &[DVec3]) {
        let faces = &mut self.surfaces[surface].1;
        let start = faces.corners.len();
        let next = corners.iter().cycle().skip(1);
        let differ = std::iter::zip(corners, next).filter(|(a, b)| a != b);
        faces.corners.extend(differ.map(|(&corner, _)| corner));
        let kept = &faces.corners[start..];
        let is_in = |c: &u32| (*c as usize) < positions.len();
        let problem = if kept.len() < 3 {
            &mut self.flat
        } else if !kept.iter().all(is_in) {
            &mut self.lost
        } else if !kept.iter().all(|&c| positions[c as usize].is_finite()) {
            &mut self.infinite
        } else {
            faces.starts.push(faces.corners.len() as u32);
            return;
        };
        *problem += 1;
        faces.corners.truncate(start);
    }

    /// Appends the faces that bound volumes, with their fronts out of them, and says so in a warning.
    /// `name` gives the name of a cell's tag.
    pub fn push_boundary(
        &mut self,
        boundary: &VolumeBoundary,
        positions: &[DVec3],
        name: impl Fn(u32) -> String,
        file: &str,
        warnings: &mut Warnings,
    ) {
        let place = |c: u32| positions.get(c as usize).copied().unwrap_or(DVec3::NAN);
        let (mut turned, mut numbers) = (0, HashMap::new());
        let mut faces = boundary.faces();
        for face in &mut faces {
            turned += usize::from(face.turn_outwards(place));
            let new = || self.number(&name(face.tag));
            let surface = *numbers.entry(face.tag).or_insert_with(new);
            self.push(surface, &face.corners, positions);
        }
        let message = match faces.len() {
            0 => "volumes without a boundary: each face belongs to two of them or more".to_owned(),
            count => format!(
                "volumes without surfaces: the {count} faces of their boundary are read, whose fronts look \
                 out of the volumes (form-factors --two-sided has rows of the backs, too)"
            ),
        };
        warnings.add_whole(file, message);
        let message = "face of a volume whose corners are in another order: turned outwards";
        warnings.add_many(file, message.to_owned(), turned, || Position::Whole);
    }

    /// Whether no face was kept.
    pub fn is_empty(&self) -> bool {
        self.surfaces.iter().all(|(_, faces)| faces.is_empty())
    }

    /// The surfaces as the objects of a scene in which z is up, those without a face left out. Counts in
    /// warnings which faces were skipped.
    pub fn scene(self, positions: &[DVec3], file: &str, warnings: &mut Warnings) -> Scene {
        let mut scene = Scene::default();
        scene.units.up = Up::Z;
        let problems = [
            ("fewer than three different corners", self.flat),
            ("a corner that does not exist", self.lost),
            ("a corner that is not finite", self.infinite),
        ];
        for (problem, count) in problems {
            let message = format!("face with {problem}: skipped");
            warnings.add_many(file, message, count, || Position::Whole);
        }
        if self.is_empty() {
            warnings.add_whole(file, "no faces: the scene is empty");
            return scene;
        }
        let material = scene.add_material(Material::diffuse("default", REFLECTANCE));
        let mut points = LocalPoints::new(positions);
        for (name, faces) in self.surfaces.into_iter().filter(|(_, f)| !f.is_empty()) {
            let mesh = points.mesh(faces, material);
            scene.objects.push(Object::new(name, Shape::Mesh(mesh)));
        }
        scene
    }
}

/// The points of all surfaces, and the numbers that they have in the current one.
struct LocalPoints<'a> {
    positions: &'a [DVec3],
    /// For each point the surface that used it last, from 1, and its number there.
    used: Vec<(u32, u32)>,
    surface: u32,
}

impl LocalPoints<'_> {
    fn new(positions: &[DVec3]) -> LocalPoints<'_> {
        LocalPoints {
            positions,
            used: vec![(0, 0); positions.len()],
            surface: 0,
        }
    }

    /// The next surface as a mesh of its own points.
    fn mesh(&mut self, mut faces: Faces, material: MaterialId) -> Mesh {
        self.surface += 1;
        let mut positions = Vec::new();
        for corner in &mut faces.corners {
            let used = &mut self.used[*corner as usize];
            if used.0 != self.surface {
                *used = (self.surface, positions.len() as u32);
                positions.push(self.positions[*corner as usize]);
            }
            *corner = used.1;
        }
        Mesh {
            positions,
            face_materials: vec![material; faces.len()],
            faces,
            ..Mesh::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_surface_has_its_own_points() {
        let at = |x: f64| DVec3::new(x, x * x, 0.0);
        let mut positions: Vec<DVec3> = (0..6).map(|x| at(f64::from(x))).collect();
        positions[5] = DVec3::NAN;
        let mut surfaces = NamedSurfaces::default();
        let (lid, floor) = (surfaces.number("lid"), surfaces.number("floor"));
        assert_eq!(surfaces.number("lid"), lid);
        let empty = surfaces.number("empty");
        let mut push = |surface, corners: &[u32]| surfaces.push(surface, corners, &positions);
        push(floor, &[4, 2, 3]);
        push(lid, &[0, 1, 2, 2]);
        push(floor, &[3, 2, 0, 4]);
        push(empty, &[0, 1, 1]);
        push(empty, &[0, 1, 6]);
        push(floor, &[0, 1, 5]);
        let mut warnings = Warnings::default();
        let scene = surfaces.scene(&positions, "a", &mut warnings);
        scene.validate().unwrap();
        let names: Vec<&str> = scene.objects.iter().map(|o| o.name.as_str()).collect();
        assert_eq!(names, ["lid", "floor"]);
        let Shape::Mesh(floor) = &scene.objects[1].shape else {
            panic!("a mesh");
        };
        assert_eq!(floor.positions, [4.0, 2.0, 3.0, 0.0].map(at));
        assert_eq!(floor.faces.get(1), [2, 1, 3, 0]);
        let warnings = warnings.finish("a");
        assert!(warnings.iter().all(|w| w.count == 1) && warnings.len() == 3);
    }
}
