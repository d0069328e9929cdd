//! MATLAB files of versions 5 to 7: arrays of numbers, also within structures and cells, and the texts beside them.
//!
//! Source: MAT-File Format, The MathWorks, chapter 1. An element is a tag (type, bytes) and its data, padded to eight bytes.

use std::io::Read as _;

use super::cursor::{Cursor, Stored};
use super::{Channel, Found, Trouble, names};

/// Levels of structures in structures.
const DEEPEST: usize = 16;
/// Elements of a structure array or cell that are read.
const MOST_ELEMENTS: usize = 4096;

const COMPRESSED: u32 = 15;
const MATRIX: u32 = 14;

pub fn read(bytes: &[u8]) -> Result<Found, Trouble> {
    let mut cursor = Cursor::new(bytes);
    cursor.take(126)?;
    cursor.big_end_first = cursor.take(2)? == b"MI";
    let mut reader = Reader::default();
    while cursor.left() > 0 {
        let (kind, mut content) = element(&mut cursor)?;
        match kind {
            COMPRESSED => {
                let mut inflated = Vec::new();
                let packed = content.take(content.left())?;
                flate2::read::ZlibDecoder::new(packed)
                    .read_to_end(&mut inflated)
                    .map_err(|e| Trouble::damaged(format!("a variable can't be unpacked ({e})")))?;
                let mut inner = Cursor::new(&inflated);
                inner.big_end_first = cursor.big_end_first;
                let (kind, content) = element(&mut inner)?;
                if kind == MATRIX {
                    reader.matrix(content, None, 0)?;
                }
            }
            MATRIX => reader.matrix(content, None, 0)?,
            _ => {}
        }
    }
    let Reader {
        mut found, texts, ..
    } = reader;
    names::units_beside(&mut found.channels, &texts);
    Ok(found)
}

/// The next element: its type and its data.
fn element<'a>(cursor: &mut Cursor<'a>) -> Result<(u32, Cursor<'a>), Trouble> {
    let first = cursor.u32()?;
    // Up to four bytes stand in the tag itself.
    if first >> 16 != 0 {
        let (kind, count) = (first & 0xffff, (first >> 16) as usize);
        let mut four = cursor.part(4)?;
        return match count <= 4 {
            true => Ok((kind, four.part(count)?)),
            false => Err(Trouble::damaged(format!(
                "a short element of {count} bytes at byte {}",
                cursor.at
            ))),
        };
    }
    let count = cursor.u32()? as usize;
    let content = cursor.part(count)?;
    if first != COMPRESSED {
        cursor.skip(count.next_multiple_of(8) - count);
    }
    Ok((first, content))
}

/// How the numbers of an element are stored.
fn stored(kind: u32) -> Option<Stored> {
    Some(match kind {
        1 => Stored::I8,
        2 | 16 => Stored::U8,
        3 => Stored::I16,
        4 | 17 => Stored::U16,
        5 => Stored::I32,
        6 | 18 => Stored::U32,
        7 => Stored::F32,
        9 => Stored::F64,
        12 => Stored::I64,
        13 => Stored::U64,
        _ => return None,
    })
}

fn numbers(cursor: &mut Cursor) -> Result<Vec<f64>, Trouble> {
    let (kind, content) = element(cursor)?;
    let stored = stored(kind)
        .ok_or_else(|| Trouble::damaged(format!("an element of type {kind} among numbers")))?;
    stored.all(content)
}

#[derive(Default)]
struct Reader {
    found: Found,
    texts: Vec<(String, String)>,
}

