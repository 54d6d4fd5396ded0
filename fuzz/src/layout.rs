//! Where a file holds text, numbers, lengths and encoded bytes, so that mutants are damaged where it counts
//! and whole elsewhere.
//!
//! Nothing here fails: a mutant is damaged again, and what cannot be made out is bytes.

use std::ops::Range;

use crate::format::Format;

/// Numbers side by side in a binary file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Numbers {
    pub(crate) range: Range<usize>,
    /// Bytes of each: 1, 2, 4 or 8.
    pub(crate) width: usize,
    pub(crate) big_endian: bool,
}

/// A length, and the bytes that it counts.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Length {
    pub(crate) number: Numbers,
    pub(crate) covers: Range<usize>,
}

/// What stands where.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Layout {
    pub(crate) text: Vec<Range<usize>>,
    pub(crate) numbers: Vec<Numbers>,
    pub(crate) lengths: Vec<Length>,
    /// Base64.
    pub(crate) encoded: Vec<Range<usize>>,
}

const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";

impl Numbers {
    fn one(at: usize, width: usize, big_endian: bool) -> Self {
        Self { range: at..at + width, width, big_endian }
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.range.len() / self.width
    }

    /// Where one of them stands.
    pub(crate) fn place(&self, number: usize) -> Range<usize> {
        let at = self.range.start + number * self.width;
        at..at + self.width
    }

    /// The lowest bytes of a value.
    pub(crate) fn bytes(&self, value: u64) -> Vec<u8> {
        let mut bytes = value.to_le_bytes()[..self.width].to_vec();
        if self.big_endian {
            bytes.reverse();
        }
        bytes
    }

    /// One of them; 0 where it lies beyond the end.
    pub(crate) fn read(&self, bytes: &[u8], number: usize) -> u64 {
        let bytes = bytes.get(self.place(number)).unwrap_or_default();
        let shift = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
        if self.big_endian {
            bytes.iter().fold(0, shift)
        } else {
            bytes.iter().rev().fold(0, shift)
        }
    }
}

impl Layout {
    pub(crate) fn of(format: Format, bytes: &[u8]) -> Self {
        let mut layout = Self::default();
        let all = 0..bytes.len();
        match format {
            Format::Ply => layout.ply(bytes),
            Format::Stl => layout.stl(bytes),
            Format::Glb => layout.glb(bytes),
            Format::Rays => layout.block(all, 4, false),
            Format::Png => layout.png(bytes, PNG.len()),
            Format::Jpeg => layout.jpeg(bytes),
            Format::Exr => {
                layout.block(all.clone(), 4, false);
                layout.block(all, 1, false);
            }
            Format::Obj
            | Format::Mtl
            | Format::Gltf
            | Format::Toml
            | Format::Csv
            | Format::Records => layout.text.push(all),
        }
        for range in layout.text.clone() {
            layout.encoded(bytes, range);
        }
        layout
    }

    /// Of bytes that a file embeds: a picture, or numbers of any kind.
    pub(crate) fn of_embedded(bytes: &[u8]) -> Self {
        if bytes.starts_with(PNG) {
            return Self::of(Format::Png, bytes);
        }
        if bytes.starts_with(b"\xff\xd8") {
            return Self::of(Format::Jpeg, bytes);
        }
        let mut layout = Self::default();
        for width in [4, 2, 1] {
            layout.block(0..bytes.len(), width, false);
        }
        layout
    }

    fn block(&mut self, range: Range<usize>, width: usize, big_endian: bool) {
        if range.len() >= width {
            self.numbers.push(Numbers { range, width, big_endian });
        }
    }

    /// A length, of what follows it at `from`; gives what that is.
    fn length(
        &mut self,
        bytes: &[u8],
        number: Numbers,
        from: usize,
        less: usize,
    ) -> Option<Range<usize>> {
        if number.range.end > bytes.len() {
            return None;
        }
        self.numbers.push(number.clone());
        let length = usize::try_from(number.read(bytes, 0)).ok()?.checked_sub(less)?;
        let covers = from..from.checked_add(length)?;
        if covers.end > bytes.len() {
            return None;
        }
        self.lengths.push(Length { number, covers: covers.clone() });
        Some(covers)
    }

