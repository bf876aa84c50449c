//! Typefaces as computers have them: TrueType, OpenType, Type 1, and text set in them.
//!
//! Outlines come without hinting, in ems, y up, and as the font draws them: quadratic curves
//! become the cubic ones that they are, and contours that overlap are filled as one
//! ([`FillRule::NonZero`]). A variable font is read where its axes begin; glyphs that are
//! pictures or painted in colours are not drawn.

mod convert;
mod face;
mod names;
mod overlap;
mod set;

pub use convert::Converted;
pub use face::{SettingError, Typeface};
pub use names::encoding_of;
pub use set::Setting;
