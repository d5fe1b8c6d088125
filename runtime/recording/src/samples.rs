//! What the messages of a recording say.
//!
//! In: the topic and the JSON of a message, and the layout of its cell. Out: the sample in its own terms, to the bit. This is the one place that
//! reads what [`StepEvent::sample`](mrroc_core::observe::step_observer::StepEvent::sample) writes: replays, pages and exports take it from here.

use mrroc_core::fault::{Name, ProcessId, Role};
use mrroc_core::link::Nanos;
use mrroc_core::observe::layout::{Layout, SignalLayout};
use mrroc_core::observe::step_observer::{ReadingState, StepRecord};
use mrroc_core::operator::state::InstructionKind;
use mrroc_core::payload::{Shape, Wire};
use mrroc_core::pose::Pose;
use mrroc_core::robot::{Channel, Signals, Value as Signal};
use serde_json::Value;

use super::json::{as_number, pose, words};

/// A message of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordedMessage<'a> {
    /// Its topic.
    pub topic: &'a str,
    /// The date of the cell's time 0 \[ns since 1970, UTC\].
    pub start: Nanos,
    /// Its time on the cell's clock \[ns\].
    pub time: Nanos,
    /// What it says.
    pub json: &'a [u8],
}

/// What a process showed. Robots, sensors and bodies are named by their places in the layout.
#[derive(Clone, Debug, PartialEq)]
pub enum Sample {
    /// The MP begins a step.
    Step(StepRecord),
    /// An instruction of a program begins, or is over.
    Instruction {
        /// Whose program it is.
        process: ProcessId,
        /// What is done from now on.
        doing: InstructionKind,
        /// Its generator or condition; empty where it has none.
        by: String,
    },
    /// A line of `/events`.
    Event {
        /// Whose it is.
        process: ProcessId,
        /// The step.
        step: u64,
        /// What happened, such as `fault`.
        what: String,
        /// More about it; may be empty.
        text: String,
    },
    /// A robot begins a step.
    Image(Box<RobotSample>),
    /// What the inputs of a robot read and its outputs are.
    Signals {
        /// The robot.
        robot: usize,
        /// The step.
        step: u64,
        /// By their channels.
        signals: Signals,
    },
    /// A process has collected a reading.
    Reading {
        /// The sensor.
        sensor: usize,
        /// Who collected it.
        by: ProcessId,
        /// The step in which it was collected.
        step: u64,
        /// The step in which it was taken; 0 of one that is not there.
        taken: u64,
        /// What was collected.
        state: ReadingState,
        /// The words of the reading, or of the fault.
        words: Vec<u64>,
    },
    /// Where a body is, `X_WB`; `None`: nobody knows.
    Body {
        /// The body.
        body: usize,
        /// Its pose.
        pose: Option<Pose>,
    },
    /// About a robot, a sensor or a body that the layout does not have.
    Unknown,
    /// What is in a recording for viewers alone: orders, currents, requests of consoles, scenes; and what lower cells show.
    Other,
}

/// A robot at the beginning of a step.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotSample {
    /// Its place in the layout.
    pub robot: usize,
    /// The step.
    pub step: u64,
    /// As it is demanded to be.
    pub demanded: StateSample,
    /// As it is measured.
    pub measured: StateSample,
    /// The tool in force, `X_FE`; `None`: nobody knows.
    pub tool: Option<Pose>,
}

/// A state of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct StateSample {
    /// Joint positions [rad or m].
    pub joints: Vec<f64>,
    /// Joint velocities [rad/s or m/s].
    pub velocity: Vec<f64>,
    /// The pose of its tool, `X_WE`; `None`: nobody knows.
    pub pose: Option<Pose>,
}

