//! Blocks and their instances; layers, colours and MATERIALs.

use super::*;
use azulejo_scene::{Material, Rgb};

/// A triangle with the corners (0, 0, 0), (1, 0, 0) and (0, 1, 0), with additional groups.
fn triangle(more: &str) -> String {
    format!("0 3DFACE; {more}; @10 0 0 0; @11 1 0 0; @12 0 1 0;")
}

fn block(name: &str, more: &str, content: &str) -> String {
    format!("0 BLOCK; 2 {name}; {more}; {content}; 0 ENDBLK;")
}

/// A drawing of blocks and entities.
fn drawing(blocks: &str, entities: &str) -> String {
    file(&[("BLOCKS", blocks), ("ENTITIES", entities)])
}

/// Checks where an INSERT of these groups puts the triangle of a block with base point (0, 0, 1).
fn check_insert(groups: &str, expected: &[[f64; 3]]) {
    let text = drawing(
        &block("a", "@10 0 0 1", &triangle("8 0")),
        &format!("0 INSERT; 2 a; {groups}"),
    );
    check_polygons(&only_mesh(&text), &[expected]);
}

#[test]
fn placements() {
    check_insert(
        "@10 5 6 7",
        &[[5.0, 6.0, 6.0], [6.0, 6.0, 6.0], [5.0, 7.0, 6.0]],
    );
    check_insert(
        "@10 5 6 7; 50 90",
        &[[5.0, 6.0, 6.0], [5.0, 7.0, 6.0], [4.0, 6.0, 6.0]],
    );
    check_insert(
        "41 2; 42 3; 43 4",
        &[[0.0, 0.0, -4.0], [2.0, 0.0, -4.0], [0.0, 3.0, -4.0]],
    );
    // A mirrored face is reversed, so that its front stays the front.
    check_insert(
        "41 -2",
        &[[0.0, 0.0, -1.0], [0.0, 1.0, -1.0], [-2.0, 0.0, -1.0]],
    );
    // Along x: the block's x is y, its y is z; the point is in these axes as well.
    check_insert(
        "@10 5 6 7; @210 1 0 0",
        &[[6.0, 5.0, 6.0], [6.0, 6.0, 6.0], [6.0, 5.0, 7.0]],
    );
    // Extrusion, rotation and scale together: R_z(90°)·diag(2, 1, 1) in axes (−x, y, −z).
    check_insert(
        "@10 5 0 0; @210 0 0 -1; 50 90; 41 2",
        &[[-5.0, 0.0, 1.0], [-5.0, 2.0, 1.0], [-4.0, 0.0, 1.0]],
    );
}

#[test]
fn arrays() {
    let text = drawing(
        &block("a", "", &triangle("8 0")),
        "0 INSERT; 2 a; 8 tiles; @10 10 0 0; 50 90; 41 0.5; 70 3; 71 2; 44 4; 45 5",
    );
    let loaded = load(text);
    assert_eq!(names(&loaded), ["a/tiles"; 6]);
    let objects = &loaded.scene.objects;
    assert_eq!(loaded.scene.shared_meshes().len(), 1);
    // Steps are rotated with the block but not scaled: columns along y, rows along −x.
    let corner = |i: usize| objects[i].shape.placed_mesh().unwrap().position(0);
    let expected = [[10, 0], [10, 4], [10, 8], [5, 0], [5, 4], [5, 8]];
    for (i, [x, y]) in expected.into_iter().enumerate() {
        assert!(
            (corner(i) - DVec3::new(x.into(), y.into(), 0.0)).length() < 1e-12,
            "{i}: {}",
            corner(i)
        );
    }
}

#[test]
fn blocks_within_blocks() {
    let leg = block("leg", "", &triangle("8 wood"));
    let table = block(
        "table",
        "@10 1 0 0",
        "0 INSERT; 2 Leg; 8 0; @10 3 0 0; 41 2; 0 LIGHT; 70 2; @10 1 1 1; 72 2",
    );
    let text = drawing(&(leg + &table), "0 INSERT; 2 TABLE; @10 10 0 0; 50 180");
    let loaded = load(text);
    assert_eq!(
        (names(&loaded), warnings(&loaded)),
        (vec!["table/leg/wood"], vec![])
    );
    check_polygons(
        mesh(&loaded, 0),
        &[&[[8.0, 0.0, 0.0], [6.0, 0.0, 0.0], [8.0, -1.0, 0.0]]],
    );
    let azulejo_scene::LightKind::Point { position, .. } = loaded.scene.lights[0].kind else {
        panic!("a point light");
    };
    assert!(
        (position - DVec3::new(10.0, -1.0, 1.0)).length() < 1e-12,
        "{position}"
    );
}

