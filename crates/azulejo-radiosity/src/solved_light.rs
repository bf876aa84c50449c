//! The light of a scene, solved once and gathered as often as needed.

use crate::error::SolveError;
use crate::fine_light::IrradianceField;
use crate::first_pass::{FirstPass, PatchPurpose};
use crate::gather::{gather, gather_split};
use crate::gather_pass::GatherLight;
use crate::gathering::{GatherEffort, GatherTargets, Gathering};
use crate::path_pairs::{PairTargets, PathPair, gather_pairs};
use crate::report::{Estimate, Report};
use crate::solved::SolvedPatches;
use azulejo_factors::row::side;
use azulejo_factors::{PointNormal, ProxyScene};
use azulejo_scene::{Rgb, Scene};
use azulejo_trace::run::batches::in_counted_batches;
use azulejo_trace::sampling::hash;
use azulejo_trace::{
    Cancelled, DiffuseLight, GatherOptions, GatherPoint, Gathered, Gatherer, Harmonics,
    IncidentDomain, Run, RunStage, Termination, Tracer,
};
use rayon::prelude::*;
use std::ops::Range;

/// Points that are worked on together.
const BATCH: usize = 256;

/// Points whose directions of light are gathered together.
const HARMONIC_BATCH: usize = 16;

/// Batches of a block that processes share.
const BLOCK: usize = 1;

/// The light on the patches of a scene.
pub struct SolvedLight<'a> {
    proxy: &'a ProxyScene<'a>,
    solved: SolvedPatches<'a>,
    run: Run<'a>,
}

