//! Lines and triangles drawn in addition to the model: gizmos, markers of lights and cameras,
//! highlights.

use crate::projection::Projection;
use azulejo::scene::math::Aabb;
use glam::{DAffine3, DVec2, DVec3, DVec4};
use std::f64::consts::TAU;

/// Factor by which depth-tested overlays are drawn nearer, so that they are visible on surfaces.
const NEARER: f64 = 1.0008;
/// Segments of a circle.
const PIECES: u32 = 48;

/// Colour and line style of an overlay element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverlayStyle {
    /// sRGB and opacity.
    pub color: [u8; 4],
    /// Line width, pixels.
    pub width: f32,
    /// Whether it is visible through surfaces.
    pub on_top: bool,
}

impl OverlayStyle {
    /// Opaque lines of the given width that surfaces occlude.
    pub fn new([r, g, b]: [u8; 3], width: f32) -> OverlayStyle {
        OverlayStyle {
            color: [r, g, b, 255],
            width,
            on_top: false,
        }
    }

    /// The same style, visible through surfaces.
    pub fn on_top(self) -> OverlayStyle {
        OverlayStyle {
            on_top: true,
            ..self
        }
    }
}

/// A line segment in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverlayLine {
    /// Start point.
    pub from: DVec3,
    /// End point.
    pub to: DVec3,
    /// Its colour, and whether surfaces hide it.
    pub ink: OverlayStyle,
}

/// A two-sided triangle in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverlayTriangle {
    /// Its vertices, in any order.
    pub corners: [DVec3; 3],
    /// Its colour, and whether surfaces hide it.
    pub ink: OverlayStyle,
}

/// Everything drawn in addition to the model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overlay {
    /// Line segments.
    pub lines: Vec<OverlayLine>,
    /// Triangles, drawn in this order, before the lines.
    pub triangles: Vec<OverlayTriangle>,
}

impl Overlay {
    /// An empty overlay.
    pub fn none() -> &'static Overlay {
        const NONE: &Overlay = &Overlay {
            lines: Vec::new(),
            triangles: Vec::new(),
        };
        NONE
    }

    /// Adds a line segment.
    pub fn line(&mut self, from: DVec3, to: DVec3, ink: OverlayStyle) {
        self.lines.push(OverlayLine { from, to, ink });
    }

    /// Adds a polyline; closed back to the first point if `is_closed`.
    pub fn polyline(&mut self, points: &[DVec3], is_closed: bool, ink: OverlayStyle) {
        points.windows(2).for_each(|w| self.line(w[0], w[1], ink));
        if let (true, [first, .., last]) = (is_closed, points) {
            self.line(*last, *first, ink);
        }
    }

    /// Adds a triangle.
    pub fn triangle(&mut self, corners: [DVec3; 3], ink: OverlayStyle) {
        self.triangles.push(OverlayTriangle { corners, ink });
    }

    /// Adds a filled parallelogram.
    pub fn parallelogram(&mut self, corner: DVec3, a: DVec3, b: DVec3, ink: OverlayStyle) {
        let opposite = corner + a + b;
        self.triangle([corner, corner + a, opposite], ink);
        self.triangle([corner, opposite, corner + b], ink);
    }

    /// Adds an arrow; its filled head is an eighth of its length.
    pub fn arrow(&mut self, from: DVec3, to: DVec3, ink: OverlayStyle) {
        let along = to - from;
        let neck = to - 0.125 * along;
        self.line(from, neck, ink);
        let ring = ring(neck, along, 0.04 * along.length(), 12);
        for k in 0..ring.len() {
            let next = ring[(k + 1) % ring.len()];
            self.triangle([ring[k], next, to], ink);
            self.triangle([ring[k], next, neck], ink);
        }
    }

    /// Adds the edges of a transformed box.
    pub fn cuboid(&mut self, bounds: Aabb, world_from_object: DAffine3, ink: OverlayStyle) {
        if bounds.is_empty() {
            return;
        }
        let corner = |k: usize| {
            let pick = |axis: usize| {
                let side = if k >> axis & 1 == 0 {
                    bounds.min
                } else {
                    bounds.max
                };
                side[axis]
            };
            world_from_object.transform_point3(DVec3::new(pick(0), pick(1), pick(2)))
        };
        for k in 0..8 {
            for axis in [1, 2, 4] {
                if k & axis == 0 {
                    self.line(corner(k), corner(k | axis), ink);
                }
            }
        }
    }

    /// Adds a circle around a normal of any length.
    pub fn circle(&mut self, centre: DVec3, normal: DVec3, radius: f64, ink: OverlayStyle) {
        self.polyline(&ring(centre, normal, radius, PIECES), true, ink);
    }

    /// Adds the cone of a spot light: `half_angle` from its axis in radians, at most a right angle;
    /// `along` is the vector from the apex to the base.
    pub fn cone(&mut self, apex: DVec3, along: DVec3, half_angle: f64, ink: OverlayStyle) {
        // Near a right angle the base would become infinite; the slant height is fixed instead.
        let (sin, cos) = half_angle.clamp(0.0, 0.5 * TAU).sin_cos();
        let length = along.length();
        let base = ring(apex + cos * along, along, sin * length, PIECES);
        self.polyline(&base, true, ink);
        for k in (0..base.len()).step_by(PIECES as usize / 8) {
            self.line(apex, base[k], ink);
        }
    }

    /// Adds three lines of length `size` along the axes through a point.
    pub fn cross(&mut self, centre: DVec3, size: f64, ink: OverlayStyle) {
        for axis in DVec3::AXES {
            self.line(centre - 0.5 * size * axis, centre + 0.5 * size * axis, ink);
        }
    }

    /// Bounding spheres (centre, radius) of all lines and triangles.
    pub(super) fn spheres(&self) -> impl Iterator<Item = (DVec3, f64)> {
        let lines = self.lines.iter().map(|l| around(&[l.from, l.to]));
        lines.chain(self.triangles.iter().map(|t| around(&t.corners)))
    }
}

