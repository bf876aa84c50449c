//! first pass: scene to irradiance
