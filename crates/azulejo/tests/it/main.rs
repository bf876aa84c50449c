//! Both passes together.

mod atlases;
mod glossy;
mod instances;
mod lightmap;
mod outside;
mod pictured_lamps;
mod rtrace;
mod typeface;
