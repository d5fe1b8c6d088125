//! The numbers of a reading: which of its words they are, what they are called, and whether they may be believed.
//!
//! In: the shape of a reading, and what the cell file allows. Out: for the words of a reading, nothing, or the first number
//! that is not to be believed.

use mrroc::fault::{Fault, FaultKind};
use mrroc::payload::Shape;
use mrroc_launch::cell_file::Believable;

/// One number of a reading.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Number {
    /// Such as `position.x`.
    name: String,
    /// Its word.
    at: usize,
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Float,
    Single,
    Unsigned,
    Signed,
}

impl Number {
    fn value(&self, words: &[u64]) -> f64 {
        let word = words[self.at];
        match self.kind {
            Kind::Float => f64::from_bits(word),
            Kind::Single => f32::from_bits(word as u32).into(),
            Kind::Unsigned => word as f64,
            Kind::Signed => word.cast_signed() as f64,
        }
    }
}

/// The numbers of a reading, and what they may be.
#[derive(Clone, Debug)]
pub(crate) struct Numbers {
    numbers: Vec<Number>,
    believable: Believable,
}

/// The names of the numbers of a reading of this shape; `None` if one of its words may be anything.
pub(crate) fn names(shape: &Shape) -> Option<Vec<String>> {
    Some(numbers(shape)?.into_iter().map(|number| number.name).collect())
}

fn numbers(shape: &Shape) -> Option<Vec<Number>> {
    let mut found = Vec::new();
    let mut at = 0;
    push(shape, "", &mut at, &mut found).then_some(found)
}

/// Adds the numbers of a shape that begins at this word; `false` if one of its words may be anything.
fn push(shape: &Shape, name: &str, at: &mut usize, found: &mut Vec<Number>) -> bool {
    let mut add = |kind| {
        let name = if name.is_empty() { "value" } else { name };
        found.push(Number { name: name.to_owned(), at: *at, kind });
        *at += 1;
        true
    };
    match shape {
        Shape::Float => add(Kind::Float),
        Shape::Single => add(Kind::Single),
        Shape::Unsigned => add(Kind::Unsigned),
        Shape::Signed => add(Kind::Signed),
        // Their words are values of their types or none.
        Shape::Truth | Shape::Choice(_) => {
            *at += 1;
            true
        }
        Shape::Array(item, count) => (0..*count).all(|i| push(item, &format!("{name}[{i}]"), at, found)),
        Shape::Fields(fields) => fields.iter().all(|(field, shape)| {
            let dot = if name.is_empty() { "" } else { "." };
            push(shape, &format!("{name}{dot}{field}"), at, found)
        }),
        Shape::Variants(_) | Shape::Demand | Shape::Words(_) => false,
    }
}

impl Numbers {
    /// Of a reading of this shape, all of whose words are known; `believable` has one entry for each number.
    pub fn new(shape: &Shape, believable: Believable) -> Option<Numbers> {
        Some(Numbers { numbers: numbers(shape)?, believable })
    }

    /// Of a reading whose numbers may be anything.
    pub const fn unbounded() -> Numbers {
        let believable = Believable { least: Vec::new(), largest: Vec::new(), per_second: None };
        Numbers { numbers: Vec::new(), believable }
    }

    /// Looks at the words of a reading, and at the last one that was believed, with the time between the two \[s\].
    pub fn check(&self, words: &[u64], last: Option<(&[u64], f64)>) -> Result<(), Fault> {
        for (i, number) in self.numbers.iter().enumerate() {
            let x = number.value(words);
            let fault = |what: &str, limit: f64| {
                let text = format!("`{}` {what}", number.name);
                Err(Fault::new(FaultKind::SensorFailed).text(&text).exceeds(x, limit, ""))
            };
            let (least, largest) = (self.believable.least[i], self.believable.largest[i]);
            if !x.is_finite() {
                return fault("is not finite", largest);
            }
            if x < least {
                return fault("is below its range", least);
            }
            if x > largest {
                return fault("is above its range", largest);
            }
            if let (Some(rates), Some((before, time))) = (&self.believable.per_second, last) {
                let before = number.value(before);
                let may = rates[i] * time;
                if (x - before).abs() > may {
                    return fault("jumps", before + may.copysign(x - before));
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPE: Shape = Shape::Fields(&[
        ("seen", &Shape::Truth),
        ("at", &Shape::Fields(&[("x", &Shape::Float), ("count", &Shape::Signed)])),
        ("pair", &Shape::Array(&Shape::Single, 2)),
    ]);

    fn numbers_of(per_second: Option<Vec<f64>>) -> Numbers {
        let believable = Believable { least: vec![-1.0; 4], largest: vec![2.0, 3.0, 2.0, 2.0], per_second };
        Numbers::new(&SHAPE, believable).expect("all words are known")
    }

    fn words(x: f64, count: i64, pair: [f32; 2]) -> [u64; 5] {
        let [a, b] = pair.map(|x| x.to_bits().into());
        [1, x.to_bits(), count.cast_unsigned(), a, b]
    }

    #[test]
    fn numbers_have_the_names_of_their_fields_and_what_is_no_number_has_none() {
        let names = names(&SHAPE).expect("all words are known");
        assert_eq!(names, ["at.x", "at.count", "pair[0]", "pair[1]"]);
        assert_eq!(super::names(&Shape::Float).expect("known"), ["value"]);
        assert_eq!(super::names(&Shape::Fields(&[("any", &Shape::Words(2))])), None);
    }

    #[test]
    fn fault_121_a_number_beyond_what_the_cell_file_allows_is_named() {
        let numbers = numbers_of(None);
        assert_eq!(numbers.check(&words(2.0, 3, [-1.0, 2.0]), None), Ok(()));
        for (words, told) in [
            (words(2.1, 0, [0.0; 2]), "`at.x` is above its range"),
            (words(0.0, -2, [0.0; 2]), "`at.count` is below its range"),
            (words(0.0, 0, [0.0, 2.5]), "`pair[1]` is above its range"),
            (words(f64::NAN, 0, [0.0; 2]), "`at.x` is not finite"),
            (words(0.0, 0, [f32::INFINITY, 0.0]), "`pair[0]` is not finite"),
        ] {
            let fault = numbers.check(&words, None).expect_err(told).to_string();
            assert!(fault.contains(told), "{fault}");
        }
    }

    #[test]
    fn fault_121_a_number_that_changes_faster_than_it_may_is_named() {
        let numbers = numbers_of(Some(vec![10.0, 1e3, 1e3, 1e3]));
        let (before, after) = (words(0.0, 0, [0.0; 2]), words(0.5, 0, [0.0; 2]));
        assert_eq!(numbers.check(&after, Some((&before, 0.05))), Ok(()), "10 per second for 50 ms");
        let told = numbers.check(&after, Some((&before, 0.049))).expect_err("a jump").to_string();
        assert!(told.contains("`at.x` jumps"), "{told}");
    }
}
