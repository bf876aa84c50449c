//! Bounds-checked reads of numbers from the bytes of binary formats.

/// A cursor over the bytes of a binary file, or of a piece of one.
///
/// Every read either succeeds and advances, or returns `None` and leaves the cursor unchanged.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bytes<'a> {
    bytes: &'a [u8],
    /// Offset of `bytes` in the file.
    start: usize,
    at: usize,
}

/// Defines methods that read one little-endian number each.
macro_rules! numbers {
    ($($name:ident $kind:ty),*) => {$(
        #[doc = concat!("The next little-endian `", stringify!($kind), "`.")]
        #[inline]
        pub fn $name(&mut self) -> Option<$kind> {
            self.array().map(<$kind>::from_le_bytes)
        }
    )*};
}

impl<'a> Bytes<'a> {
    /// A cursor at the start of a file.
    pub fn new(bytes: &'a [u8]) -> Bytes<'a> {
        Bytes {
            bytes,
            start: 0,
            at: 0,
        }
    }

    /// Offset of the next byte in the file.
    pub fn offset(&self) -> u64 {
        (self.start + self.at) as u64
    }

    /// Number of bytes left.
    pub fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// The next `count` bytes.
    #[inline]
    pub fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let end = self.at.checked_add(count)?;
        let taken = self.bytes.get(self.at..end)?;
        self.at = end;
        Some(taken)
    }

    /// The next `count` bytes as a separate cursor.
    pub fn piece(&mut self, count: usize) -> Option<Bytes<'a>> {
        let start = self.start + self.at;
        let bytes = self.take(count)?;
        Some(Bytes {
            bytes,
            start,
            at: 0,
        })
    }

    /// Skips `count` bytes.
    pub fn skip(&mut self, count: usize) -> Option<()> {
        self.take(count).map(|_| ())
    }

    #[inline]
    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }

    numbers!(u8_le u8, u16_le u16, i16_le i16, u32_le u32, f32_le f32);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_stay_inside() {
        let mut bytes = Bytes::new(&[1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(bytes.u16_le(), Some(0x0201));
        let mut piece = bytes.piece(3).unwrap();
        assert_eq!((piece.offset(), piece.u16_le()), (2, Some(0x0403)));
        assert_eq!((piece.u32_le(), piece.left(), piece.offset()), (None, 1, 4));
        assert_eq!((bytes.offset(), bytes.u8_le()), (5, Some(6)));
        assert!(bytes.skip(2).is_none() && bytes.take(usize::MAX).is_none());
        assert_eq!(bytes.left(), 1);
    }
}
