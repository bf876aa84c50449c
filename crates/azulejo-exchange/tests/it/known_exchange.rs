//! Exchange with known answers: every row of a table of reference values, from the factors of its rows.

use azulejo_exchange::network::STEFAN_BOLTZMANN;
use azulejo_exchange::{
    Enclosure, ExchangeFactors, Groups, HeatBalance, HeatProblem, RowCondition, RowTable,
    SpectralRange, SurfaceBand, band_fraction, exchange_factors, heat_balance,
};
use azulejo_factors::FormFactors;
use azulejo_factors::analytic::form_factor;
use azulejo_factors::form_factors::{Exchange, RowRemainder};
use azulejo_factors::truth::formulas::{coaxial_disks, on_common_edge, opposed, wedge};
use azulejo_trace::Progress;
use glam::DVec3;
use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_3, PI};

/// Surfaces with the factors of each row, from the diagonal on.
struct Surfaces {
    enclosure: Enclosure,
    emissivity: Vec<f64>,
}

/// Areas, factors from each row to those from it on, emissivities and mirror reflectances. What rows lack
/// goes to the sky.
fn surfaces(areas: &[f64], upper: &[&[f64]], emissivity: &[f64], mirrors: &[f64]) -> Surfaces {
    let n = areas.len();
    let factor = |i: usize, j: usize| {
        let (low, high) = (i.min(j), i.max(j));
        upper[low][high - low] * areas[low] / areas[i]
    };
    let rest = |i: usize| {
        let ended: f64 = (0..n).map(|j| factor(i, j) * (1.0 - mirrors[j])).sum();
        let sky = if 1.0 - ended > 1e-12 {
            1.0 - ended
        } else {
            0.0
        };
        RowRemainder {
            sky,
            ..RowRemainder::default()
        }
    };
    let row = |i: usize| {
        let entry = |j: usize| Exchange {
            column: j as u32,
            value: areas[i] * factor(i, j),
            error: 0.0,
        };
        (i..n).map(entry).collect::<Vec<Exchange>>()
    };
    Surfaces {
        enclosure: Enclosure {
            factors: FormFactors {
                exchange: (0..n).map(row).collect(),
                areas: areas.to_vec(),
                rest: (0..n).map(rest).collect(),
                ends: mirrors.iter().map(|m| 1.0 - m).collect(),
                ..FormFactors::default()
            },
            rows: RowTable {
                names: (0..n).map(|i| i.to_string()).collect(),
                ..RowTable::default()
            },
            outside: None,
        },
        emissivity: emissivity.to_vec(),
    }
}

fn nodes(count: usize) -> Groups {
    Groups {
        of_rows: (0..count as u32).map(Some).collect(),
        names: (0..count).map(|i| i.to_string()).collect(),
    }
}

impl Surfaces {
    fn grey(&self) -> SurfaceBand<'_> {
        SurfaceBand {
            enclosure: &self.enclosure,
            range: SpectralRange::Thermal,
            emissivity: self.emissivity.clone(),
        }
    }

    fn exchange(&self) -> ExchangeFactors {
        let count = self.emissivity.len();
        exchange_factors(&self.grey(), &nodes(count), &Progress::new()).unwrap()
    }

    fn gebhart(&self, a: usize, b: usize) -> f64 {
        self.exchange().gebhart(a, b).0
    }

    fn conductance(&self, a: usize, b: usize) -> f64 {
        self.exchange().conductance(a, b).0
    }

    fn factor(&self, i: usize, j: u32) -> f64 {
        self.enclosure.factors.get(i, j).0
    }

    fn heat(&self, conditions: &[RowCondition]) -> HeatBalance {
        let problem = HeatProblem {
            bands: &[self.grey()],
            conditions,
            surroundings: [0.0, 0.0],
            solar: &[],
        };
        heat_balance(&problem, &nodes(conditions.len()), &Progress::new()).unwrap()
    }
}

fn plates(emissivity: [f64; 2], [m1, m2]: [f64; 2]) -> Surfaces {
    let both = 1.0 / (1.0 - m1 * m2);
    surfaces(
        &[1.0; 2],
        &[&[m2 * both, both], &[m1 * both]],
        &emissivity,
        &[m1, m2],
    )
}

