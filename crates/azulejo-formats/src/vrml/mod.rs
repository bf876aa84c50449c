//! VRML 1.0, VRML97 and X3D, the latter in XML or in the classic encoding.
//!
//! Three grammars lead into two sorts of scene: VRML 1.0 is a stream of nodes that change a state
//! (`v1`); VRML97 and X3D are a tree of nodes with fields. Both put their objects on one
//! stage, because files of one version may stand inside files of another.
//! `docs/formats/vrml.md` says how every node is understood.

mod classic;
mod elevation;
mod extrusion;
mod faces;
mod flat;
mod lexer;
mod lights;
mod look;
mod names;
mod shape;
mod solid;
mod solids;
mod stage;
mod surroundings;
#[cfg(test)]
mod tests;
mod tree;
mod triangles;
mod v1;
mod world;
mod xml;

use crate::{Files, Loaded, ReadError, ReadOptions};
use stage::{Frame, Opened, Source, Stage};
use std::rc::Rc;
use tree::Document;

/// Reads a model, with the files that it names.
///
/// # Errors
/// A header of no version that is known, text of which nothing could be used, and a model that
/// unfolds to more than `options` allow.
pub fn read(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    let source = Rc::new(Source::model(name, bytes));
    let mut stage = Stage::new(name, files, options);
    read_into(&mut stage, &source, &Frame::default())?;
    Ok(stage.finish(name))
}

/// Reads a file and puts what it holds under `frame`: the model itself, or a file inside it.
///
/// # Errors
/// As [`read`].
fn read_into(stage: &mut Stage, source: &Rc<Source>, frame: &Frame) -> Result<(), ReadError> {
    if v1::is_meant(&source.bytes) {
        return v1::read_into(stage, source, frame);
    }
    let document = document(stage, source)?;
    world::build(stage, &document, frame)
}

/// Reads a file of nodes with fields.
///
/// # Errors
/// A header of another version, text of which nothing could be used.
fn document(stage: &mut Stage, source: &Rc<Source>) -> Result<Rc<Document>, ReadError> {
    let text = &source.bytes;
    let document = match text.trim_ascii_start() {
        [b'#', b'V' | b'X', ..] => classic::parse(stage, source)?,
        [b'<', ..] => xml::parse(stage, source)?,
        _ => {
            let mut lexer = lexer::Lexer::new(&source.bytes);
            let expected = "\"#VRML V2.0 utf8\", \"#VRML V1.0 ascii\", \"#X3D V3.3 utf8\" or XML";
            return Err(lexer.error(&source.name, expected));
        }
    };
    let document = Rc::new(document);
    stage.know(source, &document);
    Ok(document)
}

/// Reads the first file of `urls` that can be had into `frame`: the node `Inline` of any version,
/// which stands at the byte `at` of `from`. What is wrong with the file is a warning.
///
/// # Errors
/// The model unfolds to more than the options allow.
fn include(
    stage: &mut Stage,
    from: &Source,
    at: usize,
    urls: &[String],
    frame: &Frame,
) -> Result<(), ReadError> {
    let done = match stage.open(from, at, urls) {
        None => return Ok(()),
        Some(Opened::Known(document)) => world::build(stage, &document, frame),
        Some(Opened::New(source)) => match read_into(stage, &source, frame) {
            Err(e) => refuse(stage, from, at, &source, e),
            Ok(()) => Ok(()),
        },
    };
    stage.close();
    done
}

/// Makes a warning of what is wrong with the file `inside` this one.
///
/// # Errors
/// What is wrong with the model as a whole.
fn refuse(
    stage: &mut Stage,
    from: &Source,
    at: usize,
    inside: &Source,
    e: ReadError,
) -> Result<(), ReadError> {
    if e.file != inside.name {
        return Err(e);
    }
    let (place, found, expected) = (e.position, e.found, e.expected);
    let why = format!("{}{place}: found {found}, expected {expected}", e.file);
    stage.warn(
        from,
        at,
        format!("a file inside this one is not shown: {why}"),
    );
    Ok(())
}
