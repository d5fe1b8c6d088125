//! Drives in the plant without their EDP: what they do in each servo period.

use core::cell::RefCell;
use core::time::Duration;
use std::rc::Rc;

use nalgebra::Vector3;

use super::drives::{Commands, Drives};
use super::{Part, Rest};
use crate::control::command::{Command, Reading, RegulatorSets, Switch};
use crate::link::memory::MemoryBoard;
use crate::link::message::{Kind, Message};
use crate::link::{Board, Server};
use crate::model::drive_fault::DriveFault;
use crate::model::driver::{Driver, Measured, Regulators, SimulatedDrives};
use crate::model::excess::Excess;
use crate::model::fault::{FaultKind, ProcessId, Role};
use crate::model::load::Load;
use crate::model::name::Name;
use crate::model::pose::Pose;
use crate::model::signals::{Channel, Outputs, Signals, Value, Values};
use crate::model::time::Nanos;
use crate::random::Random;
use crate::tests::slide::{One, Slide};

/// Servo period and step: 1 ms, so `L` is 20.
const SERVO: Nanos = 1_000_000;
const L: u64 = 20;

/// What a drive was told, period by period.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Told {
    Position(f64),
    Brake,
    Choose(u8),
    Outputs(u32, u32),
    Carry(f64),
}

/// A drive that is where it is told, and keeps a third of its speed in each period of braking.
struct Exact {
    told: Rc<RefCell<Vec<Told>>>,
    measured: Measured<One>,
    trips_at: Option<f64>,
}

impl Driver<Slide> for Exact {
    fn period(&self) -> Duration {
        Duration::from_nanos(SERVO)
    }
    fn measured(&self) -> Result<Measured<One>, DriveFault> {
        Ok(self.measured)
    }
    fn tick(&mut self, demanded: &One) -> Result<Measured<One>, DriveFault> {
        self.told.borrow_mut().push(Told::Position(demanded[0]));
        if self.trips_at.is_some_and(|trips_at| demanded[0] >= trips_at) {
            return Err(DriveFault::exceeded(0, "motor current", Excess::new(30.0, 25.0, "A")));
        }
        let velocity = (demanded - self.measured.position) / 1e-3;
        self.measured = Measured { position: *demanded, velocity };
        Ok(self.measured)
    }
    fn choose_regulators(&mut self, sets: &Regulators) {
        self.told.borrow_mut().push(Told::Choose(sets.set(0)));
    }
    fn switch_outputs(&mut self, outputs: &Outputs) {
        self.told.borrow_mut().push(Told::Outputs(outputs.digital(), outputs.values().digital()));
    }
    fn carry(&mut self, load: &Load) {
        self.told.borrow_mut().push(Told::Carry(load.mass));
    }
    fn simulation(&mut self) -> Option<&mut dyn SimulatedDrives<One>> {
        Some(self)
    }
}

impl SimulatedDrives<One> for Exact {
    fn brake(&mut self) -> Measured<One> {
        self.told.borrow_mut().push(Told::Brake);
        self.measured.velocity /= 3.0;
        self.measured
    }
}

/// A port whose requests and replies are lists.
#[derive(Clone, Default)]
struct Lists(Rc<RefCell<(Vec<Message>, Vec<Message>)>>);

impl Server for Lists {
    fn receive(&self, request: &mut Message) -> bool {
        self.0.borrow_mut().0.pop().map(|came| *request = came).is_some()
    }
    fn reply(&self, reply: &Message) {
        self.0.borrow_mut().1.push(*reply);
    }
}

fn edp() -> ProcessId {
    ProcessId::new(Role::Edp, Name::new("slide").expect("a name"))
}

fn command(period: u64, demanded: f64) -> Message {
    let mut message = Message::empty();
    let (regulators, tool) = (Regulators::default(), Pose::identity());
    Command {
        period,
        switched: 0,
        choice: 0,
        regulators,
        demanded: One::new(demanded),
        tool,
        told: Default::default(),
    }
    .put(&mut message);
    message
}

/// Drives in real time: their commands, their readings, and what the drive was told.
struct Bench {
    drives: Drives<Slide>,
    commands: Rc<MemoryBoard>,
    readings: Rc<MemoryBoard>,
    told: Rc<RefCell<Vec<Told>>>,
}

