//! What is written comes back, and what is damaged is refused by its key.

use super::*;
use crate::numpy::{ArrayCompression, ArraySink, npy};
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::{Value, json};
use std::io::Write;

type KeyedFiles = BTreeMap<String, Vec<u8>>;

/// A store with chunks of three rows.
fn store() -> KeyedFiles {
    let mut store = KeyedFiles::new();
    let mut writer = ZarrWriter::new(ArrayCompression::Fast, &mut store).with_chunks(3);
    let mut add = |name: &str, write: &dyn Fn(&mut dyn Write) -> io::Result<()>| {
        writer.add_array(name, &mut |out| write(out)).unwrap();
    };
    add("a", &|w| {
        npy::write(&[7], &[1.5, -2.0, 0.0, 4.0, 5.0, 6.0, 7.0], w)
    });
    add("pairs", &|w| {
        npy::write(&[4, 2], &[0i32, 1, 2, 3, 4, 5, 6, -7], w)
    });
    add("names", &|w| {
        npy::write_texts(&["floor", "wänd", "", "lid"].map(str::to_owned), w)
    });
    add("format", &|w| npy::write_bytes(b"csr", w));
    add("n", &|w| npy::write(&[], &[9i64], w));
    add("none", &|w| npy::write(&[0, 3], &[0f32; 0], w));
    writer.finish(&[("layout", 3)]).unwrap();
    store
}

fn whole(store: &KeyedFiles, name: &str) -> Result<Option<npy::StoredArray>, ZarrError> {
    ZarrGroup::open(store.clone())?.whole(name, &mut (1 << 20))
}

fn numbers(store: &KeyedFiles, name: &str) -> Vec<f64> {
    whole(store, name).unwrap().unwrap().numbers().unwrap()
}

#[test]
fn arrays_come_back() {
    let store = store();
    let group = ZarrGroup::open(store.clone()).unwrap();
    let expected = ["a", "format", "n", "names", "none", "pairs"];
    assert_eq!(group.names().unwrap(), expected);
    assert_eq!(group.attribute("layout"), Some(3));
    assert_eq!(numbers(&store, "a"), [1.5, -2.0, 0.0, 4.0, 5.0, 6.0, 7.0]);
    let pairs = whole(&store, "pairs").unwrap().unwrap();
    assert_eq!(pairs.shape(), [4, 2]);
    let expected = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, -7.0];
    assert_eq!(pairs.numbers().unwrap(), expected);
    let names = whole(&store, "names").unwrap().unwrap();
    assert_eq!(names.texts().unwrap(), ["floor", "wänd", "", "lid"]);
    let format = whole(&store, "format").unwrap().unwrap();
    assert_eq!(format.texts().unwrap(), ["csr"]);
    assert_eq!(numbers(&store, "n"), [9.0]);
    let none = whole(&store, "none").unwrap().unwrap();
    assert_eq!((none.shape(), none.len()), (&[0, 3][..], 0));
    assert!(whole(&store, "b").unwrap().is_none());
    // Three chunks of at most three rows, of which the last has one.
    let a = group.array("a").unwrap().unwrap();
    assert_eq!((a.rows(), a.chunk_rows(), a.chunks()), (7, 3, 3));
    assert_eq!(group.chunk(&a, 2).unwrap().numbers().unwrap(), [7.0]);
    // The same bytes every time.
    assert_eq!(self::store(), store);
}

#[test]
fn chunks_without_compression_have_checksums_too() {
    let mut store = KeyedFiles::new();
    let mut writer = ZarrWriter::new(ArrayCompression::None, &mut store);
    let values = vec![0.25; 1000];
    let written = writer.add_array("a", &mut |out| npy::write(&[1000], &values, out));
    written.unwrap();
    writer.finish(&[]).unwrap();
    assert!(store["a/c/0"].len() > 8000);
    assert_eq!(numbers(&store, "a"), values);
    store.get_mut("a/c/0").unwrap()[4000] ^= 1;
    let said = whole(&store, "a").unwrap_err().to_string();
    assert!(
        said.starts_with("a/c/0: ") && said.contains("damaged"),
        "{said}"
    );
}

