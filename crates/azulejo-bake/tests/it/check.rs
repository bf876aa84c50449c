//! The judge of atlases: what it finds, and that it finds nothing in ours.

use azulejo_bake::check::{AtlasCheck, CheckOptions, check};
use azulejo_bake::layout::NO_CHART;
use azulejo_bake::{Layout, Receiver, ReceiverLayout, UnwrapOptions, kept_layout, unwrap};
use azulejo_scene::Scene;
use azulejo_scene::synthetic::{
    CornellVariant, cornell_box, displaced_sphere, room_with_table, street,
};
use azulejo_trace::sampling::uniform;
use azulejo_trace::{Progress, Tracer};
use glam::DVec3;

const SIZE: u32 = 256;

type Uvs = [[f32; 2]; 3];

/// A triangle in space with its place on the page, both from the same numbers.
fn flat(receiver: &mut Receiver, layout: &mut ReceiverLayout, corners: Uvs) {
    let first = receiver.positions.len() as u32;
    for [u, v] in corners {
        receiver.positions.push(DVec3::new(u.into(), v.into(), 0.0));
    }
    receiver.triangles.push([first, first + 1, first + 2]);
    receiver.parts.push(0);
    layout.uvs.push(corners);
    layout.pages.push(0);
}

fn sheet(triangles: &[Uvs]) -> (Receiver, ReceiverLayout) {
    let mut receiver = Receiver {
        name: "sheet".into(),
        density: 1.0,
        ..Receiver::default()
    };
    let mut layout = ReceiverLayout::default();
    for &corners in triangles {
        flat(&mut receiver, &mut layout, corners);
    }
    (receiver, layout)
}

fn checked((receiver, layout): (Receiver, ReceiverLayout)) -> AtlasCheck {
    let layout = Layout {
        pages: vec![[SIZE; 2]],
        receivers: vec![layout],
        charts: 0,
    };
    check(&[receiver], &layout, &CheckOptions::default())
}

const LOWER: Uvs = [[0.25, 0.25], [0.5, 0.25], [0.5, 0.5]];
const UPPER: Uvs = [[0.25, 0.25], [0.5, 0.5], [0.25, 0.5]];

fn moved(uvs: Uvs, u: f32, v: f32) -> Uvs {
    uvs.map(|[a, b]| [a + u, b + v])
}

fn is_clean(found: &AtlasCheck) -> bool {
    found.is_complete
        && [
            found.outside,
            found.overlaps,
            found.near,
            found.mirrored,
            found.collapsed,
            found.creases,
        ]
        .iter()
        .all(|f| f.count == 0)
}

#[test]
fn a_good_atlas_is_clean() {
    let found = checked(sheet(&[LOWER, UPPER]));
    assert!(is_clean(&found), "{found:?}");
    assert_eq!((found.triangles, found.charts), (2, 1));
    assert!((found.covered - 1.0 / 16.0).abs() < 1e-9);
    assert!((found.stretch - 1.0).abs() < 1e-6 && found.most_stretch.count == 0);
    assert!((found.density_spread() - 1.0).abs() < 1e-6);
}