#[test]
fn blocks_may_follow_and_anonymous_ones_have_no_name() {
    let text = file(&[
        (
            "ENTITIES",
            "0 INSERT; 2 *U1; 66 1; 0 ATTRIB; 1 text; 0 SEQEND",
        ),
        ("BLOCKS", &block("*U1", "70 1", &triangle("8 walls"))),
    ]);
    let loaded = load(text);
    assert_eq!((names(&loaded), warnings(&loaded)), (vec!["walls"], vec![]));
}

#[test]
fn inserts_that_cannot_be_followed() {
    let a = block("a", "", "0 INSERT; 2 b");
    let b = block("b", "", &format!("0 INSERT; 2 a; {}", triangle("8 0")));
    let loaded = load(drawing(
        &(a + &b),
        "0 INSERT; 2 a; 0 INSERT; 2 c; 0 INSERT; 41 0; 2 b; 0 INSERT",
    ));
    assert_eq!(names(&loaded), ["a/b/0", "b/0"]);
    assert_eq!(
        warnings(&loaded),
        [
            ":61:1: INSERT with a scale of 0: taken as 1",
            ":67:1: INSERT without a block: skipped",
            ":19:1: INSERT of block \"a\", which contains itself: left out",
            ":57:1: INSERT of block \"c\", which is not defined: left out",
        ]
    );
}

#[test]
fn depth_is_limited() {
    let mut blocks = block("b0", "", &triangle("8 0"));
    for i in 1..200 {
        blocks += &block(&format!("b{i}"), "", &format!("0 INSERT; 2 b{}", i - 1));
    }
    let shallow = load(drawing(&blocks, "0 INSERT; 2 b50"));
    assert_eq!(
        (shallow.scene.objects.len(), warnings(&shallow).len()),
        (1, 0)
    );
    for top in [199, 70, 64] {
        let deep = load(drawing(
            &blocks,
            &format!("0 INSERT; 2 b{top}; 0 INSERT; 2 b0"),
        ));
        assert_eq!(names(&deep), ["b0/0"], "{top}");
        assert!(
            warnings(&deep)[0].contains("more than 64 blocks deep"),
            "{top}"
        );
    }
    // The depth from below equals the depth from above.
    let inserts: String = (0..200).map(|i| format!("0 INSERT; 2 b{i};")).collect();
    let loaded = load(drawing(&blocks, &inserts));
    assert_eq!(loaded.scene.objects.len(), 63);
}

#[test]
fn expansion_bombs_are_refused() {
    let mut blocks = block("b0", "", &triangle("8 0"));
    for i in 1..20 {
        blocks += &block(
            &format!("b{i}"),
            "",
            &format!("0 INSERT; 2 b{}; 70 1000; 71 1000", i - 1),
        );
    }
    let message = try_load(drawing(&blocks, "0 INSERT; 2 b19"), &Memory::new())
        .unwrap_err()
        .to_string();
    assert!(
        message.starts_with("a.dxf: found instances, arrays or curves that expand to more than"),
        "{message}"
    );
    // A large array of an empty block costs nothing.
    let empty = blocks.replace("3DFACE", "POINT");
    assert_eq!(
        load(drawing(&empty, "0 INSERT; 2 b19")).scene.objects.len(),
        0
    );
}

