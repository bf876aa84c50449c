//! Render pipelines of draw.wgsl, created on first use.

use super::lightmap::lightmap_binding;
use super::overlay::WORDS;
use super::target::{COLOR, DEPTH};
use super::textures::{sampler_binding, texture_binding};
use std::collections::HashMap;

/// Identifies a pipeline by its state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PipelineKey {
    pub stage: DrawStage,
    pub samples: u32,
    /// The culled side in GPU terms: for mirrored objects, the front.
    pub culled: Option<wgpu::Face>,
}

/// What is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DrawStage {
    Background,
    /// Triangles over shared vertices, with the fragment shader entry point.
    Surface {
        shade: &'static str,
        has: VertexAttributes,
        is_glass: bool,
    },
    /// Triangles that share no vertices.
    Facets {
        shade: &'static str,
        is_glass: bool,
    },
    /// Faces that only write depth, to hide edges.
    Hiding,
    /// Edges; faint over shaded surfaces.
    Edges {
        is_faint: bool,
    },
    Points,
    OverlayStyle {
        on_top: bool,
    },
}

/// Which attributes have a value for each vertex; the others are constant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct VertexAttributes {
    pub normals: bool,
    pub light: bool,
    pub lightmap: bool,
    pub colors: bool,
    pub uvs: bool,
}

pub struct RenderPipelines {
    pub shader: wgpu::ShaderModule,
    pub frame: wgpu::BindGroupLayout,
    /// One uniform block at a dynamic offset: objects and materials.
    pub block: wgpu::BindGroupLayout,
    with_all: wgpu::PipelineLayout,
    /// Groups of the frame and of an object.
    pub with_object: wgpu::PipelineLayout,
    with_frame: wgpu::PipelineLayout,
    made: HashMap<PipelineKey, wgpu::RenderPipeline>,
}

impl RenderPipelines {
    pub fn new(device: &wgpu::Device, picture: &wgpu::BindGroupLayout) -> RenderPipelines {
        let frame = frame_layout(device);
        let block = block_layout(device);
        let layout = |groups: &[Option<&wgpu::BindGroupLayout>]| {
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                bind_group_layouts: groups,
                ..wgpu::PipelineLayoutDescriptor::default()
            })
        };
        RenderPipelines {
            shader: device.create_shader_module(wgpu::include_wgsl!("draw.wgsl")),
            with_all: layout(&[Some(&frame), Some(&block), Some(&block), Some(picture)]),
            with_object: layout(&[Some(&frame), Some(&block)]),
            with_frame: layout(&[Some(&frame)]),
            frame,
            block,
            made: HashMap::new(),
        }
    }

    /// Creates a pipeline that does not exist yet.
    pub fn prepare(&mut self, device: &wgpu::Device, way: PipelineKey) {
        if !self.made.contains_key(&way) {
            let pipeline = self.make(device, way);
            self.made.insert(way, pipeline);
        }
    }

    /// A pipeline created before.
    pub fn get(&self, way: PipelineKey) -> Option<&wgpu::RenderPipeline> {
        self.made.get(&way)
    }

    fn make(&self, device: &wgpu::Device, way: PipelineKey) -> wgpu::RenderPipeline {
        let recipe = PipelineState::of(way.stage);
        let layout = match way.stage {
            DrawStage::Surface { .. } | DrawStage::Facets { .. } => &self.with_all,
            DrawStage::Background | DrawStage::OverlayStyle { .. } => &self.with_frame,
            _ => &self.with_object,
        };
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(recipe.shade),
            layout: Some(layout),
            vertex: wgpu::VertexState {
                module: &self.shader,
                entry_point: Some(recipe.corner),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &recipe.buffers,
            },
            primitive: wgpu::PrimitiveState {
                topology: recipe.topology,
                cull_mode: way.culled,
                ..wgpu::PrimitiveState::default()
            },
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(recipe.writes_depth),
                depth_compare: Some(recipe.compare),
                stencil: wgpu::StencilState::default(),
                bias: recipe.bias,
            }),
            multisample: wgpu::MultisampleState {
                count: way.samples,
                ..wgpu::MultisampleState::default()
            },
            fragment: Some(wgpu::FragmentState {
                module: &self.shader,
                entry_point: Some(recipe.shade),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(wgpu::ColorTargetState {
                    format: COLOR,
                    blend: recipe.blends.then_some(wgpu::BlendState::ALPHA_BLENDING),
                    write_mask: wgpu::ColorWrites::ALL,
                })],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// The state in which stages differ.
struct PipelineState {
    corner: &'static str,
    shade: &'static str,
    buffers: Vec<Option<wgpu::VertexBufferLayout<'static>>>,
    topology: wgpu::PrimitiveTopology,
    compare: wgpu::CompareFunction,
    writes_depth: bool,
    blends: bool,
    bias: wgpu::DepthBiasState,
}

impl PipelineState {
    fn of(stage: DrawStage) -> PipelineState {
        use wgpu::CompareFunction::{Always, Greater, GreaterEqual};
        use wgpu::PrimitiveTopology as Topology;
        let usual = PipelineState {
            corner: "same_place",
            shade: "line",
            buffers: vec![Some(position(wgpu::VertexStepMode::Vertex))],
            topology: Topology::TriangleList,
            compare: Greater,
            writes_depth: true,
            blends: false,
            bias: wgpu::DepthBiasState::default(),
        };
        match stage {
            DrawStage::Background => PipelineState {
                corner: "whole_picture",
                shade: "background",
                buffers: Vec::new(),
                compare: Always,
                writes_depth: false,
                ..usual
            },
            DrawStage::Surface {
                shade,
                has,
                is_glass,
            } => PipelineState {
                corner: "surface",
                shade,
                buffers: surface(has),
                writes_depth: !is_glass,
                blends: is_glass,
                ..usual
            },
            DrawStage::Facets { shade, is_glass } => PipelineState {
                corner: "surface",
                shade,
                buffers: surface(VertexAttributes {
                    light: true,
                    ..VertexAttributes::default()
                }),
                writes_depth: !is_glass,
                blends: is_glass,
                // Only under edges that lie on the faces: at silhouettes it would let back faces
                // show through.
                bias: match shade {
                    "patches" => backward(),
                    _ => usual.bias,
                },
                ..usual
            },
            DrawStage::Hiding => PipelineState {
                shade: "hidden",
                bias: backward(),
                ..usual
            },
            DrawStage::Edges { is_faint } => PipelineState {
                corner: "edge",
                topology: Topology::LineList,
                compare: GreaterEqual,
                blends: is_faint,
                ..usual
            },
            DrawStage::Points => PipelineState {
                corner: "dot_corner",
                topology: Topology::TriangleStrip,
                buffers: vec![Some(position(wgpu::VertexStepMode::Instance))],
                ..usual
            },
            DrawStage::OverlayStyle { on_top } => PipelineState {
                corner: "inked",
                shade: "ink",
                buffers: vec![Some(inked())],
                compare: if on_top { Always } else { GreaterEqual },
                writes_depth: false,
                blends: true,
                ..usual
            },
        }
    }
}

/// Depth bias away from the camera, larger on steep faces, whose depth changes within the width of
/// a line.
fn backward() -> wgpu::DepthBiasState {
    wgpu::DepthBiasState {
        constant: -32,
        slope_scale: -1.0,
        clamp: 0.0,
    }
}

fn position(step_mode: wgpu::VertexStepMode) -> wgpu::VertexBufferLayout<'static> {
    wgpu::VertexBufferLayout {
        array_stride: 12,
        step_mode,
        attributes: &const { wgpu::vertex_attr_array![0 => Float32x3] },
    }
}

