//! Reads numbers from buffers.

use super::buffers::Buffers;
use super::draco::{DracoAccessors, DracoElements};
use gltf_json::accessor::sparse::Sparse;
use gltf_json::accessor::{Accessor, ComponentType, Type};
use gltf_json::buffer::View;
use gltf_json::validation::Checked;
use gltf_json::{Index, Root};

/// The data that accessors read from. Faults are strings, because they affect only a part of the
/// file, and the reader of that part decides what to do.
#[derive(Debug)]
pub(super) struct Data<'a> {
    /// The JSON document.
    pub root: &'a Root,
    /// Its buffers.
    pub buffers: Buffers<'a>,
    /// Accessors whose data are compressed together with the rest of their primitive.
    pub draco: DracoAccessors,
}

/// Elements of one accessor, or the values of a sparse one: each begins `stride` bytes after
/// the previous one.
#[derive(Clone, Copy)]
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    count: usize,
}

impl<'a> Elements<'a> {
    /// Checks that all elements lie within the bytes.
    fn new(
        view: &'a [u8],
        offset: u64,
        stride: Option<usize>,
        size: usize,
        count: usize,
    ) -> Result<Elements<'a>, String> {
        let stride = stride.unwrap_or(size);
        if stride < size {
            return Err(format!("elements of {size} bytes every {stride} bytes"));
        }
        let length = match count {
            0 => Some(0),
            _ => stride
                .checked_mul(count - 1)
                .and_then(|l| l.checked_add(size)),
        };
        let start = usize::try_from(offset).ok();
        let end = start.zip(length).and_then(|(s, l)| s.checked_add(l));
        let bytes = start.zip(end).and_then(|(s, e)| view.get(s..e));
        let bytes = bytes.ok_or_else(|| {
            format!(
                "{count} elements reach beyond the {} bytes of their view",
                view.len()
            )
        })?;
        Ok(Elements {
            bytes,
            stride,
            size,
            count,
        })
    }

    /// The decoded elements of a compressed accessor, which must have this number of components.
    fn of_draco(decoded: &'a DracoElements, components: usize) -> Result<Elements<'a>, String> {
        if decoded.width != components {
            let width = decoded.width;
            return Err(format!("{width} components per element in its Draco data"));
        }
        let size = components * size_of(decoded.kind);
        Elements::new(&decoded.bytes, 0, None, size, decoded.count)
    }

    /// The elements' bytes.
    fn iter(self) -> impl Iterator<Item = &'a [u8]> {
        (0..self.count).map(move |i| &self.bytes[i * self.stride..][..self.size])
    }

    /// Converts the numbers of every element, which are `S` bytes each.
    fn numbers<const S: usize, const N: usize, T>(
        self,
        number: impl Fn([u8; S]) -> f64,
        make: &impl Fn([f64; N]) -> T,
    ) -> Vec<T> {
        let element = |bytes: &[u8]| {
            let (parts, _) = bytes.as_chunks::<S>();
            make(std::array::from_fn(|k| number(parts[k])))
        };
        self.iter().map(element).collect()
    }

    /// Like [`Elements::numbers`], for components of any type. Normalized integers are divided by
    /// the largest value of their type.
    fn decoded<const N: usize, T>(
        self,
        kind: ComponentType,
        normalized: bool,
        make: &impl Fn([f64; N]) -> T,
    ) -> Vec<T> {
        use ComponentType::{F32, I8, I16, U8, U16, U32};
        let share = |value: f64, most: f64| if normalized { value / most } else { value };
        let signed = |value: f64, most: f64| {
            if normalized {
                (value / most).max(-1.0)
            } else {
                value
            }
        };
        match kind {
            F32 => self.numbers(|b| f32::from_le_bytes(b).into(), make),
            U8 => self.numbers(|[b]| share(b.into(), 255.0), make),
            U16 => self.numbers(|b| share(u16::from_le_bytes(b).into(), 65535.0), make),
            U32 => self.numbers(|b| share(u32::from_le_bytes(b).into(), 4294967295.0), make),
            I8 => self.numbers(|b| signed(i8::from_le_bytes(b).into(), 127.0), make),
            I16 => self.numbers(|b| signed(i16::from_le_bytes(b).into(), 32767.0), make),
        }
    }

    /// Unsigned integers.
    fn indices(self, kind: ComponentType) -> Result<Vec<u32>, String> {
        fn each<const S: usize>(e: Elements, number: impl Fn([u8; S]) -> u32) -> Vec<u32> {
            let elements = e.iter().filter_map(<[u8]>::first_chunk);
            elements.map(|b| number(*b)).collect()
        }
        match kind {
            ComponentType::U8 => Ok(each(self, |[b]| b.into())),
            ComponentType::U16 => Ok(each(self, |b| u16::from_le_bytes(b).into())),
            ComponentType::U32 => Ok(each(self, u32::from_le_bytes)),
            _ => Err("indices that are not integers".to_owned()),
        }
    }
}

