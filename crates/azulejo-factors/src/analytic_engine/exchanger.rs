//! Rows of exchange areas, distributed over threads.

use super::check::STRATA;
pub(crate) use super::horizon::Horizon;
use super::images::{FlatMirror, ImageLimits, MirrorImage, MirrorImages};
use super::occluders::SceneOccluders;
use super::planes::SurfacePlanes;
pub(crate) use super::traversal::UpwardSum;
use super::traversal::{
    ExchangeBlock, HorizonSplit, PairAccuracy, PairCounts, PairTraversal, RequestedRows, SplitPairs,
};
use super::work::PairWork;
use super::{Facet, FacetTree};
use crate::analytic::{Approximate, exchange_area_fast, form_factor_fast};
use crate::exchange_areas::{Exchange, ExchangeAreas};
use crate::exchange_areas::{read_row, write_row};
use crate::patch::Patches;
use crate::row::{ORDERS, Side};
use crate::shadow_rays::{View, sequence};
use azulejo_scene::math::area_vector;
use azulejo_trace::run::{LoopSize, Record, RecordReader, write_list};
use azulejo_trace::sampling::SobolTable;
use azulejo_trace::{Cancelled, Progress, Run, RunStage, Surfaces};
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// Rows computed together.
const GROUP: usize = 16;

/// Groups of a block: one, so that many processes have something to do to the end.
const BLOCK: usize = 1;

/// Fewest and most groups that are computed at once: enough for many threads.
const AT_ONCE: [usize; 2] = [16, 64];

/// Bytes of these, within these limits.
const BYTES_AT_ONCE: usize = 16 << 20;

/// Groups of a matrix of so many rows that are computed at once.
fn groups_at_once(rows: usize) -> usize {
    let group = GROUP * size_of::<Exchange>() * rows.max(1);
    (BYTES_AT_ONCE / group).clamp(AT_ONCE[0], AT_ONCE[1])
}

/// Bytes that an exchanger and its work take, besides the matrix: facets with their Gauss points and
/// clusters, a group of rows for each thread, and the groups that are computed at once.
pub(crate) fn working_bytes(rows: usize, threads: usize) -> f64 {
    let pair = (size_of::<f64>() + size_of::<f32>()) as f64;
    let groups = (threads * GROUP * rows) as f64 * pair;
    let at_once = (groups_at_once(rows) * GROUP * rows * size_of::<Exchange>()) as f64;
    rows as f64 * FACET_BYTES + groups + at_once
}

/// Bytes per facet, about: its corners, thirteen Gauss points, and a share of the clusters.
const FACET_BYTES: f64 = 1_200.0;

/// Up to this many sides, rows are exact by default.
const FEW: usize = 32;

/// Options of an [`Exchanger`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExchangerOptions {
    /// RMS error of the sums of rows; `None` chooses by the number of rows.
    pub accuracy: Option<f64>,
    /// Whether each channel is needed, so that coloured mirrors are left to rays.
    pub is_per_channel: bool,
    /// Seed of the shadow rays.
    pub seed: u32,
    /// Seconds of counted work after which a row is left to rays; infinite if it never is.
    pub row_budget: f64,
}

/// Computes exchange areas. Immutable; shared by all threads.
pub(crate) struct Exchanger<'a> {
    patches: &'a Patches,
    surfaces: &'a Surfaces<'a>,
    sides: Vec<Side>,
    facets: FacetTree,
    /// Position of each side's facet, or [`NOWHERE`].
    positions: Vec<u32>,
    images: Vec<MirrorImage>,
    truncated: f64,
    /// What is taken as flat, where coordinates are rounded.
    pub flatness: Option<String>,
    /// Distance by which rounding moves corners; 0 where coordinates are exact.
    rounding: f64,
    accuracy: PairAccuracy,
    /// Between which points shadow rays are.
    points: SobolTable,
    /// For each patch, whether some side may see its back.
    shows_back: Vec<bool>,
    /// Orders that are known completely by formulas.
    pub known: [bool; ORDERS],
    seed: u32,
    row_budget: f64,
}

