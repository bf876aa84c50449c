//! The matrix of form factors: cubes and rooms with known entries, its promises, its bad days.

use azulejo_radiosity::analytic::form_factor;
use azulejo_radiosity::{
    FormFactorOptions, FormFactors, PatchSize, Patches, SolveError, form_factors,
};
use azulejo_scene::synthetic::cube_room;
use azulejo_scene::{Material, Mesh, Object, Rgb, Scene, Shape};
use azulejo_trace::{Progress, Tracer};
use glam::{DVec3, dvec3};

fn factors(scene: &Scene, options: &FormFactorOptions) -> FormFactors {
    form_factors(scene, &Tracer::new(scene), options, &Progress::new())
        .expect("the scene has surfaces")
}

fn by_rays(size: PatchSize, rays: u32) -> FormFactorOptions {
    FormFactorOptions {
        size,
        rays,
        analytic: false,
        ..FormFactorOptions::default()
    }
}

/// Faces as they are.
const WHOLE: PatchSize = PatchSize::Edge(0.0);

/// Every entry of the divided cube, from the closed formula.
fn cube_truth(size: PatchSize) -> Vec<Vec<f64>> {
    let patches = Patches::new(&cube_room(), size);
    let polygon = |i| patches.polygon(i).expect("a cube is flat");
    let row = |i| {
        (0..patches.len())
            .map(|j| form_factor(&polygon(i), &polygon(j)))
            .collect()
    };
    (0..patches.len()).map(row).collect()
}

/// What the deviations from known entries look like.
#[derive(Debug, Default)]
struct Deviations {
    entries: usize,
    within_two: usize,
    within_four: usize,
    /// Mean over rows of Σ |error|, and of what the matrix says it is.
    row_error: f64,
    said: f64,
}

fn deviations(found: &FormFactors, truth: &[Vec<f64>]) -> Deviations {
    let mut d = Deviations::default();
    for (i, row) in truth.iter().enumerate() {
        for (j, &exact) in row.iter().enumerate() {
            let (value, error) = found.get(i, j as u32);
            d.row_error += (value - exact).abs() / truth.len() as f64;
            if value > 0.0 {
                let deviation = (value - exact).abs() / f64::from(error);
                d.entries += 1;
                d.within_two += usize::from(deviation <= 2.0);
                d.within_four += usize::from(deviation <= 4.0);
            }
        }
        d.said += found.row_errors[i] / truth.len() as f64;
    }
    d
}

#[test]
fn standard_errors_are_honest() {
    for (rays, size) in [
        (256, 0.25),
        (1 << 10, 0.2),
        (1 << 12, 0.2),
        (1 << 14, 0.25),
        (1 << 16, 0.5),
        (1 << 16, 0.25),
    ] {
        let size = PatchSize::Edge(size);
        let d = deviations(
            &factors(&cube_room(), &by_rays(size, rays)),
            &cube_truth(size),
        );
        let share = |n: usize| n as f64 / d.entries as f64;
        eprintln!(
            "{rays} rays: 2 SE {:.4}, 4 SE {:.4}, row {:.4} said {:.4}",
            share(d.within_two),
            share(d.within_four),
            d.row_error,
            d.said
        );
    }
}

#[test]
fn a_cube_of_six_faces() {
    for analytic in [false, true] {
        let f = factors(
            &cube_room(),
            &FormFactorOptions {
                size: WHOLE,
                rays: 1 << 12,
                analytic,
                ..FormFactorOptions::default()
            },
        );
        eprintln!(
            "{:?} {} {}",
            f.row(0).collect::<Vec<_>>(),
            f.correction,
            f.is_closed
        );
        for i in 0..6 {
            assert!((f.row_sum(i) - 1.0).abs() < 1e-6);
        }
    }
}
