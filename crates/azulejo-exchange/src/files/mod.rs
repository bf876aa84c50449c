//! Files of matrices.

pub mod csv;
