//! Builds vertices, patches and their adjacency from a division.

use super::bent::{bent_regions, onto};
use super::cells::{Cells, CornerOrigin, NO_CORNER};
use super::contacts::Contacts;
use super::divide::Division;
use super::locate::{Locator, is_flat};
use super::outline::{Outline, Region, Slot};
use super::reflectance::{mean_emitted_pictures, mean_opacities};
use super::vertex_split::{SplitVertex, split_along_contacts};
use super::{DisplayVertex, FaceId, FlatRegion, GivenVertex, Lists, Patches};
use azulejo_scene::math::area_vector;
use azulejo_scene::{
    CoordinateDigits, Object, Primitive, PrimitiveKind, Scene, Shape, SurfaceGrid,
};
use glam::DVec3;
use std::collections::HashSet;

/// How far gather positions move towards the centre of the adjoining patches.
const PULL: f64 = 1e-3;
/// The same in errors of a coordinate in single precision: of both surfaces that meet there, in any direction.
const ROUNDINGS: f64 = 4.0;
/// The most of it, however small the patches are.
const MOST_PULL: f64 = 0.25;
/// Patches that turn less than this (cosine) around a vertex are coplanar there.
const COPLANAR_COSINE: f64 = 1.0 - 1e-9;
/// A piece of a side lies on a contact if its middle is within this share of the edge.
const NEAR: f64 = 1e-5;
/// Marks a point without a display vertex.
const UNSEEN: u32 = u32::MAX;

/// Builds the patches of a division.
pub(super) fn build(outline: &Outline, contacts: &Contacts, division: Division) -> Patches {
    // Vertices and patches, object by object, and the patches around each vertex.
    let mut builder = PatchBuilder::new(outline, contacts, &division);
    builder.add_objects();
    let PatchBuilder {
        vertices,
        corners,
        owner,
        region_patches,
        object_vertices,
        object_patches,
        corner_vertex,
        parted,
        ..
    } = builder;
    let rings = |i: u32| corners[i as usize].iter().filter(|&&v| v != NO_CORNER);
    let around = Lists::new(
        vertices.len(),
        (0..corners.len() as u32).flat_map(|i| rings(i).map(move |&v| (v, i))),
    );
    let locator = Locator::new(outline, &division.cells, &region_patches);
    let mut patches = Patches {
        areas: Vec::new(),
        emitted_pictures: None,
        regions: outline.regions.iter().map(flat).collect(),
        region_corners: outline.slots.iter().map(|s| s.corner).collect(),
        bent: bent_regions(outline),
        primitives: outline.scene.objects.iter().map(primitive).collect(),
        given: given_vertices(outline, &corner_vertex, &parted),
        face_base: outline.face_base.clone(),
        face_regions: outline.face_regions.clone(),
        cells: division.cells,
        corners,
        owner,
        region_patches,
        object_patches,
        object_vertices,
        vertices,
        around,
        locator,
    };
    // What depends on the finished patches.
    patches.areas = (0..patches.len()).map(|i| area(&patches, i)).collect();
    pull_inward(&mut patches, &roundings(outline.scene));
    if let Some(shares) = mean_opacities(outline.scene, &patches) {
        let areas = patches.areas.iter_mut().zip(shares);
        areas.for_each(|(area, share)| *area *= share);
    }
    patches.emitted_pictures = mean_emitted_pictures(outline.scene, &patches);
    patches
}

fn flat(region: &Region) -> FlatRegion {
    FlatRegion {
        face: FaceId {
            object: region.object,
            face: region.face,
        },
        material: region.material,
        normal: region.normal,
        corners: region.slots.clone(),
    }
}

fn primitive(object: &Object) -> Option<Primitive> {
    match &object.shape {
        Shape::Primitive(p) => Some(p.clone()),
        Shape::Mesh(_) | Shape::Instance(_) | Shape::Exact(_) => None,
    }
}

