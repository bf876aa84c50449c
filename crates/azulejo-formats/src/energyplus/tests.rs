//! Small rooms in both languages, damaged ones, and the positions of errors.

use super::read;
use crate::{Loaded, Memory, Position, ReadError, ReadOptions};
use azulejo_scene::{Mesh, Scene, Shape};
use glam::DVec3;
use proptest::prelude::*;

/// A room of 4 m × 3 m × 2.5 m with a window inside of its south wall and a door that reaches the floor,
/// in all the spellings that IDF allows.
const ROOM: &str = "\
! A room, with a comment; and a semicolon, in it
Version,25.1;
GlobalGeometryRules, UpperLeftCorner, Counterclockwise, Relative;
Building, House, 0;
ZONE,
  Room,   !- Name
  0, 10, 0, 1;
Material,
  Plaster, Rough, 0.01, 0.5, 1000, 900, 0.8;
Construction, Wall type, Brick, plaster;
buildingsurface:detailed,
  South,       !- Name
  Wall, Wall type, ROOM, , Outdoors, , SunExposed, WindExposed, autocalculate,
  4,           !- Number of Vertices
  0, 0, 2.5,   !- X,Y,Z ==> Vertex 1
  0, 0, 0,
  4, 0, 0,
  4, 0, 2.5;
BuildingSurface:Detailed, Floor, Floor, Wall type, Room, , Ground, , NoSun, NoWind, 0, 4,
  4,0,0, 0,0,0, 0,3,0, 4,3,0;
BuildingSurface:Detailed, Gable, Wall, Wall type, Room, , Outdoors, , , , , ,
  0,3,2.5, 0,3,0, 0,0,0, 0,0,2.5, 0,1.5,4;
FenestrationSurface:Detailed, Pane, Window, Double, South, , , , , 4, 1,0,2, 1,0,1, 2,0,1, 2,0,2;
Door, Entrance, Wood, SOUTH, 1, 2.5, 0, 1, 2;
";

fn load_as(text: &str, name: &str) -> Result<Loaded, ReadError> {
    let options = ReadOptions::default();
    let loaded = read(text.as_bytes(), name, &Memory::new(), &options);
    if let Ok(loaded) = &loaded {
        loaded.scene.validate().unwrap();
    }
    loaded
}

fn load(text: &str) -> Loaded {
    load_as(text, "a.idf").unwrap()
}

fn names(scene: &Scene) -> Vec<&str> {
    scene.objects.iter().map(|o| &*o.name).collect()
}

fn mesh<'s>(scene: &'s Scene, name: &str) -> &'s Mesh {
    let object = scene.objects.iter().find(|o| o.name == name);
    match &object.unwrap_or_else(|| panic!("no {name}")).shape {
        Shape::Mesh(mesh) => mesh,
        other => panic!("{other:?}"),
    }
}

fn messages(loaded: &Loaded) -> Vec<String> {
    loaded.warnings.iter().map(ToString::to_string).collect()
}

/// The area of an object, by the direction of its fronts.
fn area_vector(scene: &Scene, name: &str) -> DVec3 {
    let mesh = mesh(scene, name);
    (0..mesh.faces.len())
        .map(|f| mesh.face_area_vector(f))
        .sum()
}

fn check_area(scene: &Scene, name: &str, expected: [f64; 3]) {
    let actual = area_vector(scene, name);
    assert!(actual.distance(expected.into()) < 1e-9, "{name}: {actual}");
    let sum = mesh(scene, name).area();
    assert!((sum - actual.length()).abs() < 1e-9, "{name} is folded");
}

#[test]
fn a_room() {
    let loaded = load(ROOM);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let scene = &loaded.scene;
    assert_eq!(
        names(scene),
        ["South", "Pane", "Entrance", "Floor", "Gable"]
    );
    // Into the room, without the openings.
    check_area(scene, "South", [0.0, 7.0, 0.0]);
    check_area(scene, "Pane", [0.0, 1.0, 0.0]);
    check_area(scene, "Entrance", [0.0, 2.0, 0.0]);
    check_area(scene, "Floor", [0.0, 0.0, 12.0]);
    check_area(scene, "Gable", [9.75, 0.0, 0.0]);
    // The origin of the zone.
    let door = mesh(scene, "Entrance").bounds();
    assert_eq!(door.min, DVec3::new(12.5, 0.0, 1.0));
    assert_eq!(door.max, DVec3::new(13.5, 0.0, 3.0));
    let reflectance = |name: &str| {
        let material = scene.materials.iter().find(|m| m.name == name);
        (material.unwrap().diffuse.r * 100.0).round()
    };
    let reflectances = ["Wall type", "Double", "Wood"].map(reflectance);
    assert_eq!(reflectances, [20.0, 16.0, 10.0]);
}

