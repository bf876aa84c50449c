//! A page of a lightmap as pixels.

use crate::bake::BakedDocument;
use crate::gpu::{ColorScalar, ColorScale};
use crate::view::ColorMap;
use azulejo::bake::LightmapPage;
use azulejo::bake::layout::NO_CHART;
use azulejo::render::{Tone, auto_exposure, srgb_from_linear};
use azulejo::scene::{Image, Rgb};
use clap::ValueEnum;
use egui::{Color32, ColorImage};
use rayon::prelude::*;
use std::sync::Arc;

/// Most pixels along a side: more are not seen, and take long to colour.
const MAX_SIDE: usize = 4096;
/// Shares of the values that a colour scale begins and ends at: a few texels would stretch it.
const ENDS: [f64; 2] = [0.01, 0.99];
/// Most values that are sorted for the ends of a scale.
const MAX_SORTED: usize = 100_000;
/// Smallest value of a logarithmic scale, relative to the largest.
const DYNAMICS: f64 = 1e-4;
/// Grey of texels that cover nothing.
const EMPTY: Color32 = Color32::from_gray(28);

/// What is shown of a lightmap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum LightmapView {
    /// The light as on white surfaces.
    #[default]
    Light,
    /// The luminance of the irradiance in false colours.
    FalseColor,
    /// Its standard error in per cent of the mean.
    Error,
    /// The charts, each in a colour.
    Charts,
    /// Texels per metre of each chart.
    Density,
}

/// A page, and how it is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PageView {
    /// What the colours of texels mean.
    pub quantity: LightmapView,
    /// The page, from 0.
    pub page: usize,
    /// Exposure beside the automatic one.
    pub stops: f64,
    /// Whether the colour scale is logarithmic.
    pub is_logarithmic: bool,
    /// The colours that stand for values.
    pub map: ColorMap,
}

/// A place on a page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Texel {
    /// The page, from 0.
    pub page: usize,
    /// Column and row, from the upper left.
    pub place: [u32; 2],
}

/// A page as pixels.
pub struct PagePicture {
    /// Width and height of the page, texels.
    pub size: [u32; 2],
    /// The colour scale, if values are shown.
    pub scale: Option<ColorScale>,
    page: usize,
    pixels: Arc<ColorImage>,
}

impl PagePicture {
    /// Colours a page; of large ones every few texels, so that no side is longer than `most`.
    pub fn new(result: &BakedDocument, view: &PageView, most: usize) -> PagePicture {
        let page = &result.baked.lightmap.pages[view.page];
        let scale = values(result, view.quantity).map(|value| {
            let ends = ends(result, &value);
            color_scale(ends, view)
        });
        let color = coloring(result, view, scale);
        let [width, height] = page.size.map(|n| n as usize);
        let step = width.max(height).div_ceil(most.clamp(1, MAX_SIDE)).max(1);
        let columns = width.div_ceil(step);
        let texel = |k: usize| (k / columns) * step * width + (k % columns) * step;
        let count = columns * height.div_ceil(step);
        let pixels = (0..count).into_par_iter().map(|k| color(page, texel(k)));
        let pixels = ColorImage::new([columns, height.div_ceil(step)], pixels.collect());
        PagePicture {
            size: page.size,
            scale,
            page: view.page,
            pixels: Arc::new(pixels),
        }
    }

    /// The pixels, which are shared and not copied.
    pub fn pixels(&self) -> Arc<ColorImage> {
        Arc::clone(&self.pixels)
    }

    /// The texel at a place in texels; `None` outside.
    pub fn texel(&self, at: [f32; 2]) -> Option<Texel> {
        let is_inside = (0..2).all(|k| at[k] >= 0.0 && at[k] < self.size[k] as f32);
        is_inside.then(|| Texel {
            page: self.page,
            place: at.map(|x| x as u32),
        })
    }
}

/// What a texel of a page shows as a number.
type TexelValue = Box<dyn Fn(&LightmapPage, usize) -> f64 + Sync>;

/// The values of a quantity; `None` if it has none.
fn values(result: &BakedDocument, quantity: LightmapView) -> Option<TexelValue> {
    match quantity {
        LightmapView::Light | LightmapView::Charts => None,
        LightmapView::FalseColor => Some(Box::new(|page, t| luminance(page.irradiance[t]))),
        LightmapView::Error => {
            let mean = result.baked.lightmap.mean().luminance();
            let share = 100.0 / mean.max(f64::MIN_POSITIVE);
            Some(Box::new(move |page, t| {
                share * luminance(page.standard_error[t])
            }))
        }
        LightmapView::Density => {
            let densities = result.densities.clone();
            Some(Box::new(move |page, t| {
                let chart = page.charts[t] as usize;
                densities.get(chart).copied().unwrap_or(0.0)
            }))
        }
    }
}

