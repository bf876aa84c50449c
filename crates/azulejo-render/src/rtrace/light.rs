//! Light sources: brightness, shadows and sampling.

use super::Shadows;
use super::shade::{NOTHING, RaySampler, Shader, ShadingPoint, lobe};
use super::world::{Owner, is_above};
use azulejo_scene::Rgb;
use azulejo_scene::rtrace::{RtraceLight, RtraceLightKind};
use glam::DVec3;

/// How a light falls on a surface, without shadows.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightIncidence {
    /// Cosine times the intensity of a spot.
    pub diffuse: f64,
    /// The highlight's lobe times the intensity of a spot.
    pub specular: f64,
    to_light: DVec3,
    distance: f64,
}

impl Shader<'_> {
    /// How light from a light's centre falls on a surface.
    pub fn light(&self, at: &ShadingPoint, light: &RtraceLight) -> LightIncidence {
        let to_light = light.position - at.position;
        let distance = to_light.length();
        let to_light = to_light.normalize_or_zero();
        let cosine = at.normal.dot(to_light);
        let through = cosine < 0.0 && self.transmits_light(at);
        let intensity = intensity(light, to_light);
        let facing = if through { -cosine } else { cosine };
        let diffuse = if facing > NOTHING && is_above(at.surface.diffuse, NOTHING) {
            facing * intensity
        } else {
            0.0
        };
        let about = match (cosine < 0.0, at.refracted.filter(|_| through)) {
            (true, Some(refracted)) => refracted.dot(to_light),
            (true, None) => 0.0,
            (false, _) => at.mirrored.dot(to_light),
        };
        let specular = if is_above(at.specular, NOTHING) {
            lobe(about, at.surface.phong) * intensity
        } else {
            0.0
        };
        LightIncidence {
            diffuse,
            specular,
            to_light,
            distance,
        }
    }

    /// What a light brings to a surface: faded, shadowed, averaged over its samples.
    pub fn brightness(
        &self,
        at: &ShadingPoint,
        light: &RtraceLight,
        lit: &LightIncidence,
        sampler: &mut RaySampler,
    ) -> Rgb {
        let fade = self.lens.fade(lit.distance);
        let faded = |k: usize| light.brightness[k] * if light.fades[k] { fade } else { 1.0 };
        let full = Rgb::new(faded(0), faded(1), faded(2));
        if at.surface.is_unshadowed {
            return full;
        }
        let points = self.sample_points(light, lit, sampler);
        if points.is_empty() {
            return self.unblocked(at, full, lit.to_light, lit.distance);
        }
        let share = 1.0 / points.len() as f64;
        let seen = points.into_iter().map(|offset| {
            let direction = (lit.distance * lit.to_light + offset).normalize_or(lit.to_light);
            self.unblocked(at, full, direction, lit.distance)
        });
        share * seen.sum::<Rgb>()
    }

    /// Sample points of a light with an area, relative to its centre; none for point lights and for
    /// lights as small as a pixel.
    fn sample_points(
        &self,
        light: &RtraceLight,
        lit: &LightIncidence,
        sampler: &mut RaySampler,
    ) -> Vec<DVec3> {
        // The number of samples that a light of that size is worth.
        let worth = |size: f64| (self.lens.fade(size) * size / self.lens.pixel) as u32;
        match light.kind {
            RtraceLightKind::Point | RtraceLightKind::Spot { .. } => Vec::new(),
            RtraceLightKind::Extended { radius, samples } => {
                let count = worth(2.0 * radius);
                let steps = count.min(samples.saturating_sub(1));
                if count <= 1 || steps <= 1 {
                    return Vec::new();
                }
                let edges = square(lit.to_light).map(|edge| 2.0 * radius * edge);
                grid(edges, [steps, steps], true, sampler)
            }
            RtraceLightKind::Planar { edges, samples } => {
                let count = worth(edges[0].length().max(edges[1].length()));
                let steps = samples.map(|s| count.min(s.saturating_sub(1)));
                if count <= 1 || steps[0] == 0 {
                    return Vec::new();
                }
                grid(edges, steps, false, sampler)
            }
        }
    }

    /// The part of `full` that arrives from `direction` and at most `distance` away.
    fn unblocked(&self, at: &ShadingPoint, full: Rgb, direction: DVec3, distance: f64) -> Rgb {
        let mut ray = self.world.leaving(at.found, at.position, direction);
        ray.t_max = distance;
        let own = at.found.owner;
        // Shadow rays start as if outside: glass balls shadow themselves.
        let skip = at.found.is_passed_by(false);
        let counts = |owner: Owner| !(skip && owner == own);
        if self.options.shadows == Shadows::Opaque {
            return match self.world.first(&ray, counts) {
                Some(_) => Rgb::BLACK,
                None => full,
            };
        }
        let mut left = full;
        let mut passed: Vec<Owner> = Vec::new();
        while let Some(hit) = self
            .world
            .first(&ray, |o| counts(o) && !passed.contains(&o))
        {
            left *= hit.surface.transparency;
            if !is_above(left, self.options.cut) {
                return Rgb::BLACK;
            }
            ray.t_min = self.world.beyond(&ray, hit.distance);
            passed.push(hit.owner);
        }
        left
    }
}