/// A convex body inside another of which it is seen as from everywhere: spheres, cylinders.
fn inside(areas: [f64; 2], emissivity: [f64; 2], mirror: f64) -> Surfaces {
    let outer = (1.0 - areas[0] / areas[1]) / (1.0 - mirror);
    surfaces(
        &areas,
        &[&[mirror, 1.0], &[outer]],
        &emissivity,
        &[0.0, mirror],
    )
}

fn spheres(emissivity: [f64; 2], mirror: f64) -> Surfaces {
    inside([4.0 * PI, 16.0 * PI], emissivity, mirror)
}

fn cylinders(emissivity: [f64; 2], mirror: f64) -> Surfaces {
    inside([PI, 4.0 * PI], emissivity, mirror)
}

fn triangle() -> Surfaces {
    surfaces(
        &[1.0; 3],
        &[&[0.0, 0.5, 0.5], &[0.0, 0.5], &[0.0]],
        &[0.8, 0.4, 0.2],
        &[0.0; 3],
    )
}

/// Floor, ceiling, and four walls as one.
fn cube_of_three(emissivity: [f64; 3]) -> Surfaces {
    let f12 = opposed(1.0, 1.0, 1.0);
    let wall = (1.0 - f12) / 4.0;
    let upper: [&[f64]; 3] = [
        &[0.0, f12, 1.0 - f12],
        &[0.0, 1.0 - f12],
        &[1.0 - 2.0 * wall],
    ];
    surfaces(&[1.0, 1.0, 4.0], &upper, &emissivity, &[0.0; 3])
}

/// The room of 4 × 3 × 2.5 with its faces x0 x1 y0 y1 z0 z1.
fn room(emissivity: [f64; 6]) -> Surfaces {
    let size = [4.0, 3.0, 2.5];
    let area = |i: usize| size[(i / 2 + 1) % 3] * size[(i / 2 + 2) % 3];
    let factor = |i: usize, j: usize| {
        let (a, b) = (i / 2, j / 2);
        if i == j {
            0.0
        } else if a == b {
            opposed(size[(a + 1) % 3], size[(a + 2) % 3], size[a])
        } else {
            // Face a extends along b, and b along a; both along the third axis.
            on_common_edge(size[3 - a - b], size[b], size[a])
        }
    };
    let upper: Vec<Vec<f64>> = (0..6)
        .map(|i| (i..6).map(|j| factor(i, j)).collect())
        .collect();
    let upper: Vec<&[f64]> = upper.iter().map(Vec::as_slice).collect();
    let areas: Vec<f64> = (0..6).map(area).collect();
    surfaces(&areas, &upper, &emissivity, &[0.0; 6])
}

/// The face of a unit cube at `at` along `axis`, seen from the side of `toward`, moved by whole cells.
fn square(axis: usize, at: f64, toward: f64, cell: [f64; 3]) -> Vec<DVec3> {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let corner = |a: f64, b: f64| {
        let mut p = cell;
        p[axis] = at;
        p[u] = cell[u] + a;
        p[v] = cell[v] + b;
        DVec3::from_array(p)
    };
    let mut corners = vec![
        corner(0.0, 0.0),
        corner(1.0, 0.0),
        corner(1.0, 1.0),
        corner(0.0, 1.0),
    ];
    if toward < at {
        corners.reverse();
    }
    corners
}

