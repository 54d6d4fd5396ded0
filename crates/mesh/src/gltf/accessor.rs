//! Accessors: numbers in buffers, of any type, dense or sparse.

use super::document::Accessor;
use super::{Buffer, GltfFile, element, malformed};
use crate::error::MeshProblem;
use crate::quote::quoted;
use crate::reading::Reading;

/// The type of an accessor's numbers.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number in the bytes, which are as many as its size.
    fn read(self, bytes: &[u8]) -> f64 {
        let word = bytes.iter().rev().fold(0, |high, &byte| high << 8 | u32::from(byte));
        let [low, next, ..] = word.to_le_bytes();
        match self {
            Self::I8 => f64::from(low.cast_signed()),
            Self::I16 => f64::from(i16::from_le_bytes([low, next])),
            Self::U8 | Self::U16 | Self::U32 => f64::from(word),
            Self::F32 => f64::from(f32::from_bits(word)),
        }
    }

    /// What the largest number stands for 1 in, where they are normalised.
    const fn largest(self) -> f64 {
        match self {
            Self::I8 => i8::MAX as f64,
            Self::U8 => u8::MAX as f64,
            Self::I16 => i16::MAX as f64,
            Self::U16 => u16::MAX as f64,
            Self::U32 => u32::MAX as f64,
            Self::F32 => 1.0,
        }
    }
}

/// What the specification, without extensions, lets an accessor be for a purpose.
pub(super) struct Rule {
    /// `SCALAR`, `VEC3` and so on.
    pub(super) kind: &'static str,
    /// The types of its numbers, and which of them are normalised.
    pub(super) components: &'static [(Component, bool)],
}

impl GltfFile {
    /// The items of an accessor, `N` numbers each; `place` stands for the element in messages. A type
    /// that the rule lacks is noted where no extension allows it: what it means is clear.
    pub(super) fn numbers<const N: usize>(
        &self,
        number: usize,
        rule: &Rule,
        place: &str,
        reading: &mut Reading,
    ) -> Result<Vec<[f64; N]>, MeshProblem> {
        let accessor = element(&self.document.accessors, number, "accessor", place)?;
        if accessor.kind != rule.kind {
            let what = format!("accessor {number} is {}, not {}", accessor.kind, rule.kind);
            return Err(malformed(place, what));
        }
        let component = component(accessor.component_type, place)?;
        let is_normalized = accessor.normalized && component != Component::F32;
        let quantization = "KHR_mesh_quantization";
        let is_declared = self.document.extensions_used.iter().any(|used| used == quantization);
        if !rule.components.contains(&(component, is_normalized)) && !is_declared {
            let what = "numbers of a type that only KHR_mesh_quantization allows";
            reading.tolerate(place, what)?;
        }
        let size = component.size();
        let bytes = self.items(number, accessor, component, N, place, reading)?;
        reading.claim((accessor.count as u64).saturating_mul(8 * N as u64))?;
        let scale = if is_normalized { component.largest() } else { 1.0 };
        let value = |item: &[u8], i: usize| {
            // The lowest of a signed type stands for −1 like the next.
            let value = component.read(&item[i * size..(i + 1) * size]) / scale;
            if is_normalized { value.max(-1.0) } else { value }
        };
        let items = bytes.chunks_exact(N * size);
        Ok(items.map(|item| std::array::from_fn(|i| value(item, i))).collect())
    }

    /// The whole numbers of an accessor of scalars.
    pub(super) fn whole(
        &self,
        number: usize,
        place: &str,
        reading: &mut Reading,
    ) -> Result<Vec<usize>, MeshProblem> {
        let accessor = element(&self.document.accessors, number, "accessor", place)?;
        let component = component(accessor.component_type, place)?;
        if accessor.kind != "SCALAR" || !is_index(component) {
            let what = format!("accessor {number} of indices is not of unsigned whole numbers");
            return Err(malformed(place, what));
        }
        let bytes = self.items(number, accessor, component, 1, place, reading)?;
        reading.claim((accessor.count as u64).saturating_mul(8))?;
        Ok(bytes.chunks_exact(component.size()).map(whole).collect())
    }

