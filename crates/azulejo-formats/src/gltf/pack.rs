//! The binary data of a file being written: one buffer, its views and their accessors.

use serde_json::{Value, json};

/// glTF's name for single precision.
const FLOAT: u32 = 5126;

/// The purpose of a view, with glTF's numbers.
#[derive(Clone, Copy, Debug)]
enum Target {
    Vertices = 34_962,
    Indices = 34_963,
}

/// One buffer, filled piece by piece.
#[derive(Debug, Default)]
pub(super) struct Pack {
    /// Its bytes.
    pub bin: Vec<u8>,
    /// Its views.
    pub views: Vec<Value>,
    /// Its accessors.
    pub accessors: Vec<Value>,
}

impl Pack {
    /// Adds bytes, and returns the index of their view.
    pub fn bytes(&mut self, bytes: &[u8]) -> usize {
        let offset = self.start();
        self.bin.extend_from_slice(bytes);
        self.close(offset, None)
    }

    /// Adds an attribute of vertices in single precision, and returns its accessor.
    pub fn attribute<const N: usize>(
        &mut self,
        values: impl ExactSizeIterator<Item = [f64; N]>,
    ) -> usize {
        let count = values.len();
        self.vectors(values);
        self.accessor(json!({ "componentType": FLOAT, "count": count, "type": kind::<N>() }))
    }

    /// Like [`Pack::attribute`], with the least and the greatest values, as positions require them.
    pub fn positions(&mut self, values: impl ExactSizeIterator<Item = [f64; 3]>) -> usize {
        let count = values.len();
        let (least, greatest) = self.vectors(values);
        let wide = |v: [f32; 3]| v.map(f64::from);
        self.accessor(json!({
            "componentType": FLOAT,
            "count": count,
            "type": "VEC3",
            "min": wide(least),
            "max": wide(greatest),
        }))
    }

    /// Adds indices into `vertices` vertices, and returns their accessor.
    pub fn indices(&mut self, indices: &[u32], vertices: usize) -> usize {
        let offset = self.start();
        // The largest number of each type is reserved.
        let is_short = vertices <= usize::from(u16::MAX);
        for &i in indices {
            if is_short {
                self.bin.extend((i as u16).to_le_bytes())
            } else {
                self.bin.extend(i.to_le_bytes())
            }
        }
        self.close(offset, Some(Target::Indices));
        let component = if is_short { 5123 } else { 5125 };
        let count = indices.len();
        self.accessor(json!({ "componentType": component, "count": count, "type": "SCALAR" }))
    }

    /// Adds vectors, and returns the least and the greatest of each component.
    fn vectors<const N: usize>(
        &mut self,
        values: impl ExactSizeIterator<Item = [f64; N]>,
    ) -> ([f32; N], [f32; N]) {
        let offset = self.start();
        self.bin.reserve(4 * N * values.len());
        let (mut least, mut greatest) = ([f32::MAX; N], [f32::MIN; N]);
        for value in values {
            let narrow = value.map(|v| (v as f32).clamp(f32::MIN, f32::MAX));
            for (k, v) in narrow.into_iter().enumerate() {
                least[k] = least[k].min(v);
                greatest[k] = greatest[k].max(v);
                self.bin.extend(v.to_le_bytes());
            }
        }
        self.close(offset, Some(Target::Vertices));
        (least, greatest)
    }

    /// Offset of the next piece: numbers are aligned to their size.
    fn start(&mut self) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        self.bin.len()
    }

    /// Adds a view of the bytes since `offset`.
    fn close(&mut self, offset: usize, target: Option<Target>) -> usize {
        let length = self.bin.len() - offset;
        let mut view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": length });
        if let Some(target) = target {
            view["target"] = json!(target as u32);
        }
        self.views.push(view);
        self.views.len() - 1
    }

    /// Adds an accessor of the latest view.
    fn accessor(&mut self, mut accessor: Value) -> usize {
        accessor["bufferView"] = json!(self.views.len() - 1);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}

fn kind<const N: usize>() -> &'static str {
    match N {
        2 => "VEC2",
        3 => "VEC3",
        _ => "VEC4",
    }
}
