use super::read;
use crate::reader_tests::{check_warnings, mesh, names};
use crate::{Loaded, Memory, ReadError, ReadOptions};
use azulejo_scene::Mesh;
use glam::DVec3;
use proptest::prelude::*;

fn try_with(text: &str, files: &Memory, options: &ReadOptions) -> Result<Loaded, ReadError> {
    let loaded = read(text.as_bytes(), "a.inp", files, options)?;
    loaded.scene.validate().unwrap();
    Ok(loaded)
}

fn load(text: &str) -> Loaded {
    try_with(text, &Memory::new(), &ReadOptions::default()).unwrap()
}

fn check_error(text: &str, expected: &str) {
    let error = try_with(text, &Memory::new(), &ReadOptions::default()).unwrap_err();
    assert_eq!(error.to_string().lines().next(), Some(expected), "{text}");
}

/// Nodes 1 to 8 at the corners of a unit cube, the lower four first.
const CUBE: &str = "*NODE
1, 0, 0, 0
2, 1., 0, 0
3, 1.0D0, 1, 0
4, 0, 1
5, 0, 0, 1
6, 1, 0, 1
7, 1, 1, 1
8, 0, 1, 1
";

#[test]
fn shells_by_set() {
    let text = "*Heading
 a room
** a comment
*ELEMENT, TYPE=S4R, ELSET=Floor
1, 1, 2, 3, 4
*Element, type = S3, Elset = \"The lid\"
2, 5, 6, 7
3, 5, 7, 8
*ELEMENT, TYPE=S8R, ELSET=FLOOR
4, 1, 2, 6, 5,
 91, 92, 93, 94
*ELEMENT, TYPE=B31, ELSET=bars
5, 1, 2
*STEP
";
    let loaded = load(&[CUBE, text].concat());
    assert_eq!(names(&loaded), ["Floor", "The lid"]);
    assert_eq!(mesh(&loaded, 0).faces.len(), 2);
    assert_eq!(mesh(&loaded, 0).face_area_vector(0), DVec3::Z);
    assert_eq!(mesh(&loaded, 1).area(), 1.0);
    check_warnings(
        &loaded,
        &[
            "a.inp:10:1: keyword without geometry (the first is *HEADING): skipped (2 times)",
            "a.inp:21:1: elements of type B31: skipped",
        ],
    );
}

#[test]
fn elements_without_a_set_get_one() {
    let text = "*ELEMENT, TYPE=S3
1, 1, 2, 3
2, 1, 3, 4
3, 5, 6, 7
4, 5, 7, 8
*ELEMENT, TYPE=S4, ELSET=Eall
5, 1, 2, 6, 5
*ELSET, ELSET=_Picked, INTERNAL, GENERATE
1, 9, 1
*ELSET, ELSET=odd, GENERATE
1, 999999999, 2
*ELSET, ELSET=first
1, 2
*ELSET, ELSET=nested
first, wall.1
*ELSET, ELSET=wall.1
5
*SHELL SECTION, ELSET=nested, MATERIAL=m
.1
*SHELL SECTION, ELSET=_Picked, MATERIAL=m
";
    let loaded = load(&[CUBE, text].concat());
    assert_eq!(names(&loaded), ["nested", "odd", "_Picked"]);
    assert_eq!([0, 1, 2].map(|k| mesh(&loaded, k).faces.len()), [3, 1, 1]);
    let plain = load(&[CUBE, "*ELEMENT, TYPE=S3\n1, 1, 2, 3\n"].concat());
    assert_eq!(names(&plain), ["elements"]);
}

#[test]
fn physical_groups_of_gmsh_name_what_its_surfaces_do_not() {
    let text = "*ELEMENT, type=CPS3, ELSET=Surface1
1, 1, 2, 3
2, 1, 3, 4
*ELEMENT, type=CPS3, ELSET=Surface2
3, 5, 6, 7
*ELEMENT, type=CPS3, ELSET=Surface12
4, 5, 7, 8
*ELSET,ELSET=gmsh:bounding_entities
1, 3, 4
*ELSET,ELSET=floor
1, 2,
*ELSET,ELSET=lid
3
";
    let loaded = load(&[CUBE, text].concat());
    assert_eq!(names(&loaded), ["floor", "lid", "Surface12"]);
    assert_eq!([0, 1, 2].map(|k| mesh(&loaded, k).faces.len()), [2, 1, 1]);
    let other = text.replace("Surface", "Surface_");
    assert_eq!(
        names(&load(&[CUBE, &other].concat())),
        ["Surface_1", "Surface_2", "Surface_12"]
    );
}

