//! Lightmaps beside light that is gathered at points, and light that is known.

use azulejo::bake::UnwrapOptions;
use azulejo::factors::{PatchSize, PointNormal};
use azulejo::lightmap::{
    BakeError, BakeOptions, BakeSource, Baked, BakedLight, BakedSides, BytePictures, Coordinates,
    bake, bake_occlusion, meshes_of,
};
use azulejo::radiosity::{FirstPass, SolveError, probe};
use azulejo::scene::synthetic::{CornellVariant, cornell_box};
use azulejo::scene::{Attribute, Light, LightKind, Material, Mesh, Object, Rgb, Scene, Shape};
use azulejo::trace::run::{CountedBlocks, together};
use azulejo::trace::sampling::uniform;
use azulejo::trace::{Blocks, Progress, Run, Tracer};
use glam::DVec3;
use std::f64::consts::PI;

pub fn options(size: u32, error: f64) -> BakeOptions {
    BakeOptions {
        charts: UnwrapOptions {
            size,
            ..UnwrapOptions::default()
        },
        pass: FirstPass {
            error: Some(error),
            ..FirstPass::default()
        },
        coordinates: Coordinates::New,
        is_directional: false,
        denoises: false,
        densities: Vec::new(),
        follows_light: false,
        light: BakedLight::Total,
        sides: BakedSides::Brighter,
    }
}

pub fn baked(scene: &Scene, options: &BakeOptions) -> Baked {
    let objects: Vec<u32> = (0..scene.objects.len() as u32).collect();
    bake(
        scene,
        &Tracer::new(scene),
        &objects,
        options,
        &Progress::new(),
    )
    .unwrap()
}

/// A point of the surface of an atlas, uniform by area: receiver, triangle and weights.
pub fn places(baked: &Baked, count: u32) -> Vec<(usize, usize, [f64; 3])> {
    let receivers = &baked.atlas.receivers;
    let mut triangles = Vec::new();
    let mut sum = 0.0;
    for (r, receiver) in receivers.iter().enumerate() {
        for t in 0..receiver.triangles.len() {
            sum += receiver.area_vector(t).length();
            triangles.push((sum, r, t));
        }
    }
    let place = |k: u32| {
        let [u, v, w] = [0, 1, 2].map(|d| f64::from(uniform(&[k, d, 77])));
        let at = triangles
            .partition_point(|t| t.0 < w * sum)
            .min(triangles.len() - 1);
        let root = u.sqrt();
        let weights = [1.0 - root, root * (1.0 - v), root * v];
        (triangles[at].1, triangles[at].2, weights)
    };
    (0..count).map(place).collect()
}

/// The point of a place, and the normal of the side that is baked.
pub fn on_surface(baked: &Baked, &(r, t, weights): &(usize, usize, [f64; 3])) -> PointNormal {
    let receiver = &baked.atlas.receivers[r];
    let corners = receiver.corners(t);
    let chart = baked.atlas.layout.receivers[r].charts[t];
    let side = if baked.atlas.is_turned(chart) {
        -1.0
    } else {
        1.0
    };
    PointNormal {
        position: (0..3).map(|k| weights[k] * corners[k]).sum(),
        normal: side * receiver.area_vector(t).normalize(),
    }
}

/// What viewers read at points beside what is there: root mean square and mean of the differences, relative to the
/// mean.
fn found_errors(scene: &Scene, baked: &Baked) -> [f64; 2] {
    let places = places(baked, 400);
    let points: Vec<PointNormal> = places
        .iter()
        .map(|place| on_surface(baked, place))
        .collect();
    let pass = FirstPass {
        error: Some(0.007),
        ..FirstPass::default()
    };
    let truth = probe(scene, &Tracer::new(scene), &points, &pass, &Progress::new()).unwrap();
    let (mut squares, mut bias, mut sum) = (0.0, 0.0, 0.0);
    for (&(r, t, weights), truth) in places.iter().zip(&truth.estimates) {
        let found = baked.irradiance(r, t, weights).unwrap();
        let difference = found - truth.value;
        squares += (difference * difference).mean();
        bias += difference.mean();
        sum += truth.value.mean();
    }
    let (count, mean) = (places.len() as f64, sum / places.len() as f64);
    [(squares / count).sqrt() / mean, bias / sum]
}

