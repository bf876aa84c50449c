//! Converts the elements of a document to figures of what they fill and stroke.

use super::path::PathProblems;
use super::shapes;
use super::stroke::path;
use super::style::{OwnStyle, Paint, Style};
use super::style_sheet::StyleSheet;
use super::values::{LengthUnits, transform};
use super::viewport;
use crate::outline::clip::Clip;
use crate::outline::drawing::{Drawing, Filled};
#[cfg(feature = "fonts")]
use crate::outline::letters::Letters;
use crate::outline::pen::Pen;
use crate::outline::stroke::{StrokeProblem, stroked};
use crate::reading::options::Budget;
use crate::reading::text::shortened;
use crate::reading::warnings::Warnings;
use crate::{Files, Position, ReadError, ReadOptions};
use azulejo_scene::Figure;
use glam::{DAffine2, DVec2};
use roxmltree::{Document, Node};
use std::collections::HashMap;
use std::rc::Rc;

/// Deepest nesting of `use`; deeper ones are left out, and thereby recursive ones.
const DEEPEST_USE: u32 = 32;

/// Reads all filled shapes.
pub(super) fn read(
    xml: &Document,
    file: &str,
    files: &dyn Files,
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
        clip_depth: 0,
        #[cfg(feature = "fonts")]
        letters: Letters::new(files),
    };
    #[cfg(not(feature = "fonts"))]
    let _ = files;
    let skipped = walk.sheet.not_applied;
    let message =
        "style sheet rule whose selector is not a single class, id or element: not applied";
    walk.warnings
        .add_many(file, message.to_owned(), skipped, || Position::Whole);
    let root = viewport::root(xml.root_element());
    walk.all(vec![PendingElement {
        element: xml.root_element(),
        map: root.map,
        style: Style::default(),
        depth: 0,
        view: root.view,
        clip: None,
        is_clip: false,
        size: [None; 2],
    }])?;
    Ok(Drawing {
        shapes: walk.shapes,
        metres_per_unit: root.metres_per_unit,
        warnings: walk.warnings.finish(file),
    })
}

/// The drawing under construction.
pub(super) struct SvgWalk<'a, 'i> {
    pub xml: &'a Document<'i>,
    file: &'a str,
    warnings: Warnings,
    pub sheet: StyleSheet,
    pub ids: HashMap<&'a str, Node<'a, 'i>>,
    budget: Budget,
    pub shapes: Vec<Filled>,
    /// How many clip paths are being drawn, one inside the other.
    pub clip_depth: u32,
    #[cfg(feature = "fonts")]
    pub letters: Letters<'a>,
}

/// An element to be drawn, with its transform and style.
#[derive(Clone)]
pub(super) struct PendingElement<'a, 'i> {
    pub element: Node<'a, 'i>,
    /// The drawing from its coordinates.
    pub map: DAffine2,
    pub style: Style,
    /// Nesting depth of `use`.
    pub depth: u32,
    /// The size of the nearest viewport, in its units.
    pub view: DVec2,
    /// What it is inside of.
    pub clip: Option<Rc<Clip>>,
    /// Whether it clips others: only what it fills counts.
    pub is_clip: bool,
    /// The width and height that its `use` asks for.
    pub size: [Option<&'a str>; 2],
}

impl PendingElement<'_, '_> {
    /// What its relative lengths refer to.
    pub fn units(&self) -> LengthUnits {
        self.style.units(self.view)
    }
}

impl<'a, 'i> SvgWalk<'a, 'i> {
    /// Draws elements in document order, without recursion: nesting may be as deep as a file is long.
    fn all(&mut self, mut open: Vec<PendingElement<'a, 'i>>) -> Result<(), ReadError> {
        while let Some(site) = open.pop() {
            self.spend(cost(&site))?;
            let Some((style, own)) = site.style.clone().of(site.element, &self.sheet, site.view)
            else {
                continue;
            };
            let map = site.map * self.own_transform(site.element, &style.units(site.view));
            self.note_ignored(&own, site.element);
            let mut site = PendingElement { map, style, ..site };
            let name = site.element.tag_name().name();
            let is_shape = matches!(
                name,
                "path" | "rect" | "circle" | "ellipse" | "polygon" | "polyline" | "line"
            );
            // A shape may be clipped in units of its own outline.
            if let Some(property) = own.clip.as_ref().filter(|_| !is_shape) {
                site.clip = self.clip(&site, property, None)?;
            }
            match name {
                _ if is_shape => self.draw(site, own.clip.as_deref())?,
                "use" => self.follow(site, &mut open),
                #[cfg(feature = "fonts")]
                "text" => self.text(&site)?,
                "svg" | "g" | "a" | "switch" if site.is_clip => self.left_out(name, site.element),
                "svg" if site.element == self.xml.root_element() => push_children(site, &mut open),
                "svg" => self.enter(site, own.overflows, &mut open),
                // Only what is used of it is shown.
                "symbol" if site.depth > 0 => self.enter(site, own.overflows, &mut open),
                "symbol" => {}
                "g" | "a" => push_children(site, &mut open),
                "switch" => open.extend(chosen(site)),
                name => self.left_out(name, site.element),
            }
        }
        Ok(())
    }

