//! Merges coplanar tiles that fill a convex polygon: a mirror of many panes becomes one window, the
//! triangles of a lamp one lamp.

use crate::lambert::{ArrayPolygon, convex_hull};
use azulejo_scene::math::area_vector;
use glam::DVec3;
use std::collections::HashMap;

/// Tolerance of coplanarity, as a share of the size of a tile, and of the area of a hull that its
/// tiles may leave open.
const TOLERANCE: f64 = 1e-6;

/// Pieces of more planes than this are not compared with each other: only tiles that have corners in
/// common are merged.
const MOST_PLANES: usize = 1024;

/// A flat polygon, with the properties that tiles must share to be merged.
#[derive(Clone)]
pub struct Tile<P> {
    /// Counter-clockwise about `normal`.
    pub polygon: ArrayPolygon,
    /// Unit.
    pub normal: DVec3,
    /// Reflectance or emission.
    pub property: P,
}

/// A tile that others were merged into.
pub struct MergedTile<P> {
    /// The convex hull of its members, or the only one.
    pub tile: Tile<P>,
    /// The tiles that fill it, by their indices, ascending.
    pub members: Vec<u32>,
}

/// The same surface in fewer polygons, in the order of their first members: tiles of one plane that
/// fill their convex hull are replaced by it, first those that are linked by common corners, then
/// all of a plane.
pub fn merged<P: Clone + PartialEq>(tiles: Vec<Tile<P>>) -> Vec<MergedTile<P>> {
    let linked = linked(&tiles);
    let single = |(k, tile)| MergedTile {
        tile,
        members: vec![k],
    };
    let pieces = hulls((0..).zip(tiles).map(single).collect(), &linked);
    let plane = planes(&pieces);
    let mut all = match plane {
        Some(plane) => hulls(pieces, &plane),
        None => pieces,
    };
    all.sort_by_key(|piece| piece.members[0]);
    all
}

/// For each tile the first of those that it is linked to by common corners.
fn linked<P: PartialEq>(tiles: &[Tile<P>]) -> Vec<u32> {
    let mut roots: Vec<u32> = (0..tiles.len() as u32).collect();
    let mut around: HashMap<[u64; 3], Vec<u32>> = HashMap::new();
    for (k, tile) in (0u32..).zip(tiles) {
        for corner in tile.polygon.iter() {
            // Adding zero makes negative zeros positive.
            let key = (*corner + DVec3::ZERO).to_array().map(f64::to_bits);
            let beside = around.entry(key).or_default();
            let of_one = |&&other: &&u32| is_of_one(&tiles[other as usize], tile);
            match beside.iter().find(of_one) {
                Some(&other) => join(&mut roots, other, k),
                // One of each plane is enough.
                None => beside.push(k),
            }
        }
    }
    (0..roots.len() as u32)
        .map(|k| root(&mut roots, k))
        .collect()
}

/// The root of a tree, which is its first tile; shortens the way there.
fn root(roots: &mut [u32], mut k: u32) -> u32 {
    while roots[k as usize] != k {
        roots[k as usize] = roots[roots[k as usize] as usize];
        k = roots[k as usize];
    }
    k
}

fn join(roots: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(roots, a), root(roots, b));
    roots[a.max(b) as usize] = a.min(b);
}

/// For each piece the first of its plane; `None` if there are too many planes.
fn planes<P: PartialEq>(pieces: &[MergedTile<P>]) -> Option<Vec<u32>> {
    let mut firsts: Vec<u32> = Vec::new();
    let mut plane = Vec::with_capacity(pieces.len());
    for (k, piece) in (0u32..).zip(pieces) {
        let of_one = |&&first: &&u32| is_of_one(&pieces[first as usize].tile, &piece.tile);
        let first = firsts.iter().find(of_one).copied().unwrap_or(k);
        if first == k {
            firsts.push(k);
        }
        if firsts.len() > MOST_PLANES {
            return None;
        }
        plane.push(first);
    }
    Some(plane)
}

