//! A file of an original or changed scene, read again, so that it is known where everything is in it.

use super::changes::Pose;
use super::survey::{FaceElements, Original, Partition};
use azulejo::models;
use azulejo_scene::{Mesh, Object, Scene, Shape, Units};
use azulejo_trace::Progress;
use glam::{DAffine3, DMat3, DVec3};
use rstar::RTree;
use rstar::primitives::GeomWithData;
use std::path::{Path, PathBuf};

/// A file with a scene, as commands see it.
pub struct Site {
    /// The file.
    pub path: PathBuf,
    /// Name of each object.
    pub names: Vec<String>,
    /// Elements of the original at each face.
    pub elements: FaceElements,
    /// From the original to the coordinates in which commands work: those of the file, or of `--unit`.
    pub map: DAffine3,
    /// Units in which commands work.
    pub units: Units,
    /// The largest distance by which a vertex was moved, in units of the original.
    pub moved: f64,
    /// Options that belong to the change.
    pub options: Vec<String>,
}

/// Rounding of numbers that readers and writers may leave, relative to the largest coordinate.
const SINGLE: f64 = 1.2e-7;
const DOUBLE: f64 = 1e-14;

/// A copy is this many sizes away at least; it is not part of the original.
const FAR: f64 = 100.0;

impl Site {
    /// Writes a pose to a folder, and reads it again.
    ///
    /// # Errors
    /// What is wrong with the file: it cannot be written or read, or its vertices are not where they were.
    pub fn new(folder: &Path, original: &Original, pose: &Pose) -> Result<Site, String> {
        let path = folder.join(format!("scene.{}", pose.extension));
        let progress = Progress::new();
        models::write(&pose.scene, &path, &progress).map_err(|e| e.to_string())?;
        let model = models::read(&path, &models::Reading::default(), &progress);
        let scene = model.map_err(|e| e.to_string())?.scene;
        let scale = scale_of(&pose.map);
        let (mut map, moved) = placed(original, pose, &scene);
        let largest = scene.bounds();
        let largest = largest.min.abs().max(largest.max.abs()).max_element();
        let is_single = matches!(pose.extension, "glb" | "gltf" | "ply" | "stl");
        let digits = if is_single { SINGLE } else { DOUBLE };
        let reach = pose.moved
            + digits * (largest + 1e-3 * scale * original.size()) * scale / scale_of(&map);
        if moved > 2.0 * reach {
            return Err(format!(
                "vertices of the .{} moved by {moved:.2e}, expected {reach:.2e}",
                pose.extension
            ));
        }
        let moved = (pose.moved + moved.min(reach)) / scale;
        let rounding = 1e-9 * original.size() + 4.0 * f64::EPSILON * largest / scale_of(&map);
        let elements = original.find(&scene, &map, rounding + 2.0 * moved);
        let mut units = scene.units;
        let mut options = Vec::new();
        if let Some((name, metres)) = pose.unit {
            options.extend(["--unit".to_owned(), name.to_owned()]);
            if let Some(own) = units.metres_per_unit {
                map = DAffine3::from_scale(DVec3::splat(own / metres)) * map;
            }
            units.metres_per_unit = Some(metres);
        }
        if pose.is_single {
            options.extend(["--threads".to_owned(), "1".to_owned()]);
        }
        Ok(Site {
            path,
            names: names(scene),
            elements,
            map,
            units,
            moved,
            options,
        })
    }

    /// Lengths here for one of the original.
    pub fn scale(&self) -> f64 {
        scale_of(&self.map)
    }

    /// Square metres here for a square unit of the original.
    pub fn square_metres(&self) -> f64 {
        (self.scale() * self.units.metres()).powi(2)
    }

    /// Elements at all faces of an object.
    pub fn object_elements(&self, object: usize) -> impl Iterator<Item = usize> {
        self.elements
            .faces
            .get(object)
            .into_iter()
            .flatten()
            .flatten()
            .copied()
    }

    /// Whether faces of an object were added to the original.
    pub fn has_added(&self, object: usize) -> bool {
        self.elements.has_added.get(object).is_some_and(|&is| is)
    }

