//! Draws facets into the pixels of one face.
//!
//! Nothing is clipped: a pixel's direction hits a facet if it is a combination of the directions to
//! the corners with no negative weight, and the weights are linear in the image wherever the
//! corners are (Olano and Greer, *Triangle Scan Conversion using 2D Homogeneous Coordinates*,
//! 1997). Two facets with a common edge compute its weight from the same products, so no pixel
//! falls between them. The depth value is 1/w, which is linear too; it is computed from the plane,
//! so that coplanar facets have bit-identical depths, and the lowest patch wins.

#![allow(
    clippy::needless_range_loop,
    reason = "loops over lanes that the compiler turns into vector instructions"
)]

use super::face::{Begin, Depth, Face};
use super::prepared_world::{FacetNode, FacetPacket, LANES, LocalWorld, PlaneFacet};
use super::view::Plane;
use std::ops::Range;

/// The side of a pixel that shows none.
pub(super) const NOTHING: u32 = u32::MAX;

/// Facets wider than this are limited to the pixels between their edges in each row.
const WIDE: usize = 24;

/// Rounding error of sums of a few products, relative to the products.
const ROUNDING: f32 = 8.0 * f32::EPSILON;

/// Largest number of half-spaces of a [`Cone`].
const PLANES: usize = 8;

/// Size of the stack of nodes: more than the depth of any tree.
const STACK: usize = crate::kernel::DEEPEST + 1;

/// Columns and rows of a face that are drawn; rows start below the horizon on side faces too.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Region {
    pub columns: Range<usize>,
    pub rows: Range<usize>,
}

impl Region {
    pub const EMPTY: Region = Region {
        columns: 0..0,
        rows: 0..0,
    };

    /// Grows to include some pixels of a row.
    pub fn add(&mut self, columns: Range<usize>, row: usize) {
        let grow = |range: &mut Range<usize>, more: Range<usize>| {
            *range = if range.start >= range.end {
                more
            } else {
                range.start.min(more.start)..range.end.max(more.end)
            };
        };
        grow(&mut self.columns, columns);
        grow(&mut self.rows, row..row + 1);
    }
}

/// The pixels of a face that are drawn into.
pub(super) struct Canvas<'a> {
    /// Nearness 1/w of what each pixel shows; infinite where nothing may be drawn.
    pub nearness: &'a mut [f32],
    /// The side that it shows.
    pub sides: &'a mut [u32],
    /// Centres of the columns, −1..1; those of the rows are the same.
    pub centres: &'a [f32],
    /// The row with which the pixels begin.
    pub first_row: usize,
}

/// Draws everything that a face shows in a region.
// By itself the compiler makes it twice as fast as inlined into what calls it.
#[inline(never)]
pub(super) fn draw(world: &LocalWorld, face: &Face, region: &Region, canvas: &mut Canvas) {
    if world.nodes.is_empty() || region.columns.is_empty() || region.rows.is_empty() {
        return;
    }
    let mut painter = Painter::new(world, face, region, canvas);
    let mut waiting = [0u32; STACK];
    let mut count = 1;
    while count > 0 {
        count -= 1;
        let index = waiting[count] as usize;
        let node = &world.nodes[index];
        if !painter.cone.may_show(node) {
            continue;
        }
        if node.second == 0 {
            let packets = &world.packets[node.packets[0] as usize..node.packets[1] as usize];
            packets.iter().for_each(|p| painter.packet(p));
            continue;
        }
        let (first, second) = (index + 1, index + node.second as usize);
        // The nearer child first: what it occludes is then rejected by depth.
        let is_swapped = painter.along(second) < painter.along(first);
        let (near, far) = if is_swapped {
            (second, first)
        } else {
            (first, second)
        };
        (waiting[count], waiting[count + 1]) = (far as u32, near as u32);
        count += 2;
    }
}

/// The half-spaces that bound the visible part of a region: its four borders, the front of the
/// viewpoint, and the space behind the mirror.
struct Cone {
    normals: [[f32; PLANES]; 3],
    absolute: [[f32; PLANES]; 3],
    offsets: [f32; PLANES],
}

impl Cone {
    fn new(face: &Face, borders: &[f32; 4]) -> Cone {
        let [left, right, low, high] = borders.map(f64::from);
        let [u, v, w] = face.axes;
        let through_eye = [u - left * w, right * w - u, v - low * w, high * w - v, w];
        let mut cone = Cone {
            normals: [[0.0; PLANES]; 3],
            absolute: [[0.0; PLANES]; 3],
            offsets: [0.0; PLANES],
        };
        let eye = through_eye.map(|normal| Plane {
            normal,
            offset: normal.dot(face.eye),
        });
        let begin = face.begin.as_ref().map(|b| b.plane);
        for (k, plane) in eye.into_iter().chain(begin).enumerate() {
            for (axis, x) in plane.normal.to_array().into_iter().enumerate() {
                cone.normals[axis][k] = x as f32;
                cone.absolute[axis][k] = x.abs() as f32;
            }
            cone.offsets[k] = plane.offset as f32;
        }
        cone
    }

