//! Where something stands on a surface, texels have the light of one side of it.

use crate::lightmap::{baked, on_surface, options, places, room};
use azulejo::bake::Resolution;
use azulejo::lightmap::{BakeOptions, Baked, BakedSides, bake, meshes_of};
use azulejo::scene::{Attribute, Light, LightKind, Material, Mesh, Object, Rgb, Scene, Shape};
use azulejo::trace::{Progress, Tracer};
use glam::DVec3;

/// Texels per unit.
const DENSITY: f64 = 10.0;

/// Relative difference of light that is steep between the rim of a chart and the middle of the texel there.
const RIM: f64 = 0.04;

fn dense(error: f64) -> BakeOptions {
    let mut options = options(512, error);
    options.charts.resolution = Resolution::PerUnit(DENSITY);
    options
}

/// Irradiance as a viewer reads it at places of an object, with their position and the normal of the side.
fn read_light(baked: &Baked, object: u32, count: u32) -> Vec<(DVec3, DVec3, f64)> {
    let mut read = Vec::new();
    for place in places(baked, count) {
        let (r, t, weights) = place;
        if baked.objects[r] == object {
            let at = on_surface(baked, &place);
            let light = baked.irradiance(r, t, weights).unwrap().mean();
            read.push((at.position, at.normal, light));
        }
    }
    assert!(read.len() > 100, "{} places", read.len());
    read
}

/// How far from the foot of a thing a viewer's filter mixes the light of both sides: not at all where charts end
/// there, up to a texel where they do not.
fn blurred(cuts: bool) -> f64 {
    if cuts { 0.0 } else { 1.0 / DENSITY }
}

fn point_light(position: DVec3) -> Light {
    Light {
        name: "lamp".into(),
        kind: LightKind::Point {
            position,
            intensity: Rgb::grey(10.0),
        },
    }
}

/// A rectangle from corners in order, its front where they run against the clock.
fn rectangle(scene: &mut Scene, name: &str, corners: [[f64; 3]; 4], material: u32) {
    let mut mesh = Mesh {
        positions: corners.map(DVec3::from).to_vec(),
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2, 3], material);
    scene.objects.push(Object::new(name, Shape::Mesh(mesh)));
}

/// A box between these coordinates, its normals outside.
fn solid(scene: &mut Scene, extent: [[f64; 2]; 3], material: u32) {
    let [low, high] = [0, 1].map(|end| DVec3::from(extent.map(|axis| axis[end])));
    room(scene, low, high, material, true);
    turn_last(scene);
}

/// Turns the faces of the last object round.
fn turn_last(scene: &mut Scene) {
    if let Some(Shape::Mesh(mesh)) = scene.objects.last_mut().map(|object| &mut object.shape) {
        (0..mesh.faces.len()).for_each(|face| mesh.reverse_face(face));
    }
}

/// Walls of half a texel, of one, and of two, on a floor that runs under them: no light in the room, none of its dark
/// outside.
#[test]
fn closed_rooms_stay_dark() {
    for thickness in [0.05, 0.1, 0.2] {
        let mut scene = Scene::default();
        let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
        let floor = [[-4.0, -4.0], [8.0, -4.0], [8.0, 8.0], [-4.0, 8.0]].map(|[x, y]| [x, y, 0.0]);
        rectangle(&mut scene, "floor", floor, grey);
        let (low, high) = (DVec3::ZERO, DVec3::new(4.0, 4.0, 2.5));
        // The inner walls, and the outer ones with their fronts outside.
        room(&mut scene, low, high, grey, false);
        let out = DVec3::new(thickness, thickness, 0.0);
        room(
            &mut scene,
            low - out,
            high + out + DVec3::Z * thickness,
            grey,
            false,
        );
        turn_last(&mut scene);
        scene.lights.push(Light {
            name: "sky".into(),
            kind: LightKind::Ambient {
                radiance: Rgb::grey(1.0),
            },
        });
        let scene = meshes_of(&scene, true);
        let baked = baked(&scene, &dense(0.05));
        let (mut inside, mut outside, mut dimmest) = (0.0f64, 0.0f64, f64::INFINITY);
        for (p, _, e) in read_light(&baked, 0, 4000) {
            let is_inside = p.x > 0.0 && p.x < 4.0 && p.y > 0.0 && p.y < 4.0;
            let away = (p.x - 2.0).abs().max((p.y - 2.0).abs()) - 2.0 - thickness;
            if is_inside {
                inside = inside.max(e);
            } else if away > 0.0 {
                outside = outside.max(e);
                dimmest = dimmest.min(e);
            }
        }
        assert!(
            inside <= 1e-3 * outside,
            "{thickness}: {inside} of {outside}"
        );
        assert!(
            dimmest > 0.4 * outside,
            "{thickness}: {dimmest} of {outside}"
        );
    }
}