fn inked() -> wgpu::VertexBufferLayout<'static> {
    wgpu::VertexBufferLayout {
        array_stride: 4 * WORDS as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &const { wgpu::vertex_attr_array![0 => Float32x4, 1 => Unorm8x4] },
    }
}

/// Six vertex buffers; missing attributes have one constant value.
fn surface(has: VertexAttributes) -> Vec<Option<wgpu::VertexBufferLayout<'static>>> {
    let optional = |is_there, array_stride, attributes| {
        Some(wgpu::VertexBufferLayout {
            array_stride,
            step_mode: if is_there {
                wgpu::VertexStepMode::Vertex
            } else {
                wgpu::VertexStepMode::Instance
            },
            attributes,
        })
    };
    let normals = &const { wgpu::vertex_attr_array![1 => Snorm16x2] };
    let light = &const { wgpu::vertex_attr_array![2 => Float16x4] };
    let colors = &const { wgpu::vertex_attr_array![3 => Unorm8x4] };
    let uvs = &const { wgpu::vertex_attr_array![4 => Float32x2] };
    let lightmap = &const { wgpu::vertex_attr_array![5 => Float32x3] };
    vec![
        Some(position(wgpu::VertexStepMode::Vertex)),
        optional(has.normals, 4, normals),
        optional(has.light, 8, light),
        optional(has.colors, 4, colors),
        optional(has.uvs, 8, uvs),
        optional(has.lightmap, 12, lightmap),
    ]
}

fn frame_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty,
        count: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("frame"),
        entries: &[
            entry(0, uniform(false)),
            entry(1, texture_binding()),
            entry(2, sampler_binding()),
            entry(3, texture_binding()),
            entry(4, sampler_binding()),
            entry(5, lightmap_binding()),
        ],
    })
}

fn block_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("block"),
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty: uniform(true),
            count: None,
        }],
    })
}

fn uniform(has_dynamic_offset: bool) -> wgpu::BindingType {
    wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset,
        min_binding_size: None,
    }
}
