//! What holds for the factors of any scene, however wrong it is.

use azulejo_factors::{Closure, Engine, FormFactorOptions, Hemicube, PatchSize, form_factors};
use azulejo_scene::Scene;
use azulejo_scene::synthetic::cube_room;
use azulejo_trace::{Progress, Tracer};
use glam::{DAffine3, DQuat, DVec3};
use proptest::prelude::*;

/// A cube: place, size, turn, which of its faces are missing, and which of the others face outwards.
type Body = ([f64; 3], f64, f64, u8, u8);

fn scene(bodies: &[Body]) -> Scene {
    let mut scene = Scene::default();
    for &(place, size, turn, missing, outward) in bodies {
        let map = DAffine3::from_scale_rotation_translation(
            DVec3::splat(size),
            DQuat::from_rotation_z(turn) * DQuat::from_rotation_x(0.7 * turn),
            place.into(),
        );
        let whole = cube_room().transformed(&map);
        let azulejo_scene::Shape::Mesh(cube) = &whole.objects[0].shape else {
            continue;
        };
        let mut mesh = cube.clone();
        mesh.faces = azulejo_scene::Faces::default();
        mesh.face_materials.clear();
        for (face, corners) in cube.faces.iter().enumerate() {
            let mut corners = corners.to_vec();
            if outward >> face & 1 == 1 {
                corners.reverse();
            }
            if missing >> face & 1 == 0 {
                mesh.push_face(&corners, 0);
            }
        }
        let mut body = whole.clone();
        body.objects[0].shape = azulejo_scene::Shape::Mesh(mesh);
        scene.merge(body);
    }
    scene
}

fn check(scene: &Scene, engine: Engine, size: PatchSize, closure: Closure, two_sided: bool) {
    let options = FormFactorOptions {
        engine: engine.clone(),
        size,
        closure,
        two_sided,
        rays: 256,
        ..FormFactorOptions::default()
    };
    let tracer = Tracer::new(scene);
    let Ok(factors) = form_factors(scene, &tracer, &options, &Progress::new()) else {
        return;
    };
    assert_eq!(factors.impossible_row(), None, "{options:?}");
    let noise = factors.noise_of_sums();
    for (row, sum) in factors.row_sums().into_iter().enumerate() {
        let most = 1.0 + factors.row_errors[row] + 5.0 * noise[row];
        assert!(sum <= most + 1e-9, "{row}: {sum} {options:?}");
        for (_, f, error) in factors.row(row) {
            let most = 1.0 + 5.0 * f64::from(error) + factors.row_errors[row] + 1e-9;
            assert!((0.0..=most).contains(&f), "{row}: {f} {options:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    /// Bodies that are open, turned inside out and stand in each other.
    #[test]
    fn no_row_has_more_than_its_light(
        bodies in prop::collection::vec(
            (prop::array::uniform3(-1.0..1.0f64), 0.3..2.0f64, 0.1..1.4f64, 0u8..64, 0u8..64), 1..4),
        is_closed in any::<bool>(),
    ) {
        let mut bodies = bodies;
        if is_closed {
            bodies.iter_mut().for_each(|body| body.3 = 0);
        }
        let scene = scene(&bodies);
        let hemicube = Engine::Hemicube(Hemicube { resolution: 32, ..Hemicube::default() });
        for engine in [Engine::Auto, Engine::Rays, Engine::Analytic, hemicube] {
            // Formulas take seconds for each face that crosses others.
            if engine == Engine::Analytic && bodies.len() > 1 {
                continue;
            }
            for closure in [Closure::Closed, Closure::Always] {
                check(&scene, engine.clone(), PatchSize::Edge(0.0), closure, false);
            }
            check(&scene, engine, PatchSize::Count(24), Closure::Closed, true);
        }
    }
}

/// 16 viewpoints on faces that end inside of other bodies know little of what leaves, and two of them may agree by
/// chance.
#[test]
fn few_viewpoints_do_not_add_light() {
    let open = [
        ([-0.938, -0.0682, 0.2466], 0.7999, 0.6176, 35, 0),
        ([-0.684, 0.2102, -0.8259], 1.4181, 0.1338, 24, 40),
    ];
    let closed = [
        ([0.1321, -0.5833, 0.4481], 1.7993, 1.0542, 0, 4),
        ([-0.8954, 0.5854, -0.3498], 1.9762, 0.6051, 0, 32),
    ];
    let hemicube = Engine::Hemicube(Hemicube {
        resolution: 32,
        ..Hemicube::default()
    });
    check(
        &scene(&open),
        hemicube.clone(),
        PatchSize::Count(24),
        Closure::Closed,
        true,
    );
    check(
        &scene(&closed),
        hemicube,
        PatchSize::Edge(0.0),
        Closure::Closed,
        false,
    );
}

/// Of plates that see each other wholly, formulas know what is left for the sky and the ground.
#[test]
fn what_formulas_leave_goes_outside() {
    let bodies = [([0.0, 0.0, 0.0], 1.0, 0.0, 0b001111, 0)];
    let scene = scene(&bodies);
    let tracer = Tracer::new(&scene);
    for engine in [
        Engine::Rays,
        Engine::Hemicube(Hemicube {
            resolution: 32,
            ..Hemicube::default()
        }),
    ] {
        let options = FormFactorOptions {
            engine,
            size: PatchSize::Edge(0.0),
            rays: 64,
            ..FormFactorOptions::default()
        };
        let factors = form_factors(&scene, &tracer, &options, &Progress::new()).unwrap();
        assert_eq!(factors.len(), 2);
        for (sum, rest) in factors.row_sums().iter().zip(&factors.rest) {
            assert!(*sum > 0.1 && rest.escaped() > 0.1, "{sum} {rest:?}");
            assert!((sum + rest.escaped() - 1.0).abs() < 1e-6, "{sum} {rest:?}");
        }
    }
}
