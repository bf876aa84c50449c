//! Item buffers on graphics cards, through Vulkan and OpenGL, without a display.
//!
//! [`Card`] is a [`Device`](azulejo_trace::item_buffer::Device) of `azulejo-trace`: it draws the
//! same hemicubes as the processor does in software, with the same results except for pixels on
//! edges. Mesa's software drivers count as cards too; [`Card::is_software`] identifies them.
//!
//! A world stays in the card's memory, in clusters of nearby triangles (`mesh`). Hemicubes are
//! tiles of one atlas (`atlas`), and each face is a viewport into which the potentially visible
//! clusters are drawn (`face`, `draw.wgsl`). Form factors are summed on the card (`sum.wgsl`) or
//! read back and summed by the processor (`tally`); pixels that show mirrors continue into
//! reflected worlds in either case (`view_traversal`).
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
mod shared;
mod tally;
mod target;
#[cfg(test)]
mod tests;
mod view_traversal;

pub use card::{Backend, Card};
pub use shared::Reduction;
