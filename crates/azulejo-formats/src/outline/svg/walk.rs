//! Converts the elements of a document to figures of what they fill and stroke.

use super::path::PathProblems;
use super::shapes;
use super::stroke;
use super::style::{Paint, Style};
use super::style_sheet::StyleSheet;
use super::values::{length, numbers, transform};
use crate::outline::drawing::{Drawing, Filled};
use crate::outline::pen::Pen;
use crate::reading::options::Budget;
use crate::reading::text::shortened;
use crate::reading::warnings::Warnings;
use crate::{Position, ReadError, ReadOptions};
use azulejo_scene::{Curve, Figure};
use glam::{DAffine2, DVec2};
use roxmltree::{Document, Node};
use std::collections::HashMap;

/// Deepest nesting of `use`; deeper ones are left out, and thereby recursive ones.
const DEEPEST_USE: u32 = 32;

/// Reads all filled shapes.
pub(super) fn read(
    xml: &Document,
    file: &str,
    options: &ReadOptions,
) -> Result<Drawing, ReadError> {
    let ids = xml
        .descendants()
        .filter_map(|n| Some((n.attribute("id")?, n)));
    let mut walk = SvgWalk {
        xml,
        file,
        warnings: Warnings::default(),
        sheet: StyleSheet::new(xml),
        // If several elements have the same id, the first is used.
        ids: ids.collect::<Vec<_>>().into_iter().rev().collect(),
        budget: Budget::new(options),
        shapes: Vec::new(),
    };
    let skipped = walk.sheet.not_applied;
    let message =
        "style sheet rule whose selector is not a single class, id or element: not applied";
    walk.warnings
        .add_many(file, message.to_owned(), skipped, || Position::Whole);
    let (map, metres_per_unit) = viewport(xml.root_element());
    walk.all(map)?;
    Ok(Drawing {
        shapes: walk.shapes,
        metres_per_unit,
        warnings: walk.warnings.finish(file),
    })
}

/// The transform that turns y up, with the lower left corner of the view at the origin, and the
/// length of a unit in metres, if the drawing has a physical size.
pub(super) fn viewport(root: Node) -> (DAffine2, Option<f64>) {
    const METRES: f64 = 0.0254 / 96.0;
    let side = |name: &str| root.attribute(name).and_then(length);
    let (view, _) = numbers(root.attribute("viewBox").unwrap_or_default());
    let (left, bottom, view_width) = match view[..] {
        [x, y, width, height] if width > 0.0 => (x, y + height, Some(width)),
        _ => (0.0, side("height").map_or(0.0, |(height, _)| height), None),
    };
    let metres = match (side("width"), view_width) {
        (Some((width, true)), Some(units)) if width > 0.0 => Some(METRES * width / units),
        (Some((_, true)), None) => Some(METRES),
        _ => None,
    };
    let map = DAffine2::from_cols_array(&[1.0, 0.0, 0.0, -1.0, -left, bottom]);
    (map, metres)
}

struct SvgWalk<'a, 'i> {
    xml: &'a Document<'i>,
    file: &'a str,
    warnings: Warnings,
    sheet: StyleSheet,
    ids: HashMap<&'a str, Node<'a, 'i>>,
    budget: Budget,
    shapes: Vec<Filled>,
}

/// An element to be drawn, with its transform and style.
#[derive(Clone, Copy)]
struct PendingElement<'a, 'i> {
    element: Node<'a, 'i>,
    map: DAffine2,
    style: Style,
    /// Nesting depth of `use`.
    depth: u32,
}

