//! The properties by which an element is painted, and their inheritance.

use super::style_sheet::StyleSheet;
use super::values::color;
use azulejo_scene::{FillRule, Rgb};
use roxmltree::Node;

/// The relevant properties of an element, its own or inherited.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Style {
    /// How its inside is painted.
    pub fill: Paint,
    /// The fill rule.
    pub rule: FillRule,
    /// Whether it has a stroke.
    pub is_stroked: bool,
    /// Whether it is visible.
    pub is_visible: bool,
    /// The value of `currentColor`.
    current: Paint,
}

/// The paint of the inside of a shape.
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
            is_stroked: false,
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
            ("fill-opacity" | "opacity", value) if value.parse() == Ok(0.0) => {
                self.fill = Paint::None;
            }
            ("stroke", value) => self.is_stroked = value != "none",
            ("visibility", value) => self.is_visible = value == "visible",
            ("fill-rule", "evenodd") => self.rule = FillRule::EvenOdd,
            ("fill-rule", "nonzero") => self.rule = FillRule::NonZero,
            _ => {}
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
