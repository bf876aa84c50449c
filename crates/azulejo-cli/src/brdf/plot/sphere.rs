//! A sphere of the material under a square area light.

use super::patches::{EDGE, SphereFunction, SpherePatches};
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

/// Key of the samples that are common to all points; errors of this one are small for most models.
const KEY: [u32; 2] = [5; 2];

/// Points per pixel, in either direction, for perfect specular reflection.
const PLACES: u32 = 4;

/// Width of the picture in radii of the sphere.
const WIDTH: f64 = 2.02;

/// The standard error of displayed values, 0 to 1, at which a point is finished, as far as rounds tell: together they are
/// stratified, so that the true one is a half or less.
const GOOD: f64 = 0.009;

/// The same for single pixels, whose errors are noise.
const GOOD_PIXEL: f64 = 0.004;

/// The largest accepted error of interpolated displayed values: one of 255 steps.
const NEAR: f64 = 0.004;

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
        let place = place.clamp_length_max(EDGE);
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
    let density = (f64::from(side) / WIDTH).powi(2);
    let patches = in_order(subject, "sphere", SpherePatches::COUNT, |k| {
        SpherePatches::part(k, &studio, density)
    })?;
    let patches = SpherePatches(patches);
    let rows = in_order(subject, "pixels", side as usize, |y| {
        let pixel = |x: u32| studio.pixel([x, y as u32], side, &patches);
        (0..side).flat_map(pixel).collect::<Vec<u8>>()
    })?;
    Ok(RgbImage {
        width: side,
        height: side,
        rgb: rows.concat(),
    })
}

impl SphereFunction for SphereScene<'_> {
    /// Light by the parts that scatter. The samples are the same everywhere, so that their error is smooth, too.
    fn at(&self, place: DVec2) -> Rgb {
        self.scattered(&SpherePoint::seen_at(place), KEY, GOOD)
    }

    fn is_near(&self, interpolated: Rgb, value: Rgb) -> bool {
        let off = shown(interpolated) - shown(value);
        off.map(f64::abs).max_channel() < NEAR
    }
}

/// Light as it is displayed, 0 to 1.
fn shown(light: Rgb) -> Rgb {
    Tone::Filmic.map(light).map(srgb_from_linear)
}

