//! Models with lightmaps, loaded by Bevy.

mod loading;
mod model;
mod picture;
