//! What an EDP makes of single requests.

use super::*;
use crate::model::drive_fault::DriveFault;
use crate::model::driver::{Driver, Measured, Regulators};
use crate::model::excess::Excess;
use crate::observe::servo::ServoRecord;
use crate::tests::slide::One;

/// Exact drives with brakes; power that comes back finds the slide where it sagged to meanwhile.
struct Braked {
    exact: Exact,
    told: Rc<RefCell<Vec<&'static str>>>,
    sags_to: Result<f64, DriveFault>,
}

impl Driver<Slide> for Braked {
    fn period(&self) -> Duration {
        self.exact.period
    }
    fn measured(&self) -> Result<Measured<One>, DriveFault> {
        Ok(self.exact.measured)
    }
    fn tick(&mut self, demanded: &One) -> Result<Measured<One>, DriveFault> {
        self.exact.tick(demanded)
    }
    fn has_brakes(&self) -> bool {
        true
    }
    fn switch_off(&mut self) {
        self.told.borrow_mut().push("off");
    }
    fn switch_on(&mut self) -> Result<(), DriveFault> {
        self.exact.measured.position = One::new(self.sags_to?);
        self.told.borrow_mut().push("on");
        Ok(())
    }
    fn choose_regulators(&mut self, sets: &Regulators) {
        assert_eq!(*sets, Regulators::default());
        self.told.borrow_mut().push("usual");
    }
}

/// An EDP whose drives have brakes, and what they are told.
fn braked(
    servo: Duration,
    sags_to: Result<f64, DriveFault>,
) -> (Edp<'static, Slide>, Rc<RefCell<Vec<&'static str>>>) {
    let (mut edp, _) = edp(servo);
    let told = Rc::<RefCell<Vec<&'static str>>>::default();
    let drive = Braked { exact: Exact::new(servo), told: Rc::clone(&told), sags_to };
    edp.servo.drive = Drive::Here(Box::new(drive));
    (edp, told)
}

const MS: Duration = Duration::from_millis(1);

fn ask(edp: &mut Edp<'static, Slide>, kind: RequestKind, flags: u32, epoch: u32) -> Message {
    edp.answers.request = Message::new(Kind::Request(kind));
    (edp.answers.request.header.flags, edp.answers.request.header.epoch) = (flags, epoch);
    edp.serve();
    edp.answers.reply
}

fn demand(edp: &mut Edp<'static, Slide>, demand: &Demand<Slide>, flags: u32, step: u64) -> Message {
    edp.answers.request = Message::new(Kind::Request(RequestKind::Demand));
    let header = &mut edp.answers.request.header;
    (header.flags, header.step, header.len) = (flags, step, <Demand<Slide> as Wire>::LEN as u32);
    (header.dt, header.duration) = (1e-3, 1e-3);
    demand.put(&mut edp.answers.request.body);
    edp.serve();
    edp.answers.reply
}

fn x(x: f64) -> Demand<Slide> {
    Demand::joints(One::new(x))
}

#[test]
fn a_robot_that_is_not_where_it_was_told_to_be_starts_no_motion() {
    let (mut edp, _) = edp(MS);
    edp.servo.measured.position = One::new(1.5);
    let reply = ask(&mut edp, RequestKind::Query, 0, 0);
    assert_eq!(reply.header.kind, Kind::Reply, "it may be asked where it is");
    let reply = ask(&mut edp, RequestKind::Query, flag::FIRST, 0);
    assert_eq!((reply.header.kind, reply.fault().kind()), (Kind::Fault, FaultKind::StartPoseMismatch));
    // A motion that goes on from another one is checked as it moves.
    let (mut edp, _) = self::edp(MS);
    demand(&mut edp, &x(1e-6), flag::FIRST, 0);
    edp.servo.measured.position = One::new(1.5);
    assert_eq!(ask(&mut edp, RequestKind::Query, flag::FIRST, 0).header.kind, Kind::Reply);
}

