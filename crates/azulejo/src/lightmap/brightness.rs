//! Pictures of 8 bits for surfaces of very different brightness.
//!
//! A picture of 8 bits is scaled to its brightest texel: a hot patch over a lamp would leave a room to the
//! last few steps. Parts of objects that are much brighter than the rest have a picture of their own, of the same
//! size and with the same coordinates, so that files of irradiance beside it stay one page.

use super::Baked;
use azulejo_bake::layout::NO_CHART;
use azulejo_bake::{LightmapPage, srgb_bytes};
use azulejo_formats::gltf::patch::{self as gltf, MediaType};
use azulejo_formats::picture::png;
use std::collections::HashSet;
use std::io;

/// Brightest texel over the mean above which bright parts are kept apart.
const MOST: f32 = 16.0;

/// Brightest texel of a chart over that of the median chart, and over the mean of the page, above which it is
/// bright.
const BRIGHT: f32 = 4.0;

/// Pictures of 8 bits of a lightmap, and what reads which.
#[derive(Clone, Debug, PartialEq)]
pub struct BytePictures {
    /// First those of all pages, then those of bright parts.
    pub pictures: Vec<BytePicture>,
    /// The picture of each triangle of each receiver.
    pub of_triangles: Vec<Vec<u32>>,
    /// Share of the area that has pictures of its own.
    pub bright_share: f64,
}

/// A picture of 8 bits.
#[derive(Clone, Debug, PartialEq)]
pub struct BytePicture {
    /// Its name in files.
    pub name: String,
    /// Its page.
    pub page: usize,
    /// Its sRGB bytes, row by row.
    pub rgb: Vec<u8>,
    /// Irradiance of the linear value 1.
    pub intensity: f64,
}

impl BytePicture {
    /// A picture of a glTF file.
    ///
    /// # Errors
    /// Its size is not that of its page.
    pub fn png(&self, baked: &Baked) -> io::Result<gltf::LightmapPage> {
        let size = baked.lightmap.pages[self.page].size;
        png_page(self.name.clone(), size, &self.rgb, self.intensity)
    }
}

/// Bytes in sRGB, row by row, as a picture of a glTF file; `intensity` is the light of a white texel.
///
/// # Errors
/// There are not three bytes for each texel.
pub fn png_page(
    name: String,
    [width, height]: [u32; 2],
    rgb: &[u8],
    intensity: f64,
) -> io::Result<gltf::LightmapPage> {
    let mut picture = Vec::new();
    png::write(width, height, rgb, &mut picture)?;
    Ok(gltf::LightmapPage {
        name,
        picture,
        media_type: MediaType::Png,
        intensity,
        fallback: None,
        directions: Vec::new(),
    })
}

/// A part of an object, which has one material: its receiver and number.
type PartKey = (usize, u32);

impl BytePictures {
    /// The pictures of a lightmap; without any for bright parts unless they are wanted.
    pub fn new(baked: &Baked, separates_bright: bool) -> BytePictures {
        let layout = &baked.atlas.layout;
        let pages = &baked.lightmap.pages;
        let mut bytes = BytePictures {
            pictures: Vec::new(),
            of_triangles: layout.receivers.iter().map(|r| r.pages.clone()).collect(),
            bright_share: 0.0,
        };
        let mut bright = Vec::new();
        // Pages come first, a picture for each, so that their numbers are those of their pictures.
        for (number, page) in pages.iter().enumerate() {
            let name = match pages.len() {
                1 => "lightmap".to_owned(),
                _ => format!("lightmap {}", number + 1),
            };
            let is_bright = if separates_bright {
                bright_charts(baked, number)
            } else {
                None
            };
            let picture = |name, (rgb, intensity)| BytePicture {
                name,
                page: number,
                rgb,
                intensity,
            };
            let Some(is_bright) = is_bright else {
                let whole = picture(name, srgb_bytes(&page.irradiance));
                bytes.pictures.push(whole);
                continue;
            };
            // Keep the bright charts apart, and leave the others to the picture of the page.
            let of_bright = picture(format!("{name}, bright"), alone(page, &is_bright));
            let is_other: Vec<bool> = is_bright.iter().map(|b| !b).collect();
            bytes.pictures.push(picture(name, alone(page, &is_other)));
            bright.push((of_bright, is_bright));
        }
        let mut areas = [0.0; 2];
        // Pictures of bright charts follow; the triangles of these charts read them.
        for (of_bright, is_bright) in bright {
            let number = bytes.pictures.len() as u32;
            for (of_receiver, charts) in bytes.of_triangles.iter_mut().zip(&layout.receivers) {
                for (picture, &chart) in of_receiver.iter_mut().zip(&charts.charts) {
                    if *picture == of_bright.page as u32 && is(&is_bright, chart) {
                        *picture = number;
                    }
                }
            }
            bytes.pictures.push(of_bright);
        }
        // Compare the area that has pictures of its own with the rest.
        for (r, pictures) in bytes.of_triangles.iter().enumerate() {
            for (t, &picture) in pictures.iter().enumerate() {
                let area = baked.atlas.receivers[r].area_vector(t).length();
                areas[usize::from(picture as usize >= pages.len())] += area;
            }
        }
        bytes.bright_share = areas[1] / f64::max(areas[0] + areas[1], f64::MIN_POSITIVE);
        bytes
    }

