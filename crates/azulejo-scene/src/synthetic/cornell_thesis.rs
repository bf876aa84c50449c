//! A closed box with a spherical lamp and five objects, modelled after a thesis on specular
//! radiosity.

use super::metres;
use super::sheets::{Plate, Sheets, between, border, raised, steps};
use crate::{Camera, Material, MaterialId, Object, Rgb, Scene, Shape};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// A closed cube of 2 metres (z up) with a spherical lamp, a panel in the middle, a box, a stand, a
/// head and a torus: 12,922 facets, 96 of them triangles, as many as in the Cornell box of the
/// thesis.
///
/// The first `mirrors` of the panel's front, row by row from below, are mirrors of reflectance 0.9.
/// The front has 8 × 8 fields, so that 64 mirrors cover it; for more than 64 it has 50 × 30 and the
/// back and rims are divided alike, which makes 15,922 facets. Numbers above 1,500 count as 1,500.
///
/// Every body is closed and is 5 mm above the floor. All facets are flat and convex, with their
/// fronts towards the air. After B. Sena, "Radiosity with specular surfaces", 2019, from which only
/// the numbers and kinds of objects are taken.
pub fn cornell_thesis(mirrors: usize) -> Scene {
    cornell_thesis_at(mirrors, 1.0)
}

/// [`cornell_thesis`] with about `detail` times as many facets, 0.01..=16, for quick tests and for
/// heavier ones. The panel is unchanged.
pub fn cornell_thesis_at(mirrors: usize, detail: f64) -> Scene {
    let detail = Detail(detail.clamp(0.01, 16.0).sqrt());
    let mut scene = surroundings();
    let mut add = |name: &str, sheets: Sheets| {
        let mesh = sheets.into_mesh();
        scene.objects.push(Object::new(name, Shape::Mesh(mesh)));
    };
    add("room", room(&detail));
    add("lamp", lamp(&detail));
    add("panel", panel(mirrors.min(MOST_MIRRORS)));
    add("box", block(&detail));
    add("stand", stand(&detail));
    add("head", head(&detail));
    add("torus", torus(&detail));
    scene
}

const MOST_MIRRORS: usize = 1500;

const WHITE: MaterialId = 0;
const RED: MaterialId = 1;
const GREEN: MaterialId = 2;
const LAMP: MaterialId = 3;
const MIRROR: MaterialId = 4;
const WOOD: MaterialId = 5;
const BLUE: MaterialId = 6;

/// The gap between the floor and the objects.
const JOINT: f64 = 0.005;

/// Factor on the number of parts into which edges are divided.
struct Detail(f64);

impl Detail {
    fn of(&self, n: usize) -> usize {
        ((n as f64 * self.0).round() as usize).max(1)
    }

    /// As `of`, rounded to a multiple of `step`, at least twice `step`.
    fn by(&self, n: usize, step: usize) -> usize {
        step * ((n as f64 * self.0 / step as f64).round() as usize).max(2)
    }
}

fn surroundings() -> Scene {
    let materials = vec![
        Material::diffuse("white", Rgb::new(0.73, 0.71, 0.68)),
        Material::diffuse("red", Rgb::new(0.63, 0.07, 0.05)),
        Material::diffuse("green", Rgb::new(0.14, 0.45, 0.09)),
        Material::emitter("lamp", Rgb::new(17.0, 14.0, 10.0)),
        Material::mirror("mirror", Rgb::grey(0.9)),
        Material::diffuse("wood", Rgb::new(0.5, 0.32, 0.18)),
        Material::diffuse("blue", Rgb::new(0.25, 0.35, 0.6)),
    ];
    Scene {
        materials,
        cameras: vec![Camera {
            name: "front".into(),
            eye: DVec3::new(0.0, -0.97, 1.05),
            target: DVec3::new(0.0, 0.5, 0.75),
            up: DVec3::Z,
            vertical_fov: 1.6,
            size: Some((512, 512)),
        }],
        units: metres(),
        ..Scene::default()
    }
}

/// The cube −1..=1 in x and y, 0..=2 in z, seen from inside: 6 × 36 × 36.
fn room(detail: &Detail) -> Sheets {
    let mut sheets = Sheets::default();
    let n = detail.of(36);
    let lines = steps(-1.0, 1.0, n);
    let plate = Plate::from_lines(&lines, &lines);
    let mut ceiling = plate.at(2.0);
    ceiling.reverse();
    sheets.sheet(&plate.at(0.0), |_, _| Some(WHITE));
    sheets.sheet(&ceiling, |_, _| Some(WHITE));
    let mut around = plate.border();
    around.reverse();
    let walls = between(&raised(&around, 0.0), &raised(&around, 2.0), n);
    // Clockwise from the corner in front on the left: left, back, right, front.
    let sides = [RED, WHITE, GREEN, WHITE];
    sheets.sheet(&walls, |i, _| Some(sides[i / n]));
    sheets
}

