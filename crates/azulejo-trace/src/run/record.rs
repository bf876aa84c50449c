//! Items as bytes.

use crate::gather::{Gathered, Harmonics, REPLICATES};
use azulejo_scene::Rgb;
use azulejo_scene::harmonics::HARMONICS;

/// An item of a block that can be stored.
pub trait Record: Sized {
    /// Appends the item's bytes.
    fn write(&self, bytes: &mut Vec<u8>);

    /// The inverse of `write`; `None` if the bytes are invalid.
    fn read(bytes: &mut RecordReader) -> Option<Self>;

    /// Whether it is complete; blocks with incomplete items are not stored.
    fn is_complete(&self) -> bool {
        true
    }
}

/// Records of numbers, by their bytes in little-endian order.
macro_rules! record_numbers {
    ($($type:ident)+) => {
        $(impl Record for $type {
            fn write(&self, bytes: &mut Vec<u8>) {
                bytes.extend(self.to_le_bytes());
            }

            fn read(bytes: &mut RecordReader) -> Option<$type> {
                bytes.array().map($type::from_le_bytes)
            }
        })+
    };
}

record_numbers! { u8 u32 u64 f32 f64 }

impl Record for Rgb {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.to_array().iter().for_each(|x| x.write(bytes));
    }

    fn read(bytes: &mut RecordReader) -> Option<Rgb> {
        Some(Rgb::new(bytes.f64()?, bytes.f64()?, bytes.f64()?))
    }
}

impl<R: Record + Copy + Default, const N: usize> Record for [R; N] {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.iter().for_each(|item| item.write(bytes));
    }

    fn read(bytes: &mut RecordReader) -> Option<[R; N]> {
        let mut items = [R::default(); N];
        for item in &mut items {
            *item = R::read(bytes)?;
        }
        Some(items)
    }
}

impl<R: Record> Record for Vec<R> {
    fn write(&self, bytes: &mut Vec<u8>) {
        write_list(self, bytes, R::write);
    }

    fn read(bytes: &mut RecordReader) -> Option<Vec<R>> {
        bytes.list(R::read)
    }

    fn is_complete(&self) -> bool {
        self.iter().all(R::is_complete)
    }
}

impl Record for Gathered {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.replicates.write(bytes);
    }

    fn read(bytes: &mut RecordReader) -> Option<Gathered> {
        let replicates = <[Rgb; REPLICATES]>::read(bytes)?;
        Some(Gathered { replicates })
    }
}

impl Record for Harmonics {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.coefficients.write(bytes);
    }

    fn read(bytes: &mut RecordReader) -> Option<Harmonics> {
        let coefficients = <[Gathered; HARMONICS]>::read(bytes)?;
        Some(Harmonics { coefficients })
    }
}

/// Nothing is incomplete: time was over.
impl<R: Record> Record for Option<R> {
    fn write(&self, bytes: &mut Vec<u8>) {
        u8::from(self.is_some()).write(bytes);
        self.iter().for_each(|item| item.write(bytes));
    }

    fn read(bytes: &mut RecordReader) -> Option<Option<R>> {
        match u8::read(bytes)? {
            0 => Some(None),
            1 => R::read(bytes).map(Some),
            _ => None,
        }
    }

    fn is_complete(&self) -> bool {
        self.as_ref().is_some_and(R::is_complete)
    }
}

impl<A: Record, B: Record> Record for (A, B) {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.0.write(bytes);
        self.1.write(bytes);
    }

    fn read(bytes: &mut RecordReader) -> Option<(A, B)> {
        Some((A::read(bytes)?, B::read(bytes)?))
    }

    fn is_complete(&self) -> bool {
        self.0.is_complete() && self.1.is_complete()
    }
}

/// Reads numbers from the front of a byte slice.
pub struct RecordReader<'a> {
    pub(super) bytes: &'a [u8],
}

impl<'a> RecordReader<'a> {
    /// From the beginning of `bytes`.
    pub fn new(bytes: &'a [u8]) -> RecordReader<'a> {
        RecordReader { bytes }
    }

    /// What was not read yet.
    pub fn rest(&self) -> &'a [u8] {
        self.bytes
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.bytes.split_first_chunk()?;
        self.bytes = rest;
        Some(*first)
    }

    /// Four bytes, little-endian.
    pub fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    /// Eight bytes, little-endian.
    pub fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    /// A number of single precision.
    pub fn f32(&mut self) -> Option<f32> {
        self.array().map(f32::from_le_bytes)
    }

    /// A number of double precision.
    pub fn f64(&mut self) -> Option<f64> {
        self.array().map(f64::from_le_bytes)
    }

    /// A list written by [`write_list`]; `None`, before anything is allocated, for a count that the
    /// bytes cannot hold.
    pub fn list<T>(&mut self, read: impl Fn(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        let count = self.u32()? as usize;
        if count > self.bytes.len() {
            return None;
        }
        (0..count).map(|_| read(self)).collect()
    }
}

/// Appends a count and then each item by `write`.
pub fn write_list<T>(items: &[T], bytes: &mut Vec<u8>, write: impl Fn(&T, &mut Vec<u8>)) {
    bytes.extend((items.len() as u32).to_le_bytes());
    items.iter().for_each(|item| write(item, bytes));
}
