//! `probe --year`: all hours of a weather file, against sums by hand and against single hours.

use crate::support::Folder;
use azulejo_formats::numpy::npz::NpzReader;
use azulejo_scene::sky::sun_position;
use std::fmt::Write;
use std::io::Cursor;

/// Days of the months of 2025.
const DAYS: [u32; 12] = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];

/// When 2025 begins in the time zone of the file, Unix seconds.
const BEGIN: f64 = 1_735_689_600.0 - 3600.0;

const PLACE: [f64; 2] = [48.13, 11.7];

/// Direct normal and diffuse horizontal irradiance of an hour of a day, both from 0: clear days and cloudy ones.
fn weather(day: u32, hour: u32) -> [u32; 2] {
    if !(6..19).contains(&hour) {
        return [0; 2];
    }
    match (day * 7 + hour / 4) % 5 {
        0 => [0, 90 + 10 * (day % 7)],
        k => [150 * k, 60 + 10 * (hour % 5)],
    }
}

/// A weather file of a year, without the hours that are `left_out`.
pub fn weather_file(left_out: impl Fn(u32, u32) -> bool) -> String {
    let [latitude, longitude] = PLACE;
    let mut file = format!(
        "LOCATION,Munich,-,DEU,made up,0,{latitude},{longitude},1.0,529.0\nDATA PERIODS,1,1,Data,Sunday,1/1,12/31\n"
    );
    let mut day = 0;
    for (month, days) in (1..).zip(DAYS) {
        for day_of_month in 1..=days {
            for hour in (0..24).filter(|&hour| !left_out(day, hour)) {
                let [dni, dhi] = weather(day, hour);
                let end = hour + 1;
                writeln!(
                    file,
                    "1996,{month},{day_of_month},{end},60,?9,12.0,7.5,60,95600,0,1300,300,400,{dni},{dhi},0,0"
                )
                .unwrap();
            }
            day += 1;
        }
    }
    file
}

/// A folder with models and the weather of a year.
fn folder(models: &[(&str, &str)]) -> Folder {
    let folder = Folder::new();
    folder.write("year.epw", weather_file(|_, _| false));
    models
        .iter()
        .for_each(|(name, text)| folder.write(name, text));
    folder
}

/// An array of an archive.
fn array(folder: &Folder, name: &str) -> Vec<f64> {
    let mut archive = NpzReader::new(Cursor::new(folder.read("year.npz")), 1 << 24).unwrap();
    archive.array(name).unwrap().unwrap().numbers().unwrap()
}

/// The lines of `year.csv`, as numbers: sum, sun, sky, reflected, standard error.
fn sums(folder: &Folder) -> Vec<Vec<f64>> {
    let text = String::from_utf8(folder.read("year.csv")).unwrap();
    assert!(
        text.starts_with("x,y,z,nx,ny,nz,sum,direct_sun,sky,reflected,std_error\n"),
        "{text}"
    );
    let line = |line: &str| {
        line.split(',')
            .skip(6)
            .map(|word| word.parse().unwrap())
            .collect()
    };
    text.lines().skip(1).map(line).collect()
}

/// Σ DNI · max(0, n · s) and Σ DHI over the year, kWh/m², with the sun in the middle of each hour; the normal has its
/// parts to the east, the north and the zenith. With the table of irradiance by sun and sky of each hour.
fn by_hand(normal: [f64; 3]) -> ([f64; 2], Vec<[f64; 2]>) {
    let hours = (0..8760u32).map(|k| {
        let [dni, dhi] = weather(k / 24, k % 24);
        let middle = BEGIN + 3600.0 * (f64::from(k) + 0.5);
        let sun = sun_position(middle, PLACE[0], PLACE[1]).unwrap();
        let toward = sun.toward().to_array();
        let cosine: f64 = toward.iter().zip(normal).map(|(a, b)| a * b).sum();
        let cosine = if sun.is_up() { cosine.max(0.0) } else { 0.0 };
        [f64::from(dni) * cosine, f64::from(dhi)]
    });
    let hours: Vec<[f64; 2]> = hours.collect();
    let sum = |i: usize| hours.iter().map(|hour| hour[i] / 1000.0).sum();
    ([sum(0), sum(1)], hours)
}

