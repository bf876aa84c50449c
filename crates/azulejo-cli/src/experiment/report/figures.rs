//! The plots of a report, chosen by its results.

use super::super::record::{RunRecord, TaskRecord};
use super::tables::{RepeatedRun, repeated};

/// A line chart.
pub struct ChartSpec {
    /// File name without extension.
    pub name: String,
    /// Title.
    pub title: String,
    /// Horizontal axis.
    pub x: ChartAxis,
    /// Vertical axis.
    pub y: ChartAxis,
    /// The lines.
    pub series: Vec<ChartSeries>,
}

/// An axis with its quantity and unit.
#[derive(Clone, Copy)]
pub struct ChartAxis {
    /// Quantity and unit.
    pub label: &'static str,
    /// Whether the axis is logarithmic.
    pub is_logarithmic: bool,
}

/// One line.
#[derive(Clone)]
pub struct ChartSeries {
    /// Its name.
    pub name: String,
    /// Its points, by x.
    pub points: Vec<(f64, f64)>,
}

/// A quantity of runs.
struct PlotQuantity {
    /// For names of files.
    name: &'static str,
    axis: ChartAxis,
    of: fn(&RunRecord) -> Option<f64>,
}

const fn logarithmic(label: &'static str) -> ChartAxis {
    ChartAxis {
        label,
        is_logarithmic: true,
    }
}

const SECONDS: PlotQuantity = PlotQuantity {
    name: "time",
    axis: logarithmic("time for all form factors, s"),
    of: |r| Some(r.seconds),
};
const SAMPLES: PlotQuantity = PlotQuantity {
    name: "samples",
    axis: logarithmic("rays or pixels per row"),
    of: |r| (r.samples > 0.0).then_some(r.samples),
};
const ROW_ERROR: PlotQuantity = PlotQuantity {
    name: "row-error",
    axis: logarithmic("mean relative error of a row"),
    of: |r| r.row_error_mean,
};
const B_ERROR: PlotQuantity = PlotQuantity {
    name: "b-error",
    axis: logarithmic("mean relative error of B"),
    of: |r| r.b_error_mean,
};
const CLOSURE: PlotQuantity = PlotQuantity {
    name: "closure",
    axis: logarithmic("row sums' error, RMS"),
    of: |r| (r.closure_rms > 0.0).then_some(r.closure_rms),
};
const FACETS: PlotQuantity = PlotQuantity {
    name: "facets",
    axis: logarithmic("facets"),
    of: |r| Some(r.facets as f64),
};
const MEMORY: PlotQuantity = PlotQuantity {
    name: "memory",
    axis: logarithmic("peak memory, MiB"),
    of: |r| r.peak_bytes.map(|b| b as f64 / f64::from(1 << 20)),
};
const MIRRORS: PlotQuantity = PlotQuantity {
    name: "mirrors",
    axis: ChartAxis {
        label: "mirrors",
        is_logarithmic: false,
    },
    of: |r| r.mirrors.map(|m| m as f64),
};

/// The plots with at least one line of two points.
pub fn of(records: &[&TaskRecord]) -> Vec<ChartSpec> {
    let rows = repeated(records);
    let rows: Vec<&RepeatedRun> = rows.iter().filter(|r| !r.is_reference).collect();
    let mut scenes: Vec<&str> = Vec::new();
    for row in &rows {
        if !scenes.contains(&row.run.scene.as_str()) {
            scenes.push(&row.run.scene);
        }
    }
    let mut figures = Vec::new();
    for scene in scenes {
        let rows: Vec<&RepeatedRun> = rows
            .iter()
            .copied()
            .filter(|r| r.run.scene == scene)
            .collect();
        let by_engine = |r: &RunRecord| r.engine.clone();
        for (y, x) in [
            (&ROW_ERROR, &SECONDS),
            (&B_ERROR, &SECONDS),
            (&ROW_ERROR, &SAMPLES),
            (&SECONDS, &SAMPLES),
        ] {
            figures.push(figure(scene, &rows, x, y, by_engine));
        }
    }
    // Scenes of one family differ in their number of mirrors or facets.
    let mut families: Vec<&str> = rows.iter().map(|r| family(r.run)).collect();
    families.dedup();
    for name in families {
        let rows: Vec<&RepeatedRun> = rows
            .iter()
            .copied()
            .filter(|r| family(r.run) == name)
            .collect();
        let pairs = if rows.iter().any(|r| r.run.mirrors.is_some()) {
            vec![
                (&SECONDS, &MIRRORS),
                (&ROW_ERROR, &MIRRORS),
                (&B_ERROR, &MIRRORS),
            ]
        } else {
            vec![(&SECONDS, &FACETS), (&MEMORY, &FACETS), (&CLOSURE, &FACETS)]
        };
        for (y, x) in pairs {
            figures.push(figure(name, &rows, x, y, |r| r.setting.clone()));
        }
    }
    figures.retain(|f| f.series.iter().any(|s| s.points.len() > 1));
    figures
}

