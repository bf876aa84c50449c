//! Closed outlines of a drawing as plane figures.

use super::axes::world_from_entity;
use super::curve::sweep;
use super::pairs::Pairs;
use super::parse::position;
use super::record::{Record, Records};
use super::spline;
use super::strands::{OpenOutline, Strand, bounds, join, tolerance};
#[cfg(feature = "fonts")]
use super::text::TextFonts;
use super::units;
#[cfg(feature = "fonts")]
use crate::outline::letters::Letters;
use crate::outline::pen::{Ellipse, Pen};
use crate::outline::{Drawing, Filled};
use crate::reading::options::Budget;
use crate::reading::text::{decoded, shortened, text};
use crate::reading::warnings::Warnings;
use crate::{Files, Position, ReadError, ReadOptions};
use azulejo_scene::figure::{Rectangle, Segment};
use azulejo_scene::{Contour, Curve, Figure, FillRule};
use glam::{DAffine2, DMat2, DMat3, DVec2};
use std::collections::{HashMap, HashSet};
use std::f64::consts::TAU;
use std::rc::Rc;

/// Blocks within blocks; more are one inside itself.
const DEEPEST: usize = 32;

/// Most open outlines of which is asked what they surround: the largest.
const EXAMINED: usize = 64;

/// Reads the outlines of a drawing's model space as plane figures, seen from above: polylines, circles, ellipses and
/// splines that are closed, and lines, arcs, open polylines and splines where their ends meet, also those of
/// inserted blocks. All outlines of a layer form one figure, with holes where one is inside another
/// ([`FillRule::EvenOdd`]); outlines that go through several layers are of that of their first piece. Open and
/// non-horizontal outlines are left out with a warning.
///
/// # Errors
/// A file without sections, one whose outlines have more curves than `options` allow, and one with an open outline
/// around others: what is inside may be its holes.
pub fn read_figures(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<Drawing, ReadError> {
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
        blocks: HashMap::new(),
        block: None,
        entities: Vec::new(),
        polyline: None,
        #[cfg(feature = "fonts")]
        letters: Letters::new(files),
        #[cfg(feature = "fonts")]
        fonts: TextFonts::default(),
    };
    #[cfg(not(feature = "fonts"))]
    let _ = files;
    let mut records = Records::new(bytes);
    let mut record = Record::default();
    while records.read(&mut record) && record.kind != b"EOF" {
        reader.record(&record)?;
    }
    reader.finish_polyline()?;
    if !reader.has_sections {
        return Err(ReadError::whole(name, "no section", "a drawing in DXF"));
    }
    // Put the blocks into their places, and join what meets.
    let entities = std::mem::take(&mut reader.entities);
    let mut content = vec![LayerContent::default(); reader.layers.len()];
    let space = Insertion {
        map: DAffine2::IDENTITY,
        layer: None,
        depth: 0,
    };
    reader.expand(&entities, &space, &mut content)?;
    let (strands, letters): (Vec<_>, Vec<_>) =
        content.into_iter().map(|c| (c.strands, c.letters)).unzip();
    let mut contours = reader.joined(strands)?;
    // Letters are cut out of what is around them on their layer, as if they had been drawn as outlines.
    // Those drawn twice count once.
    for (contours, mut letters) in contours.iter_mut().zip(letters) {
        let mut known = HashSet::new();
        letters.retain(|letter| known.insert(bits(std::slice::from_ref(letter))));
        contours.extend(letters);
    }
    let filled = |(name, contours): (String, Vec<Contour>)| Filled {
        figure: Figure {
            contours,
            rule: FillRule::EvenOdd,
        },
        color: None,
        name,
    };
    let shapes = reader.layers.into_iter().zip(contours).map(filled);
    Ok(Drawing {
        shapes: shapes
            .filter(|shape| shape.figure != Figure::default())
            .collect(),
        metres_per_unit: reader.metres_per_unit,
        warnings: reader.warnings.finish(name),
    })
}

