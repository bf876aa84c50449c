use crate::gpu::{self, Plan};
use bevy::asset::LoadState;
use bevy::light::{IrradianceVolume, LightProbe};
use bevy::prelude::*;
use serde::Deserialize;
use std::f32::consts::PI;

/// Light in the Cornell box, from `azulejo probe cornell.grf --grid 3,2,2 --grid-box 60,60,40,500,500,500 --error 1%`
/// with `-o cornell.ktx2`, and `-o cornell.json`.
const VOLUME: &[u8] = include_bytes!("../cornell.ktx2");
const NUMBERS: &[u8] = include_bytes!("../cornell.json");

/// Half of the sides of the cubes (m).
const HALF: f32 = 0.02;

/// From the middle to the eye: no cube hides another.
const DIRECTION: Vec3 = Vec3::new(0.403, 0.82, 0.406);

#[derive(Deserialize)]
struct Grid {
    resolution: [u32; 3],
    min: [f32; 3],
    max: [f32; 3],
    coefficients: Vec<f32>,
}

impl Grid {
    fn size(&self) -> Vec3 {
        Vec3::from(self.max) - Vec3::from(self.min)
    }

    /// Numbers of the cell of each probe.
    fn cells(&self) -> impl Iterator<Item = UVec3> {
        let [nx, ny, nz] = self.resolution;
        (0..nx * ny * nz)
            .map(move |probe| UVec3::new(probe % nx, probe / nx % ny, probe / (nx * ny)))
    }

    fn position(&self, cell: UVec3) -> Vec3 {
        let share = (cell.as_vec3() + 0.5) / UVec3::from(self.resolution).as_vec3();
        Vec3::from(self.min) + share * self.size()
    }

    /// E/π of the light of a probe on a surface that faces a side.
    fn light(&self, cell: UVec3, side: IVec3) -> Vec3 {
        let [nx, ny, _] = self.resolution;
        let probe = (cell.x + nx * (cell.y + ny * cell.z)) as usize;
        let [x, y, z] = side.as_vec3().to_array();
        let bands = [PI, 2.0 * PI / 3.0, PI / 4.0];
        // Those of products of two axes are 0.
        let harmonics = [
            (0, bands[0] * 0.282_095),
            (1, bands[1] * 0.488_603 * y),
            (2, bands[1] * 0.488_603 * z),
            (3, bands[1] * 0.488_603 * x),
            (6, bands[2] * 0.315_392 * (3.0 * z * z - 1.0)),
            (8, bands[2] * 0.546_274 * (x * x - y * y)),
        ];
        let terms = harmonics.map(|(k, factor)| {
            let at = 27 * probe + 3 * k;
            factor / PI * Vec3::from_slice(&self.coefficients[at..at + 3])
        });
        // Hard light has bands above, without which some sides are slightly negative.
        terms.into_iter().sum::<Vec3>().max(Vec3::ZERO)
    }
}

/// White cubes around the probes have on each side the light that the harmonics of the grid say, and no other cell's or
/// side's: all differ.
#[test]
fn cubes_in_a_volume_have_the_light_of_its_probes_on_each_side() {
    let grid: Grid = serde_json::from_slice(NUMBERS).unwrap();
    let middle = Vec3::from(grid.min) + grid.size() / 2.0;
    for toward in [DIRECTION, -DIRECTION] {
        let Some(mut app) = gpu::renderer("cornell.ktx2", VOLUME) else {
            return;
        };
        let plan = Plan {
            size: [1024, 1024],
            extent: [0.9, 0.9],
            transform: Transform::from_translation(middle + 2.0 * toward)
                .looking_at(middle, Vec3::Y),
            // An exposure of 1.
            ev100: -1.2_f32.log2(),
        };
        plan.spawn(&mut app);
        spawn(&mut app, &grid, middle);
        (0..20).for_each(|_| app.update());
        let mut compared = 0;
        for cell in grid.cells() {
            for axis in 0..3 {
                let mut side = IVec3::ZERO;
                side[axis] = toward[axis].signum() as i32;
                let place = grid.position(cell) + HALF * side.as_vec3();
                let shown = Vec3::from(plan.shown(&app, place));
                let expected = expected(&grid, cell, side);
                let error = (shown - expected).abs().max_element();
                assert!(
                    error < 0.01 * expected.max_element() + 1e-3,
                    "{cell} {side}: {shown}, expected {expected}"
                );
                compared += 1;
            }
        }
        assert_eq!(compared, 36);
    }
}

/// The light of a cube's side: interpolated, as the side is not at the probe itself but nearer to the next.
fn expected(grid: &Grid, cell: UVec3, side: IVec3) -> Vec3 {
    let next = cell.as_ivec3() + side;
    let resolution = UVec3::from(grid.resolution);
    let light = grid.light(cell, side);
    if next.min_element() < 0 || next.cmpge(resolution.as_ivec3()).any() {
        return light;
    }
    let apart = (grid.size() / resolution.as_vec3()).dot(side.as_vec3().abs());
    light.lerp(grid.light(next.as_uvec3(), side), HALF / apart)
}

/// Adds the volume, and cubes around its probes.
fn spawn(app: &mut App, grid: &Grid, middle: Vec3) {
    app.finish();
    app.cleanup();
    let world = app.world_mut();
    let cube = Cuboid::from_size(Vec3::splat(2.0 * HALF));
    let cube = world.resource_mut::<Assets<Mesh>>().add(cube);
    let white = StandardMaterial {
        base_color: Color::WHITE,
        perceptual_roughness: 1.0,
        reflectance: 0.0,
        ..default()
    };
    let white = world.resource_mut::<Assets<StandardMaterial>>().add(white);
    for cell in grid.cells() {
        world.spawn((
            Mesh3d(cube.clone()),
            MeshMaterial3d(white.clone()),
            Transform::from_translation(grid.position(cell)),
        ));
    }
    let voxels = world.resource::<AssetServer>().load("cornell.ktx2");
    world.spawn((
        LightProbe::default(),
        IrradianceVolume {
            voxels: voxels.clone(),
            intensity: 1.0,
            ..default()
        },
        Transform::from_translation(middle).with_scale(grid.size()),
    ));
    loop {
        app.update();
        match app.world().resource::<AssetServer>().load_state(&voxels) {
            LoadState::Loaded => break,
            LoadState::Failed(fault) => panic!("{fault}"),
            _ => {}
        }
    }
}
