//! Irradiance on the vertices of the meshes as given and as divided.

use crate::rooms::*;
use azulejo_radiosity::{FirstPass, PatchSize, solve};
use azulejo_scene::{
    Light, LightKind, Mesh, Object, ObjectIrradiance, Primitive, Rgb, Scene, Shape,
};
use azulejo_trace::{Progress, Tracer};
use glam::{DVec3, dvec3};

/// A bulb over a floor of 3 × 3 vertices: E = cos θ/r² at each.
fn bulb_over_floor() -> Scene {
    let mut scene = Scene::default();
    add_tiles(
        &mut scene,
        dvec3(-1.0, -1.0, 0.0),
        2.0 * DVec3::X,
        2.0 * DVec3::Y,
        2,
        surface(0.5, 0.0, 0.0),
    );
    let kind = LightKind::Point {
        position: BULB,
        intensity: Rgb::WHITE,
    };
    scene.lights.push(Light {
        name: "bulb".into(),
        kind,
    });
    scene
}

const BULB: DVec3 = DVec3::new(0.2, 0.1, 1.5);

fn from_bulb(p: DVec3) -> f64 {
    let d = BULB - p;
    d.z / d.length().powi(3)
}

#[track_caller]
fn check_vertices(what: &str, positions: &[DVec3], found: &[Rgb]) {
    assert_eq!(positions.len(), found.len());
    for (p, e) in positions.iter().zip(found) {
        let truth = from_bulb(*p);
        // Vertices are gathered a thousandth of a patch inside.
        assert!(
            (e.mean() / truth - 1.0).abs() < 3e-3,
            "{what} {p:?}: {} instead of {truth}",
            e.mean()
        );
    }
}

#[test]
fn a_kept_mesh_gets_values_on_its_own_vertices() {
    let mut scene = bulb_over_floor();
    let pass = FirstPass {
        keep_mesh: true,
        size: PatchSize::Count(100),
        ..rays(16)
    };
    let before = mesh_of(&mut scene, 0).clone();
    let light = solve(&scene, &Tracer::new(&scene), &pass, &Progress::new()).unwrap();
    let ObjectIrradiance::Vertices {
        irradiance, error, ..
    } = &light.irradiance.objects[0]
    else {
        panic!("values for the mesh as given")
    };
    check_vertices("given", &before.positions, irradiance);
    assert_eq!(error.len(), irradiance.len());
    scene.set_irradiance(light.irradiance);
    let after = mesh_of(&mut scene, 0);
    assert_eq!(
        (&after.positions, &after.faces),
        (&before.positions, &before.faces)
    );
    scene.validate().unwrap();
}

#[test]
fn a_divided_mesh_gets_values_on_all_vertices() {
    let mut scene = bulb_over_floor();
    let pass = FirstPass {
        size: PatchSize::Count(100),
        ..rays(16)
    };
    let light = solve(&scene, &Tracer::new(&scene), &pass, &Progress::new()).unwrap();
    scene.set_irradiance(light.irradiance);
    let mesh = mesh_of(&mut scene, 0);
    assert!(mesh.faces.len() >= 90, "{} faces", mesh.faces.len());
    check_vertices("divided", &mesh.positions, &mesh.irradiance);
    assert!(scene.is_solved());
    scene.validate().unwrap();
}

/// A floor that faces down is reversed towards the light, divided or kept.
#[test]
fn a_floor_upside_down() {
    let mut scene = bulb_over_floor();
    mesh_of(&mut scene, 0).faces.corners.reverse();
    let tracer = Tracer::new(&scene);
    let pass = FirstPass {
        size: PatchSize::Count(100),
        ..rays(16)
    };
    let kept = FirstPass {
        keep_mesh: true,
        ..pass.clone()
    };
    let light = solve(&scene, &tracer, &kept, &Progress::new()).unwrap();
    let positions = mesh_of(&mut scene, 0).positions.clone();
    let ObjectIrradiance::Vertices { irradiance, .. } = &light.irradiance.objects[0] else {
        panic!("kept")
    };
    check_vertices("kept", &positions, irradiance);
    let light = solve(&scene, &tracer, &pass, &Progress::new()).unwrap();
    scene.set_irradiance(light.irradiance);
    let mesh = mesh_of(&mut scene, 0);
    check_vertices("turned", &mesh.positions, &mesh.irradiance);
    assert!(
        (0..mesh.faces.len()).all(|f| mesh.face_area_vector(f).z > 0.0),
        "turned to the light"
    );
    scene.validate().unwrap();
}

/// Exact primitives carry irradiance on grids of their parts; a far bulb gives cos θ/r².
#[test]
fn primitives_carry_grids() {
    let mut scene = bulb_over_floor();
    scene.objects.clear();
    let ball = Primitive::sphere(DVec3::ZERO, 0.5, 0);
    scene
        .objects
        .push(Object::new("ball", Shape::Primitive(ball)));
    let pass = FirstPass {
        size: PatchSize::Count(200),
        ..rays(16)
    };
    let light = solve(&scene, &Tracer::new(&scene), &pass, &Progress::new()).unwrap();
    scene.set_irradiance(light.irradiance);
    let Shape::Primitive(p) = &scene.objects[0].shape else {
        panic!("still a primitive")
    };
    let light = p.light.as_ref().unwrap();
    let (nu, nv) = (light.grids[0].nu, light.grids[0].nv);
    // Not the poles, whose vertices are gathered inside their cells.
    for j in 1..nv {
        for i in 0..=nu {
            let at = p.point(
                0,
                f64::from(i) / f64::from(nu),
                f64::from(j) / f64::from(nv),
            );
            let d = BULB - at.position;
            let truth = (d.dot(at.normal) / d.length().powi(3)).max(0.0);
            let found = light.irradiance[(j * (nu + 1) + i) as usize].mean();
            assert!(
                (found - truth).abs() < 5e-3,
                "{:?}: {found} instead of {truth}",
                at.position
            );
        }
    }
    scene.validate().unwrap();
}

/// Vertex colours multiply the reflectance, also in the energy balance.
#[test]
fn painted_walls() {
    let mut scene = cube([0; 6].map(|_| surface(1.0, 0.0, 1.0)));
    let mesh: &mut Mesh = mesh_of(&mut scene, 0);
    mesh.colors = vec![Rgb::grey(0.5); mesh.positions.len()];
    let pass = FirstPass {
        size: PatchSize::Count(150),
        ..rays(64)
    };
    let shot = solve(
        &scene,
        &Tracer::new(&scene),
        &FirstPass {
            memory: 0,
            ..pass.clone()
        },
        &Progress::new(),
    )
    .unwrap();
    assert!(
        shot.report.balance.error() < 2e-2,
        "{:?}",
        shot.report.balance
    );
    let solved = Matrix::solve(&scene, &pass);
    for p in 0..solved.patches.len() {
        let (b, _) = solved.radiosity(p, true);
        assert!((b - 2.0).abs() < 1e-4, "B {b}");
    }
    let error = solved.found.balance.error();
    assert!(error < 1e-4, "balance {error}: {:?}", solved.found.balance);
}
