//! Patches: the faces of a scene divided into pieces that each have one radiosity.
//!
//! Every edge that faces share, also faces of different objects, is divided at the same points, bit
//! for bit, so there are no T-junctions. Flat quadrilaterals become grids, triangles become
//! congruent triangles; other faces (unequal opposite sides, more corners, concave outlines) are
//! triangulated. So are faces that others touch or cross inside: no patch lies across such a
//! contact line, and each of its sides has display vertices of its own. Exact primitives become
//! cells of their parameters and are sampled on the exact surface.
//!
//! | module | purpose |
//! |---|---|
//! | `outline` | flat regions, shared edges, smooth surfaces |
//! | `contacts`, `box_pairs` | where faces touch or cross each other inside |
//! | `lines` | contact lines at a patch size |
//! | `divide`, `edge_points` | number and positions of the pieces of each edge |
//! | `cells`, `irregular`, `lattice`, `ring`, `constrained_delaunay` | the division of a region |
//! | `vertex_split` | display vertices on both sides of a contact |
//! | `build` | patches, their corners and the display vertices |
//! | `locate` | from a hit to its patch |
//! | `sample` | random points of a patch |
//! | `facets` | flat triangles that approximate curved patches for item buffers |
//! | `refined` | the divided mesh |

mod bent;
mod box_pairs;
mod build;
mod cells;
mod constrained_delaunay;
#[cfg(test)]
mod contact_tests;
mod contacts;
mod divide;
mod edge_points;
mod facets;
mod flaws;
mod irregular;
mod lattice;
mod lines;
mod locate;
mod outline;
mod refined;
mod reflectance;
mod ring;
mod sample;
#[cfg(test)]
mod tests;
mod vertex_split;

pub(crate) use facets::PatchFacets;
pub use refined::RefinedShape;
pub use reflectance::reflectances;
pub use sample::{PatchPoint, Sampler};

use azulejo_scene::math::area_vector;
use azulejo_scene::{Material, MaterialId, Primitive, Rgb, Scene};
use bent::BentRegions;
use cells::{Cells, NO_CORNER};
use contacts::Contacts;
use divide::Division;
use glam::DVec3;
use locate::Locator;
use outline::Outline;
use std::ops::Range;

/// The size of patches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PatchSize {
    /// About this many patches in the whole scene, to within 10% where faces and contacts allow it.
    /// Faces need patches even if they stay whole: one for a triangle or quadrilateral, more where
    /// the outline is not convex. If these are more than half of the count, half of it is added to
    /// them for dividing the largest faces. So however many letters or details a scene has, the
    /// room around them is divided.
    Count(usize),
    /// The edge of squares of which this many have the total area of all surfaces. Finer faces stay
    /// whole, so a detailed figure does not make the patches of the room around it coarser.
    Squares(usize),
    /// Flat faces stay whole; curved ones are divided as by `Squares`: for sums over many patches, which do not
    /// depend on the division.
    FlatWhole(usize),
    /// The longest edge, in scene units. Exact for edges of faces and for regular patterns; inner
    /// edges of irregular triangles may be up to 1.5 times as long. If not positive, faces stay
    /// whole.
    Edge(f64),
}

/// A face of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FaceId {
    /// Index among the scene's objects.
    pub object: u32,
    /// Index among the mesh's faces, or the part of an exact primitive.
    pub face: u32,
}

/// A point at which irradiance is computed and shown.
///
/// Corners of patches of one object share a display vertex if they coincide and the surface is
/// smooth there: irradiance never bleeds over a crease, nor over a line along which another face
/// touches or crosses this one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplayVertex {
    /// Index among the scene's objects.
    pub object: u32,
    /// World position.
    pub position: DVec3,
    /// Unit shading normal of the front: the file's, interpolated, or else the mean of the
    /// smooth surface's faces, weighted by angle.
    pub normal: DVec3,
    /// Where irradiance is gathered: `position` moved a thousandth of the way to the centre of the
    /// adjoining patches, so that it does not lie in an adjoining wall. On a flat surface that
    /// makes hardly any difference; on a bent one it lies in a single patch.
    pub gather: DVec3,
}

/// A display vertex of a vertex of the given mesh, one of several at a crease.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GivenVertex {
    /// Index of the display vertex, which has the normal and the gather position.
    pub display: u32,
    /// Sum of the corner angles of its faces, radians: its weight in a mean over the vertex.
    pub weight: f64,
}