/// Objects and their names count, not only what their meshes have: each INSERT of a small block is an object.
#[test]
fn objects_and_their_names_count() {
    let is_read = |text: &str, most_elements: u64| {
        let options = ReadOptions {
            most_elements,
            ..ReadOptions::default()
        };
        read(text.as_bytes(), "a.dxf", &Memory::new(), &options).is_ok()
    };
    // A thousand triangles of 3 vertices, 3 corners, the object and the INSERT.
    let array = |names: [&str; 2]| {
        let blocks = block(names[0], "", &triangle("8 0"))
            + &block(
                names[1],
                "",
                &format!("0 INSERT; 2 {}; 70 100; 71 10", names[0]),
            );
        drawing(&blocks, &format!("0 INSERT; 2 {}", names[1]))
    };
    let short = array(["a", "b"]);
    let cost = 1000 * (3 + 3 + 32 + 8) + 8;
    assert!(is_read(&short, cost + 1000 * 5 / 24) && !is_read(&short, cost));
    let long = array(["a", &"b".repeat(100)]);
    assert!(is_read(&long, cost + 1000 * 104 / 24) && !is_read(&long, cost + 4000));
    // Blocks in blocks: two million objects of a file of 2 kB.
    let mut blocks = block("b0", "", &triangle("8 0"));
    for i in 1..22 {
        let two = format!("0 INSERT; 2 b{}; ", i - 1).repeat(2);
        blocks += &block(&format!("b{i}"), "", &two);
    }
    let doubled = |top: u32| drawing(&blocks, &format!("0 INSERT; 2 b{top}"));
    let most = ReadOptions::default().most_elements;
    assert!(is_read(&doubled(10), most) && !is_read(&doubled(21), most));
}

#[test]
fn overflow_leaves_the_object_out() {
    let mut blocks = block("b0", "", &triangle("8 0"));
    for i in 1..5 {
        blocks += &block(
            &format!("b{i}"),
            "",
            &format!("0 INSERT; 2 b{}; 41 1e99; 42 1e99", i - 1),
        );
    }
    let loaded = load(drawing(&blocks, "0 INSERT; 2 b4; 0 INSERT; 2 b0"));
    assert_eq!(names(&loaded), ["b0/0"]);
    assert_eq!(
        warnings(&loaded),
        [": surfaces whose coordinates overflow, by nested scales: left out"]
    );
}

const LAYERS: &str = "0 TABLE; 2 LAYER; 70 9;
    0 LAYER; 2 0; 70 0; 62 7; 0 LAYER; 2 red; 70 0; 62 1; 0 LAYER; 2 off; 62 -3;
    0 LAYER; 2 frozen; 70 1; 62 5; 0 LAYER; 2 Paint; 62 1; 420 255; 0 ENDTAB";

/// Names of objects and materials of a drawing with the layers above.
fn check_layers(blocks: &str, entities: &str, objects: &[&str], expected: &[&str]) {
    let loaded = load(file(&[
        ("TABLES", LAYERS),
        ("BLOCKS", blocks),
        ("ENTITIES", entities),
    ]));
    assert_eq!(
        (&*names(&loaded), &*materials(&loaded)),
        (objects, expected),
        "{entities}"
    );
}

#[test]
fn colours_of_entities() {
    let check =
        |groups: &str, expected: &str| check_layers("", &triangle(groups), &["red"], &[expected]);
    check("8 RED", "red");
    check("8 red; 62 256", "red");
    check("8 red; 62 1", "red");
    check("8 red; 62 0", "red/7");
    check("8 red; 62 33", "red/33");
    check("8 red; 62 33; 420 16744448", "red/#ff8000");
    let color = |groups: &str| {
        let loaded = load(file(&[("TABLES", LAYERS), ("ENTITIES", &triangle(groups))]));
        loaded.scene.materials[0].diffuse
    };
    assert_eq!(color("8 red"), Rgb::new(1.0, 0.0, 0.0));
    assert_eq!(color("8 paint"), Rgb::new(0.0, 0.0, 1.0));
    assert_eq!(color("8 0"), Rgb::grey(0.5));
    assert_eq!(color("8 never described"), Rgb::grey(0.5));
    assert_eq!(color("8 0; 62 5"), Rgb::new(0.0, 0.0, 1.0));
}

#[test]
fn colours_in_blocks() {
    let check = |groups: &str, insert: &str, object: &str, material: &str| {
        let blocks = block("a", "", &triangle(groups));
        check_layers(
            &blocks,
            &format!("0 INSERT; 2 a; {insert}"),
            &[object],
            &[material],
        );
    };
    // Layer 0 is the layer of the INSERT, also for colours by layer.
    check("8 0", "8 red", "a/red", "red");
    check("8 0; 62 5", "8 red", "a/red", "red/5");
    check("8 paint", "8 red; 62 5", "a/Paint", "Paint");
    // By block: the colour of the INSERT.
    check("8 paint; 62 0", "8 red; 62 5", "a/Paint", "Paint/5");
    check("8 paint; 62 0", "8 red", "a/Paint", "Paint/1");
    check("8 0; 62 0", "8 red; 62 0", "a/red", "red/7");
    // Through two levels.
    let blocks =
        block("a", "", &triangle("8 0; 62 0")) + &block("b", "", "0 INSERT; 2 a; 8 0; 62 0");
    check_layers(
        &blocks,
        "0 INSERT; 2 b; 8 red; 62 4",
        &["b/a/red"],
        &["red/4"],
    );
}

