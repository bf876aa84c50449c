//! VRML 1.0, VRML97 and X3D, the latter in XML or in the classic encoding.
//!
//! Three grammars lead into two sorts of scene: VRML 1.0 is a stream of nodes that change a state
//! (`v1`); VRML97 and X3D are a tree of nodes with fields. Both put their objects on one
//! stage, because files of one version may stand inside files of another.
//! `docs/formats/vrml.md` says how every node is understood.

mod appearance;
mod builder;
mod classic;
mod elevation;
mod environment;
mod extrusion;
mod faces;
mod flat;
mod lexer;
mod lights;
mod names;
mod shape;
mod solid;
mod solids;
#[cfg(test)]
mod tests;
mod tree;
mod triangles;
mod v1;
mod world;
mod xml;

use crate::{Files, Loaded, ReadError, ReadOptions};
use builder::{OpenedFile, VrmlPlacement, VrmlSceneBuilder, VrmlSource};
use std::rc::Rc;
use tree::VrmlDocument;

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
    let source = Rc::new(VrmlSource::model(name, bytes));
    let mut builder = VrmlSceneBuilder::new(name, files, options);
    read_into(&mut builder, &source, &VrmlPlacement::default())?;
    Ok(builder.finish(name))
}

/// Reads a file and puts what it holds under `frame`: the model itself, or a file inside it.
///
/// # Errors
/// As [`read`].
fn read_into(
    builder: &mut VrmlSceneBuilder,
    source: &Rc<VrmlSource>,
    frame: &VrmlPlacement,
) -> Result<(), ReadError> {
    if v1::is_meant(source.text()) {
        return v1::read_into(builder, source, frame);
    }
    let document = document(builder, source)?;
    world::build(builder, &document, frame)
}

/// Reads a file of nodes with fields.
///
/// # Errors
/// A header of another version, text of which nothing could be used.
fn document(
    builder: &mut VrmlSceneBuilder,
    source: &Rc<VrmlSource>,
) -> Result<Rc<VrmlDocument>, ReadError> {
    let text = source.text();
    let document = match text.trim_ascii_start() {
        [b'#', b'V' | b'X', ..] => classic::parse(builder, source)?,
        [b'<', ..] => xml::parse(builder, source)?,
        _ => {
            let mut lexer = lexer::VrmlLexer::new(&source.bytes);
            let expected = "\"#VRML V2.0 utf8\", \"#VRML V1.0 ascii\", \"#X3D V3.3 utf8\" or XML";
            return Err(lexer.error(&source.name, expected));
        }
    };
    let document = Rc::new(document);
    builder.know(source, &document);
    Ok(document)
}

/// Reads the first file of `urls` that can be had into `frame`: the node `Inline` of any version,
/// which stands at the byte `at` of `from`. What is wrong with the file is a warning.
///
/// # Errors
/// The model unfolds to more than the options allow.
fn include(
    builder: &mut VrmlSceneBuilder,
    from: &VrmlSource,
    at: usize,
    urls: &[String],
    frame: &VrmlPlacement,
) -> Result<(), ReadError> {
    let done = match builder.open(from, at, urls) {
        None => return Ok(()),
        Some(OpenedFile::Known(document)) => world::build(builder, &document, frame),
        Some(OpenedFile::New(source)) => match read_into(builder, &source, frame) {
            Err(e) => refuse(builder, from, at, &source, e),
            Ok(()) => Ok(()),
        },
    };
    builder.close();
    done
}

/// Makes a warning of what is wrong with the file `inside` this one.
///
/// # Errors
/// What is wrong with the model as a whole.
fn refuse(
    builder: &mut VrmlSceneBuilder,
    from: &VrmlSource,
    at: usize,
    inside: &VrmlSource,
    e: ReadError,
) -> Result<(), ReadError> {
    if e.file != inside.name {
        return Err(e);
    }
    let (place, found, expected) = (e.position, e.found, e.expected);
    let why = format!("{}{place}: found {found}, expected {expected}", e.file);
    builder.warn(
        from,
        at,
        format!("a file inside this one is not shown: {why}"),
    );
    Ok(())
}