/// A unit cube whose faces x0 x1 y0 y1 z0 z1 may be mirrors, by images: the cube is repeated in all
/// cells that are seen through mirrors.
fn mirrored_cube(emissivity: [f64; 6], mirrors: [f64; 6]) -> Surfaces {
    const FAR: i32 = 90;
    // Cells along an axis with their weights: of what is beyond mirrors 0 and 1 of that axis.
    let cells = |axis: usize| -> Vec<(i32, f64)> {
        let [low, high] = [mirrors[2 * axis], mirrors[2 * axis + 1]];
        let mut cells = vec![(0, 1.0)];
        for (way, mut next) in [(1, [high, low]), (-1, [low, high])] {
            let mut weight = 1.0;
            for k in 1..=FAR {
                weight *= next[0];
                next.swap(0, 1);
                if weight < 1e-18 {
                    break;
                }
                cells.push((way * k, weight));
            }
        }
        cells
    };
    let factor = |i: usize, j: usize| {
        let (axis, side) = (i / 2, i % 2);
        let from = square(axis, side as f64, 0.5, [0.0; 3]);
        let mut sum = 0.0;
        let all = [cells(0), cells(1), cells(2)];
        for &(x, wx) in &all[0] {
            for &(y, wy) in &all[1] {
                for &(z, wz) in &all[2] {
                    let (cell, weight) = ([x, y, z], wx * wy * wz);
                    // In every other cell the mirror image has its sides exchanged.
                    let (to, k) = (j / 2, cell[j / 2]);
                    let flipped = usize::from(k.rem_euclid(2) == 1);
                    let plane = f64::from(k) + ((j % 2) ^ flipped) as f64;
                    let middle = f64::from(k) + 0.5;
                    // What lies behind the face that looks.
                    let ahead = if side == 0 { 0..i32::MAX } else { i32::MIN..1 };
                    if !ahead.contains(&cell[axis]) || (to == axis && plane == side as f64) {
                        continue;
                    }
                    let polygon = square(to, plane, middle, cell.map(f64::from));
                    sum += weight * form_factor(&from, &polygon);
                }
            }
        }
        sum
    };
    let upper: Vec<Vec<f64>> = (0..6)
        .map(|i| (i..6).map(|j| factor(i, j)).collect())
        .collect();
    let upper: Vec<&[f64]> = upper.iter().map(Vec::as_slice).collect();
    surfaces(&[1.0; 6], &upper, &emissivity, &mirrors)
}

const X0: usize = 0;
const X1: usize = 1;
const Z0: usize = 4;
const Z1: usize = 5;

fn one_mirror() -> Surfaces {
    mirrored_cube(
        [0.6, 0.6, 0.6, 0.6, 0.6, 0.1],
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.9],
    )
}

fn two_mirrors() -> Surfaces {
    mirrored_cube(
        [0.2, 0.2, 0.5, 0.5, 0.5, 0.5],
        [0.8, 0.8, 0.0, 0.0, 0.0, 0.0],
    )
}

fn mirrors_in_a_corner() -> Surfaces {
    mirrored_cube(
        [0.5, 0.1, 0.5, 0.1, 0.5, 0.5],
        [0.0, 0.7, 0.0, 0.9, 0.0, 0.0],
    )
}

/// Two strips of width 1 at 60°, per metre; the second may be a mirror.
fn strips(emissivity: [f64; 2], mirror: f64) -> Surfaces {
    let own = mirror * (1.0 - FRAC_PI_3.sin());
    let (third, half) = (&[own, 0.5][..], &[0.0][..]);
    surfaces(&[1.0; 2], &[third, half], &emissivity, &[0.0, mirror])
}

fn squares_at_60_degrees() -> Surfaces {
    surfaces(
        &[1.0; 2],
        &[&[0.0, wedge(FRAC_PI_3)], &[0.0]],
        &[0.7, 0.3],
        &[0.0; 2],
    )
}

/// Base, top and wall of a closed cylinder of radius 1 and height 2.
fn closed_cylinder() -> Surfaces {
    let f12 = coaxial_disks(1.0, 1.0, 2.0);
    let own = 1.0 - 2.0 * (1.0 - f12) / 4.0;
    let upper: [&[f64]; 3] = [&[0.0, f12, 1.0 - f12], &[0.0, 1.0 - f12], &[own]];
    surfaces(&[PI, PI, 4.0 * PI], &upper, &[0.9, 0.6, 0.3], &[0.0; 3])
}

/// A unit cube of 24 squares: four of each of z0, z1, x0, x1, y0, y1.
fn cube_of_24() -> (Surfaces, Vec<Vec<DVec3>>) {
    let mut polygons = Vec::new();
    for (axis, at) in [(2, 0.0), (2, 1.0), (0, 0.0), (0, 1.0), (1, 0.0), (1, 1.0)] {
        let face = square(axis, at, 0.5, [0.0; 3]);
        let along = [face[1] - face[0], face[3] - face[0]].map(|v| v / 2.0);
        for (a, b) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let start = face[0] + a * along[0] + b * along[1];
            let [u, v] = along;
            polygons.push(vec![start, start + u, start + u + v, start + v]);
        }
    }
    let factor = |i: usize, j: usize| {
        if i / 4 == j / 4 {
            0.0
        } else {
            form_factor(&polygons[i], &polygons[j])
        }
    };
    let upper: Vec<Vec<f64>> = (0..24)
        .map(|i| (i..24).map(|j| factor(i, j)).collect())
        .collect();
    let upper: Vec<&[f64]> = upper.iter().map(Vec::as_slice).collect();
    let cube = surfaces(&[0.25; 24], &upper, &[0.8; 24], &[0.0; 24]);
    (cube, polygons)
}