#[test]
fn an_opening_inside_is_a_hole() {
    let text = ROOM.replace("Door, Entrance, Wood, SOUTH, 1, 2.5, 0, 1, 2;", "");
    let loaded = load(&text);
    let south = mesh(&loaded.scene, "South");
    assert_eq!((south.faces.len(), south.positions.len()), (1, 8));
    check_area(&loaded.scene, "South", [0.0, 9.0, 0.0]);
    assert!(loaded.warnings.is_empty());
}

/// The same room by the vertices of other conventions.
#[test]
fn conventions_of_vertices() {
    let expected = load(ROOM).scene;
    let south = "0, 0, 2.5,   !- X,Y,Z ==> Vertex 1\n  0, 0, 0,\n  4, 0, 0,\n  4, 0, 2.5;";
    let check = |rules: &str, corners: &str, pane: &str| {
        // Only the wall and its openings; the others would have to be turned, too.
        let text = ROOM
            .replace("UpperLeftCorner, Counterclockwise, Relative", rules)
            .replace(south, corners)
            .replace("1,0,2, 1,0,1, 2,0,1, 2,0,2;", pane);
        let loaded = load(&text);
        for name in ["South", "Pane", "Entrance"] {
            let actual = mesh(&loaded.scene, name);
            let before = mesh(&expected, name);
            assert_eq!(actual.bounds(), before.bounds(), "{rules} {name}");
            let turned = area_vector(&loaded.scene, name);
            assert!(
                turned.distance(area_vector(&expected, name)) < 1e-9,
                "{rules} {name}"
            );
        }
    };
    check(
        "LowerLeftCorner, CounterClockWise, Relative",
        "0,0,0, 4,0,0, 4,0,2.5, 0,0,2.5;",
        "1,0,1, 2,0,1, 2,0,2, 1,0,2;",
    );
    check(
        "LowerRightCorner, Counterclockwise, Relative",
        "4,0,0, 4,0,2.5, 0,0,2.5, 0,0,0;",
        "2,0,1, 2,0,2, 1,0,2, 1,0,1;",
    );
    check(
        "UpperRightCorner, Clockwise, Relative",
        "4,0,2.5, 4,0,0, 0,0,0, 0,0,2.5;",
        "2,0,2, 2,0,1, 1,0,1, 1,0,2;",
    );
    check(
        "ULC, CW, World",
        "10,0,3.5, 14,0,3.5, 14,0,1, 10,0,1;",
        "11,0,3, 12,0,3, 12,0,2, 11,0,2;",
    );
}

/// A roof that is upside down is turned, with its window, whichever corner comes first.
#[test]
fn a_window_of_a_turned_roof_keeps_its_place() {
    let window = |corner: &str, corners: &str| {
        let text = format!(
            "Version,25.1;\nGlobalGeometryRules, {corner}, Counterclockwise, Relative;\nZone, Z;\n\
             BuildingSurface:Detailed, R, Roof, C, Z, , Outdoors, , , , 0, 4, {corners};\nWindow, P, G, R, , 1, 1, 0.5, 1, 2;"
        );
        let loaded = load(&text);
        // Fronts face into the zone.
        assert!(area_vector(&loaded.scene, "R").z < 0.0);
        mesh(&loaded.scene, "P").bounds()
    };
    let [a, b, c, d] = ["0,0,0", "4,0,0", "4,3,2", "0,3,2"];
    let expected = window("UpperLeftCorner", &[c, b, a, d].join(","));
    assert_eq!(expected.min.x, 1.0);
    for (corner, corners) in [
        ("LowerLeftCorner", [b, a, d, c]),
        ("LowerRightCorner", [a, d, c, b]),
        ("UpperRightCorner", [d, c, b, a]),
    ] {
        let bounds = window(corner, &corners.join(","));
        let off = (bounds.min - expected.min).length() + (bounds.max - expected.max).length();
        assert!(off < 1e-9, "{corner}: {bounds:?}, {expected:?}");
    }
}