/// What viewers read at points is within one and a half times the requested error of what is there.
#[test]
fn texels_have_the_requested_error() {
    let scene = meshes_of(&cornell_box(CornellVariant::Diffuse), true);
    let error = 0.03;
    let baked = baked(&scene, &options(192, error));
    let stated = baked.lightmap.relative_error();
    assert!(stated < 1.2 * error, "stated {stated}");
    let [rms, bias] = found_errors(&scene, &baked);
    assert!(rms < 1.5 * error, "{rms}");
    assert!(bias.abs() < 0.01, "{bias}");
}

/// A lightmap of this many rays at every texel.
fn with_rays(size: u32, rays: u32) -> BakeOptions {
    let options = options(size, 0.0);
    BakeOptions {
        pass: FirstPass {
            error: None,
            rays: Some(rays),
            ..options.pass
        },
        ..options
    }
}

/// Light from a number of rays is about as far from what is there as its error says, and more rays make it less. With
/// few, the error of patches is known so badly that more of it is stated than there is.
#[test]
fn texels_of_a_number_of_rays_know_their_error() {
    let scene = meshes_of(&cornell_box(CornellVariant::Diffuse), true);
    let mut all = Vec::new();
    for (rays, most) in [(64, 4.0), (512, 2.5)] {
        let baked = baked(&scene, &with_rays(128, rays));
        assert_eq!(baked.texels.nodes, baked.texels.sites);
        let stated = baked.lightmap.relative_error();
        let [rms, bias] = found_errors(&scene, &baked);
        assert!(
            (0.7..most).contains(&(stated / rms)),
            "{rays} rays: {stated} for {rms}"
        );
        assert!(bias.abs() < 0.01, "{rays} rays: {bias}");
        all.push((stated, rms));
    }
    assert!(all[1].0 < all[0].0 && all[1].1 < all[0].1, "{all:?}");
}

/// It is the light of a lightmap to an error, texel by texel.
#[test]
fn rays_and_errors_agree() {
    let scene = meshes_of(&cornell_box(CornellVariant::Diffuse), true);
    let fixed = baked(&scene, &with_rays(64, 512)).lightmap;
    let other = baked(&scene, &options(64, 0.01)).lightmap;
    let ratio = fixed.mean().mean() / other.mean().mean();
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
    let (mut within, mut all) = (0, 0);
    let (a, b) = (&fixed.pages[0], &other.pages[0]);
    for texel in (0..a.areas.len()).filter(|&t| a.areas[t] > 0.0) {
        let difference = (a.irradiance[texel][1] - b.irradiance[texel][1]).abs();
        let error = a.standard_error[texel][1].hypot(b.standard_error[texel][1]);
        within += usize::from(difference <= 2.0 * error);
        all += 1;
    }
    let share = within as f64 / all as f64;
    assert!(share > 0.93, "{share}");
}

/// Where texels are far too coarse, the error says so, for indirect light, too.
#[test]
fn coarse_texels_say_what_they_miss() {
    let scene = meshes_of(&cornell_box(CornellVariant::Diffuse), true);
    let baked = baked(&scene, &options(40, 0.02));
    let stated = baked.lightmap.relative_error();
    let [rms, _] = found_errors(&scene, &baked);
    assert!(rms > 0.05, "{rms}: not coarse");
    assert!((0.6..1.7).contains(&(stated / rms)), "{stated} for {rms}");
}

/// Where there is no time at all, texels have light whose error is stated, and none of them is dark for want of time.
#[test]
fn a_deadline_that_has_passed_leaves_light_and_its_error() {
    let scene = meshes_of(&cornell_box(CornellVariant::Diffuse), true);
    let objects: Vec<u32> = (0..scene.objects.len() as u32).collect();
    let progress = Progress::new();
    progress.set_deadline(std::time::Instant::now());
    let options = options(128, 0.01);
    let baked = bake(&scene, &Tracer::new(&scene), &objects, &options, &progress).unwrap();
    let stated = baked.lightmap.relative_error();
    let [rms, bias] = found_errors(&scene, &baked);
    assert!(rms < 0.3 && bias.abs() < 0.05, "{rms}, {bias}");
    assert!((0.5..3.0).contains(&(stated / rms)), "{stated} for {rms}");
}

