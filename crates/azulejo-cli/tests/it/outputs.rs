//! Lightmaps in other forms: for viewers that know none, and in pictures of bright texels.

use super::support::{Folder, project};
use azulejo_formats::picture::{self, exr};
use azulejo_formats::{Memory, ReadOptions, gltf};
use azulejo_render::SecondPass;
use azulejo_scene::math::Ray;
use azulejo_scene::{Image, Rgb, Scene, WrapMode};
use azulejo_trace::{Progress, Tracer};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;
use std::fs;

/// A floor with a picture, a wall with colours of its vertices, and a lamp over both.
const ROOM: &str = "\
mtllib room.mtl
v 0 0 0
v 2 0 0
v 2 0 2
v 0 0 2
v 0 0 0 1 1 1
v 2 0 0 0.3 0.6 0.9
v 2 2 0 0.5 0.5 0.5
v 0 2 0 0.9 0.2 0.4
v 0.5 2.5 0.5
v 1.5 2.5 0.5
v 1.5 2.5 1.5
v 0.5 2.5 1.5
vt 0 0
vt 1 0
vt 1 1
vt 0 1
o floor
usemtl picture
f 1/1 4/4 3/3 2/2
o wall
usemtl plain
f 5 6 7 8
o lamp
usemtl lamp
f 9 10 11 12
";

const MATERIALS: &str = "\
newmtl picture
Kd 0.8 0.8 0.8
map_Kd picture.png
newmtl plain
Kd 0.7 0.4 0.1
newmtl lamp
Kd 0 0 0
Ke 30 30 30
";

/// `room.glb`, with the picture of four by four colours in it.
fn room() -> Folder {
    let folder = Folder::new();
    let mut bytes = Vec::new();
    let colors: Vec<u8> = (0..16u8)
        .flat_map(|k| [40 + 13 * k, 235 - 12 * k, 60 + 40 * (k % 4)])
        .collect();
    picture::png::write(4, 4, &colors, &mut bytes).unwrap();
    folder.write("picture.png", bytes);
    folder.write("room.obj", ROOM);
    folder.write("room.mtl", MATERIALS);
    folder.ok("convert room.obj -o room.glb");
    folder
}

fn scene_of(folder: &Folder, name: &str) -> Scene {
    let bytes = folder.read(name);
    let read = gltf::read(&bytes, name, &Memory::new(), &ReadOptions::default());
    read.unwrap().scene
}

/// A point of a surface that is not a lamp, and the radiance that was baked for it.
struct BakedPoint {
    position: DVec3,
    normal: DVec3,
    /// Texture coordinates and the colour of vertices of the file that was written.
    uv: DVec2,
    color: Rgb,
    material: usize,
    baked: Rgb,
}

/// Points of the faces: ρ of the file that was read, E of the EXR.
fn points(folder: &Folder, baked: &Scene) -> Vec<BakedPoint> {
    let given = scene_of(folder, "room.glb");
    let light: Image = picture::decode(&folder.read("e.exr")).unwrap();
    let mut points = Vec::new();
    for (object, before) in baked.objects.iter().zip(&given.objects) {
        let (placed, old) = (object.shape.placed_mesh(), before.shape.placed_mesh());
        let (placed, old) = (placed.unwrap(), old.unwrap());
        for face in 0..old.mesh.faces.len() {
            let of_old = &given.materials[old.mesh.face_materials[face] as usize];
            if of_old.is_emitter() {
                continue;
            }
            for weights in [
                [0.6, 0.2, 0.2],
                [0.2, 0.6, 0.2],
                [0.3, 0.2, 0.5],
                [0.34, 0.33, 0.33],
            ] {
                let corners = placed.mesh.faces.corner_range(face);
                let mean = |mesh: &azulejo_scene::Mesh| -> Option<DVec2> {
                    let uvs = mesh.uvs.as_ref()?;
                    let at = |c: usize| uvs.at(c, mesh.faces.corners[c]);
                    Some(corners.clone().zip(weights).map(|(c, w)| w * at(c)).sum())
                };
                let texture = |id: u32| given.textures.get(id as usize);
                let color = |mesh: &azulejo_scene::Mesh| -> Rgb {
                    let of = |c: usize| mesh.colors.get(mesh.faces.corners[c] as usize);
                    let colors = corners.clone().zip(weights);
                    let colors = colors.map(|(c, w)| of(c).copied().unwrap_or(Rgb::WHITE) * w);
                    colors.sum()
                };
                let reflectance = of_old.painted(color(old.mesh), mean(old.mesh), texture);
                let uv = mean(placed.mesh).unwrap();
                let e = light.sample_wrapped(uv, [WrapMode::Clamp; 2]);
                let positions = placed.face_positions(face);
                points.push(BakedPoint {
                    position: positions.iter().zip(weights).map(|(&p, w)| w * p).sum(),
                    normal: placed.face_area_vector(face).normalize(),
                    uv,
                    color: color(placed.mesh),
                    material: placed.mesh.face_materials[face] as usize,
                    baked: reflectance * Rgb::from(e.map(f64::from)) / PI,
                });
            }
        }
    }
    assert_eq!(points.len(), 16);
    points
}