#[test]
fn surfaces_come_first() {
    let text = "*ELEMENT, TYPE=C3D8, ELSET=solid
1, 1, 2, 3, 4, 5, 6, 7, 8
*ELEMENT, TYPE=S4, ELSET=sheet
2, 1, 2, 6, 5
3, 1, 2, 3, 4
*SURFACE, NAME=top, TYPE=ELEMENT
1, S2
*SURFACE, NAME=Both sides
solid, s1
sheet, SNEG
2, SPOS
*SURFACE, NAME=again
1, S2
1, S7
2, E1
2, S3
1, SPOS
*SURFACE, NAME=rest
solid
nothing, S1
*SURFACE, TYPE=NODE, NAME=n
1, 2
*SURFACE, COMBINE=UNION, NAME=u
top, rest
";
    let loaded = load(&[CUBE, text].concat());
    assert_eq!(names(&loaded), ["top", "Both sides", "rest"]);
    assert_eq!(mesh(&loaded, 0).face_area_vector(0), DVec3::Z);
    let areas: Vec<DVec3> = (0..4)
        .map(|f| mesh(&loaded, 1).face_area_vector(f))
        .collect();
    assert_eq!(areas, [-DVec3::Z, DVec3::Y, -DVec3::Z, -DVec3::Y]);
    assert_eq!(mesh(&loaded, 2).faces.len(), 4);
    check_warnings(
        &loaded,
        &[
            "a.inp:23:1: surface of \"S7\", which is not a face: skipped",
            "a.inp:24:1: surface of \"E1\", which is not a face: skipped",
            "a.inp:30:1: *SURFACE of type NODE: skipped",
            "a.inp:32:1: *SURFACE of type COMBINE: skipped",
            "a.inp:21:1: face that an earlier surface has: it stays there (2 times)",
            "a.inp:21:1: face that its element does not have: skipped (2 times)",
            "a.inp: set or instance \"nothing\" does not exist: skipped",
        ],
    );
}

/// Numbered faces of plane elements are edges, which are not surfaces.
#[test]
fn plane_elements_are_sheets() {
    let text = "*ELEMENT, TYPE=CPS3, ELSET=wall\n1, 1, 2, 3\n*SURFACE, NAME=edge\nwall, S2\n";
    let loaded = load(&[CUBE, text].concat());
    assert_eq!(names(&loaded), ["wall"]);
    check_warnings(
        &loaded,
        &["a.inp:12:1: face that its element does not have: skipped"],
    );
}

#[test]
fn cavities_choose_surfaces() {
    let text = "*ELEMENT, TYPE=DS4, ELSET=e
1, 1, 2, 3, 4
2, 5, 6, 7, 8
*SURFACE, NAME=a
1, SPOS
*SURFACE, NAME=b
2, SNEG
*CAVITY DEFINITION, NAME=c
B
";
    let loaded = load(&[CUBE, text].concat());
    assert_eq!(names(&loaded), ["b"]);
    check_warnings(
        &loaded,
        &["a.inp: shell without a surface, beside others that have one (*SURFACE): skipped"],
    );
}

#[test]
fn solids_have_a_boundary() {
    for (kind, nodes, faces) in [
        ("C3D8R", "1,2,3,4,5,6,7,8", 6),
        (
            "DC3D20",
            "1,2,3,4,5,6,7,8, 21,22,23,24,25,26,27,\n28,29,30,31,32",
            6,
        ),
        ("C3D4", "1,2,4,5", 4),
        ("C3D10", "1,2,4,5, 21,22,23,24,25,26", 4),
        ("DC3D6", "1,2,4,5,6,8", 5),
        ("C3D5", "1,2,3,4,5", 5),
    ] {
        let text = format!("{CUBE}*ELEMENT, TYPE={kind}, ELSET=s\n1, {nodes}\n");
        let loaded = load(&text);
        assert_eq!(mesh(&loaded, 0).faces.len(), faces, "{kind}");
        assert_eq!(loaded.warnings.len(), 1);
        let message = format!("the {faces} faces of their boundary");
        assert!(loaded.warnings[0].message.contains(&message));
    }
}