/// The position of sides without a facet: curved ones.
const NOWHERE: u32 = u32::MAX;

/// Entries of one row, by order.
pub(crate) type Orders = [Vec<Exchange>; ORDERS];

impl<'a> Exchanger<'a> {
    /// Between these sides of patches; their indices in the list are rows and columns.
    pub fn new(
        patches: &'a Patches,
        surfaces: &'a Surfaces<'a>,
        sides: Vec<Side>,
        options: ExchangerOptions,
    ) -> Exchanger<'a> {
        let scene_occluders = SceneOccluders::new(patches, surfaces, &sides);
        let planes = &scene_occluders.planes;
        let facet = |(row, &side): (usize, &Side)| facet(patches, planes, side, row as u32);
        let list: Vec<Facet> = sides.iter().enumerate().filter_map(facet).collect();
        let (mut images, known) = images(
            patches,
            surfaces,
            &scene_occluders,
            &list,
            options.is_per_channel,
        );
        let facets = FacetTree::new(&list, scene_occluders.size);
        let set_columns = |image: &mut MirrorImage| image.set_columns(&facets.list);
        images.list.par_iter_mut().for_each(set_columns);
        let mut positions = vec![NOWHERE; sides.len()];
        for (position, facet) in facets.list.iter().enumerate() {
            positions[facet.id as usize] = position as u32;
        }
        Exchanger {
            accuracy: accuracy(options.accuracy, sides.len()),
            points: sequence(),
            patches,
            surfaces,
            sides,
            facets,
            positions,
            images: images.list,
            truncated: images.truncated,
            flatness: planes.note(),
            rounding: planes.rounding.map_or(0.0, |_| planes.graze),
            shows_back: scene_occluders.shows_back,
            known,
            seed: options.seed,
            row_budget: options.row_budget,
        }
    }

    /// The largest share of any row's light that takes chains of mirrors without images; `None` if
    /// there are no images at all.
    pub fn truncated(&self) -> Option<f64> {
        (self.images.len() > 1).then_some(self.truncated)
    }

    /// Whether formulas know everything.
    pub fn is_complete(&self) -> bool {
        self.known == [true; ORDERS] && self.positions.iter().all(|&p| p != NOWHERE)
    }

    /// The stratum of neighbours that a column belongs to, for [`Strata`](super::check::Strata); `None` if it has no formula.
    pub fn stratum(&self, column: usize) -> Option<usize> {
        let position = self.positions[column];
        (position != NOWHERE).then(|| position as usize * STRATA / self.facets.list.len())
    }

    /// The rows that have formulas, neighbours next to each other.
    pub fn rows_in_order(&self) -> Vec<usize> {
        self.facets.list.iter().map(|f| f.id as usize).collect()
    }

    /// Whether a row has a formula.
    pub fn has(&self, row: usize) -> bool {
        self.positions[row] != NOWHERE
    }

    /// The upper triangle of each order, by rows, except blocks that are stored; `None` if others
    /// make the result. Rows that time ran out for are not marked in `is_done`. With an `up` direction, what leaves
    /// them upwards of the light to columns that their horizon cuts is found as well.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn all(&self, up: Option<DVec3>, run: Run) -> Result<Option<AllPairs>, Cancelled> {
        let positions: Vec<u32> = (0..self.facets.list.len() as u32).collect();
        let groups: Vec<&[u32]> = positions.chunks(GROUP).collect();
        let size = LoopSize {
            items: groups.len(),
            block: BLOCK,
            at_once: groups_at_once(self.sides.len()),
        };
        let own = run.own_items(size.items);
        let progress = run.progress;
        progress.begin("exchange areas", own as u64);
        let group = |&group: &usize| {
            progress.advance(1)?;
            if progress.out_of_time() {
                return Ok(RowGroup::default());
            }
            Ok(self.group(groups[group], true, up).0)
        };
        let done = run.resumed(RunStage::Pairs, size, |indices| {
            indices.par_iter().map(group).collect()
        })?;
        Ok(done.map(|done| self.assembled(done, up.is_some())))
    }

    /// The pairs of all groups.
    fn assembled(&self, done: Vec<RowGroup>, is_split: bool) -> AllPairs {
        let n = self.sides.len();
        let mut orders = [(); ORDERS].map(|()| vec![Box::<[Exchange]>::default(); n]);
        // Rows without a facet count as done.
        let mut is_done: Vec<bool> = self.positions.iter().map(|&p| p == NOWHERE).collect();
        let mut counts = PairCounts::default();
        let mut upward = vec![UpwardSum::default(); if is_split { n } else { 0 }];
        for group in done {
            counts.add(&group.counts);
            for (id, sum) in group.upward {
                upward[id as usize].add(sum.value, sum.variance);
            }
            for (id, row) in group.rows {
                is_done[id as usize] = !group.given_up.contains(&id);
                if !is_done[id as usize] {
                    // Rays find the pairs that it has again.
                    continue;
                }
                for (order, row) in orders.iter_mut().zip(row) {
                    order[id as usize] = row.into();
                }
            }
        }
        AllPairs {
            is_doubtful: vec![false; n],
            orders: orders.map(ExchangeAreas::from_rows),
            is_done,
            counts,
            upward: is_split.then_some(upward),
        }
    }

    /// Whole rows, in the requested order; empty for those without a facet. Each depends on its
    /// own facet alone, whichever others are requested with it.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn rows(
        &self,
        rows: &[usize],
        progress: &Progress,
    ) -> Result<Vec<Option<Orders>>, Cancelled> {
        let positions = self.sorted_positions(rows);
        let groups: Vec<&[u32]> = positions.chunk_by(same_group).collect();
        let group = |rows: &&[u32]| {
            progress.advance(rows.len() as u64)?;
            Ok(self.group(rows, false, None).0)
        };
        let groups: Vec<RowGroup> = groups
            .par_iter()
            .map(group)
            .collect::<Result<_, Cancelled>>()?;
        let mut places = vec![NOWHERE; self.sides.len()];
        for (k, &row) in rows.iter().enumerate() {
            places[row] = k as u32;
        }
        let mut sorted = vec![None; rows.len()];
        for group in groups {
            let given_up = group.given_up;
            for (id, row) in group
                .rows
                .into_iter()
                .filter(|(id, _)| !given_up.contains(id))
            {
                sorted[places[id as usize] as usize] = Some(row);
            }
        }
        Ok(sorted)
    }

    /// What all pairs will take, from a few rows all over the scene. Ends early where these take more
    /// than `most` seconds of counted work by themselves.
    pub fn forecast(&self, up: Option<DVec3>, most: f64) -> WorkForecast {
        let count = self.facets.list.len();
        let samples = count.min(SAMPLED_ROWS);
        // Numbers that a multiple of the golden ratio leaves are spread evenly, however many are used.
        let place = |k: usize| ((k as f64 * GOLDEN).fract() * count as f64) as u32;
        let mut work = PairWork::default();
        let mut forecast = WorkForecast::default();
        for k in 0..samples {
            let (_, row_work, seconds) = self.group(&[place(k)], false, up);
            work.add(&row_work);
            forecast.longest_row = f64::max(forecast.longest_row, seconds);
            forecast.tried += 1;
            if work.seconds() > most {
                break;
            }
        }
        // Each pair is computed once.
        let rows = count as f64 / forecast.tried.max(1) as f64;
        forecast.seconds = 0.5 * rows * work.in_group().seconds();
        forecast
    }

    /// Positions of the facets of rows that have one: neighbours together, so that clusters are
    /// tested for many rows at once.
    fn sorted_positions(&self, rows: &[usize]) -> Vec<u32> {
        let positions = rows.iter().map(|&row| self.positions[row]);
        let mut positions: Vec<u32> = positions.filter(|&p| p != NOWHERE).collect();
        positions.sort_unstable();
        positions
    }

    /// Some rows of one group of [`GROUP`] neighbours, from the diagonal on if `upper`; the work, and the
    /// seconds of it that were pairs.
    fn group(&self, rows: &[u32], upper: bool, up: Option<DVec3>) -> (RowGroup, PairWork, f64) {
        let group = RowGroupPlaces::new(rows, self.facets.list.len());
        let requested = RequestedRows {
            places: &group.places,
            upper,
            split: up.map(|up| self.horizon_split(SplitPairs::All, up, self.sides.len())),
            budget: self.row_budget,
        };
        let mut blocks: [Option<ExchangeBlock>; ORDERS] = Default::default();
        let mut counts = PairCounts::default();
        let (mut work, mut seconds) = (PairWork::default(), 0.0);
        let mut given_up = Vec::new();
        for image in &self.images {
            let block = blocks[image.order]
                .get_or_insert_with(|| ExchangeBlock::new(rows.len(), self.facets.list.len()));
            let done = self.add_image(image, &group, requested, block);
            counts.add(&done.counts);
            work.add(&done.work);
            seconds += done.seconds;
            given_up.extend(done.given_up);
            // Each image may be cheap, and all of them together not.
            if seconds > self.row_budget * rows.len() as f64 {
                let ids = rows.iter().map(|&k| self.facets.list[k as usize].id);
                given_up.extend(ids);
                break;
            }
        }
        given_up.sort_unstable();
        given_up.dedup();
        let row = |(k, position): (usize, &u32)| {
            let sorted = |block: &Option<ExchangeBlock>| {
                let mut entries = block.as_ref().map_or(Vec::new(), |f| self.entries(f, k));
                entries.sort_unstable_by_key(|e| e.column);
                entries
            };
            let id = self.facets.list[*position as usize].id;
            (id, blocks.each_ref().map(sorted))
        };
        let group = RowGroup {
            rows: rows.iter().enumerate().map(row).collect(),
            counts,
            given_up,
            upward: blocks[0]
                .as_ref()
                .map_or(Vec::new(), |block| self.upward(rows, block)),
        };
        (group, work, seconds)
    }

    /// What leaves the facets of a block upwards, where that is anything.
    fn upward(&self, rows: &[u32], block: &ExchangeBlock) -> Vec<(u32, UpwardSum)> {
        let of_rows = rows.iter().zip(&block.upward_of_rows);
        let of_rows = of_rows.map(|(&k, sum)| (self.facets.list[k as usize].id, *sum));
        let of_columns = self.facets.list.iter().zip(&block.upward_of_columns);
        let all = of_rows.chain(of_columns.map(|(facet, sum)| (facet.id, *sum)));
        all.filter(|(_, sum)| *sum != UpwardSum::default())
            .collect()
    }

    /// Adds what an image contributes to the requested rows of a group.
    fn add_image(
        &self,
        image: &MirrorImage,
        group: &RowGroupPlaces,
        requested: RequestedRows,
        block: &mut ExchangeBlock,
    ) -> ImagePairs {
        let rows = image.rows(self.facets.list[group.whole.clone()].iter());
        let mut traversal =
            PairTraversal::new(image, &rows, &self.facets, self.accuracy, requested);
        traversal.run(block);
        for &(row, column) in &traversal.unresolved {
            let Some(place) = group.places[row] else {
                continue;
            };
            let row = group.whole.start + row;
            let Some(split) = requested.split else {
                let seen = self.by_shadow_rays(row, column, None);
                block.add(place, column, seen.whole, seen.error);
                continue;
            };
            let seen = self.by_shadow_rays(row, column, Some(split.up));
            let [a, b] = [row, column].map(|k| &self.facets.list[k]);
            if split.pairs == SplitPairs::All || b.id >= split.rows {
                block.add(place, column, seen.whole, seen.error);
            }
            let upward = Approximate {
                value: seen.upward,
                error: seen.upward_error,
            };
            let cuts = split.cuts(a, b, image.graze);
            block.add_split([place, column], split.pairs, seen.whole, upward, cuts);
        }
        let own = group.whole.clone().enumerate();
        let given_up =
            own.filter(|&(row, _)| group.places[row].is_some() && traversal.is_given_up(row));
        ImagePairs {
            counts: traversal.counts,
            work: traversal.work,
            seconds: traversal.pair_seconds(),
            given_up: given_up.map(|(_, k)| self.facets.list[k].id).collect(),
        }
    }

    /// Of some rows, what no matrix of theirs tells: how much leaves upwards of the light to columns
    /// that a row's horizon cuts, unless this is known, and how much ends on columns from `rows` on, which are not
    /// rows. Without mirrors.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn split_at_horizon(
        &self,
        of: &[usize],
        up: DVec3,
        rows: usize,
        is_cut_known: bool,
        progress: &Progress,
    ) -> Result<Vec<SplitRow>, Cancelled> {
        let positions = self.sorted_positions(of);
        let groups: Vec<&[u32]> = positions.chunk_by(same_group).collect();
        let pairs = if is_cut_known {
            SplitPairs::Hidden
        } else {
            SplitPairs::Cut
        };
        let split = self.horizon_split(pairs, up, rows);
        progress.begin("sky view factors", groups.len() as u64);
        let group = |rows: &&[u32]| {
            progress.advance(1)?;
            Ok(self.split_group(rows, split))
        };
        let split_rows: Vec<Vec<(u32, SplitRow)>> = groups
            .par_iter()
            .map(group)
            .collect::<Result<_, Cancelled>>()?;
        let mut sorted = vec![SplitRow::default(); of.len()];
        let mut places = vec![NOWHERE; self.sides.len()];
        for (k, &row) in of.iter().enumerate() {
            places[row] = k as u32;
        }
        for (id, row) in split_rows.into_iter().flatten() {
            sorted[places[id as usize] as usize] = row;
        }
        Ok(sorted)
    }

    fn horizon_split(&self, pairs: SplitPairs, up: DVec3, rows: usize) -> HorizonSplit {
        HorizonSplit {
            pairs,
            up,
            rows: rows as u32,
            // Exact formulas know no horizon.
            error: self.accuracy.partial.max(EXACT),
        }
    }

    /// Some rows of one group of neighbours, split at the horizon.
    fn split_group(&self, rows: &[u32], split: HorizonSplit) -> Vec<(u32, SplitRow)> {
        let group = RowGroupPlaces::new(rows, self.facets.list.len());
        let requested = RequestedRows {
            places: &group.places,
            upper: false,
            split: Some(split),
            budget: f64::INFINITY,
        };
        let mut block = ExchangeBlock::with_upward(rows.len(), self.facets.list.len());
        for image in self.images.iter().filter(|image| image.order == 0) {
            self.add_image(image, &group, requested, &mut block);
        }
        let row = |(k, &position): (usize, &u32)| {
            let id = self.facets.list[position as usize].id;
            (id, self.split_row(&block, k, split.rows))
        };
        rows.iter().enumerate().map(row).collect()
    }

    /// The sums of one row of a block, over columns in their fixed order.
    fn split_row(&self, block: &ExchangeBlock, row: usize, rows: u32) -> SplitRow {
        let (values, errors) = block.row(row);
        let mut sums = SplitRow::default();
        for (k, facet) in self.facets.list.iter().enumerate() {
            sums.upward += block.upward(row)[k];
            sums.variance += f64::from(errors[k]).powi(2);
            if facet.id >= rows {
                sums.hidden += values[k];
            }
        }
        sums
    }

    /// The share of a row's light that may pass cracks which the rounding of coordinates opens: of a
    /// strip along its border.
    pub fn crack(&self, row: usize) -> f64 {
        let facet = &self.facets.list[self.positions[row] as usize];
        let corners = facet.polygon();
        let next = corners.iter().cycle().skip(1);
        let border: f64 = corners.iter().zip(next).map(|(a, b)| a.distance(*b)).sum();
        self.rounding * border / facet.area
    }

    /// A row's horizon.
    pub fn horizon(&self, row: usize, up: DVec3) -> Horizon {
        let facet = &self.facets.list[self.positions[row] as usize];
        Horizon::new(facet, up, self.images[0].graze)
    }

    /// Sides that are not rows although rows may see them.
    pub fn hidden_sides(&self, is_column: impl Fn(u32, bool) -> bool) -> Vec<Side> {
        let patches = (0..self.patches.len() as u32).filter(|&p| self.shows_back[p as usize]);
        patches
            .filter(|&p| !is_column(p, false))
            .map(|p| 2 * p + 1)
            .collect()
    }

    fn entries(&self, block: &ExchangeBlock, row: usize) -> Vec<Exchange> {
        let (values, errors) = block.row(row);
        // Of the exact size: most of the memory is in these lists.
        let count = values.iter().filter(|&&value| value > 0.0).count();
        let mut entries = Vec::with_capacity(count);
        let places = 0..values.len();
        let seen = places.filter(|&c| values[c] > 0.0);
        entries.extend(seen.map(|c| Exchange {
            column: self.facets.list[c].id,
            value: values[c],
            error: errors[c],
        }));
        entries
    }

    /// A pair that is too complex for formulas, or that rays find sooner.
    fn by_shadow_rays(&self, row: usize, column: usize, up: Option<DVec3>) -> SeenByRays {
        let (a, b) = (&self.facets.list[row], &self.facets.list[column]);
        let view = View {
            patches: self.patches,
            surfaces: self.surfaces,
            pair: [a, b].map(|f| (self.sides[f.id as usize] / 2) as usize),
            normals: [a.normal, b.normal],
            up,
            key: [self.seed, a.id.min(b.id), a.id.max(b.id)],
            points: &self.points,
        };
        let whole = exchange_area_fast(a.polygon(), b.polygon(), self.accuracy.whole);
        // Variances in proportion to form factors add up to that of the row, and take the fewest rays for that.
        let goal = self.accuracy.row * (a.area.min(b.area) / whole).sqrt();
        let visible = view.visible_within(goal);
        SeenByRays {
            whole: whole * visible.share,
            error: whole * visible.error,
            upward: whole * visible.upward,
            upward_error: whole * visible.upward_error,
        }
    }
}

