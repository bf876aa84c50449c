//! Charts of reports, and the style of their pages.

mod draw;
mod report_page;

pub use draw::svg;
pub use report_page::{machine_table, page_head, plots, write_report};

use crate::drawing::{COLORS, Color, GRID, INK, hex};
use std::fmt;

/// The style sheet of pages, light or dark as the reader's system.
const STYLE: &str = include_str!("style.css");

/// The style sheet, with rules that replace the colours of inline plots by those of the page. Lines of
/// plots are paler in the dark.
fn page_style() -> String {
    let rule = |color: Color, value: &str| {
        let color = hex(color);
        let attribute_rule =
            |name: &str| format!("figure svg [{name}=\"{color}\"] {{ {name}: {value}; }}\n");
        attribute_rule("fill") + &attribute_rule("stroke")
    };
    let lines = COLORS.iter().enumerate();
    let lines: String = lines
        .map(|(k, c)| rule(*c, &format!("var(--line{k})")))
        .collect();
    STYLE.to_owned() + &lines + &rule(INK, "currentColor") + &rule(GRID, "var(--grid)")
}

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
    /// How it is drawn.
    pub style: SeriesStyle,
    /// Its points, by samples and then by x: times are noisy, and would turn lines back.
    pub points: Vec<ChartPoint>,
}

/// What is drawn of a series.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SeriesStyle {
    /// A line with a marker at each point.
    #[default]
    Marked,
    /// The line alone.
    Line,
    /// The markers alone.
    Points,
}

/// A point of a line: the mean of the repetitions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChartPoint {
    /// x and y.
    pub at: [f64; 2],
    /// Rays or pixels per row.
    pub samples: f64,
    /// Standard deviations of x and y between the repetitions; 0 for a single one.
    pub spread: [f64; 2],
}

/// The exponent of the growth of y with x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    /// The exponent.
    pub exponent: f64,
    /// Its standard error, from the scatter about the line; `None` for two points.
    pub error: Option<f64>,
}

impl ChartSpec {
    /// The growth along a line; `None` where an axis is not logarithmic, or for one point.
    pub fn growth(&self, series: &ChartSeries) -> Option<Growth> {
        let is_power = self.x.is_logarithmic && self.y.is_logarithmic;
        let points: Vec<[f64; 2]> = series.points.iter().map(|p| p.at).collect();
        let is_line = series.style == SeriesStyle::Marked;
        growth(&points).filter(|_| is_power && is_line)
    }

    /// Whether any point is a mean of several repetitions.
    pub fn has_spread(&self) -> bool {
        let mut points = self.series.iter().flat_map(|s| &s.points);
        points.any(|p| p.spread != [0.0; 2])
    }
}

/// `−0.58 ± 0.02`
impl fmt::Display for Growth {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let sign = if self.exponent < 0.0 { "−" } else { "" };
        write!(f, "{sign}{:.2}", self.exponent.abs())?;
        match self.error {
            Some(error) => write!(f, " ± {error:.2}"),
            None => Ok(()),
        }
    }
}

/// The exponent of the growth of y with x, by least squares of the logarithms, each point as good as
/// any other; `None` for one point, or where all x are the same.
fn growth(points: &[[f64; 2]]) -> Option<Growth> {
    let n = points.len() as f64;
    let logs: Vec<[f64; 2]> = points.iter().map(|p| p.map(f64::ln)).collect();
    let mean = |axis: usize| logs.iter().map(|p| p[axis]).sum::<f64>() / n;
    let (mx, my) = (mean(0), mean(1));
    let across: f64 = logs.iter().map(|[x, y]| (x - mx) * (y - my)).sum();
    let along: f64 = logs.iter().map(|[x, _]| (x - mx).powi(2)).sum();
    let exponent = across / along;
    let residual = |[x, y]: &[f64; 2]| (y - my - exponent * (x - mx)).powi(2);
    let residuals: f64 = logs.iter().map(residual).sum();
    let error = (residuals / (n - 2.0) / along).sqrt();
    (along > 1e-9).then_some(Growth {
        exponent,
        error: (points.len() > 2).then_some(error),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plots_follow_the_page() {
        let rules = page_style();
        assert!(rules.contains("figure svg [stroke=\"#0072b2\"] { stroke: var(--line0); }"));
        assert!(rules.contains("figure svg [fill=\"#202124\"] { fill: currentColor; }"));
    }

    #[test]
    fn growth_is_the_slope() {
        let points = [10.0f64, 100.0, 1000.0].map(|x| [x, 3.0 * x.powf(1.7)]);
        let exact = growth(&points).unwrap();
        assert!((exact.exponent - 1.7).abs() < 1e-12 && exact.error.unwrap() < 1e-12);
        assert_eq!(growth(&points[..1]), None);
        assert_eq!(growth(&points[..2]).unwrap().error, None);
        // Residuals of the logarithms −d, 2d, −d over three decades: SE = √6 d / √(2 ln² 10).
        let d = 0.1f64;
        let bent = [
            [1.0, (-d).exp()],
            [10.0, (2.0 * d).exp()],
            [100.0, (-d).exp()],
        ];
        let bent = growth(&bent).unwrap();
        let expected = 6f64.sqrt() * d / (2f64.sqrt() * 10f64.ln());
        assert!(bent.exponent.abs() < 1e-12);
        assert!((bent.error.unwrap() - expected).abs() < 1e-12, "{bent:?}");
        assert_eq!(bent.to_string(), "0.00 ± 0.08");
    }
}
