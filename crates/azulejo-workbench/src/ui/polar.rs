//! The polar plot of a luminaire, the aim downwards.

use super::panel_context::PanelContext;
use super::viewport::number;
use azulejo::luminaire::kinds::{LuminaireKind, PLANES, beam_angle, round_step};
use egui::{Align2, Color32, FontId, Rect, Sense, Stroke, Ui, pos2, vec2};
use std::f32::consts::PI;

/// Side of the plot, points; less in a narrow panel.
const SIDE: f32 = 240.0;

/// Room for the angles around the largest circle, points.
const MARGIN: f32 = 24.0;

/// Colours of the half planes of 0 and 180, and of 90 and 270 degrees.
const COLORS: [Color32; 2] = [
    Color32::from_rgb(0xd0, 0x50, 0x40),
    Color32::from_rgb(0x40, 0x80, 0xd0),
];

/// Draws the intensities of a luminaire in two planes, and says its beam. `unit` is that of intensities, of which one of
/// the luminaire's is `factor`.
pub(super) fn show(
    ui: &mut Ui,
    cx: &PanelContext,
    kind: &LuminaireKind,
    (unit, factor): (&str, f64),
) {
    let profiles = PLANES.map(|(_, axis)| kind.profile(axis));
    let [beams, fields] = [0.5, 0.1].map(|share| {
        let [a, b] = profiles.each_ref().map(|p| beam_angle(p, share));
        format!("{a:.0}° × {b:.0}°")
    });
    ui.label(format!("{}: {beams}", cx.tr("Beam (half of the greatest)")));
    ui.label(format!("{}: {fields}", cx.tr("Field (a tenth)")));
    let side = SIDE.min(ui.available_width());
    let (rect, _) = ui.allocate_exact_size(vec2(side, side), Sense::hover());
    paint(ui, rect, kind.scale * kind.web.most() * factor, unit, |k| {
        let points = profiles[k].iter();
        points
            .map(|(angle, i)| (*angle as f32, i * factor))
            .collect()
    });
    ui.horizontal(|ui| {
        for ((name, _), color) in PLANES.into_iter().zip(COLORS) {
            ui.colored_label(color, name);
        }
    });
}

/// Paints rings up to the greatest intensity, and the curves of both planes.
fn paint(ui: &Ui, rect: Rect, most: f64, unit: &str, curve: impl Fn(usize) -> Vec<(f32, f64)>) {
    let painter = ui.painter();
    let visuals = ui.visuals();
    let line = Stroke::new(1.0, visuals.weak_text_color().gamma_multiply(0.4));
    let (font, words) = (FontId::proportional(10.0), visuals.weak_text_color());
    let radius = rect.width() / 2.0 - MARGIN;
    let step = round_step(most / 4.0);
    let full = step * (most / step).ceil().max(1.0);
    let at = |angle: f32, value: f64| {
        let r = radius * (value / full) as f32;
        rect.center() + vec2(r * angle.sin(), r * angle.cos())
    };
    for k in 0..12 {
        let angle = k as f32 * PI / 6.0;
        painter.line_segment([rect.center(), at(angle, full)], line);
        let degrees = if k <= 6 { 30 * k } else { 360 - 30 * k };
        let place = at(angle, full * f64::from(1.0 + 0.5 * MARGIN / radius));
        painter.text(
            place,
            Align2::CENTER_CENTER,
            format!("{degrees}°"),
            font.clone(),
            words,
        );
    }
    let rings = (full / step).round() as u32;
    for ring in 1..=rings {
        let value = step * f64::from(ring);
        painter.circle_stroke(rect.center(), radius * (value / full) as f32, line);
        let unit = if ring == rings { unit } else { "" };
        let text = format!("{} {unit}", number(value));
        let place = at(0.0, value) + vec2(3.0, -1.0);
        painter.text(
            place,
            Align2::LEFT_BOTTOM,
            text.trim_end(),
            font.clone(),
            words,
        );
    }
    for (k, color) in COLORS.into_iter().enumerate() {
        let points = curve(k).into_iter().map(|(angle, value)| {
            let point = at(angle, value);
            pos2(point.x, point.y)
        });
        painter.line(points.collect(), Stroke::new(1.5, color));
    }
}
