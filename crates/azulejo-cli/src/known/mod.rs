//! Known answers: scenes and enclosures with a question whose answer is known, read from the folder `data`.
//!
//! Tests of the libraries include these files, too; they find in each what follows from formulas.

pub mod exchange;
pub mod factors;
