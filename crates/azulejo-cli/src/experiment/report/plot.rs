//! Plots as SVG, by the crate `plotters`.

use super::figures::{Axis, Figure, Series};
use plotters::coord::Shift;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;

/// Colours that people with any colour vision tell apart (Okabe and Ito 2008), without those too
/// pale for lines on white; each line has a mark of its own as well.
pub const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(110, 110, 110),
];

/// Text and axes.
pub const INK: RGBColor = RGBColor(32, 33, 36);

/// Lines across.
pub const GRID: RGBColor = RGBColor(218, 220, 224);

/// Height of all of it, and width of all but the legend, pixels.
const SIZE: (u32, u32) = (470, 360);

/// Half the size of a mark, pixels.
const MARK: i32 = 4;

/// Distance from name to name in the legend, pixels.
const LINE: i32 = 22;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Failed = DrawingAreaErrorKind<std::io::Error>;

/// The plot as an SVG document with a transparent ground; the names of its lines stand at its right,
/// where they hide nothing.
pub fn svg(figure: &Figure) -> String {
    let longest = figure.series.iter().map(|s| s.name.chars().count()).max();
    // No fonts are read: a letter of this size is about half as wide as high.
    let legend = 50 + 8 * longest.unwrap_or(0) as u32;
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (SIZE.0 + legend, SIZE.1));
        let (chart, names) = root.into_drawing_area().split_horizontally(SIZE.0);
        // Writing into a string does not fail; a plot that cannot be laid out stays empty.
        let _ = draw(figure, &chart).and_then(|()| explain(&figure.series, &names));
    }
    text
}

fn draw(figure: &Figure, area: &Area) -> Result<(), Failed> {
    let points = || figure.series.iter().flat_map(|s| &s.points);
    let x = Scale::around(points().map(|p| p.0), figure.x);
    let y = Scale::around(points().map(|p| p.1), figure.y);
    let font = ("sans-serif", 14).into_font().color(&INK);
    let title = ("sans-serif", 17).into_font().color(&INK);
    let mut chart = ChartBuilder::on(area)
        .caption(&figure.title, title)
        .margin(10)
        .x_label_area_size(46)
        .y_label_area_size(72)
        .build_cartesian_2d(x, y)?;
    chart
        .configure_mesh()
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .axis_style(INK)
        .label_style(font.clone())
        .axis_desc_style(font)
        .x_desc(figure.x.label)
        .y_desc(figure.y.label)
        .draw()?;
    for (k, Series { points, .. }) in figure.series.iter().enumerate() {
        let color = COLORS[k % COLORS.len()];
        let line = LineSeries::new(points.iter().copied(), color.stroke_width(2));
        chart.draw_series(line)?;
        for &point in points {
            mark(chart.plotting_area(), k, point)?;
        }
    }
    Ok(())
}

/// The marks and names of the lines.
fn explain(series: &[Series], area: &Area) -> Result<(), Failed> {
    let font = ("sans-serif", 14).into_font().color(&INK);
    let font = font.pos(Pos::new(HPos::Left, VPos::Center));
    for (k, Series { name, .. }) in series.iter().enumerate() {
        let y = 50 + LINE * k as i32;
        let line = vec![(6, y), (34, y)];
        area.draw(&PathElement::new(
            line,
            COLORS[k % COLORS.len()].stroke_width(2),
        ))?;
        mark(area, k, (20, y))?;
        area.draw(&Text::new(name.clone(), (42, y), font.clone()))?;
    }
    Ok(())
}

/// The mark of the k-th line.
fn mark<'a, C: CoordTranslate>(
    area: &DrawingArea<SVGBackend<'a>, C>,
    k: usize,
    at: C::From,
) -> Result<(), Failed>
where
    C::From: Clone + 'static,
{
    let style = COLORS[k % COLORS.len()].filled();
    match k % 4 {
        0 => area.draw(&Circle::new(at, MARK, style)),
        1 => area.draw(&TriangleMarker::new(at, MARK + 2, style)),
        2 => {
            let square = Rectangle::new([(-MARK, -MARK), (MARK, MARK)], style);
            area.draw(&(EmptyElement::at(at) + square))
        }
        _ => area.draw(&Cross::new(at, MARK, style.stroke_width(2))),
    }
}

/// An axis with its range: one type for both kinds.
struct Scale {
    range: Range<f64>,
    is_logarithmic: bool,
}

impl Scale {
    /// A range a little larger than the values.
    fn around(values: impl Iterator<Item = f64>, axis: Axis) -> Scale {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
            (a.min(v), b.max(v))
        });
        let range = match axis.is_logarithmic {
            // At least a factor of 4, so that there is a number to read.
            true => {
                let missing = (2.0 / (high / low).sqrt()).max(1.25);
                low / missing..high * missing
            }
            false => low - 0.04 * (high - low).max(1.0)..high + 0.04 * (high - low).max(1.0),
        };
        Scale {
            range,
            is_logarithmic: axis.is_logarithmic,
        }
    }

    /// Where a value stands on the axis, 0 to 1.
    fn share(&self, value: f64) -> f64 {
        let place = |v: f64| if self.is_logarithmic { v.ln() } else { v };
        let (low, high) = (place(self.range.start), place(self.range.end));
        (place(value) - low) / (high - low)
    }

    /// Round values to be labelled.
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
            let first = (low.max(0.0) / step).ceil() as i64;
            let last = (high / step).floor() as i64;
            return (first..=last).map(|k| k as f64 * step).collect();
        }
        let decades = low.log10().floor() as i32..=high.log10().ceil() as i32;
        let at = |steps: &[f64]| -> Vec<f64> {
            let all = decades
                .clone()
                .flat_map(|d| steps.iter().map(move |s| s * 10f64.powi(d)));
            all.filter(|v| (low..=high).contains(v)).collect()
        };
        let enough = steps.iter().map(|s| at(s)).find(|ticks| ticks.len() >= 3);
        enough.unwrap_or_else(|| at(steps[steps.len() - 1]))
    }
}

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let length = f64::from(limit.1 - limit.0);
        limit.0 + (self.share(*value) * length).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks()
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

impl ValueFormatter<f64> for Scale {
    fn format_ext(&self, value: &f64) -> String {
        label(*value)
    }
}

/// A tick: plain where that is short, else a power of ten.
fn label(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude == 0.0 || (1e-2..1e5).contains(&magnitude) {
        let text = format!("{value:.3}");
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    let power = magnitude.log10().floor() as i32;
    let digits = value / 10f64.powi(power);
    let exponent: String = power.to_string().chars().map(superscript).collect();
    match (digits - 1.0).abs() < 1e-9 {
        true => format!("10{exponent}"),
        false => format!("{digits:.0}·10{exponent}"),
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

    fn scale(low: f64, high: f64, is_logarithmic: bool) -> Scale {
        Scale {
            range: low..high,
            is_logarithmic,
        }
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(scale(0.5, 2000.0, true).ticks(), [1.0, 10.0, 100.0, 1000.0]);
        assert_eq!(scale(0.9, 6.0, true).ticks(), [1.0, 2.0, 5.0]);
        assert_eq!(scale(-2.0, 66.0, false).ticks(), [0.0, 20.0, 40.0, 60.0]);
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
    fn a_plot_shows_its_lines() {
        let axis = |label, is_logarithmic| Axis {
            label,
            is_logarithmic,
        };
        let series = |name: &str| Series {
            name: name.into(),
            points: vec![(1.0, 1e-3), (100.0, 1e-5)],
        };
        let figure = Figure {
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
        ] {
            assert!(svg.contains(part), "{part} is not in {svg}");
        }
    }
}
