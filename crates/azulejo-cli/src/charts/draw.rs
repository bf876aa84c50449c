//! Line charts.

use super::{ChartAxis, ChartPoint, ChartSeries, ChartSpec, SeriesStyle};
use crate::drawing::{COLORS, Drawing, GRID, INK, TextAnchor};
use glam::DVec2;
use std::ops::Range;

/// Width without the legend, and height.
const SIZE: DVec2 = DVec2::new(470.0, 360.0);

/// Corners of the area between the axes.
const AREA: [DVec2; 2] = [DVec2::new(82.0, 40.0), DVec2::new(460.0, 304.0)];

const FONT_SIZE: f64 = 12.0;

/// Distance of a baseline below the middle of its letters.
const BASELINE: f64 = 0.35 * FONT_SIZE;

/// Half the size of a marker.
const MARKER: f64 = 4.0;

/// Line spacing of the legend.
const LEGEND_LINE: f64 = 22.0;

/// Distance of an entry's second line.
const LEGEND_SECOND: f64 = 15.0;

/// The first line of the legend.
const LEGEND_TOP: f64 = 50.0;

/// Half the width of the ends of error bars.
const BAR_END: f64 = 3.0;

/// Size of secondary text.
const SMALL: f64 = 11.0;

/// The chart as an SVG document on a transparent background, with the legend at its right.
pub fn svg(figure: &ChartSpec) -> String {
    drawing(figure).svg()
}

fn drawing(figure: &ChartSpec) -> Drawing {
    let entries: Vec<LegendEntry> = figure.series.iter().map(|s| entry(figure, s)).collect();
    let lines = entries.iter().flat_map(|e| [&e.name, &e.growth]);
    let longest = lines.map(|line| line.chars().count()).max();
    // The width of the text is estimated: the reader's font is not known.
    let legend = 50.0 + 7.0 * longest.unwrap_or(0) as f64;
    let rows: f64 = entries.iter().map(LegendEntry::height).sum();
    let height = SIZE.y.max(LEGEND_TOP + rows);
    let mut drawing = Drawing::transparent(SIZE.x + legend, height);
    let chart = ChartArea::new(figure);
    chart.axes(figure, &mut drawing);
    for (k, ChartSeries { points, style, .. }) in figure.series.iter().enumerate() {
        for point in points {
            chart.bars(point, color(k), &mut drawing);
        }
        let points: Vec<DVec2> = points.iter().map(|p| chart.at(p.at)).collect();
        if *style != SeriesStyle::Points {
            drawing.line(points.clone(), color(k), 2.0);
        }
        if *style != SeriesStyle::Line {
            points
                .into_iter()
                .for_each(|at| marker(k, at, &mut drawing));
        }
    }
    draw_legend(&entries, &mut drawing);
    drawing
}

/// Both axes of a chart.
struct ChartArea {
    x: AxisScale,
    y: AxisScale,
}

impl ChartArea {
    fn new(figure: &ChartSpec) -> ChartArea {
        let points = || figure.series.iter().flat_map(|s| &s.points);
        let values = |axis: usize| {
            points()
                .flat_map(move |p| bar(p, axis))
                .chain(points().map(move |p| p.at[axis]))
        };
        let shown = |axis: ChartAxis| move |v: &f64| *v > 0.0 || !axis.is_logarithmic;
        ChartArea {
            x: AxisScale::around(values(0).filter(shown(figure.x)), figure.x),
            y: AxisScale::around(values(1).filter(shown(figure.y)), figure.y),
        }
    }

    /// Bars of one standard deviation to either side, where there are several repetitions. A bar that
    /// reaches below zero on a logarithmic axis ends at the chart's edge.
    fn bars(&self, point: &ChartPoint, color: [u8; 3], drawing: &mut Drawing) {
        for (axis, scale) in [&self.x, &self.y].into_iter().enumerate() {
            if point.spread[axis] <= 0.0 {
                continue;
            }
            let ends = bar(point, axis).map(|v| v.max(scale.range.start));
            let ends = ends.map(|value| {
                let mut at = point.at;
                at[axis] = value;
                self.at(at)
            });
            let across = BAR_END * if axis == 0 { DVec2::Y } else { DVec2::X };
            drawing.line(ends.to_vec(), color, 1.0);
            for end in ends {
                drawing.line(vec![end - across, end + across], color, 1.0);
            }
        }
    }

    /// Position of a pair of values.
    fn at(&self, [x, y]: [f64; 2]) -> DVec2 {
        let share = DVec2::new(self.x.share(x), 1.0 - self.y.share(y));
        AREA[0] + share * (AREA[1] - AREA[0])
    }

