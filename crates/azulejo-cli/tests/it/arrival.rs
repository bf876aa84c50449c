//! Factors are right where they arrive: in the file that the next program reads.

use crate::support::Folder;
use std::collections::BTreeMap;

/// Floor and ceiling of 6 × 4 m, 3 m apart, and walls that face outwards.
const WALLS_OUTWARD: &str = "v 0 0 0\nv 6 0 0\nv 6 4 0\nv 0 4 0\nv 0 0 3\nv 6 0 3\nv 6 4 3\nv 0 4 3\n\
    o floor\nf 1 2 3 4\no ceiling\nf 8 7 6 5\no walls\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// Two rooms whose common wall is two faces, back to back.
const DOUBLE_WALL: &str = "v 0 0 0\nv 4 0 0\nv 8 0 0\nv 0 4 0\nv 4 4 0\nv 8 4 0\nv 0 0 3\nv 4 0 3\nv 8 0 3\n\
    v 0 4 3\nv 4 4 3\nv 8 4 3\no room1\nf 1 2 5 4\nf 10 11 8 7\nf 7 8 2 1\nf 4 5 11 10\nf 4 10 7 1\n\
    o wall1\nf 2 8 11 5\no room2\nf 2 3 6 5\nf 11 12 9 8\nf 8 9 3 2\nf 5 6 12 11\nf 3 9 12 6\n\
    o wall2\nf 5 11 8 2\n";

/// A wall on a level ground, 10 m from its edge.
const BLOCK: [[[f64; 3]; 3]; 4] = [
    [[0.0, 0.0, 0.0], [30.0, 0.0, 0.0], [30.0, 30.0, 0.0]],
    [[0.0, 0.0, 0.0], [30.0, 30.0, 0.0], [0.0, 30.0, 0.0]],
    [[20.0, 0.0, 0.0], [20.0, 30.0, 0.0], [20.0, 30.0, 10.0]],
    [[20.0, 0.0, 0.0], [20.0, 30.0, 10.0], [20.0, 0.0, 10.0]],
];

/// The factors of a CSV by its two names.
fn factors(folder: &Folder, name: &str) -> BTreeMap<(String, String), f64> {
    let text = String::from_utf8(folder.read(name)).unwrap();
    let fields = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
    let lines = text.lines().skip(1).map(fields);
    lines
        .map(|f| ((f[0].clone(), f[1].clone()), f[2].parse().unwrap()))
        .collect()
}

fn of(found: &BTreeMap<(String, String), f64>, from: &str, to: &str) -> f64 {
    let key = (from.to_owned(), to.to_owned());
    found.get(&key).copied().unwrap_or(0.0)
}

/// The sum of a row with what leaves, and without what ends on backs.
fn sum(found: &BTreeMap<(String, String), f64>, from: &str) -> f64 {
    let row = found
        .iter()
        .filter(|((a, b), _)| a == from && b != "hidden");
    row.map(|(_, f)| f).sum()
}

#[test]
fn what_cannot_be_closed_stays_as_it_is() {
    let folder = Folder::new();
    folder.write("two.obj", WALLS_OUTWARD);
    for engine in [
        "",
        "--engine rays",
        "--engine hemicube",
        "--patch-size 0",
        "--closure=always",
    ] {
        folder.ok(&format!(
            "form-factors two.obj -o f.csv --by object {engine}"
        ));
        let found = factors(&folder, "f.csv");
        let factor = of(&found, "floor", "ceiling");
        assert!((factor - 0.341694).abs() < 2e-3, "{engine}: {factor}");
        let hidden = of(&found, "floor", "hidden");
        assert!((hidden + factor - 1.0).abs() < 2e-3, "{engine}: {hidden}");
    }
}

