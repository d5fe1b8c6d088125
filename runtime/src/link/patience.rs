//! How a process waits for answers: not for ever, and asking again.

use super::{Client, Closed, Nanos, Waiter};

/// How long an answer may take, and after which time without one it is asked for again \[ns\].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patience {
    pub most: Nanos,
    pub again: Nanos,
}

impl Patience {
    /// Begins to wait for answers to requests that are sent now.
    pub fn begin(self, waiter: &dyn Waiter) -> Waiting {
        let now = waiter.now();
        Waiting { until: now + self.most, next: now + self.again, again: self.again.max(1) }
    }
}

/// A wait for answers to requests of one time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Waiting {
    until: Nanos,
    /// When the request is sent again, and after which time again \[ns\].
    next: Nanos,
    again: Nanos,
}

impl Waiting {
    /// Waits for something to come, if there is time left; where it is due the request is sent again.
    ///
    /// # Errors
    /// [`Closed`] when the cell is closing.
    pub fn goes_on(&mut self, client: &dyn Client, waiter: &dyn Waiter) -> Result<bool, Closed> {
        let now = waiter.now();
        if now >= self.until {
            return Ok(false);
        }
        if now >= self.next {
            client.send_again();
            self.next += (now - self.next) / self.again * self.again + self.again;
        }
        waiter.wait(Some(self.next.min(self.until)))?;
        Ok(true)
    }
}
