//! What [`Engine::Auto`] means for a scene: the engine expected to reach the error soonest.
//!
//! Formulas cost by pairs that see each other, and most where these see each other partially: a town of
//! 60,000 patches may cost less than a room of 10,000, and three boxes more than both. The pairs of a few
//! rows are therefore computed and their work counted ([`Exchanger::forecast`]). Costs are those of one
//! core; that they are counts keeps the choice, and with it the result, the same on every machine.
//! Graphics cards are never chosen automatically, because their speed is unknown.

use crate::analytic_engine::exchanger::{Exchanger, ExchangerOptions};
use crate::engine::Engine;
use crate::patch::Patches;
use crate::row::Side;
use crate::shadow_rays::facing_ray;
use azulejo_scene::math::{Frame, Ray};
use azulejo_trace::sampling::{cosine_about, seeds, sobol};
use azulejo_trace::{KernelRay, Surfaces};

/// Formulas are worth this many times the time of rays. In rooms their rows are some fifty times better, for
/// which rays would need a few hundred times as long; among buildings twice, but exact for near pairs.
const WORTH: f64 = 4.0;

/// RMS error of the sums of rows where formulas of the usual accuracy take too long: most pairs with something between
/// them then take shadow rays.
const ROUGH: f64 = 3e-4;

/// Seconds that formulas may always take.
const SHORT: f64 = 1.0;

/// Rows that take this many times their forecast are left to rays.
const OUTLASTED: f64 = 5.0;

/// Seconds that any row may take.
const LEAST_ROW: f64 = 1e-3;

/// Share of the time of rays that a forecast may take, and seconds that it always may.
const FORECAST: (f64, f64) = (0.02, 0.1);

/// More patches than this are not even tried.
const MOST_PATCHES: usize = 200_000;

/// Share of the area that has to be flat for formulas to be worth while.
const MOSTLY_FLAT: f64 = 0.95;

/// Seconds per ray with sampling its start; more for one that meets a patch, which is located, and that per binary
/// digit of the number of patches; more for one that starts on a curved patch.
const SECONDS_PER_RAY: [f64; 4] = [0.09e-6, 0.06e-6, 0.04e-6, 0.4e-6];

/// Seconds per formula of a close pair, with its shadow rays.
const SECONDS_PER_PAIR: f64 = 50e-6;

/// Rays that tell how many meet a patch.
const RAYS: u32 = 1_024;

/// Rays per row of a matrix by default.
const ROW_RAYS: f64 = 4_096.0;

/// Random pairs whose visibility is tested.
const PAIRS: u32 = 2_048;

/// Rays between the patches of such a pair.
const RAYS_PER_PAIR: u32 = 4;

/// The properties of a divided scene on which the automatic choice of an engine rests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EngineChoice {
    /// Number of patches.
    pub patches: usize,
    /// Share of the area that is flat, 0 to 1.
    pub flat: f64,
    /// Whether there are patches of mirrors, glass or glossy surfaces.
    pub is_specular: bool,
    /// Shares of all pairs that see each other: fully, and partially. Of sampled pairs.
    pub visible: [f64; 2],
    /// Share of the rays from fronts that meet a patch.
    pub met: f64,
    /// Close pairs, which rows by rays have formulas for.
    pub close_pairs: usize,
    /// What formulas for all pairs take at the requested accuracy, or the usual one.
    pub formulas: FormulaTime,
    /// The same at a lower accuracy, where that is allowed and was tried.
    pub rough: FormulaTime,
    /// Bytes that may be used.
    pub memory: u64,
}

/// How long formulas take on one core, by counted work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FormulaTime {
    /// Seconds for all pairs; infinite where they are not considered.
    pub seconds: f64,
    /// Seconds of the pairs of the longest of a few rows.
    pub row_seconds: f64,
}

impl FormulaTime {
    const NEVER: FormulaTime = FormulaTime {
        seconds: f64::INFINITY,
        row_seconds: f64::INFINITY,
    };

    /// Seconds of counted work after which a row is left to rays: five times what the longest of the forecast takes.
    pub fn row_budget(&self) -> f64 {
        OUTLASTED * self.row_seconds.max(LEAST_ROW)
    }
}

/// An engine for form factors.
#[derive(Clone, Debug, PartialEq)]
pub struct FactorsChoice {
    /// The engine.
    pub engine: Engine,
    /// RMS error of the sums of rows, if it is not what was requested or is usual.
    pub accuracy: Option<f64>,
    /// Seconds of counted work after which a row of formulas is left to rays.
    pub row_budget: f64,
    /// Seconds of CPU time.
    pub seconds: f64,
    /// Why this one.
    pub why: String,
}

