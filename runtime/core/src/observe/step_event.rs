//! What can happen in a step of a cell, and what each of it is as a sample of a channel.
//!
//! In: a step, order, image, reading or fault, in its own terms. Out: the channel that it is a sample of, and its fields by their names.
//! This is the one place that says so: a recording and its schemas follow from it. Whoever shows only some of it picks that by itself.

use mrroc_macros::Payload;

use crate::link::message::OrderKind;
use crate::model::fault::{Fault, FaultKind, FaultWords, ProcessId};
use crate::model::image::STATE_WORDS;
use crate::model::joints::MAX_JOINTS;
use crate::model::name::Name;
use crate::model::shape::Shape;
use crate::model::signals::{Channel, Signals, Values};
use crate::model::time::Nanos;
use crate::model::type_name::TypeName;
use crate::model::wire::Wire;
use crate::observe::layout::{Layout, SignalLayout};
use crate::observe::sample::{Field, Fields, Schema, Subject, Topic};
use crate::operator::jog::JogNow;
use crate::operator::state::InstructionKind;

/// Words of what an image is shown as: the demanded state, the measured one, the tool.
pub const IMAGE_WORDS: usize = 2 * STATE_WORDS + 7;

/// What the MP shows of a step that it begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct StepRecord {
    /// Its index.
    pub step: u64,
    /// Its path time \[s\].
    pub dt: f64,
    /// Its real time \[s\].
    pub duration: f64,
    /// The speed that the operator wants, as a share of the plan, 0 to 1.
    pub speed: f64,
    /// Whether the operator has suspended the cell.
    pub suspended: bool,
    /// Whether the limit of reduced speed is in force.
    pub reduced: bool,
    /// Whether the operator aborts.
    pub aborting: bool,
    /// Whether the operator has asked for a protective stop since the step before.
    pub stopping: bool,
    /// Whether the operator has reset the latched cell.
    pub resetting: bool,
}

/// What happened. The words that are shown beside it are named with each.
#[derive(Clone, Copy, Debug)]
pub enum StepEvent {
    /// The MP begins a step. No words.
    Step(StepRecord),
    /// An instruction begins, or is over: of the MP's program, or of the program of an ECP. No words.
    Instruction {
        /// The last step that began before.
        step: u64,
        /// What is done from now on; [`InstructionKind::Nothing`]: the last instruction is over.
        doing: InstructionKind,
        /// Its generator or condition; [`TypeName::NONE`] of homing, and of an MP without a program, which lets those of the
        /// ECPs run.
        by: TypeName,
    },
    /// The operator aborts, after the step began. No words.
    Abort {
        /// The step.
        step: u64,
    },
    /// From this step on, this is asked of the robot that a person jogs: the words of a
    /// [`JogNow`](crate::operator::jog::JogNow).
    Jog {
        /// The step.
        step: u64,
        /// The robot.
        robot: Name,
    },
    /// What took place in the step left no time for more: an MP or ECP could not begin a motion in it. No words.
    Late {
        /// The step.
        step: u64,
    },
    /// A request came too late to its EDP for its step. No words.
    LateRequest {
        /// The step.
        step: u64,
        /// Its place among the requests of that step, from 0.
        nth: u32,
        /// The step for which demands could be taken when it came.
        due: u64,
    },
    /// The MP orders; the words of the order, if it has one.
    Order {
        /// The robot that is ordered.
        robot: Name,
        /// The step.
        step: u64,
        /// The ordinal of the instruction.
        instruction: u32,
        /// What kind of order it is.
        kind: OrderKind,
        /// The name of the order's type.
        payload: &'static str,
        /// What its words say.
        shape: &'static Shape,
    },
    /// The drives of an EDP have found their reference marks. No words.
    Found {
        /// The step.
        step: u64,
    },
    /// An EDP begins a step: [`IMAGE_WORDS`] words.
    Image {
        /// The step.
        step: u64,
        /// What the robot does in it.
        mode: Mode,
    },
    /// What the motors of a robot take when an EDP begins a step: a word for each motor, its current \[A\].
    Currents {
        /// The step.
        step: u64,
    },
    /// The inputs and outputs of a robot that has such, when an EDP begins a step:
    /// [`SIGNAL_WORDS`](super::step_observer::SIGNAL_WORDS) words of its [`Signals`](crate::robot::Signals).
    Signals {
        /// The step.
        step: u64,
    },
    /// A process has collected a reading: its words, or those of a fault.
    Reading {
        /// The sensor.
        sensor: Name,
        /// The step in which it was collected.
        step: u64,
        /// What was collected.
        state: ReadingState,
        /// The step in which it was taken.
        taken: u64,
        /// What its words say.
        shape: &'static Shape,
    },
    /// A part of a value that a program has computed and that a replay does not compute again: its words.
    Value {
        /// The step.
        step: u64,
        /// The name of the value.
        name: Name,
        /// How many parts follow.
        left: u32,
    },
    /// A process stops for a fault: its words.
    Fault {
        /// The step.
        step: u64,
    },
    /// Where a body is that the robots handle: the words of its pose `X_WB`.
    Body {
        /// The step.
        step: u64,
        /// The body, one of the [layout](crate::observe::layout::Layout::bodies).
        body: Name,
    },
    /// The MP's program is over: no words, or those of the fault it ended with.
    End {
        /// The last step.
        step: u64,
    },
}

