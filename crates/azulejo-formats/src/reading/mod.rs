//! The basis of every reader: bytes, text and numbers, the files around a model, options,
//! errors and warnings, and format recognition. Nothing here depends on the content of a format.

pub(crate) mod base64;
pub(crate) mod bytes;
pub(crate) mod cursor;
pub(crate) mod detect;
pub(crate) mod error;
pub(crate) mod files;
pub(crate) mod fonts;
pub(crate) mod fortran;
pub(crate) mod gzip;
pub(crate) mod include;
pub(crate) mod json;
pub(crate) mod lexer;
pub(crate) mod number;
pub(crate) mod options;
pub(crate) mod text;
pub(crate) mod warnings;
pub(crate) mod words;
pub(crate) mod xml;
