//! Pages of texels with their irradiance.

use crate::buried::buried_regions;
use crate::lightmap_page::{LightmapPage, mean, neighbours};
use crate::samples::{Samples, TexelSample};
use azulejo_radiosity::sites::SiteLight;
use azulejo_scene::Rgb;
use azulejo_trace::Surfaces;

/// Light of a quarter of the area, W/m².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct QuarterLight {
    /// Mean irradiance.
    pub mean: f64,
    /// Root mean square of its standard error.
    pub error: f64,
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

/// The sample that a texel shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShownSample {
    /// Page of the texel.
    pub page: u32,
    /// Its place on the page, row by row.
    pub at: u32,
    /// The sample.
    pub sample: u32,
    /// Whether it lies inside of a solid, in the dark.
    pub is_buried: bool,
}

/// The sample that each covered texel shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShownSamples {
    texels: Vec<ShownSample>,
}

impl ShownSamples {
    /// Chooses by the light of each sample: of those of a texel the larger one that is seen.
    ///
    /// # Panics
    /// If there is not one light for each sample.
    pub fn new(samples: &Samples, light: &[SiteLight], surfaces: &Surfaces) -> ShownSamples {
        assert_eq!(samples.samples.len(), light.len(), "one light per sample");
        let is_buried = buried_regions(samples, light, surfaces);
        let of_texels = samples
            .samples
            .chunk_by(|a, b| (a.page, a.texel) == (b.page, b.texel));
        let mut first = 0;
        let shown = |of_texel: &[TexelSample]| {
            let numbers = first..;
            first += of_texel.len();
            // What is seen counts, of that what is larger.
            let rank = |s: &TexelSample| (!is_buried[s.region as usize], s.area);
            let order = |a: &(bool, f32), b: &(bool, f32)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1));
            let best = numbers
                .zip(of_texel)
                .max_by(|a, b| order(&rank(a.1), &rank(b.1)))?;
            let coverage = &samples.pages[best.1.page as usize];
            Some(ShownSample {
                page: best.1.page,
                at: coverage.texels[best.1.texel as usize].index,
                sample: best.0 as u32,
                is_buried: is_buried[best.1.region as usize],
            })
        };
        ShownSamples {
            texels: of_texels.filter_map(shown).collect(),
        }
    }

    /// Those that are not buried.
    pub fn seen(&self) -> impl Iterator<Item = &ShownSample> {
        self.texels.iter().filter(|shown| !shown.is_buried)
    }

    /// The lightmap of some light of all samples.
    pub fn lightmap(&self, samples: &Samples, light: &[SiteLight]) -> Lightmap {
        let dark = samples.pages.iter().map(|p| LightmapPage::dark(p.size));
        let mut lightmap = Lightmap {
            pages: dark.collect(),
            buried: 0,
        };
        let nothing = samples.pages.iter().map(|p| p.size[0] * p.size[1]);
        let nothing = nothing.map(|count| vec![NOT_SEEN; count as usize]);
        let mut seen = SeenSamples {
            samples: &samples.samples,
            pages: nothing.collect(),
        };
        let mut buried = Vec::new();
        for shown in &self.texels {
            let (page, at) = (shown.page as usize, shown.at as usize);
            let sample = &samples.samples[shown.sample as usize];
            let covered = &samples.pages[page].texels[sample.texel as usize];
            let to = &mut lightmap.pages[page];
            to.irradiance[at] = light[shown.sample as usize].irradiance;
            to.standard_error[at] = light[shown.sample as usize].standard_error;
            to.charts[at] = covered.chart;
            if shown.is_buried {
                buried.push((page, at));
            } else {
                to.areas[at] = covered.area;
                seen.pages[page][at] = shown.sample;
            }
        }
        lightmap.buried = buried.len();
        lightmap.light_rims(&buried, &seen);
        lightmap
    }
}

/// No sample is seen at a texel.
const NOT_SEEN: u32 = u32::MAX;

/// The samples that are seen, by page and texel.
struct SeenSamples<'a> {
    samples: &'a [TexelSample],
    pages: Vec<Vec<u32>>,
}

impl SeenSamples<'_> {
    fn at(&self, page: usize, texel: usize) -> Option<&TexelSample> {
        self.samples.get(self.pages[page][texel] as usize)
    }
}

impl Lightmap {
    /// Gives buried texels beside others of their chart the light of those, because viewers interpolate
    /// between both. Where a thin wall has its two sides around one texel, the side that is nearer counts:
    /// the one that shows most of the texels around.
    fn light_rims(&mut self, buried: &[(usize, usize)], shown: &SeenSamples) {
        let mut rims = Vec::new();
        for &(page, texel) in buried {
            let texels = &self.pages[page];
            let mut sides: Vec<(u32, f32, Vec<usize>)> = Vec::new();
            for (_, beside) in neighbours(texels.size, texel as u32) {
                let Some(sample) = shown.at(page, beside) else {
                    continue;
                };
                if texels.charts[beside] != texels.charts[texel] {
                    continue;
                }
                match sides.iter_mut().find(|side| side.0 == sample.region) {
                    Some(side) => {
                        side.1 += sample.free;
                        side.2.push(beside);
                    }
                    None => sides.push((sample.region, sample.free, vec![beside])),
                }
            }
            if let Some((_, _, seen)) = sides.iter().max_by(|a, b| a.1.total_cmp(&b.1)) {
                let light = mean(&texels.irradiance, seen);
                rims.push((page, texel, light, mean(&texels.standard_error, seen)));
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
