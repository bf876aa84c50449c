//! Results of jobs as bytes, to the last bit: what comes from the worker of a page, which has a memory of its own.

use super::probes::ProbeMeasurement;
use super::task_plane::TaskPlane;
use super::{App, JobResult};
use crate::document::{ItemId, SceneDocument, Solution, SurfacePick, TaskGrid};
use crate::engine_comparison::EngineRun;
use crate::first_pass::{EngineChoice, PatchFormFactors};
use azulejo::factors::EngineUsed;
use azulejo::factors::form_factors::{Factor, GroupFactor};
use azulejo::radiosity::strata::{ErrorParts, QuarterError};
use azulejo::radiosity::{EnergyBalance, Estimate, Method, Report};
use azulejo::scene::{
    Attribute, BackIrradiance, Faces, Image, Mesh, PositionHistory, Rgb, Shape, SurfaceGrid,
    SurfaceLight, VertexLight,
};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// What can be put into bytes, and be taken from them again.
trait Parcel: Sized {
    fn put(&self, to: &mut Vec<u8>);

    /// `None` of bytes that were not put there.
    fn take(from: &mut &[u8]) -> Option<Self>;
}

macro_rules! numbers {
    ($($number:ty),*) => {$(
        impl Parcel for $number {
            fn put(&self, to: &mut Vec<u8>) {
                to.extend(self.to_le_bytes());
            }

            fn take(from: &mut &[u8]) -> Option<$number> {
                let (bytes, rest) = from.split_first_chunk()?;
                *from = rest;
                Some(<$number>::from_le_bytes(*bytes))
            }
        }
    )*};
}

numbers!(u8, u32, u64, f32, f64);

/// Implements [`Parcel`] for structs by their fields; the compiler demands all of them.
macro_rules! structs {
    ($($name:ident { $($field:ident),* })*) => {$(
        impl Parcel for $name {
            fn put(&self, to: &mut Vec<u8>) {
                $(self.$field.put(to);)*
            }

            fn take(from: &mut &[u8]) -> Option<$name> {
                Some($name { $($field: Parcel::take(from)?),* })
            }
        }
    )*};
}

structs! {
    Rgb { r, g, b }
    DVec2 { x, y }
    DVec3 { x, y, z }
    Faces { starts, corners }
    BackIrradiance { irradiance, error }
    VertexLight { irradiance, error, back }
    SurfaceGrid { nu, nv }
    SurfaceLight { grids, irradiance, error }
    Mesh {
        positions, normals, uvs, lightmap_uvs, colors, irradiance, irradiance_error, back, faces,
        face_materials, smoothing, history
    }
    Image { width, height, pixels, alpha }
    Estimate { value, error }
    EngineUsed { name, device, notes }
    EnergyBalance { emitted, absorbed, escaped, cut }
    ErrorParts { noise, discretization, interpolation }
    QuarterError { mean, error }
    Report {
        method, engine_used, patches, points, patch_rays, refined_rows, patch_error, point_rays,
        bytes, iterations, residual, balance, balance_error, error, error_each, error_parts,
        quarters, path_traced, rays_needed, interpolated
    }
    TaskGrid { corner, sides, counts, up }
    SurfacePick { item, position, normal }
    Factor { value, error }
    GroupFactor { factor, estimates }
    EngineRun { engine, samples, seconds, error }
}

impl Parcel for usize {
    fn put(&self, to: &mut Vec<u8>) {
        (*self as u64).put(to);
    }

    fn take(from: &mut &[u8]) -> Option<usize> {
        usize::try_from(u64::take(from)?).ok()
    }
}

impl Parcel for ItemId {
    fn put(&self, to: &mut Vec<u8>) {
        self.0.put(to);
    }

    fn take(from: &mut &[u8]) -> Option<ItemId> {
        Some(ItemId(Parcel::take(from)?))
    }
}

impl Parcel for Method {
    fn put(&self, to: &mut Vec<u8>) {
        (*self as u8).put(to);
    }

    fn take(from: &mut &[u8]) -> Option<Method> {
        let all = [Method::Matrix, Method::Stochastic, Method::Paths];
        let code = u8::take(from)?;
        all.into_iter().find(|method| *method as u8 == code)
    }
}

