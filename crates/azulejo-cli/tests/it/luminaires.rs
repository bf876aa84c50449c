//! Luminaires of photometric files: their light arrives where the file says.

use crate::support::Folder;

/// A wallwasher: k cos γ, k = 1000/π cd, across its wall, twice as much toward it and nothing away from it.
fn wallwasher() -> String {
    let plane = |factor: f64| {
        let angles = (0..=90).step_by(5).map(f64::from);
        let candela = |a: f64| factor * 1000.0 / std::f64::consts::PI * a.to_radians().cos();
        let values: Vec<String> = angles.map(|a| format!("{:.4}", candela(a))).collect();
        values.join(" ")
    };
    let angles: Vec<String> = (0..=90).step_by(5).map(|a| a.to_string()).collect();
    format!(
        "IESNA:LM-63-2002\n[LUMINAIRE] Wallwasher\nTILT=NONE\n1 1000 1 19 3 1 2 0.1 0.1 0\n1 1 30\n{}\n0 90 180\n{}\n{}\n{}\n",
        angles.join(" "),
        plane(2.0),
        plane(1.0),
        plane(0.0)
    )
}

/// The first numbers of the lines that `probe` writes.
fn lux(folder: &Folder, line: &str) -> Vec<f64> {
    let text = folder.ok(line).out;
    let first = |line: &str| line.split_whitespace().next().unwrap().parse().unwrap();
    text.lines().map(first).collect()
}

fn check(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert!(
            (a - b).abs() < 2e-3 * b.max(1.0),
            "{found:?}, expected {expected:?}"
        );
    }
}

/// E = I cos³ γ / h² at 8 m, on sensors without any surface.
#[test]
fn a_wallwasher_shines_to_its_wall() {
    let folder = Folder::new();
    folder.write("wash.ies", wallwasher());
    folder.write("wash.mgf", "ies wash.ies -t 0 0 8\n");
    let far = 16.0 / 3.0;
    folder.write(
        "points.txt",
        format!(
            "0 0 0 0 0 1\n{far} 0 0 0 0 1\n{} 0 0 0 0 1\n0 {far} 0 0 0 1\n",
            -far
        ),
    );
    let below = 1000.0 / std::f64::consts::PI / 64.0;
    let aside = below * (8.0 / (far * far + 64.0f64).sqrt()).powi(4);
    let expected = [below, 2.0 * aside, 0.0, aside];
    check(
        &lux(&folder, "probe wash.mgf --points points.txt -o -"),
        &expected,
    );
    let placed = "probe wash.ies --place wash.ies:translate=0,0,8 --points points.txt -o -";
    check(&lux(&folder, placed), &expected);
    // GRF keeps it.
    folder.ok("convert wash.mgf -o wash.grf");
    check(
        &lux(&folder, "probe wash.grf --points points.txt -o -"),
        &expected,
    );
    // In millimetres, a quarter of a turn, and half of the light: beside an empty model, as its lamp.
    folder.write("far.obj", "v 0 0 -9e6\nv 1 0 -9e6\nv 1 1 -9e6\nf 1 2 3\n");
    folder.write(
        "points.txt",
        "0 5333.333333 0 0 0 1\n5333.333333 0 0 0 0 1\n",
    );
    let flux = folder.json("info wash.ies")["luminaires"][0]["flux"]
        .as_f64()
        .unwrap();
    let lamp = format!("wash.ies@0,0,8000,0,90,0,lm={}", flux / 2.0);
    let line = format!(
        "probe far.obj --up z --unit mm --place far.obj:up=z,unit=mm --lamp {lamp} --points points.txt -o -"
    );
    // Scenes of OBJ are in watts, of which one is 179 lm.
    let found: Vec<f64> = lux(&folder, &line)
        .iter()
        .map(|watts| 179.0 * watts)
        .collect();
    check(&found, &[aside, aside / 2.0]);
}

/// A closed box of 4 × 3 × 4, y up, that reflects the half.
const BOX: &str = "v 0 0 0\nv 4 0 0\nv 4 0 4\nv 0 0 4\nv 0 3 0\nv 4 3 0\nv 4 3 4\nv 0 3 4\n\
    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// The lamp shines by shadow rays and by particles alike.
