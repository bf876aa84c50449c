//! The pages of a lightmap in GPU memory.

use super::geometry::half;
use azulejo::scene::Image;
use rayon::prelude::*;

/// Most texels of all pages, of eight bytes each: larger pages are halved until they fit.
const MAX_TEXELS: u64 = 1 << 25;
/// The value stored for the largest irradiance: far below the largest half float, 65504.
const BRIGHTEST: f32 = 16384.0;

/// The pages of a lightmap: irradiance.
#[derive(Clone, Copy, Debug)]
pub struct LightmapPages<'a> {
    /// Their identity and revision.
    pub key: u64,
    /// The pages, rows from the top.
    pub pages: &'a [Image],
}

/// The layers of a texture, one for each page; a dark one if there are none.
pub struct LightmapTexture {
    key: Option<u64>,
    pub view: wgpu::TextureView,
    /// Irradiance that the stored value 1 stands for.
    pub scale: f32,
}

impl LightmapTexture {
    /// A dark texel.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> LightmapTexture {
        LightmapTexture {
            key: None,
            view: load(device, queue, [1, 1], &[vec![[0; 4]]]),
            scale: 1.0,
        }
    }

    /// Uploads pages unless they are there.
    pub fn upload(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        lightmap: Option<LightmapPages>,
    ) {
        let key = lightmap.map(|l| l.key);
        if key == self.key {
            return;
        }
        let pages = lightmap.map_or(&[][..], |l| l.pages);
        let layers = device.limits().max_texture_array_layers as usize;
        if pages.is_empty() || pages.len() >= layers {
            *self = LightmapTexture {
                key,
                ..LightmapTexture::new(device, queue)
            };
            return;
        }
        let most = pages.iter().flat_map(|p| p.pixels.iter().flatten());
        let most = most.copied().filter(|v| v.is_finite()).fold(0.0, f32::max);
        let scale = if most > 0.0 { most / BRIGHTEST } else { 1.0 };
        let side = |size: fn(&Image) -> u32| pages.iter().map(size).max().unwrap_or(1).max(1);
        let whole = [side(|p| p.width), side(|p| p.height)];
        let step = step(whole, pages.len(), device.limits().max_texture_dimension_2d);
        let size = whole.map(|n| n.div_ceil(step));
        let texels: Vec<_> = pages.iter().map(|p| layer(p, size, step, scale)).collect();
        *self = LightmapTexture {
            key,
            view: load(device, queue, size, &texels),
            scale,
        };
    }
}

/// Texels along a side that become one, so that pages of this size fit.
fn step(size: [u32; 2], pages: usize, most: u32) -> u32 {
    let fits = |step: u32| {
        let [width, height] = size.map(|n| n.div_ceil(step));
        let texels = u64::from(width) * u64::from(height) * pages as u64;
        width.max(height) <= most && texels <= MAX_TEXELS
    };
    (0..31)
        .map(|k| 1 << k)
        .find(|&step| fits(step))
        .unwrap_or(1 << 30)
}

/// A page in the upper left corner of a layer, each texel the mean of a square of `step` texels.
fn layer(page: &Image, size: [u32; 2], step: u32, scale: f32) -> Vec<[u16; 4]> {
    let texel = |k: u32| {
        let first = [k % size[0], k / size[0]].map(|n| n * step);
        let (mut sum, mut count) = ([0.0f32; 3], 0.0f32);
        for y in first[1]..(first[1] + step).min(page.height) {
            for x in first[0]..(first[0] + step).min(page.width) {
                let texel = page.pixel(x, y);
                (0..3).for_each(|c| sum[c] += texel[c]);
                count += 1.0;
            }
        }
        let [r, g, b] = sum.map(|s| half(s / (count.max(1.0) * scale)));
        [r, g, b, half(1.0)]
    };
    (0..size[0] * size[1]).into_par_iter().map(texel).collect()
}

/// Layers of a texture for this many pages: OpenGL takes one layer for a plain texture, and multiples of six for the
/// sides of cubes.
fn layer_count(pages: u32) -> u32 {
    match pages.max(2) {
        pages if pages.is_multiple_of(6) => pages + 1,
        pages => pages,
    }
}

fn load(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    [width, height]: [u32; 2],
    layers: &[Vec<[u16; 4]>],
) -> wgpu::TextureView {
    let size = wgpu::Extent3d {
        width,
        height,
        depth_or_array_layers: layer_count(layers.len() as u32),
    };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("lightmap"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let rows = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(8 * width),
        rows_per_image: None,
    };
    for (number, texels) in (0..).zip(layers) {
        let place = wgpu::TexelCopyTextureInfo {
            origin: wgpu::Origin3d {
                x: 0,
                y: 0,
                z: number,
            },
            ..texture.as_image_copy()
        };
        let one = wgpu::Extent3d {
            depth_or_array_layers: 1,
            ..size
        };
        queue.write_texture(place, bytemuck::cast_slice(texels), rows, one);
    }
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..wgpu::TextureViewDescriptor::default()
    })
}

pub fn lightmap_binding() -> wgpu::BindingType {
    wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension: wgpu::TextureViewDimension::D2Array,
        multisampled: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_are_halved_until_they_fit() {
        assert_eq!(step([1024, 1024], 1, 8192), 1);
        assert_eq!(step([16384, 512], 1, 8192), 2);
        assert_eq!(step([8192, 8192], 4, 8192), 4);
        assert_eq!([1, 2, 6, 7].map(layer_count), [2, 2, 7, 7]);
        let page = Image::opaque(3, 2, (0..6u8).map(|v| [f32::from(v); 3]).collect());
        let halved = layer(&page, [2, 1], 2, 0.5);
        // Means of 0, 1, 3, 4 and of 2, 5, in units of a half.
        assert_eq!(halved[0][0], half(4.0));
        assert_eq!(halved[1][2], half(7.0));
    }
}
