//! Models with lightmaps and volumes of light, loaded by Bevy.

mod gpu;
mod loading;
mod model;
mod picture;
mod volume;
