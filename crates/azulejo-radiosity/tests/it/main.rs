//! Integration tests of the first pass, one module per subject.

mod form_factors;
mod table;
