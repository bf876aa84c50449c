//! Merges coplanar tiles that fill a convex polygon: a mirror of many panes becomes one window.

use crate::lambert::{ArrayPolygon, convex_hull};
use azulejo_scene::Rgb;
use azulejo_scene::math::area_vector;
use glam::DVec3;

/// Tolerance of coplanarity, as a share of the size of a tile, and of the area of a hull that its
/// tiles may leave open.
const TOLERANCE: f64 = 1e-6;

/// A flat polygon, with the properties that tiles must share to be merged.
#[derive(Clone)]
pub struct Tile {
    /// Counter-clockwise about `normal`.
    pub polygon: ArrayPolygon,
    /// Unit.
    pub normal: DVec3,
    /// Reflectance.
    pub reflectance: Rgb,
}

/// The same surface in fewer polygons: tiles of one plane that fill their convex hull are replaced
/// by it.
pub fn merged(tiles: &[Tile]) -> Vec<Tile> {
    let mut groups: Vec<Vec<&Tile>> = Vec::new();
    for tile in tiles {
        match groups.iter_mut().find(|group| is_of_one(group[0], tile)) {
            Some(group) => group.push(tile),
            None => groups.push(vec![tile]),
        }
    }
    let whole = |group: Vec<&Tile>| match hull(&group) {
        Some(hull) => vec![hull],
        None => group.into_iter().cloned().collect(),
    };
    groups.into_iter().flat_map(whole).collect()
}

/// Whether two tiles lie in one plane and have one reflectance.
fn is_of_one(a: &Tile, b: &Tile) -> bool {
    let size = area_vector(&a.polygon).length().sqrt();
    let offset = |p: &DVec3| (*p - a.polygon[0]).dot(a.normal).abs();
    a.reflectance == b.reflectance
        && a.normal.dot(b.normal) > 1.0 - TOLERANCE
        && b.polygon.iter().all(|p| offset(p) <= TOLERANCE * size)
}

/// The convex hull of tiles, if they fill it and it has few corners.
fn hull(tiles: &[&Tile]) -> Option<Tile> {
    let (first, rest) = tiles.split_first()?;
    let normal = first.normal;
    let corners = tiles.iter().flat_map(|t| t.polygon.iter().copied());
    let polygon = convex_hull(corners, normal);
    let area = |p: &[DVec3]| area_vector(p).dot(normal);
    let filled: f64 = tiles.iter().map(|t| area(&t.polygon)).sum();
    let fills = (area(&polygon) - filled).abs() <= TOLERANCE * filled;
    (!rest.is_empty() && fills && polygon.len() <= ArrayPolygon::INLINE).then(|| Tile {
        polygon,
        ..(*first).clone()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    /// Fields of a grid of unit squares in a slanted plane.
    fn fields(wanted: impl Fn(i32, i32) -> bool) -> Vec<Tile> {
        let (x, y) = (dvec3(0.6, 0.0, 0.8), DVec3::Y);
        let at =
            |i: i32, j: i32| dvec3(3.0, 1.0, 2.0) + 0.1 * (f64::from(i) * x + f64::from(j) * y);
        let tile = |(i, j)| Tile {
            polygon: [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
                .into_iter()
                .collect(),
            normal: x.cross(y),
            reflectance: Rgb::grey(0.9),
        };
        let all = (0..8).flat_map(|i| (0..8).map(move |j| (i, j)));
        all.filter(|&(i, j)| wanted(i, j)).map(tile).collect()
    }

    fn check(tiles: &[Tile], polygons: usize) -> Vec<Tile> {
        let merged = merged(tiles);
        assert_eq!(merged.len(), polygons);
        let area = |tiles: &[Tile]| -> f64 {
            let of = |t: &Tile| area_vector(&t.polygon).dot(t.normal);
            tiles.iter().map(of).sum()
        };
        assert!((area(tiles) - area(&merged)).abs() < 1e-12);
        merged
    }

    #[test]
    fn fields_of_a_panel_are_one_window() {
        let one = check(&fields(|_, _| true), 1);
        assert_eq!(one[0].polygon.len(), 4);
        check(&fields(|_, j| j < 2), 1);
    }

    #[test]
    fn what_is_not_convex_stays_as_it_is() {
        check(&fields(|i, j| i < 4 || j < 4), 48);
        check(&fields(|i, j| (i + j) % 2 == 0), 32);
    }

    #[test]
    fn planes_and_reflectances_are_kept_apart() {
        let mut tiles = fields(|_, j| j < 1);
        tiles[7].reflectance = Rgb::WHITE;
        check(&tiles, 2);
        let mut tiles = fields(|_, j| j < 1);
        for tile in &mut tiles[4..] {
            tile.polygon = tile
                .polygon
                .iter()
                .map(|p| *p + 0.01 * tile.normal)
                .collect();
        }
        check(&tiles, 2);
    }
}