/// Two lamps in black surroundings, one at each side of a sheet that stands across a floor, where no edge of a texel
/// is: each side has the light of its own lamp, by I cos θ / d²; without one of them its side is black.
#[test]
fn a_partition_parts_the_light() {
    for (cuts, both) in [(false, true), (true, true), (false, false), (true, false)] {
        let mut scene = Scene::default();
        let black = scene.add_material(Material::diffuse("black", Rgb::BLACK));
        let floor = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]].map(|[x, y]| [x, y, 0.0]);
        rectangle(&mut scene, "floor", floor, black);
        let at = 1.73;
        let sheet = [[-50.0, 0.0], [50.0, 0.0], [50.0, 100.0], [-50.0, 100.0]];
        rectangle(&mut scene, "sheet", sheet.map(|[y, z]| [at, y, z]), black);
        let lamps = [DVec3::new(0.5, 1.5, 2.0), DVec3::new(3.5, 1.5, 2.0)];
        scene.lights = lamps.map(point_light).to_vec();
        if !both {
            scene.lights.remove(0);
        }
        let scene = meshes_of(&scene, cuts);
        let options = BakeOptions {
            sides: BakedSides::Front,
            ..dense(0.01)
        };
        // The sheet receives nothing: it would take most of the page.
        let (tracer, progress) = (Tracer::new(&scene), Progress::new());
        let baked = bake(&scene, &tracer, &[0], &options, &progress).unwrap();
        for (p, _, light) in read_light(&baked, 0, 2000) {
            let lamp = usize::from(p.x > at);
            let way = lamps[lamp] - p;
            let expected = if lamp == 0 && !both {
                0.0
            } else {
                10.0 * way.z / way.length().powi(3)
            };
            let off = light - expected;
            if (p.x - at).abs() < blurred(cuts) {
                continue;
            }
            assert!(
                off >= -0.02 * expected,
                "cuts {cuts}, {p}: {light} for {expected}"
            );
            // Half a texel along the rim has the light of the texel.
            let rim = p.x.min(p.y).min(4.0 - p.x).min(3.0 - p.y);
            if (p.x - at).abs() > 1.0 / DENSITY && rim > 0.5 / DENSITY {
                assert!(
                    off < RIM * expected + 2e-3,
                    "cuts {cuts}, {p}: {light} for {expected}"
                );
            }
        }
    }
}

/// A column runs through three storeys, whose floors are a texel thick; a lamp is in the middle one. No light on it
/// below and above, and all of it beside the lamp.
#[test]
fn a_column_has_the_light_of_each_storey() {
    for cuts in [false, true] {
        let mut scene = Scene::default();
        let black = scene.add_material(Material::diffuse("black", Rgb::BLACK));
        let storeys = [[0.0, 1.87], [1.97, 3.91], [4.01, 6.0]];
        let column = [[1.8, 2.2], [1.8, 2.2], [-1.0, 7.0]];
        solid(&mut scene, column, black);
        for slab in [[-0.1, 0.0], [1.87, 1.97], [3.91, 4.01], [6.0, 6.1]] {
            solid(&mut scene, [[0.0, 4.0], [0.0, 4.0], slab], black);
        }
        for wall in [[-0.1, 0.0], [4.0, 4.1]] {
            solid(&mut scene, [wall, [-0.1, 4.1], [-0.1, 6.1]], black);
            solid(&mut scene, [[0.0, 4.0], wall, [-0.1, 6.1]], black);
        }
        let lamp = DVec3::new(0.5, 2.0, 3.0);
        scene.lights.push(point_light(lamp));
        let scene = meshes_of(&scene, cuts);
        let options = BakeOptions {
            sides: BakedSides::Front,
            ..dense(0.01)
        };
        let baked = baked(&scene, &options);
        for (p, normal, light) in read_light(&baked, 0, 40_000) {
            let margin = blurred(cuts);
            let is_in = |s: &[f64; 2]| p.z > s[0] + margin && p.z < s[1] - margin;
            let of = storeys.iter().position(is_in);
            let way = lamp - p;
            let expected = match of {
                Some(1) => 10.0 * way.dot(normal).max(0.0) / way.length().powi(3),
                _ => 0.0,
            };
            // What is inside of a floor nobody sees.
            if of.is_some() {
                assert!(
                    (light - expected).abs() < RIM * expected + 2e-3,
                    "cuts {cuts}, {p} {normal}: {light} for {expected}"
                );
            }
        }
    }
}

