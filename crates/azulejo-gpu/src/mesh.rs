//! A world in the card's memory: clusters of nearby facets under a tree of boxes, which finds the
//! clusters that may be visible in a face.

use crate::pipelines::CORNER_WORDS;
use crate::shared::Shared;
use azulejo_trace::item_buffer::{
    DrawError, Facet, LocalMirror, NO_MIRROR, PatchOptics, Plane, UnitCube, World,
};
use glam::DVec3;
use std::collections::HashMap;
use std::ops::Range;

/// Facets thinner than this, relative to their longest edge, are left out: they cover no pixel, and
/// their planes are mere rounding.
const THINNEST: f64 = 1e-9;
/// Planes closer than this in normal and offset are merged, so that coplanar facets have the same
/// depth. Relative to half the world's size.
const SAME_PLANE: f64 = 1.0 / (1u64 << 27) as f64;
/// Boxes are enlarged by this much, for the rounding of projections.
const BOX_SLACK: f64 = 4e-6;
/// Size of a facet in bytes.
const FACET_BYTES: u64 = 3 * 4 * CORNER_WORDS as u64;
/// Largest size of a buffer in bytes, unless the card allows less.
const MOST_BYTES: u64 = 256 << 20;

/// A world on the card. Immutable.
pub struct Mesh {
    pub local: UnitCube,
    pub patches: u32,
    pub up: DVec3,
    pub mirrors: Vec<LocalMirror>,
    optics: Vec<PatchOptics>,
    /// Vertices, in as many buffers as the card's limits require.
    buffers: Vec<wgpu::Buffer>,
    clusters: Clusters,
    facets: u32,
    /// Facets in every buffer but the last.
    facets_per_buffer: u32,
}

impl Mesh {
    /// Copies a world to the card. Facets with a corner that is not finite, without area, or of
    /// nonexistent patches are left out.
    ///
    /// # Errors
    /// [`DrawError::TooLarge`].
    pub fn new(shared: &Shared, world: &World, cluster: u32) -> Result<Mesh, DrawError> {
        let sound: Vec<&Facet> = world
            .triangles
            .iter()
            .filter(|t| t.patch < world.patches && t.corners.iter().all(|c| c.is_finite()))
            .collect();
        let local = UnitCube::around(sound.iter().flat_map(|t| t.corners));
        let optics: Vec<PatchOptics> = (0..world.patches).map(|p| world.optics(p)).collect();
        let facets = prepared(&sound, &local, &optics);
        let per_buffer = shared.limits.max_buffer_size.min(MOST_BYTES) / FACET_BYTES;
        // A buffer has whole clusters, and one at least.
        let cluster = cluster.min(per_buffer as u32).max(1);
        let clusters = Clusters::new(&facets, cluster);
        let per_buffer = per_buffer as u32 / cluster * cluster;
        if per_buffer == 0 {
            let most = shared.limits.max_buffer_size;
            let error = format!("a facet, but its buffers are limited to {most} bytes");
            return Err(DrawError::TooLarge(error));
        }
        let mirror = |m| LocalMirror::new(m, &local);
        Ok(Mesh {
            local,
            patches: world.patches,
            up: world.up,
            mirrors: world.mirrors.iter().map(mirror).collect(),
            optics,
            buffers: upload(shared, &facets, per_buffer)?,
            clusters,
            facets: facets.len() as u32,
            facets_per_buffer: per_buffer,
        })
    }

    pub fn optics(&self, patch: u32) -> PatchOptics {
        self.optics[patch as usize]
    }

    /// Whether any patch is part of a mirror.
    pub fn has_mirrors(&self) -> bool {
        let is_mirror = |o: &PatchOptics| matches!(o, PatchOptics::Mirror(_));
        self.optics.iter().any(is_mirror)
    }

    /// Whether any patch is bent.
    pub fn has_bent(&self) -> bool {
        self.optics.contains(&PatchOptics::Bent)
    }

    /// Ranges of facets that may be visible in a cone.
    pub fn in_cone(&self, cone: &Cone) -> Vec<Range<u32>> {
        let size = self.clusters.size;
        let facets = |c: Range<u32>| size * c.start..(size * c.end).min(self.facets);
        self.clusters
            .in_cone(cone)
            .into_iter()
            .map(facets)
            .collect()
    }

    /// Draws a range of facets.
    pub fn draw(&self, pass: &mut wgpu::RenderPass, bound: &mut Option<u32>, range: &Range<u32>) {
        let mut first = range.start;
        while first < range.end {
            let number = first / self.facets_per_buffer;
            let begin = number * self.facets_per_buffer;
            let end = range.end.min(begin + self.facets_per_buffer);
            if *bound != Some(number) {
                pass.set_vertex_buffer(0, self.buffers[number as usize].slice(..));
                *bound = Some(number);
            }
            pass.draw(3 * (first - begin)..3 * (end - begin), 0..1);
            first = end;
        }
    }
}

