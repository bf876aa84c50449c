//! Clusters of grids, bent and closed surfaces, and of what is none.

use super::*;
use crate::enclosure::CellMesh;
use crate::enclosure::tests::{fronts, two_squares};
use azulejo_factors::FaceId;
use azulejo_factors::form_factors::ExchangeAreas;
use azulejo_scene::math::area_vector;
use glam::DVec3;
use proptest::prelude::*;
use std::collections::{BTreeMap, HashSet};
use std::f64::consts::{PI, TAU};

/// Rows of one object that see nothing.
fn rows(polygons: Vec<Vec<DVec3>>) -> Enclosure {
    let n = polygons.len();
    let areas = polygons.iter().map(|p| area_vector(p).length()).collect();
    let mut enclosure = fronts(areas, ExchangeAreas::from_iter(vec![vec![]; n]));
    let face = |k: usize| FaceId {
        object: 0,
        face: k as u32,
    };
    enclosure.factors.faces = (0..n).map(face).collect();
    enclosure.rows.names = (0..n).map(|k| format!("wall/{k}")).collect();
    enclosure.rows.objects = vec!["wall".into(), "lid".into()];
    enclosure.rows.cells = CellMesh::new(polygons);
    enclosure
}

/// Squares of a parameter plane, of which a function makes positions.
fn grid(nx: usize, ny: usize, at: impl Fn(f64, f64) -> DVec3) -> Vec<Vec<DVec3>> {
    let corner = |x: usize, y: usize| at(x as f64, y as f64);
    let square = |x: usize, y: usize| {
        vec![
            corner(x, y),
            corner(x + 1, y),
            corner(x + 1, y + 1),
            corner(x, y + 1),
        ]
    };
    (0..ny)
        .flat_map(|y| (0..nx).map(move |x| (x, y)))
        .map(|(x, y)| square(x, y))
        .collect()
}

fn flat(x: f64, y: f64) -> DVec3 {
    DVec3::new(x, y, 0.0)
}

/// A tube of this many sides, whose corners are equal where it closes.
fn tube(sides: usize, rings: usize) -> Vec<Vec<DVec3>> {
    grid(sides, rings, |x, y| {
        let angle = TAU * (x % sides as f64) / sides as f64;
        DVec3::new(angle.cos(), angle.sin(), y)
    })
}

fn options(count: usize, degrees: f64) -> ClusterOptions {
    ClusterOptions {
        count,
        angle: degrees.to_radians(),
        whole_faces: false,
    }
}

fn clusters(enclosure: &Enclosure, count: usize, degrees: f64) -> Groups {
    let groups = enclosure.clusters(&options(count, degrees)).unwrap();
    check(enclosure, &groups, degrees);
    groups
}

/// Clusters are discs of rows that face one way, and are numbered by first appearance.
fn check(enclosure: &Enclosure, groups: &Groups, degrees: f64) {
    let mut members: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (row, group) in groups.of_rows.iter().enumerate() {
        let next = members.len() as u32;
        assert!(group.unwrap() <= next, "by first appearance");
        members.entry(group.unwrap()).or_default().push(row);
    }
    assert_eq!(members.len(), groups.names.len());
    let different: HashSet<&String> = groups.names.iter().collect();
    assert_eq!(different.len(), groups.names.len());
    let cells = &enclosure.rows.cells;
    for rows in members.values().filter(|rows| rows.len() > 1) {
        check_disc(cells, rows);
        let vectors = || rows.iter().map(|&r| area_vector(&cells.polygon(r)));
        let mean = vectors().sum::<DVec3>().normalize_or_zero();
        for vector in vectors().filter(|_| mean != DVec3::ZERO) {
            assert!(vector.angle_between(mean).to_degrees() < degrees + 0.01);
        }
    }
}

