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
const REACH: i32 = 4;

/// Texels to each side that are compared.
const PATCH: i32 = 1;

/// How many times the noise of both two texels may differ before they count less: the paper's k.
const SENSITIVITY: f64 = 1.0;

/// Square of the error of a number in single precision, relative to it: texels without noise differ by so much.
const LEAST_VARIANCE: f64 = 1e-12;

/// Mean of min(z², 1) of a number z with the standard normal distribution.
const CUT_MEAN: f64 = 0.516;

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
        let filter = PageFilter::new(page, regions);
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
        let errors: Vec<[f32; 3]> = (0..filtered.len())
            .into_par_iter()
            .map(|texel| filter.error_left(texel, &filtered))
            .collect();
        page.irradiance = filtered.iter().map(|texel| texel.irradiance).collect();
        page.standard_error = errors;
    }
    Ok(())
}

/// What a texel becomes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FilteredTexel {
    irradiance: [f32; 3],
    /// Variance of the noise that is left.
    variance: [f64; 3],
    /// Square of what was changed, beyond the noise that this takes away: what is blurred, on average.
    blurred: [f64; 3],
}

/// The texels of a page before they are filtered.
struct PageFilter<'p> {
    page: &'p LightmapPage,
    regions: &'p [u32],
    /// Part of the stated variance that is noise from texel to texel: the rest is what neighbours have in common, such as
    /// what patches are off by.
    noise_share: f64,
}

impl<'p> PageFilter<'p> {
    fn new(page: &'p LightmapPage, regions: &'p [u32]) -> PageFilter<'p> {
        let mut filter = PageFilter {
            page,
            regions,
            noise_share: 1.0,
        };
        // Neighbours differ by the noise of both, or by light, which is not counted beyond that noise.
        let (mut found, mut stated) = (0.0, 0.0);
        for texel in (0..regions.len()).filter(|&t| regions[t] != NO_REGION) {
            let Some(beside) = filter.beside(texel, [1, 0], regions[texel]) else {
                continue;
            };
            for k in 0..3 {
                let both = filter.variance(texel, k) + filter.variance(beside, k);
                found += (filter.value(texel, k) - filter.value(beside, k))
                    .powi(2)
                    .min(both);
                stated += both;
            }
        }
        if stated > 0.0 {
            filter.noise_share = (found / (CUT_MEAN * stated)).min(1.0);
        }
        filter
    }

    fn value(&self, texel: usize, channel: usize) -> f64 {
        self.page.irradiance[texel][channel].into()
    }

    /// The variance of noise.
    fn variance(&self, texel: usize, channel: usize) -> f64 {
        self.noise_share * f64::from(self.page.standard_error[texel][channel]).powi(2)
    }

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

    /// Whether a texel is filtered.
    fn is_noisy(&self, texel: usize) -> bool {
        self.regions[texel] != NO_REGION && self.page.standard_error[texel] != [0.0; 3]
    }

    /// What a texel becomes.
    fn texel(&self, texel: usize) -> FilteredTexel {
        let own = self.page.irradiance[texel];
        if !self.is_noisy(texel) {
            return FilteredTexel {
                irradiance: own,
                variance: [0.0; 3],
                blurred: [0.0; 3],
            };
        }
        let region = self.regions[texel];
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
                sum[k] += weight * self.value(other, k);
                variance[k] += weight * weight * self.variance(other, k);
            }
        }
        let irradiance = sum.map(|s| (s / weights) as f32);
        let variance = variance.map(|v| v / (weights * weights));
        // Of the noise of a texel its weight stays, and that of the others comes in.
        let blurred = [0, 1, 2].map(|k| {
            let changed = (f64::from(irradiance[k]) - self.value(texel, k)).powi(2);
            changed - self.variance(texel, k) * (1.0 - 2.0 / weights) - variance[k]
        });
        FilteredTexel {
            irradiance,
            variance,
            blurred,
        }
    }

    /// The standard error that is left: noise, what texels have in common, and what is blurred around.
    fn error_left(&self, texel: usize, filtered: &[FilteredTexel]) -> [f32; 3] {
        let stated = self.page.standard_error[texel];
        if !self.is_noisy(texel) {
            return stated;
        }
        let of_region = self
            .around(texel, REACH)
            .filter(|(other, _)| self.regions[*other] == self.regions[texel]);
        let (mut blurred, mut count) = ([0.0; 3], 0.0);
        for (other, _) in of_region {
            count += 1.0;
            (0..3).for_each(|k| blurred[k] += filtered[other].blurred[k]);
        }
        [0, 1, 2].map(|k| {
            let all = f64::from(stated[k]).powi(2);
            let shared = (1.0 - self.noise_share) * all;
            let left = filtered[texel].variance[k] + shared + (blurred[k] / count).max(0.0);
            left.min(all).sqrt() as f32
        })
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
                    let value = |t: usize| self.value(t, k);
                    let [of_a, of_b] = [a, b].map(|t| self.variance(t, k));
                    let difference = (value(a) - value(b)).powi(2) - of_a - of_b.min(of_a);
                    let scale = SENSITIVITY.powi(2) * (of_a + of_b);
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

    fn filtered(page: &LightmapPage, regions: &[u32]) -> Vec<([f32; 3], [f32; 3])> {
        let filter = PageFilter::new(page, regions);
        let texels: Vec<FilteredTexel> = (0..regions.len()).map(|t| filter.texel(t)).collect();
        let error = |t| filter.error_left(t, &texels);
        (0..regions.len())
            .map(|t| (texels[t].irradiance, error(t)))
            .collect()
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
        assert!(before > 0.17 && after < 0.4 * before, "{before} {after}");
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
