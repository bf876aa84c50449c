//! What [`Engine::Auto`] means for a scene: the engine expected to reach the error soonest.
//!
//! Costs are those of one core, measured on rooms of 500 to 13,000 facets; only their ratios
//! matter. Graphics cards are never chosen automatically, because their speed is unknown.

use crate::engine::Engine;
use crate::patch::Patches;
use azulejo_scene::Scene;

/// With more patches than this, formulas for all pairs take minutes and gigabytes.
const MOST_PAIRED: usize = 20_000;

/// Share of the area that has to be flat for formulas to be worth while.
const MOSTLY_FLAT: f64 = 0.95;

/// Seconds per ray, including sampling its start and locating the patch it hits.
const SECONDS_PER_RAY: f64 = 0.4e-6;

/// Seconds per pair of patches by formulas, including shadows.
const SECONDS_PER_PAIR: f64 = 2.5e-6;

/// The properties of a divided scene on which the automatic choice of an engine rests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EngineChoice {
    /// Number of patches.
    pub patches: usize,
    /// Share of the area that is flat, 0 to 1.
    pub flat: f64,
    /// Whether there are patches of mirrors, glass or glossy surfaces.
    pub is_specular: bool,
    /// Bytes that may be used.
    pub memory: u64,
}

impl EngineChoice {
    /// The properties of `scene` as divided into `patches`.
    pub fn of(scene: &Scene, patches: &Patches, memory: u64) -> EngineChoice {
        let (mut flat, mut all) = (0.0, 0.0);
        for p in 0..patches.len() {
            let area = patches.area(p);
            all += area;
            if patches.polygon(p).is_some() {
                flat += area;
            }
        }
        EngineChoice {
            patches: patches.len(),
            flat: flat / f64::max(all, f64::MIN_POSITIVE),
            is_specular: patches
                .materials_in_use(scene)
                .iter()
                .any(|m| m.is_specular()),
            memory,
        }
    }

    /// Bytes for all pairs, if all see each other.
    fn pair_bytes(&self) -> f64 {
        16.0 * 0.5 * (self.patches as f64).powi(2)
    }

    fn fits(&self) -> bool {
        self.pair_bytes() <= self.memory as f64
    }

    /// The engine for a matrix of form factors, and the reason.
    pub fn for_factors(&self) -> (Engine, String) {
        let n = self.patches;
        if n > MOST_PAIRED {
            let why = format!("rays, because {n} patches are too many to pair by formulas");
            (Engine::Rays, why)
        } else if !self.fits() {
            let gibibytes = self.pair_bytes() / f64::from(1 << 30);
            let why = format!("rays, because all pairs of {n} patches may take {gibibytes:.1} GiB");
            (Engine::Rays, why)
        } else if self.flat < MOSTLY_FLAT {
            let curved = 100.0 * (1.0 - self.flat);
            let why = format!("rays, because {curved:.0}% of the area is curved");
            (Engine::Rays, why)
        } else {
            let why = format!("analytic, because {n} flat patches can be paired by formulas");
            (Engine::Analytic, why)
        }
    }

    /// The engine for solving light to a relative `error`, and the reason. Formulas pay where
    /// many rays would be needed; at least `least` rays leave each patch.
    pub fn for_light(&self, error: f64, least: u32) -> (Engine, String) {
        let n = self.patches as f64;
        // A patch's error from N rays is about a half N^−0.63.
        let rays = (0.5 / error).powf(1.0 / 0.63).max(f64::from(least));
        let by_rays = n * rays * SECONDS_PER_RAY;
        let by_formulas = 0.5 * n * n * SECONDS_PER_PAIR;
        let is_possible = self.flat >= MOSTLY_FLAT && !self.is_specular;
        let fits = self.fits() && self.patches <= MOST_PAIRED;
        if is_possible && fits && by_formulas < by_rays {
            let why = format!(
                "analytic, because {} flat patches are paired sooner than about {rays:.0} rays \
                 of each are traced",
                self.patches
            );
            return (Engine::Analytic, why);
        }
        let why = if is_possible {
            format!("rays, because about {rays:.0} of each patch reach the error soonest")
        } else if self.is_specular {
            "rays, because there are mirrors, glass or gloss".to_owned()
        } else {
            "rays, because there are curved surfaces".to_owned()
        };
        (Engine::Rays, why)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOM: EngineChoice = EngineChoice {
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
        let curved = EngineChoice { flat: 0.5, ..ROOM };
        check(curved.for_factors(), &Engine::Rays, "50%");
        let many = EngineChoice {
            patches: 20_001,
            ..ROOM
        };
        check(many.for_factors(), &Engine::Rays, "too many");
        let tight = EngineChoice {
            memory: 100 << 20,
            ..ROOM
        };
        check(tight.for_factors(), &Engine::Rays, "may take 0.2 GiB");
    }

    #[test]
    fn light_is_found_by_rays_unless_formulas_are_sooner() {
        check(ROOM.for_light(0.03, 128), &Engine::Rays, "about 128 of");
        let few = EngineChoice {
            patches: 100,
            ..ROOM
        };
        check(few.for_light(0.001, 128), &Engine::Analytic, "paired");
        let mirrors = EngineChoice {
            is_specular: true,
            ..few
        };
        check(mirrors.for_light(0.001, 128), &Engine::Rays, "mirrors");
        let balls = EngineChoice { flat: 0.0, ..few };
        check(balls.for_light(0.001, 128), &Engine::Rays, "curved");
    }
}
