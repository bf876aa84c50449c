//! What is written comes back.

use super::*;
use crate::enclosure::Enclosure;
use crate::enclosure::OutsideLight;
use crate::enclosure::tests::two_squares;
use crate::files::{FactorFileError, FactorFormat, FileOptions};
use azulejo_factors::form_factors::{ExchangeAreas, Plan, SkyFactors};
use azulejo_factors::hierarchy::{FactorOperator, StatedFactors};
use azulejo_factors::{
    CompressedFactors, CompressionOptions, Engine, FormFactorOptions, PatchSize,
};
use azulejo_formats::numpy::npy;
use azulejo_formats::numpy::npz::{NpzReader, NpzWriter};
use azulejo_scene::Rgb;
use azulejo_scene::sky::SkyDivision;
use azulejo_trace::Progress;
use std::io::Cursor;

const BUDGET: u64 = 1 << 24;

fn bytes(enclosure: &Enclosure, precision: ArchivePrecision) -> Vec<u8> {
    let mut bytes = Vec::new();
    write(enclosure, precision, &mut bytes).unwrap();
    bytes
}

fn back(bytes: &[u8]) -> ReadEnclosure {
    read(Cursor::new(bytes), BUDGET).unwrap()
}

/// Two squares with light from outside.
fn lit() -> Enclosure {
    let mut enclosure = two_squares();
    enclosure.factors.exchange = ExchangeAreas::sum_of(&enclosure.factors.orders);
    let row = OutsideLight {
        irradiance: Rgb::new(3.0, 2.0, 1.0),
        error: Rgb::new(0.3, 0.2, 0.1),
    };
    enclosure.outside = Some(vec![row, OutsideLight::default()]);
    enclosure.sky = Some(SkyFactors {
        division: SkyDivision::TREGENZA,
        north: 0.5,
        shares: (0..2 * 146).map(|k| k as f32).collect(),
        errors: vec![0.25; 2 * 146],
    });
    enclosure.factors.unseen = vec![0.125, 0.0];
    enclosure.factors.rays = 8192;
    enclosure.factors.engine_used.name = "rays".to_owned();
    enclosure.factors.ends[1] = 0.75;
    enclosure
}

#[test]
fn everything_comes_back() {
    let enclosure = lit();
    let read = back(&bytes(&enclosure, ArchivePrecision::Auto));
    assert_eq!(read.enclosure.factors, enclosure.factors);
    assert_eq!(read.enclosure.rows, enclosure.rows);
    assert_eq!(read.enclosure.outside, enclosure.outside);
    assert_eq!(read.enclosure.sky, enclosure.sky);
    assert_eq!((read.is_single, read.asymmetry), (false, 0.0));
    // A second time the bytes are the same.
    let again = bytes(&read.enclosure, ArchivePrecision::Auto);
    assert_eq!(again, bytes(&enclosure, ArchivePrecision::Auto));
}

#[test]
fn single_precision_rounds_and_errors_never_shrink() {
    let mut enclosure = two_squares();
    enclosure.factors.orders.clear();
    let mut pair = enclosure.factors.exchange.get(0, 1);
    pair.value = 0.6;
    enclosure.factors.exchange = ExchangeAreas::from_iter([vec![pair], vec![]]);
    let error = enclosure.factors.exchange.get(0, 1).error;
    let read = back(&bytes(&enclosure, ArchivePrecision::Single));
    assert!(read.is_single && read.asymmetry < 1e-7);
    let (x, _) = read.enclosure.factors.get(0, 1);
    assert!((x - 0.3).abs() < 1e-7 && x != 0.3, "{x}");
    let stored = read.enclosure.factors.exchange.get(0, 1).error;
    assert!((error..1.01 * error).contains(&stored), "{stored} {error}");
}

