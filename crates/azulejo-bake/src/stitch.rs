//! Equal light on both sides of the seams of a smooth surface.
//!
//! Where a chart ends, a viewer interpolates between texels that lie differently on either side, and
//! their error is not the same: a line is seen. Texels along seams are changed as little as makes both
//! sides agree, by least squares. Where light changes abruptly at a seam, as under the edge of a thing that
//! lies on the surface, they stay: what is made equal there is wrong on both sides.
//!
//! Iwanicki, *Lighting technology of The Last of Us*, SIGGRAPH 2013.

use crate::atlas::Atlas;
use crate::layout::NO_CHART;
use crate::lightmap::Lightmap;
use crate::lightmap_page::bilinear_cells;
use crate::seams::{EdgeSide, Edges};
use std::collections::HashMap;

/// Points along a seam, per texel.
const POINTS_PER_TEXEL: f64 = 2.0;

/// Weight of a texel's own value beside that of a point of a seam: of a difference, a hundredth stays.
const OWN: f64 = 0.01;

/// Difference between both sides, relative to the brighter, and as a multiple of their standard errors, from
/// which on light changes there more abruptly than texels can show.
const STEP: f64 = 0.1;
const STEP_ERRORS: f64 = 2.0;

/// Angle between the faces of two objects that meet, up to which they are one surface, degrees.
const SMOOTH: f64 = 30.0;

/// Most steps of conjugate gradients.
const MOST_STEPS: usize = 200;

/// Residual at which they end, relative to the first.
const ENOUGH: f64 = 1e-4;

/// A point of a seam on both sides: texels and weights, which should sum to nothing.
type Row = Vec<(u32, f64)>;

/// Makes light equal on both sides of seams that are neither creases nor contacts, but where it changes
/// abruptly. Returns the root mean square of the difference along them before and after, of all channels.
pub fn stitch(lightmap: &mut Lightmap, atlas: &Atlas) -> SeamErrors {
    let starts = page_starts(lightmap);
    let mut rows = rows(lightmap, atlas, &starts);
    // Leave out points where light changes abruptly: made equal, both sides would be wrong.
    let all = rows.len();
    rows.retain(|row| is_even(row, lightmap, &starts));
    // Number the texels along seams, so that the system has no others.
    let mut numbers: HashMap<u32, u32> = HashMap::new();
    let mut texels = Vec::new();
    let system: Vec<Row> = rows
        .iter()
        .map(|row| {
            row.iter()
                .map(|&(texel, weight)| {
                    let number = *numbers.entry(texel).or_insert_with(|| {
                        texels.push(texel);
                        texels.len() as u32 - 1
                    });
                    (number, weight)
                })
                .collect()
        })
        .collect();
    let mut errors = SeamErrors {
        points: rows.len(),
        abrupt: all - rows.len(),
        ..SeamErrors::default()
    };
    // Solve for each channel, and measure the seams before and after.
    for channel in 0..3 {
        let given: Vec<f64> = texels
            .iter()
            .map(|&t| f64::from(lightmap.texel(&starts, t)[channel]))
            .collect();
        let solution = solve(&system, &given);
        errors.before += square(&system, &given);
        errors.after += square(&system, &solution);
        for (&texel, value) in texels.iter().zip(solution) {
            lightmap.texel(&starts, texel)[channel] = value.max(0.0) as f32;
        }
    }
    let count = (3 * rows.len()).max(1) as f64;
    errors.before = (errors.before / count).sqrt();
    errors.after = (errors.after / count).sqrt();
    errors
}

/// The root mean square of the difference along all seams that are neither creases nor contacts, as it is:
/// the same before and after.
pub fn seam_errors(lightmap: &Lightmap, atlas: &Atlas) -> SeamErrors {
    let starts = page_starts(lightmap);
    let rows = rows(lightmap, atlas, &starts);
    let pages = lightmap.pages.iter();
    let texels: Vec<[f32; 3]> = pages.flat_map(|p| p.irradiance.iter().copied()).collect();
    let of_row = |row: &Row| -> f64 {
        let of_channel = |k: usize| -> f64 {
            let values = row.iter();
            values
                .map(|&(t, w)| w * f64::from(texels[t as usize][k]))
                .sum()
        };
        (0..3).map(|k| of_channel(k).powi(2)).sum()
    };
    let count = (3 * rows.len()).max(1) as f64;
    let error = (rows.iter().map(of_row).fold(0.0, |sum, x| sum + x) / count).sqrt();
    SeamErrors {
        points: rows.len(),
        abrupt: 0,
        before: error,
        after: error,
    }
}

