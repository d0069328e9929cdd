//! TDMS: groups of channels with properties, in segments.
//!
//! Source: TDMS File Format Internal Structure, National Instruments. A segment has a head of 28 bytes, the list
//! of its objects with what changed since the last segment, and raw data: chunks in which each channel has its
//! block, or samples take turns.

use std::collections::HashMap;

use super::cursor::{Cursor, Stored};
use super::{Channel, Found, Trouble};

const WITH_OBJECTS: u32 = 1 << 1;
const NEW_LIST: u32 = 1 << 2;
const WITH_DATA: u32 = 1 << 3;
const INTERLEAVED: u32 = 1 << 5;
const BIG_END: u32 = 1 << 6;
const OF_DEVICE: u32 = 1 << 7;

#[derive(Clone, Copy, PartialEq)]
enum Type {
    Number(Stored),
    Instant,
    Text,
}

impl Type {
    fn of(code: u32) -> Option<Type> {
        Some(Type::Number(match code {
            1 => Stored::I8,
            2 => Stored::I16,
            3 => Stored::I32,
            4 => Stored::I64,
            5 | 0x21 => Stored::U8,
            6 => Stored::U16,
            7 => Stored::U32,
            8 => Stored::U64,
            9 | 0x19 => Stored::F32,
            10 | 0x1a => Stored::F64,
            0x20 => return Some(Type::Text),
            0x44 => return Some(Type::Instant),
            _ => return None,
        }))
    }

    fn size(self) -> usize {
        match self {
            Type::Number(stored) => stored.size(),
            Type::Instant => 16,
            Type::Text => 1,
        }
    }

    /// A value; of an instant, the seconds since `origin`, or since the whole second of the first where there is none yet:
    /// seconds since 1904 leave an f64 no digits for short intervals.
    fn read(self, from: &mut Cursor, origin: &mut Option<i64>) -> Result<f64, Trouble> {
        match self {
            Type::Number(stored) => stored.read(from),
            Type::Text => Ok(f64::NAN),
            Type::Instant => {
                let (seconds, parts) = match from.big_end_first {
                    true => {
                        let seconds = from.i64()?;
                        (seconds, from.u64()?)
                    }
                    false => {
                        let parts = from.u64()?;
                        (from.i64()?, parts)
                    }
                };
                let since = seconds.wrapping_sub(*origin.get_or_insert(seconds));
                // In 2^-64 s.
                Ok(since as f64 + parts as f64 / 2f64.powi(64))
            }
        }
    }
}

impl Cursor<'_> {
    fn text(&mut self) -> Result<String, Trouble> {
        let count = self.u32()? as usize;
        Ok(String::from_utf8_lossy(self.take(count)?).into_owned())
    }
}

/// What a segment says of a channel's data.
#[derive(Clone, Copy)]
struct Index {
    kind: Type,
    /// Values in each chunk.
    count: usize,
    /// Their bytes.
    bytes: usize,
}

enum Property {
    Number(f64),
    Text(String),
}

#[derive(Default)]
struct Object {
    index: Option<Index>,
    properties: HashMap<String, Property>,
    values: Vec<f64>,
    has_texts: bool,
    /// The second from which instants count.
    origin: Option<i64>,
}

#[derive(Default)]
struct Reader {
    /// Paths in the order in which they came.
    order: Vec<String>,
    objects: HashMap<String, Object>,
    /// The objects with data of the present segment.
    list: Vec<String>,
}

pub fn read(bytes: &[u8]) -> Result<Found, Trouble> {
    let mut cursor = Cursor::new(bytes);
    let mut reader = Reader::default();
    while cursor.left() > 0 {
        let begin = cursor.at;
        if cursor.take(4)? != b"TDSm" {
            return Err(Trouble::damaged(format!(
                "no segment begins at byte {begin}, where one should"
            )));
        }
        let toc = cursor.u32()?;
        cursor.big_end_first = toc & BIG_END != 0;
        let _version = cursor.u32()?;
        let (next, raw) = (cursor.u64()?, cursor.u64()?);
        if next == u64::MAX {
            return Err(Trouble::new(
                format!(
                    "the segment at byte {begin} was never finished: the logger stopped in the midst"
                ),
                "open it and save it again in the program that wrote it, or by two lines of Python: \
                 `from nptdms import TdmsFile` and `TdmsFile(\"run.tdms\").as_dataframe().to_csv(\"run.csv\")`",
            ));
        }
        let (next, raw) = (small(next), small(raw));
        let mut segment = cursor.part(next)?;
        cursor.big_end_first = false;
        if raw > next {
            return Err(Trouble::damaged(format!(
                "the data of the segment at byte {begin} begin behind its end"
            )));
        }
        let mut head = segment.part(raw)?;
        if toc & NEW_LIST != 0 {
            reader.list.clear();
        }
        if toc & WITH_OBJECTS != 0 {
            reader.objects(&mut head)?;
        }
        if toc & WITH_DATA != 0 {
            if toc & OF_DEVICE != 0 {
                return Err(of_device());
            }
            reader.data(segment, toc & INTERLEAVED != 0)?;
        }
    }
    reader.found()
}