    fn ply(&mut self, bytes: &[u8]) {
        let header = match find(bytes, b"end_header") {
            Some(at) => bytes[at..].iter().position(|&byte| byte == b'\n').map(|end| at + end + 1),
            None => None,
        };
        let is_text = find(bytes, b"format ascii").is_some();
        let header = header.filter(|_| !is_text).unwrap_or(bytes.len());
        self.text.push(0..header);
        let big_endian = find(&bytes[..header], b"big").is_some();
        for width in [1, 4, 8] {
            self.block(header..bytes.len(), width, big_endian);
        }
    }

    fn stl(&mut self, bytes: &[u8]) {
        const HEADER: usize = 80;
        const TRIANGLE: usize = 50;
        let triangles = bytes.len().saturating_sub(HEADER + 4) / TRIANGLE;
        let is_whole = triangles > 0 && bytes.len() == HEADER + 4 + triangles * TRIANGLE;
        if bytes.starts_with(b"solid") && !is_whole || bytes.len() < HEADER + 4 {
            self.text.push(0..bytes.len());
            return;
        }
        self.numbers.push(Numbers::one(HEADER, 4, false));
        for triangle in 0..triangles {
            let at = HEADER + 4 + triangle * TRIANGLE;
            self.block(at..at + 48, 4, false);
            self.block(at + 48..at + TRIANGLE, 2, false);
        }
    }

    fn glb(&mut self, bytes: &[u8]) {
        self.block(0..bytes.len().min(8), 4, false);
        let _ = self.length(bytes, Numbers::one(8, 4, false), 0, 0);
        let mut at = 12;
        while let Some(head) = bytes.get(at..at + 8) {
            self.block(at + 4..at + 8, 4, false);
            let Some(data) = self.length(bytes, Numbers::one(at, 4, false), at + 8, 0) else {
                break;
            };
            at = data.end;
            if head.ends_with(b"JSON") {
                self.text.push(data);
            } else {
                for width in [4, 2, 1] {
                    self.block(data.clone(), width, false);
                }
                if let Some(start) = find(&bytes[data.clone()], PNG) {
                    self.png(bytes, data.start + start + PNG.len());
                }
            }
        }
    }

    /// The chunks of a picture, from where the first begins.
    fn png(&mut self, bytes: &[u8], first: usize) {
        let mut at = first;
        while let Some(kind) = bytes.get(at + 4..at + 8) {
            self.block(at + 4..at + 8, 1, true);
            let Some(data) = self.length(bytes, Numbers::one(at, 4, true), at + 8, 0) else {
                break;
            };
            at = data.end + 4;
            if kind == b"IHDR" {
                self.block(data.start..data.end.min(data.start + 8), 4, true);
            }
            self.block(data, 1, true);
            if kind == b"IEND" {
                break;
            }
        }
    }

    fn jpeg(&mut self, bytes: &[u8]) {
        let mut at = 2;
        while let Some(&[0xff, kind]) = bytes.get(at..at + 2) {
            self.block(at + 1..at + 2, 1, true);
            at += 2;
            // These stand alone.
            if matches!(kind, 0x01 | 0xd0..=0xd9) {
                continue;
            }
            let Some(data) = self.length(bytes, Numbers::one(at, 2, true), at + 2, 2) else {
                break;
            };
            at = data.end;
            let is_frame = matches!(kind, 0xc0..=0xcf) && !matches!(kind, 0xc4 | 0xc8 | 0xcc);
            if is_frame && data.len() > 5 {
                self.block(data.start + 1..data.start + 5, 2, true);
            }
            self.block(data, 1, true);
            if kind == 0xda {
                let rest = &bytes[at..];
                let end = rest
                    .windows(2)
                    .position(|two| two[0] == 0xff && !matches!(two[1], 0x00 | 0xd0..=0xd7));
                let end = at + end.unwrap_or(rest.len());
                self.block(at..end, 1, true);
                at = end;
            }
        }
    }

