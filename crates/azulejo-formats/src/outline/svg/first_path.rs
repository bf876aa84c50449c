//! The first path of a drawing, for text to follow.

use super::stroke;
use super::style::Style;
use super::values::transform;
use super::viewport;
use super::{shapes, with_document};
use crate::outline::pen::Pen;
use crate::reading::text::shortened;
use crate::{Position, ReadError};
use azulejo_scene::FillRule;
use azulejo_scene::figure::Segment;
use glam::{DAffine2, DVec2};
use kurbo::{BezPath, PathSeg, Point};
use roxmltree::Node;

/// Elements that are paths.
const PATHS: [&str; 7] = [
    "path", "line", "polyline", "polygon", "rect", "circle", "ellipse",
];

/// The first contour of the first path or basic shape of a drawing, wherever it is, with all transforms applied, y up.
/// `name` is used in messages.
///
/// # Errors
/// As [`read`](super::read), and a drawing without paths or whose first one has no curves or no finite coordinates.
pub fn first_path(bytes: &[u8], name: &str) -> Result<Vec<Segment>, ReadError> {
    with_document(bytes, name, |xml| {
        let mut paths = xml
            .descendants()
            .filter(|n| PATHS.contains(&n.tag_name().name()));
        let Some(element) = paths.next() else {
            let expected = "a path for the text to follow";
            return Err(ReadError::whole(name, "a drawing without paths", expected));
        };
        let segments = first_contour(element, &viewport::root(xml.root_element()));
        segments.ok_or_else(|| {
            let place = xml.text_pos_at(element.range().start);
            let found = shortened(element.tag_name().name());
            ReadError {
                position: Position::Line(place.row, place.col),
                ..ReadError::whole(
                    name,
                    found,
                    "a path with curves, all transforms well-formed",
                )
            }
        })
    })
}

fn first_contour(element: Node, view: &viewport::RootView) -> Option<Vec<Segment>> {
    let mut map = DAffine2::IDENTITY;
    for node in element.ancestors() {
        if let Some(text) = node.attribute("transform") {
            map = transform(text)? * map;
        }
    }
    let map = view.map * map;
    let units = Style::default().units(view.view);
    let mut pen = Pen::default();
    shapes::draw(element, &units, &mut pen);
    let path = stroke::path(element, &pen.finish(FillRule::NonZero), &units)?;
    let contour = path.elements().iter().enumerate();
    let second = contour
        .filter(|(_, e)| matches!(e, kurbo::PathEl::MoveTo(_)))
        .nth(1);
    let end = second.map_or(path.elements().len(), |(k, _)| k);
    let contour = BezPath::from_vec(path.elements()[..end].to_vec());
    let place = |p: Point| map.transform_point2(DVec2::new(p.x, p.y));
    let segment = |s: PathSeg| match s {
        PathSeg::Line(line) => Segment::Line([place(line.p0), place(line.p1)]),
        PathSeg::Quad(_) | PathSeg::Cubic(_) => {
            let cubic = s.to_cubic();
            Segment::Cubic([cubic.p0, cubic.p1, cubic.p2, cubic.p3].map(place))
        }
    };
    let segments: Vec<Segment> = contour.segments().map(segment).collect();
    let is_finite = |s: &Segment| s.bounds().size().is_finite();
    (!segments.is_empty() && segments.iter().all(is_finite)).then_some(segments)
}