/// Replaces the pieces of each group by their hull, where they fill it.
fn hulls<P: Clone>(pieces: Vec<MergedTile<P>>, group: &[u32]) -> Vec<MergedTile<P>> {
    let mut groups: Vec<Vec<MergedTile<P>>> = Vec::new();
    let mut place = HashMap::new();
    for (&group, piece) in group.iter().zip(pieces) {
        let k = *place.entry(group).or_insert_with(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        groups[k].push(piece);
    }
    let whole = |group: Vec<MergedTile<P>>| match hull(&group) {
        Some(hull) => vec![hull],
        None => group,
    };
    groups.into_iter().flat_map(whole).collect()
}

/// Whether two tiles lie in one plane and have the same properties.
fn is_of_one<P: PartialEq>(a: &Tile<P>, b: &Tile<P>) -> bool {
    let size = area_vector(&a.polygon).length().sqrt();
    let offset = |p: &DVec3| (*p - a.polygon[0]).dot(a.normal).abs();
    a.property == b.property
        && a.normal.dot(b.normal) > 1.0 - TOLERANCE
        && b.polygon.iter().all(|p| offset(p) <= TOLERANCE * size)
}

/// The convex hull of pieces, if they fill it and it has few corners.
fn hull<P: Clone>(pieces: &[MergedTile<P>]) -> Option<MergedTile<P>> {
    let (first, rest) = pieces.split_first()?;
    if rest.is_empty() {
        return None;
    }
    let normal = first.tile.normal;
    let polygons = || pieces.iter().map(|piece| &piece.tile.polygon);
    let corners = polygons().flat_map(|p| p.iter().copied());
    let polygon = convex_hull(corners, normal);
    // A hole that is as large as an overlap elsewhere shows in the first moment.
    let origin = polygon[0];
    let (area, moment) = moments(&polygon, normal, origin);
    let each = polygons().map(|p| moments(p, normal, origin));
    let (filled, balance) = each.fold((0.0, DVec3::ZERO), |a, b| (a.0 + b.0, a.1 + b.1));
    let fills = (area - filled).abs() <= TOLERANCE * filled
        && (moment - balance).length() <= TOLERANCE * filled * filled.sqrt();
    if !fills || polygon.len() > ArrayPolygon::INLINE {
        return None;
    }
    let mut members: Vec<u32> = pieces.iter().flat_map(|p| p.members.clone()).collect();
    members.sort_unstable();
    let tile = Tile {
        polygon,
        ..first.tile.clone()
    };
    Some(MergedTile { tile, members })
}

/// Area of a polygon, and its first moment about a point.
fn moments(polygon: &[DVec3], normal: DVec3, about: DVec3) -> (f64, DVec3) {
    let corner = polygon[0];
    let mut sum = (0.0, DVec3::ZERO);
    for edge in polygon[1..].windows(2) {
        let area = 0.5 * (edge[0] - corner).cross(edge[1] - corner).dot(normal);
        sum.0 += area;
        sum.1 += area * ((corner + edge[0] + edge[1]) / 3.0 - about);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    /// Fields of a grid of unit squares in a slanted plane.
    fn fields(is_inside: impl Fn(i32, i32) -> bool) -> Vec<Tile<u32>> {
        let (x, y) = (dvec3(0.6, 0.0, 0.8), DVec3::Y);
        let at =
            |i: i32, j: i32| dvec3(3.0, 1.0, 2.0) + 0.1 * (f64::from(i) * x + f64::from(j) * y);
        let tile = |(i, j)| Tile {
            polygon: [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
                .into_iter()
                .collect(),
            normal: x.cross(y),
            property: 0,
        };
        let all = (0..8).flat_map(|i| (0..8).map(move |j| (i, j)));
        all.filter(|&(i, j)| is_inside(i, j)).map(tile).collect()
    }

    /// Merges tiles into this many; none is lost, and no area.
    fn check(tiles: &[Tile<u32>], polygons: usize) -> Vec<MergedTile<u32>> {
        let merged = merged(tiles.to_vec());
        assert_eq!(merged.len(), polygons);
        let area = |t: &Tile<u32>| area_vector(&t.polygon).dot(t.normal);
        for piece in &merged {
            let filled: f64 = piece
                .members
                .iter()
                .map(|&k| area(&tiles[k as usize]))
                .sum();
            assert!((area(&piece.tile) - filled).abs() < 1e-12);
        }
        let mut members: Vec<u32> = merged.iter().flat_map(|m| m.members.clone()).collect();
        members.sort_unstable();
        assert!(members.into_iter().eq(0..tiles.len() as u32));
        merged
    }

    #[test]
    fn fields_of_a_panel_are_one_window() {
        let one = check(&fields(|_, _| true), 1);
        assert_eq!(one[0].tile.polygon.len(), 4);
        check(&fields(|_, j| j < 2), 1);
    }

    #[test]
    fn what_is_not_convex_stays_as_it_is() {
        check(&fields(|i, j| i < 4 || j < 4), 48);
        check(&fields(|i, j| (i + j) % 2 == 0), 32);
    }

    #[test]
    fn planes_and_properties_are_kept_apart() {
        let mut tiles = fields(|_, j| j < 1);
        tiles[7].property = 1;
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

    #[test]
    fn panels_of_one_plane_are_merged_each() {
        let merged = check(&fields(|i, j| i < 3 && j < 3 || i > 4 && j > 4), 2);
        assert_eq!(merged[0].members.len(), 9);
    }

    #[test]
    fn bricks_without_common_corners_are_merged() {
        // Rows whose joints lie in the middle of the bricks below.
        let mut bricks = Vec::new();
        for row in 0..4 {
            let mut x = 0.0;
            let first = if row % 2 == 0 { 1.0 } else { 0.5 };
            for width in [first, 1.0, 1.0, 2.0 - first] {
                let (y, next) = (f64::from(row), x + width);
                let corners = [(x, y), (next, y), (next, y + 1.0), (x, y + 1.0)];
                bricks.push(Tile {
                    polygon: corners.into_iter().map(|(x, y)| dvec3(x, y, 0.0)).collect(),
                    normal: DVec3::Z,
                    property: 0,
                });
                x = next;
            }
        }
        check(&bricks, 1);
    }

    #[test]
    fn a_hole_is_not_filled_by_a_tile_that_is_there_twice() {
        let mut tiles = fields(|_, _| true);
        tiles[27] = tiles[3].clone();
        check(&tiles, 64);
    }
}
