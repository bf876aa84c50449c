//! What texels are too coarse for: the error of light that is interpolated between them.
//!
//! A texel has the mean light of what it covers, and its standard error is that of the mean. What viewers
//! show between texels differs from the light there, at the edges of shadows by far more than that. Here
//! direct light is gathered at places between, and compared with what is interpolated, wherever it is uneven.
//! Indirect light is smoother, and costs more: it is gathered at a few places of texels that are alike, by how
//! uneven it is there and whether they lie at the rim of a chart.

use crate::atlas::Atlas;
use crate::lightmap::{Lightmap, ShownSample, ShownSamples};
use crate::lightmap_page::{LightmapPage, neighbours};
use crate::pad::pad_charts;
use crate::samples::{PageSampler, Samples};
use azulejo_radiosity::sites::{SiteDirect, SiteLight};
use azulejo_scene::Rgb;
use azulejo_trace::run::batches::{BLOCK, in_counted_batches};
use azulejo_trace::sampling::{hash, uniform};
use azulejo_trace::{Cancelled, GatherPoint, Gathered, Gatherer, Run};
use glam::DVec2;
use rayon::prelude::*;

/// Places along each axis of a texel where light is uneven.
const PLACES: u32 = 2;

/// Of the texels where it is even, one of this many is looked at, in one place.
const EVEN: u32 = 16;

/// For a first estimate, one of this many texels where light is uneven is looked at.
const FEW: u32 = 8;

/// The same where there is a deadline.
const FEWER: u32 = 64;

/// Difference to a neighbour, as a multiple of the permitted error, above which light is uneven.
const UNEVEN: f64 = 1.0;

/// Part of the variance of texels that is left between them: the mean of the squared weights.
const LEFT: f64 = 4.0 / 9.0;

/// Texels that are worked on together.
const BATCH: usize = 64;

/// Classes of texels by how uneven indirect light is there, of those at the rims of charts and of the others.
const CLASSES: usize = 12;

/// Texels of each class at which indirect light is gathered.
const OF_CLASS: usize = 128;

/// Compares a lightmap with direct light between its texels.
pub struct BetweenTexels<'a> {
    /// The surfaces.
    pub atlas: &'a Atlas,
    /// The points that the lightmap was made from.
    pub samples: &'a Samples,
    /// Those of them that it shows.
    pub shown: &'a ShownSamples,
    /// Direct light of all samples.
    pub direct: &'a SiteDirect,
    /// All their light but that.
    pub rest: &'a [SiteLight],
    /// Where direct light comes from.
    pub gatherer: &'a Gatherer<'a>,
    /// The permitted error, relative to the mean.
    pub error: f64,
    /// Keys the choice of places.
    pub seed: u32,
}

/// Finds the light of points.
pub type PointGather<'g, E> = dyn FnMut(&[GatherPoint]) -> Result<Vec<Gathered>, E> + 'g;

/// Mean square of the differences at places of a texel, of each channel, W²/m⁴.
type Squares = [f64; 3];

