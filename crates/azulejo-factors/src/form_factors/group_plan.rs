//! Division and samples where only sums over groups of rows are needed.
//!
//! Integrals over a group do not depend on its division, so few patches do: flat faces stay whole, and each
//! group has as many rays or hemicubes as its sums need, distributed over its patches by area. Formulas with
//! shadows are an exception: of large patches nearly all pairs are partially occluded, and take longer than many
//! small ones.

use super::PreparedPlan;
use crate::engine::Engine;
use crate::patch::{FaceId, PatchSize, Patches};
use crate::samples::{RowSamples, SampleCounts};
use azulejo_scene::MaterialId;
use std::collections::HashMap;

/// What the rows of a group have in common, besides their side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GroupBy {
    /// The face of an object.
    Face,
    /// The object.
    Object,
    /// The material.
    Material,
}

impl GroupBy {
    /// The same for two patches of a group, and different for others.
    pub fn key(self, face: FaceId, material: MaterialId) -> (u32, u32) {
        match self {
            GroupBy::Face => (face.object, face.face),
            GroupBy::Object => (face.object, 0),
            GroupBy::Material => (material, 0),
        }
    }
}

/// Patches of formulas, about: where some pairs are occluded, both more and fewer take longer for the same error.
const FORMULA_PATCHES: usize = 200;

/// Squares by whose size curved faces are divided for rays and hemicubes.
const CURVED_SQUARES: usize = 500;

/// The size by which polygons take the place of exact shapes: as where patches themselves are needed.
pub(super) const PROXY_SIZE: PatchSize = PatchSize::Squares(2_500);

/// The division for sums over groups. Automatic choices come later, and are formulas wherever these pay.
pub(super) fn size(engine: &Engine) -> PatchSize {
    match engine {
        Engine::Auto | Engine::Analytic => PatchSize::Count(FORMULA_PATCHES),
        Engine::Rays | Engine::Particles | Engine::Hemicube(_) | Engine::Hybrid(_) => {
            PatchSize::FlatWhole(CURVED_SQUARES)
        }
    }
}

/// How many samples groups and rows take.
struct Budget {
    /// Samples of all groups together, as far as the limits allow.
    total: f64,
    /// Fewest and most samples of a group.
    group: [f64; 2],
    /// Fewest samples of a row: four replicates.
    row: u32,
}

/// Up to 40 groups have the most; more share what 2,500 patches of 4,096 rays take.
const RAYS: Budget = Budget {
    total: 1e7,
    group: [4_096.0, 262_144.0],
    row: 64,
};

/// About the error of rays, in less than five times their time.
const HEMICUBES: Budget = Budget {
    total: 16_384.0,
    group: [16.0, 1_024.0],
    row: 4,
};

/// Positions at which light from outside is gathered.
const POSITIONS: Budget = Budget {
    total: 160_000.0,
    group: [64.0, 16_384.0],
    row: 16,
};

/// The groups of patches, and their areas.
pub(super) struct GroupAreas {
    patch_groups: Vec<u32>,
    areas: Vec<f64>,
}

impl GroupAreas {
    pub fn new(patches: &Patches, by: GroupBy) -> GroupAreas {
        let (mut numbers, mut areas) = (HashMap::new(), Vec::new());
        let group = |patch: usize| {
            let key = by.key(patches.face(patch), patches.material(patch));
            let number = *numbers.entry(key).or_insert_with(|| {
                areas.push(0.0);
                areas.len() as u32 - 1
            });
            areas[number as usize] += patches.area(patch);
            number
        };
        GroupAreas {
            patch_groups: (0..patches.len()).map(group).collect(),
            areas,
        }
    }

    /// Number of groups.
    pub fn count(&self) -> usize {
        self.areas.len()
    }

    /// Rays and hemicubes of each patch.
    pub fn samples(&self, patches: &Patches) -> RowSamples {
        RowSamples {
            rays: self.shared(patches, &RAYS),
            hemicubes: Some(self.shared(patches, &HEMICUBES)),
        }
    }

    /// Positions on each patch for light from outside.
    pub fn positions(&self, patches: &Patches) -> SampleCounts {
        self.shared(patches, &POSITIONS)
    }

    /// The samples of each group, distributed over its patches by area, in powers of two.
    fn shared(&self, patches: &Patches, budget: &Budget) -> SampleCounts {
        let per_group = budget.per_group(self.count());
        let count = |(patch, &group): (usize, &u32)| {
            let share = patches.area(patch) / self.areas[group as usize];
            budget.per_row(per_group * share)
        };
        SampleCounts::ByPatch(self.patch_groups.iter().enumerate().map(count).collect())
    }
}

impl Budget {
    /// The samples of each of `groups` groups.
    fn per_group(&self, groups: usize) -> f64 {
        let [least, most] = self.group;
        (self.total / groups.max(1) as f64).clamp(least, most)
    }

    /// The samples of a row that should have about `samples`: a power of two, of which Sobol's points are best.
    fn per_row(&self, samples: f64) -> u32 {
        let power = samples.max(1.0).log2().round().min(24.0);
        (1u32 << power as u32).max(self.row)
    }
}

impl PreparedPlan<'_> {
    /// What was planned for groups, in a sentence without full stop; `None` if rows are as they were asked for.
    pub(super) fn group_note(&self) -> Option<String> {
        let groups = self.groups.as_ref()?;
        let (count, rows) = (groups.count(), self.sides.len());
        let planned = |budget: &Budget, what: &str| {
            let (each, least) = (budget.per_group(count) as u64, budget.row);
            format!("about {each} {what} from each group, at least {least} from each patch")
        };
        let samples = match &self.engine {
            Engine::Analytic => None,
            Engine::Hemicube(_) | Engine::Hybrid(_) => Some(planned(&HEMICUBES, "hemicubes")),
            Engine::Auto | Engine::Rays | Engine::Particles => Some(planned(&RAYS, "rays")),
        };
        let samples = samples.map_or(String::new(), |words| format!(": {words}"));
        Some(format!(
            "planned for sums over {count} groups, {rows} rows{samples}"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::synthetic::cube_room;

    #[test]
    fn groups_share_samples_by_area() {
        let scene = cube_room();
        let whole = Patches::new(&scene, PatchSize::FlatWhole(500));
        assert_eq!(whole.len(), 6);
        let by_face = GroupAreas::new(&whole, GroupBy::Face);
        assert_eq!(by_face.count(), 6);
        let samples = by_face.samples(&whole);
        assert_eq!(samples.rays, SampleCounts::ByPatch(vec![262_144; 6]));
        let hemicubes = SampleCounts::ByPatch(vec![1_024; 6]);
        assert_eq!(samples.hemicubes, Some(hemicubes));
        let divided = Patches::new(&scene, PatchSize::Edge(0.25));
        let by_face = GroupAreas::new(&divided, GroupBy::Face);
        let samples = by_face.samples(&divided);
        assert_eq!(samples.rays, SampleCounts::ByPatch(vec![16_384; 96]));
    }

    #[test]
    fn budgets_have_limits() {
        assert_eq!(RAYS.per_group(1), 262_144.0);
        assert_eq!(RAYS.per_group(1_000), 1e4);
        assert_eq!(RAYS.per_group(100_000), 4_096.0);
        assert_eq!(RAYS.per_row(10.0), 64);
        assert_eq!(RAYS.per_row(3_000.0), 4_096);
        assert_eq!(HEMICUBES.per_row(0.0), 4);
    }
}
