//! The luminaires of a scene by kind: flux, beam, and what a polar plot shows.

use azulejo_scene::{LightKind, PhotometricWeb, Scene};
use glam::DVec3;
use std::sync::Arc;

/// The lights of one luminaire, or of several alike.
#[derive(Clone, Debug)]
pub struct LuminaireKind<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its distribution.
    pub web: &'a Arc<PhotometricWeb>,
    /// The sum of the factors of its lights: radiant intensity where the web says 1, W/sr (cd in photometric scenes), for
    /// distances in scene units.
    pub scale: f64,
    /// Their number.
    pub lights: usize,
}

/// Half planes about the axis in which intensities are plotted: of 0 and 180, and of 90 and 270 degrees.
pub const PLANES: [(&str, DVec3); 2] = [("C0 – C180", DVec3::X), ("C90 – C270", DVec3::Y)];

impl LuminaireKind<'_> {
    /// Those of a scene, in order. Points that stand for one opening share their web, and so do luminaires that were read
    /// once.
    pub fn of(scene: &Scene) -> Vec<LuminaireKind<'_>> {
        let mut kinds: Vec<LuminaireKind<'_>> = Vec::new();
        for light in &scene.lights {
            let LightKind::Luminaire { scale, web, .. } = &light.kind else {
                continue;
            };
            let same = |kind: &&mut LuminaireKind| {
                kind.name == light.name && (Arc::ptr_eq(kind.web, web) || kind.web == web)
            };
            match kinds.iter_mut().find(same) {
                Some(kind) => {
                    kind.scale += scale.mean();
                    kind.lights += 1;
                }
                None => kinds.push(LuminaireKind {
                    name: &light.name,
                    web,
                    scale: scale.mean(),
                    lights: 1,
                }),
            }
        }
        kinds
    }

    /// Intensities in a plane, by angles from the aim that rise from −π to π: positive ones are on the side that `axis`
    /// points to. They are those of the file and whole degrees, between which the intensity is nearly linear.
    pub fn profile(&self, axis: DVec3) -> Vec<(f64, f64)> {
        let given = self.web.angles().into_iter().flatten();
        let mut degrees: Vec<f64> = (0..=180).map(f64::from).collect();
        degrees.extend(
            given
                .map(|angle| angle.abs())
                .filter(|angle| *angle < 180.0),
        );
        degrees.sort_by(f64::total_cmp);
        degrees.dedup();
        let below = degrees.iter().skip(1).rev().map(|angle| -angle);
        let intensity = |degrees: f64| {
            let angle = degrees.to_radians();
            let toward = axis * angle.sin() - DVec3::Z * angle.cos();
            (angle, self.scale * self.web.toward(toward))
        };
        below
            .chain(degrees.iter().copied())
            .map(intensity)
            .collect()
    }
}

/// The full angle of a profile, degrees, beyond which the intensity is less than a share of the largest in it; 0 without
/// light.
pub fn beam_angle(profile: &[(f64, f64)], share: f64) -> f64 {
    let limit = share * profile.iter().map(|(_, i)| *i).fold(0.0, f64::max);
    let is_in = |(_, intensity): &(f64, f64)| *intensity >= limit;
    let ends = profile
        .iter()
        .position(is_in)
        .zip(profile.iter().rposition(is_in));
    let Some((first, last)) = ends.filter(|_| limit > 0.0) else {
        return 0.0;
    };
    // Where the line to the angle beyond has the limit.
    let edge = |inside: usize, outside: Option<&(f64, f64)>| {
        let (angle, intensity) = profile[inside];
        outside.map_or(angle, |(beyond, less)| {
            angle + (beyond - angle) * (intensity - limit) / (intensity - less)
        })
    };
    let before = first.checked_sub(1).map(|k| &profile[k]);
    (edge(last, profile.get(last + 1)) - edge(first, before)).to_degrees()
}

/// A number of one digit, 1, 2 or 5 times a power of ten, of about this size: a step of rings.
pub fn round_step(about: f64) -> f64 {
    if about.is_nan() || about <= 0.0 {
        return 1.0;
    }
    let power = 10f64.powf(about.log10().floor());
    match about / power {
        x if x < 1.5 => power,
        x if x < 3.5 => 2.0 * power,
        x if x < 7.5 => 5.0 * power,
        _ => 10.0 * power,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::{Light, Rgb, WebType};
    use glam::DMat3;
    use std::f64::consts::PI;

    #[test]
    fn beams_are_full_angles() {
        // Straight down 100 cd, nothing from 60 degrees on in the plane of 0 degrees, and from 30.2 in that of 90.
        let values = vec![100.0, 60.0, 55.0, 0.0, 100.0, 0.1, 0.0, 0.0];
        let web = PhotometricWeb::new(WebType::C, [&[0.0, 30.0, 30.2, 60.0], &[0.0, 90.0]], values);
        let kind = LightKind::Luminaire {
            position: DVec3::ZERO,
            world_from_web: DMat3::IDENTITY,
            scale: Rgb::WHITE,
            web: Arc::new(web.unwrap()),
        };
        let light = |name: &str| Light {
            name: name.to_owned(),
            kind: kind.clone(),
        };
        let scene = Scene {
            lights: vec![light("a"), light("a"), light("b")],
            ..Scene::default()
        };
        let kinds = LuminaireKind::of(&scene);
        assert_eq!([kinds.len(), kinds[0].lights, kinds[1].lights], [2, 2, 1]);
        let profiles = PLANES.map(|(_, axis)| kinds[0].profile(axis));
        let beams = [0.5, 0.1].map(|share| profiles.each_ref().map(|p| beam_angle(p, share)));
        let expected = [[65.818, 30.03], [109.164, 54.054]];
        for (found, expected) in beams.iter().flatten().zip(expected.iter().flatten()) {
            assert!((found - expected).abs() < 0.01, "{beams:?}");
        }
        let at = |angle: f64| profiles[0].iter().find(|(a, _)| (a - angle).abs() < 1e-12);
        assert!((at(PI / 6.0).unwrap().1 - 120.0).abs() < 1e-9);
        assert!(profiles[0].is_sorted_by(|a, b| a.0 < b.0));
        assert_eq!([profiles[0][0].0, profiles[0].last().unwrap().0], [-PI, PI]);
        // The same to all sides.
        let even = [(-PI, 3.0), (0.0, 3.0), (PI, 3.0)];
        assert_eq!(
            [beam_angle(&even, 0.5), beam_angle(&[(0.0, 0.0)], 0.5)],
            [360.0, 0.0]
        );
        assert_eq!(
            [70.0, 30.0, 12.0, 90.0].map(round_step),
            [50.0, 20.0, 10.0, 100.0]
        );
    }
}
