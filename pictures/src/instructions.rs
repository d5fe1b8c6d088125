//! What a program did: its Moves and Waits over time, and when the operator had suspended the cell.
//!
//! In: what its program does at the end of every servo period. Out: spans of time, in bounded memory: when there are too
//! many, neighbours become one.

use mrroc::observe::Activity;
use mrroc::operator::state::InstructionKind;

use crate::svg::Range;

/// The most spans kept.
const CAPACITY: usize = 2000;

/// An instruction, or neighbours that are shown as one.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Span {
    /// When it began and ended \[s\].
    pub time: Range,
    /// How many instructions there are in it.
    pub count: u64,
    /// A Move or a Wait; none where there are both.
    pub doing: Option<InstructionKind>,
    /// The generator or condition; none where there are several.
    pub by: Option<String>,
}

impl Span {
    /// Both and what is between them.
    pub fn with(&self, next: &Span) -> Span {
        Span {
            time: Range { low: self.time.low, high: next.time.high },
            count: self.count + next.count,
            doing: self.doing.filter(|doing| Some(*doing) == next.doing),
            by: self.by.clone().filter(|by| Some(by) == next.by.as_ref()),
        }
    }
}

/// What a program did.
#[derive(Clone, Debug, Default)]
pub(crate) struct Log {
    spans: Vec<Span>,
    suspensions: Vec<Range>,
    /// What it did last, and when \[s\].
    last: Activity,
    time: f64,
}

impl Log {
    /// What its program did at the end of a servo period.
    pub fn observe(&mut self, time: f64, now: &Activity) {
        // Robots are observed one after another, each at the end of its own period.
        if !time.is_finite() || time < self.time {
            return;
        }
        let is_new = now.instructions != self.last.instructions;
        // What was seen in the period before lasted until some time in this one.
        if is_open(&self.last)
            && let Some(span) = self.spans.last_mut()
        {
            span.time.high = if is_new { self.time } else { time };
        }
        if is_new && is_open(now) {
            self.make_room();
            self.spans.push(Span {
                time: Range { low: self.time, high: time },
                count: 1,
                doing: Some(now.doing),
                by: Some(now.by().to_owned()),
            });
        }
        match (self.last.suspended, self.suspensions.last_mut()) {
            (true, Some(suspension)) => suspension.high = time,
            _ if now.suspended => self.suspensions.push(Range { low: time, high: time }),
            _ => {}
        }
        (self.last, self.time) = (*now, time);
    }

    fn make_room(&mut self) {
        if self.spans.len() >= CAPACITY {
            self.spans = self.spans.chunks(2).map(merged).collect();
        }
    }

    /// Moves and Waits in order of time.
    pub fn spans(&self) -> &[Span] {
        &self.spans
    }

    /// When the cell was suspended \[s\].
    pub fn suspensions(&self) -> &[Range] {
        &self.suspensions
    }
}

fn merged(spans: &[Span]) -> Span {
    spans[1..].iter().fold(spans[0].clone(), |all, span| all.with(span))
}

/// Whether there is a Move or a Wait to show. That of an MP without a program is shown by the programs of the ECPs.
fn is_open(activity: &Activity) -> bool {
    match activity.doing {
        InstructionKind::Nothing | InstructionKind::Homing => false,
        InstructionKind::Move | InstructionKind::Wait => !activity.by().is_empty(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::generator::TypeName;

    struct Line;
    struct Dwell;

    fn ends(log: &Log) -> Vec<(f64, f64)> {
        log.spans().iter().map(|span| (span.time.low, span.time.high)).collect()
    }

    #[test]
    fn instructions_are_as_long_as_they_were_seen() {
        let mut log = Log::default();
        let idle = Activity::default();
        let line = idle.begun(InstructionKind::Move, TypeName::of::<Line>());
        let again = line.begun(InstructionKind::Move, TypeName::of::<Line>());
        let dwell = again.begun(InstructionKind::Wait, TypeName::of::<Dwell>());
        let seen = [idle, line, line, line, again, again, dwell, dwell, dwell.over(), dwell.over()];
        for (i, now) in seen.iter().enumerate() {
            log.observe(i as f64, now);
        }
        // From the period before the first in which it was seen; of two in a row the first ends where the next begins.
        assert_eq!(ends(&log), [(0.0, 3.0), (3.0, 5.0), (5.0, 8.0)]);
        assert_eq!(log.spans()[2].by.as_deref(), Some("Dwell"));
        assert_eq!(log.spans()[2].doing, Some(InstructionKind::Wait));
    }

    #[test]
    fn an_mp_without_a_program_has_no_instructions_and_a_suspension_lasts_until_it_is_resumed() {
        let mut log = Log::default();
        let trigger = Activity::default().begun(InstructionKind::Move, TypeName::NONE);
        for i in 0..10 {
            let mut now = trigger;
            now.suspended = (3..6).contains(&i);
            log.observe(f64::from(i), &now);
        }
        assert!(log.spans().is_empty());
        assert_eq!(log.suspensions(), [Range { low: 3.0, high: 6.0 }]);
        // Of another robot's slower period, which is told later.
        let mut late = trigger;
        late.suspended = true;
        log.observe(4.0, &late);
        assert_eq!(log.suspensions().len(), 1);
    }

    #[test]
    fn of_very_many_instructions_neighbours_become_one_and_none_is_lost() {
        let mut log = Log::default();
        let mut now = Activity::default();
        for i in 0..10_001_u32 {
            let by = if i == 9000 { TypeName::of::<Dwell>() } else { TypeName::of::<Line>() };
            now = now.begun(InstructionKind::Move, by);
            log.observe(f64::from(i), &now);
        }
        assert!(log.spans().len() <= CAPACITY);
        assert_eq!(log.spans().iter().map(|span| span.count).sum::<u64>(), 10_001);
        assert_eq!(log.spans().iter().filter(|span| span.by.is_none()).count(), 1);
        assert!(ends(&log).windows(2).all(|pair| pair[0].1 <= pair[1].0 + 1e-9));
    }
}
