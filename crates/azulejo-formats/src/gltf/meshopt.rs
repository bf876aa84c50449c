//! Decoders of `EXT_meshopt_compression` (Kapoulkine and Rock, 2021; appendices A and B of the
//! extension's specification) and `KHR_meshopt_compression`, which has a second version of the attributes and
//! a filter of colours more.

use crate::reading::bytes::Bytes;
use gltf_json::Value;
use gltf_json::buffer::View;

/// Most bytes that a byte of compressed data may encode: two bits for 16 bytes, or for 256 in the second version.
const MOST_BYTES_PER_BYTE: u64 = 1024;

/// Names of the extensions.
pub(super) const NAMES: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

/// Elements of a group, which are encoded with the same number of bits.
const GROUP: usize = 16;

/// The description of a compressed view in JSON.
#[derive(Debug)]
pub(super) struct CompressedView {
    /// Index of the buffer that holds it.
    pub buffer: usize,
    /// Its offset in the buffer.
    pub offset: u64,
    /// Its compressed size in bytes.
    pub length: u64,
    stride: usize,
    count: usize,
    mode: Mode,
    filter: Filter,
}

#[derive(Clone, Copy, Debug)]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

#[derive(Clone, Copy, Debug)]
enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

impl CompressedView {
    /// The compression of a view, if it has any.
    pub fn of(view: &View) -> Option<Result<CompressedView, String>> {
        let extensions = &view.extensions.as_ref()?.others;
        let mut descriptions = NAMES.iter().filter_map(|name| extensions.get(*name));
        let read = CompressedView::read(descriptions.next()?);
        Some(read.ok_or_else(|| "compressed data with an invalid description".to_owned()))
    }

    fn read(json: &Value) -> Option<CompressedView> {
        let number = |key: &str| json.get(key).and_then(Value::as_u64);
        let word = |key: &str| json.get(key).and_then(Value::as_str);
        let packed = CompressedView {
            buffer: usize::try_from(number("buffer")?).ok()?,
            offset: number("byteOffset").unwrap_or(0),
            length: number("byteLength")?,
            stride: usize::try_from(number("byteStride")?).ok()?,
            count: usize::try_from(number("count")?).ok()?,
            mode: match word("mode")? {
                "ATTRIBUTES" => Mode::Attributes,
                "TRIANGLES" => Mode::Triangles,
                "INDICES" => Mode::Indices,
                _ => return None,
            },
            filter: match word("filter").unwrap_or("NONE") {
                "NONE" => Filter::None,
                "OCTAHEDRAL" => Filter::Octahedral,
                "QUATERNION" => Filter::Quaternion,
                "EXPONENTIAL" => Filter::Exponential,
                "COLOR" => Filter::Color,
                _ => return None,
            },
        };
        packed.is_sound().then_some(packed)
    }

    /// Whether the numbers are consistent, and no byte would expand to more than it can encode.
    fn is_sound(&self) -> bool {
        let stride = self.stride;
        let fits = match (self.mode, self.filter) {
            (Mode::Attributes, Filter::None | Filter::Exponential) => {
                stride > 0 && stride.is_multiple_of(4) && stride <= 256
            }
            (Mode::Attributes, Filter::Octahedral | Filter::Color) => stride == 4 || stride == 8,
            (Mode::Attributes, Filter::Quaternion) => stride == 8,
            (Mode::Triangles, Filter::None) => {
                (stride == 2 || stride == 4) && self.count.is_multiple_of(3)
            }
            (Mode::Indices, Filter::None) => stride == 2 || stride == 4,
            _ => false,
        };
        let most = self.length.saturating_mul(MOST_BYTES_PER_BYTE);
        fits && self.size() <= most
    }

    /// Decompressed size in bytes.
    pub fn size(&self) -> u64 {
        (self.count as u64).saturating_mul(self.stride as u64)
    }

