//! Rows by rays.

use crate::scenes::*;
use azulejo_factors::rays::RayEstimator;
use azulejo_factors::row::{Columns, Row, side};
use azulejo_factors::{PatchSize, Patches};
use azulejo_scene::{Material, Object, Opacity, Primitive, Scene, Shape};
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
            let whole = (row.absorbed + row.all_escaped() + row.cut).mean() + sum * diffuse;
            assert!(
                (whole - 1.0).abs() < 1e-11,
                "ρ_d {diffuse}, ρ_s {mirror}: {whole} of 1"
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

/// Facing unit squares one apart, F = 0.19982, with gauze in between, and one of them gauze itself: the
/// factor counts what passes, and areas count by their opacity.
#[test]
fn rows_through_gauze() {
    let gauze = |opacity: f64| Material {
        opacity: Some(Opacity::constant(opacity)),
        ..surface(0.5, 0.0, 0.0)
    };
    let squares = |between: Option<f64>, upper: Material| {
        let mut scene = Scene::default();
        add_sheet(
            &mut scene,
            DVec3::ZERO,
            DVec3::X,
            DVec3::Y,
            surface(0.5, 0.0, 0.0),
        );
        add_sheet(&mut scene, DVec3::Z, DVec3::Y, DVec3::X, upper);
        if let Some(opacity) = between {
            let corner = DVec3::new(-5.0, -5.0, 0.5);
            add_sheet(
                &mut scene,
                corner,
                11.0 * DVec3::X,
                11.0 * DVec3::Y,
                gauze(opacity),
            );
        }
        let (patches, rows) = rows(&scene, PatchSize::Edge(0.0), 1 << 14);
        let to_upper = |row: &Row| {
            let entries = row.entries.iter().flatten();
            let own = entries.filter(|e| e.side / 2 == 1);
            own.map(|e| e.weight.r).sum::<f64>() / row.entries.len() as f64
        };
        (to_upper(&rows[0]), patches.area(1))
    };
    let check = |(estimate, area): (f64, f64), factor: f64, whole: f64| {
        let spread = (factor * (1.0 - factor) / f64::from(1 << 14)).sqrt();
        assert!(
            (estimate - factor).abs() < 4.0 * spread,
            "{estimate} of {factor}"
        );
        assert!((area - whole).abs() < 1e-12, "{area} of {whole}");
    };
    let plain = || surface(0.5, 0.0, 0.0);
    check(squares(None, plain()), 0.19982, 1.0);
    check(squares(Some(0.3), plain()), 0.7 * 0.19982, 1.0);
    check(squares(Some(0.5), gauze(0.5)), 0.25 * 0.19982, 0.5);
}
