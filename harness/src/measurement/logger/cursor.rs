//! Bytes read one number after the other, either end first, never beyond the last.

use super::Trouble;

/// A place in a file's bytes.
#[derive(Clone)]
pub struct Cursor<'a> {
    bytes: &'a [u8],
    /// Bytes passed.
    pub at: usize,
    pub big_end_first: bool,
}

macro_rules! number {
    ($name:ident, $type:ty) => {
        pub fn $name(&mut self) -> Result<$type, Trouble> {
            const SIZE: usize = size_of::<$type>();
            let taken = self.take(SIZE)?;
            let mut bytes = [0; SIZE];
            bytes.copy_from_slice(taken);
            Ok(match self.big_end_first {
                true => <$type>::from_be_bytes(bytes),
                false => <$type>::from_le_bytes(bytes),
            })
        }
    };
}

impl<'a> Cursor<'a> {
    pub fn new(bytes: &'a [u8]) -> Cursor<'a> {
        Cursor {
            bytes,
            at: 0,
            big_end_first: false,
        }
    }

    pub fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    pub fn take(&mut self, count: usize) -> Result<&'a [u8], Trouble> {
        if count > self.left() {
            return Err(Trouble::damaged(format!(
                "{count} bytes are announced behind byte {} and {} are there",
                self.at,
                self.left()
            )));
        }
        let taken = &self.bytes[self.at..self.at + count];
        self.at += count;
        Ok(taken)
    }

    /// The next bytes with a cursor of their own.
    pub fn part(&mut self, count: usize) -> Result<Cursor<'a>, Trouble> {
        Ok(Cursor {
            bytes: self.take(count)?,
            at: 0,
            big_end_first: self.big_end_first,
        })
    }

    /// As many as `count` bytes, or those there are.
    pub fn skip(&mut self, count: usize) {
        self.at += count.min(self.left());
    }

    number!(u8, u8);
    number!(u16, u16);
    number!(u32, u32);
    number!(u64, u64);
    number!(i8, i8);
    number!(i16, i16);
    number!(i32, i32);
    number!(i64, i64);
    number!(f32, f32);
    number!(f64, f64);
}

/// How a number is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stored {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Stored {
    pub fn size(self) -> usize {
        match self {
            Stored::I8 | Stored::U8 => 1,
            Stored::I16 | Stored::U16 => 2,
            Stored::I32 | Stored::U32 | Stored::F32 => 4,
            Stored::I64 | Stored::U64 | Stored::F64 => 8,
        }
    }

    pub fn read(self, from: &mut Cursor) -> Result<f64, Trouble> {
        Ok(match self {
            Stored::I8 => f64::from(from.i8()?),
            Stored::U8 => f64::from(from.u8()?),
            Stored::I16 => f64::from(from.i16()?),
            Stored::U16 => f64::from(from.u16()?),
            Stored::I32 => f64::from(from.i32()?),
            Stored::U32 => f64::from(from.u32()?),
            Stored::I64 => from.i64()? as f64,
            Stored::U64 => from.u64()? as f64,
            Stored::F32 => f64::from(from.f32()?),
            Stored::F64 => from.f64()?,
        })
    }

    /// All numbers that `from` holds.
    pub fn all(self, mut from: Cursor) -> Result<Vec<f64>, Trouble> {
        let count = from.left() / self.size();
        (0..count).map(|_| self.read(&mut from)).collect()
    }
}
