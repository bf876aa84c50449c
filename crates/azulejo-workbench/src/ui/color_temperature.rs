//! Colours of glowing bodies, by their temperatures.

use azulejo::formats::mgf::black_body_color;
use azulejo::scene::Rgb;

/// Temperatures that are told apart, K: colder bodies have no blue on a display.
pub const LEAST: f64 = 1_900.0;
pub const MOST: f64 = 20_000.0;

/// How far a colour may be from that of a glowing body, by its channels relative to its luminance.
const TOLERANCE: f64 = 0.12;

/// The correlated colour temperature of light, K: that of the body whose ratio of blue to red it
/// has; `None` for black, and where green does not fit.
pub fn of(light: Rgb) -> Option<f64> {
    let luminance = light.luminance();
    if !(luminance > 0.0 && light.r > 0.0) {
        return None;
    }
    let ratio = light.b / light.r;
    // The hotter, the bluer.
    let (mut cold, mut hot) = (LEAST, MOST);
    for _ in 0..60 {
        let middle = (cold * hot).sqrt();
        let color = black_body_color(middle)?;
        if color.b / color.r.max(f64::MIN_POSITIVE) < ratio {
            cold = middle;
        } else {
            hot = middle;
        }
    }
    let color = black_body_color(cold)?;
    let color = color / color.luminance().max(f64::MIN_POSITIVE);
    let light = light / luminance;
    let difference = (0..3).map(|k| (color[k] - light[k]).abs());
    (difference.fold(0.0, f64::max) < TOLERANCE).then_some(cold)
}

/// Light of a temperature with this luminance; `None` if there is no such temperature.
pub fn light_of(kelvin: f64, luminance: f64) -> Option<Rgb> {
    let color = black_body_color(kelvin)?;
    let own = color.luminance();
    (own > 0.0).then(|| color * (luminance / own))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_temperature_of_a_colour_gives_the_colour_back() {
        for kelvin in [2_200.0, 2_700.0, 4_000.0, 6_500.0, 12_000.0] {
            let light = light_of(kelvin, 42.0).unwrap();
            assert!((light.luminance() - 42.0).abs() < 1e-9);
            let kelvins = of(light).unwrap();
            assert!(
                (kelvins / kelvin - 1.0).abs() < 1e-3,
                "{kelvins} for {kelvin}"
            );
        }
        let white = of(Rgb::WHITE).unwrap();
        // The white of equal energy, as in MGF and in recipes.
        assert!((5_000.0..6_000.0).contains(&white), "{white}");
    }

    #[test]
    fn green_and_black_light_have_none() {
        assert_eq!(of(Rgb::new(0.1, 1.0, 0.1)), None);
        assert_eq!(of(Rgb::BLACK), None);
    }
}
