//! What is wrong with texture coordinates for a lightmap, ours or anybody's.
//!
//! | Module | What it looks for |
//! |---|---|
//! | `islands` | charts, by edges on whose two sides coordinates are equal; creases inside of them |
//! | `grid` | boxes that are near one another |
//! | `overlaps`, `gaps` | triangles that share texels, charts that are too near for a filter |
//! | `quality` | density, stretch, mirrored and collapsed triangles |
//!
//! Time and memory grow with the number of triangles, whatever their coordinates are.

mod gaps;
mod grid;
mod islands;
mod overlaps;
mod quality;

use crate::layout::{Layout, NO_CHART, signed_area};
use crate::{Receiver, TriangleId};
use glam::DVec2;
use islands::IslandTriangle;

/// How far outside of the page coordinates may lie for rounding, as a share of it.
const OUTSIDE_ROUNDING: f64 = 1e-6;

/// Coordinates beyond this many pages are not compared with others.
const FARTHEST: f64 = 1e3;

/// What an atlas is held against.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckOptions {
    /// Charts that are nearer are found, texels.
    pub gap: f64,
    /// Larger angles between neighbouring faces of a chart are found, degrees.
    pub crease: f64,
}

impl Default for CheckOptions {
    fn default() -> CheckOptions {
        CheckOptions {
            gap: 2.0,
            crease: 30.0,
        }
    }
}

/// Something that was found, and where it is worst.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Finding {
    /// How often.
    pub count: usize,
    /// How bad the worst is, in the unit of the field.
    pub amount: f64,
    /// The worst triangle.
    pub worst: Option<TriangleId>,
}

impl Finding {
    /// Counts another one, and keeps the worse.
    fn add(&mut self, amount: f64, at: TriangleId) {
        self.count += 1;
        if self.worst.is_none() || amount > self.amount {
            (self.amount, self.worst) = (amount, Some(at));
        }
    }
}

/// What was found of an atlas. Triangles without an area that single precision can tell from none are left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AtlasCheck {
    /// Number of triangles with an area.
    pub triangles: usize,
    /// Number of charts.
    pub charts: usize,
    /// Triangles with coordinates that are outside of 0..=1, or no numbers. The amount is how far, in pages.
    pub outside: Finding,
    /// Triangles that overlap others by more than 1e-6 of the smaller area, and more than rounding. The
    /// amount is the largest share of a smaller triangle.
    pub overlaps: Finding,
    /// Charts with another one nearer than asked for. The amount is that distance, of the nearest, texels.
    pub near: Finding,
    /// Triangles that are mirrored within their chart. The amount is the largest share of all area.
    pub mirrored: Finding,
    /// Area of mirrored triangles as a share of all.
    pub mirrored_share: f64,
    /// Triangles without area on the page, so that they cover no texel. The amount is the largest share of all
    /// area.
    pub collapsed: Finding,
    /// Area of collapsed triangles as a share of all.
    pub collapsed_share: f64,
    /// Edges inside of charts at which faces meet at more than the crease. The amount is the largest
    /// angle, degrees.
    pub creases: Finding,
    /// Charts that are thinner than half a texel along an axis. The amount is how much thinner, texels.
    pub thin: Finding,
    /// Texels per scene unit below which 5% and above which 5% of the area lie.
    pub density: [f64; 2],
    /// Stretch of charts, each relative to its own density (Sander, Snyder, Gortler and Hoppe, *Texture
    /// mapping progressive meshes*, SIGGRAPH 2001): the root mean square over the area; 1 is none.
    pub stretch: f64,
    /// The largest stretch in any direction anywhere. The count is the number of triangles above 4.
    pub most_stretch: Finding,
    /// Area of triangles on the pages as a share of these, overlaps counted once per triangle.
    pub covered: f64,
    /// Share of the area in triangles that cover less than a whole texel each.
    pub below_texel: f64,
    /// Whether all pairs were compared. Where very many lie over one another, not all are.
    pub is_complete: bool,
}

impl AtlasCheck {
    /// Largest over smallest density, without the extreme 5% of the area on either side.
    pub fn density_spread(&self) -> f64 {
        self.density[1] / self.density[0].max(f64::MIN_POSITIVE)
    }
}

/// A triangle with an area, as the checks see it.
#[derive(Clone, Copy, Debug)]
struct CheckedTriangle {
    id: TriangleId,
    page: u32,
    /// [`NO_CHART`] if it has none.
    chart: u32,
    /// Corners, texels.
    corners: [DVec2; 3],
    /// Area on the page, square texels; negative if it is mirrored against the page.
    texels: f64,
    /// Area of the surface, square scene units.
    area: f64,
    /// Whether it has a chart, and coordinates that are numbers of a usable size.
    is_placed: bool,
    /// Which edges no other triangle of the chart has with the same coordinates.
    is_border: [bool; 3],
}

