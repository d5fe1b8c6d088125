//! A person jogs arms of running cells, on the memory link: how fast, how soon they stand, and what they do at their limits.

use core::time::Duration;
use std::cell::RefCell;
use std::rc::Rc;

use mrroc::cell::{CellError, OutputSetup, RunReport};
use mrroc::fault::{Name, ProcessId};
use mrroc::link::Nanos;
use mrroc::observe::ServoRecord;
use mrroc::observe::step_observer::{StepEvent, StepObserver, StepRecord};
use mrroc::operator::jog::{JogOrder, JogPanel};
use mrroc::operator::{LAPSE, Operator, REDUCED_SPEED, Renewal};
use mrroc::payload::Wire;
use mrroc::prelude::*;
use mrroc::robot::{Channel, Signals, Value};
use mrroc_generators::generators::{JointMove, PanelJog};
use mrroc_robots::{Irp6, SimulatedIrp6, Six};

const STEP: Duration = Duration::from_millis(2);
/// Steps between two renewals of a button that is held, and until a hold lapses.
const BEAT: u64 = 50;
const LAPSED: u64 = 150;
const HOME: Six = Irp6::READY;

fn order(text: &str) -> JogOrder {
    JogOrder::read(&mut text.split_whitespace()).expect(text)
}

fn left() -> Name {
    Name::new("left").expect("a name")
}

/// A person at a console: presses a button at a step, renews it, and lets it go, or is gone.
#[derive(Clone)]
struct Press {
    text: String,
    steps: std::ops::Range<u64>,
    /// Whether the button is let go at the end; else nothing is heard any more.
    lets_go: bool,
}

fn press(text: &str, steps: std::ops::Range<u64>) -> Press {
    Press { text: text.to_owned(), steps, lets_go: true }
}

/// Does what a person does, at reduced speed from the first step on.
fn operate(presses: Vec<Press>, done: u64) -> impl FnMut(u64, &Operator) {
    move |step, operator| {
        if step == 1 {
            operator.set_reduced(true);
        }
        for Press { text, steps, lets_go } in &presses {
            // Each press has a number of its own, which grows.
            if steps.contains(&step) && (step - steps.start).is_multiple_of(BEAT) {
                let renewal = Renewal::of(steps.start, (step - steps.start) / BEAT).expect("few");
                operator.jog(renewal, left(), order(text));
            }
            if step == steps.end && *lets_go {
                operator.let_go(steps.start);
            }
        }
        if step == done {
            operator.end_jog(left());
            // The rest of the program may move at full speed.
            operator.set_reduced(false);
            operator.resume();
        }
    }
}

/// What was seen of a run.
#[derive(Default)]
struct Seen {
    /// Path time of each step [s], by its index.
    dt: RefCell<Vec<f64>>,
    /// Joints that were demanded in each servo period [rad].
    joints: RefCell<Vec<Six>>,
    /// Steps from which on something was asked of a robot.
    jogs: RefCell<Vec<u64>>,
}

impl StepObserver for Seen {
    fn see(&self, _: Nanos, _: ProcessId, what: &StepEvent, _: &[u64]) {
        match *what {
            StepEvent::Step(StepRecord { step, dt, .. }) => {
                self.dt.borrow_mut().resize(step as usize, f64::NAN);
                self.dt.borrow_mut().push(dt);
            }
            StepEvent::Jog { step, .. } => self.jogs.borrow_mut().push(step),
            _ => {}
        }
    }
}

impl Seen {
    /// The speed of the tool in each servo period [m/s], and how fast it turns [rad/s].
    fn speeds(&self, arm: &Irp6, tool: &Pose) -> Vec<(f64, f64)> {
        let poses: Vec<_> = self.joints.borrow().iter().map(|q| arm.forward(q) * tool).collect();
        let between = |two: &[Pose]| {
            let (a, b) = (two[0], two[1]);
            let distance = (b.translation.vector - a.translation.vector).norm();
            (distance / STEP.as_secs_f64(), a.rotation.angle_to(&b.rotation) / STEP.as_secs_f64())
        };
        poses.windows(2).map(between).collect()
    }
}

