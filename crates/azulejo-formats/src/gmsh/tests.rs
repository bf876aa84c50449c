use super::read;
use crate::reader_tests::{check_warnings, mesh};
use crate::{Loaded, Memory, ReadError, ReadOptions};
use azulejo_scene::Up;
use glam::DVec3;
use proptest::prelude::*;

fn try_load(bytes: &[u8]) -> Result<Loaded, ReadError> {
    let loaded = read(bytes, "a.msh", &Memory::new(), &ReadOptions::default())?;
    loaded.scene.validate().unwrap();
    Ok(loaded)
}

fn load(text: &str) -> Loaded {
    try_load(text.as_bytes()).unwrap_or_else(|e| panic!("{e}"))
}

fn check_error(text: &str, expected: &str) {
    let error = try_load(text.as_bytes()).unwrap_err().to_string();
    assert_eq!(error.lines().next(), Some(expected));
}

/// Names of objects with their numbers of faces.
fn objects(loaded: &Loaded) -> Vec<(&str, usize)> {
    let objects = loaded.scene.objects.iter().enumerate();
    objects
        .map(|(k, o)| (o.name.as_str(), mesh(loaded, k).faces.len()))
        .collect()
}

/// A file of version 2.2 with the corners of a cube, numbered 10 to 17.
fn version_2(before: &str, elements: &str) -> String {
    let count = elements.lines().count();
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n{before}$Nodes\n8\n10 0 0 0\n11 1 0 0\n12 1 1 0\n\
         13 0 1 0\n14 0 0 1\n15 1 0 1\n16 1 1 1\n17 0 1 1\n$EndNodes\n$Elements\n{count}\n{elements}\
         $EndElements\n"
    )
}

const NAMES: &str =
    "$PhysicalNames\n3\n2 1 \"hot wall\"\n3 1 \"air\"\n1 2 \"edge\"\n$EndPhysicalNames\n";

#[test]
fn surfaces_have_names() {
    let elements = "1 3 2 1 4 10 13 12 11\n2 2 2 2 5 14 15 16\n3 2 2 0 6 14 16 17\n4 1 2 2 7 10 11\n\
                    5 15 2 0 1 10\n6 2 0 10 11 15\n";
    let loaded = load(&version_2(NAMES, elements));
    let expected = [
        ("hot wall", 1),
        ("physical surface 2", 1),
        ("surface 6", 1),
        ("surface 0", 1),
    ];
    assert_eq!(objects(&loaded), expected);
    assert_eq!(loaded.scene.units.up, Up::Z);
    assert_eq!(mesh(&loaded, 0).face_area_vector(0), -DVec3::Z);
    assert_eq!(mesh(&loaded, 1).positions.len(), 3);
    check_warnings(
        &loaded,
        &["a.msh: point or line element: skipped, as it has no area (2 times)"],
    );
}

#[test]
fn curved_elements_are_read_by_their_corners() {
    let six = "1 9 2 1 4 14 15 16 10 11 12\n";
    let eight = "2 16 2 1 4 10 13 12 11 14 15 16 17\n";
    let nine = "3 10 2 1 4 10 11 15 14 10 10 10 10 10\n";
    let loaded = load(&version_2(NAMES, &[six, eight, nine].concat()));
    let plain = "1 2 2 1 4 14 15 16\n2 3 2 1 4 10 13 12 11\n3 3 2 1 4 10 11 15 14\n";
    assert_eq!(loaded.scene, load(&version_2(NAMES, plain)).scene);
    check_warnings(
        &loaded,
        &["a.msh: element of second or higher order: read as flat, between its corners (3 times)"],
    );
}

/// gmsh writes an element of two groups twice, and with a negative number of its group in another order.
#[test]
fn groups_may_overlap_and_be_reversed() {
    let twice = "1 2 2 1 4 10 11 12\n2 2 2 2 4 10 11 12\n3 2 2 -1 5 14 15 16\n";
    let loaded = load(&version_2(NAMES, twice));
    assert_eq!(objects(&loaded), [("hot wall", 2)]);
    assert_eq!(mesh(&loaded, 0).face_area_vector(0), DVec3::Z / 2.0);
    assert_eq!(mesh(&loaded, 0).face_area_vector(1), -DVec3::Z / 2.0);
    check_warnings(
        &loaded,
        &["a.msh: element in several physical groups: only the first one has it"],
    );
}

