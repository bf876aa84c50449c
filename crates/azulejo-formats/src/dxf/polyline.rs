//! POLYLINE with its VERTEX records: planar and spatial polylines, polygon meshes of rows and
//! columns, and polyface meshes.

use super::color::Color;
use super::drawing::Appearance;
use super::ids::AppearanceId;
use super::outline::{DxfOutline, Vertex};
use super::record::Record;
use super::surfaces::{FaceCorners, LayerMesh};
use glam::DVec3;

/// Bits of group 70 of a POLYLINE.
mod flag {
    pub const CLOSED: i64 = 1;
    pub const SPLINE: i64 = 4;
    pub const SPATIAL: i64 = 8;
    pub const MESH: i64 = 16;
    pub const CLOSED_ACROSS: i64 = 32;
    pub const POLYFACE: i64 = 64;
}

/// Bits of group 70 of a VERTEX.
mod vertex_flag {
    pub const CONTROL_POINT: i64 = 16;
    pub const POSITION: i64 = 64;
    pub const POLYFACE: i64 = 128;
}

/// A POLYLINE whose vertices are being read.
#[derive(Debug)]
pub(super) struct Polyline {
    /// Its flags.
    flags: i64,
    /// Its appearance; faces may have colours of their own.
    pub appearance: Appearance,
    /// Its offset in the file.
    pub offset: usize,
    /// Whether it is not to be drawn.
    pub is_left_out: bool,
    /// Numbers of rows and columns, before and after smoothing.
    sizes: [[usize; 2]; 2],
    /// Default widths of vertices.
    widths: [f64; 2],
    /// The outline of a planar polyline.
    pub outline: DxfOutline,
    /// The points of all other kinds, without control points.
    points: Vec<DVec3>,
    /// The faces of a polyface mesh.
    faces: Vec<PolyFace>,
}

/// A face of a polyface mesh.
#[derive(Debug)]
struct PolyFace {
    corners: [i64; 4],
    appearance: AppearanceId,
}

/// The kind of a POLYLINE.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PolylineKind {
    /// A planar polyline.
    Flat,
    /// A spatial polyline.
    Spatial,
    /// A polygon mesh of rows and columns.
    Mesh,
    /// A polyface mesh.
    Polyface,
}

impl Polyline {
    /// Begins with the POLYLINE record.
    pub fn new(record: &Record, appearance: Appearance, outline: DxfOutline) -> Polyline {
        let size = |code| record.integer(code, 0).clamp(0, 1 << 24) as usize;
        let flags = record.integer(70, 0);
        Polyline {
            flags,
            appearance,
            offset: record.offset,
            is_left_out: false,
            sizes: [[size(71), size(72)], [size(73), size(74)]],
            widths: [record.real(40, 0.0), record.real(41, 0.0)],
            outline: DxfOutline {
                is_closed: flags & flag::CLOSED != 0,
                ..outline
            },
            points: Vec::new(),
            faces: Vec::new(),
        }
    }

    /// Its kind.
    pub fn kind(&self) -> PolylineKind {
        match self.flags {
            f if f & flag::POLYFACE != 0 => PolylineKind::Polyface,
            f if f & flag::MESH != 0 => PolylineKind::Mesh,
            f if f & flag::SPATIAL != 0 => PolylineKind::Spatial,
            _ => PolylineKind::Flat,
        }
    }

    /// The appearance of a VERTEX that is a face.
    pub fn appearance_of(&self, vertex: &Record) -> Appearance {
        let own = vertex.find(62).or(vertex.find(420));
        match own {
            Some(_) => Appearance {
                color: Color::of(vertex),
                ..self.appearance
            },
            None => self.appearance,
        }
    }

    /// Adds a VERTEX with its appearance.
    pub fn add(&mut self, record: &Record, appearance: AppearanceId) {
        let flags = record.integer(70, 0);
        match self.kind() {
            PolylineKind::Polyface => self.add_to_polyface(record, flags, appearance),
            _ if flags & vertex_flag::CONTROL_POINT != 0 => {}
            PolylineKind::Flat => self.outline.vertices.push(Vertex {
                point: record.point(10).truncate(),
                widths: [
                    record.real(40, self.widths[0]),
                    record.real(41, self.widths[1]),
                ],
                bulge: record.real(42, 0.0),
            }),
            PolylineKind::Mesh | PolylineKind::Spatial => self.points.push(record.point(10)),
        }
    }

    /// Vertices that are positions have both bits, faces have one.
    fn add_to_polyface(&mut self, record: &Record, flags: i64, appearance: AppearanceId) {
        if flags & vertex_flag::POSITION != 0 || flags & vertex_flag::POLYFACE == 0 {
            self.points.push(record.point(10));
        } else {
            self.faces.push(PolyFace {
                corners: [71, 72, 73, 74].map(|code| record.integer(code, 0)),
                appearance,
            });
        }
    }

    /// Adds a mesh of rows and columns. Returns whether the number of vertices matches.
    pub fn draw_mesh(&self, mesh: &mut LayerMesh, appearance: AppearanceId) -> bool {
        let [rows_declared, columns] = self.size();
        let rows = rows_declared.min(self.points.len() / columns.max(1));
        if rows < 2 || columns < 2 {
            return false;
        }
        let first = mesh.vertices(self.points[..rows * columns].iter().copied());
        let at =
            |row: usize, column: usize| first + (row % rows * columns + column % columns) as u32;
        let ways = |flag, count| count - usize::from(self.flags & flag == 0);
        for row in 0..ways(flag::CLOSED, rows) {
            for column in 0..ways(flag::CLOSED_ACROSS, columns) {
                let (next_row, next) = (row + 1, column + 1);
                let corners = [
                    at(row, column),
                    at(next_row, column),
                    at(next_row, next),
                    at(row, next),
                ];
                mesh.face(&corners, appearance);
            }
        }
        rows_declared * columns == self.points.len()
    }

    /// Declared numbers of rows and columns. Smoothed meshes have separate ones.
    fn size(&self) -> [usize; 2] {
        let [given, smoothed] = self.sizes;
        let fits = |size: [usize; 2]| size[0] * size[1] == self.points.len();
        let is_smoothed = self.flags & flag::SPLINE != 0 && (fits(smoothed) || !fits(given));
        if is_smoothed { smoothed } else { given }
    }

    /// Adds a mesh of faces. Returns how many were skipped, because they have fewer than three corners
    /// or an invalid one.
    pub fn draw_polyface(&self, mesh: &mut LayerMesh) -> usize {
        let mut lost = 0;
        let first = mesh.vertices(self.points.iter().copied());
        for face in &self.faces {
            // A corner 0 ends the face; a negative one hides the edge after it, not the face.
            let given = face.corners.iter().take_while(|corner| **corner != 0);
            let vertices = given.map(|corner| corner.unsigned_abs() - 1);
            let exist = vertices
                .clone()
                .all(|vertex| vertex < self.points.len() as u64);
            let corners =
                FaceCorners::new(vertices.map(|vertex| first.wrapping_add(vertex as u32)));
            if exist && corners.are_a_face() {
                mesh.face(corners.as_slice(), face.appearance)
            } else {
                lost += 1
            }
        }
        lost
    }

    /// Most vertices and corners that it adds.
    pub fn cost(&self) -> u64 {
        match self.kind() {
            PolylineKind::Flat => self.outline.cost(),
            PolylineKind::Spatial => 0,
            PolylineKind::Mesh => 5 * self.points.len() as u64,
            PolylineKind::Polyface => self.points.len() as u64 + 4 * self.faces.len() as u64,
        }
    }
}
