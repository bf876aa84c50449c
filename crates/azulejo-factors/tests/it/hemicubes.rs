//! Rows by item buffers, with windows and with rays at mirrors, against closed forms, rays, and the
//! energy balance; and devices that fail.

use crate::scenes::*;
use azulejo_factors::estimator::Estimator;
use azulejo_factors::row::{Columns, Row, Side, side};
use azulejo_factors::{
    Engine, EngineUsed, FormFactorOptions, Hemicube, HemicubeBackend, PatchSize, Patches,
    form_factors,
};
use azulejo_scene::synthetic::cube_room;
use azulejo_scene::{Light, LightKind, Material, Mesh, Object, Primitive, Rgb, Scene, Shape};
use azulejo_trace::item_buffer::{
    Device, DrawError, ItemBuffers, Processor, Seen, Settings, View, World,
};
use azulejo_trace::{Gatherer, Progress, Surfaces, Tracer};
use glam::{DVec3, dvec3};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

const WHOLE: PatchSize = PatchSize::Edge(0.0);

fn options(resolution: u32, points: u32) -> Hemicube {
    Hemicube {
        resolution,
        points,
        device: HemicubeBackend::Processor,
    }
}

fn both(resolution: u32, points: u32) -> [Engine; 2] {
    let options = options(resolution, points);
    [Engine::Hemicube(options.clone()), Engine::Hybrid(options)]
}

/// Rows of some sides, and the engine used.
fn rows_of(
    scene: &Scene,
    size: PatchSize,
    engine: &Engine,
    sides: impl Fn(&Patches) -> Vec<Side>,
) -> (Patches, Vec<Row>, EngineUsed) {
    let tracer = Tracer::new(scene);
    let patches = Patches::new(scene, size);
    let gatherer = Gatherer::new(Surfaces::new(scene, &tracer));
    let estimator = Estimator::new(engine, &gatherer, &patches, 4096, 7, Columns::All);
    let rows = estimator.rows(&sides(&patches), &Progress::new());
    let ran = estimator.engine_used();
    let rows = rows.expect("nobody cancels");
    drop(estimator);
    (patches, rows, ran)
}

fn fronts(patches: &Patches) -> Vec<Side> {
    (0..patches.len() as u32).map(|p| side(p, true)).collect()
}

/// Form factor of a row to one side, all orders together, with its standard error.
fn factor(row: &Row, to: Side) -> (f64, f64) {
    let weight = |entries: &Vec<azulejo_factors::row::Entry>| {
        let to_side = entries.iter().filter(|e| e.side == to);
        to_side.map(|e| e.weight.r).sum::<f64>()
    };
    spread(&row.entries.iter().map(weight).collect::<Vec<f64>>())
}

/// One form factor between whole faces, by both engines.
#[track_caller]
fn check_factor(what: &str, scene: &Scene, from: u32, to: u32, truth: f64) {
    for engine in both(64, 256) {
        let (_, rows, ran) = rows_of(scene, WHOLE, &engine, |_| vec![side(from, true)]);
        let estimate = factor(&rows[0], side(to, true));
        let name = format!("{what} by {}", ran.name);
        check(&name, estimate, truth, 2e-3, 2e-4);
    }
}

const GREY: fn() -> Material = || surface(0.5, 0.0, 0.0);

/// The unit cube with mirrors of one reflectance in the place of some walls.
fn cube_with(mirrors: &[usize], reflectance: f64) -> Scene {
    cube(std::array::from_fn(|k| {
        if mirrors.contains(&k) {
            surface(0.0, reflectance, 0.0)
        } else {
            GREY()
        }
    }))
}

#[test]
fn faces_of_a_cube() {
    let scene = cube_with(&[], 0.0);
    check_factor(
        "opposite",
        &scene,
        cube_face(0),
        cube_face(1),
        0.19982489569839,
    );
    check_factor(
        "beside",
        &scene,
        cube_face(0),
        cube_face(2),
        0.20004377607540,
    );
}

#[test]
fn a_mirror_wall() {
    let (floor, ceiling) = (cube_face(0), cube_face(1));
    let perfect = cube_with(&[2], 1.0);
    check_factor("mir_cube", &perfect, floor, ceiling, 0.285875384851);
    let scene = cube_with(&[2], 0.9);
    let [other, beside] = [3, 4].map(cube_face);
    check_factor("mirror F", &scene, floor, ceiling, 0.27727033593548);
    check_factor("to x1", &scene, floor, other, 0.229571720123);
    check_factor("to y0", &scene, floor, beside, 0.236576783167);
    check_factor("x1 to itself", &scene, other, other, 0.061730629937);
}