#[test]
fn arrays_are_those_of_the_page() {
    let bytes = bytes(&lit(), ArchivePrecision::Auto);
    let mut npz = NpzReader::new(Cursor::new(&bytes), BUDGET).unwrap();
    let mut numbers = |name: &str| npz.array(name).unwrap().unwrap().numbers().unwrap();
    assert_eq!(numbers("data"), [0.25, 0.5]);
    assert_eq!(numbers("indices"), [1.0, 0.0]);
    assert_eq!(numbers("indptr"), [0.0, 1.0, 2.0]);
    assert_eq!(numbers("direct"), [0.125, 0.25]);
    assert_eq!(numbers("one_mirror"), [0.125, 0.25]);
    assert_eq!(numbers("more_mirrors"), [0.0, 0.0]);
    assert_eq!(numbers("sky"), [0.75, 0.5]);
    assert_eq!(numbers("rho_s"), [0.0, 0.25]);
    assert_eq!(numbers("patch_face"), [0.0, 3.0, 1.0, 0.0]);
    assert_eq!(numbers("cell_starts"), [0.0, 4.0, 7.0]);
    assert_eq!(numbers("normals"), [0.0, 0.0, 1.0, 0.0, 0.0, -1.0]);
    let documented = include_str!("mod.rs");
    for name in npz.names() {
        let is_error = name.ends_with("_error") && documented.contains("`…_error`");
        assert!(
            documented.contains(&format!("`{name}`")) || is_error,
            "{name}"
        );
    }
}

#[test]
fn no_prefix_and_no_damage_panics() {
    let whole = bytes(&lit(), ArchivePrecision::Auto);
    for length in (0..whole.len()).step_by(11) {
        assert!(read(Cursor::new(&whole[..length]), BUDGET).is_err());
    }
    for i in (0..whole.len()).step_by(5) {
        let mut damaged = whole.clone();
        damaged[i] ^= 0x55;
        let _ = read(Cursor::new(&damaged), BUDGET);
    }
}

/// An archive of a 2 × 2 matrix with one array replaced, or without it.
fn with(name: &str, shape: &[usize], values: Option<&[f64]>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut npz = NpzWriter::new(&mut bytes);
    npz.add("format", |w| npy::write_bytes(b"csr", w)).unwrap();
    let arrays: [(&str, &[usize], &[f64]); 5] = [
        ("shape", &[2], &[2.0, 2.0]),
        ("indptr", &[3], &[0.0, 1.0, 2.0]),
        ("indices", &[2], &[1.0, 0.0]),
        ("data", &[2], &[0.25, 0.5]),
        ("areas", &[2], &[2.0, 1.0]),
    ];
    for (known, usual, numbers) in arrays {
        let is_index = ["shape", "indptr", "indices"].contains(&known);
        let (shape, numbers) = match values {
            _ if known != name => (usual, numbers),
            Some(values) => (shape, values),
            None => continue,
        };
        let integers: Vec<i64> = numbers.iter().map(|&x| x as i64).collect();
        let write = |w: &mut dyn std::io::Write| {
            if is_index {
                npy::write(shape, &integers, w)
            } else {
                npy::write(shape, numbers, w)
            }
        };
        npz.add(known, write).unwrap();
    }
    npz.finish().unwrap();
    bytes
}

#[test]
fn a_matrix_of_others_is_made_reciprocal() {
    let read = back(&with("", &[], None));
    assert_eq!(
        (read.asymmetry, read.enclosure.factors.get(0, 1).0),
        (0.0, 0.25)
    );
    assert_eq!(read.enclosure.rows.names, ["0", "1"]);
    assert!(read.enclosure.rows.cells.is_empty());
    let read = back(&with("data", &[2], Some(&[0.3, 0.5])));
    assert!((read.asymmetry - 0.1).abs() < 1e-12, "{}", read.asymmetry);
    assert!((read.enclosure.factors.get(1, 0).0 - 0.55).abs() < 1e-12);
}

