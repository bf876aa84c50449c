//! Tests of the library as a whole.

mod known_exchange;