#[test]
fn corridors() {
    let (floor, ceiling) = (cube_face(0), cube_face(1));
    for (reflectance, truth) in [
        (0.5, 0.294595182671),
        (0.9, 0.3873533),
        (1.0, 2f64.sqrt() - 1.0),
    ] {
        let scene = cube_with(&[2, 3], reflectance);
        let what = format!("corridor {reflectance}");
        check_factor(&what, &scene, floor, ceiling, truth);
    }
}

fn square(x: f64, z: f64, up: bool) -> (DVec3, DVec3, DVec3) {
    let edges = if up {
        (DVec3::X, DVec3::Y)
    } else {
        (DVec3::Y, DVec3::X)
    };
    (dvec3(x, 0.0, z), edges.0, edges.1)
}

fn sheets(sheets: &[((DVec3, DVec3, DVec3), Material)]) -> Scene {
    let mut scene = Scene::default();
    for ((corner, edge1, edge2), material) in sheets {
        add_sheet(&mut scene, *corner, *edge1, *edge2, material.clone());
    }
    scene
}

#[test]
fn windows_that_show_a_part() {
    let mirror = (dvec3(-0.2, 0.2, 0.3), 0.5 * DVec3::Y, 0.5 * DVec3::Z);
    let scene = sheets(&[
        (square(0.0, 0.0, true), GREY()),
        (square(0.0, 1.0, false), GREY()),
        (mirror, surface(0.0, 0.8, 0.0)),
    ]);
    check_factor("mir_window", &scene, 0, 1, 0.22076122);
    let ceiling = (dvec3(0.0, 0.0, 1.0), 3.0 * DVec3::X, DVec3::Y);
    let scene = sheets(&[
        (square(0.0, 0.0, true), GREY()),
        (square(1.5, 0.0, true), GREY()),
        (ceiling, surface(0.0, 0.9, 0.0)),
    ]);
    check_factor("mir_corner", &scene, 0, 1, 0.0293360871);
}

/// Σ_j X_ij (1 − ρ_s,j) + escaped + cut of each row, and the shares of surfaces, the outside and
/// the residue.
#[track_caller]
fn check_closure(what: &str, scene: &Scene, patches: &Patches, rows: &[Row], within: f64) {
    let material = |s: Side| &scene.materials[patches.material((s / 2) as usize) as usize];
    for (i, row) in rows.iter().enumerate() {
        let (mut kept, mut diffuse) = (0.0, 0.0);
        for e in row.entries.iter().flatten() {
            let m = material(e.side);
            let kept_share = if m.dielectric.is_some() {
                0.0
            } else {
                1.0 - m.mirror.r
            };
            kept += e.weight.r * kept_share / 4.0;
            diffuse += e.weight.r * m.diffuse.r / 4.0;
        }
        let lost = row.all_escaped().r + row.cut.r;
        let whole = diffuse + row.absorbed.r + lost;
        assert!(
            (whole - 1.0).abs() < within,
            "{what}, row {i}: fates {whole}"
        );
        let has_glass = scene.materials.iter().any(|m| m.dielectric.is_some());
        let sum = kept + lost;
        assert!(
            has_glass || (sum - 1.0).abs() < within,
            "{what}, row {i}: {sum}"
        );
    }
}

/// Scenes with light by every kind of path.
fn closed_scenes() -> Vec<(&'static str, Scene)> {
    let ball = |material: Material| {
        let mut scene = cube_with(&[3], 0.7);
        let number = scene.add_material(material);
        let ball = Primitive::sphere(dvec3(0.4, 0.5, 0.5), 0.2, number);
        scene
            .objects
            .push(Object::new("ball", Shape::Primitive(ball)));
        scene
    };
    vec![
        ("no mirrors", cube_with(&[], 0.0)),
        ("a mirror", cube_with(&[2], 0.9)),
        ("a corner of mirrors", cube_with(&[0, 2, 4], 0.6)),
        ("facing mirrors", cube_with(&[2, 3], 0.6)),
        ("only mirrors", cube_with(&[0, 1, 2, 3, 4, 5], 0.5)),
        ("shiny walls", cube([0; 6].map(|_| surface(0.5, 0.3, 0.0)))),
        ("a mirror ball", ball(surface(0.1, 0.8, 0.0))),
        ("a glass ball", ball(Material::dielectric("glass", 1.5))),
        ("a matt ball", ball(GREY())),
    ]
}

