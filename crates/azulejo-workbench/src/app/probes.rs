//! Probes: pinned surface points at which the light is displayed.

use super::table::{CsvTable, cell};
use super::{App, JobResult, Severity};
use crate::app::light_unit::ShownUnit;
use crate::document::{
    SceneDocument, SceneObject, ShadingPoint, Solution, SurfacePick, same_light,
};
use crate::first_pass::measure;
use crate::gpu::display_mesh;
use crate::jobs::JobKind;
use azulejo::radiosity::Estimate;
use azulejo::scene::{Mesh, Rgb, Shape};
use glam::DVec3;
use std::borrow::Cow;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

/// A pinned surface point.
#[derive(Clone, Debug)]
pub struct Probe {
    /// Unique within the session.
    pub number: u64,
    /// The point and the side of the surface.
    pub pick: SurfacePick,
    /// The surface at this point now; `None` if it was moved away or deleted.
    pub site: Option<ProbeSurface>,
    /// Irradiance measured at the point itself, if this was requested.
    pub measured: Option<Estimate>,
}

/// The surface under a probe.
#[derive(Clone, Debug)]
pub struct ProbeSurface {
    /// Index of the face in the polygons that display the object.
    pub face: u32,
    /// Material and side of the surface; light is stored for front sides only.
    pub paint: ShadingPoint,
    /// Irradiance interpolated between the vertices, with its standard error where known.
    pub light: Option<(Rgb, Option<Rgb>)>,
    /// The shape that these values were read from.
    shape: Arc<Shape>,
}

/// Irradiance measured at probes, by their numbers, and the document it was measured in.
pub struct ProbeMeasurement {
    document: SceneDocument,
    estimates: Vec<(u64, Estimate)>,
}

impl ProbeMeasurement {
    /// Estimates by the numbers of the probes, in a document.
    pub(super) fn new(
        document: SceneDocument,
        estimates: Vec<(u64, Estimate)>,
    ) -> ProbeMeasurement {
        ProbeMeasurement {
            document,
            estimates,
        }
    }

    /// The estimates by the numbers of the probes.
    #[cfg(any(test, target_arch = "wasm32"))]
    pub(super) fn estimates(&self) -> &[(u64, Estimate)] {
        &self.estimates
    }
}

impl Probe {
    /// Updates the probe if the surface or its light may have changed.
    fn refresh(&mut self, document: &SceneDocument, solution: Option<&Solution>) {
        let item = document.object(self.pick.item);
        let lit = item.and_then(|item| solution?.shown(item));
        let Some((item, shape)) = item.map(|item| (item, lit.unwrap_or(&item.shape))) else {
            self.site = None;
            return;
        };
        // An object that has not moved since it was solved has a lit shape of its own.
        let is_same = |site: &ProbeSurface| lit.is_some() && Arc::ptr_eq(&site.shape, shape);
        if !self.site.as_ref().is_some_and(is_same) {
            let face = self.site.as_ref().map(|site| site.face);
            self.site = site(&self.pick, item, shape, lit.is_some(), face);
        }
    }
}

/// Finds the surface at a point: the nearest face, unless it is too far away. `face` is the one
/// found last time, which is still the nearest as long as the point lies on it.
fn site(
    pick: &SurfacePick,
    item: &SceneObject,
    shape: &Arc<Shape>,
    is_lit: bool,
    face: Option<u32>,
) -> Option<ProbeSurface> {
    const MAX_DISTANCE: f64 = 0.01;
    const ON: f64 = 1e-7;
    let size = item.bounds().diagonal();
    // Skip the search while an object is being dragged far away from the probe.
    let bounds = item.bounds();
    let inside = pick.position.clamp(bounds.min, bounds.max);
    if bounds.is_empty() || pick.position.distance(inside) > MAX_DISTANCE * size {
        return None;
    }
    let local = if is_lit {
        glam::DAffine3::IDENTITY
    } else {
        item.placement.inverse()
    };
    let scale = local.matrix3.determinant().abs().cbrt();
    let mesh = display_mesh(shape, (1e-3 * size * scale).max(f64::MIN_POSITIVE), is_lit);
    let position = local.transform_point3(pick.position);
    let last = face.and_then(|f| nearest(&mesh, f as usize..(f as usize + 1), position));
    let last = last.filter(|last| last.distance <= ON * size * scale);
    let nearest = last.or_else(|| nearest(&mesh, 0..mesh.faces.len(), position))?;
    if nearest.distance > MAX_DISTANCE * size * scale {
        return None;
    }
    let [a, b, c] = nearest.corners.map(|v| mesh.positions[v as usize]);
    // World normals are object normals times the inverse transpose of the placement.
    let normal = local.matrix3.transpose() * (b - a).cross(c - a);
    let is_front = normal.dot(pick.normal) > 0.0;
    let face = nearest.face as usize;
    Some(ProbeSurface {
        face: nearest.face,
        paint: ShadingPoint::at(&mesh, face, nearest.corners, nearest.weights, is_front)?,
        light: is_lit.then(|| nearest.light(&mesh)).flatten(),
        shape: Arc::clone(shape),
    })
}

