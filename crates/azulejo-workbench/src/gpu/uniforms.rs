//! Uniform data for the shaders: per frame, per object and per material.

use super::frame::{Background, ColorScalar, ViewportFrame};
use super::geometry::GpuMesh;
use crate::projection::Projection;
use crate::view::Shading;
use azulejo::render::{REINHARD_WHITE, Tone};
use azulejo::scene::{BackplateFit, Material, Rgb};
use glam::{DAffine3, DMat3, DVec3, Mat4};

/// Size in 32-bit words of the largest block, that of an object.
pub const WORDS: usize = 56;
/// Size in words of the frame's block.
pub const FRAME_WORDS: usize = 60;

/// Uniform blocks side by side in one buffer.
pub struct UniformBlocks {
    buffer: wgpu::Buffer,
    pub group: wgpu::BindGroup,
    stride: u32,
}

impl UniformBlocks {
    pub fn new(
        device: &wgpu::Device,
        layout: &wgpu::BindGroupLayout,
        count: usize,
    ) -> UniformBlocks {
        let bytes = 4 * WORDS as u32;
        let limits = device.limits();
        let stride = bytes.next_multiple_of(limits.min_uniform_buffer_offset_alignment);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("blocks"),
            size: u64::from(stride) * count.max(1) as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("blocks"),
            layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer: &buffer,
                    offset: 0,
                    size: wgpu::BufferSize::new(u64::from(bytes)),
                }),
            }],
        });
        UniformBlocks {
            buffer,
            group,
            stride,
        }
    }

    /// Writes all blocks, growing the buffer if necessary.
    pub fn write(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        layout: &wgpu::BindGroupLayout,
        blocks: &[[f32; WORDS]],
    ) {
        let stride = self.stride as usize / 4;
        let mut words = vec![0f32; stride * blocks.len()];
        for (place, block) in words.chunks_exact_mut(stride).zip(blocks) {
            place[..WORDS].copy_from_slice(block);
        }
        if 4 * words.len() as u64 > self.buffer.size() {
            *self = UniformBlocks::new(device, layout, blocks.len().next_power_of_two());
        }
        queue.write_buffer(&self.buffer, 0, bytemuck::cast_slice(&words));
    }

    pub fn offset(&self, number: u32) -> u32 {
        number * self.stride
    }
}

/// A block being filled.
struct BlockWriter<const N: usize> {
    words: [f32; N],
    next: usize,
}

impl<const N: usize> BlockWriter<N> {
    fn new() -> BlockWriter<N> {
        BlockWriter {
            words: [0.0; N],
            next: 0,
        }
    }

    fn put(mut self, numbers: &[f32]) -> BlockWriter<N> {
        self.words[self.next..self.next + numbers.len()].copy_from_slice(numbers);
        self.next += numbers.len();
        self
    }

    fn color(self, [r, g, b]: [u8; 3], last: f32) -> BlockWriter<N> {
        let part = |x: u8| f32::from(x) / 255.0;
        self.put(&[part(r), part(g), part(b), last])
    }

    fn light(self, light: Rgb, last: f32) -> BlockWriter<N> {
        let [r, g, b] = light.to_f32();
        self.put(&[r, g, b, last])
    }

    fn vector(self, v: DVec3, last: f32) -> BlockWriter<N> {
        let [x, y, z] = v.as_vec3().to_array();
        self.put(&[x, y, z, last])
    }
}

/// The uniforms of the frame. `picture` is the size of the background image, if there is one, and
/// `lightmap_scale` the irradiance that the stored value 1 of the lightmap stands for.
pub fn frame(
    frame: &ViewportFrame,
    view: &Projection,
    picture: Option<[u32; 2]>,
    lightmap_scale: f32,
) -> [f32; FRAME_WORDS] {
    let size = view.size();
    let tone = match frame.tone {
        Tone::Linear => 0.0,
        Tone::Reinhard => 1.0,
        Tone::Filmic => 2.0,
    };
    // Without a valid up vector, up is that of the screen.
    let up = (view.rotation() * frame.camera.up).try_normalize();
    let (lower, upper, kind) = backdrop(&frame.background, picture.is_some());
    let fog = frame.fog;
    let fog_color = fog.map_or(Rgb::BLACK, |f| f.color);
    let fog_kind = match fog {
        None => 0.0,
        Some(fog) if fog.exponential => 1.0,
        Some(_) => 2.0,
    };
    let scale = &frame.scale;
    // On a logarithmic scale the shader works with logarithms.
    let end = |x: f64| if scale.is_logarithmic { x.ln() } else { x } as f32;
    let world = view.rotation().transpose();
    let flag = |is: bool| f32::from(u8::from(is));
    // The order, and the padding, are those of `Frame` in draw.wgsl.
    BlockWriter::new()
        .put(&[size.x as f32, size.y as f32, view.near() as f32, tone])
        .vector(up.unwrap_or(DVec3::Y), frame.exposure as f32)
        .color(lower, kind)
        .color(upper, REINHARD_WHITE as f32)
        .put(&placement(
            &frame.background,
            picture,
            size.as_vec2().to_array(),
        ))
        .light(fog_color, fog_kind)
        .put(&[fog.map_or(1.0, |f| f.visibility) as f32, end(scale.low)])
        .put(&[end(scale.high), scale.interval() as f32])
        .color(frame.line_color, line_opacity(frame))
        .vector(world.x_axis, 0.0)
        .vector(world.y_axis, 0.0)
        .vector(world.z_axis, 0.0)
        .put(&[flag(scale.is_logarithmic)])
        .put(&[flag(scale.quantity == ColorScalar::Luminance)])
        .put(&[fog_color.max_channel().max(1.0) as f32, lightmap_scale])
        .put(&[scale.display as f32, gain(&frame.background), 0.0, 0.0])
        .put(&section(frame, view))
        .words
}

