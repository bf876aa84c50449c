//! Removes the noise of texels that were gathered each by itself, by their own standard errors.
//!
//! Non-local means: a texel becomes the weighted mean of those around whose surroundings differ from its own by no more
//! than the noise of both (Rousselle, Knaus and Zwicker, *Adaptive rendering with non-local means filtering*, SIGGRAPH
//! Asia 2012). Only texels of the same region of a chart count, so that no light crosses a seam or a contact.

use crate::lightmap::{Lightmap, ShownSamples};
use crate::lightmap_page::LightmapPage;
use crate::samples::Samples;
use azulejo_trace::{Cancelled, Progress};
use rayon::prelude::*;

/// Texels to each side that are averaged.
const REACH: i32 = 6;

/// Texels to each side that are compared.
const PATCH: i32 = 1;

/// How many times the noise of both two texels may differ before they count less: the paper's k.
const SENSITIVITY: f64 = 0.6;

/// Part of the variance of a texel that counts as known where surroundings are compared.
const LEAST_VARIANCE: f64 = 1e-12;

/// No region: texels between charts, and those inside of solids.
const NO_REGION: u32 = u32::MAX;

/// The region of each texel of each page.
fn regions(shown: &ShownSamples, samples: &Samples, lightmap: &Lightmap) -> Vec<Vec<u32>> {
    let pages = lightmap.pages.iter();
    let mut regions: Vec<Vec<u32>> = pages.map(|p| vec![NO_REGION; p.charts.len()]).collect();
    for texel in shown.seen() {
        let region = samples.samples[texel.sample as usize].region;
        regions[texel.page as usize][texel.at as usize] = region;
    }
    regions
}

/// Filters the texels of all pages and sets their standard errors to what is left; `lightmap` is that of `shown`, before
/// its charts are padded. Texels without noise keep their values. The result does not depend on the number of threads.
///
/// # Errors
/// [`Cancelled`] when `progress` was.
pub fn denoise(
    lightmap: &mut Lightmap,
    shown: &ShownSamples,
    samples: &Samples,
    progress: &Progress,
) -> Result<(), Cancelled> {
    let regions = regions(shown, samples, lightmap);
    let texels = lightmap.pages.iter().map(|p| p.charts.len() as u64).sum();
    progress.begin("denoise", texels);
    for (page, regions) in lightmap.pages.iter_mut().zip(&regions) {
        let filter = PageFilter { page, regions };
        let width = page.size[0] as usize;
        let rows: Result<Vec<Vec<FilteredTexel>>, Cancelled> = (0..page.size[1] as usize)
            .into_par_iter()
            .map(|row| {
                progress.advance(width as u64)?;
                Ok((row * width..(row + 1) * width)
                    .map(|t| filter.texel(t))
                    .collect())
            })
            .collect();
        let filtered = rows?.concat();
        page.irradiance = filtered.iter().map(|texel| texel.0).collect();
        page.standard_error = filtered.iter().map(|texel| texel.1).collect();
    }
    Ok(())
}

/// Irradiance and its standard error.
type FilteredTexel = ([f32; 3], [f32; 3]);

/// The texels of a page before they are filtered.
struct PageFilter<'p> {
    page: &'p LightmapPage,
    regions: &'p [u32],
}

