//! The task plane in the viewport: its cells in false colours.

use crate::app::TaskPlane;
use crate::gpu::{ColorScale, Overlay, OverlayStyle};

/// Opacity of the cells: what lies below remains visible.
const OPACITY: u8 = 225;
/// The outline.
const EDGE: [u8; 3] = [240, 240, 240];

/// Adds the cells to an overlay, and an outline of all of them.
pub fn draw(overlay: &mut Overlay, plane: &TaskPlane, scale: &ColorScale) {
    let grid = &plane.grid;
    let [a, b] = grid.sides;
    for ((_, corner), cell) in grid.corners().zip(&plane.cells) {
        let Some(estimate) = cell else {
            continue;
        };
        let [red, green, blue] = scale.map.color(scale.fraction(estimate.value.luminance()));
        let ink = OverlayStyle {
            color: [red, green, blue, OPACITY],
            ..OverlayStyle::new(EDGE, 1.0)
        };
        overlay.parallelogram(corner, a, b, ink);
    }
    let [a, b] = [a * f64::from(grid.counts[0]), b * f64::from(grid.counts[1])];
    let corners = [
        grid.corner,
        grid.corner + a,
        grid.corner + a + b,
        grid.corner + b,
    ];
    overlay.polyline(&corners, true, OverlayStyle::new(EDGE, 1.5));
}
