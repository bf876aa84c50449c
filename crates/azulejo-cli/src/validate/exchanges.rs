//! Exchange factors, temperatures and fluxes whose values are known.

use super::Validator;
use super::record::{CheckRecord, ValidationPart};
use crate::clock::Clock;
use crate::failure::Failure;
use crate::known::exchange::exchange_cases;

const PART: ValidationPart = ValidationPart::Exchange;

/// Checks all cases.
pub fn check(validator: &Validator) -> Result<Vec<CheckRecord>, Failure> {
    let mut records = Vec::new();
    for case in exchange_cases() {
        let asked = &case.asked;
        if !validator.wants(PART, &asked.id) {
            continue;
        }
        let clock = Clock::start();
        let answer = case.ask().map_err(Failure::failed)?;
        let values = [answer, asked.truth, case.tolerance()];
        records.push(CheckRecord {
            source: asked.source.clone(),
            unit: asked.question.unit(),
            seconds: clock.wall(),
            ..CheckRecord::new(PART, &*asked.id, values).of("", case.description())
        });
    }
    Ok(records)
}
