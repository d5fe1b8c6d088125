//! The values of a recorded run that its programs computed themselves: what one process recorded, one after another.

use core::cell::Cell;

use crate::model::name::Name;

/// What a program recorded once.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedValue {
    /// Under which name.
    pub name: Name,
    /// Its words, as they were recorded.
    pub words: Vec<u64>,
}

/// What the program of a process recorded, in the order in which it did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordedValues {
    /// The values.
    pub values: Vec<RecordedValue>,
    next: Cell<usize>,
}

impl RecordedValues {
    /// These values, of which none has been taken.
    pub fn of(values: Vec<RecordedValue>) -> RecordedValues {
        RecordedValues { values, next: Cell::new(0) }
    }

    /// The next value, if it has this name.
    pub fn next(&self, name: Name) -> Option<&[u64]> {
        let next = self.values.get(self.next.get()).filter(|value| value.name == name)?;
        self.next.set(self.next.get() + 1);
        Some(&next.words)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_come_in_their_order_and_under_their_names() {
        let [plan, goal] = ["plan", "goal"].map(|name| Name::new(name).expect("a name"));
        let value = |name, word| RecordedValue { name, words: vec![word] };
        let recorded = RecordedValues::of(vec![value(plan, 1), value(plan, 2), value(goal, 3)]);
        let found =
            [plan, goal, plan, plan, goal, goal].map(|name| recorded.next(name).map(|words| words[0]));
        assert_eq!(found, [Some(1), None, Some(2), None, Some(3), None]);
    }
}