pub(super) struct FigureReader<'a> {
    bytes: &'a [u8],
    file: &'a str,
    warnings: Warnings,
    budget: Budget,
    section: Vec<u8>,
    has_sections: bool,
    metres_per_unit: Option<f64>,
    /// The names of layers, in the order in which they occur.
    layers: Vec<String>,
    by_name: HashMap<String, usize>,
    blocks: HashMap<Vec<u8>, Rc<FigureBlock>>,
    /// The block that is being read, and its name.
    block: Option<(Vec<u8>, FigureBlock)>,
    /// Those of the model space.
    entities: Vec<FigureEntity>,
    /// The old kind of polyline, whose vertices are separate records.
    polyline: Option<Polyline>,
    #[cfg(feature = "fonts")]
    pub(super) letters: Letters<'a>,
    #[cfg(feature = "fonts")]
    pub(super) fonts: TextFonts,
}

/// Something drawn, with the number of its layer.
#[derive(Clone)]
pub(super) enum FigureEntity {
    Strand(usize, Strand),
    /// Closed outlines of letters.
    Letters(usize, Vec<Contour>),
    Insert(usize, FigureInsert),
}

/// What is on a layer.
#[derive(Clone, Default)]
struct LayerContent {
    strands: Vec<Strand>,
    letters: Vec<Contour>,
}

/// A block in its places.
#[derive(Clone)]
pub(super) struct FigureInsert {
    offset: usize,
    block: Vec<u8>,
    /// Drawing from block, of the first place.
    map: DAffine2,
    /// Numbers of columns and rows, and the steps from one to the next.
    counts: [u32; 2],
    steps: [DVec2; 2],
}

/// Entities that are inserted together.
#[derive(Default)]
struct FigureBlock {
    base: DVec2,
    entities: Vec<FigureEntity>,
}

/// How entities are put into the drawing.
struct Insertion {
    map: DAffine2,
    /// The layer of what is on layer 0 of a block.
    layer: Option<usize>,
    depth: usize,
}

/// A polyline in its own plane: vertices, each with the bulge of the segment after it.
struct Polyline {
    offset: usize,
    layer: usize,
    vertices: Vec<(DVec2, f64)>,
    is_closed: bool,
    plane: Option<DMat3>,
}

pub(super) type ReadResult = Result<(), ReadError>;

const CLOSED: i64 = 1;