impl EngineChoice {
    /// The properties of a scene as divided into `patches`; rows by rays have formulas for `close_pairs`. Formulas with
    /// an `accuracy` are considered for that.
    pub fn of(
        surfaces: &Surfaces,
        patches: &Patches,
        accuracy: Option<f64>,
        memory: u64,
        close_pairs: usize,
    ) -> EngineChoice {
        let (mut flat, mut whole) = (0.0, 0.0);
        for p in 0..patches.len() {
            let area = patches.area(p);
            whole += area;
            if patches.polygon(p).is_some() {
                flat += area;
            }
        }
        let materials = patches.materials_in_use(surfaces.scene);
        let choice = EngineChoice {
            patches: patches.len(),
            flat: flat / f64::max(whole, f64::MIN_POSITIVE),
            is_specular: materials.iter().any(|m| m.is_specular()),
            visible: visible_shares(surfaces, patches),
            met: met_share(surfaces, patches),
            close_pairs,
            formulas: FormulaTime::NEVER,
            rough: FormulaTime::NEVER,
            memory,
        };
        let tracer = surfaces.tracer;
        let is_for_rays = tracer.is_repeated() || tracer.has_see_through();
        let is_for_formulas = choice.flat >= MOSTLY_FLAT && choice.fits();
        if is_for_rays || !is_for_formulas || choice.patches > MOST_PATCHES {
            return choice;
        }
        EngineChoice {
            formulas: choice.forecast(surfaces, patches, accuracy),
            ..choice
        }
    }

    /// The same with formulas of a lower accuracy, where they were considered and take long.
    pub fn or_rough(self, surfaces: &Surfaces, patches: &Patches) -> EngineChoice {
        let seconds = self.formulas.seconds;
        if seconds <= SHORT || seconds.is_infinite() {
            return self;
        }
        EngineChoice {
            rough: self.forecast(surfaces, patches, Some(ROUGH)),
            ..self
        }
    }

    /// The time of all pairs of fronts, and of what the horizon divides.
    fn forecast(
        &self,
        surfaces: &Surfaces,
        patches: &Patches,
        accuracy: Option<f64>,
    ) -> FormulaTime {
        let most = FORECAST.0 * self.matrix_seconds(ROW_RAYS) + FORECAST.1;
        let options = ExchangerOptions {
            accuracy,
            is_per_channel: false,
            seed: 0,
            row_budget: most,
        };
        let fronts = (0..patches.len() as Side).map(|patch| 2 * patch);
        let exchanger = Exchanger::new(patches, surfaces, fronts.collect(), options);
        let up = surfaces.scene.units.up.axis();
        let is_open = self.met < 1.0 && !self.is_specular;
        let work = exchanger.forecast(is_open.then_some(up), most);
        FormulaTime {
            seconds: work.seconds,
            row_seconds: work.longest_row,
        }
    }

    /// Seconds that `rays` rays from each patch take.
    fn ray_seconds(&self, rays: f64) -> f64 {
        let patches = self.patches.max(1) as f64;
        let [start, meeting, locating, curved] = SECONDS_PER_RAY;
        let meeting = self.met * (meeting + locating * patches.log2());
        patches * rays * (start + meeting + curved * (1.0 - self.flat))
    }

    /// Seconds of a matrix by `rays` rays from each patch, with formulas for close pairs.
    fn matrix_seconds(&self, rays: f64) -> f64 {
        self.ray_seconds(rays) + self.close_pairs as f64 * SECONDS_PER_PAIR
    }

    /// All pairs, each counted once.
    fn pairs(&self) -> f64 {
        0.5 * (self.patches as f64).powi(2)
    }

    /// Bytes for the pairs that see each other.
    fn pair_bytes(&self) -> f64 {
        16.0 * self.pairs() * self.visible.iter().sum::<f64>()
    }

    fn fits(&self) -> bool {
        self.pair_bytes() <= self.memory as f64
    }

