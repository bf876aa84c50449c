//! The matrix by the analytic engine, with rays for pairs without a formula.

use super::doubt::RowCheck;
use super::matrix::RowRemainder;
use super::rows::RowTracing;
use super::{FormFactors, PreparedPlan, merge};
use crate::analytic_engine::exchanger::{AllPairs, Exchanger, ExchangerOptions};
use crate::choice::met_share;
use crate::engine::{Engine, EngineUsed};
use crate::error::FactorsError;
use crate::estimator::Estimator;
use crate::exchange_areas::{Exchange, ExchangeAreas};
use crate::row::{Columns, ORDERS, Order, Side};
use azulejo_trace::sampling::hash;
use azulejo_trace::{Progress, Run};
use glam::DVec3;

impl PreparedPlan<'_> {
    /// All rows by formulas. Rays take the rest: curved patches; mirrors and glass without images;
    /// rows that time ran out for; and in open scenes with mirrors the directions, but not the
    /// amount, of light that leaves.
    pub(super) fn by_formulas(&self, run: Run) -> Result<FormFactors, FactorsError> {
        self.refuse_too_large(run)?;
        // Only one process knows of all rows which are given up.
        let is_alone = run.role().parts == 1 && !run.is_shared();
        let row_budget = if is_alone {
            self.row_budget
        } else {
            f64::INFINITY
        };
        let n = self.sides.len();
        let sides = (0..n).map(|row| self.sides.side(row)).collect();
        let exchanger = self.exchanger(sides, row_budget);
        let pairs = exchanger.all(self.open_up(), run)?;
        let checked = |pairs| self.checked(pairs, &exchanger, is_alone, run.progress);
        let pairs = pairs.map(checked).transpose()?;
        // Where others make the result, they have the rows that are not here.
        let is_done = |row: usize| pairs.as_ref().is_none_or(|pairs| pairs.is_done[row]);
        let is_doubtful = |row: usize| pairs.as_ref().is_some_and(|pairs| pairs.is_doubtful[row]);
        let is_complete = exchanger.is_complete() && (0..n).all(|i| is_done(i) && !is_doubtful(i));
        let materials = self.plan.patches.materials_in_use(&self.plan.proxy.scene);
        if is_complete && !materials.iter().any(|m| m.is_specular()) {
            let pairs = pairs.ok_or(FactorsError::Elsewhere)?;
            return self.formulas_alone(pairs, &exchanger, run.progress);
        }
        // Rays find the rest.
        let has_formula: Vec<bool> = (0..n).map(|i| exchanger.has(i)).collect();
        let is_known = |i: usize, j: u32, order: Order| {
            let j = j as usize;
            exchanger.known[usize::from(order)]
                && (has_formula[i] && has_formula[j])
                && is_done(i.min(j))
                && !is_doubtful(i)
                && !is_doubtful(j)
        };
        let estimator = self.sampled_estimator(&Engine::Rays);
        let tracing = RowTracing {
            separate: self.plan.options.separate,
            is_known: &is_known,
            ..RowTracing::new(self, &estimator)
        };
        let traced = tracing.trace(run)?;
        let (Some(pairs), Some(traced)) = (pairs, traced) else {
            return Err(FactorsError::Elsewhere);
        };
        let rays = (!is_complete).then(|| self.row_rays());
        let by_rays = FormFactors {
            engine_used: self.formulas_used(&pairs, &exchanger, rays),
            ..merge::merge(&self.sides, traced, &[], run.progress)?
        };
        let mut factors = joined(pairs, by_rays, self.plan.options.separate);
        if is_complete {
            self.describe(&mut factors);
            settle_remainders(&mut factors, exchanger.truncated());
        }
        Ok(factors)
    }

    /// All rows where formulas know all of them, in a scene without mirrors.
    fn formulas_alone(
        &self,
        pairs: AllPairs,
        exchanger: &Exchanger,
        progress: &Progress,
    ) -> Result<FormFactors, FactorsError> {
        let none = ExchangeAreas::from_rows(vec![Box::default(); self.sides.len()]);
        let by_rays = FormFactors {
            engine_used: self.formulas_used(&pairs, exchanger, None),
            orders: vec![none.clone(); ORDERS],
            exchange: none,
            ..FormFactors::default()
        };
        let upward = pairs.upward.clone();
        let mut factors = joined(pairs, by_rays, self.plan.options.separate);
        self.describe(&mut factors);
        factors.rest = self.remainders(&factors, exchanger, upward.as_deref(), progress)?;
        Ok(factors)
    }

    /// The engine that ran, with how the pairs were resolved; `rays` are those per row, if rays found a part.
    fn formulas_used(
        &self,
        pairs: &AllPairs,
        exchanger: &Exchanger,
        rays: Option<u32>,
    ) -> EngineUsed {
        let kernel = self.gatherer.surfaces().tracer.kernel_name();
        EngineUsed {
            notes: notes(pairs, exchanger, rays),
            ..EngineUsed::new("analytic", kernel)
        }
    }

    /// The exchange areas without those of rows that a few rays contradict.
    ///
    /// # Errors
    /// [`FactorsError::Doubtful`] if there are many of these, or if others computed the rows and go on with
    /// them.
    fn checked(
        &self,
        mut pairs: AllPairs,
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
        let doubtful = check.doubtful(&pairs, progress)?;
        if doubtful.is_empty() {
            return Ok(pairs);
        }
        let rows = self.sides.len();
        if doubtful.len() as f64 > MOST_DOUBTFUL * rows as f64 || !is_alone {
            return Err(FactorsError::Doubtful {
                doubtful: doubtful.len(),
                rows,
            });
        }
        doubtful
            .iter()
            .for_each(|&row| pairs.is_doubtful[row] = true);
        let is_doubtful = &pairs.is_doubtful;
        for order in &mut pairs.orders {
            order.retain(|i, e| !is_doubtful[i] && !is_doubtful[e.column as usize]);
        }
        Ok(pairs)
    }

    /// The up direction, if light leaves the scene, and only formulas and shadow rays tell how much of it upwards.
    fn open_up(&self) -> Option<DVec3> {
        let (scene, patches) = (&self.plan.proxy.scene, &self.plan.patches);
        let is_specular = patches
            .materials_in_use(scene)
            .iter()
            .any(|m| m.is_specular());
        let is_open = !is_specular && met_share(self.gatherer.surfaces(), patches) < 1.0;
        is_open.then(|| scene.units.up.axis())
    }

    /// An exchanger between these sides.
    pub(super) fn exchanger(&self, sides: Vec<Side>, row_budget: f64) -> Exchanger<'_> {
        let options = ExchangerOptions {
            accuracy: self.accuracy,
            is_per_channel: false,
            seed: hash(&[self.seed, 0]),
            row_budget,
        };
        let surfaces = self.gatherer.surfaces();
        Exchanger::new(&self.plan.patches, surfaces, sides, options)
    }

    /// The estimator by `rays` rays for each row, with this seed.
    pub(super) fn ray_estimator(&self, rays: u32, seed: u32) -> Estimator<'_> {
        Estimator::new(
            &Engine::Rays,
            &self.gatherer,
            &self.plan.patches,
            rays,
            seed,
            Columns::All,
        )
    }
}

