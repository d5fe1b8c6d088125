//! When an EDP switches its robot's outputs, and what a stop makes of them.

use super::*;
use crate::model::drive_fault::DriveFault;
use crate::model::driver::{Channels, Driver, Measured};
use crate::model::load::Load;
use crate::model::signals::{Channel, Outputs, Signals, Value};
use crate::tests::slide::One;

/// What drives were told, in order.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Heard {
    At(f64),
    Outputs(Outputs),
    Carry(f64),
}

struct Hearing {
    exact: Exact,
    heard: Rc<RefCell<Vec<Heard>>>,
    outputs: Outputs,
    load_time: Duration,
}

impl Driver<Slide> for Hearing {
    fn period(&self) -> Duration {
        self.exact.period
    }
    fn measured(&self) -> Result<Measured<One>, DriveFault> {
        Ok(self.exact.measured)
    }
    fn tick(&mut self, demanded: &One) -> Result<Measured<One>, DriveFault> {
        self.heard.borrow_mut().push(Heard::At(demanded[0]));
        self.exact.tick(demanded)
    }
    fn channels(&self) -> Channels {
        Channels::ALL
    }
    fn signals(&self) -> Signals {
        Signals { outputs: *self.outputs.values(), ..Signals::OFF }
    }
    fn switch_outputs(&mut self, outputs: &Outputs) {
        self.heard.borrow_mut().push(Heard::Outputs(*outputs));
        self.outputs = *outputs;
    }
    fn carry(&mut self, load: &Load) {
        self.heard.borrow_mut().push(Heard::Carry(load.mass));
    }
    fn load_time(&self) -> Duration {
        self.load_time
    }
}

const VACUUM: Channel = Channel::Digital(0);
const SPINDLE: Channel = Channel::Digital(1);
const FLOW: Channel = Channel::Analog(2);

fn on(channel: Channel, on: bool) -> Outputs {
    Outputs::NONE.with(channel, Value::Digital(on))
}

/// An EDP with a vacuum that holds, a spindle that is switched off at a stop, and a flow that is; and what its drives hear.
fn switching(servo: Duration) -> (Edp<'static, Slide>, Rc<RefCell<Vec<Heard>>>) {
    taking_loads_in(Duration::ZERO, servo)
}

