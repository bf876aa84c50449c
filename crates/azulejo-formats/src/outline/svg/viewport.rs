//! Viewports: the element `svg` at the root and inside, and `symbol`.

use super::values::{LengthUnits, length, numbers};
use glam::{DAffine2, DVec2};
use roxmltree::Node;
use svgtypes::{Align, AspectRatio};

/// The rectangle of a viewBox: its corner and its size.
fn view_box(element: Node) -> Option<[DVec2; 2]> {
    match numbers(element.attribute("viewBox").unwrap_or_default()).0[..] {
        [x, y, width, height] if width > 0.0 && height > 0.0 => {
            Some([DVec2::new(x, y), DVec2::new(width, height)])
        }
        _ => None,
    }
}

/// How a viewBox is fitted into its viewport.
fn aspect(element: Node) -> AspectRatio {
    let text = element.attribute("preserveAspectRatio");
    let parsed = text.and_then(|text| text.trim().parse().ok());
    parsed.unwrap_or(AspectRatio {
        defer: false,
        align: Align::XMidYMid,
        slice: false,
    })
}

/// The lengths of the units of a viewBox of a size in a viewport, SVG 2, 8.2.
fn scale(aspect: AspectRatio, view: DVec2, viewport: DVec2) -> DVec2 {
    let scale = viewport / view;
    match aspect.align {
        Align::None => scale,
        _ if aspect.slice => DVec2::splat(scale.max_element()),
        _ => DVec2::splat(scale.min_element()),
    }
}

/// Which share of the room that is left is before the content.
fn before(align: Align) -> DVec2 {
    let x = match align {
        Align::None | Align::XMinYMin | Align::XMinYMid | Align::XMinYMax => 0.0,
        Align::XMidYMin | Align::XMidYMid | Align::XMidYMax => 0.5,
        Align::XMaxYMin | Align::XMaxYMid | Align::XMaxYMax => 1.0,
    };
    let y = match align {
        Align::None | Align::XMinYMin | Align::XMidYMin | Align::XMaxYMin => 0.0,
        Align::XMinYMid | Align::XMidYMid | Align::XMaxYMid => 0.5,
        Align::XMinYMax | Align::XMidYMax | Align::XMaxYMax => 1.0,
    };
    DVec2::new(x, y)
}

/// What the element at the root shows.
pub(super) struct RootView {
    /// Turns y up, with the lower left corner of the view at the origin.
    pub map: DAffine2,
    /// The size of the view, user units.
    pub view: DVec2,
    /// The length of a unit in metres, if the drawing has a physical size.
    pub metres_per_unit: Option<f64>,
}

/// The view of the root, whose own units are those of the drawing.
pub(super) fn root(element: Node) -> RootView {
    const METRES: f64 = 0.0254 / 96.0;
    // What browsers take where nothing is said.
    const USUAL: DVec2 = DVec2::new(300.0, 150.0);
    let side = |name: &str| {
        element
            .attribute(name)
            .and_then(length)
            .filter(|(s, _)| *s > 0.0)
    };
    let (width, height) = (side("width"), side("height"));
    let is_physical = width.is_some_and(|(_, is_physical)| is_physical);
    let given = view_box(element);
    let aspect = aspect(element);
    // A unit of the drawing is as long as one across; only where the view is stretched is one up another.
    let (across, up) = match (given, width, height) {
        (Some([_, view]), Some((width, _)), Some((height, _))) => {
            let scale = scale(aspect, view, DVec2::new(width, height));
            (scale.x, scale.y / scale.x)
        }
        (Some([_, view]), Some((width, _)), None) => (width / view.x, 1.0),
        _ => (1.0, 1.0),
    };
    let [corner, view] = given.unwrap_or_else(|| {
        let height = height.map_or(0.0, |(height, _)| height);
        [
            DVec2::ZERO,
            DVec2::new(width.map_or(USUAL.x, |(width, _)| width), height),
        ]
    });
    let bottom = corner.y + view.y;
    RootView {
        map: DAffine2::from_cols_array(&[1.0, 0.0, 0.0, -up, -corner.x, up * bottom]),
        view: if view.y > 0.0 {
            view
        } else {
            DVec2::new(view.x, USUAL.y)
        },
        metres_per_unit: is_physical.then_some(METRES * across),
    }
}

/// What an inner `svg`, or a `symbol` in its place, shows.
pub(super) struct InnerView {
    /// Its content in the coordinates around it.
    pub map: DAffine2,
    /// The size of its view, in its own units.
    pub view: DVec2,
    /// The rectangle that it shows, in the coordinates around it.
    pub window: [DVec2; 2],
}

/// The view of an inner element, at its x and y. `size` is what a `use` says of its width and height. `None` if it shows
/// nothing: SVG 2, 8.2.
pub(super) fn inner(
    element: Node,
    size: [Option<&str>; 2],
    units: &LengthUnits,
) -> Option<InnerView> {
    let side = |name: &str, own: Option<&str>, whole: f64| {
        let text = own.or(element.attribute(name));
        text.map_or(Some(whole), |text| match text.trim() {
            "auto" => Some(whole),
            text => units.length(name, text),
        })
    };
    let corner = match element.tag_name().name() {
        "svg" => DVec2::new(units.of(element, "x")?, units.of(element, "y")?),
        _ => DVec2::ZERO,
    };
    let viewport = DVec2::new(
        side("width", size[0], units.view.x)?,
        side("height", size[1], units.view.y)?,
    );
    if viewport.min_element() <= 0.0 {
        return None;
    }
    let whole = [DVec2::ZERO, viewport];
    let [view_corner, view] = view_box(element).unwrap_or(whole);
    let aspect = aspect(element);
    let scale = scale(aspect, view, viewport);
    let room = before(aspect.align) * (viewport - scale * view);
    Some(InnerView {
        map: DAffine2::from_scale_angle_translation(
            scale,
            0.0,
            corner + room - scale * view_corner,
        ),
        view,
        window: [corner, corner + viewport],
    })
}