impl Bench {
    fn new(trips_at: Option<f64>) -> Bench {
        let (commands, readings) = (Rc::<MemoryBoard>::default(), Rc::<MemoryBoard>::default());
        let free =
            Commands::Free(Rc::clone(&commands) as Rc<dyn Board>, Rc::clone(&readings) as Rc<dyn Board>);
        let (drives, told) = drives(free, trips_at);
        Bench { drives, commands, readings, told }
    }

    /// The drives' own instant for a period, and what they read after it.
    fn period(&mut self, period: u64) -> Message {
        self.drives.serve();
        self.drives.advance((period + 1) * SERVO);
        self.readings.0.borrow().expect("a reading")
    }

    fn told(&self) -> Vec<Told> {
        self.told.take()
    }
}

fn drives(commands: Commands, trips_at: Option<f64>) -> (Drives<Slide>, Rc<RefCell<Vec<Told>>>) {
    let told = Rc::<RefCell<Vec<Told>>>::default();
    let measured = Measured { position: One::zeros(), velocity: One::zeros() };
    let driver = Exact { told: Rc::clone(&told), measured, trips_at };
    (Drives::new(edp(), Box::new(driver), measured, commands, SERVO, (L + 1) * SERVO, Vec::new()), told)
}

fn near(told: &[Told], expected: &[f64]) {
    assert_eq!(told.len(), expected.len(), "{told:?}");
    for (told, expected) in told.iter().zip(expected) {
        assert!(matches!(told, Told::Position(x) if (x - expected).abs() < 1e-15), "{told:?}, {expected}");
    }
}

#[test]
fn drives_hold_until_their_first_command_and_then_follow_one_a_period() {
    let mut bench = Bench::new(None);
    for period in 0..5 {
        bench.drives.serve();
        bench.drives.advance((period + 1) * SERVO);
    }
    assert_eq!((bench.told(), bench.drives.rests()), (Vec::new(), true));
    for period in 5..10 {
        bench.commands.write(&command(period, 1e-3 * period as f64));
        let reading = Reading::<One>::get(&bench.period(period)).expect("a reading");
        assert_eq!((reading.period, reading.demanded[0]), (period, 1e-3 * period as f64));
        assert_eq!(bench.told(), [Told::Position(1e-3 * period as f64)]);
    }
    assert!(!bench.drives.rests());
}

#[test]
fn fault_11_a_command_that_is_late_is_bridged_at_the_speed_before_it_and_never_repeated() {
    let mut bench = Bench::new(None);
    for period in 0..3 {
        bench.commands.write(&command(period, period as f64));
        bench.period(period);
    }
    bench.told();
    // Periods 3 and 4 get none; the one of 5 is where the motion has come to meanwhile.
    bench.period(3);
    bench.period(4);
    bench.commands.write(&command(5, 5.0));
    bench.period(5);
    near(&bench.told(), &[3.0, 4.0, 5.0]);
    // One of a period that is over changes nothing.
    bench.commands.write(&command(4, 100.0));
    bench.period(6);
    near(&bench.told(), &[6.0]);
}

#[test]
fn fault_11_drives_whose_edp_stalls_again_and_again_are_told_no_speed_far_from_that_of_commands() {
    // The first joint of an IRp-6: it goes to and fro as fast as it may, in between at most at 1.4 rad/s.
    let (most, acceleration) = (1.4, 7.0);
    let period_s = SERVO as f64 * 1e-9;
    // So many periods of stalls as drives bridge take a line off the motion by `a (L Ts)² / 2`; that the line has the mean speed of as
    // many periods before, by as much again. It fades over as many periods as were bridged.
    let bound = most + 2.0 * acceleration * L as f64 * period_s;
    let mut fastest = 0.0_f64;
    for seed in 0..200 {
        let (mut random, mut bench) = (Random::seeded(seed), Bench::new(None));
        let (mut x, mut v, mut to) = (0.0, 0.0, most);
        let mut awake_at = 0;
        for period in 0..2000 {
            if random.unit() < 2e-3 {
                to = most * (2.0 * random.unit() - 1.0);
            }
            let (before, change) = (v, acceleration * period_s);
            v += f64::clamp(to - v, -change, change);
            x += 0.5 * (before + v) * period_s;
            // The EDP sleeps for up to `L` periods, often for a few.
            if period > awake_at && random.unit() < 0.1 {
                awake_at = period + 1 + (L as f64 * random.unit().powi(3)) as u64;
            }
            if period >= awake_at {
                bench.commands.write(&command(period, x));
            }
            // And the plant.
            if random.unit() < 0.8 {
                bench.period(period);
            }
        }
        let told = bench.told();
        let positions = told.iter().map(|told| match *told {
            Told::Position(x) => x,
            other => panic!("{other:?}"),
        });
        let positions: Vec<f64> = positions.collect();
        let speeds = positions.windows(2).map(|pair| (pair[1] - pair[0]).abs() / period_s);
        fastest = speeds.fold(fastest, f64::max);
        // They do not stay apart from the commands: once commands have come in time for as long as drives bridge, they are where they are told to be.
        for period in 2000..=2000 + L {
            bench.commands.write(&command(period, x));
            bench.period(period);
        }
        assert_eq!(bench.told().last(), Some(&Told::Position(x)), "seed {seed}");
    }
    assert!(fastest <= bound, "{fastest} rad/s of {bound}");
}

