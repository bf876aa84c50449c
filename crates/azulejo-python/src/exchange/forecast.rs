//! Refusal of networks that would not fit in memory.

use azulejo_exchange::{Enclosure, GroupBy};
use pyo3::PyErr;
use pyo3::exceptions::PyMemoryError;

/// Numbers for each pair of a node and a row while a network is solved: what is emitted, what is
/// exchanged, what arrives, and what the solver needs.
const OF_ROWS: u64 = 5;

/// Numbers for each pair of nodes: conductances with errors, and what they are made of.
const OF_NODES: u64 = 4;

/// Refuses a network of so many nodes that it needs more than `memory`, in bytes.
pub fn check(
    enclosure: &Enclosure,
    by: Option<GroupBy>,
    bands: usize,
    memory: u64,
) -> Result<(), PyErr> {
    let rows = enclosure.len() as u64;
    let nodes = match by {
        Some(by) if !enclosure.rows.are_groups => enclosure.groups(by).names.len() as u64,
        _ => rows,
    };
    // Bands that are done keep conductances and errors.
    let kept = 2 * (bands as u64).saturating_sub(1);
    let numbers_per_node = nodes.saturating_mul(OF_NODES + kept);
    let numbers = nodes.saturating_mul(numbers_per_node.saturating_add(OF_ROWS * rows));
    let bytes = numbers.saturating_mul(size_of::<f64>() as u64);
    if bytes <= memory {
        return Ok(());
    }
    let gibibytes = |bytes: u64| bytes as f64 / f64::from(1 << 30);
    Err(PyMemoryError::new_err(format!(
        "a network of {nodes} nodes needs about {:.1} GiB of memory, and {:.1} GiB may be used: choose fewer \
         nodes by by=, group rows, or allow more memory",
        gibibytes(bytes),
        gibibytes(memory)
    )))
}