/// Every face of every solid looks outwards, and they are its boundary.
#[test]
fn faces_of_solids() {
    for (kind, nodes, faces) in [
        ("C3D8", "1,2,3,4,5,6,7,8", 6),
        ("C3D4", "1,2,4,5", 4),
        ("C3D6", "1,2,4,5,6,8", 5),
        ("C3D5", "1,2,3,4,5", 5),
    ] {
        let surfaces: String = (1..=faces)
            .map(|k| format!("*SURFACE, NAME=f{k}\n1, S{k}\n"))
            .collect();
        let text = format!("{CUBE}*ELEMENT, TYPE={kind}, ELSET=s\n1, {nodes}\n");
        let (solid, named) = (load(&text), load(&[text, surfaces].concat()));
        check_warnings(&named, &[]);
        let mut expected: Vec<_> = areas(mesh(&solid, 0));
        let mut actual: Vec<_> = (0..faces).flat_map(|k| areas(mesh(&named, k))).collect();
        expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
        actual.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(actual, expected, "{kind}");
    }
}

fn areas(mesh: &Mesh) -> Vec<[f64; 3]> {
    let area = |f: usize| (mesh.face_area_vector(f) + DVec3::ZERO).to_array();
    (0..mesh.faces.len()).map(area).collect()
}

const ASSEMBLY: &str = "*PART, NAME=Plate
*ELEMENT, TYPE=S4
1, 1, 2, 3, 4
*ELSET, ELSET=all
1
*SURFACE, NAME=front
all, SPOS
*END PART
*ASSEMBLY, NAME=a
*INSTANCE, NAME=left, PART=PLATE
*END INSTANCE
*INSTANCE, NAME=right, PART=Plate
 1., 0., 0.
 1., 0., 0., 1., 1., 0., 90.
*END INSTANCE
";

fn assembly(rest: &str) -> String {
    let (part, others) = ASSEMBLY.split_once('\n').unwrap();
    [part, "\n", CUBE, others, rest, "*END ASSEMBLY\n"].concat()
}

#[test]
fn instances_have_places() {
    let loaded = load(&assembly(""));
    assert_eq!(names(&loaded), ["left.front", "right.front"]);
    assert_eq!(mesh(&loaded, 0).face_area_vector(0), DVec3::Z);
    // By 1 along x, and then by 90 degrees about the edge there.
    let turned = mesh(&loaded, 1);
    assert!((turned.face_area_vector(0) - DVec3::X).length() < 1e-12);
    let far = DVec3::new(1.0, 1.0, -1.0);
    assert!(turned.positions.iter().any(|p| p.distance(far) < 1e-12));
    let without = assembly("").replace("*SURFACE, NAME=front\nall, SPOS\n", "");
    assert_eq!(names(&load(&without)), ["left.all", "right.all"]);
    let outside = assembly("*SURFACE, NAME=pair\nleft.all, SPOS\nright.1, SNEG\n");
    let outside = outside.replace("*SURFACE, NAME=front\nall, SPOS\n", "");
    let loaded = load(&outside);
    assert_eq!(
        (names(&loaded), mesh(&loaded, 0).faces.len()),
        (vec!["pair"], 2)
    );
    let sets = "*ELSET, ELSET=_s, INTERNAL, INSTANCE=right\n1\n*SURFACE, NAME=one\n_s, SPOS\n";
    let loaded = load(&assembly(sets).replace("*SURFACE, NAME=front\nall, SPOS\n", ""));
    assert_eq!(names(&loaded), ["one"]);
}

#[test]
fn instances_may_list_their_mesh() {
    let mesh_of_instance = [CUBE, "*ELEMENT, TYPE=S3, ELSET=own\n1, 1, 2, 3\n"].concat();
    let text = format!(
        "*PART, NAME=p\n*END PART\n*ASSEMBLY\n*INSTANCE, NAME=i, PART=p\n0, 0, 2.\n{mesh_of_instance}\
         *END INSTANCE\n*INSTANCE, NAME=j, PART=q\n*END INSTANCE\n"
    );
    let loaded = load(&text);
    assert_eq!(names(&loaded), ["own"]);
    assert_eq!(mesh(&loaded, 0).positions[0].z, 2.0);
    check_warnings(
        &loaded,
        &["a.inp:18:1: instance of a part that does not exist, or has no elements with surfaces"],
    );
    let alone = load(&["*PART, NAME=p\n", &mesh_of_instance, "*END PART\n"].concat());
    assert_eq!(names(&alone), ["own"]);
}

