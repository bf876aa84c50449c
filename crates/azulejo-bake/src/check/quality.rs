//! How well an atlas uses its texels.

use super::{AtlasCheck, CheckedTriangle};
use crate::Receiver;
use crate::layout::Layout;
use glam::{DVec2, DVec3};

/// Share of the area that is left out at both ends of densities.
const EXTREME: f64 = 0.05;

/// Stretch above which triangles are counted.
const MUCH_STRETCH: f64 = 4.0;

/// Width of a chart below which its light is that of single texels, at best.
const THIN: f64 = 0.5;

/// What is summed for a chart.
#[derive(Clone, Copy)]
struct ChartSums {
    /// Surface of triangles of either orientation, square scene units.
    area: [f64; 2],
    texels: f64,
    low: DVec2,
    high: DVec2,
    first: usize,
}

/// Finds all that does not concern pairs.
pub(super) fn find(
    triangles: &[CheckedTriangle],
    receivers: &[Receiver],
    layout: &Layout,
    found: &mut AtlasCheck,
) {
    // Sum up the charts first: orientation and stretch are relative to the chart of a triangle.
    let charts = chart_sums(triangles, found.charts);
    let whole: f64 = triangles.iter().map(|t| t.area).sum();
    let share = |area: f64| area / whole.max(f64::MIN_POSITIVE);
    let (mut texels, mut small) = (0.0, 0.0);
    let (mut weight, mut squares) = (0.0, 0.0);
    let mut densities = Vec::new();
    for triangle in triangles {
        let own = share(triangle.area);
        if triangle.texels == 0.0 {
            found.collapsed.add(own, triangle.id);
            found.collapsed_share += own;
            continue;
        }
        // The side to which most of a chart's surface faces is right, and the rest is mirrored.
        let chart = &charts[triangle.chart as usize];
        if (triangle.texels > 0.0) != (chart.area[0] >= chart.area[1]) {
            found.mirrored.add(own, triangle.id);
            found.mirrored_share += own;
        }
        texels += triangle.texels.abs();
        small += if triangle.texels.abs() < 1.0 {
            own
        } else {
            0.0
        };
        densities.push(((triangle.texels.abs() / triangle.area).sqrt(), own));
        // Measure the stretch relative to the density of the chart, which has a measure of its own.
        let receiver = &receivers[triangle.id.receiver as usize];
        let space = receiver.corners(triangle.id.triangle as usize);
        let scale = chart.texels / (chart.area[0] + chart.area[1]);
        let [mean, most] = stretch(triangle.corners, space).map(|s| s * scale.sqrt());
        weight += own;
        squares += own * mean * mean;
        // Keep the largest stretch of all triangles, but count only those where it is much.
        let count = found.most_stretch.count + usize::from(most > MUCH_STRETCH);
        found.most_stretch.add(most, triangle.id);
        found.most_stretch.count = count;
    }
    for chart in &charts {
        let width = (chart.high - chart.low).min_element();
        if chart.texels > 0.0 && width < THIN {
            found.thin.add(THIN - width, triangles[chart.first].id);
        }
    }
    let pages = layout.texel_count().max(1) as f64;
    found.covered = texels / pages;
    found.below_texel = small;
    found.stretch = if weight > 0.0 {
        (squares / weight).sqrt()
    } else {
        1.0
    };
    found.density = extremes(&mut densities);
}

fn chart_sums(triangles: &[CheckedTriangle], count: usize) -> Vec<ChartSums> {
    let empty = ChartSums {
        area: [0.0; 2],
        texels: 0.0,
        low: DVec2::INFINITY,
        high: DVec2::NEG_INFINITY,
        first: usize::MAX,
    };
    let mut charts = vec![empty; count];
    let placed = triangles.iter().enumerate();
    for (number, triangle) in placed.filter(|(_, t)| t.texels != 0.0) {
        let chart = &mut charts[triangle.chart as usize];
        chart.first = chart.first.min(number);
        chart.area[usize::from(triangle.texels < 0.0)] += triangle.area;
        chart.texels += triangle.texels.abs();
        for corner in triangle.corners {
            chart.low = chart.low.min(corner);
            chart.high = chart.high.max(corner);
        }
    }
    charts
}

/// Root mean square and largest stretch of the map from the page to the surface, scene units per texel.
fn stretch([a, b, c]: [DVec2; 3], space: [DVec3; 3]) -> [f64; 2] {
    let twice = (b - a).perp_dot(c - a);
    let [q, r] = [space[1] - space[0], space[2] - space[0]];
    let (e, f) = (b - a, c - a);
    let along_u = (q * f.y - r * e.y) / twice;
    let along_v = (r * e.x - q * f.x) / twice;
    let (a, b, c) = (
        along_u.length_squared(),
        along_u.dot(along_v),
        along_v.length_squared(),
    );
    let root = ((a - c).powi(2) + 4.0 * b * b).sqrt();
    [(0.5 * (a + c)).sqrt(), (0.5 * (a + c + root)).sqrt()]
}

/// Densities below which the extreme part of the area lies, and above which.
fn extremes(densities: &mut [(f64, f64)]) -> [f64; 2] {
    densities.sort_by(|a, b| a.0.total_cmp(&b.0));
    let whole: f64 = densities.iter().map(|d| d.1).sum();
    let at = |share: f64| {
        let mut sum = 0.0;
        let density = densities.iter().find(|d| {
            sum += d.1;
            sum >= share * whole
        });
        density.or(densities.last()).map_or(0.0, |d| d.0)
    };
    [at(EXTREME), at(1.0 - EXTREME)]
}