fn tool() -> Pose {
    Pose::translation(0.05, 0.0, 0.15)
}

/// An arm `left` from these joints on, whose program lets it be jogged, and then turns its column to 0.1 rad.
fn left_arm(seen: &Rc<Seen>, start: Six) -> RobotSetup<Irp6> {
    let keep = Rc::clone(seen);
    let setup = RobotSetup::new("left", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &start));
    setup
        .tool(tool())
        .observe(move |record: &ServoRecord<Irp6>| keep.joints.borrow_mut().push(record.demanded))
        .program(|ecp| {
            let panel = ecp.jog_panel();
            ecp.move_robot((), PanelJog::by(panel))?;
            let mut to = ecp.image().demanded().joints;
            to[0] = 0.1;
            ecp.move_robot((), JointMove::to(to, Six::repeat(0.4), Six::repeat(0.8))).map(drop)
        })
}

fn run(start: Six, presses: Vec<Press>, done: u64) -> (Rc<Seen>, Result<RunReport, CellError>) {
    let seen = Rc::new(Seen::default());
    let cell = Cell::new(STEP).robot(left_arm(&seen, start));
    let cell = cell.on_step(operate(presses, done)).observed_by(Rc::clone(&seen) as Rc<dyn StepObserver>);
    let outcome = cell.run();
    (seen, outcome)
}

#[test]
fn an_arm_goes_where_it_is_jogged_and_on_with_its_program_when_that_is_done() {
    let arm = Irp6::nominal();
    let at = |seen: &Seen, step: usize| arm.forward(&seen.joints.borrow()[step]) * tool();
    let presses = vec![
        press("world z -50% by 0.05", 100..900),
        press("tool x 30% by 0.02", 1100..1900),
        press("world rz 100% by 0.1", 2100..2900),
        press("joint 4 -50% by 0.04", 3100..3900),
        press("joint 1 50%", 4100..4500),
    ];
    let (seen, outcome) = run(HOME, presses, 5000);
    outcome.expect("no fault");
    let all = [90, 1000, 2000, 3000, 4000, 4700].map(|step| at(&seen, step));
    let joints = |step: usize| seen.joints.borrow()[step];
    assert!((joints(90) - HOME).amax() < 1e-5, "the encoders' resolution");
    let moved = |i: usize| all[i + 1].translation.vector - all[i].translation.vector;
    let turned = |i: usize| (all[i + 1].rotation * all[i].rotation.inverse()).scaled_axis();
    // Increments end where they were asked to, to the rounding of the inverse kinematics.
    let near = |a: nalgebra::Vector3<f64>, b: nalgebra::Vector3<f64>| (a - b).norm() < 1e-9;
    assert!(near(moved(0), nalgebra::Vector3::z() * -0.05) && turned(0).norm() < 1e-9, "{}", moved(0));
    assert!(near(moved(1), all[1].rotation * nalgebra::Vector3::x() * 0.02), "{}", moved(1));
    assert!(near(turned(2), nalgebra::Vector3::z() * 0.1) && moved(2).norm() < 1e-9, "{}", turned(2));
    let by = joints(4000) - joints(3000);
    assert!((by[3] + 0.04).abs() < 1e-12 && by.norm() < 0.04 + 1e-12, "{by}");
    // As long as it is held, 0.8 s: half of 95 % of 250 mm/s on the tool's circle about the column.
    let by = joints(4700) - joints(4000);
    let turning = 0.5 * 0.95 * REDUCED_SPEED / all[4].translation.vector.xy().norm();
    assert!((0.5 * 0.8 * turning..1.1 * 0.8 * turning).contains(&by[0]) && by.norm() == by[0], "{by}");
    let end = *seen.joints.borrow().last().expect("steps");
    assert!((end[0] - 0.1).abs() < 1e-9, "{end}");
}

