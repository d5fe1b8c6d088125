//! What a console asks of a robot that is jogged, as text and as words of a message.
//!
//! ```text
//! tool x -50%            along the tool's x axis, backwards, at half of the largest jogging speed
//! world rz 20% by 0.1    about the world's z axis, by 0.1 rad
//! frame table y 100%     along the y axis of the frame that the cell calls `table`
//! joint 3 10% by 0.05    the third joint, by 0.05 rad or m
//! to 50% 0 -1.57 0.16    to these joint positions [rad or m]
//! output gripper off     the robot stands; its output that the cell calls `gripper` is off
//! output valve 0.35      the same of an analog output, in its driver's unit
//! ```

use core::fmt;
use core::str::SplitWhitespace;

use crate::model::joints::{JointVector, MAX_JOINTS};
use crate::model::name::Name;
use crate::model::signals::Value;
use crate::model::wire::{BadWords, Wire};
use crate::operator::no_request::NoRequest;

/// What a console asks of the robot that it jogs, as long as its hold lasts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JogOrder {
    /// What is moved.
    pub motion: JogMotion,
    /// How fast, as a share of the largest jogging speed, -1 to 1 and not 0; the sign says in which direction. Above 0 of a motion to joint
    /// positions, 1 of an output.
    pub speed: f64,
    /// By how much in one hold [m or rad], > 0; `None`: as long as it is held.
    pub distance: Option<f64>,
}

/// What a jog moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JogMotion {
    /// The tool, along or about an axis of a frame. It turns about its own origin.
    Tool {
        /// The frame.
        frame: JogFrame,
        /// The axis.
        axis: JogAxis,
    },
    /// One joint.
    Joint {
        /// Which, from 0.
        joint: u8,
    },
    /// All joints, straight in joint space to positions.
    To {
        /// The positions.
        joints: JogJoints,
    },
    /// Nothing: an output of the robot's controller is switched, while the robot stands.
    Output {
        /// What the cell calls it.
        output: Name,
        /// What it is to be.
        to: Value,
    },
}

/// The frame whose axes a tool follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JogFrame {
    /// The tool's own, as it is when the jog begins.
    Tool,
    /// The world of the robot's model.
    World,
    /// One that the cell names, such as a table.
    Named(Name),
}

/// An axis along which a tool moves, or about which it turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JogAxis {
    /// Along x \[m\].
    X,
    /// Along y \[m\].
    Y,
    /// Along z \[m\].
    Z,
    /// About x \[rad\].
    Rx,
    /// About y \[rad\].
    Ry,
    /// About z \[rad\].
    Rz,
}

impl JogAxis {
    /// All of them; one travels as its place in this list.
    pub const ALL: [JogAxis; 6] = [JogAxis::X, JogAxis::Y, JogAxis::Z, JogAxis::Rx, JogAxis::Ry, JogAxis::Rz];

    /// Its word.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            JogAxis::X => "x",
            JogAxis::Y => "y",
            JogAxis::Z => "z",
            JogAxis::Rx => "rx",
            JogAxis::Ry => "ry",
            JogAxis::Rz => "rz",
        }
    }

    /// Which of the three axes it is, from 0.
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize % 3
    }

    /// Whether the tool turns about it.
    #[must_use]
    pub const fn turns(self) -> bool {
        matches!(self, JogAxis::Rx | JogAxis::Ry | JogAxis::Rz)
    }
}

/// Joint positions of a robot of any kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JogJoints {
    count: u8,
    positions: [f64; MAX_JOINTS],
}

impl JogJoints {
    /// Of these positions [rad or m]: finite, 1 to [`MAX_JOINTS`] of them.
    #[must_use]
    pub fn new(positions: &[f64]) -> Option<JogJoints> {
        let fits = (1..=MAX_JOINTS).contains(&positions.len()) && positions.iter().all(|q| q.is_finite());
        let mut all = [0.0; MAX_JOINTS];
        fits.then(|| all[..positions.len()].copy_from_slice(positions))?;
        Some(JogJoints { count: positions.len() as u8, positions: all })
    }