#[test]
fn bad_arrays_are_named() {
    let refuse = |bytes: Vec<u8>, expected: &str| {
        let message = read(Cursor::new(bytes), BUDGET).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    };
    refuse(with("areas", &[], None), "no array \"areas\"");
    refuse(with("data", &[], None), "no array \"data\"");
    refuse(with("data", &[2], Some(&[f64::NAN, 0.5])), "data[0] is NaN");
    refuse(
        with("data", &[1], Some(&[0.5])),
        "data, std_error: not one number",
    );
    refuse(with("areas", &[2], Some(&[-1.0, 1.0])), "areas: -1");
    refuse(
        with("areas", &[3], Some(&[1.0; 3])),
        "areas: its shape is [3]",
    );
    refuse(with("shape", &[2], Some(&[2.0, 3.0])), "2 × 3");
    refuse(with("indptr", &[3], Some(&[0.0, 2.0, 1.0])), "indptr");
    refuse(with("indices", &[2], Some(&[1.0, 2.0])), "indices");
    refuse(vec![0; 40], "archive");
}

/// Reads with SciPy, where Python has it.
#[test]
fn scipy_reads_the_archive() {
    let Some(python) = azulejo_testing::python() else {
        return;
    };
    let path = std::env::temp_dir().join(format!("azulejo-{}.npz", std::process::id()));
    let mut file = std::fs::File::create(&path).unwrap();
    let mut enclosure = two_squares();
    enclosure.rows.names = vec!["floor".to_owned(), "wänd".to_owned()];
    write(&enclosure, ArchivePrecision::Auto, &mut file).unwrap();
    let script = "import sys, numpy, scipy.sparse as s\n\
        f = s.load_npz(sys.argv[1]); assert f.format == 'csr'\n\
        assert (f.toarray() == [[0, 0.25], [0.5, 0]]).all()\n\
        z = numpy.load(sys.argv[1])\n\
        assert z['names'].tolist() == ['floor', 'wänd']\n\
        d = s.csr_matrix((z['direct'], z['indices'], z['indptr']), z['shape'])\n\
        assert (d.toarray() == [[0, 0.125], [0.25, 0]]).all()\n\
        assert z['areas'].tolist() == [2, 1] and z['std_error'].tolist() == [0.125, 0.25]\n";
    let status = std::process::Command::new(python)
        .args(["-c", script])
        .arg(&path)
        .status();
    std::fs::remove_file(&path).unwrap();
    assert!(status.unwrap().success());
}

#[test]
fn faces_of_groups_come_back() {
    let groups = crate::Groups {
        of_rows: vec![Some(0); 2],
        names: vec!["all".into()],
    };
    let mut grouped = lit().grouped(&groups);
    assert_eq!(grouped.rows.grouped_faces.len(), 2);
    let read = back(&bytes(&grouped, ArchivePrecision::Auto));
    assert_eq!(read.enclosure.rows, grouped.rows);
    grouped.rows.grouped_faces[1].1 = 1;
    let bad = bytes(&grouped, ArchivePrecision::Auto);
    let error = super::read(Cursor::new(bad), BUDGET).unwrap_err();
    assert!(
        error.to_string().starts_with("group_faces: expected"),
        "{error}"
    );
    // An object without a name.
    grouped.rows.grouped_faces[1] = (azulejo_factors::FaceId { object: 7, face: 0 }, 0);
    let bad = bytes(&grouped, ArchivePrecision::Auto);
    let error = super::read(Cursor::new(bad), BUDGET).unwrap_err();
    assert!(
        error.to_string().contains("a row is of object 7"),
        "{error}"
    );
}