#[test]
fn a_reply_tells_the_state_and_the_standstill() {
    let (mut edp, _) = edp(MS);
    assert_eq!(ask(&mut edp, RequestKind::Query, 0, 0).header.flags, flag::STANDSTILL);
    let reply = ask(&mut edp, RequestKind::Query, flag::WANT_STATE, 0);
    assert_eq!(reply.header.flags, flag::STANDSTILL | flag::STATE);
    assert_eq!(demand(&mut edp, &x(1e-6), flag::WANT_STATE, 0).header.flags, flag::STATE);
}

#[test]
fn a_robot_stands_when_its_drives_have_come_to_the_last_demand() {
    // With a period of 2 ms at steps of 1 ms the drives lie behind the demands.
    let (mut edp, _) = edp(2 * MS);
    let settling = edp.servo.interpolation.settling_steps();
    assert!(settling > 1 && edp.is_at_standstill());
    demand(&mut edp, &x(1e-6), 0, 0);
    edp.begin_step();
    ask(&mut edp, RequestKind::Brake, 0, 0);
    for step in 0..settling {
        assert!(!edp.is_at_standstill(), "step {step}");
        edp.begin_step();
    }
    assert!(edp.is_at_standstill());
}

#[test]
fn the_rate_of_a_demand_is_its_path_time_over_its_own_duration() {
    let (mut edp, _) = edp(MS);
    edp.answers.request = Message::new(Kind::Request(RequestKind::Demand));
    let header = &mut edp.answers.request.header;
    // 0.75 of four periods: 5e-3 m/s of a path that has 5e-3 / 0.75 m/s.
    (header.dt, header.duration, header.len) = (3e-3, 4e-3, <Demand<Slide> as Wire>::LEN as u32);
    x(5e-6).put(&mut edp.answers.request.body);
    edp.serve();
    // (0.98 - 0.9 r²) a / (v + a T), see `Acceptor::rate_margin`.
    let expected = (0.98 - 0.9 * 0.75 * 0.75) * 10.0 / (5e-3 / 0.75 + 10.0 * 1e-3);
    let fall = edp.answers.reply.header.rate_margin.fall;
    assert!((fall - expected).abs() < 1e-9 * expected, "{fall}, {expected}");
}

#[test]
fn a_demand_of_a_step_that_is_over_moves_nothing_and_its_tool_stays() {
    let (mut edp, _) = edp(MS);
    (0..3).for_each(|_| edp.begin_step());
    let tool = Pose::translation(0.0, 0.0, 0.1);
    let due = edp.clock.due;
    demand(&mut edp, &x(1e-6).with_tool(tool), 0, due - 1);
    assert!(
        matches!(edp.path.mode, Mode::Holding)
            && edp.path.next.is_none()
            && *edp.path.acceptor.tool() == tool
    );
    demand(&mut edp, &x(1e-6), 0, due);
    assert!(matches!(edp.path.mode, Mode::Moving { .. }) && edp.path.next.is_some());
}

#[test]
fn only_the_first_demand_of_a_motion_from_rest_is_told_to_be_the_first() {
    for (moves, flags, first) in [(false, flag::FIRST, true), (false, 0, false), (true, flag::FIRST, false)] {
        let (mut edp, _) = edp(MS);
        if moves {
            demand(&mut edp, &x(1e-6), flag::FIRST, 0);
            edp.begin_step();
        }
        let step = edp.clock.due;
        let fault = demand(&mut edp, &x(0.5), flags, step).fault();
        assert_eq!(fault.is_of_first_demand(), first, "{moves} {flags}: {fault}");
    }
}

#[test]
fn a_set_that_a_regulator_does_not_have_is_refused_with_the_joint() {
    let (mut edp, _) = edp(MS);
    let reply = demand(&mut edp, &x(1e-6).with_regulators(Regulators::uniform(0)), 0, 0);
    assert_eq!(reply.header.kind, Kind::Reply);
    edp.begin_step();
    let step = edp.clock.due;
    let fault = demand(&mut edp, &x(2e-6).with_regulators(Regulators::uniform(3)), 0, step).fault();
    assert_eq!((fault.kind(), fault.joint()), (FaultKind::NoRegulator, Some(0)));
}