    /// Grid, axes, tick labels and titles.
    fn axes(&self, figure: &ChartSpec, drawing: &mut Drawing) {
        let [low, high] = AREA;
        let middle = 0.5 * (low + high);
        let (end, center) = (TextAnchor::End, TextAnchor::Middle);
        for tick in self.x.ticks() {
            let x = self.at([tick, 1.0]).x;
            let foot = DVec2::new(x, high.y);
            drawing.line(vec![DVec2::new(x, low.y), foot], GRID, 1.0);
            drawing.line(vec![foot, foot + 5.0 * DVec2::Y], INK, 1.0);
            drawing.text(foot + 18.0 * DVec2::Y, center, FONT_SIZE, INK, &label(tick));
        }
        for tick in self.y.ticks() {
            let foot = DVec2::new(low.x, self.at([1.0, tick]).y);
            drawing.line(vec![foot, foot.with_x(high.x)], GRID, 1.0);
            drawing.line(vec![foot - 5.0 * DVec2::X, foot], INK, 1.0);
            let at = foot + DVec2::new(-9.0, BASELINE);
            drawing.text(at, end, FONT_SIZE, INK, &label(tick));
        }
        drawing.line(vec![low, low.with_y(high.y), high], INK, 1.0);
        let at = DVec2::new(middle.x, SIZE.y - 14.0);
        drawing.text(at, center, FONT_SIZE, INK, figure.x.label);
        drawing.vertical_text(DVec2::new(22.0, middle.y), FONT_SIZE, INK, figure.y.label);
        let at = DVec2::new(middle.x, 26.0);
        drawing.text(at, center, 15.0, INK, &figure.title);
    }
}

fn color(series: usize) -> [u8; 3] {
    COLORS[series % COLORS.len()]
}

/// The ends of a point's error bar along an axis.
fn bar(point: &ChartPoint, axis: usize) -> [f64; 2] {
    let (middle, spread) = (point.at[axis], point.spread[axis]);
    [middle - spread, middle + spread]
}

/// A series in the legend.
struct LegendEntry {
    name: String,
    style: SeriesStyle,
    /// The growth along the line; empty if there is none.
    growth: String,
}

impl LegendEntry {
    fn height(&self) -> f64 {
        let lines = if self.growth.is_empty() { 0.0 } else { 1.0 };
        LEGEND_LINE + lines * LEGEND_SECOND
    }
}

fn entry(figure: &ChartSpec, series: &ChartSeries) -> LegendEntry {
    let growth = figure.growth(series);
    LegendEntry {
        name: series.name.clone(),
        style: series.style,
        growth: growth.map_or(String::new(), |g| format!("slope {g}")),
    }
}

/// Markers, names and slopes of the series.
fn draw_legend(entries: &[LegendEntry], drawing: &mut Drawing) {
    let mut y = LEGEND_TOP;
    for (k, entry) in entries.iter().enumerate() {
        let start = DVec2::new(SIZE.x + 6.0, y);
        if entry.style != SeriesStyle::Points {
            drawing.line(vec![start, start + 28.0 * DVec2::X], color(k), 2.0);
        }
        if entry.style != SeriesStyle::Line {
            marker(k, start + 14.0 * DVec2::X, drawing);
        }
        let at = start + DVec2::new(36.0, BASELINE);
        drawing.text(at, TextAnchor::Start, FONT_SIZE, INK, &entry.name);
        if !entry.growth.is_empty() {
            let at = at + LEGEND_SECOND * DVec2::Y;
            drawing.text(at, TextAnchor::Start, SMALL, INK, &entry.growth);
        }
        y += entry.height();
    }
}

/// The marker of a series: colour is not the only difference between lines.
fn marker(series: usize, at: DVec2, drawing: &mut Drawing) {
    let color = color(series);
    let offset = |x: f64, y: f64| at + MARKER * DVec2::new(x, y);
    match series % 4 {
        0 => drawing.disk(at, 1.1 * MARKER, color),
        1 => {
            let corners = [offset(0.0, -1.5), offset(1.3, 0.9), offset(-1.3, 0.9)];
            drawing.polygon(corners.to_vec(), color);
        }
        2 => {
            let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
            drawing.polygon(corners.map(|(x, y)| offset(x, y)).to_vec(), color);
        }
        _ => {
            for slope in [-1.0, 1.0] {
                let ends = [offset(-1.0, -slope), offset(1.0, slope)];
                drawing.line(ends.to_vec(), color, 2.0);
            }
        }
    }
}

/// The range of an axis.
struct AxisScale {
    range: Range<f64>,
    is_logarithmic: bool,
}

