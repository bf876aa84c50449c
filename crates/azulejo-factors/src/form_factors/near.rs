//! Pairs whose direct form factor a formula finds better than rays: close ones, whose steep kernel
//! rays sample badly, and those with emitters, whose noise does not average out.

use super::boxes::{BoxTree, distance};
use super::shaft::{Occluders, Shaft};
use super::sides::Sides;
use crate::analytic::exchange_area;
use crate::analytic_engine::planes::SurfacePlanes;
use crate::patch::Polygon;
use crate::shadow_rays::{View, sequence};
use azulejo_scene::math::Aabb;
use azulejo_trace::run::LoopSize;
use azulejo_trace::sampling::SobolTable;
use azulejo_trace::{Cancelled, Progress, Run, RunStage, Surfaces};
use glam::DVec3;
use rayon::prelude::*;

/// An exchange area with its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PairEstimate {
    pub column: u32,
    pub value: f64,
    pub error: f64,
}

impl PairEstimate {
    /// Whether nothing was sampled.
    pub fn is_exact(&self) -> bool {
        self.error <= 2.0 * FREE_ERROR * self.value
    }
}

/// The exact estimates of one row, by column.
pub(super) type PairEstimates = Vec<PairEstimate>;

/// The exact estimates of row `i`; none if `exact` has no rows.
pub(super) fn formulas(exact: &[PairEstimates], i: usize) -> &[PairEstimate] {
    exact.get(i).map_or(&[][..], |row| row)
}

/// Formulas per row, on average: in a furnished room they take as long as 1,400 rays per row.
/// Scenes of up to 64 rows are done by formula altogether.
const PAIRS_PER_ROW: usize = 32;

/// Reaches of close pairs: distance of the centres over the larger diameter. The largest that
/// [`PAIRS_PER_ROW`] allows is used.
const REACHES: [f64; 5] = [f64::INFINITY, 4.0, 2.0, 1.0, 0.5];

/// Relative error of an unoccluded form factor: what [`Shaft`] may miss.
const FREE_ERROR: f64 = 1e-7;

/// Pairs of a block, and pairs that are computed at once: a second or so.
const BLOCK: usize = 1 << 11;
const AT_ONCE: usize = 1 << 14;

/// Exact estimates of the selected pairs, in both rows of each, except those that are stored.
///
/// If others make the result, the columns are right and the values are 0: rows by rays need to know only
/// which pairs have a formula.
pub(super) fn exact(
    sides: &Sides,
    surfaces: &Surfaces,
    seed: u32,
    run: Run,
) -> Result<Vec<PairEstimates>, Cancelled> {
    let rows = PairSelector::new(sides, surfaces);
    let pairs = rows.pairs();
    let occluders = Occluders::new(sides.patches, surfaces.scene);
    let size = LoopSize {
        items: pairs.len(),
        block: BLOCK,
        at_once: AT_ONCE,
    };
    let own = run.own_items(size.items);
    run.progress.begin("formulas", own as u64);
    let estimate = |&pair: &usize| {
        run.progress.advance(1)?;
        let (i, j) = pairs[pair];
        Ok(rows.estimate(i, j, surfaces, &occluders, seed))
    };
    let block = |block: &[usize]| block.par_iter().map(estimate).collect();
    let estimates = run.resumed(RunStage::Formulas, size, block)?;
    let estimates = estimates.unwrap_or_else(|| vec![(0.0, 0.0); pairs.len()]);
    let mut exact = vec![PairEstimates::new(); sides.len()];
    for (&(i, j), (value, error)) in pairs.iter().zip(estimates) {
        for (row, column) in [(i, j), (j, i)] {
            exact[row as usize].push(PairEstimate {
                column,
                value,
                error,
            });
        }
    }
    exact
        .par_iter_mut()
        .for_each(|row| row.sort_unstable_by_key(|e| e.column));
    Ok(exact)
}

/// Number of pairs that have a formula.
pub(super) fn count(sides: &Sides, surfaces: &Surfaces) -> usize {
    PairSelector::new(sides, surfaces).pairs().len()
}

/// Exact estimates of all pairs of one row that have a formula.
pub(super) fn exact_row(
    sides: &Sides,
    surfaces: &Surfaces,
    row: usize,
    seed: u32,
    progress: &Progress,
) -> Result<PairEstimates, Cancelled> {
    let rows = PairSelector::new(sides, surfaces);
    let occluders = Occluders::new(sides.patches, surfaces.scene);
    let others: Vec<usize> = (0..sides.len())
        .filter(|&j| j != row && rows.within(row, j, f64::INFINITY))
        .collect();
    progress.begin("formulas", others.len() as u64);
    let estimate = |&j: &usize| {
        progress.advance(1)?;
        // A pair has one estimate, from whichever row it is requested.
        let (first, second) = (row.min(j) as u32, row.max(j) as u32);
        let (value, error) = rows.estimate(first, second, surfaces, &occluders, seed);
        Ok(PairEstimate {
            column: j as u32,
            value,
            error,
        })
    };
    others.par_iter().map(estimate).collect()
}

/// A flat row, with its corners counter-clockwise as seen from its side.
struct FlatRow {
    polygon: Vec<DVec3>,
    normal: DVec3,
    centre: DVec3,
    diameter: f64,
}

struct PairSelector<'a> {
    sides: &'a Sides<'a>,
    /// Sides in one plane, such as both of a patch, exchange nothing, however rounding has bent them.
    planes: SurfacePlanes,
    /// Flat rows; the others are left to rays.
    facets: Vec<Option<FlatRow>>,
    is_lamp: Vec<bool>,
    /// Between which points shadow rays are.
    points: SobolTable,
}

