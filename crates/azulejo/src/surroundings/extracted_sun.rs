//! The sun in a picture of the surroundings, as a light of its own.

use azulejo_scene::sky::SUN_HALF_ANGLE;
use azulejo_scene::{Image, Projection, Rgb};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Least radiance of the sun's pixels, as a multiple of the median over the sphere.
const LEAST_CONTRAST: f64 = 30.0;

/// Least radiance of the sun's pixels, as a share of the brightest one: what is darker is its halo.
const LEAST_SHARE: f64 = 0.02;

/// Largest half angle of what is taken for the sun, radians.
const MOST_HALF_ANGLE: f64 = 1.5 * PI / 180.0;

/// Each pixel is integrated over this many points squared.
const POINTS: u32 = 4;

/// A sun that was taken out of a picture of the surroundings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExtractedSun {
    /// Unit, toward it, in the frame of the environment.
    pub toward: DVec3,
    /// Irradiance of what faces it, in the unit of the picture.
    pub irradiance: Rgb,
    /// Half of the angle that its pixels subtend, radians; at least that of the sun.
    pub half_angle: f64,
    /// Number of its pixels.
    pub pixels: usize,
}

/// Takes the sun out of a picture: the brightest pixel and what is connected to it and far above the
/// median, if that is no wider than 3 degrees. Its pixels become the mean of those around them.
///
/// The light is that of what was taken away, integrated over the pixels, so that every surface that sees
/// the whole sun receives what it did before.
///
/// # Errors
/// Why there is none; the picture is then unchanged.
pub fn extract_sun(image: &mut Image, projection: Projection) -> Result<ExtractedSun, String> {
    let sphere = PixelSphere {
        width: image.width as usize,
        height: image.height as usize,
        projection,
    };
    let luminance: Vec<f64> = image
        .pixels
        .iter()
        .map(|p| p.iter().map(|v| f64::from(*v)).sum::<f64>() / 3.0)
        .collect();
    // The sun stands out far from the median of the sphere; pixels outside an angular map do not count.
    let seen = |k: &usize| sphere.solid_angle(*k) > 0.0;
    let brightest = (0..luminance.len())
        .filter(seen)
        .max_by(|&a, &b| luminance[a].total_cmp(&luminance[b]).then(b.cmp(&a)));
    let brightest = brightest.ok_or("the picture has no pixels")?;
    let (peak, median) = (luminance[brightest], sphere.median(&luminance));
    if peak <= LEAST_CONTRAST * median || peak <= 0.0 {
        return Err(format!(
            "the brightest pixel has {:.3} times the median radiance, expected more than {LEAST_CONTRAST}",
            peak / median.max(f64::MIN_POSITIVE)
        ));
    }
    // Its disc is what is connected to the brightest pixel and bright enough, unless that is too wide.
    let least = (LEAST_CONTRAST * median).max(LEAST_SHARE * peak);
    let disc = sphere.connected(brightest, |k| luminance[k] > least);
    let size: f64 = disc.iter().map(|&k| sphere.solid_angle(k)).sum();
    let half_angle = (1.0 - size / TAU).clamp(-1.0, 1.0).acos();
    if half_angle > MOST_HALF_ANGLE {
        return Err(format!(
            "what is brightest is {:.2} degrees wide, expected at most {:.0}",
            2.0 * half_angle.to_degrees(),
            2.0 * MOST_HALF_ANGLE.to_degrees()
        ));
    }
    // Behind the disc the surroundings go on as they are around it.
    let around = sphere.around(&disc);
    let fill: [f32; 3] = std::array::from_fn(|c| {
        let sum: f64 = around.iter().map(|&k| f64::from(image.pixels[k][c])).sum();
        (sum / around.len().max(1) as f64) as f32
    });
    // Integrate what is taken away times its direction: what faces the sun keeps its irradiance.
    let mut vectors = [DVec3::ZERO; 3];
    for &k in &disc {
        let direction = sphere.vector(k);
        for (c, vector) in vectors.iter_mut().enumerate() {
            *vector += f64::from(image.pixels[k][c] - fill[c]) * direction;
        }
    }
    let toward = vectors.iter().sum::<DVec3>().try_normalize();
    let toward = toward.ok_or("what is brightest is no brighter than what is around it")?;
    disc.iter().for_each(|&k| image.pixels[k] = fill);
    Ok(ExtractedSun {
        toward,
        irradiance: Rgb::from(vectors.map(|v| v.dot(toward).max(0.0))),
        half_angle: half_angle.max(SUN_HALF_ANGLE),
        pixels: disc.len(),
    })
}

