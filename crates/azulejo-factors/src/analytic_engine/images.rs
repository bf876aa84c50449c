//! The scene seen directly and through chains of planar mirrors: the method of images.

use super::occluders::SceneOccluders;
use super::{Facet, FacetTree};
use crate::analytic::{Blocker, Chain};
use azulejo_scene::Rgb;
use azulejo_scene::math::Aabb;
use azulejo_trace::lambert::ArrayPolygon;
use glam::DVec3;
use rayon::prelude::*;

/// Rows as columns see them, directly or through a chain of mirrors: their images, behind windows.
pub(super) struct MirrorImage {
    /// Convex polygons in between: first windows, then blockers.
    pub obstructions: Vec<Blocker>,
    pub windows: usize,
    /// Bounding boxes of curved occluders.
    pub curved: Vec<Aabb>,
    /// Reflectance of the chain, mean of the channels.
    pub weight: f64,
    /// 0 direct, 1 by one mirror, 2 by more.
    pub order: usize,
    /// Depth that does not count.
    pub graze: f64,
    /// The mirrors, from the columns on.
    chain: Chain,
    /// Columns behind mirrors whose windows need no test; empty if there are no such mirrors.
    behind: Vec<bool>,
}

/// A flat mirror: the coplanar patches of one material together.
pub(super) struct FlatMirror {
    pub polygon: Vec<DVec3>,
    pub reflectance: Rgb,
}

/// Most windows and images of blockers of all chains together.
const MOST_OBSTRUCTIONS: usize = 1 << 18;

/// Which chains of mirrors are followed.
#[derive(Clone, Copy, Debug)]
pub(super) struct ImageLimits {
    /// Chains that carry at most this share of any row's light are dropped.
    pub least: f64,
    /// Most chains of more than one mirror.
    pub chains: usize,
    /// If chains that were not followed may carry more than this share of any row's light, no chain
    /// of several mirrors is kept.
    pub most_truncated: f64,
}

/// The images that are computed with.
pub(super) struct MirrorImages {
    pub list: Vec<MirrorImage>,
    /// Whether all chains of more than one mirror are included, apart from negligible ones.
    pub is_complete: bool,
    /// Upper bound of the share of any row's light that dropped chains carry.
    pub truncated: f64,
}

impl MirrorImage {
    fn new(
        chain: Chain,
        scene_occluders: &SceneOccluders,
        occluders: &[&[DVec3]],
        reflectance: Rgb,
    ) -> MirrorImage {
        let windows: Vec<Blocker> = chain
            .windows()
            .filter_map(|w| Blocker::new(w.clone()))
            .collect();
        let count = windows.len();
        let blockers = chain
            .blockers(occluders)
            .into_iter()
            .filter_map(|(polygon, of)| {
                let original = &scene_occluders.flat[of];
                if chain.length == 0 {
                    return Some(original.clone());
                }
                let mut blocker = Blocker::new(polygon)?;
                blocker.is_one_sided = original.is_one_sided;
                blocker.graze = original.graze;
                Some(blocker)
            });
        MirrorImage {
            obstructions: windows.into_iter().chain(blockers).collect(),
            windows: count,
            curved: scene_occluders.curved.clone(),
            weight: reflectance.mean(),
            order: chain.length.min(2),
            // Each mirror has a rounding of its own.
            graze: scene_occluders.planes.graze * (1 + chain.length) as f64,
            chain,
            behind: Vec::new(),
        }
    }

    /// Finds out which columns no light reaches first.
    pub fn set_columns(&mut self, columns: &[Facet]) {
        let behind: Vec<bool> = columns
            .iter()
            .map(|facet| self.chain.is_behind(facet.polygon()))
            .collect();
        if behind.contains(&true) {
            self.behind = behind;
        }
    }

    /// Whether a column lies behind a mirror of the chain.
    pub fn is_behind(&self, column: usize) -> bool {
        self.behind.get(column).is_some_and(|&is_behind| is_behind)
    }

    /// Images of facets, clipped to what columns may see.
    pub fn rows<'a>(&self, facets: impl Iterator<Item = &'a Facet>) -> FacetTree {
        let image = |facet: &Facet| {
            if self.order == 0 {
                return facet.clone();
            }
            let polygon = self.chain.placed_roughly(facet.polygon());
            let normal = self.chain.image.transform_vector3(facet.normal);
            Facet::new(facet.id, polygon.as_deref().unwrap_or(&[]), normal)
        };
        FacetTree::without_tree(facets.map(image).collect())
    }

    /// The parts of a row and a column between which light may pass all windows.
    pub fn lit_parts(&self, row: &Facet, column: &Facet) -> Option<[ArrayPolygon; 2]> {
        let row = row.polygon().iter().copied().collect();
        let before = self.chain.before(column.polygon())?;
        Some([self.chain.beyond(row)?, before])
    }
}

/// A chain that may be extended.
struct GrowingChain {
    chain: Chain,
    reflectance: Rgb,
}