    /// Decodes `bytes`, the compressed data.
    ///
    /// # Errors
    /// The reason, for data that ends too soon or begins with the header of another version.
    pub fn decode(&self, bytes: &[u8]) -> Result<Vec<u8>, String> {
        let decoded = match self.mode {
            Mode::Attributes => attributes(bytes, self.count, self.stride),
            Mode::Triangles => triangles(bytes, self.count).map(|i| self.narrowed(&i)),
            Mode::Indices => indices(bytes, self.count).map(|i| self.narrowed(&i)),
        };
        let mut decoded = decoded.ok_or("damaged compressed data")?;
        match self.filter {
            Filter::None => {}
            Filter::Octahedral if self.stride == 4 => each(&mut decoded, octahedral_bytes),
            Filter::Octahedral => each(&mut decoded, octahedral_shorts),
            Filter::Quaternion => each(&mut decoded, quaternion),
            Filter::Exponential => each(&mut decoded, exponential),
            Filter::Color if self.stride == 4 => each(&mut decoded, |[y, co, cg, a]: [u8; 4]| {
                let [co, cg] = [co, cg].map(|b| i32::from(b.cast_signed()));
                color([y.into(), co, cg, a.into()], 255.0).map(|v| v as u8)
            }),
            Filter::Color => each(&mut decoded, |e| {
                let [y, co, cg, a] = shorts(e);
                let [y, a] = [y, a].map(|v| i32::from(v.cast_unsigned()));
                let rgba = color([y, co.into(), cg.into(), a], 65535.0);
                let [r, g, b, a] = rgba.map(|v| (v as u16).cast_signed());
                bytes_of([r, g, b], a)
            }),
        }
        Ok(decoded)
    }

    /// Indices as bytes, two or four for each.
    fn narrowed(&self, indices: &[u32]) -> Vec<u8> {
        let bytes = indices.iter().map(|i| i.to_le_bytes());
        bytes
            .flat_map(|b| b.into_iter().take(self.stride))
            .collect()
    }
}

fn zigzag(v: u8) -> u8 {
    (v >> 1) ^ (v & 1).wrapping_neg()
}

fn zigzag_wide(v: u32) -> u32 {
    (v >> 1) ^ (v & 1).wrapping_neg()
}

/// Mode 0, versions 0 and 1. Elements are stored in blocks; in a block, the first bytes of all elements are
/// followed by the second bytes, each as its difference from the previous element.
fn attributes(bytes: &[u8], count: usize, stride: usize) -> Option<Vec<u8>> {
    let is_first = match bytes.first()? {
        0xa0 => true,
        0xa1 => false,
        _ => return None,
    };
    // The base of the first element is in the tail, padded at its front, and the channels of version 1.
    let (channels, least) = if is_first { (0, 32) } else { (stride / 4, 24) };
    let tail = bytes.get(bytes.len().checked_sub(stride + channels)?..)?;
    let (base, channels) = tail.split_at(stride);
    let mut last = base.to_vec();
    let mut data = Bytes::new(bytes.get(1..bytes.len().checked_sub(least.max(tail.len()))?)?);
    let most = ((8192 / stride) & !(GROUP - 1)).min(256);
    let mut elements = vec![0; count * stride];
    for block in elements.chunks_mut(most * stride) {
        let controls = data.take(channels.len())?;
        for k in 0..stride {
            let control = controls.get(k / 4).map(|c| c >> (k % 4 * 2) & 3);
            byte_column(&mut data, &mut block[k..], stride, control)?;
        }
        for (k, last) in last.chunks_mut(4).enumerate() {
            let channel = channels.get(k).copied().unwrap_or(0);
            sum_up(&mut block[4 * k..], stride, channel, last.try_into().ok()?)?;
        }
    }
    Some(elements)
}