struct PatchBuilder<'a> {
    outline: &'a Outline<'a>,
    contacts: &'a Contacts,
    division: &'a Division,
    vertices: Vec<DisplayVertex>,
    corners: Vec<[u32; 4]>,
    owner: Vec<u32>,
    region_patches: Vec<u32>,
    object_vertices: Vec<u32>,
    object_patches: Vec<u32>,
    /// Display vertex of each corner group, at the group's first slot.
    corner_vertex: Vec<u32>,
    /// First of the display vertices along each seam, at the seam's first slot.
    seam_vertex: Vec<u32>,
    /// Shading normal of each slot.
    normals: Vec<DVec3>,
    /// Edges of the object's patches along contacts, as ascending pairs of vertices.
    contact_edges: HashSet<[u32; 2]>,
    /// The vertices on contacts after they were split.
    parted: Vec<SplitVertex>,
}

impl<'a> PatchBuilder<'a> {
    fn new(
        outline: &'a Outline<'a>,
        contacts: &'a Contacts,
        division: &'a Division,
    ) -> PatchBuilder<'a> {
        let slots = outline.slots.len();
        PatchBuilder {
            outline,
            contacts,
            division,
            vertices: Vec::new(),
            corners: Vec::new(),
            owner: Vec::new(),
            region_patches: vec![0],
            object_vertices: vec![0],
            object_patches: vec![0],
            corner_vertex: vec![UNSEEN; slots],
            seam_vertex: vec![UNSEEN; slots],
            normals: shading_normals(outline),
            contact_edges: HashSet::new(),
            parted: Vec::new(),
        }
    }

    fn add_objects(&mut self) {
        for faces in self.outline.face_base.windows(2) {
            let regions = self.outline.face_regions[faces[0] as usize]
                ..self.outline.face_regions[faces[1] as usize];
            for r in regions {
                self.add_region(r);
            }
            self.part_vertices_at_contacts();
            self.object_vertices.push(self.vertices.len() as u32);
            self.object_patches.push(self.corners.len() as u32);
        }
    }

    fn add_region(&mut self, r: u32) {
        let region = &self.outline.regions[r as usize];
        let cells = &self.division.cells[r as usize];
        let local = match *cells {
            Cells::None => Vec::new(),
            Cells::Part { nu, nv } => self.part_vertices(region, nu, nv),
            _ => self.flat_vertices(region, cells),
        };
        cells.for_each(|ring| {
            let vertex = |k: u32| local.get(k as usize).copied().unwrap_or(NO_CORNER);
            self.corners.push(ring.map(vertex));
            self.owner.push(r);
        });
        self.note_contacts(r, cells, &local);
        self.region_patches.push(self.corners.len() as u32);
    }

    /// Records which edges of a region's patches lie on contacts. `local` are the vertices at its
    /// local points.
    fn note_contacts(&mut self, r: u32, cells: &Cells, local: &[u32]) {
        let region = &self.outline.regions[r as usize];
        if let Cells::Irregular(mesh) = cells {
            let edges = mesh.contacts.iter().map(|e| e.map(|k| local[k as usize]));
            self.contact_edges.extend(edges.map(ascending));
        }
        let mut along = self.contacts.of(r as usize).iter().filter(|c| !c.inside);
        if along.next().is_none() {
            return;
        }
        let (slots, edge_points) = (self.outline.slots_of(region), &self.division.edge_points);
        let pieces = slots.iter().map(|s| edge_points.pieces[s.edge as usize]);
        let mut sides: Vec<Vec<u32>> = pieces.map(|n| vec![UNSEEN; n as usize]).collect();
        let mut next = local.iter();
        cells.for_each_point(|place| {
            if let (CornerOrigin::Side { side, step }, Some(&v)) = (place, next.next()) {
                sides[side as usize][step as usize] = v;
            }
        });
        for (k, slot) in slots.iter().enumerate() {
            let end = sides[(k + 1) % slots.len()][0];
            sides[k].push(end);
            for (step, w) in (0..).zip(sides[k].windows(2)) {
                if self.is_on_contact(r, slot, step) {
                    self.contact_edges.insert(ascending([w[0], w[1]]));
                }
            }
        }
    }

    /// Whether piece `step` of a side lies on a contact along it.
    fn is_on_contact(&self, r: u32, slot: &Slot, step: u32) -> bool {
        let edge = &self.outline.edges[slot.edge as usize];
        let edge_points = &self.division.edge_points;
        let ends = [step, step + 1].map(|k| edge.point(edge_points.share_on(slot, k)));
        let middle = 0.5 * (ends[0] + ends[1]);
        let reach = NEAR * edge.length();
        let mut along = self.contacts.of(r as usize).iter().filter(|c| !c.inside);
        along.any(|c| {
            let [a, b] = c.ends;
            let share = (middle - a).dot(b - a) / a.distance_squared(b);
            middle.distance(a + share.clamp(0.0, 1.0) * (b - a)) < reach
        })
    }

    /// Splits the vertices on contacts of the object that was added last.
    fn part_vertices_at_contacts(&mut self) {
        if self.contact_edges.is_empty() {
            return;
        }
        let first = self.object_patches[self.object_patches.len() - 1] as usize;
        let corners = &mut self.corners[first..];
        let parted = split_along_contacts(&self.contact_edges, corners, &mut self.vertices);
        self.parted.extend(parted);
        self.contact_edges.clear();
    }

    fn push_vertex(&mut self, object: u32, position: DVec3, normal: DVec3) -> u32 {
        self.vertices.push(DisplayVertex {
            object,
            position,
            normal,
            gather: position,
        });
        self.vertices.len() as u32 - 1
    }

    /// The display vertices of a flat region's local points, created where it is the first.
    fn flat_vertices(&mut self, region: &Region, cells: &Cells) -> Vec<u32> {
        let outline = self.outline;
        let slots = outline.slots_of(region);
        let first = region.slots.start as usize;
        let normals = self.normals[first..first + slots.len()].to_vec();
        let mut places = Vec::new();
        cells.for_each_point(|place| places.push(place));
        let mut local = Vec::with_capacity(places.len());
        cells.for_each_weight(|weights| {
            let vertex = match places[local.len()] {
                CornerOrigin::Side { side, step: 0 } => self.corner_vertex(region, first, side),
                CornerOrigin::Side { side, step } => self.seam_vertex(region, first, side, step),
                CornerOrigin::Inside => {
                    let weights = weights.iter().map(|&(k, w)| (k as usize, w));
                    let position = weights.clone().map(|(k, w)| slots[k].position * w).sum();
                    let normal: DVec3 = weights.map(|(k, w)| normals[k] * w).sum();
                    self.push_vertex(region.object, position, unit_or(normal, region.normal))
                }
            };
            local.push(vertex);
        });
        local
    }

    fn corner_vertex(&mut self, region: &Region, first: usize, corner: u32) -> u32 {
        let slot = self.outline.slots[first + corner as usize];
        let group = slot.corner_group as usize;
        if self.corner_vertex[group] == UNSEEN {
            let normal = self.normals[first + corner as usize];
            self.corner_vertex[group] = self.push_vertex(region.object, slot.position, normal);
        }
        self.corner_vertex[group]
    }

    /// The vertex `step` pieces along a side, 0 < step < the side's pieces.
    fn seam_vertex(&mut self, region: &Region, first: usize, side: u32, step: u32) -> u32 {
        let slot = self.outline.slots[first + side as usize];
        let count = self.division.edge_points.pieces[slot.edge as usize];
        let seam = slot.seam as usize;
        if self.seam_vertex[seam] == UNSEEN {
            self.seam_vertex[seam] = self.vertices.len() as u32;
            let next = first + (side as usize + 1) % region.slots.len();
            let (mut a, mut b) = (self.normals[first + side as usize], self.normals[next]);
            if !slot.forward {
                (a, b) = (b, a);
            }
            let edge = &self.outline.edges[slot.edge as usize];
            for i in 1..count {
                let t = self.division.edge_points.share(slot.edge, i);
                let normal = unit_or(a + t * (b - a), region.normal);
                self.push_vertex(region.object, edge.point(t), normal);
            }
        }
        let along = if slot.forward { step } else { count - step };
        self.seam_vertex[seam] + along - 1
    }

    /// Grid vertices of a primitive's part, in the order of `Primitive::tessellate`.
    fn part_vertices(&mut self, region: &Region, nu: u32, nv: u32) -> Vec<u32> {
        let outline = self.outline;
        let Shape::Primitive(primitive) = &outline.scene.objects[region.object as usize].shape
        else {
            return Vec::new();
        };
        let part = region.face as usize;
        let inset = Inset::new(primitive.kind, part);
        let mut local = Vec::with_capacity(SurfaceGrid { nu, nv }.vertices());
        for j in 0..=nv {
            for i in 0..=nu {
                let (u, v) = (f64::from(i) / f64::from(nu), f64::from(j) / f64::from(nv));
                let shown = primitive.point(part, u, v);
                let (gu, gv) = inset.pulled(u, v, nu, nv);
                let gathered = primitive.point(part, gu, gv);
                let vertex = self.push_vertex(region.object, shown.position, shown.normal);
                self.vertices[vertex as usize].gather = gathered.position;
                local.push(vertex);
            }
        }
        local
    }
}

