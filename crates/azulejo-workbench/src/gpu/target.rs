//! The render target and its readback.

use super::GpuError;
use std::sync::mpsc::channel;

/// The format that egui displays: bytes that are already sRGB.
pub const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
pub const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Samples per pixel with antialiasing.
pub const SAMPLES: u32 = 4;

/// The pixels of an image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PixelBuffer {
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// sRGB and opacity, which is always 255, row by row from the upper left corner.
    pub rgba: Vec<u8>,
}

impl PixelBuffer {
    /// The sRGB colour in column `x`, row `y`.
    ///
    /// # Panics
    ///
    /// If the position is outside the image.
    pub fn color(&self, x: u32, y: u32) -> [u8; 3] {
        let start = 4 * (y as usize * self.width as usize + x as usize);
        [0, 1, 2].map(|k| self.rgba[start + k])
    }

    /// Without opacity: three bytes per pixel.
    pub fn rgb(&self) -> Vec<u8> {
        let pixels = self.rgba.chunks_exact(4);
        pixels.flat_map(|p| [p[0], p[1], p[2]]).collect()
    }
}

/// Textures of the same size.
pub struct RenderTarget {
    pub size: [u32; 2],
    pub samples: u32,
    texture: wgpu::Texture,
    pub view: wgpu::TextureView,
    many: Option<wgpu::TextureView>,
    depth: wgpu::TextureView,
}

impl RenderTarget {
    pub fn new(device: &wgpu::Device, size: [u32; 2], samples: u32) -> RenderTarget {
        use wgpu::TextureUsages as Usage;
        let make = |format, samples, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some("viewport"),
                size: extent(size),
                mip_level_count: 1,
                sample_count: samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let view = |t: &wgpu::Texture| t.create_view(&wgpu::TextureViewDescriptor::default());
        let drawn = Usage::RENDER_ATTACHMENT;
        let shown = Usage::TEXTURE_BINDING | Usage::COPY_SRC;
        let texture = make(COLOR, 1, drawn | shown);
        RenderTarget {
            size,
            samples,
            view: view(&texture),
            many: (samples > 1).then(|| view(&make(COLOR, samples, drawn))),
            depth: view(&make(DEPTH, samples, drawn)),
            texture,
        }
    }

    /// Begins a render pass that clears the target.
    pub fn begin<'a>(&self, encoder: &'a mut wgpu::CommandEncoder) -> wgpu::RenderPass<'a> {
        let (view, resolve_target, store) = match &self.many {
            Some(many) => (many, Some(&self.view), wgpu::StoreOp::Discard),
            None => (&self.view, None, wgpu::StoreOp::Store),
        };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("viewport"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations {
                    // Infinitely far, since depth is reversed.
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        })
    }

    /// Waits for the image and copies it.
    pub fn read(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<PixelBuffer, GpuError> {
        let [width, height] = self.size;
        let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let back = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("way back"),
            size: u64::from(row) * u64::from(height),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            self.texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &back,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row),
                    rows_per_image: None,
                },
            },
            extent(self.size),
        );
        queue.submit([encoder.finish()]);
        let rows = mapped(device, &back)?;
        let rgba = rows.chunks_exact(row as usize);
        Ok(PixelBuffer {
            width,
            height,
            rgba: rgba
                .flat_map(|r| &r[..4 * width as usize])
                .copied()
                .collect(),
        })
    }
}

/// The content of a buffer after the GPU has finished with it.
fn mapped(device: &wgpu::Device, buffer: &wgpu::Buffer) -> Result<Vec<u8>, GpuError> {
    let lost = |reason: String| GpuError::Lost { reason };
    let (sender, outcome) = channel();
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        // The receiver is gone if another error came first.
        let _ = sender.send(result);
    });
    let polled = device.poll(wgpu::PollType::wait_indefinitely());
    polled.map_err(|e| lost(e.to_string()))?;
    let outcome = outcome.try_recv().map_err(|e| lost(e.to_string()))?;
    outcome.map_err(|e| lost(e.to_string()))?;
    let view = buffer.get_mapped_range(..);
    let bytes = view.map_err(|e| lost(e.to_string()))?.to_vec();
    buffer.unmap();
    Ok(bytes)
}

fn extent([width, height]: [u32; 2]) -> wgpu::Extent3d {
    wgpu::Extent3d {
        width,
        height,
        depth_or_array_layers: 1,
    }
}
