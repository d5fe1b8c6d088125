//! What happens to pages, and what is to be done for them then.

use mrroc_core::operator::{OnBehalf, Request};

use crate::console_session::CellSnapshot;
use crate::rules::authority::Page;
use crate::rules::request::PageRequest;

/// The number of a connection, among all that pages have made.
pub type Key = u64;

/// What a page says.
#[derive(Debug)]
pub enum PageEvent<'h> {
    /// A message.
    Text(&'h str),
    /// A ping, or its answer.
    Control,
    /// What is no text.
    Binary,
    /// That it goes; or it has gone.
    Closed,
    /// The connection has failed, or what came was no frame.
    Failed(String),
}

/// Whom an answer is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct To {
    pub key: Key,
    pub page: Page,
    /// The number that the page gave its request.
    pub number: u64,
}

/// What is to be done for pages.
pub enum Action {
    /// The console server is asked for something, for somebody who waits for the answer, or for nobody.
    Ask { request: Request, by: OnBehalf, to: Option<To> },
    /// Something is to be done with the files of poses, of a cell that showed this.
    Files { asked: PageRequest, shown: CellSnapshot, to: To },
    /// The terminal is told.
    Say(String),
}
