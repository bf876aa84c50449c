//! The indirect light of texels, from the solved first pass: to an error, or from a number of rays.

use super::{BakedLight, DEFAULT_ERROR};
use azulejo_bake::{
    Atlas, BetweenTexels, DirectGather, DirectTexels, Samples, ShownSamples, TexelCells,
    TexelField, TexelHarmonics,
};
use azulejo_radiosity::sites::{
    IndirectGoal, SiteDirect, SiteLight, SiteStatistics, first_look, look_again, with_indirect,
};
use azulejo_radiosity::{IrradianceField, PairTargets, PathPair, SolveError, SolvedLight};
use azulejo_trace::{Cancelled, GatherPoint, Gathered, Harmonics, IncidentDomain, Run};

/// Share of the permitted error that is left to noise and patches beside interpolation.
const NOISE_SHARE: f64 = 0.85;

/// Rays per point of the first look at the light.
const FIRST_RAYS: u32 = 128;

/// Rays by which it is asked where the indirect light of a node comes from.
const DIRECTION_RAYS: u32 = 128;

/// Rays of the first look once the deadline has passed.
const LATE_RAYS: u32 = 32;

/// Looks after the first, each corrected by paths: what patches leak into the dark, and miss where it is
/// bright, is hardly left in the light that the last gather reads.
const LOOKS: u32 = 2;

/// Part of what texels are too coarse for that indirect light may be off by, whatever is asked: together
/// both are hardly more.
const BESIDE_RESOLUTION: f64 = 0.2;

/// Least and most error of direct light beside that of indirect light from a number of rays: with less, shadow
/// edges would be looked for in noise, and with more they would be missed.
const DIRECT_ERROR: [f64; 2] = [1e-3, DEFAULT_ERROR];

/// The light of all samples.
pub struct SampleLight {
    /// What comes straight from lamps and lights.
    pub direct: DirectTexels,
    /// All that is baked, and direct light.
    pub all: Vec<SiteLight>,
    /// How it was computed.
    pub texels: SiteStatistics,
    /// The error that was aimed at, relative to the mean.
    pub error: f64,
}

/// Where the indirect light of texels comes from.
pub struct IndirectLight<'a> {
    pub solved: &'a SolvedLight<'a>,
    /// Most bounces, if they are limited.
    pub bounces: Option<u32>,
    pub error: f64,
    /// Whether it is asked where direct light comes from.
    pub is_directional: bool,
    /// Shared as that of `solved`.
    pub run: Run<'a>,
}

