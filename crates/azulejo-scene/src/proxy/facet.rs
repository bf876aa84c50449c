//! Tessellation of solids that are not compounds.

use super::bevelled::{BevelledFigure, steps};
use super::builder::corners;
use super::flat_figure::{FlatFigure, Tile, tiles};
use crate::math::{area_vector, normal_matrix};
use crate::{Bevel, BevelEnds, BicubicPatch, Figure, Leaf, MaterialId, Mesh, Primitive, Prism};
use glam::{DMat3, DVec2, DVec3};
use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;

/// Largest chord error as a fraction of a solid's size, so that small solids keep their shape.
const COARSEST: f64 = 0.02;
/// Smallest chord error as a fraction of a solid's size.
const FINEST: f64 = 1e-6;
/// Most pieces of a patch along each side.
const MOST_PIECES: f64 = 256.0;
/// Faces of a mesh without normals are one smooth surface below this angle of 30°.
const SMOOTH_COSINE: f64 = 0.866_025_403_784_438_6;

/// A polygon that approximates a piece of a surface.
pub(super) struct Facet {
    /// Positions and unit normals, counter-clockwise from the front.
    pub corners: Vec<(DVec3, DVec3)>,
    pub material: MaterialId,
}

/// A flattened figure, ready to be extruded.
struct FlatPrism {
    flat: FlatFigure,
    /// Polygons of a cap, as indices of points.
    caps: Vec<Vec<u32>>,
    /// Outward normals at both ends of each side.
    normals: Vec<[DVec2; 2]>,
}

impl FlatPrism {
    fn new(figure: &Figure, tolerance: f64) -> FlatPrism {
        let flat = FlatFigure::new(figure, tolerance);
        FlatPrism {
            caps: caps(&flat.points, &flat.tiles),
            normals: side_normals(&flat),
            flat,
        }
    }
}

/// A figure as polygons for a bevel with that many steps.
type BevelKey = (FigureKey, *const Bevel, u32);

/// A figure and a tolerance.
type FigureKey = (*const Figure, u64);

/// Flattened figures, each once per tolerance, also with each of their bevels.
#[derive(Default)]
pub(super) struct FlatFigureCache {
    flat: HashMap<FigureKey, Rc<FlatPrism>>,
    bevelled: HashMap<BevelKey, Rc<BevelledFigure>>,
}

impl FlatFigureCache {
    fn get(&mut self, figure: &Arc<Figure>, tolerance: f64) -> Rc<FlatPrism> {
        let key = (Arc::as_ptr(figure), tolerance.to_bits());
        let flat = self.flat.entry(key);
        Rc::clone(flat.or_insert_with(|| Rc::new(FlatPrism::new(figure, tolerance))))
    }

    fn bevelled(
        &mut self,
        figure: &Arc<Figure>,
        tolerance: f64,
        bevel: &Arc<Bevel>,
        steps: u32,
    ) -> Rc<BevelledFigure> {
        let prism = self.get(figure, tolerance);
        let key = (Arc::as_ptr(figure), tolerance.to_bits());
        let bevelled = self.bevelled.entry((key, Arc::as_ptr(bevel), steps));
        Rc::clone(bevelled.or_insert_with(|| {
            let FlatPrism { flat, normals, .. } = &*prism;
            Rc::new(BevelledFigure::new(flat, normals, bevel, steps, tolerance))
        }))
    }
}

/// The faces of a leaf; chords deviate from it by at most `chord_error`.
pub(super) fn facets(leaf: Leaf, chord_error: f64, flats: &mut FlatFigureCache) -> Vec<Facet> {
    let within = |size: f64| chord_error.clamp(FINEST * size, COARSEST * size);
    match leaf {
        Leaf::Primitive(p) => primitive_facets(p, within(p.bounds().diagonal())),
        Leaf::Prism(p) => prism_facets(p, chord_error, flats),
        Leaf::Patch(p) => patch_facets(p, within(p.bounds().diagonal())),
        Leaf::Mesh(mesh) => mesh_facets(mesh),
    }
}

