//! What the program that moves a robot is given to let a person jog it.
//!
//! In: what the cell's consoles ask for, once a step. Out: the same for a generator, with the robot's model and the cell's named
//! frames; and why the robot stands though its jog is held, for who holds it.

use core::cell::Cell;
use core::fmt;
use std::rc::Rc;

use super::JogRefusal;
use super::order::{JogFrame, JogMotion, JogOrder};
use crate::model::demand::Demand;
use crate::model::name::Name;
use crate::model::named::{CellNames, SignalNames};
use crate::model::pose::Pose;
use crate::model::robot::Robot;
use crate::model::signals::{Channel, Value};
use crate::model::wire::BadWords;

/// What is asked of a robot in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum JogNow {
    /// Nothing: it is to stand.
    #[default]
    Nothing,
    /// To move.
    Order {
        /// The number of the hold: another one is another press of a button.
        press: u64,
        /// What is asked for.
        order: JogOrder,
    },
    /// To go on with the program: the person has done with jogging.
    Done {
        /// The number of the press.
        press: u64,
    },
}

impl JogNow {
    /// How many words of a message it takes.
    pub const WORDS: usize = 2 + JogOrder::WORDS;

    /// Writes it into [`WORDS`](Self::WORDS) words, which are zeros.
    pub fn put(&self, words: &mut [u64]) {
        match self {
            JogNow::Nothing => {}
            JogNow::Order { press, order } => {
                (words[0], words[1]) = (1, *press);
                order.put(&mut words[2..]);
            }
            JogNow::Done { press } => (words[0], words[1]) = (2, *press),
        }
    }

    /// Reads it from [`WORDS`](Self::WORDS) words.
    ///
    /// # Errors
    /// [`BadWords`] when they spell nothing.
    pub fn get(words: &[u64]) -> Result<JogNow, BadWords> {
        match *words.get(..JogNow::WORDS).ok_or(BadWords)? {
            [0, ..] => Ok(JogNow::Nothing),
            [1, press, ref order @ ..] => Ok(JogNow::Order { press, order: JogOrder::get(order)? }),
            [2, press, ..] => Ok(JogNow::Done { press }),
            _ => Err(BadWords),
        }
    }
}

/// `press 7 tool x 50%`, `done 8`, `nothing`: as [`JogNow::read`] reads it.
impl fmt::Display for JogNow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            JogNow::Nothing => f.write_str("nothing"),
            JogNow::Order { press, order } => write!(f, "press {press} {order}"),
            JogNow::Done { press } => write!(f, "done {press}"),
        }
    }
}

impl JogNow {
    /// Reads it from a text.
    #[must_use]
    pub fn read(text: &str) -> Option<JogNow> {
        let mut words = text.split_whitespace();
        match (words.next()?, words.next().and_then(|press| press.parse().ok())) {
            ("press", Some(press)) => Some(JogNow::Order { press, order: JogOrder::read(&mut words).ok()? }),
            ("done", Some(press)) => Some(JogNow::Done { press }),
            ("nothing", None) => Some(JogNow::Nothing),
            _ => None,
        }
    }
}

/// Why a robot stands, or comes to stand, though its jog is held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum JogStop {
    /// It does not: it moves, or nobody jogs it.
    #[default]
    None,
    /// This joint, from 0, is as near to its limit as a jog goes.
    Joint(u8),
    /// The arm cannot follow its tool in this direction: it is out of reach, or near a singularity.
    Kinematics,
    /// It has gone as far as was asked for.
    There,
}

impl JogStop {
    /// As a word of a message.
    #[must_use]
    pub const fn to_word(self) -> u64 {
        match self {
            JogStop::None => 0,
            JogStop::Joint(joint) => 1 | (joint as u64) << 8,
            JogStop::Kinematics => 2,
            JogStop::There => 3,
        }
    }

    /// From a word of a message; what spells none is none.
    #[must_use]
    pub const fn from_word(word: u64) -> JogStop {
        match word & 0xff {
            1 => JogStop::Joint((word >> 8) as u8),
            2 => JogStop::Kinematics,
            3 => JogStop::There,
            _ => JogStop::None,
        }
    }

    /// In words; empty where there is none.
    #[must_use]
    pub fn text(self) -> String {
        match self {
            JogStop::None => String::new(),
            JogStop::Joint(joint) => format!("joint {} is at its limit", u32::from(joint) + 1),
            JogStop::Kinematics => {
                "the arm cannot go on in this direction: its reach ends, or a singularity is near".to_owned()
            }
            JogStop::There => "it is there".to_owned(),
        }
    }
}

/// Where what is asked of a robot is laid down for the generator that moves it.
#[derive(Clone, Debug, Default)]
pub struct JogSeat(Rc<Seat>);

#[derive(Debug, Default)]
struct Seat {
    now: Cell<JogNow>,
    /// The newest press that said that jogging is done.
    done: Cell<u64>,
    stop: Cell<JogStop>,
    /// Whether a generator has asked since this was asked last.
    read: Cell<bool>,
}

impl JogSeat {
    /// From now on this is asked for.
    pub fn say(&self, now: JogNow) {
        if let JogNow::Done { press } = now {
            self.0.done.set(self.0.done.get().max(press));
        }
        self.0.now.set(now);
    }

    /// Why the robot stands, as its generator has told last.
    #[must_use]
    pub fn stop(&self) -> JogStop {
        self.0.stop.get()
    }

    /// Nobody says any more why it stands.
    pub(crate) fn forget(&self) {
        self.0.stop.set(JogStop::None);
    }

    /// Whether a panel of it is in a program's hands.
    pub(crate) fn is_taken(&self, own: usize) -> bool {
        Rc::strong_count(&self.0) > own
    }