impl Parcel for EngineChoice {
    fn put(&self, to: &mut Vec<u8>) {
        (*self as u8).put(to);
    }

    fn take(from: &mut &[u8]) -> Option<EngineChoice> {
        use EngineChoice::{Analytic, Auto, Hemicube, Hybrid, Rays};
        let code = u8::take(from)?;
        [Auto, Rays, Hemicube, Hybrid, Analytic]
            .into_iter()
            .find(|engine| *engine as u8 == code)
    }
}

/// Not carried: that of the model's own mesh is kept.
impl Parcel for PositionHistory {
    fn put(&self, _: &mut Vec<u8>) {}

    fn take(_: &mut &[u8]) -> Option<PositionHistory> {
        Some(PositionHistory::NONE)
    }
}

impl<T: Parcel> Parcel for Vec<T> {
    fn put(&self, to: &mut Vec<u8>) {
        self.len().put(to);
        self.iter().for_each(|value| value.put(to));
    }

    fn take(from: &mut &[u8]) -> Option<Vec<T>> {
        let count = usize::take(from)?;
        (0..count).map(|_| T::take(from)).collect()
    }
}

impl<T: Parcel + Copy + Default, const N: usize> Parcel for [T; N] {
    fn put(&self, to: &mut Vec<u8>) {
        self.iter().for_each(|value| value.put(to));
    }

    fn take(from: &mut &[u8]) -> Option<[T; N]> {
        let mut all = [T::default(); N];
        for value in &mut all {
            *value = T::take(from)?;
        }
        Some(all)
    }
}

impl<A: Parcel, B: Parcel> Parcel for (A, B) {
    fn put(&self, to: &mut Vec<u8>) {
        self.0.put(to);
        self.1.put(to);
    }

    fn take(from: &mut &[u8]) -> Option<(A, B)> {
        Some((A::take(from)?, B::take(from)?))
    }
}

impl<T: Parcel> Parcel for Option<T> {
    fn put(&self, to: &mut Vec<u8>) {
        u8::from(self.is_some()).put(to);
        if let Some(value) = self {
            value.put(to);
        }
    }

    fn take(from: &mut &[u8]) -> Option<Option<T>> {
        match u8::take(from)? {
            0 => Some(None),
            _ => Some(Some(T::take(from)?)),
        }
    }
}

impl<T: Parcel> Parcel for Box<T> {
    fn put(&self, to: &mut Vec<u8>) {
        (**self).put(to);
    }

    fn take(from: &mut &[u8]) -> Option<Box<T>> {
        T::take(from).map(Box::new)
    }
}

impl Parcel for String {
    fn put(&self, to: &mut Vec<u8>) {
        self.len().put(to);
        to.extend(self.as_bytes());
    }

    fn take(from: &mut &[u8]) -> Option<String> {
        let count = usize::take(from)?;
        let (text, rest) = from.split_at_checked(count)?;
        *from = rest;
        String::from_utf8(text.to_vec()).ok()
    }
}

impl<T: Parcel> Parcel for Attribute<T> {
    fn put(&self, to: &mut Vec<u8>) {
        self.values.put(to);
        self.corners.put(to);
    }

    fn take(from: &mut &[u8]) -> Option<Attribute<T>> {
        Some(Attribute {
            values: Parcel::take(from)?,
            corners: Parcel::take(from)?,
        })
    }
}

/// Puts what light has made of a shape.
fn put_light(shape: &Shape, to: &mut Vec<u8>) {
    match shape {
        Shape::Mesh(mesh) => mesh.put(to),
        Shape::Instance(instance) => instance.light.clone().put(to),
        Shape::Primitive(primitive) => primitive.light.put(to),
        Shape::Exact(exact) => exact.proxy.clone().put(to),
    }
}

/// Takes what light has made of a shape.
fn take_light(shape: &mut Shape, from: &mut &[u8]) -> Option<()> {
    match shape {
        Shape::Mesh(mesh) => {
            let history = mesh.history;
            *mesh = Mesh::take(from)?;
            mesh.history = history;
        }
        Shape::Instance(instance) => instance.light = Parcel::take(from)?,
        Shape::Primitive(primitive) => primitive.light = Parcel::take(from)?,
        Shape::Exact(exact) => exact.proxy = Parcel::take(from)?,
    }
    Some(())
}

