//! The operator's panel: a page in a browser that shows a cell in 3D while it runs, and operates it.
//!
//! In: what the cell's console server shows, and what a person presses. Out: a page, and requests to the console server. The panel is a
//! process of its own and one more console: no process that moves robots speaks HTTP, none waits for the panel, and a cell that is
//! not asked for a panel has none of it. A run that is over, on the memory link or in a recording, is shown by the same page.
//!
//! The [`rules`] say who may do what and need no socket; with the feature `server` there is what answers browsers.
//!
//! ```
//! use core::time::Duration;
//! use mrroc_panel::rules::authority::Authority;
//!
//! let (mut authority, second) = (Authority::default(), Duration::from_secs(1));
//! authority.take(1, second)?;
//! assert!(authority.take(2, second).is_err());
//! # Ok::<(), mrroc_panel::rules::authority::NoAuthority>(())
//! ```

#![forbid(unsafe_code)]
#![allow(clippy::disallowed_methods, reason = "a console is no part of control")]

pub mod rules;

#[cfg(all(feature = "server", target_os = "linux"))]
mod beside;
#[cfg(all(feature = "server", target_os = "linux"))]
mod console_session;
#[cfg(all(feature = "server", target_os = "linux"))]
mod control;
#[cfg(all(feature = "server", target_os = "linux"))]
mod driver;
#[cfg(all(feature = "server", target_os = "linux"))]
mod events;
#[cfg(all(feature = "server", target_os = "linux"))]
mod meshes;
#[cfg(all(feature = "server", target_os = "linux"))]
mod now;
#[cfg(all(feature = "server", target_os = "linux"))]
mod operate;
#[cfg(all(feature = "server", target_os = "linux"))]
mod page;
#[cfg(all(feature = "server", target_os = "linux"))]
mod pages;
#[cfg(all(feature = "server", target_os = "linux"))]
mod panel;
#[cfg(all(feature = "server", target_os = "linux"))]
mod poses;
#[cfg(all(feature = "server", target_os = "linux"))]
mod readings;
#[cfg(all(feature = "server", target_os = "linux"))]
mod recording;
#[cfg(all(feature = "server", target_os = "linux"))]
mod run;
#[cfg(all(feature = "server", target_os = "linux"))]
mod run_history;
#[cfg(all(feature = "server", target_os = "linux"))]
mod secured;
#[cfg(all(feature = "server", target_os = "linux"))]
mod server;
#[cfg(all(feature = "server", target_os = "linux"))]
mod session;
#[cfg(all(test, feature = "server", target_os = "linux"))]
mod shown_tests;
#[cfg(all(feature = "server", target_os = "linux"))]
mod socket;
#[cfg(all(feature = "server", target_os = "linux"))]
mod standing;
#[cfg(all(feature = "server", target_os = "linux"))]
mod teaching;
#[cfg(all(test, feature = "server", target_os = "linux"))]
mod tests;
#[cfg(all(feature = "server", target_os = "linux"))]
mod values;

#[cfg(all(feature = "server", target_os = "linux"))]
pub use panel::InBrowser;
