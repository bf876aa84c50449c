//! What single precision makes of coordinates that are far from the origin.
//!
//! Numbers of 32 bits have 24 binary digits. A model spends some of them on its distance from the
//! origin: at 5,400,000 m, as in national grids, its coordinates are 0.5 m apart, however small it is.

use super::tessellate::mesh_of;
use crate::Position;
use crate::reading::warnings::Warnings;
use azulejo_scene::math::Aabb;
use azulejo_scene::{Mesh, Scene, Shape, Units};
use glam::DVec3;

/// How many times as far from the origin as it is large a model counts as far from it: then four of
/// the 24 digits are spent. Models around the origin, however finely they are divided, have what single precision
/// can give them.
const FAR: f64 = 16.0;

/// Part of the edges that is shorter than what counts as a detail; a few slivers say nothing of a model.
const SHORTEST: f64 = 0.05;

/// Largest change of a detail's length by rounding, relative to it, that is not worth a word.
const NOTICED: f64 = 1e-2;

/// Most edges of a mesh that are measured; of more, only some are.
const MEASURED_EDGES: usize = 1 << 20;

/// Distance between neighbouring numbers of single precision around a finite coordinate.
pub(crate) fn spacing(coordinate: f64) -> f64 {
    let size = (coordinate.abs() as f32).clamp(f32::MIN_POSITIVE, f32::MAX);
    // The exponent of a normal number, without its bias.
    let exponent = (size.to_bits() >> 23) as i32 - 127;
    2f64.powi(exponent - 23)
}

/// Where a set of coordinates lies, seen from the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CoordinateReach {
    /// The largest coordinate.
    pub reach: f64,
    /// The diagonal of the box around them.
    pub diagonal: f64,
}

impl CoordinateReach {
    /// That of a box; `None` if it is empty or not finite.
    pub fn of(bounds: Aabb) -> Option<CoordinateReach> {
        let extent = CoordinateReach {
            reach: bounds.min.abs().max(bounds.max.abs()).max_element(),
            diagonal: bounds.diagonal(),
        };
        (!bounds.is_empty() && extent.reach.is_finite()).then_some(extent)
    }

    /// Whether much of what single precision has is spent on the distance from the origin.
    pub fn is_far(&self) -> bool {
        self.reach > FAR * self.diagonal
    }
}

/// The largest change of a coordinate by rounding to single precision.
pub(crate) fn rounding(positions: impl Iterator<Item = DVec3>) -> f64 {
    let off = |x: f64| (f64::from(x as f32) - x).abs();
    let most = positions.map(|p| DVec3::new(off(p.x), off(p.y), off(p.z)).max_element());
    most.fold(0.0, f64::max)
}

/// The positions that faces use, some several times.
pub(crate) fn used_positions(mesh: &Mesh) -> impl Iterator<Item = DVec3> {
    let corners = mesh.faces.corners.iter();
    corners.map(|&v| mesh.positions[v as usize])
}

/// Length that most edges of the faces of a mesh have at least: the size of its details. Edges without
/// length count, since they are what rounding makes of short ones.
fn detail(mesh: &Mesh) -> f64 {
    let step = mesh.faces.corners.len() / MEASURED_EDGES + 1;
    let mut lengths: Vec<f64> = Vec::new();
    for face in (0..mesh.faces.len()).step_by(step) {
        let corners = mesh.faces.get(face);
        let next = corners.iter().cycle().skip(1);
        let length = |(&a, &b): (&u32, &u32)| {
            let [a, b] = [a, b].map(|v| mesh.positions[v as usize]);
            a.distance(b)
        };
        lengths.extend(corners.iter().zip(next).map(length));
    }
    if lengths.is_empty() {
        return f64::INFINITY;
    }
    let rank = (SHORTEST * lengths.len() as f64) as usize;
    *lengths.select_nth_unstable_by(rank, f64::total_cmp).1
}

/// Whether it shows in the details of a mesh that both ends of an edge may be off by so much.
pub(crate) fn is_noticed(off: f64, mesh: &Mesh) -> bool {
    2.0 * off > NOTICED * detail(mesh)
}

/// A point near the middle of a box, with few decimal digits.
pub(crate) fn near(bounds: Aabb) -> DVec3 {
    let centre = bounds.centre();
    let quarter = 0.25 * bounds.diagonal();
    if quarter < f64::MIN_POSITIVE {
        return centre;
    }
    let power = quarter.log10().floor() as i32;
    let round = |x: f64| match power {
        0.. => (x / 10f64.powi(power)).round() * 10f64.powi(power),
        // Quotients of whole numbers are as short as decimals can be.
        _ => (x * 10f64.powi(-power)).round() / 10f64.powi(-power),
    };
    let point = DVec3::new(round(centre.x), round(centre.y), round(centre.z));
    if point.is_finite() { point } else { centre }
}

