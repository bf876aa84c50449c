//! Hierarchical traversal of all pairs of some rows with all columns.

use super::gauss_points::{FOUR, NINE};
use super::horizon::{Elevation, Horizon};
use super::images::MirrorImage;
use super::partial::{PairGoal, PartialVisibility, rough};
use super::shaft::ClusterShaft;
use super::work::{PairWork, WorkKind};
use super::{Cluster, Facet, FacetTree, Facing};
use crate::analytic::{Approximate, Effect, exchange_area, exchange_area_fast, exchange_area_past};
use crate::shadow_rays::{MOST_RAYS, rays_for};
use azulejo_scene::math::Aabb;
use glam::DVec3;
use std::ops::Range;

/// The accuracy of pairs.
#[derive(Clone, Copy, Debug)]
pub(super) struct PairAccuracy {
    /// Relative error of unoccluded pairs.
    pub whole: f64,
    /// Absolute error of the form factors of partially occluded pairs.
    pub partial: f64,
    /// RMS error of the sums of rows.
    pub row: f64,
    /// Whether all pairs take the exact formulas, so that these errors may be small.
    pub is_exact: bool,
}

/// Exchange areas with their errors, by row of the group and position of the column.
pub(super) struct ExchangeBlock {
    values: Vec<f64>,
    errors: Vec<f32>,
    /// The parts that leave upwards, if they were requested.
    upward: Vec<f64>,
    /// What leaves rows and columns upwards of the pairs that a horizon cuts, if it was requested of all pairs.
    pub upward_of_rows: Vec<UpwardSum>,
    pub upward_of_columns: Vec<UpwardSum>,
    columns: usize,
}

/// What leaves a facet upwards, of some pairs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct UpwardSum {
    /// Exchange area, square scene units.
    pub value: f64,
    /// Its variance.
    pub variance: f64,
}

impl UpwardSum {
    pub fn add(&mut self, value: f64, variance: f64) {
        self.value += value;
        self.variance += variance;
    }
}

impl ExchangeBlock {
    pub fn new(rows: usize, columns: usize) -> ExchangeBlock {
        ExchangeBlock {
            values: vec![0.0; rows * columns],
            errors: vec![0.0; rows * columns],
            upward: Vec::new(),
            upward_of_rows: vec![UpwardSum::default(); rows],
            upward_of_columns: vec![UpwardSum::default(); columns],
            columns,
        }
    }

    /// The same with room for the parts that leave upwards.
    pub fn with_upward(rows: usize, columns: usize) -> ExchangeBlock {
        ExchangeBlock {
            upward: vec![0.0; rows * columns],
            ..ExchangeBlock::new(rows, columns)
        }
    }

    /// What leaves a row upwards, by column.
    pub fn upward(&self, row: usize) -> &[f64] {
        &self.upward[row * self.columns..(row + 1) * self.columns]
    }

    /// Counts what leaves a pair upwards: its row, or of [`SplitPairs::All`] both ends, each where its horizon `cuts`
    /// the pair, of which `whole` is the exchange area.
    pub fn add_split(
        &mut self,
        [row, column]: [usize; 2],
        pairs: SplitPairs,
        whole: f64,
        upward: Approximate,
        cuts: [bool; 2],
    ) {
        if pairs != SplitPairs::All {
            let k = row * self.columns + column;
            self.upward[k] += upward.value;
            self.errors[k] = self.errors[k].hypot(upward.error as f32);
            return;
        }
        let variance = upward.error * upward.error;
        if cuts[0] {
            self.upward_of_rows[row].add(upward.value, variance);
        }
        // What arrives from below leaves the other end upwards.
        if cuts[1] {
            let rest = (whole - upward.value).max(0.0);
            self.upward_of_columns[column].add(rest, variance);
        }
    }

    /// Values and errors of a row, by column.
    pub fn row(&self, row: usize) -> (&[f64], &[f32]) {
        let range = row * self.columns..(row + 1) * self.columns;
        (&self.values[range.clone()], &self.errors[range])
    }

