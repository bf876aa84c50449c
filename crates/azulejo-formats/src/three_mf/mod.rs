//! 3D Manufacturing Format, `.3mf`, for printers: written only.
//!
//! Core specification 1.3 of the 3MF Consortium. `docs/formats/3mf.md` has the details.

#[cfg(test)]
mod tests;
mod write;

pub use write::{losses, write, write_within};
