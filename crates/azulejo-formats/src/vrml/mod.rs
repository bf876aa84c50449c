//! VRML 1.0, VRML97 and X3D, the latter in XML or in the classic encoding.
//!
//! Three grammars lead into two sorts of scene: VRML 1.0 is a stream of nodes that change a state
//! ([`v1`]); VRML97 and X3D are a tree of nodes with fields. Both put their objects on one
//! stage, because files of one version may stand inside files of another.
//! `docs/formats/vrml.md` says how every node is understood.

#[allow(dead_code, reason = "the readers that use it follow")]
mod faces;
#[allow(dead_code, reason = "the readers that use it follow")]
mod lexer;
#[allow(dead_code, reason = "the readers that use it follow")]
mod stage;

use crate::{Files, Loaded, ReadError, ReadOptions};
use stage::{Frame, Source, Stage};

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
    let source = Source {
        name: name.to_owned(),
        bytes: crate::text::without_utf16(bytes).into_owned(),
    };
    let mut stage = Stage::new(name, files, options);
    read_into(&mut stage, &source, &Frame::default())?;
    Ok(stage.finish(name))
}

/// Reads a file and puts what it holds under `frame`: the model itself, or a file inside it.
///
/// # Errors
/// As [`read`].
fn read_into(_stage: &mut Stage, source: &Source, _frame: &Frame) -> Result<(), ReadError> {
    // VRML 1.0 and Inventor plug in here: v1::read_into(stage, source, frame).
    Err(ReadError::whole(&*source.name, "VRML", "another format"))
}

/// Reads the first file of `urls` that can be had into `frame`: the node `Inline` of any version,
/// which stands at the byte `at` of `from`. What is wrong with the file is a warning.
///
/// # Errors
/// The model unfolds to more than the options allow.
#[allow(dead_code, reason = "the readers that use it follow")]
fn include(
    stage: &mut Stage,
    from: &Source,
    at: usize,
    urls: &[String],
    frame: &Frame,
) -> Result<(), ReadError> {
    let Some(source) = stage.open(from, at, urls) else {
        return Ok(());
    };
    let read = read_into(stage, &source, frame);
    stage.close();
    match read {
        Err(e) if e.file == source.name => {
            stage.warn(
                from,
                at,
                format!("a file inside this one is not shown: {e}"),
            );
            Ok(())
        }
        read => read,
    }
}
