//! The visible fraction of a pair of patches, by shadow rays.

use crate::patch::Patches;
use azulejo_scene::math::Ray;
use azulejo_trace::sampling::{seeds, sobol};
use azulejo_trace::{KernelRay, REPLICATES, Surfaces, Tracer};
use glam::DVec3;
use std::f64::consts::PI;

/// Shadow rays per pair and replicate.
const RAYS: u32 = 16;

/// Further shadow rays where the first ones find the pair partially visible.
const MORE_RAYS: u32 = 64;

/// Most shadow rays of a pair.
pub(crate) const SHADOW_RAYS: usize = (RAYS + MORE_RAYS) as usize * REPLICATES;

/// A pair of patches whose visibility is estimated.
pub(crate) struct View<'a> {
    pub patches: &'a Patches,
    pub surfaces: &'a Surfaces<'a>,
    pub pair: [usize; 2],
    /// Normals of the sides that see each other.
    pub normals: [DVec3; 2],
    /// With an up direction, light that leaves the first facet downwards counts as blocked.
    pub up: Option<DVec3>,
    /// Seeds of the random numbers.
    pub key: [u32; 3],
}

/// The visible share of an exchange area.
pub(crate) struct Visible {
    pub share: f64,
    /// Its standard error.
    pub error: f64,
    /// Whether some rays were blocked and some were not.
    is_partial: bool,
}

/// Sums over shadow rays: of the kernel, of its square, of its visible part.
#[derive(Clone, Copy, Default)]
struct Kernels {
    sum: f64,
    squares: f64,
    visible: f64,
}

impl View<'_> {
    /// The visible share.
    pub fn visible(&self) -> Visible {
        let first = self.estimate(RAYS);
        if first.is_partial {
            self.estimate(MORE_RAYS)
        } else {
            first
        }
    }

    /// The visible share by `rays` shadow rays per replicate, between points stratified over both
    /// facets and weighted with the kernel (ratio estimator).
    fn estimate(&self, rays: u32) -> Visible {
        let (mut shadow, mut kernels, mut blocked) = (Vec::new(), Vec::new(), Vec::new());
        let mut is_down = Vec::new();
        for r in 0..REPLICATES as u32 {
            let [seed, i, j] = self.key;
            let scrambling = seeds(&[seed, i, j, r, rays]);
            for k in 0..rays {
                let u = [0, 1, 2, 3].map(|d| f64::from(sobol(k, d, scrambling[d])));
                let (ray, kernel, way) = self.connect(u);
                shadow.push(ray);
                kernels.push(kernel);
                is_down.push(self.up.is_some_and(|up| way.dot(up) < 0.0));
            }
        }
        self.surfaces.tracer.any(&shadow, &mut blocked);
        let mut sums = [Kernels::default(); REPLICATES];
        for (index, (&kernel, &blocked)) in kernels.iter().zip(&blocked).enumerate() {
            sums[index / rays as usize].add(kernel, !blocked && !is_down[index]);
        }
        Visible::new(&sums)
    }

    /// A shadow ray between two points, the kernel's value there, and the way from one to the other.
    fn connect(&self, u: [f64; 4]) -> (KernelRay, f64, DVec3) {
        let point = |k: usize| {
            let at = self.patches.sample(self.pair[k], u[2 * k], u[2 * k + 1]);
            at.position
        };
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
    fn add(&mut self, kernel: f64, is_visible: bool) {
        self.sum += kernel;
        self.squares += kernel * kernel;
        self.visible += if is_visible { kernel } else { 0.0 };
    }
}

impl Visible {
    /// The error is the larger of two. One comes from the spread of the replicates. The other is
    /// what so few rays cannot resolve, even if all passed or none did: the standard deviation of
    /// the posterior of a share after K independent observations with a uniform prior (Laplace's
    /// rule of succession), about 1/K if all K agree. K is the effective number of kernels,
    /// (Σk)²/Σk².
    fn new(replicates: &[Kernels; REPLICATES]) -> Visible {
        let total = |f: fn(&Kernels) -> f64| replicates.iter().map(f).sum::<f64>();
        let (sum, squares, visible) =
            (total(|k| k.sum), total(|k| k.squares), total(|k| k.visible));
        if sum == 0.0 {
            return Visible {
                share: 0.5,
                error: 0.5,
                is_partial: false,
            };
        }
        let (share, looks) = (visible / sum, sum * sum / squares);
        // Residuals of the ratio, each replicate weighted by its kernels.
        let n = REPLICATES as f64;
        let spread: f64 = replicates
            .iter()
            .map(|k| (k.visible - share * k.sum).powi(2))
            .sum();
        let spread = spread * n / (n - 1.0) / (sum * sum);
        let expected = (share * looks + 1.0) / (looks + 2.0);
        let posterior = expected * (1.0 - expected) / (looks + 3.0);
        let is_partial = visible > 0.0 && visible < sum;
        Visible {
            share,
            error: (STUDENT * STUDENT * spread).max(posterior).sqrt(),
            is_partial,
        }
    }
}

/// Student's t with three degrees of freedom over the normal quantile at 95.4%.
const STUDENT: f64 = 3.307 / 2.0;
