//! The named inputs and outputs of a robot: how they are set up, and what is wrong with that.
//!
//! In: names, channels, what each output does at a stop. Out: the names for programs, [`Declared`] for the EDP, wires for
//! simulated drives; or everything that cannot be.

use core::fmt;
use core::time::Duration;
use std::rc::Rc;

use crate::control::edp::signals::Declared;
use crate::control::simulated_signals::SimulatedWire;
use crate::model::driver::{Channels, WhenLost};
use crate::model::load::Load;
use crate::model::name::Name;
use crate::model::named::SignalNames;
use crate::model::signals::{ANALOG, Channel, DIGITAL, Outputs, Value};
use crate::observe::layout::SignalLayout;

/// An input of a robot's controller with a name: [`RobotSetup::input`](super::RobotSetup::input).
#[derive(Clone, Debug, PartialEq)]
pub struct InputSetup {
    pub(super) name: String,
    pub(super) channel: Channel,
    pub(super) follows: Option<(String, Duration)>,
}

impl InputSetup {
    /// The input of this channel.
    #[must_use]
    pub fn new(name: &str, channel: Channel) -> InputSetup {
        InputSetup { name: name.to_owned(), channel, follows: None }
    }

    /// Of simulated drives: the input reads what the output of this name, of the same robot, has been for the time `after`. So
    /// a program that waits for a gripper's switch runs without a gripper. Real drives do not care.
    #[must_use]
    pub fn follows(mut self, output: &str, after: Duration) -> InputSetup {
        self.follows = Some((output.to_owned(), after));
        self
    }
}

/// An output of a robot's controller with a name, and what it does at a stop:
/// [`RobotSetup::output`](super::RobotSetup::output). It holds, unless it is told otherwise here.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputSetup {
    pub(super) name: String,
    pub(super) channel: Channel,
    pub(super) on_stop: Option<Value>,
    pub(super) holds_body: bool,
    pub(super) turns_tool: bool,
}

impl OutputSetup {
    /// The output of this channel.
    #[must_use]
    pub fn new(name: &str, channel: Channel) -> OutputSetup {
        OutputSetup { name: name.to_owned(), channel, on_stop: None, holds_body: false, turns_tool: false }
    }

    /// The value that it takes at every stop that is not a suspension: a fault, a protective stop, an abort, the end of the
    /// cell, a lost process.
    #[must_use]
    pub fn on_stop(mut self, value: Value) -> OutputSetup {
        self.on_stop = Some(value);
        self
    }

    /// It holds a body, as a gripper or a vacuum does: it can only hold at a stop, and is refused a value for it.
    #[must_use]
    pub fn holds_body(mut self) -> OutputSetup {
        self.holds_body = true;
        self
    }

    /// It drives a tool, such as a spindle: it needs a value for a stop.
    #[must_use]
    pub fn turns_tool(mut self) -> OutputSetup {
        self.turns_tool = true;
        self
    }
}

/// What is wrong with a named signal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WrongSignal {
    /// The name is none.
    Name(String),
    /// Two signals of the robot have the name.
    Twice,
    /// Two outputs have the channel.
    Shared(Channel, String),
    /// The controller does not have the channel: it has so many.
    Channel(Channel, usize),
    /// An output that holds a body has a value for a stop.
    WouldLetGo,
    /// An output that drives a tool has none.
    WouldTurnOn,
    /// The value for a stop is of the other type, or no number.
    Value(Channel, String),
    /// An input follows an output that is not there, or is of the other type.
    Follows(String),
}

impl fmt::Display for WrongSignal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            WrongSignal::Name(why) => f.write_str(why),
            WrongSignal::Twice => {
                f.write_str("another signal of the robot has this name\n help: give each a name of its own")
            }
            WrongSignal::Shared(channel, other) => {
                write!(f, "its channel, {channel}, is that of `{other}`\n help: give each output a channel of its own")
            }
            WrongSignal::Channel(channel, 0) => {
                let kind = kind(*channel);
                write!(f, "the robot's drives have no {kind} channel of that direction\n help: leave it out, or choose drives that have it")
            }
            WrongSignal::Channel(channel, there) => {
                let kind = kind(*channel);
                write!(f, "its drives have no channel {channel}\n help: write {kind} 0 to {kind} {}", there - 1)
            }
            WrongSignal::WouldLetGo => f.write_str(
                "it holds a body, and a stop would let it fall\n help: leave its value for a stop out: it holds then",
            ),
            WrongSignal::WouldTurnOn => f.write_str(
                "it drives a tool, which would go on at a stop\n help: say the value that switches it off, on_stop = false",
            ),
            WrongSignal::Value(Channel::Digital(_), value) => {
                write!(f, "its value for a stop is {value}, the output is digital\n help: write on_stop = false, or true")
            }
            WrongSignal::Value(Channel::Analog(_), value) => {
                write!(f, "its value for a stop is {value}, the output is analog\n help: write on_stop = 0.0, or another number")
            }
            WrongSignal::Follows(output) => write!(
                f,
                "it follows `{output}`, which is no output of the robot of its type\n help: write the name of one"
            ),
        }
    }
}

const fn kind(channel: Channel) -> &'static str {
    match channel {
        Channel::Digital(_) => "digital",
        Channel::Analog(_) => "analog",
    }
}

/// The named signals of a robot.
#[derive(Clone, Debug, Default)]
pub(super) struct SignalSetups {
    pub inputs: Vec<InputSetup>,
    pub outputs: Vec<OutputSetup>,
    /// What the robot carries at the start.
    pub load: Option<Load>,
}

