//! Damaged and hostile files.

use super::super::opcode::*;
use super::super::read;
use super::writer::*;
use super::{check_warned, load};
use crate::{Memory, ReadOptions};

const ORIGIN: [f64; 3] = [0.0; 3];

fn error(bytes: &[u8], options: &ReadOptions) -> String {
    match read(bytes, "a.flt", &Memory::new(), options) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("read"),
    }
}

fn check_error(bytes: &[u8], expected: &str) {
    assert_eq!(error(bytes, &ReadOptions::default()), expected);
}

#[test]
fn it_must_begin_with_a_header() {
    let expected = "expected a header record: opcode 1 and a length of at least 16";
    let check = |bytes: &[u8], found: &str| {
        check_error(
            bytes,
            &format!("a.flt: byte 0 (0x0): found {found}, {expected}"),
        );
    };
    check(b"", "the end of the file");
    check(b"\0\x01\0", "the end of the file");
    check(&group("g").0, "opcode 2 and length 44");
    check(&FltRecord::new(HEADER, 12).0, "opcode 1 and length 12");
    check(&header(1600).0[..100], "a header of 324 bytes, truncated");
}

#[test]
fn damage_ends_the_reading_and_is_said() {
    let drawn: &[(&str, &[[f64; 3]])] = &[("o", &[ORIGIN])];
    let good = Flt::new().node(object("o"), &[]);
    let cut = good.clone().add(FltRecord(group("g").0[..40].to_vec()));
    check_warned(
        cut,
        drawn,
        &[(
            "damaged: group (opcode 2) with a length of 44 bytes, but only 40 left; the rest of the file is skipped",
            1,
        )],
    );
    let short = good.clone().add(group("g").u16(2, 3)).add(group("g"));
    check_warned(
        short,
        drawn,
        &[(
            "damaged: group (opcode 2) with a length of 3 bytes, but only 88 left; the rest of the file is skipped",
            1,
        )],
    );
    let ragged = good.clone().add(FltRecord(vec![1, 2, 3]));
    check_warned(
        ragged,
        drawn,
        &[("3 bytes after the last record: skipped", 1)],
    );
    let padded = good.add(FltRecord(vec![0; 999]));
    check_warned(padded, drawn, &[]);
}

#[test]
fn levels_are_mended() {
    let push = || FltRecord::new(PUSH, 4);
    let pop = || FltRecord::new(POP, 4);
    let open = Flt::new()
        .add(push())
        .add(object("o"))
        .add(push())
        .face(face());
    check_warned(
        open,
        &[("o", &[ORIGIN])],
        &[("the file ends inside 2 nested levels: closed", 1)],
    );
    let closed = Flt::new()
        .add(pop())
        .add(pop())
        .add(pop())
        .node(object("o"), &[]);
    check_warned(
        closed,
        &[("o", &[ORIGIN])],
        &[("pop without a push: skipped", 3)],
    );
    let twice = Flt::new()
        .add(push())
        .add(push())
        .face(face())
        .add(pop())
        .add(pop());
    let warning = (
        "push without a node before it: taken as an unnamed group",
        1,
    );
    check_warned(twice, &[("", &[ORIGIN])], &[warning]);
}

#[test]
fn corners_that_are_no_vertices_are_left_out() {
    let nowhere = vertex([f64::NAN, 0.0, 0.0], 0);
    let flt = Flt::of(header(1600))
        .palette(vec![
            vertex([0.0; 3], 0),
            vertex([1.0, 0.0, 0.0], 0),
            nowhere,
            vertex([0.0, 1.0, 0.0], 0),
        ])
        .add(face())
        .with(|f| f.add(vertex_list(&[8, 48, 88, 128])))
        .add(face())
        .with(|f| f.add(vertex_list(&[8, 9, 48, u32::MAX])));
    check_warned(
        flt,
        &[("", &[ORIGIN])],
        &[
            (
                "corner that does not refer to a vertex of the palette: skipped",
                3,
            ),
            ("face with fewer than three corners: skipped", 1),
        ],
    );
}