/// A box on a floor in the sun: the floor is lit up to its foot on one side, and black in its shadow on the other.
#[test]
fn a_box_has_its_shadow_at_its_foot() {
    for cuts in [false, true] {
        let mut scene = Scene::default();
        let black = scene.add_material(Material::diffuse("black", Rgb::BLACK));
        let floor = [[0.0, 0.0], [5.0, 0.0], [5.0, 4.0], [0.0, 4.0]].map(|[x, y]| [x, y, 0.0]);
        rectangle(&mut scene, "floor", floor, black);
        let (low, high) = (DVec3::new(1.63, 1.37, 0.0), DVec3::new(2.67, 2.71, 1.0));
        solid(&mut scene, [0, 1, 2].map(|k| [low[k], high[k]]), black);
        let direction = DVec3::new(1.0, 0.0, -1.0).normalize();
        scene.lights.push(Light {
            name: "sun".into(),
            kind: LightKind::Directional {
                direction,
                irradiance: Rgb::grey(10.0),
                half_angle: 0.0,
            },
        });
        let scene = meshes_of(&scene, cuts);
        let options = BakeOptions {
            sides: BakedSides::Front,
            ..dense(0.01)
        };
        let baked = baked(&scene, &options);
        let lit = -10.0 * direction.z;
        let texel = 1.0 / DENSITY;
        for (p, _, light) in read_light(&baked, 0, 4000) {
            let is_beside = |margin: f64| p.y > low.y + margin && p.y < high.y - margin;
            // Under the box nobody looks.
            if is_beside(0.0) && p.x < low.x - blurred(cuts) {
                assert!(light > 0.98 * lit, "cuts {cuts}, {p}: {light} for {lit}");
            }
            let is_dark = p.x > high.x && p.x < high.x + 1.0 - 2.0 * texel;
            if is_beside(2.0 * texel) && is_dark {
                assert!(
                    light < 1e-3 * lit,
                    "cuts {cuts}, {p}: {light} in the shadow"
                );
            }
        }
    }
}

/// A smooth sphere over a floor, under a lamp and a sky: charts end somewhere, and both sides of each end
/// have the same light.
#[test]
fn a_sphere_has_no_seams() {
    let mut scene = Scene::default();
    let white = scene.add_material(Material::diffuse("white", Rgb::grey(0.5)));
    let steps = 12;
    let mut mesh = Mesh::default();
    let mut normals = Vec::new();
    // Six squares of a cube, blown up.
    for face in 0..6 {
        let axis = face % 3;
        let sign = if face < 3 { 1.0 } else { -1.0 };
        let first = mesh.positions.len() as u32;
        for k in 0..(steps + 1) * (steps + 1) {
            let [u, v] = [k % (steps + 1), k / (steps + 1)]
                .map(|i| 2.0 * f64::from(i) / f64::from(steps) - 1.0);
            let mut p = [0.0; 3];
            (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (sign, sign * u, v);
            let normal = DVec3::from(p).normalize();
            mesh.positions.push(normal);
            normals.push(normal);
        }
        for k in 0..steps * steps {
            let a = first + k / steps * (steps + 1) + k % steps;
            let corners = [a, a + 1, a + steps + 2, a + steps + 1];
            mesh.push_face(&corners, white);
        }
    }
    mesh.normals = Some(Attribute::per_vertex(normals));
    scene.objects.push(Object::new("sphere", Shape::Mesh(mesh)));
    let floor = [[-4.0, -4.0], [4.0, -4.0], [4.0, 4.0], [-4.0, 4.0]].map(|[x, y]| [x, y, -1.5]);
    rectangle(&mut scene, "floor", floor, white);
    scene.lights.push(point_light(DVec3::new(3.0, 2.0, 4.0)));
    scene.lights.push(Light {
        name: "sky".into(),
        kind: LightKind::Ambient {
            radiance: Rgb::grey(0.3),
        },
    });
    let options = BakeOptions {
        sides: BakedSides::Front,
        ..options(256, 0.02)
    };
    let baked = baked(&scene, &options);
    let charts = &baked.atlas.layout.receivers[0].charts;
    assert!(charts.iter().any(|chart| *chart != charts[0]), "one chart");
    let mean = baked.lightmap.mean().mean();
    let seams = baked.seams;
    assert!(seams.points > 200, "{} points", seams.points);
    assert!(seams.abrupt * 10 < seams.points, "{seams:?}");
    assert!(seams.after <= 0.005 * mean, "{} of {mean}", seams.after);
}
