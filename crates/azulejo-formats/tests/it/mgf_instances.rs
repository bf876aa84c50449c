//! Arrays and includes of MGF as instances: the same scenes as from files that repeat everything in their
//! text.

use azulejo_formats::{Files, Folder, Memory, ReadOptions, mgf};
use azulejo_scene::{Mesh, Scene, Shape};
use azulejo_testing::data;
use glam::DVec3;
use std::fmt::Write;

fn read(text: &str, files: &dyn Files) -> Scene {
    let loaded = mgf::read(text.as_bytes(), "main.mgf", files, &ReadOptions::default());
    let scene = loaded.expect("a scene").scene;
    scene.validate().expect("a valid scene");
    scene
}

/// Writes out what arrays and includes repeat.
struct Unroller<'a> {
    files: &'a dyn Files,
    out: String,
}

impl Unroller<'_> {
    fn unrolled(text: &str, files: &dyn Files) -> String {
        let mut unroller = Unroller {
            files,
            out: String::new(),
        };
        unroller.statements(&statements(text));
        unroller.out
    }

    fn statements(&mut self, statements: &[String]) {
        let mut rest = statements;
        while let [first, after @ ..] = rest {
            let words: Vec<&str> = first.split_whitespace().collect();
            match words[..] {
                ["xf", ref options @ ..] if options.contains(&"-a") => {
                    let end = end_of_transform(after);
                    self.instances(options, &after[..end]);
                    rest = &after[end + 1..];
                }
                ["i", file, ref options @ ..] => {
                    // A missing file is skipped in both readings.
                    if let Ok(bytes) = self.files.read(file) {
                        let text = String::from_utf8_lossy(&bytes).into_owned();
                        self.instances(options, &statements_closed(&text));
                    }
                    rest = after;
                }
                _ => {
                    self.line(first);
                    rest = after;
                }
            }
        }
    }

    /// The content once for each instance: `-a n` becomes `-i k`.
    fn instances(&mut self, options: &[&str], content: &[String]) {
        let counts = options.windows(2).filter(|pair| pair[0] == "-a");
        let counts: Vec<usize> = counts.map(|pair| pair[1].parse().unwrap()).collect();
        for instance in 0..counts.iter().product() {
            let mut left = instance;
            let mut places: Vec<usize> = counts
                .iter()
                .rev()
                .map(|count| {
                    let place = left % count;
                    left /= count;
                    place
                })
                .collect();
            places.reverse();
            let mut next = places.iter();
            let mut words: Vec<String> = options.iter().map(ToString::to_string).collect();
            for k in (0..words.len()).filter(|&k| options[k] == "-a") {
                words[k] = "-i".into();
                words[k + 1] = next.next().unwrap().to_string();
            }
            let map = if words.is_empty() {
                "-t 0 0 0".to_owned()
            } else {
                words.join(" ")
            };
            self.line(&format!("xf {map}"));
            let names: Vec<String> = places.iter().map(ToString::to_string).collect();
            if !names.is_empty() {
                self.line(&format!("o a{}", names.join(".")));
            }
            self.statements(content);
            if !names.is_empty() {
                self.line("o");
            }
            self.line("xf");
        }
    }

    fn line(&mut self, line: &str) {
        writeln!(self.out, "{line}").unwrap();
    }
}

/// The statements of a text, without comments, each on one line.
fn statements(text: &str) -> Vec<String> {
    let text = text.replace("\\\r\n", " ").replace("\\\n", " ");
    let lines = text.lines();
    let lines = lines.map(|l| l.split('#').next().unwrap().trim().to_owned());
    lines.filter(|l| !l.is_empty()).collect()
}

/// Like [`statements`], with the ends of what is open at the end of a file.
fn statements_closed(text: &str) -> Vec<String> {
    let mut list = statements(text);
    let mut open = Vec::new();
    for statement in &list {
        match statement.split_once(char::is_whitespace) {
            Some((word @ ("o" | "xf"), _)) => open.push(word.to_owned()),
            None if statement == "o" || statement == "xf" => drop(open.pop()),
            _ => {}
        }
    }
    list.extend(open.into_iter().rev());
    list
}