#[test]
fn every_share_is_accounted_for() {
    for (what, scene) in closed_scenes() {
        for engine in both(16, 4) {
            let (patches, rows, ran) = rows_of(&scene, PatchSize::Count(24), &engine, fronts);
            let name = format!("{what} by {}", ran.name);
            check_closure(&name, &scene, &patches, &rows, 1e-9);
            // What windows drawn by chance carry too much or too little: about a step of their comb.
            let cut = rows.iter().map(|r| r.cut.r.abs()).fold(0.0, f64::max);
            assert!(cut < 5e-4, "{name}: cut {cut}");
        }
    }
}

/// Entries of row sums by target agree with rays within their errors.
#[test]
fn rays_and_hemicubes_agree() {
    for (what, scene) in closed_scenes() {
        if what == "only mirrors" {
            continue; // every pixel goes through 23 of them
        }
        let reference = rows_of(&scene, PatchSize::Count(24), &Engine::Rays, fronts);
        for engine in both(24, 16) {
            let (patches, rows, ran) = rows_of(&scene, PatchSize::Count(24), &engine, fronts);
            let (mut squares, mut count, mut bias) = (0.0, 0.0, 0.0);
            for (row, truth) in rows.iter().zip(&reference.1) {
                for to in 0..2 * patches.len() as u32 {
                    let (a, b) = (factor(row, to), factor(truth, to));
                    // Errors of four replicates each: a floor keeps chance from making them 0.
                    let error = (a.1.powi(2) + b.1.powi(2) + 3e-4f64.powi(2)).sqrt();
                    squares += ((a.0 - b.0) / error).powi(2);
                    bias += a.0 - b.0;
                    count += f64::from(a.0 + b.0 > 0.0);
                }
            }
            let rms = (squares / f64::max(count, 1.0)).sqrt();
            let bias = bias / rows.len() as f64;
            eprintln!(
                "{what} by {}: rms {rms:.2} σ, bias of a row {bias:.1e}",
                ran.name
            );
            assert!(
                rms < 1.5 && bias.abs() < 5e-3,
                "{what} by {}: {rms} σ",
                ran.name
            );
        }
    }
}

/// Row error against the exact factors of a cube, for refinement in both parameters.
fn cube_error(resolution: u32, points: u32) -> f64 {
    let engine = Engine::Hemicube(options(resolution, points));
    let scene = cube_room();
    let (patches, rows, _) = rows_of(&scene, WHOLE, &engine, fronts);
    let mut sum = 0.0;
    for (i, row) in rows.iter().enumerate() {
        for j in 0..patches.len() {
            let cosine = patches.normal(i).dot(patches.normal(j));
            let truth = match (i == j, cosine < -0.5) {
                (true, _) => 0.0,
                (_, true) => 0.19982489569839,
                _ => 0.20004377607540,
            };
            sum += (factor(row, side(j as u32, true)).0 - truth).powi(2);
        }
    }
    (sum / rows.len() as f64).sqrt()
}

#[test]
fn error_falls_with_points_without_a_floor() {
    let errors = [4, 32, 256].map(|points| cube_error(32, points));
    eprintln!("points: {errors:?}");
    // Sobol points over the patch: at least their square root, a factor of 4 for 16 times.
    assert!(
        errors[1] < errors[0] / 4.0 && errors[2] < errors[1] / 4.0,
        "{errors:?}"
    );
}

#[test]
fn error_falls_with_resolution() {
    let errors = [4, 16, 64].map(|resolution| cube_error(resolution, 512));
    eprintln!("resolution: {errors:?}");
    assert!(
        errors[1] < errors[0] / 3.0 && errors[2] < errors[1],
        "{errors:?}"
    );
}

