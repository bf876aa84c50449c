//! Hostile files: none may cause a panic, hang or exhaust memory.

use super::solids::{FIGURES, SOLIDS};
use super::*;
use proptest::prelude::*;

fn must_fail(text: &str, files: &Memory, reason: &str) {
    let error = read(text.as_bytes(), "test.grf", files).err();
    let message = error.map(|e| e.to_string()).unwrap_or_default();
    assert!(message.contains(reason), "{message}");
}

#[test]
fn a_million_nested_blocks() {
    let none = Memory::new();
    let reason = "at most 256 nested levels";
    must_fail(&"begin ".repeat(1_000_000), &none, reason);
    must_fail(
        &"transform scale (1,1,1) begin ".repeat(1_000_000),
        &none,
        reason,
    );
    must_fail(
        &"def a = rgb (1,1,1) begin ".repeat(1_000_000),
        &none,
        reason,
    );
    must_fail(&"(".repeat(1_000_000), &none, "a block");
}

#[test]
fn the_deepest_nesting_fits_the_stack_of_a_thread() {
    let text = format!(
        "{}{}{}",
        "transform scale (1,1,1) begin ".repeat(256),
        triangle(""),
        " end".repeat(256)
    );
    let scene = scene(&text);
    assert_eq!(scene.objects.len(), 1);
    let again = document_text(&document(&text));
    assert_eq!(super::scene(&again), scene);
}

#[test]
fn includes_that_double() {
    // Two includes in each of 40 files: 2^40 in all.
    let files = (0..40).fold(Memory::new(), |files, k| {
        let name = format!("{k}.grf");
        files.with(name, format!("include {0}.grf include {0}.grf", k + 1))
    });
    must_fail(
        "include 0.grf",
        &files.with("40.grf", ""),
        "expected a smaller model",
    );
}

#[test]
fn a_tower_of_includes() {
    let files = (0..100).fold(Memory::new(), |files, k| {
        files.with(format!("{k}.grf"), format!("include {}.grf", k + 1))
    });
    must_fail("include 0.grf", &files, "at most 64 nested levels");
}

#[test]
fn counts_reserve_nothing() {
    must_fail(&triangle("4000000000 0 1 2"), &Memory::new(), "found `(`");
    let grids = "ext primitive begin kind = sphere map = 1 0 0 0 1 0 0 0 1 0 0 0 end ext \
        ext surface_light begin grids = 65536 65536 irradiance = (1,1,1) end ext";
    must_fail(grids, &Memory::new(), "4295098369 triples");
}

/// One line of a megabyte with unknown names: line and column must not be counted from the start
/// each time, nor the line be kept for each.
#[test]
fn one_long_line_of_names() {
    let uses: String = (0..60_000).map(|k| format!("use color c{k} ")).collect();
    must_fail(&triangle(&uses), &Memory::new(), "`c0`");
}

/// A long name, a long brdf and many textures that every face would copy.
#[test]
fn looks_that_multiply() {
    let name = "n".repeat(300_000);
    let faces: String = (0..2000)
        .map(|k| format!("rgb (0, 0, {k}e-4) (0, 1, 2) "))
        .collect();
    let textures = "use texture t ".repeat(10_000);
    let mesh = triangle(&format!("{textures} use brdf {name} {faces}"));
    let text = format!(
        "def t = texture x def {name} = brdf ward kd = 0.5 ks = 0.5 ax = 0.1 begin {mesh} end"
    );
    let scene = scene(&text);
    assert_eq!(scene.materials.len(), 2001);
    assert_eq!(scene.materials[1].textures.len(), 64);
    let names: usize = scene.materials.iter().map(|m| m.name.len()).sum();
    assert!(names < 300 << 20, "{names}");
}

#[test]
fn a_transform_that_overflows() {
    let huge = "transform scale (1e300,1,1) scale (1e300,1,1) begin";
    must_fail(
        &format!("{huge} {} end", triangle("")),
        &Memory::new(),
        "overflow",
    );
    let large = "transform scale (1e308,1,1) translation (1e308,0,0) begin";
    must_fail(
        &format!("{large} {} end", triangle("")),
        &Memory::new(),
        "overflow",
    );
}

#[test]
fn truncation_at_every_byte() {
    for sample in [CUBE, EVERYTHING, SOLIDS] {
        for end in 0..=sample.len() {
            let _ = read(&sample.as_bytes()[..end], "test.grf", &Memory::new());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn random_bytes_changed(
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        solids in any::<bool>()
    ) {
        let text = if solids { format!("{FIGURES}{SOLIDS}end def") } else { EVERYTHING.to_owned() };
        let mut bytes = text.into_bytes();
        for (at, byte) in edits {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Ok(loaded) = read(&bytes, "test.grf", &Memory::new()) {
            // What was read can be written, and reads back the same.
            prop_assert_eq!(loaded.scene.validate(), Ok(()));
            prop_assert_eq!(scene(&written(&loaded.scene)), loaded.scene);
        }
    }

    #[test]
    fn pieces_moved(cuts in prop::collection::vec(0..EVERYTHING.len(), 3)) {
        let mut cuts = cuts;
        cuts.sort_unstable();
        let bytes = EVERYTHING.as_bytes();
        let moved = [&bytes[..cuts[0]], &bytes[cuts[1]..cuts[2]], &bytes[cuts[0]..cuts[1]], &bytes[cuts[2]..]];
        let _ = read(&moved.concat(), "test.grf", &Memory::new());
    }
}
