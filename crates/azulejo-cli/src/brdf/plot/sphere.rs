//! A sphere of the material under a square area light.

use super::{Panel, PlotSubject, in_order};
use crate::drawing::{Drawing, FAINT, RgbImage, TextAnchor};
use crate::failure::Failure;
use azulejo_render::{Tone, srgb_from_linear};
use azulejo_scene::{Brdf, Rgb};
use azulejo_trace::sampling::{SobolTable, seeds};
use glam::{DVec2, DVec3};

/// Samples of the lamp, and of the model, per round.
const ROUND: usize = 32;

/// Largest number of rounds at a point.
const ROUNDS: usize = 32;

/// Number of rounds from which their spread is estimated.
const LEAST: usize = 4;

/// Points per pixel, in either direction, for perfect specular reflection.
const PLACES: u32 = 4;

/// The standard error at which a point is finished, of a displayed value of 1.
const GOOD: f64 = 0.0015;

/// The lamp: a square that faces the sphere.
struct SquareLamp {
    center: DVec3,
    /// Half the length of its sides.
    sides: [DVec3; 2],
    normal: DVec3,
    area: f64,
    radiance: f64,
}

impl SquareLamp {
    /// To the left, above, and in front of the sphere, whose radius is 1.
    fn new() -> SquareLamp {
        let center = DVec3::new(-2.2, 2.6, 2.6);
        let normal = -center.normalize();
        let across = DVec3::Y.cross(normal).normalize();
        let half = 0.75;
        SquareLamp {
            center,
            sides: [across * half, normal.cross(across) * half],
            normal,
            area: 4.0 * half * half,
            radiance: 15.0,
        }
    }

    /// Samples a point of it from two numbers in 0..1.
    fn point(&self, u: [f64; 2]) -> DVec3 {
        let [a, b] = u.map(|u| 2.0 * u - 1.0);
        self.center + a * self.sides[0] + b * self.sides[1]
    }

    /// Density of its points as directions from `from`, 1/sr; `None` where it is not visible.
    fn density(&self, from: DVec3, direction: DVec3) -> Option<f64> {
        let cos = -direction.dot(self.normal);
        let along = (self.center - from).dot(self.normal) / direction.dot(self.normal);
        if !(cos > 0.0 && along > 0.0) {
            return None;
        }
        let off = from + along * direction - self.center;
        let inside = |side: DVec3| off.dot(side).abs() <= side.length_squared();
        let met = self.sides.iter().all(|s| inside(*s));
        met.then(|| along * along / (cos * self.area))
    }
}

/// A point of the sphere in a model's frame: tangents run around the vertical axis.
struct SpherePoint {
    at: DVec3,
    tangent: DVec3,
    bitangent: DVec3,
    /// To the viewer, who is far away in front.
    wo: DVec3,
}

impl SpherePoint {
    /// The point of the sphere that is visible at a point of the unit disk, or at its edge.
    fn seen_at(place: DVec2) -> SpherePoint {
        let place = place.clamp_length_max(0.9995);
        SpherePoint::new(place.extend((1.0 - place.length_squared()).sqrt()))
    }

    fn new(at: DVec3) -> SpherePoint {
        let tangent = DVec3::Y.cross(at).try_normalize().unwrap_or(DVec3::X);
        let mut spot = SpherePoint {
            at,
            tangent,
            bitangent: at.cross(tangent),
            wo: DVec3::Z,
        };
        spot.wo = spot.local(DVec3::Z);
        spot
    }

    fn local(&self, v: DVec3) -> DVec3 {
        DVec3::new(v.dot(self.tangent), v.dot(self.bitangent), v.dot(self.at))
    }

    fn world(&self, v: DVec3) -> DVec3 {
        v.x * self.tangent + v.y * self.bitangent + v.z * self.at
    }
}

/// The illumination of spheres of one model.
struct SphereScene<'a> {
    brdf: &'a Brdf,
    lamp: SquareLamp,
    points: SobolTable,
}

