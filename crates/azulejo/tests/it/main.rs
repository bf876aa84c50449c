//! Both passes together.

mod atlases;
mod directional;
mod glossy;
mod instances;
mod lightmap;
mod lightmap_contacts;
mod outside;
mod page;
mod pictured_lamps;
mod probe_grid;
mod rtrace;
mod typeface;
