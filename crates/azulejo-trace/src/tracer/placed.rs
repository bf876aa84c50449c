//! The contents of a tracer besides triangles: exact shapes, and other tracers.

use super::Tracer;
use crate::exact::{ExactPrimitive, Line3, PlacedExact, crossing, point_on_triangle};
use crate::frame::{LocalFrame, double, single};
use crate::hit::ResolvedPoint;
use crate::kernel::{KernelHit, KernelRay, OtherShapes};
use azulejo_scene::math::Ray;
use glam::{DAffine3, DMat3, DVec3};
use std::sync::Arc;

/// A shape other than a triangle, in leaves of its own.
#[derive(Clone, Debug)]
pub(crate) enum Placed {
    Triangle(Box<PlacedTriangle>),
    Primitive(Box<PlacedPrimitive>),
    Exact(Box<PlacedExact>),
    Instance(Box<PlacedTracer>),
}

/// A triangle of a mesh that is too large for the kernel's digits.
#[derive(Clone, Debug)]
pub(crate) struct PlacedTriangle {
    pub item: u32,
    /// In kernel coordinates.
    pub corners: [DVec3; 3],
}

/// An exact primitive.
#[derive(Clone, Debug)]
pub(crate) struct PlacedPrimitive {
    pub object: u32,
    pub first_item: u32,
    pub shape: ExactPrimitive,
}

/// The tracer of a shared mesh at one of its places.
#[derive(Clone, Debug)]
pub(crate) struct PlacedTracer {
    pub object: u32,
    pub first_item: u32,
    /// The first of the numbers under which what all places share is known.
    pub first_prototype: u32,
    pub tracer: Arc<Tracer>,
    pub world_from_mesh: DAffine3,
    pub mesh_from_world: DAffine3,
    /// From the mesh's normals to the world's, which it leaves with another length.
    pub world_normals: DMat3,
    /// From the outer tracer's kernel coordinates to the inner one's.
    pub inner_from_local: DAffine3,
}

impl Placed {
    pub(crate) fn first_item(&self) -> u32 {
        match self {
            Placed::Triangle(t) => t.item,
            Placed::Primitive(p) => p.first_item,
            Placed::Exact(e) => e.first_item,
            Placed::Instance(i) => i.first_item,
        }
    }

    /// The surface point of a hit on this shape.
    pub(crate) fn resolve(&self, frame: &LocalFrame, ray: &Ray, hit: &KernelHit) -> ResolvedPoint {
        match self {
            Placed::Triangle(t) => t.resolve(frame, ray, hit),
            Placed::Primitive(p) => p.resolve(ray, hit),
            Placed::Exact(e) => e.resolve(frame, ray, hit),
            Placed::Instance(i) => i.resolve(ray, hit),
        }
    }
}

impl PlacedTriangle {
    fn closest(&self, ray: &KernelRay, hit: &mut KernelHit) {
        let Some((t, u, v)) = self.crossing(ray, hit.t) else {
            return;
        };
        let t = t as f32;
        if hit.is_after(t, self.item) {
            *hit = KernelHit::on_surface(t, self.item, [u as f32, v as f32]);
        }
    }

    fn any(&self, ray: &KernelRay, t_max: f32) -> bool {
        self.crossing(ray, t_max).is_some()
    }

    fn crossing(&self, ray: &KernelRay, t_max: f32) -> Option<(f64, f64, f64)> {
        let range = f64::from(ray.t_min.max(0.0))..=f64::from(t_max);
        crossing(self.corners, &Line3::of(ray)).filter(|(t, ..)| range.contains(t))
    }

    fn resolve(&self, frame: &LocalFrame, ray: &Ray, hit: &KernelHit) -> ResolvedPoint {
        let corners = self.corners.map(|p| frame.world_point(p));
        point_on_triangle(corners, ray, f64::from(hit.t))
    }
}

impl PlacedPrimitive {
    fn closest(&self, ray: &KernelRay, hit: &mut KernelHit) {
        let line = self.shape.object_line(&Line3::of(ray));
        let t_min = f64::from(ray.t_min.max(0.0));
        let Some(p) = self.shape.first(&line, t_min, f64::from(hit.t)) else {
            return;
        };
        let (t, item) = (p.t as f32, self.first_item + p.part as u32);
        if hit.is_after(t, item) {
            *hit = KernelHit::on_surface(t, item, [p.u as f32, p.v as f32]);
        }
    }

