//! The container of the RGL database: named tensors.

use crate::ReadError;
use crate::reading::bytes::Bytes;

/// The magic number of such a file.
pub(super) const MAGIC: &[u8; 12] = b"tensor_file\0";

/// The supported version.
const VERSION: [u8; 2] = [1, 0];

/// A tensor of the file: the location of its data is checked, their values are not.
pub(super) struct Tensor<'a> {
    pub shape: Vec<usize>,
    pub kind: ElementType,
    pub data: &'a [u8],
    /// Offset of its data in the file.
    pub offset: u64,
}

/// The type of a tensor's elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ElementType {
    Byte,
    Float,
    Double,
    /// Any other type, by its size.
    Other(usize),
}

impl ElementType {
    fn of(code: u8) -> Option<ElementType> {
        match code {
            1 => Some(ElementType::Byte),
            2 => Some(ElementType::Other(1)),
            3 | 4 | 9 => Some(ElementType::Other(2)),
            5 | 6 => Some(ElementType::Other(4)),
            7 | 8 => Some(ElementType::Other(8)),
            10 => Some(ElementType::Float),
            11 => Some(ElementType::Double),
            _ => None,
        }
    }

    fn size(self) -> usize {
        match self {
            ElementType::Byte => 1,
            ElementType::Float => 4,
            ElementType::Double => 8,
            ElementType::Other(size) => size,
        }
    }
}

/// More dimensions than any tensor here has.
const DIMENSIONS: u16 = 8;

/// The names and tensors of a file, in its order.
pub(super) fn read<'a>(
    bytes: &'a [u8],
    name: &str,
) -> Result<Vec<(String, Tensor<'a>)>, ReadError> {
    let mut head = Bytes::new(bytes);
    let mut tensors = Vec::new();
    let begins = head.take(MAGIC.len()) == Some(MAGIC) && head.take(2) == Some(&VERSION);
    if !begins {
        let expected = "a tensor file of version 1.0";
        return Err(ReadError::at_byte(name, 0, "other bytes", expected));
    }
    let count = head.u32_le().ok_or_else(|| ended(&head, name))?;
    for _ in 0..count {
        tensors.push(field(&mut head, bytes, name)?);
    }
    Ok(tensors)
}

fn ended(head: &Bytes, name: &str) -> ReadError {
    let place = head.offset() + head.left() as u64;
    ReadError::at_byte(
        name,
        place,
        "the end of the file",
        "the rest of the list of tensors",
    )
}

fn u64_le(head: &mut Bytes) -> Option<u64> {
    let low = u64::from(head.u32_le()?);
    Some(low | u64::from(head.u32_le()?) << 32)
}

fn field<'a>(
    head: &mut Bytes<'a>,
    bytes: &'a [u8],
    file: &str,
) -> Result<(String, Tensor<'a>), ReadError> {
    let place = head.offset();
    let length = head.u16_le().ok_or_else(|| ended(head, file))?;
    let name = head.take(length.into()).ok_or_else(|| ended(head, file))?;
    let name = String::from_utf8_lossy(name).into_owned();
    let wrong = |found: String, expected: &str| ReadError::at_byte(file, place, found, expected);

    let dimensions = head.u16_le().ok_or_else(|| ended(head, file))?;
    let code = head.u8_le().ok_or_else(|| ended(head, file))?;
    let offset = u64_le(head).ok_or_else(|| ended(head, file))?;
    if dimensions > DIMENSIONS {
        let found = format!("a tensor `{name}` of {dimensions} dimensions");
        return Err(wrong(found, "8 at most"));
    }
    let kind = ElementType::of(code).ok_or_else(|| {
        let found = format!("type {code} of the elements of `{name}`");
        wrong(found, "a number from 1 to 11")
    })?;
    let mut shape = Vec::new();
    for _ in 0..dimensions {
        let size = u64_le(head).ok_or_else(|| ended(head, file))?;
        shape.push(usize::try_from(size).unwrap_or(usize::MAX));
    }
    let data = data(bytes, offset, &shape, kind).ok_or_else(|| {
        let found = format!("a tensor `{name}` with {shape:?} elements starting at byte {offset}");
        wrong(found, "one that ends before the file")
    })?;
    let tensor = Tensor {
        shape,
        kind,
        data,
        offset,
    };
    Ok((name, tensor))
}

fn data<'a>(bytes: &'a [u8], offset: u64, shape: &[usize], kind: ElementType) -> Option<&'a [u8]> {
    let mut size = kind.size();
    for n in shape {
        size = size.checked_mul(*n)?;
    }
    let start = usize::try_from(offset).ok()?;
    bytes.get(start..start.checked_add(size)?)
}

impl Tensor<'_> {
    /// Its elements, if they are floating-point numbers.
    pub fn floats(&self) -> Option<Vec<f32>> {
        match self.kind {
            ElementType::Float => {
                let floats = self.data.as_chunks::<4>().0.iter();
                Some(floats.map(|b| f32::from_le_bytes(*b)).collect())
            }
            ElementType::Double => {
                let doubles = self.data.as_chunks::<8>().0.iter();
                Some(doubles.map(|b| f64::from_le_bytes(*b) as f32).collect())
            }
            _ => None,
        }
    }
}
