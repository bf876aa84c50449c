//! Prisms that emit: lamps in the form of letters, sampled on their own exact surface.
//!
//! The planes are sampled by rejection in the cells of a grid that the figure touches, so that the
//! density is the same everywhere and no polygon stands in for the outline. The sides are sampled
//! along pieces of the curves. Solids within set operations are left to chance: where their surface
//! is cut away is known to rays alone.

use super::bevel_surface::BevelSurface;
use super::emitters::{Emission, EmitterPoint};
use azulejo_scene::figure::{Rectangle, Segment};
use azulejo_scene::math::normal_matrix;
use azulejo_scene::{Figure, Material, Prism, Scene, Shape, Solid};
use glam::{DVec2, DVec3};

/// Cells of the grid along the longer edge of the figure.
const CELLS: usize = 24;

/// Pieces of each curve.
pub(super) const PIECES: usize = 8;

/// Distance from a curve at which its two sides are told apart, relative to the figure's size.
const BESIDE: f64 = 1e-7;

/// Where a point is on a prism, in the terms of a [`Hit`](crate::Hit).
#[derive(Clone, Copy, Debug)]
pub(crate) struct PrismPlace {
    /// 0 and 1 the planes, then the curves.
    pub part: u32,
    /// Parameter of the curve.
    pub u: f64,
    /// In the world.
    pub position: DVec3,
}

/// A prism that emits from its outside.
#[derive(Clone, Debug)]
pub(crate) struct PrismEmitter<'a> {
    prism: &'a Prism,
    pub emission: Emission,
    /// The object, and the index of its leaf.
    pub key: (u32, u32),
    /// Middles of the cells that the figure touches, and their half edges.
    cells: Vec<DVec2>,
    half_cell: DVec2,
    curves: Vec<Segment>,
    bevel: Option<BevelSurface<'a>>,
    /// Sum of the rough areas up to each side piece, which count over all curves, and each strip of a bevel.
    ends: Vec<f64>,
    /// Rough area of the cells of one plane in the world, and of all sides and bevels.
    plane_area: f64,
    side_area: f64,
}

