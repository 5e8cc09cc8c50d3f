//! Numbers in binary files.

/// Binary format of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    F64,
    F32,
    I8,
    I16,
    I32,
    I64,
    U8,
    U16,
    U32,
    U64,
}

/// A number as the file stores it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Reading {
    Float(f64),
    Integer(i64),
}

impl Number {
    /// Returns the size in bytes.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::F32 | Self::I32 | Self::U32 => 4,
            Self::F64 | Self::I64 | Self::U64 => 8,
        }
    }

    /// Decodes a number.
    ///
    /// - `bytes`: as many as [`Number::size`].
    pub(super) fn read(self, bytes: &[u8], big_endian: bool) -> Reading {
        let push = |bits: u64, byte: &u8| bits << 8 | u64::from(*byte);
        let bits = if big_endian {
            bytes.iter().fold(0, push)
        } else {
            bytes.iter().rev().fold(0, push)
        };
        match self {
            Self::F64 => Reading::Float(f64::from_bits(bits)),
            Self::F32 => Reading::Float(f64::from(f32::from_bits(bits as u32))),
            Self::I8 => Reading::Integer(i64::from(bits as i8)),
            Self::I16 => Reading::Integer(i64::from(bits as i16)),
            Self::I32 => Reading::Integer(i64::from(bits as i32)),
            Self::I64 | Self::U8 | Self::U16 | Self::U32 => Reading::Integer(bits as i64),
            Self::U64 => i64::try_from(bits).map_or(Reading::Float(bits as f64), Reading::Integer),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_numbers_in_both_orders() {
        let number = |number: Number, bytes: &[u8]| {
            let little = number.read(bytes, false);
            let turned: Vec<u8> = bytes.iter().rev().copied().collect();
            assert_eq!(little, number.read(&turned, true));
            little
        };
        assert_eq!(number(Number::I16, &[0xfe, 0xff]), Reading::Integer(-2));
        assert_eq!(number(Number::U16, &[0xfe, 0xff]), Reading::Integer(0xfffe));
        assert_eq!(number(Number::I8, &[0x80]), Reading::Integer(-128));
        assert_eq!(number(Number::I32, &[0xff; 4]), Reading::Integer(-1));
        assert_eq!(
            number(Number::U64, &[0xff; 8]),
            Reading::Float(u64::MAX as f64)
        );
        assert_eq!(
            number(Number::F32, &1.5_f32.to_le_bytes()),
            Reading::Float(1.5)
        );
        assert_eq!(
            number(Number::F64, &(-0.1_f64).to_le_bytes()),
            Reading::Float(-0.1)
        );
    }
}