#[test]
fn fewer_rows_than_the_header_says_are_an_error() {
    let mut store = KeyedFiles::new();
    let mut writer = ZarrWriter::new(ArrayCompression::Fast, &mut store).with_chunks(2);
    let short = writer.add_array("a", &mut |out| {
        npy::write_header("<f8", &[5], out)?;
        out.write_all(&[0; 16])
    });
    assert!(short.unwrap_err().to_string().contains("fewer rows"));
}

/// A key that is missing, cut off or damaged is named; nothing is taken for zeros.
#[test]
fn what_is_missing_or_damaged_is_named() {
    let whole_store = store();
    let all = ["a", "format", "n", "names", "none", "pairs"];
    let read_all = |store: &KeyedFiles| -> Result<usize, ZarrError> {
        let mut found = 0;
        for name in all {
            found += usize::from(whole(store, name)?.is_some());
        }
        Ok(found)
    };
    assert_eq!(read_all(&whole_store), Ok(all.len()));
    for (key, content) in &whole_store {
        let mut store = whole_store.clone();
        store.remove(key);
        if key.contains("/c") || key == "zarr.json" {
            let said = read_all(&store).unwrap_err().to_string();
            assert!(said.starts_with(&format!("{key}: ")), "{key}: {said}");
        } else {
            // An array without metadata is none.
            assert_eq!(read_all(&store), Ok(all.len() - 1), "{key}");
        }
        for length in 0..content.len() {
            store.insert(key.clone(), content[..length].to_vec());
            let said = read_all(&store).unwrap_err().to_string();
            assert!(said.starts_with(&format!("{key}: ")), "{key}: {said}");
        }
        for place in 0..content.len() {
            let mut damaged = content.clone();
            damaged[place] ^= 0x40;
            store.insert(key.clone(), damaged);
            // Some bytes do not matter; none makes reading panic.
            let _ = read_all(&store);
        }
        if key.contains("/c") {
            // Behind the header of gzip all bits are covered by its checksum.
            for place in 10..content.len() {
                let mut damaged = content.clone();
                damaged[place] ^= 1;
                store.insert(key.clone(), damaged);
                let said = read_all(&store).map(|_| place);
                assert!(said.is_err(), "{key}: byte {place}");
            }
        }
    }
}

/// Metadata of `a` with one value replaced.
fn with(pointer: &str, value: Value) -> KeyedFiles {
    let mut store = store();
    let mut metadata: Value = serde_json::from_slice(&store["a/zarr.json"]).unwrap();
    *metadata.pointer_mut(pointer).unwrap() = value;
    let content = serde_json::to_vec(&metadata).unwrap();
    store.insert("a/zarr.json".to_owned(), content);
    store
}

#[test]
fn bad_metadata_are_explained() {
    let refuse = |pointer: &str, value: Value, expected: &str| {
        let said = whole(&with(pointer, value), "a").unwrap_err().to_string();
        assert!(said.contains(expected), "{pointer}: {said}");
    };
    refuse("/zarr_format", json!(2), "zarr_format: 2, expected 3");
    refuse("/node_type", json!("group"), "expected \"array\"");
    refuse("/shape", json!([-1]), "shape: [-1]");
    refuse(
        "/shape",
        json!([7, 1]),
        "chunks of [3] for an array of [7, 1]",
    );
    refuse("/shape", json!([1u64 << 62]), "more than any memory");
    refuse("/shape", json!([1u64 << 50]), "more than the memory allows");
    refuse("/shape", json!([70]), "a/c/3: this chunk is missing");
    refuse(
        "/data_type",
        json!("float32"),
        "a/c/0: it expands to more than 12 bytes",
    );
    refuse("/data_type", json!("complex128"), "complex128");
    refuse(
        "/codecs",
        json!([{"name": "blosc"}]),
        "codecs: blosc, expected",
    );
    refuse("/codecs", json!(["bytes", "gzip", "zstd"]), "expected");
    refuse("/codecs/0/name", json!("vlen-utf8"), "expected bytes");
    refuse("/chunk_grid/name", json!("rectangular"), "rectangular");
    refuse(
        "/chunk_grid/configuration/chunk_shape",
        json!([0]),
        "chunks of [0]",
    );
    refuse(
        "/chunk_grid/configuration/chunk_shape",
        json!([1u64 << 40]),
        "too large",
    );
    refuse("/chunk_key_encoding/name", json!("other"), "other");
    let mut store = store();
    store.insert("a/zarr.json".to_owned(), vec![b'['; 100_000]);
    assert!(whole(&store, "a").is_err());
    store.insert("a/zarr.json".to_owned(), vec![b' '; 2 << 20]);
    assert!(whole(&store, "a").is_err());
}