/// Decodes one byte of the difference of each element of a block: every `stride`-th of `block`.
fn byte_column(
    data: &mut Bytes,
    block: &mut [u8],
    stride: usize,
    control: Option<u8>,
) -> Option<()> {
    let count = block.len().div_ceil(stride);
    let mut slots = block.iter_mut().step_by(stride);
    let bits = match control {
        None => [0, 2, 4, 8],
        Some(0) => [0, 1, 2, 4],
        Some(1) => [1, 2, 4, 8],
        Some(2) => return Some(()),
        _ => {
            slots
                .zip(data.take(count)?)
                .for_each(|(slot, b)| *slot = *b);
            return Some(());
        }
    };
    let groups = count.div_ceil(GROUP);
    let headers = data.take(groups.div_ceil(4))?;
    for group in 0..groups {
        let mode = headers[group / 4] >> (group % 4 * 2) & 3;
        // The last group may be longer than the rest of the block.
        let deltas = deltas(data, bits[usize::from(mode)])?;
        slots.by_ref().zip(deltas).for_each(|(slot, d)| *slot = d);
    }
    Some(())
}

/// The differences of a group, of 0 to 8 bits each. The largest value of 1, 2 or 4 bits means that
/// a byte after the bits of the group holds the difference.
fn deltas(data: &mut Bytes, bits: usize) -> Option<[u8; GROUP]> {
    match bits {
        0 => return Some([0; GROUP]),
        8 => return data.take(GROUP)?.try_into().ok(),
        _ => {}
    }
    let per_byte = 8 / bits;
    let escape = (1 << bits) - 1;
    let packed = data.take(GROUP / per_byte)?;
    let mut deltas = [0; GROUP];
    for (i, delta) in deltas.iter_mut().enumerate() {
        let at = bits * (i % per_byte);
        let shift = if bits == 1 { at } else { 8 - bits - at };
        *delta = packed[i / per_byte] >> shift & escape;
        if *delta == escape {
            *delta = data.u8_le()?;
        }
    }
    Some(deltas)
}

/// Makes elements of the differences in four bytes of each: sums of bytes, or of two bytes together, or the
/// exclusive or of all four, turned, as the channel says.
fn sum_up(block: &mut [u8], stride: usize, channel: u8, last: &mut [u8; 4]) -> Option<()> {
    for element in block.chunks_mut(stride) {
        let delta: &mut [u8; 4] = element.first_chunk_mut()?;
        *last = match channel & 3 {
            0 => std::array::from_fn(|i| last[i].wrapping_add(zigzag(delta[i]))),
            1 => {
                let [a, b, c, d] = *last;
                let [e, f, g, h] = *delta;
                let sum = |last: [u8; 2], delta: [u8; 2]| {
                    let delta = zigzag_wide(u16::from_le_bytes(delta).into()) as u16;
                    u16::from_le_bytes(last).wrapping_add(delta).to_le_bytes()
                };
                let ([a, b], [c, d]) = (sum([a, b], [e, f]), sum([c, d], [g, h]));
                [a, b, c, d]
            }
            2 => {
                let delta = u32::from_le_bytes(*delta).rotate_right(u32::from(channel >> 4));
                (u32::from_le_bytes(*last) ^ delta).to_le_bytes()
            }
            _ => return None,
        };
        *delta = *last;
    }
    Some(())
}

/// A number of 7 bits per byte, lowest bits first; the highest bit means that more follow.
fn varint(data: &mut Bytes) -> Option<u32> {
    let mut value = 0;
    for shift in (0..35).step_by(7) {
        let byte = data.u8_le()?;
        value |= u32::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Some(value);
        }
    }
    None
}

/// Mode 2: each index as its difference from one of the previous two.
fn indices(bytes: &[u8], count: usize) -> Option<Vec<u32>> {
    let mut data = Bytes::new(&bytes[..bytes.len().checked_sub(4)?]);
    if data.u8_le()? & 0xfe != 0xd0 {
        return None;
    }
    let mut last = [0u32; 2];
    let mut next = || {
        let v = varint(&mut data)?;
        let base = &mut last[v as usize & 1];
        *base = base.wrapping_add(zigzag_wide(v >> 1));
        Some(*base)
    };
    (0..count).map(|_| next()).collect()
}

