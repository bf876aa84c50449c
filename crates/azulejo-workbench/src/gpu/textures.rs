//! Textures and background images in GPU memory.

use super::frame::TextureSource;
use azulejo::render::srgb_from_linear;
use azulejo::scene::Image;
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::OnceLock;

/// The longest side of an uploaded image, pixels.
const MAX_PIXELS: u32 = 4096;
/// Size of the table from linear light to sRGB: fine enough to produce every byte.
const STEPS: usize = 1 << 14;

/// Textures by the keys of the images multiplied in them.
pub struct TextureCache {
    loaded: HashMap<Vec<u64>, LoadedTexture>,
    layout: wgpu::BindGroupLayout,
    sampler: wgpu::Sampler,
    white: wgpu::BindGroup,
    white_view: wgpu::TextureView,
}

struct LoadedTexture {
    view: wgpu::TextureView,
    group: wgpu::BindGroup,
    used: u64,
}

impl TextureCache {
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> TextureCache {
        let layout = layout(device);
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("pictures"),
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..wgpu::SamplerDescriptor::default()
        });
        let white = Image {
            width: 1,
            height: 1,
            pixels: vec![[1.0; 3]],
            alpha: None,
        };
        let white_view = load(device, queue, Cow::Borrowed(&white));
        TextureCache {
            loaded: HashMap::new(),
            white: group(device, &layout, &white_view, &sampler),
            white_view,
            layout,
            sampler,
        }
    }

    pub fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    pub fn sampler(&self) -> &wgpu::Sampler {
        &self.sampler
    }

    /// Uploads the product of several images; returns its key, or `None` if none of them has
    /// pixels.
    pub fn upload(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        textures: &[TextureSource],
        frame: u64,
    ) -> Option<Vec<u64>> {
        let has_pixels = |p: &&TextureSource| p.image.is_some_and(|i| !i.pixels.is_empty());
        let textures: Vec<&TextureSource> = textures.iter().filter(has_pixels).collect();
        let key: Vec<u64> = textures.iter().map(|p| p.key).collect();
        if let Some(loaded) = self.loaded.get_mut(&key) {
            loaded.used = frame;
            return Some(key);
        }
        let images: Vec<&Image> = textures.iter().filter_map(|p| p.image).collect();
        let view = load(device, queue, product(&images)?);
        let loaded = LoadedTexture {
            group: group(device, &self.layout, &view, &self.sampler),
            view,
            used: frame,
        };
        self.loaded.insert(key.clone(), loaded);
        Some(key)
    }

    /// The bind group of a key; a white texture for `None` and for freed ones.
    pub fn group(&self, key: Option<&Vec<u64>>) -> &wgpu::BindGroup {
        let loaded = key.and_then(|key| self.loaded.get(key));
        loaded.map_or(&self.white, |l| &l.group)
    }

    pub fn view(&self, key: Option<&Vec<u64>>) -> &wgpu::TextureView {
        let loaded = key.and_then(|key| self.loaded.get(key));
        loaded.map_or(&self.white_view, |l| &l.view)
    }

    /// Frees the textures last used before the given frame.
    pub fn free_before(&mut self, frame: u64) {
        self.loaded.retain(|_, loaded| loaded.used >= frame);
    }
}

fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty,
        count: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("texture"),
        entries: &[entry(0, texture_binding()), entry(1, sampler_binding())],
    })
}

pub fn texture_binding() -> wgpu::BindingType {
    wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    }
}

pub fn sampler_binding() -> wgpu::BindingType {
    wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)
}

fn group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    view: &wgpu::TextureView,
    sampler: &wgpu::Sampler,
) -> wgpu::BindGroup {
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("texture"),
        layout,
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(view),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: wgpu::BindingResource::Sampler(sampler),
            },
        ],
    })
}

/// Multiplies images over the same texture coordinates; `None` for an empty list.
fn product<'a>(images: &[&'a Image]) -> Option<Cow<'a, Image>> {
    let (&first, others) = images.split_first()?;
    if others.is_empty() {
        return Some(Cow::Borrowed(first));
    }
    let width = images.iter().map(|i| i.width).max()?.min(MAX_PIXELS);
    let height = images.iter().map(|i| i.height).max()?.min(MAX_PIXELS);
    let pixel = |k: u32| {
        let (x, y) = (f64::from(k % width) + 0.5, f64::from(k / width) + 0.5);
        let (u, v) = (x / f64::from(width), 1.0 - y / f64::from(height));
        images.iter().fold([1.0; 3], |all, image| {
            let one = image.sample(u, v);
            [0, 1, 2].map(|c| all[c] * one[c])
        })
    };
    let pixels = (0..width * height).into_par_iter().map(pixel).collect();
    Some(Cow::Owned(Image {
        width,
        height,
        pixels,
        alpha: None,
    }))
}

/// Uploads an image with its mip levels.
fn load(device: &wgpu::Device, queue: &wgpu::Queue, image: Cow<Image>) -> wgpu::TextureView {
    let most = device.limits().max_texture_dimension_2d.min(MAX_PIXELS);
    let mut level = image;
    while level.width.max(level.height) > most {
        level = Cow::Owned(halved(&level));
    }
    let levels = level.width.max(level.height).max(1).ilog2() + 1;
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("texture"),
        size: extent(&level),
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for number in 0..levels {
        let place = wgpu::TexelCopyTextureInfo {
            mip_level: number,
            ..texture.as_image_copy()
        };
        let rows = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(4 * level.width),
            rows_per_image: None,
        };
        queue.write_texture(place, &texels(&level), rows, extent(&level));
        if number + 1 < levels {
            level = Cow::Owned(halved(&level));
        }
    }
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn extent(image: &Image) -> wgpu::Extent3d {
    wgpu::Extent3d {
        width: image.width.max(1),
        height: image.height.max(1),
        depth_or_array_layers: 1,
    }
}

/// The image at half the size, rounded down, each pixel the mean of four.
fn halved(image: &Image) -> Image {
    let (width, height) = ((image.width / 2).max(1), (image.height / 2).max(1));
    let pixel = |k: u32| {
        let (x, y) = (2 * (k % width), 2 * (k / width));
        let (right, below) = ((x + 1).min(image.width - 1), (y + 1).min(image.height - 1));
        let four = [(x, y), (right, y), (x, below), (right, below)];
        let four = four.map(|(x, y)| image.pixel(x, y));
        [0, 1, 2].map(|c| 0.25 * four.iter().map(|p| p[c]).sum::<f32>())
    };
    Image {
        width,
        height,
        pixels: (0..width * height).into_par_iter().map(pixel).collect(),
        alpha: None,
    }
}

/// Opaque sRGB bytes.
fn texels(image: &Image) -> Vec<u8> {
    static TABLE: OnceLock<Vec<u8>> = OnceLock::new();
    let table = TABLE.get_or_init(|| {
        let byte = |k| (255.0 * srgb_from_linear(k as f64 / STEPS as f64)).round() as u8;
        (0..=STEPS).map(byte).collect()
    });
    // NaN becomes index 0.
    let byte = |x: f32| table[(x.clamp(0.0, 1.0) * STEPS as f32 + 0.5) as usize];
    let texel = |p: &[f32; 3]| [byte(p[0]), byte(p[1]), byte(p[2]), 255];
    image.pixels.par_iter().flat_map_iter(texel).collect()
}
