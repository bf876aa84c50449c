//! `text`: converts a string to solid letters.

use super::args::TextArgs;
use super::{solid, typeface};
use crate::failure::Failure;
use crate::report::Report;
use crate::session::Session;
use azulejo::models::ModelOutput;
use azulejo::models::read_bytes;
use azulejo_scene::Rgb;
use std::path::Path;

/// Largest length of a text; letters share their outlines, but each has its own prism.
const LONGEST: usize = 1 << 20;

/// Runs `text`.
pub fn run(args: &TextArgs, session: &mut Session) -> Result<Report, Failure> {
    let output = ModelOutput::check(&args.output)?;
    session.claim_stdout(output.is_stdout())?;
    let text = text(args)?;
    let glyphs = typeface::set(&text, &args.typeface, &args.lines, session)?;
    let (size, depth) = (args.solid.size, args.solid.depth);
    let depth = depth.unwrap_or(0.25 * size);
    let frame = args.frame.frame(size, depth);
    let bevel = args.edge.bevel(size, depth)?;
    let name = args.surface.name.clone().unwrap_or_else(|| title(&text));
    let material = args.surface.material(&name, Rgb::grey(0.7));
    let mut prisms = frame.prisms(&glyphs, 0);
    prisms.iter_mut().for_each(|p| p.bevel.clone_from(&bevel));
    let scene = solid::scene(&name, vec![material], prisms)?;
    solid::write(&scene, &output, &args.output, session)
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
