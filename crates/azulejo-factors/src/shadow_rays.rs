//! The visible fraction of a pair of patches, by shadow rays.

use crate::patch::{Patches, Sampler};
use azulejo_scene::math::Ray;
use azulejo_trace::sampling::{SobolTable, seeds};
use azulejo_trace::{KernelRay, REPLICATES, Surfaces, Tracer};
use glam::DVec3;
use std::f64::consts::PI;

/// Shadow rays per pair and replicate where no goal says how many.
const RAYS: u32 = 16;

/// The same where these find the pair partially visible.
const MORE_RAYS: u32 = 64;

/// First shadow rays per replicate of a pair with a goal, and the most.
const GOAL_RAYS: [u32; 2] = [4, 1024];

/// Most shadow rays of a pair.
pub(crate) const MOST_RAYS: f64 = GOAL_RAYS[1] as f64 * REPLICATES as f64;

/// By what power of the number of rays the standard error of a share falls: measured.
const FALL: f64 = 0.74;

/// By what power of their number the variance of stratified rays is below that of independent ones, where that cannot be
/// measured: less than they fall by.
const GAIN: f64 = 0.3;

/// Parameter of the prior of shares, Beta(PRIOR, PRIOR): pairs with something between them are mostly hidden or free.
const PRIOR: f64 = 0.3;

/// Degrees of freedom that the expected variance counts as, beside the three of the replicates.
const EXPECTED: f64 = 3.0;

/// A pair of patches whose visibility is estimated.
pub(crate) struct View<'a> {
    pub patches: &'a Patches,
    pub surfaces: &'a Surfaces<'a>,
    pub pair: [usize; 2],
    /// Normals of the sides that see each other.
    pub normals: [DVec3; 2],
    /// With an up direction, what leaves the first facet upwards is counted by itself.
    pub up: Option<DVec3>,
    /// Seeds of the random numbers.
    pub key: [u32; 3],
    /// The numbers, of [`sequence`].
    pub points: &'a SobolTable,
}

/// The visible share of an exchange area.
pub(crate) struct Visible {
    pub share: f64,
    /// Its standard error.
    pub error: f64,
    /// The share that leaves upwards, and its standard error.
    pub upward: f64,
    pub upward_error: f64,
    /// Whether some rays were blocked and some were not.
    is_partial: bool,
    /// The standard deviation of what a single ray says.
    deviation: f64,
}

/// Sums over shadow rays: of the kernel, of its square, of its visible part, and of what of that leaves upwards.
#[derive(Clone, Copy, Default)]
struct Kernels {
    sum: f64,
    squares: f64,
    visible: f64,
    upward: f64,
}

/// The points of the unit hypercube that rays connect.
pub(crate) fn sequence() -> SobolTable {
    SobolTable::new(GOAL_RAYS[1] as usize)
}

/// Shadow rays in all for a standard error of a share of `goal`, where a single ray has `deviation`; `None` if they are
/// too many.
pub(crate) fn rays_for(deviation: f64, goal: f64) -> Option<f64> {
    let [least, most] = GOAL_RAYS.map(|rays| f64::from(rays) * REPLICATES as f64);
    let rays = (deviation / goal).powf(1.0 / FALL).max(least);
    (rays <= most).then_some(rays)
}