/// A pair by shadow rays: its exchange area and what of it leaves the first facet upwards, with standard errors.
struct SeenByRays {
    whole: f64,
    error: f64,
    upward: f64,
    upward_error: f64,
}

/// Whether two positions belong to one group.
fn same_group(a: &u32, b: &u32) -> bool {
    a / GROUP as u32 == b / GROUP as u32
}

/// The requested rows of a group of [`GROUP`] neighbours in the tree.
///
/// The traversal takes the whole group, because its clusters decide how pairs are computed: with
/// clusters of the requested rows alone, a row would depend on which others are requested, and
/// solvers request as many at a time as there are threads.
struct RowGroupPlaces {
    /// Positions of the whole group.
    whole: Range<usize>,
    /// For each of these its place among the requested rows.
    places: Vec<Option<usize>>,
}

impl RowGroupPlaces {
    fn new(rows: &[u32], facets: usize) -> RowGroupPlaces {
        let first = rows[0] as usize / GROUP * GROUP;
        let whole = first..(first + GROUP).min(facets);
        let mut places = vec![None; whole.len()];
        for (place, &row) in rows.iter().enumerate() {
            places[row as usize - first] = Some(place);
        }
        RowGroupPlaces { whole, places }
    }
}

/// Exchange areas of one row that [`Exchanger::split_at_horizon`] sums up.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SplitRow {
    /// To columns that the horizon cuts and to those that are not rows: the part above the horizon.
    pub upward: f64,
    /// To columns that are not rows.
    pub hidden: f64,
    /// Variance of either.
    pub variance: f64,
}