/// A plate just below a lamp would leave a room to the last steps of 8 bits: it has a picture of its own.
#[test]
fn bright_parts_have_pictures_of_their_own() {
    let mut scene = Scene::default();
    let [walls, plate] =
        ["walls", "plate"].map(|name| scene.add_material(Material::diffuse(name, Rgb::grey(0.5))));
    room(&mut scene, DVec3::ZERO, DVec3::splat(3.0), walls, true);
    let corners = [[1.4, 1.4], [1.6, 1.4], [1.6, 1.6], [1.4, 1.6]];
    let mut mesh = Mesh {
        positions: corners.map(|[x, y]| DVec3::new(x, y, 1.5)).to_vec(),
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2, 3], plate);
    scene.objects.push(Object::new("plate", Shape::Mesh(mesh)));
    scene.lights.push(Light {
        name: "lamp".into(),
        kind: LightKind::Point {
            position: DVec3::new(1.5, 1.5, 1.6),
            intensity: Rgb::grey(10.0),
        },
    });
    let baked = baked(&scene, &options(64, 0.1));
    let all = BytePictures::new(&baked, false);
    let apart = BytePictures::new(&baked, true);
    assert_eq!([all.pictures.len(), apart.pictures.len()], [1, 2]);
    let intensities = [0, 1].map(|k| apart.pictures[k].intensity);
    assert_eq!(intensities[1], all.pictures[0].intensity);
    assert!(intensities[0] < 0.1 * intensities[1], "{intensities:?}");
    let of = |receiver: usize| apart.of_triangles[receiver].iter().copied().max();
    assert_eq!([of(0), of(1)], [Some(0), Some(1)]);
    assert!(apart.share_below(&baked, 0.1) < 0.2);
    assert!(all.share_below(&baked, 0.1) > 0.9);
}

/// The free share over a floor beside a long wall of height h at the distance x is (1 + x / √(x² + h²)) / 2.
#[test]
fn occlusion_beside_a_wall_is_known() {
    let mut scene = Scene::default();
    let white = scene.add_material(Material::diffuse("white", Rgb::grey(0.5)));
    let quad = |corners: [[f64; 3]; 4]| {
        let mut mesh = Mesh {
            positions: corners.map(DVec3::from).to_vec(),
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, 2, 3], white);
        Shape::Mesh(mesh)
    };
    let floor = [
        [0.0, -2.0, 0.0],
        [4.0, -2.0, 0.0],
        [4.0, 2.0, 0.0],
        [0.0, 2.0, 0.0],
    ];
    let wall = [
        [0.0, -500.0, 0.0],
        [0.0, 500.0, 0.0],
        [0.0, 500.0, 1.0],
        [0.0, -500.0, 1.0],
    ];
    scene.objects = vec![
        Object::new("floor", quad(floor)),
        Object::new("wall", quad(wall)),
    ];
    check_occlusion_beside_a_wall(&scene, options(128, 0.01));
    check_occlusion_beside_a_wall(&scene, with_rays(128, 1024));
}

/// The floor is the first object of the scene, and the wall, of height 1, the other.
fn check_occlusion_beside_a_wall(scene: &Scene, options: BakeOptions) {
    let options = BakeOptions {
        sides: BakedSides::Front,
        ..options
    };
    let bake = |distance: f64| {
        let tracer = Tracer::new(scene);
        bake_occlusion(scene, &tracer, &[0], &options, distance, &Progress::new()).unwrap()
    };
    let baked = bake(1e4);
    assert!(baked.report.is_none());
    let (mut squares, mut count) = (0.0, 0.0);
    for (r, t, weights) in places(&baked, 300) {
        let corners = baked.atlas.receivers[r].corners(t);
        let x: f64 = (0..3).map(|k| weights[k] * corners[k].x).sum();
        let expected = 0.5 * (1.0 + x / x.hypot(1.0));
        let found = baked.irradiance(r, t, weights).unwrap().mean();
        squares += (found - expected).powi(2);
        count += 1.0;
        assert!(
            (found - expected).abs() < 0.04,
            "{found} for {expected} at {x}"
        );
    }
    let rms = f64::sqrt(squares / count);
    assert!(rms < 0.01, "{rms}");
    // What is farther than that does not count.
    let near = bake(0.5).lightmap.mean().mean();
    assert!(near > baked.lightmap.mean().mean() && near < 1.0, "{near}");
}

