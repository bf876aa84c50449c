//! Light from outside, by the command.

use crate::support::Folder;
use azulejo_formats::numpy::npz::NpzReader;
use serde_json::json;
use std::f64::consts::PI;
use std::io::Cursor;

const PLANE: &str = "\
v -5 0 -5
v -5 0 5
v 5 0 5
v 5 0 -5
f 1 2 3 4
";

/// An open plane, and one point on it that faces up.
fn plane() -> Folder {
    let folder = Folder::new();
    folder.write("plane.obj", PLANE);
    folder.write("up.txt", "0 0 0 0 1 0\n");
    folder
}

/// Irradiance of the point in green, and its standard error.
fn irradiance(folder: &Folder, options: &str) -> [f64; 2] {
    let line = format!("probe {options} --points up.txt --rays 4096");
    let out = folder.ok(&line).out;
    let numbers: Vec<f64> = out.split_whitespace().map(|n| n.parse().unwrap()).collect();
    [numbers[1], numbers[4]]
}

#[track_caller]
fn check([found, error]: [f64; 2], truth: f64) {
    let margin = 4.0 * error + 1e-6 * truth;
    assert!(
        (found - truth).abs() < margin && error < 0.01 * truth,
        "{found} ± {error}, {truth}"
    );
}

#[test]
fn skies_and_suns_light_level_ground() {
    let folder = plane();
    check(irradiance(&folder, "plane.obj --sky 2"), 2.0 * PI);
    check(
        irradiance(&folder, "plane.obj --sky cie:12,300 --sun 200,35,0"),
        300.0,
    );
    let beam = 800.0 * 35f64.to_radians().sin();
    check(
        irradiance(&folder, "plane.obj --sky cie:12,300 --sun 200,35,800"),
        300.0 + beam,
    );
    check(irradiance(&folder, "plane.obj --sun dir:0,3,4,500"), 300.0);
    // In solar watts the sky of Perez gives the diffuse irradiance that was given.
    let weather = "plane.obj --sky perez:600,150 --sun 180,45 --solar";
    check(irradiance(&folder, weather), 150.0 + 600.0 * 0.5f64.sqrt());
}

/// Azimuths are clockwise from north, which is −z where y is up: a sun in the east casts light on
/// what faces +x.
#[test]
fn directions_are_those_of_the_compass() {
    let folder = plane();
    for (azimuth, faces) in [
        (0, "0 0 -1"),
        (90, "1 0 0"),
        (180, "0 0 1"),
        (270, "-1 0 0"),
    ] {
        folder.write("up.txt", format!("0 3 0 {faces}\n"));
        let line = format!("plane.obj --sun {azimuth},0.5,100 --ground none");
        let [found, _] = irradiance(&folder, &line);
        assert!(found > 99.0, "{azimuth}: {found}");
        let line = format!("plane.obj --sun {},0.5,100 --north 20", azimuth - 20);
        let [turned, _] = irradiance(&folder, &line);
        assert!((turned - found).abs() < 0.05, "{azimuth}: {turned}");
    }
}

#[test]
fn the_sun_stands_where_place_and_time_say() {
    let folder = plane();
    let when = "--place 48.14,11.58 --time 2025-06-21T13:15+02:00";
    // About 65.3 degrees high at noon of midsummer.
    let [found, _] = irradiance(&folder, &format!("plane.obj {when} --sun 1000"));
    let truth = 1000.0 * 65.3f64.to_radians().sin();
    assert!((found - truth).abs() < 0.2, "{found}, {truth}");
    let at_night =
        folder.ok("convert plane.obj -o n.grf --place 48.14,11.58 --sun 2025-06-21T01:00Z");
    assert!(
        at_night.err.contains("below the horizon"),
        "{}",
        at_night.err
    );
    for (line, words) in [
        ("--time 2025-06-21T13:15+02:00", "--place LAT,LON"),
        ("--place 48.14,11.58", "--time"),
        ("--sky cie:12", "--sun AZ,EL"),
        ("--sky perez:600,150", "--sun AZ,EL"),
        ("--time 2025-06-21T13:15", "offset"),
        ("--place 91,0 --time 60s", "latitude"),
        ("--sky cie:17", "1 to 16"),
    ] {
        let run = folder.run(&format!("probe plane.obj --points up.txt {line}"));
        assert_eq!(run.code, Some(2), "{line}: {}", run.err);
        assert!(run.err.contains(words), "{line}: {}", run.err);
    }
}

