//! Passes over the points of a gather: in groups that are gathered alike, in loops that processes share, until an error
//! or a deadline is reached.

use crate::deadline::{GatherPace, hasty_rays, planned_seconds};
use crate::gathered_values::PointKind;
use crate::gathering::{
    CHUNK, FEWEST_RAYS, FIRST_RAYS, GatherEffort, GatherError, Gathering, MOST_RAYS, Paths,
};
use azulejo_scene::Rgb;
use azulejo_trace::run::{LoopSize, Record, RecordReader, write_list};
use azulejo_trace::sampling::hash;
use azulejo_trace::time::Instant;
use azulejo_trace::{
    Cancelled, DiffuseLight, DirectionTables, GatherOptions, GatherPoint, Gathered, Gatherer,
    Measure, REPLICATES, Run, RunStage, SplitIrradiance, Termination,
};
use rayon::prelude::*;
use std::ops::Range;

/// Points whose time is measured before a first pass that has a deadline.
const PACE_POINTS: u32 = 64;

/// How many more rays than are permitted a goal may take before it is said to be out of reach.
const TOLERATED: f64 = 0.1;

/// Largest growth of a point's total per pass: early variances are too uncertain to be trusted
/// further.
const GROWTH: f64 = 8.0;

/// The light that a gather finds at diffuse surfaces.
pub struct GatherLight<'a, L> {
    /// The light on patches.
    pub patches: &'a L,
    /// Where bounces are limited, black light for the paths, and the number of bounces: patches do
    /// not tell how often their light was reflected.
    pub limited: Option<(&'a L, u32)>,
}

impl<L> Clone for GatherLight<'_, L> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<L> Copy for GatherLight<'_, L> {}

impl<'a, L> GatherLight<'a, L> {
    /// Light on patches, and black light with the most bounces that paths may have.
    pub fn new(patches: &'a L, limited: Option<&'a (L, u32)>) -> GatherLight<'a, L> {
        GatherLight {
            patches,
            limited: limited.map(|(black, bounces)| (black, *bounces)),
        }
    }

    /// What paths with this end read, and how they end.
    pub(crate) fn ending(&self, termination: Termination) -> (&'a L, Termination) {
        match (termination, self.limited) {
            (Termination::Roulette, Some((black, bounces))) => {
                (black, Termination::Bounces(bounces))
            }
            _ => (self.patches, termination),
        }
    }
}

/// The constants of all passes.
#[derive(Clone, Copy)]
pub(crate) struct GatherPass<'a, L> {
    pub gatherer: &'a Gatherer<'a>,
    pub light: GatherLight<'a, L>,
    pub points: &'a [GatherPoint],
    pub pace: &'a GatherPace,
    pub seed: u32,
    pub run: Run<'a>,
}

/// A group of points that are gathered alike: from this many rays, to this many, ending so, and whether
/// their indirect light is gathered at all.
type Way = (u32, u32, Termination, PointKind);