/// A box of six walls, its normals inside.
pub fn room(scene: &mut Scene, low: DVec3, high: DVec3, material: u32, floor: bool) {
    let corner = |k: u32| {
        let pick = |axis: usize| {
            if k >> axis & 1 == 1 {
                high[axis]
            } else {
                low[axis]
            }
        };
        DVec3::new(pick(0), pick(1), pick(2))
    };
    let mut mesh = Mesh {
        positions: (0..8).map(corner).collect(),
        ..Mesh::default()
    };
    let walls = [
        [0, 1, 3, 2],
        [4, 6, 7, 5],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 5, 7, 3],
    ];
    for wall in walls.iter().skip(usize::from(!floor)) {
        mesh.push_face(wall, material);
    }
    scene.objects.push(Object::new("room", Shape::Mesh(mesh)));
}

/// In a closed room of one reflectance ρ that emits L everywhere, irradiance is πL/(1 − ρ).
#[test]
fn a_white_furnace_is_even() {
    let mut scene = Scene::default();
    let glowing = scene.add_material(Material {
        emission: Rgb::grey(1.0),
        ..Material::diffuse("glowing", Rgb::grey(0.6))
    });
    room(
        &mut scene,
        DVec3::ZERO,
        DVec3::new(2.0, 3.0, 2.5),
        glowing,
        true,
    );
    for options in [options(96, 0.02), with_rays(96, 256)] {
        let options = BakeOptions {
            sides: BakedSides::Front,
            ..options
        };
        let baked = baked(&scene, &options);
        let expected = PI / (1.0 - 0.6);
        let mean = baked.lightmap.mean().mean();
        assert!(
            (mean / expected - 1.0).abs() < 0.01,
            "{mean} for {expected}"
        );
        let page = &baked.lightmap.pages[0];
        for (t, e) in page
            .irradiance
            .iter()
            .enumerate()
            .filter(|(t, _)| page.areas[*t] > 0.0)
        {
            let off = (f64::from(e[1]) / expected - 1.0).abs();
            assert!(off < 0.15, "texel {t}: {e:?}");
        }
    }
}

#[test]
fn parts_of_the_light_add_up() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let part = |light: BakedLight| {
        let options = BakeOptions {
            light,
            ..options(96, 0.05)
        };
        baked(&scene, &options).lightmap.mean().mean()
    };
    let [total, indirect, direct] =
        [BakedLight::Total, BakedLight::Indirect, BakedLight::Direct].map(part);
    assert!(indirect > 0.1 * total && direct > 0.1 * total);
    assert!(
        ((indirect + direct) / total - 1.0).abs() < 0.01,
        "{indirect} + {direct} of {total}"
    );
}

#[test]
fn threads_make_no_difference_and_cancelling_stops() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
            .install(|| baked(&scene, &options(64, 0.1)).lightmap)
    };
    let one = with(1);
    assert!(one == with(2) && one == with(7));
    let progress = Progress::new();
    progress.cancel();
    let objects = [0, 1, 2];
    let stopped = bake(
        &scene,
        &Tracer::new(&scene),
        &objects,
        &options(64, 0.1),
        &progress,
    );
    assert_eq!(
        stopped.unwrap_err(),
        BakeError::Solve(SolveError::Cancelled)
    );
}

