//! The channels of a recording: each thing that a process shows becomes a message of one channel.
//!
//! In: records of the ring. Out: for each record a JSON text on its channel, which is made when it is first needed.

use core::fmt::Write;
use std::io;

use serde_json::{Value, json};

use super::json::{number, numbers, object, schema, value};
use mrroc_core::fault::Name;
use mrroc_core::fault::{Fault, FaultKind, FaultWords, ProcessId};
use mrroc_core::link::Nanos;
use mrroc_core::link::message::OrderKind;
use mrroc_core::observe::layout::{Layout, SignalLayout};
use mrroc_core::observe::ring::Record;
use mrroc_core::observe::step_observer::STATE_WORDS;
use mrroc_core::observe::step_observer::{Mode, ReadingState, StepEvent};
use mrroc_core::operator::jog::JogNow;
use mrroc_core::operator::state::InstructionKind;
use mrroc_core::payload::Shape;
use mrroc_core::payload::Wire;
use mrroc_core::robot::{Channel, MAX_JOINTS, Signals, Values};

/// Where the messages go.
pub(super) trait Outlet {
    /// Makes a channel for a topic, with a schema of this name and text; returns the number of the channel.
    fn open(&mut self, topic: &str, schema: &str, text: &str) -> io::Result<u16>;

    /// Writes a message at a time of the cell.
    fn write(&mut self, channel: u16, time: Nanos, json: &str) -> io::Result<()>;

    /// Hands on what was written, so that a reader can have it now.
    fn flush(&mut self) -> io::Result<()>;

    /// Ends the recording: this many records were dropped.
    fn finish(&mut self, dropped: u64) -> io::Result<()>;
}

/// The topic of a channel, by which channels are distinguished.
#[derive(Clone, Copy, PartialEq)]
enum Topic {
    /// Of the uppermost cell, or of a lower one.
    Steps(Option<Name>),
    Instructions(Option<Name>),
    Events(Option<Name>),
    Robot(Name),
    Currents(Name),
    Signals(Name),
    Orders(Name),
    Payload(Name, &'static str),
    Sensor(Name),
    Body(Name),
}

/// The channels made so far.
pub(super) struct Channels {
    layout: Layout,
    open: Vec<(Topic, u16)>,
    text: String,
}

impl Channels {
    pub fn of(layout: Layout) -> Channels {
        Channels { layout, open: Vec::new(), text: String::new() }
    }

