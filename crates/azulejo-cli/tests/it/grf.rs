//! GRF files that people write: light in place, layout, findings, comparison, tables.

use crate::support::Folder;

const SCENE: &str = "// by hand\nparams begin view (0, 0, 1) end params\n\
    def white = rgb (.5, 0.50, 5e-1)\nbegin\n  include \"part.grf\"\n\
    begin mesh use color white\n\tbegin vertexs (0,0,0) (2,0,0) (2,2,0)   (0,2,0) end vertices // floor\n\
    begin faces (0,1,2,3) end faces end mesh\n  light begin rgb (9,9,9) (0,0,2) (0,1,0) (1,0,0) end light\nend def\n";
const PART: &str = "// a table\nbegin mesh begin vertices (0,0,1) (1,0,1) (0,1,1) end begin faces (0,1,2) end end\n";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("scene.grf", SCENE);
    folder.write("part.grf", PART);
    folder
}

fn text(folder: &Folder, name: &str) -> String {
    String::from_utf8(folder.read(name)).unwrap()
}

#[test]
fn light_goes_into_the_text_and_nothing_else_changes() {
    let folder = folder();
    let run = folder.ok("solve scene.grf --in-place --rays 64");
    assert!(run.err.contains("part.grf"), "{}", run.err);
    let once = text(&folder, "scene.grf");
    assert_eq!(text(&folder, "part.grf"), PART);
    let mut rest = once.clone();
    while let Some(start) = rest.find("irad (") {
        let end = start + rest[start..].find(')').unwrap() + 2;
        rest.replace_range(start..end, "");
    }
    let unfolded = format!(
        "// from here: include \"part.grf\"\n{}\n// to here: \"part.grf\"\n",
        PART.trim_end()
    );
    assert_eq!(rest, SCENE.replace("include \"part.grf\"", &unfolded));
    assert_eq!(once.matches("irad (").count(), 7);
    assert!(folder.json("info scene.grf")["solved"].as_bool().unwrap());
    // Again: the same places, the same size.
    folder.ok("solve scene.grf --in-place --rays 64 --seed 7 -q");
    let again = text(&folder, "scene.grf");
    assert_ne!(again, once);
    assert!(again.len().abs_diff(once.len()) < 60);
    // A copy beside it, with more digits; standard output.
    folder.ok("solve scene.grf --in-place -o copy.grf --digits 17 --rays 64 -q");
    assert!(text(&folder, "copy.grf").len() > again.len());
    assert!(
        folder
            .ok("solve scene.grf --in-place -o - --rays 64 -q")
            .out
            .starts_with("// by hand\n")
    );
    assert_eq!(text(&folder, "scene.grf"), again);
}