/// The result of [`Exchanger::all`].
pub(crate) struct AllPairs {
    pub orders: [ExchangeAreas; ORDERS],
    /// Rows that are complete, from the diagonal on.
    pub is_done: Vec<bool>,
    /// Rows that rays contradict: neither they nor their columns are there.
    pub is_doubtful: Vec<bool>,
    pub counts: PairCounts,
    /// By row what leaves it upwards of the light to columns that its horizon cuts, if that was requested.
    pub upward: Option<Vec<UpwardSum>>,
}

/// Upper rows that were computed together; empty if time ran out.
#[derive(Default)]
struct RowGroup {
    rows: Vec<(u32, Orders)>,
    counts: PairCounts,
    /// Those of the rows that took more than their budget, in order, and are not complete.
    given_up: Vec<u32>,
    /// What leaves rows and columns upwards.
    upward: Vec<(u32, UpwardSum)>,
}

/// What one image was for a group of rows.
struct ImagePairs {
    counts: PairCounts,
    work: PairWork,
    /// Of the work, pairs.
    seconds: f64,
    /// Rows that took more than their budget.
    given_up: Vec<u32>,
}

/// Most rows of a forecast.
const SAMPLED_ROWS: usize = 32;

/// The fractional part of the golden ratio.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Work before it is done.
#[derive(Clone, Debug, Default)]
pub(crate) struct WorkForecast {
    /// Seconds that all pairs take on one core.
    pub seconds: f64,
    /// Seconds of the pairs of the longest of the rows that were tried.
    pub longest_row: f64,
    /// Rows that were tried.
    pub tried: usize,
}

