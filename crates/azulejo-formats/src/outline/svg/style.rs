//! The properties by which an element is painted, and their inheritance.

use super::style_sheet::StyleSheet;
use super::values::{LengthUnits, color};
use crate::FontRequest;
use azulejo_scene::{FillRule, Rgb};
use glam::DVec2;
use kurbo::{Cap, Join, Stroke};
use roxmltree::Node;
use std::rc::Rc;
use svgtypes::FontShorthand;

/// The relevant properties of an element, its own or inherited.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Style {
    /// How its inside is painted.
    pub fill: Paint,
    /// The fill rule.
    pub rule: FillRule,
    /// The same where it clips others.
    pub clip_rule: FillRule,
    /// How its outline is painted.
    pub stroke: StrokeStyle,
    /// Its letters.
    pub letters: FontProperties,
    /// Whether it is visible.
    pub is_visible: bool,
    /// The value of `currentColor`.
    current: Paint,
}

/// How letters look, and where lines of them are.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FontProperties {
    /// Length of an em, user units.
    pub size: f64,
    /// Which part of a line is at its place: 0 its start, 1 its end.
    pub anchor: f64,
    /// Additional space after each letter, user units.
    pub spacing: f64,
    families: Rc<[String]>,
    weight: u16,
    is_italic: bool,
}

impl FontProperties {
    /// The font.
    pub fn request(&self) -> FontRequest {
        FontRequest {
            weight: self.weight,
            is_italic: self.is_italic,
            ..FontRequest::regular(self.families.iter().cloned())
        }
    }

    fn set(&mut self, name: &str, value: &str, units: &LengthUnits) {
        match (name, value) {
            ("font", value) => {
                let Ok(font) = FontShorthand::from_str(value) else {
                    return;
                };
                self.set("font-size", font.font_size, units);
                self.set("font-family", font.font_family, units);
                self.set("font-weight", font.font_weight.unwrap_or("normal"), units);
                self.set("font-style", font.font_style.unwrap_or("normal"), units);
            }
            ("font-family", value) => {
                let name = |family: &str| family.trim().trim_matches(['"', '\'']).to_owned();
                self.families = value.split(',').map(name).collect();
            }
            ("font-size", value) => {
                let size = keyword_size(value).or_else(|| units.length("font-size", value));
                self.size = size.filter(|s| *s >= 0.0).unwrap_or(self.size);
            }
            ("font-weight", "normal") => self.weight = 400,
            ("font-weight", "bold") => self.weight = 700,
            // CSS Fonts Level 4, 2.2.1.
            ("font-weight", "bolder") => {
                self.weight = match self.weight {
                    ..350 => 400,
                    350..550 => 700,
                    _ => 900,
                }
            }
            ("font-weight", "lighter") => {
                self.weight = match self.weight {
                    ..550 => 100,
                    550..750 => 400,
                    _ => 700,
                }
            }
            ("font-weight", value) => {
                let weight = value.parse().ok().filter(|w| (1..=1000).contains(w));
                self.weight = weight.unwrap_or(self.weight);
            }
            ("font-style", value) => {
                self.is_italic = value.starts_with("italic") || value.starts_with("oblique");
            }
            ("text-anchor", "start") => self.anchor = 0.0,
            ("text-anchor", "middle") => self.anchor = 0.5,
            ("text-anchor", "end") => self.anchor = 1.0,
            ("letter-spacing", "normal") => self.spacing = 0.0,
            ("letter-spacing", value) => {
                self.spacing = units.length(name, value).unwrap_or(self.spacing);
            }
            _ => {}
        }
    }
}

/// CSS's names of sizes, with a medium of 16.
fn keyword_size(value: &str) -> Option<f64> {
    Some(match value {
        "xx-small" => 9.0,
        "x-small" => 10.0,
        "small" => 13.0,
        "medium" => 16.0,
        "large" => 18.0,
        "x-large" => 24.0,
        "xx-large" => 32.0,
        _ => return None,
    })
}

/// How an outline is painted.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct StrokeStyle {
    /// Its paint.
    pub paint: Paint,
    /// Lengths of dashes and gaps in turn, user units, an even number; none if it has no gaps.
    pub dashes: Rc<[f64]>,
    /// Where in the dashes it begins.
    pub dash_offset: f64,
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

    fn set(&mut self, name: &str, value: &str, units: &LengthUnits, current: Paint) {
        match (name, value) {
            ("stroke", value) => self.paint = paint(value, current),
            ("stroke-width", value) => {
                let width = units.length(name, value);
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
            ("stroke-dasharray", value) => self.dashes = dashes(value, units),
            ("stroke-dashoffset", value) => {
                self.dash_offset = units.length(name, value).unwrap_or(0.0);
            }
            ("stroke-opacity", value) if value.parse() == Ok(0.0) => self.paint = Paint::None,
            _ => {}
        }
    }
}