#[test]
fn a_wall_of_two_faces_counts_once_with_its_backs() {
    let folder = Folder::new();
    folder.write("wall.obj", DOUBLE_WALL);
    for engine in ["", "--engine rays", "--engine hemicube"] {
        let command = format!("form-factors wall.obj -o f.csv --by object --two-sided {engine}");
        let words = folder.ok(&command).err;
        assert!(words.contains("back to back in one plane"), "{words}");
        let found = factors(&folder, "f.csv");
        for row in ["room1", "room2", "wall1", "wall2"] {
            let sum = sum(&found, row);
            assert!((sum - 1.0).abs() < 5e-3, "{engine}: {row} {sum}");
        }
        assert_eq!(sum(&found, "wall1 (back)"), 0.0, "{engine}");
    }
}

#[test]
fn rooms_that_were_inserted_twice_are_refused() {
    let folder = Folder::new();
    let room = DOUBLE_WALL.replace("o ", "o second_");
    folder.write("room.obj", DOUBLE_WALL);
    folder.write("again.obj", room);
    folder.fails(
        "form-factors room.obj again.obj -o f.csv --by object",
        1,
        "more than all of its light",
    );
    assert!(!folder.names().contains(&"f.csv".to_owned()));
}

#[test]
fn udales_gets_what_no_facet_has() {
    let folder = Folder::new();
    let facet = |corners: &[[f64; 3]; 3]| {
        let vertex = |[x, y, z]: &[f64; 3]| format!("vertex {x} {y} {z}\n");
        let corners: String = corners.iter().map(vertex).collect();
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    };
    let facets: String = BLOCK.iter().map(facet).collect();
    folder.write(
        "block.stl",
        format!("solid block\n{facets}endsolid block\n"),
    );
    for engine in ["", "--engine rays", "--engine rays --closure=never"] {
        folder.ok(&format!(
            "form-factors block.stl -o vfsparse.inp.001 --patch-size 0 {engine}"
        ));
        let text = |name: &str| String::from_utf8(folder.read(name)).unwrap();
        let mut sums: Vec<f64> = text("svf.inp.001")
            .lines()
            .skip(1)
            .map(|l| l.parse().unwrap())
            .collect();
        for line in text("vfsparse.inp.001").lines() {
            let fields: Vec<&str> = line.split(' ').collect();
            sums[fields[0].parse::<usize>().unwrap() - 1] += fields[2].parse::<f64>().unwrap();
        }
        // The tolerance of its check is 1e-3.
        assert!(
            sums.iter().all(|s| (s - 1.0).abs() < 1e-6),
            "{engine}: {sums:?}"
        );
    }
}

/// Boxes of 4 × 5 × 3 m side by side, each a zone.
fn rooms(names: &[&str], more: &str) -> String {
    let mut idf = format!("Version,25.2;Construction,C,M;{more}\n");
    for (k, name) in names.iter().enumerate() {
        let [a, b] = [4 * k, 4 * k + 4];
        let mut wall = |kind: &str, class: &str, corners: [[usize; 3]; 4]| {
            let corners: String = corners
                .iter()
                .map(|[x, y, z]| format!(",{x},{y},{z}"))
                .collect();
            idf += &format!(
                "BuildingSurface:Detailed,{name}_{kind},{class},C,{name},,Outdoors,,SunExposed,WindExposed,,4{corners};\n"
            );
        };
        wall(
            "Floor",
            "Floor",
            [[a, 0, 0], [a, 5, 0], [b, 5, 0], [b, 0, 0]],
        );
        wall("Roof", "Roof", [[a, 5, 3], [a, 0, 3], [b, 0, 3], [b, 5, 3]]);
        wall("S", "Wall", [[a, 0, 3], [a, 0, 0], [b, 0, 0], [b, 0, 3]]);
        wall("E", "Wall", [[b, 0, 3], [b, 0, 0], [b, 5, 0], [b, 5, 3]]);
        wall("N", "Wall", [[b, 5, 3], [b, 5, 0], [a, 5, 0], [a, 5, 3]]);
        wall("W", "Wall", [[a, 5, 3], [a, 5, 0], [a, 0, 0], [a, 0, 3]]);
        idf += &format!("Zone,{name};\n");
    }
    idf
}

