//! Planar polylines with bulges, widths and thickness, and their surfaces.

use super::axes::world_from_entity;
use super::curve::{Station, bulged};
use super::ids::AppearanceId;
use super::surfaces::{LayerMesh, LineString};
use glam::{DMat3, DVec2, DVec3};

/// A polyline in its plane.
#[derive(Debug, Default)]
pub(super) struct DxfOutline {
    /// Its vertices, each with the segment to the next.
    pub vertices: Vec<Vertex>,
    /// Whether the last vertex is connected to the first.
    pub is_closed: bool,
    /// Elevation of its plane.
    pub elevation: f64,
    /// Thickness: how far it is extruded from there.
    pub thickness: f64,
    /// Normal of its plane; zero for +z.
    pub extrusion: DVec3,
}

/// A vertex of a flat polyline.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Vertex {
    /// Its position.
    pub point: DVec2,
    /// Width at the start and at the end of the segment to the next vertex.
    pub widths: [f64; 2],
    /// Bulge: tangent of a quarter of the angle of the arc to the next vertex; 0 for a straight line.
    pub bulge: f64,
}

/// Least cosine of the angle between two arcs that form one smooth curve.
const SMOOTH: f64 = 0.999;

/// Where two wide segments meet, their edges are extended until they meet, unless that is more than
/// this many half widths away.
const LONGEST_MITRE: f64 = 4.0;

/// A straight piece of a polyline, including the pieces of arcs.
#[derive(Clone, Copy, Debug)]
struct Piece {
    ends: [End; 2],
    /// Number of the smooth curve that it belongs to; 0 for a straight segment.
    curve: u32,
}

/// An end of a piece.
#[derive(Clone, Copy, Debug)]
struct End {
    station: Station,
    half_width: f64,
    /// Vector from the centre line to the left edge.
    side: DVec2,
    /// Whether the neighbour's edges start here.
    is_joined: bool,
}

impl DxfOutline {
    /// Whether it has a surface.
    pub fn has_surface(&self) -> bool {
        self.thickness != 0.0 || self.is_wide()
    }

    fn is_wide(&self) -> bool {
        let wide = |v: &Vertex| v.widths.iter().any(|w| *w > 0.0);
        self.vertices.iter().any(wide)
    }

    /// Most vertices and corners that [`DxfOutline::draw`] adds.
    pub fn cost(&self) -> u64 {
        let pieces = |v: &Vertex| match v.bulge {
            0.0 => 1,
            bulge => super::curve::pieces(4.0 * bulge.atan()) as u64,
        };
        let each = match (self.is_wide(), self.thickness != 0.0) {
            (true, true) => 8 + 24,
            (true, false) => 4 + 4,
            (false, _) => 2 + 4,
        };
        self.vertices.iter().map(|v| each * pieces(v)).sum()
    }

    /// Adds its surface to a mesh.
    pub fn draw(&self, mesh: &mut LayerMesh, appearance: AppearanceId) {
        let pieces = self.pieces();
        if pieces.is_empty() {
            return;
        }
        let space = ExtrusionFrame {
            axes: world_from_entity(self.extrusion),
            low: self.elevation + self.thickness.min(0.0),
            height: self.thickness.abs(),
        };
        let curves = pieces.iter().map(|p| p.curve).max().unwrap_or(0);
        let mut groups = vec![0];
        groups.extend((0..curves).map(|_| mesh.new_group()));
        if self.is_wide() {
            Band {
                space,
                groups,
                appearance,
            }
            .draw(&pieces, mesh);
        } else {
            self.draw_wall(&pieces, &space, &groups, mesh, appearance);
        }
    }

    fn draw_wall(
        &self,
        pieces: &[Piece],
        space: &ExtrusionFrame,
        groups: &[u32],
        mesh: &mut LayerMesh,
        appearance: AppearanceId,
    ) {
        let mut points: Vec<DVec3> = pieces
            .iter()
            .map(|p| space.low(p.ends[0].station.point))
            .collect();
        let last = pieces[pieces.len() - 1].ends[1].station.point;
        if !self.is_closed {
            points.push(space.low(last));
        }
        let line = LineString {
            points,
            is_closed: self.is_closed,
        };
        let groups = |part: usize| groups[pieces[part].curve as usize];
        mesh.wall(&line, space.up(), appearance, groups);
    }

    /// Its straight pieces, mitred where they meet.
    fn pieces(&self) -> Vec<Piece> {
        let mut pieces = Vec::new();
        let mut curves = 0;
        let count = self.vertices.len();
        let ways = if self.is_closed {
            count
        } else {
            count.saturating_sub(1)
        };
        for way in 0..ways {
            let (from, to) = (&self.vertices[way], &self.vertices[(way + 1) % count]);
            // Segments without length have no direction. The difference is tested because it
            // may underflow although the points differ.
            if (to.point - from.point).try_normalize().is_some() {
                add_way(from, to.point, &mut curves, &mut pieces);
            }
        }
        let joints = if self.is_closed {
            pieces.len()
        } else {
            pieces.len().saturating_sub(1)
        };
        for joint in 0..joints {
            join(&mut pieces, joint);
        }
        pieces
    }
}