/// What an EDP does in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// The robot stands where it was demanded last.
    Holding,
    /// It follows its demands.
    Moving,
    /// The demand did not come: the path goes on.
    Bridging,
    /// It is on its way to a standstill.
    Braking,
    /// Its drives have no power.
    Off,
}

impl Mode {
    /// Its word.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Mode::Holding => "holding",
            Mode::Moving => "moving",
            Mode::Bridging => "bridging",
            Mode::Braking => "braking",
            Mode::Off => "off",
        }
    }
}

/// What a process has collected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Payload)]
pub enum ReadingState {
    /// A reading.
    There,
    /// Nothing yet.
    None,
    /// The sensor's fault.
    Fault,
    /// No answer in time.
    Lost,
}

impl ReadingState {
    /// Its word.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            ReadingState::There => "there",
            ReadingState::None => "none",
            ReadingState::Fault => "fault",
            ReadingState::Lost => "lost",
        }
    }
}

/// What is done in an instruction, as its word.
const DOING: &Shape = &Shape::Choice(&InstructionKind::WORDS);

impl StepEvent {
    /// The channel of which it is a sample, shown by this process.
    #[must_use]
    pub fn topic(&self, by: ProcessId) -> Topic {
        let of_cell = |part, schema| Topic::new(Subject::Cell(by.cell()), part, Schema::Common(schema));
        let of_robot = |part, schema| {
            Topic::new(by.name.map_or_else(|| Subject::Cell(by.cell()), Subject::Robot), part, schema)
        };
        match *self {
            StepEvent::Step(_) => of_cell("steps", "Step"),
            StepEvent::Instruction { .. } => of_cell("instructions", "Instruction"),
            StepEvent::Image { .. } => of_robot("", Schema::Common("RobotImage")),
            StepEvent::Currents { .. } => of_robot("currents", Schema::Common("MotorCurrents")),
            StepEvent::Signals { .. } => of_robot("signals", Schema::Own("Signals")),
            StepEvent::Order { robot, payload, kind: OrderKind::Step, shape, .. } if !shape.is_empty() => {
                Topic::new(Subject::Robot(robot), "orders", Schema::Payload(payload))
            }
            StepEvent::Order { robot, .. } => {
                Topic::new(Subject::Robot(robot), "orders", Schema::Common("Order"))
            }
            StepEvent::Reading { sensor, .. } => {
                Topic::new(Subject::Sensor(by.cell(), sensor), "", Schema::Own("Reading"))
            }
            StepEvent::Body { body, .. } => Topic::new(Subject::Body(body), "", Schema::Common("Body")),
            StepEvent::Abort { .. }
            | StepEvent::Jog { .. }
            | StepEvent::Late { .. }
            | StepEvent::LateRequest { .. }
            | StepEvent::Found { .. }
            | StepEvent::Value { .. }
            | StepEvent::Fault { .. }
            | StepEvent::End { .. } => of_cell("events", "Event"),
        }
    }

