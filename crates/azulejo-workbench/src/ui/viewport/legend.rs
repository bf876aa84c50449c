//! The legend of a colour scale.

use crate::gpu::ColorScale;
use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, Vec2};

/// Draws a colour bar with its values in the lower left corner of `rect`.
pub fn paint(painter: &Painter, rect: Rect, scale: &ColorScale, unit: &str) {
    let height = (0.5 * rect.height()).clamp(80.0, 240.0);
    let bar = Rect::from_min_size(
        Pos2::new(rect.min.x + 12.0, rect.max.y - height - 14.0),
        Vec2::new(16.0, height),
    );
    let panel = Rect::from_min_max(
        bar.min - Vec2::new(6.0, 24.0),
        bar.max + Vec2::new(78.0, 8.0),
    );
    painter.rect_filled(panel, 4.0, Color32::from_black_alpha(150));
    let steps = 64;
    for k in 0..steps {
        let place = (f64::from(k) + 0.5) / f64::from(steps);
        let [r, g, b] = scale.map.color(place);
        let top = bar.max.y - (k + 1) as f32 / steps as f32 * height;
        let size = Vec2::new(bar.width(), height / steps as f32 + 0.5);
        let color = Color32::from_rgb(r, g, b);
        painter.rect_filled(
            Rect::from_min_size(Pos2::new(bar.min.x, top), size),
            0.0,
            color,
        );
    }
    let font = FontId::proportional(11.0);
    let white = Color32::WHITE;
    let above = Pos2::new(bar.min.x, bar.min.y - 4.0);
    painter.text(above, Align2::LEFT_BOTTOM, unit, font.clone(), white);
    for k in 0..=4 {
        let place = f64::from(k) / 4.0;
        let y = bar.max.y - place as f32 * height;
        let text = number(scale.value(place));
        painter.text(
            Pos2::new(bar.max.x + 8.0, y),
            Align2::LEFT_CENTER,
            text,
            font.clone(),
            white,
        );
        let tick = [Pos2::new(bar.max.x, y), Pos2::new(bar.max.x + 5.0, y)];
        painter.line_segment(tick, Stroke::new(1.0, white));
    }
    // The positions of the isolines on the bar.
    for k in 1..scale.bands {
        let y = bar.max.y - k as f32 / scale.bands as f32 * height;
        let line = [Pos2::new(bar.min.x, y), Pos2::new(bar.max.x, y)];
        painter.line_segment(line, Stroke::new(1.0, Color32::from_black_alpha(180)));
    }
}

/// A number with three significant digits.
pub fn number(x: f64) -> String {
    let size = x.abs();
    if size == 0.0 {
        "0".into()
    } else if !(1e-3..1e6).contains(&size) {
        format!("{x:.2e}")
    } else {
        let digits = (2 - size.log10().floor() as i32).max(0) as usize;
        format!("{x:.digits$}")
    }
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_have_three_digits() {
        for (x, text) in [
            (0.0, "0"),
            (512.4, "512"),
            (5.124, "5.12"),
            (0.05124, "0.0512"),
            (-2.5, "-2.50"),
            (12_345.6, "12346"),
            (1.5e-7, "1.50e-7"),
            (2e9, "2.00e9"),
        ] {
            assert_eq!(number(x), text);
        }
    }
}