/// Few bytes that expand to many, and strings that claim to be long.
#[test]
fn little_content_takes_little_memory() {
    let mut bomb = GzEncoder::new(Vec::new(), Compression::best());
    bomb.write_all(&vec![0; 2 << 20]).unwrap();
    let bomb = bomb.finish().unwrap();
    let mut store = store();
    store.insert("a/c/0".to_owned(), bomb.clone());
    let said = whole(&store, "a").unwrap_err().to_string();
    assert!(
        said.contains("a/c/0: it expands to more than 24 bytes"),
        "{said}"
    );
    store.insert("names/c/0".to_owned(), bomb);
    assert!(whole(&store, "names").is_err());
    let mut long = GzEncoder::new(Vec::new(), Compression::fast());
    let claims = [3u32, u32::MAX, 0, 0].map(u32::to_le_bytes);
    long.write_all(claims.as_flattened()).unwrap();
    store.insert("names/c/0".to_owned(), long.finish().unwrap());
    let said = whole(&store, "names").unwrap_err().to_string();
    assert!(said.contains("names/c/0: expected 3 strings"), "{said}");
    let group = ZarrGroup::open(self::store()).unwrap();
    let said = group.whole("a", &mut 55).unwrap_err().to_string();
    assert!(said.contains("memory"), "{said}");
    let mut budget = 60;
    group.whole("a", &mut budget).unwrap();
    assert_eq!(budget, 4);
}

/// Big-endian numbers, keys of version 2, no compression, and zstd: what other programs write.
#[test]
fn stores_of_others_are_read() {
    let mut store = with(
        "/codecs",
        json!([{"name": "bytes", "configuration": {"endian": "big"}}]),
    );
    let mut metadata: Value = serde_json::from_slice(&store["a/zarr.json"]).unwrap();
    metadata["chunk_key_encoding"] = json!({"name": "v2"});
    metadata["shape"] = json!([2]);
    metadata["chunk_grid"]["configuration"]["chunk_shape"] = json!([1]);
    let content = serde_json::to_vec(&metadata).unwrap();
    store.insert("a/zarr.json".to_owned(), content);
    store.insert("a/0".to_owned(), 2.5f64.to_be_bytes().to_vec());
    store.insert("a/1".to_owned(), 3.5f64.to_be_bytes().to_vec());
    assert_eq!(numbers(&store, "a"), [2.5, 3.5]);

    let mut store = with("/codecs/1", json!({"name": "zstd"}));
    let chunks = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 0.0, 0.0]];
    for (k, chunk) in chunks.iter().enumerate() {
        let bytes: Vec<u8> = chunk.iter().flat_map(|x: &f64| x.to_le_bytes()).collect();
        let level = ruzstd::encoding::CompressionLevel::Fastest;
        let compressed = ruzstd::encoding::compress_to_vec(&bytes[..], level);
        store.insert(format!("a/c/{k}"), compressed);
    }
    assert_eq!(numbers(&store, "a"), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    store.get_mut("a/c/1").unwrap().truncate(8);
    let said = whole(&store, "a").unwrap_err().to_string();
    assert!(said.starts_with("a/c/1: "), "{said}");
}
