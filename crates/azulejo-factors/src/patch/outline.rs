//! The faces of the scene before division: flat regions, shared edges, and which regions form one
//! smooth surface.

use crate::disjoint_sets::DisjointSets;
use azulejo_scene::math::area_vector;
use azulejo_scene::{MaterialId, PlacedMesh, Primitive, Scene, Shape};
use glam::DVec3;
use std::ops::Range;

/// Tolerance of flat faces: distance of corners from the plane, as a share of the diameter.
const FLATNESS: f64 = 1e-5;
/// Below this angle of 30°, faces of a mesh without smoothing information form one surface.
const SMOOTH_COSINE: f64 = 0.866_025_403_784_438_6;
/// Faces that turn by less than 0.1° are coplanar.
const COPLANAR_COSINE: f64 = 0.999_998_5;
/// Faces of more corners are divided triangle by triangle: to triangulate anew with a lattice inside,
/// and to compare every corner with every line on the face, would take quadratic time.
const REGION_CORNERS: usize = 2048;
/// At an edge of many faces each is compared with this many before it: two is a manifold, more is
/// an accident, and comparing all with all would be quadratic.
const FACES_COMPARED: usize = 8;

/// The form of a region, which determines how it can be divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// Without area, or with corners that are not finite: no patches.
    Empty,
    /// Three corners.
    Triangle,
    /// Four corners, flat and strictly convex.
    Quad,
    /// Any other flat simple polygon.
    Polygon,
    /// A part of an exact primitive.
    Part,
}

/// A flat piece of one face: the whole face, or one of its triangles where it is bent.
#[derive(Clone, Debug)]
pub(super) struct Region {
    pub object: u32,
    pub face: u32,
    pub form: Form,
    /// Its slots: one per corner, each with the side that follows it.
    pub slots: Range<u32>,
    /// Its triangles in [`Outline::triangles`], in the tracer's order.
    pub triangles: Range<u32>,
    pub normal: DVec3,
    pub area: f64,
    pub material: MaterialId,
}

/// One corner of a region and the side from it to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slot {
    /// Which corner of the mesh, counted over all its faces.
    pub corner: u32,
    /// Which vertex of the mesh.
    pub vertex: u32,
    pub position: DVec3,
    /// The side, among [`Outline::edges`].
    pub edge: u32,
    /// Whether the side runs as its edge does.
    pub forward: bool,
    /// Slots of one corner group are one display vertex.
    pub corner_group: u32,
    /// Sides of one seam share their display vertices.
    pub seam: u32,
}

/// A straight line between two positions, in a direction that depends on the positions alone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub from: DVec3,
    pub to: DVec3,
}

impl Edge {
    pub fn length(&self) -> f64 {
        self.from.distance(self.to)
    }

    /// The point `share` of the way along; bit-identical for every face at the edge.
    pub fn point(&self, share: f64) -> DVec3 {
        self.from + (self.to - self.from) * share
    }
}

/// All regions of a scene, and what they share.
pub(super) struct Outline<'s> {
    pub scene: &'s Scene,
    pub regions: Vec<Region>,
    pub slots: Vec<Slot>,
    /// Triangles of the regions, as positions among the region's slots.
    pub triangles: Vec<[u32; 3]>,
    pub edges: Vec<Edge>,
    /// For each object the number of faces before it, and the total.
    pub face_base: Vec<u32>,
    /// For each face the number of regions before it, and the total.
    pub face_regions: Vec<u32>,
}

