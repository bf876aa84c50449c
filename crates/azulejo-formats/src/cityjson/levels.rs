//! Which of the geometries of a city object are read, by their levels of detail.

use super::document::{CityDocument, CityHeader};
use crate::Lod;
use crate::reading::json::Json;
use std::collections::HashMap;

/// How well a geometry suits: the greater, the better.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub(super) struct LevelRank {
    /// Compared first.
    class: u8,
    /// Compared within a class.
    within: f64,
}

/// Most generations of parts. Cycles of parents end here, too.
const MOST_GENERATIONS: usize = 8;

impl LevelRank {
    /// The rank of a level, which may be missing.
    ///
    /// Of the levels by default, the highest below 3 is best: from 3 on there are openings and
    /// furniture, far more than the exchange of radiation in a city needs. Level 0 is a footprint.
    fn of(level: Option<f64>, asked: Lod) -> LevelRank {
        let Some(level) = level else {
            return LevelRank {
                class: 0,
                within: 0.0,
            };
        };
        let (class, within) = match asked {
            Lod::Coarsest => (1, -level),
            Lod::Numbered(number) if level == number => (3, 0.0),
            Lod::Numbered(number) if level < number => (2, level),
            Lod::Numbered(_) => (1, -level),
            _ if level >= 3.0 => (2, -level),
            _ if level >= 1.0 => (3, level),
            _ => (1, level),
        };
        LevelRank { class, within }
    }

    /// Whether it is better by more than the digit behind the point.
    fn is_clearly_above(self, other: LevelRank) -> bool {
        (self.class, self.within.floor()) > (other.class, other.within.floor())
    }
}

/// The level that a geometry states, as a string or as a number.
pub(super) fn own_level(geometry: Json<'_>) -> Option<f64> {
    let lod = geometry.member("lod")?;
    let level = match lod.string() {
        Some(text) => text.trim().parse().ok(),
        None => lod.number(),
    };
    level.filter(|level: &f64| level.is_finite())
}

/// The level of a geometry; of a placed template that of the template.
fn level_of(geometry: Json<'_>, header: &CityHeader<'_>) -> Option<f64> {
    own_level(geometry).or_else(|| {
        let template = geometry.member("template")?.index()?;
        header.templates.get(template)?.level
    })
}

/// The geometries of one city object.
pub(super) struct ChosenGeometries<'a> {
    /// Those that are read.
    pub list: Vec<Json<'a>>,
    /// Their rank.
    rank: Option<LevelRank>,
}

impl<'a> ChosenGeometries<'a> {
    fn of(object: Json<'a>, header: &CityHeader<'a>, asked: Lod) -> ChosenGeometries<'a> {
        let geometries = object.member("geometry");
        let geometries = geometries.iter().flat_map(|list| list.elements());
        let ranked: Vec<_> = geometries
            .map(|g| (LevelRank::of(level_of(g, header), asked), g))
            .collect();
        let best = |a: LevelRank, b: LevelRank| if b > a { b } else { a };
        let rank = ranked.iter().map(|(rank, _)| *rank).reduce(best);
        let suits = |r: LevelRank| asked == Lod::All || Some(r) == rank;
        let list = ranked.iter().filter(|(r, _)| suits(*r));
        ChosenGeometries {
            list: list.map(|(_, g)| *g).collect(),
            rank,
        }
    }
}

/// The geometries of all objects of a document in their order, and the number of objects that are left
/// out because their parts have a better level: both together would be the same building twice.
pub(super) fn choose<'a>(
    document: &CityDocument<'a>,
    header: &CityHeader<'a>,
    asked: Lod,
) -> (Vec<ChosenGeometries<'a>>, usize) {
    let objects = document.objects.iter();
    let mut chosen: Vec<_> = objects
        .map(|(_, object)| ChosenGeometries::of(*object, header, asked))
        .collect();
    if asked == Lod::All {
        return (chosen, 0);
    }
    let mut left_out = 0;
    for (parent, of_parts) in best_parts(document, &chosen) {
        let own = chosen[parent].rank;
        if own.is_some_and(|own| of_parts.is_clearly_above(own)) {
            chosen[parent].list.clear();
            left_out += 1;
        }
    }
    (chosen, left_out)
}

/// The best rank among the parts of each object that has some: building parts, bridge parts, tunnel
/// parts. Installations and furniture only add to an object.
fn best_parts(
    document: &CityDocument<'_>,
    chosen: &[ChosenGeometries<'_>],
) -> HashMap<usize, LevelRank> {
    let parents = parents_of_parts(document);
    let mut best: HashMap<usize, LevelRank> = HashMap::new();
    for (k, geometries) in chosen.iter().enumerate() {
        let Some(rank) = geometries.rank else {
            continue;
        };
        let mut part = k;
        for _ in 0..MOST_GENERATIONS {
            let Some(parent) = parents[part].filter(|&p| p != k) else {
                break;
            };
            let known = best.entry(parent).or_insert(rank);
            if rank > *known {
                *known = rank;
            }
            part = parent;
        }
    }
    best
}

/// For each object the number of the one that it is a part of.
fn parents_of_parts(document: &CityDocument<'_>) -> Vec<Option<usize>> {
    let numbers = document.objects.iter().enumerate();
    let numbers: HashMap<&str, usize> = numbers.map(|(k, (id, _))| (&**id, k)).collect();
    let parent = |object: Json<'_>| {
        let kind = object.member("type")?.string()?;
        let parent = object.member("parents")?.elements().next()?.string()?;
        let number = numbers.get(&*parent).copied();
        number.filter(|_| kind.ends_with("Part"))
    };
    let objects = document.objects.iter();
    objects.map(|(_, object)| parent(*object)).collect()
}
