//! The line around the selection.

use super::target::COLOR;

/// One value per pixel: 1 on the selection.
const MASK: wgpu::TextureFormat = wgpu::TextureFormat::R8Unorm;

/// Draws a line around a mask of what is selected, visible through what stands before it.
pub struct SelectionOutline {
    layout: wgpu::BindGroupLayout,
    color: wgpu::Buffer,
    marks: wgpu::RenderPipeline,
    line: wgpu::RenderPipeline,
    mask: Option<([u32; 2], wgpu::TextureView)>,
}

impl SelectionOutline {
    /// `surfaces` is the shader of the surfaces, `with_object` the layout of its groups of frame and
    /// object.
    pub fn new(
        device: &wgpu::Device,
        surfaces: &wgpu::ShaderModule,
        with_object: &wgpu::PipelineLayout,
    ) -> SelectionOutline {
        let layout = layout(device);
        let shader = device.create_shader_module(wgpu::include_wgsl!("outline.wgsl"));
        let of_line = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("outline"),
            bind_group_layouts: &[Some(&layout)],
            ..wgpu::PipelineLayoutDescriptor::default()
        });
        // The mask needs positions only; the line blends with the picture.
        let place = wgpu::VertexBufferLayout {
            array_stride: 12,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &const { wgpu::vertex_attr_array![0 => Float32x3] },
        };
        let over = Some(wgpu::BlendState::ALPHA_BLENDING);
        let color = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("outline colour"),
            size: 16,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        // The mask is drawn with the shader of the surfaces, and so is cut as they are.
        let marks = MaskStage {
            shader: surfaces,
            entries: ["same_place", "marked"],
            layout: with_object,
            buffers: &[Some(place)],
            target: (MASK, None),
        };
        // The line is drawn by one triangle over the whole picture, which reads the mask.
        let line = MaskStage {
            shader: &shader,
            entries: ["whole_picture", "outline"],
            layout: &of_line,
            buffers: &[],
            target: (COLOR, over),
        };
        // The mask is made once the size of the picture is known.
        SelectionOutline {
            marks: marks.pipeline(device),
            line: line.pipeline(device),
            layout,
            color,
            mask: None,
        }
    }

    /// Makes the mask as large as the image, and sets the colour of the line.
    pub fn prepare(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        size: [u32; 2],
        color: [u8; 3],
    ) {
        let [r, g, b] = color.map(|c| f32::from(c) / 255.0);
        let color = [r, g, b, 1.0];
        queue.write_buffer(&self.color, 0, bytemuck::cast_slice(&color));
        if self.mask.as_ref().is_some_and(|(known, _)| *known == size) {
            return;
        }
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("selection"),
            size: wgpu::Extent3d {
                width: size[0],
                height: size[1],
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: MASK,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        self.mask = Some((size, view));
    }

    /// Begins the pass that draws the mask.
    pub fn begin_mask<'a>(
        &self,
        encoder: &'a mut wgpu::CommandEncoder,
    ) -> Option<wgpu::RenderPass<'a>> {
        let (_, mask) = self.mask.as_ref()?;
        let clear = wgpu::LoadOp::Clear(wgpu::Color::BLACK);
        let mut pass = begin(encoder, mask, clear);
        pass.set_pipeline(&self.marks);
        Some(pass)
    }

    /// Draws the line into the finished image.
    pub fn draw(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        image: &wgpu::TextureView,
    ) {
        let Some((_, mask)) = &self.mask else {
            return;
        };
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("outline"),
            layout: &self.layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: self.color.as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::TextureView(mask),
                },
            ],
        });
        let mut pass = begin(encoder, image, wgpu::LoadOp::Load);
        pass.set_pipeline(&self.line);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
    }
}

fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    view: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
) -> wgpu::RenderPass<'a> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("selection"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load,
                store: wgpu::StoreOp::Store,
            },
        })],
        ..wgpu::RenderPassDescriptor::default()
    })
}

fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty,
        count: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("outline"),
        entries: &[
            entry(
                0,
                wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
            ),
            entry(
                1,
                wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: false },
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
            ),
        ],
    })
}

/// One of both stages: the mask, and the line around it.
struct MaskStage<'a> {
    shader: &'a wgpu::ShaderModule,
    /// Entry points of vertices and fragments.
    entries: [&'static str; 2],
    layout: &'a wgpu::PipelineLayout,
    buffers: &'a [Option<wgpu::VertexBufferLayout<'static>>],
    target: (wgpu::TextureFormat, Option<wgpu::BlendState>),
}

impl MaskStage<'_> {
    /// Without depth: the selection is marked whatever stands before it.
    fn pipeline(&self, device: &wgpu::Device) -> wgpu::RenderPipeline {
        let [corner, shade] = self.entries;
        let (format, blend) = self.target;
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(shade),
            layout: Some(self.layout),
            vertex: wgpu::VertexState {
                module: self.shader,
                entry_point: Some(corner),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: self.buffers,
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: self.shader,
                entry_point: Some(shade),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(wgpu::ColorTargetState {
                    format,
                    blend,
                    write_mask: wgpu::ColorWrites::ALL,
                })],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}
