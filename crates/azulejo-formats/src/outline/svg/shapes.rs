//! Basic shapes: rectangles, circles, ellipses, polygons.

use super::path::{self, PathProblems};
use super::values::{LengthUnits, numbers};
use crate::outline::pen::{Ellipse, Pen};
use glam::DVec2;
use roxmltree::Node;
use std::f64::consts::FRAC_PI_2;

/// Draws the outline of a shape; `None` for other elements, and for those with lengths that are none.
pub(super) fn draw(element: Node, units: &LengthUnits, pen: &mut Pen) -> Option<PathProblems> {
    let value = |name: &str| units.of(element, name);
    match element.tag_name().name() {
        "path" => return Some(path::draw(element.attribute("d").unwrap_or(""), pen)),
        "rect" => {
            let corner = DVec2::new(value("x")?, value("y")?);
            let size = DVec2::new(value("width")?, value("height")?);
            if size.min_element() > 0.0 {
                rectangle(corner, size, radii(element, units, size)?, pen);
            }
        }
        "circle" | "ellipse" => {
            let radii = match element.attribute("r") {
                Some(_) => DVec2::splat(value("r")?),
                None => DVec2::new(value("rx")?, value("ry")?),
            };
            if radii.min_element() > 0.0 {
                let centre = DVec2::new(value("cx")?, value("cy")?);
                pen.ellipse(upright(centre, radii));
            }
        }
        "polygon" => return Some(polygon(element, true, pen)),
        "polyline" => return Some(polygon(element, false, pen)),
        _ => return None,
    }
    Some(PathProblems::default())
}

fn upright(centre: DVec2, radii: DVec2) -> Ellipse {
    Ellipse {
        centre,
        x: DVec2::new(radii.x, 0.0),
        y: DVec2::new(0.0, radii.y),
    }
}

/// Corner radii of a rectangle: one sets both, and they are at most half the sides.
fn radii(element: Node, units: &LengthUnits, size: DVec2) -> Option<DVec2> {
    let radius = |name: &str| match element.attribute(name) {
        Some(text) if text.trim() != "auto" => units.length(name, text).map(|r| Some(r.max(0.0))),
        _ => Some(None),
    };
    let (x, y) = (radius("rx")?, radius("ry")?);
    let both = DVec2::new(x.or(y).unwrap_or(0.0), y.or(x).unwrap_or(0.0));
    Some(both.min(0.5 * size))
}

fn rectangle(corner: DVec2, size: DVec2, radii: DVec2, pen: &mut Pen) {
    let is_round = radii.min_element() > 0.0;
    let radii = if is_round { radii } else { DVec2::ZERO };
    // From the top left, y down: the sides, and the corner that ends each.
    let turns = [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)].map(DVec2::from);
    pen.move_to(corner + DVec2::new(radii.x, 0.0));
    for (k, toward) in turns.into_iter().enumerate() {
        let along = DVec2::from([(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][k]);
        let next = along.perp();
        let at = corner + size * toward;
        let side_end = at - radii * along;
        if side_end != pen.at() {
            pen.line_to(side_end);
        }
        if is_round {
            let centre = at - radii * along + radii * next;
            let start = -FRAC_PI_2 + FRAC_PI_2 * k as f64;
            pen.arc_to(upright(centre, radii), start, FRAC_PI_2, at + radii * next);
        }
    }
    pen.close();
}

/// Lines through points; an odd number at the end is an error.
fn polygon(element: Node, is_closed: bool, pen: &mut Pen) -> PathProblems {
    let (coordinates, is_cut) = numbers(element.attribute("points").unwrap_or(""));
    let (points, odd) = coordinates.as_chunks();
    for (k, &[x, y]) in points.iter().enumerate() {
        match k {
            0 => pen.move_to(DVec2::new(x, y)),
            _ => pen.line_to(DVec2::new(x, y)),
        }
    }
    let comes_back = pen.close();
    PathProblems {
        open: usize::from(!is_closed && !comes_back && !points.is_empty()),
        is_cut: is_cut || !odd.is_empty(),
    }
}