impl AxisScale {
    /// A range slightly larger than that of the values.
    fn around(values: impl Iterator<Item = f64>, axis: ChartAxis) -> AxisScale {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
            (a.min(v), b.max(v))
        });
        let range = if axis.is_logarithmic {
            // At least a factor of 4, so that there are ticks.
            let missing = (2.0 / (high / low).sqrt()).max(1.25);
            low / missing..high * missing
        } else {
            let margin = 0.04 * (high - low).max(1.0);
            low - margin..high + margin
        };
        AxisScale {
            range,
            is_logarithmic: axis.is_logarithmic,
        }
    }

    /// Position of a value along the axis, 0 to 1.
    fn share(&self, value: f64) -> f64 {
        let position = |v: f64| if self.is_logarithmic { v.ln() } else { v };
        let (low, high) = (position(self.range.start), position(self.range.end));
        (position(value) - low) / (high - low)
    }

    /// Round values to label.
    fn ticks(&self) -> Vec<f64> {
        let steps: &[&[f64]] = &[
            &[1.0],
            &[1.0, 3.0],
            &[1.0, 2.0, 5.0],
            &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0],
        ];
        let (low, high) = (self.range.start, self.range.end);
        if !self.is_logarithmic {
            let rough = (high - low) / 6.0;
            let power = 10f64.powf(rough.log10().floor());
            let step = [1.0, 2.0, 5.0, 10.0]
                .map(|s| s * power)
                .into_iter()
                .find(|s| *s >= rough);
            let step = step.unwrap_or(rough);
            let first = (low / step).ceil() as i64;
            let last = (high / step).floor() as i64;
            return (first..=last).map(|k| k as f64 * step).collect();
        }
        let decades = low.log10().floor() as i32..=high.log10().ceil() as i32;
        let at = |steps: &[f64]| -> Vec<f64> {
            let values = decades
                .clone()
                .flat_map(|d| steps.iter().map(move |s| s * 10f64.powi(d)));
            values.filter(|v| (low..=high).contains(v)).collect()
        };
        let enough = steps.iter().map(|s| at(s)).find(|ticks| ticks.len() >= 3);
        enough.unwrap_or_else(|| at(steps[steps.len() - 1]))
    }
}

/// Label of a tick: plain if that is short, otherwise with a power of ten.
fn label(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude == 0.0 || (1e-2..1e5).contains(&magnitude) {
        let text = format!("{value:.3}");
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    let power = magnitude.log10().floor() as i32;
    let digits = value / 10f64.powi(power);
    let exponent: String = power.to_string().chars().map(superscript).collect();
    if (digits - 1.0).abs() < 1e-9 {
        format!("10{exponent}")
    } else {
        format!("{digits:.0}·10{exponent}")
    }
}

fn superscript(c: char) -> char {
    match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '0'..='9' => char::from_u32(0x2070 + (c as u32 - 0x30)).unwrap_or(c),
        _ => c,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scale(low: f64, high: f64, is_logarithmic: bool) -> AxisScale {
        AxisScale {
            range: low..high,
            is_logarithmic,
        }
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(scale(0.5, 2000.0, true).ticks(), [1.0, 10.0, 100.0, 1000.0]);
        assert_eq!(scale(0.9, 6.0, true).ticks(), [1.0, 2.0, 5.0]);
        assert_eq!(scale(-2.0, 66.0, false).ticks(), [0.0, 20.0, 40.0, 60.0]);
        assert_eq!(scale(-4.2, 4.2, false).ticks(), [-4.0, -2.0, 0.0, 2.0, 4.0]);
        for (x, want) in [
            (0.05, "0.05"),
            (1.0, "1"),
            (1e-4, "10⁻⁴"),
            (3e-12, "3·10⁻¹²"),
            (20_000.0, "20000"),
            (1e6, "10⁶"),
        ] {
            assert_eq!(label(x), want);
        }
    }

    #[test]
    fn a_chart_shows_its_series() {
        let axis = |label, is_logarithmic| ChartAxis {
            label,
            is_logarithmic,
        };
        let series = |name: &str| ChartSeries {
            name: name.into(),
            style: SeriesStyle::Marked,
            points: [[1.0, 1e-3], [10.0, 1e-4], [100.0, 1e-5]]
                .map(|at| ChartPoint {
                    at,
                    samples: 0.0,
                    spread: [0.0, 0.5 * at[1]],
                })
                .to_vec(),
        };
        let figure = ChartSpec {
            name: "f".into(),
            title: "a <title>".into(),
            x: axis("time, s", true),
            y: axis("error", true),
            series: ["one", "two", "three", "four", "five"].map(series).to_vec(),
        };
        let svg = svg(&figure);
        for part in [
            "a &lt;title&gt;",
            "time, s",
            "error",
            "one",
            "five",
            "<circle",
            "<polyline",
            "10⁻⁴",
            "slope −1.00 ± 0.00",
        ] {
            assert!(svg.contains(part), "{part} is not in {svg}");
        }
        // Two axes and five lines in the legend; a line, and three bars with two ends each.
        let lines = svg.matches("stroke-width=\"1\"").count();
        assert!(lines >= 5 * 9, "{lines} thin lines");
    }
}
