//! The world prepared for drawing: packets of facets under a tree of boxes.

use super::view::{LocalMirror, PatchOptics, Plane, UnitCube};
use super::{Facet, World};
use crate::kernel::{BinaryNode, Reference, binary_tree};
use glam::DVec3;
use std::collections::HashMap;

/// Facets in a packet.
pub(super) const LANES: usize = 8;
/// A node of the binary tree with no more facets than this is a leaf.
const LEAF: usize = 2 * LANES;
/// Facets thinner than this, relative to their longest edge, are left out: they cover no pixel, and
/// their planes are mere rounding.
const THINNEST: f64 = 1e-9;
/// Planes closer than this in normal and offset are merged, so that coplanar facets have the same
/// depth. Relative to half the world's size.
const SAME_PLANE: f64 = 1.0 / (1u64 << 27) as f64;
/// Boxes are enlarged by this much, for the rounding of projections.
const BOX_SLACK: f32 = 4e-6;

/// Facets side by side.
pub(super) struct FacetPacket {
    /// Coordinates, `[3 * corner + axis][lane]`; NaN in lanes that are not in use.
    pub corners: [[f32; LANES]; 9],
    pub facets: [PlaneFacet; LANES],
}

/// The properties of a facet besides its corners.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PlaneFacet {
    pub patch: u32,
    /// Its plane.
    pub plane: u32,
    /// Whether the plane's normal points to the front.
    pub is_upright: bool,
}

/// A box, and the packets in it if it is a leaf. A node is followed by its first child.
pub(super) struct FacetNode {
    pub centre: [f32; 3],
    pub half: [f32; 3],
    /// Distance to the second child; 0 for a leaf.
    pub second: u32,
    /// Packets of a leaf.
    pub packets: [u32; 2],
}

/// A prepared world. Immutable.
pub(super) struct LocalWorld {
    pub local: UnitCube,
    pub nodes: Vec<FacetNode>,
    pub packets: Vec<FacetPacket>,
    pub planes: Vec<Plane>,
    pub mirrors: Vec<LocalMirror>,
    pub up: DVec3,
    pub patches: u32,
    optics: Vec<PatchOptics>,
}

impl LocalWorld {
    /// Prepares a world. Facets with a corner that is not finite, without area, or of nonexistent
    /// patches are left out.
    pub fn new(world: &World) -> LocalWorld {
        let is_sound = |corners: &[DVec3; 3]| corners.iter().all(|c| c.is_finite());
        let is_drawn = |t: &&Facet| t.patch < world.patches && is_sound(&t.corners);
        let drawn = || world.triangles.iter().filter(is_drawn);
        let local = UnitCube::around(drawn().flat_map(|t| t.corners));
        let mut planes = DistinctPlanes::default();
        let mut facets = Vec::new();
        for t in drawn() {
            let corners = t.corners.map(|c| local.point(c));
            if let Some((plane, is_upright)) = planes.of(corners) {
                let facet = PlaneFacet {
                    patch: t.patch,
                    plane,
                    is_upright,
                };
                facets.push((corners.map(|c| c.as_vec3().to_array()), facet));
            }
        }
        let (nodes, packets) = tree(&facets);
        let mirrors = world.mirrors.iter().map(|m| LocalMirror::new(m, &local));
        LocalWorld {
            local,
            nodes,
            packets,
            planes: planes.planes,
            mirrors: mirrors.collect(),
            up: world.up,
            patches: world.patches,
            optics: (0..world.patches).map(|p| world.optics(p)).collect(),
        }
    }

    pub fn optics(&self, patch: u32) -> PatchOptics {
        self.optics[patch as usize]
    }
}

/// The distinct planes of facets.
#[derive(Default)]
struct DistinctPlanes {
    planes: Vec<Plane>,
    known: HashMap<[i64; 4], u32>,
}