/// A ball of 16 × 10: 32 triangles, 128 quadrilaterals.
fn lamp(detail: &Detail) -> Sheets {
    let mut sheets = Sheets::default();
    let (around, rings) = (detail.by(16, 4), detail.of(10).max(3));
    let outline: Vec<DVec2> = closed(around, DVec2::from_angle);
    let rings = (1..rings).map(|k| {
        let (s, c) = (PI * k as f64 / rings as f64).sin_cos();
        Ring::new(0.15 * s, DVec3::new(0.0, 0.1, 1.7 - 0.15 * c))
    });
    let rings: Vec<_> = rings.collect();
    let pole = |up: f64| DVec3::new(0.0, 0.1, 1.7 + 0.15 * up);
    capped(&mut sheets, &outline, &rings, [pole(-1.0), pole(1.0)], LAMP);
    sheets
}

/// The panel, 3 cm thick, turned towards the viewer: 2 × 8 × 8 + 4 × 8, or with 50 × 30 fields.
fn panel(mirrors: usize) -> Sheets {
    let mut sheets = Sheets::default();
    let [nx, ny] = if mirrors > 64 { [50, 30] } else { [8, 8] };
    let (across, up) = (DVec2::from_angle(0.25).extend(0.0), DVec3::Z);
    let thick = 0.03 * up.cross(across);
    let foot = DVec3::new(0.0, 0.35, 0.35) - 0.5 * across;
    let (along, above) = (steps(0.0, 1.0, nx), steps(0.0, 0.8, ny));
    let row = |&z: &f64| along.iter().map(|&x| foot + x * across + z * up).collect();
    let front: Vec<Vec<DVec3>> = above.iter().map(row).collect();
    let behind = |row: &Vec<DVec3>| row.iter().map(|&p| p + thick).collect();
    let mut back: Vec<Vec<DVec3>> = front.iter().map(behind).collect();
    let rim = between(&border(&back), &border(&front), 1);
    back.reverse();
    sheets.sheet(&front, |i, j| {
        if j * nx + i < mirrors {
            Some(MIRROR)
        } else {
            Some(WHITE)
        }
    });
    sheets.sheet(&back, |_, _| Some(WHITE));
    sheets.sheet(&rim, |_, _| Some(WHITE));
    sheets
}

/// A box of 10 × 10 × 20: 1,000 quadrilaterals.
fn block(detail: &Detail) -> Sheets {
    let (n, high) = (detail.of(10), detail.of(20));
    let plate = Plate::turned(DVec2::new(-0.6, -0.1), DVec2::splat(0.4), 0.35, [n, n]);
    let rings = [
        Ring::new(1.0, DVec3::Z * JOINT),
        Ring::new(1.0, DVec3::Z * 0.8),
    ];
    let mut sheets = Sheets::default();
    upright(&mut sheets, &plate, &divided(&rings, high), WOOD);
    sheets
}

/// A stand of square sections: 10 × 10 below and above, 40 × 30 around.
fn stand(detail: &Detail) -> Sheets {
    let n = detail.of(10);
    let centre = DVec2::new(0.5, -0.05);
    let plate = Plate::turned(DVec2::ZERO, DVec2::splat(0.4), -0.2, [n, n]);
    let ring = |scale: f64, z: f64| Ring::new(scale, centre.extend(z));
    // Base, neck, column, head and plate: six rows each.
    let profile = [
        ring(1.0, JOINT),
        ring(1.0, 0.08),
        ring(0.5, 0.12),
        ring(0.42, 0.4),
        ring(0.75, 0.46),
        ring(0.75, 0.52),
    ];
    let mut sheets = Sheets::default();
    upright(&mut sheets, &plate, &divided(&profile, detail.of(6)), WHITE);
    sheets
}