impl<L: DiffuseLight> GatherPass<'_, L> {
    /// Rays of the first pass before a deadline, from the pace of a keyed sample; `None` if there is no
    /// time for all points.
    fn hasty(&self, all: &Gathering) -> Result<Option<u32>, GatherError> {
        let count = self.points.len() as u32;
        let key = |k: u32| hash(&[self.seed, k, 0x9ace]) % count.max(1);
        let sample: Vec<u32> = (0..count.min(PACE_POINTS)).map(key).collect();
        let termination = all.strata.termination(0);
        self.gather_at(&sample, 0..FEWEST_RAYS, termination)?;
        let seconds = self.pace.seconds_per_ray(termination);
        Ok(hasty_rays(self.points.len(), seconds, self.run.progress))
    }

    /// Says early if the goal will not be reached, and what it would take.
    fn forecast(&self, all: &Gathering, goal: f64, most: u32) {
        let sum = |rays: &[u32]| rays.iter().map(|&n| f64::from(n)).sum::<f64>();
        let [free, capped] =
            [u32::MAX, most].map(|most| sum(&all.allocate(goal, f64::INFINITY, most)));
        let seconds = all.seconds_needed(goal, self.pace);
        let left = self.run.progress.time_left();
        let is_late = left.is_some_and(|left| seconds > left.as_secs_f64());
        if is_late || free > (1.0 + TOLERATED) * capped {
            self.run.progress.measured(Measure::OutOfReach {
                error: goal,
                seconds,
                rays: free / self.points.len().max(1) as f64,
            });
        }
    }

    /// Seconds in which all points get this many rays.
    fn seconds_to_all(&self, all: &Gathering, most: u32) -> f64 {
        let seconds = |k: usize| {
            let whole = all.strata.points(k).len() as f64 * f64::from(most);
            let pace = self.pace.seconds_per_ray(all.strata.termination(k));
            (whole - all.spent_on(k)).max(0.0) * pace
        };
        (0..all.strata.count()).map(seconds).sum()
    }

    /// Gathers from nothing until `effort` is reached or the progress is out of time; passes
    /// intermediate results to `watch` after each pass but the last.
    pub fn reach(
        &self,
        all: &mut Gathering,
        effort: GatherEffort,
        watch: &mut dyn FnMut(&Gathering),
    ) -> Result<(), GatherError> {
        let most = effort.most();
        if effort.paths == Paths::Always {
            all.strata.trace_paths(0);
        }
        if effort.is_each {
            all.strata.ask_each();
        }
        let rays = match effort.error {
            _ if self.run.progress.has_deadline() => match self.hasty(all)? {
                Some(rays) => rays.min(most),
                None => return self.reach_coarsely(all, effort.error, most),
            },
            Some(_) => FIRST_RAYS.min(most),
            None => most,
        };
        self.begin(all, rays)?;
        if all.spent.contains(&0) {
            return Err(GatherError::OutOfTime);
        }
        all.strata.divide(&all.gathered);
        if effort.paths == Paths::Measured {
            self.validate(all, effort.error, most)?;
        }
        if let Some(goal) = effort.error {
            self.forecast(all, goal, most);
        }
        self.spend(all, effort, watch)
    }

    /// Spends rays where they reduce the error most until `effort` is reached or the phase is over.
    pub fn spend(
        &self,
        all: &mut Gathering,
        effort: GatherEffort,
        watch: &mut dyn FnMut(&Gathering),
    ) -> Result<(), GatherError> {
        let most = effort.most();
        loop {
            self.run
                .progress
                .measured(Measure::Error(all.relative_error()));
            if let Some(goal) = effort.error {
                all.rays_needed = all.needed(goal);
            }
            let seconds = planned_seconds(self.run.progress);
            let totals = match effort.error {
                None if self.seconds_to_all(all, most) <= seconds => vec![most; all.spent.len()],
                Some(goal) if seconds.is_infinite() => all.allocate(goal, GROWTH, most),
                goal => {
                    let goal = goal.unwrap_or(0.0);
                    let allowed = all.noise_within_reach(goal, seconds, self.pace);
                    all.allocate_to(&allowed, GROWTH, most)
                }
            };
            if self.run.progress.phase_is_over() || totals == all.spent {
                return Ok(());
            }
            watch(all);
            self.raise(all, &totals)?;
        }
    }

    /// Gathers with so many rays at all points, which have none yet, in blocks that are stored and
    /// divided. What there is time for before a deadline is not kept.
    fn begin(&self, all: &mut Gathering, rays: u32) -> Result<(), GatherError> {
        let is_divided = self.run.role().is_kept && !self.run.is_shared();
        if self.run.progress.has_deadline() || !is_divided {
            return Ok(self.raise(all, &vec![rays; self.points.len()])?);
        }
        let termination = all.strata.termination(0);
        let count = self.points.len();
        let size = LoopSize {
            items: count.div_ceil(CHUNK),
            block: block_chunks(rays),
            at_once: block_chunks(rays),
        };
        let own = self.run.own_items(size.items);
        self.run.progress.begin("irradiance", (own * CHUNK) as u64);
        let chunks = self.run.resumed(RunStage::Points, size, |chunks| {
            let of = |&chunk: &usize| (chunk * CHUNK) as u32..count.min((chunk + 1) * CHUNK) as u32;
            let chosen: Vec<u32> = chunks.iter().flat_map(of).collect();
            let irradiance = self.gather_at(&chosen, 0..rays, termination)?;
            Ok(irradiance
                .chunks(CHUNK)
                .map(|c| PointChunk(c.to_vec()))
                .collect())
        })?;
        let chunks = chunks.ok_or(GatherError::Elsewhere)?;
        let irradiance = chunks.iter().flat_map(|chunk| &chunk.0);
        for (i, new) in irradiance.flatten().enumerate() {
            all.values.add(i, new, 1.0);
            all.spent[i] = rays;
        }
        all.combine();
        Ok(())
    }

    /// Raises every point to its total, in groups with the same start and total; points keep what
    /// they have when time runs out.
    pub fn raise(&self, all: &mut Gathering, totals: &[u32]) -> Result<(), Cancelled> {
        let way = |i: usize| -> Way {
            let termination = all.strata.termination_of(i);
            (all.spent[i], totals[i], termination, all.values.kind(i))
        };
        let groups: Vec<Way> = (0..totals.len()).map(way).collect();
        let mut ways: Vec<Way> = groups.iter().copied().filter(|w| w.1 > w.0).collect();
        self.run.progress.begin("irradiance", ways.len() as u64);
        ways.sort_unstable();
        ways.dedup();
        let chosen = |way: &Way| -> Vec<u32> {
            let points = 0..groups.len() as u32;
            points.filter(|&i| groups[i as usize] == *way).collect()
        };
        let of_ways: Vec<Vec<u32>> = ways.iter().map(chosen).collect();
        for batch in batches(&ways, self.run.progress.has_deadline()) {
            let (ways, of_ways) = (&ways[batch.clone()], &of_ways[batch]);
            let pairs = ways.iter().zip(of_ways);
            let together: Vec<PointGroup> = pairs
                .map(|(way, chosen)| self.group_of(way, chosen))
                .collect();
            let light = self.gather_groups(&together)?;
            for ((&(spent, total, ..), chosen), light) in ways.iter().zip(of_ways).zip(light) {
                for (&i, new) in chosen.iter().zip(light) {
                    if let Some(new) = new {
                        let share = f64::from(total - spent) / f64::from(total);
                        all.values.add(i as usize, &new, share);
                        all.spent[i as usize] = total;
                    }
                }
            }
        }
        all.combine();
        Ok(())
    }

    /// Gathers once at the chosen points with a range of their rays; `None` where time ran out.
    pub fn gather_at(
        &self,
        chosen: &[u32],
        rays: Range<u32>,
        termination: Termination,
    ) -> Result<Vec<Option<SplitIrradiance>>, Cancelled> {
        self.gather_group(self.irradiance_group(chosen, rays, termination))
    }

    /// Whether there is no time for rays from this one on: the first of a point have some grace.
    fn is_over(&self, first_ray: u32) -> bool {
        match first_ray {
            0 => self.run.progress.is_overdue(),
            _ => self.run.progress.phase_is_over(),
        }
    }

    /// Gathers once at each list of points with its range of their rays, in one loop that processes share; `None` where
    /// time ran out, if that is minded.
    pub fn gather_lists(
        &self,
        lists: &[PointList],
        minds_time: bool,
    ) -> Result<Vec<Vec<Option<SplitIrradiance>>>, Cancelled> {
        let groups = lists.iter().map(|list| {
            let (points, rays) = (&list.points, list.rays.clone());
            let group = if list.has_direct {
                self.irradiance_group(points, rays, list.termination)
            } else {
                self.indirect_group(points, rays, list.termination)
            };
            PointGroup {
                minds_time,
                ..group
            }
        });
        self.gather_groups(&groups.collect::<Vec<_>>())
    }

    /// Points that go the same way.
    fn group_of<'g>(&'g self, way: &Way, chosen: &'g [u32]) -> PointGroup<'g> {
        let &(spent, total, termination, kind) = way;
        match kind {
            PointKind::Record => self.irradiance_group(chosen, spent..total, termination),
            PointKind::Interpolated => self.direct_group(chosen, spent..total),
        }
    }

    /// Points whose irradiance is gathered with a range of their rays.
    fn irradiance_group<'g>(
        &'g self,
        chosen: &'g [u32],
        rays: Range<u32>,
        termination: Termination,
    ) -> PointGroup<'g> {
        let (light, ending) = self.light.ending(termination);
        let options = self.options(&rays, ending);
        let directions = DirectionTables::new(&options);
        PointGroup {
            chosen,
            rays,
            minds_time: true,
            gather: Box::new(move |points| {
                let start = Instant::now();
                let irradiance = self
                    .gatherer
                    .gather_with(points, &options, &directions, light);
                let rays = points.len() as u64 * u64::from(options.rays);
                self.pace.add(termination, rays, start.elapsed());
                irradiance
            }),
        }
    }

    /// Points whose indirect light alone is gathered.
    fn indirect_group<'g>(
        &'g self,
        chosen: &'g [u32],
        rays: Range<u32>,
        termination: Termination,
    ) -> PointGroup<'g> {
        let (light, ending) = self.light.ending(termination);
        let options = self.options(&rays, ending);
        let directions = DirectionTables::new(&options);
        let split = |indirect| SplitIrradiance {
            direct: Gathered::default(),
            indirect,
        };
        PointGroup {
            chosen,
            rays,
            minds_time: true,
            gather: Box::new(move |points| {
                let gatherer = self.gatherer;
                let indirect = gatherer.gather_indirect(points, &options, &directions, light);
                indirect.into_iter().map(split).collect()
            }),
        }
    }

    /// Points at which direct light alone is gathered.
    fn direct_group<'g>(&'g self, chosen: &'g [u32], rays: Range<u32>) -> PointGroup<'g> {
        let options = self.options(&rays, Termination::Radiosity);
        let split = |direct| SplitIrradiance {
            direct,
            indirect: Gathered::default(),
        };
        PointGroup {
            chosen,
            rays,
            minds_time: true,
            gather: Box::new(move |points| {
                let direct = self.gatherer.gather_direct(points, &options);
                direct.into_iter().map(split).collect()
            }),
        }
    }

    fn options(&self, rays: &Range<u32>, termination: Termination) -> GatherOptions {
        GatherOptions {
            rays: rays.end - rays.start,
            spent: rays.start,
            seed: self.seed,
            termination,
        }
    }

    fn gather_group(&self, group: PointGroup) -> Result<Vec<Option<SplitIrradiance>>, Cancelled> {
        let irradiance = self.gather_groups(&[group])?;
        Ok(irradiance.into_iter().flatten().collect())
    }

    /// Gathers at the points of all groups, in one loop that processes share; `None` where time ran out.
    fn gather_groups(
        &self,
        groups: &[PointGroup],
    ) -> Result<Vec<Vec<Option<SplitIrradiance>>>, Cancelled> {
        let of_group = |(number, group): (usize, &PointGroup)| {
            let size = CHUNK * step_chunks(group.rays.len() as u32);
            let starts = (0..group.chosen.len()).step_by(size);
            let end = |start: usize| (start + size).min(group.chosen.len());
            starts
                .map(move |start| (number, start..end(start)))
                .collect::<Vec<_>>()
        };
        let pieces: Vec<(usize, Range<usize>)> =
            groups.iter().enumerate().flat_map(of_group).collect();
        let of_chunk = |group: &PointGroup, chunk: &[u32]| {
            self.run.progress.advance(chunk.len() as u64)?;
            if group.minds_time && self.is_over(group.rays.start) {
                return Ok(vec![None; chunk.len()]);
            }
            let points: Vec<GatherPoint> = chunk.iter().map(|&i| self.points[i as usize]).collect();
            Ok((group.gather)(&points).into_iter().map(Some).collect())
        };
        let of_piece = |&piece: &usize| {
            let (number, range) = &pieces[piece];
            let group = &groups[*number];
            let chunks = group.chosen[range.clone()].par_chunks(CHUNK);
            let irradiance: Result<Vec<Vec<_>>, Cancelled> =
                chunks.map(|chunk| of_chunk(group, chunk)).collect();
            Ok(PointChunk(irradiance?.concat()))
        };
        let irradiance = self.run.shared((pieces.len(), 1), |indices| {
            indices.par_iter().map(of_piece).collect()
        })?;
        let mut of_groups: Vec<Vec<Option<SplitIrradiance>>> = vec![Vec::new(); groups.len()];
        for ((number, _), piece) in pieces.iter().zip(irradiance) {
            of_groups[*number].extend(piece.0);
        }
        Ok(of_groups)
    }
}

