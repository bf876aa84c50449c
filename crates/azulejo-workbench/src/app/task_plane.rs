//! The task plane: irradiance on a horizontal grid above the floor, as standards for the lighting
//! of work places ask for.

use super::table::{CsvTable, cell};
use super::{App, JobResult, Severity};
use crate::app::light_unit::ShownUnit;
use crate::document::{SceneDocument, same_light};
use crate::first_pass::measure_in_space;
use crate::jobs::{JobKind, JobSender, in_thread_pool};
use azulejo::factors::PointNormal;
use azulejo::radiosity::Estimate;
use azulejo::scene::Up;
use azulejo::trace::Progress;
use glam::DVec3;
use std::borrow::Cow;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

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

/// The task plane of the document.
#[derive(Clone, Debug, Default)]
pub struct TaskPlaneState {
    /// Where it lies.
    pub settings: TaskPlaneSettings,
    /// Whether the user has added one.
    pub is_added: bool,
    /// What was measured, unless the model has changed since.
    pub result: Option<TaskPlane>,
}

/// Irradiance on the cells of a horizontal rectangle.
#[derive(Clone, Debug)]
pub struct TaskPlane {
    /// Unique for each result.
    pub number: u64,
    /// Where the cells lie.
    pub grid: TaskGrid,
    /// Irradiance at the centres of the cells, in the order of [`TaskGrid::centres`]; `None` inside of
    /// solids.
    pub cells: Vec<Option<Estimate>>,
    /// The document in which it was measured.
    of: SceneDocument,
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

/// A number with its standard error.
pub type Measured = (f64, f64);

/// The figures by which standards judge a task plane; irradiance is in the unit of the document.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaskPlaneFigures {
    /// Smallest irradiance.
    pub least: Measured,
    /// Mean irradiance.
    pub mean: Measured,
    /// Largest irradiance.
    pub most: Measured,
    /// U0, the smallest irradiance relative to the mean.
    pub uniformity: Measured,
    /// The smallest irradiance relative to the largest.
    pub diversity: Measured,
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

impl TaskPlane {
    /// The figures of all cells outside of solids; `None` if there are none.
    pub fn figures(&self) -> Option<TaskPlaneFigures> {
        let values = self.cells.iter().flatten();
        let values: Vec<Measured> = values
            .map(|e| (e.value.luminance(), e.error.luminance()))
            .collect();
        let by_value = |a: &&Measured, b: &&Measured| a.0.total_cmp(&b.0);
        let least = *values.iter().min_by(by_value)?;
        let most = *values.iter().max_by(by_value)?;
        let count = values.len() as f64;
        let sum: f64 = values.iter().map(|v| v.0).sum();
        let squares: f64 = values.iter().map(|v| v.1 * v.1).sum();
        let mean = (sum / count, squares.sqrt() / count);
        Some(TaskPlaneFigures {
            least,
            mean,
            most,
            uniformity: ratio(least, mean),
            diversity: ratio(least, most),
        })
    }
}

/// A quotient of two independent numbers; 0 of nothing.
fn ratio(a: Measured, b: Measured) -> Measured {
    if b.0 <= 0.0 {
        return (0.0, 0.0);
    }
    let quotient = a.0 / b.0;
    (quotient, (a.1 / b.0).hypot(quotient * b.1 / b.0))
}

impl App {
    /// Adds a task plane that suits the model, and measures it.
    pub(super) fn add_task_plane(&mut self) {
        if !self.task_plane.is_added {
            self.task_plane.settings = TaskPlaneSettings::suited_to(&self.document);
        }
        self.measure_task_plane();
    }

    /// Measures the task plane in the background.
    pub(super) fn measure_task_plane(&mut self) {
        self.jobs.cancel_kind(JobKind::TaskPlane);
        self.task_plane.is_added = true;
        let Some(grid) = TaskGrid::of(&self.document, &self.task_plane.settings) else {
            let text = self.tr("the margin leaves nothing of the model's footprint");
            self.report(Severity::Error, text);
            return;
        };
        let (of, settings) = (self.document.clone(), self.lighting.settings);
        let threads = self.preferences.threads;
        let work = move |progress: &Progress, outbox: &JobSender<JobResult>| {
            let place = |(_, position)| PointNormal {
                position,
                normal: grid.up,
            };
            let points: Vec<PointNormal> = grid.centres().map(place).collect();
            let measured = || measure_in_space(&of, &settings, &points, progress);
            if let Some(cells) = in_thread_pool(threads, measured)? {
                static NUMBER: AtomicU64 = AtomicU64::new(1);
                outbox.send(JobResult::TaskPlane(Box::new(TaskPlane {
                    number: NUMBER.fetch_add(1, Ordering::Relaxed),
                    grid,
                    cells,
                    of,
                })));
            }
            Ok(())
        };
        let title = self.tr("task plane");
        self.jobs.start(JobKind::TaskPlane, title, work);
    }

    pub(super) fn take_task_plane(&mut self, found: TaskPlane) {
        if same_light(&found.of, &self.document) {
            self.task_plane.result = Some(found);
        } else {
            let text =
                self.tr("the model changed while the task plane was measured: measure again");
            self.report(Severity::Warning, text);
        }
    }

    /// Forgets what was measured in another state of the document.
    pub(super) fn refresh_task_plane(&mut self) {
        let result = self.task_plane.result.as_ref();
        if result.is_some_and(|plane| !same_light(&plane.of, &self.document)) {
            self.task_plane.result = None;
        }
    }

    pub(super) fn remove_task_plane(&mut self) {
        self.jobs.cancel_kind(JobKind::TaskPlane);
        self.task_plane.result = None;
        self.task_plane.is_added = false;
    }

    /// Writes the points of the task plane in the unit that is shown.
    pub(super) fn save_task_plane(&mut self, path: PathBuf) {
        self.asking = None;
        let Some(plane) = &self.task_plane.result else {
            let text = self.tr("the task plane has not been measured yet");
            self.report(Severity::Error, text);
            return;
        };
        let unit = ShownUnit::of(self);
        let headings = [
            "column",
            "row",
            "x",
            "y",
            "z",
            "E",
            "standard error",
            "unit",
        ];
        let mut table = CsvTable::new(&headings);
        for ((at, centre), estimate) in plane.grid.centres().zip(&plane.cells) {
            let Some(estimate) = estimate else {
                continue;
            };
            let light = [estimate.value, estimate.error].map(|e| unit.rgb(e).luminance());
            let place = at.map(|k| Cow::from((k + 1).to_string()));
            let numbers = centre.to_array().into_iter().chain(light);
            let numbers = numbers.map(|x| cell(Some(x)));
            let unit = [Cow::from(unit.irradiance())];
            table.row(place.into_iter().chain(numbers).chain(unit));
        }
        self.save_table(path, table);
    }
}

#[cfg(test)]
mod tests;
