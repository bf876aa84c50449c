//! Reduction of an image to a palette of 256 colours, which halves the size of its file.

use super::{Color, RgbImage};
use std::collections::BTreeMap;

/// Colours that one byte can index.
const COLORS: usize = 256;

/// An image with a palette.
pub struct IndexedImage {
    /// At most 256 colours.
    pub palette: Vec<Color>,
    /// Index of each pixel's colour, rows from the top.
    pub indices: Vec<u8>,
}

/// A colour and its weight.
type WeightedColor = (Color, f64);

/// Chooses the colours by median cut (Heckbert 1982): the group with the largest spread is split
/// until there are enough groups; each becomes its mean.
pub fn reduce(image: &RgbImage) -> IndexedImage {
    let mut counts: BTreeMap<Color, u32> = BTreeMap::new();
    for rgb in image.rgb.chunks_exact(3) {
        *counts.entry([rgb[0], rgb[1], rgb[2]]).or_default() += 1;
    }
    // The square root keeps large even areas from taking most of the palette.
    let weighted = |(color, count): (&Color, &u32)| (*color, f64::from(*count).sqrt());
    let mut groups = vec![counts.iter().map(weighted).collect::<Vec<WeightedColor>>()];
    while groups.len() < COLORS {
        let spreads = groups.iter().map(|g| spread(g).0);
        let widest = spreads.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((k, _)) = widest.filter(|(_, spread)| *spread > 0.0) else {
            break;
        };
        let (low, high) = split(std::mem::take(&mut groups[k]));
        groups[k] = low;
        groups.push(high);
    }
    let palette: Vec<Color> = groups.iter().map(|g| mean(g)).collect();
    let exact: BTreeMap<Color, u8> = palette.iter().copied().zip(0..=255).collect();
    let mut near: BTreeMap<(Color, usize), u8> = BTreeMap::new();
    let width = image.width.max(1) as usize;
    let index = |(k, rgb): (usize, &[u8])| {
        let color = [rgb[0], rgb[1], rgb[2]];
        let cell = k / width % 4 * 4 + k % width % 4;
        let dithered = || {
            nearest(
                &palette,
                color.map(|c| f64::from(c) + DITHER * THRESHOLDS[cell]),
            )
        };
        match exact.get(&color) {
            Some(index) => *index,
            None => *near.entry((color, cell)).or_insert_with(dithered),
        }
    };
    let indices = image.rgb.chunks_exact(3).enumerate().map(index).collect();
    IndexedImage { palette, indices }
}

/// Amplitude of the ordered dither that hides the steps between palette colours.
const DITHER: f64 = 3.0;

/// Bayer's matrix of four by four, from -1 to 1.
const THRESHOLDS: [f64; 16] = {
    let order = [0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5];
    let mut matrix = [0.0; 16];
    let mut k = 0;
    while k < 16 {
        matrix[k] = (order[k] as f64 - 7.5) / 7.5;
        k += 1;
    }
    matrix
};

/// The sum of squared deviations from the mean in the channel where it is largest, and that channel.
fn spread(group: &[WeightedColor]) -> (f64, usize) {
    let channel_spread = |channel: usize| {
        let sum = |f: &dyn Fn(f64) -> f64| -> f64 {
            group
                .iter()
                .map(|(c, w)| w * f(f64::from(c[channel])))
                .sum()
        };
        let (weight, first) = (sum(&|_| 1.0), sum(&|x| x));
        (sum(&|x| x * x) - first * first / weight, channel)
    };
    let widest = (0..3)
        .map(channel_spread)
        .max_by(|a, b| a.0.total_cmp(&b.0));
    // A single colour would leave only rounding errors.
    widest.filter(|_| group.len() > 1).unwrap_or((0.0, 0))
}

/// Splits a group of two colours or more at the mean of its widest channel.
fn split(mut group: Vec<WeightedColor>) -> (Vec<WeightedColor>, Vec<WeightedColor>) {
    let (_, channel) = spread(&group);
    group.sort_by_key(|(color, _)| (color[channel], *color));
    let weight: f64 = group.iter().map(|(_, w)| w).sum();
    let sum: f64 = group.iter().map(|(c, w)| w * f64::from(c[channel])).sum();
    let at = group.partition_point(|(c, _)| f64::from(c[channel]) <= sum / weight);
    let high = group.split_off(at.clamp(1, group.len() - 1));
    (group, high)
}

fn mean(group: &[WeightedColor]) -> Color {
    let weight: f64 = group.iter().map(|(_, w)| w).sum();
    [0, 1, 2].map(|channel| {
        let sum: f64 = group.iter().map(|(c, w)| w * f64::from(c[channel])).sum();
        (sum / weight.max(f64::MIN_POSITIVE)).round() as u8
    })
}

fn nearest(palette: &[Color], color: [f64; 3]) -> u8 {
    let distance = |other: &Color| -> f64 {
        let channels = std::iter::zip(color, *other);
        channels.map(|(a, b)| (a - f64::from(b)).powi(2)).sum()
    };
    let distances = palette.iter().map(distance).zip(0..=255);
    let nearest = distances.min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map_or(0, |(_, k)| k)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(rgb: Vec<u8>) -> Vec<Color> {
        let width = rgb.len() as u32 / 3;
        let reduced = reduce(&RgbImage {
            width,
            height: 1,
            rgb,
        });
        reduced
            .indices
            .iter()
            .map(|i| reduced.palette[usize::from(*i)])
            .collect()
    }

    #[test]
    fn few_colours_stay_as_they_are() {
        let rgb = [[255; 3], [0; 3], [255; 3], [200, 10, 30]];
        assert_eq!(shown(rgb.concat()), rgb);
    }

    #[test]
    fn many_colours_become_those_near_them() {
        let ramp = |k: u32| [(k / 4) as u8, 255 - (k / 4) as u8, (k % 64) as u8];
        let rgb: Vec<[u8; 3]> = (0..1024).map(ramp).collect();
        for (color, expected) in shown(rgb.concat()).iter().zip(&rgb) {
            let off = (0..3).map(|c| color[c].abs_diff(expected[c])).max();
            assert!(off <= Some(16), "{color:?} {expected:?}");
        }
    }
}