    pub fn add(&mut self, row: usize, column: usize, value: f64, error: f64) {
        let k = row * self.columns + column;
        self.values[k] += value;
        self.errors[k] += error as f32;
    }
}

/// Which rows of a group are computed, and how much of them.
#[derive(Clone, Copy)]
pub(super) struct RequestedRows<'a> {
    /// For each row of the group its row of the [`ExchangeBlock`], if it is requested.
    pub places: &'a [Option<usize>],
    /// Whether only pairs from the diagonal on are computed.
    pub upper: bool,
    /// Whether the parts that leave upwards are computed, and only of pairs that need it.
    pub split: Option<HorizonSplit>,
    /// Seconds of pairs after which a row is given up.
    pub budget: f64,
}

/// Which pairs are split at the horizon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SplitPairs {
    /// Those that it cuts, and those with columns that are not rows, of which the whole exchange area is computed
    /// as well.
    Cut,
    /// Those with columns that are not rows.
    Hidden,
    /// Those that it cuts, from either end, beside the exchange areas of all.
    All,
}

/// Which pairs are split at the horizon, and how.
#[derive(Clone, Copy)]
pub(super) struct HorizonSplit {
    pub pairs: SplitPairs,
    pub up: DVec3,
    /// Facets with numbers from this on are not rows.
    pub rows: u32,
    /// Absolute error of form factors.
    pub error: f64,
}

impl HorizonSplit {
    pub fn elevation(&self, from: &Facet, to: &Facet, graze: f64) -> Elevation {
        Horizon::new(from, self.up, graze).elevation(&Horizon::new(to, self.up, graze))
    }

    /// Whether the horizon of either facet cuts the other.
    pub fn cuts(&self, a: &Facet, b: &Facet, graze: f64) -> [bool; 2] {
        [[a, b], [b, a]].map(|[from, to]| self.elevation(from, to, graze) == Elevation::Mixed)
    }

    /// Whether no horizon cuts pairs of two clusters: then it cuts none of their facets, to which
    /// `graze` is allowed.
    fn is_clear(&self, from: &Aabb, to: &Aabb, graze: f64) -> bool {
        let range = |b: &Aabb| {
            let (middle, reach) = (self.up.dot(b.centre()), self.up.abs().dot(0.5 * b.size()));
            (middle - reach, middle + reach)
        };
        let ((low, high), (lowest, highest)) = (range(from), range(to));
        lowest >= high - 0.5 * graze || highest <= low + 0.5 * graze
    }
}

/// A node of a binary tree over the rows of the group.
struct RowNode {
    range: Range<usize>,
    is_requested: bool,
    cluster: Cluster,
    /// The second half; 0 in a leaf. The first half is the next node.
    second: usize,
}

/// Most rows per leaf.
const FEW_ROWS: usize = 2;

/// Pairs with more obstructions than this are left to shadow rays.
const MOST_OBSTRUCTIONS: usize = 24;

/// Microseconds of a shadow ray.
const RAY: f64 = 0.15;

/// Microseconds of formulas for each edge that separates visible from hidden, where row sums are wanted to less than
/// [`COARSE`], and to more: measured in rooms, which are computed so, and in towns.
const EDGE: [f64; 2] = [20.0, 50.0];
const COARSE: f64 = 1e-4;

/// The standard deviation of what a single ray says of a pair, before it is traced.
const DEVIATION: f64 = 0.4;

/// Row and column of a pair that is left to shadow rays.
pub(super) type UnresolvedPair = (usize, usize);

/// Number of pairs by the method that resolved them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PairCounts {
    /// Unoccluded, in unoccluded clusters.
    pub bulk: u64,
    /// Unoccluded, by Gauss's rule.
    pub single: u64,
    /// Unoccluded, by contours.
    pub close: u64,
    /// Partially occluded.
    pub partial: u64,
    /// Fully occluded.
    pub occluded: u64,
    /// Left to shadow rays.
    pub unresolved: u64,
}