#[test]
fn files_include_others() {
    let text = "*NODE, INPUT=nodes.txt\n*ELEMENT, TYPE=S3, ELSET=e\n*INCLUDE, INPUT=e.inp\n2, 1, 3, 4\n*INCLUDE, INPUT=none\n";
    let nodes = CUBE.split_once('\n').unwrap().1;
    let files = Memory::new()
        .with("nodes.txt", nodes)
        .with("e.inp", "1, 1, 2, 3\n");
    let loaded = try_with(text, &files, &ReadOptions::default()).unwrap();
    assert_eq!(mesh(&loaded, 0).area(), 1.0);
    check_warnings(
        &loaded,
        &["a.inp:5:1: included file \"none\": there is no such file; skipped"],
    );
    let circle = Memory::new().with("b.inp", "*INCLUDE, INPUT=b.inp\n");
    let error = try_with("*INCLUDE, INPUT=b.inp\n", &circle, &ReadOptions::default()).unwrap_err();
    assert_eq!(&*error.found, "file \"b.inp\", which includes itself");
    assert_eq!(error.included_from, [("a.inp".to_owned(), 1)]);
}

/// Small files that would unfold to much.
#[test]
fn expansion_is_limited() {
    let options = |text: &str| ReadOptions::in_proportion(text.len());
    let check = |text: &str, files: &Memory| {
        let error = try_with(text, files, &options(text)).unwrap_err();
        assert!(error.found.contains("expand to more than"), "{error}");
    };
    let elements: String = (1..4000).map(|k| format!("{k},1,2,3\n")).collect();
    let instances = "*INSTANCE, PART=p\n".repeat(1000);
    let part = format!("*PART, NAME=p\n{CUBE}*ELEMENT, TYPE=S3, ELSET=e\n{elements}");
    check(&format!("{part}*END PART\n{instances}"), &Memory::new());
    let ranges = "1,999999999\n".repeat(4000);
    let sets = format!("*ELSET, ELSET=s, GENERATE\n{ranges}*SURFACE, NAME=a\ns, SPOS\n");
    check(
        &[CUBE, "*ELEMENT, TYPE=S3\n", &elements, &sets].concat(),
        &Memory::new(),
    );
    let files = (0..18).fold(Memory::new(), |files, k| {
        let twice = format!("*INCLUDE, INPUT=f{}\n", k + 1).repeat(2);
        files.with(format!("f{k}"), twice)
    });
    check("*INCLUDE, INPUT=f0\n", &files.with("f18", "** nothing\n"));
}

#[test]
fn sets_may_contain_themselves() {
    let text = "*ELEMENT, TYPE=S3\n1,1,2,3\n*ELSET, ELSET=a\nb\n*ELSET, ELSET=b\na, 1\n*SURFACE, NAME=s\na, SPOS\n";
    let loaded = load(&[CUBE, text].concat());
    assert_eq!(mesh(&loaded, 0).faces.len(), 1);
    check_warnings(&loaded, &[]);
}

#[test]
fn fields_are_checked() {
    let number = "expected a whole number";
    check_error("*NODE\n x, 1", &format!("a.inp:2:2: found \"x\", {number}"));
    check_error(
        "*NODE\n1, 0, 1..",
        "a.inp:2:7: found \"1..\", expected a number",
    );
    check_error(
        "*ELEMENT, TYPE=S3\n1, 2, -3",
        &format!("a.inp:2:7: found \"-3\", {number}"),
    );
    check_error(
        "*ELSET, ELSET=a, GENERATE\n1",
        &format!("a.inp:2:2: found the end of the line, {number}"),
    );
    check_error(
        "*NODE, SYSTEM=S\n1",
        "a.inp:1:1: found nodes in the system S, expected the systems R or C",
    );
    check_error(
        "*SYSTEM\n1,0,0",
        "a.inp:2:1: found a coordinate system (*SYSTEM), expected nodes in the global system",
    );
    check_error(
        "*INCLUDE",
        "a.inp:1:1: found *INCLUDE without INPUT, expected the name of a file",
    );
    check_error(
        "*INSTANCE, PART=p\n1\n1,1,1,1,1,1,9",
        "a.inp:3:1: found a rotation about two points that are one, expected two points of its axis",
    );
}