/// Factors by the names of two surfaces.
type ByNames = BTreeMap<(String, String), f64>;

/// The objects of a file for EnergyPlus: of each zone the factors by both names.
fn objects(folder: &Folder, name: &str) -> Vec<(String, ByNames)> {
    let text = String::from_utf8(folder.read(name)).unwrap();
    let objects = text.split(';').filter(|o| !o.trim().is_empty());
    let object = |object: &str| {
        let fields: Vec<String> = object.split(',').map(|f| f.trim().to_owned()).collect();
        assert_eq!(fields[0], "ZoneProperty:UserViewFactors:BySurfaceName");
        let triples = fields[2..].chunks(3);
        let triples = triples.map(|t| ((t[0].clone(), t[1].clone()), t[2].parse().unwrap()));
        (fields[1].clone(), triples.collect())
    };
    objects.map(object).collect()
}

#[test]
fn zones_are_enclosures_of_their_own() {
    let folder = Folder::new();
    let shade = "Shading:Building:Detailed,Tree,,4, -9,0,0, -9,5,0, -9,5,3, -9,0,3;";
    folder.write("two.idf", rooms(&["ROOM1", "ROOM2"], shade));
    folder.ok("form-factors two.idf -o one.idf --by object --zone room1 --closure");
    let found = objects(&folder, "one.idf");
    assert_eq!((found.len(), &*found[0].0), (1, "ROOM1"));
    assert_eq!(found[0].1.len(), 36);
    assert!((sum(&found[0].1, "ROOM1_Floor") - 1.0).abs() < 1e-8);
    folder.ok("form-factors two.idf -o both.idf --by object");
    let both = objects(&folder, "both.idf");
    let zones: Vec<&str> = both.iter().map(|(zone, _)| &**zone).collect();
    assert_eq!(zones, ["ROOM1", "ROOM2"]);
    for ((from, to), f) in &both[0].1 {
        let other = |name: &String| name.replace("ROOM1", "ROOM2");
        let same = both[1].1[&(other(from), other(to))];
        assert!((f - same).abs() < 1e-8, "{from} {to}: {f} {same}");
    }
    // A matrix of the whole building knows its zones, too.
    folder.ok("form-factors two.idf -o f.npz --patch-size 0");
    folder.ok("form-factors f.npz -o again.idf --by object --zone ROOM2");
    let again = objects(&folder, "again.idf");
    assert_eq!((again.len(), again[0].1.len()), (1, 36));
    folder.ok("form-factors two.idf -o both.epjson --by object");
    let json: serde_json::Value = serde_json::from_slice(&folder.read("both.epjson")).unwrap();
    let objects = &json["ZoneProperty:UserViewFactors:BySurfaceName"];
    assert_eq!(objects.as_object().unwrap().len(), 2);
    for (line, expected) in [
        (
            "two.idf -o f.idf --by object --zone ROOM3",
            "expected one of ROOM1, ROOM2",
        ),
        (
            "f.npz -o f.idf --by object --zone ROOM3",
            "expected one of ROOM1, ROOM2",
        ),
        ("two.idf -o f.idf", "--by object makes them"),
    ] {
        folder.fails(&format!("form-factors {line}"), 1, expected);
    }
}