    /// Joins what rows of this file have in common.
    pub fn join(&self, groups: &mut Partition, by_object: bool) {
        for (object, faces) in self.elements.faces.iter().enumerate() {
            faces
                .iter()
                .for_each(|face| groups.join(face.iter().copied()));
            if by_object {
                groups.join(self.object_elements(object));
            }
        }
        if by_object {
            // Rows have names, which objects may share.
            for (k, name) in self.names.iter().enumerate() {
                let same = (0..k).find(|&other| self.names[other] == *name);
                let both = same.into_iter().chain([k]);
                groups.join(both.flat_map(|object| self.object_elements(object)));
            }
        }
    }
}

/// Names of objects, as in rows: those without have their number.
fn names(scene: Scene) -> Vec<String> {
    let objects = scene.objects.into_iter().enumerate();
    let name = |(k, object): (usize, Object)| {
        if object.name.is_empty() {
            format!("object {k}")
        } else {
            object.name
        }
    };
    objects.map(name).collect()
}

/// The mean scale of a map.
fn scale_of(map: &DAffine3) -> f64 {
    map.matrix3.determinant().abs().cbrt()
}

/// From the units and axes of one scene to those of another.
pub fn adaptation(from: Units, to: Units) -> DAffine3 {
    let mesh = Mesh {
        positions: vec![DVec3::X, DVec3::Y, DVec3::Z],
        ..Mesh::default()
    };
    let axes = Scene {
        objects: vec![Object::new("", Shape::Mesh(mesh))],
        units: from,
        ..Scene::default()
    };
    let axes = axes.adapted(to);
    match axes.objects.first().map(|o| &o.shape) {
        Some(Shape::Mesh(mesh)) => DAffine3::from_mat3(DMat3::from_cols(
            mesh.positions[0],
            mesh.positions[1],
            mesh.positions[2],
        )),
        _ => DAffine3::IDENTITY,
    }
}

/// From the original to a file, and the largest distance by which its vertices were moved beside that, in
/// units of the pose. Some formats keep neither unit nor axis: then coordinates are those of the pose.
fn placed(original: &Original, pose: &Pose, scene: &Scene) -> (DAffine3, f64) {
    let vertices = RTree::bulk_load(vertices_of(
        original,
        pose,
        &pose.scene,
        &DAffine3::IDENTITY,
    ));
    let candidates = [
        adaptation(scene.units, pose.scene.units),
        DAffine3::IDENTITY,
    ];
    let moved = |pose_from_file: &DAffine3| {
        let vertices_there = vertices_of(original, pose, scene, pose_from_file);
        // All of it is far away.
        if vertices_there.is_empty() && vertices.size() > 0 {
            return f64::INFINITY;
        }
        let nearest = vertices_there.iter().map(|v| {
            let nearest = vertices.nearest_neighbor(v.geom());
            nearest.map_or(f64::INFINITY, |n| {
                DVec3::from_array(*n.geom()).distance(DVec3::from_array(*v.geom()))
            })
        });
        nearest.fold(0.0, f64::max)
    };
    let tried = candidates.map(|map| (map.inverse() * pose.map, moved(&map)));
    let [adapted, same] = tried;
    if same.1 < adapted.1 { same } else { adapted }
}

/// Vertices of meshes, without those of a copy far away.
fn vertices_of(
    original: &Original,
    pose: &Pose,
    scene: &Scene,
    pose_from_scene: &DAffine3,
) -> Vec<GeomWithData<[f64; 3], ()>> {
    let centre = pose.map.transform_point3(original.bounds.centre());
    let far = FAR * scale_of(&pose.map) * original.size();
    let meshes = scene.objects.iter().filter_map(|o| o.shape.placed_mesh());
    let positions = meshes.flat_map(|placed| {
        let corners = placed.mesh.faces.corners.clone();
        corners.into_iter().map(move |v| placed.position(v))
    });
    let positions = positions.map(|p| pose_from_scene.transform_point3(p));
    let near = positions.filter(|p| p.distance(centre) < far);
    near.map(|p| GeomWithData::new(p.to_array(), ())).collect()
}
