//! The matrix by the analytic engine, with rays for what has no formula.

use super::doubt::RowCheck;
use super::forecast::Costs;
use super::matrix::RowRemainder;
use super::rows::RowTracing;
use super::{FormFactors, PreparedPlan, merge};
use crate::analytic_engine::exchanger::{AllPairs, Exchanger, ExchangerOptions};
use crate::engine::{Engine, EngineUsed};
use crate::error::FactorsError;
use crate::estimator::Estimator;
use crate::exchange_areas::{Exchange, ExchangeAreas};
use crate::row::{Columns, ORDERS, Order, Side};
use azulejo_trace::Progress;
use azulejo_trace::Run;
use azulejo_trace::sampling::hash;

impl PreparedPlan<'_> {
    /// All rows by formulas. Rays take the rest: curved patches; mirrors and glass without images;
    /// rows that time ran out for; and in open scenes with mirrors the directions, but not the
    /// amount, of light that leaves.
    pub(super) fn by_formulas(&self, run: Run) -> Result<FormFactors, FactorsError> {
        let (n, options) = (self.sides.len(), self.plan.options);
        self.refuse_too_large(run)?;
        let list: Vec<Side> = (0..n).map(|row| self.sides.side(row)).collect();
        // Only one process knows of all rows which are given up.
        let is_alone = run.role().parts == 1 && !run.is_shared();
        let row_budget = if is_alone {
            self.row_budget
        } else {
            f64::INFINITY
        };
        let exchanger = self.exchanger(list, row_budget);
        let all = exchanger.all(run)?;
        let all = match all {
            Some(all) => Some(self.checked(all, &exchanger, is_alone, run.progress)?),
            // Others have the rows that are not here.
            None => None,
        };
        let is_done = |row: usize| all.as_ref().is_none_or(|all| all.is_done[row]);
        let is_doubtful = |row: usize| all.as_ref().is_some_and(|all| all.is_doubtful[row]);
        let has_formula: Vec<bool> = (0..n).map(|i| exchanger.has(i)).collect();
        let is_known = |i: usize, j: u32, order: Order| {
            let j = j as usize;
            exchanger.known[usize::from(order)]
                && (has_formula[i] && has_formula[j])
                && is_done(i.min(j))
                && !is_doubtful(i)
                && !is_doubtful(j)
        };
        let is_complete = exchanger.is_complete() && (0..n).all(|i| is_done(i) && !is_doubtful(i));
        let patches = &self.plan.patches;
        let materials = patches.materials_in_use(&self.plan.proxy.scene);
        if is_complete && !materials.iter().any(|m| m.is_specular()) {
            let all = all.ok_or(FactorsError::Elsewhere)?;
            let engine_used = EngineUsed {
                name: "analytic".to_owned(),
                device: self.gatherer.surfaces().tracer.kernel_name(),
                notes: notes(&all, &exchanger, is_complete, 0),
            };
            let by_rays = FormFactors {
                engine_used,
                exchange: ExchangeAreas::from_rows(vec![Box::default(); n]),
                orders: vec![ExchangeAreas::from_rows(vec![Box::default(); n]); ORDERS],
                ..FormFactors::default()
            };
            let mut factors = joined(all, by_rays, options.separate);
            self.describe(&mut factors);
            factors.rest = self.remainders(&factors, &exchanger, run.progress)?;
            return Ok(factors);
        }
        let rays = self.row_rays();
        let estimator = self.estimator_of(&Engine::Rays);
        let no_pairs = vec![Vec::new(); n];
        let tracing = RowTracing {
            sides: &self.sides,
            gatherer: &self.gatherer,
            exact: &no_pairs,
            estimator: &estimator,
            separate: options.separate,
            is_known: &is_known,
        };
        let traced = tracing.trace(run)?;
        let (Some(all), Some(traced)) = (all, traced) else {
            return Err(FactorsError::Elsewhere);
        };
        let by_rays = merge::merge(&self.sides, traced, &no_pairs, run.progress)?;
        let engine_used = EngineUsed {
            name: "analytic".to_owned(),
            device: estimator.engine_used().device,
            notes: notes(&all, &exchanger, is_complete, rays),
        };
        let mut factors = FormFactors {
            engine_used,
            ..joined(all, by_rays, options.separate)
        };
        if is_complete {
            self.describe(&mut factors);
            settle_remainders(&mut factors, exchanger.truncated());
        }
        Ok(factors)
    }

    /// The exchange areas without those of rows that a few rays contradict.
    ///
    /// # Errors
    /// [`FactorsError::Doubtful`] if there are many of these, or if others computed the rows and go on with
    /// them.
    fn checked(
        &self,
        mut all: AllPairs,
        exchanger: &Exchanger,
        is_alone: bool,
        progress: &Progress,
    ) -> Result<AllPairs, FactorsError> {
        let check = RowCheck {
            sides: &self.sides,
            gatherer: &self.gatherer,
            exchanger,
            seed: hash(&[self.seed, 3]),
        };
        let doubtful = check.doubtful(&all, progress)?;
        if doubtful.is_empty() {
            return Ok(all);
        }
        let rows = self.sides.len();
        if doubtful.len() as f64 > MOST_DOUBTFUL * rows as f64 || !is_alone {
            return Err(FactorsError::Doubtful {
                doubtful: doubtful.len(),
                rows,
            });
        }
        doubtful.iter().for_each(|&row| all.is_doubtful[row] = true);
        let is_doubtful = &all.is_doubtful;
        for order in &mut all.orders {
            order.retain(|i, e| !is_doubtful[i] && !is_doubtful[e.column as usize]);
        }
        Ok(all)
    }

    /// An exchanger between these sides.
    pub(super) fn exchanger(&self, sides: Vec<Side>, row_budget: f64) -> Exchanger<'_> {
        let wanted = ExchangerOptions {
            accuracy: self.plan.options.accuracy,
            is_per_channel: false,
            seed: hash(&[self.seed, 0]),
            row_budget,
        };
        let surfaces = self.gatherer.surfaces();
        Exchanger::new(&self.plan.patches, surfaces, sides, wanted)
    }

    pub(super) fn ray_estimator(&self, rays: u32) -> Estimator<'_> {
        Estimator::new(
            &Engine::Rays,
            &self.gatherer,
            &self.plan.patches,
            rays,
            hash(&[self.seed, 1]),
            Columns::All,
        )
    }

    /// The memory for the matrix if formulas find all visible pairs.
    pub(super) fn forecast_of_formulas(
        &self,
        progress: &Progress,
    ) -> Result<super::Forecast, FactorsError> {
        let sampler = self.ray_estimator(super::FORECAST_RAYS);
        let costs = Costs {
            sides: &self.sides,
            tracer: self.gatherer.surfaces().tracer,
            sampler: &sampler,
            rays: super::FORECAST_RAYS,
            by_rows: false,
            matrices: if self.plan.options.separate { 2 } else { 1 },
            seed: self.seed,
        };
        Ok(costs.forecast(progress)?)
    }
}