#[test]
fn each_defect_is_found_and_only_that() {
    let beyond = checked(sheet(&[LOWER, UPPER, moved(LOWER, 0.6, 0.0)]));
    assert_eq!(beyond.outside.count, 1);
    assert!((beyond.outside.amount - 0.1).abs() < 1e-6);
    assert_eq!(beyond.outside.worst.unwrap().triangle, 2);
    assert_eq!(beyond.overlaps.count, 0);

    // A hundredth of a triangle that lies on another.
    let on = checked(sheet(&[LOWER, moved(LOWER, 0.225, 0.0)]));
    assert_eq!(on.overlaps.count, 2);
    assert!((on.overlaps.amount - 0.01).abs() < 1e-4, "{on:?}");
    let twice = checked(sheet(&[LOWER, LOWER.map(|[u, v]| [u, v])]));
    assert_eq!((twice.overlaps.count, twice.overlaps.amount), (2, 1.0));

    let apart = |texels: f32| {
        let by = 0.25 + texels / SIZE as f32;
        checked(sheet(&[
            LOWER,
            UPPER,
            moved(LOWER, by, 0.0),
            moved(UPPER, by, 0.0),
        ]))
    };
    let (near, far) = (apart(1.5), apart(2.0));
    assert_eq!((near.near.count, near.charts), (2, 2));
    assert!((near.near.amount - 1.5).abs() < 1e-6, "{near:?}");
    assert!(is_clean(&near) || near.overlaps.count == 0);
    assert!(is_clean(&far), "{far:?}");
    let touching = apart(0.0);
    assert_eq!((touching.near.count, touching.overlaps.count), (0, 0));
    assert_eq!(touching.charts, 1, "equal corners in space are one chart");

    let mut folded = sheet(&[LOWER, UPPER]);
    // The corner of the upper one goes to the other side of the edge that both have.
    folded.1.uvs[1][2] = [0.5, 0.3];
    let folded = checked(folded);
    assert_eq!(
        (folded.mirrored.count, folded.overlaps.count),
        (1, 2),
        "{folded:?}"
    );
    let mut flat = sheet(&[LOWER, UPPER]);
    flat.1.uvs[1] = [[0.25, 0.25], [0.5, 0.5], [0.375, 0.375]];
    let flat = checked(flat);
    assert_eq!(flat.collapsed.count, 1);
    assert!((flat.collapsed_share - 0.5).abs() < 1e-6);

    let mut bent = sheet(&[LOWER, UPPER]);
    bent.0.positions[5].z = 1.0;
    let bent = checked(bent);
    assert_eq!(bent.creases.count, 1);
    assert!(bent.creases.amount > 60.0 && bent.creases.amount < 100.0);
    assert!(bent.stretch > 1.05);

    let dense = checked(sheet(&[LOWER, UPPER]));
    let mut sparse = sheet(&[LOWER, UPPER]);
    for corner in &mut sparse.0.positions[3..] {
        *corner *= 2.0;
    }
    let sparse = checked(sparse);
    assert!((sparse.density_spread() / dense.density_spread() - 2.0).abs() < 1e-3);
}

/// A chart that is mirrored as a whole, as in files whose v points up, is as good as another.
#[test]
fn mirrored_charts_are_not_mirrored_triangles() {
    let mut sheet = sheet(&[LOWER, UPPER]);
    for corner in sheet.1.uvs.iter_mut().flatten() {
        corner[1] = 1.0 - corner[1];
    }
    assert!(is_clean(&checked(sheet)));
}

#[test]
fn nothing_that_a_file_says_is_too_much() {
    let strange = [
        [[f32::NAN, 0.0], [0.5, f32::INFINITY], [0.1, 0.2]],
        [[1e30, 0.0], [-1e30, 0.5], [1e30, 1e30]],
        [[0.1, 0.1]; 3],
        [
            [0.3, 0.3],
            [0.3 + f32::EPSILON, 0.3],
            [0.3, 0.3 + f32::EPSILON],
        ],
        [[1e-40, 0.0], [0.0, 1e-40], [0.0, 0.0]],
    ];
    let mut mesh = sheet(&vec![LOWER; strange.len()]);
    mesh.1.uvs = strange.to_vec();
    let found = checked(mesh);
    assert_eq!(found.outside.count, 2);
    assert_eq!(found.outside.amount, f64::INFINITY);
    assert!(found.collapsed.count >= 3, "{found:?}");
    assert_eq!(checked(sheet(&[])).triangles, 0);
    // As the checker of a file sees it.
    let (receiver, layout) = {
        let mut mesh = sheet(&vec![LOWER; strange.len()]);
        mesh.1.uvs = strange.to_vec();
        mesh
    };
    let kept = kept_layout(
        std::slice::from_ref(&receiver),
        vec![layout],
        vec![[SIZE; 2]],
        30.0,
        None,
    );
    let again = check(&[receiver], &kept, &CheckOptions::default());
    assert_eq!(again.outside, found.outside);
    assert_eq!(again.collapsed, found.collapsed);
    let mut points = sheet(&[LOWER, UPPER]);
    points.0.positions.fill(DVec3::ONE);
    assert_eq!(checked(points).triangles, 0);
    let mut nowhere = sheet(&[LOWER, UPPER]);
    nowhere.0.positions.fill(DVec3::NAN);
    assert_eq!(checked(nowhere).triangles, 0);
    // Fewer coordinates than triangles.
    let mut short = sheet(&[LOWER, UPPER]);
    short.1.uvs.pop();
    assert_eq!(checked(short).triangles, 1);
}

/// Triangles that all lie on one another, and slivers whose boxes all do.
#[test]
fn crowds_are_compared_in_part() {
    let crowd = checked(sheet(&vec![LOWER; 30_000]));
    assert_eq!(crowd.overlaps.count, 30_000);
    let slivers: Vec<Uvs> = (0..30_000)
        .map(|k| {
            let x = k as f32 / 40_000.0;
            [[x, 0.0], [x + 0.2, 0.9], [x + 0.2 + 1e-5, 0.9]]
        })
        .collect();
    let slivers = checked(sheet(&slivers));
    assert_eq!(slivers.overlaps.count, 0);
    assert!(!slivers.is_complete);
}

