//! Light from infinitely far away that depends on the direction: pictures of the surroundings,
//! skies, and suns that subtend an angle.

use super::direction_table::DirectionTable;
use crate::sampling::concentric_disk;
use azulejo_scene::math::Frame;
use azulejo_scene::{Environment, Image, LightKind, Rgb, Scene};
use glam::DVec3;
use std::f64::consts::PI;

/// All light that arrives from outside, but for what is the same from all directions and for
/// suns without size. Immutable; shared by all threads.
pub struct Outside<'a> {
    environments: Vec<EnvironmentLight<'a>>,
    pub(crate) suns: Vec<SunDisc>,
    /// Sum of the shares of the environments and the suns up to each.
    ends: Vec<f64>,
}

/// An environment that gives light.
struct EnvironmentLight<'a> {
    environment: Environment,
    image: Option<&'a Image>,
    table: DirectionTable,
    /// Share of the samples of all that is outside.
    share: f64,
}

/// A disc of the sky that shines, such as the sun: the same radiance all over it.
pub(crate) struct SunDisc {
    /// Its frame: z toward its centre.
    frame: Frame,
    /// Irradiance on a surface that faces it, W/m².
    pub irradiance: Rgb,
    /// Radiance, W/(sr·m²).
    pub radiance: Rgb,
    /// Sine of half the angle that it subtends.
    sine: f64,
    share: f64,
}

/// A direction in which something outside shines.
#[derive(Clone, Copy, Debug)]
pub struct OutsideSample {
    /// Unit, toward what shines.
    pub direction: DVec3,
    /// Radiance that arrives if nothing stands between, W/(sr·m²).
    pub radiance: Rgb,
    /// Density of the sample over solid angle, 1/sr.
    pub pdf: f64,
}