impl<'a> SolvedLight<'a> {
    /// Solves the light between patches. All that is gathered from it is part of the same `run`.
    ///
    /// # Errors
    /// As [`solve`](crate::solve()).
    pub fn new(
        proxy: &'a ProxyScene<'a>,
        pass: &FirstPass,
        run: impl Into<Run<'a>>,
    ) -> Result<SolvedLight<'a>, SolveError> {
        SolvedLight::for_points(proxy, pass, run.into(), &[])
    }

    /// The same for these points alone: without light between patches where paths from them cost less.
    ///
    /// # Errors
    /// As [`new`](SolvedLight::new).
    pub fn for_points(
        proxy: &'a ProxyScene<'a>,
        pass: &FirstPass,
        run: impl Into<Run<'a>>,
        points: &[PointNormal],
    ) -> Result<SolvedLight<'a>, SolveError> {
        let (places, run) = (gather_points(&proxy.on_polygons(points)), run.into());
        let purpose = PatchPurpose::Points(&places);
        Ok(SolvedLight {
            proxy,
            solved: SolvedPatches::new(proxy, pass, purpose, run, &mut |_, _| ())?,
            run,
        })
    }

    /// What gathers in the scene.
    pub fn gatherer(&self) -> &Gatherer<'a> {
        &self.solved.gatherer
    }

    /// Statistics and error of the light between patches.
    pub fn report(&self) -> Report {
        self.solved.report(&Gathering::new(GatherTargets {
            points: &[],
            areas: &[],
        }))
    }

    /// Irradiance of either side at a place of a face, as hits have it, front and back: that of the whole
    /// patch, W/m².
    pub fn sides_at(&self, [object, face, triangle]: [u32; 3], [u, v]: [f32; 2]) -> [Rgb; 2] {
        let patch = self.solved.patches.locate(object, face, triangle, u, v);
        [true, false].map(|front| self.solved.solution.incident[side(patch, front) as usize])
    }

    /// Makes sure that processes that share the work, if there are several, have the same light between patches:
    /// what is gathered from another would not fit.
    ///
    /// # Errors
    /// They have not.
    pub fn agree(&self) -> Result<(), Cancelled> {
        if !self.run.is_shared() {
            return Ok(());
        }
        let blocks = self.run.blocks;
        blocks.rely_on(blocks.loop_stage(), self.solved.digest())
    }

    /// Direct irradiance at points, from one shadow ray per source, W/m².
    ///
    /// # Errors
    /// The caller cancelled.
    pub fn direct_at(&self, points: &[GatherPoint]) -> Result<Vec<Rgb>, Cancelled> {
        let progress = self.run.progress;
        let batches: Vec<&[GatherPoint]> = points.chunks(BATCH).collect();
        progress.begin("direct light", points.len() as u64);
        let of_batch = |&batch: &usize| -> Result<Vec<Rgb>, Cancelled> {
            progress.advance(batches[batch].len() as u64)?;
            let direct = self.gatherer().direct(batches[batch], 1, 0);
            Ok(direct.iter().map(|light| light.whole().mean()).collect())
        };
        let size = (batches.len(), BLOCK);
        let irradiance = self
            .run
            .shared(size, |indices| indices.par_iter().map(of_batch).collect())?;
        Ok(irradiance.concat())
    }

    /// Irradiance at points and normals, all alike.
    ///
    /// Points on concave exact shapes may lie behind their proxy polygons, and are moved onto them.
    ///
    /// # Errors
    /// As [`solve`](crate::solve()).
    pub fn probe(&self, points: &[PointNormal]) -> Result<Probed, SolveError> {
        let digest = self.solved.digest();
        self.run.blocks.rely_on(RunStage::Points, digest)?;
        let places = gather_points(&self.proxy.on_polygons(points));
        let (light, black) = (self.solved.light(), self.solved.black_light());
        let gathering = gather(
            &self.solved.gatherer,
            GatherLight::new(&light, black.as_ref()),
            GatherTargets {
                points: &places,
                areas: &[],
            },
            self.solved.effort(),
            hash(&[self.solved.key(), 2]),
            self.run,
        )?;
        let errors = gathering.standard_errors();
        let estimate = |(g, &error): (&Gathered, &Rgb)| Estimate {
            // The estimate of a visible fraction may fall slightly below zero.
            value: g.mean().map(|e| e.max(0.0)),
            error,
        };
        let estimates = gathering
            .gathered
            .iter()
            .zip(&errors)
            .map(estimate)
            .collect();
        Ok(Probed {
            estimates,
            report: self.solved.report(&gathering),
        })
    }

    /// Indirect irradiance at points in two ways: from `fine` light, or that of patches where there is none,
    /// and path traced. Patches do not know how often their light was reflected: where bounces are limited,
    /// only what is path traced heeds that.
    ///
    /// # Errors
    /// The caller cancelled.
    pub fn path_pairs(
        &self,
        targets: &[PairTargets],
        fine: Option<&dyn IrradianceField>,
        seed: u32,
    ) -> Result<Vec<Vec<PathPair>>, SolveError> {
        let light = self.solved.light();
        let light = match fine {
            Some(field) => light.with_fine(field),
            None => light,
        };
        let black = self.solved.black_light();
        Ok(gather_pairs(
            &self.solved.gatherer,
            GatherLight::new(&light, black.as_ref()),
            targets,
            hash(&[self.solved.key(), 2, seed]),
            self.run,
        )?)
    }

    /// Direct light that arrives at points from all around, from these shadow rays per source and replicate.
    ///
    /// # Errors
    /// The caller cancelled.
    pub fn direct_harmonics(
        &self,
        points: &[GatherPoint],
        rays: Range<u32>,
    ) -> Result<Vec<Harmonics>, Cancelled> {
        let gatherer = self.gatherer();
        self.run.progress.begin("direct light", points.len() as u64);
        in_counted_batches(points, (HARMONIC_BATCH, BLOCK), self.run, |batch| {
            let behind = |point: &GatherPoint| GatherPoint {
                normal: -point.normal,
                ..*point
            };
            let behind: Vec<GatherPoint> = batch.iter().map(behind).collect();
            let sides =
                [batch, &behind].map(|side| gatherer.direct_harmonics(side, rays.clone(), 0).1);
            let both = sides[0].iter().zip(&sides[1]);
            Ok(both.map(|(front, back)| front.plus(back)).collect())
        })
    }

    /// Indirect light that arrives at points from a domain, from these rays of each that read `fine` light, or that
    /// of patches where there is none; where nothing is solved, and where bounces are limited, path traced.
    ///
    /// # Errors
    /// The caller cancelled.
    pub fn harmonics(
        &self,
        points: &[GatherPoint],
        domain: IncidentDomain,
        rays: Range<u32>,
        fine: Option<&dyn IrradianceField>,
        seed: u32,
    ) -> Result<Vec<Harmonics>, SolveError> {
        let mut light = self.solved.light();
        if let Some(field) = fine {
            light = light.with_fine(field);
        }
        let black = self.solved.black_light();
        let light = GatherLight::new(&light, black.as_ref());
        let is_traced = light.limited.is_some() || light.patches.is_unknown();
        let (light, termination) = light.ending(if is_traced {
            Termination::Roulette
        } else {
            Termination::Radiosity
        });
        let options = GatherOptions {
            rays: rays.end - rays.start,
            spent: rays.start,
            seed: hash(&[self.solved.key(), 3, seed]),
            termination,
        };
        let gatherer = self.gatherer();
        self.run
            .progress
            .begin("directions of light", points.len() as u64);
        Ok(in_counted_batches(
            points,
            (HARMONIC_BATCH, BLOCK),
            self.run,
            |batch| Ok(gatherer.indirect_harmonics(batch, domain, &options, light)),
        )?)
    }

    /// Indirect irradiance (W/m², all that [`Gatherer::direct`] does not count) at points that stand for areas
    /// (square scene units), so exact that with direct
    /// light beside it the error is `error`, relative to the mean. Samples depend on the points' keys and
    /// `seed`.
    ///
    /// # Errors
    /// As [`solve`](crate::solve()).
    pub fn indirect(
        &self,
        points: &[GatherPoint],
        areas: &[f64],
        error: f64,
        seed: u32,
    ) -> Result<Vec<Gathered>, SolveError> {
        let light = self.solved.light();
        let black = self.solved.black_light();
        let effort = GatherEffort {
            interpolate: false,
            error: Some(error),
            ..self.solved.effort()
        };
        // Parts that never meet store one gather of points alone: that of `split` or `probe`.
        let run = self.run.without_storage();
        let gathering: Gathering = gather_split(
            &self.solved.gatherer,
            GatherLight::new(&light, black.as_ref()),
            GatherTargets { points, areas },
            effort,
            hash(&[self.solved.key(), 2, seed]),
            run,
        )?;
        Ok(gathering.indirect())
    }

    /// Irradiance at points that stand for areas (square scene units), from `rays` rays at each, up to
    /// [`MOST_RAYS`](crate::gather::MOST_RAYS), whatever error that leaves. All of them read patches, as those of
    /// [`probe`](SolvedLight::probe) with rays alone; what patches are too coarse for is part of the stated errors.
    /// Samples depend on the points' keys and `seed`. In blocks of points, which are stored and divided.
    ///
    /// # Errors
    /// As [`solve`](crate::solve()), and [`SolveError::Elsewhere`].
    pub fn split(
        &self,
        points: &[GatherPoint],
        areas: &[f64],
        rays: u32,
        seed: u32,
    ) -> Result<SplitLight, SolveError> {
        let digest = self.solved.digest_at(points);
        self.run.blocks.rely_on(RunStage::Points, digest)?;
        let light = self.solved.light();
        let black = self.solved.black_light();
        let effort = GatherEffort {
            interpolate: false,
            error: None,
            rays,
            ..self.solved.effort()
        };
        let mut gathering = gather_split(
            &self.solved.gatherer,
            GatherLight::new(&light, black.as_ref()),
            GatherTargets { points, areas },
            effort,
            hash(&[self.solved.key(), 2, seed]),
            self.run,
        )?;
        let relative_error = gathering.relative_error();
        // Standard errors are those of what is in `gathered`: from here on, indirect light alone.
        gathering.gathered = gathering.indirect();
        let errors = gathering.standard_errors();
        let estimate = |(g, error): (&Gathered, Rgb)| Estimate {
            value: g.mean(),
            error,
        };
        Ok(SplitLight {
            direct: gathering.direct().to_vec(),
            indirect: gathering
                .gathered
                .iter()
                .zip(errors)
                .map(estimate)
                .collect(),
            relative_error,
        })
    }
}