/// Within the steps of 8 bits, and what differs between a texel and its middle.
fn check_near(found: &[Rgb], points: &[BakedPoint]) {
    let most = points
        .iter()
        .map(|p| p.baked.max_channel())
        .fold(0.0, f64::max);
    for (found, point) in found.iter().zip(points) {
        let off = (*found - point.baked).map(f64::abs).max_channel();
        assert!(off < 0.015 * most, "{found:?}, baked {:?}", point.baked);
        let share = (*found - point.baked).mean().abs() / point.baked.mean();
        assert!(share < 0.05, "{found:?}, baked {:?}", point.baked);
    }
}

/// What a file shows that needs no lightmap is ρE/π, with a picture of ρ and without.
#[test]
fn surfaces_shine_as_they_are_lit() {
    let folder = room();
    let options = "--size 96 --error 10% --lightmap e.exr";
    let report = folder.json(&format!(
        "bake room.glb -o shines.glb --as emissive {options}"
    ));
    assert!(report["exposure"].is_null());
    let scene = scene_of(&folder, "shines.glb");
    let points_of = points(&folder, &scene);
    let size = scene.bounds().diagonal();
    let ray = |p: &BakedPoint| Ray::new(p.position + 1e-4 * size * p.normal, -p.normal);
    let rays: Vec<Ray> = points_of.iter().map(ray).collect();
    let tracer = Tracer::new(&scene);
    let options_of_pass = SecondPass::default();
    let seen = azulejo_render::radiance(&scene, &tracer, &rays, &options_of_pass, &Progress::new());
    check_near(&seen.unwrap(), &points_of);
    folder.ok("bake shines.glb --strip -o again.glb");
    assert!(folder.read("again.glb") == folder.read("room.glb"));
    // Half as bright as what fits, and twice.
    let report = folder.json(&format!("bake room.glb -o flat.glb --as unlit {options}"));
    let exposure = report["exposure"].as_f64().unwrap();
    assert!(report["cut_share"].as_f64().unwrap() < 1e-3);
    let scene = scene_of(&folder, "flat.glb");
    let points_of = points(&folder, &scene);
    let shown = |p: &BakedPoint| {
        let material = &scene.materials[p.material];
        let texture = |id: u32| scene.textures.get(id as usize);
        material.painted(p.color, Some(p.uv), texture) / exposure
    };
    let shown: Vec<Rgb> = points_of.iter().map(shown).collect();
    check_near(&shown, &points_of);
    let image = scene.textures[0].image.as_ref().unwrap();
    let most = image.pixels.iter().flatten().copied().fold(0.0, f32::max);
    assert!(most > 0.9, "{most}");
    folder.ok("bake flat.glb --strip -o again.glb");
    assert!(folder.read("again.glb") == folder.read("room.glb"));
    let bright = folder.json(&format!(
        "bake room.glb -o bright.glb --as emissive --exposure {} --size 96 --error 10%",
        4.0 * exposure
    ));
    assert!(bright["cut_share"].as_f64().unwrap() > 0.1);
    assert!(
        bright["warnings"]
            .to_string()
            .contains("is brighter than white")
    );
    assert_eq!(
        bright["exposure"].as_f64().map(|e| (e / exposure).round()),
        Some(4.0)
    );
}

