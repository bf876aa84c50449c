//! The world as it is seen straight, and as it is seen by planar mirrors.

use super::screens::Solids;
use super::{Facet, Facets};
use crate::analytic::{Blocker, Chain};
use azulejo_scene::Rgb;
use azulejo_scene::math::Aabb;
use glam::DVec3;
use rayon::prelude::*;

/// Rows as columns see them, straight or by a chain of mirrors: their images, behind windows.
pub(super) struct World {
    /// Convex polygons between: first windows, then blockers.
    pub screens: Vec<Blocker>,
    pub windows: usize,
    /// Boxes of which no more is known than that something in them blocks.
    pub curved: Vec<Aabb>,
    /// Share of the light that comes through, mean of the channels.
    pub weight: f64,
    /// 0 straight, 1 by one mirror, 2 by more.
    pub order: usize,
    /// Depth that does not count.
    pub graze: f64,
    /// From the columns on.
    chain: Chain,
}

/// A flat mirror, as large as its patches in one plane together.
pub(super) struct Mirror {
    pub polygon: Vec<DVec3>,
    pub reflectance: Rgb,
}

/// Which chains of mirrors are followed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Depth {
    /// Chains through which no row has more of its light go than this are not.
    pub least: f64,
    /// Most chains of more than one mirror.
    pub chains: usize,
    /// If more of any row's light goes on after so many, none of them is.
    pub most_left: f64,
}

/// The worlds that are worth looking at.
pub(super) struct Worlds {
    pub list: Vec<World>,
    /// Whether all chains of more than one mirror are there, but for what is too weak.
    pub has_all_orders: bool,
}

impl World {
    fn new(chain: Chain, solids: &Solids, occluders: &[&[DVec3]], reflectance: Rgb) -> World {
        let windows: Vec<Blocker> = chain
            .windows
            .iter()
            .filter_map(|w| Blocker::new(w.clone()))
            .collect();
        let count = windows.len();
        let blockers = chain
            .blockers(occluders)
            .into_iter()
            .filter_map(|(polygon, of)| {
                let mut blocker = Blocker::new(polygon)?;
                blocker.is_one_sided = solids.flat[of].is_one_sided;
                Some(blocker)
            });
        World {
            screens: windows.into_iter().chain(blockers).collect(),
            windows: count,
            curved: solids.curved.clone(),
            weight: reflectance.mean(),
            order: chain.windows.len().min(2),
            graze: 1e-10 * solids.size,
            chain,
        }
    }

    /// Images of facets, as far as columns may see them.
    pub fn rows<'a>(&self, facets: impl Iterator<Item = &'a Facet>) -> Facets {
        let image = |facet: &Facet| {
            if self.order == 0 {
                return facet.clone();
            }
            let polygon = self.chain.placed(facet.polygon());
            let normal = self.chain.image.transform_vector3(facet.normal);
            Facet::new(facet.id, polygon.as_deref().unwrap_or(&[]), normal)
        };
        Facets::in_turn(facets.map(image).collect())
    }
}

/// A chain on its way to longer ones.
struct Growing {
    chain: Chain,
    reflectance: Rgb,
    /// The mirror that it ends in.
    last: usize,
}

impl Worlds {
    /// Straight, by each mirror, and by chains of them, the shortest first. `reach` is the most
    /// that any side has of its light go through a window.
    pub fn new(
        solids: &Solids,
        mirrors: &[Mirror],
        depth: Depth,
        reach: impl Fn(&[DVec3]) -> f64 + Sync,
    ) -> Worlds {
        let occluders: Vec<&[DVec3]> = solids.flat.iter().map(|b| &b.polygon[..]).collect();
        let world = |g: &Growing| World::new(g.chain.clone(), solids, &occluders, g.reflectance);
        let mut ends = vec![Growing {
            chain: Chain::default(),
            reflectance: Rgb::WHITE,
            last: usize::MAX,
        }];
        let mut list = vec![world(&ends[0])];
        ends = longer(&ends, mirrors, &occluders);
        list.extend(ends.iter().map(world));
        let singles = list.len();
        if depth.chains == 0 {
            return Worlds {
                list,
                has_all_orders: mirrors.len() < 2,
            };
        }
        loop {
            let bound = |g: Growing| {
                let most = g.chain.windows.last().map_or(0.0, |w| reach(w));
                let most = g.reflectance.max_channel() * most;
                (most > depth.least).then_some((g, most))
            };
            let next = longer(&ends, mirrors, &occluders).into_par_iter();
            let next: Vec<(Growing, f64)> = next.filter_map(bound).collect();
            if list.len() + next.len() > singles + depth.chains {
                let left: f64 = next.iter().map(|(_, most)| most).sum();
                let has_all_orders = left <= depth.most_left;
                if !has_all_orders {
                    list.truncate(singles);
                }
                return Worlds {
                    list,
                    has_all_orders,
                };
            }
            if next.is_empty() {
                return Worlds {
                    list,
                    has_all_orders: true,
                };
            }
            ends = next.into_iter().map(|(g, _)| g).collect();
            list.extend(ends.iter().map(world));
        }
    }
}

/// All chains with one more mirror at their ends.
fn longer(ends: &[Growing], mirrors: &[Mirror], occluders: &[&[DVec3]]) -> Vec<Growing> {
    let on = |end: &Growing| {
        let others = mirrors.iter().enumerate().filter(|(k, _)| *k != end.last);
        let both = others.flat_map(|(k, mirror)| {
            let chains =
                [1.0, -1.0].map(|side| end.chain.extended(&mirror.polygon, side, occluders));
            chains.into_iter().flatten().map(move |chain| (chain, k))
        });
        let grown = both.map(|(chain, k)| Growing {
            chain,
            reflectance: end.reflectance * mirrors[k].reflectance,
            last: k,
        });
        grown.collect::<Vec<_>>()
    };
    ends.iter().flat_map(on).collect()
}
