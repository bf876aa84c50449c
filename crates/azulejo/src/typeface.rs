//! DejaVu Serif, the typeface that is part of the programs.
//!
//! Plots and new lettering need one that is the same on every machine. Its licence is in
//! `fonts/LICENSE-DEJAVU`; `examples/fonts` has the same files for the command line.

/// The outlines, as a PPF font.
pub const DEJAVU_SERIF: &[u8] = include_bytes!("../fonts/dejavu-serif.ppf");

/// The encoding of Latin-1, as PPE.
pub const LATIN: &[u8] = include_bytes!("../fonts/latin.ppe");