fn put_solution(solution: &Solution, to: &mut Vec<u8>) {
    solution.shapes().for_each(|shape| put_light(shape, to));
    solution.report.put(to);
}

fn take_solution(document: &SceneDocument, from: &mut &[u8]) -> Option<Solution> {
    let mut shapes: Vec<Shape> = document
        .scene()
        .objects
        .into_iter()
        .map(|o| o.shape)
        .collect();
    for shape in &mut shapes {
        take_light(shape, from)?;
    }
    let report = Parcel::take(from)?;
    Some(Solution::of_shapes(document.clone(), shapes, report))
}

/// A result as bytes; empty of those that no worker has.
pub(super) fn pack(result: &JobResult) -> Vec<u8> {
    let mut bytes = Vec::new();
    let to = &mut bytes;
    match result {
        JobResult::Light(solution) => {
            0u8.put(to);
            put_solution(solution, to);
        }
        JobResult::Render(image, samples) => {
            1u8.put(to);
            image.put(to);
            samples.put(to);
        }
        JobResult::Measured(measurement) => {
            2u8.put(to);
            measurement.estimates().to_vec().put(to);
        }
        JobResult::TaskPlane(plane) => {
            3u8.put(to);
            plane.grid.put(to);
            plane.cells.put(to);
        }
        JobResult::FormFactors(factors) => {
            4u8.put(to);
            factors.pick.put(to);
            factors.patches.as_ref().put(to);
            factors.factors.put(to);
            factors.sum.put(to);
            factors.objects.put(to);
        }
        JobResult::Autosaved(revision) => {
            5u8.put(to);
            revision.put(to);
        }
        JobResult::Note(text) => {
            6u8.put(to);
            text.put(to);
        }
        JobResult::EngineRun(run) => {
            7u8.put(to);
            run.put(to);
        }
        _ => {}
    }
    bytes
}

/// The result of a job that was started with `document`.
pub(super) fn unpack(mut bytes: &[u8], document: &SceneDocument) -> Option<JobResult> {
    let from = &mut bytes;
    Some(match u8::take(from)? {
        0 => JobResult::Light(Box::new(take_solution(document, from)?)),
        1 => JobResult::Render(Parcel::take(from)?, u32::take(from)?),
        2 => {
            let estimates = Parcel::take(from)?;
            let measurement = ProbeMeasurement::new(document.clone(), estimates);
            JobResult::Measured(Box::new(measurement))
        }
        3 => {
            let (grid, cells) = (Parcel::take(from)?, Parcel::take(from)?);
            JobResult::TaskPlane(Box::new(TaskPlane::new(grid, cells, document.clone())))
        }
        4 => JobResult::FormFactors(Box::new(PatchFormFactors {
            number: PatchFormFactors::next_number(),
            pick: Parcel::take(from)?,
            patches: Arc::new(Parcel::take(from)?),
            factors: Parcel::take(from)?,
            sum: Parcel::take(from)?,
            objects: Parcel::take(from)?,
        })),
        5 => JobResult::Autosaved(u64::take(from)?),
        6 => JobResult::Note(Parcel::take(from)?),
        7 => JobResult::EngineRun(Parcel::take(from)?),
        _ => return None,
    })
}

impl App {
    /// The result in a parcel of a job.
    #[cfg(target_arch = "wasm32")]
    pub(super) fn open_parcel(&self, job: u64, bytes: &[u8]) -> Option<JobResult> {
        let sent = self.sent.iter().find(|(id, _)| *id == job);
        unpack(bytes, sent.map_or(&self.document, |(_, document)| document))
    }
}

#[cfg(target_arch = "wasm32")]
impl crate::jobs::JobOutput for JobResult {
    fn packed(&self) -> Vec<u8> {
        pack(self)
    }

    fn arrived(bytes: Vec<u8>) -> JobResult {
        JobResult::Parcel(bytes)
    }
}

#[cfg(test)]
mod tests;