/// The pixels of a picture on the sphere.
struct PixelSphere {
    width: usize,
    height: usize,
    projection: Projection,
}

impl PixelSphere {
    /// The integral of the direction over a pixel; its length is nearly its solid angle.
    fn vector(&self, pixel: usize) -> DVec3 {
        let (column, row) = (pixel % self.width, pixel / self.width);
        let place = |k: usize, step: u32, of: usize| {
            (k as f64 + (f64::from(step) + 0.5) / f64::from(POINTS)) / of as f64
        };
        let share = 1.0 / f64::from(POINTS * POINTS);
        let mut sum = DVec3::ZERO;
        for step in 0..POINTS * POINTS {
            let u = place(column, step % POINTS, self.width);
            let v = place(row, step / POINTS, self.height);
            sum += share * self.density(u, v) * self.projection.direction(u, v);
        }
        sum
    }

    /// Solid angle of a pixel, sr; 0 outside of an angular map.
    fn solid_angle(&self, pixel: usize) -> f64 {
        let (column, row) = (pixel % self.width, pixel / self.width);
        let middle = |k: usize, of: usize| (k as f64 + 0.5) / of as f64;
        self.density(middle(column, self.width), middle(row, self.height))
    }

    /// Solid angle of a pixel by the density at a place in the picture.
    fn density(&self, u: f64, v: f64) -> f64 {
        let share = 1.0 / (self.width * self.height) as f64;
        match self.projection {
            Projection::Equirectangular => share * TAU * PI * (PI * v).sin(),
            Projection::AngularMap => {
                let angle = PI * (2.0 * u - 1.0).hypot(1.0 - 2.0 * v);
                match angle {
                    a if a > PI => 0.0,
                    // The area of the picture is 4 in units of its half side.
                    a if a > 0.0 => share * 4.0 * PI * PI * a.sin() / a,
                    _ => share * 4.0 * PI * PI,
                }
            }
        }
    }

    /// The median by solid angle.
    fn median(&self, values: &[f64]) -> f64 {
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        let whole: f64 = order.iter().map(|&k| self.solid_angle(k)).sum();
        let mut sum = 0.0;
        let middle = order.iter().find(|&&k| {
            sum += self.solid_angle(k);
            sum >= 0.5 * whole
        });
        middle.map_or(0.0, |&k| values[k])
    }

