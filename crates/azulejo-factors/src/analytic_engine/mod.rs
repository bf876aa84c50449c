//! The analytic engine: exchange areas of all pairs of flat facets.
//!
//! Facets are clustered ([`cluster_tree`](crate::cluster_tree)), so that one test of two clusters and the shaft between
//! them accepts or rejects thousands of pairs ([`traversal`], [`shaft`]). Facets that cast shadows
//! are merged into large convex ones ([`convex_merge`], [`occluders`]). Unoccluded pairs take
//! Gauss's rule ([`gauss_points`]) or, when close, a contour integral; partially occluded ones are
//! cut along the discontinuities of the view ([`partial`]). Chains of planar mirrors are traversed
//! in the same way, as images behind windows ([`images`]). What lies in one plane within the rounding of
//! coordinates does so exactly ([`planes`]). [`horizon`] tells light that leaves
//! upwards from the rest, and [`slabs`] does so where facets touch. [`work`] counts what all of this costs.
//! [`check`] compares rows with a few rays. [`exchanger`] distributes the rows
//! over threads.

pub(crate) mod check;
mod convex_merge;
pub(crate) mod estimator;
pub(crate) mod exchanger;
mod gauss_points;
mod horizon;
mod images;
mod occluders;
mod partial;
pub(crate) mod planes;
mod shaft;
mod slabs;
mod traversal;
mod work;

use crate::analytic::gauss;
use crate::cluster_tree::{ClusterNode, ClusterTree};
use azulejo_scene::math::{Aabb, area_vector};
use azulejo_trace::lambert::clip;
use gauss_points::GaussPoints;
use glam::DVec3;
use planes::SurfacePlane;

/// Most facets per leaf of a tree.
const LEAF: usize = 4;

/// Most corners of a facet: a quadrilateral clipped twice, by a mirror and by another facet.
const MOST_CORNERS: usize = 6;

/// A flat, convex, one-sided piece of surface.
#[derive(Clone, Debug)]
pub(crate) struct Facet {
    corners: [DVec3; MOST_CORNERS],
    count: usize,
    /// Its row and column.
    pub id: u32,
    /// Unit normal of its visible side, and the offset of its plane.
    normal: DVec3,
    offset: f64,
    centre: DVec3,
    /// Distance of the furthest corner from the centre.
    radius: f64,
    area: f64,
}

impl Facet {
    /// A facet, counter-clockwise about `normal`; a clipped one keeps the normal of the whole.
    fn new(id: u32, corners: &[DVec3], normal: DVec3) -> Facet {
        let count = corners.len().min(MOST_CORNERS);
        let mut kept = [DVec3::ZERO; MOST_CORNERS];
        kept[..count].copy_from_slice(&corners[..count]);
        let centre = corners.iter().sum::<DVec3>() / corners.len().max(1) as f64;
        let radius = corners
            .iter()
            .map(|c| c.distance(centre))
            .fold(0.0, f64::max);
        Facet {
            corners: kept,
            count,
            id,
            normal,
            offset: corners.first().map_or(0.0, |c| c.dot(normal)),
            centre,
            radius,
            area: area_vector(corners).length(),
        }
    }

    /// The same facet in the plane that it lies in together with others.
    fn in_plane(self, plane: SurfacePlane) -> Facet {
        Facet {
            normal: plane.normal,
            offset: plane.offset,
            ..self
        }
    }

    /// The part in front of another's plane, if there is any.
    fn in_front_of(&self, other: &Facet, graze: f64) -> Option<Facet> {
        let heights = || self.polygon().iter().map(|&p| other.height(p));
        if heights().all(|h| h <= graze) {
            None
        } else if heights().all(|h| h >= -graze) {
            Some(self.clone())
        } else {
            let part = clip(self.polygon(), other.corners[0], other.normal);
            let part = Facet::new(self.id, &part, self.normal);
            Some(part).filter(|part| part.count > 2)
        }
    }

    fn polygon(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    fn is_empty(&self) -> bool {
        self.count == 0
    }

    fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }
}

/// Facets in the order of a tree over them, with precomputed clusters and Gauss points.
#[derive(Debug)]
pub(crate) struct FacetTree {
    tree: ClusterTree,
    /// By position in the tree.
    list: Vec<Facet>,
    /// By node.
    clusters: Vec<Cluster>,
    four: GaussPoints<4>,
    nine: GaussPoints<9>,
}

impl FacetTree {
    fn new(facets: &[Facet], size: f64) -> FacetTree {
        let centres_and_normals: Vec<_> = facets.iter().map(|f| (f.centre, f.normal)).collect();
        let tree = ClusterTree::new(&centres_and_normals, size, LEAF);
        let list = tree.order.iter().map(|&i| facets[i as usize].clone());
        let list = list.collect();
        FacetTree::with_tree(tree, list)
    }