/// The patches of a scene, numbered face by face and object by object.
///
/// Faces without area, or with corners that are not finite, have no patch. Flat patches lie
/// within 1e-5 of their face's diameter of the triangles that the tracer sees.
pub struct Patches {
    /// Corners of each patch among `vertices`; the fourth may be `NO_CORNER`.
    corners: Vec<[u32; 4]>,
    areas: Vec<f64>,
    /// The mean of the picture that each patch emits; `None` if none emits one.
    emitted_pictures: Option<Vec<Rgb>>,
    /// Region of each patch.
    owner: Vec<u32>,
    regions: Vec<FlatRegion>,
    /// Corners of the regions, counted over all corners of their mesh.
    region_corners: Vec<u32>,
    /// The division of each region.
    cells: Vec<Cells>,
    /// First patch of each region, and the total.
    region_patches: Vec<u32>,
    /// Triangles of regions that are not exactly flat.
    bent: BentRegions,
    /// For each object its primitive, if it is one.
    primitives: Vec<Option<Primitive>>,
    /// First patch of each object, and the total.
    object_patches: Vec<u32>,
    /// First vertex of each object, and the total.
    object_vertices: Vec<u32>,
    vertices: Vec<DisplayVertex>,
    /// Patches around each vertex.
    around: Lists<u32>,
    /// For each object's given vertices their display vertices.
    given: Vec<Lists<GivenVertex>>,
    /// First face of each object, and the total.
    face_base: Vec<u32>,
    /// First region of each face, and the total.
    face_regions: Vec<u32>,
    locator: Locator,
}

/// What patches share with their region.
struct FlatRegion {
    face: FaceId,
    material: MaterialId,
    /// Unit normal; zero for parts of primitives.
    normal: DVec3,
    /// Its corners, among [`Patches::region_corners`].
    corners: Range<u32>,
}

/// Lists of different lengths, stored consecutively.
#[derive(Default)]
struct Lists<T> {
    starts: Vec<u32>,
    items: Vec<T>,
}

impl<T: Copy + Default> Lists<T> {
    /// Distributes `(list, item)` pairs over `count` lists; items keep their order.
    fn new(count: usize, pairs: impl Iterator<Item = (u32, T)> + Clone) -> Lists<T> {
        let mut starts = vec![0u32; count + 1];
        pairs.clone().for_each(|p| starts[p.0 as usize + 1] += 1);
        for i in 0..count {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut items = vec![T::default(); starts[count] as usize];
        for (list, item) in pairs {
            items[next[list as usize] as usize] = item;
            next[list as usize] += 1;
        }
        Lists { starts, items }
    }

    fn get(&self, list: usize) -> &[T] {
        match (self.starts.get(list), self.starts.get(list + 1)) {
            (Some(&a), Some(&b)) => &self.items[a as usize..b as usize],
            _ => &[],
        }
    }
}

/// Three or four corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polygon {
    points: [DVec3; 4],
    count: usize,
}

impl std::ops::Deref for Polygon {
    type Target = [DVec3];
    fn deref(&self) -> &[DVec3] {
        &self.points[..self.count]
    }
}

impl Patches {
    /// Divides the faces of a scene into at most about 2^24 patches, or one per face if there are
    /// more faces. Never panics on a valid scene.
    pub fn new(scene: &Scene, size: PatchSize) -> Patches {
        let outline = Outline::new(scene);
        let contacts = Contacts::new(&outline);
        let division = Division::new(&outline, &contacts, size);
        build::build(&outline, &contacts, division)
    }

    /// Number of patches.
    pub fn len(&self) -> usize {
        self.corners.len()
    }

    /// Whether no face of the scene has any area.
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// Area in square scene units, > 0; of the exact surface for curved patches.
    pub fn area(&self, i: usize) -> f64 {
        self.areas[i]
    }

    /// Material of the patch's face.
    pub fn material(&self, i: usize) -> MaterialId {
        self.region(i).material
    }

    /// Mean radiance that a side of a patch emits, W/(sr·m²), if `material` is that of the patch.
    pub fn emission(&self, i: usize, material: &Material, front: bool) -> Rgb {
        let emitted = material.emission_from(front);
        match &self.emitted_pictures {
            Some(means) if !emitted.is_black() => emitted * means[i],
            _ => emitted,
        }
    }