impl RecordedMessage<'_> {
    /// What it says in a cell of this layout; `None`: it does not fit.
    #[must_use]
    pub fn sample(&self, layout: &Layout) -> Option<Sample> {
        let json = || serde_json::from_slice::<Value>(self.json).ok();
        let parts: Vec<_> = self.topic.split('/').skip(1).collect();
        let found = |place: Option<usize>, read: &dyn Fn(usize, &Value) -> Option<Sample>| match place {
            Some(place) => read(place, &json()?),
            None => Some(Sample::Unknown),
        };
        let robot = |name| layout.robots.iter().position(|robot| robot.name == name);
        match *parts.as_slice() {
            ["steps"] => {
                let (mut json, mut record) = (json()?, Vec::new());
                // The first recordings do not have it.
                json.as_object_mut()?.entry("reduced").or_insert(Value::Bool(false));
                words(StepRecord::SHAPE, &json, &mut record)?;
                StepRecord::get(&record).ok().map(Sample::Step)
            }
            ["instructions"] => instruction(&json()?),
            ["events"] => event(&json()?),
            ["robots", name] => found(robot(name), &|place, json| {
                image(place, layout.robots[place].joints.len(), json)
                    .map(|image| Sample::Image(Box::new(image)))
            }),
            ["robots", name, "signals"] => found(robot(name), &|robot, json| {
                let signals = signals(&layout.robots[robot].signals, json)?;
                Some(Sample::Signals { robot, step: json["step"].as_u64()?, signals })
            }),
            ["sensors", name] => {
                let place = layout.sensors.iter().position(|sensor| sensor.name == name);
                found(place, &|place, json| reading(place, layout.sensors[place].reading, json))
            }
            ["bodies", name] => {
                let place = layout.bodies.iter().position(|body| body.name == name);
                found(place, &|body, json| Some(Sample::Body { body, pose: pose(&json["pose"]) }))
            }
            _ => Some(Sample::Other),
        }
    }
}

fn instruction(json: &Value) -> Option<Sample> {
    let word = json["doing"].as_str()?;
    let doing = InstructionKind::ALL.into_iter().find(|doing| doing.word() == word)?;
    Some(Sample::Instruction {
        process: process(json["process"].as_str()?)?,
        doing,
        by: json["by"].as_str()?.to_owned(),
    })
}

fn event(json: &Value) -> Option<Sample> {
    Some(Sample::Event {
        process: process(json["process"].as_str()?)?,
        step: json["step"].as_u64()?,
        what: json["what"].as_str()?.to_owned(),
        text: json["text"].as_str()?.to_owned(),
    })
}

fn image(robot: usize, joints: usize, json: &Value) -> Option<RobotSample> {
    let numbers = |json: &Value| -> Option<Vec<f64>> {
        let list = json.as_array().filter(|list| list.len() == joints)?;
        list.iter().map(as_number).collect()
    };
    let state = |json: &Value| {
        Some(StateSample {
            joints: numbers(&json["joints"])?,
            velocity: numbers(&json["velocity"])?,
            pose: pose(&json["pose"]),
        })
    };
    Some(RobotSample {
        robot,
        step: json["step"].as_u64()?,
        demanded: state(&json["demanded"])?,
        measured: state(&json["measured"])?,
        tool: pose(&json["tool"]),
    })
}

fn signals(known: &[SignalLayout], json: &Value) -> Option<Signals> {
    let mut signals = Signals::OFF;
    for SignalLayout { name, channel, is_output, .. } in known {
        let of = if *is_output { "outputs" } else { "inputs" };
        let value = match channel {
            Channel::Digital(_) => Signal::Digital(json[of][name].as_bool()?),
            Channel::Analog(_) => Signal::Analog(as_number(&json[of][name])?),
        };
        let values = if *is_output { &mut signals.outputs } else { &mut signals.inputs };
        values.set(*channel, value);
    }
    Some(signals)
}

fn reading(sensor: usize, shape: &Shape, json: &Value) -> Option<Sample> {
    let mut spelled = Vec::new();
    let states = [ReadingState::There, ReadingState::Fault, ReadingState::None, ReadingState::Lost];
    let word = json["state"].as_str()?;
    let state = states.into_iter().find(|state| state.word() == word)?;
    match state {
        ReadingState::There => words(shape, &json["reading"], &mut spelled)?,
        ReadingState::Fault => {
            let fault = &json["fault"];
            words(&Shape::Words(fault.as_array()?.len()), fault, &mut spelled)?;
        }
        ReadingState::None | ReadingState::Lost => {}
    }
    let by = process(json["by"].as_str()?)?;
    let (step, taken) = (json["step"].as_u64()?, json["taken"].as_u64().unwrap_or(0));
    Some(Sample::Reading { sensor, by, step, taken, state, words: spelled })
}

