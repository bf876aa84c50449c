//! Light by way of one glossy surface, against sums over the surface and the lamp.

use azulejo_scene::brdf::{Brdf, Description};
use azulejo_scene::{Light, LightKind, Material, Object, Primitive, Rgb, Scene, Shape};
use azulejo_trace::{
    DiffuseHit, DiffuseLight, GatherOptions, GatherPoint, Gatherer, OutgoingRadiosity, Surfaces,
    Termination, Tracer,
};
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::Arc;

/// The floor's corner and edges.
const FLOOR: [DVec3; 3] = [
    DVec3::new(-1.0, -1.0, 0.0),
    DVec3::new(2.0, 0.0, 0.0),
    DVec3::new(0.0, 2.0, 0.0),
];

/// The lamp's corner and edges; it shines down.
const LAMP: [DVec3; 3] = [
    DVec3::new(1.0, -0.4, 1.2),
    DVec3::new(0.0, 0.8, 0.0),
    DVec3::new(0.5, 0.0, 0.2),
];

const RADIANCE: f64 = 3.0;

/// A viewpoint above the floor that faces it, away from the lamp.
const EYE: DVec3 = DVec3::new(-0.6, 0.1, 0.7);

fn look() -> DVec3 {
    DVec3::new(-0.2, 0.1, -1.0).normalize()
}

fn brdf() -> Arc<Brdf> {
    let text: Description = "lewis n = 30 ks = 0.8".parse().unwrap();
    Arc::new(Brdf::new(text).unwrap())
}

fn sheet([corner, a, b]: [DVec3; 3], material: u32) -> Object {
    let sheet = Primitive::parallelogram(corner, a, b, material);
    Object::new("sheet", Shape::Primitive(sheet))
}

/// Nothing is diffuse here.
struct Dark;

impl DiffuseLight for Dark {
    fn outgoing(&self, _at: &DiffuseHit, _replicate: usize) -> OutgoingRadiosity {
        OutgoingRadiosity::default()
    }

    fn reflectance(&self, _at: &DiffuseHit) -> Rgb {
        Rgb::BLACK
    }
}

/// Gathered irradiance at the viewpoint and its standard error.
fn gathered(scene: &Scene) -> (f64, f64) {
    let tracer = Tracer::new(scene);
    let gatherer = Gatherer::new(Surfaces::new(scene, &tracer));
    let points: Vec<GatherPoint> = (0..64)
        .map(|key| GatherPoint {
            position: EYE,
            normal: look(),
            key,
        })
        .collect();
    let options = GatherOptions {
        rays: 1024,
        spent: 0,
        seed: 5,
        termination: Termination::default(),
    };
    let found = gatherer.gather(&points, &options, &Dark);
    let values: Vec<f64> = found.iter().map(|g| g.mean().g).collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let spread: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    (mean, (spread / (n * (n - 1.0))).sqrt())
}

/// Middles of the cells of a sheet, its normal, and the area of a cell.
fn cells([corner, a, b]: [DVec3; 3], n: u32) -> (Vec<DVec3>, DVec3, f64) {
    let at = |k: u32| (f64::from(k) + 0.5) / f64::from(n);
    let cells = (0..n * n).map(|k| corner + at(k % n) * a + at(k / n) * b);
    let across = a.cross(b);
    let area = across.length() / f64::from(n * n);
    (cells.collect(), across.normalize(), area)
}

/// Sum over the floor of what reaches the viewpoint, `shine` being the radiance that a point
/// reflects.
fn over_floor(n: u32, shine: impl Fn(DVec3, DVec3) -> f64) -> f64 {
    let (floor, normal, area) = cells(FLOOR, n);
    let term = |x: &DVec3| {
        let way = EYE - *x;
        let wo = way.normalize();
        let cos = (-wo.dot(look())).max(0.0) * wo.dot(normal);
        shine(*x, wo) * cos / way.length_squared()
    };
    floor.iter().map(term).sum::<f64>() * area
}