#[test]
fn what_cannot_be_in_place_is_refused() {
    let folder = folder();
    folder.write("tri.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.fails("solve tri.obj --in-place", 2, "not a GRF file");
    folder.fails("solve scene.grf part.grf --in-place", 2, "one scene");
    folder.fails("solve - --in-place", 2, "standard input");
    folder.fails("solve scene.grf --in-place --up z", 2, "--up");
    folder.fails("solve scene.grf --in-place --sides brighter", 2, "brighter");
    folder.fails("solve scene.grf", 2, "--output");
    std::fs::create_dir(folder.path("sub")).unwrap();
    folder.fails(
        "solve scene.grf --in-place -o sub/s.grf",
        2,
        "relative to its folder",
    );
    folder.ok("convert scene.grf -o packed.grf.gz");
    folder.fails("solve packed.grf.gz --in-place", 2, "gunzip");
    assert_eq!(text(&folder, "scene.grf"), SCENE);
}

#[test]
fn plain_grf_has_no_extensions_and_says_what_is_lost() {
    let folder = folder();
    let run = folder.ok("convert scene.grf --plain -o plain.grf");
    let plain = text(&folder, "plain.grf");
    assert!(!plain.contains("ext "), "{plain}");
    assert!(plain.contains("light begin rgb (9, 9, 9) (0, 0, 2) (0, 1, 0) (1, 0, 0) end light"));
    assert!(!run.err.contains("warning"), "{}", run.err);
    folder.ok("convert plain.grf -o with.grf --unit cm --up z");
    let run = folder.ok("convert with.grf --plain -o plain.grf");
    assert!(
        run.err.contains("does not keep everything: the unit"),
        "{}",
        run.err
    );
    folder.fails(
        "convert scene.grf --plain -o a.obj",
        2,
        "only GRF has a plain form",
    );
    folder.fails(
        "convert scene.grf --digits 6 -o a.glb",
        2,
        "numbers of fixed size",
    );
    folder.fails(
        "convert scene.grf --digits 2 -o a.grf",
        2,
        "2 is not in 4..=17",
    );
}

#[test]
fn layout_findings_and_differences() {
    let folder = folder();
    let run = folder.run("grf fmt --check scene.grf");
    assert_eq!((run.code, &*run.out), (Some(1), "differs  scene.grf\n"));
    assert_eq!(text(&folder, "scene.grf"), SCENE);
    folder.write("old.grf", SCENE);
    folder.ok("grf fmt scene.grf part.grf");
    assert!(text(&folder, "scene.grf").contains("\n      (2, 2, 0)\n"));
    assert_eq!(folder.ok("grf fmt --check scene.grf part.grf").out, "");
    assert_eq!(folder.ok("grf diff old.grf scene.grf").out, "");
    // A mistake in one file changes none.
    folder.write("bad.grf", "begin mesh");
    folder.write("odd.grf", " ; ");
    folder.fails("grf fmt odd.grf bad.grf", 1, "bad.grf:1:11");
    assert_eq!(text(&folder, "odd.grf"), " ; ");
    assert_eq!(folder.ok("grf lint scene.grf part.grf").out, "");
    folder.write("odd.grf", "def a = rgb (1, 1, 1)\n");
    let run = folder.run("grf lint odd.grf bad.grf");
    assert_eq!(run.code, Some(1));
    assert!(
        run.out.starts_with(
            "odd.grf:1:5: [unused-definition] the color `a` is not used\nbad.grf:1:11: [syntax]"
        ),
        "{}",
        run.out
    );
    folder.ok("grf lint odd.grf --skip unused-definition");
    folder.write(
        "moved.grf",
        SCENE
            .replace("(2,2,0)", "(2,2.5,0)")
            .replace("9,9,9", "8,8,8"),
    );
    let run = folder.run("grf diff old.grf moved.grf");
    assert_eq!(run.code, Some(1));
    assert!(
        run.out
            .contains("changed  object 2: vertices moved by up to 0.5"),
        "{}",
        run.out
    );
    folder.ok("grf diff old.grf old.grf --tolerance 1e-9");
    folder.fails("grf diff old.grf nothing.grf", 2, "nothing.grf");
}

#[test]
fn tables_of_models() {
    let folder = folder();
    let run = folder.ok("info --table scene.grf part.grf");
    let lines: Vec<&str> = run.out.lines().collect();
    assert!(lines[0].starts_with("model") && lines[0].ends_with("ratio"));
    assert_eq!(lines.len(), 3);
    let run = folder.ok("info --table --format csv part.grf");
    assert!(
        run.out
            .contains(&format!("\npart.grf,{},1,1,3,1,", PART.len())),
        "{}",
        run.out
    );
    let run = folder.ok("info --table --format markdown part.grf");
    assert!(run.out.contains("\n| --- | ---: |"), "{}", run.out);
    let value = folder.json("info --table scene.grf");
    assert_eq!(value["models"][0]["vertices"], 7);
    folder.fails("info --table scene.grf nothing.grf", 1, "nothing.grf");
    folder.fails("info --format csv scene.grf", 2, "--table");
}