/// Share of the rows that rays may take instead of formulas which they contradict.
const MOST_DOUBTFUL: f64 = 0.1;

/// The sum of the exchange areas by formulas and by rays.
fn joined(pairs: AllPairs, by_rays: FormFactors, separate: bool) -> FormFactors {
    let [straight, mirrored, more] = pairs.orders;
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
    let matrices = factors.orders.iter_mut().chain([&mut factors.exchange]);
    matrices.for_each(|matrix| matrix.retain(doubt));
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
    let scaled = |part: f64, noise: f64| {
        let doubt = if part == went { 0.0 } else { noise * share };
        (part * share, doubt.hypot(error * part / went))
    };
    let (sky, sky_error) = scaled(seen.sky, seen.sky_error);
    let (ground, ground_error) = scaled(seen.ground, seen.ground_error);
    let (hidden, hidden_error) = scaled(seen.hidden, seen.hidden_error);
    RowRemainder {
        sky,
        sky_error,
        ground,
        ground_error,
        hidden,
        hidden_error,
        cut: 0.0,
        lost: seen.lost * share,
    }
}

/// How the pairs were resolved.
fn notes(pairs: &AllPairs, exchanger: &Exchanger, rays: Option<u32>) -> Vec<String> {
    let t = &pairs.counts;
    let mut notes = vec![format!(
        "{} pairs are unoccluded, {} partially occluded, {} fully occluded",
        t.bulk + t.single + t.close,
        t.partial,
        t.occluded
    )];
    if t.unresolved > 0 {
        notes.push(format!(
            "shadow rays estimated {} pairs with something between them",
            t.unresolved
        ));
    }
    notes.extend(exchanger.flatness.clone());
    let doubtful = pairs.is_doubtful.iter().filter(|&&row| row).count();
    if doubtful > 0 {
        notes.push(format!(
            "{doubtful} rows took rays, which contradict their formulas"
        ));
    }
    let given_up = pairs.is_done.iter().filter(|&&is_done| !is_done).count();
    if given_up > 0 {
        notes.push(format!(
            "{given_up} rows were left to rays, because formulas took too long"
        ));
    }
    if let Some(rays) = rays {
        notes.push(format!(
            "rays found the light without formulas, {rays} per row"
        ));
    }
    notes
}

#[cfg(test)]
mod tests {
    use crate::form_factors::Plan;
    use crate::{Closure, Engine, FormFactorOptions, PatchSize};
    use azulejo_scene::synthetic::room_with_table;
    use azulejo_trace::{Progress, Tracer};

    /// What formulas had found of rows that were then left to rays counted in addition to what these found: some rows
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