/// The last 16 values, indexed backwards from the latest.
#[derive(Clone, Copy)]
struct Recent<T> {
    ring: [T; 16],
    next: usize,
}

impl<T: Copy + Default> Recent<T> {
    fn new() -> Recent<T> {
        Recent {
            ring: [T::default(); 16],
            next: 0,
        }
    }

    fn push(&mut self, value: T) {
        self.ring[self.next % 16] = value;
        self.next += 1;
    }

    fn get(&self, back: u8) -> T {
        self.ring[(self.next + 15 - usize::from(back)) % 16]
    }
}

/// Decoder of mode 1, which encodes what each triangle shares with previous ones.
struct Triangles<'a> {
    data: Bytes<'a>,
    next: u32,
    last: u32,
    edges: Recent<(u32, u32)>,
    vertices: Recent<u32>,
}

/// Mode 1: a byte for each triangle, the data that these leave open, and a table of frequent codes.
fn triangles(bytes: &[u8], count: usize) -> Option<Vec<u32>> {
    let (head, table) = bytes.split_last_chunk::<16>()?;
    let mut data = Bytes::new(head);
    if data.u8_le()? & 0xfe != 0xe0 {
        return None;
    }
    let codes = data.take(count / 3)?;
    let mut triangles = Triangles {
        data,
        next: 0,
        last: 0,
        edges: Recent::new(),
        vertices: Recent::new(),
    };
    let mut indices = Vec::with_capacity(count);
    for &code in codes {
        let triangle = match code >> 4 {
            0xf => triangles.without_edge(code & 15, table)?,
            edge => triangles.beside_edge(edge, code & 15)?,
        };
        indices.extend(triangle);
    }
    Some(indices)
}

impl Triangles<'_> {
    fn fresh(&mut self) -> u32 {
        self.next = self.next.wrapping_add(1);
        self.next.wrapping_sub(1)
    }

    /// A vertex in the data, as its difference from the previous one there.
    fn explicit(&mut self) -> Option<u32> {
        let delta = zigzag_wide(varint(&mut self.data)?);
        self.last = self.last.wrapping_add(delta);
        Some(self.last)
    }

    /// A triangle at a recent edge.
    fn beside_edge(&mut self, edge: u8, vertex: u8) -> Option<[u32; 3]> {
        let (a, b) = self.edges.get(edge);
        let c = match vertex {
            0 => self.fresh(),
            1..0xd => self.vertices.get(vertex),
            0xd => self.last.wrapping_sub(1),
            0xe => self.last.wrapping_add(1),
            _ => self.explicit()?,
        };
        if let 0xd | 0xe = vertex {
            self.last = c;
        }
        if !(1..0xd).contains(&vertex) {
            self.vertices.push(c);
        }
        self.edges.push((c, b));
        self.edges.push((a, c));
        Some([a, b, c])
    }

    /// A triangle of three vertices, by a code in the table or in the data.
    fn without_edge(&mut self, code: u8, table: &[u8; 16]) -> Option<[u32; 3]> {
        let from_table = code < 0xe;
        let pair = if from_table {
            table[usize::from(code)]
        } else {
            self.data.u8_le()?
        };
        if !from_table && pair == 0 {
            self.next = 0;
        }
        let a = match code {
            0xf => self.explicit()?,
            _ => self.fresh(),
        };
        let (b, b_is_new) = self.vertex(pair >> 4, from_table)?;
        let (c, c_is_new) = self.vertex(pair & 15, from_table)?;
        self.vertices.push(a);
        for (vertex, is_new) in [(b, b_is_new), (c, c_is_new)] {
            if is_new {
                self.vertices.push(vertex);
            }
        }
        self.edges.push((b, a));
        self.edges.push((c, b));
        self.edges.push((a, c));
        Some([a, b, c])
    }

    /// A vertex by half of a code, and whether it must be added to the recent ones.
    fn vertex(&mut self, half: u8, from_table: bool) -> Option<(u32, bool)> {
        match half {
            0 => Some((self.fresh(), true)),
            0xf if from_table => None,
            0xf => Some((self.explicit()?, true)),
            back => Some((self.vertices.get(back - 1), false)),
        }
    }
}

