//! Files put together for tests.

use super::super::super::container::tests::glb_of;
use super::super::PatchedFile;
use super::super::glb::Parts;
use serde_json::Value;

/// A file that is put together.
#[derive(Default)]
pub struct Craft {
    pub bin: Vec<u8>,
    pub views: Vec<String>,
    pub accessors: Vec<String>,
}

impl Craft {
    /// Adds a view of bytes, and returns its index.
    pub fn view(&mut self, bytes: &[u8], more: &str) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        self.views.push(format!(
            "{{\"buffer\":0, \"byteOffset\":{},\"byteLength\":{}{more}}}",
            self.bin.len(),
            bytes.len()
        ));
        self.bin.extend(bytes);
        self.views.len() - 1
    }

    /// Adds an accessor of bytes, and returns its index.
    pub fn accessor(
        &mut self,
        bytes: &[u8],
        component: u32,
        count: usize,
        kind: &str,
        more: &str,
    ) -> usize {
        let view = self.view(bytes, "");
        self.accessors.push(format!(
            "{{ \"bufferView\":{view},\"componentType\":{component},\"count\":{count},\
             \"type\":\"{kind}\"{more} }}"
        ));
        self.accessors.len() - 1
    }

    /// Adds an accessor of floats.
    pub fn floats(&mut self, values: &[f32], kind: &str) -> usize {
        let width = match kind {
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 1,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let bounds = if kind == "VEC3" {
            let at = |k: usize| values.iter().skip(k).step_by(3).copied();
            let least: Vec<f32> = (0..3)
                .map(|k| at(k).fold(f32::INFINITY, f32::min))
                .collect();
            let most: Vec<f32> = (0..3)
                .map(|k| at(k).fold(f32::NEG_INFINITY, f32::max))
                .collect();
            format!(",\"min\":{least:?},\"max\":{most:?}")
        } else {
            String::new()
        };
        self.accessor(&bytes, 5126, values.len() / width, kind, &bounds)
    }

    /// Positions of a strip of `quads` squares, two vertices each, and one more pair.
    pub fn positions(&mut self, quads: usize) -> usize {
        let pairs = 0..=quads;
        let values: Vec<f32> = pairs
            .flat_map(|i| [i as f32, 0.0, 0.0, i as f32, 1.0, 0.0])
            .collect();
        self.floats(&values, "VEC3")
    }

    /// Indices of the triangles of those squares, in this many bytes each.
    pub fn triangles(&mut self, quads: usize, size: usize) -> usize {
        let corners = (0..quads as u32).flat_map(|q| [0, 2, 1, 1, 2, 3].map(|k| 2 * q + k));
        let bytes: Vec<u8> = corners
            .flat_map(|v| v.to_le_bytes().into_iter().take(size))
            .collect();
        let component = match size {
            1 => 5121,
            2 => 5123,
            _ => 5125,
        };
        self.accessor(&bytes, component, 6 * quads, "SCALAR", "")
    }

    /// The JSON, with `rest` after the lists; `buffer` is how its buffer begins.
    pub fn json(&self, buffer: &str, rest: &str) -> String {
        let lists = [
            ("bufferViews", self.views.join(" ,\r\n")),
            ("accessors", self.accessors.join(",")),
        ];
        let lists = lists.map(|(name, list)| format!("\"{name}\" : [ {list}\t]"));
        format!(
            "{{\r\n\"asset\": {{\"version\":\"2.0\"}},\"buffers\":[{{{buffer}\"byteLength\":{}}}],\n{},\n{rest} }}",
            self.bin.len(),
            lists.join(",\n")
        )
    }

    /// A GLB of this.
    pub fn glb(&self, rest: &str) -> Vec<u8> {
        let mut json = self.json("", rest).into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut bin = self.bin.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        glb_of(&[(b"JSON", &json), (b"BIN\0", &bin)])
    }
}

/// The members of a primitive of [`two_squares`].
pub const SQUARES: &str = r#""attributes":{"POSITION":0},"indices":1"#;

/// A file of two squares: accessor 0 are their positions, accessor 1 their triangles.
pub fn two_squares() -> Craft {
    let mut craft = Craft::default();
    craft.positions(2);
    craft.triangles(2, 2);
    craft
}

/// A GLB of two squares. In the JSON, `@` stands for [`SQUARES`].
pub fn squares(rest: &str) -> Vec<u8> {
    two_squares().glb(&rest.replace('@', SQUARES))
}

/// The JSON of an edited file.
pub fn json_of(file: &PatchedFile) -> Value {
    let parts = Parts::of(&file.bytes, "a").unwrap();
    serde_json::from_str(parts.text).unwrap()
}
