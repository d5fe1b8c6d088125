//! The types of fields, and values of them.

use core::fmt;
use core::str::FromStr;

/// The type of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Type {
    /// 0 or 1, in a byte.
    Bool,
    /// 8 bits.
    Uint8,
    /// 32 bits.
    Uint32,
    /// 64 bits.
    Uint64,
    /// 32 bits with a sign.
    Int32,
    /// A double.
    Double,
    /// Three doubles.
    Vector3d,
    /// Six doubles.
    Vector6d,
    /// Six numbers of 32 bits with a sign.
    Vector6Int32,
    /// Six numbers of 32 bits.
    Vector6Uint32,
}

impl Type {
    /// All of them.
    pub const ALL: [Type; 10] = [
        Type::Bool,
        Type::Uint8,
        Type::Uint32,
        Type::Uint64,
        Type::Int32,
        Type::Double,
        Type::Vector3d,
        Type::Vector6d,
        Type::Vector6Int32,
        Type::Vector6Uint32,
    ];

    /// As the protocol writes it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Type::Bool => "BOOL",
            Type::Uint8 => "UINT8",
            Type::Uint32 => "UINT32",
            Type::Uint64 => "UINT64",
            Type::Int32 => "INT32",
            Type::Double => "DOUBLE",
            Type::Vector3d => "VECTOR3D",
            Type::Vector6d => "VECTOR6D",
            Type::Vector6Int32 => "VECTOR6INT32",
            Type::Vector6Uint32 => "VECTOR6UINT32",
        }
    }

    /// Bytes of a value.
    #[must_use]
    pub const fn size(self) -> usize {
        match self {
            Type::Bool | Type::Uint8 => 1,
            Type::Uint32 | Type::Int32 => 4,
            Type::Uint64 | Type::Double => 8,
            Type::Vector3d | Type::Vector6Int32 | Type::Vector6Uint32 => 24,
            Type::Vector6d => 48,
        }
    }
}

/// What a controller answers for the name of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Offer {
    /// It has the field, with values of this type.
    Has(Type),
    /// It has no such field.
    NotFound,
    /// It takes the field as an input, and another client writes it already.
    InUse,
}

impl FromStr for Offer {
    type Err = ();

    fn from_str(text: &str) -> Result<Offer, ()> {
        match text {
            "NOT_FOUND" => Ok(Offer::NotFound),
            "IN_USE" => Ok(Offer::InUse),
            _ => Type::ALL.into_iter().find(|one| one.name() == text).map(Offer::Has).ok_or(()),
        }
    }
}

impl fmt::Display for Offer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Offer::Has(has) => has.name(),
            Offer::NotFound => "NOT_FOUND",
            Offer::InUse => "IN_USE",
        })
    }
}

/// A value of a field.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "the types say it")]
pub enum Value {
    Bool(bool),
    Uint8(u8),
    Uint32(u32),
    Uint64(u64),
    Int32(i32),
    Double(f64),
    Vector3d([f64; 3]),
    Vector6d([f64; 6]),
    Vector6Int32([i32; 6]),
    Vector6Uint32([u32; 6]),
}

impl Value {
    /// Its type.
    #[must_use]
    pub const fn of(&self) -> Type {
        match self {
            Value::Bool(_) => Type::Bool,
            Value::Uint8(_) => Type::Uint8,
            Value::Uint32(_) => Type::Uint32,
            Value::Uint64(_) => Type::Uint64,
            Value::Int32(_) => Type::Int32,
            Value::Double(_) => Type::Double,
            Value::Vector3d(_) => Type::Vector3d,
            Value::Vector6d(_) => Type::Vector6d,
            Value::Vector6Int32(_) => Type::Vector6Int32,
            Value::Vector6Uint32(_) => Type::Vector6Uint32,
        }
    }

    /// Appends its bytes.
    pub fn write(&self, to: &mut Vec<u8>) {
        match self {
            Value::Bool(value) => to.push(u8::from(*value)),
            Value::Uint8(value) => to.push(*value),
            Value::Uint32(value) => to.extend(value.to_be_bytes()),
            Value::Uint64(value) => to.extend(value.to_be_bytes()),
            Value::Int32(value) => to.extend(value.to_be_bytes()),
            Value::Double(value) => to.extend(value.to_be_bytes()),
            Value::Vector3d(values) => to.extend(values.iter().flat_map(|value| value.to_be_bytes())),
            Value::Vector6d(values) => to.extend(values.iter().flat_map(|value| value.to_be_bytes())),
            Value::Vector6Int32(values) => to.extend(values.iter().flat_map(|value| value.to_be_bytes())),
            Value::Vector6Uint32(values) => to.extend(values.iter().flat_map(|value| value.to_be_bytes())),
        }
    }
}

