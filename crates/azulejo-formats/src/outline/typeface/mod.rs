//! Typefaces in TrueType, OpenType and Type 1, and text set in them.
//!
//! Outlines are without hinting, in ems, y up, and as the font draws them: quadratic curves
//! are exactly converted to cubic ones, and overlapping contours are filled as one
//! ([`FillRule::NonZero`](azulejo_scene::FillRule::NonZero)). A variable font is read at the default of its axes; bitmap and
//! colour glyphs are not drawn.

mod convert;
mod face;
mod metrics;
mod names;
mod overlap;
mod set;

pub use convert::Converted;
pub use face::{SettingError, Typeface};
pub use names::encoding_of;
pub use set::Setting;