/// Adds the pieces of the segment from one vertex to the next.
fn add_way(from: &Vertex, to: DVec2, curves: &mut u32, pieces: &mut Vec<Piece>) {
    let stations = bulged(from.point, to, from.bulge);
    let count = stations.len() - 1;
    let curve = match (count > 1, pieces.last()) {
        (false, _) => 0,
        (true, Some(last)) if last.curve != 0 && is_smooth(&last.ends[1].station, &stations[0]) => {
            last.curve
        }
        (true, _) => {
            *curves += 1;
            *curves
        }
    };
    let end = |i: usize| {
        let share = i as f64 / count as f64;
        let [start, end] = from.widths.map(|w| 0.5 * w.max(0.0));
        let station = stations[i];
        let half_width = start + (end - start) * share;
        End {
            station,
            half_width,
            side: half_width * station.tangent.perp(),
            is_joined: false,
        }
    };
    pieces.extend((0..count).map(|i| Piece {
        ends: [end(i), end(i + 1)],
        curve,
    }));
}

fn is_smooth(a: &Station, b: &Station) -> bool {
    a.tangent.dot(b.tangent) > SMOOTH
}

/// Lets the edges of a piece and of the next end at the same points, if both are equally wide
/// and the angle between them is not too sharp.
fn join(pieces: &mut [Piece], joint: usize) {
    let next = (joint + 1) % pieces.len();
    let (a, b) = (pieces[joint].ends[1], pieces[next].ends[0]);
    let (n, m) = (a.station.tangent.perp(), b.station.tangent.perp());
    // The mitre is the vector whose projections on both normals are 1.
    let stretch = 1.0 + n.dot(m);
    let is_short = stretch > 2.0 / (LONGEST_MITRE * LONGEST_MITRE);
    let is_even = (a.half_width - b.half_width).abs() <= 1e-9 * a.half_width;
    if a.half_width > 0.0 && is_even && is_short {
        let side = a.half_width * (n + m) / stretch;
        for (piece, end) in [(joint, 1), (next, 0)] {
            let end = &mut pieces[piece].ends[end];
            (end.side, end.is_joined) = (side, true);
        }
    }
}

/// The coordinate system and extrusion of a polyline.
#[derive(Clone, Copy, Debug)]
struct ExtrusionFrame {
    axes: DMat3,
    low: f64,
    height: f64,
}

impl ExtrusionFrame {
    fn low(&self, p: DVec2) -> DVec3 {
        self.axes * p.extend(self.low)
    }

    fn up(&self) -> DVec3 {
        self.height * self.axes.z_axis
    }
}

/// A polyline with width: flat, or a solid if it has thickness.
struct Band {
    space: ExtrusionFrame,
    /// The smoothing group of each curve.
    groups: Vec<u32>,
    appearance: AppearanceId,
}

/// Vertices across a band: lower right and left, then upper right and left if it is thick.
type CrossSection = [u32; 4];

impl Band {
    fn draw(&self, pieces: &[Piece], mesh: &mut LayerMesh) {
        let first_vertex = mesh.mesh.positions.len() as u32;
        let mut before: Option<CrossSection> = None;
        for (i, piece) in pieces.iter().enumerate() {
            let [start, end] = piece.ends;
            let a = before.filter(|_| start.is_joined && i > 0);
            let a = a.unwrap_or_else(|| self.across(&start, mesh));
            let closes = i > 0 && i + 1 == pieces.len() && end.is_joined;
            let b = if closes {
                // The vertices at the start of the first piece, which were added first.
                self.numbered(first_vertex)
            } else {
                self.across(&end, mesh)
            };
            self.draw_piece(piece, a, b, mesh);
            before = Some(b);
        }
    }

    fn across(&self, end: &End, mesh: &mut LayerMesh) -> CrossSection {
        let sides = [end.station.point - end.side, end.station.point + end.side];
        let first = mesh.vertices(sides.map(|p| self.space.low(p)));
        if self.space.height > 0.0 {
            mesh.vertices(sides.map(|p| self.space.low(p) + self.space.up()));
        }
        self.numbered(first)
    }

    /// The vertices across that begin with this; the upper ones of a flat band equal the lower.
    fn numbered(&self, first: u32) -> CrossSection {
        let above = if self.space.height > 0.0 { 2 } else { 0 };
        [first, first + 1, first + above, first + above + 1]
    }

    fn draw_piece(&self, piece: &Piece, a: CrossSection, b: CrossSection, mesh: &mut LayerMesh) {
        let [right, left, high_right, high_left] = [0, 1, 2, 3].map(|i| [a[i], b[i]]);
        mesh.face(
            &[high_right[0], high_right[1], high_left[1], high_left[0]],
            self.appearance,
        );
        if self.space.height == 0.0 {
            return;
        }
        let group = self.groups[piece.curve as usize];
        mesh.face(&[right[0], left[0], left[1], right[1]], self.appearance);
        mesh.smooth_face(
            &[right[0], right[1], high_right[1], high_right[0]],
            self.appearance,
            group,
        );
        mesh.smooth_face(
            &[left[1], left[0], high_left[0], high_left[1]],
            self.appearance,
            group,
        );
        if !piece.ends[0].is_joined {
            mesh.face(
                &[left[0], right[0], high_right[0], high_left[0]],
                self.appearance,
            );
        }
        if !piece.ends[1].is_joined {
            mesh.face(
                &[right[1], left[1], high_left[1], high_right[1]],
                self.appearance,
            );
        }
    }
}
