//! SVG drawings: their filled and stroked shapes.
//!
//! Paths and basic shapes become [`Figure`](azulejo_scene::Figure)s, with all transforms applied,
//! y up, and arcs as cubic curves; letters become the outlines of a font. Images are left out and counted.
//! `docs/formats/svg.md` documents how every element is interpreted.

mod clip;
mod first_path;
mod path;
mod shapes;
mod stroke;
mod style;
mod style_sheet;
#[cfg(test)]
mod tests;
#[cfg(feature = "fonts")]
mod text;
mod values;
mod viewport;
mod walk;

pub use first_path::first_path;

use crate::outline::drawing::Drawing;
use crate::reading::text::decoded_text;
use crate::reading::xml::crowded_element;
use crate::{Files, ReadError, ReadOptions};
use roxmltree::{Document, ParsingOptions};

/// Reads a drawing. `name` is used in messages; `files` provides fonts.
///
/// # Errors
/// XML that is not well-formed or declares entities, another element than `svg`, and a drawing
/// that expands to more than `options` allow. Anything less is left out with a warning.
pub fn read(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<Drawing, ReadError> {
    with_document(bytes, name, |xml| walk::read(xml, name, files, options))
}

/// Parses a drawing, and hands it on.
fn with_document<T>(
    bytes: &[u8],
    name: &str,
    then: impl FnOnce(&Document) -> Result<T, ReadError>,
) -> Result<T, ReadError> {
    let text = decoded_text(bytes);
    if let Some(at) = text.find("<!ENTITY") {
        // An entity may stand for a megabyte, and be referenced a million times.
        let (found, expected) = ("XML that declares entities of its own", "SVG without them");
        return Err(ReadError::at_byte(name, at as u64, found, expected));
    }
    if let Some((at, found)) = crowded_element(&text) {
        let expected = "elements as those of drawings";
        return Err(ReadError::at_byte(name, at as u64, found, expected));
    }
    let parsing = ParsingOptions {
        allow_dtd: true,
        ..ParsingOptions::default()
    };
    let xml = Document::parse_with_options(&text, parsing).map_err(|e| {
        let place = e.pos();
        let found = format!("XML that is not well-formed ({e})");
        ReadError::at_line(name, &text, place.row, place.col, found, "an SVG drawing")
    })?;
    let root = xml.root_element();
    if root.tag_name().name() != "svg" {
        let found = format!(
            "the element {}",
            crate::reading::text::shortened(root.tag_name().name())
        );
        return Err(ReadError::whole(name, found, "the element svg"));
    }
    then(&xml)
}

/// Whether bytes are XML with an element `svg` near the beginning.
pub(crate) fn is_svg(bytes: &[u8]) -> bool {
    const LOOKED_AT: usize = 1 << 14;
    let head = &bytes[..bytes.len().min(LOOKED_AT)];
    let start = head.trim_ascii_start();
    let mut words = head
        .windows(5)
        .filter(|w| w.starts_with(b"<svg") || w.ends_with(b":svg"));
    start.starts_with(b"<") && words.next().is_some()
}
