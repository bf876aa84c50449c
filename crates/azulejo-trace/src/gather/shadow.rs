//! Shadow tests: what stands between a point and the lights it would receive.

use super::sources::Window;
use crate::interaction::shadow_ray;
use crate::lambert::mirror_point;
use crate::{KernelRay, Tracer};
use azulejo_scene::Rgb;
use glam::DVec3;

/// A planned shadow test: `count` rays from `first`, one behind the other.
pub(super) struct ShadowTest {
    /// The caller's number for what is tested.
    pub tag: u32,
    pub replicate: u32,
    pub weight: f64,
    first: u32,
    count: u32,
}

/// A batch of shadow tests, with memory that is kept between batches.
pub(super) struct ShadowTests<'a> {
    tracer: &'a Tracer,
    rays: Vec<KernelRay>,
    /// What passes along each ray.
    shares: Vec<Rgb>,
    tests: Vec<ShadowTest>,
}

impl<'a> ShadowTests<'a> {
    pub fn new(tracer: &'a Tracer) -> ShadowTests<'a> {
        ShadowTests {
            tracer,
            rays: Vec::new(),
            shares: Vec::new(),
            tests: Vec::new(),
        }
    }

    /// Starts a new batch.
    pub fn clear(&mut self) {
        self.tests.clear();
        self.rays.clear();
    }

    /// Number of the next ray, for [`keep`](ShadowTests::keep).
    pub fn planned(&self) -> u32 {
        self.rays.len() as u32
    }

    /// Plans a ray to a point.
    pub fn push_segment(&mut self, from: DVec3, to: DVec3) {
        self.rays.push(shadow_ray(self.tracer, from, to));
    }

    /// Plans both legs of the way to a point whose mirror image is `image`; none if the mirror
    /// does not lie between.
    pub fn push_reflected(&mut self, from: DVec3, image: DVec3, window: &Window) {
        let (here, there) = (
            (from - window.polygon[0]).dot(window.normal),
            (image - window.polygon[0]).dot(window.normal),
        );
        if here * there >= 0.0 {
            return;
        }
        let at = from + (image - from) * (here / (here - there));
        let target = mirror_point(image, window.polygon[0], window.normal);
        let before = self.tracer.leaving(at, window.normal * here.signum());
        self.push_segment(from, before);
        self.push_segment(before, target);
    }

    /// Makes a test of the rays from `first` on; returns its weight. Drops them and returns
    /// `None` if there are none or the weight is zero.
    pub fn keep(&mut self, first: u32, tag: u32, replicate: u32, weight: f64) -> Option<f64> {
        let count = self.planned() - first;
        if weight > 0.0 && count > 0 {
            self.tests.push(ShadowTest {
                tag,
                replicate,
                weight,
                first,
                count,
            });
            return Some(weight);
        }
        self.rays.truncate(first as usize);
        None
    }

    /// Traces the batch and reports of each test, in their order, the share of the light that passes what
    /// stands between, 0..=1 per channel, and the first of its rays, against which the light arrives.
    pub fn trace(&mut self, mut report: impl FnMut(&ShadowTest, Rgb, &KernelRay)) {
        self.tracer.transmittance(&self.rays, &mut self.shares);
        for test in &self.tests {
            let rays = test.first as usize..(test.first + test.count) as usize;
            let legs = self.shares[rays].iter();
            let share = legs.fold(Rgb::WHITE, |all, &leg| all * leg);
            report(test, share, &self.rays[test.first as usize]);
        }
    }
}