/// Differences of irradiance along seams.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SeamErrors {
    /// Points at which it was measured.
    pub points: usize,
    /// Points left out, because light changes abruptly there.
    pub abrupt: usize,
    /// Root mean square before they were made equal, W/m².
    pub before: f64,
    /// And after.
    pub after: f64,
}

/// The number of the first texel of each page, counted over all pages.
fn page_starts(lightmap: &Lightmap) -> Vec<u32> {
    let mut start = 0;
    let of_page = |page: &crate::LightmapPage| {
        let first = start;
        start += page.charts.len() as u32;
        first
    };
    lightmap.pages.iter().map(of_page).collect()
}

/// The page of a texel that is counted over all pages, and its place there.
fn place(starts: &[u32], texel: u32) -> (usize, usize) {
    let page = starts.partition_point(|&s| s <= texel) - 1;
    (page, (texel - starts[page]) as usize)
}

impl Lightmap {
    /// A texel counted over all pages.
    fn texel(&mut self, starts: &[u32], texel: u32) -> &mut [f32; 3] {
        let (page, at) = place(starts, texel);
        &mut self.pages[page].irradiance[at]
    }
}

/// Whether light is so even at a point of a seam that both sides should agree.
fn is_even(row: &Row, lightmap: &Lightmap, starts: &[u32]) -> bool {
    let step = |channel: usize| {
        let (mut sides, mut error) = ([0.0; 2], 0.0);
        for &(texel, weight) in row {
            let (page, at) = place(starts, texel);
            let page = &lightmap.pages[page];
            sides[usize::from(weight < 0.0)] +=
                weight.abs() * f64::from(page.irradiance[at][channel]);
            error += weight.abs() * f64::from(page.standard_error[at][channel]);
        }
        let [a, b] = sides;
        (a - b).abs() - STEP * f64::max(a, b) - STEP_ERRORS * error
    };
    (0..3).all(|channel| step(channel) <= 0.0)
}

/// A side of a seam: receiver, triangle, and the corner at which the edge begins.
type FacetEdge = (usize, u32, u8);

/// Pairs of sides that are one smooth surface, of one receiver, or of two that meet.
fn smooth_pairs(atlas: &Atlas) -> Vec<[FacetEdge; 2]> {
    let Atlas {
        receivers, layout, ..
    } = atlas;
    let mut pairs = Vec::new();
    let mut borders = Vec::new();
    for (r, receiver) in receivers.iter().enumerate() {
        let edges = Edges::of(receiver, &receiver.visible_triangles());
        let cuts = &layout.receivers[r].cuts;
        let is_cut = |(t, corner): (u32, u8)| cuts[t as usize][usize::from(corner)];
        let whole = edges.pairs().into_iter();
        let whole = whole.filter(|p| !p.sides.into_iter().any(is_cut));
        pairs.extend(whole.map(|p| p.sides.map(|(t, corner)| (r, t, corner))));
        borders.extend(
            edges
                .borders()
                .into_iter()
                .map(|(key, side)| (key, r, side)),
        );
    }
    borders.sort_unstable_by_key(|(key, r, side)| (*key, *r, side.triangle));
    for meeting in borders.chunk_by(|a, b| a.0 == b.0) {
        let [(_, r, a), (_, s, b)] = meeting else {
            continue;
        };
        let normal = |r: usize, side: &EdgeSide| {
            let vector = receivers[r].area_vector(side.triangle as usize);
            vector.normalize_or_zero()
        };
        let is_flat = normal(*r, a).dot(normal(*s, b)) >= SMOOTH.to_radians().cos();
        if a.is_along != b.is_along && is_flat {
            pairs.push([(*r, a.triangle, a.corner), (*s, b.triangle, b.corner)]);
        }
    }
    pairs
}

