//! Both passes together.

mod glossy;
mod rtrace;
mod typeface;
