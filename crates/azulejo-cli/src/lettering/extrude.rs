//! `extrude`: a solid from a drawing.

use super::args::ExtrudeArgs;
use super::solid;
use crate::failure::Failure;
use crate::report::Report;
use crate::session::Session;
use azulejo::models::ModelOutput;
use azulejo::models::read_bytes;
use azulejo_formats::outline::Drawing;
use azulejo_formats::{ReadOptions, read_drawing};
use azulejo_scene::{Material, MaterialId, Prism, Rgb};
use glam::DVec2;
use std::sync::Arc;

/// Runs `extrude`.
pub fn run(args: &ExtrudeArgs, session: &mut Session) -> Result<Report, Failure> {
    let output = ModelOutput::check(&args.output)?;
    session.claim_stdout(output.is_stdout())?;
    let path = args.drawing.display().to_string();
    let bytes = read_bytes(&args.drawing)?;
    let drawing = read_drawing(&bytes, &path, &ReadOptions::default()).map_err(Failure::failed)?;
    drawing.warnings.iter().for_each(|w| session.warn(w));
    let stem = args
        .drawing
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy();
    let name = args
        .surface
        .name
        .clone()
        .unwrap_or_else(|| stem.into_owned());
    let metres = drawing.metres_per_unit;
    let (materials, prisms) = extruded(drawing, args, &name);
    let mut scene = solid::scene(&name, materials, prisms)?;
    scene.units.metres_per_unit = metres.map(|m| m / args.scale).filter(|m| m.is_normal());
    solid::write(&scene, &output, &args.output, session)
}

/// A prism for each figure, and a material for each colour.
fn extruded(drawing: Drawing, args: &ExtrudeArgs, name: &str) -> (Vec<Material>, Vec<Prism>) {
    let world_from_figure =
        (args.frame.frame(args.scale, args.depth)).world_from_glyph(DVec2::ZERO);
    let mut colors: Vec<Rgb> = Vec::new();
    let mut prisms = Vec::new();
    for shape in drawing.shapes {
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
        });
    }
    let material = |(i, color): (usize, &Rgb)| match i {
        0 => args.surface.material(name, *color),
        _ => args.surface.material(&format!("{name} {}", i + 1), *color),
    };
    let materials = colors.iter().enumerate().map(material).collect();
    (materials, prisms)
}