#[test]
fn cylindrical_nodes() {
    let text =
        "*NODE, SYSTEM=C\n1, 1, 0, 3\n2, 2, 180, 3\n3, 1, 90, 3\n*ELEMENT, TYPE=S3\n1,1,3,2\n";
    let loaded = load(text);
    let far = DVec3::new(-2.0, 0.0, 3.0);
    assert!(mesh(&loaded, 0).positions[2].distance(far) < 1e-12);
}

#[test]
fn what_is_skipped_is_counted() {
    let text = "*ELEMENT, TYPE=S3
1, 1, 2, 3
1, 1, 3, 4
2, 1, 2, 99
3, 1, 2, 3, 4
4, 1,
*NODE
1, 0, 0, 0
8, 0, 0, 9
*NGEN
1, 8
*ELSET
1
";
    let loaded = load(&[CUBE, text].concat());
    check_warnings(
        &loaded,
        &[
            "a.inp:12:1: element of a number that another one has: skipped",
            "a.inp:14:1: element with too many nodes: the first ones are used",
            "a.inp:15:1: element with too few nodes: skipped",
            "a.inp:18:1: node of a number that another one has: the last one counts",
            "a.inp:19:1: *NGEN, which makes nodes or elements: skipped",
            "a.inp:21:1: *ELSET without a name: skipped",
            "a.inp: element with a node that does not exist: skipped",
        ],
    );
    assert_eq!(mesh(&loaded, 0).faces.len(), 2);
}

#[test]
fn damaged_files_are_no_danger() {
    let surface = "*ELSET, ELSET=g, GENERATE\n1, 9, 2\n*SURFACE, NAME=s\ng, SPOS\nleft.all, S1\n";
    let text = assembly(surface);
    for end in 0..text.len() {
        let _ = read(
            &text.as_bytes()[..end],
            "a.inp",
            &Memory::new(),
            &ReadOptions::default(),
        );
    }
}

proptest! {
    #[test]
    fn any_text_is_read_or_refused(text in "((\\*NODE|\\*ELEMENT, TYPE=(S3|C3D4), ELSET=a|\\*SURFACE, NAME=a|\\*ELSET, ELSET=a|\\*INSTANCE, PART=a|\\*PART, NAME=a|a, S[12])?[0-9a., ]{0,20}\n){0,20}") {
        if let Ok(loaded) = read(text.as_bytes(), "a.inp", &Memory::new(), &ReadOptions::default()) {
            prop_assert!(loaded.scene.validate().is_ok());
        }
    }
}

/// CalculiX numbers the faces of a cavity by element, and those of an element from the last load on.
#[test]
fn faces_with_radiation_loads_are_in_the_order_of_calculix() {
    let text = "*ELEMENT, TYPE=C3D8, ELSET=E
7, 1, 2, 3, 4, 5, 6, 7, 8
*ELEMENT, TYPE=S4, ELSET=shells
3, 1, 2, 3, 4
*SURFACE, NAME=ignored
7, S1
*STEP
*RADIATE, CAVITY=Oven
7, R2CR, 300., 0.8
7, R1, 300., 0.8
E, R6CR, 300., 0.8
shells, R1CR, 300., 0.8
*END STEP
*STEP
*RADIATE
7, R2CR, 350., 0.8
*END STEP
";
    let loaded = load(&[CUBE, text].concat());
    assert_eq!(names(&loaded), ["Oven"]);
    let mesh = mesh(&loaded, 0);
    let normals: Vec<DVec3> = (0..3).map(|f| mesh.face_area_vector(f)).collect();
    // The back of the shell; of the brick its sixth face, whose load comes last, and the second.
    assert_eq!(normals, [-DVec3::Z, -DVec3::X, DVec3::Z]);
    // A step may take back what there was.
    let text = text.replace("*STEP\n*RADIATE\n", "*STEP\n*RADIATE, OP=NEW\n");
    assert_eq!(
        super::tests::mesh(&load(&[CUBE, &text].concat()), 0)
            .faces
            .len(),
        1
    );
}

#[test]
fn elements_that_should_be_revolved_are_named() {
    let loaded = load(&[CUBE, "*ELEMENT, TYPE=CAX4\n1, 1, 2, 3, 4\n"].concat());
    check_warnings(
        &loaded,
        &[
            "a.inp:10:1: elements of type CAX4, which are axisymmetric: read as a sheet in their plane, and not revolved \
             (--revolve 64 does it)",
        ],
    );
}