#[test]
fn forms_that_exclude_each_other() {
    let folder = room();
    for (line, said) in [
        ("--as moz,emissive", "would add up"),
        ("--as unlit --image hdr", "--image png"),
        ("--as mx --exposure 2", "--exposure is for"),
        ("--as unlit --exposure 0", "above 0"),
        ("--html --strip", "--strip"),
    ] {
        folder.fails(&format!("bake room.glb -o x.glb {line}"), 2, said);
    }
}

/// The Cornell box with bright texels, and irradiance in files of both precisions.
#[test]
fn bright_texels_are_within_their_steps() {
    let folder = Folder::new();
    let scene = fs::read(project().join("examples/cornell.grf")).unwrap();
    folder.write("box.grf", scene);
    folder.ok("convert box.grf -o box.glb");
    let options = "--size 48 --error 20%";
    for (image, step) in [
        ("ktx2", 1.0f32 / 512.0),
        ("ktx2-half", 1.0 / 2048.0),
        ("hdr", 1.0 / 256.0),
    ] {
        let run = folder.ok(&format!(
            "bake box.glb -o bright.glb --image {image} {options} --lightmap e.exr --float"
        ));
        assert_eq!(
            run.err.contains("KHR_texture_basisu"),
            image != "hdr",
            "{}",
            run.err
        );
        let report = folder.json("bake bright.glb --check --lightmap e.exr");
        let tests = report["tests"].as_array().unwrap();
        let error = tests.iter().find(|t| t["test"] == "picture_error").unwrap();
        let error = error["value"].as_f64().unwrap();
        assert!(
            error > 0.0 && error < 2.0 * f64::from(step),
            "{image}: {error}"
        );
        // What is shown is the bright picture, too.
        let scene = scene_of(&folder, "bright.glb");
        assert!(scene.has_lightmap());
        let lightmap = scene.materials.iter().find_map(|m| m.lightmap).unwrap();
        let shown = scene.textures[lightmap.texture as usize]
            .image
            .as_ref()
            .unwrap();
        let baked = exr::read(&folder.read("e.exr")).unwrap();
        for (a, b) in shown.pixels.iter().zip(&baked.pixels) {
            let most = b.iter().copied().fold(0.0, f32::max);
            for k in 0..3 {
                let off = (a[k] * lightmap.scale as f32 - b[k]).abs();
                assert!(off <= 1.001 * step * most + 1e-6, "{image}: {a:?}, {b:?}");
            }
        }
        folder.ok("bake bright.glb --strip -o again.glb");
        assert!(
            folder.read("again.glb") == folder.read("box.glb"),
            "{image}"
        );
    }
    let whole = folder.read("e.exr");
    let run = folder.ok(&format!(
        "bake box.glb -o plain.glb --as plain {options} --lightmap e.exr"
    ));
    assert!(!run.err.contains("floats of 32 bits"), "{}", run.err);
    let half = folder.read("e.exr");
    assert!(
        2 * half.len() < 3 * whole.len(),
        "{} of {}",
        half.len(),
        whole.len()
    );
    let (half, whole) = (exr::read(&half).unwrap(), exr::read(&whole).unwrap());
    for (a, b) in half
        .pixels
        .iter()
        .flatten()
        .zip(whole.pixels.iter().flatten())
    {
        assert!((a - b).abs() <= b / 2047.0 + 3e-8, "{a}, {b}");
    }
}

/// Models of other formats get matt surfaces that mirror nothing in any viewer, and are read as matt.
#[test]
fn matt_surfaces_say_so() {
    let folder = Folder::with_room();
    folder.ok("bake room.obj -o room.glb --as plain --size 32 --error 30%");
    let glb = folder.read("room.glb");
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let json: serde_json::Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    for material in json["materials"].as_array().unwrap() {
        let specular = &material["extensions"]["KHR_materials_specular"];
        assert_eq!(specular["specularFactor"], 0, "{material}");
    }
    let scene = scene_of(&folder, "room.glb");
    assert!(
        scene
            .materials
            .iter()
            .all(|m| m.brdf.is_none() && m.mirror.is_black())
    );
}

/// A page is one whatever its name is.
#[test]
fn a_page_of_any_name() {
    let folder = Folder::with_room();
    folder.ok("bake room.obj -o page.txt --html --size 32 --error 30%");
    assert!(folder.read("page.txt").starts_with(b"<!doctype html>"));
    let run = folder.ok("bake room.obj -o - --html --size 32 --error 30%");
    assert!(run.out.starts_with("<!doctype html>"));
}

