//! Plots of the convergence.

use super::super::colors::lines;
use super::super::panel_context::PanelContext;
use super::percent;
use super::series::ConvergenceCurves;
use crate::ui::help::{self, HelpTerm};
use crate::ui::viewport::number;
use azulejo::trace::Measure;
use azulejo::trace::time::Instant;
use egui::{Color32, Grid, Ui, WidgetInfo};
use egui_plot::{
    Corner, GridInput, GridMark, HLine, HoverPosition, Legend, Line, LineStyle, Plot, PlotPoints,
    PlotUi,
};

/// Draws the latest measures as numbers, and all of them as curves.
pub fn show(ui: &mut Ui, cx: &PanelContext) {
    let lighting = &cx.app.lighting;
    let began = lighting.began.unwrap_or_else(Instant::now);
    let curves = ConvergenceCurves::new(&lighting.measures, began);
    numbers(ui, cx);
    if !curves.residuals.is_empty() {
        residuals(ui, cx, &curves);
    }
    if !curves.errors.is_empty() || !curves.patch_errors.is_empty() {
        errors(ui, cx, &curves);
    }
}

/// The latest measures as numbers.
fn numbers(ui: &mut Ui, cx: &PanelContext) {
    let lighting = &cx.app.lighting;
    let measures = || lighting.measures.iter().rev().map(|m| m.measure);
    let residual = measures().find_map(|m| match m {
        Measure::Residual {
            iteration, value, ..
        } => Some((iteration, value)),
        _ => None,
    });
    let error = measures().find_map(|m| match m {
        Measure::Error(value) => Some(value),
        _ => None,
    });
    Grid::new("last measures").num_columns(2).show(ui, |ui| {
        if let Some((iteration, value)) = residual {
            let after = cx.tr("at bounce");
            let value = format!("{} {after} {iteration}", number(value));
            ui.horizontal(|ui| {
                ui.label(cx.tr("Remaining light (residual)"));
                help::mark(ui, cx.language, HelpTerm::Residual);
            });
            ui.add(egui::Label::new(value).wrap());
            ui.end_row();
        }
        if let Some(error) = error {
            let aim = percent(lighting.settings.error);
            let value = format!("{}, {} {aim}", percent(error), cx.tr("target"));
            super::row(ui, cx.tr("Estimated error"), "", value);
        }
    });
}

fn residuals(ui: &mut Ui, cx: &PanelContext, curves: &ConvergenceCurves) {
    let colors = lines(ui);
    let (replicate, bounces) = (cx.tr("estimate"), cx.tr("bounces"));
    let title = cx.tr("Residual against bounces");
    ui.horizontal(|ui| {
        ui.weak(title);
        help::mark(ui, cx.language, HelpTerm::Replicate);
    });
    let ys = curves.residuals.iter().flat_map(|c| &c.points);
    let plot = framed("residuals", Corner::RightTop, ys.map(|p| p[1]))
        .x_axis_label(bounces)
        .x_grid_spacer(whole)
        .x_axis_formatter(|mark, _| format!("{:.0}", mark.value))
        .y_axis_formatter(|mark, _| short(mark.value))
        .label_formatter(|at| {
            near(at)
                .map(|(name, [x, y])| format!("{name}: {:.2e}, {x:.0} {bounces}", 10f64.powf(y)))
        });
    let shown = plot.show(ui, |plot| {
        for (k, curve) in curves.residuals.iter().enumerate() {
            let color = colors[curve.replicate as usize % colors.len()];
            let name = format!("{replicate} {}", curve.replicate + 1);
            let line = Line::new(name, PlotPoints::from(curve.points.clone()));
            plot.line(
                line.id(k)
                    .color(faded(color, curve.is_superseded))
                    .width(1.8),
            );
        }
    });
    shown
        .response
        .widget_info(|| WidgetInfo::labeled(egui::Role::Image, true, title));
}

fn errors(ui: &mut Ui, cx: &PanelContext, curves: &ConvergenceCurves) {
    let title = cx.tr("Estimated error against time");
    ui.weak(title);
    let [blue, orange, ..] = lines(ui);
    let ink = ui.visuals().strong_text_color();
    // Errors and times are logarithms; the range of the plot includes the target.
    let aim = cx.app.lighting.settings.error.max(1e-9).log10();
    let ys = curves.errors.iter().chain(&curves.patch_errors);
    // Errors are shares: as percentages they are two decades larger.
    let plot = framed("errors", Corner::RightBottom, ys.map(|p| p[1]).chain([aim]));
    let plot = error_and_seconds(plot, cx);
    let (of_light, of_patches) = (cx.tr("irradiance"), cx.tr("patches"));
    let aimed = cx.tr("target");
    let shown = plot.show(ui, |plot| {
        let line = HLine::new(aimed, aim)
            .color(ink.gamma_multiply(0.7))
            .width(1.2);
        plot.hline(line.style(LineStyle::dashed_loose()).allow_hover(false));
        let curves = [
            (of_patches, &curves.patch_errors, orange),
            (of_light, &curves.errors, blue),
        ];
        for (name, points, color) in curves {
            curve(plot, name, points, color);
        }
    });
    // To a screen reader the plot is an image with a title.
    shown
        .response
        .widget_info(|| WidgetInfo::labeled(egui::Role::Image, true, title));
}

