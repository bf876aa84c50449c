//! Closed outlines of a drawing as plane figures.

use super::axes::world_from_entity;
use super::pairs::Pairs;
use super::parse::position;
use super::record::{Record, Records};
use super::spline;
use super::units;
use crate::outline::pen::{Ellipse, Pen};
use crate::outline::{Drawing, Filled};
use crate::reading::options::Budget;
use crate::reading::text::{decoded, shortened, text};
use crate::reading::warnings::Warnings;
use crate::{Position, ReadError, ReadOptions};
use azulejo_scene::{Figure, FillRule};
use glam::{DMat3, DVec2};
use std::collections::HashMap;

/// Reads the closed polylines, circles, ellipses and splines of a drawing's model space as plane
/// figures, seen from above. All outlines of a layer form one figure, with holes where one is inside
/// another ([`FillRule::EvenOdd`]). Open and non-horizontal outlines are left out with a warning.
///
/// # Errors
/// A file without sections, and one whose outlines have more curves than `options` allow.
pub fn read_figures(bytes: &[u8], name: &str, options: &ReadOptions) -> Result<Drawing, ReadError> {
    let bytes = &*decoded(bytes);
    let mut reader = FigureReader {
        bytes,
        file: name,
        warnings: Warnings::default(),
        budget: Budget::new(options),
        section: Vec::new(),
        has_sections: false,
        metres_per_unit: None,
        layers: Vec::new(),
        by_name: HashMap::new(),
        polyline: None,
    };
    let mut records = Records::new(bytes);
    let mut record = Record::default();
    while records.read(&mut record) && record.kind != b"EOF" {
        reader.record(&record)?;
    }
    reader.finish_polyline()?;
    if !reader.has_sections {
        return Err(ReadError::whole(name, "no section", "a drawing in DXF"));
    }
    let filled = |(name, pen): (String, Pen)| Filled {
        figure: pen.finish(FillRule::EvenOdd),
        color: None,
        name,
    };
    let shapes: Vec<Filled> = reader.layers.into_iter().map(filled).collect();
    Ok(Drawing {
        shapes: shapes
            .into_iter()
            .filter(|s| s.figure != Figure::default())
            .collect(),
        metres_per_unit: reader.metres_per_unit,
        warnings: reader.warnings.finish(name),
    })
}

struct FigureReader<'a> {
    bytes: &'a [u8],
    file: &'a str,
    warnings: Warnings,
    budget: Budget,
    section: Vec<u8>,
    has_sections: bool,
    metres_per_unit: Option<f64>,
    /// Layers by their names, each with its outlines.
    layers: Vec<(String, Pen)>,
    by_name: HashMap<String, usize>,
    /// The old kind of polyline, whose vertices are separate records.
    polyline: Option<Polyline>,
}

/// A polyline in its own plane: vertices, each with the bulge of the segment after it.
struct Polyline {
    offset: usize,
    layer: usize,
    vertices: Vec<(DVec2, f64)>,
    is_closed: bool,
    plane: Option<DMat3>,
}

type ReadResult = Result<(), ReadError>;

const CLOSED: i64 = 1;