    /// Draws the children of an element.
    pub fn children(&mut self, site: PendingElement<'a, 'i>) -> Result<(), ReadError> {
        let mut open = Vec::new();
        push_children(site, &mut open);
        self.all(open)
    }

    pub fn warn(&mut self, message: impl Into<String>, element: Node) {
        let xml = self.xml;
        self.warnings.add(self.file, message.into(), || {
            let start = xml.text_pos_at(element.range().start);
            Position::Line(start.row, start.col)
        });
    }

    /// Counts what is drawn.
    ///
    /// # Errors
    /// It is more than the options allow.
    pub fn spend(&mut self, elements: u64) -> Result<(), ReadError> {
        self.budget.spend(elements).map_err(|e| e.error(self.file))
    }

    /// The element's own transform, and its x and y if it is a `use`.
    fn own_transform(&mut self, element: Node, units: &LengthUnits) -> DAffine2 {
        let map = match element.attribute("transform").map(transform) {
            None => DAffine2::IDENTITY,
            Some(Some(map)) => map,
            Some(None) => {
                self.warn("malformed transform: not applied", element);
                DAffine2::IDENTITY
            }
        };
        if element.tag_name().name() != "use" {
            return map;
        }
        let [x, y] = ["x", "y"].map(|name| units.of(element, name).unwrap_or(0.0));
        map * DAffine2::from_translation(DVec2::new(x, y))
    }

    /// Warns about properties of an element that are not applied.
    fn note_ignored(&mut self, own: &OwnStyle, element: Node) {
        for name in &own.ignored {
            self.warn(format!("{name}: not applied"), element);
        }
    }

    /// Enters an inner viewport, which shows nothing outside of itself.
    fn enter(
        &mut self,
        mut site: PendingElement<'a, 'i>,
        overflows: bool,
        open: &mut Vec<PendingElement<'a, 'i>>,
    ) {
        let Some(inner) = viewport::inner(site.element, site.size, &site.units()) else {
            return;
        };
        if !overflows {
            site.clip = Some(Clip::window(inner.window, &site.map, site.clip));
        }
        site.map *= inner.map;
        site.view = inner.view;
        site.size = [None; 2];
        push_children(site, open);
    }

    fn follow(&mut self, site: PendingElement<'a, 'i>, open: &mut Vec<PendingElement<'a, 'i>>) {
        let element = site.element;
        match self.linked(element) {
            Some(_) if site.depth == DEEPEST_USE => {
                self.warn(
                    format!("use nested more than {DEEPEST_USE} deep: left out"),
                    element,
                );
            }
            Some(target) => open.push(PendingElement {
                element: target,
                depth: site.depth + 1,
                size: ["width", "height"].map(|side| element.attribute(side)),
                ..site
            }),
            None => self.warn("use of an element that does not exist: left out", element),
        }
    }