#[test]
fn fault_232_a_jog_that_is_let_go_or_no_longer_renewed_slows_down_within_three_steps_and_stands() {
    // A hundred presses of each end, each of another length, so that they end in all phases of the motion.
    for lets_go in [true, false] {
        let mut presses = Vec::new();
        let (mut step, mut side) = (100, "");
        for i in 0..100 {
            let lasts = 60 + 7 * i % 300;
            let text = format!("world {} {side}80%", ["x", "y", "rz"][i as usize % 3]);
            presses.push(Press { text, steps: step..step + lasts, lets_go });
            // A person jogs to and fro.
            side = if i % 6 < 3 { "-" } else { "" };
            step += lasts + LAPSED + 250;
        }
        let (seen, outcome) = run(HOME, presses.clone(), step);
        outcome.expect("no fault");
        let (dt, joints) = (seen.dt.borrow(), seen.joints.borrow());
        for Press { steps, text, .. } in &presses {
            let renewed = steps.start + (steps.end - 1 - steps.start) / BEAT * BEAT;
            let ends = (if lets_go { steps.end } else { renewed + LAPSED }) as usize;
            let name = format!("{text} in {steps:?}, let go {lets_go}");
            assert!(dt[ends - 1] > 0.0 && dt[ends] > 0.0, "{name}: it moves until then");
            assert!(dt[ends + 3] < dt[ends].max(dt[ends - 1]), "{name}: the rate falls within three steps");
            // The rate takes 0.2 s from 1 to 0 where the robot leaves room for it.
            let stands = ends + 130;
            assert!(dt[stands] == 0.0, "{name}: the rate is 0");
            let next = (stands + 100).min(joints.len());
            assert!(joints[stands..next].iter().all(|q| *q == joints[stands]), "{name}: it stands");
        }
    }
    assert_eq!(LAPSE, STEP * LAPSED as u32);
}

/// Postures all over the workspace, also near its ends.
fn postures() -> [Six; 4] {
    [
        HOME,
        Six::new(0.8, -1.4, 0.1, -0.1, 4.5, 0.7),
        Six::new(-1.5, -1.8, 0.3, -0.3, 4.7, -1.0),
        Six::new(0.2, -1.3, 0.0, -0.3, 4.6, 1.0),
    ]
}

#[test]
fn fault_233_no_jog_moves_the_tool_faster_than_250_mm_per_second_and_none_breaks_a_limit() {
    let arm = Irp6::nominal();
    let mut motions = Vec::new();
    for side in ["", "-"] {
        for frame in ["tool", "world"] {
            motions
                .extend(["x", "y", "z", "rx", "ry", "rz"].map(|axis| format!("{frame} {axis} {side}100%")));
        }
        motions.extend((1..=6).map(|joint| format!("joint {joint} {side}100%")));
    }
    let mut fastest = (0.0_f64, 0.0_f64);
    for start in postures() {
        let mut step = 100;
        let mut presses = Vec::new();
        for text in &motions {
            // Long enough to come to the end of the arm's reach or of a joint.
            presses.push(press(text, step..step + 2500));
            step += 2500 + 200;
        }
        let (seen, outcome) = run(start, presses, step);
        outcome.expect("soft stops, and no fault");
        for (speed, turn) in seen.speeds(&arm, &tool()) {
            assert!(speed <= REDUCED_SPEED * (1.0 + 1e-9), "{speed} m/s");
            fastest = (fastest.0.max(speed), fastest.1.max(turn));
        }
        let limits = arm.limits();
        for q in seen.joints.borrow().iter() {
            assert!((0..6).all(|i| q[i] >= limits.lower[i] && q[i] <= limits.upper[i]), "{q}");
        }
    }
    // They come near to what they may.
    assert!(fastest.0 > 0.9 * REDUCED_SPEED && fastest.1 > 0.45, "{fastest:?}");
}

