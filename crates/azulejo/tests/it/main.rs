//! Both passes together, and the layers of the crates.

mod arrows;
mod circles;
mod glossy;
mod rtrace;
mod typeface;
