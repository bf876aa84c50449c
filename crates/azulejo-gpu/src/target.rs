//! Textures to draw into, and their readback.

use crate::atlas::Atlas;
use crate::face::{FaceDrawing, WORDS};
use crate::mesh::Mesh;
use crate::pipelines::{DEPTH, NUMBERS};
use crate::shared::{Reduction, Shared};
use azulejo_trace::item_buffer::DrawError;
use std::sync::mpsc::{Receiver, channel};

/// The side of a pixel that shows none.
pub const NOTHING: u32 = u32::MAX;

/// Largest number of drawings in a submission: it limits the memory of their uniforms.
const MOST_DRAWINGS: usize = 1 << 14;

/// An atlas in the card's memory.
pub struct AtlasTarget {
    pub atlas: Atlas,
    sides: wgpu::Texture,
    /// Nearness of the visible surface at each pixel, if requested.
    nearness: Option<wgpu::Texture>,
    depth: wgpu::TextureView,
    windows: Option<WindowNumbers>,
    /// Buffers for reading back pixels, sides and nearness.
    back: Vec<wgpu::Buffer>,
    faces: Faces,
    sums: Option<Sums>,
}

/// The window of each pixel.
struct WindowNumbers {
    texture: wgpu::Texture,
    group: wgpu::BindGroup,
}

/// Uniforms of drawings.
struct Faces {
    buffer: wgpu::Buffer,
    group: wgpu::BindGroup,
    /// Stride in bytes.
    stride: u32,
}

/// Sums by side, computed on the card.
struct Sums {
    group: wgpu::BindGroup,
    ups: wgpu::Buffer,
    sums: wgpu::Buffer,
    back: wgpu::Buffer,
}

/// The purpose of a target.
pub struct TargetOptions<'a> {
    pub atlas: Atlas,
    pub nearness: bool,
    pub windows: bool,
    pub reduction: Reduction,
    /// Delta form factors of the hemicube's pixels as integers.
    pub weights: &'a [u32],
    pub patches: u32,
}

/// A readback to the processor's memory in progress.
pub struct Mapping {
    buffer: wgpu::Buffer,
    bytes: u64,
    outcome: Receiver<Result<(), wgpu::BufferAsyncError>>,
}

/// The pixels into which drawings are made.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum DrawInto {
    /// Pixels of the directly visible world.
    Faces,
    /// Pixels of windows.
    Windows,
}

impl AtlasTarget {
    /// `None` if the card has not enough memory.
    pub fn new(shared: &Shared, wanted: &TargetOptions) -> Option<AtlasTarget> {
        shared.allocate(|device| {
            let used = wgpu::TextureUsages::RENDER_ATTACHMENT;
            let read = wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::TEXTURE_BINDING;
            let size = wanted.atlas.size();
            let numbers = |usage| texture(device, size, NUMBERS, usage);
            let depth = texture(device, size, DEPTH, used);
            let tiles = u64::from(wanted.atlas.tiles);
            let back = |_| back_buffer(device, tiles * wanted.atlas.tile_bytes());
            let pipeline = shared.pipelines.sum.as_ref();
            let pipeline = pipeline.filter(|_| wanted.reduction == Reduction::Compute);
            let sides = numbers(used | read);
            let sums = pipeline.map(|pipeline| Sums::new(shared, pipeline, &sides, wanted));
            AtlasTarget {
                atlas: wanted.atlas,
                nearness: wanted.nearness.then(|| numbers(used | read)),
                depth: depth.create_view(&wgpu::TextureViewDescriptor::default()),
                windows: wanted.windows.then(|| WindowNumbers::new(shared, size)),
                back: (0..1 + usize::from(wanted.nearness)).map(back).collect(),
                faces: Faces::new(shared, MOST_DRAWINGS.min(8 * tiles as usize)),
                sums,
                sides,
            }
        })
    }

