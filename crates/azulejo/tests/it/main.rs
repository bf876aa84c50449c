//! Both passes together.

mod glossy;
mod instances;
mod outside;
mod pictured_lamps;
mod rtrace;
mod typeface;
