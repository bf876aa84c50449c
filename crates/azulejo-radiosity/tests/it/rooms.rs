//! Scenes with known answers, and the first pass run on them in parts.

use azulejo_radiosity::engine::Estimator;
use azulejo_radiosity::light::reflectances;
use azulejo_radiosity::row::Columns;
use azulejo_radiosity::system::{Found, System};
use azulejo_radiosity::{Estimate, FirstPass, PatchSize, Patches, PointNormal, probe};
use azulejo_scene::synthetic::cube_room;
use azulejo_scene::{Material, Mesh, Object, Rgb, Scene, Shape};
use azulejo_trace::sampling::uniform;
use azulejo_trace::{Gatherer, Progress, Surfaces, Tracer};
use glam::{DVec3, dvec3};
use std::f64::consts::PI;

/// A grey surface that reflects, mirrors and emits, the last as exitance in W/m².
pub fn surface(diffuse: f64, mirror: f64, exitance: f64) -> Material {
    Material {
        diffuse: Rgb::grey(diffuse),
        mirror: Rgb::grey(mirror),
        emission: Rgb::grey(exitance / PI),
        ..Material::default()
    }
}

/// The unit cube seen from inside; materials of z = 0, z = 1, x = 0, x = 1, y = 0, y = 1.
pub fn cube(materials: [Material; 6]) -> Scene {
    let mut scene = cube_room();
    scene.materials = materials.to_vec();
    mesh_of(&mut scene, 0).face_materials = vec![2, 3, 4, 5, 0, 1];
    scene
}

/// Face of the cube's mesh with the material of this number: see [`cube`].
pub fn cube_face(material: usize) -> u32 {
    [4, 5, 0, 1, 2, 3][material]
}

/// Adds a parallelogram whose front looks toward `edge1 × edge2`.
pub fn add_sheet(scene: &mut Scene, corner: DVec3, edge1: DVec3, edge2: DVec3, material: Material) {
    let material = scene.add_material(material);
    let positions = vec![
        corner,
        corner + edge1,
        corner + edge1 + edge2,
        corner + edge2,
    ];
    let mut mesh = Mesh {
        positions,
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2, 3], material);
    scene.objects.push(Object::new("sheet", Shape::Mesh(mesh)));
}

/// Adds a parallelogram cut into `n × n` faces.
pub fn add_tiles(
    scene: &mut Scene,
    corner: DVec3,
    edge1: DVec3,
    edge2: DVec3,
    n: u32,
    material: Material,
) {
    let material = scene.add_material(material);
    let at = |i: u32, j: u32| {
        corner + edge1 * (f64::from(i) / f64::from(n)) + edge2 * (f64::from(j) / f64::from(n))
    };
    let mut mesh = Mesh::default();
    for j in 0..=n {
        mesh.positions.extend((0..=n).map(|i| at(i, j)));
    }
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            mesh.push_face(&[a, a + 1, a + n + 2, a + n + 1], material);
        }
    }
    scene.objects.push(Object::new("tiles", Shape::Mesh(mesh)));
}

/// The mesh of an object that is one.
pub fn mesh_of(scene: &mut Scene, object: usize) -> &mut Mesh {
    match &mut scene.objects[object].shape {
        Shape::Mesh(mesh) => mesh,
        _ => panic!("object {object} is no mesh"),
    }
}

/// `rays` a patch and a point, whole faces as patches.
pub fn rays(rays: u32) -> FirstPass {
    FirstPass {
        rays: Some(rays),
        size: PatchSize::Edge(0.0),
        ..FirstPass::default()
    }
}

/// The patches of a scene and the light on them, by the matrix.
pub struct Matrix {
    pub patches: Patches,
    pub found: Found,
    reflectance: Vec<Rgb>,
    exitance: Vec<f64>,
}

impl Matrix {
    pub fn solve(scene: &Scene, pass: &FirstPass) -> Matrix {
        let tracer = Tracer::new(scene);
        let patches = Patches::new(scene, pass.size);
        let gatherer = Gatherer::new(Surfaces::new(scene, &tracer));
        let reflectance = reflectances(scene, &patches);
        let (rays, seed) = (pass.rays.unwrap_or(256), pass.seed as u32);
        let progress = Progress::new();
        let engine = &pass.engine;
        let estimator = Estimator::new(engine, &gatherer, &patches, rays, seed, Columns::Diffuse);
        let system = System::trace(
            &gatherer,
            &patches,
            &reflectance,
            &estimator,
            seed,
            &progress,
        )
        .unwrap();
        let found = system.solve_all(pass.bounces, &progress).unwrap();
        let exitance = |p: usize| {
            scene.materials[patches.material(p) as usize]
                .exitance()
                .mean()
        };
        let exitance = (0..patches.len()).map(exitance).collect();
        Matrix {
            patches,
            found,
            reflectance,
            exitance,
        }
    }

