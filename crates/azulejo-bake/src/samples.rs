//! The points at which a lightmap needs light: one for each texel, on what it covers.
//!
//! A texel may cover a surface on both sides of a wall that stands on it. So the points of neighbouring
//! texels are joined where nothing is between them, to *regions* of the surface; a texel between two
//! regions has a point in each, and only one of them counts in the end ([`Lightmap`](crate::Lightmap)).

use crate::Receiver;
use crate::atlas::Atlas;
use crate::coverage::{Coverage, TexelPoint, TriangleId};
use crate::layout::signed_area;
use crate::solids::Groups;
use azulejo_scene::math::Ray;
use azulejo_trace::run::batches::{SHORT_BLOCK, in_blocks, in_counted_batches};
use azulejo_trace::run::{Record, RecordReader};
use azulejo_trace::sampling::hash;
use azulejo_trace::{Cancelled, GatherPoint, Run, Tracer};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::collections::HashMap;

/// How far above the surface points are joined, as a share of the width of a texel: the chord between two
/// texels of a surface that bends by 30° lies 0.13 of it below.
const LIFT: f64 = 0.25;

/// How far points keep from the borders of triangles, texels.
const INSET: f64 = 0.01;

/// Points along each axis of a texel that is between regions.
const FINE: u32 = 4;

/// Texels that are worked on together.
const BATCH: usize = 1024;

/// A point of a texel at which light is needed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexelSample {
    /// Page of the texel.
    pub page: u32,
    /// Its place among the covered texels of the page.
    pub texel: u32,
    /// The triangle.
    pub of: TriangleId,
    /// Weights of the triangle's corners 1 and 2.
    pub uv: [f32; 2],
    /// World position, moved off coarse smooth surfaces.
    pub position: DVec3,
    /// Unit normal of the side that receives.
    pub normal: DVec3,
    /// What the sample stands for, square scene units.
    pub area: f32,
    /// The share of the texel's places that is free to be seen from its region, nothing standing on
    /// them.
    pub free: f32,
    /// The part of the surface that it belongs to, of those that can see one another.
    pub region: u32,
}

/// The points of all texels of a lightmap.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    /// The covered texels of each page.
    pub pages: Vec<Coverage>,
    /// In the order of pages and texels; a texel between two regions has two.
    pub samples: Vec<TexelSample>,
    /// Number of regions; samples without one have numbers of their own from here on.
    pub regions: u32,
}

impl Samples {
    /// Chooses the points.
    ///
    /// # Errors
    /// The caller cancelled.
    pub fn new(atlas: &Atlas, tracer: &Tracer, run: Run) -> Result<Samples, Cancelled> {
        let mut all = Samples::default();
        for page in 0..atlas.layout.pages.len() as u32 {
            let coverage = Coverage::new(&atlas.receivers, &atlas.layout, page, run.progress)?;
            let sampler = PageSampler::new(atlas, tracer, &coverage, page);
            let (samples, regions) = sampler.samples(all.regions, run)?;
            all.regions += regions;
            all.samples.extend(samples);
            all.pages.push(coverage);
        }
        Ok(all)
    }
}

/// A point of a texel, and one above it from which others are looked at.
#[derive(Clone, Copy, Debug)]
struct SurfacePoint {
    of: TriangleId,
    uv: [f32; 2],
    position: DVec3,
    /// Shading normal of the side that receives.
    normal: DVec3,
    raised: DVec3,
}

impl Record for SurfacePoint {
    fn write(&self, bytes: &mut Vec<u8>) {
        [self.of.receiver, self.of.triangle].write(bytes);
        self.uv.write(bytes);
        let vectors = [self.position, self.normal, self.raised];
        vectors.map(|v| v.to_array()).write(bytes);
    }

