//! Pictures of a scene by the graphics card, or by a driver that does without one.
//!
//! Data in, picture out: a [`ViewportFrame`] says what is to be seen and how, a [`Renderer`] draws it into
//! a texture of its own, which egui shows and [`Renderer::read`] reads back. Nothing here knows
//! the document or the window.
//!
//! | module | what it does |
//! |---|---|
//! | `frame`, `overlay` | what is to be drawn, as plain data |
//! | `projection` | from the world to the picture, in `f64` |
//! | `walk`, `geometry` | polygons to vertices and triangles, and these to the card |
//! | `textures`, `blocks` | textures and numbers to the card |
//! | `pipelines`, `draw.wgsl` | what the card runs |
//! | `pass`, `renderer`, `target` | the order of drawing, and what is drawn into |
//! | `display` | polygons of exact shapes, as fine as the view shows |
//! | `pick` | what a ray or a rectangle meets |
//! | `device`, `error` | opening a card, and what can go wrong |

mod color_map;
mod device;
mod error;
mod frame;
mod geometry;
mod mesh_pieces;
mod overlay;
mod pass;
mod pick;
mod pipelines;
mod projection;
mod renderer;
mod target;
mod tessellate;
#[cfg(test)]
mod tests;
mod textures;
mod uniforms;

pub use device::HeadlessDevice;
pub use error::GpuError;
pub use frame::{
    Background, ColorScalar, ColorScale, FaceValues, MeshInstance, TextureSource, ViewportFrame,
};
pub use overlay::{Overlay, OverlayLine, OverlayStyle, OverlayTriangle};
pub use pick::{PickHit, pick, pick_rectangle};
pub use projection::Projection;
pub use renderer::{DrawnFrame, RenderStatistics, Renderer};
pub use target::PixelBuffer;
pub use tessellate::{chord_error, display_mesh};
