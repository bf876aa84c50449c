//! Form factors in stores of chunks: written, converted, refused where damaged, and solved out of core.

use crate::support::Folder;
use std::fs;

/// A room with patches, and tables for it.
fn room() -> Folder {
    let folder = Folder::with_room();
    folder.write("eps.csv", "name,eps\n*,0.7\n");
    folder.write("temperatures.csv", "name,T,q\nlamp,400,\n*,,0\nspace,3,\n");
    folder.ok("form-factors room.obj -o f.zarr --patches 300 --rays 256 --separate");
    folder
}

fn text(folder: &Folder, name: &str) -> String {
    String::from_utf8_lossy(&folder.read(name)).into_owned()
}

/// Files of a store with their content.
fn files(folder: &Folder, name: &str) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    let mut folders = vec![folder.path(name)];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let key = path.strip_prefix(folder.path(name)).unwrap();
                found.push((key.display().to_string(), fs::read(&path).unwrap()));
            }
        }
    }
    found.sort();
    found
}

#[test]
fn stores_convert_to_archives_and_back() {
    let folder = room();
    assert!(
        !folder
            .names()
            .iter()
            .any(|name| name.starts_with(".azulejo"))
    );
    // Any number of threads writes the same bytes, over the store of before.
    let first = files(&folder, "f.zarr");
    let mut command = folder.command(
        "form-factors room.obj -o f.zarr --patches 300 --rays 256 --separate --no-journal",
    );
    let status = command.env("RAYON_NUM_THREADS", "1").output().unwrap();
    assert!(status.status.success());
    assert!(files(&folder, "f.zarr") == first);
    folder.ok("form-factors f.zarr -o f.npz --precision single");
    folder.ok("form-factors f.npz -o g.zarr --precision single");
    folder.ok("form-factors g.zarr -o g.npz --precision single");
    // Both directions of a pair are rounded, so that their mean may differ in the last place.
    let factors = |name: &str| -> Vec<(String, f64)> {
        folder.ok(&format!("form-factors {name} -o list.csv"));
        let list = text(&folder, "list.csv");
        let fields = list
            .lines()
            .skip(1)
            .map(|line| line.split(',').collect::<Vec<_>>());
        fields
            .map(|f| (format!("{}-{}", f[0], f[1]), f[2].parse().unwrap()))
            .collect()
    };
    let (before, after) = (factors("f.npz"), factors("g.npz"));
    assert_eq!(before.len(), after.len());
    for (a, b) in before.iter().zip(&after) {
        assert!(a.0 == b.0 && (a.1 - b.1).abs() <= 2e-5 * a.1, "{a:?} {b:?}");
    }
    let info = folder.json("info g.zarr");
    assert_eq!(
        (&info["format"], &info["bits"]),
        (&"zarr".into(), &32.into())
    );
    assert_eq!(folder.json("info g.npz")["rows"], info["rows"]);
    // What reworks an .npz reworks a store.
    folder.ok("form-factors f.zarr -o by.csv --by object --truncate 0.1%");
    assert!(text(&folder, "by.csv").contains("walls"));
    folder.ok("form-factors f.zarr -o plain.zarr --compression none");
    let size = |name: &str| -> usize {
        let files = files(&folder, name);
        files.iter().map(|(_, content)| content.len()).sum()
    };
    assert!(size("plain.zarr") > size("f.zarr"));
    folder.ok("form-factors plain.zarr -o plain.npz --compression none");
    assert!(folder.read("plain.npz").len() > folder.read("f.npz").len());
}

#[test]
fn only_stores_are_replaced_and_damage_is_named() {
    let folder = room();
    fs::create_dir(folder.path("photos.zarr")).unwrap();
    folder.write("photos.zarr/a.png", "");
    folder.fails(
        "form-factors f.zarr -o photos.zarr",
        1,
        "photos.zarr: a folder with other things",
    );
    folder.write("file.zarr", "");
    folder.fails(
        "form-factors f.zarr -o file.zarr",
        1,
        "a file, expected a folder",
    );
    folder.fails("form-factors file.zarr -o g.npz", 1, "file.zarr: zarr.json");
    folder.fails(
        "form-factors none.zarr -o g.npz",
        1,
        "none.zarr: zarr.json: there is no such file",
    );
    folder.fails(
        "form-factors f.zarr -o g.csv --compression none",
        2,
        "--compression",
    );
    folder.fails(
        "form-factors f.zarr -o g.npz --rays 9",
        2,
        "--rays: the factors of an .npz or .zarr",
    );
    folder.fails(
        "form-factors f.zarr -o g.npz --memory 1M",
        1,
        "allow more with --memory",
    );
    let chunk = folder.read("f.zarr/direct/c/0");
    folder.write("f.zarr/direct/c/0", &chunk[..chunk.len() / 2]);
    for command in ["form-factors f.zarr -o g.npz", "info f.zarr"] {
        folder.fails(command, 1, "f.zarr: direct/c/0: ");
    }
    fs::remove_file(folder.path("f.zarr/direct/c/0")).unwrap();
    folder.fails("info f.zarr", 1, "direct/c/0: this chunk is missing");
    fs::remove_file(folder.path("f.zarr/zarr.json")).unwrap();
    folder.fails("info f.zarr", 1, "is the store whole?");
}

/// The same bytes whether the matrix is in memory or read from the store in each product: for few rows, which
/// are factored, and for many, which are solved by conjugate gradients.
#[test]
fn exchange_out_of_core_writes_the_same_bytes() {
    let folder = room();
    folder.ok("form-factors room.obj -o many.zarr --patches 2300 --rays 16 --compression none");
    let solve = "--materials eps.csv --boundary temperatures.csv";
    for name in ["f", "many"] {
        let outputs = |kind: &str| format!("-o {kind}.npz -o {kind}.csv -o {kind}.vtu");
        folder.ok(&format!(
            "exchange {name}.zarr {solve} {}",
            outputs("inside")
        ));
        let run = folder.ok(&format!(
            "exchange {name}.zarr {solve} {} --memory 1M",
            outputs("outside")
        ));
        assert!(
            run.err
                .contains("it is read from the store for each product"),
            "{}",
            run.err
        );
        for extension in ["npz", "csv"] {
            let [inside, outside] =
                ["inside", "outside"].map(|kind| folder.read(&format!("{kind}.{extension}")));
            assert!(inside == outside, "{name}: {extension}");
        }
        // Sums of rows are added up in another order there: their last digits may differ.
        let arrays = |name: &str| -> Vec<String> {
            let text = text(&folder, name);
            let names = text.split("Name=\"").skip(1);
            names
                .map(|rest| rest.split('"').next().unwrap_or_default().to_owned())
                .collect()
        };
        assert!(arrays("inside.vtu").contains(&"row_sum".to_owned()));
        assert_eq!(arrays("inside.vtu"), arrays("outside.vtu"));
    }
}
