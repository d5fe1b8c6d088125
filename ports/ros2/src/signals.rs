//! Named inputs and outputs of robots as topics.
//!
//! In: pictures of the cell. Out: a message for each signal whose value has changed, kept for who comes later.

use mrroc_core::observe::layout::{Layout, SignalLayout};
use mrroc_core::robot::{Channel, Signals};
use mrroc_processes::Picture;
use ros2_client::Publisher;

use crate::messages::{Flag, Number};
use crate::node::{RosNode, kept, topic_name};

/// The topics of all named signals of a cell.
pub struct SignalTopics(Vec<SignalTopic>);

struct SignalTopic {
    robot: String,
    is_output: bool,
    publisher: SignalPublisher,
}

enum SignalPublisher {
    Digital { number: u8, topic: Publisher<Flag>, last: Option<bool> },
    Analog { number: u8, topic: Publisher<Number>, last: Option<f64> },
}

impl SignalTopics {
    /// Those of a cell of this layout.
    ///
    /// # Errors
    /// Why a topic cannot be published.
    pub fn open(node: &mut RosNode, layout: &Layout) -> Result<SignalTopics, String> {
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

    /// Publishes what has changed.
    pub fn picture(&mut self, picture: &Picture) {
        for topic in &mut self.0 {
            let of = picture.carried.iter().find(|carried| carried.robot == topic.robot);
            if let Some(carried) = of {
                topic.publisher.publish(&carried.signals, topic.is_output);
            }
        }
    }
}

impl SignalPublisher {
    fn open(node: &mut RosNode, robot: &str, signal: &SignalLayout) -> Result<SignalPublisher, String> {
        let direction = if signal.is_output { "outputs" } else { "inputs" };
        let topic = format!("/{}/{direction}/{}", topic_name(robot), topic_name(&signal.name));
        Ok(match signal.channel {
            Channel::Digital(number) => {
                let topic = node.publisher(&topic, ("std_msgs", "Bool"), kept())?;
                SignalPublisher::Digital { number, topic, last: None }
            }
            Channel::Analog(number) => {
                let topic = node.publisher(&topic, ("std_msgs", "Float64"), kept())?;
                SignalPublisher::Analog { number, topic, last: None }
            }
        })
    }

    /// What nobody takes is dropped.
    fn publish(&mut self, signals: &Signals, is_output: bool) {
        let values = if is_output { &signals.outputs } else { &signals.inputs };
        match self {
            SignalPublisher::Digital { number, topic, last } => {
                let data = values.is_on(*number);
                if last.replace(data) != Some(data) {
                    drop(topic.publish(Flag { data }));
                }
            }
            SignalPublisher::Analog { number, topic, last } => {
                let data = values.analog(*number);
                if last.replace(data) != Some(data) {
                    drop(topic.publish(Number { data }));
                }
            }
        }
    }
}