impl<'a> PrismEmitter<'a> {
    /// `None` for a prism without area.
    fn new(key: (u32, u32), prism: &'a Prism, material: &Material) -> Option<PrismEmitter<'a>> {
        let (cells, half_cell) = cells(&prism.figure);
        let [x, y, z] = axes(prism);
        let curves: Vec<Segment> = prism.figure.segments().collect();
        let bevel = prism.bevel.as_ref().map(|b| BevelSurface::new(prism, b));
        let height = height(&bevel);
        let mut side_area = 0.0;
        let mut ends = Vec::with_capacity(curves.len() * PIECES);
        for k in 0..curves.len() * PIECES {
            let curve = &curves[k / PIECES];
            let start = piece_start(k);
            let chord = curve.at(start + 1.0 / PIECES as f64) - curve.at(start);
            side_area += height * (chord.x * x + chord.y * y).cross(z).length();
            ends.push(side_area);
        }
        for area in bevel.iter().flat_map(BevelSurface::areas) {
            side_area += area;
            ends.push(side_area);
        }
        let cell = 4.0 * half_cell.x * half_cell.y;
        let plane_area = cells.len() as f64 * cell * x.cross(y).length();
        let area = 2.0 * plane_area + side_area;
        (area > 0.0 && area.is_finite()).then(|| PrismEmitter {
            prism,
            emission: Emission::new(material.emission, false, area),
            key,
            cells,
            half_cell,
            curves,
            bevel,
            ends,
            plane_area,
            side_area,
        })
    }

    /// A point of two numbers in 0..1; `None` for one of the points of the cells that are outside the
    /// figure, or on a curve inside it.
    pub fn point(&self, u: (f64, f64)) -> Option<EmitterPoint> {
        let mut chosen = u.0 * self.area();
        for plane in [0, 1] {
            if chosen < self.plane_area {
                return self.on_plane(plane, (chosen / self.plane_area, u.1));
            }
            chosen -= self.plane_area;
        }
        self.on_side(chosen.min(self.side_area), u.1)
    }

    fn area(&self) -> f64 {
        2.0 * self.plane_area + self.side_area
    }

    fn on_plane(&self, plane: u32, u: (f64, f64)) -> Option<EmitterPoint> {
        let place = u.0 * self.cells.len() as f64;
        let cell = (place as usize).min(self.cells.len() - 1);
        let within = DVec2::new(place - cell as f64, u.1);
        let p = self.cells[cell] + (2.0 * within - 1.0) * self.half_cell;
        let z = f64::from(plane);
        let normal = DVec3::new(0.0, 0.0, 2.0 * z - 1.0);
        let is_inside = self.prism.figure.contains(p) && self.is_on_plane(p, z);
        is_inside.then(|| self.placed(p.extend(z), normal, self.area()))
    }

    /// Whether a bevel leaves a point of a plane that is inside the figure.
    fn is_on_plane(&self, p: DVec2, z: f64) -> bool {
        let setback = |b: &BevelSurface| b.bevel().setback(z);
        let bevel = self.bevel.as_ref();
        bevel.is_none_or(|b| b.is_set_back(p, setback(b)))
    }

    fn on_side(&self, chosen: f64, share: f64) -> Option<EmitterPoint> {
        let piece = self.ends.partition_point(|&end| end <= chosen);
        let piece = piece.min(self.ends.len().checked_sub(1)?);
        let before = piece.checked_sub(1).map_or(0.0, |k| self.ends[k]);
        let within = (chosen - before) / (self.ends[piece] - before);
        if let Some(strip) = piece.checked_sub(self.curves.len() * PIECES) {
            let at = [within.clamp(0.0, 1.0), share];
            let on = self.bevel.as_ref()?.point(strip, at)?;
            let area = self.strip_density(piece, on.stretch)?.recip();
            return Some(self.placed(on.position, on.normal, area));
        }
        let z = match &self.bevel {
            Some(b) => b.bevel().sides()[0] + share * height(&self.bevel),
            None => share,
        };
        let t = piece_start(piece) + within.clamp(0.0, 1.0) / PIECES as f64;
        let curve = &self.curves[piece / PIECES];
        let (p, along) = (curve.at(t), curve.derivative(t));
        let aside = self.beside(DVec2::new(along.y, -along.x));
        let [right, left] = [p + aside, p - aside].map(|p| self.prism.figure.contains(p));
        let outward = if left { aside } else { -aside };
        let area = self.side_density(piece, along)?.recip();
        (right != left).then(|| self.placed(p.extend(z), outward.extend(0.0), area))
    }

    /// A short step in that direction.
    fn beside(&self, direction: DVec2) -> DVec2 {
        let size = self.half_cell.max_element() * CELLS as f64;
        direction.normalize_or_zero() * (BESIDE * size)
    }

    /// Density by world area on a piece of a side, where the curve's derivative is `along`. `None`
    /// where it vanishes.
    fn side_density(&self, piece: usize, along: DVec2) -> Option<f64> {
        let [x, y, z] = axes(self.prism);
        let stretch = (along.x * x + along.y * y).cross(z).length() / PIECES as f64;
        self.strip_density(piece, stretch * height(&self.bevel))
    }

    /// Density by world area on a piece of a side or a strip of a bevel, whose parameters are stretched that much.
    fn strip_density(&self, piece: usize, stretch: f64) -> Option<f64> {
        let before = piece.checked_sub(1).map_or(0.0, |k| self.ends[k]);
        let share = (self.ends[piece] - before) / self.area();
        let density = share / stretch;
        (density.is_finite() && density > 0.0).then_some(density)
    }

    fn placed(&self, p: DVec3, normal: DVec3, area: f64) -> EmitterPoint {
        let map = &self.prism.world_from_figure;
        EmitterPoint {
            position: map.transform_point3(p),
            normal: (normal_matrix(map.matrix3) * normal).normalize_or_zero(),
            area,
        }
    }

    /// One over the density by area with which [`point`](PrismEmitter::point) finds a place;
    /// infinite where it finds none.
    pub fn area_at(&self, place: PrismPlace) -> f64 {
        let Some(curve) = place.part.checked_sub(2) else {
            return self.area();
        };
        let on_bevel = self.bevel.as_ref().and_then(|b| b.locate(place.position));
        if let Some((strip, stretch)) = on_bevel {
            let density = self.strip_density(self.curves.len() * PIECES + strip, stretch);
            return density.map_or(f64::INFINITY, f64::recip);
        }
        let Some(segment) = self.curves.get(curve as usize) else {
            return f64::INFINITY;
        };
        let within = ((place.u * PIECES as f64) as usize).min(PIECES - 1);
        let piece = curve as usize * PIECES + within;
        let density = self.side_density(piece, segment.derivative(place.u));
        density.map_or(f64::INFINITY, f64::recip)
    }
}

/// The height of the sides, between bevels if there are any.
fn height(bevel: &Option<BevelSurface>) -> f64 {
    bevel.as_ref().map_or(1.0, |b| {
        let [low, high] = b.bevel().sides();
        high - low
    })
}

/// The images of the figure's axes and of the extrusion.
fn axes(prism: &Prism) -> [DVec3; 3] {
    let map = &prism.world_from_figure;
    [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| map.transform_vector3(axis))
}

/// Parameter at which a piece starts, pieces counting over all curves.
fn piece_start(piece: usize) -> f64 {
    (piece % PIECES) as f64 / PIECES as f64
}

/// The middles of the cells of a grid over the figure that it may touch, and half the edges of one.
fn cells(figure: &Figure) -> (Vec<DVec2>, DVec2) {
    let bounds = figure.bounds();
    let size = bounds.max - bounds.min;
    if !(size.min_element() > 0.0 && size.is_finite()) {
        return (Vec::new(), DVec2::ZERO);
    }
    let count = |edge: f64| (CELLS as f64 * edge / size.max_element()).ceil().max(1.0) as usize;
    let (columns, rows) = (count(size.x), count(size.y));
    let edge = DVec2::new(size.x / columns as f64, size.y / rows as f64);
    let column = |x: f64| (((x - bounds.min.x) / edge.x).max(0.0) as usize).min(columns - 1);
    let row = |y: f64| (((y - bounds.min.y) / edge.y).max(0.0) as usize).min(rows - 1);
    let mut touched = vec![false; columns * rows];
    for segment in figure.segments() {
        for k in 0..PIECES {
            let Rectangle { min, max } = piece_bounds(&segment, k);
            for y in row(min.y)..=row(max.y) {
                let line = &mut touched[y * columns..(y + 1) * columns];
                line[column(min.x)..=column(max.x)].fill(true);
            }
        }
    }
    let middle = |k: usize| {
        let place = DVec2::new((k % columns) as f64 + 0.5, (k / columns) as f64 + 0.5);
        bounds.min + place * edge
    };
    // A cell that no curve touches is all inside or all outside.
    let is_kept = |k: &usize| touched[*k] || figure.contains(middle(*k));
    let kept = (0..columns * rows).filter(is_kept).map(middle);
    (kept.collect(), 0.5 * edge)
}

/// A rectangle around a piece of a curve, a little larger than it.
fn piece_bounds(segment: &Segment, piece: usize) -> Rectangle {
    let at = |k: usize| k as f64 / PIECES as f64;
    let (a, b) = (segment.at(at(piece)), segment.at(at(piece + 1)));
    // The chord of a stretch h of the parameter deviates by at most h² max|B″| / 8.
    let bend = match *segment {
        Segment::Line(_) => 0.0,
        Segment::Cubic([a, b, c, d]) => {
            6.0 * (a - 2.0 * b + c).length().max((b - 2.0 * c + d).length())
        }
    };
    let bounds = segment.bounds();
    let size = (bounds.max - bounds.min).max_element();
    let margin = DVec2::splat(bend / (8.0 * (PIECES * PIECES) as f64) + 1e-9 * size);
    Rectangle {
        min: a.min(b) - margin,
        max: a.max(b) + margin,
    }
}

/// The prisms of a scene that emit, outside of set operations, in the order of their keys.
pub(crate) fn prism_emitters(scene: &Scene) -> Vec<PrismEmitter<'_>> {
    let mut emitters = Vec::new();
    for (object, o) in (0..).zip(&scene.objects) {
        let Shape::Exact(exact) = &o.shape else {
            continue;
        };
        let mut leaf = 0;
        for solid in &exact.solids {
            if let Solid::Prism(prism) = solid {
                let material = &scene.materials[prism.material as usize];
                if material.is_emitter() {
                    emitters.extend(PrismEmitter::new((object, leaf), prism, material));
                }
            }
            leaf += solid.leaves().len() as u32;
        }
    }
    emitters
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::{Bevel, BevelEnds, BevelProfile, Exact, Rgb};
    use glam::DAffine3;
    use std::sync::Arc;