#[test]
fn a_motion_ends_at_once_where_one_step_takes_its_speed_away() {
    // 10 m/s² take 1e-2 m/s away in 1 ms.
    let (mut edp, _) = edp(MS);
    demand(&mut edp, &x(9e-6), 0, 0);
    edp.begin_step();
    ask(&mut edp, RequestKind::Brake, 0, 0);
    assert!(matches!(edp.path.mode, Mode::Holding));
    // 18e-3 m/s take two steps.
    let (mut edp, _) = self::edp(MS);
    for q in [9e-6, 27e-6] {
        let step = edp.clock.due;
        demand(&mut edp, &x(q), 0, step);
        edp.begin_step();
    }
    ask(&mut edp, RequestKind::Brake, 0, 0);
    assert!(matches!(edp.path.mode, Mode::Braking(_)));
    // The law leaves 8e-3 m/s after 1 ms and stands after 1.8 ms.
    edp.begin_step();
    assert!(
        (edp.path.acceptor.demanded().1[0] - 8e-3).abs() < 1e-12 && matches!(edp.path.mode, Mode::Braking(_))
    );
    edp.begin_step();
    assert_eq!(edp.path.acceptor.demanded().1[0], 0.0);
    edp.begin_step();
    assert!(matches!(edp.path.mode, Mode::Holding));
}

#[test]
fn a_joint_that_does_not_follow_is_told_of_with_its_step_and_shown_with_its_time() {
    let (mut edp, _) = edp(MS);
    let shown = Rc::<core::cell::Cell<f64>>::default();
    let seen = Rc::clone(&shown);
    edp.shown.observers.push(Box::new(move |record: &ServoRecord<Slide>| seen.set(record.time)));
    edp.tick_at(6_500_000);
    assert!((shown.get() - 7.5e-3).abs() < 1e-12 && edp.answers.fault.is_none());
    edp.servo.following_error = One::new(-1.0);
    edp.tick_at(7_500_000);
    let fault = edp.answers.fault.expect("no error is small enough");
    assert_eq!((fault.kind(), fault.step()), (FaultKind::FollowingError, Some(7)));
}

#[test]
fn a_stopped_robot_with_brakes_has_no_power_and_begins_where_it_sagged_to() {
    let (mut edp, told) = braked(MS, Ok(0.25));
    ask(&mut edp, RequestKind::Stop, 0, 0);
    assert!(matches!(edp.path.mode, Mode::Off));
    let reply = ask(&mut edp, RequestKind::Reset, 0, 1);
    assert_eq!((reply.header.kind, told.take()), (Kind::Reply, vec!["off", "on", "usual"]));
    assert!(matches!(edp.path.mode, Mode::Holding) && edp.answers.fault.is_none());
    assert_eq!(
        (edp.path.acceptor.demanded().0[0], edp.servo.commanded[0], edp.servo.interpolation.goal()[0]),
        (0.25, 0.25, 0.25)
    );
    assert!(edp.is_at_standstill());
}

#[test]
fn a_robot_that_moves_or_has_not_come_to_its_last_demand_keeps_its_power() {
    let (mut edp, told) = braked(MS, Ok(0.0));
    demand(&mut edp, &x(9e-6), 0, 0);
    edp.begin_step();
    demand(&mut edp, &x(27e-6), 0, 1);
    edp.begin_step();
    ask(&mut edp, RequestKind::Stop, 0, 0);
    assert!(matches!(edp.path.mode, Mode::Braking(_)) && told.take().is_empty());
    let (mut edp, told) = braked(2 * MS, Ok(0.0));
    demand(&mut edp, &x(1e-6), 0, 0);
    edp.begin_step();
    ask(&mut edp, RequestKind::Stop, 0, 0);
    assert!(matches!(edp.path.mode, Mode::Holding) && told.take().is_empty());
}

