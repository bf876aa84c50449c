//! Free-form statements, each in a small file with a surface known in closed form.

use crate::{Loaded, Memory, ReadOptions, obj};
use azulejo_scene::{Mesh, Shape};
use glam::DVec3;
use std::f64::consts::{FRAC_1_SQRT_2, PI};
use std::fmt::Write;

fn load(text: &str) -> Loaded {
    let loaded = obj::read(text.as_bytes(), "a.obj", &Memory::new());
    let loaded = loaded.unwrap_or_else(|e| panic!("{e}"));
    loaded.scene.validate().unwrap_or_else(|e| panic!("{e}"));
    loaded
}

fn meshes(loaded: &Loaded) -> Vec<&Mesh> {
    fn mesh(shape: &Shape) -> &Mesh {
        match shape {
            Shape::Mesh(mesh) => mesh,
            _ => panic!("OBJ has meshes only"),
        }
    }
    loaded
        .scene
        .objects
        .iter()
        .map(|o| mesh(&o.shape))
        .collect()
}

fn only_mesh(text: &str) -> Mesh {
    let loaded = load(text);
    assert_eq!(loaded.warnings, [], "{text}");
    assert_eq!(loaded.scene.objects.len(), 1, "{text}");
    meshes(&loaded)[0].clone()
}

fn check_warnings(text: &str, expected: &[&str]) {
    let loaded = load(text);
    let messages: Vec<&str> = loaded.warnings.iter().map(|w| w.message.as_str()).collect();
    assert_eq!(messages, expected, "{text}");
}

/// A square of the plane z = 0 from (0, 0) to (2, 2), bilinear, over parameters 0..=1.
const SQUARE: &str = "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 2 2 0\ncstype bezier\ndeg 1 1\n";
const SURFACE: &str = "surf 0 1 0 1 1 2 3 4\nparm u 0 1\nparm v 0 1\n";

/// Control points of the saddle z = xy − x over 0..=3 squared, cubic by quadratic, in the
/// order u first; `xs` and `ys` are their coordinates.
fn net(xs: &[f64], ys: &[f64]) -> String {
    let mut text = String::new();
    for y in ys {
        for x in xs {
            // z is linear in each: its control points are its values.
            let _ = writeln!(text, "v {x} {y} {}", x * y - x);
        }
    }
    text
}

fn list(count: usize) -> String {
    (1..=count).map(|k| format!(" {k}")).collect()
}

/// Checks that vertices and normals of a mesh are those of z = xy − x.
fn check_saddle(mesh: &Mesh, area: f64) {
    for (p, n) in mesh
        .positions
        .iter()
        .zip(&mesh.normals.as_ref().unwrap().values)
    {
        assert!((p.z - (p.x * p.y - p.x)).abs() < 1e-12, "{p}");
        let expected = DVec3::new(1.0 - p.y, -p.x, 1.0).normalize();
        assert!(
            n.abs_diff_eq(expected, 1e-9),
            "{n} at {p}, expected {expected}"
        );
    }
    assert!(
        (mesh.area() / area - 1.0).abs() < 2e-3,
        "{} of {area}",
        mesh.area()
    );
}

/// Area of z = xy − x over a square of side 3, by the midpoint rule.
fn saddle_area() -> f64 {
    let n = 300;
    let h = 3.0 / f64::from(n);
    let middle = |k: i32| h * (f64::from(k) + 0.5);
    let cell = |x: f64, y: f64| (1.0 + x * x + (y - 1.0) * (y - 1.0)).sqrt() * h * h;
    (0..n * n).map(|k| cell(middle(k % n), middle(k / n))).sum()
}

