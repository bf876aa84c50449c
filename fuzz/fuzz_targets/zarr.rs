//! Any bytes as an array of a Zarr store: its metadata, and behind a zero its chunks. What is read has as many
//! elements as its shape says, and takes no more than its budget.
#![no_main]

use azulejo_formats::zarr::ZarrGroup;
use libfuzzer_sys::fuzz_target;
use std::collections::BTreeMap;

/// Bytes that an array may take.
const BUDGET: u64 = 1 << 20;

fuzz_target!(|bytes: &[u8]| {
    let mut parts = bytes.splitn(2, |byte| *byte == 0);
    let metadata = parts.next().unwrap_or_default();
    let chunks = parts.next().unwrap_or_default();
    let (first, second) = chunks.split_at(chunks.len() / 2);
    let group = br#"{"zarr_format": 3, "node_type": "group"}"#;
    let store = [
        ("zarr.json", &group[..]),
        ("a/zarr.json", metadata),
        ("a/c", chunks),
        ("a/c/0", first),
        ("a/c/1", second),
        ("a/c/0/0", first),
        ("a/c/1/0", second),
    ];
    let store: BTreeMap<String, Vec<u8>> = store
        .into_iter()
        .map(|(key, content)| (key.to_owned(), content.to_owned()))
        .collect();
    let group = ZarrGroup::open(store).expect("the group is valid");
    let mut budget = BUDGET;
    if let Ok(Some(array)) = group.whole("a", &mut budget) {
        assert_eq!(array.len(), array.shape().iter().product::<usize>());
        assert!(array.data().len() as u64 <= BUDGET);
    }
});