/// A room in blocks, by rays.
fn room_in_blocks() -> BlockArchive {
    let scene = azulejo_scene::synthetic::cube_room();
    let tracer = azulejo_trace::Tracer::new(&scene);
    let options = FormFactorOptions {
        engine: Engine::Rays,
        size: PatchSize::Count(600),
        rays: 256,
        ..FormFactorOptions::default()
    };
    let plan = Plan::new(&scene, &tracer, &options).unwrap();
    let prepared = plan.prepare();
    let compression = CompressionOptions::default();
    let stated = StatedFactors::of(&prepared, &compression, &Progress::new()).unwrap();
    let mut archive = BlockArchive::of(&prepared, &scene, stated, compression.tolerance);
    let light = OutsideLight {
        irradiance: Rgb::new(3.0, 2.0, 1.0),
        ..OutsideLight::default()
    };
    archive.enclosure.outside = Some(vec![light; archive.enclosure.len()]);
    archive
}

fn block_bytes(archive: &BlockArchive) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_blocks(archive, &mut bytes).unwrap();
    bytes
}

#[test]
fn blocks_come_back() {
    let room = room_in_blocks();
    let bytes = block_bytes(&room);
    let StoredFactors::Blocks(read) = open(Cursor::new(&bytes), BUDGET).unwrap() else {
        panic!("blocks");
    };
    assert!(read.factors.bound.is_nan());
    let known = |factors: &CompressedFactors| CompressedFactors {
        bound: 0.0,
        ..factors.clone()
    };
    assert_eq!(known(&read.factors), known(&room.factors));
    assert_eq!(read.enclosure.rows, room.enclosure.rows);
    assert_eq!(read.enclosure.outside, room.enclosure.outside);
    let (stated, bytes_of) = (read.stated, read.whole_bytes);
    assert_eq!((stated, bytes_of), (room.stated, room.whole_bytes));
    assert_eq!(read.tolerance, 1e-3);
    let x: Vec<f64> = (0..read.enclosure.len()).map(|i| i as f64).collect();
    assert_eq!(
        read.enclosure.operator().apply(&x),
        room.enclosure.operator().apply(&x)
    );
    assert_eq!(
        read.enclosure.factors.is_closed,
        room.enclosure.factors.is_closed
    );
    assert!(block_bytes(&read) == bytes);
    let documented = include_str!("mod.rs");
    for name in read.arrays {
        let is_documented = documented.contains(&format!("`{name}`"));
        assert!(is_documented, "{name}");
    }
    // Who wants single entries is told.
    let refused = super::read(Cursor::new(&bytes), BUDGET)
        .unwrap_err()
        .to_string();
    assert!(refused.contains("no single entries"), "{refused}");
    let options = FileOptions::default();
    let files = FactorFormat::Csv.prepare(&read.enclosure, &options);
    assert!(matches!(files, Err(FactorFileError::Elsewhere)));
}