    /// Whether a part of the box may lie in all of them.
    #[inline]
    fn may_show(&self, node: &FacetNode) -> bool {
        let mut is_outside = false;
        for k in 0..PLANES {
            let product = |n: &[[f32; PLANES]; 3], v: [f32; 3]| {
                n[0][k] * v[0] + n[1][k] * v[1] + n[2][k] * v[2]
            };
            let middle = product(&self.normals, node.centre);
            // Distant viewpoints have large offsets, whose rounding must not reject a box.
            let slack = product(&self.absolute, node.half) + 1e-6 * self.offsets[k].abs();
            is_outside |= middle + slack < self.offsets[k];
        }
        !is_outside
    }
}

struct Painter<'a, 'b> {
    world: &'a LocalWorld,
    face: &'a Face,
    cone: Cone,
    region: &'a Region,
    /// Left, right, low and high ends of the region: centres of its outermost pixels.
    borders: [f32; 4],
    /// Pixels per half the image.
    half: f32,
    canvas: &'a mut Canvas<'b>,
}

/// Corners of a packet in the coordinates of the face, `[3 * corner + axis][lane]`.
type FaceCorners = [[f32; LANES]; 9];

/// For each lane of a packet the range of columns and rows of its pixels, as whole numbers.
struct Extents {
    columns: [[f32; LANES]; 2],
    rows: [[f32; LANES]; 2],
    /// Whether a corner is not in front of the viewpoint.
    is_beside: [bool; LANES],
    /// Whether there may be any pixel.
    is_seen: [bool; LANES],
}

/// A facet ready to be filled in: functions of the image as coefficients of x, y and 1.
struct Fill {
    /// Functions that are not negative in the pixels of the facet: its three edges, and the
    /// distance behind the mirror.
    inside: [[f32; 3]; 4],
    nearness: [f32; 3],
    side: u32,
}

impl<'a, 'b> Painter<'a, 'b> {
    fn new(
        world: &'a LocalWorld,
        face: &'a Face,
        region: &'a Region,
        canvas: &'a mut Canvas<'b>,
    ) -> Self {
        let centre = |k: usize| canvas.centres[k];
        let borders = [
            centre(region.columns.start),
            centre(region.columns.end - 1),
            centre(region.rows.start),
            centre(region.rows.end - 1),
        ];
        // Slightly wider, so that rounding loses no pixel.
        let borders = [
            borders[0] - 1e-5,
            borders[1] + 1e-5,
            borders[2] - 1e-5,
            borders[3] + 1e-5,
        ];
        let half = 0.5 * canvas.centres.len() as f32;
        let cone = Cone::new(face, &borders);
        Painter {
            world,
            face,
            cone,
            region,
            borders,
            half,
            canvas,
        }
    }

    /// Distance of a node's centre along the face's axis.
    fn along(&self, node: usize) -> f32 {
        let (c, w) = (self.world.nodes[node].centre, self.face.rows[2]);
        c[0] * w[0] + c[1] * w[1] + c[2] * w[2]
    }

    fn packet(&mut self, packet: &FacetPacket) {
        let seen = self.place(packet);
        let extents = self.extents(&seen);
        for lane in 0..LANES {
            if extents.is_seen[lane] {
                self.facet(packet, lane, &seen, &extents);
            }
        }
    }

    /// Corners relative to the viewpoint, along the face's axes.
    #[inline]
    fn place(&self, packet: &FacetPacket) -> FaceCorners {
        let Face {
            rows: m, high, low, ..
        } = self.face;
        let mut seen = [[0.0; LANES]; 9];
        for corner in 0..3 {
            let at = 3 * corner;
            for lane in 0..LANES {
                // The first difference is exact for points near the viewpoint, so they keep their
                // precision.
                let q = [0, 1, 2].map(|k| (packet.corners[at + k][lane] - high[k]) - low[k]);
                for (k, m) in m.iter().enumerate() {
                    seen[at + k][lane] = m[0] * q[0] + m[1] * q[1] + m[2] * q[2];
                }
            }
        }
        seen
    }

