//! Drawing a scene with the GPU or a software driver.
//!
//! Plain data in, pixels out: a [`ViewportFrame`] describes what to draw, a [`Renderer`] draws it
//! into a texture of its own, which egui displays and [`Renderer::read`] reads back. Nothing here
//! depends on the document or the window.
//!
//! | module | purpose |
//! |---|---|
//! | `frame`, `overlay` | the input of the renderer, as plain data |
//! | `mesh_pieces`, `geometry` | polygons to vertices and triangles, and their upload |
//! | `textures`, `lightmap`, `uniforms` | upload of textures, lightmaps and uniform data |
//! | `pipelines`, `draw.wgsl` | pipelines and shaders |
//! | `pass`, `renderer`, `target` | the render pass and its target |
//! | `tessellate` | polygons of exact shapes, as fine as the view requires |
//! | `pick` | intersection with a ray or a selection rectangle |
//! | `device`, `error` | opening a device, and its errors |

mod color_map;
mod device;
mod error;
mod frame;
mod geometry;
mod lightmap;
mod mesh_pieces;
mod outline;
mod overlay;
mod pass;
mod pick;
mod pipelines;
mod renderer;
mod target;
mod tessellate;
#[cfg(test)]
mod tests;
mod textures;
mod ticks;
mod uniforms;

pub use crate::projection::Projection;
pub use device::HeadlessDevice;
pub use error::GpuError;
pub use frame::{
    Background, ColorScalar, ColorScale, DrawnMesh, FaceValues, TextureSource, ViewportFrame,
};
pub use lightmap::LightmapPages;
pub use overlay::{Overlay, OverlayLine, OverlayStyle, OverlayTriangle};
pub use pick::{Cutaway, PickHit, pick, pick_rectangle};
pub use renderer::{DrawnFrame, RenderStatistics, Renderer};
pub use target::PixelBuffer;
pub use tessellate::{chord_error, display_mesh};