#[test]
fn palettes_are_checked() {
    let stray = Flt::of(header(1600)).add(vertex([0.0; 3], 0)).square();
    let flt = stray
        .add(FltRecord::new(MATERIAL_PALETTE, 40))
        .add(FltRecord::new(VERTEX_PALETTE, 8))
        .add(vertex([0.0; 3], 0))
        .face(face());
    let outside = "vertex outside the vertex palette: skipped";
    check_warned(
        flt,
        &[("", &[ORIGIN])],
        &[
            (outside, 2),
            ("palette entry that is too short: skipped", 1),
            ("second vertex palette: skipped", 1),
        ],
    );
}

#[test]
fn a_matrix_of_no_numbers_is_left_out() {
    let matrix = translation(f32::INFINITY, 0.0, 0.0);
    check_warned(
        Flt::new().node(object("o"), &[matrix]),
        &[("o", &[ORIGIN])],
        &[("matrix that is too short or not finite: ignored", 1)],
    );
    // A vertex whose transformed position overflows is dropped.
    let far = translation(f32::MAX, 0.0, 0.0);
    let row = f32::MAX;
    let huge = matrix_of(row);
    let nested = |f: Flt| {
        (0..12).fold(f, |f, _| {
            f.add(group(""))
                .add(huge.clone())
                .add(FltRecord::new(PUSH, 4))
        })
    };
    let loaded = load(nested(Flt::new()).node(object("o"), &[far]));
    assert_eq!(loaded.scene.objects.len(), 0);
}

fn matrix_of(scale: f32) -> FltRecord {
    matrix([
        [scale, 0.0, 0.0],
        [0.0, scale, 0.0],
        [0.0, 0.0, scale],
        [0.0; 3],
    ])
}

#[test]
fn an_empty_file_says_so() {
    check_warned(Flt::new(), &[], &[("no faces: the scene is empty", 1)]);
}

#[test]
fn old_revisions_are_said() {
    let loaded = load(
        Flt::of(header(12))
            .add(face())
            .with(|f| f.add(FltRecord::new(7, 16))),
    );
    let messages: Vec<&str> = loaded.warnings.iter().map(|w| &*w.message).collect();
    assert_eq!(
        messages,
        [
            "revision 12: colours and vertices before revision 14 have other formats, which are not supported",
            "absolute vertex (before revision 13) (opcode 7): skipped",
            "face without corners: skipped",
            "no faces: the scene is empty",
        ]
    );
}

#[test]
fn levels_end() {
    let deep = (0..200).fold(Flt::new(), |f, _| {
        f.add(group("")).add(FltRecord::new(PUSH, 4))
    });
    let message = error(&deep.0, &ReadOptions::default());
    assert!(
        message.contains("nodes nested more than 128 deep"),
        "{message}"
    );
    let faces = (0..200).fold(Flt::new(), |f, _| {
        f.add(face()).add(FltRecord::new(PUSH, 4))
    });
    let message = error(&faces.0, &ReadOptions::default());
    assert!(
        message.contains("nodes nested more than 128 deep"),
        "{message}"
    );
}

/// Instances of instances: 16 of each in the next, ten levels.
#[test]
fn instances_are_limited() {
    let number = |opcode, k| FltRecord::new(opcode, 8).u16(6, k);
    let flt = (1..=10).fold(Flt::new(), |f, k| {
        f.add(number(INSTANCE_DEFINITION, k)).with(|f| {
            (0..16).fold(f.face(face()), |f, _| {
                f.add(number(INSTANCE_REFERENCE, k - 1))
            })
        })
    });
    let flt = flt.add(number(INSTANCE_REFERENCE, 10));
    check_budget(&flt.0);
}