    fn read(bytes: &mut RecordReader) -> Option<SurfacePoint> {
        let [receiver, triangle] = Record::read(bytes)?;
        let uv = Record::read(bytes)?;
        let vectors: [[f64; 3]; 3] = Record::read(bytes)?;
        let [position, normal, raised] = vectors.map(DVec3::from);
        Some(SurfacePoint {
            of: TriangleId { receiver, triangle },
            uv,
            position,
            normal,
            raised,
        })
    }
}

/// Chooses points of the texels of a page.
pub(crate) struct PageSampler<'a> {
    atlas: &'a Atlas,
    tracer: &'a Tracer,
    coverage: &'a Coverage,
    page: u32,
}

impl<'a> PageSampler<'a> {
    pub fn new(
        atlas: &'a Atlas,
        tracer: &'a Tracer,
        coverage: &'a Coverage,
        page: u32,
    ) -> PageSampler<'a> {
        PageSampler {
            atlas,
            tracer,
            coverage,
            page,
        }
    }

    /// World position and normal at a place of the page, if the texel covers something there and nothing stands
    /// between it and the sample.
    pub fn seen_place(&self, sample: &TexelSample, place: DVec2) -> Option<(DVec3, DVec3)> {
        let texel = sample.texel as usize;
        let at = self.coverage.point_at(&self.atlas.layout, texel, place)?;
        if sample.free == 1.0 {
            let point = self.on_surface(at, 0.0);
            return Some((point.position, point.normal));
        }
        let [u, v] = sample.uv.map(f64::from);
        let of_sample = TexelPoint {
            of: sample.of,
            weights: [1.0 - u - v, u, v],
        };
        let lift = LIFT / f64::from(FINE);
        let mut points = [at, of_sample].map(|point| self.on_surface(point, lift));
        self.lower_where_blocked(&mut points);
        let [point, seen] = points;
        let ray = Ray::between(point.raised, seen.raised);
        (!self.tracer.occluded(&ray)).then_some((point.position, point.normal))
    }

    /// The samples of the page, with regions numbered from `first`, and the number of regions.
    fn samples(&self, first: u32, run: Run) -> Result<(Vec<TexelSample>, u32), Cancelled> {
        let texels = self.coverage.texels.len();
        run.progress.begin("points", 2 * texels as u64);
        let points = self.points(run)?;
        let neighbours = self.neighbours();
        let is_free = self.joined(&points, &neighbours, run)?;
        let mut is_between = vec![false; texels];
        for (&(a, b), _) in neighbours.iter().zip(&is_free).filter(|(_, free)| !**free) {
            is_between[a as usize] = true;
            is_between[b as usize] = true;
        }
        // A texel that something stands in is of no region, so that it joins none that are apart.
        let mut apart = Groups::new(texels);
        for (&(a, b), &is_free) in neighbours.iter().zip(&is_free) {
            if is_free && !is_between[a as usize] && !is_between[b as usize] {
                apart.join(a, b);
            }
        }
        let mut numbers: HashMap<u32, u32> = HashMap::new();
        let mut region_of = vec![u32::MAX; texels];
        for texel in 0..texels {
            if !is_between[texel] {
                let next = first + numbers.len() as u32;
                region_of[texel] = *numbers.entry(apart.of(texel as u32)).or_insert(next);
            }
        }
        let mut regions = numbers.len() as u32;
        let rows = Rows::new(self.coverage);
        let of_texels: Vec<Vec<TexelSample>> = (0..texels)
            .into_par_iter()
            .map(|t| {
                if is_between[t] {
                    self.between(t, &points, &region_of, &rows)
                } else {
                    vec![self.sample(t, &points[t], region_of[t], [1.0; 2])]
                }
            })
            .collect();
        let mut samples: Vec<TexelSample> = of_texels.into_iter().flatten().collect();
        for sample in samples.iter_mut().filter(|s| s.region == u32::MAX) {
            sample.region = first + regions;
            regions += 1;
        }
        Ok((samples, regions))
    }

    /// A sample with its shares of the texel's area and of its places.
    fn sample(
        &self,
        texel: usize,
        point: &SurfacePoint,
        region: u32,
        [share, free]: [f32; 2],
    ) -> TexelSample {
        TexelSample {
            page: self.page,
            texel: texel as u32,
            of: point.of,
            uv: point.uv,
            position: point.position,
            normal: point.normal,
            area: share * self.coverage.texels[texel].area,
            free,
            region,
        }
    }

    /// The point of each texel nearest to the centre of what it covers.
    fn points(&self, run: Run) -> Result<Vec<SurfacePoint>, Cancelled> {
        let texels: Vec<u32> = (0..self.coverage.texels.len() as u32).collect();
        let point = |&texel: &u32| {
            let [x, y] = self.coverage.texels[texel as usize].centre.map(f64::from);
            self.surface_point(texel as usize, DVec2::new(x, y), LIFT)
        };
        in_counted_batches(&texels, (BATCH, SHORT_BLOCK), run, |batch| {
            let mut points: Vec<SurfacePoint> = batch.iter().map(point).collect();
            self.lower_where_blocked(&mut points);
            Ok(points)
        })
    }

    /// The point of a texel at a place of the page, and one `lift` texels above it.
    fn surface_point(&self, texel: usize, place: DVec2, lift: f64) -> SurfacePoint {
        self.on_surface(self.coverage.point(&self.atlas.layout, texel, place), lift)
    }

    fn on_surface(&self, TexelPoint { of, weights }: TexelPoint, lift: f64) -> SurfacePoint {
        let Atlas {
            receivers, layout, ..
        } = self.atlas;
        let receiver = &receivers[of.receiver as usize];
        let triangle = of.triangle as usize;
        let chart = layout.receivers[of.receiver as usize].charts[triangle];
        let side = if self.atlas.is_turned(chart) {
            -1.0
        } else {
            1.0
        };
        let corners = receiver.corners(triangle);
        let texels = layout.texels(of.receiver as usize, triangle);
        let weights = off_border(weights, texels);
        let on: DVec3 = corners.iter().zip(weights).map(|(&c, w)| w * c).sum();
        let vector = receiver.area_vector(triangle);
        let flat = side * vector.normalize_or(DVec3::Z);
        let in_texels = signed_area(texels).abs();
        let width = (vector.length() / in_texels.max(f64::MIN_POSITIVE)).sqrt();
        let raised = self.tracer.leaving(on, flat) + lift * width * flat;
        SurfacePoint {
            of,
            uv: [weights[1] as f32, weights[2] as f32],
            position: self.off_facets(receiver, triangle, weights, on, side),
            normal: side * receiver.shading_normal(triangle, weights),
            raised,
        }
    }

    /// A point of a facet moved outwards onto the smooth surface that its shading normals describe, so
    /// that neighbouring facets do not shade it; the point itself where that surface is not outside.
    ///
    /// Hanika, *Hacking the shadow terminator*, in Ray Tracing Gems II, 2021.
    fn off_facets(
        &self,
        receiver: &Receiver,
        triangle: usize,
        weights: [f64; 3],
        on: DVec3,
        side: f64,
    ) -> DVec3 {
        let Some(normals) = receiver.normals.get(triangle) else {
            return on;
        };
        let flat = side * receiver.area_vector(triangle).normalize_or(DVec3::Z);
        let corners = receiver.corners(triangle);
        let moved = |k: usize| {
            let normal = side * normals[k];
            // A normal that points into the other side of the facet would pull the point through it.
            let normal = if normal.dot(flat) > 0.0 { normal } else { flat };
            on - f64::min(0.0, (on - corners[k]).dot(normal)) * normal
        };
        let outside: DVec3 = (0..3).map(|k| weights[k] * moved(k)).sum();
        let height = (outside - on).dot(flat);
        if height <= 0.0 || !outside.is_finite() {
            return on;
        }
        let start = self.tracer.leaving(on, flat);
        if self
            .tracer
            .occluded(&Ray::between(start, self.tracer.leaving(outside, flat)))
        {
            on
        } else {
            outside
        }
    }

    /// Puts raised points back onto the surface where something is between.
    fn lower_where_blocked(&self, points: &mut [SurfacePoint]) {
        let low = |p: &SurfacePoint| {
            let up = (p.raised - p.position).normalize_or(p.normal);
            self.tracer.leaving(p.position, up)
        };
        let rays: Vec<_> = points
            .iter()
            .map(|p| self.tracer.kernel_ray(&Ray::between(low(p), p.raised)))
            .collect();
        let mut blocked = Vec::new();
        self.tracer.any(&rays, &mut blocked);
        for (point, _) in points.iter_mut().zip(blocked).filter(|(_, b)| *b) {
            point.raised = low(point);
        }
    }

    /// Pairs of texels of one chart, side by side or one above the other.
    fn neighbours(&self) -> Vec<(u32, u32)> {
        let rows = Rows::new(self.coverage);
        let texels = &self.coverage.texels;
        let mut pairs = Vec::with_capacity(2 * texels.len());
        for (t, texel) in texels.iter().enumerate() {
            let [column, row] = rows.place(texel.index);
            for next in [rows.at(column + 1, row), rows.at(column, row + 1)] {
                if let Some(n) = next.filter(|&n| texels[n as usize].chart == texel.chart) {
                    pairs.push((t as u32, n));
                }
            }
        }
        pairs
    }

    /// For each pair whether nothing is between their points.
    fn joined(
        &self,
        points: &[SurfacePoint],
        pairs: &[(u32, u32)],
        run: Run,
    ) -> Result<Vec<bool>, Cancelled> {
        let ray = |&(a, b): &(u32, u32)| {
            let [a, b] = [a, b].map(|t| points[t as usize].raised);
            self.tracer.kernel_ray(&Ray::between(a, b))
        };
        let flags = in_blocks(pairs, (BATCH, SHORT_BLOCK), run, |batch| {
            run.progress.advance((batch.len() / 2) as u64)?;
            let rays: Vec<_> = batch.iter().map(ray).collect();
            let mut blocked = Vec::new();
            self.tracer.any(&rays, &mut blocked);
            Ok(blocked.into_iter().map(|b| u8::from(!b)).collect())
        })?;
        Ok(flags.into_iter().map(|is_free| is_free == 1).collect())
    }

    /// The samples of a texel that something stands in: one in each of the two regions around it that
    /// most of its points see.
    fn between(
        &self,
        texel: usize,
        points: &[SurfacePoint],
        region_of: &[u32],
        rows: &Rows,
    ) -> Vec<TexelSample> {
        let covered = &self.coverage.texels[texel];
        let [column, row] = rows.place(covered.index);
        // Take the neighbours in the same chart that belong to a region.
        let around: Vec<u32> = rows
            .around(column, row)
            .filter(|&n| self.coverage.texels[n as usize].chart == covered.chart)
            .filter(|&n| region_of[n as usize] != u32::MAX)
            .collect();
        let corner = DVec2::new(column.into(), row.into());
        let centre = DVec2::from(covered.centre.map(f64::from));
        // Assign each of the finest parts of the texel to the region of the first neighbour that it sees.
        let mut regions: Vec<(u32, u32, f64, SurfacePoint)> = Vec::new();
        for k in 0..FINE * FINE {
            let step = DVec2::new((k % FINE).into(), (k / FINE).into());
            let place = corner + (step + 0.5) / f64::from(FINE);
            let mut point = [self.surface_point(texel, place, LIFT / f64::from(FINE))];
            self.lower_where_blocked(&mut point);
            let [point] = point;
            let sees = |n: &&u32| {
                let ray = Ray::between(point.raised, points[**n as usize].raised);
                !self.tracer.occluded(&ray)
            };
            let Some(&seen) = around.iter().find(sees) else {
                continue;
            };
            let (region, distance) = (region_of[seen as usize], place.distance(centre));
            // A region is sampled at the part nearest to the centre of what the texel covers.
            match regions.iter_mut().find(|f| f.0 == region) {
                Some(known) => {
                    known.1 += 1;
                    if distance < known.2 {
                        (known.2, known.3) = (distance, point);
                    }
                }
                None => regions.push((region, 1, distance, point)),
            }
        }
        // Keep the two largest regions, with their shares of the texel; without any, sample the texel as it is.
        regions.sort_by_key(|f| std::cmp::Reverse(f.1));
        regions.truncate(2);
        let all: u32 = regions.iter().map(|f| f.1).sum();
        if regions.is_empty() {
            return vec![self.sample(texel, &points[texel], u32::MAX, [1.0, 0.0])];
        }
        let of_region = |(region, count, _, point): &(u32, u32, f64, SurfacePoint)| {
            let shares = [all, FINE * FINE].map(|n| *count as f32 / n as f32);
            self.sample(texel, point, *region, shares)
        };
        regions.iter().map(of_region).collect()
    }
}

