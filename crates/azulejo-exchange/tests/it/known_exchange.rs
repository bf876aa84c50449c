//! Exchange with known answers: the solver against them, and both against a table of reference values.

use crate::cases::{ExchangeCase, exchange_cases};
use std::collections::{HashMap, HashSet};

/// How many cases there are.
const CASES: usize = 156;

/// How many rows the table of reference values has at least.
const ROWS: usize = 61;

#[test]
fn cases_are_named_once_and_described() {
    let cases = exchange_cases();
    let ids: HashSet<&str> = cases.iter().map(|case| &*case.problem.id).collect();
    assert_eq!((ids.len(), cases.len()), (CASES, CASES));
    for case in &cases {
        let (asked, description) = (&case.problem, case.description());
        assert!(asked.truth.is_finite() && asked.truth != 0.0, "{case:?}");
        assert!(
            description.len() > 20 && !asked.source.is_empty(),
            "{case:?}"
        );
        let most = if asked.question.unit() == "K" {
            1e-8
        } else {
            1e-10 * asked.truth.abs()
        };
        assert!(case.tolerance() <= most, "{case:?}");
    }
}

/// The solver finds what textbooks say: ratios to ten digits, temperatures to 1e-8 K.
#[test]
fn the_solver_agrees_with_textbooks() {
    let mut off = Vec::new();
    for case in exchange_cases() {
        let (id, truth) = (&case.problem.id, case.problem.truth);
        let answer = case.ask().unwrap_or_else(|e| panic!("{id}: {e}"));
        // NaN is not within it.
        let is_within = (answer - truth).abs() <= case.tolerance();
        if !is_within {
            off.push((id.clone(), answer, truth));
        }
    }
    assert!(off.is_empty(), "{off:#?}");
}

/// Both the solver and the textbook agree with each row of the table, to ten digits.
#[test]
fn the_table_of_exchange_factors() {
    let Some(data) = azulejo_testing::data() else {
        return;
    };
    let table = std::fs::read_to_string(data.join("reference/exchange_factors.tsv")).unwrap();
    let cases = exchange_cases();
    let cases: HashMap<&str, &ExchangeCase> =
        cases.iter().map(|case| (&*case.problem.id, case)).collect();
    let (mut off, mut rows) = (Vec::new(), 0);
    for line in table.lines().skip(1) {
        let columns: Vec<&str> = line.split('\t').collect();
        let (id, expected): (_, f64) = (columns[0], columns[4].parse().unwrap());
        let case = cases
            .get(id)
            .unwrap_or_else(|| panic!("{id} is not a case"));
        rows += 1;
        let answers = [case.ask().unwrap(), case.problem.truth];
        let is_near = |answer: &f64| (answer - expected).abs() <= 1e-10 * expected.abs();
        if !answers.iter().all(is_near) {
            off.push((id, answers, expected));
        }
    }
    assert!(rows >= ROWS, "{rows} rows");
    assert!(off.is_empty(), "{off:#?}");
}
