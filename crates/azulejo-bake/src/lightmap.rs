//! Pages of texels with their irradiance.

use crate::buried::buried_regions;
use crate::layout::NO_CHART;
use crate::pad::{mean, neighbours};
use crate::samples::{Samples, TexelSample};
use azulejo_scene::Rgb;
use azulejo_trace::Surfaces;

/// Irradiance with its standard error, W/m² (lx in photometric scenes).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TexelLight {
    /// The value.
    pub irradiance: Rgb,
    /// Its standard error.
    pub standard_error: Rgb,
}

/// Light of a quarter of the area, W/m².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct QuarterLight {
    /// Mean irradiance.
    pub mean: f64,
    /// Root mean square of its standard error.
    pub error: f64,
}

/// The texels of one page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightmapPage {
    /// Width and height, texels.
    pub size: [u32; 2],
    /// Irradiance, W/m² (lx in photometric scenes), row by row from v = 0: the top row of a picture.
    pub irradiance: Vec<[f32; 3]>,
    /// Its standard error.
    pub standard_error: Vec<[f32; 3]>,
    /// The chart that each texel covers or pads; [`NO_CHART`] between charts.
    pub charts: Vec<u32>,
    /// What each texel covers, square scene units: none where it pads a chart, or lies inside of a
    /// solid.
    pub areas: Vec<f32>,
}

/// A lightmap: the light of the texels that cover a surface, before it is continued to those
/// around ([`pad_charts`](crate::pad_charts)).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lightmap {
    /// Its pages.
    pub pages: Vec<LightmapPage>,
    /// Texels that cover nothing but what lies inside of solids, in the dark.
    pub buried: usize,
}

impl Lightmap {
    /// From the light of each sample.
    ///
    /// # Panics
    /// If there is not one light for each sample.
    pub fn new(samples: &Samples, light: &[TexelLight], surfaces: &Surfaces) -> Lightmap {
        assert_eq!(samples.samples.len(), light.len(), "one light per sample");
        let is_buried = buried_regions(samples, light, surfaces);
        let mut lightmap = Lightmap {
            pages: samples
                .pages
                .iter()
                .map(|p| LightmapPage::dark(p.size))
                .collect(),
            buried: 0,
        };
        let mut buried = Vec::new();
        let numbered: Vec<(usize, &TexelSample)> = samples.samples.iter().enumerate().collect();
        for of_texel in numbered.chunk_by(|a, b| (a.1.page, a.1.texel) == (b.1.page, b.1.texel)) {
            // What is seen counts, of that what is larger.
            let rank = |s: &TexelSample| (!is_buried[s.region as usize], s.area);
            let order = |a: &(bool, f32), b: &(bool, f32)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1));
            let best = of_texel.iter().max_by(|a, b| order(&rank(a.1), &rank(b.1)));
            let Some(&(number, sample)) = best else {
                continue;
            };
            let covered = samples.pages[sample.page as usize].texels[sample.texel as usize];
            let (to, at) = (
                &mut lightmap.pages[sample.page as usize],
                covered.index as usize,
            );
            to.irradiance[at] = light[number].irradiance.to_f32();
            to.standard_error[at] = light[number].standard_error.to_f32();
            to.charts[at] = covered.chart;
            if is_buried[sample.region as usize] {
                buried.push((sample.page as usize, at));
            } else {
                to.areas[at] = covered.area;
            }
        }
        lightmap.buried = buried.len();
        lightmap.light_rims(&buried);
        lightmap
    }

    /// Gives buried texels beside others of their chart the light of those, because viewers interpolate
    /// between both.
    fn light_rims(&mut self, buried: &[(usize, usize)]) {
        let mut rims = Vec::new();
        for &(page, texel) in buried {
            let texels = &self.pages[page];
            let seen: Vec<usize> = neighbours(texels.size, texel as u32)
                .map(|(_, n)| n)
                .filter(|&n| texels.areas[n] > 0.0 && texels.charts[n] == texels.charts[texel])
                .collect();
            if !seen.is_empty() {
                let light = mean(&texels.irradiance, &seen);
                rims.push((page, texel, light, mean(&texels.standard_error, &seen)));
            }
        }
        for (page, texel, light, error) in rims {
            self.pages[page].irradiance[texel] = light;
            self.pages[page].standard_error[texel] = error;
        }
    }

    /// Mean irradiance over the area that the texels cover.
    pub fn mean(&self) -> Rgb {
        let (mut sum, mut area) = (Rgb::BLACK, 0.0);
        for page in &self.pages {
            for (e, &a) in page.irradiance.iter().zip(&page.areas) {
                sum += Rgb::from(e.map(f64::from)) * f64::from(a);
                area += f64::from(a);
            }
        }
        sum / f64::max(area, f64::MIN_POSITIVE)
    }

    /// Share of the texels of all pages that cover surfaces.
    pub fn covered_share(&self) -> f64 {
        let areas = || self.pages.iter().flat_map(|p| &p.areas);
        let covered = areas().filter(|&&a| a > 0.0).count() + self.buried;
        covered as f64 / f64::max(areas().count() as f64, 1.0)
    }

    /// Share of the area where irradiance is below a share of the largest of its page.
    pub fn share_below(&self, share: f64) -> f64 {
        let (mut below, mut all) = (0.0, 0.0);
        for page in &self.pages {
            let most = page
                .irradiance
                .iter()
                .flatten()
                .copied()
                .fold(0.0, f32::max);
            for (e, &area) in page.irradiance.iter().zip(&page.areas) {
                let bright = e.iter().copied().fold(0.0, f32::max);
                all += f64::from(area);
                if f64::from(bright) < share * f64::from(most) {
                    below += f64::from(area);
                }
            }
        }
        below / f64::max(all, f64::MIN_POSITIVE)
    }

    /// Mean irradiance and root mean square of the standard error of each quarter of the area, from dark to
    /// bright, W/m².
    pub fn quarters(&self) -> [QuarterLight; 4] {
        let mut texels: Vec<(f64, f64, f64)> = Vec::new();
        for page in &self.pages {
            for (t, &area) in page.areas.iter().enumerate().filter(|(_, a)| **a > 0.0) {
                let [e, error] = [page.irradiance[t], page.standard_error[t]]
                    .map(|value| Rgb::from(value.map(f64::from)));
                texels.push((e.mean(), (error * error).mean(), f64::from(area)));
            }
        }
        texels.sort_by(|a, b| a.0.total_cmp(&b.0));
        let all: f64 = texels.iter().map(|t| t.2).sum();
        let (mut quarters, mut areas) = ([QuarterLight::default(); 4], [0.0; 4]);
        let mut before = 0.0;
        for (e, square, area) in texels {
            let q = ((4.0 * before / all) as usize).min(3);
            before += area;
            areas[q] += area;
            quarters[q].mean += area * e;
            quarters[q].error += area * square;
        }
        for (quarter, area) in quarters.iter_mut().zip(areas) {
            let share = 1.0 / f64::max(area, f64::MIN_POSITIVE);
            quarter.mean *= share;
            quarter.error = (share * quarter.error).sqrt();
        }
        quarters
    }

    /// Root mean square of the standard error over the area and the channels, over the mean.
    pub fn relative_error(&self) -> f64 {
        let (mut sum, mut area) = (0.0, 0.0);
        for page in &self.pages {
            for (e, &a) in page.standard_error.iter().zip(&page.areas) {
                let error = Rgb::from(e.map(f64::from));
                sum += (error * error).mean() * f64::from(a);
                area += f64::from(a);
            }
        }
        let square = sum / f64::max(area, f64::MIN_POSITIVE);
        square.sqrt() / self.mean().mean().max(f64::MIN_POSITIVE)
    }
}