#[test]
fn fault_11_simulated_time_that_is_late_is_made_up_for_evenly() {
    let mut bench = Bench::new(None);
    bench.commands.write(&command(0, 0.0));
    bench.period(0);
    bench.told();
    // The plant sleeps over three commands, of which it sees the last.
    bench.commands.write(&command(4, 4.0));
    bench.period(4);
    near(&bench.told(), &[1.0, 2.0, 3.0, 4.0]);
}

#[test]
fn fault_01_drives_bridge_l_steps_without_commands_then_brake_and_stay_without_power() {
    let mut bench = Bench::new(None);
    for period in 0..3 {
        bench.commands.write(&command(period, 0.1 * period as f64));
        bench.period(period);
    }
    bench.told();
    let (mut period, mut bridged) = (3, 0);
    while bench.told.borrow().last() != Some(&Told::Brake) {
        bridged = bench.told.borrow().len() as u64;
        bench.period(period);
        period += 1;
        assert!(period < 100, "they never brake");
    }
    assert_eq!(bridged, L);
    let reading = bench.period(period);
    let fault = reading.fault();
    assert_eq!((reading.header.kind, fault.kind()), (Kind::Fault, FaultKind::Overrun));
    let excess = fault.excess().expect("steps");
    assert_eq!((excess.actual, excess.limit), ((L + 1) as f64, L as f64));
    // 100 m/s, a third of it left after each period: 1e-3 after eleven, ln(1e5) / ln 3 = 10.5.
    while !bench.drives.rests() {
        period += 1;
        assert_eq!(bench.drives.due(), Some((period + 1) * SERVO));
        bench.period(period);
    }
    assert_eq!(bench.drives.rest(), Some(Rest { edp: edp(), braked_after: L + 1, stood_after: 11 }));
    // An EDP that comes back moves nothing.
    bench.told();
    period += 1;
    bench.commands.write(&command(period, 5.0));
    assert_eq!(bench.period(period).header.kind, Kind::Fault);
    assert!(bench.told().iter().all(|told| *told == Told::Brake));
}

#[test]
fn drives_that_have_braked_look_every_period_for_an_order_to_have_power_again() {
    let mut bench = Bench::new(None);
    for period in 0..3 {
        bench.commands.write(&command(period, 1e-6 * period as f64));
        bench.period(period);
    }
    let mut period = 3;
    while !bench.drives.rests() {
        bench.period(period);
        period += 1;
    }
    // Nobody wakes the plant for what is shown to it.
    assert_eq!(bench.drives.due(), Some((period + 1) * SERVO));
    let mut order = Message::empty();
    Switch { ordinal: 1, on: true }.put(&mut order);
    bench.commands.write(&order);
    assert_eq!(bench.period(period).header.kind, Kind::Reply);
    bench.told();
    let mut message = Message::empty();
    let (regulators, tool) = (Regulators::default(), Pose::identity());
    let demanded = One::new(3e-6);
    Command {
        period: period + 1,
        switched: 1,
        choice: 0,
        regulators,
        demanded,
        tool,
        told: Default::default(),
    }
    .put(&mut message);
    bench.commands.write(&message);
    assert_eq!(bench.period(period + 1).header.kind, Kind::Reply);
    near(&bench.told(), &[3e-6]);
}

#[test]
fn fault_01_an_old_command_is_no_sign_of_life() {
    let mut bench = Bench::new(None);
    for period in 0..3 {
        bench.commands.write(&command(period, 0.1 * period as f64));
        bench.period(period);
    }
    bench.told();
    // It neither puts the brakes off nor brings them on.
    for period in 3..3 + L {
        bench.commands.write(&command(0, 0.0));
        bench.period(period);
    }
    assert!(bench.told().iter().all(|told| *told != Told::Brake));
    bench.period(3 + L);
    assert_eq!(bench.told(), [Told::Brake]);
}

