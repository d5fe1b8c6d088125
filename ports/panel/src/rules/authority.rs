//! Authority: the one page that operates the cell.
//!
//! In: pages that take it, let it go, say that they are there, or are gone. Out: who has it. It lapses [`LAPSE`] after its holder's
//! last sign of life, and never comes back by itself.

use core::time::Duration;

pub use mrroc_core::operator::LAPSE;

/// The number of a page, among all that have connected.
pub type Page = u64;

/// Why a page may not operate the cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoAuthority {
    /// Another page does.
    #[error("page {0} has control: it must let go of it first")]
    Another(Page),
    /// It has not taken authority, or has lost it.
    #[error("this page does not have control: take it first")]
    None,
}

/// Who has authority.
#[derive(Clone, Copy, Debug, Default)]
pub struct Authority {
    holder: Option<(Page, Duration)>,
}

impl Authority {
    /// Who has it.
    #[must_use]
    pub fn holder(&self) -> Option<Page> {
        self.holder.map(|(page, _)| page)
    }

    /// A page takes it at a time of a clock that only goes forward.
    ///
    /// # Errors
    /// [`NoAuthority::Another`]
    pub fn take(&mut self, page: Page, now: Duration) -> Result<(), NoAuthority> {
        self.lapse(now);
        match self.holder() {
            Some(other) if other != page => Err(NoAuthority::Another(other)),
            Some(_) | None => {
                self.holder = Some((page, now));
                Ok(())
            }
        }
    }

    /// A page says that it is there.
    pub fn beat(&mut self, page: Page, now: Duration) {
        self.lapse(now);
        if let Some((holder, at)) = &mut self.holder
            && *holder == page
        {
            *at = now;
        }
    }

    /// Whether a page may operate the cell at a time.
    ///
    /// # Errors
    /// [`NoAuthority`]
    pub fn check(&mut self, page: Page, now: Duration) -> Result<(), NoAuthority> {
        self.lapse(now);
        match self.holder() {
            Some(holder) if holder == page => Ok(()),
            Some(other) => Err(NoAuthority::Another(other)),
            None => Err(NoAuthority::None),
        }
    }

    /// A page lets go of it, or is gone; whether it had it.
    pub fn let_go(&mut self, page: Page) -> bool {
        let had = self.holder() == Some(page);
        if had {
            self.holder = None;
        }
        had
    }

    /// When it lapses, if its holder says nothing more.
    #[must_use]
    pub fn lapses(&self) -> Option<Duration> {
        self.holder.map(|(_, at)| at + LAPSE)
    }

    /// Takes it from a page that has said nothing for too long; which.
    pub fn lapse(&mut self, now: Duration) -> Option<Page> {
        let (page, _) = self.holder.filter(|(_, at)| now >= *at + LAPSE)?;
        self.holder = None;
        Some(page)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: fn(u64) -> Duration = Duration::from_millis;

    #[test]
    fn fault_202_one_page_has_authority_and_no_other_one_can_take_it() {
        let mut authority = Authority::default();
        assert_eq!(authority.check(1, MS(0)), Err(NoAuthority::None));
        assert_eq!(authority.take(1, MS(0)), Ok(()));
        assert_eq!(authority.take(2, MS(10)), Err(NoAuthority::Another(1)));
        assert_eq!(
            (authority.check(1, MS(20)), authority.check(2, MS(20))),
            (Ok(()), Err(NoAuthority::Another(1)))
        );
        // What the other page says keeps nothing alive and takes nothing away.
        authority.beat(2, MS(299));
        assert!(!authority.let_go(2));
        assert_eq!(authority.holder(), Some(1));
        assert!(authority.let_go(1));
        assert_eq!(authority.take(2, MS(300)), Ok(()));
    }

    #[test]
    fn fault_202_authority_lapses_three_hundred_milliseconds_after_the_last_sign_of_life_and_does_not_come_back()
     {
        let mut authority = Authority::default();
        authority.take(1, MS(0)).expect("nobody had it");
        for i in 1..=10 {
            authority.beat(1, MS(290 * i));
        }
        assert_eq!((authority.lapses(), authority.check(1, MS(3199))), (Some(MS(3200)), Ok(())));
        assert_eq!(authority.check(1, MS(3200)), Err(NoAuthority::None));
        // A late sign of life is none.
        authority.beat(1, MS(3201));
        assert_eq!(authority.check(1, MS(3202)), Err(NoAuthority::None));
        authority.take(2, MS(3300)).expect("it is free");
        assert_eq!((authority.lapse(MS(3599)), authority.lapse(MS(3600))), (None, Some(2)));
        assert_eq!(authority.holder(), None);
    }
}
