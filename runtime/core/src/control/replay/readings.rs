//! The readings of a recorded run: what one process collected of one sensor, one after another.

use core::cell::Cell;

use crate::link::message::{Kind, Message};
use crate::model::fault::ProcessId;
use crate::model::name::Name;
use crate::model::wire::WORDS;
use crate::observe::step_observer::ReadingState;

/// What was collected once.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedReading {
    /// The step in which it was collected.
    pub step: u64,
    /// The step in which it was taken.
    pub taken: u64,
    /// What had been collected.
    pub state: ReadingState,
    /// The reading's words.
    pub words: Vec<u64>,
}

impl RecordedReading {
    /// Makes it the reply of the sensor, which has read then.
    pub fn put(&self, reply: &mut Message) -> bool {
        let kind = if self.state == ReadingState::Fault { Kind::Fault } else { Kind::Reply };
        reply.header.kind = kind;
        reply.header.step = self.taken;
        let len = self.words.len().min(WORDS);
        reply.header.len = len as u32;
        reply.body[..len].copy_from_slice(&self.words[..len]);
        true
    }
}

/// What a process collected of a sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedReadings {
    /// The sensor.
    pub sensor: Name,
    /// The process that collected them.
    pub by: ProcessId,
    /// What it collected, in the order in which it did.
    pub readings: Vec<RecordedReading>,
    next: Cell<usize>,
}

impl RecordedReadings {
    /// Of a process that has collected nothing of the sensor yet.
    pub fn new(sensor: Name, by: ProcessId) -> RecordedReadings {
        RecordedReadings { sensor, by, readings: Vec::new(), next: Cell::new(0) }
    }

    /// What is collected next, if that was in this step.
    pub fn collect(&self, step: u64) -> Option<&RecordedReading> {
        let next = self.readings.get(self.next.get()).filter(|reading| reading.step == step)?;
        self.next.set(self.next.get() + 1);
        Some(next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_come_in_their_order_and_in_their_steps() {
        let mut recorded = RecordedReadings::new(Name::new("touch").expect("a name"), ProcessId::MP);
        let reading =
            |step, word| RecordedReading { step, taken: step, state: ReadingState::There, words: vec![word] };
        recorded.readings = vec![reading(3, 1), reading(3, 2), reading(5, 3)];
        let collected =
            [2, 3, 3, 3, 4, 5, 5].map(|step| recorded.collect(step).map(|reading| reading.words[0]));
        assert_eq!(collected, [None, Some(1), Some(2), None, None, Some(3), None]);
    }
}