#[test]
fn zones_and_buildings_are_turned_clockwise() {
    let text = ROOM.replace("Room,   !- Name\n  0,", "Room,\n  90,");
    let scene = load(&text).scene;
    // What looked north looks east.
    check_area(&scene, "South", [7.0, 0.0, 0.0]);
    let wall = mesh(&scene, "South").bounds();
    assert_eq!(wall.min, DVec3::new(10.0, -4.0, 1.0));
    assert_eq!(wall.max, DVec3::new(10.0, 0.0, 3.5));
    let text = ROOM.replace("House, 0;", "House, 90;");
    let scene = load(&text).scene;
    let wall = mesh(&scene, "South").bounds();
    assert_eq!(wall.min, DVec3::new(0.0, -14.0, 1.0));
    // The world does not turn.
    let text = text.replace("Counterclockwise, Relative", "Counterclockwise, World");
    check_area(&load(&text).scene, "South", [0.0, 7.0, 0.0]);
}

/// A box of simple rectangles around a zone, and what shades it.
const RECTANGLES: &str = "
Version, 9.2;
Building, B, 30;
Zone, Z, 15, 1, 2, 3;
Wall:Exterior, S, C, Z, 180, 90, 0, 0, 0, 4, 2.5;
Wall:Adiabatic, E, C, Z, 90, 90, 4, 0, 0, 3, 2.5;
Wall:Underground, N, C, Z, 0, 90, 4, 3, 0, 4, 2.5;
Wall:Interzone, W, C, Z, Other, 270, 90, 0, 3, 0, 3, 2.5;
Roof, R, C, Z, 180, 0, 0, 0, 2.5, 4, 3;
Floor:GroundContact, F, C, Z, 90, 180, 4, 0, 0, 3, 4;
Window, Pane, G, S, , , 1, 0.5, 1, 2, 1;
Window:Interzone, Inner, G, W, X, 1, 0.5, 1, 2, 1;
GlazedDoor, Terrace, G, N, , , 1, 0.5, 0, 1, 2;
Shading:Site, Hill, 180, 90, -10, -20, 0, 30, 5;
Shading:Building, Wing, 180, 90, -10, -20, 0, 30, 5;
";

#[test]
fn rectangles() {
    let loaded = load(RECTANGLES);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let scene = &loaded.scene;
    let zone = ["S", "E", "N", "W", "R", "F", "Pane", "Inner", "Terrace"];
    let faces: f64 = zone.iter().map(|n| mesh(scene, n).area()).sum();
    assert!((faces - 59.0).abs() < 1e-9, "{faces}");
    // Closed, and all fronts inside: the volume by the divergence theorem is negative.
    let sum: DVec3 = zone.iter().map(|n| area_vector(scene, n)).sum();
    assert!(sum.length() < 1e-9, "{sum}");
    let third =
        |mesh: &Mesh, f: usize| mesh.face_positions(f)[0].dot(mesh.face_area_vector(f)) / 3.0;
    let of = |mesh: &Mesh| (0..mesh.faces.len()).map(|f| third(mesh, f)).sum::<f64>();
    let volume: f64 = zone.iter().map(|n| of(mesh(scene, n))).sum();
    assert!((volume + 30.0).abs() < 1e-9, "{volume}");
    // The zone is turned by 45 degrees in all, about its origin, which the building turns by 30.
    let [sin, cos] = [30f64.to_radians().sin(), 30f64.to_radians().cos()];
    let origin = DVec3::new(cos + 2.0 * sin, 2.0 * cos - sin, 3.0);
    let corner = mesh(scene, "S")
        .positions
        .iter()
        .map(|p| p.distance(origin));
    assert!(corner.fold(f64::INFINITY, f64::min) < 1e-12);
    let south = area_vector(scene, "S").normalize();
    let diagonal = DVec3::new(1.0, 1.0, 0.0).normalize();
    assert!(south.distance(diagonal) < 1e-12, "{south}");
    let hill = mesh(scene, "Hill").bounds();
    assert_eq!(hill.min, DVec3::new(-10.0, -20.0, 0.0));
    assert_eq!(hill.max, DVec3::new(20.0, -20.0, 5.0));
    let wing = area_vector(scene, "Wing").normalize();
    assert!(wing.distance(DVec3::new(-sin, -cos, 0.0)) < 1e-12, "{wing}");
}