fn primitive_facets(primitive: &Primitive, chord_error: f64) -> Vec<Facet> {
    if !(chord_error > 0.0 && chord_error.is_finite()) {
        return Vec::new();
    }
    let grids = primitive.grids(chord_error, f64::INFINITY);
    let mesh = primitive.tessellate(&grids);
    let facet = |face| Facet {
        corners: corners(&mesh, face),
        material: primitive.material,
    };
    (0..mesh.faces.len()).map(facet).collect()
}

fn mesh_facets(mesh: &Mesh) -> Vec<Facet> {
    let smooth = mesh.normals.is_none().then(|| smooth_normals(mesh));
    let facet = |face: usize| {
        let mut corners = corners(mesh, face);
        if let Some(normals) = &smooth {
            let own = &normals[mesh.faces.corner_range(face)];
            corners.iter_mut().zip(own).for_each(|(c, &n)| c.1 = n);
        }
        Facet {
            corners,
            material: mesh.face_materials[face],
        }
    };
    (0..mesh.faces.len()).map(facet).collect()
}

/// For each corner of a mesh the mean normal of those faces at its vertex whose normals differ by
/// less than 30° from that of its own face.
fn smooth_normals(mesh: &Mesh) -> Vec<DVec3> {
    let vectors: Vec<DVec3> = (0..mesh.faces.len())
        .map(|f| mesh.face_area_vector(f))
        .collect();
    let mut around = vec![Vec::new(); mesh.positions.len()];
    for (face, ring) in mesh.faces.iter().enumerate() {
        ring.iter().for_each(|&v| around[v as usize].push(face));
    }
    let mut normals = Vec::with_capacity(mesh.faces.corners.len());
    for (face, ring) in mesh.faces.iter().enumerate() {
        let own = vectors[face].normalize_or(DVec3::Z);
        normals.extend(ring.iter().map(|&v| {
            let like = around[v as usize].iter().map(|&f| vectors[f]);
            let like = like.filter(|n| n.normalize_or_zero().dot(own) > SMOOTH_COSINE);
            like.sum::<DVec3>().normalize_or(own)
        }));
    }
    normals
}

