//! The number types of VTK's files.

use super::super::array::Values;

/// What one number of an array is in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    /// Eight to a byte, the first in the highest bit.
    Bit,
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

impl Scalar {
    /// By the name that VTU files give it.
    pub(super) fn of_xml(name: &str) -> Option<Self> {
        Some(match name {
            "Bit" => Self::Bit,
            "Int8" => Self::I8,
            "UInt8" => Self::U8,
            "Int16" => Self::I16,
            "UInt16" => Self::U16,
            "Int32" => Self::I32,
            "UInt32" => Self::U32,
            "Int64" => Self::I64,
            "UInt64" => Self::U64,
            "Float32" => Self::F32,
            "Float64" => Self::F64,
            _ => return None,
        })
    }

    /// By the name that legacy files give it, in small letters. A `long` has 64 bits, as on every
    /// system but Windows; a `vtkIdType` is written with 32.
    pub(super) fn of_legacy(name: &str) -> Option<Self> {
        Some(match name {
            "bit" => Self::Bit,
            "char" | "signed_char" => Self::I8,
            "unsigned_char" => Self::U8,
            "short" => Self::I16,
            "unsigned_short" => Self::U16,
            "int" | "vtkidtype" => Self::I32,
            "unsigned_int" => Self::U32,
            "long" | "long_long" | "vtktypeint64" => Self::I64,
            "unsigned_long" | "unsigned_long_long" | "vtktypeuint64" => Self::U64,
            "float" => Self::F32,
            "double" => Self::F64,
            _ => return None,
        })
    }

    /// How many bytes `count` numbers take; `None` where no computer has them.
    pub(super) fn bytes_of(self, count: usize) -> Option<usize> {
        let bits = match self {
            Self::Bit => return Some(count.div_ceil(8)),
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        };
        count.checked_mul(bits)
    }

    /// The first `count` numbers of `bytes`, which must hold as many.
    pub(super) fn decode(self, bytes: &[u8], little_endian: bool, count: usize) -> Values {
        fn each<const N: usize, T>(bytes: &[u8], little: bool, number: fn([u8; N]) -> T) -> Vec<T> {
            let words = bytes.as_chunks::<N>().0.iter();
            let ordered = words.map(|&(mut word)| {
                if !little {
                    word.reverse();
                }
                number(word)
            });
            ordered.collect()
        }
        let little = little_endian;
        match self {
            Self::Bit => {
                let bit = |k: usize| i64::from(bytes[k / 8] >> (7 - k % 8) & 1);
                let there = count.min(8 * bytes.len());
                Values::Integers((0..there).map(bit).collect())
            }
            Self::I8 => Values::Integers(each(bytes, little, |b| i8::from_le_bytes(b).into())),
            Self::U8 => Values::Integers(each(bytes, little, |b| u8::from_le_bytes(b).into())),
            Self::I16 => Values::Integers(each(bytes, little, |b| i16::from_le_bytes(b).into())),
            Self::U16 => Values::Integers(each(bytes, little, |b| u16::from_le_bytes(b).into())),
            Self::I32 => Values::Integers(each(bytes, little, |b| i32::from_le_bytes(b).into())),
            Self::U32 => Values::Integers(each(bytes, little, |b| u32::from_le_bytes(b).into())),
            // Ids beyond 2⁶³ do not occur; what VTK writes there is −1.
            Self::I64 | Self::U64 => Values::Integers(each(bytes, little, i64::from_le_bytes)),
            Self::F32 => Values::Floats(each(bytes, little, |b| f32::from_le_bytes(b).into())),
            Self::F64 => Values::Floats(each(bytes, little, f64::from_le_bytes)),
        }
    }

    /// Reads `count` numbers in words. `room` is the length of the text they come from, which
    /// limits what is set aside for them.
    pub(super) fn parse<'a>(
        self,
        mut words: impl Iterator<Item = &'a [u8]>,
        count: usize,
        room: usize,
    ) -> Result<Values, Unreadable> {
        let capacity = count.min(room / 2 + 1);
        let mut found = 0;
        let mut next = || {
            let word = words.next().ok_or(Unreadable::End { found })?;
            found += 1;
            str::from_utf8(word).map_err(|_| Unreadable::of(word))
        };
        if matches!(self, Self::F32 | Self::F64) {
            let mut numbers = Vec::with_capacity(capacity);
            for _ in 0..count {
                let word = next()?;
                let number = match self {
                    Self::F32 => word.parse::<f32>().map(f64::from),
                    _ => word.parse::<f64>(),
                };
                numbers.push(number.map_err(|_| Unreadable::of(word.as_bytes()))?);
            }
            return Ok(Values::Floats(numbers));
        }
        let mut numbers = Vec::with_capacity(capacity);
        for _ in 0..count {
            let word = next()?;
            numbers.push(
                self.whole(word)
                    .ok_or_else(|| Unreadable::of(word.as_bytes()))?,
            );
        }
        Ok(Values::Integers(numbers))
    }

    fn whole(self, word: &str) -> Option<i64> {
        if self == Self::U64 {
            return word.parse::<u64>().ok().map(|x| x as i64);
        }
        let (low, high) = match self {
            Self::Bit => (0, 1),
            // VTK's `char` has a sign on some machines and none on others.
            Self::I8 => (i8::MIN.into(), u8::MAX.into()),
            Self::U8 => (0, u8::MAX.into()),
            Self::I16 => (i16::MIN.into(), i16::MAX.into()),
            Self::U16 => (0, u16::MAX.into()),
            Self::I32 => (i32::MIN.into(), i32::MAX.into()),
            Self::U32 => (0, u32::MAX.into()),
            _ => (i64::MIN, i64::MAX),
        };
        word.parse().ok().filter(|x| (low..=high).contains(x))
    }
}

/// Why words could not be read as numbers.
pub(super) enum Unreadable {
    /// There are no more words.
    End { found: usize },
    /// This is no number of the type.
    Word(String),
}

impl Unreadable {
    fn of(word: &[u8]) -> Self {
        let shown = String::from_utf8_lossy(&word[..word.len().min(24)]);
        Self::Word(shown.into_owned())
    }
}
