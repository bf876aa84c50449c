//! Form factors from points, which have no area and take no part in the exchange: sensors.

use super::matrix::RowRemainder;
use super::rows::ending;
use super::spread::{NoiseModel, SPREAD_FREEDOM, excess_spread, mean_and_variance};
use super::{Factor, MOST_RAYS, PreparedPlan};
use crate::proxy::PointNormal;
use crate::rays::{BATCH, HitPatches, Visits};
use crate::row::order;
use azulejo_scene::Rgb;
use azulejo_scene::math::{Frame, Ray};
use azulejo_trace::follow::{Event, Path, Scratch, follow};
use azulejo_trace::sampling::{SobolTable, cosine_about, hash, seeds};
use azulejo_trace::{Cancelled, Progress, REPLICATES};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// A place at which light arrives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FactorPoint {
    /// World position.
    pub position: DVec3,
    /// Unit normal of a receiver that weighs directions by their cosine to it; `None` for one that
    /// weighs the whole sphere alike, as a small globe does.
    pub normal: Option<DVec3>,
}

/// What a point sees: shares of its hemisphere weighted by cosine, or of the whole sphere.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointFactors {
    /// Number and factor of each group of columns that is seen, ascending.
    pub factors: Vec<(u32, Factor)>,
    /// Shares that reach no column that has a group.
    pub rest: RowRemainder,
}

/// Keys the random numbers of points.
pub(super) const POINTS: u32 = 3;

impl PreparedPlan<'_> {
    /// The form factors from each point to groups of the columns of the matrix, of which there are
    /// `count`, directly and by all mirrors and glass: an element dA → surface, or solid angle / 4π. `groups`
    /// has one for each column; what columns without one receive is `hidden`.
    ///
    /// Each point has the rays of a row, in four replicates whose spread gives the standard errors,
    /// also of sums over groups. The result depends on the number of a point in the list, and not
    /// on the number of threads.
    ///
    /// # Errors
    /// [`Cancelled`].
    ///
    /// # Panics
    /// If there is not one group for each column, or a group beyond `count`.
    pub fn factors_from_points(
        &self,
        points: &[FactorPoint],
        (groups, count): (&[Option<u32>], usize),
        progress: &Progress,
    ) -> Result<Vec<PointFactors>, Cancelled> {
        assert_eq!(groups.len(), self.rows(), "one group for each column");
        progress.begin("point factors", points.len() as u64);
        let rays = self.plan.options.rays.clamp(1, MOST_RAYS);
        let per_replicate = (rays as usize).div_ceil(REPLICATES);
        let surfaces = self.gatherer.surfaces();
        let sampling = PointSampling {
            plan: self,
            groups,
            table: SobolTable::new(per_replicate),
            per_replicate,
            seed: hash(&[self.seed, POINTS]),
            hit_patches: HitPatches::new(surfaces, &self.plan.patches),
        };
        let start = || PointWork::new(count);
        let placed = points.par_iter().zip(self.placed(points)).enumerate();
        let factors = placed.map_init(start, |work, (k, (point, position))| {
            let at = FactorPoint { position, ..*point };
            let factors = sampling.point(k as u32, &at, work);
            progress.advance(1)?;
            Ok(factors)
        });
        factors.collect()
    }

    /// Where rays start: in front of the polygons that stand for exact surfaces.
    pub(super) fn placed(&self, points: &[FactorPoint]) -> Vec<DVec3> {
        let facing = |p: &FactorPoint| PointNormal {
            position: p.position,
            normal: p.normal.unwrap_or(DVec3::ZERO),
        };
        let facing: Vec<PointNormal> = points.iter().map(facing).collect();
        let placed = self.plan.proxy.on_polygons(&facing);
        let tracer = &self.plan.proxy.tracer;
        let leaving = |p: &PointNormal| tracer.leaving(p.position, p.normal);
        placed.iter().map(leaving).collect()
    }
}

/// How points are sampled.
struct PointSampling<'a> {
    plan: &'a PreparedPlan<'a>,
    groups: &'a [Option<u32>],
    table: SobolTable,
    per_replicate: usize,
    seed: u32,
    hit_patches: HitPatches<'a>,
}

/// What the rays of one point found, by replicate.
#[derive(Default)]
struct Sums {
    groups: Vec<[f64; REPLICATES]>,
    /// Groups that are not zero.
    seen: Vec<u32>,
    escaped: [[f64; 2]; REPLICATES],
    hidden: [f64; REPLICATES],
    ended: f64,
    cut: f64,
}

/// What a thread keeps from point to point.
struct PointWork {
    sums: Sums,
    /// What single rays bring to groups by mirrors and glass.
    visits: Visits,
    paths: Vec<Path>,
    scratch: Scratch,
}

impl PointWork {
    fn new(groups: usize) -> PointWork {
        let visits = Visits::new(groups);
        let groups = vec![[0.0; REPLICATES]; groups];
        PointWork {
            visits,
            sums: Sums {
                groups,
                ..Sums::default()
            },
            paths: Vec::new(),
            scratch: Scratch::default(),
        }
    }
}

impl Sums {
    fn add(&mut self, group: u32, replicate: usize, weight: f64) {
        let sums = &mut self.groups[group as usize];
        if *sums == [0.0; REPLICATES] {
            self.seen.push(group);
        }
        sums[replicate] += weight;
    }
}