/// Which borders of a part's parameters are creases, from which gather positions stay away.
struct Inset {
    u: bool,
    v_low: bool,
    v_high: bool,
}

impl Inset {
    fn new(kind: PrimitiveKind, part: usize) -> Inset {
        let flat = is_flat(kind);
        let cap = matches!(kind, PrimitiveKind::Cylinder | PrimitiveKind::Cone { .. }) && part > 0;
        let sphere = kind == PrimitiveKind::Sphere;
        Inset {
            u: flat,
            v_low: !sphere && !cap,
            v_high: !sphere,
        }
    }

    fn pulled(&self, u: f64, v: f64, nu: u32, nv: u32) -> (f64, f64) {
        let (du, dv) = (PULL * 0.5 / f64::from(nu), PULL * 0.5 / f64::from(nv));
        let u = if self.u { u.clamp(du, 1.0 - du) } else { u };
        let low = if self.v_low { dv } else { 0.0 };
        let high = if self.v_high { 1.0 - dv } else { 1.0 };
        (u, v.clamp(low, high))
    }
}

fn ascending([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

fn unit_or(v: DVec3, other: DVec3) -> DVec3 {
    v.try_normalize().unwrap_or(other)
}

/// Angle of a region's corner, radians.
fn corner_angle(outline: &Outline, region: &Region, slot: u32) -> f64 {
    let slots = outline.slots_of(region);
    let (n, k) = (slots.len(), (slot - region.slots.start) as usize);
    let [next, before] = [1, n - 1].map(|step| slots[(k + step) % n].position - slots[k].position);
    let (sine, cosine) = (next.cross(before).dot(region.normal), next.dot(before));
    // Beyond π at the reflex corner of a concave outline.
    sine.atan2(cosine).rem_euclid(std::f64::consts::TAU)
}

/// The file's normal at each slot, or the mean over the slot's smooth surface.
fn shading_normals(outline: &Outline) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; outline.slots.len()];
    for region in &outline.regions {
        for slot in region.slots.clone() {
            let group = outline.slots[slot as usize].corner_group as usize;
            sums[group] += corner_angle(outline, region, slot) * region.normal;
        }
    }
    let mut normals = vec![DVec3::ZERO; outline.slots.len()];
    for region in &outline.regions {
        let mesh = outline.mesh(region);
        for s in region.slots.clone() {
            let slot = &outline.slots[s as usize];
            let given = mesh.and_then(|m| m.normal(slot.corner as usize, slot.vertex));
            let normal = given.unwrap_or(sums[slot.corner_group as usize]);
            normals[s as usize] = unit_or(normal, region.normal);
        }
    }
    normals
}