/// Sizes beyond the address space are beyond the file.
fn small(size: u64) -> usize {
    usize::try_from(size).unwrap_or(usize::MAX)
}

fn of_device() -> Trouble {
    Trouble::new(
        "raw data of a DAQmx device can't be read",
        "convert the file with two lines of Python: `from nptdms import TdmsFile` and \
         `TdmsFile(\"run.tdms\").as_dataframe(time_index=True).to_csv(\"run.csv\")`",
    )
}

impl Reader {
    fn objects(&mut self, head: &mut Cursor) -> Result<(), Trouble> {
        let count = head.u32()?;
        for _ in 0..count {
            let path = head.text()?;
            if !self.objects.contains_key(&path) {
                self.order.push(path.clone());
            }
            let object = self.objects.entry(path.clone()).or_default();
            let index = head.u32()?;
            let has_data = match index {
                u32::MAX => false,
                0 => object.index.is_some(),
                0x1269 | 0x1369 | 0x6912_0000 | 0x6913_0000 => return Err(of_device()),
                _ => {
                    let code = head.u32()?;
                    let _dimensions = head.u32()?;
                    let values = small(head.u64()?);
                    let kind = Type::of(code).ok_or_else(|| {
                        Trouble::new(
                            format!("numbers of type {code:#x} can't be read"),
                            "save the channel as double",
                        )
                        .of(&shown(&path))
                    })?;
                    let bytes = match kind {
                        Type::Text => Some(small(head.u64()?)),
                        _ => values.checked_mul(kind.size()),
                    };
                    let bytes = bytes.ok_or_else(|| {
                        Trouble::damaged(format!("{values} samples are announced"))
                            .of(&shown(&path))
                    })?;
                    object.index = Some(Index {
                        kind,
                        count: values,
                        bytes,
                    });
                    true
                }
            };
            let properties = head.u32()?;
            for _ in 0..properties {
                let (name, value) = property(head).map_err(|t| t.of(&shown(&path)))?;
                if let Some(value) = value {
                    object.properties.insert(name, value);
                }
            }
            let is_listed = self.list.contains(&path);
            match has_data {
                true if !is_listed => self.list.push(path),
                false if is_listed => self.list.retain(|p| *p != path),
                _ => {}
            }
        }
        Ok(())
    }

    fn data(&mut self, mut data: Cursor, interleaved: bool) -> Result<(), Trouble> {
        let indices: Vec<(String, Index)> = self
            .list
            .iter()
            .filter_map(|path| Some((path.clone(), self.objects.get(path)?.index?)))
            .collect();
        let chunk = indices
            .iter()
            .try_fold(0usize, |all, (_, index)| all.checked_add(index.bytes));
        let chunk = chunk.unwrap_or(usize::MAX);
        if chunk == 0 {
            return Ok(());
        }
        if !data.left().is_multiple_of(chunk) {
            return Err(Trouble::damaged(format!(
                "{} bytes of data where chunks have {chunk}",
                data.left()
            )));
        }
        while data.left() > 0 {
            if interleaved {
                let rows = indices.first().map_or(0, |(_, index)| index.count);
                if let Some((path, _)) = indices
                    .iter()
                    .find(|(_, i)| i.count != rows || i.kind == Type::Text)
                {
                    let short = Trouble::damaged(
                        "samples take turns, and their numbers differ or they are texts",
                    );
                    return Err(short.of(&shown(path)));
                }
                for _ in 0..rows {
                    for (path, index) in &indices {
                        self.put(path, &mut data, (1, index.kind))?;
                    }
                }
            } else {
                for (path, index) in &indices {
                    let mut block = data.part(index.bytes)?;
                    self.put(path, &mut block, (index.count, index.kind))?;
                }
            }
        }
        Ok(())
    }