impl Record for RowGroup {
    fn is_complete(&self) -> bool {
        !self.rows.is_empty()
    }

    fn write(&self, bytes: &mut Vec<u8>) {
        write_list(&self.rows, bytes, |(id, orders), bytes| {
            bytes.extend(id.to_le_bytes());
            orders.iter().for_each(|row| write_row(row, bytes));
        });
        let counts = self.counts.counts();
        bytes.extend(counts.into_iter().flat_map(u64::to_le_bytes));
        write_list(&self.given_up, bytes, |id, bytes| {
            bytes.extend(id.to_le_bytes())
        });
        write_list(&self.upward, bytes, |(id, sum), bytes| {
            bytes.extend(id.to_le_bytes());
            bytes.extend(sum.value.to_le_bytes());
            bytes.extend(sum.variance.to_le_bytes());
        });
    }

    fn read(bytes: &mut RecordReader) -> Option<RowGroup> {
        let row = |b: &mut RecordReader| {
            let id = b.u32()?;
            let orders = [read_row(b)?, read_row(b)?, read_row(b)?];
            Some((id, orders))
        };
        let rows = bytes.list(row)?;
        let mut counts = [0; 6];
        for count in &mut counts {
            *count = bytes.u64()?;
        }
        let counts = PairCounts::of(counts);
        let given_up = bytes.list(RecordReader::u32)?;
        let sum = |b: &mut RecordReader| {
            let id = b.u32()?;
            let (value, variance) = (b.f64()?, b.f64()?);
            Some((id, UpwardSum { value, variance }))
        };
        Some(RowGroup {
            rows,
            counts,
            given_up,
            upward: bytes.list(sum)?,
        })
    }
}