/// For each object and given vertex the display vertices there, with the angles of their faces.
fn given_vertices(
    outline: &Outline,
    corner_vertex: &[u32],
    parted: &[SplitVertex],
) -> Vec<Lists<GivenVertex>> {
    let mut angles = vec![0.0; outline.slots.len()];
    for region in &outline.regions {
        for slot in region.slots.clone() {
            let group = outline.slots[slot as usize].corner_group as usize;
            angles[group] += corner_angle(outline, region, slot);
        }
    }
    let shown = |s: u32, shown: &mut Vec<(u32, GivenVertex)>| {
        let (vertex, weight) = (outline.slots[s as usize].vertex, angles[s as usize]);
        let display = corner_vertex[s as usize];
        // Split vertices ascend, object by object.
        let first = parted.partition_point(|p| p.from < display);
        let parts = parted[first..].iter().take_while(|p| p.from == display);
        let before = shown.len();
        shown.extend(parts.map(|p| {
            let (display, weight) = (p.into, weight * p.share);
            (vertex, GivenVertex { display, weight })
        }));
        if shown.len() == before {
            shown.push((vertex, GivenVertex { display, weight }));
        }
    };
    let object_vertices = |(object, o): (usize, &Object)| {
        let Some(mesh) = o.shape.mesh() else {
            return Lists::default();
        };
        let regions = outline.face_regions[outline.face_base[object] as usize] as usize
            ..outline.face_regions[outline.face_base[object + 1] as usize] as usize;
        let mut vertices = Vec::new();
        let slots = outline.regions[regions]
            .iter()
            .flat_map(|r| r.slots.clone());
        slots
            .filter(|&s| outline.slots[s as usize].corner_group == s)
            .for_each(|s| shown(s, &mut vertices));
        Lists::new(mesh.positions.len(), vertices.iter().copied())
    };
    let objects = outline.scene.objects.iter().enumerate();
    objects.map(object_vertices).collect()
}