/// What lights a scene is in the file that is written.
#[test]
fn light_from_outside_is_saved() {
    let folder = plane();
    let options = "--sky cie:13,200 --sun 120,50,700 --background 0.1,0.2,0.3 --north 15";
    folder.ok(&format!("convert plane.obj -o day.grf {options}"));
    let lights = &folder.json("info day.grf")["lights"];
    assert_eq!(lights["environment"], json!(1));
    assert_eq!(lights["directional"], json!(1));
    let given = irradiance(&folder, &format!("plane.obj {options}"));
    let [saved, error] = irradiance(&folder, "day.grf");
    assert!((saved - given[0]).abs() < 1e-6 * saved, "{saved} {given:?}");
    assert!(error < 0.01 * saved);
}

/// A picture of 4 × 2 pixels, RGBE without compression: bright above, dark below.
fn write_picture(folder: &Folder, name: &str, size: &str) {
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n").into_bytes();
    for row in 0..2 {
        let e: [u8; 4] = if row == 0 {
            [128, 128, 128, 130]
        } else {
            [0; 4]
        };
        (0..4).for_each(|_| bytes.extend(e));
    }
    folder.write(name, bytes);
}

#[test]
fn pictures_give_light_and_are_seen() {
    let folder = plane();
    write_picture(&folder, "sky.hdr", "-Y 2 +X 4");
    // (128 + ½) / 256 · 4 above.
    let radiance = 128.5 / 64.0;
    check(
        irradiance(&folder, "plane.obj --environment sky.hdr"),
        radiance * PI,
    );
    let strong = "plane.obj --environment sky.hdr --environment-strength 3";
    check(irradiance(&folder, strong), 3.0 * radiance * PI);
    folder.ok("convert plane.obj -o lit.grf --environment sky.hdr --environment-rotate 90");
    check(irradiance(&folder, "lit.grf"), radiance * PI);
    let view = "--from 0,3,9 --at 0,2,0 --size 16x16 --spp 4";
    folder.ok(&format!("render lit.grf -o sky.exr {view}"));
    folder.ok(&format!(
        "render lit.grf -o reference.exr {view} --reference"
    ));
    folder.ok(&format!(
        "render plane.obj --sun 1,60 --background sky.hdr -o b.png {view}"
    ));
    write_picture(&folder, "odd.hdr", "-Y 1 +X 8");
    let odd = folder.run("convert plane.obj -o x.grf --environment odd.hdr");
    assert_eq!(odd.code, Some(1));
    assert!(odd.err.contains("twice as wide"), "{}", odd.err);
    let no_light = folder.run("convert plane.obj -o x.grf --environment plane.obj");
    assert!(no_light.err.contains(".hdr or .exr"), "{}", no_light.err);
}

#[test]
fn a_studio_lights_what_does_not_shine() {
    let folder = plane();
    folder.write("box.obj", CUBE);
    let dark = folder.run("render box.obj -o box.png --size 16x16");
    assert_eq!(dark.code, Some(1));
    for way in ["--studio", "--sky 1", "--sun"] {
        assert!(dark.err.contains(way), "{}", dark.err);
    }
    folder.ok("render box.obj -o box.png --size 16x16 --studio --error 10%");
    folder.ok("convert box.obj -o studio.grf --studio");
    let info = folder.json("info studio.grf");
    assert_eq!(info["lights"]["area"], json!(3));
    assert_eq!(info["cameras"].as_array().unwrap().len(), 1);
    // A studio is not built in a studio.
    folder.ok("convert studio.grf -o again.grf --studio");
    assert_eq!(folder.json("info again.grf")["objects"], info["objects"]);
}

/// A screen or a lamp of the model is not a reason to leave out the studio that was asked for.
#[test]
fn a_studio_is_added_to_what_shines() {
    let folder = plane();
    folder.write("lamp.mtl", "newmtl lamp\nKd 0.2 0.2 0.2\nKe 0.1 0.1 0.1\n");
    folder.write("lamp.obj", format!("mtllib lamp.mtl\nusemtl lamp\n{CUBE}"));
    folder.ok("convert lamp.obj -o lit.grf --studio");
    let lamps = &folder.json("info lit.grf")["lights"]["area"];
    assert_eq!(lamps, &json!(4), "the box and three lamps");
    // A lightmap would not show the lamps.
    folder.write("box.obj", CUBE);
    folder.ok("bake box.obj --studio --size 64 --error 20% -o baked.glb");
    folder.fails("render baked.glb -o x.png --studio", 2, "bake --strip");
}

