//! Edges that coincide, moved apart.

use super::shell::Shell;
use super::{coarseness, height, single};
use azulejo_scene::{MaterialId, Mesh};
use glam::DVec3;
use std::collections::HashMap;

/// How often coincident edges are moved, each time twice as far.
const ROUNDS: i32 = 12;
/// How far vertices are moved, in steps of single precision.
const STEPS: f64 = 4.0;

/// The shells of all objects of a file.
#[derive(Default)]
pub(super) struct Shells {
    positions: Vec<DVec3>,
    triangles: Vec<ShellTriangle>,
}

struct ShellTriangle {
    corners: [u32; 3],
    material: MaterialId,
    object: u32,
}

/// What is wrong with the triangles of a file.
#[derive(Default)]
struct Flaws {
    /// Vertices to move, and by how many steps.
    moved: HashMap<u32, f64>,
    /// The object of the first flaw that moving cannot mend.
    worst: Option<u32>,
    edges: usize,
}

impl Shells {
    /// Adds the shell of an object.
    pub fn add(&mut self, object: u32, shell: Shell) {
        let base = self.positions.len() as u32;
        self.positions.extend(shell.positions);
        let triangles = shell.triangles.into_iter();
        self.triangles
            .extend(triangles.map(|(corners, material)| ShellTriangle {
                corners: corners.map(|v| base + v),
                material,
                object,
            }));
    }

    fn points(&self, corners: [u32; 3]) -> [DVec3; 3] {
        corners.map(|v| self.positions[v as usize])
    }

    /// Moves vertices inwards until no edges coincide, by their positions, and no triangle is without area.
    ///
    /// Programs that merge equal positions would else find edges of four triangles, as where two letters, or two
    /// parts of one, touch.
    pub fn move_apart(&mut self) {
        for round in 0..ROUNDS {
            let flaws = self.flaws();
            if flaws.moved.is_empty() {
                return;
            }
            let mut inward: HashMap<u32, DVec3> = HashMap::new();
            for t in &self.triangles {
                for v in t
                    .corners
                    .into_iter()
                    .filter(|v| flaws.moved.contains_key(v))
                {
                    let [a, b, c] = self.points(t.corners);
                    *inward.entry(v).or_default() -= (b - a).cross(c - a);
                }
            }
            for (v, steps) in flaws.moved {
                let p = &mut self.positions[v as usize];
                let way = inward
                    .get(&v)
                    .map_or(DVec3::X, |way| way.normalize_or(DVec3::X));
                let step = STEPS * coarseness([*p; 3]) * 2f64.powi(round);
                *p = single(*p + steps * step * way);
            }
        }
    }

    /// The first object that is not closed, and why: nothing is written then.
    pub fn flaw(&self) -> Option<(u32, String)> {
        let flaws = self.flaws();
        if let Some(object) = flaws.worst {
            let found = flaws.edges;
            let message = format!(
                "found {found} edges of its polygons without exactly two triangles, expected a closed surface; another \
                 --tolerance may help, and GRF keeps exact shapes"
            );
            return Some((object, message));
        }
        let mut volumes: HashMap<u32, f64> = HashMap::new();
        for t in &self.triangles {
            let [a, b, c] = self.points(t.corners);
            *volumes.entry(t.object).or_default() += a.dot(b.cross(c)) / 6.0;
        }
        let hollow = volumes.iter().filter(|(_, v)| **v <= 0.0).map(|(k, _)| *k);
        let message = "its polygons enclose no volume; is it turned inside out?";
        hollow.min().map(|object| (object, message.to_owned()))
    }

    fn flaws(&self) -> Flaws {
        let mut known = HashMap::with_capacity(self.positions.len());
        let places: Vec<u32> = (self.positions.iter())
            .map(|p| {
                let next = known.len() as u32;
                *known.entry(p.to_array().map(f64::to_bits)).or_insert(next)
            })
            .collect();
        drop(known);
        let place = |v: u32| places[v as usize];
        let mut edges = Vec::with_capacity(3 * self.triangles.len());
        for (n, t) in (0..).zip(&self.triangles) {
            for k in 0..3 {
                let (a, b) = (t.corners[k], t.corners[(k + 1) % 3]);
                let (a, b) = if (place(a), a) < (place(b), b) {
                    (a, b)
                } else {
                    (b, a)
                };
                edges.push((place(a), place(b), a, b, 3 * n + k as u32));
            }
        }
        edges.sort_unstable();
        let mut flaws = Flaws::default();
        for uses in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
            self.judge(uses, &mut flaws);
        }
        for t in &self.triangles {
            let (k, height) = height(self.points(t.corners));
            if height == 0.0 {
                flaws.moved.entry(t.corners[k]).or_insert(1.0);
                flaws.worst.get_or_insert(t.object);
            }
        }
        flaws
    }

    /// Looks at the triangles at one edge.
    fn judge(&self, uses: &[(u32, u32, u32, u32, u32)], flaws: &mut Flaws) {
        let forward = |&(_, _, low, _, half): &(u32, u32, u32, u32, u32)| {
            self.triangles[half as usize / 3].corners[half as usize % 3] == low
        };
        if let [one, other] = uses
            && forward(one) != forward(other)
        {
            return;
        }
        flaws.edges += 1;
        let object = self.triangles[uses[0].4 as usize / 3].object;
        flaws.worst.get_or_insert(object);
        // Copies after the first are moved, each further than the one before.
        let mut copies: Vec<(u32, u32)> = uses.iter().map(|u| (u.2, u.3)).collect();
        copies.dedup();
        for (k, (a, b)) in copies.iter().enumerate().skip(1) {
            let (first, last) = copies[0];
            for v in [*a, *b].into_iter().filter(|v| *v != first && *v != last) {
                let steps = flaws.moved.entry(v).or_default();
                *steps = steps.max(k as f64);
            }
        }
    }

    /// The triangles of each object as a mesh.
    pub fn meshes(&self, objects: usize) -> Vec<Option<Mesh>> {
        let mut meshes: Vec<Option<Mesh>> = vec![None; objects];
        let mut numbers: HashMap<u32, u32> = HashMap::new();
        let mut current = None;
        for t in &self.triangles {
            if current != Some(t.object) {
                numbers.clear();
                current = Some(t.object);
            }
            let mesh = meshes[t.object as usize].get_or_insert_default();
            let corners = t.corners.map(|v| {
                *numbers.entry(v).or_insert_with(|| {
                    mesh.positions.push(self.positions[v as usize]);
                    mesh.positions.len() as u32 - 1
                })
            });
            mesh.push_face(&corners, t.material);
        }
        meshes
    }
}
