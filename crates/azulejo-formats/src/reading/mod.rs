//! What every reader stands on: bytes, text and numbers, the files around a model, options,
//! errors and warnings, and which format bytes are in. Nothing here knows a format's content.

pub(crate) mod bytes;
pub(crate) mod detect;
pub(crate) mod error;
pub(crate) mod files;
pub(crate) mod gzip;
pub(crate) mod lexer;
pub(crate) mod number;
pub(crate) mod options;
pub(crate) mod text;
pub(crate) mod warnings;
pub(crate) mod words;
