//! The comparison of a replay's demands with the recorded demands.
//!
//! In: the images of a replay. Out: how many steps were compared, and the first step, robot and joint with demands that are
//! not the same to the bit.

use core::cell::{Cell, RefCell};
use core::fmt;
use std::rc::Rc;

use mrroc_core::fault::ProcessId;
use mrroc_core::fault::{Fault, Name};
use mrroc_core::link::Nanos;
use mrroc_core::observe::step_observer::{StepEvent, StepObserver};

use mrroc_core::replay::RecordedRun;

/// A demand that differs from the recorded demand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Index of the step.
    pub step: u64,
    /// The robot.
    pub robot: Name,
    /// Index of the joint, from 0.
    pub joint: usize,
    /// The position that the recorded run demanded of the joint [rad or m].
    pub recorded: f64,
    /// The position that the replay demanded of the joint [rad or m].
    pub replayed: f64,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Difference { step, robot, joint, recorded, replayed } = self;
        write!(f, "step {step}, {robot} joint {}: recorded {recorded:?}, replayed {replayed:?}", joint + 1)
    }
}

/// Compares the demands of a replay with a recording's.
pub(crate) struct Comparison {
    recorded: Rc<RecordedRun>,
    /// The last step that is compared.
    last: u64,
    /// The last of the compared steps that the MP began.
    begun: Cell<u64>,
    /// How many images of robots had the recorded demands.
    compared: Cell<u64>,
    first: RefCell<Option<Difference>>,
}

/// The result of a comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Compared {
    /// Number of steps that the MP began both in the recorded run and in the replay.
    pub steps: u64,
    /// Number of compared steps, counted for each robot.
    pub images: u64,
    /// The first demand that differs from the recorded demand.
    pub difference: Option<Difference>,
    /// The last step of the recording, if the replay's programs ended before it.
    pub longer: Option<u64>,
    /// The fault that ended the replay, if one did.
    pub fault: Option<String>,
    /// The fault from outside, such as a drive's fault, at which the comparison ended.
    pub outside: Option<String>,
    /// How the recorded run ended: `Some(None)` without a fault, `Some(Some(text))` with a fault, `None` if the
    /// recording was cut off.
    pub end: Option<Option<String>>,
}

impl Compared {
    /// Whether the replay made every demand of the recording again.
    #[must_use]
    pub const fn is_identical(&self) -> bool {
        self.difference.is_none() && self.longer.is_none() && self.images > 0
    }
}

impl Comparison {
    pub fn with(recorded: Rc<RecordedRun>) -> Comparison {
        let last = recorded.last();
        let (begun, compared, first) = (Cell::new(0), Cell::new(0), RefCell::new(None));
        Comparison { recorded, last, begun, compared, first }
    }

    /// What has been found, of a replay that ended with this fault or without one.
    pub fn outcome(&self, fault: Option<&Fault>) -> Compared {
        let difference = *self.first.borrow();
        let steps =
            self.recorded.script.steps.iter().filter(|scripted| scripted.step <= self.begun.get()).count();
        // The MP may have left out the last steps of the recording.
        let due = self.recorded.script.last_until(self.last);
        let is_short = difference.is_none() && self.begun.get() < due;
        Compared {
            steps: steps as u64,
            images: self.compared.get(),
            difference,
            longer: is_short.then_some(self.last),
            fault: fault.map(ToString::to_string),
            outside: self.recorded.outside.as_ref().map(|(_, text)| text.clone()),
            end: self.recorded.end.clone(),
        }
    }

    /// Compares the demanded joint positions of an image, which are its first words.
    fn compare(&self, robot: Name, step: u64, words: &[u64]) {
        let Some(recorded) = self.recorded.robot(robot.as_str()) else { return };
        let Some(image) = recorded.image(step).filter(|_| step <= self.last) else { return };
        let pairs = image.demanded.iter().zip(words).take(recorded.joints);
        let different = pairs.enumerate().find(|(_, (recorded, word))| recorded.to_bits() != **word);
        let Some((joint, (&recorded, &word))) = different else {
            self.compared.set(self.compared.get() + 1);
            return;
        };
        // Robots begin a step one after another, so of the differences in one step the robot first in the cell's order
        // counts.
        let found = Difference { step, robot, joint, recorded, replayed: f64::from_bits(word) };
        self.first.borrow_mut().get_or_insert(found);
    }
}

impl StepObserver for Comparison {
    fn see(&self, _: Nanos, by: ProcessId, what: &StepEvent, words: &[u64]) {
        match (*what, by.name) {
            (StepEvent::Image { step, .. }, Some(robot)) => self.compare(robot, step, words),
            (StepEvent::Step(record), _) => self.begun.set(record.step),
            _ => {}
        }
    }

    fn is_over(&self, step: u64) -> bool {
        step > self.last || self.first.borrow().is_some()
    }
}
