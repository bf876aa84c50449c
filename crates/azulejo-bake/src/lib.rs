//! Lightmaps of solved scenes, and web pages that show them.

pub mod page;