/// A point of a triangle, [`INSET`] texels inside where it lies on the border: a point in the very corner
/// of a room sees what is behind the wall.
fn off_border(weights: [f64; 3], corners: [DVec2; 3]) -> [f64; 3] {
    if weights.iter().all(|&w| w > INSET) {
        return weights;
    }
    let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
    let place: DVec2 = (0..3).map(|k| weights[k] * corners[k]).sum();
    let share = (INSET / f64::max(place.distance(middle), f64::MIN_POSITIVE)).min(0.5);
    weights.map(|w| w + share * (1.0 / 3.0 - w))
}

/// The number of a texel that covers nothing.
const EMPTY: u32 = u32::MAX;

/// The covered texels of a page by column and row.
pub(crate) struct Rows {
    size: [u32; 2],
    places: Vec<u32>,
}

impl Rows {
    pub fn new(coverage: &Coverage) -> Rows {
        let size = coverage.size;
        let mut places = vec![EMPTY; size[0] as usize * size[1] as usize];
        for (t, texel) in coverage.texels.iter().enumerate() {
            places[texel.index as usize] = t as u32;
        }
        Rows { size, places }
    }

    /// Column and row of a texel.
    pub fn place(&self, index: u32) -> [u32; 2] {
        [index % self.size[0], index / self.size[0]]
    }

