//! JSON: glTF, CityJSON, epJSON, or something else.

use super::words::is_energyplus;
use super::{Detection, Format};

/// The format of JSON, by the names at its top level.
pub(super) fn json_model(bytes: &[u8]) -> Detection {
    // glTF without `asset` is for its reader to refuse.
    const GLTF: [&[u8]; 6] = [
        b"asset",
        b"scenes",
        b"nodes",
        b"meshes",
        b"accessors",
        b"buffers",
    ];
    let mut format = Err("JSON that is not glTF, CityJSON or epJSON");
    for name in TopLevelNames::new(bytes) {
        match name {
            b"CityObjects" => return Ok(Format::CityJson),
            _ if is_energyplus(name) => return Ok(Format::EnergyPlus),
            b"asset" => return Ok(Format::Gltf),
            _ if GLTF.contains(&name) => format = Ok(Format::Gltf),
            _ => {}
        }
    }
    format
}

/// The names of the outermost object of JSON, which need not be well-formed.
struct TopLevelNames<'a> {
    bytes: &'a [u8],
    at: usize,
    depth: u32,
}

impl<'a> TopLevelNames<'a> {
    fn new(bytes: &'a [u8]) -> TopLevelNames<'a> {
        TopLevelNames {
            bytes,
            at: 0,
            depth: 0,
        }
    }

    /// The text in quotes that begins at the current byte, which is passed.
    fn quoted(&mut self) -> Option<&'a [u8]> {
        let start = self.at + 1;
        let mut end = start;
        while *self.bytes.get(end)? != b'"' {
            end += if self.bytes[end] == b'\\' { 2 } else { 1 };
        }
        self.at = end + 1;
        self.bytes.get(start..end)
    }
}

impl<'a> Iterator for TopLevelNames<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        loop {
            match *self.bytes.get(self.at)? {
                b'{' | b'[' => self.depth += 1,
                b'}' | b']' => self.depth = self.depth.saturating_sub(1),
                b'"' => {
                    let text = self.quoted()?;
                    let behind = self.bytes[self.at..].iter();
                    let next = behind.copied().find(|b| !b.is_ascii_whitespace());
                    if self.depth == 1 && next == Some(b':') {
                        return Some(text);
                    }
                    continue;
                }
                _ => {}
            }
            self.at += 1;
        }
    }
}