/// The light of a glTF file that keeps its mesh goes into the file itself, and out again.
#[test]
fn light_on_the_vertices_of_the_file_itself() {
    let folder = Folder::with_room();
    for (file, lit, beside) in [
        ("room.glb", "lit.glb", None),
        ("room.gltf", "lit.gltf", Some("lit.light.bin")),
    ] {
        folder.ok(&format!("convert room.obj -o {file}"));
        let report = folder.json(&format!("solve {file} -o {lit} --keep-mesh --error 3%"));
        assert_eq!(report["output"], lit);
        let names = folder.names();
        assert!(beside.is_none_or(|name| names.contains(&name.to_owned())));
        assert_eq!(folder.json(&format!("info {lit}"))["solved"], true);
        let stripped = folder.json(&format!("bake {lit} --strip -o again"));
        assert_eq!(stripped["exact"], true);
        // Blanks of JSON as text may differ, nothing else.
        let without_blanks = |name: &str| {
            let mut bytes = folder.read(name);
            if beside.is_some() {
                bytes.retain(|byte| !byte.is_ascii_whitespace());
            }
            bytes
        };
        assert!(without_blanks("again") == without_blanks(file), "{file}");
    }
    // The same light as in a file that is written anew.
    folder.ok("solve room.obj -o anew.glb --keep-mesh --sides front --error 3%");
    let light = |name: &str| {
        let scene = scene_of(&folder, name);
        let mut light = Vec::new();
        for placed in scene.objects.iter().filter_map(|o| o.shape.placed_mesh()) {
            for face in placed.mesh.faces.iter() {
                for &v in face {
                    let at = placed.position(v).to_array().map(|x| (1000.0 * x) as i64);
                    light.push((at, placed.irradiance[v as usize].mean()));
                }
            }
        }
        light.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        light
    };
    let (kept, anew) = (light("lit.glb"), light("anew.glb"));
    assert_eq!(kept.len(), anew.len());
    let mean = |list: &[([i64; 3], f64)]| list.iter().map(|l| l.1).sum::<f64>() / list.len() as f64;
    let (kept, anew) = (mean(&kept), mean(&anew));
    assert!((kept / anew - 1.0).abs() < 0.02, "{kept}, {anew}");
    // Light that is computed again takes the place of the other.
    let before = folder.read("lit.glb");
    let run = folder.ok("solve lit.glb -o lit.glb --keep-mesh --error 3%");
    assert!(
        run.err.contains("has put on its vertices is removed first"),
        "{}",
        run.err
    );
    assert!(folder.read("lit.glb") == before);
    // What changes more than light is written anew.
    let run = folder.ok("solve room.glb -o other.glb --keep-mesh --sides split --error 10%");
    assert!(
        run.err.contains("--sides split changes more than light"),
        "{}",
        run.err
    );
    folder.fails(
        "bake other.glb --strip -o again",
        1,
        "nor its light on vertices",
    );
    // So is a file whose walls look away from the light.
    let room = String::from_utf8(folder.read("room.obj")).unwrap();
    let turned = room.lines().map(|line| match line.strip_prefix("f ") {
        Some(face) if !face.starts_with('9') => {
            let corners: Vec<&str> = face.split(' ').rev().collect();
            format!("f {}\n", corners.join(" "))
        }
        _ => format!("{line}\n"),
    });
    folder.write("turned.obj", turned.collect::<String>());
    folder.ok("convert turned.obj -o turned.glb");
    // The room behind its walls is so dark that no error is within reach.
    let line = "solve turned.glb -o other.glb --keep-mesh --patches 100 --rays 16";
    let run = folder.ok(line);
    assert!(run.err.contains("some faces are turned"), "{}", run.err);
    let run = folder.ok(&format!("{line} --sides front"));
    assert!(!run.err.contains("turned"), "{}", run.err);
    // A lightmap takes the place of it.
    let run = folder.ok("bake lit.glb -o baked.glb --size 32 --error 30%");
    assert!(
        run.err.contains("has put on its vertices is removed first"),
        "{}",
        run.err
    );
    folder.ok("bake baked.glb --strip -o again");
    assert!(folder.read("again") == folder.read("room.glb"));
}
