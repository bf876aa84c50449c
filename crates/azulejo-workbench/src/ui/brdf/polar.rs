//! Polar plot of lobes in the plane of incidence.

use super::lobes::LobeSlice;
use super::theme::{brightness, grid, lines, short};
use super::view::{LobeQuantity, LobeView, RadialScale};
use crate::words::Language;
use egui::{Align2, Color32, Ui};
use egui_plot::{HoverPosition, Line, LineStyle, Plot, PlotPoint, PlotPoints, PlotUi, Text};

/// Smaller fractions of the radius are not drawn.
const SEEN: f64 = 5e-4;

/// Rays at larger angles are nearly level, degrees.
const LEVEL: f64 = 70.0;

/// Draws the lobes of one model, or of two: the second is dashed.
pub(super) fn draw(ui: &mut Ui, language: Language, view: &LobeView, models: &[&[LobeSlice]]) {
    // One radial scale for all lobes makes models comparable: it ends at their maximum.
    let values = models
        .iter()
        .flat_map(|slices| slices.iter().flat_map(|s| drawn(view, s)));
    let top = values.map(|v| v.1).fold(0.0, f64::max);
    let dial = PolarAxes {
        view,
        top: if top > 0.0 { top } else { 1.0 },
        grid: grid(ui),
        ink: ui.visuals().weak_text_color(),
        colors: lines(ui),
    };
    // The plot is a fixed half disc: spokes and rings replace its own axes and grid.
    let (name, unit) = (quantity(view), language.tr("1/sr"));
    let height = (0.56 * ui.available_width()).clamp(120.0, 230.0);
    let plot = Plot::new("polar")
        .height(height)
        .data_aspect(1.0)
        .show_axes(false)
        .show_grid(false)
        .show_x(false)
        .show_y(false)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .set_margin_fraction(egui::Vec2::ZERO)
        .include_x(-1.25)
        .include_x(1.25)
        .include_y(-0.16)
        .include_y(1.17)
        .label_formatter(|at| dial.words(at, name, unit));
    // Of each model the first lobe is drawn last, on top of the others.
    let shown = plot.show(ui, |plot| {
        dial.draw_axes(plot);
        for (slices, is_dashed) in models.iter().zip([false, true]) {
            for (k, slice) in slices.iter().enumerate().rev() {
                dial.slice(plot, slice, k, is_dashed);
            }
        }
    });
    // To a screen reader the plot is an image with its quantity and scale.
    let words = language.tr("Lobes in the plane of incidence");
    let scale = match view.scale {
        RadialScale::Linear => language.tr("Linear"),
        RadialScale::Logarithmic => language.tr("Logarithmic"),
    };
    let words = format!("{words}: {name}, {unit}, {scale}");
    let info = || egui::WidgetInfo::labeled(egui::accesskit::Role::Image, true, &words);
    shown.response.widget_info(info);
}

/// Label of the radial quantity.
pub(super) fn quantity(view: &LobeView) -> &'static str {
    match view.quantity {
        LobeQuantity::WithCosine => "f·cos θ",
        LobeQuantity::Alone => "f",
    }
}

/// Angles with the values plotted there.
fn drawn(view: &LobeView, slice: &LobeSlice) -> impl Iterator<Item = (f64, f64)> {
    let value = |&(angle, f): &(f64, _)| {
        let cos = angle.to_radians().cos();
        (angle, view.value(brightness(f), cos))
    };
    slice.points.iter().map(value)
}

/// The axes of the half circle.
struct PolarAxes<'a> {
    view: &'a LobeView,
    /// The value at radius 1.
    top: f64,
    grid: Color32,
    ink: Color32,
    colors: [Color32; 5],
}

/// The position at an angle to the normal in degrees and a fraction of the radius.
fn at(degrees: f64, share: f64) -> [f64; 2] {
    let (sin, cos) = degrees.to_radians().sin_cos();
    [share * sin, share * cos]
}