/// Ways that are gathered in one loop, so that processes that share the work meet once: as many as leave the tables
/// of directions small; before a deadline one after the other, those of fewest rays first.
fn batches(ways: &[Way], has_deadline: bool) -> Vec<Range<usize>> {
    let mut batches: Vec<Range<usize>> = Vec::new();
    let mut rays = 0;
    for (number, &(spent, total, ..)) in ways.iter().enumerate() {
        rays += total - spent;
        match batches.last_mut() {
            Some(batch) if rays <= MOST_RAYS && !has_deadline => batch.end = number + 1,
            _ => {
                rays = total - spent;
                batches.push(number..number + 1);
            }
        }
    }
    batches
}

/// Points that are gathered alike, all of them.
pub struct PointList {
    /// Their numbers.
    pub points: Vec<u32>,
    /// Which rays of each.
    pub rays: Range<u32>,
    /// How their paths end.
    pub termination: Termination,
    /// Whether direct light is gathered, too.
    pub has_direct: bool,
}

/// The light at points that are gathered together.
type BatchGather<'g> = dyn Fn(&[GatherPoint]) -> Vec<SplitIrradiance> + Sync + 'g;

/// Points that are gathered alike.
struct PointGroup<'g> {
    /// Their numbers.
    chosen: &'g [u32],
    /// Which rays of each.
    rays: Range<u32>,
    /// Whether points are left out once time is over.
    minds_time: bool,
    /// The light of some of them.
    gather: Box<BatchGather<'g>>,
}

