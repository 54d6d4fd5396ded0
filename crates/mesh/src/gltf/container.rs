//! What a document comes in: the binary file's chunks, JSON, and data as text.

use base64::Engine as _;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use serde::Deserialize;
use serde::de::IgnoredAny;

use super::document::{Asset, Document, Version};
use super::malformed;
use crate::error::MeshProblem;
use crate::quote::{cut, quoted};
use crate::reading::Reading;

/// A part of a binary file, and its kind.
type Chunk<'a> = (&'a [u8], [u8; 4]);

/// The document's JSON, and the bytes that a binary file carries beside it.
pub(super) fn split<'a>(
    bytes: &'a [u8],
    reading: &mut Reading,
) -> Result<(&'a [u8], Option<Vec<u8>>), MeshProblem> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes, None));
    }
    let word = |at: usize| bytes.get(at..at + 4).and_then(|word| word.try_into().ok());
    let number = |at: usize| word(at).map(|word| u32::from_le_bytes(word) as usize);
    match number(4) {
        Some(1) => return Err(old()),
        Some(version) if version != 2 => return Err(unknown_version(&version.to_string())),
        _ => {}
    }
    let (promised, actual) = (number(8).unwrap_or(12), bytes.len());
    let lengths = format!("the header promises {promised} bytes, the file has {actual}");
    if promised > actual {
        return Err(MeshProblem::Truncated { what: lengths });
    }
    if promised < actual {
        reading.tolerate(lengths, "bytes after the last chunk")?;
    }
    let mut at = 12;
    let mut chunk = || -> Result<Option<Chunk<'a>>, MeshProblem> {
        let Some(kind) = word(at + 4).filter(|_| at + 8 <= promised) else { return Ok(None) };
        let length = number(at).unwrap_or_default();
        let data = bytes[..promised].get(at + 8..at + 8 + length).ok_or_else(|| {
            let what = format!("the chunk at byte {at} needs {length} bytes");
            MeshProblem::Truncated { what }
        })?;
        at += 8 + length.next_multiple_of(4);
        Ok(Some((data, kind)))
    };
    let Some((json, [b'J', b'S', b'O', b'N'])) = chunk()? else {
        return Err(malformed("header", "the first chunk is not JSON"));
    };
    let blob = loop {
        match chunk()? {
            Some((data, [b'B', b'I', b'N', 0])) => break Some(data),
            Some(_) => {}
            None => break None,
        }
    };
    if let Some(blob) = blob {
        reading.claim(blob.len() as u64)?;
    }
    Ok((json, blob.map(<[u8]>::to_vec)))
}

/// The document that a JSON text holds.
pub(super) fn parse(mut json: &[u8], reading: &mut Reading) -> Result<Document, MeshProblem> {
    if let Some(rest) = json.strip_prefix(b"\xef\xbb\xbf") {
        reading.tolerate("line 1", "a byte order mark")?;
        json = rest;
    }
    // Chunks are filled up with spaces; some programs take zeros.
    let is_padding = |byte: &u8| *byte == 0 || byte.is_ascii_whitespace();
    let end = json.iter().rposition(|byte| !is_padding(byte)).map_or(0, |last| last + 1);
    if json[end..].contains(&0) {
        reading.tolerate("end of the JSON", "zero bytes")?;
        json = &json[..end];
    }
    let document: Document = serde_json::from_slice(json).map_err(|error| {
        let what = cut(&error.to_string(), 200);
        match error.classify() {
            serde_json::error::Category::Eof => MeshProblem::Truncated { what },
            _ if is_old(json) => old(),
            _ => malformed("document", what),
        }
    })?;
    if is_first(&document.asset) {
        return Err(old());
    }
    if !matches!(document.asset.version, Some(Version::Text(_))) {
        reading.tolerate("asset", "a version that is no text")?;
    }
    let version = document.asset.version.as_ref().map_or("2.0".to_owned(), Version::to_string);
    // What is of a later minor version can be read, unless it says that it cannot.
    let least = document.asset.min_version.as_ref().map_or("2.0".to_owned(), Version::to_string);
    match (version.starts_with("2."), least.as_str()) {
        (true, "2.0") => {}
        (true, least) => return Err(unknown_version(least)),
        (false, _) => return Err(unknown_version(&version)),
    }
    Ok(document)
}

/// Whether a JSON text is of the format's first version, whose lists were dictionaries.
fn is_old(json: &[u8]) -> bool {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Kind {
        Dictionary(Dictionary),
        Other(IgnoredAny),
    }
    #[derive(Deserialize)]
    struct Dictionary {}
    #[derive(Default, Deserialize)]
    #[serde(default)]
    struct Probe {
        asset: Asset,
        accessors: Option<Kind>,
        meshes: Option<Kind>,
        nodes: Option<Kind>,
        scenes: Option<Kind>,
    }
    let probe: Probe = serde_json::from_slice(json).unwrap_or_default();
    let lists = [probe.accessors, probe.meshes, probe.nodes, probe.scenes];
    let is_dictionary = |list: &Option<Kind>| matches!(list, Some(Kind::Dictionary(Dictionary {})));
    is_first(&probe.asset) || lists.iter().any(is_dictionary)
}

fn is_first(asset: &Asset) -> bool {
    asset.version.as_ref().is_some_and(|version| {
        let version = version.to_string();
        version == "1" || version.starts_with("1.")
    })
}

fn old() -> MeshProblem {
    unknown_version("1.0")
}

fn unknown_version(version: &str) -> MeshProblem {
    MeshProblem::Unsupported {
        what: format!("glTF {} is", quoted(version)),
        mend: "convert it to glTF 2.0",
    }
}

/// The bytes of a data URI after its scheme (RFC 2397): in base64, or percent-encoded.
pub(super) fn decode_data(text: &str) -> Result<Vec<u8>, String> {
    let (kind, data) = text.split_once(',').ok_or("its data URI has no comma")?;
    let plain: Vec<u8> = percent_encoding::percent_decode_str(data).collect();
    let is_base64 =
        kind.rsplit(';').next().is_some_and(|last| last.trim().eq_ignore_ascii_case("base64"));
    if !is_base64 {
        return Ok(plain);
    }
    // Padding may be left out, and lines broken.
    let config =
        GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
    let plain: Vec<u8> = plain.into_iter().filter(|byte| !byte.is_ascii_whitespace()).collect();
    GeneralPurpose::new(&STANDARD, config).decode(plain).map_err(|error| error.to_string())
}