impl FigureReader<'_> {
    fn record(&mut self, record: &Record) -> ReadResult {
        match (&self.section[..], record.kind) {
            (_, b"SECTION") => self.begin_section(record),
            (_, b"ENDSEC") => {
                self.finish_polyline()?;
                self.end_block();
                self.section.clear();
            }
            (b"ENTITIES" | b"BLOCKS", b"VERTEX") => self.vertex(record),
            (b"ENTITIES" | b"BLOCKS", b"SEQEND") => self.finish_polyline()?,
            (b"BLOCKS", b"BLOCK") => {
                self.end_block();
                let block = FigureBlock {
                    base: record.point(10).truncate(),
                    entities: Vec::new(),
                };
                self.block = Some((block_name(record), block));
            }
            #[cfg(feature = "fonts")]
            (b"TABLES", b"STYLE") => self.text_style(record),
            (b"BLOCKS", b"ENDBLK") => {
                self.finish_polyline()?;
                self.end_block();
            }
            (b"ENTITIES" | b"BLOCKS", _) => {
                self.finish_polyline()?;
                self.entity(record)?;
            }
            _ => {}
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

    fn end_block(&mut self) {
        if let Some((name, block)) = self.block.take() {
            self.blocks.insert(name, Rc::new(block));
        }
    }

    fn position(&self, offset: usize) -> Position {
        match offset {
            0 => Position::Whole,
            at => position(self.bytes, Pairs::new(self.bytes).encoding, at),
        }
    }

    pub(super) fn warn(&mut self, message: impl Into<String>, offset: usize) {
        let position = self.position(offset);
        self.warnings.add(self.file, message.into(), || position);
    }

    pub(super) fn spend(&mut self, elements: usize) -> ReadResult {
        let spent = self.budget.spend(elements as u64);
        spent.map_err(|e| e.error(self.file))
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
            b"LINE" => {
                let ends = [10, 11].map(|code| record.point(code).truncate());
                self.add(record, vec![Segment::Line(ends)])
            }
            b"LWPOLYLINE" => self.light_polyline(record),
            b"POLYLINE" => {
                self.begin_polyline(record);
                Ok(())
            }
            b"CIRCLE" => self.circle(record, (0.0, TAU)),
            b"ARC" => {
                let angles = sweep(record.real(50, 0.0), record.real(51, 360.0));
                self.circle(record, angles)
            }
            b"ELLIPSE" => self.ellipse(record),
            b"SPLINE" => self.spline(record),
            b"INSERT" => self.insert(record),
            #[cfg(feature = "fonts")]
            b"TEXT" | b"ATTRIB" | b"ATTDEF" => self.text(record),
            #[cfg(feature = "fonts")]
            b"MTEXT" => self.paragraphs(record),
            kind => {
                let kind = shortened(&text(kind));
                self.warn(format!("{kind}: no outline, left out"), record.offset);
                Ok(())
            }
        }
    }

    /// The entity's plane seen from above, if it is horizontal.
    pub(super) fn plane(&mut self, record: &Record) -> Option<DMat3> {
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

    pub(super) fn layer(&mut self, record: &Record) -> usize {
        let name = record.text(8);
        let next = self.layers.len();
        let index = *self.by_name.entry(name.to_lowercase()).or_insert(next);
        if index == next {
            self.layers.push(name.into_owned());
        }
        index
    }

    pub(super) fn keep(&mut self, entity: FigureEntity) {
        match &mut self.block {
            Some((_, block)) => block.entities.push(entity),
            None => self.entities.push(entity),
        }
    }

    fn add(&mut self, record: &Record, segments: Vec<Segment>) -> ReadResult {
        let layer = self.layer(record);
        self.add_strand(layer, record.offset, segments)
    }

    fn add_strand(&mut self, layer: usize, offset: usize, segments: Vec<Segment>) -> ReadResult {
        self.spend(segments.len())?;
        if !segments.is_empty() {
            self.keep(FigureEntity::Strand(layer, Strand { segments, offset }));
        }
        Ok(())
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
        let (Some(plane), Some(&(first, _))) = (polyline.plane, polyline.vertices.first()) else {
            return Ok(());
        };
        // A bulge is divided into at most eight pieces.
        self.spend(7 * polyline.vertices.len())?;
        let flat = |p: DVec2| (plane * p.extend(0.0)).truncate();
        let is_mirrored = plane.z_axis.z < 0.0;
        let mut pen = Pen::default();
        pen.move_to(flat(first));
        let ends = polyline.vertices.iter().skip(1).map(|vertex| vertex.0);
        let ends = ends.chain(polyline.is_closed.then_some(first));
        for ((_, bulge), to) in polyline.vertices.iter().zip(ends) {
            let bulge = if is_mirrored { -bulge } else { *bulge };
            bulged(&mut pen, flat(to), bulge);
        }
        self.add_strand(polyline.layer, polyline.offset, pen.into_segments())
    }

    /// A circle, or the arc of one: where it begins, and its angle.
    fn circle(&mut self, record: &Record, angles: (f64, f64)) -> ReadResult {
        let Some(plane) = self.plane(record) else {
            return Ok(());
        };
        let radius = record.real(40, 0.0);
        let ellipse = Ellipse {
            centre: (plane * record.point(10)).truncate(),
            x: radius * plane.x_axis.truncate(),
            y: radius * plane.y_axis.truncate(),
        };
        self.arc(record, ellipse, angles)
    }

    /// An ellipse's centre and axes are in the drawing's coordinates, not the entity's.
    fn ellipse(&mut self, record: &Record) -> ReadResult {
        let Some(plane) = self.plane(record) else {
            return Ok(());
        };
        let major = record.point(11);
        let minor = record.real(40, 1.0) * plane.z_axis.cross(major);
        let ellipse = Ellipse {
            centre: record.point(10).truncate(),
            x: major.truncate(),
            y: minor.truncate(),
        };
        let [start, end] = [record.real(41, 0.0), record.real(42, TAU)].map(f64::to_degrees);
        self.arc(record, ellipse, sweep(start, end))
    }

    fn arc(&mut self, record: &Record, ellipse: Ellipse, (start, angle): (f64, f64)) -> ReadResult {
        let mut pen = Pen::default();
        pen.move_to(ellipse.at(start));
        let is_whole = angle > TAU - 1e-6;
        let end = if is_whole {
            pen.at()
        } else {
            ellipse.at(start + angle)
        };
        pen.arc_to(ellipse, start, angle, end);
        self.add(record, pen.into_segments())
    }

    fn spline(&mut self, record: &Record) -> ReadResult {
        match spline::curves(record) {
            Ok(curves) => self.add(record, curves.into_iter().map(Segment::Cubic).collect()),
            Err(why) => {
                self.warn(format!("SPLINE {why}: left out"), record.offset);
                Ok(())
            }
        }
    }

    fn insert(&mut self, record: &Record) -> ReadResult {
        let layer = self.layer(record);
        let Some(plane) = self.plane(record) else {
            return Ok(());
        };
        self.spend(1)?;
        let plane = DMat2::from_cols(plane.x_axis.truncate(), plane.y_axis.truncate());
        let turned = plane * DMat2::from_angle(record.real(50, 0.0).to_radians());
        let scale = DVec2::new(record.real(41, 1.0), record.real(42, 1.0));
        let count = |code| record.integer(code, 1).clamp(1, 1 << 20) as u32;
        let step = |code, axis: DVec2| turned * (record.real(code, 0.0) * axis);
        self.keep(FigureEntity::Insert(
            layer,
            FigureInsert {
                offset: record.offset,
                block: block_name(record),
                map: DAffine2::from_mat2_translation(
                    turned * DMat2::from_diagonal(scale),
                    plane * record.point(10).truncate(),
                ),
                counts: [count(70), count(71)],
                steps: [step(44, DVec2::X), step(45, DVec2::Y)],
            },
        ));
        Ok(())
    }

    /// Adds the strands and letters of entities to those of their layers.
    fn expand(
        &mut self,
        entities: &[FigureEntity],
        into: &Insertion,
        content: &mut [LayerContent],
    ) -> ReadResult {
        let of_zero = self.by_name.get("0").copied();
        let of_insert = |layer: usize| match into.layer {
            Some(inserted) if Some(layer) == of_zero => inserted,
            _ => layer,
        };
        for entity in entities {
            match entity {
                FigureEntity::Strand(layer, strand) => {
                    self.spend(strand.segments.len())?;
                    let strand = strand.mapped(&into.map);
                    if strand.points().all(DVec2::is_finite) {
                        content[of_insert(*layer)].strands.push(strand);
                    }
                }
                FigureEntity::Letters(layer, contours) => {
                    let mut figure = Figure {
                        contours: contours.clone(),
                        ..Figure::default()
                    };
                    self.spend(figure.curve_count())?;
                    figure.move_points(|p| into.map.transform_point2(p));
                    if figure.bounds().size().is_finite() {
                        content[of_insert(*layer)].letters.extend(figure.contours);
                    }
                }
                FigureEntity::Insert(layer, insert) => {
                    let Some(block) = self.blocks.get(&insert.block).cloned() else {
                        self.warn("INSERT of a block that is missing: left out", insert.offset);
                        continue;
                    };
                    if into.depth == DEEPEST {
                        self.warn("block inside itself: left out", insert.offset);
                        continue;
                    }
                    for row in 0..insert.counts[1] {
                        for column in 0..insert.counts[0] {
                            self.spend(1)?;
                            let [x, y] = insert.steps;
                            let step = f64::from(column) * x + f64::from(row) * y;
                            let map = into.map
                                * DAffine2::from_translation(step)
                                * insert.map
                                * DAffine2::from_translation(-block.base);
                            let inner = Insertion {
                                map,
                                layer: Some(of_insert(*layer)),
                                depth: into.depth + 1,
                            };
                            self.expand(&block.entities, &inner, content)?;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// The closed outlines of each layer.
    fn joined(&mut self, strands: Vec<Vec<Strand>>) -> Result<Vec<Vec<Contour>>, ReadError> {
        let near = tolerance(bounds(strands.iter().flatten()));
        let mut contours = Vec::new();
        let mut rest = Vec::new();
        let mut layer_of = HashMap::new();
        for (layer, strands) in strands.into_iter().enumerate() {
            let joined = join(strands, near);
            contours.push(joined.loops);
            for strand in joined.open.into_iter().flat_map(|open| open.strands) {
                layer_of.entry(strand.offset).or_insert(layer);
                rest.push(strand);
            }
        }
        // What is open in each layer may be closed by others.
        rest.sort_by_key(|strand| strand.offset);
        let first = rest.first().and_then(|s| layer_of.get(&s.offset)).copied();
        let joined = join(rest, near);
        if let Some(layer) = first {
            contours[layer].extend(joined.loops);
        }
        self.check_open(joined.open, contours.iter().flatten())?;
        Ok(contours)
    }

    /// Says what is left out, and refuses it if it is around others, which may be its holes.
    fn check_open<'c>(
        &mut self,
        mut open: Vec<OpenOutline>,
        contours: impl Iterator<Item = &'c Contour>,
    ) -> ReadResult {
        let inside: Vec<Rectangle> = contours.map(around).collect();
        let size = |open: &OpenOutline| {
            let around = bounds(&open.strands);
            (around.max - around.min).length()
        };
        open.sort_by(|a, b| size(b).total_cmp(&size(a)));
        for outline in open.iter().take(EXAMINED) {
            if !outline.surrounds(&inside) {
                continue;
            }
            // Without the last digits, which are those of rounding.
            let [x, y] = outline.place.to_array().map(|x| x as f32 + 0.0);
            let found = if outline.branches {
                format!("lines around others that branch at ({x}, {y})")
            } else {
                format!("an outline around others that is open at ({x}, {y})")
            };
            let expected = "ends that meet, or nothing there: what may be its holes would be solid";
            return Err(ReadError {
                position: self.position(outline.strands[0].offset),
                ..ReadError::whole(self.file, found, expected)
            });
        }
        for outline in open {
            let what = if outline.branches {
                "lines that branch: no outline, left out"
            } else {
                "open outline: left out"
            };
            self.warn(what, outline.strands[0].offset);
        }
        Ok(())
    }
}

/// The numbers that define contours, to compare them.
pub(super) fn bits(contours: &[Contour]) -> Vec<u64> {
    let points = |curve: &Curve| match *curve {
        Curve::Line { start } => vec![start],
        Curve::Cubic {
            start,
            control1,
            control2,
        } => vec![start, control1, control2],
    };
    let points = contours.iter().flat_map(|c| &c.curves).flat_map(points);
    points.flat_map(|p| [p.x, p.y]).map(f64::to_bits).collect()
}

/// The smallest rectangle around a closed outline.
fn around(contour: &Contour) -> Rectangle {
    let figure = Figure {
        contours: vec![contour.clone()],
        rule: FillRule::EvenOdd,
    };
    figure.bounds()
}

/// The name of a block, in any case.
fn block_name(record: &Record) -> Vec<u8> {
    record.bytes(2).to_ascii_lowercase()
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