    /// The bytes of an accessor's items, one after another.
    fn items(
        &self,
        number: usize,
        accessor: &Accessor,
        component: Component,
        width: usize,
        place: &str,
        reading: &mut Reading,
    ) -> Result<Vec<u8>, MeshProblem> {
        let (count, size) = (accessor.count, component.size() * width);
        let name = format!("accessor {number}");
        reading.claim((count as u64).saturating_mul(size as u64))?;
        let mut bytes = match accessor.buffer_view {
            // Zeros. They are as many as the file says, so not more than it has bytes.
            None if count > self.size => {
                let what = format!("{name} has {count} items and no data");
                return Err(malformed(place, what));
            }
            None => vec![0; count * size],
            Some(view) => {
                let offset = accessor.byte_offset;
                let items =
                    self.strided(view, offset, component, size, count, &name, place, reading)?;
                items.flatten().copied().collect()
            }
        };
        if let Some(sparse) = &accessor.sparse {
            let index = component_of_index(sparse.indices.component_type, place)?;
            let (view, offset) = (sparse.indices.buffer_view, sparse.indices.byte_offset);
            let indices = self.strided(
                view,
                offset,
                index,
                index.size(),
                sparse.count,
                &name,
                place,
                reading,
            )?;
            let (view, offset) = (sparse.values.buffer_view, sparse.values.byte_offset);
            let values =
                self.strided(view, offset, component, size, sparse.count, &name, place, reading)?;
            for (index, value) in indices.map(whole).zip(values) {
                let item = index.checked_mul(size).and_then(|at| bytes.get_mut(at..at + size));
                let item = item.ok_or_else(|| {
                    malformed(place, format!("{name} replaces item {index}, it has {count}"))
                })?;
                item.copy_from_slice(value);
            }
        }
        Ok(bytes)
    }

    /// So many items of `size` bytes in a view, each a stride after the one before.
    #[allow(clippy::too_many_arguments, reason = "what the format says of where items are")]
    fn strided<'a>(
        &'a self,
        view: usize,
        offset: usize,
        component: Component,
        size: usize,
        count: usize,
        name: &str,
        place: &str,
        reading: &Reading,
    ) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>, MeshProblem> {
        let (data, start, stride) = self.view(view, place)?;
        let stride = stride.unwrap_or(size);
        let range = || {
            let data = data.get(offset..)?;
            let needed = match count {
                0 => 0,
                _ => stride.checked_mul(count - 1)?.checked_add(size)?,
            };
            (stride >= size && needed <= data.len()).then_some(data)
        };
        let data = range()
            .ok_or_else(|| malformed(place, format!("{name} reaches beyond its buffer view")))?;
        let unit = component.size();
        if !(start + offset).is_multiple_of(unit) || !stride.is_multiple_of(unit) {
            reading.tolerate(place, "numbers that are not aligned to their size")?;
        }
        Ok((0..count).map(move |i| &data[i * stride..i * stride + size]))
    }

    /// The bytes of a view, where they begin in their buffer, and its stride.
    pub(super) fn view(
        &self,
        number: usize,
        place: &str,
    ) -> Result<(&[u8], usize, Option<usize>), MeshProblem> {
        let view = element(&self.document.buffer_views, number, "bufferView", place)?;
        let data = match element(&self.buffers, view.buffer, "buffer", place)? {
            Buffer::Sound(data) => data,
            Buffer::Short(what) => return Err(MeshProblem::Truncated { what: what.clone() }),
            Buffer::Missing(what) => {
                let compression = view.extensions.keys().find(|name| name.contains("compression"));
                return Err(match compression {
                    None => MeshProblem::Missing { what: what.clone() },
                    Some(name) => MeshProblem::Unsupported {
                        what: format!("{place}: {} without uncompressed data is", quoted(name)),
                        mend: "export it without compression",
                    },
                });
            }
        };
        let start = view.byte_offset;
        let bytes = start.checked_add(view.byte_length).and_then(|end| data.get(start..end));
        let bytes = bytes.ok_or_else(|| {
            malformed(place, format!("bufferView {number} reaches beyond its buffer"))
        })?;
        Ok((bytes, start, view.byte_stride))
    }
}

fn component(code: u32, place: &str) -> Result<Component, MeshProblem> {
    Component::of(code).ok_or_else(|| malformed(place, format!("componentType {code} is none")))
}

fn component_of_index(code: u32, place: &str) -> Result<Component, MeshProblem> {
    let what = || malformed(place, format!("componentType {code} of sparse indices is none"));
    Component::of(code).filter(|component| is_index(*component)).ok_or_else(what)
}

fn is_index(component: Component) -> bool {
    matches!(component, Component::U8 | Component::U16 | Component::U32)
}

/// The unsigned number in the bytes.
fn whole(bytes: &[u8]) -> usize {
    bytes.iter().rev().fold(0, |high, &byte| high << 8 | usize::from(byte))
}
