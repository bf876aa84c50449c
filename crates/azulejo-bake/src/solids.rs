//! Which faces bound solids, so that a ray can tell that it started inside of one.
//!
//! A floor goes on under the furniture that stands on it. There it lies inside of closed boxes, in
//! the dark, and that dark must not reach the texels around.

use azulejo_scene::Scene;
use azulejo_scene::math::{Aabb, area_vector};
use azulejo_trace::{KernelHit, KernelRay, Surfaces};
use glam::DVec3;
use std::collections::HashMap;

/// How far from one plane the ends of an open box may be, as a share of its size.
const FLAT: f64 = 1e-6;

/// Vertices nearer than this share of the scene's size are one.
const WELD: f64 = 1e-7;

/// The inner side of a face of a solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Inside {
    /// The face bounds no solid.
    Nowhere,
    Back,
    Front,
}

/// For each object and face whether its back lies inside of a solid: a part of a mesh that is closed, or open at
/// one flat end alone.
pub fn backs_inside(scene: &Scene) -> Vec<Vec<bool>> {
    let inside = |faces: Vec<Inside>| faces.iter().map(|side| *side == Inside::Back).collect();
    Solids::of(scene).inner.into_iter().map(inside).collect()
}

/// The solids of a scene: parts of meshes that are closed, or open at one flat end alone, as boxes
/// without a bottom are.
pub(crate) struct Solids {
    /// By object and face.
    inner: Vec<Vec<Inside>>,
}

impl Solids {
    /// Finds the solids of a scene of meshes. Objects may have parts of one solid each: many files have
    /// every face of a box by itself.
    pub fn of(scene: &Scene) -> Solids {
        let faces = SceneFaces::of(scene);
        let sides = inner_sides(&faces);
        let mut inner: Vec<Vec<Inside>> = Vec::new();
        for object in &scene.objects {
            let count = object.shape.mesh().map_or(0, |mesh| mesh.faces.len());
            let first = inner.iter().map(Vec::len).sum::<usize>();
            inner.push(sides[first..first + count].to_vec());
        }
        Solids { inner }
    }

    /// Whether a ray came from inside of the solid that it hits.
    pub fn comes_from_inside(&self, surfaces: &Surfaces, ray: &KernelRay, hit: &KernelHit) -> bool {
        let item = surfaces.item(hit.item);
        let faces = &self.inner[item.object as usize];
        match faces.get(item.face as usize) {
            None | Some(Inside::Nowhere) => false,
            Some(Inside::Back) => !surfaces.is_front(ray, hit),
            Some(Inside::Front) => surfaces.is_front(ray, hit),
        }
    }
}

/// The faces of all meshes of a scene over welded positions.
struct SceneFaces {
    positions: Vec<DVec3>,
    /// The corners of each face.
    faces: Vec<Vec<u32>>,
}

impl SceneFaces {
    fn of(scene: &Scene) -> SceneFaces {
        let grid = WELD * scene.bounds().diagonal().max(f64::MIN_POSITIVE);
        let mut welded: HashMap<[i64; 3], u32> = HashMap::new();
        let mut all = SceneFaces {
            positions: Vec::new(),
            faces: Vec::new(),
        };
        for mesh in scene.objects.iter().filter_map(|o| o.shape.placed_mesh()) {
            for corners in mesh.mesh.faces.iter() {
                let weld = |&v: &u32| {
                    let p = mesh.position(v);
                    let key = (p / grid).round().to_array().map(|x| x as i64);
                    *welded.entry(key).or_insert_with(|| {
                        all.positions.push(p);
                        all.positions.len() as u32 - 1
                    })
                };
                all.faces.push(corners.iter().map(weld).collect());
            }
        }
        all
    }

    fn corners(&self, face: u32) -> Vec<DVec3> {
        let corners = self.faces[face as usize].iter();
        corners.map(|&v| self.positions[v as usize]).collect()
    }
}

/// Edges by their ends: their faces, and whether these have them from the smaller vertex to the larger.
type EdgeFaces = HashMap<(u32, u32), Vec<(u32, bool)>>;

