//! The page around the data.

use super::light::LightCodes;
use super::planes::deflate;
use super::{PageModel, base64, geometry, head};
use std::io::{self, Write};

/// The page: what is before the title, between title and style, between style and data, and so on.
const TEMPLATE: &str = include_str!("viewer.html");

const STYLE: &str = include_str!("viewer.css");

/// Shaders, by the identifier of their script element.
const SHADERS: [(&str, &str); 2] = [
    ("surface-vertex", include_str!("surface.vert.glsl")),
    ("surface-fragment", include_str!("surface.frag.glsl")),
];

/// The viewer, in the order in which its parts use each other.
const PROGRAM: [&str; 9] = [
    include_str!("js/vectors.js"),
    include_str!("js/decode.js"),
    include_str!("js/surfaces.js"),
    include_str!("js/renderer.js"),
    include_str!("js/navigation.js"),
    include_str!("js/exposure.js"),
    include_str!("js/legend.js"),
    include_str!("js/interface.js"),
    include_str!("js/main.js"),
];

/// Writes the page of a valid model.
pub(super) fn write(model: &PageModel, out: &mut dyn Write) -> io::Result<()> {
    // Parts are written one after another and never searched again, so that data which look like
    // the name of a part stay data.
    for part in TEMPLATE.split("{{") {
        let (name, text) = part.split_once("}}").unwrap_or(("", part));
        match name {
            "title" => out.write_all(escaped(head::title(model)).as_bytes())?,
            "style" => out.write_all(STYLE.as_bytes())?,
            "shaders" => write_shaders(out)?,
            "data" => write_data(model, out)?,
            "program" => write_program(out)?,
            _ => {}
        }
        out.write_all(text.as_bytes())?;
    }
    Ok(())
}

fn write_shaders(out: &mut dyn Write) -> io::Result<()> {
    for (id, source) in SHADERS {
        writeln!(
            out,
            "<script type=\"x-shader\" id=\"{id}\">{source}</script>"
        )?;
    }
    Ok(())
}

fn write_program(out: &mut dyn Write) -> io::Result<()> {
    out.write_all(b"\"use strict\";\n(() => {\n")?;
    for part in PROGRAM {
        out.write_all(part.as_bytes())?;
    }
    out.write_all(b"})();\n")
}

fn write_data(model: &PageModel, out: &mut dyn Write) -> io::Result<()> {
    let light: Vec<LightCodes> = model.lightmaps.iter().map(LightCodes::new).collect();
    let head = head::json(model, &light);
    writeln!(
        out,
        "<script type=\"application/json\" id=\"head\">{head}</script>"
    )?;
    write_piece("geometry", &deflate(&geometry::bytes(model))?, out)?;
    for (k, codes) in light.iter().enumerate() {
        write_piece(&format!("light-{k}"), &deflate(&codes.bytes)?, out)?;
    }
    let pictures = model.materials.iter().filter_map(|m| m.picture.as_ref());
    for (k, picture) in pictures.enumerate() {
        write_piece(&format!("picture-{k}"), &picture.bytes, out)?;
    }
    Ok(())
}

/// Writes bytes as an element that no browser executes.
fn write_piece(id: &str, bytes: &[u8], out: &mut dyn Write) -> io::Result<()> {
    write!(out, "<script type=\"x-data\" id=\"{id}\">")?;
    base64::write(bytes, out)?;
    out.write_all(b"</script>\n")
}

/// Text for the content of an element.
pub(super) fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            c if c.is_control() => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}
