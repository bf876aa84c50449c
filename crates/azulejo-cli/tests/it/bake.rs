//! `bake`: lightmaps from the command line.

use super::support::Folder;
use serde_json::Value;
use std::fs;

/// The JSON of a GLB.
fn json(glb: &[u8]) -> Value {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&glb[20..20 + length]).unwrap()
}

#[test]
fn a_legacy_model_gets_a_lightmap() {
    let folder = Folder::with_room();
    let run = folder
        .ok("bake room.obj -o room.glb --size 64 --error 10% --lightmap e.exr --error-map se.exr");
    assert!(run.err.contains("estimated error"), "{}", run.err);
    assert!(run.err.contains("10% requested"), "{}", run.err);
    let file = json(&folder.read("room.glb"));
    assert!(
        file["extensionsUsed"]
            .as_array()
            .unwrap()
            .contains(&"MOZ_lightmap".into())
    );
    let materials = file["materials"].as_array().unwrap();
    let lightmap = &materials[0]["extensions"]["MOZ_lightmap"];
    assert_eq!(lightmap["texCoord"], 1);
    assert!(lightmap["intensity"].as_f64().unwrap() > 0.0);
    let primitives = file["meshes"][0]["primitives"].as_array().unwrap();
    assert!(
        primitives
            .iter()
            .all(|p| p["attributes"]["TEXCOORD_1"].is_u64())
    );
    assert!(folder.read("e.exr").starts_with(&[0x76, 0x2f, 0x31, 0x01]));
    assert_eq!(
        folder.names(),
        ["e.exr", "room.glb", "room.mtl", "room.obj", "se.exr"]
    );
}

/// Models without lamps have it, too.
#[test]
fn ambient_occlusion_needs_no_light() {
    let folder = Folder::new();
    let corner =
        "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 0 0 2\nv 2 0 2\no corner\nf 1 2 3 4\nf 1 5 6 2\n";
    folder.write("corner.obj", corner);
    let run =
        folder.ok("bake corner.obj -o ao.glb --size 64 --light ao --error 5% --lightmap ao.exr");
    assert!(run.err.contains("of the hemisphere is free"), "{}", run.err);
    let file = json(&folder.read("ao.glb"));
    let material = &file["materials"][0];
    assert_eq!(material["occlusionTexture"]["texCoord"], 1);
    assert!(!material.to_string().contains("MOZ_lightmap"));
    assert!(folder.read("ao.exr").starts_with(&[0x76, 0x2f, 0x31, 0x01]));
}

/// A file with a lightmap is what it was, byte for byte, once that is removed.
#[test]
fn what_was_baked_can_be_stripped() {
    let folder = Folder::with_room();
    folder.ok("convert room.obj -o room.glb");
    let before = folder.read("room.glb");
    folder.ok("bake room.glb -o baked.glb --size 64 --error 20%");
    assert!(folder.read("baked.glb").len() > before.len());
    let report = folder.json("bake baked.glb --strip -o again.glb");
    assert_eq!(report["exact"], true);
    assert!(folder.read("again.glb") == before);
    let misnamed = folder.run("bake baked.glb --strip -o again.gltf");
    assert!(misnamed.err.contains("is a .glb"), "{}", misnamed.err);
    let refused = folder.run("bake room.glb --strip -o again.glb");
    assert_eq!(refused.code, Some(1));
    assert!(folder.read("again.glb") == before);
}

#[test]
fn a_page_is_one_file() {
    let folder = Folder::with_room();
    folder.ok("bake room.obj -o page.html --size 64 --error 20%");
    let page = String::from_utf8(folder.read("page.html")).unwrap();
    assert!(page.starts_with("<!doctype html>"));
    assert!(!page.contains("http://") && !page.contains("https://"));
    assert_eq!(folder.names(), ["page.html", "room.mtl", "room.obj"]);
}

