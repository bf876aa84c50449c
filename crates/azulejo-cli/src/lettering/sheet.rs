//! `font sheet`: an image of all glyphs.

use super::args::FontSheetArgs;
use super::font;
use super::ink::GreyCanvas;
use crate::failure::Failure;
use crate::report::{Report, count};
use crate::session::Session;
use azulejo::output::Output;
use azulejo_formats::picture::png;
use azulejo_scene::{Encoding, Font, Line};
use glam::DVec2;
use std::path::Path;

/// Largest number of pixels of a sheet.
const LARGEST: usize = 1 << 28;

/// Runs `font sheet`.
pub fn run(args: &FontSheetArgs, session: &mut Session) -> Result<Report, Failure> {
    if args.output != Path::new("-") && args.output.extension().is_none_or(|e| e != "png") {
        let path = args.output.display();
        let message = format!("{path}: unknown image format, expected .png");
        return Err(Failure::misuse(message));
    }
    let output = Output::check(&args.output)?;
    session.claim_stdout(output.is_stdout())?;
    let converted = font::converted(&args.font, &args.part, session)?;
    let sheet = SheetLayout::new(&converted.font, &converted.encoding, f64::from(args.size))?;
    let unnamed = sheet.names.iter().filter(|n| n.is_none()).count();
    if unnamed > 0 {
        let message =
            format!("{unnamed} names are not drawn: the font lacks some of their letters");
        session.note(&message);
    }
    let paper = sheet.draw(&converted.font);
    let [width, height] = paper.size.map(|s| s as u32);
    let rgb = paper.rgb();
    output.write(session.progress(), |out| {
        png::write(width, height, &rgb, out)
    })?;
    let glyphs = converted.font.glyphs.len();
    let mut report = Report::default();
    let path = args.output.display().to_string();
    let words = format!(
        "{path}: {} glyphs, {width} x {height} pixels",
        count(glyphs)
    );
    report.fact("output", path, "wrote", words);
    report.value("glyphs", glyphs);
    Ok(report)
}

/// The layout: cells of equal size, glyphs above their names.
struct SheetLayout {
    /// Pixels per em.
    em: f64,
    /// Cells across and down.
    cells: [usize; 2],
    /// Size of a cell in pixels.
    cell: [usize; 2],
    /// The baseline, in pixels below the top of a cell.
    base: f64,
    /// The name of each glyph, set in the font if it has the letters.
    names: Vec<Option<Line>>,
}

/// Size of the names, as a share of the glyphs'.
const NAME_SIZE: f64 = 0.18;

impl SheetLayout {
    fn new(font: &Font, encoding: &Encoding, em: f64) -> Result<SheetLayout, Failure> {
        let boxes = font.glyphs.values().map(|g| g.figure.bounds());
        let inked = boxes.filter(|b| b.min.x <= b.max.x);
        let bounds = inked.reduce(|a, b| a.union(b));
        let bounds =
            bounds.ok_or_else(|| Failure::failed("no glyph of the font has an outline"))?;
        let margin = 0.12 * em;
        let cell = [
            em * bounds.size().x + 2.0 * margin,
            em * (bounds.size().y + 1.8 * NAME_SIZE) + 2.0 * margin,
        ];
        let across = (font.glyphs.len() as f64 * cell[1] / cell[0])
            .sqrt()
            .ceil()
            .max(1.0);
        let down = (font.glyphs.len() as f64 / across).ceil();
        let pixels = across * cell[0].ceil() * down * cell[1].ceil();
        if pixels.is_nan() || pixels > LARGEST as f64 {
            let message = "the sheet would be too large, expected a smaller --size";
            return Err(Failure::failed(message));
        }
        let name = |name: &String| font.set_line(name, encoding, 0.02).ok();
        Ok(SheetLayout {
            em,
            cells: [across as usize, down as usize],
            cell: cell.map(|c| c.ceil() as usize),
            base: margin + em * bounds.max.y,
            names: font.glyphs.keys().map(name).collect(),
        })
    }

    fn draw(&self, font: &Font) -> GreyCanvas {
        let mut paper = GreyCanvas::new([0, 1].map(|axis| self.cells[axis] * self.cell[axis]));
        for (i, (glyph, name)) in font.glyphs.values().zip(&self.names).enumerate() {
            let corner = [
                i % self.cells[0] * self.cell[0],
                i / self.cells[0] * self.cell[1],
            ];
            let corner = DVec2::from(corner.map(|c| c as f64));
            let ink = glyph.figure.bounds();
            let left = 0.5 * (self.cell[0] as f64 - self.em * (ink.min.x + ink.max.x));
            paper.draw(&glyph.figure, corner + DVec2::new(left, self.base), self.em);
            if let Some(name) = name {
                self.draw_name(name, corner, &mut paper);
            }
        }
        paper
    }

    /// Names are at the bottom of their cells, smaller where they would not fit.
    fn draw_name(&self, name: &Line, corner: DVec2, paper: &mut GreyCanvas) {
        let room = 0.92 * self.cell[0] as f64;
        let size = (NAME_SIZE * self.em).min(room / name.advance.max(1e-9));
        let base = self.cell[1] as f64 - (0.12 + 0.3 * NAME_SIZE) * self.em;
        let left = 0.5 * (self.cell[0] as f64 - size * name.advance);
        for glyph in &name.glyphs {
            let pen = DVec2::new(glyph.pen.x, -glyph.pen.y);
            let at = corner + DVec2::new(left, base) + size * pen;
            paper.draw(&glyph.figure, at, size);
        }
    }
}