/// A point on a mesh.
struct NearestPoint {
    face: u32,
    corners: [u32; 3],
    weights: [f64; 3],
    distance: f64,
}

impl NearestPoint {
    fn light(&self, mesh: &Mesh) -> Option<(Rgb, Option<Rgb>)> {
        let mean = |values: &[Rgb]| {
            let mut sum = Rgb::BLACK;
            for (&corner, weight) in self.corners.iter().zip(self.weights) {
                sum += *values.get(corner as usize)? * weight;
            }
            Some(sum)
        };
        let irradiance = mean(&mesh.irradiance)?;
        Some((irradiance, mean(&mesh.irradiance_error)))
    }
}

/// The point of the given faces of a mesh that is nearest to `point`.
fn nearest(mesh: &Mesh, faces: Range<usize>, point: DVec3) -> Option<NearestPoint> {
    let mut best: Option<NearestPoint> = None;
    let mut triangles = Vec::new();
    for face in faces.start..faces.end.min(mesh.faces.len()) {
        triangles.clear();
        mesh.triangulate_into(face, &mut triangles);
        for triangle in &triangles {
            let corners = triangle.map(|c| mesh.faces.get(face)[c as usize]);
            let p = corners.map(|v| mesh.positions[v as usize]);
            let weights = nearest_weights(point, p);
            let there = weights[0] * p[0] + weights[1] * p[1] + weights[2] * p[2];
            let distance = there.distance(point);
            if best.as_ref().is_none_or(|b| distance < b.distance) {
                best = Some(NearestPoint {
                    face: face as u32,
                    corners,
                    weights,
                    distance,
                });
            }
        }
    }
    best
}

/// Barycentric coordinates of the point of a triangle nearest to `p` (Ericson 2005, section 5.1.5).
fn nearest_weights(p: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(p - a), ac.dot(p - a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = d1 / (d1 - d3);
        return [1.0 - v, v, 0.0];
    }
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = d2 / (d2 - d6);
        return [1.0 - w, 0.0, w];
    }
    let va = d3 * d6 - d5 * d4;
    let (along, back) = (d4 - d3, d5 - d6);
    if va <= 0.0 && along >= 0.0 && back >= 0.0 {
        let w = along / (along + back);
        return [0.0, 1.0 - w, w];
    }
    let sum = va + vb + vc;
    [va / sum, vb / sum, vc / sum]
}

/// The columns of the table of probes.
const PROBE_COLUMNS: [&str; 14] = [
    "number",
    "object",
    "material",
    "x",
    "y",
    "z",
    "nx",
    "ny",
    "nz",
    "E",
    "standard error",
    "measured E",
    "standard error of measured E",
    "unit",
];

impl App {
    /// Pins a probe at a picked point.
    pub(super) fn add_probe(&mut self, pick: SurfacePick) {
        const MAX_PROBES: usize = 100;
        if self.probes.len() >= MAX_PROBES {
            return self
                .fail(self.tr("the maximum number of probes is reached: remove some first"));
        }
        self.pinned += 1;
        self.probes.push(Probe {
            number: self.pinned,
            pick,
            site: None,
            measured: None,
        });
        self.refresh_probes();
    }

    pub(super) fn remove_probe(&mut self, number: u64) {
        self.probes.retain(|p| p.number != number);
    }

    /// Drops what was measured: with other settings it would be something else.
    pub(super) fn forget_measurements(&mut self) {
        self.measured_in = None;
        self.probes.iter_mut().for_each(|p| p.measured = None);
    }