fn patch_facets(patch: &BicubicPatch, chord_error: f64) -> Vec<Facet> {
    let p = &patch.points;
    let count = |bend: f64| {
        // As for curves; half of the error for each direction.
        let n = (6.0 * bend / (8.0 * 0.5 * chord_error)).sqrt().ceil();
        n.clamp(1.0, MOST_PIECES) as u32
    };
    let bend = |a: DVec3, b: DVec3, c: DVec3| (a - 2.0 * b + c).length();
    let pairs = || (0..4).flat_map(|i| [(i, 0), (i, 1)]);
    let along_u = pairs().map(|(i, j)| bend(p[i][j], p[i][j + 1], p[i][j + 2]));
    let along_v = pairs().map(|(i, j)| bend(p[j][i], p[j + 1][i], p[j + 2][i]));
    let nu = count(along_u.fold(0.0, f64::max));
    let nv = count(along_v.fold(0.0, f64::max));
    let corner = |i: u32, j: u32| {
        let (u, v) = (f64::from(i) / f64::from(nu), f64::from(j) / f64::from(nv));
        (patch.at(u, v).0, patch_normal(patch, u, v))
    };
    let facet = |(i, j)| Facet {
        corners: [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
            .map(|(i, j)| corner(i, j))
            .to_vec(),
        material: patch.material,
    };
    let cells = (0..nv).flat_map(|j| (0..nu).map(move |i| (i, j)));
    cells.map(facet).collect()
}

/// Where a side of the patch is a point, the normal is taken a small step inside.
fn patch_normal(patch: &BicubicPatch, u: f64, v: f64) -> DVec3 {
    let normal = |u, v| {
        let (_, du, dv) = patch.at(u, v);
        du.normalize_or_zero().cross(dv.normalize_or_zero())
    };
    let inward = |x: f64| x + 1e-3 * (0.5 - x);
    let exact = normal(u, v);
    let normal = if exact.length_squared() > 1e-12 {
        exact
    } else {
        normal(inward(u), inward(v))
    };
    normal.normalize_or(DVec3::Z)
}

/// The chord error of a prism's figure, in its units, and how many world units these are at most; `None` without size.
fn figure_tolerance(prism: &Prism, chord_error: f64) -> Option<[f64; 2]> {
    let m = prism.world_from_figure.matrix3;
    let stretch = m.x_axis.length().hypot(m.y_axis.length());
    let size = prism.figure.bounds().size().length();
    let tolerance = (chord_error / stretch).clamp(FINEST * size, COARSEST * size);
    (tolerance > 0.0 && tolerance.is_finite()).then_some([tolerance, stretch])
}

/// The length of a prism's outline in the world.
pub(super) fn outline_length(prism: &Prism, chord_error: f64, flats: &mut FlatFigureCache) -> f64 {
    let Some([tolerance, _]) = figure_tolerance(prism, chord_error) else {
        return 0.0;
    };
    let flat = &flats.get(&prism.figure, tolerance).flat;
    let side = |&[a, b]: &[u32; 2]| {
        let way = flat.points[b as usize] - flat.points[a as usize];
        (prism.world_from_figure.matrix3 * way.extend(0.0)).length()
    };
    flat.border.iter().map(side).sum()
}

fn prism_facets(prism: &Prism, chord_error: f64, flats: &mut FlatFigureCache) -> Vec<Facet> {
    let m = prism.world_from_figure.matrix3;
    let Some([tolerance, stretch]) = figure_tolerance(prism, chord_error) else {
        return Vec::new();
    };
    let prepared = flats.get(&prism.figure, tolerance);
    let mut builder = PrismFacets::new(prism);
    match &prism.bevel {
        None => {
            builder.add_plane(&prepared.flat.points, &prepared.caps, 0.0);
            builder.add_plane(&prepared.flat.points, &prepared.caps, 1.0);
            builder.add_sides(&prepared, [0.0, 1.0]);
        }
        Some(bevel) => {
            let radius = bevel.inset.max(bevel.depth * m.z_axis.length() / stretch);
            let count = steps(bevel, radius, tolerance);
            let bevelled = flats.bevelled(&prism.figure, tolerance, bevel, count);
            builder.add_bevel(&bevelled, bevel, 0.0);
            match bevel.ends {
                BevelEnds::Front => builder.add_plane(&prepared.flat.points, &prepared.caps, 1.0),
                BevelEnds::Both => builder.add_bevel(&bevelled, bevel, 1.0),
            }
            builder.add_sides(&prepared, bevel.sides());
        }
    }
    builder.facets
}

/// The faces of a prism under construction.
struct PrismFacets<'a> {
    prism: &'a Prism,
    cofactor: DMat3,
    mirrors: bool,
    facets: Vec<Facet>,
}