#[test]
fn the_boundary_stands_for_missing_surfaces() {
    // A cube of two prisms, one of the second order, and a pyramid on it in another group.
    let elements = "1 6 2 1 1 10 11 13 14 15 17\n\
                    2 18 2 1 1 11 12 13 15 16 17 10 10 10 10 10 10 10 10 10\n\
                    3 7 2 0 8 14 15 16 17 18\n";
    let text = version_2(NAMES, elements).replace("$Nodes\n8", "$Nodes\n9\n18 0.5 0.5 2");
    let loaded = load(&text);
    // The cover of the cube is two triangles, the base of the pyramid a square: both are boundaries.
    assert_eq!(objects(&loaded), [("air", 8), ("volume 8", 5)]);
    check_warnings(
        &loaded,
        &[
            "a.msh: element of second or higher order: read as flat, between its corners",
            "a.msh: volumes without surfaces: the 13 faces of their boundary are read, whose fronts look \
             out of the volumes (form-factors --two-sided has rows of the backs, too)",
        ],
    );
    let bottom = mesh(&loaded, 0).face_area_vector(0);
    assert_eq!(bottom, -DVec3::Z / 2.0);
    let both = [elements, "4 2 2 1 1 10 11 12\n"].concat();
    let loaded = load(&version_2(NAMES, &both).replace("$Nodes\n8", "$Nodes\n9\n18 0.5 0.5 2"));
    assert_eq!(objects(&loaded), [("hot wall", 1)]);
    let skipped = "a.msh: volume element: skipped, as the file has elements of surfaces (3 times)";
    assert_eq!(loaded.warnings[1].to_string(), skipped);
}

#[test]
fn other_sections_are_passed() {
    let more = "$Comments\nany $thing\n$EndComments\n$NodeData\n1\n\"T\"\n$EndNodeData\n\
                $NodeData\n$EndNodeData\n$Periodic\n0\n$EndPeriodic\n$Mine\n$EndMine\n";
    let loaded = load(&version_2(more, "1 2 2 1 4 10 11 12\n"));
    check_warnings(
        &loaded,
        &[
            "a.msh:7:1: section $NodeData: skipped (2 times)",
            "a.msh:16:1: section $Mine: skipped",
        ],
    );
    check_warnings(
        &load(&version_2("", "")),
        &["a.msh: no faces: the scene is empty"],
    );
}

#[test]
fn nodes_may_be_parametric() {
    let text = version_2("", "1 2 2 1 4 10 11 12\n");
    let named = text
        .replace("$Nodes", "$ParametricNodes")
        .replace("$EndNodes", "$EndParametricNodes");
    let mut parametric = named;
    for (k, tail) in [
        "0 1",
        "1 1 .5",
        "2 1 .5 .5",
        "3 1",
        "0 1",
        "0 1",
        "0 1",
        "0 1",
    ]
    .iter()
    .enumerate()
    {
        let start = format!("\n{} ", 10 + k);
        let at = parametric.find(&start).unwrap() + 1;
        let end = at + parametric[at..].find('\n').unwrap();
        parametric.insert_str(end, &format!(" {tail}"));
    }
    assert_eq!(load(&parametric).scene, load(&text).scene);
}

/// Version 4.1 as text, or binary in either byte order.
struct Encoder {
    bytes: Vec<u8>,
    order: Option<bool>,
}

impl Encoder {
    fn new(order: Option<bool>) -> Encoder {
        let mut encoder = Encoder {
            bytes: Vec::new(),
            order,
        };
        encoder.line(&format!("$MeshFormat\n4.1 {} 8", u8::from(order.is_some())));
        if order.is_some() {
            encoder.ints(&[1]);
        }
        encoder.line("\n$EndMeshFormat");
        encoder
    }

    fn line(&mut self, text: &str) {
        self.bytes.extend(text.bytes().chain([b'\n']));
    }

    fn raw<const N: usize>(&mut self, text: String, mut bytes: [u8; N]) {
        match self.order {
            None => self.bytes.extend(text.bytes().chain([b' '])),
            Some(is_big) => {
                if is_big {
                    bytes.reverse();
                }
                self.bytes.extend(bytes);
            }
        }
    }

    fn ints(&mut self, numbers: &[i32]) {
        for n in numbers {
            self.raw(n.to_string(), n.to_le_bytes());
        }
    }

    fn sizes(&mut self, numbers: &[u64]) {
        for n in numbers {
            self.raw(n.to_string(), n.to_le_bytes());
        }
    }

    fn reals(&mut self, numbers: &[f64]) {
        for n in numbers {
            self.raw(n.to_string(), n.to_le_bytes());
        }
    }
}