#[test]
fn fields_of_all_versions() {
    let wall = |version: &str, head: &str| {
        let text = format!(
            "{version}\nZone, Z;\nBuildingSurface:Detailed, W, Wall, C, Z, {head} 4, 0,0,1, 0,0,0, 1,0,0, 1,0,1;\n"
        );
        let loaded = load(&text);
        assert!(loaded.warnings.is_empty(), "{text} {:?}", loaded.warnings);
        check_area(&loaded.scene, "W", [0.0, 1.0, 0.0]);
    };
    let (old, new) = ("Outdoors,,,,,", ",Outdoors,,,,,");
    wall("Version, 9.5;", old);
    wall("Version, 9.6.0;", new);
    wall("Version, 25.2;", new);
    // The number of vertices decides where the version is missing or wrong.
    wall("", old);
    wall("", new);
    wall("Version, 9.6;", old);
    wall("Version, 8.9;", new);
    let window = |version: &str, head: &str| {
        let text = format!(
            "{version}\nZone, Z;\nWall:Detailed, W, C, Z, {} 4, 0,0,3, 0,0,0, 3,0,0, 3,0,3;\n\
             FenestrationSurface:Detailed, P, Window, G, W, {head} 3, 1,0,2, 1,0,1, 2,0,1,,,;\n",
            if version.contains("8.9") { old } else { new }
        );
        let loaded = load(&text);
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        check_area(&loaded.scene, "P", [0.0, 0.5, 0.0]);
        check_area(&loaded.scene, "W", [0.0, 8.5, 0.0]);
    };
    window("Version, 8.9;", ",,,,,");
    window("Version, 9.6;", ",,,,");
    window("", ",,,,,");
    window("", ",,,,");
}

/// Two rooms with a wall between them that has a window; the second zone lists it in another order.
const TWO_ROOMS: &str = "
Version, 25.1;
Zone, A; Zone, B;
BuildingSurface:Detailed, AB, Wall, C, A, , Surface, BA, , , , 4, 2,0,2, 2,0,0, 2,3,0, 2,3,2;
BuildingSurface:Detailed, BA, Wall, C, B, , Surface, AB, , , , 4, 2,3,2.0000001, 2,3,0, 2,0,0, 2,0,2;
FenestrationSurface:Detailed, Pane AB, Window, G, AB, Pane BA, , , , 4, 2,1,1.5, 2,1,.5, 2,2,.5, 2,2,1.5;
FenestrationSurface:Detailed, Pane BA, Window, G, BA, Pane AB, , , , 4, 2,2,1.5, 2,2,.5, 2,1,.5, 2,1,1.5;
";

#[test]
fn walls_between_zones_are_two() {
    let loaded = load(TWO_ROOMS);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let scene = &loaded.scene;
    assert_eq!(names(scene), ["AB", "Pane AB", "BA", "Pane BA"]);
    check_area(scene, "AB", [-5.0, 0.0, 0.0]);
    check_area(scene, "BA", [5.0, 0.0, 0.0]);
    // The same corners, so that rays find both sides in one place.
    for (a, b) in [("AB", "BA"), ("Pane AB", "Pane BA")] {
        let (a, mut b) = (
            mesh(scene, a).face_positions(0),
            mesh(scene, b).face_positions(0),
        );
        b.reverse();
        assert_eq!(a, b);
    }
}

/// A wall that names the zone behind it has a side there, too.
#[test]
fn the_other_side_of_a_wall() {
    let text = "
Version, 25.1;
Material, Plaster, Rough, .01, .5, 1000, 900, .8;
Material, Metal, Smooth, .01, .5, 1000, 900, .3;
Construction, C, Metal, Brick, Plaster;
Zone, A; Zone, B;
BuildingSurface:Detailed, AB, Wall, C, A, , Zone, b, , , , 4, 2,0,2, 2,0,0, 2,3,0, 2,3,2;
Window, Pane, C, AB, , 1, 1, .5, 1, 1;
Wall:Interzone, BA, C, B, , A, 270, 90, 5, 0, 0, 3, 2;
Wall:Interzone, BB, C, B, , AB, 270, 90, 5, 0, 0, 3, 2;
";
    let loaded = load(text);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let scene = &loaded.scene;
    let expected = ["AB", "iz-AB", "Pane", "iz-Pane", "BA", "iz-BA", "BB"];
    assert_eq!(names(scene), expected);
    check_area(scene, "AB", [-5.0, 0.0, 0.0]);
    check_area(scene, "iz-AB", [5.0, 0.0, 0.0]);
    check_area(scene, "Pane", [-1.0, 0.0, 0.0]);
    check_area(scene, "iz-Pane", [1.0, 0.0, 0.0]);
    check_area(scene, "BA", [6.0, 0.0, 0.0]);
    check_area(scene, "iz-BA", [-6.0, 0.0, 0.0]);
    let of = |name: &str| &scene.materials[mesh(scene, name).face_materials[0] as usize];
    assert!((of("AB").diffuse.r - 0.2).abs() < 1e-12);
    assert!((of("iz-AB").diffuse.r - 0.7).abs() < 1e-12);
    assert_eq!(of("iz-AB").name, "C (reversed)");
}