    /// Submits drawings; those of one call start with cleared pixels.
    pub fn draw(&mut self, shared: &Shared, mesh: &Mesh, drawings: &[FaceDrawing], into: DrawInto) {
        self.faces.hold(shared, drawings.len().min(MOST_DRAWINGS));
        // Pixels are cleared even without drawings.
        for first in (0..drawings.len().max(1)).step_by(MOST_DRAWINGS) {
            let part = &drawings[first..drawings.len().min(first + MOST_DRAWINGS)];
            self.faces.write(shared, part);
            let descriptor = wgpu::CommandEncoderDescriptor::default();
            let mut encoder = shared.device.create_command_encoder(&descriptor);
            let mut pass = self.begin(&mut encoder, first == 0);
            let in_windows = into == DrawInto::Windows;
            pass.set_pipeline(shared.pipelines.draw(in_windows, self.nearness.is_some()));
            if let (true, Some(windows)) = (in_windows, &self.windows) {
                pass.set_bind_group(1, &windows.group, &[]);
            }
            self.encode(&mut pass, mesh, part);
            drop(pass);
            shared.queue.submit([encoder.finish()]);
        }
    }

    /// Begins a pass over the atlas, which clears it or draws over it.
    fn begin<'a>(
        &self,
        encoder: &'a mut wgpu::CommandEncoder,
        empties: bool,
    ) -> wgpu::RenderPass<'a> {
        let view = |t: &wgpu::Texture| t.create_view(&wgpu::TextureViewDescriptor::default());
        let views = [Some(view(&self.sides)), self.nearness.as_ref().map(view)];
        let nothing = f64::from(NOTHING);
        let nothing = wgpu::Color {
            r: nothing,
            g: nothing,
            b: nothing,
            a: nothing,
        };
        let colour = |view| wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: operations(nothing, empties),
        };
        let colours: Vec<_> = views.iter().flatten().map(|v| Some(colour(v))).collect();
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &colours,
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(operations(0.0, empties)),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        })
    }

    fn encode(&self, pass: &mut wgpu::RenderPass, mesh: &Mesh, drawings: &[FaceDrawing]) {
        let mut bound = None;
        for (number, drawing) in (0u32..).zip(drawings) {
            if drawing.facets.is_empty() {
                continue;
            }
            let [x, y, w, h] = drawing.viewport.map(|k| k as f32);
            pass.set_viewport(x, y, w, h, 0.0, 1.0);
            let [x, y, w, h] = drawing.scissor;
            pass.set_scissor_rect(x, y, w, h);
            pass.set_bind_group(0, &self.faces.group, &[number * self.faces.stride]);
            for range in &drawing.facets {
                mesh.draw(pass, &mut bound, range);
            }
        }
    }

    /// Sets the window of the pixels in some rows of a tile.
    pub fn set_windows(&self, shared: &Shared, tile: u32, first_row: u32, numbers: &[u32]) {
        let Some(windows) = &self.windows else {
            return;
        };
        let n = self.atlas.resolution;
        let [x, y] = self.atlas.origin(tile);
        shared.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &windows.texture,
                mip_level: 0,
                origin: wgpu::Origin3d {
                    x,
                    y: y + first_row,
                    z: 0,
                },
                aspect: wgpu::TextureAspect::All,
            },
            bytemuck::cast_slice(numbers),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * n),
                rows_per_image: None,
            },
            wgpu::Extent3d {
                width: n,
                height: numbers.len() as u32 / n,
                depth_or_array_layers: 1,
            },
        );
    }

    /// Starts reading back tiles: sides, and nearness if it is stored. Tiles are consecutive, in
    /// the given order.
    pub fn read_back(
        &self,
        shared: &Shared,
        tiles: &[u32],
    ) -> (wgpu::SubmissionIndex, Vec<Mapping>) {
        let descriptor = wgpu::CommandEncoderDescriptor::default();
        let mut encoder = shared.device.create_command_encoder(&descriptor);
        let textures = [Some(&self.sides), self.nearness.as_ref()];
        for (texture, buffer) in textures.iter().flatten().zip(&self.back) {
            for (place, &tile) in tiles.iter().enumerate() {
                self.copy(&mut encoder, texture, buffer, tile, place as u64);
            }
        }
        let submission = shared.queue.submit([encoder.finish()]);
        let bytes = tiles.len() as u64 * self.atlas.tile_bytes();
        let mappings = self.back.iter().map(|buffer| Mapping::new(buffer, bytes));
        (submission, mappings.collect())
    }

    fn copy(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        texture: &wgpu::Texture,
        buffer: &wgpu::Buffer,
        tile: u32,
        place: u64,
    ) {
        let [x, y] = self.atlas.origin(tile);
        let n = self.atlas.resolution;
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo {
                texture,
                mip_level: 0,
                origin: wgpu::Origin3d { x, y, z: 0 },
                aspect: wgpu::TextureAspect::All,
            },
            wgpu::TexelCopyBufferInfo {
                buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: place * self.atlas.tile_bytes(),
                    bytes_per_row: Some(self.atlas.row_bytes()),
                    rows_per_image: None,
                },
            },
            wgpu::Extent3d {
                width: n,
                height: 3 * n,
                depth_or_array_layers: 1,
            },
        );
    }

    /// Starts the summation of the first tiles on the card and the readback of the sums. `ups` are
    /// the world's up along the axes of each. `None` if this target was not made for that.
    pub fn add_up(
        &self,
        shared: &Shared,
        ups: &[[f32; 4]],
    ) -> Option<(wgpu::SubmissionIndex, Mapping)> {
        let sums = self.sums.as_ref()?;
        let pipeline = shared.pipelines.sum.as_ref()?;
        let tiles = ups.len() as u32;
        let bytes = sums.sums.size() / u64::from(self.atlas.tiles) * u64::from(tiles);
        shared
            .queue
            .write_buffer(&sums.ups, 0, bytemuck::cast_slice(ups));
        let descriptor = wgpu::CommandEncoderDescriptor::default();
        let mut encoder = shared.device.create_command_encoder(&descriptor);
        encoder.clear_buffer(&sums.sums, 0, Some(bytes));
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &sums.group, &[]);
        let n = self.atlas.resolution;
        pass.dispatch_workgroups(n.div_ceil(64), (3 * n).div_ceil(16), tiles);
        drop(pass);
        encoder.copy_buffer_to_buffer(&sums.sums, 0, &sums.back, 0, Some(bytes));
        let submission = shared.queue.submit([encoder.finish()]);
        Some((submission, Mapping::new(&sums.back, bytes)))
    }
}