/// Light from the surroundings, without the lamp: a dark floor below, a sky that brightens upward.
fn surroundings(direction: DVec3) -> f64 {
    let above = ((direction.y + 0.06) / 0.12).clamp(0.0, 1.0);
    let sky = 0.12 + 0.33 * direction.y.max(0.0);
    0.045 + (sky - 0.045) * above * above * (3.0 - 2.0 * above)
}

/// Draws the panel.
pub fn draw(subject: &PlotSubject, panel: Panel, sheet: &mut Drawing) -> Result<(), Failure> {
    panel.head(
        "Sphere under a square lamp",
        "on a dark floor under a dim sky; tangents are horizontal",
        sheet,
    );
    let names = ["solid", "dashed"];
    let parts = panel.parts(subject.models.len());
    for ((brdf, part), name) in subject.models.iter().zip(&parts).zip(names) {
        let side = part.size.x.min(part.size.y) - 8.0;
        let corner = part.at + 0.5 * (part.size - DVec2::splat(side));
        let pixels = picture(subject, brdf, (side * subject.scale).round() as u32)?;
        sheet.image(corner, DVec2::splat(side), pixels);
        if parts.len() > 1 {
            let at = DVec2::new(part.at.x + 0.5 * part.size.x, corner.y + side + 14.0);
            sheet.text(at, TextAnchor::Middle, 11.0, FAINT, name);
        }
    }
    Ok(())
}

fn picture(subject: &PlotSubject, brdf: &Brdf, side: u32) -> Result<RgbImage, Failure> {
    let studio = SphereScene {
        brdf,
        lamp: SquareLamp::new(),
        points: SobolTable::new(ROUND * ROUNDS),
    };
    let rows = in_order(subject, "sphere", side as usize, |y| {
        let pixel = |x: u32| studio.pixel(x, y as u32, side);
        (0..side).flat_map(pixel).collect::<Vec<u8>>()
    })?;
    Ok(RgbImage {
        width: side,
        height: side,
        rgb: rows.concat(),
    })
}