/// Points, keyed by their numbers.
fn gather_points(points: &[PointNormal]) -> Vec<GatherPoint> {
    let place = |(i, p): (usize, &PointNormal)| GatherPoint {
        position: p.position,
        normal: p.normal,
        key: i as u32,
    };
    points.iter().enumerate().map(place).collect()
}

/// Irradiance at points by where it comes from, W/m².
#[derive(Clone, Debug, PartialEq)]
pub struct SplitLight {
    /// Straight from lamps and lights, or from them by one flat mirror: what [`Gatherer::direct`] counts.
    pub direct: Vec<Gathered>,
    /// All else.
    pub indirect: Vec<Estimate>,
    /// Estimated error of both together: its root mean square over the points by their areas, over the mean.
    pub relative_error: f64,
}

/// Irradiance at points.
#[derive(Clone, Debug, PartialEq)]
pub struct Probed {
    /// One estimate per point, W/m².
    pub estimates: Vec<Estimate>,
    /// Statistics and error of the solution.
    pub report: Report,
}

/// Irradiance at given points and normals. `keep_mesh` has no effect.
///
/// Points on concave exact shapes may lie behind their proxy polygons, and are moved onto them. A `&Progress` is a run
/// of one process; where several share it, points are divided, and the light between patches too if they talk to each
/// other.
///
/// # Errors
/// As [`solve`](crate::solve()), and [`SolveError::Elsewhere`].
pub fn probe<'r>(
    scene: &Scene,
    tracer: &Tracer,
    points: &[PointNormal],
    pass: &FirstPass,
    run: impl Into<Run<'r>>,
) -> Result<Probed, SolveError> {
    let proxy = ProxyScene::new(scene, tracer, pass.size);
    SolvedLight::for_points(&proxy, pass, run.into(), points)?.probe(points)
}