    /// Hands over its fields in their order, shown at a time of a cell of this layout, with these words; none if the words make no
    /// sense.
    pub fn sample(
        &self,
        time: Nanos,
        by: ProcessId,
        words: &[u64],
        layout: &Layout,
        take: &mut dyn FnMut(Fields<'_>),
    ) {
        let robot = || layout.robots.iter().find(|robot| by.name.is_some_and(|n| n.as_str() == robot.name));
        let mut event = |step: u64, what: &str, text: &str| {
            take(&[
                ("process", Field::Text(&by)),
                ("step", Field::Integer(step)),
                ("text", Field::Text(&text)),
                ("what", Field::Text(&what)),
            ]);
        };
        match *self {
            StepEvent::Step(record) => {
                let mut words = [0; StepRecord::LEN];
                record.put(&mut words);
                take(&Field::all(StepRecord::SHAPE, &words));
            }
            StepEvent::Instruction { step, doing, by: generator } => take(&[
                ("step", Field::Integer(step)),
                ("process", Field::Text(&by)),
                ("doing", Field::Value(DOING, &[doing as u64])),
                ("by", Field::Text(&generator)),
            ]),
            StepEvent::Image { step, mode } => {
                let joints = robot().map_or(MAX_JOINTS, |robot| robot.joints.len());
                let Some((states, tool)) = words.split_at_checked(2 * STATE_WORDS) else { return };
                let (demanded, measured) = states.split_at(STATE_WORDS);
                take(&[
                    ("step", Field::Integer(step)),
                    ("mode", Field::Text(&mode.word())),
                    ("demanded", Field::Fields(&state(demanded, joints))),
                    ("measured", Field::Fields(&state(measured, joints))),
                    ("tool", Field::Value(Shape::POSE, tool)),
                ]);
            }
            StepEvent::Currents { step } => {
                take(&[("step", Field::Integer(step)), ("currents", Field::Numbers(words))]);
            }
            StepEvent::Signals { step } => {
                let Ok(values) = Signals::get(words) else { return };
                let known = robot().map_or(&[][..], |robot| &robot.signals);
                take(&[
                    ("step", Field::Integer(step)),
                    ("inputs", Field::Fields(&signals(known, &values.inputs, false))),
                    ("outputs", Field::Fields(&signals(known, &values.outputs, true))),
                ]);
            }
            StepEvent::Order { step, instruction, kind, shape, .. } => {
                let (has_words, kind) = (kind == OrderKind::Step && !shape.is_empty(), kind.word());
                let fields = [
                    ("step", Field::Integer(step)),
                    ("instruction", Field::Integer(u64::from(instruction))),
                    ("kind", Field::Text(&kind)),
                    ("order", Field::Value(shape, words)),
                ];
                take(&fields[..if has_words { 4 } else { 3 }]);
            }
            StepEvent::Reading { step, state, taken, shape, .. } => {
                let (is_there, is_fault) = (state == ReadingState::There, state == ReadingState::Fault);
                let (state, taken, as_words) = (state.word(), [taken], Shape::Words(words.len()));
                let mut fields = vec![
                    ("step", Field::Integer(step)),
                    ("by", Field::Text(&by)),
                    ("state", Field::Text(&state)),
                    (
                        "taken",
                        Field::Optional(&Shape::Unsigned, (is_there || is_fault).then_some(&taken[..])),
                    ),
                    ("reading", Field::Optional(shape, is_there.then_some(words))),
                ];
                fields.extend(is_fault.then_some(("fault", Field::Unlisted(&as_words, words))));
                take(&fields);
            }
            StepEvent::Abort { step } => event(step, "abort", ""),
            StepEvent::Jog { step, robot } => {
                event(step, "jog", &format!("{robot} {}", JogNow::get(words).unwrap_or_default()));
            }
            StepEvent::Late { step } => event(step, "late", ""),
            StepEvent::LateRequest { step, nth, due } => {
                event(step, "late request", &format!("request {nth} in step {due}"));
            }
            StepEvent::Found { step } => event(step, "found", &time.to_string()),
            StepEvent::Value { step, name, left } => {
                let hex: String = words.iter().map(|word| format!("{word:016x}")).collect();
                event(step, "value", &format!("{name} {left} {hex}"));
            }
            StepEvent::Fault { step } => {
                let what = if comes_from_outside(words) { "fault from outside" } else { "fault" };
                event(step, what, &fault_text(words));
            }
            StepEvent::Body { step, .. } => {
                take(&[("step", Field::Integer(step)), ("pose", Field::Value(Shape::POSE, words))]);
            }
            StepEvent::End { step } => event(step, "end", &fault_text(words)),
        }
    }
}

/// The state of a robot with so many joints.
fn state(words: &[u64], joints: usize) -> [(&str, Field<'_>); 3] {
    [
        ("joints", Field::Numbers(&words[..joints])),
        ("velocity", Field::Numbers(&words[MAX_JOINTS..MAX_JOINTS + joints])),
        ("pose", Field::Value(Shape::POSE, &words[2 * MAX_JOINTS..])),
    ]
}

/// The values of a robot's inputs or outputs by their names.
fn signals<'a>(known: &'a [SignalLayout], values: &Values, outputs: bool) -> Vec<(&'a str, Field<'a>)> {
    let value = |signal: &'a SignalLayout| {
        let value = match signal.channel {
            Channel::Digital(number) => Field::Truth(values.is_on(number)),
            Channel::Analog(number) => Field::Number(values.analog(number)),
        };
        (signal.name.as_str(), value)
    };
    known.iter().filter(|signal| signal.is_output == outputs).map(value).collect()
}

/// The text of a fault; empty if there is no fault.
fn fault_text(words: &[u64]) -> String {
    FaultWords::get(words).map_or_else(|_| String::new(), |fault| Fault::from(fault).to_string())
}

/// Whether a fault came from outside the programs, so that a replay, which has no robots, cannot have it.
fn comes_from_outside(words: &[u64]) -> bool {
    use FaultKind::{DriveFault, FollowingError, Overrun, PeerLost, StartPoseMismatch};
    let kind = FaultWords::get(words).map(|fault| Fault::from(fault).kind());
    matches!(kind, Ok(PeerLost | Overrun | StartPoseMismatch | FollowingError | DriveFault))
}
