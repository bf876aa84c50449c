//! Clipping: what of a shape is inside others.

use azulejo_scene::Figure;
use azulejo_scene::figure::Rectangle;
use glam::{DAffine2, DVec2};
use std::rc::Rc;

/// The inside of figures, in the coordinates of the drawing.
#[derive(Debug)]
pub(crate) struct Clip {
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
        let covers = self.bounds.min.cmpge(own.min).all() && self.bounds.max.cmple(own.max).all();
        if covers && is_rectangle(&figure, own) {
            return self.figure.clone();
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