/// The points of all seams.
fn rows(lightmap: &Lightmap, atlas: &Atlas, starts: &[u32]) -> Vec<Row> {
    let pairs = smooth_pairs(atlas).into_iter();
    pairs
        .flat_map(|pair| seam_rows(pair, lightmap, atlas, starts))
        .collect()
}

/// The points of one seam; none where both sides are one chart.
fn seam_rows(pair: [FacetEdge; 2], lightmap: &Lightmap, atlas: &Atlas, starts: &[u32]) -> Vec<Row> {
    let layout = &atlas.layout;
    let ends = pair.map(|(r, triangle, corner)| {
        let uvs = layout.receivers[r].uvs[triangle as usize];
        let corner = usize::from(corner);
        [uvs[corner], uvs[(corner + 1) % 3]]
    });
    let is_charted = |(r, t, _): FacetEdge| layout.receivers[r].charts[t as usize] != NO_CHART;
    let pages = pair.map(|(r, t, _)| layout.receivers[r].pages[t as usize]);
    // The second side has the edge the other way round.
    let is_joined = pages[0] == pages[1] && ends[0][0] == ends[1][1] && ends[0][1] == ends[1][0];
    if is_joined || !pair.into_iter().all(is_charted) {
        return Vec::new();
    }
    let sizes = pages.map(|p| layout.pages[p as usize]);
    let length = |side: usize| {
        let [a, b] = ends[side];
        let along = |k: usize| f64::from(b[k] - a[k]) * f64::from(sizes[side][k]);
        along(0).hypot(along(1))
    };
    let count = (POINTS_PER_TEXEL * length(0).max(length(1)))
        .ceil()
        .max(1.0) as u32;
    let row = |k: u32| {
        let t = (f64::from(k) + 0.5) / f64::from(count);
        let mut row = Row::new();
        for (side, sign) in [(0, 1.0), (1, -1.0)] {
            let t = if side == 0 { t } else { 1.0 - t };
            let [a, b] = ends[side];
            let uv = [0, 1].map(|k| f64::from(a[k]) * (1.0 - t) + f64::from(b[k]) * t);
            let page = pages[side] as usize;
            let (cells, weights) = bilinear_cells(sizes[side], uv);
            for (cell, weight) in cells.into_iter().zip(weights) {
                let is_known = lightmap.pages[page].charts[cell] != NO_CHART;
                if weight > 0.0 && is_known {
                    row.push((starts[page] + cell as u32, sign * weight));
                }
            }
        }
        row
    };
    (0..count).map(row).collect()
}

fn difference(row: &Row, values: &[f64]) -> f64 {
    row.iter().map(|&(t, w)| w * values[t as usize]).sum()
}

fn square(rows: &[Row], values: &[f64]) -> f64 {
    rows.iter().map(|row| difference(row, values).powi(2)).sum()
}

/// The values nearest to the given ones for which rows sum to nothing, by conjugate gradients on
/// (AᵀA + OWN) x = OWN · given.
fn solve(rows: &[Row], given: &[f64]) -> Vec<f64> {
    let apply = |x: &[f64]| {
        let mut y: Vec<f64> = x.iter().map(|v| OWN * v).collect();
        for row in rows {
            let sum = difference(row, x);
            for &(t, w) in row {
                y[t as usize] += w * sum;
            }
        }
        y
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let mut x = given.to_vec();
    let of_x = apply(&x);
    let mut residual: Vec<f64> = given.iter().zip(&of_x).map(|(g, y)| OWN * g - y).collect();
    let mut direction = residual.clone();
    let first = dot(&residual, &residual);
    let mut old = first;
    for _ in 0..MOST_STEPS {
        if old <= ENOUGH * ENOUGH * first || old == 0.0 {
            break;
        }
        let of_direction = apply(&direction);
        let step = old / dot(&direction, &of_direction);
        for i in 0..x.len() {
            x[i] += step * direction[i];
            residual[i] -= step * of_direction[i];
        }
        let new = dot(&residual, &residual);
        for (d, r) in direction.iter_mut().zip(&residual) {
            *d = r + (new / old) * *d;
        }
        old = new;
    }
    x
}