fn facet(patches: &Patches, planes: &SurfacePlanes, side: Side, row: u32) -> Option<Facet> {
    let patch = (side / 2) as usize;
    let mut polygon = patches.polygon(patch)?.to_vec();
    let mut normal = patches.normal(patch);
    if side % 2 == 1 {
        polygon.reverse();
        normal = -normal;
    }
    let plane = planes.of(patch, normal)?;
    Some(Facet::new(row, &polygon, plane.normal).in_plane(plane))
}

/// The accuracy of pairs that gives the sums of rows the requested one.
fn accuracy(error: Option<f64>, rows: usize) -> PairAccuracy {
    let error = error.unwrap_or(if rows <= FEW { 1e-11 } else { 5e-5 });
    if error < EXACT {
        return PairAccuracy {
            whole: 1e-13,
            partial: error,
            row: error,
            is_exact: true,
        };
    }
    PairAccuracy {
        whole: 0.4 * error,
        // Measured on rooms of 500 to 20,000 facets: partially occluded pairs are a few of each
        // row, with nearly independent errors; finer divisions have more of them.
        partial: error * (12.0 / (rows as f64).sqrt()).min(0.25),
        row: error,
        is_exact: false,
    }
}

/// Below this accuracy only exact formulas will do.
const EXACT: f64 = 1e-6;