impl<'s> Outline<'s> {
    pub fn new(scene: &'s Scene) -> Outline<'s> {
        let mut outline = Outline {
            scene,
            regions: Vec::new(),
            slots: Vec::new(),
            triangles: Vec::new(),
            edges: Vec::new(),
            face_base: vec![0],
            face_regions: vec![0],
        };
        for (object, o) in scene.objects.iter().enumerate() {
            if let Some(mesh) = o.shape.placed_mesh() {
                outline.add_mesh(object as u32, mesh);
            } else if let Shape::Primitive(primitive) = &o.shape {
                outline.add_primitive(object as u32, primitive);
            }
            // Exact shapes are divided as their proxy polygons: see `Scene::faceted`.
            let faces = outline.face_regions.len() - 1;
            outline.face_base.push(faces as u32);
        }
        outline.share_edges();
        outline
    }

    pub fn slots_of(&self, region: &Region) -> &[Slot] {
        &self.slots[region.slots.start as usize..region.slots.end as usize]
    }

    pub fn triangles_of(&self, region: &Region) -> &[[u32; 3]] {
        &self.triangles[region.triangles.start as usize..region.triangles.end as usize]
    }

    /// The mesh of a region, unless it is a primitive's part.
    pub fn mesh(&self, region: &Region) -> Option<PlacedMesh<'s>> {
        self.scene.objects[region.object as usize]
            .shape
            .placed_mesh()
    }

    fn add_primitive(&mut self, object: u32, primitive: &Primitive) {
        for part in 0..primitive.kind.parts() {
            self.regions.push(Region {
                object,
                face: part as u32,
                form: Form::Part,
                slots: 0..0,
                triangles: 0..0,
                normal: DVec3::ZERO,
                area: 0.0,
                material: primitive.material,
            });
            self.face_regions.push(self.regions.len() as u32);
        }
    }

    fn add_mesh(&mut self, object: u32, placed: PlacedMesh) {
        let mesh = placed.mesh;
        let (mut triangles, mut corners) = (Vec::new(), Vec::new());
        for face in 0..mesh.faces.len() {
            triangles.clear();
            mesh.triangulate_into(face, &mut triangles);
            let points = placed.face_positions(face);
            match flat_form(&points, &triangles) {
                Some(form) => {
                    corners.clear();
                    corners.extend(0..points.len() as u32);
                    self.add_region(object, placed, face, form, &corners, &triangles);
                }
                None => {
                    for t in &triangles {
                        let form = triangle_form(&t.map(|k| points[k as usize]));
                        self.add_region(object, placed, face, form, t, &[[0, 1, 2]]);
                    }
                }
            }
            self.face_regions.push(self.regions.len() as u32);
        }
    }

    fn add_region(
        &mut self,
        object: u32,
        placed: PlacedMesh,
        face: usize,
        form: Form,
        corners: &[u32],
        triangles: &[[u32; 3]],
    ) {
        let mesh = placed.mesh;
        let (slot, triangle) = (self.slots.len() as u32, self.triangles.len() as u32);
        let first = mesh.faces.corner_range(face).start as u32;
        let ring = mesh.faces.get(face);
        let positions: Vec<DVec3> = corners
            .iter()
            .map(|&c| placed.position(ring[c as usize]))
            .collect();
        let vector = area_vector(&positions);
        // The tracer needs the triangles of empty regions too, but they have no sides to share.
        self.triangles.extend_from_slice(triangles);
        if form != Form::Empty {
            self.slots
                .extend(corners.iter().zip(positions).map(|(&c, p)| Slot {
                    corner: first + c,
                    vertex: ring[c as usize],
                    // Adding zero turns −0 into 0, so that equal positions have equal bits.
                    position: p + DVec3::ZERO,
                    edge: 0,
                    forward: true,
                    corner_group: 0,
                    seam: 0,
                }));
        }
        self.regions.push(Region {
            object,
            face: face as u32,
            form,
            slots: slot..self.slots.len() as u32,
            triangles: triangle..self.triangles.len() as u32,
            normal: vector.normalize_or_zero(),
            area: vector.length(),
            material: mesh.face_materials.get(face).copied().unwrap_or(0),
        });
    }