    /// The up to eight pixels around one; an equirectangular picture goes on at its sides.
    fn neighbours(&self, pixel: usize) -> impl Iterator<Item = usize> + '_ {
        let (column, row) = ((pixel % self.width) as i64, (pixel / self.width) as i64);
        let (width, height) = (self.width as i64, self.height as i64);
        let wraps = self.projection == Projection::Equirectangular;
        let steps = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
        steps.filter(|s| *s != (0, 0)).filter_map(move |(dx, dy)| {
            let (x, y) = (column + dx, row + dy);
            let x = if wraps { x.rem_euclid(width) } else { x };
            let is_inside = (0..width).contains(&x) && (0..height).contains(&y);
            is_inside.then(|| (y * width + x) as usize)
        })
    }

    /// The pixels that are connected to one, in ascending order.
    fn connected(&self, first: usize, belongs: impl Fn(usize) -> bool) -> Vec<usize> {
        let mut known = vec![false; self.width * self.height];
        let (mut pixels, mut next) = (Vec::new(), vec![first]);
        known[first] = true;
        while let Some(pixel) = next.pop() {
            pixels.push(pixel);
            for other in self.neighbours(pixel) {
                if !known[other] && belongs(other) {
                    known[other] = true;
                    next.push(other);
                }
            }
        }
        pixels.sort_unstable();
        pixels
    }

    /// The pixels that touch some, in ascending order.
    fn around(&self, pixels: &[usize]) -> Vec<usize> {
        let others = pixels.iter().flat_map(|&k| self.neighbours(k));
        let mut around: Vec<usize> = others
            .filter(|k| pixels.binary_search(k).is_err() && self.solid_angle(*k) > 0.0)
            .collect();
        around.sort_unstable();
        around.dedup();
        around
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sky that is brighter above, with a bright disc of this half angle around a direction.
    fn picture(projection: Projection, toward: DVec3, half_angle: f64, radiance: f32) -> Image {
        let (width, height) = match projection {
            Projection::Equirectangular => (1024, 512),
            Projection::AngularMap => (800, 800),
        };
        let pixel = |k: u32| {
            let (x, y) = (f64::from(k % width) + 0.5, f64::from(k / width) + 0.5);
            let d = projection.direction(x / f64::from(width), y / f64::from(height));
            let sky = (1.0 + 0.5 * d.z) as f32;
            let is_sun = d.angle_between(toward) < half_angle;
            if is_sun {
                [radiance, 0.9 * radiance, 0.7 * radiance]
            } else {
                [sky; 3]
            }
        };
        Image::opaque(width, height, (0..width * height).map(pixel).collect())
    }

    /// Irradiance of a plane by a picture.
    fn irradiance(image: &Image, projection: Projection, normal: DVec3) -> Rgb {
        let sphere = PixelSphere {
            width: image.width as usize,
            height: image.height as usize,
            projection,
        };
        let of = |k: usize| {
            let cosine = sphere.vector(k).dot(normal).max(0.0);
            Rgb::from(image.pixels[k].map(f64::from)) * cosine
        };
        (0..image.pixels.len())
            .map(of)
            .fold(Rgb::BLACK, |a, b| a + b)
    }

    #[test]
    fn a_sun_is_taken_out_and_no_energy_is_lost() {
        let toward = DVec3::new(0.5, 0.3, 0.8).normalize();
        for projection in [Projection::Equirectangular, Projection::AngularMap] {
            let half_angle = 1f64.to_radians();
            let mut image = picture(projection, toward, half_angle, 20_000.0);
            let before = irradiance(&image, projection, DVec3::Z);
            let sun = extract_sun(&mut image, projection).unwrap();
            assert!(
                sun.toward.angle_between(toward) < 0.1f64.to_radians(),
                "{sun:?}"
            );
            assert!((sun.half_angle / half_angle - 1.0).abs() < 0.1, "{sun:?}");
            let after = irradiance(&image, projection, DVec3::Z);
            let sum = after + sun.irradiance * sun.toward.z;
            let off = (sum - before).map(|c| c.abs()).max_channel() / before.max_channel();
            assert!(off < 1e-4, "{projection:?}: {before:?}, {sum:?}");
            assert!(after.max_channel() < 6.0, "{after:?}");
            let exact = 20_000.0 * PI * half_angle.sin().powi(2);
            assert!(
                (sun.irradiance.r / exact - 1.0).abs() < 0.15,
                "{sun:?} {exact}"
            );
        }
    }

    #[test]
    fn one_pixel_at_the_side_is_a_sun() {
        let mut image = picture(
            Projection::Equirectangular,
            DVec3::NEG_X,
            0.3f64.to_radians(),
            9e4,
        );
        let sun = extract_sun(&mut image, Projection::Equirectangular).unwrap();
        assert!(sun.half_angle >= SUN_HALF_ANGLE && sun.toward.x < -0.999);
    }

    #[test]
    fn no_sun() {
        let refuse = |half_angle: f64, radiance: f32, part: &str| {
            let mut image = picture(Projection::Equirectangular, DVec3::Z, half_angle, radiance);
            let given = image.clone();
            let message = extract_sun(&mut image, Projection::Equirectangular).unwrap_err();
            assert!(message.contains(part), "{message}");
            assert!(image == given);
        };
        refuse(0.02, 20.0, "times the median");
        refuse(0.2, 20_000.0, "degrees wide");
    }
}
