//! Stores come back, agree with archives, and are refused by the key that is wrong.

use super::*;
use crate::archive::ArchivePrecision;
use crate::enclosure::tests::two_squares;
use crate::network::tests;
use azulejo_formats::numpy::ArrayCompression;
use azulejo_formats::numpy::ArraySink;
use azulejo_formats::numpy::npy;
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::io::Cursor;

type StoreFiles = BTreeMap<String, Vec<u8>>;

const BUDGET: u64 = 1 << 26;

fn options(precision: ArchivePrecision) -> ArchiveOptions {
    ArchiveOptions::from(precision)
}

/// A store of an enclosure with chunks of so many entries.
fn stored(enclosure: &Enclosure, precision: ArchivePrecision, chunk: usize) -> StoreFiles {
    let mut memory = StoreFiles::new();
    write_chunks(enclosure, options(precision), chunk, &mut memory).unwrap();
    memory
}

fn read(memory: &StoreFiles, budget: u64) -> Result<ReadEnclosure, StoreError> {
    MatrixStore::open(memory.clone(), budget)?.read(&Progress::new())
}

/// A matrix of random numbers with all that is known of rows.
fn random_enclosure(n: usize, seed: u32) -> Enclosure {
    let mut enclosure = tests::random_enclosure(n, seed);
    let face = azulejo_factors::FaceId { object: 0, face: 0 };
    enclosure.factors.faces = vec![face; n];
    enclosure.factors.materials = vec![0; n];
    enclosure.factors.is_back = vec![false; n];
    enclosure.factors.row_errors = vec![0.0; n];
    enclosure.rows.objects = vec!["all".to_owned()];
    enclosure.rows.materials = vec!["grey".to_owned()];
    enclosure.rows.diffuse = vec![azulejo_scene::Rgb::BLACK; n];
    enclosure
}

/// Two squares with orders of reflection and all arrays.
fn lit() -> Enclosure {
    let mut enclosure = two_squares();
    enclosure.factors.exchange = ExchangeAreas::sum_of(&enclosure.factors.orders);
    let light = crate::enclosure::OutsideLight {
        irradiance: azulejo_scene::Rgb::new(3.0, 2.0, 1.0),
        error: azulejo_scene::Rgb::new(0.3, 0.2, 0.1),
    };
    enclosure.outside = Some(vec![light, Default::default()]);
    enclosure.factors.unseen = vec![0.125, 0.0];
    enclosure.factors.rays = 8192;
    enclosure.factors.engine_used.name = "rays".to_owned();
    enclosure.factors.ends[1] = 0.75;
    enclosure
}

#[test]
fn everything_comes_back() {
    let enclosure = lit();
    for chunk in [1, 2, 1000] {
        let memory = stored(&enclosure, ArchivePrecision::Auto, chunk);
        let found = read(&memory, BUDGET).unwrap();
        assert_eq!(found.enclosure.factors, enclosure.factors);
        assert_eq!(found.enclosure.rows, enclosure.rows);
        assert_eq!(found.enclosure.outside, enclosure.outside);
        assert_eq!((found.is_single, found.asymmetry), (false, 0.0));
        assert_eq!(
            stored(&found.enclosure, ArchivePrecision::Auto, chunk),
            memory
        );
    }
}