fn area(patches: &Patches, i: usize) -> f64 {
    if patches.region(i).normal == DVec3::ZERO {
        curved_area(patches, i)
    } else {
        area_vector(&patches.corner_points(i)).length()
    }
}

/// Area by the Gauss–Legendre rule of 4 × 4 points; the area density of a cell is smooth.
fn curved_area(patches: &Patches, i: usize) -> f64 {
    const NODES: [(f64, f64); 4] = [
        (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
        (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
        (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
        (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
    ];
    let Cells::Part { nu, nv } = patches.cells[patches.owner[i] as usize] else {
        return 0.0;
    };
    let sum: f64 = NODES
        .iter()
        .flat_map(|&(s, ws)| NODES.map(|(t, wt)| (s, t, ws * wt)))
        .map(|(s, t, w)| w * patches.curved_point(i, s, t).area_density)
        .sum();
    sum / (f64::from(nu) * f64::from(nv))
}

/// Moves the gather positions of meshes away from their borders, and onto the triangles that the tracer sees of faces
/// that rounding has bent: behind them it is dark. No closer to borders than rounding may have moved what stands there.
fn pull_inward(patches: &mut Patches, roundings: &[f64]) {
    for v in 0..patches.vertices.len() {
        let object = patches.vertices[v].object as usize;
        if patches.primitives[object].is_none()
            && let Some((target, patch)) = inner_target(patches, v)
        {
            let position = patches.vertices[v].position;
            let inward = target - position;
            let share = PULL.max((ROUNDINGS * roundings[object] / inward.length()).min(MOST_PULL));
            let pulled = position + share * inward;
            let bent = patches.bent.get(&patches.owner[patch as usize]);
            let normal = patches.normal(patch as usize);
            let gather = bent.map_or(pulled, |triangles| onto(triangles, normal, pulled));
            patches.vertices[v].gather = gather;
        }
    }
}

/// The largest error of a coordinate of each object that has been rounded to single precision; 0 otherwise.
fn roundings(scene: &Scene) -> Vec<f64> {
    let single = |object: &Object| {
        let rounding = object.shape.coordinate_rounding();
        let is_single = rounding.digits == CoordinateDigits::Single;
        if is_single { rounding.error } else { 0.0 }
    };
    scene.objects.iter().map(single).collect()
}

/// The centre of the adjoining patches, weighted by corner angle, if they are coplanar; otherwise
/// the centre of the patch with the widest corner there. With a patch on whose plane it lies.
fn inner_target(patches: &Patches, v: usize) -> Option<(DVec3, u32)> {
    let position = patches.vertices[v].position;
    let around = patches.patches_at(v);
    let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
    let &first = around.first()?;
    let mut widest = (position, 0.0, first);
    let normal = patches.normal(first as usize);
    let mut flat = true;
    for &i in around {
        let (centre, angle) = (patches.centre(i as usize), angle_at(patches, i, v));
        flat &= patches.normal(i as usize).dot(normal) > COPLANAR_COSINE;
        sum += angle * centre;
        weight += angle;
        if angle > widest.1 {
            widest = (centre, angle, i);
        }
    }
    Some(if flat && weight > 0.0 {
        (sum / weight, first)
    } else {
        (widest.0, widest.2)
    })
}

fn angle_at(patches: &Patches, patch: u32, v: usize) -> f64 {
    let ring = patches.corner_vertices(patch as usize);
    let n = ring.len();
    let Some(k) = ring.iter().position(|&w| w as usize == v) else {
        return 0.0;
    };
    let at = |k: usize| patches.vertices[ring[k % n] as usize].position;
    (at(k + 1) - at(k)).angle_between(at(k + n - 1) - at(k))
}