    /// Updates all probes after a change of the document or its light. Measurements are valid for
    /// one document only.
    pub(super) fn refresh_probes(&mut self) {
        let solution = self.lighting.solution.as_deref();
        let document = &self.document;
        for probe in &mut self.probes {
            probe.refresh(document, solution);
        }
        if (self.measured_in.as_ref()).is_some_and(|then| !same_light(then, document)) {
            self.forget_measurements();
        }
    }

    pub(super) fn drop_probes(&mut self) {
        self.jobs.cancel_kind(JobKind::Probe);
        self.probes.clear();
        self.measured_in = None;
    }

    /// Measures the irradiance at all probes in the background.
    pub(super) fn measure_probes(&mut self) {
        if self.probes.is_empty() {
            return;
        }
        let (document, settings) = (self.document.clone(), self.lighting.settings);
        let (numbers, places): (Vec<u64>, Vec<SurfacePick>) =
            self.probes.iter().map(|p| (p.number, p.pick)).unzip();
        let title = self.tr("probes");
        self.start_job(JobKind::Probe, title, move |progress, outbox| {
            let estimates = measure(&document, &settings, &places, progress)?;
            let estimates = numbers.into_iter().zip(estimates).collect();
            let measurement = ProbeMeasurement::new(document, estimates);
            outbox.send(JobResult::Measured(Box::new(measurement)));
            Ok(())
        });
    }

    /// Writes the table of probes in the unit that is shown.
    pub(super) fn save_probes(&mut self, path: PathBuf) {
        self.asking = None;
        if self.probes.is_empty() {
            return self.fail(self.tr("there are no probes yet: pin one first"));
        }
        let table = self.probe_table();
        self.save_table(path, table);
    }

    fn probe_table(&self) -> CsvTable {
        let unit = ShownUnit::of(self);
        let shown = |light: Option<Rgb>| cell(light.map(|e| unit.rgb(e).luminance()));
        let mut table = CsvTable::new(&PROBE_COLUMNS);
        for probe in &self.probes {
            let site = probe.site.as_ref();
            let id = site.map(|s| s.paint.material as usize);
            let material = id.and_then(|id| self.document.materials.get(id));
            let light = site.filter(|s| s.paint.is_front).and_then(|s| s.light);
            let SurfacePick {
                item,
                position,
                normal,
            } = probe.pick;
            let numbers = position.to_array().into_iter().chain(normal.to_array());
            let head = [
                Cow::from(probe.number.to_string()),
                Cow::from(self.document.name(item).unwrap_or_default()),
                Cow::from(material.map_or("", |m| m.name.as_str())),
            ];
            let tail = [
                shown(light.map(|l| l.0)),
                shown(light.and_then(|l| l.1)),
                shown(probe.measured.map(|m| m.value)),
                shown(probe.measured.map(|m| m.error)),
                Cow::from(unit.irradiance()),
            ];
            let numbers = numbers.map(|x| cell(Some(x)));
            table.row(head.into_iter().chain(numbers).chain(tail));
        }
        table
    }

    pub(super) fn take_measurement(&mut self, measurement: ProbeMeasurement) {
        if !same_light(&measurement.document, &self.document) {
            let text = self.tr("the model changed while the probes were measured: measure again");
            self.report(Severity::Warning, text);
            return;
        }
        for probe in &mut self.probes {
            let mut estimates = measurement.estimates.iter();
            if let Some((_, estimate)) = estimates.find(|(number, _)| *number == probe.number) {
                probe.measured = Some(*estimate);
            }
        }
        self.measured_in = Some(measurement.document);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

    #[test]
    fn the_nearest_place_of_a_triangle_is_inside_it() {
        for (point, expected) in [
            ([0.25, 0.5, 3.0], [0.25, 0.25, 0.5]),
            ([-1.0, -1.0, 0.0], [1.0, 0.0, 0.0]),
            ([2.0, -1.0, 0.0], [0.0, 1.0, 0.0]),
            ([-1.0, 3.0, 1.0], [0.0, 0.0, 1.0]),
            ([0.5, -2.0, 0.0], [0.5, 0.5, 0.0]),
            ([-2.0, 0.5, 0.0], [0.5, 0.0, 0.5]),
            ([1.0, 1.0, 0.0], [0.0, 0.5, 0.5]),
        ] {
            let weights = nearest_weights(DVec3::from(point), TRIANGLE);
            let far = (0..3).map(|k| (weights[k] - expected[k]).abs());
            assert!(far.fold(0.0, f64::max) < 1e-12, "{point:?}: {weights:?}");
        }
    }
}
