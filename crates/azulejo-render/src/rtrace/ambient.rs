//! Ambient light: constant, or gathered with rays.

use super::shade::{NOTHING, RaySampler, RayState, Shader, ShadingPoint};
use super::world::is_above;
use azulejo_scene::Rgb;
use glam::DVec3;
use std::f64::consts::TAU;

/// Tries to sample a direction that does not point into the surface.
const MOST_TRIES: u32 = 256;

impl Shader<'_> {
    /// Ambient light on a surface.
    pub fn ambient(&self, at: &ShadingPoint, sampler: &mut RaySampler) -> Rgb {
        if at.path.depth >= self.options.ambient_depth || self.options.ambient_samples == 0 {
            return self.world.rtrace().ambient * at.diffuse();
        }
        let (kd, ks) = (at.surface.diffuse.mean(), at.specular.mean());
        if kd + ks <= NOTHING {
            return Rgb::BLACK;
        }
        let (diffuse, specular) = (kd / (kd + ks), ks / (kd + ks));
        let samples = f64::from(self.options.ambient_samples);
        let phong = at.surface.phong;
        let around = self.gathered(
            at,
            at.surface.diffuse,
            (samples * diffuse).round() as u32,
            |sampler| Some(around_normal(at.smooth_normal, sampler)),
            sampler,
        );
        let about = self.gathered(
            at,
            at.specular,
            mirrored_rays(samples, specular, phong),
            |sampler| about_mirrored(at, phong, sampler),
            sampler,
        );
        // Both models mirror ambient light as Phong's does.
        diffuse * around * at.diffuse() + specular * about * at.phong_mirror()
    }

    /// Mean radiance over `rays` rays from a surface that reflects `share` of it.
    fn gathered(
        &self,
        at: &ShadingPoint,
        share: Rgb,
        rays: u32,
        direction: impl Fn(&mut RaySampler) -> Option<DVec3>,
        sampler: &mut RaySampler,
    ) -> Rgb {
        let level = at.path.level * share;
        if rays == 0 || !is_above(share, NOTHING) || !is_above(level, NOTHING) {
            return Rgb::BLACK;
        }
        let path: RayState = at.path.next(level, at.path.is_inside);
        let mut sum = Rgb::BLACK;
        for _ in 0..rays {
            if let Some(direction) = direction(sampler) {
                sum += self.radiance(at, direction, path, sampler);
            }
        }
        sum / f64::from(rays)
    }
}

/// Rays about the mirrored one: fewer the sharper the lobe, if mirroring prevails.
fn mirrored_rays(samples: f64, specular: f64, phong: f64) -> u32 {
    if specular < 0.5 {
        return (samples * specular).round() as u32;
    }
    let rays = samples / (1.0 + phong) * (specular + phong * (1.0 - specular));
    rays.round() as u32
}

/// A direction about an axis, by its cosine and an angle around it.
fn about(axis: DVec3, cosine: f64, turn: f64) -> DVec3 {
    let other = if axis.x.abs() > 1.0 - NOTHING {
        DVec3::Y
    } else {
        DVec3::X
    };
    let u = axis.cross(other).normalize();
    let v = u.cross(axis);
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    (sine * (turn.cos() * u + turn.sin() * v) + cosine * axis).normalize()
}

fn around_normal(normal: DVec3, sampler: &mut RaySampler) -> DVec3 {
    let cosine = sampler.uniform().sqrt();
    about(normal, cosine, TAU * sampler.uniform())
}

/// RTRACE intends Phong's lobe, whose cosine is u^(1/(n+1)), but computes u^((n+1)/2): the sharper
/// the highlight, the farther from it these rays go. Kept, as its images depend on it.
fn about_mirrored(at: &ShadingPoint, phong: f64, sampler: &mut RaySampler) -> Option<DVec3> {
    (0..MOST_TRIES).find_map(|_| {
        let cosine = sampler.uniform().sqrt().powf(phong + 1.0);
        let direction = about(at.mirrored, cosine, TAU * sampler.uniform());
        (direction.dot(at.smooth_normal) >= NOTHING).then_some(direction)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_around_a_normal_follow_its_cosine() {
        let mut sampler = RaySampler::new(3, 4);
        let normal = DVec3::new(1.0, 2.0, -2.0) / 3.0;
        let n = 4000;
        let mean: f64 = (0..n)
            .map(|_| around_normal(normal, &mut sampler).dot(normal))
            .sum::<f64>()
            / f64::from(n);
        assert!((mean - 2.0 / 3.0).abs() < 0.01, "{mean}");
    }

    #[test]
    fn sharp_mirrors_take_fewer_rays() {
        assert_eq!(mirrored_rays(16.0, 0.25, 50.0), 4);
        assert_eq!(mirrored_rays(16.0, 1.0, 3.0), 4);
        assert_eq!(mirrored_rays(16.0, 1.0, 300.0), 0);
    }
}
