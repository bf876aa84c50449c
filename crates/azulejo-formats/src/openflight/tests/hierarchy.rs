//! Nodes: names, transforms, and selection.

use super::super::opcode::*;
use super::writer::*;
use super::{check, check_loaded, check_warned, load, load_with};
use crate::{Lod, Memory, ReadOptions};
use azulejo_scene::{LightKind, Rgb};
use glam::DVec3;

const ORIGIN: [f64; 3] = [0.0; 3];

fn long_id(name: &str) -> FltRecord {
    FltRecord::new(LONG_ID, 4).more(name.as_bytes()).more(&[0])
}

fn replicate(copies: u16) -> FltRecord {
    FltRecord::new(REPLICATE, 8).u16(4, copies)
}

#[test]
fn objects_are_named_by_their_path() {
    let flt = Flt::new().with(|f| {
        f.add(group("house")).with(|f| {
            f.add(group(""))
                .with(|f| {
                    f.add(object("o1"))
                        .add(long_id("kitchen table"))
                        .with(|f| f.face(face()).face(face()))
                })
                .node(object("o2"), &[])
        })
    });
    check(
        flt,
        &[
            ("house/kitchen table", &[ORIGIN, ORIGIN]),
            ("house/o2", &[ORIGIN]),
        ],
    );
}

#[test]
fn faces_below_a_group_are_one_object() {
    let flt = Flt::new().with(|f| {
        f.face(face()).add(group("g")).with(|f| {
            f.face(face())
                .node(object("o"), &[])
                .face(face())
                .face(face())
        })
    });
    let expected: &[(&str, &[[f64; 3]])] = &[
        ("g/o", &[ORIGIN]),
        ("g", &[ORIGIN, ORIGIN, ORIGIN]),
        ("", &[ORIGIN]),
    ];
    check(flt, expected);
}

#[test]
fn matrices_multiply() {
    // x → y → −x, then translated.
    let turn = matrix([
        [0.0, 1.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0],
        [5.0, 0.0, 0.0],
    ]);
    let flt = Flt::new().with(|f| {
        f.add(group("g"))
            .add(FltRecord::new(78, 56))
            .add(turn)
            .with(|f| f.node(object("o"), &[translation(1.0, 2.0, 3.0)]))
    });
    check(flt, &[("g/o", &[[3.0, 1.0, 3.0]])]);
}

#[test]
fn a_matrix_far_away_has_the_digits_of_its_translations() {
    let by = |delta: [f64; 3]| FltRecord::new(78, 56).doubles(32, &delta);
    let place = [500_000.123, 5_400_000.456, 300.789];
    let [x, y, z] = place.map(|v| v as f32);
    let parts = [
        by([0.0, 400_000.0, 0.0]),
        by([place[0], 5_000_000.456, place[2]]),
    ];
    let with = |matrix: FltRecord| {
        let flt = Flt::new().node(object("o"), &[parts[0].clone(), parts[1].clone(), matrix]);
        super::mesh(&load(flt), 0).positions[0]
    };
    let exact = DVec3::from(place);
    assert!((with(translation(x, y, z)) - exact).length() < 1e-8);
    // Another matrix is not theirs.
    assert_eq!(with(translation(x, y + 1.0, z)).y, f64::from(y + 1.0));
}

#[test]
fn a_mirror_keeps_fronts() {
    let mirror = matrix([
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, 0.0],
    ]);
    let loaded = load(Flt::new().node(object("o"), &[mirror]));
    let mesh = super::mesh(&loaded, 0);
    assert_eq!(mesh.face_area_vector(0), DVec3::Z);
    assert_eq!(mesh.positions[mesh.faces.get(0)[3] as usize].x, -1.0);
}

