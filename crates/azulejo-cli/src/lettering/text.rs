//! `text`: converts a string to solid letters.

use super::args::TextArgs;
use super::typeface::Fonts;
use super::{solid, typeface, values};
use crate::failure::Failure;
use crate::report::Report;
use crate::session::Session;
use azulejo::models::ModelOutput;
use azulejo::models::read_bytes;
use azulejo_formats::outline::typeface::StyledText;
use azulejo_scene::{Material, MaterialId, PlacedGlyph, Prism, Rgb, TextFrame};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;

/// Largest length of a text; letters share their outlines, but each has its own prism.
const LONGEST: usize = 1 << 20;

/// By how much the front of each layer of a letter lies before that below it, as a share of the depth, and how far all
/// of them may reach.
const STEP: f64 = 0.05;
const HIGHEST: f64 = 0.5;

/// Runs `text`.
pub fn run(args: &TextArgs, session: &mut Session) -> Result<Report, Failure> {
    let output = ModelOutput::check(&args.output)?.with_tolerance(args.polygons.tolerance)?;
    session.claim_stdout(output.is_stdout())?;
    let text = StyledText::parse(&text(args)?, values::reflectance).map_err(Failure::failed)?;
    let fonts = Fonts::read(&args.typeface, session)?;
    let glyphs = typeface::set(&text, &fonts, args, session)?;
    let depth = args.solid.depth.unwrap_or(0.25 * args.solid.size);
    let frame = args.frame.frame(args.solid.size, depth);
    let name = args
        .surface
        .name
        .clone()
        .unwrap_or_else(|| title(&text.text));
    let (materials, prisms) = extruded(&glyphs, &frame, depth, args, &name)?;
    let mut scene = solid::scene(&name, materials, prisms)?;
    let light = args.surface.shine(&mut scene)?;
    let mut report = solid::write(&scene, &output, &args.output, session)?;
    light.iter().for_each(|light| light.describe(&mut report));
    report.value("fonts", fonts.instances.clone());
    for instance in fonts.instances {
        report.line("variable font", instance);
    }
    Ok(report)
}

/// A prism of this depth for each glyph, and a material for each colour.
fn extruded(
    glyphs: &[PlacedGlyph],
    frame: &TextFrame,
    depth: f64,
    args: &TextArgs,
    name: &str,
) -> Result<(Vec<Material>, Vec<Prism>), Failure> {
    let top = glyphs.iter().map(|g| g.layer).max().unwrap_or(0);
    let step = STEP.min(HIGHEST / f64::from(top.max(1)));
    let mut colors: Vec<Option<Rgb>> = Vec::new();
    let mut known = HashMap::new();
    let mut bevels = HashMap::new();
    let mut prisms = Vec::new();
    for glyph in glyphs.iter().filter(|g| !g.figure.contours.is_empty()) {
        let bits = glyph.color.map(|c| [c.r, c.g, c.b].map(f64::to_bits));
        let material = *known.entry(bits).or_insert(colors.len());
        if material == colors.len() {
            colors.push(glyph.color);
        }
        let rise = f64::from(glyph.layer) * step;
        // Glyphs of one size and layer share a bevel.
        let unit = args.solid.size * glyph.axis.length();
        let bevel = match bevels.entry((unit.to_bits(), glyph.layer)) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => new.insert(args.edge.bevel(unit, depth * (1.0 + rise))?),
        };
        // What only lies on another layer would be thinner than its bevel.
        let frame = match bevel {
            Some(_) => frame.raised(rise),
            None => frame.of_layer(glyph, step),
        };
        let prism = frame.prism(glyph, material as MaterialId);
        prisms.extend(prism.map(|prism| Prism {
            bevel: bevel.clone(),
            ..prism
        }));
    }
    let material = |(k, color): (usize, &Option<Rgb>)| {
        let name = match k {
            0 => name.to_owned(),
            _ => format!("{name} {}", k + 1),
        };
        let plain = args.surface.material(&name, Rgb::grey(0.7));
        Material {
            diffuse: color.unwrap_or(plain.diffuse),
            ..plain
        }
    };
    Ok((colors.iter().enumerate().map(material).collect(), prisms))
}

/// The text to write.
fn text(args: &TextArgs) -> Result<String, Failure> {
    let path = match (&args.text, &args.file) {
        (Some(text), _) if text != "-" => return Ok(text.replace("\\n", "\n")),
        (_, Some(path)) => path,
        _ => Path::new("-"),
    };
    let bytes = read_bytes(path)?;
    let path = path.display();
    if bytes.len() > LONGEST {
        let message = format!("{path}: {} bytes, expected at most {LONGEST}", bytes.len());
        return Err(Failure::Failed(message));
    }
    let text = String::from_utf8(bytes).map_err(|e| {
        let place = e.utf8_error().valid_up_to();
        Failure::failed(format_args!("{path}: byte {place}: expected UTF-8"))
    })?;
    Ok(match text.strip_prefix('\u{feff}') {
        Some(behind) => behind.to_owned(),
        None => text,
    })
}

/// The first words of the text, as a name.
fn title(text: &str) -> String {
    const LONGEST_NAME: usize = 40;
    let line = text.lines().map(str::trim).find(|l| !l.is_empty());
    let letters = line.unwrap_or("text").chars().filter(|c| !c.is_control());
    letters.take(LONGEST_NAME).collect()
}