/// By Euler's characteristic, and by a border that is one closed line through different points.
fn check_disc(cells: &CellMesh, rows: &[usize]) {
    let (mut edges, mut points) = (BTreeMap::new(), HashSet::new());
    for &row in rows {
        let corners = cells.cell(row);
        for (k, &a) in corners.iter().enumerate() {
            let b = corners[(k + 1) % corners.len()];
            *edges.entry((a.min(b), a.max(b))).or_insert(0) += 1;
            points.insert(a);
        }
    }
    assert_eq!(points.len() + rows.len(), edges.len() + 1, "{rows:?}");
    let border: Vec<_> = edges.iter().filter(|&(_, &n)| n == 1).collect();
    let mut ways: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for &(&(a, b), _) in &border {
        ways.entry(a).or_default().push(b);
        ways.entry(b).or_default().push(a);
    }
    assert!(ways.values().all(|next| next.len() == 2), "{rows:?}");
    let start = *ways.keys().next().unwrap();
    let (mut before, mut at, mut steps) = (start, ways[&start][0], 1);
    while at != start {
        let next = ways[&at].iter().find(|&&p| p != before).unwrap();
        (before, at, steps) = (at, *next, steps + 1);
    }
    assert_eq!(steps, border.len(), "{rows:?}");
}

fn areas(enclosure: &Enclosure, groups: &Groups) -> Vec<f64> {
    enclosure.grouped(groups).factors.areas
}

#[test]
fn a_grid_becomes_as_many_pieces_of_like_size() {
    let plane = rows(grid(16, 12, flat));
    for count in [1, 2, 5, 12, 48, 191, 192, 500] {
        let groups = clusters(&plane, count, 30.0);
        assert_eq!(groups.names.len(), count.min(192));
        let sizes = areas(&plane, &groups);
        let mean = 192.0 / count.min(192) as f64;
        let most = sizes.iter().copied().fold(0.0, f64::max);
        let least = sizes.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(most < 2.5 * mean && least > mean / 2.5, "{count} {sizes:?}");
    }
    let four = clusters(&rows(grid(4, 4, flat)), 4, 30.0);
    assert_eq!(four.names, ["wall/0", "wall/1", "wall/2", "wall/3"]);
    assert_eq!(areas(&rows(grid(4, 4, flat)), &four), [4.0; 4]);
}

#[test]
fn no_cluster_closes_a_ring() {
    for (sides, rings) in [(12, 1), (3, 1), (12, 5), (8, 2)] {
        let ring = rows(tube(sides, rings));
        let count = clusters(&ring, 1, 180.0).names.len();
        assert!((2..4).contains(&count), "{sides} {rings} {count}");
    }
    assert_eq!(clusters(&rows(tube(12, 1)), 1, 180.0).names.len(), 2);
    // A box closes around what it holds.
    let mut faces = tube(4, 1);
    let lid = |k: usize| -> Vec<DVec3> { faces.iter().map(|f| f[k]).collect() };
    let (mut floor, ceiling) = (lid(0), lid(3));
    floor.reverse();
    faces.extend([floor, ceiling]);
    assert_eq!(clusters(&rows(faces), 1, 180.0).names.len(), 2);
}

#[test]
fn bends_end_clusters() {
    let ring = rows(tube(36, 4));
    // 36 sides of 10°: at most five lie within 20° of their mean.
    let groups = clusters(&ring, 1, 20.0);
    assert!((8..=12).contains(&groups.names.len()), "{:?}", groups.names);
    // None of them is flat with another, but for those of one side.
    assert_eq!(clusters(&ring, 1, 0.0).names.len(), 36);
    // A fold of 90°: both halves are 45° off their mean.
    let folded = || {
        rows(grid(4, 2, |x, y| {
            DVec3::new(x.min(2.0), y, (x - 2.0).max(0.0))
        }))
    };
    assert_eq!(clusters(&folded(), 1, 44.0).names.len(), 2);
    assert_eq!(clusters(&folded(), 1, 46.0).names.len(), 1);
}