impl PairCounts {
    /// The inverse of [`counts`](PairCounts::counts).
    pub fn of([bulk, single, close, partial, occluded, unresolved]: [u64; 6]) -> PairCounts {
        PairCounts {
            bulk,
            single,
            close,
            partial,
            occluded,
            unresolved,
        }
    }

    /// All counts, in a fixed order.
    pub fn counts(&self) -> [u64; 6] {
        [
            self.bulk,
            self.single,
            self.close,
            self.partial,
            self.occluded,
            self.unresolved,
        ]
    }

    pub fn add(&mut self, other: &PairCounts) {
        self.bulk += other.bulk;
        self.single += other.single;
        self.close += other.close;
        self.partial += other.partial;
        self.occluded += other.occluded;
        self.unresolved += other.unresolved;
    }
}

/// State of the traversal.
pub(super) struct PairTraversal<'a> {
    image: &'a MirrorImage,
    accuracy: PairAccuracy,
    rows: &'a FacetTree,
    columns: &'a FacetTree,
    requested: RequestedRows<'a>,
    nodes: Vec<RowNode>,
    obstructions: Vec<u32>,
    /// The edges that matter of the obstructions of the current pair.
    edges: Vec<u64>,
    partial: PartialVisibility,
    sums: Vec<f64>,
    pub counts: PairCounts,
    /// What was done.
    pub work: PairWork,
    /// Seconds of the pairs of each row so far.
    spent: Vec<f64>,
    /// Pairs left to shadow rays.
    pub unresolved: Vec<UnresolvedPair>,
}

