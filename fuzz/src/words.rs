//! The parts of a text: words, lines, and what stands between brackets and commas.

use std::ops::Range;

/// Words and signs, each a range of `text`. A word is of letters, digits and what numbers and names hold.
pub(crate) fn words(text: &[u8]) -> Vec<Range<usize>> {
    let in_word =
        |byte: u8| byte.is_ascii_alphanumeric() || b"_+-.%".contains(&byte) || byte >= 0x80;
    let mut words: Vec<Range<usize>> = Vec::new();
    for (at, &byte) in text.iter().enumerate() {
        if byte.is_ascii_whitespace() {
            continue;
        }
        match words.last_mut() {
            Some(last) if last.end == at && in_word(byte) && in_word(text[at - 1]) => last.end += 1,
            _ => words.push(at..at + 1),
        }
    }
    words
}

/// Lines, with their ends.
pub(crate) fn lines(text: &[u8]) -> Vec<Range<usize>> {
    let mut start = 0;
    text.split_inclusive(|&byte| byte == b'\n')
        .map(|line| {
            start += line.len();
            start - line.len()..start
        })
        .collect()
}

/// What a bracket holds between its commas: of JSON and TOML the values of lists and the members of objects.
pub(crate) fn elements(text: &[u8]) -> Vec<Range<usize>> {
    let mut elements = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    let mut in_string = false;
    let mut escaped = false;
    for (at, &byte) in text.iter().enumerate() {
        if in_string {
            in_string = escaped || byte != b'"';
            escaped = byte == b'\\' && !escaped;
            continue;
        }
        match byte {
            b'"' => in_string = true,
            b'[' | b'{' => open.push(at + 1),
            b',' | b']' | b'}' => {
                let Some(start) = open.last_mut() else { continue };
                if *start < at {
                    elements.push(*start..at);
                }
                if byte == b',' {
                    *start = at + 1;
                } else {
                    open.pop();
                }
            }
            _ => {}
        }
    }
    elements
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &str, parts: fn(&[u8]) -> Vec<Range<usize>>) -> Vec<&str> {
        parts(text.as_bytes()).into_iter().map(|range| &text[range]).collect()
    }

    #[test]
    fn text_is_taken_apart() {
        assert_eq!(shown("v -1e3 a/b\n", words), ["v", "-1e3", "a", "/", "b"]);
        assert_eq!(shown("a\n\nb", lines), ["a\n", "\n", "b"]);
        assert_eq!(
            shown(r#"{"a":[1,2],"b,]":{}}"#, elements),
            ["1", "2", r#""a":[1,2]"#, r#""b,]":{}"#]
        );
    }
}
