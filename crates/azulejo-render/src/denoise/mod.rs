//! Removes noise from an image by its own standard errors and the layers beside it.
//!
//! Rousselle, Manzi and Zwicker, *Robust denoising using feature and color information*, Computer
//! Graphics Forum 32(7), 2013: joint non-local means. Three filters are tried, of which the third
//! looks at the layers alone, and the one with the least estimated error is taken, pixel by pixel.
//! Weights come from one half of the samples and are applied to the other (Rousselle, Knaus and
//! Zwicker, *Adaptive rendering with non-local means filtering*, SIGGRAPH Asia 2012, section 4), so
//! that noise does not choose its own neighbours. Textures are divided out before.

mod filter;
mod planes;
mod select;

use crate::layers::PictureLayers;
use crate::measured::MeasuredImage;
use azulejo_scene::Image;
use azulejo_trace::{Cancelled, Progress};
use filter::{Candidate, NoisyImage, filter_bands};
use planes::{Features, Size};
use select::FilterSelection;

/// Albedo below which textures are not divided out: the light is hardly reflected, but emitted.
const LEAST_ALBEDO: f32 = 0.02;

/// An image without most of its noise, and what was done to it.
#[derive(Clone, Debug, PartialEq)]
pub struct DenoisedImage {
    /// Radiance, W/(sr·m²).
    pub image: Image,
    /// Change of the pixels, mean of the absolute values over the mean of the image.
    pub change: f64,
    /// Change of the image's mean, relative to it: light that was moved out of or into bright dots.
    pub bias: f64,
    /// Root mean square of the relative error before, estimated from standard errors and the
    /// difference between the halves; relative as in [`relative_rmse`](crate::relative_rmse).
    pub error_before: f64,
    /// The same after, noise and what the filter blurs together, by Stein's unbiased risk estimate.
    pub error_after: f64,
}

/// Filters a measured image; `layers` must be of the same view and size.
///
/// Pixels without any standard error keep their values, so an image without noise is unchanged.
/// The result is the same bits for any number of threads. Counts pixels on `progress`.
///
/// # Errors
/// [`Cancelled`] when `progress` was.
///
/// # Panics
/// If the images differ in size.
pub fn denoise(
    found: &MeasuredImage,
    layers: &PictureLayers,
    progress: &Progress,
) -> Result<DenoisedImage, Cancelled> {
    let size = Size {
        width: found.image.width as usize,
        height: found.image.height as usize,
    };
    let count = size.width * size.height;
    assert!(
        [found.image.pixels.len(), layers.depth.len()] == [count; 2],
        "an image and layers of different sizes"
    );
    progress.begin("denoise", count as u64);
    let albedo = demodulation(&layers.albedo);
    let noisy = NoisyImage::new(size, found, &albedo);
    let features = Features::new(size, layers);
    let candidates = filter_bands(&noisy, &features, progress)?;
    let selection = FilterSelection::new(size, &noisy, &features, &candidates, &albedo);
    Ok(finish(found, &albedo, &candidates, &selection))
}

/// What each channel is divided by before it is filtered.
fn demodulation(albedo: &Image) -> Vec<[f32; 3]> {
    let divisor = |a: f32| if a > LEAST_ALBEDO { a } else { 1.0 };
    albedo.pixels.iter().map(|p| p.map(divisor)).collect()
}

/// Blends the candidates as they were selected, puts the textures back, and measures the result.
fn finish(
    found: &MeasuredImage,
    albedo: &[[f32; 3]],
    candidates: &[Candidate],
    selection: &FilterSelection,
) -> DenoisedImage {
    let mut image = found.image.clone();
    let (mut moved, mut added, mut whole) = (0.0, 0.0, 0.0);
    for (k, pixel) in image.pixels.iter_mut().enumerate() {
        if found.error.pixels[k] != [0.0; 3] {
            let shares = selection.shares[k];
            let kept = 1.0 - shares.iter().sum::<f32>();
            for c in 0..3 {
                let before = pixel[c];
                let filtered = candidates.iter().zip(shares);
                let filtered: f32 = filtered.map(|(one, s)| s * one.mean(k)[c]).sum();
                pixel[c] = kept * before + filtered * albedo[k][c];
                moved += f64::from((pixel[c] - before).abs());
                added += f64::from(pixel[c] - before);
            }
        }
        whole += found.image.pixels[k]
            .iter()
            .map(|&v| f64::from(v))
            .sum::<f64>();
    }
    let relative = |sum: f64| if whole > 0.0 { sum / whole } else { 0.0 };
    DenoisedImage {
        image,
        change: relative(moved),
        bias: relative(added),
        error_before: selection.error_before,
        error_after: selection.error_after,
    }
}

#[cfg(test)]
mod tests;