impl IndirectLight<'_> {
    /// The light of all samples to the requested error.
    pub fn to_error(
        &self,
        atlas: &Atlas,
        objects: &[u32],
        samples: &Samples,
        light: BakedLight,
        seed: u32,
    ) -> Result<SampleLight, SolveError> {
        let (error, run) = (self.error, self.run);
        let gather = self.direct_gather(atlas, samples, seed);
        let direct = azulejo_bake::direct(gather, error, run)?;
        let (all, texels) = match light {
            BakedLight::Direct => (
                direct.light.light(),
                SiteStatistics {
                    sites: samples.samples.len(),
                    nodes: 0,
                },
            ),
            _ => self.of_texels(atlas, objects, (samples, &direct.light), seed)?,
        };
        Ok(SampleLight {
            direct,
            all,
            texels,
            error,
        })
    }

    /// What gathers direct light.
    fn direct_gather<'g>(
        &'g self,
        atlas: &'g Atlas,
        samples: &'g Samples,
        seed: u32,
    ) -> DirectGather<'g> {
        DirectGather {
            samples,
            atlas,
            gatherer: self.solved.gatherer(),
            is_directional: self.is_directional,
            seed,
        }
    }

    /// Indirect light with direct light of all samples: a first look at that of patches, others at the look before, and the last, to
    /// the requested error.
    fn of_texels(
        &self,
        atlas: &Atlas,
        objects: &[u32],
        (samples, direct): (&Samples, &SiteDirect),
        seed: u32,
    ) -> Result<(Vec<SiteLight>, SiteStatistics), SolveError> {
        // Indirect light need not be much better than texels can show direct light.
        let coarse = self.too_coarse_for(atlas, samples, direct, seed)?;
        let goal = IndirectGoal {
            relative: self.error,
            least: BESIDE_RESOLUTION * coarse,
        };
        let surfaces = self.solved.gatherer().surfaces();
        // The first look reads the light of patches.
        let mut look = |points: &[GatherPoint]| {
            let is_late = self.run.progress.out_of_time();
            let rays = if is_late { LATE_RAYS } else { FIRST_RAYS };
            self.read_at(points, None, rays, 0)
        };
        let cells = TexelCells::new(samples);
        let (mut light, cells) = first_look(cells, direct, goal, self.run, &mut look)?;
        // Limited bounces are path traced, so that further looks have nothing to correct.
        if self.bounces.is_some() {
            let mut gather =
                |targets: &[PairTargets]| targets.iter().map(|t| self.limited(t)).collect();
            return with_indirect(cells, direct, goal, true, self.run, &mut gather);
        }
        // Each look reads the one before, and is corrected by paths: patches leak light into the dark.
        for number in 1..=LOOKS {
            if self.run.progress.out_of_time() {
                break;
            }
            let field = TexelField::new(atlas, samples, &light, objects, surfaces);
            drop(std::mem::take(&mut light));
            let mut gather =
                |targets: &[PairTargets]| self.solved.path_pairs(targets, Some(&field), number);
            light = look_again(&cells, direct, self.run, &mut gather)?;
        }
        // The last gather reads the last look, and takes as many rays as the error needs.
        let field = TexelField::new(atlas, samples, &light, objects, surfaces);
        drop(light);
        let mut gather =
            |targets: &[PairTargets]| self.solved.path_pairs(targets, Some(&field), LOOKS + 1);
        with_indirect(cells, direct, goal, false, self.run, &mut gather)
    }

    /// The light of all samples from `rays` rays at each. No sample depends on what others get until all have their
    /// light, so that processes that never meet can share it. Direct light comes from the same gather, but at the
    /// edges of shadows, and is about as exact as the rest.
    pub fn with_rays(
        &self,
        atlas: &Atlas,
        samples: &Samples,
        rays: u32,
        seed: u32,
    ) -> Result<SampleLight, SolveError> {
        let (points, areas) = azulejo_bake::sample_points(samples);
        let light = (self.solved).split(&points, &areas, rays, LOOKS + 1)?;
        let error = light.relative_error.clamp(DIRECT_ERROR[0], DIRECT_ERROR[1]);
        let gather = self.direct_gather(atlas, samples, seed);
        let direct = azulejo_bake::direct_from(gather, (&light.direct, error), self.run)?;
        let indirect = light.indirect.iter().map(|e| (e.value, e.error));
        Ok(SampleLight {
            all: direct.light.plus(indirect),
            direct,
            texels: SiteStatistics {
                sites: points.len(),
                nodes: points.len(),
            },
            error,
        })
    }

    /// Adds to where direct light comes from, if that was asked for, where indirect light does, by rays that read
    /// `field`.
    pub fn add_directions(
        &self,
        harmonics: &mut TexelHarmonics,
        samples: &Samples,
        field: &TexelField,
    ) -> Result<(), SolveError> {
        if harmonics.is_empty() {
            return Ok(());
        }
        let mut gather = |points: &[GatherPoint]| -> Result<Vec<Harmonics>, SolveError> {
            let domain = IncidentDomain::Hemisphere;
            (self.solved).harmonics(points, domain, 0..DIRECTION_RAYS, Some(field), LOOKS + 3)
        };
        harmonics.add_indirect(samples, self.run, &mut gather)
    }

    /// The light at points between texels, from rays that read `field`.
    pub fn at(
        &self,
        points: &[GatherPoint],
        field: &TexelField,
    ) -> Result<Vec<Gathered>, SolveError> {
        if self.bounces.is_some() {
            let areas = vec![1.0; points.len()];
            let error = NOISE_SHARE * self.error;
            return self.solved.indirect(points, &areas, error, LOOKS + 2);
        }
        self.read_at(points, Some(field), FIRST_RAYS, LOOKS + 2)
    }

    /// Root mean square of the direct light that texels are too coarse for, W/m², about.
    fn too_coarse_for(
        &self,
        atlas: &Atlas,
        samples: &Samples,
        direct: &SiteDirect,
        seed: u32,
    ) -> Result<f64, Cancelled> {
        let gatherer = self.solved.gatherer();
        let light = direct.light();
        let shown = ShownSamples::new(samples, &light, gatherer.surfaces());
        let none = vec![SiteLight::default(); light.len()];
        let between = BetweenTexels {
            atlas,
            samples,
            shown: &shown,
            direct,
            rest: &none,
            gatherer,
            error: self.error,
            seed,
        };
        let mut lightmap = shown.lightmap(samples, &light);
        for page in &mut lightmap.pages {
            azulejo_bake::pad_charts(page, 1);
        }
        between.estimate(&lightmap, self.run)
    }

    /// The light at points by so many rays that read that of patches, or `field`.
    fn read_at(
        &self,
        points: &[GatherPoint],
        field: Option<&dyn IrradianceField>,
        rays: u32,
        look: u32,
    ) -> Result<Vec<Gathered>, SolveError> {
        let targets = PairTargets {
            points,
            areas: &[],
            read: 0..rays,
            traced: 0..0,
        };
        let pairs = self.solved.path_pairs(&[targets], field, look)?;
        Ok(pairs.into_iter().flatten().map(|pair| pair.read).collect())
    }

    /// Where bounces are limited, all is path traced.
    fn limited(&self, targets: &PairTargets) -> Result<Vec<PathPair>, SolveError> {
        let error = NOISE_SHARE * self.error;
        let indirect = self
            .solved
            .indirect(targets.points, targets.areas, error, LOOKS + 1)?;
        let node = |read| PathPair {
            read,
            ..PathPair::default()
        };
        Ok(indirect.into_iter().map(node).collect())
    }
}
