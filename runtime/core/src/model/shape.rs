//! What the words of a plain value say: how a recording shows orders and readings with the names of their fields.
//!
//! In: a type, through [`Wire::SHAPE`](crate::Wire::SHAPE). Out: the tree of its fields, one leaf for each word.

/// How the words of a [`Wire`](crate::payload::Wire) type are made up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One word: the bits of an `f64`.
    Float,
    /// One word: the bits of an `f32` below.
    Single,
    /// One word: an unsigned number.
    Unsigned,
    /// One word: a signed number.
    Signed,
    /// One word: 0 or 1.
    Truth,
    /// One word: the place of one of these names.
    Choice(&'static [&'static str]),
    /// One word, the place of one of these names, and the value that this name chooses; zeros to the longest value.
    Variants(&'static [(&'static str, &'static Shape)]),
    /// So many values of one shape.
    Array(&'static Shape, usize),
    /// Fields one after another.
    Fields(&'static [(&'static str, &'static Shape)]),
    /// The demand of a robot, of which only the part counts that its first word chooses.
    Demand,
    /// So many words of a type that does not say more.
    Words(usize),
}

impl Shape {
    /// Of a position \[m\] and a unit quaternion: `X` of any frame in another one.
    pub const POSE: &'static Shape = &Shape::Fields(&[
        ("position", &Shape::Fields(&[("x", &Shape::Float), ("y", &Shape::Float), ("z", &Shape::Float)])),
        (
            "orientation",
            &Shape::Fields(&[
                ("x", &Shape::Float),
                ("y", &Shape::Float),
                ("z", &Shape::Float),
                ("w", &Shape::Float),
            ]),
        ),
    ]);

    /// Words that a value takes.
    #[must_use]
    pub const fn len(&self) -> usize {
        match self {
            Shape::Float
            | Shape::Single
            | Shape::Unsigned
            | Shape::Signed
            | Shape::Truth
            | Shape::Choice(_) => 1,
            Shape::Array(item, count) => item.len() * *count,
            Shape::Fields(fields) => {
                let mut len = 0;
                let mut i = 0;
                while i < fields.len() {
                    len += fields[i].1.len();
                    i += 1;
                }
                len
            }
            Shape::Variants(variants) => {
                let mut longest = 0;
                let mut i = 0;
                while i < variants.len() {
                    let len = variants[i].1.len();
                    longest = if len > longest { len } else { longest };
                    i += 1;
                }
                1 + longest
            }
            Shape::Demand => 1 + crate::model::joints::MAX_JOINTS + 7 + 2,
            Shape::Words(len) => *len,
        }
    }

    /// Whether a value takes no words.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

#[cfg(test)]
mod tests {
    use crate::model::pose::Pose;
    use crate::model::sensor::EffectorState;
    use crate::model::wire::Wire;
    use crate::model::wrench::Wrench;

    fn takes_what_it_shows<T: Wire>() {
        assert_eq!(T::SHAPE.len(), T::LEN);
    }

    #[test]
    fn every_word_of_a_value_is_shown_once() {
        takes_what_it_shows::<()>();
        takes_what_it_shows::<f32>();
        takes_what_it_shows::<[[i32; 3]; 2]>();
        takes_what_it_shows::<nalgebra::SVector<f64, 5>>();
        takes_what_it_shows::<Pose>();
        takes_what_it_shows::<Wrench>();
        takes_what_it_shows::<EffectorState>();
        takes_what_it_shows::<crate::model::name::Name>();
        takes_what_it_shows::<crate::model::payload::Trigger>();
    }
}