#[test]
fn one_surface_in_every_family() {
    let area = saddle_area();
    let even = |n: usize| -> Vec<f64> { (0..=n).map(|k| 3.0 * k as f64 / n as f64).collect() };
    let bezier = net(&even(3), &even(2))
        + "cstype bezier\ndeg 3 2\nsurf 0 1 0 1"
        + &list(12)
        + "\nparm u 0 1\nparm v 0 1\nend\n";
    check_saddle(&only_mesh(&bezier), area);
    let pieces = net(&even(6), &even(4))
        + "cstype bezier\ndeg 3 2\nsurf 0 2 5 7"
        + &list(35)
        + "\nparm u 0 1 2\nparm v 5 6 7\nend\n";
    check_saddle(&only_mesh(&pieces), area);
    // Control points of a straight line are the averages of knots (Greville).
    let spline = net(&[0.0, 0.5, 1.5, 2.5, 3.0], &[0.0, 1.5, 3.0])
        + "cstype bspline\ndeg 2 1\nsurf 0 3 0 3"
        + &list(15)
        + "\nparm u 0 0 0 1 2 3 3 3\nparm v 0 0 1.5 3 3\nend\n";
    check_saddle(&only_mesh(&spline), area);
    let cardinal = net(&[-1.0, 0.0, 1.0, 2.0, 3.0, 4.0], &[-3.0, 0.0, 3.0, 6.0])
        + "cstype cardinal\ndeg 3 3\nsurf 0 3 0 3"
        + &list(24)
        + "\nparm u 0 1 2 3\nparm v 0 3\nend\n";
    check_saddle(&only_mesh(&cardinal), area);
    // Coefficients: x = 3u, y = 3v, z = 9uv − 3u.
    let taylor = "v 0 0 0\nv 3 0 -3\nv 0 3 0\nv 0 0 9\ncstype taylor\ndeg 1 1\n\
                  surf 0 1 0 1 1 2 3 4\nparm u 0 1\nparm v 0 1\nend\n";
    check_saddle(&only_mesh(taylor), area);
    let matrix = net(&even(3), &even(2))
        + "cstype bmatrix\ndeg 3 2\nstep 3 2\n\
           bmat u 1 -3 3 -1 \\\n 0 3 -6 3 \\\n 0 0 3 -3 \\\n 0 0 0 1\n\
           bmat v 1 -2 1 0 2 -2 0 0 1\nsurf 0 1 0 1"
        + &list(12)
        + "\nparm u 0 1\nparm v 0 1\nend\n";
    check_saddle(&only_mesh(&matrix), area);
}

/// An octant of the unit sphere, with one edge collapsed to the pole.
fn octant() -> String {
    let w = FRAC_1_SQRT_2;
    format!(
        "v 1 0 0\nv 1 1 0 {w}\nv 0 1 0\nv 1 0 1 {w}\nv 1 1 1 0.5\nv 0 1 1 {w}\nv 0 0 1\n\
         v 0 0 1 {w}\ncstype rat bezier\ndeg 2 2\nsurf 0 1 0 1 1 2 3 4 5 6 7 8 7\n\
         parm u 0 1\nparm v 0 1\n"
    )
}

#[test]
fn rational_surfaces_are_round() {
    let mesh = only_mesh(&(octant() + "end\n"));
    for (p, n) in mesh
        .positions
        .iter()
        .zip(&mesh.normals.as_ref().unwrap().values)
    {
        assert!((p.length() - 1.0).abs() < 1e-12, "{p}");
        assert!(n.dot(*p) > 1.0 - 1e-5, "{n} at {p}");
    }
    for face in 0..mesh.faces.len() {
        let corners = mesh.face_positions(face);
        let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
        let deep = 1.0 - middle.length();
        assert!(deep < 2e-3 * 3f64.sqrt(), "{deep} at {middle}");
        assert!(mesh.face_area_vector(face).dot(middle) > 0.0);
    }
    assert!(
        (mesh.area() / (PI / 2.0) - 1.0).abs() < 5e-3,
        "{}",
        mesh.area()
    );
    // Without `rat` the weights have no effect.
    let plain = octant().replace("rat ", "");
    check_warnings(
        &(plain + "end\n"),
        &["vertex with a weight w: not used, weights apply only to rational surfaces"],
    );
}

#[test]
fn techniques_are_obeyed() {
    let faces = |technique: &str| {
        only_mesh(&format!("{technique}\n{}end\n", octant()))
            .faces
            .len()
    };
    assert_eq!(faces("stech cparma 2 3"), 4 * 6);
    assert_eq!(faces("stech cparmb 0"), 1);
    let by_length = faces("stech cspace 0.1");
    assert!((16 * 16..18 * 18).contains(&by_length), "{by_length}");
    let fine = faces("stech curv 0.0001 90");
    assert!(fine > 5 * faces("stech curv 0.001 90"), "{fine}");
    let angles = faces("stech curv 100 10");
    assert!((80..=100).contains(&angles), "{angles}");
    check_warnings(
        &format!("stech cspace 0\n{SQUARE}{SURFACE}end"),
        &["malformed \"stech\": skipped"],
    );
}