/// A bounding sphere (centre, radius) of points.
fn around(points: &[DVec3]) -> (DVec3, f64) {
    let centre = points.iter().sum::<DVec3>() / points.len() as f64;
    let distances = points.iter().map(|p| p.distance(centre));
    (centre, distances.fold(0.0, f64::max))
}

/// Points on a circle around an axis.
fn ring(centre: DVec3, axis: DVec3, radius: f64, pieces: u32) -> Vec<DVec3> {
    let axis = axis.try_normalize().unwrap_or(DVec3::Z);
    let (x, y) = axis.any_orthonormal_pair();
    let point = |k: u32| {
        let (sin, cos) = (TAU * f64::from(k) / f64::from(pieces)).sin_cos();
        centre + radius * (cos * x + sin * y)
    };
    (0..pieces).map(point).collect()
}

/// Triangle vertices in clip coordinates, five words each: four for the position, one for the
/// colour. Occluded elements come first; also returns the number of their vertices.
pub(super) fn corners(overlay: &Overlay, view: &Projection) -> (Vec<u32>, u32) {
    let mut words = Vec::new();
    let mut hidden = 0;
    for on_top in [false, true] {
        let nearer = if on_top { 1.0 } else { NEARER };
        for t in overlay.triangles.iter().filter(|t| t.ink.on_top == on_top) {
            let clip = t.corners.map(|p| view.clip(view.to_view(p)));
            clip.iter()
                .for_each(|&c| push(&mut words, c, nearer, t.ink));
        }
        for line in overlay.lines.iter().filter(|l| l.ink.on_top == on_top) {
            if let Some([a, b, c, d]) = ribbon(line, view) {
                for corner in [a, b, c, c, b, d] {
                    push(&mut words, corner, nearer, line.ink);
                }
            }
        }
        if !on_top {
            hidden = (words.len() / WORDS) as u32;
        }
    }
    (words, hidden)
}

/// Words per vertex.
pub(super) const WORDS: usize = 5;

fn push(words: &mut Vec<u32>, clip: DVec4, nearer: f64, ink: OverlayStyle) {
    let z = (clip.z * nearer).min(clip.w.max(clip.z));
    let place = DVec4::new(clip.x, clip.y, z, clip.w).as_vec4();
    words.extend(place.to_array().map(f32::to_bits));
    words.push(u32::from_le_bytes(ink.color));
}

/// The four corners of a wide line; `None` if it is behind the near plane.
fn ribbon(line: &OverlayLine, view: &Projection) -> Option<[DVec4; 4]> {
    let (mut a, mut b) = (view.to_view(line.from), view.to_view(line.to));
    let near = -view.near();
    if a.z > near && b.z > near || !(a + b).is_finite() {
        return None;
    }
    if a.z > near {
        a = a.lerp(b, (near - a.z) / (b.z - a.z));
    } else if b.z > near {
        b = b.lerp(a, (near - b.z) / (a.z - b.z));
    }
    let (a, b) = (view.clip(a), view.clip(b));
    let pixel = |c: DVec4| DVec2::new(c.x, c.y) / c.w * 0.5 * view.size();
    let along = (pixel(b) - pixel(a)).try_normalize().unwrap_or(DVec2::X);
    let aside = along.perp() * f64::from(line.ink.width) / view.size();
    let moved = |c: DVec4, side: f64| {
        let offset = side * c.w * aside;
        DVec4::new(c.x + offset.x, c.y + offset.y, c.z, c.w)
    };
    Some([moved(a, 1.0), moved(a, -1.0), moved(b, 1.0), moved(b, -1.0)])
}