    /// Share of the area where irradiance is below a share of the largest of its picture.
    pub fn share_below(&self, baked: &Baked, share: f64) -> f64 {
        let layout = &baked.atlas.layout;
        let mut of_charts = vec![0.0; layout.charts as usize];
        for (pictures, receiver) in self.of_triangles.iter().zip(&layout.receivers) {
            for (&picture, &chart) in pictures.iter().zip(&receiver.charts) {
                if let Some(most) = of_charts.get_mut(chart as usize) {
                    *most = self.pictures[picture as usize].intensity;
                }
            }
        }
        let (mut below, mut all) = (0.0, 0.0);
        for page in &baked.lightmap.pages {
            for (texel, &area) in page.areas.iter().enumerate().filter(|(_, a)| **a > 0.0) {
                let light = page.irradiance[texel].iter().copied().fold(0.0, f32::max);
                all += f64::from(area);
                if f64::from(light) < share * of_charts[page.charts[texel] as usize] {
                    below += f64::from(area);
                }
            }
        }
        below / f64::max(all, f64::MIN_POSITIVE)
    }
}

fn is(of_charts: &[bool], chart: u32) -> bool {
    of_charts.get(chart as usize).copied().unwrap_or(false)
}

/// For each chart whether it belongs to a bright part of a page; `None` if the page needs no other picture, or if
/// nothing would be left.
fn bright_charts(baked: &Baked, number: usize) -> Option<Vec<bool>> {
    let page = &baked.lightmap.pages[number];
    let layout = &baked.atlas.layout;
    let mut most = vec![0.0_f32; layout.charts as usize];
    let (mut sum, mut area) = (0.0, 0.0);
    for (texel, &chart) in page.charts.iter().enumerate() {
        let light = page.irradiance[texel];
        if let Some(most) = most.get_mut(chart as usize) {
            *most = light.iter().copied().fold(*most, f32::max);
        }
        let of_texel = page.areas[texel];
        sum += of_texel * light.iter().sum::<f32>() / 3.0;
        area += of_texel;
    }
    let mean = sum / area.max(f32::MIN_POSITIVE);
    let brightest = most.iter().copied().fold(0.0, f32::max);
    if brightest <= MOST * mean {
        return None;
    }
    let mut of_page: Vec<f32> = most.iter().copied().filter(|m| *m > 0.0).collect();
    of_page.sort_by(f32::total_cmp);
    let median = of_page[of_page.len() / 2];
    let threshold = BRIGHT * median.max(mean);
    // A part has one material, and a material one picture.
    let parts = || {
        let receivers = baked.atlas.receivers.iter().zip(&layout.receivers);
        receivers
            .enumerate()
            .flat_map(move |(r, (receiver, charts))| {
                let of_page = receiver.parts.iter().zip(&charts.charts).zip(&charts.pages);
                of_page
                    .filter(move |((_, chart), page)| {
                        **page as usize == number && **chart != NO_CHART
                    })
                    .map(move |((part, chart), _)| ((r, *part), *chart))
            })
    };
    let is_hot = |chart: u32| most[chart as usize] > threshold;
    let hot: HashSet<PartKey> = parts()
        .filter(|(_, chart)| is_hot(*chart))
        .map(|p| p.0)
        .collect();
    let mut is_bright = vec![false; most.len()];
    let mut has_others = false;
    for (part, chart) in parts() {
        is_bright[chart as usize] = hot.contains(&part);
        has_others |= !is_bright[chart as usize];
    }
    has_others.then_some(is_bright)
}

/// The bytes of some charts of a page, dark elsewhere, and the light of their brightest texel.
fn alone(page: &LightmapPage, is_shown: &[bool]) -> (Vec<u8>, f64) {
    let texel = |(light, &chart): (&[f32; 3], &u32)| {
        if is(is_shown, chart) {
            *light
        } else {
            [0.0; 3]
        }
    };
    let light: Vec<[f32; 3]> = page
        .irradiance
        .iter()
        .zip(&page.charts)
        .map(texel)
        .collect();
    srgb_bytes(&light)
}