impl SphereScene<'_> {
    /// One pixel of an image with this many on each side.
    fn pixel(&self, [x, y]: [u32; 2], side: u32, patches: &SpherePatches) -> [u8; 3] {
        // The sphere is the unit circle, with a little space around it.
        let at = |x: f64, y: f64| {
            let unit = WIDTH / f64::from(side);
            unit * (DVec2::new(x, y) - 0.5 * f64::from(side)) * DVec2::new(1.0, -1.0)
        };
        let middle = at(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let covered = 0.5 + (1.0 - middle.length()) * f64::from(side) / WIDTH;
        if covered <= 0.0 {
            return [255; 3];
        }
        let scattered = || self.scattered(&SpherePoint::seen_at(middle), [x, y], GOOD_PIXEL);
        let mut light = patches.at(middle).unwrap_or_else(scattered);
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
        let mixed = shown(light) * covered + Rgb::grey(1.0 - covered);
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
    /// model, combined by multiple importance sampling (Veach and Guibas 1995).
    fn scattered(&self, spot: &SpherePoint, key: [u32; 2], good: f64) -> Rgb {
        let (mut sum, mut squares) = (Rgb::BLACK, 0.0);
        for round in 1..=ROUNDS {
            let radiance = self.round(spot, key, round - 1);
            sum += radiance;
            squares += radiance.mean().powi(2);
            let n = round as f64;
            let mean = sum.mean() / n;
            let error = ((squares / n - mean * mean).max(0.0) / (n - 1.0).max(1.0)).sqrt();
            let [low, high] = [mean, mean + error].map(|light| shown(Rgb::grey(light)).r);
            if round >= LEAST && high - low < good {
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
        let share = model_share(self.brdf.pdf(spot.wo, wi), density);
        let light = self.lamp.radiance * (1.0 - share) / density;
        self.brdf.eval(spot.wo, wi) * (wi.z * light)
    }

    fn by_model(&self, spot: &SpherePoint, u: [f64; 3]) -> Rgb {
        let Some(sample) = self.brdf.sample(spot.wo, u) else {
            return Rgb::BLACK;
        };
        let wi = spot.world(sample.wi);
        let lamp = self.lamp.density(spot.at, wi).map_or(0.0, |density| {
            self.lamp.radiance * model_share(sample.pdf, density)
        });
        sample.weight * (lamp + surroundings(wi))
    }
}

/// The weight of the model's samples in the light of the lamp, for the densities of both techniques. The edges of the
/// lamp make this light rough, so the lamp's own samples get all of it unless the model's are denser.
fn model_share(model: f64, lamp: f64) -> f64 {
    let over = (model / lamp - 1.0).max(0.0);
    over * over / (1.0 + over * over)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn studio(brdf: &Brdf, radiance: f64) -> SphereScene<'_> {
        SphereScene {
            brdf,
            lamp: SquareLamp {
                radiance,
                ..SquareLamp::new()
            },
            points: SobolTable::new(ROUND * ROUNDS),
        }
    }

    /// Interpolated light against that of single points, at every seventh pixel of a picture.
    #[test]
    fn interpolated_points_are_as_bright_as_others() {
        for text in [
            "diffuse kd = (0.8, 0.5, 0.3)",
            "ggx_smith ax = 0.1 ay = 0.4 metal = gold",
            "ggx_smith ax = 3",
            "cook_torrance m = 0.3 metal = copper",
            "phong kd = 0.1 ks = 0.5 n = 1e5",
        ] {
            let brdf = Brdf::new(text.parse().unwrap()).unwrap();
            let (studio, side) = (studio(&brdf, 15.0), 128);
            let density = (f64::from(side) / WIDTH).powi(2);
            let part = |k| SpherePatches::part(k, &studio, density);
            let patches = SpherePatches((0..SpherePatches::COUNT).map(part).collect());
            let (mut squares, mut worst, mut count) = (0.0, 0.0f64, 0.0);
            for k in (0..side * side).step_by(7) {
                let at = |k: u32| WIDTH * ((f64::from(k) + 0.5) / f64::from(side) - 0.5);
                let (x, y) = (k % side, k / side);
                let place = DVec2::new(at(x), at(y));
                let Some(light) = patches.at(place).filter(|_| place.length() < EDGE) else {
                    continue;
                };
                let other = studio.scattered(&SpherePoint::seen_at(place), [x, y], GOOD_PIXEL);
                let off = (shown(light) - shown(other)).map(f64::abs).max_channel();
                worst = worst.max(off);
                squares += off * off;
                count += 1.0;
            }
            let root = (squares / f64::max(count, 1.0)).sqrt();
            assert!(root < 0.005 && worst < 0.025, "{text}: {root} {worst}");
            assert!(count > 500.0, "{text}: {count} interpolated");
        }
    }

    /// The irradiance at the point that the lamp faces, by both sampling techniques together,
    /// against the form factor of its polygon.
    #[test]
    fn a_matt_sphere_is_as_bright_as_the_form_factor_says() {
        let brdf = Brdf::new("diffuse kd = 1".parse().unwrap()).unwrap();
        let spot = SpherePoint::new(-SquareLamp::new().normal);
        let height = SquareLamp::new().center.length() - 1.0;
        let x = 0.75 / height;
        let quarter = x / (1.0 + x * x).sqrt() * (x / (1.0 + x * x).sqrt()).atan();
        let factor = 4.0 * quarter / std::f64::consts::PI;
        let light = |radiance| {
            studio(&brdf, radiance)
                .scattered(&spot, [1, 2], GOOD_PIXEL)
                .r
        };
        let slope = (light(1000.0) - light(0.0)) / 1000.0;
        assert!((slope / factor - 1.0).abs() < 3e-3, "{slope} {factor}");
    }
}