impl<'a, 'i> SvgWalk<'a, 'i> {
    /// Draws elements in document order, without recursion: nesting may be as deep as a file is long.
    fn all(&mut self, map: DAffine2) -> Result<(), ReadError> {
        let mut open = vec![PendingElement {
            element: self.xml.root_element(),
            map,
            style: Style::default(),
            depth: 0,
        }];
        while let Some(site) = open.pop() {
            self.budget
                .spend(cost(&site))
                .map_err(|e| e.error(self.file))?;
            let Some(style) = site.style.of(site.element, &self.sheet) else {
                continue;
            };
            let map = site.map * self.own_transform(site.element);
            let site = PendingElement { map, style, ..site };
            self.note_ignored(site.element);
            match site.element.tag_name().name() {
                "svg" | "g" | "a" | "switch" | "symbol" => push_children(site, &mut open),
                "use" => self.follow(site, &mut open),
                "path" | "rect" | "circle" | "ellipse" | "polygon" | "polyline" | "line" => {
                    self.draw(site)?;
                }
                name => self.left_out(name, site.element),
            }
        }
        Ok(())
    }

    fn warn(&mut self, message: impl Into<String>, element: Node) {
        let xml = self.xml;
        self.warnings.add(self.file, message.into(), || {
            let start = xml.text_pos_at(element.range().start);
            Position::Line(start.row, start.col)
        });
    }

    /// The element's own transform, and its x and y for elements that have them.
    fn own_transform(&mut self, element: Node) -> DAffine2 {
        let map = match element.attribute("transform").map(transform) {
            None => DAffine2::IDENTITY,
            Some(Some(map)) => map,
            Some(None) => {
                self.warn("malformed transform: not applied", element);
                DAffine2::IDENTITY
            }
        };
        let is_placed = match element.tag_name().name() {
            "use" => true,
            "svg" => element != self.xml.root_element(),
            _ => false,
        };
        let value = |name: &str| {
            if is_placed {
                element
                    .attribute(name)
                    .and_then(length)
                    .map_or(0.0, |(v, _)| v)
            } else {
                0.0
            }
        };
        map * DAffine2::from_translation(DVec2::new(value("x"), value("y")))
    }

    /// Warns about attributes of an element that are not applied.
    fn note_ignored(&mut self, element: Node) {
        for name in ["clip-path", "mask", "filter"] {
            if element.attribute(name).is_some_and(|v| v.trim() != "none") {
                self.warn(format!("{name}: not applied"), element);
            }
        }
        let is_inner = element != self.xml.root_element();
        if is_inner && element.attribute("viewBox").is_some() {
            self.warn("viewBox of an inner element: not applied", element);
        }
    }

    fn follow(&mut self, site: PendingElement<'a, 'i>, open: &mut Vec<PendingElement<'a, 'i>>) {
        const XLINK: &str = "http://www.w3.org/1999/xlink";
        let element = site.element;
        let link = element
            .attribute("href")
            .or(element.attribute((XLINK, "href")));
        let target = link
            .and_then(|l| l.trim().strip_prefix('#'))
            .and_then(|id| self.ids.get(id));
        match target {
            Some(_) if site.depth == DEEPEST_USE => {
                self.warn(
                    format!("use nested more than {DEEPEST_USE} deep: left out"),
                    element,
                );
            }
            Some(&target) => open.push(PendingElement {
                element: target,
                depth: site.depth + 1,
                ..site
            }),
            None => self.warn("use of an element that does not exist: left out", element),
        }
    }

    /// Warns about elements that are not supported.
    fn left_out(&mut self, name: &str, element: Node) {
        const SILENT: [&str; 16] = [
            "defs",
            "title",
            "desc",
            "metadata",
            "style",
            "script",
            "clipPath",
            "mask",
            "filter",
            "marker",
            "pattern",
            "linearGradient",
            "radialGradient",
            "view",
            "animate",
            "set",
        ];
        const SVG: &str = "http://www.w3.org/2000/svg";
        let is_ours = element.tag_name().namespace().is_none_or(|n| n == SVG);
        if is_ours && !SILENT.contains(&name) {
            self.warn(format!("{}: left out", shortened(name)), element);
        }
    }