/// Faces with two sides that face inward: seen from outside by the camera of the file, or an empty shell.
#[test]
fn an_inside_out_shell_with_two_sides_is_lit_from_outside() {
    let folder = plane();
    let cube = |camera: &str| {
        format!(
            "#VRML V2.0 utf8\n{camera}Shape {{ appearance Appearance {{ material Material {{ diffuseColor 0.8 0.3 \
             0.1 }} }} geometry IndexedFaceSet {{ solid FALSE coord Coordinate {{ point [ -1 -1 -1, 1 -1 -1, 1 1 -1, \
             -1 1 -1, -1 -1 1, 1 -1 1, 1 1 1, -1 1 1 ] }} coordIndex [ 0 1 2 3 -1 5 4 7 6 -1 4 0 3 7 -1 1 5 6 2 -1 \
             4 5 1 0 -1 3 2 6 7 -1 ] }} }}\n"
        )
    };
    let outside = "Viewpoint { position 3 2.5 5 orientation -0.6 0.77 0.2 0.66 }\n";
    for (name, camera) in [("seen.wrl", outside), ("alone.wrl", "")] {
        folder.write(name, cube(camera));
        folder.ok(&format!("convert {name} -o out.grf --studio"));
        assert_eq!(
            folder.json("info out.grf")["lights"]["area"],
            json!(3),
            "{name}"
        );
    }
    // From within it is a room.
    folder.write("room.wrl", cube("Viewpoint { position 0 0 0.9 }\n"));
    folder.ok("convert room.wrl -o out.grf --studio");
    assert_eq!(folder.json("info out.grf")["lights"]["area"], json!(1));
}

/// What a picture cannot show is said.
#[test]
fn black_pictures_say_why() {
    let folder = plane();
    folder.write("box.obj", CUBE);
    folder.write("lamp.mtl", "newmtl lamp\nKd 0.2 0.2 0.2\nKe 9 9 9\n");
    folder.write(
        "lamp.obj",
        "mtllib lamp.mtl\nusemtl lamp\nv 0.4 0.5 0.4\nv 0.6 0.5 0.4\nv 0.5 0.5 0.6\nf 1 2 3\n",
    );
    let black = folder.run(
        "render box.obj lamp.obj -o x.png --size 16x16 --error 20% --from 3,4,3 --at 0.5,0.5,0.5",
    );
    assert_eq!(black.code, Some(0), "{}", black.err);
    assert!(black.err.contains("no light reaches"), "{}", black.err);
    let away = "render box.obj -o x.png --studio --size 16x16 --error 20% --from 9,90,9 --at 9,99,9 --up 0,0,1";
    let away = folder.run(away);
    assert!(away.err.contains("no surface is in view"), "{}", away.err);
}

const CUBE: &str = "\
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
";

/// Several views have names of their own.
#[test]
fn several_pictures() {
    let folder = Folder::with_room();
    folder.ok("render room.obj -o turn.png --turntable 3 --size 8x8 --spp 1 --error 20%");
    let names = folder.names();
    for name in ["turn-001.png", "turn-002.png", "turn-003.png"] {
        assert!(names.contains(&name.to_owned()), "{names:?}");
    }
    assert!(!names.contains(&"turn.png".to_owned()));
    let none = folder.run("render room.obj -o x.png --cameras all");
    assert!(
        none.code == Some(1) && none.err.contains("no cameras"),
        "{}",
        none.err
    );
    let refused = folder.run("render room.obj -o - --turntable 3");
    assert!(refused.err.contains("one picture"), "{}", refused.err);
}