/// The index of the `xf` that ends a transform whose content comes first.
fn end_of_transform(statements: &[String]) -> usize {
    let mut depth = 1;
    let end = statements.iter().position(|statement| {
        match statement.split_once(char::is_whitespace) {
            Some(("xf", _)) => depth += 1,
            None if statement == "xf" => depth -= 1,
            _ => {}
        }
        depth == 0
    });
    end.expect("the end of a transform")
}

/// Compares a file's scene, unfolded, with that of the unrolled text, and returns it as it was read.
fn check(text: &str, files: &dyn Files) -> Scene {
    let scene = read(text, files);
    let expected = read(&Unroller::unrolled(text, files), files);
    assert!(!expected.has_instances());
    assert_eq!(scene.materials, expected.materials);
    assert_eq!(scene.objects.len(), expected.objects.len());
    let size = expected.bounds().size().max_element();
    for (found, expected) in scene.unfolded().objects.iter().zip(&expected.objects) {
        assert_eq!(found.name, expected.name);
        let name = &expected.name;
        match (&found.shape, &expected.shape) {
            (Shape::Mesh(a), Shape::Mesh(b)) => same_mesh(a, b, 1e-12 * size, name),
            (Shape::Primitive(a), Shape::Primitive(b)) => {
                assert_eq!((a.kind, a.material), (b.kind, b.material), "{name}");
                let apart = a.world_from_object.translation - b.world_from_object.translation;
                assert!(apart.length() <= 1e-12 * size, "{name}");
            }
            other => panic!("{name}: {other:?}"),
        }
    }
    scene
}

/// Compares corner by corner: a mirrored mesh has the same faces, but counts its vertices in another order.
fn same_mesh(found: &Mesh, expected: &Mesh, tolerance: f64, name: &str) {
    assert_eq!(found.faces.starts, expected.faces.starts, "{name}");
    assert_eq!(found.face_materials, expected.face_materials, "{name}");
    assert_eq!(found.positions.len(), expected.positions.len(), "{name}");
    let corners = found.faces.corners.iter().zip(&expected.faces.corners);
    for (corner, (&a, &b)) in corners.enumerate() {
        let [p, q] = [found.positions[a as usize], expected.positions[b as usize]];
        assert!(p.distance(q) <= tolerance, "{name}: {p}, not {q}");
        let [m, n] = [(found, a), (expected, b)].map(|(mesh, v)| {
            let normals = mesh.normals.as_ref();
            normals.map_or(DVec3::ZERO, |normals| normals.at(corner, v))
        });
        assert!(m.distance(n) <= 1e-12, "{name}: {m}, not {n}");
    }
}

/// How many instances a scene has, and of how many meshes.
fn shared(scene: &Scene) -> (usize, usize) {
    let instances = scene.objects.iter();
    let instances = instances.filter(|o| matches!(o.shape, Shape::Instance(_)));
    (instances.count(), scene.shared_meshes().len())
}

/// A group of 5 × 5 slanted squares with vertices of its own, some of them with normals.
fn tile(name: &str) -> String {
    let mut text = format!("o {name}\n");
    for k in 0..36 {
        let (x, y) = (k % 6, k / 6);
        writeln!(text, "v v{k} =\np {x} {y} .{}", k % 4).unwrap();
        if x < 4 {
            writeln!(text, "n 0 .1 1").unwrap();
        }
    }
    for k in (0..29).filter(|k| k % 6 < 5) {
        let [b, c, d] = [k + 1, k + 7, k + 6];
        writeln!(text, "f v{k} v{b} v{c} v{d}").unwrap();
    }
    text + "o\n"
}

const GREY: &str = "m grey =\nrd .5\n";

