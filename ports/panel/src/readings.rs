//! Readings of virtual sensors as numbers with names, for plots and arrows.
//!
//! In: the shape of a reading, and its words. Out: a name for each number, such as `force.x`, and the
//! numbers in the same order. What a name chooses is the place of that name; texts and what a shape does not tell are left out.

use mrroc_core::payload::Shape;

/// The most numbers of a reading that are shown: those of a picture that was taken would fill the page.
const MOST: usize = 32;

/// What is older is not shown \[ns\]: an arrow would tell of what is no longer so.
pub const OLD: u64 = 1_000_000_000;

/// The name of each number of a reading.
#[must_use]
pub fn names(shape: &Shape) -> Vec<String> {
    let mut names = Vec::new();
    name(shape, "", &mut names);
    names.truncate(MOST);
    if is_wrench(shape) {
        let of = |part: &str| ["x", "y", "z"].map(|axis| format!("{part}.{axis}"));
        names = [of("force"), of("torque")].concat();
    }
    names
}

fn name(shape: &Shape, at: &str, names: &mut Vec<String>) {
    // Of the numbers of an array that is longer the first ones are enough.
    if names.len() >= MOST {
        return;
    }
    match shape {
        Shape::Float
        | Shape::Single
        | Shape::Unsigned
        | Shape::Signed
        | Shape::Truth
        | Shape::Choice(_)
        | Shape::Variants(_) => names.push(if at.is_empty() { "value".to_owned() } else { at.to_owned() }),
        Shape::Array(item, count) => {
            (0..(*count).min(MOST)).for_each(|i| name(item, &format!("{at}[{i}]"), names));
        }
        Shape::Fields(fields) => {
            for (field, shape) in *fields {
                let dot = if at.is_empty() { "" } else { "." };
                name(shape, &format!("{at}{dot}{field}"), names);
            }
        }
        Shape::Demand | Shape::Words(_) => {}
    }
}

/// The numbers of a reading in words; a number that is missing or not finite is `None`.
#[must_use]
pub fn of_words(shape: &Shape, words: &[u64]) -> Vec<Option<f64>> {
    let mut numbers = Vec::new();
    words_of(shape, words, &mut numbers);
    numbers.truncate(MOST);
    numbers
}

fn words_of(shape: &Shape, words: &[u64], numbers: &mut Vec<Option<f64>>) {
    if numbers.len() >= MOST {
        return;
    }
    let word = words.first().copied();
    match shape {
        Shape::Float => numbers.push(word.map(f64::from_bits).filter(|x| x.is_finite())),
        Shape::Single => {
            let single = word.map(|word| f64::from(f32::from_bits(word as u32)));
            numbers.push(single.filter(|x| x.is_finite()));
        }
        Shape::Signed => numbers.push(word.map(|word| word.cast_signed() as f64)),
        Shape::Unsigned | Shape::Truth | Shape::Choice(_) | Shape::Variants(_) => {
            numbers.push(word.map(|word| word as f64));
        }
        Shape::Array(item, count) => {
            let of = |i: usize| words.get(i * item.len()..).unwrap_or_default();
            (0..(*count).min(MOST)).for_each(|i| words_of(item, of(i), numbers));
        }
        Shape::Fields(fields) => {
            let mut rest = words;
            for (_, shape) in *fields {
                words_of(shape, rest, numbers);
                rest = rest.get(shape.len()..).unwrap_or_default();
            }
        }
        Shape::Demand | Shape::Words(_) => {}
    }
}

/// Whether a reading is a wrench: a force and a torque of three numbers each, and no more.
#[must_use]
pub fn is_wrench(shape: &Shape) -> bool {
    matches!(
        shape,
        Shape::Fields([("force", Shape::Array(Shape::Float, 3)), ("torque", Shape::Array(Shape::Float, 3))])
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc_core::nalgebra::Vector3;
    use mrroc_core::payload::Wire;
    use mrroc_core::pose::{Pose, Wrench};

    #[test]
    fn a_wrench_has_six_numbers_and_a_pose_is_none() {
        let wrench = Wrench::new(Vector3::new(1.0, -2.5, 3.0), Vector3::new(f64::NAN, 0.5, -0.25));
        let mut words = [0; Wrench::LEN];
        wrench.put(&mut words);
        let expected = [Some(1.0), Some(-2.5), Some(3.0), None, Some(0.5), Some(-0.25)];
        assert_eq!(of_words(Wrench::SHAPE, &words), expected);
        let named = names(Wrench::SHAPE);
        assert_eq!(named, ["force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z"]);
        assert!(is_wrench(Wrench::SHAPE) && !is_wrench(Pose::SHAPE) && !is_wrench(&Shape::Float));
    }

    #[test]
    fn every_shape_has_as_many_numbers_as_names_however_little_is_there() {
        const LIST: Shape = Shape::Array(&Shape::Signed, 3);
        const LONG: Shape = Shape::Array(&Shape::Float, 1000);
        const MIXED: Shape = Shape::Fields(&[
            ("seen", &Shape::Truth),
            ("how", &Shape::Choice(&["near", "far"])),
            ("list", &LIST),
            ("what", &Shape::Variants(&[("none", &Shape::Words(0)), ("some", &Shape::Float)])),
            ("text", &Shape::Words(2)),
            ("last", &Shape::Single),
        ]);
        let named = names(&MIXED);
        assert_eq!(named, ["seen", "how", "list[0]", "list[1]", "list[2]", "what", "last"]);
        let minus = (-4_i64).cast_unsigned();
        let words = [1, 1, minus, 5, 6, 1, 7, 8, 9, u64::from(0.5_f32.to_bits())];
        let expected = [1.0, 1.0, -4.0, 5.0, 6.0, 1.0, 0.5].map(Some);
        assert_eq!(of_words(&MIXED, &words), expected);
        for shape in [&MIXED, &LONG, &LIST, &Shape::Float, &Shape::Demand] {
            let count = names(shape).len();
            assert!(count <= MOST);
            assert_eq!(of_words(shape, &[]).len(), count);
        }
    }
}