impl<'a> PairTraversal<'a> {
    /// A traversal of all pairs of those of `rows`, as seen in `image`, that are `requested`, and
    /// `columns`.
    pub fn new(
        image: &'a MirrorImage,
        rows: &'a FacetTree,
        columns: &'a FacetTree,
        accuracy: PairAccuracy,
        requested: RequestedRows<'a>,
    ) -> PairTraversal<'a> {
        let mut traversal = PairTraversal {
            image,
            accuracy,
            rows,
            columns,
            requested,
            nodes: Vec::new(),
            obstructions: Vec::new(),
            edges: Vec::new(),
            partial: PartialVisibility::default(),
            sums: Vec::new(),
            counts: PairCounts::default(),
            work: PairWork::default(),
            spent: vec![0.0; rows.list.len()],
            unresolved: Vec::new(),
        };
        traversal.halve(0..rows.list.len());
        traversal
    }

    fn halve(&mut self, range: Range<usize>) {
        let facets = &self.rows.list[range.clone()];
        let node = self.nodes.len();
        self.nodes.push(RowNode {
            cluster: Cluster::new(facets),
            is_requested: self.requested.places[range.clone()]
                .iter()
                .any(Option::is_some),
            range: range.clone(),
            second: 0,
        });
        if range.len() > FEW_ROWS {
            let middle = range.start + range.len() / 2;
            self.halve(range.start..middle);
            self.nodes[node].second = self.nodes.len();
            self.halve(middle..range.end);
        }
    }

    /// All pairs of the requested rows with columns.
    pub fn run(&mut self, found: &mut ExchangeBlock) {
        let count = self.image.obstructions.len() + self.image.curved.len();
        self.obstructions.extend(0..count as u32);
        if !self.columns.tree.nodes.is_empty() {
            self.visit(0, 0, 0..count, found);
        }
        self.obstructions.clear();
    }

    fn visit(&mut self, r: usize, c: usize, obstructions: Range<usize>, block: &mut ExchangeBlock) {
        let image = self.image;
        let upper = self.requested.upper;
        let (row, column) = (&self.nodes[r], &self.columns.clusters[c]);
        let (row_range, second_row) = (row.range.clone(), row.second);
        self.work.count(WorkKind::Visit, 1);
        let node = &self.columns.tree.nodes[c];
        // Leave clusters without any pair to compute: not requested, given up, empty, or below the diagonal.
        let goes_on = |row: usize| !self.is_given_up(row);
        if !row.is_requested
            || !row_range.clone().any(goes_on)
            || row.cluster.is_empty()
            || column.is_empty()
            || upper && column.last_id < row.cluster.first_id
        {
            return;
        }
        // Where no horizon cuts the clusters, only columns that are not rows need the parts above it.
        let is_split = match self.requested.split {
            None => false,
            Some(split) => {
                let is_clear = split.is_clear(&row.cluster.bounds, &column.bounds, image.graze);
                let is_left_out = match split.pairs {
                    SplitPairs::Cut => is_clear,
                    SplitPairs::Hidden => true,
                    SplitPairs::All => false,
                };
                if is_left_out && column.last_id < split.rows {
                    return;
                }
                !is_clear
            }
        };
        let facing = match (
            row.cluster.facing(&column.bounds, image.graze),
            column.facing(&row.cluster.bounds, image.graze),
        ) {
            (Facing::Away, _) | (_, Facing::Away) => return,
            (Facing::Towards, Facing::Towards) => Facing::Towards,
            _ => Facing::Mixed,
        };
        // Keep the obstructions that may block part of the shaft between the clusters; stop if nothing passes it.
        let top = self.obstructions.len();
        if !obstructions.is_empty() {
            self.work.count(WorkKind::Shaft, obstructions.len());
            let shaft = ClusterShaft::new(&row.cluster.bounds, &column.bounds, image.graze);
            if !self.cull(&shaft, obstructions) {
                self.obstructions.truncate(top);
                self.counts.occluded += (row_range.len() * node.range.len()) as u64;
                return;
            }
        }
        let kept = top..self.obstructions.len();
        let (is_row_leaf, is_leaf) = (second_row == 0, node.is_leaf());
        // Nothing is between clusters that face each other: Gauss's rule takes all pairs together if it suffices.
        let is_done = !is_split
            && kept.is_empty()
            && facing == Facing::Towards
            && self.clear(&row_range, r, c, block);
        if is_done {
        } else if is_row_leaf && is_leaf {
            for row in row_range {
                for column in node.range.start as usize..node.range.end as usize {
                    let before = self.work;
                    self.pair(row, column, kept.clone(), block);
                    self.spent[row] += self.work.seconds() - before.seconds();
                }
            }
        } else {
            // Halve the larger cluster, or whichever is not a leaf, so that shafts get narrower.
            let size = |b: &Aabb| b.size().length_squared();
            let halves_row = !is_row_leaf
                && (is_leaf || size(&self.nodes[r].cluster.bounds) > size(&column.bounds));
            if halves_row {
                self.visit(r + 1, c, kept.clone(), block);
                self.visit(second_row, c, kept, block);
            } else {
                self.visit(r, c + 1, kept.clone(), block);
                self.visit(r, node.second as usize, kept, block);
            }
        }
        self.obstructions.truncate(top);
    }

    /// Pushes the obstructions that matter in a shaft; false if it is fully blocked.
    fn cull(&mut self, shaft: &ClusterShaft, obstructions: Range<usize>) -> bool {
        for k in obstructions {
            let index = self.obstructions[k] as usize;
            let is_window = index < self.image.windows;
            match self.image.obstructions.get(index) {
                Some(obstruction) => match (shaft.effect(obstruction), is_window) {
                    (Effect::None, true) | (Effect::Hides, false) => return false,
                    (Effect::None, false) | (Effect::Hides, true) => {}
                    (Effect::Partial(_), _) => self.obstructions.push(index as u32),
                },
                None => {
                    if shaft.meets(&self.image.curved[index - self.image.obstructions.len()]) {
                        self.obstructions.push(index as u32);
                    }
                }
            }
        }
        true
    }

    /// Seconds of the pairs of all rows.
    pub fn pair_seconds(&self) -> f64 {
        self.spent.iter().sum()
    }

    /// Whether a row took more than its budget.
    pub fn is_given_up(&self, row: usize) -> bool {
        self.spent[row] > self.requested.budget
    }

    /// Pairs of unoccluded clusters, if Gauss's rule is accurate enough for all.
    fn clear(
        &mut self,
        rows: &Range<usize>,
        r: usize,
        c: usize,
        block: &mut ExchangeBlock,
    ) -> bool {
        let image = self.image;
        let (row, column) = (&self.nodes[r].cluster, &self.columns.clusters[c]);
        if !(row.is_plain && column.is_plain) {
            return false;
        }
        // Take four points on each facet if sizes over distance are small enough, or nine, but these only in leaves.
        let ratio = (row.most_radius + column.most_radius) / gap(&row.bounds, &column.bounds);
        let is_leaf = self.columns.tree.nodes[c].is_leaf();
        let error = if FOUR * ratio.powi(4) < self.accuracy.whole {
            FOUR * ratio.powi(4)
        } else if is_leaf && NINE * ratio.powi(6) < self.accuracy.whole {
            NINE * ratio.powi(6)
        } else {
            return false;
        };
        let is_four = FOUR * ratio.powi(4) < self.accuracy.whole;
        let columns = {
            let range = &self.columns.tree.nodes[c].range;
            range.start as usize..range.end as usize
        };
        let values = rows.len() * columns.len() * if is_four { 16 } else { 81 };
        self.work.count(WorkKind::Kernel, values);
        self.sums.resize(columns.len(), 0.0);
        // Compute a row with all columns of the cluster at once; those that do not count are left out after that.
        for row in rows.clone() {
            let own = &self.rows.list[row];
            let Some(place) = self.requested.places[row].filter(|_| !own.is_empty()) else {
                continue;
            };
            if is_four {
                let points = self.rows.four.own(row);
                self.columns
                    .four
                    .exchange(&points, columns.clone(), &mut self.sums);
            } else {
                let points = self.rows.nine.own(row);
                self.columns
                    .nine
                    .exchange(&points, columns.clone(), &mut self.sums);
            }
            for (k, &value) in columns.clone().zip(&self.sums) {
                let facet = &self.columns.list[k];
                let is_lit = !facet.is_empty() && !image.is_behind(k);
                if (!self.requested.upper || facet.id >= own.id) && is_lit {
                    let value = image.weight * value.max(0.0);
                    block.add(place, k, value, error * value);
                    // No horizon cuts these pairs: all of their light leaves upwards, or none.
                    if let Some(split) = self.requested.split
                        && facet.id >= split.rows
                        && split.elevation(own, facet, image.graze) == Elevation::Above
                    {
                        block.upward[place * block.columns + k] += value;
                    }
                }
            }
        }
        self.counts.bulk += (rows.len() * columns.len()) as u64;
        true
    }

    fn pair(
        &mut self,
        row: usize,
        column: usize,
        obstructions: Range<usize>,
        block: &mut ExchangeBlock,
    ) {
        let image = self.image;
        let (a, b) = (&self.rows.list[row], &self.columns.list[column]);
        let Some(place) = self.requested.places[row] else {
            return;
        };
        let is_lower = self.requested.upper && b.id < a.id;
        if a.is_empty() || b.is_empty() || is_lower || self.is_given_up(row) {
            return;
        }
        if image.is_behind(column) {
            return;
        }
        self.work.count(WorkKind::Visit, 1);
        let split = self.requested.split;
        let elevation = split.map(|split| split.elevation(a, b, image.graze));
        let is_row = split.is_none_or(|split| b.id < split.rows);
        let takes_all = split.is_none_or(|split| split.pairs == SplitPairs::All);
        let is_cut = elevation == Some(Elevation::Mixed);
        if is_row && !takes_all && !(is_cut && split.is_some_and(|s| s.pairs == SplitPairs::Cut)) {
            return;
        }
        let Some(is_whole) = facing(a, b, image.graze) else {
            return;
        };
        // What a facet's plane cuts off is not seen, and need not be behind anything.
        let seen_parts = if is_whole {
            None
        } else {
            let parts = (a.in_front_of(b, image.graze), b.in_front_of(a, image.graze));
            let (Some(a), Some(b)) = parts else {
                return;
            };
            Some([a, b])
        };
        let error = split.map_or(self.accuracy.partial, |split| split.error);
        let goal = PairGoal {
            up: None,
            error: error * a.area.min(b.area),
            whole: self.accuracy.whole,
            graze: image.graze,
        };
        let parts = seen_parts.as_ref().map_or([a, b], |[a, b]| [a, b]);
        let top = self.obstructions.len();
        let is_seen = self.cull_for_pair(parts[0], parts[1], obstructions);
        let kept = top..self.obstructions.len();
        if !is_seen {
            self.counts.occluded += 1;
        } else if self.is_too_complex(&kept) || self.is_for_rays(parts, &kept) {
            self.unresolved.push((row, column));
            let rays = self.shadow_rays(parts).unwrap_or(MOST_RAYS);
            self.work.count(WorkKind::Ray, rays as usize);
            self.counts.unresolved += 1;
        } else {
            let takes_whole = takes_all || !is_row;
            let whole = match (takes_whole, kept.is_empty()) {
                (false, _) => Approximate::default(),
                (true, true) => self.whole(row, column, is_whole),
                (true, false) => self.partly_seen(parts, kept.clone(), goal),
            };
            let Approximate { value, error } = whole;
            block.add(place, column, image.weight * value, image.weight * error);
            if let Some(split) = split {
                let upward = match elevation {
                    Some(Elevation::Above) => Approximate { value, error: 0.0 },
                    Some(Elevation::Mixed) => {
                        let up = Some(split.up);
                        self.partly_seen(parts, kept, PairGoal { up, ..goal })
                    }
                    _ => Approximate::default(),
                };
                let cuts = split.cuts(a, b, image.graze);
                block.add_split([place, column], split.pairs, value, upward, cuts);
            }
        }
        self.obstructions.truncate(top);
    }

    /// Whether a pair with these obstructions is left to shadow rays.
    fn is_too_complex(&self, kept: &Range<usize>) -> bool {
        let image = self.image;
        kept.len() > MOST_OBSTRUCTIONS && image.order == 0
            || self.obstructions[kept.clone()]
                .iter()
                .any(|&s| s as usize >= image.obstructions.len())
    }

    /// Whether shadow rays are expected to be sooner behind these obstructions than formulas.
    fn is_for_rays(&self, pair: [&Facet; 2], kept: &Range<usize>) -> bool {
        let can_be = self.image.order == 0 && !self.accuracy.is_exact;
        let edges = self.edges[..kept.len()].iter();
        let edges: u32 = edges.map(|edges| edges.count_ones()).sum();
        let edge = if self.accuracy.row < COARSE {
            EDGE[0]
        } else {
            EDGE[1]
        };
        let is_sooner = |rays| rays * RAY < f64::from(edges) * edge;
        can_be && self.shadow_rays(pair).is_some_and(is_sooner)
    }

    /// How many shadow rays a pair takes, about; `None` if these are too many.
    fn shadow_rays(&self, [a, b]: [&Facet; 2]) -> Option<f64> {
        let most = a.area.min(b.area);
        let whole = rough(a, b);
        rays_for(DEVIATION, self.accuracy.row * (most / whole).sqrt())
    }

    /// A pair behind obstructions, or the part of it above the horizon.
    fn partly_seen(
        &mut self,
        [a, b]: [&Facet; 2],
        kept: Range<usize>,
        goal: PairGoal,
    ) -> Approximate {
        let image = self.image;
        self.counts.partial += 1;
        let windows = image.windows;
        let obstructions = self.obstructions[kept].iter().zip(&self.edges);
        let obstructions = obstructions.map(|(&s, &edges)| {
            (
                &image.obstructions[s as usize],
                edges,
                (s as usize) < windows,
            )
        });
        if !self.accuracy.is_exact || goal.up.is_some() {
            let seen = self.partial.exchange([a, b], obstructions, goal);
            self.work.add(&std::mem::take(&mut self.partial.work));
            return seen;
        }
        match image.lit_parts(a, b) {
            Some([a, b]) => {
                let obstructions =
                    obstructions.map(|(obstruction, _, is_window)| (obstruction, is_window));
                let (seen, views) = exchange_area_past(&a, &b, obstructions, goal.error);
                self.work.count(WorkKind::ExactView, views);
                seen
            }
            None => Approximate::default(),
        }
    }

    /// As [`cull`](PairTraversal::cull), for one pair; records which edges matter.
    fn cull_for_pair(&mut self, a: &Facet, b: &Facet, obstructions: Range<usize>) -> bool {
        self.work.count(WorkKind::Effect, obstructions.len());
        self.edges.clear();
        for k in obstructions {
            let index = self.obstructions[k] as usize;
            let Some(obstruction) = self.image.obstructions.get(index) else {
                self.obstructions.push(index as u32);
                self.edges.push(0);
                continue;
            };
            let effect = obstruction.effect(a.polygon(), b.polygon(), self.image.graze);
            match (effect, index < self.image.windows) {
                (Effect::None, true) | (Effect::Hides, false) => return false,
                (Effect::None, false) | (Effect::Hides, true) => {}
                (Effect::Partial(edges), _) => {
                    self.obstructions.push(index as u32);
                    self.edges.push(edges);
                }
            }
        }
        true
    }

    /// An unoccluded pair.
    fn whole(&mut self, row: usize, column: usize, is_whole: bool) -> Approximate {
        let (rows, columns) = (self.rows, self.columns);
        let (a, b) = (&rows.list[row], &columns.list[column]);
        let ratio = (a.radius + b.radius) / a.centre.distance(b.centre);
        let (four, nine) = (FOUR * ratio.powi(4), NINE * ratio.powi(6));
        let is_plain = is_whole && a.count <= 4 && b.count <= 4;
        let mut value = [0.0];
        if is_plain && four < self.accuracy.whole {
            self.counts.single += 1;
            self.work.count(WorkKind::Kernel, 16);
            columns
                .four
                .exchange(&rows.four.own(row), column..column + 1, &mut value);
            Approximate {
                value: value[0],
                error: four * value[0],
            }
        } else if is_plain && nine < self.accuracy.whole {
            self.counts.single += 1;
            self.work.count(WorkKind::Kernel, 81);
            columns
                .nine
                .exchange(&rows.nine.own(row), column..column + 1, &mut value);
            Approximate {
                value: value[0],
                error: nine * value[0],
            }
        } else {
            self.counts.close += 1;
            self.work.count(WorkKind::Contour, 1);
            let value = if self.accuracy.is_exact {
                exchange_area(a.polygon(), b.polygon())
            } else {
                exchange_area_fast(a.polygon(), b.polygon(), self.accuracy.whole)
            };
            Approximate {
                value,
                error: self.accuracy.whole * value,
            }
        }
    }
}

/// Whether both facets are fully in front of each other; `None` if they face away.
fn facing(a: &Facet, b: &Facet, graze: f64) -> Option<bool> {
    let range = |of: &Facet, points: &[DVec3]| {
        points
            .iter()
            .map(|&p| of.height(p))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| {
                (low.min(h), high.max(h))
            })
    };
    let (first, second) = (range(a, b.polygon()), range(b, a.polygon()));
    (first.1 > graze && second.1 > graze).then_some(first.0 >= -graze && second.0 >= -graze)
}

/// Distance between two boxes.
fn gap(a: &Aabb, b: &Aabb) -> f64 {
    (a.min - b.max).max(b.min - a.max).max(DVec3::ZERO).length()
}