/// A facet in the card's format.
struct Prepared {
    corners: [[f32; 3]; 3],
    /// Normal and offset of its plane.
    plane: [f32; 4],
    /// Twice the patch, one more if the plane's normal points to the back.
    side: u32,
    mirror: u32,
    /// Position on a space-filling curve (Morton 1966).
    morton: u64,
}

/// Facets in the order in which they are drawn: nearby ones together, and of those at the same
/// point the lowest patch first, which wins at equal depth.
fn prepared(sound: &[&Facet], local: &UnitCube, optics: &[PatchOptics]) -> Vec<Prepared> {
    let mut planes = CardPlanes::default();
    let mut facets = Vec::with_capacity(sound.len());
    for t in sound {
        let corners = t.corners.map(|c| local.point(c));
        let Some((plane, is_upright)) = planes.of(corners) else {
            continue;
        };
        facets.push(Prepared {
            corners: corners.map(|c| c.as_vec3().to_array()),
            plane,
            side: 2 * t.patch + u32::from(!is_upright),
            mirror: match optics[t.patch as usize] {
                PatchOptics::Mirror(m) => m,
                _ => NO_MIRROR,
            },
            morton: morton_code(corners.iter().sum::<DVec3>() / 3.0),
        });
    }
    facets.sort_by_key(|f| (f.morton, f.side));
    facets
}

/// The planes of all facets, each once.
#[derive(Default)]
struct CardPlanes {
    known: HashMap<[i64; 4], [f32; 4]>,
}

impl CardPlanes {
    /// The plane through three corners, and whether they turn counter-clockwise about its
    /// normal; `None` if they span none.
    fn of(&mut self, [a, b, c]: [DVec3; 3]) -> Option<([f32; 4], bool)> {
        let across = (b - a).cross(c - a);
        let edges = [b - a, c - b, a - c].map(DVec3::length_squared);
        let longest = edges.into_iter().fold(0.0, f64::max);
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
        let middle = (a + b + c) / 3.0;
        let step = |x: f64| (x / SAME_PLANE).round() as i64;
        let key = [normal.x, normal.y, normal.z, normal.dot(middle)].map(step);
        let plane = self.known.entry(key).or_insert_with(|| {
            // The offset must fit the normal as the card has it, rounded.
            let rounded = normal.as_vec3();
            let offset = rounded.as_dvec3().dot(middle) as f32;
            [rounded.x, rounded.y, rounded.z, offset]
        });
        Some((*plane, is_upright))
    }
}

/// The bits of the three coordinates, interleaved.
fn morton_code(p: DVec3) -> u64 {
    const BITS: u32 = 20;
    let cells = f64::from(1u32 << BITS);
    let coordinate = |x: f64| (0.5 * (x + 1.0) * cells).clamp(0.0, cells - 1.0) as u64;
    let p = [p.x, p.y, p.z].map(coordinate);
    let mut code = 0;
    for bit in (0..BITS).rev() {
        for x in p {
            code = code << 1 | (x >> bit & 1);
        }
    }
    code
}

/// Copies facets to the card, `per_buffer` to each buffer.
fn upload(
    shared: &Shared,
    facets: &[Prepared],
    per_buffer: u32,
) -> Result<Vec<wgpu::Buffer>, DrawError> {
    let mut buffers = Vec::new();
    for part in facets.chunks(per_buffer as usize) {
        let descriptor = wgpu::BufferDescriptor {
            label: Some("facets"),
            size: part.len() as u64 * FACET_BYTES,
            usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        };
        let buffer = shared.allocate(|device| device.create_buffer(&descriptor));
        let buffer = buffer.ok_or_else(|| {
            let (count, bytes) = (facets.len(), facets.len() as u64 * FACET_BYTES);
            DrawError::TooLarge(format!(
                "{count} facets take {bytes} bytes, more than its free memory; its buffers are \
                 limited to {} bytes",
                shared.limits.max_buffer_size
            ))
        })?;
        // In pieces, so that the temporary copies stay small.
        const PIECE: usize = 1 << 16;
        for (number, piece) in part.chunks(PIECE).enumerate() {
            let words: Vec<u32> = piece.iter().flat_map(corner_words).collect();
            let offset = (number * PIECE) as u64 * FACET_BYTES;
            shared
                .queue
                .write_buffer(&buffer, offset, bytemuck::cast_slice(&words));
        }
        buffers.push(buffer);
    }
    shared.check()?;
    Ok(buffers)
}

fn corner_words(facet: &Prepared) -> impl Iterator<Item = u32> + '_ {
    facet.corners.iter().flat_map(|corner| {
        let numbers = corner.iter().chain(&facet.plane).map(|x| x.to_bits());
        numbers.chain([facet.side, facet.mirror])
    })
}

