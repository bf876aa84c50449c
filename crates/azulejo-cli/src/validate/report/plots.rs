//! The plots of the report.

use super::super::ValidationResults;
use super::super::record::{CheckRecord, ValidationPart};
use crate::charts::{ChartAxis, ChartPoint, ChartSeries, ChartSpec, SeriesStyle};
use std::f64::consts::TAU;

/// Relative errors below this are drawn at it: closed forms may be right to the last bit.
const LEAST: f64 = 1e-16;

/// Width of the bins of the histogram, in standard errors.
const BIN: f64 = 0.5;

/// The histogram ends here; what is beyond is in the last bin.
const BINS: i32 = 10;

/// Fewer answers than this are not a histogram.
const FEW: usize = 30;

/// The plots that the results have something for.
pub fn of(results: &ValidationResults) -> Vec<ChartSpec> {
    let plots = [
        errors(results),
        histogram(results),
        convergence(results),
        coverage(results),
    ];
    plots.into_iter().filter(|f| !f.series.is_empty()).collect()
}

const fn axis(label: &'static str, is_logarithmic: bool) -> ChartAxis {
    ChartAxis {
        label,
        is_logarithmic,
    }
}

fn points(of: impl IntoIterator<Item = [f64; 2]>) -> Vec<ChartPoint> {
    let point = |at| ChartPoint {
        at,
        samples: 0.0,
        spread: [0.0; 2],
    };
    of.into_iter().map(point).collect()
}

/// The closed forms by engine, without the check of their outlying ones.
fn by_engine(results: &ValidationResults) -> Vec<(&str, Vec<&CheckRecord>)> {
    let mut engines: Vec<(&str, Vec<&CheckRecord>)> = Vec::new();
    for record in &results.records {
        if record.part != ValidationPart::ClosedForms || record.expected == 0.0 {
            continue;
        }
        match engines.iter_mut().find(|(name, _)| *name == record.engine) {
            Some((_, records)) => records.push(record),
            None => engines.push((&record.engine, vec![record])),
        }
    }
    engines
}

/// Relative errors against the values themselves.
fn errors(results: &ValidationResults) -> ChartSpec {
    let series = |(name, records): (&str, Vec<&CheckRecord>)| ChartSeries {
        name: name.to_owned(),
        style: SeriesStyle::Points,
        points: points(records.iter().map(|r| {
            let relative = (r.deviation() / r.expected).abs();
            [r.expected.abs(), relative.max(LEAST)]
        })),
    };
    ChartSpec {
        name: "errors".into(),
        title: "Errors of closed forms".into(),
        x: axis("form factor (or radiosity, W/m²)", true),
        y: axis("relative error", true),
        series: by_engine(results).into_iter().map(series).collect(),
    }
}

/// Deviations in standard errors, beside those of normal errors.
fn histogram(results: &ValidationResults) -> ChartSpec {
    let mut series = Vec::new();
    for (name, records) in by_engine(results) {
        let scores: Vec<f64> = records.iter().filter_map(|r| r.standard_score()).collect();
        if scores.len() >= FEW {
            series.push(ChartSeries {
                name: format!("{name} ({})", scores.len()),
                style: SeriesStyle::Marked,
                points: points(densities(&scores)),
            });
        }
    }
    if !series.is_empty() {
        let steps = -40..=40;
        let normal = |k: i32| {
            let z = f64::from(k) * 0.125;
            [z, (-0.5 * z * z).exp() / TAU.sqrt()]
        };
        series.push(ChartSeries {
            name: "normal errors".into(),
            style: SeriesStyle::Line,
            points: points(steps.map(normal)),
        });
    }
    ChartSpec {
        name: "scores".into(),
        title: "Deviations in standard errors".into(),
        x: axis("(found − expected) / standard error", false),
        y: axis("density", false),
        series,
    }
}

/// Centres of bins and densities.
fn densities(scores: &[f64]) -> Vec<[f64; 2]> {
    let mut bins = vec![0.0; 2 * BINS as usize + 1];
    for z in scores {
        let bin = (z / BIN).round().clamp(-f64::from(BINS), f64::from(BINS));
        bins[(bin as i32 + BINS) as usize] += 1.0 / (scores.len() as f64 * BIN);
    }
    let center = |k: usize| BIN * (k as f64 - f64::from(BINS));
    bins.into_iter()
        .enumerate()
        .map(|(k, n)| [center(k), n])
        .collect()
}

/// Error against samples.
fn convergence(results: &ValidationResults) -> ChartSpec {
    let series = results.convergence.iter().map(|curve| ChartSeries {
        name: curve.engine.to_owned(),
        style: SeriesStyle::Marked,
        points: points(curve.points.iter().copied()),
    });
    ChartSpec {
        name: "convergence".into(),
        title: "Error of unoccluded polygons".into(),
        x: axis("rays or pixels of a row", true),
        y: axis("root mean square of relative errors", true),
        series: series.collect(),
    }
}

/// Shares within this many standard errors, beside those of normal errors.
fn coverage(results: &ValidationResults) -> ChartSpec {
    let curve = |name: &str, style, of: Vec<[f64; 2]>| ChartSeries {
        name: name.to_owned(),
        style,
        points: points(of),
    };
    let coverages = results.coverage.iter();
    let mut series: Vec<ChartSeries> = coverages
        .map(|c| curve(&c.name, SeriesStyle::Marked, c.points.clone()))
        .collect();
    if !series.is_empty() {
        series.push(curve("normal errors", SeriesStyle::Line, NORMAL.to_vec()));
    }
    ChartSpec {
        name: "coverage".into(),
        title: "Answers within their error bars".into(),
        x: axis("standard errors", false),
        y: axis("share of answers", false),
        series,
    }
}

/// erf(z/√2) at some z.
const NORMAL: [[f64; 2]; 13] = [
    [0.0, 0.0],
    [0.25, 0.197_413],
    [0.5, 0.382_925],
    [0.75, 0.546_745],
    [1.0, 0.682_689],
    [1.25, 0.788_700],
    [1.5, 0.866_386],
    [1.75, 0.919_882],
    [2.0, 0.954_500],
    [2.25, 0.975_551],
    [2.5, 0.987_581],
    [3.0, 0.997_300],
    [4.0, 0.999_937],
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn densities_sum_to_one() {
        let density = densities(&[0.1, -0.1, 0.6, -99.0, 7.0]);
        let sum: f64 = density.iter().map(|p| p[1] * BIN).sum();
        assert!((sum - 1.0).abs() < 1e-12);
        let middle = density.iter().find(|p| p[0] == 0.0).unwrap();
        assert!((middle[1] - 0.8).abs() < 1e-12, "{density:?}");
        assert!(density[0][1] > 0.0 && density[density.len() - 1][1] > 0.0);
    }
}
