//! Proxy geometry: polygons in the place of exact shapes, for computing light.
//!
//! Patches are pieces of polygons. Prisms and the results of set operations are therefore divided
//! as polygons whose chords stay close to the exact surface, in proportion to the patch size: finer
//! polygons would only make more patches. The second pass renders the exact shapes and reads the
//! light from the proxy.

use crate::patch::PatchSize;
use azulejo_scene::{Exact, Mesh, Object, Scene, Shape, TriangleTree};
use azulejo_trace::Tracer;
use glam::DVec3;
use std::borrow::Cow;

/// Largest distance of chords from an exact shape, as a share of the patch size: as for primitives.
/// Solids much smaller than a patch still keep their form ([`Exact::tessellate`]).
pub const CHORD_ERROR: f64 = 0.02;

/// Chord error of the polygons from which areas are estimated, as a share of a shape's size.
const ROUGH: f64 = 0.01;

/// The scene that is divided into patches of a size: polygons in the place of exact shapes, or the
/// scene itself if it has none.
pub fn faceted(scene: &Scene, size: PatchSize) -> Cow<'_, Scene> {
    let is_exact = |o: &Object| matches!(o.shape, Shape::Exact(_));
    if !scene.objects.iter().any(is_exact) {
        return Cow::Borrowed(scene);
    }
    let chord_error = CHORD_ERROR * edge(scene, size);
    scene.faceted_by(|_| chord_error)
}

/// The edge length of patches; infinite where faces stay whole.
fn edge(scene: &Scene, size: PatchSize) -> f64 {
    let length = match size {
        PatchSize::Edge(edge) => edge,
        PatchSize::Count(count) | PatchSize::Squares(count) | PatchSize::FlatWhole(count) => {
            (area(scene) / count.max(1) as f64).sqrt()
        }
    };
    if length > 0.0 { length } else { f64::INFINITY }
}

fn area(scene: &Scene) -> f64 {
    let rough = |exact: &Exact| -> f64 {
        let areas = exact.areas(ROUGH * exact.bounds().diagonal());
        areas.values().sum()
    };
    let shape_area = |shape: &Shape| match shape {
        Shape::Mesh(_) | Shape::Instance(_) => shape.placed_mesh().map_or(0.0, |m| m.area()),
        Shape::Primitive(primitive) => primitive.area(),
        Shape::Exact(exact) => rough(exact),
    };
    scene.objects.iter().map(|o| shape_area(&o.shape)).sum()
}

/// A point and the side of a surface that receives light there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointNormal {
    /// World position.
    pub position: DVec3,
    /// Unit normal of the receiving side.
    pub normal: DVec3,
}

/// A scene of polygons and primitives with its tracer; both the caller's own where possible.
pub struct ProxyScene<'a> {
    /// The scene as the caller has it.
    pub given: &'a Scene,
    /// The scene with polygons in the place of exact shapes; `given` itself if it has none.
    pub scene: Cow<'a, Scene>,
    /// A tracer of `scene`.
    pub tracer: Cow<'a, Tracer>,
}

impl<'a> ProxyScene<'a> {
    /// The proxy of `given` for patches of `size`; `tracer` is one of `given`.
    pub fn new(given: &'a Scene, tracer: &'a Tracer, size: PatchSize) -> ProxyScene<'a> {
        let scene = faceted(given, size);
        let tracer = match &scene {
            Cow::Borrowed(_) => Cow::Borrowed(tracer),
            Cow::Owned(scene) => {
                let polygons = Tracer::with_kernel(scene, &tracer.kernel());
                Cow::Owned(polygons.repeated_as(tracer))
            }
        };
        ProxyScene {
            given,
            scene,
            tracer,
        }
    }

    /// Moves points on exact surfaces that lie behind the proxy polygons onto these: from inside
    /// they would see nothing.
    pub fn on_polygons(&self, points: &[PointNormal]) -> Vec<PointNormal> {
        let objects = self.given.objects.iter().zip(&self.scene.objects);
        let meshes: Vec<ProxyMesh> = objects
            .filter_map(|(given, polygons)| match (&given.shape, &polygons.shape) {
                (Shape::Exact(_), Shape::Mesh(mesh)) => Some(ProxyMesh::new(mesh)),
                _ => None,
            })
            .collect();
        let moved = |p: &PointNormal| meshes.iter().fold(*p, |p, mesh| mesh.before(p));
        points.iter().map(moved).collect()
    }
}

/// The polygons of one exact shape.
struct ProxyMesh {
    tree: TriangleTree,
    /// Points farther behind the polygons than this are inside the shape, and stay there.
    reach: f64,
}

impl ProxyMesh {
    fn new(mesh: &Mesh) -> ProxyMesh {
        ProxyMesh {
            tree: TriangleTree::new(mesh),
            reach: CHORD_ERROR * mesh.bounds().diagonal(),
        }
    }

    fn before(&self, point: PointNormal) -> PointNormal {
        let near = self.tree.nearest(point.position, point.normal);
        let behind = |p: DVec3| (p - point.position).dot(point.normal) > 0.0;
        match near.filter(|n| n.distance <= self.reach && behind(n.position)) {
            Some(on) => PointNormal {
                position: on.position,
                ..point
            },
            None => point,
        }
    }
}