/// Concentric spheres: everything that leaves the inner one arrives at the outer one; a quarter of
/// what leaves the outer one arrives at the inner one.
#[test]
fn curved_patches_see_as_their_facets() {
    let mut scene = Scene::default();
    for radius in [1.0, 2.0] {
        let material = scene.add_material(GREY());
        let sphere = Primitive::sphere(DVec3::ZERO, radius, material);
        scene
            .objects
            .push(Object::new("sphere", Shape::Primitive(sphere)));
    }
    for engine in both(32, 8) {
        let (patches, rows, _) = rows_of(&scene, PatchSize::Count(90), &engine, |patches| {
            let inner = patches.patches_of(0).map(|p| side(p as u32, true));
            let outer = patches.patches_of(1).map(|p| side(p as u32, false));
            inner.chain(outer).collect()
        });
        let inner = patches.patches_of(0).len();
        let to_inner = |row: &Row| {
            let entries = row.entries.iter().flatten();
            let met = entries.filter(|e| (e.side as usize) < 2 * inner);
            met.map(|e| e.weight.r).sum::<f64>() / 4.0
        };
        assert!(rows[..inner].iter().all(|r| to_inner(r) < 1e-9));
        let outer = &rows[inner..];
        let mean = outer.iter().map(to_inner).sum::<f64>() / outer.len() as f64;
        assert!((mean - 0.25).abs() < 1e-3, "{mean}");
        check_closure("spheres", &scene, &patches, &rows, 1e-9);
    }
}

/// Light leaves an open scene upwards and downwards, and the surroundings count as stray.
#[test]
fn sky_and_ground() {
    let mut scene = sheets(&[((dvec3(0.0, 0.0, 0.0), DVec3::X, DVec3::Z), GREY())]);
    scene.units.up = azulejo_scene::Up::Z;
    let kind = LightKind::Ambient {
        radiance: Rgb::grey(2.0),
    };
    scene.lights.push(Light {
        name: "sky".into(),
        kind,
    });
    for engine in both(64, 16) {
        let (_, rows, _) = rows_of(&scene, WHOLE, &engine, fronts);
        for escaped in rows[0].escaped.as_flattened() {
            assert!((escaped.r - 0.5).abs() < 5e-3);
        }
        let truth = 2.0 * std::f64::consts::PI;
        assert!((rows[0].external.r - truth).abs() < 1e-9);
        assert!(rows[0].stray.iter().all(|s| (s.r - truth).abs() < 1e-9));
    }
}

#[test]
fn threads_change_no_bit() {
    let (_, scene) = closed_scenes().swap_remove(6);
    for engine in both(16, 8) {
        let rows = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let pool = pool.expect("threads start");
            pool.install(|| rows_of(&scene, PatchSize::Count(24), &engine, fronts).1)
        };
        let (one, three) = (rows(1), rows(3));
        for (a, b) in one.iter().zip(&three) {
            assert_eq!((&a.entries, a.stray, a.cut), (&b.entries, b.stray, b.cut));
            assert_eq!((a.absorbed, a.escaped), (b.absorbed, b.escaped));
        }
    }
}

/// Rows depend neither on the other rows requested nor on how many points fit in one call.
#[test]
fn rows_stand_alone() {
    let scene = cube_with(&[2], 0.5);
    for points in [4, 300] {
        let engine = Engine::Hemicube(options(16, points));
        let rows = rows_of(&scene, PatchSize::Count(24), &engine, fronts).1;
        let some = rows_of(&scene, PatchSize::Count(24), &engine, |_| vec![10, 6]).1;
        assert_eq!(some[0].entries, rows[5].entries);
        assert_eq!(some[1].entries, rows[3].entries);
    }
}

