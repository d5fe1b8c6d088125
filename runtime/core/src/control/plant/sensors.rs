//! A simulated virtual sensor in the plant: what it senses is there, and so is it.
//!
//! In: the orders that its VSP has taken, as they are. Out: the readings, with which the VSP answers its requesters.

use super::{Part, Rest};
use crate::control::vsp::Aggregator;
use crate::link::Server;
use crate::link::message::Message;
use crate::model::time::Nanos;

/// The plant's end.
pub(super) struct Sensor {
    aggregator: Aggregator,
    orders: Box<dyn Server>,
    request: Message,
    reply: Message,
}

impl Sensor {
    pub fn new(aggregator: Aggregator, orders: Box<dyn Server>) -> Self {
        Sensor { aggregator, orders, request: Message::empty(), reply: Message::empty() }
    }
}

impl Part for Sensor {
    fn serve(&mut self) {
        if self.orders.receive(&mut self.request) {
            let step = self.request.header.step;
            // Simulated sensors open nothing.
            self.aggregator.answer(&self.request, &mut self.reply, 0);
            self.reply.header.step = step;
            self.orders.reply(&self.reply);
        }
    }

    fn advance(&mut self, _: Nanos) {}

    fn due(&self) -> Option<Nanos> {
        None
    }

    fn rests(&self) -> bool {
        true
    }

    fn rest(&self) -> Option<Rest> {
        None
    }
}