/// Checks texture coordinates. Charts are those of `layout` where it has them, else triangles that meet at edges
/// with equal coordinates. Triangles without coordinates
/// or page are left out; those without chart cover no texel.
pub fn check(receivers: &[Receiver], layout: &Layout, options: &CheckOptions) -> AtlasCheck {
    let mut check = AtlasCheck {
        is_complete: true,
        ..AtlasCheck::default()
    };
    let triangles = checked_triangles(receivers, layout, options, &mut check);
    check.triangles = triangles.len();
    for triangle in &triangles {
        let uvs = &layout.receivers[triangle.id.receiver as usize].uvs;
        let amount = outside(uvs[triangle.id.triangle as usize]);
        if amount > OUTSIDE_ROUNDING {
            check.outside.add(amount, triangle.id);
        }
    }
    overlaps::find(&triangles, layout, &mut check);
    gaps::find(&triangles, options.gap, &mut check);
    quality::find(&triangles, receivers, layout, &mut check);
    check
}

/// How far coordinates lie outside of the page; infinite for what is not a number.
fn outside(uvs: [[f32; 2]; 3]) -> f64 {
    let beyond = |c: f32| match f64::from(c) {
        c if c.is_finite() => f64::max(-c, c - 1.0).max(0.0),
        _ => f64::INFINITY,
    };
    uvs.into_iter().flatten().map(beyond).fold(0.0, f64::max)
}

/// The triangles that have an area and coordinates, with charts numbered over all receivers.
fn checked_triangles(
    receivers: &[Receiver],
    layout: &Layout,
    options: &CheckOptions,
    found: &mut AtlasCheck,
) -> Vec<CheckedTriangle> {
    let mut list = Vec::new();
    let mut charts = 0;
    for (r, (receiver, placed)) in receivers.iter().zip(&layout.receivers).enumerate() {
        // Leave out triangles without area, coordinates or page.
        let is_visible = receiver.visible_triangles();
        let is_checked = |t: &usize| {
            let page = placed.pages.get(*t).copied().unwrap_or(0);
            let is_there = (page as usize) < layout.pages.len() && *t < placed.uvs.len();
            is_visible[*t] && is_there
        };
        let is_charted = |t: &usize| placed.charts.get(*t) != Some(&NO_CHART);
        let all = (0..receiver.triangles.len()).filter(is_checked);
        let (kept, bare): (Vec<usize>, Vec<usize>) = all.partition(is_charted);
        // Form the charts of the receiver, and count the creases inside of them.
        let islands = islands::of(receiver, placed, &kept);
        for crease in islands.creases(receiver, options.crease) {
            let id = TriangleId {
                receiver: r as u32,
                triangle: crease.1,
            };
            found.creases.add(crease.0, id);
        }
        // Triangles without a chart come last, and cover nothing on the page.
        let none = IslandTriangle {
            chart: NO_CHART,
            is_border: [false; 3],
        };
        let bare = bare.iter().map(|t| (t, &none));
        for (&t, island) in kept.iter().zip(&islands.triangles).chain(bare) {
            let page = placed.pages.get(t).copied().unwrap_or(0);
            let size = layout.pages[page as usize];
            let corners = placed.texels(t, size);
            let mut coordinates = placed.uvs[t].iter().flatten();
            let is_placed =
                island.chart != NO_CHART && coordinates.all(|c| f64::from(c.abs()) < FARTHEST);
            list.push(CheckedTriangle {
                id: TriangleId {
                    receiver: r as u32,
                    triangle: t as u32,
                },
                page,
                chart: match island.chart {
                    NO_CHART => NO_CHART,
                    chart => charts + chart,
                },
                corners,
                texels: if is_placed { signed_area(corners) } else { 0.0 },
                area: receiver.area_vector(t).length(),
                is_placed,
                is_border: island.is_border,
            });
        }
        charts += islands.charts;
    }
    found.charts = charts as usize;
    list
}

/// The charts of the triangles of all receivers, and their number. Triangles that cannot cover a texel have none.
pub(crate) fn chart_numbers(receivers: &[Receiver], layout: &Layout) -> (Vec<Vec<u32>>, u32) {
    let mut check = AtlasCheck::default();
    let options = CheckOptions::default();
    let triangles = checked_triangles(receivers, layout, &options, &mut check);
    let counts = receivers.iter().map(|r| r.triangles.len());
    let mut numbers: Vec<Vec<u32>> = counts.map(|count| vec![NO_CHART; count]).collect();
    for triangle in triangles.iter().filter(|t| t.texels != 0.0) {
        numbers[triangle.id.receiver as usize][triangle.id.triangle as usize] = triangle.chart;
    }
    (numbers, check.charts as u32)
}