    /// The positions [rad or m].
    #[must_use]
    pub fn positions(&self) -> &[f64] {
        &self.positions[..usize::from(self.count)]
    }

    /// As joints of a robot that has so many.
    #[must_use]
    pub fn of<J: JointVector>(&self) -> Option<J> {
        (J::LEN == self.positions().len()).then(|| J::from_joints(|i| self.positions[i]))
    }
}

/// A share as percent, as it is written: to nine digits.
pub(in crate::operator) fn percent(share: f64) -> f64 {
    (1e11 * share).round() / 1e9
}

/// The share that a number of percent is, `50`, `50%`; whatever number it is.
pub(in crate::operator) fn share(text: &str) -> Option<f64> {
    let percent = text.strip_suffix('%').unwrap_or(text).trim_end().parse::<f64>().ok()?;
    percent.is_finite().then(|| (percent * 1e9).round() / 1e11)
}

/// What to write.
const HELP: &str = "write what to move, and how fast: tool x -50%, world rz 20% by 0.1, frame table y 5%, joint 3 10%, or to 50% \
                    and a position for each joint; or what to switch: output gripper off";

/// Which word of a message has the value of an output: the one behind its name.
const VALUE: usize = 3 + <Name as Wire>::LEN;

impl JogOrder {
    /// How many words of a message it takes.
    pub const WORDS: usize = 3 + MAX_JOINTS;

    /// The same, if it can be carried out.
    fn checked(self) -> Option<JogOrder> {
        let (slowest, has_distance, is_known) = match self.motion {
            JogMotion::Tool { .. } => (-1.0, true, true),
            JogMotion::Joint { joint } => (-1.0, true, usize::from(joint) < MAX_JOINTS),
            JogMotion::To { .. } => (f64::MIN_POSITIVE, false, true),
            JogMotion::Output { to, .. } => (1.0, false, !matches!(to, Value::Analog(to) if !to.is_finite())),
        };
        let speed = (slowest..=1.0).contains(&self.speed) && self.speed != 0.0;
        let distance =
            self.distance.is_none_or(|distance| distance.is_finite() && distance > 0.0 && has_distance);
        (speed && distance && is_known).then_some(self)
    }

    /// Reads one from the words of a text, all that are left.
    ///
    /// # Errors
    /// [`NoRequest`]: what to write.
    pub fn read(words: &mut SplitWhitespace<'_>) -> Result<JogOrder, NoRequest> {
        JogOrder::parsed(words).and_then(JogOrder::checked).ok_or_else(|| NoRequest {
            what: "it is not said what is to be jogged".to_owned(),
            help: HELP.to_owned(),
        })
    }

    fn parsed(words: &mut SplitWhitespace<'_>) -> Option<JogOrder> {
        let frame = match words.next()? {
            "tool" => JogFrame::Tool,
            "world" => JogFrame::World,
            "frame" => JogFrame::Named(Name::new(words.next()?).ok()?),
            "joint" => {
                let joint = words.next()?.parse::<u8>().ok()?.checked_sub(1)?;
                return JogOrder::by(JogMotion::Joint { joint }, words);
            }
            "to" => {
                let speed = share(words.next()?)?;
                let positions = words.map(|word| word.parse().ok()).collect::<Option<Vec<f64>>>()?;
                let joints = JogJoints::new(&positions)?;
                return Some(JogOrder { motion: JogMotion::To { joints }, speed, distance: None });
            }
            "output" => {
                let output = Name::new(words.next()?).ok()?;
                let to = match words.next()? {
                    "on" => Value::Digital(true),
                    "off" => Value::Digital(false),
                    value => Value::Analog(value.parse().ok()?),
                };
                let motion = JogMotion::Output { output, to };
                return words.next().is_none().then_some(JogOrder { motion, speed: 1.0, distance: None });
            }
            _ => return None,
        };
        let axis = words.next()?;
        let axis = JogAxis::ALL.into_iter().find(|known| known.word() == axis)?;
        JogOrder::by(JogMotion::Tool { frame, axis }, words)
    }