#[test]
fn air_boundaries_are_open() {
    let text = format!("{TWO_ROOMS}\nConstruction:AirBoundary, c, None;");
    let loaded = load(&text);
    assert_eq!(names(&loaded.scene), [] as [&str; 0]);
    let open = loaded.warnings[0].clone();
    assert_eq!((open.count, open.position), (2, Position::Line(4, 1)));
    assert!(open.message.contains("left open"), "{open}");
}

#[test]
fn shading_turns_with_its_surface() {
    let text = "Version,25.1; Building, B, 90; Zone, Z, 90, 5, 0, 0;
        Shading:Zone:Detailed, Fin, w, , 4, 0,0,1, 0,0,0, 1,0,0, 1,0,1;
        Shading:Building:Detailed, Wing, , 4, 0,0,1, 0,0,0, 1,0,0, 1,0,1;
        Shading:Site:Detailed, Hill, , 4, 0,0,1, 0,0,0, 1,0,0, 1,0,1;
        Wall:Detailed, W, C, Z, , Outdoors,,,,, 4, 0,0,1, 0,0,0, 1,0,0, 1,0,1;";
    let loaded = load(text);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let scene = &loaded.scene;
    check_area(scene, "W", [0.0, -1.0, 0.0]);
    check_area(scene, "Fin", [0.0, 1.0, 0.0]);
    assert_eq!(mesh(scene, "Fin").bounds(), mesh(scene, "W").bounds());
    check_area(scene, "Wing", [-1.0, 0.0, 0.0]);
    check_area(scene, "Hill", [0.0, -1.0, 0.0]);
}

/// The room of `ROOM` as epJSON.
const ROOM_JSON: &str = r#"{
 "Version": {"Version 1": {"version_identifier": "25.1"}},
 "GlobalGeometryRules": {"GlobalGeometryRules 1": {"coordinate_system": "Relative",
  "starting_vertex_position": "UpperLeftCorner", "vertex_entry_direction": "Counterclockwise"}},
 "Zone": {"Room": {"x_origin": 10, "z_origin": 1.0}},
 "Material": {"Plaster": {"thermal_absorptance": 0.8}},
 "Construction": {"Wall type": {"outside_layer": "Brick", "layer_2": "plaster"}},
 "BuildingSurface:Detailed": {
  "South": {"surface_type": "Wall", "construction_name": "Wall type", "zone_name": "ROOM",
   "view_factor_to_ground": "Autocalculate", "number_of_vertices": 4, "vertices": [
    {"vertex_x_coordinate": 0, "vertex_y_coordinate": 0, "vertex_z_coordinate": 2.5},
    {"vertex_x_coordinate": 0, "vertex_y_coordinate": 0, "vertex_z_coordinate": 0},
    {"vertex_x_coordinate": 4, "vertex_y_coordinate": 0, "vertex_z_coordinate": 0},
    {"vertex_x_coordinate": 4, "vertex_y_coordinate": 0, "vertex_z_coordinate": 2.5}]}},
 "FenestrationSurface:Detailed": {"Pane": {"building_surface_name": "South", "construction_name": "Double",
  "surface_type": "Window", "vertex_1_x_coordinate": 1, "vertex_1_y_coordinate": 0, "vertex_1_z_coordinate": 2,
  "vertex_2_x_coordinate": 1, "vertex_2_y_coordinate": 0, "vertex_2_z_coordinate": 1,
  "vertex_3_x_coordinate": 2, "vertex_3_y_coordinate": 0, "vertex_3_z_coordinate": 1,
  "vertex_4_x_coordinate": 2, "vertex_4_y_coordinate": 0, "vertex_4_z_coordinate": 2}},
 "Door": {"Entrance": {"building_surface_name": "South", "construction_name": "Wood",
  "starting_x_coordinate": 2.5, "starting_z_coordinate": 0, "length": 1, "height": 2}}
}"#;