    /// The materials of the scene that some patch has; a scene may list others.
    pub fn materials_in_use<'a>(&self, scene: &'a Scene) -> Vec<&'a Material> {
        let mut ids: Vec<MaterialId> = (0..self.len()).map(|i| self.material(i)).collect();
        ids.sort_unstable();
        ids.dedup();
        ids.iter()
            .map(|&id| &scene.materials[id as usize])
            .collect()
    }

    /// The face that the patch is a piece of.
    pub fn face(&self, i: usize) -> FaceId {
        self.region(i).face
    }

    /// Centroid of a flat patch; the point at the middle of its parameters for a curved one.
    pub fn centre(&self, i: usize) -> DVec3 {
        match self.polygon(i).as_deref() {
            Some(&[a, b, c]) => (a + b + c) / 3.0,
            Some(&[a, b, c, d]) => {
                let half = |p, q, r| area_vector(&[p, q, r]).length();
                let (first, second) = (half(a, b, c), half(a, c, d));
                ((a + b + c) * first + (a + c + d) * second) / (3.0 * (first + second))
            }
            _ => self.curved_point(i, 0.5, 0.5).position,
        }
    }

    /// Unit normal of the front; for a curved patch that of its centre.
    pub fn normal(&self, i: usize) -> DVec3 {
        let region = self.region(i);
        if region.normal == DVec3::ZERO {
            self.curved_point(i, 0.5, 0.5).normal
        } else {
            region.normal
        }
    }

    /// The longest distance between two corners.
    pub fn diameter(&self, i: usize) -> f64 {
        let points = self.corner_points(i);
        let distances = points
            .iter()
            .enumerate()
            .flat_map(|(k, p)| points[..k].iter().map(move |q| p.distance(*q)));
        distances.fold(0.0, f64::max)
    }

    /// The corners of a flat patch, counter-clockwise from the front; `None` for a curved one.
    pub fn polygon(&self, i: usize) -> Option<Polygon> {
        let mut polygon = self.corner_points(i);
        let region = self.region(i);
        if let Some(primitive) = &self.primitives[region.face.object as usize] {
            if !locate::is_flat(primitive.kind) {
                return None;
            }
            // The parameters of some parts are clockwise.
            let normal = self.curved_point(i, 0.5, 0.5).normal;
            if area_vector(&polygon).dot(normal) < 0.0 {
                polygon.points.swap(1, 3);
            }
        }
        Some(polygon)
    }

    /// The corners of a patch: those of its [`polygon`](Patches::polygon), or of a curved one those
    /// on its surface, counter-clockwise from the front.
    pub fn corner_positions(&self, i: usize) -> Vec<DVec3> {
        let polygon = self.polygon(i).unwrap_or_else(|| {
            let mut corners = self.corner_points(i);
            if area_vector(&corners).dot(self.normal(i)) < 0.0 {
                let count = corners.count;
                corners.points[1..count].reverse();
            }
            corners
        });
        polygon.to_vec()
    }

    /// Indices of the display vertices at the 3 or 4 corners of a patch, in the order of
    /// [`polygon`](Patches::polygon); on an exact primitive, in the direction of its `u`, `v`.
    pub fn corner_vertices(&self, i: usize) -> &[u32] {
        let corners = &self.corners[i];
        let count = if corners[3] == NO_CORNER { 3 } else { 4 };
        &corners[..count]
    }

    /// The patches of an object; empty for an object that does not exist.
    pub fn patches_of(&self, object: u32) -> Range<usize> {
        between(&self.object_patches, object as usize)
    }

    /// The patches of a face; empty for a face that does not exist.
    pub fn patches_of_face(&self, face: FaceId) -> Range<usize> {
        let faces = between(&self.face_base, face.object as usize);
        let index = faces.start + face.face as usize;
        if index >= faces.end {
            return 0..0;
        }
        let regions = between(&self.face_regions, index);
        self.region_patches[regions.start] as usize..self.region_patches[regions.end] as usize
    }

    /// All display vertices, object by object; within an object the vertices of its refined mesh in
    /// order, or the grid vertices of its parts.
    pub fn vertices(&self) -> &[DisplayVertex] {
        &self.vertices
    }

    /// The display vertices of an object; empty for an object that does not exist.
    pub fn vertices_of(&self, object: u32) -> Range<usize> {
        between(&self.object_vertices, object as usize)
    }

    /// The patches of the same smooth surface that meet at a display vertex.
    pub fn patches_at(&self, vertex: usize) -> &[u32] {
        self.around.get(vertex)
    }

    /// The display vertices of vertex `vertex` of an object's given mesh: one, more at a crease,
    /// none if no face with area uses it.
    pub fn given_vertices(&self, object: u32, vertex: u32) -> &[GivenVertex] {
        self.given
            .get(object as usize)
            .map_or(&[], |lists| lists.get(vertex as usize))
    }

    /// The flat piece of a face that a patch is a piece of.
    pub(crate) fn region_number(&self, i: usize) -> u32 {
        self.owner[i]
    }

    fn region(&self, i: usize) -> &FlatRegion {
        &self.regions[self.owner[i] as usize]
    }

    fn corner_points(&self, i: usize) -> Polygon {
        let corners = self.corner_vertices(i);
        let mut points = [DVec3::ZERO; 4];
        for (p, &v) in points.iter_mut().zip(corners) {
            *p = self.vertices[v as usize].position;
        }
        Polygon {
            points,
            count: corners.len(),
        }
    }
}

/// Entry `i` of a list of starts as a range; empty when out of range.
fn between(starts: &[u32], i: usize) -> Range<usize> {
    match (starts.get(i), starts.get(i + 1)) {
        (Some(&a), Some(&b)) => a as usize..b as usize,
        _ => 0..0,
    }
}
