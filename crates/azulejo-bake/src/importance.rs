//! Which charts need more texels than others: those with the edges of shadows.
//!
//! What bilinear interpolation misses of an abrupt change is, as a mean square over a chart, proportional to the
//! width h of its texels and to e, the length of such edges times their squared heights over its area. With a
//! given number of texels, Σ A e h is least where texels per area are proportional to e^(2/3).

use crate::Receiver;
use crate::atlas::Atlas;
use crate::direct::{DirectGather, direct};
use crate::layout::{Layout, NO_CHART, signed_area};
use crate::samples::{Rows, Samples};
use azulejo_scene::Rgb;
use azulejo_trace::{Cancelled, Gatherer, Run};

/// Width of the texels with which edges are looked for, relative to that of the lightmap's.
const COARSER: u32 = 4;

/// Least width of the pages for that, texels.
const LEAST_PAGE: u32 = 16;

/// Direct light's error there, relative to that of the lightmap.
const COARSER_ERROR: f64 = 2.0;

/// What a chart without any edge counts as, relative to the mean of all.
const SMOOTH: f64 = 0.02;

/// Fewest and most texels per area, relative to the mean: with fewer, indirect light suffers more than shadows gain.
const LIMITS: [f64; 2] = [1.0 / 2.0, 4.0];

/// Times that charts beyond these limits are set to them, and the others to what is left.
const ROUNDS: u32 = 16;

/// Which charts of a layout need more texels than others.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChartImportance {
    /// How much denser than others the texels of each chart should be, per length.
    pub densities: Vec<f64>,
    /// Area times edges of each chart: to what its mean square error is proportional, with the width of a texel.
    edges: Vec<f64>,
}

impl ChartImportance {
    /// The mean square error that interpolation makes at the edges of shadows with the texels of `layout`, up to a
    /// factor; `measured` is the layout of the same receivers whose charts were looked at.
    pub fn shadow_error(&self, layout: &Layout, measured: &Layout, receivers: &[Receiver]) -> f64 {
        let mut areas = vec![[0.0; 2]; self.edges.len()];
        for (r, receiver) in receivers.iter().enumerate() {
            for (t, &chart) in measured.receivers[r].charts.iter().enumerate() {
                if chart != NO_CHART {
                    let of_chart = &mut areas[chart as usize];
                    of_chart[0] += 0.5 * receiver.area_vector(t).length();
                    of_chart[1] += signed_area(layout.texels(r, t)).abs();
                }
            }
        }
        let of_chart = |(edges, [area, texels]): (&f64, &[f64; 2])| {
            edges * (area / f64::max(*texels, f64::MIN_POSITIVE)).sqrt()
        };
        self.edges.iter().zip(&areas).map(of_chart).sum()
    }
}

/// Looks for the edges of shadows. `error` is that of the lightmap relative to the mean.
///
/// # Errors
/// The caller cancelled.
pub fn chart_importance(
    atlas: &Atlas,
    gatherer: &Gatherer,
    error: f64,
    seed: u32,
    run: Run,
) -> Result<ChartImportance, Cancelled> {
    // Larger texels and a larger error show where the edges of shadows are, at a small part of the cost.
    let mut coarse = atlas.clone();
    for size in coarse.layout.pages.iter_mut().flatten() {
        *size = (*size / COARSER).max(LEAST_PAGE);
    }
    let samples = Samples::new(&coarse, gatherer.surfaces().tracer, run)?;
    let error = COARSER_ERROR * error;
    let gather = DirectGather {
        samples: &samples,
        atlas: &coarse,
        gatherer,
        is_directional: false,
        seed,
    };
    let light = direct(gather, error, run)?.light;
    let mut charts = vec![ChartEdges::default(); atlas.layout.charts as usize];
    let mut first = 0;
    for (page, coverage) in samples.pages.iter().enumerate() {
        let of_page = samples.samples[first..]
            .iter()
            .take_while(|s| s.page as usize == page)
            .count();
        // A texel with several samples has the light of the last one.
        let mut of_texels = vec![Rgb::BLACK; coverage.texels.len()];
        for sample in first..first + of_page {
            let texel = samples.samples[sample].texel as usize;
            of_texels[texel] = Rgb::from(light.irradiance[sample].map(f64::from));
        }
        first += of_page;
        let rows = Rows::new(coverage);
        for (t, texel) in coverage.texels.iter().enumerate() {
            let chart = &mut charts[texel.chart as usize];
            chart.area += f64::from(texel.area);
            chart.texels += 1.0;
            let [column, row] = rows.place(texel.index);
            // Sum the squared steps between neighbours of a chart, each pair once.
            for next in [rows.at(column + 1, row), rows.at(column, row + 1)] {
                let Some(n) = next.filter(|&n| coverage.texels[n as usize].chart == texel.chart)
                else {
                    continue;
                };
                let step = of_texels[n as usize] - of_texels[t];
                chart.steps += (step * step).mean();
                chart.pairs += 1.0;
            }
        }
    }
    let edges = |chart: &ChartEdges| chart.edges().map_or(0.0, |edges| chart.area * edges);
    Ok(ChartImportance {
        densities: densities(&charts),
        edges: charts.iter().map(edges).collect(),
    })
}