impl SignalSetups {
    /// The names for programs.
    pub fn names(&self) -> Rc<SignalNames> {
        let inputs = self.inputs.iter().map(|input| (input.name.clone(), input.channel));
        let outputs = self.outputs.iter().map(|output| (output.name.clone(), output.channel));
        let tools = self.outputs.iter().filter(|output| output.turns_tool);
        let tools = tools.filter_map(|output| Some((output.name.clone(), output.on_stop?)));
        Rc::new(SignalNames { inputs: inputs.collect(), outputs: outputs.collect(), tools: tools.collect() })
    }

    /// What the EDP needs to know.
    pub fn declared(&self) -> Declared {
        let zero = |channel| match channel {
            Channel::Digital(_) => Value::Digital(false),
            Channel::Analog(_) => Value::Analog(0.0),
        };
        let any = !self.inputs.is_empty() || !self.outputs.is_empty();
        let named = |all: Outputs, output: &OutputSetup| all.with(output.channel, zero(output.channel));
        let outputs = self.outputs.iter().fold(Outputs::NONE, named);
        let stopped = |all: Outputs, output: &OutputSetup| match output.on_stop {
            Some(value) => all.with(output.channel, value),
            None => all,
        };
        let on_stop = self.outputs.iter().fold(Outputs::NONE, stopped);
        Declared { any, outputs, on_stop, load: self.load }
    }

    /// The wires of simulated drives.
    pub fn wires(&self) -> Vec<SimulatedWire> {
        let wire = |input: &InputSetup| {
            let (output, after) = input.follows.as_ref()?;
            let output = self.outputs.iter().find(|known| known.name == *output)?;
            Some(SimulatedWire { input: input.channel, output: output.channel, after: *after })
        };
        self.inputs.iter().filter_map(wire).collect()
    }

    /// Everything that is wrong with them, for drives with these channels; of drives that are not found yet these are not known.
    pub fn check(&self, channels: Option<Channels>) -> Vec<(String, WrongSignal)> {
        let mut wrong = Vec::new();
        let names = || {
            let inputs = self.inputs.iter().map(|input| &*input.name);
            inputs.chain(self.outputs.iter().map(|output| &*output.name))
        };
        for name in names() {
            if let Err(bad) = Name::new(name) {
                wrong.push((name.to_owned(), WrongSignal::Name(bad.to_string())));
            }
        }
        for (i, name) in names().enumerate() {
            if names().take(i).any(|before| before == name) {
                wrong.push((name.to_owned(), WrongSignal::Twice));
            }
        }
        for InputSetup { name, channel, follows } in &self.inputs {
            let there = channels.map_or(most(*channel), |channels| usize::from(channels.inputs(*channel)));
            if number(*channel) >= there {
                wrong.push((name.clone(), WrongSignal::Channel(*channel, there)));
            }
            let Some((output, _)) = follows else { continue };
            let is_one = |known: &OutputSetup| known.name == *output && kind(known.channel) == kind(*channel);
            if !self.outputs.iter().any(is_one) {
                wrong.push((name.clone(), WrongSignal::Follows(output.clone())));
            }
        }
        for (i, output) in self.outputs.iter().enumerate() {
            let OutputSetup { name, channel, on_stop, holds_body, turns_tool } = output;
            let there = channels.map_or(most(*channel), |channels| usize::from(channels.outputs(*channel)));
            if number(*channel) >= there {
                wrong.push((name.clone(), WrongSignal::Channel(*channel, there)));
            }
            if let Some(other) = self.outputs[..i].iter().find(|other| other.channel == *channel) {
                wrong.push((name.clone(), WrongSignal::Shared(*channel, other.name.clone())));
            }
            match (on_stop, channel) {
                (None, _) | (Some(Value::Digital(_)), Channel::Digital(_)) => {}
                (Some(Value::Analog(value)), Channel::Analog(_)) if value.is_finite() => {}
                (Some(value), _) => {
                    wrong.push((name.clone(), WrongSignal::Value(*channel, value.to_string())))
                }
            }
            if *holds_body && on_stop.is_some() {
                wrong.push((name.clone(), WrongSignal::WouldLetGo));
            }
            if *turns_tool && on_stop.is_none() {
                wrong.push((name.clone(), WrongSignal::WouldTurnOn));
            }
        }
        wrong
    }

    /// What the table says of them, for drives whose outputs do this when they are told nothing any more.
    pub fn layout(&self, when_lost: WhenLost) -> Vec<SignalLayout> {
        let input = |input: &InputSetup| SignalLayout {
            name: input.name.clone(),
            channel: input.channel,
            is_output: false,
            note: String::new(),
        };
        let output = |output: &OutputSetup| SignalLayout {
            name: output.name.clone(),
            channel: output.channel,
            is_output: true,
            note: note(output, when_lost),
        };
        self.inputs.iter().map(input).chain(self.outputs.iter().map(output)).collect()
    }
}

/// What an output does at a stop, and when its controller is told nothing any more.
fn note(output: &OutputSetup, when_lost: WhenLost) -> String {
    let at_stop = output.on_stop.map_or_else(|| "holds".to_owned(), |value| format!("takes {value}"));
    let lost = match (when_lost, output.on_stop) {
        (WhenLost::AsDeclared, _) | (WhenLost::Hold, None) => return format!("{at_stop} at a stop"),
        (WhenLost::Hold, Some(_)) => "but HOLDS when this machine is lost",
        (WhenLost::Drop, _) if output.holds_body => "but LETS GO when this machine is lost",
        (WhenLost::Drop, _) => "and drops when this machine is lost",
    };
    format!("{at_stop} at a stop, {lost}")
}

const fn most(channel: Channel) -> usize {
    match channel {
        Channel::Digital(_) => DIGITAL,
        Channel::Analog(_) => ANALOG,
    }
}

const fn number(channel: Channel) -> usize {
    match channel {
        Channel::Digital(number) | Channel::Analog(number) => number as usize,
    }
}
