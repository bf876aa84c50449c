//! Factors do not depend on how a model stands, and on the digits with which it is written.

use azulejo_factors::form_factors::Closure;
use azulejo_factors::{Engine, FormFactorOptions, FormFactors, PatchSize, form_factors};
use azulejo_scene::synthetic::room_with_table;
use azulejo_scene::{Material, Mesh, Object, Rgb, Scene, Shape};
use azulejo_trace::sampling::uniform;
use azulejo_trace::{Progress, Tracer};
use glam::{DAffine3, DQuat, DVec3, EulerRot, dvec3};

/// How coordinates are written.
#[derive(Clone, Copy, Debug)]
enum Digits {
    Decimals(i32),
    Single,
    Double,
}

impl Digits {
    fn write(self, p: DVec3) -> DVec3 {
        match self {
            Digits::Decimals(count) => p.map(|x| {
                let text = format!("{x:.*}", count as usize);
                text.parse().unwrap()
            }),
            Digits::Single => p.as_vec3().as_dvec3(),
            Digits::Double => p,
        }
    }
}

/// A turn and a shift by up to `reach`, different for each `k`.
fn pose(k: u32, reach: f64) -> DAffine3 {
    let random = |d: u32| 2.0 * f64::from(uniform(&[k, d])) - 1.0;
    let turn = DQuat::from_euler(
        EulerRot::XYZ,
        3.0 * random(0),
        3.0 * random(1),
        3.0 * random(2),
    );
    let shift = reach * dvec3(random(3), random(4), random(5));
    DAffine3::from_rotation_translation(turn, shift)
}

/// A scene in another pose, its meshes written with these digits and read again.
fn posed(scene: &Scene, map: &DAffine3, digits: Digits) -> Scene {
    let mut posed = scene.clone().transformed(map);
    for object in &mut posed.objects {
        if let Shape::Mesh(mesh) = &mut object.shape {
            mesh.positions
                .iter_mut()
                .for_each(|p| *p = digits.write(*p));
            mesh.history = Default::default();
        }
    }
    posed
}

/// A box seen from inside, each wall an object.
fn room(size: DVec3) -> Scene {
    let mut scene = Scene::default();
    let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
    let walls = [
        [0, 1, 3, 2],
        [4, 6, 7, 5],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 5, 7, 3],
    ];
    for (k, wall) in walls.iter().enumerate() {
        let corner =
            |&c: &i32| size * dvec3(f64::from(c & 1), f64::from(c >> 1 & 1), f64::from(c >> 2));
        let mut mesh = Mesh {
            positions: wall.iter().map(corner).collect(),
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, 2, 3], grey);
        scene
            .objects
            .push(Object::new(format!("wall {k}"), Shape::Mesh(mesh)));
    }
    scene
}

fn options(size: PatchSize) -> FormFactorOptions {
    FormFactorOptions {
        engine: Engine::Analytic,
        size,
        closure: Closure::Never,
        ..FormFactorOptions::default()
    }
}

fn compute(scene: &Scene, options: &FormFactorOptions) -> FormFactors {
    form_factors(scene, &Tracer::new(scene), options, &Progress::new()).unwrap()
}

fn sums(factors: &FormFactors) -> Vec<f64> {
    factors.row_sums()
}

/// Rooms turned and rounded had rows with sums from 0 to 0.77, or took minutes, because their walls hid
/// themselves.
#[test]
fn turned_and_rounded_rooms_are_closed() {
    let room = room(dvec3(4.0, 3.0, 2.5));
    let digits = [5, 6, 7]
        .map(Digits::Decimals)
        .into_iter()
        .chain([Digits::Single, Digits::Double]);
    for (k, digits) in digits.cycle().take(15).enumerate() {
        let reach = [0.0, 3.0, 100.0][k / 5];
        let scene = posed(&room, &pose(k as u32, reach), digits);
        let start = std::time::Instant::now();
        for size in [PatchSize::Edge(0.0), PatchSize::Count(600)] {
            let factors = compute(&scene, &options(size));
            let off = sums(&factors)
                .into_iter()
                .map(|s| (s - 1.0).abs())
                .fold(0.0, f64::max);
            eprintln!(
                "{k} {digits:?} {reach} {size:?}: {off:e} {:?} {:.2?}",
                factors.engine_used.notes,
                start.elapsed()
            );
            let error = match digits {
                Digits::Decimals(n) => 10f64.powi(-n),
                Digits::Single => 1e-7 * (8.0 + reach),
                Digits::Double => 1e-15 * reach,
            };
            assert!(off < 1e-4 + 3.0 * error, "{k} {digits:?} {size:?}: {off:e}");
        }
    }
}

/// Partially occluded pairs, too.
#[test]
fn turned_and_rounded_tables_hide_what_they_hid() {
    let room = room_with_table(200);
    let start = std::time::Instant::now();
    let straight = compute(&room, &options(PatchSize::Edge(0.0)));
    eprintln!("{:?} {:.2?}", straight.engine_used.notes, start.elapsed());
    for (k, digits) in [Digits::Decimals(6), Digits::Single, Digits::Double]
        .into_iter()
        .enumerate()
    {
        let start = std::time::Instant::now();
        let scene = posed(&room, &pose(k as u32, 10.0), digits);
        let turned = compute(&scene, &options(PatchSize::Edge(0.0)));
        let mut worst = (0.0, 0, 0, 0.0, 0.0);
        for i in 0..straight.areas.len() {
            for j in 0..straight.areas.len() as u32 {
                let ((a, e), (b, f)) = (straight.get(i, j), turned.get(i, j));
                let error = f64::from(e.hypot(f)) + 1e-5;
                let off = (a - b).abs() / error;
                if off > worst.0 {
                    worst = (off, i, j as usize, a, b);
                }
            }
        }
        let off = worst.0;
        eprintln!("{worst:?}");
        eprintln!(
            "{k} {digits:?}: {off:e} {:?} {:.2?}",
            turned.engine_used.notes,
            start.elapsed()
        );
        assert!(off < 5.0, "{digits:?}: {worst:?}");
    }
}

#[test]
fn zz_tables_debug() {
    let room = room_with_table(200);
    let scene = posed(&room, &pose(0, 10.0), Digits::Decimals(6));
    let turned = posed(&room, &pose(0, 10.0), Digits::Double);
    let mut shifted = room.clone();
    shifted = shifted.transformed(&DAffine3::from_translation(dvec3(1.0, 2.0, 3.0)));
    let d = scene.objects.len();
    eprintln!("{d}");
    for (n, s) in [
        ("straight", &room),
        ("turned", &turned),
        ("rounded", &scene),
        ("shifted", &shifted),
    ] {
        for acc in [5e-5, 5e-6, 1e-7] {
            let start = std::time::Instant::now();
            let f = compute(
                s,
                &FormFactorOptions {
                    accuracy: Some(acc),
                    ..options(PatchSize::Edge(0.0))
                },
            );
            eprintln!(
                "{n} {acc:e} {:?} sums {:e} {:.2?}",
                f.get(153, 64),
                f.row_sums()[153],
                start.elapsed()
            );
        }
        let f = compute(
            s,
            &FormFactorOptions {
                engine: Engine::Rays,
                analytic: false,
                rays: 1 << 18,
                ..options(PatchSize::Edge(0.0))
            },
        );
        eprintln!("{n} rays {:?}", f.get(153, 64));
    }
}