    #[inline]
    fn extents(&self, seen: &FaceCorners) -> Extents {
        let [left, right, low, high] = self.borders;
        let mut extents = Extents {
            columns: [[0.0; LANES]; 2],
            rows: [[0.0; LANES]; 2],
            is_beside: [false; LANES],
            is_seen: [false; LANES],
        };
        let (columns, rows) = (&self.region.columns, &self.region.rows);
        let first = [columns.start as f32, rows.start as f32];
        let last = [(columns.end - 1) as f32, (rows.end - 1) as f32];
        for lane in 0..LANES {
            let [x, y, w] = [0, 1, 2].map(|k| [0, 3, 6].map(|corner| seen[corner + k][lane]));
            let all = |outside: [bool; 3]| outside[0] & outside[1] & outside[2];
            let beyond = |a: [f32; 3], end: f32| [0, 1, 2].map(|c| a[c] > end * w[c]);
            let before = |a: [f32; 3], end: f32| [0, 1, 2].map(|c| a[c] < end * w[c]);
            let is_outside = all(beyond(x, right))
                | all(before(x, left))
                | all(beyond(y, high))
                | all(before(y, low))
                | all(w.map(|w| w <= 0.0));
            let range = |a: [f32; 3], k: usize| {
                let p = [0, 1, 2].map(|c| a[c] / w[c]);
                let (least, most) = (smaller(p), larger(p));
                // Pixels k with least ≤ centre(k) ≤ most, and a hundredth more.
                let pixel = |a: f32| (a * self.half + (self.half - 0.5)).clamp(-4.0, 1e5);
                [
                    nearest(pixel(least) + 0.49).max(first[k]),
                    nearest(pixel(most) - 0.49).min(last[k]),
                ]
            };
            let is_beside = smaller(w) <= 0.0;
            let (c, r) = (range(x, 0), range(y, 1));
            for end in 0..2 {
                extents.columns[end][lane] = c[end];
                extents.rows[end][lane] = r[end];
            }
            extents.is_beside[lane] = is_beside;
            // Unused lanes hold NaN and are never in front of the viewpoint.
            let is_within = larger(w) > 0.0;
            let has_pixels = is_beside | ((c[0] <= c[1]) & (r[0] <= r[1]));
            extents.is_seen[lane] = is_within & !is_outside & has_pixels;
        }
        extents
    }

    fn facet(&mut self, packet: &FacetPacket, lane: usize, seen: &FaceCorners, extents: &Extents) {
        let facet = &packet.facets[lane];
        let Some(depth) = self.face.depth(&self.world.planes[facet.plane as usize]) else {
            return;
        };
        let corners = [0, 3, 6].map(|c| [0, 1, 2].map(|k| seen[c + k][lane]));
        let (columns, rows) = if extents.is_beside[lane] {
            let ranges = [0, 1].map(|axis| self.spread(&corners, axis));
            match ranges {
                [Some(columns), Some(rows)] => (columns, rows),
                _ => return,
            }
        } else {
            let range =
                |ends: &[[f32; LANES]; 2]| ends[0][lane] as usize..ends[1][lane] as usize + 1;
            (range(&extents.columns), range(&extents.rows))
        };
        let fill = self.prepare(facet, &corners, &packet.corners_of(lane), &depth);
        if columns.len() > WIDE {
            self.fill_wide(&fill, columns, rows);
        } else {
            for row in rows {
                self.fill_row(&fill, row, columns.clone());
            }
        }
    }

    /// Columns (axis 0) or rows (axis 1) of the part in front of the viewpoint of a facet that
    /// extends beside or behind it.
    fn spread(&self, corners: &[[f32; 3]; 3], axis: usize) -> Option<Range<usize>> {
        let range = [&self.region.columns, &self.region.rows][axis];
        let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
        for (k, a) in corners.iter().enumerate() {
            let b = &corners[(k + 1) % 3];
            if a[2] > 0.0 {
                let x = a[axis] / a[2];
                (least, most) = (least.min(x), most.max(x));
            }
            if (a[2] > 0.0) != (b[2] > 0.0) {
                // Towards the plane of the viewpoint the edge leaves the image at one end.
                let x = a[axis] * b[2] - b[axis] * a[2];
                let x = if a[2] > 0.0 { -x } else { x };
                if x >= 0.0 {
                    most = f32::INFINITY;
                }
                if x <= 0.0 {
                    least = f32::NEG_INFINITY;
                }
            }
        }
        let pixel = |x: f32| x * self.half + (self.half - 0.5);
        let first = (pixel(least) - 0.01).ceil().max(range.start as f32) as usize;
        let last = (pixel(most) + 0.01).floor().min((range.end - 1) as f32);
        (last >= first as f32).then(|| first..last as usize + 1)
    }

