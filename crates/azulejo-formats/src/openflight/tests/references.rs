//! External references: file lookup and content.

use super::super::opcode::*;
use super::writer::*;
use super::{check_loaded, load_with, mesh};
use crate::{Loaded, Memory, ReadOptions};
use azulejo_scene::{Rgb, Up};

const ORIGIN: [f64; 3] = [0.0; 3];
const OWN: u32 = u32::MAX;

fn reference(name: &str, flags: u32) -> FltRecord {
    FltRecord::new(EXTERNAL_REFERENCE, 216)
        .text(4, name)
        .u32(208, flags)
}

/// A file whose object `o` is in another file.
fn part() -> Vec<u8> {
    Flt::new().with(|f| f.node(object("o"), &[])).0
}

fn load(flt: Flt, files: &Memory) -> Loaded {
    load_with(flt, files, &ReadOptions::default())
}

/// A file that refers to `names`, below group `g`.
fn referring(names: &[&str]) -> Flt {
    let with_references = |f: Flt| names.iter().fold(f, |f, name| f.add(reference(name, OWN)));
    Flt::new().with(|f| f.add(group("g")).with(with_references))
}

#[test]
fn files_are_found() {
    let files = Memory::new()
        .with("parts/lamp.flt", part())
        .with("chair.flt", part())
        .with("parts/all.flt", referring(&["lamp.flt", "../chair.flt"]).0);
    let names = [
        ".\\parts\\lamp.flt",
        "D:\\models\\Chair.flt",
        "parts/all.flt",
    ];
    let expected: &[(&str, &[[f64; 3]])] = &[
        ("g/o", &[ORIGIN]),
        ("g/o", &[ORIGIN]),
        ("g/g/o", &[ORIGIN]),
        ("g/g/o", &[ORIGIN]),
    ];
    check_loaded(&load(referring(&names), &files), expected, &[]);
}

#[test]
fn what_is_missing_is_said() {
    let files = Memory::new().with("notes.flt", "no model at all");
    check_loaded(
        &load(referring(&["gone.flt", "notes.flt", "gone.flt"]), &files),
        &[],
        &[
            ("file \"gone.flt\" skipped: there is no such file", 2),
            (
                "file \"notes.flt\" skipped: notes.flt: byte 0 (0x0): found opcode 28271 and \
                 length 8301, expected a header record: opcode 1 and a length of at least 16",
                1,
            ),
            ("no faces: the scene is empty", 1),
        ],
    );
}

#[test]
fn cycles_are_refused() {
    let back = referring(&["A.FLT"]).0;
    let files = Memory::new()
        .with("b.flt", back)
        .with("self.flt", referring(&["./self.flt"]).0);
    let loaded = load(referring(&["b.flt", "self.flt"]), &files);
    let messages: Vec<&str> = loaded.warnings.iter().map(|w| &*w.message).collect();
    assert_eq!(
        messages,
        [
            "file \"A.FLT\" skipped: it refers to itself",
            "file \"./self.flt\" skipped: it refers to itself",
            "no faces: the scene is empty"
        ]
    );
}

#[test]
fn chains_end() {
    let name = |k: usize| format!("{k}.flt");
    let files = (0..30).fold(Memory::new(), |files, k| {
        files.with(name(k), referring(&[&name(k + 1)]).0)
    });
    let loaded = load(referring(&["0.flt"]), &files);
    let message = &loaded.warnings[0].message;
    assert!(
        message.contains("files nested more than 16 deep"),
        "{message}"
    );
}

#[test]
fn the_bytes_of_all_files_are_limited() {
    let files = Memory::new().with("b.flt", part());
    let options = ReadOptions {
        most_unpacked: 100,
        ..ReadOptions::default()
    };
    let loaded = load_with(referring(&["b.flt"]), &files, &options);
    let message = &loaded.warnings[0].message;
    assert!(message.contains("exceed the size limit"), "{message}");
}

#[test]
fn one_node_can_be_asked_for() {
    let house = Flt::new().with(|f| {
        f.node(object("roof"), &[])
            .add(group("wall"))
            .with(|f| f.node(object("door"), &[translation(1.0, 0.0, 0.0)]))
    });
    let files = Memory::new().with("house.flt", house.0);
    let names = ["house.flt<door>", "house.flt<wall>", "house.flt<cat>"];
    check_loaded(
        &load(referring(&names), &files),
        &[
            ("g/door", &[[1.0, 0.0, 0.0]]),
            ("g/wall/door", &[[1.0, 0.0, 0.0]]),
        ],
        &[("no node named \"cat\": skipped", 1)],
    );
}

#[test]
fn units_become_those_of_the_root() {
    let in_units = |unit| Flt::of(header(1600).u8(62, unit)).square();
    let kilometres = in_units(1)
        .add(group("km"))
        .add(translation(0.0, 0.0, 2.0))
        .with(|f| f.face(face()).add(reference("feet.flt", OWN)));
    let feet = in_units(4).node(object("ft"), &[translation(10.0, 0.0, 0.0)]);
    let unknown = in_units(3).node(object("?"), &[translation(1.0, 0.0, 0.0)]);
    let files = Memory::new()
        .with("km.flt", kilometres.0)
        .with("feet.flt", feet.0)
        .with("unknown.flt", unknown.0);
    let root = in_units(0)
        .add(reference("km.flt", OWN))
        .add(translation(5.0, 0.0, 0.0))
        .add(reference("unknown.flt", OWN));
    let loaded = load(root, &files);
    assert_eq!(loaded.scene.units.metres_per_unit, Some(1.0));
    assert_eq!(loaded.scene.units.up, Up::Z);
    check_loaded(
        &loaded,
        &[
            ("km/ft", &[[8.048, 0.0, 2000.0]]),
            ("km", &[[5.0, 0.0, 2000.0]]),
            ("?", &[[1.0, 0.0, 0.0]]),
        ],
        &[("unknown unit of length: not used", 1)],
    );
}

/// A colour palette whose first colour is `abgr`.
fn colors(abgr: u32) -> FltRecord {
    FltRecord::new(COLOR_PALETTE, 132 + 8).u32(132, abgr)
}

#[test]
fn palettes_are_the_files_own_or_the_referring_files() {
    let check = |revision, flags, with_palette, expected| {
        let part = Flt::new()
            .add(colors(0xff00_ff00))
            .face(face().u32(44, 0).u32(68, 127));
        let root = Flt::of(header(revision)).square();
        let root = if with_palette {
            root.add(colors(0xff00_00ff))
        } else {
            root
        };
        let files = Memory::new().with("b.flt", part.0);
        let loaded = load(root.add(reference("b.flt", flags)), &files);
        let material = mesh(&loaded, 0).face_materials[0] as usize;
        assert_eq!(loaded.scene.materials[material].diffuse, expected);
    };
    let (red, green) = (Rgb::new(1.0, 0.0, 0.0), Rgb::new(0.0, 1.0, 0.0));
    check(1600, OWN, true, green);
    check(1600, 1 << 31, true, green);
    check(1600, 0, true, red);
    check(1600, !(1 << 31), true, red);
    check(1600, 0, false, green);
    check(1410, 0, true, green);
}
