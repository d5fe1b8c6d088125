//! What drives the [pages](crate::pages) of a panel: the machine's clock, the console server of the cell, and the files of poses.
//!
//! In: what connections hear, and what the console server shows and answers. Out: requests to the console server, work with files, sentences at the terminal, and news for
//! connections.

use std::net::SocketAddr;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use mrroc_core::console::complain;
use mrroc_core::operator::{Answer, Request};
use tokio::sync::{oneshot, watch};
use tokio::time::Instant;

use crate::console_session::{CellSnapshot, RequestSink};
use crate::events::{Action, Key, To};
use crate::now::Appearance;
use crate::pages::Pages;
use crate::poses::Poses;
use crate::rules::origin::OriginPolicy;
use crate::rules::token::Token;
use crate::run_history::RunHistory;
use crate::teaching;

/// How long is waited at most until it is looked whether a page has said nothing for too long.
const LOOKS: Duration = Duration::from_millis(20);

/// What a panel shows.
pub enum Source {
    /// A cell that runs: where to ask, and what it does.
    Running(Box<dyn RequestSink>, watch::Receiver<CellSnapshot>),
    /// A run that is over.
    Over(Box<RunHistory>),
}

/// The pages of a panel, and what stands around them: the clock, the console server, and the files of poses.
pub struct Panel {
    state: Mutex<Shared>,
    console: Option<Box<dyn RequestSink>>,
    looks: Arc<Appearance>,
    poses: Option<Arc<Poses>>,
    /// Tells connections that their pages have something new to be told.
    news: watch::Sender<()>,
    pub origins: OriginPolicy,
    since: Instant,
    /// The machine's monotonic clock when the panel began.
    began: Duration,
}

struct Shared {
    pages: Pages,
    shown: Option<watch::Receiver<CellSnapshot>>,
}

impl Panel {
    /// Of a source, at an address, known by a token.
    #[must_use]
    pub fn new(source: Source, looks: Arc<Appearance>, token: Token, address: SocketAddr) -> Panel {
        let (console, shown, history) = match source {
            Source::Running(console, mut shown) => {
                shown.mark_changed();
                (Some(console), Some(shown), None)
            }
            Source::Over(history) => (None, None, Some(history)),
        };
        let pages = Pages::new(Arc::clone(&looks), token, history);
        Panel {
            state: Mutex::new(Shared { pages, shown }),
            console,
            looks,
            poses: None,
            news: watch::Sender::new(()),
            origins: OriginPolicy::at(address),
            // First of the two, so that nothing is said to have been heard later than it was.
            began: monotonic(),
            since: Instant::now(),
        }
    }

    /// The same, which teaches poses beside the file of the cell.
    #[must_use]
    pub fn teaching(mut self, cell: &Path) -> Panel {
        let poses = Poses::of(cell);
        self.state().pages.teach(teaching::taught(&poses, &self.looks));
        self.poses = Some(Arc::new(poses));
        self
    }

    fn state(&self) -> MutexGuard<'_, Shared> {
        // It is valid whatever a thread that held it did.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The machine's monotonic clock.
    fn now(&self) -> Duration {
        self.began + self.since.elapsed()
    }

    /// Waits until a time of that clock; for ever, if there is none.
    pub async fn wait(&self, until: Option<Duration>) {
        match until {
            Some(until) => tokio::time::sleep_until(self.since + until.saturating_sub(self.began)).await,
            None => std::future::pending().await,
        }
    }

    /// Whether there is news since it was asked last.
    pub fn news(&self) -> watch::Receiver<()> {
        self.news.subscribe()
    }

    /// Changes something of its pages, at the time that it is now, and does what is to be done then.
    pub fn update<T>(self: &Arc<Self>, change: impl FnOnce(&mut Pages, Duration) -> T) -> T {
        let (changed, actions, has_news) = {
            let Shared { pages, shown } = &mut *self.state();
            if let Some(shown) = shown {
                let newest = shown.borrow_and_update();
                if newest.has_changed() {
                    pages.show(newest.clone());
                }
            }
            let changed = change(pages, self.now());
            (changed, pages.actions(), pages.has_news())
        };
        actions.into_iter().for_each(|action| self.act(action));
        if has_news {
            self.news.send_replace(());
        }
        changed
    }

    fn act(self: &Arc<Self>, action: Action) {
        match action {
            Action::Say(text) => complain(&format!("panel: {text}")),
            Action::Ask { request, by, to } => {
                let answered = self.console.as_ref().map(|console| console.ask(request, by));
                if let Some((to, answered)) = to.zip(answered) {
                    self.tell(to, request, answered);
                }
            }
            Action::Files { asked, shown, to } => {
                let (panel, poses, looks) = (Arc::clone(self), self.poses.clone(), Arc::clone(&self.looks));
                tokio::spawn(async move {
                    // Files may take their time.
                    let work = move || teaching::carry_out(poses.as_deref(), &looks, &asked, &shown);
                    let done = tokio::task::spawn_blocking(work).await;
                    let (outcome, taught) =
                        done.unwrap_or_else(|_| (Err("the panel is ending".to_owned()), None));
                    panel.update(|pages, _| pages.worked(to, outcome, taught));
                });
            }
        }
    }

    /// Tells a page what the console server answers, when it does.
    fn tell(self: &Arc<Self>, to: To, request: Request, answered: oneshot::Receiver<Answer>) {
        let panel = Arc::clone(self);
        tokio::spawn(async move {
            let answer = answered.await.ok();
            panel.update(|pages, _| pages.answered(to, &request, answer));
        });
    }
}

/// The machine's monotonic clock, which all processes of the cell go by.
fn monotonic() -> Duration {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    Duration::new(u64::try_from(now.tv_sec).unwrap_or(0), u32::try_from(now.tv_nsec).unwrap_or(0))
}

/// Shows pages what the cell does, and takes control from those that say nothing for too long, again and again.
pub async fn look_after(panel: Arc<Panel>) {
    let mut shown = panel.state().shown.clone();
    loop {
        let (lapses, now) = panel.update(|pages, now| (pages.look(now), now));
        let until = lapses.into_iter().chain([now + LOOKS]).min();
        let is_over = tokio::select! {
            () = panel.wait(until) => false,
            changed = changed(shown.as_mut()) => changed.is_err(),
        };
        if is_over {
            shown = None;
        }
    }
}

async fn changed(shown: Option<&mut watch::Receiver<CellSnapshot>>) -> Result<(), watch::error::RecvError> {
    match shown {
        Some(shown) => shown.changed().await,
        None => std::future::pending().await,
    }
}

/// The place of a page, until this is dropped.
pub struct Place {
    pub panel: Arc<Panel>,
    pub key: Key,
}

impl Drop for Place {
    fn drop(&mut self) {
        self.panel.state().pages.forget(self.key);
    }
}