    /// Radiosity of one side of a patch with its standard error.
    pub fn radiosity(&self, patch: usize, front: bool) -> (f64, f64) {
        let side = 2 * patch + usize::from(!front);
        let exitance = if front { self.exitance[patch] } else { 0.0 };
        let each: Vec<f64> = self
            .found
            .solutions
            .iter()
            .map(|x| exitance + x[side].mean())
            .collect();
        spread(&each)
    }

    /// Irradiance on one side of patches, averaged by area, with its standard error; the patches
    /// must reflect.
    pub fn irradiance(&self, patches: std::ops::Range<usize>, front: bool) -> (f64, f64) {
        let mean = |x: &Vec<Rgb>| {
            let of = |p: usize| {
                x[2 * p + usize::from(!front)].mean() / self.reflectance[p].mean()
                    * self.patches.area(p)
            };
            patches.clone().map(of).sum::<f64>()
                / patches.clone().map(|p| self.patches.area(p)).sum::<f64>()
        };
        spread(&self.found.solutions.iter().map(mean).collect::<Vec<f64>>())
    }
}

/// Radiosity of the fronts of `patches` over 256 seeds, each with its standard error: where whole
/// faces are patches, the few positions at which one seed finds direct light make most of the
/// noise.
pub fn radiosities(scene: &Scene, patches: &[usize], rays_per_patch: u32) -> Vec<(f64, f64)> {
    let solve = |seed| {
        Matrix::solve(
            scene,
            &FirstPass {
                seed,
                ..rays(rays_per_patch)
            },
        )
    };
    let solved: Vec<Matrix> = (0..256).map(solve).collect();
    let balance: Vec<f64> = solved.iter().map(|m| m.found.balance.error()).collect();
    assert!(balance.iter().all(|&e| e < 0.05), "balances: {balance:?}");
    let of = |&p: &usize| {
        spread(
            &solved
                .iter()
                .map(|m| m.radiosity(p, true).0)
                .collect::<Vec<f64>>(),
        )
    };
    patches.iter().map(of).collect()
}

/// Mean and standard error of independent estimates.
pub fn spread(each: &[f64]) -> (f64, f64) {
    let n = each.len() as f64;
    let mean = each.iter().sum::<f64>() / n;
    let square = each.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
    (mean, (square / (n * (n - 1.0))).sqrt())
}

/// Irradiance at points.
pub fn irradiance(scene: &Scene, points: &[PointNormal], pass: &FirstPass) -> Vec<Estimate> {
    probe(scene, &Tracer::new(scene), points, pass, &Progress::new())
        .unwrap()
        .estimates
}

/// Asserts that an estimate agrees with the truth within five standard errors of four
/// replicates, and `tolerance` besides; no error is smaller than `floor`, the rounding.
#[track_caller]
pub fn check(what: &str, (value, error): (f64, f64), truth: f64, tolerance: f64, floor: f64) {
    eprintln!("{what}: {value:.7} ± {error:.1e}, truth {truth:.7}");
    let off = (value - truth).abs();
    assert!(
        off <= tolerance,
        "{what}: {value} is {off:.2e} off {truth}, more than {tolerance:.1e}"
    );
    assert!(
        off <= 5.0 * error + floor,
        "{what}: {value} ± {error:.1e} claims too much: {truth}"
    );
}

/// The grey value of an estimate with its raw standard error.
pub fn grey(e: &Estimate) -> (f64, f64) {
    (e.value.mean(), e.error.mean())
}

/// A point with a normal.
pub fn at(x: f64, y: f64, z: f64, normal: DVec3) -> PointNormal {
    PointNormal {
        position: dvec3(x, y, z),
        normal,
    }
}

/// Points spread over the six sides of the unit cube, away from its edges.
pub fn points_on_cube(count: u32) -> Vec<PointNormal> {
    let point = |k: u32| {
        let [a, b] = [0, 1].map(|d| 0.01 + 0.98 * f64::from(uniform(&[k, d])));
        match k % 6 {
            0 => at(a, b, 0.0, DVec3::Z),
            1 => at(a, b, 1.0, -DVec3::Z),
            2 => at(0.0, a, b, DVec3::X),
            3 => at(1.0, a, b, -DVec3::X),
            4 => at(a, 0.0, b, DVec3::Y),
            _ => at(a, 1.0, b, -DVec3::Y),
        }
    };
    (0..count).map(point).collect()
}