impl WindowNumbers {
    fn new(shared: &Shared, size: wgpu::Extent3d) -> WindowNumbers {
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let texture = texture(&shared.device, size, NUMBERS, usage);
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let group = shared.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("windows"),
            layout: &shared.pipelines.windows,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(&view),
            }],
        });
        WindowNumbers { texture, group }
    }
}

impl Faces {
    fn new(shared: &Shared, count: usize) -> Faces {
        let bytes = 4 * WORDS as u32;
        let stride = bytes.next_multiple_of(shared.limits.min_uniform_buffer_offset_alignment);
        let buffer = shared.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("faces"),
            size: u64::from(stride) * count.max(1) as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let group = shared.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("faces"),
            layout: &shared.pipelines.face,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer: &buffer,
                    offset: 0,
                    size: wgpu::BufferSize::new(u64::from(bytes)),
                }),
            }],
        });
        Faces {
            buffer,
            group,
            stride,
        }
    }

    /// Grows to hold this many.
    fn hold(&mut self, shared: &Shared, count: usize) {
        if count as u64 * u64::from(self.stride) > self.buffer.size() {
            *self = Faces::new(shared, count.next_power_of_two());
        }
    }

    fn write(&self, shared: &Shared, drawings: &[FaceDrawing]) {
        let stride = self.stride as usize / 4;
        let mut words = vec![0u32; stride * drawings.len()];
        for (place, drawing) in words.chunks_exact_mut(stride).zip(drawings) {
            place[..WORDS].copy_from_slice(&drawing.words);
        }
        shared
            .queue
            .write_buffer(&self.buffer, 0, bytemuck::cast_slice(&words));
    }
}