#[test]
fn objects_materials_and_sides_stay_apart() {
    let mut plane = rows(grid(8, 2, flat));
    for row in 0..16 {
        plane.factors.faces[row].object = u32::from(row % 8 > 5);
        plane.factors.materials[row] = u32::from(row % 8 < 2);
        plane.factors.is_back[row] = row % 8 == 7;
    }
    let groups = clusters(&plane, 1, 30.0);
    assert_eq!(groups.names, ["wall/0", "wall/1", "lid/0", "lid/0 (back)"]);
    // Objects of one name.
    plane.rows.objects[1] = "wall".into();
    let groups = clusters(&plane, 1, 30.0);
    assert_eq!(
        groups.names,
        ["wall/0 #0", "wall/1", "wall/0 #2", "wall/0 (back)"]
    );
    let parts = [grid(2, 2, flat), grid(2, 2, |x, y| flat(x + 9.0, y))].concat();
    assert_eq!(clusters(&rows(parts), 1, 30.0).names.len(), 2);
}

#[test]
fn corners_on_edges_and_rounded_ones_are_found() {
    let at = |x: f64, y: f64| flat(2.0 * x, 3.0 * y);
    // Three rows beside two, all of them two high.
    let beside = |x: f64, y: f64| flat(2.0 * x - 2.0, 2.0 * y);
    let parts = || [grid(1, 2, at), grid(1, 3, beside)].concat();
    let groups = rows(parts()).clusters(&options(1, 30.0)).unwrap();
    assert_eq!(groups.names.len(), 1);
    let turned = |mut polygons: Vec<Vec<DVec3>>| {
        let turn = glam::DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.0);
        for (k, p) in polygons.iter_mut().flatten().enumerate() {
            *p = turn * *p * 0.3 + DVec3::splat(1e-9 * (k % 3) as f64);
        }
        polygons
    };
    let groups = rows(turned(parts())).clusters(&options(1, 30.0)).unwrap();
    assert_eq!(groups.names.len(), 1);
    let groups = rows(turned(grid(7, 5, flat))).clusters(&options(3, 30.0));
    assert_eq!(groups.unwrap().names.len(), 3);
}

#[test]
fn walls_back_to_back_are_two() {
    let mut sheets = grid(4, 4, flat);
    let mut behind = grid(4, 4, flat);
    behind.iter_mut().for_each(|p| p.reverse());
    sheets.extend(behind);
    let groups = clusters(&rows(sheets), 2, 30.0);
    assert_eq!(groups.names.len(), 2);
    assert!(groups.of_rows[..16].iter().all(|g| *g == Some(0)));
}

#[test]
fn rows_without_area_or_polygon() {
    let mut polygons = grid(3, 1, flat);
    // A needle between two halves, one as a line, one as a point, and a bow tie.
    let [a, b, c] = [flat(3.0, 0.0), flat(3.0, 0.5), flat(3.0, 1.0)];
    polygons.push(vec![a, b, c]);
    polygons.extend(grid(1, 2, |x, y| flat(x + 3.0, y / 2.0)));
    polygons.push(vec![a, a, a]);
    polygons.push(vec![a, flat(9.0, 0.0), a, flat(9.0, 1.0)]);
    let enclosure = rows(polygons);
    let groups = enclosure.clusters(&options(1, 30.0)).unwrap();
    assert_eq!(groups.names.len(), 3, "{groups:?}");
    assert!(groups.of_rows[..6].iter().all(|g| *g == Some(0)));
    let mut none = enclosure;
    none.rows.cells.rows.truncate(2);
    none.rows.cells.starts.truncate(3);
    none.rows.cells.corners.truncate(8);
    let groups = none.clusters(&options(1, 30.0)).unwrap();
    assert_eq!(groups.names.len(), 7);
}