impl SphereScene<'_> {
    /// One pixel of an image with this many on each side.
    fn pixel(&self, x: u32, y: u32, side: u32) -> [u8; 3] {
        // The sphere is the unit circle, with a little space around it.
        let at = |x: f64, y: f64| {
            let unit = 2.02 / f64::from(side);
            unit * (DVec2::new(x, y) - 0.5 * f64::from(side)) * DVec2::new(1.0, -1.0)
        };
        let middle = at(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let covered = 0.5 + (1.0 - middle.length()) * f64::from(side) / 2.02;
        if covered <= 0.0 {
            return [255; 3];
        }
        let mut light = self.scattered(&SpherePoint::seen_at(middle), [x, y]);
        for k in 0..PLACES * PLACES {
            let offset = |k: u32| (f64::from(k) + 0.5) / f64::from(PLACES);
            let place = at(
                f64::from(x) + offset(k % PLACES),
                f64::from(y) + offset(k / PLACES),
            );
            light += self.mirrored(&SpherePoint::seen_at(place)) / f64::from(PLACES * PLACES);
        }
        // Averaging displayed values instead of light keeps the edge of the sphere smooth.
        let covered = covered.min(1.0);
        let shown = Tone::Filmic.map(light).map(srgb_from_linear);
        let mixed = shown * covered + Rgb::grey(1.0 - covered);
        mixed.to_array().map(|c| (255.0 * c).round() as u8)
    }

    /// Light by perfect specular reflection.
    fn mirrored(&self, spot: &SpherePoint) -> Rgb {
        let reflectance = self.brdf.mirror(spot.wo.z);
        if reflectance.is_black() {
            return reflectance;
        }
        let wi = spot.world(DVec3::new(-spot.wo.x, -spot.wo.y, spot.wo.z));
        let lamp = self
            .lamp
            .density(spot.at, wi)
            .map_or(0.0, |_| self.lamp.radiance);
        reflectance * (lamp + surroundings(wi))
    }

    /// Light by the other parts, to the required standard error: samples of the lamp and of the
    /// model, combined by multiple importance sampling (Veach and Guibas 1995, the power
    /// heuristic).
    fn scattered(&self, spot: &SpherePoint, key: [u32; 2]) -> Rgb {
        let (mut sum, mut squares) = (Rgb::BLACK, 0.0);
        for round in 1..=ROUNDS {
            let radiance = self.round(spot, key, round - 1);
            sum += radiance;
            squares += radiance.mean().powi(2);
            let n = round as f64;
            let mean = sum.mean() / n;
            let error = ((squares / n - mean * mean).max(0.0) / (n - 1.0).max(1.0)).sqrt();
            // Bright light is compressed, so a proportionally larger error is invisible.
            if round >= LEAST && error < GOOD * (1.0 + 4.0 * mean) {
                return sum / n;
            }
        }
        sum / ROUNDS as f64
    }

    fn round(&self, spot: &SpherePoint, key: [u32; 2], round: usize) -> Rgb {
        let [lamp, model] = [0, 1].map(|k| seeds(&[key[0], key[1], k]));
        let mut sum = Rgb::BLACK;
        for k in round * ROUND..(round + 1) * ROUND {
            let [a, b, ..] = self.points.point(k, lamp).map(f64::from);
            sum += self.by_lamp(spot, [a, b]);
            let [a, b, c, _] = self.points.point(k, model).map(f64::from);
            sum += self.by_model(spot, [c, a, b]);
        }
        sum / ROUND as f64
    }

    fn by_lamp(&self, spot: &SpherePoint, u: [f64; 2]) -> Rgb {
        let direction = (self.lamp.point(u) - spot.at).normalize();
        let wi = spot.local(direction);
        let Some(density) = self.lamp.density(spot.at, direction).filter(|_| wi.z > 0.0) else {
            return Rgb::BLACK;
        };
        let other = self.brdf.pdf(spot.wo, wi);
        let light = self.lamp.radiance * power_weight(density, other) / density;
        self.brdf.eval(spot.wo, wi) * (wi.z * light)
    }

    fn by_model(&self, spot: &SpherePoint, u: [f64; 3]) -> Rgb {
        let Some(sample) = self.brdf.sample(spot.wo, u) else {
            return Rgb::BLACK;
        };
        let wi = spot.world(sample.wi);
        let lamp = self.lamp.density(spot.at, wi).map_or(0.0, |density| {
            self.lamp.radiance * power_weight(sample.pdf, density)
        });
        sample.weight * (lamp + surroundings(wi))
    }
}

fn power_weight(own: f64, other: f64) -> f64 {
    own * own / (own * own + other * other)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The irradiance at the point that the lamp faces, by both sampling techniques together,
    /// against the form factor of its polygon.
    #[test]
    fn a_matt_sphere_is_as_bright_as_the_form_factor_says() {
        let brdf = Brdf::new("diffuse kd = 1".parse().unwrap()).unwrap();
        let studio = |radiance: f64| SphereScene {
            brdf: &brdf,
            lamp: SquareLamp {
                radiance,
                ..SquareLamp::new()
            },
            points: SobolTable::new(ROUND * ROUNDS),
        };
        let spot = SpherePoint::new(-SquareLamp::new().normal);
        let height = SquareLamp::new().center.length() - 1.0;
        let x = 0.75 / height;
        let quarter = x / (1.0 + x * x).sqrt() * (x / (1.0 + x * x).sqrt()).atan();
        let factor = 4.0 * quarter / std::f64::consts::PI;
        let light = |radiance| studio(radiance).scattered(&spot, [1, 2]).r;
        let slope = (light(1000.0) - light(0.0)) / 1000.0;
        assert!((slope / factor - 1.0).abs() < 3e-3, "{slope} {factor}");
    }
}