#[test]
fn drives_that_held_all_the_time_go_on_holding_what_they_were_told_unless_they_do_not_follow() {
    // The following error is 1 m.
    for (measured, begins) in [(0.5, 0.0), (1.5, 1.5)] {
        let (mut edp, _) = edp(MS);
        edp.servo.measured.position = One::new(measured);
        ask(&mut edp, RequestKind::Stop, 0, 0);
        assert!(matches!(edp.path.mode, Mode::Holding));
        assert_eq!(ask(&mut edp, RequestKind::Reset, 0, 1).header.kind, Kind::Reply);
        assert_eq!((edp.path.acceptor.demanded().0[0], edp.servo.commanded[0]), (begins, begins));
    }
}

#[test]
fn drives_that_do_not_come_on_stay_latched() {
    let trip = DriveFault::exceeded(0, "motor current", Excess::new(30.0, 25.0, "A"));
    let (mut edp, told) = braked(MS, Err(trip));
    ask(&mut edp, RequestKind::Stop, 0, 0);
    let reply = ask(&mut edp, RequestKind::Reset, 0, 1);
    assert_eq!((reply.header.kind, reply.fault().kind()), (Kind::Fault, FaultKind::DriveFault));
    assert!(matches!(edp.path.mode, Mode::Off) && told.take() == ["off"]);
}

#[test]
fn the_task_space_comes_in_within_fifty_milliseconds_of_servo_periods() {
    let (mut edp, _) = edp(Duration::from_micros(250));
    edp.servo.space = InterpolationSpace::Task;
    edp.servo.task_space.accept(true, false);
    for (periods, u) in [(10, 0.05), (90, 0.5), (100, 1.0), (10, 1.0)] {
        (0..periods).for_each(|period| edp.tick_at(period * 250_000));
        edp.servo.task_space.set_difference(One::new(1.0));
        // u² (3 - 2 u) of the difference, u = t / 50 ms.
        assert!((edp.servo.task_space.correction()[0] - u * u * (3.0 - 2.0 * u)).abs() < 1e-12, "{u}");
    }
}

#[test]
fn a_servo_period_in_the_task_space_is_no_jump() {
    // 1 m/s is 0.25 mm in 0.25 ms.
    for (distance, goes) in [(0.24e-3, true), (0.26e-3, false)] {
        let (mut edp, _) = edp(Duration::from_micros(250));
        edp.servo.space = InterpolationSpace::Task;
        edp.servo.task_space.accept(true, true);
        edp.servo.commanded = One::new(-distance);
        edp.tick_at(0);
        let kind = edp.answers.fault.as_ref().map(Fault::kind);
        assert_eq!(kind, (!goes).then_some(FaultKind::DemandedVelocity), "{distance}");
    }
}

/// Exact drives whose encoders cannot be read the first times, and what they are asked.
struct Unread {
    exact: Exact,
    refusals: core::cell::Cell<u32>,
    told: Rc<RefCell<Vec<&'static str>>>,
}

impl Driver<Slide> for Unread {
    fn period(&self) -> Duration {
        self.exact.period
    }
    fn open(&mut self) -> Result<(), DriveFault> {
        self.told.borrow_mut().push("open");
        Ok(())
    }
    fn close(&mut self) {
        self.told.borrow_mut().push("close");
    }
    fn measured(&self) -> Result<Measured<One>, DriveFault> {
        self.told.borrow_mut().push("measured");
        if self.refusals.get() > 0 {
            self.refusals.set(self.refusals.get() - 1);
            return Err(DriveFault::Other("encoder 1 has no supply"));
        }
        Ok(Measured { position: One::new(0.25), velocity: One::zeros() })
    }
    fn tick(&mut self, demanded: &One) -> Result<Measured<One>, DriveFault> {
        self.told.borrow_mut().push("tick");
        self.exact.tick(demanded)
    }
    fn has_brakes(&self) -> bool {
        true
    }
}