    /// `corners` in the coordinates of the face, `placed` in those of the world.
    fn prepare(
        &self,
        facet: &PlaneFacet,
        corners: &[[f32; 3]; 3],
        placed: &[[f32; 3]; 3],
        depth: &Depth,
    ) -> Fill {
        let is_front = depth.is_above == facet.is_upright;
        let sign = if is_front != self.face.is_turned {
            -1.0
        } else {
            1.0
        };
        // 2 a × b as (a + b) × (b − a), with the difference in world coordinates: behind many
        // mirrors the viewpoint is far away, and relative to it the corners have lost digits that
        // the edge needs. Exchanging a and b changes only the sign, to the bit.
        let edge = |k: usize, l: usize| {
            let ([px, py, pz], [qx, qy, qz]) = (placed[k], placed[l]);
            let along = [qx - px, qy - py, qz - pz];
            let turned = |m: &[f32; 3]| m[0] * along[0] + m[1] * along[1] + m[2] * along[2];
            let [u, v, w] = &self.face.rows;
            let d = [turned(u), turned(v), turned(w)];
            let ([ax, ay, az], [bx, by, bz]) = (corners[k], corners[l]);
            let s = [ax + bx, ay + by, az + bz];
            [
                sign * (s[1] * d[2] - s[2] * d[1]),
                sign * (s[2] * d[0] - s[0] * d[2]),
                sign * (s[0] * d[1] - s[1] * d[0]),
            ]
        };
        let [nx, ny, n1] = depth.nearness;
        let behind = match &self.face.begin {
            Some(Begin {
                nearness: [x, y, one],
                ..
            }) => [(x - nx) as f32, (y - ny) as f32, (one - n1) as f32],
            None => [0.0, 0.0, 1.0],
        };
        Fill {
            inside: [edge(0, 1), edge(1, 2), edge(2, 0), behind],
            nearness: [nx as f32, ny as f32, n1 as f32],
            side: 2 * facet.patch + u32::from(!is_front),
        }
    }

    /// Fills rows between the columns where the edges cross them.
    fn fill_wide(&mut self, fill: &Fill, columns: Range<usize>, rows: Range<usize>) {
        let inverse = fill.inside.map(|e| 1.0 / e[0]);
        for row in rows {
            let y = self.canvas.centres[row];
            let (mut left, mut right) = (-1.0f32, 1.0f32);
            for (e, inverse) in fill.inside.iter().zip(inverse) {
                let x = -(e[1] * y + e[2]) * inverse;
                // Where the edge is nearly parallel to the row, its rounding extends over many
                // pixels.
                let slack = ROUNDING * (e[1].abs() + e[2].abs()) * inverse.abs();
                if e[0] > 0.0 {
                    left = left.max(x - slack);
                } else if e[0] < 0.0 {
                    right = right.min(x + slack);
                }
            }
            let pixel = |x: f32| x * self.half + (self.half - 0.5);
            let first = (pixel(left) - 1.0).max(columns.start as f32) as usize;
            let last = (pixel(right) + 2.0).min(columns.end as f32).max(0.0) as usize;
            if first < last {
                self.fill_row(fill, row, first..last);
            }
        }
    }

    #[inline]
    fn fill_row(&mut self, fill: &Fill, row: usize, columns: Range<usize>) {
        let y = self.canvas.centres[row];
        let start = (row - self.canvas.first_row) * self.canvas.centres.len();
        let pixels = start + columns.start..start + columns.end;
        let centres = &self.canvas.centres[columns];
        let nearness = &mut self.canvas.nearness[pixels.clone()];
        let sides = &mut self.canvas.sides[pixels];
        let at_row = |e: &[f32; 3]| (e[0], e[1] * y + e[2]);
        // One by one, because a map over the array is not inlined.
        let [a, b, c, d] = &fill.inside;
        let (a, b, c, d) = (at_row(a), at_row(b), at_row(c), at_row(d));
        let near = at_row(&fill.nearness);
        let side = fill.side;
        let value = |(slope, rest): (f32, f32), x: f32| slope * x + rest;
        for ((old, old_side), &x) in nearness.iter_mut().zip(sides).zip(centres) {
            let is_inside = (value(a, x) >= 0.0)
                & (value(b, x) >= 0.0)
                & (value(c, x) >= 0.0)
                & (value(d, x) >= 0.0);
            let new = value(near, x);
            let is_nearer = (new > *old) | ((new == *old) & (side < *old_side));
            let is_shown = is_inside & is_nearer;
            *old = if is_shown { new } else { *old };
            *old_side = if is_shown { side } else { *old_side };
        }
    }
}

/// Plain comparisons: `f32::min` also handles NaN, which costs time.
fn smaller([a, b, c]: [f32; 3]) -> f32 {
    let ab = if b < a { b } else { a };
    if c < ab { c } else { ab }
}

fn larger([a, b, c]: [f32; 3]) -> f32 {
    let ab = if b > a { b } else { a };
    if c > ab { c } else { ab }
}

/// The nearest whole number, for |x| < 2^22: adding 1.5 · 2^23 leaves no room for a fraction.
fn nearest(x: f32) -> f32 {
    const ROUND: f32 = 12_582_912.0;
    (x + ROUND) - ROUND
}
