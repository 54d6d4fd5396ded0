//! Mutants: sound files, damaged in places that their format gives a meaning to.
//!
//! Every damage is one edit, a range of bytes and what stands there instead. Lengths that cover the range
//! follow it, and checksums are made right at the end, but for a few: a reader that refuses a mutant for its
//! checksum shows nothing else.

use std::ops::Range;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use rand::seq::{IndexedRandom as _, IteratorRandom as _};
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64;

use crate::format::Format;
use crate::layout::{self, Layout, Length, Numbers};
use crate::words::{elements, lines, words};

/// Bytes of the largest mutant.
const LARGEST: usize = 1 << 18;

/// Bytes of what is repeated.
const LONG: usize = 1 << 16;

/// Numbers at the ends of the ranges that readers keep them in, beyond them, and beside them.
const NUMBERS: &str = "\
    0 -0 -0.0 1 -1 2 127 128 255 256 -32768 32767 65535 65536 16777217 2147483647 2147483648 \
    -2147483648 -2147483649 4294967295 4294967296 9223372036854775807 9223372036854775808 \
    -9223372036854775808 18446744073709551615 18446744073709551616 1e-30 1e-38 1e-45 5e-324 \
    1e18 1e19 1e30 3.4028235e38 -3.4028235e38 3.4028236e38 1e39 1e308 \
    -1.7976931348623157e308 1e309 1e999999999999 1e-999999999999 nan -nan NaN inf -inf \
    Infinity 0.1 1. .5 +1 1e 0x10 1_000 1,5";

/// Words that mean something to one reader or another.
const WORDS: &[&[u8]] = &[
    b"",
    b"\xef\xbb\xbf",
    b"\xff",
    b"\xc3\xa9",
    b"\0",
    b"\r",
    b"\r\n",
    b"\t",
    b"\n",
    b"\x1b[2J",
    b"\\",
    b"#",
    b"\"",
    b"'",
    b"{}",
    b"[]",
    b"{",
    b"]",
    b",",
    b":",
    b"/",
    b"//",
    b"null",
    b"true",
    b"..",
    b"../tetra.obj",
    b"/",
    b"/dev/zero",
    b"/dev/stdin",
    b"%00",
    b"%2e%2e%2f",
    b"data:,",
    b"data:image/png;base64,AAAA",
    b"data:application/octet-stream;base64,",
    b"mutant.obj",
    b"mutant.gltf",
    b"mutant.png",
    b"tetra.obj",
    b"exr.toml",
    b"KHR_draco_mesh_compression",
    b"EXT_meshopt_compression",
    b"KHR_texture_basisu",
];

/// What stands in a range instead.
struct Edit {
    range: Range<usize>,
    with: Vec<u8>,
}

/// Makes the mutants of one format.
pub struct Mutator {
    format: Format,
    seeds: Vec<Vec<u8>>,
    /// Words of all seeds.
    words: Vec<Vec<u8>>,
}

/// The choices of one mutant.
struct Draw<'a> {
    random: Pcg64,
    of: &'a Mutator,
}

impl Mutator {
    /// Of sound files of a format, in an order that is the same everywhere. At least one is needed to make
    /// anything but nothing.
    pub fn new(format: Format, seeds: Vec<Vec<u8>>) -> Self {
        let mut known: Vec<Vec<u8>> = Vec::new();
        for bytes in &seeds {
            for range in Layout::of(format, bytes).text {
                let text = &bytes[range];
                known.extend(words(text).into_iter().map(|word| text[word].to_vec()));
            }
        }
        known.sort();
        known.dedup();
        Self { format, seeds, words: known }
    }

    /// The mutant of a number, of a series that the seed names.
    pub fn mutant(&self, seed: u64, number: u64) -> Vec<u8> {
        let state = u128::from(seed) << 64 | u128::from(number);
        let mut draw = Draw { random: Pcg64::from_seed(state_bytes(state)), of: self };
        let mut bytes = draw.seed().to_vec();
        // The first choices of neighbouring numbers are alike in nothing.
        let mut edits = 1;
        while edits < 6 && draw.chance(2) {
            edits += 1;
        }
        for _ in 0..edits {
            let layout = Layout::of(self.format, &bytes);
            let edit = draw.edit(&bytes, &layout);
            if bytes.len() - edit.range.len() + edit.with.len() > LARGEST {
                continue;
            }
            let follow = !draw.chance(8);
            apply(&mut bytes, &layout, edit, follow);
        }
        if !draw.chance(16) {
            layout::seal(&mut bytes);
        }
        bytes
    }
}