#[test]
fn the_same_as_json() {
    let loaded = load_as(ROOM_JSON, "a.epJSON").unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let idf = load(ROOM).scene;
    for (k, object) in loaded.scene.objects.iter().enumerate() {
        assert_eq!(object, &idf.objects[k]);
    }
    assert_eq!(loaded.scene.objects.len(), 3);
    let [json, idf] = [&loaded.scene, &idf].map(|s| &s.materials[..3]);
    assert_eq!(json, idf);
}

#[test]
fn what_is_skipped() {
    let text = "Version,25.1;\n##include walls.imf\nZone, Z;
InternalMass, M, C, Z, , 10;
Shading:Overhang, O, P, 0, 90, 0, 0, 1;
GeometryTransform, XY, 1, 2;
Wall:Detailed, W, C, Nowhere, , Zone, Y,,,, 2, 0,0,1, 0,0,0, 1,0,0, 1,0,1;
Wall:Detailed, L, C, Z, , Outdoors,,,,, 2, 0,0,1, 0,0,0;
Window, P, G, X, , 1, 0, 0, 1, 1;
FenestrationSurface:Detailed, Q, Window, G, X, , , Frame, 2, 3, 1,0,2, 1,0,1, 2,0,1;
Floor:Detailed, F, C, Z, , Ground,,,,, 3, 0,0,0, 1,0,0, 0,1,0;
Schedule:Constant, S, , 1;
Wall:Detailed, Unfinished";
    let loaded = load(text);
    assert_eq!(names(&loaded.scene), ["W", "F", "Q"]);
    check_area(&loaded.scene, "F", [0.0, 0.0, 0.5]);
    let expected = [
        "a.idf:13:1: the file ends inside an object: skipped",
        "a.idf:2:1: macro commands (##): skipped; EnergyPlus expands them beforehand",
        "a.idf:7:1: surface with another number of vertices than it says: all are read",
        "a.idf:5:1: overhang or fin given by its window: not in the scene",
        "a.idf:6:1: another aspect ratio of the building: not applied",
        "a.idf:7:1: surface of a zone that is not in the file",
        "a.idf:8:1: surface of fewer than three vertices: skipped",
        "a.idf:11:1: roof that faces down, or floor that faces up: turned",
        "a.idf:9:1: opening on a surface that is not in the file: skipped",
        "a.idf:10:1: frame of an opening: part of its surface",
        "a.idf:10:1: opening with a multiplier: one is read",
        "a.idf:10:1: opening of a surface that is not in the file: in no surface",
        "a.idf:4:1: internal mass, which has no place: only files for EnergyPlus have it",
        "a.idf:7:1: surface whose other side is in a zone that is not in the file: one side is read",
    ];
    assert_eq!(messages(&loaded), expected);
    assert_eq!(
        messages(&load("Version,25.1;")),
        ["a.idf: no surfaces: the scene is empty"]
    );
}

/// Windows of a wall of 4 m × 2.5 m: what is left of it, and how the warnings begin.
fn check_wall(windows: &[&str], left: f64, warnings: &[&str]) {
    let windows: Vec<String> = windows
        .iter()
        .enumerate()
        .map(|(k, corners)| {
            format!("FenestrationSurface:Detailed, P{k}, Window, G, W,,,,, 4, {corners};\n")
        })
        .collect();
    let text = format!(
        "Version,25.1;Zone,Z;Wall:Detailed, W, C, Z, , Outdoors,,,,, 4, 0,0,2.5, 0,0,0, 4,0,0, 4,0,2.5;\n{}",
        windows.concat()
    );
    let loaded = load(&text);
    let actual = messages(&loaded);
    assert_eq!(actual.len(), warnings.len(), "{actual:?}");
    for (actual, expected) in actual.iter().zip(warnings) {
        assert!(actual.contains(expected), "{actual}");
    }
    if left > 0.0 {
        let wall = mesh(&loaded.scene, "W");
        let triangles: f64 = wall.in_triangles(|_| true).area();
        assert!((wall.area() - left).abs() < 1e-9, "{}", wall.area());
        assert!((triangles - left).abs() < 1e-9, "{triangles}");
    }
}

