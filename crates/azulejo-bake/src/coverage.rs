//! Which part of which triangles each texel covers.
//!
//! Conservative: a texel takes part if its square meets a triangle, however little. The mean of light
//! over exactly what a texel covers keeps the energy of the surface.

use crate::Receiver;
use crate::layout::{Layout, NO_CHART, barycentric, signed_area};
use azulejo_trace::{Cancelled, Progress};
use glam::DVec2;
use rayon::prelude::*;

/// Rows of texels that are covered together.
const BAND: u32 = 16;

/// How far outside a triangle a point may lie for rounding alone, barycentric.
const ROUNDING: f64 = 1e-9;

/// Rounding of texture coordinates in single precision, as a share of the page.
pub(crate) const COORDINATE_ROUNDING: f64 = 1.0 / (1 << 23) as f64;

/// A triangle of a receiver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TriangleId {
    /// Which receiver.
    pub receiver: u32,
    /// Which of its triangles.
    pub triangle: u32,
}

/// The part of a triangle that a texel covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoveredPiece {
    /// The triangle.
    pub of: TriangleId,
    /// Area, square scene units.
    pub area: f32,
}

/// A texel that covers something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoveredTexel {
    /// Its number, row by row.
    pub index: u32,
    /// Its chart.
    pub chart: u32,
    /// Its first piece.
    first: u32,
    /// Sum of the areas of its pieces, square scene units.
    pub area: f32,
    /// The centre of its pieces by area, texels of the page.
    pub centre: [f32; 2],
}

/// The covered texels of a page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Coverage {
    /// Width and height of the page.
    pub size: [u32; 2],
    /// In the order of their indices.
    pub texels: Vec<CoveredTexel>,
    pieces: Vec<CoveredPiece>,
    /// Texels that charts share, which should be none: each counts for the chart with the most area.
    pub shared: u32,
}

impl Coverage {
    /// Covers one page of a layout.
    ///
    /// # Errors
    /// The caller cancelled.
    pub fn new(
        receivers: &[Receiver],
        layout: &Layout,
        page: u32,
        progress: &Progress,
    ) -> Result<Coverage, Cancelled> {
        let size = layout.pages[page as usize];
        let placed = placed_triangles(receivers, layout, page);
        let bands = size[1].div_ceil(BAND);
        let mut of_band: Vec<Vec<u32>> = vec![Vec::new(); bands as usize];
        for (number, triangle) in placed.iter().enumerate() {
            let (low, high) = triangle.rows(size[1]);
            for band in low / BAND..=high / BAND {
                of_band[band as usize].push(number as u32);
            }
        }
        progress.begin("texels", bands.into());
        let parts: Result<Vec<Coverage>, Cancelled> = of_band
            .par_iter()
            .zip(0..bands)
            .map(|(numbers, band)| {
                progress.advance(1)?;
                let triangles = numbers.iter().map(|&n| &placed[n as usize]);
                Ok(band_coverage(triangles, size, band))
            })
            .collect();
        let mut whole = Coverage {
            size,
            ..Coverage::default()
        };
        for part in parts? {
            let offset = whole.pieces.len() as u32;
            let moved = |t: &CoveredTexel| CoveredTexel {
                first: t.first + offset,
                ..*t
            };
            whole.texels.extend(part.texels.iter().map(moved));
            whole.pieces.extend(part.pieces);
            whole.shared += part.shared;
        }
        Ok(whole)
    }

    /// The pieces of a texel, by its place in `texels`.
    pub fn pieces(&self, texel: usize) -> &[CoveredPiece] {
        let end = self.texels.get(texel + 1);
        let end = end.map_or(self.pieces.len(), |next| next.first as usize);
        &self.pieces[self.texels[texel].first as usize..end]
    }
}

/// A triangle with a chart, in texels.
struct PlacedTriangle {
    id: TriangleId,
    chart: u32,
    corners: [DVec2; 3],
    /// Square scene units per square texel.
    area_per_texel: f64,
}

impl PlacedTriangle {
    /// The first and last row that it may touch.
    fn rows(&self, height: u32) -> (u32, u32) {
        range(self.corners.map(|c| c.y), height)
    }
}

/// The first and last of `count` unit intervals that values may touch.
fn range(values: [f64; 3], count: u32) -> (u32, u32) {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let last = f64::from(count - 1);
    (
        low.floor().clamp(0.0, last) as u32,
        high.floor().clamp(0.0, last) as u32,
    )
}

