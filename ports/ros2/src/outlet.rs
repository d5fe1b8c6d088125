//! Where messages go: to other nodes, or into a bag.
//!
//! In: the same messages of the same topics for both. So a bag of a recording has what nodes would have heard.

use mrroc_core::console::complain;

use crate::messages::RosType;

/// Whether who comes later gets the last message of a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Durability {
    /// No: who is there gets it.
    Volatile,
    /// Yes.
    TransientLocal,
}

/// Where topics are opened.
pub trait Outlet {
    /// A topic of one type of messages.
    type Topic<M: RosType>: Put<M>;

    /// The name of the node whose topics they are.
    fn node(&self) -> &str;

    /// Now \[ns since 1970\].
    fn now(&self) -> u64;

    /// Tells what topics lack.
    fn warn(&self, what: &str) {
        complain(what);
    }

    /// A topic.
    ///
    /// # Errors
    /// Why there is none.
    fn topic<M: RosType>(&mut self, name: &str, durability: Durability) -> Result<Self::Topic<M>, String>;

    /// The name of a topic of the node itself.
    fn own(&self, topic: &str) -> String {
        format!("/{}/{topic}", self.node())
    }
}

/// Why there is no topic of a name that another one has.
pub fn twice(name: &str) -> String {
    format!("topic {name}: it would be there twice\n help: rename a robot, a signal or a sensor")
}

/// A topic that takes messages.
pub trait Put<M> {
    /// Takes one, or drops it: what becomes of it is not the concern of who shows it.
    fn put(&self, message: M);
}