    /// The mean of one over the density is the area, that of the polygons.
    #[test]
    fn samples_of_bevelled_letters_count_for_their_area() {
        let corners = [
            (0.0, 0.0),
            (0.7, 0.0),
            (0.7, 0.2),
            (0.25, 0.2),
            (0.3, 0.8),
            (0.1, 1.0),
            (0.0, 1.0),
        ];
        let figure = Arc::new(Figure::polygon(corners.map(DVec2::from)));
        let material = Material::emitter("lamp", Rgb::WHITE);
        for profile in [BevelProfile::Chamfer, BevelProfile::Round] {
            for (inset, depth, ends) in [
                (0.05, 0.2, BevelEnds::Front),
                (0.05, 0.5, BevelEnds::Both),
                (0.3, 0.4, BevelEnds::Both),
            ] {
                let bevel = Bevel {
                    profile,
                    inset,
                    depth,
                    ends,
                };
                let prism = Prism {
                    figure: Arc::clone(&figure),
                    world_from_figure: DAffine3::from_scale(DVec3::new(2.0, 1.5, 0.3)),
                    material: 0,
                    bevel: Some(Arc::new(bevel)),
                };
                let emitter = PrismEmitter::new((0, 0), &prism, &material).unwrap();
                let side = 500;
                let at = |k: u32| (f64::from(k) + 0.5) / f64::from(side);
                let each = (0..side * side).filter_map(|k| {
                    // Along the surface as finely as possible: all of it depends on the first number.
                    let first = (at(k % side) + f64::from(k / side)) / f64::from(side);
                    emitter.point((first, (f64::from(k) * 0.618_033_988_75).fract()))
                });
                let area = each.map(|p| p.area).sum::<f64>() / f64::from(side * side);
                let polygons = Exact::new(vec![Solid::Prism(prism.clone())]).areas(1e-5)[&0];
                assert!(
                    (area / polygons - 1.0).abs() < 0.005,
                    "{bevel:?}: {area} {polygons}"
                );
            }
        }
    }
}