/// Share of the rows that rays may take instead of formulas which they contradict.
const MOST_DOUBTFUL: f64 = 0.1;

/// The sum of the exchange areas by formulas and by rays.
fn joined(all: AllPairs, by_rays: FormFactors, separate: bool) -> FormFactors {
    let [straight, mirrored, more] = all.orders;
    let sum = |a: ExchangeAreas, b: ExchangeAreas| match (a.pairs(), b.pairs()) {
        (_, 0) => a,
        (0, _) => b,
        _ => ExchangeAreas::sum_of(&[a, b]),
    };
    if separate {
        let orders = [straight, mirrored, more].into_iter().zip(by_rays.orders);
        let orders: Vec<ExchangeAreas> = orders.map(|(a, b)| sum(a, b)).collect();
        return FormFactors {
            exchange: ExchangeAreas::sum_of(&orders),
            orders,
            ..by_rays
        };
    }
    let exchange = [mirrored, more, by_rays.exchange]
        .into_iter()
        .fold(straight, sum);
    FormFactors {
        exchange,
        orders: Vec::new(),
        ..by_rays
    }
}

/// Assigns the deficit of rows to where rays saw it go; deficits within a row's errors count as
/// zero. Where rays lost nothing, the deficit is what longer chains of mirrors than those with
/// images would have carried.
fn settle_remainders(factors: &mut FormFactors, truncated: Option<f64>) {
    let ended = factors.ended();
    let errors = factors.per_area(factors.exchange.sums(|_, e| [f64::from(e.error); 2]));
    for ((rest, ended), error) in factors.rest.iter_mut().zip(ended).zip(errors) {
        *rest = settled_remainder(rest, 1.0 - ended, error, truncated.is_some());
    }
    if let Some(truncated) = truncated {
        widen_by_truncation(factors, truncated);
    }
}

