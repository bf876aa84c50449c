//! Fields of a record, by their offset from its start.

use crate::reading::text::text;
use azulejo_scene::Rgb;
use glam::DVec3;

/// The bytes of one record, including opcode and length. Everything is big-endian.
///
/// A field beyond the end of the record is `None`: records only grew from one revision to the next,
/// and each reader has a default for a missing field.
#[derive(Clone, Copy, Debug)]
pub(super) struct RecordFields<'a>(pub &'a [u8]);

impl<'a> RecordFields<'a> {
    fn array<const N: usize>(self, at: usize) -> Option<[u8; N]> {
        self.0.get(at..at.checked_add(N)?)?.try_into().ok()
    }

    pub fn u8(self, at: usize) -> Option<u8> {
        self.0.get(at).copied()
    }

    pub fn u16(self, at: usize) -> Option<u16> {
        self.array(at).map(u16::from_be_bytes)
    }

    pub fn i16(self, at: usize) -> Option<i16> {
        self.array(at).map(i16::from_be_bytes)
    }

    pub fn u32(self, at: usize) -> Option<u32> {
        self.array(at).map(u32::from_be_bytes)
    }

    pub fn i32(self, at: usize) -> Option<i32> {
        self.array(at).map(i32::from_be_bytes)
    }

    /// A field of type `f32`.
    pub fn single(self, at: usize) -> Option<f64> {
        self.array(at).map(|b| f64::from(f32::from_be_bytes(b)))
    }

    /// A field of type `f64`.
    pub fn double(self, at: usize) -> Option<f64> {
        self.array(at).map(f64::from_be_bytes)
    }

    /// Three consecutive `f32`.
    pub fn singles(self, at: usize) -> Option<DVec3> {
        let bytes: [u8; 12] = self.array(at)?;
        let part = |k: usize| f64::from(f32::from_be_bytes([0, 1, 2, 3].map(|i| bytes[4 * k + i])));
        Some(DVec3::new(part(0), part(1), part(2)))
    }

    /// Three consecutive `f64`.
    pub fn doubles(self, at: usize) -> Option<DVec3> {
        let end = at.checked_add(24)?;
        let (parts, _) = self.0.get(at..end)?.as_chunks::<8>();
        let [x, y, z] = [parts[0], parts[1], parts[2]].map(f64::from_be_bytes);
        Some(DVec3::new(x, y, z))
    }

    /// Three consecutive `f32` as a colour.
    pub fn color(self, at: usize) -> Option<Rgb> {
        self.singles(at).map(|c| c.to_array().into())
    }

    /// A colour of four bytes: alpha, blue, green, red.
    pub fn packed_color(self, at: usize) -> Option<Rgb> {
        let [_, b, g, r] = self.array(at)?;
        Some(Rgb::new(f64::from(r), f64::from(g), f64::from(b)) / 255.0)
    }

    /// A text of up to `length` bytes, terminated by a zero.
    pub fn text(self, at: usize, length: usize) -> String {
        let end = at.saturating_add(length).min(self.0.len());
        let field = self.0.get(at..end).unwrap_or_default();
        let field = field.split(|b| *b == 0).next().unwrap_or_default();
        text(field).trim().to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_end_with_their_record() {
        let fields = RecordFields(b"\x00\x05\x00\x0c a\xe9\0zz\xff\x80");
        assert_eq!((fields.u16(0), fields.u16(10)), (Some(5), Some(0xff80)));
        assert_eq!((fields.i16(10), fields.u16(11)), (Some(-128), None));
        assert_eq!((fields.u32(9), fields.u32(usize::MAX)), (None, None));
        assert_eq!(fields.text(4, 8), "aé");
        assert_eq!(fields.text(8, 100), "zzÿ\u{80}");
        assert_eq!(fields.text(100, 8), "");
        assert!(fields.doubles(4).is_none() && fields.singles(4).is_none());
        assert_eq!(
            fields.packed_color(0),
            Some(Rgb::new(12.0, 0.0, 5.0) / 255.0)
        );
    }
}