impl LightmapPage {
    /// A page without light or charts.
    pub fn dark(size: [u32; 2]) -> LightmapPage {
        let count = size[0] as usize * size[1] as usize;
        LightmapPage {
            size,
            irradiance: vec![[0.0; 3]; count],
            standard_error: vec![[0.0; 3]; count],
            charts: vec![NO_CHART; count],
            areas: vec![0.0; count],
        }
    }

    /// Irradiance between the centres of texels, as viewers interpolate it, at texture coordinates 0..=1.
    pub fn bilinear(&self, uv: [f64; 2]) -> Rgb {
        let (cells, weights) = bilinear_cells(self.size, uv);
        let value = |c: usize| Rgb::from(self.irradiance[c].map(f64::from));
        cells.iter().zip(weights).map(|(&c, w)| value(c) * w).sum()
    }
}

/// The four texels around a place, and their weights; beyond the border the texels at it.
pub(crate) fn bilinear_cells(size: [u32; 2], uv: [f64; 2]) -> ([usize; 4], [f64; 4]) {
    let split = |x: f64, n: u32| {
        let x = (x * f64::from(n) - 0.5).clamp(0.0, f64::from(n - 1));
        let low = (x.floor() as usize).min(n as usize - 1);
        (low, (low + 1).min(n as usize - 1), x - low as f64)
    };
    let (left, right, fx) = split(uv[0], size[0]);
    let (top, bottom, fy) = split(uv[1], size[1]);
    let at = |column: usize, row: usize| row * size[0] as usize + column;
    (
        [
            at(left, top),
            at(right, top),
            at(left, bottom),
            at(right, bottom),
        ],
        [
            (1.0 - fx) * (1.0 - fy),
            fx * (1.0 - fy),
            (1.0 - fx) * fy,
            fx * fy,
        ],
    )
}
