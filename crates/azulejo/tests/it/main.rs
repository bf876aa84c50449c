//! Both passes together.

mod glossy;
mod outside;
mod rtrace;
mod typeface;