/// What is found on a chart.
#[derive(Clone, Copy, Debug, Default)]
struct ChartEdges {
    area: f64,
    texels: f64,
    /// Pairs of texels side by side, and the sum of their squared differences.
    pairs: f64,
    steps: f64,
}

impl ChartEdges {
    /// Squared heights times length of edges, over the area; `None` where too little is seen.
    fn edges(&self) -> Option<f64> {
        let width = (self.area / self.texels).sqrt();
        let edges = self.steps * width / self.area;
        (self.pairs > 0.0 && edges.is_finite()).then_some(edges)
    }
}

/// Texels per length of each chart relative to the mean.
fn densities(charts: &[ChartEdges]) -> Vec<f64> {
    let (mut sum, mut area) = (0.0, 0.0);
    for (chart, edges) in charts.iter().filter_map(|c| Some((c, c.edges()?))) {
        sum += chart.area * edges;
        area += chart.area;
    }
    let mean = sum / area;
    if mean.is_nan() || mean <= 0.0 {
        return vec![1.0; charts.len()];
    }
    let share_of = |chart: &ChartEdges| {
        let edges = chart.edges().unwrap_or(mean);
        (edges / mean + SMOOTH).powf(2.0 / 3.0)
    };
    let shares: Vec<f64> = charts.iter().map(share_of).collect();
    let all: f64 = charts.iter().map(|c| c.area).sum();
    let mut scale = 1.0;
    let limited = |share: f64, scale: f64| (scale * share).clamp(LIMITS[0], LIMITS[1]);
    for _ in 0..ROUNDS {
        let of_charts = charts.iter().zip(&shares);
        let texels: f64 = of_charts.map(|(c, &w)| c.area * limited(w, scale)).sum();
        scale *= all / texels;
    }
    let density = |&share: &f64| limited(share, scale).sqrt();
    shares.iter().map(density).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(area: f64, steps: f64) -> ChartEdges {
        ChartEdges {
            area,
            texels: 100.0 * area,
            pairs: 190.0 * area,
            steps,
        }
    }

    /// Texels go to charts with edges, their number stays, and no chart is starved.
    #[test]
    fn edges_get_texels() {
        let charts = [
            chart(1.0, 8.0),
            chart(2.0, 0.0),
            chart(1.0, 1.0),
            chart(0.01, 0.0),
        ];
        let ratio = densities(&charts);
        assert!(ratio[0] > ratio[2] && ratio[2] > ratio[1], "{ratio:?}");
        // Edges of an eighth of the squared height: a quarter of the texels.
        let share = (ratio[0] / ratio[2]).powi(2);
        assert!((3.0..4.2).contains(&share), "{share}");
        let texels: f64 = charts.iter().zip(&ratio).map(|(c, d)| c.area * d * d).sum();
        assert!((texels / 4.01 - 1.0).abs() < 0.05, "{texels}");
        let limits = LIMITS.map(f64::sqrt);
        assert!(
            ratio
                .iter()
                .all(|d| (limits[0] - 1e-9..=limits[1] + 1e-9).contains(d))
        );
        assert_eq!(densities(&[chart(1.0, 0.0); 2]), [1.0; 2]);
        assert!(densities(&[]).is_empty());
    }
}