/// Two squares on entities 1 (groups −7 and 8) and 2 (none), a triangle between two partitions of a volume.
fn version_4(order: Option<bool>) -> Vec<u8> {
    let mut file = Encoder::new(order);
    file.line("$PhysicalNames\n1\n2 7 \"lid\"\n$EndPhysicalNames\n$Entities");
    file.sizes(&[1, 0, 2, 0]);
    file.ints(&[1]);
    file.reals(&[0.0; 3]);
    file.sizes(&[0]);
    for (entity, groups) in [(1, &[-7, 8][..]), (2, &[])] {
        file.ints(&[entity]);
        file.reals(&[0.0; 6]);
        file.sizes(&[groups.len() as u64]);
        file.ints(groups);
        file.sizes(&[1]);
        file.ints(&[4]);
    }
    file.line("\n$EndEntities\n$PartitionedEntities");
    file.sizes(&[2, 1]);
    file.ints(&[9, 1]);
    file.sizes(&[0, 0, 1, 0]);
    file.ints(&[5, 3, 1]);
    file.sizes(&[2]);
    file.ints(&[1, 2]);
    file.reals(&[0.0; 6]);
    file.sizes(&[0, 0]);
    file.line("\n$EndPartitionedEntities\n$Nodes");
    file.sizes(&[2, 5, 1, 1 << 40]);
    file.ints(&[2, 1, 1]);
    file.sizes(&[4, 1, 2, 3, 1 << 40]);
    for (x, y) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
        file.reals(&[x, y, 0.5, 0.1, 0.2]);
    }
    file.ints(&[0, 2, 0]);
    file.sizes(&[1, 4]);
    file.reals(&[0.0, 0.0, 3.0]);
    file.line("\n$EndNodes\n$Elements");
    file.sizes(&[4, 4, 1, 4]);
    file.ints(&[2, 1, 3]);
    file.sizes(&[1, 1, 1, 2, 3, 1 << 40]);
    file.ints(&[2, 2, 2]);
    file.sizes(&[1, 2, 1, 2, 4]);
    file.ints(&[1, 4, 1]);
    file.sizes(&[1, 3, 1, 2]);
    file.ints(&[2, 5, 2]);
    file.sizes(&[1, 4, 1, 2, 3]);
    file.line("\n$EndElements");
    file.bytes
}

#[test]
fn version_4_is_read_in_every_encoding() {
    let text = try_load(&version_4(None)).unwrap();
    assert_eq!(objects(&text), [("lid", 1), ("surface 2", 1)]);
    // The negative number of its group turns the square.
    assert_eq!(mesh(&text, 0).face_area_vector(0), -DVec3::Z);
    assert_eq!(mesh(&text, 1).positions[2], DVec3::new(0.0, 0.0, 3.0));
    check_warnings(
        &text,
        &[
            "a.msh: point or line element: skipped, as it has no area",
            "a.msh: surface in several physical groups: only the first one has it",
            "a.msh: element between partitions of a volume: skipped",
        ],
    );
    for is_big in [false, true] {
        let binary = try_load(&version_4(Some(is_big))).unwrap();
        assert_eq!(binary.scene, text.scene);
        assert_eq!(binary.warnings, text.warnings);
    }
}

/// Elements of one type in blocks, numbers of four bytes.
#[test]
fn version_2_is_read_in_either_byte_order() {
    let text = version_2(
        "",
        "1 2 2 7 1 10 11 12\n2 2 2 7 1 12 13 10\n3 3 1 0 14 15 16 17\n",
    );
    for is_big in [false, true] {
        let mut file = Encoder::new(Some(is_big));
        file.bytes[14] = b'2';
        file.bytes[12] = b'2';
        file.bytes[13] = b'.';
        file.line("$Nodes\n8");
        let corners = [(0, 0), (1, 0), (1, 1), (0, 1)];
        let places = corners.iter().cycle().take(8).enumerate();
        for (k, &(x, y)) in places {
            file.ints(&[10 + k as i32]);
            file.reals(&[f64::from(x), f64::from(y), (k / 4) as f64]);
        }
        file.line("\n$EndNodes\n$Elements\n3");
        file.ints(&[2, 2, 2, 1, 7, 1, 10, 11, 12, 2, 7, 1, 12, 13, 10]);
        file.ints(&[3, 1, 1, 3, 0, 14, 15, 16, 17]);
        file.line("\n$EndElements");
        assert_eq!(try_load(&file.bytes).unwrap().scene, load(&text).scene);
    }
}