#[test]
fn internal_mass_takes_part_by_its_area() {
    let folder = Folder::new();
    let check = |mass: &str, names: &[&str]| {
        folder.write("mass.idf", rooms(&["OFFICE"], mass));
        folder.ok("form-factors mass.idf -o vf.idf --by object --zone OFFICE --closure");
        let found = objects(&folder, "vf.idf").remove(0).1;
        let rows = 6 + names.len();
        assert_eq!(found.len(), rows * rows, "{mass}");
        for (from, _) in found.keys() {
            assert!((sum(&found, from) - 1.0).abs() < 1e-7, "{mass}: {from}");
        }
        found
    };
    let found = check("InternalMass,Furniture,C,OFFICE,,47;", &["Furniture"]);
    // Of 94 m² of surfaces, 20 m² are the floor's.
    assert!((of(&found, "Furniture", "OFFICE_Floor") - 20.0 / 94.0).abs() < 1e-8);
    assert!((of(&found, "OFFICE_Floor", "Furniture") - 47.0 / 94.0).abs() < 1e-8);
    let plenty = "InternalMass,Shelves,C,OFFICE,,100;InternalMass,Books,C,OFFICE,,300;";
    let found = check(plenty, &["Shelves", "Books"]);
    let [there, back] =
        [("OFFICE_Floor", "Books"), ("Books", "OFFICE_Floor")].map(|(a, b)| of(&found, a, b));
    assert!((20.0 * there - 300.0 * back).abs() < 1e-6, "{there} {back}");
}

/// Two bricks 1 m apart, of which two faces radiate.
const BRICKS: &str = "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n\
    9,0,0,2\n10,1,0,2\n11,1,1,2\n12,0,1,2\n13,0,0,3\n14,1,0,3\n15,1,1,3\n16,0,1,3\n\
    *ELEMENT,TYPE=C3D8,ELSET=Eall\n1,1,2,3,4,5,6,7,8\n2,9,10,11,12,13,14,15,16\n\
    *STEP\n*RADIATE\n2,R1CR,300.,0.8\n1,R2CR,300.,0.8\n2,R3,300.,0.8\n*END STEP\n";

#[test]
fn calculix_gets_the_faces_of_its_loads() {
    let folder = Folder::new();
    folder.write("two.inp", BRICKS);
    folder.ok("form-factors two.inp -o two.vwf --patch-size 0");
    let content = folder.read("two.vwf");
    let numbers = |at: usize| f64::from_le_bytes(content[at..at + 8].try_into().unwrap());
    // Behind the title: two factors of rows with themselves, and then both directions of the pair.
    assert_eq!(content[88..92], 16i32.to_le_bytes());
    assert!((numbers(116) - 0.19982489569839).abs() < 1e-8);
    folder.fails(
        "form-factors two.inp -o more.vwf --patches 20",
        1,
        "--patch-size 0 or --by face makes them",
    );
    let names = folder.json("info two.inp");
    assert_eq!(
        names["object_list"].as_array().map(Vec::len),
        Some(1),
        "{names}"
    );
}

/// Four houses on a street, as CityJSON has them; with reversed roofs, as converters leave them.
fn city(roofs_down: bool) -> String {
    let mut vertices: Vec<String> = Vec::new();
    let mut objects: Vec<String> = Vec::new();
    let houses = [
        ("A", 0, 0, 12),
        ("B", 20, 0, 6),
        ("C", 0, 20, 6),
        ("D", 20, 20, 12),
    ];
    for (name, x, y, height) in houses {
        let first = vertices.len();
        for z in [0, 100 * height] {
            for (dx, dy) in [(0, 0), (10, 0), (10, 10), (0, 10)] {
                vertices.push(format!("[{},{},{z}]", x + dx, y + dy));
            }
        }
        let ring = |corners: [usize; 4]| {
            let corners: Vec<String> = corners.iter().map(|c| (first + c).to_string()).collect();
            format!("[[{}]]", corners.join(","))
        };
        let roof = if roofs_down {
            [7, 6, 5, 4]
        } else {
            [4, 5, 6, 7]
        };
        let rings = [
            [3, 2, 1, 0],
            roof,
            [0, 1, 5, 4],
            [1, 2, 6, 5],
            [2, 3, 7, 6],
            [3, 0, 4, 7],
        ];
        let rings = rings.map(ring).join(",");
        objects.push(format!(
            "\"{name}\":{{\"type\":\"Building\",\"geometry\":[{{\"type\":\"Solid\",\"lod\":\"1\",\"boundaries\":[[{rings}]],\
             \"semantics\":{{\"surfaces\":[{{\"type\":\"GroundSurface\"}},{{\"type\":\"RoofSurface\"}},\
             {{\"type\":\"WallSurface\"}}],\"values\":[[0,1,2,2,2,2]]}}}}]}}"
        ));
    }
    let first = vertices.len();
    vertices
        .extend(["[-20,-20,-1]", "[50,-20,-1]", "[50,50,-1]", "[-20,50,-1]"].map(str::to_owned));
    objects.push(format!(
        "\"street\":{{\"type\":\"LandUse\",\"geometry\":[{{\"type\":\"MultiSurface\",\"lod\":\"1\",\
         \"boundaries\":[[[{},{},{},{}]]]}}]}}",
        first,
        first + 1,
        first + 2,
        first + 3
    ));
    format!(
        "{{\"type\":\"CityJSON\",\"version\":\"2.0\",\"transform\":{{\"scale\":[1,1,0.01],\"translate\":[0,0,0]}},\
         \"CityObjects\":{{{}}},\"vertices\":[{}]}}",
        objects.join(","),
        vertices.join(",")
    )
}

