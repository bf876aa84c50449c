//! The curves of Strauss's model in RTRACE's variant.
//!
//! Strauss, *A Realistic Lighting Model for Computer Animators*, IEEE CG&A 10(6), 1990.

use super::shade::NOTHING;
use azulejo_scene::Rgb;
use azulejo_scene::rtrace::RtraceSurface;
use std::f64::consts::FRAC_2_PI;

/// The most that reflection gains at grazing angles.
const PEAK: f64 = 0.1;

/// The angular factors of Strauss's model for a pair of directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StraussFactors {
    /// Fresnel's term for the outgoing angle, 0..=1.
    pub fresnel: f64,
    /// Gain of the reflection, in units of itself plus the peak.
    pub gain: f64,
}

impl StraussFactors {
    /// `incidence` is the shadowing of the incoming ray; `cosine` is between the normal and the
    /// outgoing direction.
    pub fn new(cosine: f64, incidence: f64) -> StraussFactors {
        let flat = |fresnel| StraussFactors { fresnel, gain: 0.0 };
        if cosine < NOTHING {
            return flat(1.0);
        }
        if cosine > 1.0 - NOTHING {
            return flat(0.0);
        }
        let angle = cosine.acos() * FRAC_2_PI;
        let fresnel = fresnel(angle);
        StraussFactors {
            fresnel,
            gain: fresnel * incidence * shadowing(angle),
        }
    }

    /// Specular reflectance: more at grazing angles.
    pub fn mirror(self, specular: Rgb) -> Rgb {
        specular.map(|s| (s + (s + PEAK) * self.gain).min(1.0))
    }

    /// The colour that metal gives to its reflection; white at grazing angles.
    pub fn tint(self, surface: &RtraceSurface) -> Rgb {
        let towards = surface.metal * (surface.color - Rgb::WHITE);
        Rgb::WHITE + (1.0 - self.fresnel) * towards
    }
}

/// Shadowing of an incoming ray of that cosine to the normal; 0 from behind.
pub(super) fn incidence(cosine: f64) -> f64 {
    if cosine > 1.0 - NOTHING {
        1.0
    } else if cosine < NOTHING {
        0.0
    } else {
        shadowing(cosine.acos() * FRAC_2_PI)
    }
}

/// A curve with its pole at `pole`.
fn pole(x: f64, pole: f64) -> f64 {
    (x - pole).powi(2).recip()
}

/// Fresnel term: 0 along the normal, 1 at grazing angles. `angle` is in right angles.
fn fresnel(angle: f64) -> f64 {
    const K: f64 = 1.12;
    let share = (pole(angle, K) - pole(0.0, K)) / (pole(1.0, K) - pole(0.0, K));
    share.max(0.0)
}

/// Shadowing term: 1 along the normal, 0 at grazing angles. `angle` is in right angles.
fn shadowing(angle: f64) -> f64 {
    const K: f64 = 1.01;
    let share = (pole(1.0, K) - pole(angle, K)) / (pole(1.0, K) - pole(0.0, K));
    share.max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curves_run_from_end_to_end() {
        let check = |factor: f64, expected: f64| {
            assert!((factor - expected).abs() < 1e-9, "{factor} {expected}");
        };
        check(fresnel(0.0), 0.0);
        check(fresnel(1.0), 1.0);
        check(shadowing(0.0), 1.0);
        check(shadowing(1.0), 0.0);
        for k in 0..100 {
            let (a, b) = (f64::from(k) / 100.0, f64::from(k + 1) / 100.0);
            assert!(fresnel(a) < fresnel(b) && shadowing(a) > shadowing(b));
        }
    }

    #[test]
    fn light_along_the_normal_and_from_behind_gains_nothing() {
        let check = |cosine, fresnel| {
            assert_eq!(
                StraussFactors::new(cosine, 1.0),
                StraussFactors { fresnel, gain: 0.0 }
            );
        };
        check(1.0, 0.0);
        check(0.0, 1.0);
        check(-0.5, 1.0);
        assert!(StraussFactors::new(0.1, 1.0).gain > 0.0);
        assert_eq!((incidence(1.0), incidence(-0.3)), (1.0, 0.0));
    }
}
