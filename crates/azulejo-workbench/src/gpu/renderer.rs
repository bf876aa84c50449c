//! Drawing a frame.

use super::GpuError;
use super::device::{DeviceErrors, catch_errors};
use super::frame::{Background, DrawnMesh, TextureSource, ViewportFrame};
use super::geometry::{FacetAttribute, GpuMesh, GpuUploader};
use super::lightmap::LightmapTexture;
use super::outline::SelectionOutline;
use super::overlay;
use super::pass::{DrawPlan, PassEncoder, VisibleObject};
use super::pipelines::RenderPipelines;
use super::target::{COLOR, PixelBuffer, RenderTarget, SAMPLES};
use super::textures::TextureCache;
use super::uniforms::{self, UniformBlocks};
use crate::projection::Projection;
use crate::view::ColorMap;
use std::collections::HashMap;

/// Frames after which an unused mesh is freed: while the solver runs, new meshes arrive every
/// second.
const PATIENCE: u64 = 2;

/// Draws frames into a texture of its own.
///
/// Meshes stay in GPU memory under their keys. After an error they are uploaded again by the next
/// frame; after [`GpuError::Lost`] a new renderer with a new device is needed.
pub struct Renderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    listener: DeviceErrors,
    can_smooth: bool,
    pipelines: RenderPipelines,
    outline: SelectionOutline,
    textures: TextureCache,
    geometries: HashMap<u64, GpuMesh>,
    target: Option<RenderTarget>,
    frame_block: wgpu::Buffer,
    object_blocks: UniformBlocks,
    material_blocks: UniformBlocks,
    color_map: (ColorMap, wgpu::TextureView),
    lightmap: LightmapTexture,
    constants: DefaultAttributes,
    number: u64,
    statistics: RenderStatistics,
}

/// Constant values for meshes that lack a vertex attribute.
pub struct DefaultAttributes {
    pub zeros: wgpu::Buffer,
    pub ones: wgpu::Buffer,
}

/// The image of a frame.
#[derive(Clone, Copy, Debug)]
pub struct DrawnFrame<'a> {
    /// Opaque sRGB bytes in the format `Rgba8Unorm`, as egui expects.
    pub view: &'a wgpu::TextureView,
    /// Whether this is another view than that of the previous frame, so that it must be registered
    /// again.
    pub is_new: bool,
}

/// Costs of the last frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RenderStatistics {
    /// Number of objects that may be visible.
    pub objects: usize,
    /// Bytes uploaded for this frame, uniforms and overlay excluded.
    pub bytes_loaded: u64,
    /// Meshes in GPU memory.
    pub meshes_held: usize,
}

impl Renderer {
    /// Creates a renderer on a device. It handles the device's loss and uncaptured errors, which
    /// would make wgpu panic.
    ///
    /// # Errors
    ///
    /// [`GpuError::Rejected`] if the driver rejects the shaders, or [`GpuError::Lost`].
    pub fn new(device: wgpu::Device, queue: wgpu::Queue) -> Result<Renderer, GpuError> {
        let listener = DeviceErrors::new(&device);
        listener.check()?;
        let can_smooth = catch_errors(&device, || {
            RenderTarget::new(&device, [4, 4], SAMPLES);
            Ok(())
        });
        catch_errors(&device.clone(), || {
            Ok(Renderer::build(device, queue, listener, can_smooth.is_ok()))
        })
    }

    fn build(
        device: wgpu::Device,
        queue: wgpu::Queue,
        listener: DeviceErrors,
        can_smooth: bool,
    ) -> Renderer {
        let textures = TextureCache::new(&device, &queue);
        let pipelines = RenderPipelines::new(&device, textures.layout());
        let frame_block = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: 4 * uniforms::FRAME_WORDS as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Renderer {
            outline: SelectionOutline::new(&device, &pipelines.shader, &pipelines.with_object),
            object_blocks: UniformBlocks::new(&device, &pipelines.block, 1),
            material_blocks: UniformBlocks::new(&device, &pipelines.block, 1),
            color_map: load_map(&device, &queue, ColorMap::default()),
            lightmap: LightmapTexture::new(&device, &queue),
            constants: DefaultAttributes::new(&device, &queue),
            geometries: HashMap::new(),
            target: None,
            number: 0,
            statistics: RenderStatistics::default(),
            device,
            queue,
            listener,
            can_smooth,
            pipelines,
            textures,
            frame_block,
        }
    }