impl<'a> PairSelector<'a> {
    fn new(sides: &'a Sides<'a>, surfaces: &Surfaces) -> PairSelector<'a> {
        let facet = |i: usize| {
            let polygon = sides.patches.polygon(sides.patch(i))?;
            Some(FlatRow::new(sides, i, polygon))
        };
        let material =
            |i: usize| &surfaces.scene.materials[sides.patches.material(sides.patch(i)) as usize];
        let is_lamp = |i: usize| !material(i).emission_from(!sides.is_back(i)).is_black();
        let corners = |i: usize| sides.patches.polygon(i).map(|p| p.to_vec());
        let flat = (0..sides.patches.len()).filter_map(corners);
        let bounds = Aabb::around(flat.flatten());
        PairSelector {
            sides,
            planes: SurfacePlanes::new(sides.patches, surfaces.scene, &bounds),
            facets: (0..sides.len()).into_par_iter().map(facet).collect(),
            is_lamp: (0..sides.len()).map(is_lamp).collect(),
            points: sequence(),
        }
    }

    /// Pairs i < j of rows that face each other and are close or include an emitter, in order.
    fn pairs(&self) -> Vec<(u32, u32)> {
        let most = PAIRS_PER_ROW * self.sides.len();
        let mut pairs = REACHES
            .iter()
            .find_map(|&reach| self.close(reach, most))
            .unwrap_or_default();
        let lamps = self.is_lamp.iter().filter(|&&is_lamp| is_lamp).count();
        if lamps * self.sides.len() <= most {
            pairs.extend(self.lamp_pairs());
            pairs.sort_unstable();
            pairs.dedup();
        }
        pairs
    }

    /// Pairs within `reach` diameters; `None` if there are more than `most`.
    fn close(&self, reach: f64, most: usize) -> Option<Vec<(u32, u32)>> {
        let n = self.sides.len();
        // Half of all pairs face each other, if that many.
        if reach.is_infinite() && n.saturating_mul(n) / 2 > most {
            return None;
        }
        let centres = self
            .facets
            .iter()
            .map(|f| Aabb::around(f.iter().map(|f| f.centre)));
        let tree = BoxTree::new(&centres.collect::<Vec<_>>());
        let mut pairs = Vec::new();
        for i in 0..n {
            let Some(facet) = &self.facets[i] else {
                continue;
            };
            let radius = reach * facet.diameter;
            let is_close = |bounds: &Aabb| distance(bounds, facet.centre) < radius;
            let is_full = tree.any(is_close, |j| {
                if self.is_smaller(j as usize, i) && self.within(i, j as usize, radius) {
                    pairs.push((j.min(i as u32), j.max(i as u32)));
                }
                pairs.len() > most
            });
            if is_full {
                return None;
            }
        }
        pairs.sort_unstable();
        Some(pairs)
    }

    /// Each pair is found by its larger row; of equal ones by the later.
    fn is_smaller(&self, j: usize, i: usize) -> bool {
        let size = |k: usize| {
            let facet = self.facets[k].as_ref();
            facet.map_or(f64::INFINITY, |f| f.diameter)
        };
        (size(j), j) < (size(i), i)
    }

    fn within(&self, i: usize, j: usize, radius: f64) -> bool {
        let (Some(a), Some(b)) = (&self.facets[i], &self.facets[j]) else {
            return false;
        };
        let [first, second] = [i, j].map(|row| self.planes.number(self.sides.patch(row)));
        a.centre.distance(b.centre) < radius && first != second && a.faces(b) && b.faces(a)
    }

    fn lamp_pairs(&self) -> impl Iterator<Item = (u32, u32)> {
        let lamps = (0..self.sides.len()).filter(|&i| self.is_lamp[i]);
        let pairs = lamps.flat_map(|i| (0..self.sides.len()).map(move |j| (i, j)));
        pairs
            .filter(|&(i, j)| self.within(i, j, f64::INFINITY))
            .map(|(i, j)| (i.min(j) as u32, i.max(j) as u32))
    }

    /// Exchange area of a pair and its standard error.
    fn estimate(
        &self,
        i: u32,
        j: u32,
        surfaces: &Surfaces,
        occluders: &Occluders,
        seed: u32,
    ) -> (f64, f64) {
        let (Some(a), Some(b)) = (&self.facets[i as usize], &self.facets[j as usize]) else {
            return (0.0, 0.0);
        };
        let whole = exchange_area(&a.polygon, &b.polygon);
        if whole == 0.0 || occluders.is_free(&Shaft::new(&a.polygon, &b.polygon)) {
            return (whole, FREE_ERROR * whole);
        }
        let view = View {
            patches: self.sides.patches,
            surfaces,
            pair: [i, j].map(|row| self.sides.patch(row as usize)),
            normals: [a.normal, b.normal],
            up: None,
            key: [seed, i, j],
            points: &self.points,
        };
        let visible = view.visible();
        (whole * visible.share, whole * visible.error)
    }
}

impl FlatRow {
    fn new(sides: &Sides, row: usize, polygon: Polygon) -> FlatRow {
        let patch = sides.patch(row);
        let mut polygon = polygon.to_vec();
        let mut normal = sides.patches.normal(patch);
        if sides.is_back(row) {
            polygon.reverse();
            normal = -normal;
        }
        FlatRow {
            polygon,
            normal,
            centre: sides.patches.centre(patch),
            diameter: sides.patches.diameter(patch),
        }
    }

    /// Whether any corner of the other is in front, beyond rounding.
    fn faces(&self, other: &FlatRow) -> bool {
        let least = 1e-9 * (self.diameter + other.diameter);
        other
            .polygon
            .iter()
            .any(|&c| (c - self.centre).dot(self.normal) > least)
    }
}