/// Values in the order of a recipe, read from the front of their bytes. Each method is `None` where too few are left.
#[derive(Clone, Copy, Debug)]
pub struct Values<'b>(pub &'b [u8]);

impl Values<'_> {
    /// Whether all bytes have been read.
    #[must_use]
    pub const fn is_over(&self) -> bool {
        self.0.is_empty()
    }

    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*first)
    }

    fn several<T: Copy + Default, const M: usize>(
        &mut self,
        one: impl Fn(&mut Self) -> Option<T>,
    ) -> Option<[T; M]> {
        let mut values = [T::default(); M];
        for value in &mut values {
            *value = one(self)?;
        }
        Some(values)
    }

    /// The next one, of this type.
    pub fn value(&mut self, of: Type) -> Option<Value> {
        Some(match of {
            Type::Bool => Value::Bool(self.u8()? != 0),
            Type::Uint8 => Value::Uint8(self.u8()?),
            Type::Uint32 => Value::Uint32(self.u32()?),
            Type::Uint64 => Value::Uint64(self.u64()?),
            Type::Int32 => Value::Int32(self.i32()?),
            Type::Double => Value::Double(self.f64()?),
            Type::Vector3d => Value::Vector3d(self.doubles()?),
            Type::Vector6d => Value::Vector6d(self.doubles()?),
            Type::Vector6Int32 => Value::Vector6Int32(self.several(Self::i32)?),
            Type::Vector6Uint32 => Value::Vector6Uint32(self.several(Self::u32)?),
        })
    }

    /// The next byte.
    pub fn u8(&mut self) -> Option<u8> {
        self.take().map(u8::from_be_bytes)
    }

    /// The next two bytes.
    pub fn u16(&mut self) -> Option<u16> {
        self.take().map(u16::from_be_bytes)
    }

    /// The next number of 32 bits.
    pub fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_be_bytes)
    }

    /// The next number of 64 bits.
    pub fn u64(&mut self) -> Option<u64> {
        self.take().map(u64::from_be_bytes)
    }

    /// The next number of 32 bits with a sign.
    pub fn i32(&mut self) -> Option<i32> {
        self.take().map(i32::from_be_bytes)
    }

    /// The next double.
    pub fn f64(&mut self) -> Option<f64> {
        self.take().map(f64::from_be_bytes)
    }

    /// The next doubles.
    pub fn doubles<const M: usize>(&mut self) -> Option<[f64; M]> {
        self.several(Self::f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_every_type_have_their_sizes_and_are_read_back() {
        let values = [
            Value::Bool(true),
            Value::Uint8(200),
            Value::Uint32(0xdead_beef),
            Value::Uint64(1 << 60),
            Value::Int32(-2),
            Value::Double(-0.1),
            Value::Vector3d([1.0, 2.0, 3.0]),
            Value::Vector6d([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]),
            Value::Vector6Int32([-3, -2, -1, 0, 1, 2]),
            Value::Vector6Uint32([6, 5, 4, 3, 2, 1]),
        ];
        let mut bytes = Vec::new();
        for (value, of) in values.iter().zip(Type::ALL) {
            let before = bytes.len();
            value.write(&mut bytes);
            assert_eq!((value.of(), bytes.len() - before), (of, of.size()));
            assert_eq!(of.name().parse(), Ok(Offer::Has(of)));
        }
        let mut read = Values(&bytes);
        for value in values {
            assert_eq!(read.value(value.of()), Some(value));
        }
        assert!(read.is_over());
        assert_eq!(read.value(Type::Bool), None);
        // Big-endian, as UR's guide says: -0.1 is 0xbfb999999999999a.
        let mut double = Vec::new();
        Value::Double(-0.1).write(&mut double);
        assert_eq!(double, [0xbf, 0xb9, 0x99, 0x99, 0x99, 0x99, 0x99, 0x9a]);
    }
}