/// A head on the stand, with nose and ears: 64 triangles, 32 × 41 quadrilaterals.
///
/// All sections are scaled copies of one outline, so that the facets are flat.
fn head(detail: &Detail) -> Sheets {
    let (around, rings) = (detail.by(32, 4), detail.of(42).max(3));
    let bump = |a: f64, at: f64, width: f64| {
        let off = (a - at + PI).rem_euclid(TAU) - PI;
        (-(off / width).powi(2)).exp()
    };
    let outline = closed(around, |a| {
        let (nose, ears) = (
            bump(a, 1.5 * PI, 0.3),
            bump(a, 0.0, 0.25) + bump(a, PI, 0.25),
        );
        DVec2::from_angle(a) * DVec2::new(0.85, 1.0) * (1.0 + 0.25 * nose + 0.3 * ears)
    });
    let ring = |k: usize| {
        let t = k as f64 / (rings + 1) as f64;
        let (s, c) = (PI * t).sin_cos();
        // A narrow chin, pushed forward, below a round skull.
        let (chin, width) = (1.0 - t, 0.16 * s * (0.72 + 0.28 * (1.2 * t).min(1.0)));
        Ring::new(
            width,
            DVec3::new(0.5, -0.05 - 0.05 * chin * chin, 0.74 - 0.21 * c),
        )
    };
    let poles = [ring(0), ring(rings + 1)].map(|r| r.centre);
    let rings: Vec<_> = (1..=rings).map(ring).collect();
    let mut sheets = Sheets::default();
    capped(&mut sheets, &outline, &rings, poles, BLUE);
    sheets
}

/// A torus lying in front: 35 × 30.
fn torus(detail: &Detail) -> Sheets {
    let (around, section) = (detail.of(35).max(3), detail.of(30).max(3));
    let (centre, large, small) = (DVec3::new(-0.02, -0.45, JOINT + 0.09), 0.2, 0.09);
    let circle = closed(section, DVec2::from_angle);
    let row = |radial: &DVec2| -> Vec<DVec3> {
        let place = |c: &DVec2| (*radial * (large + small * c.x)).extend(small * c.y) + centre;
        circle.iter().map(place).collect()
    };
    let rows: Vec<_> = closed(around, DVec2::from_angle).iter().map(row).collect();
    let mut sheets = Sheets::default();
    // Along the section first: with the rows in their order around the torus the front would face
    // inside.
    let turned: Vec<_> = rows.into_iter().rev().collect();
    sheets.sheet(&turned, |_, _| Some(GREEN));
    sheets
}

/// `n` points over a full turn, followed by the first again.
fn closed(n: usize, at: impl Fn(f64) -> DVec2) -> Vec<DVec2> {
    (0..=n)
        .map(|k| at(TAU * (k % n) as f64 / n as f64))
        .collect()
}

/// A section: the scale of an outline and the position of its origin.
#[derive(Clone, Copy)]
struct Ring {
    scale: f64,
    centre: DVec3,
}

impl Ring {
    fn new(scale: f64, centre: DVec3) -> Ring {
        Ring { scale, centre }
    }

    fn points(&self, outline: &[DVec2]) -> Vec<DVec3> {
        let place = |p: &DVec2| (*p * self.scale).extend(0.0) + self.centre;
        outline.iter().map(place).collect()
    }
}

/// `n` steps between every two sections.
fn divided(rings: &[Ring], n: usize) -> Vec<Ring> {
    let mut sections = vec![rings[0]];
    for pair in rings.windows(2) {
        sections.extend((1..=n).map(|k| {
            let t = k as f64 / n as f64;
            Ring::new(
                pair[0].scale * (1.0 - t) + pair[1].scale * t,
                pair[0].centre * (1.0 - t) + pair[1].centre * t,
            )
        }));
    }
    sections
}

/// A body between two poles, sections from bottom to top.
fn capped(
    sheets: &mut Sheets,
    outline: &[DVec2],
    rings: &[Ring],
    [low, high]: [DVec3; 2],
    material: MaterialId,
) {
    let rows: Vec<_> = rings.iter().map(|r| r.points(outline)).collect();
    sheets.sheet(&rows, |_, _| Some(material));
    let (first, last) = (&rows[0], &rows[rows.len() - 1]);
    first
        .windows(2)
        .for_each(|p| sheets.face(&[low, p[1], p[0]], material));
    last.windows(2)
        .for_each(|p| sheets.face(&[high, p[0], p[1]], material));
}

/// A body with flat ends, sections from bottom to top, each a scaled copy of `plate`.
fn upright(sheets: &mut Sheets, plate: &Plate, rings: &[Ring], material: MaterialId) {
    let outline = plate.border();
    let rows: Vec<_> = rings.iter().map(|r| r.points(&outline)).collect();
    sheets.sheet(&rows, |_, _| Some(material));
    let end = |ring: &Ring| -> Vec<Vec<DVec3>> {
        let rows = plate.at(0.0);
        let flat = rows
            .iter()
            .map(|row| row.iter().map(|p| p.truncate()).collect());
        flat.map(|row: Vec<DVec2>| ring.points(&row)).collect()
    };
    let mut bottom = end(&rings[0]);
    bottom.reverse();
    sheets.sheet(&bottom, |_, _| Some(material));
    sheets.sheet(&end(&rings[rings.len() - 1]), |_, _| Some(material));
}
