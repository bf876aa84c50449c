//! Cryptomatte: which named things cover each pixel, and how much of it.
//!
//! Friedman and Jones, *Cryptomatte Specification*, version 1.2.0 (Psyop, 2018). A layer has channels for the pairs of
//! an id and its coverage, largest first, two pairs to four channels. The id is the hash of a name as a number of 32 bits;
//! attributes of the file say the names, so that compositors show them.

use super::exr::{ChannelValues, NamedChannel};
use std::fmt::Write;

/// Pairs of ids and coverages that a layer stores for each pixel.
pub const RANKS: usize = 6;

/// For a pixel the indices of names with their coverage, 0..=1, the largest first. Where nothing is left, the coverage is
/// 0, and the index has no meaning.
pub type Ranks = [(u32, f32); RANKS];

/// The id of a name: a finite number that is not denormal, whose bits are MurmurHash3 (x86, 32 bits) of it.
pub fn id(name: &str) -> f32 {
    let hash = murmur3(name.as_bytes());
    // Exponents that mean denormal numbers, infinity and NaN.
    let is_special = matches!(hash >> 23 & 0xff, 0 | 0xff);
    f32::from_bits(if is_special { hash ^ 1 << 23 } else { hash })
}

/// The channels of a layer, `CryptoObject00.r` and so on.
pub fn channels(layer: &str, names: &[String], ranks: &[Ranks]) -> Vec<NamedChannel> {
    let ids: Vec<f32> = names.iter().map(|name| id(name)).collect();
    let mut channels = Vec::with_capacity(2 * RANKS);
    for rank in 0..RANKS {
        let group = rank / 2;
        let [of_id, of_coverage] = [["r", "g"], ["b", "a"]][rank % 2];
        let pairs = || ranks.iter().map(|ranks| ranks[rank]);
        let named = |&(name, coverage): &(u32, f32)| {
            if coverage > 0.0 {
                ids[name as usize]
            } else {
                0.0
            }
        };
        let mut push = |letter: &str, values: Vec<f32>| {
            channels.push(NamedChannel {
                name: format!("{layer}{group:02}.{letter}"),
                values: ChannelValues::Float(values),
            });
        };
        push(of_id, pairs().map(|pair| named(&pair)).collect());
        push(of_coverage, pairs().map(|pair| pair.1).collect());
    }
    channels
}

/// The attributes of a layer, by their names: what it is called, how ids are made, and those of all names.
pub fn attributes(layer: &str, names: &[String]) -> Vec<(String, String)> {
    let key = format!("{:08x}", murmur3(layer.as_bytes()));
    let attribute =
        |name: &str, value: String| (format!("cryptomatte/{}/{name}", &key[..7]), value);
    let mut manifest = String::from("{");
    for (k, name) in names.iter().enumerate() {
        let comma = if k > 0 { "," } else { "" };
        // Writing to a string does not fail.
        let _ = write!(
            manifest,
            "{comma}\"{}\":\"{:08x}\"",
            json(name),
            id(name).to_bits()
        );
    }
    manifest.push('}');
    vec![
        attribute("name", layer.to_owned()),
        attribute("hash", "MurmurHash3_32".to_owned()),
        attribute("conversion", "uint32_to_float32".to_owned()),
        attribute("manifest", manifest),
    ]
}

/// A text inside quotes of JSON, in ASCII, as attributes have no other characters for certain.
fn json(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            ' '..='~' => out.push(c),
            _ => {
                for unit in c.encode_utf16(&mut [0; 2]) {
                    let _ = write!(out, "\\u{unit:04x}");
                }
            }
        }
    }
    out
}

/// MurmurHash3 of 32 bits for x86, by Austin Appleby, with seed 0.
fn murmur3(bytes: &[u8]) -> u32 {
    let mixed = |k: u32| {
        let k = k.wrapping_mul(0xcc9e_2d51).rotate_left(15);
        k.wrapping_mul(0x1b87_3593)
    };
    let mut hash = 0u32;
    let blocks = bytes.chunks_exact(4);
    let tail = blocks.remainder();
    for block in blocks {
        let k = block.iter().rev().fold(0, |k, &b| k << 8 | u32::from(b));
        hash = (hash ^ mixed(k)).rotate_left(13);
        hash = hash.wrapping_mul(5).wrapping_add(0xe654_6b64);
    }
    if !tail.is_empty() {
        hash ^= mixed(tail.iter().rev().fold(0, |k, &b| k << 8 | u32::from(b)));
    }
    hash ^= bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values that implementations of MurmurHash3 agree on.
    #[test]
    fn hashes_are_those_of_others() {
        for (text, expected) in [
            ("", 0),
            ("hello", 0x248b_fa47),
            ("hello, world", 0x149b_bb7f),
            ("The quick brown fox jumps over the lazy dog", 0x2e4f_f723),
        ] {
            assert_eq!(murmur3(text.as_bytes()), expected, "{text}");
        }
    }

    #[test]
    fn ids_are_numbers() {
        // The hash of nothing is 0, whose exponent is changed.
        assert_eq!(id("").to_bits(), 1 << 23);
        for k in 0..100_000 {
            let id = id(&format!("object {k}"));
            assert!(id.is_normal(), "{k} {id:e}");
        }
    }

    #[test]
    fn layers_have_keys_and_names() {
        let things = ["a \"wall\"".to_owned(), "שלום\n".to_owned()];
        let none = (0, 0.0);
        let ranks = [[(1, 0.75), (0, 0.25), none, none, none, none]];
        let attributes = attributes("CryptoObject", &things);
        let names: Vec<&str> = attributes.iter().map(|a| a.0.as_str()).collect();
        assert_eq!(names[0], "cryptomatte/3ae39a5/name");
        assert!(names.iter().all(|name| name.len() < 32), "{names:?}");
        let manifest: serde_json::Value = serde_json::from_str(&attributes[3].1).unwrap();
        for name in &things {
            let expected = format!("{:08x}", id(name).to_bits());
            assert_eq!(manifest[name.as_str()], expected, "{name}");
        }
        let channels = channels("CryptoObject", &things, &ranks);
        let names: Vec<&str> = channels.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(
            names[..4],
            [
                "CryptoObject00.r",
                "CryptoObject00.g",
                "CryptoObject00.b",
                "CryptoObject00.a"
            ]
        );
        assert_eq!(names[11], "CryptoObject02.a");
        let value = |k: usize| match &channels[k].values {
            ChannelValues::Float(values) => values[0],
            ChannelValues::Index(_) => panic!("an index"),
        };
        assert_eq!(
            [value(1), value(3), value(4), value(5)],
            [0.75, 0.25, 0.0, 0.0]
        );
        assert_eq!(value(0), id("שלום\n"));
    }
}