    /// The engine for a matrix of form factors, where a row takes `rays`.
    pub fn for_factors(&self, rays: f64) -> FactorsChoice {
        let n = self.patches;
        let seen = 100.0 * self.visible.iter().sum::<f64>();
        let by_rays = self.matrix_seconds(rays);
        let rays_alone = |why: String| FactorsChoice {
            engine: Engine::Rays,
            accuracy: None,
            row_budget: f64::INFINITY,
            seconds: by_rays,
            why: format!("rays, because {why}"),
        };
        if !self.fits() {
            let gibibytes = self.pair_bytes() / f64::from(1 << 30);
            return rays_alone(format!(
                "the {seen:.1}% of the pairs of {n} patches that see each other may take {gibibytes:.1} GiB"
            ));
        }
        if self.flat < MOSTLY_FLAT {
            let curved = 100.0 * (1.0 - self.flat);
            return rays_alone(format!("{curved:.0}% of the area is curved"));
        }
        let most = f64::max(WORTH * by_rays, SHORT);
        let (time, accuracy) = if self.formulas.seconds <= most {
            (self.formulas, None)
        } else {
            (self.rough, Some(ROUGH))
        };
        let by_formulas = time.seconds;
        if by_formulas > most {
            let least = by_formulas.min(self.formulas.seconds);
            return rays_alone(format!(
                "they take about {by_rays:.2} s of CPU time, and formulas for {n} patches, of whose pairs {seen:.1}% \
                 see each other, {least:.0} s or more"
            ));
        }
        // Rays follow the light without formulas.
        let rest = if self.is_specular || self.flat < 1.0 {
            self.ray_seconds(rays)
        } else {
            0.0
        };
        let with = if accuracy.is_some() {
            " and shadow rays"
        } else {
            ""
        };
        FactorsChoice {
            engine: Engine::Analytic,
            accuracy,
            row_budget: time.row_budget(),
            seconds: by_formulas + rest,
            why: format!(
                "analytic, because formulas{with} for {n} flat patches, of whose pairs {seen:.1}% see each other, take \
                 about {by_formulas:.2} s of CPU time"
            ),
        }
    }

