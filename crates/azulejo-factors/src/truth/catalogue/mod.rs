//! Series of closed forms: the geometries of Howell's catalogue over ranges of their parameters.
//!
//! Every formula is checked by an independent quadrature in `tests`. Names end with the parameters.

mod curved;
mod flat;
mod infinite;
#[cfg(test)]
mod tests;

use super::Case;

/// Closed forms over ranges of parameters: rectangles and wedges, infinite strips and cylinders, disks,
/// finite cylinders, spheres, and elements. None of them is among [`cases`](super::cases).
pub fn catalogue() -> Vec<Case> {
    [flat::cases(), infinite::cases(), curved::cases()].concat()
}