/// The arrays are those of the `.npz`, number by number, whatever the chunks.
#[test]
fn arrays_are_those_of_the_archive() {
    let enclosure = lit();
    let mut bytes = Vec::new();
    archive::write(&enclosure, ArchivePrecision::Auto, &mut bytes).unwrap();
    let bytes = Cursor::new(bytes);
    let mut npz = azulejo_formats::numpy::npz::NpzReader::new(bytes, BUDGET).unwrap();
    let group = ZarrGroup::open(stored(&enclosure, ArchivePrecision::Auto, 2)).unwrap();
    let mut names = npz.names();
    names.sort();
    assert_eq!(group.names().unwrap(), names);
    for name in names {
        let expected = npz.array(&name).unwrap().unwrap();
        let found = group.whole(&name, &mut BUDGET.clone()).unwrap().unwrap();
        assert_eq!(found.shape(), expected.shape(), "{name}");
        assert_eq!(found.numbers(), expected.numbers(), "{name}");
        assert_eq!(found.texts(), expected.texts(), "{name}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// From a store to an `.npz` and back nothing changes but the last places of factors, because both directions
    /// of a pair are rounded, and one number stands for them in memory.
    #[test]
    fn stores_and_archives_convert(n in 1usize..40, seed in 0u32..1000, chunk in 1usize..300, is_single: bool) {
        let precision = if is_single { ArchivePrecision::Single } else { ArchivePrecision::Double };
        let enclosure = random_enclosure(n, seed);
        let memory = stored(&enclosure, precision, chunk);
        let found = read(&memory, BUDGET).unwrap();
        prop_assert_eq!(found.is_single, is_single && found.enclosure.factors.exchange.entries() > 0);
        let mut bytes = Vec::new();
        archive::write(&found.enclosure, precision, &mut bytes).unwrap();
        let archived = archive::read(Cursor::new(bytes), BUDGET).unwrap().enclosure;
        prop_assert_eq!(&archived.rows, &found.enclosure.rows);
        prop_assert_eq!(&archived.factors.rest, &found.enclosure.factors.rest);
        let again = stored(&archived, precision, chunk);
        let place = if is_single { f64::from(f32::EPSILON) } else { f64::EPSILON };
        let again = read(&again, BUDGET).unwrap().enclosure.factors.exchange;
        let exchange = &found.enclosure.factors.exchange;
        for i in 0..n {
            prop_assert_eq!(again.upper(i).len(), exchange.upper(i).len());
            for (a, b) in again.upper(i).iter().zip(exchange.upper(i)) {
                prop_assert_eq!(a.column, b.column);
                prop_assert!((a.value - b.value).abs() <= 2.0 * place * b.value.abs());
            }
        }
    }
}

/// A store with one array replaced.
fn with(name: &str, write: &dyn Fn(&mut dyn io::Write) -> io::Result<()>) -> StoreFiles {
    let mut memory = stored(&two_squares_alone(), ArchivePrecision::Auto, 1);
    memory.retain(|key, _| !key.starts_with(&format!("{name}/")));
    let mut writer = ZarrWriter::new(ArrayCompression::Fast, &mut memory).with_chunks(1);
    writer.add_array(name, &mut |out| write(out)).unwrap();
    memory
}

fn two_squares_alone() -> Enclosure {
    let mut enclosure = two_squares();
    enclosure.factors.orders.clear();
    enclosure
}

#[test]
fn the_mean_is_taken_of_what_is_not_reciprocal() {
    let memory = with("data", &|w| npy::write(&[2], &[0.3, 0.5], w));
    let found = read(&memory, BUDGET).unwrap();
    assert!((found.asymmetry - 0.1).abs() < 1e-12, "{}", found.asymmetry);
    assert!((found.enclosure.factors.get(1, 0).0 - 0.55).abs() < 1e-12);
}

#[test]
fn bad_arrays_are_named() {
    let refuse = |memory: StoreFiles, expected: &str| {
        let said = read(&memory, BUDGET).unwrap_err().to_string();
        assert!(said.contains(expected), "{said}");
    };
    let numbers = |name: &str, values: &[f64], expected: &str| {
        refuse(
            with(name, &|w| npy::write(&[values.len()], values, w)),
            expected,
        );
    };
    numbers("data", &[f64::NAN, 0.5], "row 0 has a factor of NaN");
    numbers(
        "data",
        &[0.5],
        "data/zarr.json: its shape is [1], expected [2]",
    );
    numbers("indices", &[1.5, 0.0, 2.0], "indices/zarr.json");
    numbers("areas", &[-1.0, 1.0], "areas: -1");
    numbers("areas", &[1.0; 3], "areas: its shape is [3]");
    let integers = |name: &str, values: &[i64], expected: &str| {
        refuse(
            with(name, &|w| npy::write(&[values.len()], values, w)),
            expected,
        );
    };
    integers("indices", &[1, 2], "row 1 do not ascend below 2");
    integers("indices", &[1, -1], "expected whole numbers from 0 on");
    integers("indptr", &[0, 2, 1], "indptr");
    integers("indptr", &[0, 1, 9], "its shape is [2], expected [9]");
    integers("shape", &[2, 3], "2 × 3");
    integers("shape", &[1 << 40, 1 << 40], "expected a square matrix");
    integers("version", &[9], "newer azulejo");
    let mut memory = stored(&two_squares_alone(), ArchivePrecision::Auto, 1);
    memory.retain(|key, _| !key.starts_with("data/"));
    refuse(memory, "no array \"data\"");
    refuse(StoreFiles::new(), "zarr.json: there is no such file");
}

/// Each file of a store that is missing or cut off is an error that names it, and damage never a panic.
#[test]
fn damaged_stores_are_refused() {
    let whole = stored(&lit(), ArchivePrecision::Auto, 1);
    let mut named = 0;
    for (key, content) in &whole {
        let mut memory = whole.clone();
        memory.insert(key.clone(), content[..content.len() / 2].to_vec());
        let said = read(&memory, BUDGET).map(|_| ());
        // Arrays that are written for others are not read.
        if let Err(said) = said {
            assert!(said.to_string().starts_with(&format!("{key}: ")), "{said}");
            named += 1;
        } else {
            let name = key.split('/').next().unwrap_or_default();
            let unread = ["data", "std_error", "escaped", "centroids", "normals"];
            assert!(unread.contains(&name), "{key}");
        }
        for place in (0..content.len()).step_by(7) {
            let mut damaged = content.clone();
            damaged[place] ^= 0x55;
            memory.insert(key.clone(), damaged);
            let _ = read(&memory, BUDGET);
        }
    }
    assert!(named > whole.len() / 2, "{named} of {}", whole.len());
}

#[test]
fn budgets_hold() {
    let memory = stored(&random_enclosure(30, 7), ArchivePrecision::Auto, 100);
    let entries = MatrixStore::open(memory.clone(), BUDGET).unwrap().entries() as u64;
    for budget in [0, 100, 1000, 16 * entries] {
        let said = read(&memory, budget).unwrap_err().to_string();
        assert!(said.contains("memory"), "{said}");
    }
    let progress = Progress::new();
    progress.cancel();
    let store = MatrixStore::open(memory, BUDGET).unwrap();
    assert_eq!(store.read(&progress).err(), Some(StoreError::Cancelled));
}

#[test]
fn folders_hold_stores() {
    let folder = std::env::temp_dir().join(format!("azulejo-store-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let enclosure = lit();
    let mut sink = StoreFolderSink(folder.clone());
    write(&enclosure, ArchiveOptions::default(), &mut sink).unwrap();
    let store = MatrixStore::open(StoreFolder(folder.clone()), BUDGET).unwrap();
    let found = store.read(&Progress::new()).unwrap();
    assert_eq!(found.enclosure.factors, enclosure.factors);
    // A file that is larger than its array.
    std::fs::write(folder.join("areas/c/0"), vec![0; 10_000]).unwrap();
    let said = MatrixStore::open(StoreFolder(folder.clone()), BUDGET);
    let said = said.unwrap_err().to_string();
    assert!(
        said.starts_with("areas/c/0: the file has more than"),
        "{said}"
    );
    std::fs::remove_dir_all(folder).unwrap();
}

/// The same store in memory and out of core.
fn both(memory: &StoreFiles) -> [Enclosure; 2] {
    let store = MatrixStore::open(memory.clone(), BUDGET).unwrap();
    let outside = store.out_of_core(&Progress::new()).unwrap();
    [read(memory, BUDGET).unwrap().enclosure, outside]
}

/// A matrix with errors and a row that sees itself.
fn noisy(n: usize, seed: u32) -> Enclosure {
    let mut enclosure = random_enclosure(n, seed);
    let exchange = &enclosure.factors.exchange;
    let with_error = |e: &Exchange| Exchange {
        error: 0.01 * e.value as f32,
        ..*e
    };
    let row = |i: usize| exchange.upper(i).iter().map(with_error).collect::<Vec<_>>();
    enclosure.factors.exchange = (0..n).map(row).collect();
    enclosure
}

#[test]
fn products_out_of_core_have_the_bits_of_those_in_memory() {
    for (enclosure, chunk) in [
        (noisy(70, 3), 7),
        (noisy(70, 4), 100_000),
        (lit(), 1),
        (noisy(1, 5), 1),
    ] {
        let memory = stored(&enclosure, ArchivePrecision::Auto, chunk);
        let [inside, outside] = both(&memory);
        let [a, b] = [inside.operator(), outside.operator()];
        let n = inside.len();
        assert_eq!(a.row_areas(), b.row_areas());
        assert_eq!(a.numbers(), b.numbers());
        assert_eq!((a.own(), a.connected()), (b.own(), b.connected()));
        for lanes in [1, 2, 3, 4, 8] {
            let x: Vec<f64> = (0..n * lanes).map(|k| 0.1 + (k % 13) as f64).collect();
            assert_eq!(a.exchanged_lanes(&x, lanes), b.exchanged_lanes(&x, lanes));
            assert_eq!(a.variance_lanes(&x, lanes), b.variance_lanes(&x, lanes));
        }
        let x: Vec<f64> = (0..n).map(|k| (k % 5) as f64).collect();
        let vectors = [(&x[..], a.row_areas()), (a.row_areas(), a.row_areas())];
        assert_eq!(a.variances_between(&vectors), b.variances_between(&vectors));
        assert_eq!(b.failure(), None);
    }
}

#[test]
fn networks_and_temperatures_do_not_depend_on_where_the_matrix_is() {
    use crate::network::tests::each_row;
    use crate::{HeatProblem, RowCondition, SpectralRange, SurfaceBand};
    let n = 40;
    let memory = stored(&noisy(n, 11), ArchivePrecision::Single, 50);
    let solved = both(&memory).map(|enclosure| {
        let band = |range, share: f64| SurfaceBand {
            emissivity: enclosure.factors.ends.iter().map(|e| share * e).collect(),
            enclosure: &enclosure,
            range,
        };
        let nodes = each_row(n);
        let progress = Progress::new();
        let grey = [band(SpectralRange::Thermal, 0.5)];
        let two = [
            band(SpectralRange::Between(0.0, 5.0), 0.3),
            band(SpectralRange::Between(5.0, f64::INFINITY), 0.8),
        ];
        let conditions: Vec<RowCondition> = (0..n)
            .map(|i| match i % 2 {
                0 => RowCondition::Temperature(300.0 + i as f64),
                _ => RowCondition::Flux(0.0),
            })
            .collect();
        let heat = |bands: &[SurfaceBand]| {
            let problem = HeatProblem {
                bands,
                conditions: &conditions,
                surroundings: [3.0; 2],
                solar: &[],
            };
            crate::heat_balance(&problem, &nodes, &progress).unwrap()
        };
        let factors = crate::exchange_factors(&grey[0], &nodes, &progress).unwrap();
        (factors, heat(&grey), heat(&two))
    });
    assert!(solved[0] == solved[1]);
    assert!(solved[0].1.node_heat_errors.iter().any(|e| *e > 0.0));
}

#[test]
fn one_direction_is_not_enough_where_both_differ() {
    let memory = with("data", &|w| npy::write(&[2], &[0.3, 0.5], w));
    let store = MatrixStore::open(memory, BUDGET).unwrap();
    let said = store.out_of_core(&Progress::new()).unwrap_err();
    assert!(
        said.to_string().contains("differ by more than rounding"),
        "{said}"
    );
}

/// A store from which chunks vanish while it is in use.
#[derive(Clone)]
struct SharedMemory(std::sync::Arc<std::sync::Mutex<StoreFiles>>);

impl ZarrStore for SharedMemory {
    fn names(&self) -> io::Result<Vec<String>> {
        self.0.lock().unwrap().names()
    }

    fn get(&self, key: &str, most: u64) -> io::Result<Option<Vec<u8>>> {
        ZarrStore::get(&*self.0.lock().unwrap(), key, most)
    }
}

#[test]
fn what_vanishes_while_a_store_is_in_use_is_an_error() {
    use crate::network::tests::each_row;
    use crate::{ExchangeError, SpectralRange, SurfaceBand};
    let memory = stored(&noisy(30, 2), ArchivePrecision::Auto, 50);
    let shared = SharedMemory(std::sync::Arc::new(std::sync::Mutex::new(memory)));
    let store = MatrixStore::open(shared.clone(), BUDGET).unwrap();
    let enclosure = store.out_of_core(&Progress::new()).unwrap();
    shared.0.lock().unwrap().remove("data/c/1");
    let band = SurfaceBand {
        emissivity: enclosure.factors.ends.iter().map(|e| 0.5 * e).collect(),
        enclosure: &enclosure,
        range: SpectralRange::Thermal,
    };
    let solved = crate::exchange_factors(&band, &each_row(30), &Progress::new());
    let Err(ExchangeError::Unreadable { message }) = solved else {
        panic!("{solved:?}");
    };
    assert!(
        message.starts_with("data/c/1: this chunk is missing"),
        "{message}"
    );
    assert!(enclosure.operator().exchanged(&[1.0; 30])[0].is_nan());
}

/// Runs a script in a folder, and says what it says if it fails.
fn runs(python: &std::ffi::OsStr, script: &str, folder: &std::path::Path) -> Result<(), String> {
    let run = std::process::Command::new(python)
        .args(["-c", script])
        .current_dir(folder)
        .output()
        .unwrap();
    if run.status.success() {
        return Ok(());
    }
    Err(String::from_utf8_lossy(&run.stderr).into_owned())
}

/// The lines of docs/form-factors.md, and all arrays against those of the `.npz`; then a store that
/// zarr-python wrote, which leaves out chunks of zeros if nobody asks for them. Where Python has zarr.
#[test]
fn zarr_python_reads_and_writes_stores() {
    let Some(python) = azulejo_testing::python() else {
        return;
    };
    let folder = std::env::temp_dir().join(format!("azulejo-zarr-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(folder.join("f.zarr")).unwrap();
    if runs(
        &python,
        "import zarr; assert zarr.__version__ >= '3'",
        &folder,
    )
    .is_err()
    {
        std::fs::remove_dir_all(folder).unwrap();
        return;
    }
    let mut enclosure = lit();
    enclosure.rows.names[1] = "wänd".to_owned();
    let mut sink = StoreFolderSink(folder.join("f.zarr"));
    write_chunks(&enclosure, ArchiveOptions::default(), 1, &mut sink).unwrap();
    let mut npz = std::fs::File::create(folder.join("f.npz")).unwrap();
    archive::write(&enclosure, ArchivePrecision::Auto, &mut npz).unwrap();
    let script = "import warnings, numpy, scipy.sparse as sp, zarr\n\
        warnings.simplefilter('error')\n\
        z = zarr.open_group('f.zarr', mode='r')\n\
        X = sp.csr_array((z['data'][:], z['indices'][:], z['indptr'][:]), z['shape'][:])\n\
        n = numpy.load('f.npz')\n\
        assert set(z.array_keys()) == set(n.files), set(z.array_keys()) ^ set(n.files)\n\
        assert (X.toarray() == sp.load_npz('f.npz').toarray()).all()\n\
        assert z.attrs['azulejo_form_factors'] == 1\n\
        for name in n.files:\n\
        \x20   a, b = numpy.asarray(z[name][...]), n[name]\n\
        \x20   assert a.shape == b.shape, name\n\
        \x20   if b.dtype.kind in 'US':\n\
        \x20       assert [str(t) for t in numpy.ravel(a)] == numpy.ravel(b).astype(str).tolist(), name\n\
        \x20   else:\n\
        \x20       assert a.dtype == b.dtype and (a == b).all(), name\n";
    runs(&python, script, &folder).unwrap();
    for (is_whole, expected) in [
        ("True", None),
        ("False", Some("indices/c/1: this chunk is missing")),
    ] {
        let script = format!(
            "import numpy as np, zarr\n\
            zarr.config.set({{'array.write_empty_chunks': {is_whole}}})\n\
            z = zarr.open_group('own.zarr', mode='w', zarr_format=3)\n\
            def put(name, a, **more):\n\
            \x20   a = np.asarray(a)\n\
            \x20   z.create_array(name, shape=a.shape, dtype=a.dtype, **more)[...] = a\n\
            z.create_array('format', shape=(), dtype=str)[...] = 'csr'\n\
            put('shape', np.array([2, 2])); put('indptr', np.array([0, 1, 2]))\n\
            put('indices', np.array([1, 0], 'i4'), chunks=(1,))\n\
            put('data', np.array([0.25, 0.5]), chunks=(1,))\n\
            put('areas', np.array([2.0, 1.0]))\n"
        );
        runs(&python, &script, &folder).unwrap();
        let store = MatrixStore::open(StoreFolder(folder.join("own.zarr")), BUDGET).unwrap();
        let found = store.read(&Progress::new());
        match expected {
            None => assert_eq!(found.unwrap().enclosure.factors.get(0, 1).0, 0.25),
            Some(expected) => {
                let said = found.unwrap_err().to_string();
                assert!(said.starts_with(expected), "{said}");
            }
        }
    }
    std::fs::remove_dir_all(folder).unwrap();
}
