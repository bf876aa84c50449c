//! Conversion of entities to surfaces and lights.

use super::axes::world_from_entity;
use super::curve::{ellipse, is_full, sweep};
use super::drawing::Insert;
use super::ids::AppearanceId;
use super::light::light;
use super::mesh_entity::ControlCage;
use super::outline::{DxfOutline, Vertex};
use super::parse::DxfParser;
use super::polyline::{Polyline, PolylineKind};
use super::record::Record;
use super::surfaces::{FaceCorners, LayerMesh, LineString};
use crate::ReadError;
use crate::reading::text::{shortened, text};
use glam::{DMat3, DVec2, DVec3};

/// Most vertices and corners of an extruded circle.
const COST_OF_CIRCLE: u64 = 256;

type ReadResult = Result<(), ReadError>;

impl<'a> DxfParser<'a, '_> {
    /// Handles an entity, or a record that belongs to one.
    pub fn entity(&mut self, record: &Record<'a>) -> ReadResult {
        match record.kind {
            b"VERTEX" => self.vertex(record),
            b"SEQEND" => return self.finish_polyline(true),
            // Text attached to an INSERT.
            b"ATTRIB" => {}
            b"POLYLINE" => self.begin_polyline(record),
            _ if self.is_left_out(record) => {}
            _ => return self.draw(record),
        }
        Ok(())
    }

    /// Whether an entity is not part of the visible model.
    fn is_left_out(&mut self, record: &Record<'a>) -> bool {
        let why = if record.integer(67, 0) == 1 {
            "entity in paper space: left out"
        } else if record.integer(60, 0) == 1 {
            "invisible entity: left out"
        } else if self.current().is_none() {
            "entity outside blocks: left out"
        } else {
            return false;
        };
        self.warn(why, record.offset);
        true
    }

    fn draw(&mut self, record: &Record<'a>) -> ReadResult {
        match record.kind {
            b"3DFACE" => self.face(record),
            b"INSERT" => self.insert(record),
            b"LWPOLYLINE" => return self.light_polyline(record),
            b"MESH" => return self.mesh(record),
            b"LINE" => self.line(record),
            b"SOLID" | b"TRACE" => self.solid(record),
            b"CIRCLE" | b"ARC" | b"ELLIPSE" => return self.curve(record),
            b"LIGHT" => self.light(record),
            kind => {
                let kind = shortened(&text(kind));
                self.warn(skipped(&kind), record.offset);
            }
        }
        Ok(())
    }

    /// The mesh that an entity belongs to, and its appearance there.
    fn site(&mut self, record: &Record<'a>) -> Option<(&mut LayerMesh, AppearanceId)> {
        const OPACITY_IS_GIVEN: i64 = 0x0200_0000;
        let appearance = self.appearance(record);
        let id = self.appearance_id(appearance);
        let opacity = record.integer(440, 0);
        if opacity & OPACITY_IS_GIVEN != 0 && opacity & 0xff != 0xff {
            self.warn("transparent entity: opaque", record.offset);
        }
        let block = self.current()?;
        Some((block.surfaces.on(appearance.layer), id))
    }

    fn face(&mut self, record: &Record<'a>) {
        let third = record.point(12);
        let fourth = if record.find(13).is_some() {
            record.point(13)
        } else {
            third
        };
        let corners = FaceCorners::new([record.point(10), record.point(11), third, fourth]);
        if !corners.are_a_face() {
            return self.warn(
                "3DFACE with fewer than three different corners: skipped",
                record.offset,
            );
        }
        if let Some((mesh, appearance)) = self.site(record) {
            let first = mesh.vertices(corners.as_slice().iter().copied());
            let indices = [first, first + 1, first + 2, first + 3];
            mesh.face(&indices[..corners.as_slice().len()], appearance);
        }
    }

    /// A filled quadrilateral, whose third and fourth corners are swapped.
    fn solid(&mut self, record: &Record<'a>) {
        let (axes, offset) = extrusion(record);
        let third = flat_point(record, 12);
        let fourth = if record.find(13).is_some() {
            flat_point(record, 13)
        } else {
            third
        };
        let corners = FaceCorners::new([
            flat_point(record, 10),
            flat_point(record, 11),
            fourth,
            third,
        ]);
        if !corners.are_a_face() {
            let kind = shortened(&text(record.kind));
            return self.warn(
                format!("{kind} with fewer than three different corners: skipped"),
                record.offset,
            );
        }
        let points: Vec<DVec3> = corners.as_slice().iter().map(|&p| axes * p).collect();
        let Some((mesh, appearance)) = self.site(record) else {
            return;
        };
        if offset == DVec3::ZERO {
            return mesh.polygon(&points, axes.z_axis, appearance);
        }
        let outline = LineString {
            points,
            is_closed: true,
        };
        mesh.prism(&outline, offset, appearance, 0);
    }

    /// A line, in coordinates of the drawing and not of its extrusion.
    fn line(&mut self, record: &Record<'a>) {
        let (_, offset) = extrusion(record);
        if offset == DVec3::ZERO {
            return self.no_surface(record);
        }
        let points = vec![flat_point(record, 10), flat_point(record, 11)];
        if let Some((mesh, appearance)) = self.site(record) {
            mesh.wall(
                &LineString {
                    points,
                    is_closed: false,
                },
                offset,
                appearance,
                |_| 0,
            );
        }
    }

    /// A circle, arc or ellipse.
    fn curve(&mut self, record: &Record<'a>) -> ReadResult {
        let (axes, offset) = extrusion(record);
        if offset == DVec3::ZERO {
            self.no_surface(record);
            return Ok(());
        }
        self.spend(COST_OF_CIRCLE)?;
        let (centre, x, y, range) = match record.kind {
            b"ELLIPSE" => whole_ellipse(record, axes),
            _ => circle(record, axes),
        };
        let line = LineString {
            points: ellipse(centre, x, y, range),
            is_closed: is_full(range.1),
        };
        let Some((mesh, appearance)) = self.site(record) else {
            return Ok(());
        };
        let group = mesh.new_group();
        if line.is_closed {
            mesh.prism(&line, offset, appearance, group)
        } else {
            mesh.wall(&line, offset, appearance, |_| group)
        }
        Ok(())
    }

    fn no_surface(&mut self, record: &Record) {
        let kind = shortened(&text(record.kind));
        self.warn(
            format!("{kind} without thickness or width: has no surface"),
            record.offset,
        );
    }

    fn spend(&mut self, elements: u64) -> ReadResult {
        let file = &self.drawing.file;
        self.budget.spend(elements).map_err(|e| e.error(file))
    }

    fn light_polyline(&mut self, record: &Record<'a>) -> ReadResult {
        const CLOSED: i64 = 1;
        let width = record.real(43, 0.0);
        let mut vertices: Vec<Vertex> = Vec::new();
        for pair in &record.pairs {
            // Numbers before the first vertex belong to the whole polyline.
            let number = || record.finite(pair.value).unwrap_or(0.0);
            match (pair.code, vertices.last_mut()) {
                (10, _) => vertices.push(Vertex {
                    point: DVec2::new(number(), 0.0),
                    widths: [width; 2],
                    bulge: 0.0,
                }),
                (20, Some(vertex)) => vertex.point.y = number(),
                (40, Some(vertex)) => vertex.widths[0] = number(),
                (41, Some(vertex)) => vertex.widths[1] = number(),
                (42, Some(vertex)) => vertex.bulge = number(),
                _ => {}
            }
        }
        let outline = DxfOutline {
            vertices,
            is_closed: record.integer(70, 0) & CLOSED != 0,
            elevation: record.real(38, 0.0),
            thickness: record.real(39, 0.0),
            extrusion: record.point(210),
        };
        if !outline.has_surface() {
            self.no_surface(record);
            return Ok(());
        }
        self.spend(outline.cost())?;
        if let Some((mesh, appearance)) = self.site(record) {
            outline.draw(mesh, appearance);
        }
        Ok(())
    }

    fn mesh(&mut self, record: &Record<'a>) -> ReadResult {
        let cage = ControlCage::read(record);
        if cage.level > 0 {
            let message = format!(
                "MESH of smoothness {}: its control cage is used without subdivision",
                cage.level
            );
            self.warn(message, record.offset);
        }
        self.spend(cage.cost())?;
        if let Some((mesh, appearance)) = self.site(record) {
            let lost = cage.draw(mesh, appearance);
            let message = "face of a MESH with too few or invalid corners: skipped";
            self.warn_many(message.to_owned(), lost, record.offset);
        }
        Ok(())
    }

    fn light(&mut self, record: &Record<'a>) {
        let layer = self.appearance(record).layer;
        match light(record) {
            Ok(light) => {
                if let Some(block) = self.current() {
                    block.lights.push((layer, light));
                }
                const INVERSE_SQUARE: i64 = 2;
                if record.integer(72, INVERSE_SQUARE) != INVERSE_SQUARE
                    || record.integer(292, 0) != 0
                {
                    let message = "LIGHT with an attenuation or limits of its own: falls off with the inverse square of the distance";
                    self.warn(message, record.offset);
                }
            }
            Err(why) => self.warn(format!("LIGHT {why}: left out"), record.offset),
        }
    }

    fn insert(&mut self, record: &Record<'a>) {
        let name = record.bytes(2);
        if name.is_empty() {
            return self.warn("INSERT without a block: skipped", record.offset);
        }
        let appearance = self.appearance(record);
        let appearance = self.appearance_id(appearance);
        let block = self.block_id(name);
        let axes = world_from_entity(record.point(210));
        let turn = axes * DMat3::from_rotation_z(record.real(50, 0.0).to_radians());
        let scale = [41, 42, 43].map(|code| self.scale(record, code));
        let count = |code| record.integer(code, 1).clamp(1, i64::from(u16::MAX)) as u32;
        let insert = Insert {
            block,
            appearance,
            matrix: turn * DMat3::from_diagonal(DVec3::from_array(scale)),
            origin: axes * flat_point(record, 10),
            column_step: turn * DVec3::new(record.real(44, 0.0), 0.0, 0.0),
            row_step: turn * DVec3::new(0.0, record.real(45, 0.0), 0.0),
            columns: count(70),
            rows: count(71),
            offset: record.offset,
            is_refused: false,
        };
        if let Some(into) = self.current() {
            into.inserts.push(insert);
        }
    }

    /// A scale factor, which may be negative but not 0.
    fn scale(&mut self, record: &Record, code: i16) -> f64 {
        let scale = record.real(code, 1.0);
        if scale != 0.0 {
            return scale;
        }
        self.warn("INSERT with a scale of 0: taken as 1", record.offset);
        1.0
    }

    fn begin_polyline(&mut self, record: &Record<'a>) {
        let appearance = self.appearance(record);
        let outline = DxfOutline {
            elevation: flat_point(record, 10).z,
            thickness: record.real(39, 0.0),
            extrusion: record.point(210),
            ..DxfOutline::default()
        };
        let mut polyline = Polyline::new(record, appearance, outline);
        polyline.is_left_out = self.is_left_out(record);
        self.polyline = Some(polyline);
    }

    fn vertex(&mut self, record: &Record) {
        let appearance = match &self.polyline {
            Some(polyline) => polyline.appearance_of(record),
            None => return self.warn("VERTEX without a POLYLINE: skipped", record.offset),
        };
        let appearance = self.appearance_id(appearance);
        if let Some(polyline) = &mut self.polyline {
            polyline.add(record, appearance);
        }
    }

    /// Draws the current POLYLINE, if there is one.
    ///
    /// # Errors
    /// More segments than allowed.
    pub fn finish_polyline(&mut self, is_complete: bool) -> ReadResult {
        let Some(polyline) = self.polyline.take() else {
            return Ok(());
        };
        if !is_complete {
            self.warn(
                "POLYLINE without a SEQEND: its vertices end with the next entity",
                polyline.offset,
            );
        }
        if polyline.is_left_out {
            return Ok(());
        }
        self.spend(polyline.cost())?;
        match polyline.kind() {
            PolylineKind::Flat if polyline.outline.has_surface() => self.flat_polyline(&polyline),
            PolylineKind::Flat => self.warn(
                "POLYLINE without thickness or width: has no surface",
                polyline.offset,
            ),
            PolylineKind::Spatial => self.warn("spatial POLYLINE: has no surface", polyline.offset),
            PolylineKind::Mesh => self.polygon_mesh(&polyline),
            PolylineKind::Polyface => self.polyface_mesh(&polyline),
        }
        Ok(())
    }

    fn flat_polyline(&mut self, polyline: &Polyline) {
        let appearance = self.appearance_id(polyline.appearance);
        if let Some(block) = self.current() {
            polyline
                .outline
                .draw(block.surfaces.on(polyline.appearance.layer), appearance);
        }
    }

    fn polygon_mesh(&mut self, polyline: &Polyline) {
        let appearance = self.appearance_id(polyline.appearance);
        let Some(block) = self.current() else { return };
        let is_whole = polyline.draw_mesh(block.surfaces.on(polyline.appearance.layer), appearance);
        if !is_whole {
            let message =
                "polygon mesh whose vertex count is not rows × columns: complete rows are kept";
            self.warn(message, polyline.offset);
        }
    }

    fn polyface_mesh(&mut self, polyline: &Polyline) {
        let Some(block) = self.current() else { return };
        let lost = polyline.draw_polyface(block.surfaces.on(polyline.appearance.layer));
        let message = "face of a polyface mesh with too few or invalid corners: skipped";
        self.warn_many(message.to_owned(), lost, polyline.offset);
    }
}