/// Coordinates that single precision cannot tell apart well enough.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct CoarseCoordinates {
    /// Number of meshes.
    pub count: usize,
    /// The largest coordinate of the one with the largest.
    pub reach: f64,
}

impl CoarseCoordinates {
    /// Adds a mesh that is at some place, and whose coordinates are off by `off`.
    fn add(&mut self, mesh: &Mesh, off: impl FnOnce(CoordinateReach) -> f64) {
        let extent = CoordinateReach::of(mesh.bounds()).filter(CoordinateReach::is_far);
        let Some(extent) = extent else { return };
        if is_noticed(off(extent), mesh) {
            self.count += 1;
            self.reach = self.reach.max(extent.reach);
        }
    }

    /// Those of a scene as it was read from a file whose coordinates are in single precision.
    pub fn as_read(scene: &Scene) -> CoarseCoordinates {
        let mut coarse = CoarseCoordinates::default();
        for object in &scene.objects {
            if let Shape::Mesh(mesh) = &object.shape {
                coarse.add_read(mesh);
            }
        }
        coarse
    }

    /// Those that a scene would have in a file whose coordinates are in single precision.
    pub fn to_be_written(scene: &Scene) -> CoarseCoordinates {
        let mut coarse = CoarseCoordinates::default();
        for object in &scene.objects {
            // What is not far need not be tessellated.
            if CoordinateReach::of(object.bounds()).is_some_and(|extent| extent.is_far()) {
                coarse.add_written(&mesh_of(object));
            }
        }
        coarse
    }

    /// Adds a mesh in the coordinates of a file that has them in single precision; one that the file moves,
    /// as its coordinates show, is where it is by more digits than those.
    pub fn add_read(&mut self, mesh: &Mesh) {
        self.add(mesh, |extent| match rounding(used_positions(mesh)) {
            0.0 => 0.5 * spacing(extent.reach),
            _ => 0.0,
        });
    }

    /// Adds a mesh that will be written in single precision.
    pub fn add_written(&mut self, mesh: &Mesh) {
        self.add(mesh, |_| rounding(used_positions(mesh)));
    }

    /// How far apart they are, and where, in words; `None` if no mesh is coarse.
    pub fn words(&self, units: &Units) -> Option<String> {
        let unit = unit(units);
        let (at, apart) = (self.reach, spacing(self.reach));
        (self.count > 0).then(|| {
            format!(
                "coordinates as float32 at {}{unit} are {}{unit} apart",
                three_digits(at),
                three_digits(apart)
            )
        })
    }

    /// How to write the scene without the loss, if it can be as a whole.
    pub fn advice(&self, scene: &Scene) -> String {
        let bounds = scene.bounds();
        if !CoordinateReach::of(bounds).is_some_and(|extent| extent.is_far()) {
            return String::new();
        }
        let [x, y, z] = (-near(bounds) + 0.0).to_array();
        format!("; move the model to its origin with --place FILE:translate={x},{y},{z}")
    }

    /// The warning of what a file has lost; `None` if no mesh is coarse.
    pub fn message(&self, units: &Units) -> Option<String> {
        let words = self.words(units)?;
        Some(format!(
            "{words}, too much for the detail of a mesh: export it near the origin, or in double precision"
        ))
    }
}

/// Warns of a scene that comes from a file in single precision, and lost detail by it.
pub(crate) fn warn(scene: &Scene, file: &str, warnings: &mut Warnings) {
    let coarse = CoarseCoordinates::as_read(scene);
    if let Some(message) = coarse.message(&scene.units) {
        warnings.add_many(file, message, coarse.count, || Position::Whole);
    }
}

/// The sign of the unit of length with a space before it; empty if it is unknown or none of the usual.
fn unit(units: &Units) -> &'static str {
    const SIGNS: [(f64, &str); 6] = [
        (1.0, " m"),
        (1e-3, " mm"),
        (1e-2, " cm"),
        (1e3, " km"),
        (0.0254, " in"),
        (0.3048, " ft"),
    ];
    let metres = units.metres_per_unit.unwrap_or(0.0);
    let is = |(length, _): &&(f64, &str)| (metres / length - 1.0).abs() < 1e-9;
    SIGNS.iter().find(is).map_or("", |(_, sign)| sign)
}

