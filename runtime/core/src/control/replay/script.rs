//! The steps of a recorded run: in which of them the MP began one, and what the operator wanted then.

use super::values::RecordedValues;
use crate::model::name::Name;
use crate::operator::Operator;
use crate::operator::jog::JogNow;
use crate::safety::latch::Latch;

/// One step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScriptedStep {
    /// Its index.
    pub step: u64,
    /// The operator's speed, as a share of the plan.
    pub speed: f64,
    /// Whether the operator had suspended the cell.
    pub suspended: bool,
    /// Whether the limit of reduced speed was in force.
    pub reduced: bool,
    /// Whether the operator was aborting when it began.
    pub aborting: bool,
    /// Whether the operator aborted after it had begun.
    pub aborts: bool,
    /// Whether the operator asked for a protective stop before it.
    pub stopping: bool,
    /// Whether the operator had reset the latched cell.
    pub resetting: bool,
    /// Whether what took place in it left no time for more.
    pub late: bool,
}

/// What was asked of a robot that a person jogged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScriptedJog {
    /// From which step on.
    pub step: u64,
    /// The robot.
    pub robot: Name,
    /// What was asked.
    pub now: JogNow,
}

/// What the MP of a run goes by in its replay.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Script {
    /// Its steps, in their order.
    pub steps: Vec<ScriptedStep>,
    /// What was asked of robots that were jogged, in the order of the steps.
    pub jogs: Vec<ScriptedJog>,
    /// What its program recorded.
    pub values: RecordedValues,
}

impl Script {
    /// What is asked of which robot in a step.
    pub fn jog(&self, step: u64) -> Option<(Name, JogNow)> {
        let last = self.jogs.partition_point(|jog| jog.step <= step).checked_sub(1)?;
        self.jogs.get(last).filter(|jog| jog.now != JogNow::Nothing).map(|jog| (jog.robot, jog.now))
    }

    fn at(&self, step: u64) -> Option<&ScriptedStep> {
        let place = self.steps.binary_search_by_key(&step, |scripted| scripted.step).ok()?;
        self.steps.get(place)
    }

    /// The next step that the MP began after one; the one after it where none is recorded.
    pub fn after(&self, step: u64) -> u64 {
        let place = self.steps.partition_point(|scripted| scripted.step <= step);
        self.steps.get(place).map_or(step + 1, |scripted| scripted.step)
    }

    /// The last step up to this one that the MP began; 0 if it began none.
    pub fn last_until(&self, step: u64) -> u64 {
        let count = self.steps.partition_point(|scripted| scripted.step <= step);
        count.checked_sub(1).and_then(|last| self.steps.get(last)).map_or(0, |scripted| scripted.step)
    }

    /// The last step that is recorded.
    pub fn last(&self) -> u64 {
        self.steps.last().map_or(0, |scripted| scripted.step)
    }

    /// Lets the operator want what he wanted when a step began.
    pub fn begin(&self, step: u64, operator: &Operator) {
        let Some(scripted) = self.at(step) else { return };
        // The reader has checked that it is a share.
        let _ = operator.set_speed(scripted.speed);
        operator.set_reduced(scripted.reduced);
        if scripted.suspended {
            operator.suspend();
        } else {
            operator.resume();
        }
        if scripted.aborting {
            operator.abort();
        }
        if scripted.stopping {
            operator.protective_stop();
        }
        if scripted.resetting && operator.latch() != Latch::Resetting {
            // If the operator is refused here but was not in the recording, the demands will differ.
            let _ = operator.acknowledge().and_then(|()| operator.reset());
        }
    }

    /// Lets the operator abort as he did after a step had begun.
    pub fn go_on(&self, step: u64, operator: &Operator) {
        if self.at(step).is_some_and(|scripted| scripted.aborts) {
            operator.abort();
        }
    }

    /// Whether it was too late in a step for more.
    pub fn was_late(&self, step: u64) -> bool {
        self.at(step).is_some_and(|scripted| scripted.late)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(step: u64) -> ScriptedStep {
        ScriptedStep {
            step,
            speed: 1.0,
            suspended: false,
            reduced: false,
            aborting: false,
            aborts: false,
            stopping: false,
            resetting: false,
            late: false,
        }
    }

    #[test]
    fn steps_that_were_skipped_are_skipped_again() {
        let steps = vec![step(1), step(2), step(5), ScriptedStep { late: true, ..step(6) }];
        let script = Script { steps, ..Script::default() };
        assert_eq!([0, 1, 2, 3, 5, 6].map(|after| script.after(after)), [1, 2, 5, 5, 6, 7]);
        assert_eq!([0, 2, 4, 5, 9].map(|step| script.last_until(step)), [0, 2, 2, 5, 6]);
        assert_eq!((script.last(), script.was_late(5), script.was_late(6)), (6, false, true));
    }

    #[test]
    fn what_is_asked_of_a_robot_that_is_jogged_holds_until_something_else_is() {
        let robot = Name::new("left").expect("a name");
        let jog = |step, now| ScriptedJog { step, robot, now };
        let done = JogNow::Done { press: 7 };
        let jogs = vec![jog(3, done), jog(5, JogNow::Nothing)];
        let script = Script { jogs, ..Script::default() };
        assert_eq!(
            [2, 3, 4, 5, 9].map(|step| script.jog(step).map(|(_, now)| now)),
            [None, Some(done), Some(done), None, None]
        );
    }

    #[test]
    fn the_operator_wants_what_he_wanted() {
        let steps = vec![
            ScriptedStep { speed: 0.5, suspended: true, ..step(1) },
            ScriptedStep { speed: 0.5, aborts: true, ..step(2) },
            ScriptedStep { stopping: true, ..step(3) },
        ];
        let script = Script { steps, ..Script::default() };
        let operator = Operator::new();
        operator.begin();
        script.begin(1, &operator);
        assert_eq!((operator.speed(), operator.is_suspended()), (0.5, true));
        script.begin(2, &operator);
        assert!(!operator.is_suspended() && !operator.is_aborting());
        script.go_on(2, &operator);
        assert!(operator.is_aborting() && !operator.take_protective_stop());
        script.begin(3, &operator);
        assert!(operator.take_protective_stop() && !operator.take_protective_stop());
    }
}