/// Bytes of an element whose components have `size` bytes each. Columns of matrices begin at multiples
/// of 4 bytes (glTF 2.0, 3.6.2.4).
fn element_size(kind: Type, size: usize) -> usize {
    match kind {
        Type::Scalar => size,
        Type::Vec2 => 2 * size,
        Type::Vec3 => 3 * size,
        Type::Vec4 => 4 * size,
        Type::Mat2 => 2 * (2 * size).next_multiple_of(4),
        Type::Mat3 => 3 * (3 * size).next_multiple_of(4),
        Type::Mat4 => 4 * (4 * size).next_multiple_of(4),
    }
}

fn size_of(kind: ComponentType) -> usize {
    match kind {
        ComponentType::I8 | ComponentType::U8 => 1,
        ComponentType::I16 | ComponentType::U16 => 2,
        ComponentType::U32 | ComponentType::F32 => 4,
    }
}

fn valid<T: Copy>(checked: &Checked<T>) -> Result<T, String> {
    match checked {
        Checked::Valid(value) => Ok(*value),
        Checked::Invalid => Err("an accessor of an unknown type".to_owned()),
    }
}

/// Elements that an accessor without bytes may always have.
const MOST_ZEROS: usize = 1 << 16;

impl Data<'_> {
    fn accessor(&self, index: Index<Accessor>) -> Result<&Accessor, String> {
        let accessor = self.root.get(index);
        accessor.ok_or_else(|| format!("accessor {index} does not exist"))
    }

    /// The number of elements of an accessor according to the JSON; they may not exist. Those of
    /// compressed primitives do.
    pub fn count(&self, index: Index<Accessor>) -> Result<usize, String> {
        if let Some(decoded) = self.draco.get(index)? {
            return Ok(decoded.count);
        }
        let accessor = self.accessor(index)?;
        let count = accessor.count.0;
        // Zeros, or few values among zeros: in no bytes there may be a billion.
        let most = (MOST_ZEROS + self.buffers.size()) as u64;
        let fits = accessor.buffer_view.is_some() || count <= most;
        let count = usize::try_from(count).ok().filter(|_| fits);
        count.ok_or_else(|| {
            let count = accessor.count.0;
            format!("accessor {index} has {count} elements, of which the file has no bytes")
        })
    }

    /// Number of components of each element of an accessor.
    pub fn width(&self, index: Index<Accessor>) -> Result<usize, String> {
        Ok(match valid(&self.accessor(index)?.type_)? {
            Type::Scalar => 1,
            Type::Vec2 => 2,
            Type::Vec3 => 3,
            Type::Vec4 | Type::Mat2 => 4,
            Type::Mat3 => 9,
            Type::Mat4 => 16,
        })
    }

    /// Converts each of the `count` elements of an accessor. The caller has
    /// justified their number: a sparse accessor may have a billion elements in no bytes.
    ///
    /// # Errors
    /// The reason, for another number of elements or another type than requested, and for elements
    /// that lie outside the buffer.
    pub fn read<const N: usize, T: Clone>(
        &self,
        index: Index<Accessor>,
        count: usize,
        make: impl Fn([f64; N]) -> T,
    ) -> Result<Vec<T>, String> {
        let accessor = self.accessor(index)?;
        if self.width(index)? != N {
            return Err(format!(
                "accessor {index} does not have {N} components per element"
            ));
        }
        self.expect_count(index, count)?;
        let (kind, normalized) = (valid(&accessor.component_type)?.0, accessor.normalized);
        let named = |fault| format!("accessor {index}: {fault}");
        let mut values = match (accessor.buffer_view, self.draco.get(index)?) {
            (Some(view), _) => {
                let offset = accessor.byte_offset.unwrap_or_default().0;
                let elements = self.elements(view, offset, N * size_of(kind), count);
                elements.map_err(named)?.decoded(kind, normalized, &make)
            }
            (None, Some(decoded)) => {
                let elements = Elements::of_draco(decoded, N).map_err(named)?;
                elements.decoded(decoded.kind, normalized, &make)
            }
            (None, None) => vec![make([0.0; N]); count],
        };
        if let Some(sparse) = &accessor.sparse {
            let changed = self.sparse(sparse, kind, normalized, count, &make);
            for (i, value) in changed.map_err(named)? {
                let slot = values.get_mut(i as usize);
                *slot.ok_or_else(|| named("a sparse index out of range".into()))? = value;
            }
        }
        Ok(values)
    }

    /// The bytes of all elements of an accessor as they are stored, one after another. For a compressed one
    /// the type of their components comes with them.
    ///
    /// # Errors
    /// As [`Data::read`].
    pub fn raw(
        &self,
        index: Index<Accessor>,
        count: usize,
    ) -> Result<(Vec<u8>, ComponentType), String> {
        let accessor = self.accessor(index)?;
        self.expect_count(index, count)?;
        let kind = valid(&accessor.component_type)?.0;
        let size = element_size(valid(&accessor.type_)?, size_of(kind));
        let named = |fault| format!("accessor {index}: {fault}");
        let elements = match (accessor.buffer_view, self.draco.get(index)?) {
            (Some(view), _) => {
                let offset = accessor.byte_offset.unwrap_or_default().0;
                Some(self.elements(view, offset, size, count).map_err(named)?)
            }
            (None, Some(decoded)) => {
                let elements = Elements::of_draco(decoded, self.width(index)?).map_err(named)?;
                return Ok((elements.iter().flatten().copied().collect(), decoded.kind));
            }
            (None, None) => None,
        };
        let total = count.checked_mul(size).ok_or("too many elements")?;
        let mut bytes = match elements {
            Some(elements) => elements.iter().flatten().copied().collect(),
            None => vec![0; total],
        };
        if let Some(sparse) = &accessor.sparse {
            for (i, value) in self.raw_sparse(sparse, size, count).map_err(named)? {
                let slot = bytes.chunks_exact_mut(size).nth(i as usize);
                let slot = slot.ok_or_else(|| named("a sparse index out of range".into()))?;
                slot.copy_from_slice(value);
            }
        }
        Ok((bytes, kind))
    }

    /// The elements that a sparse accessor replaces as they are stored, with their indices.
    fn raw_sparse(
        &self,
        sparse: &Sparse,
        size: usize,
        most: usize,
    ) -> Result<impl Iterator<Item = (u32, &[u8])>, String> {
        let (indices, count) = self.sparse_indices(sparse, most)?;
        let stored = &sparse.values;
        let values = self.elements(stored.buffer_view, stored.byte_offset.0, size, count)?;
        Ok(indices.into_iter().zip(values.iter()))
    }

    fn expect_count(&self, index: Index<Accessor>, expected: usize) -> Result<(), String> {
        match self.count(index)? {
            count if count == expected => Ok(()),
            count => Err(format!(
                "accessor {index} has {count} elements, where {expected} are needed"
            )),
        }
    }

    /// The `count` elements of an accessor of vertex indices.
    ///
    /// # Errors
    /// As [`Data::read`].
    pub fn indices(&self, index: Index<Accessor>, count: usize) -> Result<Vec<u32>, String> {
        let accessor = self.accessor(index)?;
        let kind = valid(&accessor.component_type)?.0;
        if accessor.sparse.is_some() || self.width(index)? != 1 {
            // Sparse indices do not occur in practice; reading them as floating point is exact, too.
            return self.read(index, count, |[i]| i as u32);
        }
        self.expect_count(index, count)?;
        if let Some(decoded) = self.draco.get(index)? {
            return Elements::of_draco(decoded, 1)?.indices(decoded.kind);
        }
        let view = accessor.buffer_view;
        let view = view.ok_or_else(|| format!("accessor {index} has no buffer view"))?;
        let offset = accessor.byte_offset.unwrap_or_default().0;
        let elements = self.elements(view, offset, size_of(kind), count);
        let indices = elements.and_then(|e| e.indices(kind));
        indices.map_err(|fault| format!("accessor {index}: {fault}"))
    }

    fn elements(
        &self,
        view: Index<View>,
        offset: u64,
        size: usize,
        count: usize,
    ) -> Result<Elements<'_>, String> {
        let bytes = self.buffers.view(view)?;
        let stride = self.root.get(view).and_then(|v| v.byte_stride);
        // Some writers store 0 for "tightly packed".
        let stride = stride.map(|s| s.0).filter(|s| *s > 0);
        Elements::new(bytes, offset, stride, size, count)
    }

    /// The elements that a sparse accessor replaces, with their indices.
    fn sparse<const N: usize, T>(
        &self,
        sparse: &Sparse,
        kind: ComponentType,
        normalized: bool,
        most: usize,
        make: &impl Fn([f64; N]) -> T,
    ) -> Result<impl Iterator<Item = (u32, T)>, String> {
        let (indices, count) = self.sparse_indices(sparse, most)?;
        let stored = &sparse.values;
        let size = N * size_of(kind);
        let values = self.elements(stored.buffer_view, stored.byte_offset.0, size, count)?;
        let values = values.decoded(kind, normalized, make);
        Ok(indices.into_iter().zip(values))
    }

    /// Which elements a sparse accessor replaces, at most `most`, and their number.
    fn sparse_indices(&self, sparse: &Sparse, most: usize) -> Result<(Vec<u32>, usize), String> {
        let count = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
        if count > most {
            return Err("more sparse values than elements".to_owned());
        }
        let stored = &sparse.indices;
        let kind = valid(&stored.component_type)?.0;
        let indices = self.elements(
            stored.buffer_view,
            stored.byte_offset.0,
            size_of(kind),
            count,
        )?;
        Ok((indices.indices(kind)?, count))
    }
}