    /// Reads some values of a channel.
    fn put(
        &mut self,
        path: &str,
        from: &mut Cursor,
        (count, kind): (usize, Type),
    ) -> Result<(), Trouble> {
        let Some(object) = self.objects.get_mut(path) else {
            return Ok(());
        };
        if kind == Type::Text {
            object.has_texts = true;
            return Ok(());
        }
        for _ in 0..count {
            object.values.push(kind.read(from, &mut object.origin)?);
        }
        Ok(())
    }

    fn found(mut self) -> Result<Found, Trouble> {
        let mut found = Found::default();
        for path in std::mem::take(&mut self.order) {
            let Some(mut object) = self.objects.remove(&path) else {
                continue;
            };
            let name = shown(&path);
            // A group, the file itself, or a channel that never had data.
            if object.index.is_none() && path.matches("/'").count() < 2 {
                continue;
            }
            if object.has_texts {
                found
                    .remarks
                    .push(format!("'{name}' holds texts, not read"));
                continue;
            }
            object.scale().map_err(|t| t.of(&name))?;
            let is_instants = object.index.is_some_and(|i| i.kind == Type::Instant);
            let mut values = object.values;
            if is_instants && let Some(first) = values.first().copied() {
                values.iter_mut().for_each(|v| *v -= first);
            }
            let number = |name: &str| match object.properties.get(name) {
                Some(Property::Number(value)) => Some(*value),
                _ => None,
            };
            let increment = number("wf_increment").filter(|i| *i > 0.0 && i.is_finite());
            let start = number("wf_start_offset").filter(|s| s.is_finite());
            let mut channel = Channel::new(&name, values);
            channel.even = increment.map(|i| (start.unwrap_or(0.0), 1.0 / i));
            for unit in ["unit_string", "NI_UnitDescription", "unit", "Unit", "units"] {
                if let Some(Property::Text(text)) = object.properties.get(unit) {
                    channel = channel.with_unit(text);
                }
            }
            if is_instants {
                channel = channel.with_unit("s");
            }
            found.channels.push(channel);
        }
        Ok(found)
    }
}

impl Object {
    /// Applies a linear scale that the file states and its writer has not applied.
    fn scale(&mut self) -> Result<(), Trouble> {
        let number = |name: &str| match self.properties.get(name) {
            Some(Property::Number(value)) => Some(*value),
            _ => None,
        };
        let text = |name: &str| match self.properties.get(name) {
            Some(Property::Text(text)) => Some(text.as_str()),
            _ => None,
        };
        let scales = number("NI_Number_Of_Scales").unwrap_or(0.0);
        if scales < 1.0 || text("NI_Scaling_Status") != Some("unscaled") {
            return Ok(());
        }
        let kind = text("NI_Scale[0]_Scale_Type").unwrap_or("none");
        if scales > 1.0 || kind != "Linear" {
            return Err(Trouble::new(
                format!(
                    "{scales} scale(s), the first of the type '{kind}'; one linear scale can be read"
                ),
                "save scaled values, or convert the file with two lines of Python: \
                 `from nptdms import TdmsFile` and `TdmsFile(\"run.tdms\").as_dataframe().to_csv(\"run.csv\")`",
            ));
        }
        let slope = number("NI_Scale[0]_Linear_Slope").unwrap_or(1.0);
        let offset = number("NI_Scale[0]_Linear_Y_Intercept").unwrap_or(0.0);
        self.values
            .iter_mut()
            .for_each(|v| *v = slope * *v + offset);
        Ok(())
    }
}

/// `/'group'/'channel'` as `group/channel`; a quotation mark in a name is doubled.
fn shown(path: &str) -> String {
    let inner = path.trim_start_matches("/'").trim_end_matches('\'');
    inner.replace("'/'", "/").replace("''", "'")
}

fn property(head: &mut Cursor) -> Result<(String, Option<Property>), Trouble> {
    let name = head.text()?;
    let code = head.u32()?;
    let value = match Type::of(code) {
        Some(Type::Text) => Some(Property::Text(head.text()?)),
        Some(kind) => Some(Property::Number(kind.read(head, &mut Some(0))?)),
        None => {
            let size = match code {
                0 => 0,
                0x0c => 8,
                0x0d => 16,
                0x0008_000c => 8,
                0x0010_000d => 16,
                0x0b | 0x1b => 16,
                _ => {
                    return Err(Trouble::damaged(format!(
                        "property '{name}' is of the unknown type {code:#x}"
                    )));
                }
            };
            head.take(size)?;
            None
        }
    };
    Ok((name, value))
}
