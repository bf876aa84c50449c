//! Reflection models, in place and in files.

use super::{document, document_text, loaded, read, scene, triangle, warnings, written};
use crate::{Folder, Memory};
use azulejo_scene::brdf::{Content, Description, MODELS};
use azulejo_scene::{Material, Rgb};

fn material(brdf: &str) -> Material {
    loaded(&triangle(brdf)).scene.materials[0].clone()
}

fn text_of(material: &Material) -> String {
    let brdf = material.brdf.as_ref();
    brdf.map(|b| b.description().to_string())
        .unwrap_or_default()
}

/// Checks the error for a brdf alone on the second line.
#[track_caller]
fn must_fail(brdf: &str, expected: &str) {
    let text = format!("def a =\nbrdf {brdf}\n");
    let error = read(text.as_bytes(), "test.grf", &Memory::new()).map(|l| l.scene);
    let message = error.expect_err(brdf).to_string();
    let first = message.lines().next().unwrap_or_default();
    assert_eq!(first, format!("test.grf:2:{expected}"));
}

#[test]
fn every_model_is_read_written_and_read() {
    for example in MODELS.iter().flat_map(|m| m.examples) {
        let text = format!(
            "def a = brdf {example} begin {} end",
            triangle("use brdf a")
        );
        let read = scene(&text);
        assert_eq!(read.validate(), Ok(()), "{example}");
        if read.materials[0].brdf.is_some() {
            assert_eq!(text_of(&read.materials[0]), *example);
        }
        assert_eq!(scene(&written(&read)), read, "{example}");
        let once = document_text(&document(&text));
        assert_eq!(document_text(&document(&once)), once, "{example}");
    }
}

#[test]
fn the_names_of_the_grammar() {
    for brdf in [
        "phong n = 20 ks = 0.2 kd = 0.4",
        "blinn n = 20 ks = 0.2 kd = 0.4",
        "torrance rough = 0.1 nreal = 1.5 nimag = 0 ks = 0.2 kd = (0.1, 0.2, 0.3)",
        "poulin d = 2.2 n = 20 ks = 0.2 kd = 0.4",
        "he sigma = 0.18 tau = 3 nreal = 1.5 nimag = 2",
        "ward ax = 0.1 ay = 0.2 ks = 0.2 kd = 0.4",
        "lewis n = 20 ks = 0.2 kd = 0.4",
        "oren-nayar kd = 0.3 sigma = 20",
        "cook_torrance m = 0.2 metal = gold",
    ] {
        assert_eq!(text_of(&material(&format!("brdf {brdf}"))), brdf);
    }
    let sum = "combination weight = 0.5 lewis n = 3 ks = 0.5 weight = 0.25 diffuse kd = 1";
    assert_eq!(text_of(&material(&format!("brdf {sum}"))), sum);
}

#[test]
fn colours_multiply_what_is_diffuse() {
    let lewis = "brdf lewis n = 20 ks = 0.25 kd = 0.5";
    let red = material(&format!("rgb (0.5, 0, 0) {lewis}"));
    assert_eq!(red.diffuse, Rgb::new(0.25, 0.0, 0.0));
    // A colour sets what the brdf leaves undefined.
    let red = material("rgb (0.5, 0, 0) brdf lewis n = 20 ks = 0.25");
    assert_eq!(red.diffuse, Rgb::new(0.5, 0.0, 0.0));
    let definition = "def a = brdf lewis n = 20 ks = 0.25 kd = 0.5 begin \
        ext material begin of = a diffuse = (0.1, 0.2, 0.3) end ext ";
    let painted = scene(&format!("{definition} {} end", triangle("use brdf a")));
    assert_eq!(painted.materials[0].diffuse, Rgb::new(0.1, 0.2, 0.3));
    assert!(painted.materials[0].brdf.is_some());
    assert_eq!(scene(&written(&painted)), painted);
}

#[test]
fn errors_say_where_and_what_is_nearest() {
    must_fail(
        "wardd ax = 0.1",
        "6: found the reflection model `wardd`, expected a known one: the nearest name is `ward`",
    );
    must_fail(
        "lewis n = 3 kss = 1",
        "18: found the parameter `kss` of `lewis`, expected kd, ks, n: the nearest name is `ks`",
    );
    must_fail(
        "lewis n = -1",
        "12: found `n` of -1, expected a number between 0 and 1000000",
    );
    must_fail("lewis ks = 1", "6: found `lewis` without `n`, expected `n`");
    must_fail(
        "lewis n = 1 n = 2",
        "18: found `n` again, expected each parameter once",
    );
    must_fail(
        "lewis n = (1, 2, 3)",
        "12: found another type of value for `n`, expected one number",
    );
    must_fail(
        "lewis n = (1, 2)",
        "16: found two numbers, expected a number or (r, g, b)",
    );
    must_fail(
        "diffuse kd = 2",
        "14: found `kd` of 2, expected a number between 0 and 1",
    );
    must_fail(
        "combination weight = 0.7 diffuse kd = 1 weight = 0.7 specular ks = 1",
        "6: found a reflectance of 1.4, expected at most 1, for energy conservation",
    );
    must_fail(
        "combination weight = -1 diffuse kd = 1",
        "27: found a weight of -1, expected a weight from 0 to 1",
    );
    must_fail(
        "combination weight = 0.5 lewis n = 3 weight = 0.2 ward ks = 1",
        "56: found `ward` without `ax`, expected `ax`",
    );
}