/// Applies a filter to every `N` bytes.
fn each<const N: usize>(bytes: &mut [u8], filter: impl Fn([u8; N]) -> [u8; N]) {
    let (elements, _) = bytes.as_chunks_mut::<N>();
    for element in elements {
        *element = filter(*element);
    }
}

fn octahedral_bytes(element: [u8; 4]) -> [u8; 4] {
    let [x, y, one, w] = element.map(|b| f32::from(b.cast_signed()));
    let [x, y, z] = octahedral(x, y, one).map(|v| ((v * 127.0).round() as i8).cast_unsigned());
    [x, y, z, (w as i8).cast_unsigned()]
}

fn octahedral_shorts(element: [u8; 8]) -> [u8; 8] {
    let [x, y, one, w] = shorts(element);
    let [x, y, z] = octahedral(x.into(), y.into(), one.into());
    bytes_of([x, y, z].map(|v| (v * 32767.0).round() as i16), w)
}

/// A unit vector from its octahedral encoding.
fn octahedral(x: f32, y: f32, one: f32) -> [f32; 3] {
    let (x, y) = (x / one, y / one);
    let z = 1.0 - x.abs() - y.abs();
    let fold = z.min(0.0);
    let (x, y) = (x - fold.copysign(x), y - fold.copysign(y));
    let length = (x * x + y * y + z * z).sqrt();
    [x / length, y / length, z / length]
}

/// A unit quaternion from its three smaller components.
fn quaternion(element: [u8; 8]) -> [u8; 8] {
    let [x, y, z, code] = shorts(element);
    let scale = std::f32::consts::FRAC_1_SQRT_2 / f32::from(code | 3);
    let [x, y, z] = [x, y, z].map(|v| f32::from(v) * scale);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let largest = usize::from(code.cast_unsigned() & 3);
    let mut turned = [0; 4];
    for (k, v) in [w, x, y, z].into_iter().enumerate() {
        turned[(largest + k) % 4] = (v * 32767.0).round() as i16;
    }
    let [x, y, z, w] = turned;
    bytes_of([x, y, z], w)
}

/// A single-precision number from an exponent in the upper 8 bits and a mantissa in the lower 24.
fn exponential(element: [u8; 4]) -> [u8; 4] {
    let value = i32::from_le_bytes(element);
    let mantissa = value << 8 >> 8;
    (2f32.powi(value >> 24) * mantissa as f32).to_le_bytes()
}

/// Red, green, blue and alpha up to `most`, from YCoCg and an alpha whose highest bit tells how many bits they have.
fn color([y, co, cg, a]: [i32; 4], most: f32) -> [f32; 4] {
    let Some(bit) = a.checked_ilog2() else {
        return [0.0; 4];
    };
    let scale = most / ((2 << bit) - 1) as f32;
    let a = a & ((1 << bit) - 1);
    let share = |v: i32| (v as f32 * scale).round().clamp(0.0, most);
    [y + co - cg, y + cg, y - co - cg, a << 1 | a & 1].map(share)
}

fn shorts(element: [u8; 8]) -> [i16; 4] {
    let (pairs, _) = element.as_chunks::<2>();
    std::array::from_fn(|k| i16::from_le_bytes(pairs[k]))
}