#[test]
fn errors_say_where() {
    let check = |text: &str, found: &str| {
        let expected =
            "expected version 2.2 or 4.1, as which gmsh exports it (Mesh.MshFileVersion)";
        check_error(text, &format!("{found}, {expected}"));
    };
    check("$NOD\n3\n", "a.msh:1:1: found version 1 of the format");
    check(
        "$MeshFormat\n4 0 8\n",
        "a.msh:2:1: found version 4 of the format",
    );
    check(
        "$MeshFormat\n4.0 1 8\n",
        "a.msh:2:1: found version 4.0 of the format",
    );
    check(
        "$Comments\n$EndComments",
        "a.msh: found no section $MeshFormat",
    );
    let triangle = "1 2 2 1 4 10 11 12\n";
    let changed = |from: &str, to: &str| version_2("", triangle).replace(from, to);
    check_error(
        &changed("10 11 12", "10 11 19"),
        "a.msh:17:1: found an element with node 19, expected a node of the section $Nodes before it",
    );
    check_error(
        &changed("1 2 2 1", "1 200 2 1"),
        "a.msh:17:3: found element type 200, expected lines, triangles, quadrilaterals, tetrahedra, \
         hexahedra, prisms or pyramids",
    );
    check_error(
        &changed("$Nodes\n8", "$Nodes\n7"),
        "a.msh:13:1: found \"17\", expected $EndNodes",
    );
    check_error(
        &changed("$Nodes\n8", "$Nodes\n9"),
        "a.msh:14:1: found \"$EndNodes\", expected the number of a node",
    );
    check_error(
        &changed("$EndElements", "$EndNodeData"),
        "a.msh:18:1: found \"$EndNodeData\", expected $EndElements",
    );
    check_error(
        &changed("1 1 0\n", "1 x 0\n"),
        "a.msh:8:6: found \"x\", expected a number",
    );
    check_error(
        "$Nodes\n1\n",
        "a.msh:1:1: found $Nodes, expected $MeshFormat before it",
    );
    check_error(
        &version_2("$Mine\n", ""),
        "a.msh:19:1: found the end of the file, expected $EndMine",
    );
    check_error(
        "$MeshFormat\n2.2 0 9\n",
        "a.msh:2:7: found 9, expected 4 or 8 bytes for each size",
    );
    check_error(
        "$MeshFormat\n2.2 1 8\n\x02\0\0\0",
        "a.msh: byte 20 (0x14): found 2, expected the integer 1",
    );
    check_error(
        "nodes",
        "a.msh:1:1: found \"nodes\", expected a section, as $Nodes",
    );
}

#[test]
fn a_cut_file_is_an_error() {
    for order in [None, Some(false)] {
        let bytes = version_4(order);
        let whole = try_load(&bytes).unwrap().scene;
        for end in 0..bytes.len() - 1 {
            if let Ok(cut) = try_load(&bytes[..end]) {
                assert!(cut.scene.objects.is_empty() || cut.scene == whole, "{end}");
            }
        }
    }
}

/// Counts that the file does not hold must end early and reserve nothing.
#[test]
fn counts_reserve_no_memory() {
    let most = u64::MAX.to_string();
    for line in ["$Nodes\n8", "$Elements\n1", "$PhysicalNames\n3"] {
        let (section, _) = line.split_once('\n').unwrap();
        let text = version_2(NAMES, "1 2 2 1 4 10 11 12\n");
        let text = text.replace(line, &format!("{section}\n{most}"));
        assert!(try_load(text.as_bytes()).is_err(), "{line}");
    }
    let mut file = Encoder::new(Some(false));
    file.line("$Nodes");
    file.sizes(&[u64::MAX, 1, 1, 1]);
    file.ints(&[0, 1, 0]);
    file.sizes(&[u64::MAX, 1]);
    assert!(try_load(&file.bytes).is_err());
}

proptest! {
    #[test]
    fn any_words_are_harmless(words in "([$A-Za-z0-9.\n -]|\\$EndNodes|\\$Elements\n){0,200}") {
        let _ = try_load(format!("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n{words}").as_bytes());
    }
}

/// Version 2.0 of 2008 writes no dimension before the number of a name.
#[test]
fn names_without_a_dimension() {
    let names = "$PhysicalNames\n2\n1 \"hot wall\"\n2 \"5 cold\"\n$EndPhysicalNames\n";
    let text = version_2(names, "1 3 2 1 4 10 13 12 11\n2 2 2 2 5 14 15 16\n");
    let loaded = load(&text.replace("2.2 0 8", "2 0 8"));
    assert_eq!(objects(&loaded), [("hot wall", 1), ("5 cold", 1)]);
}
