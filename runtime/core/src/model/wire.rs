//! Plain numbers on the wire: how payloads, readings and demands become words and come back checked.
//!
//! A message body is [`WORDS`] words of 64 bits. Nothing is reinterpreted: every value is written and read
//! field by field, so that a corrupted or foreign message is an error and never undefined behaviour.

use nalgebra::{SVector, Translation3, UnitQuaternion, Vector3};

use crate::model::pose::Pose;
use crate::model::shape::Shape;

/// Words in the body of a message.
pub const WORDS: usize = 64;

/// Words that do not spell a value of the type asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the words of the message are no value of its type")]
pub struct BadWords;

/// A plain value of a fixed number of words.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no plain value",
    label = "cannot be sent as words",
    note = "plain are numbers, `bool`, arrays and vectors of them, poses, and types that `#[derive(Clone, Copy, mrroc::payload::Payload)]`"
)]
pub trait Wire: Copy + 'static {
    /// Words taken, at most [`WORDS`].
    const LEN: usize;

    /// A hash of the type's name and fields: two processes that disagree about a type see different layouts.
    const LAYOUT: u64;

    /// What the words say, for those who look at a recording; unless a type says more, that they are words.
    const SHAPE: &'static Shape = &Shape::Words(Self::LEN);

    /// Writes the value into the first [`LEN`](Wire::LEN) words.
    fn put(&self, words: &mut [u64]);

    /// How many of these words say what the value is, where the last ones may say nothing: they need not be sent.
    fn used(&self) -> usize {
        Self::LEN
    }

    /// Reads the value from the first [`LEN`](Wire::LEN) words.
    ///
    /// # Errors
    /// [`BadWords`] when they spell none.
    fn get(words: &[u64]) -> Result<Self, BadWords>;
}

/// FNV-1a over a text, continued from `seed`: the layout hash of the `Payload` derive.
#[must_use]
pub const fn layout_hash(seed: u64, text: &str) -> u64 {
    let bytes = text.as_bytes();
    let mut hash = seed ^ 0xcbf2_9ce4_8422_2325;
    let mut i = 0;
    while i < bytes.len() {
        hash = (hash ^ bytes[i] as u64).wrapping_mul(0x0100_0000_01b3);
        i += 1;
    }
    hash
}

macro_rules! wire_numbers {
    ($($number:ty, $shape:ident: $to:expr, $from:expr;)*) => {$(
        #[allow(clippy::redundant_closure_call)] // some are closures, some are functions
        impl Wire for $number {
            const LEN: usize = 1;
            const LAYOUT: u64 = layout_hash(0, stringify!($number));
            const SHAPE: &'static Shape = &Shape::$shape;
            fn put(&self, words: &mut [u64]) {
                const TO: fn($number) -> u64 = $to;
                words[0] = TO(*self);
            }
            fn get(words: &[u64]) -> Result<Self, BadWords> {
                const FROM: fn(u64) -> Option<$number> = $from;
                words.first().copied().and_then(FROM).ok_or(BadWords)
            }
        }
    )*};
}

wire_numbers! {
    f64, Float: f64::to_bits, |word| Some(f64::from_bits(word));
    f32, Single: |x| u64::from(x.to_bits()), |word| u32::try_from(word).ok().map(f32::from_bits);
    u64, Unsigned: |x| x, Some;
    u32, Unsigned: u64::from, |word| u32::try_from(word).ok();
    u16, Unsigned: u64::from, |word| u16::try_from(word).ok();
    u8, Unsigned: u64::from, |word| u8::try_from(word).ok();
    i64, Signed: i64::cast_unsigned, |word| Some(word.cast_signed());
    i32, Signed: |x| i64::from(x).cast_unsigned(), |word| i32::try_from(word.cast_signed()).ok();
    bool, Truth: u64::from, |word| match word { 0 => Some(false), 1 => Some(true), _ => None };
}

impl Wire for () {
    const LEN: usize = 0;
    const LAYOUT: u64 = layout_hash(0, "()");
    const SHAPE: &'static Shape = &Shape::Fields(&[]);
    fn put(&self, _: &mut [u64]) {}
    fn get(_: &[u64]) -> Result<Self, BadWords> {
        Ok(())
    }
}

impl<T: Wire, const N: usize> Wire for [T; N] {
    const LEN: usize = N * T::LEN;
    const LAYOUT: u64 = layout_hash(T::LAYOUT.wrapping_add(N as u64), "array");
    const SHAPE: &'static Shape = &Shape::Array(T::SHAPE, N);
    fn put(&self, words: &mut [u64]) {
        for (item, chunk) in self.iter().zip(words.chunks_exact_mut(T::LEN.max(1))) {
            item.put(chunk);
        }
    }
    fn get(words: &[u64]) -> Result<Self, BadWords> {
        let mut items = [T::get(words)?; N];
        for (i, item) in items.iter_mut().enumerate().skip(1) {
            *item = T::get(words.get(i * T::LEN..).ok_or(BadWords)?)?;
        }
        Ok(items)
    }
}

impl<const N: usize> Wire for SVector<f64, N> {
    const LEN: usize = N;
    const LAYOUT: u64 = layout_hash(N as u64, "vector");
    const SHAPE: &'static Shape = &Shape::Array(&Shape::Float, N);
    fn put(&self, words: &mut [u64]) {
        for (x, word) in self.iter().zip(words) {
            *word = x.to_bits();
        }
    }
    fn get(words: &[u64]) -> Result<Self, BadWords> {
        if words.len() < N {
            return Err(BadWords);
        }
        Ok(SVector::from_fn(|i, _| f64::from_bits(words[i])))
    }
}

impl Wire for Pose {
    const LEN: usize = 7;
    const LAYOUT: u64 = layout_hash(0, "pose");
    const SHAPE: &'static Shape = Shape::POSE;
    fn put(&self, words: &mut [u64]) {
        let (p, q) = (&self.translation, &self.rotation);
        for (word, x) in words.iter_mut().zip([p.x, p.y, p.z, q.i, q.j, q.k, q.w]) {
            *word = x.to_bits();
        }
    }
    /// The quaternion comes as it was sent, normalised or not: whoever acts on a pose checks it first.
    fn get(words: &[u64]) -> Result<Self, BadWords> {
        if words.len() < 7 {
            return Err(BadWords);
        }
        let x = |i: usize| f64::from_bits(words[i]);
        let rotation = nalgebra::Quaternion::new(x(6), x(3), x(4), x(5));
        Ok(Pose::from_parts(
            Translation3::from(Vector3::new(x(0), x(1), x(2))),
            UnitQuaternion::new_unchecked(rotation),
        ))
    }
}