    /// The covered texel there.
    pub fn at(&self, column: u32, row: u32) -> Option<u32> {
        if column >= self.size[0] || row >= self.size[1] {
            return None;
        }
        let texel = self.places[row as usize * self.size[0] as usize + column as usize];
        (texel != EMPTY).then_some(texel)
    }

    /// The covered ones of the eight texels around one.
    pub fn around(&self, column: u32, row: u32) -> impl Iterator<Item = u32> + '_ {
        let steps = [-1, 0, 1]
            .into_iter()
            .flat_map(|y| [-1, 0, 1].map(|x| (x, y)));
        steps
            .filter(|step| *step != (0, 0))
            .filter_map(move |(x, y)| {
                self.at(column.checked_add_signed(x)?, row.checked_add_signed(y)?)
            })
    }
}

/// A sample as a point of a gather, with the key of its random numbers.
pub(crate) fn gather_point(samples: &Samples, sample: usize) -> GatherPoint {
    let s = &samples.samples[sample];
    GatherPoint {
        position: s.position,
        normal: s.normal,
        key: hash(&[s.page, s.texel, sample as u32]),
    }
}

/// The points of all samples, and the areas for which they stand, square scene units.
pub fn sample_points(samples: &Samples) -> (Vec<GatherPoint>, Vec<f64>) {
    let all = samples.samples.iter().enumerate();
    all.map(|(s, sample)| (gather_point(samples, s), f64::from(sample.area)))
        .unzip()
}
