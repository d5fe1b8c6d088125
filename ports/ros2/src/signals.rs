//! Named inputs and outputs of robots as topics.
//!
//! In: what inputs read and outputs are. Out: a message for each signal whose value has changed, kept for who comes later.

use mrroc_core::observe::layout::{Layout, SignalLayout};
use mrroc_core::robot::{Channel, Signals};

use crate::messages::{Flag, Number};
use crate::node::topic_name;
use crate::outlet::{Durability, Outlet, Put};

/// The topics of all named signals of a cell.
pub struct SignalTopics<O: Outlet>(Vec<SignalTopic<O>>);

struct SignalTopic<O: Outlet> {
    robot: String,
    is_output: bool,
    publisher: SignalPublisher<O>,
}

enum SignalPublisher<O: Outlet> {
    Digital { number: u8, topic: O::Topic<Flag>, last: Option<bool> },
    Analog { number: u8, topic: O::Topic<Number>, last: Option<f64> },
}

impl<O: Outlet> SignalTopics<O> {
    /// Those of a cell of this layout.
    ///
    /// # Errors
    /// Why a topic cannot be published.
    pub fn open(node: &mut O, layout: &Layout) -> Result<Self, String> {
        let mut topics = Vec::new();
        for robot in &layout.robots {
            for signal in &robot.signals {
                let publisher = SignalPublisher::open(node, &robot.name, signal)?;
                topics.push(SignalTopic {
                    robot: robot.name.clone(),
                    is_output: signal.is_output,
                    publisher,
                });
            }
        }
        Ok(SignalTopics(topics))
    }

    /// Publishes what has changed of a robot.
    pub fn put(&mut self, robot: &str, signals: &Signals) {
        for topic in self.0.iter_mut().filter(|topic| topic.robot == robot) {
            topic.publisher.publish(signals, topic.is_output);
        }
    }
}

impl<O: Outlet> SignalPublisher<O> {
    fn open(node: &mut O, robot: &str, signal: &SignalLayout) -> Result<Self, String> {
        let direction = if signal.is_output { "outputs" } else { "inputs" };
        let topic = format!("/{}/{direction}/{}", topic_name(robot), topic_name(&signal.name));
        Ok(match signal.channel {
            Channel::Digital(number) => {
                let topic = node.topic(&topic, Durability::TransientLocal)?;
                SignalPublisher::Digital { number, topic, last: None }
            }
            Channel::Analog(number) => {
                let topic = node.topic(&topic, Durability::TransientLocal)?;
                SignalPublisher::Analog { number, topic, last: None }
            }
        })
    }

    fn publish(&mut self, signals: &Signals, is_output: bool) {
        let values = if is_output { &signals.outputs } else { &signals.inputs };
        match self {
            SignalPublisher::Digital { number, topic, last } => {
                let data = values.is_on(*number);
                if last.replace(data) != Some(data) {
                    topic.put(Flag { data });
                }
            }
            SignalPublisher::Analog { number, topic, last } => {
                let data = values.analog(*number);
                if last.replace(data) != Some(data) {
                    topic.put(Number { data });
                }
            }
        }
    }
}