    /// The element that another refers to.
    pub fn linked(&self, element: Node<'a, 'i>) -> Option<Node<'a, 'i>> {
        const XLINK: &str = "http://www.w3.org/1999/xlink";
        let link = element.attribute("href");
        let link = link.or(element.attribute((XLINK, "href")))?;
        let id = link.trim().strip_prefix('#')?;
        self.ids.get(id).copied()
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
    fn draw(
        &mut self,
        mut site: PendingElement<'a, 'i>,
        clip: Option<&str>,
    ) -> Result<(), ReadError> {
        let element = site.element;
        let (fills, strokes) = site.paints();
        let is_line = element.tag_name().name() == "line";
        let fills = fills && !is_line;
        if !fills && !strokes {
            return Ok(());
        }
        // Draw in the element's own coordinates, and spend by the curves, which each `use` repeats.
        let units = site.units();
        let mut pen = Pen::default();
        let outcome = if is_line {
            Some(PathProblems::default())
        } else {
            shapes::draw(element, &units, &mut pen)
        };
        let Some(outcome) = outcome else {
            self.warn("shape with a length in an unknown unit: left out", element);
            return Ok(());
        };
        self.note(outcome, fills, element);
        let figure = pen.finish(site.rule());
        if let Some(property) = clip {
            let bounds = figure.bounds();
            site.clip = self.clip(&site, property, Some(bounds))?;
        }
        let stroked = strokes.then(|| self.stroked(&figure, &site)).flatten();
        if fills {
            self.add(figure, site.style.fill, &site)?;
        }
        match stroked {
            Some(stroked) => self.add(stroked, site.style.stroke.paint, &site),
            None => Ok(()),
        }
    }

    /// The stroke of a figure in the coordinates of an element.
    pub fn stroked(&mut self, figure: &Figure, site: &PendingElement) -> Option<Figure> {
        let (element, style) = (site.element, &site.style.stroke);
        let pen = style.pen()?;
        let path = path(element, figure, &site.units())?;
        match stroked(path, &pen, &style.dashes, style.dash_offset) {
            Ok(stroked) => Some(stroked),
            Err(StrokeProblem::NoCurve) => None,
            Err(StrokeProblem::Vanishes) => {
                self.warn("stroke too thin to be seen: left out", element);
                None
            }
            Err(StrokeProblem::TooManyDashes) => {
                let message = "stroke-dasharray of too many dashes: stroke left out";
                self.warn(message, element);
                None
            }
        }
    }

    /// Adds a figure in the coordinates of an element.
    pub fn add(
        &mut self,
        mut figure: Figure,
        paint: Paint,
        site: &PendingElement,
    ) -> Result<(), ReadError> {
        let element = site.element;
        let clip_cost = site.clip.as_ref().map_or(0, |clip| clip.cost());
        self.spend(figure.curve_count() as u64 + clip_cost)?;
        if !self.budget.keeps() {
            return Ok(());
        }
        // Even where its coordinates are finite, transforms can make a shape overflow.
        figure.move_points(|p| site.map.transform_point2(p));
        if figure.contours.is_empty() {
            return Ok(());
        }
        if !figure.bounds().size().is_finite() {
            self.warn("shape whose transforms overflow: left out", element);
            return Ok(());
        }
        if let Some(clip) = &site.clip {
            figure = clip.clipped(figure);
        }
        if figure.contours.is_empty() {
            return Ok(());
        }
        // A gradient or a pattern fills the same figure, but without a colour that could be kept.
        let color = match paint {
            Paint::Color(color) => Some(color),
            Paint::None | Paint::Other => None,
        };
        if color.is_none() && !site.is_clip {
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

impl PendingElement<'_, '_> {
    /// Whether it is filled, and whether it is stroked.
    pub fn paints(&self) -> (bool, bool) {
        let style = &self.style;
        let (fills, strokes) = if self.is_clip {
            (true, false)
        } else {
            (style.fill != Paint::None, style.stroke.pen().is_some())
        };
        (fills && style.is_visible, strokes && style.is_visible)
    }

    /// The rule by which it is filled, or clips.
    pub fn rule(&self) -> azulejo_scene::FillRule {
        if self.is_clip {
            self.style.clip_rule
        } else {
            self.style.rule
        }
    }
}

/// What drawing an element takes from the budget: each `use` of it parses its attributes again.
fn cost(site: &PendingElement) -> u64 {
    let repeats = site.depth > 0 || site.is_clip;
    let attributes = site.element.attributes().filter(|_| repeats);
    1 + attributes.map(|a| a.value().len() as u64).sum::<u64>()
}

/// Pushes the last child first, so that the first one is popped first.
fn push_children<'a, 'i>(site: PendingElement<'a, 'i>, open: &mut Vec<PendingElement<'a, 'i>>) {
    let children = site.element.children().rev().filter(Node::is_element);
    open.extend(children.map(|element| PendingElement {
        element,
        ..site.clone()
    }));
}

/// The first child of a `switch` that needs nothing that is not here: SVG 2, 5.8.
fn chosen<'a, 'i>(site: PendingElement<'a, 'i>) -> Option<PendingElement<'a, 'i>> {
    let needs =
        |child: &Node, name: &str| child.attribute(name).is_some_and(|v| !v.trim().is_empty());
    let speaks = |child: &Node| {
        let languages = child.attribute("systemLanguage").unwrap_or("en");
        languages
            .split(',')
            .any(|language| language.trim().starts_with("en"))
    };
    let mut children = site.element.children().filter(Node::is_element);
    let child = children.find(|c| !needs(c, "requiredExtensions") && speaks(c))?;
    Some(PendingElement {
        element: child,
        ..site
    })
}