#[track_caller]
fn near(found: f64, truth: f64, share: f64) {
    assert!(
        (found - truth).abs() < share * truth,
        "{found}, expected {truth}"
    );
}

/// Ground of which half of the light returns, 2 km wide, y up.
const GROUND: &str = "mtllib ground.mtl\nusemtl grey\nv -1000 0 -1000\nv -1000 0 1000\nv 1000 0 1000\nv 1000 0 -1000\nf 1 2 3 4\n";

#[test]
fn open_sensors_receive_what_the_file_says() {
    let folder = folder(&[
        ("ground.obj", GROUND),
        ("ground.mtl", "newmtl grey\nKd 0.5 0.5 0.5\n"),
        // Level, to the south, and level below the ground.
        ("points.txt", "0 1 0 0 1 0\n0 1 0 0 0 1\n0 -1 0 0 -1 0\n"),
    ]);
    let probe = "probe ground.obj --points points.txt --weather year.epw --year --patch-size 0";
    folder.ok(&format!("{probe} -o year.npz"));
    folder.ok(&format!("{probe} -o year.csv --threads 1"));
    let ([sun, sky], hours) = by_hand([0.0, 0.0, 1.0]);
    let found = sums(&folder);
    let [sum, direct, of_sky, reflected, error] = found[0][..] else {
        panic!("{found:?}")
    };
    near(sum, sun + sky, 0.005);
    near(direct, sun, 1e-5);
    near(of_sky, sky, 0.005);
    assert!(reflected < 1e-3 * sum && error < 0.005 * sum, "{found:?}");
    // What the upright one sees of the ground gives back half of what arrives there.
    let (([south, _], _), upright) = (by_hand([0.0, -1.0, 0.0]), &found[1]);
    near(upright[1], south, 1e-5);
    near(upright[3], 0.25 * (sun + sky), 0.01);
    // From below there is only the ground below the horizon, which is as bright as under an open sky.
    near(found[2][0], 0.2 * (sun + sky), 0.01);
    // The table has every hour, and the sums are its own to the bit for any number of threads.
    let table = array(&folder, "irradiance");
    assert_eq!(table.len(), 8760 * 3);
    for (row, [sun, sky]) in table.chunks(3).zip(&hours) {
        assert!(
            (row[0] - sun - sky).abs() < 0.006 * (sun + sky) + 1e-6,
            "{row:?} {sun} {sky}"
        );
    }
    let sums_of_table = array(&folder, "sum");
    near(sums_of_table[0], sum, 1e-6);
    let times = array(&folder, "time");
    assert!((times[0] - 0.5).abs() < 1e-12 && (times[8759] - 8759.5).abs() < 1e-9);
}

/// A grey room, open to the south, z up: 4 × 5 × 3; the pane closes it.
fn room(with_pane: bool) -> String {
    let mut text = "m grey =\n\tsides 2\n\trd 0.5\nm glass =\n\tsides 2\n\tir 1.5 0\n\tc\n\t\tcxy 0.25 0.45\n\tts 0.7 0\n".to_owned();
    let corners = [
        [0, 0, 0],
        [4, 0, 0],
        [4, 5, 0],
        [0, 5, 0],
        [0, 0, 3],
        [4, 0, 3],
        [4, 5, 3],
        [0, 5, 3],
    ];
    for (k, [x, y, z]) in corners.iter().enumerate() {
        writeln!(text, "v v{k} =\n\tp {x} {y} {z}").unwrap();
    }
    text += "m grey\nf v0 v1 v2 v3\nf v4 v7 v6 v5\nf v1 v5 v6 v2\nf v2 v6 v7 v3\nf v3 v7 v4 v0\n";
    if with_pane {
        text += "m glass\nf v0 v4 v5 v1\n";
    }
    text
}

