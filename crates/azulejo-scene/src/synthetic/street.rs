//! A street under a dome of sky, modelled after a thesis on specular radiosity.

mod dome;
mod house;

use super::metres;
use super::sheets::{Plate, Sheets, steps};
use crate::{Camera, Material, MaterialId, Object, Rgb, Scene, Shape};
use dome::Dome;
use glam::{DVec2, DVec3};
use house::House;

/// A street of 24 houses under a dome of sky (metres, z up), closed: 61,795 quadrilaterals, of
/// which 2,407 form the sky and 59,388 the street.
///
/// Ten neighbouring patches of the sky act as the sun. A quarter of the windows are mirrors of
/// reflectance 0.4. The sky's quadrilaterals are equal in area to 12 %: rings of trapezoids between
/// parallels of latitude on a sphere of 100 m, and a flat field from 58° of altitude to the zenith,
/// because quadrilaterals on a sphere are flat only between parallels. All other facets are flat
/// and convex as well, every edge has two of them, and all fronts are towards the air.
///
/// After B. Sena, "Radiosity with specular surfaces", 2019, whose street in Bayonne has 61,795
/// quadrilaterals, 2,407 of them in the sky; nothing else is taken from it.
pub fn street() -> Scene {
    street_with_detail(1.0)
}

/// [`street`] with about `detail` times as many facets, 0.02..=16.
pub fn street_with_detail(detail: f64) -> Scene {
    let detail = detail.clamp(0.02, 16.0).sqrt();
    let site = Site::new(detail);
    let dome = Dome::new(detail);
    let mut sky = Sheets::default();
    dome.add_sky(&mut sky, SKY, SUN);
    let mut ground = Sheets::default();
    site.add_ground(&mut ground);
    dome.add_plain(&mut ground, &site.border(), GROUND);
    let mut scene = surroundings();
    let mut add = |name: String, sheets: Sheets| {
        let mesh = sheets.into_mesh();
        scene.objects.push(Object::new(name, Shape::Mesh(mesh)));
    };
    add("sky".into(), sky);
    add("ground".into(), ground);
    for (k, house) in site.houses.iter().enumerate() {
        let mut sheets = Sheets::default();
        house.build(&site.lines, k as u64, &mut sheets);
        add(format!("house{k}"), sheets);
    }
    scene
}

const GROUND: MaterialId = 0;
const ASPHALT: MaterialId = 1;
const ROOF: MaterialId = 2;
const WINDOW: MaterialId = 3;
const MIRROR: MaterialId = 4;
const SKY: MaterialId = 5;
const SUN: MaterialId = 6;
/// Index of the first of the consecutive plaster materials.
const PLASTER: MaterialId = 7;
const PLASTERS: usize = 4;

fn surroundings() -> Scene {
    let plaster = |k: usize, r, g, b| Material::diffuse(format!("plaster{k}"), Rgb::new(r, g, b));
    let materials = vec![
        Material::diffuse("ground", Rgb::new(0.25, 0.24, 0.2)),
        Material::diffuse("asphalt", Rgb::grey(0.12)),
        Material::diffuse("roof", Rgb::new(0.4, 0.16, 0.1)),
        Material::diffuse("window", Rgb::new(0.06, 0.07, 0.08)),
        Material::mirror("mirror", Rgb::grey(0.4)),
        Material::emitter("sky", Rgb::new(0.7, 0.85, 1.1)),
        Material::emitter("sun", Rgb::new(420.0, 390.0, 330.0)),
        plaster(0, 0.68, 0.62, 0.5),
        plaster(1, 0.7, 0.7, 0.66),
        plaster(2, 0.6, 0.42, 0.32),
        plaster(3, 0.5, 0.55, 0.6),
    ];
    Scene {
        materials,
        cameras: vec![Camera {
            name: "street".into(),
            eye: DVec3::new(-52.0, -1.5, 4.0),
            target: DVec3::new(0.0, 1.0, 6.5),
            up: DVec3::Z,
            vertical_fov: 1.0,
            size: Some((800, 500)),
        }],
        units: metres(),
        ..Scene::default()
    }
}

/// The built-up rectangle around the street, which runs along x.
struct Site {
    lines: [Vec<f64>; 2],
    houses: Vec<House>,
    /// Rows of cells that are the street.
    street: std::ops::Range<usize>,
}

/// Houses on each side of the street.
const HOUSES: usize = 12;
const HALF_LENGTH: f64 = 60.0;
const HALF_WIDTH: f64 = 24.0;

impl Site {
    /// 197 × 80 cells of 0.6 m; houses of 15 × 18 cells, 14 cells of street between them.
    fn new(detail: f64) -> Site {
        let of = |n: usize| ((n as f64 * detail).round() as usize).max(1);
        let (wide, margin, half_street) = (of(15), of(3), of(7));
        // Ridges run along the middle, so houses are an even number of cells deep.
        let (deep, behind) = (2 * of(9), of(15));
        let nx = HOUSES * (wide + 1) - 1 + 2 * margin;
        let ny = 2 * (half_street + deep + behind);
        let lines = [
            steps(-HALF_LENGTH, HALF_LENGTH, nx),
            steps(-HALF_WIDTH, HALF_WIDTH, ny),
        ];
        let house = |k: usize| {
            let (column, side) = (k % HOUSES, k / HOUSES);
            let x = margin + column * (wide + 1);
            let y = [behind, behind + deep + 2 * half_street][side];
            House::new(k, [x, y], [wide, deep], detail)
        };
        Site {
            lines,
            houses: (0..2 * HOUSES).map(house).collect(),
            street: behind + deep..behind + deep + 2 * half_street,
        }
    }

    fn add_ground(&self, sheets: &mut Sheets) {
        let plate = Plate::from_lines(&self.lines[0], &self.lines[1]);
        sheets.sheet(&plate.at(0.0), |i, j| {
            let is_built = self.houses.iter().any(|h| h.covers(i, j));
            match (is_built, self.street.contains(&j)) {
                (true, _) => None,
                (false, true) => Some(ASPHALT),
                (false, false) => Some(GROUND),
            }
        });
    }

    /// The rectangle's border from the middle of its right side, counter-clockwise, each point once.
    fn border(&self) -> Vec<DVec2> {
        let mut border = Plate::from_lines(&self.lines[0], &self.lines[1]).border();
        border.pop();
        let [nx, ny] = [self.lines[0].len() - 1, self.lines[1].len() - 1];
        border.rotate_left(nx + ny / 2);
        border
    }
}