fn revolved(text: &str, sectors: u32) -> Result<Loaded, ReadError> {
    let options = ReadOptions {
        sectors: Some(sectors),
        ..ReadOptions::default()
    };
    try_with(text, &Memory::new(), &options)
}

/// The sections of a tube between 1 and 3 from the axis, 2 high, and of a solid cylinder below it.
const SECTIONS: &str = "*NODE
1, 1, 0
2, 3, 0
3, 3, 2
4, 1, 2
5, 0, -1
6, 1, -1
7, 0, 0
*ELEMENT, TYPE=DCAX4, ELSET=tube
1, 1, 2, 3, 4
*ELEMENT, TYPE=CAX3, ELSET=cylinder
2, 5, 6, 1
3, 5, 1, 7
";

#[test]
fn axisymmetric_elements_are_revolved() {
    let loaded = revolved(SECTIONS, 12).unwrap();
    assert_eq!(names(&loaded), ["tube", "cylinder"]);
    // Each edge that elements do not share, in twelve facets; none on the axis.
    let counts = [0, 1].map(|k| mesh(&loaded, k).faces.len());
    assert_eq!(counts, [4 * 12, 3 * 12]);
    for k in [0, 1] {
        assert!(mesh(&loaded, k).is_closed());
        let volume = mesh(&loaded, k).faces.iter().enumerate();
        let volume = volume.map(|(f, corners)| {
            let corner = mesh(&loaded, k).positions[corners[0] as usize];
            corner.dot(mesh(&loaded, k).face_area_vector(f)) / 3.0
        });
        // Of prisms over a regular polygon of the same circumference.
        let (circle, sides) = ([8.0, 1.0][k], 12.0);
        let half = std::f64::consts::PI / sides;
        let expected = circle * [2.0, 1.0][k] * std::f64::consts::PI * half / half.tan();
        let volume: f64 = volume.sum();
        assert!((volume / expected - 1.0).abs() < 1e-12, "{volume}");
    }
}

#[test]
fn edges_of_axisymmetric_elements_have_numbers() {
    let text = "*SURFACE, NAME=wall
1, S4
*SURFACE, NAME=lid
1, S3
*SURFACE, NAME=axis
3, S3
*SURFACE, NAME=free
2,
*SURFACE, NAME=none
1, S5
1, SPOS
";
    let loaded = revolved(&[SECTIONS, text].concat(), 24).unwrap();
    assert_eq!(names(&loaded), ["wall", "lid", "free"]);
    let wall = mesh(&loaded, 0);
    assert!((wall.area() / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-12);
    for face in 0..wall.faces.len() {
        let centre: DVec3 = wall.face_positions(face).iter().sum();
        assert!(centre.with_y(0.0).dot(wall.face_area_vector(face)) < 0.0);
    }
    assert!((0..24).all(|face| mesh(&loaded, 1).face_area_vector(face).y > 0.0));
    // The side and the bottom of the cylinder.
    assert_eq!(mesh(&loaded, 2).faces.len(), 2 * 24);
    check_warnings(
        &loaded,
        &[
            "a.inp:18:1: face with fewer than three different corners: skipped",
            "a.inp:22:1: face that its element does not have: skipped (2 times)",
        ],
    );
}

#[test]
fn sections_are_beside_the_axis() {
    for (node, place) in [("-1, 0", "-1, 0, 0"), ("1, 0, 2", "1, 0, 2")] {
        let text = SECTIONS.replace("1, 1, 0\n", &format!("1, {node}\n"));
        let error = revolved(&text, 12).unwrap_err().to_string();
        assert!(
            error.contains(&format!("a node at {place} of an axisymmetric element")),
            "{error}"
        );
    }
    let many: String = (8..2000).map(|k| format!("{k}, 1, {k}\n")).collect();
    let text = ["*NODE\n", &many, SECTIONS].concat();
    let options = ReadOptions {
        sectors: Some(3600),
        ..ReadOptions::in_proportion(text.len())
    };
    let error = try_with(&text, &Memory::new(), &options).unwrap_err();
    assert!(error.found.contains("expand to more than"), "{error}");
    // Few nodes, and many elements between them.
    let many: String = (9..2000).map(|k| format!("{k}, 5, 6, 1\n")).collect();
    let text = [SECTIONS, &many].concat();
    let error = try_with(&text, &Memory::new(), &options).unwrap_err();
    assert!(error.found.contains("expand to more than"), "{error}");
}