/// On the floor, in the sun and behind it, and on a wall.
const IN_ROOM: &str = "2 1 0.8  0 0 1\n2 4 0.8  0 0 1\n3.9 3 1.5  -1 0 0\n";

/// The mean of the channels at the points, and its standard error, in an hour by its middle.
fn at(folder: &Folder, model: &str, time: &str) -> Vec<[f64; 2]> {
    let out = folder.ok(&format!(
        "probe {model} --points points.txt --weather year.epw --solar --rays 2048 --time 2025-{time}+01:00"
    ));
    let row = |line: &str| {
        let n: Vec<f64> = line.split(' ').map(|word| word.parse().unwrap()).collect();
        [(n[0] + n[1] + n[2]) / 3.0, (n[3] + n[4] + n[5]) / 3.0]
    };
    out.out.lines().map(row).collect()
}

/// Hours in a room are those that the radiosity of each alone finds.
#[test]
fn hours_in_a_room_are_those_of_a_single_instant() {
    let (open, closed) = (room(false), room(true));
    let folder = folder(&[
        ("open.mgf", &open),
        ("pane.mgf", &closed),
        ("points.txt", IN_ROOM),
    ]);
    for model in ["open.mgf", "pane.mgf"] {
        folder.ok(&format!(
            "probe {model} --points points.txt --weather year.epw --year --solar --patches 300 -o year.npz"
        ));
        let table = array(&folder, "irradiance");
        let times = [
            ("06-21T10:30", 171 * 24 + 10),
            ("12-20T12:30", 353 * 24 + 12),
            ("03-02T15:30", 60 * 24 + 15),
        ];
        for (time, record) in times {
            for (k, [expected, error]) in at(&folder, model, time).into_iter().enumerate() {
                let found = table[record * 3 + k];
                let margin = 4.0 * error + 0.05 * expected;
                assert!(
                    (found - expected).abs() < margin,
                    "{model} {time} {k}: {found}, {expected} ± {error}"
                );
            }
        }
    }
}

#[test]
fn years_with_gaps_are_refused_and_nothing_is_written() {
    let folder = folder(&[
        ("ground.obj", GROUND),
        ("ground.mtl", ""),
        ("points.txt", "0 1 0 0 1 0\n"),
    ]);
    let probe = "probe ground.obj --points points.txt --year -o out.npz --weather";
    folder.write("gap.epw", weather_file(|day, hour| (day, hour) == (40, 7)));
    folder.fails(
        &format!("{probe} gap.epw"),
        1,
        "gap.epw: line 970: found hour 9 of 10/2, expected hour 8 of 10/2",
    );
    folder.write("half.epw", weather_file(|day, _| day > 181));
    folder.fails(
        &format!("{probe} half.epw"),
        1,
        "expected hour 1 of 2/7 after it",
    );
    let missing = weather_file(|_, _| false).replacen(",0,0,0,0\n", ",9999,0,0,0\n", 1);
    folder.write("missing.epw", missing);
    folder.fails(
        &format!("{probe} missing.epw"),
        1,
        "line 3: found no direct normal irradiance (9999)",
    );
    folder.write(
        "columns.epw",
        weather_file(|_, _| false).replace(",7.5,60,95600,", ","),
    );
    folder.fails(&format!("{probe} columns.epw"), 1, "line 3: found ");
    for (line, words) in [
        (format!("{probe} year.epw --memory 1M"), "1 points need"),
        (
            format!("{probe} year.epw --engine particles"),
            "particles have no form factors",
        ),
        (
            format!("{} year.epw", probe.replace("out.npz", "out.txt")),
            "out.txt: a year is written as .csv",
        ),
        (
            format!("{probe} year.epw --time 2025-06-21T10:30Z"),
            "cannot be used with",
        ),
        (
            format!("{probe} year.epw --shard 1/2"),
            "--shard and --year",
        ),
    ] {
        let run = folder.run(&line);
        assert!(
            run.code != Some(0) && run.err.contains(words),
            "{line}: {}",
            run.err
        );
    }
    assert!(
        !folder.names().iter().any(|name| name.starts_with("out")),
        "{:?}",
        folder.names()
    );
}