    /// The engine for solving light to a relative `error`, and the reason. Formulas pay where
    /// many rays would be needed; at least `least` rays leave each patch.
    pub fn for_light(&self, error: f64, least: u32) -> (Engine, String) {
        // A patch's error from N rays is about a half N^−0.63.
        let rays = (0.5 / error).powf(1.0 / 0.63).max(f64::from(least));
        let by_rays = self.ray_seconds(rays);
        // Solvers request whole rows, which compute each pair twice.
        let by_formulas = 2.0 * self.formulas.seconds;
        let is_possible = self.flat >= MOSTLY_FLAT && !self.is_specular;
        if is_possible && self.fits() && by_formulas < by_rays {
            let why = format!(
                "analytic, because {} flat patches are paired in {by_formulas:.2} s of CPU time, sooner than \
                 about {rays:.0} rays of each are traced",
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

/// Shares of the pairs of fronts that see each other: fully, and partially, as a few rays between
/// random points of random pairs tell.
fn visible_shares(surfaces: &Surfaces, patches: &Patches) -> [f64; 2] {
    if patches.is_empty() {
        return [0.0; 2];
    }
    let (mut rays, mut pairs) = (Vec::new(), Vec::new());
    let scrambling = seeds(&[0xf1]);
    for k in 0..PAIRS {
        let pick = |d: usize| {
            let u = f64::from(sobol(k, d, scrambling[d]));
            (u * patches.len() as f64) as usize % patches.len()
        };
        let (i, j) = (pick(0), pick(1));
        for r in 0..RAYS_PER_PAIR {
            let u = f64::from(sobol(RAYS_PER_PAIR * k + r, 2, scrambling[2]));
            let v = f64::from(sobol(RAYS_PER_PAIR * k + r, 3, scrambling[3]));
            if let Some(ray) = between(surfaces, patches, [i, j], [u, v]) {
                rays.push(ray);
                pairs.push(k);
            }
        }
    }
    let mut blocked = Vec::new();
    surfaces.tracer.any(&rays, &mut blocked);
    let (mut clear, mut partial) = (0u32, 0u32);
    let results: Vec<(u32, bool)> = pairs.into_iter().zip(blocked).collect();
    for pair in results.chunk_by(|a, b| a.0 == b.0) {
        let free = pair.iter().filter(|(_, blocked)| !blocked).count() as u32;
        clear += u32::from(free == RAYS_PER_PAIR);
        partial += u32::from(free > 0 && free < RAYS_PER_PAIR);
    }
    [clear, partial].map(|count| f64::from(count) / f64::from(PAIRS))
}

/// Share of the light of all fronts, each with as much as any other, that meets a patch.
pub(crate) fn met_share(surfaces: &Surfaces, patches: &Patches) -> f64 {
    if patches.is_empty() {
        return 0.0;
    }
    let scrambling = seeds(&[0xf2]);
    let ray = |k: u32| {
        let u: [f64; 4] = std::array::from_fn(|d| f64::from(sobol(k, d, scrambling[d])));
        let patch = k as usize * patches.len() / RAYS as usize;
        let start = patches.sample(patch, u[0], u[1]);
        let direction = cosine_about(&Frame::from_normal(start.normal), u[2], u[3]);
        let origin = surfaces.tracer.leaving(start.position, start.normal);
        surfaces.tracer.kernel_ray(&Ray::new(origin, direction))
    };
    let rays: Vec<KernelRay> = (0..RAYS).map(ray).collect();
    let mut met = Vec::new();
    surfaces.tracer.any(&rays, &mut met);
    met.iter().filter(|&&met| met).count() as f64 / f64::from(RAYS)
}

/// A ray between points of two patches, if their fronts face each other there.
fn between(
    surfaces: &Surfaces,
    patches: &Patches,
    [i, j]: [usize; 2],
    [u, v]: [f64; 2],
) -> Option<KernelRay> {
    // Different points on either side, so that the four rays of a pair are not parallel.
    let points = [patches.sample(i, u, v), patches.sample(j, v, 1.0 - u)];
    facing_ray(surfaces.tracer, points.map(|p| (p.position, p.normal)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patch::PatchSize;
    use azulejo_scene::synthetic::{cube_room, room_with_table, street_with_detail};
    use azulejo_trace::Tracer;

    const ROOM: EngineChoice = EngineChoice {
        patches: 5_000,
        flat: 1.0,
        is_specular: false,
        visible: [0.5, 0.1],
        met: 1.0,
        close_pairs: 80_000,
        formulas: FormulaTime {
            seconds: 30.0,
            row_seconds: 0.01,
        },
        rough: FormulaTime::NEVER,
        memory: 4 << 30,
    };

    #[track_caller]
    fn check((engine, why): (Engine, String), expected: &Engine, word: &str) {
        assert_eq!(&engine, expected, "{why}");
        assert!(why.contains(word), "{why}");
    }

    fn taking(seconds: f64) -> FormulaTime {
        FormulaTime {
            seconds,
            row_seconds: 0.01,
        }
    }

    #[track_caller]
    fn check_factors(choice: EngineChoice, expected: &Engine, word: &str) {
        let FactorsChoice { engine, why, .. } = choice.for_factors(ROW_RAYS);
        check((engine, why), expected, word);
    }

    #[test]
    fn factors_of_flat_rooms_are_formulas() {
        check_factors(ROOM, &Engine::Analytic, "5000 flat");
        let curved = EngineChoice { flat: 0.5, ..ROOM };
        check_factors(curved, &Engine::Rays, "50%");
        let many = EngineChoice {
            patches: 60_000,
            formulas: taking(4_500.0),
            memory: u64::MAX,
            ..ROOM
        };
        check_factors(many, &Engine::Rays, "4500 s");
        let tight = EngineChoice {
            memory: 100 << 20,
            ..ROOM
        };
        check_factors(tight, &Engine::Rays, "may take 0.1 GiB");
    }

    /// Before rays take all of a scene, shadow rays take what hides parts of pairs.
    #[test]
    fn rough_formulas_come_before_rays() {
        let town = EngineChoice {
            formulas: taking(4_500.0),
            rough: taking(20.0),
            ..ROOM
        };
        check_factors(town, &Engine::Analytic, "and shadow rays");
        let choice = town.for_factors(ROW_RAYS);
        assert_eq!((choice.accuracy, choice.seconds), (Some(ROUGH), 20.0));
        assert_eq!(ROOM.for_factors(ROW_RAYS).accuracy, None);
    }

    /// What counts is the work, not the number of patches.
    #[test]
    fn factors_of_towns_are_formulas() {
        let town = EngineChoice {
            patches: 60_000,
            visible: [0.006, 0.003],
            formulas: taking(100.0),
            ..ROOM
        };
        check_factors(town, &Engine::Analytic, "0.9%");
    }

    fn shares(scene: &azulejo_scene::Scene) -> [f64; 2] {
        let tracer = Tracer::new(scene);
        let surfaces = Surfaces::new(scene, &tracer);
        let patches = Patches::new(scene, PatchSize::Edge(0.0));
        visible_shares(&surfaces, &patches)
    }

    #[test]
    fn a_few_rays_tell_how_many_pairs_see_each_other() {
        let [clear, partial] = shares(&cube_room());
        // Of 36 ordered pairs of walls, six are a wall with itself.
        assert!(
            (clear - 5.0 / 6.0).abs() < 0.03 && partial == 0.0,
            "{clear}"
        );
        // 61% of the pairs of the room are seen, by the analytic engine, 13% of all partially.
        let [clear, partial] = shares(&room_with_table(500));
        assert!((clear + partial - 0.61).abs() < 0.06, "{clear} {partial}");
        let [clear, partial] = shares(&street_with_detail(0.1));
        assert!(clear + partial < 0.35, "{clear} {partial}");
    }

    #[test]
    fn light_is_found_by_rays_unless_formulas_are_sooner() {
        check(ROOM.for_light(0.03, 128), &Engine::Rays, "about 128 of");
        let few = EngineChoice {
            patches: 100,
            formulas: taking(0.01),
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