#[test]
fn roofs_that_face_into_their_houses_are_named() {
    let folder = Folder::new();
    folder.write("good.city.json", city(false));
    folder.write("down.city.json", city(true));
    let good = folder.ok("form-factors good.city.json -o f.csv --by object --rays 1024");
    assert!(!good.err.contains("inside out"), "{}", good.err);
    let down = folder
        .ok("form-factors down.city.json -o f.csv --by object --rays 1024")
        .err;
    assert!(
        down.contains("inside out") && down.contains("Roof"),
        "{down}"
    );
    assert!(!down.contains("Wall"), "{down}");
    let found = factors(&folder, "f.csv");
    let hidden = found
        .iter()
        .filter(|((_, to), f)| to == "hidden" && **f > 0.99);
    assert_eq!(hidden.count(), 4);
}

#[test]
fn fronts_that_see_the_sky_are_no_alarm() {
    let folder = Folder::new();
    folder.write(
        "chimney.obj",
        "v 0 0 6\nv 10 0 6\nv 10 10 6\nv 0 10 6\nv 4 4 6\nv 5 4 6\nv 5 5 6\nv 4 5 6\n\
         v 4 4 7.5\nv 5 4 7.5\nv 5 5 7.5\nv 4 5 7.5\no roof\nf 1 2 3 4\no chimney_walls\nf 5 6 10 9\n\
         f 6 7 11 10\nf 7 8 12 11\nf 8 5 9 12\no chimney_top\nf 9 10 11 12\n",
    );
    folder.write(
        "pv.obj",
        "v -0.94 0 1.158\nv 0.94 0 1.842\nv 0.94 20 1.842\nv -0.94 20 1.158\n\
         v -2.5 0 0\nv 2.5 0 0\nv 2.5 20 0\nv -2.5 20 0\n\
         o front\nf 1 2 3 4\no rear\nf 4 3 2 1\no ground\nf 5 6 7 8\n",
    );
    for command in [
        "chimney.obj --place chimney.obj:up=z",
        "pv.obj --place pv.obj:up=z --periodic x=5,y=20 --rays 1024",
    ] {
        let words = folder
            .ok(&format!("form-factors {command} --by object -o f.csv"))
            .err;
        assert!(!words.contains("inside out"), "{words}");
    }
}

#[test]
fn the_axis_of_files_and_the_instant_of_the_sun() {
    let folder = Folder::new();
    folder.write("t.obj", "v -5 -5 0\nv 5 -5 0\nv 5 5 0\nf 1 2 3\n");
    let words = folder.ok("form-factors t.obj --up z -o f.csv").err;
    assert!(words.contains("--place t.obj:up=z"), "{words}");
    let sun = "--place 48.14,11.58 --sky cie:12 --sun 900 --time 2025-06-21T14:00+02:00";
    for command in [
        "form-factors t.obj -o f.npz",
        "convert t.obj -o t.grf",
        "info t.obj",
    ] {
        folder.ok(&format!("{command} {sun}"));
    }
    folder.write("eps.csv", "name,eps\n*,0.9\n");
    folder.ok(&format!(
        "exchange t.obj --materials eps.csv -o x.csv {sun}"
    ));
    folder.fails("info t.obj --time 60s", 2, "2025-06-21T14:00+02:00");
}