impl View<'_> {
    /// The visible share.
    pub fn visible(&self) -> Visible {
        let first = self.by_rays(RAYS, 0);
        if first.is_partial {
            self.by_rays(MORE_RAYS, 1)
        } else {
            first
        }
    }

    /// The visible share with a standard error of about `goal`. First rays tell how many this takes, and do not count
    /// then: an estimate is off that ends where its first values agree.
    pub fn visible_within(&self, goal: f64) -> Visible {
        let [least, most] = GOAL_RAYS;
        let per_replicate = |deviation| {
            let rays = rays_for(deviation, goal);
            rays.map_or(most, |rays| (rays / REPLICATES as f64) as u32)
        };
        let first = self.by_rays(least, 0);
        if per_replicate(0.5) <= least {
            return first;
        }
        self.by_rays(per_replicate(first.deviation), 1)
    }

    /// The visible share by so many rays per replicate, between points stratified over both facets and weighted with
    /// the kernel (ratio estimator); those of another `stage` are independent.
    fn by_rays(&self, rays: u32, stage: u32) -> Visible {
        let (mut shadow, mut kernels, mut blocked) = (Vec::new(), Vec::new(), Vec::new());
        let samplers = self.pair.map(|patch| self.patches.sampler(patch));
        for r in 0..REPLICATES as u32 {
            let [seed, i, j] = self.key;
            let scrambling = seeds(&[seed, i, j, r, stage]);
            for k in 0..rays {
                let u = self.points.point(k as usize, scrambling).map(f64::from);
                let (ray, kernel, way) = self.connect(&samplers, u);
                let is_up = self.up.is_some_and(|up| way.dot(up) > 0.0);
                shadow.push(ray);
                kernels.push((kernel, is_up));
            }
        }
        self.surfaces.tracer.any(&shadow, &mut blocked);
        let mut sums = [Kernels::default(); REPLICATES];
        for (index, (&(kernel, is_up), &blocked)) in kernels.iter().zip(&blocked).enumerate() {
            sums[index / rays as usize].add(kernel, !blocked, is_up);
        }
        Visible::new(&sums)
    }

    /// A shadow ray between two points, the kernel's value there, and the way from one to the other.
    fn connect(&self, samplers: &[Sampler; 2], u: [f64; 4]) -> (KernelRay, f64, DVec3) {
        let point = |k: usize| samplers[k].sample(u[2 * k], u[2 * k + 1]).position;
        let ([x, y], [m, n]) = ([point(0), point(1)], self.normals);
        let tracer = self.surfaces.tracer;
        let ray = Ray::between(tracer.leaving(x, m), tracer.leaving(y, n));
        let (way, squared) = (y - x, (y - x).length_squared());
        let kernel = way.dot(m).max(0.0) * (-way.dot(n)).max(0.0) / (PI * squared * squared);
        (
            tracer.kernel_ray(&ray),
            if kernel.is_finite() { kernel } else { 0.0 },
            way,
        )
    }
}

/// A ray between two points with normals, if these face each other.
pub(crate) fn facing_ray(tracer: &Tracer, ends: [(DVec3, DVec3); 2]) -> Option<KernelRay> {
    let [(x, m), (y, n)] = ends;
    let way = y - x;
    let is_facing = way.dot(m) > 0.0 && way.dot(n) < 0.0;
    is_facing.then(|| tracer.kernel_ray(&Ray::between(tracer.leaving(x, m), tracer.leaving(y, n))))
}

impl Kernels {
    fn add(&mut self, kernel: f64, is_visible: bool, is_up: bool) {
        self.sum += kernel;
        self.squares += kernel * kernel;
        let seen = |counts: bool| if is_visible && counts { kernel } else { 0.0 };
        self.visible += seen(true);
        self.upward += seen(is_up);
    }
}

impl Visible {
    fn new(replicates: &[Kernels; REPLICATES]) -> Visible {
        let all = Share::new(replicates, |k| k.visible);
        let upward = Share::new(replicates, |k| k.upward);
        Visible {
            share: all.value,
            error: all.variance.sqrt(),
            upward: upward.value,
            upward_error: upward.variance.sqrt(),
            is_partial: all.value > 0.0 && all.value < 1.0,
            deviation: all.deviation.max(upward.deviation),
        }
    }
}

/// A share of the kernels.
struct Share {
    value: f64,
    variance: f64,
    /// The standard deviation of what a single ray says.
    deviation: f64,
}

impl Share {
    /// The variance is estimated twice, and both are averaged by their degrees of freedom: from the spread of the
    /// replicates, and as what so many rays leave open, even if all passed or none did. That is the posterior variance
    /// of a share after K independent observations, divided by how much better stratified rays are, K^GAIN.
    /// K is the effective number of kernels, (Σk)²/Σk².
    fn new(replicates: &[Kernels; REPLICATES], part: fn(&Kernels) -> f64) -> Share {
        let total = |f: fn(&Kernels) -> f64| replicates.iter().map(f).sum::<f64>();
        let (sum, squares, counted) = (total(|k| k.sum), total(|k| k.squares), total(part));
        if sum == 0.0 {
            return Share {
                value: 0.5,
                variance: 0.25,
                deviation: 0.5,
            };
        }
        let (value, looks) = (counted / sum, sum * sum / squares);
        // Residuals of the ratio, each replicate weighted by its kernels.
        let n = REPLICATES as f64;
        let residual = |k: &Kernels| (part(k) - value * k.sum).powi(2);
        let spread: f64 = replicates.iter().map(residual).sum();
        let spread = spread * n / (n - 1.0) / (sum * sum);
        let expected = (value * looks + PRIOR) / (looks + 2.0 * PRIOR);
        let single = expected * (1.0 - expected);
        let posterior = single / (looks + 2.0 * PRIOR + 1.0) / looks.powf(GAIN);
        Share {
            value,
            variance: ((n - 1.0) * spread + EXPECTED * posterior) / (n - 1.0 + EXPECTED),
            deviation: single.sqrt(),
        }
    }
}