/// Adds light by chains of mirrors without images to the errors, as if it ended where the rest of
/// its row did. Its amount is the row's own cut where no light leaves the scene; elsewhere at most
/// `truncated`.
fn widen_by_truncation(factors: &mut FormFactors, truncated: f64) {
    let rows = factors.rest.iter().zip(factors.ended());
    let share = |(rest, ended): (&RowRemainder, f64)| {
        let lost = if rest.escaped() > 0.0 {
            truncated
        } else {
            rest.cut
        };
        lost / ended.max(f64::MIN_POSITIVE)
    };
    let shares: Vec<f64> = rows.map(share).collect();
    let doubt = |i: usize, e: &mut Exchange| {
        let share = shares[i].max(shares[e.column as usize]);
        e.error = f64::from(e.error).hypot(share * e.value) as f32;
        true
    };
    let all = factors.orders.iter_mut().chain([&mut factors.exchange]);
    all.for_each(|matrix| matrix.retain(doubt));
}

fn settled_remainder(
    seen: &RowRemainder,
    missing: f64,
    error: f64,
    has_images: bool,
) -> RowRemainder {
    let went = seen.escaped() + seen.hidden + seen.lost;
    if missing <= 2.0 * error + 1e-12 {
        return RowRemainder::default();
    }
    if went == 0.0 {
        return RowRemainder {
            cut: if has_images { missing } else { 0.0 },
            ..RowRemainder::default()
        };
    }
    let share = missing / went;
    // A single way out is as well known as the sum of the row.
    let of = |part: f64, noise: f64| {
        let doubt = if part == went { 0.0 } else { noise * share };
        (part * share, doubt.hypot(error * part / went))
    };
    let (sky, sky_error) = of(seen.sky, seen.sky_error);
    let (ground, ground_error) = of(seen.ground, seen.ground_error);
    RowRemainder {
        sky,
        sky_error,
        ground,
        ground_error,
        hidden: seen.hidden * share,
        cut: 0.0,
        lost: seen.lost * share,
    }
}

/// How the pairs were resolved.
fn notes(all: &AllPairs, exchanger: &Exchanger, is_complete: bool, rays: u32) -> Vec<String> {
    let t = &all.counts;
    let mut notes = vec![format!(
        "{} pairs are unoccluded, {} partially occluded, {} fully occluded",
        t.bulk + t.single + t.close,
        t.partial,
        t.occluded
    )];
    if t.unresolved > 0 {
        notes.push(format!(
            "{} pairs with too many occluders took shadow rays",
            t.unresolved
        ));
    }
    notes.extend(exchanger.flatness.clone());
    let doubtful = all
        .is_doubtful
        .iter()
        .filter(|&&is_doubtful| is_doubtful)
        .count();
    if doubtful > 0 {
        notes.push(format!(
            "{doubtful} rows took rays, which contradict their formulas"
        ));
    }
    let given_up = all.is_done.iter().filter(|&&is_done| !is_done).count();
    if given_up > 0 {
        notes.push(format!(
            "{given_up} rows were left to rays, because formulas took too long"
        ));
    }
    if !is_complete {
        notes.push(format!("what has no formula took {rays} rays per row"));
    }
    notes
}

#[cfg(test)]
mod tests {
    use crate::form_factors::Plan;
    use crate::{Closure, Engine, FormFactorOptions, PatchSize};
    use azulejo_scene::synthetic::room_with_table;
    use azulejo_trace::{Progress, Tracer};

    /// What formulas had found of rows that were then left to rays counted beside what these found: some rows
    /// summed to 1.9.
    #[test]
    fn rows_left_to_rays_count_once() {
        let scene = room_with_table(60);
        let tracer = Tracer::new(&scene);
        let options = FormFactorOptions {
            engine: Engine::Analytic,
            size: PatchSize::Edge(0.0),
            closure: Closure::Never,
            ..FormFactorOptions::default()
        };
        let plan = Plan::new(&scene, &tracer, &options).unwrap();
        let mut prepared = plan.prepare();
        prepared.row_budget = 1e-5;
        let factors = prepared.compute(&Progress::new()).unwrap();
        let notes = factors.engine_used.notes.join("; ");
        assert!(notes.contains("rows were left to rays"), "{notes}");
        let off = factors.row_sums().into_iter().map(|sum| (sum - 1.0).abs());
        let off = off.fold(0.0, f64::max);
        assert!(off < 0.1, "{off}");
    }
}
