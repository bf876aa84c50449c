//! Incremental construction of a mesh.

use crate::{Attribute, MaterialId, Mesh};
use glam::DVec3;
use std::collections::HashMap;

/// Assigns indices to positions; positions within a tolerance share an index.
pub(super) struct Weld {
    tolerance: f64,
    cells: HashMap<[i64; 3], Vec<u32>>,
    pub positions: Vec<DVec3>,
}

impl Weld {
    /// `tolerance` > 0.
    pub fn new(tolerance: f64) -> Weld {
        Weld {
            tolerance,
            cells: HashMap::new(),
            positions: Vec::new(),
        }
    }

    /// The index of a position: that of an earlier one within the tolerance, or a new one.
    pub fn number(&mut self, p: DVec3) -> u32 {
        let cell = |p: DVec3| {
            (p / (8.0 * self.tolerance))
                .floor()
                .to_array()
                .map(|x| x as i64)
        };
        let reach = DVec3::splat(self.tolerance);
        let (low, high) = (cell(p - reach), cell(p + reach));
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let near = self.cells.get(&[x, y, z]).and_then(|list| {
                        let is_near =
                            |&&k: &&u32| self.positions[k as usize].distance(p) <= self.tolerance;
                        list.iter().find(is_near)
                    });
                    if let Some(&k) = near {
                        return k;
                    }
                }
            }
        }
        let number = self.positions.len() as u32;
        self.cells.entry(cell(p)).or_default().push(number);
        self.positions.push(p);
        number
    }
}

/// A mesh under construction, with a normal at every corner.
pub(super) struct ProxyMeshBuilder {
    weld: Weld,
    mesh: Mesh,
    normals: Vec<DVec3>,
    normal_corners: Vec<u32>,
}

impl ProxyMeshBuilder {
    /// Vertices closer than `tolerance` are merged.
    pub fn new(tolerance: f64) -> ProxyMeshBuilder {
        ProxyMeshBuilder {
            weld: Weld::new(tolerance),
            mesh: Mesh::default(),
            normals: Vec::new(),
            normal_corners: Vec::new(),
        }
    }

    /// Further polygons share no vertices with earlier ones.
    pub fn begin_solid(&mut self) {
        self.weld.cells.clear();
    }

    /// Appends a polygon, counter-clockwise from its front, with the unit normals of its corners. A
    /// polygon with fewer than three different corners is left out.
    pub fn push(&mut self, corners: &[(DVec3, DVec3)], material: MaterialId) {
        let mut ring: Vec<(u32, DVec3)> = corners
            .iter()
            .map(|&(p, n)| (self.weld.number(p), n))
            .collect();
        ring.dedup_by_key(|corner| corner.0);
        while ring.len() > 1 && ring[0].0 == ring[ring.len() - 1].0 {
            ring.pop();
        }
        if ring.len() < 3 {
            return;
        }
        let vertices: Vec<u32> = ring.iter().map(|corner| corner.0).collect();
        self.mesh.push_face(&vertices, material);
        for (_, normal) in ring {
            if self.normals.last() != Some(&normal) {
                self.normals.push(normal);
            }
            self.normal_corners.push(self.normals.len() as u32 - 1);
        }
    }

    pub fn faces(&self) -> usize {
        self.mesh.faces.len()
    }

    pub fn finish(self) -> Mesh {
        Mesh {
            positions: self.weld.positions,
            normals: Some(Attribute {
                values: self.normals,
                corners: Some(self.normal_corners),
            }),
            ..self.mesh
        }
    }
}

/// Positions and normals of a face's corners; the face's own normal where it has no others.
pub(super) fn corners(mesh: &Mesh, face: usize) -> Vec<(DVec3, DVec3)> {
    let flat = mesh.face_area_vector(face).normalize_or_zero();
    let range = mesh.faces.corner_range(face);
    let normal = |k: usize, v: u32| match &mesh.normals {
        Some(normals) => normals.at(k, v),
        None => flat,
    };
    let ring = range.clone().zip(mesh.faces.get(face));
    ring.map(|(k, &v)| (mesh.positions[v as usize], normal(k, v)))
        .collect()
}