#[test]
fn a_lamp_in_a_glossy_floor() {
    let mut scene = Scene::default();
    let floor = scene.add_material(Material::with_brdf("floor", brdf()));
    let lamp = scene.add_material(Material::emitter("lamp", Rgb::grey(RADIANCE)));
    scene.objects = vec![sheet(FLOOR, floor), sheet(LAMP, lamp)];
    let (mean, error) = gathered(&scene);

    let model = brdf();
    let (lamp, normal, area) = cells(LAMP, 12);
    assert!(normal.z < 0.0);
    let expected = over_floor(120, |x, wo| {
        let term = |y: &DVec3| {
            let way = *y - x;
            let wi = way.normalize();
            let cos = wi.z.max(0.0) * (-wi.dot(normal)).max(0.0);
            model.eval(wo, wi).g * cos / way.length_squared()
        };
        RADIANCE * area * lamp.iter().map(term).sum::<f64>()
    });
    assert!(
        (mean - expected).abs() < 4.0 * error + 1e-3 * expected && error < 0.02 * expected,
        "{mean} ± {error}, expected {expected}"
    );
}

/// Light samples that contribute nothing are replaced by others: a second lamp whose dark side is
/// all that the floor sees takes as many samples, and changes nothing.
#[test]
fn a_lamp_that_looks_away_changes_nothing() {
    let mut scene = Scene::default();
    let floor = scene.add_material(Material::with_brdf("floor", brdf()));
    let lamp = scene.add_material(Material::emitter("lamp", Rgb::grey(RADIANCE)));
    scene.objects = vec![sheet(FLOOR, floor), sheet(LAMP, lamp)];
    let (alone, error) = gathered(&scene);
    let above = DVec3::new(0.0, 0.0, 3.0);
    let turned = [LAMP[0] + above, 4.0 * LAMP[2], 4.0 * LAMP[1]];
    scene.objects.push(sheet(turned, lamp));
    let (both, other) = gathered(&scene);
    assert!(
        (alone - both).abs() < 4.0 * error.hypot(other),
        "{alone} ± {error} alone, {both} ± {other} beside another"
    );
}

#[test]
fn a_point_light_in_a_glossy_floor() {
    let mut scene = Scene::default();
    let floor = scene.add_material(Material::with_brdf("floor", brdf()));
    scene.objects = vec![sheet(FLOOR, floor)];
    let position = DVec3::new(1.2, 0.2, 1.1);
    let intensity = Rgb::grey(PI);
    let kind = LightKind::Point {
        position,
        intensity,
    };
    scene.lights.push(Light {
        name: "lamp".into(),
        kind,
    });
    let (mean, error) = gathered(&scene);

    let model = brdf();
    let expected = over_floor(400, |x, wo| {
        let way = position - x;
        let wi = way.normalize();
        model.eval(wo, wi).g * wi.z * PI / way.length_squared()
    });
    // What the viewpoint sees of the light itself is above its horizon.
    assert!((position - EYE).dot(look()) < 0.0);
    assert!(
        (mean - expected).abs() < 4.0 * error + 1e-3 * expected && error < 0.02 * expected,
        "{mean} ± {error}, expected {expected}"
    );
}

/// What is lost, kept and sent on makes up all that a path set out with.
#[test]
fn shares_at_a_glossy_surface_add_up() {
    use azulejo_scene::math::Ray;
    use azulejo_trace::follow::{Event, Path, Scratch, follow};
    let mut scene = Scene::default();
    let floor = scene.add_material(Material::with_brdf("floor", brdf()));
    scene.objects = vec![sheet(FLOOR, floor)];
    let tracer = Tracer::new(&scene);
    let surfaces = Surfaces::new(&scene, &tracer);
    let ray = tracer.kernel_ray(&Ray::new(
        DVec3::new(0.1, 0.2, 1.0),
        DVec3::new(0.3, 0.1, -1.0),
    ));
    let path = |id| Path::new(ray, id, Rgb::WHITE);
    let count = 4096;
    let (mut escaped, mut absorbed) = (0.0, 0.0);
    let mut paths: Vec<Path> = (0..count).map(path).collect();
    follow(
        &surfaces,
        &mut paths,
        &mut Scratch::default(),
        3,
        |path, event| match event {
            Event::Escape => escaped += path.weight.g,
            Event::Absorbed | Event::Cut => absorbed += path.weight.g,
            Event::Surface { .. } => absorbed += path.weight.g,
        },
    );
    let all = f64::from(count);
    assert!((escaped + absorbed - all).abs() < 1e-9 * all);
    let wo = DVec3::new(-0.3, -0.1, 1.0).normalize();
    let albedo = brdf().albedo(wo).g;
    assert!((escaped / all - albedo).abs() < 0.01, "{escaped} {albedo}");
}
