//! Options of the first pass, and what follows from them.

use crate::gathering::{GatherEffort, MOST_RAYS, Paths};
use crate::refine::RefinementGoal;
use crate::report::Method;
use crate::sides::StoredSides;
use azulejo_factors::{Engine, PatchSize};
use azulejo_trace::GatherPoint;
use azulejo_trace::sampling::hash;

/// Options of the first pass.
#[derive(Clone, Debug, PartialEq)]
pub struct FirstPass {
    /// The engine for the form factors between patches.
    pub engine: Engine,
    /// How finely faces are divided.
    pub size: PatchSize,
    /// Estimated relative RMS errors of the patches' radiosity and of irradiance at which to stop;
    /// `None` leaves it to `rays`.
    pub error: Option<f64>,
    /// Whether irradiance is to reach `error` at each point, relative to its own, instead of the mean of all: many more
    /// rays in the dark. Points darker than a thousandth of the mean are taken to have that.
    pub error_each: bool,
    /// Rays per patch, and most rays per vertex; with an `error`, most of both. `None` chooses by
    /// `error`. With neither, the goal is 3% at no more than 2,048 rays per vertex.
    pub rays: Option<u32>,
    /// Rays from all vertices or points together, about: each gets as many as that leaves by a pilot of paths, up to
    /// the default, and no more for `error`. Takes the place of `rays`.
    pub ray_budget: Option<f64>,
    /// Diffuse bounces of light to follow; `None` follows them to convergence.
    pub bounces: Option<u32>,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Bytes that the rows of form factors may take; beyond, light is shot without a matrix.
    pub memory: u64,
    /// Interpolate indirect light between vertices or points, where there are thousands of them, as
    /// far as the requested error permits.
    pub interpolate: bool,
    /// Write irradiance on the vertices of the given mesh instead of those of the patches.
    pub keep_mesh: bool,
    /// Which side's irradiance the surfaces of meshes store.
    pub sides: StoredSides,
}

impl Default for FirstPass {
    /// Patches of a 1,500th of the area, 3% error or 2,048 rays, bounces to convergence, 4 GiB.
    fn default() -> FirstPass {
        FirstPass {
            engine: Engine::Auto,
            size: PatchSize::Squares(1_500),
            error: None,
            error_each: false,
            rays: None,
            ray_budget: None,
            bounces: None,
            seed: 0,
            memory: 4 << 30,
            interpolate: true,
            keep_mesh: false,
            sides: StoredSides::default(),
        }
    }
}

/// Relative error to reach by default.
const DEFAULT_ERROR: f64 = 0.03;

/// Most rays per point by default: caustics of glass and curved mirrors would take far more.
pub(crate) const DEFAULT_RAYS: u32 = 2048;

/// Most rays per patch where only an error is requested.
const MOST_PATCH_RAYS: u32 = 1 << 17;

/// Rays of the stored rows of patches, at least.
const FEWEST_PATCH_RAYS: u32 = 32;

/// Patches whose errors may be as large as that of the light that is gathered from them; the squares
/// of errors grow with their number.
const AVERAGED_PATCHES: f64 = 20_000.0;

/// Largest error of patches, however many there are.
const MOST_PATCH_ERROR: f64 = 0.25;

impl FirstPass {
    pub(crate) fn effort(&self, method: Method) -> GatherEffort {
        let paths = match method {
            Method::Paths => Paths::Always,
            Method::Matrix | Method::Stochastic => Paths::Measured,
        };
        match (self.error, self.rays) {
            (None, None) => GatherEffort {
                error: Some(DEFAULT_ERROR),
                is_each: self.error_each,
                rays: DEFAULT_RAYS,
                paths,
                interpolate: self.interpolate,
            },
            (error, rays) => GatherEffort {
                error,
                is_each: self.error_each,
                rays: rays.unwrap_or(MOST_RAYS),
                paths,
                interpolate: self.interpolate,
            },
        }
    }

    /// Rays of the stored rows: all that were requested, if no error is.
    ///
    /// The error of a patch from n rays is about a half n^−0.6, and refinement leaves about that
    /// times n^−½ of the rows' noise: a fourth of the requested error.
    pub(crate) fn patch_rays(&self, purpose: PatchPurpose, patches: usize) -> u32 {
        let relief = purpose.relief(patches);
        let enough = (2.0 / (relief * self.aim())).powf(0.9);
        let fewest = ((128.0 / relief) as u32).clamp(FEWEST_PATCH_RAYS, 128);
        let enough = (enough as u32).max(fewest).next_power_of_two().min(2048);
        match (self.error, self.rays) {
            (None, Some(rays)) => rays,
            (_, most) => enough.min(most.unwrap_or(u32::MAX)),
        }
    }

    /// The relative error to reach, as far as the rays allow.
    pub(crate) fn aim(&self) -> f64 {
        self.error.unwrap_or(DEFAULT_ERROR)
    }

    /// The goal of refinement, if an error is to be reached. A limited number of bounces cannot be
    /// refined: the light of the last but one would be needed.
    pub(crate) fn goal(&self, purpose: PatchPurpose, patches: usize) -> Option<RefinementGoal> {
        let error = match (self.error, self.rays) {
            (None, Some(_)) => None,
            (error, _) => Some(error.unwrap_or(DEFAULT_ERROR)),
        };
        let larger = |e: f64| e.max(MOST_PATCH_ERROR.min(e * purpose.relief(patches)));
        let error = error.map(larger);
        let rays = self.rays.unwrap_or(MOST_PATCH_RAYS);
        let goal = error.map(|error| RefinementGoal { error, rays });
        goal.filter(|_| self.bounces.is_none())
    }

    /// The same with as many rays from each vertex or point as its budget affords.
    pub(crate) fn within_budget(&self, affordable: impl Fn(f64) -> u32) -> FirstPass {
        let Some(budget) = self.ray_budget else {
            return self.clone();
        };
        FirstPass {
            error: Some(self.aim()),
            rays: Some(affordable(budget)),
            ..self.clone()
        }
    }

    pub(crate) fn key(&self) -> u32 {
        hash(&[self.seed as u32, (self.seed >> 32) as u32])
    }
}

/// What the radiosity of patches is for: how large its error may be.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PatchPurpose<'p> {
    /// Each patch is a result.
    Result,
    /// To be gathered to vertices, which need to know which sides of surfaces are lit: every point
    /// reads hundreds of patches, whose errors are independent, so the more there are, the larger they
    /// may be.
    Vertices,
    /// To be gathered to these points, whose side is given; none if they are not known yet.
    Points(&'p [GatherPoint]),
}

impl PatchPurpose<'_> {
    /// How much larger the error of so many patches may be than that of the light in the end.
    fn relief(self, patches: usize) -> f64 {
        match self {
            PatchPurpose::Result => 1.0,
            PatchPurpose::Vertices | PatchPurpose::Points(_) => {
                (patches as f64 / AVERAGED_PATCHES).max(1.0).sqrt()
            }
        }
    }
}