/// Difficult faces: coincident ones, crossing planes, slivers, crumbs below a pixel.
#[test]
fn degenerate_faces_keep_the_energy_balance() {
    let mut scene = cube_with(&[2], 0.5);
    let material = scene.add_material(GREY());
    let mut mesh = Mesh {
        positions: vec![
            dvec3(0.2, 0.2, 0.0),
            dvec3(0.8, 0.2, 0.0),
            dvec3(0.8, 0.8, 0.0),
            dvec3(0.2, 0.8, 0.0),
            dvec3(0.5, 0.1, -0.5),
            dvec3(0.5, 0.9, -0.4),
            dvec3(0.5, 0.5, 1.5),
            dvec3(0.1, 0.1, 0.3),
            dvec3(0.9, 0.9, 0.3),
            dvec3(0.5, 0.5 + 1e-9, 0.3),
            dvec3(0.3, 0.3, 0.6),
            dvec3(0.3 + 1e-5, 0.3, 0.6),
            dvec3(0.3, 0.3 + 1e-5, 0.6),
        ],
        ..Mesh::default()
    };
    // On the floor; its other side; across floor and ceiling; a sliver; a crumb.
    for face in [
        &[0, 1, 2, 3][..],
        &[3, 2, 1, 0],
        &[4, 5, 6],
        &[7, 8, 9],
        &[10, 11, 12],
    ] {
        mesh.push_face(face, material);
    }
    scene.objects.push(Object::new("bad", Shape::Mesh(mesh)));
    for engine in both(32, 4) {
        let both_sides = |patches: &Patches| (0..2 * patches.len() as u32).collect();
        let (patches, rows, _) = rows_of(&scene, PatchSize::Count(24), &engine, both_sides);
        check_closure("bad faces", &scene, &patches, &rows, 1e-9);
        let sums = |e: &azulejo_factors::row::Entry| e.weight.is_finite() && e.weight.r >= 0.0;
        assert!(
            rows.iter()
                .flat_map(|r| r.entries.iter().flatten())
                .all(sums)
        );
    }
}

/// A bowl of mirrors, each facing many others, and itself through them.
#[test]
fn a_mirror_that_faces_itself() {
    let mut scene = Scene::default();
    let mirror = scene.add_material(surface(0.0, 1.0, 0.0));
    let sphere = Primitive::sphere(DVec3::ZERO, 1.0, mirror);
    let mesh = sphere.tessellate(&sphere.grids(0.5, f64::INFINITY));
    scene.objects.push(Object::new("bowl", Shape::Mesh(mesh)));
    for engine in both(4, 4) {
        let (patches, rows, _) = rows_of(&scene, WHOLE, &engine, |_| vec![33]);
        check_closure("bowl", &scene, &patches, &rows, 1e-9);
        // Perfect mirrors absorb nothing; after a thousand of them single precision lets some light
        // out.
        assert!(rows.iter().all(|r| r.cut.r > 0.9), "{:?}", rows[0].cut);
    }
}

/// Ways in which a device may fail.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    None,
    Missing,
    TooSmall,
    /// Lost after this many draws.
    Lost(usize),
    /// Too few answers.
    Silent,
}

#[derive(Debug)]
struct Faulty(Fault);

struct FaultyBuffers {
    fault: Fault,
    real: Box<dyn ItemBuffers>,
    drawn: AtomicUsize,
}

impl Device for Faulty {
    fn name(&self) -> String {
        "test card".to_owned()
    }

    fn load(&self, world: &World, settings: &Settings) -> Result<Box<dyn ItemBuffers>, DrawError> {
        match self.0 {
            Fault::Missing => Err(DrawError::Missing("no adapter was found".to_owned())),
            Fault::TooSmall => Err(DrawError::TooLarge("a texture of 9 of 4 pixels".to_owned())),
            fault => Ok(Box::new(FaultyBuffers {
                fault,
                real: Processor.load(world, settings)?,
                drawn: AtomicUsize::new(0),
            })),
        }
    }
}

impl ItemBuffers for FaultyBuffers {
    fn batch(&self) -> usize {
        5
    }

    fn draw(&self, views: &[View]) -> Result<Vec<Seen>, DrawError> {
        let before = self.drawn.fetch_add(1, Ordering::Relaxed);
        match self.fault {
            Fault::Lost(after) if before >= after => Err(DrawError::Lost("reset".to_owned())),
            Fault::Silent => Ok(Vec::new()),
            _ => self.real.draw(views),
        }
    }
}

/// The rows are those of the processor, and the report mentions the failure.
#[track_caller]
fn check_fault(fault: Fault, device: &str, note: Option<&str>) {
    let scene = cube_with(&[2], 0.5);
    let engine = |device| {
        let options = options(16, 8);
        Engine::Hemicube(Hemicube { device, ..options })
    };
    let card = HemicubeBackend::Device(Arc::new(Faulty(fault)));
    let size = PatchSize::Count(24);
    let (_, drawn, ran) = rows_of(&scene, size, &engine(card), fronts);
    let (_, truth, _) = rows_of(&scene, size, &engine(HemicubeBackend::Processor), fronts);
    let entries = |rows: &[Row]| rows.iter().map(|r| r.entries.clone()).collect::<Vec<_>>();
    assert_eq!(entries(&drawn), entries(&truth));
    assert_eq!(
        (ran.name.as_str(), ran.device.as_str()),
        ("hemicube", device)
    );
    assert_eq!(
        ran.notes.len(),
        usize::from(note.is_some()),
        "{:?}",
        ran.notes
    );
    for (note, expected) in ran.notes.iter().zip(note) {
        assert!(note.contains(expected), "{note}");
    }
}

