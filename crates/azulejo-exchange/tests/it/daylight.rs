//! Sensors in the open, whose light is known.

use azulejo_exchange::Enclosure;
use azulejo_exchange::daylight::{Daylight, YearAtPoints, year_at_points};
use azulejo_exchange::points::{SeenFromPoints, numbered};
use azulejo_factors::form_factors::{FactorPoint, Plan};
use azulejo_factors::{FormFactorOptions, PatchSize};
use azulejo_scene::sky::{Sky, SkyDivision, direction_from};
use azulejo_scene::{Material, Object, Primitive, Rgb, Scene, Shape, Up};
use azulejo_trace::{Progress, Tracer};
use glam::{DVec3, dvec3};
use std::f64::consts::PI;

/// North of the scene, clockwise.
const NORTH: f64 = 0.3;

/// A square of reflectance 0.5 on level ground, z up, and light that falls on sensors above it.
fn year(half: f64, records: &[Option<Daylight>], normals: &[DVec3]) -> YearAtPoints {
    let mut scene = Scene::default();
    scene.units.up = Up::Z;
    let grey = scene.add_material(Material::diffuse("grey", Rgb::new(0.4, 0.5, 0.6)));
    let corner = dvec3(-half, -half, 0.0);
    let square =
        Primitive::parallelogram(corner, 2.0 * half * DVec3::X, 2.0 * half * DVec3::Y, grey);
    scene
        .objects
        .push(Object::new("ground", Shape::Primitive(square)));
    let tracer = Tracer::new(&scene);
    let options = FormFactorOptions {
        size: PatchSize::Edge(half / 4.0),
        two_sided: true,
        ..FormFactorOptions::default()
    };
    let plan = Plan::new(&scene, &tracer, &options).unwrap();
    let (prepared, progress) = (plan.prepare(), Progress::new());
    let mut enclosure = Enclosure::new(&prepared, &scene, prepared.compute(&progress).unwrap());
    let sky = (SkyDivision::TREGENZA, NORTH);
    let of_rows = prepared.sky_factors(sky.0, sky.1, &enclosure.factors, &progress);
    enclosure.sky = Some(of_rows.unwrap());
    let point = |&normal: &DVec3| FactorPoint {
        position: DVec3::Z,
        normal: Some(normal),
    };
    let points = numbered(normals.iter().map(point).collect());
    let mut seen = SeenFromPoints::compute(&prepared, (&scene, None), points, &progress).unwrap();
    seen.add_sky(&prepared, sky, &progress).unwrap();
    year_at_points(
        (&prepared, &enclosure),
        seen,
        (records, 0.5),
        true,
        &progress,
    )
    .unwrap()
}

/// A uniform sky above ground of radiance 3, or the sun alone.
fn sky() -> Daylight {
    Daylight {
        sky: Sky {
            ground: 3.0,
            ..Sky::uniform(10.0)
        },
        diffuse_horizontal: 10.0 * PI,
        toward_sun: DVec3::NEG_Z,
        direct_normal: 0.0,
    }
}

fn sun(azimuth: f64) -> Daylight {
    Daylight {
        sky: Sky::uniform(0.0),
        diffuse_horizontal: 0.0,
        toward_sun: direction_from(azimuth, PI / 6.0),
        direct_normal: 100.0,
    }
}

#[track_caller]
fn check(found: f32, truth: f64) {
    assert!(
        (f64::from(found) - truth).abs() < 0.01 * truth + 1e-3,
        "{found}, expected {truth}"
    );
}

/// Uprights see half of the sky and half of the ground below the horizon, and the sun where it is north of them.
#[test]
fn uprights_in_the_open_see_half_of_the_sky() {
    let north = dvec3(NORTH.sin(), NORTH.cos(), 0.0);
    let records = [Some(sky()), None, Some(sun(0.0)), Some(sun(PI / 3.0))];
    let year = year(1e-3, &records, &[DVec3::Z, north, -north, DVec3::NEG_Z]);
    let table = year.irradiance.as_deref().unwrap();
    let expected = [
        [10.0 * PI, 6.5 * PI, 6.5 * PI, 3.0 * PI],
        [0.0; 4],
        [50.0, 100.0 * (PI / 6.0).cos(), 0.0, 0.0],
        [50.0, 50.0 * (PI / 6.0).cos(), 0.0, 0.0],
    ];
    for (found, truth) in table.iter().zip(expected.as_flattened()) {
        check(*found, *truth);
    }
    // Each record is half an hour, and parts of sums are sums, too.
    for k in 0..4 {
        let truth: f64 = expected.iter().map(|record| 0.5 * record[k]).sum();
        check(year.sum[k] as f32, truth);
        let parts = year.direct_sun[k] + year.sky[k] + year.reflected()[k];
        assert!((parts - year.sum[k]).abs() < 1e-4 * year.sum[k]);
        assert!(year.standard_error[k] < 0.01 * year.sum[k]);
    }
    check(year.reflected()[1] as f32, 0.5 * 1.5 * PI);
}

/// Ground gives back half of its light to what looks down, whatever the number of threads.
#[test]
fn ground_reflects_the_sky_and_the_sun() {
    let records = [Some(sky()), Some(sun(1.0))];
    let down = [DVec3::NEG_Z];
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| year(400.0, &records, &down))
    };
    let [one, three] = [1, 3].map(with);
    let table = one.irradiance.as_deref().unwrap();
    check(table[0], 0.5 * 10.0 * PI);
    check(table[1], 0.5 * 50.0);
    assert_eq!(one.irradiance, three.irradiance);
    assert_eq!(
        (one.sum, one.standard_error),
        (three.sum, three.standard_error)
    );
}