fn placed_triangles(receivers: &[Receiver], layout: &Layout, page: u32) -> Vec<PlacedTriangle> {
    let mut placed = Vec::new();
    for (r, receiver) in receivers.iter().enumerate() {
        let of_receiver = &layout.receivers[r];
        for triangle in 0..receiver.triangles.len() {
            let chart = of_receiver.charts[triangle];
            if of_receiver.pages[triangle] != page || chart == NO_CHART {
                continue;
            }
            let corners = layout.texels(r, triangle);
            let in_texels = signed_area(corners).abs();
            let area_per_texel = receiver.area_vector(triangle).length() / in_texels;
            if in_texels > 0.0 && area_per_texel.is_finite() {
                placed.push(PlacedTriangle {
                    id: TriangleId {
                        receiver: r as u32,
                        triangle: triangle as u32,
                    },
                    chart,
                    corners,
                    area_per_texel,
                });
            }
        }
    }
    placed
}

/// What one triangle covers of one texel.
struct Covered {
    index: u32,
    chart: u32,
    piece: CoveredPiece,
    /// Centre of the piece, texels.
    centre: DVec2,
}

/// The texels of one band of rows.
fn band_coverage<'a>(
    triangles: impl Iterator<Item = &'a PlacedTriangle>,
    size: [u32; 2],
    band: u32,
) -> Coverage {
    let mut covered = Vec::new();
    for triangle in triangles {
        cover(triangle, size, band, &mut covered);
    }
    covered.sort_by_key(|c| (c.index, c.piece.of));
    let mut coverage = Coverage {
        size,
        ..Coverage::default()
    };
    for of_texel in covered.chunk_by(|a, b| a.index == b.index) {
        coverage.add(of_texel);
    }
    coverage
}

impl Coverage {
    /// Adds a texel with all that covers it.
    fn add(&mut self, covered: &[Covered]) {
        let area_of = |chart: u32| -> f32 {
            let of_chart = covered.iter().filter(|c| c.chart == chart);
            of_chart.map(|c| c.piece.area).sum()
        };
        let most = |a: &&Covered, b: &&Covered| area_of(a.chart).total_cmp(&area_of(b.chart));
        let Some(chart) = covered.iter().max_by(most).map(|c| c.chart) else {
            return;
        };
        let own = || covered.iter().filter(|c| c.chart == chart);
        self.shared += u32::from(own().count() < covered.len());
        let area: f64 = own().map(|c| f64::from(c.piece.area)).sum();
        let moment: DVec2 = own().map(|c| c.centre * f64::from(c.piece.area)).sum();
        self.texels.push(CoveredTexel {
            index: covered[0].index,
            chart,
            first: self.pieces.len() as u32,
            area: area as f32,
            centre: (moment / area).as_vec2().to_array(),
        });
        self.pieces.extend(own().map(|c| c.piece));
    }
}

/// Adds what a triangle covers of the texels of a band.
fn cover(triangle: &PlacedTriangle, size: [u32; 2], band: u32, covered: &mut Vec<Covered>) {
    let (low, high) = triangle.rows(size[1]);
    let (low, high) = (low.max(band * BAND), high.min(band * BAND + BAND - 1));
    for row in low..=high {
        let strip = clipped(&triangle.corners, 1, f64::from(row));
        let (Some(first), Some(last)) = (
            strip.iter().map(|p| p.x).reduce(f64::min),
            strip.iter().map(|p| p.x).reduce(f64::max),
        ) else {
            continue;
        };
        let (first, last) = range([first, last, last], size[0]);
        for column in first..=last {
            let polygon = clipped(&strip, 0, f64::from(column));
            if is_rounding(&polygon, triangle, size) {
                continue;
            }
            let (area, centre) = area_and_centre(&polygon);
            let area = (area * triangle.area_per_texel) as f32;
            if area > 0.0 {
                covered.push(Covered {
                    index: row * size[0] + column,
                    chart: triangle.chart,
                    piece: CoveredPiece {
                        of: triangle.id,
                        area,
                    },
                    centre,
                });
            }
        }
    }
}

/// Whether a piece is so thin, beside its triangle, that it comes from rounding the coordinates of
/// corners that lie on the border of a texel.
fn is_rounding(piece: &[DVec2], triangle: &PlacedTriangle, size: [u32; 2]) -> bool {
    let extent = |corners: &[DVec2], axis: usize| {
        let along = corners.iter().map(|c| c[axis]);
        let high = along.clone().fold(f64::NEG_INFINITY, f64::max);
        high - along.fold(f64::INFINITY, f64::min)
    };
    [0, 1].into_iter().any(|axis| {
        let rounding = COORDINATE_ROUNDING * f64::from(size[axis]);
        extent(piece, axis) < rounding && extent(&triangle.corners, axis) > 2.0 * rounding
    })
}

