//! Linear RGB triples: reflectance, radiance, irradiance.

use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, Index, IndexMut, Mul, MulAssign, Sub};

/// Three numbers per quantity: red, green, blue, linear.
///
/// The unit is the quantity's: dimensionless for reflectance, W/(sr·m²) for radiance, W/m² for
/// irradiance, exitance and radiosity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rgb {
    /// Red.
    pub r: f64,
    /// Green.
    pub g: f64,
    /// Blue.
    pub b: f64,
}

impl Rgb {
    /// No light at all.
    pub const BLACK: Rgb = Rgb::grey(0.0);
    /// One in every channel.
    pub const WHITE: Rgb = Rgb::grey(1.0);

    /// Three channels.
    pub const fn new(r: f64, g: f64, b: f64) -> Rgb {
        Rgb { r, g, b }
    }

    /// The same value in every channel.
    pub const fn grey(value: f64) -> Rgb {
        Rgb {
            r: value,
            g: value,
            b: value,
        }
    }

    /// Applies `f` to each channel.
    pub fn map(self, f: impl Fn(f64) -> f64) -> Rgb {
        Rgb::new(f(self.r), f(self.g), f(self.b))
    }

    /// The largest channel.
    pub fn max_channel(self) -> f64 {
        self.r.max(self.g).max(self.b)
    }

    /// The plain mean of the channels, the weight-free grey used for error estimates.
    pub fn mean(self) -> f64 {
        (self.r + self.g + self.b) / 3.0
    }

    /// Relative luminance, ITU-R BT.709 primaries.
    pub fn luminance(self) -> f64 {
        0.2126 * self.r + 0.7152 * self.g + 0.0722 * self.b
    }

    /// Whether every channel is exactly zero.
    pub fn is_black(self) -> bool {
        self == Rgb::BLACK
    }

    /// Whether all channels are equal.
    pub fn is_grey(self) -> bool {
        self.r == self.g && self.g == self.b
    }

    /// Whether no channel is NaN or infinite.
    pub fn is_finite(self) -> bool {
        self.r.is_finite() && self.g.is_finite() && self.b.is_finite()
    }

    /// Red, green, blue.
    pub const fn to_array(self) -> [f64; 3] {
        [self.r, self.g, self.b]
    }

    /// Red, green, blue as image values.
    pub fn to_f32(self) -> [f32; 3] {
        [self.r as f32, self.g as f32, self.b as f32]
    }
}

impl From<[f64; 3]> for Rgb {
    fn from([r, g, b]: [f64; 3]) -> Rgb {
        Rgb { r, g, b }
    }
}

impl Index<usize> for Rgb {
    type Output = f64;
    #[inline]
    fn index(&self, channel: usize) -> &f64 {
        match channel {
            0 => &self.r,
            1 => &self.g,
            2 => &self.b,
            _ => panic!("an Rgb has channels 0, 1 and 2, not {channel}"),
        }
    }
}

impl IndexMut<usize> for Rgb {
    #[inline]
    fn index_mut(&mut self, channel: usize) -> &mut f64 {
        match channel {
            0 => &mut self.r,
            1 => &mut self.g,
            2 => &mut self.b,
            _ => panic!("an Rgb has channels 0, 1 and 2, not {channel}"),
        }
    }
}

impl Add for Rgb {
    type Output = Rgb;
    fn add(self, o: Rgb) -> Rgb {
        Rgb::new(self.r + o.r, self.g + o.g, self.b + o.b)
    }
}

impl Sub for Rgb {
    type Output = Rgb;
    fn sub(self, o: Rgb) -> Rgb {
        Rgb::new(self.r - o.r, self.g - o.g, self.b - o.b)
    }
}

impl Mul for Rgb {
    type Output = Rgb;
    fn mul(self, o: Rgb) -> Rgb {
        Rgb::new(self.r * o.r, self.g * o.g, self.b * o.b)
    }
}

impl Mul<f64> for Rgb {
    type Output = Rgb;
    fn mul(self, k: f64) -> Rgb {
        Rgb::new(self.r * k, self.g * k, self.b * k)
    }
}

impl Mul<Rgb> for f64 {
    type Output = Rgb;
    fn mul(self, c: Rgb) -> Rgb {
        c * self
    }
}

impl Div<f64> for Rgb {
    type Output = Rgb;
    fn div(self, k: f64) -> Rgb {
        Rgb::new(self.r / k, self.g / k, self.b / k)
    }
}

impl AddAssign for Rgb {
    fn add_assign(&mut self, o: Rgb) {
        *self = *self + o;
    }
}

impl MulAssign<f64> for Rgb {
    fn mul_assign(&mut self, k: f64) {
        *self = *self * k;
    }
}

impl MulAssign for Rgb {
    fn mul_assign(&mut self, o: Rgb) {
        *self = *self * o;
    }
}

impl Sum for Rgb {
    fn sum<I: Iterator<Item = Rgb>>(iter: I) -> Rgb {
        iter.fold(Rgb::BLACK, |a, b| a + b)
    }
}