/// Fluxes of the 24 squares by name.
fn fluxes_of_24(name: &str) -> f64 {
    let (cube, polygons) = cube_of_24();
    let temperature = |i: usize| [500.0, 300.0, 400.0, 400.0, 400.0, 400.0][i / 4];
    let given: Vec<RowCondition> = (0..24)
        .map(|i| RowCondition::Temperature(temperature(i)))
        .collect();
    let heat = cube.heat(&given);
    let height = |i: usize| polygons[i].iter().map(|p| p.z).sum::<f64>() / 4.0;
    let is_wanted = |&i: &usize| match name {
        "cube24_q_floor" => i < 4,
        "cube24_q_ceiling" => (4..8).contains(&i),
        "cube24_q_wall_low" => i >= 8 && height(i) < 0.5,
        _ => i >= 8 && height(i) > 0.5,
    };
    let found: Vec<f64> = (0..24).filter(is_wanted).map(|i| heat.fluxes[i]).collect();
    assert!(
        found.iter().all(|q| (q - found[0]).abs() < 1e-9),
        "{found:?}"
    );
    found[0]
}

/// Temperature of what is in shadow in a spherical crater of a fifth of its sphere.
fn crater() -> f64 {
    let (share, albedo, emissivity) = (0.2, 0.12, 0.95);
    let rows: [&[f64]; 2] = [&[share * 0.5, share * 0.5], &[share * 0.5]];
    let crater = surfaces(&[0.5; 2], &rows, &[emissivity; 2], &[0.0; 2]);
    let thermal = crater.grey();
    let solar = SurfaceBand {
        range: SpectralRange::Solar,
        emissivity: vec![1.0 - albedo; 2],
        ..thermal.clone()
    };
    // The rim's disk catches the light; all of it falls on the lit half.
    let sun = 1361.0 * 10f64.to_radians().sin() * (1.0 - share) / 0.5;
    let problem = HeatProblem {
        bands: &[thermal, solar],
        conditions: &[RowCondition::Flux(0.0); 2],
        surroundings: [0.0, 0.0],
        solar: &[sun, 0.0],
    };
    heat_balance(&problem, &nodes(2), &Progress::new())
        .unwrap()
        .temperatures[1]
}

/// A plate in space under the sun.
fn sunlit_plate() -> f64 {
    let plate = surfaces(&[1.0], &[&[0.0]], &[0.8], &[0.0]);
    let thermal = plate.grey();
    let solar = SurfaceBand {
        range: SpectralRange::Solar,
        emissivity: vec![0.2],
        ..thermal.clone()
    };
    let problem = HeatProblem {
        bands: &[thermal, solar],
        conditions: &[RowCondition::Flux(0.0)],
        surroundings: [0.0, 0.0],
        solar: &[1361.0],
    };
    heat_balance(&problem, &nodes(1), &Progress::new())
        .unwrap()
        .temperatures[0]
}

/// Plates in two bands.
fn banded_plates() -> f64 {
    let plates = plates([0.5; 2], [0.0; 2]);
    let band = |range: [f64; 2], emissivity: [f64; 2]| SurfaceBand {
        range: SpectralRange::Between(range[0], range[1]),
        emissivity: emissivity.to_vec(),
        ..plates.grey()
    };
    let bands = [
        band([0.0, 4.0], [0.9, 0.2]),
        band([4.0, f64::INFINITY], [0.1, 0.8]),
    ];
    let problem = HeatProblem {
        bands: &bands,
        conditions: &[1500.0, 300.0].map(RowCondition::Temperature),
        surroundings: [0.0, 0.0],
        solar: &[],
    };
    heat_balance(&problem, &nodes(2), &Progress::new())
        .unwrap()
        .fluxes[0]
}

fn of_triangle(quantity: fn(&HeatBalance) -> f64) -> f64 {
    let given = [
        RowCondition::Temperature(1000.0),
        RowCondition::Temperature(500.0),
        RowCondition::Flux(0.0),
    ];
    quantity(&triangle().heat(&given))
}