#[test]
fn arrays_share_their_meshes() {
    let tile = tile("tile");
    let text = format!(
        "{GREY}xf -rz 20 -t 1 2 3 -a 2 -t 9 0 0 -a 3 -ry 40\n{tile}v n =\nn 0 0 1\ntorus n .2 1\n\
         sph n 2\no small\nf v0 v1 v7\no\nxf\n{tile}"
    );
    let scene = check(&text, &Memory::new());
    assert_eq!((scene.objects.len(), scene.materials.len()), (25, 1));
    assert_eq!(shared(&scene), (12, 2));
    // Arrays in arrays share across all of them, and mirrored ones have a mirrored mesh.
    let text = format!(
        "{GREY}xf -a 2 -t 0 0 9\nxf -t 1 0 0 -a 3 -t 7 0 0\n{tile}xf\nxf -mx -a 2 -t 0 7 0 -s 2\n{tile}xf\nxf\n"
    );
    assert_eq!(shared(&check(&text, &Memory::new())), (10, 2));
}

#[test]
fn included_files_share_their_meshes() {
    let faces = tile("x").replace("o x\n", "").replace("\no\n", "\n");
    let files = Memory::new()
        .with("tile.mgf", tile("tile"))
        .with("faces.mgf", faces)
        .with(
            "two.mgf",
            "i tile.mgf -t 1 1 1\no both\ni faces.mgf -rx 9\ni faces.mgf -my\no\n",
        );
    let text = format!(
        "{GREY}i tile.mgf\ni tile.mgf -mx -t 5 0 0\ni two.mgf -rx 30\nxf -a 2 -t 0 0 2\ni two.mgf\nxf\n\
         i faces.mgf\ni tile.mgf -a 2 -t 0 0 20\n"
    );
    let scene = check(&text, &files);
    // The mirrored tile is the only one of its mesh; the faces outside of groups are one mesh of their own.
    assert_eq!(shared(&scene), (9, 2));
}

#[test]
fn what_differs_is_not_shared() {
    let tile = tile("tile");
    let files = Memory::new()
        .with("tile.mgf", &*tile)
        .with("red.mgf", format!("m grey =\nrd .1\n{tile}"));
    // Each reading moves a vertex of the next one, or another material is current.
    let text = format!(
        "{GREY}v p =\np 0 0 0\nxf -a 3 -t 9 0 0\n{tile}o fan\n{}v p = v7\no\nxf\n\
         i tile.mgf\nm black =\nrd 0\ni tile.mgf\ni tile.mgf -t 0 9 0\ni red.mgf\n",
        "f p v0 v1 v2\n".repeat(20)
    );
    let scene = check(&text, &files);
    // Tiles; fans after the first; black tiles.
    assert_eq!(shared(&scene), (7, 3));
}

#[test]
fn maps_that_flatten_or_overflow_are_copied() {
    let tile = tile("tile");
    for map in [
        "-s 1e-200",
        "-s 1e-100",
        "-s 1e120",
        "-s 1e307",
        "-sz 1e-320",
    ] {
        let text = format!("{GREY}xf {map} -a 2 -t 1 0 0\n{tile}xf\n");
        // Valid, and nothing more: their numbers are beyond what normals can follow.
        assert_eq!(read(&text, &Memory::new()).objects.len(), 2, "{map}");
    }
}

#[test]
fn offices_as_if_written_out() {
    let Some(data) = data() else { return };
    let folder = data.join("corpus/mgf");
    for (path, expected) in [
        ("corridor.mgf", (0, 0)),
        ("office2/office2.mgf", (0, 0)),
        ("office3/office.mgf", (0, 0)),
        ("hospital/main.mgf", (16, 7)),
        ("hospital/hosp.mgf", (158, 70)),
    ] {
        let path = folder.join(path);
        let bytes = std::fs::read(&path).expect("a readable file");
        let text = String::from_utf8_lossy(&bytes);
        let files = Folder::of_model(&path).allow(&folder);
        assert_eq!(
            shared(&check(&text, &files)),
            expected,
            "{}",
            path.display()
        );
    }
}