impl<'a> PrismFacets<'a> {
    fn new(prism: &'a Prism) -> PrismFacets<'a> {
        let m = prism.world_from_figure.matrix3;
        PrismFacets {
            prism,
            cofactor: normal_matrix(m),
            mirrors: m.determinant() < 0.0,
            facets: Vec::new(),
        }
    }

    /// Adds a polygon in figure space, counter-clockwise from outside, with outward normals of any length.
    fn push(&mut self, corners: impl DoubleEndedIterator<Item = (DVec3, DVec3)>) {
        let map = &self.prism.world_from_figure;
        let placed = corners.map(|(p, n)| {
            let normal = (self.cofactor * n).normalize_or(DVec3::Z);
            (map.transform_point3(p), normal)
        });
        let mut corners: Vec<(DVec3, DVec3)> = placed.collect();
        if self.mirrors {
            corners.reverse();
        }
        self.facets.push(Facet {
            corners,
            material: self.prism.material,
        });
    }

    /// Adds a polygon that is counter-clockwise from above, on the back as it is, on the front the other way round.
    fn push_towards(&mut self, z: f64, corners: impl DoubleEndedIterator<Item = (DVec3, DVec3)>) {
        if z > 0.0 {
            self.push(corners);
        } else {
            self.push(corners.rev());
        }
    }

    /// Adds the polygons of one of the planes.
    fn add_plane(&mut self, points: &[DVec2], polygons: &[Vec<u32>], z: f64) {
        let normal = (2.0 * z - 1.0) * DVec3::Z;
        for polygon in polygons {
            let corner = |&k: &u32| (points[k as usize].extend(z), normal);
            self.push_towards(z, polygon.iter().map(corner));
        }
    }

    /// Adds a bevel and what it leaves of the plane at z.
    fn add_bevel(&mut self, bevelled: &BevelledFigure, bevel: &Bevel, z: f64) {
        let points = &bevelled.flat.points;
        self.add_plane(points, &caps(points, &tiles(&bevelled.plane)), z);
        let Some(climb) = bevel.climb(z) else { return };
        let up = DVec3::new(1.0, 1.0, 2.0 * z - 1.0);
        for triangle in &bevelled.slopes {
            let corner = |(k, normal): (u32, DVec3)| {
                let height = climb.height(bevelled.rises[k as usize]);
                (points[k as usize].extend(height), up * normal)
            };
            self.push_towards(z, triangle.map(corner).into_iter());
        }
    }

    /// Adds the sides between two heights.
    fn add_sides(&mut self, prepared: &FlatPrism, [low, high]: [f64; 2]) {
        if low >= high {
            return;
        }
        let FlatPrism { flat, normals, .. } = prepared;
        for (&[a, b], [na, nb]) in flat.border.iter().zip(normals) {
            let at = |k: u32, z: f64| flat.points[k as usize].extend(z);
            let corners = [
                (at(a, low), na),
                (at(b, low), nb),
                (at(b, high), nb),
                (at(a, high), na),
            ];
            self.push(corners.into_iter().map(|(p, n)| (p, n.extend(0.0))));
        }
    }
}

/// The polygons of a cap; triangles where the triangulation of a polygon would overlap.
fn caps(points: &[DVec2], tiles: &[Tile]) -> Vec<Vec<u32>> {
    let mut whole = Vec::new();
    for tile in tiles {
        let points = tile.ring.iter().map(|&k| points[k as usize].extend(0.0));
        let mut mesh = Mesh {
            positions: points.collect(),
            ..Mesh::default()
        };
        mesh.push_face(&(0..tile.ring.len() as u32).collect::<Vec<_>>(), 0);
        let triangles = mesh.triangulate(0);
        let area = |t: &[u32; 3]| area_vector(&t.map(|k| mesh.positions[k as usize])).z;
        if triangles.iter().all(|t| area(t) > 0.0) {
            whole.push(tile.ring.clone());
        } else {
            whole.extend(tile.triangles.iter().map(|t| t.to_vec()));
        }
    }
    whole
}

/// Outward normals in the figure's plane at both ends of each side, any length. Where sides join
/// smoothly, their normals agree.
fn side_normals(flat: &FlatFigure) -> Vec<[DVec2; 2]> {
    let outward = |side: &[u32; 2]| {
        let [a, b] = side.map(|k| flat.points[k as usize]);
        -(b - a).perp().normalize_or_zero()
    };
    let mut sums = vec![(DVec2::ZERO, 0); flat.points.len()];
    for side in &flat.border {
        for &end in side {
            let sum = &mut sums[end as usize];
            *sum = (sum.0 + outward(side), sum.1 + 1);
        }
    }
    let normal = |side: &[u32; 2], end: u32| {
        let (sum, count) = sums[end as usize];
        let smooth = flat.is_smooth[end as usize] && count == 2 && sum.length() > 0.1;
        if smooth { sum } else { outward(side) }
    };
    let both = |side: &[u32; 2]| side.map(|end| normal(side, end));
    flat.border.iter().map(both).collect()
}
