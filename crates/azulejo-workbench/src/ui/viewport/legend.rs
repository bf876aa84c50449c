//! The legend of a colour scale.

use crate::gpu::ColorScale;
use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, Vec2};

/// What a legend says besides its scale.
#[derive(Clone, Copy, Debug, Default)]
pub struct LegendText<'a> {
    /// The unit of the values.
    pub unit: &'a str,
    /// Whether there are values below and above the scale, which have the colours of its ends.
    pub beyond: (bool, bool),
}

/// Draws a colour bar with round values in the lower left corner of `rect`.
pub fn paint(painter: &Painter, rect: Rect, scale: &ColorScale, text: LegendText) {
    let height = (0.5 * rect.height()).clamp(80.0, 240.0);
    let bar = Rect::from_min_size(
        Pos2::new(rect.min.x + 12.0, rect.max.y - height - 16.0),
        Vec2::new(16.0, height),
    );
    let panel = Rect::from_min_max(
        bar.min - Vec2::new(6.0, 28.0),
        bar.max + Vec2::new(86.0, 12.0),
    );
    painter.rect_filled(panel, 4.0, Color32::from_black_alpha(170));
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
    let font = FontId::proportional(12.0);
    let white = Color32::WHITE;
    let above = Pos2::new(bar.min.x, bar.min.y - 10.0);
    painter.text(above, Align2::LEFT_BOTTOM, text.unit, font.clone(), white);
    for (place, label) in labels(scale, text.beyond, height / 14.0) {
        let y = bar.max.y - place as f32 * height;
        let at = Pos2::new(bar.max.x + 8.0, y);
        painter.text(at, Align2::LEFT_CENTER, label, font.clone(), white);
        let tick = [Pos2::new(bar.max.x, y), Pos2::new(bar.max.x + 5.0, y)];
        painter.line_segment(tick, Stroke::new(1.0, white));
        if scale.bands > 0 {
            let line = [Pos2::new(bar.min.x, y), Pos2::new(bar.max.x, y)];
            painter.line_segment(line, Stroke::new(1.0, Color32::from_black_alpha(180)));
        }
    }
}

/// Places on the scale, 0 to 1, with their labels, at most about `most` of them. The ends are
/// labelled even if they are not round, and say so if there are values beyond.
fn labels(scale: &ColorScale, beyond: (bool, bool), most: f32) -> Vec<(f64, String)> {
    let ticks = scale.ticks();
    let every = (ticks.len() as f32 / most.max(2.0)).ceil().max(1.0) as usize;
    let place = |shown: f64| scale.fraction(shown / scale.display);
    let mut labels: Vec<(f64, String)> = (ticks.iter().step_by(every))
        .map(|&shown| (place(shown), short(shown)))
        .filter(|(at, _)| (-1e-9..=1.0 + 1e-9).contains(at))
        .collect();
    let room = 0.8 / f64::from(most.max(2.0));
    for (end, value, is_beyond, sign) in [
        (0.0, scale.low, beyond.0, "≤"),
        (1.0, scale.high, beyond.1, "≥"),
    ] {
        let value = scale.display * value;
        let is_tick = |(at, _): &(f64, String)| (at - end).abs() < 1e-6;
        let text = match labels.iter().find(|l| is_tick(l)) {
            Some((_, text)) => text.clone(),
            None => short(value),
        };
        let text = if is_beyond {
            format!("{sign} {text}")
        } else {
            text
        };
        // An end takes the place of a tick that would touch it.
        labels.retain(|(at, _)| (at - end).abs() > room);
        labels.push((end, text));
    }
    labels
}

/// A round number without superfluous zeros, or three digits of another one.
pub fn short(x: f64) -> String {
    let text = number(x);
    match text.split_once('e') {
        Some((digits, power)) => format!("{}e{power}", trimmed(digits)),
        None => trimmed(&text).to_owned(),
    }
}

fn trimmed(digits: &str) -> &str {
    if digits.contains('.') {
        digits.trim_end_matches('0').trim_end_matches('.')
    } else {
        digits
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
    use super::*;

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
        assert_eq!(short(2.5), "2.5");
        assert_eq!(short(500.0), "500");
        assert_eq!(short(2e9), "2e9");
    }

    #[test]
    fn a_legend_says_where_values_lie_beyond_it() {
        let scale = ColorScale {
            high: 2.07,
            bands: 8,
            ..ColorScale::default()
        };
        let text = |scale: &ColorScale, beyond| {
            let mut labels = labels(scale, beyond, 12.0);
            labels.sort_by(|a, b| a.0.total_cmp(&b.0));
            labels.into_iter().map(|(_, text)| text).collect::<Vec<_>>()
        };
        let rounded = scale.rounded();
        assert_eq!(
            text(&rounded, (false, true)),
            ["0", "0.5", "1", "1.5", "2", "≥ 2.5"]
        );
        let fixed = text(&scale, (false, true));
        assert_eq!(fixed.last().map(String::as_str), Some("≥ 2.07"));
        assert!(!fixed.contains(&"2".to_owned()), "it would touch the end");
        // In a low window there is room for few.
        assert!(labels(&rounded, (false, false), 3.0).len() <= 4);
    }
}