    fn encoded(&mut self, bytes: &[u8], range: Range<usize>) {
        for mark in [b"base64,".as_slice(), b"\"png\":\""] {
            let mut at = range.start;
            while let Some(found) = find(&bytes[at..range.end], mark) {
                let start = at + found + mark.len();
                let rest = &bytes[start..range.end];
                let end = rest.iter().position(|&byte| byte == b'"').unwrap_or(rest.len());
                at = start + end;
                self.encoded.push(start..at);
            }
        }
    }
}

/// Where a word begins.
pub(crate) fn find(bytes: &[u8], word: &[u8]) -> Option<usize> {
    bytes.windows(word.len()).position(|window| window == word)
}

/// Makes the checksums of a PNG right again, so that its damage is not all that a reader sees of it.
pub fn seal(bytes: &mut [u8]) {
    let Some(start) = find(bytes, PNG) else { return };
    let mut layout = Layout::default();
    layout.png(bytes, start + PNG.len());
    for Length { covers: Range { start, end }, .. } in layout.lengths {
        let sum = crc32fast::hash(&bytes[start - 4..end]);
        if let Some(place) = bytes.get_mut(end..end + 4) {
            place.copy_from_slice(&sum.to_be_bytes());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::{corpus, files};

    #[test]
    fn every_seed_has_what_its_format_has() {
        for format in Format::ALL {
            let seeds = files(&corpus().join(format.name())).expect("the corpus is there");
            assert!(seeds.len() > 1 || format == Format::Exr, "{format:?}");
            for (path, bytes) in seeds {
                let layout = Layout::of(format, &bytes);
                let found = layout.text.len() + layout.numbers.len();
                assert!(found > 0, "{}", path.display());
                for Length { covers, .. } in &layout.lengths {
                    assert!(covers.end <= bytes.len(), "{}", path.display());
                }
                let chunks = match format {
                    Format::Glb | Format::Png => 3,
                    Format::Jpeg => 5,
                    _ => 0,
                };
                assert!(layout.lengths.len() >= chunks, "{}: {layout:?}", path.display());
                // Checksums of a sound picture are right.
                let mut sealed = bytes.clone();
                seal(&mut sealed);
                assert_eq!(sealed, bytes, "{}", path.display());
            }
        }
    }

    #[test]
    fn nothing_lies_beyond_the_end_of_what_is_cut_off() {
        for format in Format::ALL {
            for (path, bytes) in files(&corpus().join(format.name())).expect("the corpus is there")
            {
                for length in 0..bytes.len().min(600) {
                    let Layout { text, numbers, lengths, encoded } =
                        Layout::of(format, &bytes[..length]);
                    let ends = text.iter().chain(&encoded).map(|range| range.end);
                    let ends = ends.chain(numbers.iter().map(|numbers| numbers.range.end));
                    let ends = ends.chain(
                        lengths
                            .iter()
                            .flat_map(|Length { number, covers }| [number.range.end, covers.end]),
                    );
                    let end = ends.max().unwrap_or_default();
                    assert!(end <= length, "{}, {length} bytes: {end}", path.display());
                }
            }
        }
    }

    #[test]
    fn numbers_are_read_in_their_order() {
        let bytes = [1, 2, 3, 4];
        let little = Numbers { range: 0..4, width: 2, big_endian: false };
        let big = Numbers { big_endian: true, ..little.clone() };
        assert_eq!((little.read(&bytes, 1), big.read(&bytes, 1)), (0x0403, 0x0304));
        assert_eq!((little.bytes(0x0403), big.bytes(0x0304)), (vec![3, 4], vec![3, 4]));
    }
}