fn of_heated_cube(row: usize) -> f64 {
    let given = [
        RowCondition::Flux(1000.0),
        RowCondition::Temperature(300.0),
        RowCondition::Flux(0.0),
    ];
    cube_of_three([0.9, 0.5, 0.1]).heat(&given).temperatures[row]
}

/// Conductance of black floor and ceiling with reradiating walls between them.
fn reradiating() -> f64 {
    let given = [
        RowCondition::Temperature(400.0),
        RowCondition::Temperature(300.0),
        RowCondition::Flux(0.0),
    ];
    let heat = cube_of_three([1.0, 1.0, 0.5]).heat(&given);
    heat.fluxes[0] / (STEFAN_BOLTZMANN * (400f64.powi(4) - 300f64.powi(4)))
}

/// Two plates with a shield: conductances in series.
fn shield() -> f64 {
    let one_side = plates([0.8, 0.05], [0.0; 2]).conductance(0, 1);
    STEFAN_BOLTZMANN * (500f64.powi(4) - 300f64.powi(4)) * one_side / 2.0
}

/// Black sky beyond the hole of a sphere of area 1.
fn hole() -> f64 {
    let sphere = surfaces(&[0.9], &[&[0.9]], &[0.5], &[0.0]);
    // The hole is as large as its flat disk.
    sphere.conductance(0, 1) / 0.09
}