#[test]
fn replication_repeats_the_matrix() {
    let flt = Flt::new().with(|f| f.node(object("o"), &[replicate(2), translation(2.0, 0.0, 0.0)]));
    let at = |x: f64| [x, 0.0, 0.0];
    check(
        flt,
        &[("o", &[at(0.0)]), ("o", &[at(2.0)]), ("o", &[at(4.0)])],
    );
    let of_face = Flt::new().add(object("o")).with(|f| {
        f.add(face())
            .add(translation(0.0, 0.0, 3.0))
            .add(replicate(1))
            .with(|f| f.add(vertex_list(&CORNERS)))
            .face(face())
    });
    check(of_face, &[("o", &[ORIGIN, [0.0, 0.0, 3.0], ORIGIN])]);
    check_warned(
        Flt::new().node(object("o"), &[replicate(9)]),
        &[("o", &[ORIGIN])],
        &[(
            "replication without a matrix: ignored, all copies would coincide",
            1,
        )],
    );
}

#[test]
fn a_degree_of_freedom_stands_at_its_current_values() {
    let mut current = FltRecord::new(DOF, 384).named("door");
    let axes = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    current = current.doubles(16, &axes).doubles(88 + 2 * 32 + 16, &[7.0]);
    check(
        Flt::new().node(current, &[]),
        &[("door", &[[7.0, 0.0, 0.0]])],
    );
    check_warned(
        Flt::new().node(FltRecord::new(DOF, 80).named("door"), &[]),
        &[("door", &[ORIGIN])],
        &[(
            "degree of freedom that is too short or not finite: ignored",
            1,
        )],
    );
}

/// A level of detail with its switch distances.
fn lod(name: &str, switch_in: f64, switch_out: f64) -> FltRecord {
    FltRecord::new(LOD, 80)
        .named(name)
        .doubles(16, &[switch_in, switch_out])
}

fn check_lod(lod_asked: Lod, expected: &[&str]) {
    let old = FltRecord::new(OLD_LOD, 40)
        .named("old")
        .u32(12, 10)
        .u32(16, 0);
    let flt = Flt::new().with(|f| {
        f.node(lod("near", 10.0, 0.0), &[])
            .node(lod("mid", 20.0, 10.0), &[])
            .node(lod("far", 90.0, 20.0), &[])
            .add(lod("empty", 99.0, 90.0))
            .node(group("always"), &[])
            .node(old, &[])
    });
    let options = ReadOptions {
        lod: lod_asked,
        ..ReadOptions::default()
    };
    let loaded = load_with(flt, &Memory::new(), &options);
    let names: Vec<&str> = loaded.scene.objects.iter().map(|o| &*o.name).collect();
    assert_eq!(names, expected, "{lod_asked:?}");
    let left_out: usize = loaded.warnings.iter().map(|w| w.count).sum();
    // The empty one makes no object, but is counted as skipped all the same.
    let empty = usize::from(lod_asked != Lod::All);
    assert_eq!(left_out, 5 - expected.len() + empty, "{lod_asked:?}");
}

#[test]
fn levels_of_detail_are_chosen() {
    check_lod(Lod::Finest, &["near", "always", "old"]);
    check_lod(Lod::Coarsest, &["far", "always"]);
    check_lod(Lod::Distance(0.0), &["near", "always", "old"]);
    check_lod(Lod::Distance(10.0), &["near", "always", "old"]);
    check_lod(Lod::Distance(10.5), &["mid", "always"]);
    check_lod(Lod::All, &["near", "mid", "far", "always", "old"]);
}