#[test]
fn fault_83_encoders_that_cannot_be_read_are_a_fault_with_their_reason_until_a_reset_reads_them() {
    let told = Rc::<RefCell<Vec<&'static str>>>::default();
    let driver = Unread { exact: Exact::new(MS), refusals: 2.into(), told: Rc::clone(&told) };
    let config = EdpConfig { drive: Drive::Here(Box::new(driver)).opened(), ..config(MS) };
    let mut edp = Edp::new(config, Host::of(&Still), Box::new(Replies(Rc::default())));
    assert_eq!(told.take(), ["open", "measured", "close"]);
    let says = |reply: Message| {
        let fault = reply.fault();
        assert_eq!((fault.kind(), fault.message()), (FaultKind::DriveFault, "encoder 1 has no supply"));
        assert_eq!(fault.robot().map(|name| name.to_string()).as_deref(), Some("g"));
    };
    says(ask(&mut edp, RequestKind::Query, flag::WANT_STATE, 0));
    // No demand comes to drives that nobody knows the place of.
    says(demand(&mut edp, &x(1e-6), 0, 0));
    edp.begin_step();
    edp.tick_at(500_000);
    assert!(told.take().is_empty());
    // Only when it is this robot's turn to recover: that may take its time.
    says(ask(&mut edp, RequestKind::Stop, 0, 0));
    assert!(told.take().is_empty());
    says(ask(&mut edp, RequestKind::Stop, flag::RECOVER, 0));
    assert_eq!(told.take(), ["open"]);
    says(ask(&mut edp, RequestKind::Reset, 0, 1));
    assert_eq!(told.take(), ["measured"]);
    // They are open by now, and only read again.
    assert_eq!(ask(&mut edp, RequestKind::Reset, 0, 2).header.kind, Kind::Reply);
    assert_eq!(told.take(), ["measured"]);
    assert_eq!((edp.path.acceptor.demanded().0[0], edp.servo.commanded[0]), (0.25, 0.25));
}

#[test]
fn fault_83_drives_that_come_on_and_cannot_be_read_stay_latched() {
    let (mut edp, _) = edp(MS);
    let told = Rc::<RefCell<Vec<&'static str>>>::default();
    edp.servo.drive = Drive::Here(Box::new(Unread { exact: Exact::new(MS), refusals: 1.into(), told }));
    ask(&mut edp, RequestKind::Stop, 0, 0);
    assert!(matches!(edp.path.mode, Mode::Off));
    let refused = ask(&mut edp, RequestKind::Reset, 0, 1).fault();
    assert_eq!((refused.kind(), refused.message()), (FaultKind::DriveFault, "encoder 1 has no supply"));
    assert!(matches!(edp.path.mode, Mode::Off));
    assert_eq!(ask(&mut edp, RequestKind::Reset, 0, 2).header.kind, Kind::Reply);
    assert_eq!(edp.path.acceptor.demanded().0[0], 0.25);
}

#[test]
fn fault_152_demands_that_are_all_late_are_not_missing_and_after_the_last_one_twenty_steps_are_bridged() {
    for late in [1, 3, 15] {
        let (mut edp, _) = edp(MS);
        let mut last = 0;
        for _ in 0..300 {
            let due = edp.clock.due;
            if due >= late {
                let flags = if last == 0 { flag::FIRST } else { 0 };
                let reply = demand(&mut edp, &x(1e-6 * f64::from(last + 1)), flags, due - late);
                assert_eq!(reply.header.kind, Kind::Reply, "{late} steps late, in step {due}");
                last += 1;
            }
            edp.begin_step();
            assert!(last == 0 || edp.path.is_moving(), "{late} steps late, in step {due}");
        }
        let mut bridged = 0;
        while edp.path.is_moving() {
            edp.begin_step();
            bridged += 1;
        }
        assert_eq!(bridged - 1, 20, "{late} steps late");
        assert_eq!(edp.answers.fault.as_ref().map(Fault::kind), Some(FaultKind::PeerLost));
    }
}
