//! The properties by which an element is painted, and their inheritance.

use super::style_sheet::StyleSheet;
use super::values::{color, length};
use azulejo_scene::{FillRule, Rgb};
use kurbo::{Cap, Join, Stroke};
use roxmltree::Node;

/// The relevant properties of an element, its own or inherited.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Style {
    /// How its inside is painted.
    pub fill: Paint,
    /// The fill rule.
    pub rule: FillRule,
    /// How its outline is painted.
    pub stroke: StrokeStyle,
    /// Whether it is visible.
    pub is_visible: bool,
    /// The value of `currentColor`.
    current: Paint,
}

/// How an outline is painted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StrokeStyle {
    /// Its paint.
    pub paint: Paint,
    /// Whether it has gaps.
    pub is_dashed: bool,
    width: f64,
    join: Join,
    cap: Cap,
    miter_limit: f64,
}

impl StrokeStyle {
    /// The pen; `None` if it draws nothing.
    pub fn pen(&self) -> Option<Stroke> {
        let stroke = Stroke::new(self.width)
            .with_join(self.join)
            .with_caps(self.cap)
            .with_miter_limit(self.miter_limit);
        (self.paint != Paint::None && self.width > 0.0).then_some(stroke)
    }

    fn set(&mut self, name: &str, value: &str, current: Paint) {
        match (name, value) {
            ("stroke", value) => self.paint = paint(value, current),
            ("stroke-width", value) => {
                let width = length(value).map(|(width, _)| width);
                self.width = width.filter(|w| *w >= 0.0).unwrap_or(self.width);
            }
            ("stroke-linejoin", "round") => self.join = Join::Round,
            ("stroke-linejoin", "bevel") => self.join = Join::Bevel,
            ("stroke-linejoin", _) => self.join = Join::Miter,
            ("stroke-linecap", "round") => self.cap = Cap::Round,
            ("stroke-linecap", "square") => self.cap = Cap::Square,
            ("stroke-linecap", _) => self.cap = Cap::Butt,
            ("stroke-miterlimit", value) => {
                let limit = value.parse().ok().filter(|x: &f64| *x >= 1.0);
                self.miter_limit = limit.unwrap_or(self.miter_limit);
            }
            ("stroke-dasharray", value) => self.is_dashed = value != "none",
            ("stroke-opacity", value) if value.parse() == Ok(0.0) => self.paint = Paint::None,
            _ => {}
        }
    }
}

/// The paint of the inside or of the outline of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Paint {
    /// Not painted.
    None,
    /// One colour, linear.
    Color(Rgb),
    /// Gradients, patterns, and unknown colour names.
    Other,
}

impl Default for Style {
    fn default() -> Style {
        Style {
            fill: Paint::Color(Rgb::BLACK),
            rule: FillRule::NonZero,
            stroke: StrokeStyle {
                paint: Paint::None,
                is_dashed: false,
                width: 1.0,
                join: Join::Miter,
                cap: Cap::Butt,
                miter_limit: 4.0,
            },
            is_visible: true,
            current: Paint::Color(Rgb::BLACK),
        }
    }
}

impl Style {
    /// The style of a child element of one with this style; `None` if it and its content are not
    /// displayed.
    ///
    /// In rising priority: attributes, rules of the style sheet, the element's own `style`.
    pub fn of(mut self, element: Node, sheet: &StyleSheet) -> Option<Style> {
        let mut is_displayed = true;
        for attribute in element.attributes() {
            self.set(attribute.name(), attribute.value(), &mut is_displayed);
        }
        for (name, value) in sheet.declarations(element) {
            self.set(name, value, &mut is_displayed);
        }
        for declaration in element.attribute("style").unwrap_or("").split(';') {
            if let Some((name, value)) = declaration.split_once(':') {
                self.set(name.trim(), value, &mut is_displayed);
            }
        }
        is_displayed.then_some(self)
    }

    fn set(&mut self, name: &str, value: &str, is_displayed: &mut bool) {
        let value = value.trim().trim_end_matches("!important").trim_end();
        match (name, value) {
            ("display", value) => *is_displayed = value != "none",
            (_, "inherit") => {}
            ("color", value) => self.current = paint(value, self.current),
            ("fill", value) => self.fill = paint(value, self.current),
            ("fill-opacity", value) if value.parse() == Ok(0.0) => self.fill = Paint::None,
            ("opacity", value) if value.parse() == Ok(0.0) => {
                (self.fill, self.stroke.paint) = (Paint::None, Paint::None);
            }
            ("visibility", value) => self.is_visible = value == "visible",
            ("fill-rule", "evenodd") => self.rule = FillRule::EvenOdd,
            ("fill-rule", "nonzero") => self.rule = FillRule::NonZero,
            (name, value) => self.stroke.set(name, value, self.current),
        }
    }
}

fn paint(value: &str, current: Paint) -> Paint {
    match value {
        "none" | "transparent" => Paint::None,
        "currentColor" | "currentcolor" => current,
        other => color(other).map_or(Paint::Other, Paint::Color),
    }
}
