//! Irradiance from light that is read, beside path traced irradiance from the same directions.

use crate::deadline::GatherPace;
use crate::gather::{GatherLight, GatherPass};
use azulejo_trace::{Cancelled, DiffuseLight, GatherPoint, Gathered, Gatherer, Termination, Work};
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

/// Which rays of every point.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PairRange {
    /// Those that read light.
    pub read: Range<u32>,
    /// Those that are path traced.
    pub traced: Range<u32>,
}

/// Gathers at all points in both ways, whatever time it is: a point without light would be dark. Direct light is
/// left out.
///
/// # Errors
/// The caller cancelled.
pub(crate) fn gather_pairs(
    gatherer: &Gatherer,
    light: GatherLight<impl DiffuseLight>,
    points: &[GatherPoint],
    rays: &PairRange,
    seed: u32,
    (journal, progress): Work,
) -> Result<Vec<PathPair>, Cancelled> {
    let pass = GatherPass {
        gatherer,
        light,
        points,
        journal,
        pace: &GatherPace::default(),
        seed,
        progress,
    };
    progress.begin("irradiance", 3 * points.len() as u64);
    let indirect = |rays: &Range<u32>, termination| -> Result<Vec<Gathered>, Cancelled> {
        if rays.is_empty() {
            return Ok(vec![Gathered::default(); points.len()]);
        }
        let found = pass.gather_all(rays.clone(), termination)?;
        Ok(found.into_iter().map(|f| f.indirect).collect())
    };
    let read = indirect(&rays.read, Termination::Radiosity)?;
    let few = if rays.read == rays.traced {
        read.clone()
    } else {
        indirect(&rays.traced, Termination::Radiosity)?
    };
    let traced = indirect(&rays.traced, Termination::Roulette)?;
    let pairs = read.into_iter().zip(few).zip(traced);
    Ok(pairs
        .map(|((read, few), traced)| PathPair { read, few, traced })
        .collect())
}