/// Relative intensity of a light toward a point, from which `to_light` is the unit direction to it.
fn intensity(light: &RtraceLight, to_light: DVec3) -> f64 {
    let RtraceLightKind::Spot {
        direction,
        half_angle,
        factor,
    } = light.kind
    else {
        return 1.0;
    };
    let edge = half_angle.cos().min(1.0 - NOTHING);
    let inside = (-direction.dot(to_light) - edge) / (1.0 - edge);
    if inside > 0.0 {
        inside.powf(1.0 / factor)
    } else {
        0.0
    }
}

/// The unit edges of a square that faces along `direction`.
fn square(direction: DVec3) -> [DVec3; 2] {
    let up = if direction.y.abs() > 1.0 - NOTHING {
        DVec3::Z
    } else {
        DVec3::Y
    };
    let u = direction.cross(up).normalize();
    [u, direction.cross(u)]
}

/// Jittered points on a parallelogram around the origin, one more than `steps` along each edge;
/// without its corners where `is_round`.
fn grid(
    edges: [DVec3; 2],
    steps: [u32; 2],
    is_round: bool,
    sampler: &mut RaySampler,
) -> Vec<DVec3> {
    let mut points = Vec::new();
    let mut along = |i: u32, steps: u32| match steps {
        0 => 0.0,
        n => (f64::from(i) + sampler.jitter()) / f64::from(n) - 0.5,
    };
    let is_end = |i: u32, n: u32| i == 0 || i == n;
    for i in 0..=steps[0] {
        let u = along(i, steps[0]);
        for j in 0..=steps[1] {
            if is_round && is_end(i, steps[0]) && is_end(j, steps[1]) {
                continue;
            }
            points.push(u * edges[0] + along(j, steps[1]) * edges[1]);
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spot(factor: f64) -> RtraceLight {
        RtraceLight {
            position: DVec3::ZERO,
            brightness: Rgb::WHITE,
            fades: [true; 3],
            kind: RtraceLightKind::Spot {
                direction: -DVec3::Y,
                half_angle: 60f64.to_radians(),
                factor,
            },
        }
    }

    #[test]
    fn a_spot_is_linear_in_the_cosine_or_flat() {
        let toward = |degrees: f64| {
            let a = degrees.to_radians();
            DVec3::new(a.sin(), a.cos(), 0.0)
        };
        let check = |factor, degrees, expected: f64| {
            let strength = intensity(&spot(factor), toward(degrees));
            assert!((strength - expected).abs() < 1e-9, "{degrees}: {strength}");
        };
        check(1.0, 0.0, 1.0);
        check(1.0, 61.0, 0.0);
        check(1.0, 75f64.to_radians().cos().acos().to_degrees(), 0.0);
        check(1.0, 0.75f64.acos().to_degrees(), 0.5);
        check(2.0, 0.75f64.acos().to_degrees(), 0.5f64.sqrt());
    }

    #[test]
    fn a_round_light_leaves_out_its_corners() {
        let edges = [2.0 * DVec3::X, 2.0 * DVec3::Z];
        let mut sampler = RaySampler::new(1, 2);
        let points = grid(edges, [3, 3], true, &mut sampler);
        assert_eq!(points.len(), 12);
        assert!(points.iter().all(|p| p.x.abs() < 1.4 && p.z.abs() < 1.4));
        assert_eq!(grid(edges, [4, 0], false, &mut sampler).len(), 5);
    }
}
