//! What the crate does for its users.

mod atlas;
mod browser;
mod page;
mod room;
mod swatches;
mod viewers;
