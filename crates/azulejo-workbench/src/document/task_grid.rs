//! The task plane of a document: where it lies, and its cells.

use super::SceneDocument;
use azulejo::scene::Up;
use glam::DVec3;

/// Limit on the number of points along a side.
pub const MAX_POINTS: u32 = 256;

/// Where the task plane lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaskPlaneSettings {
    /// Height above the lowest point of the model, metres.
    pub height: f64,
    /// Distance from the edges of the model's footprint, metres.
    pub margin: f64,
    /// Numbers of points along x, and along the other horizontal axis.
    pub counts: [u32; 2],
}

impl Default for TaskPlaneSettings {
    /// The height of a desk.
    fn default() -> TaskPlaneSettings {
        TaskPlaneSettings {
            height: 0.8,
            margin: 0.5,
            counts: [16, 12],
        }
    }
}

impl TaskPlaneSettings {
    /// The height of a desk and the usual margin or, in models smaller than a room, shares of their
    /// size.
    pub fn suited_to(document: &SceneDocument) -> TaskPlaneSettings {
        /// A smaller footprint is none of a room, metres.
        const ROOM: f64 = 2.0;
        let usual = TaskPlaneSettings::default();
        let bounds = document.model_bounds();
        if bounds.is_empty() {
            return usual;
        }
        let size = bounds.size() * document.units.metres_per_unit.unwrap_or(1.0);
        let [high, a, b] = match document.units.up {
            Up::Y => [size.y, size.x, size.z],
            Up::Z => [size.z, size.x, size.y],
        };
        let least = a.min(b);
        if least >= ROOM {
            return usual;
        }
        // Two digits, as the window shows them.
        let rounded = |x: f64| format!("{x:.1e}").parse().unwrap_or(x);
        TaskPlaneSettings {
            height: rounded((0.25 * high).min(usual.height)),
            margin: rounded((0.1 * least).min(usual.margin)),
            ..usual
        }
    }
}

/// The cells of a horizontal rectangle, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaskGrid {
    /// The corner of the first cell.
    pub corner: DVec3,
    /// Both sides of a cell.
    pub sides: [DVec3; 2],
    /// Numbers of cells along both sides.
    pub counts: [u32; 2],
    /// Unit normal: the side of the plane that is measured.
    pub up: DVec3,
}

impl TaskGrid {
    /// The grid above the floor of a document; `None` if the margin leaves nothing of its footprint.
    pub fn of(document: &SceneDocument, settings: &TaskPlaneSettings) -> Option<TaskGrid> {
        let bounds = document.model_bounds();
        if bounds.is_empty() {
            return None;
        }
        let units = document.units;
        let metre = 1.0 / units.metres_per_unit.unwrap_or(1.0);
        let up = units.up.axis();
        let across = match units.up {
            Up::Y => [DVec3::X, DVec3::Z],
            Up::Z => [DVec3::X, DVec3::Y],
        };
        let counts = settings.counts.map(|n| n.clamp(1, MAX_POINTS));
        let margin = settings.margin * metre;
        let lengths = across.map(|axis| bounds.size().dot(axis) - 2.0 * margin);
        let is_usable = |x: f64| x.is_finite() && x > 0.0;
        if !lengths.into_iter().all(is_usable) || !settings.height.is_finite() {
            return None;
        }
        let height = bounds.min.dot(up) + settings.height * metre;
        let start = across.map(|axis| (bounds.min.dot(axis) + margin) * axis);
        Some(TaskGrid {
            corner: start[0] + start[1] + height * up,
            sides: [0, 1].map(|k| across[k] * (lengths[k] / f64::from(counts[k]))),
            counts,
            up,
        })
    }

    /// The column and the row of each cell with its corner, row by row.
    pub fn corners(&self) -> impl Iterator<Item = ([u32; 2], DVec3)> {
        let grid = *self;
        let [columns, rows] = grid.counts;
        (0..rows).flat_map(move |row| {
            (0..columns).map(move |column| {
                let [a, b] = grid.sides;
                let corner = grid.corner + f64::from(column) * a + f64::from(row) * b;
                ([column, row], corner)
            })
        })
    }

    /// The column and the row of each cell with its centre.
    pub fn centres(&self) -> impl Iterator<Item = ([u32; 2], DVec3)> {
        let to_centre = 0.5 * (self.sides[0] + self.sides[1]);
        self.corners()
            .map(move |(at, corner)| (at, corner + to_centre))
    }
}
