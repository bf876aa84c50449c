//! Tests of the library as a whole.

// The cases of `azulejo validate`; of their reader, tests need but a part.
#[allow(dead_code)]
#[path = "../../../azulejo-cli/src/known/exchange.rs"]
mod cases;
mod daylight;
mod expected;
mod known_exchange;
mod known_factors;
mod known_values;
mod net_radiation;
mod planck;
mod textbooks;
