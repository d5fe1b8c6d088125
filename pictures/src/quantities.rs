//! The quantities of a reading: what its words are, as its [`Shape`] says.
//!
//! In: the shape of a sensor's readings. Out: groups of numbers, one for each chart, and states, one for each row of bands.
//! Units are told where a shape has them: forces \[N\] and torques \[N m\] of wrenches, positions \[m\] of poses. What a
//! shape says nothing about is not drawn, and counted.

use mrroc::payload::Shape;
use mrroc::payload::WORDS;

/// The most groups of a reading, and the most numbers of a group.
const GROUPS: usize = 12;
const NUMBERS: usize = 8;

/// A number of a reading.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Number {
    pub label: String,
    /// Its place among the words of the reading, from 0.
    pub word: usize,
    format: Format,
}

/// What the bits of a word are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Float,
    Single,
    Unsigned,
    Signed,
}

impl Number {
    /// Its value in a reading of these words; not a number where there are too few.
    pub fn value(&self, words: &[u64]) -> f64 {
        let Some(word) = words.get(self.word) else { return f64::NAN };
        match self.format {
            Format::Float => f64::from_bits(*word),
            Format::Single => u32::try_from(*word).map_or(f64::NAN, |bits| f64::from(f32::from_bits(bits))),
            Format::Unsigned => *word as f64,
            Format::Signed => word.cast_signed() as f64,
        }
    }
}

/// Numbers of one chart.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Group {
    pub heading: String,
    /// Empty where the shape tells none.
    pub unit: &'static str,
    pub numbers: Vec<Number>,
}

/// A state of a reading: on or off, or one of some names.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Choice {
    pub label: String,
    /// Its place among the words of the reading, from 0.
    pub word: usize,
    /// The names of its states; nothing where it is on or off.
    pub names: Option<Vec<&'static str>>,
}

/// All quantities of a reading.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Quantities {
    pub groups: Vec<Group>,
    pub choices: Vec<Choice>,
    /// How many words are not drawn.
    pub undrawn: usize,
}

impl Quantities {
    /// Of readings of this shape.
    pub fn of(shape: &Shape) -> Quantities {
        let mut quantities = Quantities::default();
        quantities.take(shape, &[], 0);
        quantities
    }

    /// How many numbers there are in all groups.
    pub fn numbers(&self) -> impl Iterator<Item = &Number> {
        self.groups.iter().flat_map(|group| &group.numbers)
    }

    fn take(&mut self, shape: &Shape, path: &[String], word: usize) {
        match shape {
            Shape::Float | Shape::Single | Shape::Unsigned | Shape::Signed => {
                let number = Number {
                    label: "value".to_owned(),
                    word,
                    format: format(shape).unwrap_or(Format::Float),
                };
                self.group(heading(path, "reading"), "", vec![number]);
            }
            Shape::Truth => self.choice(path, word, None),
            Shape::Choice(names) => self.choice(path, word, Some(names.to_vec())),
            Shape::Variants(variants) => {
                self.choice(path, word, Some(variants.iter().map(|(name, _)| *name).collect()));
                self.undrawn += shape.len() - 1;
            }
            Shape::Array(item, count) => self.take_array(item, *count, path, word),
            Shape::Fields(fields) => self.take_fields(shape, fields, path, word),
            Shape::Demand | Shape::Words(_) => self.undrawn += shape.len(),
        }
    }

    fn take_array(&mut self, item: &Shape, count: usize, path: &[String], word: usize) {
        if let Some(format) = format(item) {
            for first in (0..count).step_by(NUMBERS) {
                let end = (first + NUMBERS).min(count);
                let numbers =
                    (first..end).map(|i| Number { label: format!("{}", i + 1), word: word + i, format });
                let named = heading(path, "reading");
                let heading =
                    if count > NUMBERS { format!("{named}, {} to {end}", first + 1) } else { named };
                self.group(heading, "", numbers.collect());
            }
            return;
        }
        // More than can be drawn need not be looked at.
        let looked = count.min(WORDS);
        for i in 0..looked {
            self.take(item, &with(path, &format!("{}", i + 1)), word + i * item.len());
        }
        self.undrawn += (count - looked) * item.len();
    }