fn receivers(scene: &Scene) -> Vec<Receiver> {
    scene
        .objects
        .iter()
        .filter_map(Receiver::of_object)
        .collect()
}

/// Checks what the unwrapper makes of receivers.
fn judged(
    name: &str,
    receivers: &[Receiver],
    tracer: &Tracer,
    options: &UnwrapOptions,
) -> AtlasCheck {
    let layout = unwrap(receivers, tracer, options, &Progress::new());
    let layout = layout.unwrap_or_else(|e| panic!("{name}: {e}"));
    let wanted = CheckOptions {
        gap: 2.0 * f64::from(options.padding),
        crease: options.crease,
    };
    let found = check(receivers, &layout, &wanted);
    assert!(found.is_complete, "{name}");
    assert_eq!(found.outside.count, 0, "{name}: {found:?}");
    assert_eq!(found.overlaps.count, 0, "{name}: {found:?}");
    assert_eq!(found.near.count, 0, "{name}: {found:?}");
    assert_eq!(found.creases.count, 0, "{name}: {found:?}");
    assert!(found.mirrored_share < 1e-6, "{name}: {found:?}");
    assert!(found.collapsed_share < 1e-6, "{name}: {found:?}");
    let charted: Vec<u32> = layout
        .receivers
        .iter()
        .flat_map(|r| r.charts.iter().copied())
        .filter(|c| *c != NO_CHART)
        .collect();
    assert_eq!(
        found.triangles - found.collapsed.count,
        charted.len(),
        "{name}"
    );
    found
}

#[test]
fn our_atlases_are_clean() {
    for (name, scene) in [
        ("Cornell box", cornell_box(CornellVariant::Diffuse)),
        ("ball", displaced_sphere(2000)),
        ("room", room_with_table(24)),
        ("street", street()),
    ] {
        let options = UnwrapOptions {
            size: 512,
            ..UnwrapOptions::default()
        };
        let found = judged(name, &receivers(&scene), &Tracer::new(&scene), &options);
        assert!(found.stretch <= 1.05, "{name}: {found:?}");
        assert!(found.most_stretch.amount <= 4.0, "{name}: {found:?}");
        let least = if found.charts < 100 { 0.5 } else { 0.3 };
        assert!(found.covered > least, "{name}: {found:?}");
    }
}

/// A made mesh: a field of heights, a crowd of triangles, or a bent strip, of some size.
fn random_mesh(number: u32) -> Receiver {
    let random = |k: u32| f64::from(uniform(&[number, k, 77]));
    let mut receiver = Receiver {
        name: format!("mesh {number}"),
        density: 1.0,
        ..Receiver::default()
    };
    let side = 2 + (random(0) * 8.0) as u32;
    let scale = 10f64.powf(4.0 * random(1) - 2.0);
    match number % 3 {
        0 | 1 => {
            let rough = random(2) * if number.is_multiple_of(3) { 0.3 } else { 2.0 };
            let long = if number.is_multiple_of(3) { 1.0 } else { 20.0 };
            for (y, x) in (0..=side).flat_map(|y| (0..=side).map(move |x| (y, x))) {
                let z = rough * random(10 + y * 32 + x);
                let p = DVec3::new(f64::from(x), long * f64::from(y), z);
                receiver.positions.push(scale * p);
            }
            for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
                let a = y * (side + 1) + x;
                let (b, c, d) = (a + 1, a + side + 2, a + side + 1);
                receiver.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        _ => {
            let count = side * side;
            for k in 0..3 * count {
                let p = DVec3::new(random(9 * k + 10), random(9 * k + 11), random(9 * k + 12));
                receiver.positions.push(scale * p);
            }
            receiver.triangles = (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        }
    }
    receiver.parts = vec![0; receiver.triangles.len()];
    receiver
}

#[test]
fn atlases_of_random_meshes_are_clean() {
    let tracer = Tracer::new(&Scene::default());
    for number in 0..200 {
        let receiver = random_mesh(number);
        let options = UnwrapOptions {
            size: 256,
            padding: 1 + number % 3,
            blocks: number.is_multiple_of(7),
            ..UnwrapOptions::default()
        };
        let name = receiver.name.clone();
        let found = judged(&name, &[receiver], &tracer, &options);
        assert!(found.stretch < 1.3, "{name}: {found:?}");
    }
}