fn value(id: &str) -> Option<f64> {
    let room_emissivity = [0.9, 0.8, 0.7, 0.6, 0.95, 0.5];
    let diffuse_cube = || mirrored_cube([0.6, 0.6, 0.6, 0.6, 0.6, 0.1], [0.0; 6]);
    Some(match id {
        "plates_dd_GR" => plates([0.8, 0.3], [0.0; 2]).conductance(0, 1),
        "plates_ss_GR" => plates([0.8, 0.3], [0.2, 0.7]).conductance(0, 1),
        "plates_mix_Fs11" => plates([0.3, 0.6], [0.2, 0.3]).factor(0, 0),
        "plates_mix_Fs12" => plates([0.3, 0.6], [0.2, 0.3]).factor(0, 1),
        "plates_mix_B11" => plates([0.3, 0.6], [0.2, 0.3]).gebhart(0, 0),
        "plates_mix_GR" => plates([0.3, 0.6], [0.2, 0.3]).conductance(0, 1),
        "plates_shield_q" => shield(),
        "sph_diff_GR" => spheres([0.7, 0.4], 0.0).conductance(0, 1),
        "sph_spec_GR" => spheres([0.7, 0.4], 0.6).conductance(0, 1),
        "sph_part_GR" => spheres([0.7, 0.4], 0.35).conductance(0, 1),
        "sph_part_Fs22" => spheres([0.7, 0.4], 0.35).factor(1, 1),
        "sph_part_B22" => spheres([0.7, 0.4], 0.35).gebhart(1, 1),
        "cyl_diff_GR" => cylinders([0.9, 0.2], 0.0).conductance(0, 1),
        "cyl_spec_GR" => cylinders([0.9, 0.2], 0.8).conductance(0, 1),
        "tri_B12" => triangle().gebhart(0, 1),
        "tri_B33" => triangle().gebhart(2, 2),
        "tri_mixed_q1" => of_triangle(|h| h.fluxes[0]),
        "tri_mixed_T3" => of_triangle(|h| h.temperatures[2]),
        "cube3_B12" => cube_of_three([0.9, 0.5, 0.1]).gebhart(0, 1),
        "cube3_B33" => cube_of_three([0.9, 0.5, 0.1]).gebhart(2, 2),
        "cube3_GR13" => cube_of_three([0.9, 0.5, 0.1]).conductance(0, 2),
        "cube3_mixed_T1" => of_heated_cube(0),
        "cube3_mixed_T3" => of_heated_cube(2),
        "cube3_rerad" => reradiating(),
        "room_F_z0_y0" => room(room_emissivity).factor(Z0, 2),
        "room_F_z0_x0" => room(room_emissivity).factor(Z0, 0),
        "room_B_z0_z1" => room(room_emissivity).gebhart(Z0, Z1),
        "room_scriptF_z0_y0" => room([0.8; 6]).exchange().script_f(Z0, 2).0,
        "cube_m1_Fs_z0z0" => one_mirror().factor(Z0, Z0 as u32),
        "cube_m1_Fs_z0x0" => one_mirror().factor(Z0, X0 as u32),
        "cube_m1_Fs_x0x1" => one_mirror().factor(X0, X1 as u32),
        "cube_m1_B_z0z1" => one_mirror().gebhart(Z0, Z1),
        "cube_m1_B_z0z0" => one_mirror().gebhart(Z0, Z0),
        "cube_d1_B_z0z0" => diffuse_cube().gebhart(Z0, Z0),
        "cube_m2_Fs_z0z1" => two_mirrors().factor(Z0, Z1 as u32),
        "cube_m2_Fs_z0x0" => two_mirrors().factor(Z0, X0 as u32),
        "cube_m2_B_z0z1" => two_mirrors().gebhart(Z0, Z1),
        "cube_m2_B_x0x0" => two_mirrors().gebhart(X0, X0),
        "cube_mc_Fs_z0z1" => mirrors_in_a_corner().factor(Z0, Z1 as u32),
        "cube_mc_B_z0x1" => mirrors_in_a_corner().gebhart(Z0, X1),
        "wedge_dd_Bspace" => strips([0.5; 2], 0.0).gebhart(0, 2),
        "wedge_ds_Fs11" => strips([0.5, 0.2], 0.8).factor(0, 0),
        "wedge_ds_Fspace" => strips([0.5, 0.2], 0.8).enclosure.factors.rest[0].sky,
        "wedge_ds_Bspace" => strips([0.5, 0.2], 0.8).gebhart(0, 2),
        "squares60_GR12" => squares_at_60_degrees().conductance(0, 1),
        "squares60_GR1s" => squares_at_60_degrees().conductance(0, 2),
        "sphere3_B12" => {
            let rows: [&[f64]; 3] = [&[0.1, 0.3, 0.6], &[0.3, 0.6], &[0.6]];
            surfaces(&[0.1, 0.3, 0.6], &rows, &[0.9, 0.5, 0.05], &[0.0; 3]).gebhart(0, 1)
        }
        "sphere_hole" => hole(),
        "cyl3_B12" => closed_cylinder().gebhart(0, 1),
        "cyl_mirror_Fs13" => {
            let disks = |h: f64| coaxial_disks(1.0, 1.0, h);
            (1.0 - disks(2.0)) + 0.8 * (disks(2.0) - disks(4.0))
        }
        "band_1000" => band_fraction(1000.0 / 300.0, 300.0),
        "band_2897" => band_fraction(2_897.771_955 / 300.0, 300.0),
        "band_5000" => band_fraction(5000.0 / 300.0, 300.0),
        "band_20000" => band_fraction(20_000.0 / 300.0, 300.0),
        "band2_plates_q" => banded_plates(),
        "solar_plate_T" => sunlit_plate(),
        "ingersoll_T" => crater(),
        name if name.starts_with("cube24_q_") => fluxes_of_24(name),
        _ => return None,
    })
}

/// Each row of the table, to ten digits.
#[test]
fn the_table_of_exchange_factors() {
    let Some(data) = azulejo_testing::data() else {
        return;
    };
    let table = std::fs::read_to_string(data.join("reference/exchange_factors.tsv")).unwrap();
    let mut off = HashMap::new();
    let mut rows = 0;
    for line in table.lines().skip(1) {
        let columns: Vec<&str> = line.split('\t').collect();
        let (id, expected): (_, f64) = (columns[0], columns[4].parse().unwrap());
        let found = value(id).unwrap_or_else(|| panic!("{id} is not computed"));
        rows += 1;
        let is_near = (found - expected).abs() <= 1e-10 * expected.abs();
        if !is_near {
            off.insert(id.to_owned(), (found, expected));
        }
    }
    assert!(rows >= 60, "{rows} rows");
    assert!(off.is_empty(), "{off:#?}");
}

/// The mirrored cubes close: what leaves a row arrives, counted once.
#[test]
fn images_fill_all_directions() {
    for cube in [one_mirror(), two_mirrors(), mirrors_in_a_corner()] {
        let factors = &cube.enclosure.factors;
        for (ended, rest) in factors.ended().iter().zip(&factors.rest) {
            assert!((ended - 1.0).abs() < 1e-9 && rest.sky == 0.0, "{ended}");
        }
    }
}