    /// A few facets without a tree.
    fn without_tree(list: Vec<Facet>) -> FacetTree {
        FacetTree::with_tree(ClusterTree::default(), list)
    }

    fn with_tree(tree: ClusterTree, list: Vec<Facet>) -> FacetTree {
        let cluster = |node: &ClusterNode| {
            Cluster::new(&list[node.range.start as usize..node.range.end as usize])
        };
        let (mut four, mut nine) = (GaussPoints::new(), GaussPoints::new());
        for facet in &list {
            four.push(facet.polygon(), facet.normal);
            nine.push(facet.polygon(), facet.normal);
        }
        FacetTree {
            clusters: tree.nodes.iter().map(cluster).collect(),
            tree,
            list,
            four,
            nine,
        }
    }
}

/// Bounds of a group of facets.
#[derive(Clone, Debug)]
struct Cluster {
    bounds: Aabb,
    /// Mean of the normals, and the largest angle of a normal to it.
    axis: DVec3,
    spread: f64,
    /// Offsets of their planes along the axis, if all are parallel.
    offsets: Option<[f64; 2]>,
    most_radius: f64,
    first_id: u32,
    last_id: u32,
    /// Whether precomputed Gauss points are valid: no facet was clipped to more than four corners.
    is_plain: bool,
}

/// How the facets of one cluster are oriented towards the points of another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Facing {
    /// All facets face away from all points.
    Away,
    /// All facets face all points.
    Towards,
    Mixed,
}

/// Angle below which normals count as equal.
const PARALLEL: f64 = 1e-9;

impl Cluster {
    fn new<'a>(facets: impl IntoIterator<Item = &'a Facet> + Clone) -> Cluster {
        let present = || facets.clone().into_iter().filter(|f| !f.is_empty());
        let axis = present()
            .map(|f| f.normal)
            .sum::<DVec3>()
            .normalize_or_zero();
        // The chord is more accurate than the cosine for small angles.
        let angle = |n: DVec3| 2.0 * (0.5 * n.distance(axis)).min(1.0).asin();
        let spread = present().map(|f| angle(f.normal)).fold(0.0, f64::max);
        let offsets = present().map(|f| f.offset);
        let ends = offsets.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], d| {
            [low.min(d), high.max(d)]
        });
        Cluster {
            bounds: Aabb::around(present().flat_map(|f| f.polygon()).copied()),
            axis,
            spread,
            offsets: (spread <= PARALLEL).then_some(ends),
            most_radius: present().map(|f| f.radius).fold(0.0, f64::max),
            first_id: present().map(|f| f.id).min().unwrap_or(u32::MAX),
            last_id: present().map(|f| f.id).max().unwrap_or(0),
            is_plain: present().all(|f| f.count <= 4),
        }
    }

    fn is_empty(&self) -> bool {
        self.bounds.is_empty()
    }

    fn facing(&self, other: &Aabb, graze: f64) -> Facing {
        let (centre, half) = (other.centre(), 0.5 * other.size());
        if let Some([low, high]) = self.offsets {
            let (middle, reach) = (self.axis.dot(centre), self.axis.abs().dot(half));
            return if middle + reach <= low + graze {
                Facing::Away
            } else if middle - reach >= high - graze {
                Facing::Towards
            } else {
                Facing::Mixed
            };
        }
        let way = centre - self.bounds.centre();
        let (distance, reach) = (way.length(), half.length() + 0.5 * self.bounds.diagonal());
        if distance <= reach {
            return Facing::Mixed;
        }
        let angle = (self.axis.dot(way) / distance).clamp(-1.0, 1.0).acos();
        let height = |angle: f64| distance * angle.clamp(0.0, std::f64::consts::PI).cos();
        if height(angle - self.spread) + reach <= 0.0 {
            Facing::Away
        } else if height(angle + self.spread) - reach >= 0.0 {
            Facing::Towards
        } else {
            Facing::Mixed
        }
    }
}

/// `N` Gauss points, a square number, of a triangle or quadrilateral; zero weights for other
/// polygons.
fn gauss_square<const N: usize>(polygon: &[DVec3], normal: DVec3) -> [(DVec3, f64); N] {
    let &[a, b, c, d] = match polygon {
        [a, b, c] => &[*a, *b, *c, *c],
        [a, b, c, d] => &[*a, *b, *c, *d],
        // Some finite point: it neither counts nor divides by zero.
        _ => return [(polygon.first().copied().unwrap_or_default(), 0.0); N],
    };
    let rule = gauss(N.isqrt());
    let (ab, ad, twist) = (b - a, d - a, a - b + c - d);
    std::array::from_fn(|k| {
        let ((u, weight_u), (v, weight_v)) = (rule[k % rule.len()], rule[k / rule.len()]);
        let jacobian = (ab + v * twist).cross(ad + u * twist).dot(normal);
        let point = a + u * ab + v * ad + u * v * twist;
        (point, weight_u * weight_v * jacobian)
    })
}
