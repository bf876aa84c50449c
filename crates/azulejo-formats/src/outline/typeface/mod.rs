//! Typefaces in TrueType, OpenType and Type 1, and text set in them.
//!
//! Outlines are without hinting, in ems, y up, and as the font draws them: quadratic curves
//! are exactly converted to cubic ones, and overlapping contours are filled as one
//! ([`FillRule::NonZero`](azulejo_scene::FillRule::NonZero)). A variable font is read at the default of its axes until
//! [`vary`] moves it. Glyphs in colours are layers of one colour each; those that are bitmaps are not drawn.

mod afm;
mod color;
mod convert;
mod face;
mod features;
mod metrics;
mod names;
mod overlap;
mod runs;
mod set;
mod shape;
mod styled;
mod unpack;

pub use color::ColorLoss;
pub use convert::Converted;
pub use face::{FontFace, SettingError, Typeface};
pub use features::{AxisValue, FontAxis, FontFeature, VariationError, vary};
pub use names::encoding_of;
pub use set::{Layout, Setting};
pub use styled::{MarkupError, Span, Style, StyledText};
