//! 3D Manufacturing Format, `.3mf`, for printers.
//!
//! Core specification 1.3 of the 3MF Consortium, with colours and textures of the Materials and Properties Extension and
//! the parts of the Production Extension, which are read. `docs/formats/3mf.md` has the details.

mod package;
mod part;
mod properties;
mod read;
#[cfg(test)]
mod read_tests;
#[cfg(test)]
mod tests;
mod write;

pub use read::read;
pub use write::{losses, write, write_within};

/// The units of 3MF by their length in metres.
const UNITS: [(&str, f64); 6] = [
    ("micron", 1e-6),
    ("millimeter", 1e-3),
    ("centimeter", 1e-2),
    ("inch", 0.0254),
    ("foot", 0.3048),
    ("meter", 1.0),
];
