//! Item buffers on graphics cards, through Vulkan and OpenGL, without a display.
//!
//! [`Card`] is a [`Device`](azulejo_trace::item_buffer::Device) of `azulejo-trace`: it draws the
//! hemicubes that the processor draws there in software, with the same results except for pixels
//! on edges. Mesa's software drivers count as cards too; [`Card::is_software`] identifies them.
//!
//! A world stays in the card's memory, in clusters of triangles that are near each other
//! (`mesh`). Hemicubes stand side by side in one atlas (`atlas`), each face a viewport in which
//! the clusters are drawn that can be in it (`face`, `draw.wgsl`). What the pixels show is added
//! up on the card (`sum.wgsl`) or read back and added up by the processor (`tally`); pixels that
//! show mirrors continue into reflected worlds in either case (`view_traversal`).
//!
//! ```
//! use azulejo_gpu::{Backend, Card};
//!
//! match Card::open(Backend::Auto) {
//!     Ok(card) => assert!(!azulejo_trace::item_buffer::Device::name(&card).is_empty()),
//!     Err(missing) => assert!(missing.to_string().contains("driver")),
//! }
//! ```

mod atlas;
mod buffers;
mod card;
mod face;
mod mesh;
mod pipelines;
mod tally;
mod target;
#[cfg(test)]
mod tests;
mod view_traversal;

pub use card::{Backend, Card, Reduction};