/// The scene's name without its parameters.
fn family(run: &RunRecord) -> &str {
    run.scene.split(", ").next().unwrap_or("")
}

fn figure(
    about: &str,
    rows: &[&RepeatedRun],
    x: &PlotQuantity,
    y: &PlotQuantity,
    name: impl Fn(&RunRecord) -> String,
) -> ChartSpec {
    let mut series: Vec<ChartSeries> = Vec::new();
    for row in rows {
        let (Some(px), Some(py)) = (row.mean(x.of), row.mean(y.of)) else {
            continue;
        };
        let fits = |axis: ChartAxis, p: f64| p.is_finite() && (p > 0.0 || !axis.is_logarithmic);
        if !fits(x.axis, px) || !fits(y.axis, py) {
            continue;
        }
        let name = name(row.run);
        let index = series
            .iter()
            .position(|s| s.name == name)
            .unwrap_or_else(|| {
                series.push(ChartSeries {
                    name,
                    points: Vec::new(),
                });
                series.len() - 1
            });
        series[index].points.push((px, py));
    }
    for s in &mut series {
        s.points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    ChartSpec {
        name: format!("{}-{}-{}", file_name(about), y.name, x.name),
        title: about.to_owned(),
        x: x.axis,
        y: y.axis,
        series,
    }
}

/// Letters and digits, the rest as single hyphens.
fn file_name(text: &str) -> String {
    let words = text.split(|c: char| !c.is_ascii_alphanumeric());
    let words: Vec<&str> = words.filter(|w| !w.is_empty()).collect();
    words.join("-").to_lowercase()
}

/// The exponent of the growth of y with x, by least squares of the logarithms; `None` for one point.
pub fn growth(points: &[(f64, f64)]) -> Option<f64> {
    let n = points.len() as f64;
    let logs: Vec<(f64, f64)> = points.iter().map(|&(x, y)| (x.ln(), y.ln())).collect();
    let mean = |f: fn(&(f64, f64)) -> f64| logs.iter().map(f).sum::<f64>() / n;
    let (mx, my) = (mean(|p| p.0), mean(|p| p.1));
    let across: f64 = logs.iter().map(|(x, y)| (x - mx) * (y - my)).sum();
    let along: f64 = logs.iter().map(|(x, _)| (x - mx).powi(2)).sum();
    (along > 1e-9).then(|| across / along)
}

#[cfg(test)]
mod tests {
    use super::super::super::record::TaskOutcome;
    use super::*;

    fn run(scene: &str, mirrors: Option<usize>, samples: f64) -> TaskRecord {
        let run = RunRecord {
            scene: scene.into(),
            mirrors,
            engine: "rays".into(),
            setting: format!("rays, {samples} rays"),
            samples,
            seconds: samples / 100.0,
            row_error_mean: Some(1.0 / samples),
            ..RunRecord::default()
        };
        TaskRecord {
            key: String::new(),
            version: String::new(),
            outcome: TaskOutcome::Run(run),
        }
    }

    #[test]
    fn plots_that_have_lines() {
        let records = [
            run("box, 0 mirrors", Some(0), 64.0),
            run("box, 0 mirrors", Some(0), 256.0),
            run("box, 16 mirrors", Some(16), 64.0),
        ];
        let figures = of(&records.iter().collect::<Vec<_>>());
        let names: Vec<&str> = figures.iter().map(|f| f.name.as_str()).collect();
        assert_eq!(
            names,
            [
                "box-0-mirrors-row-error-time",
                "box-0-mirrors-row-error-samples",
                "box-0-mirrors-time-samples",
                "box-time-mirrors",
                "box-row-error-mirrors"
            ]
        );
        assert_eq!(
            figures[0].series[0].points,
            [(0.64, 1.0 / 64.0), (2.56, 1.0 / 256.0)]
        );
    }

    #[test]
    fn growth_is_the_slope() {
        let points = [10.0f64, 100.0, 1000.0].map(|x| (x, 3.0 * x.powf(1.7)));
        assert!((growth(&points).unwrap() - 1.7).abs() < 1e-12);
        assert_eq!(growth(&points[..1]), None);
    }
}
