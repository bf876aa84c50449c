//! Lists of labels, faces and points, in text and in binary.

use super::cursor::{FoamCursor, FoamHeader};
use crate::ReadError;
use glam::DVec3;

/// A list of whole numbers.
enum LabelList<'a> {
    Text(Vec<u64>),
    Raw(&'a [u8], FoamHeader),
    /// `3{7}`: equal numbers, of which there may be more than the file has bytes.
    Uniform(u64, u64),
}

impl<'a> LabelList<'a> {
    fn read(cursor: &mut FoamCursor<'a>, header: &FoamHeader) -> Result<LabelList<'a>, ReadError> {
        let count = cursor.label()?;
        if cursor.pass(b'{') {
            let value = cursor.label()?;
            cursor.expect(b'}')?;
            return Ok(LabelList::Uniform(count, value));
        }
        if header.is_binary {
            let bytes = cursor.raw(count, header.label)?;
            return Ok(LabelList::Raw(bytes, header.clone()));
        }
        let mut labels = Vec::new();
        cursor.expect(b'(')?;
        for _ in 0..count {
            labels.push(cursor.label()?);
        }
        cursor.expect(b')')?;
        Ok(LabelList::Text(labels))
    }

    fn len(&self) -> u64 {
        match self {
            LabelList::Text(labels) => labels.len() as u64,
            LabelList::Raw(bytes, header) => (bytes.len() / header.label) as u64,
            LabelList::Uniform(count, _) => *count,
        }
    }

    /// The label of an index; `None` if it is negative or there is none.
    fn get(&self, index: u64) -> Option<u64> {
        let at = usize::try_from(index).ok()?;
        match self {
            LabelList::Text(labels) => labels.get(at).copied(),
            LabelList::Raw(bytes, header) => header.label_at(bytes, at),
            LabelList::Uniform(count, value) => (index < *count).then_some(*value),
        }
    }
}

impl FoamHeader {
    /// A binary label of some bytes; `None` if it is negative.
    fn label_at(&self, bytes: &[u8], index: usize) -> Option<u64> {
        let start = index.checked_mul(self.label)?;
        let bytes = bytes.get(start..start.checked_add(self.label)?)?;
        let value = match (self.label, self.is_big) {
            (4, false) => i64::from(i32::from_le_bytes(bytes.try_into().ok()?)),
            (4, true) => i64::from(i32::from_be_bytes(bytes.try_into().ok()?)),
            (_, false) => i64::from_le_bytes(bytes.try_into().ok()?),
            (_, true) => i64::from_be_bytes(bytes.try_into().ok()?),
        };
        u64::try_from(value).ok()
    }

    /// The binary real number that some bytes are.
    fn scalar_of(&self, bytes: &[u8]) -> f64 {
        match (bytes, self.is_big) {
            (&[a, b, c, d], false) => f32::from_le_bytes([a, b, c, d]).into(),
            (&[a, b, c, d], true) => f32::from_be_bytes([a, b, c, d]).into(),
            (bytes, is_big) => {
                let word = bytes.try_into().unwrap_or_default();
                if is_big {
                    f64::from_be_bytes(word)
                } else {
                    f64::from_le_bytes(word)
                }
            }
        }
    }
}

/// Reads all points.
pub(super) fn points(
    cursor: &mut FoamCursor,
    header: &FoamHeader,
) -> Result<Vec<DVec3>, ReadError> {
    let count = cursor.label()?;
    let mut points = Vec::new();
    if header.is_binary {
        let bytes = cursor.raw(count, 3 * header.scalar)?;
        for point in bytes.chunks_exact(3 * header.scalar) {
            let mut axes = point
                .chunks_exact(header.scalar)
                .map(|b| header.scalar_of(b));
            let mut next = || axes.next().unwrap_or(f64::NAN);
            points.push(DVec3::new(next(), next(), next()));
        }
        return Ok(points);
    }
    cursor.expect(b'(')?;
    for _ in 0..count {
        cursor.expect(b'(')?;
        points.push(DVec3::new(
            cursor.scalar()?,
            cursor.scalar()?,
            cursor.scalar()?,
        ));
        cursor.expect(b')')?;
    }
    cursor.expect(b')')?;
    Ok(points)
}

/// Reads faces and gives those from number `first` on to `each`, with their numbers; returns how many faces
/// there are.
pub(super) fn faces(
    cursor: &mut FoamCursor,
    header: &FoamHeader,
    first: u64,
    each: &mut dyn FnMut(u64, &[u32]),
) -> Result<u64, ReadError> {
    if header.class == "faceCompactList" {
        return compact_faces(cursor, header, first, each);
    }
    let count = cursor.label()?;
    let mut corners = Vec::new();
    if count == 0 {
        return Ok(0);
    }
    cursor.expect(b'(')?;
    for face in 0..count {
        corners.clear();
        let of_face = cursor.label()?;
        if header.is_binary {
            let bytes = cursor.raw(of_face, header.label)?;
            let labels = (0..bytes.len() / header.label).map(|k| header.label_at(bytes, k));
            corners.extend(labels.map(corner));
        } else {
            cursor.expect(b'(')?;
            for _ in 0..of_face {
                corners.push(corner(Some(cursor.label()?)));
            }
            cursor.expect(b')')?;
        }
        if face >= first {
            each(face, &corners);
        }
    }
    cursor.expect(b')')?;
    Ok(count)
}

/// Faces as the labels of all of them, and where those of each begin.
fn compact_faces(
    cursor: &mut FoamCursor,
    header: &FoamHeader,
    first: u64,
    each: &mut dyn FnMut(u64, &[u32]),
) -> Result<u64, ReadError> {
    let starts = LabelList::read(cursor, header)?;
    let at = cursor.text.offset();
    let labels = LabelList::read(cursor, header)?;
    let count = starts.len().saturating_sub(1);
    if matches!(starts, LabelList::Uniform(..)) && count > 0 {
        let found = "faces without a corner";
        return Err(cursor.error(at, found, "where the corners of each face begin"));
    }
    let mut corners = Vec::new();
    for face in first..count {
        corners.clear();
        let ends = starts.get(face).zip(starts.get(face + 1));
        let ends = ends.filter(|(start, end)| start <= end && *end <= labels.len());
        let Some((start, end)) = ends else {
            let found = format!("face {face}, whose corners are not among the labels");
            let expected = format!("{} labels, in ascending order", labels.len());
            return Err(cursor.error(at, found, expected));
        };
        // Equal labels without end are not corners; ascending, the others are each in one face.
        if matches!(labels, LabelList::Uniform(..)) {
            continue;
        }
        corners.extend((start..end).map(|k| corner(labels.get(k))));
        each(face, &corners);
    }
    Ok(count)
}

/// A label as the index of a point, one that does not exist if it is none.
fn corner(label: Option<u64>) -> u32 {
    label
        .and_then(|l| u32::try_from(l).ok())
        .unwrap_or(u32::MAX)
}