impl Sums {
    fn new(
        shared: &Shared,
        pipeline: &wgpu::ComputePipeline,
        sides: &wgpu::Texture,
        wanted: &TargetOptions,
    ) -> Sums {
        let device = &shared.device;
        let storage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let buffer = |label, size, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        // The sums of a tile: of each side of each patch, and of light that leaves upwards and downwards.
        let atlas = &wanted.atlas;
        let slots = 2 * wanted.patches + 2;
        let bytes = sum_bytes(wanted.patches) * u64::from(atlas.tiles);
        // Weights and sizes are the same in every atlas: write them once.
        let weights = buffer("weights", 4 * wanted.weights.len() as u64, storage);
        shared
            .queue
            .write_buffer(&weights, 0, bytemuck::cast_slice(wanted.weights));
        let uniform = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let sizes = buffer("sizes", 16, uniform);
        let numbers = [atlas.resolution, atlas.columns, slots, wanted.patches];
        shared
            .queue
            .write_buffer(&sizes, 0, bytemuck::cast_slice(&numbers));
        // The other buffers change with each atlas: the directions of up, and the sums.
        let ups = buffer("ups", 16 * u64::from(atlas.tiles), storage);
        let sums = buffer("sums", bytes, storage | wgpu::BufferUsages::COPY_SRC);
        let view = sides.create_view(&wgpu::TextureViewDescriptor::default());
        // Bind the resources in the order of the bindings in sum.wgsl.
        let resources = [
            sizes.as_entire_binding(),
            wgpu::BindingResource::TextureView(&view),
            weights.as_entire_binding(),
            ups.as_entire_binding(),
            sums.as_entire_binding(),
        ];
        let entries: Vec<wgpu::BindGroupEntry> = resources
            .into_iter()
            .zip(0..)
            .map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("sums"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        Sums {
            group,
            ups,
            sums,
            back: back_buffer(device, bytes),
        }
    }
}

/// Size of a tile's sums in bytes.
pub fn sum_bytes(patches: u32) -> u64 {
    8 * (2 * u64::from(patches) + 2)
}

impl Mapping {
    fn new(buffer: &wgpu::Buffer, bytes: u64) -> Mapping {
        let (sender, outcome) = channel();
        buffer.map_async(wgpu::MapMode::Read, 0..bytes, move |result| {
            // The receiver is gone if another error came first.
            let _ = sender.send(result);
        });
        Mapping {
            buffer: buffer.clone(),
            bytes,
            outcome,
        }
    }

    /// Passes the numbers to `read` once the submission is complete.
    pub fn read<T>(self, shared: &Shared, read: impl FnOnce(&[u32]) -> T) -> Result<T, DrawError> {
        match self.outcome.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(e)) => return Err(shared.lose(e.to_string())),
            Err(e) => return Err(shared.lose(format!("no response: {e}"))),
        }
        let view = self.buffer.get_mapped_range(0..self.bytes);
        let view = view.map_err(|e| shared.lose(e.to_string()))?;
        let answer = read(bytemuck::cast_slice(&view));
        drop(view);
        self.buffer.unmap();
        Ok(answer)
    }
}

fn operations<T>(empty: T, empties: bool) -> wgpu::Operations<T> {
    let load = if empties {
        wgpu::LoadOp::Clear(empty)
    } else {
        wgpu::LoadOp::Load
    };
    wgpu::Operations {
        load,
        store: wgpu::StoreOp::Store,
    }
}

fn texture(
    device: &wgpu::Device,
    size: wgpu::Extent3d,
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

fn back_buffer(device: &wgpu::Device, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("back"),
        size,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}