    /// The rest of a text: the speed, and the distance if there is one.
    fn by(motion: JogMotion, words: &mut SplitWhitespace<'_>) -> Option<JogOrder> {
        let speed = share(words.next()?)?;
        let distance = match words.next() {
            None => None,
            Some("by") => Some(words.next()?.parse().ok()?),
            Some(_) => return None,
        };
        words.next().is_none().then_some(JogOrder { motion, speed, distance })
    }

    /// Writes it into [`WORDS`](Self::WORDS) words.
    pub fn put(&self, words: &mut [u64]) {
        let (tag, frame, number) = match &self.motion {
            JogMotion::Tool { frame, axis } => {
                let frame = match frame {
                    JogFrame::Tool => 0,
                    JogFrame::World => 1,
                    JogFrame::Named(name) => {
                        name.put(&mut words[3..]);
                        2
                    }
                };
                (0, frame, *axis as u64)
            }
            JogMotion::Joint { joint } => (1, 0, u64::from(*joint)),
            JogMotion::To { joints } => {
                for (word, q) in words[3..].iter_mut().zip(joints.positions()) {
                    *word = q.to_bits();
                }
                (2, 0, u64::from(joints.count))
            }
            JogMotion::Output { output, to } => {
                output.put(&mut words[3..]);
                let (of, word) = match to {
                    Value::Digital(on) => (0, u64::from(*on)),
                    Value::Analog(value) => (1, value.to_bits()),
                };
                words[VALUE] = word;
                (3, of, 0)
            }
        };
        words[0] = tag | frame << 8 | number << 16;
        words[1] = self.speed.to_bits();
        words[2] = self.distance.unwrap_or(0.0).to_bits();
    }

    /// Reads it from [`WORDS`](Self::WORDS) words.
    ///
    /// # Errors
    /// [`BadWords`] when they spell none.
    pub fn get(words: &[u64]) -> Result<JogOrder, BadWords> {
        let words = words.get(..JogOrder::WORDS).ok_or(BadWords)?;
        let number = usize::try_from(words[0] >> 16).map_err(|_| BadWords)?;
        let motion = match (words[0] & 0xff, words[0] >> 8 & 0xff) {
            (0, frame) => {
                let frame = match frame {
                    0 => JogFrame::Tool,
                    1 => JogFrame::World,
                    2 => JogFrame::Named(Name::get(&words[3..])?),
                    _ => return Err(BadWords),
                };
                JogMotion::Tool { frame, axis: *JogAxis::ALL.get(number).ok_or(BadWords)? }
            }
            (1, 0) => JogMotion::Joint { joint: u8::try_from(number).map_err(|_| BadWords)? },
            (2, 0) => {
                let positions = words.get(3..3 + number.min(MAX_JOINTS)).ok_or(BadWords)?;
                let mut joints = [0.0; MAX_JOINTS];
                joints.iter_mut().zip(positions).for_each(|(q, word)| *q = f64::from_bits(*word));
                let joints = joints.get(..number).and_then(JogJoints::new).ok_or(BadWords)?;
                JogMotion::To { joints }
            }
            (3, of) => {
                let to = match (of, words[VALUE]) {
                    (0, on @ (0 | 1)) => Value::Digital(on == 1),
                    (1, value) => Value::Analog(f64::from_bits(value)),
                    _ => return Err(BadWords),
                };
                JogMotion::Output { output: Name::get(&words[3..])?, to }
            }
            _ => return Err(BadWords),
        };
        let distance = f64::from_bits(words[2]);
        let distance = (distance != 0.0).then_some(distance);
        JogOrder { motion, speed: f64::from_bits(words[1]), distance }.checked().ok_or(BadWords)
    }
}