#[test]
fn fault_234_a_robot_whose_program_does_not_let_it_be_jogged_stands_and_so_does_one_beside_another_that_moves()
 {
    let run = |beside: bool, jogs: bool| {
        let (seen, other) = (Rc::new(Seen::default()), Rc::new(Seen::default()));
        let mut setup = left_arm(&seen, HOME);
        if !jogs {
            setup = setup.program(|ecp| ecp.move_robot((), to_and_fro()).map(drop));
        }
        let mut cell = Cell::new(STEP).robot(setup);
        if beside {
            let keep = Rc::clone(&other);
            let right = RobotSetup::new("right", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &HOME));
            let right = right
                .observe(move |record: &ServoRecord<Irp6>| keep.joints.borrow_mut().push(record.demanded))
                .program(|ecp| ecp.move_robot((), to_and_fro()).map(drop));
            cell = cell.robot(right);
        }
        let cell = cell.observed_by(Rc::clone(&seen) as Rc<dyn StepObserver>);
        let cell = cell.on_step(operate(vec![press("joint 1 50%", 1000..3000)], 4000));
        cell.run().expect("no fault");
        (seen, other)
    };
    // At reduced speed from the first step on, all of them stand; the jog moves neither robot.
    for (beside, jogs) in [(true, true), (false, false)] {
        let (seen, other) = run(beside, jogs);
        assert!(seen.jogs.borrow().first().is_none_or(|step| *step >= 4000), "nothing is asked for");
        for one in [&seen, &other] {
            let joints = one.joints.borrow();
            assert!(joints.iter().take(3999).skip(300).all(|q| *q == joints[300]), "{beside} {jogs}");
        }
        assert!(seen.dt.borrow()[300..3999].iter().all(|dt| *dt == 0.0), "no path time passes");
    }
    // The first one is jogged when it is alone: in 0.6 s, some time after its beginning, by half of 95 % of 250 mm/s at the tool, on
    // its circle about the column.
    let (seen, _) = run(false, true);
    let joints = seen.joints.borrow();
    let by = joints[1600] - joints[1300];
    let radius = (Irp6::nominal().forward(&joints[1300]) * tool()).translation.vector.xy().norm();
    let turned = 0.6 * 0.5 * 0.95 * REDUCED_SPEED / radius;
    assert!((by[0] - turned).abs() < 1e-3 * turned && by.norm() == by[0].abs(), "{by} {turned}");
    // And so is the other one when it moves by its program at full speed: it comes to where that takes it.
    let (_, other) = run(true, true);
    assert!((other.joints.borrow().last().expect("steps")[0] - 0.5).abs() < 1e-9);
}

/// An arm `right` whose program lets it be jogged until the operator aborts.
fn right_arm(seen: &Rc<Seen>) -> RobotSetup<Irp6> {
    let keep = Rc::clone(seen);
    RobotSetup::new("right", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &HOME))
        .observe(move |record: &ServoRecord<Irp6>| keep.joints.borrow_mut().push(record.demanded))
        .program(|ecp| {
            let panel = ecp.jog_panel();
            ecp.move_robot((), PanelJog::by(panel)).map(drop)
        })
}

#[test]
fn fault_239_a_hold_that_goes_over_to_another_robot_moves_neither() {
    let (seen, other) = (Rc::new(Seen::default()), Rc::new(Seen::default()));
    let cell = Cell::new(STEP).robot(left_arm(&seen, HOME)).robot(right_arm(&other));
    let right = Name::new("right").expect("a name");
    let cell = cell.observed_by(Rc::clone(&seen) as Rc<dyn StepObserver>).on_step(move |step, operator| {
        let renewal = |count| Renewal::of(100, count).expect("few");
        match step {
            1 => operator.set_reduced(true),
            100 => operator.jog(renewal(0), left(), order("world x 50%")),
            200 => operator.jog(renewal(2), left(), order("world x 50%")),
            // From now on the same hold names the other arm.
            250..1000 if step % BEAT == 0 => {
                operator.jog(renewal(step / BEAT), right, order("world x 50%"));
            }
            // A hold of its own moves it.
            1000 => operator.jog(Renewal::of(1000, 0).expect("few"), right, order("world x 50%")),
            1500 => operator.abort(),
            _ => {}
        }
    });
    cell.run().expect_err("aborted");
    let (left, right) = (seen.joints.borrow(), other.joints.borrow());
    assert!((left[340] - left[250]).norm() > 1e-3, "it is jogged until its last renewal has lapsed");
    let stands = (200 + LAPSED) as usize + 130;
    assert!(left[stands..1400].iter().all(|q| *q == left[stands]), "then it stands");
    assert!(right[90..1000].iter().all(|q| *q == right[90]), "and the other one was not moved");
    assert!((right[1100] - right[1000]).norm() > 1e-3, "but it is by a hold of its own");
}