    /// Adds what a shape fills, and then its stroke.
    fn draw(&mut self, site: PendingElement) -> Result<(), ReadError> {
        let element = site.element;
        let stroke = site.style.stroke;
        let pen_of_stroke = stroke.pen();
        let is_line = element.tag_name().name() == "line";
        let fills = site.style.fill != Paint::None && !is_line;
        if !site.style.is_visible || !(fills || pen_of_stroke.is_some()) {
            return Ok(());
        }
        // Draw in the element's own coordinates, and spend by the curves, which each `use` repeats.
        let mut pen = Pen::default();
        let outcome = if is_line {
            Some(PathProblems::default())
        } else {
            shapes::draw(element, &mut pen)
        };
        let Some(outcome) = outcome else {
            self.warn("shape with a length in an unknown unit: left out", element);
            return Ok(());
        };
        self.note(outcome, fills, element);
        let figure = pen.finish(site.style.rule);
        let stroked = pen_of_stroke.and_then(|pen| stroke::stroked(element, &figure, &pen));
        if fills {
            self.add(figure, site.style.fill, &site)?;
        }
        if let Some(stroked) = stroked {
            if stroke.is_dashed {
                self.warn("stroke-dasharray: drawn without gaps", element);
            }
            self.add(stroked, stroke.paint, &site)?;
        }
        Ok(())
    }

    /// Adds a figure in the coordinates of an element.
    fn add(
        &mut self,
        mut figure: Figure,
        paint: Paint,
        site: &PendingElement,
    ) -> Result<(), ReadError> {
        let element = site.element;
        self.budget
            .spend(figure.curve_count() as u64)
            .map_err(|e| e.error(self.file))?;
        if !self.budget.keeps() {
            return Ok(());
        }
        // Even where its coordinates are finite, transforms can make a shape overflow.
        transform_figure(&mut figure, &site.map);
        if figure.contours.is_empty() {
            return Ok(());
        }
        if !figure.bounds().size().is_finite() {
            self.warn("shape whose transforms overflow: left out", element);
            return Ok(());
        }
        // A gradient or a pattern fills the same figure, but without a colour that could be kept.
        let color = match paint {
            Paint::Color(color) => Some(color),
            Paint::None | Paint::Other => None,
        };
        if color.is_none() {
            self.warn("paint that is not a single colour: not kept", element);
        }
        let name = element.attribute("id").unwrap_or_default();
        self.shapes.push(Filled {
            figure,
            color,
            name: name.to_owned(),
        });
        Ok(())
    }

    fn note(&mut self, outcome: PathProblems, fills: bool, element: Node) {
        if outcome.is_cut {
            let message = "malformed path or points: drawn up to the error";
            self.warn(message, element);
        }
        if fills && outcome.open > 0 {
            self.warn(
                "open outline: closed by a straight line, as for filling",
                element,
            );
        }
    }
}

/// What drawing an element takes from the budget: each `use` of it parses its attributes again.
fn cost(site: &PendingElement) -> u64 {
    let attributes = site.element.attributes().filter(|_| site.depth > 0);
    1 + attributes.map(|a| a.value().len() as u64).sum::<u64>()
}

/// Pushes the last child first, so that the first one is popped first.
fn push_children<'a, 'i>(site: PendingElement<'a, 'i>, open: &mut Vec<PendingElement<'a, 'i>>) {
    let children = site.element.children().rev().filter(Node::is_element);
    open.extend(children.map(|element| PendingElement { element, ..site }));
}

fn transform_figure(figure: &mut Figure, map: &DAffine2) {
    let map_point = |p: &mut DVec2| *p = map.transform_point2(*p);
    let curves = figure.contours.iter_mut().flat_map(|c| &mut c.curves);
    curves.for_each(|curve| match curve {
        Curve::Line { start } => map_point(start),
        Curve::Cubic {
            start,
            control1,
            control2,
        } => [start, control1, control2].into_iter().for_each(map_point),
    });
}
