//! `extrude`: a solid from a drawing.

use super::args::{ExtrudeArgs, PaintOrder};
use super::solid;
use super::typeface::numbered;
use crate::failure::Failure;
use crate::report::Report;
use crate::session::Session;
use azulejo::fonts::Fonts;
use azulejo::models::ModelOutput;
use azulejo::models::read_bytes;
use azulejo_formats::outline::typeface::Typeface;
use azulejo_formats::outline::{Drawing, Filled};
use azulejo_formats::{ReadOptions, read_drawing};
use azulejo_scene::figure::Rectangle;
use azulejo_scene::{Figure, Material, MaterialId, Prism, Rgb};
use glam::DVec2;
use std::sync::Arc;

/// Shapes that are compared with those before them, and points of each.
const MOST_COMPARED: usize = 200;
const POINTS: usize = 64;

/// Most tests of a point with a curve: a second's work.
const MOST_TESTS: usize = 50_000_000;

/// Runs `extrude`.
pub fn run(args: &ExtrudeArgs, session: &mut Session) -> Result<Report, Failure> {
    let output = ModelOutput::check(&args.output)?.with_tolerance(args.polygons.tolerance)?;
    session.claim_stdout(output.is_stdout())?;
    let (path, page) = numbered(&args.drawing);
    let bytes = read_bytes(&path)?;
    let fonts = fonts(args)?;
    let options = ReadOptions {
        page,
        ..ReadOptions::default()
    };
    let read = read_drawing(&bytes, &path.display().to_string(), &fonts, &options);
    let mut drawing = read.map_err(Failure::failed)?;
    drawing.warnings.iter().for_each(|w| session.warn(w));
    if args.layers.is_none() && is_painted_over(&drawing.shapes) {
        session.note(
            "shapes that are painted over others are inside of them: --layers STEP raises each over those before it, \
             --layers inlay cuts it out of them",
        );
    }
    if args.layers == Some(PaintOrder::Inlay) {
        inlay(&mut drawing.shapes);
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let name = args
        .surface
        .name
        .clone()
        .unwrap_or_else(|| stem.into_owned());
    let metres = drawing.metres_per_unit;
    let (materials, prisms) = extruded(drawing, args, &name)?;
    let mut scene = solid::scene(&name, materials, prisms)?;
    scene.units.metres_per_unit = metres.map(|m| m / args.scale).filter(|m| m.is_normal());
    let light = args.surface.shine(&mut scene)?;
    let mut report = solid::write(&scene, &output, &args.output, session)?;
    light.iter().for_each(|light| light.describe(&mut report));
    Ok(report)
}

/// The font of the drawing's texts: the one that is named, which must be one, or those of the system.
fn fonts(args: &ExtrudeArgs) -> Result<Fonts, Failure> {
    let Some(path) = &args.font else {
        return Ok(Fonts::default());
    };
    let bytes = read_bytes(path)?;
    Typeface::read(&bytes, &path.display().to_string(), 0).map_err(Failure::failed)?;
    Ok(Fonts::only(path, bytes, 0))
}

/// Whether a shape lies on one of another colour (or, without colours, another name) before it, as far as the points of
/// its outlines say.
fn is_painted_over(shapes: &[Filled]) -> bool {
    let drawn = shapes.iter().take(MOST_COMPARED);
    let known: Vec<(&Filled, Rectangle)> = drawn.map(|s| (s, s.figure.bounds())).collect();
    let mut left = MOST_TESTS;
    known.iter().enumerate().any(|(k, (shape, around))| {
        known[..k].iter().any(|(before, below)| {
            let overlap = around.min.max(below.min).cmplt(around.max.min(below.max));
            let is_same = match shape.color {
                Some(_) => shape.color == before.color,
                None => before.color.is_none() && shape.name == before.name,
            };
            if is_same || !overlap.all() {
                return false;
            }
            let each = before.figure.curve_count();
            let points = shape.figure.segments().take(POINTS.min(left / each.max(1)));
            let mut points = points.map(|segment| segment.at(0.5));
            left = left.saturating_sub(POINTS * each);
            points.any(|point| before.figure.contains(point))
        })
    })
}

/// Cuts each shape out of those before it. Shapes of which nothing is left are left out.
fn inlay(shapes: &mut Vec<Filled>) {
    let bounds: Vec<Rectangle> = shapes.iter().map(|s| s.figure.bounds()).collect();
    for k in 0..shapes.len() {
        let (shape, later) = shapes[k..]
            .split_first_mut()
            .expect("k is below the length");
        let overlaps = |b: &Rectangle| {
            let (low, high) = (b.min.max(bounds[k].min), b.max.min(bounds[k].max));
            low.cmplt(high).all()
        };
        let above = later.iter().zip(&bounds[k + 1..]);
        let above: Vec<&Figure> = above
            .filter(|(_, b)| overlaps(b))
            .map(|(s, _)| &s.figure)
            .collect();
        if !above.is_empty() {
            shape.figure = shape.figure.difference(&above);
        }
    }
    shapes.retain(|shape| shape.figure.curve_count() > 0);
}

/// A prism for each figure, and a material for each colour.
fn extruded(
    drawing: Drawing,
    args: &ExtrudeArgs,
    name: &str,
) -> Result<(Vec<Material>, Vec<Prism>), Failure> {
    let step = match args.layers {
        Some(PaintOrder::Raised(step)) => step,
        Some(PaintOrder::Inlay) | None => 0.0,
    };
    let front = args.frame.frame(args.scale, args.depth);
    let mut colors: Vec<Rgb> = Vec::new();
    let mut prisms = Vec::new();
    for (k, shape) in drawing.shapes.into_iter().enumerate() {
        let rise = k as f64 * step;
        let frame = front.raised(rise / args.depth);
        let world_from_figure = frame.world_from_glyph(DVec2::ZERO);
        let own = args.surface.color.or(shape.color);
        let color = own.unwrap_or(Rgb::grey(0.7));
        let known = colors.iter().position(|c| *c == color);
        let material = known.unwrap_or(colors.len());
        if known.is_none() {
            colors.push(color);
        }
        prisms.push(Prism {
            figure: Arc::new(shape.figure),
            world_from_figure,
            material: material as MaterialId,
            bevel: args.edge.bevel(args.scale, args.depth + rise)?,
        });
    }
    let material = |(i, color): (usize, &Rgb)| match i {
        0 => args.surface.material(name, *color),
        _ => args.surface.material(&format!("{name} {}", i + 1), *color),
    };
    let materials = colors.iter().enumerate().map(material).collect();
    Ok((materials, prisms))
}
