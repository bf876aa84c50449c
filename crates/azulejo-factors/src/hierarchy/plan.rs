//! Compressed factors of a plan, by whichever way suits it.

use super::stated::StatedErrors;
use super::{CompressedFactors, CompressionError, CompressionOptions, from_rays};
use crate::engine::Engine;
use crate::form_factors::{ExchangeAreas, FormFactors, PreparedPlan};
use azulejo_trace::Progress;

/// Bytes per pair that compression takes besides the matrix.
const PAIR_BYTES: u64 = 12;

/// Compressed factors with their rows and their errors.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StatedFactors {
    /// The matrix.
    pub factors: CompressedFactors,
    /// What is known of its rows: a matrix without pairs, whose `exchange` has no rows.
    pub rows: FormFactors,
    /// How far products and row sums are off.
    pub stated: StatedErrors,
    /// Bytes of the whole matrix; where there was none, a forecast of them.
    pub whole_bytes: u64,
}

impl StatedFactors {
    /// Computes the form factors of a plan in blocks.
    ///
    /// If its engine is rays, [`CompressedFactors::from_rays`]: the whole matrix never exists, and closure
    /// plays no part. Otherwise the whole matrix, with closure as the plan's options say, is compressed by
    /// [`CompressedFactors::new`]; if that takes more than the memory, and the engine was not asked for by
    /// name, rays do it, and a note says so. The same bits for any number of threads.
    ///
    /// # Errors
    /// [`CompressionError`]; [`FactorsError::TooLarge`](crate::FactorsError::TooLarge) if neither fits in the memory.
    pub fn of(
        plan: &PreparedPlan,
        options: &CompressionOptions,
        progress: &Progress,
    ) -> Result<StatedFactors, CompressionError> {
        options.check()?;
        if *plan.engine() == Engine::Rays {
            return StatedFactors::by_rays(plan, options, progress);
        }
        let forecast = plan.forecast(progress)?;
        let needed = forecast.bytes + PAIR_BYTES * forecast.pairs;
        if needed > plan.memory() && !plan.has_engine_by_name() {
            let mut stated = StatedFactors::by_rays(plan, options, progress)?;
            let note = "the whole matrix, which formulas need, would take more than the memory";
            stated.rows.engine_used.notes.push(note.to_owned());
            return Ok(stated);
        }
        plan.refuse_above_memory(needed)?;
        StatedFactors::whole(plan, options, progress)
    }

    fn whole(
        plan: &PreparedPlan,
        options: &CompressionOptions,
        progress: &Progress,
    ) -> Result<StatedFactors, CompressionError> {
        let mut rows = plan.compute(progress)?;
        let factors = CompressedFactors::new(&rows, &plan.places(), options, progress)?;
        let stated = StatedErrors::against(&factors, &rows);
        let whole_bytes = rows.exchange.bytes() as u64;
        rows.exchange = ExchangeAreas::new();
        Ok(StatedFactors {
            factors,
            rows,
            stated,
            whole_bytes,
        })
    }

    fn by_rays(
        plan: &PreparedPlan,
        options: &CompressionOptions,
        progress: &Progress,
    ) -> Result<StatedFactors, CompressionError> {
        plan.refuse_above_memory(from_rays::forecast_bytes(plan))?;
        let whole = plan.forecast(progress)?;
        let factors = CompressedFactors::from_rays(plan, options, progress)?;
        Ok(StatedFactors {
            rows: factors.rows_alone(plan),
            stated: StatedErrors::by_rays(&factors, plan, progress)?,
            whole_bytes: 16 * whole.pairs,
            factors,
        })
    }
}