/// Reads the name of a process, such as `mp` or `ecp arm`.
fn process(text: &str) -> Option<ProcessId> {
    let (role, name) = text.split_once(' ').unwrap_or((text, ""));
    let role = match role {
        "mp" => return Some(ProcessId::MP),
        "ecp" => Role::Ecp,
        "edp" => Role::Edp,
        "vsp" => Role::Vsp,
        _ => return None,
    };
    Some(ProcessId::new(role, Name::new(name).ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::channels::write_fields;
    use core::time::Duration;
    use mrroc::prelude::*;
    use mrroc_core::fault::{Fault, FaultKind, FaultWords};
    use mrroc_core::generator::TypeName;
    use mrroc_core::nalgebra::{Quaternion, UnitQuaternion, Vector3};
    use mrroc_core::observe::layout::{HardwareLayout, SensorLayout};
    use mrroc_core::observe::step_observer::{Mode, StepEvent};
    use mrroc_core::pose::Wrench;
    use mrroc_core::robot::{MAX_JOINTS, Values};
    use mrroc_core::sensor::VspMode;
    use mrroc_robots::{Gripper, One, Simulated};
    use proptest::prelude::*;

    const STATE: usize = 2 * MAX_JOINTS + 7;

    /// A gripper with an input and an output of each sort, a sensor of forces, and a brick.
    fn layout() -> Layout {
        let hand = RobotSetup::new("hand", Gripper::new(), Simulated::new(Gripper::new(), &One::new(0.05)));
        let cell =
            Cell::new(Duration::from_millis(2)).robot(hand).shows_body("brick", [0.1; 3], Pose::identity);
        let mut layout = cell.layout();
        layout.robots[0].signals = [
            ("closed", Channel::Digital(2), false),
            ("force", Channel::Analog(1), false),
            ("valve", Channel::Digital(4), true),
            ("flow", Channel::Analog(0), true),
        ]
        .map(|(name, channel, is_output)| SignalLayout {
            name: name.to_owned(),
            channel,
            is_output,
            note: String::new(),
        })
        .to_vec();
        layout.sensors.push(SensorLayout {
            name: "wrist".to_owned(),
            kind: "wrench",
            of: None,
            readers: Vec::new(),
            every: 1,
            stale_after: Duration::ZERO,
            mode: VspMode::Interactive,
            latency: Duration::ZERO,
            reading: Wrench::SHAPE,
            reading_layout: 0,
            hardware: HardwareLayout::Nothing,
        });
        layout
    }

    fn of(role: Role) -> ProcessId {
        ProcessId::new(role, Name::new("hand").expect("a name"))
    }

    /// What the message says that an event makes in a recording.
    fn said(event: &StepEvent, by: ProcessId, words: &[u64]) -> Option<Sample> {
        let (layout, topic, mut json) = (layout(), event.topic(by).to_string(), String::new());
        event.sample(7, by, words, &layout, &mut |fields| write_fields(&mut json, fields));
        RecordedMessage { topic: &topic, start: 0, time: 7, json: json.as_bytes() }.sample(&layout)
    }

    fn words_of(value: &impl Wire) -> Vec<u64> {
        let mut words = vec![0; 64];
        value.put(&mut words);
        words
    }

    fn turned([x, y, z, i, j, k]: [f64; 6]) -> Pose {
        Pose::from_parts(
            Vector3::new(x, y, z).into(),
            UnitQuaternion::new_normalize(Quaternion::new(1.0, i, j, k)),
        )
    }

    fn numbers<const N: usize>() -> impl Strategy<Value = [f64; N]> {
        core::array::from_fn(|_| -1e3..1e3_f64)
    }

    proptest! {
        #[test]
        fn a_step_is_read_as_it_was_shown(
            (step, dt, duration, speed) in (any::<u64>(), 0.0..1.0_f64, 0.0..1.0_f64, 0.0..1.0_f64),
            [suspended, reduced, aborting, stopping, resetting] in any::<[bool; 5]>(),
        ) {
            let record = StepRecord { step, dt, duration, speed, suspended, reduced, aborting, stopping, resetting };
            prop_assert_eq!(said(&StepEvent::Step(record), ProcessId::MP, &[]), Some(Sample::Step(record)));
        }

        #[test]
        fn a_robot_is_read_as_it_was_shown(
            step in any::<u64>(),
            [a, b, c, d] in numbers(),
            poses in [numbers(), numbers(), numbers()],
        ) {
            let mut words = vec![0; 2 * STATE + 7];
            let [demanded, measured, tool] = poses.map(turned);
            for (at, [position, velocity], pose) in [(0, [a, b], demanded), (STATE, [c, d], measured)] {
                (words[at], words[at + MAX_JOINTS]) = (position.to_bits(), velocity.to_bits());
                pose.put(&mut words[at + 2 * MAX_JOINTS..]);
            }
            tool.put(&mut words[2 * STATE..]);
            let state = |q: f64, v: f64, pose| StateSample { joints: vec![q], velocity: vec![v], pose: Some(pose) };
            let (demanded, measured) = (state(a, b, demanded), state(c, d, measured));
            let expected = RobotSample { robot: 0, step, demanded, measured, tool: Some(tool) };
            let event = StepEvent::Image { step, mode: Mode::Holding };
            prop_assert_eq!(said(&event, of(Role::Edp), &words), Some(Sample::Image(Box::new(expected))));
        }

        #[test]
        fn inputs_and_outputs_are_read_as_they_were_shown(
            (step, [closed, valve]) in any::<(u64, [bool; 2])>(),
            [force, flow] in numbers(),
        ) {
            let mut signals = Signals { inputs: Values::OFF, outputs: Values::OFF };
            signals.inputs.set(Channel::Digital(2), Signal::Digital(closed));
            signals.inputs.set(Channel::Analog(1), Signal::Analog(force));
            signals.outputs.set(Channel::Digital(4), Signal::Digital(valve));
            signals.outputs.set(Channel::Analog(0), Signal::Analog(flow));
            let found = said(&StepEvent::Signals { step }, of(Role::Edp), &words_of(&signals));
            prop_assert_eq!(found, Some(Sample::Signals { robot: 0, step, signals }));
        }

        #[test]
        fn a_reading_is_read_as_it_was_shown((step, taken) in any::<(u64, u64)>(), [x, y, z] in numbers()) {
            let shown = words_of(&Wrench::new(Vector3::new(x, y, z), Vector3::new(f64::INFINITY, z, x)));
            let shown = &shown[..Wrench::LEN];
            let sensor = Name::new("wrist").expect("a name");
            for (state, words) in [
                (ReadingState::There, shown),
                (ReadingState::Fault, &shown[..3]),
                (ReadingState::None, &[][..]),
                (ReadingState::Lost, &[][..]),
            ] {
                let event = StepEvent::Reading { sensor, step, state, taken, shape: Wrench::SHAPE };
                let found = said(&event, of(Role::Ecp), words);
                // Of what is not there nobody knows when it was taken.
                let (taken, words) = (if words.is_empty() { 0 } else { taken }, words.to_vec());
                let expected = Sample::Reading { sensor: 0, by: of(Role::Ecp), step, taken, state, words };
                prop_assert_eq!(found, Some(expected));
            }
        }

        #[test]
        fn a_body_is_where_it_was_shown(step in any::<u64>(), pose in numbers()) {
            let event = StepEvent::Body { body: Name::new("brick").expect("a name"), step };
            let pose = turned(pose);
            let found = said(&event, ProcessId::MP, &words_of(&pose)[..7]);
            prop_assert_eq!(found, Some(Sample::Body { body: 0, pose: Some(pose) }));
        }
    }

    #[test]
    fn a_pose_that_nobody_knows_is_none() {
        let event = StepEvent::Body { body: Name::new("brick").expect("a name"), step: 1 };
        let mut words = words_of(&Pose::identity());
        words[0] = f64::NAN.to_bits();
        assert_eq!(said(&event, ProcessId::MP, &words[..7]), Some(Sample::Body { body: 0, pose: None }));
    }

    #[test]
    fn faults_and_instructions_are_read_with_their_processes() {
        let fault = Fault::new(FaultKind::Aborted);
        let found = said(&StepEvent::Fault { step: 3 }, of(Role::Ecp), &words_of(&FaultWords::from(&fault)));
        let Some(Sample::Event { process, step, what, text }) = found else { panic!("{found:?}") };
        assert_eq!((process, step, &*what), (of(Role::Ecp), 3, "fault"));
        assert_eq!(text, fault.to_string());
        let ends = StepEvent::Instruction { step: 3, doing: InstructionKind::Nothing, by: TypeName::NONE };
        let expected = Sample::Instruction {
            process: ProcessId::MP,
            doing: InstructionKind::Nothing,
            by: String::new(),
        };
        assert_eq!(said(&ends, ProcessId::MP, &[]), Some(expected));
    }

    #[test]
    fn what_the_layout_does_not_have_is_unknown_and_what_does_not_fit_is_nothing() {
        let layout = layout();
        let of = |topic, json: &str| {
            RecordedMessage { topic, start: 0, time: 0, json: json.as_bytes() }.sample(&layout)
        };
        for topic in
            ["/robots/arm", "/robots/press.arm", "/robots/arm/signals", "/sensors/eye", "/bodies/box"]
        {
            assert_eq!(of(topic, "{}"), Some(Sample::Unknown), "{topic}");
        }
        for topic in ["/commands", "/robots/hand/currents", "/cells/press/steps", "/tf", ""] {
            assert_eq!(of(topic, "no JSON"), Some(Sample::Other), "{topic}");
        }
        for topic in
            ["/steps", "/events", "/instructions", "/robots/hand", "/robots/hand/signals", "/sensors/wrist"]
        {
            assert_eq!((of(topic, "no JSON"), of(topic, "{}")), (None, None), "{topic}");
        }
    }
}