fn inner_sides(all: &SceneFaces) -> Vec<Inside> {
    let mut edges: EdgeFaces = HashMap::new();
    for (face, corners) in all.faces.iter().enumerate() {
        let next = corners.iter().cycle().skip(1);
        for (&a, &b) in corners.iter().zip(next) {
            if a != b {
                let sides = edges.entry((a.min(b), a.max(b))).or_default();
                sides.push((face as u32, a < b));
            }
        }
    }
    // Faces that continue each other across an edge, and no third, bound one solid.
    let is_joint = |sides: &[(u32, bool)]| match sides {
        [(_, one), (_, other)] => one != other,
        _ => false,
    };
    let mut groups = Groups::new(all.faces.len());
    for sides in edges.values().filter(|sides| is_joint(sides)) {
        groups.join(sides[0].0, sides[1].0);
    }
    let mut parts: HashMap<u32, Part> = HashMap::new();
    for face in 0..all.faces.len() as u32 {
        let part = parts.entry(groups.of(face)).or_default();
        part.faces.push(face);
    }
    for (&(a, b), sides) in edges.iter().filter(|(_, sides)| !is_joint(sides)) {
        for (face, _) in sides {
            if let Some(part) = parts.get_mut(&groups.of(*face)) {
                part.rim.extend([a, b]);
            }
        }
    }
    let mut inner = vec![Inside::Nowhere; all.faces.len()];
    for part in parts.values() {
        let side = part.inner_side(all);
        for &face in &part.faces {
            inner[face as usize] = side;
        }
    }
    inner
}

/// Faces that are connected by edges.
#[derive(Default)]
struct Part {
    faces: Vec<u32>,
    /// Vertices of edges beyond which it does not go on.
    rim: Vec<u32>,
}

impl Part {
    fn inner_side(&self, all: &SceneFaces) -> Inside {
        if self.faces.len() < 3 {
            return Inside::Nowhere;
        }
        let corners = self.faces.iter().flat_map(|&f| all.corners(f));
        let size = Aabb::around(corners).diagonal();
        // A flat lid over the rim adds nothing to the volume as seen from a point of the rim.
        let from = match self.rim.iter().min() {
            Some(&v) => all.positions[v as usize],
            None => all.corners(self.faces[0])[0],
        };
        let cone = |&face: &u32| {
            let corners = all.corners(face);
            area_vector(&corners).dot(corners[0] - from)
        };
        let volume: f64 = self.faces.iter().map(cone).sum();
        let is_thin = volume.abs() <= FLAT * size.powi(3);
        if is_thin || !self.has_flat_rim(all, from, size) {
            return Inside::Nowhere;
        }
        if volume > 0.0 {
            Inside::Back
        } else {
            Inside::Front
        }
    }

    fn has_flat_rim(&self, all: &SceneFaces, from: DVec3, size: f64) -> bool {
        if self.rim.is_empty() {
            return true;
        }
        let position = |&v: &u32| all.positions[v as usize] - from;
        let rim: Vec<DVec3> = self.rim.iter().map(position).collect();
        let farthest = rim.iter().max_by(|a, b| a.length().total_cmp(&b.length()));
        let along = farthest.map_or(DVec3::ZERO, |d| d.normalize_or_zero());
        let across = rim.iter().map(|d| along.cross(*d));
        let across = across.max_by(|a, b| a.length().total_cmp(&b.length()));
        let normal = across.unwrap_or_default().normalize_or_zero();
        rim.iter().all(|d| d.dot(normal).abs() <= FLAT * size)
    }
}

/// Groups of numbers, by joining pairs.
pub(crate) struct Groups(Vec<u32>);

impl Groups {
    /// Each number alone.
    pub fn new(count: usize) -> Groups {
        Groups((0..count as u32).collect())
    }

    /// The smallest number of a number's group.
    pub fn of(&mut self, mut number: u32) -> u32 {
        while self.0[number as usize] != number {
            let next = self.0[number as usize];
            self.0[number as usize] = self.0[next as usize];
            number = next;
        }
        number
    }

    /// Makes one group of those of two numbers.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.of(a), self.of(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