#[test]
fn damaged_blocks_are_named() {
    let whole = block_bytes(&room_in_blocks());
    let changed = |name: &str, change: &dyn Fn(&mut Vec<f64>)| {
        let mut npz = NpzReader::new(Cursor::new(&whole), BUDGET).unwrap();
        let mut bytes = Vec::new();
        let mut out = NpzWriter::new(&mut bytes);
        for known in npz.names() {
            let array = npz.array(&known).unwrap().unwrap();
            if let Some(texts) = array.texts() {
                let scalar = array.shape().is_empty();
                let write = |w: &mut dyn std::io::Write| {
                    if scalar {
                        npy::write_bytes(texts[0].as_bytes(), w)
                    } else {
                        npy::write_texts(&texts, w)
                    }
                };
                out.add(&known, write).unwrap();
                continue;
            }
            let mut numbers = array.numbers().unwrap();
            let before = numbers.len();
            if known == name {
                change(&mut numbers);
            }
            let mut shape = array.shape().to_vec();
            if numbers.len() != before {
                shape = vec![numbers.len()];
            }
            let integers: Vec<i64> = numbers.iter().map(|&x| x as i64).collect();
            let write = |w: &mut dyn std::io::Write| match array.integers() {
                Some(_) => npy::write(&shape, &integers, w),
                None => npy::write(&shape, &numbers, w),
            };
            out.add(&known, write).unwrap();
        }
        out.finish().unwrap();
        open(Cursor::new(bytes), BUDGET).map(|_| ())
    };
    assert!(changed("", &|_| ()).is_ok());
    let refuse = |name: &str, expected: &str, change: &dyn Fn(&mut Vec<f64>)| {
        let message = changed(name, change).unwrap_err().to_string();
        assert!(message.contains(expected), "{name}: {message}");
    };
    refuse("order", "each of the", &|x| x[1] = x[0]);
    refuse("order", "each of the", &|x| x[0] = 1e9);
    refuse("order", "0 or more", &|x| x[0] = -1.0);
    refuse("block_rows", "within", &|x| x[1] = 1e9);
    refuse("block_rows", "within", &|x| x.swap(0, 1));
    refuse("block_columns", "block 0", &|x| x[0] += 1.0);
    refuse("block_kind", "expected 0 (sparse)", &|x| x[0] = 7.0);
    refuse("block_kind", "block_rank: expected", &|x| {
        x.pop();
    });
    refuse("block_rank", "numbers and", &|x| {
        let link = x.iter().position(|&rank| rank == 1.0).unwrap();
        x[link] = 2.0;
    });
    refuse("block_values", "ascending from 0", &|x| x[1] = 1e9);
    refuse("block_layout", "ascending from 0", &|x| x[0] = 1.0);
    refuse("layout", "beyond the block", &|x| x[0] = 60_000.0);
    refuse("layout", "its indices", &|x| x[1] += 1.0);
    refuse("values", "values[3] is NaN", &|x| x[3] = f64::NAN);
    refuse("part_blocks", "ascending from 0", &|x| x[0] = 1.0);
    refuse("areas", "areas: -1", &|x| x[0] = -1.0);
    refuse("shape", "square", &|x| x[0] = 7.0);
    refuse("sum_error", "sum_error: its shape", &|x| {
        x.pop();
    });
    for length in (0..whole.len()).step_by(997) {
        assert!(open(Cursor::new(&whole[..length]), BUDGET).is_err());
    }
}

/// Multiplies by blocks in NumPy alone, as the page shows.
#[test]
fn numpy_multiplies_by_blocks() {
    let Some(python) = azulejo_testing::python() else {
        return;
    };
    let path = std::env::temp_dir().join(format!("azulejo-blocks-{}.npz", std::process::id()));
    let room = room_in_blocks();
    std::fs::write(&path, block_bytes(&room)).unwrap();
    let page = include_str!("../../../../docs/form-factors.md");
    let (_, rest) = page
        .split_once("```python\nimport numpy as np\n\n\ndef dense")
        .unwrap();
    let (code, _) = rest.split_once("```").unwrap();
    let code = code.replace("\"f.npz\"", "sys.argv[1]");
    let script = format!("import sys\nimport numpy as np\n\n\ndef dense{code}");
    let script = script + "print(X.sum(axis=1).min(), X[3, 77], X[77, 3])\n";
    let run = std::process::Command::new(python)
        .args(["-c", &script])
        .arg(&path)
        .output()
        .unwrap();
    std::fs::remove_file(&path).unwrap();
    assert!(
        run.status.success(),
        "{}",
        String::from_utf8_lossy(&run.stderr)
    );
    let output = String::from_utf8_lossy(&run.stdout);
    let last = output.lines().last().unwrap();
    let numbers: Vec<f64> = last.split(' ').map(|x| x.parse().unwrap()).collect();
    let least = room
        .factors
        .sums()
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    let entry = |i: usize, j: usize| room.factors.exchange_area(i, j) / room.factors.areas[i];
    for (value, known) in numbers.iter().zip([least, entry(3, 77), entry(77, 3)]) {
        assert!((value - known).abs() < 1e-9, "{output} {known}");
    }
}
