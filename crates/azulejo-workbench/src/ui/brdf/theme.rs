//! Colours and rows shared by all parts of the editor.

pub(super) use crate::ui::colors::lines;
use azulejo::scene::Rgb;
use egui::{Align, Color32, Layout, RichText, Sense, Stroke, Ui, vec2};

/// Width of the labels.
const NAMES: f32 = 84.0;

/// Line colours of red, green and blue; the line widths differ as well.
pub(super) fn channels(ui: &Ui) -> [Color32; 3] {
    let [blue, orange, green, ..] = lines(ui);
    [orange, green, blue]
}

/// Colour of grid lines.
pub(super) fn grid(ui: &Ui) -> Color32 {
    ui.visuals().weak_text_color().gamma_multiply(0.45)
}

/// The scalar that is plotted for a colour.
pub(super) fn brightness(value: Rgb) -> f64 {
    value.luminance()
}

/// A number with three digits for an axis.
pub(super) fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        x if !(1e-3..1e5).contains(&x) => format!("{value:.0e}"),
        x => {
            let digits = (2 - x.log10().floor() as i32).clamp(0, 5) as usize;
            let text = format!("{value:.digits$}");
            if text.contains('.') {
                text.trim_end_matches('0').trim_end_matches('.').to_owned()
            } else {
                text
            }
        }
    }
}

/// A label with a tooltip, followed by its fields, which get the label as their accessible name.
/// Fields that do not fit into one line go to the next.
pub(super) fn row<R>(
    ui: &mut Ui,
    name: &str,
    about: &str,
    fields: impl FnOnce(&mut Ui, &str) -> R,
) -> R {
    ui.horizontal(|ui| {
        let size = vec2(NAMES, ui.spacing().interact_size.y);
        ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
            ui.set_min_width(NAMES);
            let label = ui.add(egui::Label::new(name).truncate());
            if !about.is_empty() {
                label.on_hover_text(about);
            }
        });
        ui.spacing_mut().slider_width = (ui.available_width() - 80.0).clamp(60.0, 260.0);
        ui.horizontal_wrapped(|ui| fields(ui, name)).inner
    })
    .inner
}

/// A row whose label is above the fields where it is too long to be beside them.
pub(super) fn named<R>(
    ui: &mut Ui,
    name: &str,
    about: &str,
    fields: impl FnOnce(&mut Ui, &str) -> R,
) -> R {
    let label = egui::WidgetText::from(name);
    let wrap = Some(egui::TextWrapMode::Extend);
    let galley = label.into_galley(ui, wrap, f32::INFINITY, egui::TextStyle::Body);
    if galley.size().x <= NAMES {
        return row(ui, name, about, fields);
    }
    ui.add(egui::Label::new(name).truncate())
        .on_hover_text(about);
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().slider_width = (ui.available_width() - 80.0).clamp(60.0, 300.0);
        fields(ui, name)
    })
    .inner
}

/// A tick, or a triangle with an exclamation mark.
pub(super) fn mark(ui: &mut Ui, is_good: bool, color: Color32) {
    let (place, _) = ui.allocate_exact_size(vec2(13.0, 13.0), Sense::hover());
    let at = |x: f32, y: f32| place.lerp_inside(vec2(x, y));
    let stroke = Stroke::new(1.8, color);
    let (line, others) = if is_good {
        (vec![at(0.1, 0.55), at(0.4, 0.85), at(0.9, 0.2)], vec![])
    } else {
        (
            vec![at(0.5, 0.0), at(1.0, 0.95), at(0.0, 0.95), at(0.5, 0.0)],
            vec![
                [at(0.5, 0.35), at(0.5, 0.62)],
                [at(0.5, 0.72), at(0.5, 0.82)],
            ],
        )
    };
    ui.painter().line(line, stroke);
    for ends in others {
        ui.painter().line_segment(ends, Stroke::new(1.4, color));
    }
}

pub(super) fn problem(ui: &mut Ui, words: &str) {
    marked(ui, words, ui.visuals().error_fg_color);
}

pub(super) fn notice(ui: &mut Ui, words: &str) {
    marked(ui, words, ui.visuals().warn_fg_color);
}

fn marked(ui: &mut Ui, words: &str, color: Color32) {
    ui.horizontal_top(|ui| {
        mark(ui, false, color);
        ui.add(egui::Label::new(RichText::new(words).color(color)).wrap());
    });
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_are_short() {
        for (value, expected) in [
            (0.0, "0"),
            (0.5, "0.5"),
            (12.34, "12.3"),
            (1234.0, "1234"),
            (0.01, "0.01"),
            (1e-4, "1e-4"),
            (100.0, "100"),
            (2e5, "2e5"),
        ] {
            assert_eq!(short(value), expected);
        }
    }
}