impl BetweenTexels<'_> {
    /// Adds what interpolation misses of direct light to the standard errors of a lightmap. `rest` is
    /// [`BetweenTexels::rest_of`] it. Returns its root mean square over the area and the channels, W/m². Once the
    /// deadline of the progress has passed, some of the uneven texels stand for all.
    ///
    /// # Errors
    /// The caller cancelled.
    pub fn add_direct(
        &self,
        lightmap: &mut Lightmap,
        rest: &Lightmap,
        run: Run,
    ) -> Result<f64, Cancelled> {
        let is_short = run.progress.out_of_time();
        let one_of = if is_short { FEWER } else { 1 };
        let looked_at: Vec<(&ShownSample, bool)> = self
            .by_evenness(lightmap, rest)
            .filter(|(shown, is_uneven)| {
                self.is_one_of(if *is_uneven { one_of } else { EVEN }, shown)
            })
            .collect();
        let all_squares = self.all_squares(&looked_at, lightmap, rest, run)?;
        let area = |shown: &ShownSample| {
            f64::from(lightmap.pages[shown.page as usize].areas[shown.at as usize])
        };
        let (mut of_even, mut even_area) = ([0.0; 3], 0.0);
        for ((shown, is_uneven), squares) in looked_at.iter().zip(&all_squares) {
            if let (false, Some(squares)) = (is_uneven, squares) {
                even_area += area(shown);
                (0..3).for_each(|k| of_even[k] += area(shown) * squares[k]);
            }
        }
        let of_even =
            of_even.map(|sum| f64::max(sum / f64::max(even_area, f64::MIN_POSITIVE), 0.0));
        let mut of_texel: Vec<Vec<[f32; 3]>> = (lightmap.pages.iter())
            .map(|page| vec![of_even.map(|square| square as f32); page.areas.len()])
            .collect();
        let of_uneven: Vec<(&ShownSample, Squares)> = looked_at
            .iter()
            .zip(&all_squares)
            .filter(|((_, is_uneven), _)| *is_uneven)
            .filter_map(|((shown, _), squares)| Some((*shown, (*squares)?)))
            .collect();
        // Few places are noisy, and what is taken for noise may be more than there is: the sum is right.
        let share = [0, 1, 2].map(|k| {
            let of = |square: fn(f64) -> f64| -> f64 {
                let each = of_uneven
                    .iter()
                    .map(|(shown, s)| area(shown) * square(s[k]));
                each.sum()
            };
            let (sum, positive) = (of(|s| s), of(|s| s.max(0.0)));
            f64::max(sum, 0.0) / f64::max(positive, f64::MIN_POSITIVE)
        });
        let square = |squares: &Squares| [0, 1, 2].map(|k| share[k] * squares[k].max(0.0));
        if is_short {
            let (mut sums, mut areas) = ([0.0; 3], 0.0);
            for (shown, squares) in &of_uneven {
                areas += area(shown);
                let squares = square(squares);
                (0..3).for_each(|k| sums[k] += area(shown) * squares[k]);
            }
            let mean = sums.map(|sum| (sum / f64::max(areas, f64::MIN_POSITIVE)) as f32);
            for (shown, _) in self
                .by_evenness(lightmap, rest)
                .filter(|(_, uneven)| *uneven)
            {
                of_texel[shown.page as usize][shown.at as usize] = mean;
            }
        }
        for (shown, squares) in &of_uneven {
            of_texel[shown.page as usize][shown.at as usize] = square(squares).map(|s| s as f32);
        }
        let (mut sum, mut whole) = (0.0, 0.0);
        for (page, squares) in lightmap.pages.iter_mut().zip(&of_texel) {
            for (t, squares) in squares
                .iter()
                .enumerate()
                .filter(|(t, _)| page.areas[*t] > 0.0)
            {
                let area = f64::from(page.areas[t]);
                sum += area * squares.iter().copied().map(f64::from).sum::<f64>() / 3.0;
                whole += area;
                for (error, square) in page.standard_error[t].iter_mut().zip(squares) {
                    *error = error.hypot(square.sqrt());
                }
            }
        }
        Ok((sum / f64::max(whole, f64::MIN_POSITIVE)).sqrt())
    }

    /// The same root mean square from some of the texels, where there is no other light yet: where direct light
    /// is even, nothing is missed.
    ///
    /// # Errors
    /// The caller cancelled.
    pub fn estimate(&self, lightmap: &Lightmap, run: Run) -> Result<f64, Cancelled> {
        let rest = self.shown.lightmap(self.samples, self.rest);
        let one_of = if run.progress.has_deadline() {
            FEWER
        } else {
            FEW
        };
        let looked_at: Vec<(&ShownSample, bool)> = self
            .by_evenness(lightmap, &rest)
            .filter(|(shown, is_uneven)| *is_uneven && self.is_one_of(one_of, shown))
            .collect();
        let all_squares = self.all_squares(&looked_at, lightmap, &rest, run)?;
        let area = |shown: &ShownSample| {
            f64::from(lightmap.pages[shown.page as usize].areas[shown.at as usize])
        };
        let mean = |squares: Squares| squares.iter().sum::<f64>() / 3.0;
        let of_each = looked_at.iter().zip(all_squares);
        let sum: f64 = of_each
            .map(|((shown, _), squares)| area(shown) * squares.map_or(0.0, mean))
            .sum();
        let all: f64 = self.shown.seen().map(area).sum();
        let square = f64::from(one_of) * sum / f64::max(all, f64::MIN_POSITIVE);
        Ok(square.max(0.0).sqrt())
    }

    /// The texels that are seen, and whether direct light is uneven there.
    fn by_evenness<'m>(
        &'m self,
        lightmap: &'m Lightmap,
        rest: &'m Lightmap,
    ) -> impl Iterator<Item = (&'m ShownSample, bool)> {
        let permitted = UNEVEN * self.error * lightmap.mean().mean();
        (self.shown.seen())
            .map(move |shown| (shown, self.is_uneven(shown, lightmap, rest, permitted)))
    }

    fn all_squares(
        &self,
        looked_at: &[(&ShownSample, bool)],
        lightmap: &Lightmap,
        rest: &Lightmap,
        run: Run,
    ) -> Result<Vec<Option<Squares>>, Cancelled> {
        run.progress.begin("between texels", looked_at.len() as u64);
        let all_squares = in_counted_batches(looked_at, (BATCH, BLOCK), run, |batch| {
            let squares = |&(shown, is_uneven): &(&ShownSample, bool)| {
                self.squares(shown, is_uneven, lightmap, rest)
            };
            Ok(batch.iter().map(squares).collect())
        })?;
        let seen = |(places, squares): (u32, Squares)| (places > 0).then_some(squares);
        Ok(all_squares.into_iter().map(seen).collect())
    }

    /// Whether a texel is one of those that are chosen, one of this many.
    fn is_one_of(&self, many: u32, shown: &ShownSample) -> bool {
        hash(&[self.seed, shown.page, shown.at, 0xe7e]).is_multiple_of(many)
    }

    /// Whether direct light differs between a texel and one around it.
    fn is_uneven(
        &self,
        shown: &ShownSample,
        lightmap: &Lightmap,
        rest: &Lightmap,
        permitted: f64,
    ) -> bool {
        let (page, rest) = (
            &lightmap.pages[shown.page as usize],
            &rest.pages[shown.page as usize],
        );
        let direct = |t: usize| light(&page.irradiance[t]) - light(&rest.irradiance[t]);
        let own = direct(shown.at as usize);
        neighbours(page.size, shown.at)
            .filter(|&(_, n)| page.charts[n] == page.charts[shown.at as usize])
            .any(|(_, n)| (direct(n) - own).map(f64::abs).max_channel() > permitted)
    }

    /// The number of places of a texel that are seen, and the mean square of what interpolation misses there, less
    /// noise.
    fn squares(
        &self,
        shown: &ShownSample,
        is_uneven: bool,
        lightmap: &Lightmap,
        rest: &Lightmap,
    ) -> (u32, Squares) {
        let (points, uvs) = self.places(shown, if is_uneven { PLACES } else { 1 });
        if points.is_empty() {
            return (0, [0.0; 3]);
        }
        let noise = self.direct.variance[shown.sample as usize].map(|v| LEFT * f64::from(v));
        let mut squares = [0.0; 3];
        for (gathered, uv) in self.gatherer.direct(&points, 1, self.seed).iter().zip(&uvs) {
            let direct = gathered.whole();
            let interpolated = |map: &Lightmap| -> Rgb {
                LightmapPage::bilinear(&map.pages[shown.page as usize], *uv)
            };
            let difference = interpolated(lightmap) - interpolated(rest) - direct.mean();
            let [d, variance] = [difference, direct.variance()].map(Rgb::to_array);
            for k in 0..3 {
                squares[k] += d[k] * d[k] - variance[k] - noise[k];
            }
        }
        let places = points.len() as u32;
        (places, squares.map(|s| s / f64::from(places)))
    }

    /// Places of a texel that are seen, one in each of `places`² parts of it, with their texture coordinates.
    fn places(&self, shown: &ShownSample, places: u32) -> (Vec<GatherPoint>, Vec<[f64; 2]>) {
        let sample = &self.samples.samples[shown.sample as usize];
        let coverage = &self.samples.pages[shown.page as usize];
        let tracer = self.gatherer.surfaces().tracer;
        let sampler = PageSampler::new(self.atlas, tracer, coverage, shown.page);
        let [width, height] = coverage.size;
        let corner = DVec2::new((shown.at % width).into(), (shown.at / width).into());
        let (mut points, mut uvs) = (Vec::new(), Vec::new());
        for k in 0..places * places {
            let keys = |d: u32| [self.seed, shown.page, shown.at, k, d, 0xbe7];
            let jitter = DVec2::new(uniform(&keys(0)).into(), uniform(&keys(1)).into());
            let cell = DVec2::new((k % places).into(), (k / places).into());
            let place = corner + (cell + jitter) / f64::from(places);
            if let Some((position, normal)) = sampler.seen_place(sample, place) {
                points.push(GatherPoint {
                    position,
                    normal,
                    key: hash(&keys(2)),
                });
                uvs.push([place.x / f64::from(width), place.y / f64::from(height)]);
            }
        }
        (points, uvs)
    }

    /// All light but direct light, as viewers read it, of charts with padding of `padding` texels.
    pub fn rest_of(&self, padding: u32) -> Lightmap {
        let mut rest = self.shown.lightmap(self.samples, self.rest);
        for page in &mut rest.pages {
            pad_charts(page, padding);
        }
        rest
    }

    /// Adds what interpolation misses of all other light to the standard errors of a lightmap, where that is more
    /// than they say: `gather` finds such light at a few places. `rest` is [`BetweenTexels::rest_of`] it. Returns
    /// the root mean square of what is added, over the area and the channels, W/m².
    ///
    /// # Errors
    /// Those of `gather`.
    pub fn add_indirect<E>(
        &self,
        lightmap: &mut Lightmap,
        rest: &Lightmap,
        gather: &mut PointGather<E>,
    ) -> Result<f64, E> {
        let classes = self.classes(rest);
        let (mut points, mut uvs, mut owners) = (Vec::new(), Vec::new(), Vec::new());
        // Look at one place in each of a few texels of every class, chosen by keys.
        for (class, members) in classes.iter().enumerate() {
            let mut order: Vec<&ShownSample> = members.clone();
            order.sort_by_cached_key(|shown| hash(&[self.seed, shown.page, shown.at, 0x1d7]));
            let seen = order.into_iter().filter_map(|shown| {
                let (points, uvs) = self.places(shown, PLACES);
                Some((*points.first()?, *uvs.first()?, shown))
            });
            for (point, uv, shown) in seen.take(OF_CLASS) {
                points.push(point);
                uvs.push(uv);
                owners.push((class, shown));
            }
        }
        let gathered = gather(&points)?;
        // Average the squared differences to what viewers interpolate, less noise and stated errors.
        let mut squares = vec![([0.0; 3], 0.0); classes.len()];
        for ((indirect, uv), (class, shown)) in gathered.iter().zip(uvs).zip(owners) {
            let page = &rest.pages[shown.page as usize];
            let area = f64::from(page.areas[shown.at as usize]);
            let error = light(&page.standard_error[shown.at as usize]).to_array();
            let difference = (page.bilinear(uv) - indirect.mean()).to_array();
            let variance = indirect.variance().to_array();
            let (sums, areas) = &mut squares[class];
            *areas += area;
            for k in 0..3 {
                sums[k] += area * (difference[k].powi(2) - variance[k] - error[k].powi(2));
            }
        }
        // All texels of a class get its mean, because single differences say little.
        let (mut sum, mut whole) = (0.0, 0.0);
        for (members, (sums, areas)) in classes.iter().zip(squares) {
            let missed = sums.map(|s| f64::max(s, 0.0) / f64::max(areas, f64::MIN_POSITIVE));
            for shown in members {
                let page = &mut lightmap.pages[shown.page as usize];
                let area = f64::from(page.areas[shown.at as usize]);
                sum += area * missed.iter().sum::<f64>() / 3.0;
                whole += area;
                let errors = &mut page.standard_error[shown.at as usize];
                for (error, square) in errors.iter_mut().zip(missed) {
                    *error = f64::from(*error).hypot(square.sqrt()) as f32;
                }
            }
        }
        Ok((sum / f64::max(whole, f64::MIN_POSITIVE)).sqrt())
    }

    /// Texels by whether they lie at the rim of a chart, and by how much the light of those around differs.
    fn classes(&self, rest: &Lightmap) -> Vec<Vec<&ShownSample>> {
        let mut of_kinds: [Vec<(f32, &ShownSample)>; 2] = Default::default();
        for shown in self.shown.seen() {
            let page = &rest.pages[shown.page as usize];
            let at = shown.at as usize;
            let own = light(&page.irradiance[at]);
            let (mut unevenness, mut is_rim) = (0.0, false);
            for (_, n) in neighbours(page.size, shown.at) {
                let is_one = page.charts[n] == page.charts[at];
                is_rim |= !is_one || page.areas[n] == 0.0;
                if is_one {
                    let difference = light(&page.irradiance[n]) - own;
                    unevenness = f64::max(unevenness, difference.map(f64::abs).max_channel());
                }
            }
            of_kinds[usize::from(is_rim)].push((unevenness as f32, shown));
        }
        let mut classes = Vec::new();
        for kind in &mut of_kinds {
            kind.par_sort_by(|a, b| a.0.total_cmp(&b.0));
            let size = kind.len().div_ceil(CLASSES).max(1);
            let of_class = |class: &[(f32, _)]| class.iter().map(|member| member.1).collect();
            classes.extend(kind.chunks(size).map(of_class));
        }
        classes
    }
}

fn light(texel: &[f32; 3]) -> Rgb {
    Rgb::from(texel.map(f64::from))
}