#[test]
fn switches_show_their_current_mask() {
    let switch = |current: u32, masks: &[u32]| {
        let words: Vec<u8> = masks.iter().flat_map(|m| m.to_be_bytes()).collect();
        FltRecord::new(SWITCH, 28)
            .named("s")
            .u32(16, current)
            .u32(20, masks.len() as u32 / 2)
            .u32(24, 2)
            .more(&words)
    };
    let file = |switch| {
        Flt::new()
            .add(switch)
            .add(long_id("lamp"))
            .with(|f| (0..34).fold(f, |f, k| f.node(object(&k.to_string()), &[])))
    };
    let off = "node that its switch disables: skipped";
    check_warned(
        file(switch(1, &[0, 0, 1 << 31 | 1, 2])),
        &[
            ("lamp/0", &[ORIGIN]),
            ("lamp/31", &[ORIGIN]),
            ("lamp/33", &[ORIGIN]),
        ],
        &[(off, 31)],
    );
    let loaded = load(file(switch(2, &[0, 0, 0, 0])));
    assert_eq!(loaded.scene.objects.len(), 34);
    let warning = "switch without its current mask: all children are used";
    assert_eq!(super::said(&loaded), [(warning, 1)]);
}

#[test]
fn an_animation_stands_at_its_first_frame() {
    let animated = |revision: u32, flags: u32| {
        let flt = Flt::of(header(revision)).square();
        flt.add(group("g").u32(16, flags))
            .with(|f| f.node(object("1"), &[]).node(object("2"), &[]))
    };
    let left_out = &[("frame of an animation after the first: skipped", 1)];
    for (revision, flags) in [(1600, 1 << 30), (1600, 1 << 25), (1570, 1 << 29)] {
        check_warned(animated(revision, flags), &[("g/1", &[ORIGIN])], left_out);
    }
    let still: &[(&str, &[[f64; 3]])] = &[("g/1", &[ORIGIN]), ("g/2", &[ORIGIN])];
    check(animated(1600, 1 << 29), still);
    check(animated(1570, 1 << 25), still);
}

#[test]
fn instances_are_drawn_where_they_are_referred_to() {
    let definition = FltRecord::new(INSTANCE_DEFINITION, 8).u16(6, 3);
    let reference = |number| FltRecord::new(INSTANCE_REFERENCE, 8).u16(6, number);
    let flt = Flt::new().with(|f| {
        f.add(definition.clone())
            .add(translation(0.0, 0.0, 1.0))
            .with(|f| f.node(object("o"), &[]))
            .add(group("g"))
            .with(|f| f.add(reference(3)).add(translation(2.0, 0.0, 0.0)))
            .add(reference(3))
            .add(reference(4))
    });
    check_warned(
        flt,
        &[("g/o", &[[2.0, 0.0, 1.0]]), ("o", &[[0.0, 0.0, 1.0]])],
        &[("reference to instance 4, which is not defined: skipped", 1)],
    );
    let inside_itself = Flt::new()
        .add(definition)
        .with(|f| f.node(object("o"), &[]).add(reference(3)))
        .add(reference(3));
    check_warned(
        inside_itself,
        &[("o", &[ORIGIN])],
        &[("instance 3 inside itself: skipped", 1)],
    );
}

#[test]
fn what_is_no_surface_is_named() {
    let nodes = [87, 91, 92, 95, 98, 111, 115, 116, 126, 127, 130, 131];
    let others = [50, 52, 83, 88, 90, 93, 97, 112, 114, 125, 128, 133, 9999];
    let silent = [31, 74, 76, 82, 94, 105, 110, 119, 132];
    let flt = nodes.iter().fold(Flt::new(), |f, &opcode| {
        f.node(FltRecord::new(opcode, 16).named(&opcode.to_string()), &[])
    });
    let flt = others
        .iter()
        .chain(&silent)
        .fold(flt, |f, &opcode| f.add(FltRecord::new(opcode, 8)));
    let loaded = load(flt.node(object("last"), &[]));
    // Roads and clip regions contain ordinary geometry.
    let names: Vec<&str> = loaded.scene.objects.iter().map(|o| &*o.name).collect();
    assert_eq!(names, ["87", "98", "127", "last"]);
    let named = |opcode: &&u16| {
        let number = format!("(opcode {opcode})");
        let is_it = |w: &&crate::Warning| w.message.contains(&number);
        loaded.warnings.iter().any(|w| is_it(&w) && w.count == 1)
    };
    assert_eq!(nodes.iter().filter(named).count(), nodes.len());
    assert_eq!(others.iter().filter(named).count(), others.len());
    assert_eq!(silent.iter().filter(named).count(), 0);
    let sound = &loaded
        .warnings
        .iter()
        .find(|w| w.message.starts_with("text ("))
        .unwrap();
    assert_eq!(sound.message, "text (opcode 95): skipped");
    assert!(matches!(sound.position, crate::Position::Byte(at) if at > 324));
}

