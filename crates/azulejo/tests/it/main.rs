//! Both passes together.

mod glossy;
mod outside;
mod pictured_lamps;
mod rtrace;
mod typeface;
