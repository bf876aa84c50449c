//! Files made to be difficult.
