//! A simulated virtual sensor in the plant: what it senses is there, and so is it.
//!
//! In: the orders that its VSP has taken, as they are. Out: the readings, with which the VSP answers its requesters.

use super::{Part, Rest};
use crate::fault::{Fault, FaultKind, ProcessId};
use crate::link::patience::Patience;
use crate::link::{Client, Closed, Nanos, Server, Waiter};
use crate::message::Message;
use crate::vsp::{Aggregator, VirtualSensor};

/// The plant's end.
pub(super) struct Sensor<V: VirtualSensor> {
    aggregator: Aggregator<V>,
    orders: Box<dyn Server>,
    request: Message,
    reply: Message,
}

impl<V: VirtualSensor> Sensor<V> {
    pub fn new(aggregator: Aggregator<V>, orders: Box<dyn Server>) -> Self {
        Sensor { aggregator, orders, request: Message::empty(), reply: Message::empty() }
    }
}

impl<V: VirtualSensor> Part for Sensor<V> {
    fn serve(&mut self) {
        if self.orders.receive(&mut self.request) {
            self.aggregator.answer(&self.request, &mut self.reply);
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

/// The VSP's end.
pub(crate) struct PlantSensor {
    pub port: Box<dyn Client>,
    /// The plant's place.
    pub plant: usize,
    pub patience: Patience,
}

impl PlantSensor {
    /// The reading for an order, or the fault that there is none.
    ///
    /// # Errors
    /// [`Closed`] when the cell is closing.
    pub fn answer(&self, request: &Message, reply: &mut Message, waiter: &dyn Waiter) -> Result<(), Closed> {
        self.port.send(request);
        waiter.call(self.plant)?;
        let mut waiting = self.patience.begin(waiter);
        while !self.port.receive(reply) {
            if !waiting.goes_on(&*self.port, waiter)? {
                let fault = Fault::new(FaultKind::PeerLost).in_process(ProcessId::PLANT);
                reply.set_fault(&fault.at_step(request.header.step));
                return Ok(());
            }
        }
        Ok(())
    }
}
