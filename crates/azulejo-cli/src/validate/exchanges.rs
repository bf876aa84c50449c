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
        let problem = &case.problem;
        if !validator.wants(PART, &problem.id) {
            continue;
        }
        let clock = Clock::start();
        let answer = case.ask().map_err(Failure::failed)?;
        let values = [answer, problem.truth, case.tolerance()];
        records.push(CheckRecord {
            source: problem.source.clone(),
            unit: problem.question.unit(),
            seconds: clock.wall(),
            ..CheckRecord::new(PART, &*problem.id, values).of("", case.description())
        });
    }
    Ok(records)
}