#[test]
fn the_processor_takes_over() {
    check_fault(Fault::None, "test card", None);
    check_fault(Fault::Missing, "processor", Some("no adapter was found"));
    check_fault(
        Fault::TooSmall,
        "processor",
        Some("a texture of 9 of 4 pixels"),
    );
    check_fault(
        Fault::Lost(0),
        "processor",
        Some("test card: the device was lost: reset"),
    );
    check_fault(
        Fault::Lost(3),
        "processor",
        Some("took over from test card"),
    );
    check_fault(Fault::Silent, "processor", Some("it drew 0 of"));
}

#[test]
fn the_report_names_the_backend() {
    let scene = {
        let (_, scene) = closed_scenes().swap_remove(6);
        let mut scene = scene;
        scene.materials[1] = surface(0.5, 0.0, 1.0);
        scene
    };
    let card = HemicubeBackend::Device(Arc::new(Faulty(Fault::Lost(2))));
    let engine = Engine::Hybrid(Hemicube {
        device: card,
        ..options(8, 4)
    });
    let tracer = Tracer::new(&scene);
    let factors = FormFactorOptions {
        engine,
        size: PatchSize::Count(24),
        ..FormFactorOptions::default()
    };
    let factors = form_factors(&scene, &tracer, &factors, &Progress::new()).expect("computed");
    let used = &factors.engine_used;
    assert_eq!(
        (used.name.as_str(), used.device.as_str()),
        ("hybrid", "processor")
    );
    assert!(used.notes[0].contains("test card") && used.notes[1].contains("specular"));
}

#[test]
fn cancelling_stops_between_draws() {
    let scene = cube_room();
    let tracer = Tracer::new(&scene);
    let patches = Patches::new(&scene, PatchSize::Count(24));
    let gatherer = Gatherer::new(Surfaces::new(&scene, &tracer));
    for engine in both(8, 4) {
        let estimator = Estimator::new(&engine, &gatherer, &patches, 64, 7, Columns::All);
        let progress = Progress::new();
        progress.cancel();
        assert!(estimator.rows(&fronts(&patches), &progress).is_err());
        let progress = Progress::new();
        let rows = estimator.rows(&fronts(&patches), &progress);
        assert_eq!((rows.map(|r| r.len()), progress.done()), (Ok(24), 24));
    }
}

/// A ball of many flat facets, each a mirror in a plane of its own, seen from inside.
fn mirrored_body(diffuse: f64, mirror: f64) -> Scene {
    let (around, along) = (12, 8);
    let point = |i: usize, j: usize| {
        let (t, p) = (
            std::f64::consts::PI * i as f64 / along as f64,
            std::f64::consts::TAU * (j % around) as f64 / around as f64,
        );
        dvec3(t.sin() * p.cos(), t.sin() * p.sin(), t.cos())
    };
    let mut scene = Scene::default();
    let wall = scene.add_material(surface(diffuse, mirror, 1.0));
    for i in 0..along {
        for j in 0..around {
            let corners = [
                point(i, j),
                point(i, j + 1),
                point(i + 1, j + 1),
                point(i + 1, j),
            ];
            let corners = match i {
                0 => vec![corners[0], corners[2], corners[3]],
                _ if i + 1 == along => vec![corners[0], corners[1], corners[2]],
                _ => corners.to_vec(),
            };
            let numbers: Vec<u32> = (0..corners.len() as u32).collect();
            let mut face = Mesh {
                positions: corners,
                ..Mesh::default()
            };
            face.push_face(&numbers, wall);
            scene.objects.push(Object::new("facet", Shape::Mesh(face)));
        }
    }
    scene
}