    fn any(&self, ray: &KernelRay, t_max: f32) -> bool {
        let line = self.shape.object_line(&Line3::of(ray));
        let t_min = f64::from(ray.t_min.max(0.0));
        self.shape.first(&line, t_min, f64::from(t_max)).is_some()
    }

    fn resolve(&self, ray: &Ray, hit: &KernelHit) -> ResolvedPoint {
        let part = (hit.item - self.first_item) as usize;
        let line = self.shape.object_line_from_world(&Line3 {
            origin: ray.origin,
            direction: ray.direction,
        });
        let (t, u, v) = match self.shape.nearest_to(&line, f64::from(hit.t)) {
            // By rounding another part may be hit; then the kernel's result is kept.
            Some(p) if p.part == part => (p.t, p.u, p.v),
            _ => {
                let [u, v] = hit.uv().map(f64::from);
                (f64::from(hit.t), u, v)
            }
        };
        let point = self.shape.shape.point(part, u, v);
        ResolvedPoint {
            t,
            u,
            v,
            part: 0,
            position: point.position,
            normal: point.normal,
        }
    }
}

impl PlacedTracer {
    fn closest(&self, ray: &KernelRay, hit: &mut KernelHit) {
        let mut inner_hit = KernelHit::NOTHING;
        let inner = [self.inner_ray(ray, hit.t)];
        self.tracer
            .closest_into(&inner, std::slice::from_mut(&mut inner_hit));
        if !inner_hit.is_hit() {
            return;
        }
        inner_hit.item += self.first_item;
        if hit.is_after(inner_hit.t, inner_hit.item) {
            *hit = inner_hit;
        }
    }

    fn any(&self, ray: &KernelRay, t_max: f32) -> bool {
        let mut blocked = false;
        let inner = [self.inner_ray(ray, t_max)];
        self.tracer
            .any_into(&inner, std::slice::from_mut(&mut blocked));
        blocked
    }

    /// The ray in the instance, up to and including `last`.
    fn inner_ray(&self, ray: &KernelRay, last: f32) -> KernelRay {
        let map = &self.inner_from_local;
        KernelRay {
            origin: single(map.transform_point3(double(ray.origin))),
            direction: single(map.transform_vector3(double(ray.direction))),
            t_max: last.next_up(),
            ..*ray
        }
    }

    fn resolve(&self, ray: &Ray, hit: &KernelHit) -> ResolvedPoint {
        let inner_ray = Ray {
            origin: self.mesh_from_world.transform_point3(ray.origin),
            direction: self.mesh_from_world.transform_vector3(ray.direction),
            ..*ray
        };
        let mut inner_hit = *hit;
        inner_hit.item -= self.first_item;
        let inner = self.tracer.resolve(&inner_ray, &inner_hit);
        ResolvedPoint {
            t: inner.t,
            u: inner.u,
            v: inner.v,
            part: inner.triangle,
            position: self.world_from_mesh.transform_point3(inner.position),
            normal: (self.world_normals * inner.normal).normalize_or_zero(),
        }
    }
}

impl OtherShapes for [Placed] {
    fn closest(&self, shape: u32, ray: &KernelRay, hit: &mut KernelHit) {
        match &self[shape as usize] {
            Placed::Triangle(t) => t.closest(ray, hit),
            Placed::Primitive(p) => p.closest(ray, hit),
            Placed::Exact(e) => e.closest(ray, hit),
            Placed::Instance(i) => i.closest(ray, hit),
        }
    }

    fn any(&self, shape: u32, ray: &KernelRay, t_max: f32) -> bool {
        match &self[shape as usize] {
            Placed::Triangle(t) => t.any(ray, t_max),
            Placed::Primitive(p) => p.any(ray, t_max),
            Placed::Exact(e) => e.any(ray, t_max),
            Placed::Instance(i) => i.any(ray, t_max),
        }
    }
}