/// A sheet of 2 m with little light above and much below, and a box far away. A second sheet is
/// curved: its shading normals differ from those of its faces.
fn sheets() -> Scene {
    let mut scene = Scene::default();
    let white = scene.add_material(Material::diffuse("white", Rgb::grey(0.5)));
    let square = |low: f64| {
        let mut mesh = Mesh {
            positions: [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]
                .map(|[x, y]| DVec3::new(x + low, y, 0.0))
                .to_vec(),
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, 2, 3], white);
        mesh
    };
    let mut curved = square(3.0);
    let tilted = [-1.0, 1.0, 1.0, -1.0].map(|x| DVec3::new(0.2 * x, 0.0, 1.0).normalize());
    curved.normals = Some(Attribute::per_vertex(tilted.to_vec()));
    scene
        .objects
        .push(Object::new("sheet", Shape::Mesh(square(0.0))));
    scene
        .objects
        .push(Object::new("curved", Shape::Mesh(curved)));
    let (low, high) = (DVec3::new(60.0, 0.0, 0.0), DVec3::new(61.0, 1.0, 1.0));
    room(&mut scene, low, high, white, true);
    let Shape::Mesh(solid) = &mut scene.objects[2].shape else {
        unreachable!("a room is a mesh")
    };
    (0..solid.faces.len()).for_each(|face| solid.reverse_face(face));
    let sun = |down: f64, irradiance: f64| Light {
        name: "sun".into(),
        kind: LightKind::Directional {
            direction: DVec3::new(0.0, 0.0, down),
            irradiance: Rgb::grey(irradiance),
            half_angle: 0.0,
        },
    };
    scene.lights = vec![sun(-1.0, 1.0), sun(1.0, 10.0)];
    scene
}

/// What a written file says of sheets: for each triangle of its objects, up or down, and its irradiance.
fn written_sheets(sheets: &Scene, sides: BakedSides) -> Vec<(String, f64, f64)> {
    let mut source = BakeSource::written(sheets, true).unwrap();
    let options = BakeOptions {
        sides,
        ..options(64, 0.05)
    };
    let mut baked = baked(&source.scene, &options);
    source.turn_to_light(&mut baked).unwrap();
    assert_eq!(source.scene.objects.len(), source.origins.len());
    let layouts = source.layouts(&baked);
    let mut found = Vec::new();
    for (receiver, surface) in baked.atlas.receivers.iter().enumerate() {
        let object = &source.scene.objects[baked.objects[receiver] as usize];
        let mesh = object.shape.mesh().unwrap().in_triangles(|_| true);
        assert_eq!(mesh.faces.len(), surface.triangles.len());
        // The file has the same triangles in the same order.
        let layout = layouts[baked.objects[receiver] as usize].as_ref().unwrap();
        assert_eq!(layout.uvs, baked.atlas.layout.receivers[receiver].uvs);
        for t in 0..surface.triangles.len() {
            let up = surface.area_vector(t).normalize().z;
            assert!(
                (mesh
                    .face_area_vector(t.min(mesh.faces.len() - 1))
                    .normalize()
                    .z
                    - up)
                    .abs()
                    < 1e-9
            );
            let light = baked.irradiance(receiver, t, [1.0 / 3.0; 3]).unwrap();
            found.push((object.name.clone(), up, light.mean()));
        }
    }
    found
}

/// Fronts have the light in files that are written, whichever side of a face it came from.
#[test]
fn faces_are_turned_to_their_light() {
    let found = written_sheets(&sheets(), BakedSides::Brighter);
    let sheets = found.iter().filter(|(name, ..)| name != "room");
    for (name, up, light) in sheets {
        assert!(
            *up < -0.9 && (light / 10.0 - 1.0).abs() < 0.05,
            "{name} {up}: {light}"
        );
    }
    // A solid keeps its fronts.
    let lid = |(name, up, _): &&(String, f64, f64)| name == "room" && *up > 0.9;
    assert!(
        found
            .iter()
            .filter(lid)
            .all(|(_, _, light)| (light - 1.0).abs() < 0.05)
    );
}

