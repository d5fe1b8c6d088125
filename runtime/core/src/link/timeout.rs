//! How a process waits for answers: not for ever, and asking again.

use core::time::Duration;

use super::{Client, Closed, Nanos, Waiter};
pub use crate::safety::stopping::{missed_step_budget, together_budget};

/// How long a process waits for an answer.
#[derive(Clone, Copy, Debug)]
pub struct AnswerTimeout {
    /// The longest time for which an answer is awaited \[ns\].
    pub most: Nanos,
    /// The time after which a request without an answer is sent again \[ns\].
    pub again: Nanos,
}

impl AnswerTimeout {
    /// Until a lost peer is noticed, asking again in every step.
    pub fn of_step(step: Duration) -> AnswerTimeout {
        let again = step.as_nanos() as Nanos;
        AnswerTimeout { most: again * (u64::from(missed_step_budget(step)) + 1), again }
    }

    /// Begins to wait for answers to requests that are sent now.
    #[inline]
    pub fn begin(self, waiter: &dyn Waiter) -> Waiting {
        let now = waiter.now();
        Waiting { until: now + self.most, next: now + self.again, again: self.again.max(1) }
    }
}

/// A wait for answers to requests of one time.
#[derive(Clone, Copy, Debug)]
pub struct Waiting {
    until: Nanos,
    /// When the request is sent again, and after which time again \[ns\].
    next: Nanos,
    again: Nanos,
}

impl Waiting {
    /// The same, at most until `time` \[ns\].
    pub fn until(self, time: Nanos) -> Waiting {
        Waiting { until: self.until.min(time), ..self }
    }

    /// Waits for something to come, if there is time left; where it is due the request is sent again.
    ///
    /// # Errors
    /// [`Closed`] when the cell is closing.
    #[inline]
    pub fn goes_on(&mut self, client: &dyn Client, waiter: &dyn Waiter) -> Result<bool, Closed> {
        let now = waiter.now();
        if now >= self.until {
            return Ok(false);
        }
        if now >= self.next {
            client.send_again();
            self.next += (now - self.next) / self.again * self.again + self.again;
        }
        waiter.wait_for_reply(client, Some(self.next.min(self.until)))?;
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use core::cell::{Cell, RefCell};
    use std::rc::Rc;

    use super::*;
    use crate::link::message::Message;

    /// Wakes when it is to, or so much later.
    struct Sleeps(Rc<Cell<Nanos>>, Nanos);

    impl Waiter for Sleeps {
        fn now(&self) -> Nanos {
            self.0.get()
        }
        fn wait(&self, deadline: Option<Nanos>) -> Result<(), Closed> {
            self.0.set(deadline.ok_or(Closed)? + self.1);
            Ok(())
        }
    }

    /// When it was asked again.
    struct Asked(Rc<Cell<Nanos>>, RefCell<Vec<Nanos>>);

    impl Client for Asked {
        fn send(&self, _: &Message) {}
        fn send_again(&self) {
            self.1.borrow_mut().push(self.0.get());
        }
        fn receive(&self, _: &mut Message) -> bool {
            false
        }
    }

    fn asked(late: Nanos) -> (Vec<Nanos>, Nanos) {
        let now = Rc::new(Cell::new(500));
        let (waiter, client) = (Sleeps(Rc::clone(&now), late), Asked(Rc::clone(&now), RefCell::default()));
        let mut waiting = AnswerTimeout { most: 3500, again: 1000 }.begin(&waiter);
        while waiting.goes_on(&client, &waiter).expect("open") {
            assert!(now.get() < 10_000, "for ever");
        }
        (client.1.take(), now.get())
    }

    #[test]
    fn an_answer_is_asked_for_again_after_each_time_without_one_until_the_timeout_is_over() {
        assert_eq!(asked(0), (vec![1500, 2500, 3500], 4000));
        // Woken late it asks once for the times that are over, and goes on with those to come.
        assert_eq!(asked(1200), (vec![2700], 4700));
        assert_eq!(asked(700), (vec![2200, 3200], 4200));
    }
}