#[test]
fn windows_of_all_kinds() {
    let inside = "1,0,2, 1,0,1, 2,0,1, 2,0,2";
    check_wall(&[inside], 9.0, &[]);
    // Side by side, with a common edge.
    check_wall(&[inside, "2,0,2, 2,0,1, 3,0,1, 3,0,2"], 8.0, &[]);
    // From the floor to the ceiling, and the whole wall.
    check_wall(&["1,0,2.5, 1,0,0, 2,0,0, 2,0,2.5"], 7.5, &[]);
    let whole = "0,0,2.5, 0,0,0, 4,0,0, 4,0,2.5";
    check_wall(&[whole], 0.0, &["cover entirely"]);
    // Wound the other way.
    check_wall(&["1,0,2, 2,0,2, 2,0,1, 1,0,1"], 9.0, &[]);
    // Beyond the wall, twice the same, one inside of the other.
    check_wall(&["3,0,2, 3,0,1, 5,0,1, 5,0,2"], 9.0, &["overlap or extend"]);
    check_wall(&[inside, inside], 9.0, &["overlap or extend"]);
    let small = "1.2,0,1.8, 1.2,0,1.2, 1.8,0,1.2, 1.8,0,1.8";
    check_wall(&[inside, small], 9.0, &["overlap or extend"]);
    check_wall(&[small, inside], 9.0, &["overlap or extend"]);
    check_wall(
        &["7,0,2, 7,0,1, 8,0,1, 8,0,2"],
        10.0,
        &["overlap or extend"],
    );
    // Before the wall.
    check_wall(&["1,-.1,2, 1,-.1,1, 2,-.1,1, 2,-.1,2"], 9.0, &["plane"]);
    // Concave: a dart.
    check_wall(&["1,0,2, 2,0,1, 3,0,2, 2,0,1.5"], 9.5, &[]);
}

#[test]
fn an_l_shaped_wall_with_a_door() {
    let text = "Version,25.1;Zone,Z;
        Wall:Detailed, W, C, Z, , Outdoors,,,,, 6, 0,0,4, 0,0,0, 6,0,0, 6,0,2, 3,0,2, 3,0,4;
        Door, D, C, W, 1, 4, 0, 1, 1.5; Window, P, G, W, , 1, 1, 1, 1, 2;";
    let loaded = load(text);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    check_area(&loaded.scene, "W", [0.0, 18.0 - 1.5 - 2.0, 0.0]);
}

#[test]
fn positions_of_errors() {
    let refuse = |text: &str, line: u32, column: u32, expected: &str| {
        let error = load_as(text, "a.idf").unwrap_err();
        assert_eq!(error.position, Position::Line(line, column), "{error}");
        assert!(error.to_string().contains(expected), "{error}");
    };
    let text = ROOM.replace("  0, 0, 0,\n", "  0, O, 0,\n");
    refuse(&text, 16, 6, "found \"O\", expected a coordinate");
    let text = ROOM.replace("0, 10, 0, 1;", "0, 10, 0 m, 1;");
    refuse(&text, 7, 10, "found \"0 m\", expected a number");
    let text = ROOM.replace("2.5, 0, 1, 2;", "2.5, 0, 1;");
    refuse(&text, 24, 1, "Door without height");
    let text = "Version,25.1;\nZone,Z;\nWall:Detailed, W, C, Z,,,,,,, 3, 0,0,0, 1,0,0, 1,1,0, 5;";
    refuse(text, 3, 55, "half a vertex");
    let json = ROOM_JSON.replace(
        "\"vertex_y_coordinate\": 0, \"vertex_z_coordinate\": 0},",
        "\"vertex_y_coordinate\": 0},",
    );
    refuse(&json, 12, 5, "a vertex without x, y or z");
    let json = ROOM_JSON.replace("\"x_origin\": 10", "\"x_origin\": null");
    refuse(&json, 5, 32, "found \"null\"");
    refuse(&ROOM_JSON[..100], 3, 39, "malformed JSON");
}

#[test]
fn every_prefix() {
    for end in 0..ROOM.trim_end().len() {
        // What is complete is read.
        let loaded = load(&ROOM[..end]);
        assert!(loaded.scene.objects.len() < 5, "{end}");
    }
    for end in 1..ROOM_JSON.trim_end().len() {
        assert!(load_as(&ROOM_JSON[..end], "a").is_err(), "{end}");
    }
}

/// A field of windows, too many for one wall where they touch.
#[test]
fn a_sieve_is_refused() {
    let window = |k: usize| {
        let x = 0.0001 * k as f64;
        format!("Window, P{k}, G, W, , 1, {x}, 0, 0.0001, 1;\n")
    };
    let windows: String = (0..5000).map(window).collect();
    let text = format!(
        "Version,25.1;Zone,Z;\nWall:Detailed, W, C, Z, , Outdoors,,,,, 4, 0,0,2.5, 0,0,0, 4,0,0, 4,0,2.5;\n{windows}"
    );
    let error = load_as(&text, "a.idf").unwrap_err();
    assert_eq!(error.position, Position::Line(2, 1));
    assert!(error.found.contains("5000 openings"), "{error}");
    let options = ReadOptions::in_proportion(text.len());
    let error = read(text.as_bytes(), "a.idf", &Memory::new(), &options).unwrap_err();
    assert!(error.found.contains("expand"), "{error}");
}

