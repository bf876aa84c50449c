//! Colour maps with monotonic lightness, so that values can be distinguished with impaired
//! colour vision and in greyscale prints.

use crate::view::ColorMap;

// Colour tables as image programs read them: 256 times red, green and blue, sRGB, exported from
// matplotlib 3.11, and all CC0.

/// Smith and van der Walt 2015.
const VIRIDIS: &[u8; 768] = include_bytes!("color_map/viridis.act");
/// Nuñez, Anderton and Renslow, PLOS ONE 13(7), 2018.
const CIVIDIS: &[u8; 768] = include_bytes!("color_map/cividis.act");
/// Smith and van der Walt 2015.
const MAGMA: &[u8; 768] = include_bytes!("color_map/magma.act");

impl ColorMap {
    /// The sRGB colour of `t`, clamped to 0..=1; NaN counts as 0.
    pub fn color(self, t: f64) -> [u8; 3] {
        self.entry((t.clamp(0.0, 1.0) * 255.0).round() as u8)
    }

    /// All 256 colours as opaque RGBA.
    pub(super) fn texels(self) -> Vec<u8> {
        let texel = |i| {
            let [r, g, b] = self.entry(i);
            [r, g, b, 255]
        };
        (0..=255).flat_map(texel).collect()
    }

    fn entry(self, i: u8) -> [u8; 3] {
        let table = match self {
            ColorMap::Viridis => VIRIDIS,
            ColorMap::Cividis => CIVIDIS,
            ColorMap::Magma => MAGMA,
            ColorMap::Grey => return [i; 3],
        };
        table.as_chunks().0[usize::from(i)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variants::all;

    /// CIE lightness L* of an sRGB colour, D65.
    fn lightness(color: [u8; 3]) -> f64 {
        let linear = color.map(|x| {
            let x = f64::from(x) / 255.0;
            if x <= 0.04045 {
                x / 12.92
            } else {
                ((x + 0.055) / 1.055).powf(2.4)
            }
        });
        let y = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
        116.0 * y.cbrt() - 16.0
    }

    #[test]
    fn every_map_grows_lighter() {
        for map in all::<ColorMap>() {
            let light: Vec<f64> = (0..=16)
                .map(|k| lightness(map.color(f64::from(k) / 16.0)))
                .collect();
            assert!(
                light.windows(2).all(|w| w[1] > w[0] + 1.0),
                "{map:?} {light:?}"
            );
        }
    }

    #[test]
    fn ends_are_those_that_were_published() {
        assert_eq!(ColorMap::Viridis.color(0.0), [68, 1, 84]);
        assert_eq!(ColorMap::Viridis.color(2.0), [253, 231, 37]);
        assert_eq!(ColorMap::Cividis.color(f64::NAN), [0, 34, 78]);
        assert_eq!(ColorMap::Magma.color(1.0), [252, 253, 191]);
    }
}
