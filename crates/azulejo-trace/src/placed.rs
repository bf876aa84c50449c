//! What a tracer holds besides triangles: exact shapes, and other tracers.

use crate::assemble::{LocalFrame, double, single};
use crate::exact::PlacedExact;
use crate::kernel::{Others, is_better};
use crate::primitive::ExactPrimitive;
use crate::ray::{KernelHit, KernelRay};
use crate::tracer::Tracer;
use azulejo_scene::math::{Ray, normal_matrix};
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// A shape that stands in leaves of its own.
#[derive(Clone, Debug)]
pub(crate) enum Placed {
    Primitive(Box<PlacedPrimitive>),
    Exact(Box<PlacedExact>),
    Instance(Box<PlacedTracer>),
}

/// An exact primitive.
#[derive(Clone, Debug)]
pub(crate) struct PlacedPrimitive {
    pub object: u32,
    pub first_item: u32,
    pub shape: ExactPrimitive,
}

/// A tracer in another tracer's world.
#[derive(Clone, Debug)]
pub(crate) struct PlacedTracer {
    /// Which of the instances it is.
    pub index: u32,
    pub first_item: u32,
    pub tracer: Arc<Tracer>,
    pub world_from_instance: DAffine3,
    pub instance_from_world: DAffine3,
    /// From the outer tracer's kernel coordinates to the inner one's.
    pub inner_from_local: DAffine3,
}

/// A surface point in the world, in double precision.
pub(crate) struct ResolvedPoint {
    pub t: f64,
    pub u: f64,
    pub v: f64,
    /// The part of an exact shape's leaf, the triangle of a face; 0 for a primitive.
    pub part: u32,
    pub position: DVec3,
    /// Unit normal of the front.
    pub normal: DVec3,
}

impl Placed {
    pub(crate) fn first_item(&self) -> u32 {
        match self {
            Placed::Primitive(p) => p.first_item,
            Placed::Exact(e) => e.first_item,
            Placed::Instance(i) => i.first_item,
        }
    }

    /// The surface point of a hit on this shape.
    pub(crate) fn resolve(&self, frame: &LocalFrame, ray: &Ray, hit: &KernelHit) -> ResolvedPoint {
        match self {
            Placed::Primitive(p) => p.resolve(ray, hit),
            Placed::Exact(e) => e.resolve(frame, ray, hit),
            Placed::Instance(i) => i.resolve(ray, hit),
        }
    }
}

impl PlacedPrimitive {
    fn closest(&self, ray: &KernelRay, hit: &mut KernelHit) {
        let line = (self.shape).local_line(double(ray.origin), double(ray.direction));
        let t_min = f64::from(ray.t_min.max(0.0));
        let Some(p) = self.shape.first(&line, t_min, f64::from(hit.t)) else {
            return;
        };
        let (t, item) = (p.t as f32, self.first_item + p.part as u32);
        if is_better(t, item, hit) {
            *hit = KernelHit {
                t,
                item,
                u: p.u as f32,
                v: p.v as f32,
            };
        }
    }

    fn any(&self, ray: &KernelRay, t_max: f32) -> bool {
        let line = (self.shape).local_line(double(ray.origin), double(ray.direction));
        let t_min = f64::from(ray.t_min.max(0.0));
        self.shape.first(&line, t_min, f64::from(t_max)).is_some()
    }

    fn resolve(&self, ray: &Ray, hit: &KernelHit) -> ResolvedPoint {
        let part = (hit.item - self.first_item) as usize;
        let line = self.shape.world_line(ray.origin, ray.direction);
        let (t, u, v) = match self.shape.nearest_to(&line, f64::from(hit.t)) {
            // By rounding another part may be met; then the kernel's own answer stands.
            Some(p) if p.part == part => (p.t, p.u, p.v),
            _ => (f64::from(hit.t), f64::from(hit.u), f64::from(hit.v)),
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
        let mut found = KernelHit::NOTHING;
        let inner = [self.inner_ray(ray, hit.t)];
        self.tracer
            .closest_into(&inner, std::slice::from_mut(&mut found));
        if !found.is_hit() {
            return;
        }
        found.item += self.first_item;
        if is_better(found.t, found.item, hit) {
            *hit = found;
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
            origin: self.instance_from_world.transform_point3(ray.origin),
            direction: self.instance_from_world.transform_vector3(ray.direction),
            ..*ray
        };
        let inner_hit = KernelHit {
            item: hit.item - self.first_item,
            ..*hit
        };
        let inner = self.tracer.resolve(&inner_ray, &inner_hit);
        let normal = normal_matrix(self.world_from_instance.matrix3) * inner.normal;
        ResolvedPoint {
            t: inner.t,
            u: inner.u,
            v: inner.v,
            part: inner.triangle,
            position: self.world_from_instance.transform_point3(inner.position),
            normal: normal.normalize_or_zero(),
        }
    }
}

impl Others for [Placed] {
    fn closest(&self, shape: u32, ray: &KernelRay, hit: &mut KernelHit) {
        match &self[shape as usize] {
            Placed::Primitive(p) => p.closest(ray, hit),
            Placed::Exact(e) => e.closest(ray, hit),
            Placed::Instance(i) => i.closest(ray, hit),
        }
    }

    fn any(&self, shape: u32, ray: &KernelRay, t_max: f32) -> bool {
        match &self[shape as usize] {
            Placed::Primitive(p) => p.any(ray, t_max),
            Placed::Exact(e) => e.any(ray, t_max),
            Placed::Instance(i) => i.any(ray, t_max),
        }
    }
}