#[test]
fn a_gltf_file_gets_pictures_beside_it() {
    let folder = Folder::with_room();
    folder.ok("convert room.obj -o room.gltf");
    let before = folder.names();
    folder.ok("bake room.gltf -o baked.gltf --size 64 --error 20%");
    let file: Value = serde_json::from_slice(&folder.read("baked.gltf")).unwrap();
    let added: Vec<String> = folder
        .names()
        .into_iter()
        .filter(|name| !before.contains(name) && name != "baked.gltf")
        .collect();
    let named = |list: &str| -> Vec<String> {
        let entries = file[list].as_array().unwrap().iter();
        entries
            .filter_map(|e| Some(e["uri"].as_str()?.to_owned()))
            .collect()
    };
    let used = [named("buffers"), named("images")].concat();
    assert!(
        !added.is_empty() && added.iter().all(|name| used.contains(name)),
        "{added:?}, {used:?}"
    );
}

#[test]
fn a_deadline_is_kept_and_said() {
    let folder = Folder::with_room();
    let run = folder.run("bake room.obj --lightmap e.exr --size 256 --error 0.05% --time 0.01s");
    assert_eq!(run.code, Some(0), "{}", run.err);
    assert!(
        run.err.contains("there was no time for more"),
        "{}",
        run.err
    );
}

#[test]
fn what_cannot_be_baked_is_said() {
    let folder = Folder::with_room();
    folder.write("empty.obj", "o nothing\n");
    let all = folder.names();
    for (line, code, said) in [
        ("bake room.obj -o room.obj", 2, ".glb, .gltf or .html"),
        ("bake room.obj -o room.glb --size 0", 2, "--size"),
        ("bake room.obj -o room.glb --size 100000", 2, "--size"),
        ("bake room.obj -o room.glb --size 4", 1, "expected 5"),
        (
            "bake room.obj -o room.glb --keep-mesh",
            2,
            "a lightmap has texels",
        ),
        ("bake room.obj -o missing/room.glb", 1, "missing"),
        ("bake room.obj --lightmap e.png", 2, ".exr"),
        (
            "bake room.obj -o room.glb --light ao --as moz",
            2,
            "a share, not light",
        ),
        ("bake room.obj -o room.glb --as occlusion", 2, "--light ao"),
        ("bake room.obj -o room.glb --ao-distance 2", 2, "--light ao"),
        ("bake room.obj -o page.html --light ao", 2, "shows light"),
        ("bake empty.obj -o room.glb --sky 1", 1, ""),
        (
            "bake room.obj -o room.glb --texels-per-metre 1e9",
            1,
            "too large",
        ),
        (
            "bake room.obj -o room.glb --size 256 --memory 1MiB",
            1,
            "permit more memory",
        ),
    ] {
        let run = folder.run(line);
        assert_eq!(run.code, Some(code), "{line}\n{}", run.err);
        assert!(run.err.contains(said), "{line}\n{}", run.err);
        assert_eq!(folder.names(), all, "{line}");
    }
    fs::remove_file(folder.path("empty.obj")).unwrap();
}

#[test]
fn pages_and_parts_of_the_light_are_chosen() {
    let folder = Folder::with_room();
    let report =
        folder.json("bake room.obj -o room.glb --size 64 --pages 2 --error 20% --light indirect");
    assert_eq!(report["texels"].as_u64().map(|n| n > 100), Some(true));
    let file = json(&folder.read("room.glb"));
    let pages = file["images"].as_array().unwrap().len();
    assert!(pages >= 1, "{pages}");
    let plain = folder.run("bake room.obj -o plain.glb --as plain --size 64 --error 20%");
    assert_eq!(plain.code, Some(0), "{}", plain.err);
    let file = json(&folder.read("plain.glb"));
    assert!(file["images"].is_null());
}