/// A lamp sends its light from its front, and would be dark if it were turned.
#[test]
fn lamps_keep_their_fronts() {
    let mut scene = sheets();
    scene.materials[0].emission = Rgb::grey(0.01);
    let found = written_sheets(&scene, BakedSides::Brighter);
    let sheets = || found.iter().filter(|(name, ..)| name != "room");
    assert_eq!(sheets().count(), 4);
    assert!(
        sheets().all(|(_, up, light)| *up > 0.9 && (light - 1.0).abs() < 0.1),
        "{found:?}"
    );
}

/// Each side of a sheet has its own light, and a solid has no inner side.
#[test]
fn both_sides_are_baked() {
    let found = written_sheets(&sheets(), BakedSides::Both);
    for (name, up, light) in &found {
        let expected = match *up {
            up if up > 0.9 => 1.0,
            up if up < -0.9 => 10.0,
            _ => 0.0,
        };
        assert!(
            (light - expected).abs() < 0.05 * expected + 0.01,
            "{name} {up}: {light}"
        );
    }
    let of = |name: &str| found.iter().filter(|f| f.0 == name).count();
    assert_eq!([of("sheet"), of("sheet (back)")], [2, 2]);
    assert_eq!([of("curved"), of("curved (back)")], [2, 2]);
    assert_eq!([of("room"), of("room (back)")], [12, 0]);
}

#[test]
fn scenes_without_light_or_surface_are_refused() {
    let mut scene = cornell_box(CornellVariant::Diffuse);
    for material in &mut scene.materials {
        material.emission = Rgb::BLACK;
    }
    let refused = |scene: &Scene, objects: &[u32]| {
        let tracer = Tracer::new(scene);
        bake(scene, &tracer, objects, &options(64, 0.1), &Progress::new()).unwrap_err()
    };
    assert_eq!(refused(&scene, &[0]), BakeError::Solve(SolveError::NoLight));
    assert!(refused(&scene, &[]).to_string().contains("no triangle"));
}

/// A plate in the sun whose shadow falls on one of two floors: with the same texels, the error of viewers is less
/// where texels follow the light.
#[test]
fn density_follows_the_edges_of_shadows() {
    let mut scene = Scene::default();
    let white = scene.add_material(Material::diffuse("white", Rgb::grey(0.5)));
    let mut square = |low: DVec3, width: f64| {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mut mesh = Mesh {
            positions: corners
                .map(|[x, y]| low + width * DVec3::new(x, y, 0.0))
                .to_vec(),
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, 2, 3], white);
        scene.objects.push(Object::new("floor", Shape::Mesh(mesh)));
    };
    square(DVec3::ZERO, 2.0);
    square(DVec3::new(5.0, 0.0, 0.0), 6.0);
    square(DVec3::new(0.6, 0.7, 0.5), 0.8);
    scene.lights.push(Light {
        name: "sun".into(),
        kind: LightKind::Directional {
            direction: DVec3::new(0.2, 0.1, -1.0).normalize(),
            irradiance: Rgb::grey(1.0),
            half_angle: 0.0,
        },
    });
    let bake = |follows_light: bool| {
        let options = BakeOptions {
            follows_light,
            sides: BakedSides::Front,
            ..options(96, 0.02)
        };
        baked(&scene, &options)
    };
    let [alike, followed] = [false, true].map(bake);
    let texels = |baked: &Baked, receiver: usize| -> f64 {
        let layout = &baked.atlas.layout;
        let area = |t: usize| {
            let [a, b, c] = layout.texels(receiver, t);
            (b - a).perp_dot(c - a).abs()
        };
        (0..2).map(area).sum()
    };
    assert!(texels(&followed, 0) > 2.0 * texels(&alike, 0));
    let [before, after] =
        [&alike, &followed].map(|baked| baked.between_texels / baked.lightmap.mean().mean());
    assert!(after < 0.8 * before, "{after}, {before} before");
}

