//! Renders an SFF or SCN scene as RTRACE does.
//!
//! RTRACE (António Costa, INESC-Norte, 1988 to 1994) is a ray tracer after Whitted with its own
//! ideas of light: lamps that fade with distance but not with its square, one number
//! for a surface's mirror and highlight, and colours that fade to black with the length of the ray.
//! [`render`] computes what that program computes, from the numbers that readers keep in [`Rtrace`];
//! docs/look-rtrace.md lists the differences.

mod ambient;
mod light;
mod map;
mod noise;
mod pixels;
mod relief;
mod shade;
mod strauss;
mod texture;
mod view;
mod world;

#[cfg(test)]
mod tests;

pub use view::{Side, View};

use azulejo_scene::rtrace::Rtrace;
use azulejo_scene::{Image, Scene};
use azulejo_trace::{Cancelled, Progress};
use pixels::Pixels;
use rayon::prelude::*;
use shade::Shader;
use view::Lens;

/// RTRACE's options that change the image. The letters are those of its command line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// `m`: the reflection model.
    pub model: Model,
    /// `t`: which textures are applied.
    pub textures: Textures,
    /// `l`: what casts shadows.
    pub shadows: Shadows,
    /// `s`: the most surfaces along a path, mirrored and refracted, at least 1.
    pub depth: u32,
    /// `S`: a path ends where the product of its reflectances and transmittances is not above this.
    pub cut: f64,
    /// How pixels are subdivided.
    pub antialiasing: Antialiasing,
    /// `d`: number of surfaces along a path whose ambient light is gathered with rays.
    pub ambient_depth: u32,
    /// `D`: rays that gather it, shared between diffuse and mirrored light.
    pub ambient_samples: u32,
}

impl Default for Options {
    /// RTRACE's defaults: Strauss's model, no textures, opaque shadows, 8 surfaces, cut at 1%,
    /// one ray per pixel corner, constant ambient light.
    fn default() -> Options {
        Options {
            model: Model::Strauss,
            textures: Textures::None,
            shadows: Shadows::Opaque,
            depth: 8,
            cut: 0.01,
            antialiasing: Antialiasing::default(),
            ambient_depth: 0,
            ambient_samples: 16,
        }
    }
}

/// The reflection model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// 0: Phong's.
    Phong,
    /// 1: Strauss's (*A realistic lighting model for computer animators*, 1990), as RTRACE modifies
    /// it.
    Strauss,
}

/// Which textures are applied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Textures {
    /// 0: none.
    None,
    /// 1: those among the objects.
    Inline,
    /// 2: those of a section of their own.
    Section,
}

/// What casts shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shadows {
    /// 0: everything is opaque, glass too.
    Opaque,
    /// 1: each object transmits its share, once.
    Filtered,
    /// 2: and lights behind a glass surface light it.
    Transmitted,
}

/// How pixels are subdivided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Antialiasing {
    /// `a`: which pixels.
    pub mode: AntialiasingMode,
    /// `p`: how often a pixel is halved, 0..=3. At 0 a pixel is the mean of its corners.
    pub levels: u32,
    /// `A`: a pixel is subdivided if its corners differ by more than this (root mean square of the
    /// channels); if negative, its magnitude is compared with the contrast instead.
    pub threshold: f64,
    /// `i`: whether rays inside a pixel may hit objects that none of its corners hit. RTRACE's
    /// default is false, which breaks fine lines.
    pub all_objects: bool,
}

impl Default for Antialiasing {
    fn default() -> Antialiasing {
        Antialiasing {
            mode: AntialiasingMode::Adaptive,
            levels: 0,
            threshold: 0.05,
            all_objects: false,
        }
    }
}

/// Which pixels are subdivided, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AntialiasingMode {
    /// 0: quarters whose corners differ, again and again.
    Adaptive,
    /// 1: pixels whose corners differ, all at once.
    SemiAdaptive,
    /// 2: all pixels, all at once.
    Fixed,
}

/// Renders what RTRACE computes: linear values, 1 for white, not clamped.
///
/// `rtrace` must be the numbers of `scene`. Counts corners and pixels on `progress`. The same bits
/// for any number of threads.
///
/// # Errors
/// [`Cancelled`] when `progress` was.
///
/// # Panics
/// If the image has 2³² pixel corners or more.
pub fn render(
    scene: &Scene,
    rtrace: &Rtrace,
    view: &View,
    options: &Options,
    progress: &Progress,
) -> Result<Image, Cancelled> {
    let (width, height) = view.size;
    let mut image = Image::new(width, height);
    if image.pixels.is_empty() {
        return Ok(image);
    }
    let corners = (u64::from(width) + 1) * (u64::from(height) + 1);
    assert!(
        u32::try_from(corners).is_ok(),
        "an image of {width} × {height} pixels is too large"
    );
    progress.begin("render", corners + u64::from(width) * u64::from(height));
    let lens = Lens::new(view);
    let shader = Shader::new(scene, rtrace, &lens, options);
    let pixels = Pixels {
        shader: &shader,
        lens: &lens,
        options: options.antialiasing,
    };
    let corners = pixels.corners(progress)?;
    let rows: Result<Vec<Vec<[f32; 3]>>, Cancelled> = (0..height)
        .into_par_iter()
        .map(|y| pixels.row(y, &corners, progress))
        .collect();
    image.pixels = rows?.concat();
    Ok(image)
}

/// The bytes that RTRACE writes for its values: 256 v, rounded, within 0..=255; three per pixel.
/// There is no gamma.
pub fn bytes(image: &Image) -> Vec<u8> {
    let byte = |v: &f32| (256.0 * f64::from(*v)).clamp(0.0, 255.0).round() as u8;
    image.pixels.iter().flatten().map(byte).collect()
}
