//! Exchange with known answers: the solver, textbooks, and a table of reference values.

use azulejo_exchange::truth::{ExchangeCase, ExchangeQuantity, exchange_cases};
use std::collections::{HashMap, HashSet};

/// How many cases there are.
const CASES: usize = 156;

/// How many rows the table of reference values has at least.
const ROWS: usize = 61;

#[test]
fn ids_are_unique() {
    let cases = exchange_cases();
    let ids: HashSet<&str> = cases.iter().map(|case| case.id).collect();
    assert_eq!((ids.len(), cases.len()), (CASES, CASES));
}

/// The solver finds what textbooks say: ratios to ten digits, temperatures to 1e-8 K.
#[test]
fn the_solver_agrees_with_textbooks() {
    let mut off = Vec::new();
    for case in exchange_cases() {
        let tolerance = match case.quantity {
            ExchangeQuantity::Temperature => 1e-8,
            _ => 1e-10,
        };
        assert!(case.tolerance <= tolerance, "{case:?}");
        let found = case.ask().unwrap_or_else(|e| panic!("{}: {e}", case.id));
        if !case.is_within(found) {
            off.push((case.id, found, case.truth, case.deviation(found)));
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
    let cases: HashMap<&str, &ExchangeCase> = cases.iter().map(|case| (case.id, case)).collect();
    let (mut off, mut rows) = (Vec::new(), 0);
    for line in table.lines().skip(1) {
        let columns: Vec<&str> = line.split('\t').collect();
        let (id, expected): (_, f64) = (columns[0], columns[4].parse().unwrap());
        let case = cases.get(id).unwrap_or_else(|| panic!("{id} is no case"));
        rows += 1;
        let found = [case.ask().unwrap(), case.truth];
        let is_near = |found: &f64| (found - expected).abs() <= 1e-10 * expected.abs();
        if !found.iter().all(is_near) {
            off.push((id, found, expected));
        }
    }
    assert!(rows >= ROWS, "{rows} rows");
    assert!(off.is_empty(), "{off:#?}");
}