/// What was baked passes all tests; a mesh whose faces all have the same coordinates does not.
#[test]
fn lightmaps_are_checked() {
    let folder = Folder::with_room();
    folder.ok("bake room.obj -o room.glb --size 128 --error 20% --lightmap e.exr");
    let before = folder.names();
    let report = folder.json("bake room.glb --check --lightmap e.exr");
    assert_eq!(report["ok"], true);
    let value = |key: &str| {
        let tests = report["tests"].as_array().unwrap();
        let test = tests.iter().find(|t| t["test"] == key);
        test.and_then(|t| t["value"].as_f64()).unwrap()
    };
    assert_eq!(value("overlaps"), 0.0);
    let error = value("picture_error");
    assert!(error > 0.0 && error < 0.02, "{error}");
    assert_eq!(folder.names(), before, "nothing is written");
    let small = folder.run("bake room.glb --check --size 64 --lightmap e.exr");
    assert_eq!(small.code, Some(1));
    assert!(
        small.err.contains("no picture of this size"),
        "{}",
        small.err
    );
    // Pictures go on beyond the wall, and over one another.
    let textured = "mtllib room.mtl\nv 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 1 0\nv 1 1 0\n\
        vt 0 0\nvt 3 0\nvt 3 3\nvt 0 3\no floor\nf 1/1 2/2 3/3 4/4\nf 1/1 2/2 6/3 5/4\n";
    folder.write("tiles.obj", textured);
    folder.ok("convert tiles.obj -o tiles.glb");
    let tiles = folder.run("bake tiles.glb --check --uv-set 0");
    assert_eq!(tiles.code, Some(1), "{}", tiles.err);
    for said in ["overlapping triangles", "DEFECT", "\"floor\", triangle"] {
        assert!(tiles.out.contains(said), "{}", tiles.out);
    }
    for (line, code, said) in [
        (
            "bake tiles.glb --check",
            1,
            "no object has texture coordinates",
        ),
        ("bake room.obj --check", 1, "room.obj"),
        ("bake room.glb --check -o x.glb", 2, "--output"),
        ("bake room.glb room.glb --check", 2, "one glTF file"),
    ] {
        let run = folder.run(line);
        assert_eq!(run.code, Some(code), "{line}\n{}", run.err);
        assert!(run.err.contains(said), "{line}\n{}", run.err);
    }
}

/// A GLB with other JSON: what another program might have written.
fn rewritten(glb: &[u8], change: impl Fn(&mut Value)) -> Vec<u8> {
    let mut json = json(glb);
    json["asset"].as_object_mut().unwrap().remove("extras");
    change(&mut json);
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let bin = &glb[20 + length..];
    let total = (20 + text.len() + bin.len()) as u32;
    let mut file = glb[..8].to_vec();
    file.extend(total.to_le_bytes());
    file.extend((text.len() as u32).to_le_bytes());
    file.extend(&glb[16..20]);
    file.extend(text);
    file.extend(bin);
    file
}

/// Coordinates that are fit stay, those that are not are made anew, and it is said why.
#[test]
fn coordinates_of_files_are_kept() {
    let folder = Folder::with_room();
    folder.ok("bake room.obj -o plain.glb --as plain --size 128 --patches 100 --error 30%");
    let given = rewritten(&folder.read("plain.glb"), |_| {});
    folder.write("given.glb", &given);
    let run =
        folder.ok("bake given.glb -o kept.glb --size 128 --patches 100 --error 30% --uv keep");
    assert!(run.err.contains("TEXCOORD_1 are kept"), "{}", run.err);
    let (before, after) = (json(&given), json(&folder.read("kept.glb")));
    assert_eq!(before["accessors"], after["accessors"]);
    let attributes = |file: &Value| file["meshes"][0]["primitives"][0]["attributes"].clone();
    assert_eq!(attributes(&before), attributes(&after));
    assert_eq!(
        after["materials"][0]["extensions"]["MOZ_lightmap"]["texCoord"],
        1
    );
    assert_eq!(folder.json("bake kept.glb --check")["ok"], true);
    folder.ok("bake kept.glb --strip -o again.glb");
    assert!(folder.read("again.glb") == given);
    // At this size charts are too near one another.
    let coarse =
        folder.run("bake given.glb -o coarse.glb --size 32 --patches 100 --error 30% --uv keep");
    assert_eq!(coarse.code, Some(1));
    assert!(coarse.err.contains("charts near others"), "{}", coarse.err);
    // All objects have the coordinates of the first.
    let wall = json(&given)["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"].clone();
    folder.write(
        "twice.glb",
        rewritten(&given, |file| {
            let copy = file["nodes"][0].clone();
            let nodes = file["nodes"].as_array_mut().unwrap();
            nodes.push(copy);
            nodes.last_mut().unwrap()["translation"] = serde_json::json!([50.0, 0.0, 0.0]);
            let number = nodes.len() - 1;
            file["scenes"][0]["nodes"]
                .as_array_mut()
                .unwrap()
                .push(number.into());
        }),
    );
    assert!(wall.is_u64());
    let run = folder.ok("bake twice.glb -o repacked.glb --size 128 --patches 100 --error 30%");
    assert!(run.err.contains("overlapping triangles"), "{}", run.err);
    assert!(run.err.contains("are repacked"), "{}", run.err);
    assert_eq!(folder.json("bake repacked.glb --check")["ok"], true);
    let run = folder.ok("bake twice.glb -o new.glb --size 128 --patches 100 --error 30% --uv new");
    assert!(!run.err.contains("TEXCOORD_1"), "{}", run.err);
    for (line, said) in [
        ("bake room.obj -o x.glb --uv keep", "only a glTF file"),
        (
            "bake given.glb -o x.glb --uv keep --uv-set 2",
            "no TEXCOORD_2",
        ),
        ("bake given.glb -o x.glb --uv keep --pages 2", "on one page"),
        (
            "bake twice.glb -o x.glb --uv keep --size 128",
            "overlapping",
        ),
    ] {
        let run = folder.run(line);
        assert_eq!(run.code, Some(1), "{line}\n{}", run.err);
        assert!(run.err.contains(said), "{line}\n{}", run.err);
    }
}

