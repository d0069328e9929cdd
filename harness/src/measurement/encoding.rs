//! A file's bytes as text, in the encodings that loggers write.

use std::borrow::Cow;

use encoding_rs::{Encoding, UTF_16BE, UTF_16LE, WINDOWS_1252};

/// A text, and how it was encoded where that is not plain UTF-8.
pub(super) struct Text {
    pub content: String,
    pub encoding: Option<&'static str>,
}

/// Decodes `bytes`: by the byte order mark where there is one; else UTF-8; else UTF-16 where every
/// other byte is zero; else Windows-1252, in which old loggers write `µ` and `°`. Numbers look the
/// same in all that begin with ASCII.
pub(super) fn decode(bytes: &[u8]) -> Text {
    if let Some((encoding, mark)) = Encoding::for_bom(bytes) {
        let (content, _) = encoding.decode_without_bom_handling(&bytes[mark..]);
        return named(content, encoding);
    }
    if let Some(encoding) = utf16_without_mark(bytes) {
        let (content, _) = encoding.decode_without_bom_handling(bytes);
        return named(content, encoding);
    }
    match std::str::from_utf8(bytes) {
        Ok(content) => Text {
            content: content.to_owned(),
            encoding: None,
        },
        Err(_) => {
            let (content, _) = WINDOWS_1252.decode_without_bom_handling(bytes);
            named(content, WINDOWS_1252)
        }
    }
}

fn named(content: Cow<'_, str>, encoding: &'static Encoding) -> Text {
    let name = match encoding.name() {
        "UTF-8" => "UTF-8 with a byte order mark",
        "UTF-16LE" => "UTF-16, little end first",
        "UTF-16BE" => "UTF-16, big end first",
        name => name,
    };
    Text {
        content: content.into_owned(),
        encoding: Some(name),
    }
}

/// Characters at the beginning that are looked at for zero bytes.
const LOOKED_AT: usize = 512;

/// UTF-16 by its zero bytes: a table's characters are ASCII, so that one byte of each pair is zero.
fn utf16_without_mark(bytes: &[u8]) -> Option<&'static Encoding> {
    let pairs = bytes.chunks_exact(2).take(LOOKED_AT);
    let all = pairs.len();
    let zeros = |place: usize| pairs.clone().filter(|pair| pair[place] == 0).count();
    let (first, second) = (zeros(0), zeros(1));
    let mostly = |zeros: usize| all >= 8 && 10 * zeros > 9 * all;
    match (mostly(first), mostly(second)) {
        (true, false) => Some(UTF_16BE),
        (false, true) => Some(UTF_16LE),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_text_comes_out_of_every_encoding() {
        let text = "t/ms;x [µm]\n0,1;2,5\n0,2;2,6\n";
        let wide = |bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
            text.encode_utf16().flat_map(bytes).collect()
        };
        let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
        let cases = [
            (text.as_bytes().to_vec(), None),
            (
                ["\u{feff}".as_bytes(), text.as_bytes()].concat(),
                Some("UTF-8 with a byte order mark"),
            ),
            (
                [&[0xff, 0xfe], &wide(u16::to_le_bytes)[..]].concat(),
                Some("UTF-16, little end first"),
            ),
            (
                [&[0xfe, 0xff], &wide(u16::to_be_bytes)[..]].concat(),
                Some("UTF-16, big end first"),
            ),
            (wide(u16::to_le_bytes), Some("UTF-16, little end first")),
            (wide(u16::to_be_bytes), Some("UTF-16, big end first")),
            (latin, Some("windows-1252")),
        ];
        for (bytes, encoding) in cases {
            let found = decode(&bytes);
            assert_eq!((found.content.as_str(), found.encoding), (text, encoding));
        }
    }
}