#[test]
fn texture_coordinates() {
    let parameters = only_mesh(&format!(
        "{SQUARE}surf 0.25 0.75 0 1 1 2 3 4\nparm u 0 1\nparm v 0 1\nend"
    ));
    let uvs = parameters.uvs.unwrap().values;
    assert_eq!(uvs[0].to_array(), [0.25, 0.0]);
    assert_eq!(parameters.positions[1].x, 1.5);
    let given = only_mesh(&format!(
        "{SQUARE}vt 0 0\nvt 5 0\nvt 0 5\nvt 5 6\nsurf 0 1 0 1 1/1 2/2 3/3 4/4\nparm u 0 1\nparm v 0 1\nend"
    ));
    assert_eq!(given.uvs.unwrap().values[3].to_array(), [5.0, 6.0]);
    check_warnings(
        &format!("{SQUARE}vn 0 0 1\nsurf 0 1 0 1 1//1 2 3 4\nparm u 0 1\nparm v 0 1\nend"),
        &["normals of control points: not used, those of the surface are computed"],
    );
}

/// A circle around (0.5, 0.5) in the parameter plane, a rational spline of four quarters.
fn circle(radius: f64) -> String {
    let mut text = String::new();
    let w = FRAC_1_SQRT_2;
    for (x, y, w) in [
        (1.0, 0.0, 1.0),
        (1.0, 1.0, w),
        (0.0, 1.0, 1.0),
        (-1.0, 1.0, w),
        (-1.0, 0.0, 1.0),
        (-1.0, -1.0, w),
        (0.0, -1.0, 1.0),
        (1.0, -1.0, w),
    ] {
        let (x, y): (f64, f64) = (x, y);
        let _ = writeln!(text, "vp {} {} {w}", 0.5 + radius * x, 0.5 + radius * y);
    }
    text + "cstype rat bezier\ndeg 2\ncurv2 1 2 3 4 5 6 7 8 1\nparm u 0 1 2 3 4\nend\n\
            cstype bezier\ndeg 1 1\n"
}

fn check_area(text: &str, expected: f64) {
    let mesh = only_mesh(text);
    let area = mesh.area();
    assert!(
        (area / expected - 1.0).abs() < 5e-3,
        "{area}, expected {expected}: {text}"
    );
    let up = |f: usize| mesh.face_area_vector(f).z >= 0.0;
    assert!((0..mesh.faces.len()).all(up), "{text}");
}

#[test]
fn trimming() {
    let circle = format!("{SQUARE}{}", circle(0.4));
    let hole = 4.0 * 0.16 * PI;
    check_area(&format!("{circle}{SURFACE}trim 0 4 1\nend"), hole);
    check_area(&format!("{circle}{SURFACE}trim 4 0 -1\nend"), hole);
    check_area(&format!("{circle}{SURFACE}hole 0 4 1\nend"), 4.0 - hole);
    check_area(&format!("{circle}{SURFACE}trim 0 2 1 2 4 1\nend"), hole);
    // Half of the circle: the chord closes it.
    check_area(&format!("{circle}{SURFACE}trim 0 2 1\nend"), hole / 2.0);
    // The outline that exporters write where nothing is trimmed.
    let outline = "vp 0 0\nvp 1 0\nvp 1 1\nvp 0 1\ncurv2 -4 -3 -2 -1 -4\nparm u 0 1 2 3 4\nend\n";
    check_area(&format!("{circle}{outline}{SURFACE}trim 0 4 2\nend"), 4.0);
    let both = format!("{circle}{outline}{SURFACE}trim 0 4 2\nhole 0 4 1\nend");
    check_area(&both, 4.0 - hole);
    check_area(&format!("stech cparmb 7\n{both}"), 4.0 - hole);
    check_warnings(
        &format!("{circle}{outline}{SURFACE}trim 0 4 2\ntrim 0 4 2\nend\nf 1 2 3"),
        &["free-form curve or surface with loops that cut all of it away: skipped"],
    );
}

#[test]
fn a_trimmed_dome_has_no_cracks() {
    let circle = circle(0.3).replace("cstype bezier\ndeg 1 1\n", "");
    let text = format!("{circle}{}hole 0 4 1\nend\n", octant());
    let mesh = only_mesh(&text);
    let mut edges = std::collections::HashMap::new();
    for face in mesh.faces.iter() {
        for k in 0..face.len() {
            let (a, b) = (face[k], face[(k + 1) % face.len()]);
            *edges.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
        }
    }
    // Edges of only one face lie on the rim or around the hole, nowhere else.
    let uvs = &mesh.uvs.as_ref().unwrap().values;
    let on_border = |v: u32| {
        let p = uvs[v as usize];
        let rim = p.x.min(p.y).min(1.0 - p.x).min(1.0 - p.y);
        rim.abs() < 1e-12 || (p.distance(glam::DVec2::splat(0.5)) - 0.3).abs() < 2e-3
    };
    for ((a, b), sum) in edges {
        assert!(
            sum == 0 || (on_border(a) && on_border(b)),
            "{} {}",
            uvs[a as usize],
            uvs[b as usize]
        );
    }
}

