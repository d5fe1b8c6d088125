//! A lower cell as its upper MP sees it: a robot that may be left out of a Move.
//!
//! In: the answers of a cell. Out: for a program that goes on without a cell that has a fault, an answer in that cell's place,
//! as of one that has finished and stands, until the next Move that names it.

use crate::link::message::{Kind, Message, OrderKind, flag};
use crate::model::fault::{Fault, FaultKind};
use crate::model::image::{IMAGE_WORDS, RobotImage};
use crate::model::list::{Owner, PayloadType, RobotHandle};
use crate::model::lower_cell::{CellStatus, LowerCell};
use crate::model::wire::Wire;

use super::Mp;
use super::robots::{CELL_SILENT, RobotPort};

impl RobotPort {
    /// Whether it is a cell that has no part in what an order is for.
    pub(super) fn is_left_out_of(&self, kind: OrderKind) -> bool {
        let of_instruction = match kind {
            OrderKind::Step | OrderKind::End | OrderKind::Abort | OrderKind::Brake => true,
            OrderKind::Query | OrderKind::Start | OrderKind::Stop | OrderKind::Reset => false,
        };
        of_instruction && self.lower.as_ref().is_some_and(|lower| lower.out)
    }

    /// An instruction begins that names it.
    pub(super) fn name_again(&mut self) {
        if let Some(lower) = &mut self.lower {
            (lower.out, lower.fault) = (false, None);
        }
    }

    /// After an answer, or in vain: puts one in the place of that of a cell with a fault, if the program goes on without it.
    pub(super) fn stand_in_for_cell(&mut self) {
        let Some(lower) = self.lower.as_mut().filter(|lower| lower.dispensable) else { return };
        // At a stop the robots of each cell count, whatever it says.
        if !self.asked || self.order.header.kind == Kind::Order(OrderKind::Stop) {
            return;
        }
        let fault = if self.is_silent {
            Fault::new(FaultKind::PeerLost).in_process(self.facts.process).text(CELL_SILENT)
        } else if self.reply.header.kind == Kind::Fault {
            self.reply.fault()
        } else {
            return;
        };
        (lower.fault, lower.out) = (Some(fault), true);
        self.is_silent = false;
        let header = self.order.header;
        self.reply = Message::new(Kind::Reply);
        (self.reply.header.step, self.reply.header.epoch) = (header.step, header.epoch);
        self.reply.header.flags = flag::FINISHED | flag::ENDED | flag::STANDSTILL | flag::STATE;
        self.reply.header.len = IMAGE_WORDS as u32;
        let status = CellStatus { ready: false, latched: true, suspended: false, rate: 0.0 };
        RobotImage::<LowerCell>::of_cell(status).put(&mut self.reply.body);
    }
}

impl Mp<'_> {
    /// From now on Moves and Waits **go on without this cell** when it has a fault or does not answer: the fault stops neither the
    /// other robots nor the Move, which ends as if this cell had finished. [`left_out`](Self::left_out) tells. By default such a
    /// fault is that of the Move, and stops all cells.
    ///
    /// The cell stays latched until its own operator resets it. Its image then says that it [is
    /// ready](RobotImage::is_ready), and the next Move that names it orders it again.
    ///
    /// # Errors
    /// `Config`: the handle is of another MP.
    ///
    /// # Example
    /// ```
    /// use mrroc::cell::LowerCell;
    /// use mrroc::prelude::*;
    ///
    /// #[derive(Clone, Copy, Payload)]
    /// enum Job {
    ///     Weld,
    /// }
    ///
    /// #[generator(mp)]
    /// fn weld() -> Always<(LowerCell, LowerCell), Job> {
    ///     Always((Job::Weld, Job::Weld))
    /// }
    ///
    /// #[condition(mp)]
    /// fn is_back(e: &State<(LowerCell,)>) -> bool {
    ///     e.0.is_ready()
    /// }
    ///
    /// fn coordinate(mp: &mut Mp) -> Result<(), Fault> {
    ///     let (mut left, mut right) = (mp.robot::<LowerCell>("left")?, mp.robot::<LowerCell>("right")?);
    ///     mp.go_on_without(&left)?;
    ///     mp.move_robots((&mut left, &mut right), (), weld {})?;
    ///     if let Some(fault) = mp.left_out(&left) {
    ///         eprintln!("the right cell has welded alone: {fault}");
    ///         mp.wait_until((&mut left,), (), is_back {})?; // its operator resets it
    ///     }
    ///     Ok(())
    /// }
    /// ```
    pub fn go_on_without(&mut self, cell: &RobotHandle<LowerCell>) -> Result<(), Fault> {
        let stranger = self.robots.owner.not_its_own(cell.owner, cell.name);
        Owner::refuse("cell", stranger).map_err(|fault| fault.in_process(self.process))?;
        if let Some(lower) = &mut self.robots[cell.index].lower {
            lower.dispensable = true;
        }
        Ok(())
    }

    /// The fault for which the last Move that named this cell went on without it, or a Wait since then; `None` if it took part.
    #[must_use]
    pub fn left_out(&self, cell: &RobotHandle<LowerCell>) -> Option<Fault> {
        if cell.owner != self.robots.owner {
            return None;
        }
        self.robots[cell.index].lower.as_ref()?.fault.clone()
    }

    /// Refuses orders that no cell takes, before anything moves.
    ///
    /// # Errors
    /// `PayloadMismatch` for the first cell of which one is asked.
    pub(super) fn refuse_tight(
        &self,
        indices: &[usize],
        payload: &dyn Fn(usize) -> PayloadType,
    ) -> Result<(), Fault> {
        for (i, robot) in indices.iter().map(|&index| &self.robots[index]).enumerate() {
            let payload = payload(i);
            if robot.lower.is_some() && payload.tight {
                let text = format!(
                    "cell `{}` takes loose orders, an `enum`; `{}` is a struct of tight ones",
                    robot.facts.name, payload.name
                );
                return Err(Fault::new(FaultKind::PayloadMismatch).in_process(self.process).text(&text));
            }
        }
        Ok(())
    }
}