/// The lengths of a list, twice if they are odd; none if one is negative, malformed, or all are 0.
fn dashes(value: &str, units: &LengthUnits) -> Rc<[f64]> {
    let parts = value
        .split([',', ' ', '\t', '\n'])
        .filter(|part| !part.is_empty());
    let lengths: Option<Vec<f64>> = parts.map(|p| units.length("stroke-dasharray", p)).collect();
    let usable = lengths.filter(|l| l.iter().all(|x| *x >= 0.0) && l.iter().any(|x| *x > 0.0));
    let lengths = usable.unwrap_or_default();
    if lengths.len().is_multiple_of(2) {
        lengths.into()
    } else {
        lengths.repeat(2).into()
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

/// Properties that children do not inherit.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct OwnStyle {
    /// What clips it, as the document says it.
    pub clip: Option<String>,
    /// Those of its properties that have no effect here.
    pub ignored: Vec<&'static str>,
    /// Whether a viewport shows what is outside of it.
    pub overflows: bool,
}

impl OwnStyle {
    fn set(&mut self, name: &str, value: &str) {
        const IGNORED: [&str; 7] = [
            "mask",
            "filter",
            "vector-effect",
            "marker",
            "marker-start",
            "marker-mid",
            "marker-end",
        ];
        match (name, value) {
            ("clip-path", "none") => self.clip = None,
            ("clip-path", value) => self.clip = Some(value.to_owned()),
            ("overflow", value) => self.overflows = matches!(value, "visible" | "auto"),
            _ => {
                let known = IGNORED.iter().find(|ignored| **ignored == name);
                self.ignored.extend(known.filter(|_| value != "none"));
            }
        }
    }
}

impl Default for Style {
    fn default() -> Style {
        Style {
            fill: Paint::Color(Rgb::BLACK),
            rule: FillRule::NonZero,
            clip_rule: FillRule::NonZero,
            stroke: StrokeStyle {
                paint: Paint::None,
                dashes: Rc::new([]),
                dash_offset: 0.0,
                width: 1.0,
                join: Join::Miter,
                cap: Cap::Butt,
                miter_limit: 4.0,
            },
            letters: FontProperties {
                size: 16.0,
                anchor: 0.0,
                spacing: 0.0,
                families: Rc::new(["serif".to_owned()]),
                weight: 400,
                is_italic: false,
            },
            is_visible: true,
            current: Paint::Color(Rgb::BLACK),
        }
    }
}

impl Style {
    /// What relative lengths refer to, in a viewport of this size.
    pub fn units(&self, view: DVec2) -> LengthUnits {
        LengthUnits {
            view,
            em: self.letters.size,
        }
    }

    /// The style of a child element of one with this style; `None` if it and its content are not
    /// displayed.
    ///
    /// In rising priority: attributes, rules of the style sheet, the element's own `style`.
    pub fn of(
        mut self,
        element: Node,
        sheet: &StyleSheet,
        view: DVec2,
    ) -> Option<(Style, OwnStyle)> {
        let declared = element.attribute("style").unwrap_or("").split(';');
        let declared = declared.filter_map(|declaration| declaration.split_once(':'));
        let attributes = element.attributes().map(|a| (a.name(), a.value()));
        let all: Vec<(&str, &str)> = attributes
            .chain(sheet.declarations(element))
            .chain(declared.map(|(name, value)| (name.trim(), value)))
            .map(|(name, value)| (name, value.trim().trim_end_matches("!important").trim_end()))
            .filter(|(_, value)| *value != "inherit")
            .collect();
        // Other lengths may be in units of the element's own font size, that one of its parent's.
        let outer = self.units(view);
        for (name, value) in all
            .iter()
            .filter(|(name, _)| matches!(*name, "font" | "font-size"))
        {
            self.letters.set(name, value, &outer);
        }
        let units = self.units(view);
        let (mut own, mut is_displayed) = (OwnStyle::default(), true);
        for (name, value) in all {
            match name {
                "display" => is_displayed = value != "none",
                "font" | "font-size" => {}
                _ => self.set(name, value, &units),
            }
            own.set(name, value);
        }
        is_displayed.then_some((self, own))
    }

    fn set(&mut self, name: &str, value: &str, units: &LengthUnits) {
        match (name, value) {
            ("color", value) => self.current = paint(value, self.current),
            ("fill", value) => self.fill = paint(value, self.current),
            ("fill-opacity", value) if value.parse() == Ok(0.0) => self.fill = Paint::None,
            ("opacity", value) if value.parse() == Ok(0.0) => {
                (self.fill, self.stroke.paint) = (Paint::None, Paint::None);
            }
            ("visibility", value) => self.is_visible = value == "visible",
            ("fill-rule", "evenodd") => self.rule = FillRule::EvenOdd,
            ("fill-rule", "nonzero") => self.rule = FillRule::NonZero,
            ("clip-rule", "evenodd") => self.clip_rule = FillRule::EvenOdd,
            ("clip-rule", "nonzero") => self.clip_rule = FillRule::NonZero,
            (name, value) => {
                self.stroke.set(name, value, units, self.current);
                self.letters.set(name, value, units);
            }
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
