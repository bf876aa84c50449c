//! Layers of pictures, and the filter, on the command line.

use crate::support::{Folder, project};
use azulejo_formats::picture::cryptomatte;
use azulejo_formats::picture::exr::{self, ChannelValues, NamedChannel};

fn floats<'c>(channels: &'c [NamedChannel], name: &str) -> &'c [f32] {
    let found = channels.iter().find(|c| c.name == name);
    match found.map(|c| &c.values) {
        Some(ChannelValues::Float(values)) => values,
        other => panic!("{name}: {other:?}"),
    }
}

fn indices<'c>(channels: &'c [NamedChannel], name: &str) -> &'c [u32] {
    let found = channels.iter().find(|c| c.name == name);
    match found.map(|c| &c.values) {
        Some(ChannelValues::Index(values)) => values,
        other => panic!("{name}: {other:?}"),
    }
}

/// A box with glossy surfaces and a word of three letters in it.
fn folder() -> Folder {
    let folder = Folder::with_room();
    let scene = std::fs::read(project().join("examples/cornell-glossy.grf")).unwrap();
    folder.write("box.grf", scene);
    let font = project().join("examples/fonts/dejavu-serif.ppf");
    let text = format!("text LUZ --font {} -o word.grf", font.display());
    folder.ok(&text);
    folder
}

#[test]
fn layers_add_up_and_name_what_is_seen() {
    let folder = folder();
    let size = "--size 32x24 --spp 8 -o x.exr --layers all";
    for how in ["--reference", "--rays 256", "--rays 256 --gather 8"] {
        folder.ok(&format!("render box.grf {how} {size}"));
        let (_, channels) = exr::read_channels(&folder.read("x.exr")).unwrap();
        let names: Vec<&str> = channels.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names.len(), 3 + 3 + 3 + 1 + 3 + 9, "{names:?}");
        for color in ["R", "G", "B"] {
            let of = |layer: &str| floats(&channels, &format!("{layer}{color}"));
            let parts = of("direct.").iter().zip(of("indirect."));
            for ((direct, indirect), whole) in parts.zip(of("")) {
                let difference = (direct + indirect - whole).abs();
                assert!(difference <= 1e-5 * direct.abs().max(whole.abs()), "{how}");
            }
            assert!(of("albedo.").iter().all(|a| (0.0..=1.0).contains(a)));
            assert!(of("error.").iter().all(|e| *e >= 0.0));
        }
        // The camera stands 800 mm before the open front of a box of 559 mm.
        let depth = floats(&channels, "Z");
        let inside = |z: &&f32| (800.0..1360.0).contains(*z);
        assert!(depth.iter().filter(inside).count() > 500, "{depth:?}");
        let objects = indices(&channels, "objectId");
        assert_eq!(
            objects.iter().all(|&id| id > 0),
            depth.iter().all(|&z| z < 1e10)
        );
    }
}

#[test]
fn letters_are_told_apart() {
    let folder = folder();
    folder.ok(
        "render word.grf --studio --reference --spp 2 --size 60x40 -o w.exr --layers glyph,depth",
    );
    let (size, channels) = exr::read_channels(&folder.read("w.exr")).unwrap();
    assert_eq!((size, channels.len()), ((60, 40), 5));
    let mut glyphs = indices(&channels, "glyphId").to_vec();
    glyphs.sort_unstable();
    glyphs.dedup();
    assert_eq!(glyphs, [0, 1, 2, 3]);
}

/// Coverage by Cryptomatte is that of the ids, and its ids are those of the names in the file's attributes.
#[test]
fn mattes_cover_what_is_seen() {
    let folder = folder();
    let line = "render word.grf --studio --rays 16 --spp 16 --size 60x40 --layers cryptomatte,object,glyph";
    folder.ok(&format!("{line} -o w.exr"));
    let file = folder.read("w.exr");
    folder.ok(&format!("{line} -o again.exr --threads 1"));
    assert!(folder.read("again.exr") == file, "the same bytes");
    let (_, channels) = exr::read_channels(&file).unwrap();
    let attributes = String::from_utf8_lossy(&file).into_owned();
    for (layer, names) in [
        ("CryptoObject", vec!["LUZ/1", "LUZ/2", "LUZ/3"]),
        ("CryptoAsset", vec!["LUZ"]),
        ("CryptoMaterial", vec!["LUZ"]),
    ] {
        let ids: Vec<f32> = names.iter().map(|name| cryptomatte::id(name)).collect();
        for (name, id) in names.iter().zip(&ids) {
            let said = format!("\"{name}\":\"{:08x}\"", id.to_bits());
            assert!(attributes.contains(&said), "{layer} {said}");
        }
        let pair = |rank: usize| {
            let [id, coverage] = [["r", "g"], ["b", "a"]][rank % 2];
            let of = |letter: &str| floats(&channels, &format!("{layer}{:02}.{letter}", rank / 2));
            (of(id), of(coverage))
        };
        let mut sums = vec![0.0; 60 * 40];
        let mut seen = vec![0.0; ids.len()];
        for rank in 0..6 {
            let (of_id, coverage) = pair(rank);
            for ((sum, id), covered) in sums.iter_mut().zip(of_id).zip(coverage) {
                *sum += covered;
                if let Some(k) = ids.iter().position(|known| known == id) {
                    seen[k] += covered;
                }
            }
        }
        assert!(sums.iter().all(|s| *s < 1.0 + 1e-6), "{layer}");
        let seen_at_all = indices(&channels, "objectId").iter().filter(|id| **id > 0);
        let (total, count) = (sums.iter().sum::<f32>(), seen_at_all.count() as f32);
        assert!(
            (total / count - 1.0).abs() < 0.05,
            "{layer} {total} {count}"
        );
        let glyphs = indices(&channels, "glyphId");
        for (k, covered) in seen.iter().enumerate() {
            let is_it = |g: &&u32| {
                if ids.len() == 1 {
                    **g > 0
                } else {
                    **g == k as u32 + 1
                }
            };
            let pixels = glyphs.iter().filter(is_it).count() as f32;
            assert!(
                (covered / pixels - 1.0).abs() < 0.25,
                "{layer} {k} {covered} {pixels}"
            );
        }
    }
}

#[test]
fn layers_need_their_format() {
    let folder = folder();
    for name in ["x.png", "x.hdr"] {
        let line = format!("render room.obj -o {name} --layers all");
        folder.fails(&line, 2, "ends in .exr");
    }
    folder.fails("render room.obj -o x.exr --layers light", 2, "albedo");
}

#[test]
fn denoised_pictures_say_what_was_done() {
    let folder = folder();
    let line = "render box.grf --reference --spp 16 --size 48x48 --denoise";
    let report = folder.json(&format!("{line} -o x.png"));
    let of = |key: &str| report[key].as_f64().unwrap();
    assert!(
        of("denoised_error") < 0.6 * of("denoised_error_before"),
        "{report}"
    );
    assert!(
        of("denoised_change") > 0.0 && of("denoised_bias").abs() < 0.1,
        "{report}"
    );
    folder.ok(&format!("{line} -o one.exr --threads 1"));
    folder.ok(&format!("{line} -o two.exr --threads 2"));
    assert_eq!(folder.read("one.exr"), folder.read("two.exr"));
    folder.fails("render room.obj -o x.png --spp 2 --denoise", 2, "--spp 4");
}
