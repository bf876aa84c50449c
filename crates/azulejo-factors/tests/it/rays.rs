//! Rows by rays.

use crate::scenes::*;
use azulejo_factors::rays::RayEstimator;
use azulejo_factors::row::{Columns, Row, side};
use azulejo_factors::{PatchSize, Patches};
use azulejo_scene::{Object, Primitive, Scene, Shape};
use azulejo_trace::{Gatherer, Surfaces, Tracer};
use glam::DVec3;
use std::f64::consts::PI;

fn rows(scene: &Scene, size: PatchSize, rays: u32) -> (Patches, Vec<Row>) {
    let tracer = Tracer::new(scene);
    let patches = Patches::new(scene, size);
    let gatherer = Gatherer::new(Surfaces::new(scene, &tracer));
    let estimator = RayEstimator::new(&gatherer, &patches, rays, 1, Columns::All);
    let rows = (0..patches.len() as u32)
        .map(|p| estimator.row(side(p, true)))
        .collect();
    (patches, rows)
}

/// Every ray's weight is accounted for: what surfaces keep, reflect diffusely, let out or cut.
#[test]
fn rows_telescope() {
    for (diffuse, mirror) in [(0.5, 0.0), (0.5, 0.3), (0.05, 0.95), (0.0, 1.0)] {
        let (_, rows) = rows(
            &cube([(); 6].map(|()| surface(diffuse, mirror, 1.0))),
            PatchSize::Count(54),
            64,
        );
        for row in &rows {
            let sum: f64 = row
                .entries
                .iter()
                .flatten()
                .map(|e| e.weight.r)
                .sum::<f64>()
                / row.entries.len() as f64;
            let all = (row.absorbed + row.all_escaped() + row.cut).mean() + sum * diffuse;
            assert!(
                (all - 1.0).abs() < 1e-11,
                "ρ_d {diffuse}, ρ_s {mirror}: {all} of 1"
            );
            let identity = sum * (1.0 - mirror) + row.cut.mean();
            assert!(
                (identity - 1.0).abs() < 1e-11,
                "ρ_s {mirror}: Σ X (1 − ρ_s) + cut = {identity}"
            );
        }
    }
}

/// On the inside of a sphere F_ij = A_j / A for every pair.
#[test]
fn inside_of_a_sphere_sees_by_area() {
    let mut scene = Scene::default();
    let grey = scene.add_material(surface(0.5, 0.0, 0.0));
    scene.objects.push(Object::new(
        "sphere",
        Shape::Primitive(Primitive::sphere(DVec3::ZERO, 1.0, grey)),
    ));
    let tracer = Tracer::new(&scene);
    let patches = Patches::new(&scene, PatchSize::Count(60));
    let gatherer = Gatherer::new(Surfaces::new(&scene, &tracer));
    let rays = 1 << 14;
    let estimator = RayEstimator::new(&gatherer, &patches, rays, 1, Columns::All);
    let mut worst = 0f64;
    for i in 0..patches.len() as u32 {
        let row = estimator.row(side(i, false));
        let mut factors = vec![0.0; 2 * patches.len()];
        row.entries
            .iter()
            .flatten()
            .for_each(|e| factors[e.side as usize] += e.weight.r / 4.0);
        assert!(
            (factors.iter().sum::<f64>() - 1.0).abs() < 1e-3,
            "row {i} sums to {}",
            factors.iter().sum::<f64>()
        );
        for j in 0..patches.len() {
            let f = patches.area(j) / (4.0 * PI);
            let sigma = (f * (1.0 - f) / f64::from(rays)).sqrt();
            worst = worst.max((factors[2 * j + 1] - f).abs() / sigma);
            assert_eq!(factors[2 * j], 0.0, "the inside sees no outside");
        }
    }
    eprintln!(
        "sphere of {} patches: worst entry {worst:.2} σ of random rays off",
        patches.len()
    );
    assert!(worst < 4.5, "{worst} σ");
}