impl<'a> Outside<'a> {
    pub(super) fn new(scene: &'a Scene) -> Outside<'a> {
        let mut environments: Vec<EnvironmentLight> = Vec::new();
        let mut suns = Vec::new();
        for light in &scene.lights {
            match light.kind {
                LightKind::Environment(environment) => {
                    let uneven = environment.split_even().1;
                    environments.extend(EnvironmentLight::new(scene, uneven));
                }
                LightKind::Directional {
                    direction,
                    irradiance,
                    half_angle,
                } if half_angle > 0.0 && !irradiance.is_black() => {
                    suns.push(SunDisc::new(-direction, irradiance, half_angle));
                }
                _ => {}
            }
        }
        let shares = environments.iter_mut().map(|e| &mut e.share);
        let shares = shares.chain(suns.iter_mut().map(|s| &mut s.share));
        let mut shares: Vec<&mut f64> = shares.collect();
        let total: f64 = shares.iter().map(|share| **share).sum();
        let mut sum = 0.0;
        let up_to = |share: &mut &mut f64| {
            **share /= total;
            sum += **share;
            sum
        };
        Outside {
            ends: shares.iter_mut().map(up_to).collect(),
            environments,
            suns,
        }
    }

    /// Whether nothing outside shines.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Whether there are environments.
    pub fn has_environments(&self) -> bool {
        !self.environments.is_empty()
    }

    /// Radiance of the environments from a unit direction of the world, W/(sr·m²).
    pub fn environment(&self, direction: DVec3) -> Rgb {
        let radiance = |e: &EnvironmentLight| e.environment.radiance(direction, e.image);
        self.environments.iter().map(radiance).sum()
    }

    /// As [`environment`](Outside::environment), between pixels interpolated, with the discs of
    /// suns: what a camera sees.
    pub fn seen(&self, direction: DVec3) -> Rgb {
        let radiance = |e: &EnvironmentLight| e.environment.seen(direction, e.image);
        self.environments.iter().map(radiance).sum::<Rgb>() + self.sun(direction)
    }

    /// Radiance of environments and suns, W/(sr·m²).
    pub fn radiance(&self, direction: DVec3) -> Rgb {
        self.environment(direction) + self.sun(direction)
    }

    fn sun(&self, direction: DVec3) -> Rgb {
        let seen = self.suns.iter().filter(|s| s.contains(direction));
        seen.map(|s| s.radiance).sum()
    }

    /// A direction for three numbers in 0..1, in proportion to radiance where pictures and skies
    /// are tabulated; `None` if there is nothing outside.
    pub fn sample(&self, u: [f64; 3]) -> Option<OutsideSample> {
        let last = self.ends.len().checked_sub(1)?;
        let chosen = self.ends.partition_point(|&end| end <= u[0]).min(last);
        let direction = match self.environments.get(chosen) {
            Some(light) => light.sample([u[1], u[2]]),
            None => self.suns[chosen - self.environments.len()].sample([u[1], u[2]]),
        };
        let pdf = self.pdf(direction);
        (pdf > 0.0).then(|| OutsideSample {
            direction,
            radiance: self.radiance(direction),
            pdf,
        })
    }

    /// Density, 1/sr, of [`sample`](Outside::sample).
    pub fn pdf(&self, direction: DVec3) -> f64 {
        let sky = |e: &EnvironmentLight| e.share * e.pdf(direction);
        let sun = |s: &SunDisc| s.share * s.pdf(direction);
        self.environments.iter().map(sky).sum::<f64>() + self.suns.iter().map(sun).sum::<f64>()
    }

    /// A direction for three numbers in 0..1 in which the environments shine, in proportion to
    /// their radiance, and its density, 1/sr. `None` if there are none.
    pub fn sample_environment(&self, u: [f64; 3]) -> Option<(DVec3, f64)> {
        let last = self.environments.len().checked_sub(1)?;
        let chance = u[0] * self.ends[last];
        let chosen = self.ends[..last].partition_point(|&end| end <= chance);
        let direction = self.environments[chosen].sample([u[1], u[2]]);
        Some((direction, self.environment_pdf(direction)))
    }

    /// Density, 1/sr, of [`sample_environment`](Outside::sample_environment).
    pub(crate) fn environment_pdf(&self, direction: DVec3) -> f64 {
        let Some(last) = self.environments.len().checked_sub(1) else {
            return 0.0;
        };
        let sky = |e: &EnvironmentLight| e.share * e.pdf(direction);
        self.environments.iter().map(sky).sum::<f64>() / self.ends[last]
    }

    /// Integral of the radiance of all environments over the sphere, W/m².
    pub fn total(&self) -> Rgb {
        self.environments.iter().map(|e| e.table.total()).sum()
    }
}

impl<'a> EnvironmentLight<'a> {
    /// `None` if it is black, or its picture is missing.
    fn new(scene: &'a Scene, environment: Environment) -> Option<EnvironmentLight<'a>> {
        let texture = environment.texture();
        let image = texture.and_then(|id| scene.textures.get(id as usize)?.image.as_ref());
        let table = DirectionTable::new(&environment, image)?;
        Some(EnvironmentLight {
            environment,
            image,
            share: table.total().mean(),
            table,
        })
    }

    fn sample(&self, u: [f64; 2]) -> DVec3 {
        self.environment.world_from_environment * self.table.sample(u)
    }

    fn pdf(&self, direction: DVec3) -> f64 {
        self.table.pdf(self.environment.to_local(direction))
    }
}

impl SunDisc {
    fn new(toward: DVec3, irradiance: Rgb, half_angle: f64) -> SunDisc {
        let sine = half_angle.sin();
        // A disc of radiance L that is faced gives π L sin² of half its angle.
        SunDisc {
            frame: Frame::from_normal(toward),
            irradiance,
            radiance: irradiance / (PI * sine * sine),
            sine,
            share: irradiance.mean(),
        }
    }

    /// Unit, toward its centre.
    pub fn toward(&self) -> DVec3 {
        self.frame.z
    }

    /// Sine of half the angle that it subtends.
    pub fn sine(&self) -> f64 {
        self.sine
    }

    /// A direction of the disc, in proportion to the cosine of the angle to its centre: equal
    /// shares of its irradiance on a surface that faces it.
    pub fn sample(&self, u: [f64; 2]) -> DVec3 {
        let (x, y) = concentric_disk(u[0], u[1]);
        let (x, y) = (x * self.sine, y * self.sine);
        let z = (1.0 - x * x - y * y).sqrt();
        self.frame.to_world(DVec3::new(x, y, z))
    }