/// The same, whose robot takes a load when it has stood for this long.
fn taking_loads_in(load_time: Duration, servo: Duration) -> (Edp<'static, Slide>, Rc<RefCell<Vec<Heard>>>) {
    let heard = Rc::<RefCell<Vec<Heard>>>::default();
    let mut config = config(servo);
    let drive =
        Hearing { exact: Exact::new(servo), heard: Rc::clone(&heard), outputs: Outputs::NONE, load_time };
    config.drive = Drive::Here(Box::new(drive));
    let flow = Outputs::NONE.with(FLOW, Value::Analog(0.0));
    let on_stop = on(SPINDLE, false).and(&flow);
    config.declared = Declared { any: true, outputs: on(VACUUM, false).and(&on_stop), on_stop, load: None };
    (Edp::new(config, Host::of(&Still), Box::new(Replies(Rc::default()))), heard)
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

fn ask(edp: &mut Edp<'static, Slide>, kind: RequestKind, flags: u32) -> Message {
    edp.answers.request = Message::new(Kind::Request(kind));
    edp.answers.request.header.flags = flags;
    edp.serve();
    edp.answers.reply
}

fn told(outputs: Outputs, x: f64) -> Demand<Slide> {
    let mut demand = Demand::joints(One::new(x));
    demand.outputs = outputs;
    demand
}

/// A ramp in small steps: the demand of step `k` is `k` micrometres, and that of step 10 switches the vacuum on. Steps and
/// servo periods come in the order of their times.
fn ramp(servo: Duration) -> Vec<Heard> {
    let (mut edp, heard) = switching(servo);
    let (step, servo) = (1_000_000, servo.as_nanos() as Nanos);
    let late = servo.min(step) / 2;
    let mut next = (0, 0);
    while next.0 < 60 {
        if next.0 * step + late <= next.1 * servo + servo / 2 {
            let outputs = if next.0 == 10 { on(VACUUM, true) } else { Outputs::NONE };
            demand(&mut edp, &told(outputs, next.0 as f64 * 1e-6), flag::FIRST, next.0);
            edp.begin_step();
            next.0 += 1;
        } else {
            edp.tick_at(next.1 * servo + servo / 2);
            next.1 += 1;
        }
    }
    heard.take()
}

#[test]
fn an_output_switches_when_the_drives_come_to_the_position_of_its_demand() {
    for micros in [250, 500, 1000, 2000, 4000] {
        let heard = ramp(Duration::from_micros(micros));
        let told = heard.iter().position(|heard| matches!(heard, Heard::Outputs(_))).expect("told");
        assert_eq!(heard[told], Heard::Outputs(on(VACUUM, true)), "{micros} us");
        assert_eq!(heard.iter().filter(|heard| matches!(heard, Heard::Outputs(_))).count(), 1);
        let at = |heard: &Heard| if let Heard::At(x) = heard { *x * 1e6 } else { f64::NAN };
        // The first period that ends at the demand or beyond it; the spline of a ramp is on the ramp.
        let (before, after) = (at(&heard[told - 1]), at(&heard[told + 1]));
        assert!(before < 10.0 - 1e-6 && after >= 10.0 - 1e-6, "{micros} us: {before}, {after}");
    }
}

#[test]
fn a_stop_gives_outputs_their_values_for_it_and_what_was_to_come_does_not() {
    // With a period of 2 ms the drives lie behind the demands.
    let begun = || {
        let (mut edp, heard) = switching(Duration::from_millis(2));
        let flow = Outputs::NONE.with(FLOW, Value::Analog(2.5));
        let all = on(VACUUM, true).and(&on(SPINDLE, true)).and(&flow);
        demand(&mut edp, &told(all, 1e-6), flag::FIRST, 0);
        edp.begin_step();
        (0..5).for_each(|period| edp.tick_at(period * 2_000_000 + 1_000_000));
        demand(&mut edp, &told(on(VACUUM, false), 2e-6), 0, 1);
        edp.begin_step();
        assert!(heard.take().contains(&Heard::Outputs(all)));
        (edp, heard)
    };
    let stopped =
        on(VACUUM, true).and(&on(SPINDLE, false)).and(&Outputs::NONE.with(FLOW, Value::Analog(0.0)));
    let stops: [fn(&mut Edp<'static, Slide>); 4] = [
        |edp| _ = ask(edp, RequestKind::Stop, 0),
        |edp| _ = ask(edp, RequestKind::Brake, flag::ABORTED),
        |edp| _ = ask(edp, RequestKind::Query, flag::ABORTED),
        |edp| edp.stop_for(Fault::new(FaultKind::FollowingError), 1),
    ];
    for (i, stop) in stops.into_iter().enumerate() {
        let (mut edp, heard) = begun();
        stop(&mut edp);
        assert_eq!(heard.take(), [Heard::Outputs(stopped)], "stop {i}: at once");
        stop(&mut edp);
        (5..20).for_each(|period| edp.tick_at(period * 2_000_000 + 1_000_000));
        assert!(heard.take().iter().all(|heard| matches!(heard, Heard::At(_))), "stop {i}: nothing more");
        let signals = edp.signals.signals().outputs;
        assert!(signals.is_on(0) && !signals.is_on(1) && signals.analog(2) == 0.0, "stop {i}");
    }
    // A motion that ends, and a suspension, are no stops.
    for flags in [0, flag::SUSPENDED] {
        let (mut edp, heard) = begun();
        ask(&mut edp, RequestKind::Brake, flags);
        assert!(heard.take().is_empty());
    }
}

#[test]
fn the_image_has_the_values_of_the_signals() {
    let (mut edp, _) = switching(Duration::from_millis(1));
    demand(&mut edp, &told(on(VACUUM, true), 1e-6), flag::FIRST, 0);
    edp.begin_step();
    let image = |edp: &mut Edp<'static, Slide>| {
        let reply = ask(edp, RequestKind::Query, flag::WANT_STATE);
        crate::model::image::RobotImage::<Slide>::get(reply.words()).expect("an image")
    };
    let vacuum = crate::model::signals::Output::<bool>::of(VACUUM).expect("digital");
    assert!(!image(&mut edp).value(vacuum), "not told yet");
    edp.tick_at(500_000);
    assert!(image(&mut edp).value(vacuum));
}

#[test]
fn what_a_robot_cannot_be_told_is_refused_and_moves_nothing() {
    let nan = Outputs::NONE.with(FLOW, Value::Analog(f64::NAN));
    let wrong = [
        (told(on(Channel::Digital(9), true), 1e-6), FaultKind::NoOutput, "no output is named for digital 9"),
        (told(nan, 1e-6), FaultKind::NoOutput, "an analog output is told what is no number"),
        (
            Demand::joints(One::new(1e-6)).with_load(Load { mass: -1.0, ..Load::NONE }),
            FaultKind::Program,
            "the load of a demand is that of no body: its mass is negative, or no number",
        ),
    ];
    for (demanded, kind, text) in wrong {
        let (mut edp, heard) = switching(Duration::from_millis(1));
        let fault = demand(&mut edp, &demanded, flag::FIRST, 0).fault();
        assert_eq!((fault.kind(), fault.message()), (kind, text));
        edp.begin_step();
        edp.tick_at(500_000);
        assert_eq!(heard.take().last(), Some(&Heard::At(0.0)));
    }
}

#[test]
fn a_load_is_told_when_the_step_of_its_demand_begins_and_late_choices_are_in_force_all_the_same() {
    let (mut edp, heard) = switching(Duration::from_millis(1));
    let carried = told(on(VACUUM, true), 1e-6).with_load(Load::point(0.5, nalgebra::Vector3::z()));
    demand(&mut edp, &carried, flag::FIRST, 0);
    assert!(heard.take().is_empty());
    edp.begin_step();
    assert_eq!(heard.take(), [Heard::Carry(0.5)]);
    edp.tick_at(500_000);
    // The demands of steps 1 and 2 are missing; that of step 1 comes too late.
    edp.begin_step();
    edp.begin_step();
    heard.take();
    demand(&mut edp, &told(on(VACUUM, false), 2e-6), 0, 1);
    edp.begin_step();
    edp.tick_at(3_500_000);
    assert!(heard.take().contains(&Heard::Outputs(on(VACUUM, false))));
}

#[test]
fn a_robot_is_told_that_it_carries_nothing_only_after_it_was_told_something_else() {
    let (mut edp, heard) = switching(Duration::from_millis(1));
    // A tool without a mass says nothing of what is set at the robot's pendant.
    for (step, (mass, expected)) in [(0.0, None), (0.5, Some(0.5)), (0.0, Some(0.0))].into_iter().enumerate()
    {
        let position = One::new((step + 1) as f64 * 1e-6);
        let carrying = Demand::joints(position).with_load(Load::point(mass, nalgebra::Vector3::zeros()));
        demand(&mut edp, &carrying, if step == 0 { flag::FIRST } else { 0 }, step as u64);
        heard.take();
        edp.begin_step();
        let carried = |heard| if let Heard::Carry(mass) = heard { Some(mass) } else { None };
        let told: Vec<_> = heard.take().into_iter().filter_map(carried).collect();
        assert_eq!(told, expected.into_iter().collect::<Vec<_>>(), "{mass} kg");
    }
}

/// Steps from the one whose demand tells a load until the robot is at standstill.
fn steps_with_a_load(load_time: Duration) -> u64 {
    let (mut edp, _) = taking_loads_in(load_time, Duration::from_millis(1));
    let carrying = Demand::hold().with_load(Load::point(0.5, nalgebra::Vector3::zeros()));
    demand(&mut edp, &carrying, flag::FIRST, 0);
    (1..100)
        .find(|step| {
            edp.begin_step();
            edp.tick_at((step - 1) * 1_000_000 + 500_000);
            ask(&mut edp, RequestKind::Brake, 0);
            edp.is_at_standstill()
        })
        .expect("at standstill")
}

#[test]
fn a_motion_that_tells_a_load_is_over_when_the_robot_has_stood_for_the_time_that_it_needs_and_a_stop_at_once()
{
    let at_once = steps_with_a_load(Duration::ZERO);
    for (micros, steps) in [(1000, 1), (20_000, 20), (19_500, 20)] {
        assert_eq!(steps_with_a_load(Duration::from_micros(micros)) - at_once, steps, "{micros} us");
    }
    let (mut edp, _) = taking_loads_in(Duration::from_secs(10), Duration::from_millis(1));
    let carrying = Demand::hold().with_load(Load::point(0.5, nalgebra::Vector3::zeros()));
    demand(&mut edp, &carrying, flag::FIRST, 0);
    for step in 0..10 {
        edp.begin_step();
        edp.tick_at(step * 1_000_000 + 500_000);
    }
    ask(&mut edp, RequestKind::Brake, 0);
    assert!(!edp.is_at_standstill());
    ask(&mut edp, RequestKind::Stop, 0);
    assert!(edp.is_at_standstill(), "no stop waits for it");
}