#[test]
fn regions_of_openfoam_are_named_before_the_work() {
    let folder = Folder::new();
    let boundary = |group: &str| {
        format!(
            "3(walls{{type wall;inGroups 1({group});nFaces 4;startFace 0;}} front{{type empty;nFaces 1;startFace 4;}} \
                 back{{type empty;nFaces 1;startFace 5;}})"
        )
    };
    let header = |class: &str, object: &str| {
        format!(
            "FoamFile{{version 2.0;format ascii;class {class};location \"polyMesh\";object {object};}}\n"
        )
    };
    for (place, group) in [("constant", "wall"), ("constant/air", "viewFactorWall")] {
        std::fs::create_dir_all(folder.path(&format!("{place}/polyMesh"))).unwrap();
        let write = |name: &str, class: &str, content: &str| {
            folder.write(
                &format!("{place}/polyMesh/{name}"),
                header(class, name) + content,
            );
        };
        write(
            "points",
            "vectorField",
            "8((0 0 0)(2 0 0)(2 1 0)(0 1 0)(0 0 .01)(2 0 .01)(2 1 .01)(0 1 .01))",
        );
        write(
            "faces",
            "faceList",
            "6(4(0 1 5 4)4(2 3 7 6)4(3 0 4 7)4(1 2 6 5)4(0 3 2 1)4(4 5 6 7))",
        );
        write("boundary", "polyBoundaryMesh", &boundary(group));
    }
    let flat = "form-factors constant/polyMesh/boundary -o f.csv --by object";
    let words = folder.ok(flat).err;
    assert!(words.contains("--periodic z"), "{words}");
    folder.ok(&format!("{flat} --periodic z --patch-size 0 --rays 256"));
    let sum = sum(&factors(&folder, "f.csv"), "walls");
    assert!((sum - 1.0).abs() < 1e-6, "{sum}");
    let region = "form-factors constant/air/polyMesh/boundary --format openfoam --openfoam v2312 --by face --patch-size 0";
    folder.fails(&format!("{region} -o ."), 1, "constant/air");
    folder.ok(&format!("{region} -o constant/air --periodic z"));
    assert!(!folder.read("constant/air/F").is_empty());
}

/// A tube of radius 1 and length 2, as a section beside its axis, closed by disks.
#[test]
fn axisymmetric_elements_are_bodies_of_revolution() {
    let folder = Folder::new();
    folder.write(
        "tube.inp",
        "*NODE\n1,1,0\n2,1.1,0\n3,1.1,2\n4,1,2\n5,0,-.1\n6,1,-.1\n7,0,0\n8,0,2\n9,1,2.1\n10,0,2.1\n\
         *ELEMENT, TYPE=DCAX4\n1,1,2,3,4\n2,5,6,1,7\n3,8,4,9,10\n\
         *SURFACE, NAME=tube\n1,S4\n*SURFACE, NAME=bottom\n2,S3\n*SURFACE, NAME=top\n3,S1\n",
    );
    let words = folder.ok("info tube.inp").out;
    assert!(words.contains("--revolve 64"), "{words}");
    folder.ok(
        "form-factors tube.inp -o f.csv --revolve 96 --by object --patch-size 0 --engine analytic",
    );
    let found = factors(&folder, "f.csv");
    for (from, to, expected) in [
        ("tube", "tube", 0.585_786),
        ("bottom", "top", 0.171_573),
        ("bottom", "tube", 0.828_427),
        ("tube", "top", 0.207_107),
    ] {
        let factor = of(&found, from, to);
        assert!((factor - expected).abs() < 5e-4, "{from} {to}: {factor}");
    }
    folder.fails("info tube.inp --revolve 2", 2, "3..=3600");
}