#[test]
fn doubtful_models_are_named() {
    let messages = warnings(&triangle("brdf phong n = 20 ks = 0.2 kd = 0.4"));
    assert!(
        messages[0].contains("`phong` is not reciprocal"),
        "{messages:?}"
    );
    // The one does not hide the other; 20 reflects too much where 2000 does not.
    for n in [20, 2000] {
        let messages = warnings(&triangle(&format!("brdf phong n = {n} ks = 1 kd = 0.9")));
        let second = if n == 20 { "degrees" } else { "kd + ks of 1.9" };
        assert!(
            messages[0].contains("`phong` is not reciprocal"),
            "{messages:?}"
        );
        assert!(messages[1].contains(second), "{messages:?}");
    }
    let messages = warnings(&triangle("brdf ward_duer ax = 0.3 ks = 1"));
    assert!(messages[0].contains("at 85 degrees"), "{messages:?}");
    let none: [String; 0] = [];
    assert_eq!(warnings(&triangle("brdf ward_gmd ax = 0.3 ks = 1")), none);
    assert_eq!(
        warnings(&triangle("brdf ward_duer ax = 0.1 ks = 0.1")),
        none
    );
}

const WARD: &str = "begin brdf model ward_gmd diffuse 0.1 specular 0.5 param ax 0.1 end brdf";

#[test]
fn files_hold_models() {
    let files = Memory::new().with("a/brushed.brdf", WARD).with(
        "a/part.grf",
        triangle("brdf \"brushed.brdf\" (0, 1, 2) brdf \"brushed.brdf\""),
    );
    let text = "include \"a/part.grf\"";
    let loaded = read(text.as_bytes(), "test.grf", &files).unwrap();
    assert_eq!(loaded.warnings, []);
    let [material] = &loaded.scene.materials[..] else {
        panic!("one material")
    };
    assert_eq!(material.diffuse, Rgb::grey(0.1));
    let brdf = material.brdf.as_ref().unwrap();
    let Description::File { path, content } = brdf.description() else {
        panic!("a file")
    };
    let expected = "ward_gmd kd = 0.1 ks = 0.5 ax = 0.1".parse().unwrap();
    assert_eq!(path, "a/brushed.brdf");
    assert_eq!(content.as_deref(), Some(&Content::Text(expected)));
    let again = read(written(&loaded.scene).as_bytes(), "test.grf", &files).unwrap();
    assert_eq!(again.scene, loaded.scene);
}

#[test]
fn files_that_are_missing_or_wrong() {
    let text = format!("\n{}", triangle("brdf \"gone.brdf\""));
    assert_eq!(
        warnings(&text),
        [
            "test.grf:2:81: brdf \"gone.brdf\" skipped, its surface is diffuse: there is no such file"
        ]
    );
    assert_eq!(scene(&text).materials[0].diffuse, Rgb::grey(0.5));
    let files = Memory::new().with("bad.brdf", "begin brdf\n model wurd\nend brdf");
    let error = read(triangle("brdf \"bad.brdf\"").as_bytes(), "test.grf", &files);
    let message = error.map(|l| l.scene).unwrap_err().to_string();
    assert!(
        message.starts_with("bad.brdf:2:8: found the reflection model `wurd`"),
        "{message}"
    );
    assert!(message.ends_with("included from test.grf:1"), "{message}");
    let folder = Folder::new(concat!(env!("CARGO_MANIFEST_DIR"), "/src"));
    let outside = triangle("brdf \"../Cargo.toml\"");
    let loaded = read(outside.as_bytes(), "test.grf", &folder).unwrap();
    let message = loaded.warnings[0].to_string();
    assert!(
        message.contains("leads out of the model's folder"),
        "{message}"
    );
}

#[test]
fn hostile_models() {
    let check = |brdf: String, expected: &str| {
        let text = triangle(&format!("brdf {brdf}"));
        let error = read(text.as_bytes(), "test.grf", &Memory::new()).map(|l| l.scene);
        let message = error.unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    };
    check(format!("lewis {}", "n = 1 ".repeat(1_000_000)), "`n` again");
    let sum = format!("combination {}", "weight = 0 lewis n = 1 ".repeat(100_000));
    check(sum, "at most 64 models");
    check("lewis n = 1e999".to_owned(), "not so large");
    check("lewis n = nan".to_owned(), "one number");
    // Every face has a model of its own.
    let faces: String = (0..20_000)
        .map(|k| format!("brdf lewis n = {k} (0,1,2) "))
        .collect();
    let error = read(triangle(&faces).as_bytes(), "test.grf", &Memory::new());
    let message = error.map(|l| l.scene).unwrap_err().to_string();
    assert!(message.contains("at most 4096 distinct ones"), "{message}");
}
