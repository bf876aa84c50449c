//! Exchange factors, temperatures and fluxes whose values are known.

use super::Validator;
use super::record::{CheckRecord, ValidationPart};
use crate::clock::Clock;
use crate::failure::Failure;
use azulejo_exchange::truth::{ExchangeCase, ExchangeQuantity, exchange_cases};

const PART: ValidationPart = ValidationPart::Exchange;

/// Checks all cases.
pub fn check(validator: &Validator) -> Result<Vec<CheckRecord>, Failure> {
    let mut records = Vec::new();
    for case in exchange_cases() {
        if !validator.wants(PART, case.id) {
            continue;
        }
        let clock = Clock::start();
        let found = case.ask().map_err(Failure::failed)?;
        let values = [found, case.truth, bound(&case)];
        records.push(CheckRecord {
            source: case.source.to_owned(),
            unit: case.quantity.unit(),
            seconds: clock.wall(),
            ..CheckRecord::new(PART, case.id, values).of("", case.description.clone())
        });
    }
    Ok(records)
}

/// The tolerance in the unit of the answer.
fn bound(case: &ExchangeCase) -> f64 {
    match case.quantity {
        ExchangeQuantity::Temperature => case.tolerance,
        _ => case.tolerance * case.truth.abs(),
    }
}