/// In a closed body every pixel of a hemicube is a window behind each level of mirrors. Their number
/// is bounded, and B = M / (1 − ρ_d − ρ_s) (1 − ρ_s) stays what it is in any closed scene: with
/// ρ_d = 0.5, ρ_s = 0.3 and M = 1, B = 3.5 and H = 5.
#[test]
fn windows_of_a_closed_body_of_mirrors_come_to_an_end() {
    let scene = mirrored_body(0.5, 0.3);
    let tracer = Tracer::new(&scene);
    let compute = |engine: Engine| {
        let options = FormFactorOptions {
            engine,
            size: WHOLE,
            rays: 4096,
            analytic: false,
            ..FormFactorOptions::default()
        };
        form_factors(&scene, &tracer, &options, &Progress::new()).expect("computed")
    };
    let (drawn, traced) = (
        compute(Engine::Hemicube(options(32, 4))),
        compute(Engine::Rays),
    );
    for factors in [&drawn, &traced] {
        let name = &factors.engine_used.name;
        // B = M + ρ_d X B, by iteration.
        let mut b = vec![1.0; factors.len()];
        let mut h = vec![0.0; factors.len()];
        for _ in 0..100 {
            for (i, h) in h.iter_mut().enumerate() {
                *h = factors.row(i).map(|(j, x, _)| x * b[j as usize]).sum();
            }
            b = h.iter().map(|h| 1.0 + 0.5 * h).collect();
        }
        let mean = |v: &[f64]| {
            let weighted = v.iter().zip(&factors.areas).map(|(x, a)| x * a);
            weighted.sum::<f64>() / factors.areas.iter().sum::<f64>()
        };
        let (b, h) = (mean(&b), mean(&h));
        eprintln!("{name}: B {b}, H {h}");
        assert!(
            (b / 3.5 - 1.0).abs() < 0.01 && (h / 5.0 - 1.0).abs() < 0.01,
            "{name}: {b} {h}"
        );
        let cut = mean(&factors.rest.iter().map(|r| r.cut).collect::<Vec<_>>());
        assert!(cut.abs() < 1e-3, "{name}: cut {cut}");
    }
}

/// A backend that counts the views it draws.
#[derive(Debug, Default)]
struct Counting(Arc<AtomicUsize>);

struct CountingBuffers(Arc<AtomicUsize>, Box<dyn ItemBuffers>);

impl Device for Counting {
    fn name(&self) -> String {
        "counter".to_owned()
    }

    fn load(&self, world: &World, settings: &Settings) -> Result<Box<dyn ItemBuffers>, DrawError> {
        let real = Processor.load(world, settings)?;
        Ok(Box::new(CountingBuffers(self.0.clone(), real)))
    }
}

impl ItemBuffers for CountingBuffers {
    fn batch(&self) -> usize {
        self.1.batch()
    }

    fn draw(&self, views: &[View]) -> Result<Vec<Seen>, DrawError> {
        self.0.fetch_add(views.len(), Ordering::Relaxed);
        self.1.draw(views)
    }
}

/// One point is one hemicube, at the barycentre, whose error nobody knows.
#[test]
fn a_single_eye_has_an_unknown_error() {
    let scene = cube_with(&[], 0.0);
    let tracer = Tracer::new(&scene);
    for (points, eyes) in [(1, 1), (2, 4), (5, 8)] {
        let counter = Counting::default();
        let drawn = counter.0.clone();
        let engine = Engine::Hemicube(Hemicube {
            device: HemicubeBackend::Device(Arc::new(counter)),
            ..options(128, points)
        });
        let factors = FormFactorOptions {
            engine,
            size: WHOLE,
            analytic: false,
            ..FormFactorOptions::default()
        };
        let factors = form_factors(&scene, &tracer, &factors, &Progress::new()).expect("computed");
        assert_eq!(drawn.load(Ordering::Relaxed), 6 * eyes, "{points} points");
        assert_eq!(factors.rays, 6 * eyes as u64 * 3 * 128 * 128);
        let (value, error) = factors.get(0, 1);
        let is_unknown = factors.row_errors.iter().all(|e| e.is_nan());
        assert_eq!((error.is_nan(), is_unknown), (eyes == 1, eyes == 1));
        let note = factors
            .engine_used
            .notes
            .iter()
            .any(|n| n.contains("unknown"));
        assert_eq!(note, eyes == 1, "{:?}", factors.engine_used.notes);
        if eyes == 1 {
            // The barycentre's own view of the opposite wall, closed: not that of the whole wall.
            assert!((value - 0.2395).abs() < 2e-3, "{value}");
            assert!(factors.closed.is_some_and(|c| c.deficit.abs() < 1e-9));
        }
    }
}