/// A name of a hundred thousand bytes above as many objects as a small file can hold.
#[test]
fn names_are_limited() {
    let name = FltRecord::new(LONG_ID, 60_000).bytes(4, &[b'n'; 59_996]);
    let objects = |f| (0..200).fold(f, |f: Flt, _| f.node(object(""), &[]));
    let more = FltRecord::new(CONTINUATION, 40_000).bytes(4, &[b'n'; 39_996]);
    let flt = Flt::new().add(group("")).add(name).add(more).with(objects);
    check_budget(&flt.0);
}

/// Nested replicated groups.
#[test]
fn replication_is_limited() {
    let flt = (0..10).fold(Flt::new(), |f, _| {
        let replicate = FltRecord::new(REPLICATE, 8).u16(4, i16::MAX as u16);
        f.add(group(""))
            .add(replicate)
            .add(translation(1.0, 0.0, 0.0))
            .add(FltRecord::new(PUSH, 4))
    });
    check_budget(&flt.face(face()).0);
}

fn check_budget(bytes: &[u8]) {
    let options = ReadOptions {
        most_elements: 100_000,
        ..ReadOptions::default()
    };
    let message = error(bytes, &options);
    assert!(message.contains("expand to more than 100000"), "{message}");
}

/// Truncates a file at every byte and changes every byte: it must be read or rejected, and any
/// result must be valid.
#[test]
fn any_damage_is_survived() {
    let part = Flt::new().node(object("p"), &[]).0;
    let whole = everything().0;
    let files = Memory::new().with("b.flt", part);
    let options = ReadOptions {
        most_elements: 20_000,
        ..ReadOptions::default()
    };
    let check = |bytes: &[u8]| {
        if let Ok(loaded) = read(bytes, "a.flt", &files, &options) {
            let valid = loaded.scene.validate();
            valid.unwrap_or_else(|e| panic!("{e}"));
        }
    };
    for end in 0..whole.len() {
        check(&whole[..end]);
    }
    let mut changed = whole.clone();
    for at in 0..whole.len() {
        for value in [0, 0xff, whole[at] ^ 0x80] {
            changed[at] = value;
            check(&changed);
        }
        changed[at] = whole[at];
    }
}

/// A file with most types of nodes.
fn everything() -> Flt {
    let reference = FltRecord::new(EXTERNAL_REFERENCE, 216).text(4, "b.flt");
    let replicate = FltRecord::new(REPLICATE, 8).u16(4, 2);
    let instance = |opcode| FltRecord::new(opcode, 8).u16(6, 1);
    let pool = FltRecord::new(LOCAL_VERTEX_POOL, 12 + 72)
        .u32(4, 3)
        .u32(8, 1 << 31);
    let primitive = FltRecord::new(MESH_PRIMITIVE, 16)
        .u16(4, 1)
        .u16(6, 1)
        .u32(8, 3);
    Flt::of(FltRecord::new(HEADER, 128).u32(12, 1600))
        .square()
        .add(FltRecord::new(MATERIAL_PALETTE, 84).singles(76, &[1.0]))
        .add(FltRecord::new(COLOR_PALETTE, 140).u32(132, 0xff00_ffff))
        .with(|f| {
            f.add(FltRecord::new(LOD, 80).named("l"))
                .add(replicate)
                .add(translation(1.0, 2.0, 3.0))
                .with(|f| f.face(face().u8(48, 3)).face(face().u16(30, 0).u8(48, 2)))
                .add(instance(INSTANCE_DEFINITION))
                .with(|f| {
                    f.add(mesh())
                        .add(pool)
                        .with(|f| f.add(primitive.more(&[0, 1, 2])))
                })
                .add(instance(INSTANCE_REFERENCE))
                .add(reference)
                .add(FltRecord::new(SWITCH, 32).u32(20, 1).u32(24, 1).u8(31, 1))
                .with(|f| f.add(FltRecord::new(DOF, 384)).with(|f| f.face(face())))
        })
}