impl MirrorImages {
    /// Directly, by each mirror, and by chains of them, the shortest first. `reach` bounds the
    /// share of any side's light that passes a window; all light starts among `corners`.
    pub fn new(
        scene_occluders: &SceneOccluders,
        mirrors: &[FlatMirror],
        limits: ImageLimits,
        corners: &[DVec3],
        reach: impl Fn(&[DVec3]) -> f64 + Sync,
    ) -> MirrorImages {
        let occluders: Vec<&[DVec3]> = scene_occluders
            .flat
            .iter()
            .map(|b| &b.polygon[..])
            .collect();
        let image_of = |g: &GrowingChain| {
            MirrorImage::new(g.chain.clone(), scene_occluders, &occluders, g.reflectance)
        };
        // The direct view and single mirrors come first, and are kept whatever longer chains cost.
        let graze = scene_occluders.planes.graze;
        let mut ends = vec![GrowingChain {
            chain: Chain::with_graze(graze),
            reflectance: Rgb::WHITE,
        }];
        let mut list = vec![image_of(&ends[0])];
        ends = longer(&ends, mirrors, &occluders);
        list.extend(ends.iter().map(image_of));
        let singles = list.len();
        if limits.chains == 0 {
            return MirrorImages {
                list,
                is_complete: mirrors.len() < 2,
                truncated: 0.0,
            };
        }
        // Bound what a chain carries by its reflectance and the window that lets the least light pass.
        let lean = |chain: &Chain, others: &[&Chain]| chain.without_passed(corners, graze, others);
        let bound = |mut g: GrowingChain| {
            g.chain = lean(&g.chain, &[&Chain::default()]);
            let most = g.chain.windows().map(|w| reach(w)).fold(1.0, f64::min);
            let most = g.reflectance.max_channel() * most;
            (g, most)
        };
        let mut truncated = 0.0;
        while !ends.is_empty() {
            let mut next = longer(&ends, mirrors, &occluders);
            // In the corner of a room chains differ only in the order of their mirrors; one may stand for all.
            if next.len() <= limits.chains {
                next = joined(next, lean);
            }
            let next: Vec<(GrowingChain, f64)> = next.into_par_iter().map(bound).collect();
            let (next, weak): (Vec<_>, Vec<_>) =
                next.into_iter().partition(|(_, most)| *most > limits.least);
            truncated += weak.iter().map(|(_, most)| most).sum::<f64>();
            // Beyond the limits, chains of this length are not followed, and what they may carry is lost.
            let obstructions: usize = list.iter().map(|image| image.obstructions.len()).sum();
            if list.len() + next.len() > singles + limits.chains || obstructions > MOST_OBSTRUCTIONS
            {
                truncated += next.iter().map(|(_, most)| most).sum::<f64>();
                break;
            }
            ends = next.into_iter().map(|(g, _)| g).collect();
            list.extend(ends.iter().map(image_of));
        }
        // If too much is lost, chains of several mirrors are dropped altogether.
        let is_complete = truncated <= limits.most_truncated;
        if !is_complete {
            list.truncate(singles);
        }
        MirrorImages {
            list,
            is_complete,
            truncated,
        }
    }
}

/// All chains with one more mirror at their ends.
fn longer(
    ends: &[GrowingChain],
    mirrors: &[FlatMirror],
    occluders: &[&[DVec3]],
) -> Vec<GrowingChain> {
    let on = |end: &GrowingChain| {
        let by = |mirror: &FlatMirror| {
            let chain = |side| end.chain.extended(&mirror.polygon, side, occluders);
            let reflectance = end.reflectance * mirror.reflectance;
            let chains = [1.0, -1.0].map(chain).into_iter().flatten();
            chains.map(move |chain| GrowingChain { chain, reflectance })
        };
        mirrors.iter().flat_map(by).collect::<Vec<_>>()
    };
    ends.iter().flat_map(on).collect()
}

/// The same chains, joined where they differ only in the order of mirrors. `lean` drops windows
/// that need no test, except those that all of the other chains have.
fn joined(
    chains: Vec<GrowingChain>,
    lean: impl Fn(&Chain, &[&Chain]) -> Chain,
) -> Vec<GrowingChain> {
    let mut groups: Vec<Vec<GrowingChain>> = Vec::with_capacity(chains.len());
    for new in chains {
        let has_image = |group: &&mut Vec<GrowingChain>| {
            let off = group[0].reflectance - new.reflectance;
            off.map(f64::abs).max_channel() <= 1e-12 && group[0].chain.has_image_of(&new.chain)
        };
        match groups.iter_mut().find(has_image) {
            Some(group) => group.push(new),
            None => groups.push(vec![new]),
        }
    }
    let one = |group: Vec<GrowingChain>| {
        let others = |k: usize| -> Vec<&Chain> {
            let others = group.iter().enumerate().filter(|(l, _)| *l != k);
            others.map(|(_, other)| &other.chain).collect()
        };
        let chains = group.iter().enumerate();
        let chains: Vec<Chain> = chains.map(|(k, g)| lean(&g.chain, &others(k))).collect();
        let reflectance = group[0].reflectance;
        match Chain::joined(&chains) {
            Some(chain) if group.len() > 1 => vec![GrowingChain { chain, reflectance }],
            _ => group,
        }
    };
    groups.into_iter().flat_map(one).collect()
}
