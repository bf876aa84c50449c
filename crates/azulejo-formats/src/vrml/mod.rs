//! VRML 1.0, VRML97 and X3D, the latter in the XML or the classic encoding.
//!
//! Three grammars lead to two data models: VRML 1.0 is a stream of nodes that change a traversal
//! state (`v1`); VRML97 and X3D are a tree of nodes with fields. Both add their objects to the same
//! scene builder, because files of one version may be nested in files of another.
//! `docs/formats/vrml.md` describes how every node is interpreted.

mod appearance;
mod background;
mod builder;
mod classic;
mod elevation;
mod environment;
mod extrusion;
mod faces;
mod flat;
mod lexer;
mod lights;
mod markup;
mod names;
mod shape;
mod solid;
mod solids;
#[cfg(test)]
mod tests;
#[cfg(feature = "fonts")]
mod text;
mod tree;
mod triangles;
mod v1;
mod world;
mod write;
mod xml;

pub use write::{losses, write, write_x3d};

use crate::{Files, Loaded, ReadError, ReadOptions};
use builder::{OpenedFile, VrmlPlacement, VrmlSceneBuilder, VrmlSource};
use std::rc::Rc;
use tree::VrmlDocument;

/// Reads a model and the files that it refers to.
///
/// # Errors
/// An unknown version in the header, text without usable content, and a model that unfolds to more
/// than `options` allow.
pub fn read(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    let source = Rc::new(VrmlSource::model(name, bytes));
    let mut builder = VrmlSceneBuilder::new(name, files, options);
    builder.read_into(&source, &VrmlPlacement::default())?;
    Ok(builder.finish(name))
}

impl VrmlSceneBuilder<'_> {
    /// Reads a file and adds its content under `frame`: the model itself, or a nested file.
    ///
    /// # Errors
    /// As [`read`].
    fn read_into(
        &mut self,
        source: &Rc<VrmlSource>,
        frame: &VrmlPlacement,
    ) -> Result<(), ReadError> {
        if v1::is_meant(&source.bytes) {
            return v1::read_into(self, source, frame);
        }
        let document = self.document(source)?;
        world::build(self, &document, frame)
    }

    /// Reads a file of nodes with fields.
    ///
    /// # Errors
    /// An unknown version in the header, text without usable content.
    fn document(&mut self, source: &Rc<VrmlSource>) -> Result<Rc<VrmlDocument>, ReadError> {
        let text = &source.bytes;
        let document = match text.trim_ascii_start() {
            [b'#', b'V' | b'X', ..] => classic::parse(self, source)?,
            [b'<', ..] => xml::parse(self, source)?,
            _ => {
                let mut lexer = lexer::VrmlLexer::new(&source.bytes);
                let expected =
                    "\"#VRML V2.0 utf8\", \"#VRML V1.0 ascii\", \"#X3D V3.3 utf8\" or XML";
                return Err(lexer.error(&source.name, expected));
            }
        };
        let document = Rc::new(document);
        self.remember(source, &document);
        Ok(document)
    }

    /// Reads the first file of `urls` that exists into `frame`: the node `Inline` of any version, at
    /// byte `at` of `from`. Problems of the file become warnings.
    ///
    /// # Errors
    /// The model unfolds to more than the options allow.
    fn include(
        &mut self,
        from: &VrmlSource,
        at: usize,
        urls: &[String],
        frame: &VrmlPlacement,
    ) -> Result<(), ReadError> {
        let done = match self.open(from, at, urls) {
            None => return Ok(()),
            Some(OpenedFile::Known(document)) => world::build(self, &document, frame),
            Some(OpenedFile::New(source)) => match self.read_into(&source, frame) {
                Err(e) => self.refuse(from, at, &source, e),
                Ok(()) => Ok(()),
            },
        };
        self.close();
        done
    }

    /// Turns an error in the nested file `inside` into a warning.
    ///
    /// # Errors
    /// Errors that concern the model as a whole.
    fn refuse(
        &mut self,
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
        self.warn(from, at, format!("nested file skipped: {why}"));
        Ok(())
    }
}
