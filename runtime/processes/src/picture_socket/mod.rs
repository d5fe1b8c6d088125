//! What the processes of a cell show its picture, on its way to the plant, which draws the picture.
//!
//! In: steps of the MP, readings that the MP and ECPs collect, inputs and outputs that EDPs have. Out: the same to the observers
//! of the picture, on a thread of the plant. The step of a process copies what it shows into a ring; a thread sends it through
//! a datagram socket in the session's folder (`sender`), in which the plant receives it (`receiver`), as `datagram`s of plain
//! words. The plant makes the socket before the cell begins. When it is full, the sender's thread waits. When the ring is full,
//! too, a step in real time drops what it shows, and the plant tells how much is missing; under the virtual clock it waits.

mod datagram;
mod receiver;
mod sender;
#[cfg(test)]
mod tests;

pub(crate) use receiver::Receiver;
pub(crate) use sender::join;