#[test]
fn an_order_to_switch_that_comes_twice_is_done_once() {
    let mut bench = Bench::new(None);
    let mut order = Message::empty();
    Switch { ordinal: 1, on: true }.put(&mut order);
    bench.commands.write(&order);
    bench.drives.serve();
    let regulators = Regulators::default();
    for (period, x) in [(3, 0.0), (4, 0.1)] {
        let mut message = Message::empty();
        let (demanded, tool) = (One::new(x), Pose::identity());
        Command { period, switched: 1, choice: 0, regulators, demanded, tool, told: Default::default() }
            .put(&mut message);
        bench.commands.write(&message);
        bench.period(period);
    }
    bench.told();
    // The drives go on as before it.
    bench.commands.write(&order);
    bench.period(5);
    near(&bench.told(), &[0.2]);
}

#[test]
fn a_command_at_the_very_beginning_waits_for_the_end_of_its_period() {
    let mut bench = Bench::new(None);
    bench.commands.write(&command(0, 0.0));
    bench.drives.serve();
    bench.drives.advance(0);
    assert_eq!(bench.told(), []);
    bench.drives.advance(SERVO);
    assert_eq!(bench.told(), [Told::Position(0.0)]);
}

#[test]
fn a_drive_that_trips_has_no_power_and_says_why() {
    let mut bench = Bench::new(Some(2.0));
    for period in 0..5 {
        bench.commands.write(&command(period, period as f64));
        let reading = bench.period(period);
        let tripped = period >= 2;
        assert_eq!(reading.header.kind == Kind::Fault, tripped, "{period}");
        if tripped {
            assert_eq!(reading.fault().kind(), FaultKind::DriveFault);
        }
    }
    use Told::{Brake, Position};
    assert_eq!(bench.told(), [Position(0.0), Position(1.0), Position(2.0), Brake, Brake]);
    // That no demands came is not what it stopped for.
    assert_eq!(bench.drives.rest(), None);
}

#[test]
fn drives_that_stood_when_their_commands_stayed_away_have_no_stop_to_tell_of() {
    let mut bench = Bench::new(None);
    for period in 0..L + 5 {
        if period < 2 {
            bench.commands.write(&command(period, 0.0));
        }
        bench.period(period);
    }
    assert_eq!(bench.told().last(), Some(&Told::Brake));
    assert!(bench.drives.rests() && bench.drives.rest().is_none());
}

#[test]
fn drives_that_are_switched_on_go_on_although_the_plant_saw_nothing_but_the_next_demand() {
    let mut bench = Bench::new(Some(2.0));
    for period in 0..4 {
        bench.commands.write(&command(period, period as f64));
        bench.period(period);
    }
    bench.told();
    let mut message = Message::empty();
    Switch { ordinal: 1, on: false }.put(&mut message);
    bench.commands.write(&message);
    bench.drives.serve();
    let told = bench.readings.0.borrow().expect("told at once");
    assert_eq!((told.header.kind, told.header.instruction), (Kind::Reply, 1));
    // The order to switch on is overwritten by the first demand after it.
    let (regulators, tool) = (Regulators::default(), Pose::identity());
    Command {
        period: 9,
        switched: 2,
        choice: 0,
        regulators,
        demanded: One::new(1.0),
        tool,
        told: Default::default(),
    }
    .put(&mut message);
    bench.commands.write(&message);
    let reading = bench.period(9);
    assert_eq!((reading.header.kind, reading.header.instruction), (Kind::Reply, 2));
    near(&bench.told(), &[1.0]);
}

#[test]
fn in_lock_step_each_command_is_one_period_and_is_answered_in_it() {
    let lists = Lists::default();
    let (mut drives, told) = drives(Commands::Asked(Box::new(lists.clone())), None);
    assert_eq!(drives.due(), None);
    for period in 7..12 {
        lists.0.borrow_mut().0.push(command(period, 0.5));
        drives.serve();
        // Before its own instant for that period; at it nothing more happens.
        assert_eq!(told.take(), [Told::Position(0.5)]);
        let reply = lists.0.borrow_mut().1.pop().expect("answered");
        assert_eq!(Reading::<One>::get(&reply).map(|reading| reading.period), Ok(period));
        assert_eq!(drives.due(), Some((period + 2) * SERVO));
        drives.advance((period + 1) * SERVO);
        assert_eq!(told.take(), []);
    }
}