/// When an output of an arm changes, by the step of its EDP, and to what: a digital one to 0 or 1.
struct Switched {
    channel: Channel,
    changes: RefCell<Vec<(u64, f64)>>,
}

impl StepObserver for Switched {
    fn see(&self, _: Nanos, by: ProcessId, what: &StepEvent, words: &[u64]) {
        let StepEvent::Signals { step } = *what else { return };
        assert_eq!(by.name, Some(left()));
        let outputs = Signals::get(words).expect("signals").outputs;
        let value = match self.channel {
            Channel::Digital(number) => f64::from(u8::from(outputs.is_on(number))),
            Channel::Analog(number) => outputs.analog(number),
        };
        let mut changes = self.changes.borrow_mut();
        if changes.last().map_or(0.0, |(_, last)| *last) != value {
            changes.push((step, value));
        }
    }
}

#[test]
fn fault_246_a_person_switches_outputs_of_an_arm_that_stands_and_none_that_would_start_a_tool() {
    let run = |channel, presses: Vec<Press>| {
        let seen = Rc::new(Seen::default());
        let switched = Rc::new(Switched { channel, changes: RefCell::default() });
        let arm = left_arm(&seen, HOME)
            .output(OutputSetup::new("gripper", Channel::Digital(0)).holds_body())
            .output(
                OutputSetup::new("spindle", Channel::Digital(1)).turns_tool().on_stop(Value::Digital(false)),
            )
            .output(OutputSetup::new("valve", Channel::Analog(0)));
        let cell = Cell::new(STEP).robot(arm).observed_by(Rc::clone(&switched) as Rc<dyn StepObserver>);
        cell.on_step(operate(presses, 2500)).run().expect("no fault");
        let joints = seen.joints.borrow();
        assert!(
            joints[90..2000].iter().all(|q| *q == joints[90]),
            "no arm moves because an output is switched"
        );
        switched.changes.borrow().clone()
    };
    let near = |changes: &[(u64, f64)], expected: &[(u64, f64)]| {
        let alike = |(a, b): (&(u64, f64), &(u64, f64))| a.1 == b.1 && (b.0..b.0 + 6).contains(&a.0);
        changes.len() == expected.len() && changes.iter().zip(expected).all(alike)
    };
    // It stays as it was switched, also when the program goes on.
    let changes = run(
        Channel::Digital(0),
        vec![
            press("output gripper on", 100..160),
            press("output gripper off", 700..760),
            press("output gripper on", 900..960),
        ],
    );
    assert!(near(&changes, &[(100, 1.0), (700, 0.0), (900, 1.0)]), "{changes:?}");
    let changes = run(Channel::Analog(0), vec![press("output valve 0.35", 100..160)]);
    assert!(near(&changes, &[(100, 0.35)]), "{changes:?}");
    // A spindle is not started by a button, and nothing is that is not there or of the other type.
    let refused = ["output spindle on", "output gripper 1", "output valve on", "output lamp on"];
    for text in refused {
        for channel in [Channel::Digital(0), Channel::Digital(1), Channel::Analog(0)] {
            assert_eq!(run(channel, vec![press(text, 100..160)]), [], "{text}");
        }
    }
}

#[test]
fn fault_246_an_output_is_switched_when_the_arm_has_come_to_rest() {
    let seen = Rc::new(Seen::default());
    let switched = Rc::new(Switched { channel: Channel::Digital(0), changes: RefCell::default() });
    let arm = left_arm(&seen, HOME).output(OutputSetup::new("gripper", Channel::Digital(0)));
    let cell = Cell::new(STEP).robot(arm).observed_by(Rc::clone(&switched) as Rc<dyn StepObserver>);
    // One button is let go and the next one pressed in the same step, while the arm moves.
    let presses = vec![press("joint 1 100%", 100..400), press("output gripper on", 400..1400)];
    cell.on_step(operate(presses, 1500)).run().expect("no fault");
    let (joints, changes) = (seen.joints.borrow(), switched.changes.borrow());
    let stands = (400..).find(|&i| joints[i + 1] == joints[i]).expect("it comes to rest");
    assert!(stands > 410 && stands < 1000, "{stands}");
    let [(step, on)] = changes[..] else { panic!("{changes:?}") };
    assert!(
        on == 1.0 && (stands as u64..stands as u64 + 8).contains(&step),
        "at {step}, at rest at {stands}"
    );
}

