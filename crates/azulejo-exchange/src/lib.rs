//! Radiative exchange between surfaces, from their form factors.
//!
//! An [`Enclosure`] is a matrix of form factors together with its rows: their names, corners and
//! reflectances. It needs no scene, and is what [`archive`] stores in an `.npz` and reads again.
//!
//! | read in this order | purpose |
//! |---|---|
//! | [`enclosure`] | form factors with a description of their rows, grouped by face, object or material |
//! | [`archive`] | the same as an `.npz` |
//! | [`files`] | files of other programs |

pub mod archive;
pub mod enclosure;
pub mod files;

pub use enclosure::{CellMesh, Enclosure, GroupBy, Groups, OutsideLight, RowTable};