impl PageFilter<'_> {
    /// Texels at most so far from one, with their steps to it.
    fn around(&self, texel: usize, reach: i32) -> impl Iterator<Item = (usize, [i32; 2])> {
        let [width, height] = self.page.size.map(|n| n as i32);
        let (column, row) = (texel as i32 % width, texel as i32 / width);
        let steps = (-reach..=reach).flat_map(move |y| (-reach..=reach).map(move |x| [x, y]));
        steps.filter_map(move |[x, y]| {
            let (column, row) = (column + x, row + y);
            let is_inside = (0..width).contains(&column) && (0..height).contains(&row);
            is_inside.then_some(((row * width + column) as usize, [x, y]))
        })
    }

    /// The texel at a step from another, if it is of the same region.
    fn beside(&self, texel: usize, [x, y]: [i32; 2], region: u32) -> Option<usize> {
        let [width, height] = self.page.size.map(|n| n as i32);
        let (column, row) = (texel as i32 % width + x, texel as i32 / width + y);
        let is_inside = (0..width).contains(&column) && (0..height).contains(&row);
        let beside = (row * width + column) as usize;
        (is_inside && self.regions[beside] == region).then_some(beside)
    }

    /// What a texel becomes.
    fn texel(&self, texel: usize) -> FilteredTexel {
        let (own, error) = (self.page.irradiance[texel], self.page.standard_error[texel]);
        let region = self.regions[texel];
        if region == NO_REGION || error == [0.0; 3] {
            return (own, error);
        }
        let (mut sum, mut weights, mut variance) = ([0.0; 3], 0.0, [0.0; 3]);
        for (other, step) in self.around(texel, REACH) {
            if self.regions[other] != region {
                continue;
            }
            let weight = if step == [0, 0] {
                1.0
            } else {
                (-self.distance(texel, other, region).max(0.0)).exp()
            };
            weights += weight;
            for k in 0..3 {
                sum[k] += weight * f64::from(self.page.irradiance[other][k]);
                variance[k] += (weight * f64::from(self.page.standard_error[other][k])).powi(2);
            }
        }
        let value = sum.map(|s| (s / weights) as f32);
        // What is blurred shows in how far the mean is from the value beyond its noise.
        let left = [0, 1, 2].map(|k| {
            let noise = variance[k] / (weights * weights);
            let moved = f64::from(value[k] - own[k]).powi(2) - f64::from(error[k]).powi(2);
            (noise + moved.max(0.0)).sqrt().min(f64::from(error[k])) as f32
        });
        (value, left)
    }

    /// Mean square difference of the surroundings of two texels beyond that of their noise, over that noise.
    fn distance(&self, a: usize, b: usize, region: u32) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for y in -PATCH..=PATCH {
            for x in -PATCH..=PATCH {
                let pair = self
                    .beside(a, [x, y], region)
                    .zip(self.beside(b, [x, y], region));
                let Some((a, b)) = pair else { continue };
                for k in 0..3 {
                    let value = |t: usize| f64::from(self.page.irradiance[t][k]);
                    let variance = |t: usize| f64::from(self.page.standard_error[t][k]).powi(2);
                    let both = variance(a) + variance(b).min(variance(a));
                    let difference = (value(a) - value(b)).powi(2) - both;
                    let scale = SENSITIVITY.powi(2) * (variance(a) + variance(b));
                    sum += difference
                        / (scale + LEAST_VARIANCE * value(a).powi(2)).max(f64::MIN_POSITIVE);
                    count += 1.0;
                }
            }
        }
        sum / f64::max(count, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_trace::sampling::uniform;

    /// A page of two regions side by side, of light 1 and 4, with so much noise.
    fn noisy(noise: f32) -> (LightmapPage, Vec<u32>) {
        let mut page = LightmapPage::dark([32, 16]);
        let mut regions = Vec::new();
        for t in 0..page.charts.len() {
            let region = u32::from(t % 32 >= 16);
            // The sum of four has nearly the normal distribution.
            let sum: f32 = (0..4).map(|k| uniform(&[t as u32, k]) - 0.5).sum();
            page.irradiance[t] = [[1.0, 4.0][region as usize] + noise * sum * 3f32.sqrt(); 3];
            page.standard_error[t] = [noise; 3];
            page.charts[t] = 0;
            regions.push(region);
        }
        (page, regions)
    }

    fn filtered(page: &LightmapPage, regions: &[u32]) -> Vec<FilteredTexel> {
        let filter = PageFilter { page, regions };
        (0..regions.len()).map(|t| filter.texel(t)).collect()
    }

    #[test]
    fn noise_goes_and_seams_stay() {
        let (page, regions) = noisy(0.2);
        let rms = |values: &mut dyn Iterator<Item = (usize, f32)>| {
            let square = |(t, v): (usize, f32)| (v - [1.0, 4.0][regions[t] as usize]).powi(2);
            (values.map(square).sum::<f32>() / regions.len() as f32).sqrt()
        };
        let before = rms(&mut page.irradiance.iter().map(|v| v[0]).enumerate());
        let texels = filtered(&page, &regions);
        let after = rms(&mut texels.iter().map(|v| v.0[0]).enumerate());
        assert!(before > 0.17 && after < 0.35 * before, "{before} {after}");
        // What is stated to be left is that, within a factor of two.
        let stated: f32 = texels.iter().map(|v| v.1[0].powi(2)).sum::<f32>();
        let stated = (stated / regions.len() as f32).sqrt();
        assert!(
            stated > 0.5 * after && stated < 2.5 * after,
            "{after} {stated}"
        );
    }

    #[test]
    fn texels_without_noise_and_without_region_stay() {
        let (page, regions) = noisy(0.0);
        let texels = filtered(&page, &regions);
        assert!(texels.iter().zip(&page.irradiance).all(|(t, v)| t.0 == *v));
        let (page, _) = noisy(0.5);
        let texels = filtered(&page, &vec![NO_REGION; page.charts.len()]);
        assert!(texels.iter().zip(&page.irradiance).all(|(t, v)| t.0 == *v));
    }
}