impl PolarAxes<'_> {
    fn line(&self, plot: &mut PlotUi, points: Vec<[f64; 2]>, color: Color32) {
        let line = Line::new("", PlotPoints::from(points))
            .color(color)
            .width(1.0);
        plot.line(line.allow_hover(false));
    }

    fn text(
        &self,
        plot: &mut PlotUi,
        position: [f64; 2],
        words: &str,
        color: Color32,
        anchor: Align2,
    ) {
        let text = egui::RichText::new(words).size(10.0);
        let position = PlotPoint::new(position[0], position[1]);
        plot.text(
            Text::new("", position, text)
                .color(color)
                .anchor(anchor)
                .allow_hover(false),
        );
    }

    /// Spokes, rings with their values, and the surface.
    fn draw_axes(&self, plot: &mut PlotUi) {
        for k in -2..=2 {
            self.line(
                plot,
                vec![[0.0, 0.0], at(30.0 * f64::from(k), 1.0)],
                self.grid,
            );
        }
        for value in self.view.rings(self.top) {
            let share = self.view.share(value, self.top);
            let arc = (-45..=45).map(|k| at(2.0 * f64::from(k), share)).collect();
            self.line(plot, arc, self.grid);
            self.text(
                plot,
                [share, -0.02],
                &short(value),
                self.ink,
                Align2::CENTER_TOP,
            );
        }
        self.line(plot, vec![[-1.05, 0.0], [1.05, 0.0]], self.ink);
    }

    /// One lobe, with its direction of incidence.
    fn slice(&self, plot: &mut PlotUi, slice: &LobeSlice, k: usize, is_dashed: bool) {
        let color = self.colors[k % self.colors.len()];
        let style = if is_dashed {
            LineStyle::dashed_dense()
        } else {
            LineStyle::Solid
        };
        let position = |(angle, value)| at(angle, self.view.share(value, self.top));
        let ends = std::iter::once([0.0; 2]);
        let points = ends
            .clone()
            .chain(drawn(self.view, slice).map(position))
            .chain(ends);
        let width = if k == 0 { 2.4 } else { 1.2 };
        let name = format!("{}°", short(slice.incidence));
        let line = Line::new(&name, PlotPoints::from(points.collect::<Vec<_>>()));
        plot.line(
            line.id((k, is_dashed))
                .color(color)
                .width(width)
                .style(style),
        );
        let mirrored = brightness(slice.mirrored);
        if mirrored > SEEN {
            let points = PlotPoints::from(vec![[0.0; 2], at(slice.incidence, 1.0)]);
            let style = LineStyle::Dotted {
                spacing: if is_dashed { 9.0 } else { 5.0 },
            };
            plot.line(
                Line::new("", points)
                    .color(color)
                    .width(1.6)
                    .style(style)
                    .allow_hover(false),
            );
        }
        if !is_dashed {
            self.light(plot, slice.incidence, &name, color, width);
            if mirrored > SEEN {
                let words = format!("{:.1} %", 100.0 * mirrored);
                // Beside the ray, away from the label of its angle.
                let position = at(slice.incidence.max(3.0), 1.03);
                // There is no room at the right of a ray that is nearly level.
                let anchor = if slice.incidence > LEVEL {
                    Align2::RIGHT_BOTTOM
                } else {
                    Align2::LEFT_CENTER
                };
                self.text(plot, position, &words, color, anchor);
            }
        }
    }

    /// A direction of incidence with its angle.
    fn light(&self, plot: &mut PlotUi, incidence: f64, name: &str, color: Color32, width: f32) {
        let points = PlotPoints::from(vec![at(-incidence, 1.02), at(-incidence, 1.09)]);
        plot.line(
            Line::new("", points)
                .color(color)
                .width(width)
                .allow_hover(false),
        );
        let anchor = if incidence < 10.0 {
            Align2::CENTER_BOTTOM
        } else {
            Align2::RIGHT_BOTTOM
        };
        self.text(plot, at(-incidence, 1.09), name, color, anchor);
    }

    /// Text for the point under the mouse.
    fn words(&self, position: &HoverPosition, quantity: &str, unit: &str) -> Option<String> {
        let HoverPosition::NearDataPoint {
            plot_name,
            position,
            ..
        } = position
        else {
            return None;
        };
        let share = position.x.hypot(position.y);
        let angle = position.x.atan2(position.y).to_degrees();
        let value = self.view.value_at(share, self.top);
        (!plot_name.is_empty()).then(|| {
            format!(
                "{plot_name}, {angle:.0}°\n{quantity} = {} {unit}",
                short(value)
            )
        })
    }
}