impl DistinctPlanes {
    /// Number of the plane through three corners, and whether they turn counter-clockwise about
    /// its normal; `None` if they span none.
    fn of(&mut self, [a, b, c]: [DVec3; 3]) -> Option<(u32, bool)> {
        let across = (b - a).cross(c - a);
        let longest = [b - a, c - b, a - c]
            .map(DVec3::length_squared)
            .into_iter()
            .fold(0.0, f64::max);
        // Twice the area is height times longest edge. Written so that NaN fails.
        let is_wide = across.length() > THINNEST * longest;
        if !is_wide {
            return None;
        }
        let normal = across.normalize();
        // The sign does not depend on the facet's front, but on the first significant component.
        let first = normal.to_array().into_iter().find(|x| x.abs() > 1e-4)?;
        let is_upright = first > 0.0;
        let normal = if is_upright { normal } else { -normal };
        let offset = normal.dot((a + b + c) / 3.0);
        let step = |x: f64| (x / SAME_PLANE).round() as i64;
        let key = [normal.x, normal.y, normal.z, offset].map(step);
        let next = self.planes.len() as u32;
        let number = *self.known.entry(key).or_insert(next);
        if number == next {
            self.planes.push(Plane { normal, offset });
        }
        Some((number, is_upright))
    }
}

type LocalFacet = ([[f32; 3]; 3], PlaneFacet);

fn tree(facets: &[LocalFacet]) -> (Vec<FacetNode>, Vec<FacetPacket>) {
    let reference = |(i, (corners, _)): (usize, &LocalFacet)| {
        let [a, b, c] = *corners;
        let low = [0, 1, 2].map(|k| a[k].min(b[k]).min(c[k]));
        let high = [0, 1, 2].map(|k| a[k].max(b[k]).max(c[k]));
        Reference::new(low, high, i as u32)
    };
    let mut references: Vec<Reference> = facets.iter().enumerate().map(reference).collect();
    let binary = binary_tree(&mut references, facets.len() as u32);
    let mut grown = Grown {
        facets,
        references: &references,
        binary: &binary,
        nodes: Vec::new(),
        packets: Vec::new(),
    };
    if !binary.is_empty() {
        grown.add(0);
    }
    (grown.nodes, grown.packets)
}

/// Converts the tree to one whose leaves are packets.
struct Grown<'a> {
    facets: &'a [LocalFacet],
    references: &'a [Reference],
    binary: &'a [BinaryNode],
    nodes: Vec<FacetNode>,
    packets: Vec<FacetPacket>,
}

impl Grown<'_> {
    fn add(&mut self, index: usize) {
        let source = &self.binary[index];
        let (low, high) = (source.bounds.min, source.bounds.max);
        let at = self.nodes.len();
        self.nodes.push(FacetNode {
            centre: [0, 1, 2].map(|k| 0.5 * (low[k] + high[k])),
            half: [0, 1, 2].map(|k| 0.5 * (high[k] - low[k]) + BOX_SLACK),
            second: 0,
            packets: [0; 2],
        });
        let range = source.range();
        if source.is_leaf() || range.len() <= LEAF {
            let first = self.packets.len() as u32;
            for chunk in self.references[range].chunks(LANES) {
                let chunk = chunk.iter().map(|r| &self.facets[r.id() as usize]);
                self.packets.push(FacetPacket::new(chunk));
            }
            self.nodes[at].packets = [first, self.packets.len() as u32];
        } else {
            let right = source.right as usize;
            self.add(index + 1);
            self.nodes[at].second = (self.nodes.len() - at) as u32;
            self.add(index + right);
        }
    }
}

impl FacetPacket {
    fn new<'a>(facets: impl Iterator<Item = &'a LocalFacet>) -> FacetPacket {
        let mut packet = FacetPacket {
            corners: [[f32::NAN; LANES]; 9],
            facets: [PlaneFacet::default(); LANES],
        };
        for (lane, (corners, facet)) in facets.enumerate() {
            for (row, x) in packet.corners.iter_mut().zip(corners.iter().flatten()) {
                row[lane] = *x;
            }
            packet.facets[lane] = *facet;
        }
        packet
    }

    /// The corners in a lane.
    pub fn corners_of(&self, lane: usize) -> [[f32; 3]; 3] {
        [0, 3, 6].map(|first| [0, 1, 2].map(|axis| self.corners[first + axis][lane]))
    }
}