#[test]
fn hidden_layers() {
    let faces = ["8 red", "8 off", "8 frozen"].map(triangle).concat();
    let loaded = load(file(&[("TABLES", LAYERS), ("ENTITIES", &faces)]));
    assert_eq!(names(&loaded), ["red"]);
    assert_eq!(
        warnings(&loaded),
        [
            ": layer \"off\" is off or frozen: its content is left out",
            ": layer \"frozen\" is off or frozen: its content is left out",
        ]
    );
    // A block on a layer that is off shows its entities on other layers, on a frozen one none.
    let blocks = block("a", "", &["8 0", "8 red", "8 off"].map(triangle).concat());
    check_layers(&blocks, "0 INSERT; 2 a; 8 off", &["a/red"], &["red"]);
    check_layers(&blocks, "0 INSERT; 2 a; 8 frozen", &[], &[]);
}

#[test]
fn one_object_for_each_layer() {
    let faces = ["8 a", "8 b; 62 1", "8 A; 62 3", "8 b"]
        .map(triangle)
        .concat();
    let loaded = load(entities(&faces));
    assert_eq!(
        (names(&loaded), materials(&loaded)),
        (vec!["a", "b"], vec!["a", "a/3", "b/1", "b"])
    );
    assert_eq!(mesh(&loaded, 0).face_materials, [0, 1]);
    assert_eq!(mesh(&loaded, 1).face_materials, [2, 3]);
}

/// The materials of a red triangle with these groups, and of these MATERIALs.
fn finished(groups: &str, objects: &str) -> Vec<Material> {
    let sections = [
        ("ENTITIES", triangle(&format!("62 1; {groups}"))),
        ("OBJECTS", objects.to_owned()),
    ];
    load(file(&sections.each_ref().map(|(n, t)| (*n, t.as_str()))))
        .scene
        .materials
}

#[test]
fn described_materials() {
    let check = |material: &str, expected: Material| {
        assert_eq!(finished("347 1F", material), [expected], "{material}")
    };
    let red = Rgb::new(1.0, 0.0, 0.0);
    check(
        "0 MATERIAL; 5 1f; 1 Global; 71 1; 91 0",
        Material::diffuse("0/1", red),
    );
    check("0 MATERIAL; 5 1F; 1 ByLayer", Material::diffuse("0/1", red));
    check("0 MATERIAL; 5 20; 1 other", Material::diffuse("0/1", red));
    check("0 MATERIAL; 5 1F; 1 paint", Material::diffuse("paint", red));
    check(
        "0 MATERIAL; 5 1F; 1 paint; 41 0.5",
        Material::diffuse("paint", red * 0.5),
    );
    // 0xc2 before red, green and blue, as a signed number.
    check(
        "0 MATERIAL; 5 1F; 1 paint; 71 1; 91 -1040122112",
        Material::diffuse("paint", Rgb::new(0.0, 1.0, 0.0)),
    );
    check(
        "0 MATERIAL; 5 1F; 1 pane; 140 0.1; 145 1.5",
        Material::dielectric("pane", 1.5),
    );
    check(
        "0 MATERIAL; 5 1F; 1 gauze; 140 0.1",
        Material::diffuse("gauze", red),
    );
}

#[test]
fn materials_of_layers_and_blocks() {
    let objects = "0 MATERIAL; 5 A; 1 brick; 0 MATERIAL; 5 B; 1 ByBlock; 0 MATERIAL; 5 C; 1 wood";
    let text = file(&[
        ("TABLES", "0 LAYER; 2 walls; 62 1; 347 A"),
        (
            "BLOCKS",
            &block(
                "a",
                "",
                &(triangle("8 0; 347 B") + &triangle("8 walls") + &triangle("8 0; 62 5")),
            ),
        ),
        ("ENTITIES", "0 INSERT; 2 a; 8 walls; 347 C"),
        ("OBJECTS", objects),
    ]);
    assert_eq!(materials(&load(text)), ["wood", "brick", "brick"]);
}
