//! The pipelines of draw.wgsl and sum.wgsl.

/// Format of patch numbers and other integers per pixel.
pub const NUMBERS: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
pub const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Words of a corner: position, plane, side, mirror.
pub const CORNER_WORDS: usize = 9;

pub struct Pipelines {
    /// The face that is drawn, at a dynamic offset.
    pub face: wgpu::BindGroupLayout,
    /// Which window each pixel belongs to.
    pub windows: wgpu::BindGroupLayout,
    /// Indexed by whether windows are drawn, and whether the nearness is stored too.
    draw: [[wgpu::RenderPipeline; 2]; 2],
    /// `None` if the card has no compute shaders.
    pub sum: Option<wgpu::ComputePipeline>,
}

impl Pipelines {
    pub fn new(device: &wgpu::Device, can_compute: bool) -> Pipelines {
        // The face is a uniform at a dynamic offset, so one bind group serves many drawings.
        let layout = |binding: wgpu::BindingType, stages: wgpu::ShaderStages| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: None,
                entries: &[wgpu::BindGroupLayoutEntry {
                    binding: 0,
                    visibility: stages,
                    ty: binding,
                    count: None,
                }],
            })
        };
        let uniform = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: true,
            min_binding_size: None,
        };
        let texture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Uint,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let face = layout(uniform, wgpu::ShaderStages::VERTEX_FRAGMENT);
        let windows = layout(texture, wgpu::ShaderStages::FRAGMENT);
        // The variants differ in fragment shader and targets; only those of windows bind their numbers.
        let shader = device.create_shader_module(wgpu::include_wgsl!("draw.wgsl"));
        let draw = |is_window: bool, entry: &str, is_far: bool| {
            let groups = [Some(&face), is_window.then_some(&windows)];
            let groups = &groups[..1 + usize::from(is_window)];
            draw_pipeline(device, &shader, groups, entry, is_far)
        };
        let draw = [
            [
                draw(false, "straight", false),
                draw(false, "straight_far", true),
            ],
            [draw(true, "window", false), draw(true, "window_far", true)],
        ];
        Pipelines {
            face,
            windows,
            draw,
            sum: can_compute.then(|| sum_pipeline(device)),
        }
    }

    pub fn draw(&self, in_windows: bool, with_nearness: bool) -> &wgpu::RenderPipeline {
        &self.draw[usize::from(in_windows)][usize::from(with_nearness)]
    }
}

fn draw_pipeline(
    device: &wgpu::Device,
    shader: &wgpu::ShaderModule,
    groups: &[Option<&wgpu::BindGroupLayout>],
    entry: &str,
    is_far: bool,
) -> wgpu::RenderPipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        bind_group_layouts: groups,
        ..wgpu::PipelineLayoutDescriptor::default()
    });
    let targets = [Some(NUMBERS.into()), Some(NUMBERS.into())];
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(entry),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: shader,
            entry_point: Some("corner"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[Some(corner_layout())],
        },
        // Both sides are visible; the shader determines the side from the plane.
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            // The depth is a nearness: larger is nearer, 0 is infinitely far.
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: shader,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &targets[..1 + usize::from(is_far)],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// The layout of a corner in its buffer.
fn corner_layout() -> wgpu::VertexBufferLayout<'static> {
    const ATTRIBUTES: [wgpu::VertexAttribute; 3] =
        wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x4, 2 => Uint32x2];
    wgpu::VertexBufferLayout {
        array_stride: 4 * CORNER_WORDS as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &ATTRIBUTES,
    }
}

fn sum_pipeline(device: &wgpu::Device) -> wgpu::ComputePipeline {
    let shader = device.create_shader_module(wgpu::include_wgsl!("sum.wgsl"));
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("sum"),
        layout: None,
        module: &shader,
        entry_point: Some("sum"),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    })
}