/// The plane of a section in view space: normal and distance, n · x > d is cut away. Nothing is
/// beyond the plane of a null normal.
fn section(frame: &ViewportFrame, view: &Projection) -> [f32; 4] {
    let Some((normal, offset)) = frame.section else {
        return [0.0; 4];
    };
    let turned = view.rotation() * normal;
    let height = offset - normal.dot(frame.camera.eye);
    let [x, y, z] = turned.as_vec3().to_array();
    [x, y, z, height as f32]
}

/// Edges drawn over shaded surfaces are faint, so that they do not hide the shading.
fn line_opacity(frame: &ViewportFrame) -> f32 {
    match frame.shading {
        Shading::Patches => 0.45,
        _ => 1.0,
    }
}

fn backdrop(background: &Background, has_picture: bool) -> ([u8; 3], [u8; 3], f32) {
    match *background {
        Background::Color(color) => (color, color, 0.0),
        Background::Gradient { lower, upper } => (lower, upper, 0.0),
        Background::Image { fit, around, .. } => {
            let kind = match (has_picture, fit) {
                (false, _) => 0.0,
                (true, BackplateFit::Centered) => 1.0,
                (true, BackplateFit::Scaled) => 2.0,
                (true, BackplateFit::Tiled) => 3.0,
            };
            (around, around, kind)
        }
    }
}

/// Maps pixels to texture coordinates of the background image: factors, then offsets.
fn placement(background: &Background, picture: Option<[u32; 2]>, size: [f32; 2]) -> [f32; 4] {
    let (Background::Image { fit, .. }, Some(picture)) = (background, picture) else {
        return [0.0; 4];
    };
    let (factor, offset) = fit.placement(picture.map(f64::from), size.map(f64::from));
    [factor[0], factor[1], offset[0], offset[1]].map(|x| x as f32)
}

/// Factor of the linear colours of the background image.
fn gain(background: &Background) -> f32 {
    match background {
        Background::Image { gain, .. } => *gain as f32,
        _ => 1.0,
    }
}

/// The uniforms of an object. `light_scale` is the irradiance that the stored value 1 stands for; 0
/// if there is none.
pub fn object(
    view: &Projection,
    view_from: &DAffine3,
    geometry: &GpuMesh,
    tint: [f32; 4],
    light_scale: f64,
) -> [f32; WORDS] {
    let wide = |m: DMat3| Mat4::from_mat3(m.as_mat3());
    let m = view_from.matrix3;
    let mut place = wide(m);
    place.w_axis = view_from.translation.as_vec3().extend(1.0);
    let flag = |is: bool| f32::from(u8::from(is));
    BlockWriter::new()
        .put(&view.clip_from(view_from).to_cols_array())
        .put(&place.to_cols_array())
        // The cofactor matrix is the inverse transpose up to a factor, and always finite.
        .put(&wide(cofactors(m)).to_cols_array())
        .put(&tint)
        .put(&[light_scale as f32, flag(light_scale > 0.0)])
        .put(&[
            flag(geometry.attributes().normals),
            flag(m.determinant() < 0.0),
        ])
        .words
}

fn cofactors(m: DMat3) -> DMat3 {
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    // Without the sign, normals of mirrored objects would point inward.
    let sign = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    let most = cofactors
        .x_axis
        .length()
        .max(cofactors.y_axis.length())
        .max(cofactors.z_axis.length());
    cofactors * (sign / most.max(f64::MIN_POSITIVE))
}

/// The uniforms of a material; grey if it does not exist.
pub fn material(material: Option<&Material>) -> [f32; WORDS] {
    let Some(material) = material else {
        return BlockWriter::new()
            .light(Rgb::grey(0.5), 0.0)
            .light(Rgb::BLACK, 0.0)
            .light(Rgb::BLACK, 1.0)
            .words;
    };
    let glossy = material.mean_glossy();
    let flag = |is: bool| f32::from(u8::from(is));
    // Glossy light concentrates around the mirror direction; half of it is a rough approximation.
    let base = material.diffuse + 0.5 * glossy;
    let mirror = match material.dielectric {
        Some(_) => Rgb::grey(0.35),
        None => material.mirror + 0.35 * glossy,
    };
    let opacity = if is_glass(material) { 0.45 } else { 1.0 };
    // Pictures of emission are not drawn; with all of the emission, a dark surface with a few bright
    // windows would be one bright lamp.
    let emission = match material.emission_picture {
        Some(_) => Rgb::BLACK,
        None => material.emission,
    };
    BlockWriter::new()
        .light(base, (0.6 * glossy.mean()) as f32)
        .light(emission, flag(material.emits_back))
        .light(mirror, opacity)
        .words
}

/// Whether the material transmits light.
pub fn is_glass(material: &Material) -> bool {
    material.dielectric.is_some() && material.diffuse.is_black()
}
