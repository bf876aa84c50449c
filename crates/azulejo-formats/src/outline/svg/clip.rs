//! Clipping: what of a shape is inside others.

use super::style::Style;
use super::values::transform;
use super::walk::{PendingElement, SvgWalk};
use crate::ReadError;
use azulejo_scene::figure::Rectangle;
use azulejo_scene::{Figure, FillRule};
use glam::{DAffine2, DVec2};
use std::rc::Rc;

/// Deepest nesting of clip paths; deeper ones, and thereby those that clip themselves, are not applied.
const DEEPEST: u32 = 8;

/// The inside of figures, in the coordinates of the drawing.
#[derive(Debug)]
pub(super) struct Clip {
    figure: Figure,
    bounds: Rectangle,
    /// Whether it is all of its bounds.
    is_rectangle: bool,
    /// What it is inside of.
    outer: Option<Rc<Clip>>,
}

impl Clip {
    /// The inside of a figure and of another clip.
    pub fn new(figure: Figure, outer: Option<Rc<Clip>>) -> Rc<Clip> {
        let bounds = figure.bounds();
        Rc::new(Clip {
            is_rectangle: is_rectangle(&figure, bounds),
            bounds,
            figure,
            outer,
        })
    }

    /// The inside of a rectangle under a map, and of another clip.
    pub fn window([min, max]: [DVec2; 2], map: &DAffine2, outer: Option<Rc<Clip>>) -> Rc<Clip> {
        let corners = [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)];
        let corners = corners.map(|corner| map.transform_point2(corner));
        Clip::new(Figure::polygon(corners), outer)
    }

    /// The curves to compare a figure with, so that they can be counted first.
    pub fn cost(&self) -> u64 {
        let outer = self.outer.as_ref().map_or(0, |outer| outer.cost());
        outer + self.figure.curve_count() as u64
    }

    /// What of a figure is inside.
    pub fn clipped(&self, figure: Figure) -> Figure {
        let figure = match &self.outer {
            Some(outer) => outer.clipped(figure),
            None => figure,
        };
        let own = figure.bounds();
        let is_apart = own.max.cmple(self.bounds.min).any() || own.min.cmpge(self.bounds.max).any();
        if figure.contours.is_empty() || self.figure.contours.is_empty() || is_apart {
            return Figure::default();
        }
        let is_within =
            own.min.cmpge(self.bounds.min).all() && own.max.cmple(self.bounds.max).all();
        if self.is_rectangle && is_within {
            return figure;
        }
        figure.intersection(&self.figure)
    }
}

/// Whether a figure is the rectangle of its bounds.
fn is_rectangle(figure: &Figure, bounds: Rectangle) -> bool {
    let area = bounds.size().x * bounds.size().y;
    figure.contours.len() == 1
        && figure.curve_count() == 4
        && figure.signed_area().abs() >= area * (1.0 - 1e-12)
}

impl<'a, 'i> SvgWalk<'a, 'i> {
    /// What an element with the property `clip-path` is clipped by: all that clips what is around it, and the shapes that
    /// the property names. `bounds` are those of the element's own outline, in its coordinates, where it is a shape.
    ///
    /// # Errors
    /// The drawing expands to more than the options allow.
    pub(super) fn clip(
        &mut self,
        site: &PendingElement<'a, 'i>,
        property: &str,
        bounds: Option<Rectangle>,
    ) -> Result<Option<Rc<Clip>>, ReadError> {
        let outer = site.clip.clone();
        let link = property
            .trim()
            .strip_prefix("url(")
            .and_then(|rest| rest.split_once(')'));
        let Some((link, _)) = link else {
            self.warn("clip-path that names no element: not applied", site.element);
            return Ok(outer);
        };
        let id = link
            .trim()
            .trim_matches(['"', '\''])
            .trim_start_matches('#');
        let target = self.ids.get(id).copied();
        let Some(target) = target.filter(|t| t.tag_name().name() == "clipPath") else {
            self.warn("clip-path that does not exist: not applied", site.element);
            return Ok(outer);
        };
        if self.clip_depth == DEEPEST {
            let message = format!("clip-path nested more than {DEEPEST} deep: not applied");
            self.warn(message, site.element);
            return Ok(outer);
        }
        let mut map = site.map;
        if let Some(own) = target.attribute("transform") {
            map *= transform(own).unwrap_or(DAffine2::IDENTITY);
        }
        if target.attribute("clipPathUnits") == Some("objectBoundingBox") {
            let Some(bounds) = bounds else {
                let message = "clip-path in units of the box of a group: not applied";
                self.warn(message, site.element);
                return Ok(outer);
            };
            map *= DAffine2::from_scale_angle_translation(bounds.size(), 0.0, bounds.min);
        }
        let inside = PendingElement {
            element: target,
            map,
            style: Style::default(),
            is_clip: true,
            ..site.clone()
        };
        self.clip_depth += 1;
        let figure = self.figure_of_children(inside);
        self.clip_depth -= 1;
        Ok(Some(Clip::new(figure?, outer)))
    }

    /// All that the children of a clip path fill, as one figure.
    fn figure_of_children(&mut self, inside: PendingElement<'a, 'i>) -> Result<Figure, ReadError> {
        // What clips the clip path itself has the same coordinates.
        let own = Style::default().of(inside.element, &self.sheet, inside.view);
        let property = own.and_then(|(_, own)| own.clip);
        let clip = match property {
            Some(property) => {
                let plain = PendingElement {
                    clip: None,
                    ..inside.clone()
                };
                self.clip(&plain, &property, None)?
            }
            None => None,
        };
        let outside = std::mem::take(&mut self.shapes);
        let walked = self.children(PendingElement { clip, ..inside });
        let shapes = std::mem::replace(&mut self.shapes, outside);
        walked?;
        let figures: Vec<&Figure> = shapes.iter().map(|shape| &shape.figure).collect();
        Ok(match figures[..] {
            [] => Figure::default(),
            [only] if only.rule == FillRule::NonZero => only.clone(),
            _ => Figure::union(&figures),
        })
    }
}