impl FigureReader<'_> {
    fn record(&mut self, record: &Record) -> ReadResult {
        match record.kind {
            b"SECTION" => self.begin_section(record),
            b"ENDSEC" => {
                self.finish_polyline()?;
                self.section.clear();
            }
            _ if self.section != b"ENTITIES" => {}
            b"VERTEX" => self.vertex(record),
            b"SEQEND" => self.finish_polyline()?,
            _ => {
                self.finish_polyline()?;
                self.entity(record)?;
            }
        }
        Ok(())
    }

    fn begin_section(&mut self, record: &Record) {
        self.has_sections = true;
        self.section = record.bytes(2).to_vec();
        if self.section == b"HEADER" {
            self.metres_per_unit = units::metres_per_unit(record);
        }
    }

    fn warn(&mut self, message: impl Into<String>, offset: usize) {
        let bytes = self.bytes;
        self.warnings
            .add(self.file, message.into(), || match offset {
                0 => Position::Whole,
                at => position(bytes, Pairs::new(bytes).encoding, at),
            });
    }

    fn entity(&mut self, record: &Record) -> ReadResult {
        const IN_PAPER_SPACE: i64 = 1;
        if record.integer(67, 0) == IN_PAPER_SPACE || record.integer(60, 0) == 1 {
            self.warn(
                "entity in paper space or invisible: left out",
                record.offset,
            );
            return Ok(());
        }
        match record.kind {
            b"LWPOLYLINE" => self.light_polyline(record),
            b"POLYLINE" => {
                self.begin_polyline(record);
                Ok(())
            }
            b"CIRCLE" => self.circle(record),
            b"ELLIPSE" => self.ellipse(record),
            b"SPLINE" => self.spline(record),
            kind => {
                let kind = shortened(&text(kind));
                self.warn(
                    format!("{kind}: no closed outline, left out"),
                    record.offset,
                );
                Ok(())
            }
        }
    }

    /// The entity's plane seen from above, if it is horizontal.
    fn plane(&mut self, record: &Record) -> Option<DMat3> {
        let axes = world_from_entity(record.point(210));
        if axes.z_axis.z.abs() > 1.0 - 1e-9 {
            return Some(axes);
        }
        let kind = shortened(&text(record.kind));
        self.warn(
            format!("{kind} that does not lie flat: left out"),
            record.offset,
        );
        None
    }

    fn layer(&mut self, record: &Record) -> usize {
        let name = record.text(8);
        let next = self.layers.len();
        let index = *self.by_name.entry(name.to_lowercase()).or_insert(next);
        if index == next {
            self.layers.push((name.into_owned(), Pen::default()));
        }
        index
    }

    /// The pen of a layer, with room for some curves.
    fn pen(&mut self, layer: usize, curves: usize) -> Result<&mut Pen, ReadError> {
        self.budget
            .spend(curves as u64)
            .map_err(|e| e.error(self.file))?;
        Ok(&mut self.layers[layer].1)
    }

    fn light_polyline(&mut self, record: &Record) -> ReadResult {
        let mut vertices: Vec<(DVec2, f64)> = Vec::new();
        for pair in &record.pairs {
            let number = || record.finite(pair.value).unwrap_or(0.0);
            match (pair.code, vertices.last_mut()) {
                (10, _) => vertices.push((DVec2::new(number(), 0.0), 0.0)),
                (20, Some(vertex)) => vertex.0.y = number(),
                (42, Some(vertex)) => vertex.1 = number(),
                _ => {}
            }
        }
        let polyline = Polyline {
            offset: record.offset,
            layer: self.layer(record),
            vertices,
            is_closed: record.integer(70, 0) & CLOSED != 0,
            plane: self.plane(record),
        };
        self.draw(polyline)
    }

    fn begin_polyline(&mut self, record: &Record) {
        const MESHES: i64 = 16 | 64;
        const SMOOTHED: i64 = 2 | 4;
        let flags = record.integer(70, 0);
        let kind = match flags {
            f if f & MESHES != 0 => Some("POLYLINE that is a mesh: left out"),
            f if f & SMOOTHED != 0 => Some("smoothed POLYLINE: its straight pieces are used"),
            _ => None,
        };
        if let Some(message) = kind {
            self.warn(message, record.offset);
        }
        let plane = match flags & MESHES {
            0 => self.plane(record),
            _ => None,
        };
        self.polyline = Some(Polyline {
            offset: record.offset,
            layer: self.layer(record),
            vertices: Vec::new(),
            is_closed: flags & CLOSED != 0,
            plane,
        });
    }

    fn vertex(&mut self, record: &Record) {
        const CONTROL_POINT: i64 = 16;
        let is_drawn = record.integer(70, 0) & CONTROL_POINT == 0;
        if let Some(polyline) = self.polyline.as_mut().filter(|_| is_drawn) {
            let point = record.point(10).truncate();
            polyline.vertices.push((point, record.real(42, 0.0)));
        }
    }

    fn finish_polyline(&mut self) -> ReadResult {
        match self.polyline.take() {
            Some(polyline) => self.draw(polyline),
            None => Ok(()),
        }
    }

    fn draw(&mut self, polyline: Polyline) -> ReadResult {
        let Some(plane) = polyline.plane else {
            return Ok(());
        };
        let vertices = &polyline.vertices;
        let comes_back =
            vertices.len() > 2 && vertices.first().map(|v| v.0) == vertices.last().map(|v| v.0);
        if !polyline.is_closed && !comes_back {
            self.warn("open polyline: left out", polyline.offset);
            return Ok(());
        }
        // A bulge is divided into at most eight pieces.
        let pen = self.pen(polyline.layer, 8 * vertices.len())?;
        let flat = |p: DVec2| (plane * p.extend(0.0)).truncate();
        let is_mirrored = plane.z_axis.z < 0.0;
        let next = vertices.iter().cycle().skip(1);
        for (i, (&(from, bulge), &(to, _))) in vertices.iter().zip(next).enumerate() {
            if i == 0 {
                pen.move_to(flat(from));
            }
            let bulge = if is_mirrored { -bulge } else { bulge };
            bulged(pen, flat(to), bulge);
        }
        pen.close();
        Ok(())
    }

    fn circle(&mut self, record: &Record) -> ReadResult {
        let layer = self.layer(record);
        let Some(plane) = self.plane(record) else {
            return Ok(());
        };
        let radius = record.real(40, 0.0);
        if radius > 0.0 {
            self.pen(layer, 8)?.ellipse(Ellipse {
                centre: (plane * record.point(10)).truncate(),
                x: DVec2::new(radius, 0.0),
                y: DVec2::new(0.0, radius),
            });
        }
        Ok(())
    }

    /// An ellipse's centre and axes are in the drawing's coordinates, not the entity's.
    fn ellipse(&mut self, record: &Record) -> ReadResult {
        use std::f64::consts::TAU;
        let layer = self.layer(record);
        let turn = record.real(42, TAU) - record.real(41, 0.0);
        if (turn.abs() - TAU).abs() > 1e-6 {
            self.warn("arc of an ELLIPSE: open, left out", record.offset);
            return Ok(());
        }
        let Some(plane) = self.plane(record) else {
            return Ok(());
        };
        let major = record.point(11);
        let minor = record.real(40, 1.0) * plane.z_axis.cross(major);
        self.pen(layer, 8)?.ellipse(Ellipse {
            centre: record.point(10).truncate(),
            x: major.truncate(),
            y: minor.truncate(),
        });
        Ok(())
    }

    fn spline(&mut self, record: &Record) -> ReadResult {
        let layer = self.layer(record);
        match spline::curves(record) {
            Ok(spline) => {
                let pen = self.pen(layer, spline.len())?;
                for (i, [a, b, c, d]) in spline.into_iter().enumerate() {
                    if i == 0 {
                        pen.move_to(a);
                    }
                    pen.cubic_to(b, c, d);
                }
                pen.close();
            }
            Err(why) => self.warn(format!("SPLINE {why}: left out"), record.offset),
        }
        Ok(())
    }
}

/// Draws the segment to `to`: straight for a bulge of 0, otherwise an arc of the angle 4·atan(bulge),
/// counter-clockwise if that is positive.
fn bulged(pen: &mut Pen, to: DVec2, bulge: f64) {
    let from = pen.at();
    let chord = to - from;
    // Beyond this it is a full circle to the last digit, and its sine is too small to divide by.
    let half = 2.0 * bulge.clamp(-1e6, 1e6).atan();
    if chord == DVec2::ZERO {
        return;
    }
    if half.abs() < 1e-9 {
        return pen.line_to(to);
    }
    // The centre lies to the left of the chord for less than half a turn.
    let centre = from + 0.5 * chord + 0.5 * chord.perp() / half.tan();
    let out = from - centre;
    let circle = Ellipse {
        centre,
        x: out,
        y: out.perp(),
    };
    pen.arc_to(circle, 0.0, 2.0 * half, to);
}
