//! Coordinate systems: rectangular, cylindrical and spherical, defined by points of other systems.

use super::card::BulkCard;
use glam::{DAffine3, DMat3, DVec3};
use std::collections::{HashMap, HashSet};

/// How the three coordinates of a point are meant; angles are in degrees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CoordinateKind {
    /// x, y, z.
    Rectangular,
    /// Radius, azimuth from x, z.
    Cylindrical,
    /// Radius, angle from z, azimuth from x.
    Spherical,
}

impl CoordinateKind {
    /// By the last letter of a card's name.
    pub fn of_card(card: &BulkCard) -> Option<CoordinateKind> {
        match card.name.last()? {
            b'R' => Some(CoordinateKind::Rectangular),
            b'C' => Some(CoordinateKind::Cylindrical),
            b'S' => Some(CoordinateKind::Spherical),
            _ => None,
        }
    }

    fn rectangular(self, [a, b, c]: [f64; 3]) -> DVec3 {
        let polar = |degrees: f64| DVec3::new(cosine(degrees), cosine(degrees - 90.0), 0.0);
        match self {
            CoordinateKind::Rectangular => DVec3::new(a, b, c),
            CoordinateKind::Cylindrical => a * polar(b) + c * DVec3::Z,
            CoordinateKind::Spherical => {
                let (z, r) = (a * cosine(b), a * cosine(b - 90.0));
                r * polar(c) + z * DVec3::Z
            }
        }
    }
}

/// The cosine of an angle in degrees; exact at right angles, so that walls stay in their planes.
fn cosine(degrees: f64) -> f64 {
    match degrees.rem_euclid(360.0) {
        0.0 => 1.0,
        90.0 | 270.0 => 0.0,
        180.0 => -1.0,
        other => other.to_radians().cos(),
    }
}

/// What a system is defined by: its origin, a point on its z axis, and one in its x-z plane.
#[derive(Clone, Copy, Debug)]
pub(super) enum DefiningPoints {
    /// Grid points, by their numbers.
    Grids([u32; 3]),
    /// Points in another system.
    Points(u32, [[f64; 3]; 3]),
}

/// A coordinate system as its card defines it.
#[derive(Clone, Copy, Debug)]
pub(super) struct DefinedSystem {
    pub kind: CoordinateKind,
    pub points: DefiningPoints,
    /// Index of its card among the places that errors report.
    pub place: (u32, u32),
}

/// A point as its card gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GridPoint {
    /// Its coordinate system, 0 for the basic one; `None` if the card does not say.
    pub system: Option<u32>,
    pub coordinates: [f64; 3],
}

/// Why the place of a system is not known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SystemFault {
    /// It is defined by itself, through the others.
    Circle(u32),
    /// There is no system of this number, which the first one needs.
    Missing(u32, u32),
    /// It needs a grid point that does not exist.
    NoGrid(u32, u32),
    /// Its three points are on one line.
    Flat(u32),
}

/// A system in the basic one.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedSystem {
    kind: CoordinateKind,
    basic_from_system: DAffine3,
}

impl PlacedSystem {
    /// The basic system.
    const BASIC: PlacedSystem = PlacedSystem {
        kind: CoordinateKind::Rectangular,
        basic_from_system: DAffine3::IDENTITY,
    };

    /// The place of a point in the basic system.
    pub fn basic(&self, coordinates: [f64; 3]) -> DVec3 {
        let local = self.kind.rectangular(coordinates);
        self.basic_from_system.transform_point3(local)
    }
}

/// All systems, placed one after the other.
pub(super) struct SystemResolver<'a> {
    pub defined: &'a HashMap<u32, DefinedSystem>,
    pub grid: &'a dyn Fn(u32) -> Option<GridPoint>,
    pub placed: HashMap<u32, PlacedSystem>,
}

