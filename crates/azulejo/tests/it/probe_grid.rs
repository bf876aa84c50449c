//! Grids of probes beside irradiance that is gathered at their points.

use azulejo::factors::PointNormal;
use azulejo::probe_grid::{GridLight, ProbeGrid, grid_light};
use azulejo::radiosity::{FirstPass, probe};
use azulejo::scene::Scene;
use azulejo::scene::harmonics::harmonic_irradiance;
use azulejo::scene::math::Aabb;
use azulejo::scene::synthetic::{CornellVariant, cornell_box};
use azulejo::trace::{Progress, Run, Tracer};
use glam::DVec3;

/// A grid in the middle of the Cornell box.
fn light(scene: &Scene, pass: &FirstPass, progress: &Progress) -> GridLight {
    let bounds = scene.bounds();
    let inset = 0.2 * (bounds.max - bounds.min);
    let grid = ProbeGrid {
        bounds: Aabb {
            min: bounds.min + inset,
            max: bounds.max - inset,
        },
        resolution: [3, 3, 3],
    };
    grid_light(scene, &Tracer::new(scene), grid, pass, Run::from(progress)).unwrap()
}

/// Irradiance by harmonics is that of points, but for what their bands leave out, which is stated.
#[test]
fn harmonics_give_the_irradiance_of_points() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let pass = FirstPass {
        error: Some(0.01),
        ..FirstPass::default()
    };
    let light = light(&scene, &pass, &Progress::new());
    assert!(light.noise < 0.012, "{}", light.noise);
    let normals = [DVec3::X, DVec3::Y, DVec3::Z];
    let places: Vec<(usize, DVec3)> = (0..light.grid.len())
        .filter(|&probe| !light.is_inside[probe])
        .flat_map(|probe| normals.iter().flat_map(move |&n| [(probe, n), (probe, -n)]))
        .collect();
    let points: Vec<PointNormal> = places
        .iter()
        .map(|&(probe, normal)| PointNormal {
            position: light.grid.position(probe),
            normal,
        })
        .collect();
    let truth = probe(
        &scene,
        &Tracer::new(&scene),
        &points,
        &pass,
        &Progress::new(),
    )
    .unwrap();
    let (mut squares, mut bias, mut sum) = (0.0, 0.0, 0.0);
    for ((probe, normal), truth) in places.iter().zip(&truth.estimates) {
        let off = (harmonic_irradiance(&light.coefficients[*probe], *normal) - truth.value).mean();
        squares += off * off;
        bias += off;
        sum += truth.value.mean();
    }
    let count = places.len() as f64;
    let (rms, bias) = (f64::sqrt(squares / count) / (sum / count), bias / sum);
    let stated = light.systematic.unwrap().hypot(light.noise);
    assert!(
        rms < 2.0 * stated && rms > 0.3 * stated,
        "{rms}, stated {stated}"
    );
    assert!(bias.abs() < 0.02, "{bias}");
}

/// After the deadline there is light with its noise, and no time for the check.
#[test]
fn a_deadline_that_has_passed_leaves_light() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let progress = Progress::new();
    progress.set_deadline(std::time::Instant::now());
    let light = light(&scene, &FirstPass::default(), &progress);
    assert!(light.noise > 0.0 && light.noise < 1.0, "{}", light.noise);
    assert!(light.coefficients.iter().any(|c| c[0].mean() > 0.0));
}
