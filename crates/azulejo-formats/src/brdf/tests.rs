//! Tests of the text format.

use super::{read, text};
use crate::Memory;
use azulejo_scene::brdf::{Content, Description, MODELS};

fn description(file: &str) -> Description {
    let read = read(file.as_bytes(), "a.brdf", &Memory::new());
    match read.unwrap_or_else(|e| panic!("{file}: {e}")).content {
        Content::Text(description) => description,
        other => panic!("{other:?}"),
    }
}

fn check(file: &str, expected: &str) {
    assert_eq!(description(file).to_string(), expected, "{file}");
}

#[track_caller]
fn must_fail(file: &str, expected: &str) {
    let error = read(file.as_bytes(), "a.brdf", &Memory::new()).map(|r| r.content);
    let message = error.expect_err(file).to_string();
    assert!(message.contains(expected), "{file}: {message}");
}

fn written(description: &Description) -> String {
    let mut out = Vec::new();
    text::write(description, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

#[test]
fn statements_become_parameters() {
    check(
        "// A file.\nbegin brdf\n version 1\n model ward_gmd // Ward\n diffuse (0.1, 0.08, 0.05)\n\
         specular 0.5\n param ax 0.1\n param ay = 0.3\nend brdf\n",
        "ward_gmd kd = (0.1, 0.08, 0.05) ks = 0.5 ax = 0.1 ay = 0.3",
    );
    check(
        "begin brdf model cook_torrance param m 0.2 \
         fresnel conductor eta (0.16, 0.42, 1.56) k (3.5, 2.4, 1.9) end brdf",
        "cook_torrance m = 0.2 eta = (0.16, 0.42, 1.56) k = (3.5, 2.4, 1.9)",
    );
    check(
        "begin brdf model cook_torrance param m 0.2 fresnel metal gold end",
        "cook_torrance m = 0.2 metal = gold",
    );
    check(
        "lewis n = 20 ks = 0.5 // as in GRF",
        "lewis n = 20 ks = 0.5",
    );
    check(
        "begin brdf model layered begin brdf weight 0.5 model layered \
         begin brdf weight 0.5 model diffuse diffuse 1 end brdf \
         begin brdf model lewis param n 3 end brdf end brdf end brdf",
        "combination weight = 0.25 diffuse kd = 1 weight = 0.5 lewis n = 3",
    );
}

#[test]
fn what_a_model_does_not_use_is_said() {
    let file = "begin brdf\nmodel lewis param n 3\nfresnel dielectric eta 1.5\n\
                wavelengths (0.61, 0.55, 0.465)\nend brdf";
    let read = read(file.as_bytes(), "a.brdf", &Memory::new()).unwrap();
    let messages: Vec<String> = read.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        messages,
        [
            "a.brdf:3:9: `lewis` has no Fresnel term: ignored",
            "a.brdf:4:1: `lewis` has no wavelengths: ignored",
        ]
    );
}

#[test]
fn errors_have_their_place_and_the_nearest_name() {
    must_fail("begin brdf\n model warf\nend brdf", "a.brdf:2:8");
    must_fail(
        "begin brdf\n model warf\nend brdf",
        "nearest name is `ward`",
    );
    must_fail(
        "begin brdf\n model lewis\n param n 3\n param m 4\nend",
        "a.brdf:4:8",
    );
    must_fail(
        "begin brdf model lewis param n 3 specular 2 end",
        "between 0 and 1",
    );
    must_fail("begin brdf model lewis end brdf", "`lewis` without `n`");
    must_fail("begin brdf model lewis param n gold end", "one number");
    must_fail("begin brdf version 2 model lewis end", "the version 1");
    must_fail("begin brdf model lewis model ward end", "one `model`");
    must_fail("begin brdf end brdf", "a block without `model`");
    must_fail("begin brdf shine 3 end", "version, model");
    must_fail("begin brdf model lewis param n 1e999 end", "not so large");
    must_fail("begin brdf model lewis param n nan end", "one number");
    must_fail("begin brdf model lewis param n 3", "the end of the file");
    must_fail(
        "begin brdf model diffuse end brdf more",
        "the end of the file",
    );
    must_fail("begin brdf model layered diffuse 1 end", "`kd` of layers");
    must_fail("", "the name of a reflection model");
    let two = "begin brdf model diffuse diffuse 1 end brdf ".repeat(2);
    must_fail(&format!("begin brdf model layered {two} end"), "at most 1");
}

#[test]
fn measured_files_are_found_or_named() {
    let file = "begin brdf model measured \"gold.binary\" end brdf";
    let missing = read(file.as_bytes(), "a.brdf", &Memory::new()).unwrap();
    assert_eq!(
        missing.warnings[0].to_string(),
        "a.brdf:1:27: brdf \"gold.binary\" skipped: there is no such file"
    );
    // Found by fuzzing: an unquoted name may contain a quote, which could not be written.
    must_fail(
        "begin brdf model measured a\"b end brdf",
        "in double quotes",
    );
    let odd = Description::File {
        path: "a\"b".to_owned(),
        content: None,
    };
    assert!(text::write(&odd, &mut Vec::new()).is_err());
    // A file that refers to itself is not measured data.
    let files = Memory::new().with("gold.binary", file);
    let error = read(file.as_bytes(), "a.brdf", &files)
        .map(|r| r.content)
        .unwrap_err();
    assert!(error.to_string().contains("measured data"), "{error}");
}

#[test]
fn every_model_is_written_and_read_back() {
    for example in MODELS.iter().flat_map(|m| m.examples) {
        let parsed: Description = example.parse().unwrap();
        assert_eq!(description(&written(&parsed)), parsed, "{example}");
        assert_eq!(description(example), parsed, "{example}");
    }
    let sum: Description = "combination weight = 0.1 lewis n = 3 weight = 1e-7 diffuse kd = 1"
        .parse()
        .unwrap();
    assert_eq!(description(&written(&sum)), sum);
}

#[test]
fn hostile_files_end_soon() {
    let many = "param n 3\n".repeat(1_000_000);
    must_fail(
        &format!("begin brdf model lewis {many} end brdf"),
        "`n` again",
    );
    let deep = "begin brdf model layered ".repeat(100_000);
    must_fail(&deep, "at most 16 nested levels");
    let wide = "begin brdf model diffuse end brdf ".repeat(100_000);
    must_fail(
        &format!("begin brdf model layered {wide}"),
        "at most 64 layers",
    );
    let line = format!("lewis {}", "n = 3 ".repeat(1_000_000));
    must_fail(&line, "`n` again");
    let sum = format!("combination {}", "diffuse kd = 0 ".repeat(1_000_000));
    must_fail(&sum, "at most 64 models");
    must_fail(
        &format!("lewis n = {}", "9".repeat(1_000_000)),
        "not so large",
    );
    must_fail(
        &format!("lewis n = ({}", "1, ".repeat(1_000_000)),
        "a longer list",
    );
}