    fn take_fields(&mut self, shape: &Shape, fields: &[(&str, &Shape)], path: &[String], word: usize) {
        let axes = |of: [&str; 3], first: usize| {
            let number = |(i, label): (usize, &&str)| Number {
                label: (*label).to_owned(),
                word: first + i,
                format: Format::Float,
            };
            of.iter().enumerate().map(number).collect::<Vec<_>>()
        };
        if is_wrench(fields) {
            self.group(heading(&with(path, "force"), ""), "N", axes(["x", "y", "z"], word));
            self.group(heading(&with(path, "torque"), ""), "N m", axes(["x", "y", "z"], word + 3));
            return;
        }
        if shape == Shape::POSE {
            self.group(heading(&with(path, "position"), ""), "m", axes(["x", "y", "z"], word));
            let mut turn = axes(["x", "y", "z"], word + 3);
            turn.push(Number { label: "w".to_owned(), word: word + 6, format: Format::Float });
            self.group(heading(&with(path, "orientation (unit quaternion)"), ""), "", turn);
            return;
        }
        // A value in a type of its own.
        if let [("0", shape)] = fields {
            self.take(shape, path, word);
            return;
        }
        // Fields of one letter are coordinates: they are of one kind.
        let coordinates: Option<Vec<Format>> =
            fields.iter().map(|(name, shape)| format(shape).filter(|_| name.len() == 1)).collect();
        if let Some(formats) = coordinates.filter(|formats| (2..=NUMBERS).contains(&formats.len())) {
            let numbers = fields.iter().zip(formats).enumerate();
            let numbers = numbers.map(|(i, ((name, _), format))| Number {
                label: (*name).to_owned(),
                word: word + i,
                format,
            });
            self.group(heading(path, "reading"), "", numbers.collect());
            return;
        }
        let mut word = word;
        for (name, shape) in fields {
            self.take(shape, &with(path, name), word);
            word += shape.len();
        }
    }

    fn group(&mut self, heading: String, unit: &'static str, numbers: Vec<Number>) {
        if self.groups.len() < GROUPS {
            self.groups.push(Group { heading, unit, numbers });
        } else {
            self.undrawn += numbers.len();
        }
    }

    fn choice(&mut self, path: &[String], word: usize, names: Option<Vec<&'static str>>) {
        if self.choices.len() < GROUPS {
            self.choices.push(Choice { label: heading(path, "reading").to_lowercase(), word, names });
        } else {
            self.undrawn += 1;
        }
    }
}

fn format(shape: &Shape) -> Option<Format> {
    match shape {
        Shape::Float => Some(Format::Float),
        Shape::Single => Some(Format::Single),
        Shape::Unsigned => Some(Format::Unsigned),
        Shape::Signed => Some(Format::Signed),
        Shape::Truth
        | Shape::Choice(_)
        | Shape::Variants(_)
        | Shape::Array(..)
        | Shape::Fields(_)
        | Shape::Demand
        | Shape::Words(_) => None,
    }
}

fn is_wrench(fields: &[(&str, &Shape)]) -> bool {
    let three = Shape::Array(&Shape::Float, 3);
    let [(force, forces), (torque, torques)] = fields else { return false };
    (*force, *torque) == ("force", "torque") && **forces == three && **torques == three
}

fn with(path: &[String], name: &str) -> Vec<String> {
    path.iter().cloned().chain([name.replace('_', " ")]).collect()
}