    /// Draws a frame.
    ///
    /// # Errors
    ///
    /// [`GpuError::TooLarge`], [`GpuError::OutOfMemory`] (after freeing everything that the frame
    /// does not need), [`GpuError::Lost`] or [`GpuError::Rejected`].
    pub fn draw(&mut self, frame: &ViewportFrame) -> Result<DrawnFrame<'_>, GpuError> {
        self.listener.check()?;
        let size = frame.size.map(|n| n.max(1));
        let most = self.device.limits().max_texture_dimension_2d;
        if size[0].max(size[1]) > most {
            return Err(GpuError::TooLarge { asked: size, most });
        }
        let device = self.device.clone();
        let mut outcome = catch_errors(&device, || self.try_draw(frame, size));
        if outcome == Err(GpuError::OutOfMemory) {
            // Retry with nothing in GPU memory but what this frame needs.
            self.forget();
            outcome = catch_errors(&device, || self.try_draw(frame, size));
        }
        if outcome.is_err() {
            self.forget();
            // If the device is lost, that is the cause of any other error. Polling reports the
            // loss; polling a lost device returns nothing else.
            let _ = device.poll(wgpu::PollType::Poll);
            self.listener.check()?;
        }
        let is_new = outcome?;
        self.listener.check()?;
        let view = self.target.as_ref().map(|t| &t.view);
        let view = view.ok_or(GpuError::OutOfMemory)?;
        Ok(DrawnFrame { view, is_new })
    }

    /// Draws a frame of [values](ViewportFrame::is_values) and reads it back: the position on the
    /// colour scale, 0 to 1, in 16 bits, red and green, and in blue 255 where there is light. The
    /// last image stays.
    ///
    /// # Errors
    ///
    /// Those of [`draw`](Self::draw).
    pub fn values(&mut self, frame: &ViewportFrame) -> Result<PixelBuffer, GpuError> {
        let shown = self.target.take();
        let read = match self.draw(frame) {
            Ok(_) => self.read(),
            Err(error) => Err(error),
        };
        self.target = shown;
        read
    }

    /// Reads the last image back.
    ///
    /// # Errors
    ///
    /// [`GpuError::Rejected`] before the first frame, and the errors of [`draw`](Self::draw).
    pub fn read(&self) -> Result<PixelBuffer, GpuError> {
        self.listener.check()?;
        let target = self.target.as_ref().ok_or_else(|| GpuError::Rejected {
            reason: "nothing was drawn yet".to_owned(),
        })?;
        catch_errors(&self.device, || target.read(&self.device, &self.queue))
    }

    /// Whether the adapter is a software rasterizer; frames without
    /// [`ViewportFrame::antialiasing`] are then about three times as fast.
    pub fn is_software(&self) -> bool {
        let info = self.device.adapter_info();
        let name = info.name.to_lowercase();
        let known = ["llvmpipe", "softpipe", "swiftshader"];
        info.device_type == wgpu::DeviceType::Cpu || known.iter().any(|k| name.contains(k))
    }

    /// Checks whether the device is still available.
    ///
    /// # Errors
    ///
    /// [`GpuError::Lost`].
    pub fn check(&self) -> Result<(), GpuError> {
        // Polling reports a lost device.
        let _ = self.device.poll(wgpu::PollType::Poll);
        self.listener.check()
    }

    /// Costs of the last frame.
    pub fn statistics(&self) -> RenderStatistics {
        self.statistics
    }

    /// Frees all per-frame resources.
    pub fn forget(&mut self) {
        self.geometries.clear();
        self.textures.free_before(u64::MAX);
        self.lightmap = LightmapTexture::new(&self.device, &self.queue);
        self.target = None;
    }

    /// Destroys the device as if the GPU had been unplugged.
    #[cfg(test)]
    pub(super) fn destroy(&self) {
        self.device.destroy();
    }

    /// Returns whether the texture view is new.
    fn try_draw(&mut self, frame: &ViewportFrame, size: [u32; 2]) -> Result<bool, GpuError> {
        self.number += 1;
        // Bring the target, the colour map and the lightmap up to date; what fits is kept.
        let is_new = self.resize(frame, size);
        let plan = DrawPlan::of(frame.shading);
        let plan = if frame.is_values { plan.packed() } else { plan };
        if self.color_map.0 != frame.scale.map {
            self.color_map = load_map(&self.device, &self.queue, frame.scale.map);
        }
        self.lightmap
            .upload(&self.device, &self.queue, frame.lightmap);
        // Upload the vertex streams that the mode needs of the objects in view, and the textures.
        let view = self.view(frame, size);
        let visible = self.load(frame, &view, &plan)?;
        let textures = self.load_textures(frame, &plan);
        let backdrop = self.load_backdrop(frame);
        // Write the uniforms: of objects and materials in blocks at offsets, then of the frame.
        let objects = self.object_blocks(frame, &view, &visible, &plan);
        let materials: Vec<_> = materials(frame).map(uniforms::material).collect();
        let layout = &self.pipelines.block;
        self.object_blocks
            .write(&self.device, &self.queue, layout, &objects);
        self.material_blocks
            .write(&self.device, &self.queue, layout, &materials);
        let picture = backdrop.as_ref().and(background_size(&frame.background));
        let block = uniforms::frame(frame, &view, picture, self.lightmap.scale);
        self.queue
            .write_buffer(&self.frame_block, 0, bytemuck::cast_slice(&block));
        let group = self.frame_group(backdrop.as_ref());
        let (ink, hidden_ink) = self.load_overlay(frame, &view);
        let Some(target) = &self.target else {
            return Err(GpuError::OutOfMemory);
        };
        let mut encoder = PassEncoder {
            frame,
            view,
            plan,
            device: &self.device,
            pipelines: &mut self.pipelines,
            texture_cache: &self.textures,
            geometries: &self.geometries,
            objects: &self.object_blocks,
            materials: &self.material_blocks,
            constants: &self.constants,
            frame_group: &group,
            textures: &textures,
            visible: &visible,
            ink: &ink,
            hidden_ink,
            samples: target.samples,
        };
        // A pass only looks pipelines up: create the missing ones before it begins.
        encoder.prepare();
        let mut commands = self.device.create_command_encoder(&Default::default());
        encoder.encode(target.begin(&mut commands));
        // Outline the selection in the finished picture, around a mask of its surfaces.
        if encoder.has_marks() {
            let outline = &mut self.outline;
            outline.prepare(&self.device, &self.queue, size, frame.selection_color);
            if let Some(pass) = outline.begin_mask(&mut commands) {
                encoder.encode_marks(pass);
            }
            outline.draw(&self.device, &mut commands, &target.view);
        }
        self.queue.submit([commands.finish()]);
        self.free(&plan);
        Ok(is_new)
    }

    /// Creates the textures of the target; returns whether they are new.
    fn resize(&mut self, frame: &ViewportFrame, size: [u32; 2]) -> bool {
        let samples = if frame.antialiasing && self.can_smooth {
            SAMPLES
        } else {
            1
        };
        let fits = |t: &RenderTarget| t.size == size && t.samples == samples;
        let is_new = !self.target.as_ref().is_some_and(fits);
        if is_new {
            // Free the old textures first.
            self.target = None;
            self.target = Some(RenderTarget::new(&self.device, size, samples));
        }
        is_new
    }

    fn view(&mut self, frame: &ViewportFrame, size: [u32; 2]) -> Projection {
        for drawn in frame.objects {
            let geometry = self.geometries.entry(drawn.key);
            geometry.or_insert_with(|| GpuMesh::new(drawn.mesh)).used = self.number;
        }
        let objects = frame.objects.iter().filter_map(|drawn| {
            let geometry = self.geometries.get(&drawn.key)?;
            Some(sphere(drawn, geometry))
        });
        let view = Projection::new(frame.camera, size);
        // Overlays may be far away and must not push the near plane into the model.
        view.around(objects, frame.overlay.spheres())
    }

    /// Uploads the objects that may be visible.
    fn load(
        &mut self,
        frame: &ViewportFrame,
        view: &Projection,
        plan: &DrawPlan,
    ) -> Result<Vec<VisibleObject>, GpuError> {
        let mut loader = GpuUploader::new(&self.device, &self.queue);
        let mut visible = Vec::new();
        for (index, drawn) in frame.objects.iter().enumerate() {
            let Some(geometry) = self.geometries.get_mut(&drawn.key) else {
                continue;
            };
            let (centre, radius) = sphere(drawn, geometry);
            if drawn.mesh.faces.is_empty() || !view.sees(view.to_view(centre), radius) {
                continue;
            }
            geometry.upload(drawn, plan.streams, &mut loader)?;
            geometry.select(drawn, &mut loader);
            visible.push(VisibleObject {
                index,
                view_from: view.view_from(&drawn.world_from_object, geometry.origin),
                stretch: stretch(drawn),
            });
        }
        self.statistics = RenderStatistics {
            objects: visible.len(),
            bytes_loaded: loader.bytes,
            meshes_held: self.geometries.len(),
        };
        Ok(visible)
    }

    /// The texture key of each material.
    fn load_textures(&mut self, frame: &ViewportFrame, plan: &DrawPlan) -> Vec<Option<Vec<u64>>> {
        let cache = &mut self.textures;
        let mut key = |textures: &[u32]| {
            let known = textures
                .iter()
                .filter_map(|&t| frame.textures.get(t as usize));
            let used: Vec<TextureSource> = known.copied().collect();
            cache.upload(&self.device, &self.queue, &used, self.number)
        };
        let textures = materials(frame).map(|m| m.filter(|_| plan.streams.uvs));
        textures.map(|m| m.and_then(|m| key(&m.textures))).collect()
    }

    fn load_backdrop(&mut self, frame: &ViewportFrame) -> Option<Vec<u64>> {
        let Background::Image { picture, .. } = frame.background else {
            return None;
        };
        self.textures
            .upload(&self.device, &self.queue, &[picture], self.number)
    }

    fn load_overlay(&self, frame: &ViewportFrame, view: &Projection) -> (wgpu::Buffer, u32) {
        let (words, hidden) = overlay::corners(frame.overlay, view);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("overlay"),
            size: (4 * words.len() as u64).max(4),
            usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue
            .write_buffer(&buffer, 0, bytemuck::cast_slice(&words));
        (buffer, hidden)
    }

    fn object_blocks(
        &self,
        frame: &ViewportFrame,
        view: &Projection,
        visible: &[VisibleObject],
        plan: &DrawPlan,
    ) -> Vec<[f32; uniforms::WORDS]> {
        let [r, g, b] = frame.selection_color.map(|x| f32::from(x) / 255.0);
        let block = |s: &VisibleObject| {
            let drawn = &frame.objects[s.index];
            let geometry = self.geometries.get(&drawn.key)?;
            let tint = [r, g, b, f32::from(u8::from(drawn.is_selected))];
            let scale = match plan.streams.facets {
                FacetAttribute::None => geometry.light_scale,
                FacetAttribute::Light | FacetAttribute::Values => geometry.facet_scale,
            };
            Some(uniforms::object(view, &s.view_from, geometry, tint, scale))
        };
        let none = [0.0; uniforms::WORDS];
        visible.iter().map(|s| block(s).unwrap_or(none)).collect()
    }

    fn frame_group(&mut self, backdrop: Option<&Vec<u64>>) -> wgpu::BindGroup {
        let sampler = wgpu::BindingResource::Sampler(self.textures.sampler());
        let resources = [
            self.frame_block.as_entire_binding(),
            wgpu::BindingResource::TextureView(self.textures.view(backdrop)),
            sampler.clone(),
            wgpu::BindingResource::TextureView(&self.color_map.1),
            sampler,
            wgpu::BindingResource::TextureView(&self.lightmap.view),
        ];
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &self.pipelines.frame,
            entries: &entries,
        })
    }

    fn free(&mut self, plan: &DrawPlan) {
        let oldest = self.number.saturating_sub(PATIENCE);
        self.geometries.retain(|_, g| g.used >= oldest);
        self.textures.free_before(oldest);
        if plan.streams.facets == FacetAttribute::None {
            self.geometries.values_mut().for_each(GpuMesh::drop_facets);
        }
    }
}

