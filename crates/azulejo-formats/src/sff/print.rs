//! Writes a document as text. Numbers are the shortest that read back to the same value.

use super::document::*;
use azulejo_scene::rtrace::{RtraceLight, RtraceLightKind, RtraceSource};
use azulejo_scene::{Operation, Rgb};
use glam::{DMat4, DVec3};
use std::io::{self, Write};

/// Smallest magnitude of a colour whose sign is a flag: zero cannot carry one.
const FLAGGED: f64 = 0.001;

/// Writes a document.
pub(crate) fn print(document: &SffDocument, out: &mut dyn Write) -> io::Result<()> {
    let mut out = SffPrinter { out };
    out.document(document)
}

struct SffPrinter<'w> {
    out: &'w mut dyn Write,
}

type PrintResult = io::Result<()>;

impl SffPrinter<'_> {
    fn document(&mut self, document: &SffDocument) -> PrintResult {
        let view = &document.view;
        writeln!(self.out, "view")?;
        for point in [view.eye, view.target, view.up] {
            self.line(&point.to_array())?;
        }
        self.line(&view.angles)?;
        writeln!(self.out, "colors")?;
        self.line(&document.background.to_array())?;
        self.line(&document.ambient.to_array())?;
        writeln!(self.out, "lights")?;
        for light in &document.lights {
            self.light(light)?;
        }
        writeln!(self.out, "\nsurfaces")?;
        for surface in &document.surfaces {
            self.surface(surface)?;
        }
        writeln!(self.out, "\nobjects")?;
        let mut depth = 0;
        for record in &document.objects {
            self.record(&record.kind, &mut depth)?;
        }
        if !document.textures.is_empty() {
            writeln!(self.out, "\ntextures")?;
            for record in &document.textures {
                if let RecordKind::Texture(texture) = &record.kind {
                    self.texture(texture)?;
                }
            }
        }
        writeln!(self.out, "\nend")
    }

    fn numbers(&mut self, numbers: &[f64]) -> PrintResult {
        numbers.iter().try_for_each(|n| write!(self.out, " {n}"))
    }

    fn point(&mut self, point: DVec3) -> PrintResult {
        self.numbers(&point.to_array())
    }

    fn end(&mut self) -> PrintResult {
        writeln!(self.out)
    }

    /// Writes numbers at the start of a line.
    fn line(&mut self, numbers: &[f64]) -> PrintResult {
        if let Some((first, rest)) = numbers.split_first() {
            write!(self.out, "{first}")?;
            self.numbers(rest)?;
        }
        self.end()
    }

    fn light(&mut self, light: &RtraceLight) -> PrintResult {
        let number = match light.kind {
            RtraceLightKind::Point => 1,
            RtraceLightKind::Spot { .. } => 2,
            RtraceLightKind::Extended { .. } => 3,
            RtraceLightKind::Planar { .. } => 4,
        };
        write!(self.out, "{number}")?;
        self.point(light.position)?;
        let signed = |k: usize| {
            if light.fades[k] {
                light.brightness[k]
            } else {
                -light.brightness[k]
            }
        };
        self.numbers(&[0, 1, 2].map(signed))?;
        match light.kind {
            RtraceLightKind::Point => {}
            RtraceLightKind::Spot {
                direction,
                half_angle,
                factor,
            } => {
                self.point(direction)?;
                self.numbers(&[half_angle.to_degrees(), factor])?;
            }
            RtraceLightKind::Extended { radius, samples } => {
                self.numbers(&[radius, f64::from(samples)])?;
            }
            RtraceLightKind::Planar { edges, samples } => {
                self.point(edges[0])?;
                self.point(edges[1])?;
                self.numbers(&samples.map(f64::from))?;
            }
        }
        self.end()
    }

    fn surface(&mut self, surface: &SurfaceRecord) -> PrintResult {
        let kind = match surface.source {
            RtraceSource::Phong { .. } => 1,
            RtraceSource::Strauss { .. } => 2,
        };
        let flagged = |amount: f64, flag: bool| if flag { -amount.max(FLAGGED) } else { amount };
        let color = surface.color;
        let red = flagged(color.r, surface.is_emitter);
        let green = flagged(color.g, surface.is_unshadowed);
        write!(self.out, "{kind}")?;
        self.numbers(&[red, green, color.b])?;
        let mut color = |c: Rgb| self.numbers(&c.to_array());
        match surface.source {
            RtraceSource::Phong {
                diffuse,
                specular,
                phong,
                metal,
                transparency,
            } => {
                color(diffuse)?;
                color(specular)?;
                self.numbers(&[phong, metal])?;
                self.numbers(&transparency.to_array())?;
            }
            RtraceSource::Strauss {
                smooth,
                metal,
                transparency,
            } => {
                color(smooth)?;
                color(metal)?;
                color(transparency)?;
            }
        }
        self.end()
    }

    fn record(&mut self, kind: &RecordKind, depth: &mut usize) -> PrintResult {
        match kind {
            RecordKind::Object {
                appearance,
                geometry,
            } => self.object(appearance, geometry),
            RecordKind::Texture(texture) => {
                write!(self.out, "64 ")?;
                self.texture(texture)
            }
            RecordKind::Transform { object, matrix } => {
                write!(self.out, "65 {object}")?;
                self.matrix(matrix)?;
                self.end()
            }
            RecordKind::CsgBegin {
                appearance,
                operation,
            } => {
                let operation = match operation {
                    Operation::Union => 0,
                    Operation::Difference => 1,
                    Operation::Intersection => 2,
                };
                let RecordAppearance {
                    surface,
                    refraction,
                } = appearance;
                writeln!(
                    self.out,
                    "66 0 {surface} {refraction} {operation} - csg begin {depth}"
                )?;
                *depth += 1;
                Ok(())
            }
            RecordKind::CsgNext => {
                let depth = depth.saturating_sub(1);
                writeln!(self.out, "66 1 - csg middle {depth}")
            }
            RecordKind::CsgEnd => {
                *depth = depth.saturating_sub(1);
                writeln!(self.out, "66 2 - csg end {depth}")
            }
            RecordKind::ListBegin { appearance } => {
                let RecordAppearance {
                    surface,
                    refraction,
                } = appearance;
                writeln!(self.out, "67 0 {surface} {refraction} - list begin 0")
            }
            RecordKind::ListEnd => writeln!(self.out, "67 1 - list end 0"),
        }
    }

    fn object(&mut self, appearance: &RecordAppearance, geometry: &SffGeometry) -> PrintResult {
        let number = match geometry {
            SffGeometry::Sphere { .. } => 1,
            SffGeometry::Cuboid { .. } => 2,
            SffGeometry::Patches(_) => 3,
            SffGeometry::Cone(_) => 4,
            SffGeometry::Polygons(_) => 5,
            SffGeometry::Triangles(_) => 6,
            SffGeometry::Text(_) => 7,
        };
        write!(
            self.out,
            "{number} {} {}",
            appearance.surface, appearance.refraction
        )?;
        match geometry {
            SffGeometry::Sphere { centre, radius } => {
                self.point(*centre)?;
                self.numbers(&[*radius])?;
                self.end()
            }
            SffGeometry::Cuboid { centre, half } => {
                self.point(*centre)?;
                self.point(*half)?;
                self.end()
            }
            SffGeometry::Cone(cone) => {
                self.point(cone.base)?;
                self.numbers(&[cone.base_radius])?;
                self.point(cone.apex)?;
                self.numbers(&[cone.apex_radius])?;
                self.end()
            }
            SffGeometry::Patches(placed) => self.placed(placed, Self::patches),
            SffGeometry::Polygons(placed) => self.placed(placed, Self::polygons),
            SffGeometry::Triangles(placed) => self.placed(placed, Self::triangles),
            SffGeometry::Text(data) => self.data(data, |out, commands| out.text(commands)),
        }
    }

    fn placed<T>(
        &mut self,
        placed: &PlacedData<T>,
        write: fn(&mut Self, &T) -> PrintResult,
    ) -> PrintResult {
        self.point(placed.origin)?;
        self.point(placed.scale)?;
        self.data(&placed.data, write)
    }

    fn data<T>(
        &mut self,
        data: &RecordData<T>,
        write: impl Fn(&mut Self, &T) -> PrintResult,
    ) -> PrintResult {
        match data {
            RecordData::File(name) => writeln!(self.out, " {name}"),
            RecordData::Here(data) => {
                writeln!(self.out, " -")?;
                write(self, data)
            }
        }
    }

    fn patches(&mut self, data: &PatchData) -> PrintResult {
        for patch in &data.patches {
            self.line(&patch.map(|v| f64::from(v) + 1.0))?;
        }
        self.end()?;
        self.vertices(&data.vertices)
    }

    fn polygons(&mut self, data: &PolygonData) -> PrintResult {
        for face in data.faces.iter() {
            write!(self.out, "{}", face.len())?;
            face.iter()
                .try_for_each(|v| write!(self.out, " {}", v + 1))?;
            self.end()?;
        }
        self.end()?;
        self.vertices(&data.vertices)
    }

    fn vertices(&mut self, vertices: &[DVec3]) -> PrintResult {
        for vertex in vertices {
            self.line(&vertex.to_array())?;
        }
        self.end()
    }

    fn triangles(&mut self, data: &TriangleData) -> PrintResult {
        for (k, corners) in data.corners.iter().enumerate() {
            for (corner, (position, normal)) in corners.iter().enumerate() {
                let [x, y, z] = position.to_array();
                let blank = if corner == 0 { "" } else { " " };
                write!(self.out, "{blank}{x} {y} {z}")?;
                self.point(*normal)?;
            }
            if let Some(surfaces) = data.surfaces.get(k) {
                self.numbers(&surfaces.map(f64::from))?;
            }
            self.end()?;
        }
        self.end()
    }

    fn text(&mut self, commands: &[TextCommand]) -> PrintResult {
        for command in commands {
            match &command.kind {
                TextCommandKind::Spacing(spacing) => write!(self.out, "SPACING {spacing}")?,
                TextCommandKind::Scale(scale) => {
                    write!(self.out, "SCALE")?;
                    self.point(*scale)?;
                }
                TextCommandKind::Orientation(axes) => {
                    write!(self.out, "ORIENTATION")?;
                    axes.iter().try_for_each(|a| self.point(*a))?;
                }
                TextCommandKind::Font(name) => write!(self.out, "FONT {name}")?,
                TextCommandKind::Encoding(name) => write!(self.out, "ENCODING {name}")?,
                TextCommandKind::At(origin, text) => {
                    write!(self.out, "AT")?;
                    self.point(*origin)?;
                    write!(self.out, " \"{text}\"")?;
                }
            }
            self.end()?;
        }
        self.end()
    }

    fn matrix(&mut self, matrix: &DMat4) -> PrintResult {
        self.numbers(&matrix.transpose().to_cols_array())
    }

    /// Writes a texture after its 64, if it has one.
    fn texture(&mut self, texture: &TextureRecord) -> PrintResult {
        let number = texture.kind.number;
        write!(self.out, "{number} {}", texture.object)?;
        self.matrix(&texture.matrix)?;
        self.numbers(&texture.kind.values)?;
        match &*texture.file {
            "" if super::record::has_file(number) => writeln!(self.out, " -"),
            "" => self.end(),
            name => writeln!(self.out, " {name}"),
        }
    }
}