    /// Writes a record as a message.
    pub fn put(&mut self, record: &Record, outlet: &mut dyn Outlet) -> io::Result<()> {
        let (topic, shape) = topic(record);
        let known = self.open.iter().find(|(known, _)| *known == topic);
        let channel = match known {
            Some((_, channel)) => *channel,
            None => {
                let (name, schema, text) = describe(topic, shape, &self.layout);
                let channel = outlet.open(&name, &schema, &text.to_string())?;
                self.open.push((topic, channel));
                channel
            }
        };
        self.text.clear();
        let joints = |name: Option<Name>| {
            let found =
                self.layout.robots.iter().find(|robot| name.is_some_and(|n| n.as_str() == robot.name));
            found.map_or(MAX_JOINTS, |robot| robot.joints.len())
        };
        let signals = record.by.name.map_or(&[][..], |name| signals_of(&self.layout, name));
        write_record(&mut self.text, record, joints(record.by.name), signals);
        outlet.write(channel, record.time, &self.text)
    }
}

fn topic(record: &Record) -> (Topic, Option<&'static Shape>) {
    let cell = record.by.cell();
    let events = Topic::Events(cell);
    match record.what {
        StepEvent::Step { .. } => (Topic::Steps(cell), None),
        StepEvent::Instruction { .. } => (Topic::Instructions(cell), None),
        StepEvent::Image { .. } => (record.by.name.map_or(events, Topic::Robot), None),
        StepEvent::Currents { .. } => (record.by.name.map_or(events, Topic::Currents), None),
        StepEvent::Signals { .. } => (record.by.name.map_or(events, Topic::Signals), None),
        StepEvent::Order { robot, payload, shape, kind: OrderKind::Step, .. } if !shape.is_empty() => {
            (Topic::Payload(robot, payload), Some(shape))
        }
        StepEvent::Order { robot, .. } => (Topic::Orders(robot), None),
        // Its process has such a name, so the name is none that is too long.
        StepEvent::Reading { sensor, shape, .. } => {
            (Topic::Sensor(cell.and_then(|cell| sensor.within(cell).ok()).unwrap_or(sensor)), Some(shape))
        }
        StepEvent::Body { body, .. } => (Topic::Body(body), None),
        StepEvent::Abort { .. }
        | StepEvent::Jog { .. }
        | StepEvent::Late { .. }
        | StepEvent::LateRequest { .. }
        | StepEvent::Found { .. }
        | StepEvent::Fault { .. }
        | StepEvent::End { .. } => (events, None),
    }
}

/// The topic of what each cell has one of: `/steps`, and `/cells/press/steps` of a lower one.
pub(super) fn of_cell(cell: Option<Name>, what: &str) -> String {
    cell.map_or_else(|| format!("/{what}"), |cell| format!("/cells/{cell}/{what}"))
}

/// A channel's topic, and its schema with its name.
fn describe(topic: Topic, shape: Option<&Shape>, layout: &Layout) -> (String, String, Value) {
    let (number, integer, text) =
        (json!({"type": "number"}), json!({"type": "integer"}), json!({"type": "string"}));
    let truth = json!({"type": "boolean"});
    let order = [("step", integer.clone()), ("instruction", integer.clone()), ("kind", text.clone())];
    let shape = shape.map(schema).unwrap_or_default();
    match topic {
        Topic::Steps(cell) => {
            let step = object([
                ("step", integer),
                ("dt", number.clone()),
                ("duration", number.clone()),
                ("speed", number),
                ("suspended", truth.clone()),
                ("reduced", truth.clone()),
                ("aborting", truth.clone()),
                ("stopping", truth.clone()),
                ("resetting", truth),
            ]);
            (of_cell(cell, "steps"), "mrroc.Step".to_owned(), step)
        }
        Topic::Instructions(cell) => {
            let words = InstructionKind::ALL.map(InstructionKind::word);
            let instruction = [
                ("step", integer),
                ("process", text.clone()),
                ("doing", json!({"type": "string", "enum": words})),
                ("by", text),
            ];
            (of_cell(cell, "instructions"), "mrroc.Instruction".to_owned(), object(instruction))
        }
        Topic::Events(cell) => {
            let event =
                [("step", integer), ("process", text.clone()), ("what", text.clone()), ("text", text)];
            (of_cell(cell, "events"), "mrroc.Event".to_owned(), object(event))
        }
        Topic::Robot(name) => {
            let joints = json!({"type": "array", "items": {"type": "number"}});
            let state =
                object([("joints", joints.clone()), ("velocity", joints), ("pose", schema(Shape::POSE))]);
            let image = object([
                ("step", integer),
                ("mode", text),
                ("demanded", state.clone()),
                ("measured", state),
                ("tool", schema(Shape::POSE)),
            ]);
            (format!("/robots/{name}"), "mrroc.RobotImage".to_owned(), image)
        }
        Topic::Currents(name) => {
            let currents = json!({"type": "array", "items": {"type": "number"}});
            let motors = object([("step", integer), ("currents", currents)]);
            (format!("/robots/{name}/currents"), "mrroc.MotorCurrents".to_owned(), motors)
        }
        Topic::Signals(name) => {
            let of = |outputs: bool| {
                let signals = signals_of(layout, name).iter().filter(|signal| signal.is_output == outputs);
                object(signals.map(|signal| {
                    let schema = match signal.channel {
                        Channel::Digital(_) => truth.clone(),
                        Channel::Analog(_) => number.clone(),
                    };
                    (signal.name.as_str(), schema)
                }))
            };
            let signals = object([("step", integer), ("inputs", of(false)), ("outputs", of(true))]);
            (format!("/robots/{name}/signals"), format!("mrroc.Signals.{name}"), signals)
        }
        Topic::Orders(name) => (format!("/robots/{name}/orders"), "mrroc.Order".to_owned(), object(order)),
        Topic::Payload(name, payload) => {
            let order = object(order.into_iter().chain([("order", shape)]));
            (format!("/robots/{name}/orders/{payload}"), format!("mrroc.Order.{payload}"), order)
        }
        Topic::Body(name) => {
            let body = object([("step", integer), ("pose", schema(Shape::POSE))]);
            (format!("/bodies/{name}"), "mrroc.Body".to_owned(), body)
        }
        Topic::Sensor(name) => {
            let reading = [
                ("step", integer.clone()),
                ("by", text.clone()),
                ("state", text),
                ("taken", integer),
                ("reading", shape),
            ];
            let mut reading = object(reading);
            // The field `reading` is absent when there is no reading, so it is not required.
            reading["required"] = json!(["step", "by", "state"]);
            (format!("/sensors/{name}"), format!("mrroc.Reading.{name}"), reading)
        }
    }
}

/// The named inputs and outputs of a robot.
fn signals_of(layout: &Layout, name: Name) -> &[SignalLayout] {
    let robot = layout.robots.iter().find(|robot| name.as_str() == robot.name);
    robot.map_or(&[], |robot| &robot.signals)
}

/// Writes the values of signals by their names.
fn write_signals(out: &mut String, signals: &[SignalLayout], values: &Values, outputs: bool) {
    out.push('{');
    let of_them = signals.iter().filter(|signal| signal.is_output == outputs);
    for (i, SignalLayout { name, channel, .. }) in of_them.enumerate() {
        if i > 0 {
            out.push(',');
        }
        // Writing to a text cannot fail.
        let _ = match channel {
            Channel::Digital(channel) => write!(out, "\"{name}\":{}", values.is_on(*channel)),
            Channel::Analog(channel) => {
                let _ = write!(out, "\"{name}\":");
                number(out, values.analog(*channel));
                Ok(())
            }
        };
    }
    out.push('}');
}

fn write_record(out: &mut String, record: &Record, joints: usize, signals: &[SignalLayout]) {
    let words = record.words();
    // Writing to a text cannot fail.
    let _ = match record.what {
        StepEvent::Step { step, dt, duration, speed, suspended, reduced, aborting, stopping, resetting } => {
            write!(
                out,
                "{{\"step\":{step},\"dt\":{dt:?},\"duration\":{duration:?},\"speed\":{speed:?},\"suspended\":{suspended},\"reduced\":{reduced},\"aborting\":{aborting},\"stopping\":{stopping},\"resetting\":{resetting}}}"
            )
        }
        StepEvent::Instruction { step, doing, by } => {
            let (process, doing) = (record.by, doing.word());
            write!(out, "{{\"step\":{step},\"process\":\"{process}\",\"doing\":\"{doing}\",\"by\":\"{by}\"}}")
        }
        StepEvent::Image { step, mode } => return write_image(out, step, mode, words, joints),
        StepEvent::Currents { step } => {
            let _ = write!(out, "{{\"step\":{step},\"currents\":");
            numbers(out, words);
            out.write_str("}")
        }
        StepEvent::Signals { step } => {
            let Ok(values) = Signals::get(words) else { return };
            let _ = write!(out, "{{\"step\":{step},\"inputs\":");
            write_signals(out, signals, &values.inputs, false);
            out.push_str(",\"outputs\":");
            write_signals(out, signals, &values.outputs, true);
            out.write_str("}")
        }
        StepEvent::Order { step, instruction, kind, shape, .. } => {
            let kind = order_kind(kind);
            let _ = write!(out, "{{\"step\":{step},\"instruction\":{instruction},\"kind\":\"{kind}\"");
            if kind == "step" && !shape.is_empty() {
                out.push_str(",\"order\":");
                value(out, shape, words);
            }
            out.write_str("}")
        }
        StepEvent::Reading { step, state, taken, shape, .. } => {
            let _ = write!(
                out,
                "{{\"step\":{step},\"by\":\"{}\",\"state\":\"{}\"",
                record.by,
                reading_state(state)
            );
            match state {
                ReadingState::There => {
                    let _ = write!(out, ",\"taken\":{taken},\"reading\":");
                    value(out, shape, words);
                }
                ReadingState::Fault => {
                    let _ = write!(out, ",\"taken\":{taken},\"fault\":");
                    value(out, &Shape::Words(words.len()), words);
                }
                ReadingState::None | ReadingState::Lost => {}
            }
            out.write_str("}")
        }
        StepEvent::Abort { step } => return write_event(out, step, record.by, "abort", ""),
        StepEvent::Jog { step, robot } => {
            let now = JogNow::get(words).unwrap_or_default();
            return write_event(out, step, record.by, "jog", &format!("{robot} {now}"));
        }
        StepEvent::Late { step } => return write_event(out, step, record.by, "late", ""),
        StepEvent::LateRequest { step, nth, due } => {
            let came = format!("request {nth} in step {due}");
            return write_event(out, step, record.by, "late request", &came);
        }
        StepEvent::Found { step } => {
            return write_event(out, step, record.by, "found", &record.time.to_string());
        }
        StepEvent::Fault { step } => {
            let what = if comes_from_outside(words) { "fault from outside" } else { "fault" };
            return write_event(out, step, record.by, what, &fault_text(words));
        }
        StepEvent::Body { step, .. } => {
            let _ = write!(out, "{{\"step\":{step},\"pose\":");
            value(out, Shape::POSE, words);
            out.write_str("}")
        }
        StepEvent::End { step } => return write_event(out, step, record.by, "end", &fault_text(words)),
    };
}

fn write_image(out: &mut String, step: u64, mode: Mode, words: &[u64], joints: usize) {
    let mode = match mode {
        Mode::Holding => "holding",
        Mode::Moving => "moving",
        Mode::Bridging => "bridging",
        Mode::Braking => "braking",
        Mode::Off => "off",
    };
    let _ = write!(out, "{{\"step\":{step},\"mode\":\"{mode}\"");
    let (states, tool) = words.split_at(words.len().min(2 * STATE_WORDS));
    for (name, state) in ["demanded", "measured"].iter().zip(states.chunks_exact(STATE_WORDS)) {
        let _ = write!(out, ",\"{name}\":{{\"joints\":");
        numbers(out, &state[..joints]);
        out.push_str(",\"velocity\":");
        numbers(out, &state[MAX_JOINTS..MAX_JOINTS + joints]);
        out.push_str(",\"pose\":");
        value(out, Shape::POSE, &state[2 * MAX_JOINTS..]);
        out.push('}');
    }
    out.push_str(",\"tool\":");
    value(out, Shape::POSE, tool);
    out.push('}');
}

fn write_event(out: &mut String, step: u64, by: ProcessId, what: &str, text: &str) {
    let _ = write!(out, "{}", json!({"step": step, "process": by.to_string(), "what": what, "text": text}));
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

const fn order_kind(kind: OrderKind) -> &'static str {
    match kind {
        OrderKind::Query => "query",
        OrderKind::Start => "start",
        OrderKind::Step => "step",
        OrderKind::End => "end",
        OrderKind::Abort => "abort",
        OrderKind::Brake => "brake",
        OrderKind::Stop => "stop",
        OrderKind::Reset => "reset",
    }
}

pub(super) const fn reading_state(state: ReadingState) -> &'static str {
    match state {
        ReadingState::There => "there",
        ReadingState::None => "none",
        ReadingState::Fault => "fault",
        ReadingState::Lost => "lost",
    }
}