#[test]
fn surfaces_and_faces_in_one_file() {
    let text = format!(
        "{SQUARE}usemtl a\nf 1 2 4 3\no wing\ng tip\nusemtl b\n{SURFACE}end\nf 1 2 3\n{SURFACE}end\n\
         g root\n{SURFACE}end\n"
    );
    let loaded = load(&text);
    let names: Vec<&str> = loaded
        .scene
        .objects
        .iter()
        .map(|o| o.name.as_str())
        .collect();
    assert_eq!(names, ["", "wing/tip", "wing/tip", "wing/root"]);
    let sizes: Vec<usize> = meshes(&loaded).iter().map(|m| m.faces.len()).collect();
    assert_eq!(sizes, [1, 1, 2, 1]);
    let material = |object: usize| meshes(&loaded)[object].face_materials[0];
    assert_eq!((material(0), material(2)), (0, 1));
    let bare = load(&format!("{SQUARE}{SURFACE}end\n"));
    assert_eq!(bare.scene.materials[0].name, "default");
}

#[test]
fn old_patches() {
    let points: String = (0..16)
        .map(|k| format!("v {} {} {}\n", k % 4, 3 - k / 4, k % 3))
        .collect();
    let old = only_mesh(&format!("{points}bzp{}", list(16)));
    let new = only_mesh(&format!(
        "{points}cstype bezier\ndeg 3 3\nsurf 0 1 0 1 13 14 15 16 9 10 11 12 5 6 7 8 1 2 3 4\n\
         parm u 0 1\nparm v 0 1\nend"
    ));
    assert_eq!(old, new);
    assert!(only_mesh(&format!("{points}bsp{}", list(16))).faces.len() > 1);
    assert!(only_mesh(&format!("{points}cdp{}", list(16))).faces.len() > 1);
    check_warnings(
        &format!("{points}bzp 1 2 3\nf 1 2 3"),
        &["patch without exactly 16 control points: skipped"],
    );
}

#[test]
fn invalid_elements_are_reported() {
    let check = |changed: (&str, &str), expected: &str| {
        let text = format!("{SQUARE}f 1 2 3\n{SURFACE}end\n");
        assert!(text.contains(changed.0), "{}", changed.0);
        check_warnings(&text.replace(changed.0, changed.1), &[expected]);
    };
    let skipped = |why: &str| format!("free-form curve or surface with {why}: skipped");
    check(("cstype bezier\n", ""), &skipped("no cstype before it"));
    check(
        ("deg 1 1", "deg 99 1"),
        &skipped("degree 99, expected 1 to 30"),
    );
    check(("deg 1 1", "deg 1"), &skipped("degree 0, expected 1 to 30"));
    check(
        ("parm u 0 1", "parm u 1 0"),
        &skipped("parameter values (parm) that do not increase"),
    );
    check(
        ("parm u 0 1\n", ""),
        &skipped("0 parameter values (parm), expected 2 or more"),
    );
    check(
        ("parm u 0 1", "parm u 0 1 2"),
        &skipped("4 control points, expected 3 × 2"),
    );
    check(
        ("surf 0 1", "surf 3 4"),
        &skipped("a range outside its parameters"),
    );
    check(
        ("v 2 2 0", "v 2 1e300 0"),
        &skipped("points that are not finite"),
    );
    check(
        ("1\nend", "1\ntrim 0 1 1\nend"),
        &skipped("a loop with a trimming curve that does not exist"),
    );
    check(
        ("end\n", ""),
        "curve or surface without end at the end of the file: ended there",
    );
    check(
        ("deg 1 1", "deg 1 1\ndeg x"),
        "\"deg\" with a malformed or infinite number: skipped",
    );
    check(
        ("surf 0 1 0 1 1", "surf a 1"),
        "\"surf\" without four numbers for its range: skipped",
    );
    check(
        ("deg 1 1", "deg 1 1\nparm w 1"),
        "\"parm\" for neither u nor v: skipped",
    );
    check(
        ("deg 1 1", "deg 1 1\nend"),
        "\"end\" without a curve or surface: skipped",
    );
    check(
        ("deg 1 1", "deg 1 1\ntrim 0 1 1"),
        "\"trim or hole\" outside a curve or surface: skipped",
    );
    check(
        ("1\nend", "1\nscrv 0 1 1\nend"),
        "\"scrv\" does not change a surface, only how it is divided: skipped",
    );
    check(
        ("end\n", "end\ncon 1 0 1 1 1 0 1 1\n"),
        "con: surfaces are not joined, their edges may not meet exactly",
    );
    check(
        ("end\n", "end\ncurv 0 1 1 2\nparm u 0 1\nend\n"),
        "free-form curves (curv) have no surface: skipped",
    );
    check_warnings(
        &format!("{SQUARE}{SURFACE}f 1 2 3\n{SURFACE}end"),
        &["curve or surface without end before the next one: ended there"],
    );
    check_warnings(
        &format!("v 0 0 0 0\n{SQUARE}cstype rat bezier\n{SURFACE}end\nf 1 2 3"),
        &[&skipped("weights that are not positive")],
    );
    check_warnings(
        "cstype nurbs\nv 0 0 0\nf 1 1 1",
        &["unknown cstype \"nurbs\""],
    );
    check_warnings(
        &format!("{SQUARE}curv2 1 2\nparm u 0 1\nend\nf 1 2 3"),
        &[&skipped("0 control points, expected 2")],
    );
}

