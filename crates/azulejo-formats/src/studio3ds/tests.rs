use super::read;
use crate::reader_tests::mesh;
use crate::surface::phong::Highlight;
use crate::{Loaded, Memory, ReadOptions};
use azulejo_scene::{LightKind, OpacityChannel, OpacityPicture, Rgb, Sidedness, Up};
use glam::{DVec2, DVec3};

/// A chunk with its data and children.
fn chunk(id: u16, body: &[u8]) -> Vec<u8> {
    let length = body.len() as u32 + 6;
    [&id.to_le_bytes()[..], &length.to_le_bytes(), body].concat()
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn shorts(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn name(name: &str) -> Vec<u8> {
    [name.as_bytes(), b"\0"].concat()
}

/// A file with these chunks in its editor section, followed by `rest`.
fn file(editor: &[Vec<u8>], rest: &[Vec<u8>]) -> Vec<u8> {
    let editor = chunk(0x3d3d, &editor.concat());
    chunk(0x4d4d, &[editor, rest.concat()].concat())
}

fn object(object: &str, chunks: &[Vec<u8>]) -> Vec<u8> {
    chunk(0x4000, &[name(object), chunks.concat()].concat())
}

fn vertices(positions: &[[f32; 3]]) -> Vec<u8> {
    let count = shorts(&[positions.len() as u16]);
    chunk(0x4110, &[count, floats(positions.as_flattened())].concat())
}

fn faces(corners: &[[u16; 3]], children: &[Vec<u8>]) -> Vec<u8> {
    let entries = corners.iter().flat_map(|&[a, b, c]| shorts(&[a, b, c, 7]));
    let list = [shorts(&[corners.len() as u16]), entries.collect()].concat();
    chunk(0x4120, &[list, children.concat()].concat())
}

/// A square of two triangles in the ground plane.
const SQUARE: [[f32; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
const HALVES: [[u16; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

fn square(called: &str) -> Vec<u8> {
    let mesh = [vertices(&SQUARE), faces(&HALVES, &[])].concat();
    object(called, &[chunk(0x4100, &mesh)])
}

fn load(bytes: &[u8]) -> Loaded {
    let loaded = read(bytes, "a.3ds", &Memory::new(), &ReadOptions::default()).unwrap();
    loaded.scene.validate().unwrap();
    loaded
}

/// Checks the warnings and their counts.
fn check_warnings(loaded: &Loaded, expected: &[(&str, usize)]) {
    let warnings = loaded.warnings.iter();
    let warnings: Vec<_> = warnings.map(|w| (w.message.as_str(), w.count)).collect();
    assert_eq!(warnings, expected);
}

fn check_error(bytes: &[u8], expected: &str) {
    let error = read(bytes, "a.3ds", &Memory::new(), &ReadOptions::default()).unwrap_err();
    assert_eq!(error.to_string(), expected);
}

#[test]
fn a_mesh() {
    let loaded = load(&file(&[square("floor")], &[]));
    check_warnings(&loaded, &[]);
    assert_eq!(loaded.scene.objects[0].name, "floor");
    assert_eq!(loaded.scene.units.up, Up::Z);
    let mesh = mesh(&loaded, 0);
    assert_eq!(mesh.positions[2], DVec3::new(1.0, 1.0, 0.0));
    assert_eq!(mesh.faces.corners, [0, 1, 2, 0, 2, 3]);
    assert_eq!(loaded.scene.materials[0].diffuse, Rgb::grey(0.5));
    assert!(mesh.normals.is_none() && mesh.uvs.is_none() && mesh.smoothing.is_empty());
}

#[test]
fn what_is_no_model() {
    check_error(
        b"",
        "a.3ds: byte 0 (0x0): found the end of the file, expected a 3DS model, which begins with chunk 4D4D",
    );
    check_error(
        &chunk(0x3daa, &[]),
        "a.3ds: byte 0 (0x0): found a material library of 3D Studio (MLI), expected a 3DS model, which begins with chunk 4D4D",
    );
    check_error(
        &chunk(0xc23d, &[]),
        "a.3ds: byte 0 (0x0): found a project of 3D Studio (PRJ), expected a 3DS model, which begins with chunk 4D4D",
    );
    check_error(
        b"\x01\x02",
        "a.3ds: byte 0 (0x0): found chunk 0201, expected a 3DS model, which begins with chunk 4D4D",
    );
}

#[test]
fn an_empty_model_says_so() {
    check_warnings(
        &load(&file(&[], &[])),
        &[("no faces: the scene is empty", 1)],
    );
    let bare = object("bare", &[chunk(0x4100, &vertices(&SQUARE))]);
    let loaded = load(&file(&[bare], &[]));
    check_warnings(
        &loaded,
        &[
            ("mesh without faces: skipped", 1),
            ("no faces: the scene is empty", 1),
        ],
    );
}

#[test]
fn a_file_that_ends_too_soon() {
    let whole = file(&[square("a"), square("b")], &[]);
    let loaded = load(&whole[..whole.len() - 9]);
    assert_eq!(loaded.scene.objects.len(), 1);
    check_warnings(
        &loaded,
        &[
            ("chunk 4D4D longer than its parent: truncated", 1),
            ("chunk 3D3D longer than its parent: truncated", 1),
            ("chunk 4000 longer than its parent: truncated", 1),
            ("chunk 4100 longer than its parent: truncated", 1),
            ("chunk 4120 longer than its parent: truncated", 1),
            ("faces missing from a truncated list", 2),
            ("mesh without faces: skipped", 1),
        ],
    );
    for end in 2..whole.len() {
        load(&whole[..end]);
    }
}

#[test]
fn damaged_chunks() {
    let odd = [
        chunk(0x1234, b"?"),
        [shorts(&[0x9999]), 3u32.to_le_bytes().to_vec()].concat(),
        b"lost".to_vec(),
    ];
    let loaded = load(&file(&[vec![square("floor")], odd.to_vec()].concat(), &[]));
    check_warnings(
        &loaded,
        &[
            ("unknown (chunk 1234): skipped", 1),
            (
                "chunk 9999 shorter than its own header: the rest of its parent is skipped",
                1,
            ),
        ],
    );
    let mut trailing = file(&[square("floor")], &[]);
    trailing.extend(b"tail");
    check_warnings(&load(&trailing), &[("4 bytes after the model: skipped", 1)]);
}

#[test]
fn faces_that_cannot_be_are_counted() {
    let lists = [
        vertices(&SQUARE),
        faces(&[[0, 1, 2], [0, 1, 4], [9, 1, 2]], &[]),
    ];
    let loaded = load(&file(
        &[object("o", &[chunk(0x4100, &lists.concat())])],
        &[],
    ));
    assert_eq!(mesh(&loaded, 0).faces.len(), 1);
    check_warnings(
        &loaded,
        &[("face with a vertex index out of range: skipped", 2)],
    );
}

fn color(id: u16, rgb: [u8; 3]) -> Vec<u8> {
    chunk(id, &chunk(0x0011, &rgb))
}

fn percent(id: u16, percent: u16) -> Vec<u8> {
    chunk(id, &chunk(0x0030, &shorts(&[percent])))
}

fn material(called: &str, entries: &[Vec<u8>]) -> Vec<u8> {
    chunk(
        0xafff,
        &[chunk(0xa000, &name(called)), entries.concat()].concat(),
    )
}

/// A list of the faces of one material.
fn material_faces(material: &str, faces: &[u16]) -> Vec<u8> {
    let count = shorts(&[faces.len() as u16]);
    chunk(0x4130, &[name(material), count, shorts(faces)].concat())
}

/// A square with these face materials, and texture coordinates equal to its positions.
fn painted(lists: &[Vec<u8>]) -> Vec<u8> {
    let uvs = floats(&[0., 0., 1., 0., 1., 1., 0., 1.]);
    let uvs = chunk(0x4140, &[shorts(&[4]), uvs].concat());
    let mesh = [vertices(&SQUARE), uvs, faces(&HALVES, lists)].concat();
    object("painted", &[chunk(0x4100, &mesh)])
}

#[test]
fn materials_of_faces() {
    let red = material(
        "red",
        &[
            color(0xa020, [255, 0, 0]),
            percent(0xa084, 50),
            chunk(0xa081, &[]),
        ],
    );
    let lists = [material_faces("red", &[1]), material_faces("lost", &[0, 7])];
    let loaded = load(&file(&[painted(&lists), red], &[]));
    assert_eq!(mesh(&loaded, 0).face_materials, [1, 0]);
    let [red, lost] = loaded.scene.materials.as_slice() else {
        panic!("two materials")
    };
    assert_eq!(red.diffuse, Rgb::new(1.0, 0.0, 0.0));
    assert_eq!(
        (red.emission, red.emits_back),
        (Rgb::new(0.5, 0.0, 0.0), true)
    );
    assert_eq!(red.sidedness, Sidedness::Two);
    assert_eq!(lost.sidedness, Sidedness::Unsaid);
    assert_eq!((lost.name.as_str(), lost.diffuse), ("lost", Rgb::grey(0.5)));
    check_warnings(
        &loaded,
        &[
            ("undefined material \"lost\": grey with reflectance 0.5", 1),
            ("material assigned to a face index out of range: skipped", 1),
        ],
    );
}

#[test]
fn gloss_glass_and_maps_are_said() {
    let glossy = material(
        "glossy",
        &[
            color(0xa020, [51, 51, 51]),
            color(0xa030, [255, 255, 255]),
            percent(0xa040, 50),
            percent(0xa041, 25),
            percent(0xa050, 30),
            chunk(0xa230, &[]),
        ],
    );
    let loaded = load(&file(
        &[painted(&[material_faces("glossy", &[0, 1])]), glossy],
        &[],
    ));
    let highlight = Highlight::of(&loaded.scene.materials[0]);
    assert_eq!(highlight, Some(Highlight::mirrored(32.0, Rgb::grey(0.25))));
    check_warnings(&loaded, &[("bump map (chunk A230): skipped", 1)]);
    let opacity = loaded.scene.materials[0].opacity.unwrap();
    assert!((opacity.constant - 0.7).abs() < 1e-12 && opacity.picture.is_none());
}

/// The brightness of an opacity map multiplies what chunk A050 leaves.
#[test]
fn opacity_maps() {
    let map = chunk(0xa300, &name("LEAF.TGA"));
    let leaf = material("leaf", &[percent(0xa050, 50), chunk(0xa210, &map)]);
    let tga = crate::picture::tga::tests::file(3, 1, 8, 0, &[], &[255, 0]);
    let files = Memory::new().with("leaf.tga", tga);
    let bytes = file(&[painted(&[material_faces("leaf", &[0, 1])]), leaf], &[]);
    let loaded = read(&bytes, "a.3ds", &files, &ReadOptions::default()).unwrap();
    let opacity = loaded.scene.materials[0].opacity.unwrap();
    let picture = OpacityPicture {
        texture: 0,
        channel: OpacityChannel::Luminance,
    };
    assert_eq!((opacity.constant, opacity.picture), (0.5, Some(picture)));
    assert!(loaded.scene.textures[0].image.is_some());
    check_warnings(&loaded, &[]);
}

/// A material with a transformed texture.
fn pictured(called: &str, entries: &[Vec<u8>]) -> Vec<u8> {
    let file = chunk(0xa300, &name("C:\\MAPS\\WOOD.PNG"));
    let map = [chunk(0x0030, &shorts(&[100])), file, entries.concat()].concat();
    material(called, &[color(0xa020, [10, 20, 30]), chunk(0xa200, &map)])
}

#[test]
fn pictures_and_their_places() {
    let mut png = Vec::new();
    crate::picture::png::write(1, 1, &[255, 0, 0], &mut png).unwrap();
    let files = Memory::new().with("wood.png", png);
    let plain = pictured("plain", &[]);
    let scaled = pictured(
        "scaled",
        &[
            chunk(0xa356, &floats(&[2.0])),
            chunk(0xa354, &floats(&[3.0])),
            chunk(0xa358, &floats(&[0.5])),
        ],
    );
    let lists = [
        material_faces("plain", &[0]),
        material_faces("scaled", &[1]),
    ];
    let bytes = file(&[plain, scaled, painted(&lists)], &[]);
    let loaded = read(&bytes, "a.3ds", &files, &ReadOptions::default()).unwrap();
    loaded.scene.validate().unwrap();
    check_warnings(&loaded, &[]);
    assert_eq!(loaded.scene.textures.len(), 1);
    assert_eq!(loaded.scene.materials[1].textures, [0]);
    assert_eq!(loaded.scene.materials[1].diffuse, Rgb::WHITE);
    let mesh = mesh(&loaded, 0);
    let uvs = mesh.uvs.as_ref().unwrap();
    assert_eq!(uvs.at(2, 2), DVec2::ONE);
    // The second face has the same vertex with another coordinate.
    assert_eq!(uvs.at(4, 2), DVec2::new(0.5, 2.0));

    let without = load(&bytes);
    assert_eq!(
        without.scene.materials[0].diffuse,
        Rgb::new(10.0, 20.0, 30.0) / 255.0
    );
    check_warnings(
        &without,
        &[(
            "picture \"C:/MAPS/WOOD.PNG\" is not used: there is no such file",
            1,
        )],
    );
}

#[test]
fn a_picture_is_turned_around_its_middle() {
    let turned = pictured("turned", &[chunk(0xa35c, &floats(&[90.0]))]);
    let loaded = load(&file(
        &[turned, painted(&[material_faces("turned", &[0, 1])])],
        &[],
    ));
    let uvs = mesh(&loaded, 0).uvs.as_ref().unwrap();
    assert!((uvs.at(0, 0) - DVec2::new(0.0, 1.0)).length() < 1e-12);
    assert!(uvs.corners.is_none());
}

/// A square folded along its diagonal, with smoothing masks.
fn folded(masks: [u32; 2], materials: &[Vec<u8>]) -> Vec<u8> {
    let mut corners = SQUARE;
    corners[3][2] = 1.0;
    let masks = chunk(0x4150, masks.map(u32::to_le_bytes).as_flattened());
    let children = [vec![masks], materials.to_vec()].concat();
    let mesh = [vertices(&corners), faces(&HALVES, &children)].concat();
    object("folded", &[chunk(0x4100, &mesh)])
}

#[test]
fn smoothing_groups() {
    for groups in [[4, 4], [4, 2], [0, 6], [0, 0]] {
        let loaded = load(&file(&[folded(groups, &[])], &[]));
        assert_eq!(mesh(&loaded, 0).smoothing, groups);
        assert!(mesh(&loaded, 0).normals.is_none());
    }
    // Faces with one of several bits in common are smooth, but not a single group.
    let shared = load(&file(&[folded([6, 2], &[])], &[]));
    let normals = mesh(&shared, 0).normals.as_ref().unwrap();
    assert_eq!(normals.at(0, 0), normals.at(3, 0));
    assert!(mesh(&shared, 0).smoothing.is_empty());

    let flat = material("flat", &[chunk(0xa100, &shorts(&[1]))]);
    let flat = load(&file(
        &[flat, folded([4, 4], &[material_faces("flat", &[0, 1])])],
        &[],
    ));
    assert!(mesh(&flat, 0).normals.is_none());
    assert_eq!(mesh(&flat, 0).smoothing, [0, 0]);
}

/// A track with one key.
fn track(id: u16, values: &[f32]) -> Vec<u8> {
    let mut body = vec![0; 10];
    body.extend(1u32.to_le_bytes());
    body.extend([0; 4]);
    // Tension and bias precede the value.
    body.extend(shorts(&[0b101]));
    body.extend(floats(&[9.0, 9.0]));
    body.extend(floats(values));
    chunk(id, &body)
}

fn node(kind: u16, id: u16, called: &str, parent: i16, entries: &[Vec<u8>]) -> Vec<u8> {
    let header = [name(called), shorts(&[0, 0, parent as u16])].concat();
    let body = [
        chunk(0xb030, &shorts(&[id])),
        chunk(0xb010, &header),
        entries.concat(),
    ];
    chunk(kind, &body.concat())
}

fn keyframer(nodes: &[Vec<u8>]) -> Vec<u8> {
    chunk(0xb000, &nodes.concat())
}

fn instance(called: &str) -> Vec<u8> {
    chunk(0xb011, &name(called))
}

#[test]
fn instances_under_a_dummy() {
    let nodes = [
        // A child may precede its parent.
        node(
            0xb002,
            5,
            "wheel",
            9,
            &[instance("left"), track(0xb020, &[1., 0., 0.])],
        ),
        node(
            0xb002,
            6,
            "wheel",
            9,
            &[
                track(0xb020, &[2., 0., 0.]),
                chunk(0xb013, &floats(&[1., 0., 0.])),
            ],
        ),
        node(
            0xb002,
            9,
            "$$$DUMMY",
            -1,
            &[instance("cart"), track(0xb020, &[0., 0., 7.])],
        ),
    ];
    let loaded = load(&file(
        &[square("wheel"), square("still")],
        &[keyframer(&nodes)],
    ));
    check_warnings(&loaded, &[]);
    let names: Vec<&str> = loaded
        .scene
        .objects
        .iter()
        .map(|o| o.name.as_str())
        .collect();
    assert_eq!(names, ["cart/left", "cart/wheel", "still"]);
    assert_eq!(mesh(&loaded, 0).positions[0], DVec3::new(1.0, 0.0, 7.0));
    assert_eq!(mesh(&loaded, 1).positions[0], DVec3::new(1.0, 0.0, 7.0));
    assert_eq!(mesh(&loaded, 2).positions[0], DVec3::ZERO);
}

#[test]
fn rotation_is_clockwise_and_scale_comes_first() {
    let quarter = std::f32::consts::FRAC_PI_2;
    let nodes = [node(
        0xb002,
        0,
        "floor",
        -1,
        &[
            track(0xb020, &[0., 0., 0.]),
            track(0xb021, &[quarter, 0., 0., 1.]),
            track(0xb022, &[3., 1., 1.]),
        ],
    )];
    let loaded = load(&file(&[square("floor")], &[keyframer(&nodes)]));
    let moved = mesh(&loaded, 0).positions[1];
    assert!(
        (moved - DVec3::new(0.0, -3.0, 0.0)).length() < 1e-6,
        "{moved}"
    );
}

/// A square stored through a local frame, with a node that inverts and repeats it.
fn framed(frame: [f32; 12], position: [f32; 3], scale: [f32; 3]) -> Loaded {
    let lists = [
        vertices(&SQUARE),
        faces(&HALVES, &[]),
        chunk(0x4160, &floats(&frame)),
    ];
    let nodes = [node(
        0xb002,
        0,
        "o",
        -1,
        &[track(0xb020, &position), track(0xb022, &scale)],
    )];
    let object = object("o", &[chunk(0x4100, &lists.concat())]);
    load(&file(&[object], &[keyframer(&nodes)]))
}

#[test]
fn the_local_frame_is_undone() {
    let frame = [2., 0., 0., 0., 2., 0., 0., 0., 2., 5., 5., 5.];
    let same = framed(frame, [5., 5., 5.], [2.; 3]);
    assert_eq!(mesh(&same, 0).positions[2], DVec3::new(1.0, 1.0, 0.0));
    let nearly = framed(frame, [5., 5., 5.000001], [2.; 3]);
    assert_eq!(mesh(&nearly, 0).positions[2], DVec3::new(1.0, 1.0, 0.0));
    let moved = framed(frame, [5., 5., 6.], [2.; 3]);
    assert_eq!(mesh(&moved, 0).positions[2], DVec3::new(1.0, 1.0, 1.0));
}

/// Some programs write frames that say nothing, and pivots that count from the middle of the mesh's box.
#[test]
fn a_lost_frame_begins_in_the_middle_of_the_mesh() {
    let quarter = std::f32::consts::FRAC_PI_2;
    let pivot = chunk(0xb013, &floats(&[-0.5, 0.0, 0.0]));
    let turned = track(0xb021, &[quarter, 0., 0., 1.]);
    let placed = |position: [f32; 3], more: &[Vec<u8>]| {
        let entries = [&[pivot.clone(), track(0xb020, &position)], more].concat();
        let nodes = [node(0xb002, 0, "door", -1, &entries)];
        let loaded = load(&file(&[square("door")], &[keyframer(&nodes)]));
        mesh(&loaded, 0).positions.clone()
    };
    let stored = SQUARE.map(|p| DVec3::from(p.map(f64::from)));
    assert_eq!(placed([0.0, 0.5, 0.0], &[]), stored);
    // A door turns about its hinge.
    let opened = placed([0.0, 0.5, 0.0], &[turned]);
    assert!(
        (opened[1] - DVec3::new(-0.5, -0.5, 0.0)).length() < 1e-6,
        "{opened:?}"
    );
    // Elsewhere the frame is taken as it is.
    assert_eq!(placed([3.0, 0.5, 0.0], &[])[0], DVec3::new(3.5, 0.5, 0.0));
}

#[test]
fn a_mirrored_frame_keeps_fronts() {
    let frame = [-1., 0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0.];
    let same = framed(frame, [0.; 3], [1.; 3]);
    assert_eq!(mesh(&same, 0).face_area_vector(0).z, 0.5);
    assert_eq!(mesh(&same, 0).positions[1], DVec3::X);
    let mirrored = framed(frame, [0.; 3], [-1., 1., 1.]);
    assert_eq!(mesh(&mirrored, 0).positions[1], DVec3::NEG_X);
    assert_eq!(mesh(&mirrored, 0).face_area_vector(0).z, 0.5);
}

#[test]
fn a_flat_frame_leaves_what_is_stored() {
    let loaded = framed([0.; 12], [7.; 3], [1.; 3]);
    assert_eq!(mesh(&loaded, 0).positions[1], DVec3::X);
    check_warnings(
        &loaded,
        &[("mesh whose local frame is singular: placed as stored", 1)],
    );
}

#[test]
fn parents_in_a_circle_or_missing() {
    let nodes = [
        node(0xb002, 0, "a", 1, &[track(0xb020, &[1., 0., 0.])]),
        node(0xb002, 1, "b", 0, &[track(0xb020, &[1., 0., 0.])]),
        node(0xb002, 2, "c", 77, &[]),
    ];
    let loaded = load(&file(
        &[square("a"), square("b"), square("c")],
        &[keyframer(&nodes)],
    ));
    assert_eq!(loaded.scene.objects[0].name, "b/a");
    check_warnings(
        &loaded,
        &[
            (
                "keyframer node whose parent is missing: placed at the root",
                1,
            ),
            (
                "keyframer node that is its own ancestor: placed at the root",
                1,
            ),
        ],
    );
}

#[test]
fn too_many_instances() {
    let nodes = vec![node(0xb002, 0, "a", -1, &[]); 40];
    let bytes = file(&[square("a")], &[keyframer(&nodes)]);
    let options = ReadOptions {
        most_elements: 300,
        ..ReadOptions::default()
    };
    let error = read(&bytes, "a.3ds", &Memory::new(), &options).unwrap_err();
    assert!(error.to_string().contains("more than 300"), "{error}");
    assert_eq!(load(&bytes).scene.objects.len(), 40);
}

#[test]
fn hidden_objects_and_nodes_are_left_out() {
    let mut hidden = node(0xb002, 0, "a", -1, &[]);
    // The flags follow two headers, the id and the name.
    let flags = 6 + 8 + 6 + 2;
    hidden[flags + 1] = 0x08;
    let mesh = [vertices(&SQUARE), faces(&HALVES, &[])].concat();
    let secret = object("secret", &[chunk(0x4010, &[]), chunk(0x4100, &mesh)]);
    let loaded = load(&file(&[square("a"), secret], &[keyframer(&[hidden])]));
    assert!(loaded.scene.objects.is_empty());
    check_warnings(
        &loaded,
        &[
            ("hidden object: skipped", 1),
            ("hidden node: skipped", 1),
            ("no faces: the scene is empty", 1),
        ],
    );
}

fn light(position: [f32; 3], entries: &[Vec<u8>]) -> Vec<u8> {
    let white = chunk(0x0010, &floats(&[1., 0.5, 0.25]));
    let body = [floats(&position), white, entries.concat()].concat();
    object("lamp", &[chunk(0x4600, &body)])
}

#[test]
fn lights() {
    let omni = light([1., 2., 3.], &[chunk(0x465b, &floats(&[4.]))]);
    let off = light([0.; 3], &[chunk(0x4620, &[])]);
    let dark = light([0.; 3], &[chunk(0x465b, &floats(&[-1.]))]);
    let cone = chunk(0x4610, &floats(&[0., 0., 0., 40., 90.]));
    let spot = light([0., 0., 5.], &[cone, chunk(0x4625, &[])]);
    let loaded = load(&file(&[square("floor"), omni, off, dark, spot], &[]));
    let kinds: Vec<LightKind> = loaded.scene.lights.iter().map(|l| l.kind.clone()).collect();
    let intensity = Rgb::new(1.0, 0.5, 0.25);
    let expected = [
        LightKind::Point {
            position: DVec3::new(1.0, 2.0, 3.0),
            intensity: 4.0 * intensity,
        },
        LightKind::Spot {
            position: DVec3::new(0.0, 0.0, 5.0),
            direction: DVec3::NEG_Z,
            intensity,
            inner: 20f64.to_radians(),
            outer: 45f64.to_radians(),
        },
    ];
    assert_eq!(kinds, expected);
    check_warnings(
        &loaded,
        &[
            ("light that is off: skipped", 1),
            (
                "light with a negative colour or a position that is not finite: skipped",
                1,
            ),
            ("range of a light (chunk 4625): skipped", 1),
        ],
    );
}

#[test]
fn the_keyframer_moves_lights() {
    let lamp = light(
        [1., 2., 3.],
        &[chunk(0x4610, &floats(&[0., 0., 0., 40., 90.]))],
    );
    let nodes = [
        node(0xb007, 0, "lamp", -1, &[track(0xb020, &[0., 0., 9.])]),
        node(0xb006, 1, "lamp", -1, &[track(0xb020, &[0., 5., 9.])]),
    ];
    let loaded = load(&file(&[square("floor"), lamp], &[keyframer(&nodes)]));
    let LightKind::Spot {
        position,
        direction,
        ..
    } = loaded.scene.lights[0].kind
    else {
        panic!("a spotlight")
    };
    assert_eq!((position, direction), (DVec3::new(0.0, 0.0, 9.0), DVec3::Y));
}

#[test]
fn a_cone_without_an_angle_is_no_light() {
    for [hot_spot, fall_off] in [[40.0, f32::NAN], [f32::NAN, 90.0]] {
        let cone = chunk(0x4610, &floats(&[0., 0., 0., hot_spot, fall_off]));
        let loaded = load(&file(&[square("floor"), light([0., 0., 5.], &[cone])], &[]));
        assert!(loaded.scene.lights.is_empty());
        let warning = "light with a negative colour or a position that is not finite: skipped";
        check_warnings(&loaded, &[(warning, 1)]);
    }
}

fn camera(values: [f32; 8]) -> Vec<u8> {
    object("view", &[chunk(0x4700, &floats(&values))])
}

#[test]
fn cameras() {
    let plain = camera([0., -5., 0., 0., 0., 0., 0., 48.]);
    let banked = camera([0., -5., 0., 0., 0., 0., 90., 48.]);
    let blind = camera([1., 1., 1., 1., 1., 1., 0., 48.]);
    let loaded = load(&file(&[square("floor"), plain, banked, blind], &[]));
    let [plain, banked] = loaded.scene.cameras.as_slice() else {
        panic!("two cameras")
    };
    assert_eq!(
        (plain.eye, plain.target, plain.up),
        (DVec3::new(0.0, -5.0, 0.0), DVec3::ZERO, DVec3::Z)
    );
    let horizontal = 2.0 * ((0.5 * plain.vertical_fov).tan() * 4.0 / 3.0).atan();
    assert!((horizontal.to_degrees() - 50.0).abs() < 1e-9);
    // Clockwise as seen by the camera: up becomes right.
    assert!((banked.up - DVec3::X).length() < 1e-12, "{}", banked.up);
    check_warnings(
        &loaded,
        &[("camera without a viewing direction: skipped", 1)],
    );
}

#[test]
fn the_keyframer_turns_cameras() {
    let nodes = [node(
        0xb003,
        0,
        "view",
        -1,
        &[track(0xb023, &[90.]), track(0xb024, &[180.])],
    )];
    let still = camera([0., -5., 0., 0., 0., 0., 0., 48.]);
    let loaded = load(&file(&[square("floor"), still], &[keyframer(&nodes)]));
    let camera = &loaded.scene.cameras[0];
    assert!((camera.up - DVec3::NEG_Z).length() < 1e-12);
    assert!(((0.5 * camera.vertical_fov).tan() - 0.75).abs() < 1e-12);
}

#[test]
fn the_background() {
    let blue = chunk(0x1200, &chunk(0x0010, &floats(&[0., 0., 1.])));
    let used = load(&file(
        &[square("floor"), blue.clone(), chunk(0x1201, &[])],
        &[],
    ));
    assert_eq!(used.scene.background, Some(Rgb::new(0.0, 0.0, 1.0).into()));
    assert_eq!(
        load(&file(&[square("floor"), blue], &[])).scene.background,
        None
    );
}

#[test]
fn coordinates_far_from_the_origin_are_coarse() {
    // A square decimetre in a national grid: its corners are half a metre apart, or none.
    let far = |x: f32, y: f32| [500_000.25 + x, 5_400_000.5 + y, 300.0];
    let corners = [far(0.0, 0.0), far(0.1, 0.0), far(0.1, 0.1), far(0.0, 0.1)];
    let mesh = [vertices(&corners), faces(&HALVES, &[])].concat();
    let tile = object("tile", &[chunk(0x4100, &mesh)]);
    let expected = "coordinates as float32 at 5400000 are 0.5 apart, too much for the detail of a mesh: export it \
                    near the origin, or in double precision";
    check_warnings(
        &load(&file(&[tile, square("floor")], &[])),
        &[(expected, 1)],
    );
}
