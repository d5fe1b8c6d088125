//! What a page may ask for, and when.
//!
//! In: a message of a page that was let in, and the time. Out: requests to the console server; or why not.

use core::time::Duration;

use mrroc_core::operator::{Answer, OnBehalf, Request};

use crate::events::Key;
use crate::pages::Pages;
use crate::rules::request::{Message, PageRequest, Stamp};
use crate::session::DoesNotRead;

/// Requests of pages that may wait for files.
const FILES: usize = 16;

impl Pages {
    /// Does what a page asks for, or says why not.
    ///
    /// # Errors
    /// [`DoesNotRead`]
    pub(crate) fn handle(
        &mut self,
        key: Key,
        by: OnBehalf,
        now: Duration,
        message: Message,
    ) -> Result<(), DoesNotRead> {
        let Message { number, asked } = message;
        if self.history.is_some() {
            return self.replay(key, number, &asked);
        }
        match self.begin_to(key, by, now, number, asked) {
            Ok(Some(told)) => self.answer(key, number, &Answer::Done(told.to_owned())),
            Ok(None) => Ok(()),
            Err(why) => self.answer(key, number, &Answer::Refused(why)),
        }
    }

    /// Shows a moment of a run that is over.
    fn replay(&mut self, key: Key, number: u64, asked: &PageRequest) -> Result<(), DoesNotRead> {
        let Some(history) = &self.history else { return Ok(()) };
        let why = match asked {
            PageRequest::Frame(at, minute) => match history.at(*at) {
                Some(now) => {
                    let looks = &self.scene.looks;
                    let mut state = looks.state(now);
                    if *minute {
                        state["minute"] = history.minute(*at).map(|now| looks.plotted(now)).collect();
                    }
                    return self.tell(key, state.to_string().into());
                }
                None => "nothing was seen of this run",
            },
            PageRequest::Beat => return Ok(()),
            _ => "the run is over: there is nothing to operate",
        };
        self.answer(key, number, &Answer::Refused(why.to_owned()))
    }

    /// Begins to do what a page asks for of a cell that runs. What it is told at once, if that is all; or why not.
    fn begin_to(
        &mut self,
        key: Key,
        by: OnBehalf,
        now: Duration,
        number: u64,
        asked: PageRequest,
    ) -> Result<Option<&'static str>, String> {
        let page = by.page;
        match asked {
            PageRequest::Beat => self.control.beat(page, now),
            PageRequest::Take => {
                self.control.take(page, now).map_err(|why| why.to_string())?;
                self.ask(key, by, number, Request::Take);
            }
            PageRequest::Release => {
                let left = self.control.leave(page);
                self.tell_console_server(by, left);
                self.note(&format!("page {page}: let go of control"));
                return Ok(Some("nobody has control"));
            }
            PageRequest::Press(button, stamp) => {
                self.may_operate(by, now, stamp)?;
                self.ask(key, by, number, Request::Press(button));
            }
            PageRequest::Hold(begins, jog, stamp) => {
                self.may_operate(by, now, stamp)?;
                let button = self.control.renew(begins, jog, now).map_err(|why| why.to_string())?;
                self.ask(key, by, number, Request::Press(button));
            }
            PageRequest::LetGo => {
                let may = self.control.check(page, now);
                match may.ok().and_then(|()| self.control.release()) {
                    Some(button) => {
                        self.ask(key, by, number, Request::Press(button));
                    }
                    None => return Ok(Some("nothing is held")),
                }
            }
            PageRequest::Teach(.., stamp) => {
                self.may_operate(by, now, stamp)?;
                self.use_files(key, by, number, asked)?;
            }
            PageRequest::Rename(..) | PageRequest::Forget(..) => {
                self.control.check(page, now).map_err(|why| why.to_string())?;
                self.use_files(key, by, number, asked)?;
            }
            PageRequest::ToolPath(..) => self.use_files(key, by, number, asked)?,
            PageRequest::Token(_) | PageRequest::Frame(..) => {
                return Err("this is a cell that runs, and the page is let in already".to_owned());
            }
            // It is taken before.
            PageRequest::Stop => {}
        }
        Ok(None)
    }

    /// Whether a page may operate the cell, as it is now, by what it saw of it.
    fn may_operate(&mut self, by: OnBehalf, now: Duration, stamp: Stamp) -> Result<(), String> {
        self.control.check(by.page, now).map_err(|why| why.to_string())?;
        match self.scene.shown.get().stamp {
            Some((newest, period)) => stamp.check(newest, period).map_err(|old| old.to_string()),
            None => Err("the cell has not been seen yet".to_owned()),
        }
    }

    fn use_files(&mut self, key: Key, by: OnBehalf, number: u64, asked: PageRequest) -> Result<(), String> {
        if self.files >= FILES {
            return Err("the files of the poses do not answer: ask again".to_owned());
        }
        self.begin_work(key, by.page, number, asked);
        Ok(())
    }
}
