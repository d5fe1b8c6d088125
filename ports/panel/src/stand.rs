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

/// How long a hold lasts here after its last renewal: shorter than at the cell, so that the cell hears of its end in time however long
/// the renewal was on its way.
const HELD: Duration = Duration::from_millis(LAPSE.as_millis() as u64 - 10);

/// Authority, and the hold of the page that has it.
#[derive(Default)]
pub struct Stand(Mutex<Held>);

#[derive(Default)]
struct Held {
    authority: Authority,
    hold: Option<Hold>,
}

/// What a page holds.
#[derive(Clone, Copy)]
struct Hold {
    renewal: Renewal,
    at: Duration,
    /// The robot that it jogs, if it jogs one.
    jogs: Option<Name>,
}

/// Why a hold is not renewed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotRenewed {
    /// It was let go, or not renewed in time.
    #[error("the hold is over: let go, and hold again")]
    Over,
    /// It was for another robot, or for none.
    #[error("a hold moves what it began with: let go, and hold again")]
    Another,
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

    /// The renewal of a hold of the page that has authority; of a new one, which it begins. A `jog` is a hold that moves one robot.
    ///
    /// # Errors
    /// [`NotRenewed`]
    pub fn renew(
        &self,
        begins: bool,
        jog: Option<(Name, JogOrder)>,
        now: Duration,
    ) -> Result<Button, NotRenewed> {
        let held = &mut self.held().hold;
        let jogs = jog.map(|(robot, _)| robot);
        let renewal = match *held {
            // Its number grows from hold to hold, also after the panel was started again.
            _ if begins => Renewal::first(monotonic() / 1_000_000),
            Some(hold) if now < hold.at + HELD && hold.jogs != jogs => return Err(NotRenewed::Another),
            Some(hold) if now < hold.at + HELD => hold.renewal.next().ok_or(NotRenewed::Over)?,
            Some(_) | None => return Err(NotRenewed::Over),
        };
        *held = Some(Hold { renewal, at: now, jogs });
        Ok(match jog {
            Some((robot, order)) => Button::Jog(renewal, robot, order),
            None => Button::Hold(renewal),
        })
    }

    /// Whether a page holds anything.
    pub fn holds(&self) -> bool {
        self.held().hold.is_some()
    }

    /// The page whose hold was not renewed in time, and what the desk is told.
    pub fn lapsed_hold(&self, now: Duration) -> Option<(Page, Button)> {
        let held = &mut *self.held();
        let hold = held.hold.take_if(|hold| now >= hold.at + HELD)?;
        Some((held.authority.holder()?, Button::LetGo(hold.renewal.hold())))
    }

    /// What the desk is told when a page no longer holds anything.
    pub fn release(&self) -> Option<Button> {
        self.held().hold.take().map(|hold| Button::LetGo(hold.renewal.hold()))
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

/// The machine's monotonic clock, which all processes of the cell go by \[ns\].
pub fn monotonic() -> u64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    u64::try_from(now.tv_sec).unwrap_or(0) * 1_000_000_000 + u64::try_from(now.tv_nsec).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: fn(u64) -> Duration = Duration::from_millis;

    #[test]
    fn fault_206_a_hold_that_was_not_renewed_in_time_or_whose_page_is_gone_is_over() {
        let stand = Stand::default();
        stand.take(1, MS(0)).expect("free");
        let Ok(Button::Hold(first)) = stand.renew(true, None, MS(0)) else { panic!("no hold") };
        let Ok(Button::Hold(second)) = stand.renew(false, None, MS(289)) else { panic!("no renewal") };
        assert_eq!((second.hold(), second.count()), (first.hold(), first.count() + 1));
        // The desk is told of its end 10 ms before the cell would end it.
        assert_eq!(stand.lapsed_hold(MS(578)), None);
        assert_eq!(stand.lapsed_hold(MS(579)), Some((1, Button::LetGo(first.hold()))));
        assert_eq!(stand.lapsed_hold(MS(580)), None);
        assert_eq!(stand.renew(false, None, MS(581)), Err(NotRenewed::Over));
        stand.renew(true, None, MS(700)).expect("a new one");
        // What the desk is told when the page is gone: that nobody holds, then that nobody operates.
        let told = stand.leave(1);
        assert!(matches!(told[..], [Request::Press(Button::LetGo(_)), Request::Release]), "{told:?}");
        assert!(stand.leave(1).is_empty() && stand.release().is_none());
    }

    #[test]
    fn fault_239_a_hold_that_names_another_robot_than_it_began_with_is_not_renewed() {
        let (stand, name) = (Stand::default(), |text| Name::new(text).expect("a name"));
        let order = JogOrder::read(&mut "world x 20%".split_whitespace()).expect("an order");
        let (left, right) = ((name("left"), order), (name("right"), order));
        stand.take(1, MS(0)).expect("free");
        stand.renew(true, Some(left), MS(0)).expect("begun");
        stand.renew(false, Some(left), MS(100)).expect("renewed");
        for other in [Some(right), None] {
            assert_eq!(stand.renew(false, other, MS(200)), Err(NotRenewed::Another));
        }
        // What renewed nothing keeps nothing alive.
        assert_eq!(stand.renew(false, Some(left), MS(400)), Err(NotRenewed::Over));
        stand.renew(true, Some(right), MS(500)).expect("another hold");
    }
}