/// The generator's state and stream, from a number.
fn state_bytes(state: u128) -> [u8; 32] {
    let mut bytes = [0; 32];
    bytes[..16].copy_from_slice(&state.to_le_bytes());
    bytes[16..].copy_from_slice(&state.wrapping_mul(0x9e37_79b9_7f4a_7c15).to_le_bytes());
    bytes
}

/// Replaces a range; lengths that cover it `follow`.
fn apply(bytes: &mut Vec<u8>, layout: &Layout, Edit { range, with }: Edit, follow: bool) {
    let (less, more) = (range.len() as u64, with.len() as u64);
    if follow && less != more {
        for Length { number, covers } in &layout.lengths {
            let covered = covers.start <= range.start && range.end <= covers.end;
            if covered && number.range.end <= range.start {
                let length = number.read(bytes, 0).wrapping_sub(less).wrapping_add(more);
                bytes[number.range.clone()].copy_from_slice(&number.bytes(length));
            }
        }
    }
    bytes.splice(range, with);
}

/// The same range, `offset` bytes later.
fn moved(range: &Range<usize>, offset: usize) -> Range<usize> {
    range.start + offset..range.end + offset
}

impl Draw<'_> {
    fn below(&mut self, end: usize) -> usize {
        if end == 0 { 0 } else { self.random.random_range(0..end) }
    }

    /// Once in so many times.
    fn chance(&mut self, times: u32) -> bool {
        self.random.random_range(0..times) == 0
    }

    fn of<'a, T>(&mut self, from: &'a [T]) -> Option<&'a T> {
        from.choose(&mut self.random)
    }

    fn seed(&mut self) -> &'_ [u8] {
        let of = self.of;
        self.of(&of.seeds).map_or(&[], Vec::as_slice)
    }

    fn edit(&mut self, bytes: &[u8], layout: &Layout) -> Edit {
        let made = match self.below(16) {
            0..8 => self.text(bytes, layout),
            8..12 => self.number(bytes, layout),
            12..14 => self.embedded(bytes, layout),
            _ => None,
        };
        // Binary files have no text, and others no numbers.
        made.or_else(|| if self.chance(2) { self.number(bytes, layout) } else { None })
            .or_else(|| if self.chance(4) { self.text(bytes, layout) } else { None })
            .unwrap_or_else(|| self.bytes(bytes))
    }

    fn text(&mut self, bytes: &[u8], layout: &Layout) -> Option<Edit> {
        let range = self.of(&layout.text)?.clone();
        let text = &bytes[range.clone()];
        let edit = match self.below(8) {
            0..4 => self.word(text),
            4 | 5 => self.line(text),
            _ => self.element(text).or_else(|| self.word(text)),
        }?;
        Some(Edit { range: moved(&edit.range, range.start), with: edit.with })
    }

    /// A word dropped, doubled, put elsewhere, or another in its place.
    fn word(&mut self, text: &[u8]) -> Option<Edit> {
        let all = words(text);
        let is_number = |word: &&Range<usize>| {
            str::from_utf8(&text[(*word).clone()]).is_ok_and(|word| word.parse::<f64>().is_ok())
        };
        let numbers: Vec<_> = all.iter().filter(is_number).cloned().collect();
        let from = if !numbers.is_empty() && self.chance(2) { &numbers } else { &all };
        let range = self.of(from)?.clone();
        let word = &text[range.clone()];
        if from.len() < all.len() && !self.chance(8) {
            return Some(Edit { range, with: self.extreme_text() });
        }
        let with = match self.below(8) {
            0 => Vec::new(),
            1 => [word, b" ", word].concat(),
            2 => self.of(WORDS)?.to_vec(),
            3 => self.long(word, b""),
            4 => self.nested(word),
            5 => {
                let other = self.of(&all)?.clone();
                return Some(swapped(text, range, other));
            }
            _ => {
                let of = self.of;
                self.of(&of.words)?.clone()
            }
        };
        Some(Edit { range, with })
    }

    /// A line dropped, doubled, put elsewhere, or one of another file beside it.
    fn line(&mut self, text: &[u8]) -> Option<Edit> {
        let all = lines(text);
        let range = self.of(&all)?.clone();
        let line = &text[range.clone()];
        let with = match self.below(6) {
            0 => Vec::new(),
            1 => [line, line].concat(),
            2 => self.long(line, b""),
            3 => {
                let other = self.of(&all)?.clone();
                return Some(swapped(text, range, other));
            }
            4 => line.strip_suffix(b"\n")?.to_vec(),
            _ => {
                let seed = self.seed().to_vec();
                let other = self.of(&lines(&seed))?.clone();
                [line, &seed[other]].concat()
            }
        };
        Some(Edit { range, with })
    }

    /// What stands between commas dropped, doubled, put elsewhere, or another in its place.
    fn element(&mut self, text: &[u8]) -> Option<Edit> {
        let all = elements(text);
        let range = self.of(&all)?.clone();
        let element = &text[range.clone()];
        let key = layout::find(element, b":").map_or(0, |at| at + 1);
        let value = range.start + key..range.end;
        let edit = match self.below(8) {
            0 => {
                let comma = usize::from(text.get(range.end) == Some(&b','));
                Edit { range: range.start..range.end + comma, with: Vec::new() }
            }
            1 => Edit { range, with: [element, b",", element].concat() },
            2 => Edit { range, with: self.long(element, b",") },
            3 => {
                let other = self.of(&all)?.clone();
                swapped(text, range, other)
            }
            4 => {
                let with: &[&[u8]] = &[b"null", b"[]", b"{}", b"0", b"\"\"", b"[0]", b"true"];
                Edit { range: value, with: self.of(with)?.to_vec() }
            }
            5 => {
                let with = self.nested(&text[value.clone()]);
                Edit { range: value, with }
            }
            _ => {
                let seed = self.seed().to_vec();
                let other = self.of(&elements(&seed))?.clone();
                Edit { range, with: seed[other].to_vec() }
            }
        };
        Some(edit)
    }

    fn extreme_text(&mut self) -> Vec<u8> {
        match self.below(8) {
            // Indices of other things, and of itself.
            0..3 => self.below(8).to_string().into_bytes(),
            3 => [b"1".as_slice(), &b"0".repeat(1 + self.below(400))].concat(),
            4 => [b"0.".as_slice(), &b"0".repeat(self.below(400)), b"7"].concat(),
            _ => NUMBERS.split(' ').choose(&mut self.random).unwrap_or("0").into(),
        }
    }

    /// A part many times over.
    fn long(&mut self, part: &[u8], between: &[u8]) -> Vec<u8> {
        let mut once = part.to_vec();
        once.extend(between);
        let most = LONG / once.len().max(1);
        let times = if self.chance(2) { most } else { 1 + self.below(64).min(most) };
        let mut whole = once.repeat(times);
        whole.truncate(whole.len() - between.len().min(whole.len()));
        whole
    }

    /// A part deep in brackets.
    fn nested(&mut self, part: &[u8]) -> Vec<u8> {
        let depth = [4, 100, 130, 1000, 20_000][self.below(5)];
        let (open, close): (&[u8], &[u8]) = match self.below(4) {
            0 => (b"{\"children\":", b"}"),
            1 => (b"a.", b""),
            2 => (b"{a=", b"}"),
            _ => (b"[", b"]"),
        };
        let depth = depth.min(LONG / open.len());
        [&open.repeat(depth), part, &close.repeat(depth)].concat()
    }

    /// A number of a binary file at the ends of its range, beside what it was, or another's.
    fn number(&mut self, bytes: &[u8], layout: &Layout) -> Option<Edit> {
        let numbers = self.of(&layout.numbers)?;
        let which = self.below(numbers.count());
        let value = numbers.read(bytes, which);
        let other = self.below(numbers.count());
        let value = match self.below(8) {
            0 => value.wrapping_add(1),
            1 => value.wrapping_sub(1),
            2 => value ^ 1 << self.below(numbers.width * 8),
            3 => self.below(8) as u64,
            4 => numbers.read(bytes, other),
            5 => self.random.random(),
            _ => self.extreme(numbers),
        };
        Some(Edit { range: numbers.place(which), with: numbers.bytes(value) })
    }

    /// The bits of an integer or a float that readers may stumble over.
    fn extreme(&mut self, numbers: &Numbers) -> u64 {
        let bits = numbers.width * 8;
        let most = u64::MAX >> (64 - bits);
        let integers =
            [0, 1, 2, most, most - 1, most >> 1, (most >> 1) + 1, most >> 2, most >> 8, most / 3];
        let floats = [
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            -0.0,
            1.0,
            -1.0,
            1e-30,
            1e18,
            1e30,
            -1e38,
            1e300,
        ];
        let float = self.of(&floats).copied().unwrap_or_default();
        match numbers.width {
            #[expect(clippy::cast_possible_truncation, reason = "rounding is wanted")]
            4 if self.chance(2) => u64::from(match self.below(4) {
                0 => [1, 0x007f_ffff, 0x7f7f_ffff, 0xff7f_ffff][self.below(4)],
                _ => (float as f32).to_bits(),
            }),
            8 if self.chance(2) => match self.below(4) {
                0 => [1, f64::MAX.to_bits(), (-f64::MAX).to_bits()][self.below(3)],
                _ => float.to_bits(),
            },
            _ => self.of(&integers).copied().unwrap_or_default(),
        }
    }

    /// Damage to what is embedded as text, in its own terms.
    fn embedded(&mut self, bytes: &[u8], layout: &Layout) -> Option<Edit> {
        let range = self.of(&layout.encoded)?.clone();
        let mut inner = BASE64.decode(&bytes[range.clone()]).ok()?;
        let layout = Layout::of_embedded(&inner);
        let edit = self.number(&inner, &layout).filter(|_| !self.chance(3));
        let edit = edit.unwrap_or_else(|| self.bytes(&inner));
        apply(&mut inner, &layout, edit, true);
        layout::seal(&mut inner);
        Some(Edit { range, with: BASE64.encode(inner).into_bytes() })
    }

    /// Bytes changed, cut out, doubled or put in, the end cut off, or another file's end in its place.
    fn bytes(&mut self, bytes: &[u8]) -> Edit {
        let at = self.below(bytes.len() + 1);
        let end = bytes.len().min(at + 1 + self.below(8));
        let range = at..end;
        let with = match self.below(8) {
            0 => {
                let mut with = bytes[range.clone()].to_vec();
                let bit = self.below(8);
                with.iter_mut().take(1).for_each(|byte| *byte ^= 1 << bit);
                with
            }
            1 => (0..=self.below(4)).map(|_| self.random.random()).collect(),
            2 => Vec::new(),
            3 => [&bytes[range.clone()], &bytes[range.clone()]].concat(),
            4 => vec![[0, 0xff][self.below(2)]; range.len()],
            5 => {
                let with = (0..=self.below(8)).map(|_| self.random.random()).collect();
                return Edit { range: at..at, with };
            }
            6 => return Edit { range: at..bytes.len(), with: Vec::new() },
            _ => {
                let seed = self.seed().to_vec();
                let from = if self.chance(2) { at.min(seed.len()) } else { self.below(seed.len()) };
                return Edit { range: at..bytes.len(), with: seed[from..].to_vec() };
            }
        };
        Edit { range, with }
    }
}