/// A positive number with three significant digits, without an exponent where it is of usual size.
fn three_digits(number: f64) -> String {
    let rounded: f64 = format!("{number:.2e}").parse().unwrap_or(number);
    if (1e-6..1e12).contains(&rounded) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slab with a corner at a place.
    fn slab(at: DVec3, size: DVec3) -> Mesh {
        let corner = |k: u32| {
            let step = |axis: u32| f64::from(k >> axis & 1);
            at + size * DVec3::new(step(0), step(1), step(2))
        };
        let mut mesh = Mesh {
            positions: (0..8).map(corner).collect(),
            ..Mesh::default()
        };
        for face in [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ] {
            mesh.push_face(&face, 0);
        }
        mesh
    }

    #[test]
    fn numbers_are_apart() {
        for (coordinate, expected) in [
            (1.0, 2f64.powi(-23)),
            (-1.5, 2f64.powi(-23)),
            (5_400_000.0, 0.5),
            (500_000.0, 0.03125),
            (0.0, 2f64.powi(-149)),
            (1e300, 2f64.powi(104)),
        ] {
            assert_eq!(spacing(coordinate), expected, "{coordinate}");
        }
        let next = f64::from(5_400_000f32.next_up());
        assert_eq!(next - 5_400_000.0, spacing(5_400_000.0));
    }

    fn check(at: DVec3, size: DVec3, read: bool, written: bool) {
        let mut mesh = slab(at, size);
        let [mut as_read, mut as_written] = [CoarseCoordinates::default(); 2];
        as_written.add_written(&mesh);
        for p in &mut mesh.positions {
            *p = p.as_vec3().as_dvec3();
        }
        as_read.add_read(&mesh);
        assert_eq!(
            (as_read.count > 0, as_written.count > 0),
            (read, written),
            "{at} {size}"
        );
    }

    #[test]
    fn only_what_is_far_and_fine_is_coarse() {
        let utm = DVec3::new(500_000.25, 5_400_000.5, 300.125);
        let wall = DVec3::new(10.0, 0.3, 3.0);
        check(utm, wall, true, true);
        // A millimetre at ten kilometres, and around the origin.
        let sheet = DVec3::new(10.0, 10.0, 0.001);
        check(DVec3::splat(10_000.1), sheet, true, true);
        check(DVec3::splat(-5.0), sheet, false, false);
        check(DVec3::splat(0.1), DVec3::new(1e4, 1e4, 0.001), false, false);
        // A hundred metres away a wall is what it is.
        check(DVec3::new(100.1, 100.1, 0.1), wall, false, false);
        // Whole numbers lose nothing, but a reader cannot know what they were before.
        check(utm.floor(), DVec3::ONE, true, false);
        // Millimetres: a plate of a centimetre a kilometre away is right to a hundredth.
        check(
            DVec3::splat(1e6 + 0.1),
            DVec3::new(200.0, 100.0, 10.0),
            false,
            false,
        );
        check(
            DVec3::splat(1e6 + 0.1),
            DVec3::new(200.0, 100.0, 1.0),
            true,
            true,
        );
    }

    #[test]
    fn words_have_the_unit() {
        let coarse = CoarseCoordinates {
            count: 2,
            reach: 5_400_008.5,
        };
        let of = |metres_per_unit| Units {
            metres_per_unit,
            ..Units::default()
        };
        let words = coarse.words(&of(Some(1.0))).unwrap();
        assert_eq!(words, "coordinates as float32 at 5400000 m are 0.5 m apart");
        let words = coarse.words(&of(None)).unwrap();
        assert_eq!(words, "coordinates as float32 at 5400000 are 0.5 apart");
        assert_eq!(CoarseCoordinates::default().words(&of(None)), None);
        assert_eq!(three_digits(0.0009765625), "0.000977");
        assert_eq!(three_digits(1.5e-9), "1.5e-9");
    }
    fn check_near(min: [f64; 3], max: [f64; 3], expected: [f64; 3]) {
        let bounds = Aabb {
            min: min.into(),
            max: max.into(),
        };
        assert_eq!(near(bounds), DVec3::from(expected));
    }

    #[test]
    fn origins_are_short_numbers() {
        check_near(
            [500_000.25, 5_400_000.5, 300.125],
            [500_010.25, 5_400_008.5, 303.325],
            [500_005.0, 5_400_005.0, 302.0],
        );
        check_near([1.01, 2.0, 3.0], [1.03, 2.02, 3.0], [1.02, 2.01, 3.0]);
        check_near([7.5; 3], [7.5; 3], [7.5; 3]);
        let huge = DVec3::splat(1e308);
        let point = near(Aabb {
            min: 0.5 * huge,
            max: huge,
        });
        assert!(point.is_finite());
    }
}