/// A convex polygon between `low` and `low + 1` along an axis (Sutherland and Hodgman 1974).
fn clipped(polygon: &[DVec2], axis: usize, low: f64) -> Vec<DVec2> {
    let above = half(polygon, |p| p[axis] - low);
    half(&above, |p| low + 1.0 - p[axis])
}

/// The part of a convex polygon where `inside` is not negative.
pub(crate) fn half(polygon: &[DVec2], inside: impl Fn(DVec2) -> f64) -> Vec<DVec2> {
    let mut kept = Vec::with_capacity(polygon.len() + 2);
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let (of_a, of_b) = (inside(a), inside(b));
        if of_a >= 0.0 {
            kept.push(a);
        }
        if (of_a > 0.0 && of_b < 0.0) || (of_a < 0.0 && of_b > 0.0) {
            kept.push(a.lerp(b, of_a / (of_a - of_b)));
        }
    }
    kept
}

/// Area and centre of a convex polygon of either orientation.
pub(crate) fn area_and_centre(polygon: &[DVec2]) -> (f64, DVec2) {
    let Some((&a, rest)) = polygon.split_first() else {
        return (0.0, DVec2::ZERO);
    };
    let (mut area, mut moment) = (0.0, DVec2::ZERO);
    for pair in rest.windows(2) {
        let of_triangle = signed_area([a, pair[0], pair[1]]);
        area += of_triangle;
        moment += of_triangle * (a + pair[0] + pair[1]) / 3.0;
    }
    if area == 0.0 {
        return (0.0, a);
    }
    (area.abs(), moment / area)
}

/// A point of a texel: where on which triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TexelPoint {
    pub of: TriangleId,
    /// Barycentric coordinates.
    pub weights: [f64; 3],
}

impl Coverage {
    /// The point of a texel's pieces at a place of the page, if there is one.
    pub(crate) fn point_at(
        &self,
        layout: &Layout,
        texel: usize,
        place: DVec2,
    ) -> Option<TexelPoint> {
        self.pieces(texel).iter().find_map(|piece| {
            let of_receiver = &layout.receivers[piece.of.receiver as usize];
            let corners = of_receiver.texels(piece.of.triangle as usize, self.size);
            let weights = barycentric(corners, place)?;
            let is_inside = weights.iter().all(|&w| w >= -ROUNDING);
            is_inside.then(|| TexelPoint {
                of: piece.of,
                weights: normalized(weights),
            })
        })
    }

    /// The point of a texel's pieces at a place of the page, or the nearest to it.
    pub(crate) fn point(&self, layout: &Layout, texel: usize, place: DVec2) -> TexelPoint {
        let size = self.size;
        let mut nearest = (f64::INFINITY, None);
        for piece in self.pieces(texel) {
            let corners = layout.receivers[piece.of.receiver as usize]
                .texels(piece.of.triangle as usize, size);
            let Some(weights) = barycentric(corners, place) else {
                continue;
            };
            if weights.iter().all(|&w| w >= -ROUNDING) {
                return TexelPoint {
                    of: piece.of,
                    weights: normalized(weights),
                };
            }
            let polygon = self.polygon(&corners, self.texels[texel].index);
            let (_, centre) = area_and_centre(&polygon);
            let distance = centre.distance(place);
            if distance < nearest.0 {
                let weights = barycentric(corners, centre).unwrap_or([1.0 / 3.0; 3]);
                nearest = (distance, Some((piece.of, weights)));
            }
        }
        let (of, weights) = nearest
            .1
            .unwrap_or((self.pieces(texel)[0].of, [1.0 / 3.0; 3]));
        TexelPoint {
            of,
            weights: normalized(weights),
        }
    }

    /// What a texel covers of a triangle, texels.
    fn polygon(&self, corners: &[DVec2; 3], index: u32) -> Vec<DVec2> {
        let (column, row) = (index % self.size[0], index / self.size[0]);
        clipped(&clipped(corners, 1, row.into()), 0, column.into())
    }
}

/// Barycentric coordinates within the triangle.
fn normalized(weights: [f64; 3]) -> [f64; 3] {
    let positive = weights.map(|w| w.max(0.0));
    let sum: f64 = positive.iter().sum();
    positive.map(|w| w / sum)
}