/// The chains of mirrors whose images pay off, and the orders that they cover completely.
fn images(
    patches: &Patches,
    surfaces: &Surfaces,
    scene_occluders: &SceneOccluders,
    facets: &[Facet],
    is_per_channel: bool,
) -> (MirrorImages, [bool; ORDERS]) {
    let specular = |i: &usize| {
        let material = &surfaces.scene.materials[patches.material(*i) as usize];
        material.is_specular()
    };
    let all: Vec<usize> = (0..patches.len()).filter(specular).collect();
    let is_flat_mirror = |&i: &usize| {
        let material = &surfaces.scene.materials[patches.material(i) as usize];
        let is_sharp = material.dielectric.is_none() && material.glossy().is_none();
        let is_mirror = is_sharp && patches.polygon(i).is_some();
        is_mirror && (material.mirror.is_grey() || !is_per_channel)
    };
    let mirrors = if scene_occluders.curved.is_empty() && all.iter().all(is_flat_mirror) {
        scene_occluders.mirrors(patches, surfaces, &all)
    } else {
        Vec::new()
    };
    let is_few = facets.len() <= FEW;
    let pays = is_few || cost_of_images(&mirrors, facets) <= MOST_COST;
    let mirrors: &[FlatMirror] = if pays { &mirrors } else { &[] };
    let limits = ImageLimits {
        least: 1e-10,
        // Each costs up to as much as the scene itself: between divided surfaces rays are faster.
        chains: if is_few { 8_192 } else { 0 },
        most_truncated: 1e-5,
    };
    let corners: Vec<DVec3> = facets.iter().flat_map(|f| f.polygon()).copied().collect();
    let reach = |window: &[DVec3]| {
        // Windows are visible from either side.
        let back: Vec<DVec3> = window.iter().rev().copied().collect();
        let share = |f: &Facet| {
            let of = |polygon: &[DVec3]| form_factor_fast(f.polygon(), polygon, 1e-2);
            of(window) + of(&back)
        };
        facets.iter().map(share).fold(0.0, f64::max)
    };
    let images = MirrorImages::new(scene_occluders, mirrors, limits, &corners, reach);
    let by_images = all.is_empty() || !mirrors.is_empty();
    let known = [true, by_images, by_images && images.is_complete];
    (images, known)
}

/// Images of mirrors that cost up to this, relative to the direct pairs, are better than rays.
const MOST_COST: f64 = 6.0;

/// Upper bound of the cost of pairs by one mirror, over all mirrors, relative to the direct pairs:
/// the share of pairs on the same side of the mirror's plane.
fn cost_of_images(mirrors: &[FlatMirror], facets: &[Facet]) -> f64 {
    let cost = |mirror: &FlatMirror| {
        let normal = area_vector(&mirror.polygon).normalize_or_zero();
        let heights = || {
            facets
                .iter()
                .map(|f| normal.dot(f.centre - mirror.polygon[0]))
        };
        let sides = [1.0, -1.0].map(|side| heights().filter(|h| side * h > 0.0).count());
        let squares = sides.map(|count| (count as f64 / facets.len() as f64).powi(2));
        squares.iter().sum::<f64>()
    };
    mirrors.iter().map(cost).sum()
}
