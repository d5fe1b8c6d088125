//! The virtual sensor: both of its sides, under a virtual clock.

use super::*;
use crate::handover::{Orders, Shared, Worker};
use instrument::VirtualLine;

/// A sensor whose thread is this one.
struct Sensor<'t> {
    line: VirtualLine<'t>,
    shared: Shared,
    orders: Orders,
    worker: Worker,
    goes_on: Result<(), GeocomError>,
}

/// A sensor that has greeted its instrument, over a line that is closed after so many questions.
fn sensor<'t>(closes_after: usize) -> Sensor<'t> {
    let mut line = VirtualLine { closes_after, ..line_to(|_, answer| vec![answer]) };
    let mut client = Client::new(Timeouts::default());
    client.greet();
    assert_eq!(line.run(&mut client), Ok(None));
    let (shared, orders) = (Shared::default(), Orders::default());
    Sensor { line, shared, orders, worker: Worker::new(client), goes_on: Ok(()) }
}

impl Sensor<'_> {
    /// A step's order.
    fn order(&mut self, sight: Sight) -> Result<Angles, Fault> {
        self.orders.aggregate(&self.shared, sight, self.goes_on)
    }

    /// What the thread does until it has nothing to do.
    fn work(&mut self) {
        while self.goes_on.is_ok() {
            let bytes = self.line.take();
            match self.worker.poll(self.line.now, &bytes, &self.shared) {
                ClientAction::Idle => return,
                next => self.goes_on = self.line.carry_out(next, self.worker.client()),
            }
        }
        self.worker.close(&self.shared);
    }

    /// Orders a sight until there is something to say of it.
    fn ordered(&mut self, sight: Sight) -> Result<Angles, Fault> {
        let at_once = self.order(sight)?;
        if at_once.settled {
            return Ok(at_once);
        }
        self.work();
        self.order(sight)
    }
}

#[test]
fn a_virtual_sensor_reads_what_it_is_told_to_sight() {
    let mut sensor = sensor(usize::MAX);
    for (index, direction, turned) in [(1, DIRECTION, false), (2, DIRECTION, true), (3, [-2.0, 0.1], false)] {
        let [hz, v] = direction;
        let read = sensor.ordered(Sight { index, hz, v, turned }).expect("a reading");
        assert!(read.settled, "{read:?}");
        assert_eq!((read.index, read.turned), (index, turned));
        assert!((read.hz - hz).abs() < 2e-4 && (read.v - v).abs() < 2e-4, "{read:?}");
        assert!(read.hz != hz, "it has errors");
    }
    let why = sensor.ordered(Sight { index: 4, hz: 1.0, v: 1.0, turned: false }).expect_err("no target");
    assert!(why.to_string().contains("no target"), "{why}");
    let read = sensor.ordered(Sight { index: 5, hz: 0.7, v: -0.3, turned: false });
    assert!(read.is_ok_and(|read| read.settled));
}

#[test]
fn there_is_no_reading_until_the_last_answer_of_the_sight_has_come() {
    let mut sensor = sensor(usize::MAX);
    let sight = Sight { index: 1, hz: 0.7, v: -0.3, turned: true };
    assert!(!sensor.order(sight).expect("nothing is wrong").settled);
    let before = sensor.line.now;
    loop {
        let bytes = sensor.line.take();
        let next = sensor.worker.poll(sensor.line.now, &bytes, &sensor.shared);
        if next == ClientAction::Idle {
            break;
        }
        let is_settled = sensor.order(sight).expect("nothing is wrong").settled;
        assert_eq!(is_settled, matches!(next, ClientAction::Done(Ok(Some(_)))));
        sensor.line.carry_out(next, sensor.worker.client()).expect("open");
    }
    // Five answers of 40 ms each.
    assert_eq!(sensor.line.now - before, MS(200));
}

#[test]
fn a_program_that_begins_anew_gets_no_reading_of_before() {
    let mut sensor = sensor(usize::MAX);
    let first = Sight { index: 1, hz: -2.0, v: 0.1, turned: false };
    let before = sensor.ordered(first).expect("a reading");
    assert!(before.settled && (before.hz + 2.0).abs() < 2e-4, "{before:?}");
    // The same number, of another target; then the same target, which nothing but an order of no sight makes a new one.
    let [hz, v] = DIRECTION;
    let other = sensor.ordered(Sight { index: 1, hz, v, turned: false }).expect("a reading");
    assert!(other.settled && (other.hz - hz).abs() < 2e-4, "{other:?}");
    assert!(!sensor.order(Sight::default()).expect("nothing is wrong").settled);
    let again = Sight { index: 1, hz, v, turned: false };
    assert!(!sensor.order(again).expect("nothing is wrong").settled, "it is sighted anew");
    sensor.work();
    assert!(sensor.order(again).is_ok_and(|read| read.settled));
    // What failed is tried again by whoever orders it again.
    let nowhere = Sight { index: 2, hz: 1.0, v: 1.0, turned: false };
    for _ in 0..2 {
        let asked = sensor.line.instrument.asked;
        assert!(sensor.ordered(nowhere).is_err_and(|why| why.to_string().contains("no target")));
        assert!(sensor.line.instrument.asked > asked);
    }
}

#[test]
fn fault_185_a_line_that_is_closed_is_a_fault_and_never_a_reading() {
    // In each of the six questions of a greeting and a sight; after the last one there is a reading.
    for questions in 1..6 {
        let mut sensor = sensor(questions);
        let [hz, v] = DIRECTION;
        let sight = Sight { index: 1, hz, v, turned: true };
        let why = sensor.ordered(sight).expect_err("closed");
        assert!(why.to_string().contains("closed"), "{why}");
        // And it stays one, for any other sight and for none.
        for sight in [sight, Sight { index: 2, ..sight }, Sight::default()] {
            let why = sensor.order(sight).expect_err("closed");
            assert!(why.to_string().contains("closed"), "{why}");
        }
    }
    let mut line = VirtualLine { closes_after: 0, ..line_to(|_, answer| vec![answer]) };
    let mut client = Client::new(Timeouts::default());
    client.greet();
    assert_eq!(line.run(&mut client), Err(GeocomError::Closed));
}
