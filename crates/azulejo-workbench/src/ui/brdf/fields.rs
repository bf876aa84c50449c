//! Input fields for numbers and colours.

use super::super::inputs;
use super::theme::row;
use azulejo::scene::Rgb;
use egui::{SliderClamping, Ui, vec2};

/// The range of a number field.
#[derive(Clone, Copy, Debug)]
pub(super) struct NumberRange<'a> {
    /// Minimum.
    pub least: f64,
    /// Maximum.
    pub most: f64,
    /// Unit; empty for plain numbers.
    pub unit: &'a str,
    /// Whether a number typed outside the range is clamped; otherwise it stays, and the caller must
    /// report it.
    pub is_strict: bool,
}

/// A fraction of light, 0 to 1.
pub(super) const SHARE: NumberRange = NumberRange {
    least: 0.0,
    most: 1.0,
    unit: "",
    is_strict: true,
};

impl NumberRange<'_> {
    /// The same range with another maximum.
    pub fn up_to(self, most: f64) -> Self {
        NumberRange { most, ..self }
    }

    fn range(&self) -> std::ops::RangeInclusive<f64> {
        self.least..=self.most
    }

    /// Whether the slider is logarithmic, because a linear one would not reach most values of a
    /// wide range.
    fn is_logarithmic(&self) -> bool {
        if self.least > 0.0 {
            self.most > 20.0 * self.least
        } else {
            self.least == 0.0 && self.most > 90.0
        }
    }

    fn suffix(&self) -> String {
        match self.unit {
            "" => String::new(),
            "degrees" => "°".to_owned(),
            unit => format!(" {unit}"),
        }
    }
}

/// A slider with a number field, labelled `name`.
pub(super) fn number(ui: &mut Ui, name: &str, span: NumberRange, value: &mut f64) {
    let clamping = if span.is_strict {
        SliderClamping::Always
    } else {
        SliderClamping::Never
    };
    let slider = inputs::slider(value, span.range())
        .logarithmic(span.is_logarithmic())
        .smallest_positive(1e-2)
        .clamping(clamping)
        .suffix(span.suffix())
        .max_decimals(6);
    ui.add(slider).accessible_name(name);
}

/// A row with a number field.
pub(super) fn number_row(ui: &mut Ui, name: &str, about: &str, span: NumberRange, value: &mut f64) {
    row(ui, name, about, |ui, name| number(ui, name, span, value));
}

/// A colour button and three numbers.
pub(super) fn color(ui: &mut Ui, name: &str, span: NumberRange, color: &mut Rgb) {
    if span.least >= 0.0 && span.most <= 1.0 {
        swatch(ui, name, color);
    }
    channels(ui, name, span, color);
}

/// A button with the colour, which opens a colour picker.
pub(super) fn swatch(ui: &mut Ui, name: &str, color: &mut Rgb) {
    inputs::picked(ui, name, color, |picked| Some(picked.map(rounded)));
}

/// Colour pickers have 256 steps; more digits are meaningless.
fn rounded(x: f64) -> f64 {
    (1e4 * x).round() / 1e4
}

/// Three numbers.
fn channels(ui: &mut Ui, name: &str, span: NumberRange, color: &mut Rgb) {
    for (channel, letter) in ["R", "G", "B"].into_iter().enumerate() {
        let value = &mut color[channel];
        let range = if span.is_strict {
            span.range()
        } else {
            f64::NEG_INFINITY..=f64::INFINITY
        };
        let drag = inputs::number(value, range)
            .speed(0.002 * (span.most - span.least).min(1.0))
            .max_decimals(4)
            .prefix(format!("{letter} "))
            .suffix(span.suffix())
            .min_size(vec2(58.0, 0.0));
        let response = ui.add(drag).accessible_name(format!("{name} {letter}"));
        if response.dragged() {
            *value = value.clamp(span.least, span.most);
        }
    }
}

/// A row with a colour.
pub(super) fn color_row(ui: &mut Ui, name: &str, about: &str, span: NumberRange, value: &mut Rgb) {
    row(ui, name, about, |ui, name| color(ui, name, span, value));
}