/// The warning about an entity that is not supported.
fn skipped(kind: &str) -> String {
    match kind {
        "3DSOLID" | "BODY" | "REGION" | "SURFACE" | "EXTRUDEDSURFACE" | "LOFTEDSURFACE"
        | "NURBSURFACE" | "PLANESURFACE" | "REVOLVEDSURFACE" | "SWEPTSURFACE" => {
            format!(
                "{kind}: ACIS solid, whose data format is undocumented: skipped; export it as a mesh"
            )
        }
        _ => format!("{kind}: not read or without a surface: skipped"),
    }
}

/// Axes of an entity, and its extrusion vector.
fn extrusion(record: &Record) -> (DMat3, DVec3) {
    let axes = world_from_entity(record.point(210));
    (axes, record.real(39, 0.0) * axes.z_axis)
}

/// A point of a planar entity. Before release 11 the elevation was stored once, in group 38.
fn flat_point(record: &Record, code: i16) -> DVec3 {
    let mut point = record.point(code);
    if point.z == 0.0 && record.find(code + 20).is_none() {
        point.z = record.real(38, 0.0);
    }
    point
}

/// Centre, half axes, and start and angle in radians.
type Ellipse = (DVec3, DVec3, DVec3, (f64, f64));

fn circle(record: &Record, axes: DMat3) -> Ellipse {
    let range = match record.kind {
        b"ARC" => sweep(record.real(50, 0.0), record.real(51, 360.0)),
        _ => sweep(0.0, 360.0),
    };
    let radius = record.real(40, 0.0).abs();
    (
        axes * flat_point(record, 10),
        radius * axes.x_axis,
        radius * axes.y_axis,
        range,
    )
}

/// An ellipse has the drawing's coordinates; its parameters are in radians.
fn whole_ellipse(record: &Record, axes: DMat3) -> Ellipse {
    let major = record.point(11);
    let minor = record.real(40, 1.0) * axes.z_axis.cross(major);
    let (start, end) = (record.real(41, 0.0), record.real(42, std::f64::consts::TAU));
    (
        record.point(10),
        major,
        minor,
        sweep(start.to_degrees(), end.to_degrees()),
    )
}