/// What surfaces absorb of the light in the texels is what they absorb by the balance of the first pass.
#[test]
fn energy_is_kept() {
    let scene = meshes_of(&cornell_box(CornellVariant::Diffuse), true);
    let baked = baked(&scene, &options(128, 0.02));
    let mut absorbed = Rgb::BLACK;
    for (page, texel) in (0..128 * 128).map(|texel| (&baked.lightmap.pages[0], texel)) {
        let area = f64::from(page.areas[texel]);
        if area > 0.0 {
            let chart = page.charts[texel];
            let layout = &baked.atlas.layout;
            let receiver = layout
                .receivers
                .iter()
                .position(|r| r.charts.contains(&chart));
            let object = &scene.objects[baked.objects[receiver.unwrap()] as usize];
            let material = object.shape.mesh().unwrap().face_materials[0];
            let kept = Rgb::grey(1.0) - scene.materials[material as usize].diffuse;
            absorbed += kept * Rgb::from(page.irradiance[texel].map(f64::from)) * area;
        }
    }
    let balance = baked.report.as_ref().unwrap().balance;
    // Areas are in units of the scene, powers in W.
    let absorbed = absorbed * scene.units.metres().powi(2);
    let share = absorbed.mean() / balance.absorbed.mean();
    assert!(
        (share - 1.0).abs() < 0.01,
        "{share}: {absorbed:?}, {balance:?}"
    );
}

/// Checks that processes that share the work of a lightmap all get the bits of one process, and that each loop's
/// items are computed once, by several of them.
fn check_shared(whole: &Baked, work: impl Fn(&dyn Blocks) -> Baked + Sync) {
    let bits = |baked: &Baked| -> Vec<u32> {
        let pages = baked.lightmap.pages.iter();
        let values = pages.flat_map(|page| page.irradiance.iter().chain(&page.standard_error));
        values.flatten().map(|value| value.to_bits()).collect()
    };
    let (mut alone, mut most_busy) = (None, 0);
    for processes in [2, 5] {
        let found = together(processes, |blocks| {
            let blocks = CountedBlocks::new(blocks);
            (work(&blocks), blocks.items())
        });
        for (baked, _) in &found {
            assert!(bits(baked) == bits(whole), "{processes} processes");
            assert!(baked.atlas.layout == whole.atlas.layout && baked.texels == whole.texels);
            assert_eq!(
                baked.between_texels.to_bits(),
                whole.between_texels.to_bits()
            );
        }
        let items: usize = found.iter().map(|(_, items)| items).sum();
        assert_eq!(items, *alone.get_or_insert(items), "{processes} processes");
        let busy = found.iter().filter(|(_, items)| *items > 0).count();
        most_busy = most_busy.max(busy);
    }
    // One may be so quick that others find nothing left, but hardly each time.
    assert!(most_busy > 1);
}

#[test]
fn processes_do_not_matter() {
    let scene = meshes_of(&cornell_box(CornellVariant::MirrorBlock), true);
    let objects: Vec<u32> = (0..scene.objects.len() as u32).collect();
    let tracer = Tracer::new(&scene);
    let brighter = BakeOptions {
        follows_light: true,
        ..options(32, 0.3)
    };
    let limited = BakeOptions {
        light: BakedLight::Indirect,
        sides: BakedSides::Both,
        pass: FirstPass {
            bounces: Some(2),
            ..options(32, 0.3).pass
        },
        ..options(32, 0.3)
    };
    let of_rays = BakeOptions {
        sides: BakedSides::Both,
        ..with_rays(32, 32)
    };
    for mut options in [brighter, limited, of_rays] {
        options.pass.size = PatchSize::Count(200);
        check_shared(&baked(&scene, &options), |blocks| {
            let progress = Progress::new();
            let run = Run::new(blocks, &progress);
            bake(&scene, &tracer, &objects, &options, run).unwrap()
        });
    }
}

#[test]
fn processes_do_not_matter_to_occlusion() {
    let scene = meshes_of(&cornell_box(CornellVariant::Diffuse), true);
    let objects: Vec<u32> = (0..scene.objects.len() as u32).collect();
    let tracer = Tracer::new(&scene);
    for options in [options(64, 0.1), with_rays(48, 64)] {
        let whole = bake_occlusion(&scene, &tracer, &objects, &options, 0.3, &Progress::new());
        check_shared(&whole.unwrap(), |blocks| {
            let progress = Progress::new();
            let run = Run::new(blocks, &progress);
            bake_occlusion(&scene, &tracer, &objects, &options, 0.3, run).unwrap()
        });
    }
}
