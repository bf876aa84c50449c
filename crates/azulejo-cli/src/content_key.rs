//! Keys of work that is stored on disk: a hash of everything that its result depends on.

use azulejo_scene::content::ContentBytes;
use std::fmt::Write;

/// Bytes that are collected before they are hashed: numbers alone would be slow.
const PART: usize = 1 << 16;

/// A key: BLAKE3 of the content.
pub type ContentKey = [u8; 32];

/// Hashes contents one after the other. The key is the same on every machine and with every
/// toolchain.
pub struct ContentHasher {
    hasher: blake3::Hasher,
    part: Vec<u8>,
}

impl ContentHasher {
    /// Of nothing yet.
    pub fn new() -> ContentHasher {
        ContentHasher {
            hasher: blake3::Hasher::new(),
            part: Vec::with_capacity(PART),
        }
    }

    /// Adds a content.
    pub fn add(&mut self, content: &(impl ContentBytes + ?Sized)) -> &mut ContentHasher {
        content.feed(&mut |bytes| {
            if self.part.len() + bytes.len() > PART {
                self.hasher.update(&self.part);
                self.part.clear();
            }
            if bytes.len() > PART {
                self.hasher.update(bytes);
            } else {
                self.part.extend_from_slice(bytes);
            }
        });
        self
    }

    /// The key of all that was added.
    pub fn key(&mut self) -> ContentKey {
        self.hasher.update(&self.part);
        self.part.clear();
        *self.hasher.finalize().as_bytes()
    }
}

/// The first half of a key in hexadecimal digits, for names.
pub fn shown(key: &ContentKey) -> String {
    key[..16].iter().fold(String::new(), |mut text, byte| {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_key_is_that_of_all_bytes() {
        let long = "x".repeat(3 * PART + 1);
        let mut hasher = ContentHasher::new();
        for _ in 0..1000 {
            hasher.add(&1.0).add(&*long);
        }
        let mut bytes = Vec::new();
        for _ in 0..1000 {
            bytes.extend(1f64.to_le_bytes());
            bytes.extend((long.len() as u64).to_le_bytes());
            bytes.extend(long.as_bytes());
        }
        assert_eq!(hasher.key(), *blake3::hash(&bytes).as_bytes());
        // The published value of BLAKE3 for no input.
        let none = shown(&ContentHasher::new().key());
        assert_eq!(none, "af1349b9f5f9a1a6a0404dea36dcc949");
    }
}