fn bytes_of([x, y, z]: [i16; 3], w: i16) -> [u8; 8] {
    let mut element = [0; 8];
    for (slot, value) in element.chunks_mut(2).zip([x, y, z, w]) {
        slot.copy_from_slice(&value.to_le_bytes());
    }
    element
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Packed data described by this JSON, whose position is added.
    fn packed(json: &str, length: usize) -> Option<CompressedView> {
        let json = format!("{{\"buffer\":0,\"byteLength\":{length},{json}}}");
        CompressedView::read(&serde_json::from_str(&json).unwrap())
    }

    fn bytes(hex: &str) -> Vec<u8> {
        let digits: Vec<u8> = hex.bytes().filter(u8::is_ascii_hexdigit).collect();
        let value = |d: u8| char::from(d).to_digit(16).unwrap() as u8;
        let (pairs, _) = digits.as_chunks::<2>();
        pairs
            .iter()
            .map(|&[h, l]| value(h) << 4 | value(l))
            .collect()
    }

    /// Decodes what meshoptimizer 0.25 wrote, and checks that no truncation does harm.
    fn check(json: &str, hex: &str, expected: &[u8]) {
        let file = bytes(hex);
        let packed = packed(json, file.len()).unwrap();
        assert_eq!(packed.decode(&file).as_deref(), Ok(expected), "{json}");
        for end in 0..file.len() {
            let _ = packed.decode(&file[..end]);
        }
        let mut changed = file.clone();
        for at in 0..file.len() {
            for value in [0, 0xff, file[at] ^ 0x80, file[at].wrapping_add(1)] {
                changed[at] = value;
                let _ = packed.decode(&changed);
            }
            changed[at] = file[at];
        }
    }

    fn check_indices(json: &str, hex: &str, expected: &[u32]) {
        let expected: Vec<u8> = expected.iter().flat_map(|i| i.to_le_bytes()).collect();
        check(json, hex, &expected);
    }

    #[test]
    fn attributes_of_every_kind_of_group() {
        let element = |i: u32| {
            let second = if i < 16 { 0 } else { i & 3 };
            [i, i * i, i * 37, 7, second, i >> 2, 255 - i, i * i * i].map(|v| v as u8)
        };
        let expected: Vec<u8> = (0..40).flat_map(element).collect();
        check(
            "\"byteStride\":8,\"count\":40,\"mode\":\"ATTRIBUTES\"",
            "a0152aaaaaaaaaaaaaaaaaaa00001f0002060a0e12161a1e22262a2e32363a3e42464a4e52565a5e6266 \
             6a6e72767affff00007e82868a8e92969a1f004a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a \
             4a4a4a4a4a4a4a4affff00004a4a4a4a4a4a4a4a00142aeaeaea050505eaea0000050515008080808080 \
             808080800000151555555555555555555500001f00020e264a7ab6fead4d1e96e55546ee5d62d106ea25 \
             d621f212c17645f56631ffff0000bdc24e1975c5f6be0000000000000000000000000000000000000000 \
             00000000000000070000ff00",
            &expected,
        );
    }

    #[test]
    fn triangles_of_a_grid_and_isolated_ones() {
        check_indices(
            "\"byteStride\":4,\"count\":105,\"mode\":\"TRIANGLES\"",
            "e1fe1e100e100e100ece1e160e150e140ece1e140e140e140ece1e140e140e140effffff0f0af80029ff \
             0c0000ffb601c30160007687566778a9866589689801690000",
            &[
                0, 1, 5, 5, 1, 6, 6, 1, 2, 6, 2, 7, 7, 2, 3, 7, 3, 8, 8, 3, 4, 8, 4, 9, 5, 6, 10,
                10, 6, 11, 11, 6, 7, 11, 7, 12, 12, 7, 8, 12, 8, 13, 13, 8, 9, 13, 9, 14, 10, 11,
                15, 15, 11, 16, 16, 11, 12, 16, 12, 17, 17, 12, 13, 17, 13, 18, 18, 13, 14, 18, 14,
                19, 15, 16, 20, 20, 16, 21, 21, 16, 17, 21, 17, 22, 22, 17, 18, 22, 18, 23, 23, 18,
                19, 23, 19, 24, 24, 3, 17, 9, 9, 9, 100, 2, 50,
            ],
        );
    }

    #[test]
    fn two_runs_of_indices() {
        check_indices(
            "\"byteStride\":4,\"count\":10,\"mode\":\"INDICES\"",
            "d1000404d10f05040405f0b418c30f00000000",
            &[0, 1, 2, 500, 501, 3, 4, 502, 100_000, 5],
        );
    }

    #[test]
    fn filters() {
        let cases = [
            (
                "\"byteStride\":4,\"count\":3,\"mode\":\"ATTRIBUTES\",\"filter\":\"OCTAHEDRAL\"",
                "a0013c000000913a013c00000091b500010c000000fe000000000000000000000000000000000000000000000000000000007f007f00",
                "7f0000004c9a00003c4cae7f",
            ),
            (
                "\"byteStride\":8,\"count\":3,\"mode\":\"ATTRIBUTES\",\"filter\":\"OCTAHEDRAL\"",
                "a0013c000000dc6f013c0000000704013c000000dcac013c000000091400000104000000010c000000fe000000000000000000000000000000000000000000000000ff070000ff070000",
                "ff7f000000000000c54c959900000000693dca4c0daeff7f",
            ),
            (
                "\"byteStride\":8,\"count\":3,\"mode\":\"ATTRIBUTES\",\"filter\":\"QUATERNION\"",
                "a0013c000000b170013c0000000a0d013c000000b1de013c0000000a19013c000000b170013c0000000a0d01380000000500000000000000000000000000000000000000000000000000000000000000ff07",
                "000000000000ff7f0f40fa3ffa3ffa3f39f39f5939f36ca6",
            ),
            (
                "\"byteStride\":16,\"count\":1,\"mode\":\"ATTRIBUTES\",\"filter\":\"EXPONENTIAL\"",
                "a0000000000000000000000000000000000000000000000000000000000000000001000000fdffff00000000003a300000",
                "0000803f000040c00000000000e84046",
            ),
        ];
        for (json, hex, expected) in cases {
            check(json, hex, &bytes(expected));
        }
    }

    /// What meshoptimizer 1.2 writes and reads as version 1: every kind of control and channel, and colours.
    #[test]
    fn second_version() {
        let cases = [
            (
                16,
                40,
                "NONE",
                "a19f774daa005252d6d5d7d5d7d570ebe9ebebebe9ebebeb52f5f3f5f5f5f5f5f5f5f5f3f5f5f5f5f5f5f5f3 \
             f500b8b8a3a3a3a3a3a33d515151515151515151b828282828282828282828282828282828282828282b005e \
             5e522e30302e301a181818161818ffffccccccaccccc18181816ccccccac00000000002f2f2f2f2f2f2f2f2f \
             2f2f2f2f2f2f2f2f2f2f2f2f2f2f2f2f2f2f2f2f2f2f2f2f2f2f2f2f2f2f2a06888888888688888888886888 \
             8888888688888800000000001111111111111111111111111111111111111111111111111111111111111111 \
             111111111111112a055555555555555555555555555557555555555500000000152aaaaaaaaaaaaaaaaaaa00 \
             000002060a0e12161a1e22262a2e32363a3e42464a4e52565a5e62666a6e72767a7e82868a8e92969a282666 \
             66666666000015155555555555555555550000000000000000803f0000ffff000000ff0403020101000000",
                "0000803f0000ffff000000ff04030201295caf3fe803f6fc010100fe0403020152b8de3fd007edf9020400fd \
             040302013d0a0740b80be4f6030900fc0403020152b81e40a00fdbf3041000fb04030201666636408813d2f0 \
             051900fa040302017b144e407017c9ed062400f9040302018fc26540581bc0ea073100f804030201a4707d40 \
             401fb7e7084000f7040302015c8f8a402823aee4095100f604030201666696401027a5e10a6400f504030201 \
             713da240f82a9cde0b7900f4040302017b14ae40e02e93db0c9000f30403020185ebb940c8328ad80da900f2 \
             040302018fc2c540b03681d50ec400f1040302019a99d140983a78d20fe100f004030201a470dd40803e6fcf \
             100000ef04030201ae47e940684266cc112101ee04030201b81ef54050465dc9124400ed04030201e17a0041 \
             384a54c6136901ec0403020166660641204e4bc3149000eb04030201ec510c41085242c015b901ea04030201 \
             713d1241f05539bd16e400e904030201f6281841d85930ba171101e8040302017b141e41c05d27b7184000e7 \
             0403020100002441a8611eb4197101e60403020185eb2941906515b11aa400e5040302010ad72f4178690cae \
             1bd901e4040302018fc23541606d03ab1c1000e30403020114ae3b414871faa71d4901e2040302019a994141 \
             3075f1a41e8400e1040302011f8547411879e8a11fc101e004030201a4704d41007ddf9e200000df04030201 \
             295c5341e880d69b214101de04030201ae475941d084cd98228400dd0403020133335f41b888c49523c901dc \
             04030201b81e6541a08cbb92241000db040302013d0a6b418890b28f255901da04030201c3f570417094a98c \
             26a400d90403020148e176415898a08927f101d804030201",
            ),
            (
                4,
                20,
                "NONE",
                "a1ff00516181731e01214153f2278b0222426282a27b001046a69cc6d97919e7a645c4da7a1a45a5fa9f00ee \
             3129bb4ed10eee6b238661d20ded32ad729300a9b63c29c996097e89480fca950aaab5154d73000000000000 \
             00000000000000000000000000c67edfd600",
                "c67edfd69d8656816ca93ddc2bfc28faf14acae500adf180ff4088cbee038fc6cdf60605a382d0c01cd5bee4 \
             08b201dcc214d041c38139f6d4be32fbf5cbbb5026a8d4f567557deab8d2b6c37a826c89",
            ),
            (
                4,
                20,
                "NONE",
                "a19a02079b9f9b979b9f9b0f0f0f000907090b000000000000000000000000000000000000000000003f62",
                "0000003f001c003f0038003f0014003f0030003f000c003f0028003f0004003f0020003f003c003f0018003f \
             0034003f0010003f002c003f0008003f0024003f0000003f001c003f0038003f0014003f",
            ),
            (
                4,
                3,
                "COLOR",
                "a1ff0066e500d03200ca4b007d7f00000000000000000000000000000000000000407fc1ff00",
                "fe0100ff3499668000000000",
            ),
            (
                8,
                3,
                "COLOR",
                "a1ffff00666500060d00d0cd00110400cacb000c0300020000050700000000000000000000000000000004ff \
             0701fcff0f0000",
                "efff10000000ffff43339999666608800000000000000000",
            ),
        ];
        for (stride, count, filter, hex, expected) in cases {
            let json = format!(
                "\"byteStride\":{stride},\"count\":{count},\"mode\":\"ATTRIBUTES\",\"filter\":\"{filter}\""
            );
            check(&json, hex, &bytes(expected));
        }
    }

    #[test]
    fn invalid_descriptions() {
        let refused = |json: &str, length| assert!(packed(json, length).is_none(), "{json}");
        refused("\"byteStride\":4,\"count\":1", 99);
        refused("\"byteStride\":3,\"count\":1,\"mode\":\"ATTRIBUTES\"", 99);
        refused("\"byteStride\":4,\"count\":4,\"mode\":\"TRIANGLES\"", 99);
        refused("\"byteStride\":4,\"count\":3,\"mode\":\"WORDS\"", 99);
        refused(
            "\"byteStride\":4,\"count\":4000000000,\"mode\":\"INDICES\"",
            99,
        );
        let quaternions = "\"mode\":\"ATTRIBUTES\",\"filter\":\"QUATERNION\"";
        refused(&format!("\"byteStride\":4,\"count\":1,{quaternions}"), 99);
    }
}
