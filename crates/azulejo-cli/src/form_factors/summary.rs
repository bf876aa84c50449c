//! The summary of a form factor matrix.

use crate::report::{Report, count, number, percent};
use azulejo_exchange::Enclosure;
use azulejo_factors::FormFactors;
use azulejo_factors::form_factors::{Adjustment, RowRemainder, Truncation};
use serde_json::{Value, json};

/// Adds the size and the errors of a matrix.
pub fn describe(enclosure: &Enclosure, report: &mut Report) {
    let factors = &enclosure.factors;
    let (n, entries) = (factors.len(), factors.exchange.entries());
    let what = if enclosure.rows.are_groups {
        "groups"
    } else {
        "patches"
    };
    report.fact(what, n, what, count(n));
    let share = entries as f64 / (n as f64 * n as f64);
    let words = format!("{}, {} of the matrix", count(entries), percent(share));
    report.fact("entries", entries, "entries", words);
    report.value("matrix_bytes", factors.exchange.bytes());
    report.fact("rays", factors.rays, "rays", count(factors.rays));
    let missing = describe_sums(enclosure, report);
    closure(factors, report);
    truncation(factors, report);
    // A row is no better than its sum; an error that is unknown stays unknown.
    let estimated = mean(factors, &factors.row_errors);
    let error = if estimated < missing {
        missing
    } else {
        estimated
    };
    report.fact("row_error", number(error), "error of a row", percent(error));
}

/// Adds what leaves the scene, and the sums of rows; returns the mean of what they lack or have too much.
pub fn describe_sums(enclosure: &Enclosure, report: &mut Report) -> f64 {
    surroundings(&enclosure.factors, report);
    sums(enclosure, report)
}

/// Sky and ground.
fn surroundings(factors: &FormFactors, report: &mut Report) {
    let mean_share = |share: fn(&RowRemainder) -> f64| {
        let shares: Vec<f64> = factors.rest.iter().map(share).collect();
        mean(factors, &shares)
    };
    let (sky, ground, hidden) = (
        mean_share(|r| r.sky),
        mean_share(|r| r.ground),
        mean_share(|r| r.hidden),
    );
    let mut words = if factors.is_closed {
        "closed".to_owned()
    } else {
        format!(
            "open: {} of the light leaves upwards (sky), {} downwards (ground)",
            percent(sky),
            percent(ground)
        )
    };
    if hidden > 0.0 {
        words += &format!("; {} ends on back sides", percent(hidden));
    }
    report.fact("closed", factors.is_closed, "scene", words);
    report.value("sky_mean", number(sky));
    report.value("ground_mean", number(ground));
    report.value("hidden_mean", number(hidden));
    report.value("cut_mean", number(mean_share(|r| r.cut)));
}

/// Adds the sums of rows; returns the mean of what they lack or have too much.
fn sums(enclosure: &Enclosure, report: &mut Report) -> f64 {
    let factors = &enclosure.factors;
    // The sum of an empty row is −0, which would be printed.
    let sums: Vec<f64> = enclosure.row_sums().iter().map(|s| s + 0.0).collect();
    let low = sums.iter().copied().fold(f64::INFINITY, f64::min);
    let high = sums.iter().copied().fold(0.0, f64::max);
    let middle = mean(factors, &sums);
    report.line(
        "row sums",
        format!("{low:.4} to {high:.4}, mean {middle:.6}"),
    );
    report.value("row_sum_min", number(low));
    report.value("row_sum_max", number(high));
    report.value("row_sum_mean", number(middle));
    let missing: Vec<f64> = enclosure.residuals().iter().map(|r| r.abs()).collect();
    let most = missing.iter().copied().fold(0.0, f64::max);
    let typical = mean(factors, &missing);
    let words = format!("{} of a row, at most {}", percent(typical), percent(most));
    report.line("unaccounted", words);
    report.value("unaccounted_mean", number(typical));
    report.value("unaccounted_max", number(most));
    typical
}

fn closure(factors: &FormFactors, report: &mut Report) {
    let words = match &factors.closed {
        None => "none: rows are unchanged".to_owned(),
        Some(moved) => format!("moved {}", in_words(moved)),
    };
    report.line("closure", words);
    report.value(
        "closure",
        factors.closed.as_ref().map_or(Value::Null, moved),
    );
    let total = factors.closed.map_or(0.0, |m| m.total);
    report.value("correction", number(total));
}

fn truncation(factors: &FormFactors, report: &mut Report) {
    let Some(done) = &factors.truncated else {
        return;
    };
    let Truncation {
        before,
        after,
        dropped,
        moved: moves,
    } = done;
    let words = format!(
        "dropped {} of {} entries with {} of the light; moved {}",
        count(before - after),
        count(*before),
        percent(*dropped),
        in_words(moves)
    );
    report.line("truncation", words);
    let value = json!({
        "entries_before": before, "entries_after": after, "dropped": number(*dropped),
        "moved": moved(moves),
    });
    report.value("truncation", value);
}

fn in_words(moved: &Adjustment) -> String {
    format!(
        "{} of the light, {} of a row, at most {}",
        percent(moved.total),
        percent(moved.mean),
        percent(moved.most)
    )
}

fn moved(moved: &Adjustment) -> Value {
    json!({
        "moved": number(moved.total), "row_mean": number(moved.mean),
        "row_max": number(moved.most), "lacks_max": number(moved.deficit),
    })
}

/// The mean of one number per row, weighted by area.
fn mean(factors: &FormFactors, numbers: &[f64]) -> f64 {
    let total: f64 = factors.areas.iter().sum();
    let weighted = numbers.iter().zip(&factors.areas).map(|(x, a)| x * a);
    weighted.sum::<f64>() / total.max(f64::MIN_POSITIVE)
}