/// The zone of each object, and what has no place in it.
fn zones(text: &str) -> Vec<(String, String, usize)> {
    let objects = load(text).scene.objects;
    let described = objects.into_iter().map(|object| {
        let zone = object.zone.map_or((String::new(), 0), |zone| {
            (zone.name.clone(), zone.masses.len())
        });
        (object.name, zone.0, zone.1)
    });
    described.collect()
}

#[test]
fn surfaces_know_their_zones() {
    let wall = |name: &str, zone: &str, construction: &str, outside: &str| {
        format!(
            "Wall:Detailed,{name},{construction},{zone},,{outside},,,,3, 0,0,0, 1,0,0, 0,0,1;\n"
        )
    };
    let start = "Version,25.2;Zone,One;Zone,Two;Zone,Three;Construction:AirBoundary,Air;\n\
                 InternalMass,Sofa,C,TWO,,12;InternalMass,Nothing,C,Four,,12;\n\
                 Shading:Site:Detailed,Tree,,3, 0,0,0, 1,0,0, 0,0,1;\n";
    let walls = [
        wall("a", "One", "C", "Outdoors,"),
        wall("b", "two", "C", "Zone,Three"),
        wall("c", "Three", "C", "Outdoors,"),
    ];
    let text = [start, &walls.concat()].concat();
    let expected = |rows: &[(&str, &str, usize)]| -> Vec<_> {
        let rows = rows.iter();
        rows.map(|(name, zone, masses)| ((*name).to_owned(), (*zone).to_owned(), *masses))
            .collect()
    };
    let mut objects = zones(&text);
    let tree = objects.remove(
        objects
            .iter()
            .position(|(name, ..)| name == "Tree")
            .unwrap(),
    );
    assert_eq!(tree.1, "");
    assert_eq!(
        objects,
        expected(&[
            ("a", "One", 0),
            ("b", "two", 1),
            ("iz-b", "Three", 0),
            ("c", "Three", 0)
        ])
    );
    // What is open between them makes one of two, by the name of the first.
    let open = [&*text, &wall("hole", "Three", "Air", "Surface,a")].concat();
    let objects = zones(&open);
    assert!(
        objects.contains(&("c".into(), "One".into(), 0)),
        "{objects:?}"
    );
}

proptest! {
    /// Any change of a byte gives an error or a valid scene.
    #[test]
    fn damaged(at in 0..ROOM.len(), byte in any::<u8>()) {
        for text in [ROOM, ROOM_JSON, TWO_ROOMS, RECTANGLES] {
            let mut bytes = text.as_bytes().to_vec();
            let at = at % bytes.len();
            bytes[at] = byte;
            if let Ok(loaded) = read(&bytes, "a.idf", &Memory::new(), &ReadOptions::default()) {
                prop_assert!(loaded.scene.validate().is_ok());
            }
        }
    }

    /// Wherever windows lie, wall and cut-outs have the area of the wall.
    #[test]
    fn areas_add_up(grid in prop::collection::btree_set((0u32..8, 0u32..5), 0..12), inset in 0u32..3) {
        let inset = 0.1 * f64::from(inset);
        let window = |&(i, j): &(u32, u32)| {
            let (x, z) = (0.5 * f64::from(i) + inset, 0.5 * f64::from(j) + inset);
            let size = 0.5 - 2.0 * inset;
            format!("Window, P{i}{j}, G, W, , 1, {x}, {z}, {size}, {size};\n")
        };
        let windows: String = grid.iter().map(window).collect();
        let text = format!(
            "Version,25.1;Zone,Z;\nWall:Detailed, W, C, Z, , Outdoors,,,,, 4, 0,0,2.5, 0,0,0, 4,0,0, 4,0,2.5;\n{windows}"
        );
        let loaded = load(&text);
        prop_assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        let triangles = |o: &azulejo_scene::Object| match &o.shape {
            Shape::Mesh(mesh) => mesh.in_triangles(|_| true).area(),
            _ => 0.0,
        };
        let sum: f64 = loaded.scene.objects.iter().map(triangles).sum();
        prop_assert!((sum - 10.0).abs() < 1e-9, "{}", sum);
    }
}