/// The names on the path to a quantity, the first letter a capital.
fn heading(path: &[String], unnamed: &str) -> String {
    let named = if path.is_empty() { unnamed.to_owned() } else { path.join(", ") };
    let mut letters = named.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::payload::Wire;
    use mrroc::pose::{Pose, Wrench};
    use nalgebra::Vector3;

    fn words<T: Wire>(value: &T) -> Vec<u64> {
        let mut words = vec![0; T::LEN];
        value.put(&mut words);
        words
    }

    type Labelled = Vec<(String, f64)>;

    fn told(quantities: &Quantities, words: &[u64]) -> Vec<(String, &'static str, Labelled)> {
        let group = |group: &Group| {
            let numbers = group.numbers.iter().map(|number| (number.label.clone(), number.value(words)));
            (group.heading.clone(), group.unit, numbers.collect())
        };
        quantities.groups.iter().map(group).collect()
    }

    fn labelled(labels: &[&str], values: &[f64]) -> Labelled {
        labels.iter().map(|label| (*label).to_owned()).zip(values.iter().copied()).collect()
    }

    #[test]
    fn a_wrench_is_a_force_and_a_torque_with_their_units() {
        let wrench = Wrench::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.4, 0.5, 0.6));
        let quantities = Quantities::of(Wrench::SHAPE);
        assert_eq!(
            told(&quantities, &words(&wrench)),
            [
                ("Force".to_owned(), "N", labelled(&["x", "y", "z"], &[1.0, 2.0, 3.0])),
                ("Torque".to_owned(), "N m", labelled(&["x", "y", "z"], &[0.4, 0.5, 0.6])),
            ]
        );
        assert_eq!(quantities.undrawn, 0);
    }

    #[test]
    fn a_pose_is_a_position_in_metres_and_a_quaternion() {
        let found = told(&Quantities::of(Pose::SHAPE), &words(&Pose::translation(0.1, 0.2, 0.3)));
        assert_eq!(found[0], ("Position".to_owned(), "m", labelled(&["x", "y", "z"], &[0.1, 0.2, 0.3])));
        assert_eq!(found[1].2, labelled(&["x", "y", "z", "w"], &[0.0, 0.0, 0.0, 1.0]));
    }

    /// Fields one after another, nested and not: each number is the word that it was put into.
    #[test]
    fn fields_have_charts_of_their_own_and_states_have_rows() {
        const SHAPE: Shape = Shape::Fields(&[
            ("is_seen", &Shape::Truth),
            ("kind_of", &Shape::Choice(&["bolt", "nut"])),
            ("at", &Shape::Fields(&[("x", &Shape::Float), ("y", &Shape::Single)])),
            ("grip", Wrench::SHAPE),
            ("count", &Shape::Signed),
            ("raw", &Shape::Words(3)),
            ("rows", &Shape::Array(&Shape::Unsigned, 10)),
        ]);
        let mut words = vec![1, 1, 2.5_f64.to_bits(), u64::from(1.5_f32.to_bits())];
        words.extend((0..6).map(|i| f64::from(i).to_bits()));
        words.extend([(-7_i64).cast_unsigned(), 99, 99, 99]);
        words.extend(0..10);
        assert_eq!(words.len(), SHAPE.len());
        let quantities = Quantities::of(&SHAPE);
        let found = told(&quantities, &words);
        let headings: Vec<_> = found.iter().map(|(heading, unit, _)| (heading.as_str(), *unit)).collect();
        assert_eq!(
            headings,
            [
                ("At", ""),
                ("Grip, force", "N"),
                ("Grip, torque", "N m"),
                ("Count", ""),
                ("Rows, 1 to 8", ""),
                ("Rows, 9 to 10", "")
            ]
        );
        assert_eq!(found[0].2, labelled(&["x", "y"], &[2.5, 1.5]));
        assert_eq!(found[2].2, labelled(&["x", "y", "z"], &[3.0, 4.0, 5.0]));
        assert_eq!(found[3].2, labelled(&["value"], &[-7.0]));
        assert_eq!(found[5].2, labelled(&["9", "10"], &[8.0, 9.0]));
        let choices: Vec<_> =
            quantities.choices.iter().map(|choice| (choice.label.as_str(), choice.word)).collect();
        assert_eq!(choices, [("is seen", 0), ("kind of", 1)]);
        assert_eq!(quantities.choices[1].names, Some(vec!["bolt", "nut"]));
        assert_eq!(quantities.undrawn, 3);
    }

    #[test]
    fn more_than_a_page_bears_is_counted_and_not_drawn() {
        let quantities = Quantities::of(&Shape::Array(&Shape::Float, 100));
        assert_eq!(quantities.numbers().count() + quantities.undrawn, 100);
        assert_eq!(quantities.groups.len(), GROUPS);
        assert!(quantities.numbers().all(|number| number.value(&[]).is_nan()));
    }
}