/// A picture of 1024 × 512 pixels with a sun at 45 degrees: what the floor receives is the same,
/// whether it comes from pixels or from the light that replaces them.
#[test]
fn the_sun_of_a_picture_becomes_a_light() {
    let folder = plane();
    let sky = |has_sun: bool| {
        let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 512 +X 1024\n".to_vec();
        for k in 0..512 * 1024 {
            let (row, column) = (k / 1024, k % 1024);
            let is_sun = (126..130).contains(&row) && (700..705).contains(&column);
            bytes.extend(if is_sun && has_sun {
                [128, 128, 128, 143]
            } else {
                [128, 128, 128, 129]
            });
        }
        bytes
    };
    folder.write("sun.hdr", sky(true));
    folder.write("cloud.hdr", sky(false));
    let [before, before_error] = irradiance(&folder, "plane.obj --environment sun.hdr");
    let [after, error] = irradiance(&folder, "plane.obj --environment sun.hdr --extract-sun");
    let [cloudy, _] = irradiance(&folder, "plane.obj --environment cloud.hdr");
    let tolerance = 4.0 * before_error.hypot(error) + 1e-3 * before;
    assert!(
        (before - after).abs() < tolerance,
        "{before} {after} ± {tolerance}"
    );
    assert!(before > 2.0 * cloudy, "{before} {cloudy}");
    let line = "convert plane.obj -o lit.grf --environment sun.hdr --extract-sun";
    let run = folder.ok(line);
    assert!(run.err.contains("20 pixels of"), "{}", run.err);
    // What is saved has no sun in its picture: it is not counted twice.
    let [saved, error] = irradiance(&folder, "lit.grf");
    assert!(
        (saved - after).abs() < 4.0 * error + 2e-3 * after,
        "{saved} {after}"
    );
    let none = folder.ok("convert plane.obj -o x.grf --environment cloud.hdr --extract-sun");
    assert!(none.err.contains("no sun found"), "{}", none.err);
    let alone = folder.run("convert plane.obj -o x.grf --extract-sun");
    assert_eq!(alone.code, Some(2));
}

/// The light that rows of form factors receive from outside is that of `probe` on the open floor.
#[test]
fn form_factors_give_the_light_from_outside() {
    let folder = plane();
    let options = "--sky cie:12,200 --sun 120,50,700";
    let [expected, error] = irradiance(&folder, &format!("plane.obj {options}"));
    let line = format!("form-factors plane.obj -o f.csv --patches 16 --rays 64 {options}");
    let report = folder.json(&line);
    let table = String::from_utf8(folder.read("f.csv")).unwrap();
    let rows = table.lines().filter(|l| l.contains(",irradiance,"));
    let mut count = 0;
    for row in rows {
        let words: Vec<&str> = row.split(',').collect();
        let [found, own] = [words[2], words[3]].map(|w| w.parse::<f64>().unwrap());
        let tolerance = 4.0 * own.hypot(error) + 1e-6 * expected;
        assert!(
            (found - expected).abs() < tolerance,
            "{row}, expected {expected} ± {error}"
        );
        assert!(own < 0.05 * found, "{row}");
        count += 1;
    }
    assert!(count >= 16, "{count} rows");
    let mean = report["irradiance_outside"].as_f64().unwrap();
    assert!((mean / expected - 1.0).abs() < 0.02, "{mean} {expected}");
    folder.ok("form-factors plane.obj -o dark.csv --patches 4 --rays 64");
    assert!(
        !String::from_utf8(folder.read("dark.csv"))
            .unwrap()
            .contains("irradiance")
    );
}

