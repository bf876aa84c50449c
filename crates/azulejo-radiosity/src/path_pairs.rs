//! Irradiance from light that is read, beside path traced irradiance from the same directions.

use crate::deadline::GatherPace;
use crate::gather_pass::{GatherLight, GatherPass, PointList};
use azulejo_trace::{Cancelled, DiffuseLight, GatherPoint, Gathered, Gatherer, Run, Termination};
use std::ops::Range;

/// Indirect irradiance of a point, found in two ways, W/m².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathPair {
    /// From the light that all rays read: quick, without much noise, and as wrong as that light.
    pub read: Gathered,
    /// The same from the first few of the rays.
    pub few: Gathered,
    /// Path traced, from the same directions as `few`: right on average.
    pub traced: Gathered,
}

/// Points that get the same rays.
#[derive(Clone, Debug)]
pub struct PairTargets<'a> {
    /// Where.
    pub points: &'a [GatherPoint],
    /// The area for which each stands, square scene units; empty where nothing depends on it.
    pub areas: &'a [f64],
    /// Which rays of each read light.
    pub read: Range<u32>,
    /// Which rays of each are path traced.
    pub traced: Range<u32>,
}

/// Gathers at all points in both ways, whatever time it is: a point without light would be dark. Direct light is
/// left out. All in one loop that processes share.
///
/// # Errors
/// The caller cancelled.
pub(crate) fn gather_pairs(
    gatherer: &Gatherer,
    light: GatherLight<impl DiffuseLight>,
    targets: &[PairTargets],
    seed: u32,
    run: Run,
) -> Result<Vec<Vec<PathPair>>, Cancelled> {
    let points: Vec<GatherPoint> = targets.iter().flat_map(|t| t.points).copied().collect();
    let pass = GatherPass {
        gatherer,
        light,
        points: &points,
        pace: &GatherPace::default(),
        seed,
        run,
    };
    run.progress.begin("irradiance", 3 * points.len() as u64);
    let mut lists = Vec::new();
    let mut first = 0;
    for target in targets {
        let all = first..first + target.points.len() as u32;
        first = all.end;
        let mut add = |rays: &Range<u32>, termination| {
            // Without rays there is nothing to gather.
            let points = if rays.start < rays.end {
                all.clone().collect()
            } else {
                Vec::new()
            };
            let rays = rays.clone();
            lists.push(PointList {
                points,
                rays,
                termination,
                has_direct: false,
            });
        };
        add(&target.read, Termination::Radiosity);
        // Where all rays are path traced, those that read light are the same.
        let few = if target.read == target.traced {
            &(0..0)
        } else {
            &target.traced
        };
        add(few, Termination::Radiosity);
        add(&target.traced, Termination::Roulette);
    }
    let mut gathered = pass.gather_lists(&lists, false)?.into_iter();
    let mut next = |count: usize| -> Vec<Gathered> {
        let list = gathered.next().unwrap_or_default();
        let indirect = list.into_iter().flatten().map(|f| f.indirect);
        let mut light: Vec<Gathered> = indirect.collect();
        light.resize(count, Gathered::default());
        light
    };
    let pairs = targets.iter().map(|target| {
        let count = target.points.len();
        let (read, few, traced) = (next(count), next(count), next(count));
        let few = if target.read == target.traced {
            read.clone()
        } else {
            few
        };
        let all = read.into_iter().zip(few).zip(traced);
        all.map(|((read, few), traced)| PathPair { read, few, traced })
            .collect()
    });
    Ok(pairs.collect())
}
