//! first pass: scene to irradiance

pub mod analytic;
