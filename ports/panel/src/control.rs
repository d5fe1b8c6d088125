//! Control of the cell: the page with authority, and what it holds.
//!
//! In: what pages do, and when, by the machine's monotonic clock. Out: requests that the console server gets for them, and when it is to be looked again.

use core::time::Duration;

use mrroc_core::fault::Name;
use mrroc_core::operator::button::Button;
use mrroc_core::operator::jog::JogOrder;
use mrroc_core::operator::{Renewal, Request};

use crate::rules::authority::{Authority, LAPSE, NoAuthority, Page};

/// How long a hold lasts here after its last renewal: shorter than at the cell, so that the cell hears of its end in time however long
/// the renewal was in transit.
const HELD: Duration = Duration::from_millis(LAPSE.as_millis() as u64 - 10);

/// Authority, and the hold of the page that has it.
#[derive(Debug, Default)]
pub struct Control {
    authority: Authority,
    hold: Option<Hold>,
}

/// What a page holds.
#[derive(Clone, Copy, Debug)]
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

impl Control {
    /// Who has authority.
    pub fn holder(&self) -> Option<Page> {
        self.authority.holder()
    }

    /// A page takes authority.
    ///
    /// # Errors
    /// [`NoAuthority::Another`]
    pub fn take(&mut self, page: Page, now: Duration) -> Result<(), NoAuthority> {
        self.authority.take(page, now)
    }

    /// A page is there.
    pub fn beat(&mut self, page: Page, now: Duration) {
        self.authority.beat(page, now);
    }

    /// Whether a page may operate the cell.
    ///
    /// # Errors
    /// [`NoAuthority`]
    pub fn check(&mut self, page: Page, now: Duration) -> Result<(), NoAuthority> {
        self.authority.check(page, now)
    }

    /// The renewal of a hold of the page that has authority; of a new one, which it begins. A `jog` is a hold that moves one robot.
    ///
    /// # Errors
    /// [`NotRenewed`]
    pub fn renew(
        &mut self,
        begins: bool,
        jog: Option<(Name, JogOrder)>,
        now: Duration,
    ) -> Result<Button, NotRenewed> {
        let jogs = jog.map(|(robot, _)| robot);
        let renewal = match self.hold {
            // Its number grows from hold to hold, also after the panel was started again.
            _ if begins => Renewal::first(u64::try_from(now.as_millis()).unwrap_or(u64::MAX)),
            Some(hold) if now < hold.at + HELD && hold.jogs != jogs => return Err(NotRenewed::Another),
            Some(hold) if now < hold.at + HELD => hold.renewal.next().ok_or(NotRenewed::Over)?,
            Some(_) | None => return Err(NotRenewed::Over),
        };
        self.hold = Some(Hold { renewal, at: now, jogs });
        Ok(match jog {
            Some((robot, order)) => Button::Jog(renewal, robot, order),
            None => Button::Hold(renewal),
        })
    }

    /// When a hold or authority lapses next, if nothing more is heard.
    pub fn lapses(&self) -> Option<Duration> {
        let hold = self.hold.map(|hold| hold.at + HELD);
        hold.into_iter().chain(self.authority.lapses()).min()
    }

    /// The page whose hold was not renewed in time, and what the console server is told.
    pub fn lapsed_hold(&mut self, now: Duration) -> Option<(Page, Button)> {
        let hold = self.hold.take_if(|hold| now >= hold.at + HELD)?;
        Some((self.authority.holder()?, Button::LetGo(hold.renewal.hold())))
    }

    /// What the console server is told when a page no longer holds anything.
    pub fn release(&mut self) -> Option<Button> {
        self.hold.take().map(|hold| Button::LetGo(hold.renewal.hold()))
    }

    /// What the console server is told when a page is gone or lets go of authority; nothing if it did not have it.
    pub fn leave(&mut self, page: Page) -> Vec<Request> {
        let had = self.authority.let_go(page);
        if had { self.left() } else { Vec::new() }
    }

    /// The page whose authority has lapsed by now, and what the console server is told.
    pub fn lapse(&mut self, now: Duration) -> Option<(Page, Vec<Request>)> {
        let lapsed = self.authority.lapse(now)?;
        Some((lapsed, self.left()))
    }

    fn left(&mut self) -> Vec<Request> {
        let released = self.release().map(Request::Press);
        released.into_iter().chain([Request::Release]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: fn(u64) -> Duration = Duration::from_millis;

    #[test]
    fn fault_206_a_hold_that_was_not_renewed_in_time_or_whose_page_is_gone_is_over() {
        let mut control = Control::default();
        control.take(1, MS(0)).expect("free");
        let Ok(Button::Hold(first)) = control.renew(true, None, MS(0)) else { panic!("no hold") };
        let Ok(Button::Hold(second)) = control.renew(false, None, MS(289)) else { panic!("no renewal") };
        assert_eq!((second.hold(), second.count()), (first.hold(), first.count() + 1));
        // The console server is told of its end 10 ms before the cell would end it.
        assert_eq!((control.lapses(), control.lapsed_hold(MS(578))), (Some(MS(300)), None));
        control.beat(1, MS(299));
        assert_eq!(control.lapses(), Some(MS(579)));
        assert_eq!(control.lapsed_hold(MS(579)), Some((1, Button::LetGo(first.hold()))));
        assert_eq!(control.lapsed_hold(MS(580)), None);
        assert_eq!(control.renew(false, None, MS(581)), Err(NotRenewed::Over));
        control.renew(true, None, MS(700)).expect("a new one");
        // What the console server is told when the page is gone: that nobody holds, then that nobody operates.
        let told = control.leave(1);
        assert!(matches!(told[..], [Request::Press(Button::LetGo(_)), Request::Release]), "{told:?}");
        assert!(control.leave(1).is_empty() && control.release().is_none());
    }

    #[test]
    fn fault_239_a_hold_that_names_another_robot_than_it_began_with_is_not_renewed() {
        let (mut control, name) = (Control::default(), |text| Name::new(text).expect("a name"));
        let order = JogOrder::read(&mut "world x 20%".split_whitespace()).expect("an order");
        let (left, right) = ((name("left"), order), (name("right"), order));
        control.take(1, MS(0)).expect("free");
        control.renew(true, Some(left), MS(0)).expect("begun");
        control.renew(false, Some(left), MS(100)).expect("renewed");
        for other in [Some(right), None] {
            assert_eq!(control.renew(false, other, MS(200)), Err(NotRenewed::Another));
        }
        // What renewed nothing keeps nothing alive.
        assert_eq!(control.renew(false, Some(left), MS(400)), Err(NotRenewed::Over));
        control.renew(true, Some(right), MS(500)).expect("another hold");
    }
}