/// Rays of a block that is stored, about, and fewest and most of its chunks.
const BLOCK_RAYS: usize = 1 << 20;
const BLOCK: [usize; 2] = [32, 4096];

/// Chunks of a block that is stored.
fn block_chunks(rays: u32) -> usize {
    (BLOCK_RAYS / (CHUNK * rays.max(1) as usize)).clamp(BLOCK[0], BLOCK[1])
}

/// Rays of a block that processes share, about: some milliseconds of one thread; and most of its chunks.
const STEP_RAYS: usize = 1 << 15;
const STEP: usize = 512;

/// Chunks of a block that processes share.
fn step_chunks(rays: u32) -> usize {
    (STEP_RAYS / (CHUNK * rays.max(1) as usize)).clamp(1, STEP)
}

/// Points that were gathered together; `None` where time ran out.
struct PointChunk(Vec<Option<SplitIrradiance>>);

impl Record for PointChunk {
    fn write(&self, bytes: &mut Vec<u8>) {
        write_list(&self.0, bytes, |point, bytes| {
            let both = point.map(|p| [p.direct.replicates, p.indirect.replicates]);
            both.write(bytes);
        });
    }

    fn read(bytes: &mut RecordReader) -> Option<PointChunk> {
        let points = bytes.list(Option::<[[Rgb; REPLICATES]; 2]>::read)?;
        let split = |[direct, indirect]: [[Rgb; REPLICATES]; 2]| {
            let [direct, indirect] = [direct, indirect].map(|replicates| Gathered { replicates });
            SplitIrradiance { direct, indirect }
        };
        let points = points.into_iter().map(|point| point.map(split));
        Some(PointChunk(points.collect()))
    }

    fn is_complete(&self) -> bool {
        self.0.iter().all(Option::is_some)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_are_gathered_together_while_their_tables_are_small() {
        let way =
            |(spent, total): (u32, u32)| (spent, total, Termination::Radiosity, PointKind::Record);
        let of = |rays: &[(u32, u32)], has_deadline: bool| -> Vec<(usize, usize)> {
            let ways: Vec<Way> = rays.iter().copied().map(way).collect();
            let spans = batches(&ways, has_deadline);
            spans.iter().map(|batch| (batch.start, batch.end)).collect()
        };
        assert_eq!(of(&[], false), []);
        assert_eq!(of(&[(0, 128), (0, 256), (128, 512)], false), [(0, 3)]);
        assert_eq!(of(&[(0, 128), (0, 256)], true), [(0, 1), (1, 2)]);
        let most = MOST_RAYS;
        let rays = [(0, 1), (0, most), (0, most - 1), (5, 6)];
        assert_eq!(of(&rays, false), [(0, 1), (1, 2), (2, 4)]);
    }
}
