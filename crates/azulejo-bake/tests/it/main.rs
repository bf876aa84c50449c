//! What the crate does for its users.

mod atlas;
mod browser;
mod check;
mod crowded;
mod room;
mod swatches;
mod viewers;
mod web_page;