    fn contains(&self, direction: DVec3) -> bool {
        let local = self.frame.to_local(direction);
        local.z > 0.0 && local.x * local.x + local.y * local.y <= self.sine * self.sine
    }

    /// Density of [`sample`](SunDisc::sample), 1/sr.
    fn pdf(&self, direction: DVec3) -> f64 {
        if self.contains(direction) {
            direction.dot(self.toward()) / (PI * self.sine * self.sine)
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::uniform;
    use azulejo_scene::{Light, Projection, Texture, Up};

    fn uniforms(k: u32) -> [f64; 3] {
        [1, 2, 3].map(|d| f64::from(uniform(&[k, d])))
    }

    /// A picture with a dark ground and a bright spot, and a sun.
    fn scene() -> Scene {
        let mut image = Image::new(32, 16);
        for (k, pixel) in image.pixels.iter_mut().enumerate() {
            *pixel = [0.2 + (k % 7) as f32, 1.0, if k < 256 { 2.0 } else { 0.1 }];
        }
        image.pixels[100] = [900.0, 800.0, 700.0];
        let mut scene = Scene::default();
        scene.textures.push(Texture {
            path: "sky.hdr".into(),
            image: Some(image),
            ..Texture::default()
        });
        let mut sky = Environment::picture(0, Projection::Equirectangular, Up::Y);
        sky.scale = Rgb::new(0.5, 1.0, 2.0);
        let sun = LightKind::Directional {
            direction: DVec3::new(0.3, -1.0, 0.2).normalize(),
            irradiance: Rgb::grey(40.0),
            half_angle: 0.05,
        };
        for kind in [LightKind::Environment(sky), sun] {
            let name = String::new();
            scene.lights.push(Light { name, kind });
        }
        scene
    }

    #[test]
    fn samples_have_the_density_that_is_said() {
        let scene = scene();
        let outside = Outside::new(&scene);
        // The mean of 1/p over samples is the solid angle of all directions.
        let (mut sphere, mut flux, n) = (0.0, 0.0, 200_000);
        for k in 0..n {
            let sample = outside.sample(uniforms(k)).unwrap();
            assert!((sample.direction.length() - 1.0).abs() < 1e-9);
            sphere += 1.0 / sample.pdf / f64::from(n);
            flux += sample.radiance.g / sample.pdf / f64::from(n);
        }
        assert!((sphere / (4.0 * PI) - 1.0).abs() < 0.02, "{sphere}");
        let cosine_mean =
            2.0 * (1.0 - (1.0 - 0.05f64.sin().powi(2)).sqrt()) / 0.05f64.sin().powi(2);
        let all = outside.total().g + 40.0 * cosine_mean;
        assert!((flux / all - 1.0).abs() < 0.01, "{flux} {all}");
    }

    #[test]
    fn environments_alone_are_sampled_alone() {
        let scene = scene();
        let outside = Outside::new(&scene);
        let n = 100_000;
        let mut flux = Rgb::BLACK;
        for k in 0..n {
            let (direction, pdf) = outside.sample_environment(uniforms(k)).unwrap();
            flux += outside.environment(direction) / (pdf * f64::from(n));
        }
        let all = outside.total();
        assert!(
            ((flux - all) / all.mean()).map(f64::abs).max_channel() < 0.01,
            "{flux:?} {all:?}"
        );
    }

    /// E = ∫ L cos over the disc is the irradiance that the light gives.
    #[test]
    fn a_sun_gives_its_irradiance() {
        let scene = scene();
        let sun = &Outside::new(&scene).suns[0];
        let n = 10_000;
        let of = |k: u32| {
            let d = sun.sample([0, 1].map(|i| uniforms(k)[i]));
            assert!(sun.contains(d) && sun.pdf(d) > 0.0);
            sun.radiance.r * d.dot(sun.toward()) / sun.pdf(d)
        };
        let irradiance = (0..n).map(of).sum::<f64>() / f64::from(n);
        assert!((irradiance - 40.0).abs() < 1e-9, "{irradiance}");
    }
}