#[test]
fn pieces_of_a_face_stay_together() {
    let mut plane = rows(grid(6, 6, flat));
    for (row, face) in plane.factors.faces.iter_mut().enumerate() {
        // Faces of two by three.
        face.face = (row % 6 / 2 + 3 * (row / 18)) as u32;
    }
    let whole = ClusterOptions {
        whole_faces: true,
        ..options(4, 30.0)
    };
    let groups = plane.clusters(&whole).unwrap();
    check(&plane, &groups, 30.0);
    assert_eq!(groups.names.len(), 4);
    let grouped = plane.grouped(&groups).rows.grouped_faces;
    let faces: Vec<u32> = grouped.iter().map(|(f, _)| f.face).collect();
    assert_eq!(faces, [0, 1, 2, 3, 4, 5]);
    assert_eq!(
        plane
            .clusters(&ClusterOptions { count: 36, ..whole })
            .unwrap()
            .names
            .len(),
        6
    );
}

#[test]
fn what_has_no_clusters_is_refused() {
    let mut none = two_squares();
    none.rows.cells = CellMesh::default();
    let refused = none.clusters(&options(1, 30.0)).unwrap_err();
    assert_eq!(refused, ClusterError::NoGeometry);
    assert!(refused.to_string().contains("\"cell_rows\""));
    let plane = rows(grid(2, 2, flat));
    let grouped = plane.grouped(&clusters(&plane, 2, 30.0));
    let refused = grouped.clusters(&options(1, 30.0)).unwrap_err();
    assert_eq!(refused, ClusterError::AreGroups);
    let empty = Enclosure::default().clusters(&options(1, 30.0)).unwrap();
    assert_eq!(empty, Groups::default());
}

/// A plane in which every edge is divided by many corners of others, and a crowd at one edge.
#[test]
fn hostile_rows_end() {
    let needle = |k: usize| {
        let x = k as f64;
        vec![flat(-x, 0.0), flat(x + 1.0, 0.0), flat(x, -1.0 - x)]
    };
    let groups = rows((0..400).map(needle).collect()).clusters(&options(1, 180.0));
    assert!(groups.unwrap().names.len() <= 400);
    let leaf = |k: usize| {
        let angle = k as f64;
        let tip = DVec3::new(angle.cos(), angle.sin(), 0.5);
        vec![DVec3::ZERO, DVec3::Z, tip]
    };
    let crowd = rows((0..100).map(leaf).collect()).clusters(&options(1, 180.0));
    assert_eq!(crowd.unwrap().names.len(), 100);
}

proptest! {
    #[test]
    fn clusters_of_bent_grids_with_holes_are_discs(
        (nx, ny) in (1..9usize, 1..9usize), bend in 0.0..0.6, count in 1..20usize,
        holes in proptest::collection::vec(any::<bool>(), 81), degrees in 1.0..PI.to_degrees(),
    ) {
        let mut polygons = grid(nx, ny, |x, y| DVec3::new(x, y, bend * (x * y).sin()));
        let mut hole = holes.iter();
        polygons.retain(|_| !hole.next().unwrap());
        prop_assume!(!polygons.is_empty());
        let enclosure = rows(polygons);
        let groups = clusters(&enclosure, count, degrees);
        prop_assert!(groups.names.len() >= count.min(enclosure.len()));
    }

    #[test]
    fn nothing_panics(
        corners in proptest::collection::vec((0..4i8, 0..4i8, 0..2i8), 3..120), count in 0..9usize,
        sides in 3..6usize,
    ) {
        let point = |&(x, y, z): &(i8, i8, i8)| DVec3::new(x.into(), y.into(), z.into());
        let polygons = corners.chunks_exact(sides).map(|c| c.iter().map(point).collect());
        let enclosure = rows(polygons.collect());
        for whole_faces in [false, true] {
            let cluster_options = ClusterOptions { whole_faces, ..options(count, 180.0) };
            let groups = enclosure.clusters(&cluster_options).unwrap();
            prop_assert!(groups.names.len() <= enclosure.len());
        }
    }
}