    /// Finds sides on the same line, and joins those that are one smooth surface.
    fn share_edges(&mut self) {
        let places = self.places();
        let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(self.slots.len());
        for region in &self.regions {
            for slot in region.slots.clone() {
                let [a, b] = [slot, next_slot(region, slot)].map(|s| places[s as usize]);
                self.slots[slot as usize].forward = a < b;
                sides.push((a.min(b), a.max(b), slot));
            }
        }
        sides.sort_unstable();
        let owner = self.owners();
        let mut corner_groups = DisjointSets::new(self.slots.len());
        let mut seams = DisjointSets::new(self.slots.len());
        self.join_corners_of_faces(&mut corner_groups);
        for run in sides.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
            self.push_edge(run, &owner);
            self.join_smooth(run, &owner, &mut corner_groups, &mut seams);
        }
        for slot in 0..self.slots.len() as u32 {
            self.slots[slot as usize].corner_group = corner_groups.find(slot);
            self.slots[slot as usize].seam = seams.find(slot);
        }
    }

    /// A number per slot, equal for equal positions and ordered as they are.
    fn places(&self) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.slots.len() as u32).collect();
        let key = |s: u32| self.slots[s as usize].position.to_array();
        order.sort_unstable_by(|&a, &b| {
            let (p, q) = (key(a), key(b));
            p[0].total_cmp(&q[0])
                .then(p[1].total_cmp(&q[1]))
                .then(p[2].total_cmp(&q[2]))
        });
        let mut places = vec![0; order.len()];
        let mut place = 0;
        for (i, &slot) in order.iter().enumerate() {
            if i > 0 && key(order[i - 1]) != key(slot) {
                place += 1;
            }
            places[slot as usize] = place;
        }
        places
    }

    /// The region of each slot.
    fn owners(&self) -> Vec<u32> {
        let mut owner = vec![0; self.slots.len()];
        for (r, region) in self.regions.iter().enumerate() {
            owner[region.slots.start as usize..region.slots.end as usize].fill(r as u32);
        }
        owner
    }

    /// The triangles of a bent face share its corners.
    fn join_corners_of_faces(&self, groups: &mut DisjointSets) {
        for face in self.face_regions.windows(2).filter(|w| w[1] - w[0] > 1) {
            let regions = &self.regions[face[0] as usize..face[1] as usize];
            let (first, last) = (regions[0].slots.start, regions[regions.len() - 1].slots.end);
            let mut slots: Vec<u32> = (first..last).collect();
            slots.sort_by_key(|&s| self.slots[s as usize].corner);
            for w in slots.windows(2) {
                if self.slots[w[0] as usize].corner == self.slots[w[1] as usize].corner {
                    groups.join(w[0], w[1]);
                }
            }
        }
    }

    fn push_edge(&mut self, run: &[(u32, u32, u32)], owner: &[u32]) {
        let slot = run[0].2;
        let next = next_slot(&self.regions[owner[slot as usize] as usize], slot);
        let [mut from, mut to] = [slot, next].map(|s| self.slots[s as usize].position);
        if !self.slots[slot as usize].forward {
            std::mem::swap(&mut from, &mut to);
        }
        for side in run {
            self.slots[side.2 as usize].edge = self.edges.len() as u32;
        }
        self.edges.push(Edge { from, to });
    }

    fn join_smooth(
        &self,
        run: &[(u32, u32, u32)],
        owner: &[u32],
        corner_groups: &mut DisjointSets,
        seams: &mut DisjointSets,
    ) {
        for (i, &(_, _, a)) in run.iter().enumerate() {
            for &(_, _, b) in &run[i.saturating_sub(FACES_COMPARED)..i] {
                let regions = [a, b].map(|s| &self.regions[owner[s as usize] as usize]);
                let ends = [(a, next_slot(regions[0], a)), (b, next_slot(regions[1], b))];
                if let Some(pairs) = self.smooth_pairs(regions, ends) {
                    for (p, q) in pairs {
                        corner_groups.join(p, q);
                    }
                    seams.join(a, b);
                }
            }
        }
    }

    /// The slots at the two ends of a side that two regions share, if they share its vertices
    /// and are one smooth surface there.
    fn smooth_pairs(
        &self,
        [r, s]: [&Region; 2],
        [(a0, a1), (b0, b1)]: [(u32, u32); 2],
    ) -> Option<[(u32, u32); 2]> {
        let vertex = |k: u32| self.slots[k as usize].vertex;
        let corner = |k: u32| self.slots[k as usize].corner as usize;
        let pairs = if (vertex(a0), vertex(a1)) == (vertex(b1), vertex(b0)) {
            [(a0, b1), (a1, b0)]
        } else if (vertex(a0), vertex(a1)) == (vertex(b0), vertex(b1)) {
            [(a0, b0), (a1, b1)]
        } else {
            return None;
        };
        if r.object != s.object {
            return None;
        }
        let placed = self.mesh(r)?;
        let mesh = placed.mesh;
        let cosine = r.normal.dot(s.normal);
        let smooth = if r.face == s.face {
            true
        } else if mesh.normals.is_some() {
            let at = |k: u32| placed.normal(corner(k), vertex(k)).unwrap_or_default();
            pairs
                .iter()
                .all(|&(p, q)| at(p).dot(at(q)) > COPLANAR_COSINE)
        } else if mesh.smoothing.is_empty() {
            cosine > SMOOTH_COSINE
        } else {
            let group = mesh.smoothing_group(r.face as usize);
            cosine > COPLANAR_COSINE || group != 0 && group == mesh.smoothing_group(s.face as usize)
        };
        smooth.then_some(pairs)
    }
}