impl Reader {
    /// Reads a matrix; `name` is that of the field it stands in.
    fn matrix(
        &mut self,
        mut from: Cursor,
        name: Option<&str>,
        depth: usize,
    ) -> Result<(), Trouble> {
        if from.left() == 0 {
            return Ok(());
        }
        let flags = numbers(&mut from)?;
        let flags = flags.first().copied().unwrap_or(0.0) as u32;
        let class = flags & 0xff;
        let is_complex = flags & 0x800 != 0;
        // Objects have no dimensions.
        if class >= 16 {
            let (_, mut own) = element(&mut from)?;
            let own = String::from_utf8_lossy(own.take(own.left())?).into_owned();
            let own = name.unwrap_or(&own);
            if !own.is_empty() {
                self.found.remarks.push(format!(
                    "'{own}' is an object of MATLAB (table, timetable, string), not read: save its columns as arrays"
                ));
            }
            return Ok(());
        }
        let dimensions: Vec<usize> = numbers(&mut from)?.iter().map(|d| *d as usize).collect();
        let count = dimensions
            .iter()
            .try_fold(1usize, |all, d| all.checked_mul(*d))
            .ok_or_else(|| Trouble::damaged(format!("an array of {dimensions:?} is announced")))?;
        let (_, mut own) = element(&mut from)?;
        let own = String::from_utf8_lossy(own.take(own.left())?).into_owned();
        let name = name.unwrap_or(&own).to_owned();
        match class {
            1 if depth < DEEPEST => {
                for i in 0..count.min(MOST_ELEMENTS) {
                    let (_, cell) = element(&mut from)?;
                    self.matrix(cell, Some(&format!("{name}/{}", i + 1)), depth + 1)?;
                }
            }
            2 if depth < DEEPEST => self.structure(from, &name, count, depth)?,
            4 => {
                let (_, content) = element(&mut from).map(|(kind, c)| (stored(kind), c))?;
                let bytes = content.clone().take(content.left())?;
                let text = match std::str::from_utf8(bytes) {
                    Ok(text) => text.replace('\0', ""),
                    Err(_) => bytes.iter().map(|b| char::from(*b)).collect(),
                };
                self.texts.push((name, text));
            }
            6..=15 => {
                let values = numbers(&mut from).map_err(|t| t.of(&name))?;
                if is_complex {
                    self.found
                        .remarks
                        .push(format!("'{name}' is complex, not read"));
                } else {
                    array(&mut self.found, &name, &dimensions, values)?;
                }
            }
            _ => self
                .found
                .remarks
                .push(format!("'{name}' is of class {class}, not read")),
        }
        Ok(())
    }

    fn structure(
        &mut self,
        mut from: Cursor,
        name: &str,
        count: usize,
        depth: usize,
    ) -> Result<(), Trouble> {
        let width = numbers(&mut from)?.first().copied().unwrap_or(0.0) as usize;
        let (_, mut names) = element(&mut from)?;
        if width == 0 {
            return Ok(());
        }
        let names = names.take(names.left())?;
        let fields: Vec<String> = names
            .chunks_exact(width)
            .map(|field| field.split(|b| *b == 0).next().unwrap_or_default())
            .map(|field| String::from_utf8_lossy(field).into_owned())
            .collect();
        for i in 0..count.min(MOST_ELEMENTS) {
            for field in &fields {
                let (_, content) = element(&mut from)?;
                let path = match count {
                    1 => format!("{name}/{field}"),
                    _ => format!("{name}/{}/{field}", i + 1),
                };
                self.matrix(content, Some(&path), depth + 1)?;
            }
        }
        Ok(())
    }
}

/// An array as channels: one number is a scalar, a row or column one channel, a matrix one for each column, or for each
/// row where it is wider than tall.
pub fn array(
    found: &mut Found,
    name: &str,
    dimensions: &[usize],
    values: Vec<f64>,
) -> Result<(), Trouble> {
    let count: usize = dimensions.iter().product();
    if values.len() != count {
        return Err(Trouble::damaged(format!(
            "{count} samples are announced and {} are there",
            values.len()
        ))
        .of(name));
    }
    let long: Vec<usize> = dimensions.iter().copied().filter(|d| *d > 1).collect();
    match long.as_slice() {
        _ if count == 0 => found.channels.push(Channel::new(name, Vec::new())),
        [] => found.scalars.push((name.to_owned(), values[0])),
        [_] => found.channels.push(Channel::new(name, values)),
        [rows, columns] => {
            // Samples run along the longer side.
            let (samples, signals, step, next) = match rows >= columns {
                true => (*rows, *columns, 1, *rows),
                false => (*columns, *rows, *rows, 1),
            };
            for signal in 0..signals {
                let own = (0..samples).map(|i| values[signal * next + i * step]);
                let name = format!("{name}#{}", signal + 1);
                found.channels.push(Channel::new(&name, own.collect()));
            }
        }
        _ => found
            .remarks
            .push(format!("'{name}' has {} dimensions, not read", long.len())),
    }
    Ok(())
}