#[test]
fn both_ways_of_light_see_the_distribution() {
    let folder = Folder::new();
    folder.write("wash.ies", wallwasher());
    folder.write("box.obj", BOX);
    folder.write(
        "points.txt",
        "2 .01 1.5 0 1 0\n3.2 .01 2.5 0 1 0\n.8 .01 1 0 1 0\n3.99 1 2 -1 0 0\n",
    );
    let lamp = "--lamp wash.ies@2,2.4,2,20,30,10";
    let line = |more: &str| format!("probe box.obj {lamp} --points points.txt {more} -o -");
    let by_rays = lux(&folder, &line("--error 1%"));
    let by_particles = lux(
        &folder,
        &line("--engine particles --patches 300 --rays 4096"),
    );
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let ratio = mean(&by_particles) / mean(&by_rays);
    assert!((ratio - 1.0).abs() < 0.02, "{by_rays:?} {by_particles:?}");
    // A recipe hangs it at the same place.
    folder.write(
        "lamps.toml",
        "[[light]]\nkind = \"luminaire\"\nfile = \"wash.ies\"\nposition = [2, 2.4, 2]\ntilt = 20\nrotation = 30\nspin = 10\n",
    );
    let by_recipe = lux(
        &folder,
        "probe box.obj --recipe lamps.toml --points points.txt --error 1% -o -",
    );
    assert_eq!(by_recipe, by_rays);
    folder.write(
        "none.toml",
        "[[light]]\nkind = \"luminaire\"\nposition = [2, 2.4, 2]\n",
    );
    folder.fails(
        "info box.obj --recipe none.toml",
        1,
        "none.toml:1:1: a luminaire needs a `file`",
    );
    let bare = lux(&folder, &line("--bounces 0"));
    assert!(mean(&by_rays) > 1.1 * mean(&bare));
}

/// A lamp that burns worse where it is tilted, by the table of another file (LM-63, `TILT=` a name).
#[test]
fn tilted_lamps_have_what_is_left_of_their_light() {
    let folder = Folder::new();
    folder.write("box.obj", BOX);
    folder.write("points.txt", "2 .01 2 0 1 0\n");
    folder.write("plain.ies", wallwasher());
    folder.write(
        "tilted.ies",
        wallwasher().replace("TILT=NONE", "TILT=hid.tlt"),
    );
    let seen = |file: &str, tilt: u32| {
        let line = "probe box.obj --points points.txt --bounces 0 -o - --lamp";
        lux(&folder, &format!("{line} {file}@2,2.4,2,{tilt}"))[0]
    };
    assert_eq!(seen("tilted.ies", 0), seen("plain.ies", 0));
    folder.fails(
        "info box.obj --lamp tilted.ies@2,2.4,2,30",
        1,
        "hid.tlt: found",
    );
    folder.write("hid.tlt", "1\n2\n0 60\n1 0.5\n");
    let ratio = seen("tilted.ies", 30) / seen("plain.ies", 30);
    assert!((ratio - 0.75).abs() < 1e-12, "{ratio}");
}

#[test]
fn luminaires_are_described_and_plotted() {
    let folder = Folder::new();
    folder.write("wash.ies", wallwasher());
    folder.write("box.obj", BOX);
    let found = folder.json("info wash.ies -o polar.svg");
    let lamp = &found["luminaires"][0];
    assert_eq!(lamp["name"], "Wallwasher");
    // π k over the half sphere, of the chords between 5 degrees.
    let flux = lamp["flux"].as_f64().unwrap();
    assert!((flux / 1000.0 - 1.0).abs() < 1e-3, "{flux}");
    let most = lamp["intensity_most"].as_f64().unwrap();
    assert!((most - 636.6198).abs() < 1e-3);
    let plot = String::from_utf8(folder.read("polar.svg")).unwrap();
    assert!(plot.starts_with("<svg") && plot.contains("Wallwasher") && plot.contains("C90"));
    folder.fails("info box.obj -o polar.svg", 1, "no luminaire");
}

#[test]
fn what_is_no_luminaire_is_said() {
    let folder = Folder::new();
    folder.write("room.obj", BOX);
    folder.write("wash.ies", wallwasher());
    folder.write("broken.ies", wallwasher().replace("0 90 180", "0 90 x"));
    let check = |lamp: &str, code: i32, expected: &str| {
        folder.fails(&format!("info room.obj --lamp {lamp}"), code, expected);
    };
    check("wash.ies", 2, "FILE@X,Y,Z");
    check("wash.ies@1,2", 2, "FILE@X,Y,Z");
    check("wash.ies@1,2,3,4,5,6,7", 2, "7 numbers");
    check("wash.ies@1,2,3,power=3", 2, "expected lm, cct or set");
    check("none.ies@1,2,3", 1, "none.ies");
    check("wash.ies@1,2,3,lm=0", 1, "above 0");
    check("wash.ies@1,2,3,set=2", 1, "set 1");
    check("broken.ies@1,2,3", 1, "broken.ies:7:6");
    check("room.obj@1,2,3", 1, "room.obj");
}