#[test]
fn a_choice_of_regulators_is_made_once_and_before_the_period_that_it_is_for() {
    let mut bench = Bench::new(None);
    for (period, choice) in [(0, 0), (1, 1), (2, 1), (3, 2)] {
        let mut message = Message::empty();
        let (regulators, tool) = (Regulators::uniform(choice as u8 + 6), Pose::identity());
        Command {
            period,
            switched: 0,
            choice,
            regulators,
            demanded: One::zeros(),
            tool,
            told: Default::default(),
        }
        .put(&mut message);
        bench.commands.write(&message);
        bench.period(period);
    }
    use Told::{Choose, Position};
    let at = Position(0.0);
    assert_eq!(bench.told(), [at, Choose(7), at, at, Choose(8), at]);
}

#[test]
fn outputs_and_a_load_are_told_once_and_before_the_period_that_they_are_for() {
    use crate::control::command::DriveSettings as Beside;
    let on = |on| Outputs::NONE.with(Channel::Digital(2), Value::Digital(on));
    let load = |mass| Load::point(mass, Vector3::z());
    let orders = [
        Beside::default(),
        Beside { outputs: on(true), ..Beside::default() },
        Beside { outputs: on(true), loads: 1, load: load(0.5) },
        Beside { outputs: on(false), loads: 2, load: load(0.5) },
    ];
    let mut bench = Bench::new(None);
    for (period, told) in orders.into_iter().enumerate() {
        let mut message = Message::empty();
        let (regulators, tool, demanded) = (Regulators::default(), Pose::identity(), One::zeros());
        let command =
            Command { period: period as u64, switched: 0, choice: 0, regulators, demanded, tool, told };
        command.put(&mut message);
        assert_eq!(Command::get(&message), Ok(command));
        bench.commands.write(&message);
        bench.period(period as u64);
    }
    let at = Told::Position(0.0);
    let (switched, carried) = (Told::Outputs, Told::Carry);
    let expected = [at, switched(4, 4), at, carried(0.5), at, switched(4, 0), carried(0.5), at];
    assert_eq!(bench.told(), expected);
}

#[test]
fn the_words_of_a_reading_say_its_currents_and_signals_where_there_are_any() {
    let signals =
        Signals { inputs: Values::new(5, [0.0, 1.5, 0.0, 0.0]), outputs: Values::new(1 << 31, [0.0; 4]) };
    for currents in [None, Some(One::new(2.0))] {
        for signals in [Signals::OFF, signals] {
            let measured = Measured { position: One::new(0.1), velocity: One::new(0.2) };
            let reading = Reading { period: 3, measured, demanded: One::new(0.3), currents, signals };
            let mut message = Message::empty();
            // Words of an earlier message are still there.
            message.body = [7; crate::model::wire::WORDS];
            reading.put(&mut message);
            assert_eq!(Reading::get(&message), Ok(reading));
        }
    }
}

#[test]
fn what_is_no_command_and_no_reading_is_refused() {
    let good = command(1, 0.0);
    assert!(Command::<One>::get(&good).is_ok() && Reading::<One>::get(&good).is_err());
    for kind in [Kind::Read, Kind::Reply, Kind::Fault] {
        let mut other = good;
        other.header.kind = kind;
        assert!(Command::<One>::get(&other).is_err(), "{kind:?}");
    }
    for len in [0, 10, 12, 17, 19, 56, u32::MAX] {
        let mut other = good;
        other.header.len = len;
        assert!(Command::<One>::get(&other).is_err(), "{len}");
        other.header.kind = Kind::Reply;
        assert!(Reading::<One>::get(&other).is_err(), "{len}");
    }
}

#[test]
fn the_sets_of_regulators_are_those_of_the_driver() {
    struct Odd;
    impl Driver<Slide> for Odd {
        fn period(&self) -> Duration {
            Duration::from_millis(1)
        }
        fn measured(&self) -> Result<Measured<One>, DriveFault> {
            Ok(Measured { position: One::zeros(), velocity: One::zeros() })
        }
        fn tick(&mut self, _: &One) -> Result<Measured<One>, DriveFault> {
            self.measured()
        }
        fn has_regulator(&self, joint: usize, set: u8) -> bool {
            joint == 0 && set % 63 < 2
        }
    }
    let sets = RegulatorSets::of(&Odd);
    for set in 0..=u8::MAX {
        assert_eq!(sets.has(0, set), set % 63 < 2, "{set}");
        assert!(!sets.has(1, set) && !sets.has(99, set));
    }
}