impl PointSampling<'_> {
    fn point(&self, number: u32, point: &FactorPoint, work: &mut PointWork) -> PointFactors {
        for replicate in 0..REPLICATES {
            for first in (0..self.per_replicate).step_by(BATCH) {
                let last = (first + BATCH).min(self.per_replicate);
                let words = [self.seed, number, replicate as u32];
                self.fill(point, first..last, seeds(&words), &mut work.paths);
                let chances = hash(&[hash(&words), first as u32]);
                self.follow(work, chances, replicate);
            }
        }
        self.finish(work)
    }

    /// Rays from a point, for a stretch of a replicate's sequence.
    fn fill(
        &self,
        point: &FactorPoint,
        stretch: std::ops::Range<usize>,
        scrambling: [u32; 4],
        paths: &mut Vec<Path>,
    ) {
        let tracer = &self.plan.plan.proxy.tracer;
        let frame = point.normal.map(Frame::from_normal);
        let share = 1.0 / self.per_replicate as f64;
        paths.extend(stretch.zip(0..).map(|(k, id)| {
            let [u, v, ..] = self.table.point(k, scrambling).map(f64::from);
            let direction = match &frame {
                Some(frame) => cosine_about(frame, u, v),
                None => on_sphere(u, v),
            };
            Path::new(
                tracer.kernel_ray(&Ray::new(point.position, direction)),
                id,
                Rgb::grey(share),
            )
        }));
    }

    fn follow(&self, work: &mut PointWork, chances: u32, replicate: usize) {
        let PointWork {
            sums,
            visits,
            paths,
            scratch,
        } = work;
        let surfaces = self.plan.gatherer.surfaces();
        let up = surfaces.scene.units.up.axis();
        let share = 1.0 / REPLICATES as f64;
        follow(surfaces, paths, scratch, chances, |path, event| {
            let weight = path.weight.mean();
            match event {
                Event::Escape => {
                    let is_up = surfaces.tracer.world_ray(&path.leg.ray).direction.dot(up) >= 0.0;
                    sums.escaped[replicate][usize::from(!is_up)] += weight;
                }
                Event::Cut => sums.cut += weight * share,
                Event::Absorbed => {}
                Event::Surface { hit, front } => {
                    let ends = (path.weight * ending(surfaces.material(hit.item))).mean();
                    let patch = self.hit_patches.at(&hit);
                    let column = self.plan.sides.column(patch, front);
                    match column.and_then(|column| self.groups[column as usize]) {
                        Some(group) => {
                            sums.add(group, replicate, weight);
                            sums.ended += ends * share;
                            let order = order(path);
                            if order > 0 || surfaces.is_specular(hit.item) {
                                visits.add(path.id, group, order, weight);
                            }
                        }
                        None => sums.hidden[replicate] += ends,
                    }
                }
            }
        });
        visits.end(1.0 / self.per_replicate as f64);
    }

    /// Means and standard errors; empties the sums.
    fn finish(&self, PointWork { sums, visits, .. }: &mut PointWork) -> PointFactors {
        let visits = visits.take();
        let excess = |group: u32| -> f64 {
            let first = visits.partition_point(|e| e.side < group);
            let own = visits[first..].iter().take_while(|e| e.side == group);
            own.map(|e| e.weight.mean()).sum::<f64>() / (REPLICATES * REPLICATES) as f64
        };
        let mut seen = std::mem::take(&mut sums.seen);
        seen.sort_unstable();
        let factors = seen.iter().map(|&group| {
            let replicates = std::mem::take(&mut sums.groups[group as usize]);
            (group, self.factor(replicates, excess(group)))
        });
        let factors = factors.collect();
        let [sky, ground] = [0, 1].map(|way| self.factor(sums.escaped.map(|e| e[way]), 0.0));
        let hidden = self.factor(sums.hidden, 0.0);
        let lost = 1.0 - sums.ended - hidden.value - sums.cut - sky.value - ground.value;
        let rest = RowRemainder {
            sky: sky.value,
            sky_error: sky.error,
            ground: ground.value,
            ground_error: ground.error,
            hidden: hidden.value,
            hidden_error: hidden.error,
            cut: sums.cut,
            lost: if lost > ROUNDING { lost } else { 0.0 },
        };
        *sums = Sums {
            groups: std::mem::take(&mut sums.groups),
            ..Sums::default()
        };
        PointFactors { factors, rest }
    }

    /// A share, where the squares of what single rays bring are larger by `excess` than those of hits.
    fn factor(&self, replicates: [f64; REPLICATES], excess: f64) -> Factor {
        let (value, spread) = mean_and_variance(replicates);
        let hit = 1.0 / (REPLICATES * self.per_replicate) as f64;
        let spread = spread + excess_spread(value, hit, excess, SPREAD_FREEDOM);
        let error = NoiseModel::Hits.error(value, spread, hit);
        Factor { value, error }
    }
}

/// Below this, a share is missing only by rounding.
const ROUNDING: f64 = 1e-9;

/// A direction of the whole sphere, each as likely (Archimedes).
fn on_sphere(u: f64, v: f64) -> DVec3 {
    let (sin, cos) = (TAU * v).sin_cos();
    let z = 1.0 - 2.0 * u;
    let radius = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(radius * cos, radius * sin, z)
}
