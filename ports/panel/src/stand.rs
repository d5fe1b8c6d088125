//! Who stands at the desk: the page with authority, and what it holds.
//!
//! In: what pages do. Out: requests that the desk gets for them.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use mrroc_core::fault::Name;
use mrroc_core::operator::Renewal;
use mrroc_core::operator::button::Button;
use mrroc_core::operator::jog::JogOrder;
use mrroc_processes::Request;

use crate::rules::authority::{Authority, LAPSE, NoAuthority, Page};

/// Authority, and the hold of the page that has it.
#[derive(Default)]
pub struct Stand(Mutex<Held>);

#[derive(Default)]
struct Held {
    authority: Authority,
    hold: Option<(Renewal, Duration)>,
}

impl Stand {
    fn held(&self) -> MutexGuard<'_, Held> {
        // It is valid whatever a thread that held it did.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Who has authority.
    pub fn holder(&self) -> Option<Page> {
        self.held().authority.holder()
    }

    /// A page takes authority.
    ///
    /// # Errors
    /// [`NoAuthority::Another`]
    pub fn take(&self, page: Page, now: Duration) -> Result<(), NoAuthority> {
        self.held().authority.take(page, now)
    }

    /// A page is there.
    pub fn beat(&self, page: Page, now: Duration) {
        self.held().authority.beat(page, now);
    }

    /// Whether a page may operate the cell.
    ///
    /// # Errors
    /// [`NoAuthority`]
    pub fn check(&self, page: Page, now: Duration) -> Result<(), NoAuthority> {
        self.held().authority.check(page, now)
    }

    /// The renewal of a hold of the page that has authority; of a new one, which it begins. `None` if the hold that it would renew
    /// is over.
    /// A `jog` is a hold that moves one robot.
    pub fn renew(&self, begins: bool, jog: Option<(Name, JogOrder)>, now: Duration) -> Option<Button> {
        let hold = &mut self.held().hold;
        let lasting = hold.filter(|(_, at)| now < *at + LAPSE).and_then(|(renewal, _)| renewal.next());
        // Its number grows from hold to hold, also after the panel was started again.
        let first = || Renewal::first(monotonic_millis());
        let renewal = if begins { Some(first()) } else { lasting };
        *hold = renewal.map(|renewal| (renewal, now));
        renewal.map(|renewal| match jog {
            Some((robot, order)) => Button::Jog(renewal, robot, order),
            None => Button::Hold(renewal),
        })
    }

    /// What the desk is told when a page no longer holds anything.
    pub fn release(&self) -> Option<Button> {
        self.held().hold.take().map(|(renewal, _)| Button::LetGo(renewal.hold()))
    }

    /// What the desk is told when a page is gone or lets go of authority; nothing if it did not have it.
    pub fn leave(&self, page: Page) -> Vec<Request> {
        let had = self.held().authority.let_go(page);
        if had { self.left() } else { Vec::new() }
    }

    /// The page whose authority has lapsed by now, and what the desk is told.
    pub fn lapse(&self, now: Duration) -> Option<(Page, Vec<Request>)> {
        let lapsed = self.held().authority.lapse(now)?;
        Some((lapsed, self.left()))
    }

    fn left(&self) -> Vec<Request> {
        let released = self.release().map(Request::Press);
        released.into_iter().chain([Request::Release]).collect()
    }
}

/// Milliseconds of a clock that only goes forward, since the machine started.
fn monotonic_millis() -> u64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    u64::try_from(now.tv_sec).unwrap_or(0) * 1000 + u64::try_from(now.tv_nsec).unwrap_or(0) / 1_000_000
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: fn(u64) -> Duration = Duration::from_millis;

    #[test]
    fn fault_206_a_hold_that_was_not_renewed_in_time_or_whose_page_is_gone_is_over() {
        let stand = Stand::default();
        stand.take(1, MS(0)).expect("free");
        let Some(Button::Hold(first)) = stand.renew(true, None, MS(0)) else { panic!("no hold") };
        let Some(Button::Hold(second)) = stand.renew(false, None, MS(299)) else { panic!("no renewal") };
        assert_eq!((second.hold(), second.count()), (first.hold(), first.count() + 1));
        assert_eq!(stand.renew(false, None, MS(599)), None);
        assert_eq!(stand.renew(false, None, MS(600)), None);
        stand.renew(true, None, MS(700)).expect("a new one");
        // What the desk is told when the page is gone: that nobody holds, then that nobody operates.
        let told = stand.leave(1);
        assert!(matches!(told[..], [Request::Press(Button::LetGo(_)), Request::Release]), "{told:?}");
        assert!(stand.leave(1).is_empty() && stand.release().is_none());
    }
}