/// As [`JogOrder::read`] reads it.
impl fmt::Display for JogOrder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let speed = percent(self.speed);
        match &self.motion {
            JogMotion::Tool { frame, axis } => {
                match frame {
                    JogFrame::Tool => f.write_str("tool")?,
                    JogFrame::World => f.write_str("world")?,
                    JogFrame::Named(name) => write!(f, "frame {name}")?,
                }
                write!(f, " {} {speed}%", axis.word())?;
            }
            JogMotion::Joint { joint } => write!(f, "joint {} {speed}%", u32::from(*joint) + 1)?,
            JogMotion::To { joints } => {
                write!(f, "to {speed}%")?;
                return joints.positions().iter().try_for_each(|q| write!(f, " {q:?}"));
            }
            JogMotion::Output { output, to } => {
                return write!(f, "output {output} {to}");
            }
        }
        self.distance.map_or(Ok(()), |distance| write!(f, " by {distance:?}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read(text: &str) -> Result<JogOrder, NoRequest> {
        JogOrder::read(&mut text.split_whitespace())
    }

    fn motions() -> impl Strategy<Value = JogMotion> {
        let table = Name::new("table-with-twenty-four-b").expect("a name");
        let frame = prop_oneof![Just(JogFrame::Tool), Just(JogFrame::World), Just(JogFrame::Named(table))];
        let gripper = Name::new("gripper").expect("a name");
        let value =
            prop_oneof![any::<bool>().prop_map(Value::Digital), (-9.0..9.0_f64).prop_map(Value::Analog)];
        prop_oneof![
            value.prop_map(move |to| JogMotion::Output { output: gripper, to }),
            (frame, 0_usize..6).prop_map(|(frame, axis)| JogMotion::Tool { frame, axis: JogAxis::ALL[axis] }),
            (0..MAX_JOINTS as u8).prop_map(|joint| JogMotion::Joint { joint }),
            prop::collection::vec(-7.0..7.0_f64, 1..=MAX_JOINTS).prop_map(|positions| {
                JogMotion::To { joints: JogJoints::new(&positions).expect("finite") }
            }),
        ]
    }

    proptest! {
        #[test]
        fn every_order_is_read_as_it_is_written_and_sent_as_it_is(
            motion in motions(), percent in 1_i32..=100, back in any::<bool>(), distance in prop::option::of(1e-6..10.0_f64)
        ) {
            let is_to = matches!(motion, JogMotion::To { .. } | JogMotion::Output { .. });
            let share = f64::from(if back && !is_to { -percent } else { percent }) / 100.0;
            let speed = if matches!(motion, JogMotion::Output { .. }) { 1.0 } else { share };
            let order = JogOrder { motion, speed, distance: distance.filter(|_| !is_to) };
            prop_assert_eq!(read(&order.to_string()), Ok(order));
            let mut words = [0; JogOrder::WORDS];
            order.put(&mut words);
            prop_assert_eq!(JogOrder::get(&words), Ok(order));
        }

        #[test]
        fn words_that_spell_no_order_are_refused_without_harm(words in prop::collection::vec(any::<u64>(), 0..20)) {
            // Whatever is read can be carried out.
            if let Ok(order) = JogOrder::get(&words) {
                prop_assert!(order.checked().is_some());
            }
        }
    }

    #[test]
    fn what_cannot_be_carried_out_is_refused_with_what_to_write() {
        for text in [
            "",
            "tool",
            "tool w 10%",
            "tool x",
            "tool x 0%",
            "tool x 101%",
            "tool x -101%",
            "tool x NaN%",
            "tool x 10% by 0",
            "tool x 10% by -1",
            "tool x 10% by inf",
            "tool x 10% by 1 more",
            "joint 0 10%",
            "joint 9 10%",
            "frame a:b x 10%",
            "to 10%",
            "to -10% 0 0",
            "to 10% 0 NaN",
            "to 10% 0 0 0 0 0 0 0 0 0",
            "up 10%",
            "output gripper",
            "output gripper maybe",
            "output valve NaN",
            "output gripper on 5%",
        ] {
            let refused = read(text).expect_err(text);
            assert!(refused.help.contains("tool x -50%"), "{refused}");
        }
    }
}