/// Level ground beside a wall: what its patches of the sky have is what it has of the sky, and matrices that were stored
/// keep them through groups.
#[test]
fn shares_of_the_sky_by_patches_add_up() {
    let folder = Folder::new();
    let ground = "v 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\n";
    let wall = "v 2 0 0\nv 2 1 0\nv 2 1 1\nv 2 0 1\n";
    folder.write(
        "court.obj",
        format!("{ground}{wall}o ground\nf 1 2 3 4\no wall\nf 5 6 7 8\n"),
    );
    let make = "form-factors court.obj -o patches.csv --patch-size 0.5 --sky-patches tregenza";
    let said = folder.ok(make).err;
    assert!(said.contains("145 (tregenza), and the ground"), "{said}");
    let text = |name: &str| String::from_utf8(folder.read(name)).unwrap();
    let patches = text("patches.csv");
    let share = |row: &str, of: &dyn Fn(&str) -> bool| -> f64 {
        let lines = patches
            .lines()
            .map(|line| line.split(',').collect::<Vec<_>>());
        let chosen = lines.filter(|cells| cells[0] == row && of(cells[1]));
        chosen.map(|cells| cells[2].parse::<f64>().unwrap()).sum()
    };
    for row in ["0", "3", "5"] {
        let (sky, patches) = (
            share(row, &|to| to == "sky"),
            share(row, &|to| to.starts_with("sky:")),
        );
        assert!(
            sky > 0.3 && (sky - patches).abs() < 1e-6,
            "{sky}, {patches}"
        );
    }
    // A file that has no place for them is refused before the work; a stored matrix has them or not.
    let refused = "form-factors court.obj -o a.vtu --sky-patches reinhart:2";
    folder.fails(refused, 2, "expected an .npz or a .csv");
    folder.ok("form-factors court.obj -o f.npz --patch-size 0.5 --sky-patches reinhart:2");
    folder.ok("form-factors f.npz -o by.csv --by object");
    assert!(text("by.csv").contains("ground,sky:577,"));
    let again = "form-factors f.npz -o g.npz --sky-patches tregenza";
    folder.fails(again, 2, "are computed");
    // Above the wall a globe sees each patch by its solid angle, and an element what its side of the sky has.
    folder.write("points.txt", "0.5 3 0.5\n");
    let from = "form-factors court.obj -o seen.npz --from points.txt --sky-patches tregenza";
    folder.ok(from);
    let mut archive = NpzReader::new(Cursor::new(folder.read("seen.npz")), 1 << 20).unwrap();
    let mut array = |name: &str| archive.array(name).unwrap().unwrap();
    let (shares, angles) = (array("sky_patches"), array("sky_solid_angles"));
    assert_eq!(shares.shape(), [1, 146]);
    let sum: f64 = (1..146).map(|k| shares.number(k)).sum();
    assert!((sum - array("sky").number(0)).abs() < 1e-6 && (sum - 0.5).abs() < 0.01);
    for k in 1..146 {
        let expected = angles.number(k) / (4.0 * PI);
        assert!((shares.number(k) - expected).abs() < 0.02 * expected, "{k}");
    }
    folder.write("points.txt", "0.5 3 0.5 0 1 0\n");
    folder.ok(&from.replace("seen.npz", "seen.csv"));
    let seen = text("seen.csv");
    let lines = seen.lines().filter(|line| line.contains(",sky:"));
    let shares = lines.map(|line| line.split(',').nth(2).unwrap().parse::<f64>().unwrap());
    assert!((shares.sum::<f64>() - 1.0).abs() < 1e-6);
}

/// The weather of an instant is the sky of Perez by the record of its hour, at the place of the file.
#[test]
fn weather_files_give_sun_and_sky() {
    let folder = Folder::with_room();
    folder.write("points.txt", "1 1 1 0 1 0\n");
    let head = "LOCATION,Somewhere,-,DEU,IWEC,108660,48.14,11.58,1.0,529.0\nDATA PERIODS,1,1,Data,Sunday,1/1,12/31\n";
    let row = |day: u32, hour: u32, light: &str| {
        format!("1996,{day},{hour},60,?9,12.0,7.5,60,95600,0,1300,300,400,{light},0,0\n")
            .replacen("1996,", "1996,6,", 1)
    };
    let rows = [
        row(21, 13, "9999,9999"),
        row(21, 14, "600,150"),
        row(21, 15, "100,50"),
    ]
    .concat();
    folder.write("year.epw", format!("{head}{rows}"));
    let probe = "probe room.obj --points points.txt -o - --rays 64 --solar --seed 3";
    // 14:00 of summer time is 13:00 of the file: the hour that ends at 14.
    let instant = "--time 2025-06-21T14:00+02:00";
    let by_file = folder.ok(&format!("{probe} --weather year.epw {instant}"));
    let by_hand = folder.ok(&format!(
        "{probe} --sky perez:600,150,7.5 --place 48.14,11.58 {instant}"
    ));
    assert_eq!(by_file.out, by_hand.out);
    let words = "weather of Somewhere on 21 June, 13:00 (UTC+01): 600 W/m² direct normal";
    assert!(by_file.err.contains(words), "{}", by_file.err);
    // Another place, with the weather of the file.
    let elsewhere = format!("--place 48.14,2.0 {instant}");
    let by_file = folder.ok(&format!("{probe} --weather year.epw {elsewhere}"));
    let by_hand = folder.ok(&format!("{probe} --sky perez:600,150,7.5 {elsewhere}"));
    assert_eq!(by_file.out, by_hand.out);
    for (more, code, words) in [
        ("", 2, "give --time"),
        (
            "--time 2025-06-21T13:30+02:00",
            1,
            "is missing on 21 June, 12:30 (UTC+01)",
        ),
        (
            "--time 2024-02-29T14:00Z",
            1,
            "it has no record of 29 February, 15:00",
        ),
        (
            "--time 2025-06-21T14:00+02:00 --sky cie:1",
            2,
            "cannot be used with",
        ),
    ] {
        folder.fails(&format!("{probe} --weather year.epw {more}"), code, words);
    }
    let model = format!("{probe} --weather room.obj {instant}");
    folder.fails(&model, 1, "room.obj: line 1: found ");
}
