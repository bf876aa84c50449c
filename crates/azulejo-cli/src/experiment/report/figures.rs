//! The plots of a report, chosen by its results.

use super::super::record::{RunRecord, TaskRecord};
use super::tables::{RepeatedRun, repeated};
use crate::charts::{ChartAxis, ChartPoint, ChartSeries, ChartSpec, SeriesStyle};

/// A quantity of runs.
struct PlotQuantity {
    /// For names of files.
    name: &'static str,
    axis: ChartAxis,
    of: fn(&RunRecord) -> Option<f64>,
}

/// A quantity on a logarithmic axis.
const fn plotted(
    name: &'static str,
    label: &'static str,
    of: fn(&RunRecord) -> Option<f64>,
) -> PlotQuantity {
    let axis = ChartAxis {
        label,
        is_logarithmic: true,
    };
    PlotQuantity { name, axis, of }
}

const SECONDS: PlotQuantity = plotted("time", "time for all form factors, s", |r| Some(r.seconds));
const CPU: PlotQuantity = plotted("cpu-time", "CPU time of all threads, s", |r| {
    Some(r.cpu_seconds)
});
const SAMPLES: PlotQuantity = plotted("samples", "rays or pixels per row", |r| {
    (r.samples > 0.0).then_some(r.samples)
});
const ROW_ERROR: PlotQuantity = plotted("row-error", "mean relative error of a row", |r| {
    r.row_error_mean
});
const B_ERROR: PlotQuantity = plotted("b-error", "mean relative error of B", |r| r.b_error_mean);
const CLOSURE: PlotQuantity = plotted("closure", "row sums' error, RMS", |r| {
    (r.closure_rms > 0.0).then_some(r.closure_rms)
});
const FACETS: PlotQuantity = plotted("facets", "facets", |r| Some(r.facets as f64));
const MEMORY: PlotQuantity = plotted("memory", "peak memory, MiB", |r| {
    r.peak_bytes.map(|b| b as f64 / f64::from(1 << 20))
});
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
        let by_engine = |r: &RunRecord| sweep_name(&rows, r);
        for (y, x) in [
            (&ROW_ERROR, &SECONDS),
            (&ROW_ERROR, &CPU),
            (&B_ERROR, &SECONDS),
            (&B_ERROR, &CPU),
            (&ROW_ERROR, &SAMPLES),
            (&B_ERROR, &SAMPLES),
            (&SECONDS, &SAMPLES),
            (&CPU, &SAMPLES),
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
                (&CPU, &MIRRORS),
                (&ROW_ERROR, &MIRRORS),
                (&B_ERROR, &MIRRORS),
            ]
        } else {
            vec![
                (&SECONDS, &FACETS),
                (&CPU, &FACETS),
                (&MEMORY, &FACETS),
                (&CLOSURE, &FACETS),
            ]
        };
        for (y, x) in pairs {
            figures.push(figure(name, &rows, x, y, |r| r.setting.clone()));
        }
    }
    figures.retain(|f| f.series.iter().any(|s| s.points.len() > 1));
    figures
}

/// The name of the line on which a run lies: that of the engine, with the number of points or the
/// resolution where both vary, of which the one with fewer values tells lines apart.
fn sweep_name(rows: &[&RepeatedRun], run: &RunRecord) -> String {
    let values = |of: fn(&RunRecord) -> Option<u32>| {
        let same = rows.iter().filter(|r| r.run.engine == run.engine);
        let mut values: Vec<u32> = same.filter_map(|r| of(r.run)).collect();
        values.sort_unstable();
        values.dedup();
        values.len()
    };
    let (points, pixels) = (values(|r| r.patch_points), values(|r| r.resolution));
    let with = |n: Option<u32>, what: &str| match n {
        Some(1) => format!("{}, 1 {}", run.engine, what.trim_end_matches('s')),
        Some(n) => format!("{}, {n} {what}", run.engine),
        None => run.engine.clone(),
    };
    if points < 2 || pixels < 2 {
        run.engine.clone()
    } else if points <= pixels {
        with(run.patch_points, "points")
    } else {
        with(run.resolution, "pixels")
    }
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
        // Leave out runs without one of the quantities, and points that a logarithmic axis cannot show.
        let (Some(px), Some(py)) = (row.mean(x.of), row.mean(y.of)) else {
            continue;
        };
        let fits = |axis: ChartAxis, p: f64| p.is_finite() && (p > 0.0 || !axis.is_logarithmic);
        if !fits(x.axis, px) || !fits(y.axis, py) {
            continue;
        }
        // Runs of the same name make one line; lines are in the order of their first runs.
        let name = name(row.run);
        let index = series
            .iter()
            .position(|s| s.name == name)
            .unwrap_or_else(|| {
                series.push(ChartSeries {
                    name,
                    style: SeriesStyle::Marked,
                    points: Vec::new(),
                });
                series.len() - 1
            });
        let spread = |quantity: &PlotQuantity| row.deviation(quantity.of).unwrap_or(0.0);
        series[index].points.push(ChartPoint {
            at: [px, py],
            samples: row.run.samples,
            spread: [spread(x), spread(y)],
        });
    }
    // Order points by samples before x, because times are noisy and would turn lines back.
    for s in &mut series {
        s.points.sort_by(|a, b| {
            let by_x = a.at[0].total_cmp(&b.at[0]);
            a.samples.total_cmp(&b.samples).then(by_x)
        });
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
            cpu_seconds: samples / 50.0,
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
                "box-0-mirrors-row-error-cpu-time",
                "box-0-mirrors-row-error-samples",
                "box-0-mirrors-time-samples",
                "box-0-mirrors-cpu-time-samples",
                "box-time-mirrors",
                "box-cpu-time-mirrors",
                "box-row-error-mirrors"
            ]
        );
        let points: Vec<[f64; 2]> = figures[0].series[0].points.iter().map(|p| p.at).collect();
        assert_eq!(points, [[0.64, 1.0 / 64.0], [2.56, 1.0 / 256.0]]);
        assert!(!figures[0].has_spread());
    }

    /// Repetitions are one point with bars, and every number of points is a line.
    #[test]
    fn sweeps_of_two_parameters_have_a_line_for_each_value() {
        let mut records = Vec::new();
        for (points, pixels, seed) in [(4, 32, 0), (4, 32, 1), (4, 64, 0), (16, 32, 0), (16, 64, 0)]
        {
            let mut record = run("box", None, f64::from(points * pixels));
            if let TaskOutcome::Run(run) = &mut record.outcome {
                run.engine = "hemicube".into();
                run.setting = format!("hemicube, {pixels} pixels, {points} points");
                (run.resolution, run.patch_points) = (Some(pixels), Some(points));
                run.seed = seed;
                run.row_error_mean = Some(0.1 + 0.1 * seed as f64);
            }
            records.push(record);
        }
        let figures = of(&records.iter().collect::<Vec<_>>());
        let names: Vec<&str> = figures[0].series.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["hemicube, 4 points", "hemicube, 16 points"]);
        let first = figures[0].series[0].points[0];
        assert!((first.at[1] - 0.15).abs() < 1e-12 && figures[0].has_spread());
        assert!(
            (first.spread[1] - 0.1 / 2f64.sqrt()).abs() < 1e-12,
            "{first:?}"
        );
    }
}