/// Clusters of facets and the boxes around them.
struct Clusters {
    /// Facets in a cluster.
    size: u32,
    count: u32,
    /// Node k has the children 2k + 1 and 2k + 2, which share its clusters by halves.
    nodes: Vec<ClusterBounds>,
}

#[derive(Clone, Copy)]
struct ClusterBounds {
    centre: DVec3,
    half: DVec3,
}

impl Clusters {
    fn new(facets: &[Prepared], size: u32) -> Clusters {
        let count = facets.len().div_ceil(size as usize);
        let nothing = ClusterBounds {
            centre: DVec3::ZERO,
            half: DVec3::ZERO,
        };
        let mut clusters = Clusters {
            size,
            count: count as u32,
            nodes: vec![nothing; 2 * count.next_power_of_two()],
        };
        if count > 0 {
            clusters.enclose(facets, 0, 0..count as u32);
        }
        clusters
    }

    /// Sets the boxes of a node and of all below it; returns low and high corner.
    fn enclose(&mut self, facets: &[Prepared], node: usize, range: Range<u32>) -> [DVec3; 2] {
        let [low, high] = if range.len() == 1 {
            let first = (range.start * self.size) as usize;
            let end = (first + self.size as usize).min(facets.len());
            let corners = facets[first..end].iter().flat_map(|f| f.corners);
            let corners = corners.map(|c| DVec3::from(c.map(f64::from)));
            corners.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], c| {
                [low.min(c), high.max(c)]
            })
        } else {
            let [left, right] = halves(&range);
            let a = self.enclose(facets, 2 * node + 1, left);
            let b = self.enclose(facets, 2 * node + 2, right);
            [a[0].min(b[0]), a[1].max(b[1])]
        };
        self.nodes[node] = ClusterBounds {
            centre: 0.5 * (low + high),
            half: 0.5 * (high - low) + BOX_SLACK,
        };
        [low, high]
    }

    /// Ranges of clusters that may lie in a cone, in order, joined where they touch.
    fn in_cone(&self, cone: &Cone) -> Vec<Range<u32>> {
        let mut ranges: Vec<Range<u32>> = Vec::new();
        if self.count > 0 {
            self.search(cone, 0, 0..self.count, &mut ranges);
        }
        ranges
    }

    fn search(&self, cone: &Cone, node: usize, range: Range<u32>, found: &mut Vec<Range<u32>>) {
        let containment = cone.containment(&self.nodes[node]);
        if containment == Containment::Outside {
            return;
        }
        if containment == Containment::Across && range.len() > 1 {
            let [left, right] = halves(&range);
            self.search(cone, 2 * node + 1, left, found);
            self.search(cone, 2 * node + 2, right, found);
            return;
        }
        match found.last_mut() {
            Some(last) if last.end == range.start => last.end = range.end,
            _ => found.push(range),
        }
    }
}

/// The two halves of a node's clusters; the tree is as deep as the logarithm of their number.
fn halves(range: &Range<u32>) -> [Range<u32>; 2] {
    let middle = range.start + (range.len() as u32).div_ceil(2);
    [range.start..middle, middle..range.end]
}

/// The position of a box relative to a [`Cone`].
#[derive(Clone, Copy, PartialEq, Eq)]
enum Containment {
    Outside,
    Inside,
    Across,
}

/// Half-spaces that bound the part of the world visible in a part of an image: its four borders,
/// the front of the viewpoint, and the space behind the mirror.
pub struct Cone {
    planes: Vec<Plane>,
}

impl Cone {
    /// `axes` of the image; `borders`: left, right, low and high end in u and v.
    pub fn new(eye: DVec3, axes: &[DVec3; 3], borders: [f64; 4], begin: Option<&Plane>) -> Cone {
        let [x, y, w] = *axes;
        let [left, right, low, high] = borders;
        let normals = [x - left * w, right * w - x, y - low * w, high * w - y, w];
        let mut planes: Vec<Plane> = normals
            .into_iter()
            .map(|n| {
                let normal = n.normalize();
                let offset = normal.dot(eye);
                Plane { normal, offset }
            })
            .collect();
        planes.extend(begin);
        Cone { planes }
    }

    fn containment(&self, bounds: &ClusterBounds) -> Containment {
        let mut containment = Containment::Inside;
        for plane in &self.planes {
            let middle = plane.normal.dot(bounds.centre) - plane.offset;
            let reach = plane.normal.abs().dot(bounds.half) + 1e-6 * plane.offset.abs();
            if middle + reach < 0.0 {
                return Containment::Outside;
            }
            if middle < reach {
                containment = Containment::Across;
            }
        }
        containment
    }
}