/// Relative error against seconds, both by their logarithms: the axes of a plot, and what is said about a point.
pub(super) fn error_and_seconds<'a>(plot: Plot<'a>, cx: &PanelContext) -> Plot<'a> {
    // Errors are shares: as percentages they are two decades larger.
    plot.x_axis_label(cx.tr("seconds"))
        .x_grid_spacer(decades)
        .x_axis_formatter(|mark, _| plain(mark.value))
        .y_axis_formatter(|mark, _| format!("{} %", plain(mark.value + 2.0)))
        .label_formatter(|at| {
            let (name, [x, y]) = near(at)?;
            Some(format!(
                "{name}: {}, {} s",
                percent(10f64.powf(y)),
                number(10f64.powf(x))
            ))
        })
}

/// Draws a curve; a line through a single point would be invisible.
pub(super) fn curve(plot: &mut PlotUi, name: &str, points: &[[f64; 2]], color: Color32) {
    if let [_] = points {
        let dot = egui_plot::Points::new(name, PlotPoints::from(points.to_vec()));
        plot.points(dot.color(color).radius(3.0));
    } else if !points.is_empty() {
        let line = Line::new(name, PlotPoints::from(points.to_vec()));
        plot.line(line.color(color).width(1.8));
    }
}

/// A fixed plot whose range is rounded to whole decades.
pub(super) fn framed<'a>(name: &str, legend: Corner, ys: impl Iterator<Item = f64>) -> Plot<'a> {
    let (low, high) = ys.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| {
        (low.min(y), high.max(y))
    });
    Plot::new(name.to_owned())
        .height(150.0)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .include_y((low - 0.05).floor())
        .include_y((high + 0.05).ceil())
        .y_grid_spacer(decades)
        .y_axis_min_width(38.0)
        .show_x(false)
        .show_y(false)
        .legend(
            Legend::default()
                .position(legend)
                .text_style(egui::TextStyle::Small)
                .background_alpha(0.6),
        )
}

fn faded(color: Color32, is_superseded: bool) -> Color32 {
    if is_superseded {
        color.gamma_multiply(0.45)
    } else {
        color
    }
}

/// Grid marks at powers of ten, few enough for their labels; also at 2 and 5 times those where
/// there is space.
fn decades(input: GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    // Logarithms of finite numbers lie within this range.
    let (low, high) = (low.max(-330.0), high.min(330.0));
    let mark = |value: f64, step_size: f64| GridMark { value, step_size };
    let step = ((high - low) / 4.0).ceil().max(1.0);
    let mut marks = Vec::new();
    let mut decade = (low / step).floor() * step;
    while decade <= high {
        marks.push(mark(decade, step));
        if high - low < 2.5 {
            marks.extend([2.0, 5.0].map(|f: f64| mark(decade + f.log10(), 0.3)));
        }
        decade += step;
    }
    marks.retain(|m| (low..=high).contains(&m.value));
    marks
}

/// Grid marks at whole numbers, at most a dozen.
fn whole(input: GridInput) -> Vec<GridMark> {
    let (low, high) = (input.bounds.0.max(0.0), input.bounds.1.min(1e9));
    let rough = ((high - low) / 12.0).max(1.0);
    let power = 10f64.powf(rough.log10().floor());
    let nice = [1.0, 2.0, 5.0, 10.0].into_iter().map(|f| f * power);
    let step = nice.into_iter().find(|s| *s >= rough).unwrap_or(rough);
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    let value = |k: i64| GridMark {
        value: k as f64 * step,
        step_size: step,
    };
    (first..=last).map(value).collect()
}

/// 10^`exponent` in scientific notation: "1e-3", "2e-3".
fn short(exponent: f64) -> String {
    format!("{:.0e}", 10f64.powf(exponent))
}

/// 10^`exponent` in decimal notation.
fn plain(exponent: f64) -> String {
    match exponent {
        e if (-3.5..=4.5).contains(&e) => {
            let digits = (-(e + 1e-9).floor()).max(0.0) as usize;
            format!("{:.digits$}", 10f64.powf(e))
        }
        e => short(e),
    }
}

fn near<'a>(at: &HoverPosition<'a>) -> Option<(&'a str, [f64; 2])> {
    match at {
        HoverPosition::NearDataPoint {
            plot_name,
            position,
            ..
        } => Some((plot_name, [position.x, position.y])),
        HoverPosition::Elsewhere { .. } => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_words_that_people_use() {
        for (exponent, power, words) in [
            (-3.0, "1e-3", "0.001"),
            (-1.0, "1e-1", "0.1"),
            (0.0, "1e0", "1"),
            (2f64.log10(), "2e0", "2"),
            (0.05f64.log10(), "5e-2", "0.05"),
            (2.0, "1e2", "100"),
            (6.0, "1e6", "1e6"),
        ] {
            assert_eq!((&*short(exponent), &*plain(exponent)), (power, words));
        }
    }

    #[test]
    fn marks_are_few_whatever_the_range() {
        let bounds = [(0.0, 0.0), (-1.0, 1.0), (-5.0, 3.0), (0.0, 1e6)];
        let wild = [(f64::NEG_INFINITY, f64::INFINITY), (f64::NAN, f64::NAN)];
        for bounds in bounds.into_iter().chain(wild) {
            let input = || GridInput {
                bounds,
                base_step_size: 1.0,
            };
            assert!(decades(input()).len() < 12, "{bounds:?}");
            assert!(whole(input()).len() < 20, "{bounds:?}");
        }
    }
}