/// Two parts of a text, each in the other's place, where they do not overlap; else the first is dropped.
fn swapped(text: &[u8], a: Range<usize>, b: Range<usize>) -> Edit {
    let (first, second) = if a.start <= b.start { (a, b) } else { (b, a) };
    if first.end > second.start {
        return Edit { range: first, with: Vec::new() };
    }
    let with = [&text[second.clone()], &text[first.end..second.start], &text[first.clone()]];
    Edit { range: first.start..second.end, with: with.concat() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::{corpus, files};

    fn mutator(format: Format) -> Mutator {
        let seeds = files(&corpus().join(format.name())).expect("the corpus is there");
        Mutator::new(format, seeds.into_iter().map(|(_, bytes)| bytes).collect())
    }

    #[test]
    fn a_number_names_one_mutant() {
        for format in Format::ALL {
            let (one, other) = (mutator(format), mutator(format));
            let mut differ = 0;
            for number in 0..200 {
                let mutant = one.mutant(7, number);
                assert_eq!(mutant, other.mutant(7, number), "{format:?} {number}");
                assert!(mutant.len() <= LARGEST, "{format:?} {number}");
                differ += usize::from(mutant != one.mutant(8, number));
            }
            assert!(differ > 190, "{format:?}: {differ} of 200 differ by the seed");
        }
    }

    #[test]
    fn lengths_follow_what_they_cover() {
        let mutator = mutator(Format::Glb);
        let bytes = &mutator.seeds[0];
        let layout = Layout::of(Format::Glb, bytes);
        let at = layout.text[0].start + 1;
        let mut longer = bytes.clone();
        apply(&mut longer, &layout, Edit { range: at..at, with: b"    ".to_vec() }, true);
        let after = Layout::of(Format::Glb, &longer);
        assert_eq!(after.lengths.len(), layout.lengths.len());
        assert_eq!(after.lengths[0].covers, 0..longer.len());
        assert_eq!(after.text[0].len(), layout.text[0].len() + 4);
    }

    #[test]
    fn damaged_pictures_keep_right_checksums() {
        let mutator = mutator(Format::Png);
        let right = (0..1000).filter(|&number| {
            let mutant = mutator.mutant(1, number);
            let mut sealed = mutant.clone();
            layout::seal(&mut sealed);
            sealed == mutant
        });
        let right = right.count();
        assert!((930..1000).contains(&right), "{right} of 1000");
    }
}
