//! What [`Engine::Auto`] is for a scene: whichever engine promises the asked error soonest.
//!
//! The costs are those of one core, measured on rooms of 500 to 13,000 facets; only their ratios
//! count. Graphics cards are left to those who ask for them: what one does is not known before.

use crate::engine::Engine;
use crate::patch::Patches;
use azulejo_scene::{Material, Scene};

/// Above so many patches formulas take minutes and gigabytes, pair by pair.
const MOST_PAIRED: usize = 20_000;

/// Surfaces are mostly flat if this share of their area is.
const MOSTLY: f64 = 0.95;

/// Seconds that a ray takes, with its start and the patch it meets.
const RAY: f64 = 0.4e-6;

/// Seconds that a pair of patches takes by formulas, with shadows.
const PAIR: f64 = 2.5e-6;

/// What an engine is chosen by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Facts {
    pub patches: usize,
    /// Share of the area that is flat.
    pub flat: f64,
    /// Whether there are mirrors or glass.
    pub is_specular: bool,
    /// Bytes that may be used.
    pub memory: u64,
}

impl Facts {
    pub fn of(scene: &Scene, patches: &Patches, memory: u64) -> Facts {
        let (mut flat, mut all) = (0.0, 0.0);
        for p in 0..patches.len() {
            let area = patches.area(p);
            all += area;
            if patches.polygon(p).is_some() {
                flat += area;
            }
        }
        Facts {
            patches: patches.len(),
            flat: flat / f64::max(all, f64::MIN_POSITIVE),
            is_specular: scene.materials.iter().any(Material::is_specular),
            memory,
        }
    }

    /// Bytes that all pairs take, if all see each other.
    fn pairs(&self) -> f64 {
        16.0 * 0.5 * (self.patches as f64).powi(2)
    }

    fn fits(&self) -> bool {
        self.pairs() <= self.memory as f64
    }

    /// The engine for form factors as a product, and why.
    pub fn for_factors(&self) -> (Engine, String) {
        let n = self.patches;
        if n > MOST_PAIRED {
            let why = format!("rays, because {n} patches are too many to pair by formulas");
            (Engine::Rays, why)
        } else if !self.fits() {
            let gibibytes = self.pairs() / f64::from(1 << 30);
            let why = format!("rays, because all pairs of {n} patches may take {gibibytes:.1} GiB");
            (Engine::Rays, why)
        } else if self.flat < MOSTLY {
            let curved = 100.0 * (1.0 - self.flat);
            let why = format!("rays, because {curved:.0}% of the area is curved");
            (Engine::Rays, why)
        } else {
            let why = format!("analytic, because {n} flat patches can be paired by formulas");
            (Engine::Analytic, why)
        }
    }

    /// The engine for the light of patches to a relative error, and why: formulas are worth their
    /// pairs where rays would have to be many. At least `least` rays leave each patch.
    pub fn for_light(&self, error: f64, least: u32) -> (Engine, String) {
        let n = self.patches as f64;
        // A patch's error from N rays is about a half N^−0.63.
        let rays = (0.5 / error).powf(1.0 / 0.63).max(f64::from(least));
        let by_rays = n * rays * RAY;
        let by_formulas = 0.5 * n * n * PAIR;
        let is_possible = self.flat >= MOSTLY && !self.is_specular;
        let fits = self.fits() && self.patches <= MOST_PAIRED;
        if is_possible && fits && by_formulas < by_rays {
            let why = format!(
                "analytic, because {} flat patches are paired sooner than about {rays:.0} rays \
                 of each are traced",
                self.patches
            );
            return (Engine::Analytic, why);
        }
        let why = match is_possible {
            true => {
                format!("rays, because about {rays:.0} of each patch promise the error soonest")
            }
            false if self.is_specular => {
                "rays, because mirrors, glass and gloss are followed".to_owned()
            }
            false => "rays, because curved surfaces are sampled as they are".to_owned(),
        };
        (Engine::Rays, why)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOM: Facts = Facts {
        patches: 5_000,
        flat: 1.0,
        is_specular: false,
        memory: 4 << 30,
    };

    #[track_caller]
    fn check((engine, why): (Engine, String), expected: &Engine, word: &str) {
        assert_eq!(&engine, expected, "{why}");
        assert!(why.contains(word), "{why}");
    }

    #[test]
    fn factors_of_flat_rooms_are_formulas() {
        check(ROOM.for_factors(), &Engine::Analytic, "5000 flat");
        let curved = Facts { flat: 0.5, ..ROOM };
        check(curved.for_factors(), &Engine::Rays, "50%");
        let many = Facts {
            patches: 20_001,
            ..ROOM
        };
        check(many.for_factors(), &Engine::Rays, "too many");
        let tight = Facts {
            memory: 100 << 20,
            ..ROOM
        };
        check(tight.for_factors(), &Engine::Rays, "may take 0.2 GiB");
    }

    #[test]
    fn light_is_found_by_rays_unless_formulas_are_sooner() {
        check(ROOM.for_light(0.03, 128), &Engine::Rays, "about 128 of");
        let few = Facts {
            patches: 100,
            ..ROOM
        };
        check(few.for_light(0.001, 128), &Engine::Analytic, "paired");
        let mirrors = Facts {
            is_specular: true,
            ..few
        };
        check(mirrors.for_light(0.001, 128), &Engine::Rays, "mirrors");
        let balls = Facts { flat: 0.0, ..few };
        check(balls.for_light(0.001, 128), &Engine::Rays, "curved");
    }
}