#[test]
fn objects_are_denser_than_others() {
    let folder = Folder::with_room();
    let density = |more: &str| {
        let line = format!("bake room.obj -o room.glb --texels-per-metre 20 --error 30% {more}");
        let run = folder.run(&format!("{line} --json"));
        let report: Value = serde_json::from_str(&run.out).unwrap();
        (
            report["texels_per_metre"].as_f64().unwrap(),
            report["warnings"].to_string(),
        )
    };
    let usual = density("").0;
    assert!((usual - 20.0).abs() < 1.0, "{usual}");
    // The last that fits counts.
    let (sparse, _) = density("--density *=2 --density wal?s=0.25");
    assert!(sparse > 4.9 && sparse < 7.0, "{sparse}");
    assert!(
        density("--density none*=2")
            .1
            .contains("no object has such a name")
    );
    for wrong in ["walls", "walls=0", "walls=x", "[=2", "walls=1e9"] {
        let run = folder.run(&format!("bake room.obj -o x.glb --density {wrong}"));
        assert_eq!(run.code, Some(2), "{wrong}\n{}", run.err);
    }
}

/// A lamp below a sheet whose corners are in the order that makes its upper side the front.
#[test]
fn sides_without_a_front_are_baked() {
    let folder = Folder::new();
    folder.write(
        "sheet.mtl",
        "newmtl white\nKd 0.7 0.7 0.7\nnewmtl lamp\nKd 0 0 0\nKe 9 9 9\n",
    );
    folder.write(
        "sheet.obj",
        "mtllib sheet.mtl\nv 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 0 0 -1\nv 1 0 -1\nv 1 1 -1\nv 0 1 -1\n\
         o sheet\nusemtl white\nf 1 2 3 4\no lamp\nusemtl lamp\nf 5 6 7 8\n",
    );
    let bake = |more: &str| {
        folder.ok(&format!(
            "bake sheet.obj -o lit.glb --size 32 --error 10% {more}"
        ));
        json(&folder.read("lit.glb"))
    };
    let meshes = |file: &Value| file["meshes"].as_array().map_or(0, Vec::len);
    let one = bake("");
    let both = bake("--double-sided split");
    assert!(meshes(&both) > meshes(&one), "{both}");
    let materials = both["materials"].as_array().unwrap();
    let mut baked = materials
        .iter()
        .filter(|m| !m["extensions"]["MOZ_lightmap"].is_null());
    assert!(baked.all(|m| m["doubleSided"] != true), "{materials:?}");
    folder.ok("convert sheet.obj -o sheet.glb");
    let run = folder.ok("bake sheet.glb -o lit.glb --size 32 --error 10% --double-sided split");
    assert!(run.err.contains("rewritten"), "{}", run.err);
}
