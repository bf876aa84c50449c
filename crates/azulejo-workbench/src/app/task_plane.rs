//! The task plane: irradiance on a horizontal grid above the floor, as standards for the lighting
//! of work places ask for.

use super::table::{CsvTable, cell};
use super::{App, JobResult, Severity};
use crate::app::light_unit::ShownUnit;
use crate::document::{SceneDocument, TaskGrid, TaskPlaneSettings, same_light};
use crate::first_pass::measure_in_space;
use crate::jobs::JobKind;
use azulejo::factors::PointNormal;
use azulejo::radiosity::Estimate;
use std::borrow::Cow;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

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
    document: SceneDocument,
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

impl TaskPlane {
    /// A new result.
    pub(super) fn new(
        grid: TaskGrid,
        cells: Vec<Option<Estimate>>,
        document: SceneDocument,
    ) -> TaskPlane {
        static NUMBER: AtomicU64 = AtomicU64::new(1);
        TaskPlane {
            number: NUMBER.fetch_add(1, Ordering::Relaxed),
            grid,
            cells,
            document,
        }
    }

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
        self.task_plane.is_added = true;
        let Some(grid) = TaskGrid::of(&self.document, &self.task_plane.settings) else {
            return self.fail(self.tr("the margin leaves no area of the model's footprint"));
        };
        let (document, settings) = (self.document.clone(), self.lighting.settings);
        let title = self.tr("task plane");
        self.start_job(JobKind::TaskPlane, title, move |progress, outbox| {
            let place = |(_, position)| PointNormal {
                position,
                normal: grid.up,
            };
            let points: Vec<PointNormal> = grid.centres().map(place).collect();
            if let Some(cells) = measure_in_space(&document, &settings, &points, progress)? {
                let plane = TaskPlane::new(grid, cells, document);
                outbox.send(JobResult::TaskPlane(Box::new(plane)));
            }
            Ok(())
        });
    }

    pub(super) fn take_task_plane(&mut self, plane: TaskPlane) {
        if same_light(&plane.document, &self.document) {
            self.task_plane.result = Some(plane);
        } else {
            let text =
                self.tr("the model changed while the task plane was measured: measure again");
            self.report(Severity::Warning, text);
        }
    }

    /// Forgets what was measured in another state of the document.
    pub(super) fn refresh_task_plane(&mut self) {
        let result = self.task_plane.result.as_ref();
        if result.is_some_and(|plane| !same_light(&plane.document, &self.document)) {
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
            return self.fail(self.tr("the task plane has not been measured yet"));
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