impl<'a> SystemResolver<'a> {
    pub fn new(
        defined: &'a HashMap<u32, DefinedSystem>,
        grid: &'a dyn Fn(u32) -> Option<GridPoint>,
    ) -> SystemResolver<'a> {
        SystemResolver {
            defined,
            grid,
            placed: HashMap::from([(0, PlacedSystem::BASIC)]),
        }
    }

    /// Places a system and all that it is defined by. The chain of these may be as long as the file, which
    /// is why it is kept in a list.
    pub fn place(&mut self, system: u32) -> Result<PlacedSystem, SystemFault> {
        if let Some(known) = self.placed.get(&system) {
            return Ok(*known);
        }
        let mut chain = vec![system];
        let mut begun = HashSet::new();
        while let Some(&current) = chain.last() {
            if self.placed.contains_key(&current) {
                chain.pop();
                continue;
            }
            let Some(defined) = self.defined.get(&current).copied() else {
                let from = chain.iter().rev().find(|&&s| self.needs(s, current));
                return Err(SystemFault::Missing(*from.unwrap_or(&current), current));
            };
            let needed = self.needed(current, &defined)?;
            let mut missing = needed.iter().filter(|s| !self.placed.contains_key(s));
            match missing.next() {
                Some(_) if !begun.insert(current) => {
                    return Err(SystemFault::Circle(current));
                }
                Some(_) => chain.extend(missing_of(&needed, &self.placed)),
                None => {
                    let placed = self.placed_by(current, &defined)?;
                    self.placed.insert(current, placed);
                }
            }
        }
        Ok(self.placed[&system])
    }

    /// Whether a system is defined in another one.
    fn needs(&self, system: u32, other: u32) -> bool {
        let defined = self.defined.get(&system);
        let needed = defined.and_then(|d| self.needed(system, d).ok());
        needed.is_some_and(|needed| needed.contains(&other))
    }

    /// The systems in which the points are given that define one.
    fn needed(&self, system: u32, defined: &DefinedSystem) -> Result<[u32; 3], SystemFault> {
        match defined.points {
            DefiningPoints::Points(reference, _) => Ok([reference; 3]),
            DefiningPoints::Grids(grids) => {
                let mut systems = [0; 3];
                for (grid_system, number) in systems.iter_mut().zip(grids) {
                    let grid = (self.grid)(number).ok_or(SystemFault::NoGrid(system, number))?;
                    *grid_system = grid.system.unwrap_or(0);
                }
                Ok(systems)
            }
        }
    }

    /// A system whose points are in systems that are placed.
    fn placed_by(&self, system: u32, defined: &DefinedSystem) -> Result<PlacedSystem, SystemFault> {
        let needed = self.needed(system, defined)?;
        let points = match defined.points {
            DefiningPoints::Points(_, points) => points,
            DefiningPoints::Grids(grids) => {
                grids.map(|g| (self.grid)(g).map_or([0.0; 3], |g| g.coordinates))
            }
        };
        let at = |k: usize| self.placed[&needed[k]].basic(points[k]);
        let basic_from_system = frame([at(0), at(1), at(2)]).ok_or(SystemFault::Flat(system))?;
        Ok(PlacedSystem {
            kind: defined.kind,
            basic_from_system,
        })
    }
}

fn missing_of(needed: &[u32; 3], placed: &HashMap<u32, PlacedSystem>) -> impl Iterator<Item = u32> {
    let missing = needed.iter().copied();
    missing.filter(|s| !placed.contains_key(s))
}

/// The axes of a system by its origin, a point on z, and one in the x-z plane.
fn frame([origin, on_z, in_xz]: [DVec3; 3]) -> Option<DAffine3> {
    let z = (on_z - origin).try_normalize()?;
    let y = z.cross(in_xz - origin);
    // A point that is on the axis but for rounding defines no plane.
    let is_clear = y.length() > 1e-12 * (in_xz - origin).length();
    let y = y.try_normalize().filter(|_| is_clear)?;
    let axes = DMat3::from_cols(y.cross(z), y, z);
    Some(DAffine3::from_mat3_translation(axes, origin))
}