/// Each of these once took time in proportion to all of the file before it.
#[test]
fn many_malformed_statements_take_no_time() {
    let start = std::time::Instant::now();
    let text = "deg x\nstep 1e999\nsurf a\nend\nvp nan\n".repeat(20_000);
    check_warnings(
        &format!("{SQUARE}f 1 2 3\n{text}"),
        &[
            "\"deg\" with a malformed or infinite number: skipped",
            "\"step\" with a malformed or infinite number: skipped",
            "\"surf\" without four numbers for its range: skipped",
            "\"vp\" with a malformed or infinite number: skipped",
        ],
    );
    let options = "map_Kd -s 1 x a.png\nPc x\n".repeat(20_000);
    let mtl = format!("newmtl m\n{options}");
    let read = obj::read_materials(mtl.as_bytes(), "m.mtl", &Memory::new()).unwrap();
    assert_eq!(read.warnings.len(), 2);
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

#[test]
fn control_points_must_exist() {
    let text = format!("{SQUARE}surf 0 1 0 1 1 2 3 5");
    let error = obj::read(text.as_bytes(), "a.obj", &Memory::new()).unwrap_err();
    assert_eq!(
        error.to_string().lines().next().unwrap(),
        "a.obj:7:20: found vertex 5, expected 1 to 4, the number of vertices in the file"
    );
}

#[test]
fn small_files_cannot_fill_memory() {
    let text = format!(
        "stech cspace 1e-9\n{SQUARE}{}",
        format!("{SURFACE}end\n").repeat(50)
    );
    let options = ReadOptions {
        most_elements: 1_000_000,
        ..ReadOptions::default()
    };
    let error = obj::read_with(text.as_bytes(), "a.obj", &Memory::new(), &options).unwrap_err();
    assert!(
        error.to_string().contains("more than 1000000 vertices"),
        "{error}"
    );
}

#[test]
fn truncated_or_changed_anywhere() {
    let text = format!(
        "{SQUARE}{}{SURFACE}trim 0 4 1\nend\nstech cparma 2 1\n{}hole 0 4 -1\nend\n",
        circle(0.4),
        octant().replace("1 2 3 4 5 6 7 8 7", "5 6 7 8 9 10 11 12 11"),
    );
    assert_eq!(
        meshes(&load(&text))[0]
            .uvs
            .as_ref()
            .map(|uvs| uvs.corners.is_none()),
        Some(true)
    );
    let options = ReadOptions {
        most_elements: 10_000,
        ..ReadOptions::default()
    };
    let survive = |bytes: &[u8]| match obj::read_with(bytes, "a.obj", &Memory::new(), &options) {
        Ok(loaded) => loaded.scene.validate().unwrap_or_else(|e| panic!("{e}")),
        Err(e) => assert!(!e.to_string().is_empty()),
    };
    for end in 0..=text.len() {
        survive(&text.as_bytes()[..end]);
    }
    for value in b"\n-.e9" {
        for at in 0..text.len() {
            let mut changed = text.clone().into_bytes();
            changed[at] = *value;
            survive(&changed);
        }
    }
}