impl DefaultAttributes {
    fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> DefaultAttributes {
        let make = |bytes: [u8; 16]| {
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("constant attribute"),
                size: 16,
                usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            queue.write_buffer(&buffer, 0, &bytes);
            buffer
        };
        DefaultAttributes {
            zeros: make([0; 16]),
            ones: make([255; 16]),
        }
    }
}

/// The frame's materials, followed by the one that replaces missing materials.
fn materials<'a>(
    frame: &'a ViewportFrame,
) -> impl Iterator<Item = Option<&'a azulejo::scene::Material>> + use<'a> {
    frame.materials.iter().map(|&m| Some(m)).chain([None])
}

/// A bounding sphere of a placed mesh.
fn sphere(drawn: &DrawnMesh, geometry: &GpuMesh) -> (glam::DVec3, f64) {
    let centre = drawn.world_from_object.transform_point3(geometry.origin);
    (centre, geometry.radius * stretch(drawn))
}

/// Upper bound on how much an object's placement stretches lengths.
fn stretch(drawn: &DrawnMesh) -> f64 {
    let m = drawn.world_from_object.matrix3;
    let columns = [m.x_axis, m.y_axis, m.z_axis];
    let is_rigid = columns.iter().all(|c| (c.length() - 1.0).abs() < 1e-6)
        && (m.determinant().abs() - 1.0).abs() < 1e-6;
    // The image of a unit vector is no longer than the matrix's Frobenius norm.
    let norm = columns
        .iter()
        .map(|c| c.length_squared())
        .sum::<f64>()
        .sqrt();
    if is_rigid { 1.0 } else { norm }
}

fn background_size(background: &Background) -> Option<[u32; 2]> {
    match background {
        Background::Image { picture, .. } => picture.image.map(|i| [i.width, i.height]),
        _ => None,
    }
}

fn load_map(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    map: ColorMap,
) -> (ColorMap, wgpu::TextureView) {
    let size = wgpu::Extent3d {
        width: 256,
        height: 1,
        depth_or_array_layers: 1,
    };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("colour map"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: COLOR,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let rows = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(4 * 256),
        rows_per_image: None,
    };
    queue.write_texture(texture.as_image_copy(), &map.texels(), rows, size);
    (
        map,
        texture.create_view(&wgpu::TextureViewDescriptor::default()),
    )
}