/// The usual range of the values of all texels that cover something.
fn ends(result: &BakedDocument, value: &TexelValue) -> (f64, f64) {
    let pages = &result.baked.lightmap.pages;
    let count: usize = pages.iter().map(|page| page.areas.len()).sum();
    let step = count.div_ceil(MAX_SORTED).max(1);
    let mut values: Vec<f64> = pages
        .iter()
        .flat_map(|page| {
            let covered = (0..page.areas.len()).filter(|&t| page.areas[t] > 0.0);
            covered.step_by(step).map(|t| value(page, t))
        })
        .filter(|v| v.is_finite())
        .collect();
    values.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let rank = share * values.len().saturating_sub(1) as f64;
        values.get(rank.round() as usize).copied().unwrap_or(0.0)
    };
    (at(ENDS[0]), at(ENDS[1]))
}

/// The scale between two values.
fn color_scale((low, high): (f64, f64), view: &PageView) -> ColorScale {
    let high = if high > 0.0 { high } else { 1.0 };
    let low = match (view.is_logarithmic, view.quantity) {
        (true, _) => low.clamp(DYNAMICS * high, 0.5 * high),
        // Densities that are nearly alike are shown as such.
        (false, LightmapView::Density) => low.min(0.5 * high),
        (false, _) => 0.0,
    };
    ColorScale {
        map: view.map,
        quantity: ColorScalar::default(),
        low,
        high,
        is_logarithmic: view.is_logarithmic,
        bands: 0,
        display: 1.0,
    }
}

type TexelColor = Box<dyn Fn(&LightmapPage, usize) -> Color32 + Sync>;

/// The colour of a texel.
fn coloring(result: &BakedDocument, view: &PageView, scale: Option<ColorScale>) -> TexelColor {
    let value = values(result, view.quantity);
    match (view.quantity, value, scale) {
        (LightmapView::Charts, ..) => Box::new(|page, t| match page.charts[t] {
            NO_CHART => EMPTY,
            chart if page.areas[t] > 0.0 => chart_color(chart, 1.0),
            // What pads a chart is darker.
            chart => chart_color(chart, 0.5),
        }),
        (_, Some(value), Some(scale)) => Box::new(move |page, t| {
            if page.areas[t] > 0.0 {
                let [r, g, b] = scale.map.color(scale.fraction(value(page, t)));
                Color32::from_rgb(r, g, b)
            } else {
                EMPTY
            }
        }),
        _ => {
            let exposure = exposure(&result.baked.lightmap.pages) * view.stops.exp2();
            let tone = Tone::default();
            Box::new(move |page, t| {
                if page.charts[t] == NO_CHART {
                    return EMPTY;
                }
                let light = Rgb::from(page.irradiance[t].map(f64::from)) * exposure;
                let [r, g, b] = tone
                    .map(light)
                    .to_array()
                    .map(|x| (255.0 * srgb_from_linear(x)).round() as u8);
                Color32::from_rgb(r, g, b)
            })
        }
    }
}

/// An exposure that suits all pages.
fn exposure(pages: &[LightmapPage]) -> f64 {
    let count: usize = pages.iter().map(|page| page.areas.len()).sum();
    let step = count.div_ceil(MAX_SORTED).max(1);
    let covered = pages.iter().flat_map(|page| {
        let covered = (0..page.areas.len()).filter(|&t| page.areas[t] > 0.0);
        covered.step_by(step).map(|t| page.irradiance[t])
    });
    let pixels: Vec<[f32; 3]> = covered.collect();
    auto_exposure(&Image::opaque(pixels.len() as u32, 1, pixels))
}

/// A colour of its own for each chart: hues by the golden angle, which keeps neighbours in number apart.
fn chart_color(chart: u32, brightness: f32) -> Color32 {
    const GOLDEN: f64 = 0.618_033_988_749_895;
    let hue = (f64::from(chart) * GOLDEN).fract() as f32;
    let shade = [0.95, 0.75, 0.6][chart as usize % 3] * brightness;
    egui::ecolor::Hsva::new(hue, 0.55, shade, 1.0).into()
}

/// The luminance of linear light.
pub fn luminance(light: [f32; 3]) -> f64 {
    Rgb::from(light.map(f64::from)).luminance()
}