/// An entry of the light source palette.
fn light(index: u32, kind: u32) -> FltRecord {
    FltRecord::new(LIGHT_SOURCE_PALETTE, 240)
        .u32(4, index)
        .text(16, "lamp")
        .singles(56, &[1.0, 0.5, 0.25, 1.0])
        .u32(88, kind)
        .singles(132, &[0.0, 30.0])
        .singles(148, &[1.0, 0.0, 0.0])
}

/// A light source node that is on, at (0, 0, 5).
fn source(name: &str, index: u32, yaw: f32, pitch: f32) -> FltRecord {
    FltRecord::new(LIGHT_SOURCE, 64)
        .named(name)
        .u32(16, index)
        .u32(24, 3 << 30)
        .doubles(32, &[0.0, 0.0, 5.0])
        .singles(56, &[yaw, pitch])
}

#[test]
fn light_sources_shine() {
    let flt = Flt::new()
        .add(light(0, 0))
        .add(light(1, 1))
        .add(light(2, 2))
        .add(source("sun", 0, 90.0, 45.0))
        .add(source("", 1, 0.0, 0.0))
        .add(translation(1.0, 0.0, 0.0))
        .with(|f| f.face(face()))
        .add(source("spot", 2, 0.0, -90.0));
    let loaded = load(flt);
    assert_eq!(loaded.warnings, []);
    assert_eq!(loaded.scene.objects.len(), 1);
    let color = Rgb::new(1.0, 0.5, 0.25);
    let [sun, point, spot] = &loaded.scene.lights[..] else {
        panic!("three lights")
    };
    let half = 0.5f64.sqrt();
    let from_west_above = DVec3::new(half, 0.0, -half);
    assert!(
        matches!(sun.kind, LightKind::Directional { direction, irradiance, half_angle: 0.0 }
        if direction.abs_diff_eq(from_west_above, 1e-7) && irradiance == color)
    );
    assert!(
        matches!(point.kind, LightKind::Point { position, intensity }
        if position == DVec3::new(1.0, 0.0, 5.0) && intensity == color)
    );
    assert!(
        matches!(spot.kind, LightKind::Spot { direction, inner, outer, .. }
        if direction.abs_diff_eq(-DVec3::Z, 1e-7)
            && inner == outer && (outer - 30f64.to_radians()).abs() < 1e-7)
    );
    assert_eq!((&*sun.name, &*point.name), ("sun", "lamp"));
}

#[test]
fn what_lights_lose_is_said() {
    let fading = light(0, 2).singles(132, &[4.0]).singles(152, &[0.5]);
    let flt = Flt::new()
        .face(face())
        .add(fading)
        .add(light(1, 7))
        .add(source("", 0, 0.0, 0.0).u32(24, 1 << 31))
        .add(source("", 0, 0.0, 0.0).u32(24, 0))
        .add(source("", 1, 0.0, 0.0))
        .add(source("", 8, 0.0, 0.0));
    let loaded = load(flt);
    assert_eq!(loaded.scene.lights.len(), 1);
    let warnings = [
        "light source limited to its descendants: lights the whole scene",
        "attenuation of a light source: ignored, light falls off with the square of the distance",
        "exponent of a spot light: replaced by a smooth falloff from its axis to its edge",
        "light source that is disabled: skipped",
        "light source of unknown type, without a position, or with invalid numbers: skipped",
        "light source without a palette entry: skipped",
    ];
    check_loaded(&loaded, &[("", &[ORIGIN])], &warnings.map(|w| (w, 1)));
}