/// The slot after `slot` around its region.
fn next_slot(region: &Region, slot: u32) -> u32 {
    if slot + 1 == region.slots.end {
        region.slots.start
    } else {
        slot + 1
    }
}

fn longest_distance(points: &[DVec3]) -> f64 {
    points
        .iter()
        .map(|p| p.distance(points[0]))
        .fold(0.0, f64::max)
}

/// A triangle, unless its area is within the rounding of its corners.
fn triangle_form(points: &[DVec3; 3]) -> Form {
    let area = area_vector(points).length();
    let reach = longest_distance(points);
    if area.is_finite() && area > 1e-14 * reach * reach && reach > 0.0 {
        Form::Triangle
    } else {
        Form::Empty
    }
}

/// The form of a whole face; `None` if only its triangles are flat, if it crosses itself, or if it
/// has very many corners.
fn flat_form(points: &[DVec3], triangles: &[[u32; 3]]) -> Option<Form> {
    if let &[a, b, c] = points {
        return Some(triangle_form(&[a, b, c]));
    }
    if points.len() > REGION_CORNERS {
        return None;
    }
    let vector = area_vector(points);
    let reach = longest_distance(points);
    let normal = vector.normalize_or_zero();
    let flat = normal != DVec3::ZERO
        && points
            .iter()
            .all(|p| (*p - points[0]).dot(normal).abs() <= FLATNESS * reach);
    // The triangles of a simple polygon tile it, so their areas add up without overlap.
    let tiled: f64 = triangles
        .iter()
        .map(|t| area_vector(&t.map(|k| points[k as usize])).length())
        .sum();
    let simple = (tiled - vector.length()).abs() <= 1e-6 * tiled;
    if !(flat && simple && vector.length() > 1e-12 * reach * reach) {
        None
    } else if is_convex_quad(points, normal) {
        Some(Form::Quad)
    } else {
        Some(Form::Polygon)
    }
}

/// Whether a flat quadrilateral turns by at least half a degree at every corner.
fn is_convex_quad(points: &[DVec3], normal: DVec3) -> bool {
    points.len() == 4
        && (0..4).all(|k| {
            let [e, f] = [1, 3].map(|step| points[(k + step) % 4] - points[k]);
            e.cross(f).dot(normal) > 0.01 * e.length() * f.length()
        })
}
