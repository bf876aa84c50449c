//! Albedo as a function of the angle of incidence.

use super::lobes::AlbedoCurve;
use super::theme::{brightness, channels, grid, short};
use crate::words::Language;
use azulejo::scene::Rgb;
use egui::{Color32, Ui};
use egui_plot::{GridMark, HLine, HoverPosition, Line, LineStyle, Plot, PlotPoints, PlotUi};

/// Channels that differ by less are drawn as one line.
const MERGE_TOLERANCE: f64 = 0.005;

/// Draws the curves of one model, or of two: the second is dashed.
pub(super) fn draw(ui: &mut Ui, language: Language, curves: &[&AlbedoCurve]) {
    // The axis ends above 1, or higher for models that create energy, within limits.
    let values = curves
        .iter()
        .flat_map(|c| c.iter().map(|p| p.1.max_channel()));
    let most = 1.08 * values.fold(1.0, f64::max).min(8.0);
    let (colors, ink, line) = (channels(ui), ui.visuals().strong_text_color(), grid(ui));
    // Mark multiples of 15°: the default grid of the plot is decimal.
    let angles = |_: egui_plot::GridInput| {
        let mark = |k: i32| GridMark {
            value: f64::from(15 * k),
            step_size: 30.0,
        };
        (0..=6).map(mark).collect()
    };
    let plot = Plot::new("albedo")
        .height(130.0)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .set_margin_fraction(egui::Vec2::ZERO)
        .include_x(0.0)
        .include_x(93.0)
        .include_y(0.0)
        .include_y(most)
        .grid_color(line)
        .x_grid_spacer(angles)
        .y_grid_spacer(move |_| shares(most))
        .x_axis_formatter(|mark, _| format!("{:.0}°", mark.value))
        .y_axis_formatter(|mark, _| short(mark.value))
        .show_x(false)
        .show_y(false)
        .label_formatter(words);
    let shown = plot.show(ui, |plot| {
        // The dashed line is perfect reflection, which no physical albedo exceeds.
        let full = HLine::new("", 1.0)
            .color(ink.gamma_multiply(0.6))
            .width(1.0);
        plot.hline(full.style(LineStyle::dashed_loose()).allow_hover(false));
        for (curve, is_dashed) in curves.iter().zip([false, true]) {
            lines(plot, curve, is_dashed, colors, ink);
        }
    });
    // To a screen reader the plot is an image with a title.
    let words = language.tr("Albedo as a function of the angle of incidence");
    let info = || egui::WidgetInfo::labeled(egui::accesskit::Role::Image, true, words);
    shown.response.widget_info(info);
}

/// Grid marks of the albedo: a few round values.
fn shares(most: f64) -> Vec<GridMark> {
    let step = if most > 3.0 { 1.0 } else { 0.25 };
    let count = (most / step) as i32;
    let mark = |k: i32| GridMark {
        value: f64::from(k) * step,
        step_size: 2.0 * step,
    };
    (0..=count).map(mark).collect()
}

/// One line, or three where the channels differ.
fn lines(
    plot: &mut PlotUi,
    curve: &AlbedoCurve,
    is_dashed: bool,
    colors: [Color32; 3],
    ink: Color32,
) {
    let is_colored =
        |(_, a): &(f64, Rgb)| (0..3).any(|c| (a[c] - a.mean()).abs() > MERGE_TOLERANCE);
    let mut line = |name: &str, color: Color32, width: f32, of: &dyn Fn(Rgb) -> f64| {
        let points: Vec<[f64; 2]> = curve.iter().map(|&(angle, a)| [angle, of(a)]).collect();
        let style = if is_dashed {
            LineStyle::dashed_dense()
        } else {
            LineStyle::Solid
        };
        let line = Line::new(name, PlotPoints::from(points)).id((name, is_dashed));
        plot.line(line.color(color).width(width).style(style));
    };
    if !curve.iter().any(is_colored) {
        return line("ρ", ink, 2.0, &brightness);
    }
    // Line widths distinguish the channels without relying on colour.
    for (k, (name, width)) in [("R", 2.6), ("G", 1.9), ("B", 1.2)].into_iter().enumerate() {
        line(name, colors[k], width, &|a: Rgb| a[k]);
    }
}

fn words(at: &HoverPosition) -> Option<String> {
    match at {
        HoverPosition::NearDataPoint {
            plot_name,
            position,
            ..
        } if !plot_name.is_empty() => Some(format!(
            "{plot_name} = {:.3}, {:.0}°",
            position.y, position.x
        )),
        _ => None,
    }
}