    /// Whether a generator has asked since this was asked last.
    pub(crate) fn take_read(&self) -> bool {
        self.0.read.take()
    }

    pub(crate) fn panel<R: Robot>(
        &self,
        model: Rc<R>,
        named: Rc<CellNames>,
        signals: Rc<SignalNames>,
    ) -> JogPanel<R> {
        JogPanel { seat: self.clone(), model, named, signals, ignores: self.0.done.get() }
    }
}

/// A program's panel of a robot that a person may jog: from [`Ecp::jog_panel`](crate::program::Ecp::jog_panel) or
/// [`Mp::jog_panel`](crate::program::Mp::jog_panel), for a generator that asks it once a step.
///
/// The robot may be jogged while a Move is at work whose generator asks the panel, and stands as soon as the hold is over, whatever
/// the generator demands.
///
/// ```
/// # use mrroc_core as mrroc;
/// use mrroc::operator::jog::{JogNow, JogPanel};
/// use mrroc_robots::Irp6;
///
/// // Without a cell: what is said to the seat, the panel tells.
/// let (mut panel, seat) = JogPanel::alone(Irp6::nominal());
/// assert_eq!(panel.now(), JogNow::Nothing);
/// seat.say(JogNow::Done { press: 1 });
/// assert_eq!(panel.now(), JogNow::Done { press: 1 });
/// ```
#[derive(Debug)]
pub struct JogPanel<R> {
    seat: JogSeat,
    model: Rc<R>,
    named: Rc<CellNames>,
    signals: Rc<SignalNames>,
    /// What said that jogging is done before this panel was taken is none of its.
    ignores: u64,
}

impl<R: Robot> JogPanel<R> {
    /// A panel of no cell, and where to say what it tells: to try a generator.
    #[must_use]
    pub fn alone(model: R) -> (JogPanel<R>, JogSeat) {
        let seat = JogSeat::default();
        (seat.panel(Rc::new(model), Rc::default(), Rc::default()), seat)
    }

    /// What is asked of the robot in this step.
    pub fn now(&mut self) -> JogNow {
        self.seat.0.read.set(true);
        match self.seat.0.now.get() {
            JogNow::Done { press } if press <= self.ignores => JogNow::Nothing,
            now => now,
        }
    }

    /// Tells who holds why the robot stands, or that it does not.
    pub fn tell(&mut self, stop: JogStop) {
        self.seat.0.stop.set(stop);
    }

    /// The robot's model: its kinematics and limits.
    #[must_use]
    pub fn model(&self) -> &R {
        &self.model
    }

    /// The pose in the world of a frame, `X_WU`, whose axes a tool with the pose `X_WE` is to follow; `None` if the cell names no
    /// such frame.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn frame(&self, frame: JogFrame, X_WE: &Pose) -> Option<Pose> {
        match frame {
            JogFrame::Tool => Some(*X_WE),
            JogFrame::World => Some(Pose::identity()),
            JogFrame::Named(name) => named(&self.named, name),
        }
    }

    /// The same demand, with the value of the output that an order switches, if it switches one.
    #[must_use]
    pub fn switched(&self, demand: Demand<R>, order: &JogOrder) -> Demand<R> {
        match order.motion {
            JogMotion::Output { output, to } => match switchable(&self.signals, output, to) {
                Ok(channel) => demand.with_value(channel, to),
                Err(_) => demand,
            },
            JogMotion::Tool { .. } | JogMotion::Joint { .. } | JogMotion::To { .. } => demand,
        }
    }
}

/// The channel of an output that a person switches.
///
/// # Errors
/// Why it may not be switched like this.
pub(crate) fn switchable(names: &SignalNames, output: Name, to: Value) -> Result<Channel, JogRefusal> {
    let known = names.outputs.iter().find(|(name, _)| name == output.as_str());
    let channel = known.map(|(_, channel)| *channel).ok_or(JogRefusal::NoOutput)?;
    if matches!(channel, Channel::Digital(_)) != matches!(to, Value::Digital(_)) {
        return Err(JogRefusal::NoOutput);
    }
    match names.tools.iter().find(|(name, _)| name == output.as_str()) {
        Some((_, at_stop)) if *at_stop != to => Err(JogRefusal::DrivesTool),
        Some(_) | None => Ok(channel),
    }
}

/// The pose of a frame that a cell names.
pub(crate) fn named(names: &CellNames, frame: Name) -> Option<Pose> {
    names.frames.iter().find(|(name, _)| name == frame.as_str()).map(|(_, pose)| *pose)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operator::jog::order::{JogAxis, JogMotion};

    #[test]
    fn what_is_asked_for_and_why_a_robot_stands_survive_their_words() {
        let motion = JogMotion::Tool { frame: JogFrame::World, axis: JogAxis::Ry };
        let order = JogOrder { motion, speed: -0.5, distance: Some(0.01) };
        for now in [JogNow::Nothing, JogNow::Order { press: 7, order }, JogNow::Done { press: 8 }] {
            let mut words = [0; JogNow::WORDS];
            now.put(&mut words);
            assert_eq!(JogNow::get(&words), Ok(now));
            assert_eq!(JogNow::read(&now.to_string()), Some(now));
        }
        assert_eq!(JogNow::get(&[3; JogNow::WORDS]), Err(BadWords));
        assert_eq!(JogNow::get(&[0; 2]), Err(BadWords));
        for stop in [JogStop::None, JogStop::Joint(7), JogStop::Kinematics, JogStop::There] {
            assert_eq!(JogStop::from_word(stop.to_word()), stop);
            assert_eq!(stop.text().is_empty(), stop == JogStop::None);
        }
    }
}