/// Half a radian there.
fn to_and_fro() -> JointMove<Irp6> {
    let mut to = HOME;
    to[0] = 0.5;
    JointMove::to(to, Six::repeat(0.4), Six::repeat(0.8))
}

#[test]
fn an_mp_lets_one_of_its_arms_be_jogged_as_an_ecp_does() {
    let seen = Rc::new(Seen::default());
    let keep = Rc::clone(&seen);
    let arm = |name: &str| RobotSetup::new(name, Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &HOME));
    let observed =
        arm("left").observe(move |record: &ServoRecord<Irp6>| keep.joints.borrow_mut().push(record.demanded));
    let cell = Cell::new(STEP).robot(observed).robot(arm("right")).program(|mp| {
        let (mut left, mut right) = (mp.robot::<Irp6>("left")?, mp.robot::<Irp6>("right")?);
        let (of_left, of_right): (JogPanel<Irp6>, _) = (mp.jog_panel(&left)?, mp.jog_panel(&right)?);
        let both = Each::of((PanelJog::by(of_left), PanelJog::by(of_right)));
        mp.move_robots((&mut left, &mut right), (), both).map(drop)
    });
    // The right one is never done: the operator ends the instruction.
    let mut operate = operate(vec![press("world x 50% by 0.1", 100..1500)], 1600);
    let cell = cell.on_step(move |step, operator| {
        operate(step, operator);
        if step == 1700 {
            operator.abort();
        }
    });
    cell.run().expect_err("aborted");
    let (joints, arm) = (seen.joints.borrow(), Irp6::nominal());
    let displacement =
        arm.forward(&joints[1550]).translation.vector - arm.forward(&joints[90]).translation.vector;
    assert!((displacement - nalgebra::Vector3::x() * 0.1).norm() < 1e-9, "{displacement}");
}

#[test]
fn a_step_of_an_arm_that_is_jogged_allocates_nothing_also_when_a_jog_begins_or_comes_to_an_end() {
    use mrroc_counting_allocator::allocations;
    // Down, turned, by a joint, back: each is pressed for 300 steps, renewed every 50th, and let go for 200.
    let orders = ["world z -60%", "tool rx 50%", "joint 1 40%", "world z 60% by 0.01"].map(order);
    let (counts, seen) =
        (Rc::new(std::cell::Cell::new((0, 0))), Rc::new(std::cell::Cell::new((HOME, 0_u32))));
    let (counted, moved) = (Rc::clone(&counts), Rc::clone(&seen));
    let arm = RobotSetup::new("left", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &HOME));
    let arm = arm.tool(tool()).observe(move |record: &ServoRecord<Irp6>| {
        let (before, periods) = moved.get();
        moved.set((record.demanded, periods + u32::from(before != record.demanded)));
    });
    let arm = arm.program(|ecp| {
        let panel = ecp.jog_panel();
        ecp.move_robot((), PanelJog::by(panel)).map(drop)
    });
    let name = left();
    let cell = Cell::new(STEP).robot(arm).on_step(move |step, operator| {
        match step {
            1 => operator.set_reduced(true),
            600 => counted.set((allocations(), 0)),
            9_000 => counted.set((counted.get().0, allocations())),
            9_100 => operator.abort(),
            _ => {}
        }
        let (press, at) = (step / 500, step % 500);
        if step >= 500 && at < 300 && at.is_multiple_of(BEAT) {
            operator.jog(Renewal::of(press, at / BEAT).expect("few"), name, orders[press as usize % 4]);
        } else if at == 300 {
            operator.let_go(press);
        }
    });
    cell.run().expect_err("aborted");
    let (warm, end) = counts.get();
    assert!(warm > 0, "nothing was counted");
    assert!(seen.get().1 > 2000, "it is jogged: in {} periods", seen.get().1);
    assert_eq!(end - warm, 0, "allocations in 8400 steps");
}
