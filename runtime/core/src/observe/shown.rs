//! What a robot's program shows to observers: which stroke it engraves, say.
//!
//! In: values that the program sets. Out: the same to observers, in the same process or, where the cell runs as processes,
//! in the plant, over a board. Nothing in a cell acts on it.

use core::cell::{Cell, OnceCell};
use std::rc::Rc;

use crate::link::Board;
use crate::link::message::{Kind, Message};
use crate::model::wire::Wire;

/// A value that a program of an ECP sets and observers read; all copies are the same. A robot's set-up names it:
/// [`RobotSetup::shows`](crate::cell::RobotSetup::shows).
///
/// ```
/// let stroke = mrroc::observe::Shown::new(0_u32);
/// let seen = stroke.clone();
/// stroke.set(3);
/// assert_eq!(seen.get(), 3);
/// ```
pub struct Shown<T>(Rc<Inner<T>>);

struct Inner<T> {
    value: Cell<T>,
    /// Whether it is set in this process.
    own: Cell<bool>,
    /// The board by which the value gets from one process to the other.
    board: OnceCell<Rc<dyn Board>>,
}

impl<T> Clone for Shown<T> {
    fn clone(&self) -> Self {
        Shown(Rc::clone(&self.0))
    }
}

impl<T: core::fmt::Debug + Wire> core::fmt::Debug for Shown<T> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_tuple("Shown").field(&self.get()).finish()
    }
}

impl<T: Wire> Shown<T> {
    /// Shows this until something else is set.
    #[must_use]
    pub fn new(value: T) -> Shown<T> {
        Shown(Rc::new(Inner { value: Cell::new(value), own: Cell::new(false), board: OnceCell::new() }))
    }

    /// Shows a value from now on.
    pub fn set(&self, value: T) {
        self.0.value.set(value);
        self.0.own.set(true);
        if let Some(board) = self.0.board.get() {
            let mut message = Message::empty();
            message.header.kind = Kind::Reply;
            message.header.len = T::LEN as u32;
            value.put(&mut message.body);
            board.write(&message);
        }
    }

    /// What is shown.
    #[must_use]
    pub fn get(&self) -> T {
        if let Some(board) = self.0.board.get().filter(|_| !self.0.own.get()) {
            let mut message = Message::empty();
            // A damaged message is passed over.
            if board.read(&mut message)
                && message.words().len() == T::LEN
                && let Ok(value) = T::get(message.words())
            {
                self.0.value.set(value);
            }
        }
        self.0.value.get()
    }
}

/// A shown value of any type.
pub trait AnyShown {
    /// From the process that sets it to the one that reads it.
    fn pass_on(&self, board: Rc<dyn Board>);
}

impl<T: Wire> AnyShown for Shown<T> {
    fn pass_on(&self, board: Rc<dyn Board>) {
        // A set-up is put on one link.
        drop(self.0.board.set(board));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::memory::MemoryBoard;

    #[test]
    fn what_one_process_sets_another_one_reads_and_what_is_no_value_is_no_news() {
        let (sets, reads) = (Shown::new((0.5_f64).to_bits()), Shown::new(7_u64));
        let slate = Rc::<MemoryBoard>::default();
        sets.pass_on(Rc::clone(&slate) as Rc<dyn Board>);
        reads.pass_on(Rc::clone(&slate) as Rc<dyn Board>);
        assert_eq!(reads.get(), 7);
        sets.set(11);
        assert_eq!((sets.get(), reads.get()), (11, 11));
        if let Some(message) = &mut *slate.0.borrow_mut() {
            message.header.len = 2;
            message.body[0] = 12;
        }
        assert_eq!((sets.get(), reads.get()), (11, 11));
    }
}
