//! A simulated virtual sensor in the plant, as its VSP reaches it.
//!
//! In: orders. Out: readings, or the fault that none came.

use crate::link::message::Message;
use crate::link::timeout::AnswerTimeout;
use crate::link::{Client, Closed, Waiter};
use crate::model::fault::{Fault, FaultKind, ProcessId};

/// The VSP's end.
pub(crate) struct PlantSensor {
    pub port: Box<dyn Client>,
    /// The plant's place.
    pub plant: usize,
    pub timeout: AnswerTimeout,
}

impl PlantSensor {
    /// Answers an order with a reading, or with the fault for which there is no reading.
    ///
    /// # Errors
    /// [`Closed`] when the cell is closing.
    pub fn answer(&self, request: &Message, reply: &mut Message, waiter: &dyn Waiter) -> Result<(), Closed> {
        self.port.send(request);
        waiter.call(self.plant)?;
        let mut waiting = self.timeout.begin(waiter);
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
